//! Exact integer polynomials in the power basis: Sturm's theorem.
//!
//! J. C. F. Sturm, *Mémoire sur la résolution des équations numériques* (1835); with a second polynomial, as
//! in Basu, Pollack, Roy, *Algorithms in Real Algebraic Geometry*, 2.2 (the Tarski query). Pseudo-remainders
//! are made with positive factors only, and each is divided by its content, which keeps all signs.

use super::fraction::Fraction;
use super::rational::{primitive, sign};
use dashu_int::IBig;
use dashu_int::ops::RemEuclid;

/// `a_0 ..= a_n`, `a_n` not zero; zero is the empty list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Polynomial(pub(crate) Vec<IBig>);

/// The binomials `C(n, 0..=n)`.
pub(crate) fn binomials(n: usize) -> Vec<IBig> {
    let mut row = vec![IBig::ONE];
    for i in 0..n {
        row.push(&row[i] * IBig::from(n - i) / IBig::from(i + 1));
    }
    row
}

impl Polynomial {
    /// A positive multiple of the polynomial with these coefficients.
    pub(crate) fn new(mut c: Vec<IBig>) -> Self {
        while c.last().is_some_and(|x| *x == IBig::ZERO) {
            c.pop();
        }
        Self(primitive(c))
    }

    /// From its coefficients in Bernstein form of a degree that may be higher than its own.
    pub(crate) fn from_bernstein(b: &[IBig]) -> Self {
        Self::new(powers(b))
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    /// 0 for constants and for zero.
    pub(crate) fn degree(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    pub(crate) fn derivative(&self) -> Self {
        let terms = self.0.iter().enumerate().skip(1);
        Self::new(terms.map(|(k, a)| a * IBig::from(k)).collect())
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self(Vec::new());
        }
        let mut c = vec![IBig::ZERO; self.0.len() + other.0.len() - 1];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                c[i + j] += a * b;
            }
        }
        Self::new(c)
    }

    /// `f(n / d) d^degree`, d > 0.
    pub(crate) fn value_at(&self, n: &IBig, d: &IBig) -> IBig {
        let mut sum = IBig::ZERO;
        let mut power = IBig::ONE;
        for a in self.0.iter().rev() {
            sum = sum * n + a * &power;
            power *= d;
        }
        sum
    }

    pub(crate) fn sign_at(&self, x: &Fraction) -> i32 {
        sign(&self.value_at(x.numerator(), &IBig::from(x.denominator().clone())))
    }

    /// A positive multiple of the remainder of `self` by `d`, which is not zero.
    pub(crate) fn remainder(&self, d: &Self) -> Self {
        let mut r = self.0.clone();
        let Some(lead) = d.0.last() else {
            return Self(Vec::new());
        };
        let negative = sign(lead) < 0;
        let size = if negative { -lead } else { lead.clone() };
        while r.len() >= d.0.len() {
            let Some(top) = r.pop() else { break };
            if top == IBig::ZERO {
                continue;
            }
            let top = if negative { -top } else { top };
            for x in &mut r {
                *x *= &size;
            }
            let shift = r.len() + 1 - d.0.len();
            for (k, b) in d.0[..d.0.len() - 1].iter().enumerate() {
                r[shift + k] -= &top * b;
            }
        }
        Self::new(r)
    }

    fn negated(&self) -> Self {
        Self(self.0.iter().map(|a| -a).collect())
    }

    /// The greatest common divisor, up to a constant.
    pub(crate) fn gcd(&self, other: &Self) -> Self {
        let (mut a, mut b) = (self.clone(), other.clone());
        while !b.is_zero() {
            (a, b) = (b.clone(), a.remainder(&b));
        }
        a
    }

    /// The quotient by a divisor, up to a positive factor times the sign of the divisor's leading coefficient.
    pub(crate) fn quotient(&self, d: &Self) -> Self {
        let Some(lead) = d.0.last() else {
            return self.clone();
        };
        let mut r = self.0.clone();
        let mut q = Vec::new();
        while r.len() >= d.0.len() {
            let Some(top) = r.pop() else { break };
            for x in r.iter_mut().chain(&mut q) {
                *x *= lead;
            }
            let shift = r.len() + 1 - d.0.len();
            for (k, b) in d.0[..d.0.len() - 1].iter().enumerate() {
                r[shift + k] -= &top * b;
            }
            // Multiplied by lead once a step, as the rest will be.
            q.push(top);
        }
        q.reverse();
        Self::new(q)
    }

    /// Square-free factors: factor `m - 1` holds the roots of multiplicity m (Yun's algorithm, D. Y. Y. Yun, *On
    /// square-free decomposition algorithms*, SYMSAC 1976, with gcds taken one multiplicity at a time).
    pub(crate) fn square_free_factors(&self) -> Vec<Self> {
        let mut factors = Vec::new();
        // with[m]: the product of the roots of multiplicity > m.
        let mut rest = self.clone();
        let mut repeated = rest.gcd(&rest.derivative());
        let mut simple = rest.quotient(&repeated);
        while simple.degree() > 0 {
            rest = repeated;
            let next = simple.gcd(&rest);
            factors.push(simple.quotient(&next));
            repeated = rest.quotient(&next);
            simple = next;
        }
        factors
    }
}

