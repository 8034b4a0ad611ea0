//! All hits of a line with a BREP; how they are found and proven is in the module `zeros`.

use super::answer::{
    Accuracy, AnyHit, Feature, Hit, LineAnswer, LineProbe, Options, Parameter, Undecided, Unsettled,
};
use super::forms::Stabber;
use super::inside::{PARITY_BUDGET, near_edges};
use super::passages::crossings;
use super::zeros::{Digits, FaceHits, HitAt, RawHit, face_hits};
use super::{Work, Workspace};
use crate::numeric::{Ball, Dd, Enclosure};
use crate::prepare::closed::ClosedSurface;
use crate::prepare::{PreparedBrep, jet};
use nalgebra::{Point2, Vector3};

/// A node of the search for hits costs about as much as this many of the search for contacts.
const NODE_COST: usize = 4;

/// Lists that queries of lines use again.
#[derive(Debug, Default)]
pub(crate) struct LineMemory {
    faces: Vec<usize>,
    face: FaceHits,
    /// The hits of the last line, in order.
    pub(super) hits: Vec<RawHit>,
    /// The first place that it left open.
    unsettled: Option<Unsettled>,
}

/// A hit that is not settled.
fn place_of(h: &RawHit) -> Unsettled {
    Unsettled {
        face: h.face,
        t: Some(h.t.mid.hi),
    }
}

/// The first box of a face that may hold hits: where the line comes nearest to the middle of it.
fn place_of_open(brep: &PreparedBrep, stab: &Stabber, face: usize, found: &FaceHits) -> Unsettled {
    let near = found.open.first().map(|(patch, u, v)| {
        let maps = &brep.double(face).patches[*patch].maps;
        let [u, v] =
            [(0, u), (1, v)].map(|(k, r)| maps[k].to_native(Dd::from(0.5 * r[0] + 0.5 * r[1])));
        let point = brep.brep().surface(face).point(u, v);
        let d = stab.direction;
        (point - stab.origin).dot(&d) / d.norm_squared()
    });
    Unsettled {
        face,
        t: near.filter(|t| t.is_finite()),
    }
}

/// All hits of a line with the trimmed faces.
///
/// `hits` holds every parameter where the line meets a face, in order of `t`, each with a proven
/// enclosure (as a length, no wider than the accuracy asked for wherever double-double gives that), the interval where it lies in a face; a
/// hit on an edge is listed for each of its faces. `crossings` and `in_crack` are as the crate defines them (module `passages`). Against
/// polygons in planes all is exact, and next to the borders of plane faces that are lines, arcs or curves of degree two; so is how often the line meets a native
/// sphere, cylinder or cone, on a seam and a rim too; and an interval in which it lies in a plane face, in a native cylinder or cone, or in a ruling of a
/// NURBS face that is trimmed nowhere along it (where it ends is exact, or within an enclosure; `crossings` is not known). Else a line that touches a face or runs in it, meets it
/// within rounding of its border, or passes an edge so near to the width of its crack that bounds of this do not tell, is `Undecided`, with what was found.
///
/// What it allocates: see [`Workspace`].
pub fn line(
    brep: &PreparedBrep,
    probe: &LineProbe,
    options: &Options,
    workspace: &mut Workspace,
) -> LineAnswer {
    let stab = Stabber::new(probe);
    let nodes = options.node_budget / NODE_COST;
    let mut budget = nodes;
    // Off every edge by more than its crack, each hit is a crossing of its own, and there is no crack to
    // pass. Else whether hits merge hangs on the width of the crack: all digits are wanted.
    let mut near = PARITY_BUDGET;
    let near_edge = near_edges(brep, &stab, &mut near);
    let accuracy = if near_edge {
        Accuracy::Full
    } else {
        options.accuracy
    };
    let lines = &mut workspace.lines;
    let mut undecided = hits_within(brep, &stab, accuracy, &mut budget, lines);
    let raw = &lines.hits;
    // A closed range of t: a hit whose enclosure holds an end of it is not settled.
    let at_end = |h: &RawHit| h.exact.is_none() && stab.is_at_end(&h.t);
    let mut unsettled = lines.unsettled;
    if let Some(h) = raw.iter().find(|h| at_end(h)) {
        undecided = Some(Undecided::Degenerate);
        unsettled = Some(place_of(h));
    }
    let runs = |h: &RawHit| h.is_row() || h.exact.as_ref().is_some_and(|m| m.end.is_some());
    let lies_in = raw.iter().any(runs);
    // Hits that are open may be none, or cross.
    let settled = undecided.is_none();
    let mut count = settled.then(|| raw.iter().filter(|h| h.crosses()).count());
    let mut in_crack = false;
    if near_edge && settled {
        let found = crossings(brep, &stab, raw, &mut near);
        if (found.count.is_none() && !lies_in) || found.in_crack.is_none() {
            undecided = Some(Undecided::Crack);
            unsettled = None;
        }
        count = found.count;
        in_crack = found.in_crack.unwrap_or(false);
    }
    if lies_in {
        count = None;
    }
    // Only what is certain is listed.
    let mut hits = Vec::with_capacity(raw.len());
    let certain = raw.iter().filter(|h| h.inside);
    hits.extend(certain.filter_map(|h| dress(brep, &stab, h)));
    workspace.work = Work {
        nodes: nodes - budget + PARITY_BUDGET - near,
        contacts: hits.len(),
        rays: 0,
    };
    LineAnswer {
        hits,
        crossings: count,
        in_crack,
        undecided,
        unsettled,
    }
}

