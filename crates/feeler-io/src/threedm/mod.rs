//! The .3dm format, versions 3 to 8 (archive versions 3, 4, 5, 50, 60, 70, 80), little-endian.
//!
//! | module | reads |
//! |---|---|
//! | `archive` | chunks, checksums, plain values |
//! | `class` | class ids, and the wrapper around the data of an object |
//! | `curves`, `surfaces` | one class each |
//! | `brep` | `ON_Brep` 3.x |
//! | `attributes` | names, layers, units |
//! | `sheets` | nothing: sees that loops lie on one sheet of their surface |
//! | `document` | the whole file |

mod archive;
mod assembly;
mod attributes;
mod brep;
mod class;
mod curves;
mod document;
mod error;
mod sheets;
mod surfaces;
mod units;

pub use archive::MAX_DEPTH;
pub use document::{Document, MAX_FILE_SIZE, Object, ObjectKind, read_3dm, read_file};
pub use error::{ChunkId, FileError, FileProblem, Problem, ReadError};
pub use units::Units;
