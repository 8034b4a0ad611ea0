//! What `corpora/cases/cases.json` points to is there.

use serde_json::Value;
use std::path::Path;

/// Words with a slash that name a file or a folder: those that begin with a folder of the repository's.
fn paths(text: &str) -> Vec<&str> {
    let words = text.split([' ', ',', ';', ':', '(', ')', '`']);
    let named = words.filter(|w| {
        let (first, rest) = w.split_once('/').unwrap_or((w, ""));
        let folders = ["crates", "corpora", "tests", "fuzz", "cpp"];
        folders.contains(&first) && !rest.is_empty()
    });
    named.collect()
}

#[test]
fn the_paths_of_cases_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = std::fs::read_to_string(root.join("corpora/cases/cases.json")).unwrap();
    let cases: Vec<Value> = serde_json::from_str(&text).unwrap();
    let mut count = 0;
    for case in &cases {
        for said in case.as_object().unwrap().values() {
            for path in paths(said.as_str().unwrap_or_default()) {
                assert!(root.join(path).exists(), "{}: no {path}", case["id"]);
                count += 1;
            }
        }
    }
    assert!(count > 4, "{count} paths");
}
