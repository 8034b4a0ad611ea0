//! The field's cases of stress, each against its easy version, with its conditioning.
//!
//! The suite `cases` names in each query's id the case and how hard it is (`C2 e=1e-9`, or `C2 easy`). The conditioning of
//! a query is how far the answer moves when one number of the query moves by an ulp, in ulp of the answer: a large error
//! where it is large is the question's, not the method's.

use super::numbers::quantile;
use crate::cases::{Case, Models, cases};
use crate::engine::{Engine, FeelerEngine};
use crate::run::asked;
use feeler::query::Options;
use feeler_corpus::{Body, CorpusError, Query, QueryLine, Verdict, judge, read_text, suites, ulp};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// The suite.
const SUITE: &str = "cases";
/// What each of its cases is about.
const ABOUT: &str = "cases.json";
/// How the easy version is named.
const EASY: &str = "easy";
/// How often a query is timed, at most.
const ROUNDS: usize = 3;

#[derive(Deserialize)]
struct About {
    id: String,
    about: String,
    #[serde(default)]
    elsewhere: Option<String>,
}

/// One case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Extreme {
    /// Its id.
    pub id: String,
    /// What it is about.
    pub about: String,
    /// Where it is tested, if it is no query.
    pub elsewhere: Option<String>,
    /// Hard queries.
    pub queries: usize,
    /// Right answers among them.
    pub right: usize,
    /// Undecided ones.
    pub undecided: usize,
    /// Wrong or indeterminate ones.
    pub wrong: usize,
    /// Worst error in ulp of the true value.
    pub ulps: Option<f64>,
    /// Largest conditioning: ulp of the answer by an ulp of a number of the query; infinite where the answer's count or
    /// side changes.
    pub conditioning: Option<f64>,
    /// Median microseconds of the hard queries.
    pub microseconds: Option<f64>,
    /// Median microseconds of the easy version.
    pub easy_microseconds: Option<f64>,
    /// Reasons of those that are not right, a few.
    pub reasons: Vec<String>,
    /// Hard queries that were left when the case's time was over.
    pub not_reached: usize,
}

/// How many reasons are kept.
const REASONS: usize = 3;

#[derive(Default)]
struct Tally {
    spent: f64,
    not_reached: usize,
    hard: Vec<f64>,
    easy: Vec<f64>,
    counts: [usize; 3],
    ulps: Option<f64>,
    conditioning: Option<f64>,
    reasons: Vec<String>,
}

/// All cases through the kernel at full accuracy; empty where the corpus has no such suite. A query that takes longer than
/// this part of `seconds` is answered once: its time includes what is prepared on first use, and its conditioning is not known.
///
/// # Errors
/// The corpus cannot be read.
pub(crate) fn extremes(
    corpus: &Path,
    models: &mut Models,
    seconds: f64,
    tick: &mut dyn FnMut(usize, usize),
) -> Result<Vec<Extreme>, CorpusError> {
    let path = corpus.join(SUITE).join(ABOUT);
    let Ok(text) = read_text(&path) else {
        return Ok(Vec::new());
    };
    let about: Vec<About> = serde_json::from_str(&text).map_err(|error| CorpusError::Json {
        path: path.clone(),
        number: error.line(),
        error,
    })?;
    let mut tallies: BTreeMap<String, Tally> = BTreeMap::new();
    let mut engine = FeelerEngine::new(Options::default());
    for suite in suites(corpus, Some(SUITE))? {
        let cases = cases(corpus, &suite, models)?;
        let mut open: Option<&str> = None;
        for (i, case) in cases.iter().enumerate() {
            tick(i, cases.len());
            let Some(loaded) = models.get(&case.query.model) else {
                continue;
            };
            if open != Some(case.query.model.as_str()) {
                // A model that cannot be opened makes every answer a refusal, hence wrong.
                let _ = engine.open(&loaded.model);
                open = Some(&case.query.model);
            }
            one(case, loaded.size, seconds, &mut engine, &mut tallies);
        }
    }
    Ok(about.into_iter().map(|a| row(a, &tallies)).collect())
}

/// See [`extremes`].
const SLOW: f64 = 0.1;
/// A case may take this many times `seconds`; what is left then is not asked.
const PATIENCE: f64 = 10.0;

