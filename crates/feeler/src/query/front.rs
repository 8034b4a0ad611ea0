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
//!   own sake (a border towards which the distance falls, the boundary pieces of a face in closed form, all of one on a sphere) is within the part and need not be.
//!
//! Thus the parts written down hold `x*`. Those with the least bounds are kept; `beyond` is the least bound of the others. The rest
//! is the triangle inequality. A search whose budget was spent gives no front.
//!
//! A query about `c` first goes down from the last foot, which gives an upper bound `d`. If `beyond - |c - q| > d` the front serves: only
//! parts nearer than `d` are looked at, by all the means of a search, and what is proven is as narrow as ever. Else the search
//! is that of a new query, and gives a new front.
//!
//! Nor is a part looked at that was farther away than `d` when it was last looked at by more than the ball has gone since: one comparison each tells that (see [`Front`]).
//!
//! # What a front learns
//! A part keeps a centre of its own, the last about which its bound grew: any centre will do, since each part is bounded by itself. A box
//! is put aside for good where it does not meet the region, and is replaced by its halves where nothing settles it whole: both leave `x*` in
//! a part of the list. (Boundary pieces alone stand for points on trims; a box of a patch for those within the region.) A piece that may leave its
//! patch (to f64, one along the patch's border may) is left as it is.
//!
//! What settled a box about one centre often does so about the next: that `f` falls along u or v everywhere on it, or that `G` is strictly
//! convex. Both rest on differences of coefficients, which change little with the centre (module `steady`), so no coefficient is looked at
//! again. What follows from them is what the search makes of it (cases *monotone* and *no critical point in the region* of the
//! module `search`): the border of the patch that the box touches is searched, as a part that learns as others do, or the leaf is proven at the new foot (a box that a trim crosses takes sides
//! there at each query; where none of its critical points is in the region all borders of the patch that it touches are searched); where
//! the foot is elsewhere, a place on the box that was kept mostly tells that it is far (module `foothold`).

use super::foothold::Foothold;
use super::leaf::Cell;
use super::node::{Node, on_borders, whole};
use super::objective::Objective;
use super::outcome::Source;
use super::search::{NOISE_FACTOR, Search, least_squared, split_along_u};
use super::shape::Shape;
use super::steady::{Asked, Steady};
use super::task::{Kind, Task};
use crate::numeric::Dd;
use crate::numeric::bernstein::{greater, lesser};
use crate::prepare::{Net, Products, Quotient, jet, least_squared_distance};
use crate::trim::BoxSide;
use nalgebra::Point3;
use std::collections::BinaryHeap;

/// How many steps, by about the Hessian that a convex box has, a place on it is worth before the last digits are looked for.
const MOST_STEPS: usize = 3;
/// The box in space of what may be anywhere.
const EVERYWHERE: [[f64; 2]; 3] = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
/// How many parts are kept: more bear longer ways and cost more to keep...
pub(super) const MOST: usize = 32;
/// ...and where the front before has served fewer queries than these: the way may be a short one.
const FIRST: usize = 16;
const FEW: u32 = 16;
/// How many they may become.
const MOST_PARTS: usize = 128;
/// So many are looked over at once: an index among them is a byte.
const BLOCK: usize = 128;
/// A front that has become so many is made anew, if it has served so many queries.
const LONG_SERVICE: u32 = 64;
/// Boxes are not cut below this width in local parameters: cut from its patch, a box has the patch's errors.
const NARROW: f64 = 1.0 / (1u64 << 8) as f64;
/// How many parts a search writes down before it puts those aside that a front would not keep.
pub(super) const MOST_LEFT: usize = 1024;
/// Boxes with more coefficients than this (degree 7 by 7) are cut from their patch again at each query, and nothing is learnt of them.
const MOST_KEPT: usize = 225;
/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;
const DOWN: f64 = 1.0 - 32.0 * f64::EPSILON;
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

/// What is known of where a part is.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// No point of it is nearer than `away` to this: the front's centre, or one that it was looked at from since.
    center: Point3<f64>,
    away: f64,
    /// A box in space that holds it.
    hull: [[f64; 2]; 3],
}

