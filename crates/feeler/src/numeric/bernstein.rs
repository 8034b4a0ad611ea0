//! Polynomials in Bernstein form: products, subdivision, evaluation.
//!
//! A tensor-product polynomial of bidegree `(m, n)` on the unit square has
//! coefficients `c[i * (n + 1) + j]`; a polynomial of one variable has `n = 0`.
//! Source: R. Farouki, V. Rajan, *Algorithms for polynomials in Bernstein
//! form*, CAGD 5 (1988).

use super::{Ball, Real};

/// The bidegree of a tensor-product polynomial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bidegree {
    /// Degree along u.
    pub u: usize,
    /// Degree along v.
    pub v: usize,
}

impl Bidegree {
    /// How many coefficients there are.
    pub fn count(self) -> usize {
        (self.u + 1) * (self.v + 1)
    }
}

impl std::ops::Add for Bidegree {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            u: self.u + o.u,
            v: self.v + o.v,
        }
    }
}

/// Row `n` of Pascal's triangle; each entry off by at most `n` units.
pub fn binomials<T: Real>(n: usize) -> Vec<T> {
    let mut row = vec![T::ONE; n + 1];
    for k in 1..n {
        for i in (1..=k).rev() {
            row[i] = row[i] + row[i - 1];
        }
    }
    row
}

/// How many units of rounding a coefficient of a [`product`] of factors of bidegrees `a` and `b`
/// can be off by, relative to (largest coefficient of one) x (largest of the other).
///
/// Proof: coefficient `(m, n)` of the product is `sum w_ijkl x_ij y_kl` with
/// `w_ijkl = C(a.u, i) C(b.u, k) / C(a.u + b.u, m) * (the same in v) >= 0` and `sum w = 1`, so it is a convex
/// combination of the `x_ij y_kl`. Each term meets six binomials (at most
/// `a.u + b.u + a.v + b.v` additions each side, so twice that in all), at most six products and one
/// quotient (worth two units), and at most `(min(a.u, b.u) + 1)(min(a.v, b.v) + 1)` additions. To first
/// order the error is at most the sum of these counts times the unit, times `max|x| max|y|`;
/// 16 more units cover the higher orders for counts below 10^6.
pub fn product_units(a: Bidegree, b: Bidegree) -> f64 {
    let sum = a + b;
    let binomials = 4 * (sum.u + sum.v);
    let additions = (a.u.min(b.u) + 1) * (a.v.min(b.v) + 1);
    (binomials + additions + 8 + 16) as f64
}

/// Multiplies coefficients by their binomials (scaled Bernstein form).
fn scale<T: Real>(c: &[T], degree: Bidegree) -> Vec<T> {
    let (bu, bv) = (binomials::<T>(degree.u), binomials::<T>(degree.v));
    let mut out = Vec::with_capacity(c.len());
    for (i, row) in c.chunks_exact(degree.v + 1).enumerate() {
        out.extend(row.iter().zip(&bv).map(|(x, b)| *x * (bu[i] * *b)));
    }
    out
}

/// Adds the product of two polynomials to `sum`, all in scaled Bernstein form.
fn multiply_scaled<T: Real>(x: &[T], a: Bidegree, y: &[T], b: Bidegree, sum: &mut [T]) {
    let width = a.v + b.v + 1;
    for i in 0..=a.u {
        let xs = &x[i * (a.v + 1)..(i + 1) * (a.v + 1)];
        for k in 0..=b.u {
            let row = &mut sum[(i + k) * width..(i + k + 1) * width];
            let ys = &y[k * (b.v + 1)..(k + 1) * (b.v + 1)];
            // Of quadratics and cubics with a length that the compiler knows.
            if let Ok(ys) = ys.try_into() {
                multiply_row::<T, 3>(xs, ys, row);
            } else if let Ok(ys) = ys.try_into() {
                multiply_row::<T, 4>(xs, ys, row);
            } else {
                for (j, xi) in xs.iter().enumerate() {
                    add_multiple(*xi, ys, &mut row[j..]);
                }
            }
        }
    }
}

