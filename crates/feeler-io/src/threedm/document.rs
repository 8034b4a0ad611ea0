//! The whole file.

use super::archive::{Archive, Chunk};
use super::attributes::{Attributes, Layer, attributes, layer, units};
use super::blocks::{self, Blocks, DEFINITION_RECORD};
use super::brep::brep;
use super::class::{self, Class};
use super::curves::curve_of;
use super::extrusion::extrusion;
use super::on_surface;
use super::surfaces::surface_of;
use super::version1;
use crate::document::{Document, Format, Object, ObjectKind};
use crate::error::{ChunkId, Problem, ReadError};
use crate::units::Units;
use feeler::brep::{Brep, BrepParts, Face};
use std::collections::HashMap;
use std::ops::RangeInclusive;

/// What a file starts with; 8 more bytes hold the version.
pub(crate) const MAGIC: &[u8] = b"3D Geometry File Format ";
const VERSION_DIGITS: usize = 8;

const COMMENT: u32 = 0x0000_0001;
const END_OF_FILE: u32 = 0x0000_7FFF;
const END_OF_TABLE: u32 = 0xFFFF_FFFF;
const LAYER_TABLE: u32 = 0x1000_0011;
const OBJECT_TABLE: u32 = 0x1000_0013;
const BLOCK_TABLE: u32 = 0x1000_0021;
/// Tables of things that are not used: bitmaps, materials, groups, fonts, ...
const OTHER_TABLES: RangeInclusive<u32> = 0x1000_0010..=0x1000_0028;
const PROPERTIES_TABLE: u32 = 0x1000_0014;
const SETTINGS_TABLE: u32 = 0x1000_0015;
const OPENNURBS_VERSION: u32 = 0xA000_0026;
const UNITS: u32 = 0x2000_8031;
const LAYER_RECORD: u32 = 0x2000_8050;
const OBJECT_RECORD: u32 = 0x2000_8070;
const OBJECT_TYPE: u32 = 0x8200_0071;
const OBJECT: u32 = 0x0002_7FFA;
const ATTRIBUTES: u32 = 0x0200_8072;
const END_OF_OBJECT: u32 = 0x8200_007F;

/// Reads a .3dm file of version 1 to 8 from memory.
///
/// A bad object does not lose the others: it becomes [`ObjectKind::Refused`] with the reason.
/// Extrusions become BREPs, and block definitions [blocks](Document::blocks). A file of version 2 is read with a
/// warning. Of BREPs in files of versions 1 and 2, which hold neither vertices nor what a trim is, these are rebuilt; of version 1,
/// coordinates with weights are stored apart and multiplied at import, which rounds them.
///
/// # Errors
/// [`ReadError`], which names the chunk, its byte offset and the remedy: no .3dm file, a version that is
/// not read, or a chunk structure that does not hold together outside the objects.
///
/// # Cost
/// O(size) time; memory within a small multiple of the size.
pub fn read_3dm(bytes: &[u8]) -> Result<Document, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    // Other programs' bytes may stand before the header.
    let start = bytes
        .windows(MAGIC.len())
        .position(|w| w == MAGIC)
        .ok_or(ReadError::NotA3dm { size: bytes.len() })?;
    let digits = start + MAGIC.len();
    let mut archive = Archive {
        bytes,
        version: version(bytes.get(digits..digits + VERSION_DIGITS).unwrap_or(&[]))?,
        opennurbs: 0,
    };
    let body = digits + VERSION_DIGITS;
    if archive.version == 1 {
        if !version1::has_tables(Chunk::file(archive, body)) {
            return version1::read(Chunk::file(archive, body));
        }
        archive.version = 2;
    }
    let mut reader = DocumentReader::new(archive.version, start);
    reader.file(Chunk::file(archive, body))?;
    let DocumentReader {
        mut document,
        blocks,
        ..
    } = reader;
    blocks.place(&mut document, bytes.len());
    Ok(document)
}

fn version(digits: &[u8]) -> Result<u32, ReadError> {
    let text = String::from_utf8_lossy(digits);
    match text.trim().parse() {
        Ok(version @ (1..=5 | 50 | 60 | 70 | 80)) => Ok(version),
        _ => Err(ReadError::Version {
            found: text.trim().escape_default().to_string(),
        }),
    }
}

struct DocumentReader {
    /// Where the header starts.
    start: usize,
    document: Document,
    /// Whether the object table was seen.
    has_objects: bool,
    layers: HashMap<i32, Layer>,
    blocks: Blocks,
}

