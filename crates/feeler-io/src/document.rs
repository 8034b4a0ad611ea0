//! What reading gives.

use crate::error::ReadError;
use crate::units::Units;
use feeler::brep::Brep;
use feeler::nurbs::Curve3;

/// The format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// openNURBS, `.3dm`.
    Rhino,
    /// OCCT's text format, `.brep`.
    Occt,
}

impl Format {
    /// Its name in reports: `3dm`, `brep`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rhino => "3dm",
            Self::Occt => "brep",
        }
    }
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// In which format it was.
    pub format: Format,
    /// The version of the format, as in the file. Of .3dm: 3, 4, 5, 50, 60, 70 or 80 (2 too, with a warning);
    /// of .brep: 1, 2 or 3.
    pub version: u32,
    /// Version of the library that wrote a .3dm file, as stored; 0 if not said.
    pub opennurbs_version: u32,
    /// The unit of every length in the file. A .brep says none.
    pub units: Units,
    /// The tolerance the model was made with, in these units; `None` if unset.
    pub tolerance: Option<f64>,
    /// The objects, in file order, including those that could not be read.
    pub objects: Vec<Object>,
    /// What was odd about the file as a whole.
    pub warnings: Vec<String>,
}

impl Document {
    /// The BREPs with the index of their object, in file order.
    pub fn breps(&self) -> impl Iterator<Item = (usize, &Brep)> {
        let objects = self.objects.iter().enumerate();
        objects.filter_map(|(i, o)| match &o.kind {
            ObjectKind::Brep(brep) => Some((i, brep)),
            _ => None,
        })
    }
}

/// One object of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its name; empty if it has none.
    pub name: String,
    /// The name of its layer, if it is on one.
    pub layer: Option<String>,
    /// Whether it is part of a block's definition rather than of the model itself.
    pub block_member: bool,
    /// Byte offset of its record from the start of the file.
    pub offset: usize,
    /// What it is.
    pub kind: ObjectKind,
    /// What was odd about it: spans cut to their curve's domain, faces without loops, names that
    /// could not be read.
    pub warnings: Vec<String>,
}

/// What an object is.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectKind {
    /// A boundary representation.
    Brep(Brep),
    /// A surface that is no part of a BREP, as a BREP of one face without loops (its whole domain).
    Surface(Brep),
    /// A curve that is no part of a BREP.
    Curve(Curve3),
    /// An extrusion. Not read yet.
    Extrusion,
    /// A mesh. Not read.
    Mesh,
    /// Something else (a point, a text, a block reference, ...), by name.
    Other(String),
    /// A BREP, curve or surface that could not be read.
    Refused {
        /// Its class, `"object"` if even that could not be read.
        class: String,
        /// Why, where, and what to do.
        reason: ReadError,
    },
}

impl ObjectKind {
    /// What it is in reports: `brep`, `surface`, `curve`, `extrusion`, `mesh`, `refused` or the name of
    /// something else.
    pub fn name(&self) -> &str {
        match self {
            Self::Brep(_) => "brep",
            Self::Surface(_) => "surface",
            Self::Curve(_) => "curve",
            Self::Extrusion => "extrusion",
            Self::Mesh => "mesh",
            Self::Other(name) => name,
            Self::Refused { .. } => "refused",
        }
    }
}
