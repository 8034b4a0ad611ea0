//! Reports: a table, `report.json` and `report.md`.

use feeler_corpus::{Ceilings, Fault};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

/// A query that fell short, and how to repeat it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// `wrong`, `indeterminate`, `undecided`; `right` for the largest error above a ceiling.
    pub verdict: String,
    /// The kind of the query, by the protocol's word.
    #[serde(default)]
    pub kind: String,
    /// Why.
    pub reason: String,
    /// File and line of the query.
    pub place: String,
    /// A command line that repeats it.
    pub command: String,
}

/// What one suite gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The suite.
    pub suite: String,
    /// What it is about.
    pub description: String,
    /// How many queries.
    pub queries: usize,
    /// How many more the engine does not treat, and was not asked.
    pub not_asked: usize,
    /// Wrong answers.
    pub wrong: usize,
    /// In what they failed.
    pub faults: BTreeMap<Fault, usize>,
    /// Answers that the truth cannot judge.
    pub indeterminate: usize,
    /// Bounds wider than asked, or none.
    pub undecided: usize,
    /// Answers of which nothing was proven.
    pub unbounded: usize,
    /// Worst error of a right answer, in ulp of the true value.
    pub error_ulp: Option<f64>,
    /// Worst error of a right answer, in model units.
    pub error_length: Option<f64>,
    /// Worst relative error of a first derivative.
    pub derivative_error: Option<f64>,
    /// Median time of a query in microseconds, preparation included in each model's first.
    pub median_microseconds: f64,
    /// The 99th percentile of the times.
    pub p99_microseconds: f64,
    /// Time of all its queries in seconds.
    pub seconds: f64,
    /// The kinds of queries that were asked, by the protocol's words: how many, and their time in seconds.
    #[serde(default)]
    pub kinds: BTreeMap<String, (usize, f64)>,
    /// The ceilings that it was held against.
    pub ceilings: Ceilings,
    /// Which ceilings were exceeded; empty if the suite passed.
    pub short: Vec<String>,
    /// The queries behind it, worst first.
    pub failures: Vec<Failure>,
    /// All answers, where they are kept: file and line of the query, a tab, and the answer as the protocol writes it. Numbers are in
    /// the shortest form that reads back the same, so that equal lines are equal bits.
    #[serde(skip)]
    pub answers: Vec<String>,
}

/// What a run of the gate gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Name and version of the engine.
    pub engine: String,
    /// A value without bounds of its own might be off by this part of the model's size.
    pub tolerance: f64,
    /// A row a suite.
    pub suites: Vec<Row>,
}

const HEADER: [&str; 8] = [
    "suite",
    "queries",
    "wrong",
    "indeterminate",
    "undecided",
    "worst ulp",
    "worst length",
    "median us",
];

/// How many queries that fell short are shown of a suite.
const SHOWN: usize = 5;

impl Row {
    fn cells(&self) -> [String; 8] {
        let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2e}"));
        /// Above this nobody reads digits.
        const LARGE: f64 = 1e6;
        let ulp = |x: Option<f64>| match x {
            Some(x) if x < LARGE => format!("{x:.2}"),
            large => number(large),
        };
        [
            self.suite.clone(),
            self.queries.to_string(),
            self.wrong.to_string(),
            self.indeterminate.to_string(),
            self.undecided.to_string(),
            ulp(self.error_ulp),
            number(self.error_length),
            format!("{:.1}", self.median_microseconds),
        ]
    }
}

impl Report {
    /// Whether every suite stayed within its ceilings.
    pub fn passed(&self) -> bool {
        !self.suites.is_empty() && self.suites.iter().all(|r| r.short.is_empty())
    }

    /// The table as text, columns aligned.
    pub fn table(&self) -> String {
        let rows: Vec<[String; 8]> = std::iter::once(HEADER.map(str::to_owned))
            .chain(self.suites.iter().map(Row::cells))
            .collect();
        let width = |c: usize| rows.iter().map(|r| r[c].len()).max().unwrap_or(0);
        let mut text = String::new();
        for row in &rows {
            let mut line = format!("{:<w$}", row[0], w = width(0));
            for (c, cell) in row.iter().enumerate().skip(1) {
                let _ = write!(line, "  {cell:>w$}", w = width(c));
            }
            text.push_str(&line);
            text.push('\n');
        }
        text
    }

    /// What fell short, with the commands that repeat it; empty if all passed.
    pub fn shortfalls(&self) -> String {
        let mut text = String::new();
        for row in self.suites.iter().filter(|r| !r.short.is_empty()) {
            let _ = writeln!(text, "{}: {}", row.suite, row.short.join("; "));
            for f in row.failures.iter().take(SHOWN) {
                let _ = writeln!(text, "  {} at {}: {}", f.verdict, f.place, f.reason);
                let _ = writeln!(text, "    {}", f.command);
            }
            if let Some(more) = row.failures.len().checked_sub(SHOWN).filter(|n| *n > 0) {
                let _ = writeln!(text, "  and {more} more in report.json");
            }
        }
        text
    }

    /// The report as Markdown.
    pub fn markdown(&self) -> String {
        let verdict = if self.passed() { "passed" } else { "FAILED" };
        let mut text = format!("# Gate: {verdict}\n\nEngine: {}\n\n", self.engine);
        let _ = writeln!(text, "| {} |", HEADER.join(" | "));
        let _ = writeln!(text, "|---|{}", "--:|".repeat(HEADER.len() - 1));
        for row in &self.suites {
            let _ = writeln!(text, "| {} |", row.cells().join(" | "));
        }
        text.push('\n');
        for row in &self.suites {
            let _ = writeln!(text, "- **{}**: {}", row.suite, row.description);
        }
        let short = self.shortfalls();
        if !short.is_empty() {
            let _ = write!(text, "\n## What fell short\n\n```text\n{short}```\n");
        }
        text
    }

    /// Writes `report.json` and `report.md` into a folder, which is made if need be.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let json = serde_json::to_string_pretty(self)?;
        std::fs::write(folder.join("report.json"), json + "\n")?;
        std::fs::write(folder.join("report.md"), self.markdown())
    }

    /// Writes the answers that were kept, one a line, into a file, whose folder is made if need be.
    pub fn write_answers(&self, path: &Path) -> std::io::Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let mut out = BufWriter::new(File::create(path)?);
        for line in self.suites.iter().flat_map(|s| &s.answers) {
            writeln!(out, "{line}")?;
        }
        out.flush()
    }
}