/// Adds the product of two rows to `sum`.
#[inline(always)]
fn multiply_row<T: Real, const N: usize>(x: &[T], y: &[T; N], sum: &mut [T]) {
    for (j, xi) in x.iter().enumerate() {
        if let Some(part) = sum[j..].first_chunk_mut::<N>() {
            add_multiple(*xi, y, part);
        }
    }
}

#[inline(always)]
fn add_multiple<T: Real>(x: T, y: &[T], sum: &mut [T]) {
    for (r, yl) in sum.iter_mut().zip(y) {
        *r = *r + x * *yl;
    }
}

/// The product of two polynomials; see [`product_units`] for its error.
pub fn product<T: Real>(x: &[T], a: Bidegree, y: &[T], b: Bidegree) -> Vec<T> {
    let degree = a + b;
    let mut sum = vec![T::ZERO; degree.count()];
    multiply_scaled(&scale(x, a), a, &scale(y, b), b, &mut sum);
    let (bu, bv) = (binomials::<T>(degree.u), binomials::<T>(degree.v));
    for (i, row) in sum.chunks_exact_mut(degree.v + 1).enumerate() {
        for (c, b) in row.iter_mut().zip(&bv) {
            *c = *c / (bu[i] * *b);
        }
    }
    sum
}

/// The largest magnitude of the coefficients.
pub fn largest<T: Real>(c: &[T]) -> f64 {
    let most = c.iter().fold(0.0, |m, x| greater(m, x.approximate().abs()));
    // As `magnitude` has it, of the largest: rounding is monotone.
    most * (1.0 + f64::EPSILON)
}

/// The lesser of two numbers; the first where the second is none. (Unlike `f64::min` it is one instruction.)
#[inline(always)]
pub(crate) fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The greater of two numbers; the first where the second is none.
#[inline(always)]
pub(crate) fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Splits a polynomial in the middle, along u or along v: `c` becomes the first half, the second is given back. Each coefficient of
/// the halves is an average of the old ones, so errors of the old ones are not amplified, and each of
/// the at most `degree` averagings adds one rounding: see [`split_error`].
pub fn split_off<T: Real>(c: &mut [T], degree: Bidegree, along_u: bool) -> Vec<T> {
    let mut right = Vec::new();
    split_into(c, &mut right, degree, along_u);
    right
}

/// The same with a list for the second half, whatever it holds.
pub(crate) fn split_into<T: Real>(
    c: &mut [T],
    right: &mut Vec<T>,
    degree: Bidegree,
    along_u: bool,
) {
    right.clear();
    right.extend_from_slice(c);
    let width = degree.v + 1;
    if along_u {
        // Whole rows at once: the same averages, in an order that processors like.
        match width {
            // A curve.
            1 => return split_row(right, c),
            5 => return split_columns::<T, 5>(right, c),
            7 => return split_columns::<T, 7>(right, c),
            _ => {}
        }
        for k in 1..=degree.u {
            for i in 0..=degree.u - k {
                let (low, high) = right[i * width..(i + 2) * width].split_at_mut(width);
                for (a, b) in low.iter_mut().zip(high) {
                    *a = (*a + *b).half();
                }
            }
            c[k * width..(k + 1) * width].copy_from_slice(&right[..width]);
        }
        return;
    }
    match width {
        5 => split_rows::<T, 5>(right, c),
        7 => split_rows::<T, 7>(right, c),
        _ => {
            let rows = right.chunks_exact_mut(width).zip(c.chunks_exact_mut(width));
            rows.for_each(|(row, left)| split_row(row, left));
        }
    }
}

/// What one [`split_off`] adds to the error of coefficients no larger than `largest`, where an operation that underflows may lose `tiny`.
pub fn split_error<T: Real>(degree: Bidegree, along_u: bool, largest: f64, tiny: f64) -> f64 {
    let count = if along_u { degree.u } else { degree.v } as f64;
    count * (T::UNIT * largest * (1.0 + 64.0 * f64::EPSILON) + tiny)
}

