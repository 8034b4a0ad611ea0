//! The oracle at the ends of what it takes: weights over 1e-12 to 1e12, degrees to 25, coordinates that are far off the
//! origin and features that are small, long and thin domains, knot spans of one ulp.
//!
//! Truth by construction. A patch with its control points on a rectangle's grid lies in the rectangle, for weights are
//! positive; where the four borders run through the rectangle's sides its image is all of it, as a continuous map of a square
//! that takes the border round the border once misses no point inside. So weights and knots may be as
//! hostile as one likes, and the distance is still that to the rectangle. A curve times a positive polynomial, in
//! homogeneous coordinates, is the same curve at a higher degree.

use crate::scene::stress::binomials;
use crate::scene::{Random, bezier, brep, dyadic, patch, plane};
use feeler::numeric::Dyadic;
use feeler::nurbs::{Curve2, NurbsCurve, NurbsSurface, Surface};
use feeler::query::LineKind;
use feeler::trim::Side;
use feeler_oracle::second::{Bound, Second, TrimmedRegion, derivative_roots};
use feeler_oracle::{DistanceStatus, Oracle, TruthEnclosure};
use nalgebra::{Vector3, Vector4};
use std::time::Instant;

/// What an enclosure may be wide, as a part of the model's size: 2^-100.
const WIDTH: f64 = 7.888_609_052_210_118e-31;

/// Knots of a Bezier piece of this degree over `[from, to]`.
fn bezier_knots(degree: usize, from: f64, to: f64) -> Vec<f64> {
    [vec![from; degree + 1], vec![to; degree + 1]].concat()
}

/// A rectangle `o + x a + y b` with x from 0 to `sides[0]`, y from 0 to `sides[1]`, where a = (2, 1, 2), b = (1, 2, -2) and
/// the normal (2, -2, -1) have length 3 and are orthogonal.
struct Rectangle {
    origin: [f64; 3],
    sides: [f64; 2],
}

const FRAME: [[f64; 3]; 3] = [[2.0, 1.0, 2.0], [1.0, 2.0, -2.0], [2.0, -2.0, -1.0]];

impl Rectangle {
    /// The point with these coordinates along the frame, which must be exact.
    fn point(&self, at: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| {
            let exact = (0..3).fold(dyadic(self.origin[k]), |sum, i| {
                &sum + &(&dyadic(at[i]) * &dyadic(FRAME[i][k]))
            });
            let x = exact.approximate();
            assert_eq!(dyadic(x), exact, "not exact in f64");
            x
        })
    }

    fn size(&self) -> f64 {
        3.0 * self.sides[0].hypot(self.sides[1])
    }

    /// The square of the distance of the point with these coordinates.
    fn square(&self, at: [f64; 3]) -> Dyadic {
        let off = |x: f64, side: f64| {
            let (below, above) = (-&dyadic(x), &dyadic(x) - &dyadic(side));
            if below.signum() > 0 {
                below
            } else if above.signum() > 0 {
                above
            } else {
                Dyadic::ZERO
            }
        };
        let (x, y) = (off(at[0], self.sides[0]), off(at[1], self.sides[1]));
        let z = dyadic(at[2]);
        let sum = &(&(&x * &x) + &(&y * &y)) + &(&z * &z);
        &sum * &dyadic(9.0)
    }

    /// A spline surface that covers it: control points at these parts of the sides, weights powers of two.
    fn surface(
        &self,
        degrees: [usize; 2],
        parts: [&[f64]; 2],
        weight: impl Fn(usize, usize) -> f64,
        knots: [Vec<f64>; 2],
    ) -> Surface {
        let mut net = Vec::new();
        for (i, x) in parts[0].iter().enumerate() {
            for (j, y) in parts[1].iter().enumerate() {
                let w = weight(i, j);
                let p = self.point([x * self.sides[0], y * self.sides[1], 0.0]);
                net.push(Vector4::new(w * p[0], w * p[1], w * p[2], w));
            }
        }
        let counts = [parts[0].len(), parts[1].len()];
        Surface::Nurbs(NurbsSurface::new(degrees, counts, net, knots).unwrap())
    }

    /// Points above the inside, beside a side, off a corner; near and far; with coordinates that are exact at `unit`.
    fn queries(&self, g: &mut Random, unit: f64) -> Vec<[f64; 3]> {
        let [a, b] = self.sides;
        let mut round = |lo: f64, hi: f64| (g.range(lo, hi) / unit).round() * unit;
        // Within the rectangle after rounding.
        let (x, y) = ([0.125 * a, 0.875 * a], [0.125 * b, 0.875 * b]);
        vec![
            [round(x[0], x[1]), round(y[0], y[1]), round(0.0, b)],
            [round(x[0], x[1]), round(y[0], y[1]), unit],
            [round(x[0], x[1]), round(y[0], y[1]), 0.0],
            [round(x[0], x[1]), round(b, 2.0 * b), round(-b, b)],
            [round(-a, 0.0), round(y[0], y[1]), unit],
            [round(a, 2.0 * a), round(-b, 0.0), round(-b, b)],
            [round(a, 2.0 * a), round(-b, 0.0), 0.0],
        ]
    }
}

