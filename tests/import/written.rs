//! What we write as .3dm, rhino3dm reads and finds valid.

use crate::models::models;
use crate::reference::python;
use feeler_io::{ObjectKind, read_file, write_3dm};
use std::path::{Path, PathBuf};

/// Class, whether valid, what is wrong.
type Look = (String, bool, String);

/// What rhino3dm says of each object; `None`, said aloud, where there is none.
fn look(files: &[PathBuf]) -> Option<Vec<Option<Vec<Look>>>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("import/valid.py");
    let output = python()?
        .arg(script)
        .args(files)
        .output()
        .expect("Python runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    Some(
        text.lines()
            .map(|l| serde_json::from_str(l).expect("JSON"))
            .collect(),
    )
}

#[test]
fn rhino3dm_finds_what_we_write_valid() {
    let folder = std::env::temp_dir().join(format!("feeler-written-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let (mut sources, mut files, mut kinds) = (Vec::new(), Vec::new(), Vec::new());
    for (i, path) in models().into_iter().enumerate() {
        let document = read_file(&path).expect("a model");
        let written = write_3dm(&document).expect("faces with loops");
        let file = folder.join(format!("{i}.3dm"));
        std::fs::write(&file, &written.bytes).expect("a file");
        let own = document
            .objects
            .iter()
            .enumerate()
            .filter(|(_, o)| !o.block_member);
        let mut expected = Vec::new();
        for (index, _) in own {
            for part in document.parts(index) {
                match part.kind {
                    ObjectKind::Brep(_) | ObjectKind::Extrusion(_) => {
                        expected.push((index, "Brep"))
                    }
                    ObjectKind::Surface(_) => expected.push((index, "Surface")),
                    ObjectKind::Curve(_) => expected.push((index, "Curve")),
                    _ => {}
                }
            }
        }
        sources.push(path);
        files.push(file);
        kinds.push(expected);
    }
    let said = look(&files);
    let (Some(said), Some(before)) = (said, look(&sources)) else {
        return;
    };
    let (mut valid, mut invalid_before, mut invalid) = (0, 0, Vec::new());
    for (((path, said), before), kinds) in sources.iter().zip(said).zip(before).zip(kinds) {
        let said = said.unwrap_or_else(|| panic!("{} is not read", path.display()));
        let before = before.expect("a model");
        assert_eq!(said.len(), kinds.len(), "{}", path.display());
        for ((class, is_valid, log), (index, kind)) in said.into_iter().zip(kinds) {
            assert!(
                class.ends_with(kind),
                "{}: {class}, not {kind}",
                path.display()
            );
            // What was no valid object before may stay none.
            if before[index].1 {
                valid += usize::from(is_valid);
                if !is_valid {
                    invalid.push(format!("{} object {index}: {log}", path.display()));
                }
            } else {
                invalid_before += 1;
            }
        }
    }
    println!("{valid} objects are valid; {invalid_before} were not before");
    assert!(invalid.is_empty(), "{}", invalid.join("\n"));
    assert!(valid >= 60, "{valid}");
    std::fs::remove_dir_all(&folder).expect("the folder");
}

/// In these ends of trims of one loop are a rounding apart, and openNURBS asks for equal ones.
const APART: [&str; 3] = [
    "shift_gate.brep",
    "shift_gate_nurbs.brep",
    "sheet_trimmed.brep",
];

/// Files of OCCT have trims that run against their curve, and no flags that say which run along a border.
#[test]
fn rhino3dm_finds_valid_what_comes_from_occt() {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpora/models");
    let folder = std::env::temp_dir().join(format!("feeler-occt-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let (mut names, mut files) = (Vec::new(), Vec::new());
    for part in ["brep", "thesis"] {
        let entries = std::fs::read_dir(corpora.join(part)).expect("models");
        for path in entries.flatten().map(|e| e.path()) {
            if path.extension().is_none_or(|e| e != "brep") {
                continue;
            }
            let document = read_file(&path).expect("a model");
            let written = write_3dm(&document).expect("faces with loops");
            let name = path.file_stem().expect("a name").to_string_lossy();
            let file = folder.join(format!("{name}.3dm"));
            std::fs::write(&file, &written.bytes).expect("a file");
            files.push(file);
            names.push(format!("{name}.brep"));
        }
    }
    let Some(said) = look(&files) else { return };
    let mut valid = 0;
    for (name, said) in names.iter().zip(said) {
        for (class, is_valid, log) in said.unwrap_or_else(|| panic!("{name} is not read")) {
            assert!(
                is_valid || APART.contains(&name.as_str()),
                "{name}: {class}: {log}"
            );
            valid += usize::from(is_valid);
        }
    }
    assert!(valid >= 60, "{valid}");
    std::fs::remove_dir_all(&folder).expect("the folder");
}
