//! Surfaces.

use super::Scalar;
use super::curve::{rounded, turn, unit};
use super::parameter::{Limit, Parameter};
use super::spline::{SHORT, ShortSpan, Span, binomial};
use crate::numeric::{Ball, Dd};
use crate::nurbs::{NurbsSurface, Plane, Revolution, Sum, Surface};
use nalgebra::{Point3, Vector3, Vector4};

/// The partial derivatives of a surface up to some total order.
#[derive(Clone, Debug, PartialEq)]
pub struct Partials<T> {
    order: usize,
    values: Vec<T>,
}

impl<T: Copy> Partials<T> {
    fn new(order: usize, zero: T) -> Self {
        Self {
            order,
            values: vec![zero; (order + 1) * (order + 2) / 2],
        }
    }

    fn index(&self, i: usize, j: usize) -> usize {
        // Row i has order + 1 - i entries.
        i * (2 * self.order + 3 - i) / 2 + j
    }

    /// The largest total order.
    pub fn order(&self) -> usize {
        self.order
    }

    /// The derivative taken `i` times along u and `j` times along v; `(0, 0)` is the point.
    ///
    /// # Panics
    /// If `i + j` is above the order.
    pub fn get(&self, i: usize, j: usize) -> T {
        assert!(
            i + j <= self.order,
            "derivative ({i}, {j}) was not asked for"
        );
        self.values[self.index(i, j)]
    }

    fn set(&mut self, i: usize, j: usize, value: T) {
        let at = self.index(i, j);
        self.values[at] = value;
    }

    /// Each value converted.
    pub fn map<U: Copy>(&self, f: impl Fn(T) -> U) -> Partials<U> {
        Partials {
            order: self.order,
            values: self.values.iter().map(|v| f(*v)).collect(),
        }
    }
}

/// The pairs `(i, j)` with `i + j <= order`.
fn orders(order: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..=order).flat_map(move |i| (0..=order - i).map(move |j| (i, j)))
}

/// A point and first derivatives, each with a proven bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point.
    pub point: Point3<f64>,
    /// Derivative along u.
    pub du: Vector3<f64>,
    /// Derivative along v.
    pub dv: Vector3<f64>,
    /// Bound on the error of each coordinate of the point.
    pub bound: f64,
    /// Bound on the error of each coordinate of `du`.
    pub du_bound: f64,
    /// Bound on the error of each coordinate of `dv`.
    pub dv_bound: f64,
}

impl Surface {
    /// The point at `(u, v)` (clamped to the domain), in f64, with the a-priori error
    /// stated [here](super).
    pub fn point(&self, u: f64, v: f64) -> Point3<f64> {
        if let Self::Nurbs(s) = self
            && let Some([point, ..]) = short_nurbs(s, [u, v], 0)
        {
            return Vector3::from(point).into();
        }
        self.derivatives(u, v, 0).get(0, 0).into()
    }

    /// The point and all mixed partial derivatives up to total order `order`, in f64. At knots
    /// they are one-sided, from above (see [`Limit`]).
    pub fn derivatives(&self, u: f64, v: f64, order: usize) -> Partials<Vector3<f64>> {
        if order == 1
            && let Self::Nurbs(s) = self
            && let Some(all) = short_nurbs(s, [u, v], order)
        {
            let [point, du, dv] = all.map(Vector3::from);
            return Partials {
                order,
                values: vec![point, dv, du],
            };
        }
        partials::<f64>(self, [u, v], order, [Limit::FromAbove; 2]).map(Vector3::from)
    }

    /// The point at `(u, v)` (clamped to the domain) and a proven bound on the error of
    /// each coordinate: see [`first_derivatives_with_bound`](Self::first_derivatives_with_bound).
    pub fn point_with_bound(&self, u: f64, v: f64) -> (Point3<f64>, f64) {
        let all = partials::<Ball<Dd>>(self, [u, v], 0, [Limit::FromAbove; 2]);
        let (point, bound) = rounded(&all.get(0, 0));
        (point.into(), bound)
    }

