//! Exact rationals.
//!
//! Not those of dashu-ratio (0.4.4): they are reduced by the greatest common divisor of dashu-int (0.4.3), which panics on some numbers (see
//! [`gcd`]), and sums of powers of two far apart, which knots make, are of that kind.

use super::rational::sign;
use dashu_int::ops::{BitTest, Gcd, PowerOfTwo, UnsignedAbs};
use dashu_int::{IBig, UBig};
use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A rational number in lowest terms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Fraction {
    n: IBig,
    d: UBig,
}

/// Up to so many bits dashu-int divides without memory of its own.
const WITHOUT_SCRATCH: usize = 32 * 64;
/// Up to so many it multiplies in ways that take the more of it the longer the factors are.
const MONOTONE: usize = 1024 * 64;

/// The greatest common divisor; of zero and a number that number.
///
/// dashu-int (0.4.3) reserves memory for the first division of Euclid's algorithm, and uses it for all that follow: where a
/// later one, of numbers less alike in length, needs more, it panics ("not enough memory allocated"). Here the longer number is first made longer
/// by a multiple of the shorter, so that no later division needs as much as the first; numbers beyond all
/// that come here go by plain steps until they are shorter.
pub(crate) fn gcd(a: &UBig, b: &UBig) -> UBig {
    let (a, b) = if a < b { (b, a) } else { (a, b) };
    if *b == UBig::ZERO {
        return a.clone();
    }
    if b.bit_len() <= WITHOUT_SCRATCH {
        return a.gcd(b);
    }
    let (mut a, mut b) = (a.clone(), b.clone());
    while b.bit_len() > MONOTONE {
        let rest = a % &b;
        (a, b) = (b, rest);
    }
    if b == UBig::ZERO {
        return a;
    }
    let longer = a.bit_len().max(2 * b.bit_len());
    (a + (&b << longer)).gcd(b)
}

/// Both divided by what they have in common; `d` is not 0.
fn reduced(n: IBig, d: UBig) -> (IBig, UBig) {
    if d == UBig::ONE {
        return (n, d);
    }
    if n == IBig::ZERO {
        return (n, UBig::ONE);
    }
    if d.is_power_of_two() {
        let common = d.trailing_zeros().min(n.trailing_zeros()).unwrap_or(0);
        return (n >> common, d >> common);
    }
    let g = gcd(&(&n).unsigned_abs(), &d);
    if g == UBig::ONE {
        return (n, d);
    }
    (n / IBig::from(g.clone()), d / g)
}

impl Fraction {
    pub(crate) const ZERO: Self = Self {
        n: IBig::ZERO,
        d: UBig::ONE,
    };
    pub(crate) const ONE: Self = Self {
        n: IBig::ONE,
        d: UBig::ONE,
    };

    /// `n / d`, d not 0.
    pub(crate) fn from_parts(n: IBig, d: UBig) -> Self {
        let (n, d) = reduced(n, d);
        Self { n, d }
    }

    pub(crate) fn numerator(&self) -> &IBig {
        &self.n
    }

    pub(crate) fn denominator(&self) -> &UBig {
        &self.d
    }

    pub(crate) fn pow(&self, k: usize) -> Self {
        Self {
            n: self.n.pow(k),
            d: self.d.pow(k),
        }
    }

    /// The largest integer not above it.
    pub(crate) fn floor(&self) -> IBig {
        let d = IBig::from(self.d.clone());
        // Division of integers here is toward zero.
        let q = &self.n / &d;
        if sign(&self.n) < 0 && &q * &d != self.n {
            q - IBig::ONE
        } else {
            q
        }
    }

    fn sum(&self, other: &Self, less: bool) -> Self {
        let join = |a: IBig, b: IBig| if less { a - b } else { a + b };
        if self.d == other.d {
            return Self::from_parts(join(self.n.clone(), other.n.clone()), self.d.clone());
        }
        let (a, b) = (
            &self.n * IBig::from(other.d.clone()),
            &other.n * IBig::from(self.d.clone()),
        );
        Self::from_parts(join(a, b), &self.d * &other.d)
    }

    fn product(&self, n: &IBig, d: &UBig) -> Self {
        // What the two have in common across, which is all: shorter than their products.
        let (a, d) = reduced(self.n.clone(), d.clone());
        let (b, c) = reduced(n.clone(), self.d.clone());
        Self { n: a * b, d: c * d }
    }

    /// `other` is not 0.
    fn quotient(&self, other: &Self) -> Self {
        let d = (&other.n).unsigned_abs();
        let n = IBig::from(other.d.clone());
        self.product(&if sign(&other.n) < 0 { -n } else { n }, &d)
    }
}

impl<T: Into<IBig>> From<T> for Fraction {
    fn from(n: T) -> Self {
        Self {
            n: n.into(),
            d: UBig::ONE,
        }
    }
}

