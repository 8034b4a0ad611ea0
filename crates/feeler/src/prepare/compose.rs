//! Images of trim curves: the composition of a Bezier patch with a curve in its
//! parameter square.

use super::{Homogeneous, Net};
use crate::numeric::bernstein::{Bidegree, binomials};
use crate::numeric::{Ball, Real};

/// The largest degree of a composed curve; beyond it a trim is not composed, and the width of a crack along it is not known. The thread of OCCT's bottle has
/// trims of degree 8 on a surface of degree 12 x 1 and on a cylinder's patches of 11 x 1; of OCCT's propeller and sink some have degree 10 on surfaces of 7 x 6 and 6 x 9.
pub(crate) const MAX_COMPOSED_DEGREE: usize = 192;

/// Bernstein coefficients of a polynomial.
pub(super) type Poly<T> = Vec<Ball<T>>;

/// Products of polynomials of two degrees in Bernstein form, with running bounds: what binomials there are is found once for all of them.
pub(super) struct Products<T> {
    /// `C(p, i) C(q, j)`, row by row.
    weights: Vec<Ball<T>>,
    /// `C(p + q, k)`.
    whole: Vec<Ball<T>>,
    columns: usize,
}

impl<T: Real> Products<T> {
    /// Of polynomials of degree `p` and such of degree `q`.
    pub(super) fn new(p: usize, q: usize) -> Self {
        let columns = pascal(q);
        let mut weights = Vec::with_capacity((p + 1) * (q + 1));
        for b in pascal(p) {
            weights.extend(columns.iter().map(|c| b * *c));
        }
        Self {
            weights,
            whole: pascal(p + q),
            columns: q + 1,
        }
    }

    /// Bytes of what is found once, for factors of so many coefficients.
    pub(super) fn bytes(x: usize, y: usize) -> usize {
        (x * y + 3 * (x + y)) * size_of::<Ball<T>>()
    }

    /// One of them.
    pub(super) fn of(&self, x: &[Ball<T>], y: &[Ball<T>]) -> Poly<T> {
        debug_assert_eq!(x.len() * self.columns, self.weights.len(), "its degree");
        debug_assert_eq!(y.len(), self.columns, "its degree");
        let mut out = vec![Ball::ZERO; self.whole.len()];
        for ((i, xi), row) in x.iter().enumerate().zip(self.weights.chunks(self.columns)) {
            for ((o, yj), b) in out[i..].iter_mut().zip(y).zip(row) {
                *o = *o + *b * (*xi * *yj);
            }
        }
        for (o, b) in out.iter_mut().zip(&self.whole) {
            *o = *o / *b;
        }
        out
    }

    /// A polynomial of the first degree in one that is higher by the second: its product with 1.
    pub(super) fn elevated(&self, x: &[Ball<T>]) -> Poly<T> {
        if self.columns == 1 {
            return x.to_vec();
        }
        self.of(x, &vec![Ball::ONE; self.columns])
    }
}

/// Binomials C(n, k) with n up to this are below 2^53: exact even in f64.
pub(super) const EXACT_BINOMIALS: usize = 56;

/// Row `n` of Pascal's triangle.
fn pascal<T: Real>(n: usize) -> Vec<Ball<T>> {
    // Each entry is off by at most n units (bernstein::binomials).
    let ball = |b: T| Ball {
        mid: b,
        rad: if n <= EXACT_BINOMIALS {
            0.0
        } else {
            n as f64 * T::UNIT * b.magnitude()
        },
    };
    binomials::<T>(n).into_iter().map(ball).collect()
}

/// Adds the product of two polynomials with scaled coefficients to a third.
fn add_product<T: Real>(out: &mut [Ball<T>], x: &[Ball<T>], y: &[Ball<T>]) {
    for (i, a) in x.iter().enumerate() {
        for (o, b) in out[i..].iter_mut().zip(y) {
            *o = *o + *a * *b;
        }
    }
}

/// A polynomial times a number; times 1 it is itself, without a rounding.
fn scaled<T: Real>(by: Ball<T>, mut x: Poly<T>) -> Poly<T> {
    if !by.is_one() {
        x.iter_mut().for_each(|a| *a = by * *a);
    }
    x
}

