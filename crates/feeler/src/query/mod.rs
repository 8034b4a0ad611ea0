//! Queries and their answers.

mod answer;
mod contact;
mod forms;
mod inside;
mod leaf;
mod line;
mod node;
mod objective;
mod search;
mod upper;
mod zeros;

pub use answer::{
    Accuracy, Contact, ContactAnswer, Contacts, Feature, HalfSpace, Hit, LineAnswer, LineKind,
    LineProbe, Options, Probe, ProbeError, Separation, SideAnswer, Sphere, Undecided,
};

pub use contact::contact;
pub use inside::inside;
pub use line::line;

use crate::nurbs::SurfacePoint;
use crate::prepare::PreparedBrep;
use nalgebra::Point2;

/// Memory that queries reuse; owned by the caller, one a thread.
#[derive(Debug, Default)]
pub struct Workspace {}

/// The side of a point of a face's parameter space; `None` if there is no such face. Exact: see
/// [`trim`](crate::trim).
pub fn side(brep: &PreparedBrep, face: usize, uv: Point2<f64>) -> Option<SideAnswer> {
    if face >= brep.brep().faces().len() {
        return None;
    }
    let found = brep.region(face).side(uv);
    Some(SideAnswer {
        side: found.side,
        in_gap: found.in_gap,
        undecided: found.side.is_none().then_some(Undecided::Degenerate),
    })
}

/// The point of a face at `uv` (clamped to the surface's domain) and its first derivatives, with
/// bounds; `None` if there is no such face.
pub fn evaluate(brep: &PreparedBrep, face: usize, uv: Point2<f64>) -> Option<SurfacePoint> {
    if face >= brep.brep().faces().len() {
        return None;
    }
    let surface = brep.brep().surface(face);
    Some(surface.first_derivatives_with_bound(uv.x, uv.y))
}
