//! Blocks: definitions, references to them, and what these place.
//!
//! A definition names the objects it consists of by their ids; they stand in the object table, marked as its members. A
//! reference has the definition's id and a matrix; definitions may hold references. Each reference is unfolded to what it places.
//!
//! A definition may be linked to another file. That file is never opened: where a copy of its objects is embedded, that is placed, and
//! said; else the reference is refused with the path.

use super::archive::{ANONYMOUS, Chunk};
use super::class;
use super::curves::REMEDY;
use crate::affine::Affine;
use crate::document::{Document, Object, ObjectKind};
use crate::error::{Problem, ReadError};
use feeler::brep::Brep;
use feeler::nurbs::{Curve, NurbsCurve, Surface};
use std::collections::HashMap;

/// The record of a definition in the table of definitions.
pub(super) const DEFINITION_RECORD: u32 = 0x2000_8076;
/// The attributes that newer files keep in one chunk: id, name, ...
const COMPONENT: u32 = 0x4000_8002;

/// How deep blocks may be in each other; a block that holds itself is found by this.
const MAX_NESTED: usize = 32;
/// Objects that a file's references may place in all, ...
const PLACED: usize = 10_000;
/// ... and the numbers in them, for a file of no bytes and for each byte.
const NUMBERS: usize = 1 << 22;
const NUMBERS_PER_BYTE: usize = 4;

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
    definitions: HashMap<Id, Definition>,
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

/// How many numbers a spline holds.
pub(crate) fn numbers_of_spline<const H: usize>(n: &NurbsCurve<H>) -> usize {
    H * n.control_points().len() + n.knots().knots().len()
}

fn numbers_of_curve<const D: usize, const H: usize>(c: &Curve<D, H>) -> usize {
    match c {
        Curve::Nurbs(n) => numbers_of_spline(n),
        Curve::Polyline(p) => (D + 1) * p.points().len(),
        // Segments are never poly-curves themselves.
        Curve::Poly(p) => p.segments().iter().map(numbers_of_curve).sum(),
        Curve::Line(_) | Curve::Arc(_) => 20,
    }
}

/// How many numbers a surface holds.
pub(crate) fn numbers_of_surface(s: &Surface) -> usize {
    match s {
        Surface::Nurbs(n) => {
            4 * n.control_net().len() + n.knots_u().knots().len() + n.knots_v().knots().len()
        }
        Surface::Revolution(r) => 20 + numbers_of_curve(&r.profile),
        Surface::Sum(s) => 3 + numbers_of_curve(&s.first) + numbers_of_curve(&s.second),
        Surface::Plane(_) => 20,
    }
}

/// How many numbers a BREP holds, roughly: what a copy of it costs.
pub(crate) fn numbers(brep: &Brep) -> usize {
    let p = brep.parts();
    let surfaces = p.surfaces.iter().map(numbers_of_surface);
    let curves: usize = p.curves2.iter().map(numbers_of_curve).sum();
    let curves3: usize = p.curves3.iter().map(numbers_of_curve).sum();
    let items = p.vertices.len() + p.edges.len() + p.trims.len() + p.loops.len() + p.faces.len();
    surfaces.sum::<usize>() + curves + curves3 + 20 * items
}

/// What is left of what references may unfold to.
struct Budget {
    objects: usize,
    numbers: usize,
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
        self.definitions.insert(id, definition);
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

    /// Gives each reference that stands in the model itself what it places.
    pub(super) fn unfold(&self, document: &mut Document, size: usize) {
        let mut budget = Budget {
            objects: PLACED,
            numbers: NUMBERS.saturating_add(NUMBERS_PER_BYTE.saturating_mul(size)),
        };
        let mut indices: Vec<usize> = self.references.keys().copied().collect();
        indices.sort_unstable();
        for index in indices {
            let Some(object) = document.objects.get(index) else {
                continue;
            };
            // A member is placed with its block.
            if object.block_member {
                continue;
            }
            let mut placed = Placed::default();
            let result = self.placed(document, index, &mut budget, &mut placed);
            let offset = object.offset;
            let name = self.name_of(index);
            let Some(object) = document.objects.get_mut(index) else {
                continue;
            };
            object.warnings.extend(placed.warnings);
            object.kind = match result {
                Ok(()) => ObjectKind::Block {
                    name,
                    parts: placed.parts,
                },
                Err(problem) => refused("InstanceRef", offset, problem),
            };
        }
    }

    fn name_of(&self, reference: usize) -> String {
        let block = self.references.get(&reference).map(|r| r.block);
        let definition = block.and_then(|b| self.definitions.get(&b));
        definition.map(|d| d.name.clone()).unwrap_or_default()
    }

