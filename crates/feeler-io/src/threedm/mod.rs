//! The .3dm format, versions 3 to 8 (archive versions 3, 4, 5, 50, 60, 70, 80), little-endian.
//!
//! | module | reads |
//! |---|---|
//! | `archive` | chunks, checksums, plain values |
//! | `class` | class ids, and the wrapper around the data of an object |
//! | `curves`, `surfaces` | one class each |
//! | `brep` | `ON_Brep` 3.x |
//! | `attributes` | names, layers, units |
//! | `document` | the whole file |

mod archive;
mod assembly;
mod attributes;
mod brep;
mod class;
mod curves;
mod document;
mod surfaces;

pub use archive::MAX_DEPTH;
pub(crate) use document::MAGIC;
pub use document::read_3dm;
