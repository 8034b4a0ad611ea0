//! A line as the zero set of two linear forms, and what they are on patches and curves.

use super::answer::{LineKind, LineProbe};
use crate::numeric::bernstein::{
    Bidegree, greater, keep_part, largest, lesser, part_error, split_error, split_off,
};
use crate::numeric::{Ball, Dd, Real, TINY};
use crate::prepare::{Net, Skewer};
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
    /// One over each coordinate of the direction, rounded.
    inverse: [f64; 3],
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
            inverse: [0, 1, 2].map(|c| 1.0 / d[c]),
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
        let [a, b] = [self.axis, self.other(k)].map(|c| {
            let shift = Ball::difference(net_origin[c], self.origin[c]);
            Ball::exact(self.normals[k][c]) * shift
        });
        a + b
    }

    /// The coordinate besides [`axis`](Self::axis) in which normal `k` is not zero.
    fn other(&self, k: usize) -> usize {
        (self.axis + 1 + k) % 3
    }

    /// `L_k` and the numerator of `t`: coefficients and one bound for each of the three.
    pub(super) fn forms<T: Real>(&self, net: &Net<T>) -> Forms<T> {
        self.some_forms(net, [true, true])
    }

    /// Those that tell where a line has zeros: without the numerator of `t` and `w` where all `t` count.
    pub(super) fn planes<T: Real>(&self, net: &Net<T>) -> Forms<T> {
        let ends = self.range.iter().any(|t| t.is_finite());
        self.some_forms(net, [true, ends])
    }

    /// The numerator of `t` and `w` alone.
    pub(super) fn clock<T: Real>(&self, net: &Net<T>) -> Forms<T> {
        self.some_forms(net, [false, true])
    }

    /// `L_1` and `L_2`, the numerator of `t` and `w`; of these pairs those that are wanted.
    fn some_forms<T: Real>(&self, net: &Net<T>, [planes, clock]: [bool; 2]) -> Forms<T> {
        let mut out = Forms {
            degree: net.degree,
            c: Default::default(),
            error: [0.0; 4],
            u: [0.0, 1.0],
            v: if net.degree.v == 0 {
                [0.0, 0.0]
            } else {
                [0.0, 1.0]
            },
        };
        if planes {
            for k in 0..2 {
                let offset = self.offset(k, &net.origin);
                let (values, error) = self.plane(net, k, offset);
                (out.c[k], out.error[k]) = (values.collect(), error);
            }
        }
        if clock {
            let axis = self.axis;
            let shift = Ball::difference(net.origin[axis], self.origin[axis]);
            let (values, error) = form(net, [(axis, 1.0)], shift);
            (out.c[2], out.error[2]) = (values.collect(), error);
            out.c[3] = net.points.iter().map(|p| p[3].mid).collect();
            out.error[3] = net.spread[3];
        }
        out
    }

    /// The coefficients of `L_k`, given [`offset`](Self::offset), and one bound for all.
    pub(super) fn plane<T: Real>(
        &self,
        net: &Net<T>,
        k: usize,
        offset: Ball<Dd>,
    ) -> (impl Iterator<Item = T>, f64) {
        let parts = [self.axis, self.other(k)].map(|c| (c, self.normals[k][c]));
        form(net, parts, offset)
    }

    /// Whether a box in space can meet the line; each quotient may be off by a few roundings (three: the difference, one over the
    /// direction and their product).
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
            let (p, q) = if self.inverse[c].is_finite() {
                let by = self.inverse[c];
                ((b[c][0] - o) * by, (b[c][1] - o) * by)
            } else {
                ((b[c][0] - o) / d, (b[c][1] - o) / d)
            };
            let slack = 4.0 * f64::EPSILON * greater(p.abs(), q.abs()) + f64::MIN_POSITIVE;
            low = greater(low, lesser(p, q) - slack);
            high = lesser(high, greater(p, q) + slack);
            if low > high {
                return false;
            }
        }
        true
    }

    /// Whether a parameter may be on either side of an end of the range, and is not known exactly.
    pub(super) fn is_at_end(&self, t: &Ball<Dd>) -> bool {
        let ends = [self.start_off(t), self.end_off(t)];
        t.rad > 0.0 && ends.iter().any(Option::is_none)
    }

    /// Whether a parameter is surely outside of the range.
    pub(super) fn is_beyond(&self, t: &Ball<Dd>) -> bool {
        [self.start_off(t), self.end_off(t)].contains(&Some(true))
    }

    fn start_off(&self, t: &Ball<Dd>) -> Option<bool> {
        let start = self.range[0];
        if !start.is_finite() {
            return Some(false);
        }
        is_below(t, start)
    }

    fn end_off(&self, t: &Ball<Dd>) -> Option<bool> {
        let end = self.range[1];
        if !end.is_finite() {
            return Some(false);
        }
        is_below(&-*t, -end)
    }

    /// What boxes in a tree are held against.
    pub(super) fn skewer(&self) -> Skewer {
        Skewer {
            origin: self.origin.into(),
            direction: self.direction.into(),
            has_ends: self.range.iter().any(|t| t.is_finite()),
        }
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

/// The sum of multiples of some coordinates and of the weight: its coefficients, and one bound for all.
fn form<T: Real, const N: usize>(
    net: &Net<T>,
    parts: [(usize, f64); N],
    weight: Ball<Dd>,
) -> (impl Iterator<Item = T>, f64) {
    let weight = Ball::<T>::from_dd(weight.mid, weight.rad);
    let mut size = weight.magnitude() * net.largest[3];
    let mut error = weight.magnitude() * net.spread[3] + weight.rad * net.largest[3];
    for (c, n) in parts {
        size += n.abs() * net.largest[c];
        error += n.abs() * net.spread[c];
    }
    let value = move |p: &[Ball<T>; 4]| {
        let sum = |sum: T, (c, n): (usize, f64)| sum + T::from_f64(n) * p[c].mid;
        parts.into_iter().fold(weight.mid * p[3].mid, sum)
    };
    // At most eight roundings of parts no larger than the sum of the largest, and what underflows of products.
    let error = (error + 8.0 * T::UNIT * size) * UP + f64::MIN_POSITIVE;
    (net.points.iter().map(value), error)
}

/// `L_1`, `L_2`, the numerator of `t d_axis`, and `w`, over a box; those that are not wanted have no coefficients.
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
        [lesser(r[0], x), greater(r[1], x)]
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
    let factor = if along_u { degree.u } else { degree.v };
    let mut out = [f64::INFINITY, f64::NEG_INFINITY];
    let mut take = |a: &T, b: &T| {
        let d = (*b - *a).approximate();
        out = [lesser(out[0], d), greater(out[1], d)];
    };
    if along_u {
        let pairs = c.iter().zip(&c[width..]);
        pairs.for_each(|(a, b)| take(a, b));
    } else {
        for row in c.chunks_exact(width) {
            let pairs = row.iter().zip(&row[1..]);
            pairs.for_each(|(a, b)| take(a, b));
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

/// Whether a number is below a limit, finer than f64; `None` where that is not known.
fn is_below(x: &Ball<Dd>, limit: f64) -> Option<bool> {
    let limit = Dd::from(limit);
    if x.rad == 0.0 {
        return Some(x.mid < limit);
    }
    let off = x.mid - limit;
    let known = off.hi.abs() > (x.rad + 4.0 * Dd::UNIT * off.hi.abs()) * UP;
    known.then_some(off < Dd::ZERO)
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

    pub(super) fn halves(mut self, along_u: bool) -> [Self; 2] {
        let mut high = Self {
            c: Default::default(),
            ..self
        };
        for k in 0..4 {
            if self.c[k].is_empty() {
                continue;
            }
            let e =
                self.error[k] + split_error::<T>(self.degree, along_u, largest(&self.c[k]), TINY);
            high.c[k] = split_off(&mut self.c[k], self.degree, along_u);
            (self.error[k], high.error[k]) = (e * UP, e * UP);
        }
        if along_u {
            let m = 0.5 * (self.u[0] + self.u[1]);
            (self.u[1], high.u[0]) = (m, m);
        } else {
            let m = 0.5 * (self.v[0] + self.v[1]);
            (self.v[1], high.v[0]) = (m, m);
        }
        [self, high]
    }

    /// The two forms alone.
    pub(super) fn pair(&self) -> Pair<'_, T> {
        Pair {
            degree: self.degree,
            c: [&self.c[0], &self.c[1]],
            error: [self.error[0], self.error[1]],
        }
    }

    /// See [`Pair::slopes`].
    pub(super) fn slopes(&self) -> ([[f64; 2]; 2], [f64; 2]) {
        self.pair().slopes()
    }

    /// See [`Pair::look`]; the lists are used again.
    pub(super) fn look(&self, j: &[[f64; 2]; 2], turned: &mut [Vec<T>; 2]) -> Look {
        for list in &mut *turned {
            list.clear();
            list.resize(self.c[0].len(), T::ZERO);
        }
        let [first, second] = turned;
        self.pair().look(j, [first, second])
    }

    /// A linear combination of `L_1` and `L_2`, into a list that is used again, and its error.
    pub(super) fn combine(&self, y: [f64; 2], into: &mut Vec<T>) -> f64 {
        into.clear();
        into.resize(self.c[0].len(), T::ZERO);
        self.pair().combine(y, into)
    }
}

/// `L_1` and `L_2` over a box: their coefficients, and a bound for each.
#[derive(Clone, Copy)]
pub(super) struct Pair<'a, T> {
    pub(super) degree: Bidegree,
    pub(super) c: [&'a [T]; 2],
    pub(super) error: [f64; 2],
}

impl<T: Real> Pair<'_, T> {
    /// The Jacobian of `(L_1, L_2)` in the middle of the box, roughly, by mean differences, and how much both change at most along
    /// u and v; in coordinates that run over the box from 0 to 1.
    pub(super) fn slopes(&self) -> ([[f64; 2]; 2], [f64; 2]) {
        let mut most = [0.0; 2];
        let jacobian = std::array::from_fn(|k| {
            std::array::from_fn(|along| {
                let r = slope_range(self.c[k], self.degree, along == 0, 0.0);
                most[along] += greater(r[0].abs(), r[1].abs());
                0.5 * (r[0] + r[1])
            })
        });
        (jacobian, most)
    }

    /// What combinations of the forms tell, given their Jacobian; `turned` has room for two.
    #[inline]
    pub(super) fn look(&self, j: &[[f64; 2]; 2], turned: [&mut [T]; 2]) -> Look {
        let one_sign = |c: &[T], error: f64| {
            let r = range(c, error);
            r[0] > 0.0 || r[1] < 0.0
        };
        let told = |none: bool, one_at_most: Option<Contraction>, noise: bool| Look {
            none,
            one_at_most,
            noise,
        };
        let e = self.combine(combination(j), turned[0]);
        if one_sign(turned[0], e) {
            return told(true, None, false);
        }
        let noise = largest(turned[0]) <= NOISE_FACTOR * e;
        let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        let size = (j[0][0].abs() + j[0][1].abs()) * (j[1][0].abs() + j[1][1].abs());
        if !(det.abs() > 64.0 * f64::EPSILON * size) {
            return told(false, None, noise);
        }
        let y = [
            [j[1][1] / det, -j[0][1] / det],
            [-j[1][0] / det, j[0][0] / det],
        ];
        let mut errors = [0.0; 2];
        for k in 0..2 {
            errors[k] = self.combine(y[k], turned[k]);
            if one_sign(turned[k], errors[k]) {
                return told(true, None, noise);
            }
        }
        let [first, second] = turned;
        let e = contraction([(first, errors[0]), (second, errors[1])], self.degree);
        told(false, (e < 1.0).then_some(Contraction { y, e }), noise)
    }

    /// A linear combination of the two, and its error.
    pub(super) fn combine(&self, y: [f64; 2], into: &mut [T]) -> f64 {
        let [p, q] = y.map(T::from_f64);
        let pairs = self.c[0].iter().zip(self.c[1]);
        for (x, (a, b)) in into.iter_mut().zip(pairs) {
            *x = p * *a + q * *b;
        }
        let size: f64 = (0..2).map(|k| y[k].abs() * largest(self.c[k])).sum();
        let error: f64 = (0..2).map(|k| y[k].abs() * self.error[k]).sum();
        (error + 4.0 * T::UNIT * size) * UP
    }
}

/// Boxes on which a form is below this many of its error bounds are left to the next arithmetic.
pub(super) const NOISE_FACTOR: f64 = 8.0;

/// What the two forms tell about their zeros on a box.
pub(super) struct Look {
    /// There is none.
    pub(super) none: bool,
    /// There is one at most: see the module `certify`.
    pub(super) one_at_most: Option<Contraction>,
    /// One of their combinations is all rounding noise.
    pub(super) noise: bool,
}

/// `K = Y L` with `|I - K'| <= e < 1` over a box, for coordinates that run over it from 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct Contraction {
    pub(super) y: [[f64; 2]; 2],
    pub(super) e: f64,
}

