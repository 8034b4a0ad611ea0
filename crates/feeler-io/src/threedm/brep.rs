//! `ON_Brep` 3.x (2.x: [`brep2`]).
//!
//! The format keeps lists with holes: a curve may be missing, an item may be marked as deleted. Both
//! are dropped here and the indices renumbered; a reference to one is an error.

use super::archive::{ANONYMOUS, Chunk};
use super::assembly::{
    Assembly, Kept, StoredEdge, StoredFace, StoredLoop, StoredTrim, StoredVertex, Topology,
};
use super::brep2;
use super::class::{self, Class};
use super::curves::{curve, curve_of};
use super::on_surface;
use super::surfaces::surface;
use crate::error::{Problem, ReadError};
use crate::poles::lost_edges;
use crate::sheets::{jumps, open};
use feeler::brep::{Brep, BrepParts, Iso, TrimKind};
use nalgebra::Point3;
use std::collections::BTreeMap;

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

/// A list of curves or surfaces, some of which may be missing. `read` gets the place of the one to read, which it may leave out.
fn geometry<'a, T>(
    data: &mut Chunk<'a>,
    what: &'static str,
    mut read: impl FnMut(&mut Chunk<'a>, usize) -> Result<Option<T>, ReadError>,
) -> Result<Kept<T>, ReadError> {
    let (mut list, count) = part(data, what, size_of::<i32>())?;
    let mut kept = Kept::new(what);
    for i in 0..count {
        let item = match list.i32("whether there is one")? {
            0 => None,
            _ => read(&mut list, i)?,
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
    let (major, minor) = class::layout(&mut data, "Brep", &[2, 3], remedy)?;
    let (parts, mut warnings) = if major == 2 {
        // Meshes for display follow: stepped over.
        (brep2::read(&mut data)?, Vec::new())
    } else {
        brep3(&mut data, minor)?
    };
    let (brep, found) = finished(parts, data)?;
    warnings.extend(found);
    Ok((brep, warnings))
}

/// The BREP of parts read from a chunk, which is done with, and what was odd about it.
pub(super) fn finished(
    mut parts: BrepParts,
    data: Chunk<'_>,
) -> Result<(Brep, Vec<String>), ReadError> {
    let mut warnings = open(&mut parts);
    let brep =
        Brep::new(parts).map_err(|problem| data.fail_at(data.id.offset, Problem::Brep(problem)))?;
    data.finish()?;
    warnings.extend(jumps(&brep));
    warnings.extend(lost_edges(&brep));
    Ok((brep, warnings))
}

/// Layout 3.x after its version.
fn brep3(data: &mut Chunk<'_>, minor: u8) -> Result<(BrepParts, Vec<String>), ReadError> {
    let curves2 = geometry(data, "uv curve", |d, _| curve(d, "a uv curve").map(Some))?;
    // Where an edge's curve is a curve on a surface that has no form here, trims say as much: the edge does without.
    let mut on_surface = BTreeMap::new();
    let curves3 = geometry(data, "space curve", |d, i| {
        let (class, object) = class::object(d)?;
        if class == Class::CurveOnSurface {
            let image = on_surface::read(object, "a space curve").ok();
            on_surface.insert(i, image.is_some());
            return Ok(image);
        }
        curve_of(class, object, "a space curve").map(Some)
    })?;
    let surfaces = geometry(data, "surface", |d, _| surface(d).map(Some))?;
    let mut topology = Topology::read(data)?;
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
    let mut warnings = Vec::new();
    if !on_surface.is_empty() {
        for (e, edge) in topology.edges.items_mut().enumerate() {
            let curve = usize::try_from(edge.curve).ok();
            let Some(is_read) = curve.and_then(|c| on_surface.get(&c)) else {
                continue;
            };
            let what = if *is_read {
                "which is taken as the curve in space that it is, rounded"
            } else {
                edge.curve = -1;
                "which has no form here and is left out; the faces' trims are used"
            };
            warnings.push(format!(
                "edge {e}: its curve is a curve on a surface (CurveOnSurface), {what}"
            ));
        }
    }
    let mut assembly = Assembly {
        at: data.id.offset,
        data,
        warnings,
    };
    let parts = assembly.parts(curves2, curves3, surfaces, &topology)?;
    Ok((parts, assembly.warnings))
}
