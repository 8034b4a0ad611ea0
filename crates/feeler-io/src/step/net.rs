//! Points and first derivatives of B-spline surfaces by basis functions: [`point`], [`derivatives`].
//!
//! The kernel's are de Boor's triangles for each row of the net, to the same bits at each order; of degree 6 by 10 they take 40 times as long. Searches,
//! which carry no proof, ask for tens of thousands.

use feeler::nurbs::{KnotVector, NurbsSurface};
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
        values[0] = 1.0;
        for j in 1..=p {
            let (mut saved, mut before) = (0.0, 0.0);
            for r in 0..j {
                let (right, left) = (k[span + r + 1] - t, t - k[span + 1 + r - j]);
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

/// The rows of the net of which a basis function along u is not zero, each from the first along v on.
fn rows<'a>(s: &'a NurbsSurface, [u, v]: [&Basis; 2]) -> impl Iterator<Item = &'a [Vector4<f64>]> {
    let [p, q] = [s.knots_u(), s.knots_v()].map(|k| k.degree() + 1);
    let rows = s.control_net().chunks_exact(s.counts()[1]);
    let first = v.first;
    let own = rows.skip(u.first).take(p);
    own.map(move |row| row.get(first..first + q).unwrap_or(&[]))
}

/// The point at uv, clamped to the domain: that of [`derivatives`], to the same bits.
pub(super) fn point(s: &NurbsSurface, [u, v]: [f64; 2]) -> Point3<f64> {
    let (u, v) = (Basis::at(s.knots_u(), u), Basis::at(s.knots_v(), v));
    let mut h = Vector4::zeros();
    for (row, value) in rows(s, [&u, &v]).zip(u.values) {
        let mut own = Vector4::zeros();
        for (x, value) in row.iter().zip(v.values) {
            own += x * value;
        }
        h += own * value;
    }
    Point3::from(h.xyz() / h.w)
}

/// The point at uv, clamped to the domain, and the derivatives by u and v, from above.
pub(super) fn derivatives(s: &NurbsSurface, [u, v]: [f64; 2]) -> [Vector3<f64>; 3] {
    let (u, v) = (Basis::at(s.knots_u(), u), Basis::at(s.knots_v(), v));
    let mut sums = [Vector4::zeros(); 3];
    for (row, (value, slope)) in rows(s, [&u, &v]).zip(u.values.into_iter().zip(u.slopes)) {
        let (mut own, mut along) = (Vector4::zeros(), Vector4::zeros());
        for (x, (value, slope)) in row.iter().zip(v.values.into_iter().zip(v.slopes)) {
            own += x * value;
            along += x * slope;
        }
        sums[0] += own * value;
        sums[1] += own * slope;
        sums[2] += along * value;
    }
    let [h, du, dv] = sums;
    let point = h.xyz() / h.w;
    [
        point,
        (du.xyz() - point * du.w) / h.w,
        (dv.xyz() - point * dv.w) / h.w,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler::nurbs::Surface;

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
}
