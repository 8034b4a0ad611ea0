//! What is told about the place of a contact: its point, its normal, the feature of the BREP it is on, and how well these are known.

use super::answer::{Accuracy, Contact, Feature, Probe, Separation};
use super::continuum::CONTINUUM_REACH;
use super::local::on_trim;
use super::nearest::nearest_along;
use super::normal::{normal_of_faces, unit};
use super::outcome::{Locus, Outcome, Rough, Settled, Source, Spread};
use super::search::QUARTER;
use crate::numeric::{Ball, Dd};
use crate::prepare::closed::V3;
use crate::prepare::{Net, PreparedBrep, curve_jet, jet};
use crate::trim::Side;
use nalgebra::{Point2, Point3, Vector3};

/// A foot nearer to a vertex than this times the size is on the vertex.
pub(super) const ON_VERTEX: f64 = 1.0 / (1u64 << 40) as f64;

/// A bound is off by a few roundings.
const BOUND_UP: f64 = 1.0 + 16.0 * f64::EPSILON;

/// A point of the BREP in the search's terms.
pub(super) struct Place {
    pub(super) face: usize,
    pub(super) trim: Option<usize>,
    pub(super) spot: Locus,
    pub(super) uv: Point2<f64>,
}

/// A point of a net, relative to the net's origin, and its derivatives, in f64.
pub(super) fn rough_jet(net: &Net<f64>, at: [f64; 2]) -> [Vector3<f64>; 3] {
    let [h, s, t] = if jet::fits(net.degree) {
        jet::jet1(net, at[0], at[1])
    } else {
        let j = net.jet(Ball::exact(at[0]), Ball::exact(at[1]));
        [j.value, j.s, j.t].map(|v| v.map(|x| x.mid))
    };
    let point = Vector3::from_fn(|c, _| h[c] / h[3]);
    let along = |d: &[f64; 4]| Vector3::from_fn(|c, _| (d[c] - d[3] * point[c]) / h[3]);
    [point, along(&s), along(&t)]
}

/// Where a settled node's minimum is: the place, its patch and the local parameters there.
pub(super) fn place_of(brep: &PreparedBrep, s: &Settled) -> Option<(Place, usize, [Ball<Dd>; 2])> {
    let (face, trim, patch, local, uv) = match s.source? {
        Source::Patch { face, index } => {
            let maps = &brep.double(face).patches[index].maps;
            let uv = Point2::from([0, 1].map(|k| maps[k].to_native(Dd::from(s.at[k]))));
            (face, None, index, s.at.map(Ball::exact), uv)
        }
        Source::Piece { face, index } => {
            let geometry = brep.double_double(face);
            let piece = geometry.piece(index);
            let (p, _) = curve_jet(&piece.local, Ball::exact(s.at[0]));
            let local = [p[0] / p[2], p[1] / p[2]];
            let maps = geometry.patches.maps_of(piece.patch);
            let uv = Point2::new(
                maps[0].nearest_native(local[0].mid),
                maps[1].nearest_native(local[1].mid),
            );
            (face, piece.trim, piece.patch, local, uv)
        }
    };
    let place = Place {
        face,
        trim,
        spot: Locus::Patch {
            patch,
            local,
            point: None,
        },
        uv,
    };
    Some((place, patch, local))
}

/// Of the distance of a ball's centre: where a foot is known to so little, the normal is good to twelve digits. (Full accuracy has all of them.)
const SHARP_FOOT: f64 = 1.0 / (1u64 << 42) as f64;

/// A height over a half-space's plane is rounded a few times, each by half a unit of numbers up to three times the largest coordinate or the offset: three products, three sums, and
/// the foot's own coordinates.
const HEIGHT_ROUNDED: f64 = 16.0 * f64::EPSILON;

/// The point of a place in f64, where that is known within `enough`, and in the direction of a ball's centre within [`SHARP_FOOT`].
///
/// The place's parameters are rounded, each by half a unit of one at most, besides what they are known to.
fn rough_point(
    brep: &PreparedBrep,
    probe: &Probe,
    place: &Place,
    rough: Option<&Rough>,
    enough: f64,
) -> Option<V3> {
    let Locus::Patch { patch, local, .. } = place.spot else {
        return None;
    };
    let geometry = brep.double(place.face);
    let net = &geometry.patches[patch].net;
    if !jet::fits(net.degree) {
        return None;
    }
    let at = local.map(|x| x.mid.hi.clamp(0.0, 1.0));
    let speeds = geometry.patch_speeds(patch);
    let moved: f64 = (0..2)
        .map(|k| speeds[k] * (f64::EPSILON + local[k].rad))
        .sum();
    let value = cartesian(net, &point_at(net, (place.face, patch), at, rough));
    let point: [Ball<f64>; 3] = std::array::from_fn(|c| {
        let x = value[c];
        Ball {
            rad: (x.rad + moved) * BOUND_UP,
            ..x
        }
    });
    let enough = match probe {
        Probe::Sphere(s) => {
            let off = Vector3::from_fn(|c, _| s.center[c] - point[c].mid);
            enough.min(SHARP_FOOT * off.norm())
        }
        Probe::HalfSpace(_) => enough,
    };
    let known = point.iter().all(|x| x.rad <= enough);
    known.then(|| point.map(Ball::to_dd))
}

