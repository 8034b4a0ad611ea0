//! All hits of a line with a BREP; how they are found and proven is in the module `zeros`.

use super::answer::{AnyHit, Feature, Hit, LineAnswer, LineProbe, Options, Separation, Undecided};
use super::forms::Stabber;
use super::inside::{PARITY_BUDGET, near_edges};
use super::zeros::{Digits, HitAt, RawHit, face_hits, one_hit};
use super::{Work, Workspace};
use crate::numeric::{Ball, Dd, Enclosure};
use crate::prepare::PreparedBrep;
use nalgebra::{Point2, Vector3};

/// A node of the search for hits costs about as much as this many of the search for contacts.
const NODE_COST: usize = 4;

/// Two hits of one face nearer than this in the line's own length units, relative to the model's
/// size, on patches that share a border, are one.
const SAME_HIT: f64 = 1.0 / (1u64 << 36) as f64;
/// All hits of a line with the trimmed faces.
///
/// `hits` holds every parameter where the line meets a face, in order of `t`, each with a proven
/// enclosure; a hit on an edge is listed for each of its faces. `crossings` counts transversal passages, hits within
/// the width of a crack of each other at an edge counting once. A line that touches a face or runs in it, meets it within
/// rounding of its border, or passes an edge that two faces share within its crack is `Undecided`, with what was found.
pub fn line(
    brep: &PreparedBrep,
    probe: &LineProbe,
    options: &Options,
    workspace: &mut Workspace,
) -> LineAnswer {
    let stab = Stabber::new(probe);
    let nodes = options.node_budget / NODE_COST;
    let mut budget = nodes;
    let (raw, mut undecided) = all_hits(brep, &stab, Digits::All, &mut budget);
    // A closed range of t: a hit whose enclosure holds an end of it is not settled.
    let at_end = |h: &RawHit| {
        stab.range.iter().any(|e| {
            e.is_finite()
                && h.t.lower() <= *e
                && *e <= h.t.upper()
                && h.t.rad > 0.0
                && h.t.mid != Dd::from(*e)
        })
    };
    if raw.iter().any(at_end) {
        undecided = Some(Undecided::Degenerate);
    }
    // Off every edge by more than its crack, each hit is a crossing of its own, and there is no crack to
    // pass. Else whether hits merge hangs on the exact widths of cracks: undecided.
    let mut near = PARITY_BUDGET;
    if near_edges(brep, &stab, &mut near) {
        undecided.get_or_insert(Undecided::Crack);
    }
    // Only what is certain is listed.
    let hits: Vec<Hit> = raw
        .iter()
        .filter(|h| h.inside)
        .filter_map(|h| dress(brep, &stab, h))
        .collect();
    workspace.work = Work {
        nodes: nodes - budget + PARITY_BUDGET - near,
        contacts: hits.len(),
        rays: 0,
    };
    LineAnswer {
        hits,
        crossings: raw.len(),
        in_crack: false,
        undecided,
    }
}

