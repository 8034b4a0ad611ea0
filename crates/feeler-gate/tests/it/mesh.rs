//! The mesh engine, against what geometry says of meshes.

use feeler_corpus::{Body, Model, QueryLine};
use feeler_gate::{Engine, MeshEngine};
use std::path::Path;

fn engine(name: &str, degrees: f64) -> MeshEngine {
    let models = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../corpora/models"));
    let model = Model::load(&models.join(name), None).unwrap();
    let mut engine = MeshEngine::new(degrees);
    engine.open(&model).unwrap();
    engine
}

fn ask(engine: &mut MeshEngine, line: &str) -> Body {
    let query = QueryLine::parse(line).unwrap().query().unwrap();
    assert!(engine.treats(&query));
    engine.answer(&query).body
}

fn separation(engine: &mut MeshEngine, line: &str) -> f64 {
    match ask(engine, line) {
        Body::Contact { separation, .. } => separation.value,
        other => panic!("{other:?}"),
    }
}

/// A block has no chords: all answers are exact up to rounding. It spans 3 by 4 by 5.
#[test]
fn a_block_is_exact() {
    let mut block = engine("analytic/block.json.gz", 180.0);
    let Body::Line {
        hits, crossings, ..
    } = ask(
        &mut block,
        r#"{"line":{"origin":[-10,0.3,1.2],"direction":[2,0,0]}}"#,
    )
    else {
        panic!()
    };
    assert_eq!((hits.len(), crossings), (2, Some(2)));
    let (x0, x1) = (hits[0].point[0], hits[1].point[0]);
    assert!((hits[0].normal[0], hits[1].normal[0]) == (-1.0, 1.0));
    assert!(((hits[1].t.value - hits[0].t.value) * 2.0 - (x1 - x0)).abs() < 1e-14);
    let ball = |x: f64| format!(r#"{{"sphere":{{"center":[{x},0.3,1.2],"radius":0.25}}}}"#);
    assert!((separation(&mut block, &ball(x1 + 1.0)) - 0.75).abs() < 1e-14);
    assert!((separation(&mut block, &ball(x1 - 0.1)) + 0.35).abs() < 1e-14);
    let plane = format!(
        r#"{{"half_space":{{"normal":[1,0,0],"offset":{}}}}}"#,
        x0 + 0.5
    );
    assert!((separation(&mut block, &plane) + 0.5).abs() < 1e-14);
    let inside = |x: f64| format!(r#"{{"inside":{{"point":[{x},0.3,1.2]}}}}"#);
    for (x, side) in [(x1 - 1e-9, "Inside"), (x1 + 1e-9, "Outside")] {
        let answer = format!("{:?}", ask(&mut block, &inside(x)));
        assert!(answer.contains(side), "{answer}");
    }
}

/// A line through an edge that two triangles share, and through a corner that many do, crosses once.
#[test]
fn shared_edges_are_crossed_once() {
    let mut block = engine("analytic/block.json.gz", 180.0);
    let Body::Line { hits, .. } = ask(
        &mut block,
        r#"{"line":{"origin":[-10,0.3,1.2],"direction":[1,0,0]}}"#,
    ) else {
        panic!()
    };
    let x = hits[0].point[0];
    let Body::Line { hits, .. } = ask(
        &mut block,
        r#"{"line":{"origin":[0.1,-10,1.2],"direction":[0,1,0]}}"#,
    ) else {
        panic!()
    };
    let y: Vec<f64> = hits.iter().map(|h| h.point[1]).collect();
    let Body::Line { hits, .. } = ask(
        &mut block,
        r#"{"line":{"origin":[0.1,0.3,-10],"direction":[0,0,1]}}"#,
    ) else {
        panic!()
    };
    let z: Vec<f64> = hits.iter().map(|h| h.point[2]).collect();
    // The middle of a face lies on its diagonal.
    let line = format!(
        r#"{{"line":{{"origin":[{},{},{}],"direction":[1,0,0]}}}}"#,
        x - 1.0,
        0.5 * (y[0] + y[1]),
        0.5 * (z[0] + z[1])
    );
    let Body::Line { crossings, .. } = ask(&mut block, &line) else {
        panic!()
    };
    assert_eq!(crossings, Some(2));
}

/// In the socket: the error is that of the mesh, and gets smaller with it.
#[test]
fn a_ball_in_its_socket() {
    let query = r#"{"sphere":{"center":[0.01,0.02,0.03],"radius":2.51}}"#;
    // The socket's radius is 2.5.
    let truth = 2.5 - (0.01f64 * 0.01 + 0.02 * 0.02 + 0.03 * 0.03).sqrt() - 2.51;
    let mut before = f64::INFINITY;
    for degrees in [30.0, 10.0, 3.0, 1.0] {
        let mut engine = engine("thesis/ball_joint_cavity_nurbs.3dm", degrees);
        let error = (separation(&mut engine, query) - truth).abs();
        assert!(error <= engine.chord_error() * 1.01, "{degrees}: {error}");
        assert!(error < before);
        before = error;
    }
    assert!(before < 2e-4);
}

#[test]
fn what_a_mesh_cannot_know_is_not_treated() {
    let engine = MeshEngine::new(10.0);
    for line in [
        r#"{"side":{"face":0,"uv":[0,0]}}"#,
        r#"{"evaluate":{"face":0,"uv":[0,0]}}"#,
        r#"{"split":{"face":0,"loop":0,"trim":0}}"#,
        r#"{"sphere":{"center":[0,0,0],"radius":1},"contacts":"all"}"#,
    ] {
        let query = QueryLine::parse(line).unwrap().query().unwrap();
        assert!(!engine.treats(&query), "{line}");
    }
}
