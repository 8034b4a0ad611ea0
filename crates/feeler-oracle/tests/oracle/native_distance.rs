//! Distances and half-spaces of native surfaces against closed forms in exact arithmetic, and
//! against the same parts as NURBS.

use crate::scene::native::{arc_xz, circle2, line3, revolved};
use crate::scene::{Random, brep, dyadic as d, interval, model, plane, polygon, sq};
use dashu_int::IBig;
use feeler::brep::Brep;
use feeler::numeric::Dyadic;
use feeler::nurbs::{Arc, Curve3, NurbsCurve, PolyCurve, Revolution, Sum, Surface};
use feeler_oracle::{DistanceStatus, DistanceTruth, Oracle, TruthEnclosure};
use nalgebra::{Point3, Vector3, Vector4};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn oracle(b: &Brep) -> Oracle {
    Oracle::new(&[b]).unwrap()
}

fn distance(o: &Oracle, p: [f64; 3]) -> DistanceTruth {
    o.distance(p, None).unwrap().unwrap()
}

/// No wider than 2^-100 of the size.
fn assert_narrow(t: &DistanceTruth, size: f64) {
    let most = &d(size) * &Dyadic::new(IBig::ONE, -100);
    assert!(t.enclosure.width() <= most, "{t:?}");
}

/// A centre, an axis, a spine: all of a curve or of the surface is nearest, and that is seen soon.
#[track_caller]
fn assert_level(t: &DistanceTruth, value: f64, size: f64) {
    assert!(t.enclosure.contains(&d(value)), "{t:?}");
    assert_narrow(t, size);
    assert_eq!(t.status, DistanceStatus::IntervalOnly);
    assert!(t.nodes[1] < 1000, "{t:?}");
}

/// `a <= k sqrt(s) <= b`, k >= 0.
fn assert_root_between(a: &Dyadic, k: &Dyadic, s: &Dyadic, b: &Dyadic, what: &str) {
    let square = &sq(k) * s;
    assert!(a.signum() <= 0 || sq(a) <= square, "lower end: {what}");
    assert!(b.signum() >= 0 && square <= sq(b), "upper end: {what}");
}

/// The enclosure holds `|k sqrt(s) + m| / n` with k, n > 0.
fn assert_linear_in_root(e: &TruthEnclosure, [k, n]: [f64; 2], s: &Dyadic, m: &Dyadic, what: &str) {
    let (lo, hi) = (&d(n) * &e.lo, &d(n) * &e.hi);
    // The sign of k sqrt(s) + m.
    let negative = m.signum() < 0 && &sq(&d(k)) * s < sq(m);
    let (a, b) = if negative {
        (&(&Dyadic::ZERO - &hi) - m, &(&Dyadic::ZERO - &lo) - m)
    } else {
        (&lo - m, &hi - m)
    };
    assert_root_between(&a, &d(k), s, &b, what);
}

fn sphere(radius: f64) -> Surface {
    revolved(
        arc_xz([0.0; 3], radius, [-FRAC_PI_2, FRAC_PI_2]),
        [0.0, TAU],
        false,
    )
}

fn point(random: &mut Random, size: f64) -> [f64; 3] {
    [0; 3].map(|_| random.range(-size, size))
}

fn squares(p: [f64; 3]) -> [Dyadic; 3] {
    p.map(|x| sq(&d(x)))
}

#[test]
fn spheres() {
    let mut random = Random(1);
    let r = 2.5;
    for surface in [
        sphere(r),
        // More than a turn.
        revolved(
            arc_xz([0.0; 3], r, [-FRAC_PI_2, FRAC_PI_2]),
            [-0.5, 7.0],
            true,
        ),
    ] {
        let o = oracle(&brep(surface, None));
        for i in 0..40 {
            let mut p = point(&mut random, [4.0, 0.1, 1e-9, 1e-20][i % 4]);
            // The slits that a f64 pi leaves are no wider than 1e-15.
            p[1] += if p[1] < 0.0 { -1e-3 } else { 1e-3 };
            let t = distance(&o, p);
            let [x, y, z] = squares(p);
            let s = &(&x + &y) + &z;
            assert_linear_in_root(&t.enclosure, [1.0, 1.0], &s, &d(-r), &format!("{p:?}"));
            assert_narrow(&t, r);
        }
        assert_level(&distance(&o, [0.0; 3]), r, r);
        // The poles' neighbourhood: where the patch collapses.
        for e in [0.0, 1e-15, 1e-9, 1e-3] {
            let p = [e, e, 3.0];
            let t = distance(&o, p);
            let s = &(&sq(&d(e)) + &sq(&d(e))) + &d(9.0);
            // The pole itself is cut off by the rounding of pi / 2, some 1e-16 of an angle: within
            // 1e-32 of the distance.
            let slack = Dyadic::new(IBig::ONE, -100);
            let wide = TruthEnclosure {
                lo: &t.enclosure.lo - &slack,
                hi: &t.enclosure.hi + &slack,
            };
            assert_linear_in_root(&wide, [1.0, 1.0], &s, &d(-r), &format!("{p:?}"));
            assert_narrow(&t, r);
        }
    }
}

