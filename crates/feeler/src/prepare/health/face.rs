//! The health of one face.

use super::super::image::{distance, point, steepest};
use super::super::{Homogeneous, PreparedBrep};
use super::{FaceHealth, Gap, LoopHealth, Turn};
use crate::brep::LoopKind;
use crate::numeric::{Ball, Enclosure};
use crate::trim::{BoundaryPiece, PieceOrigin};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// The ends of a segment of the boundary, in balls.
fn ends(piece: &BoundaryPiece) -> Option<[Homogeneous<f64, 3>; 2]> {
    let radius = piece.radius();
    let ball = |p: &[f64; 3]| -> Homogeneous<f64, 3> {
        std::array::from_fn(|c| Ball {
            mid: p[c],
            rad: radius[c],
        })
    };
    let points = piece.control_points();
    Some([ball(points.first()?), ball(points.last()?)])
}

/// How long the segment is in uv.
fn length_in_uv([a, b]: &[Homogeneous<f64, 3>; 2]) -> Enclosure {
    let square = |c: usize| {
        // Exact where the weights are 1.
        let d = if a[2].rad == 0.0 && b[2].rad == 0.0 && a[2].mid == 1.0 && b[2].mid == 1.0 {
            a[c] - b[c]
        } else {
            a[c] / a[2] - b[c] / b[2]
        };
        d.square()
    };
    let length = (square(0) + square(1)).sqrt();
    Enclosure {
        lo: length.lower().max(0.0),
        hi: length.upper(),
    }
}

fn turn(area: &Enclosure) -> Turn {
    if area.lo > 0.0 {
        Turn::CounterClockwise
    } else if area.hi < 0.0 {
        Turn::Clockwise
    } else {
        Turn::Undecided
    }
}

pub(super) fn health(brep: &PreparedBrep, face: usize) -> FaceHealth {
    let parts = brep.brep().parts();
    let region = brep.region(face);
    let geometry = brep.double(face);
    let meetings = region.meetings();
    let mut loops: Vec<LoopHealth> = parts.faces[face]
        .loops
        .iter()
        .flatten()
        .map(|&trim_loop| {
            let area = region.loop_area(trim_loop);
            LoopHealth {
                trim_loop,
                kind: parts.loops[trim_loop].kind,
                turn: turn(&area),
                area,
                gaps: Vec::new(),
            }
        })
        .collect();
    for piece in region.pieces() {
        let PieceOrigin::Join { trim_loop, trim } = piece.origin else {
            continue;
        };
        let Some(of) = loops.iter_mut().find(|l| l.trim_loop == trim_loop) else {
            continue;
        };
        let Some(both) = ends(&piece) else {
            continue;
        };
        let boxes = [point(geometry, &both[0]), point(geometry, &both[1])];
        of.gaps.push(Gap {
            after: trim,
            uv: length_in_uv(&both),
            space: match &boxes {
                [Some(a), Some(b)] => distance(a, b),
                _ => Enclosure {
                    lo: 0.0,
                    hi: f64::INFINITY,
                },
            },
        });
    }
    // A simple loop's interior is what it runs around, once; the region lies in that of the outer loops. (What loops do at gaps, they
    // do within the gap: no more than rounding where the gap is; else the loop is not simple.)
    let simple = meetings.found.is_empty() && meetings.more == 0;
    let in_uv = match &parts.faces[face].loops {
        None => {
            let [u, v] = region.domain();
            u.length() * v.length()
        }
        Some(_) if simple => {
            let inner = |l: &LoopHealth| l.kind == LoopKind::Inner;
            let size = |l: &LoopHealth| l.area.hi.abs().max(l.area.lo.abs());
            let only_inner = loops.iter().all(inner);
            let outer = loops.iter().filter(|l| only_inner || !inner(l));
            outer.map(size).sum::<f64>() * UP
        }
        Some(_) => f64::INFINITY,
    };
    // |S_u x S_v| <= |S_u| |S_v|.
    let stretch = steepest(geometry).map_or(f64::INFINITY, |s| s[0] * s[1]);
    let area = if in_uv == 0.0 {
        0.0
    } else {
        in_uv * stretch * UP
    };
    FaceHealth {
        face,
        loops,
        meetings,
        area,
        border: border(brep, face),
    }
}

/// A bound below the length of a face's border: the chords of its images' stretches.
fn border(brep: &PreparedBrep, face: usize) -> f64 {
    let parts = brep.brep().parts();
    let mut sum = 0.0;
    for &l in parts.faces[face].loops.iter().flatten() {
        for &t in &parts.loops[l].trims {
            let Some(image) = brep.trim_image(t) else {
                continue;
            };
            for s in &image.stretches {
                let ends = [false, true].map(|last| super::super::image::end_box(s, last));
                sum += distance(&ends[0], &ends[1]).lo;
            }
        }
    }
    // As many sums as stretches, each off by a rounding: far fewer than 2^20.
    sum * (1.0 - f64::EPSILON * f64::from(1 << 20))
}