/// The hits as exactly as wanted: those that f64 gives, where they will do.
fn hits_within(
    brep: &PreparedBrep,
    stab: &Stabber,
    accuracy: Accuracy,
    budget: &mut usize,
    lines: &mut LineMemory,
) -> Option<Undecided> {
    if let Accuracy::Length(length) = accuracy {
        // Half of what may be spent: the rest is for what f64 leaves open.
        let half = *budget / 2;
        let mut own = half;
        let undecided = all_hits(brep, stab, Digits::Double, &mut own, lines);
        *budget -= half - own;
        // The norm, the products and the ends are off by a few roundings: the share that is left covers them.
        let widest = 0.5 * ROUNDED * length / stab.direction.norm();
        let value = |h: &RawHit| 4.0 * f64::EPSILON * h.t.mid.hi.abs();
        let is_narrow = |h: &RawHit| h.t.rad + value(h) <= widest;
        if undecided.is_none() && lines.hits.iter().all(is_narrow) {
            return None;
        }
    }
    all_hits(brep, stab, Digits::All, budget, lines)
}

/// What an enclosure may take up of the accuracy asked for before its ends are rounded to f64.
const ROUNDED: f64 = 1.0 - 1.0 / (1u64 << 20) as f64;

/// Whether the line meets any trimmed face, and a hit if it does.
///
/// Stops at the first hit that is certain; without one, either no face is met (proven), or it is `Undecided`. It counts no
/// crossings, so it does not look at edges. Of the options only the node budget counts.
///
/// What it allocates: see [`Workspace`].
pub fn any_hit(
    brep: &PreparedBrep,
    probe: &LineProbe,
    options: &Options,
    workspace: &mut Workspace,
) -> AnyHit {
    let stab = Stabber::new(probe);
    let nodes = options.node_budget / NODE_COST;
    let mut budget = nodes;
    let mut undecided = None;
    let mut unsettled: Option<Unsettled> = None;
    let mut hit = None;
    let LineMemory {
        faces, face: found, ..
    } = &mut workspace.lines;
    found.one = true;
    brep.faces_by_line(&stab.skewer(), |b| !stab.meets(b), faces);
    for face in faces.iter().copied() {
        let told = face_hits(brep, &stab, face, Digits::All, &mut budget, found);
        if told.is_none() {
            undecided = Some(Undecided::Degenerate);
            unsettled.get_or_insert(Unsettled { face, t: None });
            continue;
        }
        let certain = found.hits.iter().find(|h| h.is_certain(&stab));
        hit = certain.and_then(|h| dress(brep, &stab, h));
        if hit.is_some() {
            (undecided, unsettled) = (None, None);
            break;
        }
        if let Some(h) = found.hits.first() {
            unsettled.get_or_insert_with(|| place_of(h));
        } else if !found.open.is_empty() {
            unsettled.get_or_insert_with(|| place_of_open(brep, &stab, face, found));
        }
        if !found.open.is_empty() && budget == 0 {
            undecided = Some(Undecided::Budget);
        } else if !(found.open.is_empty() && found.hits.is_empty()) {
            undecided = Some(Undecided::Degenerate);
        }
    }
    workspace.work = Work {
        nodes: nodes - budget,
        contacts: usize::from(hit.is_some()),
        rays: 0,
    };
    AnyHit {
        hit,
        undecided,
        unsettled,
    }
}

