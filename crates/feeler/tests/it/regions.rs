//! Sides of points that only the last digits tell, against arithmetic of their own: integers, and closed boxes.

use crate::scenes::loops::face_within;
use feeler::numeric::{Dyadic, Interval};
use feeler::nurbs::{Curve, Curve2, Line, NurbsCurve};
use feeler::trim::{RegionSide, Side, TrimRegion};
use nalgebra::{Point2, Vector3};
use proptest::prelude::*;

fn line(a: [f64; 2], b: [f64; 2]) -> Curve2 {
    let unit = Interval::new(0.0, 1.0).unwrap();
    Curve::Line(Line::new(Point2::from(a), Point2::from(b), unit).unwrap())
}

fn region(trims: Vec<Curve2>) -> TrimRegion {
    TrimRegion::new(&face_within(vec![trims]), 0)
}

fn side(region: &TrimRegion, q: [f64; 2]) -> RegionSide {
    region.side(Point2::from(q))
}

/// The same point, or with u and v swapped.
fn swapped(q: [f64; 2], swap: bool) -> [f64; 2] {
    if swap { [q[1], q[0]] } else { q }
}

/// Some numbers next to one.
fn beside(x: f64) -> [f64; 5] {
    let (up, down) = (x.next_up(), x.next_down());
    [down.next_down(), down, x, up, up.next_up()]
}

/// The sign of `(b - a) x (q - a)`, exactly.
fn turn(a: [f64; 2], b: [f64; 2], q: [f64; 2]) -> i32 {
    let off =
        |p: [f64; 2], k: usize| &Dyadic::from_f64(p[k]).unwrap() - &Dyadic::from_f64(a[k]).unwrap();
    (&(&off(b, 0) * &off(q, 1)) - &(&off(b, 1) * &off(q, 0))).signum()
}

