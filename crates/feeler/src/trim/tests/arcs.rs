//! Sides about native arcs: at any pace, and nearer than double-double tells.

use super::shapes::*;
use crate::numeric::{Dd, Interval};
use crate::nurbs::{Arc, Curve, Curve2};
use crate::trim::{BoxSide, Side, TrimRegion};
use nalgebra::Vector2;

const WIDE: [f64; 4] = [-10.0, 10.0, -10.0, 10.0];

fn side(region: &TrimRegion, q: [f64; 2]) -> Side {
    region.side(q.into()).side.unwrap()
}

fn arc_over(
    center: [f64; 2],
    radius: f64,
    [x, y]: [[f64; 2]; 2],
    angle: [f64; 2],
    domain: [f64; 2],
) -> Curve2 {
    let interval = |i: [f64; 2]| Interval::new(i[0], i[1]).unwrap();
    let arc = Arc {
        center: center.into(),
        x: x.into(),
        y: y.into(),
        z: Vector2::zeros(),
        radius,
        angle: interval(angle),
        domain: interval(domain),
    };
    Curve::Arc(Arc::new(arc).unwrap())
}

/// `(1 - 2^-53)^2 + 2^-52 = 1 + 2^-106`: farther out than the unit circle by less than double-double tells; the f64 below is as little within.
#[test]
fn beside_an_arc_by_the_last_digits() {
    let (near, small) = (1.0 - 2f64.powi(-53), 2f64.powi(-26));
    let turn = |k: usize, [x, y]: [f64; 2]| match k {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    };
    for k in 0..4 {
        for flip in [false, true] {
            // A sector about each axis, of two pieces of an arc whose outer ends are no f64.
            let [x, y] = [turn(k, [1.0, 0.0]), turn(k, [0.0, 1.0])];
            let y = if flip { y.map(|c| -c) } else { y };
            let arc = arc_over([0.0, 0.0], 1.0, [x, y], [-0.5, 0.5], [3.0, 4.0]);
            let [from, to] = [3.0, 4.0].map(|t| <[f64; 2]>::from(arc.point(t).coords));
            let sides = vec![
                arc.into(),
                line(to, [0.0, 0.0]).into(),
                line([0.0, 0.0], from).into(),
            ];
            let region = TrimRegion::new(&face(WIDE, Some(vec![sides])), 0);
            for sign in [1.0, -1.0] {
                for (y, expected) in [
                    (small, Side::Outside),
                    (small.next_down(), Side::Inside),
                    (small.next_up(), Side::Outside),
                ] {
                    let q = turn(k, [near, sign * y]);
                    assert_eq!(side(&region, q), expected, "{k} {flip} {q:?}");
                }
            }
        }
    }
}

/// A whole circle as a file has it: from angle 0 to 2 pi in f64, which is less, so that a segment joins its ends, of which one is known in an enclosure and the other is centre and
/// radius, exactly, mostly no f64. At the very height of the centre the circle is passed at that: what is nearer to the centre is inside, by however little.
#[test]
fn at_the_height_of_a_joint() {
    let mut counts = [0; 3];
    for (center, radius) in [
        ([0.5, 0.5], 0.46),
        ([0.5, 0.5], 0.39),
        ([0.1, -0.7], 0.3),
        ([1.0 / 3.0, 0.1], 1.0 / 7.0),
        ([-2.5, 3.0], 1.25),
    ] {
        let axes = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0f64]];
        for (k, x) in axes.into_iter().enumerate() {
            for y in [axes[(k + 1) % 4], axes[(k + 3) % 4]] {
                let whole = [0.0, std::f64::consts::TAU];
                let circle = arc_over(center, radius, [x, y], whole, [0.0, 1.0]);
                let region = TrimRegion::new(&face(WIDE, Some(vec![vec![circle.into()]])), 0);
                let (i, sign) = (k % 2, x[k % 2]);
                let near = center[i] + sign * radius;
                let mut tried = vec![0.5 * (center[i] + near), near + sign];
                let (mut low, mut high) = (near, near);
                for _ in 0..4 {
                    tried.extend([low, high]);
                    (low, high) = (low.next_down(), high.next_up());
                }
                for at in tried {
                    let mut q = center;
                    q[i] = at;
                    let off = Dd::difference(at, center[i]) * Dd::from(sign) - Dd::from(radius);
                    let (expected, count) = if off < Dd::ZERO {
                        (Side::Inside, 0)
                    } else if off > Dd::ZERO {
                        (Side::Outside, 1)
                    } else {
                        (Side::Boundary, 2)
                    };
                    counts[count] += 1;
                    assert_eq!(side(&region, q), expected, "{center:?} {x:?} {y:?} {at}");
                }
            }
        }
    }
    assert!(counts.iter().all(|n| *n >= 8), "{counts:?}");
}

