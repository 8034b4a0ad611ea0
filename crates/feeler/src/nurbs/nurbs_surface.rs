//! NURBS surfaces.

use super::nurbs_curve::{check_control_points, is_rational, scaled};
use super::{GeometryError, KnotVector};
use crate::numeric::Interval;
use nalgebra::Vector4;
use std::sync::Arc;

/// A tensor-product NURBS surface: the exact quotient of its homogeneous
/// spline. Weights are positive.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsSurface {
    knots_u: KnotVector,
    knots_v: KnotVector,
    /// Shared by copies: patches are made from one.
    control_net: Arc<[Vector4<f64>]>,
}

impl NurbsSurface {
    /// A surface from homogeneous control points `(wx, wy, wz, w)`, row by row:
    /// point `(i, j)` at `i * count_v + j`, `i` along u.
    pub fn new(
        degrees: [usize; 2],
        counts: [usize; 2],
        control_net: Vec<Vector4<f64>>,
        knots: [Vec<f64>; 2],
    ) -> Result<Self, GeometryError> {
        let [ku, kv] = knots;
        let knots_u = KnotVector::new(degrees[0], counts[0], ku)?;
        let knots_v = KnotVector::new(degrees[1], counts[1], kv)?;
        if Some(control_net.len()) != counts[0].checked_mul(counts[1]) {
            return Err(GeometryError::TooFew {
                what: "control points",
                found: control_net.len(),
                needed: counts[0].saturating_mul(counts[1]),
            });
        }
        check_control_points(&control_net)?;
        Ok(Self {
            knots_u,
            knots_v,
            control_net: control_net.into(),
        })
    }

    /// The knot vector along u.
    pub fn knots_u(&self) -> &KnotVector {
        &self.knots_u
    }

    /// The knot vector along v.
    pub fn knots_v(&self) -> &KnotVector {
        &self.knots_v
    }

    /// Homogeneous control points, row by row: `(i, j)` at `i * count_v + j`.
    pub fn control_net(&self) -> &[Vector4<f64>] {
        &self.control_net
    }

    /// How many control points along u and along v.
    pub fn counts(&self) -> [usize; 2] {
        [self.knots_u.control_points(), self.knots_v.control_points()]
    }

    /// The parameter domain, u and v.
    pub fn domain(&self) -> [Interval; 2] {
        [self.knots_u.domain(), self.knots_v.domain()]
    }

    /// Whether the weights differ.
    pub fn is_rational(&self) -> bool {
        is_rational(&self.control_net)
    }

    /// The same surface, of other weights: see [`scaled`].
    pub(super) fn with_scaled_weights(&self) -> Option<Self> {
        let control_net = scaled(&self.control_net)?;
        let (knots_u, knots_v) = (self.knots_u.clone(), self.knots_v.clone());
        Some(Self {
            knots_u,
            knots_v,
            control_net,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nurbs::NurbsCurve;

    /// Weights that are all 2 are no less equal than weights of 1.
    #[test]
    fn rational_is_what_has_weights_that_differ() {
        let points = |w: f64| {
            [2.0, 2.0, 2.0, w]
                .map(|w| Vector4::new(0., 0., w, w))
                .to_vec()
        };
        let knots = || vec![0., 0., 1., 1.];
        let surface = |w| NurbsSurface::new([1, 1], [2, 2], points(w), [knots(), knots()]).unwrap();
        assert!(surface(3.0).is_rational() && !surface(2.0).is_rational());
        for w in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let refused = NurbsSurface::new([1, 1], [2, 2], points(w), [knots(), knots()]);
            let expected = if w.is_finite() {
                matches!(refused, Err(GeometryError::Weight { index: 3, .. }))
            } else {
                matches!(refused, Err(GeometryError::NotFinite { .. }))
            };
            assert!(expected, "{w}");
        }
        let curve = |w| NurbsCurve::new(1, points(w)[2..].to_vec(), knots()).unwrap();
        assert!(curve(3.0).is_rational() && !curve(2.0).is_rational());
    }

    /// A part is refused where one of its sides alone is not within the domain, or empty.
    #[test]
    fn parts_lie_within_the_domain() {
        let points = [[0., 0.], [0., 3.], [2., 0.], [2., 3.]];
        let points = points.map(|[x, y]| Vector4::new(x, y, 0., 1.)).to_vec();
        let knots = [vec![0., 0., 2., 2.], vec![0., 0., 3., 3.]];
        let s = NurbsSurface::new([1, 1], [2, 2], points, knots).unwrap();
        for bad in [
            [-0.5, 1.0],
            [1.0, 3.5],
            [1.0, 1.0],
            [1.5, 0.5],
            [f64::NAN, 1.0],
        ] {
            for (u, v) in [(bad, [0.5, 1.0]), ([0.5, 1.0], bad), (bad, bad)] {
                assert!(matches!(
                    s.restricted(u, v),
                    Err(GeometryError::EmptyInterval { .. })
                ));
            }
        }
        // The identity in x and y.
        let part = s.restricted([0.5, 2.0], [1.0, 1.5]).unwrap();
        let corners: Vec<_> = part.control_net().iter().map(|p| [p.x, p.y]).collect();
        assert_eq!(corners, [[0.5, 1.0], [0.5, 1.5], [2.0, 1.0], [2.0, 1.5]]);
    }
}
