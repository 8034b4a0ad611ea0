//! Contact queries on surfaces with known answers.

use crate::scenes::loops::{face_of, polygon, square_plane};
use feeler::brep::{Brep, BrepBuilder, BrepParts, Face};
use feeler::numeric::{Dyadic, Interval};
use feeler::nurbs::{
    Arc, Curve, Curve2, Curve3, Line, NurbsCurve, NurbsCurve3, NurbsSurface, Plane, PolyCurve,
    Revolution, Surface,
};
use feeler::prepare::{PreparedBrep, Shortcuts};
use feeler::query::{
    Accuracy, ContactAnswer, Contacts, Feature, HalfSpace, Options, Probe, Sphere, Workspace,
    contact,
};
use nalgebra::{Point2, Point3, Vector2, Vector3, Vector4};

/// An untrimmed face.
fn sheet(surface: Surface) -> PreparedBrep {
    let parts = BrepParts {
        surfaces: vec![surface],
        faces: vec![Face {
            surface: 0,
            loops: None,
            reversed: false,
        }],
        ..BrepParts::default()
    };
    PreparedBrep::new(Brep::new(parts).unwrap())
}

/// The sphere about the origin as the usual 9 x 5 rational biquadratic net.
fn nurbs_sphere(radius: f64) -> Surface {
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let circle = [
        (1., 0., 1.),
        (1., 1., h),
        (0., 1., 1.),
        (-1., 1., h),
        (-1., 0., 1.),
        (-1., -1., h),
        (0., -1., 1.),
        (1., -1., h),
        (1., 0., 1.),
    ];
    let profile = [
        (0., -1., 1.),
        (1., -1., h),
        (1., 0., 1.),
        (1., 1., h),
        (0., 1., 1.),
    ];
    let mut net = Vec::new();
    for (cx, cy, cw) in circle {
        for (r, z, pw) in profile {
            let w = cw * pw;
            net.push(Vector4::new(
                radius * r * cx * w,
                radius * r * cy * w,
                radius * z * w,
                w,
            ));
        }
    }
    let ku = vec![0., 0., 0., 1., 1., 2., 2., 3., 3., 4., 4., 4.];
    let kv = vec![0., 0., 0., 1., 1., 2., 2., 2.];
    Surface::Nurbs(NurbsSurface::new([2, 2], [9, 5], net, [ku, kv]).unwrap())
}

fn ask(
    brep: &PreparedBrep,
    c: [f64; 3],
    r: f64,
    accuracy: Accuracy,
) -> feeler::query::ContactAnswer {
    let probe = Probe::Sphere(Sphere::new(Point3::from(c), r).unwrap());
    let options = Options {
        accuracy,
        prediction: f64::INFINITY,
        ..Options::default()
    };
    contact(brep, &probe, &options, &mut Workspace::default())
}

#[test]
fn ball_in_a_nurbs_sphere() {
    let brep = sheet(nurbs_sphere(2.5));
    for e in [
        0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 0.1, 2.4, 2.5, 3.0, 10.0,
    ] {
        let c = [e * 0.6, 0.0, e * 0.8];
        let a = ask(&brep, c, 2.51, Accuracy::Full);
        let coarse = ask(&brep, c, 2.51, Accuracy::Length(1e-11));
        // The net's own rounding: radii from 2.5 - 8.5e-16 to 2.5 + 1.2e-16.
        let norm = e;
        let truth = (norm - 2.5f64).abs() - 2.51;
        assert!(
            (a.separation.value - truth).abs() < 4e-15,
            "{e}: {:?} {truth}",
            a.separation
        );
        assert!(a.undecided.is_none(), "{e}: {:?}", a.separation);
        assert!(coarse.undecided.is_none());
        assert!(coarse.separation.bounds.width() <= 1e-11);
    }
}

