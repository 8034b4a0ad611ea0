//! `feeler inspect --health` and `feeler study`: the facts of some parts, and how they look.

use crate::program::{feeler, root};
use serde_json::Value;
use std::path::{Path, PathBuf};

const SOUND: &str = "corpora/models/thesis/cube_corner_sphere_cut_nurbs.3dm";
const OPEN: &str = "corpora/models/thesis/sheet_trimmed.3dm";

/// Numbers are the kernel's to test: runs of digits, points and exponents become `#`.
fn without_numbers(text: &str) -> String {
    let mut out = String::new();
    let mut in_number = false;
    let mut before = ' ';
    for c in text.chars() {
        let is_part = c.is_ascii_digit() || (in_number && matches!(c, '.' | 'e' | '-'));
        // A digit within a word is no number.
        let starts = c.is_ascii_digit() && !before.is_alphanumeric();
        if in_number && is_part {
        } else if starts {
            out.push('#');
            in_number = true;
        } else {
            in_number = false;
            out.push(c);
        }
        before = c;
    }
    out
}

fn health(part: &str) -> Value {
    let run = feeler(&["inspect", part, "--health", "--json"], "");
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
    let mut all: Value = serde_json::from_str(&run.out).unwrap();
    all["objects"][0]["health"].take()
}

#[test]
fn sound_parts_are_one_line() {
    let run = feeler(&["inspect", SOUND, "--health"], "");
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
    let last = run.out.lines().last().unwrap();
    assert!(last.starts_with("  health: closed, 7 faces, "), "{last}");
    assert!(last.ends_with("; nothing to report"), "{last}");
    let h = health(SOUND);
    assert_eq!(h["closed"], true);
    assert_eq!(h["undefined"].as_array().map(Vec::len), Some(0));
    for e in h["edges"].as_array().unwrap() {
        assert_eq!(e["direction"], "fits");
    }
}

#[test]
fn open_parts_say_so() {
    let run = feeler(&["inspect", OPEN, "--health"], "");
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
    // A sheet: all of its eight edges are naked.
    assert!(
        run.out
            .contains("  8 edges used once: the part is open there; "),
        "{}",
        run.out
    );
    assert!(run.out.contains("  so: not closed: "), "{}", run.out);
    insta::assert_snapshot!("health_as_text", without_numbers(&run.out));
    let h = health(OPEN);
    assert_eq!(h["closed"], false);
    let naked = h["edges"].as_array().unwrap().iter();
    assert!(naked.clone().all(|e| e["naked"] == true) && naked.len() == 8);
    assert_eq!(h["undefined"][0]["name"], "material");
}

/// All keys of an object and of those in it, by path.
fn keys(value: &Value, path: &str, out: &mut Vec<String>) {
    match value {
        Value::Object(o) => {
            for (key, inner) in o {
                let path = format!("{path}.{key}");
                out.push(path.clone());
                keys(inner, &path, out);
            }
        }
        Value::Array(a) => {
            for inner in a {
                keys(inner, path, out);
            }
        }
        _ => {}
    }
}

#[test]
fn the_json_is_described() {
    let text = std::fs::read_to_string(root().join("crates/feeler-cli/HEALTH.md")).unwrap();
    let mut found = Vec::new();
    for part in [
        SOUND,
        OPEN,
        "corpora/models/trim-loops/mixture_gaps.json.gz",
        "corpora/models/trim-loops/pentagram.json.gz",
    ] {
        keys(&health(part), "", &mut found);
    }
    found.sort();
    found.dedup();
    assert!(found.len() > 35, "{found:?}");
    for path in found {
        let key = path.rsplit('.').next().unwrap();
        assert!(
            text.contains(&format!("`{key}`")),
            "{path} is not in HEALTH.md"
        );
    }
}

/// Corners of a star, whose sides cross five times.
#[test]
fn crossings_are_said() {
    let part = "corpora/models/trim-loops/pentagram.json.gz";
    let run = feeler(&["inspect", part, "--health"], "");
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.out.contains(" cross near uv ("), "{}", run.out);
    assert!(run.out.contains(", one of 5 places: "), "{}", run.out);
}

/// A folder of this test alone.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // Left from an earlier run.
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(path.join("parts/deeper")).unwrap();
    path
}

/// References that reading makes of an assembly are no objects of its file; those of a .3dm are.
#[test]
fn a_study_counts_references_of_a_file_alone() {
    let here = folder("references");
    let models = root().join("corpora/models");
    let counted = |from: &str, to: &str| {
        std::fs::copy(models.join(from), here.join("parts").join(to)).unwrap();
        let [parts, out] = ["parts", "out"].map(|p| here.join(p).to_str().unwrap().to_owned());
        let run = feeler(&["study", &parts, "--out", &out], "");
        assert_eq!(run.code, Some(0), "{run:?}");
        assert!(run.out.contains("| plane |"), "{}", run.out);
        run.out.contains("| block reference |")
    };
    assert!(!counted("step/assembly.step", "a.step"));
    assert!(counted("3dm/blocks.3dm", "b.3dm"));
}

#[test]
fn a_study_of_a_folder() {
    let here = folder("study");
    let models = root().join("corpora/models");
    for (from, to) in [
        ("thesis/cylinder.3dm", "parts/a.3DM"),
        ("thesis/cylinder.brep", "parts/deeper/b.brep"),
    ] {
        std::fs::copy(models.join(from), here.join(to)).unwrap();
    }
    std::fs::write(here.join("parts/broken.3dm"), b"not a part").unwrap();
    std::fs::write(here.join("parts/notes.txt"), b"not looked at").unwrap();
    let [parts, out] = ["parts", "out"].map(|p| here.join(p).to_str().unwrap().to_owned());
    let run = feeler(&["study", &parts, "--out", &out], "");
    // Quiet but for the tables.
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{run:?}");
    assert!(
        run.out.starts_with("2 files read, 1 unreadable; 2 BREPs\n"),
        "{}",
        run.out
    );
    // Each file holds a cylinder: two planes and a line turned around its axis.
    assert!(
        run.out.contains("| plane | 4 | 66.7 % | 2 |"),
        "{}",
        run.out
    );
    assert!(
        run.out.contains("| revolution of line | 2 | 33.3 % | 2 |"),
        "{}",
        run.out
    );
    assert!(
        run.out.contains("\n- ") && run.out.contains("broken.3dm"),
        "{}",
        run.out
    );
    let page = std::fs::read_to_string(here.join("out/study.md")).unwrap();
    assert!(run.out.starts_with(page.lines().next().unwrap()) && page.contains("(study.svg)"));
    let svg = std::fs::read_to_string(here.join("out/study.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("revolution of line"));

    let run = feeler(&["study", &here.join("out").display().to_string()], "");
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.err.starts_with("error: ") && run.err.contains("name a folder of parts"));
    let run = feeler(&["study", "no/such/folder"], "");
    assert_eq!(run.code, Some(2), "{run:?}");
    assert_eq!(run.err.lines().count(), 1, "{run:?}");
}
