//! The certified global minimum of an objective over the trimmed faces of a BREP.
//!
//! # What is proven
//! Let `m` be the minimum of `f` over the union of the trimmed faces. The search returns `lo <= m <= hi`.
//!
//! *Upper bound.* `hi` is `f` at a point of a trimmed face: a point of a patch whose uv the exact side test
//! puts in the region, or a point of a boundary piece that lies on its patch. `f` there is evaluated in
//! double-double with a running bound.
//!
//! *Lower bound.* Let `x*` be a point where the minimum is attained (the union is compact), on a
//! face with region R. Then one of these holds:
//! 1. `x*` is on a trim curve or a joining segment: it lies on a [boundary piece](crate::prepare::Piece), all of which are
//!    searched;
//! 2. `x*` is interior to R and interior to a patch: then `grad f(x*) = 0`;
//! 3. `x*` is interior to R and on a border of a patch (a joint, where the surface may have a
//!    kink, or the border of the domain): then `x*` minimises `f` on the patch near `x*`.
//!
//! A box (node) is put aside only with a proof for all points it may hold:
//! - *bound*: `f >= lo` on it, from its coefficients or from convexity; `lo` goes into the
//!   result's `lo` unless it is at least `hi`;
//! - *outside*: the box does not meet R (cases 2 and 3 are impossible in it);
//! - *monotone*: `f_u` has one sign on the whole closed box: case 2 is impossible, and case 3 is possible only on
//!   the border of the patch that `f` decreases towards, which is searched as a node of lower dimension
//!   if the box touches it;
//! - *capped*: all stationary points of `f` along one direction are strict maxima along it (see [`Node::shape`]): case 2 is impossible, and
//!   case 3 is possible only on the borders of the patch across that direction, which are searched as nodes of lower dimension where the
//!   box touches them;
//! - *ruled* (a whole patch, where only the least value is asked for): `f` is a quotient of linear functions along one direction, so
//!   monotone along it. From a point in R it does not grow one way, up to the border of the patch or to a trim: a point as low is on a
//!   boundary piece or on one of the patch's two borders across that direction, which are searched as nodes of lower dimension;
//! - *elsewhere* (a box of a sphere): it does not meet the half-space that holds all points nearer than one that is known (module `round`);
//! - *no critical point in the region*: `G = N - tau C` is strictly convex on the box; all critical points of
//!   `f` in it lie in a certified ball (see [`Leaf`]) that does not meet R: case 2 is impossible, and
//!   the borders of the patch that the box touches are searched in their own right (case 3).
//!
//! On a boundary piece a box is also put aside where it is proven to lie off its patch: what is past the border
//! of the domain is not in R, and what is on the next patch is on that patch's piece. Where the piece crosses the
//! border of its patch it ends as far as R is concerned: boxes around such a crossing are put aside by their bound
//! alone. (How which boxes these are is told to the last digits is said in the module `leaf`.)
//!
//! A face in [closed form](crate::prepare::closed) is not cut into boxes: `f` has at most one local minimum in its interior, in a
//! box that a formula gives. Where the box lies in R the minimum over the face is that formula's; else case 1 or, where the box
//! meets the border of R, both count.
//!
//! The same list with curves for patches and end points for borders holds on boundary pieces (where every point
//! counts as in the region) and on borders of patches.

use super::front::{Front, Left, MOST, MOST_LEFT, Part, nearest};
use super::leaf::Cell;
use super::node::Node;
use super::objective::Objective;
use super::outcome::{Goal, Outcome, Source};
use super::round::Approach;
use super::shape::Shape;
use super::task::{Arithmetic, Bunched, Kind, Memory, Noisy, Task};
use crate::numeric::bernstein::greater;
use crate::numeric::{Ball, Dd, Real, Td};
use crate::prepare::closed::Target;
use crate::prepare::{Net, PreparedBrep, Products, Quotient, Shell};
use crate::trim::BoxSide;
use nalgebra::Point3;
use std::collections::BinaryHeap;

/// The part of the search that does not depend on the arithmetic of its nodes.
pub(super) struct Search<'a> {
    pub(super) brep: &'a PreparedBrep,
    pub(super) objective: &'a Objective,
    pub(super) target: Target,
    pub(super) goal: Goal,
    pub(super) out: Outcome,
    /// Nodes that f64 cannot settle.
    pub(super) noisy: Vec<Noisy>,
    pub(super) memory: &'a mut Memory,
    /// The least bound of what was put aside without an entry in `out.settled`.
    unsettled: Dd,
    /// How many tasks were made (should a budget ever allow more than fit: it tells ties apart and nothing else).
    order: u32,
    /// Whether what is put aside is written down for a front.
    pub(super) recording: bool,
    /// The upper bound that [`Self::enough`] was last found for, and what it is.
    known_enough: std::cell::Cell<(Dd, Dd)>,
}