/// `n` equal steps from 0 to 1, to multiples of 2^-bits.
fn even(n: usize, bits: i32) -> Vec<f64> {
    let one = 2f64.powi(bits);
    (0..=n)
        .map(|i| (i as f64 / n as f64 * one).round() / one)
        .collect()
}

fn power(e: f64) -> f64 {
    2f64.powi(e.round() as i32)
}

/// Weights of a net of p + 1 by q + 1: powers of two from 2^-w to 2^w, at random.
fn weights(g: &mut Random, count: usize, w: f64) -> Vec<f64> {
    (0..count).map(|_| power(g.range(-w, w))).collect()
}

/// What a group of queries came to.
#[derive(Default)]
struct Measured {
    times: Vec<f64>,
    widest: f64,
    wide: Vec<String>,
}

impl Measured {
    fn add(&mut self, start: Instant, e: &TruthEnclosure, size: f64, what: &str) {
        let time = start.elapsed().as_secs_f64() * 1e3;
        self.times.push(time);
        let width = e.width().approximate() / size;
        self.widest = self.widest.max(width);
        if width > WIDTH {
            self.wide
                .push(format!("{what}: {time:.1} ms, {width:e} of the size"));
        }
    }

    #[track_caller]
    fn done(mut self, what: &str) {
        self.times.sort_by(f64::total_cmp);
        let at = |part: f64| self.times[((self.times.len() - 1) as f64 * part) as usize];
        println!(
            "{what}: {} queries, median {:.1} ms, p99 {:.1} ms, widest {:e} of the size",
            self.times.len(),
            at(0.5),
            at(0.99),
            self.widest,
        );
        assert!(self.wide.is_empty(), "{what}: {:#?}", self.wide);
    }
}

#[track_caller]
fn assert_root(e: &TruthEnclosure, square: &Dyadic) {
    assert!(e.lo.signum() >= 0, "{e:?}");
    assert!(
        &e.lo * &e.lo <= *square,
        "{e:?} is above the root of {square:?}"
    );
    assert!(
        *square <= &e.hi * &e.hi,
        "{e:?} is below the root of {square:?}"
    );
}

#[track_caller]
fn assert_meet(e: &TruthEnclosure, other: &Bound) {
    let below = other.hi.as_ref().is_some_and(|hi| *hi < e.lo);
    assert!(!below && other.lo <= e.hi, "{e:?} {other:?}");
}

/// Distances and half-spaces of a surface that covers a rectangle.
fn check(r: &Rectangle, surface: Surface, unit: f64, m: &mut Measured, what: &str) {
    let b = brep(surface, None);
    let o = Oracle::new(&[&b]).unwrap();
    let mut g = Random(5);
    for (k, at) in r.queries(&mut g, unit).into_iter().enumerate() {
        let q = r.point(at);
        let start = Instant::now();
        let t = o.distance(q, None).unwrap().unwrap();
        m.add(
            start,
            &t.enclosure,
            r.size(),
            &format!("{what}, distance {k}"),
        );
        assert_root(&t.enclosure, &r.square(at));
        // The last four are nearest to the border.
        let never = if k < 3 {
            DistanceStatus::EdgeOrCorner
        } else {
            DistanceStatus::Regular
        };
        assert_ne!(t.status, never, "{what}, distance {k}");
    }
    // Normals that see a corner, a side and the whole.
    for n in [[1.0, 2.0, 2.0], [2.0, 1.0, 2.0], [2.0, -2.0, -1.0]] {
        let start = Instant::now();
        let t = o.half_space(n, 0.25, None).unwrap().unwrap();
        m.add(
            start,
            &t.enclosure,
            r.size(),
            &format!("{what}, half-space {n:?}"),
        );
        let corners = [0.0, 1.0]
            .into_iter()
            .flat_map(|x| [0.0, 1.0].map(|y| r.point([x * r.sides[0], y * r.sides[1], 0.0])));
        let least = corners
            .map(|p| (0..3).fold(-&dyadic(0.25), |s, k| &s + &(&dyadic(n[k]) * &dyadic(p[k]))))
            .min()
            .unwrap();
        assert!(
            t.enclosure.lo <= least && least <= t.enclosure.hi,
            "{what} {n:?}: {t:?}"
        );
    }
}

