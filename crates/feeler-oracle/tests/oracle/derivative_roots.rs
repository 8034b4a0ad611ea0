//! Derivative roots of trim curves against roots that are known from how the curves are made: the
//! cases S1 to S13 of the stress list.

use crate::scene;
use crate::scene::stress::{chebyshev, curve, graph, integral, product, reweighted, root};
use crate::scene::{bezier, brep, changed, dyadic, interval, line, plane};
use feeler::brep::Brep;
use feeler::numeric::Dyadic;
use feeler::nurbs::{Arc, Curve2, NurbsCurve, PolyCurve, Polyline};
use feeler_oracle::{AxisRootsTruth, DerivativeRootTruth, Oracle, TruthEnclosure};
use nalgebra::{Point2, Vector2, Vector3};

fn roots_of(b: &Brep) -> [AxisRootsTruth; 2] {
    let o = Oracle::new(&[b]).unwrap();
    let found = o.derivative_roots(0, 0, 0).unwrap().axes;
    for axis in &found {
        for pair in axis.roots.windows(2) {
            assert!(pair[0].t.hi < pair[1].t.lo, "not disjoint");
            // Between two roots the sign does not change, but through a constant part.
            assert!(pair[0].sign[1] * pair[1].sign[0] >= 0);
        }
        for r in &axis.roots {
            let width = r.t.width();
            assert!(
                r.t.lo <= r.t.hi && width <= Dyadic::new(1.into(), -150),
                "{r:?}"
            );
            assert!(r.turns() || r.multiplicity != [0, 0]);
            // An odd order flips the sign, an even one keeps it, where both sides are one polynomial.
            if r.multiplicity[0] == r.multiplicity[1] && r.sign[0] * r.sign[1] != 0 {
                let smooth = (r.multiplicity[0] % 2 == 1) == r.turns();
                assert!(smooth || r.t.lo == r.t.hi, "{r:?}");
            }
        }
    }
    found
}

fn roots(c: &Curve2) -> [AxisRootsTruth; 2] {
    roots_of(&brep(plane(1e3), Some(vec![vec![c.clone()]])))
}

/// Whether the enclosure holds p / q.
fn holds(r: &DerivativeRootTruth, p: i64, q: i64) -> bool {
    let at = |d: &Dyadic| d * &Dyadic::new(q.into(), 0);
    let p = Dyadic::new(p.into(), 0);
    at(&r.t.lo) <= p && p <= at(&r.t.hi)
}

/// The roots are these, (p, q, multiplicity), all inside a piece.
fn check(axis: &AxisRootsTruth, expected: &[(i64, i64, usize)]) {
    assert_eq!(axis.roots.len(), expected.len(), "{axis:?}");
    for (r, (p, q, m)) in axis.roots.iter().zip(expected) {
        assert!(holds(r, *p, *q), "{p}/{q}: {r:?}");
        assert_eq!(r.multiplicity, [*m, *m], "{p}/{q}");
        assert_eq!(r.turns(), m % 2 == 1);
    }
}

fn near(r: &DerivativeRootTruth, x: f64, tolerance: f64) -> bool {
    (r.t.lo.approximate() - x).abs() <= tolerance && (r.t.hi.approximate() - x).abs() <= tolerance
}

#[test]
fn s1_no_extrema() {
    let [u, v] = roots(&curve(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 3.0, 3.5]));
    assert!(u.roots.is_empty() && v.roots.is_empty() && u.constant.is_empty());
    assert_eq!(
        roots(&line([0.0, 1.0], [2.0, -1.0])),
        <[AxisRootsTruth; 2]>::default()
    );
}

#[test]
fn s2_double_root() {
    let [u, v] = roots(&graph(&[root(1, 3), root(1, 3)]));
    assert!(u.roots.is_empty());
    check(&v, &[(1, 3, 2)]);
    assert_eq!(v.roots[0].sign, [1, 1]);
    assert!(!v.roots[0].cusp);
    let many = [
        root(1, 3),
        root(1, 3),
        root(1, 3),
        root(1, 2),
        root(1, 2),
        root(5, 7),
    ];
    check(&roots(&graph(&many))[1], &[(1, 3, 3), (1, 2, 2), (5, 7, 1)]);
}