impl DocumentReader {
    fn new(version: u32, start: usize) -> Self {
        let mut warnings = Vec::new();
        if version == 2 {
            warnings.push(
                "a file of version 2: programs that write it may turn surfaces of revolution into \
                 NURBS and leave their trims as they were, so that edges come apart; save the original as \
                 version 3 or later"
                    .into(),
            );
        }
        Self {
            start,
            document: Document {
                format: Format::Rhino,
                version,
                opennurbs_version: 0,
                units: Units::None,
                tolerance: None,
                objects: Vec::new(),
                blocks: Vec::new(),
                warnings,
            },
            has_objects: false,
            layers: HashMap::new(),
            blocks: Blocks::default(),
        }
    }

    fn file(&mut self, mut file: Chunk<'_>) -> Result<(), ReadError> {
        loop {
            let mut table = file.child()?;
            match table.id.typecode {
                END_OF_FILE => {
                    self.end(&mut table, file.position())?;
                    return Ok(());
                }
                PROPERTIES_TABLE => {
                    each(&mut table, |record| {
                        if record.id.typecode == OPENNURBS_VERSION {
                            // A date or a packed number; either way an unsigned one of 32 bits.
                            self.document.opennurbs_version = record.value as u32;
                        }
                        Ok(())
                    })?;
                    file.archive.opennurbs = self.document.opennurbs_version;
                }
                SETTINGS_TABLE => each(&mut table, |record| {
                    if record.id.typecode == UNITS {
                        (self.document.units, self.document.tolerance) = units(record)?;
                    }
                    Ok(())
                })?,
                LAYER_TABLE => each(&mut table, |record| {
                    if record.id.typecode == LAYER_RECORD {
                        self.layer(record);
                    } else {
                        self.skipped(record.id);
                    }
                    Ok(())
                })?,
                OBJECT_TABLE => {
                    self.has_objects = true;
                    each(&mut table, |record| {
                        if record.id.typecode == OBJECT_RECORD {
                            let object = self.object(record);
                            self.document.objects.push(object);
                        } else {
                            self.skipped(record.id);
                        }
                        Ok(())
                    })?;
                }
                BLOCK_TABLE => each(&mut table, |record| {
                    if record.id.typecode != DEFINITION_RECORD {
                        self.skipped(record.id);
                    } else if let Err(reason) = self.blocks.define(record) {
                        let warning = format!("a block could not be read: {reason}");
                        self.document.warnings.push(warning);
                    }
                    Ok(())
                })?,
                COMMENT => {}
                code if OTHER_TABLES.contains(&code) => {}
                _ => self.skipped(table.id),
            }
        }
    }

    /// The last chunk, which ends at byte `end`, holds the file's size: what is amiss by then.
    fn end(&mut self, chunk: &mut Chunk<'_>, end: usize) -> Result<(), ReadError> {
        if !self.has_objects {
            let warning = "the file has no object table: it is damaged, or holds no model";
            self.document.warnings.push(warning.into());
        }
        let stored = chunk.length()?;
        let size = end - self.start;
        if stored != size as u64 {
            self.document.warnings.push(format!(
                "the file says it has {stored} bytes and ends after {size}: part of it may be lost"
            ));
        }
        Ok(())
    }

    /// What is not known is skipped, as the format intends; but it may be damage.
    fn skipped(&mut self, id: ChunkId) {
        self.document
            .warnings
            .push(format!("skipped an unknown {id}"));
    }

    /// A layer that cannot be read costs its objects the layer's name, no more.
    fn layer(&mut self, mut record: Chunk<'_>) {
        match layer(&mut record) {
            Ok((index, layer)) => {
                self.layers.insert(index, layer);
            }
            Err(reason) => self
                .document
                .warnings
                .push(format!("a layer could not be read: {reason}")),
        }
    }

    fn object(&mut self, mut record: Chunk<'_>) -> Object {
        let offset = record.id.offset;
        let mut object = Object::new(offset, ObjectKind::Other("object".into()));
        let result = self.record(&mut record, &mut object);
        if let Err(reason) = result.and_then(|()| record.finish()) {
            self.blocks.forget(self.document.objects.len());
            object.kind = ObjectKind::Refused {
                class: "object".into(),
                reason,
            };
        }
        object
    }

