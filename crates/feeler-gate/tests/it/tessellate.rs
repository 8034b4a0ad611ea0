//! Triangles that stand for faces: closed where the BREP is, as near to it as was asked.

use feeler::prepare::PreparedBrep;
use feeler::query;
use feeler::trim::Side;
use feeler_corpus::Model;
use feeler_gate::tessellate::{Mesh, Rule, tessellate};
use nalgebra::{Point2, Vector3};
use std::f64::consts::PI;
use std::path::PathBuf;

fn models() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../corpora/models"))
}

fn cut(name: &str, degrees: f64, chord: f64) -> Mesh {
    let model = Model::load(&models().join(name), None).unwrap();
    tessellate(&model.breps[0], &Rule { degrees, chord }).unwrap()
}

fn by_angle(name: &str, degrees: f64) -> Mesh {
    cut(name, degrees, f64::INFINITY)
}

/// The prism over a regular polygon with a corner each `degrees` on a circle.
fn prism(radius: f64, height: f64, degrees: f64) -> f64 {
    let corners = 360.0 / degrees;
    corners / 2.0 * radius * radius * (2.0 * PI / corners).sin() * height
}

#[test]
fn a_cylinder_becomes_the_prism_inside() {
    for degrees in [30.0, 10.0, 3.0] {
        let mesh = by_angle("analytic/cylinder.json.gz", degrees);
        let expected = prism(1.5, 5.0, degrees);
        let volume = mesh.volume();
        assert!(
            (volume - expected).abs() < 1e-10,
            "{degrees}: {volume} {expected}"
        );
        // Its sagitta is its distance from the cylinder.
        let sagitta = 1.5 * (1.0 - (degrees / 2.0).to_radians().cos());
        let error = mesh.chord_error;
        assert!(
            (error - sagitta).abs() < 1e-10,
            "{degrees}: {error} {sagitta}"
        );
        // Two caps of n - 2 triangles, and 2 n on the side.
        assert_eq!(mesh.triangles.len(), 4 * (360.0 / degrees) as usize - 4);
    }
}

#[test]
fn a_ball_converges_with_the_square_of_the_angle() {
    let mut before: Option<f64> = None;
    for degrees in [10.0, 5.0, 2.5] {
        let mesh = by_angle("analytic/sphere_nurbs.json.gz", degrees);
        let lost = 4.0 / 3.0 * PI * 8.0 - mesh.volume();
        assert!(lost > 0.0);
        if let Some(before) = before {
            assert!((3.8..4.2).contains(&(before / lost)), "{before} {lost}");
        }
        before = Some(lost);
        // All corners lie on the ball, and no triangle is nearer to its centre than the mesh says.
        let at = |i: u32| Vector3::from(mesh.vertices[i as usize]);
        let center = Vector3::new(0.5, -0.25, 1.0);
        for t in &mesh.triangles {
            let corners = t.map(|i| at(i) - center);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            assert!(corners.iter().all(|c| (c.norm() - 2.0).abs() < 1e-12));
            assert!(2.0 - middle.norm() <= mesh.chord_error * 1.1);
        }
    }
}

/// A cube of side 10 without the corner cut off 4 from it.
#[test]
fn flat_faces_are_exact() {
    for name in ["cube_corner_cut.3dm", "cube_corner_cut_nurbs.3dm"] {
        let mesh = by_angle(&format!("thesis/{name}"), 180.0);
        assert!((mesh.volume() - (1000.0 - 64.0 / 6.0)).abs() < 1e-9);
        assert_eq!(mesh.triangles.len(), 16);
    }
}

/// The cube with the corner points of its socket's patches, as coarse as the coarsest mesh of the thesis.
#[test]
fn the_coarsest_ball_joint_has_20_triangles() {
    let mesh = by_angle("thesis/ball_joint_cavity.3dm", 180.0);
    assert_eq!((mesh.triangles.len(), mesh.open_edges()), (20, 0));
}

