//! Sides of points against shapes whose sides are known.

use super::shapes::*;
use crate::numeric::{Ball, Dd};
use crate::trim::{BoxSide, Side, TrimRegion};

const WIDE: [f64; 4] = [-10.0, 10.0, -10.0, 10.0];

fn side(region: &TrimRegion, q: [f64; 2]) -> Side {
    region.side(q.into()).side.unwrap()
}

#[test]
fn square_and_its_border() {
    let square = polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let region = TrimRegion::new(&face(WIDE, Some(vec![square])), 0);
    for i in -1..=5 {
        for j in -1..=5 {
            let (x, y) = (f64::from(i) / 4.0, f64::from(j) / 4.0);
            let expected = if !(0.0..=1.0).contains(&x) || !(0.0..=1.0).contains(&y) {
                Side::Outside
            } else if x == 0.0 || y == 0.0 || x == 1.0 || y == 1.0 {
                Side::Boundary
            } else {
                Side::Inside
            };
            assert_eq!(side(&region, [x, y]), expected, "{x} {y}");
        }
    }
    assert_eq!(region.classify_box([0.2, 0.8], [0.2, 0.8]), BoxSide::Inside);
    assert_eq!(region.classify_box([0.2, 1.0], [0.2, 0.8]), BoxSide::Mixed);
    assert_eq!(
        region.classify_box([1.5, 2.0], [0.2, 0.8]),
        BoxSide::Outside
    );
    assert_eq!(region.pieces().len(), 4);
}

/// A diamond with curved sides, its corners at the levels of the points: on a corner's level the ray runs exactly through a joint. Beside a
/// corner by one unit in the last place only the exact decision tells.
#[test]
fn joints_of_curves_at_the_level_of_the_point() {
    let corners = [[2.0, 1.0], [1.0, 2.0], [0.5, 1.0], [1.0, 0.5]];
    for bulge in [0.25, 0.75] {
        let sides = (0..4).map(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            // Towards where the two levels meet outside, or inside: the sides stay monotone.
            let outer = if i % 2 == 0 {
                [a[0], b[1]]
            } else {
                [b[0], a[1]]
            };
            let middle = [0, 1].map(|k| 0.5 * (a[k] + b[k]) * (1.0 - bulge) + bulge * outer[k]);
            bezier(&[a, middle, b].map(|p| [p[0], p[1], 1.0])).into()
        });
        let region = TrimRegion::new(&face(WIDE, Some(vec![sides.collect()])), 0);
        for (i, c) in corners.into_iter().enumerate() {
            assert_eq!(side(&region, c), Side::Boundary, "{c:?}");
            let k = i % 2;
            // Inwards is down at the first two corners, up at the others.
            for (q, expected) in [
                (
                    c[k].next_down(),
                    if i < 2 { Side::Inside } else { Side::Outside },
                ),
                (
                    c[k].next_up(),
                    if i < 2 { Side::Outside } else { Side::Inside },
                ),
            ] {
                let mut at = c;
                at[k] = q;
                assert_eq!(side(&region, at), expected, "bulge {bulge}, {at:?}");
            }
        }
        for u in [0.625, 1.0, 1.5, 1.9375] {
            assert_eq!(side(&region, [u, 1.0]), Side::Inside, "{u}");
        }
    }
}

/// Points off a slanted side by far less than f64 tells: the sign of the offset says where they are.
#[test]
fn beside_a_segment() {
    let corners = [[0.125, -0.3], [7.3, 1.1], [2.9, 6.7]];
    let region = TrimRegion::new(&face(WIDE, Some(vec![polygon(&corners)])), 0);
    for i in 0..3 {
        let [a, b] = [corners[i], corners[(i + 1) % 3]];
        let d = [0, 1].map(|k| Dd::difference(b[k], a[k]));
        let left = [-d[1], d[0]];
        let at = |s: f64, off: f64, rad: f64| {
            let (s, off) = (Dd::from(s), Dd::from(off));
            let point = |k: usize| Dd::from(a[k]) + s * d[k] + off * left[k];
            region.side_of_ball([0, 1].map(|k| Ball { mid: point(k), rad }))
        };
        for s in [0.1, 0.30000001, 0.5, 0.77, 0.99] {
            for off in [1e-14, 1e-17, 1e-22, 1e-27] {
                let rad = (off * 1e-3f64).clamp(1e-30, 1e-20);
                assert_eq!(at(s, off, rad), Some(Side::Inside), "{i} {s} {off:e}");
                assert_eq!(at(s, -off, rad), Some(Side::Outside), "{i} {s} {off:e}");
            }
            // Within its own error it may be on the line.
            assert_eq!(at(s, 0.0, 1e-30), None, "{i} {s}");
            assert_eq!(at(s, 1e-25, 1e-23), None, "{i} {s}");
        }
    }
}

