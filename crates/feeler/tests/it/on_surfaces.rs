//! Balls whose centre is exactly on a surface.

use crate::scenes::Random;
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve3, Line, NurbsSurface, Revolution, Surface};
use feeler::prepare::PreparedBrep;
use feeler::query::{Accuracy, Options, Probe, Sphere, Workspace, contact};
use nalgebra::{Point3, Vector3, Vector4};

/// The centre of a ball exactly on a surface: the normal is the face's, not a direction of roundings.
#[test]
fn normals_on_surfaces() {
    /// The ring at a pole of the sphere of radius 5: 5 cos(PI / 2) as f64 has it is 3.1e-16, and its centre's coordinates are rounded.
    const RING: f64 = 1e-15;
    let mut bad = Vec::new();
    let mut ask = |what: &str, brep: &PreparedBrep, p: Point3<f64>, n: Vector3<f64>| {
        let is_ring = what == "globe" && p.x == 0. && p.y == 0.;
        for accuracy in [Accuracy::Full, Accuracy::Length(1e-9)] {
            let ball = Probe::Sphere(Sphere::new(p, 0.5).unwrap());
            let a = contact(
                brep,
                &ball,
                &Options {
                    accuracy,
                    ..Options::default()
                },
                &mut Workspace::default(),
            );
            let c = &a.contacts[0];
            // A pole whose angle is the f64 next to a right one is a ring: its middle is not on the surface, and where that is told the nearest point of the ring
            // has the normal.
            let to_ring = p - c.on_brep;
            let is_off = is_ring && c.separation.bounds.lo > -0.5;
            let n = if is_off { to_ring } else { n };
            if (c.normal - n.normalize()).norm() > 1e-6 || is_off && to_ring.norm() > RING {
                bad.push(format!("{what} {accuracy:?} {p}: {c:?}"));
            }
        }
    };
    let mut r = Random::new(12);
    // z = x y over [0, 3]^2, and of degree two, z = x^2 - y.
    let knots = || vec![0., 0., 1., 1.];
    let k2 = || vec![0., 0., 0., 1., 1., 1.];
    let net = vec![
        Vector4::new(0., 0., 0., 1.),
        Vector4::new(0., 3., 0., 1.),
        Vector4::new(3., 0., 0., 1.),
        Vector4::new(3., 3., 9., 1.),
    ];
    let s = NurbsSurface::new([1, 1], [2, 2], net, [knots(), knots()]).unwrap();
    let saddle = PreparedBrep::new(feeler::brep::Brep::from_surface(Surface::Nurbs(s)).unwrap());
    let mut net = Vec::new();
    for (x, z) in [(0., 0.), (1.5, 0.), (3., 9.)] {
        for y in [0., 3.] {
            net.push(Vector4::new(x, y, z - y, 1.));
        }
    }
    let s = NurbsSurface::new([2, 1], [3, 2], net, [k2(), knots()]).unwrap();
    let gutter = PreparedBrep::new(feeler::brep::Brep::from_surface(Surface::Nurbs(s)).unwrap());
    for _ in 0..200 {
        let (x, y) = (r.below(768) as f64 / 256., r.below(768) as f64 / 256.);
        if x == 0. || y == 0. {
            continue;
        }
        ask(
            "saddle",
            &saddle,
            Point3::new(x, y, x * y),
            Vector3::new(-y, -x, 1.),
        );
        ask(
            "gutter",
            &gutter,
            Point3::new(x, y, x * x - y),
            Vector3::new(-2. * x, 1., 1.),
        );
    }
    let tau = std::f64::consts::TAU;
    let unit = Interval::new(0., 1.).unwrap();
    let angle = Interval::new(0., tau).unwrap();
    let turned = |profile: Curve3| {
        let s = Surface::Revolution(
            Revolution::new(Revolution {
                origin: Point3::origin(),
                axis: Vector3::z(),
                angle,
                angle_domain: angle,
                profile,
                transposed: false,
            })
            .unwrap(),
        );
        PreparedBrep::new(feeler::brep::Brep::from_surface(s).unwrap())
    };
    let tube = turned(Curve3::Line(
        Line::new(Point3::new(5., 0., 0.), Point3::new(5., 0., 3.), unit).unwrap(),
    ));
    let cone = turned(Curve3::Line(
        Line::new(Point3::new(0., 0., 0.), Point3::new(10., 0., 10.), unit).unwrap(),
    ));
    let half = Interval::new(-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2).unwrap();
    let globe = turned(Curve3::Arc(
        Arc::new(Arc {
            center: Point3::origin(),
            x: Vector3::x(),
            y: Vector3::z(),
            z: -Vector3::y(),
            radius: 5.,
            angle: half,
            domain: half,
        })
        .unwrap(),
    ));
    for [a, b] in [
        [3., 4.],
        [-3., 4.],
        [4., -3.],
        [-4., -3.],
        [0., 5.],
        [-5., 0.],
    ] {
        for z in [0.5, 1.0, 0.3, 2.7] {
            ask("tube", &tube, Point3::new(a, b, z), Vector3::new(a, b, 0.));
        }
        ask(
            "cone",
            &cone,
            Point3::new(a, b, 5.),
            Vector3::new(a, b, -5.),
        );
        ask(
            "globe",
            &globe,
            Point3::new(a, b, 0.),
            Vector3::new(a, b, 0.),
        );
        ask(
            "globe",
            &globe,
            Point3::new(a, 0., b),
            Vector3::new(a, 0., b),
        );
        ask(
            "globe",
            &globe,
            Point3::new(0., a, b),
            Vector3::new(0., a, b),
        );
    }
    assert!(bad.is_empty(), "{bad:#?}");
}
