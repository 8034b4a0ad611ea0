//! The engines of a study, each at a setting.

use super::measure::accuracy;
use crate::engine::{Engine, EngineChoice, FeelerEngine};
use feeler::query::Options;
use feeler_corpus::Query;

/// An engine at one setting.
pub struct Contender {
    /// The engine: one curve of a plot.
    pub name: String,
    /// The setting: one point of it.
    pub setting: String,
    /// What answers.
    pub engine: Box<dyn Engine>,
    /// The accuracy it is asked for, as a part of the model's size; full otherwise.
    pub accuracy: Option<f64>,
}

impl std::fmt::Debug for Contender {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Contender({} {})", self.name, self.setting)
    }
}

impl Contender {
    /// The kernel at an accuracy: a part of the model's size, or full.
    pub fn feeler(part: Option<f64>) -> Self {
        Self {
            name: "feeler".to_owned(),
            setting: part.map_or("full".to_owned(), |p| format!("{p:e}")),
            engine: Box::new(FeelerEngine::new(Options::default())),
            accuracy: part,
        }
    }

    /// An engine other than the kernel, by its choice.
    ///
    /// # Errors
    /// Why it cannot be had, in one line.
    pub fn other(choice: &EngineChoice) -> Result<Self, String> {
        let engine = choice.engine()?;
        let (name, setting) = match choice {
            EngineChoice::Parry { degrees } => ("parry".to_owned(), format!("{degrees}°")),
            EngineChoice::Thesis { starts: 1 } => ("thesis".to_owned(), "published".to_owned()),
            EngineChoice::Thesis { starts } => ("thesis".to_owned(), format!("{starts} starts")),
            _ => (engine.name(), "as it is".to_owned()),
        };
        Ok(Self {
            name,
            setting,
            engine,
            accuracy: None,
        })
    }

    /// The query as this contender is asked it.
    pub(crate) fn query(&self, query: &Query, size: f64) -> Query {
        Query {
            accuracy: Some(accuracy(self.accuracy, size)),
            ..query.clone()
        }
    }
}