/// The coefficients on one border: at the low or the high end of u (or v).
pub(crate) fn border<T: Copy>(c: &[T], degree: Bidegree, along_u: bool, high: bool) -> Vec<T> {
    let mut out = Vec::new();
    border_into(c, &mut out, degree, along_u, high);
    out
}

/// The same in a list, whatever it holds.
pub(crate) fn border_into<T: Copy>(
    c: &[T],
    out: &mut Vec<T>,
    degree: Bidegree,
    along_u: bool,
    high: bool,
) {
    let width = degree.v + 1;
    out.clear();
    if along_u {
        let i = if high { degree.u } else { 0 };
        out.extend_from_slice(&c[i * width..(i + 1) * width]);
    } else {
        let j = if high { degree.v } else { 0 };
        out.extend(c.iter().skip(j).step_by(width));
    }
}

/// Leaves the part of a polynomial over a range `[a, b]` of `[0, 1]`, along u or along v (de Casteljau's algorithm at `b`, then at `a / b`: The NURBS
/// Book, 5.3 for the whole net). See [`part_error`] for what it is off. The range may end past `[0, 1]` by a little.
pub fn keep_part<T: Real>(c: &mut [T], degree: Bidegree, along_u: bool, range: [f64; 2]) {
    let [a, b] = range;
    // Each to its own digits: of a sum of two that are positive no part is lost, however unlike they are.
    let weights = |t: f64, of: f64| {
        let [t, of] = [t, of].map(T::from_f64);
        [(of - t) / of, t / of]
    };
    if a < 0.0 {
        // At `a` first: what is past the border is small beside what is left then, as it may not be beside `b`.
        keep_high(c, degree, along_u, weights(a, 1.0));
        let [a, b] = [a, b].map(T::from_f64);
        let of = T::ONE - a;
        keep_low(c, degree, along_u, [(T::ONE - b) / of, (b - a) / of]);
        return;
    }
    if b != 1.0 {
        keep_low(c, degree, along_u, weights(b, 1.0));
    }
    if a > 0.0 {
        keep_high(c, degree, along_u, weights(a, b));
    }
}

/// The part below a parameter, given the weights of the two that a step is of.
fn keep_low<T: Real>(c: &mut [T], degree: Bidegree, along_u: bool, [s, t]: [T; 2]) {
    let width = degree.v + 1;
    if along_u {
        // Whole rows at once.
        for k in 1..=degree.u {
            for i in (k..=degree.u).rev() {
                let (low, high) = c[(i - 1) * width..(i + 1) * width].split_at_mut(width);
                low.iter().zip(high).for_each(|(x, y)| *y = s * *x + t * *y);
            }
        }
    } else {
        each_row(c, width, |row| {
            for k in 1..row.len() {
                for i in (k..row.len()).rev() {
                    row[i] = s * row[i - 1] + t * row[i];
                }
            }
        });
    }
}

/// The part above it.
fn keep_high<T: Real>(c: &mut [T], degree: Bidegree, along_u: bool, [s, t]: [T; 2]) {
    let width = degree.v + 1;
    if along_u {
        for k in 1..=degree.u {
            for i in 0..=degree.u - k {
                let (low, high) = c[i * width..(i + 2) * width].split_at_mut(width);
                low.iter_mut()
                    .zip(high)
                    .for_each(|(x, y)| *x = s * *x + t * *y);
            }
        }
    } else {
        each_row(c, width, |row| {
            for k in 1..row.len() {
                for i in 0..row.len() - k {
                    row[i] = s * row[i] + t * row[i + 1];
                }
            }
        });
    }
}

/// Does something with each row of a net; rows of products of quadratics and cubics have lengths that the compiler knows.
#[inline(always)]
fn each_row<T>(c: &mut [T], width: usize, work: impl Fn(&mut [T])) {
    match width {
        5 => c
            .as_chunks_mut::<5>()
            .0
            .iter_mut()
            .for_each(|row| work(row)),
        7 => c
            .as_chunks_mut::<7>()
            .0
            .iter_mut()
            .for_each(|row| work(row)),
        _ => c.chunks_exact_mut(width).for_each(work),
    }
}

