//! Which pieces only touch their patch.

use super::*;
use crate::brep::{BrepBuilder, TrimSpec};
use crate::nurbs::{Curve, NurbsCurve, NurbsSurface, Surface};
use crate::prepare::PreparedBrep;
use crate::query::objective::Objective;
use crate::query::outcome::{Goal, Width};
use crate::query::task::Memory;
use nalgebra::{Point3, Vector3, Vector4};

/// Below any slack by which parts of trims belong to the patches on both sides of a border.
const LITTLE: f64 = 1.0 / (1u64 << 50) as f64;

/// A roof over `[-1, 1]^2` with its ridge along `u = 0`, where its two patches meet, within a loop: each side is a rational curve of degree two through a corner, a
/// control point and the next corner.
fn roof(sides: &[[[f64; 2]; 2]]) -> PreparedBrep {
    let corner = |u: f64, v: f64| Vector4::new(u, v, 1.0 - u.abs(), 1.0);
    let us = [-1.0, 0.0, 1.0];
    let net = us.iter().flat_map(|u| [-1.0, 1.0].map(|v| corner(*u, v)));
    let knots = [vec![-1.0, -1.0, 0.0, 1.0, 1.0], vec![-1.0, -1.0, 1.0, 1.0]];
    let surface = NurbsSurface::new([1, 1], [3, 2], net.collect(), knots).unwrap();
    let mut b = BrepBuilder::new();
    let point = |[u, v]: [f64; 2]| Point3::new(u, v, 1.0 - u.abs());
    let ids: Vec<usize> = sides.iter().map(|s| b.vertex(point(s[0]))).collect();
    let trims = (0..sides.len()).map(|k| {
        let next = (k + 1) % sides.len();
        let ([from, middle], to) = (sides[k], sides[next][0]);
        let vertices = [ids[k], ids[next]];
        let weighted = |[u, v]: [f64; 2], w: f64| Vector3::new(u * w, v * w, w);
        let net = vec![
            weighted(from, 1.0),
            weighted(middle, 2.0),
            weighted(to, 1.0),
        ];
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        TrimSpec {
            vertices,
            curve: Curve::Nurbs(NurbsCurve::new(2, net, knots).unwrap()),
            edge: Some(b.straight_edge(vertices).unwrap()),
        }
    });
    let trims = trims.collect();
    b.face_with_trims(Surface::Nurbs(surface), vec![trims])
        .unwrap();
    PreparedBrep::new(b.build().unwrap())
}

/// What is told of the pieces of one side on one patch, in their order along the side.
fn touches(brep: &PreparedBrep, side: usize, patch: usize) -> Vec<Option<[bool; 2]>> {
    let objective = Objective::SquaredDistance(Point3::origin());
    let goal = Goal {
        width: Width::Length(1e-9),
        all_below: None,
        extents: None,
        threshold: None,
        budget: 0,
        closed: true,
        foot: false,
        hint: None,
    };
    let mut memory = Memory::default();
    let search = Search::new(brep, &objective, goal, &mut memory);
    let geometry = brep.double(0);
    let own = |i: &usize| {
        let piece = geometry.piece(*i);
        (piece.trim, piece.patch) == (Some(side), patch)
    };
    let pieces = (0..geometry.piece_count()).filter(own);
    pieces.map(|i| search.touches_only(0, i)).collect()
}

/// The patch where u is negative, and the other.
const LEFT: usize = 0;
const RIGHT: usize = 1;

/// One side runs from the ridge to the ridge and is beyond it between, by less than any slack; the sides beside it end on the ridge.
#[test]
fn a_bulge_over_a_border_touches_at_both_ends() {
    let brep = roof(&[
        [[-0.5, -0.5], [-0.25, -0.5]],
        [[0.0, -0.5], [LITTLE, 0.0]],
        [[0.0, 0.5], [-0.25, 0.5]],
        [[-0.5, 0.5], [-0.5, 0.0]],
    ]);
    assert_eq!(touches(&brep, 1, LEFT), [Some([true; 2])]);
    // On the other patch it enters, or is in it.
    assert_eq!(touches(&brep, 1, RIGHT), [None]);
    // What ends on the border has a last piece that the other patch, too, takes for near: it touches at that end alone. On its own patch it is no such piece.
    assert_eq!(touches(&brep, 0, RIGHT), [Some([false, true])]);
    assert_eq!(touches(&brep, 2, RIGHT), [Some([true, false])]);
    for side in [0, 2] {
        let own = touches(&brep, side, LEFT);
        assert!(
            !own.is_empty() && own.iter().all(Option::is_none),
            "{own:?}"
        );
    }
    // This one is far from the ridge.
    assert_eq!(touches(&brep, 3, RIGHT), []);
    assert_eq!(touches(&brep, 3, LEFT), [None]);
}

