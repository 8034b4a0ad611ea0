//! Shapes by reference to their file: what is written is where the BREP came from, not what it is.
//!
//! A [`ShapeFile`] names a file, an object of it and the SHA-256 of the BREP as it was imported: every number, index and flag
//! ([`breps_hash`]). A file that has been changed so that the BREP is another is an error that names it; one whose other objects, names or
//! layers have changed is not. Relative paths are those of the process, then and now.
//!
//! ```no_run
//! use feeler_rapier::BrepShape;
//!
//! let socket = BrepShape::from_file("corpora/models/thesis/ball_joint_socket.3dm", 0)?;
//! let saved = serde_json::to_string(&socket)?;
//! let again: BrepShape = serde_json::from_str(&saved)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Rapier's and Parry's own serialisation refuses custom shapes, before it asks them: what is saved of a world has to name its BREPs beside it.

use crate::shape::{BrepShape, Several, ShapeError};
use feeler::brep::Brep;
use feeler::prepare::PreparedBrep;
use feeler_corpus::{Model, ModelError, breps_hash};
use feeler_io::Affine;
use parry3d_f64::math::Vector;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a shape's BREP came from, and how it is asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShapeFile {
    /// Of any format that can be read.
    pub path: PathBuf,
    /// The object, as `feeler inspect` numbers them.
    pub object: usize,
    /// Which BREP of it: 0, but for a block reference, which may place several.
    #[serde(default)]
    pub part: usize,
    /// SHA-256 of the BREP, in hexadecimal.
    pub hash: String,
    /// Width of enclosures, in the model's units.
    pub accuracy: f64,
    /// Which contacts of balls are told.
    #[serde(default)]
    pub several: Several,
}

/// Why a shape cannot be had from a file, or be written as one.
#[derive(Debug, thiserror::Error)]
pub enum ShapeFileError {
    /// The file cannot be read, or has no such object; the message names it.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The object has fewer BREPs.
    #[error("{}: object {object} has no BREP {part}: it has {count}, counted from 0; name another part", path.display())]
    NoPart {
        /// The file.
        path: PathBuf,
        /// Which object.
        object: usize,
        /// Which of its BREPs.
        part: usize,
        /// How many it has.
        count: usize,
    },
    /// The BREP is not the one that was saved.
    #[error(
        "{}: object {object}, part {part}, is not the BREP that was saved (SHA-256 {found}, saved {saved}): the file has changed since; \
         restore it, or take the shape from it anew (BrepShape::from_file) and save that",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// Which object.
        object: usize,
        /// Which of its BREPs.
        part: usize,
        /// The hash now.
        found: String,
        /// The hash then.
        saved: String,
    },
    /// It cannot be a shape.
    #[error("{}: object {object}: {problem}; name another object", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// Which object.
        object: usize,
        /// Why.
        problem: ShapeError,
    },
    /// The accuracy is none.
    #[error("{}: the accuracy {accuracy} is no length: give a number above 0", path.display())]
    Accuracy {
        /// The file.
        path: PathBuf,
        /// What was given.
        accuracy: f64,
    },
}

/// Where a BREP was found.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    path: PathBuf,
    object: usize,
    part: usize,
    hash: String,
}

impl Source {
    fn read(path: &Path, object: usize, part: usize) -> Result<(Self, Brep), ShapeFileError> {
        let mut breps = Model::load(path, Some(object))?.breps;
        let path = path.to_path_buf();
        let count = breps.len();
        if part >= count {
            return Err(ShapeFileError::NoPart {
                path,
                object,
                part,
                count,
            });
        }
        let brep = breps.swap_remove(part);
        let hash = breps_hash(&[&brep]);
        let source = Self {
            path,
            object,
            part,
            hash,
        };
        Ok((source, brep))
    }

    fn shape(self, brep: Brep) -> Result<BrepShape, ShapeFileError> {
        let Self { path, object, .. } = self.clone();
        let shape = BrepShape::with_source(Arc::new(PreparedBrep::new(brep)), Some(self));
        shape.map_err(|problem| ShapeFileError::Shape {
            path,
            object,
            problem,
        })
    }
}

impl BrepShape {
    /// The shape of an object of a file, as `feeler inspect` numbers them. It can be saved, by reference to the file.
    ///
    /// # Errors
    /// In one line that names the file.
    pub fn from_file(path: impl AsRef<Path>, object: usize) -> Result<Self, ShapeFileError> {
        let (source, brep) = Source::read(path.as_ref(), object, 0)?;
        source.shape(brep)
    }

    /// Where it came from; `None` if it was not made from a file, or was scaled since.
    pub fn file(&self) -> Option<ShapeFile> {
        self.source().map(|s| ShapeFile {
            path: s.path.clone(),
            object: s.object,
            part: s.part,
            hash: s.hash.clone(),
            accuracy: self.accuracy(),
            several: self.several(),
        })
    }
}

impl ShapeFile {
    /// Reads the file again.
    ///
    /// # Errors
    /// In one line that names the file: among others, that the BREP is not the one that was saved.
    pub fn load(&self) -> Result<BrepShape, ShapeFileError> {
        if !(self.accuracy > 0.0 && self.accuracy.is_finite()) {
            return Err(ShapeFileError::Accuracy {
                path: self.path.clone(),
                accuracy: self.accuracy,
            });
        }
        let (source, brep) = Source::read(&self.path, self.object, self.part)?;
        if source.hash != self.hash {
            return Err(ShapeFileError::Changed {
                path: source.path,
                object: source.object,
                part: source.part,
                found: source.hash,
                saved: self.hash.clone(),
            });
        }
        let shape = source.shape(brep)?;
        Ok(shape
            .with_accuracy(self.accuracy)
            .with_several(self.several))
    }
}

impl Serialize for BrepShape {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let file = self.file().ok_or_else(|| {
            serde::ser::Error::custom(
                "a BREP that is not from a file cannot be saved: make it with BrepShape::from_file, and scale it after loading",
            )
        })?;
        file.serialize(to)
    }
}

impl<'de> Deserialize<'de> for BrepShape {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let file = ShapeFile::deserialize(from)?;
        file.load().map_err(serde::de::Error::custom)
    }
}

/// The BREP times a factor along each axis, if no number of it is rounded: the same power of two along all, the signs apart.
pub(crate) fn scaled(brep: &Brep, by: Vector) -> Option<Brep> {
    let rows = [
        [by.x, 0.0, 0.0, 0.0],
        [0.0, by.y, 0.0, 0.0],
        [0.0, 0.0, by.z, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    let mut flat = [0.0; 16];
    for (to, from) in flat.iter_mut().zip(rows.iter().flatten()) {
        *to = *from;
    }
    let moved = Affine::from_rows(&flat)?.apply(brep).ok()?;
    (moved.off == 0.0).then_some(moved.brep)
}
