//! Triple-double numbers.

use super::dd::{fast_two_sum, two_prod, two_sum};
use super::{Dd, Real};
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// An unevaluated sum of three f64, the second at most `2^-53` of the first, the third `2^-105`: more than 153 bits. For the few values whose last digits
/// double-double does not give; an operation takes some tens of nanoseconds.
///
/// # Errors
/// Let `u = 2^-53`. Each operation adds up a list of f64 exactly (Shewchuk's expansions) and keeps its three leading parts, as
/// [`leading`] has them: what is cut off is below `2^-153` of the sum. Sums and differences lose nothing else. Products
/// leave out `a_1 b_2`, `a_2 b_1`, `a_2 b_2`, together below `5 u^3 |a b|`, and round the three products of order `u^2` by `u` of at
/// most `2.1 u^2 |a b|` each: in all below `2^-152`. Quotients and square roots: see there. [`Real::UNIT`] is `2^-148`.
///
/// Source: Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, Discrete and
/// Computational Geometry 18 (1997), theorems 10 and 23. Fused multiply-add is not used: the bits are the same on every platform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Td([f64; 3]);

/// The exact sum of some numbers, as an expansion: parts that do not overlap, the least first, zeros left out.
struct Expansion<const N: usize> {
    parts: [f64; N],
    count: usize,
}

impl<const N: usize> Expansion<N> {
    /// Shewchuk's Grow-Expansion (theorem 10), once for each number.
    fn sum(terms: [f64; N]) -> Self {
        let (mut parts, mut count) = ([0.0; N], 0);
        for x in terms {
            let (mut q, mut kept) = (x, 0);
            for i in 0..count {
                let (sum, rest) = two_sum(q, parts[i]);
                q = sum;
                if rest != 0.0 {
                    parts[kept] = rest;
                    kept += 1;
                }
            }
            if q != 0.0 {
                parts[kept] = q;
                kept += 1;
            }
            count = kept;
        }
        Self { parts, count }
    }

    /// The three leading parts of the sum, and nothing where there are fewer.
    ///
    /// Shewchuk's Compress (theorem 23). On the way down each `(Q, q) = Q + e_i` has `|q| <= ulp(Q) / 2`, and what is still to come is below
    /// the last bit of `e_i`, so of `q`: the next part that is kept, made of these, is at most `2 |q| <= ulp(Q)`. On the
    /// way up `(Q, q) = g_i + Q` has `|q| <= ulp(Q) / 2` too. So the first of the result is within half an ulp of the sum of the
    /// rest and itself, the second at most half an ulp of the first, the third at most `2^-105` of it (but for a factor of
    /// `1 + 2^-50`), and all further ones together at most `2^-157 + 2^-209 + ...` of the largest part on the way down, which is at most
    /// twice the sum: below `2^-153` with ease.
    fn leading(mut self) -> Td {
        let Some(last) = self.count.checked_sub(1) else {
            return Td::ZERO;
        };
        let parts = &mut self.parts;
        let (mut q, mut bottom) = (parts[last], last);
        for i in (0..last).rev() {
            let (sum, rest) = fast_two_sum(q, parts[i]);
            q = sum;
            if rest != 0.0 {
                parts[bottom] = q;
                bottom -= 1;
                q = rest;
            }
        }
        parts[bottom] = q;
        // The least first; of what comes up, the last two are wanted.
        let mut below = [0.0; 2];
        for part in &parts[bottom + 1..=last] {
            let (sum, rest) = fast_two_sum(*part, q);
            q = sum;
            if rest != 0.0 {
                below = [rest, below[0]];
            }
        }
        Td([q, below[0], below[1]])
    }
}

impl Add for Td {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, o.0);
        Expansion::sum([c, f, b, e, a, d]).leading()
    }
}

impl Neg for Td {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl Sub for Td {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Td {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        let (p, p_rest) = two_prod(a[0], b[0]);
        let (q, q_rest) = two_prod(a[0], b[1]);
        let (r, r_rest) = two_prod(a[1], b[0]);
        let last = [a[0] * b[2], a[1] * b[1], a[2] * b[0]];
        let terms = [last[0], last[1], last[2], q_rest, r_rest, p_rest, q, r, p];
        Expansion::sum(terms).leading()
    }
}

impl Div for Td {
    type Output = Self;
    /// Long division: each step divides what is left by the leading part of the divisor and leaves less than `2^-50` of it; what is left is
    /// off by two roundings of at most the dividend, the sum of the four parts by one: below five units of the quotient. For divisors above
    /// 1e-250: below, what underflows is not [`TINY`](crate::numeric::TINY) beside the quotient.
    fn div(self, o: Self) -> Self {
        let (mut left, mut parts) = (self, [0.0; 4]);
        for part in &mut parts {
            *part = left.0[0] / o.0[0];
            left = left - o * Self::from_f64(*part);
        }
        parts.reverse();
        Expansion::sum(parts).leading()
    }
}

impl PartialOrd for Td {
    /// By the sign of the difference, whose leading part has it.
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        (*self - *o).0[0].partial_cmp(&0.0)
    }
}

