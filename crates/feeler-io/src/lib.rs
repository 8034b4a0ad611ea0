//! Files into [`feeler::brep::Brep`]s.
//!
//! [`read_file`] and [`read_3dm`] read .3dm files of versions 3 to 8 into a [`Document`]:
//!
//! ```no_run
//! use feeler_io::{ObjectKind, read_file};
//!
//! let document = read_file("part.3dm")?;
//! println!("{} in {}", document.version, document.units);
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
//! **Numbers.** Every f64 that reaches a BREP has the bits it has in the file; nothing is scaled,
//! and lengths stay in the file's [`Units`].
//!
//! **Hostile files.** No input panics. Every count is checked against the bytes that are left
//! before anything is allocated for it, so memory stays within a small multiple of
//! the file's size; chunks nest at most [`MAX_DEPTH`] deep; checksums are verified on every chunk
//! whose content is used. A broken chunk structure is a [`ReadError`]; a broken object is
//! [`ObjectKind::Refused`] and does not touch the others.
#![forbid(unsafe_code)]

mod threedm;

pub use threedm::{
    ChunkId, Document, FileError, FileProblem, MAX_DEPTH, MAX_FILE_SIZE, Object, ObjectKind,
    Problem, ReadError, Units, read_3dm, read_file,
};
