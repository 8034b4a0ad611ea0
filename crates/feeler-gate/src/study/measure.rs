//! Engines measured side by side on samples of the suites.
//!
//! Interleaved: within a model every engine answers the sample once, in turn, and then again, so that what else
//! the machine does falls on all of them. A query faster than [`SHORTEST`] is repeated until that much has gone by,
//! since reading the clock costs some 30 ns.

use super::contender::Contender;
use super::numbers::{Spread, quantile};
use crate::cases::{Case, Models};
use crate::report::Failure;
use crate::run::asked;
use feeler::query::Accuracy;
use feeler_corpus::{Body, Fault, Judgement, Query, Truth, Verdict, judge};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// The shortest time that is measured at once.
const SHORTEST: Duration = Duration::from_micros(4);
/// A value without bounds counts as right if it is off by no more than this part of the model's size.
pub const TOLERANCE: f64 = 1e-6;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Queries of each suite, spread evenly over it.
    pub sample: usize,
    /// How often each is asked.
    pub repetitions: usize,
    /// An engine that has used this many seconds on the queries of one model is not asked further ones; what it
    /// was asked is counted.
    pub seconds: f64,
}

/// What one engine, at one setting, gave on the sample of one suite.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The engine.
    pub engine: String,
    /// Its setting.
    pub setting: String,
    /// How many queries it answered.
    pub queries: usize,
    /// How many more of the sample it does not treat.
    pub not_asked: usize,
    /// How many more were left when its time was over.
    pub not_reached: usize,
    /// Right answers.
    pub right: usize,
    /// Bounds wider than asked, or none.
    pub undecided: usize,
    /// Answers that the truth cannot judge.
    pub indeterminate: usize,
    /// Wrong answers by what failed.
    pub faults: BTreeMap<Fault, usize>,
    /// Errors of the values, in model units; undecided answers apart, here and below.
    pub error: Option<Spread>,
    /// The same in ulp of the true value.
    pub ulps: Option<Spread>,
    /// Widths of the enclosures of the separation, in model units.
    pub width: Option<Spread>,
    /// Microseconds a query: each query's median over the repetitions.
    pub microseconds: Spread,
    /// The smallest and the largest median of one repetition.
    pub between: [f64; 2],
    /// Microseconds to open a model: the median over the models.
    pub open_microseconds: f64,
    /// Bytes held for a model: the largest.
    pub bytes: Option<usize>,
    /// The gravest failures, a few.
    pub witnesses: Vec<Failure>,
}

/// How many witnesses are kept of an engine on a suite.
const WITNESSES: usize = 3;

/// What is known of one query to one engine.
struct Record {
    case: usize,
    judgement: Judgement,
    width: Option<f64>,
    times: Vec<f64>,
}

#[derive(Default)]
struct Book {
    records: Vec<Record>,
    not_asked: usize,
    not_reached: usize,
    opens: Vec<f64>,
    bytes: Option<usize>,
}

/// `count` of `all` cases, spread evenly.
pub(crate) fn sample(all: usize, count: usize) -> Vec<usize> {
    let count = count.min(all);
    (0..count).map(|k| k * all / count).collect()
}

/// Measures all contenders on some cases of a suite, which are sorted by model.
pub(crate) fn measure(
    contenders: &mut [Contender],
    corpus: &Path,
    cases: &[Case],
    chosen: &[usize],
    models: &Models,
    plan: &Plan,
    tick: &mut dyn FnMut(usize),
) -> Vec<Point> {
    let mut books: Vec<Book> = contenders.iter().map(|_| Book::default()).collect();
    let by_model = chosen.chunk_by(|a, b| cases[*a].query.model == cases[*b].query.model);
    let mut done = 0;
    for group in by_model {
        let Some(loaded) = group
            .first()
            .and_then(|i| models.get(&cases[*i].query.model))
        else {
            continue;
        };
        let mut open: Vec<Result<(), String>> = Vec::new();
        for (contender, book) in contenders.iter_mut().zip(&mut books) {
            // A mesh for questions that it does not treat would take long for nothing.
            let mut queries = group.iter().map(|i| &cases[*i].query.query);
            if !queries.any(|q| contender.treats(q)) {
                open.push(Ok(()));
                continue;
            }
            let start = Instant::now();
            open.push(contender.engine.open(&loaded.model));
            book.opens.push(start.elapsed().as_secs_f64() * 1e6);
        }
        let mut spent = vec![0.0; contenders.len()];
        let firsts: Vec<usize> = books.iter().map(|b| b.records.len()).collect();
        for repetition in 0..plan.repetitions {
            for turn in 0..contenders.len() {
                let c = (turn + repetition) % contenders.len();
                let (contender, book) = (&mut contenders[c], &mut books[c]);
                let mut next = firsts[c];
                for &i in group {
                    let query = contender.query(&cases[i].query.query, loaded.size);
                    if !contender.treats(&query) {
                        book.not_asked += usize::from(repetition == 0);
                        continue;
                    }
                    if spent[c] > plan.seconds {
                        book.not_reached += usize::from(repetition == 0);
                        continue;
                    }
                    let before = Instant::now();
                    let (body, time) = timed(contender, &query, &open[c]);
                    spent[c] += before.elapsed().as_secs_f64();
                    if repetition == 0 {
                        let asked = asked(&query, loaded.size, TOLERANCE);
                        book.records.push(Record {
                            case: i,
                            judgement: judge(&asked, &body, &cases[i].truth),
                            width: width(&body),
                            times: Vec::new(),
                        });
                    }
                    // Those not reached in the first round are at the end.
                    if let Some(record) = book.records.get_mut(next) {
                        record.times.push(time);
                    }
                    next += 1;
                }
            }
        }
        // What is prepared on first use counts too.
        for (contender, book) in contenders.iter().zip(&mut books) {
            if book.records.last().is_some_and(|r| group.contains(&r.case)) {
                book.bytes = book.bytes.max(contender.engine.memory());
            }
        }
        done += group.len();
        tick(done);
    }
    contenders
        .iter()
        .zip(books)
        .map(|(c, book)| point(c, corpus, cases, book))
        .collect()
}