#[test]
fn s3_nearly_double_root() {
    // (t - 1/2)^2 - c; every control value is exact.
    let at = |c: f64| {
        curve(
            &[0.0, 1.0, 2.0, 3.0],
            &[0.0, 0.25 - c, -2.0 * c, 0.25 - 3.0 * c],
        )
    };
    check(&roots(&at(0.0))[1], &[(1, 2, 2)]);
    let c = 2f64.powi(-54);
    assert!(roots(&at(-c))[1].roots.is_empty());
    // 1/2 -+ 2^-27.
    check(
        &roots(&at(c))[1],
        &[((1 << 26) - 1, 1 << 27, 1), ((1 << 26) + 1, 1 << 27, 1)],
    );
}

/// Roots 0, e, 2e, 4e, ..: as the coefficients are rounded by a relative 2^-52 and the roots' ratios are 2, each
/// moves by no more than 100 times that, relatively (the product of (1 + 2^-k) / (1 - 2^-k) over all k, squared,
/// is below 70).
#[test]
fn s4_cluster() {
    let (n, e) = (9, -45);
    // Monomial coefficients of the product, divided by e^(n - k): integers.
    let mut c = vec![1.0];
    for k in 0..n {
        let r = if k == 0 { 0.0 } else { 2f64.powi(k - 1) };
        let mut next = vec![0.0; c.len() + 1];
        for (i, x) in c.iter().enumerate() {
            next[i] -= x * r;
            next[i + 1] += x;
        }
        c = next;
    }
    // Integrated and put into Bernstein form: sum over j <= i of C(i, j) / C(n + 1, j) a_j.
    let a: Vec<f64> = (0..=n + 1)
        .map(|j| {
            if j == 0 {
                0.0
            } else {
                c[j as usize - 1] * 2f64.powi(e * (n + 1 - j)) / j as f64
            }
        })
        .collect();
    let all = scene::stress::binomials(n as usize + 1);
    let v: Vec<f64> = (0..=n as usize + 1)
        .map(|i| {
            let row = scene::stress::binomials(i);
            (0..=i).map(|j| row[j] as f64 / all[j] as f64 * a[j]).sum()
        })
        .collect();
    let u: Vec<f64> = (0..v.len()).map(|i| i as f64).collect();
    let [_, found] = roots(&curve(&u, &v));
    assert_eq!(found.roots.len(), n as usize);
    assert_eq!(found.roots[0].t.hi, Dyadic::ZERO);
    assert_eq!(found.roots[0].multiplicity, [0, 1]);
    for (k, r) in found.roots.iter().enumerate().skip(1) {
        let expected = 2f64.powi(e + k as i32 - 1);
        assert!(near(r, expected, expected * 1e-12), "{k}");
        assert!(expected < 1e-10 && r.turns());
    }
    // Wilkinson: k / 20 and k / 25, control values rounded. In Bernstein form the inner roots' condition
    // is some 1e6, and 2^-53 times that is far below their distance.
    for p in [19i128, 24] {
        let factors: Vec<_> = (1..=p).map(|k| root(k, p + 1)).collect();
        let mut sum = 0.0;
        let mut v = vec![0.0];
        for d in wilkinson(&factors) {
            sum += d;
            v.push(sum);
        }
        let u: Vec<f64> = (0..v.len()).map(|i| i as f64).collect();
        let [_, found] = roots(&curve(&u, &v));
        assert_eq!(found.roots.len(), p as usize);
        for (k, r) in found.roots.iter().enumerate() {
            assert!(near(r, (k + 1) as f64 / (p + 1) as f64, 1e-4), "{p} {k}");
            assert!(r.turns());
        }
    }
}

/// Bernstein coefficients of a product in f64, each factor divided by its larger end: relative errors only, as
/// sums of exact integers would overflow.
fn wilkinson(factors: &[[i128; 2]]) -> Vec<f64> {
    use dashu_int::IBig;
    let mut c = vec![IBig::ONE];
    for f in factors {
        let mut next = vec![IBig::ZERO; c.len() + 1];
        for (i, x) in c.iter().enumerate() {
            next[i] += x * IBig::from(f[0]);
            next[i + 1] += x * IBig::from(f[1]);
        }
        c = next;
    }
    let n = scene::stress::binomials(c.len() - 1);
    // Cut at 2^20: relative errors of 2^-60 where it matters.
    c.iter()
        .zip(&n)
        .map(|(c, n)| Dyadic::new(c.clone() / IBig::from(*n), -60).approximate())
        .collect()
}