/// Boxes are not split below this width in local parameters, in parts of where they end: what halving leads to begins at a multiple of its own width `w`, so that above this its
/// middle is one of `w / 2` of no more than 52 bits, which f64 has exactly.
const LEAST_PART: f64 = 1.0 / (1u64 << 50) as f64;
/// Nor below this, where they end next to 0: where weights are 2^-40 to 2^40 they go from one control point to the next on widths down to 2^-80 there, and 20 halvings more tell
/// such a width apart.
const LEAST_WIDTH: f64 = 1.0 / (1u128 << 100) as f64;
/// Local parameters: a box of a piece that is halved down to this holds something that the way down from the whole piece's lowest guess did not come to. (Only a guide; where
/// weights are alike few boxes become so narrow.)
const NARROW: f64 = 1.0 / (1u64 << 8) as f64;
/// Which share of the width a search aims at: rounding the ends to f64 may add an ulp each.
pub(super) const QUARTER: f64 = 0.25;
/// A whole patch, and that nothing is known of what is on it.
pub(super) const WHOLE: ([[f64; 2]; 2], f64) = ([[0.0, 1.0]; 2], f64::NEG_INFINITY);
/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// Runs the search.
pub(crate) fn minimize(
    brep: &PreparedBrep,
    objective: &Objective,
    goal: Goal,
    memory: &mut Memory,
    mut front: Option<&mut Front>,
) -> Outcome {
    let mut search = Search::new(brep, objective, goal, memory);
    if !brep.shortcuts().double_first {
        search.run_all::<Dd>();
    } else if let Some(front) = front.as_deref_mut() {
        search.run_front(front);
    } else {
        search.run_all::<f64>();
    }
    search.recording = false;
    search.refine_noisy();
    if let Some(front) = front
        && search.out.budget_spent
    {
        front.forget();
    }
    let mut out = search.out;
    out.left_open |= search.unsettled < out.hi;
    if out.hi < out.lo {
        out.lo = out.hi;
    }
    out
}

impl<'a> Search<'a> {
    /// One that has not begun.
    pub(super) fn new(
        brep: &'a PreparedBrep,
        objective: &'a Objective,
        goal: Goal,
        memory: &'a mut Memory,
    ) -> Self {
        Self {
            brep,
            objective,
            target: objective.target(),
            goal,
            out: Outcome {
                lo: Dd::from(f64::INFINITY),
                hi: goal.extents.unwrap_or(Dd::from(f64::INFINITY)),
                foot: None,
                rough: None,
                settled: std::mem::take(&mut memory.settled),
                formulas: Vec::new(),
                nodes: 0,
                budget_spent: false,
                left_open: false,
                used_closed: false,
            },
            noisy: std::mem::take(&mut memory.noisy),
            memory,
            unsettled: Dd::from(f64::INFINITY),
            order: 0,
            recording: false,
            known_enough: std::cell::Cell::new((Dd::from(f64::NAN), Dd::ZERO)),
        }
    }

    /// The bound of what is not known at all.
    fn nothing(&self) -> Dd {
        if self.objective.is_squared() {
            Dd::ZERO
        } else {
            Dd::from(f64::NEG_INFINITY)
        }
    }

    /// A lower bound of `f` on a box in space, if boxes may tell.
    pub(super) fn box_bound(&self, b: &[[f64; 2]; 3]) -> Dd {
        if !self.brep.shortcuts().boxes {
            return self.nothing();
        }
        box_bound(self.objective, b)
    }

