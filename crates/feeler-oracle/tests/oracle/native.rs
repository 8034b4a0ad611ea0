//! Evaluation of native surfaces: closed forms, differences, one-sided limits, their NURBS siblings.

use crate::scene;
use crate::scene::{Random, brep, exact, interval, rational};
use dashu_int::IBig;
use dashu_ratio::RBig;
use feeler::brep::Brep;
use feeler::nurbs::{
    Arc, Curve3, Limit, Line, NurbsCurve, PolyCurve, Polyline, Revolution, Sum, Surface,
};
use feeler_oracle::{Evaluation, Oracle, TruthEnclosure};
use nalgebra::{Point3, Vector3, Vector4};

/// Models of the thesis in their native form that have a sibling of NURBS.
const NATIVE: [&str; 6] = [
    "ball",
    "ball_joint_cavity",
    "cylinder",
    "cube_corner_sphere_cut",
    "geneva4_driver",
    "shift_gate_straight",
];

fn power_of_two(bits: usize) -> RBig {
    RBig::from_parts(IBig::ONE, (IBig::ONE << bits).try_into().unwrap())
}

fn magnitude(x: &RBig) -> RBig {
    if *x < RBig::ZERO { -x } else { x.clone() }
}

/// The middle of each enclosure; none is wider than 2^-160 of `size`.
fn middle(x: &[TruthEnclosure; 3], size: &RBig) -> [RBig; 3] {
    std::array::from_fn(|k| {
        let (lo, hi) = (rational(&x[k].lo), rational(&x[k].hi));
        assert!(
            &hi - &lo <= size * power_of_two(160),
            "too wide: {:?}",
            x[k]
        );
        (lo + hi) / RBig::from(IBig::from(2))
    })
}

fn dot(a: &[RBig; 3], b: &[RBig; 3]) -> RBig {
    (0..3).fold(RBig::ZERO, |s, k| s + &a[k] * &b[k])
}

fn minus(a: &[RBig; 3], b: &[RBig; 3]) -> [RBig; 3] {
    std::array::from_fn(|k| &a[k] - &b[k])
}

fn small(x: &RBig, bits: usize) {
    assert!(magnitude(x) <= power_of_two(bits), "{}", x.to_f64().value());
}

fn oracle(s: &Surface) -> Oracle {
    Oracle::new(&[&brep(s.clone(), None)]).unwrap()
}

fn arc3(center: [f64; 3], x: [f64; 3], z: [f64; 3], radius: f64, angle: [f64; 2]) -> Arc<3> {
    let (x, z) = (Vector3::from(x), Vector3::from(z));
    Arc::new(Arc {
        center: Point3::from(center),
        x,
        y: z.cross(&x),
        z,
        radius,
        angle: interval(angle[0], angle[1]),
        domain: interval(-1.0, 1.5),
    })
    .unwrap()
}

fn revolution(profile: Curve3, axis: [f64; 3], angle: [f64; 2], transposed: bool) -> Surface {
    Surface::Revolution(
        Revolution::new(Revolution {
            origin: Point3::new(0.5, -0.25, 2.0),
            axis: Vector3::from(axis),
            angle: interval(angle[0], angle[1]),
            angle_domain: interval(0.0, 3.0),
            profile,
            transposed,
        })
        .unwrap(),
    )
}

fn segment(a: [f64; 3], b: [f64; 3]) -> Curve3 {
    Curve3::Line(Line::new(Point3::from(a), Point3::from(b), interval(2.0, 5.0)).unwrap())
}

fn spline() -> Curve3 {
    let points = [
        [2.5, 0.0, 1.0, 1.0],
        [4.0, 1.0, 3.0, 2.0],
        [3.0, 0.5, 5.0, 1.5],
        [6.0, -1.0, 8.0, 1.0],
        [3.0, 0.0, 9.0, 1.0],
    ]
    .map(Vector4::from);
    let knots = vec![0.0, 0.0, 0.0, 0.3, 0.7, 1.0, 1.0, 1.0];
    Curve3::Nurbs(NurbsCurve::new(2, points.to_vec(), knots).unwrap())
}

