//! Surfaces made of poly-curves whose segments have inner knots that are no numbers of f64 among the poly-curve's own parameters: the patches on both
//! sides of such a border are exactly what they are without one. Truth is computed in rationals.

use crate::common::q;
use crate::scenes::{loop_face, polygon_face};
use dashu_ratio::RBig as Q;
use feeler::brep::Brep;
use feeler::numeric::Interval;
use feeler::nurbs::{
    Curve, Curve3, Line, NurbsCurve2, NurbsCurve3, Plane, PolyCurve, Revolution, Sum, Surface,
};
use feeler::prepare::{PreparedBrep, Shortcuts};
use feeler::query::{
    ContactAnswer, HalfSpace, LineKind, LineProbe, Options, Probe, Sphere, Workspace, contact, line,
};
use nalgebra::{Point2, Point3, Vector3};

/// Where the second segment, of its own domain `[0, 1]`, lies in the poly-curve; and its inner knot.
const ENDS: [f64; 3] = [0.0, 1.0, 2.1];
const KNOT: f64 = 0.3;

fn interval(start: f64, end: f64) -> Interval {
    Interval::new(start, end).unwrap()
}

/// A line and a spline in `y = 0`, as points `(x, z)`; the spline has one inner knot and so `degree + 2` points.
struct Profile {
    start: [f64; 2],
    spline: Vec<[f64; 2]>,
}

impl Profile {
    fn degree(&self) -> usize {
        self.spline.len() - 2
    }

    fn curve(&self) -> Curve3 {
        let p = self.degree();
        let at = |[x, z]: [f64; 2]| Point3::new(x, 0.0, z);
        let segment = Line::new(at(self.start), at(self.spline[0]), interval(-3.0, 4.0));
        let points = self.spline.iter().map(|p| at(*p).coords.push(1.0));
        let ends = [vec![0.0; p + 1], vec![KNOT], vec![1.0; p + 1]];
        let spline = NurbsCurve3::new(p, points.collect(), ends.concat()).unwrap();
        let segments = vec![Curve::Line(segment.unwrap()), Curve::Nurbs(spline)];
        Curve::Poly(PolyCurve::new(segments, ENDS.to_vec()).unwrap())
    }

    /// Where `x` times one factor and `z` times another are quadratic: from and to, Bernstein coefficients.
    fn heights(&self, [along, up]: [Q; 2]) -> Vec<([Q; 2], [Q; 3])> {
        let of = |p: &[f64; 2]| &along * q(p[0]) + &up * q(p[1]);
        let c: Vec<Q> = self.spline.iter().map(of).collect();
        let [a, b, end] = ENDS.map(q);
        let k = q(KNOT);
        let border = &b + &k * (&end - &b);
        let between = |s: &Q, x: &Q, y: &Q| (Q::ONE - s) * x + s * y;
        let raised = |x: &Q, y: &Q| [x.clone(), (x + y) / Q::from(2), y.clone()];
        // By inserting the knot once more.
        let (first, second) = match self.degree() {
            1 => (raised(&c[0], &c[1]), raised(&c[1], &c[2])),
            2 => {
                let middle = between(&k, &c[1], &c[2]);
                let [p, q, r, s] = [0, 1, 2, 3].map(|i| c[i].clone());
                ([p, q, middle.clone()], [middle, r, s])
            }
            _ => unreachable!(),
        };
        vec![
            ([a, b.clone()], raised(&of(&self.start), &c[0])),
            ([b, border.clone()], first),
            ([border, end], second),
        ]
    }
}

/// The least value of a quadratic function over `[0, 1]`.
fn least([a, b, c]: &[Q; 3]) -> Q {
    let ends = if a < c { a.clone() } else { c.clone() };
    let bend = a - Q::from(2) * b + c;
    if b < a && b < c {
        // a (1 - t)^2 + 2 b t (1 - t) + c t^2 at t = (a - b) / (a - 2 b + c).
        (a * c - b * b) / bend
    } else {
        ends
    }
}

