//! One span of a spline as Bezier control points: in balls, and in integers.

use super::source::{Ball3, End, Exact3, integers, to_balls};
use crate::numeric::gcd;
use crate::numeric::{Ball, Dd};
use dashu_int::ops::UnsignedAbs;
use dashu_int::{IBig, UBig};
use nalgebra::Vector3;
use std::sync::Arc;

/// All of a spline.
#[derive(Debug)]
pub(super) struct Spline {
    pub(super) degree: usize,
    pub(super) knots: Arc<[f64]>,
    pub(super) points: Arc<[Vector3<f64>]>,
}

/// Part of one span of a spline, in either direction.
#[derive(Clone, Debug)]
pub(super) struct SplineSpan {
    all: Arc<Spline>,
    /// Of the knot that the span starts at.
    index: u32,
    /// Whether it runs from its second end to its first.
    reversed: bool,
    /// Its ends, where these are not the span's own.
    cut: Option<Box<[Param; 2]>>,
}

/// A parameter: a f64, or a quotient of integers that is none.
#[derive(Clone, Debug)]
pub(super) struct Param {
    /// The f64, or one near.
    pub(super) near: f64,
    /// Numerator and positive denominator where `near` is not exact.
    ratio: Option<Box<(IBig, IBig)>>,
}

impl Param {
    pub(super) fn f64(x: f64) -> Self {
        Self {
            near: x,
            ratio: None,
        }
    }

    /// `to[0] + (to[1] - to[0]) (t - from[0]) / (from[1] - from[0])`, exactly; the ends go to the ends.
    pub(super) fn mapped(t: f64, from: [f64; 2], to: [f64; 2]) -> Self {
        if t <= from[0] {
            return Self::f64(to[0]);
        }
        if t >= from[1] {
            return Self::f64(to[1]);
        }
        if from == to {
            return Self::f64(t);
        }
        let s = (t - from[0]) / (from[1] - from[0]);
        let near = (to[0] + s * (to[1] - to[0])).clamp(to[0], to[1]);
        let Some(n) = integers(&[[t, from[0], from[1]], [to[0], to[1], 1.0]]) else {
            return Self::f64(near);
        };
        let den = &n[0][2] - &n[0][1];
        let num = &n[1][0] * &den + (&n[1][1] - &n[1][0]) * (&n[0][0] - &n[0][1]);
        Self {
            near,
            ratio: Some(Box::new((num, den * &n[1][2]))),
        }
    }

    /// The sign of `self - x`.
    pub(super) fn compare(&self, x: f64) -> std::cmp::Ordering {
        match &self.ratio {
            None => self
                .near
                .partial_cmp(&x)
                .unwrap_or(std::cmp::Ordering::Equal),
            Some(r) => match integers(&[[x, 1.0, 0.0]]) {
                Some(n) => (&r.0 * &n[0][1]).cmp(&(&n[0][0] * &r.1)),
                None => std::cmp::Ordering::Less,
            },
        }
    }

    /// `k - self`.
    pub(super) fn below(&self, k: f64) -> Ball<Dd> {
        match &self.ratio {
            None => Ball::difference(k, self.near),
            Some(r) => {
                let b = to_balls(&[[r.0.clone(), r.1.clone(), IBig::ZERO]]);
                Ball::exact(k) - b[0][0] / b[0][1]
            }
        }
    }

    /// Whether it is exactly `k`.
    pub(super) fn is(&self, k: f64) -> bool {
        self.ratio.is_none() && self.near == k
    }

    fn denominator(&self) -> IBig {
        self.ratio.as_ref().map_or(IBig::ONE, |r| r.1.clone())
    }
}

impl SplineSpan {
    /// What of the span that starts at a knot is between two parameters of it.
    pub(super) fn new(all: &Arc<Spline>, index: usize, ends: [Param; 2]) -> Self {
        let whole = ends[0].is(all.knots[index]) && ends[1].is(all.knots[index + 1]);
        Self {
            all: Arc::clone(all),
            index: index as u32,
            reversed: false,
            cut: (!whole).then(|| Box::new(ends)),
        }
    }

    pub(super) fn reverse(&mut self) {
        self.reversed = !self.reversed;
    }

    fn degree(&self) -> usize {
        self.all.degree
    }

    /// The parameters at t = 0 and t = 1.
    fn ends(&self) -> [Param; 2] {
        let mut ends = match &self.cut {
            Some(cut) => (**cut).clone(),
            None => [0, 1].map(|k| Param::f64(self.all.knots[self.index as usize + k])),
        };
        if self.reversed {
            ends.reverse();
        }
        ends
    }

    /// `2p` knots, `knots[p - 1] <= .. <= knots[p]` the span.
    fn knots(&self) -> &[f64] {
        let (i, p) = (self.index as usize, self.degree());
        &self.all.knots[i + 1 - p..=i + p]
    }

    /// `p + 1` homogeneous control points.
    fn points(&self) -> impl Iterator<Item = [f64; 3]> {
        let (i, p) = (self.index as usize, self.degree());
        self.all.points[i - p..=i].iter().map(|x| (*x).into())
    }

