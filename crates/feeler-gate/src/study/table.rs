//! The tables of a study, for page and summary alike.

use super::numbers::none_seen;
use super::{BALLS, Point, Study, SuiteStudy};
use feeler_corpus::Fault;

/// A table with a headline and a line on how to read it.
pub(crate) struct Table {
    pub(crate) note: String,
    /// Headlines over several columns each, all of them; or none.
    pub(crate) groups: Vec<(String, usize)>,
    pub(crate) head: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

fn strings<const N: usize>(head: [&str; N]) -> Vec<String> {
    head.map(str::to_owned).to_vec()
}

/// Three digits, or a dash.
fn number(x: Option<f64>) -> String {
    match x {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(x) if (0.01..10_000.0).contains(&x.abs()) => {
            let digits = (2 - x.abs().log10().floor() as i32).max(0) as usize;
            format!("{x:.digits$}")
        }
        Some(x) => format!("{x:.1e}"),
    }
}

/// A count of bytes with a unit.
fn bytes(count: Option<u64>) -> String {
    match count {
        None => "-".to_owned(),
        Some(b) if b < 10_000 => format!("{b} B"),
        Some(b) if b < 10_000_000 => format!("{:.0} kB", b as f64 / 1e3),
        Some(b) => format!("{:.0} MB", b as f64 / 1e6),
    }
}

fn faults(point: &Point, which: &[Fault]) -> usize {
    which.iter().filter_map(|f| point.faults.get(f)).sum()
}

/// Errors and times on one suite.
pub(crate) fn errors(suite: &SuiteStudy) -> Table {
    let rows = suite.points.iter().filter(|p| p.queries > 0).map(|p| {
        vec![
            p.engine.clone(),
            p.setting.clone(),
            p.queries.to_string(),
            number(Some(p.microseconds.median)),
            format!(
                "{} to {}",
                number(Some(p.between[0])),
                number(Some(p.between[1]))
            ),
            number(Some(p.microseconds.p999)),
            number(p.error.map(|e| e.p99)),
            number(p.error.map(|e| e.max)),
            number(p.ulps.map(|e| e.max)),
            number(p.width.map(|e| e.max)),
            number(Some(p.open_microseconds)),
            bytes(p.bytes.map(|b| b as u64)),
        ]
    });
    Table {
        groups: Vec::new(),
        note: "Times in microseconds, errors and widths in model units; of a spread, the medians of single rounds."
            .to_owned(),
        head: strings([
            "engine", "setting", "queries", "median", "spread", "p99.9", "error p99", "error max", "ulp max",
            "width max", "open", "memory",
        ]),
        rows: rows.collect(),
    }
}

/// What answers earned, by suite and engine.
pub(crate) fn verdicts(study: &Study) -> Table {
    let mut rows = Vec::new();
    for suite in &study.suites {
        for p in suite.points.iter().filter(|p| p.queries > 0) {
            let wrong: usize = p.faults.values().sum();
            // What was not seen may still be: the upper bound stands beside it.
            let bound = match wrong {
                0 => format!("< {:.2} %", 100.0 * none_seen(p.queries)),
                _ => format!("{:.2} %", 100.0 * wrong as f64 / p.queries as f64),
            };
            let mut row = vec![
                suite.suite.clone(),
                p.engine.clone(),
                p.setting.clone(),
                p.queries.to_string(),
                p.right.to_string(),
            ];
            let groups: [&[Fault]; 6] = [
                &[Fault::MissedContact],
                &[Fault::FalseContact],
                &[Fault::Side],
                &[Fault::Hits, Fault::Roots],
                &[Fault::Value, Fault::Place, Fault::Continuum],
                &[Fault::Refused],
            ];
            row.extend(groups.map(|g| faults(p, g).to_string()));
            row.extend([
                p.undecided.to_string(),
                p.indeterminate.to_string(),
                (p.not_asked + p.not_reached).to_string(),
                bound,
            ]);
            rows.push(row);
        }
    }
    Table {
        groups: Vec::new(),
        note: format!(
            "A value without bounds counts as right within {:e} of the model's size, a certified one only within its own bounds. \
             Of several faults of one answer the gravest is counted. The last column is the share of wrong answers; where none was \
             seen, its upper bound at 95 % confidence (3/n).",
            super::TOLERANCE
        ),
        head: strings([
            "suite",
            "engine",
            "setting",
            "queries",
            "right",
            "missed contact",
            "false contact",
            "wrong side",
            "wrong count",
            "wrong value",
            "refused",
            "undecided",
            "indeterminate",
            "not asked",
            "share wrong",
        ]),
        rows,
    }
}

/// Table 1 of the thesis.
pub(crate) fn balls(study: &Study) -> Table {
    let mut head = strings(["engine", "part", "file", "memory", "first ms"]);
    let mut groups = vec![(String::new(), head.len())];
    for (radius, off) in BALLS {
        let own = strings(["us", "p99.9", "error mm", "missed"]);
        groups.push((format!("{radius} mm ball, {off} mm off"), own.len()));
        head.extend(own);
    }
    let rows = study.balls.iter().map(|r| {
        let part = r.model.rsplit('/').next().unwrap_or(&r.model);
        let mut row = vec![
            r.engine.clone(),
            part.to_owned(),
            bytes(r.file_bytes),
            bytes(r.bytes.map(|b| b as u64)),
            number(Some(r.open_milliseconds)),
        ];
        for cell in &r.balls {
            row.push(number(Some(cell.microseconds.median)));
            row.push(number(Some(cell.microseconds.p999)));
            row.push(number(Some(cell.error.max)));
            row.push(cell.missed.to_string());
        }
        if let Some(error) = &r.error {
            row.push(error.clone());
        }
        row.resize(head.len(), "-".to_owned());
        row
    });
    Table {
        groups,
        note: "Balls in the spherical hole of radius 2.5 mm, each in 64 places around its centre: microseconds an update (median, \
               and p99.9), largest error of the separation (what is below the rounding of the hole, 2e-15, is 0), and how many overlaps \
               were missed; before, what it takes to open the part and answer a first query. A mesh's file is counted as binary STL. The thesis's own figures were 70 to 630 ms a step."
            .to_owned(),
        rows: rows.collect(),
        head,
    }
}

/// What it saves to leave work out.
pub(crate) fn left_out(study: &Study) -> Table {
    let rows = study.left_out.iter().map(|r| {
        vec![
            r.what.clone(),
            r.suite.clone(),
            r.queries.to_string(),
            number(Some(r.less)),
            number(Some(r.full)),
            number(Some(r.ratio)),
            format!("{} / {}", r.undecided[0], r.undecided[1]),
        ]
    });
    Table {
        groups: Vec::new(),
        note: "The same queries both ways in one run: median microseconds with the shortcut and without, the median of the single queries' ratios \
               (above 1, the shortcut saves), and how many were undecided with / without: without convexity the node budget ends. What is \
               prepared on first use is not in it, unless a query takes too long to be asked twice."
            .to_owned(),
        head: strings([
            "what is done, against what",
            "suite",
            "queries",
            "with: us",
            "without: us",
            "ratio",
            "undecided",
        ]),
        rows: rows.collect(),
    }
}

/// The field's cases of stress.
pub(crate) fn extremes(study: &Study) -> Table {
    let rows = study.extremes.iter().map(|e| {
        let moves = match e.conditioning {
            Some(c) if c.is_infinite() => "changes".to_owned(),
            c => number(c),
        };
        let count = |n: usize| match e.queries {
            0 => "-".to_owned(),
            _ => n.to_string(),
        };
        let mut note = e.elsewhere.clone().unwrap_or_else(|| e.reasons.join("; "));
        if e.not_reached > 0 {
            note = format!("{} more not asked for want of time; {note}", e.not_reached);
        }
        vec![
            e.id.clone(),
            e.about.clone(),
            count(e.right),
            count(e.undecided),
            count(e.wrong),
            number(e.ulps),
            moves,
            number(e.microseconds),
            number(e.easy_microseconds),
            note,
        ]
    });
    Table {
        groups: Vec::new(),
        note: "Each case beside an easy version of the same question, by the kernel at full accuracy: how many answers were right, undecided, \
               wrong; the worst error in ulp; the conditioning: by how many ulp the answer moves when one number of the query moves by one \
               (“changes”: a count or a side changes); median microseconds, hard and easy."
            .to_owned(),
        head: strings([
            "case",
            "about",
            "right",
            "undecided",
            "wrong",
            "ulp max",
            "conditioning",
            "us",
            "easy us",
            "notes",
        ]),
        rows: rows.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (Some(0.0), "0"),
            (None, "-"),
            (Some(1.234), "1.23"),
            (Some(0.05), "0.0500"),
            (Some(123.4), "123"),
            (Some(9999.0), "9999"),
            (Some(12345.0), "1.2e4"),
            (Some(1.5e-15), "1.5e-15"),
        ];
        for (x, text) in cases {
            assert_eq!(number(x), text);
        }
        assert_eq!(bytes(Some(25_305)), "25 kB");
    }
}
