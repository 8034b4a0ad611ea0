//! A BREP and a segment or a capsule: balls along a line.
//!
//! The separation is the least of `d(p) - r` over the points p of the axis, d the signed distance. d changes by no
//! more than the way between two points, so d at the middle of a piece less half its length is below d on all of it: pieces are
//! halved, the lowest first, until the least bound is within [`TOLERANCE`] of the axis's length below that of the least value found, or the
//! pieces are used up. The enclosure is certified either way; where the axis runs along a face it is as wide as the pieces are long,
//! and told as undecided.

use crate::ball::{ball_at, nothing_known, separation_at};
use crate::pair::{Ask, Memory, PairAnswer};
use crate::pose::{Placed, up};
use crate::shape::BrepShape;
use feeler::numeric::Enclosure;
use feeler::query::{Separation, Undecided};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::PackedFeatureId;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Width of the enclosure beyond that of a ball's, in lengths of the axis.
const TOLERANCE: f64 = 1.0 / (1u64 << 10) as f64;
/// Most points of the axis that are asked about.
const MOST: usize = 600;

/// The pieces from `middle - half` to `middle + half`, as parts of the axis.
struct Piece {
    lowest: f64,
    middle: f64,
    half: f64,
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Piece {}
impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        // The lowest first in a heap that gives the largest.
        let by_bound = other.lowest.total_cmp(&self.lowest);
        by_bound.then(other.middle.total_cmp(&self.middle))
    }
}

pub(crate) fn along(
    shape: &BrepShape,
    ask: &Ask<'_>,
    [a, b]: [Vector; 2],
    radius: f64,
    memory: &mut Memory,
) -> PairAnswer {
    let (a, b) = (ask.placement.to_brep(a), ask.placement.to_brep(b));
    let axis = b.point - a.point;
    let length = up(axis.length());
    let bound = up(a.bound.max(b.bound) + f64::EPSILON * (a.point.length() + length));
    if !(bound + length).is_finite() {
        shape.note_undecided();
        return nothing_known();
    }
    // A point of the true axis is within the larger bound of the ends from that of the rounded one.
    let at = |t: f64| Placed {
        point: a.point + axis * t,
        bound,
    };
    let mut lookup = |t: f64| separation_at(shape, at(t), radius, memory);
    let first = lookup(0.5);
    let (mut best, mut best_at) = (first, 0.5);
    let mut heap = BinaryHeap::from([Piece {
        lowest: (first.bounds.lo - 0.5 * length).next_down(),
        middle: 0.5,
        half: 0.5,
    }]);
    let (mut asked, mut lo) = (1, f64::NEG_INFINITY);
    while let Some(piece) = heap.pop() {
        lo = piece.lowest.max(lo);
        // Rounded down as `lowest` is: an axis of no length has no more to tell than its point.
        if best.bounds.lo.next_down() - lo <= TOLERANCE * length || asked >= MOST {
            break;
        }
        let half = 0.5 * piece.half;
        for middle in [piece.middle - half, piece.middle + half] {
            let here = lookup(middle);
            asked += 1;
            if here.value < best.value {
                (best, best_at) = (here, middle);
            }
            heap.push(Piece {
                // What its parent proved holds for it, too.
                lowest: (here.bounds.lo - half * length)
                    .next_down()
                    .max(piece.lowest),
                middle,
                half,
            });
        }
    }
    let mut ends = Vec::new();
    for (t, code) in [(0.0, 0), (1.0, 1)] {
        let here = lookup(t);
        if here.value < best.value {
            (best, best_at) = (here, t);
        }
        ends.push((t, PackedFeatureId::vertex(code), here.value));
    }
    let separation = Separation {
        value: best.value,
        bounds: Enclosure {
            lo: lo.min(best.bounds.lo),
            hi: best.bounds.hi,
        },
    };
    let own = best.bounds.width().max(shape.accuracy());
    let settled = separation.bounds.width() <= (TOLERANCE * length + own).next_up();
    if !settled {
        shape.note_undecided();
    }
    let single = Ask {
        placement: ask.placement,
        prediction: ask.prediction,
        several: false,
    };
    let mut places = vec![(best_at, PackedFeatureId::edge(0))];
    if ask.several {
        // Places nearer to each other than they are known to are one.
        let near = |e: &&(f64, PackedFeatureId, f64)| {
            let apart = (e.0 - best_at).abs();
            e.2 <= ask.prediction && apart > TOLERANCE && apart * length > bound
        };
        places.extend(ends.iter().filter(near).map(|e| (e.0, e.1)));
    }
    let mut contacts = Vec::new();
    for (t, feature) in places {
        let found = ball_at(shape, &single, at(t), radius, feature, memory);
        contacts.extend(found.contacts.first().copied());
    }
    PairAnswer {
        separation,
        contacts,
        continuum: false,
        undecided: (!settled).then_some(Undecided::Budget),
    }
}