#[test]
fn cylinders() {
    let mut random = Random(2);
    let profile = || line3([2.0, 0.0, -8.0], [2.0, 0.0, 8.0]);
    let sum = Surface::Sum(Sum {
        base: Vector3::new(0.0, 0.0, -8.0),
        first: Curve3::Arc(
            Arc::new(Arc {
                center: Point3::origin(),
                x: Vector3::new(2.0, 0.0, 0.5),
                y: Vector3::y(),
                z: Vector3::new(0.0, 0.0, 7.0),
                radius: 2.0,
                angle: interval(-1.0, TAU - 1.0),
                domain: interval(0.0, 1.0),
            })
            .unwrap(),
        ),
        second: line3([0.0, 0.0, 0.0], [0.0, 0.0, 16.0]),
    });
    let window = polygon(&[[-3.0, 0.0], [3.0, 0.0], [3.0, 1.0], [-3.0, 1.0]]);
    for (surface, loops) in [
        (revolved(profile(), [0.0, TAU], false), None),
        (sum, None),
        // All but a sixth of a radian around the negative x axis.
        (revolved(profile(), [-PI, PI], false), Some(vec![window])),
    ] {
        let o = oracle(&brep(surface, loops));
        for i in 0..30 {
            let mut p = point(&mut random, 4.0);
            // Off the window's gap, and off the slits.
            p[0] = p[0].abs() + 0.2;
            p[1] += if p[1] < 0.0 { -1e-3 } else { 1e-3 };
            if i % 3 == 0 {
                let e = [1e-15, 1e-9, 1e-4][i % 9 / 3];
                let scale = 2.0 / p[0].hypot(p[1]) + e;
                p = [p[0] * scale, p[1] * scale, p[2]];
            }
            let t = distance(&o, p);
            let [x, y, _] = squares(p);
            assert_linear_in_root(
                &t.enclosure,
                [1.0, 1.0],
                &(&x + &y),
                &d(-2.0),
                &format!("{p:?}"),
            );
            assert_narrow(&t, 16.0);
        }
        for z in [0.0, 0.3, -7.0] {
            assert_level(&distance(&o, [0.0, 0.0, z]), 2.0, 16.0);
        }
        // Downwards: the ring at the lower end.
        let half = o.half_space([0.0, 0.0, 1.0], 0.0, None).unwrap().unwrap();
        assert!(half.enclosure.contains(&d(-8.0)));
        assert_narrow(&half, 16.0);
    }
}

#[test]
fn oblique_cylinder() {
    // About the direction (1, 2, 2) / 3 through a point off the origin.
    let surface = Surface::Revolution(
        Revolution::new(Revolution {
            origin: Point3::new(1.0, -1.0, 0.5),
            axis: Vector3::new(1.0, 2.0, 2.0),
            angle: interval(0.0, TAU),
            angle_domain: interval(0.0, 1.0),
            // (2, -2, 1) / 3 is orthogonal to the axis; 6 is the radius.
            profile: line3(
                [1.0 + 4.0 - 9.0, -1.0 - 4.0 - 18.0, 0.5 + 2.0 - 18.0],
                [1.0 + 4.0 + 9.0, -1.0 - 4.0 + 18.0, 0.5 + 2.0 + 18.0],
            ),
            transposed: true,
        })
        .unwrap(),
    );
    let o = oracle(&brep(surface, None));
    let mut random = Random(3);
    for _ in 0..20 {
        let p = point(&mut random, 10.0);
        let t = distance(&o, p);
        let e = [&d(p[0]) - &d(1.0), &d(p[1]) + &d(1.0), &d(p[2]) - &d(0.5)];
        let along = &(&e[0] + &(&d(2.0) * &e[1])) + &(&d(2.0) * &e[2]);
        let all = &(&sq(&e[0]) + &sq(&e[1])) + &sq(&e[2]);
        // Nine times the square of the distance from the axis.
        let s = &(&d(9.0) * &all) - &sq(&along);
        assert_linear_in_root(&t.enclosure, [1.0, 3.0], &s, &d(-18.0), &format!("{p:?}"));
        assert_narrow(&t, 50.0);
    }
}