/// `C(n, i) x^i y^(n - i)`, of two polynomials of one degree with scaled coefficients.
fn terms<T: Real>(x: &[Ball<T>], y: &[Ball<T>], n: usize) -> Vec<Poly<T>> {
    let times = |a: &[Ball<T>], b: &[Ball<T>]| -> Poly<T> {
        match (a, b) {
            ([number], x) | (x, [number]) => scaled(*number, x.to_vec()),
            _ => {
                let mut out = vec![Ball::ZERO; a.len() + b.len() - 1];
                add_product(&mut out, a, b);
                out
            }
        }
    };
    let mut ys: Vec<Poly<T>> = Vec::with_capacity(n + 1);
    let next = |power: &Poly<T>| Some(times(power, y));
    ys.extend(std::iter::successors(Some(vec![Ball::ONE]), next).take(n + 1));
    // Of x one power at a time, and each of y's goes when it is used: together they take as much as what is made of them.
    let mut power = vec![Ball::ONE];
    let mut out = Vec::with_capacity(n + 1);
    for (i, b) in pascal(n).into_iter().enumerate() {
        let Some(rest) = ys.pop() else { break };
        out.push(scaled(b, times(&power, &rest)));
        if i < n {
            power = times(&power, x);
        }
    }
    out
}

/// Bytes that [`compose`] takes at most for a patch of a degree and a curve of degree `k`, with what it gives.
pub(super) fn compose_bytes<T>(patch: Bidegree, k: usize) -> usize {
    let [p, q] = [patch.u, patch.v];
    let degree = k * (p + q);
    if degree > MAX_COMPOSED_DEGREE {
        return 0;
    }
    // The terms of both, the last powers beside them; what is given, a sum and the binomials, with the row they are made of.
    let of_terms = |n: usize| (n + 1) * (k * n + 1) + 3 * (k * n + 1);
    let own = of_terms(p) + of_terms(q) + 8 * (degree + 1) + 4 * (k + 1);
    own * size_of::<Ball<T>>() + 2 * (p + q + 2) * size_of::<Poly<T>>()
}

