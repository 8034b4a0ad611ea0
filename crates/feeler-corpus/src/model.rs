//! The BREPs of a file, and how their features are numbered.

use crate::hash::breps_hash;
use feeler::brep::Brep;
use feeler_io::{Document, FileError, ObjectKind};
use std::path::{Path, PathBuf};

/// Why a file is no model to ask.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// It cannot be read; the message names the file.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is no such object.
    #[error("{}: no object {object}: the file has {count}; `feeler inspect` lists them", path.display())]
    NoObject {
        /// The file.
        path: PathBuf,
        /// Which object was asked for.
        object: usize,
        /// How many there are.
        count: usize,
    },
    /// The object is not a BREP.
    #[error("{}: object {object} is of kind {kind}: only BREPs and surfaces can be asked", path.display())]
    NotABrep {
        /// The file.
        path: PathBuf,
        /// Which object.
        object: usize,
        /// What it is.
        kind: String,
    },
    /// A BREP of the file could not be read, so that an answer would be about the others alone.
    #[error(
        "{}: object {object} ({class}) cannot be read: {reason}; choose others with --object",
        path.display()
    )]
    Refused {
        /// The file.
        path: PathBuf,
        /// Which object.
        object: usize,
        /// Its class.
        class: String,
        /// Why.
        reason: String,
    },
    /// There is no BREP in the file.
    #[error("{}: the file holds no BREP; `feeler inspect` lists what it holds", path.display())]
    NoBrep {
        /// The file.
        path: PathBuf,
    },
}

/// The BREPs that queries are about: those of a file, or one object of it. Faces, edges and
/// vertices are numbered through them in order.
#[derive(Clone, Debug)]
pub struct Model {
    /// Where they come from.
    pub path: PathBuf,
    /// The BREPs, in file order.
    pub breps: Vec<Brep>,
}

impl Model {
    /// Reads a file and keeps all its BREPs, or object `object` alone (as numbered by
    /// `feeler inspect`; it may be a surface).
    pub fn load(path: &Path, object: Option<usize>) -> Result<Self, ModelError> {
        Self::from_document(path, feeler_io::read_file(path)?, object)
    }

    fn from_document(
        path: &Path,
        document: Document,
        object: Option<usize>,
    ) -> Result<Self, ModelError> {
        let path = path.to_path_buf();
        let count = document.objects.len();
        let mut breps = Vec::new();
        for (index, o) in document.objects.into_iter().enumerate() {
            if object.is_some_and(|wanted| wanted != index) {
                continue;
            }
            match o.kind {
                ObjectKind::Brep(brep) => breps.push(brep),
                ObjectKind::Surface(brep) if object.is_some() => breps.push(brep),
                ObjectKind::Refused { class, reason } if object.is_some() || is_brep(&class) => {
                    return Err(ModelError::Refused {
                        path,
                        object: index,
                        class,
                        reason: reason.to_string(),
                    });
                }
                kind if object.is_some() => {
                    return Err(ModelError::NotABrep {
                        path,
                        object: index,
                        kind: kind.name().to_owned(),
                    });
                }
                _ => {}
            }
        }
        match (breps.is_empty(), object) {
            (true, Some(object)) => Err(ModelError::NoObject {
                path,
                object,
                count,
            }),
            (true, None) => Err(ModelError::NoBrep { path }),
            (false, _) => Ok(Self { path, breps }),
        }
    }

    /// How many faces all BREPs have.
    pub fn faces(&self) -> usize {
        self.breps.iter().map(|b| b.faces().len()).sum()
    }

    /// The BREP of a face and its number there; `None` if there is no such face.
    pub fn face(&self, face: usize) -> Option<(usize, usize)> {
        let mut local = face;
        for (i, brep) in self.breps.iter().enumerate() {
            let count = brep.faces().len();
            if local < count {
                return Some((i, local));
            }
            local -= count;
        }
        None
    }

    /// The hash that ties a truth to these BREPs.
    pub fn hash(&self) -> String {
        breps_hash(&self.breps.iter().collect::<Vec<_>>())
    }
}

fn is_brep(class: &str) -> bool {
    class.to_ascii_lowercase().contains("brep")
}
