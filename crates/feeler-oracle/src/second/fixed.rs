//! Intervals of fixed-point numbers of any precision, with square root, arc tangent, sine and cosine by series.
//!
//! An interval is `[lo, hi] / 2^bits`; every operation rounds its ends outward. Series are alternating with terms that
//! decrease, so that what is left out is at most the first term left out.

use super::fraction::Fraction;
use super::rational::sign;
use dashu_int::ops::SquareRoot;
use dashu_int::{IBig, UBig};

/// `[lo, hi] / 2^bits`.
#[derive(Clone, Debug)]
pub(crate) struct Fixed {
    lo: IBig,
    hi: IBig,
    bits: usize,
}

/// The quotient rounded down; the divisor is positive.
fn div_floor(n: &IBig, d: &IBig) -> IBig {
    let q = n / d;
    if sign(n) < 0 && &q * d != *n {
        q - IBig::ONE
    } else {
        q
    }
}

fn div_ceil(n: &IBig, d: &IBig) -> IBig {
    -div_floor(&-n, d)
}

fn shift_ceil(n: IBig, bits: usize) -> IBig {
    // Shifts of integers here are toward minus infinity.
    -((-n) >> bits)
}

impl Fixed {
    pub(crate) fn new(x: &Fraction, bits: usize) -> Self {
        let n = x.numerator() << bits;
        let d = IBig::from(x.denominator().clone());
        Self {
            lo: div_floor(&n, &d),
            hi: div_ceil(&n, &d),
            bits,
        }
    }

    pub(crate) fn integer(n: i64, bits: usize) -> Self {
        let x = IBig::from(n) << bits;
        Self {
            lo: x.clone(),
            hi: x,
            bits,
        }
    }

    pub(crate) fn lo(&self) -> Fraction {
        Fraction::from_parts(self.lo.clone(), UBig::ONE << self.bits)
    }

    pub(crate) fn hi(&self) -> Fraction {
        Fraction::from_parts(self.hi.clone(), UBig::ONE << self.bits)
    }

    /// -1, 1; 0 where it is not known.
    pub(crate) fn sign(&self) -> i32 {
        match (sign(&self.lo), sign(&self.hi)) {
            (1, _) => 1,
            (_, -1) => -1,
            _ => 0,
        }
    }

    pub(crate) fn add(&self, o: &Self) -> Self {
        Self {
            lo: &self.lo + &o.lo,
            hi: &self.hi + &o.hi,
            bits: self.bits,
        }
    }

    pub(crate) fn neg(&self) -> Self {
        Self {
            lo: -&self.hi,
            hi: -&self.lo,
            bits: self.bits,
        }
    }

    pub(crate) fn sub(&self, o: &Self) -> Self {
        self.add(&o.neg())
    }

    pub(crate) fn mul(&self, o: &Self) -> Self {
        let all = [
            &self.lo * &o.lo,
            &self.lo * &o.hi,
            &self.hi * &o.lo,
            &self.hi * &o.hi,
        ];
        let lo = all.iter().min().cloned().unwrap_or(IBig::ZERO);
        let hi = all.iter().max().cloned().unwrap_or(IBig::ZERO);
        Self {
            lo: lo >> self.bits,
            hi: shift_ceil(hi, self.bits),
            bits: self.bits,
        }
    }

    pub(crate) fn times(&self, n: i64) -> Self {
        let (a, b) = (&self.lo * IBig::from(n), &self.hi * IBig::from(n));
        let (lo, hi) = if n >= 0 { (a, b) } else { (b, a) };
        Self {
            lo,
            hi,
            bits: self.bits,
        }
    }

    /// By a positive integer.
    pub(crate) fn over(&self, n: i64) -> Self {
        let n = IBig::from(n);
        Self {
            lo: div_floor(&self.lo, &n),
            hi: div_ceil(&self.hi, &n),
            bits: self.bits,
        }
    }

    /// `None` where the divisor may be 0.
    pub(crate) fn div(&self, o: &Self) -> Option<Self> {
        if o.sign() < 0 {
            return self.neg().div(&o.neg());
        }
        if o.sign() == 0 {
            return None;
        }
        let (lo, hi) = (&self.lo << self.bits, &self.hi << self.bits);
        Some(Self {
            lo: div_floor(&lo, if sign(&lo) >= 0 { &o.hi } else { &o.lo }),
            hi: div_ceil(&hi, if sign(&hi) >= 0 { &o.lo } else { &o.hi }),
            bits: self.bits,
        })
    }

    /// Of what is not negative in it.
    pub(crate) fn sqrt(&self) -> Self {
        let root = |x: &IBig| {
            let x = UBig::try_from(x << self.bits).unwrap_or(UBig::ZERO);
            IBig::from(x.sqrt())
        };
        Self {
            lo: root(&self.lo),
            hi: root(&self.hi) + IBig::ONE,
            bits: self.bits,
        }
    }

    fn one(&self) -> Self {
        Self::integer(1, self.bits)
    }

    /// Holds the interval widened by another's largest magnitude.
    fn widened(&self, o: &Self) -> Self {
        let r = (-&o.lo).max(o.hi.clone()).max(IBig::ZERO);
        Self {
            lo: &self.lo - &r,
            hi: &self.hi + &r,
            bits: self.bits,
        }
    }

    /// Whether every number of it is below 2^-bits.
    fn is_negligible(&self) -> bool {
        self.lo >= -IBig::ONE && self.hi <= IBig::ONE
    }