/// The homogeneous Bezier points of `S(c(t))`, where `curve` is homogeneous `(s w, t w, w)` in the patch's
/// local square; degree `k (p + q)`. `None` beyond [`MAX_COMPOSED_DEGREE`].
///
/// With `s`, `t` and `w` for the curve's coordinates it is `sum_i C(p, i) s^i (w - s)^(p - i) sum_j C(q, j) t^j (w - t)^(q - j) P_ij`: the
/// patch's homogeneous form times `w^(p+q)`, a common factor. The powers are found once for all coordinates, and the inner sum, in which polynomials
/// are only added, is that of the higher degree; within the square no power has negative coefficients, so that they lose no digits. Coefficients are
/// scaled, `C(n, k)` times Bernstein's, as a product's then are sums of products alone (R. Farouki, V. Rajan, *Algorithms for
/// polynomials in Bernstein form*, CAGD 5, 1988).
pub(crate) fn compose<T: Real>(
    patch: &Net<T>,
    curve: &[Homogeneous<T, 3>],
) -> Option<Vec<Homogeneous<T, 4>>> {
    let k = curve.len() - 1;
    let (p, q) = (patch.degree.u, patch.degree.v);
    let degree = k * (p + q);
    if degree > MAX_COMPOSED_DEGREE {
        return None;
    }
    let scales = pascal(k);
    let along = |c: usize, n: usize| -> Vec<Poly<T>> {
        let of = |x: &dyn Fn(&Homogeneous<T, 3>) -> Ball<T>| -> Poly<T> {
            let both = curve.iter().zip(&scales);
            both.map(|(p, b)| if b.is_one() { x(p) } else { *b * x(p) })
                .collect()
        };
        let (high, low) = (of(&|p| p[c]), of(&|p| p[2] - p[c]));
        terms(&high, &low, n)
    };
    // The steps from a control point to the next: of the outer sum, of the inner.
    let (outer, inner, steps) = if p <= q {
        (along(0, p), along(1, q), [q + 1, 1])
    } else {
        (along(1, q), along(0, p), [1, q + 1])
    };
    let whole = pascal(degree);
    let mut out = vec![[Ball::ONE; 4]; degree + 1];
    // The sum is 1 where they all are.
    let is_polynomial =
        patch.points.iter().all(|p| p[3].is_one()) && curve.iter().all(|p| p[2].is_one());
    for c in 0..if is_polynomial { 3 } else { 4 } {
        let mut sum = vec![Ball::ZERO; degree + 1];
        for (i, factor) in outer.iter().enumerate() {
            let mut own = vec![Ball::ZERO; inner[0].len()];
            for (j, term) in inner.iter().enumerate() {
                let point = patch.points[i * steps[0] + j * steps[1]][c];
                add_product(&mut own, &[point], term);
            }
            add_product(&mut sum, factor, &own);
        }
        for ((o, x), b) in out.iter_mut().zip(&sum).zip(&whole) {
            o[c] = *x / *b;
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dd;
    use crate::numeric::bernstein::evaluate;

    type V = [Ball<Dd>; 4];

    fn exact(c: [f64; 4]) -> V {
        c.map(Ball::exact)
    }

    fn at(points: Vec<V>, t: Ball<Dd>) -> V {
        std::array::from_fn(|c| evaluate(points.iter().map(|p| p[c]).collect(), t))
    }

    /// Points of the composed curve are the patch's, but for roundings; of polynomials all weights are 1.
    fn check<T: Real>(degree: [usize; 2], k: usize, rational: bool, most: f64) {
        let [u, v] = degree;
        let weight = |i: usize| 1.0 + f64::from(rational) * (i % 3) as f64 / 4.0;
        let known = |i: usize| {
            let (x, y, w) = ((i / (v + 1)) as f64, (i % (v + 1)) as f64, weight(i));
            exact([x * w, y * w, (x * 3.0 - y * y) / 8.0 * w, w])
        };
        let points: Vec<V> = (0..(u + 1) * (v + 1)).map(known).collect();
        let curve: Vec<V> = (0..=k)
            .map(|i| {
                let (x, w) = (i as f64 / k as f64, weight(i + 1));
                exact([(1.0 - x * x) * w, (0.25 + 0.5 * x) * w, w, 0.0])
            })
            .collect();
        let to_t = |p: &V| p.map(|x| Ball::<T>::from_dd(x.mid, 0.0));
        let net = Net::new(
            Bidegree { u, v },
            points.iter().map(to_t).collect(),
            [0.0; 3],
        );
        let own: Vec<_> = curve
            .iter()
            .map(|p| to_t(p).first_chunk().copied().unwrap())
            .collect();
        let composed = compose(&net, &own).unwrap();
        assert_eq!(composed.len(), k * (u + v) + 1);
        assert!(rational || composed.iter().all(|p| p[3].is_one()));
        let composed: Vec<V> = composed.iter().map(|p| p.map(|x| x.to_dd())).collect();
        for t in [0.0, 0.125, 0.5, 0.75, 1.0] {
            let t = Ball::exact(t);
            let [x, y, w, _] = at(curve.clone(), t);
            let rows = points.chunks_exact(v + 1);
            let column = rows.map(|row| at(row.to_vec(), y / w)).collect();
            let truth = at(column, x / w);
            let found = at(composed.clone(), t);
            for c in 0..3 {
                let off = truth[c] / truth[3] - found[c] / found[3];
                assert!(off.mid.magnitude() <= off.rad && off.rad <= most, "{off:?}");
            }
        }
    }

    #[test]
    fn composed_curves_are_on_the_patch() {
        for degree in [[1, 1], [3, 0], [0, 2], [2, 5], [6, 3], [7, 8]] {
            for k in [1, 3] {
                for rational in [false, true] {
                    check::<f64>(degree, k, rational, 1e-11);
                    check::<Dd>(degree, k, rational, 1e-26);
                }
            }
        }
    }
}
