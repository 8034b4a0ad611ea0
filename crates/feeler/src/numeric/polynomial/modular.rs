//! Greatest common divisors of polynomials, by their images modulo primes.

use super::Polynomial;
use crate::numeric::gcd;
use dashu_int::IBig;
use dashu_int::ops::UnsignedAbs;

impl Polynomial {
    /// The greatest common divisor in x, primitive, up to sign. Roots at t = 1 (formal zero
    /// leading coefficients) are not seen: deflate first. Zero with p gives p.
    ///
    /// It is put together from images modulo primes (von zur Gathen and Gerhard, *Modern Computer Algebra*, 6.7): the
    /// coefficients of remainders over the integers grow. With f and g primitive, h the divisor that is sought, and b the greatest
    /// common divisor of their leading coefficients, which that of h divides, this is why it is right and why it ends:
    ///
    /// A prime that divides neither leading coefficient leaves h its degree, and the image of h divides those of f and g: their
    /// greatest common divisor has at least the degree of h. Where it is constant, so is h. What is put together has its
    /// degree, the leading coefficient being b modulo each of the primes, which is not 0. If the primitive part of that divides f
    /// and g over the integers, it divides h, whose degree is no higher and which is primitive, too: it is h, up to sign.
    ///
    /// Primes are of no use that divide a leading coefficient, or the resultant of f / h and g / h (for the others the degree is
    /// that of h). These numbers are not 0, so that not all primes below 2^63 divide them: their product has more bits than
    /// a machine. Each of the others shows b h / (leading coefficient of h), a polynomial of integers. That is what is put
    /// together as soon as the product of such primes is more than twice its coefficients; then one more changes nothing, and
    /// the divisions succeed.
    #[must_use]
    pub fn gcd(&self, other: &Self) -> Self {
        if self.is_zero() {
            return other.clone().primitive();
        }
        if other.is_zero() {
            return self.clone().primitive();
        }
        // Before the contents are taken out, which takes longer: most polynomials have nothing in common. A prime that does not
        // divide a leading coefficient does not divide the content, without which images are the same up to a factor.
        let mut primes = Primes::default();
        let mut prime = primes.next();
        let mut image = prime.common_divisor(self, other);
        if image.as_ref().is_some_and(|h| h.len() == 1) {
            return Self::new(vec![IBig::ONE]);
        }
        let (f, g) = (self.clone().primitive(), other.clone().primitive());
        let leading = |p: &Self| p.coefficients[p.degree()].clone().unsigned_abs();
        let mut lifted = Lifted::new(IBig::from(gcd(leading(&f), leading(&g))));
        loop {
            if let Some(image) = image {
                if image.len() == 1 {
                    return Self::new(vec![IBig::ONE]);
                }
                if lifted.add(&prime, &image) {
                    let h = Self::new(lifted.coefficients.clone()).primitive();
                    if f.quotient(&h).is_some() && g.quotient(&h).is_some() {
                        return h;
                    }
                }
            }
            prime = primes.next();
            image = prime.common_divisor(&f, &g);
        }
    }
}

/// What images of one degree have in common: a polynomial modulo the product of their primes.
struct Lifted {
    leading: IBig,
    modulus: IBig,
    /// Between minus and plus half the modulus.
    coefficients: Vec<IBig>,
}

impl Lifted {
    fn new(leading: IBig) -> Self {
        Self {
            leading,
            modulus: IBig::ONE,
            coefficients: Vec::new(),
        }
    }

    /// One more image, which is monic: whether what there is now is worth a trial, because it is the first of its degree (small
    /// coefficients are found at once), or because the image changed nothing.
    fn add(&mut self, prime: &Modulus, image: &[u64]) -> bool {
        let is_first = self.coefficients.is_empty() || image.len() < self.coefficients.len();
        if is_first {
            // Those before were of a degree too high.
            self.modulus = IBig::ONE;
            self.coefficients = vec![IBig::ZERO; image.len()];
        } else if image.len() > self.coefficients.len() {
            return false;
        }
        let leading = prime.residue(&self.leading);
        let inverse = prime.inverse(prime.residue(&self.modulus));
        let mut is_same = true;
        for (c, i) in self.coefficients.iter_mut().zip(image) {
            let wanted = prime.times(leading, *i);
            let missing = prime.times(prime.minus(wanted, prime.residue(c)), inverse);
            if missing != 0 {
                is_same = false;
                *c += &self.modulus * IBig::from(prime.nearest(missing));
            }
        }
        self.modulus *= IBig::from(prime.modulus);
        is_first || is_same
    }
}

