//! The .3dm format, versions 1 to 8 (archive versions 1 to 5, 50, 60, 70, 80), little-endian.
//!
//! | module | reads |
//! |---|---|
//! | `archive` | chunks, checksums, plain values |
//! | `class` | class ids, and the wrapper around the data of an object |
//! | `curves`, `surfaces` | one class each |
//! | `on_surface`, `parameter_lines` | `ON_CurveOnSurface`, as curves in space |
//! | `brep`, `brep2` | `ON_Brep` 3.x, 2.x |
//! | `rebuild` | the topology that BREPs before 3.x do not store |
//! | `version1` | files of version 1: another container, other geometry |
//! | `extrusion` | `ON_Extrusion`, as a BREP |
//! | `blocks` | definitions and references, and what these place |
//! | `attributes` | names, layers, units |
//! | `document` | the whole file |
//! | `write` | all of it, the other way |

mod archive;
mod assembly;
mod attributes;
mod blocks;
mod brep;
mod brep2;
mod class;
mod curves;
mod document;
mod extrusion;
mod on_surface;
mod parameter_lines;
mod rebuild;
mod surfaces;
mod version1;
mod write;

pub use archive::MAX_DEPTH;
pub(crate) use document::MAGIC;
pub use document::read_3dm;
pub use write::{Written, write_3dm};
