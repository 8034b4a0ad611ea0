//! The stored truth about a .3dm file is the truth about the .brep of the same part, up to what OCCT's printing of 15
//! digits moves.

use feeler::prepare::PreparedBrep;
use feeler::query::*;
use feeler_corpus::{Ask, MODELS, Model, Truth, suites};
use std::collections::BTreeMap;
use std::path::Path;

/// Twice half a unit in the 15th digit of the size: the largest difference between points of the two files' faces and trims,
/// as `feeler-io`'s test of siblings holds. No distance to them changes by more.
const PRINTED: f64 = 1e-14;

/// Queries of a model from one suite, at most.
const QUERIES: usize = 6;

#[test]
fn the_truth_about_a_3dm_holds_for_its_brep() {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpora");
    let mut models: BTreeMap<String, Option<PreparedBrep>> = BTreeMap::new();
    let mut asked: BTreeMap<(String, String), usize> = BTreeMap::new();
    for suite in ["contact-sphere", "contact-half-space", "thesis", "inside"] {
        for suite in suites(&corpora, Some(suite)).unwrap() {
            for file in &suite.files {
                let (queries, hash) = file.queries().unwrap();
                let truths = file.truth(queries.len(), &hash).unwrap().1;
                for (query, truth) in queries.iter().zip(truths) {
                    let count = asked
                        .entry((suite.name.clone(), query.model.clone()))
                        .or_default();
                    if *count >= QUERIES {
                        continue;
                    }
                    let model = models.entry(query.model.clone()).or_insert_with(|| {
                        let path = corpora
                            .join(MODELS)
                            .join(&query.model)
                            .with_extension("brep");
                        path.exists().then(|| {
                            let [brep] =
                                <[_; 1]>::try_from(Model::load(&path, None).unwrap().breps)
                                    .unwrap();
                            PreparedBrep::new(brep)
                        })
                    });
                    let Some(model) = model else { continue };
                    *count += 1;
                    check(model, &query.query.ask, &truth, &query.model);
                }
            }
        }
    }
    // A dozen and more of each part that has both files.
    let mut by_part: BTreeMap<&str, usize> = BTreeMap::new();
    for ((_, model), count) in &asked {
        *by_part.entry(model).or_default() += count;
    }
    let parts = by_part.values().filter(|n| **n >= 12).count();
    println!("{by_part:?}");
    assert!(parts >= 12, "{by_part:?}");
}

fn check(model: &PreparedBrep, ask: &Ask, truth: &Truth, name: &str) {
    let mut workspace = Workspace::default();
    match (ask, truth) {
        (Ask::Contact(probe), Truth::Separation(t) | Truth::Contact { separation: t, .. }) => {
            let answer = contact(model, probe, &Options::default(), &mut workspace);
            let claim = answer.separation.bounds;
            let slack = PRINTED * model.size();
            let (lo, hi) = (t.lo.approximate(), t.hi.approximate());
            assert!(
                claim.lo - slack <= hi && lo <= claim.hi + slack,
                "{name}, {probe:?}: {claim:?}, the truth is [{lo:?}, {hi:?}]"
            );
            // Not by being wide.
            assert!(
                answer.undecided.is_some() || claim.hi - claim.lo <= slack,
                "{name}, {probe:?}: {claim:?}"
            );
        }
        (Ask::Inside(point), Truth::Side { side, .. }) => {
            let answer = inside(model, *point, &mut workspace);
            // `None`: nearer to the border than what the files differ by may make it.
            assert!(
                answer.side.is_none_or(|s| s == *side),
                "{name}, {point:?}: {answer:?}"
            );
        }
        _ => {}
    }
}
