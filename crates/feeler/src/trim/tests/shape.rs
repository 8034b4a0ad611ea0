//! What regions are recognised as, and that it changes no answer.

use super::shapes::*;
use crate::trim::{BoxSide, RegionShape, Side, TrimRegion};
use proptest::prelude::*;

const WIDE: [f64; 4] = [-10.0, 10.0, -10.0, 10.0];

fn shape(loops: Vec<Vec<Use>>) -> RegionShape {
    TrimRegion::new(&face(WIDE, Some(loops)), 0).shape()
}

#[test]
fn rectangles() {
    let unit = RegionShape::Rectangle([[0.0, 1.0], [0.0, 1.0]]);
    let mut corners = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for _ in 0..4 {
        assert_eq!(shape(vec![polygon(&corners)]), unit);
        corners.rotate_left(1);
    }
    corners.reverse();
    assert_eq!(shape(vec![polygon(&corners)]), unit);
    // With a point on a side, and a side that is a spline.
    let more = [[0.0, 0.0], [0.25, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    assert_eq!(shape(vec![polygon(&more)]), unit);
    let mut mixed = polygon(&more[..4]);
    mixed.pop();
    mixed.push(bezier(&[[1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]).into());
    mixed.push(line([0.0, 1.0], [0.0, 0.0]).into());
    assert_eq!(shape(vec![mixed]), unit);
}

#[test]
fn polygons_that_are_convex() {
    let pentagon = [[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [1.0, 2.0], [0.0, 1.0]];
    assert_eq!(
        shape(vec![polygon(&pentagon)]),
        RegionShape::ConvexPolygon(5)
    );
    let sheared = [[0.0, 0.0], [2.0, 0.5], [2.5, 3.0], [0.5, 2.5]];
    assert_eq!(
        shape(vec![polygon(&sheared)]),
        RegionShape::ConvexPolygon(4)
    );
}

#[test]
fn what_is_neither() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let twice: Vec<_> = square.iter().chain(&square).copied().collect();
    let eight = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    let spur = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let flat = [[0.0, 0.0], [1.0, 0.0]];
    // Turns left five times, but twice around.
    let pentagram = [
        [0.0, 3.0],
        [-2.0, -3.0],
        [3.0, 1.0],
        [-3.0, 1.0],
        [2.0, -3.0],
    ];
    for corners in [&twice[..], &eight, &L_SHAPE, &spur, &flat, &pentagram] {
        let n = corners.len();
        assert_eq!(
            shape(vec![polygon(corners)]),
            RegionShape::General(n),
            "{corners:?}"
        );
    }
    let hole = [[0.2, 0.2], [0.2, 0.8], [0.8, 0.8], [0.8, 0.2]];
    let two = vec![polygon(&square), polygon(&hole)];
    assert_eq!(shape(two), RegionShape::General(8));
    // Sides that do not meet are joined.
    let mut gap = polygon(&square);
    gap[1] = line([1.0, 1e-9], [1.0, 1.0]).into();
    assert_eq!(shape(vec![gap]), RegionShape::General(5));
    // What leaves the domain has parts of the domain's border.
    let out = TrimRegion::new(&face([0.0, 0.5, 0.0, 1.0], Some(vec![polygon(&square)])), 0);
    assert_eq!(out.shape(), RegionShape::General(8));
    let round = vec![circle([0.0, 0.0], 1.0)];
    assert_eq!(shape(round), RegionShape::General(4));
    assert_eq!(shape(vec![]), RegionShape::Nothing);
    let whole = TrimRegion::new(&face(WIDE, None), 0);
    assert_eq!(whole.shape(), RegionShape::Whole);
}

proptest! {
    /// Points and boxes on a coarse grid, so that many are on sides and corners; half of the rectangles share sides with the
    /// domain.
    #[test]
    fn rectangles_answer_as_any_loop(
        r in (0i32..3, 4i32..8, 0i32..3, 4i32..8),
        domain in (-1i32..=0, 8i32..=9, -1i32..=0, 8i32..=9),
        way in any::<bool>(),
        q in (-4i32..36, -4i32..36),
        size in (0i32..20, 0i32..20),
    ) {
        let (a, b, c, d) = (f64::from(r.0), f64::from(r.1), f64::from(r.2), f64::from(r.3));
        let mut corners = [[a, c], [b, c], [b, d], [a, d]];
        if way {
            corners.reverse();
        }
        let touch = |x: i32, side: f64, far: i32| if x == 0 || x == 8 { side } else { f64::from(far) };
        let domain = [
            touch(domain.0, a, -1),
            touch(domain.1, b, 9),
            touch(domain.2, c, -1),
            touch(domain.3, d, 9),
        ];
        let brep = face(domain, Some(vec![polygon(&corners)]));
        let quick = TrimRegion::new(&brep, 0);
        let plain = TrimRegion::with_cells(&brep, 0, false);
        prop_assert_eq!(quick.shape(), RegionShape::Rectangle([[a, b], [c, d]]));
        prop_assert!(matches!(plain.shape(), RegionShape::ConvexPolygon(4)));
        let q = [f64::from(q.0) / 4.0, f64::from(q.1) / 4.0];
        prop_assert_eq!(quick.side(q.into()), plain.side(q.into()));
        let end = [q[0] + f64::from(size.0) / 4.0, q[1] + f64::from(size.1) / 4.0];
        let (u, v) = ([q[0], end[0]], [q[1], end[1]]);
        let (fast, slow) = (quick.classify_box(u, v), plain.classify_box(u, v));
        // Both are proven, and the general one gives up where a loop comes near.
        if slow != BoxSide::Mixed {
            prop_assert_eq!(fast, slow);
        }
        for (i, j) in (0..=8).flat_map(|i| (0..=8).map(move |j| (i, j))) {
            let at = |k: usize, s: i32| q[k] + (end[k] - q[k]) * f64::from(s) / 8.0;
            let p = [at(0, i), at(1, j)];
            let side = plain.side(p.into()).side;
            let beyond = p[0] < domain[0] || p[0] > domain[1] || p[1] < domain[2] || p[1] > domain[3];
            match fast {
                BoxSide::Outside => prop_assert_eq!(side, Some(Side::Outside)),
                BoxSide::Inside => prop_assert!(beyond || side != Some(Side::Outside)),
                BoxSide::Mixed => {}
            }
        }
    }
}
