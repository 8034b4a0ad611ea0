//! Engines x corpus -> verdicts.

use crate::cases::{Case, Models, cases};
use crate::continuum::misjudged;
use crate::engine::Engine;
use crate::place::misplaced;
use crate::report::{Failure, Report, Row};
use feeler::query::{Accuracy, Contacts};
use feeler_corpus::{
    Answer, Ask, Asked, Body, Ceilings, CorpusError, Fault, Judgement, Query, Suite, Verdict,
    judge, suites,
};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;
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
    /// About so many queries of each suite alone, spread over it: a quick look.
    pub sample: Option<usize>,
    /// Whether the answers themselves are kept, as [`Row::answers`].
    pub answers: bool,
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
        hits: query.hits,
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
/// `engines` are several of the same: each works on a thread of its own, and the models of a suite are dealt out
/// to them. The report does not depend on how many there are, but for its times. No engine, no report but empty rows.
///
/// # Errors
/// The corpus cannot be read, or its truth was made for other queries or BREPs.
pub fn run(
    engines: &mut [&mut dyn Engine],
    gate: &Gate<'_>,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Report, CorpusError> {
    let mut models = Models::new();
    let mut rows = Vec::new();
    for suite in suites(gate.corpus, gate.suite)? {
        let mut cases = cases(gate.corpus, &suite, &mut models)?;
        if let Some(count) = gate.sample {
            let step = cases.len().div_ceil(count.max(1)).max(1);
            cases = cases.into_iter().step_by(step).collect();
        }
        let tally = run_cases(engines, gate, &cases, &models, &mut |done| {
            progress(&Progress {
                suite: suite.name.clone(),
                done,
                total: cases.len(),
            });
        });
        rows.push(tally.finish(&suite, gate));
    }
    Ok(Report {
        engine: engines.first().map(|e| e.name()).unwrap_or_default(),
        tolerance: gate.tolerance,
        suites: rows,
    })
}

/// What a thread tells the one that waits.
enum Told {
    Answered,
    /// The group of that number is through.
    Group(usize, Box<Tally>),
}

/// All cases of a suite, which are sorted by model, dealt out a model at a time to whichever engine is free.
fn run_cases(
    engines: &mut [&mut dyn Engine],
    gate: &Gate<'_>,
    cases: &[Case],
    models: &Models,
    tick: &mut dyn FnMut(usize),
) -> Tally {
    let groups: Vec<&[Case]> = cases
        .chunk_by(|a, b| a.query.model == b.query.model)
        .collect();
    let next = AtomicUsize::new(0);
    let (tell, told) = channel();
    let mut tallies = BTreeMap::new();
    tick(0);
    std::thread::scope(|scope| {
        for engine in engines.iter_mut() {
            let (tell, next, groups) = (tell.clone(), &next, &groups);
            scope.spawn(move || {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    let Some(group) = groups.get(k) else { break };
                    // Nobody listens only if the thread that waits is lost, and all with it.
                    let tally = run_model(*engine, gate, group, models, &|| {
                        let _ = tell.send(Told::Answered);
                    });
                    let _ = tell.send(Told::Group(k, Box::new(tally)));
                }
            });
        }
        // The last of the others ends with its thread, and the loop with that.
        drop(tell);
        let mut done = 0;
        for told in told {
            match told {
                Told::Answered => {
                    done += 1;
                    tick(done);
                }
                Told::Group(k, tally) => {
                    tallies.insert(k, tally);
                }
            }
        }
    });
    let mut all = Tally::default();
    for tally in tallies.into_values() {
        all.merge(*tally);
    }
    all
}

/// The cases of one model.
fn run_model(
    engine: &mut dyn Engine,
    gate: &Gate<'_>,
    cases: &[Case],
    models: &Models,
    answered: &dyn Fn(),
) -> Tally {
    let mut row = Tally::default();
    let Some(loaded) = cases.first().and_then(|c| models.get(&c.query.model)) else {
        return row;
    };
    let open = engine.open(&loaded.model);
    for case in cases {
        let query = &case.query;
        if !engine.treats(&query.query) {
            row.not_asked += 1;
            answered();
            continue;
        }
        let start = Instant::now();
        let answer = match &open {
            Err(error) => Body::Error {
                error: error.clone(),
            },
            Ok(()) => engine.answer(&query.query).body,
        };
        let time = start.elapsed();
        let asked = asked(&query.query, loaded.size, gate.tolerance);
        let mut judgement = judge(&asked, &answer, &case.truth);
        if let Some(why) = misplaced(loaded, &answer) {
            judgement = judgement.and(Judgement::wrong(Fault::Place, why));
        }
        if let Some(why) = misjudged(loaded, &asked, &answer, &case.truth) {
            judgement = judgement.and(Judgement::wrong(Fault::Continuum, why));
        }
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
        if gate.answers {
            let answer = Answer {
                id: query.query.id.clone(),
                body: answer,
            };
            row.answers
                .push(format!("{}\t{}", case.place(), answer.to_text()));
        }
        answered();
    }
    row
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
    answers: Vec<String>,
    /// The one with the largest error in ulp.
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

    /// Those of the cases that follow.
    fn merge(&mut self, next: Self) {
        self.queries += next.queries;
        self.not_asked += next.not_asked;
        self.wrong += next.wrong;
        self.indeterminate += next.indeterminate;
        self.undecided += next.undecided;
        self.unbounded += next.unbounded;
        for (fault, count) in next.faults {
            *self.faults.entry(fault).or_default() += count;
        }
        for (kind, (count, seconds)) in next.kinds {
            let all = self.kinds.entry(kind).or_default();
            *all = (all.0 + count, all.1 + seconds);
        }
        let before = self.error_ulp;
        self.error_ulp = larger(self.error_ulp, next.error_ulp);
        self.error_length = larger(self.error_length, next.error_length);
        self.derivative_error = larger(self.derivative_error, next.derivative_error);
        if self.error_ulp != before || self.worst.is_none() {
            self.worst = next.worst;
        }
        self.times.extend(next.times);
        self.failures.extend(next.failures);
        self.answers.extend(next.answers);
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
            answers: self.answers,
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