/// A ball that reaches over the border of the domain has no side, however far the loops are.
#[test]
fn balls_across_the_border() {
    let region = TrimRegion::new(&face(WIDE, Some(vec![circle([0.0, 0.0], 2.0)])), 0);
    let at = |p: [f64; 2], rad: f64| {
        let ball = |k: usize| Ball {
            mid: Dd::from(p[k]),
            rad,
        };
        region.side_of_ball([0, 1].map(ball))
    };
    for p in [[9.5, 0.5], [-9.5, 0.5], [0.5, 9.5], [0.5, -9.5]] {
        for rad in [0.5, 0.6, 1.0] {
            assert_eq!(at(p, rad), None, "{p:?} {rad}");
        }
        // Of what stays within it the side may be told, and is no other.
        assert_ne!(at(p, 0.25), Some(Side::Inside), "{p:?}");
        assert_eq!(at(p, 1e-20), Some(Side::Outside), "{p:?}");
    }
}

/// The same off sides along the axes that are no segments: rational quadratics whose points are all at one height.
#[test]
fn beside_flat_curves() {
    let corners = [[0.25, 0.5], [4.0, 0.5], [4.0, 3.0], [0.25, 3.0]];
    let sides = (0..4).map(|i| {
        let [a, b] = [corners[i], corners[(i + 1) % 4]];
        let middle = [0, 1].map(|k| 0.75 * a[k] + 0.25 * b[k]);
        let point = |p: [f64; 2], w: f64| [p[0] * w, p[1] * w, w];
        bezier(&[point(a, 1.0), point(middle, 2.0), point(b, 1.0)]).into()
    });
    let region = TrimRegion::new(&face(WIDE, Some(vec![sides.collect()])), 0);
    for (fixed, inward) in [
        ([2.0, 0.5], 1.0),
        ([4.0, 1.7], -1.0),
        ([2.0, 3.0], -1.0),
        ([0.25, 1.7], 1.0),
    ] {
        let across = usize::from(fixed[0] == 2.0);
        for off in [1e-17, 1e-22, 1e-27] {
            for (sign, expected) in [(inward, Side::Inside), (-inward, Side::Outside)] {
                let mut uv = fixed.map(Ball::exact);
                uv[across] = Ball {
                    mid: Dd::from(fixed[across]) + Dd::from(sign * off),
                    rad: off * 1e-3,
                };
                assert_eq!(region.side_of_ball(uv), Some(expected), "{fixed:?} {off:e}");
            }
        }
    }
}

/// Points next to the corners of triangles, a sharp one among them, where two sides count: inside is what is left of both.
#[test]
fn beside_a_corner() {
    for corners in [
        [[0.125, -0.3], [7.3, 1.1], [2.9, 6.7]],
        [[0.0, 0.0], [8.0, 0.0], [8.0, 3.0]],
        [[0.5, 0.25], [7.0, 0.5], [0.5, 0.625]],
    ] {
        let region = TrimRegion::new(&face(WIDE, Some(vec![polygon(&corners)])), 0);
        let mut told = [0; 2];
        for i in 0..3 {
            let [before, at, after] = [2, 0, 1].map(|k| corners[(i + k) % 3]);
            for step in 0..64 {
                // Dyadic, so that the offset is exact where it is scaled by powers of two.
                let turn = f64::from(step) * 0.098_174_770_424_681;
                let by = [turn.cos(), turn.sin()].map(|x| (x * 64.0).round() / 64.0);
                let left_of = |a: [f64; 2], b: [f64; 2]| {
                    let side = Dd::difference(b[0], a[0]) * Dd::from(by[1])
                        - Dd::difference(b[1], a[1]) * Dd::from(by[0]);
                    (side != Dd::ZERO).then_some(side > Dd::ZERO)
                };
                // A point beside the corner is left of a side's line where its offset is.
                let (Some(first), Some(second)) = (left_of(before, at), left_of(at, after)) else {
                    continue;
                };
                let expected = if first && second {
                    Side::Inside
                } else {
                    Side::Outside
                };
                for size in [2f64.powi(-50), 2f64.powi(-70), 2f64.powi(-88)] {
                    let uv = [0, 1].map(|k| Ball {
                        mid: Dd::from(at[k]) + Dd::from(size * by[k]),
                        rad: 1e-30,
                    });
                    let found = region.side_of_ball(uv);
                    assert!(
                        found.is_none_or(|side| side == expected),
                        "{corners:?} {i} {by:?} {size:e}: {found:?}"
                    );
                    told[usize::from(expected == Side::Inside)] += i32::from(found.is_some());
                }
            }
        }
        // Nearly all of 576: those next to a side's line at the least size are left, and where no f64 is in a narrow sector.
        assert!(told[0] > 420 && told[1] > 50, "{corners:?} {told:?}");
    }
}

