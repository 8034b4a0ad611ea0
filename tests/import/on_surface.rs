//! Curves on surfaces as curves in space: the same points at the same parameters as the surface has at the points of the curve in uv.

use crate::fixture as f;
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, Curve2, Line, NurbsCurve, Polyline, Surface};
use feeler_io::{ObjectKind, read_3dm};
use nalgebra::{Point2, Vector2, Vector3};

fn interval(a: f64, b: f64) -> Interval {
    Interval::new(a, b).expect("an interval")
}

fn only(bytes: &[u8]) -> ObjectKind {
    let mut document = read_3dm(bytes).expect("a file");
    assert_eq!(document.objects.len(), 1);
    document.objects.remove(0).kind
}

/// Writes a surface as the only object, or behind a curve on it.
type Write<'w> = &'w dyn Fn(&mut f::Writer);

fn surface(id: &str, write: Write<'_>) -> Surface {
    match only(&f::file(60, |w| w.record("", id, |w| write(w)))) {
        ObjectKind::Surface(brep) => brep.surface(0).clone(),
        other => panic!("{other:?}"),
    }
}

/// A curve in uv, as the kernel has it and as files do.
fn put(w: &mut f::Writer, curve: &Curve2) {
    let flat = |p: &Point2<f64>| [p.x, p.y, 0.0];
    match curve {
        Curve::Line(l) => w.object(f::LINE, |w| {
            let domain = [l.domain.start, l.domain.end];
            f::line(w, flat(&l.from), flat(&l.to), domain, 2);
        }),
        Curve::Polyline(p) => w.object(f::POLYLINE, |w| {
            let points: Vec<[f64; 3]> = p.points().iter().map(flat).collect();
            f::polyline(w, &points, p.params(), 2);
        }),
        Curve::Arc(a) => w.object(f::ARC, |w| {
            w.u8(0x10);
            w.f64s(&flat(&a.center));
            w.f64s(&[a.x.x, a.x.y, 0.0, a.y.x, a.y.y, 0.0, 0.0, 0.0, 1.0]);
            w.f64s(&[0.0, 0.0, 1.0, 0.0, a.radius]);
            w.f64s(&[0.0; 9]);
            w.f64s(&[a.angle.start, a.angle.end, a.domain.start, a.domain.end]);
            w.i32s(&[2]);
        }),
        Curve::Nurbs(n) => w.object(f::NURBS_CURVE, |w| {
            let points = n.control_points();
            w.u8(0x11);
            w.i32s(&[2, 1, n.degree() as i32 + 1, points.len() as i32, 0, 0]);
            w.f64s(&[0.0; 6]);
            let knots = n.knots().knots();
            w.f64_array(&knots[1..knots.len() - 1]);
            w.i32s(&[points.len() as i32]);
            points.iter().for_each(|p| w.f64s(&[p.x, p.y, p.z]));
            w.u8(0);
        }),
        Curve::Poly(_) => unreachable!("none here"),
    }
}

/// The object that a curve on a surface becomes.
fn on(curve: &Curve2, id: &str, write: Write<'_>) -> ObjectKind {
    only(&f::file(60, |w| {
        w.record("", f::CURVE_ON_SURFACE, |w| {
            put(w, curve);
            w.i32s(&[0]);
            w.object(id, |w| write(w));
        });
    }))
}

fn line(from: [f64; 2], to: [f64; 2]) -> Curve2 {
    let line = Line::new(from.into(), to.into(), interval(1.0, 4.0));
    Curve::Line(line.expect("a line"))
}

fn arc() -> Curve2 {
    let arc = Arc {
        center: Point2::new(0.5, 0.25),
        x: Vector2::new(0.6, 0.8),
        y: Vector2::new(-0.8, 0.6),
        z: Vector2::zeros(),
        radius: 0.125,
        angle: interval(0.5, 3.0),
        domain: interval(0.0, 1.0),
    };
    Curve::Arc(Arc::new(arc).expect("an arc"))
}

#[test]
fn images_are_where_the_surface_has_the_curve() {
    let stretched: Write<'_> = &|w| f::plane(w, [1.0, 5.0, -1.0, 2.0]);
    let plain: Write<'_> = &|w| f::plane(w, [0.0, 1.0, 0.0, 1.0]);
    let spline: Write<'_> = &f::nurbs_surface;
    let points = [[0.0, 0.0], [1.0, 0.5], [0.25, 1.0]].map(Point2::from);
    let polyline = Polyline::new(points.to_vec(), vec![0.0, 2.0, 3.0]).expect("a polyline");
    let net = [[0.0, 0.0, 1.0], [0.25, 0.5, 0.5], [2.0, 1.0, 2.0]].map(Vector3::from);
    let knots = vec![0.0, 0.0, 0.0, 2.0, 2.0, 2.0];
    let conic = NurbsCurve::new(2, net.to_vec(), knots).expect("a spline");
    // The spline surface is over [0, 1] x [2, 5], with knots at 0.5 and at 3.
    for (curve, id, write) in [
        (Curve::Polyline(polyline), f::PLANE, stretched),
        (Curve::Nurbs(conic), f::PLANE, stretched),
        (line([0.25, 0.0], [0.5, 1.0]), f::PLANE, stretched),
        (arc(), f::PLANE, plain),
        (line([0.3, 4.5], [0.3, 2.5]), f::NURBS_SURFACE, spline),
        (line([1.0, 2.0], [1.0, 5.0]), f::NURBS_SURFACE, spline),
        (line([0.125, 3.5], [0.875, 3.5]), f::NURBS_SURFACE, spline),
        (line([1.0, 5.0], [0.0, 5.0]), f::NURBS_SURFACE, spline),
    ] {
        is_image(&curve, id, write);
    }
}

