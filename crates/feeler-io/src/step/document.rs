//! The whole file.

use super::body::{Made3, brep, faces};
use super::entities::{Entities, problem, shape};
use super::geometry::{Geometry, Left};
use super::part21::{Attribute, parse};
use super::products::Products;
use super::sites::{Placed, What, within_itself};
use crate::affine::{Affine, composed, rounded_up};
use crate::blocks::{Block, Fault, Member, MemberOf, PLACED, faults};
use crate::document::{Document, Format, Object, ObjectKind};
use crate::error::ReadError;
use crate::occt::curves::Budget;
use crate::step_problem::StepProblem;
use crate::units::Units;
use feeler::brep::Brep;
use std::collections::HashMap;

/// Numbers that may be made of a file of no bytes, and for each byte, as of a .brep file.
const NUMBERS: usize = 1 << 17;
const NUMBERS_PER_BYTE: usize = 8;

/// How much proof of images there may be: see [`Geometry::proofs`]. Beyond, the model's report says for how many there is none yet.
const PROOFS: usize = 2048;
/// See [`Geometry::proof_bytes`]: for each byte of the file, less what its entities and bodies take, so that all takes no more than 64 times its size.
const PROOF_BYTES_PER_BYTE: usize = 52;
/// And of the quick proofs: see [`Left::pieces`].
const PIECES: usize = 1 << 16;
/// See [`Left::held`]: no file of the corpus or among OCCT's and FreeCAD's samples holds more than 1.3.
const HELD_PER_BYTE: usize = 3;
/// See [`Left::samples`]: one takes 40 bytes or 56.
const BYTES_PER_SAMPLE: usize = 16;

/// A file's tolerance counts no further than to this part of the model's size.
const MOST_TOLERANCE: f64 = 1.0 / (1 << 14) as f64;

/// So many of the faces that a body lacks are named.
const NAMED: usize = 16;