/// Points next to where two quarters of a circle meet, one rising and one falling: the radius tells.
#[test]
fn beside_a_joint_of_arcs() {
    let region = TrimRegion::new(&face(WIDE, Some(vec![circle([0.0, 0.0], 5.0)])), 0);
    for (at, along) in [
        ([5.0, 0.0], [0.0, 1.0]),
        ([0.0, 5.0], [1.0, 0.0]),
        ([-5.0, 0.0], [0.0, 1.0]),
        ([0.0, -5.0], [1.0, 0.0]),
    ] {
        for (out, aside) in [
            (1e-20, 1e-12),
            (1e-24, -1e-14),
            (1e-26, 1e-26),
            (1e-26, 0.0),
        ] {
            for sign in [1.0, -1.0] {
                let uv = [0, 1].map(|k: usize| Ball {
                    mid: Dd::from(at[k])
                        + Dd::from(sign * out * at[k])
                        + Dd::from(aside * along[k]),
                    rad: 1e-30,
                });
                // |p|^2 - 25 is 50 out (1 + out / 2) + aside^2.
                let level = sign * 50.0 * out + aside * aside;
                let expected = if level > 0.0 {
                    Side::Outside
                } else {
                    Side::Inside
                };
                let found = region.side_of_ball(uv);
                assert!(
                    found.is_none_or(|side| side == expected),
                    "{at:?} {out:e} {aside:e} {sign}: {found:?}"
                );
                // The point at the same u (or v) as the joint is beyond no end and beside no quarter, as far as is known.
                assert!(
                    found.is_some() || aside == 0.0,
                    "{at:?} {out:e} {aside:e} {sign}"
                );
            }
        }
    }
}

/// Points off a circle by far less than f64 tells, along the whole of it.
#[test]
fn beside_an_arc() {
    // Its control points are f64, exactly.
    let center = [0.125, -0.25];
    let region = TrimRegion::new(&face(WIDE, Some(vec![circle(center, 5.0)])), 0);
    for i in 0..64 {
        // A rational parametrisation: (1 - m^2, 2 m) / (1 + m^2), to 1e-31.
        let m = Dd::from((f64::from(i) * 0.6180339887 + 0.013).sin() * 40.0);
        let norm = Dd::ONE + m * m;
        let on = [(Dd::ONE - m * m) / norm, (m + m) / norm];
        let at = |off: f64, rad: f64| {
            let r = Dd::from(5.0) + Dd::from(off);
            let point = |k: usize| Dd::from(center[k]) + r * on[k];
            region.side_of_ball([0, 1].map(|k| Ball { mid: point(k), rad }))
        };
        for off in [1e-14, 1e-17, 1e-22, 1e-26] {
            let rad = (off * 1e-3f64).clamp(1e-29, 1e-20);
            assert_eq!(at(-off, rad), Some(Side::Inside), "{i} {off:e}");
            assert_eq!(at(off, rad), Some(Side::Outside), "{i} {off:e}");
        }
        assert_eq!(at(0.0, 1e-29), None, "{i}");
        assert_eq!(at(1e-25, 1e-23), None, "{i}");
    }
}

#[test]
fn circle_with_rational_points() {
    // (3/5, 4/5) scaled by 5: exactly on the circle of radius 5.
    let region = TrimRegion::new(&face(WIDE, Some(vec![circle([0.0, 0.0], 5.0)])), 0);
    for (a, b) in [(3.0, 4.0), (4.0, 3.0), (5.0, 0.0), (0.0, 5.0)] {
        for (x, y) in [(a, b), (-a, b), (a, -b), (-a, -b)] {
            assert_eq!(side(&region, [x, y]), Side::Boundary, "{x} {y}");
            if x != 0.0 {
                let out = if x > 0.0 {
                    f64::next_up(x)
                } else {
                    f64::next_down(x)
                };
                let inn = if x > 0.0 {
                    f64::next_down(x)
                } else {
                    f64::next_up(x)
                };
                assert_eq!(side(&region, [out, y]), Side::Outside, "{x} {y}");
                assert_eq!(side(&region, [inn, y]), Side::Inside, "{x} {y}");
            }
            if y != 0.0 {
                let out = if y > 0.0 {
                    f64::next_up(y)
                } else {
                    f64::next_down(y)
                };
                assert_eq!(side(&region, [x, out]), Side::Outside, "{x} {y}");
            }
        }
    }
    let mut seed = 1u64;
    for _ in 0..20_000 {
        let q = [0, 1].map(|_| {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            ((seed >> 11) as f64 / (1u64 << 53) as f64) * 12.0 - 6.0
        });
        let r = q[0] * q[0] + q[1] * q[1];
        if (r - 25.0).abs() > 1e-10 {
            let expected = if r < 25.0 {
                Side::Inside
            } else {
                Side::Outside
            };
            assert_eq!(side(&region, q), expected, "{q:?}");
        }
    }
}

