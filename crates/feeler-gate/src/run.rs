//! Engines x corpus -> verdicts.

use crate::cases::{Models, cases};
use crate::engine::Engine;
use crate::report::{Failure, Report, Row};
use feeler::query::{Accuracy, Contacts};
use feeler_corpus::{
    Ask, Asked, Body, Ceilings, CorpusError, Fault, Judgement, Query, Suite, Verdict, judge, suites,
};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// What is run, and how it is judged.
#[derive(Clone, Copy, Debug)]
pub struct Gate<'a> {
    /// The folder of the corpus.
    pub corpus: &'a Path,
    /// One suite alone.
    pub suite: Option<&'a str>,
    /// A value without bounds of its own may be off by this part of the model's size. Above 0 it takes the place
    /// of the ceilings on errors, which are those of an engine with bounds.
    pub tolerance: f64,
}

/// How far a run has come.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The suite at work.
    pub suite: String,
    /// Queries done in it.
    pub done: usize,
    /// Queries in it.
    pub total: usize,
}

/// What the judge needs to know of a query to a model of this size. A value without bounds may be off by
/// `tolerance` times the size.
pub fn asked(query: &Query, size: f64, tolerance: f64) -> Asked {
    Asked {
        accuracy: query.accuracy.unwrap_or(Accuracy::Full),
        size,
        prediction: query.prediction.unwrap_or(0.0),
        contacts: query.contacts != Some(Contacts::None),
        scale: match query.ask {
            Ask::Line(line) => line.direction.norm(),
            _ => 1.0,
        },
        tolerance: tolerance * size,
        probe: match query.ask {
            Ask::Contact(probe) => Some(probe),
            _ => None,
        },
    }
}

/// Runs the suites of a corpus, or the one named, through an engine, and holds the answers against
/// the stored truth. Where the engine cannot open a model, each query about it counts as refused.
///
/// # Errors
/// The corpus cannot be read, or its truth was made for other queries or BREPs.
pub fn run(
    engine: &mut dyn Engine,
    gate: &Gate<'_>,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Report, CorpusError> {
    let mut models = Models::new();
    let mut rows = Vec::new();
    for suite in suites(gate.corpus, gate.suite)? {
        rows.push(run_suite(engine, gate, &suite, &mut models, progress)?);
    }
    Ok(Report {
        engine: engine.name(),
        tolerance: gate.tolerance,
        suites: rows,
    })
}

fn run_suite(
    engine: &mut dyn Engine,
    gate: &Gate<'_>,
    suite: &Suite,
    models: &mut Models,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Row, CorpusError> {
    let cases = cases(gate.corpus, suite, models)?;
    let mut row = Tally::default();
    let mut open: Option<(&str, Result<(), String>)> = None;
    let total = cases.len();
    for (done, case) in cases.iter().enumerate() {
        let Some(loaded) = models.get(&case.query.model) else {
            continue;
        };
        let query = &case.query;
        if open.as_ref().map(|o| o.0) != Some(query.model.as_str()) {
            open = Some((&query.model, engine.open(&loaded.model)));
        }
        progress(&Progress {
            suite: suite.name.clone(),
            done,
            total,
        });
        if !engine.treats(&query.query) {
            row.not_asked += 1;
            continue;
        }
        let start = Instant::now();
        let answer = match &open {
            Some((_, Err(error))) => Body::Error {
                error: error.clone(),
            },
            _ => engine.answer(&query.query).body,
        };
        let time = start.elapsed();
        let asked = asked(&query.query, loaded.size, gate.tolerance);
        let judgement = judge(&asked, &answer, &case.truth);
        let kind = query.query.ask.word();
        row.add(judgement, kind, time, || Failure {
            verdict: String::new(),
            kind: kind.to_owned(),
            reason: String::new(),
            place: case.place(),
            command: engine
                .repeats(&query.query)
                .unwrap_or_else(|| case.command(gate.corpus)),
        });
    }
    Ok(row.finish(suite, gate))
}

#[derive(Debug, Default)]
struct Tally {
    queries: usize,
    not_asked: usize,
    wrong: usize,
    faults: BTreeMap<Fault, usize>,
    indeterminate: usize,
    undecided: usize,
    unbounded: usize,
    error_ulp: Option<f64>,
    error_length: Option<f64>,
    derivative_error: Option<f64>,
    times: Vec<Duration>,
    kinds: BTreeMap<String, (usize, f64)>,
    failures: Vec<Failure>,
    worst: Option<(f64, Failure)>,
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        _ => a.or(b),
    }
}