/// The hits with all faces in order of t, as the memory's own.
pub(super) fn all_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    digits: Digits,
    budget: &mut usize,
    lines: &mut LineMemory,
) -> Option<Undecided> {
    let LineMemory {
        faces,
        face: found,
        hits: raw,
        unsettled,
    } = lines;
    raw.clear();
    *unsettled = None;
    found.one = false;
    let mut undecided = None;
    brep.faces_by_line(&stab.skewer(), |b| !stab.meets(b), faces);
    for face in faces.iter().copied() {
        if face_hits(brep, stab, face, digits, budget, found).is_none() {
            undecided = Some(Undecided::Degenerate);
            unsettled.get_or_insert(Unsettled { face, t: None });
            continue;
        }
        if !found.open.is_empty() {
            unsettled.get_or_insert_with(|| place_of_open(brep, stab, face, found));
            undecided = Some(if *budget == 0 {
                Undecided::Budget
            } else {
                Undecided::Degenerate
            });
        }
        if let Some(h) = found.hits.iter().find(|h| !h.inside) {
            unsettled.get_or_insert_with(|| place_of(h));
            undecided = Some(Undecided::Degenerate);
        }
        raw.append(&mut found.hits);
    }
    raw.sort_by(|a, b| {
        let by_t = a.t.mid.partial_cmp(&b.t.mid);
        by_t.unwrap_or(std::cmp::Ordering::Equal)
            .then(a.face.cmp(&b.face))
    });
    // Of equal ones that are exact, what is rounded tells no order.
    let equal = |a: &RawHit, b: &RawHit| match (&a.exact, &b.exact) {
        (Some(a), Some(b)) => a.t.is(&b.t),
        _ => false,
    };
    for run in raw.chunk_by_mut(equal) {
        run.sort_by_key(|h| h.face);
    }
    undecided
}

fn dress(brep: &PreparedBrep, stab: &Stabber, h: &RawHit) -> Option<Hit> {
    let (point, mut normal, uv) = match &h.at {
        HitAt::Patch {
            patch,
            local,
            point,
            ..
        } => {
            let maps = &brep.double(h.face).patches[*patch].maps;
            let uv = [0, 1].map(|k| maps[k].to_native(local[k]));
            let normal = patch_normal(brep, h.face, *patch, *local);
            (Vector3::from(*point), normal, uv)
        }
        HitAt::Closed { uv, point } => (
            Vector3::from_fn(|c, _| point[c].mid.hi),
            Vector3::from({
                let form = brep.closed(h.face).map(|f| &f.surface);
                let own = |f: &&ClosedSurface| h.exact.is_none() || f.profile_axis().is_some();
                match form.filter(own) {
                    Some(form) => form.normal(*uv),
                    None => brep.polygon(h.face)?.unit_normal(),
                }
            }),
            *uv,
        ),
    };
    if brep.brep().faces()[h.face].reversed {
        normal = -normal;
    }
    let norm = normal.norm();
    let parameter = |t: &Ball<Dd>| {
        let bounds = Enclosure {
            lo: t.lower().max(stab.range[0]),
            hi: t.upper().min(stab.range[1]),
        };
        Parameter {
            value: t.mid.hi.clamp(bounds.lo.min(bounds.hi), bounds.hi),
            bounds,
        }
    };
    Some(Hit {
        t: parameter(&h.t),
        t_end: h
            .exact
            .as_ref()
            .and_then(|m| Some(parameter(&m.end.as_ref()?.enclosed()))),
        point: point.into(),
        normal: if norm > 0.0 { normal / norm } else { normal },
        feature: Feature::Face(h.face),
        face: h.face,
        uv: Point2::new(uv[0], uv[1]),
        tangential: !h.crosses(),
    })
}

