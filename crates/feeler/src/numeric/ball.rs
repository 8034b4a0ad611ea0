//! A value with a running error bound.

use super::real::TINY;
use super::{Dd, Real};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A computed value and a bound on its distance from the true one:
/// `|true - mid| <= rad`. A radius of infinity or NaN means that nothing is known; callers compare
/// so that this never passes a test.
///
/// Each operation adds its own rounding (Higham, *Accuracy and Stability*, section 3.3,
/// running error analysis). Radii are f64, rounded up: every radius formula below has
/// at most 8 operations, each off by a factor of at most 1 + 2^-53, and is multiplied by
/// `ROUND_UP` >= (1 + 2^-53)^9.
#[derive(Clone, Copy, Debug)]
pub struct Ball<T> {
    /// The computed value.
    pub mid: T,
    /// The bound.
    pub rad: f64,
}

/// Makes up for the rounding of the radius itself.
pub(crate) const ROUND_UP: f64 = 1.0 + 8.0 * f64::EPSILON;

impl<T: Real> Ball<T> {
    /// Zero, exactly.
    pub const ZERO: Self = Self {
        mid: T::ZERO,
        rad: 0.0,
    };
    /// One, exactly.
    pub const ONE: Self = Self {
        mid: T::ONE,
        rad: 0.0,
    };

    /// An exact number.
    #[inline]
    pub fn exact(x: f64) -> Self {
        Self {
            mid: T::from_f64(x),
            rad: 0.0,
        }
    }

    /// A double-double known within `rad`.
    #[inline]
    pub fn from_dd(x: Dd, rad: f64) -> Self {
        let (mid, error) = T::from_dd(x);
        Self {
            mid,
            rad: if error == 0.0 {
                rad
            } else {
                (rad + error) * ROUND_UP
            },
        }
    }

    /// Whether it is 1, exactly.
    #[inline]
    pub fn is_one(&self) -> bool {
        self.rad == 0.0 && self.mid == T::ONE
    }

    /// `a - b` of two exact numbers; exact in double-double.
    #[inline]
    pub fn difference(a: f64, b: f64) -> Self {
        Self::from_dd(Dd::difference(a, b), 0.0)
    }

    /// `|true| <=` this.
    #[inline]
    pub fn magnitude(&self) -> f64 {
        (self.mid.magnitude() + self.rad) * ROUND_UP
    }

    /// The same in double-double; exact but for triple-doubles.
    #[inline]
    pub fn to_dd(self) -> Ball<Dd> {
        let (mid, error) = self.mid.to_dd();
        Ball {
            mid,
            rad: if error == 0.0 {
                self.rad
            } else {
                (self.rad + error) * ROUND_UP
            },
        }
    }

    /// A f64 not above the true value.
    #[inline]
    pub fn lower(&self) -> f64 {
        let d = self.to_dd();
        if d.rad == 0.0 {
            d.mid.floor_f64()
        } else {
            (d.mid - Dd::from(d.rad * ROUND_UP)).floor_f64().next_down()
        }
    }

    /// A f64 not below the true value.
    #[inline]
    pub fn upper(&self) -> f64 {
        let d = self.to_dd();
        if d.rad == 0.0 {
            d.mid.ceil_f64()
        } else {
            (d.mid + Dd::from(d.rad * ROUND_UP)).ceil_f64().next_up()
        }
    }

    /// Half of it.
    #[inline]
    #[must_use]
    pub fn half(self) -> Self {
        Self {
            mid: self.mid.half(),
            rad: 0.5 * self.rad + TINY,
        }
    }

    /// The square.
    #[inline]
    #[must_use]
    pub fn square(self) -> Self {
        self * self
    }

    /// Whether the true value is proven to be above `x`.
    #[inline]
    pub fn is_above(&self, x: f64) -> bool {
        self.lower() > x
    }

    /// The square root of a number that is not negative; where the ball reaches below zero,
    /// the part below is cut off.
    ///
    /// Far from zero: `|sqrt x - sqrt m| = |x - m| / (sqrt x + sqrt m)`, and for `x >= m (1 - 2^-10)` that is at most `0.50013 |x - m| /
    /// sqrt m`; the rest of the factor makes up for the root's own rounding.
    #[must_use]
    pub fn sqrt(self) -> Self {
        let lead = self.mid.approximate();
        if lead > LEAST_ROOTED && self.rad <= lead * FAR_FROM_ZERO {
            let mid = self.mid.sqrt();
            let root = mid.approximate();
            let rad = (0.5003 * (self.rad / root) + T::UNIT * mid.magnitude()) * ROUND_UP;
            return Self { mid, rad };
        }
        self.sqrt_near_zero()
    }

