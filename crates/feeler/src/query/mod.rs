//! Queries and their answers.

mod answer;
mod contact;
mod leaf;
mod line;
mod node;
mod objective;
mod search;

pub use answer::{
    Accuracy, Contact, ContactAnswer, Contacts, Feature, HalfSpace, Hit, LineAnswer, LineKind,
    LineProbe, Options, Probe, ProbeError, Separation, SideAnswer, Sphere, Undecided,
};

pub use contact::contact;
pub use line::{inside, line};

use crate::prepare::PreparedBrep;
use nalgebra::{Point2, Point3, Vector3};

/// Memory that queries reuse; owned by the caller, one a thread.
#[derive(Debug, Default)]
pub struct Workspace {}

/// The side of a point of a face's parameter space; `None` if there is no such face.
pub fn side(_brep: &PreparedBrep, _face: usize, _uv: Point2<f64>) -> Option<SideAnswer> {
    None
}

/// A surface point and its first derivatives, with a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// The point.
    pub point: Point3<f64>,
    /// Derivative along u.
    pub du: Vector3<f64>,
    /// Derivative along v.
    pub dv: Vector3<f64>,
    /// Proven bound on the error of each coordinate of the point.
    pub bound: f64,
}

/// The point of a face at `uv` (clamped to the surface's domain) and its first derivatives;
/// `None` if there is no such face.
pub fn evaluate(_brep: &PreparedBrep, _face: usize, _uv: Point2<f64>) -> Option<Evaluation> {
    None
}
