//! The summary in Markdown.

use super::Study;
use super::table::{Table, balls, errors, extremes, left_out, verdicts};
use std::fmt::Write as _;

fn table(text: &mut String, table: &Table) {
    // A bar inside a cell would end it.
    let line = |cells: &[String]| cells.join(" | ").replace('\n', " ");
    let _ = writeln!(text, "{}\n", table.note);
    // Markdown has one line of heads.
    let groups = table.groups.iter();
    let over: Vec<&str> = groups
        .flat_map(|(name, count)| std::iter::repeat_n(name.as_str(), *count))
        .collect();
    let head: Vec<String> = (0..table.head.len())
        .map(|k| match over.get(k) {
            Some(group) if !group.is_empty() => format!("{group}: {}", table.head[k]),
            _ => table.head[k].clone(),
        })
        .collect();
    let _ = writeln!(text, "| {} |", line(&head));
    let _ = writeln!(text, "|{}", "---|".repeat(table.head.len()));
    for row in &table.rows {
        let _ = writeln!(text, "| {} |", line(row));
    }
    text.push('\n');
}

/// A headline and its table; nothing where there are no rows.
fn section(text: &mut String, title: &str, rows: &Table) {
    if !rows.rows.is_empty() {
        let _ = writeln!(text, "\n## {title}\n");
        table(text, rows);
    }
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
        section(&mut text, "Table 1 of the thesis", &balls(self));
        section(&mut text, "Verdicts", &verdicts(self));
        section(&mut text, "Cases of stress", &extremes(self));
        section(&mut text, "What is left out", &left_out(self));
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