/// Coefficients of powers from Bernstein form: as many, also where the highest are 0.
fn powers(b: &[IBig]) -> Vec<IBig> {
    let mut differences = b.to_vec();
    let mut power = Vec::with_capacity(b.len());
    for binomial in binomials(b.len().saturating_sub(1)) {
        power.push(&differences[0] * binomial);
        differences = differences.windows(2).map(|w| &w[1] - &w[0]).collect();
    }
    power
}

/// 2^61 - 1, a prime.
const PRIME: u64 = (1 << 61) - 1;

fn times(a: u64, b: u64) -> u64 {
    let x = u128::from(a) * u128::from(b);
    // 2^61 is 1; both parts are below it.
    let sum = (x as u64 & PRIME) + (x >> 61) as u64;
    if sum >= PRIME { sum - PRIME } else { sum }
}

fn less(a: u64, b: u64) -> u64 {
    if a >= b { a - b } else { a + PRIME - b }
}

/// By Fermat's little theorem, of what is not 0.
fn inverse(a: u64) -> u64 {
    let (mut result, mut square, mut rest) = (1, a, PRIME - 2);
    while rest > 0 {
        if rest & 1 == 1 {
            result = times(result, square);
        }
        square = times(square, square);
        rest >>= 1;
    }
    result
}

/// Coefficients of powers modulo the prime, from Bernstein form: as many, also where the highest are 0.
fn residues(b: &[IBig]) -> Vec<u64> {
    let prime = IBig::from(PRIME);
    let residue = |x: &IBig| u64::try_from(x.rem_euclid(&prime)).unwrap_or_default();
    let mut differences: Vec<u64> = b.iter().map(residue).collect();
    let mut power = Vec::with_capacity(b.len());
    for binomial in binomials(b.len().saturating_sub(1)) {
        power.push(times(differences[0], residue(&binomial)));
        differences = differences.windows(2).map(|w| less(w[1], w[0])).collect();
    }
    power
}

/// Whether two polynomials in Bernstein form of one degree are proven to have no common divisor but constants.
///
/// A common divisor over the rationals may be taken primitive, and then divides both in integers (Gauss); its leading coefficient divides theirs.
/// Where the prime does not divide one of these, it keeps its degree modulo the prime, and is a common divisor there.
/// So where there is none there, there is none. `false` says nothing.
pub(crate) fn coprime_by_residues(a: &[IBig], b: &[IBig]) -> bool {
    let degree = |c: &[IBig]| powers(c).iter().rposition(|x| *x != IBig::ZERO);
    let forms = [a, b];
    let [mut a, mut b] = forms.map(residues);
    if a.last() == Some(&0) && b.last() == Some(&0) {
        // Of lower degree than the form, both, or else the prime divides what leads.
        let [Some(m), Some(n)] = forms.map(degree) else {
            return false;
        };
        a.truncate(m + 1);
        b.truncate(n + 1);
        if a[m] == 0 && b[n] == 0 {
            return false;
        }
    }
    loop {
        for f in [&mut a, &mut b] {
            while f.last() == Some(&0) {
                f.pop();
            }
        }
        if a.len() < b.len() {
            std::mem::swap(&mut a, &mut b);
        }
        let (Some(top), Some(lead)) = (a.last(), b.last()) else {
            // b is 0: a is the greatest common divisor.
            return a.len() == 1;
        };
        let factor = times(*top, inverse(*lead));
        let shift = a.len() - b.len();
        for (k, x) in b.iter().enumerate() {
            a[shift + k] = less(a[shift + k], times(factor, *x));
        }
    }
}

/// A Sturm chain.
pub(crate) struct Chain(Vec<Polynomial>);

impl Chain {
    /// Of `f`, not zero.
    pub(crate) fn new(f: &Polynomial) -> Self {
        Self::from(f, f.derivative())
    }

    /// Of `f` with `g`: differences of variations are sums of the signs of g at the roots of f.
    pub(crate) fn query(f: &Polynomial, g: &Polynomial) -> Self {
        Self::from(f, f.derivative().times(g).remainder(f))
    }

    fn from(f: &Polynomial, second: Polynomial) -> Self {
        let mut chain = vec![f.clone()];
        let mut next = second;
        while !next.is_zero() {
            chain.push(next);
            let [.., a, b] = chain.as_slice() else { break };
            next = a.remainder(b).negated();
        }
        Self(chain)
    }

    /// The gcd of the two polynomials it began with.
    pub(crate) fn gcd(&self) -> &Polynomial {
        &self.0[self.0.len() - 1]
    }