    fn sqrt_near_zero(self) -> Self {
        let Ball { mid: x, rad } = self.to_dd();
        let top = x + Dd::from(rad * ROUND_UP);
        if x.hi.is_nan() || rad.is_nan() || top.hi < 0.0 {
            return Self {
                mid: T::ZERO,
                rad: f64::INFINITY,
            };
        }
        let bottom = x - Dd::from(rad * ROUND_UP);
        let (a, b) = (
            if bottom.hi > 0.0 {
                bottom.sqrt()
            } else {
                Dd::ZERO
            },
            top.sqrt(),
        );
        let mid = (a + b).half();
        // Half the width, the roots' own errors (25/8 u² each), the sums' and bounds'.
        let rad = ((b - a).half().magnitude() + 8.0 * Dd::UNIT * b.magnitude()) * ROUND_UP + TINY;
        Self::from_dd(mid, rad)
    }
}

/// A ball's radius is below this part of its value: it is far from zero.
const FAR_FROM_ZERO: f64 = 1.0 / (1u64 << 10) as f64;
/// Roots of smaller numbers may lose digits: the last part of a root's square is 2^-106 of the number, 1e-282 here, and products are exact
/// down to 2^-960, about 1e-289.
const LEAST_ROOTED: f64 = 1e-250;

impl<T: Real> Add for Ball<T> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        let mid = self.mid + o.mid;
        Self {
            mid,
            rad: (self.rad + o.rad + T::UNIT * mid.magnitude()) * ROUND_UP,
        }
    }
}

impl<T: Real> Neg for Ball<T> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            mid: -self.mid,
            rad: self.rad,
        }
    }
}

impl<T: Real> Sub for Ball<T> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl<T: Real> Mul for Ball<T> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        let mid = self.mid * o.mid;
        let inherited = self.mid.magnitude() * o.rad + (o.mid.magnitude() + o.rad) * self.rad;
        Self {
            mid,
            rad: (inherited + T::UNIT * mid.magnitude()) * ROUND_UP + TINY,
        }
    }
}