#[test]
fn s5_roots_at_ends_and_knots() {
    // v' = t (1 - t)^2.
    let [_, v] = roots(&graph(&[root(0, 1), [1, 0], [1, 0]]));
    assert_eq!(v.roots.len(), 2);
    let ends = [(0, [0, 1], [0, 1]), (1, [2, 0], [1, 0])];
    for (r, (at, multiplicity, sign)) in v.roots.iter().zip(ends) {
        assert!(holds(r, at, 1) && r.t.lo == r.t.hi);
        assert_eq!((r.multiplicity, r.sign), (multiplicity, sign));
    }
    // Uniform quadratic splines over knots 0, 1, ..: v' is linear between the differences of the control
    // values, at the knots.
    let spline = |v: &[f64], knots: Vec<f64>| {
        let points = v
            .iter()
            .enumerate()
            .map(|(i, v)| Vector3::new(i as f64, *v, 1.0))
            .collect();
        Curve2::Nurbs(NurbsCurve::new(2, points, knots).unwrap())
    };
    let uniform = |n: usize| (0..n).map(|k| k as f64).collect::<Vec<_>>();
    let [_, v] = roots(&spline(&[0.0, 1.0, 1.0, 0.0], uniform(7)));
    check(&v, &[(3, 1, 1)]);
    let [_, v] = roots(&spline(&[0.0, 1.0, 0.0, 1.0], uniform(7)));
    check(&v, &[(5, 2, 1), (7, 2, 1)]);
    // A corner at an inner knot of multiplicity 2: signs differ, nothing vanishes.
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0];
    let [_, v] = roots(&spline(&[0.0, 1.0, 2.0, 1.0, 0.0], knots.clone()));
    assert_eq!(v.roots.len(), 1);
    assert_eq!(
        (v.roots[0].multiplicity, v.roots[0].sign),
        ([0, 0], [1, -1])
    );
    assert!(v.roots[0].turns() && holds(&v.roots[0], 1, 1));
    // v' = 0 from below only: an inflection of the quadratic's end, then a rise.
    let [_, v] = roots(&spline(&[0.0, 2.0, 2.0, 3.0, 3.5], knots));
    assert_eq!(v.roots.len(), 1);
    assert_eq!((v.roots[0].multiplicity, v.roots[0].sign), ([1, 0], [1, 1]));
    assert!(!v.roots[0].turns());
    // A smooth extremum at a simple knot: differences 1, 0 would vanish at the knot between spans.
    let simple = vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0];
    let [_, v] = roots(&spline(&[0.0, 1.0, 1.0, 0.0], simple));
    assert_eq!(v.roots.len(), 1);
    assert_eq!(
        (v.roots[0].multiplicity, v.roots[0].sign),
        ([1, 1], [1, -1])
    );
}

#[test]
fn s6_cusp() {
    // u' = 2t - 1, v' = (2t - 1)^2, u raised to degree 3: differences 2/3 (-1, 0, 1) up to a factor.
    let v = integral(&product(&[root(1, 2), root(1, 2)]));
    let [u, v] = roots(&curve(&[0.0, -1.0, -1.0, 0.0], &v));
    check(&u, &[(1, 2, 1)]);
    check(&v, &[(1, 2, 2)]);
    assert!(u.roots[0].cusp && v.roots[0].cusp);
    // The same place without a cusp, and a point that stands still on a vertical line.
    let [u, _] = roots(&curve(&[0.0, -1.0, -1.0, 0.0], &[0.0, 1.0, 2.0, 3.0]));
    check(&u, &[(1, 2, 1)]);
    assert!(!u.roots[0].cusp);
    let [u, v] = roots(&curve(&[0.0, -1.0, -1.0, 0.0], &[2.0; 4]));
    assert!(u.roots[0].cusp && v.roots.is_empty() && v.constant.len() == 1);
}

