//! Enclosures: ranges proven to hold a true value.

use super::dd::two_sum;

/// A closed range `[lo, hi]` proven to hold the true value; never an estimate.
///
/// `lo` may be `-inf` and `hi` may be `+inf` where nothing better is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enclosure {
    /// Proven lower bound.
    pub lo: f64,
    /// Proven upper bound.
    pub hi: f64,
}

impl Enclosure {
    /// Knows nothing.
    pub const UNKNOWN: Self = Self {
        lo: f64::NEG_INFINITY,
        hi: f64::INFINITY,
    };

    /// The enclosure of a value known exactly.
    pub const fn exact(value: f64) -> Self {
        Self {
            lo: value,
            hi: value,
        }
    }

    /// `hi - lo`, rounded up.
    pub fn width(&self) -> f64 {
        let (w, error) = two_sum(self.hi, -self.lo);
        if error > 0.0 { w.next_up() } else { w }
    }

    /// Whether `x` lies in the range (false for NaN).
    pub fn contains(&self, x: f64) -> bool {
        self.lo <= x && x <= self.hi
    }

    /// The middle; finite whenever one end is.
    pub fn mid(&self) -> f64 {
        match (self.lo.is_finite(), self.hi.is_finite()) {
            (true, true) => (0.5 * self.lo + 0.5 * self.hi).clamp(self.lo, self.hi),
            (true, false) => self.lo,
            (false, true) => self.hi,
            (false, false) => 0.0,
        }
    }

    /// The enclosure of the minimum of two enclosed values.
    pub fn min(&self, other: &Self) -> Self {
        Self {
            lo: self.lo.min(other.lo),
            hi: self.hi.min(other.hi),
        }
    }
}
