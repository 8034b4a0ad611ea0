//! Engines x corpus -> verdicts -> reports.
//!
//! The gate reads stored truth and needs no C++. An [`Engine`] answers queries; [`run`] holds its
//! answers against the truth of a corpus and the ceilings of each suite.
#![forbid(unsafe_code)]

mod baseline;
mod cases;
pub mod census;
mod continuum;
mod engine;
mod junit;
mod place;
pub mod plot;
mod report;
mod run;
pub mod study;
pub mod tessellate;

pub use baseline::{Comparison, ERROR_FACTOR};
pub use cases::model_size;
pub use engine::{
    AsNurbs, Engine, EngineChoice, FeelerEngine, FeelerWay, MeshEngine, ModelForm, ProcessEngine,
    ProcessOptions, ThesisEngine, as_nurbs,
};
pub use report::{Failure, Report, Row};
pub use run::{Gate, Progress, asked, run};
