//! Writing .3dm files, version 5 (archive version 50).
//!
//! | module | writes |
//! |---|---|
//! | `chunks` | chunks, checksums, plain values |
//! | `geometry` | curves and surfaces in their native form |
//! | `brep` | `ON_Brep` 3.2 |
//! | `directed` | trims that run against their curves, along others |
//! | `unwound` | what winds around by more than a turn, as NURBS |
//!
//! What is read back is the same, number by number, but for what the format has no room for: the two outer knots of splines that are not
//! clamped (no point depends on them), an axis of revolution, which it keeps as two points, and revolutions over more than a turn. All are looked for and said. Where import
//! has widened a surface's domain, the flags that call a straight trim a border of it are set to fit.

mod brep;
mod chunks;
mod directed;
mod geometry;
mod unwound;

use super::archive::UNSET;
use crate::document::{Document, Object, ObjectKind};
use crate::error::WriteError;
use crate::units::Units;
use chunks::Writer;
use feeler::brep::Brep;
use geometry::Geometry;
use std::collections::BTreeMap;

/// The library version that files of this kind carry: one that writes attributes as numbered items.
const OPENNURBS: i64 = 201_004_095;
const END_OF_TABLE: u32 = 0xFFFF_FFFF;
/// Bitmaps, texture mappings, materials, line types.
const BEFORE_LAYERS: [u32; 4] = [0x1000_0016, 0x1000_0025, 0x1000_0010, 0x1000_0023];
/// Groups, fonts, dimension styles, lights, hatch patterns, blocks.
const BEFORE_OBJECTS: [u32; 6] = [
    0x1000_0018,
    0x1000_0019,
    0x1000_0020,
    0x1000_0012,
    0x1000_0022,
    0x1000_0021,
];
const HISTORY: u32 = 0x1000_0026;
const VERSION: &[u8] = b"3D Geometry File Format       50";

/// A file, and what of the document did not get into it as it was.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// The file's bytes.
    pub bytes: Vec<u8>,
    /// A line each.
    pub notes: Vec<String>,
    /// How many objects were written.
    pub objects: usize,
    /// How far any point of what block references place may be from where their maps take it, as it was moved there to be written; 0: nothing was rounded.
    pub off: f64,
}

/// What openNURBS calls a kind of object in a record.
const CURVE: i64 = 0x4;
const SURFACE: i64 = 0x8;
const BREP: i64 = 0x10;

struct File {
    /// Layers by their names. That one is hidden or locked is written as a mode of its objects.
    layers: BTreeMap<String, i32>,
    notes: Vec<String>,
    /// Counts by what was left out.
    left_out: BTreeMap<String, usize>,
    written: usize,
}

/// Writes the model that a document holds as a .3dm file of version 5: BREPs, extrusions and what block references place as BREPs, surfaces and
/// curves as they are, with names, layers, and whether they are hidden or locked. Block members are not written (what references make of
/// them is), and what was not read is counted in [`Written::notes`].
///
/// **Numbers** are those of the document: [`read_3dm`](crate::read_3dm) of the result gives the same BREPs bit for bit, unless a note says
/// otherwise.
///
/// # Errors
/// [`WriteError`]: a face without loops in a BREP of several faces, more of something than the format counts, or a curve in uv on a surface that winds which cannot be fitted.
///
/// # Cost
/// O(size).
pub fn write_3dm(document: &Document) -> Result<Written, WriteError> {
    let mut file = File {
        layers: BTreeMap::new(),
        notes: Vec::new(),
        left_out: BTreeMap::new(),
        written: 0,
    };
    let mut records = Writer::new();
    let mut off: f64 = 0.0;
    for (i, object) in document.objects.iter().enumerate() {
        if object.block_member {
            continue;
        }
        for placement in document.placements(i) {
            let (part, moved) = placement.placed_within();
            off = off.max(moved);
            file.object(&mut records, &part, i)?;
        }
    }
    let mut out = Writer::new();
    out.raw(VERSION);
    out.chunk(0x1, |w| w.raw(b"written by feeler\x1A"));
    // Properties: the library's version alone.
    out.chunk(0x1000_0014, |w| {
        w.short(0xA000_0026, OPENNURBS);
        w.short(END_OF_TABLE, 0);
    });
    out.chunk(0x1000_0015, |w| {
        w.chunk(0x2000_8031, |w| {
            units(w, &document.units, document.tolerance)
        });
        w.short(END_OF_TABLE, 0);
    });
    // openNURBS looks for its tables one after the other: those without content are written, too.
    for table in BEFORE_LAYERS {
        empty(&mut out, table);
    }
    out.chunk(0x1000_0011, |w| {
        let mut by_index: Vec<(&str, i32)> =
            file.layers.iter().map(|(n, i)| (n.as_str(), *i)).collect();
        by_index.sort_by_key(|(_, i)| *i);
        for (name, index) in by_index {
            w.chunk(0x2000_8050, |w| layer(w, name, index));
        }
        w.short(END_OF_TABLE, 0);
    });
    for table in BEFORE_OBJECTS {
        empty(&mut out, table);
    }
    out.chunk(0x1000_0013, |w| {
        w.nested(records);
        w.short(END_OF_TABLE, 0);
    });
    empty(&mut out, HISTORY);
    // The last chunk holds the file's size, itself included: two headers' worth more than what stands.
    let size = out.len() + 12 + 8;
    out.chunk(0x7FFF, |w| w.raw(&(size as u64).to_le_bytes()));
    let mut notes = file.notes;
    for (what, count) in file.left_out {
        notes.push(format!("{count} {what} left out"));
    }
    Ok(Written {
        bytes: out.finish(),
        notes,
        objects: file.written,
        off,
    })
}