const PLAIN: Rectangle = Rectangle {
    origin: [0.5, -2.0, 1.0],
    sides: [1.0, 2.0],
};
/// Coordinates of [`PLAIN`]'s queries are multiples of it.
const UNIT: f64 = 1.0 / (1 << 20) as f64;

/// A Bezier patch that covers [`PLAIN`].
fn plain(p: usize, q: usize, weight: impl Fn(usize, usize) -> f64) -> Surface {
    let knots = [bezier_knots(p, 0.0, 1.0), bezier_knots(q, 0.0, 1.0)];
    PLAIN.surface([p, q], [&even(p, 6), &even(q, 6)], weight, knots)
}

#[test]
fn far_weights() {
    let mut g = Random(1);
    let mut m = Measured::default();
    for (p, q) in [(1, 1), (2, 2), (3, 3), (5, 4)] {
        // The same rectangle run by (a t / (1 - t + a t)): one end 2^80 heavier than the other.
        let step = (80.0 / p as f64).floor();
        let s = plain(p, q, |i, _| power(step * i as f64 - 40.0));
        check(&PLAIN, s, UNIT, &mut m, &format!("{p}x{q} from end to end"));
        let w = weights(&mut g, (p + 1) * (q + 1), 40.0);
        let s = plain(p, q, |i, j| w[i * (q + 1) + j]);
        check(&PLAIN, s, UNIT, &mut m, &format!("{p}x{q} at random"));
    }
    m.done("weights 1e-12 to 1e12");
}

#[test]
fn high_degrees() {
    let mut g = Random(2);
    let mut m = Measured::default();
    for (p, q, far) in [
        (25, 1, 0.0),
        (1, 25, 40.0),
        (12, 11, 0.0),
        (25, 3, 40.0),
        (25, 25, 0.0),
        (25, 25, 40.0),
    ] {
        let w = weights(&mut g, (p + 1) * (q + 1), far);
        let s = plain(p, q, |i, j| w[i * (q + 1) + j]);
        check(
            &PLAIN,
            s,
            UNIT,
            &mut m,
            &format!("{p}x{q}, weights 2^+-{far}"),
        );
    }
    m.done("degrees to 25");
}

#[test]
fn far_off_the_origin() {
    // Sides of 8 and 16 ulps of coordinates of 2^30.
    let unit = 2f64.powi(-22);
    let mut m = Measured::default();
    let mut g = Random(3);
    for (p, q, far) in [(1, 1, 0.0), (3, 3, 0.0), (3, 2, 40.0)] {
        let at = 2f64.powi(30);
        let r = Rectangle {
            origin: [at, -at, at],
            sides: [8.0 * unit, 16.0 * unit],
        };
        let knots = [bezier_knots(p, 0.0, 1.0), bezier_knots(q, 0.0, 1.0)];
        let w = weights(&mut g, (p + 1) * (q + 1), far);
        let s = r.surface(
            [p, q],
            [&even(p, 3), &even(q, 3)],
            |i, j| w[i * (q + 1) + j],
            knots,
        );
        check(&r, s, unit, &mut m, &format!("{p}x{q}, weights 2^+-{far}"));
    }
    m.done("features of 1e-6 at 1e9");
}

/// From 0 to 2 `x`, with `x` and its next three neighbours between.
fn ulp_knots(degree: usize, x: f64) -> Vec<f64> {
    let near = std::iter::successors(Some(x), |x| Some(x.next_up())).take(4);
    [
        vec![0.0; degree + 1],
        near.collect(),
        vec![2.0 * x; degree + 1],
    ]
    .concat()
}

