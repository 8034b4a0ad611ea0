//! Intervals in which the second methods calculate: of f64, and of 256-bit numbers.
//!
//! Both satisfy [`Number`]: every operation encloses the exact result for all arguments in the operands.
//! Operations whose exact result is representable give it exactly, so that what is constant stays a point.

use dashu_int::ops::{BitTest, SquareRoot};
use dashu_int::{IBig, Sign, UBig};
use feeler::numeric::Dyadic;
use std::fmt::Debug;

/// A set of reals that encloses a number.
pub trait Number: Clone + Debug {
    /// The number itself. `x` must be finite.
    fn exact(x: f64) -> Self;
    /// The enclosure of what the ball holds.
    fn of(ball: &Ball) -> Self;
    /// A ball that holds it.
    fn ball(&self) -> Ball;
    /// Sum.
    fn plus(&self, other: &Self) -> Self;
    /// Difference.
    fn minus(&self, other: &Self) -> Self;
    /// Product.
    fn times(&self, other: &Self) -> Self;
    /// Quotient; `None` where the divisor may be 0.
    fn over(&self, other: &Self) -> Option<Self>;
    /// The negative.
    fn negated(&self) -> Self;
    /// The square.
    fn squared(&self) -> Self;
    /// The square root of what is not negative in it.
    fn root(&self) -> Self;
    /// Holds both.
    fn hull(&self, other: &Self) -> Self;
    /// Holds what both hold (perhaps more); `None` only where they are disjoint.
    fn meet(&self, other: &Self) -> Option<Self>;
    /// Lower end as f64, rounded down.
    fn lo(&self) -> f64;
    /// Upper end as f64, rounded up.
    fn hi(&self) -> f64;
    /// The lower end as a point (rounded down).
    fn lower(&self) -> Self;
    /// The upper end as a point (rounded up).
    fn upper(&self) -> Self;
    /// A point in it, about the middle.
    fn middle(&self) -> Self;
    /// No point of it is farther from [`middle`](Self::middle).
    fn radius(&self) -> f64;
    /// Larger by `r` on both sides.
    fn widened(&self, r: f64) -> Self;
    /// Whether every number of `self` is less than every one of `other`, as proven.
    fn below(&self, other: &Self) -> bool;
    /// How often an angle is halved before its series: accuracy against cost.
    const HALVINGS: u32;
    /// Relative rounding error, about.
    const UNIT: f64;
    /// Intervals of parameters are not halved below this.
    const SMALL: f64;

    /// Zero.
    fn zero() -> Self {
        Self::exact(0.0)
    }
    /// Whether it is proven to be above 0.
    fn is_positive(&self) -> bool {
        Self::zero().below(self)
    }
    /// Whether it is proven to be below 0.
    fn is_negative(&self) -> bool {
        self.below(&Self::zero())
    }
    /// Whether it may be 0.
    fn may_be_zero(&self) -> bool {
        !self.is_positive() && !self.is_negative()
    }
    /// The largest magnitude, rounded up.
    fn magnitude(&self) -> f64 {
        self.hi().max(-self.lo())
    }
    /// `[-r, r]`.
    fn about_zero(r: f64) -> Self {
        Self::zero().widened(r)
    }
}