#[test]
fn s7_loop() {
    // u' = 3 (-100, 200, -100): zeros of -(1-t)^2 + 4 t (1-t) - t^2 at (3 -+ sqrt 3) / 6; v' = 3 (100, 0, -150): of
    // 2 (1-t)^2 - 3 t^2 at sqrt 2 / (sqrt 2 + sqrt 3).
    let points = [
        [0.0, 0.0, 1.0],
        [-100.0, 100.0, 1.0],
        [100.0, 100.0, 1.0],
        [0.0, -50.0, 1.0],
    ];
    let [u, v] = roots(&bezier(&points));
    assert_eq!((u.roots.len(), v.roots.len()), (2, 1));
    let s3 = 3f64.sqrt();
    assert!(
        near(&u.roots[0], (3.0 - s3) / 6.0, 1e-15) && near(&u.roots[1], (3.0 + s3) / 6.0, 1e-15)
    );
    let s2 = 2f64.sqrt();
    assert!(near(&v.roots[0], s2 / (s2 + s3), 1e-15));
    assert!(
        u.roots
            .iter()
            .chain(&v.roots)
            .all(DerivativeRootTruth::turns)
    );
}

#[test]
fn s8_constant_coordinate() {
    let [u, v] = roots(&line([0.0, 3.0], [2.0, 3.0]));
    assert!(u.roots.is_empty() && u.constant.is_empty() && v.roots.is_empty());
    assert_eq!(v.constant.len(), 1);
    assert_eq!(v.constant[0][0].lo, dyadic(0.0));
    assert_eq!(v.constant[0][1].hi, dyadic(1.0));
    // Constant as a quotient: the weights differ.
    let [_, v] = roots(&bezier(&[
        [0.0, 3.0, 1.0],
        [1.0, 6.0, 2.0],
        [9.0, 1.5, 0.5],
    ]));
    assert_eq!((v.roots.len(), v.constant.len()), (0, 1));
    // Up, level, level, down: a plateau, no turn; two segments make one part.
    let points = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [4.0, 0.0]];
    let at = |p: &[f64; 2]| Point2::new(p[0], p[1]);
    let steps = Polyline::new(
        points.iter().map(at).collect(),
        vec![0.0, 1.0, 2.0, 4.0, 5.0],
    )
    .unwrap();
    let [u, v] = roots(&Curve2::Polyline(steps));
    assert!(u.roots.is_empty() && v.roots.is_empty());
    assert_eq!(v.constant.len(), 1);
    assert_eq!(
        (&v.constant[0][0].lo, &v.constant[0][1].hi),
        (&dyadic(1.0), &dyadic(4.0))
    );
    let zigzag = [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0], [1.0, 1.0]];
    let zigzag = Polyline::new(zigzag.iter().map(at).collect(), vec![0.0, 1.0, 2.0, 3.0]).unwrap();
    let [u, v] = roots(&Curve2::Polyline(zigzag));
    assert_eq!((u.roots.len(), v.roots.len()), (1, 2));
    assert!(v.roots.iter().all(DerivativeRootTruth::turns));
}

#[test]
fn s9_almost_constant() {
    let tiny = [0.0, 1e-300, 0.0, 1e-300];
    let [_, v] = roots(&curve(&[0.0, 1.0, 2.0, 3.0], &tiny));
    // Differences 1, -1, 1: (1-t)^2 - 2 t (1-t) + t^2 = (1 - 2t)^2.
    check(&v, &[(1, 2, 2)]);
    let e = f64::EPSILON;
    let [_, v] = roots(&curve(&[0.0, 1.0, 2.0], &[1.0, 1.0 + e, 1.0]));
    check(&v, &[(1, 2, 1)]);
    let [_, v] = roots(&curve(&[0.0, 1.0, 2.0], &[1.0, 1.0 + e, 1.0 + 3.0 * e]));
    assert!(v.roots.is_empty());
    assert!(v.constant.is_empty());
}

