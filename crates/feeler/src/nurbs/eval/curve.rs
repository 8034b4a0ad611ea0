//! Curves.

use super::Scalar;
use super::parameter::{Limit, Parameter};
use super::spline::{SHORT, ShortSpan, Span, binomial, value};
use crate::numeric::{Ball, Dd, Interval, sin_cos};
use crate::nurbs::{Arc, Curve, NurbsCurve};
use nalgebra::{Point, SVector};

impl<const D: usize, const H: usize> Curve<D, H> {
    /// The point at `t` (clamped to the domain), in f64, with the a-priori error stated
    /// [here](super).
    pub fn point(&self, t: f64) -> Point<f64, D> {
        if let Self::Nurbs(curve) = self
            && let Some(point) = nurbs_point(curve, t)
        {
            return point;
        }
        if let Self::Line(c) = self {
            let t = Parameter::new(t, c.domain, Limit::FromAbove);
            return Point::from(SVector::from(on_segment(&c.from, &c.to, c.domain, &t)));
        }
        let derivatives = self.derivatives_in::<f64>(t, 0, Limit::FromAbove);
        Point::from(SVector::from(derivatives[0]))
    }

    /// The point and the derivatives with respect to `t`, orders 0 to `order`, in f64. At
    /// knots and joints they are one-sided, from above (see [`Limit`]).
    pub fn derivatives(&self, t: f64, order: usize) -> Vec<SVector<f64, D>> {
        let short = match self {
            Self::Nurbs(curve) => short_nurbs(curve, t, order),
            _ => None,
        };
        let all = short.unwrap_or_else(|| self.derivatives_in::<f64>(t, order, Limit::FromAbove));
        all.into_iter().map(SVector::from).collect()
    }

    /// The point at `t` (clamped to the domain) and a proven bound on the error of each coordinate. It
    /// is evaluated in double-double, so that the bound is about half an ulp of the largest
    /// coordinate.
    pub fn point_with_bound(&self, t: f64) -> (Point<f64, D>, f64) {
        let point = self.derivatives_in::<Ball<Dd>>(t, 0, Limit::FromAbove)[0];
        let (coords, bound) = rounded(&point);
        (Point::from(coords), bound)
    }

    /// The point and the derivatives up to `order` in any arithmetic: coordinates of the k-th
    /// derivative at index k. Cost: O(order p^2 + order^2) operations.
    pub fn derivatives_in<S: Scalar>(&self, t: f64, order: usize, limit: Limit) -> Vec<[S; D]> {
        let t = Parameter::new(t, self.domain(), limit);
        match self {
            Self::Poly(poly) => {
                let i = t.find(poly.params());
                let from = Interval {
                    start: poly.params()[i],
                    end: poly.params()[i + 1],
                };
                let segment = &poly.segments()[i];
                let to = segment.domain();
                let mut all = simple(segment, &t.mapped(from, to), order);
                scale_by_powers(&mut all, Parameter::rate(from, to));
                all
            }
            _ => simple(self, &t, order),
        }
    }
}

/// The nearest f64 and a bound on the largest coordinate's error. What left the range of f64
/// becomes 0 with an infinite bound.
pub(super) fn rounded<const D: usize>(x: &[Ball<Dd>; D]) -> (SVector<f64, D>, f64) {
    let known = |b: &Ball<Dd>| b.mid.hi.is_finite() && b.mid.lo.is_finite() && b.rad.is_finite();
    if !x.iter().all(known) {
        return (SVector::zeros(), f64::INFINITY);
    }
    let bound = x
        .iter()
        .map(|b| (b.mid.lo.abs() + b.rad) * (1.0 + 2.0 * f64::EPSILON))
        .fold(0.0, f64::max);
    (SVector::from(x.map(|b| b.mid.hi)), bound)
}

/// Multiplies the k-th by `rate^k`: the chain rule for a linear change of parameter.
fn scale_by_powers<S: Scalar, const D: usize>(all: &mut [[S; D]], rate: S) {
    let mut power = rate;
    for derivative in all.iter_mut().skip(1) {
        for x in derivative.iter_mut() {
            *x = *x * power;
        }
        power = power * rate;
    }
}

