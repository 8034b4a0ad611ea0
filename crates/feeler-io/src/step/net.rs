//! Points and first derivatives of B-spline surfaces and curves by basis functions: [`point`], [`derivatives`], [`on_curve`].
//!
//! The kernel's are de Boor's triangles for each row of the net, to the same bits at each order; of degree 6 by 10 they take 40 times as long. Searches,
//! which carry no proof, ask for tens of thousands.

use feeler::nurbs::{KnotVector, NurbsCurve, NurbsSurface};
use nalgebra::{Point3, Vector3, Vector4};

/// Values and derivatives of the basis functions that are not zero at a parameter, from the one with index `first` on.
struct Basis {
    first: usize,
    values: [f64; KnotVector::MAX_DEGREE + 1],
    slopes: [f64; KnotVector::MAX_DEGREE + 1],
}

impl Basis {
    /// The NURBS Book, A2.2 and equation 2.7.
    fn at(knots: &KnotVector, t: f64) -> Self {
        let domain = knots.domain();
        let t = t.clamp(domain.start, domain.end);
        let (p, span, k) = (knots.degree(), knots.find_span(t), knots.knots());
        let mut values = [0.0; KnotVector::MAX_DEGREE + 1];
        let mut slopes = [0.0; KnotVector::MAX_DEGREE + 1];
        // From t to the knots above and below, the nearest first.
        let mut above = [0.0; KnotVector::MAX_DEGREE];
        let mut below = [0.0; KnotVector::MAX_DEGREE];
        for j in 0..p {
            above[j] = k[span + 1 + j] - t;
            below[j] = t - k[span - j];
        }
        values[0] = 1.0;
        for j in 1..=p {
            let (mut saved, mut before) = (0.0, 0.0);
            for r in 0..j {
                let (right, left) = (above[r], below[j - 1 - r]);
                let part = values[r] / (right + left);
                if j == p {
                    slopes[r] = p as f64 * (before - part);
                    before = part;
                }
                values[r] = saved + right * part;
                saved = left * part;
            }
            values[j] = saved;
            if j == p {
                slopes[p] = p as f64 * before;
            }
        }
        Self {
            first: span - p,
            values,
            slopes,
        }
    }
}

/// Adds a homogeneous point times a number.
fn add(sum: &mut [f64; 4], x: &[f64; 4], by: f64) {
    sum[0] += x[0] * by;
    sum[1] += x[1] * by;
    sum[2] += x[2] * by;
    sum[3] += x[3] * by;
}

/// The point of a homogeneous one.
fn point_of(h: [f64; 4]) -> Point3<f64> {
    let [x, y, z, w] = h;
    Point3::new(x / w, y / w, z / w)
}

/// The derivative of a point, from that of the homogeneous one `h`.
fn derivative_of(d: [f64; 4], h: [f64; 4], point: &Vector3<f64>) -> Vector3<f64> {
    (Vector3::new(d[0], d[1], d[2]) - point * d[3]) / h[3]
}

/// The rows of the net of which a basis function along u is not zero, each from column `first` on.
fn rows<'a>(
    s: &'a NurbsSurface,
    u: &Basis,
    first: usize,
) -> impl Iterator<Item = &'a [Vector4<f64>]> {
    let [p, q] = [s.knots_u(), s.knots_v()].map(|k| k.degree() + 1);
    let rows = s.control_net().chunks_exact(s.counts()[1]);
    let own = rows.skip(u.first).take(p);
    own.map(move |row| row.get(first..first + q).unwrap_or(&[]))
}

fn point_in(s: &NurbsSurface, u: &Basis, first: usize, values: &[f64]) -> Point3<f64> {
    let mut h = [0.0; 4];
    for (row, value) in rows(s, u, first).zip(&u.values) {
        let mut own = [0.0; 4];
        for (x, value) in row.iter().zip(values) {
            add(&mut own, &x.data.0[0], *value);
        }
        add(&mut h, &own, *value);
    }
    point_of(h)
}

/// The point at uv, clamped to the domain: that of [`derivatives`], to the same bits.
pub(super) fn point(s: &NurbsSurface, [u, v]: [f64; 2]) -> Point3<f64> {
    let (u, v) = (Basis::at(s.knots_u(), u), Basis::at(s.knots_v(), v));
    let q = s.knots_v().degree();
    point_in(s, &u, v.first, &v.values[..=q])
}

/// Numbers that [`points`] holds for a v.
pub(super) fn held(s: &NurbsSurface) -> usize {
    s.knots_v().degree() + 2
}

/// The points at all of some u and v, one u after the other: basis functions are found once for each.
pub(super) fn points(s: &NurbsSurface, us: &[f64], vs: &[f64], mut put: impl FnMut(Point3<f64>)) {
    let q = s.knots_v().degree();
    let mut values = Vec::with_capacity(vs.len() * (q + 1));
    let mut firsts = Vec::with_capacity(vs.len());
    for v in vs {
        let v = Basis::at(s.knots_v(), *v);
        values.extend_from_slice(&v.values[..=q]);
        firsts.push(v.first);
    }
    for u in us {
        let u = Basis::at(s.knots_u(), *u);
        for (first, values) in firsts.iter().zip(values.chunks_exact(q + 1)) {
            put(point_in(s, &u, *first, values));
        }
    }
}

