//! What is proven about the derivatives of a quotient on a node: where it falls, bends, has no minimum.

use super::node::Node;
use crate::numeric::bernstein::{Bidegree, by_width, greater, largest, lesser};
use crate::numeric::{Real, TINY};

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

/// Bounds on the differences of the coefficients of `G = N - tau C` and of `C` on a node: ranges that hold those of the true ones. (Derivatives are
/// differences times the degree, and second derivatives times that of what is left.)
#[derive(Clone, Copy, Debug)]
pub(super) struct Bends {
    pub(super) degree: Bidegree,
    /// Whether `C` is 1, exactly.
    pub(super) constant: bool,
    /// First differences of `G` along u and v.
    pub(super) slopes: [[f64; 2]; 2],
    /// Second differences along u, along v, and mixed.
    pub(super) seconds: [[f64; 2]; 3],
    /// The largest first difference of `C` along each.
    pub(super) c_slopes: [f64; 2],
    /// Ranges of `C`.
    pub(super) c_range: [f64; 2],
    /// Bound on the error of a computed coefficient of `G`.
    pub(super) g_error: f64,
    /// No true coefficient of `G` is larger.
    pub(super) g_largest: f64,
    /// Largest computed second difference of `G` in each direction.
    pub(super) bend: [f64; 2],
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

/// So many coefficients have the products of patches of degree 5 by 5.
const FEW: usize = 121;

impl<T: Real> Node<T> {
    /// Differences of first order along u (or v): `(min, max)` over the box.
    pub(super) fn differences(c: &[T], degree: Bidegree, along_u: bool) -> (f64, f64) {
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
    pub(super) fn second_differences(
        c: &[T],
        degree: Bidegree,
        du: usize,
        dv: usize,
    ) -> (f64, f64) {
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
        let (mut few, mut many) = ([T::ZERO; FEW], Vec::new());
        let g = self.g(tau, &mut few, &mut many);
        let c = if self.f.c.is_empty() {
            1.0
        } else {
            self.f.c.iter().map(|c| c.approximate()).sum::<f64>() / d.count() as f64
        };
        let widths = [self.u[1] - self.u[0], self.v[1] - self.v[0]];
        let mean = |du: usize, dv: usize, factor: usize, area: f64| {
            let (low, high) = Self::second_differences(g, d, du, dv);
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

    /// The coefficients of `G = N - tau C`, in one of two places: a list that is allocated only where there are many.
    fn g<'p>(&self, tau: T, few: &'p mut [T; FEW], many: &'p mut Vec<T>) -> &'p [T] {
        let (n, c) = (&self.f.n, &self.f.c);
        let out = match few.get_mut(..n.len()) {
            Some(few) => few,
            None => {
                many.resize(n.len(), T::ZERO);
                many.as_mut_slice()
            }
        };
        if c.is_empty() {
            out.iter_mut().zip(n).for_each(|(g, n)| *g = *n - tau);
        } else {
            let pairs = n.iter().zip(c);
            let each = out.iter_mut().zip(pairs);
            each.for_each(|(g, (n, c))| *g = *n - tau * *c);
        }
        out
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
        let bends = self.bends(tau);
        let mut shape = bends.told();
        // Second differences throughout: the factor from them to derivatives is the same for `G` and `C`.
        for (k, (degree, (du, dv))) in [(d.u, (2, 0)), (d.v, (0, 2))].into_iter().enumerate() {
            let high = bends.seconds[k][1];
            if degree < 2 || !(high < 0.0) || bends.c_range[0] <= 0.0 {
                continue;
            }
            let bent = if bends.constant {
                0.0
            } else {
                let (low, most) = Self::second_differences(&self.f.c, d, du, dv);
                // Four coefficients with their errors, and the roundings of the difference.
                let slack = 4.0 * (self.f.c_error + 8.0 * T::UNIT) * bends.c_range[1];
                (low.abs().max(most.abs()) + slack) * UP
            };
            shape.capped[k] = high + bends.g_largest / bends.c_range[0] * bent * UP < 0.0;
        }
        shape
    }

    /// Bounds on the differences of the coefficients of `G = N - tau C`.
    pub(super) fn bends(&self, tau: T) -> Bends {
        self.bends_unless(tau, |_| false)
    }

    /// The same, but of second differences nothing where first ones are enough, by what is [told](Bends::monotone) of them.
    pub(super) fn bends_unless(&self, tau: T, enough: impl FnOnce([i8; 2]) -> bool) -> Bends {
        let d = self.f.degree;
        let (mut few, mut many) = ([T::ZERO; FEW], Vec::new());
        let g = self.g(tau, &mut few, &mut many);
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
        let (mut slopes, mut c_slopes) = ([[0.0; 2]; 2], [0.0; 2]);
        for (k, degree) in [d.u, d.v].into_iter().enumerate() {
            if degree == 0 {
                continue;
            }
            let (low, high) = Self::differences(g, d, k == 0);
            // Two coefficients, and the rounding of the difference and of `approximate`.
            let slack = (2.0 * g_error + 4.0 * f64::UNIT * low.abs().max(high.abs())) * UP;
            slopes[k] = [low - slack, high + slack];
            if !constant {
                let (low, high) = Self::differences(&self.f.c, d, k == 0);
                c_slopes[k] = (low.abs().max(high.abs()) + 2.0 * self.f.c_error * c_most) * UP;
            }
        }
        let mut out = Bends {
            degree: d,
            constant,
            slopes,
            seconds: [[f64::NEG_INFINITY, f64::INFINITY]; 3],
            c_slopes,
            c_range,
            g_error,
            g_largest: (largest(g) + g_error) * UP,
            bend: [0.0; 2],
        };
        let monotone = [0, 1].map(|k| out.monotone(k, out.slopes[k], out.g_largest));
        if enough(monotone) {
            return out;
        }
        let mut bend = [0.0; 3];
        for (m, (du, dv)) in [(2, 0), (0, 2), (1, 1)].into_iter().enumerate() {
            let (low, high) = Self::second_differences(g, d, du, dv);
            bend[m] = low.abs().max(high.abs());
            let slack = (4.0 * g_error + 8.0 * f64::UNIT * bend[m]) * UP;
            out.seconds[m] = [low - slack, high + slack * UP];
        }
        out.bend = [bend[0], bend[1]];
        out
    }
}

impl Bends {
    /// What they prove; that a box is capped takes more than they hold.
    pub(super) fn told(&self) -> Shape {
        let monotone = [0, 1].map(|k| self.monotone(k, self.slopes[k], self.g_largest));
        self.bent(&self.seconds, monotone, self.g_largest)
    }

    /// The sign of `f`'s derivative along a direction, where it is proven not to vanish, given the range of the first differences of `G` and a
    /// bound of its coefficients.
    #[inline(always)]
    pub(super) fn monotone(&self, k: usize, [low, high]: [f64; 2], largest: f64) -> i8 {
        let degree = if k == 0 { self.degree.u } else { self.degree.v };
        if degree == 0 || !(self.c_range[0] > 0.0) {
            return 0;
        }
        let other = largest * self.c_slopes[k] * UP;
        if low * self.c_range[0] * DOWN > other {
            1
        } else if -high * self.c_range[0] * DOWN > other {
            -1
        } else {
            0
        }
    }

    /// What follows from ranges of the second differences of `G` and a bound of its coefficients.
    #[inline(always)]
    pub(super) fn bent(&self, seconds: &[[f64; 2]; 3], monotone: [i8; 2], g_largest: f64) -> Shape {
        let d = self.degree;
        let factors = [
            (d.u * d.u.saturating_sub(1)) as f64,
            (d.v * d.v.saturating_sub(1)) as f64,
            (d.u * d.v) as f64,
        ];
        let most = |m: usize| {
            let [low, high]: [f64; 2] = seconds[m];
            greater(low.abs(), high.abs()) * factors[m] * UP
        };
        let (a, b) = (seconds[0][0] * factors[0], seconds[1][0] * factors[1]);
        let cross = most(2);
        let convexity = match (d.u, d.v) {
            (0, 0) => 0.0,
            (_, 0) => a,
            (0, _) => b,
            // The least eigenvalue of [[a', c'], [c', b']] with a' >= a, b' >= b, |c'| <= c.
            _ => {
                let root = ((a - b) * (a - b) + 4.0 * cross * cross).sqrt() * UP;
                0.5 * ((a + b) - root) - 8.0 * f64::EPSILON * (a.abs() + b.abs() + root)
            }
        };
        // Derivatives are differences times the degree.
        let c_slope = d.u as f64 * self.c_slopes[0] * UP + d.v as f64 * self.c_slopes[1] * UP;
        Shape {
            monotone,
            capped: [false; 2],
            convexity,
            curvature: (most(0) + most(1) + 2.0 * cross) * UP,
            c_slope: c_slope * UP,
            c_range: self.c_range,
            g_error: self.g_error,
            g_largest,
            bend: self.bend,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::Quotient;
    use dashu_ratio::RBig as Q;
    use proptest::prelude::*;

    fn exact(x: f64) -> Q {
        Q::try_from(x).unwrap()
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
}
