//! A box of the search: part of a patch or of a boundary piece.

use crate::numeric::bernstein::{
    Bidegree, by_width, greater, keep_part, largest, lesser, part_error, split_error, split_off,
};
use crate::numeric::{Dd, Real, TINY};
use crate::prepare::Quotient;

/// `f = N / C` on a box `[u] x [v]` of a patch's local square (a curve has `degree.v = 0`; a dimension
/// that was collapsed onto a border has degree 0 and `u[0] = u[1]`).
#[derive(Clone, Debug)]
pub(crate) struct Node<T> {
    pub(crate) f: Quotient<T>,
    pub(crate) u: [f64; 2],
    pub(crate) v: [f64; 2],
    /// Proven: `f >= lo` on the box.
    pub(crate) lo: Dd,
    /// No computed coefficient of `N` is larger than this part of the true one of `C`. Not kept where `C` is 1.
    most: f64,
}

/// What is proven about `G = N - tau C` on a node, in coordinates that run over the node from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// The sign of `f`'s derivative along each direction, where it is proven not to vanish.
    pub(crate) monotone: [i8; 2],
    /// Whether `f` provably has no minimum along each direction but at the ends of the box.
    pub(crate) capped: [bool; 2],
    /// The least eigenvalue of the Hessian of `G` is at least this.
    pub(crate) convexity: f64,
    /// Its norm is at most this.
    pub(crate) curvature: f64,
    /// `|grad C|` is at most this.
    pub(crate) c_slope: f64,
    /// Ranges of `C`.
    pub(crate) c_range: [f64; 2],
    /// Bound on the error of a coefficient of `G`.
    pub(crate) g_error: f64,
    /// The largest of them.
    pub(crate) g_largest: f64,
    /// Largest second difference of `G` in each direction: where to split.
    pub(crate) bend: [f64; 2],
}

/// Makes up for the rounding of a bound that is computed in a few f64 operations.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;
const DOWN: f64 = 1.0 - 32.0 * f64::EPSILON;

/// The least and the greatest of some numbers.
struct Span {
    low: f64,
    high: f64,
}

impl Span {
    const NONE: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    #[inline(always)]
    fn take(&mut self, x: f64) {
        self.low = lesser(self.low, x);
        self.high = greater(self.high, x);
    }

    fn ends(&self) -> (f64, f64) {
        (self.low, self.high)
    }
}

impl<T: Real> Node<T> {
    /// The whole square (or, for a curve, the whole interval).
    pub(crate) fn root(f: Quotient<T>, squared: bool) -> Self {
        let v = if f.degree.v == 0 {
            [0.0, 0.0]
        } else {
            [0.0, 1.0]
        };
        Self::over(f, [0.0, 1.0], v, squared)
    }

    /// A box.
    pub(crate) fn over(f: Quotient<T>, u: [f64; 2], v: [f64; 2], squared: bool) -> Self {
        let (lo, most) = (Dd::from(f64::NEG_INFINITY), 0.0);
        let mut node = Self { f, u, v, lo, most };
        node.take_bounds(squared);
        node
    }

    /// Finds `most`, and `lo` if it is above what is known.
    ///
    /// `f = sum n_ij B_ij / sum c_ij B_ij` with `c_ij > 0` is a convex combination of the `n_ij / c_ij`, thus at least their minimum. With
    /// the true `c` of a coefficient, the computed ones are `n` and `c (1 + d)`, `|d| <= c_error`, and the true `n` is no less than `n -
    /// n_error c`. (None is infinite or no number: coordinates and weights are [far enough](crate::brep::LARGEST_COORDINATE) from what their
    /// squares overflow at.) So the true quotient is no less than `(n / c)_computed (1 + d) - n_error`; the least is that of the least.
    fn take_bounds(&mut self, squared: bool) {
        let (lo, most) = self.bounds(squared);
        self.most = most;
        if lo > self.lo {
            self.lo = lo;
        }
    }

