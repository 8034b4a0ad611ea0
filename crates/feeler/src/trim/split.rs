//! Splitting a piece where u' or v' changes sign, in f64 with proven signs.

use super::piece::Piece;
use super::source::{Ball3, Source};
use crate::numeric::polynomial::{Polynomial, binomials};
use crate::numeric::{Ball, Dd};

/// How a coordinate runs over a part of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trend {
    /// Strictly increasing.
    Up,
    /// Strictly decreasing.
    Down,
    /// Constant.
    Flat,
    /// Not known: a turn is inside, or the sign could not be settled in floats.
    Mixed,
}

/// The parts of a piece: parameters `0 = t_0 < .. < t_n = 1`, and the trends of u and v between them.
/// Mixed parts are as short as the arithmetic allows.
pub(super) struct Parts {
    pub(super) t: Vec<f64>,
    pub(super) trends: Vec<[Trend; 2]>,
}

/// Parts shorter than this are not split.
const SHORTEST: f64 = 1.0 / (1u64 << 50) as f64;
/// A bound on the number of parts of one piece: 48 turns an axis at degree 25, and what surrounds them.
const MOST_PARTS: usize = 4096;

/// A derivative's numerator on `[t, t + width]`: Bernstein coefficients, each within `error`.
#[derive(Clone)]
struct Numerator {
    coefficients: Vec<f64>,
    error: f64,
    flat: bool,
}

impl Numerator {
    fn trend(&self) -> Trend {
        if self.flat {
            return Trend::Flat;
        }
        let e = self.error;
        if self.coefficients.iter().all(|c| *c > e) {
            Trend::Up
        } else if self.coefficients.iter().all(|c| *c < -e) {
            Trend::Down
        } else {
            Trend::Mixed
        }
    }

    /// No splitting can settle what is all noise.
    fn hopeless(&self) -> bool {
        self.coefficients
            .iter()
            .all(|c| c.abs() <= 2.0 * self.error || c.is_nan())
    }

    /// De Casteljau at 1/2. Each of the n levels rounds once, relative to at most the largest
    /// coefficient; halving is exact.
    fn halves(&self) -> (Self, Self) {
        let n = self.coefficients.len();
        let mut right = self.coefficients.clone();
        let mut left = Vec::with_capacity(n);
        let largest = right.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        for k in 0..n {
            left.push(right[0]);
            for i in 0..n - 1 - k {
                right[i] = 0.5 * (right[i] + right[i + 1]);
            }
        }
        let error = (self.error + n as f64 * f64::EPSILON * largest) * (1.0 + 4.0 * f64::EPSILON)
            + f64::MIN_POSITIVE;
        let make = |coefficients| Self {
            coefficients,
            error,
            flat: self.flat,
        };
        // right[i] now holds the last point of level n - 1 - i: in order already.
        let right = make(right);
        (make(left), right)
    }
}

/// What is known of a coordinate over a part. What it does all along it does on both halves.
enum Axis {
    Known(Trend),
    /// Mixed.
    Open(Numerator),
}

impl Axis {
    fn new(n: Numerator) -> Self {
        match n.trend() {
            Trend::Mixed => Self::Open(n),
            trend => Self::Known(trend),
        }
    }

    fn trend(&self) -> Trend {
        match self {
            Self::Known(trend) => *trend,
            Self::Open(_) => Trend::Mixed,
        }
    }

    fn halves(&self) -> (Self, Self) {
        match self {
            Self::Known(trend) => (Self::Known(*trend), Self::Known(*trend)),
            Self::Open(n) => {
                let (a, b) = n.halves();
                (Self::new(a), Self::new(b))
            }
        }
    }
}