#[test]
fn cones() {
    // Half-angle with tangent 3/4; from the apex, which is a pole.
    let o = oracle(&brep(
        revolved(line3([0.0, 0.0, 0.0], [6.0, 0.0, 8.0]), [0.0, TAU], false),
        None,
    ));
    let mut random = Random(4);
    for i in 0..30 {
        let e = [1.0, 1e-3, 1e-9][i % 3];
        let p = [
            e * random.range(-2.0, 2.0),
            e * (0.01 + random.range(0.0, 2.0)),
            e * random.range(2.0, 4.0),
        ];
        let t = distance(&o, p);
        let [x, y, _] = squares(p);
        let m = &d(-3.0) * &d(p[2]);
        assert_linear_in_root(&t.enclosure, [4.0, 5.0], &(&x + &y), &m, &format!("{p:?}"));
        assert_narrow(&t, 10.0);
    }
    // Below the apex.
    let t = distance(&o, [0.0, 0.0, -1.5]);
    assert!(t.enclosure.contains(&d(1.5)));
    assert_narrow(&t, 10.0);
    // On the axis all of a circle is nearest: 3/5 of the height.
    assert_level(&distance(&o, [0.0, 0.0, 5.0]), 3.0, 10.0);
}

/// The enclosure e of `|sqrt(t) - r|` with `t = rho^2 - 2 R rho + R^2 + z^2`, rho^2 = s.
fn assert_torus(e: &TruthEnclosure, [big, r]: [f64; 2], s: &Dyadic, z: &Dyadic, what: &str) {
    let rest = &(s + &sq(&d(big))) + &sq(z);
    let twice = d(2.0 * big);
    // Whether t < r^2: the point is in the tube.
    let m = &rest - &sq(&d(r));
    let inside = m.signum() < 0 || sq(&m) < &sq(&twice) * s;
    // sqrt(t) within [a, b].
    let (a, b) = if inside {
        (&d(r) - &e.hi, &d(r) - &e.lo)
    } else {
        (&d(r) + &e.lo, &d(r) + &e.hi)
    };
    let low = if a.signum() > 0 { sq(&a) } else { Dyadic::ZERO };
    assert_root_between(&(&rest - &sq(&b)), &twice, s, &(&rest - &low), what);
}

/// A Bezier curve in space.
fn bezier3(points: &[[f64; 4]]) -> Curve3 {
    let p = points.len() - 1;
    let knots = [vec![0.0; p + 1], vec![1.0; p + 1]].concat();
    let points = points.iter().map(|q| Vector4::from(*q)).collect();
    Curve3::Nurbs(NurbsCurve::new(p, points, knots).unwrap())
}

#[test]
fn tori() {
    let (big, r) = (3.0, 1.25);
    // The exact circle as four rational quadratics, weights 1, 1, 2.
    let quarter = |k: usize| {
        let turn = |[x, z, w]: [f64; 3]| {
            let (x, z) = match k {
                0 => (x, z),
                1 => (-z, x),
                2 => (-x, -z),
                _ => (z, -x),
            };
            [x + big * w, 0.0, z, w]
        };
        bezier3(&[
            turn([r, 0.0, 1.0]),
            turn([r, r, 1.0]),
            turn([0.0, 2.0 * r, 2.0]),
        ])
    };
    let rational = Curve3::Poly(
        PolyCurve::new((0..4).map(quarter).collect(), vec![0.0, 0.1, 1.0, 7.0, 9.0]).unwrap(),
    );
    let mut random = Random(5);
    for profile in [arc_xz([big, 0.0, 0.0], r, [0.0, TAU]), rational] {
        let o = oracle(&brep(revolved(profile, [0.0, TAU], false), None));
        for i in 0..24 {
            let mut p = point(&mut random, 5.0);
            p[1] += if p[1] < 0.0 { -1e-3 } else { 1e-3 };
            if i % 4 == 1 {
                // Near the spine.
                let scale = big / p[0].hypot(p[1]);
                p = [p[0] * scale, p[1] * scale, 1e-14 * p[2]];
            }
            let t = distance(&o, p);
            let [x, y, _] = squares(p);
            assert_torus(
                &t.enclosure,
                [big, r],
                &(&x + &y),
                &d(p[2]),
                &format!("{p:?}"),
            );
            assert_narrow(&t, 8.0);
        }
        // On the spine, exactly; on the axis.
        assert_level(&distance(&o, [0.0, 3.0, 0.0]), r, 8.0);
        assert_level(&distance(&o, [0.0, 0.0, 4.0]), 3.75, 8.0);
    }
}

