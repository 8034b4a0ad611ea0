//! A report as JUnit XML, which CI systems show.
//!
//! A test suite each suite. Its first test case is the suite as a whole, against its ceilings; where these were
//! exceeded, the queries that fell short follow, each with the command that repeats it.

use crate::baseline::Comparison;
use crate::report::{Report, Row};
use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};
use std::path::Path;
use std::time::Duration;

/// So many queries of a suite are listed, the worst first; the rest stand in report.json.
const LISTED: usize = 50;

fn failed(name: &str, kind: &str, message: &str, text: &str) -> TestCase {
    let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
    status.set_type(kind).set_message(message);
    if !text.is_empty() {
        status.set_description(text);
    }
    TestCase::new(name, status)
}

fn suite(row: &Row) -> TestSuite {
    let mut suite = TestSuite::new(&row.suite);
    suite.set_time(Duration::try_from_secs_f64(row.seconds).unwrap_or_default());
    if row.short.is_empty() {
        let mut case = TestCase::new("ceilings", TestCaseStatus::success());
        case.set_classname(&row.suite);
        suite.add_test_case(case);
        return suite;
    }
    let mut cases = vec![failed("ceilings", "ceiling", &row.short.join("; "), "")];
    cases.extend(row.failures.iter().take(LISTED).map(|f| {
        let name = format!("{} at {}", f.verdict, f.place);
        failed(&name, &f.verdict, &f.reason, &f.command)
    }));
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
