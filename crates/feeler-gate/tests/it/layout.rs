//! How the gate's reports look, on a report made up here: the layout alone is fixed.

use std::collections::BTreeMap;

use feeler_corpus::Ceilings;
use feeler_gate::{Comparison, Failure, Report, Row};

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
        seconds: 1.5,
        kinds: BTreeMap::from([
            ("inside".to_owned(), (200, 0.5)),
            ("side".to_owned(), (1000, 1.0)),
        ]),
        ceilings: Ceilings::default(),
        short: Vec::new(),
        failures: Vec::new(),
        answers: Vec::new(),
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
        kind: "side".to_owned(),
        reason: "the side is outside".to_owned(),
        place: format!("corpora/fallen/queries.jsonl:{number}"),
        command: "echo '{\"id\":1}' | feeler contact part.3dm".to_owned(),
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

#[test]
fn junit() {
    insta::assert_snapshot!(report().junit(None));
}

#[test]
fn junit_against_a_baseline() {
    let comparison = Comparison {
        regressions: vec!["spheres: wrong: 0 of 1200 before, 1 of 1200 now".to_owned()],
        changed: vec!["sides: the ceiling on undecided: 3 before, 4 now: loosened".to_owned()],
    };
    insta::assert_snapshot!(report().junit(Some(&comparison)));
    assert!(
        report()
            .junit(Some(&Comparison::default()))
            .contains("failures=\"0\"")
    );
}

/// Lists of more than is of use are cut, and what XML cannot hold is left out.
#[test]
fn junit_of_many_failures() {
    let mut report = report();
    let fallen = report.suites.last_mut().unwrap();
    let one = fallen.failures[0].clone();
    fallen.failures = vec![one; 1000];
    fallen.failures[0].reason = "a bell \u{7}, a < b & \"c\"".to_owned();
    let text = report.junit(None);
    // The ceilings, and the kind that all of them are of.
    assert_eq!(text.matches("<failure").count(), 2);
    assert_eq!(text.matches("queries.jsonl:").count(), 50);
    assert!(text.contains("1000 of 1000 queries fell short"));
    assert!(text.contains("a &lt; b &amp; ") && !text.contains('\u{7}'));
}
