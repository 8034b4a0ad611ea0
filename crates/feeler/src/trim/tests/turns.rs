//! Roots of u' and v' against polynomials whose roots are known.

use super::shapes::*;
use crate::numeric::polynomial::{Parameter, Polynomial};
use crate::numeric::roots::Roots;
use crate::nurbs::Curve2;
use crate::trim::{AxisRoots, derivative_roots};
use dashu_int::IBig;

/// `(1 - t) a + t b` as a polynomial: its root is at a / (a - b).
fn linear(a: i64, b: i64) -> Polynomial {
    Polynomial::new(vec![a.into(), b.into()])
}

fn product(factors: impl IntoIterator<Item = Polynomial>) -> Polynomial {
    factors
        .into_iter()
        .reduce(|a, b| a.times(&b))
        .expect("a factor")
}

/// `(t - k/n)` times n.
fn root_at(k: i64, n: i64) -> Polynomial {
    linear(-k, n - k)
}

fn check(roots: &Roots, expected: &[(i64, i64, usize)]) {
    let found = roots.as_slice();
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (r, (k, n, multiplicity)) in found.iter().zip(expected) {
        assert_eq!(r.multiplicity, *multiplicity, "{k}/{n}");
        // lo <= k/n <= hi, strictly unless exact.
        let (lo, hi) = (
            root_at(*k, *n).sign_at(&r.lo),
            root_at(*k, *n).sign_at(&r.hi),
        );
        if r.is_exact() {
            assert_eq!(lo, 0, "{k}/{n}");
        } else {
            assert_eq!((lo, hi), (-1, 1), "{k}/{n}");
        }
    }
    // Isolating: in order, and apart.
    for w in found.windows(2) {
        assert!(w[0].hi <= w[1].lo && (w[0].hi < w[1].lo || !w[0].is_exact()));
    }
}

#[test]
fn wilkinson() {
    for degree in [20, 25, 48] {
        let f = product((1..=degree).map(|k| root_at(k, degree + 1)));
        let expected: Vec<_> = (1..=degree).map(|k| (k, degree + 1, 1)).collect();
        let mut roots = Roots::isolate(&f).unwrap();
        check(&roots, &expected);
        for i in 0..degree as usize {
            for _ in 0..60 {
                roots.refine(i);
            }
            let r = &roots.as_slice()[i];
            let width = &r.hi.to_dyadic() - &r.lo.to_dyadic();
            assert!(width <= crate::numeric::Dyadic::new(IBig::ONE, -60));
        }
        check(&roots, &expected);
    }
}

#[test]
fn clusters_and_multiplicities() {
    // 24 roots within 2.4e-9, some of them at dyadics.
    let n = 1 << 33;
    let f = product((0..24).map(|k| root_at(n / 2 - 7 + k, n)));
    let expected: Vec<_> = (0..24).map(|k| (n / 2 - 7 + k, n, 1)).collect();
    check(&Roots::isolate(&f).unwrap(), &expected);
    // (3t - 1)² (2t - 1)³ (5t - 3) t² (1 - t)⁴ and a pair of complex roots.
    let f = product([
        root_at(1, 3),
        root_at(1, 3),
        root_at(1, 2),
        root_at(1, 2),
        root_at(1, 2),
        root_at(3, 5),
        linear(0, 1),
        linear(0, 1),
        Polynomial::new(vec![1.into(), (-1).into(), 1.into()]),
        linear(1, 0),
        linear(1, 0),
        linear(1, 0),
        linear(1, 0),
    ]);
    let expected = [(0, 1, 2), (1, 3, 2), (1, 2, 3), (3, 5, 1), (1, 1, 4)];
    check(&Roots::isolate(&f).unwrap(), &expected);
    assert!(Roots::isolate(&Polynomial::new(vec![IBig::ZERO; 4])).is_none());
    assert!(Roots::isolate(&linear(2, 1)).unwrap().as_slice().is_empty());
    // Roots next to a root at a dyadic: intervals that touch it are moved off.
    let f = product([
        root_at(1, 2),
        root_at(501, 1000),
        root_at(499, 1000),
        root_at(1, 4),
    ]);
    let expected = [(1, 4, 1), (499, 1000, 1), (1, 2, 1), (501, 1000, 1)];
    check(&Roots::isolate(&f).unwrap(), &expected);
}

/// A cubic with `x = t` (times 3) and `y' = 3 b(t)` for a quadratic in Bernstein form.
fn integral(b: [f64; 3]) -> Curve2 {
    let y = [0.0, b[0], b[0] + b[1], b[0] + b[1] + b[2]];
    let points: Vec<[f64; 3]> = (0..4).map(|i| [i as f64, y[i], 1.0]).collect();
    bezier(&points)
}

fn turns(curve: &Curve2) -> (usize, usize) {
    derivative_roots(curve)
        .iter()
        .fold((0, 0), |(u, v), p| (u + p.u.turns(), v + p.v.turns()))
}

