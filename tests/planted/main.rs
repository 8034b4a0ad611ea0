//! A gate that cannot fail is worthless: mistakes planted on purpose, each of which it must find.
//!
//! Mistakes in answers are put into one answer of a suite alone, those of all others being the kernel's: the
//! gate must fail, and name that query. Mistakes in the model (what a mistake in the code that reads or
//! evaluates it amounts to) make every query of the model suffer.

mod answers;
mod contacts;
mod models;

use feeler::query::Options;
use feeler_corpus::{Answer, Body, CorpusQuery, Model, Query, Truth, suites};
use feeler_gate::{Engine, FeelerEngine, Gate, Report, Row, run};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

fn corpus() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap().join("corpora")
}

fn gate(engine: &mut dyn Engine, suite: &str) -> Report {
    let gate = Gate {
        corpus: &corpus(),
        suite: Some(suite),
        tolerance: 0.0,
        sample: None,
        answers: false,
    };
    run(&mut [engine], &gate, &mut |_| {}).unwrap()
}

fn row(report: &Report) -> &Row {
    assert_eq!(report.suites.len(), 1);
    &report.suites[0]
}

/// The kernel, as the gate runs it; what it answered is kept.
#[derive(Default)]
struct Recording {
    engine: FeelerEngine,
    answers: Vec<Answer>,
}

impl Engine for Recording {
    fn name(&self) -> String {
        self.engine.name()
    }

    fn open(&mut self, model: &Model) -> Result<(), String> {
        self.engine.open(model)
    }

    fn answer(&mut self, query: &Query) -> Answer {
        let answer = self.engine.answer(query);
        self.answers.push(answer.clone());
        answer
    }
}

/// The kernel's answers to a suite, and what they earned.
struct Recorded {
    answers: Vec<Answer>,
    report: Report,
}

/// The same for every test that asks, so that the kernel answers a suite once.
fn recorded(suite: &str) -> Arc<Recorded> {
    static ALL: Mutex<BTreeMap<String, Arc<OnceLock<Arc<Recorded>>>>> = Mutex::new(BTreeMap::new());
    let cell = ALL
        .lock()
        .unwrap()
        .entry(suite.to_owned())
        .or_default()
        .clone();
    let record = || {
        let mut recording = Recording::default();
        let report = gate(&mut recording, suite);
        let answers = recording.answers;
        Arc::new(Recorded { answers, report })
    };
    cell.get_or_init(record).clone()
}

/// Gives those answers again, one of them with a mistake. What a mistake makes of an answer, `None` where it
/// changes nothing: of the kernel about the model, the query, its answer and the one before.
type Mistake = fn(&mut FeelerEngine, &Query, &Answer, Option<&Answer>) -> Option<Body>;

struct Planted {
    engine: FeelerEngine,
    model: PathBuf,
    answers: Vec<Answer>,
    at: usize,
    /// Queries whose answers are right without a mistake, with their models.
    right: Vec<CorpusQuery>,
    mistake: Mistake,
    /// How many answers that could suffer are let pass first.
    skip: usize,
    /// The model and the query whose answer got the mistake.
    planted: Option<(PathBuf, Query)>,
}

impl Engine for Planted {
    fn name(&self) -> String {
        "planted".to_owned()
    }

    fn open(&mut self, model: &Model) -> Result<(), String> {
        self.model = model.path.clone();
        self.engine.open(model)
    }

    fn answer(&mut self, query: &Query) -> Answer {
        let before = self.at.checked_sub(1).and_then(|i| self.answers.get(i));
        let mut answer = self.answers[self.at].clone();
        let same = |q: &CorpusQuery| q.query == *query && self.model.ends_with(&q.model);
        if self.planted.is_none()
            && self.right.iter().any(same)
            && let Some(body) = (self.mistake)(&mut self.engine, query, &answer, before)
        {
            if self.skip == 0 {
                answer.body = body;
                self.planted = Some((self.model.clone(), query.clone()));
            } else {
                self.skip -= 1;
            }
        }
        self.at += 1;
        answer
    }
}

/// The queries of a suite, with the places that the gate names them by, and their truth.
fn queries(suite: &str) -> Vec<(String, CorpusQuery, Truth)> {
    let mut all = Vec::new();
    for suite in suites(&corpus(), Some(suite)).unwrap() {
        for file in &suite.files {
            let place = |n: usize| format!("{}:{n}", file.queries.display());
            let (queries, hash) = file.queries().unwrap();
            let (_, truths) = file.truth(queries.len(), &hash).unwrap();
            let both = queries.into_iter().zip(truths);
            all.extend(both.map(|(q, t)| (place(q.number), q, t)));
        }
    }
    all
}

/// One answer of a suite gets a mistake, once early in the suite and once far into it: each time the
/// gate must fail with one wrong answer more than without it, and name the query.
fn must_be_found(suite: &str, what: &str, mistake: Mistake) {
    found_where(suite, what, |_| true, mistake);
}

/// The same, among queries whose truth is such that the mistake is one. Why the gate found each wrong.
fn found_where(suite: &str, what: &str, such: fn(&Truth) -> bool, mistake: Mistake) -> Vec<String> {
    let recorded = recorded(suite);
    let unplanted = row(&recorded.report);
    let fell = |place: &String| unplanted.failures.iter().any(|f| f.place == *place);
    let queries = queries(suite);
    let right = queries
        .iter()
        .filter(|(place, _, truth)| !fell(place) && such(truth));
    let right: Vec<CorpusQuery> = right.map(|(_, q, _)| q.clone()).collect();
    let wrong = unplanted.wrong;
    let mut reasons = Vec::new();
    for skip in [0, 17] {
        let mut engine = Planted {
            engine: FeelerEngine::new(Options::default()),
            model: PathBuf::new(),
            answers: recorded.answers.clone(),
            at: 0,
            right: right.clone(),
            mistake,
            skip,
            planted: None,
        };
        let report = gate(&mut engine, suite);
        let (model, query) = engine
            .planted
            .unwrap_or_else(|| panic!("{suite}: no answer for {what}"));
        assert!(!report.passed(), "{suite}: the gate let pass {what}");
        let row = row(&report);
        assert_eq!(
            row.wrong,
            wrong + 1,
            "{suite}: {what}: {}",
            report.shortfalls()
        );
        let same = |q: &CorpusQuery| q.query == query && model.ends_with(&q.model);
        let places = queries.iter().filter(|(_, q, _)| same(q));
        let places: Vec<&String> = places.map(|(place, ..)| place).collect();
        let named = row
            .failures
            .iter()
            .find(|f| f.verdict == "wrong" && places.contains(&&f.place))
            .unwrap_or_else(|| panic!("{suite}: {what}: {places:?} is not named"));
        assert!(named.command.contains("contact"), "{}", named.command);
        println!("{suite}: {what}: {}: {}", named.place, named.reason);
        reasons.push(named.reason.clone());
    }
    reasons
}

#[test]
fn unplanted_suites_pass() {
    for suite in ["evaluate", "side", "contact-half-space"] {
        let report = gate(&mut FeelerEngine::new(Options::default()), suite);
        assert!(report.passed(), "{}", report.shortfalls());
        assert!(row(&report).queries > 100);
    }
}
