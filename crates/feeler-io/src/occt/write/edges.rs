//! Edges: OCCT wants an edge's curve in space and its curves in uv to run alike, over one range. The kernel knows no such rule.

use super::Problem;
use super::curves::Piece;
use crate::sheets::ROUNDING;
use feeler::brep::{Brep, BrepParts, Edge, TrimCurve};
use feeler::numeric::Interval;
use feeler::nurbs::Surface;
use nalgebra::Point3;
use std::collections::HashMap;

/// OCCT's smallest tolerance, in the model's unit: `Precision::Confusion()`. For edges and vertices whose file says none.
pub(super) const CONFUSION: f64 = 1e-7;

/// At so many steps an edge's curves are compared, as OCCT does (`BRepCheck_Edge`: 22), and half of these as well.
const STEPS: u32 = 44;

/// Curves of an edge that are no farther apart than this part of the model's size get a tolerance that holds
/// them; others run differently, and the edge says so.
const RUN_ALIKE: f64 = 1.0 / (1_u32 << 20) as f64;

/// What is seen between samples may be more: tolerances are so much larger than what was seen.
const SEEN: f64 = 1.125;

/// The curves of an edge, all in its direction.
pub(super) struct Curves {
    pub(super) in_space: Option<Piece<3, 4>>,
    /// By trim.
    pub(super) in_uv: Vec<(usize, Piece<2, 3>)>,
    /// Whether they run alike, over one range.
    pub(super) alike: bool,
    /// Whether the curve in space got another parameter, rounded.
    pub(super) space_rounded: bool,
    /// Whether a curve in uv did: the other side of a seam.
    pub(super) uv_rounded: bool,
    pub(super) tolerance: f64,
    /// How much more that is than the source says, because of the need.
    pub(super) raised: f64,
    /// How far the curves end from the vertices.
    pub(super) at_ends: [f64; 2],
}

/// The surface a trim lies on.
pub(super) fn surface_of<'p>(parts: &'p BrepParts, trim: &TrimCurve) -> Option<&'p Surface> {
    let face = parts.faces.get(parts.loops.get(trim.trim_loop)?.face)?;
    parts.surfaces.get(face.surface)
}

fn in_uv(parts: &BrepParts, trim: &TrimCurve) -> Result<Piece<2, 3>, Problem> {
    let curve = parts.curves2.get(trim.curve);
    let curve = curve.ok_or_else(|| Problem::new("a trim has no curve"))?;
    Piece::new(curve, trim.span, trim.reversed != trim.edge_reversed)
}

/// A singular trim's curve and how far its ends are from its vertices.
pub(super) fn singular(
    parts: &BrepParts,
    trim: &TrimCurve,
) -> Result<(Piece<2, 3>, [f64; 2]), Problem> {
    let curve = parts.curves2.get(trim.curve);
    let curve = curve.ok_or_else(|| Problem::new("a trim has no curve"))?;
    let piece = Piece::new(curve, trim.span, false)?;
    let mut vertices = trim.vertices;
    if trim.reversed {
        vertices.reverse();
    }
    let off = ends(
        parts,
        vertices,
        |t| on_surface(parts, trim, &piece, t),
        &piece,
    );
    Ok((piece, off))
}

fn on_surface(
    parts: &BrepParts,
    trim: &TrimCurve,
    piece: &Piece<2, 3>,
    t: f64,
) -> Option<Point3<f64>> {
    let uv = piece.curve.point(t);
    Some(surface_of(parts, trim)?.point(uv.x, uv.y))
}

/// How far the ends of a curve are from vertices.
fn ends<const D: usize, const H: usize>(
    parts: &BrepParts,
    vertices: [usize; 2],
    at: impl Fn(f64) -> Option<Point3<f64>>,
    piece: &Piece<D, H>,
) -> [f64; 2] {
    let [s, t] = [piece.range.start, piece.range.end];
    [(0, s), (1, t)].map(|(i, t)| {
        let vertex = parts.vertices.get(vertices[i]).map(|v| v.point);
        vertex
            .zip(at(t))
            .map_or(0.0, |(v, p): (Point3<f64>, Point3<f64>)| (v - p).norm())
    })
}

/// Whether two ranges are one up to the rounding of what files print: 15 digits.
fn is_same(a: Interval, b: Interval) -> bool {
    let slack = ROUNDING * a.start.abs().max(a.end.abs()).max(a.length());
    (a.start - b.start).abs() <= slack && (a.end - b.end).abs() <= slack
}

