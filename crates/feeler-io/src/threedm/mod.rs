//! The .3dm format, versions 3 to 8 (archive versions 3, 4, 5, 50, 60, 70, 80), little-endian.
//!
//! | module | reads |
//! |---|---|
//! | `archive` | chunks, checksums, plain values |
//! | `class` | class ids, and the wrapper around the data of an object |
//! | `curves`, `surfaces` | one class each |
//! | `brep` | `ON_Brep` 3.x |
//! | `extrusion` | `ON_Extrusion`, as a BREP |
//! | `blocks` | definitions and references, and what these place |
//! | `attributes` | names, layers, units |
//! | `document` | the whole file |
//! | `write` | all of it, the other way |

mod archive;
mod assembly;
mod attributes;
pub(crate) mod blocks;
mod brep;
mod class;
mod curves;
mod document;
mod extrusion;
mod surfaces;
mod write;

pub use archive::MAX_DEPTH;
pub(crate) use document::MAGIC;
pub use document::read_3dm;
pub use write::{Written, write_3dm};
