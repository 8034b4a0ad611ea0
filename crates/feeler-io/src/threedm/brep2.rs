//! `ON_Brep` 2.x, of files of version 2.
//!
//! Counts, the curves of trims and of edges as bare poly-curves, a NURBS surface for each face, then faces with their loops with
//! their trims. Meshes for display follow. Topology beyond that is [rebuilt](super::rebuild).

use super::archive::Chunk;
use super::curves::poly_or_only;
use super::rebuild::{OldBrep, OldFace, OldLoop, OldTrim, parts};
use super::surfaces::nurbs;
use crate::error::{Problem, ReadError};
use feeler::brep::BrepParts;
use feeler::nurbs::{Curve2, Curve3, Surface};

/// The fewest bytes of a poly-curve (its counts, box and no segments), of a NURBS surface, of a trim, a loop and a face.
const MIN_POLY_CURVE: usize = 65;
const MIN_SURFACE: usize = 93;
const MIN_TRIM: usize = 41;
const MIN_LOOP: usize = 44;
const MIN_FACE: usize = 68;

/// How many of what there are is said at the start, where the lists stand says how many fit.
fn counts(d: &mut Chunk<'_>) -> Result<[usize; 4], ReadError> {
    Ok([
        d.count("faces", MIN_SURFACE + MIN_FACE)?,
        d.count("edges", MIN_POLY_CURVE)?,
        d.count("loops", MIN_LOOP)?,
        d.count("trims", MIN_POLY_CURVE + MIN_TRIM)?,
    ])
}

/// The index stored next, of `count` things; none where it is -1.
fn index(d: &mut Chunk<'_>, what: &'static str, count: usize) -> Result<Option<usize>, ReadError> {
    let at = d.position();
    let stored = d.i32(what)?;
    match usize::try_from(stored) {
        Ok(i) if i < count => Ok(Some(i)),
        _ if stored == -1 => Ok(None),
        _ => Err(d.fail_at(
            at,
            Problem::Value {
                what: what.into(),
                found: stored.to_string(),
                expected: format!("-1, or less than {count}"),
            },
        )),
    }
}

/// A trim's fields, and the trim that it shares its edge with.
struct Fields {
    edge: Option<usize>,
    twin: Option<usize>,
    reversed: bool,
    tolerance: Option<f64>,
}

fn trim(d: &mut Chunk<'_>, edges: usize, trims: usize) -> Result<Fields, ReadError> {
    d.i32("a trim's own index")?;
    let twin = index(d, "a trim's twin", trims)?;
    d.u8("whether a trim has the edge")?;
    let edge = index(d, "a trim's edge", edges)?;
    let reversed = d.i32("a trim's direction")? != 0;
    d.skip(8, "a trim's flags")?;
    let tolerance = d.optional_f64("a trim's tolerance in space")?;
    d.f64("a trim's tolerance in uv")?;
    Ok(Fields {
        edge,
        twin,
        reversed,
        tolerance,
    })
}

/// The parts of the BREP whose layout version was just read.
pub(super) fn read(d: &mut Chunk<'_>) -> Result<BrepParts, ReadError> {
    let [face_count, edge_count, loop_count, trim_count] = counts(d)?;
    d.i32("the flag which way faces look")?;
    d.f64s::<6>("a BREP's box")?;
    let mut curves2: Vec<Curve2> = Vec::new();
    for _ in 0..trim_count {
        curves2.push(poly_or_only(d, "a uv curve")?);
    }
    let mut curves3: Vec<Curve3> = Vec::new();
    for _ in 0..edge_count {
        curves3.push(poly_or_only(d, "a space curve")?);
    }
    let mut surfaces = Vec::new();
    for _ in 0..face_count {
        surfaces.push(Surface::Nurbs(nurbs(d)?));
    }
    let mut faces = Vec::new();
    let mut fields = Vec::new();
    let mut loops_left = loop_count;
    let start = d.position();
    for surface in surfaces {
        d.skip(8, "a face's index and material")?;
        let reversed = d.i32("a face's direction")? != 0;
        d.i32("a face's kind")?;
        d.f64s::<6>("a face's box")?;
        let mut loops = Vec::new();
        for _ in 0..d.count("loops of a face", MIN_LOOP)? {
            loops_left = loops_left.saturating_sub(1);
            d.i32("a loop's index")?;
            let kind = d.i32("a loop's kind")?;
            d.f64s::<4>("a loop's box")?;
            let mut trims = Vec::new();
            for _ in 0..d.count("trims of a loop", MIN_TRIM)? {
                trims.push(fields.len());
                fields.push(trim(d, edge_count, trim_count)?);
            }
            loops.push(OldLoop { kind, trims });
        }
        faces.push(OldFace {
            surface,
            reversed,
            loops,
        });
    }
    if fields.len() != trim_count || loops_left != 0 {
        return Err(d.fail_at(
            start,
            Problem::Value {
                what: "the number of trims in the faces' loops".into(),
                found: fields.len().to_string(),
                expected: format!("{trim_count} in {loop_count} loops"),
            },
        ));
    }
    let edge_of = |f: &Fields| f.edge.or_else(|| fields.get(f.twin?)?.edge);
    let trims = fields.iter().zip(curves2).map(|(f, curve)| OldTrim {
        curve,
        edge: edge_of(f),
        reversed: f.reversed,
        tolerance: f.tolerance,
    });
    Ok(parts(OldBrep {
        trims: trims.collect(),
        curves3,
        faces,
    }))
}
