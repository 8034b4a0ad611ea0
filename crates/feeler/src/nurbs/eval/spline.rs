//! De Boor's triangle for points and all derivatives.

use super::Scalar;
use super::parameter::Parameter;
use crate::nurbs::KnotVector;
use nalgebra::SVector;

/// One knot difference of the triangle: where the parameter lies within it.
#[derive(Clone, Copy)]
struct Ratio<S> {
    /// `(t - k_m) / width` or `(k_{m+L} - t) / width`, whichever is the smaller.
    smaller: S,
    /// Whether `smaller` is the first of these.
    low: bool,
    /// `k_{m+L} - k_m`, positive.
    width: S,
}

/// Everything of a parameter that does not depend on the control points.
pub(super) struct Span<S> {
    /// The span's index; the active control points are `span - degree ..= span`.
    pub(super) index: usize,
    degree: usize,
    /// Ratios of level L = 1 ..= p, m = span - L + 1 ..= span, at `L (L - 1) / 2 + m - (span - L + 1)`.
    ratios: Vec<Ratio<S>>,
}

impl<S: Scalar> Span<S> {
    pub(super) fn new(knots: &KnotVector, t: &Parameter) -> Self {
        let degree = knots.degree();
        let index = t.find_span(knots);
        let k = knots.knots();
        // t - k_{span-j} and k_{span+1+j} - t, neither negative.
        let below: Vec<S> = (0..degree).map(|j| t.minus(k[index - j])).collect();
        let above: Vec<S> = (0..degree)
            .map(|j| -t.minus::<S>(k[index + 1 + j]))
            .collect();
        let mut ratios = Vec::with_capacity(degree * (degree + 1) / 2);
        for level in 1..=degree {
            for m in index + 1 - level..=index {
                let width = S::difference(k[m + level], k[m]);
                let (from, to) = (below[index - m], above[m + level - index - 1]);
                let low = from.value() <= to.value();
                ratios.push(Ratio {
                    smaller: if low { from } else { to } / width,
                    low,
                    width,
                });
            }
        }
        Self {
            index,
            degree,
            ratios,
        }
    }

    fn level(&self, level: usize) -> &[Ratio<S>] {
        let start = level * (level - 1) / 2;
        &self.ratios[start..start + level]
    }

    /// The spline's value and its derivatives up to `order`, from its `degree + 1` active control points;
    /// `local` is used up. Orders above the degree are zero.
    pub(super) fn derivatives<const N: usize>(
        &self,
        local: &mut [[S; N]],
        order: usize,
    ) -> Vec<[S; N]> {
        let mut out = Vec::with_capacity(order + 1);
        let mut triangle = local.to_vec();
        for k in 0..=order {
            if k > self.degree {
                out.push([S::ZERO; N]);
                continue;
            }
            if k > 0 {
                // Control points of the k-th derivative (equation 3.8), in `local`.
                let n = self.degree + 1 - k;
                let factor = S::exact(n as f64);
                for (i, ratio) in self.level(n).iter().enumerate() {
                    local[i] = std::array::from_fn(|c| {
                        (local[i + 1][c] - local[i][c]) * factor / ratio.width
                    });
                }
                triangle.clear();
                triangle.extend_from_slice(&local[..n]);
            }
            for level in (1..=self.degree - k).rev() {
                for (i, ratio) in self.level(level).iter().enumerate() {
                    triangle[i] = std::array::from_fn(|c| {
                        let (p, q) = (triangle[i][c], triangle[i + 1][c]);
                        // The form that keeps equal coordinates equal.
                        if ratio.low {
                            p + ratio.smaller * (q - p)
                        } else {
                            q + ratio.smaller * (p - q)
                        }
                    });
                }
            }
            out.push(triangle[0]);
        }
        out
    }
}

/// Up to this degree [`value`] and [`ShortSpan`] serve: what files hold, with few exceptions.
pub(super) const SHORT: usize = 8;

/// The homogeneous value in f64 and the index of the first active control point: [`Span::derivatives`] of order 0, by the same
/// operations and so to the same bits, but without memory of its own, which takes most of the time there. `None` above degree [`SHORT`].
pub(super) fn value<const N: usize>(
    knots: &KnotVector,
    points: &[SVector<f64, N>],
    t: &Parameter,
) -> Option<([f64; N], usize)> {
    let p = knots.degree();
    if p > SHORT {
        return None;
    }
    let index = t.find_span(knots);
    let k = knots.knots();
    let (mut below, mut above) = ([0.0; SHORT], [0.0; SHORT]);
    for j in 0..p {
        below[j] = t.minus(k[index - j]);
        above[j] = -t.minus::<f64>(k[index + 1 + j]);
    }
    let mut triangle = [[0.0; N]; SHORT + 1];
    for (own, q) in triangle.iter_mut().zip(&points[index - p..=index]) {
        *own = (*q).into();
    }
    for level in (1..=p).rev() {
        for i in 0..level {
            let m = index + 1 - level + i;
            let width = k[m + level] - k[m];
            let (from, to) = (below[level - 1 - i], above[i]);
            let low = from <= to;
            let smaller = if low { from } else { to } / width;
            for c in 0..N {
                let (p, q) = (triangle[i][c], triangle[i + 1][c]);
                triangle[i][c] = if low {
                    p + smaller * (q - p)
                } else {
                    q + smaller * (p - q)
                };
            }
        }
    }
    Some((triangle[0], index - p))
}