/// `(sin a, cos a)`: the series of the angle halved several times, then doubled again with
/// `cos 2a - 1 = 2 (cos a - 1) cos a + 2 (cos a - 1)`, in which nothing cancels.
///
/// For a wide argument: the values at its middle, and `|sin'|, |cos'| <= 1`, both met with `[-1, 1]`.
pub fn sin_cos<N: Number>(angle: &N) -> (N, N) {
    let middle = angle.middle();
    // Halve until the angle is below 2^-HALVINGS.
    let mut halvings = 0;
    let mut a = middle.clone();
    let half = N::exact(0.5);
    let limit = (-f64::from(N::HALVINGS)).exp2();
    while a.magnitude() > limit && halvings < 400 {
        a = a.times(&half);
        halvings += 1;
    }
    let square = a.squared();
    // s = sum (-1)^k a^(2k+1) / (2k+1)!,  m = cos a - 1 = sum_{k>=1} (-1)^k a^2k / (2k)!
    let (mut s, mut m) = (N::zero(), N::zero());
    let mut term = a;
    let mut n = 1.0;
    loop {
        s = s.plus(&term);
        let next = |t: &N, n: f64| t.over(&N::exact(n)).unwrap_or_else(N::zero);
        if n > 200.0 || term.magnitude() < 1e-90 {
            break;
        }
        term = next(&term.times(&square).negated(), (n + 1.0) * (n + 2.0));
        n += 2.0;
    }
    // The series alternates with terms that fall: the rest is at most the last term.
    s = s.widened(term.magnitude());
    let mut term = next_cosine(&N::exact(1.0), &square, 0.0);
    let mut n = 2.0;
    loop {
        m = m.plus(&term);
        if n > 200.0 || term.magnitude() < 1e-90 {
            break;
        }
        term = next_cosine(&term, &square, n);
        n += 2.0;
    }
    m = m.widened(term.magnitude());
    let two = N::exact(2.0);
    for _ in 0..halvings {
        // sin 2a = 2 sin a (1 + m); cos 2a - 1 = -2 sin^2 a.
        let sine = two.times(&s).times(&m.plus(&N::exact(1.0)));
        m = two.times(&s.squared()).negated();
        s = sine;
    }
    let c = m.plus(&N::exact(1.0));
    let r = angle.radius();
    if r == 0.0 {
        return (s, c);
    }
    // sin(a + x) = sin a + x cos a - x^2/2 [..]: first order with a remainder, or first order alone.
    let x = N::about_zero(r);
    let rest = N::about_zero((0.5 * r * r).next_up());
    let unit = N::about_zero(1.0);
    let wide = |value: &N, slope: &N| {
        let all = value.plus(&x.times(slope)).plus(&rest);
        let all = all.meet(&value.widened(r)).unwrap_or(all);
        all.meet(&unit).unwrap_or(all)
    };
    (wide(&s, &c), wide(&c, &s.negated()))
}

fn next_cosine<N: Number>(term: &N, square: &N, n: f64) -> N {
    term.times(square)
        .negated()
        .over(&N::exact((n + 1.0) * (n + 2.0)))
        .unwrap_or_else(N::zero)
}

/// A closed interval of f64. An end may be infinite: nothing is known on that side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval64 {
    lo: f64,
    hi: f64,
}

/// Below this the error of a product may underflow, and is not computed.
const SMALL_PRODUCT: f64 = 1e-250;

/// `exact - rounded` has this sign; rounds down.
fn down(x: f64, error: f64) -> f64 {
    if error < 0.0 || error.is_nan() {
        x.next_down()
    } else {
        x
    }
}

fn up(x: f64, error: f64) -> f64 {
    if error > 0.0 || error.is_nan() {
        x.next_up()
    } else {
        x
    }
}

/// The rounded sum and its exact error (Knuth).
fn sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let t = s - a;
    (s, (a - (s - t)) + (b - t))
}

/// The product rounded down and up.
fn product(a: f64, b: f64) -> (f64, f64) {
    if a == 0.0 || b == 0.0 {
        return (0.0, 0.0);
    }
    let p = a * b;
    if p.abs() < SMALL_PRODUCT || !p.is_finite() {
        return (p.next_down(), p.next_up());
    }
    let error = a.mul_add(b, -p);
    (down(p, error), up(p, error))
}

fn quotient(a: f64, b: f64) -> (f64, f64) {
    if a == 0.0 {
        return (0.0, 0.0);
    }
    let q = a / b;
    if q.abs() < SMALL_PRODUCT || a.abs() < SMALL_PRODUCT || !q.is_finite() {
        return (q.next_down(), q.next_up());
    }
    // a - q b, exactly; its sign over that of b is that of the error.
    let rest = (-q).mul_add(b, a);
    let error = if b < 0.0 { -rest } else { rest };
    (down(q, error), up(q, error))
}

impl Interval64 {
    /// `[lo, hi]`; all reals if that is no interval.
    pub fn new(lo: f64, hi: f64) -> Self {
        if lo <= hi {
            Self { lo, hi }
        } else {
            Self {
                lo: f64::NEG_INFINITY,
                hi: f64::INFINITY,
            }
        }
    }
}

impl Number for Interval64 {
    const HALVINGS: u32 = 1;
    const UNIT: f64 = f64::EPSILON;
    const SMALL: f64 = 1e-17;

