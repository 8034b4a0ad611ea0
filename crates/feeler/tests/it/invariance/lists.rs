//! Lists of contacts of one face, its surface in one patch and in two: where a trim passes from patch to patch nothing changes.

use super::{NORMALS, Patch, ball, patch, place};
use crate::scenes::polygon_face;
use feeler::nurbs::Surface;
use feeler::query::{
    Accuracy, ContactAnswer, Contacts, HalfSpace, Options, Probe, Workspace, contact,
};
use nalgebra::{Point2, Vector3};
use proptest::prelude::*;

/// A star of steps of 1/64 about the middle of the unit square.
fn star() -> impl Strategy<Value = Vec<Point2<f64>>> {
    let ray = (1u32..=16, 4i32..=30);
    prop::collection::vec(ray, 3..7).prop_filter_map("a gap", |rays| {
        let whole: u32 = rays.iter().map(|r| r.0).sum();
        let mut at = 0;
        let mut corners: Vec<Point2<f64>> = Vec::new();
        for (step, length) in rays {
            if 2 * step >= whole {
                return None;
            }
            let angle = f64::from(at) / f64::from(whole) * std::f64::consts::TAU;
            at += step;
            let on = |x: f64| 0.5 + (f64::from(length) * x).round() / 64.0;
            corners.push(Point2::new(on(angle.cos()), on(angle.sin())));
        }
        let apart = |i: usize| (corners[i] - corners[(i + 1) % corners.len()]).norm() > 0.01;
        (0..corners.len()).all(apart).then_some(corners)
    })
}

fn asked(
    surface: &Surface,
    corners: &[Point2<f64>],
    probe: &Probe,
    accuracy: Accuracy,
) -> ContactAnswer {
    let options = Options {
        accuracy,
        contacts: Contacts::All,
        prediction: 100.0,
        ..Options::default()
    };
    contact(
        &polygon_face(surface, corners),
        probe,
        &options,
        &mut Workspace::default(),
    )
}

/// One that the other list has not.
fn missing(a: &ContactAnswer, b: &ContactAnswer) -> Option<String> {
    let lost = a.contacts.iter().find(|c| {
        let same = |o: &feeler::query::Contact| {
            let (x, y) = (c.separation.bounds, o.separation.bounds);
            (c.on_brep - o.on_brep).norm() < 1e-4 && x.lo <= y.hi && y.lo <= x.hi
        };
        !b.contacts.iter().any(same)
    });
    lost.map(|c| format!("{c:?}"))
}

/// Whether a side of the polygon is level to a half-space. All of it is as low, and where it goes down from one of its ends none of it is a minimum: a list may have
/// a point of it or not.
fn has_level_side(patch: &Patch, corners: &[Point2<f64>], probe: &Probe) -> bool {
    let Probe::HalfSpace(below) = probe else {
        return false;
    };
    let surface = patch.surface();
    let height = |uv: Point2<f64>| below.normal.dot(&surface.point(uv.x, uv.y).coords);
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    sides.into_iter().any(|(a, b)| {
        let heights = [0.0, 0.5, 1.0].map(|t| height(a + (b - a) * t));
        heights.iter().all(|h| (h - heights[0]).abs() < 1e-12)
    })
}

fn both(
    patch: &Patch,
    corners: &[Point2<f64>],
    probe: &Probe,
    accuracy: Accuracy,
) -> Result<(), String> {
    let one = asked(&patch.surface(), corners, probe, accuracy);
    let two = asked(&patch.with_knot(), corners, probe, accuracy);
    let told = |a: &ContactAnswer| a.undecided.is_none() && !a.continuum;
    if !(told(&one) && told(&two)) || has_level_side(patch, corners, probe) {
        return Ok(());
    }
    match (missing(&one, &two), missing(&two, &one)) {
        (None, None) => Ok(()),
        (a, b) => Err(format!("of one patch alone {a:?}, of two alone {b:?}")),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn lists_of_one_patch_and_of_two(
        patch in patch(), corners in star(), center in place(), normal in prop::sample::select(&NORMALS[..]),
        accuracy in prop::sample::select(vec![Accuracy::Full, Accuracy::Length(1e-12), Accuracy::Length(1e-6)]),
    ) {
        let below = Probe::HalfSpace(HalfSpace::new(Vector3::from(normal), 0.25).unwrap());
        for probe in [ball(center), below] {
            let told = both(&patch, &corners, &probe, accuracy);
            prop_assert!(told.is_ok(), "{:?}", told);
        }
    }
}