#[derive(Clone, Debug)]
struct Kept {
    known: Known,
    part: Part,
    /// The products of a box, cut to it when it is first needed.
    products: Option<Box<Products<f64>>>,
    /// What settles it, if that is known.
    settling: Option<Box<Settling>>,
    /// Whether nothing settles it, or what was found did not at once: it is left to the search.
    barren: bool,
    /// Where a box of a patch lies, once that was asked.
    side: Option<BoxSide>,
}

/// Why a box holds no minimum but one that is known or searched for elsewhere, while the ball is nearby.
#[derive(Clone, Debug)]
struct Settling {
    steady: Steady,
    why: Why,
}

#[derive(Clone, Debug)]
enum Why {
    /// `f` has one sign of its derivative along u or v; with the border of the patch towards which it falls, where the box touches it: a part in its turn.
    Falls { sign: i8, border: Option<Box<Kept>> },
    /// `G` is strictly convex; with about where `f` was least, once it was not next to the nearest point, and the borders of the patch that the box touches, once no critical
    /// point within was found to be in the region.
    Convex(Option<Foothold>, Option<Vec<Kept>>),
}

/// See the [module](self).
#[derive(Clone, Debug, Default)]
pub(super) struct Front {
    /// The centre; `None` while nothing is known.
    center: Option<Point3<f64>>,
    parts: Vec<Kept>,
    beyond: f64,
    /// Where the ball was last, and how long its way from query to query was since the front was made, at most.
    last: Point3<f64>,
    travel: f64,
    /// Of each part: no point of it is nearer to where the ball is than this less `travel`.
    ///
    /// What was `a` away at least when the way was `t` long is `a - (t' - t)` away when it is `t'`: `a + t` is kept, so that one comparison
    /// passes over what cannot have come near since it was last looked at.
    clear: Vec<f64>,
    /// Of each part, too, what it knows: this is looked at most, and lies together.
    known: Vec<Known>,
    served: u32,
}

impl Kept {
    /// One that is no nearer than `away` to a centre.
    fn new(center: Point3<f64>, away: f64, part: Part) -> Self {
        let hull = EVERYWHERE;
        Self {
            known: Known { center, away, hull },
            part,
            products: None,
            settling: None,
            barren: false,
            side: None,
        }
    }

    /// Takes over a bound of the squared distance about `q`, where `least` is what is known.
    fn learn(&mut self, q: &Point3<f64>, least: f64, bound: Dd) {
        if bound.hi > least {
            (self.known.center, self.known.away) = (*q, distance(bound));
        }
    }
}

impl Known {
    /// No squared distance of it from a centre is less than this. (Which of the three tells most is as good as random: no branch hangs on it.)
    ///
    /// For a point `x` of the hull, `|x - c|^2 = |x - q|^2 - 2 d.(x - q) + |d|^2` with `d = c - q`: about a centre that has moved a little the
    /// bound moves as the distance of what is nearby does; of a large hull the triangle inequality says more, and after a long way the hull alone.
    fn least(&self, c: &Point3<f64>) -> f64 {
        let away = greater(self.away - moved(c, &self.center), 0.0) * DOWN;
        let least = greater(away * away * DOWN - TINY, 0.0);
        let least = greater(least, self.least_of_hull(c));
        greater(least, least_squared(&self.hull, c))
    }

    /// What the hull says of it with what is known about the first centre. The square of `away` is off by half a rounding of itself, which is part of `size`.
    /// (It is no number where all is within the hull.)
    fn least_of_hull(&self, c: &Point3<f64>) -> f64 {
        let square = self.away * self.away;
        let (mut sum, mut size) = (square, square);
        for (k, own) in self.hull.iter().enumerate() {
            let q = self.center[k];
            let d = c[k] - q;
            let x = if d > 0.0 { own[1] } else { own[0] };
            let term = d * (d - 2.0 * (x - q));
            sum += term;
            size += term.abs() + d * d;
        }
        sum - 32.0 * f64::EPSILON * size - TINY
    }
}

/// How far two points are from each other at most.
fn moved(a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    (a - b).norm() * UP + TINY
}

