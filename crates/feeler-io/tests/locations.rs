//! Locations of a `.brep` that are no rigid motions: what they place is refused by the location's number, the rest is read.

use feeler_io::{ObjectKind, read_brep};
use std::path::Path;

/// A part placed by locations, the first of which moves by (0, 7, 1).
fn placed() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora/models/brep/placed.brep");
    std::fs::read_to_string(path).expect("a file of the corpus")
}

/// The same with other numbers in the first location's matrix.
fn with(rows: [&str; 3]) -> String {
    let whole = placed();
    let mut lines: Vec<&str> = whole.lines().collect();
    let first = lines
        .iter()
        .position(|l| l.starts_with("Locations"))
        .expect("a table")
        + 2;
    assert_eq!(
        lines[first].split_whitespace().collect::<Vec<_>>(),
        ["1", "0", "0", "0"]
    );
    lines[first..first + 3].copy_from_slice(&rows);
    lines.join("\n")
}

fn refusals(text: &str) -> (usize, Vec<String>) {
    let document = read_brep(text.as_bytes()).expect("a file");
    let refused = document.objects.iter().filter_map(|o| match &o.kind {
        ObjectKind::Refused { reason, .. } => Some(reason.to_string()),
        _ => None,
    });
    (document.objects.len(), refused.collect())
}

#[test]
fn mirrored_and_scaled_locations_are_refused_by_number() {
    let (all, none) = refusals(&placed());
    assert!(all > 0 && none.is_empty(), "{none:?}");
    for (rows, why) in [
        (["-1 0 0 0", "0 1 0 7", "0 0 1 1"], "so it mirrors"),
        (["2 0 0 0", "0 2 0 7", "0 0 2 1"], "changes squared lengths"),
        (["1 0 0 0", "0 1 0 7", "0 0 3 1"], "changes squared lengths"),
        (
            ["1 0.5 0 0", "0 1 0 7", "0 0 1 1"],
            "changes squared lengths",
        ),
        (["1 0 0 0", "0 0 0 7", "0 0 1 1"], "so it mirrors"),
    ] {
        let (count, refused) = refusals(&with(rows));
        assert_eq!(count, all);
        assert!(!refused.is_empty(), "{rows:?}");
        for reason in refused {
            let named = reason.contains("location 1 is no rigid motion") && reason.contains(why);
            assert!(named && reason.starts_with("line "), "{reason}");
        }
    }
}

/// What is off by what 15 digits leave is a rigid motion.
#[test]
fn a_rounded_turn_is_rigid() {
    let text = with(["0.6 -0.8 0 0", "0.8 0.600000000000001 0 7", "0 0 1 1"]);
    let (_, refused) = refusals(&text);
    assert!(refused.is_empty(), "{refused:?}");
}