    pub(crate) fn variations(&self, x: &Fraction) -> i64 {
        let mut count = 0;
        let mut last = 0;
        for f in &self.0 {
            let s = f.sign_at(x);
            if s != 0 {
                count += i64::from(last * s < 0);
                last = s;
            }
        }
        count
    }

    /// The number of distinct roots between a and b, neither of which is one; with a second polynomial
    /// the sum of its signs there.
    pub(crate) fn between(&self, a: &Fraction, b: &Fraction) -> i64 {
        self.variations(a) - self.variations(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product(factors: &[&[i64]]) -> Polynomial {
        let one = Polynomial(vec![IBig::ONE]);
        factors.iter().fold(one, |f, g| {
            f.times(&Polynomial::new(g.iter().map(|x| IBig::from(*x)).collect()))
        })
    }

    fn r(n: i64, d: u64) -> Fraction {
        Fraction::from_parts(n.into(), d.into())
    }

    #[test]
    fn roots_are_counted_and_queried() {
        // (2t - 1) (3t - 1)^2 (t^2 + 1) (t - 5)
        let f = product(&[&[-1, 2], &[-1, 3], &[-1, 3], &[1, 0, 1], &[-5, 1]]);
        assert_eq!(f.degree(), 6);
        let chain = Chain::new(&f);
        assert_eq!(chain.between(&r(0, 1), &r(1, 1)), 2);
        assert_eq!(chain.between(&r(2, 5), &r(6, 1)), 2);
        assert_eq!(chain.gcd().degree(), 1);
        // g = 12 t - 5 is < 0 at 1/3, > 0 at 1/2 and 5.
        let g = product(&[&[-5, 12]]);
        assert_eq!(Chain::query(&f, &g).between(&r(0, 1), &r(6, 1)), 1);
        let factors = f.square_free_factors();
        assert_eq!(factors.len(), 2);
        assert_eq!((factors[0].degree(), factors[1].degree()), (4, 1));
        assert_eq!(factors[1].sign_at(&r(1, 3)), 0);
        assert_eq!(factors[0].sign_at(&r(1, 2)), 0);
        // The product of the factors' powers is f up to a factor.
        let back = factors[0].times(&factors[1]).times(&factors[1]);
        assert!(back == f || back == f.negated());
        assert_eq!(f.quotient(&product(&[&[-5, 1]])).degree(), 5);
    }

    #[test]
    fn triple_roots_and_constants() {
        let f = product(&[&[-1, 2], &[-1, 2], &[-1, 2], &[-2, 3]]);
        let factors = f.square_free_factors();
        assert_eq!(
            factors.iter().map(Polynomial::degree).collect::<Vec<_>>(),
            [1, 0, 1]
        );
        assert!(product(&[&[7]]).square_free_factors().is_empty());
        assert_eq!(f.sign_at(&r(1, 2)), 0);
        assert_eq!(f.sign_at(&r(3, 5)), -1);
    }

    #[test]
    fn divisors_modulo_a_prime() {
        let big = |c: &[i64]| c.iter().map(|x| IBig::from(*x)).collect::<Vec<_>>();
        // In Bernstein form of degree 2: t (1 - t), t^2, (1 - t)^2, 1; t + t^2 shares t with the first.
        let [a, b, c, one] = [[0, 1, 0], [0, 0, 1], [1, 0, 0], [1, 1, 1]].map(|x| big(&x));
        assert!(!coprime_by_residues(&a, &b) && !coprime_by_residues(&a, &c));
        assert!(coprime_by_residues(&b, &c) && coprime_by_residues(&a, &one));
        assert!(!coprime_by_residues(&a, &big(&[0, 1, 4])));
        // One leading coefficient that the prime does not divide is enough: 1 + prime t^2 and 2 t.
        let p = IBig::from(PRIME);
        let with = [IBig::ONE, IBig::ONE, IBig::ONE + &p];
        assert!(coprime_by_residues(&with, &big(&[0, 1, 2])));
        // Both of degree 1, in the form of degree 2: 2 + 2 t and 2 t; 4 t and 2 t; 2 + 2 prime t and 4 + 2 prime t, where the prime divides both.
        let t = big(&[0, 1, 2]);
        assert!(coprime_by_residues(&big(&[2, 3, 4]), &t));
        assert!(!coprime_by_residues(&big(&[0, 2, 4]), &t));
        let steep = [1, 2].map(|c| [0, 1, 2].map(|k| IBig::from(2 * c) + IBig::from(k) * &p));
        assert!(!coprime_by_residues(&steep[0], &steep[1]));
        assert_eq!(Polynomial::from_bernstein(&a).0, big(&[0, 1, -1]));
        assert_eq!(times(PRIME - 1, PRIME - 1), 1);
        assert_eq!(times(inverse(12345), 12345), 1);
        assert_eq!(times(PRIME - 2, 3), PRIME - 6);
    }
}
