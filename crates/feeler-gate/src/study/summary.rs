//! The summary in Markdown.

use super::Study;
use super::table::{Table, balls, errors, extremes, left_out, verdicts};
use std::fmt::Write as _;

fn table(text: &mut String, table: &Table) {
    // A bar inside a cell would end it.
    let line = |cells: &[String]| cells.join(" | ").replace('\n', " ");
    let _ = writeln!(text, "{}\n", table.note);
    let _ = writeln!(text, "| {} |", line(&table.head));
    let _ = writeln!(text, "|{}", "---|".repeat(table.head.len()));
    for row in &table.rows {
        let _ = writeln!(text, "| {} |", line(row));
    }
    text.push('\n');
}

impl Study {
    /// What was measured, in words and numbers of text.
    pub fn about_lines(&self) -> Vec<String> {
        let a = &self.about;
        vec![
            format!("feeler {} at commit {}, {}", a.version, a.commit, a.compiler),
            format!("{} ({} threads, one used), {}", a.processor, a.threads, a.system),
            format!(
                "{} queries of each suite, spread evenly (no random choice), {} rounds in which the engines take turns; an engine that \
                 has used {} s on one model is asked no more of it",
                self.plan.sample, self.plan.repetitions, self.plan.seconds
            ),
            "the truth is the oracle's (CGAL), stored with the corpus; its width is the floor of the plots".to_owned(),
        ]
    }

    /// The report as Markdown.
    pub fn summary(&self) -> String {
        let mut text = "# Error against run time\n\n".to_owned();
        for line in self.about_lines() {
            let _ = writeln!(text, "- {line}");
        }
        text.push_str("\n## Table 1 of the thesis\n\n");
        table(&mut text, &balls(self));
        text.push_str("## Verdicts\n\n");
        table(&mut text, &verdicts(self));
        text.push_str("## Cases of stress\n\n");
        table(&mut text, &extremes(self));
        text.push_str("## What is left out\n\n");
        table(&mut text, &left_out(self));
        text.push_str("## Errors and times by suite\n\n");
        for suite in &self.suites {
            let _ = writeln!(text, "### {}\n\n{}\n", suite.suite, suite.description);
            table(&mut text, &errors(suite));
        }
        text.push_str("## Omissions\n\n");
        for line in &self.omissions {
            let _ = writeln!(text, "- {line}");
        }
        text
    }
}