/// All but poly-curves.
fn simple<S: Scalar, const D: usize, const H: usize>(
    curve: &Curve<D, H>,
    t: &Parameter,
    order: usize,
) -> Vec<[S; D]> {
    match curve {
        Curve::Line(c) => segment(&c.from, &c.to, c.domain, t, order),
        Curve::Polyline(c) => {
            let i = t.find(c.params());
            let on = Interval {
                start: c.params()[i],
                end: c.params()[i + 1],
            };
            segment(&c.points()[i], &c.points()[i + 1], on, t, order)
        }
        Curve::Arc(c) => arc(c, t, order),
        Curve::Nurbs(c) => nurbs(c, t, order),
        // Poly-curves hold no poly-curves: `PolyCurve::new` flattens them.
        Curve::Poly(_) => vec![[S::ZERO; D]; order + 1],
    }
}

fn segment<S: Scalar, const D: usize>(
    from: &Point<f64, D>,
    to: &Point<f64, D>,
    on: Interval,
    t: &Parameter,
    order: usize,
) -> Vec<[S; D]> {
    let mut out = vec![[S::ZERO; D]; order + 1];
    out[0] = on_segment(from, to, on, t);
    if order > 0 {
        let length = S::difference(on.end, on.start);
        out[1] = std::array::from_fn(|c| S::difference(to[c], from[c]) / length);
    }
    out
}

/// From the nearer end; exact at both, and where the ends agree.
fn on_segment<S: Scalar, const D: usize>(
    from: &Point<f64, D>,
    to: &Point<f64, D>,
    on: Interval,
    t: &Parameter,
) -> [S; D] {
    let (r, s) = t.fractions::<S>(on);
    let is_first = s.value() <= r.value();
    std::array::from_fn(|c| {
        let step = S::difference(to[c], from[c]);
        if is_first {
            S::exact(from[c]) + s * step
        } else {
            S::exact(to[c]) - r * step
        }
    })
}

fn nurbs<S: Scalar, const D: usize, const H: usize>(
    curve: &NurbsCurve<H>,
    t: &Parameter,
    order: usize,
) -> Vec<[S; D]> {
    let span = Span::<S>::new(curve.knots(), t);
    let active = &curve.control_points()[span.index - curve.degree()..=span.index];
    let mut local: Vec<[S; H]> = active
        .iter()
        .map(|p| std::array::from_fn(|i| S::exact(p[i])))
        .collect();
    let homogeneous = span.derivatives(&mut local, order);
    quotients(active, &homogeneous)
}

/// A curve's point and derivatives from its homogeneous ones, there where it has these active control points.
fn quotients<S: Scalar, const D: usize, const H: usize>(
    active: &[SVector<f64, H>],
    homogeneous: &[[S; H]],
) -> Vec<[S; D]> {
    let mut out: Vec<[S; D]> = homogeneous
        .iter()
        .map(|h| std::array::from_fn(|i| h[i]))
        .collect();
    let weight = active[0][D];
    if active.iter().all(|p| p[D] == weight) {
        if weight != 1.0 {
            for x in out.iter_mut().flatten() {
                *x = *x / S::exact(weight);
            }
        }
        return out;
    }
    // The quotient rule, A4.2.
    for k in 0..out.len() {
        out[k] = std::array::from_fn(|c| {
            let mut v = out[k][c];
            for i in 1..=k {
                v = v - binomial::<S>(k, i) * homogeneous[i][D] * out[k - i][c];
            }
            v / homogeneous[0][D]
        });
    }
    out
}

/// The point as [`nurbs`] has it, to the same bits; `None` where [`value`] has none.
fn nurbs_point<const D: usize, const H: usize>(
    curve: &NurbsCurve<H>,
    t: f64,
) -> Option<Point<f64, D>> {
    let t = Parameter::new(t, curve.domain(), Limit::FromAbove);
    let all = curve.control_points();
    let (h, first) = value(curve.knots(), all, &t)?;
    let active = &all[first..=first + curve.degree()];
    let weight = active[0][D];
    let by = if active.iter().all(|p| p[D] == weight) {
        weight
    } else {
        h[D]
    };
    // The quotient by 1 is the number itself.
    Some(Point::from(SVector::from_fn(|c, _| h[c] / by)))
}

/// The point and the derivatives as [`nurbs`] has them in f64, to the same bits; `None` where [`ShortSpan`] does not serve.
fn short_nurbs<const D: usize, const H: usize>(
    curve: &NurbsCurve<H>,
    t: f64,
    order: usize,
) -> Option<Vec<[f64; D]>> {
    if order > SHORT {
        return None;
    }
    let t = Parameter::new(t, curve.domain(), Limit::FromAbove);
    let span = ShortSpan::new(curve.knots(), &t)?;
    let active = &curve.control_points()[span.index - span.degree..=span.index];
    let mut local = [[0.0; H]; SHORT + 1];
    for (own, p) in local.iter_mut().zip(active) {
        *own = (*p).into();
    }
    let homogeneous = span.derivatives(&local, order);
    Some(quotients(active, &homogeneous[..=order]))
}

