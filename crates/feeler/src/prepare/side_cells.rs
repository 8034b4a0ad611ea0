//! Sides of points in space that are kept, so that the ray through the part is cast once for many probes.
//!
//! # What is proven
//! Let `F` be the union of the trimmed faces, their trims included, and `T` the images of what of the trims is outside the
//! domains of their surfaces, moved to the nearest points of the domains. The side of a point is the parity of the hits along a
//! ray that keeps clear of cracks and of the regions around vertices (module `query::inside`). Modulo 2 the boundary of a face
//! is the image of its loops, moved so. Along each edge, take the segments between the points of two trims that a
//! matching pairs: they close the crack, and none reaches farther from the trims' images than the crack's width. What then remains
//! open is in the regions around vertices, which hold ends of these images, and so can be closed within the regions' diagonals. So
//! `F` and what closes it, all within `reach` of `F` and `T`, is a closed surface `Z`, and a ray that keeps clear of cracks and
//! vertices meets `Z` as often as `F`, modulo 2. The parity of a ray with respect to a closed surface does not depend on the ray,
//! and is the same all along a path that does not meet `Z`.
//!
//! - A ball of radius `d - reach` about a point that is at least `d` from `F` and `T` does not meet `Z`. With `d > 2 reach` all
//!   points within `d / 2` of it are on its side: any of them may be asked in its place.
//! - A point outside the box of all faces, with the same `d`, is outside: along the axis that leads straight away
//!   from the box it gets no nearer to any point of `F` or `T`, and far away there is no `Z`.
//!
//! Trims leave a domain by a rounding where they end on its border, or run along it. A piece whose box reaches over a side of the
//! domain has its part of `T` in the image of that side, where the box projects to it: boxes around the control
//! points of its parts hold it.
//!
//! # What is kept
//! The box of all faces is halved along its three axes again and again. Of a point, the largest of these cells around it whose
//! middle is within `d / 2` is asked for the side of its middle. Which cell that is hangs on the point and on `d` alone, so
//! answers do not depend on what was asked before.

use super::{Box3, Net, PreparedBrep, restrict};
use crate::numeric::Ball;
use crate::numeric::bernstein::Bidegree;
use nalgebra::Point3;
use std::sync::OnceLock;

/// Cells are halved so often at most: a part of this many points' sides needs a few megabytes.
const MOST_HALVINGS: usize = 6;
/// A distance is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// A cell and what is known about its middle.
#[derive(Debug, Default)]
struct Cell {
    /// Whether the middle is in material; `None` where that is undecided.
    side: OnceLock<Option<bool>>,
    parts: OnceLock<Box<[Cell; 8]>>,
}

/// The image of a side of a patch is covered by so many boxes.
const BOXES: usize = 8;
/// More boxes than this would take longer to look at than a ray.
const MOST_BOXES: usize = 512;

/// Adds boxes around all that a face adds to `T`; `None` where there is none, or too many.
fn strays(brep: &PreparedBrep, face: usize, out: &mut Vec<Box3>) -> Option<()> {
    let region = brep.region(face);
    let domain = region.domain().map(|d| [d.start, d.end]);
    for piece in region.pieces().filter(|p| !p.inside_domain) {
        for (k, end) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let side = domain[k][end];
            let [low, high] = piece.hull[k];
            if low >= side && end == 0 || high <= side && end == 1 {
                continue;
            }
            let [low, high] = domain[1 - k];
            let along = piece.hull[1 - k].map(|x| x.clamp(low, high));
            let patches = &brep.double(face).patches;
            for index in 0..patches.len() {
                let maps = patches.maps_of(index);
                let (across, own) = (&maps[k], &maps[1 - k]);
                let around = own.around();
                let range = [along[0].max(around[0]), along[1].min(around[1])];
                if [across.start, across.end][end] != side || !(range[0] <= range[1]) {
                    continue;
                }
                let local = range.map(|x| own.to_local(Ball::<f64>::exact(x)));
                let (a, b) = (local[0].lower().max(0.0), local[1].upper().min(1.0));
                let patch = patches.lent(index);
                let row = patch.net.side(k == 0, end == 1);
                let count = 1 + (BOXES as f64 * (b - a)) as usize;
                let cut = |i: usize| {
                    if i == count {
                        b
                    } else {
                        a + (b - a) * (i as f64 / count as f64)
                    }
                };
                for i in 0..count {
                    if out.len() == MOST_BOXES {
                        return None;
                    }
                    let part = restrict(&row, cut(i), cut(i + 1));
                    let degree = Bidegree {
                        u: part.len() - 1,
                        v: 0,
                    };
                    out.push(Net::new(degree, part, patch.net.origin).bounding_box()?);
                }
            }
        }
    }
    Some(())
}

