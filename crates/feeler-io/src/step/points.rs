//! Points of edges' curves, many of each.
//!
//! The kernel evaluates an arc to the last digit, in double-double, its frame anew each time; where thousands of points are compared with a surface whose
//! points are found in f64, f64 is enough. Of an arc from `a` to `b`, neither farther than 4 pi from 0, a point is off by at most
//! - 3 roundings of its angle, of numbers up to 4 pi: `1.5 x 13` units times the radius;
//! - its frame, orthogonal and of length 1 up to a dozen roundings; sine and cosine, one each; four more of the sum,
//!
//! in all less than 32 units of [`f64::EPSILON`] times the radius, and one of the largest coordinate: half of [`FORMULA`](super::pcurve::FORMULA), as
//! much as a spline of degree 16 takes. Other curves are the kernel's; searches, which carry no proof, take splines by basis functions ([`net`]).

use super::net;
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve3, Limit};
use libm::sincos;
use nalgebra::{Point3, Vector3};
use std::cmp::Ordering;

/// What arcs are evaluated by in f64, in radians from 0.
const MOST_ANGLE: f64 = 12.6;

pub(super) struct Points<'c> {
    pub(super) curve: &'c Curve3,
    arc: Option<Turning>,
    /// Where the derivative from below may be another.
    breaks: Vec<f64>,
}

struct Turning {
    center: Point3<f64>,
    /// The frame, times the radius.
    x: Vector3<f64>,
    y: Vector3<f64>,
    angle: Interval,
    domain: Interval,
    /// Radians for a unit of the parameter.
    rate: f64,
}

impl<'c> Points<'c> {
    pub(super) fn of(curve: &'c Curve3) -> Self {
        let arc = match curve {
            Curve::Arc(a) if a.angle.start.abs().max(a.angle.end.abs()) <= MOST_ANGLE => {
                let z = a.z.normalize();
                let x = (a.x - z * a.x.dot(&z)).normalize();
                Some(Turning {
                    center: a.center,
                    x: x * a.radius,
                    y: z.cross(&x) * a.radius,
                    angle: a.angle,
                    domain: a.domain,
                    rate: a.angle.length() / a.domain.length(),
                })
            }
            _ => None,
        };
        Self {
            curve,
            arc,
            breaks: curve.breaks(),
        }
    }

    /// Of its pieces; of an arc it is what an ellipse has, twice.
    pub(super) fn degree(&self) -> usize {
        match self.curve {
            Curve::Nurbs(n) => n.degree(),
            _ => 4,
        }
    }

    /// The ends of its pieces.
    pub(super) fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    /// Whether a piece ends there; zeros of both signs are one.
    pub(super) fn is_break(&self, t: f64) -> bool {
        let order = |b: &f64| b.partial_cmp(&t).unwrap_or(Ordering::Less);
        self.breaks.binary_search_by(order).is_ok()
    }

    /// A point of which it is known how far it is off.
    pub(super) fn proven(&self, t: f64) -> Point3<f64> {
        match &self.arc {
            Some(arc) => {
                let (sin, cos) = sincos(arc.angle_at(t));
                arc.center + (arc.x * cos + arc.y * sin)
            }
            None => self.curve.point(t),
        }
    }

    /// The same for searches, which carry no proof.
    pub(super) fn at(&self, t: f64) -> Point3<f64> {
        match self.curve {
            Curve::Nurbs(n) => Point3::from(net::on_curve(n, t)[0]),
            _ => self.proven(t),
        }
    }

    /// The derivative, on one side of a joint.
    pub(super) fn tangent(&self, t: f64, limit: Limit) -> Vector3<f64> {
        match &self.arc {
            Some(arc) => {
                let (sin, cos) = sincos(arc.angle_at(t));
                (arc.y * cos - arc.x * sin) * arc.rate
            }
            None if limit == Limit::FromBelow && self.is_break(t) => {
                let d = self.curve.derivatives_in::<f64>(t, 1, limit);
                d.get(1).map(|d| Vector3::from(*d)).unwrap_or_default()
            }
            None => match self.curve {
                Curve::Nurbs(n) => net::on_curve(n, t)[1],
                _ => {
                    let d = self.curve.derivatives(t, 1);
                    d.get(1).copied().unwrap_or_default()
                }
            },
        }
    }
}

impl Turning {
    fn angle_at(&self, t: f64) -> f64 {
        let t = t.clamp(self.domain.start, self.domain.end);
        if self.angle == self.domain {
            t
        } else {
            self.angle.start + (t - self.domain.start) * self.rate
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::nurbs::{Arc, NurbsCurve};
    use nalgebra::Vector4;

    /// Against the kernel's points, which are exact to the last digit.
    #[test]
    fn points_of_arcs_are_the_kernels_up_to_what_is_said() {
        for (angle, domain) in [
            ([-1.0, 5.0], [-1.0, 5.0]),
            ([6.0, 12.5], [0.0, 1.0]),
            ([-12.0, -7.0], [3.0, 4.0]),
            ([0.25, 0.5], [-1e3, 1e3]),
        ] {
            let interval = |[a, b]: [f64; 2]| Interval::new(a, b).unwrap();
            let arc = Arc {
                center: Point3::new(0.3, -7.0, 2.0),
                x: Vector3::new(0.36, 0.48, 0.8),
                y: Vector3::new(-0.8, 0.6, 0.0),
                z: Vector3::new(-0.48, -0.64, 0.6),
                radius: 5.0,
                angle: interval(angle),
                domain: interval(domain),
            };
            let curve: Curve3 = Curve::Arc(Arc::new(arc).unwrap());
            let points = Points::of(&curve);
            assert!(points.arc.is_some());
            let size = 12.0;
            // One unit beyond both ends, too: the last point goes on there.
            for k in -1..=65 {
                let t = interval(domain).lerp(f64::from(k) / 64.0);
                let off = (points.proven(t) - curve.point(t)).norm();
                assert!(off <= 32.0 * f64::EPSILON * size, "{angle:?} {t}: {off:e}");
                let own = curve.derivatives(t, 1)[1];
                let off = (points.tangent(t, Limit::FromAbove) - own).norm();
                assert!(off <= 32.0 * f64::EPSILON * own.norm(), "{angle:?} {t}");
            }
        }
    }

    /// A knot may be written as -0, and a sample there be 0: the slope from below is that of the piece before.
    #[test]
    fn zeros_of_both_signs_are_one_break() {
        let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        let points = points.map(|[x, y]| Vector4::new(x, y, 0.0, 1.0)).to_vec();
        for zero in [0.0, -0.0] {
            let knots = vec![-1.0, -1.0, zero, 1.0, 1.0];
            let spline = NurbsCurve::new(1, points.clone(), knots).unwrap();
            let curve: Curve3 = Curve::Nurbs(spline);
            let points = Points::of(&curve);
            for t in [0.0, -0.0] {
                assert!(points.is_break(t), "{t} at {zero}");
                assert_eq!(points.tangent(t, Limit::FromBelow), Vector3::x());
            }
            assert!(!points.is_break(0.5) && !points.is_break(f64::NAN));
        }
    }
}