#[test]
fn spans_of_one_ulp_and_long_domains() {
    let mut g = Random(4);
    let mut m = Measured::default();
    for (p, q, far) in [(1, 1, 0.0), (2, 3, 0.0), (3, 3, 40.0)] {
        let knots = [ulp_knots(p, 5e-7), ulp_knots(q, 5e5)];
        let (x, y) = (even(p + 4, 6), even(q + 4, 6));
        let w = weights(&mut g, x.len() * y.len(), far);
        let n = y.len();
        let s = PLAIN.surface([p, q], [&x, &y], |i, j| w[i * n + j], knots);
        check(
            &PLAIN,
            s,
            UNIT,
            &mut m,
            &format!("{p}x{q}, weights 2^+-{far}"),
        );
    }
    m.done("spans of one ulp, domains of 1e-6 by 1e6");
}

/// The quarter of the circle of radius r from (r, 0) to (0, r), raised to degree n and run so that weight i has the
/// factor 2^(step i): homogeneous x, y, w, exact.
fn quarter(n: usize, r: f64, step: f64) -> Vec<[f64; 3]> {
    let row = binomials(n);
    let gcd = |mut a: i128, mut b: i128| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let common = row.iter().fold(1, |l, c| l / gcd(l, *c) * c);
    let raise = binomials(n - 2);
    // 1 - t^2, 2 t, 1 + t^2: Bernstein coefficients times binomials.
    let parts: [[i128; 3]; 3] = [[1, 2, 0], [0, 2, 2], [1, 2, 2]];
    (0..=n)
        .map(|k| {
            let scale = power(step * (k as f64 - (n / 2) as f64));
            parts.map(|c| {
                let sum: i128 = (0..3)
                    .filter(|i| *i <= k && k - i <= n - 2)
                    .map(|i| c[i] * raise[k - i])
                    .sum();
                (sum * (common / row[k])) as f64 * scale
            })
        })
        .map(|[x, y, w]| [x * r, y * r, w])
        .collect()
}

#[test]
fn cylinders_of_high_degree() {
    let mut m = Measured::default();
    for (p, q, step) in [(2, 1, 40.0), (9, 2, 9.0), (25, 1, 3.0), (25, 25, 0.0)] {
        // Along z from 0 to 2; radius 5.
        let z = even(q, 6);
        let arc = quarter(p, 5.0, step);
        let net = arc
            .iter()
            .flat_map(|[x, y, w]| z.iter().map(move |z| [*x, *y, 2.0 * z * w, *w]))
            .collect();
        let b = brep(patch(p, q, net), None);
        let o = Oracle::new(&[&b]).unwrap();
        let second = Second::new(&[&b]);
        // On the ray through (3, 4), and beside; all lengths exact. The distance.
        for (k, (at, truth)) in [
            ([1.5, 2.0, 0.75], 2.5),
            ([6.0, 8.0, 0.75], 5.0),
            ([3.0, 4.0, 1.25], 0.0),
            ([3.0 - 0.75, 4.0 - 1.0, 2.0 + 3.0], 3.25),
            // From the axis all of a circle is equally near.
            ([0.0, 0.0, 1.0], 5.0),
        ]
        .into_iter()
        .enumerate()
        {
            let what = format!("{p}x{q}, distance {k}");
            let start = Instant::now();
            let t = o.distance(at, None).unwrap().unwrap();
            m.add(start, &t.enclosure, 8.0, &what);
            assert_root(&t.enclosure, &dyadic(truth * truth));
            if p < 25 {
                assert_meet(&t.enclosure, &second.distance(at).unwrap());
            }
        }
        // x >= h and so on: the cylinder's least 0.6 x + 0.8 y is at an end of the arc.
        let start = Instant::now();
        let t = o
            .half_space([-0.75, -1.0, 0.0], 0.5, None)
            .unwrap()
            .unwrap();
        m.add(start, &t.enclosure, 8.0, &format!("{p}x{q}, half-space"));
        let least = dyadic(-6.25 - 0.5);
        assert!(t.enclosure.lo <= least && least <= t.enclosure.hi, "{t:?}");
    }
    m.done("cylinders");
}

/// The straight segment between two points as a Bezier curve of this degree with far weights.
fn segment(g: &mut Random, degree: usize, a: [f64; 2], b: [f64; 2]) -> Curve2 {
    let points: Vec<[f64; 3]> = even(degree, 3)
        .iter()
        .map(|t| {
            let w = power(g.range(-40.0, 40.0));
            let [u, v] = [0, 1].map(|k| {
                let x = a[k] + t * (b[k] - a[k]);
                assert_eq!(
                    dyadic(x),
                    &dyadic(a[k]) + &(&dyadic(*t) * &(&dyadic(b[k]) - &dyadic(a[k])))
                );
                x
            });
            [w * u, w * v, w]
        })
        .collect();
    bezier(&points)
}