#[test]
fn s10_circle_of_nine_points() {
    let w = 0.5f64.sqrt();
    let at = |u: f64, v: f64, w: f64| Vector3::new(u * w, v * w, w);
    let points = vec![
        at(1.0, 0.0, 1.0),
        at(1.0, 1.0, w),
        at(0.0, 1.0, 1.0),
        at(-1.0, 1.0, w),
        at(-1.0, 0.0, 1.0),
        at(-1.0, -1.0, w),
        at(0.0, -1.0, 1.0),
        at(1.0, -1.0, w),
        at(1.0, 0.0, 1.0),
    ];
    let knots = [0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.].to_vec();
    let [u, v] = roots(&Curve2::Nurbs(NurbsCurve::new(2, points, knots).unwrap()));
    let exact = |r: &DerivativeRootTruth, k: f64| r.t.lo == dyadic(k) && r.t.hi == dyadic(k);
    // u is stationary at 0, 2, 4; v at 1, 3.
    assert_eq!((u.roots.len(), v.roots.len()), (3, 2));
    for (r, k) in u
        .roots
        .iter()
        .zip([0.0, 2.0, 4.0])
        .chain(v.roots.iter().zip([1.0, 3.0]))
    {
        assert!(exact(r, k) && !r.cusp);
    }
    assert_eq!(u.roots[0].multiplicity, [0, 1]);
    assert_eq!(u.roots[1].multiplicity, [1, 1]);
    assert_eq!(u.roots[2].multiplicity, [1, 0]);
    assert_eq!(u.roots[1].sign, [-1, 1]);
    assert_eq!(v.roots[0].sign, [1, -1]);
}

#[test]
fn s11_chebyshev() {
    // Rounding moves values by 2^-53 times the largest coefficient, 2.3e7; the extrema are +-1 with second
    // derivatives of 2500 at least: positions move by less than 1e-9, and no extremum vanishes.
    let t = chebyshev(25);
    let backwards: Vec<f64> = t.iter().rev().copied().collect();
    let axes = roots(&curve(&t, &backwards));
    for axis in axes {
        assert_eq!(axis.roots.len(), 24);
        for (k, r) in axis.roots.iter().enumerate() {
            let x = (1.0 - ((k + 1) as f64 * std::f64::consts::PI / 25.0).cos()) / 2.0;
            assert!(near(r, x, 1e-8) && r.turns(), "{k}");
        }
    }
}

#[test]
fn s12_rational() {
    // v' = (4t - 1) (2t - 1)^2 (3t - 2), run with weights 1, l, .., l^5: 16^5 and 16^-5.
    let factors = [root(1, 4), root(1, 2), root(1, 2), root(2, 3)];
    let v = integral(&product(&factors));
    let u: Vec<f64> = (0..v.len()).map(|i| i as f64).collect();
    check(
        &roots(&curve(&u, &v))[1],
        &[(1, 4, 1), (1, 2, 2), (2, 3, 1)],
    );
    for (l, p, q) in [(16.0, 16, 1), (1.0 / 16.0, 1, 16)] {
        // r = l t / (1 - t + l t): t = r / (r + l (1 - r)).
        let at = |a: i64, b: i64| (a * q, a * q + p * (b - a));
        let expected: Vec<_> = [(1, 4, 1), (1, 2, 2), (2, 3, 1)]
            .into_iter()
            .map(|(a, b, m)| (at(a, b).0, at(a, b).1, m))
            .collect();
        let [u, v] = roots(&reweighted(&u, &v, l));
        assert!(u.roots.is_empty());
        check(&v, &expected);
    }
    // As many roots as the numerator's degree admits: a cubic with two turns as a polynomial, ..
    let weights = [1.0, 1e-6, 1.0, 1e-6, 1.0, 1e6];
    let values = [0.0, 5.0, -3.0, 4.0, 0.0, 2.0];
    let points: Vec<[f64; 3]> = (0..6)
        .map(|i| [i as f64 * weights[i], values[i] * weights[i], weights[i]])
        .collect();
    let [_, v] = roots(&bezier(&points));
    assert!(v.roots.len() <= 8);
}

