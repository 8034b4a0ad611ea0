//! Native forms against their definitions, and changes of representation that must not change
//! the geometry: knot insertion, splitting, Bezier pieces, conversion to NURBS.
#![allow(clippy::needless_range_loop, reason = "indices name coordinates")]

use crate::common::{abs, curve, q, surface};
use dashu_ratio::RBig as Q;
use feeler::numeric::{Ball, Dd, Interval};
use feeler::nurbs::eval::partials;
use feeler::nurbs::{
    Arc, BezierPiece, Curve, Curve2, Curve3, GeometryError, Limit, Line, NurbsCurve, NurbsCurve3,
    NurbsSurface, Plane, PolyCurve, Polyline, Revolution, Sum, Surface,
};
use nalgebra::{Point2, Point3, Vector2, Vector3, Vector4};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn interval(a: f64, b: f64) -> Interval {
    Interval::new(a, b).unwrap()
}

/// Whether two exact curves agree at an exact parameter within `n` roundings of the largest coordinate.
fn agree(a: &NurbsCurve3, b: &NurbsCurve3, t: f64, n: usize) {
    let size = a
        .control_points()
        .iter()
        .flat_map(|p| (0..3).map(|i| abs(&(q(p[i]) / q(p[3])))))
        .max()
        .unwrap();
    let limit = size * q(n as f64 * f64::EPSILON / 2.0);
    let (x, y) = (
        &crate::common::exact_curve(a, &q(t), 0, false)[0],
        &crate::common::exact_curve(b, &q(t), 0, false)[0],
    );
    for i in 0..3 {
        assert!(abs(&(&x[i] - &y[i])) <= limit, "{t}: {x:?} {y:?}");
    }
}

