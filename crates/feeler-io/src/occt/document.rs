//! The whole file.

use super::assembly::{Assembly, Body};
use super::error::TextProblem;
use super::shapes::Tables;
use super::sites::What;
use super::tokens::{Tokens, fail};
use crate::blocks::{Block, Member, MemberOf, PLACED, faults};
use crate::document::{Document, Format, Object, ObjectKind};
use crate::error::ReadError;
use crate::units::Units;
use std::collections::HashMap;

/// What the line with the version starts with.
const HEADER: &[u8] = b"CASCADE Topology V";
/// The line of the binary format.
const BINARY: &[u8] = b"Open CASCADE Topology V";
/// How far from the start they may stand: programs write a line or two before.
const HEADER_WITHIN: usize = 512;

fn position(bytes: &[u8], of: &[u8]) -> Option<usize> {
    let start = bytes.get(..bytes.len().min(HEADER_WITHIN))?;
    start.windows(of.len()).position(|w| w == of)
}

/// Whether bytes are OCCT's, as text or not.
pub(crate) fn has_header(bytes: &[u8]) -> bool {
    position(bytes, HEADER).is_some()
}

/// Reads OCCT's text format, versions 1 to 3, from memory.
///
/// Each solid becomes an object, as does each shell that is in none, and the faces that lie loose in a compound. Compounds that hold something more than once
/// become references to [blocks](Document::blocks), and what they hold is there once. A bad one does
/// not lose the others: it becomes [`ObjectKind::Refused`] with the reason. Triangulations are not read. The format
/// has no units: [`Units::None`].
///
/// **Numbers.** Coordinates are the file's; what moves them is the products with weights, the ends of lines (origin and
/// direction in the file), points of cylinders, cones and tori at angle 0, and locations: each is rounded to
/// a few units in the last place of the model's size. Ranges are written with 15 digits by OCCT.
///
/// # Errors
/// [`ReadError`], which names the line and the remedy: no .brep file, a version that is not read, or tables that do
/// not hold together.
///
/// # Cost
/// O(size) time; memory within a small multiple of the size.
pub fn read_brep(bytes: &[u8]) -> Result<Document, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    let mut t = Tokens::new(bytes);
    if position(bytes, BINARY).is_some() {
        return Err(t.fail(TextProblem::Binary));
    }
    if !has_header(bytes) {
        return Err(t.fail(TextProblem::Header));
    }
    let version = loop {
        let Some(line) = t.rest_of_line() else {
            return Err(t.fail(TextProblem::Header));
        };
        if let Some(rest) = line.strip_prefix(HEADER) {
            let end = rest.iter().position(|b| !b.is_ascii_digit());
            let digits = rest.get(..end.unwrap_or(rest.len())).unwrap_or(rest);
            match digits {
                b"1" => break 1,
                b"2" => break 2,
                b"3" => break 3,
                _ => {
                    let found =
                        String::from_utf8_lossy(digits.get(..8).unwrap_or(digits)).into_owned();
                    return Err(t.fail(TextProblem::Version { found }));
                }
            }
        }
    };
    let tables = Tables::read(&mut t, version)?;
    let mut warnings = Vec::new();
    if tables.meshes > 0 {
        warnings.push(format!(
            "{} triangulations and polygons are for display: not read",
            tables.meshes
        ));
    }
    let mut assembly = Assembly::new(tables, t.size());
    let sites = assembly.sites()?;
    // Bodies and references in the order of the file; what blocks place follows.
    let mut bodies: Vec<Option<Body>> = sites.bodies.into_iter().map(Some).collect();
    let mut objects = Vec::new();
    // The shape of each reference.
    let mut references = HashMap::new();
    for site in sites.top {
        references.insert(objects.len(), site.shape);
        let body = match site.what {
            What::Body(i) => bodies.get_mut(i).and_then(Option::take),
            What::Block(_) => None,
        };
        objects.push(match (body, site.what) {
            (Some(body), _) => object(&mut assembly, &body, false),
            (None, What::Block(block)) => Object::new(
                assembly.offset(site.shape),
                match site.map {
                    Ok(map) => ObjectKind::Block {
                        block,
                        map: map.map(Box::new),
                    },
                    Err(reason) => refused("compound", reason),
                },
            ),
            (None, What::Body(_)) => continue,
        });
    }
    let mut members = HashMap::new();
    for (i, body) in bodies.into_iter().enumerate() {
        if let Some(body) = body {
            members.insert(i, objects.len());
            objects.push(object(&mut assembly, &body, true));
        }
    }
    let mut blocks = Vec::new();
    for sites in sites.blocks {
        let mut block = Block {
            name: String::new(),
            members: Vec::with_capacity(sites.len()),
            warnings: Vec::new(),
        };
        for site in sites {
            let (of, map) = match (site.map, site.what) {
                (Err(reason), _) => {
                    let offset = assembly.offset(site.shape);
                    let mut object = Object::new(offset, refused("placed shape", reason));
                    object.block_member = true;
                    objects.push(object);
                    (MemberOf::Object(objects.len() - 1), None)
                }
                (Ok(map), What::Block(inner)) => (MemberOf::Block(inner), map),
                (Ok(map), What::Body(i)) => match members.get(&i) {
                    Some(index) => (MemberOf::Object(*index), map),
                    None => continue,
                },
            };
            let map = map.map(Box::new);
            block.members.push(Member::new(of, map));
        }
        blocks.push(block);
    }
    let mut document = Document {
        format: Format::Occt,
        version,
        opennurbs_version: 0,
        units: Units::None,
        tolerance: None,
        objects,
        blocks,
        warnings,
    };
    // Shapes refer to earlier ones alone: no block holds itself.
    for (index, _) in faults(&mut document, t.size()) {
        if let Some(object) = document.objects.get_mut(index) {
            let problem = TextProblem::Limit {
                what: "placed shapes, or numbers in them",
                limit: PLACED,
            };
            let line = { references.get(&index) }.map_or(0, |shape| assembly.line(*shape));
            object.kind = refused("compound", fail(line, problem));
        }
    }
    Ok(document)
}

fn refused(class: &str, reason: ReadError) -> ObjectKind {
    ObjectKind::Refused {
        class: class.into(),
        reason,
    }
}

/// The object of a body.
fn object(assembly: &mut Assembly, body: &Body, block_member: bool) -> Object {
    let mut warnings = Vec::new();
    let kind = match assembly.brep(body) {
        Ok(Some((brep, odd))) => {
            warnings = odd;
            ObjectKind::Brep(brep)
        }
        Ok(None) => ObjectKind::Other(body.class.into()),
        Err(reason) => refused(&format!("brep of a {}", body.class), reason),
    };
    Object {
        block_member,
        warnings,
        ..Object::new(assembly.offset(body.shape), kind)
    }
}