/// Whether the line meets any trimmed face, and a hit if it does.
///
/// Stops at the first hit that is certain; without one, either no face is met (proven), or it is `Undecided`. It counts no
/// crossings, so it does not look at edges. Of the options only the node budget counts.
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
    let mut hit = None;
    for face in 0..brep.brep().faces().len() {
        if brep.face_box(face).is_some_and(|b| !stab.meets(b)) {
            continue;
        }
        let Some(found) = one_hit(brep, &stab, face, &mut budget) else {
            undecided = Some(Undecided::Degenerate);
            continue;
        };
        let certain = found.hits.iter().find(|h| h.is_certain(&stab));
        hit = certain.and_then(|h| dress(brep, &stab, h));
        if hit.is_some() {
            undecided = None;
            break;
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
    AnyHit { hit, undecided }
}

/// The hits with all faces in order of t, those on a shared border of two patches of a face once.
pub(super) fn all_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    digits: Digits,
    budget: &mut usize,
) -> (Vec<RawHit>, Option<Undecided>) {
    let mut raw: Vec<RawHit> = Vec::new();
    let mut undecided = None;
    let apart = SAME_HIT * brep.size() / stab.direction.norm();
    for face in 0..brep.brep().faces().len() {
        if brep.face_box(face).is_some_and(|b| !stab.meets(b)) {
            continue;
        }
        let Some(found) = face_hits(brep, stab, face, digits, budget) else {
            undecided = Some(Undecided::Degenerate);
            continue;
        };
        if !found.open.is_empty() {
            undecided = Some(if *budget == 0 {
                Undecided::Budget
            } else {
                Undecided::Degenerate
            });
        }
        let first = raw.len();
        for hit in found.hits {
            if !hit.inside {
                undecided = Some(Undecided::Degenerate);
            }
            let same = raw[first..].iter().any(|o: &RawHit| {
                on_two_patches(o, &hit)
                    && (o.t.mid - hit.t.mid).hi.abs() <= apart
                    && on_border(o)
                    && on_border(&hit)
            });
            if !same {
                raw.push(hit);
            }
        }
    }
    raw.sort_by(|a, b| {
        let by_t = a.t.mid.partial_cmp(&b.t.mid);
        by_t.unwrap_or(std::cmp::Ordering::Equal)
            .then(a.face.cmp(&b.face))
    });
    (raw, undecided)
}

fn on_two_patches(a: &RawHit, b: &RawHit) -> bool {
    match (&a.at, &b.at) {
        (HitAt::Patch { patch: p, .. }, HitAt::Patch { patch: q, .. }) => p != q,
        _ => false,
    }
}

fn on_border(h: &RawHit) -> bool {
    let near = SAME_HIT;
    let HitAt::Patch { local, .. } = &h.at else {
        return false;
    };
    local.iter().any(|x| x.hi <= near || x.hi >= 1.0 - near)
}

fn dress(brep: &PreparedBrep, stab: &Stabber, h: &RawHit) -> Option<Hit> {
    let (point, mut normal, uv) = match &h.at {
        HitAt::Patch { patch, local, .. } => {
            let patch = &brep.double_double(h.face).patches[*patch];
            let jet = patch.net.jet(ball(local[0]), ball(local[1]));
            let w = jet.value[3];
            let point = Vector3::from_fn(|c, _| {
                (jet.value[c] / w + Ball::exact(patch.net.origin[c])).mid.hi
            });
            let along = |d: &[Ball<Dd>; 4]| -> Vector3<f64> {
                Vector3::from_fn(|c, _| ((d[c] - d[3] * (jet.value[c] / w)) / w).mid.hi)
            };
            let uv = [0, 1].map(|k| patch.maps[k].to_native(local[k].hi));
            (point, along(&jet.s).cross(&along(&jet.t)), uv)
        }
        HitAt::Closed { uv, point } => (
            Vector3::from_fn(|c, _| point[c].mid.hi),
            Vector3::from(brep.closed(h.face)?.surface.normal(*uv)),
            *uv,
        ),
    };
    if brep.brep().faces()[h.face].reversed {
        normal = -normal;
    }
    let norm = normal.norm();
    let bounds = Enclosure {
        lo: h.t.lower().max(stab.range[0]),
        hi: h.t.upper().min(stab.range[1]),
    };
    Some(Hit {
        t: Separation {
            value: h.t.mid.hi.clamp(bounds.lo.min(bounds.hi), bounds.hi),
            bounds,
        },
        t_end: None,
        point: point.into(),
        normal: if norm > 0.0 { normal / norm } else { normal },
        feature: Feature::Face(h.face),
        face: h.face,
        uv: Point2::new(uv[0], uv[1]),
        tangential: false,
    })
}

fn ball(x: Dd) -> Ball<Dd> {
    Ball { mid: x, rad: 0.0 }
}
