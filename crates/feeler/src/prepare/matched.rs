//! A proven bound of the distance of two parts of rational Bezier curves that are matched with each other.
//!
//! Let `A = X / V` and `B = Y / W` be the parts and `e(s) = A(s) - B(s)` at equal relative parameters. It is
//! `(X W - Y V) / (V W)`, at every `s` a convex combination of the quotients `e_k` of its Bernstein coefficients, as `V W > 0`. So
//! every convex function of `e`, such as its length or that of a projection, is bounded by the largest value at the `e_k`.
//!
//! 1. `|e| <= max |e_k|`.
//! 2. Two parametrisations of nearly one curve differ along it far more than across it. Let `t` be a unit vector, `e_T = e.t`
//!    and `e_P` the rest. Let both parts be monotone along `t`, and `B' ` in the cone `|B'_P| <= m B'_T`. Match points of equal
//!    height `.t`, and those whose height the other part does not reach with its end there. `B` at the matched place
//!    differs from `B(s)` in height by at most `|e_T(s)|`, hence across by at most `m |e_T(s)|`. So matched points are
//!    apart by no more than `max |e_P| + m max |e_T|` across, and along by `max(|e_T(0)|, |e_T(1)|)`: where the other
//!    part does not reach, its end is at most as far as the own end beside it.
//!
//!    The cone: the derivative of a rational Bezier curve with weights > 0 is a combination with coefficients >= 0 of
//!    the `q_j - q_i`, `i < j`, and so of the steps `q_(i+1) - q_i` of its control polygon
//!    (`b_i b_j' - b_i' b_j = (j - i) b_i b_j / (s (1 - s)) >= 0`).
//!
//! Numbers are computed without bounds of their own, as these take longer than the numbers; the bounds are derived beside each step from the largest numbers
//! in it. In them `U` is the relative error of a sum or product, `D` that of a quotient; a product that underflows is off by [`TINY`] more.

use super::compose::EXACT_BINOMIALS;
use super::image::{Stretch, exact};
use crate::numeric::bernstein::binomials;
use crate::numeric::{Ball, Real, TINY};
use nalgebra::Vector3;

/// A bound that is off by a few roundings of f64 and by the squares of errors that are left out: less than ten thousand units each, as degrees are at most
/// [`MAX_COMPOSED_DEGREE`](super::compose::MAX_COMPOSED_DEGREE).
const UP: f64 = 1.0 + 1.0 / (1u64 << 39) as f64;
/// The direct bound is taken where it is at most so many times its slack.
pub(super) const NEAR_SLACK: f64 = 4.0;

/// What the coefficients of a product of polynomials of two degrees are made with.
pub(super) struct Factors<T> {
    orders: [usize; 2],
    /// `C(p, i) C(q, j) / C(p + q, i + j)`, row by row.
    shares: Vec<T>,
    /// How far the coefficients of a sum of products of which each term is off by no more than `x` beforehand, is at most `y` itself and gets the share of
    /// its own are off at most, beyond `x`, for `y = 1`: shares are off by a product and a quotient and, where binomials are large, by the additions that these
    /// are made of; then there are a product and at most as many sums as the lower degree has control points. All shares of a coefficient sum to 1.
    error: f64,
}

impl<T: Real> Factors<T> {
    fn new(orders: [usize; 2]) -> Self {
        let [p, q] = orders.map(|n| n - 1);
        let (a, b, whole) = (binomials::<T>(p), binomials::<T>(q), binomials::<T>(p + q));
        let mut shares = Vec::with_capacity(orders[0] * orders[1]);
        for (i, x) in a.iter().enumerate() {
            shares.extend(b.iter().enumerate().map(|(j, y)| *x * *y / whole[i + j]));
        }
        // All of them are exact up to this sum.
        let inexact = if p + q <= EXACT_BINOMIALS {
            0.0
        } else {
            2.0 * (p + q) as f64
        };
        let units = inexact + 2.0 + orders[0].min(orders[1]) as f64;
        Self {
            orders,
            shares,
            error: (units * T::UNIT + T::DIV_UNIT) * UP,
        }
    }