impl Ord for Fraction {
    fn cmp(&self, other: &Self) -> Ordering {
        if self.d == other.d {
            return self.n.cmp(&other.n);
        }
        let (a, b) = (
            &self.n * IBig::from(other.d.clone()),
            &other.n * IBig::from(self.d.clone()),
        );
        a.cmp(&b)
    }
}

impl PartialOrd for Fraction {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Neg for Fraction {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            n: -self.n,
            d: self.d,
        }
    }
}

/// An operator on values and references alike.
macro_rules! operator {
    ($name:ident $method:ident, $by:expr) => {
        impl $name<&Fraction> for &Fraction {
            type Output = Fraction;
            fn $method(self, other: &Fraction) -> Fraction {
                let by: fn(&Fraction, &Fraction) -> Fraction = $by;
                by(self, other)
            }
        }
        impl $name<Fraction> for &Fraction {
            type Output = Fraction;
            fn $method(self, other: Fraction) -> Fraction {
                $name::$method(self, &other)
            }
        }
        impl $name<&Fraction> for Fraction {
            type Output = Fraction;
            fn $method(self, other: &Fraction) -> Fraction {
                $name::$method(&self, other)
            }
        }
        impl $name<Fraction> for Fraction {
            type Output = Fraction;
            fn $method(self, other: Fraction) -> Fraction {
                $name::$method(&self, &other)
            }
        }
    };
}

operator!(Add add, |a, b| a.sum(b, false));
operator!(Sub sub, |a, b| a.sum(b, true));
operator!(Mul mul, |a, b| a.product(&b.n, &b.d));
operator!(Div div, Fraction::quotient);

impl AddAssign<Fraction> for Fraction {
    fn add_assign(&mut self, other: Fraction) {
        *self = self.sum(&other, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dashu_ratio::RBig;

    /// Bits without pattern.
    fn number(bits: usize, seed: u64) -> UBig {
        let mut s = seed;
        let mut n = UBig::ONE;
        while n.bit_len() < bits {
            s = s.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            n = (n << 32) + UBig::from(s >> 32);
        }
        n
    }

    /// By Euclid alone.
    fn plain(mut a: UBig, mut b: UBig) -> UBig {
        while b != UBig::ZERO {
            let rest = a % &b;
            (a, b) = (b, rest);
        }
        a
    }

    #[test]
    fn divisors_whose_remainders_are_much_shorter() {
        let g = number(60, 5);
        for (m, r) in [
            (3000, 1000),
            (6400, 3200),
            (9000, 2100),
            (20_000, 6500),
            (70_000, 30_000),
        ] {
            let (b, rest) = (number(m, 1) * &g, number(r, 2) * &g);
            let a = &b * UBig::from(3u8) + &rest;
            let expected = plain(a.clone(), b.clone());
            assert_eq!(gcd(&a, &b), expected, "{m} {r}");
            assert_eq!(gcd(&b, &a), expected, "{m} {r}");
            assert_eq!(gcd(&(&b * &a), &b), b);
        }
        let n = |x: u64| UBig::from(x);
        assert_eq!(gcd(&n(12), &n(18)), n(6));
        assert_eq!((gcd(&n(0), &n(7)), gcd(&n(7), &n(0))), (n(7), n(7)));
    }

    /// The same numbers as dashu-ratio's, where that does not panic.
    #[test]
    fn arithmetic_is_that_of_another_library() {
        let same = |x: &Fraction, y: &RBig| x.n == *y.numerator() && x.d == *y.denominator();
        let mut all = Vec::new();
        for n in [-12i64, -7, -1, 0, 1, 3, 8, 1 << 40, 3_i64.pow(30)] {
            for d in [1u64, 2, 3, 8, 12, 5_u64.pow(20)] {
                let (n, d) = (IBig::from(n), UBig::from(d));
                all.push((
                    Fraction::from_parts(n.clone(), d.clone()),
                    RBig::from_parts(n, d),
                ));
            }
        }
        for (a, x) in &all {
            assert!(same(a, x) && same(&-a.clone(), &-x.clone()) && same(&a.pow(3), &x.pow(3)));
            assert_eq!(a.floor(), x.floor(), "{x}");
            for (b, y) in &all {
                assert!(same(&(a + b), &(x + y)), "{x} + {y}");
                assert!(same(&(a - b), &(x - y)), "{x} - {y}");
                assert!(same(&(a * b), &(x * y)), "{x} * {y}");
                if b.n != IBig::ZERO {
                    assert!(same(&(a / b), &(x / y)), "{x} / {y}");
                }
                assert_eq!(a.cmp(b), x.cmp(y), "{x} {y}");
                assert_eq!(a == b, x == y, "{x} {y}");
            }
        }
    }
}
