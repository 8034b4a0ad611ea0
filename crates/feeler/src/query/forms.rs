//! A line as the zero set of two linear forms, and what they are on patches and curves.

use super::answer::{LineKind, LineProbe};
use crate::numeric::bernstein::{Bidegree, largest, split, split_error};
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::Net;
use nalgebra::{Point3, Vector3};

const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// The line in exact terms.
#[derive(Clone)]
pub(super) struct Stabber {
    pub(super) origin: Point3<f64>,
    pub(super) direction: Vector3<f64>,
    /// Normals of two planes through the line, exactly orthogonal to the direction.
    pub(super) normals: [Vector3<f64>; 2],
    /// The coordinate in which the direction is longest.
    pub(super) axis: usize,
    /// Range of t.
    pub(super) range: [f64; 2],
}

impl Stabber {
    pub(super) fn new(probe: &LineProbe) -> Self {
        let d = probe.direction;
        let axis = d.iamax();
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let normal = |other: usize| {
            let mut n = Vector3::zeros();
            n[other] = d[axis];
            n[axis] = -d[other];
            n
        };
        Self {
            origin: probe.origin,
            direction: d,
            normals: [normal(b), normal(c)],
            axis,
            range: match probe.kind {
                LineKind::Line => [f64::NEG_INFINITY, f64::INFINITY],
                LineKind::Ray => [0.0, f64::INFINITY],
                LineKind::Segment => [0.0, 1.0],
            },
        }
    }

    /// The same line, longer by a length at both ends.
    pub(super) fn longer(&self, by: f64) -> Self {
        let by = by / self.direction.norm() * UP;
        let [low, high] = self.range;
        Self {
            range: [(low - by).next_down(), (high + by).next_up()],
            ..self.clone()
        }
    }

    /// `n_k.(origin of the net - o)`.
    pub(super) fn offset(&self, k: usize, net_origin: &[f64; 3]) -> Ball<Dd> {
        let mut sum = Ball::ZERO;
        for c in 0..3 {
            sum = sum
                + Ball::exact(self.normals[k][c]) * Ball::difference(net_origin[c], self.origin[c]);
        }
        sum
    }

    /// `L_k` and the numerator of `t`: coefficients and one bound for each of the three.
    pub(super) fn forms<T: Real>(&self, net: &Net<T>) -> Forms<T> {
        let x: [_; 3] = std::array::from_fn(|c| net.coordinate(c));
        let w = net.coordinate(3);
        let form = |n: &Vector3<f64>, offset: Ball<Dd>| {
            let offset = Ball::<T>::from_dd(offset.mid, offset.rad);
            let m: [T; 3] = std::array::from_fn(|c| T::from_f64(n[c]));
            let values: Vec<T> = (0..net.degree.count())
                .map(|i| {
                    m[0] * x[0].values[i]
                        + m[1] * x[1].values[i]
                        + m[2] * x[2].values[i]
                        + offset.mid * w.values[i]
                })
                .collect();
            let mut size = offset.magnitude() * w.largest;
            let mut error = offset.magnitude() * w.error + offset.rad * w.largest;
            for c in 0..3 {
                size += n[c].abs() * x[c].largest;
                error += n[c].abs() * x[c].error;
            }
            // At most eight roundings of parts no larger than the sum of the largest.
            (values, (error + 8.0 * T::UNIT * size) * UP)
        };
        let (l1, e1) = form(&self.normals[0], self.offset(0, &net.origin));
        let (l2, e2) = form(&self.normals[1], self.offset(1, &net.origin));
        let mut unit = Vector3::zeros();
        unit[self.axis] = 1.0;
        let shift = Ball::difference(net.origin[self.axis], self.origin[self.axis]);
        let (t, et) = form(&unit, shift);
        Forms {
            degree: net.degree,
            c: [l1, l2, t, w.values],
            error: [e1, e2, et, w.error],
            u: [0.0, 1.0],
            v: if net.degree.v == 0 {
                [0.0, 0.0]
            } else {
                [0.0, 1.0]
            },
        }
    }

    /// Whether a box in space can meet the line; each product may be off by a few roundings.
    pub(super) fn meets(&self, b: &[[f64; 2]; 3]) -> bool {
        let (mut low, mut high) = (self.range[0], self.range[1]);
        for c in 0..3 {
            let (o, d) = (self.origin[c], self.direction[c]);
            if d == 0.0 {
                if o < b[c][0] || o > b[c][1] {
                    return false;
                }
                continue;
            }
            let (p, q) = ((b[c][0] - o) / d, (b[c][1] - o) / d);
            let slack = 4.0 * f64::EPSILON * p.abs().max(q.abs());
            low = low.max(p.min(q) - slack);
            high = high.min(p.max(q) + slack);
        }
        !(low > high)
    }

    /// `t` of a homogeneous point relative to a net's origin.
    pub(super) fn parameter(&self, point: &[Ball<Dd>; 4], net_origin: &[f64; 3]) -> Ball<Dd> {
        let shift = Ball::difference(net_origin[self.axis], self.origin[self.axis]);
        (point[self.axis] / point[3] + shift) / Ball::exact(self.direction[self.axis])
    }