#[test]
fn closed_parts_give_closed_meshes() {
    let mut parts = 0;
    for folder in ["thesis", "analytic", "parts"] {
        for entry in std::fs::read_dir(models().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let model = Model::load(&path, None).unwrap();
            for brep in model.breps.iter().filter(|b| b.is_closed()) {
                for degrees in [30.0, 10.0] {
                    let chord = f64::INFINITY;
                    let mesh = tessellate(brep, &Rule { degrees, chord }).unwrap();
                    assert_eq!(mesh.open_edges(), 0, "{} {degrees}", path.display());
                    assert!(mesh.volume() > 0.0, "{} {degrees}", path.display());
                }
                parts += 1;
            }
        }
    }
    assert!(parts > 50);
}

#[test]
fn chords_stay_within_what_is_asked() {
    for name in [
        "analytic/sphere.json.gz",
        "analytic/torus_nurbs.json.gz",
        "analytic/frustum.json.gz",
        "parts/spline_plate.json.gz",
        "parts/twisted_prism.json.gz",
        "parts/vase.json.gz",
        "stress/saddle.json.gz",
    ] {
        for chord in [0.05, 0.005] {
            let mesh = cut(name, 180.0, chord);
            let error = mesh.chord_error;
            assert!(error <= chord, "{name}: {error} of {chord}");
            // Not finer by an order of magnitude in length either.
            assert!(error >= chord / 100.0, "{name}: {error} of {chord}");
        }
    }
}

/// On flat faces with straight trims a point is in a triangle exactly if the kernel, which is exact there, says that it
/// is inside.
#[test]
fn trims_are_respected() {
    for name in [
        "islands_squares",
        "figure_eight",
        "pentagram",
        "overlapping_loops",
        "overlapping_spiral",
        "hole_touches_outer",
        "comb_128",
        "polygon_1024",
    ] {
        let name = format!("trim-loops/{name}.json.gz");
        let model = Model::load(&models().join(&name), None).unwrap();
        let brep = &model.breps[0];
        let mesh = by_angle(&name, 10.0);
        let prepared = PreparedBrep::new(brep.clone());
        let [u, v] = brep.surface(0).domain();
        // A lattice of irrational slope.
        const POINTS: usize = 2000;
        let golden = 0.5 * (5.0f64.sqrt() - 1.0);
        let mut inside = 0;
        for i in 0..POINTS {
            let at = [
                (i as f64 + 0.5) / POINTS as f64,
                (i as f64 * golden).fract(),
            ];
            let uv = Point2::new(u.lerp(at[0]), v.lerp(at[1]));
            let side = query::side(&prepared, 0, uv).unwrap().side.unwrap();
            let p = brep.surface(0).point(uv.x, uv.y);
            let covered = mesh.triangles.iter().any(|t| contains(&mesh, t, &p.coords));
            assert_eq!(covered, side == Side::Inside, "{name} {uv}");
            inside += usize::from(covered);
        }
        assert!(inside > 100 && inside < POINTS - 10, "{name} {inside}");
    }
}

/// Whether a point of the plane of a triangle is in it.
fn contains(mesh: &Mesh, triangle: &[u32; 3], p: &Vector3<f64>) -> bool {
    let [a, b, c] = triangle.map(|i| Vector3::from(mesh.vertices[i as usize]));
    let n = (b - a).cross(&(c - a));
    let left = |a: Vector3<f64>, b: Vector3<f64>| (b - a).cross(&(p - a)).dot(&n) >= 0.0;
    left(a, b) && left(b, c) && left(c, a)
}

#[test]
fn rules_that_are_none_are_refused() {
    let model = Model::load(&models().join("analytic/sphere.json.gz"), None).unwrap();
    for (degrees, chord) in [(0.0, 1.0), (f64::NAN, 1.0), (10.0, 0.0), (1e-3, 1.0)] {
        assert!(tessellate(&model.breps[0], &Rule { degrees, chord }).is_err());
    }
}