    fn exact(x: f64) -> Self {
        Self::new(x, x)
    }
    fn of(ball: &Ball) -> Self {
        Self::new(ball.lo(), ball.hi())
    }
    fn ball(&self) -> Ball {
        if !self.lo.is_finite() || !self.hi.is_finite() {
            return Ball::exact(0.0).widened(f64::INFINITY);
        }
        let (m, r) = (self.middle(), self.radius());
        Ball::exact(m.lo).widened(r)
    }
    fn plus(&self, other: &Self) -> Self {
        let (lo, e) = sum(self.lo, other.lo);
        let (hi, f) = sum(self.hi, other.hi);
        Self::new(down(lo, e), up(hi, f))
    }
    fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negated())
    }
    fn times(&self, other: &Self) -> Self {
        if self.lo == self.hi && other.lo == other.hi {
            let (lo, hi) = product(self.lo, other.lo);
            return Self::new(lo, hi);
        }
        let all = [
            product(self.lo, other.lo),
            product(self.lo, other.hi),
            product(self.hi, other.lo),
            product(self.hi, other.hi),
        ];
        let lo = all.iter().fold(f64::INFINITY, |m, p| m.min(p.0));
        let hi = all.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p.1));
        if all.iter().any(|p| p.0.is_nan() || p.1.is_nan()) {
            return Self::new(f64::NAN, f64::NAN);
        }
        Self::new(lo, hi)
    }
    fn over(&self, other: &Self) -> Option<Self> {
        if other.lo <= 0.0 && other.hi >= 0.0 {
            return None;
        }
        let all = [
            quotient(self.lo, other.lo),
            quotient(self.lo, other.hi),
            quotient(self.hi, other.lo),
            quotient(self.hi, other.hi),
        ];
        let lo = all.iter().fold(f64::INFINITY, |m, p| m.min(p.0));
        let hi = all.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p.1));
        if all.iter().any(|p| p.0.is_nan() || p.1.is_nan()) {
            return Some(Self::new(f64::NAN, f64::NAN));
        }
        Some(Self::new(lo, hi))
    }
    fn negated(&self) -> Self {
        Self {
            lo: -self.hi,
            hi: -self.lo,
        }
    }
    fn squared(&self) -> Self {
        let (a, b) = (self.lo.abs(), self.hi.abs());
        let high = a.max(b);
        let low = if self.lo <= 0.0 && self.hi >= 0.0 {
            0.0
        } else {
            a.min(b)
        };
        Self::new(product(low, low).0.max(0.0), product(high, high).1)
    }
    fn root(&self) -> Self {
        // IEEE square roots are correctly rounded.
        let low = if self.lo > 0.0 {
            self.lo.sqrt().next_down().max(0.0)
        } else {
            0.0
        };
        let high = if self.hi > 0.0 {
            self.hi.sqrt().next_up()
        } else {
            0.0
        };
        Self::new(low, high)
    }
    fn hull(&self, other: &Self) -> Self {
        Self::new(self.lo.min(other.lo), self.hi.max(other.hi))
    }
    fn meet(&self, other: &Self) -> Option<Self> {
        let (lo, hi) = (self.lo.max(other.lo), self.hi.min(other.hi));
        (lo <= hi).then_some(Self { lo, hi })
    }
    fn lo(&self) -> f64 {
        self.lo
    }
    fn hi(&self) -> f64 {
        self.hi
    }
    fn lower(&self) -> Self {
        Self {
            lo: self.lo,
            hi: self.lo,
        }
    }
    fn upper(&self) -> Self {
        Self {
            lo: self.hi,
            hi: self.hi,
        }
    }
    fn middle(&self) -> Self {
        let m = (0.5 * self.lo + 0.5 * self.hi).clamp(self.lo, self.hi);
        if m.is_finite() {
            Self::new(m, m)
        } else {
            Self::exact(0.0)
        }
    }
    fn radius(&self) -> f64 {
        let m = self.middle().lo;
        let (a, e) = sum(self.hi, -m);
        let (b, f) = sum(m, -self.lo);
        up(a, e).max(up(b, f))
    }
    fn widened(&self, r: f64) -> Self {
        self.plus(&Self::new(-r, r))
    }
    fn below(&self, other: &Self) -> bool {
        self.hi < other.lo
    }
}

