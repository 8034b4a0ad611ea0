//! Engines: what answers queries.

mod as_nurbs;
mod choice;
mod feeler;
mod mesh;
mod process;
mod thesis;

pub use as_nurbs::{AsNurbs, as_nurbs};
pub use choice::{EngineChoice, FeelerWay};
pub use feeler::FeelerEngine;
pub use mesh::MeshEngine;
pub use process::{ModelForm, ProcessEngine, ProcessOptions};
pub use thesis::ThesisEngine;

use feeler_corpus::{Answer, Claim, Model, Query};

/// What answers queries about one model at a time, on any thread.
pub trait Engine: Send {
    /// Its name and version, for reports.
    fn name(&self) -> String;

    /// Turns to a model; queries are about it from then on.
    ///
    /// # Errors
    /// Why the model cannot be treated, in one line.
    fn open(&mut self, model: &Model) -> Result<(), String>;

    /// Answers a query.
    fn answer(&mut self, query: &Query) -> Answer;

    /// Whether it treats queries of this kind at all; the others are not asked.
    fn treats(&self, _query: &Query) -> bool {
        true
    }

    /// A command line that asks this engine the same about the open model; none if there is no such.
    fn repeats(&self, _query: &Query) -> Option<String> {
        None
    }

    /// How many triangles stand for the open model, where it is tessellated.
    fn triangles(&self) -> Option<usize> {
        None
    }

    /// Bytes that it holds for the open model, where it knows.
    fn memory(&self) -> Option<usize> {
        None
    }
}

/// A value of which nothing is claimed: see `Asked::tolerance`.
fn value_alone(value: f64) -> Claim {
    Claim {
        value,
        lo: None,
        hi: None,
    }
}
