//! The side of a point in space, and lines near edges.

use super::answer::{LineKind, LineProbe, SideAnswer, Undecided};
use super::forms::{Forms, NOISE_FACTOR, Stabber, range};
use super::line::all_hits;
use super::zeros::{Digits, RawHit, face_hits};
use crate::numeric::Real;
use crate::numeric::bernstein::largest;
use crate::prepare::{Box3, Image, Net, PreparedBrep, SharedEdge, Stretch};
use crate::trim::Side;
use nalgebra::{Point3, Vector3};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// Directions for the parity test: none along an axis or a diagonal, none near another.
const DIRECTIONS: [[f64; 3]; 8] = [
    [0.352, 0.521, 0.778],
    [-0.677, 0.283, 0.679],
    [0.187, -0.911, 0.367],
    [0.823, 0.149, -0.548],
    [-0.419, -0.713, -0.562],
    [0.566, -0.307, 0.765],
    [-0.231, 0.891, -0.391],
    [0.937, -0.263, 0.229],
];
/// Nodes that one direction may cost.
pub(super) const PARITY_BUDGET: usize = 20_000;

/// The side of a point in space: whether it is in the solid's material.
///
/// By the parity of certified hits along a ray that keeps clear of every crack and of the regions around vertices
/// (DESIGN, and the proof there: parity then does not depend on the ray); several directions are tried. Open BREPs have no
/// material: `Outside`. A point so near the surface that the hit's enclosure holds it is undecided, but for one that is
/// exactly on a face whose points have one coordinate in common: `Boundary`.
pub fn inside(
    brep: &PreparedBrep,
    point: Point3<f64>,
    workspace: &mut super::Workspace,
) -> SideAnswer {
    let answer = |side, undecided| SideAnswer {
        side,
        in_gap: false,
        undecided,
    };
    if !brep.brep().is_closed() {
        return answer(Some(Side::Outside), None);
    }
    if brep.is_beyond(&point) {
        return answer(Some(Side::Outside), None);
    }
    if on_level_face(brep, point) {
        return answer(Some(Side::Boundary), None);
    }
    let mut why = Undecided::Degenerate;
    for d in DIRECTIONS {
        let Ok(probe) = LineProbe::new(point, Vector3::from(d), LineKind::Ray) else {
            return answer(None, Some(Undecided::Degenerate));
        };
        workspace.work.rays += 1;
        let stab = Stabber::new(&probe);
        let mut budget = PARITY_BUDGET;
        if meets_vertex(brep, &stab) || near_edges(brep, &stab, &mut budget) {
            why = Undecided::Crack;
            continue;
        }
        let on_surface = |hits: &[RawHit]| hits.iter().any(|h| h.t.lower() <= 0.0);
        let (mut hits, mut undecided) = all_hits(brep, &stab, Digits::Double, &mut budget);
        if undecided.is_some() || on_surface(&hits) {
            // f64 sees only so far.
            (hits, undecided) = all_hits(brep, &stab, Digits::All, &mut budget);
        }
        let off_edges = |h: &RawHit| h.exact.as_ref().is_none_or(|m| m.on.is_empty());
        let plain = |h: &RawHit| h.crosses() && !h.is_row() && off_edges(h);
        if undecided.is_some() || !hits.iter().all(plain) {
            why = Undecided::Degenerate;
            continue;
        }
        if on_surface(&hits) {
            // On the surface, up to the enclosure: no direction will tell.
            return answer(None, Some(Undecided::Degenerate));
        }
        let side = if hits.len() % 2 == 1 {
            Side::Inside
        } else {
            Side::Outside
        };
        return answer(Some(side), None);
    }
    answer(None, Some(why))
}

/// Whether the point is proven to be exactly on a face all of whose points have the same x, y or z.
///
/// A ray from it that is not along the face's plane meets the plane in this point alone: a certified hit is this point.
fn on_level_face(brep: &PreparedBrep, point: Point3<f64>) -> bool {
    (0..brep.brep().faces().len()).any(|face| {
        let level = brep.level(face);
        if !level.is_some_and(|(axis, at)| point[axis] == at) {
            return false;
        }
        let Ok(probe) = LineProbe::new(point, Vector3::from(DIRECTIONS[0]), LineKind::Line) else {
            return false;
        };
        let mut budget = PARITY_BUDGET;
        let found = face_hits(brep, &Stabber::new(&probe), face, Digits::All, &mut budget);
        found.is_some_and(|f| f.hits.iter().any(|h| h.inside))
    })
}

/// Whether the line may meet a region around a vertex.
fn meets_vertex(brep: &PreparedBrep, stab: &Stabber) -> bool {
    let meets = |regions: Option<&[Box3]>| {
        regions.is_none_or(|regions| regions.iter().any(|b| stab.meets(b)))
    };
    // f64 sees only so far: what it finds near is looked at again.
    meets(brep.vertex_regions()) && meets(brep.fine_vertex_regions())
}

