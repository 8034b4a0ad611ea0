//! Parameters, exact even through the linear maps of poly-curves.

use super::Scalar;
use crate::numeric::{Ball, Dd, Dyadic, Interval};
use crate::nurbs::KnotVector;
use std::cmp::Ordering;

/// Which span a parameter on a knot or joint belongs to, and so from which side
/// derivatives are taken there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Limit {
    /// The span above: `[u_i, u_{i+1})`, the last one closed.
    #[default]
    FromAbove,
    /// The span below: `(u_i, u_{i+1}]`, the first one closed.
    FromBelow,
}

/// The exact number `to.start + (t - from.start) (to.end - to.start) / (from.end - from.start)`,
/// or `t` itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parameter {
    t: f64,
    map: Option<(Interval, Interval)>,
    limit: Limit,
}

impl Parameter {
    /// `t` clamped to the domain; NaN to its start.
    pub(super) fn new(t: f64, domain: Interval, limit: Limit) -> Self {
        let t = if t.is_nan() {
            domain.start
        } else {
            t.clamp(domain.start, domain.end)
        };
        Self {
            t,
            map: None,
            limit,
        }
    }

    /// The same mapped linearly from one interval, which holds it, to another. Parameters that are
    /// mapped already are not mapped again: segments of poly-curves are no poly-curves.
    pub(super) fn mapped(self, from: Interval, to: Interval) -> Self {
        if from == to {
            return self;
        }
        let t = self.t.clamp(from.start, from.end);
        // The ends map to the ends exactly.
        let plain = if t == from.start {
            Some(to.start)
        } else if t == from.end {
            Some(to.end)
        } else {
            None
        };
        Self {
            t: plain.unwrap_or(t),
            map: plain.is_none().then_some((from, to)),
            limit: self.limit,
        }
    }

    /// The parameter less `x`.
    pub(super) fn minus<S: Scalar>(&self, x: f64) -> S {
        match self.map {
            None => S::difference(self.t, x),
            Some(_) => S::from_ball(self.ball_minus(x)),
        }
    }

    fn ball_minus(&self, x: f64) -> Ball<Dd> {
        let Some((from, to)) = self.map else {
            return Ball::difference(self.t, x);
        };
        let ratio = Ball::difference(to.end, to.start) / Ball::difference(from.end, from.start);
        // From the nearer end, so that the ends themselves keep all digits.
        if x == to.end {
            -(Ball::difference(from.end, self.t) * ratio)
        } else {
            let step = Ball::difference(self.t, from.start) * ratio;
            if x == to.start {
                step
            } else {
                Ball::difference(to.start, x) + step
            }
        }
    }

    /// Exactly how the parameter compares with `x`.
    #[inline]
    fn compare(&self, x: f64) -> Ordering {
        let Some((from, to)) = self.map else {
            return self.t.partial_cmp(&x).unwrap_or(Ordering::Less);
        };
        self.compare_mapped(from, to, x)
    }

    fn compare_mapped(&self, from: Interval, to: Interval, x: f64) -> Ordering {
        let near = self.ball_minus(x);
        if near.lower() > 0.0 {
            return Ordering::Greater;
        }
        if near.upper() < 0.0 {
            return Ordering::Less;
        }
        // All are finite: constructors see to it.
        let d = |v: f64| Dyadic::from_f64(v).unwrap_or(Dyadic::ZERO);
        let difference = |a: f64, b: f64| &d(a) - &d(b);
        let left = &difference(self.t, from.start) * &difference(to.end, to.start);
        let right = &difference(x, to.start) * &difference(from.end, from.start);
        left.cmp(&right)
    }

    /// The index of the interval between consecutive `breaks` (non-decreasing, at least two) that
    /// holds the parameter; never an empty one, if there is one that is not.
    pub(super) fn find(&self, breaks: &[f64]) -> usize {
        let above = match self.limit {
            Limit::FromAbove => {
                let n = breaks.partition_point(|b| self.compare(*b) != Ordering::Less);
                // At the end or past it: the last interval that is not empty.
                match breaks.last() {
                    Some(end) if n == breaks.len() => breaks.partition_point(|b| b < end),
                    _ => n,
                }
            }
            Limit::FromBelow => {
                let n = breaks.partition_point(|b| self.compare(*b) == Ordering::Greater);
                match breaks.first() {
                    Some(start) if n == 0 => breaks.partition_point(|b| b <= start),
                    _ => n,
                }
            }
        };
        above.clamp(1, breaks.len().saturating_sub(1).max(1)) - 1
    }

    /// The span of a knot vector that holds the parameter.
    pub(super) fn find_span(&self, knots: &KnotVector) -> usize {
        let p = knots.degree();
        p + self.find(&knots.knots()[p..=knots.control_points()])
    }

    /// How fast the parameter moves with `t`: the ratio of the map's lengths.
    pub(super) fn rate<S: Scalar>(from: Interval, to: Interval) -> S {
        if from == to {
            S::ONE
        } else {
            S::difference(to.end, to.start) / S::difference(from.end, from.start)
        }
    }

    /// `(1 - s, s)` with `s` the fraction of the interval at which the parameter lies.
    pub(super) fn fractions<S: Scalar>(&self, i: Interval) -> (S, S) {
        let length = S::difference(i.end, i.start);
        (
            -self.minus::<S>(i.end) / length,
            self.minus::<S>(i.start) / length,
        )
    }
}