#[test]
fn point_over_a_rectangle() {
    let plane = Plane {
        origin: Point3::new(1.0, 2.0, 3.0),
        x: Vector3::new(0.6, 0.8, 0.0),
        y: Vector3::new(-0.8, 0.6, 0.0),
        domain: [
            Interval {
                start: 0.0,
                end: 4.0,
            },
            Interval {
                start: 0.0,
                end: 2.0,
            },
        ],
        extents: [
            Interval {
                start: 0.0,
                end: 4.0,
            },
            Interval {
                start: 0.0,
                end: 2.0,
            },
        ],
    };
    let brep = sheet(Surface::Plane(plane));
    let at = |u: f64, v: f64, z: f64| [1.0 + 0.6 * u - 0.8 * v, 2.0 + 0.8 * u + 0.6 * v, 3.0 + z];
    for (u, v, z, d) in [
        (1.0, 1.0, 0.5, 0.5),
        (1.0, 1.0, -1e-9, 1e-9),
        (-3.0, 1.0, 4.0, 5.0),
        (7.0, 1.0, 4.0, 5.0),
        (5.0, 4.0, 2.0, 3.0),
        (2.0, -1e-3, 0.0, 1e-3),
    ] {
        let a = ask(&brep, at(u, v, z), 0.25, Accuracy::Full);
        assert!(
            (a.separation.value - (d - 0.25)).abs() < 1e-14,
            "{u} {v} {z}"
        );
        assert!(a.undecided.is_none(), "{u} {v} {z}");
    }
}

#[test]
fn half_space_under_a_sphere() {
    let brep = sheet(nurbs_sphere(2.0));
    for n in [
        [0.0, 0.0, 1.0],
        [0.6, 0.8, 0.0],
        [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0],
    ] {
        let probe = Probe::HalfSpace(HalfSpace::new(Vector3::from(n), -1.5).unwrap());
        let a = contact(
            &brep,
            &probe,
            &Options::default(),
            &mut Workspace::default(),
        );
        assert!((a.separation.value - (-0.5)).abs() < 4e-15);
        assert!(a.undecided.is_none());
    }
}

/// The sphere of this radius about the origin, as a native revolution of a half circle.
fn native_sphere(radius: f64) -> Surface {
    let arc = Arc {
        center: Point3::origin(),
        x: Vector3::x(),
        y: Vector3::z(),
        z: -Vector3::y(),
        radius,
        angle: interval(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2),
        domain: interval(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2),
    };
    turned(Curve3::Arc(Arc::new(arc).unwrap()))
}

/// The cylinder of this radius about the z axis, from -5 to 5.
fn native_cylinder(radius: f64) -> Surface {
    let line = Line::new(
        Point3::new(radius, 0.0, -5.0),
        Point3::new(radius, 0.0, 5.0),
        interval(0.0, 10.0),
    );
    turned(Curve3::Line(line.unwrap()))
}

/// The same cylinder; its profile is a poly-curve whose segments have domains of their own.
fn poly_cylinder(radius: f64) -> Surface {
    let segment = |from: f64, to: f64, start: f64, end: f64| {
        let (a, b) = (Point3::new(radius, 0.0, from), Point3::new(radius, 0.0, to));
        Curve3::Line(Line::new(a, b, interval(start, end)).unwrap())
    };
    // The second is a spline of two spans: its inner knot is no round number in the poly-curve.
    let z = [1.0, 2.0, 5.0];
    let points = z.map(|z| Vector4::new(radius, 0.0, z, 1.0)).to_vec();
    let spline = NurbsCurve3::new(1, points, vec![-7.0, -7.0, -6.7, -6.0, -6.0]).unwrap();
    let segments = vec![segment(-5.0, 1.0, 0.0, 10.0), Curve3::Nurbs(spline)];
    let params = vec![3.0, 3.3, 5.0];
    turned(Curve3::Poly(PolyCurve::new(segments, params).unwrap()))
}

fn interval(start: f64, end: f64) -> Interval {
    Interval::new(start, end).unwrap()
}

fn turned(profile: Curve3) -> Surface {
    let turn = interval(0.0, std::f64::consts::TAU);
    let revolution = Revolution {
        origin: Point3::origin(),
        axis: Vector3::new(0.0, 0.0, 2.0),
        angle: turn,
        angle_domain: turn,
        profile,
        transposed: false,
    };
    Surface::Revolution(Revolution::new(revolution).unwrap())
}

