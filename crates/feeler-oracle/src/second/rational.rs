//! Exact rationals, and what is stored of them.

use super::fraction::{Fraction, gcd};
use crate::truth::{OracleError, TruthEnclosure};
use dashu_int::ops::{BitTest, UnsignedAbs};
use dashu_int::{IBig, UBig};
use feeler::numeric::Dyadic;

/// The exact value; the kernel's data are finite.
///
/// # Errors
/// `x` must be finite.
pub(crate) fn rational(x: f64) -> Result<Fraction, OracleError> {
    let d =
        Dyadic::from_f64(x).ok_or_else(|| OracleError::Refused("not a finite number".into()))?;
    Ok(of_dyadic(&d))
}

/// Of each of them.
pub(crate) fn rationals(values: &[f64]) -> Result<Vec<Fraction>, OracleError> {
    values.iter().map(|x| rational(*x)).collect()
}

pub(crate) fn of_dyadic(d: &Dyadic) -> Fraction {
    let e = d.exponent().unsigned_abs() as usize;
    if d.exponent() >= 0 {
        Fraction::from(d.mantissa() << e)
    } else {
        Fraction::from_parts(d.mantissa().clone(), UBig::ONE << e)
    }
}

/// -1, 0 or 1.
pub(crate) fn signum(x: &Fraction) -> i32 {
    sign(x.numerator())
}

/// -1, 0 or 1.
pub(crate) fn sign(x: &IBig) -> i32 {
    match x.cmp(&IBig::ZERO) {
        std::cmp::Ordering::Less => -1,
        std::cmp::Ordering::Equal => 0,
        std::cmp::Ordering::Greater => 1,
    }
}

/// Bits that a number which is no dyadic keeps.
const BITS: i64 = 192;

/// The largest dyadic of [`BITS`] bits not above `x`; `x` itself where it is one of any length.
pub(crate) fn floor(x: &Fraction) -> Dyadic {
    let (n, d) = (x.numerator(), x.denominator());
    if let Some(k) = d.trailing_zeros()
        && *d == UBig::ONE << k
    {
        return Dyadic::new(n.clone(), -(k as i64));
    }
    let size = n.unsigned_abs().bit_len() as i64 - d.bit_len() as i64;
    let shift = (BITS - size).max(0) as usize;
    let (n, d) = (n << shift, IBig::from(d.clone()));
    // Division of integers here is toward zero.
    let mut q = &n / &d;
    if sign(&n) < 0 && &q * &d != n {
        q -= IBig::ONE;
    }
    Dyadic::new(q, -(shift as i64))
}

/// The enclosure of what lies between two rationals.
pub(crate) fn enclosure(lo: &Fraction, hi: &Fraction) -> TruthEnclosure {
    TruthEnclosure {
        lo: floor(lo),
        hi: -&floor(&-hi.clone()),
    }
}

/// Integers in the same proportions, by a common positive factor; they have no common divisor.
pub(crate) fn integers(values: &[Fraction]) -> Vec<IBig> {
    let mut lcm = UBig::ONE;
    for x in values {
        let d = x.denominator();
        lcm = &lcm / gcd(&lcm, d) * d;
    }
    let scaled = values
        .iter()
        .map(|x| x.numerator() * IBig::from(&lcm / x.denominator()))
        .collect();
    primitive(scaled)
}

/// Divided by their greatest common divisor.
pub(crate) fn primitive(mut values: Vec<IBig>) -> Vec<IBig> {
    let mut g = UBig::ZERO;
    for x in &values {
        if *x == IBig::ZERO {
            continue;
        }
        g = gcd(&g, &x.unsigned_abs());
        if g == UBig::ONE {
            return values;
        }
    }
    if g != UBig::ZERO {
        let g = IBig::from(g);
        for x in &mut values {
            *x /= &g;
        }
    }
    values
}
