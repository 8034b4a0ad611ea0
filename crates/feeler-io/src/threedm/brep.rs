//! `ON_Brep` 3.x.
//!
//! The format keeps lists with holes: a curve may be missing, an item may be marked as deleted. Both
//! are dropped here and the indices renumbered; a reference to one is an error.

use super::archive::{ANONYMOUS, Chunk};
use super::assembly::{
    Assembly, Kept, StoredEdge, StoredFace, StoredLoop, StoredTrim, StoredVertex, Topology,
};
use super::class;
use super::curves::curve;
use super::surfaces::surface;
use crate::error::{Problem, ReadError};
use crate::sheets::{jumps, open};
use feeler::brep::{Brep, Iso, TrimKind};
use nalgebra::Point3;

/// From this version of the library on, edges and trims store the domain they are shown with.
const OWN_DOMAINS_SINCE: u32 = 200_206_180;

/// Opens the next part and reads how many items it holds.
fn part<'a>(
    data: &mut Chunk<'a>,
    what: &'static str,
    item_size: usize,
) -> Result<(Chunk<'a>, usize), ReadError> {
    let mut list = data.expect(ANONYMOUS, what)?;
    class::layout(&mut list, what, &[1], super::curves::REMEDY)?;
    let count = list.count(what, item_size)?;
    Ok((list, count))
}

/// A list of curves or surfaces, some of which may be missing.
fn geometry<'a, T>(
    data: &mut Chunk<'a>,
    what: &'static str,
    mut read: impl FnMut(&mut Chunk<'a>) -> Result<T, ReadError>,
) -> Result<Kept<T>, ReadError> {
    let (mut list, count) = part(data, what, size_of::<i32>())?;
    let mut kept = Kept::new(what);
    for _ in 0..count {
        let item = match list.i32("whether there is one")? {
            0 => None,
            _ => Some(read(&mut list)?),
        };
        kept.push(item);
    }
    list.finish()?;
    Ok(kept)
}

/// A list of items that start with their own index, -1 if deleted.
fn items<'a, T>(
    list: &mut Chunk<'a>,
    what: &'static str,
    count: usize,
    mut read: impl FnMut(&mut Chunk<'a>) -> Result<T, ReadError>,
) -> Result<Kept<T>, ReadError> {
    let mut kept = Kept::new(what);
    for i in 0..count {
        let at = list.position();
        let own = list.i32("an index")?;
        let item = read(list)?;
        if own == -1 {
            kept.push(None);
        } else if usize::try_from(own) == Ok(i) {
            kept.push(Some(item));
        } else {
            return Err(list.fail_at(
                at,
                Problem::Value {
                    what: format!("the own index in the list of {what}"),
                    found: own.to_string(),
                    expected: i.to_string(),
                },
            ));
        }
    }
    Ok(kept)
}

fn vertex(d: &mut Chunk<'_>) -> Result<StoredVertex, ReadError> {
    Ok(StoredVertex {
        point: Point3::from(d.f64s::<3>("a vertex's point")?),
        edges: d.i32_array("edges of a vertex")?,
        tolerance: d.optional_f64("a vertex's tolerance")?,
    })
}

fn edge(d: &mut Chunk<'_>, own_domains: bool) -> Result<StoredEdge, ReadError> {
    let edge = StoredEdge {
        curve: d.i32("an edge's curve")?,
        reversed: d.i32("an edge's direction")? != 0,
        span: d.f64s("an edge's span")?,
        vertices: [d.i32("an edge's start")?, d.i32("an edge's end")?],
        trims: d.i32_array("trims of an edge")?,
        tolerance: d.optional_f64("an edge's tolerance")?,
    };
    if own_domains {
        // A linear change of parameter that nothing here depends on.
        d.f64s::<2>("an edge's domain")?;
    }
    Ok(edge)
}