impl Tally {
    fn add(
        &mut self,
        judgement: Judgement,
        kind: &str,
        time: Duration,
        failure: impl Fn() -> Failure,
    ) {
        self.queries += 1;
        let (count, seconds) = self.kinds.entry(kind.to_owned()).or_default();
        *count += 1;
        *seconds += time.as_secs_f64();
        self.times.push(time);
        self.unbounded += usize::from(judgement.unbounded);
        match judgement.verdict {
            Verdict::Right => {
                let before = self.error_ulp;
                self.error_ulp = larger(self.error_ulp, judgement.ulps);
                self.error_length = larger(self.error_length, judgement.error);
                self.derivative_error = larger(self.derivative_error, judgement.derivative_error);
                if self.error_ulp != before || self.worst.is_none() {
                    self.worst = judgement.ulps.map(|u| (u, failure()));
                }
                return;
            }
            Verdict::Wrong => {
                self.wrong += 1;
                *self
                    .faults
                    .entry(judgement.fault.unwrap_or(Fault::Value))
                    .or_default() += 1;
            }
            Verdict::Indeterminate => self.indeterminate += 1,
            Verdict::Undecided => self.undecided += 1,
        }
        self.failures.push(Failure {
            verdict: verdict_word(judgement.verdict).to_owned(),
            reason: judgement.reason.unwrap_or_default(),
            ..failure()
        });
    }

    fn finish(mut self, suite: &Suite, gate: &Gate<'_>) -> Row {
        self.times.sort();
        let mut ceilings = suite.file.ceilings.clone();
        if gate.tolerance > 0.0 {
            ceilings = Ceilings {
                error_ulp: None,
                error_length: None,
                derivative_error: None,
                ..ceilings
            };
        }
        let mut short = Vec::new();
        let counts = [
            ("wrong", self.wrong, ceilings.wrong),
            ("indeterminate", self.indeterminate, ceilings.indeterminate),
            ("undecided", self.undecided, ceilings.undecided),
            ("unbounded", self.unbounded, ceilings.unbounded),
        ];
        for (what, count, ceiling) in counts {
            if count > ceiling {
                short.push(format!("{what} {count}, the ceiling is {ceiling}"));
            }
        }
        let errors = [
            ("error in ulp", self.error_ulp, ceilings.error_ulp),
            ("error in length", self.error_length, ceilings.error_length),
            (
                "derivative error",
                self.derivative_error,
                ceilings.derivative_error,
            ),
        ];
        for (what, error, ceiling) in errors {
            if let (Some(error), Some(ceiling)) = (error, ceiling) {
                // Also where it is NaN.
                if error > ceiling || error.is_nan() {
                    short.push(format!("{what} {error:e}, the ceiling is {ceiling:e}"));
                    if let Some((_, worst)) = &self.worst {
                        self.failures.push(Failure {
                            verdict: "right".to_owned(),
                            reason: format!("the worst {what}"),
                            ..worst.clone()
                        });
                    }
                }
            }
        }
        if self.queries + self.not_asked == 0 {
            short.push("no queries".to_owned());
        }
        // The worst first: they are what a reader must see.
        let rank = |f: &Failure| match f.verdict.as_str() {
            "wrong" => 0,
            "indeterminate" => 1,
            "undecided" => 2,
            _ => 3,
        };
        self.failures.sort_by_key(rank);
        Row {
            suite: suite.name.clone(),
            description: suite.file.description.clone(),
            queries: self.queries,
            not_asked: self.not_asked,
            wrong: self.wrong,
            faults: self.faults,
            indeterminate: self.indeterminate,
            undecided: self.undecided,
            unbounded: self.unbounded,
            error_ulp: self.error_ulp,
            error_length: self.error_length,
            derivative_error: self.derivative_error,
            median_microseconds: quantile(&self.times, 0.5),
            p99_microseconds: quantile(&self.times, 0.99),
            seconds: self.times.iter().sum::<Duration>().as_secs_f64(),
            kinds: self.kinds,
            ceilings,
            short,
            failures: self.failures,
        }
    }
}

/// A quantile of sorted times in microseconds; 0 if there are none.
fn quantile(times: &[Duration], q: f64) -> f64 {
    let last = times.len().saturating_sub(1);
    let at = (q * last as f64).round() as usize;
    times.get(at).map_or(0.0, |t| t.as_secs_f64() * 1e6)
}

pub(crate) fn verdict_word(v: Verdict) -> &'static str {
    match v {
        Verdict::Right => "right",
        Verdict::Wrong => "wrong",
        Verdict::Indeterminate => "indeterminate",
        Verdict::Undecided => "undecided",
    }
}
