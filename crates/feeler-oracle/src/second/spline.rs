//! B-splines by definitions other than those of the first method.
//!
//! *Values*: a B-spline is a divided difference of a truncated power, `N_i(t) = (k_(i+p+1) - k_i) [k_i, ..,
//! k_(i+p+1)] (. - t)_+^p` (I. J. Schoenberg; C. de Boor, *A Practical Guide to Splines*, IX), repeated knots taken
//! as derivatives; the derivative in t is that of the truncated power. At a knot the limit from above counts, at the end
//! of the domain that from below.
//!
//! *Pieces*: knots are inserted (W. Boehm, *Inserting new knots into B-spline curves*, CAD 12 (1980)) until each span
//! in use is a Bezier curve. All of it in exact rationals.

use super::fraction::Fraction;
use super::rational::signum;
use dashu_int::IBig;

/// The value and two derivatives of those basis functions that are not zero at `t`: the index of the first of them, and
/// three numbers a function.
pub(crate) fn basis(
    degree: usize,
    knots: &[Fraction],
    t: &Fraction,
) -> (usize, Vec<[Fraction; 3]>) {
    let count = knots.len() - degree - 1;
    let at_end = *t >= knots[count];
    let span = (degree..count)
        .filter(|i| knots[*i] < knots[*i + 1])
        .rfind(|i| knots[*i] <= *t)
        .unwrap_or(degree);
    let first = span - degree;
    let functions = (first..=span).map(|i| {
        let k = &knots[i..=i + degree + 1];
        let width = &k[degree + 1] - &k[0];
        let value = divided_difference(k, t, degree, at_end) * &width;
        let slope = divided_difference(k, t, degree - 1, at_end) * &width;
        let bend = match degree {
            1 => Fraction::ZERO,
            _ => divided_difference(k, t, degree - 2, at_end) * width,
        };
        let p = Fraction::from(degree);
        let bend = bend * &p * Fraction::from(degree - 1);
        [value, -slope * p, bend]
    });
    (first, functions.collect())
}

/// The divided difference over `x` of `(. - t)_+^m`.
fn divided_difference(x: &[Fraction], t: &Fraction, m: usize, closed: bool) -> Fraction {
    // Of order r at one place: the r-th derivative over r!, C(m, r) (x - t)^(m - r).
    let confluent = |x: &Fraction, r: usize| {
        let beyond = if closed { x >= t } else { x > t };
        if !beyond || r > m {
            return Fraction::ZERO;
        }
        let binomial = super::polynomial::binomials(m)[r].clone();
        (x - t).pow(m - r) * Fraction::from(binomial)
    };
    let mut column: Vec<Fraction> = x.iter().map(|x| confluent(x, 0)).collect();
    for order in 1..x.len() {
        column = (0..x.len() - order)
            .map(|i| {
                let width = &x[i + order] - &x[i];
                if signum(&width) == 0 {
                    confluent(&x[i], order)
                } else {
                    (&column[i + 1] - &column[i]) / width
                }
            })
            .collect();
    }
    column.swap_remove(0)
}

/// Control points of a Bezier curve, each with its homogeneous coordinates, and its part of the parameter.
pub(crate) struct BezierPiece {
    pub(crate) points: Vec<Vec<Fraction>>,
    pub(crate) from: Fraction,
    pub(crate) to: Fraction,
}

/// The non-empty Bezier pieces of a spline over `[from, to]`, which lies in its domain.
pub(crate) fn pieces(
    degree: usize,
    knots: &[Fraction],
    points: &[Vec<Fraction>],
    from: &Fraction,
    to: &Fraction,
) -> Vec<BezierPiece> {
    let mut knots = knots.to_vec();
    let mut points = points.to_vec();
    let mut breaks: Vec<Fraction> = vec![from.clone()];
    for k in &knots {
        if breaks[breaks.len() - 1] < *k && k < to {
            breaks.push(k.clone());
        }
    }
    breaks.push(to.clone());
    for x in &breaks {
        while knots.iter().filter(|k| *k == x).count() < degree {
            insert(degree, &mut knots, &mut points, x);
        }
    }
    let mut out = Vec::with_capacity(breaks.len() - 1);
    for pair in breaks.windows(2) {
        // Knots s - p + 1 ..= s are all `from`, those after it `to`: p + 1 points belong to the span.
        let Some(s) = knots.iter().rposition(|k| *k == pair[0]) else {
            continue;
        };
        out.push(BezierPiece {
            points: points[s - degree..=s].to_vec(),
            from: pair[0].clone(),
            to: pair[1].clone(),
        });
    }
    out
}

/// Inserts `x` once; its multiplicity is below the degree.
fn insert(degree: usize, knots: &mut Vec<Fraction>, points: &mut Vec<Vec<Fraction>>, x: &Fraction) {
    let above = knots.iter().position(|k| k > x).unwrap_or(knots.len());
    let multiplicity = knots[..above].iter().rev().take_while(|k| *k == x).count();
    // x is in [k_s, k_(s+1)); the end of the domain may be the last knot, where nothing is inserted
    // unless knots go on beyond it.
    let s = above - 1;
    let mut next = Vec::with_capacity(points.len() + 1);
    next.extend_from_slice(&points[..=s - degree]);
    for i in s - degree + 1..=s - multiplicity {
        let width = &knots[i + degree] - &knots[i];
        let a = (x - &knots[i]) / width;
        let b = Fraction::from(IBig::ONE) - &a;
        let (lower, upper) = (&points[i - 1], &points[i]);
        let mixed = upper.iter().zip(lower).map(|(u, l)| &a * u + &b * l);
        next.push(mixed.collect());
    }
    next.extend_from_slice(&points[s - multiplicity..]);
    *points = next;
    knots.insert(above, x.clone());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::second::rational::rationals;

    /// Whatever the knots, the functions sum to 1, and their derivatives to 0.
    #[test]
    fn knots_of_all_sizes() {
        let mut state = 3_u64;
        let mut next = |n: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        for degree in [3, 5, 8] {
            for _ in 0..6 {
                // Powers of two far apart, the digits of a few ones beside them.
                let mut knots: Vec<f64> = (0..2 * degree + 2)
                    .map(|_| {
                        let size = (next(1500) as f64 - 1000.0).exp2();
                        size * (1.0 + next(1 << 30) as f64 * f64::EPSILON)
                    })
                    .collect();
                knots.sort_by(f64::total_cmp);
                let t = 0.5 * (knots[degree] + knots[degree + 1]);
                let exact = rationals(&knots).unwrap();
                let (_, functions) = basis(degree, &exact, &rationals(&[t]).unwrap()[0]);
                for (k, sum) in [1, 0, 0].into_iter().enumerate() {
                    let all = functions.iter().fold(Fraction::ZERO, |a, f| a + &f[k]);
                    assert_eq!(all, Fraction::from(sum), "{degree} {knots:?}");
                }
            }
        }
    }
}
