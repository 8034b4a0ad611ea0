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

#[cfg(test)]
mod tests {
    use super::*;

    const INF: f64 = f64::INFINITY;

    #[test]
    fn widths_are_rounded_up() {
        let width = |lo, hi| Enclosure { lo, hi }.width();
        assert_eq!(width(1.0, 3.0), 2.0);
        assert_eq!(width(0.5, 0.5), 0.0);
        // 1 + 2^-60 and 1 - 2^-60.
        let tiny = 1.0 / (1u64 << 60) as f64;
        assert_eq!(width(-tiny, 1.0), 1f64.next_up());
        assert_eq!(width(tiny, 1.0), 1.0);
        assert_eq!(Enclosure::UNKNOWN.width(), INF);
    }

    #[test]
    fn closed_at_both_ends() {
        let e = Enclosure { lo: -1.0, hi: 2.0 };
        assert!(e.contains(-1.0) && e.contains(2.0) && e.contains(0.5));
        assert!(!e.contains((-1f64).next_down()) && !e.contains(2f64.next_up()));
        assert!(!e.contains(f64::NAN));
        assert!(Enclosure::exact(0.1).contains(0.1));
    }

    #[test]
    fn middles_are_finite() {
        let mid = |lo, hi| Enclosure { lo, hi }.mid();
        assert_eq!(mid(-1.0, 3.0), 1.0);
        let large = 2f64.powi(1023);
        assert_eq!(mid(large, 1.5 * large), 1.25 * large);
        assert_eq!(mid(2.0, INF), 2.0);
        assert_eq!(mid(-INF, 3.0), 3.0);
        assert_eq!(mid(-INF, INF), 0.0);
        let least = Enclosure { lo: 0.0, hi: 5.0 }.min(&Enclosure { lo: 1.0, hi: 2.0 });
        assert_eq!(least, Enclosure { lo: 0.0, hi: 2.0 });
    }
}
