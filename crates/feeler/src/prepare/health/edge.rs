//! The health of one edge.

use super::super::crack::{CLOSED, apart};
use super::super::image::{self, Image, distance};
use super::super::matching::{Pair, frechet, frechet_bytes};
use super::super::patch::{Patches, patch_counts};
use super::super::spline::{PieceCount, piece_count};
use super::super::vertex::end_region;
use super::super::{Box3, PreparedBrep, around};
use super::{Direction, EdgeHealth, FaceHealth, Offset, TINY, Turn};
use crate::brep::{Brep, Defect, LoopKind};
use crate::numeric::{Enclosure, Interval};
use crate::nurbs::{Curve3, Surface};
use std::collections::BTreeMap;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// The distances of the ends of two images where they run in one direction, and where they run against each other: the
/// larger of two ends each.
fn end_distances(a: &[Box3; 2], b: &[Box3; 2]) -> [Enclosure; 2] {
    [0, 1].map(|turned| {
        let [x, y] = [0, 1].map(|k| distance(&a[k], &b[k ^ turned]));
        Enclosure {
            lo: x.lo.max(y.lo),
            hi: x.hi.max(y.hi),
        }
    })
}

/// A bound below the Frechet distance, in the better direction: matched curves have their ends matched.
fn at_least(distances: &[Enclosure; 2]) -> f64 {
    distances[0].lo.min(distances[1].lo)
}

pub(super) fn health(
    brep: &PreparedBrep,
    edge: usize,
    faces: &[FaceHealth],
    defects: &[Defect],
) -> EdgeHealth {
    let parts = brep.brep().parts();
    let e = &parts.edges[edge];
    let face_of = |t: usize| brep.face_of(t);
    let ends: Vec<Option<[Box3; 2]>> = e
        .trims
        .iter()
        .map(|t| {
            let end = |last| end_region(brep, || brep.double(face_of(*t)), *t, last);
            Some([end(false)?, end(true)?])
        })
        .collect();
    let mut least: f64 = 0.0;
    for (i, a) in ends.iter().enumerate() {
        for b in &ends[i + 1..] {
            if let (Some(a), Some(b)) = (a, b) {
                least = least.max(at_least(&end_distances(a, b)));
            }
        }
    }
    let images: Option<Vec<Box3>> = e
        .trims
        .iter()
        .map(|t| Some(brep.trim_image(*t)?.bounds()))
        .collect();
    let reach = match images {
        Some(boxes) if !boxes.is_empty() => {
            let b = around(&boxes);
            let squares: f64 = b.iter().map(|r| (r[1] - r[0]).powi(2)).sum();
            squares.sqrt() * UP
        }
        _ => f64::INFINITY,
    };
    let mut widest = brep.crack_width(edge);
    // Below that f64 tells nothing about an edge whose ends agree, and double-double takes a hundred times as long.
    if widest > LEAST_LOOKED_AT * brep.size() {
        widest = brep.fine_crack_width(edge);
        least = least.max(brep.least_crack_width(edge));
    }
    let crack = Enclosure {
        lo: least.min(widest),
        hi: widest,
    };
    EdgeHealth {
        edge,
        faces: e.trims.iter().map(|t| face_of(*t)).collect(),
        crack,
        offsets: offsets(brep, edge, &e.trims, defects),
        reach,
        tolerance: e.tolerance,
        direction: direction(brep, (edge, reach), &ends, faces),
        is_tiny: reach <= (TINY * brep.size()).max(e.tolerance.unwrap_or(0.0)),
    }
}

/// How far the images of some of an edge's trims are from its own curve.
pub(super) fn offsets(
    brep: &PreparedBrep,
    edge: usize,
    trims: &[usize],
    defects: &[Defect],
) -> Vec<Offset> {
    let parts = brep.brep().parts();
    let e = &parts.edges[edge];
    let Some(curve) = e.curve.map(|c| &parts.curves3[c]) else {
        return Vec::new();
    };
    let own = image::of_curve(curve, e.span);
    let seen = |t: usize| {
        defects.iter().find_map(|d| match d {
            Defect::EdgeOffSurface { trim, distance, .. } if *trim == t => Some(*distance),
            _ => None,
        })
    };
    let offset = |&trim: &usize| {
        let at_most = at_most(brep.brep(), edge, trim, brep.trim_image(trim), own.as_ref());
        Offset {
            trim,
            at_most,
            // By samples it is an estimate from above.
            about: seen(trim).map(|about| about.min(at_most)),
        }
    };
    trims.iter().map(offset).collect()
}

