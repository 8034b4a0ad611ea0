//! Damaged .brep files: each is read, or refused with one line that names a line and a remedy; no panic, no hang.

use feeler_io::{Document, ObjectKind, ReadError, TextProblem, read_brep, read_file};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// For files of some 10 kB, which take a few milliseconds.
const LONG: Duration = Duration::from_secs(5);

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../corpora/models/thesis")
}

fn text(part: &str) -> String {
    std::fs::read_to_string(folder().join(part)).expect("a file of the corpus")
}

/// A solid with a seam and poles, one with natives, splines, a periodic surface, a sheet.
const PARTS: [&str; 5] = [
    "ball_joint_cavity.brep",
    "cylinder.brep",
    "cube_corner_sphere_cut_nurbs.brep",
    "ball_nurbs_periodic.brep",
    "sheet_trimmed_nurbs.brep",
];

/// Reads, and holds what is said against what it must be.
fn read(bytes: &[u8]) -> Result<Document, ReadError> {
    let start = Instant::now();
    let result = read_brep(bytes);
    let time = start.elapsed();
    assert!(time < LONG, "{time:?}");
    let said = |reason: &ReadError| {
        let text = reason.to_string();
        assert_eq!(text.lines().count(), 1, "{text}");
        assert!(text.len() < 400, "{text}");
        if !bytes.is_empty() {
            assert!(text.starts_with("line ") && text.contains(';'), "{text}");
        }
    };
    match &result {
        Err(reason) => said(reason),
        Ok(document) => {
            for object in &document.objects {
                match &object.kind {
                    ObjectKind::Refused { reason, .. } => said(reason),
                    ObjectKind::Brep(brep) => brep.defects().iter().for_each(|d| {
                        assert!(!d.to_string().is_empty());
                    }),
                    _ => {}
                }
            }
        }
    }
    result
}

#[test]
fn a_truncated_file_is_an_error_that_names_the_line() {
    for part in PARTS {
        let text = text(part);
        let bytes = text.as_bytes();
        // The last word is the location of the whole shape.
        let end = text.trim_end().len();
        let step = 1 + bytes.len() / 1500;
        for n in (0..end).step_by(step) {
            let error = read(&bytes[..n]).expect_err("a part of a file");
            if n > 200 {
                let lines = text[..n].lines().count();
                let ReadError::Line { line, .. } = error else {
                    panic!("{error}");
                };
                assert!(line <= lines + 1, "{error}: of {lines}");
            }
        }
        assert!(read(&bytes[..end]).is_ok());
    }
}

/// Words that numbers are replaced with.
const WILD: [&str; 16] = [
    "0",
    "1",
    "-1",
    "2",
    "7",
    "100",
    "65536",
    "1000000",
    "2147483647",
    "-2147483648",
    "9223372036854775807",
    "1e308",
    "-1e-320",
    "nan",
    "*",
    "+1",
];

/// A file with some of its words replaced, taken out or said twice.
fn mutated(text: &str, changes: &[(prop::sample::Index, u8)]) -> String {
    let mut words: Vec<&str> = text.split_inclusive(char::is_whitespace).collect();
    // Behind the header, or all is lost at once.
    let first = words
        .iter()
        .position(|w| w.trim() == "Locations")
        .unwrap_or(0);
    for (at, how) in changes {
        let i = first + at.index(words.len() - first);
        match usize::from(*how) {
            how if how < WILD.len() => {
                words[i] = WILD[how];
                words.insert(i + 1, " ");
            }
            16 => drop(words.remove(i)),
            17 => words.insert(i, words[i]),
            _ => {
                let j = first + (i * 31 + usize::from(*how)) % (words.len() - first);
                words.swap(i, j);
            }
        }
    }
    words.concat()
}

/// The same files every time, unless the environment says otherwise.
fn config() -> ProptestConfig {
    let mut config = ProptestConfig {
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    config.cases = config.cases.max(1500);
    config
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn a_mutated_file_is_read_or_refused(
        part in 0..PARTS.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0..24_u8), 1..4),
    ) {
        let _ = read(mutated(&text(PARTS[part]), &changes).as_bytes());
    }

    #[test]
    fn damaged_bytes_are_read_or_refused(
        part in 0..PARTS.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut bytes = text(PARTS[part]).into_bytes();
        for (at, byte) in changes {
            let i = at.index(bytes.len());
            bytes[i] = byte;
        }
        let _ = read(&bytes);
    }
}

/// Every count of a file made far too large: nothing is allocated for it.
#[test]
fn counts_are_checked_against_what_is_left() {
    for part in PARTS {
        let text = text(part);
        for table in [
            "Locations",
            "Curve2ds",
            "Curves",
            "Polygon3D",
            "PolygonOnTriangulations",
            "Surfaces",
            "Triangulations",
            "TShapes",
        ] {
            let at = text.find(&format!("\n{table} ")).expect("a table") + 1;
            let end = at + text[at..].find('\n').expect("a line");
            for count in ["1000000", "18446744073709551615", "-3", "x"] {
                let wrong = format!("{}{table} {count}{}", &text[..at], &text[end..]);
                let error = read(wrong.as_bytes()).expect_err("a count");
                let line = text[..at].lines().count() + 1;
                assert!(
                    error.to_string().starts_with(&format!("line {line}: ")),
                    "{error}"
                );
            }
        }
    }
}

const HEADER: &str = "CASCADE Topology V1, (c) Matra-Datavision\n";