/// What `clear` is of a part no squared distance of which is less than this, after so long a way.
fn clear_of(least: f64, travel: f64) -> f64 {
    (root(least) + travel) * DOWN
}

impl Front {
    pub(super) fn forget(&mut self) {
        self.center = None;
        self.parts.clear();
        self.clear.clear();
        self.known.clear();
    }

    /// Those parts that may be as near as `reach` to where the ball is, or have a value below `hi` there: by the way that it has gone, then by what is known of them.
    ///
    /// Which these are is as good as random: nothing hangs on a branch here.
    fn near(&mut self, q: &Point3<f64>, reach: f64, hi: f64, near: &mut Vec<(usize, f64)>) {
        let travel = self.travel;
        let limit = (reach + travel).next_up();
        near.clear();
        let blocks = self.clear.chunks_mut(BLOCK).zip(self.known.chunks(BLOCK));
        for (block, (clear, known)) in blocks.enumerate() {
            let mut some = [0u8; BLOCK];
            let mut count = 0;
            // Negated: of what is no number nothing is known.
            let mut look = |index: usize, clear: f64| {
                some[count % BLOCK] = index as u8;
                count += usize::from(!(clear > limit));
            };
            let (fours, rest) = clear.as_chunks::<4>();
            for (k, four) in fours.iter().enumerate() {
                look(4 * k, four[0]);
                look(4 * k + 1, four[1]);
                look(4 * k + 2, four[2]);
                look(4 * k + 3, four[3]);
            }
            for (k, own) in rest.iter().enumerate() {
                look(4 * fours.len() + k, *own);
            }
            let mut end = near.len();
            near.resize(end + count, (0, 0.0));
            for index in some.iter().take(count) {
                let index = usize::from(*index);
                let least = known[index].least(q);
                let far = least > hi;
                let own = &mut clear[index];
                *own = if far { clear_of(least, travel) } else { *own };
                near[end] = (block * BLOCK + index, least);
                end += usize::from(!far);
            }
            near.truncate(end);
        }
    }

    /// Leaves out those parts that nothing needs to look at again.
    fn leave_out(&mut self) {
        for index in (0..self.clear.len()).rev() {
            if self.clear[index] == f64::INFINITY {
                self.parts.swap_remove(index);
                self.clear.swap_remove(index);
                self.known.swap_remove(index);
            }
        }
    }

    /// Takes over what a search about `center` put aside.
    fn learn(&mut self, center: Point3<f64>, left: &mut Vec<Left>) {
        let most = if self.served < FEW { FIRST } else { MOST };
        nearest(left, most);
        let (near, beyond) = match left.as_slice() {
            [near @ .., next] if near.len() == most => (near, distance(next.lo)),
            all => (all, f64::INFINITY),
        };
        self.center = Some(center);
        self.beyond = beyond;
        (self.last, self.travel, self.served) = (center, 0.0, 0);
        self.clear.clear();
        self.clear.extend(near.iter().map(|l| distance(l.lo)));
        self.parts.clear();
        self.parts.extend(
            near.iter()
                .map(|l| Kept::new(center, distance(l.lo), l.part)),
        );
        self.known.clear();
        self.known.extend(self.parts.iter().map(|kept| kept.known));
    }
}

/// Keeps those parts alone that a front of so many would: the nearest, and last the next one, whose bound stands for all that are farther.
pub(super) fn nearest(left: &mut Vec<Left>, most: usize) {
    if left.len() > most {
        left.select_nth_unstable_by(most, |a, b| a.lo.hi.total_cmp(&b.lo.hi));
        left.truncate(most + 1);
    }
}

/// A f64 not above the root of a bound; the root itself is correctly rounded. (Bounds whose leading parts are the same are in no order, so
/// the lesser part of one may be that of another: the rounding down makes up for it.)
fn distance(squared: Dd) -> f64 {
    root(squared.hi)
}

/// The same of a number.
fn root(squared: f64) -> f64 {
    // What is no number is nothing.
    lesser(greater(0.0, squared), f64::MAX).sqrt() * DOWN
}