/// What each coefficient of a [part](keep_part) may be off.
///
/// A step makes `s x + t y` of `t = a / b` and `s = (b - a) / b`, off by `DIV_UNIT` and `UNIT + DIV_UNIT` of themselves: with the roundings of the two
/// products and the sum that is `DIV_UNIT + 3 UNIT` of `s |x| + t |y|` at most. So what bounds `x` and `y`, one number or positive numbers
/// to which the same is done, is counted in those parts. Earlier errors are averaged. There are `degree` steps at each of both ends. (Of the quotients over `1 - a` both parts
/// may be off by a unit: four units and `DIV_UNIT` in all.) Of a range that ends past `[0, 1]` by up to `e` the two weights are `1 + 2 e` in size together, and so much more than this may
/// be each step's errors, and what it makes of earlier ones.
pub fn part_error<T: Real>(degree: Bidegree, along_u: bool, largest: f64, tiny: f64) -> f64 {
    let count = if along_u { degree.u } else { degree.v } as f64;
    let step = (4.0 * T::UNIT + 2.0 * T::DIV_UNIT) * largest * (1.0 + 64.0 * f64::EPSILON);
    2.0 * count * (step + 3.0 * tiny)
}

fn split_columns<T: Real, const WIDTH: usize>(right: &mut [T], left: &mut [T]) {
    let (rows, left) = (
        right.as_chunks_mut::<WIDTH>().0,
        left.as_chunks_mut::<WIDTH>().0,
    );
    for k in 1..rows.len() {
        for i in 0..rows.len() - k {
            let next = rows[i + 1];
            for (a, b) in rows[i].iter_mut().zip(next) {
                *a = (*a + b).half();
            }
        }
        left[k] = rows[0];
    }
}

fn split_rows<T: Real, const WIDTH: usize>(right: &mut [T], left: &mut [T]) {
    let rows = right.as_chunks_mut::<WIDTH>().0.iter_mut();
    for (row, left) in rows.zip(left.as_chunks_mut::<WIDTH>().0) {
        split_row(row, left);
    }
}

#[inline(always)]
fn split_row<T: Real>(row: &mut [T], left: &mut [T]) {
    for k in 1..row.len() {
        for i in 0..row.len() - k {
            row[i] = (row[i] + row[i + 1]).half();
        }
        left[k] = row[0];
    }
}

/// The same for the rows of any net, as an iterator over rows of `width`: the widths of products of quadratics and cubics
/// are constants, so that loops over a row are unrolled.
macro_rules! by_width {
    ($c:expr, $width:expr, $rows:ident, $body:block) => {
        match $width {
            5 => {
                let $rows = $c.as_chunks::<5>().0.iter();
                $body
            }
            7 => {
                let $rows = $c.as_chunks::<7>().0.iter();
                $body
            }
            _ => {
                let $rows = $c.chunks_exact($width);
                $body
            }
        }
    };
}
pub(crate) use by_width;

/// A polynomial of one variable at `t` by de Casteljau, with the running error.
/// `c` is used up.
pub fn evaluate<T: Real>(mut c: Vec<Ball<T>>, t: Ball<T>) -> Ball<T> {
    let s = Ball::ONE - t;
    for k in (1..c.len()).rev() {
        for i in 0..k {
            c[i] = s * c[i] + t * c[i + 1];
        }
    }
    c.first().copied().unwrap_or(Ball::ZERO)
}

#[cfg(test)]
mod tests {
    use super::super::TINY;
    use super::*;
    use crate::numeric::Dd;
    use dashu_ratio::RBig as Q;

    const A: Bidegree = Bidegree { u: 3, v: 2 };
    const B: Bidegree = Bidegree { u: 2, v: 4 };

    fn sample(degree: Bidegree, seed: u64) -> Vec<f64> {
        let mut s = seed;
        (0..degree.count())
            .map(|_| {
                s = s.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (s >> 40) as f64 / (1u64 << 23) as f64 - 1.0
            })
            .collect()
    }