fn exact(x: f64) -> Dyadic {
    Dyadic::from_f64(x).unwrap()
}

/// Checks `lo <= |rho - radius| <= hi` in exact arithmetic, `rho` being the root of `square`.
fn assert_distance(square: &Dyadic, radius: f64, lo: &Dyadic, hi: &Dyadic, outside: bool) {
    let r = exact(radius);
    // rho = radius +- d.
    let (low, high) = if outside {
        (&r + lo, &r + hi)
    } else {
        (&r - hi, &r - lo)
    };
    assert!(
        low.signum() < 0 || &(&low * &low) <= square,
        "rho below the claim"
    );
    assert!(&(&high * &high) >= square, "rho above the claim");
}

#[test]
fn native_sphere_and_cylinder_are_exact() {
    for (surface, axes) in [
        (native_sphere(2.5), 3),
        (native_cylinder(2.5), 2),
        (poly_cylinder(2.5), 2),
    ] {
        let brep = sheet(surface);
        for c in [
            [0.3, 0.4, 0.1],
            [-1.7, 1.1, 1.3],
            [3.0, -4.0, 2.0],
            [2.5 + 1e-9, 0.0, 0.0],
            [1.5, 2.0, 1e-7],
            [0.0, 1e-3, 4.0],
        ] {
            let radius = 0.125;
            let a = ask(&brep, c, radius, Accuracy::Full);
            assert!(a.undecided.is_none(), "{c:?}: {:?}", a.separation);
            let (lo, hi) = (exact(a.separation.bounds.lo), exact(a.separation.bounds.hi));
            let (lo, hi) = (&lo + &exact(radius), &hi + &exact(radius));
            let mut square = Dyadic::ZERO;
            for x in &c[..axes] {
                square = &square + &(&exact(*x) * &exact(*x));
            }
            let outside = square > &exact(2.5) * &exact(2.5);
            assert_distance(&square, 2.5, &lo, &hi, outside);
        }
    }
}

/// A point between two parallel rectangles, at distances that f64 holds exactly: each contact's own
/// enclosure must hold its own separation.
#[test]
fn all_contacts_have_enclosures_of_their_own() {
    let rectangle = |z: f64| {
        let range = interval(0.0, 4.0);
        Surface::Plane(Plane {
            origin: Point3::new(0.0, 0.0, z),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [range; 2],
            extents: [range; 2],
        })
    };
    let face = |surface| Face {
        surface,
        loops: None,
        reversed: false,
    };
    let parts = BrepParts {
        surfaces: vec![rectangle(0.0), rectangle(5.0)],
        faces: vec![face(0), face(1)],
        ..BrepParts::default()
    };
    let brep = PreparedBrep::new(Brep::new(parts).unwrap());
    let probe = Probe::Sphere(Sphere::new(Point3::new(1.0, 1.5, 2.0), 4.0).unwrap());
    let options = Options {
        contacts: Contacts::All,
        ..Options::default()
    };
    let a = contact(&brep, &probe, &options, &mut Workspace::default());
    let found: Vec<_> = a.contacts.iter().map(|c| c.feature).collect();
    assert_eq!(found, [Feature::Face(0), Feature::Face(1)]);
    for (c, truth) in a.contacts.iter().zip([-2.0, -1.0]) {
        let bounds = c.separation.bounds;
        assert!(bounds.contains(truth), "{truth}: {bounds:?}");
        assert!(bounds.width() < 1e-12, "{truth}: {bounds:?}");
    }
}