/// How far a point is from a box, up to a few roundings.
fn distance_to(b: &Box3, point: &Point3<f64>) -> f64 {
    let off = |c: usize| (b[c][0] - point[c]).max(point[c] - b[c][1]).max(0.0);
    (0..3).map(|c| off(c).powi(2)).sum::<f64>().sqrt()
}

/// See the module.
#[derive(Debug)]
pub(crate) struct SideCells {
    strays: Vec<Box3>,
    bounds: Box3,
    reach: f64,
    root: Cell,
}

impl SideCells {
    /// `None` where too much of the trims leaves the domains of their surfaces, or a face has no box. Needs the widths of all
    /// cracks.
    pub(super) fn new(brep: &PreparedBrep) -> Option<Self> {
        let faces = 0..brep.brep().faces().len();
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        let mut strays = Vec::new();
        for face in faces {
            self::strays(brep, face, &mut strays)?;
            let own = brep.face_box(face)?;
            for (b, o) in bounds.iter_mut().zip(own) {
                *b = [b[0].min(o[0]), b[1].max(o[1])];
            }
        }
        let edges = 0..brep.brep().parts().edges.len();
        let widest = edges.map(|e| brep.crack_width(e)).fold(0.0, f64::max);
        let diagonal = |b: &Box3| b.iter().map(|r| (r[1] - r[0]).powi(2)).sum::<f64>().sqrt();
        let regions: Option<Vec<Box3>> = brep.vertices().regions(brep).collect();
        let regions = regions?;
        Some(Self {
            strays,
            bounds,
            reach: regions.iter().map(diagonal).fold(widest, f64::max) * UP,
            root: Cell::default(),
        })
    }

    /// Whether a point that is at least `distance` from all faces is in material; `None` where no cell tells. `find` tells it of
    /// a cell's middle.
    pub(crate) fn in_material(
        &self,
        point: &Point3<f64>,
        distance: f64,
        find: impl FnOnce(Point3<f64>) -> Option<bool>,
    ) -> Option<bool> {
        let mut distance = distance;
        for b in &self.strays {
            distance = distance.min(distance_to(b, point) / UP);
        }
        if !(distance > 2.0 * self.reach) {
            return None;
        }
        let b = &self.bounds;
        if (0..3).any(|c| point[c] < b[c][0] || point[c] > b[c][1]) {
            return Some(false);
        }
        // Cells are made only on the way to one that tells.
        let (mut way, mut bounds) = ([0; MOST_HALVINGS], self.bounds);
        for halvings in 0..=MOST_HALVINGS {
            let middle = Point3::from(bounds.map(|r| r[0] + 0.5 * (r[1] - r[0])));
            if (middle - point).norm() * UP < 0.5 * distance {
                let cell = way[..halvings].iter().fold(&self.root, |cell, part| {
                    &cell.parts.get_or_init(Default::default)[*part]
                });
                return *cell.side.get_or_init(|| find(middle));
            }
            let Some(way) = way.get_mut(halvings) else {
                break;
            };
            let mut part = 0;
            for c in 0..3 {
                let above = point[c] >= middle[c];
                bounds[c][usize::from(!above)] = middle[c];
                part = 2 * part + usize::from(above);
            }
            *way = part;
        }
        None
    }

    /// Bytes that the cells take.
    pub(super) fn bytes(&self) -> usize {
        let mut sum = size_of::<Self>() + self.strays.capacity() * size_of::<Box3>();
        let mut left = vec![&self.root];
        while let Some(cell) = left.pop() {
            if let Some(parts) = cell.parts.get() {
                sum += size_of_val(&**parts);
                left.extend(parts.iter());
            }
        }
        sum
    }
}