    pub(super) fn push<T>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        lo: Dd,
        covered: bool,
        kind: Kind<T>,
    ) {
        self.order = self.order.wrapping_add(1);
        heap.push(Task {
            lo,
            order: self.order,
            covered,
            kind,
        });
    }

    /// Writes down what is put aside with a bound, if a front is wanted.
    #[inline]
    pub(super) fn leave(&mut self, lo: Dd, covered: bool, part: Part) {
        if self.recording && !covered {
            let lo = if lo.hi.is_nan() { self.nothing() } else { lo };
            self.memory.left.push(Left { lo, part });
            if self.memory.left.len() > MOST_LEFT {
                nearest(&mut self.memory.left, MOST);
            }
        }
    }

    /// Takes a bound into the result.
    pub(super) fn lower(&mut self, lo: Dd) {
        let lo = if lo.hi.is_nan() { self.nothing() } else { lo };
        if lo < self.out.lo {
            self.out.lo = lo;
        }
    }

    /// As [`Self::lower`], of a part that may hold the minimum and of which nothing else is kept.
    pub(super) fn lower_unsettled(&mut self, lo: Dd) {
        // Negated: what is not a number bounds nothing.
        if !(lo >= self.unsettled) {
            self.unsettled = if lo.hi.is_nan() { self.nothing() } else { lo };
        }
        self.lower(lo);
    }

    /// Nodes with a bound from here on need no more work: the enclosure is narrow
    /// enough, given the upper bound so far.
    pub(super) fn enough(&self) -> Dd {
        let hi = self.out.hi;
        let (known, enough) = self.known_enough.get();
        if known == hi {
            return enough;
        }
        let enough = self.enough_below(hi);
        self.known_enough.set((hi, enough));
        enough
    }

    /// What is enough is to be found anew: the goal is another.
    pub(super) fn forget_enough(&self) {
        self.known_enough.set((Dd::from(f64::NAN), Dd::ZERO));
    }

    fn enough_below(&self, hi: Dd) -> Dd {
        if let Some(t) = self.goal.threshold {
            // Below: nothing that is left changes that. Else what is not below matters no more.
            if hi < t {
                return Dd::from(f64::NEG_INFINITY);
            }
            let near = self.near(hi, QUARTER);
            return if t < near { t } else { near };
        }
        let near = self.near(hi, QUARTER);
        match self.goal.all_below {
            Some(all) if Dd::from(all) > near => Dd::from(all),
            _ => near,
        }
    }

    /// How low a lower bound may lie, for an upper bound `hi` and this share of the width: an aim, which need not be met to the last digit.
    pub(super) fn near(&self, hi: Dd, share: f64) -> Dd {
        if !hi.hi.is_finite() {
            return hi;
        }
        if !self.objective.is_squared() {
            return hi - Dd::from(share * self.goal.width.at(hi.hi));
        }
        // `(d - w)^2 = d^2 - w (2 d - w)` for the distance `d`.
        let d = greater(hi.hi, 0.0).sqrt();
        let w = share * self.goal.width.at(d);
        if d > w {
            hi - Dd::from(w * (2.0 * d - w))
        } else {
            Dd::ZERO
        }
    }

    /// Whether a node with this bound can be dropped without a trace.
    pub(super) fn hopeless(&self, lo: Dd) -> bool {
        lo >= self.out.hi && self.goal.all_below.is_none_or(|all| lo > Dd::from(all))
    }

    /// Runs over all faces.
    fn run_all<T: Real + Arithmetic>(&mut self) {
        if let Some(hint) = self.goal.hint {
            self.try_hint(hint);
        }
        let mut heap = BinaryHeap::from(std::mem::take(T::tasks(self.memory)));
        self.push_faces(&mut heap);
        self.run(&mut heap);
        self.memory.put_away(heap.into_vec());
    }

    fn push_faces<T>(&mut self, heap: &mut BinaryHeap<Task<T>>) {
        for face in 0..self.brep.brep().faces().len() {
            if self.memory.passed_over.contains(&face) {
                continue;
            }
            let b = self.brep.face_box(face);
            let lo = b.map_or(self.nothing(), |b| self.box_bound(b));
            self.push(heap, lo, false, Kind::Face(face));
        }
    }

    /// Runs over a front where it holds for this centre; else over all faces, and makes the front anew.
    fn run_front(&mut self, front: &mut Front) {
        if let Some(hint) = self.goal.hint {
            self.try_hint(hint);
        }
        let mut heap = BinaryHeap::from(std::mem::take(&mut self.memory.tasks));
        let holds = self.push_front(&mut heap, front);
        if !holds {
            self.memory.left.clear();
            self.recording = true;
            self.push_faces(&mut heap);
        }
        self.run(&mut heap);
        let tasks = heap.into_vec();
        for task in &tasks {
            let part = match &task.kind {
                Kind::Face(face) | Kind::Closed(face) => Part::Face(*face),
                Kind::Bunch(face, of, bunch) => {
                    self.leave_bunch((*face, *of, *bunch), task.lo, task.covered);
                    continue;
                }
                Kind::Root(source) => Part::Root(*source),
                Kind::Node {
                    source,
                    inside,
                    node,
                } => Part::Box(*source, node.u, node.v, *inside),
            };
            self.leave(task.lo, task.covered, part);
        }
        self.memory.put_away(tasks);
        if !holds {
            self.keep_front(front);
        }
    }

    pub(super) fn run<T: Real + Arithmetic>(&mut self, heap: &mut BinaryHeap<Task<T>>) {
        while let Some(task) = heap.pop() {
            if task.lo >= self.enough() {
                self.lower(task.lo);
                return self.leave_rest(heap, task);
            }
            if self.out.nodes >= self.goal.budget {
                self.out.budget_spent = true;
                self.lower(task.lo);
                return;
            }
            self.out.nodes += 1;
            let covered = task.covered;
            match task.kind {
                Kind::Face(face) => match self.closed(face) {
                    // Nothing else waits that might come first.
                    Some(_) if heap.is_empty() => {
                        self.leave(task.lo, covered, Part::Face(face));
                        self.open_closed(heap, face, task.lo);
                    }
                    Some(form) => {
                        let least = form.surface.least(&self.target);
                        let lo = if least > task.lo { least } else { task.lo };
                        self.leave(lo, covered, Part::Face(face));
                        if !self.hopeless(lo) {
                            self.push(heap, lo, true, Kind::Closed(face));
                        }
                    }
                    None => self.open_face(heap, face, task.lo, covered),
                },
                Kind::Closed(face) => self.open_closed(heap, face, task.lo),
                Kind::Bunch(face, of, bunch) => {
                    self.open_bunch(heap, (face, of, bunch), task.lo, covered);
                }
                Kind::Root(source) => self.open_root(heap, source, task.lo, covered),
                Kind::Node {
                    source,
                    inside,
                    node,
                } => self.visit(heap, source, inside, node, covered),
            }
        }
    }

    /// The value needs no more, and what is left begins with `task`. Where a foot is asked for, faces in closed form that may hold the minimum, too, are asked where:
    /// they take little, and an edge is on two of them.
    fn leave_rest<T: Real + Arithmetic>(&mut self, heap: &mut BinaryHeap<Task<T>>, task: Task<T>) {
        let mut next = Some(task);
        while let Some(task) = next {
            let is_closed = match task.kind {
                Kind::Face(face) | Kind::Closed(face) => self.closed(face).is_some(),
                Kind::Bunch(_, of, _) => of == Bunched::Curves,
                Kind::Root(_) | Kind::Node { .. } => false,
            };
            if !(is_closed
                && self.goal.foot
                && task.lo < self.out.hi
                && self.out.nodes < self.goal.budget)
            {
                self.out.left_open |= task.lo < self.out.hi;
                if self.recording {
                    // It is written down with all that is left.
                    heap.push(task);
                }
                return;
            };
            self.out.nodes += 1;
            match task.kind {
                Kind::Face(face) | Kind::Closed(face) => {
                    self.leave(task.lo, task.covered, Part::Face(face));
                    self.open_closed(heap, face, task.lo);
                }
                Kind::Bunch(face, of, bunch) => {
                    self.open_bunch(heap, (face, of, bunch), task.lo, task.covered);
                }
                Kind::Root(_) | Kind::Node { .. } => {}
            }
            next = heap.pop();
        }
    }

    fn open_face<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        face: usize,
        lo: Dd,
        mut covered: bool,
    ) {
        let geometry = T::geometry(self.brep, face);
        let shell = self.brep.shell(face);
        let lo = match shell.map(|s| s.least(&self.target)) {
            Some(least) if least > lo => least,
            _ => lo,
        };
        // A front does no better than a half-space does anew.
        if self.recording && shell.is_some_and(Shell::is_sphere) {
            self.leave(lo, covered, Part::Face(face));
            covered = true;
        }
        let round = shell.filter(|s| s.is_sphere());
        // Of a coarser answer the sphere itself tells enough as a rule.
        let first = round.filter(|_| self.goal.width.is_full());
        let first = first.and_then(|s| self.approach(s, face, lo, covered));
        // A good place to start is better than the best of a few.
        let hinted = self.goal.hint.is_some_and(|h| h.face == face);
        let started = hinted && self.out.foot.is_some();
        let start = first.as_ref().and_then(Approach::start);
        let served = first.as_ref().is_none_or(|a| a.serves(self.out.hi));
        if !(started && served) {
            match start {
                Some((index, place)) => {
                    self.look_down(Source::Patch { face, index }, place, WHOLE);
                }
                None => self.try_seed(face),
            }
        }
        let enough = lo >= self.enough();
        let hi = self.out.hi;
        let first = first.filter(|a| a.serves(hi));
        let again = round.filter(|_| !enough && first.is_none() && hi.hi.is_finite());
        let again = again.and_then(|s| self.approach(s, face, hi, covered));
        if let Some(approach) = first.as_ref().or(again.as_ref()).filter(|_| !enough) {
            self.push_near(heap, face, approach, lo, covered);
        } else {
            for (index, b) in geometry.patch_boxes().iter().enumerate() {
                let own = b.as_ref().map_or(self.nothing(), |b| self.box_bound(b));
                let lo = if own > lo { own } else { lo };
                let source = Source::Patch { face, index };
                self.push(heap, lo, covered, Kind::Root(source));
            }
        }
        self.push_pieces::<T>(heap, face, lo, covered);
    }

    /// The root node of a source.
    pub(super) fn root<T: Real + Arithmetic>(&mut self, source: Source) -> Option<Box<Node<T>>> {
        let mut node = self.memory.spare_node();
        let spare = std::mem::replace(&mut node.f, Quotient::BLANK);
        let (Source::Patch { face, index } | Source::Piece { face, index }) = source;
        let geometry = T::geometry(self.brep, face);
        let quotient = match source {
            Source::Patch { .. } => {
                let net = &geometry.patches[index].net;
                let products = || geometry.patch_products(index);
                self.objective.quotient(net, products, spare)
            }
            Source::Piece { .. } => {
                let (space, products) = self.basis::<T>(source)?;
                self.objective.quotient(space, || products, spare)
            }
        };
        *node = Node::root(quotient, self.objective.is_squared());
        Some(node)
    }

    /// The net of a source, and its products.
    pub(super) fn basis<T: Real + Arithmetic>(
        &self,
        source: Source,
    ) -> Option<(&'a Net<T>, &'a Products<T>)> {
        let (Source::Patch { face, index } | Source::Piece { face, index }) = source;
        let geometry = T::geometry(self.brep, face);
        Some(match source {
            Source::Patch { .. } => (&geometry.patches[index].net, geometry.patch_products(index)),
            Source::Piece { .. } => (
                geometry.piece(index).space.as_ref()?,
                geometry.piece_products(index)?,
            ),
        })
    }

    fn open_root<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        source: Source,
        lo: Dd,
        covered: bool,
    ) {
        let Some(mut node) = self.root::<T>(source) else {
            // A trim of too high a degree: the patch below bounds it.
            let (Source::Patch { face, .. } | Source::Piece { face, .. }) = source;
            let patch = match source {
                Source::Piece { index, .. } => {
                    Some(T::geometry(self.brep, face).piece_patch(index))
                }
                Source::Patch { .. } => None,
            };
            let bound = patch
                .and_then(|index| self.root::<T>(Source::Patch { face, index }))
                .map_or(lo, |n| n.lo);
            self.leave(bound, covered, Part::Root(source));
            return self.lower_unsettled(bound);
        };
        if lo > node.lo {
            node.lo = lo;
        }
        // From where it seems lowest.
        let least = node.lo.hi;
        self.look_down(source, node.guess(), ([node.u, node.v], least));
        let (lo, inside) = (node.lo, false);
        let kind = Kind::Node {
            source,
            inside,
            node,
        };
        self.push(heap, lo, covered, kind);
    }

    fn visit<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        source: Source,
        mut inside: bool,
        mut node: Box<Node<T>>,
        covered: bool,
    ) {
        if let Source::Patch { face, index } = source
            && !inside
        {
            let side = self.classify(face, index, node.u, node.v);
            match side {
                BoxSide::Outside => return self.memory.put_back(node),
                BoxSide::Inside => inside = true,
                BoxSide::Mixed => {}
            }
        }
        let Some(along_u) = self.settle(heap, source, inside, &node, covered) else {
            return self.memory.put_back(node);
        };
        let mut high = self.memory.spare_node();
        node.halve(&mut high, along_u, self.objective.is_squared());
        for half in [node, high] {
            self.enqueue(heap, source, inside, half, covered);
        }
    }

    /// Puts a node aside if that can be proven; else whether it is to be halved along u.
    fn settle<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        source: Source,
        inside: bool,
        node: &Node<T>,
        covered: bool,
    ) -> Option<bool> {
        let part = Part::Box(source, node.u, node.v, inside);
        if node.f.degree.count() == 1 {
            // A single point.
            let p = [Dd::from(node.u[0]), Dd::from(node.v[0])];
            self.try_point(source, p, inside);
            let lo = self.point_bound(source, p, node.lo);
            self.leave(lo, covered, part);
            if !self.hopeless(lo) {
                self.lower(lo);
                self.settle_unshaped(source, node.u, node.v, lo);
            }
            return None;
        }
        // Where a piece crosses the border of its patch, the crossing is an end of what counts, though not of
        // the piece: the minimum may be there, and neither a slope nor convexity puts it aside.
        let (mut crosses, mut leaves) = (false, None);
        if let Source::Piece { face, index } = source
            && !self.brep.double(face).piece(index).stays(node.u)
            && self.piece_leaves(face, index)
        {
            if let Some(touches) = self.touches_only(face, index) {
                for (k, end) in [(0, 0.0), (1, 1.0)] {
                    if touches[k] && node.u[k] == end {
                        self.enqueue_border(heap, source, inside, node, (true, k == 1));
                    }
                }
                self.leave(node.lo, covered, part);
                return None;
            }
            let place = self.piece_place(face, index, node.u);
            if place.off {
                return None;
            }
            crosses = place.leaves;
            leaves = Some((face, index));
        }
        let may_end = |high: bool| {
            let end = node.u[usize::from(high)];
            leaves.is_some_and(|(face, index)| self.piece_may_end(face, index, end))
        };
        // Any tau will do; one near f on the node proves most: where all minima are asked for, that is not
        // the least f so far. It has all digits of this arithmetic, lest what is constant looks as if it were not.
        let tau = if self.out.hi.hi.is_finite() && self.goal.all_below.is_none() {
            T::from_dd(self.out.hi).0
        } else {
            node.least_quotient()
        };
        let shape = node.shape(tau);
        let shortcuts = self.brep.shortcuts();
        if let Some(k) = self.ruled(source, node)
            && shape.monotone[k] == 0
        {
            // What is as low along a ruling is not searched: it is looked for from the foot.
            self.out.left_open |= !self.hopeless(node.lo);
            for end in [false, true] {
                self.enqueue_border(heap, source, inside, node, (k == 0, end));
            }
            self.leave(node.lo, covered, part);
            return None;
        }
        for (k, sign) in shape.monotone.into_iter().enumerate() {
            if sign == 0 || crosses || !shortcuts.monotone_borders {
                continue;
            }
            let range = if k == 0 { node.u } else { node.v };
            let (end, touches) = if sign > 0 {
                (false, range[0] == 0.0)
            } else {
                (true, range[1] == 1.0)
            };
            if touches {
                self.enqueue_border(heap, source, inside, node, (k == 0, end));
            } else if may_end(end) {
                if self.goal.all_below.is_none() {
                    continue;
                }
                // All of it is on the patch, as far as is told, and what goes on from its end perhaps not: then that is a minimum. (A piece that runs
                // along the border has such ends all along, which halving does not make fewer.)
                self.enqueue_border(heap, source, inside, node, (k == 0, end));
            }
            self.leave(node.lo, covered, part);
            return None;
        }
        // Tops, ridges and saddles across the parameter lines hold no minimum; where only the least one is asked for their bounds say that sooner.
        if self.goal.all_below.is_some()
            && !crosses
            && shortcuts.monotone_borders
            && let Some(k) = shape.capped.iter().position(|c| *c)
            && ![false, true].into_iter().any(may_end)
        {
            let range = if k == 0 { node.u } else { node.v };
            for (end, touches) in [(false, range[0] == 0.0), (true, range[1] == 1.0)] {
                if touches {
                    self.enqueue_border(heap, source, inside, node, (k == 0, end));
                }
            }
            self.leave(node.lo, covered, part);
            return None;
        }
        if crosses {
            let middle = [node.u, node.v].map(|r| Dd::from(0.5 * (r[0] + r[1])));
            self.try_point(source, middle, false);
        } else if shape.convexity > 0.0 && shortcuts.convex_leaves {
            let cell = Cell::from(node);
            let told = (&shape, tau.to_dd().0);
            if let Some(leaf) = self.leaf(heap, source, inside, &cell, told) {
                self.leave(leaf.lo, covered, part);
                return None;
            }
        }
        // Next to a crossing no slope and no convexity settles a box: one is small enough where all its values are within the width wanted.
        if leaves.is_some()
            && self.goal.all_below.is_some()
            && self.is_level(node, &shape, tau)
            && self.settle_level(source, node.u, node.lo)
        {
            self.leave(node.lo, covered, part);
            return None;
        }
        // Where all of G is rounding noise, halves would be no better.
        let along_u = split_along_u(node, &shape);
        if shape.g_largest <= NOISE_FACTOR * shape.g_error || along_u.is_none() {
            if let (true, Some(piece)) = (crosses, leaves)
                && T::UNIT < f64::UNIT
                && self.goal.all_below.is_none()
                && let Some(bound) = self.crossing_bound(piece, node, (&shape, tau.to_dd().0))
                && bound > node.lo
            {
                self.leave(bound, covered, part);
                self.lower_unsettled(bound);
                return None;
            }
            if let Some(piece) = leaves
                && let Some((at, _)) = self.rest_on_patch(piece, node.u)
            {
                self.try_end(source, at);
            }
            self.noisy.push((source, node.u, node.v, node.lo));
            self.leave(node.lo, covered, part);
            return None;
        }
        // A value far above those on the node hides that `G` is convex there, next to a focal point on boxes of any size; and that it is rounding noise, on what is narrow of a piece
        // whose weights are very different. (Where the region ends, low values are beside it more often than not.)
        let is_narrow_piece =
            matches!(source, Source::Piece { .. }) && !crosses && node.u[1] - node.u[0] <= NARROW;
        if (inside || is_narrow_piece) && self.goal.all_below.is_none() {
            let guess = node.guess();
            let halfway = (self.out.hi + node.lo).half().hi;
            if self.guide_value(source, guess) < halfway {
                let start = self.descend(source, guess, [node.u, node.v]);
                self.try_rough_point(source, start);
            }
            if T::UNIT < f64::UNIT {
                // f64 does not tell which values are lower by less than its own noise.
                self.try_point(source, guess.map(Dd::from), inside);
            }
        }
        along_u
    }

    /// Whether all values on a node are within the width that is wanted of one.
    fn is_level<T: Real>(&self, node: &Node<T>, shape: &Shape, tau: T) -> bool {
        let off = (shape.g_largest + shape.g_error) / shape.c_range[0] * UP;
        // Negated in effect: what is no number is not near.
        shape.c_range[0] > 0.0 && node.lo >= self.near(tau.to_dd().0 + Dd::from(off), QUARTER)
    }

    /// Puts the border of a box in line, along u (or v) at the low or the high end.
    pub(super) fn enqueue_border<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        source: Source,
        inside: bool,
        node: &Node<T>,
        (along_u, high): (bool, bool),
    ) {
        let mut border = self.memory.spare_node();
        node.border(&mut border, along_u, high, self.objective.is_squared());
        self.enqueue(heap, source, inside, border, true);
    }

    /// Of a node that is a whole patch: along which of u and v `f` is a quotient of linear functions (a height on a ruled patch), where only the
    /// least value is asked for.
    fn ruled<T: Real>(&self, source: Source, node: &Node<T>) -> Option<usize> {
        let whole = node.u == [0.0, 1.0] && node.v == [0.0, 1.0];
        let patch = matches!(source, Source::Patch { .. });
        let wanted = self.goal.all_below.is_none() && self.brep.shortcuts().monotone_borders;
        if !(patch && whole && wanted) {
            return None;
        }
        let degree = node.f.degree;
        [degree.u, degree.v].iter().position(|d| *d == 1)
    }

    /// The best bound of `f` at a single point.
    fn point_bound(&self, source: Source, p: [Dd; 2], lo: Dd) -> Dd {
        let Some(net) = self.net_dd(source) else {
            return lo;
        };
        let local = p.map(|mid| Ball { mid, rad: 0.0 });
        let mut f = self.objective.value(net, local);
        if self.is_lost(f)
            && let Some(net) = self.net_in::<Td>(source)
        {
            let [s, t] = p.map(|x| Ball::from_dd(x, 0.0));
            f = self.objective.sample(net, s, t).value();
        }
        let bound = f.mid - Dd::from(f.rad * UP);
        let bound = bound - Dd::from(2.0 * Dd::UNIT * bound.magnitude());
        if bound > lo { bound } else { lo }
    }

    pub(super) fn enqueue<T: Real + Arithmetic>(
        &mut self,
        heap: &mut BinaryHeap<Task<T>>,
        source: Source,
        inside: bool,
        node: Box<Node<T>>,
        covered: bool,
    ) {
        let lo = node.lo;
        if self.hopeless(lo) {
            self.leave(lo, covered, Part::Box(source, node.u, node.v, inside));
            return self.memory.put_back(node);
        }
        let kind = Kind::Node {
            source,
            inside,
            node,
        };
        self.push(heap, lo, covered, kind);
    }

    /// Whether a box of a patch meets the region.
    pub(super) fn classify(&self, face: usize, patch: usize, u: [f64; 2], v: [f64; 2]) -> BoxSide {
        let geometry = self.brep.double(face);
        let maps = &geometry.patches[patch].maps;
        self.brep.region(face).classify_box(
            maps[0].to_native_range(u[0], u[1]),
            maps[1].to_native_range(v[0], v[1]),
        )
    }

    pub(super) fn net(&self, source: Source) -> Option<&Net<f64>> {
        self.net_in(source)
    }

    pub(super) fn net_dd(&self, source: Source) -> Option<&Net<Dd>> {
        self.net_in(source)
    }

    /// The net of a source in an arithmetic.
    pub(super) fn net_in<T: Real + Arithmetic>(&self, source: Source) -> Option<&Net<T>> {
        let (Source::Patch { face, index } | Source::Piece { face, index }) = source;
        let geometry = T::geometry(self.brep, face);
        match source {
            Source::Patch { .. } => Some(&geometry.patches[index].net),
            Source::Piece { .. } => geometry.piece(index).space.as_ref(),
        }
    }
}

