//! Points and derivatives of a net by Bernstein polynomials, without allocation: plain f64 with an a priori bound, and
//! values in double-double.
//!
//! # Bounds
//! `u = 2^-53`, `s` and `t` in [0, 1] are exact numbers. The recurrence for the Bernstein polynomials adds
//! and multiplies only what is not negative, three roundings a level (`1 - t` among them), so each of degree `p` is
//! off by at most `3 p` roundings, *relatively*. Their sum is 1. With degrees `p`, `q` and coefficients of magnitude at
//! most `A`, known within `rho`:
//!
//! - *Value.* `sum b_i b_j P_ij` meets `3 p + 3 q` roundings from the polynomials, two from products and `p + q` from
//!   additions: off by at most `(4 (p + q) + 2) u A + rho`. Nor is it off by more than that for `A` and `rho` in parts of the weights (no
//!   `|P_ij| > A w_ij`) times the weight at the point, which is the same sum of the `w_ij`: far less where weights differ and that is small.
//! - *Slope.* The derivative of `b_i` is `p (b_(i-1) - b_i)` of degree `p - 1`: two more roundings, relative to
//!   `p (b_(i-1) + b_i)`, and the sum over i of these is `2 p`. So a slope along u is off by at most
//!   `2 p ((4 (p + q) + 4) u A + rho)`; along v with `q` for `p` in front.
//!
//! [`UNITS`] more cover what is of second order, for `p + q` far below 2^40.

use super::Net;
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, Dd, Real, TINY, two_prod, two_sum};

/// Above this degree these functions are not used.
const MAX_DEGREE: usize = 19;
const ROOM: usize = MAX_DEGREE + 1;
/// Roundings added for terms of second order.
const UNITS: usize = 4;

/// Whether a net's degrees are within what is done here.
pub(crate) fn fits(degree: Bidegree) -> bool {
    degree.u <= MAX_DEGREE && degree.v <= MAX_DEGREE
}

/// The Bernstein polynomials of degree `p < N` at `t`, and their first and second derivatives.
struct Basis<const N: usize> {
    value: [f64; N],
    slope: [f64; N],
    curvature: [f64; N],
}

/// One level up: `b_i = (1 - t) b_i + t b_(i-1)`; `k` is the degree so far.
#[inline(always)]
fn raise<const N: usize>(b: &mut [f64; N], k: usize, t: f64, s: f64) {
    let mut carry = 0.0;
    for x in &mut b[..=k] {
        let old = *x;
        *x = carry + s * old;
        carry = t * old;
    }
    b[k + 1] = carry;
}

impl<const N: usize> Basis<N> {
    /// `p` is below `N`; `orders` of derivatives are wanted.
    #[inline(always)]
    fn new(p: usize, t: f64, orders: usize) -> Self {
        let s = 1.0 - t;
        let mut b = [0.0; N];
        b[0] = 1.0;
        let mut out = Self {
            value: [0.0; N],
            slope: [0.0; N],
            curvature: [0.0; N],
        };
        for k in 0..=p {
            // Here b holds degree k.
            if k + 2 == p && orders > 1 {
                let f = (p * (p - 1)) as f64;
                for i in 0..=k {
                    let x = f * b[i];
                    out.curvature[i] += x;
                    out.curvature[i + 1] -= 2.0 * x;
                    out.curvature[i + 2] += x;
                }
            }
            if k + 1 == p && orders > 0 {
                let f = p as f64;
                out.slope[0] = -(f * b[0]);
                for i in 1..=k {
                    out.slope[i] = f * (b[i - 1] - b[i]);
                }
                out.slope[p] = f * b[k];
            }
            if k < p {
                raise(&mut b, k, t, s);
            }
        }
        out.value = b;
        out
    }
}

#[inline(always)]
fn add<const N: usize>(sum: &mut [f64; N], factor: f64, p: &[f64; N]) {
    for c in 0..N {
        sum[c] += factor * p[c];
    }
}