/// A smooth profile, one with a peak at the inner knot, and one that touches its largest radius just there.
fn profiles() -> Vec<Profile> {
    let of = |start, spline: &[[f64; 2]]| Profile {
        start,
        spline: spline.to_vec(),
    };
    vec![
        of(
            [3.0, -1.0],
            &[[4.0, -0.5], [5.1, 0.7], [4.9, 1.9], [3.3, 2.2]],
        ),
        of([3.0, -1.0], &[[4.0, -0.5], [5.3, 0.7], [3.9, 1.9]]),
        of(
            [3.0, -1.0],
            &[[4.0, -0.5], [5.3, 0.7], [5.3, 1.9], [3.3, 2.2]],
        ),
    ]
}

fn turned(profile: &Profile, transposed: bool) -> PreparedBrep {
    let turn = interval(0.0, std::f64::consts::TAU);
    let revolution = Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: turn,
        angle_domain: turn,
        profile: profile.curve(),
        transposed,
    };
    let surface = Surface::Revolution(Revolution::new(revolution).unwrap());
    PreparedBrep::with_shortcuts(Brep::from_surface(surface).unwrap(), OPEN)
}

/// Every face is searched, none has a formula.
const OPEN: Shortcuts = Shortcuts {
    closed_forms: false,
    ..Shortcuts::ALL
};

/// Contacts are listed however far they are.
fn far() -> Options {
    Options {
        prediction: f64::INFINITY,
        ..Options::default()
    }
}

/// Asks for a half-space's gap and compares it with the least of `n . x`.
fn check_half_space(brep: &PreparedBrep, n: [f64; 3], truth: &Q, what: &str) {
    const H: f64 = 0.25;
    let probe = Probe::HalfSpace(HalfSpace::new(Vector3::from(n), H).unwrap());
    let a = contact(brep, &probe, &far(), &mut Workspace::default());
    let truth = truth - q(H);
    let b = a.separation.bounds;
    assert!(q(b.lo) <= truth && truth <= q(b.hi), "{what}: {b:?}");
    is_full(&a, what);
}

fn is_full(a: &ContactAnswer, what: &str) {
    let b = a.separation.bounds;
    assert_eq!(a.undecided, None, "{what}: {b:?}");
    let ulp = b.lo.abs().max(b.hi.abs()).next_up() - b.lo.abs().max(b.hi.abs());
    assert!(b.width() <= 2.0 * ulp, "{what}: {b:?}");
    assert!(!a.continuum, "{what}");
    assert_eq!(a.contacts.len(), 1, "{what}");
}

/// Directions with no part along y: a surface of revolution about z comes as low as its profile, turned half a turn, does.
const ACROSS: [[f64; 3]; 4] = [
    [0.6, 0.0, 0.8],
    [0.6, 0.0, -0.8],
    [-5.0 / 13.0, 0.0, -12.0 / 13.0],
    [1.0, 0.0, 0.0],
];

#[test]
fn half_spaces_under_a_turned_poly_curve() {
    for (i, profile) in profiles().iter().enumerate() {
        for transposed in [false, true] {
            let brep = turned(profile, transposed);
            for n in ACROSS {
                let heights = profile.heights([-q(n[0].abs()), q(n[2])]);
                let truth = heights.iter().map(|(_, c)| least(c)).min().unwrap();
                let what = format!("{i} {transposed} {n:?}");
                check_half_space(&brep, n, &truth, &what);
            }
        }
    }
}

/// Beside the profile with straight pieces: the centre is 5 times the unit from the axis in all of these.
#[test]
fn balls_beside_a_turned_poly_curve() {
    let profile = &profiles()[1];
    let brep = turned(profile, false);
    let corners: Vec<[Q; 2]> = std::iter::once(&profile.start)
        .chain(&profile.spline)
        .map(|p| p.map(q))
        .collect();
    for (scale, z) in [(1.5, 0.7), (1.5, 0.75), (1.25, 1.5), (0.5, 1.0), (1.0, 0.7)] {
        let (at, height) = (q(5.0) * q(scale), q(z));
        let squares = corners.windows(2).map(|w| {
            let [a, b] = [&w[0], &w[1]];
            let along = [&b[0] - &a[0], &b[1] - &a[1]];
            let off = [&at - &a[0], &height - &a[1]];
            let length = &along[0] * &along[0] + &along[1] * &along[1];
            let t = (&off[0] * &along[0] + &off[1] * &along[1]) / length;
            let t = t.clamp(Q::ZERO, Q::ONE);
            let [x, y] = [0, 1].map(|k| &off[k] - &t * &along[k]);
            &x * &x + &y * &y
        });
        let square = squares.min().unwrap();
        for [x, y] in [[3.0, 4.0], [-4.0, 3.0], [0.0, -5.0]] {
            const RADIUS: f64 = 0.125;
            let center = Point3::new(x * scale, y * scale, z);
            let a = contact(
                &brep,
                &Probe::Sphere(Sphere::new(center, RADIUS).unwrap()),
                &far(),
                &mut Workspace::default(),
            );
            let what = format!("{center:?}");
            let b = a.separation.bounds;
            let [lo, hi] = [b.lo, b.hi].map(|x| q(x) + q(RADIUS));
            let below = lo < Q::ZERO || &lo * &lo <= square;
            assert!(below && square <= &hi * &hi, "{what}: {b:?}");
            is_full(&a, &what);
        }
    }
}

