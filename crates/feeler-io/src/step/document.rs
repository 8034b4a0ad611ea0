//! The whole file.

use super::body::{Made3, brep, faces, rounded_up};
use super::entities::Entities;
use super::geometry::{Geometry, Left};
use super::part21::{Attribute, parse};
use super::products::{Context, Products};
use crate::affine::Affine;
use crate::document::{Document, Format, Object, ObjectKind};
use crate::error::ReadError;
use crate::occt::curves::Budget;
use crate::threedm::blocks::numbers;
use crate::units::Units;
use std::collections::HashMap;

/// Numbers that may be made of a file of no bytes, and for each byte, as of a .brep file.
const NUMBERS: usize = 1 << 23;
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
/// Each solid and each surface model becomes an object, wherever the assemblies place it; a bad one becomes [`ObjectKind::Refused`], which names the
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
    let mut geometry = Geometry {
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
    let placed = products.placed(&entities)?;
    let contexts: Vec<Option<Context>> = { placed.iter() }
        .map(|p| products.context(&entities, p.representation))
        .collect();
    // Lengths are in the unit of the first body; others are brought to it.
    let first = contexts.iter().flatten().next().cloned();
    let units = first.as_ref().map_or(Units::None, |c| c.units.clone());
    if units == Units::None && !placed.is_empty() {
        warnings.push("no unit of length is given".to_string());
    }
    for (what, count) in &products.others {
        warnings.push(format!("{count} items of kind {what} are not read"));
    }
    let size = extent(&entities, placed.iter().map(|p| p.id));
    // Of each body, how many are still to be placed.
    let mut to_place: HashMap<u64, usize> = HashMap::new();
    for p in &placed {
        *to_place.entry(p.id).or_default() += 1;
    }
    let mut made: HashMap<u64, Result<Made3, ReadError>> = HashMap::new();
    // Faces that bodies lack, of each body once.
    let mut left_out: Vec<Object> = Vec::new();
    let mut objects = Vec::new();
    for (p, context) in placed.into_iter().zip(contexts) {
        // Placements end in the units of the assembly that is in no other.
        let top = products.context(&entities, p.top);
        let scale = top.as_ref().and_then(|c| {
            (c.units != units)
                .then(|| c.units.ratio(&units))
                .flatten()
                .map(Affine::scaling)
        });
        let to_place = to_place.entry(p.id).or_default();
        *to_place = to_place.saturating_sub(1);
        let result = made.remove(&p.id).unwrap_or_else(|| {
            geometry.angle = context.as_ref().map_or(1.0, |c| c.angle);
            let given = context.as_ref().and_then(|c| c.tolerance).unwrap_or(0.0);
            let tolerance = given.min(MOST_TOLERANCE * size);
            let list = faces(&mut geometry, p.id)?;
            let mut made = brep(p.id, &mut geometry, &list, size, tolerance)?;
            let more = made.left_out.len().saturating_sub(NAMED);
            for (face, reason) in std::mem::take(&mut made.left_out).into_iter().take(NAMED) {
                left_out.push(Object {
                    name: p.name.clone(),
                    layer: None,
                    block_member: false,
                    hidden: false,
                    locked: false,
                    offset: entities.offset(face),
                    kind: ObjectKind::Refused {
                        class: format!(
                            "face #{face} of {}",
                            entities.described(p.id).to_lowercase()
                        ),
                        reason,
                    },
                    warnings: Vec::new(),
                });
            }
            if more > 0 {
                made.warnings.push(format!(
                    "{more} of the faces that are left out are not named"
                ));
            }
            Ok(made)
        });
        let class = entities.described(p.id).to_lowercase();
        let mut own = Vec::new();
        let is_last = *to_place == 0;
        let kind = match result {
            Ok(mut body) => {
                // A copy costs what it holds.
                let map = match (&p.map, &scale) {
                    (Some(a), Some(b)) => Some(b.after(a)),
                    (a, b) => a.clone().or_else(|| b.clone()),
                };
                let warnings = if is_last {
                    std::mem::take(&mut body.warnings)
                } else {
                    body.warnings.clone()
                };
                let copied = geometry.numbers.take(numbers(&body.brep));
                let (placed, kept) = match (copied.map_err(super::entities::form(p.id)), map) {
                    (Err(reason), _) => (Err(reason), Some(body)),
                    (Ok(()), None) => {
                        own.extend(body.images.said(1.0, 0.0));
                        if is_last {
                            (Ok(body.brep), None)
                        } else {
                            (Ok(body.brep.clone()), Some(body))
                        }
                    }
                    (Ok(()), Some(map)) => {
                        let moved = map
                            .apply(&body.brep)
                            .map(|moved| {
                                own.extend(body.images.said(map.stretch(), moved.off));
                                own.push(format!(
                                    "placed by the assembly: points are off by at most {}",
                                    rounded_up(moved.off)
                                ));
                                moved.brep
                            })
                            .map_err(|e| super::entities::shape(p.id, e.to_string()));
                        (moved, Some(body))
                    }
                };
                if let Some(body) = kept.filter(|_| !is_last) {
                    made.insert(p.id, Ok(body));
                }
                match placed {
                    Ok(brep) => {
                        own.extend(warnings);
                        ObjectKind::Brep(brep)
                    }
                    Err(reason) => ObjectKind::Refused { class, reason },
                }
            }
            Err(reason) => {
                if !is_last {
                    made.insert(p.id, Err(reason.clone()));
                }
                ObjectKind::Refused { class, reason }
            }
        };
        objects.push(Object {
            name: p.name,
            layer: None,
            block_member: false,
            hidden: false,
            locked: false,
            offset: entities.offset(p.id),
            kind,
            warnings: own,
        });
        objects.append(&mut left_out);
    }
    Ok(Document {
        format: Format::Step,
        version,
        opennurbs_version: 0,
        tolerance: first.and_then(|c| c.tolerance),
        units,
        objects,
        warnings,
    })
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
