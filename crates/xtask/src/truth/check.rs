//! `cargo xtask truth --check`: a sample of the stored truth, computed again.

use super::Args;
use super::parallel::in_parallel;
use super::with_oracle::{Loaded, load, oracle_of, truth_of, unknown};
use crate::random::Random;
use feeler_corpus::{CorpusQuery, Truth, suites};
use feeler_oracle::Oracle;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Queries of each suite.
const SAMPLE: usize = 4;

/// A query of the sample, and what is stored for it.
struct Stored {
    suite: String,
    query: CorpusQuery,
    truth: Truth,
}

/// The sample of each suite: its queries by a generator that the suite's name seeds.
pub(super) fn sample(
    corpora: &Path,
    suite: Option<&str>,
    models: &mut BTreeMap<String, Loaded>,
    each: usize,
) -> Result<Vec<(String, CorpusQuery, Truth)>, String> {
    let text = |e: feeler_corpus::CorpusError| e.to_string();
    let mut all = Vec::new();
    for suite in suites(corpora, suite).map_err(text)? {
        for file in &suite.files {
            let (queries, hash) = file.queries().map_err(text)?;
            let (_, truths) = file.truth(queries.len(), &hash).map_err(text)?;
            let mut random = Random::new(&format!("sample {} {}", suite.name, file.name()));
            let chosen: BTreeSet<usize> = if each < queries.len() {
                (0..each).map(|_| random.below(queries.len())).collect()
            } else {
                (0..queries.len()).collect()
            };
            let both = queries.into_iter().zip(truths).enumerate();
            let both = both.filter(|(i, _)| chosen.contains(i));
            let both: Vec<_> = both.map(|(_, (q, t))| (suite.name.clone(), q, t)).collect();
            let asked: Vec<_> = both.iter().map(|(_, q, _)| q.clone()).collect();
            load(corpora, &asked, models)?;
            all.extend(both);
        }
    }
    Ok(all)
}

/// Where the oracle says something else than what is stored, in any bit of it.
///
/// # Errors
/// Names the queries.
pub(super) fn run(args: &Args) -> Result<(), String> {
    let mut models = BTreeMap::new();
    let each = args.sample.unwrap_or(SAMPLE);
    let stored: Vec<_> = sample(&args.corpora, args.suite.as_deref(), &mut models, each)?
        .into_iter()
        .map(|(suite, query, truth)| Stored {
            suite,
            query,
            truth,
        })
        .collect();
    let jobs = args
        .jobs
        .or_else(|| std::thread::available_parallelism().ok().map(Into::into));
    let differ = in_parallel(stored.len(), jobs.unwrap_or(1), || {
        let mut oracle: Option<(&str, Result<Oracle, String>)> = None;
        let (stored, models) = (&stored, &models);
        move |i| {
            let s = &stored[i];
            let loaded = models.get(&s.query.model)?;
            if oracle
                .as_ref()
                .is_none_or(|(name, _)| *name != s.query.model)
            {
                oracle = Some((&s.query.model, oracle_of(&loaded.model)));
            }
            let truth = match &oracle {
                Some((_, Ok(oracle))) => truth_of(oracle, &s.query.query, loaded.size),
                Some((_, Err(why))) => Err(why.clone()),
                None => Err("no oracle".to_owned()),
            };
            difference(s, &truth.unwrap_or_else(unknown))
        }
    })?;
    let differ: Vec<String> = differ.into_iter().flatten().collect();
    if differ.is_empty() {
        println!(
            "{} truths computed again: the same, bit for bit",
            stored.len()
        );
        return Ok(());
    }
    Err(format!(
        "{} of {} truths are not those that are stored; if the oracle was meant to change, run `cargo xtask truth \
         --force`:\n{}",
        differ.len(),
        stored.len(),
        differ.join("\n")
    ))
}

/// What differs, as text; the texts are what the files hold.
fn difference(stored: &Stored, now: &Truth) -> Option<String> {
    let text = |t: &Truth| serde_json::to_string(t).unwrap_or_default();
    let (old, new) = (text(&stored.truth), text(now));
    (old != new || new.is_empty()).then(|| {
        format!(
            "{} {}: {}\n  stored {old}\n  now    {new}",
            stored.suite,
            stored.query.number,
            stored.query.line.to_text()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A truth that was moved by its last bit is noticed, and named.
    #[test]
    fn a_changed_truth_is_noticed() {
        let corpora = xtask_test::root().join("corpora");
        let mut models = BTreeMap::new();
        let found = sample(&corpora, Some("thesis"), &mut models, 1).unwrap();
        let [(suite, query, truth)] = &found[..] else {
            panic!("one query");
        };
        let model = &models[&query.model];
        let oracle = oracle_of(&model.model).unwrap();
        let now = truth_of(&oracle, &query.query, model.size).unwrap();
        let mut stored = Stored {
            suite: suite.clone(),
            query: query.clone(),
            truth: truth.clone(),
        };
        assert_eq!(difference(&stored, &now), None);
        let (Truth::Separation(e) | Truth::Contact { separation: e, .. }) = &mut stored.truth
        else {
            panic!("a separation");
        };
        e.hi = &e.hi + &feeler::numeric::Dyadic::new(1.into(), -400);
        let text = difference(&stored, &now).unwrap();
        assert!(text.contains("thesis"), "{text}");
    }
}