fn trim(d: &mut Chunk<'_>, own_domains: bool) -> Result<StoredTrim, ReadError> {
    let mut trim = StoredTrim {
        curve: d.i32("a trim's curve")?,
        span: d.f64s("a trim's span")?,
        edge: d.i32("a trim's edge")?,
        vertices: [d.i32("a trim's start")?, d.i32("a trim's end")?],
        edge_reversed: d.i32("a trim's direction")? != 0,
        kind: match d.i32("a trim's kind")? {
            1 => TrimKind::Boundary,
            2 => TrimKind::Mated,
            3 => TrimKind::Seam,
            4 => TrimKind::Singular,
            _ => TrimKind::Unknown,
        },
        iso: match d.i32("a trim's iso status")? {
            1 => Iso::U,
            2 => Iso::V,
            3 => Iso::West,
            4 => Iso::South,
            5 => Iso::East,
            6 => Iso::North,
            _ => Iso::None,
        },
        trim_loop: d.i32("a trim's loop")?,
        reversed: false,
    };
    d.f64s::<2>("a trim's tolerances")?;
    if own_domains {
        d.f64s::<2>("a trim's domain")?;
        trim.reversed = d.u8("whether a trim is reversed")? != 0;
        d.skip(7 + 24, "reserved fields")?;
    } else {
        d.f64s::<6>("reserved fields")?;
    }
    d.f64s::<2>("a trim's older tolerances")?;
    Ok(trim)
}

/// Opens the next part and reads its items, which take at least `item_size` bytes each (every field
/// of an item, its arrays empty). What follows the items is not used.
fn list<'a, T>(
    data: &mut Chunk<'a>,
    what: &'static str,
    item_size: usize,
    read: impl FnMut(&mut Chunk<'a>) -> Result<T, ReadError>,
) -> Result<Kept<T>, ReadError> {
    let (mut list, count) = part(data, what, item_size)?;
    let kept = items(&mut list, what, count, read)?;
    list.finish()?;
    Ok(kept)
}

impl Topology {
    fn read(data: &mut Chunk<'_>) -> Result<Self, ReadError> {
        let archive = data.archive;
        let own_domains = archive.version >= 3 && archive.opennurbs >= OWN_DOMAINS_SINCE;
        Ok(Self {
            vertices: list(data, "vertex", 40, vertex)?,
            edges: list(data, "edge", 52, |d| edge(d, own_domains))?,
            trims: list(data, "trim", 132, |d| trim(d, own_domains))?,
            loops: list(data, "loop", 16, |d| {
                Ok(StoredLoop {
                    trims: d.i32_array("trims of a loop")?,
                    kind: d.i32("a loop's kind")?,
                    face: d.i32("a loop's face")?,
                })
            })?,
            faces: list(data, "face", 20, |d| {
                let face = StoredFace {
                    loops: d.i32_array("loops of a face")?,
                    surface: d.i32("a face's surface")?,
                    reversed: d.i32("a face's direction")? != 0,
                };
                d.i32("a face's material")?;
                Ok(face)
            })?,
        })
    }
}

/// A BREP, and what was odd about it.
pub(super) fn brep(mut data: Chunk<'_>) -> Result<(Brep, Vec<String>), ReadError> {
    let remedy = "3 or later (open it in Rhino or with rhino3dm)";
    let (_, minor) = class::layout(&mut data, "Brep", &[3], remedy)?;
    let curves2 = geometry(&mut data, "uv curve", |d| curve(d, "a uv curve"))?;
    let curves3 = geometry(&mut data, "space curve", |d| curve(d, "a space curve"))?;
    let surfaces = geometry(&mut data, "surface", surface)?;
    let topology = Topology::read(&mut data)?;
    data.f64s::<6>("a BREP's box")?;
    // Meshes for display, a flag whether it is a solid, regions: not used (whether a BREP is closed is
    // decided by its edges), and stepped over only because the checksum leaves inner chunks out.
    if minor >= 1 {
        data.expect(ANONYMOUS, "meshes")?;
        data.expect(ANONYMOUS, "meshes")?;
    }
    if minor >= 2 {
        data.i32("the solid flag")?;
    }
    if minor >= 3 {
        data.expect(ANONYMOUS, "regions")?;
    }
    let mut assembly = Assembly {
        at: data.id.offset,
        data: &data,
        warnings: Vec::new(),
    };
    let mut parts = assembly.parts(curves2, curves3, surfaces, &topology)?;
    let mut warnings = assembly.warnings;
    warnings.extend(open(&mut parts));
    let brep =
        Brep::new(parts).map_err(|problem| data.fail_at(data.id.offset, Problem::Brep(problem)))?;
    data.finish()?;
    warnings.extend(jumps(&brep));
    Ok((brep, warnings))
}
