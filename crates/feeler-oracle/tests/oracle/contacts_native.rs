//! All contacts with native surfaces: against what geometry says, and against the same parts as NURBS.

use crate::scene;
use crate::scene::contacts::{must_be, near, one_continuum};
use crate::scene::{Random, brep, interval, plane};
use feeler::brep::Brep;
use feeler::nurbs::{Arc, Curve2, Curve3, Line, PolyCurve, Revolution, Sum, Surface};
use feeler::query::{HalfSpace, Probe, Sphere};
use feeler_oracle::{ContactsTruth, Oracle};
use nalgebra::{Point2, Point3, Vector2, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn ask(b: &Brep, center: [f64; 3], prediction: f64) -> ContactsTruth {
    let probe = Probe::Sphere(Sphere::new(Point3::from(center), 0.0).unwrap());
    Oracle::new(&[b])
        .unwrap()
        .contacts(&probe, prediction)
        .unwrap()
}

fn lean(b: &Brep, normal: [f64; 3], prediction: f64) -> ContactsTruth {
    let probe = Probe::HalfSpace(HalfSpace::new(Vector3::from(normal), 0.0).unwrap());
    Oracle::new(&[b])
        .unwrap()
        .contacts(&probe, prediction)
        .unwrap()
}

fn line3(a: [f64; 3], b: [f64; 3]) -> Curve3 {
    Curve3::Line(Line::new(Point3::from(a), Point3::from(b), interval(0.0, 1.0)).unwrap())
}

fn arc3(center: [f64; 3], y: [f64; 3], radius: f64, turn: [f64; 2]) -> Curve3 {
    let (x, y) = (Vector3::x(), Vector3::from(y));
    Curve3::Arc(
        Arc::new(Arc {
            center: Point3::from(center),
            x,
            y,
            z: x.cross(&y),
            radius,
            angle: interval(turn[0], turn[1]),
            domain: interval(turn[0], turn[1]),
        })
        .unwrap(),
    )
}

fn circle2(center: [f64; 2], radius: f64) -> Curve2 {
    Curve2::Arc(
        Arc::new(Arc {
            center: Point2::from(center),
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
            radius,
            angle: interval(0.0, TAU),
            domain: interval(0.0, TAU),
        })
        .unwrap(),
    )
}

fn revolved(profile: Curve3, transposed: bool) -> Brep {
    let turn = interval(0.0, TAU);
    let surface = Surface::Revolution(
        Revolution::new(Revolution {
            origin: Point3::origin(),
            axis: Vector3::new(0.0, 0.0, 3.0),
            angle: turn,
            angle_domain: turn,
            profile,
            transposed,
        })
        .unwrap(),
    );
    brep(surface, None)
}

/// A meridian in the plane y = 0, by angles from x towards z.
fn meridian(center: f64, radius: f64, turn: [f64; 2]) -> Curve3 {
    arc3([center, 0.0, 0.0], [0.0, 0.0, 1.0], radius, turn)
}

#[test]
fn a_sphere() {
    for transposed in [false, true] {
        let ball = revolved(meridian(0.0, 2.5, [-FRAC_PI_2, FRAC_PI_2]), transposed);
        // From outside and from inside: the nearest point, and no other minimum.
        must_be(
            &ask(&ball, [3.0, 4.0, 0.0], 20.0),
            &[([1.5, 2.0, 0.0], 2.5)],
        );
        must_be(
            &ask(&ball, [0.6, 0.8, 0.0], 20.0),
            &[([1.5, 2.0, 0.0], 1.5)],
        );
        must_be(&ask(&ball, [0.0, 1.0, 0.0], 1.0), &[]);
        // On the seam, across it, and at the poles.
        must_be(
            &ask(&ball, [1.0, 0.0, 0.0], 20.0),
            &[([2.5, 0.0, 0.0], 1.5)],
        );
        must_be(
            &ask(&ball, [3.0, 0.0, 4.0], 20.0),
            &[([1.5, 0.0, 2.0], 2.5)],
        );
        must_be(
            &ask(&ball, [0.0, 0.0, 1.0], 20.0),
            &[([0.0, 0.0, 2.5], 1.5)],
        );
        must_be(
            &ask(&ball, [0.0, 0.0, -4.0], 20.0),
            &[([0.0, 0.0, -2.5], 1.5)],
        );
        for off in [1e-5, 1e-8, 1e-11, 1e-14, -1e-5, -1e-8, -1e-11] {
            let found = ask(&ball, [3.0, off, 4.0], 20.0);
            assert_eq!(found.contacts.len(), 1, "{off}: {found:#?}");
            assert!(found.contacts[0].proven, "{off}: {found:#?}");
            // Next to a pole what is near may stay unsettled; at farther ends nothing does.
            let found = ask(&ball, [off, 0.0, 4.0], 20.0);
            let proven: Vec<_> = found.contacts.iter().filter(|c| c.proven).collect();
            assert_eq!(proven.len(), 1, "{off}: {found:#?}");
            let all = found.contacts.iter();
            let foot = [0.625 * off, 0.0, 2.5];
            assert!(all.clone().all(|c| near(&c.at, foot, 1e-5)), "{found:#?}");
        }
        one_continuum(&ask(&ball, [0.0; 3], 20.0));
        must_be(
            &lean(&ball, [0.6, 0.0, 0.8], 20.0),
            &[([-1.5, 0.0, -2.0], -2.5)],
        );
        must_be(
            &lean(&ball, [0.0, 0.0, 1.0], 20.0),
            &[([0.0, 0.0, -2.5], -2.5)],
        );
    }
}

#[test]
fn a_cylinder() {
    let tube = revolved(line3([2.0, 0.0, 0.0], [2.0, 0.0, 3.0]), false);
    must_be(
        &ask(&tube, [0.6, 0.8, 1.0], 20.0),
        &[([1.2, 1.6, 1.0], 1.0)],
    );
    must_be(
        &ask(&tube, [3.0, 4.0, 1.0], 20.0),
        &[([1.2, 1.6, 1.0], 3.0)],
    );
    must_be(
        &ask(&tube, [1.0, 0.0, 1.0], 20.0),
        &[([2.0, 0.0, 1.0], 1.0)],
    );
    // Its rim, from above the wall, from inside and on the seam.
    must_be(
        &ask(&tube, [3.0, 4.0, 7.0], 20.0),
        &[([1.2, 1.6, 3.0], 5.0)],
    );
    must_be(
        &ask(&tube, [-0.6, 0.8, 4.0], 20.0),
        &[([-1.2, 1.6, 3.0], 2f64.sqrt())],
    );
    must_be(
        &ask(&tube, [1.0, 0.0, 4.0], 20.0),
        &[([2.0, 0.0, 3.0], 2f64.sqrt())],
    );
    // On the axis: a circle, inside and beyond the end.
    one_continuum(&ask(&tube, [0.0, 0.0, 1.0], 20.0));
    one_continuum(&ask(&tube, [0.0, 0.0, 5.0], 20.0));
    must_be(
        &lean(&tube, [0.0, 0.6, 0.8], 20.0),
        &[([0.0, -2.0, 0.0], -1.2)],
    );
    // A line of support.
    one_continuum(&lean(&tube, [0.6, 0.8, 0.0], 20.0));
}

#[test]
fn a_cone() {
    let cone = revolved(line3([0.0; 3], [3.0, 0.0, 4.0]), false);
    // The tip, from below; around it nothing is nearer.
    let found = ask(&cone, [0.0, 0.0, -1.0], 4.0);
    must_be(&found, &[([0.0; 3], 1.0)]);
    must_be(
        &ask(&cone, [0.1, 0.2, -1.0], 20.0),
        &[([0.0; 3], 1.05f64.sqrt())],
    );
    // Inside: the wall, and not the one across. Its foot is 2.2 from the tip along the wall.
    must_be(
        &ask(&cone, [0.6, 0.8, 2.0], 20.0),
        &[([0.792, 1.056, 1.76], 0.4)],
    );
    must_be(
        &ask(&cone, [1.0, 0.0, 2.0], 20.0),
        &[([1.32, 0.0, 1.76], 0.4)],
    );
    one_continuum(&ask(&cone, [0.0, 0.0, 2.0], 20.0));
    must_be(&lean(&cone, [0.0, 0.0, 1.0], 2.0), &[([0.0; 3], 0.0)]);
}

#[test]
fn a_torus() {
    let ring = revolved(meridian(3.0, 1.0, [0.0, TAU]), false);
    must_be(
        &ask(&ring, [6.0, 8.0, 0.0], 20.0),
        &[([2.4, 3.2, 0.0], 6.0)],
    );
    // Where both seams meet, and on one of them.
    must_be(
        &ask(&ring, [5.0, 0.0, 0.0], 20.0),
        &[([4.0, 0.0, 0.0], 1.0)],
    );
    must_be(
        &ask(&ring, [0.5, 0.0, 0.0], 20.0),
        &[([2.0, 0.0, 0.0], 1.5)],
    );
    must_be(
        &ask(&ring, [3.0, 0.0, 0.25], 20.0),
        &[([3.0, 0.0, 1.0], 0.75)],
    );
    must_be(
        &ask(&ring, [1.8, 2.4, 2.0], 20.0),
        &[([1.8, 2.4, 1.0], 1.0)],
    );
    // On the axis a circle, on the spine another.
    one_continuum(&ask(&ring, [0.0, 0.0, 0.5], 20.0));
    one_continuum(&ask(&ring, [1.8, 2.4, 0.0], 20.0));
    one_continuum(&lean(&ring, [0.0, 0.0, 1.0], 20.0));
    must_be(
        &lean(&ring, [0.6, 0.0, 0.8], 20.0),
        &[([-3.6, 0.0, -0.8], -2.8)],
    );
}

/// A circle swept along a line, and a poly-curve whose segments meet but for rounding.
#[test]
fn sums_and_poly_curves() {
    let sum = brep(
        Surface::Sum(Sum {
            base: Vector3::new(0.0, 0.0, 0.0),
            first: arc3([0.0; 3], [0.0, 1.0, 0.0], 2.0, [0.0, PI]),
            second: line3([0.0; 3], [0.0, 0.0, 3.0]),
        }),
        None,
    );
    must_be(&ask(&sum, [0.0, 5.0, 1.0], 20.0), &[([0.0, 2.0, 1.0], 3.0)]);
    must_be(&ask(&sum, [0.6, 0.8, 1.0], 20.0), &[([1.2, 1.6, 1.0], 1.0)]);
    // Below the half tube both borders are near, and no minimum lies between.
    must_be(
        &ask(&sum, [0.0, -1.0, 1.0], 20.0),
        &[
            ([2.0, 0.0, 1.0], 5f64.sqrt()),
            ([-2.0, 0.0, 1.0], 5f64.sqrt()),
        ],
    );
    // The third part of a turn, twice and more: a tube and its rounded end.
    let profile = Curve3::Poly(
        PolyCurve::new(
            vec![
                line3([2.0, 0.0, -3.0], [2.0, 0.0, 0.0]),
                arc3([0.0, 0.0, 1e-16], [0.0, 0.0, 1.0], 2.0, [0.0, FRAC_PI_2]),
            ],
            vec![0.0, 1.0, 2.0],
        )
        .unwrap(),
    );
    let tube = revolved(profile, false);
    must_be(
        &ask(&tube, [0.6, 0.8, -1.0], 20.0),
        &[([1.2, 1.6, -1.0], 1.0)],
    );
    must_be(
        &ask(&tube, [3.0, 4.0, 0.0], 20.0),
        &[([1.2, 1.6, 0.0], 3.0)],
    );
    must_be(&ask(&tube, [0.0, 0.0, 5.0], 4.0), &[([0.0, 0.0, 2.0], 3.0)]);
}

/// A plate whose border is one circle, and a plate with a round hole.
#[test]
fn plates_trimmed_by_circles() {
    let disc = brep(plane(4.0), Some(vec![vec![circle2([0.0; 2], 2.5)]]));
    must_be(
        &ask(&disc, [0.6, 0.8, 1.0], 20.0),
        &[([0.6, 0.8, 0.0], 1.0)],
    );
    must_be(
        &ask(&disc, [6.0, 8.0, 1.0], 20.0),
        &[([1.5, 2.0, 0.0], (56.25f64 + 1.0).sqrt())],
    );
    must_be(
        &ask(&disc, [6.0, 0.0, 0.0], 20.0),
        &[([2.5, 0.0, 0.0], 3.5)],
    );
    must_be(
        &lean(&disc, [0.6, 0.8, 0.0], 20.0),
        &[([-1.5, -2.0, 0.0], -2.5)],
    );
    let hole = brep(
        plane(4.0),
        Some(vec![
            scene::polygon(&[[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]]),
            vec![circle2([0.0; 2], 2.5)],
        ]),
    );
    must_be(
        &ask(&hole, [0.6, 0.8, 0.5], 20.0),
        &[([1.5, 2.0, 0.0], 2.5f64.sqrt())],
    );
    one_continuum(&ask(&hole, [0.0, 0.0, 0.5], 20.0));
}

fn part(path: &str) -> Vec<Brep> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../corpora/models")
        .join(path);
    feeler_corpus::Model::load(&path, None).unwrap().breps
}