    fn bounds(&self, squared: bool) -> (Dd, f64) {
        let unknown = if squared {
            Dd::ZERO
        } else {
            Dd::from(f64::NEG_INFINITY)
        };
        let Some((first, rest)) = self.f.n.split_first() else {
            return (unknown, 0.0);
        };
        let lesser = |a: T, b: T| if b < a { b } else { a };
        let (mut q, mut most) = (*first, 0.0);
        if self.f.c.is_empty() {
            q = rest.iter().fold(q, |q, n| lesser(q, *n));
        } else {
            if !self.f.is_proper() {
                return (unknown, f64::INFINITY);
            }
            q = q / self.f.c[0];
            most = q.approximate().abs();
            for (n, c) in rest.iter().zip(&self.f.c[1..]) {
                let own = *n / *c;
                q = lesser(q, own);
                most = greater(most, own.approximate().abs());
            }
        }
        // The rounding of `approximate` and of the quotient, and what `C` is off.
        let most = most * (1.0 + 2.0 * self.f.c_error + 32.0 * T::DIV_UNIT) * UP;
        let rounding = if self.f.c.is_empty() {
            0.0
        } else {
            8.0 * T::DIV_UNIT + self.f.c_error
        };
        let slack = rounding * q.magnitude() + self.f.n_error;
        let (lo, rest) = q.to_dd();
        let lo = lo - Dd::from((slack + rest) * UP);
        let lo = lo - Dd::from(4.0 * Dd::UNIT * q.magnitude());
        if lo > unknown {
            (lo, most)
        } else {
            (unknown, most)
        }
    }

    /// Which quotient of coefficients is the smallest.
    fn least_index(&self) -> usize {
        let mut best = (f64::INFINITY, 0);
        for (i, n) in self.f.n.iter().enumerate() {
            let q = match self.f.c.get(i) {
                Some(c) => n.approximate() / c.approximate(),
                None => n.approximate(),
            };
            if q < best.0 {
                best = (q, i);
            }
        }
        best.1
    }

    /// The smallest quotient of coefficients, nearly.
    pub(crate) fn least_quotient(&self) -> T {
        let i = self.least_index();
        match (self.f.n.get(i), self.f.c.get(i)) {
            (Some(n), Some(c)) => *n / *c,
            (Some(n), None) => *n,
            (None, _) => T::ZERO,
        }
    }

    /// The position of the smallest quotient of coefficients: a first guess of the minimum.
    pub(crate) fn guess(&self) -> [f64; 2] {
        let width = self.f.degree.v + 1;
        let best = self.least_index();
        let at = |range: [f64; 2], k: usize, degree: usize| {
            if degree == 0 {
                range[0]
            } else {
                range[0] + (range[1] - range[0]) * (k as f64 / degree as f64)
            }
        };
        [
            at(self.u, best / width, self.f.degree.u),
            at(self.v, best % width, self.f.degree.v),
        ]
    }

    /// Differences of first order along u (or v): `(min, max)` over the box.
    fn differences(c: &[T], degree: Bidegree, along_u: bool) -> (f64, f64) {
        let width = degree.v + 1;
        let mut out = Span::NONE;
        if along_u {
            for (a, b) in c.iter().zip(&c[width..]) {
                out.take((*b - *a).approximate());
            }
        } else {
            by_width!(c, width, rows, {
                for row in rows {
                    for (a, b) in row.iter().zip(&row[1..]) {
                        out.take((*b - *a).approximate());
                    }
                }
            });
        }
        out.ends()
    }

    /// Second differences: `(min, max)` of `_uu`, `_uv` or `_vv`.
    fn second_differences(c: &[T], degree: Bidegree, du: usize, dv: usize) -> (f64, f64) {
        let width = degree.v + 1;
        if degree.u < du || degree.v < dv {
            return (0.0, 0.0);
        }
        let mut out = Span::NONE;
        match (du, dv) {
            (2, 0) => {
                let rows = c.iter().zip(&c[width..]).zip(&c[2 * width..]);
                for ((x, y), z) in rows {
                    out.take(((*x - *y) - (*y - *z)).approximate());
                }
            }
            (0, 2) => {
                by_width!(c, width, rows, {
                    for row in rows {
                        for ((x, y), z) in row.iter().zip(&row[1..]).zip(&row[2..]) {
                            out.take(((*x - *y) - (*y - *z)).approximate());
                        }
                    }
                });
            }
            _ => {
                by_width!(c, width, rows, {
                    for (low, high) in rows.clone().zip(rows.skip(1)) {
                        let pairs = low.iter().zip(&low[1..]).zip(high.iter().zip(&high[1..]));
                        for ((a, b), (d, e)) in pairs {
                            out.take(((*a - *d) - (*b - *e)).approximate());
                        }
                    }
                });
            }
        }
        out.ends()
    }

