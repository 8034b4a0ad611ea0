//! What is kept of boxes that no convexity settles: where a minimum on them is, and how far it may reach.

use super::outcome::{Settled, Source, Spread};
use super::search::Search;
use crate::numeric::Dd;
use crate::prepare::closed::Extent;
use crate::trim::BoxSide;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

impl Search<'_> {
    /// Evaluates a piece where it passes the border of its patch, and next to it on both sides: on the border itself it may not be known to be on it.
    pub(super) fn try_end(&mut self, source: Source, at: f64) {
        for t in [at, at - f64::EPSILON, at + f64::EPSILON] {
            if (0.0..=1.0).contains(&t) {
                self.try_point(source, [Dd::from(t), Dd::ZERO], false);
            }
        }
    }

    /// Keeps a part of a piece on which all values are within the width wanted, where some of it is known to be on its patch.
    pub(super) fn settle_level(&mut self, source: Source, u: [f64; 2], lo: Dd) -> bool {
        let Source::Piece { face, index } = source else {
            return false;
        };
        let Some((at, part)) = self.rest_on_patch((face, index), u) else {
            return false;
        };
        self.lower(lo);
        self.try_end(source, at);
        self.out.settled.push(Settled {
            face: source.face(),
            source: Some(source),
            lo,
            at: [at, 0.0],
            spread: Some(Spread::Within([u, [0.0; 2]])),
            extent: self.length(face, index, part),
            local_minimum: true,
            on_border: false,
            flat: false,
        });
        true
    }

    /// The extent of a minimum on a box of a patch that is not convex: infinite, unless the region has but a small part of the box (next to a trim that touches a
    /// border of patches, say).
    fn extent_in_region(&self, face: usize, index: usize, ranges: [[f64; 2]; 2]) -> Extent {
        /// Up to this part of the box.
        const STEPS: u32 = 16;
        let mut part = ranges;
        let outside =
            |b: &[[f64; 2]; 2]| self.classify(face, index, b[0], b[1]) == BoxSide::Outside;
        if outside(&part) {
            return Extent::Root(0.0);
        }
        for (k, end) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            // What lies between this end and here is outside.
            let mut here = part[k][end];
            let mut far = part[k][1 - end];
            for _ in 0..STEPS {
                let middle = 0.5 * (here + far);
                let mut cut = part;
                cut[k][1 - end] = middle;
                if outside(&cut) {
                    here = middle;
                } else {
                    far = middle;
                }
            }
            part[k][end] = here;
        }
        let speeds = self.brep.double(face).patch_speeds(index);
        let length =
            |b: &[[f64; 2]; 2]| -> f64 { (0..2).map(|k| speeds[k] * (b[k][1] - b[k][0])).sum() };
        let (own, whole) = (length(&part), length(&ranges));
        if own < 0.5 * whole {
            Extent::Linear {
                slope: 0.0,
                length: own * UP,
            }
        } else {
            Extent::Root(f64::INFINITY)
        }
    }

    /// The extent of a minimum on a part of a piece that is not convex, where its neighbours are other parts.
    fn length(&self, face: usize, index: usize, [a, b]: [f64; 2]) -> Extent {
        let [speed, _] = self.brep.double(face).piece_speeds(index);
        Extent::Linear {
            slope: 0.0,
            length: speed * (b - a) * UP,
        }
    }

    /// Keeps a node that no convexity settles, for the extent of the minimum.
    pub(super) fn settle_unshaped(&mut self, source: Source, u: [f64; 2], v: [f64; 2], lo: Dd) {
        let mut at = [0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])];
        let point = u[0] == u[1] && v[0] == v[1];
        let mut extent = Extent::Root(if point { 0.0 } else { f64::INFINITY });
        let mut local_minimum = true;
        match source {
            _ if point => {}
            Source::Piece { face, index } if !self.brep.double(face).piece(index).stays(u) => {
                // One that only touches its patch from without does so on the patch's border, which is searched too.
                let rest = self.rest_on_patch((face, index), u);
                let (t, part) = rest.unwrap_or((at[0], u));
                at = [t, 0.0];
                extent = self.length(face, index, part);
                local_minimum = rest.is_some();
            }
            _ => {
                // Only where it comes to rest can be a minimum to report.
                if self.goal.all_below.is_some() {
                    at = self.descend(source, at, [u, v]);
                }
                if let Source::Patch { face, index } = source {
                    extent = self.extent_in_region(face, index, [u, v]);
                }
            }
        }
        self.out.settled.push(Settled {
            face: source.face(),
            source: Some(source),
            lo,
            at,
            spread: Some(Spread::Within([u, v])),
            extent,
            local_minimum,
            on_border: false,
            flat: false,
        });
    }
}