/// What a look at a part came to.
enum Insight {
    /// By this bound it holds no nearest point.
    Far(Dd),
    /// It does not meet the region.
    Outside,
    /// Something settles it now.
    Settles,
    /// Its halves are to be looked at.
    Halves(Box<[Kept; 2]>),
    /// All is done.
    Done,
}

/// What is made of a part for a query.
enum Found {
    /// There are no products of it.
    Nothing,
    /// Nothing: by this bound it holds no nearest point.
    Far(Dd),
    Node(Box<Node<f64>>),
}

/// What settles a node of a part, if its derivatives do, and what is to be asked about other centres; with what settled it about another, if anything did.
fn settling_of(
    node: &Node<f64>,
    shape: &Shape,
    products: &Products<f64>,
    (source, inside): (Source, bool),
    known: (Point3<f64>, f64),
    before: Option<&mut Settling>,
) -> Option<(Asked, Why)> {
    let touches = |k: usize| {
        let range = if k == 0 { node.u } else { node.v };
        match shape.monotone[k] {
            1 => range[0] == 0.0,
            _ => range[1] == 1.0,
        }
    };
    let falls = |k: &usize| shape.monotone[*k] != 0;
    let along = (0..2).find(|k| falls(k) && !touches(*k));
    let Some(along) = along.or((0..2).find(falls)) else {
        // Where it was least is still near.
        let (known, borders) = match before {
            Some(Settling {
                why: Why::Convex(foothold, borders),
                ..
            }) => (foothold.take(), borders.take()),
            _ => (None, None),
        };
        return (shape.convexity > 0.0).then_some((Asked::Seconds, Why::Convex(known, borders)));
    };
    let sign = shape.monotone[along];
    let asked = Asked::Slope(along);
    // The border is the same, and what is known of it.
    if let Some(Settling {
        steady,
        why: Why::Falls { sign: own, border },
    }) = before
        && *own == sign
        && steady.asked() == asked
    {
        let border = border.take();
        return Some((asked, Why::Falls { sign, border }));
    }
    let border = touches(along).then(|| {
        let ranges = [node.u, node.v];
        let kept = border_of((source, ranges, inside), products, known, (along, sign < 0));
        Box::new(kept)
    });
    Some((asked, Why::Falls { sign, border }))
}