/// A side that starts on the ridge and goes away from it.
#[test]
fn what_goes_away_touches_at_one_end() {
    let brep = roof(&[
        [[-0.5, -0.5], [-0.25, -0.5]],
        [[0.0, -0.5], [LITTLE, 0.0]],
        [[LITTLE, 0.5], [-0.25, 0.5]],
        [[-0.5, 0.5], [-0.5, 0.0]],
    ]);
    assert_eq!(touches(&brep, 1, LEFT), [Some([true, false])]);
    assert_eq!(touches(&brep, 1, RIGHT), [None]);
}

/// A side that is beyond the ridge next to one end and before it next to the other enters both patches, and so does one that runs along the ridge: that is on both.
#[test]
fn what_enters_does_not_only_touch() {
    let brep = roof(&[
        [[-0.5, -0.5], [-0.25, -0.5]],
        [[-LITTLE, -0.5], [0.0, 0.0]],
        [[LITTLE, 0.5], [-0.25, 0.5]],
        [[-0.5, 0.5], [-0.5, 0.0]],
    ]);
    assert_eq!(touches(&brep, 1, LEFT), [None]);
    assert_eq!(touches(&brep, 1, RIGHT), [None]);
    let along = roof(&[
        [[-0.5, -0.5], [-0.25, -0.5]],
        [[0.0, -0.5], [0.0, 0.0]],
        [[0.0, 0.5], [-0.25, 0.5]],
        [[-0.5, 0.5], [-0.5, 0.0]],
    ]);
    assert_eq!(touches(&along, 1, LEFT), [None]);
    assert_eq!(touches(&along, 1, RIGHT), [None]);
}

/// An end exactly on the ridge that is beyond the border of the domain is no place of the patch.
#[test]
fn an_end_beyond_another_border_does_not_touch() {
    for (beyond, touching) in [(0.0, true), (LITTLE, false)] {
        let brep = roof(&[
            [[-0.5, 0.0], [-0.25, 0.0]],
            [[0.0, 0.0], [LITTLE, 0.5]],
            [[0.0, 1.0 + beyond], [-0.25, 0.75]],
            [[-0.5, 0.5], [-0.5, 0.25]],
        ]);
        assert_eq!(touches(&brep, 1, LEFT), [Some([true, touching])]);
        assert_eq!(touches(&brep, 2, RIGHT), [Some([touching, false])]);
    }
}

/// A part that passes one border and is next to another all along, within it by less than roundings of the way leave of the secant method; and one that passes two.
#[test]
fn where_a_part_ends() {
    let ends = |along: [f64; 2], across: [f64; 2], swap: bool, to: usize| {
        let mut part: Vec<Homogeneous<Dd, 3>> = [0.0, 0.5, 1.0]
            .iter()
            .map(|s| {
                let between = |r: [f64; 2]| Ball::exact((1.0 - s) * r[0] + s * r[1]);
                let (u, v) = (between(along), between(across));
                if swap {
                    [v, u, Ball::ONE]
                } else {
                    [u, v, Ball::ONE]
                }
            })
            .collect();
        if to == 0 {
            part.reverse();
        }
        let slack = border_slack(&part);
        let found = end_between(&part, to, slack);
        found.map(|ends| ends.map(|s| if to == 0 { 1.0 - s } else { s }))
    };
    for swap in [false, true] {
        for to in [0, 1] {
            for (along, across, expected) in [
                ([7e-31, 0.0], [2e-16, -1e-16], 2.0 / 3.0),
                ([1e-25, 1e-31], [1e-16, -3e-16], 0.25),
                // It passes the one at a third, before the other, which it is farther beyond in the end.
                ([1e-10, -2e-10], [3e-10, -3e-10], 1.0 / 3.0),
                ([3e-10, -3e-10], [1e-10, -2e-10], 1.0 / 3.0),
            ] {
                let found = ends(along, across, swap, to);
                let near = |s: f64| (s - expected).abs() <= 1e-9;
                assert!(
                    found.is_some_and(|[on, off]| near(on) && near(off) && on <= off),
                    "{along:?} {across:?} {swap} {to}: {found:?}"
                );
            }
            // What is on the patch at that end does not end.
            assert_eq!(ends([1e-10, 2e-10], [1e-10, 3e-10], swap, to), None);
        }
    }
}
