//! Loops that cross, touch or overlap, and areas: against what is known of them.

use super::shapes::*;
use crate::numeric::{Enclosure, Interval};
use crate::nurbs::{Arc, Curve, Curve2};
use crate::trim::{Meeting, MeetingKind, TrimRegion};
use nalgebra::Vector2;
use proptest::prelude::*;
use std::f64::consts::PI;

const WIDE: [f64; 4] = [-10.0, 10.0, -10.0, 10.0];

fn meetings(loops: Vec<Vec<Use>>) -> Vec<Meeting> {
    let found = TrimRegion::new(&face(WIDE, Some(loops)), 0).meetings();
    assert_eq!(found.more, 0);
    found.found
}

fn kinds(loops: Vec<Vec<Use>>) -> Vec<MeetingKind> {
    meetings(loops).iter().map(|m| m.kind).collect()
}

fn holds(m: &Meeting, p: [f64; 2]) -> bool {
    (0..2).all(|k| m.place[k][0] <= p[k] && p[k] <= m.place[k][1])
}

#[test]
fn loops_that_keep_clear() {
    // A needle: its sides are at 2^-40 of each other's direction.
    let needle = [
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 0.5],
        [0.5, 0.25 + 1.0 / (1u64 << 40) as f64],
    ];
    let apart = 1.0 - 1.0 / f64::from(1 << 20);
    for loops in [
        vec![polygon(&L_SHAPE)],
        vec![polygon(&needle)],
        vec![circle([0.0, 0.0], 1.0)],
        // Beside each other, in each other, and a millionth apart all round.
        vec![circle([0.0, 0.0], 1.0), circle([3.0, 0.0], 1.0)],
        vec![circle([0.0, 0.0], 1.0), circle([0.25, 0.0], 0.5)],
        vec![circle([0.0, 0.0], 1.0), circle([0.0, 0.0], apart)],
        // A sickle: two arcs that leave one point at an angle.
        vec![vec![
            bezier(&[[0.0, 0.0, 1.0], [1.0, 2.0, 1.0], [2.0, 0.0, 1.0]]).into(),
            bezier(&[[2.0, 0.0, 1.0], [1.0, 1.5, 1.0], [0.0, 0.0, 1.0]]).into(),
        ]],
    ] {
        assert_eq!(meetings(loops), []);
    }
}

#[test]
fn crossings() {
    // A bow tie: y = x and y = 1 - x.
    let tie = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    let found = meetings(vec![polygon(&tie)]);
    assert_eq!(found.len(), 1);
    assert_eq!(
        (found[0].kind, found[0].trims),
        (MeetingKind::Crossing, [0, 2])
    );
    assert!(holds(&found[0], [0.5, 0.5]) && !found[0].at_gap);

    // Unit circles, one unit apart: at (1/2, +-sqrt(3)/2).
    let found = meetings(vec![circle([0.0, 0.0], 1.0), circle([1.0, 0.0], 1.0)]);
    assert_eq!(found.len(), 2);
    for (m, v) in found.iter().zip([0.75f64.sqrt(), -(0.75f64.sqrt())]) {
        assert_eq!((m.kind, m.loops), (MeetingKind::Crossing, [0, 1]));
        assert!(holds(m, [0.5, v]), "{m:?}");
    }

    // A cubic with a loop in it, which is symmetric about u = 1/2: u(t) = 6t - 15t^2 + 10t^3 = 1/2 = u(1 - t) besides at t = 1/2 where
    // 10 s^2 = 3/2 for s = t - 1/2; v = 3 t (1 - t) = 3 (1/4 - 3/20) = 3/10.
    let curl = [
        [0.0, 0.0, 1.0],
        [2.0, 1.0, 1.0],
        [-1.0, 1.0, 1.0],
        [1.0, 0.0, 1.0],
    ];
    let found = meetings(vec![vec![
        bezier(&curl).into(),
        line([1.0, 0.0], [0.0, 0.0]).into(),
    ]]);
    assert_eq!(found.len(), 1);
    assert_eq!(
        (found[0].kind, found[0].trims),
        (MeetingKind::Crossing, [0, 0])
    );
    assert!(holds(&found[0], [0.5, 0.3]), "{found:?}");
}

#[test]
fn touches_and_overlaps() {
    let touch = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    assert_eq!(kinds(vec![polygon(&touch)]), [MeetingKind::Touch; 2]);
    let spur = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    // The spur itself, and the side that starts where it ends, on it.
    assert_eq!(
        kinds(vec![polygon(&spur)]),
        [MeetingKind::Overlap, MeetingKind::Touch]
    );
    // Circles within each other that touch where both have an end.
    let found = kinds(vec![circle([0.0, 0.0], 1.0), circle([0.5, 0.0], 0.5)]);
    assert!(!found.is_empty() && found.iter().all(|k| *k == MeetingKind::Touch));
}