/// Some of each kind, with parameters in the inside of smooth pieces.
fn surfaces() -> Vec<(Surface, [f64; 2])> {
    let circle = arc3(
        [3.0, 0.5, 1.0],
        [1.0, 0.1, 0.3],
        [0.2, -1.0, 0.1],
        1.25,
        [0.3, 2.9],
    );
    let poly = Curve3::Poly(
        PolyCurve::new(
            vec![
                segment([1.0, 0.0, 0.0], [2.0, 0.0, 1.0]),
                Curve3::Arc(circle.clone()),
                spline(),
            ],
            vec![0.0, 2.0, 2.5, 4.0],
        )
        .unwrap(),
    );
    let sum = |first: Curve3, second: Curve3| {
        Surface::Sum(Sum {
            base: Vector3::new(0.5, 0.1, -2.0),
            first,
            second,
        })
    };
    vec![
        (
            revolution(
                segment([2.0, 1.0, 0.0], [3.0, 1.0, 4.0]),
                [0.1, 0.2, 1.0],
                [0.0, 6.0],
                false,
            ),
            [1.3, 3.1],
        ),
        (
            revolution(
                Curve3::Arc(circle.clone()),
                [0.0, 0.0, 2.0],
                [-1.0, 4.5],
                true,
            ),
            [0.3, 0.2],
        ),
        (
            revolution(spline(), [3.0, -1.0, 1.0], [-2.0, 1e6], false),
            [0.125, 0.5],
        ),
        (
            revolution(poly.clone(), [0.0, 1.0, 1.0], [0.5, 1.0], false),
            [1.0, 2.2],
        ),
        (
            sum(spline(), segment([0.0; 3], [0.1, 2.0, 0.3])),
            [0.45, 3.0],
        ),
        (sum(Curve3::Arc(circle), poly), [0.75, 3.125]),
    ]
}

#[test]
fn native_models_are_accepted() {
    for name in NATIVE {
        let Some(breps) = scene::model(&format!("thesis/3dm/{name}.3dm")) else {
            continue;
        };
        let all: Vec<&Brep> = breps.iter().collect();
        let oracle = Oracle::new(&all).unwrap();
        let faces: usize = breps.iter().map(|b| b.faces().len()).sum();
        assert_eq!(oracle.faces(), faces);
    }
}

#[test]
fn quadrics_fulfil_their_equations() {
    let mut g = Random(43);
    let axis = [0.3, -0.4, 1.2];
    let exact3 = |v: [f64; 3]| v.map(exact);
    let origin = exact3([0.5, -0.25, 2.0]);
    let a = exact3(axis);
    let a2 = dot(&a, &a);
    let big = exact(100.0);
    // Sphere: centre on the axis (exactly: the origin), profile in a plane through it.
    let sphere = revolution(
        Curve3::Arc(arc3(
            [0.5, -0.25, 2.0],
            [0.3, 0.1, 0.9],
            [1.0, 0.5, 0.0],
            2.5,
            [-1.0, 1.5],
        )),
        axis,
        [0.0, 6.25],
        false,
    );
    let o = oracle(&sphere);
    for _ in 0..40 {
        let e = o
            .evaluate(0, [g.range(0.0, 3.0), g.range(-1.0, 1.5)])
            .unwrap();
        let p = minus(&middle(&e.point, &big), &origin);
        let (du, dv) = (middle(&e.du, &big), middle(&e.dv, &big));
        small(&(dot(&p, &p) - exact(6.25)), 150);
        // Tangent: (P - O).S_u = 0; twice differentiated: (P - O).S_uv = -S_u.S_v.
        small(&dot(&p, &du), 150);
        small(&dot(&p, &dv), 150);
        let second: Vec<[RBig; 3]> = e.second.iter().map(|x| middle(x, &big)).collect();
        small(&(dot(&p, &second[0]) + dot(&du, &du)), 145);
        small(&(dot(&p, &second[1]) + dot(&du, &dv)), 145);
        small(&(dot(&p, &second[2]) + dot(&dv, &dv)), 145);
    }
    // Cylinder and cone: a line in a plane through the axis. With m along the axis and the line from
    // O + f to O + f + k m + s f, (A.f = 0): the squared distance from the axis is linear in the
    // height squared, (1 + s t)^2 f^2.
    for s in [0.0, 0.5] {
        let f = [4.0, 3.0, 0.0];
        let from: [f64; 3] = std::array::from_fn(|k| [0.5, -0.25, 2.0][k] + f[k]);
        let to: [f64; 3] = std::array::from_fn(|k| from[k] + [0.0, 0.0, 2.0][k] + s * f[k]);
        let surface = revolution(segment(from, to), [0.0, 0.0, -3.0], [-1.0, 5.0], true);
        let o = oracle(&surface);
        for _ in 0..40 {
            let uv = [g.range(2.0, 5.0), g.range(0.0, 3.0)];
            let e = o.evaluate(0, uv).unwrap();
            let p = minus(&middle(&e.point, &big), &origin);
            let t = (exact(uv[0]) - exact(2.0)) / exact(3.0);
            let height = exact(2.0) * &t;
            let radius = (RBig::ONE + exact(s) * &t) * exact(5.0);
            small(&(&p[2] - height), 150);
            small(&(&p[0] * &p[0] + &p[1] * &p[1] - &radius * &radius), 150);
            // Which point of the circle: about a downward axis it turns clockwise.
            let angle = -1.0 + uv[1] * 2.0;
            let r = radius.to_f64().value();
            let phi = 3.0f64.atan2(4.0) - angle;
            assert!((p[0].to_f64().value() - r * phi.cos()).abs() < 1e-12);
            assert!((p[1].to_f64().value() - r * phi.sin()).abs() < 1e-12);
        }
    }
    // Torus of radii R and r about a slanted axis through O: with h = A.p / |A| and p^2,
    // (p^2 + R^2 - r^2)^2 = 4 R^2 (p^2 - h^2). The profile's centre is O + (4, 3, 0) with A
    // orthogonal to it, and its plane holds both.
    let axis = [-3.0, 4.0, 2.0];
    let normal = Vector3::from(axis).cross(&Vector3::new(4.0, 3.0, 0.0));
    let torus = revolution(
        Curve3::Arc(arc3(
            [4.5, 2.75, 2.0],
            [1.0, 2.0, 0.5],
            normal.into(),
            2.0,
            [0.0, 6.0],
        )),
        axis,
        [0.0, 6.0],
        false,
    );
    let o = oracle(&torus);
    let a = exact3(axis);
    for _ in 0..40 {
        let e = o
            .evaluate(0, [g.range(0.0, 3.0), g.range(-1.0, 1.5)])
            .unwrap();
        let p = minus(&middle(&e.point, &big), &origin);
        let p2 = dot(&p, &p);
        let along = dot(&a, &p);
        let h2 = &along * &along / dot(&a, &a);
        let left = &p2 + exact(25.0) - exact(4.0);
        small(&(&left * &left - exact(100.0) * (p2 - h2)), 140);
    }
    assert!(a2 > RBig::ZERO);
}