    /// Bytes of those for so many control points, and of what they are made of.
    pub(super) fn bytes(a: usize, b: usize) -> usize {
        (a * b + 2 * (a + b)) * size_of::<T>()
    }
}

/// The control points over `[from, to]` of a curve over `[0, 1]`, by de Casteljau twice, and how far the curve may be from the part of the given one at the same relative
/// parameter.
///
/// A level replaces neighbours `a` and `b` by `(1 - t) a + t b`, `0 <= t <= 1`. `1 - t` is off by `U (1 - t)`, the products by `U` of each, the sum by `U`: together by no more than
/// `3 U ((1 - t) |a| + t |b|)`. What that is at most at the end is the same combination of the first points' magnitudes, `B`, as all weights are positive; and so for each of `n`
/// levels: `3 U n B`. For the second `t` is a quotient, off by `D`, which moves each average by `D (|a| + |b|) <= 2 D M`, with `M` the largest number after the first. What that makes of
/// the curve is told by [`exact`].
fn part<T: Real>(points: &[[T; 4]], [from, to]: [T; 2]) -> Option<(Vec<[T; 4]>, f64)> {
    if from == T::ZERO && to == T::ONE {
        return Some((points.to_vec(), 0.0));
    }
    let mut d: Vec<([T; 4], [f64; 4])> = { points.iter() }
        .map(|p| (*p, p.map(T::magnitude)))
        .collect();
    let n = d.len();
    let blend = |(a, x): &([T; 4], [f64; 4]), (b, y): &([T; 4], [f64; 4]), t: T| {
        let rest = T::ONE - t;
        let (t64, rest64) = (t.magnitude(), rest.magnitude());
        (
            std::array::from_fn(|c| rest * a[c] + t * b[c]),
            std::array::from_fn(|c| rest64 * x[c] + t64 * y[c]),
        )
    };
    let (mut units, mut moved) = (0.0, [0.0f64; 4]);
    if to != T::ONE {
        // Level by level; each leaves its first point in place.
        for k in 1..n {
            for i in (k..n).rev() {
                d[i] = blend(&d[i - 1], &d[i], to);
            }
        }
        units += 3.0 * T::UNIT;
    }
    if from != T::ZERO {
        let t = if to == T::ONE { from } else { from / to };
        if to != T::ONE {
            for (_, size) in &d {
                for (m, x) in moved.iter_mut().zip(size) {
                    *m = m.max(2.0 * T::DIV_UNIT * x);
                }
            }
        }
        // Each leaves its last.
        for k in 1..n {
            for i in 0..n - k {
                d[i] = blend(&d[i], &d[i + 1], t);
            }
        }
        units += 3.0 * T::UNIT;
    }
    let levels = (n - 1) as f64;
    let known: Vec<[Ball<T>; 4]> = { d.iter() }
        .map(|(p, size)| {
            std::array::from_fn(|c| Ball {
                mid: p[c],
                rad: levels * (units * size[c] + moved[c] + 4.0 * TINY) * UP,
            })
        })
        .collect();
    exact(&known)
}

/// Numbers as f64, and a bound on how far all three together are off, where each is off by so much already.
fn rounded<T: Real>(e: [T; 3], radius: [f64; 3]) -> (Vector3<f64>, f64) {
    let v = Vector3::from_fn(|c, _| e[c].approximate());
    let radius = (0..3).map(|c| radius[c] + f64::EPSILON * v[c].abs());
    (v, radius.sum::<f64>() * UP)
}

/// Bounds of the parts of a vector along the unit vector nearest to `axis` and across it.
fn along_and_across(v: &Vector3<f64>, radius: f64, axis: &Vector3<f64>) -> ([f64; 2], f64) {
    let length = axis.norm();
    let height = v.dot(axis) / length;
    // Products, sums, a norm and a quotient: far fewer than 16 roundings of numbers no larger than |v|.
    let error = radius + 16.0 * f64::EPSILON * v.norm();
    let across = (v - axis * (height / length)).norm() + error;
    ([height - error, height + error], across * UP)
}

