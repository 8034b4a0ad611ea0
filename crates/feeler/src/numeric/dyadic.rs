//! Exact dyadic numbers `m * 2^e`.

use dashu_int::IBig;
use dashu_int::ops::BitTest;
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Mul, Neg, Sub};
use std::str::FromStr;

/// An exact number `mantissa * 2^exponent`. Every finite f64 is one; sums,
/// differences and products of dyadics are dyadics.
///
/// Cost: that of integers of as many bits as the operands' exponents span.
#[derive(Clone, Debug)]
pub struct Dyadic {
    mantissa: IBig,
    exponent: i64,
}

impl Dyadic {
    /// Zero.
    pub const ZERO: Self = Self {
        mantissa: IBig::ZERO,
        exponent: 0,
    };

    /// `mantissa * 2^exponent`.
    pub fn new(mantissa: IBig, exponent: i64) -> Self {
        Self { mantissa, exponent }
    }

    /// The exact value of `x`; `None` if `x` is NaN or infinite.
    pub fn from_f64(x: f64) -> Option<Self> {
        if !x.is_finite() {
            return None;
        }
        let bits = x.to_bits();
        let biased = ((bits >> 52) & 0x7ff) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (magnitude, exponent) = if biased == 0 {
            (fraction, -1074)
        } else {
            (fraction | (1 << 52), biased - 1075)
        };
        let mantissa = IBig::from(magnitude);
        Some(Self {
            mantissa: if x < 0.0 { -mantissa } else { mantissa },
            exponent,
        })
    }

    /// The mantissa.
    pub fn mantissa(&self) -> &IBig {
        &self.mantissa
    }

    /// The exponent.
    pub fn exponent(&self) -> i64 {
        self.exponent
    }

    /// How many bits the mantissa has.
    pub(crate) fn bits(&self) -> usize {
        self.mantissa.bit_len()
    }

    /// Times `2^by`.
    pub(crate) fn shifted(&self, by: i64) -> Self {
        Self::new(self.mantissa.clone(), self.exponent + by)
    }

    /// -1, 0 or 1.
    pub fn signum(&self) -> i32 {
        match self.mantissa.cmp(&IBig::ZERO) {
            Ordering::Less => -1,
            Ordering::Equal => 0,
            Ordering::Greater => 1,
        }
    }

    /// Both mantissas at the smaller of the two exponents; zero takes the other's, whatever its own.
    fn aligned(&self, other: &Self) -> (IBig, IBig, i64) {
        let exponent = match (self.signum(), other.signum()) {
            (0, _) => other.exponent,
            (_, 0) => self.exponent,
            _ => self.exponent.min(other.exponent),
        };
        let shift = |d: &Self| match d.signum() {
            0 => IBig::ZERO,
            _ => d.mantissa.clone() << (d.exponent - exponent) as usize,
        };
        (shift(self), shift(other), exponent)
    }

    /// A nearby f64, within a relative 2^-50 of the value where that is a normal number;
    /// for display and plots, not for proofs.
    pub fn approximate(&self) -> f64 {
        let bits = self.mantissa.bit_len() as i64;
        let cut = (bits - 60).max(0);
        let top = (self.mantissa.clone() >> cut as usize)
            .try_into()
            .map_or(f64::NAN, |m: i64| m as f64);
        let mut exponent = self.exponent + cut;
        let mut value = top;
        // In steps, so that a subnormal result is not lost to an underflowing factor.
        while exponent != 0 && value != 0.0 && value.is_finite() {
            let step = exponent.clamp(-500, 500);
            value *= 2f64.powi(step as i32);
            exponent -= step;
        }
        value
    }
}

impl Add for &Dyadic {
    type Output = Dyadic;
    fn add(self, other: &Dyadic) -> Dyadic {
        let (a, b, exponent) = self.aligned(other);
        Dyadic::new(a + b, exponent)
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;
    fn sub(self, other: &Dyadic) -> Dyadic {
        let (a, b, exponent) = self.aligned(other);
        Dyadic::new(a - b, exponent)
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;
    fn mul(self, other: &Dyadic) -> Dyadic {
        Dyadic::new(
            &self.mantissa * &other.mantissa,
            self.exponent + other.exponent,
        )
    }
}

impl Neg for &Dyadic {
    type Output = Dyadic;
    fn neg(self) -> Dyadic {
        Dyadic::new(-&self.mantissa, self.exponent)
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Dyadic {}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Self) -> Ordering {
        let signs = self.signum().cmp(&other.signum());
        if signs != Ordering::Equal || self.signum() == 0 {
            return signs;
        }
        let (a, b, _) = self.aligned(other);
        a.cmp(&b)
    }
}

/// `MANTISSApEXPONENT`, the mantissa in hexadecimal: `-1fp-4` is -31/16.
impl fmt::Display for Dyadic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}p{}", self.mantissa.in_radix(16), self.exponent)
    }
}

/// Not of the form `MANTISSApEXPONENT`, or an exponent beyond +-100,000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a dyadic number: expected a hexadecimal integer, `p`, a decimal exponent")]
pub struct ParseDyadicError;

impl FromStr for Dyadic {
    type Err = ParseDyadicError;
    fn from_str(s: &str) -> Result<Self, ParseDyadicError> {
        /// Far beyond any f64 product, small enough that aligning cannot exhaust memory.
        const LARGEST_EXPONENT: i64 = 100_000;
        let (mantissa, exponent) = s.split_once('p').ok_or(ParseDyadicError)?;
        let mantissa = IBig::from_str_radix(mantissa, 16).map_err(|_| ParseDyadicError)?;
        let exponent: i64 = exponent.parse().map_err(|_| ParseDyadicError)?;
        if exponent.abs() > LARGEST_EXPONENT {
            return Err(ParseDyadicError);
        }
        Ok(Self { mantissa, exponent })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn d(x: f64) -> Dyadic {
        Dyadic::from_f64(x).unwrap()
    }

    #[test]
    fn arithmetic_is_exact() {
        // 0.1 + 0.2 and 0.3 are different numbers, and the difference is known.
        let sum = &d(0.1) + &d(0.2);
        assert!(sum < d(0.1 + 0.2));
        assert!(sum > d(0.3));
        assert_eq!(&d(1e300) * &d(1e-300), &d(1e-300) * &d(1e300));
        assert_eq!(
            d(f64::MIN_POSITIVE / 2.0).approximate(),
            f64::MIN_POSITIVE / 2.0
        );
        assert_eq!((&d(0.5) - &d(0.5)).signum(), 0);
        assert_eq!(d(-0.1).approximate(), -0.1);
        assert!(d(-1.0) < d(0.0) && d(0.0) < d(1e-300));
    }

    #[test]
    fn text_round_trips() {
        for x in [0.0, -1.9375, 1e-310, 6.02e23] {
            let text = d(x).to_string();
            assert_eq!(text.parse::<Dyadic>().unwrap(), d(x), "{text}");
        }
        assert_eq!("-1fp-4".parse::<Dyadic>().unwrap(), d(-1.9375));
        assert!("1p".parse::<Dyadic>().is_err());
        assert!("1p999999999".parse::<Dyadic>().is_err());
        for e in [100_000, -100_000] {
            assert_eq!(format!("1p{e}").parse::<Dyadic>().unwrap().exponent(), e);
        }
        assert!("1p100001".parse::<Dyadic>().is_err() && "1p-100001".parse::<Dyadic>().is_err());
    }
}
