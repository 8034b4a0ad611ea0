//! The normal of a contact where the centre of a ball is on the surface, so that the way to it points nowhere: the face's, on an edge or a vertex the normalised
//! sum of the faces' normals there. It is rounded, and nothing is proven of it.

use super::answer::Feature;
use super::local::on_trim;
use super::nearest::nearest_place;
use super::outcome::Locus;
use super::place::Place;
use crate::numeric::{Ball, Dd};
use crate::prepare::PreparedBrep;
use nalgebra::{Point3, Vector3};

/// A sum shorter than this has cancelled but for roundings.
const CANCELLED: f64 = 1.0 / (1u64 << 40) as f64;

/// The normal, and whether it is a choice among others: on edges and vertices, and where the face has none (the apex of a cone).
pub(super) fn normal_of_faces(
    brep: &PreparedBrep,
    place: &Place,
    feature: Feature,
    point: &Point3<f64>,
) -> (Vector3<f64>, bool) {
    let on_border = !matches!(feature, Feature::Face(_));
    if on_border && let Some(sum) = sum_at(brep, feature, point) {
        return (sum, true);
    }
    let outward = |n: Vector3<f64>| oriented(brep, place.face, n);
    if let Some(own) = unit(face_normal(brep, place)) {
        return (outward(own), on_border);
    }
    let around = normal_around(brep, (place.face, [place.uv.x, place.uv.y]));
    // Of what has no normal anywhere (a surface that is a curve) any direction is one.
    let normal = around.and_then(unit).map_or_else(Vector3::z, outward);
    (normal, true)
}

fn oriented(brep: &PreparedBrep, face: usize, normal: Vector3<f64>) -> Vector3<f64> {
    if brep.brep().faces()[face].reversed {
        -normal
    } else {
        normal
    }
}

/// The normalised sum of the unit normals of the faces at an edge's point or a vertex. A face that is there more than once (a seam, both sides of a slit) has the
/// normalised sum of its own.
fn sum_at(brep: &PreparedBrep, feature: Feature, point: &Point3<f64>) -> Option<Vector3<f64>> {
    let parts = brep.brep().parts();
    let trims: Vec<usize> = match feature {
        Feature::Face(_) => return None,
        Feature::Edge(e) => parts.edges[e].trims.clone(),
        Feature::Vertex(v) => (0..parts.trims.len())
            .filter(|t| parts.trims[*t].vertices.contains(&v))
            .collect(),
    };
    let mut of_faces: Vec<(usize, Vector3<f64>)> = Vec::new();
    for trim in trims {
        let at = on_trim(brep, trim, nearest_place(brep, trim, point));
        let Some(normal) = normal_at(brep, at.face, [at.uv.x, at.uv.y]) else {
            continue;
        };
        match of_faces.iter_mut().find(|(face, _)| *face == at.face) {
            Some((_, sum)) => *sum += normal,
            None => of_faces.push((at.face, normal)),
        }
    }
    let units = of_faces.into_iter().filter_map(|(_, sum)| unit(sum));
    let sum: Vector3<f64> = units.sum();
    unit(sum).filter(|_| sum.norm() > CANCELLED)
}

/// The unit normal of a face by its orientation.
fn normal_at(brep: &PreparedBrep, face: usize, at: [f64; 2]) -> Option<Vector3<f64>> {
    let p = brep
        .brep()
        .surface(face)
        .first_derivatives_with_bound(at[0], at[1]);
    let normal = unit(p.du.cross(&p.dv)).or_else(|| normal_around(brep, (face, at)).and_then(unit));
    normal.map(|n| oriented(brep, face, n))
}

/// A vector along `S_u x S_v` at a place, rounded.
fn face_normal(brep: &PreparedBrep, place: &Place) -> Vector3<f64> {
    match place.spot {
        Locus::Patch { patch, local, .. } => {
            let net = &brep.double_double(place.face).patches[patch].net;
            let jet = net.jet(local[0], local[1]);
            let w = jet.value[3];
            let along = |d: &[Ball<Dd>; 4]| -> Vector3<f64> {
                Vector3::from_fn(|c, _| ((d[c] - d[3] * (jet.value[c] / w)) / w).mid.hi)
            };
            along(&jet.s).cross(&along(&jet.t))
        }
        Locus::Closed { .. } => match brep.closed(place.face) {
            Some(form) => form.surface.normal([place.uv.x, place.uv.y]).into(),
            None => Vector3::zeros(),
        },
    }
}

/// Where a face has no normal (the apex of a cone, a collapsed side): the sum of the unit normals at points around, a
/// little inside the surface's domain. Where these cancel, the first of them: the direction is a choice there, but the
/// contact is not.
fn normal_around(brep: &PreparedBrep, (face, at): (usize, [f64; 2])) -> Option<Vector3<f64>> {
    /// Points along each side of the domain.
    const AROUND: u8 = 16;
    /// How far inside, as a part of the domain.
    const INSIDE: f64 = 1.0 / (1u64 << 20) as f64;
    let surface = brep.brep().surface(face);
    let domain = surface.domain();
    let inward = |k: usize| {
        let middle = 0.5 * (domain[k].start + domain[k].end);
        at[k] + INSIDE * (middle - at[k])
    };
    let (mut sum, mut first) = (Vector3::zeros(), None);
    for collapsed in 0..2 {
        // The whole of a side is this point where the derivative along it vanishes.
        let mut uv = at;
        uv[1 - collapsed] = inward(1 - collapsed);
        for i in 0..AROUND {
            uv[collapsed] = domain[collapsed].lerp((f64::from(i) + 0.5) / f64::from(AROUND));
            let p = surface.first_derivatives_with_bound(uv[0], uv[1]);
            let near = (p.point - surface.point(at[0], at[1])).norm() <= NEAR_POLE * brep.size();
            if let (true, Some(n)) = (near, unit(p.du.cross(&p.dv))) {
                sum += n;
                first = first.or(Some(n));
            }
        }
    }
    if sum.norm() > CANCELLED {
        return Some(sum);
    }
    // At a corner where one derivative vanishes no side is this point: what is inward of it then.
    first.or_else(|| {
        let [u, v] = [inward(0), inward(1)];
        let beside = [[u, v], [u, at[1]], [at[0], v]];
        beside.iter().find_map(|[u, v]| {
            let p = surface.first_derivatives_with_bound(*u, *v);
            unit(p.du.cross(&p.dv))
        })
    })
}

/// Points taken as neighbours of a pole are nearer to it than this part of the model's size: above what
/// [`normal_around`] goes inside, below what is another place.
const NEAR_POLE: f64 = 1.0 / (1u64 << 12) as f64;

/// The unit vector, scaled first so that tiny ones survive.
pub(super) fn unit(v: Vector3<f64>) -> Option<Vector3<f64>> {
    let size = v.amax();
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let v = v / size;
    Some(v / v.norm())
}