/// Reads a STEP file (ISO 10303-21; AP203, AP214, AP242) from memory.
///
/// Each solid and each surface model becomes an object where the assemblies place it; what is placed more than once is an object once, as a member of
/// [blocks](Document::blocks), and assemblies that hold such are references to these. A bad one becomes [`ObjectKind::Refused`], which names the
/// entity and the remedy. Where some of its faces are good the object holds these, and is open where others are missing; each of those follows as
/// [`ObjectKind::Refused`]. Meshes, curves, annotations and colours are not read.
///
/// **Numbers.** Points, radii and control points are the file's; weights, directions that are no unit vectors, ends of lines,
/// half angles of cones in degrees and what is placed are rounded to a few units in the last place of the model's size. Curves in uv are made
/// from the edges' curves in space, or taken from the file on B-spline surfaces where they fit; each object's warnings have the proven bound on
/// how far their images are from the edges, or, of files with very many fitted curves, for how many that is left to the health report. Lengths stay in the file's unit.
///
/// # Errors
/// [`ReadError`]: no STEP file, or one whose structure does not hold.
///
/// # Cost
/// O(size) and the projection of edges: some milliseconds for one that must be fitted, with its proof.
pub fn read_step(bytes: &[u8]) -> Result<Document, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    let graph = parse(bytes)?;
    let is = |name: &str| graph.schema.starts_with(name);
    let version = if is("CONFIG_CONTROL_DESIGN") || is("AP203") {
        203
    } else if is("AUTOMOTIVE_DESIGN") || is("AP214") {
        214
    } else if is("AP242") {
        242
    } else {
        0
    };
    let mut warnings = Vec::new();
    if version == 0 {
        warnings.push("the schema is none of AP203, AP214 and AP242: read as these".to_string());
    }
    if graph.blank > 0 {
        warnings.push(format!(
            "{} attributes are blank, which the standard does not allow: taken for `$`",
            graph.blank
        ));
    }
    let entities = Entities::new(graph);
    let geometry = Geometry {
        entities: &entities,
        angle: 1.0,
        proofs: PROOFS,
        proof_bytes: bytes
            .len()
            .saturating_mul(PROOF_BYTES_PER_BYTE)
            .saturating_sub(entities.graph().bytes()),
        kept_bytes: 0,
        left: Left {
            pieces: PIECES,
            held: Budget::new(HELD_PER_BYTE.saturating_mul(bytes.len())),
            samples: bytes.len() / BYTES_PER_SAMPLE,
        },
        numbers: Budget::new(NUMBERS.saturating_add(NUMBERS_PER_BYTE.saturating_mul(bytes.len()))),
    };
    let products = Products::read(&geometry)?;
    let sites = products.sites(&entities)?;
    // Lengths are in the unit of the first body; others are brought to it.
    let first = sites.first();
    let context = first.and_then(|p| products.context(&entities, p.representation));
    let units = context.as_ref().map_or(Units::None, |c| c.units.clone());
    if units == Units::None && first.is_some() {
        warnings.push("no unit of length is given".to_string());
    }
    for (what, count) in &products.others {
        warnings.push(format!("{count} items of kind {what} are not read"));
    }
    let size = extent(&entities, sites.bodies());
    let mut bodies = Bodies {
        products: &products,
        geometry,
        units: &units,
        size,
        members: HashMap::new(),
        objects: Vec::new(),
    };
    let mut references = HashMap::new();
    for p in sites.top {
        // Placements end in the units of the assembly that is in no other.
        let top = products.context(&entities, p.top);
        let scale = top.and_then(|c| {
            let differ = c.units != units;
            differ.then(|| c.units.ratio(&units)).flatten()
        });
        let map = composed(scale.map(Affine::scaling).as_ref(), p.map.as_ref());
        match p.what {
            What::Body(id) => bodies.object(id, &p, map.as_ref(), false),
            What::Assembly(block) => {
                references.insert(bodies.objects.len(), p.representation);
                let kind = ObjectKind::Block {
                    block,
                    map: map.map(Box::new),
                };
                bodies.objects.push(Object {
                    name: p.name,
                    ..Object::new(entities.offset(p.representation), kind)
                });
            }
        }
    }
    let mut blocks = Vec::new();
    for assembly in sites.assemblies {
        let members = assembly.members.into_iter().map(|p| {
            let of = match p.what {
                What::Body(id) => MemberOf::Object(bodies.member(id, &p)),
                What::Assembly(k) => MemberOf::Block(k),
            };
            Member::new(of, p.map.map(Box::new))
        });
        blocks.push(Block {
            name: assembly.name,
            members: members.collect(),
            warnings: Vec::new(),
        });
    }
    let objects = bodies.objects;
    let mut document = Document {
        format: Format::Step,
        version,
        opennurbs_version: 0,
        tolerance: context.and_then(|c| c.tolerance),
        units,
        objects,
        blocks,
        warnings,
    };
    for (index, fault) in faults(&mut document, bytes.len()) {
        let (Some(object), Some(&id)) = (document.objects.get_mut(index), references.get(&index))
        else {
            continue;
        };
        object.kind = ObjectKind::Refused {
            class: "assembly".into(),
            reason: match fault {
                Fault::Itself => within_itself(id),
                Fault::TooMuch => problem(
                    id,
                    StepProblem::Limit {
                        what: "placed parts, or numbers in them",
                        limit: PLACED,
                    },
                ),
            },
        };
    }
    Ok(document)
}

/// The objects made so far.
struct Bodies<'a> {
    products: &'a Products,
    geometry: Geometry<'a>,
    /// Those of the document.
    units: &'a Units,
    /// Of the whole file.
    size: f64,
    /// The object of each body that assemblies place.
    members: HashMap<u64, usize>,
    objects: Vec<Object>,
}

