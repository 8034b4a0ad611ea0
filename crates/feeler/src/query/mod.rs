//! Queries and their answers.

mod advance;
mod answer;
mod arrival;
pub mod batch;
mod beside;
mod border;
mod bunch;
mod certify;
mod closed;
mod contact;
mod continuum;
mod foothold;
mod forms;
mod front;
mod grazes;
mod hit_side;
mod inside;
mod joints;
mod leaf;
mod level;
mod line;
mod list;
mod local;
mod near_trim;
mod nearest;
mod node;
mod normal;
mod objective;
mod on_face;
mod one_sphere;
mod outcome;
mod overlap;
mod passages;
mod past;
mod place;
mod plain_zero;
mod poles;
mod refine;
mod round;
mod rows;
mod runs;
mod search;
mod settle;
mod shape;
mod steady;
mod task;
mod trail;
mod upon;
mod upper;
mod whole_faces;
mod zeros;

pub use answer::{
    Accuracy, AnyHit, Contact, ContactAnswer, Contacts, Feature, HalfSpace, Hit, LineAnswer,
    LineKind, LineProbe, Options, OverlapAnswer, Parameter, Probe, ProbeError, Separation,
    SideAnswer, Sphere, Undecided, Unsettled,
};

pub use advance::{StraightWay, Way, arrival_along};
pub use arrival::{ArrivalAnswer, Motion, arrival, contact_on_arrival};
pub use contact::{Witness, contact, contact_from};
pub use inside::inside;
pub use line::{any_hit, line};
pub use overlap::overlap;
pub use past::arrival_past;

use crate::nurbs::SurfacePoint;
use crate::prepare::PreparedBrep;
use crate::trim::{AxisSplit, trim_split};
use nalgebra::Point2;

/// Memory that queries reuse; owned by the caller, one a thread.
///
/// **What is allocated all the same**, when workspace and BREP have been used about such places before: the lists of the answer, and
/// - of a ball or a half-space nothing else where planes, native quadrics or recognised spheres answer; on NURBS and trimmed faces some tens of small
///   lists, where a trim is cut to be proven on its patch or the search goes on in double-double. A list of all contacts takes up to
///   some thousands.
/// - of an overlap the same, but one list on a native sphere and up to some hundred of a half-space with polygons;
/// - of a line a few for each native quadric, some tens for a NURBS face and hundreds where many boxes are cut;
/// - of an arrival what its queries take, up to some hundreds;
/// - of a point's side in uv nothing; in space as of a line, without the answer's list;
/// - of an evaluation up to some tens.
///
/// The test `allocations` holds each to what it takes on some BREPs.
#[derive(Debug, Default)]
pub struct Workspace {
    pub(crate) work: Work,
    pub(crate) memory: task::Memory,
    pub(crate) lines: line::LineMemory,
}

impl Workspace {
    /// What the last query of a sphere, half-space or line cost, in counts that are the same on any machine.
    pub fn work(&self) -> Work {
        self.work
    }
}

/// What a query cost, counted. The counts are no promise: they change as the kernel gets better.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Boxes, faces and formulas that were looked at for a minimum, or boxes for hits.
    pub nodes: usize,
    /// Contacts or hits made, with foot and normal.
    pub contacts: usize,
    /// Rays cast to tell whether a point is in material.
    pub rays: usize,
}

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

/// Where the coordinates of trim `trim` of loop `trim_loop` of a face (counted from 0) are stationary: see
/// [`trim_split`]. `None` if there is no such trim; within, if double-double does not settle it.
pub fn split(
    brep: &PreparedBrep,
    face: usize,
    trim_loop: usize,
    trim: usize,
) -> Option<Option<[AxisSplit; 2]>> {
    let parts = brep.brep().parts();
    let loops = brep.brep().faces().get(face)?.loops.as_ref()?;
    let trims = &parts.loops[*loops.get(trim_loop)?].trims;
    let trim = &parts.trims[*trims.get(trim)?];
    Some(trim_split(trim, brep.given_curve(trim.curve)))
}

/// The point of a face at `uv`, each moved to the nearer end of the surface's domain first if it is outside, and its first derivatives, with
/// bounds; `None` if there is no such face.
pub fn evaluate(brep: &PreparedBrep, face: usize, uv: Point2<f64>) -> Option<SurfacePoint> {
    if face >= brep.brep().faces().len() {
        return None;
    }
    let surface = brep.brep().surface(face);
    Some(surface.first_derivatives_with_bound(uv.x, uv.y))
}

#[cfg(test)]
mod tests;
