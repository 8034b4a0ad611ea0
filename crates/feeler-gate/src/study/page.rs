//! The page: one HTML file that needs nothing else.

use super::contender::LESS;
use super::plot::{Curve, Mark, Plot};
use super::table::{Table, balls, errors, extremes, left_out, verdicts};
use super::{Point, Study, SuiteStudy};
use crate::plot::colour;
use feeler_corpus::Fault;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Errors in model units below this are drawn on it: below the rounding of coordinates of size 1 by far.
const LEAST_LENGTH: f64 = 1e-18;
/// Errors in ulp below this are drawn on it.
const LEAST_ULP: f64 = 1e-2;

const STYLE: &str = "
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff; margin: 0 auto; padding: 1rem; max-width: 80rem; }
h1, h2, h3 { line-height: 1.2; } h2 { margin-top: 2.5rem; border-bottom: 1px solid #ccc; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 30rem), 1fr)); gap: 1rem; }
svg { max-width: 100%; height: auto; }
figure { margin: 0; overflow-x: auto; } figure svg { min-width: 30rem; } figcaption { font-size: .85rem; color: #555; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .8rem; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .5rem; text-align: right; border-bottom: 1px solid #eee; white-space: nowrap; }
th { text-align: right; background: #f6f6f6; white-space: normal; vertical-align: bottom; }
th.over { text-align: center; border-left: 1px solid #ccc; }
th.text, td.text { text-align: left; } td.long { white-space: normal; min-width: 16rem; } td.none { color: #bbb; }
tr.ours td { background: #eef6fb; }
.key { list-style: none; padding: 0; display: flex; flex-wrap: wrap; gap: .2rem 1.2rem; }
.key i { display: inline-block; width: .8rem; height: .8rem; border-radius: 50%; margin-right: .35rem; }
pre { overflow-x: auto; background: #f6f6f6; padding: .5rem; font-size: .75rem; }
summary { cursor: pointer; }
";

impl Study {
    /// The report as a page.
    pub fn page(&self) -> String {
        let names = self.engines();
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { "feeler: error against run time" }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    h1 { "Error against run time" }
                    ul { @for line in self.about_lines() { li { (line) } } }
                    nav { a href="#balls" { "Table 1 of the thesis" } " · " a href="#verdicts" { "verdicts" } " · "
                        a href="#cases" { "cases of stress" } " · " a href="#left-out" { "what is left out" } " · " a href="#witnesses" { "witnesses" } " · "
                        a href="#omissions" { "omissions" } }
                    h2 { "How to read the plots" }
                    p { "Each dot is an engine at one setting: to the left is faster, down is more exact. The dot is the largest error, the ring "
                        "the 99th percentile; the bar reaches from the fastest to the slowest of the rounds' medians, of which the first includes what is prepared on first use. Behind a setting, "
                        "“n wrong” counts answers that are wrong in more than their value: contacts missed or made up, sides, counts of hits; “n undecided” those that give a bound only, whose errors are not shown. "
                        "An error of 0 is drawn at the lower edge." }
                    ul.key { @for (k, name) in names.iter().enumerate() {
                        li { i style=(format!("background: rgb{:?}", rgb(k))) {} (name) } } }
                    @for suite in &self.suites { (section(suite, &names)) }
                    (titled("balls", "Table 1 of the thesis", &balls(self)))
                    (titled("verdicts", "Verdicts", &verdicts(self)))
                    (titled("cases", "Cases of stress", &extremes(self)))
                    (titled("left-out", "What is left out", &left_out(self)))
                    h2 #witnesses { "Witnesses" }
                    p { "The gravest failures of each engine on each suite, with a command that asks feeler the same." }
                    @for suite in &self.suites { @for point in &suite.points { (witnesses(suite, point)) } }
                    h2 #omissions { "Omissions" }
                    ul { @for line in &self.omissions { li { (line) } } }
                }
            }
        }
        .into_string()
    }
}

fn rgb(k: usize) -> (u8, u8, u8) {
    let c = colour(k);
    (c.0, c.1, c.2)
}

fn section(suite: &SuiteStudy, names: &[String]) -> Markup {
    let floor = suite.floor.filter(|f| *f > 0.0);
    let lengths = Plot {
        x: "median microseconds a query".to_owned(),
        y: "error, model units".to_owned(),
        curves: curves(suite, |p| p.error.map(|e| (e.max, e.p99))),
        floor: floor.map(|f| (f, format!("truth known to {f:.0e}"))),
        least: LEAST_LENGTH,
    };
    let ulps = Plot {
        y: "error, ulp of the true value".to_owned(),
        curves: curves(suite, |p| p.ulps.map(|e| (e.max, e.p99))),
        floor: None,
        least: LEAST_ULP,
        ..lengths.clone()
    };
    let has_curves = lengths.curves.iter().any(|c| !c.marks.is_empty());
    html! {
        h2 id=(suite.suite) { (suite.suite) }
        p { (suite.description) " (" (suite.queries) " queries)" }
        @if has_curves {
            div.plots {
                figure { (PreEscaped(lengths.svg(names))) figcaption { "Error in model units." } }
                figure { (PreEscaped(ulps.svg(names))) figcaption { "The same in units in the last place of the true value." } }
            }
        }
        details open[!has_curves] { summary { "Numbers" } (table(&errors(suite))) }
    }
}

/// A curve an engine; `of` gives the largest error and the 99th percentile.
fn curves(suite: &SuiteStudy, of: impl Fn(&Point) -> Option<(f64, f64)>) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for p in &suite.points {
        let Some((max, p99)) = of(p) else { continue };
        let grave: usize = [
            Fault::MissedContact,
            Fault::FalseContact,
            Fault::Side,
            Fault::Hits,
            Fault::Roots,
        ]
        .iter()
        .filter_map(|f| p.faults.get(f))
        .sum();
        let label = match (grave, p.undecided) {
            (0, 0) => p.setting.clone(),
            (0, n) => format!("{} ({n} undecided)", p.setting),
            (n, _) => format!("{} ({n} wrong)", p.setting),
        };
        let mark = Mark {
            x: p.between,
            at: p.microseconds.median,
            y: max,
            second: Some(p99),
            label,
        };
        match curves.iter_mut().find(|c| c.name == p.engine) {
            Some(curve) => curve.marks.push(mark),
            None => curves.push(Curve {
                name: p.engine.clone(),
                joined: p.engine != LESS,
                marks: vec![mark],
            }),
        }
    }
    // One dot alone says whose it is.
    for curve in &mut curves {
        if let [mark] = &mut curve.marks[..] {
            mark.label = format!("{} {}", curve.name, mark.label);
        }
    }
    curves
}

/// A headline and its table; nothing where there are no rows.
fn titled(id: &str, title: &str, rows: &Table) -> Markup {
    html! {
        @if !rows.rows.is_empty() {
            h2 id=(id) { (title) }
            (table(rows))
        }
    }
}

/// A cell of more letters than this is broken into lines.
const LONG: usize = 40;

fn table(table: &Table) -> Markup {
    // Columns with a word in some cell are set left.
    let is_word = |c: &String| c.starts_with(|l: char| l.is_alphabetic());
    let column = |k: usize| table.rows.iter().filter_map(move |r| r.get(k));
    let texts: Vec<bool> = (0..table.head.len())
        .map(|k| column(k).any(is_word))
        .collect();
    html! {
        p { (table.note) }
        div.wide { table {
            thead {
                @if !table.groups.is_empty() { tr { @for (name, count) in &table.groups { th.over[!name.is_empty()] colspan=(count) { (name) } } } }
                tr { @for (cell, text) in table.head.iter().zip(&texts) { th.text[*text] { (cell) } } }
            }
            tbody { @for row in &table.rows {
                tr.ours[row.iter().take(2).any(|c| c.starts_with("feeler"))] {
                    @for (cell, text) in row.iter().zip(&texts) {
                        td.text[*text].long[cell.len() > LONG].none[cell == "0" || cell == "-"] { (cell) }
                    }
                } } }
        } }
    }
}

fn witnesses(suite: &SuiteStudy, point: &Point) -> Markup {
    html! {
        @if !point.witnesses.is_empty() {
            details {
                summary { (suite.suite) ", " (point.engine) " " (point.setting) }
                @for w in &point.witnesses {
                    p { b { (w.verdict) } ": " (w.reason) " (" (w.place) ")" }
                    pre { (w.command) }
                }
            }
        }
    }
}
