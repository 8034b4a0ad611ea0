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
        Some(self.over_same_knots(scaled(&self.control_points)?))
    }

    /// The same points, run through at another pace: of a curve of one Bezier span, whose weight `i` is multiplied by `c^i`. What was at part `s` of the domain is at
    /// `s / (s + c (1 - s))` then. `c` is the power of two that brings the last weight as near to the first as it may. `None` where it is there, or a number
    /// would lose a digit, or there are several spans.
    ///
    /// (Where weights rise along a span by 1:4096 to the first power, half of it is passed in the first part in 4096 of its parameter.)
    pub(super) fn with_even_weights(&self) -> Option<Self> {
        let degree = self.degree();
        if self.knots.spans().count() != 1 || !self.knots.is_clamped() {
            return None;
        }
        let [first, last] = [self.control_points.first()?, self.control_points.last()?];
        let [first, last] = [first, last].map(|p| exponent(p[H - 1]));
        let (rise, degree) = (last - first, i32::try_from(degree).ok()?);
        // Rounded, so that what is left is half a power of two a step at most.
        let step = (2 * rise + degree).div_euclid(2 * degree);
        let control_points = multiplied(&self.control_points, |i| power_of_two(-step * i as i32))?;
        Some(self.over_same_knots(control_points))
    }

    fn over_same_knots(&self, control_points: Arc<[SVector<f64, H>]>) -> Self {
        let knots = self.knots.clone();
        Self {
            knots,
            control_points,
        }
    }
}

/// Homogeneous points times the power of two that brings the first weight to between 1 and 2: what they stand for is the same, exactly. `None` where it is
/// there, or a number would lose a digit. (The first, and not the largest: ends of trims are as often exactly on a border as their weights are 1.)
pub(super) fn scaled<const H: usize>(net: &[SVector<f64, H>]) -> Option<Arc<[SVector<f64, H>]>> {
    let first = exponent(net.first()?[H - 1]);
    multiplied(net, |_| power_of_two(-first))
}

/// The exponent of the largest power of two that is no larger than a positive normal number.
fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 - EXPONENT_OF_ONE
}

/// Two to a power, if that is a normal number, else no number.
fn power_of_two(power: i32) -> f64 {
    if (f64::MIN_EXP - 1..f64::MAX_EXP).contains(&power) {
        f64::from_bits(((EXPONENT_OF_ONE + power) as u64) << 52)
    } else {
        f64::NAN
    }
}

/// Where an f64 has 1, its bits beside the sign and the digits are these.
const EXPONENT_OF_ONE: i32 = (1.0f64.to_bits() >> 52) as i32;

/// Homogeneous points, each times a power of two of its own. `None` where all of these are 1, or a number would lose a digit.
fn multiplied<const H: usize>(
    net: &[SVector<f64, H>],
    by: impl Fn(usize) -> f64,
) -> Option<Arc<[SVector<f64, H>]>> {
    let factors: Vec<_> = (0..net.len()).map(by).collect();
    let is_kept =
        |(p, by): (&SVector<f64, H>, &f64)| p.iter().all(|x| *x == 0.0 || (x * by).is_normal());
    let differs = factors.iter().any(|by| *by != 1.0);
    let pairs = || net.iter().zip(&factors);
    (differs && pairs().all(is_kept)).then(|| pairs().map(|(p, by)| p * *by).collect())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nurbs::Curve2;
    use nalgebra::Vector3;

    fn curve(weights: &[f64], knots: &[f64]) -> NurbsCurve<3> {
        let points = (0u8..).zip(weights);
        let points = points.map(|(i, w)| Vector3::new(f64::from(i), f64::from(i * i), 1.0) * *w);
        let degree = knots.len() - weights.len() - 1;
        NurbsCurve::new(degree, points.collect(), knots.to_vec()).unwrap()
    }

    fn weights(c: &NurbsCurve<3>) -> Vec<f64> {
        c.control_points().iter().map(|p| p[2]).collect()
    }

    /// What is at part `s` of the new curve is at `c s / (c s + 1 - s)` of the old one, if weight `i` was multiplied by `c^i`.
    #[test]
    fn even_weights_are_those_of_the_same_points() {
        const CUBIC: [f64; 8] = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        /// Some roundings of coordinates up to 9, in the points' and in the parameter, of which the old curve makes as much as weights differ a step: 8 times.
        const ROUNDED: f64 = 8.0 * 8.0 * 9.0 * f64::EPSILON;
        for (given, even) in [
            ([1.0, 8.0, 64.0, 512.0], [1.0, 1.0, 1.0, 1.0]),
            ([1.0, 3.0, 20.0, 100.0], [1.0, 0.75, 1.25, 100.0 / 64.0]),
            ([512.0, 64.0, 8.0, 1.5], [512.0, 512.0, 512.0, 768.0]),
        ] {
            let given = curve(&given, &CUBIC);
            let found = given.with_even_weights().unwrap();
            assert_eq!(weights(&found), even);
            let at = |c: &NurbsCurve<3>, t: f64| Curve2::Nurbs(c.clone()).point(t);
            let c = even[1] / weights(&given)[1];
            for k in 0..=32 {
                let s = f64::from(k) / 32.0;
                let old = at(&given, c * s / (c * s + 1.0 - s));
                assert!((at(&found, s) - old).norm() < ROUNDED, "{s}");
            }
        }
    }

    /// Weights that are even, knots inside, ends that are no control points, and digits that would be lost.
    #[test]
    fn what_has_no_other_pace_stays() {
        const LINE: [f64; 4] = [0.0, 0.0, 1.0, 1.0];
        /// Weights that rise by 2^997 a step: what they are multiplied by is no normal number.
        const STEEP: [f64; 3] = [1e-300, 1e-307, 1e300];
        for (weights, knots) in [
            (&[1.0, 1.0][..], &LINE[..]),
            (&[1.0, 0.75, 1.25], &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]),
            (&[1.0, 4.0, 16.0], &[0.0, 0.0, 0.5, 1.0, 1.0]),
            (&[1.0, 4.0, 16.0], &[0.0, 0.0, 1.0, 2.0, 3.0, 3.0]),
            (&STEEP, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]),
        ] {
            assert_eq!(
                curve(weights, knots).with_even_weights(),
                None,
                "{weights:?}"
            );
        }
    }
}