#[test]
fn derivatives_are_limits_of_differences() {
    // Central differences of step 2^-40 are off by some 2^-80 times a third derivative.
    let h = 1.0 / (1u64 << 40) as f64;
    let step = exact(2.0 * h);
    let big = exact(1e15);
    for (s, uv) in surfaces() {
        let o = oracle(&s);
        let at = |u: f64, v: f64| o.evaluate(0, [u, v]).unwrap();
        let e = at(uv[0], uv[1]);
        let (plus, less) = (
            [at(uv[0] + h, uv[1]), at(uv[0], uv[1] + h)],
            [at(uv[0] - h, uv[1]), at(uv[0], uv[1] - h)],
        );
        let check =
            |up: &[TruthEnclosure; 3], down: &[TruthEnclosure; 3], d: &[TruthEnclosure; 3]| {
                let difference = minus(&middle(up, &big), &middle(down, &big));
                let d = middle(d, &big);
                let size: f64 = d.iter().map(|x| x.to_f64().value().abs()).sum();
                for k in 0..3 {
                    let off = (&difference[k] / &step - &d[k]).to_f64().value().abs();
                    // A third derivative is at most some 1e12 times the first here (turns of 1e6).
                    assert!(off <= 1e-24 * 1e13 * (1.0 + size), "{off:e} of {size:e}");
                }
            };
        check(&plus[0].point, &less[0].point, &e.du);
        check(&plus[1].point, &less[1].point, &e.dv);
        check(&plus[0].du, &less[0].du, &e.second[0]);
        check(&plus[0].dv, &less[0].dv, &e.second[1]);
        check(&plus[1].du, &less[1].du, &e.second[1]);
        check(&plus[1].dv, &less[1].dv, &e.second[2]);
    }
}

#[test]
fn kernel_and_oracle_evaluate_alike() {
    let mut g = Random(47);
    for (s, _) in surfaces() {
        let o = oracle(&s);
        let [du, dv] = s.domain();
        for k in 0..20 {
            let uv = if k == 0 {
                [du.start, dv.end]
            } else {
                [g.range(du.start, du.end), g.range(dv.start, dv.end)]
            };
            let p = s.point(uv[0], uv[1]);
            let e = o.evaluate(0, uv).unwrap();
            for c in 0..3 {
                let truth = e.point[c].lo.approximate();
                // A turn of up to 1e6 radians moves by its own rounding.
                assert!((truth - p[c]).abs() < 1e-8, "{uv:?}: {truth} {}", p[c]);
            }
        }
    }
}