/// Circles and sectors whose parameter moves at another pace than the angle, and whose arcs begin or end at angle 0, on an axis.
#[test]
fn arcs_at_any_pace() {
    let ccw = [[1.0, 0.0], [0.0, 1.0]];
    let cw = [[1.0, 0.0], [0.0, -1.0]];
    let check = |loops: Vec<Use>, holds: &dyn Fn(f64, f64) -> bool, what: &str| {
        let region = TrimRegion::new(&face(WIDE, Some(vec![loops])), 0);
        for i in 0..60 {
            for j in 0..60 {
                let q = [f64::from(i) * 0.203 - 6.0, f64::from(j) * 0.199 - 6.0];
                let expected = if holds(q[0], q[1]) {
                    Side::Inside
                } else {
                    Side::Outside
                };
                assert_eq!(side(&region, q), expected, "{what} {q:?}");
            }
        }
        region
    };
    let disc = |x: f64, y: f64| x * x + y * y < 25.0;
    for frame in [ccw, cw] {
        for domain in [[0.0, 0.5], [1.0, 2.0], [-7.0, 3.0]] {
            for start in [0.0, 0.3, -2.0] {
                let angle = [start, start + std::f64::consts::TAU];
                let whole = arc_over([0.0, 0.0], 5.0, frame, angle, domain);
                check(vec![whole.into()], &disc, "whole");
            }
        }
        // A part of an arc: from angle 0.5 to 2.5, of a domain in which a unit is half a radian.
        let whole = arc_over([0.0, 0.0], 5.0, frame, [0.0, 4.0], [1.0, 9.0]);
        let [from, to] = [2.0, 6.0].map(|t| <[f64; 2]>::from(whole.point(t).coords));
        let cut = Use {
            curve: whole,
            span: Some([2.0, 6.0]),
            reversed: false,
        };
        let sides = vec![
            cut,
            line(to, [0.0, 0.0]).into(),
            line([0.0, 0.0], from).into(),
        ];
        let up = frame[1][1];
        let holds = |x: f64, y: f64| disc(x, y) && (0.5..2.5).contains(&(up * y).atan2(x));
        check(sides, &holds, "cut");
        // Three quadrants' worth less a little: from angle -4 to 0, or 0 to 4.
        for (angle, up) in [([-4.0, 0.0], 1.0), ([0.0, 4.0], -1.0)] {
            let up = up * frame[1][1];
            let arc = arc_over([0.0, 0.0], 5.0, frame, angle, [0.0, 0.5]);
            let [from, to] = [0.0, 0.5].map(|t| <[f64; 2]>::from(arc.point(t).coords));
            let sides = vec![
                arc.into(),
                line(to, [0.0, 0.0]).into(),
                line([0.0, 0.0], from).into(),
            ];
            // What is missing is the sector of the remaining angle, on the other side of the first axis.
            let missing = std::f64::consts::TAU - 4.0;
            let holds = |x: f64, y: f64| {
                let angle = (up * y).atan2(x).rem_euclid(std::f64::consts::TAU);
                disc(x, y) && angle > missing
            };
            // A point of the circle, but not of the arc.
            let region = check(sides, &holds, "sector");
            assert_eq!(side(&region, [3.0, up * 4.0]), Side::Outside);
        }
    }
}

/// Arcs of a circle whose top is 2^-54 below 1, which is no f64, and of one whose top is there, cut beside their tops and whole quadrants about
/// them: whether a segment at 1 is beside them.
#[test]
fn a_side_that_an_arc_hardly_reaches() {
    for (radius, expected) in [
        (0.5 - 2f64.powi(-54), BoxSide::Outside),
        (0.5, BoxSide::Mixed),
    ] {
        for angle in [[1.0, 2.0], [0.0, 4.0]] {
            let frame = [[1.0, 0.0], [0.0, 1.0]];
            let arc = arc_over([0.5, 0.5], radius, frame, angle, angle);
            let [from, to] = angle.map(|t: f64| [0.5 + radius * t.cos(), 0.5 + radius * t.sin()]);
            let cap = vec![arc.into(), line(to, from).into()];
            let region = TrimRegion::new(&face([0.0, 1.0, 0.0, 1.0], Some(vec![cap])), 0);
            let side = region.classify_box([0.0, 1.0], [1.0, 1.0]);
            assert_eq!(side, expected, "{radius} {angle:?}");
        }
    }
}

/// Arcs that start within what can be told of an axis, and in truth before it: the circle's extreme is on them, whatever their ends are.
#[test]
fn an_extreme_next_to_an_arcs_end() {
    let frame = [[1.0, 0.0], [0.0, 1.0]];
    let center = [0.5, 0.5];
    // 1e-310 below 0; and 2.4e-32 below a quarter turn, where no f64 is.
    let right = arc_over(center, 0.5, frame, [-1e-310, 1.0], [-1e-310, 1.0]);
    let whole = 7_811_196_678_737_964.0;
    let top = Use {
        curve: arc_over(center, 0.5, frame, [0.0, 2.0], [0.0, whole]),
        span: Some([6_134_899_525_417_045.0, whole]),
        reversed: false,
    };
    let below = 1f64.next_down();
    let on = |a: f64| [0.5 + 0.5 * a.cos(), 0.5 + 0.5 * a.sin()];
    for (arc, to, from, extreme) in [
        (right.into(), on(1.0), [below, 0.5], [1.0, 0.5]),
        (top, on(2.0), [0.5, below], [0.5, 1.0]),
    ] {
        let cap = vec![arc, line(to, from).into()];
        let region = TrimRegion::new(&face([0.0, 1.5, 0.0, 1.5], Some(vec![cap])), 0);
        let side = region.side(extreme.into()).side;
        assert_ne!(side, Some(Side::Outside), "{extreme:?}");
        assert_ne!(side, Some(Side::Inside), "{extreme:?}");
        let all = extreme.map(|x| if x == 1.0 { [x, x] } else { [0.0, 1.5] });
        let box_side = region.classify_box(all[0], all[1]);
        assert_eq!(box_side, BoxSide::Mixed, "{extreme:?}");
        // Elsewhere on the line that touches the circle there.
        for off in [-0.04, 0.04] {
            let q = extreme.map(|x| if x == 1.0 { x } else { x + off });
            let side = region.side(q.into()).side;
            assert_eq!(side, Some(Side::Outside), "{q:?}");
        }
    }
}
