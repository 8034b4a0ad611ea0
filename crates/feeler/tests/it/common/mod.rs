//! Exact rational evaluation of NURBS from the definition of the basis functions (Cox and de
//! Boor's recurrence and its derivative, The NURBS Book, equations 2.5 and 2.7), which shares
//! nothing with the library: no de Boor triangle, no derivative control points.

use dashu_ratio::RBig as Q;
use feeler::numeric::{Ball, Dd};
use feeler::nurbs::{KnotVector, NurbsCurve, NurbsCurve3, NurbsSurface};
use nalgebra::Vector4;
use proptest::prelude::*;

/// The exact value of a finite f64.
pub(crate) fn q(x: f64) -> Q {
    Q::try_from(x).unwrap()
}

pub(crate) fn abs(x: &Q) -> Q {
    if *x < Q::ZERO { -x.clone() } else { x.clone() }
}

/// `hi + lo` exactly.
pub(crate) fn exact(x: Dd) -> Q {
    q(x.hi) + q(x.lo)
}

/// Whether a ball holds the exact value.
pub(crate) fn holds(b: &Ball<Dd>, truth: &Q) -> bool {
    abs(&(exact(b.mid) - truth)) <= q(b.rad)
}

/// The k-th derivatives of all basis functions on span `span`, at `u`.
pub(crate) fn basis(knots: &KnotVector, span: usize, u: &Q, k: usize) -> Vec<Q> {
    let p = knots.degree();
    let n = knots.control_points();
    let t: Vec<Q> = knots.knots().iter().map(|x| q(*x)).collect();
    if k > p {
        return vec![Q::ZERO; n];
    }
    let mut values = vec![Q::ZERO; t.len() - 1];
    values[span] = Q::ONE;
    for r in 1..=p {
        let next: Vec<Q> = (0..t.len() - 1 - r)
            .map(|i| {
                let (wl, wr) = (&t[i + r] - &t[i], &t[i + r + 1] - &t[i + 1]);
                let mut sum = Q::ZERO;
                let differentiate = r > p - k;
                // 0 / 0 counts as 0.
                if wl != Q::ZERO && values[i] != Q::ZERO {
                    let factor = if differentiate { Q::from(r) } else { u - &t[i] };
                    sum += factor / wl * &values[i];
                }
                if wr != Q::ZERO && values[i + 1] != Q::ZERO {
                    let factor = if differentiate {
                        -Q::from(r)
                    } else {
                        &t[i + r + 1] - u
                    };
                    sum += factor / wr * &values[i + 1];
                }
                sum
            })
            .collect();
        values = next;
    }
    values.truncate(n);
    values
}

fn binomial(n: usize, k: usize) -> Q {
    (0..k).fold(Q::ONE, |b, i| b * Q::from(n - i) / Q::from(i + 1))
}

/// The span of `u` by its definition, found by looking at all of them; `below`: the span below a knot.
pub(crate) fn span(knots: &KnotVector, u: &Q, below: bool) -> usize {
    let spans: Vec<_> = knots.spans().collect();
    let hit = spans.iter().find(|(_, a, b)| {
        if below {
            q(*a) < *u && *u <= q(*b)
        } else {
            q(*a) <= *u && *u < q(*b)
        }
    });
    let end = if below { spans.first() } else { spans.last() };
    hit.or(end).unwrap().0
}

/// Exact derivatives of a curve, orders 0 to `order`, at the exact parameter `u`.
pub(crate) fn exact_curve<const H: usize>(
    c: &NurbsCurve<H>,
    u: &Q,
    order: usize,
    below: bool,
) -> Vec<Vec<Q>> {
    let s = span(c.knots(), u, below);
    let homogeneous: Vec<Vec<Q>> = (0..=order)
        .map(|k| {
            let b = basis(c.knots(), s, u, k);
            (0..H)
                .map(|i| {
                    c.control_points()
                        .iter()
                        .zip(&b)
                        .filter(|(_, n)| **n != Q::ZERO)
                        .fold(Q::ZERO, |sum, (p, n)| sum + q(p[i]) * n)
                })
                .collect()
        })
        .collect();
    let mut out: Vec<Vec<Q>> = Vec::new();
    for k in 0..=order {
        let value = (0..H - 1)
            .map(|i| {
                let mut v = homogeneous[k][i].clone();
                for j in 1..=k {
                    v -= binomial(k, j) * &homogeneous[j][H - 1] * &out[k - j][i];
                }
                v / &homogeneous[0][H - 1]
            })
            .collect();
        out.push(value);
    }
    out
}

