//! `feeler convert`.

use crate::program::feeler;

const PART: &str = "corpora/models/thesis/ball_joint_cavity.3dm";

/// A place for a file of this test.
fn out(name: &str) -> String {
    let name = format!("feeler-convert-{}-{name}", std::process::id());
    std::env::temp_dir()
        .join(name)
        .to_string_lossy()
        .into_owned()
}

#[test]
fn what_is_written_answers_as_before() {
    let path = out("same.3dm");
    let run = feeler(&["convert", PART, &path], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.out.contains("1 objects, units mm"), "{run:?}");
    let ask = |file: &str| {
        let run = feeler(&["contact", file, "--sphere", "0.01,0.02,0.03,2.51"], "");
        assert_eq!(run.code, Some(0), "{run:?}");
        run.out
    };
    assert_eq!(ask(PART), ask(&path));
    std::fs::remove_file(path).expect("the file");
}

#[test]
fn a_brep_answers_as_before() {
    let path = out("same.brep");
    let run = feeler(&["convert", PART, &path], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.out.contains("1 objects, no units (were mm)"), "{run:?}");
    let ask = |file: &str| {
        let run = feeler(&["contact", file, "--sphere", "0.01,0.02,0.03,2.51"], "");
        assert_eq!(run.code, Some(0), "{run:?}");
        let answer: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
        answer["separation"].clone()
    };
    assert_eq!(ask(PART), ask(&path));
    std::fs::remove_file(path).expect("the file");
}

#[test]
fn other_units_are_said_with_their_rounding() {
    let path = out("inches.3dm");
    let run = feeler(&["convert", PART, &path, "--unit", "in"], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(
        run.out
            .contains("lengths from mm to in: rounded, points off by no more than"),
        "{run:?}"
    );
    let read = feeler(&["inspect", &path], "");
    assert!(
        read.out.starts_with("3dm version 50, units in, 1 objects"),
        "{read:?}"
    );
    std::fs::remove_file(path).expect("the file");
}

#[test]
fn other_formats_are_refused() {
    let run = feeler(&["convert", PART, "part.step"], "");
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.err.contains("end it with .3dm"), "{run:?}");
}
