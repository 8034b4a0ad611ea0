//! Whether a sphere or a half-space overlaps a BREP: the sign of the separation alone.

use super::answer::{Options, OverlapAnswer, Probe, Undecided};
use super::contact::FULL_FLOOR;
use super::objective::Objective;
use super::outcome::{Goal, Outcome, Width};
use super::search::minimize;
use super::{Work, Workspace, inside};
use crate::numeric::Dd;
use crate::prepare::PreparedBrep;
use crate::trim::Side;

/// Radii from this on have an exact square: a product of two f64 is two f64, unless it underflows.
const LEAST_SQUARED: f64 = 1e-140;

/// Whether the separation of a sphere or half-space, as [`contact`](super::contact) defines it, is below 0.
///
/// It is the same sign that `contact` proves at full accuracy, found with less: the search stops at the first point that
/// is proven to be nearer than the radius (or below the plane), and else puts aside whatever is proven not to be. The side
/// of a sphere's centre is asked only where no face comes that near. Of the options only the node budget counts.
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
    let mut search = |closed: bool| {
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
    let mut found = search(true);
    if is_near(&found).is_none() && found.used_closed {
        found = search(false);
    }
    let near = is_near(&found);
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
        (None, _) if found.budget_spent => answer(None, Some(Undecided::Budget)),
        (None, _) => answer(None, Some(Undecided::Precision)),
    }
}

fn answer(overlap: Option<bool>, undecided: Option<Undecided>) -> OverlapAnswer {
    OverlapAnswer { overlap, undecided }
}