#[test]
fn what_cannot_be_told() {
    // Circles that touch at (3/5, 4/5), where neither ends.
    let found = meetings(vec![circle([0.0, 0.0], 1.0), circle([0.3, 0.4], 0.5)]);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].kind, MeetingKind::Undecided);
    let near = |x: f64, r: [f64; 2]| r[0] - 1e-6 <= x && x <= r[1] + 1e-6;
    assert!(near(0.6, found[0].place[0]) && near(0.8, found[0].place[1]));
    // A cusp: u' = 3 (1 - 2t)^2 and v' = 3 (1 - 2t).
    let cusp = [
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
        [1.0, 0.0, 1.0],
    ];
    let found = kinds(vec![vec![
        bezier(&cusp).into(),
        line([1.0, 0.0], [0.0, 0.0]).into(),
    ]]);
    assert!(found.iter().all(|k| *k == MeetingKind::Undecided));
    // The same loop twice.
    let twice = kinds(vec![circle([0.0, 0.0], 1.0), circle([0.0, 0.0], 1.0)]);
    assert!(twice.len() >= 4 && !twice.contains(&MeetingKind::Crossing));
}

#[test]
fn crossings_that_a_gap_makes() {
    // The last side stops beyond the first: the segment that joins them goes back across nothing, but the two cross.
    let open = vec![
        line([0.0, 0.0], [1.0, 0.0]).into(),
        line([1.0, 0.0], [1.0, 1.0]).into(),
        line([1.0, 1.0], [0.25, -0.125]).into(),
    ];
    let found = meetings(vec![open]);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        (found[0].kind, found[0].trims),
        (MeetingKind::Crossing, [0, 2])
    );
    assert!(found[0].at_gap);
}

#[test]
fn areas() {
    let area = |l: Vec<Use>| TrimRegion::new(&face(WIDE, Some(vec![l])), 0).loop_area(0);
    let check = |found: Enclosure, is: f64| {
        assert!(found.contains(is), "{found:?} {is}");
        assert!(found.width() <= is.abs() / 16384.0, "{found:?}");
    };
    check(area(circle([3.0, -2.0], 0.5)), 0.25 * PI);
    let mut clockwise = circle([3.0, -2.0], 0.5);
    clockwise.reverse();
    for u in &mut clockwise {
        u.reversed = true;
    }
    check(area(clockwise), -0.25 * PI);
    check(area(polygon(&[[0.0, 0.0], [3.0, 0.0], [0.0, 1.0]])), 1.5);
    // A parabola of height 1 over a base of 2, run through to the right: clockwise.
    let cap = vec![
        bezier(&[[0.0, 0.0, 1.0], [1.0, 2.0, 1.0], [2.0, 0.0, 1.0]]).into(),
        line([2.0, 0.0], [0.0, 0.0]).into(),
    ];
    check(area(cap), -4.0 / 3.0);
    // Equal triangles run around in opposite directions: the sign is not known.
    let tie = area(polygon(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]));
    assert!(tie.contains(0.0) && tie.width() < 1e-12);
    // With a gap, the segment that closes it counts: a square without its last side.
    let open = polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    check(area(open.into_iter().take(3).collect()), 1.0);
    assert_eq!(
        TrimRegion::new(&face(WIDE, None), 0).loop_area(0),
        Enclosure::UNKNOWN
    );
}

fn turn(p: [i64; 2], q: [i64; 2], r: [i64; 2]) -> i64 {
    ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).signum()
}

fn is_on(p: [i64; 2], [a, b]: [[i64; 2]; 2]) -> bool {
    turn(a, b, p) == 0 && (0..2).all(|k| a[k].min(b[k]) <= p[k] && p[k] <= a[k].max(b[k]))
}

