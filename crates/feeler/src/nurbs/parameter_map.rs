//! The parameters of native forms and of their NURBS forms.

use crate::numeric::{Ball, Interval, sin_cos};

/// How the parameter of a native form goes with that of its NURBS form.
///
/// They are the same, except within the pieces of an arc: there the native parameter moves with the
/// angle, but that of the rational quadratic does not. For a piece with half angle `h`, at fraction
/// `s` of its interval, the angle `phi` from its start is given by
/// `tan(phi / 2) = s sin h / (1 - s + s cos h)`, and back by
/// `s = sin(phi / 2) / (sin(phi / 2) + sin(h - phi / 2))`. The ends of pieces map to themselves
/// exactly; between, both maps are rounded (a few ulp of the interval), and monotone up to that.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterMap {
    /// Pieces of arcs in order, with half of the angle that each turns.
    arcs: Vec<(Interval, f64)>,
}

impl ParameterMap {
    pub(super) fn push_arc(&mut self, interval: Interval, half_angle: f64) {
        self.arcs.push((interval, half_angle));
    }

    pub(super) fn arcs(&self) -> &[(Interval, f64)] {
        &self.arcs
    }

    /// Whether the two parameters are the same everywhere.
    pub fn is_identity(&self) -> bool {
        self.arcs.is_empty()
    }

    fn piece(&self, t: f64) -> Option<(Interval, f64)> {
        let i = self.arcs.partition_point(|(on, _)| on.end < t);
        let found = self.arcs.get(i).filter(|(on, _)| on.contains(t));
        found.copied()
    }

    /// The NURBS parameter of native parameter `t`.
    pub fn to_nurbs(&self, t: f64) -> f64 {
        let Some((on, h)) = self.piece(t) else {
            return t;
        };
        if t == on.start || t == on.end {
            return t;
        }
        let half = h * ((t - on.start) / on.length());
        let (a, b) = (sine(half), sine(h - half));
        on.lerp(a / (a + b)).clamp(on.start, on.end)
    }

    /// The native parameter of NURBS parameter `t`.
    pub fn to_native(&self, t: f64) -> f64 {
        let Some((on, h)) = self.piece(t) else {
            return t;
        };
        if t == on.start || t == on.end {
            return t;
        }
        let s = (t - on.start) / on.length();
        let (sin, cos) = sin_cos(Ball::exact(h));
        let half = angle_of(s * sin.mid.hi, (1.0 - s) + s * cos.mid.hi);
        on.lerp(half / h).clamp(on.start, on.end)
    }
}

fn sine(x: f64) -> f64 {
    sin_cos(Ball::exact(x)).0.mid.hi
}

/// The angle of the direction `(x, y)` with `y` and `x` not negative and not both 0, within a few ulp;
/// the same bits on every platform.
fn angle_of(y: f64, x: f64) -> f64 {
    // Below 45 degrees: arctan r = r / (1 + 0.28 r^2) within 0.005, on either side of the diagonal.
    let (low, high) = (y.min(x), y.max(x));
    let r = low / high;
    let near = r / (1.0 + 0.28 * r * r);
    let mut a = if y <= x {
        near
    } else {
        std::f64::consts::FRAC_PI_2 - near
    };
    // Newton on sin(angle - a) = 0: an error e becomes e^3 / 3, so 5e-3, 4e-8, below 1e-22.
    for _ in 0..2 {
        let (sin, cos) = sin_cos(Ball::exact(a));
        let (sin, cos) = (sin.mid.hi, cos.mid.hi);
        a += (y * cos - x * sin) / (x * cos + y * sin);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles() {
        for i in 0..=90 {
            let a = f64::from(i).to_radians();
            let (sin, cos) = sin_cos(Ball::exact(a));
            let (sin, cos) = (sin.mid.hi, cos.mid.hi);
            let found = angle_of(7.0 * sin, 7.0 * cos.max(0.0));
            assert!((found - a).abs() <= 4.0 * f64::EPSILON, "{i}: {found} {a}");
        }
    }

    #[test]
    fn maps_are_inverse_and_keep_the_ends() {
        let mut map = ParameterMap::default();
        map.push_arc(
            Interval {
                start: 1.0,
                end: 3.0,
            },
            1.0,
        );
        for t in [0.0, 1.0, 3.0, 4.0] {
            assert_eq!((map.to_nurbs(t), map.to_native(t)), (t, t));
        }
        // Half the angle is half the parameter, by symmetry.
        assert!((map.to_nurbs(2.0) - 2.0).abs() <= 4.0 * f64::EPSILON);
        for i in 0..100 {
            let t = 1.0 + f64::from(i) * 0.02;
            let back = map.to_native(map.to_nurbs(t));
            assert!((back - t).abs() <= 16.0 * f64::EPSILON, "{t} {back}");
        }
    }

    /// Of half angles up to the largest there are, where the formula's own roundings miss the end.
    #[test]
    fn ends_are_kept_to_the_last_bit() {
        let on = Interval {
            start: 0.1,
            end: 0.7,
        };
        for i in 1..=104 {
            let mut map = ParameterMap::default();
            map.push_arc(on, f64::from(i) * 0.01);
            for t in [on.start, on.end] {
                assert_eq!((map.to_nurbs(t), map.to_native(t)), (t, t), "{i}");
            }
        }
    }
}