    /// Of an argument of about [-1, 1]: `atan x = 2 atan(x / (1 + sqrt(1 + x^2)))`, and the series.
    fn atan(&self) -> Option<Self> {
        const HALVINGS: usize = 4;
        let mut x = self.clone();
        for _ in 0..HALVINGS {
            let root = x.mul(&x).add(&x.one()).sqrt();
            x = x.div(&root.add(&x.one()))?;
        }
        let square = x.mul(&x);
        let mut power = x.clone();
        let mut sum = x;
        let mut n = 1;
        loop {
            power = power.mul(&square).neg();
            n += 2;
            let term = power.over(n);
            if term.is_negligible() {
                return Some(sum.widened(&term).times(1 << HALVINGS));
            }
            sum = sum.add(&term);
        }
    }

    /// J. Machin's formula.
    pub(crate) fn pi(bits: usize) -> Self {
        let inverse = |n: i64| {
            let mut power = Self::integer(1, bits).over(n);
            let mut sum = power.clone();
            let mut k = 1;
            loop {
                power = power.over(n * n).neg();
                k += 2;
                let term = power.over(k);
                if term.is_negligible() {
                    return sum.widened(&term);
                }
                sum = sum.add(&term);
            }
        };
        inverse(5).times(16).sub(&inverse(239).times(4))
    }

    /// An angle of the direction (x, y), up to whole turns; `None` where x and y may both be 0.
    pub(crate) fn angle(x: &Self, y: &Self) -> Option<Self> {
        let size = |f: &Self| (-&f.lo).max(f.hi.clone());
        if size(y) <= size(x) {
            let a = y.div(x)?.atan()?;
            Some(if x.sign() < 0 {
                a.add(&Self::pi(x.bits))
            } else {
                a
            })
        } else {
            let a = x.div(y)?.atan()?;
            let quarter = Self::pi(x.bits).over(2);
            Some(if y.sign() > 0 {
                quarter.sub(&a)
            } else {
                quarter.neg().sub(&a)
            })
        }
    }

    /// `(cos a, sin a)` of an exact angle: turns are taken off, the rest halved for the series of
    /// `e^(ia)`, then squared as often.
    pub(crate) fn direction(angle: &Fraction, bits: usize) -> (Self, Self) {
        const HALVINGS: usize = 8;
        // What squaring and the turns lose.
        let fine = bits + 2 * HALVINGS + 64;
        let pi = Self::pi(fine);
        let a = Self::new(angle, fine);
        let turns = (&a.lo / (&pi.lo << 1))
            .to_string()
            .parse::<i64>()
            .unwrap_or(0);
        let a = a.sub(&pi.times(2 * turns)).over(1 << HALVINGS);
        let square = a.mul(&a);
        let (mut cos, mut sin) = (a.one(), a.clone());
        let (mut c, mut s) = (a.one(), a);
        let mut n = 1;
        loop {
            c = c.mul(&square).over(n * (n + 1)).neg();
            s = s.mul(&square).over((n + 1) * (n + 2)).neg();
            n += 2;
            if c.is_negligible() && s.is_negligible() {
                cos = cos.widened(&c);
                sin = sin.widened(&s);
                break;
            }
            cos = cos.add(&c);
            sin = sin.add(&s);
        }
        for _ in 0..HALVINGS {
            let both = cos.mul(&sin);
            cos = cos.mul(&cos).sub(&sin.mul(&sin));
            sin = both.times(2);
        }
        (cos.cut(bits), sin.cut(bits))
    }

    fn cut(&self, bits: usize) -> Self {
        let by = self.bits - bits;
        Self {
            lo: &self.lo >> by,
            hi: shift_ceil(self.hi.clone(), by),
            bits,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn r(x: f64) -> Fraction {
        super::super::rational::rational(x).unwrap()
    }

    fn holds(f: &Fixed, x: f64) -> bool {
        // As good as f64 tells.
        let tolerance = r(1e-15 * x.abs().max(1.0));
        f.hi() - f.lo() < r(1e-50) && f.lo() - &tolerance < r(x) && r(x) < f.hi() + &tolerance
    }

    #[test]
    fn series_agree_with_f64() {
        let pi = Fixed::pi(256);
        assert!(holds(&pi, std::f64::consts::PI));
        // 40 digits of pi.
        let digits: IBig = "31415926535897932384626433832795028841971".parse().unwrap();
        let near = Fraction::from_parts(digits, UBig::from(10u8).pow(40));
        assert!(near <= pi.lo() && pi.hi() < &near + r(1e-39));
        for x in [0.0, 0.1, -0.7, 3.0, -2.0, 1e-9, 100.0, -1e6, 1e9] {
            let (c, s) = Fixed::direction(&r(x), 256);
            assert!(holds(&c, x.cos()) && holds(&s, x.sin()), "{x}");
            let one = c.mul(&c).add(&s.mul(&s));
            assert!(one.lo() <= Fraction::ONE && Fraction::ONE <= one.hi());
            // And back, up to turns.
            let back = Fixed::angle(&c, &s).unwrap();
            let (c2, s2) = Fixed::direction(&back.lo(), 256);
            let off = c2
                .sub(&c)
                .mul(&c2.sub(&c))
                .add(&s2.sub(&s).mul(&s2.sub(&s)));
            // Squares are rounded at 2^-256.
            assert!(off.hi() < r(1e-70), "{x}");
        }
        assert!(holds(&Fixed::new(&r(2.0), 256).sqrt(), 2f64.sqrt()));
    }
}
