//! The whole file.

use super::assembly::Assembly;
use super::error::TextProblem;
use super::shapes::Tables;
use super::tokens::Tokens;
use crate::document::{Document, Format, Object, ObjectKind};
use crate::error::ReadError;
use crate::units::Units;

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
/// Each solid becomes an object, as does each shell that is in none, and the faces that lie loose in a compound. A bad one does
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
/// O(size) time; memory within a small multiple of the size, and of what the file unfolds to where it places shapes
/// more than once, which is limited.
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
    let mut document = Document {
        format: Format::Occt,
        version,
        opennurbs_version: 0,
        units: Units::None,
        tolerance: None,
        objects: Vec::new(),
        warnings: Vec::new(),
    };
    if tables.meshes > 0 {
        document.warnings.push(format!(
            "{} triangulations and polygons are for display: not read",
            tables.meshes
        ));
    }
    let mut assembly = Assembly::new(tables, t.size());
    for body in assembly.bodies()? {
        let mut warnings = Vec::new();
        let kind = match assembly.brep(&body) {
            Ok(Some((brep, odd))) => {
                warnings = odd;
                ObjectKind::Brep(brep)
            }
            Ok(None) => ObjectKind::Other(body.class.into()),
            Err(reason) => ObjectKind::Refused {
                class: format!("brep of a {}", body.class),
                reason,
            },
        };
        document.objects.push(Object {
            name: String::new(),
            layer: None,
            block_member: false,
            hidden: false,
            locked: false,
            offset: assembly.offset(body.shape),
            kind,
            warnings,
        });
    }
    Ok(document)
}