/// A ball without extent in the apex of a cone: the surface has no normal there, but the contact must not be lost.
#[test]
fn a_point_in_the_apex_of_a_cone_is_a_contact() {
    // A slant of 3 : 4, as a native revolution, and over a parabola.
    let slant = Curve3::Line(Line {
        from: Point3::new(3.0, 0.0, 0.0),
        to: Point3::new(0.0, 0.0, 4.0),
        domain: interval(0.0, 1.0),
    });
    let mut net = Vec::new();
    for [x, y] in [[3.0, 0.0], [0.0, 3.0], [-3.0, 0.0]] {
        net.push(Vector4::new(x, y, 0.0, 1.0));
        net.push(Vector4::new(0.0, 0.0, 4.0, 1.0));
    }
    let knots = [vec![0., 0., 0., 1., 1., 1.], vec![0., 0., 1., 1.]];
    let over_parabola = NurbsSurface::new([2, 1], [3, 2], net, knots).unwrap();
    for (surface, whole) in [
        (turned(slant), true),
        (Surface::Nurbs(over_parabola), false),
    ] {
        let brep = sheet(surface);
        let probe = Probe::Sphere(Sphere::new(Point3::new(0.0, 0.0, 4.0), 0.0).unwrap());
        let options = Options::default();
        let answer = contact(&brep, &probe, &options, &mut Workspace::default());
        let bounds = answer.separation.bounds;
        assert!(bounds.lo <= 0.0 && 0.0 <= bounds.hi);
        let c = &answer.contacts[0];
        assert!((c.on_brep - Point3::new(0.0, 0.0, 4.0)).norm() <= 1e-15);
        assert!((c.normal.norm() - 1.0).abs() <= 1e-15);
        // By symmetry, nothing of the sum of the normals around is along x; and for the whole cone nothing along y.
        assert!(c.normal.x.abs() <= 1e-9, "{}", c.normal);
        assert!(!whole || c.normal.y.abs() <= 1e-9, "{}", c.normal);
    }
}

/// A native sphere without loops is in closed form like one with them: no search node is needed.
#[test]
fn a_native_sphere_without_loops_needs_no_search() {
    let ball = sheet(native_sphere(2.5));
    // Exact distances: the centres lie on axes, or at (3, 4, 12) / 16 of length 13/16.
    for (c, d) in [
        ([0.5, 0.0, 0.0], 2.0),
        ([0.0, -1.25, 0.0], 1.25),
        ([0.0, 0.0, 4.0], 1.5),
        ([3.0 / 16.0, 4.0 / 16.0, 12.0 / 16.0], 2.5 - 13.0 / 16.0),
    ] {
        let probe = Probe::Sphere(Sphere::new(Point3::from(c), 0.25).unwrap());
        let options = Options {
            prediction: f64::INFINITY,
            node_budget: 4,
            ..Options::default()
        };
        let found = contact(&ball, &probe, &options, &mut Workspace::default());
        let bounds = found.separation.bounds;
        assert_eq!(found.undecided, None, "{c:?} {found:?}");
        assert!(
            bounds.lo <= d - 0.25 && d - 0.25 <= bounds.hi,
            "{c:?} {bounds:?}"
        );
        assert!(bounds.width() <= 4.0 * f64::EPSILON, "{c:?} {bounds:?}");
    }
}

/// A ball about the middle of a spherical socket is a continuum at any accuracy, and one off it is not.
#[test]
fn a_centred_ball_is_a_continuum_at_any_accuracy() {
    for surface in [nurbs_sphere(2.5), native_sphere(2.5)] {
        let socket = sheet(surface);
        for accuracy in [
            Accuracy::Length(1e-3),
            Accuracy::Length(1e-8),
            Accuracy::Length(1e-12),
            Accuracy::Full,
        ] {
            let found = ask(&socket, [0.0; 3], 2.49, accuracy);
            assert!(found.continuum, "{accuracy:?} {found:?}");
            let bounds = found.separation.bounds;
            assert!(bounds.lo <= 0.01 + 1e-14 && 0.01 - 1e-14 <= bounds.hi);
            // At 1e-3 so much of the socket is as near that it counts as a continuum too.
            if accuracy != Accuracy::Length(1e-3) {
                let found = ask(&socket, [0.5, 0.25, 0.125], 1.5, accuracy);
                assert!(!found.continuum, "{accuracy:?} {found:?}");
            }
        }
    }
}