    /// The point and the first derivatives at `(u, v)` (clamped to the domain), each
    /// with a proven bound on the error of its coordinates.
    ///
    /// It is evaluated in balls of double-doubles: each operation adds its rounding, the
    /// unit 2^-103 times its result, to the errors that it inherits (Higham, section 3.3).
    /// Then the double-doubles are rounded: the bound is `|lo|` plus the ball's
    /// radius, about half an ulp where the point is not much smaller than the control points.
    /// An infinite bound means that the numbers left the range of f64.
    pub fn first_derivatives_with_bound(&self, u: f64, v: f64) -> SurfacePoint {
        let all = partials::<Ball<Dd>>(self, [u, v], 1, [Limit::FromAbove; 2]);
        let (point, bound) = rounded(&all.get(0, 0));
        let (du, du_bound) = rounded(&all.get(1, 0));
        let (dv, dv_bound) = rounded(&all.get(0, 1));
        SurfacePoint {
            point: point.into(),
            du,
            dv,
            bound,
            du_bound,
            dv_bound,
        }
    }
}

/// The point and all partial derivatives up to total order `order` at `uv` (clamped to the
/// domain), in any arithmetic, one-sided as `limits` say for u and for v.
///
/// Cost for NURBS of degrees p, q: O(order (p q^2 + p^2 order) + order^4) operations.
pub fn partials<S: Scalar>(
    surface: &Surface,
    uv: [f64; 2],
    order: usize,
    limits: [Limit; 2],
) -> Partials<[S; 3]> {
    let [du, dv] = surface.domain();
    let at = [
        Parameter::new(uv[0], du, limits[0]),
        Parameter::new(uv[1], dv, limits[1]),
    ];
    match surface {
        Surface::Plane(s) => plane(s, &at, order),
        Surface::Revolution(s) => revolution(s, uv, &at, order, limits),
        Surface::Sum(s) => sum(s, uv, order, limits),
        Surface::Nurbs(s) => nurbs(s, &at, order),
    }
}

fn plane<S: Scalar>(s: &Plane, at: &[Parameter; 2], order: usize) -> Partials<[S; 3]> {
    let mut out = Partials::new(order, [S::ZERO; 3]);
    // Coordinates along the axes, and how fast they move.
    let along = |i: usize| -> (S, S) {
        let (domain, extent) = (s.domain[i], s.extents[i]);
        if domain == extent {
            return (at[i].minus(0.0), S::ONE);
        }
        let (r, f) = at[i].fractions::<S>(domain);
        let length = S::difference(extent.end, extent.start);
        let x = if f.value() <= r.value() {
            S::exact(extent.start) + f * length
        } else {
            S::exact(extent.end) - r * length
        };
        (x, Parameter::rate(domain, extent))
    };
    let ((a, a_rate), (b, b_rate)) = (along(0), along(1));
    let axis = |v: &Vector3<f64>, by: S| std::array::from_fn(|c| S::exact(v[c]) * by);
    let (x, y): ([S; 3], [S; 3]) = (axis(&s.x, a), axis(&s.y, b));
    out.set(
        0,
        0,
        std::array::from_fn(|c| S::exact(s.origin[c]) + x[c] + y[c]),
    );
    if order > 0 {
        out.set(1, 0, axis(&s.x, a_rate));
        out.set(0, 1, axis(&s.y, b_rate));
    }
    out
}

/// The part of `d` along the unit vector `n`, the rest e, and n x e.
fn split<S: Scalar>(d: &[S; 3], n: &[S; 3]) -> ([S; 3], [S; 3], [S; 3]) {
    let h = d[0] * n[0] + d[1] * n[1] + d[2] * n[2];
    let axial = n.map(|x| h * x);
    let e: [S; 3] = std::array::from_fn(|c| d[c] - axial[c]);
    let f = [
        n[1] * e[2] - n[2] * e[1],
        n[2] * e[0] - n[0] * e[2],
        n[0] * e[1] - n[1] * e[0],
    ];
    (axial, e, f)
}

