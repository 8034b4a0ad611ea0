//! What a search proved about a whole BREP, kept so that the next query, of a ball that has moved a little, need not prove it again.
//!
//! A *front* (Ehmann and Lin 2001 keep one of two hierarchies between frames) is a list of parts of a BREP, each with a distance, and one
//! distance `beyond` for all the rest, from a complete search about a centre `q`.
//!
//! # What is proven
//! Let `x*` be a point of the trimmed faces nearest to any other centre `c`. Then `x*` lies on a part of the list, no nearer to `q` than that
//! part's distance, or it is at least `beyond` from `q`; so it is no nearer to `c` than that distance less `|c - q|`.
//!
//! *Argument.* The search about `q` begins with parts that hold all faces, and does one of these with each part that it takes up:
//! - it cuts it into parts that hold it (a face into patches and boundary pieces, a box into halves);
//! - it puts it aside because it does not meet the region, or because what is there of a piece is off its patch: that hangs on no centre. By
//!   the list of cases in the module `search`, which holds for `c` as it does for `q`, the nearest point is found elsewhere too;
//! - it puts it aside, settles it, or leaves it waiting, by an argument about `q` (a bound, a slope, convexity, a closed form). Then it is
//!   written down with its lower bound of the squared distance from `q`, whatever else came of it. What the search makes of such a part for its
//!   own sake (a border towards which the distance falls, the boundary pieces of a face in closed form) is within the part and need not be.
//!
//! Thus the parts written down hold `x*`. Those with the least bounds are kept; `beyond` is the least bound of the others. The rest
//! is the triangle inequality. A search whose budget was spent gives no front.
//!
//! A query about `c` first goes down from the last foot, which gives an upper bound `d`. If `beyond - |c - q| > d` the front serves: only
//! parts nearer than `d` are looked at, by all the means of a search, and what is proven is as narrow as ever. Else the search
//! is that of a new query, and gives a new front.

use super::node::Node;
use super::objective::Objective;
use super::search::{Kind, Search, Source, Task};
use crate::numeric::Dd;
use crate::prepare::{Products, Quotient};
use nalgebra::Point3;
use std::collections::BinaryHeap;

/// How many parts are kept: more bear longer ways and cost more to keep.
const MOST: usize = 16;
/// How many parts a search writes down before it puts those aside that a front would not keep.
pub(super) const MOST_LEFT: usize = 1024;
/// Boxes with more coefficients than this (degree 7 by 7) are cut from their patch again at each query.
const MOST_KEPT: usize = 225;
/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;
/// Above the length of a vector whose square is lost for being tiny.
const TINY: f64 = 1e-150;

/// A part of a BREP that a search put aside.
#[derive(Clone, Copy, Debug)]
pub(super) enum Part {
    Face(usize),
    /// A whole patch or boundary piece.
    Root(Source),
    /// A box of one; and whether it is known to lie in the region.
    Box(Source, [f64; 2], [f64; 2], bool),
}

/// What a search put aside, with its lower bound of `f`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Left {
    pub(super) lo: Dd,
    pub(super) part: Part,
}

#[derive(Clone, Debug)]
struct Kept {
    /// No point of it is nearer to the front's centre.
    away: f64,
    part: Part,
    /// The products of a box, cut to it when it is first needed.
    products: Option<Products<f64>>,
}

/// See the [module](self).
#[derive(Clone, Debug, Default)]
pub(super) struct Front {
    /// The centre; `None` while nothing is known.
    center: Option<Point3<f64>>,
    parts: Vec<Kept>,
    beyond: f64,
}

impl Front {
    pub(super) fn forget(&mut self) {
        self.center = None;
        self.parts.clear();
    }

    /// Takes over what a search about `center` put aside.
    fn learn(&mut self, center: Point3<f64>, left: &mut Vec<Left>) {
        nearest(left);
        let (near, beyond) = match left.as_slice() {
            [near @ .., next] if near.len() == MOST => (near, distance(next.lo)),
            all => (all, f64::INFINITY),
        };
        self.center = Some(center);
        self.beyond = beyond;
        self.parts.clear();
        self.parts.extend(near.iter().map(|l| Kept {
            away: distance(l.lo),
            part: l.part,
            products: None,
        }));
    }
}

/// Keeps those parts alone that a front would: the nearest, and last the next one, whose bound stands for all that are farther.
pub(super) fn nearest(left: &mut Vec<Left>) {
    if left.len() > MOST {
        left.select_nth_unstable_by(MOST, |a, b| a.lo.hi.total_cmp(&b.lo.hi));
        left.truncate(MOST + 1);
    }
}

/// A f64 not above the root of a bound; the root itself is correctly rounded. (Bounds whose leading parts are the same are in no order, so
/// the lesser part of one may be that of another: the rounding down makes up for it.)
fn distance(squared: Dd) -> f64 {
    squared.hi.next_down().max(0.0).sqrt().next_down().max(0.0)
}

impl Search<'_> {
    /// Puts those parts of a front in line that may hold the nearest point; false where the front does not serve.
    pub(super) fn push_front(
        &mut self,
        heap: &mut BinaryHeap<Task<f64>>,
        front: &mut Front,
    ) -> bool {
        let (Objective::SquaredDistance(q), Some(center)) = (*self.objective, front.center) else {
            return false;
        };
        let moved = (q - center).norm() * UP + TINY;
        let reach = self.out.hi.ceil_f64().max(0.0).sqrt().next_up();
        // Negated: what is not a number serves nothing.
        if !((front.beyond - moved).next_down() > reach) {
            return false;
        }
        for kept in &mut front.parts {
            let away = (kept.away - moved).next_down();
            if away > reach {
                continue;
            }
            let lo = Dd::from((away.max(0.0) * away.max(0.0)).next_down().max(0.0));
            let (source, node, inside) = match kept.part {
                Part::Face(face) => {
                    self.push(heap, lo, true, Kind::Face(face));
                    continue;
                }
                Part::Root(source) => (source, self.root::<f64>(source), false),
                Part::Box(source, u, v, inside) => {
                    let node = self.kept_box(&q, source, [u, v], &mut kept.products);
                    (source, node, inside)
                }
            };
            let Some(mut node) = node else {
                self.push(heap, lo, true, Kind::Root(source));
                continue;
            };
            if lo > node.lo {
                node.lo = lo;
            }
            self.enqueue(heap, source, inside, node, true);
        }
        true
    }

    /// The node of a box.
    fn kept_box(
        &self,
        q: &Point3<f64>,
        source: Source,
        [u, v]: [[f64; 2]; 2],
        kept: &mut Option<Products<f64>>,
    ) -> Option<Node<f64>> {
        let (net, whole) = self.basis::<f64>(source)?;
        let cut = |own: &mut Option<Products<f64>>| -> Option<Node<f64>> {
            let products = match own {
                Some(products) => products,
                None => own.insert(whole.restricted(u, v)?),
            };
            let f = Quotient::squared_distance(q, net, products);
            Some(Node::over(f, u, v, true))
        };
        if whole.degree.count() > MOST_KEPT {
            return cut(&mut None);
        }
        cut(kept)
    }

    /// Makes a front of what a search put aside; where its budget was spent, then or later, `minimize` forgets it again.
    pub(super) fn keep_front(&mut self, front: &mut Front) {
        front.forget();
        if let Objective::SquaredDistance(q) = *self.objective {
            front.learn(q, &mut self.memory.left);
        }
    }
}