    /// The mean of the Hessian of `f` over the node, roughly (from the mean second differences
    /// of `G / C`), in local parameters of the patch: `_ss`, `_st`, `_tt`.
    pub(crate) fn mean_hessian(&self, tau: T) -> [f64; 3] {
        let d = self.f.degree;
        let g = self.g(tau);
        let c = if self.f.c.is_empty() {
            1.0
        } else {
            self.f.c.iter().map(|c| c.approximate()).sum::<f64>() / d.count() as f64
        };
        let widths = [self.u[1] - self.u[0], self.v[1] - self.v[0]];
        let mean = |du: usize, dv: usize, factor: usize, area: f64| {
            let (low, high) = Self::second_differences(&g, d, du, dv);
            if area > 0.0 {
                0.5 * (low + high) * factor as f64 / (area * c)
            } else {
                0.0
            }
        };
        [
            mean(2, 0, d.u * d.u.saturating_sub(1), widths[0] * widths[0]),
            mean(1, 1, d.u * d.v, widths[0] * widths[1]),
            mean(0, 2, d.v * d.v.saturating_sub(1), widths[1] * widths[1]),
        ]
    }

    /// The coefficients of `G = N - tau C`.
    fn g(&self, tau: T) -> Vec<T> {
        if self.f.c.is_empty() {
            return self.f.n.iter().map(|n| *n - tau).collect();
        }
        let pairs = self.f.n.iter().zip(&self.f.c);
        pairs.map(|(n, c)| *n - tau * *c).collect()
    }

