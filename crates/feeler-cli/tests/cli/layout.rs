//! How `feeler inspect` looks. The counts are facts of the model.

use crate::program::{feeler, root};

const PART: &str = "corpora/models/thesis/cube_corner_sphere_cut_nurbs.3dm";

#[test]
fn inspect_as_text() {
    let run = feeler(&["inspect", PART], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    insta::assert_snapshot!(run.out);
}

#[test]
fn inspect_as_json() {
    let run = feeler(&["inspect", PART, "--json"], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    insta::assert_snapshot!(run.out);
}

/// A native torus.
const NATIVE: &str = "corpora/models/analytic/torus.json.gz";

/// Sizes hang on the compiler's layout of structures: of what follows the last semicolon, only the words. And of how thick a shell is, none.
fn without_sizes(text: &str) -> String {
    let lines = text.lines().map(|line| {
        let from = if line.starts_with("  face ") {
            line.rfind("; ")
        } else {
            line.find("plan: ")
        };
        let (plain, sizes) = line.split_at(from.unwrap_or(line.len()));
        let mut out = match plain.split_once(" within ") {
            Some((kind, rest)) => format!("{kind} within #{}", &rest[rest.find(',').unwrap()..]),
            None => plain.to_owned(),
        };
        for c in sizes.chars() {
            if !c.is_ascii_digit() {
                out.push(c);
            } else if !out.ends_with('#') {
                out.push('#');
            }
        }
        out + "\n"
    });
    lines.collect()
}

#[test]
fn plan_as_text() {
    for (name, part) in [("nurbs", PART), ("native", NATIVE)] {
        let run = feeler(&["inspect", part, "--plan"], "");
        assert_eq!(run.code, Some(0), "{run:?}");
        insta::assert_snapshot!(format!("plan_as_text_{name}"), without_sizes(&run.out));
    }
}

#[test]
fn plan_as_json() {
    let run = feeler(&["inspect", PART, "--plan", "--json"], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    let mut all: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let plan = &mut all["objects"][0]["plan"];
    let at_once = plan["bytes_at_once"].take();
    assert!(at_once.as_u64().unwrap() > 0);
    let faces = plan["faces"].as_array_mut().unwrap();
    assert_eq!(faces.len(), 7);
    for face in faces {
        let bytes = face["bytes"].as_object_mut().unwrap();
        for size in bytes.values_mut() {
            assert!(size.take().is_u64());
        }
        if let Some(thickness) = face["form"].get_mut("thickness") {
            assert!(thickness.take().as_f64().unwrap() < 1e-14);
        }
    }
    insta::assert_snapshot!(format!("{plan:#}"));
}

/// Of a STEP file by another application protocol no version is known.
#[test]
fn an_unknown_version_is_said_to_be_unknown() {
    let text = std::fs::read_to_string(root().join("corpora/models/step/sphere.step")).unwrap();
    let text = text.replace("AUTOMOTIVE_DESIGN", "SOME_OTHER_DESIGN");
    let path = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("other.step");
    std::fs::write(&path, text).unwrap();
    let run = feeler(&["inspect", path.to_str().unwrap()], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    let head = "step version unknown, units mm";
    assert!(run.out.starts_with(head), "{run:?}");
}

/// Both formats that are written are named where the command is.
#[test]
fn the_help_names_what_is_written() {
    let run = feeler(&["help"], "");
    assert!(run.out.contains(".3dm or .brep"), "{run:?}");
}

/// What the file's own tolerance covers is no defect, and is counted.
#[test]
fn deviations_within_tolerance_are_no_defects() {
    let part = "corpora/models/thesis/shift_gate_straight.3dm";
    let run = feeler(&["inspect", part], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(
        run.out.contains("within the file's own tolerance"),
        "{run:?}"
    );
    assert!(!run.out.contains("(the file allows"), "{run:?}");
    let run = feeler(&["inspect", part, "--json"], "");
    let said: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let object = &said["objects"][0];
    assert_eq!(object["defects"], serde_json::json!([]), "{run:?}");
    let allowed = object["within_tolerance"].as_array().unwrap();
    let first = allowed[0].as_str().unwrap();
    assert!(first.contains("(the file allows"), "{first}");
}