    /// Bezier control points by blossoms: `b_k = f(from^(p-k), to^k)` (Ramshaw; *The NURBS Book*
    /// has it as knot insertion). Level r of de Boor's algorithm replaces
    /// `d_j` by `((hi - x) d_(j-1) + (x - lo) d_j) / (hi - lo)` with `lo` and `hi` the knots p + 1 - r apart around it;
    /// every factor is >= 0, so weights stay positive.
    pub(super) fn balls(&self) -> Vec<Ball3> {
        let (p, all_knots) = (self.degree(), self.knots());
        let [from, to] = &self.ends();
        let mut out = Vec::with_capacity(p + 1);
        let mut d = Vec::with_capacity(p + 1);
        for k in 0..=p {
            d.clear();
            d.extend(self.points().map(|c| c.map(Ball::exact)));
            for r in 1..=p {
                // The last k arguments are `to`, taken last: earlier levels see the same values.
                let x = if r > p - k { to } else { from };
                for j in (r..=p).rev() {
                    let (lo, hi) = (all_knots[j - 1], all_knots[j + p - r]);
                    if x.is(lo) {
                        d[j] = d[j - 1];
                        continue;
                    }
                    if x.is(hi) {
                        continue;
                    }
                    let width = Ball::<Dd>::difference(hi, lo);
                    let a = x.below(hi) / width;
                    let b = -x.below(lo) / width;
                    d[j] = [0, 1, 2].map(|i| a * d[j - 1][i] + b * d[j][i]);
                }
            }
            out.push(d[p]);
        }
        out
    }

    /// The same in integers, up to a common positive factor: at each level all points are multiplied
    /// by the least common multiple of the knot differences, which do not depend on x.
    pub(super) fn exact(&self) -> Option<Vec<Exact3>> {
        let p = self.degree();
        let span = self.ends();
        // Everything is multiplied by `unit`, and by the denominators of the two ends.
        let mut line: Vec<[f64; 3]> = self.knots().iter().map(|k| [*k, 0.0, 0.0]).collect();
        let near = |x: &Param| if x.ratio.is_none() { x.near } else { 0.0 };
        line.push([near(&span[0]), near(&span[1]), 1.0]);
        let mut line = integers(&line)?;
        let (dens, unit) = (
            [span[0].denominator(), span[1].denominator()],
            line[2 * p][2].clone(),
        );
        let common = &dens[0] * &dens[1];
        for x in line.iter_mut().flatten() {
            *x *= &common;
        }
        let (knots, ends) = line.split_at(2 * p);
        let value = |x: &Param, plain: &IBig, other: &IBig| match &x.ratio {
            Some(r) => &r.0 * &unit * other,
            None => plain.clone(),
        };
        let from = &value(&span[0], &ends[0][0], &dens[1]);
        let to = &value(&span[1], &ends[0][1], &dens[0]);
        let points = integers(&self.points().collect::<Vec<_>>())?;
        // multipliers[r - 1][j - r] = lcm / (hi - lo).
        let mut multipliers = Vec::with_capacity(p);
        for r in 1..=p {
            let widths: Vec<UBig> = (r..=p)
                .map(|j| (&knots[j + p - r][0] - &knots[j - 1][0]).unsigned_abs())
                .collect();
            let mut lcm = UBig::ONE;
            for w in &widths {
                if *w == UBig::ZERO {
                    return None;
                }
                lcm = &lcm / gcd(lcm.clone(), w.clone()) * w;
            }
            multipliers.push(
                widths
                    .iter()
                    .map(|w| IBig::from(&lcm / w))
                    .collect::<Vec<_>>(),
            );
        }
        let mut out = Vec::with_capacity(p + 1);
        for k in 0..=p {
            let mut d = points.clone();
            for r in 1..=p {
                let x = if r > p - k { to } else { from };
                for j in (r..=p).rev() {
                    let m = &multipliers[r - 1][j - r];
                    let a = (&knots[j + p - r][0] - x) * m;
                    let b = (x - &knots[j - 1][0]) * m;
                    d[j] = [0, 1, 2].map(|i| &a * &d[j - 1][i] + &b * &d[j][i]);
                }
            }
            out.push(d.swap_remove(p));
        }
        Some(reduced(out))
    }
}

impl SplineSpan {
    /// The end point at t = 0 or at t = 1, exactly.
    pub(super) fn end(&self, last: bool) -> Option<End> {
        let (p, knots) = (self.degree(), self.knots());
        let mut points = self.points();
        let x = &self.ends()[usize::from(last)];
        // Clamped: the last p knots at or before the span's start (or after its end) coincide.
        if knots[..p].iter().all(|k| x.is(*k)) {
            return Some(End::weighted(points.next()?));
        }
        if knots[p..].iter().all(|k| x.is(*k)) {
            return Some(End::weighted(points.last()?));
        }
        let mut exact = self.exact()?;
        let k = if last { exact.len() - 1 } else { 0 };
        Some(End::Rational(exact.swap_remove(k)))
    }
}

/// Divided by the greatest common divisor of all coordinates.
fn reduced(mut points: Vec<Exact3>) -> Vec<Exact3> {
    let mut g = UBig::ZERO;
    for x in points.iter().flatten() {
        if *x != IBig::ZERO {
            let m = x.clone().unsigned_abs();
            g = if g == UBig::ZERO { m } else { gcd(g, m) };
            if g == UBig::ONE {
                return points;
            }
        }
    }
    if g != UBig::ZERO {
        let g = IBig::from(g);
        for x in points.iter_mut().flatten() {
            *x /= &g;
        }
    }
    points
}