    fn at(c: &[f64], degree: Bidegree, u: f64, v: f64) -> Ball<Dd> {
        let rows = c
            .chunks_exact(degree.v + 1)
            .map(|r| evaluate(r.iter().map(|x| Ball::exact(*x)).collect(), Ball::exact(v)))
            .collect();
        evaluate(rows, Ball::exact(u))
    }

    /// As the proof counts: twice the binomials' additions, six products and a quotient worth two, the additions, 16 more.
    #[test]
    fn product_units_are_at_least_the_proofs() {
        let square = |n| Bidegree { u: n, v: n };
        for (a, b) in [(A, B), (square(0), square(0)), (square(20), square(20))] {
            let sum = a + b;
            let additions = (a.u.min(b.u) + 1) * (a.v.min(b.v) + 1);
            let count = 2 * (sum.u + sum.v) + 6 + 2 + additions + 16;
            let units = product_units(a, b);
            assert!(count as f64 <= units && units <= 2.0 * count as f64);
        }
    }

    #[test]
    fn bounds_are_no_larger_than_need_be() {
        let most = largest(&[1.0, -3.0, 2.0]);
        assert!((3.0..=3.0 * (1.0 + 2.0 * f64::EPSILON)).contains(&most));
        assert_eq!(largest::<f64>(&[]), 0.0);
        // An averaging each of the degree, of numbers up to 3.
        for (along_u, degree) in [(true, 2.0), (false, 4.0)] {
            let error = split_error::<f64>(B, along_u, 3.0, TINY);
            let plain = degree * 3.0 * f64::UNIT;
            assert!((plain..=plain * 1.001).contains(&error), "{error:e}");
        }
        assert_eq!(split_error::<f64>(B, true, 0.0, 1.0), 2.0);
        // Two ends, four roundings and two quotients for each of the degree; a few bits of numbers that all have.
        for (along_u, degree) in [(true, 2.0), (false, 4.0)] {
            let error = part_error::<f64>(B, along_u, 3.0, 0.0);
            let plain = 2.0 * degree * (4.0 * f64::UNIT + 2.0 * f64::DIV_UNIT) * 3.0;
            assert!((plain..=plain * 1.001).contains(&error), "{error:e}");
        }
    }

    #[test]
    fn what_is_no_number_is_passed_over() {
        let nan = f64::NAN;
        assert_eq!(
            [lesser(1.0, 2.0), lesser(2.0, 1.0), lesser(1.0, nan)],
            [1.0; 3]
        );
        assert_eq!(
            [greater(1.0, 2.0), greater(2.0, 1.0), greater(2.0, nan)],
            [2.0; 3]
        );
    }

    #[test]
    fn product_is_the_product() {
        let (x, y) = (sample(A, 1), sample(B, 2));
        let p = product(&x, A, &y, B);
        let bound = product_units(A, B) * f64::UNIT * largest(&x) * largest(&y);
        for (u, v) in [(0.0, 0.0), (0.25, 0.5), (1.0, 0.125), (0.7, 0.3)] {
            let error = at(&p, A + B, u, v) - at(&x, A, u, v) * at(&y, B, u, v);
            assert!(error.magnitude() <= bound, "{error:?} > {bound}");
        }
    }