/// The tables before the shapes, all empty.
fn empty(shapes: &str) -> String {
    format!(
        "{HEADER}Locations 0\nCurve2ds 0\nCurves 0\nPolygon3D 0\nPolygonOnTriangulations 0\nSurfaces 0\n\
         Triangulations 0\nTShapes {shapes}"
    )
}

fn problem(text: &str) -> TextProblem {
    match read(text.as_bytes()).expect_err("a bad file") {
        ReadError::Line { problem, .. } => *problem,
        other => panic!("{other}"),
    }
}

#[test]
fn shapes_that_hold_themselves_are_refused() {
    // The second one of two holds the first one, and that itself or the second one.
    for inner in ["+2 0", "+1 0"] {
        let text = empty(&format!(
            "2\nCo\n0000000\n{inner} *\nCo\n0000000\n+2 0 *\n+1 0\n"
        ));
        assert!(matches!(problem(&text), TextProblem::Reference { .. }));
    }
}

#[test]
fn shapes_that_unfold_without_end_are_refused() {
    // Each holds the one before twice: 2^60 of the first one.
    let mut text = String::from("61\nCo\n0000000\n*\n");
    for i in 0..60 {
        let before = 61 - i;
        text += &format!("Co\n0000000\n+{before} 0 +{before} 0 *\n");
    }
    text += "+1 0\n";
    let document = read(empty(&text).as_bytes()).expect("a file");
    let [only] = &document.objects[..] else {
        panic!("{} objects", document.objects.len());
    };
    let ObjectKind::Refused { reason, .. } = &only.kind else {
        panic!("{}", only.kind.name());
    };
    assert!(
        reason.to_string().contains("unfolds to more than"),
        "{reason}"
    );
}

#[test]
fn deep_nesting_is_refused_or_walked_without_recursion() {
    let deep = |kind: &str, count: usize| {
        let curves = format!("{}1 0 0 0 0 0 1", format!("{kind} ").repeat(count));
        format!(
            "{HEADER}Locations 0\nCurve2ds 0\nCurves 1\n{curves}\nPolygon3D 0\nPolygonOnTriangulations 0\n\
             Surfaces 0\nTriangulations 0\nTShapes 1\nCo\n0000000\n*\n+1 0\n"
        )
    };
    assert!(read(deep("8 0 1", 10).as_bytes()).is_ok());
    for kind in ["8 0 1", "9 1 0 0 1"] {
        assert!(matches!(
            problem(&deep(kind, 200_000)),
            TextProblem::Nested { .. }
        ));
    }
    // Compounds may nest as deep as they like.
    let n = 20_000;
    let mut text = format!("{n}\nCo\n0000000\n*\n");
    for i in 1..n {
        text += &format!("Co\n0000000\n+{} 0 *\n", n - i + 1);
    }
    assert!(
        read(empty(&(text + "+1 0\n")).as_bytes())
            .expect("a file")
            .objects
            .is_empty()
    );
}

#[test]
fn locations_that_grow_without_end_are_refused() {
    // Each the fourth power of the one before and another: their words grow to 5^40 factors.
    let matrix = "1\n1 0 0 1\n0 1 0 0\n0 0 1 0\n";
    let mut text = format!("{HEADER}Locations 42\n{matrix}{matrix}");
    for i in 2..42 {
        text += &format!("2 {i} 4 1 1 2 1 0\n");
    }
    assert!(matches!(problem(&text), TextProblem::Limit { .. }));
    let text = format!("{HEADER}Locations 2\n{matrix}2 1 2000000000 0\n");
    assert!(matches!(problem(&text), TextProblem::Limit { .. }));
}

/// Found by the fuzz target `read_brep`: queries took minutes on such faces.
#[test]
fn loops_far_off_their_surface_are_refused() {
    let ball = text("ball.brep");
    for (from, to) in [
        (
            "1 0 -6.2831853071795862 0 1 ",
            "1 0 -6.2831853071795862 101000 1 ",
        ),
        (
            "1 0 -6.2831853071795862 0 1 ",
            "1 3553874899 -6.2831853071795862 0 1 ",
        ),
        (
            "1 0 -1.5707963267948966 1 0 ",
            "1 0 -1.5707963267948966 1 1296911693 ",
        ),
    ] {
        assert!(ball.contains(from));
        let document = read(ball.replace(from, to).as_bytes()).expect("a file");
        let ObjectKind::Refused { reason, .. } = &document.objects[0].kind else {
            panic!("{document:?}");
        };
        assert!(reason.to_string().contains("loops reach over"), "{reason}");
    }
}

#[test]
fn what_is_no_text_of_occt_is_named() {
    assert_eq!(read(b"").unwrap_err(), ReadError::Empty);
    assert_eq!(problem("solid cube\nfacet normal"), TextProblem::Header);
    assert_eq!(
        problem("\nOpen CASCADE Topology V4 (c)\n"),
        TextProblem::Binary
    );
    let text = problem("CASCADE Topology V4, (c) Open Cascade\n").to_string();
    assert!(
        text.contains("version 4") && text.contains("1 to 3"),
        "{text}"
    );
    // By the name, where the content says nothing.
    let path = std::env::temp_dir().join(format!("feeler-io-{}.brep", std::process::id()));
    std::fs::write(&path, "nothing").unwrap();
    let said = read_file(&path).unwrap_err().to_string();
    std::fs::remove_file(&path).unwrap();
    assert!(said.contains(".brep: line 1: not a .brep file"), "{said}");
}