/// A ball: a dyadic middle of at most [`Ball::BITS`] bits, and a radius.
#[derive(Clone, Debug)]
pub struct Ball {
    mantissa: IBig,
    exponent: i64,
    radius: f64,
}

fn add_up(a: f64, b: f64) -> f64 {
    if a == 0.0 {
        b
    } else if b == 0.0 {
        a
    } else {
        (a + b).next_up()
    }
}

fn mul_up(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 {
        0.0
    } else {
        (a * b).next_up()
    }
}

/// 2^e rounded up; infinite above the range, the least positive number below it.
fn power(e: i64) -> f64 {
    if e > 1023 {
        f64::INFINITY
    } else if e < -1022 {
        f64::MIN_POSITIVE
    } else {
        f64::from_bits(((e + 1023) as u64) << 52)
    }
}

/// `m 2^e` as f64, toward zero: the largest f64 not above it for `m >= 0`; too large a magnitude: the
/// largest f64.
fn truncated(m: &IBig, e: i64) -> (f64, bool) {
    let bits = m.bit_len() as i64;
    if bits == 0 {
        return (0.0, true);
    }
    let cut = (bits - 53).max(0);
    let negative = m.sign() == Sign::Negative;
    // Magnitude first: shifting a negative number rounds down.
    let magnitude: UBig = m.clone().unsigned_abs();
    let top = &magnitude >> cut as usize;
    let mut exact = cut == 0 || magnitude.trailing_zeros().unwrap_or(0) as i64 >= cut;
    let Ok(top) = u64::try_from(top) else {
        return (f64::NAN, false);
    };
    let exponent = e + cut;
    let (mut value, scaled) = (top as f64, exponent + 53);
    if scaled > 1023 {
        return (if negative { -f64::MAX } else { f64::MAX }, false);
    }
    if scaled < -960 {
        // Near or below the subnormal range.
        value = 0.0;
        exact = false;
    } else if exponent < -1022 {
        value *= power(-500);
        value *= power(exponent + 500);
    } else {
        value *= power(exponent);
    }
    (if negative { -value } else { value }, exact)
}

trait Magnitude {
    fn unsigned_abs(self) -> UBig;
}

impl Magnitude for IBig {
    fn unsigned_abs(self) -> UBig {
        self.into_parts().1
    }
}

impl Ball {
    /// Bits of the middle.
    pub const BITS: i64 = 256;

    /// The middle, exactly.
    pub fn center(&self) -> Dyadic {
        Dyadic::new(self.mantissa.clone(), self.exponent)
    }

    /// The ball about a dyadic number.
    pub fn dyadic(d: &Dyadic) -> Self {
        Self::rounded(d.mantissa().clone(), d.exponent(), 0.0)
    }

    /// Ends, exactly.
    pub fn ends(&self) -> Option<(Dyadic, Dyadic)> {
        let r = Dyadic::from_f64(self.radius)?;
        Some((&self.center() - &r, &self.center() + &r))
    }

    /// Whether it is a single number.
    pub fn is_point(&self) -> bool {
        self.radius == 0.0
    }

    /// Whether `x` is in it.
    pub fn holds(&self, x: &Dyadic) -> bool {
        self.ends().is_none_or(|(lo, hi)| lo <= *x && *x <= hi)
    }

    /// Cuts the middle to its bits, and adds what that takes to the radius.
    fn rounded(mantissa: IBig, exponent: i64, radius: f64) -> Self {
        let excess = mantissa.bit_len() as i64 - Self::BITS;
        if excess <= 0 {
            return Self {
                mantissa,
                exponent,
                radius,
            };
        }
        let zeros = mantissa.trailing_zeros().unwrap_or(0) as i64;
        let error = if zeros >= excess {
            0.0
        } else {
            power(exponent + excess)
        };
        Self {
            mantissa: mantissa >> excess as usize,
            exponent: exponent + excess,
            radius: add_up(radius, error),
        }
    }

    fn size(&self) -> f64 {
        let (value, exact) = truncated(&self.mantissa, self.exponent);
        if exact {
            value.abs()
        } else {
            value.abs().next_up()
        }
    }

    /// The sign of the middle.
    fn sign(&self) -> i32 {
        if self.mantissa == IBig::ZERO {
            0
        } else if self.mantissa.sign() == Sign::Negative {
            -1
        } else {
            1
        }
    }

