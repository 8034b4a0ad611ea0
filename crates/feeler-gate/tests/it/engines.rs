//! The engines that come with the gate as scripts: the one in ENGINES.md, and OCCT where it is installed.

use feeler_corpus::Fault;
use feeler_gate::{Gate, ModelForm, ProcessEngine, ProcessOptions, Report, Row, run};
use std::path::{Path, PathBuf};
use std::process::Command;

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn gate(python: &str, script: &Path, suite: &str) -> Report {
    let words = [python, script.to_str().unwrap()];
    let options = ProcessOptions {
        models: ModelForm::Json(PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("engines")),
        ..ProcessOptions::default()
    };
    let line = shlex::try_join(words).unwrap();
    let mut engine = ProcessEngine::new(&line, options).unwrap();
    let corpora = here().ancestors().nth(2).unwrap().join("corpora");
    let gate = Gate {
        corpus: &corpora,
        suite: Some(suite),
        tolerance: 1e-9,
        sample: None,
        answers: false,
    };
    run(&mut [&mut engine], &gate, &mut |_| ()).unwrap()
}

/// Whether a Python has a module; said aloud where it has not.
fn has(python: &str, module: &str) -> bool {
    let import = format!("import {module}");
    let found = Command::new(python).args(["-c", &import]).output();
    let has = found.is_ok_and(|o| o.status.success());
    if !has {
        eprintln!("SKIPPED: no {python} with the module {module}");
    }
    has
}

fn refused(row: &Row) -> usize {
    row.faults.get(&Fault::Refused).copied().unwrap_or(0)
}

/// What ENGINES.md shows works as it says: it evaluates planes, and refuses what else there is.
#[test]
fn the_example_of_the_page() {
    let page = std::fs::read_to_string(here().join("ENGINES.md")).unwrap();
    let script = page.split("```python\n").nth(1).unwrap();
    let script = script.split("```").next().unwrap();
    let lines = script.lines().count();
    assert!((10..=20).contains(&lines), "{lines} lines");
    if !has("python3", "json") {
        return;
    }
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("planes.py");
    std::fs::write(&path, script).unwrap();
    let report = gate("python3", &path, "evaluate");
    assert_eq!(report.engine, "planes 1");
    let row = &report.suites[0];
    assert_eq!(row.wrong, refused(row), "{:?}", row.failures);
    // The planes of the corpus, by what it refuses of others.
    assert!(
        row.queries - row.wrong > 100,
        "{} right",
        row.queries - row.wrong
    );
    assert!(
        row.error_length.is_some_and(|e| e < 1e-13),
        "{:?}",
        row.error_length
    );
    let reasons = row.failures.iter().map(|f| f.reason.as_str());
    assert!(reasons.into_iter().all(|r| r.contains("not a plane")));
    let sides = &gate("python3", &path, "side").suites[0];
    assert_eq!((sides.queries, sides.wrong), (0, 0));
    assert!(sides.not_asked > 0);
}

/// `FEELER_OCCT_PYTHON` names the interpreter (default `python3`). Every model is taken, and hardly any side is wrong:
/// the parts arrive as they are.
#[test]
fn occt() {
    let python = std::env::var("FEELER_OCCT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    if !has(&python, "OCP") {
        return;
    }
    let script = here().join("engines/occt.py");
    let row = &gate(&python, &script, "inside").suites[0];
    assert!(row.queries > 400);
    assert_eq!(refused(row), 0, "{:?}", row.failures);
    // Of points within its tolerance of the boundary it says that they are on it, which is no side.
    assert!(row.wrong * 20 < row.queries, "{:?}", row.failures);
    assert!(row.undecided * 2 < row.queries);
}