    /// What is proven about `f` and `G = N - tau C` here.
    ///
    /// Monotone: `f_u = (N_u C - N C_u) / C^2 = (G_u C - G C_u) / C^2` for *any* tau, so it is enough that
    /// `min G_u min C > max|G| max|C_u|`; tau near `f` makes `G` small. This does not depend on
    /// how good tau is, unlike the sign of `G_u` alone.
    ///
    /// Capped: where `f_u = 0`, `N_u = f C_u`, hence `f_uu = (N_uu - f C_uu) / C = (G_uu + (tau - f) C_uu) / C`, and `|tau - f| =
    /// |G| / C`. If `max G_uu + max|G| / min C max|C_uu| < 0` on the box, all stationary points of `f` along u are strict maxima along u, thus
    /// there is one at most on every line `v = const`, and the least `f` of any part of it is at an end of that part.
    pub(crate) fn shape(&self, tau: T) -> Shape {
        let d = self.f.degree;
        let g = self.g(tau);
        let constant = self.f.c.is_empty();
        let n_max = largest(&self.f.n);
        let c_max = if constant { 1.0 } else { largest(&self.f.c) };
        let tau_size = tau.magnitude();
        // No true coefficient of `C` is larger than this.
        let c_most = c_max * (1.0 + 2.0 * self.f.c_error) * UP;
        let g_error = ((self.f.n_error + tau_size * self.f.c_error) * c_most
            + 4.0 * T::UNIT * (n_max + tau_size * c_max)
            + TINY)
            * UP;
        let c_range = if constant {
            [1.0, 1.0]
        } else {
            let least = |m: f64, c: &T| lesser(m, c.approximate());
            let c_min = self.f.c.iter().fold(f64::INFINITY, least);
            [c_min * (1.0 - 2.0 * self.f.c_error) * DOWN, c_most]
        };
        let g_max = (largest(&g) + g_error) * UP;
        let mut monotone = [0; 2];
        let mut c_slopes = [0.0; 2];
        for (k, degree) in [d.u, d.v].into_iter().enumerate() {
            if degree == 0 {
                continue;
            }
            let (low, high) = Self::differences(&g, d, k == 0);
            // Two coefficients, and the rounding of the difference and of `approximate`.
            let slack = (2.0 * g_error + 4.0 * f64::UNIT * low.abs().max(high.abs())) * UP;
            let c_diff = if constant {
                0.0
            } else {
                let (c_low, c_high) = Self::differences(&self.f.c, d, k == 0);
                (c_low.abs().max(c_high.abs()) + 2.0 * self.f.c_error * c_most) * UP
            };
            c_slopes[k] = degree as f64 * c_diff * UP;
            let other = g_max * c_diff * UP;
            if c_range[0] > 0.0 && (low - slack) * c_range[0] * DOWN > other {
                monotone[k] = 1;
            } else if c_range[0] > 0.0 && (-high - slack) * c_range[0] * DOWN > other {
                monotone[k] = -1;
            }
        }
        let second = |du: usize, dv: usize| {
            let (low, high) = Self::second_differences(&g, d, du, dv);
            let size = low.abs().max(high.abs());
            let slack = (4.0 * g_error + 8.0 * f64::UNIT * size) * UP;
            let factor = match (du, dv) {
                (2, 0) => d.u * d.u.saturating_sub(1),
                (0, 2) => d.v * d.v.saturating_sub(1),
                _ => d.u * d.v,
            } as f64;
            let highest = high + slack * UP;
            (
                (low - slack) * factor,
                (size + slack) * factor * UP,
                size,
                highest,
            )
        };
        let (a, a_max, bend_u, high_u) = second(2, 0);
        let (b, b_max, bend_v, high_v) = second(0, 2);
        let (_, c_cross, _, _) = second(1, 1);
        // Second differences throughout: the factor from them to derivatives is the same for `G` and `C`.
        let capped =
            [(d.u, high_u, (2, 0)), (d.v, high_v, (0, 2))].map(|(degree, high, (du, dv))| {
                if degree < 2 || !(high < 0.0) || c_range[0] <= 0.0 {
                    return false;
                }
                if constant {
                    return true;
                }
                let (low, most) = Self::second_differences(&self.f.c, d, du, dv);
                // Four coefficients with their errors, and the roundings of the difference.
                let slack = 4.0 * (self.f.c_error + 8.0 * T::UNIT) * c_most;
                let bent = (low.abs().max(most.abs()) + slack) * UP;
                high + g_max / c_range[0] * bent * UP < 0.0
            });
        let convexity = match (d.u, d.v) {
            (0, 0) => 0.0,
            (_, 0) => a,
            (0, _) => b,
            // The least eigenvalue of [[a', c'], [c', b']] with a' >= a, b' >= b, |c'| <= c.
            _ => {
                let root = ((a - b).powi(2) + 4.0 * c_cross * c_cross).sqrt() * UP;
                0.5 * ((a + b) - root) - 8.0 * f64::EPSILON * (a.abs() + b.abs() + root)
            }
        };
        Shape {
            monotone,
            capped,
            convexity,
            curvature: (a_max + b_max + 2.0 * c_cross) * UP,
            c_slope: (c_slopes[0] + c_slopes[1]) * UP,
            c_range,
            g_error,
            g_largest: g_max,
            bend: [bend_u, bend_v],
        }
    }