/// Whether a control polygon is monotone along an axis, and how far its steps lean from it at most.
fn lean<T: Real>(points: &[[T; 4]], axis: &Vector3<f64>) -> Option<f64> {
    let q = |p: &[T; 4]| -> [T; 3] { std::array::from_fn(|c| p[c] / p[3]) };
    let mut most: f64 = 0.0;
    let mut last = q(&points[0]);
    for p in &points[1..] {
        let next = q(p);
        // Two quotients and a difference.
        let error = std::array::from_fn(|c| {
            let both = last[c].magnitude() + next[c].magnitude();
            (T::DIV_UNIT + T::UNIT) * both * UP + 2.0 * TINY
        });
        let step = std::array::from_fn(|c| next[c] - last[c]);
        let (step, radius) = rounded(step, error);
        let (along, across) = along_and_across(&step, radius, axis);
        if !(along[0] > 0.0) {
            return None;
        }
        most = most.max(across / along[0] * UP);
        last = next;
    }
    Some(most)
}

/// The `e_k` and a bound of each one's error; `None` where `V W` is not proven to be positive or numbers overflow.
///
/// A term of `X W - Y V` is `x w - y v`, off by `2 U S` at most, where `S` bounds `|x w| + |y v|`: two products and a difference; and where `x` was moved to the other part's origin,
/// by a product and a sum, by what that is off, times `w`. A coefficient takes the shares of these that its terms have, and beyond them the error of [`Factors`] for the
/// largest of them: as terms of parts near each other are small, that is little. The same for `v w`, which is off by `U v w`.
fn differences<T: Real>(
    [a, b]: [&[[T; 4]]; 2],
    origins: [&[f64; 3]; 2],
    factors: &Factors<T>,
) -> Option<Vec<(Vector3<f64>, f64)>> {
    let shift: [Ball<T>; 3] =
        std::array::from_fn(|c| Ball::difference(origins[0][c], origins[1][c]));
    /// The coefficients, bounds of what their terms are off before they are added, and the largest terms.
    struct Sum<T> {
        of: [T; 4],
        before: [f64; 4],
        most: [f64; 4],
    }
    let none = || Sum {
        of: [T::ZERO; 4],
        before: [0.0; 4],
        most: [0.0; 4],
    };
    let mut sums: Vec<Sum<T>> = (1..a.len() + b.len()).map(|_| none()).collect();
    let sizes: Vec<[f64; 4]> = b.iter().map(|q| q.map(T::magnitude)).collect();
    for ((i, p), row) in a.iter().enumerate().zip(factors.shares.chunks(b.len())) {
        let v = p[3].magnitude();
        let x: [T; 3] = std::array::from_fn(|c| p[c] + shift[c].mid * p[3]);
        // Twice the unit of x, and what it is off by itself.
        let x_off: [f64; 3] = std::array::from_fn(|c| {
            let by = shift[c].mid.magnitude() * v;
            let moved = if by > 0.0 || shift[c].rad > 0.0 {
                T::UNIT * (by + x[c].magnitude()) + shift[c].rad * v + TINY
            } else {
                0.0
            };
            2.0 * T::UNIT * x[c].magnitude() + moved
        });
        for (((sum, q), size), share) in { sums[i..].iter_mut() }.zip(b).zip(&sizes).zip(row) {
            let part = share.magnitude();
            for c in 0..3 {
                let term = x[c] * q[3] - q[c] * p[3];
                sum.of[c] = sum.of[c] + *share * term;
                sum.before[c] += part * (x_off[c] * size[3] + 2.0 * T::UNIT * size[c] * v);
                sum.most[c] = sum.most[c].max(term.magnitude());
            }
            let term = p[3] * q[3];
            sum.of[3] = sum.of[3] + *share * term;
            sum.most[3] = sum.most[3].max(term.magnitude());
        }
    }
    // Each term has up to four products.
    let underflow = 4.0 * (factors.orders[0].min(factors.orders[1]) + 1) as f64 * TINY;
    let quotient = |sum: &Sum<T>| {
        let error: [f64; 4] = std::array::from_fn(|c| {
            let before = if c == 3 {
                T::UNIT * sum.most[3]
            } else {
                sum.before[c]
            };
            (before + factors.error * sum.most[c]) * UP + underflow
        });
        let both = sum.of[3].approximate() * (1.0 - f64::EPSILON) - error[3];
        if !(both > 0.0) {
            return None;
        }
        let e: [T; 3] = std::array::from_fn(|c| sum.of[c] / sum.of[3]);
        let radius = std::array::from_fn(|c| {
            let q = e[c].magnitude() * UP;
            (error[c] + q * error[3]) / both * UP + T::DIV_UNIT * q + TINY
        });
        let (v, r) = rounded(e, radius);
        (v.iter().all(|x| x.is_finite()) && r.is_finite()).then_some((v, r))
    };
    sums.iter().map(quotient).collect()
}

