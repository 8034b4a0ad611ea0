//! Images of trim curves: the composition of a Bezier patch with a curve in its
//! parameter square.

use super::{Homogeneous, Net};
use crate::numeric::bernstein::binomials;
use crate::numeric::{Ball, Real};

/// The largest degree of a composed curve; beyond it a trim is not composed.
pub(crate) const MAX_COMPOSED_DEGREE: usize = 80;

/// Bernstein coefficients of a polynomial.
pub(super) type Poly<T> = Vec<Ball<T>>;

/// Product of two polynomials in Bernstein form with running bounds.
pub(super) fn multiply<T: Real>(x: &[Ball<T>], y: &[Ball<T>]) -> Poly<T> {
    let (p, q) = (x.len() - 1, y.len() - 1);
    let pascal = |n: usize| -> Poly<T> {
        // Each entry is off by at most n units (bernstein::binomials).
        binomials::<T>(n)
            .into_iter()
            .map(|b| Ball {
                mid: b,
                rad: if n <= EXACT_BINOMIALS {
                    0.0
                } else {
                    n as f64 * T::UNIT * b.magnitude()
                },
            })
            .collect()
    };
    let (bp, bq, bpq) = (pascal(p), pascal(q), pascal(p + q));
    let mut out = vec![Ball::ZERO; p + q + 1];
    for (i, xi) in x.iter().enumerate() {
        for (j, yj) in y.iter().enumerate() {
            out[i + j] = out[i + j] + (bp[i] * bq[j]) * (*xi * *yj);
        }
    }
    for (o, b) in out.iter_mut().zip(&bpq) {
        *o = *o / *b;
    }
    out
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
            row = row
                .windows(2)
                .map(|pair| {
                    let (a, b) = (multiply(low, &pair[0]), multiply(high, &pair[1]));
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
