//! Several engines at work on the models of a suite.

use feeler_gate::{Engine, Gate, Report, ThesisEngine, run};
use std::path::Path;

fn report(jobs: usize, suite: &str) -> (Report, Vec<usize>) {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let gate = Gate {
        corpus: &here.ancestors().nth(2).unwrap().join("corpora"),
        suite: Some(suite),
        tolerance: 1e-6,
        sample: None,
        answers: false,
    };
    let mut engines: Vec<_> = (0..jobs).map(|_| ThesisEngine::new(1)).collect();
    let mut all: Vec<&mut dyn Engine> = Vec::new();
    for engine in &mut engines {
        all.push(engine);
    }
    let mut steps = Vec::new();
    let mut report = run(&mut all, &gate, &mut |p| steps.push(p.done)).unwrap();
    for row in &mut report.suites {
        (row.median_microseconds, row.p99_microseconds, row.seconds) = (0.0, 0.0, 0.0);
        row.kinds.values_mut().for_each(|k| k.1 = 0.0);
    }
    (report, steps)
}

/// The thesis's method fails often enough for the order of the failures to show.
#[test]
fn the_report_does_not_depend_on_how_many_there_are() {
    for suite in ["contact-sphere", "side"] {
        let (alone, steps) = report(1, suite);
        let row = &alone.suites[0];
        assert!(
            row.queries > 100 && row.failures.len() > 5,
            "{suite}: {row:?}"
        );
        // Each query is a step, and the bar never goes back.
        assert_eq!(steps, (0..=row.queries + row.not_asked).collect::<Vec<_>>());
        for jobs in [2, 3] {
            assert_eq!(report(jobs, suite), (alone.clone(), steps.clone()));
        }
    }
}

#[test]
fn without_engines_nothing_is_asked() {
    let gate = Gate {
        corpus: &Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora"),
        suite: Some("inside"),
        tolerance: 0.0,
        sample: None,
        answers: false,
    };
    let report = run(&mut [], &gate, &mut |_| ()).unwrap();
    assert_eq!(report.suites[0].queries, 0);
    assert!(!report.passed());
}