/// An exact vector, times a power of two that brings its largest coordinate near 1. Coordinates below
/// 2^-1022 after that are rounded, by less than any ball's underflow allowance
/// ([`TINY`](crate::numeric::TINY)).
fn balanced<const D: usize>(v: &SVector<f64, D>) -> [Ball<Dd>; D] {
    let largest = v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    // 2^-e as two factors, as e may reach 1074.
    let e = exponent(largest);
    let (a, b) = (power_of_two(-e / 2), power_of_two(-e - (-e / 2)));
    std::array::from_fn(|i| Ball::exact(v[i] * a * b))
}

/// e with `2^e <= x < 2^(e+1)`, for a positive normal number; -1022 below.
fn exponent(x: f64) -> i32 {
    (((x.to_bits() >> 52) & 0x7ff) as i32).max(1) - 1023
}

/// `2^e` for -1022 <= e <= 1023.
fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((e + 1023) as u64) << 52)
}

fn dot<const D: usize>(a: &[Ball<Dd>; D], b: &[Ball<Dd>; D]) -> Ball<Dd> {
    (0..D).fold(Ball::ZERO, |s, i| s + a[i] * b[i])
}

fn normalised<const D: usize>(v: [Ball<Dd>; D]) -> [Ball<Dd>; D] {
    let length = dot(&v, &v).sqrt();
    v.map(|x| x / length)
}

/// The stored axis exactly normalised.
pub(super) fn unit<const D: usize>(v: &SVector<f64, D>) -> [Ball<Dd>; D] {
    normalised(balanced(v))
}

/// The arc's exact axes `x'` and `y'` (see [`Arc`]).
pub(in crate::nurbs) fn frame<const D: usize>(arc: &Arc<D>) -> ([Ball<Dd>; D], [Ball<Dd>; D]) {
    let x = balanced(&arc.x);
    if D == 2 {
        let x = normalised(x);
        let turn = arc.x[0] * arc.y[1] - arc.x[1] * arc.y[0];
        let y = if turn < 0.0 {
            [x[1], -x[0]]
        } else {
            [-x[1], x[0]]
        };
        return (x, std::array::from_fn(|i| y[i]));
    }
    let z = balanced(&arc.z);
    // x - (x.z) z / (z.z), then normalised. With the stored axes nearly orthogonal it loses no digits.
    let share = dot(&x, &z) / dot(&z, &z);
    let x = normalised(std::array::from_fn(|i| x[i] - share * z[i]));
    let z = normalised(z);
    let cross = |i: usize, j: usize| z[i] * x[j] - z[j] * x[i];
    let y = [cross(1, 2), cross(2, 0), cross(0, 1)];
    (x, std::array::from_fn(|i| y[i]))
}

fn arc<S: Scalar, const D: usize>(arc: &Arc<D>, t: &Parameter, order: usize) -> Vec<[S; D]> {
    let (x, y) = frame(arc);
    let (sin, cos, rate) = turn(arc.angle, arc.domain, t);
    let mut out = Vec::with_capacity(order + 1);
    let mut size = Ball::exact(arc.radius);
    // Each derivative turns the direction by 90 degrees and multiplies by the rate.
    let (mut along_x, mut along_y) = (cos, sin);
    for k in 0..=order {
        out.push(std::array::from_fn(|c| {
            let v = size * (along_x * x[c] + along_y * y[c]);
            S::from_ball(if k == 0 {
                Ball::exact(arc.center[c]) + v
            } else {
                v
            })
        }));
        size = size * rate;
        (along_x, along_y) = (-along_y, along_x);
    }
    out
}

/// Sine and cosine of the angle at `t`, and how fast the angle moves.
pub(super) fn turn(
    angle: Interval,
    domain: Interval,
    t: &Parameter,
) -> (Ball<Dd>, Ball<Dd>, Ball<Dd>) {
    let rate = Parameter::rate::<Ball<Dd>>(domain, angle);
    let at = if angle == domain {
        t.minus::<Ball<Dd>>(0.0)
    } else {
        let (r, s) = t.fractions::<Ball<Dd>>(domain);
        let sweep = Ball::difference(angle.end, angle.start);
        if s.value() <= r.value() {
            Ball::exact(angle.start) + s * sweep
        } else {
            Ball::exact(angle.end) - r * sweep
        }
    };
    let (sin, cos) = sin_cos(at);
    (sin, cos, rate)
}
