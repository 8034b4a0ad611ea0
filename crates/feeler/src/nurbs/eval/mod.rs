//! Points and derivatives of curves and surfaces, of any order, in any arithmetic.
//!
//! One implementation serves all number types (see [`Scalar`]): plain f64 for speed, and
//! [`Ball`](crate::numeric::Ball)s over f64 or double-double, which carry a proven error bound.
//!
//! # Parameters
//! Parameters are clamped to the domain (NaN to its start). At an interior knot, or a joint of
//! a polyline or poly-curve, a point belongs to the half-open span `[u_i, u_{i+1})`,
//! so that derivatives there are those from above ([`Limit::FromAbove`]); the last
//! span is closed. [`Limit::FromBelow`] asks for those from below. Spans are found by exact
//! comparisons, through the linear maps of poly-curves too.
//!
//! # Method
//! De Boor's algorithm on homogeneous control points (The NURBS Book, A3.1/A4.1 in the form
//! of de Boor's triangle), derivatives from the control points of the derivative splines
//! (equation 3.8 and A3.3), and the quotient rule for rational ones (A4.2, A4.4).
//! Arcs and revolutions by [`sin_cos`](crate::numeric::sin_cos).
//!
//! # A-priori error of `point` in f64
//! Let u = 2^-53 and gamma_n = n u / (1 - n u) (Higham, *Accuracy and Stability of Numerical Algorithms*,
//! 2nd ed., section 3.1). One step of de Boor's triangle with ratios
//! a + b = 1 (a the smaller) computes `p + a (q - p)`; `a` is a quotient of two rounded
//! differences (3 roundings), then come a difference, a product and a sum, so that the
//! error is at most gamma_6 (b |p| + a |q|), as `a |q - p| <= a |q| + b |p|`. Ratios are
//! not negative and weights positive, so p steps on homogeneous points give
//! each coordinate within gamma_{6p} sum B_i w_i |x_i| and the weight within relative gamma_{6p};
//! their quotient is within gamma_{12p+1} max |x_i|, the maximum over the
//! p + 1 active control points: **|error| <= gamma_{12p+1} max |x_i|** on each
//! coordinate, whatever the weights. Where the active weights are equal the quotient has no error of its
//! own: gamma_{6p} for weights 1. For a surface of degrees p and q read p + q for p. Arcs: 4 u times
//! (|centre coordinate| + radius); the other forms follow by their formulas.
//! These hold while no product overflows or falls below 2^-1022. Beyond (coordinates above 1e300, spans so
//! short that a derivative is that large) plain f64 results may be infinite or NaN; those with a bound are
//! then 0 with an infinite bound.

mod curve;
mod parameter;
mod scalar;
mod spline;
mod surface;
#[cfg(test)]
mod tests;

pub use parameter::Limit;
pub use scalar::Scalar;
pub use surface::{Partials, SurfacePoint, partials};

pub(super) use curve::frame;
pub(super) use surface::Rotation;