    /// The two halves.
    pub(crate) fn halves(self, along_u: bool, squared: bool) -> [Self; 2] {
        let mut low = self;
        let f = &mut low.f;
        let own = |most: f64| split_error::<T>(f.degree, along_u, most, f.tiny);
        if f.c.is_empty() {
            f.n_error = (f.n_error + own(largest(&f.n))) * UP;
        } else {
            f.n_error = (f.n_error + own(low.most)) * UP;
            f.c_error = (f.c_error + own(UP + f.c_error)) * UP;
        }
        let n = split_off(&mut f.n, f.degree, along_u);
        let c = if f.c.is_empty() {
            Vec::new()
        } else {
            split_off(&mut f.c, f.degree, along_u)
        };
        let mut high = Self {
            f: Quotient { n, c, ..low.f },
            ..low
        };
        let (a, b) = if along_u {
            (&mut low.u, &mut high.u)
        } else {
            (&mut low.v, &mut high.v)
        };
        let middle = 0.5 * (a[0] + a[1]);
        (a[1], b[0]) = (middle, middle);
        low.take_bounds(squared);
        high.take_bounds(squared);
        [low, high]
    }

    /// The part of a whole patch or border over a box.
    pub(crate) fn cut(mut self, u: [f64; 2], v: [f64; 2], squared: bool) -> Self {
        for (along_u, own, range) in [(true, &mut self.u, u), (false, &mut self.v, v)] {
            if *own == range {
                continue;
            }
            *own = range;
            let f = &mut self.f;
            let off = |most: f64| part_error::<T>(f.degree, along_u, most, f.tiny);
            let (n_off, c_off) = if f.c.is_empty() {
                (off(largest(&f.n)), 0.0)
            } else {
                (off(self.most), off(UP + f.c_error))
            };
            f.n_error = (f.n_error + n_off) * UP;
            f.c_error = (f.c_error + c_off) * UP;
            // Averages are no larger but for what they are off.
            self.most = (self.most + n_off) * UP;
            keep_part(&mut f.n, f.degree, along_u, range);
            if !f.c.is_empty() {
                keep_part(&mut f.c, f.degree, along_u, range);
            }
        }
        self.take_bounds(squared);
        self
    }