    /// What the reference at `index` places. The stack of open references is a list, not the machine's. What is amiss with a
    /// reference in a block is refused by itself, and the rest placed.
    fn placed(
        &self,
        document: &Document,
        index: usize,
        budget: &mut Budget,
        placed: &mut Placed,
    ) -> Result<(), Problem> {
        let mut open: Vec<(usize, Option<Affine>, usize)> = vec![(index, None, 0)];
        while let Some((index, outer, depth)) = open.pop() {
            let Some(reference) = self.references.get(&index) else {
                continue;
            };
            if depth >= MAX_NESTED {
                return Err(Problem::Depth {
                    limit: MAX_NESTED as u32,
                });
            }
            let (definition, own) = match self.usable(reference) {
                Ok(usable) => usable,
                Err(problem) if depth == 0 => return Err(problem),
                Err(problem) => {
                    if let Some(object) = document.objects.get(index) {
                        let kind = refused("InstanceRef", object.offset, problem);
                        placed.parts.push(copied(object, kind, budget)?);
                    }
                    continue;
                }
            };
            if let Some(path) = &definition.link {
                let note = format!(
                    "the block `{}` is linked to `{path}`, which is not opened: placed is the copy embedded in this file",
                    definition.name
                );
                if !placed.warnings.contains(&note) {
                    placed.warnings.push(note);
                }
            }
            let map = match outer {
                None => own,
                Some(outer) => outer.after(&own),
            };
            let mut lost = 0_usize;
            for member in &definition.members {
                budget.take(1, 0)?;
                let Some(at) = self.objects.get(member).copied() else {
                    lost += 1;
                    continue;
                };
                if self.references.contains_key(&at) {
                    open.push((at, Some(map.clone()), depth + 1));
                } else if let Some(object) = document.objects.get(at) {
                    placed.parts.push(moved(object, &map, budget)?);
                }
            }
            if lost > 0 {
                let note = format!(
                    "{lost} of the {} members of the block `{}` are not among the file's objects",
                    definition.members.len(),
                    definition.name
                );
                if !placed.warnings.contains(&note) {
                    placed.warnings.push(note);
                }
            }
        }
        Ok(())
    }

    /// The definition of a reference and its own map.
    fn usable(&self, reference: &Reference) -> Result<(&Definition, Affine), Problem> {
        let definition = self.definitions.get(&reference.block);
        let definition = definition.ok_or_else(|| Problem::Block {
            why: "the block it refers to is not in the file".into(),
        })?;
        let own = Affine::from_rows(&reference.matrix).ok_or_else(|| Problem::Block {
            why: format!("its matrix {:?} is no affine map", reference.matrix),
        })?;
        if !definition.members.is_empty() {
            return Ok((definition, own));
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

/// What a reference places, and what is to be said of it.
#[derive(Default)]
struct Placed {
    parts: Vec<Object>,
    warnings: Vec<String>,
}

fn refused(class: &str, offset: usize, problem: Problem) -> ObjectKind {
    ObjectKind::Refused {
        class: class.into(),
        reason: ReadError::Object {
            at: offset,
            problem: Box::new(problem),
        },
    }
}

impl Budget {
    fn take(&mut self, objects: usize, numbers: usize) -> Result<(), Problem> {
        let left = self.objects.checked_sub(objects);
        match (left, self.numbers.checked_sub(numbers)) {
            (Some(objects), Some(numbers)) => {
                *self = Self { objects, numbers };
                Ok(())
            }
            _ => Err(Problem::Block {
                why: "the file's blocks unfold to too much: explode them".into(),
            }),
        }
    }
}

/// A copy of a member as another kind, paid from the budget.
fn copied(object: &Object, kind: ObjectKind, budget: &mut Budget) -> Result<Object, Problem> {
    // What is copied besides a BREP: names and warnings, 8 bytes of text for a number, and the object itself.
    let texts = object
        .warnings
        .iter()
        .chain([&object.name])
        .chain(&object.layer);
    let texts: usize = texts.map(String::len).sum();
    budget.take(
        0,
        texts / size_of::<f64>() + size_of::<Object>() / size_of::<f64>(),
    )?;
    Ok(Object {
        name: object.name.clone(),
        layer: object.layer.clone(),
        block_member: false,
        hidden: object.hidden,
        locked: object.locked,
        offset: object.offset,
        kind,
        warnings: object.warnings.clone(),
    })
}

/// A member where a reference puts it.
fn moved(object: &Object, map: &Affine, budget: &mut Budget) -> Result<Object, Problem> {
    let (brep, kind): (_, fn(Brep) -> ObjectKind) = match &object.kind {
        ObjectKind::Brep(brep) => (brep, ObjectKind::Brep),
        ObjectKind::Surface(brep) => (brep, ObjectKind::Surface),
        ObjectKind::Extrusion(brep) => (brep, ObjectKind::Extrusion),
        ObjectKind::Refused { class, reason } => {
            let kind = ObjectKind::Refused {
                class: class.clone(),
                reason: reason.clone(),
            };
            return copied(object, kind, budget);
        }
        // Curves are not asked: where they stand is of no use.
        other => return copied(object, ObjectKind::Other(other.name().to_owned()), budget),
    };
    budget.take(0, numbers(brep))?;
    let mut off = 0.0;
    let kind = match map.apply(brep) {
        Ok(moved) => {
            off = moved.off;
            kind(moved.brep)
        }
        Err(problem) => refused(
            &format!("Brep of a block ({})", object.kind.name()),
            object.offset,
            Problem::Block {
                why: problem.to_string(),
            },
        ),
    };
    let mut copy = copied(object, kind, budget)?;
    if off > 0.0 {
        copy.warnings.push(format!(
            "moved to where a block reference puts it: coordinates are rounded, off by no more than {off:.1e}"
        ));
    }
    Ok(copy)
}