impl Real for Td {
    const UNIT: f64 = 1.0 / ((1u128 << 100) as f64 * (1u64 << 48) as f64);
    const DIV_UNIT: f64 = 8.0 * Self::UNIT;
    const ZERO: Self = Self([0.0; 3]);
    const ONE: Self = Self([1.0, 0.0, 0.0]);

    fn from_f64(x: f64) -> Self {
        Self([x, 0.0, 0.0])
    }
    fn from_dd(x: Dd) -> (Self, f64) {
        (Self([x.hi, x.lo, 0.0]), 0.0)
    }
    fn to_dd(self) -> (Dd, f64) {
        let [a, b, c] = self.0;
        (Dd { hi: a, lo: b }, c.abs())
    }
    fn approximate(self) -> f64 {
        self.0[0]
    }
    fn half(self) -> Self {
        Self(self.0.map(|x| 0.5 * x))
    }
    /// Two steps of Newton's method from the root of the leading part, `s + (x - s^2) / (2 s)`: each leaves the square of half the relative
    /// error, 2^-106 and 2^-214 of it; the roundings of the last are below four units of `x`, halved, and one of the sum, with units of
    /// `2^-152`, as above.
    fn sqrt(self) -> Self {
        if self.0[0] == 0.0 {
            return Self::ZERO;
        }
        let mut s = Self::from_f64(self.0[0].sqrt());
        for _ in 0..2 {
            s = s + (self - s * s).half() / s;
        }
        s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dyadic;

    fn exact(x: Td) -> Dyadic {
        let part = |x: f64| Dyadic::from_f64(x).unwrap();
        &(&part(x.0[0]) + &part(x.0[1])) + &part(x.0[2])
    }

    fn magnitude(x: Dyadic) -> Dyadic {
        if x.signum() < 0 { -&x } else { x }
    }

    /// `|computed - truth| <= units * UNIT * |computed|`, both times a common factor.
    fn check(error: Dyadic, computed: Dyadic, unit: f64, what: &str) {
        let limit = &Dyadic::from_f64(unit).unwrap() * &magnitude(computed);
        assert!(magnitude(error) <= limit, "{what}");
    }

    fn random(seed: &mut u64) -> u64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        *seed
    }

    /// Numbers of three parts as operations leave them, and of few bits, so that sums cancel.
    fn sample(seed: &mut u64) -> Td {
        let mut terms = [0.0; 6];
        for term in &mut terms {
            let r = random(seed);
            let m = match r % 4 {
                0 => 0.0,
                1 => (r >> 60) as f64 - 7.5,
                _ => (r >> 11) as f64 / (1u64 << 53) as f64 - 0.5,
            };
            *term = m * 2f64.powi(((r >> 3) % 180) as i32 - 160);
        }
        Expansion::sum(terms).leading()
    }

    #[test]
    fn operations_are_as_exact_as_they_say() {
        let mut seed = 0x0123_4567_89ab_cdef;
        for _ in 0..40_000 {
            let (a, b) = (sample(&mut seed), sample(&mut seed));
            // Next to each other, so that they cancel.
            let near = a + b * Td::from_f64(2f64.powi(-(random(&mut seed) as i32 & 127)));
            let (x, y, z) = (exact(a), exact(b), exact(near));
            for (c, w) in [(b, &y), (near, &z)] {
                let (sum, difference) = (a + c, a - c);
                check(&exact(sum) - &(&x + w), exact(sum), Td::UNIT, "sum");
                check(
                    &exact(difference) - &(&x - w),
                    exact(difference),
                    Td::UNIT,
                    "difference",
                );
                let product = a * c;
                check(
                    &exact(product) - &(&x * w),
                    exact(product),
                    Td::UNIT,
                    "product",
                );
                assert_eq!(a.partial_cmp(&c), Some(x.cmp(w)));
                if c.0[0] != 0.0 {
                    // q = a / c: q c - a against q c.
                    let q = exact(a / c);
                    check(&(&q * w) - &x, &q * w, Td::DIV_UNIT, "quotient");
                }
            }
            if x.signum() > 0 {
                // s^2 - x = (s - r)(s + r): within twice the units of s^2.
                let s = exact(a.sqrt());
                check(&(&s * &s) - &x, &s * &s, 1.9 * Td::UNIT, "root");
            }
            // The parts that products leave out rest on this.
            for part in [a, near, a * b] {
                let [p, q, r] = part.0;
                let (second, third) = (2f64.powi(-53), 1.001 * 2f64.powi(-105));
                assert!(
                    q.abs() <= p.abs() * second && r.abs() <= p.abs() * third,
                    "{part:?}"
                );
            }
        }
    }

    #[test]
    fn conversions_tell_what_they_lose() {
        let mut seed = 0xfeed_5678_9abc_def1;
        for _ in 0..1_000 {
            let a = sample(&mut seed);
            let (dd, error) = a.to_dd();
            let back = Td::from_dd(dd);
            assert_eq!(back.1, 0.0);
            let off = magnitude(&exact(a) - &exact(back.0));
            assert!(off <= Dyadic::from_f64(error).unwrap());
            let twice = a.half().0.map(|x| 2.0 * x);
            assert_eq!(twice, a.0);
        }
    }
}
