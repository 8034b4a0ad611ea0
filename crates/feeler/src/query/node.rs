//! A box of the search: part of a patch or of a boundary piece.

use crate::numeric::bernstein::{
    Bidegree, border_into, greater, keep_part, largest, part_error, split_error, split_into,
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
    /// No computed coefficient of `N` is larger than this part of the true one of `C`. Not kept where `C` is 1.
    most: f64,
}

/// Makes up for the rounding of a bound that is computed in a few f64 operations.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// The whole square (or, for a curve, the whole interval).
pub(super) fn whole(degree: Bidegree) -> [[f64; 2]; 2] {
    let v = if degree.v == 0 { 0.0 } else { 1.0 };
    [[0.0, 1.0], [0.0, v]]
}

/// The sides of a box that are on borders of its patch: across u (0) or v (1), and whether the upper one.
pub(super) fn on_borders(ranges: [[f64; 2]; 2]) -> impl Iterator<Item = (usize, bool)> {
    let all = [(0, false), (0, true), (1, false), (1, true)];
    all.into_iter().filter(move |(k, high)| {
        let [start, end] = ranges[*k];
        // (A side has none across it.)
        start < end && if *high { end == 1.0 } else { start == 0.0 }
    })
}

impl<T: Real> Node<T> {
    /// Nothing yet: lists to be filled.
    pub(crate) const BLANK: Self = Self {
        f: Quotient::BLANK,
        u: [0.0; 2],
        v: [0.0; 2],
        lo: Dd::ZERO,
        most: 0.0,
    };

    /// The whole square (or, for a curve, the whole interval).
    pub(crate) fn root(f: Quotient<T>, squared: bool) -> Self {
        let [u, v] = whole(f.degree);
        Self::over(f, u, v, squared)
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

    /// The two halves.
    pub(crate) fn halves(mut self, along_u: bool, squared: bool) -> [Self; 2] {
        let mut high = Self::BLANK;
        self.halve(&mut high, along_u, squared);
        [self, high]
    }

    /// Becomes its lower half, and another node, whatever it holds, the upper one.
    pub(crate) fn halve(&mut self, high: &mut Self, along_u: bool, squared: bool) {
        let low = self;
        let f = &mut low.f;
        let own = |most: f64| split_error::<T>(f.degree, along_u, most, f.tiny);
        if f.c.is_empty() {
            f.n_error = (f.n_error + own(largest(&f.n))) * UP;
        } else {
            f.n_error = (f.n_error + own(low.most)) * UP;
            f.c_error = (f.c_error + own(UP + f.c_error)) * UP;
        }
        split_into(&mut f.n, &mut high.f.n, f.degree, along_u);
        high.f.c.clear();
        if !f.c.is_empty() {
            split_into(&mut f.c, &mut high.f.c, f.degree, along_u);
        }
        high.take_rest(low);
        let (a, b) = if along_u {
            (&mut low.u, &mut high.u)
        } else {
            (&mut low.v, &mut high.v)
        };
        let middle = 0.5 * (a[0] + a[1]);
        (a[1], b[0]) = (middle, middle);
        low.take_bounds(squared);
        high.take_bounds(squared);
    }

    /// Takes over all of another node but its lists.
    fn take_rest(&mut self, other: &Self) {
        let (n, c) = (std::mem::take(&mut self.f.n), std::mem::take(&mut self.f.c));
        *self = Self {
            f: Quotient { n, c, ..other.f },
            ..*other
        };
    }

    /// The part of a whole patch or border over a box.
    pub(crate) fn cut(&mut self, u: [f64; 2], v: [f64; 2], squared: bool) {
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
    }

    /// Makes of a node, whatever it holds, the restriction to one border of the box: along u (or v) at the low or the high end.
    pub(crate) fn border(&self, out: &mut Self, along_u: bool, high: bool, squared: bool) {
        let d = self.f.degree;
        border_into(&self.f.n, &mut out.f.n, d, along_u, high);
        out.f.c.clear();
        if !self.f.c.is_empty() {
            border_into(&self.f.c, &mut out.f.c, d, along_u, high);
        }
        out.take_rest(self);
        let end = |r: [f64; 2]| if high { [r[1]; 2] } else { [r[0]; 2] };
        if along_u {
            (out.f.degree.u, out.u) = (0, end(self.u));
        } else {
            (out.f.degree.v, out.v) = (0, end(self.v));
        }
        out.take_bounds(squared);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Ball;
    use crate::numeric::bernstein::binomials;
    use crate::prepare::{Net, least_squared_distance};
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

        /// The bound of a box without its coefficients: below the least of the true ones, by no more than roundings.
        #[test]
        fn the_least_coefficient_is_told_alone(
            points in prop::collection::vec([-4.0..4.0f64, -4.0..4.0f64, -4.0..4.0f64], 6),
            q in [-4.0..4.0f64, -4.0..4.0f64, -4.0..4.0f64],
            path in prop::collection::vec((any::<bool>(), any::<bool>()), 0..24),
        ) {
            let balls = points.iter().map(|p| [p[0], p[1], p[2], 1.0].map(Ball::exact));
            let net = Net::<f64>::new(DEGREE, balls.collect(), [0.0; 3]);
            let mut products = net.products();
            let mut n = vec![Q::ZERO; products.degree.count()];
            for k in 0..3 {
                let x: Vec<Q> = points.iter().map(|p| exact(p[k]) - exact(q[k])).collect();
                n.iter_mut().zip(times(&x, &x)).for_each(|(sum, x)| *sum += x);
            }
            for (along_u, high) in path {
                let upper = products.split(along_u);
                if high {
                    products = upper;
                }
                n = half(&n, products.degree, along_u, high);
            }
            let told = exact(least_squared_distance(&Point3::from(q), &net, &products));
            let truth = n.into_iter().reduce(Q::min).unwrap();
            prop_assert!(told <= truth.clone().max(Q::ZERO));
            // Coefficients are sums of parts up to 3 * 16 of each kind, 200 in all, each off by less than 200 units for products and 24 splits.
            const ROUNDINGS: f64 = 200.0 * 200.0 * f64::EPSILON;
            prop_assert!(truth - told < exact(ROUNDINGS));
        }
    }
}