fn revolution<S: Scalar>(
    s: &Revolution,
    uv: [f64; 2],
    at: &[Parameter; 2],
    order: usize,
    limits: [Limit; 2],
) -> Partials<[S; 3]> {
    let (angular, along) = if s.transposed { (1, 0) } else { (0, 1) };
    let (sin, cos, rate) = turn(s.angle, s.angle_domain, &at[angular]);
    let (sin, cos) = (S::from_ball(sin), S::from_ball(cos));
    let rate = S::from_ball(rate);
    let n = unit(&s.axis).map(S::from_ball);
    let profile = s
        .profile
        .derivatives_in::<S>(uv[along], order, limits[along]);
    let mut out = Partials::new(order, [S::ZERO; 3]);
    for (j, p) in profile.iter().enumerate() {
        // Rodrigues: d = h n + e, turned: h n + cos e + sin (n x e).
        let d: [S; 3] = std::array::from_fn(|c| {
            if j == 0 {
                p[c] - S::exact(s.origin[c])
            } else {
                p[c]
            }
        });
        let (axial, e, f) = split(&d, &n);
        let (mut along_e, mut along_f, mut power) = (cos, sin, S::ONE);
        for i in 0..=order - j {
            let value: [S; 3] = std::array::from_fn(|c| {
                let turned = along_e * e[c] + along_f * f[c];
                match (i, j) {
                    (0, 0) => S::exact(s.origin[c]) + (axial[c] + turned),
                    (0, _) => axial[c] + turned,
                    _ => power * turned,
                }
            });
            if s.transposed {
                out.set(j, i, value);
            } else {
                out.set(i, j, value);
            }
            power = power * rate;
            (along_e, along_f) = (-along_f, along_e);
        }
    }
    out
}

fn sum<S: Scalar>(s: &Sum, uv: [f64; 2], order: usize, limits: [Limit; 2]) -> Partials<[S; 3]> {
    let first = s.first.derivatives_in::<S>(uv[0], order, limits[0]);
    let second = s.second.derivatives_in::<S>(uv[1], order, limits[1]);
    let mut out = Partials::new(order, [S::ZERO; 3]);
    out.set(
        0,
        0,
        std::array::from_fn(|c| S::exact(s.base[c]) + first[0][c] + second[0][c]),
    );
    for k in 1..=order {
        out.set(k, 0, first[k]);
        out.set(0, k, second[k]);
    }
    out
}

fn nurbs<S: Scalar>(s: &NurbsSurface, at: &[Parameter; 2], order: usize) -> Partials<[S; 3]> {
    let (span_u, span_v) = (
        Span::<S>::new(s.knots_u(), &at[0]),
        Span::<S>::new(s.knots_v(), &at[1]),
    );
    let (p, q) = (s.knots_u().degree(), s.knots_v().degree());
    let [_, count_v] = s.counts();
    let net = s.control_net();
    // Rows along v first: `columns[j]` holds the j-th v-derivative of each of the p + 1 rows.
    let mut columns: Vec<Vec<[S; 4]>> = vec![Vec::with_capacity(p + 1); order + 1];
    let mut local: Vec<[S; 4]> = Vec::with_capacity(q + 1);
    let first_weight = net[(span_u.index - p) * count_v + span_v.index - q][3];
    let mut rational = false;
    for i in span_u.index - p..=span_u.index {
        let row = &net[i * count_v + span_v.index - q..=i * count_v + span_v.index];
        rational |= row.iter().any(|x| x[3] != first_weight);
        local.clear();
        local.extend(
            row.iter()
                .map(|x| -> [S; 4] { std::array::from_fn(|c| S::exact(x[c])) }),
        );
        for (j, value) in span_v
            .derivatives(&mut local, order)
            .into_iter()
            .enumerate()
        {
            columns[j].push(value);
        }
    }
    let mut homogeneous = Partials::new(order, [S::ZERO; 4]);
    for (j, column) in columns.iter_mut().enumerate() {
        for (i, value) in span_u
            .derivatives(column, order - j)
            .into_iter()
            .enumerate()
        {
            homogeneous.set(i, j, value);
        }
    }
    let mut out = homogeneous.map(|h| [h[0], h[1], h[2]]);
    if !rational {
        if first_weight != 1.0 {
            out = out.map(|x| x.map(|c| c / S::exact(first_weight)));
        }
        return out;
    }
    // The quotient rule, A4.4.
    let w = homogeneous.map(|h| h[3]);
    for (k, l) in orders(order) {
        let mut value = out.get(k, l);
        for i in 0..=k {
            for j in 0..=l {
                if i + j == 0 {
                    continue;
                }
                let factor = binomial::<S>(k, i) * binomial::<S>(l, j) * w.get(i, j);
                let part = out.get(k - i, l - j);
                for c in 0..3 {
                    value[c] = value[c] - factor * part[c];
                }
            }
        }
        out.set(k, l, value.map(|x| x / w.get(0, 0)));
    }
    out
}

