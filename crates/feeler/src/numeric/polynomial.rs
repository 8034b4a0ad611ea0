//! Integer polynomials on [0, 1], exactly.

mod modular;

use super::gcd;
use dashu_int::ops::{DivRem, UnsignedAbs};
use dashu_int::{IBig, UBig};
use std::cmp::Ordering;

/// A polynomial `sum a_i (1 - t)^(n-i) t^i` of formal degree `n` with integer `a_i`: the
/// Bernstein form with the binomials multiplied in. With `x = t / (1 - t)` it is the ordinary
/// polynomial `sum a_i x^i` times `(1 - t)^n`, so that on [0, 1] products, divisors and roots are
/// those of ordinary polynomials on [0, inf], and signs agree. A zero `a_n` is a root at t = 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Polynomial {
    coefficients: Vec<IBig>,
}

/// A parameter `numerator / 2^exponent` in [0, 1].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    numerator: IBig,
    exponent: usize,
}

impl Parameter {
    /// t = 0.
    pub fn zero() -> Self {
        Self {
            numerator: IBig::ZERO,
            exponent: 0,
        }
    }

    /// t = 1.
    pub fn one() -> Self {
        Self {
            numerator: IBig::ONE,
            exponent: 0,
        }
    }

    /// `numerator / 2^exponent`; `None` outside [0, 1].
    pub fn new(numerator: IBig, exponent: usize) -> Option<Self> {
        let one = IBig::ONE << exponent;
        (numerator >= IBig::ZERO && numerator <= one).then_some(Self {
            numerator,
            exponent,
        })
    }

    /// The exact value of `t`; `None` outside [0, 1] (NaN too).
    pub fn from_f64(t: f64) -> Option<Self> {
        if !(0.0..=1.0).contains(&t) {
            return None;
        }
        let d = super::Dyadic::from_f64(t)?;
        if d.exponent() >= 0 {
            return Self::new(d.mantissa().clone() << d.exponent() as usize, 0);
        }
        let zeros = d.mantissa().trailing_zeros().map_or(i64::MAX, |z| z as i64);
        let cut = zeros.min(-d.exponent());
        Self::new(
            d.mantissa().clone() >> cut as usize,
            (-d.exponent() - cut) as usize,
        )
    }

    /// The middle of `self` and `other`.
    #[must_use]
    pub fn mid(&self, other: &Self) -> Self {
        let exponent = self.exponent.max(other.exponent);
        let sum = self.at(exponent) + other.at(exponent);
        if sum.trailing_zeros().is_some_and(|z| z > 0) {
            return Self {
                numerator: sum >> 1,
                exponent,
            };
        }
        Self {
            numerator: sum,
            exponent: exponent + 1,
        }
    }

    fn at(&self, exponent: usize) -> IBig {
        self.numerator.clone() << (exponent - self.exponent)
    }

    /// The exact value.
    pub fn to_dyadic(&self) -> super::Dyadic {
        super::Dyadic::new(self.numerator.clone(), -(self.exponent as i64))
    }

    /// A nearby f64 in [0, 1].
    pub fn approximate(&self) -> f64 {
        self.to_dyadic().approximate().clamp(0.0, 1.0)
    }
}

impl PartialOrd for Parameter {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Parameter {
    fn cmp(&self, other: &Self) -> Ordering {
        let exponent = self.exponent.max(other.exponent);
        self.at(exponent).cmp(&other.at(exponent))
    }
}

/// -1, 0 or 1.
pub(crate) fn signum(x: &IBig) -> i32 {
    match x.cmp(&IBig::ZERO) {
        Ordering::Less => -1,
        Ordering::Equal => 0,
        Ordering::Greater => 1,
    }
}

/// The binomials `C(n, 0..=n)`; exact for n <= 60.
pub(crate) fn binomials(n: usize) -> Vec<u64> {
    let mut row = Vec::with_capacity(n + 1);
    let mut c: u128 = 1;
    for i in 0..=n {
        row.push(c as u64);
        c = c * (n - i) as u128 / (i as u128 + 1);
    }
    row
}

impl Polynomial {
    /// From `a_0 ..= a_n`; an empty list is the zero polynomial.
    pub fn new(mut coefficients: Vec<IBig>) -> Self {
        if coefficients.is_empty() {
            coefficients.push(IBig::ZERO);
        }
        Self { coefficients }
    }

