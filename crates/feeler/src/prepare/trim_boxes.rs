//! Boxes around parts of what trims are in space, which tell where a trim is not near a point. Of use for which contacts there are and how they are
//! named; no bound rests on them.

use super::bunches::{Bunches, FEW};
use super::spline::{BezierCurve, curve_pieces};
use super::{Box3, PreparedBrep, around, piece_count, widened};
use crate::nurbs::Surface;
use nalgebra::Point3;
use std::sync::OnceLock;

/// So many steps from sample to sample has a part.
pub(crate) const SAMPLES: usize = 32;
/// Eight of them a piece: samples that are pieces apart tell nothing of what is between them.
const PIECES: usize = SAMPLES / 8;
/// A bend between two samples is no longer than this many times the way between them.
pub(crate) const BENT: f64 = 2.0;

/// Room for roundings, as a part of the size.
const ROOM: f64 = 1.0 / (1u64 << 40) as f64;

/// Of each trim: boxes around its parts.
pub(super) type TrimBoxes = Box<[OnceLock<PartBoxes>]>;

/// Boxes around the parts of a trim.
#[derive(Debug)]
pub(crate) struct PartBoxes {
    parts: Box<[Box3]>,
    /// Around bunches of them, where there are many.
    bunches: Option<Bunches>,
}

impl PartBoxes {
    fn new(parts: Box<[Box3]>) -> Self {
        let boxes = || parts.iter().copied().map(Some);
        let bunches = (parts.len() > FEW).then(|| Bunches::new(boxes()));
        Self { parts, bunches }
    }

    /// How many parts there are.
    pub(crate) fn count(&self) -> usize {
        self.parts.len()
    }

    /// The first part from `from` on whose box is near, and its box. What is not near holds nothing that is.
    pub(crate) fn next(&self, from: usize, near: impl Fn(&Box3) -> bool) -> Option<(usize, &Box3)> {
        let mut part = from;
        loop {
            if let Some(bunches) = &self.bunches {
                part = bunches.next(part, &near)?;
            }
            let own = self.parts.get(part)?;
            if near(own) {
                return Some((part, own));
            }
            part += 1;
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.parts) + self.bunches.as_ref().map_or(0, Bunches::bytes)
    }
}

impl PreparedBrep {
    /// How many parts a trim is looked at in, all as long in its parameter.
    pub(crate) fn trim_parts(&self, trim: usize) -> usize {
        let parts = self.brep().parts();
        let t = &parts.trims[trim];
        let count = piece_count(&parts.curves2[t.curve], t.span.start, t.span.end).pieces;
        count.div_ceil(PIECES).max(1)
    }

    /// Boxes around them; `image` is what the trim is in space, from 0 to 1.
    pub(crate) fn trim_boxes(&self, trim: usize, image: impl Fn(f64) -> Point3<f64>) -> &PartBoxes {
        let slots = || self.brep().parts().trims.iter().map(|_| OnceLock::new());
        let all = self.trim_boxes.get_or_init(|| slots().collect());
        all[trim].get_or_init(|| {
            let count = self.trim_parts(trim);
            PartBoxes::new(self.flat_boxes(trim, count).unwrap_or_else(|| {
                let part = |k: usize| box_of(|s| image((k as f64 + s) / count as f64));
                (0..count).map(part).collect()
            }))
        })
    }

    /// Those of a trim in a plane, by the control points of its pieces: of teeth that are long and next to each other samples tell little.
    fn flat_boxes(&self, trim: usize, count: usize) -> Option<Box<[Box3]>> {
        let parts = self.brep().parts();
        let t = &parts.trims[trim];
        let surface = self.brep().surface(parts.loops[t.trim_loop].face);
        if !matches!(surface, Surface::Plane(_)) {
            return None;
        }
        let mut pieces: Vec<BezierCurve<f64, 3>> = Vec::new();
        curve_pieces(
            &parts.curves2[t.curve],
            t.span.start,
            t.span.end,
            &mut pieces,
        );
        let domain = surface.domain();
        let room = ROOM * self.size();
        let ends = |k: usize| t.span.lerp(k as f64 / count as f64);
        let mut first = 0;
        let boxes = (0..count).map(|k| {
            let (from, to) = (ends(k), ends(k + 1));
            while pieces.get(first).is_some_and(|p| p.map.end < from) {
                first += 1;
            }
            let own = pieces[first..].iter().take_while(|p| p.map.start <= to);
            let mut uv = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
            for p in own.flat_map(|p| &p.points) {
                for (c, range) in uv.iter_mut().enumerate() {
                    let x = p[c].mid / p[2].mid;
                    *range = [range[0].min(x), range[1].max(x)];
                }
            }
            let [u, v] = [0, 1].map(|c| uv[c].map(|x| x.clamp(domain[c].start, domain[c].end)));
            let corners = [[u[0], v[0]], [u[0], v[1]], [u[1], v[0]], [u[1], v[1]]];
            let corners = corners.map(|[u, v]| surface.point(u, v));
            widened(&around(&corners.map(box_of_point)), room)
        });
        Some(boxes.collect())
    }
}

fn box_of_point(p: Point3<f64>) -> Box3 {
    [0, 1, 2].map(|c| [p[c]; 2])
}

/// A box around a part of a curve, over [0, 1], by samples.
fn box_of(curve: impl Fn(f64) -> Point3<f64>) -> Box3 {
    let points: [_; SAMPLES + 1] = std::array::from_fn(|k| curve(k as f64 / SAMPLES as f64));
    let steps = points.windows(2).map(|w| (w[1] - w[0]).norm());
    let longest = steps.fold(0.0, f64::max);
    widened(&around(&points.map(box_of_point)), BENT * longest)
}

/// Bytes of those that have been made.
pub(super) fn bytes(boxes: &TrimBoxes) -> usize {
    let made = boxes.iter().filter_map(OnceLock::get);
    size_of_val(&**boxes) + made.map(PartBoxes::bytes).sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of any number of boxes those are found, in order, that a look at each finds.
    #[test]
    fn near_boxes_are_found_in_order() {
        for count in [0, 1, 24, 25, 64, 65, 512, 513, 5000] {
            let at = |k: usize| (k * 37 % 101) as f64;
            let own = |k: usize| [[at(k), at(k) + 0.5], [k as f64, k as f64], [0.0, 1.0]];
            let boxes = PartBoxes::new((0..count).map(own).collect());
            assert_eq!(boxes.count(), count);
            for [low, high] in [[3.0, 9.25], [100.0, 200.0], [50.0, 50.0], [-1.0, 1e9]] {
                let near = |b: &Box3| b[0][0] <= high && b[0][1] >= low && b[1][1] >= 20.0;
                let next = |from: usize| boxes.next(from, near).map(|(k, _)| k);
                let found: Vec<usize> = std::iter::successors(next(0), |k| next(k + 1)).collect();
                let all: Vec<usize> = (0..count).filter(|k| near(&own(*k))).collect();
                assert_eq!(found, all, "{count} {low}");
            }
        }
    }
}