#[test]
fn nearly_double_roots() {
    // (t - 3/8)² - e: every sum here is exact.
    let e = f64::EPSILON / 2.0;
    let at = |e: f64| integral([9.0 / 64.0 + e, -15.0 / 64.0 + e, 25.0 / 64.0 + e]);
    assert_eq!(turns(&at(-e)), (0, 2));
    assert_eq!(turns(&at(0.0)), (0, 0));
    assert_eq!(turns(&at(e)), (0, 0));
    let roots = derivative_roots(&at(0.0));
    let AxisRoots::At(v) = &roots[0].v else {
        panic!()
    };
    assert_eq!(v.as_slice().len(), 1);
    assert_eq!(v.as_slice()[0].multiplicity, 2);
}

#[test]
fn chebyshev_of_degree_25() {
    // T_25(2t - 1) has Bernstein coefficients (-1)^(25-i) C(50, 2i) / C(25, i) (rounded: its 24 extrema have
    // amplitude 1, far above the rounding).
    let n = 25usize;
    let binomial =
        |n: usize, k: usize| (0..k).fold(1.0f64, |b, i| b * (n - i) as f64 / (i + 1) as f64);
    let points: Vec<[f64; 3]> = (0..=n)
        .map(|i| {
            let b = binomial(2 * n, 2 * i) / binomial(n, i)
                * if (n - i).is_multiple_of(2) { 1.0 } else { -1.0 };
            [b, -b, 1.0]
        })
        .collect();
    let curve = bezier(&points);
    assert_eq!(turns(&curve), (24, 24));
    let roots = derivative_roots(&curve);
    let AxisRoots::At(mut u) = roots[0].u.clone() else {
        panic!()
    };
    for k in (0..24).cycle().take(24 * 30) {
        u.refine(k);
    }
    for (k, r) in u.as_slice().iter().enumerate() {
        // cos(k pi / 25), k = 24 .. 1, moved to [0, 1]; rounding of the coefficients allowed for.
        let x = 0.5 + 0.5 * ((24 - k) as f64 * std::f64::consts::PI / 25.0).cos();
        assert!(
            (r.lo.approximate() - x).abs() < 1e-6,
            "{k}: {} {x}",
            r.lo.approximate()
        );
    }
}

#[test]
fn rational_constant_and_knots() {
    // A quarter circle turns at its ends only.
    for u in circle([0.25, 0.0], 2.0) {
        assert_eq!(turns(&u.curve), (0, 0));
    }
    // A rational quintic with weights 1e±6. One turn is its summit. Near t = 1, with s = 1 - t, it is
    // y = (4e7 s² - 15e-6 s) / (1 + ..): a dip of 1.4e-18 at s = 1.875e-13, which sampling in f64
    // cannot see.
    let w = [1.0, 1e6, 1e-6, 1e6, 1e-6, 1.0];
    let y = [0.0, 4.0, -3.0, 4.0, -3.0, 0.0];
    let points: Vec<[f64; 3]> = (0..6)
        .map(|i| [i as f64 * w[i], y[i] * w[i], w[i]])
        .collect();
    let roots = derivative_roots(&bezier(&points));
    assert_eq!(roots[0].v.turns(), 2);
    let AxisRoots::At(mut v) = roots[0].v.clone() else {
        panic!()
    };
    for _ in 0..60 {
        v.refine(1);
    }
    let s = &Parameter::one().to_dyadic() - &v.as_slice()[1].lo.to_dyadic();
    assert!(
        (s.approximate() - 1.875e-13).abs() < 1e-18,
        "{}",
        s.approximate()
    );
    // Constant, almost constant, and a turn exactly at a knot.
    let flat = bezier(&[[0.0, 0.1, 1.0], [0.5, 0.2, 2.0], [2.0, 0.1, 1.0]]);
    assert!(matches!(derivative_roots(&flat)[0].v, AxisRoots::Constant));
    let almost = bezier(&[
        [0.0, 0.1, 1.0],
        [1.0, 0.1f64.next_up(), 1.0],
        [2.0, 0.1, 1.0],
    ]);
    assert_eq!(turns(&almost), (0, 1));
    let at_knot = nurbs(
        2,
        &[
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
            [3.0, 1.0, 1.0],
            [4.0, 0.0, 1.0],
        ],
        &[0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0],
    );
    let roots = derivative_roots(&at_knot);
    assert_eq!(roots.len(), 2);
    let AxisRoots::At(first) = &roots[0].v else {
        panic!()
    };
    let AxisRoots::At(second) = &roots[1].v else {
        panic!()
    };
    assert_eq!(first.as_slice()[0].lo, Parameter::one());
    assert_eq!(second.as_slice()[0].lo, Parameter::zero());
    assert_eq!(turns(&at_knot), (0, 0));
}
