//! Blocks: definitions, references to them, and what these place.
//!
//! A definition names the objects it consists of by their ids; they stand in the object table, marked as its members. A
//! reference has the definition's id and a matrix; definitions may hold references.
//!
//! A definition may be linked to another file. That file is never opened: where a copy of its objects is embedded, that is placed, and
//! said; else the reference is refused with the path.

use super::archive::{ANONYMOUS, Chunk};
use super::class;
use super::curves::REMEDY;
use crate::affine::Affine;
use crate::blocks::{Block, Fault, Member, MemberOf, faults};
use crate::document::{Document, ObjectKind};
use crate::error::{Problem, ReadError};
use std::collections::HashMap;

/// The record of a definition in the table of definitions.
pub(super) const DEFINITION_RECORD: u32 = 0x2000_8076;
/// The attributes that newer files keep in one chunk: id, name, ...
const COMPONENT: u32 = 0x4000_8002;

pub(super) type Id = [u8; 16];

/// A block.
pub(super) struct Definition {
    name: String,
    members: Vec<Id>,
    /// The path of the file it is linked to.
    link: Option<String>,
}

/// How a definition comes by its objects: these numbers of its kind mean that it is linked to a file, without a copy or with one.
const LINKED_AND_EMBEDDED: i32 = 2;
const LINKED: i32 = 3;

/// The path of the file that a definition of this kind is linked to: the full one, or the relative one if that is all there is.
fn link(kind: i32, full: String, relative: String) -> Option<String> {
    let path = if full.is_empty() { relative } else { full };
    (matches!(kind, LINKED | LINKED_AND_EMBEDDED) && !path.is_empty()).then_some(path)
}

/// A reference to a block.
pub(super) struct Reference {
    block: Id,
    /// By rows.
    matrix: [f64; 16],
}

/// All blocks of a file, and the references met.
#[derive(Default)]
pub(super) struct Blocks {
    definitions: Vec<Definition>,
    /// Where each definition stands among these.
    indices: HashMap<Id, usize>,
    /// Where each object with an id stands.
    objects: HashMap<Id, usize>,
    references: HashMap<usize, Reference>,
}

fn ids(d: &mut Chunk<'_>) -> Result<Vec<Id>, ReadError> {
    let count = d.count("members of a block", size_of::<Id>())?;
    (0..count).map(|_| d.uuid()).collect()
}

/// A definition, as files up to version 5 have it.
fn fixed(d: &mut Chunk<'_>) -> Result<(Id, Definition), ReadError> {
    class::layout(d, "InstanceDefinition", &[1], REMEDY)?;
    let id = d.uuid()?;
    let members = ids(d)?;
    let name = d.string("a block's name")?;
    for what in ["a block's description", "a block's address", "its label"] {
        d.string(what)?;
    }
    d.f64s::<6>("a block's box")?;
    let kind = d.i32("how a block is updated")?;
    let path = d.string("the path of a linked file")?;
    let link = link(kind, path, String::new());
    Ok((
        id,
        Definition {
            name,
            members,
            link,
        },
    ))
}

/// A definition, as files of version 6 and later have it.
fn newer(parent: &mut Chunk<'_>) -> Result<(Id, Definition), ReadError> {
    let mut d = parent.expect(ANONYMOUS, "a block's definition")?;
    // Layout 1.x.
    d.skip(8, "the layout version")?;
    let mut c = d.expect(COMPONENT, "a block's attributes")?;
    c.skip(8, "the layout version")?;
    let (mut id, mut name) = ([0; 16], String::new());
    // Each item: a byte that is 1 where its value follows.
    for item in 0..5 {
        if c.u8("whether there is an attribute")? != 1 {
            continue;
        }
        match item {
            0 => c.skip(12, "serial numbers")?,
            1 => id = c.uuid()?,
            2 | 3 => c.skip(4, "an attribute")?,
            _ => name = c.string("a block's name")?,
        }
    }
    c.finish()?;
    let kind = d.i32("how a block is updated")?;
    d.expect(ANONYMOUS, "a block's units")?;
    for what in ["a block's description", "a block's address", "its label"] {
        d.string(what)?;
    }
    d.f64s::<6>("a block's box")?;
    let members = match d.u8("whether members are listed")? {
        0 => Vec::new(),
        _ => ids(&mut d)?,
    };
    let mut link = None;
    if d.u8("whether a block is linked")? != 0 {
        let mut linked = d.expect(ANONYMOUS, "a block's link")?;
        linked.skip(8, "the layout version")?;
        let mut file = linked.expect(ANONYMOUS, "a linked file")?;
        file.skip(8, "the layout version")?;
        let full = file.string("the path of a linked file")?;
        link = self::link(kind, full, file.string("the path of a linked file")?);
    }
    d.finish()?;
    Ok((
        id,
        Definition {
            name,
            members,
            link,
        },
    ))
}

/// A reference's data.
pub(super) fn reference(mut d: Chunk<'_>) -> Result<Reference, ReadError> {
    class::layout(&mut d, "InstanceRef", &[1], REMEDY)?;
    let block = d.uuid()?;
    let matrix = d.f64s("the matrix of a block reference")?;
    d.finish()?;
    Ok(Reference { block, matrix })
}