/// The first term of a sum.
#[inline(always)]
fn times<const N: usize>(factor: f64, p: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|c| factor * p[c])
}

/// A row of coefficients, each with its weight.
#[inline(always)]
fn row_sum<const N: usize, const C: usize>(row: &[[f64; C]], weights: &[f64; N]) -> [f64; C] {
    let Some((first, rest)) = row.split_first() else {
        return [0.0; C];
    };
    let mut sum = times(weights[0], first);
    for (p, w) in rest.iter().zip(&weights[1..]) {
        add(&mut sum, *w, p);
    }
    sum
}

/// Calls a function of `(net, p, q, s, t)` with small degrees as constants, so that its loops are unrolled, or one for curves, of `(net, p, s)`: the
/// same operations in the same order for all.
macro_rules! by_degree {
    ($of:ident, $of_curve:ident, $net:expr, $s:expr, $t:expr) => {
        match ($net.degree.u, $net.degree.v) {
            (1, 1) => $of::<4>($net, 1, 1, $s, $t),
            (2, 1) => $of::<4>($net, 2, 1, $s, $t),
            (3, 1) => $of::<4>($net, 3, 1, $s, $t),
            (2, 2) => $of::<4>($net, 2, 2, $s, $t),
            (3, 3) => $of::<4>($net, 3, 3, $s, $t),
            (p, 0) if p < 8 => $of_curve::<8>($net, p, $s),
            (p, 0) if p < 16 => $of_curve::<16>($net, p, $s),
            (p, 0) => $of_curve::<ROOM>($net, p, $s),
            (p, q) if p < 4 && q < 4 => $of::<4>($net, p, q, $s, $t),
            (p, q) => $of::<ROOM>($net, p, q, $s, $t),
        }
    };
}

/// Value, `_s`, `_t`, `_ss`, `_st`, `_tt` of the homogeneous point, without a bound.
pub(crate) fn jet2(net: &Net<f64>, s: f64, t: f64) -> [[f64; 4]; 6] {
    by_degree!(jet2_of, jet2_of_curve, net, s, t)
}

#[inline(always)]
fn jet2_of_curve<const N: usize>(net: &Net<f64>, p: usize, s: f64) -> [[f64; 4]; 6] {
    let b = Basis::<N>::new(p, s, 2);
    let mut out = [[0.0; 4]; 6];
    for (i, p) in net.plain().iter().enumerate() {
        add(&mut out[0], b.value[i], p);
        add(&mut out[1], b.slope[i], p);
        add(&mut out[3], b.curvature[i], p);
    }
    out
}

#[inline(always)]
fn jet2_of<const N: usize>(net: &Net<f64>, p: usize, q: usize, s: f64, t: f64) -> [[f64; 4]; 6] {
    let (bu, bv) = (Basis::<N>::new(p, s, 2), Basis::<N>::new(q, t, 2));
    let mut out = [[0.0; 4]; 6];
    for (i, row) in net.plain().chunks_exact(q + 1).enumerate() {
        // Written out: `map` is not inlined.
        let r = [
            row_sum(row, &bv.value),
            row_sum(row, &bv.slope),
            row_sum(row, &bv.curvature),
        ];
        add(&mut out[0], bu.value[i], &r[0]);
        add(&mut out[1], bu.slope[i], &r[0]);
        add(&mut out[2], bu.value[i], &r[1]);
        add(&mut out[3], bu.curvature[i], &r[0]);
        add(&mut out[4], bu.slope[i], &r[1]);
        add(&mut out[5], bu.value[i], &r[2]);
    }
    out
}

/// The homogeneous point alone, without a bound.
pub(crate) fn value(net: &Net<f64>, s: f64, t: f64) -> [f64; 4] {
    by_degree!(value_of, value_of_curve, net, s, t)
}