fn is_image(curve: &Curve2, id: &str, write: Write<'_>) {
    let ObjectKind::Curve(image) = on(curve, id, write) else {
        panic!("no curve: {curve:?}");
    };
    let surface = surface(id, write);
    assert_eq!(image.domain(), curve.domain());
    for k in 0..=96 {
        let t = curve.domain().lerp(f64::from(k) / 96.0);
        let uv = curve.point(t);
        let off = (image.point(t) - surface.point(uv.x, uv.y)).amax();
        // Some tens of roundings of coordinates up to 16.
        assert!(
            off <= 64.0 * f64::EPSILON * 16.0,
            "{off:e} at {t}: {curve:?}"
        );
    }
}

/// Lines along u and v, either way, all of a surface's domain or a part of it.
#[test]
fn lines_of_revolutions_and_sums_are_circles_and_curves_of_theirs() {
    let turned: Write<'_> = &|w| f::revolution(w, 0x20, 0);
    let transposed: Write<'_> = &|w| f::revolution(w, 0x20, 1);
    for (id, write) in [(f::REV, turned), (f::REV, transposed), (f::SUM, &f::sum)] {
        let [u, v] = surface(id, write).domain();
        for (a, b) in [
            ([0.0, 0.375], [1.0, 0.375]),
            ([0.875, 0.0], [0.25, 0.0]),
            ([0.75, 0.125], [0.75, 0.625]),
            ([1.0, 1.0], [1.0, 0.0]),
        ] {
            let at = |s: [f64; 2]| [u.lerp(s[0]), v.lerp(s[1])];
            is_image(&line(at(a), at(b)), id, write);
        }
    }
}

/// Over knots of u and v, at one of them, through a place where both are, with either slope; polygons whose sides are of either kind.
#[test]
fn lines_across_a_spline_surface_are_diagonals_of_its_rectangles() {
    let spline: Write<'_> = &f::nurbs_surface;
    for (a, b) in [
        ([0.0, 2.0], [1.0, 5.0]),
        ([0.125, 4.75], [0.8125, 2.25]),
        ([0.5, 2.5], [0.75, 3.0]),
        ([0.9, 2.1], [0.1, 2.9]),
        ([0.25, 2.5], [0.75, 3.5]),
        ([0.3, 2.7], [0.7000000000000001, 3.3]),
    ] {
        is_image(&line(a, b), f::NURBS_SURFACE, spline);
    }
    let points = [[0.0, 2.0], [0.0, 4.0], [0.7, 4.5], [0.9, 2.2]].map(Point2::from);
    let polyline = Polyline::new(points.to_vec(), vec![-1.0, 0.0, 2.0, 2.5]).expect("a polyline");
    is_image(&Curve::Polyline(polyline), f::NURBS_SURFACE, spline);
}

/// What many lines across a large net would take is not there: it is refused, at once.
#[test]
fn very_many_lines_across_a_net_are_refused() {
    const SIDE: usize = 24;
    const LINES: usize = 2000;
    let net: Write<'_> = &|w| {
        w.u8(0x10);
        w.i32s(&[3, 0, 2, 2, SIDE as i32, SIDE as i32, 0, 0]);
        w.f64s(&[0.0; 6]);
        let knots: Vec<f64> = (0..SIDE).map(|k| k as f64).collect();
        w.f64_array(&knots);
        w.f64_array(&knots);
        w.i32s(&[(SIDE * SIDE) as i32]);
        for i in 0..SIDE * SIDE {
            w.f64s(&[(i / SIDE) as f64, (i % SIDE) as f64, 0.0]);
        }
    };
    let far = SIDE as f64 - 1.0;
    is_image(&line([0.0, 0.25], [far, far]), f::NURBS_SURFACE, net);
    let points =
        (0..=LINES).map(|k| Point2::new(k as f64 % 2.0 * far, k as f64 / LINES as f64 * far));
    let params = (0..=LINES).map(|k| k as f64).collect();
    let polyline = Polyline::new(points.collect(), params).expect("a polyline");
    let refused = on(&Curve::Polyline(polyline), f::NURBS_SURFACE, net);
    assert!(matches!(refused, ObjectKind::Refused { .. }));
}

#[test]
fn what_has_no_form_is_refused_by_name() {
    let stretched: Write<'_> = &|w| f::plane(w, [0.0, 5.0, 0.0, 2.0]);
    let spline: Write<'_> = &f::nurbs_surface;
    let revolution: Write<'_> = &|w| f::revolution(w, 0x20, 0);
    for (curve, id, write) in [
        (arc(), f::PLANE, stretched),
        (arc(), f::NURBS_SURFACE, spline),
        // Out of the domain, where points count as the nearest inside.
        (line([0.0, 2.0], [1.5, 3.0]), f::NURBS_SURFACE, spline),
        (line([0.0, 0.0], [1.0, 1.0]), f::REV, revolution),
    ] {
        let ObjectKind::Refused { class, reason } = on(&curve, id, write) else {
            panic!("not refused: {curve:?}");
        };
        assert_eq!(class, "CurveOnSurface");
        let text = reason.to_string();
        assert!(
            text.contains("CurveOnSurface cannot be used as a curve; convert it to a NURBS curve"),
            "{text}"
        );
    }
}