    /// `L_1`, `L_2` of a homogeneous vector.
    pub(super) fn apply(&self, h: &[Ball<Dd>; 4], offsets: &[Ball<Dd>; 2]) -> [Ball<Dd>; 2] {
        std::array::from_fn(|k| {
            let n = &self.normals[k];
            Ball::exact(n[0]) * h[0]
                + Ball::exact(n[1]) * h[1]
                + Ball::exact(n[2]) * h[2]
                + offsets[k] * h[3]
        })
    }
}

/// `L_1`, `L_2`, the numerator of `t d_axis`, and `w`, over a box.
#[derive(Clone, Debug)]
pub(super) struct Forms<T> {
    pub(super) degree: Bidegree,
    pub(super) c: [Vec<T>; 4],
    pub(super) error: [f64; 4],
    pub(super) u: [f64; 2],
    pub(super) v: [f64; 2],
}

/// `(min, max)` of coefficients, widened by their error and by the rounding to f64.
pub(super) fn range<T: Real>(c: &[T], error: f64) -> [f64; 2] {
    let r = c.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |r, x| {
        let x = x.approximate();
        [r[0].min(x), r[1].max(x)]
    });
    [
        r[0] - error * UP - f64::EPSILON * r[0].abs(),
        r[1] + error * UP + f64::EPSILON * r[1].abs(),
    ]
}

/// Range of the derivative along u or v, in coordinates that run over the box from 0 to 1.
pub(super) fn slope_range<T: Real>(
    c: &[T],
    degree: Bidegree,
    along_u: bool,
    error: f64,
) -> [f64; 2] {
    let width = degree.v + 1;
    let (step, factor) = if along_u {
        (width, degree.u)
    } else {
        (1, degree.v)
    };
    let mut out = [f64::INFINITY, f64::NEG_INFINITY];
    for i in 0..=degree.u {
        for j in 0..=degree.v {
            if (along_u && i == degree.u) || (!along_u && j == degree.v) {
                continue;
            }
            let at = i * width + j;
            let d = (c[at + step] - c[at]).approximate();
            out = [out[0].min(d), out[1].max(d)];
        }
    }
    if factor == 0 {
        return [0.0, 0.0];
    }
    let size = out[0].abs().max(out[1].abs());
    let slack = 2.0 * error + 4.0 * f64::EPSILON * size;
    let f = factor as f64;
    [
        (out[0] - slack) * f * signed_up(out[0], false),
        (out[1] + slack) * f * signed_up(out[1], true),
    ]
}

/// A factor next to 1 that moves `x` outward.
pub(super) fn signed_up(x: f64, high: bool) -> f64 {
    if (x > 0.0) == high {
        UP
    } else {
        1.0 - 64.0 * f64::EPSILON
    }
}

impl<T: Real> Forms<T> {
    pub(super) fn has_no_zero(&self) -> bool {
        (0..2).any(|k| {
            let r = range(&self.c[k], self.error[k]);
            r[0] > 0.0 || r[1] < 0.0
        })
    }

    /// Whether the line's range of t misses the box.
    pub(super) fn beyond(&self, stab: &Stabber) -> bool {
        let [low, high] = stab.range;
        if low == f64::NEG_INFINITY {
            return false;
        }
        let d = stab.direction[stab.axis];
        // t - low = (T - low d w) / (d w): the sign of T - low d w times that of d.
        let side = |bound: f64| {
            let (limit, sign) = (T::from_f64(bound) * T::from_f64(d), T::from_f64(d.signum()));
            let values: Vec<T> = self.c[2]
                .iter()
                .zip(&self.c[3])
                .map(|(t, w)| (*t - limit * *w) * sign)
                .collect();
            let size = largest(&self.c[2]) + (bound * d).abs() * largest(&self.c[3]);
            let error = self.error[2] + (bound * d).abs() * self.error[3] + 8.0 * T::UNIT * size;
            range(&values, error * UP)
        };
        side(low)[1] < 0.0 || (high.is_finite() && side(high)[0] > 0.0)
    }

    pub(super) fn halves(&self, along_u: bool) -> [Self; 2] {
        let mut low = self.clone();
        let mut high = self.clone();
        for k in 0..4 {
            let (a, b) = split(&self.c[k], self.degree, along_u);
            let e = self.error[k] + split_error::<T>(self.degree, along_u, largest(&self.c[k]));
            (low.c[k], high.c[k]) = (a, b);
            (low.error[k], high.error[k]) = (e * UP, e * UP);
        }
        if along_u {
            let m = 0.5 * (self.u[0] + self.u[1]);
            (low.u[1], high.u[0]) = (m, m);
        } else {
            let m = 0.5 * (self.v[0] + self.v[1]);
            (low.v[1], high.v[0]) = (m, m);
        }
        [low, high]
    }