    /// The restriction to one border of the box: along u (or v) at the low or the high end.
    pub(crate) fn border(&self, along_u: bool, high: bool, squared: bool) -> Self {
        let d = self.f.degree;
        let width = d.v + 1;
        let take = |c: &[T]| -> Vec<T> {
            if along_u {
                let i = if high { d.u } else { 0 };
                c[i * width..(i + 1) * width].to_vec()
            } else {
                let j = if high { d.v } else { 0 };
                c.iter().skip(j).step_by(width).copied().collect()
            }
        };
        let end = |r: [f64; 2]| if high { [r[1]; 2] } else { [r[0]; 2] };
        let mut node = Self {
            f: Quotient {
                degree: if along_u {
                    Bidegree { u: 0, v: d.v }
                } else {
                    Bidegree { u: d.u, v: 0 }
                },
                n: take(&self.f.n),
                c: if self.f.c.is_empty() {
                    Vec::new()
                } else {
                    take(&self.f.c)
                },
                ..self.f
            },
            u: if along_u { end(self.u) } else { self.u },
            v: if along_u { self.v } else { end(self.v) },
            lo: self.lo,
            most: self.most,
        };
        node.take_bounds(squared);
        node
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Ball;
    use crate::numeric::bernstein::binomials;
    use crate::prepare::Net;
    use dashu_ratio::RBig as Q;
    use nalgebra::Point3;
    use proptest::prelude::*;

    const DEGREE: Bidegree = Bidegree { u: 2, v: 1 };

    fn exact(x: f64) -> Q {
        Q::try_from(x).unwrap()
    }

    /// The product of two polynomials, from the definition.
    fn times(a: &[Q], b: &[Q]) -> Vec<Q> {
        let twice = DEGREE + DEGREE;
        let choose = |n: usize, k: usize| exact(binomials::<f64>(n)[k]);
        let mut out = vec![Q::ZERO; twice.count()];
        for (k, value) in out.iter_mut().enumerate() {
            let (m, n) = (k / (twice.v + 1), k % (twice.v + 1));
            for i in m.saturating_sub(DEGREE.u)..=m.min(DEGREE.u) {
                for j in n.saturating_sub(DEGREE.v)..=n.min(DEGREE.v) {
                    let own = choose(DEGREE.u, i) * choose(DEGREE.u, m - i) / choose(twice.u, m)
                        * choose(DEGREE.v, j)
                        * choose(DEGREE.v, n - j)
                        / choose(twice.v, n);
                    let at = |i: usize, j: usize| i * (DEGREE.v + 1) + j;
                    *value += own * &a[at(i, j)] * &b[at(m - i, n - j)];
                }
            }
        }
        out
    }

    /// The half of a polynomial.
    fn half(c: &[Q], d: Bidegree, along_u: bool, high: bool) -> Vec<Q> {
        let mut out = c.to_vec();
        let (lines, count, step, jump) = if along_u {
            (d.v + 1, d.u + 1, d.v + 1, 1)
        } else {
            (d.u + 1, d.v + 1, 1, d.v + 1)
        };
        for l in 0..lines {
            let mut row: Vec<Q> = (0..count).map(|i| c[l * jump + i * step].clone()).collect();
            let mut ends = [row[0].clone(), row[count - 1].clone()].map(|e| vec![e]);
            for k in (1..count).rev() {
                row = (0..k)
                    .map(|i| (&row[i] + &row[i + 1]) / exact(2.0))
                    .collect();
                ends[0].push(row[0].clone());
                ends[1].push(row[k - 1].clone());
            }
            let [low, mut up] = ends;
            up.reverse();
            for (i, x) in (if high { up } else { low }).into_iter().enumerate() {
                out[l * jump + i * step] = x;
            }
        }
        out
    }

    fn check<T: Real>(points: &[[f64; 4]], q: [f64; 3], path: &[(bool, bool)]) {
        let net = Net::<T>::new(
            DEGREE,
            points.iter().map(|p| p.map(Ball::exact)).collect(),
            [0.0; 3],
        );
        let f = Quotient::squared_distance(&Point3::from(q), &net, &net.products());
        let mut node = Node::root(f, true);
        let coordinate = |c: usize| -> Vec<Q> { points.iter().map(|p| exact(p[c])).collect() };
        let w = coordinate(3);
        let mut c = times(&w, &w);
        let mut n = vec![Q::ZERO; c.len()];
        for k in 0..3 {
            let x: Vec<Q> = coordinate(k)
                .iter()
                .zip(&w)
                .map(|(x, w)| x - exact(q[k]) * w)
                .collect();
            for (sum, x) in n.iter_mut().zip(times(&x, &x)) {
                *sum += x;
            }
        }
        let dd = |x: T| exact(x.to_dd().0.hi) + exact(x.to_dd().0.lo);
        for (along_u, high) in path {
            let degree = node.f.degree;
            let [a, b] = node.halves(*along_u, true);
            node = if *high { b } else { a };
            n = half(&n, degree, *along_u, *high);
            c = half(&c, degree, *along_u, *high);
        }
        let abs = |x: Q| if x < Q::ZERO { -x } else { x };
        for k in 0..n.len() {
            assert!(abs(dd(node.f.n[k]) - &n[k]) <= exact(node.f.n_error) * &c[k]);
            assert!(abs(dd(node.f.c[k]) - &c[k]) <= exact(node.f.c_error) * &c[k]);
            assert!(node.f.c.is_empty() || abs(dd(node.f.n[k])) <= exact(node.most) * &c[k]);
        }
        // Its least value is no less than the least of the true quotients, and the bound says so to some digits of the largest.
        let least = n
            .iter()
            .zip(&c)
            .map(|(n, c)| n / c)
            .min()
            .unwrap()
            .max(Q::ZERO);
        let lo = exact(node.lo.hi) + exact(node.lo.lo);
        assert!(lo <= least);
        let far = 64.0 * (1.0 + q.iter().map(|x| x * x).sum::<f64>());
        assert!(least - lo <= exact(far * 4096.0 * T::UNIT));
    }

    /// The value of a polynomial, exactly.
    fn value(c: &[Q], d: Bidegree, at: [&Q; 2]) -> Q {
        let along = |mut row: Vec<Q>, t: &Q| {
            while row.len() > 1 {
                let pairs = row.windows(2);
                row = pairs.map(|p| &p[0] + (&p[1] - &p[0]) * t).collect();
            }
            row.swap_remove(0)
        };
        let rows = c.chunks(d.v + 1).map(|row| along(row.to_vec(), at[1]));
        along(rows.collect(), at[0])
    }

    /// Between two points of a line along a direction in which the box is capped, `f` is nowhere below both: exactly.
    fn check_capped(net: [Vec<f64>; 2], tau: f64, lines: &[[f64; 4]]) -> [bool; 2] {
        let degree = Bidegree { u: 2, v: 3 };
        let exactly = |c: &[f64]| c.iter().map(|x| exact(*x)).collect::<Vec<_>>();
        let [n, c] = [&net[0], &net[1]].map(|c| exactly(c));
        let [own_n, own_c] = net;
        let f = Quotient {
            degree,
            n: own_n,
            c: own_c,
            n_error: 0.0,
            c_error: 0.0,
            tiny: 0.0,
        };
        let capped = Node::root(f, false).shape(tau).capped;
        for (k, _) in capped.iter().enumerate().filter(|(_, is)| **is) {
            for [across, a, b, share] in lines {
                let [across, a, b, share] = [across, a, b, share].map(|x| exact(*x));
                let between = &a + (&b - &a) * share;
                let [left, middle, right] = [&a, &between, &b].map(|along| {
                    let at = if k == 0 {
                        [along, &across]
                    } else {
                        [&across, along]
                    };
                    value(&n, degree, at) / value(&c, degree, at)
                });
                assert!(middle >= left.min(right));
            }
        }
        capped
    }

    #[test]
    fn where_a_box_is_capped_is_seen() {
        // f = (1 - (2u - 1)^2) / C over C from 1 to 1.03: a ridge along v.
        let row = |x: f64| vec![x; 4];
        let n = [row(0.0), row(2.0), row(0.0)].concat();
        let c: Vec<f64> = (0..12).map(|i| 1.0 + 0.01 * f64::from(i % 4)).collect();
        let lines = [[0.25, 0.0, 1.0, 0.5], [0.75, 0.125, 0.625, 0.25]];
        assert_eq!(check_capped([n.clone(), c], 0.5, &lines), [true, false]);
        // With weights that bend more than the ridge it is no longer proven.
        let c: Vec<f64> = [row(1.0), row(8.0), row(1.0)].concat();
        assert_eq!(check_capped([n, c], 0.5, &lines), [false, false]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn capped_boxes_have_no_minimum_inside(
            n in prop::collection::vec(-1.0..1.0f64, 12),
            c in prop::collection::vec(0.5..2.0f64, 12),
            bend in (0.0..8.0f64, 0.0..8.0f64),
            flat in 0.0..1.0f64,
            tau in -2.0..2.0f64,
            lines in prop::collection::vec([0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64], 8),
        ) {
            let place = |i: usize| [(i / 4) as f64 / 2.0, (i % 4) as f64 / 3.0];
            let n = n.iter().enumerate().map(|(i, x)| {
                let [u, v] = place(i).map(|x| 4.0 * x * (1.0 - x));
                x * flat + bend.0 * u + bend.1 * v
            });
            let c = c.iter().map(|x| 1.0 + (x - 1.0) * flat);
            check_capped([n.collect(), c.collect()], tau, &lines);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        /// Errors in parts of the weights hold coefficient by coefficient, and are small whatever the weights are.
        #[test]
        fn errors_are_small_beside_small_weights(
            points in prop::collection::vec(([-4.0..4.0f64, -4.0..4.0f64, -4.0..4.0f64], -12i32..=12), 6),
            q in [-4.0..4.0f64, -4.0..4.0f64, -4.0..4.0f64],
            path in prop::collection::vec((any::<bool>(), any::<bool>()), 0..24),
        ) {
            let points: Vec<[f64; 4]> = points
                .iter()
                .map(|(p, e)| {
                    let w = 10f64.powi(*e);
                    [p[0] * w, p[1] * w, p[2] * w, w]
                })
                .collect();
            check::<f64>(&points, q, &path);
            check::<Dd>(&points, q, &path);
        }
    }
}
