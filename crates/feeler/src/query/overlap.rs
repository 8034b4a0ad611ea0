//! Whether a sphere or a half-space overlaps a BREP: the sign of the separation alone.

use super::answer::{Options, OverlapAnswer, Probe, Undecided};
use super::contact::FULL_FLOOR;
use super::objective::Objective;
use super::outcome::{Goal, Outcome, Width};
use super::search::{box_bound, minimize};
use super::{Work, Workspace, inside};
use crate::numeric::Dd;
use crate::prepare::PreparedBrep;
use crate::prepare::apart::{is_above, is_as_far};
use crate::trim::Side;

/// Radii from this on have an exact square: a product of two f64 is two f64, unless it underflows.
const LEAST_SQUARED: f64 = 1e-140;

/// Whether the separation of a sphere or half-space, as [`contact`](super::contact) defines it, is below 0.
///
/// It is the same sign that `contact` proves at full accuracy, found with less: the search stops at the first point that
/// is proven to be nearer than the radius (or below the plane), and else puts aside whatever is proven not to be. What is touched
/// is no overlap where exact numbers prove that (of planes, NURBS whose control points are not beyond, surfaces turned about the plane's normal or swept by a straight curve), and else
/// undecided. The side of a sphere's centre is asked only where no face comes that near. Of the options only the node budget counts.
///
/// What it allocates: see [`Workspace`].
pub fn overlap(
    brep: &PreparedBrep,
    probe: &Probe,
    options: &Options,
    workspace: &mut Workspace,
) -> OverlapAnswer {
    let (objective, radius) = match probe {
        Probe::Sphere(s) => (Objective::SquaredDistance(s.center), s.radius),
        Probe::HalfSpace(h) => (Objective::Height(h.normal, h.offset), 0.0),
    };
    workspace.work = Work::default();
    let exact = !objective.is_squared() || radius == 0.0 || radius >= LEAST_SQUARED;
    let least = if !objective.is_squared() {
        Dd::ZERO
    } else if exact {
        Dd::product(radius, radius)
    } else {
        // Above the square: what is not below this is not below the square; nothing is said of the rest.
        Dd::from(LEAST_SQUARED * LEAST_SQUARED)
    };
    let search = |closed: bool, workspace: &mut Workspace| {
        let found = minimize(
            brep,
            &objective,
            Goal {
                width: Width::Full {
                    floor: FULL_FLOOR * brep.size(),
                    radius,
                },
                all_below: None,
                extents: None,
                threshold: Some(least),
                budget: options.node_budget,
                closed,
                foot: false,
                hint: None,
            },
            &mut workspace.memory,
            None,
        );
        workspace.work.nodes += found.nodes;
        found
    };
    // Whether some face is nearer than the radius, or below the plane.
    let is_near = |found: &Outcome| {
        if exact && found.hi < least {
            Some(true)
        } else if found.lo >= least {
            Some(false)
        } else {
            None
        }
    };
    let both = |workspace: &mut Workspace| {
        let found = search(true, workspace);
        if is_near(&found).is_none() && found.used_closed {
            return search(false, workspace);
        }
        found
    };
    let mut found = both(workspace);
    if is_near(&found).is_none() && !found.budget_spent {
        // Of faces that it touches, exact numbers may tell that it does not enter them. (Of those whose boxes are apart from it the search knows.)
        let is_near = |f: &usize| {
            let own = brep.face_box(*f);
            own.is_none_or(|b| box_bound(&objective, b) < least)
        };
        let faces = (0..brep.brep().faces().len()).filter(is_near);
        let touched = faces.filter(|f| keeps_out(brep, *f, probe));
        workspace.memory.passed_over.extend(touched);
        if !workspace.memory.passed_over.is_empty() {
            found = both(workspace);
        }
    }
    workspace.memory.passed_over.clear();
    let (near, budget_spent) = (is_near(&found), found.budget_spent);
    workspace.memory.keep(found);
    if near == Some(true) {
        return answer(Some(true), None);
    }
    // No face is nearer than the radius, or it is not known: then a centre in material overlaps all the same.
    let material = match probe {
        Probe::Sphere(s) if brep.brep().is_closed() => {
            match inside(brep, s.center, workspace).side {
                Some(Side::Inside) => return answer(Some(true), None),
                Some(Side::Outside | Side::Boundary) => Some(false),
                None => None,
            }
        }
        _ => Some(false),
    };
    match (near, material) {
        (Some(false), Some(false)) => answer(Some(false), None),
        (Some(_), _) => answer(None, Some(Undecided::Degenerate)),
        (None, _) if budget_spent => answer(None, Some(Undecided::Budget)),
        (None, _) => answer(None, Some(Undecided::Degenerate)),
    }
}

/// Whether a ball or half-space is proven not to enter a face, in exact numbers.
fn keeps_out(brep: &PreparedBrep, face: usize, probe: &Probe) -> bool {
    match probe {
        Probe::Sphere(s) => is_as_far(brep, face, &s.center, s.radius),
        Probe::HalfSpace(h) => is_above(brep, face, &h.normal, h.offset),
    }
}

fn answer(overlap: Option<bool>, undecided: Option<Undecided>) -> OverlapAnswer {
    OverlapAnswer { overlap, undecided }
}