/// Lines that meet the circle of the inner knot, and its neighbours in f64: twice each.
#[test]
fn lines_through_the_border_of_a_turned_poly_curve() {
    for (i, profile) in profiles()[..2].iter().enumerate() {
        let brep = turned(profile, false);
        // In the middle of the profile's second and third pieces.
        let heights = profile.heights([q(0.0), q(1.0)]);
        let z = heights[2].1[0].to_f64().value();
        for z in [z.next_down(), z, z.next_up(), z - 1e-13, z + 1e-13] {
            let probe = LineProbe::new(Point3::new(-9.0, 0.5, z), Vector3::x(), LineKind::Line);
            let a = line(
                &brep,
                &probe.unwrap(),
                &Options::default(),
                &mut Workspace::default(),
            );
            assert_eq!(
                (a.hits.len(), a.crossings, a.undecided),
                (2, Some(2), None),
                "{i} {z}"
            );
        }
    }
}

/// Over the profile, and as far along y as `[0, 1]`.
fn extruded(profile: &Profile, swapped: bool) -> Surface {
    let line = Line::new(
        Point3::origin(),
        Point3::new(0.0, 1.0, 0.0),
        interval(0.0, 1.0),
    );
    let (curve, line) = (profile.curve(), Curve::Line(line.unwrap()));
    let (first, second) = if swapped {
        (line, curve)
    } else {
        (curve, line)
    };
    Surface::Sum(Sum {
        base: Vector3::zeros(),
        first,
        second,
    })
}

/// The numbers of f64 next to the border of two patches, below and above.
fn beside_border() -> [f64; 2] {
    let border = &profiles()[0].heights([q(0.0), q(1.0)])[2].0[0];
    let near = border.to_f64().value();
    assert!(q(near) != *border, "no test");
    if q(near) < *border {
        [near, near.next_up()]
    } else {
        [near.next_down(), near]
    }
}

/// Triangles and other polygons on an extruded poly-curve: their sides pass the border between two patches, run along it at the nearest numbers of
/// f64 on either side, or end there.
#[test]
fn half_spaces_under_a_trimmed_poly_curve() {
    let [below, above] = beside_border();
    let polygons = [
        vec![[0.25, 0.125], [2.0, 0.375], [1.75, 0.875], [0.5, 0.75]],
        vec![[0.25, 0.125], [below, 0.375], [below, 0.875]],
        vec![[0.25, 0.125], [above, 0.375], [above, 0.875]],
        vec![[below, 0.25], [2.0, 0.5], [below, 0.75]],
        vec![[above, 0.25], [2.0, 0.5], [above, 0.75]],
        vec![[below, 0.25], [above, 0.5], [below, 0.75]],
        vec![[1.25, 0.25], [1.5, 0.125], [1.625, 0.5], [1.25, 0.625]],
    ];
    // Lengths are 1 as near as f64 holds them.
    let normals = [
        [2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0],
        [-2.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0],
        [-1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0],
        [-2.0 / 7.0, 3.0 / 7.0, -6.0 / 7.0],
    ];
    for (i, profile) in profiles().iter().enumerate() {
        for (j, polygon) in polygons.iter().enumerate() {
            for swapped in [false, true] {
                let mut corners: Vec<_> = polygon
                    .iter()
                    .map(|[u, v]| if swapped { [*v, *u] } else { [*u, *v] })
                    .map(Point2::from)
                    .collect();
                if swapped {
                    corners.reverse();
                }
                let brep = polygon_face(&extruded(profile, swapped), &corners);
                for n in normals {
                    let truth = on_polygon(profile, polygon, n);
                    let what = format!("{i} {j} {swapped} {n:?}");
                    check_half_space(&brep, n, &truth, &what);
                }
            }
        }
    }
}

