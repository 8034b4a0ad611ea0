//! Quantiles.

use serde::Serialize;

/// How some numbers are spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// How many.
    pub count: usize,
    /// Half of them are at most this.
    pub median: f64,
    /// 99 % of them are at most this.
    pub p99: f64,
    /// 99.9 % of them are at most this.
    pub p999: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// Of some numbers, if there are any.
    pub fn of(numbers: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut all: Vec<f64> = numbers.into_iter().collect();
        all.sort_by(f64::total_cmp);
        Some(Self {
            count: all.len(),
            median: quantile(&all, 0.5)?,
            p99: quantile(&all, 0.99)?,
            p999: quantile(&all, 0.999)?,
            max: *all.last()?,
        })
    }
}

/// The least of sorted numbers that a fraction `q` of them does not exceed.
pub(crate) fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    let rank = (q * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.max(1) - 1).copied()
}

/// An upper bound at 95 % confidence for the share of events of which none was seen in `n`: 3/n (the rule of three;
/// -ln 0.05 = 2.996).
pub(crate) fn none_seen(n: usize) -> f64 {
    (3.0 / n as f64).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_numbers_that_were_there() {
        let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(quantile(&hundred, 0.5), Some(50.0));
        assert_eq!(quantile(&hundred, 0.99), Some(99.0));
        assert_eq!(quantile(&hundred, 1.0), Some(100.0));
        assert_eq!(quantile(&[7.0], 0.001), Some(7.0));
        assert_eq!(quantile(&[], 0.5), None);
        let spread = Spread::of([3.0, 1.0, 2.0]).unwrap();
        assert_eq!((spread.count, spread.median, spread.max), (3, 2.0, 3.0));
        assert_eq!(Spread::of([]), None);
    }
}