/// See [`trim_offsets`](super::trim_offsets).
pub(super) fn offsets_alone(brep: &Brep, trims: &[usize], most_bytes: usize) -> Vec<Offset> {
    let parts = brep.parts();
    let mut of_faces: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &trim in trims {
        let face = parts.loops[parts.trims[trim].trim_loop].face;
        of_faces.entry(face).or_default().push(trim);
    }
    let mut all = Vec::new();
    for (face, trims) in of_faces {
        let surface = brep.surface(face);
        let [u, v] = patch_counts(surface);
        // Before any of them is made.
        let net = match surface {
            Surface::Nurbs(s) => size_of_val(s.control_net()),
            _ => 0,
        };
        let bytes = u.saturating_mul(v).saturating_mul(SLOT) + (u + v) * SPAN + net;
        let room = most_bytes.checked_sub(bytes);
        let mut patches = None;
        for trim in trims {
            let Some(edge) = parts.trims[trim].edge else {
                continue;
            };
            let Some(curve) = parts.edges[edge].curve else {
                continue;
            };
            let span = parts.edges[edge].span;
            let curve = &parts.curves3[curve];
            let room = room.and_then(|r| r.checked_sub(curves_bytes(brep, trim, curve, span)));
            let at_most = room.map_or(f64::INFINITY, |room| {
                // Those that others met make room.
                if patches
                    .as_ref()
                    .is_some_and(|p: &Patches<f64>| p.made() > room / 2)
                {
                    patches = None;
                }
                let patches = patches.get_or_insert_with(|| Patches::on_demand(surface));
                let image = image::image_alone(brep, patches, trim, room);
                let own = image.as_ref().and_then(|_| image::of_curve(curve, span));
                let to_match = image.as_ref().zip(own.as_ref()).map(|(i, own)| {
                    let pairs = i.stretches.len() * size_of::<Pair<f64>>();
                    pairs + i.bytes() + frechet_bytes::<f64>(i.order(), own.order())
                });
                if to_match.is_some_and(|bytes| bytes.saturating_add(patches.made()) > room) {
                    return f64::INFINITY;
                }
                at_most(brep, edge, trim, image.as_ref(), own.as_ref())
            });
            all.push(Offset {
                trim,
                at_most,
                about: None,
            });
        }
    }
    all
}

/// What a patch's slot takes, and what patches of one span of u or v are made of, beside a copy of a spline's net.
const SLOT: usize = 16;
const SPAN: usize = 1024;
/// What a piece of a trim takes, in two lists, and a control point of it.
const TRIM_PIECE: [usize; 2] = [176, 64];
/// The same of an edge's curve, which becomes an image, and one that is turned around.
const EDGE_PIECE: [usize; 2] = [640, 128];

/// What the pieces of a trim and of its edge's curve take.
fn curves_bytes(brep: &Brep, trim: usize, curve: &Curve3, span: Interval) -> usize {
    let trim = &brep.parts().trims[trim];
    let own = &brep.parts().curves2[trim.curve];
    let bytes = |count: PieceCount, [piece, point]: [usize; 2]| {
        let pieces = count.pieces.saturating_mul(piece);
        pieces.saturating_add(count.points.saturating_mul(point))
    };
    let own = piece_count(own, trim.span.start, trim.span.end);
    let curve = piece_count(curve, span.start, span.end);
    bytes(own, TRIM_PIECE).saturating_add(bytes(curve, EDGE_PIECE))
}

/// How far a trim's image is from that of its edge's curve at most.
fn at_most(
    brep: &Brep,
    edge: usize,
    trim: usize,
    image: Option<&Image<f64>>,
    own: Option<&Image<f64>>,
) -> f64 {
    let parts = brep.parts();
    let against = parts.edges[edge].reversed != parts.trims[trim].edge_reversed;
    let bound = image.zip(own).and_then(|(i, own)| apart(i, own, against));
    bound.unwrap_or(f64::INFINITY)
}

/// Cracks of no more than this part of the model's size are as good as rounding.
const LEAST_LOOKED_AT: f64 = 1.0 / (1u64 << 30) as f64;

/// One direction of two must be this many times better than the other to count.
const BETTER: f64 = 64.0;

/// Whether two images run against each other, where their ends do not tell (circles): as the bounds of their distances in both
/// directions say.
fn by_images(brep: &PreparedBrep, s: usize, t: usize) -> Option<bool> {
    let (a, b) = (brep.trim_image(s)?, brep.trim_image(t)?);
    let with = frechet(a, b)?;
    let turned = frechet(a, &b.clone().reversed())?;
    if BETTER * with < turned {
        Some(false)
    } else if BETTER * turned < with {
        Some(true)
    } else {
        None
    }
}

/// Whether material stays on one side: as the images run where they tell the direction, else as the file says.
fn direction(
    brep: &PreparedBrep,
    (edge, reach): (usize, f64),
    ends: &[Option<[Box3; 2]>],
    faces: &[FaceHealth],
) -> Direction {
    let parts = brep.brep().parts();
    let &[s, t] = &parts.edges[edge].trims[..] else {
        return Direction::NotTwo;
    };
    let rightly_turned = |trim: usize| {
        let l = parts.trims[trim].trim_loop;
        let said = matches!(parts.loops[l].kind, LoopKind::Outer | LoopKind::Inner);
        let mut loops = faces[parts.loops[l].face].loops.iter();
        said && loops.any(|x| x.trim_loop == l && x.turn != Turn::Undecided && !x.is_turned_wrong())
    };
    if !(rightly_turned(s) && rightly_turned(t)) {
        return Direction::Unknown;
    }
    let stored = parts.trims[s].edge_reversed != parts.trims[t].edge_reversed;
    let opposite = match ends {
        [Some(a), Some(b)] => {
            let [with, turned] = end_distances(a, b);
            // The ends of a closed edge are together: roundings tell them apart, and no direction.
            let told =
                |near: Enclosure, far: Enclosure| near.hi < far.lo && far.lo > CLOSED * reach;
            if told(with, turned) {
                false
            } else if told(turned, with) {
                true
            } else {
                by_images(brep, s, t).unwrap_or(stored)
            }
        }
        _ => stored,
    };
    let reversed = |trim: usize| parts.faces[brep.face_of(trim)].reversed;
    if opposite == (reversed(s) == reversed(t)) {
        Direction::Fits
    } else {
        Direction::Against
    }
}
