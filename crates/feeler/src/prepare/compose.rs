//! Images of trim curves: the composition of a Bezier patch with a curve in its
//! parameter square.

use super::{Homogeneous, Net};
use crate::numeric::bernstein::binomials;
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
        let pascal = |n: usize| {
            // Each entry is off by at most n units (bernstein::binomials).
            binomials::<T>(n).into_iter().map(move |b| Ball {
                mid: b,
                rad: if n <= EXACT_BINOMIALS {
                    0.0
                } else {
                    n as f64 * T::UNIT * b.magnitude()
                },
            })
        };
        let columns: Vec<Ball<T>> = pascal(q).collect();
        let mut weights = Vec::with_capacity((p + 1) * (q + 1));
        for b in pascal(p) {
            weights.extend(columns.iter().map(|c| b * *c));
        }
        Self {
            weights,
            whole: pascal(p + q).collect(),
            columns: q + 1,
        }
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
const EXACT_BINOMIALS: usize = 56;

/// The homogeneous Bezier points of `S(c(t))`, where `curve` is homogeneous `(s w, t w, w)` in the patch's
/// local square; degree `k (p + q)`. `None` beyond [`MAX_COMPOSED_DEGREE`].
///
/// De Casteljau with polynomials for numbers: at each step of the v direction
/// `b_j <- (w - t) b_j + t b_(j+1)`, where `w`, `t` are the curve's coordinates; likewise in u. The
/// result is the patch's homogeneous form times `w^(p+q)`, a common factor.
/// Source: T. DeRose et al., *Functional composition algorithms via blossoming*, ACM TOG 12 (1993).
pub(crate) fn compose<T: Real>(
    patch: &Net<T>,
    curve: &[Homogeneous<T, 3>],
) -> Option<Vec<Homogeneous<T, 4>>> {
    let k = curve.len() - 1;
    if k * (patch.degree.u + patch.degree.v) > MAX_COMPOSED_DEGREE {
        return None;
    }
    let coordinate = |c: usize| -> Poly<T> { curve.iter().map(|p| p[c]).collect() };
    let (s, t, w) = (coordinate(0), coordinate(1), coordinate(2));
    let rest = |x: &Poly<T>| -> Poly<T> { w.iter().zip(x).map(|(a, b)| *a - *b).collect() };
    let (s0, t0) = (rest(&s), rest(&t));
    // One coordinate of one row or column, from points to the composed polynomial.
    let collapse = |mut row: Vec<Poly<T>>, low: &Poly<T>, high: &Poly<T>| -> Poly<T> {
        while row.len() > 1 {
            let products = Products::new(low.len() - 1, row[0].len() - 1);
            row = row
                .windows(2)
                .map(|pair| {
                    let (a, b) = (products.of(low, &pair[0]), products.of(high, &pair[1]));
                    a.iter().zip(&b).map(|(x, y)| *x + *y).collect()
                })
                .collect();
        }
        row.swap_remove(0)
    };
    let mut out: Vec<Homogeneous<T, 4>> = Vec::new();
    for c in 0..4 {
        let columns = patch
            .points
            .chunks_exact(patch.degree.v + 1)
            .map(|r| collapse(r.iter().map(|p| vec![p[c]]).collect(), &t0, &t))
            .collect();
        let composed = collapse(columns, &s0, &s);
        out.resize(composed.len(), [Ball::ZERO; 4]);
        for (o, x) in out.iter_mut().zip(&composed) {
            o[c] = *x;
        }
    }
    Some(out)
}
