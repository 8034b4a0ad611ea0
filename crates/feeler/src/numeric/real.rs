//! What the search needs of a number type: f64 first, double-double for the last
//! digits, triple-double where these are lost in rounding.

use super::Dd;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A floating-point type with a known unit of rounding.
///
/// Every operation `+ - *` returns a result whose error is at most [`UNIT`](Self::UNIT)
/// times the magnitude of the computed result, and `/` at most
/// [`DIV_UNIT`](Self::DIV_UNIT) times, unless something overflows, or underflows below
/// [`TINY`], which is then an absolute bound on the error.
pub trait Real:
    Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Relative error of a sum, difference or product.
    const UNIT: f64;
    /// Relative error of a quotient.
    const DIV_UNIT: f64;
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Exact.
    fn from_f64(x: f64) -> Self;
    /// Rounded, with a bound on the error.
    fn from_dd(x: Dd) -> (Self, f64);
    /// Rounded, with a bound on the error.
    fn to_dd(self) -> (Dd, f64);
    /// The nearest f64; exact for f64.
    fn approximate(self) -> f64;
    /// Half of it, exactly (unless it underflows).
    fn half(self) -> Self;
    /// The square root, off by at most [`UNIT`](Self::UNIT) of it where the number is above 1e-250; NaN for negative
    /// numbers.
    fn sqrt(self) -> Self;
    /// `|self|` as f64, rounded up.
    #[inline]
    fn magnitude(self) -> f64 {
        self.approximate().abs() * (1.0 + f64::EPSILON)
    }
}

/// An absolute bound on the error of one operation whose result underflows.
/// A product of f64 that underflows is off by at most 2^-1075; the error terms of double-double
/// products are exact down to results of 2^-960, below 1e-289; this covers both amply.
pub const TINY: f64 = 1e-280;

impl Real for f64 {
    const UNIT: f64 = f64::EPSILON / 2.0;
    const DIV_UNIT: f64 = f64::EPSILON / 2.0;
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline]
    fn from_dd(x: Dd) -> (Self, f64) {
        // `lo` is the exact error.
        (x.hi, x.lo.abs())
    }
    #[inline]
    fn to_dd(self) -> (Dd, f64) {
        (Dd::from(self), 0.0)
    }
    #[inline]
    fn approximate(self) -> f64 {
        self
    }
    #[inline]
    fn half(self) -> Self {
        0.5 * self
    }
    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
}
