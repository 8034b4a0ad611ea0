//! Evaluation of NURBS against exact rational arithmetic.

#![allow(
    clippy::needless_range_loop,
    reason = "indices name orders and coordinates"
)]

use crate::common::{abs, curve, holds, q, surface};
use dashu_ratio::RBig as Q;
use feeler::numeric::{Ball, Dd};
use feeler::nurbs::eval::partials;
use feeler::nurbs::{Curve, Curve3, Limit, NurbsCurve, NurbsCurve3, Surface};
use nalgebra::{SVector, Vector3, Vector4};
use proptest::prelude::*;

/// n u / (1 - n u) with u = 2^-53.
fn gamma(n: usize) -> f64 {
    let nu = n as f64 * f64::EPSILON / 2.0;
    nu / (1.0 - nu)
}

/// Checks all that a curve promises at one parameter.
fn check_curve(c: &NurbsCurve3, t: f64, order: usize) {
    let curve: Curve3 = Curve::Nurbs(c.clone());
    for (limit, below) in [(Limit::FromAbove, false), (Limit::FromBelow, true)] {
        let truth = crate::common::exact_curve(c, &q(t), order, below);
        let fine = curve.derivatives_in::<Ball<Dd>>(t, order, limit);
        let coarse = curve.derivatives_in::<Ball<f64>>(t, order, limit);
        for k in 0..=order {
            for i in 0..3 {
                assert!(
                    holds(&fine[k][i], &truth[k][i]),
                    "degree {} t {t:e} order {k}: {:?}",
                    c.degree(),
                    fine[k][i]
                );
                let b = coarse[k][i];
                assert!(
                    b.rad.is_infinite() || abs(&(q(b.mid) - &truth[k][i])) <= q(b.rad),
                    "degree {} t {t:e} order {k}: {b:?}",
                    c.degree(),
                );
            }
        }
    }
    // The a-priori bound of `point`, and the rounded bound.
    let truth = &crate::common::exact_curve(c, &q(t), 0, false)[0];
    let plain = curve.point(t);
    let (point, bound) = curve.point_with_bound(t);
    for i in 0..3 {
        let largest = c
            .control_points()
            .iter()
            .map(|p| abs(&(q(p[i]) / q(p[3]))))
            .max()
            .unwrap();
        // The smallest f64 allows for underflow, in the range where that has no other effect.
        let limit = q(gamma(12 * c.degree() + 1)) * &largest + q(f64::from_bits(1));
        assert!(abs(&(q(plain[i]) - &truth[i])) <= limit, "{plain:?}");
        assert!(abs(&(q(point[i]) - &truth[i])) <= q(bound));
    }
    let largest = truth.iter().map(abs).max().unwrap();
    let net = c
        .control_points()
        .iter()
        .flat_map(|p| (0..3).map(|i| abs(&(q(p[i]) / q(p[3])))))
        .max()
        .unwrap();
    // Not only a bound but a good one.
    let half_ulp = largest * q(f64::EPSILON / 2.0);
    assert!(
        q(bound) <= half_ulp * q(1.001) + net * q(1e-28) + q(1e-270),
        "bound {bound:e} at {t}"
    );
}