#[test]
fn untrimmed_empty_and_missing() {
    let all = TrimRegion::new(&face(WIDE, None), 0);
    assert_eq!(side(&all, [0.0, 0.0]), Side::Inside);
    assert_eq!(side(&all, [10.0, 0.0]), Side::Boundary);
    assert_eq!(side(&all, [10.5, 0.0]), Side::Outside);
    assert_eq!(all.pieces().len(), 4);
    assert_eq!(all.classify_box([-9.0, 9.0], [-9.0, 9.0]), BoxSide::Inside);
    assert_eq!(all.classify_box([-10.0, 9.0], [-9.0, 9.0]), BoxSide::Inside);
    assert_eq!(
        all.classify_box([10.5, 11.0], [-9.0, 9.0]),
        BoxSide::Outside
    );
    let none = TrimRegion::new(&face(WIDE, Some(vec![])), 0);
    assert_eq!(side(&none, [0.0, 0.0]), Side::Outside);
    assert_eq!(
        none.classify_box([-10.0, 9.0], [-9.0, 9.0]),
        BoxSide::Outside
    );
    assert_eq!(
        side(&TrimRegion::new(&face(WIDE, None), 7), [0.5, 0.5]),
        Side::Outside
    );
    assert_eq!(all.side([f64::NAN, 0.0].into()).side, None);
}

