//! Files into [`feeler::brep::Brep`]s.
//!
//! [`read_file`] reads a file into a [`Document`], [`read_3dm`] a .3dm file of version 3 to 8 from memory, and
//! [`read_brep`] OCCT's text format `.brep`, versions 1 to 3:
//!
//! ```no_run
//! use feeler_io::{ObjectKind, read_file};
//!
//! let document = read_file("part.3dm")?;
//! println!("{} {} in {}", document.format.name(), document.version, document.units);
//! for object in &document.objects {
//!     match &object.kind {
//!         ObjectKind::Brep(brep) => println!("{} faces", brep.faces().len()),
//!         ObjectKind::Refused { class, reason } => println!("{class} refused: {reason}"),
//!         other => println!("{}", other.name()),
//!     }
//! }
//! # Ok::<(), feeler_io::FileError>(())
//! ```
//!
//! **Numbers.** Nothing is scaled, and lengths stay in the file's [`Units`]. Every f64 of a .3dm file that reaches a
//! BREP has the bits it has in the file; what is rounded of a .brep file, [`read_brep`] says.
//!
//! **Hostile files.** No input panics. Every count is checked against the bytes that are left
//! before anything is allocated for it, so memory stays within a small multiple of
//! the file's size; chunks nest at most [`MAX_DEPTH`] deep; checksums are verified on every chunk
//! whose content is used. Shapes of a .brep file refer to earlier ones alone, and how often they are used again is
//! limited. A broken structure is a [`ReadError`]; a broken object is [`ObjectKind::Refused`] and does not touch the
//! others.
#![forbid(unsafe_code)]

mod document;
mod error;
mod file;
mod occt;
mod sheets;
mod threedm;
mod units;

pub use document::{Document, Format, Object, ObjectKind};
pub use error::{ChunkId, FileError, FileProblem, Problem, ReadError};
pub use file::{MAX_FILE_SIZE, read_file};
pub use occt::{TextProblem, read_brep};
pub use threedm::{MAX_DEPTH, read_3dm};
pub use units::Units;
