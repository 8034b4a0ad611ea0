//! Queries, answers, scenes and truth as files.
//!
//! | module | holds |
//! |---|---|
//! | `query`, `answer` | the lines of JSON that the program and every engine speak |
//! | `model` | the BREPs of a file and how their features are numbered |
//! | `model_file` | our own model files: BREPs as JSON, exactly |
//! | `files` | text files, compressed or not, written whole or not at all |
//! | `truth` | the oracle's stored enclosures |
//! | `suite` | folders of queries, truth and ceilings |
//! | `verdict` | what an answer earned against the truth |
//! | `hash` | what ties a truth to its BREPs and queries |
//!
//! # A corpus
//! ```text
//! corpora/models/...            the models
//! corpora/SUITE/suite.json      description and ceilings
//! corpora/SUITE/NAME.jsonl      queries, a line each, with "model": a path from corpora/models
//! corpora/SUITE/NAME.truth.jsonl  who computed it, hashes; then the truth of each query, a line each
//! ```
#![forbid(unsafe_code)]

mod answer;
mod files;
mod hash;
mod model;
mod model_file;
mod query;
mod suite;
mod truth;
mod verdict;

pub use answer::{
    Answer, AnswerError, AxisSplitLine, Body, Claim, ContactLine, HitLine, SplitRootLine,
    side_word, why_at,
};
pub use files::{MAX_TEXT, read_text, write_text};
pub use hash::{breps_hash, bytes_hash};
pub use model::{Model, ModelError};
pub use model_file::MODEL_FILE_VERSION;
pub use query::{
    AccuracyLine, Ask, ContactsLine, FacePoint, Full, HalfSpaceLine, Hits, LineKindLine, LineLine,
    Pose, Query, QueryError, QueryLine, SpacePoint, SphereLine, TrimLine,
};
pub use suite::{Ceilings, CorpusError, CorpusQuery, MODELS, QueryFile, Suite, SuiteFile, suites};
pub use truth::{
    AxisSplitTruth, ContactTruth, HitTruth, SpaceBox, SplitRootTruth, Truth, TruthEnclosure,
    TruthHeader,
};
pub use verdict::{Asked, CONTINUUM_SLACK, Fault, Judgement, Verdict, judge, ulp};
