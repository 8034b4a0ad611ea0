//! Candidates for the roots of a polynomial in [0, 1]: generalised eigenvalues, in f64.
//!
//! With x = t / (1 - t) and `v_k = C(n, k) x^k` a polynomial with Bernstein coefficients b is `sum b_k v_k`, and
//! `(k + 1) v_(k+1) = x (n - k) v_k`. These relations for k < n - 1, and the polynomial itself in place of the last,
//! are a pencil `A v = x B v`, hence `A v = t (A + B) v`: the companion pencil of the Bernstein form, whose eigenvalues are
//! the roots as stably as the Bernstein coefficients determine them (G. F. Jonsson and S. Vavasis, *Solving polynomials with
//! small leading coefficients*, SIMAX 26 (2004)). Nothing is proven here; who asks certifies what he uses.

use super::polynomial::{Polynomial, binomials};
use super::rational::sign;
use dashu_int::IBig;
use dashu_int::ops::{BitTest, UnsignedAbs};
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::ComputeEigenvectors;
use faer::linalg::gevd::{gevd_real, gevd_scratch};
use faer::{Mat, Par};

/// The coefficients of `x^k`, `x = t / (1 - t)`: Bernstein coefficients times binomials, at the polynomial's own degree.
pub(crate) fn scaled_bernstein(f: &Polynomial) -> Vec<IBig> {
    let n = f.degree();
    let mut c = vec![IBig::ZERO; n + 1];
    for (j, a) in f.0.iter().enumerate() {
        // t^j = x^j (1 + x)^(n - j) (1 - t)^n.
        for (i, b) in binomials(n - j).iter().enumerate() {
            c[j + i] += a * b;
        }
    }
    c
}

/// `x 2^-shift` in f64, cut.
fn scaled(x: &IBig, shift: usize) -> f64 {
    let bits = x.unsigned_abs().bit_len();
    let cut = bits.saturating_sub(53);
    let head = i64::try_from(x.clone().unsigned_abs() >> cut).map_or(0.0, |m| m as f64);
    let exponent = cut as i64 - shift as i64;
    let size = if exponent < -1000 {
        0.0
    } else {
        head * 2f64.powi(exponent as i32)
    };
    if sign(x) < 0 { -size } else { size }
}

/// The Bernstein coefficients at the polynomial's own degree, in f64, by a common factor.
pub(crate) fn bernstein(f: &Polynomial) -> Vec<f64> {
    let c = scaled_bernstein(f);
    // Rounded to an integer: with 64 bits more that loses nothing.
    let b: Vec<IBig> = c
        .iter()
        .zip(&binomials(f.degree()))
        .map(|(c, k)| (c.clone() << 64) / k)
        .collect();
    let bits = b
        .iter()
        .map(|x| x.unsigned_abs().bit_len())
        .max()
        .unwrap_or(0);
    b.iter().map(|x| scaled(x, bits)).collect()
}

/// Real numbers in about [0, 1] near which roots may be, ascending. O(n^3) in f64: 0.1 ms at degree 10, 2 ms at 48.
pub(crate) fn candidates(f: &Polynomial) -> Vec<f64> {
    let n = f.degree();
    if n == 0 {
        return Vec::new();
    }
    let b = bernstein(f);
    let last = n - 1;
    let first = Mat::from_fn(n, n, |i, j| match (i == last, j == i + 1) {
        (true, _) => -(n as f64) * b[j],
        (false, true) => (i + 1) as f64,
        (false, false) => 0.0,
    });
    let second = Mat::from_fn(n, n, |i, j| match (i == j, i == last) {
        (true, true) => b[n],
        (true, false) => (n - i) as f64,
        (false, _) => 0.0,
    });
    let mut sum = &first + &second;
    let mut first = first;
    let (mut re, mut im, mut beta) = (Diag::zeros(n), Diag::zeros(n), Diag::zeros(n));
    // Not `Mat::generalized_eigen`: it also makes vectors, for which faer 0.24 reserves too little memory, and panics.
    let none = ComputeEigenvectors::No;
    let layout = gevd_scratch::<f64>(n, none, none, Par::Seq, Default::default());
    let done = gevd_real(
        first.as_mut(),
        sum.as_mut(),
        re.as_mut(),
        im.as_mut(),
        beta.as_mut(),
        None,
        None,
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(layout)),
        Default::default(),
    );
    if done.is_err() {
        return Vec::new();
    }
    /// How far from [0, 1], and from the real line, the eigenvalue of a real root there may be: those of multiple
    /// roots stray.
    const STRAY: f64 = 0.0625;
    let mut out: Vec<f64> = (0..n)
        .filter_map(|i| {
            let (re, im) = (re[i] / beta[i], im[i] / beta[i]);
            let near = im.abs() <= STRAY && (-STRAY..=1.0 + STRAY).contains(&re);
            near.then(|| re.clamp(0.0, 1.0))
        })
        .collect();
    out.sort_by(f64::total_cmp);
    out.dedup();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_are_near_the_roots() {
        // (4t - 1) (2t - 1) (t - 3) (10 t - 9) (t^2 + 1)
        let mut f = Polynomial(vec![IBig::ONE]);
        for g in [&[-1, 4][..], &[-1, 2], &[-3, 1], &[-9, 10], &[1, 0, 1]] {
            f = f.times(&Polynomial::new(g.iter().map(|x| IBig::from(*x)).collect()));
        }
        let found = candidates(&f);
        assert_eq!(found.len(), 3, "{found:?}");
        for (x, y) in found.iter().zip([0.25, 0.5, 0.9]) {
            assert!((x - y).abs() < 1e-13, "{found:?}");
        }
    }

    #[test]
    fn wilkinson_of_degree_24_is_found_from_f64() {
        let mut f = Polynomial(vec![IBig::ONE]);
        for k in 1..=24 {
            f = f.times(&Polynomial::new(vec![IBig::from(-k), IBig::from(25)]));
        }
        let found = candidates(&f);
        assert_eq!(found.len(), 24);
        for (k, x) in found.iter().enumerate() {
            assert!((x - (k + 1) as f64 / 25.0).abs() < 1e-6, "{k} {x}");
        }
    }
}