#[test]
fn trims_of_high_degree_in_a_long_domain() {
    // A parallelogram over 2^-20 by 2^20; the triangle below its diagonal, whose sides are of high degree.
    let long = [2f64.powi(-20), 2f64.powi(20)];
    let r = Rectangle {
        origin: [0.5, -2.0, 1.0],
        sides: [1.0, 1.0],
    };
    let mut g = Random(6);
    let mut m = Measured::default();
    for degree in [1, 5, 25] {
        let corners = [[0.0, 0.0], [long[0], 0.0], [0.0, long[1]]];
        let sides = (0..3).map(|k| segment(&mut g, degree, corners[k], corners[(k + 1) % 3]));
        let knots = [bezier_knots(1, 0.0, long[0]), bezier_knots(1, 0.0, long[1])];
        let b = brep(
            r.surface([1, 1], [&[0.0, 1.0], &[0.0, 1.0]], |_, _| 1.0, knots),
            Some(vec![sides.collect()]),
        );
        let o = Oracle::new(&[&b]).unwrap();
        for at in [
            [0.25, 0.25, 0.5],
            [0.25, 0.25, 0.0],
            [0.75, 0.75, 0.5],
            [0.5 + UNIT, 0.5, UNIT],
            [0.5 - UNIT, 0.5, UNIT],
            [-0.25, 0.5, 0.25],
            [1.5, 0.25, 0.25],
        ] {
            let q = r.point(at);
            let start = Instant::now();
            let t = o.distance(q, None).unwrap().unwrap();
            m.add(
                start,
                &t.enclosure,
                r.size(),
                &format!("degree {degree} from {at:?}"),
            );
            // Beyond the diagonal, beside its ends, or over the inside.
            let [x, y, z] = at;
            let beyond = x + y - 1.0;
            let truth = if (x - y).abs() <= 1.0 && beyond > 0.0 {
                0.5 * beyond * beyond
            } else {
                let dx = if x > 0.0 { (x - 1.0).max(0.0) } else { x };
                dx * dx + if beyond > 0.0 { y * y } else { 0.0 }
            };
            assert_root(&t.enclosure, &dyadic(9.0 * (truth + z * z)));
        }
    }
    m.done("trims of degree 25");
}

fn print_times(what: &str, mut times: Vec<f64>) {
    times.sort_by(f64::total_cmp);
    let longest = times[times.len() - 1];
    println!(
        "{what}: median {:.1}, longest {longest:.1}",
        times[times.len() / 2]
    );
}

#[test]
fn lines_meet_far_weights() {
    let mut g = Random(7);
    let mut times = Vec::new();
    for (p, q) in [(1, 1), (3, 3), (25, 2)] {
        // Products of weights of rows and columns: u and v run by themselves, so that there is one hit.
        let (a, b) = (weights(&mut g, p + 1, 20.0), weights(&mut g, q + 1, 20.0));
        let brep = brep(plain(p, q, |i, j| a[i] * b[j]), None);
        let o = Oracle::new(&[&brep]).unwrap();
        for _ in 0..4 {
            let mut inner = |side: f64| (g.range(0.125, 0.875) * side * 1024.0).round() / 1024.0;
            let at = [inner(1.0), inner(2.0)];
            let origin = PLAIN.point([at[0], at[1], 2.0]);
            let start = Instant::now();
            let t = o.line(origin, FRAME[2], LineKind::Line).unwrap();
            times.push(start.elapsed().as_secs_f64() * 1e3);
            assert!(t.open.is_empty(), "{p}x{q}: {:?}", t.open);
            assert_eq!(t.hits.len(), 1, "{p}x{q} at {at:?}: {:?}", t.hits);
            let e = &t.hits[0].t;
            assert!(e.lo <= dyadic(-2.0) && dyadic(-2.0) <= e.hi, "{e:?}");
            assert!(e.width().approximate() <= WIDTH, "{p}x{q}: {e:?}");
        }
    }
    print_times("lines, in ms", times);
}