/// What is recognised bounds the answer no tighter than is true: far from, near to, and inside spheres that are not
/// quite spheres.
#[test]
fn recognised_spheres_bound_truly() {
    // One control point off by a part in 10^k of the radius.
    for k in [4, 8, 11, 13, 15] {
        let Surface::Nurbs(sphere) = nurbs_sphere(2.5) else {
            unreachable!("a NURBS")
        };
        let mut net = sphere.control_net().to_vec();
        net[5 * 2 + 1].x += 2.5 * 10f64.powi(-k);
        let knots = [sphere.knots_u(), sphere.knots_v()].map(|k| k.knots().to_vec());
        let dented = NurbsSurface::new([2, 2], [9, 5], net, knots).unwrap();
        let with = sheet(Surface::Nurbs(dented.clone()));
        let parts = BrepParts {
            surfaces: vec![Surface::Nurbs(dented)],
            faces: vec![Face {
                surface: 0,
                loops: None,
                reversed: false,
            }],
            ..BrepParts::default()
        };
        let shortcuts = Shortcuts {
            recognition: false,
            ..Shortcuts::ALL
        };
        let without = PreparedBrep::with_shortcuts(Brep::new(parts).unwrap(), shortcuts);
        for i in 0..60 {
            let (a, b) = (0.37 * f64::from(i), 0.61 * f64::from(i));
            let r = [1e-9, 1e-3, 1.0, 2.4999, 2.5, 2.6, 40.0][i as usize % 7];
            let c = [r * a.cos() * b.cos(), r * a.sin() * b.cos(), r * b.sin()];
            for accuracy in [1e-4, 1e-10, 1e-13] {
                let (x, y) = (
                    ask(&with, c, 0.1, Accuracy::Length(accuracy)),
                    ask(&without, c, 0.1, Accuracy::Full),
                );
                let (x, y) = (x.separation.bounds, y.separation.bounds);
                assert!(
                    x.lo <= y.hi && y.lo <= x.hi,
                    "{k} {c:?} {accuracy}: {x:?} {y:?}"
                );
            }
        }
    }
}

/// A list of contacts that reaches beyond the far side of a ball: tops of the distance, the pole (one point along a whole border) and seams
/// are no contacts, and hold up no search.
#[test]
fn tops_and_poles_of_a_sphere_are_no_contacts() {
    let ball = sheet(nurbs_sphere(2.5));
    let all = |probe: &Probe| {
        let options = Options {
            contacts: Contacts::All,
            prediction: 100.0,
            node_budget: 4000,
            ..Options::default()
        };
        contact(&ball, probe, &options, &mut Workspace::default())
    };
    let is_alone_at = |answer: &ContactAnswer, at: Vector3<f64>| {
        assert_eq!(answer.undecided, None, "{answer:#?}");
        assert_eq!(answer.contacts.len(), 1, "{answer:#?}");
        let off = (answer.contacts[0].on_brep.coords - at).norm();
        assert!(off < 1e-12, "{off:e}: {answer:#?}");
    };
    for c in [
        [0.7, -0.5, -0.1],
        [0.3, 0.2, 1.1],
        [0.0, 0.5, 0.25],
        [4.0, 3.0, -1.0],
    ] {
        let c = Vector3::from(c);
        let probe = Probe::Sphere(Sphere::new(Point3::from(c), 1.0).unwrap());
        is_alone_at(&all(&probe), c.normalize() * 2.5);
    }
    for n in [[0.6, 0.48, 0.64], [0.0, 0.6, -0.8], [0.0, 0.0, 1.0]] {
        let n = Vector3::from(n);
        let probe = Probe::HalfSpace(HalfSpace::new(n, 0.0).unwrap());
        is_alone_at(&all(&probe), -n * 2.5);
    }
}