    /// In parts of the coefficients themselves, where these are positive and differ by powers of ten: a weight's errors may not be those of a greater one.
    #[test]
    fn parts_of_weights_keep_their_digits() {
        fn check<T: Real>(w: f64, range: [f64; 2], exact: impl Fn(T) -> Q) {
            let q = |x: f64| Q::try_from(x).unwrap();
            let line = Bidegree { u: 2, v: 0 };
            let c = [1.0, w, w * w];
            let mut part = c.map(T::from_f64);
            keep_part(&mut part, line, true, range);
            // The blossom at each pair of ends.
            let [a, b] = range.map(q);
            let blossom = |x: &Q, y: &Q| {
                let mean = |p: &Q, r: &Q, t: &Q| p + (r - p) * t;
                let [c0, c1, c2] = c.map(q);
                mean(&mean(&c0, &c1, x), &mean(&c1, &c2, x), y)
            };
            let truth = [blossom(&a, &a), blossom(&a, &b), blossom(&b, &b)];
            let bound = q(part_error::<T>(line, true, 1.0, 0.0));
            for (x, truth) in part.into_iter().zip(truth) {
                let off = exact(x) - &truth;
                let off = if off < Q::ZERO { -off } else { off };
                assert!(off <= &bound * &truth, "{w:e} {range:?}");
            }
        }
        let q = |x: f64| Q::try_from(x).unwrap();
        for w in [1e-3, 1e-6, 1.8e-16] {
            for width in [1.0 / 16.0, 1.0 / (1u64 << 30) as f64] {
                for steps in [1.0, 3.0, 7.0] {
                    let range = [1.0 - (steps + 1.0) * width, 1.0 - steps * width];
                    check::<f64>(w, range, q);
                    check::<Dd>(w, range, |x| q(x.hi) + q(x.lo));
                }
            }
        }
    }

    #[test]
    fn parts_are_the_same_polynomial() {
        let x = sample(B, 4);
        const PAST: f64 = 1.0 / 1024.0;
        let within = [[0.0, 0.3], [0.6, 1.0], [0.1, 0.7], [0.0, 1.0]];
        /// Ranges about a border, in which steps far past what is left would lose all.
        const NARROW: f64 = 1.0 / (1u64 << 20) as f64;
        let past = [
            [-PAST, 0.3],
            [0.9, 1.0 + PAST],
            [-PAST, 1.0 + PAST],
            [-NARROW, NARROW],
            [-PAST, NARROW * NARROW],
            [1.0 - NARROW, 1.0 + NARROW],
        ];
        for range in within.into_iter().chain(past) {
            for along_u in [true, false] {
                let mut part = x.clone();
                keep_part(&mut part, B, along_u, range);
                let growth = (1.0 + 2.0 * PAST).powi(2 * B.u.max(B.v) as i32);
                let bound = part_error::<f64>(B, along_u, largest(&x), TINY) * growth;
                for (s, t) in [(0.0, 0.5), (0.25, 1.0), (0.75, 0.125)] {
                    let exact = |x: f64| Ball::<Dd>::exact(x);
                    let along = if along_u { s } else { t };
                    let there =
                        exact(range[0]) + exact(along) * Ball::difference(range[1], range[0]);
                    let rows = |u: Ball<Dd>, v: Ball<Dd>, c: &[f64]| {
                        let rows = c.chunks_exact(B.v + 1);
                        let rows =
                            rows.map(|r| evaluate(r.iter().map(|x| Ball::exact(*x)).collect(), v));
                        evaluate(rows.collect(), u)
                    };
                    let of_whole = if along_u {
                        rows(there, exact(t), &x)
                    } else {
                        rows(exact(s), there, &x)
                    };
                    let error = at(&part, B, s, t) - of_whole;
                    assert!(error.magnitude() <= bound, "{error:?} > {bound}");
                }
            }
        }
    }

    #[test]
    fn halves_are_the_same_polynomial() {
        let x = sample(B, 3);
        for along_u in [true, false] {
            let mut l = x.clone();
            let r = split_off(&mut l, B, along_u);
            let bound = split_error::<f64>(B, along_u, largest(&x), TINY);
            for (u, v) in [(0.25, 0.5), (0.875, 0.125), (0.5, 0.5)] {
                let (half, local) = if along_u {
                    (if u < 0.5 { &l } else { &r }, ((2.0 * u) % 1.0, v))
                } else {
                    (if v < 0.5 { &l } else { &r }, (u, (2.0 * v) % 1.0))
                };
                let error = at(half, B, local.0, local.1) - at(&x, B, u, v);
                assert!(error.magnitude() <= bound, "{error:?} > {bound}");
            }
        }
    }
}