#[test]
fn sides_of_loops_far_off_small_and_long() {
    let mut g = Random(8);
    let mut times = Vec::new();
    // Offset, and lengths along u and v.
    for (at, size) in [
        ([2f64.powi(30), -(2f64.powi(30))], [2f64.powi(-19); 2]),
        ([0.0, 0.0], [2f64.powi(-20), 2f64.powi(20)]),
    ] {
        for degree in [1, 3, 25] {
            let corner = |x: f64, y: f64| [at[0] + x * size[0], at[1] + y * size[1]];
            let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
            let sides = (0..3).map(|k| segment(&mut g, degree, corners[k], corners[(k + 1) % 3]));
            let b = brep(plane(2f64.powi(31)), Some(vec![sides.collect()]));
            let o = Oracle::new(&[&b]).unwrap();
            let region = TrimmedRegion::new(&b, 0).unwrap();
            for k in 0..24 {
                let mut grid = || (g.next() * 10.0).floor() / 8.0 - 0.125;
                let (x, y) = (grid(), grid());
                let mut uv = corner(x, y);
                if k % 3 == 0 {
                    uv[0] = uv[0].next_up();
                }
                // Exactly: u' = (u - at) / size; inside where u' > 0, v' > 0 and u' + v' < 1.
                let off = |k: usize| &(&dyadic(uv[k]) - &dyadic(at[k])) * &dyadic(1.0 / size[k]);
                let (u, v) = (off(0), off(1));
                let w = &(&dyadic(1.0) - &u) - &v;
                let least = [u.signum(), v.signum(), w.signum()].into_iter().min();
                let truth = match least {
                    Some(1) => Side::Inside,
                    Some(0) => Side::Boundary,
                    _ => Side::Outside,
                };
                let start = Instant::now();
                let found = o.side(0, uv).unwrap();
                times.push(start.elapsed().as_secs_f64() * 1e6);
                assert_eq!(found.side, truth, "degree {degree} at {uv:?}");
                let quick = region.side_by_halving(uv).unwrap();
                assert_eq!(quick, found, "degree {degree} at {uv:?}");
                // Of degree 25 a Sturm chain takes tenths of a second.
                if degree < 25 || k % 6 == 0 {
                    let counted = region.side(uv).unwrap();
                    assert_eq!(counted, found, "degree {degree} at {uv:?}");
                }
            }
        }
    }
    print_times("sides, in us", times);
}

#[test]
fn derivative_roots_of_curves_far_off_and_with_short_spans() {
    let mut g = Random(9);
    let mut found = 0;
    for (at, size, far, degree, knots) in [
        (2f64.powi(30), 2f64.powi(-20), 0.0, 3, ulp_knots(3, 1.0)),
        (0.0, 2f64.powi(20), 40.0, 3, ulp_knots(3, 1e-6)),
        (
            2f64.powi(30),
            2f64.powi(-20),
            40.0,
            25,
            bezier_knots(25, 0.0, 1e-6),
        ),
        (0.0, 2f64.powi(-20), 40.0, 25, bezier_knots(25, 0.0, 1e6)),
    ] {
        for _ in 0..3 {
            let points = (0..knots.len() - degree - 1)
                .map(|_| {
                    let w = power(g.range(-far, far));
                    let mut x = || at + (g.next() * 8.0).floor() * size;
                    Vector3::new(w * x(), w * x(), w)
                })
                .collect();
            let curve = Curve2::Nurbs(NurbsCurve::new(degree, points, knots.clone()).unwrap());
            let b = brep(plane(2f64.powi(31)), Some(vec![vec![curve.clone()]]));
            let first = Oracle::new(&[&b])
                .unwrap()
                .derivative_roots(0, 0, 0)
                .unwrap();
            let second = derivative_roots(&[&b], 0, 0, 0).unwrap();
            for (a, b) in first.axes.iter().zip(&second.axes) {
                assert_eq!(a.roots.len(), b.roots.len(), "{curve:?}");
                assert_eq!(a.constant.len(), b.constant.len(), "{curve:?}");
                for (a, b) in a.roots.iter().zip(&b.roots) {
                    assert!(
                        a.t.lo <= b.t.hi && b.t.lo <= a.t.hi,
                        "{curve:?} {a:?} {b:?}"
                    );
                    assert_eq!(
                        (a.multiplicity, a.sign, a.cusp),
                        (b.multiplicity, b.sign, b.cusp)
                    );
                }
                found += a.roots.len();
            }
        }
    }
    println!("{found} derivative roots");
    assert!(found > 20);
}