    /// From Bernstein coefficients `b_i` (`a_i = C(n, i) b_i`).
    pub fn from_bernstein(b: &[IBig]) -> Self {
        let c = binomials(b.len().saturating_sub(1));
        Self::new(b.iter().zip(c).map(|(b, c)| b * IBig::from(c)).collect())
    }

    /// `a_0 ..= a_n`.
    pub fn coefficients(&self) -> &[IBig] {
        &self.coefficients
    }

    /// The formal degree n.
    pub fn degree(&self) -> usize {
        self.coefficients.len() - 1
    }

    /// Whether it is identically zero.
    pub fn is_zero(&self) -> bool {
        self.coefficients.iter().all(|a| *a == IBig::ZERO)
    }

    /// The sign at `t`: homogeneous Horner, O(n) products.
    pub fn sign_at(&self, t: &Parameter) -> i32 {
        let one = IBig::ONE << t.exponent;
        let s = &one - &t.numerator;
        let mut power = IBig::ONE;
        let mut sum = IBig::ZERO;
        for (k, a) in self.coefficients.iter().rev().enumerate() {
            if k > 0 {
                power *= &s;
                sum *= &t.numerator;
            }
            sum += a * &power;
        }
        signum(&sum)
    }

    /// The product.
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        let mut c = vec![IBig::ZERO; self.coefficients.len() + other.coefficients.len() - 1];
        for (i, a) in self.coefficients.iter().enumerate() {
            for (j, b) in other.coefficients.iter().enumerate() {
                c[i + j] += a * b;
            }
        }
        Self::new(c)
    }

    /// `d/dt` of the quotient `self / w` of two polynomials of the same formal degree n
    /// has this numerator, up to a positive factor, of formal degree 2n - 2: in x it is
    /// `p'w - p w'`, whose coefficient of x^(2n-1) cancels, and dx/dt > 0.
    #[must_use]
    pub fn quotient_derivative(&self, w: &Self) -> Self {
        let n = self.degree();
        if n == 0 || w.degree() != n {
            return Self::new(Vec::new());
        }
        let mut c = vec![IBig::ZERO; 2 * n - 1];
        for (i, p) in self.coefficients.iter().enumerate() {
            for (j, q) in w.coefficients.iter().enumerate() {
                if i != j {
                    let weight = IBig::from(i as i64 - j as i64);
                    c[i + j - 1] += p * q * weight;
                }
            }
        }
        Self::new(c)
    }

    /// The polynomial on the part `[a, b]` of [0, 1], up to a positive factor.
    #[must_use]
    pub fn restricted(&self, a: &Parameter, b: &Parameter) -> Self {
        let e = a.exponent.max(b.exponent);
        let one = IBig::ONE << e;
        let (ta, tb) = (a.at(e), b.at(e));
        let (sa, sb) = (&one - &ta, &one - &tb);
        // 1 - t = sa S + sb T and t = ta S + tb T with S = 1 - s, T = s. Horner in both:
        // sum a_i (1-t)^(n-i) t^i.
        let linear = |p: &[IBig], a: &IBig, b: &IBig| {
            let mut out = vec![IBig::ZERO; p.len() + 1];
            for (i, c) in p.iter().enumerate() {
                out[i] += c * a;
                out[i + 1] += c * b;
            }
            out
        };
        let mut power = vec![IBig::ONE];
        let mut sum: Vec<IBig> = Vec::new();
        for (k, c) in self.coefficients.iter().rev().enumerate() {
            if k > 0 {
                power = linear(&power, &sa, &sb);
                sum = linear(&sum, &ta, &tb);
            } else {
                sum.push(IBig::ZERO);
            }
            for (s, p) in sum.iter_mut().zip(&power) {
                *s += c * p;
            }
        }
        let mut out = Self::new(sum);
        out.strip_twos();
        out
    }

    /// The halves `[0, 1/2]` and `[1/2, 1]`, up to positive factors.
    pub fn halves(&self) -> (Self, Self) {
        // Right: x = 1 + 2 x'. Left: 1/x = 1 + 2 / x'.
        let right = shift_and_double(self.coefficients.clone());
        let mut reversed = self.coefficients.clone();
        reversed.reverse();
        let mut left = shift_and_double(reversed);
        left.reverse();
        let (mut left, mut right) = (Self::new(left), Self::new(right));
        left.strip_twos();
        right.strip_twos();
        (left, right)
    }