impl File {
    fn object(
        &mut self,
        records: &mut Writer,
        object: &Object,
        index: usize,
    ) -> Result<(), WriteError> {
        let mut body = Writer::new();
        let mut geometry = Geometry::default();
        let kind = match &object.kind {
            ObjectKind::Brep(brep) | ObjectKind::Extrusion(brep) => {
                self.brep(&mut body, &mut geometry, brep, index)?
            }
            ObjectKind::Surface(brep) => self.brep(&mut body, &mut geometry, brep, index)?,
            ObjectKind::Curve(curve) => {
                geometry.curve(&mut body, curve);
                CURVE
            }
            other => {
                *self.left_out.entry(other.name().to_owned()).or_default() += 1;
                return Ok(());
            }
        };
        for note in geometry.notes() {
            self.notes.push(format!("object {index}: {note}"));
        }
        // Objects lie on some layer: the format has no other way.
        let name = object.layer.as_deref().unwrap_or("Default");
        let next = i32::try_from(self.layers.len()).unwrap_or(i32::MAX);
        let layer = *self.layers.entry(name.to_owned()).or_insert(next);
        let number = self.written as u64 + 1;
        self.written += 1;
        records.chunk(0x2000_8070, |w| {
            w.short(0x8200_0071, kind);
            w.nested(body);
            w.chunk(0x0200_8072, |w| attributes(w, object, layer, number));
            w.short(0x8200_007F, 0);
        });
        Ok(())
    }

    /// A BREP, or its surface, where it is one whole face.
    fn brep(
        &mut self,
        body: &mut Writer,
        geometry: &mut Geometry,
        brep: &Brep,
        index: usize,
    ) -> Result<i64, WriteError> {
        let unsupported = |what| WriteError::Unsupported {
            object: index,
            what,
        };
        let unwound = unwound::unwound(brep).map_err(unsupported)?;
        let brep = match &unwound {
            Some((made, said)) => {
                self.notes.push(format!("object {index}: {said}"));
                made
            }
            None => brep,
        };
        let parts = brep.parts();
        if let ([face], [surface]) = (parts.faces.as_slice(), parts.surfaces.as_slice())
            && face.loops.is_none()
            && !face.reversed
        {
            geometry.surface(body, surface);
            return Ok(SURFACE);
        }
        if let Some(face) = parts.faces.iter().position(|f| f.loops.is_none()) {
            return Err(WriteError::NoLoops {
                object: index,
                face,
            });
        }
        let along = directed::directed(brep);
        brep::brep(body, geometry, along.as_ref().unwrap_or(brep));
        Ok(BREP)
    }
}

fn empty(out: &mut Writer, table: u32) {
    out.chunk(table, |w| w.short(END_OF_TABLE, 0));
}

/// An id made of a number: only that they differ matters.
fn id(space: u8, number: u64) -> [u8; 16] {
    let mut id = [0xFE; 16];
    id[8..].copy_from_slice(&number.to_be_bytes());
    // Version 8 (made by a rule of one's own), variant 1.
    id[7] = 0x80;
    id[8] = 0x80 | space;
    id
}

fn attributes(w: &mut Writer, object: &Object, layer: i32, number: u64) {
    w.u8(0x20);
    w.raw(&id(1, number));
    w.i32(layer);
    if !object.name.is_empty() {
        w.u8(1);
        w.string(&object.name);
    }
    let mode = match (object.hidden, object.locked) {
        (true, _) => 1,
        (false, true) => 2,
        _ => 0,
    };
    if mode == 1 {
        w.u8(11);
        w.u8(0);
    }
    if mode != 0 {
        w.u8(12);
        w.u8(mode);
    }
    w.u8(0);
}

const LAYER: &str = "95809813-E985-11d3-BFE5-0010830122F0";

fn layer(w: &mut Writer, name: &str, index: i32) {
    w.object(LAYER, |w| {
        w.u8(0x15);
        // Mode, index, level, material, a number no longer used.
        for x in [0, index, -1, -1, 0] {
            w.i32(x);
        }
        // Black.
        w.i32(0);
        // A line style no longer used.
        w.raw(&[0; 4]);
        w.f64s(&[0.0, 1.0]);
        w.string(name);
        // Visible; no line pattern; a plot colour and width.
        w.u8(1);
        w.i32(-1);
        w.i32(0);
        w.f64s(&[0.0]);
        // Not locked.
        w.u8(0);
        w.raw(&id(2, index as u64 + 1));
    });
}

fn units(w: &mut Writer, units: &Units, tolerance: Option<f64>) {
    // Layout 1.2.
    w.i32(102);
    w.i32(units.code());
    // Angle and relative tolerance: Rhino's own defaults, a degree and 1 %.
    w.f64s(&[tolerance.unwrap_or(UNSET), 1.0_f64.to_radians(), 0.01]);
    // Decimal display with 3 digits.
    w.i32(0);
    w.i32(3);
    w.f64s(&[units.metres().unwrap_or(1.0)]);
    w.string(match units {
        Units::Custom { name, .. } => name,
        _ => "",
    });
}
