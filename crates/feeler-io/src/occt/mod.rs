//! OCCT's text format for shapes, `.brep`, versions 1 to 3.
//!
//! | module | holds |
//! |---|---|
//! | `tokens` | words, numbers, counts, lines |
//! | `splines` | knots, control points |
//! | `curves`, `surfaces` | each kind, as it is read and as the kernel holds it |
//! | `motion` | locations |
//! | `shapes` | the tables of a file |
//! | `projection` | curves in uv that the file leaves out, on planes |
//! | `wires` | the order of a loop's trims |
//! | `builder` | a BREP in the making |
//! | `sites` | which bodies stand where |
//! | `assembly` | from shapes to BREPs |
//! | `document` | the whole file |
//! | `write` | BREPs into such files |
//!
//! The format is described in OCCT's documentation, "BRep Format"; where that is silent (periodic splines, the order
//! of factors in a location, the second curve of a seam) files that OCCT writes decide, and tests hold us to them.

mod assembly;
pub(crate) mod builder;
pub(crate) mod curves;
mod document;
mod error;
pub(crate) mod motion;
pub(crate) mod projection;
mod shapes;
mod sites;
pub(crate) mod splines;
pub(crate) mod surfaces;
mod tokens;
mod wires;
mod write;

pub(crate) use document::has_header;
pub use document::read_brep;
pub use error::TextProblem;
pub use write::write_brep;
