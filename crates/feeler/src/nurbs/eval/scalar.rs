//! What evaluation needs of a number.

use crate::numeric::{Ball, Dd, Real};
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number type that curves and surfaces can be evaluated in: `f64` (fast, with the a-priori
/// error of the [module](super)), `Ball<f64>` or `Ball<Dd>` (with a proven bound).
pub trait Scalar:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// The exact number `x`.
    fn exact(x: f64) -> Self;
    /// `a - b`.
    fn difference(a: f64, b: f64) -> Self;
    /// A number known in double-double, with its bound if the type keeps one.
    fn from_ball(b: Ball<Dd>) -> Self;
    /// The nearest f64.
    fn value(self) -> f64;
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    #[inline]
    fn exact(x: f64) -> Self {
        x
    }
    #[inline]
    fn difference(a: f64, b: f64) -> Self {
        a - b
    }
    #[inline]
    fn from_ball(b: Ball<Dd>) -> Self {
        b.mid.hi
    }
    #[inline]
    fn value(self) -> f64 {
        self
    }
}

impl<T: Real> Scalar for Ball<T> {
    const ZERO: Self = Self::ZERO;
    const ONE: Self = Self::ONE;
    #[inline]
    fn exact(x: f64) -> Self {
        Self::exact(x)
    }
    #[inline]
    fn difference(a: f64, b: f64) -> Self {
        Self::difference(a, b)
    }
    #[inline]
    fn from_ball(b: Ball<Dd>) -> Self {
        Self::from_dd(b.mid, b.rad)
    }
    #[inline]
    fn value(self) -> f64 {
        self.mid.approximate()
    }
}
