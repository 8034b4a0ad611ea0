//! Solids of `.brep` with extruded and turned ellipses, hyperbolas and parabolas (`corpora/make_brep.py`), against analysis.

use feeler::brep::Severity;
use feeler::prepare::PreparedBrep;
use feeler::query::*;
use feeler::trim::Side;
use feeler_io::{ObjectKind, read_file};
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use std::path::Path;

fn parts() -> Vec<PreparedBrep> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/brep/conics.brep");
    let document = read_file(path).expect("a file of the corpus");
    let breps = document.objects.into_iter().map(|o| match o.kind {
        ObjectKind::Brep(brep) => PreparedBrep::new(brep),
        other => panic!("{other:?}"),
    });
    breps.collect()
}

/// They stand side by side.
const APART: f64 = 12.0;

/// Above a plane through (0, 0, 3) that is turned by 0.4 about (1, 2, 0).
fn is_above(p: &Point3<f64>) -> bool {
    let axis = Unit::new_normalize(Vector3::new(1.0, 2.0, 0.0));
    let back = Rotation3::from_axis_angle(&axis, -0.4);
    (back * (p - Point3::new(0.0, 0.0, 3.0))).z > 0.0
}

/// On the left of a line from one point to another.
fn is_left(x: f64, y: f64, [a, b]: [[f64; 2]; 2]) -> bool {
    (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) > 0.0
}

/// Whether a point is in part `k`, as they are made.
fn is_in(k: usize, p: &Point3<f64>) -> bool {
    let [x, y, z] = [p.x, p.y, p.z];
    let high = 0.0 < z && z < 4.0;
    let on_hyperbola = |t: f64| [t.cosh(), 2.0 * t.sinh()];
    let on_parabola = |t: f64| [t * t / 3.0, t];
    let ellipse = (x / 3.0).powi(2) + (y / 1.5).powi(2) < 1.0;
    let hyperbola = |r: f64| x > (1.0 + (0.5 * r).powi(2)).sqrt();
    let parabola = |r: f64| 3.0 * x > r * r;
    let r = y.hypot(z);
    match k {
        0 => ellipse && high,
        1 => ellipse && high && !is_above(p),
        2 => ellipse && high && !(x > 0.0 && (y - 0.3).hypot(z - 2.0) < 0.6),
        3 => hyperbola(y) && high && is_left(x, y, [on_hyperbola(-1.0), on_hyperbola(1.2)]),
        4 => is_in(3, p) && !is_above(p),
        5 => parabola(y) && high && is_left(x, y, [on_parabola(-2.0), on_parabola(3.0)]),
        6 => (x / 3.0).powi(2) + (r / 1.5).powi(2) < 1.0,
        7 => hyperbola(r) && x < 1.2_f64.cosh(),
        8 => parabola(r) && x < 3.0,
        _ => {
            let within = 3.0 * 2.5_f64.cos() < x && x < 3.0 * 0.5_f64.cos();
            within && (y + 4.0).hypot(z) < 4.0 + 1.5 * (1.0 - (x / 3.0).powi(2)).sqrt()
        }
    }
}

/// Sides of a grid of points, but of those within a thousandth or so of a border.
#[test]
fn sides_are_those_of_the_conics() {
    let parts = parts();
    assert_eq!(parts.len(), 10);
    let mut workspace = Workspace::default();
    for (k, part) in parts.iter().enumerate() {
        assert!(part.brep().is_closed());
        for d in part.brep().defects() {
            assert!(d.severity() <= Severity::Note, "{k}: {d}");
        }
        let mut counts = [0; 2];
        for i in 0..23 {
            for j in 0..17 {
                for l in 0..11 {
                    let [a, b, c] = [i, j, l].map(f64::from);
                    let low = if k == 9 { -10.0 } else { -3.5 };
                    let deep = if k >= 6 { -low } else { 4.5 };
                    let p = Point3::new(
                        -3.3 + 0.31 * a,
                        low + (3.5 - low) * (b + 0.3) / 17.0,
                        -0.41 + (deep + 0.41) * c / 11.0,
                    );
                    let near = 1e-3;
                    let about = [
                        Vector3::x() * near,
                        Vector3::x() * -near,
                        Vector3::y() * near,
                        Vector3::y() * -near,
                        Vector3::z() * near,
                        Vector3::z() * -near,
                    ];
                    let known = is_in(k, &p);
                    if about.iter().any(|d| is_in(k, &(p + d)) != known) {
                        continue;
                    }
                    counts[usize::from(known)] += 1;
                    let side = match known {
                        true => Side::Inside,
                        false => Side::Outside,
                    };
                    let q = p + Vector3::x() * (APART * k as f64);
                    let found = inside(part, q, &mut workspace).side;
                    assert_eq!(found, Some(side), "{k}, {p}");
                }
            }
        }
        assert!(counts[0] > 500 && counts[1] > 100, "{k}: {counts:?}");
    }
}

/// Balls about points of the axis of the turned ellipse: the nearest points of a spheroid are known from its meridian, the least of a function of one angle
/// of which `(a^2 - b^2) cos t = a x` is the derivative's zero.
#[test]
fn distances_inside_a_spheroid() {
    let part = &parts()[6];
    let mut workspace = Workspace::default();
    let (a, b) = (3.0_f64, 1.5_f64);
    for k in 0..=20 {
        let x = -2.0 + 0.2 * f64::from(k);
        let cos = a * x / (a * a - b * b);
        let known = (a * cos - x).hypot(b * (1.0 - cos * cos).sqrt());
        let q = Point3::new(x + 6.0 * APART, 0.0, 0.0);
        let probe = Probe::Sphere(Sphere::new(q, 0.0).expect("a point"));
        let found = contact(part, &probe, &Options::default(), &mut workspace).separation;
        assert!(
            (found.value + known).abs() < 1e-13,
            "{x}: {found:?}, {known}"
        );
    }
}