    fn record(&mut self, record: &mut Chunk<'_>, object: &mut Object) -> Result<(), ReadError> {
        let index = self.document.objects.len();
        let mut type_bits = 0;
        let mut found = false;
        while record.left() > 0 {
            let child = record.child()?;
            match child.id.typecode {
                OBJECT_TYPE => type_bits = child.value,
                OBJECT => {
                    found = true;
                    let (class, data) = class::object_in(child)?;
                    let read = if class == Class::InstanceRef {
                        blocks::reference(data).map(|reference| {
                            self.blocks.refer(index, reference);
                            // What it places is known when the file is read.
                            ObjectKind::Other("block reference".into())
                        })
                    } else {
                        kind(class, data, type_bits, &mut object.warnings)
                    };
                    object.kind = match read {
                        Ok(kind) => kind,
                        Err(reason) => ObjectKind::Refused {
                            class: class.name(),
                            reason,
                        },
                    };
                }
                ATTRIBUTES => match attributes(child) {
                    Ok(Attributes {
                        name,
                        layer,
                        block_member,
                        hidden,
                        locked,
                        id,
                    }) => {
                        let layer = layer.and_then(|i| self.layers.get(&i));
                        object.name = name;
                        object.layer = layer.map(|l| l.name.clone());
                        object.block_member = block_member;
                        object.hidden = hidden || layer.is_some_and(|l| l.hidden);
                        object.locked = locked || layer.is_some_and(|l| l.locked);
                        self.blocks.note(id, index);
                    }
                    Err(reason) => object
                        .warnings
                        .push(format!("name and layer could not be read: {reason}")),
                },
                END_OF_OBJECT => break,
                _ => {}
            }
        }
        if found {
            Ok(())
        } else {
            Err(record.fail(Problem::Value {
                what: "the object of the record".into(),
                found: "missing".into(),
                expected: "one".into(),
            }))
        }
    }
}

/// Calls `read` for each record of a table, up to its end.
fn each<'a>(
    table: &mut Chunk<'a>,
    mut read: impl FnMut(Chunk<'a>) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    while table.left() > 0 {
        let record = table.child()?;
        if record.id.typecode == END_OF_TABLE {
            break;
        }
        read(record)?;
    }
    Ok(())
}

fn kind(
    class: Class,
    data: Chunk<'_>,
    type_bits: i64,
    warnings: &mut Vec<String>,
) -> Result<ObjectKind, ReadError> {
    Ok(match class {
        Class::Brep => {
            let (brep, found) = brep(data)?;
            warnings.extend(found);
            ObjectKind::Brep(brep)
        }
        Class::PlaneSurface | Class::RevSurface | Class::SumSurface | Class::NurbsSurface => {
            let at = data.id;
            let surface = surface_of(class, data)?;
            let parts = BrepParts {
                surfaces: vec![surface],
                faces: vec![Face {
                    surface: 0,
                    loops: None,
                    reversed: false,
                }],
                ..BrepParts::default()
            };
            let brep = Brep::new(parts).map_err(|problem| ReadError::Chunk {
                chunk: at,
                at: at.offset,
                problem: Box::new(problem.into()),
            })?;
            ObjectKind::Surface(brep)
        }
        Class::LineCurve
        | Class::ArcCurve
        | Class::PolylineCurve
        | Class::NurbsCurve
        | Class::PolyCurve => ObjectKind::Curve(curve_of(class, data, "a curve")?),
        Class::CurveOnSurface => {
            let image = on_surface::read(data, "a curve")?;
            warnings.push(
                "a curve on a surface (CurveOnSurface), taken as the curve in space that it is, rounded"
                    .into(),
            );
            ObjectKind::Curve(image)
        }
        Class::Extrusion => {
            let (brep, found) = extrusion(data)?;
            warnings.extend(found);
            ObjectKind::Extrusion(brep)
        }
        Class::Mesh => ObjectKind::Mesh,
        Class::InstanceRef | Class::Other(_) => ObjectKind::Other(other(class, type_bits)),
    })
}

/// What an object of no class of interest is, by the type bits beside it.
fn other(class: Class, type_bits: i64) -> String {
    match type_bits {
        0x1 => "point",
        0x2 => "point cloud",
        0x100 => "light",
        0x200 => "annotation",
        0x1000 => "block reference",
        0x2000 => "text dot",
        0x10000 => "hatch",
        0x40000 => "subdivision surface",
        _ => return class.name(),
    }
    .into()
}