/// The curves of an edge, given one range where that can be.
pub(super) fn curves(
    brep: &Brep,
    edge: &Edge,
    trims: &[usize],
    size: f64,
) -> Result<Curves, Problem> {
    let parts = brep.parts();
    let mut in_space = match edge.curve.and_then(|c| parts.curves3.get(c)) {
        Some(curve) => Some(Piece::new(curve, edge.span, edge.reversed)?),
        None => None,
    };
    let mut own = Vec::with_capacity(trims.len());
    for t in trims {
        if let Some(trim) = parts.trims.get(*t) {
            own.push((*t, trim, in_uv(parts, trim)?));
        }
    }
    // The range of a curve in uv whose parameter cannot change without rounding; else that of the curve in space.
    let stiff = own
        .iter()
        .find(|(_, _, p)| !p.is_loose())
        .map(|(_, _, p)| p.range);
    let first = own.first().map(|(_, _, p)| p.range);
    let range = stiff.or(in_space.as_ref().map(|p| p.range)).or(first);
    let Some(range) = range else {
        return Err(Problem::new("an edge has no curve"));
    };
    let mut same = true;
    let (mut space_rounded, mut uv_rounded) = (false, false);
    for i in 0..own.len() {
        if own[i].2.is_loose()
            && let Some(moved) = own[i].2.over(range)?
        {
            own[i].2 = moved;
        }
        same &= is_same(own[i].2.range, range);
    }
    // Both sides of a seam stand in one record, with one range.
    let mut ranges = HashMap::new();
    for (_, trim, piece) in &mut own {
        let face = parts.loops.get(trim.trim_loop).map(|l| l.face);
        let range = *ranges.entry(face).or_insert(piece.range);
        if range != piece.range {
            let was_loose = piece.is_loose();
            let moved = piece.over(range)?;
            let problem = "the two sides of a seam are arcs of different angles in uv";
            *piece = moved.ok_or_else(|| Problem::new(problem))?;
            uv_rounded |= !was_loose;
        }
    }
    let mut at_ends = [0.0_f64; 2];
    let mut add = |off: [f64; 2]| {
        for i in 0..2 {
            at_ends[i] = at_ends[i].max(off[i]);
        }
    };
    for (_, trim, piece) in &own {
        let at = |t: f64| on_surface(parts, trim, piece, t);
        add(ends(parts, edge.vertices, at, piece));
    }
    if let Some(piece) = &in_space {
        add(ends(
            parts,
            edge.vertices,
            |t| Some(piece.curve.point(t)),
            piece,
        ));
    }
    let mut apart: f64 = 0.0;
    if let Some(piece) = &in_space
        && same
    {
        let fits = is_same(piece.range, range);
        let moved = if fits {
            Some(piece.clone())
        } else {
            piece.over(range)?
        };
        let is_loose = piece.is_loose() || fits;
        match moved {
            Some(moved) => {
                for (_, trim, uv) in &own {
                    for k in 0..=STEPS {
                        let s = f64::from(k) / f64::from(STEPS);
                        let Some(p) = on_surface(parts, trim, uv, uv.range.lerp(s)) else {
                            continue;
                        };
                        apart = apart.max((p - moved.curve.point(moved.range.lerp(s))).norm());
                    }
                }
                let stored = edge.tolerance.unwrap_or(0.0);
                same = apart <= stored.max(CONFUSION).max(RUN_ALIKE * size);
                if same {
                    space_rounded = !is_loose;
                    in_space = Some(moved);
                }
            }
            None => same = false,
        }
    }
    let (tolerance, raised) = tolerance(edge.tolerance, if same { apart } else { 0.0 });
    Ok(Curves {
        in_space,
        in_uv: own.into_iter().map(|(t, _, p)| (t, p)).collect(),
        alike: same,
        space_rounded,
        uv_rounded,
        tolerance,
        raised,
        at_ends,
    })
}

/// The stored tolerance, but no less than OCCT's smallest, and no less than needed. And by how much the need raises it.
pub(super) fn tolerance(stored: Option<f64>, off: f64) -> (f64, f64) {
    let own = stored.map_or(CONFUSION, |t| t.max(CONFUSION));
    if off > own {
        (off * SEEN, off * SEEN - own)
    } else {
        (own, 0.0)
    }
}
