//! How what is low lies about feet of half-spaces, against analysis.

use super::super::tests::bowl;
use super::*;
use crate::brep::BrepBuilder;

const REACH: f64 = 1.0 / 4096.0;

/// From the foot of a half-space at a place.
fn lies(brep: &PreparedBrep, normal: [f64; 3], at: Spot, trim: Option<usize>, slack: f64) -> Lies {
    let objective = Objective::Height(normal.into(), 0.0);
    let foot = point(brep, at);
    let level = Level {
        brep,
        objective: &objective,
        foot,
        limit: Vector3::from(normal).dot(&foot.coords) + slack,
        slack,
        reach: REACH,
    };
    level.from(at, trim, false)
}

/// `z = x^2 + y^2` over its lowest point is `r^2` high at `r`: plainly more than is low where that is less than half of it at the reach, and low that far where it is all of
/// that a little beyond.
#[test]
fn the_bottom_of_a_bowl() {
    let at = Spot {
        face: 0,
        uv: [0.0, 0.0].into(),
    };
    // Where is looked, more or less.
    let [low, high] = [1.0, BEYOND * (1.0 + 2.0 * ASIDE)].map(|x| (x * REACH).powi(2));
    for (slack, expected) in [
        (0.001 * low, Lies::Near),
        (0.49 * low, Lies::Near),
        (0.9 * low, Lies::Open),
        (1.01 * high, Lies::Far),
    ] {
        assert_eq!(
            lies(&bowl(0.25), [0.0, 0.0, 1.0], at, None, slack),
            expected,
            "{slack}"
        );
    }
}

/// A triangle with its right angle at the origin, and legs of 1 along x and y: half-spaces that touch it at one corner, where the plane is lower beyond the triangle, along an edge, or
/// everywhere; and those that lean by so little that it makes no difference.
#[test]
fn a_triangle() {
    const SLACK: f64 = 1.0 / (1u64 << 30) as f64;
    /// Over the reach less than a slack by far.
    const LITTLE: f64 = SLACK;
    let mut b = BrepBuilder::new();
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let ids = corners.map(|[x, y]| b.vertex([x, y, 0.0]));
    b.planar_face(&ids).unwrap();
    let brep = PreparedBrep::new(b.build().unwrap());
    for (normal, corner, expected) in [
        ([0.6, 0.48, 0.64], 0, Lies::Near),
        ([-0.6, -0.48, 0.64], 1, Lies::Near),
        ([-0.48, -0.6, 0.64], 2, Lies::Near),
        ([-0.6, 0.0, 0.8], 1, Lies::Near),
        ([-0.6, -0.6 + LITTLE, 0.64], 1, Lies::Far),
        ([0.6, 0.0, 0.8], 0, Lies::Far),
        ([0.6, LITTLE, 0.8], 0, Lies::Far),
        ([LITTLE, 0.5 * LITTLE, 1.0], 0, Lies::Far),
    ] {
        // The corner's own edges are those before and after it, as trims too.
        for trim in [corner, (corner + 2) % 3] {
            let foot = nalgebra::Point2::from(corners[corner]);
            let s = [0.0, 1.0].into_iter().find(|s| {
                let end = point(&brep, on_trim(&brep, trim, *s));
                (end.xy() - foot).norm() < REACH
            });
            let at = on_trim(&brep, trim, s.unwrap());
            assert_eq!(
                lies(&brep, normal, at, Some(trim), SLACK),
                expected,
                "{normal:?} {trim}"
            );
        }
    }
}
