//! Derivatives against closed forms, at parameters where f64 makes no rounding.

use super::{Limit, Scalar, partials};
use crate::numeric::{Ball, Dd, Interval};
use crate::nurbs::{Curve, Curve3, NurbsCurve, NurbsSurface, PolyCurve, Revolution, Surface};
use nalgebra::{Point3, Vector3, Vector4};

fn of<S: Scalar>(
    s: &Surface,
    uv: [f64; 2],
    order: usize,
    limit: Limit,
) -> super::Partials<[f64; 3]> {
    partials::<S>(s, uv, order, [limit; 2]).map(|x| x.map(|c| c.value()))
}

/// `(u, v, 1) / ((1 + u) (1 + v))` over `[0, 2]^2`: bilinear, with weights `(1 + u) (1 + v)`.
fn quotient() -> Surface {
    let corner = |u: f64, v: f64| Vector4::new(u, v, 1.0, (1.0 + u) * (1.0 + v));
    let net = vec![
        corner(0.0, 0.0),
        corner(0.0, 2.0),
        corner(2.0, 0.0),
        corner(2.0, 2.0),
    ];
    let knots = || vec![0.0, 0.0, 2.0, 2.0];
    NurbsSurface::new([1, 1], [2, 2], net, [knots(), knots()])
        .map(Surface::Nurbs)
        .unwrap()
}

/// d^k/du^k of u / (1 + u) at 1 is 1/2, 1/4, -1/4, 3/8; of 1 / (1 + u): 1/2, -1/4, 1/4, -3/8.
#[test]
fn all_orders_of_a_quotient_that_varies_both_ways() {
    const OVER: [f64; 4] = [0.5, 0.25, -0.25, 0.375];
    const UNDER: [f64; 4] = [0.5, -0.25, 0.25, -0.375];
    let s = quotient();
    let plain = of::<f64>(&s, [1.0, 1.0], 3, Limit::FromAbove);
    let fine = of::<Ball<Dd>>(&s, [1.0, 1.0], 3, Limit::FromAbove);
    for i in 0..=3 {
        for j in 0..=3 - i {
            let truth = [OVER[i] * UNDER[j], UNDER[i] * OVER[j], UNDER[i] * UNDER[j]];
            assert_eq!(plain.get(i, j), truth, "({i}, {j})");
            assert_eq!(fine.get(i, j), truth, "({i}, {j})");
        }
    }
}

/// A roof: from above its ridge it falls, from below it rises.
#[test]
fn a_ridge_has_a_slope_from_either_side() {
    let heights = [0.0, 1.0, -2.0];
    let net = heights
        .iter()
        .zip([0.0, 1.0, 2.0])
        .flat_map(|(z, u)| [0.0, 1.0].map(|v| Vector4::new(u, v, *z, 1.0)));
    let knots = [vec![0.0, 0.0, 1.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 1.0]];
    let roof = NurbsSurface::new([1, 1], [3, 2], net.collect(), knots);
    let roof = Surface::Nurbs(roof.unwrap());
    for (limit, slope) in [(Limit::FromAbove, -3.0), (Limit::FromBelow, 1.0)] {
        let at = of::<f64>(&roof, [1.0, 0.5], 1, limit);
        assert_eq!(at.get(1, 0), [1.0, 0.0, slope], "{limit:?}");
        assert_eq!(of::<Ball<Dd>>(&roof, [1.0, 0.5], 1, limit), at);
    }
}

/// `(3 cos u, 3 sin u, 2 v)` at angle 0: (3, 0), then (0, 3), (-3, 0), (0, -3).
#[test]
fn a_cylinder_turns_counter_clockwise() {
    let line = NurbsCurve::new(
        1,
        vec![
            Vector4::new(3.0, 0.0, 0.0, 1.0),
            Vector4::new(3.0, 0.0, 2.0, 1.0),
        ],
        vec![0.0, 0.0, 1.0, 1.0],
    );
    let range = Interval {
        start: 0.0,
        end: 1.0,
    };
    let cylinder = Surface::Revolution(Revolution {
        origin: Point3::origin(),
        axis: Vector3::z(),
        angle: range,
        angle_domain: range,
        profile: Curve::Nurbs(line.unwrap()),
        transposed: false,
    });
    let at = of::<f64>(&cylinder, [0.0, 0.5], 3, Limit::FromAbove);
    assert_eq!(at.get(0, 0), [3.0, 0.0, 1.0]);
    assert_eq!(at.get(1, 0), [0.0, 3.0, 0.0]);
    assert_eq!(at.get(2, 0), [-3.0, 0.0, 0.0]);
    assert_eq!(at.get(3, 0), [0.0, -3.0, 0.0]);
    assert_eq!(at.get(0, 1), [0.0, 0.0, 2.0]);
    assert_eq!(at.get(1, 1), [0.0; 3]);
}

/// A parameter that comes to lie exactly on a knot, through a map whose rate is no f64, is on the knot: it has the slope of
/// the span above, or below.
#[test]
fn mapped_parameters_on_knots() {
    let p = |x: f64, y: f64| Vector4::new(x, y, 0., 1.);
    let points = vec![p(0., 0.), p(1., 5.), p(4., 2.)];
    let bent = NurbsCurve::new(1, points, vec![0., 0., 1., 4., 4.]).unwrap();
    // [0, 3] to [0, 4], as a third is; and another, whose start is not 0.
    for (start, end) in [(0.0, 3.0), (5.0, 29.0)] {
        let inner = vec![Curve::Nurbs(bent.clone())];
        let c: Curve3 = Curve::Poly(PolyCurve::new(inner, vec![start, end]).unwrap());
        let t = start + 0.25 * (end - start);
        let slope = |limit| c.derivatives_in::<f64>(t, 1, limit)[1][1] * (end - start) / 4.0;
        assert!((slope(Limit::FromAbove) + 1.0).abs() < 1e-14);
        assert!((slope(Limit::FromBelow) - 5.0).abs() < 1e-14);
    }
}