/// A bound of the distance within a pair, and how much of it is slack. `factors`: those of the last pair, used again where degrees are the same.
pub(super) fn bound<T: Real>(
    [a, b]: [&Stretch<T>; 2],
    from: [T; 2],
    to: [T; 2],
    factors: &mut Option<Factors<T>>,
) -> Option<(f64, f64)> {
    let (a_points, a_slack) = part(&a.points, [from[0], to[0]])?;
    let (b_points, b_slack) = part(&b.points, [from[1], to[1]])?;
    let curves = (a.slack + b.slack + a_slack + b_slack) * UP;
    let orders = [a_points.len(), b_points.len()];
    let factors = match factors {
        Some(f) if f.orders == orders => f,
        _ => factors.insert(Factors::new(orders)),
    };
    let e = differences([&a_points, &b_points], [&a.origin, &b.origin], factors)?;
    let slack = curves + e.iter().map(|(_, r)| *r).fold(0.0, f64::max);
    let direct = e.iter().map(|(v, r)| v.norm() + r).fold(0.0, f64::max) * UP;
    let chord = || {
        let last = a_points.len() - 1;
        Vector3::from_fn(|c, _| {
            let q = |i: usize| a_points[i][c] / a_points[i][3];
            (q(last) - q(0)).approximate()
        })
    };
    let sliced = || {
        let axis = chord();
        let length = axis.norm();
        if !(length > 0.0) {
            return None;
        }
        let axis = axis / length;
        lean(&a_points, &axis)?;
        let m = lean(&b_points, &axis)?;
        let (mut along, mut across, mut ends): (f64, f64, f64) = (0.0, 0.0, 0.0);
        for (k, (v, r)) in e.iter().enumerate() {
            let (height, off) = along_and_across(v, *r, &axis);
            let height = height[0].abs().max(height[1].abs());
            along = along.max(height);
            across = across.max(off);
            if k == 0 || k + 1 == e.len() {
                ends = ends.max(height);
            }
        }
        let across = (across + m * along) * UP;
        Some((across * across + ends * ends).sqrt() * UP)
    };
    let mut best = direct;
    if direct > NEAR_SLACK * slack
        && let Some(sliced) = sliced()
    {
        best = best.min(sliced);
    }
    let total = (best + curves) * UP;
    total.is_finite().then_some((total, slack))
}

#[cfg(test)]
mod tests {
    use super::super::compose::Products;
    use super::super::net::part_of;
    use super::*;
    use crate::numeric::Dd;
    use crate::numeric::bernstein::evaluate;
    use dashu_ratio::RBig as Q;
    use proptest::prelude::*;

    /// Control points `(X, w)` of a curve some way from the origin: far, that of two nearly equal ones little is left.
    fn curve(order: std::ops::Range<usize>) -> impl Strategy<Value = Vec<[f64; 4]>> {
        let point = (prop::array::uniform3(-1.0..1.0), 0.25..4.0);
        let far = prop::sample::select(vec![0.0, 1.0, 1000.0]);
        (prop::collection::vec(point, order), far).prop_map(|(points, far)| {
            let place = |(p, w): ([f64; 3], f64)| [w * (p[0] + far), w * p[1], w * p[2], w];
            points.into_iter().map(place).collect()
        })
    }