/// The least of `n . x` over the border of a polygon: with a slope along y there is no minimum within it.
fn on_polygon(profile: &Profile, polygon: &[[f64; 2]], n: [f64; 3]) -> Q {
    let heights = profile.heights([q(n[0]), q(n[2])]);
    let mut found: Vec<Q> = Vec::new();
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let [[u0, v0], [u1, v1]] = [a, b].map(|p| p.map(q));
        for ([from, to], c) in &heights {
            // Where the side is over the piece.
            let (low, high) = (u0.clone().min(u1.clone()), u0.clone().max(u1.clone()));
            let (low, high) = (low.max(from.clone()), high.min(to.clone()));
            if low > high {
                continue;
            }
            let ends = if u0 == u1 {
                [[u0.clone(), v0.clone()], [u1.clone(), v1.clone()]]
            } else {
                [low, high].map(|u| {
                    let v = &v0 + (&v1 - &v0) * (&u - &u0) / (&u1 - &u0);
                    [u, v]
                })
            };
            let [s, t] = [&ends[0], &ends[1]].map(|p| (&p[0] - from) / (to - from));
            let polar = |s: &Q, t: &Q| {
                let between = |t: &Q, x: &Q, y: &Q| (Q::ONE - t) * x + t * y;
                between(t, &between(s, &c[0], &c[1]), &between(s, &c[1], &c[2]))
            };
            let side = |v: Q| q(n[1]) * v;
            let middle = (&ends[0][1] + &ends[1][1]) / Q::from(2);
            found.push(least(&[
                polar(&s, &s) + side(ends[0][1].clone()),
                polar(&s, &t) + side(middle),
                polar(&t, &t) + side(ends[1][1].clone()),
            ]));
        }
    }
    found.into_iter().min().unwrap()
}

/// The region of a plane between a profile, as a trim, and its chord.
fn flat(profile: &Profile) -> PreparedBrep {
    let p = profile.degree();
    let at = |p: [f64; 2]| Point2::from(p);
    let segment = Line::new(
        at(profile.start),
        at(profile.spline[0]),
        interval(-3.0, 4.0),
    );
    let points = profile.spline.iter().map(|p| at(*p).coords.push(1.0));
    let ends = [vec![0.0; p + 1], vec![KNOT], vec![1.0; p + 1]];
    let spline = NurbsCurve2::new(p, points.collect(), ends.concat()).unwrap();
    let segments = vec![Curve::Line(segment.unwrap()), Curve::Nurbs(spline)];
    let trim = Curve::Poly(PolyCurve::new(segments, vec![0.0, 0.37, 1.0]).unwrap());
    let corners = [profile.spline[p + 1], profile.start];
    let chord = Line::new(at(corners[0]), at(corners[1]), interval(0.0, 1.0));
    let wide = interval(-8.0, 8.0);
    let plane = Plane {
        origin: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::y(),
        domain: [wide; 2],
        extents: [wide; 2],
    };
    let vertices = [corners[1], corners[0]].map(|[x, y]| Point3::new(x, y, 0.0));
    let curves = vec![trim, Curve::Line(chord.unwrap())];
    let surface = Surface::Plane(Plane::new(plane).unwrap());
    PreparedBrep::new(loop_face(&surface, curves, vertices.to_vec()))
}

#[test]
fn half_spaces_under_a_poly_curve_in_a_plane() {
    for (i, profile) in profiles().iter().enumerate() {
        let brep = flat(profile);
        for n in [
            [-0.6, -0.8, 0.0],
            [-0.8, 0.0, 0.6],
            [-0.6, 0.8, 0.0],
            [-12.0 / 13.0, -5.0 / 13.0, 0.0],
        ] {
            let heights = profile.heights([q(n[0]), q(n[1])]);
            let truth = heights.iter().map(|(_, c)| least(c)).min().unwrap();
            check_half_space(&brep, n, &truth, &format!("{i} {n:?}"));
        }
    }
}