/// A side of a box, across u (0) or v, as a part of its own.
fn border_of(
    (source, ranges, inside): (Source, [[f64; 2]; 2], bool),
    products: &Products<f64>,
    (center, away): (Point3<f64>, f64),
    (along, high): (usize, bool),
) -> Kept {
    let [u, v] = std::array::from_fn(|k| match k == along {
        true => [ranges[k][usize::from(high)]; 2],
        false => ranges[k],
    });
    Kept {
        products: Some(Box::new(products.border(along == 0, high))),
        ..Kept::new(center, away, Part::Box(source, u, v, inside))
    }
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
        let reach = self.out.hi.ceil_f64().max(0.0).sqrt().next_up();
        // Negated: what is not a number serves nothing.
        if !((front.beyond - moved(&q, &center)).next_down() > reach) {
            return false;
        }
        front.travel = (front.travel + moved(&q, &front.last)).next_up();
        front.last = q;
        front.served = front.served.saturating_add(1);
        // (A front serves where the least value alone is asked for: what is no nearer than the best point so far is of no use.)
        let mut todo = std::mem::take(&mut self.memory.todo);
        front.near(&q, reach, self.out.hi.hi, &mut todo);
        let mut gone = 0;
        let mut next = 0;
        while let Some(&(index, least)) = todo.get(next) {
            next += 1;
            let room = front.clear.len() < MOST_PARTS && self.out.nodes < self.goal.budget;
            let kept = &mut front.parts[index];
            match self.take_up(heap, &q, kept, (least, room)) {
                Insight::Far(lo) => front.clear[index] = clear_of(lo.hi, front.travel),
                Insight::Settles | Insight::Done => front.known[index] = kept.known,
                Insight::Outside => {
                    front.clear[index] = f64::INFINITY;
                    gone += 1;
                }
                Insight::Halves(halves) => {
                    let [low, high] = *halves;
                    *kept = low;
                    front.known[index] = kept.known;
                    let least = |own: &Kept| own.known.least(&q);
                    todo.push((index, least(kept)));
                    todo.push((front.parts.len(), least(&high)));
                    front.clear.push(f64::NEG_INFINITY);
                    front.known.push(high.known);
                    front.parts.push(high);
                }
            }
        }
        self.memory.todo = todo;
        if gone > 0 {
            front.leave_out();
        }
        if front.parts.len() >= MOST_PARTS && front.served >= LONG_SERVICE {
            front.forget();
        }
        true
    }

    /// Settles a part, or puts it in line, unless it is too far to be of use.
    fn take_up(
        &mut self,
        heap: &mut BinaryHeap<Task<f64>>,
        q: &Point3<f64>,
        kept: &mut Kept,
        (least, room): (f64, bool),
    ) -> Insight {
        if self.hopeless(Dd::from(least)) {
            return Insight::Far(Dd::from(least));
        }
        let first = self.look_at(heap, q, kept, (least, room, false));
        match first {
            Insight::Settles => self.look_at(heap, q, kept, (least, room, true)),
            _ => first,
        }
    }

    fn look_at(
        &mut self,
        heap: &mut BinaryHeap<Task<f64>>,
        q: &Point3<f64>,
        kept: &mut Kept,
        (least, room, fresh): (f64, bool, bool),
    ) -> Insight {
        let lo = Dd::from(least);
        if lo >= self.enough() {
            self.out.left_open = true;
            self.lower(lo);
            return Insight::Done;
        }
        let (source, [u, v], inside) = match kept.part {
            // It counts when it is opened.
            Part::Face(face) => {
                let own = self.brep.face_box(face).map(|b| self.box_bound(b));
                let lo = own.filter(|own| *own > lo).unwrap_or(lo);
                kept.learn(q, least, lo);
                if !self.hopeless(lo) {
                    self.push(heap, lo, true, Kind::Face(face));
                }
                return Insight::Done;
            }
            Part::Root(source) => {
                let degree = self.basis::<f64>(source).map(|b| b.1.degree);
                (source, degree.map_or([[0.0; 2]; 2], whole), false)
            }
            Part::Box(source, u, v, inside) => (source, [u, v], inside),
        };
        self.out.nodes += 1;
        if let Some(settling) = &mut kept.settling {
            let at = (source, inside, [u, v], lo);
            let known = (kept.known.center, kept.known.away);
            let own = (kept.products.as_deref(), known);
            if let Some(bound) = self.settle_kept(heap, q, at, own, settling) {
                kept.learn(q, least, bound);
                return Insight::Done;
            }
            // (What held about another centre is of use for what holds about this one.)
            if fresh {
                kept.settling = None;
                kept.barren = true;
            }
        }
        let mut node = match self.kept_box(q, source, [u, v], kept) {
            Found::Nothing => {
                self.push(heap, lo, true, Kind::Root(source));
                return Insight::Done;
            }
            Found::Far(bound) => {
                kept.learn(q, least, bound);
                return Insight::Done;
            }
            Found::Node(node) => node,
        };
        kept.learn(q, least, node.lo);
        if lo > node.lo {
            node.lo = lo;
        }
        if self.hopeless(node.lo) {
            self.memory.put_back(node);
            return Insight::Done;
        }
        let insight = if node.lo >= self.enough() {
            Insight::Done
        } else {
            self.look_into(q, source, &node, kept, room)
        };
        if let Insight::Done = insight {
            // The best point so far may be of another part, far above all of this one, with which nothing settles it (values that are all one, above all).
            let ranges = [node.u, node.v];
            if self.best_on(source, ranges).is_none() {
                self.look_down(source, node.guess(), (ranges, node.lo.hi));
            }
            self.enqueue(heap, source, inside, node, true);
        } else {
            self.memory.put_back(node);
        }
        insight
    }

    /// The node of a part, if it may hold the nearest point.
    fn kept_box(
        &mut self,
        q: &Point3<f64>,
        source: Source,
        [u, v]: [[f64; 2]; 2],
        kept: &mut Kept,
    ) -> Found {
        let Some((net, all)) = self.basis::<f64>(source) else {
            return Found::Nothing;
        };
        let cut;
        let is_whole = [u, v] == whole(all.degree);
        let is_kept = !is_whole && all.degree.count() <= MOST_KEPT;
        let products = if is_whole {
            all
        } else if let (true, Some(products)) = (is_kept, &kept.products) {
            products
        } else {
            let Some(own) = all.restricted(u, v) else {
                return Found::Nothing;
            };
            if is_kept {
                kept.products.insert(Box::new(own))
            } else {
                cut = own;
                &cut
            }
        };
        if kept.known.hull == EVERYWHERE {
            kept.known.hull = products.hull(&net.origin).unwrap_or(EVERYWHERE);
            let bound = least_squared(&kept.known.hull, q);
            if self.hopeless(Dd::from(bound)) {
                return Found::Far(Dd::from(bound));
            }
        }
        if net.unit_weights {
            let bound = Dd::from(least_squared_distance(q, net, products));
            if self.hopeless(bound) {
                return Found::Far(bound);
            }
        }
        Found::Node(self.node_over(q, (net, products), [u, v]))
    }

    /// The node over a box with its products.
    fn node_over(
        &mut self,
        q: &Point3<f64>,
        (net, products): (&Net<f64>, &Products<f64>),
        [u, v]: [[f64; 2]; 2],
    ) -> Box<Node<f64>> {
        let mut node = self.memory.spare_node();
        let spare = std::mem::replace(&mut node.f, Quotient::BLANK);
        let f = spare.made_squared_distance(q, net, products);
        *node = Node::over(f, u, v, true);
        node
    }

    /// What can be learnt of a part that may hold the nearest point, for the queries to come and for this one.
    fn look_into(
        &self,
        q: &Point3<f64>,
        source: Source,
        node: &Node<f64>,
        kept: &mut Kept,
        room: bool,
    ) -> Insight {
        let shortcuts = self.brep.shortcuts();
        let wanted = shortcuts.monotone_borders && shortcuts.convex_leaves;
        if kept.barren {
            return Insight::Done;
        }
        let basis = self.basis::<f64>(source);
        let Some((net, all)) = basis.filter(|b| wanted && b.1.degree.count() <= MOST_KEPT) else {
            return Insight::Done;
        };
        match source {
            Source::Piece { face, index } => {
                if !self.brep.double(face).piece(index).stays(node.u) {
                    return Insight::Done;
                }
            }
            Source::Patch { face, index } => {
                let known = matches!(kept.part, Part::Box(_, _, _, true));
                let ask = || match known {
                    true => BoxSide::Inside,
                    false => self.classify(face, index, node.u, node.v),
                };
                match *kept.side.get_or_insert_with(ask) {
                    BoxSide::Outside => return Insight::Outside,
                    BoxSide::Inside => kept.part = Part::Box(source, node.u, node.v, true),
                    BoxSide::Mixed => {}
                }
            }
        }
        let mixed = kept.side == Some(BoxSide::Mixed);
        let inside = matches!(kept.part, Part::Box(_, _, _, true));
        let known = (kept.known.center, kept.known.away);
        let products = kept.products.as_deref().unwrap_or(all);
        let tau = self.out.hi.hi;
        // That it falls is enough.
        let bends = node.bends_unless(tau, |monotone| monotone != [0; 2]);
        let shape = bends.told();
        let mut before = kept.settling.take();
        let found = settling_of(
            node,
            &shape,
            products,
            (source, inside),
            known,
            before.as_deref_mut(),
        );
        if let Some((asked, why)) = found {
            let old = before.as_deref().map(|b| &b.steady);
            let steady = Steady::new(asked, node, (net, products), q, (tau, bends), old);
            let settling = Settling { steady, why };
            kept.settling = Some(match before {
                Some(mut room) => {
                    *room = settling;
                    room
                }
                None => Box::new(settling),
            });
            return Insight::Settles;
        }
        let wide = (node.u[1] - node.u[0]).max(node.v[1] - node.v[0]);
        let noise = shape.g_largest <= NOISE_FACTOR * shape.g_error;
        let is_cut = room && !noise && wide > NARROW;
        let (true, Some(along_u)) = (is_cut, split_along_u(node, &shape)) else {
            kept.barren = true;
            return Insight::Done;
        };
        // Where a whole lies its halves do, unless a trim crosses it.
        let whole = kept.side.filter(|_| !mixed);
        let mut low = products.clone();
        let high = low.split(along_u);
        let halves = [(false, low), (true, high)].map(|(high, own)| {
            let half = |r: [f64; 2]| {
                let middle = 0.5 * (r[0] + r[1]);
                if high { [middle, r[1]] } else { [r[0], middle] }
            };
            let (u, v) = if along_u {
                (half(node.u), node.v)
            } else {
                (node.u, half(node.v))
            };
            Kept {
                products: Some(Box::new(own)),
                side: whole,
                ..Kept::new(known.0, known.1, Part::Box(source, u, v, inside))
            }
        });
        Insight::Halves(Box::new(halves))
    }

    /// Does with a box what `visit` would, if what settled it about another centre does so about this one; a bound of `f` on it.
    fn settle_kept(
        &mut self,
        heap: &mut BinaryHeap<Task<f64>>,
        q: &Point3<f64>,
        (source, inside, [u, v], lo): (Source, bool, [[f64; 2]; 2], Dd),
        (products, center): (Option<&Products<f64>>, (Point3<f64>, f64)),
        settling: &mut Settling,
    ) -> Option<Dd> {
        let tau = self.out.hi.hi;
        let steady = &settling.steady;
        match &mut settling.why {
            Why::Falls { sign, border } => {
                if !steady.falls(*sign, q, tau) {
                    return None;
                }
                if let Some(kept) = border {
                    let least = kept.known.least(q);
                    if let Insight::Outside = self.take_up(heap, q, kept, (least, false)) {
                        *border = None;
                    }
                }
                Some(lo)
            }
            Why::Convex(foothold, borders) => {
                let shape = steady.shape(q, tau).filter(|s| s.convexity > 0.0)?;
                let mut cell = Cell::<f64> {
                    u,
                    v,
                    lo,
                    degree: steady.degree(),
                    constant: steady.is_polynomial(),
                    node: None,
                    near: None,
                };
                let (net, all) = self.basis::<f64>(source)?;
                let best_on = self.best_on(source, [u, v]).is_some();
                if !best_on && jet::fits(net.degree) {
                    // Where it was, or else some steps on from there, mostly tells that it is far still.
                    let middle = [u, v].map(|r| 0.5 * (r[0] + r[1]));
                    let known = foothold.get_or_insert_with(|| Foothold::new(net, middle));
                    for steps in 0..=MOST_STEPS {
                        let bound = Dd::from(known.least(q, &cell, (&shape, tau)));
                        if self.hopeless(bound) {
                            return Some(bound);
                        }
                        if steps < MOST_STEPS {
                            *known = Foothold::new(net, known.step(q, &cell, steady.bend()));
                        }
                    }
                    cell.near = Some(known.at);
                }
                let leaf = self.leaf(heap, source, inside, &cell, (&shape, Dd::from(tau)))?;
                if leaf.none_in_region {
                    let own = products.unwrap_or(all);
                    let at = (source, [u, v], inside);
                    let make = |side| border_of(at, own, center, side);
                    let sides = || on_borders([u, v]).map(make).collect();
                    let sides = borders.get_or_insert_with(sides);
                    sides.retain_mut(|side| {
                        let least = side.known.least(q);
                        !matches!(
                            self.take_up(heap, q, side, (least, false)),
                            Insight::Outside
                        )
                    });
                }
                Some(leaf.lo)
            }
        }
    }

    /// Makes a front of what a search put aside; where its budget was spent, then or later, `minimize` forgets it again.
    pub(super) fn keep_front(&mut self, front: &mut Front) {
        front.forget();
        if let Objective::SquaredDistance(q) = *self.objective {
            front.learn(q, &mut self.memory.left);
        }
    }
}

#[cfg(test)]
mod tests;