/// A rectangle, a hole with corners at `(-10 + k + 0.487213, -6 + k + 0.518307)`, rounded, and a sliver, so that the grid is not square.
fn loops_through_references() -> [Vec<[f64; 2]>; 3] {
    let corner = |k: i32| {
        let k = f64::from(k);
        [-10.0 + (k + 0.487_213), -6.0 + (k + 0.518_307)]
    };
    // In so many sides that there are as many cells.
    let bottom = (0..8).map(|k| [-10.0 + 2.5 * f64::from(k), -6.0]);
    let mut outer: Vec<[f64; 2]> = bottom.chain([[10.0, -6.0], [10.0, 0.0]]).collect();
    let turned: Vec<[f64; 2]> = outer.iter().map(|p| p.map(|x| -x)).collect();
    outer.extend(turned);
    let mut hole: Vec<[f64; 2]> = (2..9).map(corner).collect();
    hole.extend([[2.0, 3.75], [-5.0, -3.75]]);
    let sliver = vec![[7.0, -5.0], [7.25, 4.75], [7.125, -5.0]];
    [outer, hole, sliver]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// The trim `(t, c (d t - n)^2)` touches v = 0 at t = n / d, which is no f64: a ray along v = 0 touches it there, at a double root, and every
    /// point of v = 0 is outside, to either side of it and as near as there are numbers.
    #[test]
    fn a_trim_that_a_ray_touches_is_not_crossed(
        d in prop::sample::select(vec![3i32, 5, 7, 9, 11, 13]),
        part in 0.0..1.0f64,
        scale in prop::sample::select(vec![1.0, 0.125, -0.125]),
        swap in any::<bool>(),
    ) {
        let n = f64::from(1 + (part * f64::from(d - 1)) as i32);
        let d = f64::from(d);
        // In Bernstein form.
        let heights = [n * n, -n * (d - n), (d - n) * (d - n)].map(|h| scale * h * 0.0625);
        let points = [0.0, 0.5, 1.0].into_iter().zip(heights);
        let net: Vec<Vector3<f64>> = points
            .map(|(u, v)| swapped([u, v], swap))
            .map(|[u, v]| Vector3::new(u, v, 1.0))
            .collect();
        let ends = [0, 2].map(|i| [net[i].x, net[i].y]);
        let parabola = NurbsCurve::new(2, net, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0]).unwrap();
        let region = region(vec![Curve::Nurbs(parabola), line(ends[1], ends[0])]);
        for u in beside(n / d) {
            let q = swapped([u, 0.0], swap);
            prop_assert_eq!(side(&region, q).side, Some(Side::Outside), "{:?}", q);
        }
        // Above the vertex it is inside, by as little as that takes: v > c (d u - n)^2, which for these is below 1e-28.
        let q = swapped([n / d, scale.signum() * 1e-26], swap);
        prop_assert_eq!(side(&region, q).side, Some(Side::Inside));
    }

    /// Where the ends of two trims differ, the whole closed box of the two is the gap, not only the segment that joins them: wherever in the face's
    /// grid of cells that is, and however many trims there are.
    #[test]
    fn a_gap_is_a_box(
        from in prop::array::uniform2(-8..8i32),
        size in prop::array::uniform2(1..16i32),
        flip in any::<bool>(),
        teeth in prop::sample::select(vec![0usize, 20, 300]),
    ) {
        let from = from.map(|x| f64::from(x) / 4.0);
        let to = [0, 1].map(|k| from[k] + f64::from(size[k]) / 4.0);
        let [a, b] = if flip { [[from[0], to[1]], [to[0], from[1]]] } else { [from, to] };
        // From b away to the right and around, back to a.
        let mut corners = vec![b, [9.0, b[1]], [9.0, 9.0]];
        for k in 0..teeth {
            let x = 9.0 - 16.0 * (k as f64 + 1.0) / (teeth as f64 + 1.0);
            corners.extend([[x, if k % 2 == 0 { 8.0 } else { 9.0 }]]);
        }
        corners.extend([[-9.0, 9.0], [-9.0, a[1]], a]);
        let trims = corners.windows(2).map(|w| line(w[0], w[1])).collect();
        let region = region(trims);
        let within = |q: [f64; 2]| (0..2).all(|k| from[k] <= q[k] && q[k] <= to[k]);
        for i in -12..=28 {
            for j in -12..=28 {
                let q = [f64::from(i) / 4.0 + 0.0625, f64::from(j) / 4.0];
                prop_assert_eq!(side(&region, q).in_gap, within(q), "{:?}", q);
            }
        }
        for q in [[from[0], from[1]], [from[0], to[1]], [to[0], from[1]], [to[0], to[1]]] {
            prop_assert!(side(&region, q).in_gap, "{:?}", q);
        }
        let q = [from[0].next_down(), from[1]];
        prop_assert!(!side(&region, q).in_gap, "{:?}", q);
    }

    /// The grid of these loops has 20 by 12 cells of side 1, and a row of corners of the inner one lies exactly on the reference points of cells, as the
    /// unit test of cells says: no such cell tells a side by its reference.
    #[test]
    fn loops_through_the_reference_points_of_cells(
        at in prop::collection::vec((0..7usize, prop::array::uniform2(-0.5..0.5f64)), 64),
    ) {
        let loops = loops_through_references();
        let trims = |c: &Vec<[f64; 2]>| -> Vec<Curve2> {
            (0..c.len()).map(|i| line(c[i], c[(i + 1) % c.len()])).collect()
        };
        let region = TrimRegion::new(&face_within(loops.iter().map(trims).collect()), 0);
        for (k, off) in at {
            let corner = loops[1][k];
            for scale in [1.0, 2f64.powi(-30), 2f64.powi(-51)] {
                let q = [0, 1].map(|i| corner[i] + scale * off[i]);
                // Crossings of the ray along u, each told exactly; on a side or at its corners it is the boundary.
                let (mut odd, mut on) = (false, false);
                for c in &loops {
                    for i in 0..c.len() {
                        let (a, b) = (c[i], c[(i + 1) % c.len()]);
                        let side = turn(a, b, q);
                        let between = |k: usize| a[k].min(b[k]) <= q[k] && q[k] <= a[k].max(b[k]);
                        on |= side == 0 && between(0) && between(1);
                        if (a[1] > q[1]) != (b[1] > q[1]) {
                            odd ^= (side > 0) == (b[1] > a[1]);
                        }
                    }
                }
                let expected = match (on, odd) {
                    (true, _) => Side::Boundary,
                    (_, true) => Side::Inside,
                    _ => Side::Outside,
                };
                prop_assert_eq!(side(&region, q).side, Some(expected), "{:?}", q);
            }
        }
    }

    /// Points as near to the sides of a triangle as there are numbers.
    #[test]
    fn beside_the_sides_of_a_triangle(
        corners in prop::array::uniform3(prop::array::uniform2(-9.0..9.0f64)),
        at in prop::collection::vec((0..3usize, 0.0..1.0f64), 24),
    ) {
        let [a, b, c] = corners;
        prop_assume!(turn(a, b, c) != 0);
        let corners = if turn(a, b, c) > 0 { [a, b, c] } else { [a, c, b] };
        let next = |k: usize| corners[(k + 1) % 3];
        let region = region((0..3).map(|k| line(corners[k], next(k))).collect());
        for (k, t) in at {
            let on = [0, 1].map(|i| corners[k][i] + t * (next(k)[i] - corners[k][i]));
            for u in beside(on[0]) {
                for v in beside(on[1]) {
                    let turns = [0, 1, 2].map(|k| turn(corners[k], next(k), [u, v]));
                    let expected = match turns.iter().min() {
                        Some(1) => Side::Inside,
                        Some(0) => Side::Boundary,
                        _ => Side::Outside,
                    };
                    prop_assert_eq!(side(&region, [u, v]).side, Some(expected), "{} {}", u, v);
                }
            }
        }
    }
}