/// Parameters worth trying: knots, their neighbours, ends, and some between.
fn parameters(c: &NurbsCurve3) -> Vec<f64> {
    let d = c.domain();
    let mut out = vec![d.start, d.end, d.mid(), d.lerp(0.3)];
    for (_, a, b) in c.knots().spans() {
        out.extend([a, a.next_up(), 0.5 * a + 0.5 * b, b.next_down()]);
    }
    out.retain(|t| d.contains(*t));
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn curves_hold_their_bounds(c in curve(), s in 0.0f64..1.0) {
        // Orders above the degree too.
        check_curve(&c, c.domain().lerp(s), c.degree() + 2);
        for t in parameters(&c) {
            check_curve(&c, t, 1);
        }
    }

    #[test]
    fn surfaces_hold_their_bounds(s in surface(), x in 0.0f64..1.0, y in 0.0f64..1.0) {
        let [du, dv] = s.domain();
        let native = Surface::Nurbs(s.clone());
        for (u, v) in [(du.lerp(x), dv.lerp(y)), (du.end, dv.lerp(y)), (du.start, dv.end)] {
            let truth = crate::common::exact_surface(&s, &q(u), &q(v), 3);
            let fine = partials::<Ball<Dd>>(&native, [u, v], 3, [Limit::FromAbove; 2]);
            let coarse = partials::<Ball<f64>>(&native, [u, v], 3, [Limit::FromAbove; 2]);
            for i in 0..=3 {
                for j in 0..=3 - i {
                    for c in 0..3 {
                        prop_assert!(holds(&fine.get(i, j)[c], &truth[i][j][c]));
                        let b = coarse.get(i, j)[c];
                        prop_assert!(
                            b.rad.is_infinite() || abs(&(q(b.mid) - &truth[i][j][c])) <= q(b.rad)
                        );
                    }
                }
            }
            let at = native.first_derivatives_with_bound(u, v);
            let degrees = s.knots_u().degree() + s.knots_v().degree();
            let plain = native.point(u, v);
            for c in 0..3 {
                prop_assert!(abs(&(q(at.point[c]) - &truth[0][0][c])) <= q(at.bound));
                prop_assert!(abs(&(q(at.du[c]) - &truth[1][0][c])) <= q(at.du_bound));
                prop_assert!(abs(&(q(at.dv[c]) - &truth[0][1][c])) <= q(at.dv_bound));
                let largest = s.control_net().iter().map(|p| abs(&(q(p[c]) / q(p[3])))).max().unwrap();
                prop_assert!(
                    abs(&(q(plain[c]) - &truth[0][0][c])) <= q(gamma(12 * degrees + 1)) * largest
                );
            }
            prop_assert!(at.bound < 1e-14);
        }
    }

    /// The homogeneous basis sums to one: equal control points give that point, exactly.
    #[test]
    fn partition_of_unity(c in curve(), s in 0.0f64..1.0) {
        let p = Vector4::new(0.1, -1e9, 3e-7, 1.0);
        let same = NurbsCurve::new(
            c.degree(), vec![p; c.control_points().len()], c.knots().knots().to_vec()).unwrap();
        let same: Curve3 = Curve::Nurbs(same);
        let d = same.derivatives(c.domain().lerp(s), 2);
        prop_assert_eq!(d[0], Vector3::new(0.1, -1e9, 3e-7));
        prop_assert_eq!(d[1], Vector3::zeros());
        prop_assert_eq!(d[2], Vector3::zeros());
    }
}

fn bezier(points: Vec<Vector4<f64>>) -> NurbsCurve3 {
    let p = points.len() - 1;
    let knots = [vec![0.0; p + 1], vec![1.0; p + 1]].concat();
    NurbsCurve::new(p, points, knots).unwrap()
}

/// Stress case E1: weights over 24 orders of magnitude.
#[test]
fn weight_ratios() {
    for e in [3, 6, 12] {
        let w = 10f64.powi(e);
        let p = |x: f64, y: f64, w: f64| Vector4::new(w * x, w * y, w, w);
        let c = bezier(vec![
            p(0., 0., w),
            p(1., 5., 1. / w),
            p(2., -7., w),
            p(3., 1., 1. / w),
        ]);
        for t in [0.0, 1e-9, 0.25, 0.5, 1.0 - 1e-12, 1.0] {
            check_curve(&c, t, 5);
        }
    }
}

/// Stress case E3: spans down to one ulp; the half-open rule on each.
#[test]
fn tiny_spans() {
    for width in [1e-6, 1e-9, 1e-12, f64::EPSILON] {
        let k = vec![
            0.,
            0.,
            0.,
            0.,
            1.,
            1. + width,
            1. + width,
            1. + width,
            2.,
            2.,
            2.,
            2.,
        ];
        let points: Vec<_> = (0..8)
            .map(|i| {
                Vector4::new(
                    f64::from(i),
                    f64::from(i * i % 7),
                    1.0 / f64::from(i + 1),
                    1.0,
                )
            })
            .collect();
        let c = NurbsCurve::new(3, points, k).unwrap();
        for t in parameters(&c) {
            check_curve(&c, t, 4);
        }
    }
}

/// Stress case E4: a corner has two derivatives, and both can be had.
#[test]
fn corners_are_one_sided() {
    let points = [[0., 0.], [1., 0.], [1., 1.]]
        .iter()
        .map(|p| Vector3::new(p[0], p[1], 1.0))
        .collect();
    let c = Curve::<2, 3>::Nurbs(NurbsCurve::new(1, points, vec![0., 0., 1., 2., 2.]).unwrap());
    let at = |limit| c.derivatives_in::<f64>(1.0, 1, limit)[1];
    assert_eq!(at(Limit::FromAbove), [0.0, 1.0]);
    assert_eq!(at(Limit::FromBelow), [1.0, 0.0]);
    assert_eq!(c.derivatives(2.0, 1)[1], SVector::from([0.0, 1.0]));
}

/// Stress case E6: every degree.
#[test]
fn degrees_up_to_25() {
    for p in 1..=25usize {
        let points = (0..=p + 2)
            .map(|i| {
                let s = if i % 2 == 0 { 1.0 } else { -1.0 };
                let w = 1.0 + (i % 3) as f64;
                Vector4::new(w * i as f64, w * s, w * 0.1 * s, w)
            })
            .collect();
        let mut k = vec![0.0; p + 1];
        k.extend([0.3, 0.7]);
        k.extend(vec![1.0; p + 1]);
        let c = NurbsCurve::new(p, points, k).unwrap();
        for t in [0.0, 0.29, 0.3, 0.5, 1.0] {
            check_curve(&c, t, 3);
        }
    }
}