/// A trim that ends 2^-52 short of the border of its patch, by less than f64 tells there: what is deepest is on the trim, and neither the border,
/// which nothing of the region is on, nor doubt whether the trim is on the patch widens the answer.
#[test]
fn a_trim_that_hardly_reaches_the_border() {
    // Its top is (y1^2 - y0 y2) / (2 y1 - y0 - y2) = 10 - e / 4 + O(e^2) with y0 = 5 - e, y1 = 15 and y2 = 5.
    let e = 2f64.powi(-50);
    let top = Curve::Nurbs(
        NurbsCurve::new(
            2,
            vec![
                Vector3::new(-5.0, 5.0 - e, 1.0),
                Vector3::new(0.0, 15.0, 1.0),
                Vector3::new(5.0, 5.0, 1.0),
            ],
            vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
        )
        .unwrap(),
    );
    let back: Curve2 = Curve::Line(
        Line::new(
            [5.0, 5.0].into(),
            [-5.0, 5.0 - e].into(),
            Interval::new(0.0, 1.0).unwrap(),
        )
        .unwrap(),
    );
    let brep = crate::scenes::loops::face_within(vec![vec![top, back]]);
    let probe = Probe::HalfSpace(HalfSpace::new(-Vector3::y(), -10.0).unwrap());
    for closed_forms in [true, false] {
        let shortcuts = Shortcuts {
            closed_forms,
            ..Shortcuts::ALL
        };
        let brep = PreparedBrep::with_shortcuts(brep.clone(), shortcuts);
        let answer = contact(
            &brep,
            &probe,
            &Options::default(),
            &mut Workspace::default(),
        );
        assert_eq!(answer.undecided, None, "{answer:?}");
        let bounds = answer.separation.bounds;
        let truth = e / 4.0;
        // What O(e^2) leaves out of the truth, and far above what is asked of separations next to 0: some 2^-100 of the size.
        let slack = 2f64.powi(-90);
        assert!(
            bounds.lo <= truth + slack && truth - slack <= bounds.hi,
            "{bounds:?}"
        );
        assert!(bounds.hi - bounds.lo <= slack, "{bounds:?}");
    }
}

/// A triangle with a side on `x + 3 y = 3`: next to that, within roundings, above the plane by little more.
#[test]
fn feet_within_a_rounding_of_a_side() {
    let mut b = BrepBuilder::new();
    let corners = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|p| b.vertex(p));
    b.planar_face(&corners).unwrap();
    let brep = PreparedBrep::new(b.build().unwrap());
    let mut workspace = Workspace::default();
    for k in 1..64 {
        let y = f64::from(k) / 64.0;
        let on = 3.0 - 3.0 * y;
        for x in [on.next_down(), on.next_up()] {
            for height in [1.0, 2f64.powi(-20), 2f64.powi(-40), 2f64.powi(-50)] {
                let probe = Sphere::new(Point3::new(x, y, height), 0.0).unwrap();
                let probe = Probe::Sphere(probe);
                let answer = contact(&brep, &probe, &Options::default(), &mut workspace);
                assert_eq!(answer.undecided, None, "{probe:?} {answer:?}");
                let beside = (x - on).max(0.0) / 10f64.sqrt();
                let truth = height.hypot(beside);
                let bounds = answer.separation.bounds;
                let slack = if beside == 0.0 {
                    0.0
                } else {
                    4.0 * f64::EPSILON * truth
                };
                assert!(
                    bounds.lo <= truth + slack && truth - slack <= bounds.hi,
                    "{probe:?} {answer:?}"
                );
            }
        }
    }
}

/// A ball about the centre of a round hole, whose rim begins and ends a rounding apart: no place along what joins them is nearer than the rim.
#[test]
fn about_the_centre_of_a_hole() {
    let unit = Interval::new(0.0, 1.0).unwrap();
    let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(Point2::from);
    let outer = polygon(&square);
    for radius in [0.25, 0.3, 0.7] {
        let hole = Arc::new(Arc {
            center: Point2::origin(),
            x: Vector2::x(),
            y: -Vector2::y(),
            z: Vector2::zeros(),
            radius,
            angle: Interval::new(0.0, std::f64::consts::TAU).unwrap(),
            domain: unit,
        });
        let loops = vec![outer.clone(), vec![Curve2::Arc(hole.unwrap())]];
        let brep = face_of(square_plane(1.0), loops);
        let brep = PreparedBrep::new(brep);
        for ball in [0.0, radius / 2.0, radius] {
            let probe = Probe::Sphere(Sphere::new(Point3::origin(), ball).unwrap());
            let mut workspace = Workspace::default();
            let answer = contact(&brep, &probe, &Options::default(), &mut workspace);
            assert_eq!(answer.undecided, None, "{answer:?}");
            assert!(
                answer.separation.bounds.contains(radius - ball),
                "{answer:?}"
            );
        }
    }
}

