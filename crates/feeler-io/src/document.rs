//! What reading gives.

use crate::affine::Affine;
use crate::blocks::{Block, Placement};
use crate::error::ReadError;
use crate::units::Units;
use feeler::brep::Brep;
use feeler::nurbs::Curve3;
use std::borrow::Cow;

/// The format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// openNURBS, `.3dm`.
    Rhino,
    /// OCCT's text format, `.brep`.
    Occt,
    /// ISO 10303-21, `.step`.
    Step,
}

impl Format {
    /// Its name in reports: `3dm`, `brep`, `step`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rhino => "3dm",
            Self::Occt => "brep",
            Self::Step => "step",
        }
    }
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// In which format it was.
    pub format: Format,
    /// The version of the format, as in the file. Of .3dm: 1 to 5, 50, 60, 70 or 80;
    /// of .brep: 1, 2 or 3; of .step: the application protocol, 203, 214 or 242, 0 for another.
    pub version: u32,
    /// Version of the library that wrote a .3dm file, as stored; 0 if not said.
    pub opennurbs_version: u32,
    /// The unit of every length in the file. A .brep says none.
    pub units: Units,
    /// The tolerance the model was made with, in these units; `None` if unset.
    pub tolerance: Option<f64>,
    /// The objects, in file order, including those that could not be read.
    pub objects: Vec<Object>,
    /// The blocks that objects of kind [`ObjectKind::Block`] place.
    pub(crate) blocks: Vec<Block>,
    /// What was odd about the file as a whole.
    pub warnings: Vec<String>,
}

impl Document {
    /// A document of BREPs alone, as if of a .3dm file of version 5: no names, no units.
    pub fn of_breps(breps: Vec<Brep>) -> Self {
        let objects = { breps.into_iter() }.map(|brep| Object::new(0, ObjectKind::Brep(brep)));
        Self {
            format: Format::Rhino,
            version: 50,
            opennurbs_version: 0,
            units: Units::None,
            tolerance: None,
            objects: objects.collect(),
            blocks: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// The blocks that objects of kind [`ObjectKind::Block`] place: those of a .3dm file, a STEP file's assemblies and a .brep file's compounds that hold
    /// or are what is placed more than once.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The block that an object is a reference to.
    pub fn block(&self, object: &Object) -> Option<&Block> {
        match &object.kind {
            ObjectKind::Block { block, .. } => self.blocks.get(*block),
            _ => None,
        }
    }

    /// The BREPs that the model consists of, in file order, with the index of their object: those of BREPs and extrusions, and of what block
    /// references place, moved there one by one; not the members of blocks themselves, and no loose surfaces.
    pub fn bodies(&self) -> impl Iterator<Item = (usize, Cow<'_, Brep>)> {
        self.chosen(Choice::default())
    }

    /// The same of the objects that are chosen.
    pub fn chosen(&self, choice: Choice) -> impl Iterator<Item = (usize, Cow<'_, Brep>)> {
        let objects = self.objects.iter().enumerate();
        let wanted = objects.filter(move |(_, o)| !o.block_member && choice.takes(o));
        wanted.flat_map(move |(i, _)| {
            let placements = self.placements(i);
            let wanted = placements.filter(move |p| choice.takes_placed(p));
            wanted.filter_map(move |p| {
                let brep = match p.placed() {
                    Cow::Borrowed(object) => Cow::Borrowed(object.body()?),
                    Cow::Owned(object) => Cow::Owned(object.into_body()?),
                };
                Some((i, brep))
            })
        })
    }

    /// The objects of kind [`ObjectKind::Brep`] with their index, members of blocks among them, in file order.
    pub fn breps(&self) -> impl Iterator<Item = (usize, &Brep)> {
        let objects = self.objects.iter().enumerate();
        objects.filter_map(|(i, o)| match &o.kind {
            ObjectKind::Brep(brep) => Some((i, brep)),
            _ => None,
        })
    }
}

/// Which objects of a file are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Whether hidden ones are.
    pub hidden: bool,
    /// Whether locked ones are.
    pub locked: bool,
}

impl Default for Choice {
    /// All.
    fn default() -> Self {
        Self {
            hidden: true,
            locked: true,
        }
    }
}

impl Choice {
    /// Whether an object is taken, by itself: of what a block reference places, ask for [each](Self::takes_placed).
    pub fn takes(self, object: &Object) -> bool {
        (self.hidden || !object.hidden) && (self.locked || !object.locked)
    }

    /// Whether what a block reference places is taken, where the reference is.
    pub fn takes_placed(self, placement: &Placement<'_>) -> bool {
        (self.hidden || !placement.hidden) && (self.locked || !placement.locked)
    }
}

/// One object of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its name; empty if it has none.
    pub name: String,
    /// The name of its layer, if it is on one.
    pub layer: Option<String>,
    /// Whether it is part of a block's definition rather than of the model itself: references place it.
    pub block_member: bool,
    /// Whether it, or its layer, is hidden. (The layers that its layer is in are not looked at.)
    pub hidden: bool,
    /// Whether it, or its layer, is locked.
    pub locked: bool,
    /// Byte offset of its record from the start of the file.
    pub offset: usize,
    /// What it is.
    pub kind: ObjectKind,
    /// What was odd about it: spans cut to their curve's domain, faces without loops, names that
    /// could not be read.
    pub warnings: Vec<String>,
}

impl Object {
    /// An object whose record is at `offset`, of which no more is known.
    pub(crate) fn new(offset: usize, kind: ObjectKind) -> Self {
        Self {
            name: String::new(),
            layer: None,
            block_member: false,
            hidden: false,
            locked: false,
            offset,
            kind,
            warnings: Vec::new(),
        }
    }

    /// Its BREP, if it is a body by itself: a BREP or an extrusion.
    pub fn body(&self) -> Option<&Brep> {
        match &self.kind {
            ObjectKind::Brep(brep) | ObjectKind::Extrusion(brep) => Some(brep),
            _ => None,
        }
    }

    /// The same, taken out of it.
    pub fn into_body(self) -> Option<Brep> {
        match self.kind {
            ObjectKind::Brep(brep) | ObjectKind::Extrusion(brep) => Some(brep),
            _ => None,
        }
    }
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
    /// An extrusion, as a BREP.
    Extrusion(Brep),
    /// A reference to a block: [`Document::placements`] tells what it places.
    Block {
        /// Which of [`Document::blocks`].
        block: usize,
        /// Where it places it; `None`: as it stands.
        map: Option<Box<Affine>>,
    },
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
    /// What it is in reports: `brep`, `surface`, `curve`, `extrusion`, `block reference`, `mesh`, `refused` or the name of
    /// something else.
    pub fn name(&self) -> &str {
        match self {
            Self::Brep(_) => "brep",
            Self::Surface(_) => "surface",
            Self::Curve(_) => "curve",
            Self::Extrusion(_) => "extrusion",
            Self::Block { .. } => "block reference",
            Self::Mesh => "mesh",
            Self::Other(name) => name,
            Self::Refused { .. } => "refused",
        }
    }
}
