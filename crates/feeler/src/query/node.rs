//! A box of the search: part of a patch or of a boundary piece.

use crate::numeric::bernstein::{
    Bidegree, by_width, greater, largest, lesser, split_error, split_off,
};
use crate::numeric::{Dd, Real};
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
}

/// What is proven about `G = N - tau C` on a node, in coordinates that run over the node from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// The sign of `f`'s derivative along each direction, where it is proven not to vanish.
    pub(crate) monotone: [i8; 2],
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
        let lo = Dd::ZERO;
        let mut node = Self { f, u, v, lo };
        node.lo = node.lower_bound(squared);
        node
    }

    /// `f = sum n_ij B_ij / sum c_ij B_ij` with `c_ij > 0` is a convex combination of the
    /// `n_ij / c_ij`, thus at least their minimum. Each quotient is off by what its parts
    /// are, and three roundings.
    fn lower_bound(&self, squared: bool) -> Dd {
        let (en, ec) = (T::from_f64(self.f.n_error), T::from_f64(self.f.c_error));
        if self.f.c.is_empty() {
            let low = self
                .f
                .n
                .iter()
                .copied()
                .reduce(|a, b| if b < a { b } else { a });
            let Some(low) = low else { return Dd::ZERO };
            // One rounding of the difference, and what is a coefficient's own.
            let lo =
                (low - en).to_dd() - Dd::from(4.0 * T::UNIT * (low.magnitude() + self.f.n_error));
            return if squared && !(lo > Dd::ZERO) {
                Dd::ZERO
            } else {
                lo
            };
        }
        let mut low: Option<T> = None;
        for (n, c) in self.f.n.iter().zip(&self.f.c) {
            if !(*c - ec - ec > T::ZERO) {
                return if squared {
                    Dd::ZERO
                } else {
                    Dd::from(f64::NEG_INFINITY)
                };
            }
            let n = *n - en;
            // Towards a smaller quotient.
            let c = if n > T::ZERO { *c + ec } else { *c - ec };
            let q = n / c;
            if low.is_none_or(|l| q < l) {
                low = Some(q);
            }
        }
        let Some(q) = low else { return Dd::ZERO };
        let slack = 8.0 * T::DIV_UNIT * q.magnitude();
        let lo = q.to_dd() - Dd::from(slack);
        if squared && !(lo > Dd::ZERO) {
            Dd::ZERO
        } else {
            lo
        }
    }

    /// The position of the smallest quotient of coefficients: a first guess of the minimum.
    pub(crate) fn guess(&self) -> [f64; 2] {
        let width = self.f.degree.v + 1;
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
        let at = |range: [f64; 2], k: usize, degree: usize| {
            if degree == 0 {
                range[0]
            } else {
                range[0] + (range[1] - range[0]) * (k as f64 / degree as f64)
            }
        };
        [
            at(self.u, best.1 / width, self.f.degree.u),
            at(self.v, best.1 % width, self.f.degree.v),
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
    pub(crate) fn shape(&self, tau: T) -> Shape {
        let d = self.f.degree;
        let g = self.g(tau);
        let constant = self.f.c.is_empty();
        let n_max = largest(&self.f.n);
        let c_max = if constant { 1.0 } else { largest(&self.f.c) };
        let tau_size = tau.magnitude();
        let g_error = (self.f.n_error
            + tau_size * self.f.c_error
            + 4.0 * T::UNIT * (n_max + tau_size * c_max))
            * UP;
        let c_range = if constant {
            [1.0, 1.0]
        } else {
            let least = |m: f64, c: &T| lesser(m, c.approximate());
            let c_min = self.f.c.iter().fold(f64::INFINITY, least);
            [
                (c_min * DOWN - 2.0 * self.f.c_error) * DOWN,
                (c_max + self.f.c_error) * UP,
            ]
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
                (c_low.abs().max(c_high.abs()) + 2.0 * self.f.c_error) * UP
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
            ((low - slack) * factor, (size + slack) * factor * UP, size)
        };
        let (a, a_max, bend_u) = second(2, 0);
        let (b, b_max, bend_v) = second(0, 2);
        let (_, c_cross, _) = second(1, 1);
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
        let error = |e: f64, c: &[T]| {
            let own = split_error::<T>(f.degree, along_u, largest(c));
            if c.is_empty() { 0.0 } else { (e + own) * UP }
        };
        (f.n_error, f.c_error) = (error(f.n_error, &f.n), error(f.c_error, &f.c));
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
        for node in [&mut low, &mut high] {
            let lo = node.lower_bound(squared);
            if lo > node.lo {
                node.lo = lo;
            }
        }
        [low, high]
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
        };
        let lo = node.lower_bound(squared);
        if lo > node.lo {
            node.lo = lo;
        }
        node
    }
}
