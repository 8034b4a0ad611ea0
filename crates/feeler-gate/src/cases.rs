//! The queries of a suite with their truth and their models.

use feeler::prepare::PreparedBrep;
use feeler_corpus::{CorpusError, CorpusQuery, MODELS, Model, Suite, Truth};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A model of a corpus with what the gate needs to know of it.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) model: Model,
    pub(crate) prepared: Vec<PreparedBrep>,
    hash: String,
    /// The longest side of its box.
    pub(crate) size: f64,
}

/// Models by the names that queries give them.
pub(crate) type Models = BTreeMap<String, Loaded>;

/// A query, what is true of it, and where it stands.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) query: CorpusQuery,
    pub(crate) truth: Truth,
    path: PathBuf,
}

impl Case {
    /// File and line.
    pub(crate) fn place(&self) -> String {
        format!("{}:{}", self.path.display(), self.query.number)
    }

    /// A command line that repeats it.
    pub(crate) fn command(&self, corpus: &Path) -> String {
        let mut line = self.query.line.clone();
        line.model = None;
        let model = corpus.join(MODELS).join(&self.query.model);
        // JSON holds no single quote here unless an id does; such an id is left out.
        if line.to_text().contains('\'') {
            line.id = None;
        }
        format!(
            "echo '{}' | cargo run --release -- contact {}",
            line.to_text(),
            model.display()
        )
    }
}

fn prepared(model: &Model) -> Vec<PreparedBrep> {
    let breps = model.breps.iter();
    breps.map(|b| PreparedBrep::new(b.clone())).collect()
}

fn size(prepared: &[PreparedBrep]) -> f64 {
    prepared.iter().fold(0.0, |m, b| b.size().max(m))
}

/// The longest side of a model's box.
pub fn model_size(model: &Model) -> f64 {
    size(&prepared(model))
}

/// The queries of a suite, by model, so that each is opened once. Models that are not known yet are loaded.
///
/// # Errors
/// A file cannot be read, or the truth was made for other queries or BREPs.
pub(crate) fn cases(
    corpus: &Path,
    suite: &Suite,
    models: &mut Models,
) -> Result<Vec<Case>, CorpusError> {
    let mut cases = Vec::new();
    for file in &suite.files {
        let (queries, hash) = file.queries()?;
        let (header, truths) = file.truth(queries.len(), &hash)?;
        for query in &queries {
            if !models.contains_key(&query.model) {
                models.insert(query.model.clone(), load(corpus, &query.model)?);
            }
            let loaded = models.get(&query.model);
            if header.models.get(&query.model) != loaded.map(|l| &l.hash) {
                return Err(CorpusError::Stale {
                    path: file.truth.clone(),
                    what: format!("BREPs of {}", query.model),
                });
            }
        }
        cases.extend(queries.into_iter().zip(truths).map(|(query, truth)| Case {
            query,
            truth,
            path: file.queries.clone(),
        }));
    }
    // The sort is stable.
    cases.sort_by(|a, b| a.query.model.cmp(&b.query.model));
    Ok(cases)
}

/// Loads a model of the corpus.
///
/// # Errors
/// Its file cannot be read.
pub(crate) fn load(corpus: &Path, name: &str) -> Result<Loaded, CorpusError> {
    Ok(loaded(Model::load(&corpus.join(MODELS).join(name), None)?))
}

pub(crate) fn loaded(model: Model) -> Loaded {
    let prepared = prepared(&model);
    Loaded {
        hash: model.hash(),
        size: size(&prepared),
        prepared,
        model,
    }
}