#[test]
fn discs() {
    // The loop's ends differ by the rounding of pi: a segment joins them.
    for (loops, size) in [
        (vec![circle2([0.0; 2], 1.5, [0.0, TAU])], 4.0),
        (vec![circle2([0.0; 2], 1.5, [0.0, TAU])], 1.5),
        (
            vec![
                circle2([0.0; 2], 1.5, [0.7, 3.0]),
                circle2([0.0; 2], 1.5, [3.0, 0.7 + TAU]),
            ],
            4.0,
        ),
    ] {
        let o = oracle(&brep(plane(size), Some(vec![loops])));
        let mut random = Random(6);
        for _ in 0..20 {
            let mut p = point(&mut random, 4.0);
            p[1] += if p[1] < 0.0 { -1e-3 } else { 1e-3 };
            let [x, y, _] = squares(p);
            let s = &x + &y;
            let t = distance(&o, p);
            assert_narrow(&t, 4.0);
            if s < sq(&d(1.5)) {
                assert!(t.enclosure.contains(&d(p[2].abs())), "{p:?} {t:?}");
            } else {
                // A torus of radius 0.
                assert_torus(&t.enclosure, [1.5, 0.0], &s, &d(p[2]), &format!("{p:?}"));
            }
        }
        let t = distance(&o, [0.0, 1.5, 0.0]);
        assert!(
            t.enclosure.contains(&Dyadic::ZERO) && t.enclosure.hi <= Dyadic::new(IBig::ONE, -100)
        );
    }
}

/// cos 1 within 2^-160, as 48 digits.
fn cos_one() -> [Dyadic; 2] {
    // 0.540302305868139717400936607442976603732310420617922...
    let digits =
        IBig::from_str_radix("540302305868139717400936607442976603732310420617", 10).unwrap();
    // Rounded to 2^-150 below and above: digits 2^150 / 10^48.
    let scale = IBig::from(10).pow(48);
    let m = (digits << 150) / scale;
    [
        Dyadic::new(m.clone() - IBig::ONE, -150),
        Dyadic::new(m + IBig::from(2), -150),
    ]
}

#[test]
fn circle_on_a_cylinder() {
    // The image of a circle of uv around (0, 0) is no rational curve. From (-s, 0, 0) the nearest
    // of its points are those at u = +-1, v = 0: the square s^2 + R^2 + 2 s R cos u + v^2 decreases
    // in u along u^2 + v^2 = 1.
    let surface = || revolved(line3([1.0, 0.0, -2.0], [1.0, 0.0, 2.0]), [-3.0, 3.0], false);
    let Surface::Revolution(mut r) = surface() else {
        panic!("a revolution")
    };
    if let Curve3::Line(l) = &mut r.profile {
        l.domain = interval(-2.0, 2.0);
    }
    let o = oracle(&brep(
        Surface::Revolution(r),
        Some(vec![vec![circle2([0.0; 2], 1.0, [0.5, 0.5 + TAU])]]),
    ));
    let [low, high] = cos_one();
    for s in [1.0, 0.25, 3.0] {
        let t = distance(&o, [-s, 0.0, 0.0]);
        let square = |c: &Dyadic| &d(s * s + 1.0) + &(&d(2.0 * s) * c);
        assert!(sq(&t.enclosure.lo) <= square(&high), "{s} {t:?}");
        assert!(square(&low) <= sq(&t.enclosure.hi), "{s} {t:?}");
        assert_narrow(&t, 4.0);
    }
    // Above its inside.
    let t = distance(&o, [1.5, 0.25, 0.125]);
    let s = &sq(&d(1.5)) + &sq(&d(0.25));
    assert_linear_in_root(&t.enclosure, [1.0, 1.0], &s, &d(-1.0), "above the disc");
}

/// The same part from two files: how far the answers are apart, in parts of the size.
#[test]
fn thesis_parts_native_and_nurbs() {
    for (name, most) in [("ball_joint_cavity", 1e-14)] {
        let Some(native) = model(&format!("thesis/3dm/{name}.3dm")) else {
            return;
        };
        let nurbs = model(&format!("thesis/3dm/{name}_nurbs.3dm")).unwrap();
        let a = Oracle::new(&native.iter().collect::<Vec<_>>()).unwrap();
        let b = Oracle::new(&nurbs.iter().collect::<Vec<_>>()).unwrap();
        let mut size = 0f64;
        for v in &native[0].parts().vertices {
            size = size.max(v.point.coords.norm());
        }
        let mut random = Random(7);
        let mut worst = 0f64;
        for i in 0..24 {
            let p = point(&mut random, if i % 2 == 0 { size } else { 0.3 * size });
            let (x, y) = (distance(&a, p), distance(&b, p));
            assert_narrow(&x, size);
            let apart = (&x.enclosure.lo - &y.enclosure.lo).approximate().abs() / size;
            worst = worst.max(apart);
            let n = Vector3::from(point(&mut random, 1.0)).normalize();
            let half = |o: &Oracle| o.half_space([n.x, n.y, n.z], 0.5, None).unwrap().unwrap();
            let (x, y) = (half(&a), half(&b));
            assert_narrow(&x, size);
            let apart = (&x.enclosure.lo - &y.enclosure.lo).approximate().abs() / size;
            worst = worst.max(apart);
        }
        println!("{name}: at most {worst:.1e} of the size apart");
        assert!(worst <= most, "{name}: {worst:e}");
    }
}
