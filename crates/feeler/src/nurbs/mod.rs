//! Knot vectors, curves and surfaces.
//!
//! Native forms (line, arc, polyline, poly-curve; plane, revolution, sum) keep
//! their exact meaning, stated at each type; every f64 they store is an exact
//! number. NURBS curves and surfaces are the exact quotients of their
//! homogeneous splines.
//!
//! Source: L. Piegl and W. Tiller, *The NURBS Book*, 2nd ed. (1997).

mod curve;
mod error;
pub mod eval;
mod knot_vector;
mod nurbs_curve;
mod nurbs_surface;
mod surface;

pub use curve::{Arc, Curve, Curve2, Curve3, Line, PolyCurve, Polyline};
pub use error::GeometryError;
pub use eval::{Limit, Partials, Scalar, SurfacePoint};
pub use knot_vector::KnotVector;
pub use nurbs_curve::{NurbsCurve, NurbsCurve2, NurbsCurve3};
pub use nurbs_surface::NurbsSurface;
pub use surface::{Plane, Revolution, Sum, Surface};