/// A [`Span`] in f64 without memory of its own, up to degree [`SHORT`]: values and derivatives, by the same operations and so to the same bits.
pub(super) struct ShortSpan {
    pub(super) index: usize,
    pub(super) degree: usize,
    ratios: [Ratio<f64>; SHORT * (SHORT + 1) / 2],
}

impl ShortSpan {
    /// `None` above degree [`SHORT`].
    pub(super) fn new(knots: &KnotVector, t: &Parameter) -> Option<Self> {
        let degree = knots.degree();
        if degree > SHORT {
            return None;
        }
        let index = t.find_span(knots);
        let k = knots.knots();
        let none = Ratio {
            smaller: 0.0,
            low: true,
            width: 1.0,
        };
        let mut ratios = [none; SHORT * (SHORT + 1) / 2];
        let (mut below, mut above) = ([0.0; SHORT], [0.0; SHORT]);
        for j in 0..degree {
            below[j] = t.minus(k[index - j]);
            above[j] = -t.minus::<f64>(k[index + 1 + j]);
        }
        let mut at = 0;
        for level in 1..=degree {
            for i in 0..level {
                let m = index + 1 - level + i;
                let width = k[m + level] - k[m];
                let (from, to) = (below[level - 1 - i], above[i]);
                let low = from <= to;
                ratios[at] = Ratio {
                    smaller: if low { from } else { to } / width,
                    low,
                    width,
                };
                at += 1;
            }
        }
        Some(Self {
            index,
            degree,
            ratios,
        })
    }

    fn level(&self, level: usize) -> &[Ratio<f64>] {
        let start = level * (level - 1) / 2;
        &self.ratios[start..start + level]
    }

    fn reduced<const N: usize>(&self, mut own: [[f64; N]; SHORT + 1], from: usize) -> [f64; N] {
        for level in (1..=from).rev() {
            for (i, ratio) in self.level(level).iter().enumerate() {
                for c in 0..N {
                    let (p, q) = (own[i][c], own[i + 1][c]);
                    own[i][c] = if ratio.low {
                        p + ratio.smaller * (q - p)
                    } else {
                        q + ratio.smaller * (p - q)
                    };
                }
            }
        }
        own[0]
    }

    /// Of the active control points, the first `degree + 1` of `local`.
    pub(super) fn value<const N: usize>(&self, local: &[[f64; N]; SHORT + 1]) -> [f64; N] {
        self.reduced(*local, self.degree)
    }

    /// Control points of the derivative of a spline of degree `n`, from its own.
    fn differentiate<const N: usize>(&self, own: &mut [[f64; N]; SHORT + 1], n: usize) {
        for (i, ratio) in self.level(n).iter().enumerate() {
            for c in 0..N {
                own[i][c] = (own[i + 1][c] - own[i][c]) * n as f64 / ratio.width;
            }
        }
    }

    pub(super) fn derivative<const N: usize>(&self, local: &[[f64; N]; SHORT + 1]) -> [f64; N] {
        let mut own = *local;
        self.differentiate(&mut own, self.degree);
        self.reduced(own, self.degree - 1)
    }

    /// The value and all derivatives up to `order`, no more than [`SHORT`].
    pub(super) fn derivatives<const N: usize>(
        &self,
        local: &[[f64; N]; SHORT + 1],
        order: usize,
    ) -> [[f64; N]; SHORT + 1] {
        let mut own = *local;
        let mut out = [[0.0; N]; SHORT + 1];
        for k in 0..=order.min(self.degree) {
            if k > 0 {
                self.differentiate(&mut own, self.degree + 1 - k);
            }
            out[k] = self.reduced(own, self.degree - k);
        }
        out
    }
}

/// `n! / (k! (n - k)!)`, exact up to n = 56.
pub(super) fn binomial<S: Scalar>(n: usize, k: usize) -> S {
    let mut b = 1.0;
    for i in 0..k.min(n - k) {
        // Each partial product is a binomial coefficient itself, so the division is exact.
        b = b * (n - i) as f64 / (i + 1) as f64;
    }
    S::exact(b)
}
