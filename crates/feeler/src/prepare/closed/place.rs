//! Native parameters of points of a surface in closed form, to double-double: where f64 does not tell on which side of the border of a
//! face a point is.

use super::ClosedSurface;
use super::form::{Linear, V3, dot, exact, sub};
use super::revolution::{Profile, RevolutionForm};
use crate::numeric::{Ball, Dd, Interval, full_turn, vector_angle};
use arrayvec::ArrayVec;

/// Copies of one parameter at whole turns: no more meet a range of one turn, with roundings.
type Copies = ArrayVec<Ball<Dd>, 3>;
/// Copies of a point's native parameters.
pub(crate) type Places = ArrayVec<[Ball<Dd>; 2], 9>;

impl ClosedSurface {
    /// The native parameters of a point of the surface: of all copies at whole turns one at least for each that is in the domain, and perhaps
    /// others. Next to the axis an angle may be anything. `None` where even the other parameter is not known.
    pub(crate) fn places(&self, point: &V3) -> Option<Places> {
        match self {
            Self::Plane(p) => {
                let w = sub(point, &exact(&p.origin));
                Some(Places::from_iter([p.parameters(&w)]))
            }
            Self::Revolution(r) => r.places(point),
        }
    }

    /// The same of a point that is exactly on the surface beyond its borders, a quadric; `None` where it is not.
    pub(crate) fn exact_places(&self, point: &[f64; 3]) -> Option<Places> {
        let Self::Revolution(r) = self else {
            return None;
        };
        let on = r.quadric.as_ref().is_some_and(|q| q.holds_point(point));
        on.then(|| r.places(&exact(point))).flatten()
    }
}

impl RevolutionForm {
    fn places(&self, point: &V3) -> Option<Places> {
        let w = sub(point, &self.fine.origin);
        let [x, y, h] = [&self.fine.e, &self.fine.b, &self.fine.axis].map(|axis| dot(&w, axis));
        let rho = (x.square() + y.square()).sqrt();
        let map = self.profile_map();
        let profile = match &self.fine.profile {
            Profile::Line { ends: [p, q], .. } => {
                Copies::from_iter([map.at((h - p[2]) / (q[2] - p[2]))])
            }
            Profile::Arc {
                center,
                x: along,
                y: across,
                angle,
                ..
            } => {
                let (a, h) = (rho - center[0], h - center[2]);
                // As where boxes of f64 are made: the model is off by no more than that.
                let skewed = |b: Ball<Dd>| widened(b, self.beside());
                let at = vector_angle(
                    skewed(a * across[0] + h * across[2]),
                    skewed(a * along[0] + h * along[2]),
                )?;
                copies(at, *angle, &map)
            }
        };
        let twist = self.twist_at(rho.lower());
        let angular = match vector_angle(y, x).filter(|_| twist.is_finite()) {
            Some(azimuth) => copies(widened(azimuth, twist), self.angle(), &self.angular()),
            None => {
                let d = self.angle_domain();
                let anywhere = Ball::exact(d.start) + Ball::difference(d.end, d.start).half();
                Copies::from_iter([widened(anywhere, d.end - d.start)])
            }
        };
        let pairs = profile
            .iter()
            .flat_map(|v| angular.iter().map(|u| self.join(*u, *v)));
        Some(pairs.collect())
    }
}

/// What an angle and those whole turns from it that may be in a range are mapped to.
fn copies(at: Ball<Dd>, range: Interval, map: &Linear) -> Copies {
    // What is about at the ends is kept: it is told where the parameter is compared with those of the domain.
    const ROUND: f64 = 1.0 / (1u64 << 20) as f64;
    let turns = |x: f64| x / full_turn().mid.hi;
    let least = (turns(range.start - at.upper()) - ROUND).ceil();
    let most = (turns(range.end - at.lower()) + ROUND).floor();
    let counts = (0..3).map(|k| least + f64::from(k));
    counts
        .take_while(|k| *k <= most)
        .map(|k| map.at(at + full_turn() * Ball::exact(k)))
        .collect()
}

fn widened(x: Ball<Dd>, by: f64) -> Ball<Dd> {
    Ball {
        mid: x.mid,
        rad: (x.rad + by) * (1.0 + 4.0 * f64::EPSILON),
    }
}
