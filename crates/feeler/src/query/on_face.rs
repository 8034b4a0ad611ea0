//! Points exactly on a face: no ray tells their side, but the numbers of the file may.

use super::forms::Stabber;
use super::inside::{DIRECTIONS, PARITY_BUDGET};
use super::zeros::{Digits, FaceHits, face_hits};
use super::{LineKind, LineProbe};
use crate::numeric::{Ball, Dd};
use crate::prepare::PreparedBrep;
use crate::trim::{BoxSide, Side};
use nalgebra::{Point2, Point3, Vector3};

/// Whether the point is proven to be exactly on a face all of whose points have the same x, y or z.
///
/// A ray from it that is not along the face's plane meets the plane in this point alone: a certified hit is this point.
pub(super) fn on_level_face(brep: &PreparedBrep, point: Point3<f64>) -> bool {
    (0..brep.brep().faces().len()).any(|face| {
        let level = brep.level(face);
        if !level.is_some_and(|(axis, at)| point[axis] == at) {
            return false;
        }
        let Ok(probe) = LineProbe::new(point, Vector3::from(DIRECTIONS[0]), LineKind::Line) else {
            return false;
        };
        let mut budget = PARITY_BUDGET;
        let (stab, mut found) = (Stabber::new(&probe), FaceHits::default());
        let told = face_hits(brep, &stab, face, Digits::All, &mut budget, &mut found);
        told.is_some() && found.hits.iter().any(|h| h.inside)
    })
}

/// Whether the point is proven to be exactly on a face: by parameters in f64 that are its own and in the region or on its border, or on a native sphere, cylinder,
/// cone or hyperboloid by its equation, with its parameters, as far as they are known, in the region.
pub(super) fn on_some_face(brep: &PreparedBrep, point: Point3<f64>) -> bool {
    let x: [f64; 3] = point.coords.into();
    (0..brep.brep().faces().len()).any(|face| {
        let near = brep.face_box(face).is_none_or(|b| {
            let mut sides = x.iter().zip(b);
            sides.all(|(x, [low, high])| low <= x && x <= high)
        });
        near && (at_stored_place(brep, face, &x) || on_quadric(brep, face, &x))
    })
}

fn at_stored_place(brep: &PreparedBrep, face: usize, point: &[f64; 3]) -> bool {
    brep.stored_place(face, point).is_some_and(|[u, v]| {
        let side = brep.region(face).side(Point2::new(u, v)).side;
        matches!(side, Some(Side::Inside | Side::Boundary))
    })
}

/// Of copies at whole turns each is the point's own: one in the region is enough.
fn on_quadric(brep: &PreparedBrep, face: usize, point: &[f64; 3]) -> bool {
    let Some(places) = brep
        .closed(face)
        .and_then(|f| f.surface.exact_places(point))
    else {
        return false;
    };
    let domain = brep.brep().surface(face).domain();
    places.iter().any(|place: &[Ball<Dd>; 2]| {
        let [u, v] = place.map(|x| [x.lower(), x.upper()]);
        let within =
            |k: usize, [low, high]: [f64; 2]| domain[k].start <= low && high <= domain[k].end;
        within(0, u) && within(1, v) && brep.region(face).classify_box(u, v) == BoxSide::Inside
    })
}