/// The homogeneous point of a patch whose net [fits](jet::fits), unless it is what is known.
fn point_at(
    net: &Net<f64>,
    (face, index): (usize, usize),
    at: [f64; 2],
    rough: Option<&Rough>,
) -> [Ball<f64>; 4] {
    match rough.filter(|r| r.is_at(Source::Patch { face, index }, at)) {
        Some(rough) => rough.point,
        None => jet::point(net, at[0], at[1]),
    }
}

/// The point in space.
fn cartesian(net: &Net<f64>, value: &[Ball<f64>; 4]) -> [Ball<f64>; 3] {
    let [x, y, z, w] = *value;
    let unit = w.is_one();
    let at = |x: Ball<f64>, k: usize| {
        let x = if unit { x } else { x / w };
        x + Ball::exact(net.origin[k])
    };
    [at(x, 0), at(y, 1), at(z, 2)]
}

/// The point of a place.
fn point_of(brep: &PreparedBrep, place: &Place) -> V3 {
    match place.spot {
        Locus::Patch {
            patch,
            local,
            point,
        } => {
            let net = &brep.double_double(place.face).patches[patch].net;
            let value = point.or_else(|| jet::fine_value(net, local));
            let value = value.unwrap_or_else(|| net.jet(local[0], local[1]).value);
            std::array::from_fn(|c| value[c] / value[3] + Ball::exact(net.origin[c]))
        }
        Locus::Closed { point } => point,
    }
}

/// Where the centre of a ball is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Centre {
    pub(super) in_material: bool,
    /// Whether it may be on the surface.
    pub(super) may_touch: bool,
}

/// What is told of a contact at a place; without bounds on foot and normal. Where the centre is counts for a ball alone.
#[inline]
pub(super) fn make_contact(
    brep: &PreparedBrep,
    probe: &Probe,
    place: &Place,
    separation: Separation,
    centre: Centre,
    accuracy: Accuracy,
    rough: Option<&Rough>,
) -> Contact {
    let rough = match accuracy {
        Accuracy::Length(a) => rough_point(brep, probe, place, rough, QUARTER * a),
        Accuracy::Full => None,
    };
    let point = rough.unwrap_or_else(|| point_of(brep, place));
    let on_brep = Point3::new(point[0].mid.hi, point[1].mid.hi, point[2].mid.hi);
    let feature = feature(brep, place, &on_brep);
    let (normal, is_choice, on_probe) = match probe {
        Probe::Sphere(s) => {
            let off: V3 = std::array::from_fn(|c| Ball::exact(s.center[c]) - point[c]);
            let to_center = Vector3::from_fn(|c, _| off[c].mid.hi);
            // Within its own error it points nowhere, nor where the centre may be on the surface: then what is found of the foot is off by more than
            // the centre is.
            let error = Vector3::from_fn(|c, _| off[c].rad).norm();
            let near = if centre.may_touch {
                ON_VERTEX * brep.size()
            } else {
                0.0
            };
            let (normal, is_choice) = if to_center.norm() > error.max(near)
                && let Some(apart) = unit(to_center)
            {
                (if centre.in_material { -apart } else { apart }, false)
            } else {
                let (normal, is_choice) = normal_of_faces(brep, place, feature, &on_brep);
                // Of what has no inside the centre may be on either side, and as near as it is, the way to it may tell on which.
                let outward = if centre.in_material { -1.0 } else { 1.0 };
                let height = outward * normal.dot(&to_center);
                let is_behind = height < -error.max(BEHIND * to_center.norm());
                let sign = if is_behind && !is_choice { -1.0 } else { 1.0 };
                (normal * sign, is_choice)
            };
            (normal, is_choice, s.center - normal * s.radius)
        }
        Probe::HalfSpace(h) => {
            // A foot may be higher than the least by the accuracy, or by more where that is not decided: its own height leads to the plane. Where the separation
            // is the same but for roundings of that, it has more digits.
            let own = h.normal.dot(&on_brep.coords) - h.offset;
            let size = on_brep.coords.amax().max(h.offset.abs());
            let is_same = (own - separation.value).abs() <= HEIGHT_ROUNDED * size;
            let height = match accuracy {
                Accuracy::Full if is_same => separation.value,
                _ => own,
            };
            (-h.normal, false, on_brep - h.normal * height)
        }
    };
    Contact {
        on_brep,
        on_probe,
        normal,
        separation,
        feature,
        face: place.face,
        uv: place.uv,
        position_bound: None,
        normal_bound: None,
        normal_is_choice: is_choice,
    }
}