#[inline(always)]
fn value_of_curve<const N: usize>(net: &Net<f64>, p: usize, s: f64) -> [f64; 4] {
    let b = Basis::<N>::new(p, s, 0);
    let mut out = [0.0; 4];
    for (i, p) in net.plain().iter().enumerate() {
        add(&mut out, b.value[i], p);
    }
    out
}

#[inline(always)]
fn value_of<const N: usize>(net: &Net<f64>, p: usize, q: usize, s: f64, t: f64) -> [f64; 4] {
    let (bu, bv) = (Basis::<N>::new(p, s, 0), Basis::<N>::new(q, t, 0));
    let mut out = [0.0; 4];
    for (i, row) in net.plain().chunks_exact(q + 1).enumerate() {
        add(&mut out, bu.value[i], &row_sum(row, &bv.value));
    }
    out
}

/// What the weight at a point is not above: it was computed up to so many roundings of itself, and the net's errors.
fn weight_below<T>(net: &Net<T>, computed: f64, units: f64) -> f64 {
    let off = units + net.blur[3];
    if net.unit_weights {
        1.0
    } else if off <= 0.25 {
        computed * (1.0 + 2.0 * off + 4.0 * f64::EPSILON)
    } else {
        f64::INFINITY
    }
}

/// Value, `_s` and `_t` of the homogeneous point, without a bound.
pub(crate) fn jet1(net: &Net<f64>, s: f64, t: f64) -> [[f64; 4]; 3] {
    by_degree!(jet1_of, jet1_of_curve, net, s, t)
}

#[inline(always)]
fn jet1_of_curve<const N: usize>(net: &Net<f64>, p: usize, s: f64) -> [[f64; 4]; 3] {
    let b = Basis::<N>::new(p, s, 1);
    let mut out = [[0.0; 4]; 3];
    for (i, p) in net.plain().iter().enumerate() {
        add(&mut out[0], b.value[i], p);
        add(&mut out[1], b.slope[i], p);
    }
    out
}

#[inline(always)]
fn jet1_of<const N: usize>(net: &Net<f64>, p: usize, q: usize, s: f64, t: f64) -> [[f64; 4]; 3] {
    sums_of::<N, 4>(net.plain(), p, q, s, t)
}

/// Value, `_s` and `_t` of two polynomials at once, given pairs of their coefficients, without a bound.
pub(crate) fn pair_jet1(pairs: &[[f64; 2]], degree: Bidegree, s: f64, t: f64) -> [[f64; 2]; 3] {
    match (degree.u, degree.v) {
        (1, 1) => sums_of::<4, 2>(pairs, 1, 1, s, t),
        (2, 1) => sums_of::<4, 2>(pairs, 2, 1, s, t),
        (3, 1) => sums_of::<4, 2>(pairs, 3, 1, s, t),
        (2, 2) => sums_of::<4, 2>(pairs, 2, 2, s, t),
        (3, 3) => sums_of::<4, 2>(pairs, 3, 3, s, t),
        (p, q) if p < 4 && q < 4 => sums_of::<4, 2>(pairs, p, q, s, t),
        (p, q) => sums_of::<ROOM, 2>(pairs, p, q, s, t),
    }
}

/// By how much such a value may be off, in parts of the largest coefficient, for `s` and `t` in [0, 1].
pub(crate) fn pair_error(degree: Bidegree) -> f64 {
    (4 * (degree.u + degree.v) + 2 + UNITS) as f64 * f64::UNIT
}

#[inline(always)]
fn sums_of<const N: usize, const C: usize>(
    net: &[[f64; C]],
    p: usize,
    q: usize,
    s: f64,
    t: f64,
) -> [[f64; C]; 3] {
    let (bu, bv) = (Basis::<N>::new(p, s, 1), Basis::<N>::new(q, t, 1));
    let mut sums = [[0.0; C]; 3];
    for (i, row) in net.chunks_exact(q + 1).enumerate() {
        let r = [row_sum(row, &bv.value), row_sum(row, &bv.slope)];
        add(&mut sums[0], bu.value[i], &r[0]);
        add(&mut sums[1], bu.slope[i], &r[0]);
        add(&mut sums[2], bu.value[i], &r[1]);
    }
    sums
}

