//! How the gate's reports look, on a report made up here: the layout alone is fixed.

use std::collections::BTreeMap;

use feeler_corpus::Ceilings;
use feeler_gate::{Failure, Report, Row};

fn row(suite: &str) -> Row {
    Row {
        suite: suite.to_owned(),
        description: format!("what {suite} is about"),
        queries: 1200,
        not_asked: 0,
        wrong: 0,
        faults: BTreeMap::new(),
        indeterminate: 0,
        undecided: 3,
        unbounded: 0,
        error_ulp: Some(0.5),
        error_length: Some(1.25e-15),
        derivative_error: None,
        median_microseconds: 12.34,
        p99_microseconds: 99.9,
        ceilings: Ceilings::default(),
        short: Vec::new(),
        failures: Vec::new(),
    }
}

fn report() -> Report {
    let sides = Row {
        error_ulp: None,
        error_length: None,
        ..row("sides")
    };
    let failure = |number: usize| Failure {
        verdict: "wrong".to_owned(),
        reason: "the side is outside".to_owned(),
        place: format!("corpora/fallen/queries.jsonl:{number}"),
        command: "echo '{}' | feeler contact part.3dm".to_owned(),
    };
    let fallen = Row {
        wrong: 7,
        short: vec!["wrong 7, the ceiling is 0".to_owned()],
        failures: (1..=7).map(failure).collect(),
        ..row("fallen")
    };
    Report {
        engine: "engine 1.2.3".to_owned(),
        tolerance: 0.0,
        suites: vec![row("spheres"), sides, fallen],
    }
}

#[test]
fn table() {
    let report = report();
    insta::assert_snapshot!(format!("{}\n{}", report.table(), report.shortfalls()));
}

#[test]
fn markdown() {
    insta::assert_snapshot!(report().markdown());
}

#[test]
fn a_report_without_suites_has_not_passed() {
    let mut report = report();
    assert!(!report.passed());
    report.suites.pop();
    assert!(report.passed());
    report.suites.clear();
    assert!(!report.passed());
}