/// Numbers in [0, 1), the same ones everywhere.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Points and first derivatives by the short way are those of the long one, to the last bit: at knots, at ends and beyond them, with weights and without.
#[test]
fn points_have_the_bits_of_derivatives() {
    let mut random = numbers();
    let mut compared = 0;
    for degree in 1..=10 {
        for weights in 0..3 {
            let mut inner: Vec<f64> = (0..6).map(|_| random()).collect();
            inner.sort_by(f64::total_cmp);
            if degree > 1 {
                inner[3] = inner[2];
            }
            let clamped = weights > 0;
            let mut knots = Vec::new();
            if clamped {
                knots.extend(vec![0.0; degree + 1]);
                knots.extend(&inner);
                knots.extend(vec![1.0; degree + 1]);
            } else {
                knots.extend((0..=degree).map(|k| k as f64 - degree as f64));
                knots.extend(&inner);
                knots.extend((0..=degree).map(|k| 1.0 + k as f64));
            }
            let count = knots.len() - degree - 1;
            let points = (0..count).map(|_| {
                let w = [1.0, 0.5, 0.25 + random()][weights];
                Vector4::new(random() * w, (random() - 0.5) * w, -3.0 * random() * w, w)
            });
            let nurbs = NurbsCurve::new(degree, points.collect(), knots.clone()).unwrap();
            let curve: Curve3 = Curve::Nurbs(nurbs);
            let at = (0..50).map(|_| random()).chain(knots).chain([f64::NAN]);
            for t in at {
                let orders = [0, 1, 3, degree + 1].map(|order| {
                    let long = curve.derivatives_in::<f64>(t, order, Limit::FromAbove);
                    let long: Vec<_> = { long.into_iter() }
                        .map(|x| Vector3::from(x).map(f64::to_bits))
                        .collect();
                    let short = curve.derivatives(t, order);
                    let bits: Vec<_> = short.iter().map(|x| x.map(f64::to_bits)).collect();
                    assert_eq!(bits, long, "degree {degree}, order {order} at {t}");
                    long
                });
                let [long, ..] = orders;
                let point = curve.point(t).coords.map(f64::to_bits);
                assert_eq!(point, long[0], "degree {degree} at {t}");
                compared += 1;
            }
        }
    }
    assert!(compared > 1500, "{compared}");
}

/// The same of surfaces, of all pairs of degrees.
#[test]
fn points_of_surfaces_have_the_bits_of_derivatives() {
    let mut random = numbers();
    for degrees in (1..=9).flat_map(|p| (1..=9).map(move |q| [p, q])) {
        for weights in 0..3 {
            let knots = degrees.map(|p| {
                let mut knots = vec![0.0; p + 1];
                knots.extend([0.25, 0.5, 0.5]);
                knots.extend(vec![1.0; p + 1]);
                if p == 1 {
                    knots.remove(3);
                }
                knots
            });
            let counts = [0, 1].map(|c| knots[c].len() - degrees[c] - 1);
            let net = (0..counts[0] * counts[1]).map(|_| {
                let w = [1.0, 0.5, 0.25 + random()][weights];
                Vector4::new(random() * w, (random() - 0.5) * w, -3.0 * random() * w, w)
            });
            let nurbs = NurbsSurface::new(degrees, counts, net.collect(), knots).unwrap();
            let surface = Surface::Nurbs(nurbs);
            let places = [0.0, 0.25, 0.5, 1.0, -1.0, 2.0, f64::NAN];
            for k in 0..20 {
                let uv = [random(), places.get(k).copied().unwrap_or(random())];
                let uv = if k % 2 == 0 { uv } else { [uv[1], uv[0]] };
                let long = of::<f64>(&surface, uv, 1, Limit::FromAbove);
                let long = long.map(|x| Vector3::from(x).map(f64::to_bits));
                let short = surface.derivatives(uv[0], uv[1], 1);
                assert_eq!(
                    short.map(|x| x.map(f64::to_bits)),
                    long,
                    "{degrees:?} {uv:?}"
                );
                let point = surface.point(uv[0], uv[1]).coords.map(f64::to_bits);
                assert_eq!(point, long.get(0, 0), "{degrees:?} {uv:?}");
            }
        }
    }
}

/// At the end, and at the start from below, the interval next to it that is not empty.
#[test]
fn empty_intervals_at_the_ends_are_passed_over() {
    let domain = Interval::new(0.0, 2.0).unwrap();
    let find = |t: f64, limit, breaks: &[f64]| {
        super::parameter::Parameter::new(t, domain, limit).find(breaks)
    };
    assert_eq!(find(2.0, Limit::FromAbove, &[0.0, 1.0, 2.0, 2.0]), 1);
    assert_eq!(find(0.0, Limit::FromBelow, &[0.0, 0.0, 1.0, 2.0]), 1);
    assert_eq!(find(1.0, Limit::FromAbove, &[0.0, 1.0, 1.0, 2.0]), 2);
    assert_eq!(find(1.0, Limit::FromBelow, &[0.0, 1.0, 1.0, 2.0]), 0);
}