/// The same lists for a part and for its twin of NURBS faces, which are quadrics and tori up to their own rounding.
#[test]
fn twins() {
    let mut random = Random(5);
    let (mut compared, mut single, mut left) = (0, 0, 0);
    for (name, center, reach) in [
        ("cylinder", [0.0; 3], 3.0),
        ("cylinder_slanted", [0.0; 3], 3.0),
        ("frustum", [0.0; 3], 3.0),
        ("sphere", [0.0; 3], 3.0),
        ("torus", [0.0; 3], 4.0),
    ] {
        let native = part(&format!("analytic/{name}.json.gz"));
        let nurbs = part(&format!("analytic/{name}_nurbs.json.gz"));
        let [a, b] =
            [&native, &nurbs].map(|all| Oracle::new(&all.iter().collect::<Vec<_>>()).unwrap());
        for _ in 0..40 {
            let at: [f64; 3] = std::array::from_fn(|k| center[k] + random.range(-reach, reach));
            let probe = Probe::Sphere(Sphere::new(Point3::from(at), 0.0).unwrap());
            let (Ok(x), Ok(y)) = (a.contacts(&probe, 1.0), b.contacts(&probe, 1.0)) else {
                left += 1;
                continue;
            };
            for (x, y) in [(&x, &y), (&y, &x)] {
                for c in x
                    .contacts
                    .iter()
                    .filter(|c| c.proven && c.within && !c.continuum)
                {
                    // Within the prediction by more than rounding.
                    if c.separation.hi.approximate() > 1.0 - 1e-9 {
                        continue;
                    }
                    let middle = c.at.map(|x| 0.5 * (x[0] + x[1]));
                    let same = y.contacts.iter().find(|o| near(&o.at, middle, 1e-6));
                    let same = same.unwrap_or_else(|| panic!("{name} {at:?}: {x:#?} {y:#?}"));
                    let off = &c.separation.lo - &same.separation.lo;
                    assert!(
                        off.approximate().abs() < 1e-13,
                        "{name} {at:?}: {c:?} {same:?}"
                    );
                    compared += 1;
                }
            }
            single += usize::from(x.contacts.len() == 1);
        }
    }
    println!("{compared} compared, {single} lists of one, {left} without a side");
    assert!(compared > 100 && left < 5);
}
