//! Blocks: definitions, references to them, and what these place.
//!
//! A definition names the objects it consists of by their ids; they stand in the object table, marked as its members. A
//! reference has the definition's id and a matrix; definitions may hold references. Each reference is unfolded to what it places.

use super::archive::{ANONYMOUS, Chunk};
use super::class;
use super::curves::REMEDY;
use crate::affine::{Affine, Moved};
use crate::document::{Document, Object, ObjectKind};
use crate::error::{Problem, ReadError};
use feeler::brep::Brep;
use feeler::nurbs::{Curve, Surface};
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
    Ok((id, Definition { name, members }))
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
    d.i32("how a block is updated")?;
    d.expect(ANONYMOUS, "a block's units")?;
    for what in ["a block's description", "a block's address", "its label"] {
        d.string(what)?;
    }
    d.f64s::<6>("a block's box")?;
    let members = match d.u8("whether members are listed")? {
        0 => Vec::new(),
        _ => ids(&mut d)?,
    };
    d.finish()?;
    Ok((id, Definition { name, members }))
}

/// A reference's data.
pub(super) fn reference(mut d: Chunk<'_>) -> Result<Reference, ReadError> {
    class::layout(&mut d, "InstanceRef", &[1], REMEDY)?;
    let block = d.uuid()?;
    let matrix = d.f64s("the matrix of a block reference")?;
    d.finish()?;
    Ok(Reference { block, matrix })
}

/// How many numbers a BREP holds, roughly: what a copy of it costs.
pub(crate) fn numbers(brep: &Brep) -> usize {
    fn curve<const D: usize, const H: usize>(c: &Curve<D, H>) -> usize {
        match c {
            Curve::Nurbs(n) => H * n.control_points().len() + n.knots().knots().len(),
            Curve::Polyline(p) => (D + 1) * p.points().len(),
            // Segments are never poly-curves themselves.
            Curve::Poly(p) => p.segments().iter().map(curve).sum(),
            Curve::Line(_) | Curve::Arc(_) => 20,
        }
    }
    let p = brep.parts();
    let surfaces = p.surfaces.iter().map(|s| match s {
        Surface::Nurbs(n) => {
            4 * n.control_net().len() + n.knots_u().knots().len() + n.knots_v().knots().len()
        }
        Surface::Revolution(r) => 20 + curve(&r.profile),
        Surface::Sum(s) => 3 + curve(&s.first) + curve(&s.second),
        Surface::Plane(_) => 20,
    });
    let curves: usize = p.curves2.iter().map(curve).sum();
    let curves3: usize = p.curves3.iter().map(curve).sum();
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
            let mut parts = Vec::new();
            let result = self.placed(document, index, &mut budget, &mut parts);
            let offset = object.offset;
            let name = self.name_of(index);
            let Some(object) = document.objects.get_mut(index) else {
                continue;
            };
            object.kind = match result {
                Ok(()) => ObjectKind::Block { name, parts },
                Err(problem) => ObjectKind::Refused {
                    class: "InstanceRef".into(),
                    reason: ReadError::Object {
                        at: offset,
                        problem: Box::new(problem),
                    },
                },
            };
        }
    }

    fn name_of(&self, reference: usize) -> String {
        let block = self.references.get(&reference).map(|r| r.block);
        let definition = block.and_then(|b| self.definitions.get(&b));
        definition.map(|d| d.name.clone()).unwrap_or_default()
    }

    /// What the reference at `index` places. The stack of open references is a list, not the machine's.
    fn placed(
        &self,
        document: &Document,
        index: usize,
        budget: &mut Budget,
        parts: &mut Vec<Object>,
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
            let unknown = || Problem::Block {
                why: "the block it refers to is not in the file (it may be linked to another)"
                    .into(),
            };
            let definition = self.definitions.get(&reference.block).ok_or_else(unknown)?;
            let own = Affine::from_rows(&reference.matrix).ok_or_else(|| Problem::Block {
                why: format!("its matrix {:?} is no affine map", reference.matrix),
            })?;
            let map = match outer {
                None => own,
                Some(outer) => outer.after(&own),
            };
            if definition.members.is_empty() {
                return Err(Problem::Block {
                    why: format!(
                        "the block `{}` holds nothing (it may be linked to another file)",
                        definition.name
                    ),
                });
            }
            for member in &definition.members {
                budget.take(1, 0)?;
                let Some(at) = self.objects.get(member).copied() else {
                    continue;
                };
                if self.references.contains_key(&at) {
                    open.push((at, Some(map.clone()), depth + 1));
                } else if let Some(object) = document.objects.get(at) {
                    parts.push(moved(object, &map, budget)?);
                }
            }
        }
        Ok(())
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

/// A member where a reference puts it.
fn moved(object: &Object, map: &Affine, budget: &mut Budget) -> Result<Object, Problem> {
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
    let mut warnings = object.warnings.clone();
    let (brep, kind): (_, fn(Brep) -> ObjectKind) = match &object.kind {
        ObjectKind::Brep(brep) => (Some(brep), ObjectKind::Brep),
        ObjectKind::Surface(brep) => (Some(brep), ObjectKind::Surface),
        ObjectKind::Extrusion(brep) => (Some(brep), ObjectKind::Extrusion),
        _ => (None, ObjectKind::Brep),
    };
    let kind = if let Some(brep) = brep {
        budget.take(0, numbers(brep))?;
        match map.apply(brep) {
            Ok(Moved { brep, off }) => {
                if off > 0.0 {
                    warnings.push(format!(
                        "moved to where a block reference puts it: coordinates are rounded, off by no more than {off:.1e}"
                    ));
                }
                kind(brep)
            }
            Err(problem) => ObjectKind::Refused {
                class: format!("Brep of a block ({})", object.kind.name()),
                reason: ReadError::Object {
                    at: object.offset,
                    problem: Box::new(Problem::Block {
                        why: problem.to_string(),
                    }),
                },
            },
        }
    } else if let ObjectKind::Refused { class, reason } = &object.kind {
        ObjectKind::Refused {
            class: class.clone(),
            reason: reason.clone(),
        }
    } else {
        // Curves are not asked: where they stand is of no use.
        ObjectKind::Other(object.kind.name().to_owned())
    };
    Ok(Object {
        name: object.name.clone(),
        layer: object.layer.clone(),
        block_member: false,
        hidden: object.hidden,
        locked: object.locked,
        offset: object.offset,
        kind,
        warnings,
    })
}