#[test]
fn s13_tiny_curve() {
    for size in [1e-15, 1e-300] {
        let [u, v] = roots(&curve(
            &[0.0, -size, -size, 0.0],
            &[0.0, size, 2.0 * size, 3.0 * size],
        ));
        check(&u, &[(1, 2, 1)]);
        assert!(v.roots.is_empty());
    }
    let [u, v] = roots(&curve(&[1.0; 4], &[2.0; 4]));
    assert!(u.roots.is_empty() && v.roots.is_empty());
    assert_eq!((u.constant.len(), v.constant.len()), (1, 1));
}

#[test]
fn spans_directions_and_poly_curves() {
    let c = graph(&[root(1, 4), root(1, 2), root(3, 4)]);
    let whole = brep(plane(1e3), Some(vec![vec![c.clone()]]));
    // A span that starts at a root and ends between two.
    let part = changed(&whole, |p| {
        p.trims[0].span = interval(0.25, 0.625);
        p.trims[0].reversed = true;
    });
    let [_, v] = roots_of(&part);
    assert_eq!(v.roots.len(), 2);
    assert_eq!((v.roots[0].multiplicity, v.roots[0].sign), ([0, 1], [0, 1]));
    assert!(holds(&v.roots[0], 1, 4) && holds(&v.roots[1], 1, 2));
    assert_eq!(v.roots[1].sign, [1, -1]);
    // Twice in a poly-curve over [0, 3] and [3, 4]: roots at 3/4 .. and 3 + 1/4 .., and the joint turns
    // (v falls.. v' = product of odd many factors is < 0 at 0 and > 0 at 1).
    let poly = PolyCurve::new(vec![c.clone(), c.clone()], vec![0.0, 3.0, 4.0]).unwrap();
    let poly = brep(plane(1e3), Some(vec![vec![Curve2::Poly(poly)]]));
    let [u, v] = roots_of(&poly);
    assert!(u.roots.is_empty());
    let expected = [(3, 4), (3, 2), (9, 4), (3, 1), (13, 4), (7, 2), (15, 4)];
    assert_eq!(v.roots.len(), expected.len());
    for (r, (p, q)) in v.roots.iter().zip(expected) {
        assert!(holds(r, p, q) && r.turns());
    }
    assert_eq!(v.roots[3].multiplicity, [0, 0]);
    // A span that cuts the poly-curve where its own parameter is no f64: 3/4 of 1/3 ..
    let cut = changed(&poly, |p| p.trims[0].span = interval(0.7, 2.3));
    assert_eq!(roots_of(&cut)[1].roots.len(), 3);
    let cut = changed(&poly, |p| p.trims[0].span = interval(0.75, 2.25));
    let [_, v] = roots_of(&cut);
    assert_eq!(v.roots.len(), 3);
    assert_eq!(v.roots[0].multiplicity, [0, 1]);
    assert_eq!(v.roots[2].multiplicity, [1, 0]);
}

#[test]
fn what_is_not_there_is_an_error() {
    let b = brep(plane(1.0), Some(vec![vec![line([0.0, 0.0], [1.0, 1.0])]]));
    let o = Oracle::new(&[&b]).unwrap();
    for (face, l, trim) in [(1, 0, 0), (0, 1, 0), (0, 0, 1)] {
        assert!(o.derivative_roots(face, l, trim).is_err());
    }
}

fn arc(x: [f64; 2], y: [f64; 2], angle: [f64; 2], domain: [f64; 2]) -> Curve2 {
    Curve2::Arc(
        Arc::new(Arc {
            center: Point2::new(0.3, -0.7),
            x: x.into(),
            y: y.into(),
            z: Vector2::zeros(),
            radius: 1.5,
            angle: interval(angle[0], angle[1]),
            domain: interval(domain[0], domain[1]),
        })
        .unwrap(),
    )
}

