//! Knot vectors and the span rule.

use super::GeometryError;
use crate::numeric::Interval;
use std::sync::Arc;

/// A non-decreasing knot vector with its degree: `n + p + 2` knots for `n + 1`
/// control points (The NURBS Book, section 2.2). Not necessarily clamped.
///
/// The domain is `[knots[p], knots[n + 1]]`; it is not empty, and no knot inside
/// it has a multiplicity above `p`.
#[derive(Clone, Debug, PartialEq)]
pub struct KnotVector {
    degree: usize,
    /// Shared by copies.
    knots: Arc<[f64]>,
}

impl KnotVector {
    /// The largest degree supported.
    pub const MAX_DEGREE: usize = 25;

    /// Checks and keeps `knots` for a spline of this degree with
    /// `control_points` control points.
    pub fn new(
        degree: usize,
        control_points: usize,
        knots: Vec<f64>,
    ) -> Result<Self, GeometryError> {
        if degree == 0 || degree > Self::MAX_DEGREE {
            return Err(GeometryError::Degree {
                degree,
                max: Self::MAX_DEGREE,
            });
        }
        if control_points < degree + 1 {
            return Err(GeometryError::TooFew {
                what: "control points",
                found: control_points,
                needed: degree + 1,
            });
        }
        let expected = control_points + degree + 1;
        if knots.len() != expected {
            return Err(GeometryError::KnotCount {
                found: knots.len(),
                expected,
            });
        }
        if knots.iter().any(|k| !k.is_finite()) {
            return Err(GeometryError::NotFinite { what: "a knot" });
        }
        if let Some(i) = knots.windows(2).position(|w| w[1] < w[0]) {
            return Err(GeometryError::KnotOrder { index: i + 1 });
        }
        let (first, last) = (knots[degree], knots[control_points]);
        if Interval::new(first, last).is_none() || !(last - first).is_finite() {
            return Err(GeometryError::EmptyInterval {
                what: "the domain of the knot vector",
            });
        }
        let mut start = 0;
        while start < knots.len() {
            let value = knots[start];
            let multiplicity = knots[start..].iter().take_while(|k| **k == value).count();
            if multiplicity > degree && first < value && value < last {
                return Err(GeometryError::KnotMultiplicity {
                    index: start,
                    multiplicity,
                    degree,
                });
            }
            start += multiplicity;
        }
        Ok(Self {
            degree,
            knots: knots.into(),
        })
    }

    /// The degree p.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Whether the first and the last control points are the curve's ends.
    pub(crate) fn is_clamped(&self) -> bool {
        let (p, k) = (self.degree(), self.knots());
        let last = k.len() - 1;
        // The outermost knots have no part in the curve.
        k[1] == k[p] && k[last - 1] == k[last - p]
    }

    /// All knots, non-decreasing.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The same, shared.
    pub(crate) fn shared(&self) -> Arc<[f64]> {
        self.knots.clone()
    }

    /// How many control points a spline over this knot vector has.
    pub fn control_points(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// `[knots[p], knots[n + 1]]`.
    pub fn domain(&self) -> Interval {
        Interval {
            start: self.knots[self.degree],
            end: self.knots[self.control_points()],
        }
    }

    /// The index `i` of the span `[knots[i], knots[i + 1])` that holds `u`; the
    /// last non-empty span is closed. `u` outside the domain (NaN too) gets the nearest
    /// span. Exact: comparisons only (The NURBS Book, A2.1). O(log n).
    pub fn find_span(&self, u: f64) -> usize {
        let n = self.control_points();
        let inside = &self.knots[self.degree..=n];
        if u >= inside[inside.len() - 1] {
            // The last non-empty span of the domain.
            let last = inside[inside.len() - 1];
            return self.degree + inside.partition_point(|k| *k < last) - 1;
        }
        let above = inside.partition_point(|k| *k <= u);
        // Below the domain (or NaN): the first non-empty span.
        if above == 0 {
            return self.degree + inside.partition_point(|k| *k <= inside[0]) - 1;
        }
        self.degree + above - 1
    }

    /// The non-empty spans of the domain, in order, as `(index, start, end)`.
    pub fn spans(&self) -> impl Iterator<Item = (usize, f64, f64)> + '_ {
        (self.degree..self.control_points())
            .map(|i| (i, self.knots[i], self.knots[i + 1]))
            .filter(|(_, a, b)| a < b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn span_rule_is_half_open_and_closed_at_the_end() {
        let k = KnotVector::new(2, 5, vec![0., 0., 0., 1., 1., 2., 2., 2.]).unwrap();
        for (u, span) in [
            (-1.0, 2),
            (0.0, 2),
            (1.0_f64.next_down(), 2),
            (1.0, 4),
            (2.0, 4),
            (3.0, 4),
            (f64::NAN, 2),
        ] {
            assert_eq!(k.find_span(u), span, "u = {u}");
        }
    }

    #[test]
    fn the_outermost_knots_do_not_count() {
        let is_clamped = |k: [f64; 6]| KnotVector::new(2, 3, k.to_vec()).unwrap().is_clamped();
        assert!(is_clamped([-9., 0., 0., 1., 1., 9.]) && is_clamped([0., 0., 0., 1., 1., 1.]));
        assert!(!is_clamped([0., 0., 0., 1., 2., 2.]) && !is_clamped([0., 0., 1., 2., 2., 2.]));
    }

    #[test]
    fn refuses_what_is_no_knot_vector() {
        use GeometryError as E;
        let new = |p, n, k: &[f64]| KnotVector::new(p, n, k.to_vec());
        assert!(matches!(new(0, 2, &[0., 1., 2.]), Err(E::Degree { .. })));
        assert!(matches!(new(1, 2, &[0., 0., 1.]), Err(E::KnotCount { .. })));
        assert!(matches!(
            new(1, 2, &[0., 0., 0., 0.]),
            Err(E::EmptyInterval { .. })
        ));
        // A domain whose length is no number; the second is only far away.
        assert!(matches!(
            new(1, 2, &[-1e308, -1e308, 1e308, 1e308]),
            Err(E::EmptyInterval { .. })
        ));
        assert!(new(1, 2, &[1e308, 1e308, 1.5e308, 1.5e308]).is_ok());
        assert!(matches!(
            new(1, 3, &[0., 0., f64::NAN, 1., 1.]),
            Err(E::NotFinite { .. })
        ));
        assert!(matches!(
            new(1, 4, &[0., 0., 0.5, 0.5, 1., 1.]),
            Err(E::KnotMultiplicity { index: 2, .. })
        ));
        assert!(matches!(
            new(1, 3, &[0., 0., 2., 1., 1.]),
            Err(E::KnotOrder { index: 3 })
        ));
    }
}
