//! A report against an earlier one: regressions are named, improvements pass, changed ceilings are listed.

use feeler_corpus::{Ceilings, Fault};
use feeler_gate::{Comparison, Report, Row};
use std::collections::BTreeMap;

fn row(suite: &str) -> Row {
    Row {
        suite: suite.to_owned(),
        description: String::new(),
        queries: 100,
        not_asked: 10,
        wrong: 3,
        faults: BTreeMap::from([(Fault::MissedContact, 1), (Fault::Value, 2)]),
        indeterminate: 0,
        undecided: 5,
        unbounded: 0,
        error_ulp: Some(8.0),
        error_length: Some(1e-12),
        derivative_error: Some(1e-15),
        median_microseconds: 10.0,
        p99_microseconds: 100.0,
        seconds: 1.0,
        kinds: BTreeMap::new(),
        ceilings: Ceilings {
            undecided: 5,
            error_ulp: Some(10.0),
            ..Ceilings::default()
        },
        short: Vec::new(),
        failures: Vec::new(),
        answers: Vec::new(),
    }
}

fn report(change: impl Fn(&mut Row)) -> Report {
    let mut second = row("second");
    change(&mut second);
    Report {
        engine: "engine 1".to_owned(),
        tolerance: 0.0,
        suites: vec![row("first"), second],
    }
}

fn compare(change: impl Fn(&mut Row)) -> Comparison {
    report(change).against(&report(|_| ()), true)
}

#[test]
fn the_same_passes() {
    assert_eq!(compare(|_| ()), Comparison::default());
}

#[test]
fn what_became_worse_is_named() {
    type Change = fn(&mut Row);
    let changes: [(Change, &str); 11] = [
        (
            |r| r.wrong = 4,
            "second: wrong: 3 of 100 before, 4 of 100 now",
        ),
        (
            |r| r.queries = 99,
            "second: wrong: 3 of 100 before, 3 of 99 now",
        ),
        (|r| r.undecided = 6, "second: undecided: 5 of 100 before, 6"),
        (|r| r.indeterminate = 1, "second: indeterminate: 0 of"),
        (|r| r.unbounded = 1, "second: unbounded: 0 of"),
        (
            |r| r.not_asked = 11,
            "second: not treated: 10 of 110 before, 11 of 111 now",
        ),
        // The same number of wrong answers, but graver ones.
        (
            |r| r.faults = BTreeMap::from([(Fault::MissedContact, 2), (Fault::Value, 1)]),
            "second: wrong by MissedContact: 1 of 100 before, 2",
        ),
        (
            |r| r.error_ulp = Some(16.1),
            "second: worst error in ulp: 8.000e0 before, 1.610e1",
        ),
        (
            |r| r.error_length = Some(2.1e-12),
            "second: worst error in length",
        ),
        (
            |r| r.derivative_error = Some(3e-15),
            "second: worst derivative error",
        ),
        (
            |r| r.suite = "other".to_owned(),
            "second: was run before, and not now",
        ),
    ];
    for (change, what) in changes {
        let found = compare(change);
        assert!(!found.passed());
        assert!(found.regressions[0].starts_with(what), "{what}: {found:?}");
        assert!(
            found.text().contains(&format!("regression: {what}")),
            "{found:?}"
        );
    }
    // One suite alone was meant to be run.
    let mut one = report(|_| ());
    one.suites.pop();
    assert!(one.against(&report(|_| ()), false).passed());
    assert!(!one.against(&report(|_| ()), true).passed());
}

#[test]
fn what_became_better_or_slower_passes() {
    let better = |r: &mut Row| {
        r.queries = 200;
        r.not_asked = 0;
        r.wrong = 1;
        r.faults = BTreeMap::from([(Fault::MissedContact, 1)]);
        r.undecided = 0;
        r.error_ulp = Some(0.5);
        r.error_length = None;
        r.derivative_error = Some(0.0);
        r.median_microseconds = 1e6;
        r.p99_microseconds = 1e6;
        r.seconds = 1e6;
    };
    assert_eq!(compare(better), Comparison::default());
    // Within the factor, and up to two roundings.
    assert!(compare(|r| r.error_ulp = Some(16.0)).passed());
    let exact = report(|r| r.error_ulp = Some(0.0));
    assert!(
        report(|r| r.error_ulp = Some(1.0))
            .against(&exact, true)
            .passed()
    );
    assert!(
        !report(|r| r.error_ulp = Some(1.1))
            .against(&exact, true)
            .passed()
    );
    // A new suite is held against its ceilings alone.
    let mut more = report(|_| ());
    more.suites.push(row("third"));
    assert!(more.against(&report(|_| ()), true).passed());
    more.suites[2].short = vec!["wrong 3, the ceiling is 0".to_owned()];
    let found = more.against(&report(|_| ()), true);
    assert_eq!(
        found.regressions,
        ["third: new, and wrong 3, the ceiling is 0"]
    );
}

#[test]
fn changed_ceilings_are_listed() {
    let loosened = compare(|r| {
        r.ceilings.undecided = 7;
        r.ceilings.error_ulp = None;
    });
    assert!(loosened.passed());
    assert_eq!(
        loosened.changed,
        [
            "second: the ceiling on undecided: 5 before, 7 now: loosened",
            "second: the ceiling on error in ulp: 1e1 before, none now: loosened",
        ]
    );
    let tightened = compare(|r| {
        r.ceilings.undecided = 4;
        r.ceilings.error_length = Some(1e-9);
    });
    assert_eq!(
        tightened.changed,
        [
            "second: the ceiling on undecided: 5 before, 4 now: tightened",
            "second: the ceiling on error in length: none before, 1e-9 now: tightened",
        ]
    );
    let mut report_now = report(|_| ());
    report_now.tolerance = 1e-6;
    let found = report_now.against(&report(|_| ()), true);
    assert_eq!(
        found.changed,
        ["all suites: tolerance: 0e0 before, 1e-6 now: loosened"]
    );
}

/// What the gate writes is what it reads.
#[test]
fn a_report_is_read_as_it_was_written() {
    let folder = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("baseline");
    let written = report(|r| r.error_ulp = None);
    written.write(&folder).unwrap();
    let read = Report::read(&folder.join("report.json")).unwrap();
    assert_eq!(read, written);
    std::fs::write(folder.join("old.json"), r#"{"engine":"e","suites":[]}"#).unwrap();
    let error = Report::read(&folder.join("old.json")).unwrap_err();
    assert!(error.to_string().contains("run the gate again"), "{error}");
}
