//! Greatest common divisors of large integers.

use dashu_int::UBig;
use dashu_int::ops::{BitTest, Gcd};

/// Up to so many bits dashu-int divides without scratch memory: 32 words of 64 bits.
const WITHOUT_SCRATCH: usize = 32 * 64;
/// Up to so many, more scratch is enough for less: above, the way it multiplies changes once more.
const SCRATCH_GROWS: usize = 1024 * 64;

/// The greatest common divisor.
///
/// dashu-int (0.4.3) takes the scratch memory for all divisions on its way at once, as much as the first of them needs. Where
/// a remainder is shorter than its divisor by more than 32 words and both are longer than that, a later division needs
/// more, and it panics: "not enough memory allocated". Such numbers are no accident here, they are sums of powers of two
/// far apart. So the longer number is made as long as the first division must be to need the most of all, by a multiple of the
/// shorter one, which is no change to the divisor; what is longer than all reason goes by Euclid's plain steps first.
pub(crate) fn gcd(a: UBig, b: UBig) -> UBig {
    let (mut long, mut short) = if a < b { (b, a) } else { (a, b) };
    while short.bit_len() > SCRATCH_GROWS {
        let rest = long % &short;
        (long, short) = (short, rest);
    }
    if short.bit_len() > WITHOUT_SCRATCH {
        let padding = &short << (long.bit_len().max(2 * short.bit_len()));
        long += padding;
    }
    long.gcd(short)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bits without pattern.
    fn number(bits: usize, seed: u64) -> UBig {
        let mut s = seed;
        let mut n = UBig::ONE;
        while n.bit_len() < bits {
            s = s.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            n = (n << 32) + UBig::from(s >> 32);
        }
        n
    }

    /// By Euclid alone.
    fn plain(mut a: UBig, mut b: UBig) -> UBig {
        while b != UBig::ZERO {
            let rest = a % &b;
            (a, b) = (b, rest);
        }
        a
    }

    #[test]
    fn remainders_that_are_much_shorter() {
        // One word of common divisor, then lengths on both sides of every threshold.
        let g = number(60, 5);
        for (m, r) in [
            (6000, 2200),
            (6400, 3200),
            (9000, 2100),
            (20_000, 6500),
            (70_000, 30_000),
            (140_000, 40_000),
        ] {
            let (b, rest) = (number(m, 1) * &g, number(r, 2) * &g);
            let a = &b * UBig::from(3u8) + &rest;
            let expected = plain(a.clone(), b.clone());
            assert_eq!(&expected % &g, UBig::ZERO);
            assert_eq!(gcd(a.clone(), b.clone()), expected, "{m} {r}");
            assert_eq!(gcd(b, a), expected, "{m} {r}");
        }
    }

    #[test]
    fn small_numbers_and_zero() {
        let n = |x: u64| UBig::from(x);
        assert_eq!(gcd(n(12), n(18)), n(6));
        assert_eq!(gcd(n(0), n(7)), n(7));
        assert_eq!(gcd(n(7), n(0)), n(7));
        let long = number(5000, 3);
        assert_eq!(gcd(long.clone(), long.clone()), long);
    }
}