/// A lower bound of `f` on a box in space. Each side is a few roundings off.
pub(super) fn box_bound(objective: &Objective, b: &[[f64; 2]; 3]) -> Dd {
    match objective {
        Objective::SquaredDistance(q) => Dd::from(least_squared(b, q)),
        Objective::Height(n, h) => {
            let (mut low, mut size) = (-h, h.abs());
            for c in 0..3 {
                let x = if n[c] > 0.0 { b[c][0] } else { b[c][1] };
                low += n[c] * x;
                size += (n[c] * x).abs();
            }
            Dd::from(low - 16.0 * f64::EPSILON * size)
        }
    }
}

/// No squared distance of a point of a box in space from a centre is less than this.
pub(super) fn least_squared(b: &[[f64; 2]; 3], center: &Point3<f64>) -> f64 {
    let sum: f64 = (0..3)
        .map(|c| {
            let gap = greater(b[c][0] - center[c], center[c] - b[c][1]);
            let gap = greater(gap, 0.0);
            gap * gap
        })
        .sum();
    sum * (1.0 - 16.0 * f64::EPSILON)
}

/// A node is left to the next arithmetic when all of `G` is below this many error bounds.
pub(super) const NOISE_FACTOR: f64 = 8.0;

/// What bends less than the most by no more than this factor.
const NEARLY: f64 = 16.0;

/// Whether a range is not split.
fn is_least([from, to]: [f64; 2]) -> bool {
    to - from <= LEAST_WIDTH.max(LEAST_PART * to)
}

/// Along which side a box is halved: where the second difference is largest; the wider side where they are alike. Where that is not split the other one is, if it bends nearly as much.
/// `None` where halves would be no better.
pub(super) fn split_along_u<T>(node: &Node<T>, shape: &Shape) -> Option<bool> {
    let d = node.f.degree;
    let (du, dv) = (node.u[1] - node.u[0], node.v[1] - node.v[0]);
    let [a, b] = shape.bend;
    // Within this factor the two directions count as alike.
    const ALIKE: f64 = 1.5;
    let along_u = if d.u == 0 || d.v == 0 {
        d.v == 0
    } else if a > ALIKE * b {
        true
    } else if b > ALIKE * a {
        false
    } else {
        du >= dv
    };
    let [most, other] = if along_u { [a, b] } else { [b, a] };
    let [range, beside] = if along_u {
        [node.u, node.v]
    } else {
        [node.v, node.u]
    };
    if !is_least(range) {
        Some(along_u)
    } else {
        (other * NEARLY >= most && !is_least(beside)).then_some(!along_u)
    }
}
