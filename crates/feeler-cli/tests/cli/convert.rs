//! `feeler convert`.

use crate::program::{feeler, root};

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

/// What an assembly places is rounded when it is moved there, in other units after it was rounded by itself: what is said has room for both.
#[test]
fn what_moving_rounds_is_said() {
    const ASSEMBLY: &str = "corpora/models/step/assembly.step";
    let bound = |name: &str, more: &[&str], begins: &str| -> f64 {
        let path = out(name);
        let run = feeler(&[&["convert", ASSEMBLY, &path], more].concat(), "");
        assert_eq!(run.code, Some(0), "{run:?}");
        std::fs::remove_file(path).expect("the file");
        let line = run.out.lines().find(|l| l.starts_with(begins));
        let said = line.and_then(|l| l.split_once("no more than "));
        let (_, number) = said.unwrap_or_else(|| panic!("{run:?}"));
        let number = number.split(' ').next().expect("a word");
        number.parse().expect("a number")
    };
    let document = feeler_io::read_file(root().join(ASSEMBLY)).expect("a file");
    let moved = bound("moved.3dm", &[], "moved to where block references put it");
    let most = (0..document.objects.len()).flat_map(|i| document.parts(i));
    let most = most.flat_map(|part| {
        part.warnings.clone().into_iter().filter_map(|w| {
            let (_, number) = w.split_once("coordinates are rounded, off by no more than ")?;
            number.parse::<f64>().ok()
        })
    });
    // Either is rounded up, to two and three digits.
    let most = most.fold(0.0, f64::max);
    assert!(most > 0.0 && moved >= most / 1.01, "{moved:e} {most:e}");
    let mut inches = document;
    let unit = feeler_io::Units::Inches;
    let scaled = inches.convert_units(unit).expect("millimetres");
    let both = bound("inches.3dm", &["--unit", "in"], "lengths from mm to in");
    let moved = moved / 25.4;
    assert!(
        scaled > 0.0 && both >= scaled + moved / 1.2,
        "{both:e} {scaled:e} {moved:e}"
    );
}