#[test]
fn limits_take_the_side_asked_for() {
    let profile = Curve3::Polyline(
        Polyline::new(
            vec![
                Point3::new(1.0, 0.0, 0.0),
                Point3::new(2.0, 0.0, 1.0),
                Point3::new(2.0, 0.0, 4.0),
            ],
            vec![0.0, 1.0, 2.0],
        )
        .unwrap(),
    );
    let knots = |o: &Oracle, uv: [f64; 2], l: Limit| -> Evaluation {
        o.evaluate_from(0, uv, [l; 2]).unwrap()
    };
    let number = |x: &TruthEnclosure| x.lo.approximate();
    let s = Surface::Revolution(
        Revolution::new(Revolution {
            origin: Point3::origin(),
            axis: Vector3::z(),
            angle: interval(0.0, 1.0),
            angle_domain: interval(0.0, 1.0),
            profile: profile.clone(),
            transposed: false,
        })
        .unwrap(),
    );
    let o = oracle(&s);
    assert_eq!(number(&knots(&o, [0.0, 1.0], Limit::FromBelow).dv[2]), 1.0);
    assert_eq!(number(&knots(&o, [0.0, 1.0], Limit::FromAbove).dv[2]), 3.0);
    assert_eq!(
        o.evaluate(0, [0.0, 1.0]).unwrap().dv[2].lo.approximate(),
        3.0
    );
    // At the ends of the domain there is but one side.
    assert_eq!(number(&knots(&o, [0.0, 0.0], Limit::FromBelow).dv[2]), 1.0);
    assert_eq!(number(&knots(&o, [1.0, 2.0], Limit::FromAbove).dv[2]), 3.0);
    // At angle 0 everything is exact.
    let e = knots(&o, [0.0, 1.5], Limit::FromAbove);
    assert!(e.point.iter().chain(&e.dv).all(|x| x.lo == x.hi));
    // A spline with a corner.
    let s = Surface::Sum(Sum {
        base: Vector3::zeros(),
        first: Curve3::Poly(
            PolyCurve::new(
                vec![
                    segment([0.0; 3], [1.0, 0.0, 0.0]),
                    segment([1.0, 0.0, 0.0], [1.0, 2.0, 0.0]),
                ],
                vec![0.0, 0.5, 1.0],
            )
            .unwrap(),
        ),
        second: profile,
    });
    let o = oracle(&s);
    assert_eq!(number(&knots(&o, [0.5, 1.0], Limit::FromBelow).du[0]), 2.0);
    assert_eq!(number(&knots(&o, [0.5, 1.0], Limit::FromAbove).du[1]), 4.0);
    assert_eq!(number(&knots(&o, [0.5, 1.0], Limit::FromBelow).dv[2]), 1.0);
}

#[test]
fn native_points_lie_on_their_nurbs_siblings() {
    // The NURBS forms are exact but for the rounding of their control points.
    let mut g = Random(53);
    let mut asked = 0;
    for name in NATIVE {
        let read = |suffix: &str| scene::model(&format!("thesis/3dm/{name}{suffix}.3dm"));
        let (Some(native), Some(nurbs)) = (read(""), read("_nurbs")) else {
            continue;
        };
        let all: Vec<&Brep> = nurbs.iter().collect();
        let sibling = Oracle::new(&all).unwrap();
        for b in &native {
            let o = Oracle::new(&[b]).unwrap();
            for face in 0..b.faces().len().min(4) {
                let [du, dv] = b.surface(face).domain();
                for _ in 0..60 {
                    let uv = [g.range(du.start, du.end), g.range(dv.start, dv.end)];
                    if o.side(face, uv).unwrap().side == feeler::trim::Side::Outside {
                        continue;
                    }
                    let e = o.evaluate(face, uv).unwrap();
                    let p = e.point.map(|x| x.lo.approximate());
                    let d = sibling.distance(p, None).unwrap().unwrap();
                    assert!(
                        d.enclosure.lo.approximate() < 1e-12,
                        "{name}, face {face}, {uv:?}: {}",
                        d.enclosure.lo.approximate()
                    );
                    asked += 1;
                    break;
                }
            }
        }
    }
    println!("{asked} points");
}
