//! NURBS curves.

use super::{GeometryError, KnotVector};
use crate::numeric::Interval;
use nalgebra::SVector;
use std::sync::Arc;

/// A NURBS curve with `H - 1` coordinates: the exact quotient of its
/// homogeneous spline. Weights are positive.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsCurve<const H: usize> {
    knots: KnotVector,
    /// Shared by copies, and by what is made of its spans.
    control_points: Arc<[SVector<f64, H>]>,
}

/// A NURBS curve in uv: homogeneous `(wu, wv, w)`.
pub type NurbsCurve2 = NurbsCurve<3>;
/// A NURBS curve in space: homogeneous `(wx, wy, wz, w)`.
pub type NurbsCurve3 = NurbsCurve<4>;

impl<const H: usize> NurbsCurve<H> {
    /// A curve from homogeneous control points (`(wx, .., w)`), all finite with
    /// positive weights, over `knots` (`control_points.len() + degree + 1` of them).
    pub fn new(
        degree: usize,
        control_points: Vec<SVector<f64, H>>,
        knots: Vec<f64>,
    ) -> Result<Self, GeometryError> {
        let knots = KnotVector::new(degree, control_points.len(), knots)?;
        check_control_points(&control_points)?;
        Ok(Self {
            knots,
            control_points: control_points.into(),
        })
    }

    /// Moves each homogeneous control point in place, or none.
    ///
    /// # Errors
    /// As [`new`](Self::new): one that moves to where none may be.
    pub fn move_points(
        &mut self,
        to: impl Fn(&SVector<f64, H>) -> SVector<f64, H>,
    ) -> Result<(), GeometryError> {
        for p in self.control_points.iter() {
            check_control_points(&[to(p)])?;
        }
        self.control_points = self.control_points.iter().map(to).collect();
        Ok(())
    }

    /// The knot vector.
    pub fn knots(&self) -> &KnotVector {
        &self.knots
    }

    /// The degree p.
    pub fn degree(&self) -> usize {
        self.knots.degree()
    }

    /// Homogeneous control points.
    pub fn control_points(&self) -> &[SVector<f64, H>] {
        &self.control_points
    }

    /// The same, shared.
    pub(crate) fn shared_points(&self) -> Arc<[SVector<f64, H>]> {
        self.control_points.clone()
    }

    /// The parameter domain.
    pub fn domain(&self) -> Interval {
        self.knots.domain()
    }

    /// Whether the weights differ.
    pub fn is_rational(&self) -> bool {
        is_rational(&self.control_points)
    }

    /// The same curve, of other weights: see [`scaled`].
    pub(super) fn with_scaled_weights(&self) -> Option<Self> {
        let control_points = scaled(&self.control_points)?;
        let knots = self.knots.clone();
        Some(Self {
            knots,
            control_points,
        })
    }
}

/// Homogeneous points times the power of two that brings the first weight to between 1 and 2: what they stand for is the same, exactly. `None` where it is
/// there, or a number would lose a digit. (The first, and not the largest: ends of trims are as often exactly on a border as their weights are 1.)
pub(super) fn scaled<const H: usize>(net: &[SVector<f64, H>]) -> Option<Arc<[SVector<f64, H>]>> {
    let first = net.first()?[H - 1];
    // Exponents of 1 to 2 less twice what they are: those of a normal number whose inverse is one.
    const ONE: u64 = 1.0f64.to_bits() >> 52;
    let by = f64::from_bits((2 * ONE).checked_sub(first.to_bits() >> 52)? << 52);
    if by == 1.0 || !by.is_normal() {
        return None;
    }
    let is_kept = |x: &f64| *x == 0.0 || (x * by).is_normal();
    let all_are = net.iter().all(|p| p.iter().all(is_kept));
    all_are.then(|| net.iter().map(|p| p * by).collect())
}

pub(super) fn is_rational<const H: usize>(net: &[SVector<f64, H>]) -> bool {
    net.iter().any(|p| p[H - 1] != net[0][H - 1])
}

pub(super) fn check_control_points<const H: usize>(
    net: &[SVector<f64, H>],
) -> Result<(), GeometryError> {
    for (index, p) in net.iter().enumerate() {
        if p.iter().any(|x| !x.is_finite()) {
            return Err(GeometryError::NotFinite {
                what: "a control point",
            });
        }
        let weight = p[H - 1];
        if weight <= 0.0 {
            return Err(GeometryError::Weight { index, weight });
        }
    }
    Ok(())
}