/// The relative roundings of values and slopes.
fn units(net: &Net<f64>) -> f64 {
    (4 * (net.degree.u + net.degree.v) + 4 + UNITS) as f64 * f64::UNIT
}

/// The bound of a radius that was computed in a few operations, what underflows included.
fn rounded_up(rad: f64) -> f64 {
    rad * (1.0 + 8.0 * f64::EPSILON) + TINY
}

/// A value with its bound.
fn bounded(net: &Net<f64>, value: [f64; 4]) -> [Ball<f64>; 4] {
    let units = units(net);
    let weight = weight_below(net, value[3], units);
    std::array::from_fn(|c| {
        if c == 3 && net.unit_weights {
            return Ball::ONE;
        }
        Ball {
            mid: value[c],
            rad: rounded_up((units * net.reach[c] + net.blur[c]) * weight),
        }
    })
}

/// The homogeneous point with bounds, for `s` and `t` in [0, 1].
pub(crate) fn point(net: &Net<f64>, s: f64, t: f64) -> [Ball<f64>; 4] {
    bounded(net, value(net, s, t))
}

/// The homogeneous point, its `_s` and its `_t` with bounds, for `s` and `t` in [0, 1].
pub(crate) fn jet(net: &Net<f64>, s: f64, t: f64) -> [[Ball<f64>; 4]; 3] {
    let [value, along_s, along_t] = jet1(net, s, t);
    let units = units(net);
    let slope = |degree: usize, sums: [f64; 4]| {
        std::array::from_fn(|c| {
            if c == 3 && net.unit_weights {
                return Ball::ZERO;
            }
            let rad = 2.0 * degree as f64 * (units * net.largest[c] + net.spread[c]);
            Ball {
                mid: sums[c],
                rad: rounded_up(rad),
            }
        })
    };
    [
        bounded(net, value),
        slope(net.degree.u, along_s),
        slope(net.degree.v, along_t),
    ]
}

/// The Bernstein polynomials `C(p, i) s^(p-i) t^i` of degree `p` at a double-double `t` in [0, 1], `s = 1 - t`.
///
/// `s` is rounded once, which counts `p` times at most; its powers and those of `t` take at most `p - 1` products each, of which `b_i`
/// has at most `p - 2` in all for `0 < i < p`; then come their product and that with the binomial, a f64 exactly. All factors are
/// positive, so each polynomial is off by at most `p + p + 1` units, relatively: no more than `4 p`.
#[inline(always)]
fn fine_basis<const N: usize>(p: usize, t: Dd) -> [Dd; N] {
    let s = Dd::ONE - t;
    let mut b = [Dd::ONE; N];
    // b_i = t^i.
    for i in 1..=p {
        b[i] = if i == 1 { t } else { b[i - 1] * t };
    }
    let (mut power, mut binomial) = (s, 1.0);
    for i in (0..p).rev() {
        // Here `power` is s^(p - i), and C(p, i) = C(p, i + 1) (i + 1) / (p - i), exactly.
        binomial = binomial * (i + 1) as f64 / (p - i) as f64;
        let own = if i == 0 { power } else { b[i] * power };
        b[i] = if binomial == 1.0 {
            own
        } else {
            own * Dd::from(binomial)
        };
        if i > 0 {
            power = power * s;
        }
    }
    b
}