    fn strip_twos(&mut self) {
        let common = self
            .coefficients
            .iter()
            .filter_map(IBig::trailing_zeros)
            .min()
            .unwrap_or(0);
        if common > 0 {
            for a in &mut self.coefficients {
                *a >>= common;
            }
        }
    }

    /// How often the sign changes along the coefficients: at least the number of roots in
    /// (0, 1) counted with multiplicity, and of the same parity (Descartes).
    pub fn sign_variations(&self) -> usize {
        let mut last = 0;
        let mut count = 0;
        for a in &self.coefficients {
            let s = signum(a);
            if s != 0 {
                count += usize::from(last != 0 && s != last);
                last = s;
            }
        }
        count
    }

    /// Takes out the roots at t = 0 and at t = 1; returns how many each.
    pub fn deflate_ends(&mut self) -> (usize, usize) {
        if self.is_zero() {
            return (0, 0);
        }
        let at_one = self
            .coefficients
            .iter()
            .rev()
            .take_while(|a| **a == IBig::ZERO)
            .count();
        self.coefficients.truncate(self.coefficients.len() - at_one);
        let at_zero = self
            .coefficients
            .iter()
            .take_while(|a| **a == IBig::ZERO)
            .count();
        self.coefficients.drain(..at_zero);
        (at_zero, at_one)
    }

    /// Divided by the positive greatest common divisor of the coefficients.
    fn primitive(mut self) -> Self {
        while self.coefficients.len() > 1 && self.coefficients.last() == Some(&IBig::ZERO) {
            self.coefficients.pop();
        }
        let mut g = UBig::ZERO;
        for a in &self.coefficients {
            if *a != IBig::ZERO {
                let m = a.clone().unsigned_abs();
                g = if g == UBig::ZERO { m } else { gcd(g, m) };
                if g == UBig::ONE {
                    return self;
                }
            }
        }
        if g != UBig::ZERO {
            let g = IBig::from(g);
            for a in &mut self.coefficients {
                *a /= &g;
            }
        }
        self
    }

    /// `self / d` where `d` divides it in the rationals, primitive.
    #[must_use]
    pub fn exact_quotient(&self, d: &Self) -> Self {
        let (a, d) = (self.clone().primitive(), d.clone().primitive());
        if d.degree() == 0 {
            return a;
        }
        // Both primitive, so the quotient is integral (Gauss's lemma).
        a.quotient(&d).unwrap_or(a)
    }

    /// `self / d` where it is a polynomial of integers, the leading coefficient of `d` not being zero.
    fn quotient(&self, d: &Self) -> Option<Self> {
        let n = d.degree();
        let mut r = self.coefficients.clone();
        let mut q = vec![IBig::ZERO; r.len().checked_sub(n)?];
        for k in (0..q.len()).rev() {
            let (f, rest) = (&r[k + n]).div_rem(&d.coefficients[n]);
            if rest != IBig::ZERO {
                return None;
            }
            for (i, c) in d.coefficients[..n].iter().enumerate() {
                r[k + i] -= c * &f;
            }
            q[k] = f;
        }
        r[..n]
            .iter()
            .all(|c| *c == IBig::ZERO)
            .then(|| Self::new(q))
    }

    /// d/dx.
    fn derivative(&self) -> Self {
        Self::new(
            self.coefficients
                .iter()
                .enumerate()
                .skip(1)
                .map(|(i, a)| a * IBig::from(i))
                .collect(),
        )
    }

    /// The product of the distinct irreducible factors; none at t = 0 or 1 may be left (see
    /// [`deflate_ends`](Self::deflate_ends)).
    #[must_use]
    pub fn square_free(&self) -> Self {
        self.exact_quotient(&self.gcd(&self.derivative()))
    }

    /// Factors f_1, f_2, .. with the product of the f_k^k equal to `self` up to a constant, each
    /// square-free, pairwise coprime (Yun; von zur Gathen and Gerhard, *Modern
    /// Computer Algebra*, algorithm 14.21, here by repeated gcds).
    pub fn square_free_factors(&self) -> Vec<Self> {
        let mut factors = Vec::new();
        let mut rest = self.clone().primitive();
        while rest.degree() > 0 {
            let repeated = rest.gcd(&rest.derivative());
            let distinct = rest.exact_quotient(&repeated);
            let distinct_later = if repeated.degree() > 0 {
                repeated.square_free()
            } else {
                Self::new(vec![IBig::ONE])
            };
            factors.push(distinct.exact_quotient(&distinct_later));
            rest = repeated;
        }
        factors
    }
}