#[test]
fn arcs() {
    use std::f64::consts::PI;
    // A full circle from an axis: u is stationary at the start and half way; 2 pi as f64 is below 2 pi.
    let [u, v] = roots(&arc(
        [1.0, 0.0],
        [0.0, 1.0],
        [0.0, 2.0 * PI],
        [0.0, 2.0 * PI],
    ));
    assert_eq!((u.roots.len(), v.roots.len()), (2, 2));
    assert_eq!(
        (u.roots[0].t.lo.clone(), u.roots[0].multiplicity),
        (Dyadic::ZERO, [0, 1])
    );
    assert_eq!((u.roots[0].sign, u.roots[1].sign), ([0, -1], [-1, 1]));
    assert_eq!((v.roots[0].sign, v.roots[1].sign), ([1, -1], [-1, 1]));
    // pi = 3.141592653589793 + 1.2246467991473532e-16.
    let rest = &u.roots[1].t.lo - &dyadic(PI);
    assert!((rest.approximate() - 1.2246467991473532e-16).abs() < 1e-30);
    assert!(near(&v.roots[0], PI / 2.0, 1e-15) && near(&v.roots[1], 1.5 * PI, 1e-15));
    // The next f64 is beyond 2 pi: the last extremum of u is inside.
    let [u, _] = roots(&arc(
        [1.0, 0.0],
        [0.0, 1.0],
        [0.0, (2.0 * PI).next_up()],
        [0.0, 1.0],
    ));
    assert_eq!(u.roots.len(), 3);
    assert!(u.roots[2].turns() && u.roots[2].t.hi < dyadic(1.0));
    // Clockwise, the frame's x along -u: u = -cos a, v = sin a: rising at first both.
    let [u, v] = roots(&arc([-2.0, 0.0], [0.0, 3.0], [-1.0, 4.0], [0.0, 10.0]));
    assert_eq!((u.roots.len(), v.roots.len()), (2, 1));
    assert_eq!(
        (u.roots[0].sign, u.roots[1].sign, v.roots[0].sign),
        ([-1, 1], [1, -1], [1, -1])
    );
    assert_eq!(
        u.roots[0].t,
        TruthEnclosure {
            lo: dyadic(2.0),
            hi: dyadic(2.0)
        }
    );
    assert!(near(&u.roots[1], 2.0 * (PI + 1.0), 1e-14));
    assert!(near(&v.roots[0], 2.0 * (PI / 2.0 + 1.0), 1e-14));
    // A frame that is not an axis: x = (3, 4) / 5; u' = 0 where tan a = -4/3, v' = 0 where tan a = 3/4.
    let skew = arc([3.0, 4.0], [-4.0, 3.0], [0.0, 6.0], [0.0, 6.0]);
    let [u, v] = roots(&skew);
    let (a, b) = ((-4.0f64 / 3.0).atan(), 0.75f64.atan());
    assert_eq!((u.roots.len(), v.roots.len()), (2, 2));
    assert!(near(&u.roots[0], a + PI, 1e-15) && near(&u.roots[1], a + 2.0 * PI, 2e-15));
    assert!(near(&v.roots[0], b, 1e-15) && near(&v.roots[1], b + PI, 1e-15));
    assert_eq!((u.roots[0].sign, v.roots[0].sign), ([-1, 1], [1, -1]));
    // Its mirror image, y on the other side: v = (4 cos a - 3 sin a) / 5.
    let [_, v] = roots(&arc([3.0, 4.0], [4.0, -3.0], [0.0, 6.0], [0.0, 6.0]));
    assert_eq!(v.roots.len(), 2);
    assert!(near(&v.roots[0], PI - b, 1e-15) && v.roots[0].sign == [-1, 1]);
    // A part of it in a poly-curve, after a segment that rises in u and v; the joint turns u.
    let start = [0.3 + 1.5 * 0.6, -0.7 + 1.5 * 0.8];
    let poly = PolyCurve::new(vec![line([0.0, -2.0], start), skew], vec![0.0, 1.0, 4.0]).unwrap();
    let [u, v] = roots(&Curve2::Poly(poly));
    assert_eq!((u.roots.len(), v.roots.len()), (3, 2));
    assert_eq!(
        (u.roots[0].multiplicity, u.roots[0].sign),
        ([0, 0], [1, -1])
    );
    assert!(near(&u.roots[1], 1.0 + (a + PI) / 2.0, 1e-15));
    // 318 turns.
    let many = roots(&arc([1.0, 0.0], [0.0, 1.0], [0.5, 2000.0], [0.0, 1.0]));
    assert_eq!(many[0].roots.len(), (2000.0 / PI) as usize);
}