/// The largest primes below 2^63, as what is missing to it: to find one takes ten times as long as its image of a short polynomial.
const BELOW: [u64; 32] = [
    25, 165, 259, 301, 375, 387, 391, 409, 457, 471, 517, 529, 549, 627, 649, 669, 711, 735, 751,
    849, 871, 891, 915, 1011, 1069, 1095, 1129, 1179, 1221, 1237, 1249, 1297,
];

/// The primes from 2^63 downwards.
#[derive(Default)]
struct Primes {
    found: usize,
    last: u64,
}

impl Primes {
    fn next(&mut self) -> Modulus {
        self.last = match BELOW.get(self.found) {
            Some(missing) => (1 << 63) - missing,
            None => prime_below(self.last),
        };
        self.found += 1;
        Modulus::new(self.last)
    }
}

fn prime_below(mut n: u64) -> u64 {
    loop {
        n -= 1;
        if is_prime(n) {
            return n;
        }
    }
}

/// The test of Miller and Rabin, with bases that make it a proof for all `n` below 2^64 (Sorenson and Webster, *Strong
/// pseudoprimes to twelve prime bases*, 2017).
fn is_prime(n: u64) -> bool {
    const BASES: [u64; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
    if let Some(q) = BASES.iter().find(|q| n.is_multiple_of(**q)) {
        return n == *q;
    }
    let m = Modulus::new(n);
    let minus_one = m.minus(0, m.one);
    let twos = (n - 1).trailing_zeros();
    n > 1
        && BASES.iter().all(|q| {
            let mut x = m.power(m.form(*q), (n - 1) >> twos);
            let mut is_passed = x == m.one || x == minus_one;
            for _ in 1..twos {
                x = m.times(x, x);
                is_passed |= x == minus_one;
            }
            is_passed
        })
}

/// An odd number below 2^63, with what arithmetic modulo it takes (Montgomery, *Modular multiplication without trial division*,
/// 1985): the residue of x is held as that of 2^64 x.
struct Modulus {
    modulus: u64,
    /// Of `modulus`, modulo 2^64, negated.
    inverse: u64,
    /// The forms of 1 and of 2^64.
    one: u64,
    shift: u64,
}

impl Modulus {
    fn new(modulus: u64) -> Self {
        // An odd number is its own inverse modulo 8; each of Newton's steps doubles the bits.
        let mut inverse = modulus;
        for _ in 0..5 {
            inverse = inverse.wrapping_mul(2u64.wrapping_sub(modulus.wrapping_mul(inverse)));
        }
        let wide = u128::from(modulus);
        let one = (1 << 64) % wide;
        Self {
            modulus,
            inverse: inverse.wrapping_neg(),
            one: one as u64,
            shift: (one * one % wide) as u64,
        }
    }

    /// `t / 2^64` for `t` below `2^64 modulus`. The multiple that is added makes the sum one of 2^64 and is below the
    /// same bound, so that the sum is below `2^65 modulus`, less than 2^128.
    fn reduce(&self, t: u128) -> u64 {
        let multiple = (t as u64).wrapping_mul(self.inverse);
        let sum = t + u128::from(multiple) * u128::from(self.modulus);
        let half = (sum >> 64) as u64;
        if half >= self.modulus {
            half - self.modulus
        } else {
            half
        }
    }

    fn form(&self, x: u64) -> u64 {
        self.reduce(u128::from(x) * u128::from(self.shift))
    }

    fn times(&self, a: u64, b: u64) -> u64 {
        self.reduce(u128::from(a) * u128::from(b))
    }

    fn minus(&self, a: u64, b: u64) -> u64 {
        if a >= b {
            a - b
        } else {
            a + (self.modulus - b)
        }
    }

    fn power(&self, mut base: u64, mut exponent: u64) -> u64 {
        let mut result = self.one;
        while exponent > 0 {
            if exponent & 1 == 1 {
                result = self.times(result, base);
            }
            base = self.times(base, base);
            exponent >>= 1;
        }
        result
    }

    /// For a prime, of what is not 0: by Fermat's little theorem.
    fn inverse(&self, a: u64) -> u64 {
        self.power(a, self.modulus - 2)
    }

    fn residue(&self, x: &IBig) -> u64 {
        let rest = i64::try_from(x % IBig::from(self.modulus)).unwrap_or(0);
        self.form(rest.rem_euclid(self.modulus as i64) as u64)
    }

    /// The number of least magnitude with a residue.
    fn nearest(&self, residue: u64) -> i64 {
        let x = self.reduce(u128::from(residue)) as i64;
        let modulus = self.modulus as i64;
        if x > modulus / 2 { x - modulus } else { x }
    }

    /// Of the degree of `p`, which is not zero; `None` if its leading coefficient has the residue 0.
    fn image(&self, p: &Polynomial) -> Option<Vec<u64>> {
        let degree = p.coefficients.iter().rposition(|c| *c != IBig::ZERO)?;
        let image: Vec<u64> = p.coefficients[..=degree]
            .iter()
            .map(|c| self.residue(c))
            .collect();
        (image[degree] != 0).then_some(image)
    }

    /// Of the images, monic; `None` if the prime divides a leading coefficient.
    fn common_divisor(&self, f: &Polynomial, g: &Polynomial) -> Option<Vec<u64>> {
        let (mut f, mut g) = (self.image(f)?, self.image(g)?);
        while !g.is_empty() {
            if g.len() == 1 {
                return Some(vec![self.one]);
            }
            self.take_remainder(&mut f, &g);
            std::mem::swap(&mut f, &mut g);
        }
        let inverse = self.inverse(f[f.len() - 1]);
        Some(f.iter().map(|c| self.times(*c, inverse)).collect())
    }

    /// Leaves of `f` its remainder by `g`, up to a factor: dividing by the leading coefficient takes longer.
    fn take_remainder(&self, f: &mut Vec<u64>, g: &[u64]) {
        let (leading, rest) = (g[g.len() - 1], &g[..g.len() - 1]);
        while f.len() >= g.len() {
            let top = self.minus(0, f[f.len() - 1]);
            f.pop();
            let base = f.len() - rest.len();
            let (low, high) = f.split_at_mut(base);
            for c in low {
                *c = self.times(*c, leading);
            }
            for (c, d) in high.iter_mut().zip(rest) {
                // Two products of residues below 2^63 are below 2^64 residues.
                let sum = u128::from(*c) * u128::from(leading) + u128::from(top) * u128::from(*d);
                *c = self.reduce(sum);
            }
            while f.last() == Some(&0) {
                f.pop();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::ops::Neg;

    fn p(c: &[i64]) -> Polynomial {
        Polynomial::new(c.iter().map(|x| IBig::from(*x)).collect())
    }

    /// x - c.
    fn minus(c: &IBig) -> Polynomial {
        Polynomial::new(vec![-c, IBig::ONE])
    }

    fn nth_prime(n: usize) -> IBig {
        let mut primes = Primes::default();
        let all = (0..=n).map(|_| primes.next().modulus);
        IBig::from(all.last().unwrap())
    }

    /// By the primitive remainder sequence (Knuth, TAOCP 2, 4.6.1, algorithm E).
    fn by_remainders(f: &Polynomial, g: &Polynomial) -> Polynomial {
        let (mut f, mut g) = (f.clone().primitive(), g.clone().primitive());
        if f.degree() < g.degree() {
            std::mem::swap(&mut f, &mut g);
        }
        while !g.is_zero() {
            if g.degree() == 0 {
                return p(&[1]);
            }
            let r = pseudo_remainder(&f, &g).primitive();
            f = g;
            g = r;
        }
        f
    }

    fn pseudo_remainder(f: &Polynomial, d: &Polynomial) -> Polynomial {
        let n = d.degree();
        let mut r = f.coefficients.clone();
        while r.len() > n {
            let top = r.pop().unwrap();
            for c in &mut r {
                *c *= &d.coefficients[n];
            }
            let base = r.len() - n;
            for (k, c) in d.coefficients[..n].iter().enumerate() {
                r[base + k] -= c * &top;
            }
        }
        Polynomial::new(r)
    }

    fn negated(f: &Polynomial) -> Polynomial {
        Polynomial::new(f.coefficients.iter().map(Neg::neg).collect())
    }

    fn is_up_to_sign(f: &Polynomial, expected: &Polynomial) -> bool {
        *f == *expected || *f == negated(expected)
    }

    /// Whether the divisor of `common a` and `common b` is `common`, whose content is 1, for coprime `a` and `b`.
    fn is_found(common: &Polynomial, a: &Polynomial, b: &Polynomial) -> bool {
        let (f, g) = (common.times(a), common.times(b));
        is_up_to_sign(&f.gcd(&g), common)
            && is_up_to_sign(&g.gcd(&f), common)
            && is_up_to_sign(&negated(&f).gcd(&g), common)
    }

    /// What takes one prime, a few, and more than the table has.
    fn commons() -> Vec<Polynomial> {
        let large = (IBig::ONE << 300) + IBig::ONE;
        let huge = (IBig::ONE << 5000) - IBig::from(3);
        vec![
            p(&[1]),
            p(&[-3, 2]),
            Polynomial::new(vec![-&large, large.clone(), IBig::from(7)]),
            Polynomial::new(vec![IBig::from(5), large.clone(), -large]),
            Polynomial::new(vec![huge.clone(), IBig::from(-1), huge + IBig::ONE]),
        ]
    }

    #[test]
    fn zero_constants_and_formal_degrees() {
        let (zero, f) = (p(&[0, 0, 0]), p(&[-6, 4, 0, 0]));
        assert_eq!(zero.gcd(&zero), p(&[0]));
        for (f, expected) in [(&f, p(&[-3, 2])), (&p(&[-4]), p(&[-1]))] {
            assert_eq!(zero.gcd(f), expected);
            assert_eq!(f.gcd(&zero), expected);
        }
        assert_eq!(f.gcd(&p(&[12])), p(&[1]));
        assert_eq!(p(&[-4]).gcd(&p(&[12])), p(&[1]));
        assert!(is_up_to_sign(&f.gcd(&f), &p(&[-3, 2])));
        assert!(is_up_to_sign(&f.gcd(&p(&[0, -3, 2, 0])), &p(&[-3, 2])));
    }

    #[test]
    fn contents_and_leading_coefficients_that_primes_divide() {
        let (first, second) = (nth_prime(0), nth_prime(1));
        let both = &first * &second;
        for common in commons() {
            for leading in [&first, &second, &both] {
                let (a, b) = (
                    p(&[1, 2]),
                    Polynomial::new(vec![IBig::ONE, leading.clone()]),
                );
                assert!(is_found(&common, &a, &b));
                // A content, on either side and on both.
                let scaled = |f: &Polynomial| f.times(&Polynomial::new(vec![leading.clone()]));
                assert!(is_found(&common, &scaled(&a), &b));
                assert!(is_found(&common, &a, &scaled(&b)));
                assert!(is_found(&common, &scaled(&a), &scaled(&b)));
                // The common divisor's own.
                assert!(is_found(&b.times(&common), &a, &p(&[1, 1])));
            }
        }
    }

    /// Where f / h and g / h are the same modulo primes, the divisor of the images has too high a degree: for the first primes, for some
    /// in the middle, for all of the table.
    #[test]
    fn resultants_that_primes_divide() {
        let product = |n: std::ops::Range<usize>| n.map(nth_prime).product::<IBig>();
        let one = IBig::ONE;
        for common in commons() {
            for primes in [0..1, 0..2, 0..5, 1..2, 1..4, 4..7, 0..BELOW.len() + 2] {
                let apart = product(primes);
                assert!(is_found(&common, &minus(&one), &minus(&(&one + &apart))));
                // Two roots too many modulo the first prime, one modulo the others.
                let two = minus(&one).times(&minus(&IBig::from(-5)));
                let near = minus(&(&one + &apart)).times(&minus(&(nth_prime(0) - IBig::from(5))));
                assert!(is_found(&common, &two, &near));
            }
        }
    }

    /// Of coefficients for which remainders take seconds: a and a q + 1 are coprime.
    #[test]
    fn many_long_coefficients() {
        let mut state = IBig::from(3);
        let mut next = |bits: usize| {
            state = (&state * &state + IBig::from(12_345)) % ((IBig::ONE << bits) - IBig::ONE);
            &state - (IBig::ONE << (bits - 1))
        };
        let mut polynomial =
            |degree: usize| Polynomial::new((0..=degree).map(|_| next(2000)).collect());
        let common = polynomial(10).primitive();
        let (a, q) = (polynomial(19), polynomial(1));
        let mut b = a.times(&q);
        b.coefficients[0] += IBig::ONE;
        assert!(is_found(&common, &a, &b));
    }

    #[test]
    fn primes_are_those_that_there_are() {
        let by_division = |n: u64| {
            n > 1
                && (2..n)
                    .take_while(|d| d * d <= n)
                    .all(|d| !n.is_multiple_of(d))
        };
        for n in 0..3000 {
            assert_eq!(is_prime(n), by_division(n), "{n}");
        }
        // Three factors each, which the bases up to 7 and up to 23 do not tell from a prime (Jaeschke 1993).
        assert!(!is_prime(3_215_031_751) && !is_prime(3_825_123_056_546_413_051));
        // Mersenne's.
        assert!(is_prime((1 << 61) - 1) && !is_prime((1 << 59) - 1));
        let mut primes = Primes::default();
        let mut last = 1 << 63;
        for _ in 0..BELOW.len() + 3 {
            last = prime_below(last);
            assert_eq!(primes.next().modulus, last);
        }
    }

    /// Zero, small ones of both signs, long ones, and multiples of the primes that come first.
    fn coefficient() -> impl Strategy<Value = IBig> {
        prop_oneof![
            4 => (-3i64..=3).prop_map(IBig::from),
            2 => any::<i64>().prop_map(IBig::from),
            2 => (any::<i64>(), any::<i64>(), 0usize..300)
                .prop_map(|(a, b, k)| (IBig::from(a) << k) + IBig::from(b)),
            1 => (-2i64..=2, 0usize..3).prop_map(|(k, n)| nth_prime(n) * IBig::from(k)),
        ]
    }

    fn polynomial(degree: usize) -> impl Strategy<Value = Polynomial> {
        prop::collection::vec(coefficient(), 1..=degree + 1).prop_map(Polynomial::new)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn the_same_as_by_remainders(a in polynomial(5), b in polynomial(5), common in polynomial(4)) {
            let (f, g) = (a.times(&common), b.times(&common));
            for (f, g) in [(&f, &g), (&a, &b), (&f, &common), (&f, &f)] {
                prop_assert!(is_up_to_sign(&f.gcd(g), &by_remainders(f, g)));
            }
        }

        #[test]
        fn arithmetic_modulo(modulus in 1u64..1 << 62, a in any::<u64>(), b in any::<u64>(), k in 0usize..200) {
            let m = Modulus::new(2 * modulus + 1);
            let n = m.modulus;
            let (a, b) = (a % n, b % n);
            let wide = |x: u64| u128::from(x);
            let product = (wide(a) * wide(b) % wide(n)) as u64;
            prop_assert_eq!(m.times(m.form(a), m.form(b)), m.form(product));
            prop_assert_eq!(m.minus(m.form(a), m.form(b)), m.form(((wide(a) + wide(n - b)) % wide(n)) as u64));
            prop_assert_eq!(m.power(m.form(a), 3), m.times(m.form(a), m.times(m.form(a), m.form(a))));
            let nearest = m.nearest(m.form(a));
            prop_assert_eq!(nearest.rem_euclid(n as i64) as u64, a);
            prop_assert!(nearest.unsigned_abs() <= n / 2);
            let x = (IBig::from(a) << k) - IBig::from(b);
            let rest = (&x - IBig::from(m.nearest(m.residue(&x)))) % IBig::from(n);
            prop_assert_eq!(rest, IBig::ZERO);
        }
    }
}