/// The point and, of order 1, the first derivatives along u and v as [`nurbs`] has them, to the same bits; `None` where [`ShortSpan`] does not serve.
fn short_nurbs(s: &NurbsSurface, uv: [f64; 2], order: usize) -> Option<[[f64; 3]; 3]> {
    let knots = [s.knots_u(), s.knots_v()];
    let [du, dv] = [0, 1].map(|c| Parameter::new(uv[c], knots[c].domain(), Limit::FromAbove));
    let (span_u, span_v) = (
        ShortSpan::new(knots[0], &du)?,
        ShortSpan::new(knots[1], &dv)?,
    );
    let (p, q) = (span_u.degree, span_v.degree);
    let [_, count_v] = s.counts();
    let net = s.control_net();
    let first_weight = net[(span_u.index - p) * count_v + span_v.index - q][3];
    let mut rational = false;
    let mut local = [[0.0; 4]; SHORT + 1];
    let mut columns = [[[0.0; 4]; SHORT + 1]; 2];
    for i in 0..=p {
        let last = (span_u.index - p + i) * count_v + span_v.index;
        let row = &net[last - q..=last];
        rational |= row.iter().any(|x| x[3] != first_weight);
        for (own, x) in local.iter_mut().zip(row) {
            *own = (*x).into();
        }
        columns[0][i] = span_v.value(&local);
        if order > 0 {
            columns[1][i] = span_v.derivative(&local);
        }
    }
    let point = span_u.value(&columns[0]);
    let mut all = [point, [0.0; 4], [0.0; 4]];
    if order > 0 {
        all[1] = span_u.derivative(&columns[0]);
        all[2] = span_u.value(&columns[1]);
    }
    let by = if rational { point[3] } else { first_weight };
    // The quotient by 1 is the number itself.
    let at: [f64; 3] = std::array::from_fn(|c| point[c] / by);
    let slope = |d: &[f64; 4]| {
        std::array::from_fn(|c| {
            let turn = if rational { d[3] * at[c] } else { 0.0 };
            (d[c] - turn) / by
        })
    };
    Some([at, slope(&all[1]), slope(&all[2])])
}

/// A homogeneous point `(w x, w y, w z, w)` taken apart for turning about a revolution's axis:
/// all parts times w.
pub(in crate::nurbs) struct Rotation {
    /// The point of the axis, times w, and the part along the axis.
    fixed: [[Ball<Dd>; 3]; 2],
    /// The part that turns, and that turned by 90 degrees.
    turning: [[Ball<Dd>; 3]; 2],
}

impl Rotation {
    pub(in crate::nurbs) fn new(s: &Revolution, p: &Vector4<f64>) -> Self {
        let n = unit(&s.axis);
        let origin = std::array::from_fn(|c| Ball::exact(p[3]) * Ball::exact(s.origin[c]));
        let d: [Ball<Dd>; 3] = std::array::from_fn(|c| Ball::exact(p[c]) - origin[c]);
        let (along, e, f) = split(&d, &n);
        Self {
            fixed: [origin, along],
            turning: [e, f],
        }
    }

    /// The point turned, its fixed part times `share`: 1 on the surface, the cosine of half a piece's
    /// angle for a middle control point.
    pub(in crate::nurbs) fn turned(
        &self,
        sin: Ball<Dd>,
        cos: Ball<Dd>,
        share: Ball<Dd>,
    ) -> [Ball<Dd>; 3] {
        std::array::from_fn(|c| {
            share * (self.fixed[0][c] + self.fixed[1][c])
                + (cos * self.turning[0][c] + sin * self.turning[1][c])
        })
    }
}
