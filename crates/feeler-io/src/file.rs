//! A file of any format.

use crate::document::Document;
use crate::error::{FileError, FileProblem, ReadError};
use crate::occt::{self, read_brep};
#[cfg(feature = "step")]
use crate::step::read_step;
use crate::threedm::{self, read_3dm};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The largest file that [`read_file`] takes: 1 GiB.
pub const MAX_FILE_SIZE: u64 = 1 << 30;

/// What a STEP file starts with, up to blanks and comments, and how far from its start it may be.
const STEP: &[u8] = b"ISO-10303-21;";
const STEP_WITHIN: usize = 512;

/// Reads the file at `path`, by its content: see [`read_3dm`], [`read_brep`] and `read_step`. Where the content is
/// none of these, the name says what it was meant to be.
///
/// # Errors
/// [`FileError`], which names the file: it cannot be opened or read, is larger than
/// [`MAX_FILE_SIZE`], or its reader refuses it.
pub fn read_file(path: impl AsRef<Path>) -> Result<Document, FileError> {
    let path = path.as_ref();
    load(path).map_err(|problem| FileError {
        path: path.to_path_buf(),
        problem,
    })
}

#[cfg(not(feature = "step"))]
fn read_step(_: &[u8]) -> Result<Document, ReadError> {
    let problem = crate::step_problem::StepProblem::NotBuilt;
    Err(ReadError::Step(Box::new(problem)))
}

fn load(path: &Path) -> Result<Document, FileProblem> {
    let mut bytes = Vec::new();
    // One byte more than allowed, whatever the system says the size is: it may be a pipe.
    File::open(path)?
        .take(MAX_FILE_SIZE + 1)
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_FILE_SIZE {
        return Err(FileProblem::TooLarge);
    }
    Ok(read(&bytes, path)?)
}

fn read(bytes: &[u8], path: &Path) -> Result<Document, ReadError> {
    let named = |ends: &[&str]| {
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        extension.is_some_and(|e| ends.iter().any(|end| e == *end))
    };
    // Other programs' bytes may stand before the header of a .3dm file, but not before the other's.
    if occt::has_header(bytes) {
        return read_brep(bytes);
    }
    let rhino = bytes
        .windows(threedm::MAGIC.len())
        .any(|w| w == threedm::MAGIC);
    let step = bytes
        .get(..bytes.len().min(STEP_WITHIN))
        .is_some_and(|start| start.windows(STEP.len()).any(|w| w == STEP));
    if step || !rhino && named(&["step", "stp", "p21"]) {
        return read_step(bytes);
    }
    if !rhino && named(&["brep", "brp"]) {
        return read_brep(bytes);
    }
    read_3dm(bytes)
}

#[cfg(all(test, not(feature = "step")))]
mod tests {
    use super::{Path, read};

    #[test]
    fn step_files_are_refused_by_name() {
        let error = read(b"ISO-10303-21;\nHEADER;", Path::new("part")).expect_err("not built in");
        assert!(error.to_string().contains("feature `step`"), "{error}");
    }
}