/// The point at uv, clamped to the domain, and the derivatives by u and v, from above.
pub(super) fn derivatives(s: &NurbsSurface, [u, v]: [f64; 2]) -> [Vector3<f64>; 3] {
    let (u, v) = (Basis::at(s.knots_u(), u), Basis::at(s.knots_v(), v));
    let q = s.knots_v().degree();
    let (values, slopes) = (&v.values[..=q], &v.slopes[..=q]);
    let (mut h, mut du, mut dv) = ([0.0; 4], [0.0; 4], [0.0; 4]);
    for (i, row) in rows(s, &u, v.first).enumerate() {
        let (mut own, mut along) = ([0.0; 4], [0.0; 4]);
        for (j, x) in row.iter().enumerate() {
            add(&mut own, &x.data.0[0], values[j]);
            add(&mut along, &x.data.0[0], slopes[j]);
        }
        add(&mut h, &own, u.values[i]);
        add(&mut du, &own, u.slopes[i]);
        add(&mut dv, &along, u.values[i]);
    }
    let point = point_of(h).coords;
    [
        point,
        derivative_of(du, h, &point),
        derivative_of(dv, h, &point),
    ]
}

/// The point of a spline at a parameter, clamped to the domain, and the derivative, from above.
pub(super) fn on_curve(c: &NurbsCurve<4>, t: f64) -> [Vector3<f64>; 2] {
    let basis = Basis::at(c.knots(), t);
    let points = { c.control_points().iter().skip(basis.first) }.take(c.degree() + 1);
    let (mut h, mut d) = ([0.0; 4], [0.0; 4]);
    for (x, (value, slope)) in points.zip(basis.values.iter().zip(&basis.slopes)) {
        add(&mut h, &x.data.0[0], *value);
        add(&mut d, &x.data.0[0], *slope);
    }
    let point = point_of(h).coords;
    [point, derivative_of(d, h, &point)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::nurbs::{Curve, Curve3, Surface};

    /// As the kernel has them, at knots and at both ends, too.
    #[test]
    fn points_and_derivatives_are_the_kernels() {
        for (p, q) in [(1, 1), (2, 3), (6, 10)] {
            let knots = |p: usize| {
                let inner = [1.0, 2.5, 2.5];
                let inner = &inner[..if p > 1 { 3 } else { 1 }];
                [&vec![0.0; p + 1][..], inner, &vec![4.0; p + 1]].concat()
            };
            let [n, m] = [p, q].map(|d| knots(d).len() - d - 1);
            let net = (0..n * m).map(|k| {
                let (i, j) = ((k / m) as f64, (k % m) as f64);
                let w = 1.0 + 0.25 * (i - j).sin();
                Vector4::new(i * w, j * w, (i * j).cos() * w, w)
            });
            let s = NurbsSurface::new([p, q], [n, m], net.collect(), [knots(p), knots(q)]).unwrap();
            let whole = Surface::Nurbs(s.clone());
            let (us, vs) = ([0.0, 0.3, 2.5, 4.0], [0.0, 1.7, 4.0]);
            let mut all = Vec::new();
            points(&s, &us, &vs, |p| all.push(p));
            let singly = us.iter().flat_map(|u| vs.map(|v| point(&s, [*u, v])));
            assert!(all.into_iter().eq(singly));
            for u in [-1.0, 0.0, 0.3, 1.0, 2.5, 3.9, 4.0] {
                for v in [0.0, 1.7, 2.5, 4.0, 9.0] {
                    let own = derivatives(&s, [u, v]);
                    assert_eq!(Point3::from(own[0]), point(&s, [u, v]));
                    let theirs = whole.derivatives(u, v, 1);
                    for (own, at) in own.iter().zip([(0, 0), (1, 0), (0, 1)]) {
                        let theirs = theirs.get(at.0, at.1);
                        let off = (own - theirs).norm();
                        assert!(
                            off <= 1e-12 * (1.0 + theirs.norm()),
                            "{p} {q} {u} {v}: {off:e}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn points_and_tangents_of_curves_are_the_kernels() {
        for p in [1, 3, 8] {
            let knots = [&vec![-1.0; p + 1][..], &[0.0, 0.25], &vec![2.0; p + 1]].concat();
            let points = (0..p + 3).map(|k| {
                let (x, w) = (k as f64, 1.0 + 0.5 * (k % 2) as f64);
                Vector4::new(x * w, x * x * w, x.sin() * w, w)
            });
            let spline = NurbsCurve::new(p, points.collect(), knots).unwrap();
            let curve: Curve3 = Curve::Nurbs(spline.clone());
            for t in [-2.0, -1.0, -0.3, 0.0, 0.25, 1.0, 2.0, 3.0] {
                let own = on_curve(&spline, t);
                for (own, theirs) in own.iter().zip(curve.derivatives(t, 1)) {
                    let off = (own - theirs).norm();
                    assert!(off <= 1e-12 * (1.0 + theirs.norm()), "{p} {t}: {off:e}");
                }
            }
        }
    }
}