/// The homogeneous point in double-double; `None` for points that may be outside of the unit square, and degrees that do not fit.
///
/// The sum over all `n` coefficients is a compensated dot product (T. Ogita, S. Rump, S. Oishi, *Accurate sum and dot product*,
/// SISC 26 (2005), algorithm 5.3, with factors that are double-doubles themselves). With `b = b_i b_j` and `P` split in
/// high and low parts: `b_h P_h = h + r` exactly, the sum of all `h` is `sigma + sum z` exactly, and what is added to `e` is
/// `z + (r + (b_h P_l + b_l P_h))`. Magnitudes: `|r|, |b_h P_l|, |b_l P_h| <= u |b P|`, `|z| <= u S` with `S = sum |b P| <= A`; so
/// all terms of `e` together are at most `(n + 3) u S`, and each passes at most `n + 4` roundings: off by
/// `(n + 4)(n + 3) u^2 S`. Left out is `b_l P_l`, at most `u^2 S` in all. Products `b_i b_j` are off by `4 (p + q) + 1` units of
/// double-double, relatively. A parameter known within `r` moves the point by at most `2 p r A` (a slope is `p` times a mean of
/// differences).
pub(crate) fn fine_value(net: &Net<Dd>, local: [Ball<Dd>; 2]) -> Option<[Ball<Dd>; 4]> {
    let [s, t] = local;
    let within = |x: Ball<Dd>| x.mid >= Dd::ZERO && x.mid <= Dd::ONE;
    if !(fits(net.degree) && within(s) && within(t)) {
        return None;
    }
    let (p, q) = (net.degree.u, net.degree.v);
    let [sums, rests] = by_degree!(fine_sums_of, fine_sums_of_curve, net, s.mid, t.mid);
    let n = net.points.len() as f64;
    // Second order: n u is far below one.
    let compensated = 1.01 * ((n + 4.0) * (n + 3.0) + 1.0) * (f64::UNIT * f64::UNIT);
    let moved = 2.0 * (p as f64 * s.rad + q as f64 * t.rad);
    let still = compensated + (4 * (p + q) + 1 + UNITS) as f64 * Dd::UNIT;
    let weight = weight_below(net, sums[3] + rests[3], still + f64::UNIT);
    Some(std::array::from_fn(|c| {
        if c == 3 && net.unit_weights {
            return Ball::ONE;
        }
        let near = still * (net.reach[c] + net.blur[c]) + net.blur[c];
        let rad = near * weight + moved * (net.largest[c] + net.spread[c]);
        Ball {
            mid: Dd::new(sums[c], rests[c]),
            rad: rad * (1.0 + 16.0 * f64::EPSILON) + TINY * n,
        }
    }))
}

/// What [`fine_value`] adds up: sums, and what they left.
#[inline(always)]
fn fine_sums_of<const N: usize>(net: &Net<Dd>, p: usize, q: usize, s: Dd, t: Dd) -> [[f64; 4]; 2] {
    let (bu, bv) = (fine_basis::<N>(p, s), fine_basis::<N>(q, t));
    let (mut sums, mut rests) = ([0.0; 4], [0.0; 4]);
    let coordinates = if net.unit_weights { 3 } else { 4 };
    for (i, row) in net.points.chunks_exact(q + 1).enumerate() {
        for (j, p) in row.iter().enumerate() {
            add_fine(&mut sums, &mut rests, bu[i] * bv[j], &p[..coordinates]);
        }
    }
    [sums, rests]
}

#[inline(always)]
fn fine_sums_of_curve<const N: usize>(net: &Net<Dd>, p: usize, s: Dd) -> [[f64; 4]; 2] {
    let b = fine_basis::<N>(p, s);
    let (mut sums, mut rests) = ([0.0; 4], [0.0; 4]);
    let coordinates = if net.unit_weights { 3 } else { 4 };
    for (i, p) in net.points.iter().enumerate() {
        add_fine(&mut sums, &mut rests, b[i], &p[..coordinates]);
    }
    [sums, rests]
}