/// Whether two segments with small integer ends meet: `None`, at one point, or along more. By the textbook, in integers.
fn meet(a: [[i64; 2]; 2], b: [[i64; 2]; 2]) -> Option<bool> {
    let [c, d] = [turn(a[0], a[1], b[0]), turn(a[0], a[1], b[1])];
    if c == 0 && d == 0 {
        let along = |k: usize| {
            let lo = a[0][k].min(a[1][k]).max(b[0][k].min(b[1][k]));
            let hi = a[0][k].max(a[1][k]).min(b[0][k].max(b[1][k]));
            hi - lo
        };
        let (x, y) = (along(0), along(1));
        return (x >= 0 && y >= 0).then_some(x > 0 || y > 0);
    }
    let [e, f] = [turn(b[0], b[1], a[0]), turn(b[0], b[1], a[1])];
    (c * d <= 0 && e * f <= 0).then_some(false)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Polygons with corners on a coarse grid, where everything happens; as segments, and raised to curves of degree 2.
    #[test]
    fn polygons_as_by_integers(corners in prop::collection::vec([0i64..5, 0i64..5], 3..8)) {
        let n = corners.len();
        let sides: Vec<_> = (0..n).map(|i| [corners[i], corners[(i + 1) % n]]).collect();
        prop_assume!(sides.iter().all(|s| s[0] != s[1]));
        let mut expected = Vec::new();
        for i in 0..n {
            for k in i + 1..n {
                let neighbours = k == i + 1 || (i == 0 && k == n - 1);
                match meet(sides[i], sides[k]) {
                    Some(true) => expected.push(([i, k], MeetingKind::Overlap)),
                    Some(false) if !neighbours => {
                        let ends = |a: [[i64; 2]; 2], b| a.iter().any(|p| is_on(*p, b));
                        let touch = ends(sides[i], sides[k]) || ends(sides[k], sides[i]);
                        let kind = if touch { MeetingKind::Touch } else { MeetingKind::Crossing };
                        expected.push(([i, k], kind));
                    }
                    _ => {}
                }
            }
        }
        let real = |p: [i64; 2]| p.map(|x| x as f64);
        let points: Vec<[f64; 2]> = corners.iter().map(|p| real(*p)).collect();
        let found = meetings(vec![polygon(&points)]);
        let mut found: Vec<_> = found.iter().map(|m| (m.trims, m.kind)).collect();
        found.sort();
        prop_assert_eq!(&found, &expected);

        let raised = sides.iter().map(|s| {
            let [a, b] = s.map(real);
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 1.0];
            bezier(&[[a[0], a[1], 1.0], middle, [b[0], b[1], 1.0]]).into()
        });
        let found = meetings(vec![raised.collect()]);
        // Nothing missed, nothing made up; what is exact for segments may be undecided here.
        for m in &found {
            let there = expected.iter().find(|e| e.0 == m.trims);
            prop_assert!(there.is_some(), "{m:?}");
            let is = there.map(|e| e.1);
            prop_assert!(m.kind == MeetingKind::Undecided || Some(m.kind) == is
                || (m.kind == MeetingKind::Touch && is == Some(MeetingKind::Overlap)), "{m:?} {is:?}");
            if is == Some(MeetingKind::Crossing) {
                prop_assert_eq!(m.kind, MeetingKind::Crossing);
            }
        }
        for e in &expected {
            prop_assert!(found.iter().any(|m| m.trims == e.0), "{e:?}");
        }
    }
}

/// A loop of two trims that meet between their ends, too: an S and its chord.
#[test]
fn two_trims_that_cross() {
    let s = [[0.0, 0.0], [0.5, 1.0], [1.5, -1.0], [2.0, 0.0]].map(|[u, v]| [u, v, 1.0]);
    for back in [
        line([2.0, 0.0], [0.0, 0.0]),
        bezier(&[[2.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]]),
    ] {
        let found = meetings(vec![vec![bezier(&s).into(), back.into()]]);
        assert!(found.iter().any(|m| holds(m, [1.0, 0.0])), "{found:?}");
    }
}

/// The cap of a circle of radius 5 over two radians, run through clockwise on an arc whose ends are on no axis: r^2 / 2 (a - sin a).
#[test]
fn area_of_a_clockwise_cap() {
    let angle = Interval::new(-2.5, -2.5 + 2.0).unwrap();
    let arc: Curve2 = Curve::Arc(
        Arc::new(Arc {
            center: [1.0, -2.0].into(),
            x: [1.0, 0.0].into(),
            y: [0.0, -1.0].into(),
            z: Vector2::zeros(),
            radius: 5.0,
            angle,
            domain: angle,
        })
        .unwrap(),
    );
    let ends = [angle.start, angle.end].map(|t| <[f64; 2]>::from(arc.point(t).coords));
    for reversed in [false, true] {
        let cap = vec![
            Use {
                curve: arc.clone(),
                span: None,
                reversed,
            },
            if reversed {
                line(ends[0], ends[1]).into()
            } else {
                line(ends[1], ends[0]).into()
            },
        ];
        let found = TrimRegion::new(&face(WIDE, Some(vec![cap])), 0).loop_area(0);
        let is = 12.5 * (2.0 - 2f64.sin()) * if reversed { 1.0 } else { -1.0 };
        assert!(found.contains(is), "{found:?} {is}");
        assert!(found.width() < is.abs() / 1024.0, "{found:?}");
    }
}
