//! What it saves to leave out what a scene does not need.

use super::contender::Contender;
use super::measure::Plan;
use super::numbers::quantile;
use crate::cases::{Models, cases, load};
use feeler::query::{Accuracy, Contacts};
use feeler_corpus::{CorpusError, Hits, Query, suites};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// The same queries asked in two ways.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// What is compared.
    pub what: String,
    /// Of which suite the queries are.
    pub suite: String,
    /// How many queries.
    pub queries: usize,
    /// Median microseconds of the way that leaves work out.
    pub less: f64,
    /// Median microseconds of the way that does not.
    pub full: f64,
    /// Median of the queries' own ratios, full to less.
    pub ratio: f64,
}

/// How often each query is asked each way.
const ROUNDS: usize = 3;

/// One way to ask, of a model of this size.
type Way = fn(&Query, f64) -> Query;

fn as_asked(query: &Query, _: f64) -> Query {
    query.clone()
}

fn no_contacts(query: &Query, _: f64) -> Query {
    Query {
        contacts: Some(Contacts::None),
        ..query.clone()
    }
}

fn all_contacts(query: &Query, _: f64) -> Query {
    Query {
        contacts: Some(Contacts::All),
        ..query.clone()
    }
}

fn overlap(query: &Query, _: f64) -> Query {
    Query {
        overlap: true,
        ..query.clone()
    }
}

fn any_hit(query: &Query, _: f64) -> Query {
    Query {
        hits: Hits::Any,
        ..query.clone()
    }
}

fn coarse(query: &Query, size: f64) -> Query {
    Query {
        accuracy: Some(Accuracy::Length(1e-6 * size)),
        ..query.clone()
    }
}

/// A comparison of ways to ask on a suite.
struct Comparison {
    what: &'static str,
    suite: &'static str,
    less: Way,
    full: Way,
}

const COMPARISONS: [Comparison; 5] = [
    Comparison {
        what: "overlap only, against the deepest contact",
        suite: "contact-sphere",
        less: overlap,
        full: as_asked,
    },
    Comparison {
        what: "the separation alone, against the deepest contact",
        suite: "contact-sphere",
        less: no_contacts,
        full: as_asked,
    },
    Comparison {
        what: "the deepest contact, against all contacts",
        suite: "contact-sphere",
        less: as_asked,
        full: all_contacts,
    },
    Comparison {
        what: "any hit, against all hits",
        suite: "line",
        less: any_hit,
        full: as_asked,
    },
    Comparison {
        what: "accuracy 1e-6 of the size, against full",
        suite: "contact-sphere",
        less: coarse,
        full: as_asked,
    },
];

/// What native models are compared with, by the end of the file's name.
const AS_NURBS: &str = "_nurbs.3dm";
/// Suites of which the queries about NURBS parts are also asked of their native siblings.
const PAIRED: [&str; 4] = ["contact-sphere", "contact-half-space", "line", "inside"];

/// How many comparisons there are.
pub(crate) const COUNT: usize = COMPARISONS.len() + PAIRED.len();

/// All comparisons. One that has used its seconds on one model goes on with the next: the count says of how many queries.
///
/// # Errors
/// The corpus cannot be read.
pub(crate) fn compare(
    corpus: &Path,
    models: &mut Models,
    plan: &Plan,
    tick: &mut dyn FnMut(),
) -> Result<Vec<LeftOut>, CorpusError> {
    let mut rows = Vec::new();
    for c in &COMPARISONS {
        let mut pairs = Vec::new();
        for suite in suites(corpus, Some(c.suite))? {
            let cases = cases(corpus, &suite, models)?;
            for i in super::measure::sample(&cases, plan.sample) {
                let model = cases[i].query.model.clone();
                pairs.push((model.clone(), model, cases[i].query.query.clone()));
            }
        }
        rows.extend(row(c.what, c.suite, &pairs, models, [c.less, c.full], plan));
        tick();
    }
    for name in PAIRED {
        let mut pairs = Vec::new();
        for suite in suites(corpus, Some(name))? {
            let mut cases = cases(corpus, &suite, models)?;
            cases.retain(|c| c.query.model.ends_with(AS_NURBS));
            for i in super::measure::sample(&cases, plan.sample) {
                let nurbs = cases[i].query.model.clone();
                let native = nurbs.replace(AS_NURBS, ".3dm");
                if !corpus.join(feeler_corpus::MODELS).join(&native).exists() {
                    continue;
                }
                if !models.contains_key(&native) {
                    models.insert(native.clone(), load(corpus, &native)?);
                }
                pairs.push((native, nurbs, cases[i].query.query.clone()));
            }
        }
        let what = "native surfaces, against the same part as NURBS";
        rows.extend(row(what, name, &pairs, models, [as_asked; 2], plan));
        tick();
    }
    Ok(rows)
}

/// Times both ways on (model of the first way, model of the second, query), the sorted queries of one model in a row.
fn row(
    what: &str,
    suite: &str,
    pairs: &[(String, String, Query)],
    models: &Models,
    ways: [Way; 2],
    plan: &Plan,
) -> Option<LeftOut> {
    let mut engines = [Contender::feeler(None), Contender::feeler(None)];
    let (mut times, mut ratios) = ([Vec::new(), Vec::new()], Vec::new());
    for group in pairs.chunk_by(|a, b| a.0 == b.0 && a.1 == b.1) {
        let names = [&group.first()?.0, &group.first()?.1];
        for (engine, name) in engines.iter_mut().zip(names) {
            engine.engine.open(&models.get(name)?.model).ok()?;
        }
        let start = Instant::now();
        for (_, _, query) in group {
            if start.elapsed().as_secs_f64() > plan.seconds {
                break;
            }
            let mut both = [Vec::new(), Vec::new()];
            for round in 0..=ROUNDS {
                for (k, way) in ways.into_iter().enumerate() {
                    let query = way(query, models.get(names[k])?.size);
                    let start = Instant::now();
                    std::hint::black_box(engines[k].engine.answer(&query));
                    // The first round prepares what the later ones use.
                    if round > 0 {
                        both[k].push(start.elapsed().as_secs_f64() * 1e6);
                    }
                }
            }
            let medians = both.map(|mut t| {
                t.sort_by(f64::total_cmp);
                quantile(&t, 0.5).unwrap_or(0.0)
            });
            ratios.push(medians[1] / medians[0]);
            times[0].push(medians[0]);
            times[1].push(medians[1]);
        }
    }
    let median = |mut t: Vec<f64>| {
        t.sort_by(f64::total_cmp);
        quantile(&t, 0.5)
    };
    let [less, full] = times;
    Some(LeftOut {
        what: what.to_owned(),
        suite: suite.to_owned(),
        queries: ratios.len(),
        less: median(less)?,
        full: median(full)?,
        ratio: median(ratios)?,
    })
}
