//! A suite of a corpus: each query with its picture, its answer and what that earned.

use crate::{Fineness, MOST_QUERIES, Part, Shown, View};
use feeler_corpus::{MODELS, Model, Verdict, judge, suites};
use feeler_gate::{Engine, FeelerEngine, asked, model_size};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A model that has been cut: its place among the parts.
struct Loaded {
    model: Model,
    part: usize,
    /// What the judge takes for its size.
    size: f64,
}

/// All queries of a suite, answered by the kernel and held against the stored truth; their models once each. At most [`MOST_QUERIES`].
///
/// # Errors
/// In one line: the corpus cannot be read, its truth was made for other queries or BREPs, or a model cannot be cut.
pub fn suite(corpus: &Path, name: &str, fineness: &Fineness) -> Result<View, String> {
    let found = suites(corpus, Some(name)).map_err(|e| e.to_string())?;
    // The bound on triangles is one for the page: its models share it.
    let mut models = BTreeSet::new();
    for file in found.iter().flat_map(|s| &s.files) {
        let (queries, _) = file.queries().map_err(|e| e.to_string())?;
        models.extend(queries.into_iter().map(|q| q.model));
    }
    let fineness = &Fineness {
        most: fineness.most / models.len().max(1),
        ..*fineness
    };
    let mut view = View {
        title: format!("suite {name}"),
        overview: true,
        ..View::default()
    };
    let mut engine = FeelerEngine::default();
    let mut loaded: BTreeMap<String, Loaded> = BTreeMap::new();
    let mut opened = String::new();
    let mut counts = [0usize; 4];
    for suite in found {
        view.notes.push(suite.file.description.clone());
        for file in &suite.files {
            let (queries, hash) = file.queries().map_err(|e| e.to_string())?;
            let truth = file.truth(queries.len(), &hash);
            let (header, truths) = truth.map_err(|e| e.to_string())?;
            for (query, truth) in queries.iter().zip(&truths) {
                if view.queries.len() == MOST_QUERIES {
                    let note = format!("more than {MOST_QUERIES} queries: the first are shown");
                    view.notes.push(note);
                    break;
                }
                if !loaded.contains_key(&query.model) {
                    let path = corpus.join(MODELS).join(&query.model);
                    let model = Model::load(&path, None).map_err(|e| e.to_string())?;
                    if header.models.get(&query.model) != Some(&model.hash()) {
                        return Err(format!(
                            "{}: made for other BREPs of {}; run `cargo xtask truth`",
                            file.truth.display(),
                            query.model
                        ));
                    }
                    let part = Part::new(&query.model, &model, fineness)
                        .map_err(|e| format!("{}: {e}", query.model))?;
                    view.parts.push(part);
                    let part = view.parts.len() - 1;
                    let size = model_size(&model);
                    loaded.insert(query.model.clone(), Loaded { model, part, size });
                }
                let Some(own) = loaded.get(&query.model) else {
                    continue;
                };
                if opened != query.model {
                    engine
                        .open(&own.model)
                        .map_err(|e| format!("{}: {e}", query.model))?;
                    opened.clone_from(&query.model);
                }
                let part = &view.parts[own.part];
                let answer = engine.answer(&query.query);
                let judgement = judge(&asked(&query.query, own.size, 0.0), &answer.body, truth);
                let mut shown = Shown::new(&own.model, part, query.number, &query.query, &answer);
                shown.part = own.part;
                let (state, place) = match judgement.verdict {
                    Verdict::Right => ("right", 0),
                    Verdict::Wrong => ("wrong", 1),
                    Verdict::Indeterminate => ("indeterminate", 2),
                    Verdict::Undecided => ("undecided", 3),
                };
                counts[place] += 1;
                shown.state = state;
                let mut words = format!("{state} against the stored truth");
                if let Some(reason) = &judgement.reason {
                    words += &format!(": {reason}");
                }
                if let Some(error) = judgement.error {
                    words += &format!("; the value is off by {error:.1e}");
                }
                if let Some(ulps) = judgement.ulps {
                    words += &format!(" ({ulps:.2} ulp)");
                }
                shown.judged = Some(words);
                view.queries.push(shown);
            }
        }
    }
    let [right, wrong, indeterminate, undecided] = counts;
    view.notes.push(format!(
        "{} queries of {} models: {right} right, {wrong} wrong, {indeterminate} indeterminate, {undecided} undecided against the stored truth",
        view.queries.len(),
        view.parts.len()
    ));
    Ok(view)
}