impl Blocks {
    /// Reads a record of the table of definitions.
    pub(super) fn define(&mut self, mut record: Chunk<'_>) -> Result<(), ReadError> {
        let archive = record.archive;
        let (_, mut data) = class::object(&mut record)?;
        // Files of version 6 were written in both ways.
        let is_newer = archive.version >= 60 && data.next_typecode() == Some(ANONYMOUS);
        let (id, definition) = if is_newer {
            newer(&mut data)?
        } else {
            fixed(&mut data)?
        };
        data.finish()?;
        self.indices.insert(id, self.definitions.len());
        self.definitions.push(definition);
        Ok(())
    }

    /// Notes the id of the object that will stand at `index`.
    pub(super) fn note(&mut self, id: Id, index: usize) {
        self.objects.insert(id, index);
    }

    /// Notes that the object that will stand at `index` is a reference.
    pub(super) fn refer(&mut self, index: usize, reference: Reference) {
        self.references.insert(index, reference);
    }

    /// The record of the object that stands at `index` is refused: it is no reference.
    pub(super) fn forget(&mut self, index: usize) {
        self.references.remove(&index);
    }

    /// Gives the document, of so many bytes, its blocks, and each reference its own. What is amiss with a reference in a block is refused by
    /// itself, and the rest placed.
    pub(super) fn place(self, document: &mut Document, bytes: usize) {
        let mut indices: Vec<usize> = self.references.keys().copied().collect();
        indices.sort_unstable();
        let mut uses: HashMap<usize, Member> = HashMap::new();
        for index in indices {
            let (Some(reference), Some(object)) =
                (self.references.get(&index), document.objects.get_mut(index))
            else {
                continue;
            };
            match self.usable(reference) {
                // A member is placed with its block.
                Ok((block, map)) => {
                    let map = Some(Box::new(map));
                    if !object.block_member {
                        let map = map.clone();
                        object.kind = ObjectKind::Block { block, map };
                    }
                    // Definitions may name what is not marked as a member, too.
                    let member = Member {
                        of: MemberOf::Block(block),
                        map,
                        hidden: object.hidden,
                        locked: object.locked,
                    };
                    uses.insert(index, member);
                }
                Err(problem) => object.kind = refused(object.offset, problem),
            }
        }
        let blocks = { &self.definitions }
            .iter()
            .map(|definition| self.block(definition, &uses));
        document.blocks = blocks.collect();
        for (index, fault) in faults(document, bytes) {
            let Some(object) = document.objects.get_mut(index) else {
                continue;
            };
            let why = match fault {
                Fault::Itself => "the block it refers to holds itself: remove it from itself",
                Fault::TooMuch => "the file's blocks unfold to too much: explode them",
            };
            object.kind = refused(object.offset, Problem::Block { why: why.into() });
        }
    }

    fn block(&self, definition: &Definition, uses: &HashMap<usize, Member>) -> Block {
        let mut warnings = Vec::new();
        if let Some(path) = &definition.link {
            warnings.push(format!(
                "the block `{}` is linked to `{path}`, which is not opened: placed is the copy embedded in this file",
                definition.name
            ));
        }
        let known = { definition.members.iter() }.filter_map(|id| self.objects.get(id).copied());
        let mut members: Vec<Member> = known
            .map(|at| match uses.get(&at) {
                Some(reference) => reference.clone(),
                None => Member::new(MemberOf::Object(at), None),
            })
            .collect();
        // Objects first, then what blocks within the block place.
        members.sort_by_key(|m| matches!(m.of, MemberOf::Block(_)));
        let lost = definition.members.len() - members.len();
        if lost > 0 {
            warnings.push(format!(
                "{lost} of the {} members of the block `{}` are not among the file's objects",
                definition.members.len(),
                definition.name
            ));
        }
        Block {
            name: definition.name.clone(),
            members,
            warnings,
        }
    }

    /// The definition of a reference, by its index, and its own map.
    fn usable(&self, reference: &Reference) -> Result<(usize, Affine), Problem> {
        let index = self.indices.get(&reference.block).copied();
        let definition = index.and_then(|i| Some((i, self.definitions.get(i)?)));
        let (index, definition) = definition.ok_or_else(|| Problem::Block {
            why: "the block it refers to is not in the file".into(),
        })?;
        let own = Affine::from_rows(&reference.matrix).ok_or_else(|| Problem::Block {
            why: format!("its matrix {:?} is no affine map", reference.matrix),
        })?;
        if !definition.members.is_empty() {
            return Ok((index, own));
        }
        let name = &definition.name;
        Err(Problem::Block {
            why: match &definition.link {
                Some(path) => format!(
                    "the block `{name}` is linked to `{path}`, which is not loaded; embed it (Rhino: BlockManager, Block Definition \
                     Type: Embedded) and save again, or load that file by itself"
                ),
                None => format!("the block `{name}` holds nothing"),
            },
        })
    }
}

fn refused(offset: usize, problem: Problem) -> ObjectKind {
    ObjectKind::Refused {
        class: "InstanceRef".into(),
        reason: ReadError::Object {
            at: offset,
            problem: Box::new(problem),
        },
    }
}