/// The combination of the two forms with the least slope, given the Jacobian: a line that passes the patch has one sign there.
fn combination(j: &[[f64; 2]; 2]) -> [f64; 2] {
    if j[0][0].abs() + j[0][1].abs() >= j[1][0].abs() + j[1][1].abs() {
        let k = if j[0][0].abs() >= j[0][1].abs() { 0 } else { 1 };
        if j[0][k] == 0.0 {
            [1.0, 0.0]
        } else {
            [-j[1][k] / j[0][k], 1.0]
        }
    } else {
        let k = if j[1][0].abs() >= j[1][1].abs() { 0 } else { 1 };
        [1.0, -j[0][k] / j[1][k]]
    }
}

/// `|I - K'|` in the maximum norm over a box, for `K = Y L`, given each `K_k` and its error.
pub(super) fn contraction<T: Real>(k: [(&[T], f64); 2], degree: Bidegree) -> f64 {
    let mut worst: f64 = 0.0;
    for (own, (c, e)) in k.into_iter().enumerate() {
        let mut row = 0.0;
        for along in 0..2 {
            let r = slope_range(c, degree, along == 0, e);
            let target = if own == along { 1.0 } else { 0.0 };
            row += (r[0] - target).abs().max((r[1] - target).abs());
        }
        worst = worst.max(row * UP);
    }
    worst
}

