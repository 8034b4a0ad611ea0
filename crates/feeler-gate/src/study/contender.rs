//! The engines of a study, each at a setting.

use super::measure::accuracy;
use crate::engine::{Engine, EngineChoice, FeelerEngine, FeelerWay};
use feeler_corpus::{Ask, Query};

/// Kernels that lack one of their shortcuts: their settings are no steps of one dial, and are not joined by a line.
pub(crate) const LESS: &str = "feeler without";

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
            engine: Box::new(FeelerEngine::default()),
            accuracy: part,
        }
    }

    /// The kernel with all surfaces turned into NURBS, at an accuracy.
    pub fn nurbs(part: Option<f64>) -> Self {
        let way = FeelerWay {
            nurbs: true,
            ..FeelerWay::default()
        };
        Self {
            name: "feeler as NURBS".to_owned(),
            engine: Box::new(FeelerEngine::with(way)),
            ..Self::feeler(part)
        }
    }

    /// The kernel at full accuracy without each of its shortcuts in turn.
    pub fn less() -> impl Iterator<Item = Self> {
        FeelerWay::each_off().map(|(name, way)| Self {
            name: LESS.to_owned(),
            setting: name.trim_start_matches("no-").replace('-', " "),
            engine: Box::new(FeelerEngine::with(way)),
            accuracy: None,
        })
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

    /// Whether it is asked this: the accuracy matters to contacts alone, and the same answer twice shows nothing.
    pub(crate) fn treats(&self, query: &Query) -> bool {
        let dial = self.accuracy.is_none() || matches!(query.ask, Ask::Contact(_));
        dial && self.engine.treats(query)
    }

    /// The query as this contender is asked it.
    pub(crate) fn query(&self, query: &Query, size: f64) -> Query {
        Query {
            accuracy: Some(accuracy(self.accuracy, size)),
            ..query.clone()
        }
    }
}