impl<T: Real> Div for Ball<T> {
    type Output = Self;
    /// With `|A - a| <= r`, `|B - b| <= s < |b|`:
    /// `|A/B - a/b| <= (r + |a/b| s) / (|b| - s)`.
    #[inline]
    fn div(self, o: Self) -> Self {
        let mid = self.mid / o.mid;
        let room = (o.mid.magnitude() * (1.0 - 4.0 * f64::EPSILON) - o.rad) * (1.0 - f64::EPSILON);
        let rad = if room > 0.0 {
            let q = mid.magnitude() * ROUND_UP;
            ((self.rad + q * o.rad) / room + T::DIV_UNIT * q) * ROUND_UP + TINY
        } else {
            f64::INFINITY
        };
        Self { mid, rad }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::{Dyadic, Td};

    fn exact(x: Dd) -> Dyadic {
        &Dyadic::from_f64(x.hi).unwrap() + &Dyadic::from_f64(x.lo).unwrap()
    }

    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        let m = (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        m * 2f64.powi((*seed % 41) as i32 - 20)
    }

    /// A ball of a random double-double, not exact: the truth is elsewhere within it.
    fn sample<T: Real>(seed: &mut u64) -> (Ball<T>, Dyadic) {
        let truth = Dd::new(random(seed), random(seed) * 1e-17);
        (Ball::from_dd(truth, 0.0), exact(truth))
    }

    fn holds<T: Real>(b: &Ball<T>, truth: &Dyadic) -> bool {
        let error = &exact(b.mid.to_dd().0) - truth;
        let error = if error.signum() < 0 { -&error } else { error };
        error <= Dyadic::from_f64(b.rad).unwrap()
            && Dyadic::from_f64(b.lower()).unwrap() <= *truth
            && Dyadic::from_f64(b.upper()).unwrap() >= *truth
    }

    fn check<T: Real>() {
        let mut seed = 0x1234_5678_9abc_def1;
        for _ in 0..20_000 {
            let (a, x) = sample::<T>(&mut seed);
            let (b, y) = sample::<T>(&mut seed);
            assert!(holds(&(a + b), &(&x + &y)), "{a:?} + {b:?}");
            assert!(holds(&(a - b), &(&x - &y)), "{a:?} - {b:?}");
            assert!(holds(&(a * b), &(&x * &y)), "{a:?} * {b:?}");
            // q = a / b: |q b - a| <= rad |b| is the same claim without a division.
            let q = a / b;
            let residue = &(&exact(q.mid.to_dd().0) * &y) - &x;
            let limit = &Dyadic::from_f64(q.rad).unwrap() * &y;
            assert!(&residue * &residue <= &limit * &limit, "{a:?} / {b:?}");
            // s = sqrt(a²): the root of the exact square is |a|.
            let s = (a * a).sqrt();
            let root = if x.signum() < 0 { -&x } else { x.clone() };
            assert!(holds(&s, &root), "sqrt {a:?}");
        }
    }

    #[test]
    fn double_balls_hold_the_truth() {
        check::<f64>();
    }

    #[test]
    fn double_double_balls_hold_the_truth() {
        check::<Dd>();
    }

    /// Small whole numbers, so that every end of every ball is exact: the result of the ends is in the ball of the result, which
    /// is no wider than the formula in exact numbers, but for rounding.
    fn check_ends<T: Real>() {
        const ROUNDING: f64 = 1.0 + 1.0 / (1u64 << 40) as f64;
        let is_within = |value: &Dyadic, b: &Ball<T>| {
            let b = b.to_dd();
            let off = &exact(b.mid) - value;
            let limit = Dyadic::from_f64(b.rad).unwrap();
            &off * &off <= &limit * &limit
        };
        for k in 0..625 {
            let digit = |i: u32| f64::from(k / 5u32.pow(i) % 5);
            let (am, ar, bm, br) = (digit(0) - 2.0, digit(1), 3.0 * digit(2) - 7.0, digit(3));
            let ball = |mid, rad| Ball::<T> {
                mid: T::from_f64(mid),
                rad,
            };
            let (a, b) = (ball(am, ar), ball(bm, br));
            let (sum, product, quotient, half) = (a + b, a * b, a / b, a.half());
            for x in [am - ar, am + ar] {
                for y in [bm - br, bm + br] {
                    let (x, y) = (Dyadic::from_f64(x).unwrap(), Dyadic::from_f64(y).unwrap());
                    assert!(is_within(&(&x + &y), &sum), "{a:?} + {b:?}");
                    assert!(is_within(&(&x * &y), &product), "{a:?} * {b:?}");
                    // q y = x, times the divisor.
                    let q = quotient.to_dd();
                    let off = &(&exact(q.mid) * &y) - &x;
                    if q.rad < f64::INFINITY {
                        let limit = &Dyadic::from_f64(q.rad).unwrap() * &y;
                        assert!(&off * &off <= &limit * &limit, "{a:?} / {b:?}");
                    }
                }
            }
            let unit = 4.0 * T::DIV_UNIT * (am.abs() + 1.0) * (bm.abs() + 1.0);
            let is_tight = |b: &Ball<T>, ideal: f64| b.rad <= ideal * ROUNDING + unit;
            assert!(is_tight(&sum, ar + br), "{a:?} + {b:?}");
            assert!(is_tight(&product, am.abs() * br + (bm.abs() + br) * ar));
            assert!(half.mid.approximate() == 0.5 * am && is_tight(&half, 0.5 * ar));
            if br < bm.abs() {
                let ideal = (ar + (am / bm).abs() * br) / (bm.abs() - br);
                assert!(is_tight(&quotient, ideal), "{a:?} / {b:?}");
            } else {
                assert_eq!(quotient.rad, f64::INFINITY);
            }
            assert!(a.lower() <= am - ar && a.upper() >= am + ar);
            assert!(a.lower() >= am - ar - 1e-14 && a.upper() <= am + ar + 1e-14);
            assert!(!a.is_above(am - ar) && a.is_above(am - ar - 1e-13));
        }
        // A divisor that reaches next to zero: 2^-50 at its least, and the quotient 2^50.
        let near = 1.0 / (1u64 << 50) as f64;
        let divisor = Ball {
            mid: T::ONE,
            rad: 1.0 - near,
        };
        assert!((Ball::<T>::ONE / divisor).upper() >= 1.0 / near);
    }

    #[test]
    fn ends_of_balls_are_held_and_little_else() {
        check_ends::<f64>();
        check_ends::<Dd>();
        check_ends::<Td>();
    }

    /// The root of `[lo, hi]` is `[sqrt lo, sqrt hi]`, as ends that are squares show.
    fn check_roots<T: Real>() {
        for scale in [-40, -6, 0, 20].map(|k| 2f64.powi(k)) {
            for (lo, hi) in [
                (0.0, 4.0),
                (1.0, 9.0),
                (4.0, 4.0),
                (1.0, (1.0 + 2f64.powi(-12)).powi(2)),
            ] {
                let squares = [lo, hi].map(|x: f64| x * scale * scale);
                let ball = Ball {
                    mid: T::from_f64(0.5 * (squares[0] + squares[1])),
                    rad: 0.5 * (squares[1] - squares[0]),
                };
                let root = ball.sqrt();
                let (lo, hi) = (scale * lo.sqrt(), scale * hi.sqrt());
                assert!(root.lower() <= lo && root.upper() >= hi, "{ball:?}");
                // What the quick way gives away: 0.5003 for a half, and the slope at the middle for that of the chord.
                let most = 0.5 * (hi - lo) * 1.002 + 8.0 * T::DIV_UNIT * hi;
                assert!(root.rad <= most, "{ball:?}: {root:?}");
            }
        }
        // What is below zero is cut off; nothing is known of what is all below.
        let ball = |mid, rad| Ball {
            mid: T::from_f64(mid),
            rad,
        };
        let root = ball(-1.0, 5.0).sqrt();
        assert!(root.lower() <= 0.0 && root.upper() >= 2.0 && root.rad <= 1.0 + 1e-14);
        assert_eq!(ball(-2.0, 1.0).sqrt().rad, f64::INFINITY);
        assert_eq!(ball(f64::NAN, 1.0).sqrt().rad, f64::INFINITY);
        assert_eq!(ball(1.0, f64::NAN).sqrt().rad, f64::INFINITY);
    }

    #[test]
    fn roots_of_wide_balls() {
        check_roots::<f64>();
        check_roots::<Dd>();
        check_roots::<Td>();
    }

    /// 1/3 of triple-double is no double-double: what that loses is in the radius, and little more.
    #[test]
    fn what_conversion_loses_is_told() {
        let third = Ball::<Td>::ONE / Ball::exact(3.0);
        let short = third.to_dd();
        let three = Dyadic::from_f64(3.0).unwrap();
        let off = &(&exact(short.mid) * &three) - &Dyadic::from_f64(1.0).unwrap();
        let limit = &Dyadic::from_f64(short.rad).unwrap() * &three;
        assert!(&off * &off <= &limit * &limit, "{short:?}");
        assert!(third.rad < short.rad && short.rad < Dd::UNIT, "{short:?}");
        let double = Ball::<f64>::from_dd(Dd::ONE / Dd::from(3.0), 0.0);
        assert!(double.rad > 0.0 && double.rad < f64::EPSILON, "{double:?}");
    }

    #[test]
    fn double_double_is_that_accurate() {
        // Not only sound: 1/3 is known to 2^-100.
        let third = Ball::<Dd>::ONE / Ball::exact(3.0);
        assert!(third.rad < 1e-31, "{third:?}");
        let two = Ball::<Dd>::exact(2.0).sqrt();
        assert!(
            (two * two - Ball::exact(2.0)).magnitude() < 1e-29,
            "{two:?}"
        );
    }

    /// Half of a ball holds half of all that it holds, and hardly more.
    #[test]
    fn halves_keep_half_the_radius() {
        for rad in [0.0, 1e-3, 4.0, 1e300, 4e-323] {
            let half = Ball { mid: 3.0, rad }.half();
            assert_eq!(half.mid, 1.5);
            assert!(
                0.5 * rad <= half.rad && half.rad <= 0.5 * rad + 2.0 * TINY,
                "{rad:e}"
            );
        }
    }
}
