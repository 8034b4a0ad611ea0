//! The BREPs of a file, and how their features are numbered.

use crate::files::{read_text, write_text};
use crate::hash::breps_hash;
use crate::model_file;
use feeler::brep::Brep;
use feeler_io::{Choice, Document, FileError, Object, ObjectKind, ReadError};
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
    /// A model file of our own cannot be read or written.
    #[error("{}: {error}; check the path, its permissions and that the file is whole", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// A model file of our own says what cannot be.
    #[error("{}: {place}: {reason}; correct the file, or make it again", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: String,
        /// Why.
        reason: String,
    },
    /// There is no BREP in the file.
    #[error("{}: the file holds no BREP; `feeler inspect` lists what it holds", path.display())]
    NoBrep {
        /// The file.
        path: PathBuf,
    },
    /// There are surfaces in the file that are no part of a BREP, and no BREP.
    #[error("{}: the file holds no BREP, but loose surfaces: ask one by itself, with --object {object}", path.display())]
    OnlySurfaces {
        /// The file.
        path: PathBuf,
        /// The first of them.
        object: usize,
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
    /// Reads a file and keeps all BREPs that the model consists of ([`Document::bodies`]: extrusions and what block references place
    /// too, members of blocks not), or object `object` alone (as numbered by `feeler inspect`; it may be a surface or a member of a block). A name that ends with `.json` or `.json.gz` is a model
    /// file of our own, whose BREPs count as objects; any other is read by [`feeler_io::read_file`].
    pub fn load(path: &Path, object: Option<usize>) -> Result<Self, ModelError> {
        if Self::is_own(path) {
            return Self::load_own(path, object);
        }
        Self::from_document(path, feeler_io::read_file(path)?, object, Choice::default())
    }

    /// The same, without the hidden or the locked objects of a .3dm file. A model file of our own has none.
    pub fn load_chosen(path: &Path, choice: Choice) -> Result<Self, ModelError> {
        if Self::is_own(path) {
            return Self::load_own(path, None);
        }
        Self::from_document(path, feeler_io::read_file(path)?, None, choice)
    }

    /// Whether a name says that it is a model file of our own.
    pub fn is_own(path: &Path) -> bool {
        let name = path.as_os_str().to_string_lossy().to_ascii_lowercase();
        name.ends_with(".json") || name.ends_with(".json.gz")
    }

    fn load_own(path: &Path, object: Option<usize>) -> Result<Self, ModelError> {
        let path = path.to_path_buf();
        let text = match read_text(&path) {
            Ok(text) => text,
            Err(error) => return Err(ModelError::Io { path, error }),
        };
        let mut breps = Self::from_text(&path, &text)?;
        if let Some(object) = object {
            let count = breps.len();
            if object >= count {
                return Err(ModelError::NoObject {
                    path,
                    object,
                    count,
                });
            }
            breps = vec![breps.swap_remove(object)];
        }
        Ok(Self { path, breps })
    }

    /// The BREPs of the text of a model file of our own; the path is for messages alone.
    pub fn from_text(path: &Path, text: &str) -> Result<Vec<Brep>, ModelError> {
        model_file::from_text(text).map_err(|p| ModelError::Text {
            path: path.to_path_buf(),
            place: p.place,
            reason: p.reason,
        })
    }

    /// The text of a model file of our own.
    pub fn to_text(breps: &[Brep], unit: Option<&str>) -> String {
        model_file::to_text(breps, unit)
    }

    /// Writes the BREPs as a model file of our own; compressed where the name ends with `.gz`.
    /// Reading it gives the same BREPs bit for bit.
    pub fn write(path: &Path, breps: &[Brep], unit: Option<&str>) -> Result<(), ModelError> {
        write_text(path, &model_file::to_text(breps, unit)).map_err(|error| ModelError::Io {
            path: path.to_path_buf(),
            error,
        })
    }

    fn from_document(
        path: &Path,
        document: Document,
        object: Option<usize>,
        choice: Choice,
    ) -> Result<Self, ModelError> {
        let path = path.to_path_buf();
        let count = document.objects.len();
        let is_wanted = |index: usize, o: &Object| {
            object.map_or(!o.block_member && choice.takes(o), |w| w == index)
        };
        let refused = |index, class, reason: &ReadError| ModelError::Refused {
            path: path.clone(),
            object: index,
            class,
            reason: reason.to_string(),
        };
        // What references place, while all objects are there.
        let mut found: Vec<(usize, Brep)> = Vec::new();
        for (index, o) in document.objects.iter().enumerate() {
            let is_reference = matches!(o.kind, ObjectKind::Block { .. });
            if !is_reference || !is_wanted(index, o) {
                continue;
            }
            let placements = document.placements(index);
            for p in placements.filter(|p| choice.takes_placed(p)) {
                let part = p.placed();
                if let ObjectKind::Refused { class, reason } = &part.kind
                    && is_brep(class)
                {
                    return Err(refused(index, class.clone(), reason));
                }
                let brep = part.into_owned().into_body();
                found.extend(brep.map(|b| (index, b)));
            }
        }
        let mut surface = None;
        for (index, o) in document.objects.into_iter().enumerate() {
            if !is_wanted(index, &o) {
                continue;
            }
            match o.kind {
                ObjectKind::Brep(brep) | ObjectKind::Extrusion(brep) => found.push((index, brep)),
                ObjectKind::Surface(brep) if object.is_some() => found.push((index, brep)),
                ObjectKind::Surface(_) => surface = surface.or(Some(index)),
                ObjectKind::Refused { class, reason } if object.is_some() || is_brep(&class) => {
                    return Err(refused(index, class, &reason));
                }
                ObjectKind::Block { .. } => {}
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
        // In the order of the objects; what one places stays in its own.
        found.sort_by_key(|(index, _)| *index);
        let breps: Vec<Brep> = found.into_iter().map(|(_, brep)| brep).collect();
        match (breps.is_empty(), object) {
            (true, Some(object)) => Err(ModelError::NoObject {
                path,
                object,
                count,
            }),
            (true, None) => Err(match surface {
                Some(object) => ModelError::OnlySurfaces { path, object },
                None => ModelError::NoBrep { path },
            }),
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
    let class = class.to_ascii_lowercase();
    [
        "brep",
        "extrusion",
        "instanceref",
        "assembly",
        "compound",
        "placed shape",
        "surface_model",
    ]
    .iter()
    .any(|of| class.contains(of))
}
