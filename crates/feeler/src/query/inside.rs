//! The side of a point in space, and lines near edges.

use super::answer::{LineKind, LineProbe, SideAnswer, Undecided};
use super::forms::{Stabber, range};
use super::line::all_hits;
use super::zeros::NOISE_FACTOR;
use crate::numeric::Real;
use crate::numeric::bernstein::largest;
use crate::prepare::closed::ClosedFace;
use crate::prepare::{Net, PreparedBrep};
use crate::trim::Side;
use nalgebra::{Point3, Vector3};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// Directions for the parity test: none along an axis or a diagonal, none near another.
const DIRECTIONS: [[f64; 3]; 8] = [
    [0.352, 0.521, 0.778],
    [-0.677, 0.283, 0.679],
    [0.187, -0.911, 0.367],
    [0.823, 0.149, -0.548],
    [-0.419, -0.713, -0.562],
    [0.566, -0.307, 0.765],
    [-0.231, 0.891, -0.391],
    [0.937, -0.263, 0.229],
];
/// A crack's width is sampled: it is taken this many times where it must not be missed.
pub(super) const CRACK_FACTOR: f64 = 2.0;
/// A parity ray keeps this far from edges, relative to the model's size, beyond the cracks: more than the
/// rounding of the crack's estimate.
pub(super) const CLEARANCE: f64 = 1.0 / (1u64 << 49) as f64;
/// Nodes that one direction may cost.
pub(super) const PARITY_BUDGET: usize = 20_000;

/// The side of a point in space: whether it is in the solid's material.
///
/// By the parity of certified hits along a ray that stays clear of every edge by twice the width of its
/// crack; several directions are tried. Open BREPs have no material: `Outside`. A point so near the
/// surface that the hit's enclosure holds it is undecided.
pub fn inside(
    brep: &PreparedBrep,
    point: Point3<f64>,
    _workspace: &mut super::Workspace,
) -> SideAnswer {
    let answer = |side, undecided| SideAnswer {
        side,
        in_gap: false,
        undecided,
    };
    if !brep.brep().is_closed() {
        return answer(Some(Side::Outside), None);
    }
    let clearance = CLEARANCE * brep.size();
    let faces = brep.brep().faces().len();
    let mut why = Undecided::Degenerate;
    for d in DIRECTIONS {
        let Ok(probe) = LineProbe::new(point, Vector3::from(d), LineKind::Ray) else {
            return answer(None, Some(Undecided::Degenerate));
        };
        let stab = Stabber::new(&probe);
        let mut budget = PARITY_BUDGET;
        if (0..faces).any(|f| near_boundary(brep, &stab, f, clearance, &mut budget)) {
            why = Undecided::Crack;
            continue;
        }
        let (hits, undecided) = all_hits(brep, &stab, &mut budget);
        if undecided.is_some() {
            why = Undecided::Degenerate;
            continue;
        }
        if hits.iter().any(|h| h.t.lower() <= 0.0) {
            // On the surface, up to the enclosure: no direction will tell.
            return answer(None, Some(Undecided::Degenerate));
        }
        let side = if hits.len() % 2 == 1 {
            Side::Inside
        } else {
            Side::Outside
        };
        return answer(Some(side), None);
    }
    answer(None, Some(why))
}

/// Whether the line comes within the width of a crack (taken [`CRACK_FACTOR`] times, plus `clearance`) of a
/// boundary piece of a face. Errs on the side of yes.
pub(super) fn near_boundary(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    clearance: f64,
    budget: &mut usize,
) -> bool {
    if let Some(b) = brep.face_box(face)
        && !stab.meets(&widened(b, CRACK_FACTOR * brep.widest_crack() + clearance))
    {
        return false;
    }
    if let Some(form) = brep.closed(face)
        && form.others.is_empty()
        && clear_of_curves(brep, stab, form, clearance)
    {
        return false;
    }
    let geometry = brep.double(face);
    let norms = [0, 1].map(|k| stab.normals[k].norm() * UP);
    for index in 0..geometry.piece_count() {
        let trim = geometry.piece_trim(index);
        let margin = CRACK_FACTOR * crack_of(brep, trim) + clearance;
        // |L_k| / w is the distance from plane k times |n_k|.
        let reach = norms.map(|n| margin * n);
        if let Some(b) = &geometry.patch_boxes[geometry.piece_patch(index)]
            && !stab.meets(&widened(b, margin))
        {
            continue;
        }
        let Some(space) = &geometry.piece(index).space else {
            return true;
        };
        if !near_curve(stab, space, reach, budget) {
            continue;
        }
        // f64 sees only so far: what it finds near is looked at again.
        let fine = &brep.double_double(face).piece(index).space;
        if fine
            .as_ref()
            .is_none_or(|space| near_curve(stab, space, reach, budget))
        {
            return true;
        }
    }
    false
}

fn widened(b: &[[f64; 2]; 3], margin: f64) -> [[f64; 2]; 3] {
    b.map(|r| [r[0] - margin, r[1] + margin])
}

/// The width of the crack along a trim (`None`: a gap between two).
fn crack_of(brep: &PreparedBrep, trim: Option<usize>) -> f64 {
    match trim.map(|t| brep.brep().parts().trims[t].edge) {
        Some(Some(edge)) => brep.cracks()[edge],
        // A pole.
        Some(None) => 0.0,
        // A gap between two trims.
        None => brep.widest_crack(),
    }
}

/// Whether the whole line is plainly clear of all boundary curves of a face in closed form.
fn clear_of_curves(brep: &PreparedBrep, stab: &Stabber, form: &ClosedFace, clearance: f64) -> bool {
    let d = stab.direction / stab.direction.norm();
    let (o, d) = (stab.origin.coords.into(), d.into());
    let slack = form.surface.pole_slack();
    form.curves.iter().all(|c| {
        let margin = CRACK_FACTOR * crack_of(brep, c.trim) + clearance + slack;
        c.shape.is_clear_of(&o, &d, margin)
    })
}

/// Whether both `|L_k| / w <= reach[k]` somewhere on a curve, as far as the arithmetic can tell.
fn near_curve<T: Real>(
    stab: &Stabber,
    space: &Net<T>,
    reach: [f64; 2],
    budget: &mut usize,
) -> bool {
    let mut stack = vec![(stab.forms(space), 0)];
    while let Some((node, depth)) = stack.pop() {
        let w = range(&node.c[3], node.error[3]);
        let clear = (0..2).any(|k| {
            let r = range(&node.c[k], node.error[k]);
            r[0] > reach[k] * w[1] * UP || r[1] < -reach[k] * w[1] * UP
        });
        if clear || node.beyond(stab) {
            continue;
        }
        let noise = (0..2).all(|k| largest(&node.c[k]) <= NOISE_FACTOR * node.error[k]);
        if *budget == 0 || noise || depth >= NEAR_DEPTH {
            return true;
        }
        *budget -= 1;
        stack.extend(node.halves(true).map(|half| (half, depth + 1)));
    }
    false
}

/// A part of a boundary piece this many halvings deep that is not clear of the line counts as near.
const NEAR_DEPTH: usize = 64;