/// `|dt/dx|` over a zone, summed over both directions, given `t` about there: `t - about = (T - about d w) / (w d)`, whose numerator is small
/// all over a zone next to a pole, where T and w are not.
pub(super) fn parameter_slope<T: Real>(near: &Forms<T>, stab: &Stabber, about: f64) -> f64 {
    let w = range(&near.c[3], near.error[3]);
    if !(w[0] > 0.0) {
        return f64::INFINITY;
    }
    let shift = T::from_f64(about) * T::from_f64(stab.direction[stab.axis]);
    let pairs = near.c[2].iter().zip(&near.c[3]);
    let numerator: Vec<T> = pairs.map(|(t, w)| *t - shift * *w).collect();
    let by = shift.magnitude();
    let size = largest(&near.c[2]) + by * largest(&near.c[3]);
    let error = (near.error[2] + by * near.error[3] + 8.0 * T::UNIT * size) * UP;
    let t_max = largest(&numerator) + error;
    let mut sum = 0.0;
    for along_u in [true, false] {
        let dt = slope_range(&numerator, near.degree, along_u, error);
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
    let d = root.degree;
    let mut out = Forms {
        c: Default::default(),
        ..*root
    };
    let mut room: [Vec<T>; 2] = Default::default();
    for k in 0..4 {
        if root.c[k].is_empty() {
            continue;
        }
        let size = largest(&root.c[k]);
        let steps = 3 * (d.u + d.v) + 2;
        // Past the border a step is no average but grows by 1 + 2 EXTENSION at most: less than twofold
        // over 50 steps.
        out.error[k] = 2.0 * (root.error[k] + steps as f64 * T::UNIT * size) * UP;
        out.c[k] = root.c[k].clone();
        restrict_along(&mut out.c[k], d, (true, u), &mut room);
        restrict_along(&mut out.c[k], d, (false, v), &mut room);
    }
    out.u = u;
    out.v = v;
    out
}

/// The two that tell where zeros are, in far fewer steps, but known some times worse: for what hangs on the last digits of nothing.
pub(super) fn restrict_roughly<T: Real>(root: &Forms<T>, [u, v]: [[f64; 2]; 2]) -> Forms<T> {
    let mut out = Forms {
        c: Default::default(),
        u,
        v,
        ..*root
    };
    for k in 0..2 {
        let mut c = root.c[k].clone();
        let mut error = root.error[k];
        for (along_u, range) in [(true, u), (false, v)] {
            error += part_error::<T>(root.degree, along_u, largest(&root.c[k]), TINY);
            keep_part(&mut c, root.degree, along_u, range);
        }
        // Past the border as above.
        (out.c[k], out.error[k]) = (c, 2.0 * error * UP);
    }
    out
}

/// Coefficient `k` of `n` is the blossom at the first end (`n - k` times), then at the second (`k` times). `room` is for two more lists.
fn restrict_along<T: Real>(
    c: &mut [T],
    d: Bidegree,
    (along_u, r): (bool, [f64; 2]),
    room: &mut [Vec<T>; 2],
) {
    let width = d.v + 1;
    let count = if along_u { d.u } else { d.v };
    let [first, second] = r.map(T::from_f64);
    // One step of all lines, of which so many coefficients are left.
    let step = |lines: &mut [T], left: usize, x: T| {
        let y = T::ONE - x;
        if along_u {
            // Whole rows at once.
            for at in 0..left * width {
                lines[at] = y * lines[at] + x * lines[at + width];
            }
        } else {
            for row in lines.chunks_exact_mut(width) {
                for i in 0..left {
                    row[i] = y * row[i] + x * row[i + 1];
                }
            }
        }
    };
    for list in room.iter_mut() {
        list.clear();
        list.extend_from_slice(c);
    }
    // After `n - k` steps at the first end; and some at the second.
    let [begun, lines] = room;
    for k in (0..=count).rev() {
        lines.copy_from_slice(begun);
        for left in (1..=k).rev() {
            step(lines, left, second);
        }
        if along_u {
            c[k * width..(k + 1) * width].copy_from_slice(&lines[..width]);
        } else {
            for (o, row) in c.chunks_exact_mut(width).zip(lines.chunks_exact(width)) {
                o[k] = row[0];
            }
        }
        if k > 0 {
            step(begun, k, first);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dyadic;

    fn exact(x: f64) -> Dyadic {
        Dyadic::from_f64(x).unwrap()
    }

    /// A short direction and small weights: products below what f64 holds in full.
    #[test]
    fn forms_hold_what_underflows() {
        let mut tiny = 0;
        for k in 0..40 {
            let step = f64::from(k);
            let (d, w) = (1.1 * 10f64.powi(-230 - k), 1e-60);
            let direction = Vector3::new(d, 0.7 * d, -0.3 * d);
            let origin = Point3::new(0.1 * step, 0.0, 1.0);
            // (Shorter than what `LineProbe::new` takes.)
            let probe = LineProbe {
                origin,
                direction,
                kind: LineKind::Line,
            };
            let stab = Stabber::new(&probe);
            let points: Vec<[f64; 4]> = [[0.3, 0.1], [1.7, -0.2], [0.9, 1.3], [2.1, 1.9]]
                .map(|[x, y]| [x * w, y * w, (x + 1.1 * y) * w, w])
                .to_vec();
            let degree = Bidegree { u: 1, v: 1 };
            let net = points.iter().map(|p| p.map(Ball::<f64>::exact)).collect();
            let forms = stab.planes(&Net::new(degree, net, [0.0; 3]));
            for side in 0..2 {
                let n = &stab.normals[side];
                for (p, found) in points.iter().zip(&forms.c[side]) {
                    let mut off = exact(0.0);
                    for c in 0..3 {
                        let x = &exact(p[c]) - &(&exact(origin[c]) * &exact(p[3]));
                        off = &off + &(&exact(n[c]) * &x);
                    }
                    let off = (&off - &exact(*found)).approximate().abs();
                    assert!(
                        off <= forms.error[side],
                        "{d:e} {off:e} {:e}",
                        forms.error[side]
                    );
                    tiny += usize::from(found.abs() < f64::MIN_POSITIVE);
                }
            }
        }
        assert!(tiny > 20);
    }
}
