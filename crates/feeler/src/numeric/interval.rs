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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_finite_and_apart() {
        let nan = f64::NAN;
        let inf = f64::INFINITY;
        for (a, b) in [
            (-inf, 1.0),
            (0.0, inf),
            (nan, 1.0),
            (0.0, nan),
            (1.0, 1.0),
            (2.0, 1.0),
        ] {
            assert_eq!(Interval::new(a, b), None, "{a} {b}");
        }
        let some = Interval::new(-1.0, 3.0).unwrap();
        assert_eq!((some.start, some.end), (-1.0, 3.0));
        assert_eq!((some.length(), some.mid()), (4.0, 1.0));
        // The sum of the ends overflows.
        let large = 2f64.powi(1023);
        let middle = Interval::new(large, 1.5 * large).unwrap().mid();
        assert_eq!(middle, 1.25 * large);
    }

    #[test]
    fn closed_at_both_ends() {
        let i = Interval::new(-1.0, 3.0).unwrap();
        assert!(i.contains(-1.0) && i.contains(0.0) && i.contains(3.0));
        for t in [(-1f64).next_down(), 3f64.next_up(), f64::NAN] {
            assert!(!i.contains(t), "{t}");
        }
        assert_eq!([0.0, 0.25, 1.0].map(|s| i.lerp(s)), [-1.0, 0.0, 3.0]);
        // -1e20 + (1 + 1e20) is 0: the end is met all the same.
        assert_eq!(Interval::new(-1e20, 1.0).unwrap().lerp(1.0), 1.0);
    }
}