fn feature(brep: &PreparedBrep, place: &Place, point: &Point3<f64>) -> Feature {
    let parts = brep.brep().parts();
    let Some(trim) = place.trim.or_else(|| trim_at(brep, place)) else {
        return Feature::Face(place.face);
    };
    let near = ON_VERTEX * brep.size();
    let at_vertex = parts.trims[trim]
        .vertices
        .iter()
        .find(|v| (parts.vertices[**v].point - point).norm() <= near);
    match (at_vertex, parts.trims[trim].edge) {
        (Some(v), _) => Feature::Vertex(*v),
        (None, Some(e)) => Feature::Edge(e),
        (None, None) => Feature::Vertex(parts.trims[trim].vertices[0]),
    }
}

/// The trim that a foot on the border of its region lies on: the one that comes nearest in uv. Only those are looked at whose
/// pieces have the foot near their boxes, if there are any. (A foot on the border of the domain may be beside the trim that bounds the face there, by a
/// rounding or more: straight out from it there is one, since it is within the loops, and that one's nearest place in the domain is the foot.)
pub(super) fn trim_at(brep: &PreparedBrep, place: &Place) -> Option<usize> {
    let region = brep.region(place.face);
    let parts = brep.brep().parts();
    match region.side(place.uv).side {
        Some(Side::Boundary) => {}
        Some(Side::Inside) => return None,
        Some(Side::Outside) | None => return trim_that_ends_at(brep, place),
    }
    let mut near = trims_near(brep, place.face, &place.uv);
    if let [only] = near.as_slice() {
        return Some(*only);
    }
    if near.is_empty() {
        let loops = parts.faces[place.face].loops.as_ref()?;
        near.extend(loops.iter().flat_map(|l| &parts.loops[*l].trims));
    }
    let distance = |t: usize| nearest_in_uv(brep, t, &place.uv).0;
    let all = near.iter().map(|t| (distance(*t), *t));
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, t)| t)
}

/// How near a trim comes to a place of its face in uv, and where on the trim, from 0 to 1, roughly. In parts of the domain: what is rounding along its longer side may be much
/// of the shorter one.
pub(super) fn nearest_in_uv(brep: &PreparedBrep, trim: usize, uv: &Point2<f64>) -> (f64, f64) {
    let parts = brep.brep().parts();
    let face = parts.loops[parts.trims[trim].trim_loop].face;
    let domain = brep.brep().surface(face).domain();
    let in_parts = |p: &Point2<f64>| Point2::from([0, 1].map(|k| p[k] / domain[k].length()));
    let within = |s: f64| in_parts(&on_trim(brep, trim, s).uv);
    nearest_along(brep, trim, within, &in_parts(uv))
}

/// The trim that ends at the vertex that a foot beside its region is on: ends of trims that should meet are off by roundings, and so is the foot on the segment that joins
/// them.
fn trim_that_ends_at(brep: &PreparedBrep, place: &Place) -> Option<usize> {
    let parts = brep.brep().parts();
    let surface = brep.brep().surface(place.face);
    let point = surface.point(place.uv.x, place.uv.y);
    let near = ON_VERTEX * brep.size();
    let ends_here = |t: &usize| {
        let mut vertices = parts.trims[*t].vertices.iter();
        vertices.any(|v| (parts.vertices[*v].point - point).norm() <= near)
    };
    let trims = trims_near(brep, place.face, &place.uv).into_iter();
    trims.filter(ends_here).min()
}

/// The trims of a face that may be next to a place.
pub(super) fn trims_near(brep: &PreparedBrep, face: usize, uv: &Point2<f64>) -> Vec<usize> {
    let region = brep.region(face);
    let domain = region.domain();
    region.trims_near([0, 1].map(|k| {
        let slack = NEAR_TRIM * (domain[k].end - domain[k].start);
        [uv[k] - slack, uv[k] + slack]
    }))
}

