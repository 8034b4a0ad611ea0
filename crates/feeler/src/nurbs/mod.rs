//! Knot vectors, curves and surfaces.
//!
//! Native forms (line, arc, polyline, poly-curve; plane, revolution, sum) keep
//! their exact meaning, stated at each type; every f64 they store is an exact
//! number. NURBS curves and surfaces are the exact quotients of their
//! homogeneous splines.
//!
//! Source: L. Piegl and W. Tiller, *The NURBS Book*, 2nd ed. (1997).

mod bezier;
mod conversion;
mod curve;
mod error;
pub mod eval;
mod knot_insertion;
mod knot_vector;
mod nurbs_curve;
mod nurbs_surface;
mod parameter_map;
mod surface;

pub use bezier::{BezierPatch, BezierPiece};
pub use conversion::{ConvertedCurve, ConvertedSurface};
pub use curve::{Arc, Curve, Curve2, Curve3, Line, PolyCurve, Polyline};
pub use error::GeometryError;
pub use eval::{Limit, Partials, Scalar, SurfacePoint};
pub use knot_vector::KnotVector;
pub use nurbs_curve::{NurbsCurve, NurbsCurve2, NurbsCurve3};
pub use nurbs_surface::NurbsSurface;
pub use parameter_map::ParameterMap;
pub use surface::{Plane, Revolution, Sum, Surface};