    /// Not farther from zero than the middle.
    fn size_below(&self) -> f64 {
        truncated(&self.mantissa, self.exponent).0.abs()
    }
}

impl Number for Ball {
    const HALVINGS: u32 = 12;
    const UNIT: f64 = 1e-76;
    const SMALL: f64 = 1e-90;

    fn exact(x: f64) -> Self {
        match Dyadic::from_f64(x) {
            Some(d) => Self {
                mantissa: d.mantissa().clone(),
                exponent: d.exponent(),
                radius: 0.0,
            },
            None => Self {
                mantissa: IBig::ZERO,
                exponent: 0,
                radius: f64::INFINITY,
            },
        }
    }
    fn of(ball: &Ball) -> Self {
        ball.clone()
    }
    fn ball(&self) -> Ball {
        self.clone()
    }
    fn plus(&self, other: &Self) -> Self {
        let radius = add_up(self.radius, other.radius);
        if self.mantissa == IBig::ZERO {
            return Self {
                radius,
                ..other.clone()
            };
        }
        if other.mantissa == IBig::ZERO {
            return Self {
                radius,
                ..self.clone()
            };
        }
        let (high, low) = if self.exponent >= other.exponent {
            (self, other)
        } else {
            (other, self)
        };
        let shift = high.exponent - low.exponent;
        if shift > 3 * Self::BITS && low.mantissa.bit_len() as i64 + 2 * Self::BITS < shift {
            // Far below the last bit.
            return Self {
                radius: add_up(radius, low.size()),
                ..high.clone()
            };
        }
        let mantissa = (high.mantissa.clone() << shift as usize) + &low.mantissa;
        Self::rounded(mantissa, low.exponent, radius)
    }
    fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negated())
    }
    fn times(&self, other: &Self) -> Self {
        let mut radius = 0.0;
        if self.radius != 0.0 || other.radius != 0.0 {
            radius = add_up(
                mul_up(self.radius, add_up(other.size(), other.radius)),
                mul_up(self.size(), other.radius),
            );
        }
        Self::rounded(
            &self.mantissa * &other.mantissa,
            self.exponent + other.exponent,
            radius,
        )
    }
    fn over(&self, other: &Self) -> Option<Self> {
        let least = (other.size_below() - other.radius).next_down();
        if !(least > 0.0) {
            return None;
        }
        if self.mantissa == IBig::ZERO && self.radius == 0.0 {
            return Some(self.clone());
        }
        // |a/b - A/B| <= (ra + |A/B| rb) / (|B| - rb).
        let shift = (Self::BITS + 2 + other.mantissa.bit_len() as i64
            - self.mantissa.bit_len() as i64)
            .max(0);
        let scaled = self.mantissa.clone() << shift as usize;
        let mantissa = &scaled / &other.mantissa;
        let exact = &mantissa * &other.mantissa == scaled;
        let exponent = self.exponent - shift - other.exponent;
        let mut quotient = Self {
            mantissa,
            exponent,
            radius: 0.0,
        };
        let carried = add_up(self.radius, mul_up(quotient.size(), other.radius));
        let carried = if carried == 0.0 {
            0.0
        } else {
            (carried / least).next_up()
        };
        // Cutting the quotient of integers toward zero.
        let cut = if exact { 0.0 } else { power(exponent) };
        // The bound above has |A/B|, and size() is of the cut one.
        let more = if carried == 0.0 || exact {
            0.0
        } else {
            mul_up(cut, (other.radius / least).next_up())
        };
        quotient.radius = add_up(add_up(carried, cut), more);
        Some(Self::rounded(
            quotient.mantissa,
            quotient.exponent,
            quotient.radius,
        ))
    }
    fn negated(&self) -> Self {
        Self {
            mantissa: -self.mantissa.clone(),
            exponent: self.exponent,
            radius: self.radius,
        }
    }
    fn squared(&self) -> Self {
        let all = self.times(self);
        // A square is not negative.
        if all.lo() < 0.0 && all.radius > 0.0 {
            let top = all.upper();
            let half = top.times(&Self::exact(0.5));
            let r = half.size();
            return Self { radius: r, ..half };
        }
        all
    }
    fn root(&self) -> Self {
        let top = self.upper();
        if top.sign() <= 0 {
            return Self::exact(0.0);
        }
        let bottom = self.lower();
        let one = |b: &Self| -> (UBig, i64) {
            // mantissa 2^e with even e and about twice the bits.
            let bits = b.mantissa.bit_len() as i64;
            let mut shift = (2 * (Self::BITS + 2) - bits).max(0);
            if (b.exponent - shift).rem_euclid(2) == 1 {
                shift += 1;
            }
            let m = (b.mantissa.clone() << shift as usize).unsigned_abs();
            (m.sqrt(), (b.exponent - shift).div_euclid(2))
        };
        let (high, high_exponent) = one(&top);
        let high = Dyadic::new(IBig::from(high + UBig::ONE), high_exponent);
        let low = if bottom.sign() <= 0 {
            Dyadic::ZERO
        } else {
            let (m, e) = one(&bottom);
            Dyadic::new(IBig::from(m), e)
        };
        Self::dyadic(&low).hull(&Self::dyadic(&high))
    }
    fn hull(&self, other: &Self) -> Self {
        let difference = self.minus(other);
        if difference.mantissa == IBig::ZERO && difference.radius == 0.0 {
            return self.clone();
        }
        // The middle of both middles.
        let middle = self.middle().plus(&other.middle()).times(&Self::exact(0.5));
        let reach = |b: &Self| {
            let off = middle.minus(&b.middle());
            add_up(add_up(off.size(), off.radius), b.radius)
        };
        let r = reach(self).max(reach(other));
        Self {
            radius: r,
            ..middle.middle()
        }
    }
    fn meet(&self, other: &Self) -> Option<Self> {
        if self.below(other) || other.below(self) {
            return None;
        }
        if self.radius <= other.radius {
            Some(self.clone())
        } else {
            Some(other.clone())
        }
    }
    fn lo(&self) -> f64 {
        let (value, exact) = truncated(&self.mantissa, self.exponent);
        let low = if exact || (value >= 0.0 && self.sign() >= 0) {
            value
        } else {
            value.next_down()
        };
        if self.radius == 0.0 {
            low
        } else {
            (low - self.radius).next_down()
        }
    }
    fn hi(&self) -> f64 {
        -self.negated().lo()
    }
    fn lower(&self) -> Self {
        if self.radius == 0.0 || !self.radius.is_finite() {
            return self.clone();
        }
        let all = self.middle().minus(&Self::exact(self.radius));
        // Rounded: below by what rounding may have added.
        if all.radius == 0.0 {
            all
        } else {
            let mut low = all.center();
            if let Some(r) = Dyadic::from_f64(all.radius) {
                low = &low - &r;
            }
            Self {
                mantissa: low.mantissa().clone(),
                exponent: low.exponent(),
                radius: 0.0,
            }
        }
    }
    fn upper(&self) -> Self {
        self.negated().lower().negated()
    }
    fn middle(&self) -> Self {
        Self {
            radius: 0.0,
            ..self.clone()
        }
    }
    fn radius(&self) -> f64 {
        self.radius
    }
    fn widened(&self, r: f64) -> Self {
        Self {
            radius: add_up(self.radius, r),
            ..self.clone()
        }
    }
    fn below(&self, other: &Self) -> bool {
        if !self.radius.is_finite() || !other.radius.is_finite() {
            return false;
        }
        let difference = other.minus(self);
        if difference.sign() <= 0 {
            return false;
        }
        difference.radius == 0.0 || difference.size_below() > difference.radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dashu_ratio::RBig;

    /// Numbers without pattern (xorshift), of magnitudes 2^-20 to 2^20.
    struct Numbers(u64);
    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            let m = (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
            m * f64::from((self.0 % 41) as i32 - 20).exp2()
        }
    }

    fn rational(d: &Dyadic) -> RBig {
        let two = RBig::from(2);
        let e = d.exponent();
        let scale = two.pow(e.unsigned_abs() as usize);
        let m = RBig::from(d.mantissa().clone());
        if e < 0 { m / scale } else { m * scale }
    }

    fn holds<N: Number>(n: &N, x: &RBig) -> bool {
        let (lo, hi) = n.ball().ends().unwrap();
        rational(&lo) <= *x && *x <= rational(&hi)
    }

    fn check<N: Number>(seed: u64) {
        let mut r = Numbers(seed);
        let exact = |x: f64| rational(&Dyadic::from_f64(x).unwrap());
        for _ in 0..300 {
            let (a, b, width) = (r.next(), r.next(), r.next().abs());
            let (x, y) = (exact(a), exact(b));
            // Once as points, once inside wider ones.
            for w in [0.0, width] {
                let (m, n) = (N::exact(a).widened(w), N::exact(b).widened(w * 0.5));
                assert!(holds(&m.plus(&n), &(&x + &y)));
                assert!(holds(&m.minus(&n), &(&x - &y)));
                assert!(holds(&m.times(&n), &(&x * &y)));
                assert!(holds(&m.squared(), &(&x * &x)));
                if let Some(q) = m.over(&n) {
                    assert!(holds(&q, &(&x / &y)), "{a} {b} {w}");
                }
                assert!(holds(&m.hull(&n), &x) && holds(&m.hull(&n), &y));
                let root = N::exact(a.abs()).widened(w).root();
                let (lo, hi) = root.ball().ends().unwrap();
                let (lo, hi) = (rational(&lo), rational(&hi));
                assert!(&lo * &lo <= exact(a.abs()) && exact(a.abs()) <= &hi * &hi);
                assert!(exact(m.lo()) <= x && x <= exact(m.hi()));
                if m.below(&n) {
                    assert!(x < y);
                }
            }
        }
    }

    #[test]
    fn operations_enclose() {
        check::<Interval64>(1);
        check::<Ball>(2);
    }

    #[test]
    fn exact_results_stay_points() {
        let third = Ball::exact(1.0).over(&Ball::exact(3.0)).unwrap();
        assert!(!third.is_point() && third.radius() < 1e-76);
        for (a, b) in [(0.1, 0.2), (1e40, -1e-3), (3.0, 0.0)] {
            assert!(Ball::exact(a).plus(&Ball::exact(b)).is_point());
            assert!(Ball::exact(a).times(&Ball::exact(b)).is_point());
        }
        let quarter = Interval64::exact(1.0).over(&Interval64::exact(4.0));
        assert_eq!(quarter, Some(Interval64::exact(0.25)));
        let same = Interval64::exact(0.1).times(&Interval64::exact(0.0));
        assert_eq!(same, Interval64::exact(0.0));
    }

    #[test]
    fn sine_and_cosine() {
        // sin(1) and cos(1) to 60 digits (OEIS A049469, A049470).
        let digits = |text: &str| {
            let n: IBig = text.parse().unwrap();
            RBig::from(n) / RBig::from(10).pow(text.len())
        };
        let ulp = RBig::from(1) / RBig::from(10).pow(59);
        let sin = digits("841470984807896506652502321630298999622563060798371065672751");
        let cos = digits("540302305868139717400936607442976603732310420617922227670097");
        let (s, c) = sin_cos(&Ball::exact(1.0));
        assert!(s.radius() < 1e-70 && c.radius() < 1e-70, "{s:?}");
        assert!(holds(&s.widened(1e-59), &sin) && holds(&s.widened(1e-59), &(&sin + &ulp)));
        assert!(holds(&c.widened(1e-59), &cos));
        // sin^2 + cos^2 = 1 anywhere, and f64 intervals hold what balls hold.
        let mut r = Numbers(5);
        for _ in 0..50 {
            let a = r.next() * 8.0;
            let (s, c) = sin_cos(&Ball::exact(a));
            let one = s.squared().plus(&c.squared());
            assert!(holds(&one, &RBig::from(1)) && one.radius() < 1e-60);
            let (s64, c64) = sin_cos(&Interval64::exact(a));
            assert!(s64.lo() <= s.hi() && s.lo() <= s64.hi());
            assert!(c64.lo() <= c.hi() && c.lo() <= c64.hi());
            assert!(s64.radius() < 1e-9 * a.abs().max(1.0), "{a} {s64:?}");
            // A wide one holds the values at points in it.
            let (wide, _) = sin_cos(&Interval64::new(a - 0.3, a + 0.3));
            assert!(wide.lo() <= s.lo() && s.hi() <= wide.hi());
        }
        let (s, c) = sin_cos(&Ball::exact(0.0));
        assert!(s.hi() == 0.0 && c.lo() == 1.0);
    }
}