/// A centre is behind a face, and not beside a foot that is off, where the cosine of the way to it and the normal is this at least.
const BEHIND: f64 = 0.5;
/// A foot nearer to a trim than this part of the domain may be on the trim.
const NEAR_TRIM: f64 = 1.0 / (1u64 << 24) as f64;

/// Bounds on foot and normal, where all that may hold the minimum is near the foot.
///
/// What the search left is settled nodes, and none that it dropped has a value below `hi`: so every point where `f` is least is on a node with
/// `lo <= hi`, in the ball that [`ball_of`] tells. On an edge, at a vertex or on a seam there are several; the foot is no farther from any such
/// point than from the farthest of these balls. (Two places that are equally low, as far as is known, leave no foot to be bounded.)
pub(super) fn bound_contact(
    c: &mut Contact,
    probe: &Probe,
    found: &Outcome,
    brep: &PreparedBrep,
    continuum: bool,
) {
    if let Probe::HalfSpace(_) = probe {
        // It is the half-space's own, wherever the contact is.
        c.normal_bound = Some(0.0);
    }
    if continuum || found.left_open || found.budget_spent {
        return;
    }
    let mut bound = 0.0f64;
    for s in found.settled.iter().filter(|s| !(s.lo > found.hi)) {
        let Some((center, radius)) = ball_of(brep, s, found.hi, found.rough.as_deref()) else {
            return;
        };
        let mut apart = 0.0;
        for (x, on_brep) in center.iter().zip(c.on_brep.iter()) {
            let off = (*x - Ball::exact(*on_brep)).magnitude();
            apart += off * off;
        }
        let own = (radius + apart.sqrt()) * BOUND_UP;
        // Negated: what is no number bounds nothing.
        if !(own <= CONTINUUM_REACH * brep.size()) {
            return;
        }
        bound = bound.max(own);
    }
    c.position_bound = Some(bound);
    if let Probe::Sphere(_) = probe {
        let distance = found.lo.hi.max(0.0).sqrt();
        // The angle at the centre: sin(angle) <= bound / distance, and asin x <= 1.6 x.
        if distance > bound {
            c.normal_bound = Some(1.6 * bound / distance + 4.0 * f64::EPSILON);
        }
    }
}

/// The centre and the radius of a ball that holds all points of a settled node where `f` may be least; `None` where nothing is known of them.
pub(super) fn ball_of(
    brep: &PreparedBrep,
    s: &Settled,
    hi: Dd,
    rough: Option<&Rough>,
) -> Option<([Ball<f64>; 3], f64)> {
    let spread = s.spread?;
    if let Spread::At { point, off } = spread {
        return Some((point.map(Ball::exact), off));
    }
    let source = s.source?;
    let geometry = brep.double(source.face());
    let way = |speeds: [f64; 2], off: [f64; 2]| speeds[0] * off[0] + speeds[1] * off[1];
    let radius = match spread {
        Spread::At { .. } => return None,
        Spread::Around(growth) => growth.radius(hi),
        Spread::Within(range) => {
            let speeds = match source {
                Source::Patch { index, .. } => geometry.patch_speeds(index),
                Source::Piece { index, .. } => geometry.piece_speeds(index),
            };
            let far = |k: usize| {
                let [low, high] = range[k].map(|end| (s.at[k] - end).abs());
                low.max(high)
            };
            way(speeds, [far(0), far(1)])
        }
    };
    let (index, local) = match source {
        Source::Patch { index, .. } => (index, s.at.map(Ball::exact)),
        Source::Piece { index, .. } => {
            let piece = geometry.piece(index);
            let (p, _) = curve_jet(&piece.local, Ball::exact(s.at[0]));
            (piece.patch, [p[0] / p[2], p[1] / p[2]])
        }
    };
    let net = &geometry.patches[index].net;
    let at = local.map(|x| x.mid.clamp(0.0, 1.0));
    // The place is as near as its parameters are, which are rounded, twice at most.
    let off = [0, 1].map(|k| local[k].rad + (local[k].mid - at[k]).abs() + 2.0 * f64::EPSILON);
    let moved = way(geometry.patch_speeds(index), off);
    let value = if jet::fits(net.degree) {
        point_at(net, (source.face(), index), at, rough)
    } else {
        let at = at.map(Ball::<f64>::exact);
        net.jet(at[0], at[1]).value
    };
    Some((cartesian(net, &value), radius + moved))
}
