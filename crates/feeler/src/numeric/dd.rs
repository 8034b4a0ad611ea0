//! Double-double numbers.

use super::Real;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// An unevaluated sum `hi + lo` of two f64 with `|lo| <= ulp(hi) / 2`: about 106
/// bits.
///
/// Error bounds (u = 2^-53), in the absence of overflow and of products below 2^-960:
/// sum and difference 3u² + 13u³ (AccurateDWPlusDW), product 5u² (DWTimesDW1),
/// quotient 15u² + 56u³ (DWDivDW2), square root 25/8 u² (SQRTDWtoDW), all relative.
/// Source: Joldes, Muller, Popescu, *Tight and rigorous error bounds for basic building blocks
/// of double-word arithmetic*, ACM TOMS 44 (2017), algorithms 6, 10, 17; Lefèvre, Louvet, Muller,
/// Picot, Rideau, *Accurate calculation of Euclidean norms*, ACM TOMS 49 (2023).
/// Fused multiply-add is not used: the bits are the same on every platform.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Dd {
    /// The f64 nearest to the value.
    pub hi: f64,
    /// The rest.
    pub lo: f64,
}

/// `(s, e)` with `s = fl(a + b)` and `s + e = a + b` exactly (Knuth).
#[inline]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let bb = s - a;
    (s, (a - (s - bb)) + (b - bb))
}

/// The same for `|a| >= |b|` or `a = 0` (Dekker).
#[inline]
pub(super) fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    (s, b - (s - a))
}

/// `(p, e)` with `p = fl(a b)` and `p + e = a b` exactly, unless something overflows
/// or underflows (Dekker, Veltkamp).
#[inline]
pub(crate) fn two_prod(a: f64, b: f64) -> (f64, f64) {
    // 2^27 + 1 splits 53 bits in 26 and 26.
    const SPLITTER: f64 = 134_217_729.0;
    let p = a * b;
    let (ta, tb) = (SPLITTER * a, SPLITTER * b);
    let ah = ta - (ta - a);
    let al = a - ah;
    let bh = tb - (tb - b);
    let bl = b - bh;
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

impl Dd {
    /// Zero.
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };
    /// One.
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// The number `hi + lo`, normalised exactly.
    pub fn new(hi: f64, lo: f64) -> Self {
        let (hi, lo) = two_sum(hi, lo);
        Self { hi, lo }
    }

    /// `a + b` exactly.
    pub fn sum(a: f64, b: f64) -> Self {
        let (hi, lo) = two_sum(a, b);
        Self { hi, lo }
    }

    /// `a - b` exactly.
    pub fn difference(a: f64, b: f64) -> Self {
        Self::sum(a, -b)
    }

    /// `a b` exactly unless something overflows or underflows.
    pub fn product(a: f64, b: f64) -> Self {
        let (hi, lo) = two_prod(a, b);
        Self { hi, lo }
    }

    /// `|self|`.
    #[must_use]
    pub fn abs(self) -> Self {
        if self.hi < 0.0 || (self.hi == 0.0 && self.lo < 0.0) {
            -self
        } else {
            self
        }
    }

    /// The square root; NaN for negative numbers.
    #[must_use]
    pub fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return Self::ZERO;
        }
        let s = self.hi.sqrt();
        let (p, e) = two_prod(s, s);
        let rest = ((self.hi - p) - e) + self.lo;
        let (hi, lo) = fast_two_sum(s, rest / (2.0 * s));
        Self { hi, lo }
    }

    /// A f64 not above the value.
    pub fn floor_f64(self) -> f64 {
        if self.lo < 0.0 {
            self.hi.next_down()
        } else {
            self.hi
        }
    }

    /// A f64 not below the value.
    pub fn ceil_f64(self) -> f64 {
        if self.lo > 0.0 {
            self.hi.next_up()
        } else {
            self.hi
        }
    }
}

impl From<f64> for Dd {
    fn from(x: f64) -> Self {
        Self { hi: x, lo: 0.0 }
    }
}

impl Add for Dd {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        let (sh, sl) = two_sum(self.hi, o.hi);
        let (th, tl) = two_sum(self.lo, o.lo);
        let (vh, vl) = fast_two_sum(sh, sl + th);
        let (hi, lo) = fast_two_sum(vh, tl + vl);
        Self { hi, lo }
    }
}

impl Sub for Dd {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Neg for Dd {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            hi: -self.hi,
            lo: -self.lo,
        }
    }
}

impl Mul for Dd {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        let (ch, cl) = two_prod(self.hi, o.hi);
        let cross = self.hi * o.lo + self.lo * o.hi;
        let (hi, lo) = fast_two_sum(ch, cl + cross);
        Self { hi, lo }
    }
}

impl Div for Dd {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        let th = self.hi / o.hi;
        let r = o * Self::from(th);
        let rest = (self.hi - r.hi) + (self.lo - r.lo);
        let (hi, lo) = fast_two_sum(th, rest / o.hi);
        Self { hi, lo }
    }
}

impl PartialOrd for Dd {
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        match self.hi.partial_cmp(&o.hi) {
            Some(Ordering::Equal) => self.lo.partial_cmp(&o.lo),
            other => other,
        }
    }
}

impl Real for Dd {
    // 8u² covers the 3u² of sums and the 5u² of products, and that they hold relative to
    // the exact result while the unit is applied to the computed one.
    const UNIT: f64 = 8.0 / (1u128 << 106) as f64;
    // 16u² covers 15u² + 56u³.
    const DIV_UNIT: f64 = 16.0 / (1u128 << 106) as f64;
    const ZERO: Self = Self::ZERO;
    const ONE: Self = Self::ONE;

    #[inline]
    fn from_f64(x: f64) -> Self {
        Self::from(x)
    }
    #[inline]
    fn from_dd(x: Dd) -> (Self, f64) {
        (x, 0.0)
    }
    #[inline]
    fn to_dd(self) -> (Dd, f64) {
        (self, 0.0)
    }
    #[inline]
    fn approximate(self) -> f64 {
        self.hi
    }
    #[inline]
    fn half(self) -> Self {
        Self {
            hi: 0.5 * self.hi,
            lo: 0.5 * self.lo,
        }
    }
    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
}