/// An answer, and the microseconds it took.
fn timed(contender: &mut Contender, query: &Query, open: &Result<(), String>) -> (Body, f64) {
    if let Err(error) = open {
        let error = error.clone();
        return (Body::Error { error }, 0.0);
    }
    let start = Instant::now();
    let body = contender.engine.answer(query).body;
    let first = start.elapsed();
    if first >= SHORTEST {
        return (body, first.as_secs_f64() * 1e6);
    }
    let mut count = 0u32;
    let start = Instant::now();
    while start.elapsed() < SHORTEST {
        for _ in 0..8 {
            std::hint::black_box(contender.engine.answer(query));
        }
        count += 8;
    }
    (body, start.elapsed().as_secs_f64() * 1e6 / f64::from(count))
}

/// How wide the separation's enclosure is.
fn width(body: &Body) -> Option<f64> {
    match body {
        Body::Contact { separation, .. } => Some(separation.hi? - separation.lo?),
        _ => None,
    }
}

/// How wide the truth of a separation is, at most: the floor below which no error is seen.
pub(crate) fn truth_width(truth: &Truth) -> Option<f64> {
    match truth {
        Truth::Separation(s) | Truth::Contact { separation: s, .. } => {
            Some((&s.hi - &s.lo).approximate())
        }
        _ => None,
    }
}

fn point(contender: &Contender, corpus: &Path, cases: &[Case], book: Book) -> Point {
    let records = &book.records;
    let count = |v: Verdict| records.iter().filter(|r| r.judgement.verdict == v).count();
    let mut faults = BTreeMap::new();
    for r in records {
        if let (Verdict::Wrong, Some(fault)) = (r.judgement.verdict, r.judgement.fault) {
            *faults.entry(fault).or_default() += 1;
        }
    }
    // What is undecided claims no value: it is counted, and no error.
    let decided = || {
        let all = records.iter();
        all.filter(|r| r.judgement.verdict != Verdict::Undecided)
    };
    let over = |get: &dyn Fn(&Record) -> Option<f64>| {
        Spread::of(decided().filter_map(get).filter(|x| !x.is_nan()))
    };
    let medians = records.iter().filter_map(|r| {
        let mut times = r.times.clone();
        times.sort_by(f64::total_cmp);
        quantile(&times, 0.5)
    });
    let rounds = records.iter().map(|r| r.times.len()).max().unwrap_or(0);
    let of_round = |k: usize| {
        let mut times: Vec<f64> = records
            .iter()
            .filter_map(|r| r.times.get(k).copied())
            .collect();
        times.sort_by(f64::total_cmp);
        quantile(&times, 0.5)
    };
    let between = (0..rounds)
        .filter_map(of_round)
        .fold([f64::INFINITY, 0.0], |[lo, hi]: [f64; 2], x| {
            [lo.min(x), hi.max(x)]
        });
    let mut failed: Vec<&Record> = records
        .iter()
        .filter(|r| r.judgement.verdict != Verdict::Right)
        .collect();
    let rank = |r: &Record| match r.judgement.verdict {
        Verdict::Wrong => (0, r.judgement.fault),
        Verdict::Indeterminate => (1, None),
        _ => (2, None),
    };
    let error = |r: &Record| r.judgement.error.unwrap_or(0.0);
    failed.sort_by(|a, b| rank(a).cmp(&rank(b)).then(error(b).total_cmp(&error(a))));
    let witnesses = failed.iter().take(WITNESSES).map(|r| Failure {
        verdict: crate::run::verdict_word(r.judgement.verdict).to_owned(),
        kind: cases[r.case].query.query.ask.word().to_owned(),
        reason: r.judgement.reason.clone().unwrap_or_default(),
        place: cases[r.case].place(),
        command: cases[r.case].command(corpus),
    });
    let witnesses = witnesses.collect();
    let mut opens = book.opens.clone();
    opens.sort_by(f64::total_cmp);
    Point {
        engine: contender.name.clone(),
        setting: contender.setting.clone(),
        queries: records.len(),
        not_asked: book.not_asked,
        not_reached: book.not_reached,
        right: count(Verdict::Right),
        undecided: count(Verdict::Undecided),
        indeterminate: count(Verdict::Indeterminate),
        faults,
        error: over(&|r| r.judgement.error),
        ulps: over(&|r| r.judgement.ulps),
        width: over(&|r| r.width),
        microseconds: Spread::of(medians).unwrap_or_default(),
        between,
        open_microseconds: quantile(&opens, 0.5).unwrap_or(0.0),
        bytes: book.bytes,
        witnesses,
    }
}

/// The accuracy that a fraction of the model's size asks for.
pub(crate) fn accuracy(part: Option<f64>, size: f64) -> Accuracy {
    part.map_or(Accuracy::Full, |p| Accuracy::Length(p * size))
}