/// `p(1 + 2x)`: a Taylor shift by additions, then powers of two.
fn shift_and_double(mut c: Vec<IBig>) -> Vec<IBig> {
    let n = c.len();
    for i in 0..n {
        for j in (i..n - 1).rev() {
            let higher = c[j + 1].clone();
            c[j] += higher;
        }
    }
    for (i, a) in c.iter_mut().enumerate() {
        *a <<= i;
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(c: &[i64]) -> Polynomial {
        Polynomial::new(c.iter().map(|x| IBig::from(*x)).collect())
    }

    #[test]
    fn halves_and_restriction_keep_values() {
        // (1-3t)(1+t) - 2 t^2 ... any cubic: compare signs at mapped parameters.
        let f = p(&[3, -7, 2, 5]);
        let (left, right) = f.halves();
        for k in 0..=16 {
            let half = |k: i64| Parameter::new(IBig::from(k), 5).unwrap();
            let whole = Parameter::new(IBig::from(k), 4).unwrap();
            assert_eq!(left.sign_at(&whole), f.sign_at(&half(k)));
            assert_eq!(right.sign_at(&whole), f.sign_at(&half(16 + k)));
            let part = f.restricted(&half(8), &half(24));
            assert_eq!(
                part.sign_at(&whole),
                f.sign_at(
                    &Parameter::new(IBig::from(16 + 2 * k - k), 5)
                        .unwrap()
                        .mid(&Parameter::new(IBig::from(k), 5).unwrap())
                )
            );
        }
    }

    #[test]
    fn greatest_common_divisors_and_square_free_factors() {
        let (a, b, c) = (p(&[-1, 3]), p(&[-2, 1, 1]), p(&[5, 0, 7]));
        let f = a.times(&a).times(&a).times(&b).times(&c).times(&c);
        let g = a.times(&a).times(&c);
        let d = f.gcd(&g);
        assert_eq!(d.degree(), 4);
        assert_eq!(d.exact_quotient(&g).degree(), 0);
        let factors = f.square_free_factors();
        let degrees: Vec<_> = factors.iter().map(Polynomial::degree).collect();
        assert_eq!(degrees, [2, 2, 1]);
        assert_eq!(f.square_free().degree(), 5);
    }

    #[test]
    fn parameters_in_order() {
        let at = |n: i64, e: usize| Parameter::new(IBig::from(n), e).unwrap();
        let ascending = [
            at(0, 5),
            at(1, 4),
            at(1, 3),
            at(3, 4),
            at(1, 1),
            at(7, 3),
            at(1, 0),
        ];
        for (i, a) in ascending.iter().enumerate() {
            for (j, b) in ascending.iter().enumerate() {
                assert_eq!(a.cmp(b), i.cmp(&j), "{a:?} {b:?}");
            }
        }
        assert_eq!(at(2, 3).cmp(&at(1, 2)), Ordering::Equal);
        assert_eq!(at(1, 1).mid(&at(3, 2)), at(5, 3));
        assert_eq!(at(1, 2).mid(&at(3, 2)).cmp(&at(1, 1)), Ordering::Equal);
    }

    #[test]
    fn signs_at_floats_are_exact() {
        // 3t - 1 has its root at 1/3: no f64.
        let f = Polynomial::from_bernstein(&[IBig::from(-1), IBig::from(2)]);
        let third = 1.0 / 3.0;
        assert_eq!(f.sign_at(&Parameter::from_f64(third).unwrap()), -1);
        assert_eq!(f.sign_at(&Parameter::from_f64(third.next_up()).unwrap()), 1);
        assert!(Parameter::from_f64(1.5).is_none() && Parameter::from_f64(f64::NAN).is_none());
        assert_eq!(Parameter::from_f64(0.0).unwrap(), Parameter::zero());
        let at = |n: i64| Parameter::new(IBig::from(n), 3);
        assert!(at(-1).is_none() && at(9).is_none() && at(0).is_some() && at(8).is_some());
    }
}
