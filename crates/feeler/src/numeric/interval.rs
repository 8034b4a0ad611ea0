//! Parameter intervals.

/// A closed parameter interval `[start, end]` with `start < end`, both finite.
///
/// Used for domains of curves and surfaces. It carries no error semantics; for
/// a range that is proven to hold a value see [`Enclosure`](super::Enclosure).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub start: f64,
    /// Upper end.
    pub end: f64,
}

impl Interval {
    /// The interval from `start` to `end`; `None` unless both are finite and
    /// `start < end`.
    pub fn new(start: f64, end: f64) -> Option<Self> {
        (start.is_finite() && end.is_finite() && start < end).then_some(Self { start, end })
    }

    /// `end - start`, rounded.
    pub fn length(&self) -> f64 {
        self.end - self.start
    }

    /// The middle, rounded; always within the interval.
    pub fn mid(&self) -> f64 {
        // Halving first cannot overflow.
        (0.5 * self.start + 0.5 * self.end).clamp(self.start, self.end)
    }

    /// Whether `t` lies in the closed interval (false for NaN).
    pub fn contains(&self, t: f64) -> bool {
        self.start <= t && t <= self.end
    }

    /// The parameter at fraction `s`: exactly `start` at 0 and `end` at 1.
    pub fn lerp(&self, s: f64) -> f64 {
        if s == 1.0 {
            self.end
        } else {
            self.start + s * (self.end - self.start)
        }
    }
}