#[inline(always)]
fn add_fine(sums: &mut [f64; 4], rests: &mut [f64; 4], b: Dd, p: &[Ball<Dd>]) {
    for (c, x) in p.iter().enumerate() {
        let x = x.mid;
        let (h, r) = two_prod(b.hi, x.hi);
        let (sum, z) = two_sum(sums[c], h);
        sums[c] = sum;
        rests[c] += z + (r + (b.hi * x.lo + b.lo * x.hi));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Ball;

    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    fn nets(p: usize, q: usize, seed: &mut u64) -> (Net<f64>, Net<Dd>) {
        let degree = Bidegree { u: p, v: q };
        let mut fine = Vec::new();
        for _ in 0..degree.count() {
            let w = if seed.is_multiple_of(3) {
                1.0
            } else {
                10f64.powf(4.0 * random(seed) - 2.0)
            };
            let x = |seed: &mut u64| {
                Dd::new(w * (random(seed) - 0.5), 1e-17 * w * (random(seed) - 0.5))
            };
            let p: [Dd; 4] = [x(seed), x(seed), x(seed), Dd::from(w)];
            fine.push(p.map(|mid| Ball { mid, rad: 0.0 }));
        }
        let coarse = fine
            .iter()
            .map(|p| p.map(|b: Ball<Dd>| Ball::from_dd(b.mid, 0.0)))
            .collect();
        (
            Net::new(degree, coarse, [0.0; 3]),
            Net::new(degree, fine, [0.0; 3]),
        )
    }

    /// What is computed here holds what running bounds on de Casteljau's algorithm in double-double hold.
    #[test]
    fn bounds_hold() {
        let mut seed = 0x853c_49e6_748f_ea9b;
        for (p, q) in [
            (1, 1),
            (2, 2),
            (3, 3),
            (2, 5),
            (15, 15),
            (7, 0),
            (1, 0),
            (0, 3),
        ] {
            for k in 0..200 {
                let (coarse, fine) = nets(p, q, &mut seed);
                let at = |seed: &mut u64| match k % 4 {
                    0 => (random(seed) < 0.5).into(),
                    1 => random(seed) * 1e-12,
                    _ => random(seed),
                };
                let (s, t) = (at(&mut seed), if q == 0 { 0.0 } else { at(&mut seed) });
                let truth = fine.jet(Ball::exact(s), Ball::exact(t));
                // A place known less exactly: the bound must reach back to the true one.
                let off = [s, t].map(|x| {
                    let rad = if k % 3 == 0 { 1e-25 } else { 0.0 };
                    let moved = Dd::new(x, if x < 1.0 { 0.9 * rad } else { -0.9 * rad });
                    Ball { mid: moved, rad }
                });
                let off = if q == 0 { [off[0], Ball::ZERO] } else { off };
                let value = fine_value(&fine, off).unwrap();
                let rough = jet(&coarse, s, t);
                let plain = jet2(&coarse, s, t);
                for c in 0..4 {
                    let holds = |x: Ball<Dd>, y: Ball<Dd>, more: f64| {
                        assert!(
                            (x.mid - y.mid).magnitude() <= x.rad * more + y.rad,
                            "{x:?} {y:?} {p} {q}"
                        );
                    };
                    holds(value[c], truth.value[c], 1.0);
                    if c < 2 {
                        let pairs: Vec<[f64; 2]> =
                            coarse.plain().iter().map(|p| [p[0], p[1]]).collect();
                        let plain = pair_jet1(&pairs, coarse.degree, s, t)[0][c];
                        let rad = pair_error(coarse.degree) * coarse.largest[c] + coarse.spread[c];
                        let plain = Ball {
                            mid: Dd::from(plain),
                            rad,
                        };
                        holds(plain, truth.value[c], 1.0);
                    }
                    for (x, y) in rough.iter().zip([truth.value, truth.s, truth.t]) {
                        holds(
                            Ball {
                                mid: Dd::from(x[c].mid),
                                rad: x[c].rad,
                            },
                            y[c],
                            1.0,
                        );
                    }
                    for (x, y) in plain.iter().zip(&rough) {
                        // Unit weights are known without rounding.
                        let rad = if y[c].rad == 0.0 { 1e-14 } else { y[c].rad };
                        assert!((x[c] - y[c].mid).abs() <= 2.0 * rad);
                    }
                }
            }
        }
    }
}