    fn balls<T: Real>(points: &[[f64; 4]]) -> Vec<[Ball<T>; 4]> {
        { points.iter() }.map(|p| p.map(Ball::exact)).collect()
    }

    fn list<T: Real>(points: &[[Ball<T>; 4]], c: usize) -> Vec<Ball<T>> {
        points.iter().map(|p| p[c]).collect()
    }

    /// A point of a curve.
    fn point(points: &[[Ball<Dd>; 4]], at: f64) -> [Ball<Dd>; 3] {
        let value = |c: usize| evaluate(list(points, c), Ball::exact(at));
        std::array::from_fn(|c| value(c) / value(3))
    }

    /// The coefficients of a difference, with bounds of their own.
    fn running<T: Real>([a, b]: [&[[f64; 4]]; 2], origins: [&[f64; 3]; 2]) -> Vec<[Ball<T>; 3]> {
        let [a, b] = [a, b].map(balls::<T>);
        let products = Products::<T>::new(a.len() - 1, b.len() - 1);
        let (v, w) = (list(&a, 3), list(&b, 3));
        let both = products.of(&v, &w);
        let differences: [Vec<Ball<T>>; 3] = std::array::from_fn(|c| {
            let shift = Ball::<T>::difference(origins[0][c], origins[1][c]);
            let x: Vec<_> = a.iter().map(|p| p[c] + shift * p[3]).collect();
            let (xw, yv) = (products.of(&x, &w), products.of(&v, &list(&b, c)));
            xw.iter().zip(&yv).map(|(p, q)| *p - *q).collect()
        });
        { 0..both.len() }
            .map(|k| std::array::from_fn(|c| differences[c][k] / both[k]))
            .collect()
    }

    fn q(x: f64) -> Q {
        Q::try_from(x).expect("a number")
    }

    fn magnitude(x: Q) -> Q {
        if x < Q::ZERO { -x } else { x }
    }

    /// In rationals: a curve that is zero where it is cut last. Its part's points, and so what their own roundings are, are small beside how far the curve goes, with which the quotient's
    /// error is multiplied.
    #[test]
    fn a_cut_at_a_quotient_is_off_by_what_the_quotient_is() {
        let mut noticed = 0;
        for k in 1..64u16 {
            // Quotients by 4093 have no end in binary digits.
            let (part_of_one, small) = (1.0 / 4096.0, 3.0 / 4096.0);
            let (from, to) = (1.0 - small - f64::from(k) * part_of_one, 1.0 - small);
            // `x(s) = to - s`.
            let points = [[to, 0.0, 0.0, 1.0], [-small, 0.0, 0.0, 1.0]];
            let (found, slack) = part(&points, [from, to]).unwrap();
            let off = |p: &[f64; 4], s: f64| magnitude(q(p[0]) / q(p[3]) - (q(to) - q(s)));
            let off = off(&found[0], from).max(off(&found[1], to));
            assert!(off <= q(slack), "{k}: {slack:e}");
            // Without the quotient's: six units of numbers up to `k part_of_one + 2 small`, and of weights of one no farther out.
            let rest = 12.0 * f64::UNIT * (f64::from(k) * part_of_one + 2.0 * small);
            noticed += usize::from(off > q(rest));
        }
        assert!(noticed > 0);
    }