/// Next to the apex of a pyramid's side (a patch of which one border is a point), as near as numbers tell: the distance is that from the apex, exactly.
#[test]
fn next_to_a_border_that_is_a_point() {
    let at = |x: f64, y: f64, z: f64, w: f64| Vector4::new(x * w, y * w, z * w, w);
    let net = vec![
        at(-3.0, 1.0, 0.0, 1.0),
        at(0.0, 0.0, 4.0, 0.5),
        at(0.0, 2.0, 0.0, 0.75),
        at(0.0, 0.0, 4.0, 1.25),
        at(3.0, 1.0, 0.0, 1.0),
        at(0.0, 0.0, 4.0, 0.75),
    ];
    let knots = [vec![0., 0., 0., 1., 1., 1.], vec![0., 0., 1., 1.]];
    let surface = NurbsSurface::new([2, 1], [3, 2], net, knots).unwrap();
    let brep = sheet(Surface::Nurbs(surface));
    for k in [20, 30, 40, 50] {
        let gap = 2f64.powi(-k);
        for part in [0.0, 0.5, 1.0 - f64::EPSILON] {
            let radius = gap * part;
            let answer = ask(&brep, [0.0, 0.0, 4.0 + gap], radius, Accuracy::Full);
            assert_eq!(
                answer.undecided, None,
                "{k} {part}: {:?}",
                answer.separation
            );
            let bounds = answer.separation.bounds;
            assert!(bounds.contains(gap - radius), "{k} {part}: {bounds:?}");
        }
    }
}

/// `z = x^2 + y^2` from `x = t` on, beside which the nearest point of the whole bowl is: nearer than numbers next to that, but not than numbers next to zero.
/// The nearest point is `(t, 0)`.
#[test]
fn feet_beside_a_trim_next_to_a_border() {
    let (linear, square) = ([-1.0, 0.0, 1.0], [1.0, -1.0, 1.0]);
    let (along, raised) = ([0.0, 0.5, 1.0], [0.0, 0.0, 1.0]);
    let net = (0..9).map(|k| {
        let (i, j) = (k / 3, k % 3);
        Vector4::new(along[i], linear[j], raised[i] + square[j], 1.0)
    });
    let knots = [
        vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
        vec![-1.0, -1.0, -1.0, 1.0, 1.0, 1.0],
    ];
    let surface = NurbsSurface::new([2, 2], [3, 3], net.collect(), knots).unwrap();
    for t in [2f64.powi(-54), 2f64.powi(-58)] {
        let corners = [[t, -1.0], [1.0, -1.0], [1.0, 0.75], [0.75, 1.0], [t, 1.0]];
        let brep = crate::scenes::polygon_face(
            &Surface::Nurbs(surface.clone()),
            &corners.map(Point2::from),
        );
        for k in [36, 40] {
            let gap = 2f64.powi(-k);
            let answer = ask(&brep, [0.0, 0.0, -gap], gap, Accuracy::Full);
            assert_eq!(answer.undecided, None, "{t} {k}: {:?}", answer.separation);
            let bounds = answer.separation.bounds;
            let up = &(&exact(t) * &exact(t)) + &exact(gap);
            let truth = &(&exact(t) * &exact(t)) + &(&up * &up);
            let [lo, hi] = [bounds.lo, bounds.hi].map(|x| &exact(x) + &exact(gap));
            assert_distance(&truth, 0.0, &lo, &hi, true);
        }
    }
}