/// The numerator of axis `axis` over [0, 1]: for constant weights the differences of control points, else
/// the coefficient of x^k in `X'W - XW'`, which is
/// `sum over i > j, i + j = k + 1 of (i - j) (a_i c_j - a_j c_i)` with a, c the
/// coefficients of X and W with binomials; roots at the ends are taken out where they are exact.
fn numerator(piece: &Piece, balls: &[Ball3], axis: usize) -> Numerator {
    let p = balls.len() - 1;
    let c = binomials(p);
    let same_weights = balls
        .iter()
        .all(|b| b[2].rad == 0.0 && b[2].mid == balls[0][2].mid);
    let cross = |i: usize, j: usize| {
        let (a, b) = (&balls[i], &balls[j]);
        let exact = |x: &Ball<Dd>| x.rad == 0.0 && x.mid.lo == 0.0;
        // Equal products of f64 cancel exactly, which balls cannot see.
        if [&a[axis], &a[2], &b[axis], &b[2]].into_iter().all(exact)
            && Dd::product(a[axis].mid.hi, b[2].mid.hi) == Dd::product(b[axis].mid.hi, a[2].mid.hi)
            && [a[axis], b[axis], a[2], b[2]]
                .iter()
                .all(|x| x.mid.hi == 0.0 || (1e-130..1e130).contains(&x.mid.hi.abs()))
        {
            return Ball::ZERO;
        }
        a[axis] * b[2] - b[axis] * a[2]
    };
    let mut n: Vec<Ball<Dd>> = if same_weights {
        (0..p)
            .map(|i| {
                if balls[i + 1][axis].mid == balls[i][axis].mid
                    && balls[i + 1][axis].rad == 0.0
                    && balls[i][axis].rad == 0.0
                {
                    Ball::ZERO
                } else {
                    balls[i + 1][axis] - balls[i][axis]
                }
            })
            .collect()
    } else {
        let outer = binomials(2 * p - 2);
        (0..2 * p - 1)
            .map(|k| {
                let mut sum = Ball::ZERO;
                for i in 0..=p {
                    let Some(j) = (k + 1).checked_sub(i) else {
                        continue;
                    };
                    if j < i && j <= p {
                        let d = cross(i, j);
                        if d.rad == 0.0 && d.mid == Dd::ZERO {
                            continue;
                        }
                        let factor = (i - j) as f64 * c[i] as f64 * c[j] as f64;
                        sum = sum + d * Ball::exact(factor);
                    }
                }
                if sum.rad == 0.0 && sum.mid == Dd::ZERO {
                    return sum;
                }
                sum / Ball::exact(outer[k] as f64)
            })
            .collect()
    };
    let is_zero = |b: &Ball<Dd>| b.rad == 0.0 && b.mid == Dd::ZERO;
    let unsettled = |b: &Ball<Dd>| !is_zero(b) && b.mid.hi.abs() <= 2.0 * b.rad;
    // An end that floats cannot tell from zero is most often zero: ask the integers.
    let ends = [n.first(), n.last()];
    let doubtful =
        ends.into_iter().flatten().any(unsettled) || n.iter().all(|b| is_zero(b) || unsettled(b));
    if doubtful && let Some(exact) = piece.exact() {
        settle_ends(&mut n, &exact.derivative(axis));
    }
    if n.iter().all(is_zero) {
        return Numerator {
            coefficients: vec![0.0],
            error: 0.0,
            flat: true,
        };
    }
    // Without its zeros at the ends the numerator has degree m; multiplied by t^k (1 - t)^l > 0 in
    // between. Binomials of the new degree replace those of the old.
    let degree = n.len() - 1;
    let front = n.iter().take_while(|b| is_zero(b)).count();
    let back = n.iter().rev().take_while(|b| is_zero(b)).count();
    let old = binomials(degree);
    let kept = &n[front..n.len() - back];
    let new = binomials(kept.len() - 1);
    let mut coefficients = Vec::with_capacity(kept.len());
    let mut error = 0.0f64;
    for (i, b) in kept.iter().enumerate() {
        let b = if front + back > 0 {
            *b * Ball::exact(old[front + i] as f64) / Ball::exact(new[i] as f64)
        } else {
            *b
        };
        coefficients.push(b.mid.hi);
        let e = (b.rad + b.mid.lo.abs()) * (1.0 + 4.0 * f64::EPSILON);
        // NaN must not be lost.
        error = if e <= error { error } else { e };
    }
    Numerator {
        coefficients,
        error: error + f64::MIN_POSITIVE,
        flat: false,
    }
}

/// Puts exact zeros where the exact numerator has them at its ends.
fn settle_ends(n: &mut Vec<Ball<Dd>>, exact: &Polynomial) {
    if exact.is_zero() {
        n.clear();
        return;
    }
    let zero = |a: &dashu_int::IBig| *a == dashu_int::IBig::ZERO;
    // Equal weights may be seen on one side only; then the degrees differ and the ends stay doubtful.
    if exact.degree() + 1 != n.len() {
        return;
    }
    for (b, _) in n
        .iter_mut()
        .zip(exact.coefficients())
        .take_while(|(_, a)| zero(a))
    {
        *b = Ball::ZERO;
    }
    let from_back = n.iter_mut().rev().zip(exact.coefficients().iter().rev());
    for (b, _) in from_back.take_while(|(_, a)| zero(a)) {
        *b = Ball::ZERO;
    }
}

/// Splits a piece.
pub(super) fn split(piece: &Piece, balls: &[Ball3]) -> Parts {
    let whole = |trends| Parts {
        t: vec![0.0, 1.0],
        trends: vec![trends],
    };
    if let Source::Segment([a, b]) = &piece.source {
        let trend = |i: usize| match a[i].partial_cmp(&b[i]) {
            Some(std::cmp::Ordering::Less) => Trend::Up,
            Some(std::cmp::Ordering::Greater) => Trend::Down,
            _ => Trend::Flat,
        };
        return whole([trend(0), trend(1)]);
    }
    if let Source::Arc(arc) = &piece.source {
        return whole(arc.trends());
    }
    let mut parts = Parts {
        t: vec![0.0],
        trends: Vec::new(),
    };
    let axes = [0, 1].map(|axis| Axis::new(numerator(piece, balls, axis)));
    let mut stack = vec![(axes, 0.0, 1.0)];
    while let Some((axes, t, width)) = stack.pop() {
        let trends = axes.each_ref().map(Axis::trend);
        let stuck = |i: usize| match &axes[i] {
            Axis::Known(_) => true,
            Axis::Open(n) => n.hopeless(),
        };
        let many = parts.trends.len() + stack.len() > MOST_PARTS;
        if (stuck(0) && stuck(1)) || width <= SHORTEST || many {
            // Adjacent parts of equal, known trends are one.
            let same = parts.trends.last() == Some(&trends);
            if same && !many {
                if let Some(last) = parts.t.last_mut() {
                    *last = t + width;
                }
            } else {
                parts.t.push(t + width);
                parts.trends.push(trends);
            }
            continue;
        }
        let (a, b) = (axes[0].halves(), axes[1].halves());
        let half = 0.5 * width;
        stack.push(([a.1, b.1], t + half, half));
        stack.push(([a.0, b.0], t, half));
    }
    parts
}