#[test]
fn native_arcs() {
    use crate::numeric::Interval;
    use crate::nurbs::{Arc, Curve};
    use nalgebra::{Point2, Vector2};
    let arc = |center: [f64; 2], radius: f64, x: [f64; 2], flip: bool, angle: [f64; 2]| {
        let y = if flip { [x[1], -x[0]] } else { [-x[1], x[0]] };
        let domain = Interval::new(angle[0], angle[1]).unwrap();
        Curve::Arc(
            Arc::new(Arc {
                center: Point2::from(center),
                x: Vector2::from(x),
                y: Vector2::from(y),
                z: Vector2::zeros(),
                radius,
                angle: domain,
                domain,
            })
            .unwrap(),
        )
    };
    let turn = std::f64::consts::TAU;
    for (x, flip, from) in [
        ([1.0, 0.0], false, 0.0),
        ([1.0, 0.0], true, 0.0),
        ([0.0, 2.0], false, 0.5),
        ([-1.0, 0.0], true, -1.0),
        ([0.6, 0.8], false, 0.25),
        ([-0.3, -0.7], true, 3.0),
    ] {
        let full = arc([0.0, 0.0], 5.0, x, flip, [from, from + turn]);
        let region = TrimRegion::new(&face(WIDE, Some(vec![vec![full.into()]])), 0);
        for (a, b) in [(3.0, 4.0), (4.0, 3.0)] {
            for (x, y) in [(a, b), (-a, b), (a, -b), (-a, -b)] {
                assert_eq!(side(&region, [x, y]), Side::Boundary, "{x} {y}");
                let (out, inn) = if x > 0.0 {
                    (f64::next_up(x), f64::next_down(x))
                } else {
                    (f64::next_down(x), f64::next_up(x))
                };
                assert_eq!(side(&region, [out, y]), Side::Outside, "{x} {y}");
                assert_eq!(side(&region, [inn, y]), Side::Inside, "{x} {y}");
            }
        }
        for i in 0..400 {
            for j in 0..400 {
                let q = [f64::from(i) * 0.0301 - 6.0, f64::from(j) * 0.0299 - 6.0];
                let inside = q[0] * q[0] + q[1] * q[1] < 25.0;
                let expected = if inside { Side::Inside } else { Side::Outside };
                assert_eq!(side(&region, q), expected, "{q:?}");
            }
        }
        // An image that needs no more than its pieces: every control point of every piece is
        // outside or on the circle, every end on it.
        for p in region.pieces() {
            let points = p.control_points();
            let ends = [points[0], points[points.len() - 1]];
            for e in ends {
                assert!((e[0].hypot(e[1]) / e[2] - 5.0).abs() < 1e-14);
            }
        }
    }
    // Two halves that meet at a point that is no f64: no gap, however near a point is. (From the suite `trim-loops`.) Where
    // the second ends, at 2 pi as a f64, it is 9.2e-17 below (0.875, 0.5), where the first starts: that is a gap.
    let halves = [[0.0, turn / 2.0], [turn / 2.0, turn]];
    let halves = halves.map(|angle| arc([0.5, 0.5], 0.375, [1.0, 0.0], false, angle).into());
    let region = TrimRegion::new(&face(WIDE, Some(vec![halves.into()])), 0);
    let about = |x: f64| [x, x.next_up(), x.next_down()];
    for x in about(0.125).into_iter().chain(about(0.875)) {
        for y in about(0.5) {
            let gap = x == 0.875 && y <= 0.5;
            assert_eq!(region.side([x, y].into()).in_gap, gap, "{x} {y}");
        }
    }
    // The other way up: the first starts 2.4e-16 and the second ends 1.2e-15 beside (4.0625, 0.6875), both below that, though by less than 1e-30: no
    // sine of a rational number but 0 is 1. (From a campaign on loops.)
    let halves = [
        [turn / 4.0, 3.0 * turn / 4.0],
        [3.0 * turn / 4.0, 5.0 * turn / 4.0],
    ];
    let halves = halves.map(|angle| arc([4.0625, -3.3125], 4.0, [1.0, 0.0], false, angle).into());
    let region = TrimRegion::new(
        &face([-32.0, 32.0, -32.0, 32.0], Some(vec![halves.into()])),
        0,
    );
    for x in about(4.0625) {
        for y in about(0.6875) {
            assert!(!region.side([x, y].into()).in_gap, "{x} {y}");
        }
    }
    // A gap that is one: the arc ends at (cos 3, sin 3), the chord starts at (-0.9, 0).
    let open = vec![
        arc([0.0, 0.0], 1.0, [1.0, 0.0], false, [0.0, 3.0]).into(),
        line([-0.9, 0.0], [1.0, 0.0]).into(),
    ];
    let region = TrimRegion::new(&face(WIDE, Some(vec![open])), 0);
    for (x, y, gap) in [
        (-0.95, 0.1, true),
        (-0.9, 0.0, true),
        (-0.995, 0.1, false),
        (-0.95, 0.15, false),
    ] {
        assert_eq!(region.side([x, y].into()).in_gap, gap, "{x} {y}");
    }
    // Half a disc: an arc and its chord.
    for flip in [false, true] {
        let half = arc([1.0, 0.5], 2.0, [1.0, 0.0], flip, [0.0, turn / 2.0]);
        let region = TrimRegion::new(
            &face(
                WIDE,
                Some(vec![vec![
                    half.into(),
                    line([-1.0, 0.5], [3.0, 0.5]).into(),
                ]]),
            ),
            0,
        );
        for i in 0..200 {
            for j in 0..200 {
                let q = [f64::from(i) * 0.0301 - 2.0, f64::from(j) * 0.0299 - 3.0];
                let above = if flip { q[1] < 0.5 } else { q[1] > 0.5 };
                let inside = (q[0] - 1.0).powi(2) + (q[1] - 0.5).powi(2) < 4.0 && above;
                let expected = if inside { Side::Inside } else { Side::Outside };
                assert_eq!(side(&region, q), expected, "{q:?} {flip}");
            }
        }
        assert_eq!(side(&region, [3.0, 0.5]), Side::Boundary);
        assert_eq!(side(&region, [0.0, 0.5]), Side::Boundary);
        assert_eq!(
            side(&region, [1.0, if flip { -1.5 } else { 2.5 }]),
            Side::Boundary
        );
    }
}

#[test]
fn a_gap_is_the_whole_box_of_its_ends() {
    let ends = [[0.0, -4.0], [4.0, 0.0]];
    let sides = [
        ([-4.0, -4.0], ends[0]),
        (ends[1], [4.0, 4.0]),
        ([4.0, 4.0], [-4.0, 4.0]),
        ([-4.0, 4.0], [-4.0, -4.0]),
    ];
    let open = sides.map(|(a, b)| line(a, b).into()).into();
    let region = TrimRegion::new(&face(WIDE, Some(vec![open])), 0);
    for i in -18..=18 {
        for j in -18..=18 {
            let q = [f64::from(i) / 4.0, f64::from(j) / 4.0];
            let expected = (0..2).all(|k| (ends[0][k]..=ends[1][k]).contains(&q[k]));
            assert_eq!(region.side(q.into()).in_gap, expected, "{q:?}");
        }
    }
}