    /// In rationals: of a coefficient the first and the last term cancel, and what is between is lost in the first, each by less than half a digit, but more of them than products are
    /// rounded.
    #[test]
    fn sums_of_products_are_off_by_their_additions() {
        const ORDER: usize = 16;
        let degree = ORDER - 1;
        let row = |n: usize| {
            let mut row = vec![Q::ONE];
            for k in 1..=n {
                row.push(&row[k - 1] * Q::from(n + 1 - k) / Q::from(k));
            }
            row
        };
        let (single, double) = (row(degree), row(2 * degree));
        let share = |i: usize, j: usize| &single[i] * &single[j] / &double[i + j];
        let weight = |i: usize| share(i, degree - i);
        // Times its share each is 5/4, -5/4 or 9/10 of half a digit of that.
        let x: Vec<f64> = { 0..ORDER }
            .map(|i| {
                let term = match i {
                    0 => 1.25,
                    _ if i == degree => -1.25,
                    _ => 0.9 * f64::UNIT,
                };
                (q(term) / weight(i)).to_f64().value()
            })
            .collect();
        let a: Vec<[f64; 4]> = x.iter().map(|x| [*x, 0.0, 0.0, 1.0]).collect();
        let b = [[0.0, 0.0, 0.0, 1.0]; ORDER];
        let origin = [0.0; 3];
        let factors = Factors::new([ORDER; 2]);
        let found = differences([&a, &b], [&origin, &origin], &factors).unwrap();
        for (k, (e, radius)) in found.iter().enumerate() {
            let terms =
                { k.saturating_sub(degree)..=k.min(degree) }.map(|i| q(x[i]) * share(i, k - i));
            let truth = terms.fold(Q::ZERO, |sum, term| sum + term);
            let off = magnitude(q(e[0]) - truth);
            assert!(off <= q(*radius), "{k}: {radius:e}");
        }
    }

    /// Double-double is off by so much at most: its unit, 1e-32, of numbers up to 4000, a few dozen times, over weights from 1/4.
    const FINE: f64 = 1e-24;
    /// How far curves that are nearly equal are apart.
    const NEARLY: f64 = 1e-9;
    /// Bounds are at most so many times what running bounds are.
    const LOOSER: f64 = 64.0;

    proptest! {
        /// With as many bits again the cut is exact for what is tested.
        #[test]
        fn parts_are_off_by_less_than_they_say(
            points in curve(2..9), (x, y) in (0.125..1.0, 0.125..1.0), ends in 0usize..4,
        ) {
            let from = if ends & 1 == 1 { 0.0 } else { f64::min(x, y) };
            let to = if ends & 2 == 2 { 1.0 } else { f64::max(x, y) };
            let (found, slack) = part(&points, [from, to]).unwrap();
            let truth = part_of(&balls(&points), [Dd::from(from), Dd::from(to)]);
            let found_balls = balls::<Dd>(&found);
            for at in [0.0, 0.125, 0.5, 0.75, 1.0] {
                let [p, q] = [&found_balls, &truth].map(|x| point(x, at));
                let off = Vector3::from_fn(|c, _| (p[c] - q[c]).magnitude()).norm();
                prop_assert!(off <= slack + FINE, "{off:e} {slack:e}");
            }
            let (_, running) = exact(&part_of(&balls::<f64>(&points), [from, to])).unwrap();
            prop_assert!(slack <= LOOSER * running, "{slack:e} {running:e}");
        }

        #[test]
        fn coefficients_are_off_by_less_than_they_say(
            a in curve(1..8), b in curve(1..8), near in 0.0f64..1.0, origin in prop::array::uniform3(-8.0..8.0),
        ) {
            // Nearly the same curve half of the time, where it may be.
            let b = if near < 0.5 {
                a.iter().map(|p| [p[0] + near * NEARLY, p[1], p[2], p[3]]).collect()
            } else {
                b
            };
            let origins = [&origin, &[0.25, 0.1, -7.0]];
            let found = differences([&a, &b], origins, &Factors::new([a.len(), b.len()])).unwrap();
            let truth = running::<Dd>([&a, &b], origins);
            let running = running::<f64>([&a, &b], origins);
            for (((e, radius), truth), running) in found.iter().zip(&truth).zip(&running) {
                let off = Vector3::from_fn(|c, _| (truth[c] - Ball::exact(e[c])).magnitude()).norm();
                prop_assert!(off <= *radius, "{off:e} {radius:e}");
                let running: f64 = running.iter().map(|x| x.rad).sum();
                prop_assert!(*radius <= LOOSER * running, "{radius:e} {running:e}");
            }
        }
    }
}