/// Exact partial derivatives `[i][j]`, `i + j <= order`.
pub(crate) fn exact_surface(s: &NurbsSurface, u: &Q, v: &Q, order: usize) -> Vec<Vec<[Q; 3]>> {
    let (su, sv) = (span(s.knots_u(), u, false), span(s.knots_v(), v, false));
    let bu: Vec<_> = (0..=order).map(|k| basis(s.knots_u(), su, u, k)).collect();
    let bv: Vec<_> = (0..=order).map(|k| basis(s.knots_v(), sv, v, k)).collect();
    let nv = s.counts()[1];
    let hom = |k: usize, l: usize| -> [Q; 4] {
        std::array::from_fn(|c| {
            let mut sum = Q::ZERO;
            for (i, nu) in bu[k].iter().enumerate().filter(|(_, n)| **n != Q::ZERO) {
                for (j, n) in bv[l].iter().enumerate().filter(|(_, n)| **n != Q::ZERO) {
                    sum += q(s.control_net()[i * nv + j][c]) * nu * n;
                }
            }
            sum
        })
    };
    let mut out: Vec<Vec<[Q; 3]>> = Vec::new();
    for k in 0..=order {
        out.push(Vec::new());
        for l in 0..=order - k {
            let a = hom(k, l);
            let value = std::array::from_fn(|c| {
                let mut x = a[c].clone();
                for i in 0..=k {
                    for j in 0..=l {
                        if i + j > 0 {
                            x -= binomial(k, i)
                                * binomial(l, j)
                                * &hom(i, j)[3]
                                * &out[k - i][l - j][c];
                        }
                    }
                }
                x / &hom(0, 0)[3]
            });
            out[k].push(value);
        }
    }
    out
}

/// A random knot vector of this degree with repeated knots, clamped or not.
pub(crate) fn knots(degree: usize) -> impl Strategy<Value = Vec<f64>> {
    (
        prop::collection::vec((0.01f64..2.0, 1..=degree), 0..4),
        any::<bool>(),
        prop::collection::vec(0.0f64..1.0, 2 * degree),
        -10.0f64..10.0,
    )
        .prop_map(move |(inner, clamped, outer, start)| {
            let mut below: Vec<f64> = Vec::new();
            let mut t = start;
            for x in &outer[..degree] {
                below.push(t);
                t -= if clamped { 0.0 } else { *x };
            }
            below.reverse();
            let mut k = below;
            // The outermost knot never matters.
            k.insert(0, k[0] - 1.0);
            let mut t = start;
            for (step, multiplicity) in inner {
                t += step;
                k.extend(std::iter::repeat_n(t, multiplicity));
            }
            t += 1.0;
            k.push(t);
            for x in &outer[degree..] {
                t += if clamped { 0.0 } else { *x };
                k.push(t);
            }
            k
        })
}

/// Random control points with weights over up to 24 orders of magnitude.
pub(crate) fn net(n: usize) -> impl Strategy<Value = Vec<Vector4<f64>>> {
    // Weights over 10^(+-e).
    (0.0f64..12.0).prop_flat_map(move |e| {
        prop::collection::vec(
            (
                prop::array::uniform3(-10.0f64..10.0),
                prop_oneof![Just(1.0), (-e..=e).prop_map(|x| 10f64.powf(x))],
            ),
            n,
        )
        .prop_map(|points| {
            points
                .into_iter()
                .map(|([x, y, z], w)| Vector4::new(w * x, w * y, w * z, w))
                .collect()
        })
    })
}

/// A random curve in space, degree up to 7.
pub(crate) fn curve() -> impl Strategy<Value = NurbsCurve3> {
    (1usize..=7).prop_flat_map(|p| {
        knots(p).prop_flat_map(move |k| {
            net(k.len() - p - 1)
                .prop_map(move |points| NurbsCurve::new(p, points, k.clone()).unwrap())
        })
    })
}

/// A random surface.
pub(crate) fn surface() -> impl Strategy<Value = NurbsSurface> {
    (1usize..=4, 1usize..=4).prop_flat_map(|(p, q)| {
        (knots(p), knots(q)).prop_flat_map(move |(ku, kv)| {
            let counts = [ku.len() - p - 1, kv.len() - q - 1];
            net(counts[0] * counts[1]).prop_map(move |points| {
                NurbsSurface::new([p, q], counts, points, [ku.clone(), kv.clone()]).unwrap()
            })
        })
    })
}