fn one(
    case: &Case,
    size: f64,
    seconds: f64,
    engine: &mut FeelerEngine,
    tallies: &mut BTreeMap<String, Tally>,
) {
    let id = case.query.query.id.as_ref().and_then(|v| v.as_str());
    let Some((name, how)) = id.and_then(|i| i.split_once(' ')) else {
        return;
    };
    let tally = tallies.entry(name.to_owned()).or_default();
    if how != EASY && tally.spent > PATIENCE * seconds {
        tally.not_reached += 1;
        return;
    }
    let query = &case.query.query;
    let start = Instant::now();
    let body = engine.answer(query).body;
    let first = start.elapsed().as_secs_f64();
    let slow = first > SLOW * seconds;
    tally.spent += first;
    let mut times = Vec::new();
    if slow {
        times.push(first * 1e6);
    }
    for _ in times.len()..if slow { 1 } else { ROUNDS } {
        let start = Instant::now();
        std::hint::black_box(engine.answer(query));
        times.push(start.elapsed().as_secs_f64() * 1e6);
    }
    times.sort_by(f64::total_cmp);
    let time = quantile(&times, 0.5).unwrap_or(0.0);
    if how == EASY {
        tally.easy.push(time);
        return;
    }
    tally.hard.push(time);
    let judgement = judge(&asked(query, size, 0.0), &body, &case.truth);
    let at = match judgement.verdict {
        Verdict::Right => 0,
        Verdict::Undecided => 1,
        Verdict::Wrong | Verdict::Indeterminate => 2,
    };
    tally.counts[at] += 1;
    if let (Some(reason), true) = (judgement.reason, tally.reasons.len() < REASONS) {
        tally.reasons.push(format!("{how}: {reason}"));
    }
    let larger = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        _ => a.or(b),
    };
    if judgement.verdict != Verdict::Undecided {
        tally.ulps = larger(tally.ulps, judgement.ulps);
    }
    // What is undecided claims no value that could move.
    if judgement.verdict == Verdict::Right && !slow {
        let moved = conditioning(&case.query.line, &body, FLOOR * size, engine);
        tally.conditioning = larger(tally.conditioning, moved);
    }
}

/// The floor of full accuracy, as a part of the size: nothing is counted in less.
const FLOOR: f64 = 1.0 / (1u128 << 96) as f64;

/// How far the answer moves, in ulp of it (or in floors, where that is more), when one number of the query moves by one
/// ulp.
fn conditioning(
    line: &QueryLine,
    body: &Body,
    floor: f64,
    engine: &mut FeelerEngine,
) -> Option<f64> {
    let mut worst = None;
    for k in 0.. {
        let mut moved = line.clone();
        let Some(x) = number(&mut moved, k) else {
            break;
        };
        *x = x.next_up();
        // A normal may be no unit vector any more.
        let Ok(query) = moved.query() else { continue };
        let by = change(body, &engine.answer(&full(query)).body, floor);
        worst = match (worst, by) {
            (Some(a), Some(b)) => Some(f64::max(a, b)),
            (a, b) => a.or(b),
        };
    }
    worst
}

fn full(query: Query) -> Query {
    Query { id: None, ..query }
}

/// The k-th number of a query.
fn number(line: &mut QueryLine, k: usize) -> Option<&mut f64> {
    let all: Vec<&mut f64> = match line {
        QueryLine {
            sphere: Some(s), ..
        } => s.center.iter_mut().chain([&mut s.radius]).collect(),
        QueryLine {
            half_space: Some(h),
            ..
        } => h.normal.iter_mut().chain([&mut h.offset]).collect(),
        QueryLine { line: Some(l), .. } => l.origin.iter_mut().chain(&mut l.direction).collect(),
        QueryLine { side: Some(at), .. }
        | QueryLine {
            evaluate: Some(at), ..
        } => at.uv.iter_mut().collect(),
        QueryLine {
            inside: Some(at), ..
        } => at.point.iter_mut().collect(),
        _ => Vec::new(),
    };
    all.into_iter().nth(k)
}

/// How far two answers are apart, in ulp of the first.
fn change(a: &Body, b: &Body, floor: f64) -> Option<f64> {
    let apart = |x: f64, y: f64| (x - y).abs() / ulp(x).max(floor);
    match (a, b) {
        (Body::Contact { separation: x, .. }, Body::Contact { separation: y, .. }) => {
            Some(apart(x.value, y.value))
        }
        (Body::Side { side: x, .. }, Body::Side { side: y, .. }) => {
            Some(if x == y { 0.0 } else { f64::INFINITY })
        }
        (Body::Line { hits: x, .. }, Body::Line { hits: y, .. }) if x.len() == y.len() => x
            .iter()
            .zip(y)
            .map(|(x, y)| apart(x.t.value, y.t.value))
            .reduce(f64::max),
        (Body::Line { .. }, Body::Line { .. }) => Some(f64::INFINITY),
        (Body::Evaluate { point: x, .. }, Body::Evaluate { point: y, .. }) => {
            let largest = x.iter().fold(f64::MIN_POSITIVE, |m, c| m.max(c.abs()));
            let each = x.iter().zip(y).map(|(x, y)| (x - y).abs() / ulp(largest));
            each.reduce(f64::max)
        }
        _ => None,
    }
}

fn row(about: About, tallies: &BTreeMap<String, Tally>) -> Extreme {
    let none = Tally::default();
    let tally = tallies.get(&about.id).unwrap_or(&none);
    let median = |times: &[f64]| {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        quantile(&sorted, 0.5)
    };
    Extreme {
        id: about.id,
        about: about.about,
        elsewhere: about.elsewhere,
        queries: tally.hard.len(),
        right: tally.counts[0],
        undecided: tally.counts[1],
        wrong: tally.counts[2],
        ulps: tally.ulps,
        conditioning: tally.conditioning,
        microseconds: median(&tally.hard),
        easy_microseconds: median(&tally.easy),
        reasons: tally.reasons.clone(),
        not_reached: tally.not_reached,
    }
}