    /// The Jacobian of `(L_1, L_2)` in the middle of the box, roughly, by mean differences.
    pub(super) fn jacobian(&self) -> [[f64; 2]; 2] {
        std::array::from_fn(|k| {
            std::array::from_fn(|along| {
                let r = slope_range(&self.c[k], self.degree, along == 0, 0.0);
                0.5 * (r[0] + r[1])
            })
        })
    }

    /// A linear combination of `L_1` and `L_2`, and its error.
    pub(super) fn combine(&self, y: [f64; 2]) -> (Vec<T>, f64) {
        let [p, q] = y.map(T::from_f64);
        let values = self.c[0]
            .iter()
            .zip(&self.c[1])
            .map(|(a, b)| p * *a + q * *b)
            .collect();
        let size: f64 = (0..2).map(|k| y[k].abs() * largest(&self.c[k])).sum();
        let error: f64 = (0..2).map(|k| y[k].abs() * self.error[k]).sum();
        (values, (error + 4.0 * T::UNIT * size) * UP)
    }
}

/// The part of a root over a box that was reached by halving it.
pub(super) fn narrow(root: &Forms<Dd>, u: [f64; 2], v: [f64; 2]) -> Forms<Dd> {
    let mut node = root.clone();
    for (along_u, target) in [(true, u), (false, v)] {
        loop {
            let r = if along_u { node.u } else { node.v };
            if r[1] - r[0] <= target[1] - target[0] {
                break;
            }
            let [low, high] = node.halves(along_u);
            node = if target[1] <= 0.5 * (r[0] + r[1]) {
                low
            } else {
                high
            };
        }
    }
    node
}

/// `|I - K'|` in the maximum norm over the box, for `K = Y L`.
pub(super) fn contraction<T: Real>(node: &Forms<T>, y: &[[f64; 2]; 2]) -> f64 {
    let mut worst: f64 = 0.0;
    for k in 0..2 {
        let (c, e) = node.combine(y[k]);
        let mut row = 0.0;
        for along in 0..2 {
            let r = slope_range(&c, node.degree, along == 0, e);
            let target = if k == along { 1.0 } else { 0.0 };
            row += (r[0] - target).abs().max((r[1] - target).abs());
        }
        worst = worst.max(row * UP);
    }
    worst
}

/// `|dt/dx|` over a zone, summed over both directions: `t = T / (w d)`.
pub(super) fn parameter_slope<T: Real>(near: &Forms<T>, stab: &Stabber) -> f64 {
    let w = range(&near.c[3], near.error[3]);
    if !(w[0] > 0.0) {
        return f64::INFINITY;
    }
    let t_max = largest(&near.c[2]) + near.error[2];
    let mut sum = 0.0;
    for along_u in [true, false] {
        let dt = slope_range(&near.c[2], near.degree, along_u, near.error[2]);
        let dw = slope_range(&near.c[3], near.degree, along_u, near.error[3]);
        let dt = dt[0].abs().max(dt[1].abs());
        let dw = dw[0].abs().max(dw[1].abs());
        sum += dt / w[0] + t_max * dw / (w[0] * w[0]);
    }
    sum / stab.direction[stab.axis].abs() * UP
}

/// The forms over `[u] x [v]` of a root, by blossoming; each of the `degree` steps in each
/// direction adds three roundings of numbers no larger than the largest coefficient.
pub(super) fn restrict<T: Real>(root: &Forms<T>, u: [f64; 2], v: [f64; 2]) -> Forms<T> {
    let mut out = root.clone();
    for k in 0..4 {
        let d = root.degree;
        let size = largest(&root.c[k]);
        let mut c = root.c[k].clone();
        c = restrict_along(&c, d, true, u);
        c = restrict_along(&c, d, false, v);
        let steps = 3 * (d.u + d.v) + 2;
        // Past the border a step is no average but grows by 1 + 2 EXTENSION at most: less than twofold
        // over 50 steps.
        out.error[k] = 2.0 * (root.error[k] + steps as f64 * T::UNIT * size) * UP;
        out.c[k] = c;
    }
    out.u = u;
    out.v = v;
    out
}

pub(super) fn restrict_along<T: Real>(c: &[T], d: Bidegree, along_u: bool, r: [f64; 2]) -> Vec<T> {
    let (stride, count, lines, step) = if along_u {
        (d.v + 1, d.u, d.v + 1, 1)
    } else {
        (1, d.v, d.u + 1, d.v + 1)
    };
    let mut out = c.to_vec();
    let mut row = Vec::with_capacity(count + 1);
    for line in 0..lines {
        for k in 0..=count {
            row.clear();
            row.extend((0..=count).map(|i| c[line * step + i * stride]));
            for level in 0..count {
                let x = T::from_f64(if level < count - k { r[0] } else { r[1] });
                let y = T::ONE - x;
                for i in 0..count - level {
                    row[i] = y * row[i] + x * row[i + 1];
                }
            }
            out[line * step + k * stride] = row[0];
        }
    }
    out
}