/// A vector along the normal of a patch at local parameters, rounded.
fn patch_normal(brep: &PreparedBrep, face: usize, patch: usize, local: [Dd; 2]) -> Vector3<f64> {
    let coarse = &brep.double(face).patches[patch].net;
    if jet::fits(coarse.degree) {
        let [h, s, t] = jet::jet1(coarse, local[0].hi, local[1].hi);
        let along = |d: &[f64; 4]| -> Vector3<f64> {
            Vector3::from_fn(|c, _| (d[c] - d[3] * (h[c] / h[3])) / h[3])
        };
        let normal = along(&s).cross(&along(&t));
        // In f64 a derivative is off by some roundings of the largest coordinate times the degree: not so near to nothing
        // that few digits of it are left.
        let size = coarse.largest[..3].iter().fold(0.0, |m: f64, x| m.max(*x)) / h[3];
        let degree = (coarse.degree.u + coarse.degree.v) as f64;
        if normal.norm() >= FEW_DIGITS * (degree * size).powi(2) {
            return normal;
        }
    }
    let fine = &brep.double_double(face).patches[patch].net;
    let jet = fine.jet(ball(local[0]), ball(local[1]));
    let w = jet.value[3];
    let along = |d: &[Ball<Dd>; 4]| -> Vector3<f64> {
        Vector3::from_fn(|c, _| ((d[c] - d[3] * (jet.value[c] / w)) / w).mid.hi)
    };
    along(&jet.s).cross(&along(&jet.t))
}

/// A normal shorter than this part of what the patch's size and degree allow is found in double-double.
const FEW_DIGITS: f64 = 1.0 / (1u64 << 12) as f64;

fn ball(x: Dd) -> Ball<Dd> {
    Ball { mid: x, rad: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::BrepBuilder;
    use crate::numeric::Interval;
    use crate::nurbs::Plane;
    use crate::query::LineKind;
    use nalgebra::Point3;

    /// A square in the plane z = 0, counter-clockwise seen from above or from below: that side is the outer one, whatever the plane's axes.
    #[test]
    fn the_normal_of_a_hit_is_on_the_outer_side() {
        let wide = Interval::new(-2.0, 2.0).unwrap();
        for (order, up) in [([0, 1, 2, 3], 1.0), ([3, 2, 1, 0], -1.0)] {
            let mut b = BrepBuilder::new();
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let v = corners.map(|[x, y]| b.vertex([x, y, 0.0]));
            let plane = Plane {
                origin: Point3::origin(),
                x: Vector3::x(),
                y: Vector3::y(),
                domain: [wide; 2],
                extents: [wide; 2],
            };
            b.face(plane, &[&order.map(|i| v[i])]).unwrap();
            let brep = PreparedBrep::new(b.build().unwrap());
            let down = LineProbe::new([0.25, 0.5, 1.0].into(), -Vector3::z(), LineKind::Line);
            let found = line(
                &brep,
                &down.unwrap(),
                &Options::default(),
                &mut Workspace::default(),
            );
            assert_eq!(found.hits.len(), 1);
            assert_eq!(found.hits[0].normal, Vector3::new(0.0, 0.0, up));
        }
    }
}
