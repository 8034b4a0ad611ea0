//! Exact vectors and quotients: for what double-double does not tell.

use crate::numeric::{Ball, Dd, Dyadic, Real};
use std::cmp::Ordering;

/// A vector of exact numbers.
pub(super) type D3 = [Dyadic; 3];

pub(super) fn dyadic(x: f64) -> Option<Dyadic> {
    Dyadic::from_f64(x)
}

pub(super) fn vector(v: &[f64]) -> Option<D3> {
    Some([dyadic(v[0])?, dyadic(v[1])?, dyadic(v[2])?])
}

pub(super) fn dot(a: &D3, b: &D3) -> Dyadic {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}

pub(super) fn cross(a: &D3, b: &D3) -> D3 {
    std::array::from_fn(|c| {
        let (i, j) = ((c + 1) % 3, (c + 2) % 3);
        &(&a[i] * &b[j]) - &(&a[j] * &b[i])
    })
}

pub(super) fn sub(a: &D3, b: &D3) -> D3 {
    std::array::from_fn(|c| &a[c] - &b[c])
}

pub(super) fn scale(a: &D3, s: &Dyadic) -> D3 {
    std::array::from_fn(|c| &a[c] * s)
}

/// A number in double-double.
pub(super) fn enclosed(x: &Dyadic) -> Ball<Dd> {
    // Each rounding leaves less than 2^-50 of what was left before it.
    let (mut rest, mut sum) = (x.clone(), Dd::ZERO);
    for _ in 0..3 {
        let part = rest.approximate();
        sum = sum + Dd::from(part);
        match dyadic(part) {
            Some(part) => rest = &rest - &part,
            None => {
                return Ball {
                    mid: sum,
                    rad: f64::INFINITY,
                };
            }
        }
    }
    const REST: f64 = 1.0 / (1u128 << 100) as f64;
    Ball {
        mid: sum,
        rad: if rest.signum() == 0 && sum.lo == 0.0 {
            0.0
        } else {
            REST * sum.magnitude() + f64::MIN_POSITIVE
        },
    }
}

/// A rational number.
#[derive(Clone, Debug)]
pub(crate) struct Ratio {
    pub(super) top: Dyadic,
    /// Above zero.
    pub(super) bottom: Dyadic,
}

impl Ratio {
    pub(super) fn new(top: Dyadic, bottom: Dyadic) -> Self {
        if bottom.signum() < 0 {
            Self {
                top: -&top,
                bottom: -&bottom,
            }
        } else {
            Self { top, bottom }
        }
    }

    pub(super) fn from_f64(x: f64) -> Option<Self> {
        Some(Self {
            top: dyadic(x)?,
            bottom: dyadic(1.0)?,
        })
    }

    pub(crate) fn cmp(&self, other: &Self) -> Ordering {
        (&self.top * &other.bottom).cmp(&(&other.top * &self.bottom))
    }

    /// In double-double.
    pub(crate) fn enclosed(&self) -> Ball<Dd> {
        // Both may be beyond all f64 where the quotient is not: divided by the same power of two, the lower one is next to 1.
        let by = -(self.bottom.exponent() + self.bottom.bits() as i64);
        enclosed(&self.top.shifted(by)) / enclosed(&self.bottom.shifted(by))
    }
}

/// A parameter of a line: exactly, or within an enclosure.
#[derive(Clone, Debug)]
pub(crate) enum When {
    Exact(Ratio),
    /// A number that may be no quotient.
    Known(Ball<Dd>),
}

impl When {
    /// Exact where the enclosure is one number.
    pub(crate) fn from_ball(t: Ball<Dd>) -> Self {
        if t.rad == 0.0
            && let (Some(high), Some(low), Some(bottom)) =
                (dyadic(t.mid.hi), dyadic(t.mid.lo), dyadic(1.0))
        {
            return Self::Exact(Ratio::new(&high + &low, bottom));
        }
        Self::Known(t)
    }

    /// `None` where enclosures do not tell.
    pub(crate) fn cmp(&self, other: &Self) -> Option<Ordering> {
        if let (Self::Exact(a), Self::Exact(b)) = (self, other) {
            return Some(a.cmp(b));
        }
        let (a, b) = (self.enclosed(), other.enclosed());
        let off = a - b;
        if off.is_above(0.0) {
            Some(Ordering::Greater)
        } else if (-off).is_above(0.0) {
            Some(Ordering::Less)
        } else {
            None
        }
    }

    /// Whether two are proven to be the same.
    pub(crate) fn is(&self, other: &Self) -> bool {
        matches!((self, other), (Self::Exact(a), Self::Exact(b)) if a.cmp(b).is_eq())
    }

    /// In double-double.
    pub(crate) fn enclosed(&self) -> Ball<Dd> {
        match self {
            Self::Exact(t) => t.enclosed(),
            Self::Known(t) => *t,
        }
    }
}