fn piece(p: &BezierPiece<4>) -> NurbsCurve3 {
    let degree = p.control_points.len() - 1;
    let knots = [
        vec![p.domain.start; degree + 1],
        vec![p.domain.end; degree + 1],
    ]
    .concat();
    NurbsCurve::new(degree, p.control_points.clone(), knots).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn curves_keep_their_shape(c in curve(), s in 0.001f64..0.999, x in 0.0f64..1.0) {
        let (d, p) = (c.domain(), c.degree());
        let (cut, t) = (d.lerp(s), d.lerp(x));
        // Each insertion is one step of gamma_6, of coordinates and of weights.
        let more = c.with_knot(cut, 2).unwrap();
        agree(&c, &more, t, 2 * 6 * 2 + 2);
        let clamped = c.to_clamped().unwrap();
        agree(&c, &clamped, t, 2 * 6 * 2 * p + 2);
        prop_assert_eq!(clamped.to_clamped().unwrap(), clamped.clone());
        let (below, above) = c.split(cut).unwrap();
        prop_assert_eq!(below.control_points().last(), above.control_points().first());
        agree(&c, if t < cut { &below } else { &above }, t, 2 * 6 * 3 * p + 2);
        let pieces = c.bezier_pieces();
        for w in pieces.windows(2) {
            prop_assert_eq!(w[0].control_points.last(), w[1].control_points.first());
            prop_assert_eq!(w[0].domain.end, w[1].domain.start);
        }
        let found = pieces.iter().find(|b| b.domain.contains(t)).unwrap();
        agree(&c, &piece(found), t, 2 * 6 * p + 2);
    }

    #[test]
    fn surfaces_keep_their_shape(s in surface(), x in 0.0f64..1.0, y in 0.0f64..1.0) {
        let [du, dv] = s.domain();
        let (u, v) = (du.lerp(x), dv.lerp(y));
        let size = s.control_net().iter()
            .flat_map(|p| (0..3).map(|i| abs(&(q(p[i]) / q(p[3]))))).max().unwrap();
        let degrees = s.knots_u().degree() + s.knots_v().degree();
        let limit = size * q((2 * 6 * 2 * degrees + 2) as f64 * f64::EPSILON / 2.0);
        let truth = &crate::common::exact_surface(&s, &q(u), &q(v), 0)[0][0];
        let patch = s.bezier_pieces().into_iter()
            .find(|b| b.domain[0].contains(u) && b.domain[1].contains(v)).unwrap();
        let knots = |i: usize| {
            let n = patch.degrees[i] + 1;
            [vec![patch.domain[i].start; n], vec![patch.domain[i].end; n]].concat()
        };
        let patch = NurbsSurface::new(
            patch.degrees, patch.degrees.map(|d| d + 1), patch.control_net.clone(),
            [knots(0), knots(1)]).unwrap();
        for other in [s.to_clamped().unwrap(), patch] {
            let found = &crate::common::exact_surface(&other, &q(u), &q(v), 0)[0][0];
            for c in 0..3 {
                prop_assert!(abs(&(&truth[c] - &found[c])) <= limit);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A segment of a poly-curve is run at another pace: its span is found by the exact parameter, which is no
    /// f64, and values and derivatives hold their bounds there.
    #[test]
    fn mapped_parameters_are_exact(
        c in curve(),
        start in -100.0f64..100.0,
        length in 1e-3f64..50.0,
        x in 0.0f64..1.0,
    ) {
        let (from, to) = (interval(start, start + length), c.domain());
        let rate = (q(to.end) - q(to.start)) / (q(from.end) - q(from.start));
        let inner = Curve::Nurbs(c.clone());
        let poly = PolyCurve::new(vec![inner], vec![from.start, from.end]).unwrap();
        let poly: Curve3 = Curve::Poly(poly);
        // Somewhere, and as close as it gets to each knot on either side.
        let mut all = vec![from.start, from.end, from.lerp(x)];
        for (_, knot, _) in c.knots().spans() {
            let near = from.lerp((knot - to.start) / to.length());
            all.extend([near.next_down(), near, near.next_up()]);
        }
        for t in all.into_iter().filter(|t| from.contains(*t)) {
            let u = q(to.start) + (q(t) - q(from.start)) * &rate;
            for (limit, below) in [(Limit::FromAbove, false), (Limit::FromBelow, true)] {
                let truth = crate::common::exact_curve(&c, &u, 2, below);
                let found = poly.derivatives_in::<Ball<Dd>>(t, 2, limit);
                let mut power = Q::ONE;
                for k in 0..=2 {
                    for i in 0..3 {
                        prop_assert!(crate::common::holds(&found[k][i], &(&truth[k][i] * &power)));
                    }
                    power *= &rate;
                }
            }
        }
    }
}

/// Stress case E10: the pole of a sphere is a point, and evaluated as one.
#[test]
fn poles() {
    let profile = Curve::Arc(
        Arc::new(Arc {
            center: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::z(),
            z: -Vector3::y(),
            radius: 2.5,
            angle: interval(-FRAC_PI_2, FRAC_PI_2),
            domain: interval(0.0, 1.0),
        })
        .unwrap(),
    );
    let sphere = Surface::Revolution(
        Revolution::new(Revolution {
            origin: Point3::origin(),
            axis: Vector3::z(),
            angle: interval(0.0, TAU),
            angle_domain: interval(0.0, 1.0),
            profile,
            transposed: false,
        })
        .unwrap(),
    );
    for u in [0.0, 0.3, 0.9] {
        let pole = sphere.first_derivatives_with_bound(u, 1.0);
        // The angle is the f64 next to pi/2, which is 6.1e-17 below it.
        assert!((pole.point - Point3::new(0., 0., 2.5)).norm() < 1e-15);
        assert!(pole.du.norm() < 1e-15 && pole.bound < 1e-15);
        assert!((pole.dv.norm() - 2.5 * PI).abs() < 1e-14);
    }
}

/// Stress case E12: a periodic curve is an unclamped one with its control points wrapped; it meets
/// itself at the wrap with all derivatives that its knots allow.
#[test]
fn periodic_curves_close() {
    let ring = [[1., 0.], [0., 1.], [-1., 0.], [0., -1.]];
    let points = (0..7)
        .map(|i| Vector3::new(ring[i % 4][0], ring[i % 4][1], 1.0))
        .collect();
    let knots = (0..11).map(f64::from).collect();
    let c = NurbsCurve::new(3, points, knots).unwrap();
    let curve: Curve2 = Curve::Nurbs(c.clone());
    let (a, b) = (
        curve.derivatives(3.0, 2),
        curve.derivatives_in::<f64>(7.0, 2, Limit::FromBelow),
    );
    for k in 0..=2 {
        assert_eq!(a[k], Vector2::from(b[k]));
    }
    let clamped: Curve2 = Curve::Nurbs(c.to_clamped().unwrap());
    assert_eq!(clamped.point(3.0), clamped.point(7.0));
    assert!((clamped.point(4.7) - curve.point(4.7)).norm() < 1e-15);
}

/// Native forms by hand.
#[test]
fn native_points() {
    // Stored axes that are neither unit nor orthogonal: x' = (1, 0, 0), y' = (0, 1, 0).
    let arc = Arc::new(Arc {
        center: Point3::new(1., 2., 3.),
        x: Vector3::new(5., 0., 1.),
        y: Vector3::new(9., 9., 9.),
        z: Vector3::new(0., 0., 4.),
        radius: 2.0,
        angle: interval(0.0, FRAC_PI_2),
        domain: interval(10.0, 20.0),
    })
    .unwrap();
    let c: Curve3 = Curve::Arc(arc);
    let (start, end) = (c.derivatives(10.0, 2), c.point(20.0));
    assert_eq!(start[0], Vector3::new(3., 2., 3.));
    let rate = FRAC_PI_2 / 10.0;
    assert!((start[1] - Vector3::new(0., 2.0 * rate, 0.)).norm() < 1e-15);
    assert!((start[2] - Vector3::new(-2.0 * rate * rate, 0., 0.)).norm() < 1e-15);
    assert!((end - Point3::new(1., 4., 3.)).norm() < 1e-15);

    // In uv, y on the clockwise side.
    let c: Curve2 = Curve::Arc(
        Arc::new(Arc {
            center: Point2::origin(),
            x: Vector2::new(0., 3.),
            y: Vector2::new(1., 0.),
            z: Vector2::zeros(),
            radius: 1.0,
            angle: interval(0.0, PI),
            domain: interval(0.0, 1.0),
        })
        .unwrap(),
    );
    assert!((c.point(0.5) - Point2::new(1., 0.)).norm() < 1e-15);
    assert!((c.point(1.0) - Point2::new(0., -1.)).norm() < 1e-15);

    // A plane with a range that is not its domain.
    let s = Surface::Plane(
        Plane::new(Plane {
            origin: Point3::new(1., 1., 1.),
            x: Vector3::new(2., 0., 0.),
            y: Vector3::new(0., 0., 3.),
            domain: [interval(0., 1.), interval(5., 7.)],
            extents: [interval(-1., 1.), interval(0., 1.)],
        })
        .unwrap(),
    );
    let d = s.derivatives(0.75, 6.0, 2);
    assert_eq!(d.get(0, 0), Vector3::new(2., 1., 2.5));
    assert_eq!(d.get(1, 0), Vector3::new(4., 0., 0.));
    assert_eq!(d.get(0, 1), Vector3::new(0., 0., 1.5));
    assert_eq!(d.get(1, 1) + d.get(2, 0) + d.get(0, 2), Vector3::zeros());

    // Revolutions, either way round: (2, 0, 0)-(2, 0, 5) turned by 90 degrees about z.
    for transposed in [false, true] {
        let s = revolution(
            transposed,
            interval(0.0, PI),
            line([2., 0., 0.], [2., 0., 5.]),
        );
        let at = |a: f64, t: f64, i: usize, j: usize| {
            if transposed {
                s.derivatives(t, a, 2).get(j, i)
            } else {
                s.derivatives(a, t, 2).get(i, j)
            }
        };
        let close =
            |a: Vector3<f64>, b: [f64; 3]| assert!((a - Vector3::from(b)).norm() < 1e-14, "{a}");
        // The angular domain is [0, 2] for angles [0, pi].
        close(at(1.0, 0.5, 0, 0), [0., 2., 2.5]);
        close(at(1.0, 0.5, 1, 0), [-PI, 0., 0.]);
        close(at(1.0, 0.5, 0, 1), [0., 0., 5.]);
        close(at(1.0, 0.5, 1, 1), [0., 0., 0.]);
        close(at(1.0, 0.5, 2, 0), [0., -PI * FRAC_PI_2, 0.]);
    }

    // A poly-curve maps each segment's own domain linearly.
    let poly = PolyCurve::new(
        vec![
            line([0., 0., 0.], [1., 0., 0.]),
            line([1., 0., 0.], [1., 4., 0.]),
        ],
        vec![0.0, 2.0, 3.0],
    )
    .unwrap();
    let c: Curve3 = Curve::Poly(poly);
    assert_eq!(c.point(1.0), Point3::new(0.5, 0., 0.));
    assert_eq!(c.point(2.5), Point3::new(1., 2., 0.));
    assert_eq!(c.derivatives(2.0, 1)[1], Vector3::new(0., 4., 0.));
    assert_eq!(
        c.derivatives_in::<f64>(2.0, 1, Limit::FromBelow)[1],
        [0.5, 0., 0.]
    );
    let s = Surface::Sum(Sum {
        base: Vector3::new(0., 0., 1.),
        first: c,
        second: line([0., 0., 0.], [0., 0., 2.]),
    });
    let d = s.derivatives(2.5, 0.25, 2);
    assert_eq!(d.get(0, 0), Vector3::new(1., 2., 1.5));
    assert_eq!(d.get(1, 0), Vector3::new(0., 4., 0.));
    assert_eq!(d.get(0, 1), Vector3::new(0., 0., 2.));
}

fn line(a: [f64; 3], b: [f64; 3]) -> Curve3 {
    Curve::Line(Line::new(Point3::from(a), Point3::from(b), interval(0.0, 1.0)).unwrap())
}

fn revolution(transposed: bool, angle: Interval, profile: Curve3) -> Surface {
    Surface::Revolution(
        Revolution::new(Revolution {
            origin: Point3::new(0., 0., -7.),
            axis: Vector3::new(0., 0., 0.1),
            angle,
            angle_domain: interval(0.0, 2.0),
            profile,
            transposed,
        })
        .unwrap(),
    )
}

fn tilted_arc(angle: Interval, domain: Interval) -> Curve3 {
    Curve::Arc(
        Arc::new(Arc {
            center: Point3::new(0.1, -3.0, 1e3),
            x: Vector3::new(1., 2., 3.),
            y: Vector3::zeros(),
            z: Vector3::new(-3., 1., 0.7),
            radius: 2.75,
            angle,
            domain,
        })
        .unwrap(),
    )
}

fn rational() -> Curve3 {
    let p = |x: f64, y: f64, z: f64, w: f64| Vector4::new(w * x, w * y, w * z, w);
    Curve::Nurbs(
        NurbsCurve::new(
            3,
            vec![
                p(1., 0., 0., 1.),
                p(2., 1., 1., 0.3),
                p(3., 0., 2., 7.),
                p(2., 2., 3., 1.),
                p(1., 1., 4., 2.),
            ],
            vec![0., 0., 0., 0., 0.4, 1., 1., 1., 1.],
        )
        .unwrap(),
    )
}

fn curves() -> Vec<Curve3> {
    let bent = Curve::Polyline(
        Polyline::new(
            vec![
                Point3::new(1., 1., 4.),
                Point3::new(0., 5., 0.1),
                Point3::new(1., 1., 1.),
            ],
            vec![0.0, 0.1, 3.0],
        )
        .unwrap(),
    );
    let arc = tilted_arc(interval(-1.0, 4.0), interval(2.0, 3.0));
    let link = Curve::Line(
        Line::new(Point3::new(1., 1., 1.), arc.point(2.0), interval(-5.0, 1.0)).unwrap(),
    );
    let poly = PolyCurve::new(
        vec![rational(), bent.clone(), link, arc],
        vec![-1.0, 0.3, 0.9, 2.0, 10.0],
    )
    .unwrap();
    vec![
        line([0.1, 0.2, 0.3], [7., -1e3, 2.]),
        bent,
        tilted_arc(interval(0.0, TAU), interval(0.0, TAU)),
        tilted_arc(interval(-3.0, 0.5), interval(1.0, 2.0)),
        rational(),
        Curve::Poly(poly),
    ]
}

/// Derivatives of every form against difference quotients of points in double-double.
#[test]
fn derivatives_are_the_slopes() {
    let h = 2f64.powi(-20);
    for c in curves() {
        let d = c.domain();
        for s in [0.111, 0.5, 0.77] {
            let t = (d.lerp(s) / h).round() * h;
            let at = |t| c.derivatives_in::<Ball<Dd>>(t, 2, Limit::FromAbove);
            let (below, here, above) = (at(t - h), at(t), at(t + h));
            for k in 0..2 {
                for i in 0..3 {
                    let slope = (above[k][i] - below[k][i]) / Ball::exact(2.0 * h);
                    let error = (slope - here[k + 1][i]).magnitude();
                    // h^2 / 6 times the third derivative of what is differentiated.
                    let third = c.derivatives(t, 5)[k + 3].norm().max(1.0);
                    assert!(
                        error <= h * h * third,
                        "{} {t} {k}: {error:e}",
                        c.type_name()
                    );
                }
            }
        }
    }
}

#[test]
fn mixed_partials_are_the_slopes() {
    let h = 2f64.powi(-20);
    for s in surfaces() {
        let [du, dv] = s.domain();
        let (u, v) = (
            (du.lerp(0.3) / h).round() * h,
            (dv.lerp(0.6) / h).round() * h,
        );
        let at = |u, v| partials::<Ball<Dd>>(&s, [u, v], 4, [Limit::FromAbove; 2]);
        let here = at(u, v);
        let (west, east, south, north) = (at(u - h, v), at(u + h, v), at(u, v - h), at(u, v + h));
        let size = (0..=4)
            .flat_map(|i| (0..=4 - i).map(move |j| (i, j)))
            .flat_map(|(i, j)| here.get(i, j).map(|x| x.magnitude()))
            .fold(1.0, f64::max);
        for i in 0..=1 {
            for j in 0..=1 {
                for c in 0..3 {
                    let two = Ball::exact(2.0 * h);
                    let along_u = (east.get(i, j)[c] - west.get(i, j)[c]) / two;
                    let along_v = (north.get(i, j)[c] - south.get(i, j)[c]) / two;
                    let (eu, ev) = (
                        (along_u - here.get(i + 1, j)[c]).magnitude(),
                        (along_v - here.get(i, j + 1)[c]).magnitude(),
                    );
                    // Third derivatives above order 4 are not looked at: allow 100 times.
                    assert!(
                        eu.max(ev) <= 100.0 * h * h * size,
                        "{} {i} {j}: {eu:e} {ev:e}",
                        s.type_name()
                    );
                }
            }
        }
    }
}

fn surfaces() -> Vec<Surface> {
    let plane = Surface::Plane(
        Plane::new(Plane {
            origin: Point3::new(0.1, 0.2, 0.3),
            x: Vector3::new(0.6, 0.8, 0.),
            y: Vector3::new(-0.8, 0.6, 1e-3),
            domain: [interval(0., 1.), interval(-1., 3.)],
            extents: [interval(-1.7, 1.), interval(-1., 3.)],
        })
        .unwrap(),
    );
    let mut all = vec![plane];
    for profile in curves() {
        for transposed in [false, true] {
            all.push(revolution(transposed, interval(0.3, 6.0), profile.clone()));
        }
        all.push(Surface::Sum(Sum {
            base: Vector3::new(1., 2., 3.),
            first: profile,
            second: rational(),
        }));
    }
    all.push(all[13].to_nurbs().map(|c| Surface::Nurbs(c.nurbs)).unwrap());
    all
}

/// The points of both forms at mapped parameters are within the bound, and what the rounding of the
/// mapped parameter adds.
#[test]
fn curves_as_nurbs() {
    for c in curves() {
        let converted = c.to_nurbs().unwrap();
        let other: Curve3 = Curve::Nurbs(converted.nurbs.clone());
        let d = c.domain();
        assert_eq!(d, other.domain());
        // 2 gamma_68 of a size of 1003, for the poly-curve; the others are far better.
        assert!(converted.bound < 2e-11, "{}", converted.bound);
        for i in 0..=100 {
            let t = d.lerp(f64::from(i) / 100.0);
            let s = converted.map.to_nurbs(t);
            let (a, b) = (c.point(t), other.point(s));
            let slope = other.derivatives(s, 1)[1].norm();
            let limit = converted.bound
                + (1e-15 * a.coords.norm())
                + 16.0 * f64::EPSILON * d.length() * slope;
            assert!(
                (a - b).norm() <= limit,
                "{} {t}: {:e} > {limit:e}",
                c.type_name(),
                (a - b).norm()
            );
            assert!((converted.map.to_native(s) - t).abs() <= 32.0 * f64::EPSILON * d.length());
        }
    }
}

/// An arc as NURBS is a circle, exactly evaluated, up to its bound.
#[test]
fn arcs_as_nurbs_are_round() {
    let angle = interval(-3.0, 3.1);
    let converted = tilted_arc(angle, interval(0.0, 1.0)).to_nurbs().unwrap();
    assert!(converted.bound < 1e-12);
    let center = [q(0.1), q(-3.0), q(1e3)];
    for i in 0..=50 {
        let t = q(f64::from(i)) / q(50.0);
        let p = &crate::common::exact_curve(&converted.nurbs, &t, 0, false)[0];
        let square = (0..3).fold(Q::ZERO, |s, c| {
            let d = &p[c] - &center[c];
            s + &d * &d
        });
        // |x^2 - r^2| <= (2 r + e) e.
        let off = abs(&(square - q(2.75) * q(2.75)));
        assert!(off <= (q(5.5) + q(converted.bound)) * q(converted.bound));
    }
}

#[test]
fn surfaces_as_nurbs() {
    for s in surfaces() {
        let converted = s.to_nurbs().unwrap();
        let other = Surface::Nurbs(converted.nurbs.clone());
        let [du, dv] = s.domain();
        assert_eq!([du, dv], other.domain());
        for i in 0..=16 {
            for j in 0..=16 {
                let (u, v) = (du.lerp(f64::from(i) / 16.0), dv.lerp(f64::from(j) / 16.0));
                let (x, y) = (converted.maps[0].to_nurbs(u), converted.maps[1].to_nurbs(v));
                let (a, d) = (s.point(u, v), other.derivatives(x, y, 1));
                let slope = d.get(1, 0).norm() * du.length() + d.get(0, 1).norm() * dv.length();
                let gap = (a.coords - d.get(0, 0)).norm();
                let limit = converted.bound + 1e-14 * a.coords.norm() + 16.0 * f64::EPSILON * slope;
                assert!(
                    gap <= limit,
                    "{} {u} {v}: {gap:e} > {limit:e}",
                    s.type_name()
                );
            }
        }
    }
}

/// A gap between segments is closed, and its size is in the bound.
#[test]
fn gaps_count_in_the_bound() {
    let poly = PolyCurve::new(
        vec![
            line([0., 0., 0.], [1., 0., 0.]),
            line([1., 0.25, 0.], [2., 0., 0.]),
        ],
        vec![0.0, 1.0, 2.0],
    )
    .unwrap();
    let c: Curve3 = Curve::Poly(poly);
    let converted = c.to_nurbs().unwrap();
    assert!((0.25..0.250_001).contains(&converted.bound));
    let other: Curve3 = Curve::Nurbs(converted.nurbs);
    assert_eq!(other.point(1.0), Point3::new(1., 0.25, 0.));
}

/// A gap in a profile is one in the surface; without any, and near the origin, the bound is that of roundings of small numbers.
#[test]
fn bounds_of_surfaces_hold_those_of_their_curves() {
    let gap = |size: f64, up: f64| {
        let segments = vec![
            line([size, 0., 0.], [size, 0., size]),
            line([size + up, 0., size], [size, 0., 2.0 * size]),
        ];
        Curve::Poly(PolyCurve::new(segments, vec![0.0, 1.0, 2.0]).unwrap())
    };
    let surface = |profile: Curve3| revolution(false, interval(0.0, 3.0), profile);
    let bound = surface(gap(1.0, 0.25)).to_nurbs().unwrap().bound;
    assert!((0.25..0.250_001).contains(&bound), "{bound}");
    // 2 gamma_28 of a size of 2.3e-6, well below a rounding of 1.
    let small: Curve3 = gap(1e-6, 0.0);
    let bound = small.to_nurbs().unwrap().bound;
    assert!(bound > 0.0 && bound < 1e-19, "{bound:e}");
}

/// Plain f64 is close to what is proven. (128 roundings of the largest number in play: the a-priori
/// bound of a degree-9 curve, far above these forms'.)
#[test]
fn plain_points_are_close() {
    let limit = |size: f64| 64.0 * f64::EPSILON * size;
    for c in curves() {
        for i in 0..=40 {
            let t = c.domain().lerp(f64::from(i) / 40.0);
            let (p, bound) = c.point_with_bound(t);
            assert!(bound <= f64::EPSILON * 1e3);
            assert!((c.point(t) - p).amax() <= limit(1e3), "{}", c.type_name());
        }
    }
    for s in surfaces() {
        let [du, dv] = s.domain();
        for i in 0..=10 {
            for j in 0..=10 {
                let (u, v) = (du.lerp(f64::from(i) / 10.0), dv.lerp(f64::from(j) / 10.0));
                let (p, bound) = s.point_with_bound(u, v);
                assert!(bound <= f64::EPSILON * 1e3);
                assert!(
                    (s.point(u, v) - p).amax() <= limit(1e3),
                    "{}",
                    s.type_name()
                );
            }
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let arc = |start: f64, end: f64| {
        Arc::new(Arc {
            center: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::y(),
            z: Vector3::z(),
            radius: 1.0,
            angle: Interval { start, end },
            domain: interval(0.0, 1.0),
        })
    };
    assert!(matches!(arc(0.0, 1e300), Err(GeometryError::Angle { .. })));
    assert!(matches!(
        arc(1.0, 1.0),
        Err(GeometryError::EmptyInterval { .. })
    ));
    assert!(matches!(
        arc(0.0, f64::NAN),
        Err(GeometryError::EmptyInterval { .. })
    ));
    let parallel = Arc::new(Arc {
        center: Point3::origin(),
        x: Vector3::new(0.1, 0.2, 0.3),
        y: Vector3::y(),
        z: Vector3::new(0.1, 0.2, 0.3) * 4.0,
        radius: 1.0,
        angle: interval(0.0, 1.0),
        domain: interval(0.0, 1.0),
    });
    assert!(matches!(parallel, Err(GeometryError::Degenerate { .. })));
    // A million turns have a point but no NURBS form.
    let c: Curve3 = Curve::Arc(arc(0.0, 6e6).unwrap());
    assert!(c.point(0.5).coords.norm() < 1.000_001);
    assert!(matches!(c.to_nurbs(), Err(GeometryError::Angle { .. })));
    let Curve::Nurbs(c) = rational() else {
        unreachable!()
    };
    assert!(matches!(
        c.split(0.0),
        Err(GeometryError::OutsideDomain { .. })
    ));
    assert!(matches!(
        c.with_knot(f64::NAN, 1),
        Err(GeometryError::OutsideDomain { .. })
    ));
    assert!(c.restricted(0.5, 0.5).is_err());
}

/// Both curves of a sum that are no NURBS are off by their own bounds, which add up to that of the sum.
#[test]
fn a_sum_is_as_far_off_as_both_its_curves() {
    let arc = |radius: f64| {
        Curve3::Arc(
            Arc::new(Arc {
                center: Point3::new(0.1, -0.2, 0.3),
                x: Vector3::new(1., 2., 3.),
                y: Vector3::zeros(),
                z: Vector3::new(-3., 1., 0.7),
                radius,
                angle: interval(0.1, 1.3),
                domain: interval(0.0, 1.0),
            })
            .unwrap(),
        )
    };
    let (small, large) = (arc(1.0), arc(1e6));
    let of = |c: &Curve3| c.to_nurbs().unwrap().bound;
    assert!(of(&small) > 0.0 && of(&large) > 1e3 * of(&small));
    for (first, second) in [(&small, &large), (&large, &small), (&large, &large)] {
        let sum = Surface::Sum(Sum {
            base: Vector3::zeros(),
            first: first.clone(),
            second: second.clone(),
        });
        let bound = sum.to_nurbs().unwrap().bound;
        assert!(bound >= of(first) + of(second), "{bound:e}");
    }
}

/// A corner `1 / v + 0` of a sum whose product of weights `v w` is no f64 moves to `w / fl(v w)`: off by `(v w - fl(v w)) / (v fl(v w))`, also
/// where weights are small and so their errors, too.
#[test]
fn bounds_count_the_rounding_of_weights() {
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    for scale in [1.0, 2f64.powi(-20), 2f64.powi(20)] {
        let (v, w) = (scale * (1.0 + 1e-5), 1.0 + 1.0 / 3.0);
        let curve = |x: f64, w: f64| {
            let points = vec![Vector4::new(x, 0., 0., w), Vector4::new(x, 0., 0., w)];
            Curve3::Nurbs(NurbsCurve::new(1, points, knots()).unwrap())
        };
        let sum = Surface::Sum(Sum {
            base: Vector3::zeros(),
            first: curve(1.0, v),
            second: curve(0.0, w),
        });
        let product = v * w;
        let off = v.mul_add(w, -product).abs() / (v * product);
        assert!(off > 0.0);
        let bound = sum.to_nurbs().unwrap().bound;
        assert!(bound >= 0.999 * off, "{scale:e}: {bound:e} {off:e}");
    }
}

/// 64 turns are allowed, and no more.
#[test]
fn arcs_of_many_turns() {
    let turns = 64.0 * TAU;
    let arc = |end: f64| tilted_arc(interval(0.0, end), interval(0.0, 1.0)).to_nurbs();
    assert!(arc(turns).is_ok());
    assert!(matches!(
        arc(turns.next_up()),
        Err(GeometryError::Angle { .. })
    ));
}

/// Twice (coordinates and weights) gamma of 2 (6 p + 4 p + 4) roundings of points at distance 5, for p = 5.
#[test]
fn the_bound_of_a_poly_curve_counts_its_steps() {
    let points = (0..6).map(|i| Vector4::new(3.0, 4.0 - f64::from(i), 0.0, 1.0));
    let knots = [[0.0; 6], [1.0; 6]].concat();
    let curve: Curve3 = Curve::Nurbs(NurbsCurve::new(5, points.collect(), knots).unwrap());
    let poly = PolyCurve::new(vec![curve], vec![0.0, 1.0]).unwrap();
    let bound = Curve::Poly(poly).to_nurbs().unwrap().bound;
    let steps = f64::from(2 * (6 * 5 + 4 * 5 + 4));
    let least = 2.0 * steps * (f64::EPSILON / 2.0) * 5.0;
    assert!(
        (least..=1.001 * least).contains(&bound),
        "{bound:e} {least:e}"
    );
}
