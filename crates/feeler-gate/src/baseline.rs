//! A report against an earlier one.
//!
//! What became worse is a regression; what became better never is, and times are not compared. Shares of queries are
//! compared, not counts, so that a corpus may grow.

use crate::report::{Report, Row};
use feeler_corpus::{Ceilings, Fault};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{Error, ErrorKind};
use std::path::Path;

/// The worst error may double (one bit) before it is called a regression.
pub const ERROR_FACTOR: f64 = 2.0;
/// An error up to this is one rounding, which no engine need keep below.
const ROUNDING_ULP: f64 = 0.5;

/// How a report differs from an earlier one. Each entry is one line that begins with the suite.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Comparison {
    /// What became worse; any of them fails the gate.
    pub regressions: Vec<String>,
    /// What is held against has changed since: ceilings of the corpus, the tolerance. A reader must see it, since
    /// a ceiling that was loosened lets more pass.
    pub changed: Vec<String>,
}

impl Report {
    /// Reads a `report.json`.
    ///
    /// # Errors
    /// It cannot be read, or is no report of this version.
    pub fn read(path: &Path) -> std::io::Result<Self> {
        let text = std::fs::read_to_string(path)?;
        serde_json::from_str(&text).map_err(|e| {
            let why =
                format!("no report.json of this version ({e}); run the gate again to get one");
            Error::new(ErrorKind::InvalidData, why)
        })
    }

    /// Compares with an earlier report. Suites that were not run now are regressions where `whole` says that all were
    /// meant to be.
    pub fn against(&self, before: &Self, whole: bool) -> Comparison {
        let mut all = Comparison::default();
        if self.tolerance != before.tolerance {
            let (was, is) = (before.tolerance, self.tolerance);
            let both = [was, is].map(|t| format!("{t:e}"));
            all.change("all suites", "tolerance", both, is > was);
        }
        for row in &self.suites {
            match before.suites.iter().find(|b| b.suite == row.suite) {
                Some(before) => all.suite(row, before),
                // New: there is nothing but its ceilings to hold it against.
                None => {
                    let short = row.short.iter();
                    let short = short.map(|s| format!("{}: new, and {s}", row.suite));
                    all.regressions.extend(short);
                }
            }
        }
        let run = |name: &str| self.suites.iter().any(|r| r.suite == name);
        for row in before.suites.iter().filter(|b| whole && !run(&b.suite)) {
            all.regressions
                .push(format!("{}: was run before, and not now", row.suite));
        }
        all
    }
}

impl Comparison {
    /// Whether nothing became worse.
    pub fn passed(&self) -> bool {
        self.regressions.is_empty()
    }

    /// What there is to say, a line each; empty if nothing.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for line in &self.regressions {
            let _ = writeln!(text, "regression: {line}");
        }
        for line in &self.changed {
            let _ = writeln!(text, "changed: {line}");
        }
        text
    }

    fn change(&mut self, suite: &str, what: &str, [was, is]: [String; 2], looser: bool) {
        let way = if looser { "loosened" } else { "tightened" };
        self.changed
            .push(format!("{suite}: {what}: {was} before, {is} now: {way}"));
    }

    fn suite(&mut self, now: &Row, before: &Row) {
        let fault = |row: &Row, f: &Fault| row.faults.get(f).copied().unwrap_or(0);
        let mut counts = vec![
            ("wrong".to_owned(), now.wrong, before.wrong),
            (
                "indeterminate".to_owned(),
                now.indeterminate,
                before.indeterminate,
            ),
            ("undecided".to_owned(), now.undecided, before.undecided),
            ("unbounded".to_owned(), now.unbounded, before.unbounded),
        ];
        let faults: BTreeSet<&Fault> = now.faults.keys().chain(before.faults.keys()).collect();
        for f in faults {
            counts.push((format!("wrong by {f:?}"), fault(now, f), fault(before, f)));
        }
        for (what, is, was) in counts {
            // is / now.queries > was / before.queries, exactly.
            if is as u128 * before.queries as u128 > was as u128 * now.queries as u128 {
                self.regressions.push(format!(
                    "{}: {what}: {was} of {} before, {is} of {} now",
                    now.suite, before.queries, now.queries
                ));
            }
        }
        let (all, all_before) = (
            now.queries + now.not_asked,
            before.queries + before.not_asked,
        );
        if now.not_asked as u128 * all_before as u128 > before.not_asked as u128 * all as u128 {
            self.regressions.push(format!(
                "{}: not treated: {} of {all_before} before, {} of {all} now",
                now.suite, before.not_asked, now.not_asked
            ));
        }
        for (what, is, was, floor) in [
            (
                "error in ulp",
                now.error_ulp,
                before.error_ulp,
                ROUNDING_ULP,
            ),
            (
                "error in length",
                now.error_length,
                before.error_length,
                0.0,
            ),
            (
                "derivative error",
                now.derivative_error,
                before.derivative_error,
                0.0,
            ),
        ] {
            if let (Some(is), Some(was)) = (is, was)
                && is > ERROR_FACTOR * was.max(floor)
            {
                self.regressions.push(format!(
                    "{}: worst {what}: {was:.3e} before, {is:.3e} now: more than {ERROR_FACTOR} times",
                    now.suite
                ));
            }
        }
        self.ceilings(&now.suite, &now.ceilings, &before.ceilings);
    }

    fn ceilings(&mut self, suite: &str, now: &Ceilings, before: &Ceilings) {
        for (what, is, was) in [
            ("wrong", now.wrong, before.wrong),
            ("indeterminate", now.indeterminate, before.indeterminate),
            ("undecided", now.undecided, before.undecided),
            ("unbounded", now.unbounded, before.unbounded),
        ] {
            if is != was {
                let both = [was, is].map(|c| c.to_string());
                self.change(suite, &format!("the ceiling on {what}"), both, is > was);
            }
        }
        for (what, is, was) in [
            ("error in ulp", now.error_ulp, before.error_ulp),
            ("error in length", now.error_length, before.error_length),
            (
                "derivative error",
                now.derivative_error,
                before.derivative_error,
            ),
        ] {
            if is != was {
                // No ceiling lets everything pass.
                let looser = is.unwrap_or(f64::INFINITY) > was.unwrap_or(f64::INFINITY);
                let both = [was, is].map(|c| c.map_or("none".to_owned(), |c| format!("{c:e}")));
                self.change(suite, &format!("the ceiling on {what}"), both, looser);
            }
        }
    }
}
