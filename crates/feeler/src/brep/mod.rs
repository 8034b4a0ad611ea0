//! Boundary representations: faces, loops, trims, edges, vertices.
//!
//! A [`Brep`] is built once, by [`Brep::new`], the only place where its structure is
//! checked: every index in it is valid and every number finite. Defects of real parts (gaps,
//! wrong orientation, edges off their surfaces) are no errors: they are kept,
//! and [`defects`](Brep::defects) reports them. [`BrepBuilder`] makes BREPs by hand.

mod builder;
mod checks;
mod defect;
mod topology;

pub use builder::{BrepBuilder, BuildError, TrimSpec};
pub use defect::{Defect, Part, Severity};
pub use topology::{
    Brep, BrepError, BrepParts, Edge, Face, Iso, LARGEST_COORDINATE, LoopKind, TrimCurve, TrimKind,
    TrimLoop, Vertex,
};