impl Bodies<'_> {
    /// The object of a body that assemblies place, made when it is met first.
    fn member(&mut self, id: u64, p: &Placed) -> usize {
        if let Some(index) = self.members.get(&id) {
            return *index;
        }
        let index = self.objects.len();
        self.members.insert(id, index);
        self.object(id, p, None, true);
        let own = { self.products }.context(self.geometry.entities, p.representation);
        if let (Some(own), Some(object)) = (own, self.objects.get_mut(index))
            && own.units != *self.units
        {
            object.warnings.push(format!(
                "as a member of an assembly it is in {}, which is not the unit of the document: where it is placed its lengths are",
                own.units
            ));
        }
        index
    }

    /// Makes the object of a body, and those of the faces that it lacks.
    fn object(&mut self, id: u64, p: &Placed, map: Option<&Affine>, block_member: bool) {
        let entities = self.geometry.entities;
        let class = entities.described(id).to_lowercase();
        let mut warnings = Vec::new();
        let mut left_out = Vec::new();
        let result = self
            .made(id, p)
            .and_then(|body| placed(id, body, map, &mut warnings, &mut left_out));
        let kind = match result {
            Ok(brep) => ObjectKind::Brep(brep),
            Err(reason) => ObjectKind::Refused {
                class: class.clone(),
                reason,
            },
        };
        let more = left_out.len().saturating_sub(NAMED);
        if more > 0 {
            warnings.push(format!(
                "{more} of the faces that are left out are not named"
            ));
        }
        self.objects.push(Object {
            name: p.name.clone(),
            block_member,
            warnings,
            ..Object::new(entities.offset(id), kind)
        });
        for (face, reason) in left_out.into_iter().take(NAMED) {
            let class = format!("face #{face} of {class}");
            let kind = ObjectKind::Refused { class, reason };
            // No member of a block: it is placed nowhere, and whoever takes the model must hear of it.
            self.objects.push(Object {
                name: p.name.clone(),
                ..Object::new(entities.offset(face), kind)
            });
        }
    }

    /// A body where it stands by itself.
    fn made(&mut self, id: u64, p: &Placed) -> Result<Made3, ReadError> {
        let context = { self.products }.context(self.geometry.entities, p.representation);
        self.geometry.angle = context.as_ref().map_or(1.0, |c| c.angle);
        let given = context.and_then(|c| c.tolerance).unwrap_or(0.0);
        let tolerance = given.min(MOST_TOLERANCE * self.size);
        let list = faces(&mut self.geometry, id)?;
        brep(id, &mut self.geometry, &list, self.size, tolerance)
    }
}

/// A body under a map, what is to be said of it, and the faces that it lacks.
fn placed(
    id: u64,
    body: Made3,
    map: Option<&Affine>,
    warnings: &mut Vec<String>,
    left_out: &mut Vec<(u64, ReadError)>,
) -> Result<Brep, ReadError> {
    *left_out = body.left_out;
    let brep = match map {
        None => {
            warnings.extend(body.images.said(1.0, 0.0));
            body.brep
        }
        Some(map) => {
            let moved = map.apply(&body.brep);
            let moved = moved.map_err(|e| shape(id, e.to_string()))?;
            warnings.extend(body.images.said(map.stretch(), moved.off));
            warnings.push(format!(
                "placed by the assembly: points are off by at most {}",
                rounded_up(moved.off)
            ));
            moved.brep
        }
    };
    warnings.extend(body.warnings);
    Ok(brep)
}

/// The largest coordinate of the points that bodies are made of.
fn extent(entities: &Entities, bodies: impl Iterator<Item = u64>) -> f64 {
    let mut size: f64 = 0.0;
    let mut open: Vec<u64> = bodies.collect();
    let graph = entities.graph();
    let mut seen = vec![false; graph.entities.len()];
    while let Some(id) = open.pop() {
        let place = graph.place(id);
        let Some((place, (_, raw))) = place.and_then(|p| Some((p, graph.entities.get(p)?))) else {
            continue;
        };
        if seen
            .get_mut(place)
            .is_none_or(|s| std::mem::replace(s, true))
        {
            continue;
        }
        if let Some(e) = entities.part(id, "CARTESIAN_POINT") {
            if let Ok(xs) = e.numbers(1)
                && xs.len() == 3
            {
                size = xs.iter().fold(size, |s, x| s.max(x.abs()));
            }
            continue;
        }
        let mut attributes: Vec<&Attribute> =
            raw.parts.iter().flat_map(|p| &p.attributes).collect();
        while let Some(a) = attributes.pop() {
            match a {
                Attribute::EntityRef(id) => open.push(*id),
                Attribute::List(list) => attributes.extend(list),
                _ => {}
            }
        }
    }
    if size > 0.0 { size } else { 1.0 }
}
