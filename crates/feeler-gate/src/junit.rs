//! A report as JUnit XML, which CI systems show.
//!
//! A test suite each suite: a test case for its ceilings, and one for each kind of query in it. Where ceilings were
//! exceeded, the kinds whose queries are behind it fail, and their text names these queries, with the command that repeats
//! each.

use crate::baseline::Comparison;
use crate::report::{Failure, Report, Row};
use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};
use std::path::Path;
use std::time::Duration;

/// So many queries of a kind are listed, the worst first; the rest stand in report.json.
const LISTED: usize = 50;

fn failed(name: &str, kind: &str, message: &str, text: &str) -> TestCase {
    let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
    status.set_type(kind).set_message(message);
    if !text.is_empty() {
        status.set_description(text);
    }
    TestCase::new(name, status)
}

/// Whether what a query earned is more than its suite lets pass.
fn counts(row: &Row, failure: &Failure) -> bool {
    let ceilings = &row.ceilings;
    match failure.verdict.as_str() {
        "wrong" => row.wrong > ceilings.wrong,
        "indeterminate" => row.indeterminate > ceilings.indeterminate,
        "undecided" => row.undecided > ceilings.undecided || row.unbounded > ceilings.unbounded,
        // Right, but with the largest error, above its ceiling.
        _ => true,
    }
}

fn suite(row: &Row) -> TestSuite {
    let mut suite = TestSuite::new(&row.suite);
    suite.set_time(Duration::try_from_secs_f64(row.seconds).unwrap_or_default());
    let mut cases = vec![match row.short.is_empty() {
        true => TestCase::new("ceilings", TestCaseStatus::success()),
        false => failed("ceilings", "ceiling", &row.short.join("; "), ""),
    }];
    for (kind, (queries, seconds)) in &row.kinds {
        let own = row.failures.iter().filter(|f| f.kind == *kind);
        let behind: Vec<&Failure> = own.filter(|f| counts(row, f)).collect();
        let mut case = match behind.first() {
            Some(worst) if !row.short.is_empty() => {
                let listed = behind
                    .iter()
                    .take(LISTED)
                    .map(|f| format!("{}: {}: {}\n{}", f.place, f.verdict, f.reason, f.command));
                let text = listed.collect::<Vec<_>>().join("\n");
                let message = format!("{} of {queries} queries fell short", behind.len());
                failed(kind, &worst.verdict, &message, &text)
            }
            _ => TestCase::new(kind, TestCaseStatus::success()),
        };
        case.set_time(Duration::try_from_secs_f64(*seconds).unwrap_or_default());
        cases.push(case);
    }
    for mut case in cases {
        case.set_classname(&row.suite);
        suite.add_test_case(case);
    }
    suite
}

impl Report {
    /// The report as JUnit XML. Against an earlier report (where it is given) the regressions decide, a
    /// test case each, and no ceilings.
    pub fn junit(&self, comparison: Option<&Comparison>) -> String {
        let mut report = quick_junit::Report::new(&self.engine);
        match comparison {
            None => {
                report.add_test_suites(self.suites.iter().map(suite));
            }
            Some(comparison) => {
                let mut suite = TestSuite::new("baseline");
                let regressions = comparison.regressions.iter();
                suite.add_test_cases(regressions.map(|r| failed(r, "regression", r, "")));
                if comparison.passed() {
                    let case = TestCase::new("no regression", TestCaseStatus::success());
                    suite.add_test_case(case);
                }
                if !comparison.changed.is_empty() {
                    suite.set_system_out(comparison.changed.join("\n"));
                }
                report.add_test_suite(suite);
            }
        }
        // It refuses what is no XML, and takes such characters out itself: there is nothing left to refuse.
        report.to_string().unwrap_or_default()
    }

    /// Writes the report as JUnit XML.
    ///
    /// # Errors
    /// Those of the system.
    pub fn write_junit(&self, path: &Path, comparison: Option<&Comparison>) -> std::io::Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        std::fs::write(path, self.junit(comparison))
    }
}
