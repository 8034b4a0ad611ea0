//! Files into [`feeler::brep::Brep`]s.
//!
//! [`read_file`] reads a file into a [`Document`], [`read_3dm`] a .3dm file of version 1 to 8 from memory, and
//! [`read_brep`] OCCT's text format `.brep`, versions 1 to 3, `read_step` STEP files:
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
//! // What stands in the model, parts of blocks and assemblies where these place them.
//! println!("{} bodies", document.bodies().count());
//! # Ok::<(), feeler_io::FileError>(())
//! ```
//!
//! [`write_3dm`] writes a document as .3dm, [`write_brep`] as OCCT's `.brep`, and [`Document::convert_units`] gives it other units.
//!
//! **Numbers.** Nothing is scaled unless [asked for](Document::convert_units), and lengths stay in the file's [`Units`]. Every f64 of a .3dm file that reaches a
//! BREP has the bits it has in the file, but for extrusions, whose faces are made here, and what block references move: warnings of the object, or of what is [placed](Placement::placed),
//! say so. What is rounded of a .brep or STEP file, [`read_brep`] and `read_step` say.
//!
//! **Hostile files.** No input panics. Every count is checked against the bytes that are left
//! before anything is allocated for it, so memory stays within a small multiple of
//! the file's size, whatever its blocks and assemblies unfold to ([`Document::placements`] tells it one by one, and how much that may be is limited); chunks nest at most [`MAX_DEPTH`] deep; checksums are verified on every chunk
//! whose content is used. Shapes of a .brep file refer to earlier ones alone, and how often they are used again within a
//! body is limited. A broken structure is a [`ReadError`]; a broken object is [`ObjectKind::Refused`] and does not touch the
//! others.
//!
//! **Features.** `step`, on unless turned off: without it [`read_file`] refuses STEP files by name.
#![forbid(unsafe_code)]
// What the readers of .brep and of STEP share is there for both.
#![cfg_attr(not(feature = "step"), allow(dead_code))]

mod affine;
mod blocks;
mod document;
mod error;
mod file;
mod numbers;
mod occt;
mod poles;
mod rescale;
mod reversed;
mod sheets;
#[cfg(feature = "step")]
mod step;
mod step_problem;
mod threedm;
mod units;
mod warp;

pub use affine::{Affine, MapError, Moved};
pub use blocks::{Block, Member, MemberOf, Placement, Placements};
pub use document::{Choice, Document, Format, Object, ObjectKind};
pub use error::{ChunkId, FileError, FileProblem, Problem, ReadError, WriteError};
pub use file::{MAX_FILE_SIZE, read_file};
pub use occt::{TextProblem, read_brep, write_brep};
pub use rescale::UnitsError;
#[cfg(feature = "step")]
pub use step::read_step;
pub use step_problem::StepProblem;
pub use threedm::{MAX_DEPTH, Written, read_3dm, write_3dm};
pub use units::Units;