/// Whether the line may come within the width of its crack of an edge that two trims use. Errs on the side of yes.
pub(super) fn near_edges(brep: &PreparedBrep, stab: &Stabber, budget: &mut usize) -> bool {
    let edges = brep.shared_edges();
    let near = |index: usize| is_near_images(brep, stab, &edges[index], budget);
    brep.edges_by_line(&stab.skewer(), |b| !stab.meets(b), near)
}

/// The edges for which that is so.
pub(super) fn all_near_edges<'a>(
    brep: &'a PreparedBrep,
    stab: &Stabber,
    budget: &mut usize,
) -> Vec<&'a SharedEdge> {
    let edges = brep.shared_edges();
    let mut near = Vec::new();
    brep.edges_by_line(
        &stab.skewer(),
        |b| !stab.meets(b),
        |index| {
            near.push(index);
            false
        },
    );
    near.sort_unstable();
    let near = near.into_iter().map(|index| &edges[index]);
    near.filter(|shared| is_near_images(brep, stab, shared, budget))
        .collect()
}

/// Whether the line may come within the width of its crack of the images of an edge's trims.
fn is_near_images(
    brep: &PreparedBrep,
    stab: &Stabber,
    shared: &SharedEdge,
    budget: &mut usize,
) -> bool {
    let d = stab.direction / stab.direction.norm();
    let (o, d) = (stab.origin.coords.into(), d.into());
    let edge = shared.edge;
    let e = &brep.brep().parts().edges[edge];
    let margin = brep.crack_width(edge);
    let mut near = e.trims.iter().filter(|t| {
        if let Some((curve, slack)) = brep.closed_image(**t)
            && curve.shape.is_clear_of(&o, &d, (margin + slack) * UP)
        {
            return false;
        }
        let image = brep.trim_image(**t);
        image.is_none_or(|image| near_image(stab, image, margin, budget))
    });
    let Some(first) = near.next() else {
        return false;
    };
    // f64 sees only so far: what it finds near is looked at again.
    let rest: Vec<_> = std::iter::once(first).chain(near).copied().collect();
    let margin = brep.fine_crack_width(edge);
    rest.into_iter().any(|t| {
        let image = brep.fine_trim_image(t);
        image.is_none_or(|image| near_image(stab, image, margin, budget))
    })
}

/// Whether the line comes within a distance of an image.
fn near_image<T: Real>(stab: &Stabber, image: &Image<T>, margin: f64, budget: &mut usize) -> bool {
    // |L_k| / w is the distance from plane k times |n_k|.
    let norms = [0, 1].map(|k| stab.normals[k].norm() * UP);
    image.stretches.iter().any(|s: &Stretch<T>| {
        let margin = (margin + s.slack + image.extra) * UP;
        let wide = s
            .bounds
            .map(|r| [(r[0] - margin).next_down(), (r[1] + margin).next_up()]);
        // A place of the curve whose height along the line is beyond an end of it may be within the margin of that end.
        let stab = stab.longer(margin);
        stab.meets(&wide) && near_curve(&stab, &s.net(), norms.map(|n| margin * n), budget)
    })
}

/// Whether both `|L_k| / w <= reach[k]` somewhere on a curve, as far as the arithmetic can tell.
fn near_curve<T: Real>(
    stab: &Stabber,
    space: &Net<T>,
    reach: [f64; 2],
    budget: &mut usize,
) -> bool {
    let mut stack = vec![(stab.forms(space), 0)];
    let mut turned = Vec::new();
    while let Some((node, depth)) = stack.pop() {
        let w = range(&node.c[3], node.error[3]);
        let clear = (0..2).any(|k| {
            let r = range(&node.c[k], node.error[k]);
            r[0] > reach[k] * w[1] * UP || r[1] < -reach[k] * w[1] * UP
        });
        if clear || node.beyond(stab) || passes(&node, reach, w[1], &mut turned) {
            continue;
        }
        let noise = (0..2).all(|k| largest(&node.c[k]) <= NOISE_FACTOR * node.error[k]);
        if *budget == 0 || noise || depth >= NEAR_DEPTH {
            return true;
        }
        *budget -= 1;
        stack.extend(node.halves(true).map(|half| (half, depth + 1)));
    }
    false
}

/// Whether a curve passes the line on the side of its chord.
///
/// `a L_1 + b L_2` is the height over the plane with normal `a n_1 + b n_2` through the line, times `w`: where the curve is within the margin of the line
/// it is at most `|a| reach_1 + |b| reach_2` times `w`. Of all such planes the one along the chord is tried.
fn passes<T: Real>(node: &Forms<T>, reach: [f64; 2], w: f64, turned: &mut Vec<T>) -> bool {
    let last = node.c[0].len() - 1;
    let along = [0, 1].map(|k| {
        let at = |i: usize| node.c[k][i].approximate() / node.c[3][i].approximate();
        at(last) - at(0)
    });
    let combination = [along[1], -along[0]];
    let error = node.combine(combination, turned);
    let r = range(turned, error);
    let within = (along[1].abs() * reach[0] + along[0].abs() * reach[1]) * w * UP;
    r[0] > within || r[1] < -within
}

/// A part of a boundary piece this many halvings deep that is not clear of the line counts as near.
const NEAR_DEPTH: usize = 64;
