//! What it saves to leave out what a scene does not need.

use super::measure::{Plan, sample};
use super::numbers::quantile;
use crate::cases::{Loaded, Models, cases, load};
use crate::engine::{Engine, FeelerEngine, FeelerWay};
use feeler::nurbs::Surface;
use feeler::prepare::Shortcuts;
use feeler::query::{Accuracy, Contacts};
use feeler_corpus::{CorpusError, Hits, MODELS, Query, suites};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// The same queries answered in two ways.
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
    /// How many were undecided in each way.
    pub undecided: [usize; 2],
}

/// How often each query is asked each way.
const ROUNDS: usize = 3;
/// The part of a plan's seconds that a comparison may spend on one model: there are many of both.
const SHARE: f64 = 0.25;
/// A comparison may take this many times a plan's seconds; models left then are not asked.
const PATIENCE: f64 = 20.0;

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

fn deepest(query: &Query, _: f64) -> Query {
    Query {
        contacts: Some(Contacts::Deepest),
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
        suite: "contacts",
        less: deepest,
        full: as_asked,
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

/// A comparison of the kernel with itself without something, on a suite.
struct Without {
    what: &'static str,
    suite: &'static str,
    /// Only models with native surfaces.
    native: bool,
    way: FeelerWay,
}

const fn without(
    what: &'static str,
    suite: &'static str,
    native: bool,
    shortcuts: Shortcuts,
) -> Without {
    let way = FeelerWay {
        nurbs: false,
        shortcuts,
    };
    Without {
        what,
        suite,
        native,
        way,
    }
}

const ALL: Shortcuts = Shortcuts::ALL;
const CLOSED: Shortcuts = Shortcuts {
    closed_forms: false,
    ..ALL
};
const CELLS: Shortcuts = Shortcuts {
    trim_cells: false,
    ..ALL
};
const FORMULAS: &str = "formulas for native surfaces, against the search";
const GRID: &str = "a grid of cells over trims, against one cell";

const WITHOUTS: [Without; 12] = [
    without(FORMULAS, "contact-sphere", true, CLOSED),
    without(FORMULAS, "line", true, CLOSED),
    Without {
        what: "native surfaces, against these turned into NURBS by us",
        suite: "contact-sphere",
        native: true,
        way: FeelerWay {
            nurbs: true,
            shortcuts: ALL,
        },
    },
    without(
        "boxes around faces and patches, against none",
        "contact-sphere",
        false,
        Shortcuts {
            boxes: false,
            ..ALL
        },
    ),
    without(
        "boxes around faces and patches, against none",
        "parts",
        false,
        Shortcuts {
            boxes: false,
            ..ALL
        },
    ),
    without(
        "planes and round surfaces recognised in NURBS, against their coefficients alone",
        "contact-sphere",
        false,
        Shortcuts {
            recognition: false,
            ..ALL
        },
    ),
    without(
        "settled where convex, against halving on",
        "contact-sphere",
        false,
        Shortcuts {
            convex_leaves: false,
            ..ALL
        },
    ),
    without(
        "reduced to borders where monotone, against halving on",
        "contact-sphere",
        false,
        Shortcuts {
            monotone_borders: false,
            ..ALL
        },
    ),
    without(
        "f64 first, against double-double at once",
        "contact-sphere",
        false,
        Shortcuts {
            double_first: false,
            ..ALL
        },
    ),
    without(
        "sides kept for cells of space, against a ray for each centre",
        "contact-sphere",
        false,
        Shortcuts {
            side_cells: false,
            ..ALL
        },
    ),
    without(GRID, "trim-loops", false, CELLS),
    without(GRID, "contact-sphere", false, CELLS),
];

/// What native models are compared with, by the end of the file's name.
const AS_NURBS: &str = "_nurbs.3dm";
/// Suites of which the queries about NURBS parts are also asked of their native siblings.
const PAIRED: [&str; 4] = ["contact-sphere", "contact-half-space", "line", "inside"];

/// How many comparisons there are.
pub(crate) const COUNT: usize = COMPARISONS.len() + WITHOUTS.len() + PAIRED.len();

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
    let mut known = BTreeMap::new();
    let mut of_suite = |name: &'static str, models: &mut Models| -> Result<_, CorpusError> {
        if !known.contains_key(name) {
            let mut all = Vec::new();
            for suite in suites(corpus, Some(name))? {
                let found = cases(corpus, &suite, models)?;
                all.extend(found.into_iter().map(|c| (c.query.model, c.query.query)));
            }
            known.insert(name, all);
        }
        Ok(known.get(name).cloned().unwrap_or_default())
    };
    let choose = |all: Vec<(String, Query)>| -> Vec<(String, String, Query)> {
        let chosen = sample(all.len(), plan.sample / 2).into_iter();
        let both = |(model, query): &(String, Query)| (model.clone(), model.clone(), query.clone());
        chosen.map(|i| both(&all[i])).collect()
    };
    let same: [Way; 2] = [as_asked; 2];
    for c in &COMPARISONS {
        let pairs = choose(of_suite(c.suite, models)?);
        let mut engines = [FeelerEngine::default(), FeelerEngine::default()];
        let ways = [c.less, c.full];
        rows.extend(row(
            c.what,
            c.suite,
            &pairs,
            models,
            &mut engines,
            ways,
            plan,
        ));
        tick();
    }
    for c in &WITHOUTS {
        let mut all = of_suite(c.suite, models)?;
        all.retain(|(model, _)| !c.native || models.get(model).is_some_and(is_native));
        let pairs = choose(all);
        let mut engines = [FeelerEngine::default(), FeelerEngine::with(c.way)];
        rows.extend(row(
            c.what,
            c.suite,
            &pairs,
            models,
            &mut engines,
            same,
            plan,
        ));
        tick();
    }
    for name in PAIRED {
        let mut all = of_suite(name, models)?;
        all.retain(|(model, _)| model.ends_with(AS_NURBS));
        let mut pairs = choose(all);
        for (native, _, _) in &mut pairs {
            *native = native.replace(AS_NURBS, ".3dm");
        }
        pairs.retain(|(native, ..)| corpus.join(MODELS).join(native).exists());
        for (native, ..) in &pairs {
            if !models.contains_key(native) {
                models.insert(native.clone(), load(corpus, native)?);
            }
        }
        let what = "native surfaces, against the same part as NURBS";
        let mut engines = [FeelerEngine::default(), FeelerEngine::default()];
        rows.extend(row(what, name, &pairs, models, &mut engines, same, plan));
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
    engines: &mut [FeelerEngine; 2],
    ways: [Way; 2],
    plan: &Plan,
) -> Option<LeftOut> {
    let mut undecided = [0; 2];
    let (mut times, mut ratios) = ([Vec::new(), Vec::new()], Vec::new());
    let begun = Instant::now();
    let groups: Vec<_> = pairs.chunk_by(|a, b| a.0 == b.0 && a.1 == b.1).collect();
    for k in scattered(groups.len()) {
        if begun.elapsed().as_secs_f64() > PATIENCE * plan.seconds {
            break;
        }
        let group = groups[k];
        let names = [&group.first()?.0, &group.first()?.1];
        for (engine, name) in engines.iter_mut().zip(names) {
            engine.open(&models.get(name)?.model).ok()?;
        }
        let start = Instant::now();
        for (_, _, query) in group {
            if start.elapsed().as_secs_f64() > SHARE * plan.seconds {
                break;
            }
            let mut both = [Vec::new(), Vec::new()];
            for round in 0..=ROUNDS {
                let mut times = [0.0; 2];
                for (k, way) in ways.into_iter().enumerate() {
                    let query = way(query, models.get(names[k])?.size);
                    let start = Instant::now();
                    let body = std::hint::black_box(engines[k].answer(&query).body);
                    times[k] = start.elapsed().as_secs_f64();
                    undecided[k] += usize::from(round == 0 && body.undecided().is_some());
                }
                // The first round prepares what the later ones use, unless it takes too long to be asked again.
                let most = if round > 0 {
                    SHARE * plan.seconds
                } else {
                    plan.seconds
                };
                let slow = times[0].max(times[1]) > most;
                if round > 0 || slow {
                    both[0].push(times[0] * 1e6);
                    both[1].push(times[1] * 1e6);
                }
                if slow {
                    break;
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
        undecided,
    })
}

/// 0 to `count` in an order whose every beginning is spread over all of them: by the digits in base two, read backwards
/// (van der Corput's sequence). A comparison that ends early has then seen models of every kind, not the first by name.
fn scattered(count: usize) -> impl Iterator<Item = usize> {
    let all = count.next_power_of_two();
    let shift = usize::BITS - all.trailing_zeros();
    (0..all)
        .map(move |k| k.reverse_bits().checked_shr(shift).unwrap_or(0))
        .filter(move |k| *k < count)
}

fn is_native(loaded: &Loaded) -> bool {
    let breps = &loaded.model.breps;
    let mut surfaces = breps.iter().flat_map(|b| &b.parts().surfaces);
    surfaces.any(|s| !matches!(s, Surface::Nurbs(_)))
}

#[cfg(test)]
mod tests {
    use super::scattered;

    #[test]
    fn every_model_comes_once_and_early_ones_lie_apart() {
        assert_eq!(scattered(0).count(), 0);
        assert_eq!(scattered(1).collect::<Vec<_>>(), [0]);
        assert_eq!(scattered(6).collect::<Vec<_>>(), [0, 4, 2, 1, 5, 3]);
    }
}