/// Stress case E7.
#[test]
fn parameters_are_clamped() {
    let c: Curve3 = Curve::Nurbs(bezier(vec![
        Vector4::new(1., 2., 3., 1.),
        Vector4::new(4., 5., 6., 1.),
    ]));
    for t in [-1e-300, -1.0, f64::NEG_INFINITY, f64::NAN] {
        assert_eq!(c.derivatives(t, 1), c.derivatives(0.0, 1), "{t}");
    }
    for t in [1.0_f64.next_up(), 7.0, f64::INFINITY] {
        assert_eq!(c.derivatives(t, 1), c.derivatives(1.0, 1), "{t}");
    }
}

/// Stress cases E8, E9, E13, E14: large offsets, mixed scales, subnormal and huge coordinates.
#[test]
fn scales() {
    let shapes: [[[f64; 3]; 4]; 4] = [
        [
            [1e9, 0., 0.],
            [1e9 + 1e-6, 1., 0.],
            [1e9 + 3e-6, -1., 0.],
            [1e9, 2., 1.],
        ],
        [
            [1e6, 1e-6, 0.],
            [-1e6, 3e-6, 0.],
            [2e6, -1e-6, 1e-6],
            [1e6, 0., 1e-6],
        ],
        [
            [1e-310, 2e-310, 0.],
            [5e-324, 1e-309, 0.],
            [-1e-310, 0., 0.],
            [1e-308, 1e-310, 0.],
        ],
        [
            [1e150, 0., 1.],
            [-1e150, 1e150, 0.],
            [3e149, 1e-150, 0.],
            [1e150, 1e150, 1e150],
        ],
    ];
    for shape in shapes {
        let points = shape
            .iter()
            .map(|p| Vector4::new(p[0], p[1], p[2], 1.0))
            .collect();
        let c = bezier(points);
        for t in [0.0, 0.1, 1.0 / 3.0, 0.5, 0.999_999_9, 1.0] {
            let truth = &crate::common::exact_curve(&c, &q(t), 0, false)[0];
            let curve: Curve3 = Curve::Nurbs(c.clone());
            let (point, bound) = curve.point_with_bound(t);
            assert!(bound.is_finite());
            for i in 0..3 {
                assert!(point[i].is_finite());
                assert!(
                    abs(&(q(point[i]) - &truth[i])) <= q(bound),
                    "{point:?} +- {bound:e}"
                );
            }
            check_curve(&c, t, 3);
        }
    }
}

/// Where f64 ends, the bound is infinite and no number is NaN.
#[test]
fn overflow_is_no_answer() {
    let c: Curve3 = Curve::Nurbs(bezier(vec![
        Vector4::new(1e308, 0., 0., 1e-300),
        Vector4::new(-1e308, 0., 0., 1.),
    ]));
    let (point, bound) = c.point_with_bound(0.25);
    assert!(point.iter().all(|x| x.is_finite()) && bound == f64::INFINITY);
}

/// Stress case E15: orders above the degree are exactly zero for polynomials and not for
/// quotients. d^k/dt^k of 1 / (1 + t) at 0 is (-1)^k k!.
#[test]
fn orders_above_the_degree() {
    let polynomial: Curve3 = Curve::Nurbs(bezier(vec![
        Vector4::new(1., 2., 3., 1.),
        Vector4::new(4., 5., 7., 1.),
        Vector4::new(4., 5., 6., 1.),
    ]));
    for d in &polynomial.derivatives(0.3, 6)[3..] {
        assert_eq!(*d, Vector3::zeros());
    }
    let quotient: Curve3 = Curve::Nurbs(bezier(vec![
        Vector4::new(1., 0., 0., 1.),
        Vector4::new(1., 0., 0., 2.),
    ]));
    let d = quotient.derivatives(0.0, 5);
    let x: Vec<f64> = d.iter().map(|v| v[0]).collect();
    assert_eq!(x, [1., -1., 2., -6., 24., -120.]);
}

#[test]
fn the_reference_itself() {
    // The reference on a parabola, by hand: (t, t^2) at 1/3.
    let c = bezier(vec![
        Vector4::new(0., 0., 0., 1.),
        Vector4::new(0.5, 0., 0., 1.),
        Vector4::new(1., 1., 0., 1.),
    ]);
    let third = Q::ONE / Q::from(3);
    let d = crate::common::exact_curve(&c, &third, 3, false);
    assert_eq!(d[0], [third.clone(), &third * &third, Q::ZERO]);
    assert_eq!(d[1], [Q::ONE, Q::from(2) * third, Q::ZERO]);
    assert_eq!(d[2], [Q::ZERO, Q::from(2), Q::ZERO]);
    assert_eq!(d[3], [Q::ZERO, Q::ZERO, Q::ZERO]);
}
