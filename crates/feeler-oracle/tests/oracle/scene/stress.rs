//! Curves whose derivative roots are known from how they are made.

use super::bezier;
use feeler::nurbs::Curve2;

/// The binomials `C(n, 0..=n)`.
pub(crate) fn binomials(n: usize) -> Vec<i128> {
    let mut row = vec![1i128];
    for i in 0..n {
        row.push(row[i] * (n - i) as i128 / (i as i128 + 1));
    }
    row
}

/// Bernstein coefficients of the product of linear factors given by their values at 0 and 1, times
/// a common factor that makes them integers.
pub(crate) fn product(factors: &[[i128; 2]]) -> Vec<i128> {
    let mut c = vec![1i128];
    for [at_0, at_1] in factors {
        let mut next = vec![0; c.len() + 1];
        for (i, x) in c.iter().enumerate() {
            next[i] += x * at_0;
            next[i + 1] += x * at_1;
        }
        c = next;
    }
    let n = binomials(c.len() - 1);
    let gcd = |mut a: i128, mut b: i128| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let lcm = n.iter().fold(1, |l, x| l / gcd(l, *x) * x);
    c.iter().zip(&n).map(|(c, n)| c * (lcm / n)).collect()
}

/// The factor with the root p / q.
pub(crate) fn root(p: i128, q: i128) -> [i128; 2] {
    [-p, q - p]
}

/// Integer control values whose differences these are; all of them exact in f64.
pub(crate) fn integral(differences: &[i128]) -> Vec<f64> {
    let mut sum = 0i128;
    let mut out = vec![0.0];
    for d in differences {
        sum += d;
        assert_eq!(sum as f64 as i128, sum, "not exact in f64");
        out.push(sum as f64);
    }
    out
}

/// A polynomial Bezier curve with these control values; the shorter list is raised in degree by
/// steps of `t`, so it must be linear or of equal length.
pub(crate) fn curve(u: &[f64], v: &[f64]) -> Curve2 {
    assert_eq!(u.len(), v.len());
    let points: Vec<[f64; 3]> = u.iter().zip(v).map(|(u, v)| [*u, *v, 1.0]).collect();
    bezier(&points)
}

/// `v' = ` the product of these factors, `u = t` times the degree.
pub(crate) fn graph(factors: &[[i128; 2]]) -> Curve2 {
    let v = integral(&product(factors));
    let u: Vec<f64> = (0..v.len()).map(|i| i as f64).collect();
    curve(&u, &v)
}

/// `t -> (t, T_n(2t - 1))`, rounded: Bernstein coefficients `(-1)^(n-i) C(2n, 2i) / C(n, i)`
/// (Farouki and Rajan, *Algorithms for polynomials in Bernstein form*, CAGD 5 (1988)).
pub(crate) fn chebyshev(n: usize) -> Vec<f64> {
    let (c, d) = (binomials(n), binomials(2 * n));
    (0..=n)
        .map(|i| {
            let sign = if (n - i).is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * d[2 * i] as f64 / c[i] as f64
        })
        .collect()
}

/// The same curve run by `t -> l t / (1 - t + l t)`: weights 1, l, l^2, ...; exact for l a power
/// of two.
pub(crate) fn reweighted(u: &[f64], v: &[f64], l: f64) -> Curve2 {
    let points: Vec<[f64; 3]> = u
        .iter()
        .zip(v)
        .enumerate()
        .map(|(i, (u, v))| {
            let w = l.powi(i as i32);
            [u * w, v * w, w]
        })
        .collect();
    bezier(&points)
}
