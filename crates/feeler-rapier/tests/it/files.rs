//! Shapes by reference to their file, and scaled.

use crate::scenes::{cube, shape};
use feeler_corpus::Model;
use feeler_rapier::{BrepDispatcher, BrepShape, Several, ShapeFile, ball_gap};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{Ball, Shape};
use std::path::{Path, PathBuf};

fn thesis(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/thesis");
    root.join(name)
}

fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn a_shape_is_saved_by_reference_and_is_the_same_again() {
    let own = BrepShape::from_file(thesis("ball_joint_cavity_nurbs.3dm"), 0).unwrap();
    let own = own
        .with_accuracy(1.0 / 3.0e9)
        .with_several(Several::Deepest);
    let text = serde_json::to_string(&own).unwrap();
    assert!(text.len() < 600, "{text}");
    let again: BrepShape = serde_json::from_str(&text).unwrap();
    assert_eq!(again.file(), own.file());
    let center = Vector::new(0.01, 0.02, 0.03);
    let gap = |s: &BrepShape| ball_gap(s, &Pose::IDENTITY, center, 2.51);
    assert_eq!(gap(&again), gap(&own));
}

/// A file that holds another BREP now is an error that names it, what is wrong and what to do; so are one that is gone, and objects that are none.
#[test]
fn a_file_that_changed_is_refused() {
    let path = scratch("changing.json");
    let write = |x: f64| {
        let brep = crate::scenes::block([0.0; 3], [x, 1.0, 1.0]);
        Model::write(&path, &[cube(), brep], None).unwrap();
    };
    write(2.0);
    let text = serde_json::to_string(&BrepShape::from_file(&path, 1).unwrap()).unwrap();
    let load = |text: &str| serde_json::from_str::<BrepShape>(text);
    assert!(load(&text).is_ok());
    // By a unit in the last place.
    write(2.0f64.next_up());
    let changed = load(&text).unwrap_err().to_string();
    for word in ["changing.json", "object 1", "changed", "from_file"] {
        assert!(changed.contains(word), "{changed}");
    }
    // Its first object is what it was.
    let first = serde_json::to_string(&BrepShape::from_file(&path, 0).unwrap()).unwrap();
    write(3.0);
    assert!(load(&first).is_ok());
    let other = text.replace("\"object\":1", "\"object\":7");
    assert!(
        load(&other)
            .unwrap_err()
            .to_string()
            .contains("no object 7")
    );
    let other = text.replace("\"part\":0", "\"part\":3");
    let said = load(&other).unwrap_err().to_string();
    assert!(
        said.contains("changing.json") && said.contains("no BREP 3"),
        "{said}"
    );
    let gone = text.replace("changing", "gone");
    assert!(load(&gone).unwrap_err().to_string().contains("gone.json"));
    let mut file: ShapeFile = serde_json::from_str(&text).unwrap();
    for accuracy in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        file.accuracy = accuracy;
        let said = file.load().unwrap_err().to_string();
        assert!(
            said.contains("accuracy") && said.contains("changing.json"),
            "{said}"
        );
    }
    // What is from no file.
    let said = serde_json::to_string(&shape(cube()))
        .unwrap_err()
        .to_string();
    assert!(said.contains("from_file"), "{said}");
}

/// Times a power of two, all answers are so many times as large, bit for bit; mirrored too.
#[test]
fn scaled_by_powers_of_two() {
    let own = BrepShape::from_file(thesis("ball_joint_cavity_nurbs.3dm"), 0).unwrap();
    for (by, mirror) in [(0.25, 1.0), (1024.0, 1.0), (2.0, -1.0)] {
        let factor = Vector::new(by * mirror, by, by);
        let scaled = own.scale_dyn(factor, 1).unwrap();
        let scaled = scaled.as_shape::<BrepShape>().unwrap();
        assert!(scaled.file().is_none());
        let center = Vector::new(0.01, 0.02, 0.03);
        let gap = |s: &BrepShape, center: Vector, radius: f64| {
            let pose = Pose::from_translation(center);
            let answer = BrepDispatcher::new().pair(&pose, s, &Ball::new(radius), 1e6);
            answer.unwrap().separation
        };
        let (one, other) = (
            gap(&own, center, 2.51),
            gap(scaled, center * factor, 2.51 * by),
        );
        // Poses round at their own scale, products alike.
        assert_eq!(other.value, one.value * by);
        assert_eq!(other.bounds.lo, one.bounds.lo * by);
        let inside = scaled.contains_local_point(Vector::new(4.0, 0.0, 0.0) * factor);
        assert!(inside, "the material is where it was");
        let mass = [own.mass().volume, scaled.mass().volume];
        assert!((mass[1] / (mass[0] * by.powi(3)) - 1.0).abs() < 1e-12);
    }
    let huge = own.scale_dyn(Vector::splat(2f64.powi(300)), 1);
    assert!(huge.is_none());
}
