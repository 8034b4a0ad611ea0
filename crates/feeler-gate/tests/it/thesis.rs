//! The thesis's algorithms on the thesis's scenes: first where they succeed, then where they are known to fail.
//! Expectations are from geometry.

use feeler_corpus::{Body, Model, QueryLine};
use feeler_gate::{Engine, ThesisEngine};
use std::path::Path;

fn load(name: &str) -> Model {
    let models = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../corpora/models"));
    Model::load(&models.join(name), None).unwrap()
}

fn engine(name: &str, starts: usize) -> ThesisEngine {
    let mut engine = ThesisEngine::new(starts);
    engine.open(&load(name)).unwrap();
    engine
}

fn ask(engine: &mut ThesisEngine, line: &str) -> Body {
    let query = QueryLine::parse(line).unwrap().query().unwrap();
    assert!(engine.treats(&query));
    engine.answer(&query).body
}

fn separation(engine: &mut ThesisEngine, line: &str) -> f64 {
    match ask(engine, line) {
        Body::Contact { separation, .. } => separation.value,
        other => panic!("{other:?}"),
    }
}

fn ball(center: [f64; 3], radius: f64) -> String {
    format!(r#"{{"sphere":{{"center":{center:?},"radius":{radius}}}}}"#)
}

/// Newton settles where the gradient is 1e-12 of its factors, in a socket of radius 2.5; distances are stationary
/// there, and hence better by far than this.
const SETTLED: f64 = 1e-9;

/// The hole's radius is 2.5. Centred balls of Table 1, and one that rests 0.028 off the centre towards the side from
/// which Newton starts.
#[test]
fn balls_in_the_socket() {
    for part in ["cavity", "cavity_nurbs", "socket", "socket_nurbs"] {
        for starts in [1, 100] {
            let mut engine = engine(&format!("thesis/ball_joint_{part}.3dm"), starts);
            for (center, radius) in [
                ([0.0, 0.0, 0.0], 2.472),
                ([0.0, 0.0, 0.0], 2.51),
                ([-0.028, 0.0, 0.0], 2.472),
                ([-0.028, 0.0, 0.0], 2.5),
                ([-0.02, 0.01, 0.0], 2.5),
            ] {
                let off = center.iter().map(|x| x * x).sum::<f64>().sqrt();
                let found = separation(&mut engine, &ball(center, radius));
                let error = found - (2.5 - off - radius);
                assert!(error.abs() < SETTLED, "{part} {starts} {center:?}: {error}");
            }
        }
    }
}

/// A plane's lowest point on a polyhedron is a corner.
#[test]
fn a_cube_with_planes() {
    for name in [
        "thesis/cube_corner_cut.3dm",
        "thesis/cube_corner_cut_nurbs.3dm",
    ] {
        let model = load(name);
        let mut engine = engine(name, 1);
        for n in [
            [1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
            [0.6, 0.8, 0.0],
            [2.0 / 3.0, -2.0 / 3.0, 1.0 / 3.0],
            [-2.0 / 7.0, -3.0 / 7.0, -6.0 / 7.0],
        ] {
            let height = |v: &feeler::brep::Vertex| (0..3).map(|k| n[k] * v.point[k]).sum::<f64>();
            let vertices = model.breps[0].parts().vertices.iter();
            let lowest = vertices.map(height).fold(f64::INFINITY, f64::min);
            let line = format!(r#"{{"half_space":{{"normal":{n:?},"offset":0.5}}}}"#);
            let error = separation(&mut engine, &line) - (lowest - 0.5);
            assert!(error.abs() < SETTLED, "{name} {n:?}: {error}");
        }
    }
}

/// Radius 2.5 about the z axis, z from 0 to 10. Against its side, its cap, and tilted: the rim.
#[test]
fn a_cylinder_with_planes() {
    for name in ["thesis/cylinder.3dm", "thesis/cylinder_nurbs.3dm"] {
        let mut engine = engine(name, 1);
        for n in [
            [0.0, 0.0, 1.0],
            [-1.0, 0.0, 0.0],
            [0.6, 0.0, 0.8],
            [0.48, 0.64, -0.6],
        ] {
            let lowest = -2.5 * f64::hypot(n[0], n[1]) + (10.0 * n[2]).min(0.0);
            let line = format!(r#"{{"half_space":{{"normal":{n:?},"offset":0.25}}}}"#);
            let error = separation(&mut engine, &line) - (lowest - 0.25);
            assert!(error.abs() < 1e-6, "{name} {n:?}: {error}");
        }
    }
}

#[test]
fn a_cube_with_lines() {
    let mut engine = engine("thesis/cube_corner_cut.3dm", 1);
    let body = ask(
        &mut engine,
        r#"{"line":{"origin":[-20,1,2],"direction":[4,0,0]}}"#,
    );
    let Body::Line { hits, .. } = body else {
        panic!()
    };
    assert_eq!(hits.len(), 2);
    assert!((hits[1].t.value - hits[0].t.value - 10.0 / 4.0).abs() < 1e-12);
}

/// Known failure: off the centre away from the side where Newton starts, it finds the farthest point of the
/// socket, and says so silently. The best of 100 starts does not.
#[test]
fn the_farthest_point_is_taken_for_the_nearest() {
    let name = "thesis/ball_joint_cavity_nurbs.3dm";
    let line = ball([0.028, 0.0, 0.0], 2.5);
    let found = separation(&mut engine(name, 1), &line);
    assert!((found - 0.028).abs() < SETTLED, "{found}");
    let found = separation(&mut engine(name, 100), &line);
    assert!((found + 0.028).abs() < SETTLED, "{found}");
}

/// Known failure: a line through the side of a cylinder hits it twice; one hit is found, with 100 starts too.
#[test]
fn a_second_hit_on_a_face_is_missed() {
    for starts in [1, 100] {
        let mut engine = engine("thesis/cylinder.3dm", starts);
        let body = ask(
            &mut engine,
            r#"{"line":{"origin":[-20,1,5],"direction":[1,0.01,0]}}"#,
        );
        let Body::Line { hits, .. } = body else {
            panic!()
        };
        assert_eq!(hits.len(), 1);
    }
}
