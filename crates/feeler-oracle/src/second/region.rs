//! The trimmed region of a face: where a box of parameters lies.
//!
//! **Method.** Loops are chains of smooth arcs (trim curves cut at their breaks, and the straight segments that join
//! them). A box that no arc's enclosure meets lies on one side. Which one tells the parity of the crossings of the
//! ray from its middle q in direction +u: arcs are halved until each part's enclosure lies above, below, left or
//! right of q. Only parts on the right count, each by whether v > q_v differs at its ends.
//!
//! **Why ends may be rounded.** v at an end is compared by the middle of an enclosure. That is the exact comparison for
//! a chain whose joints are moved by no more than the enclosure's width; every enclosure of a part is widened by more
//! than that before it is found to miss q, so the moved chain passes q on the same side, and its parity is the same.
//!
//! This is no exact classification: a box that touches a loop is `Mixed`, and so is a point on one.

use super::number::{Ball, Interval64, Number};
use super::shape::{Piece, pieces};
use feeler::brep::{Brep, Face};
use feeler::numeric::Interval;

/// Where a box of parameters lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// In the region and the domain.
    Inside,
    /// No point of it belongs to the face.
    Outside,
    /// Not known.
    Mixed,
}

/// An arc of a loop, over [0, 1].
#[derive(Clone, Debug)]
pub(crate) struct LoopArc<'a> {
    pub(crate) piece: Piece<'a, 2, 3>,
    /// Its start, shared with the arc before.
    pub(crate) start: [Ball; 2],
    /// The next arc of the loop.
    pub(super) next: usize,
}

/// A box of f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Box64 {
    pub(crate) lo: [f64; 2],
    pub(crate) hi: [f64; 2],
}

impl Box64 {
    fn of<N: Number>(uv: &[N; 2]) -> Self {
        Self {
            lo: [uv[0].lo(), uv[1].lo()],
            hi: [uv[0].hi(), uv[1].hi()],
        }
    }
    fn hull(&self, o: &Self) -> Self {
        let mut all = *self;
        for c in 0..2 {
            all.lo[c] = all.lo[c].min(o.lo[c]);
            all.hi[c] = all.hi[c].max(o.hi[c]);
        }
        all
    }
    /// Larger by what rounds ends (see above).
    fn slack(&self) -> Self {
        let mut all = *self;
        for c in 0..2 {
            let s = SLACK * self.lo[c].abs().max(self.hi[c].abs());
            all.lo[c] -= s;
            all.hi[c] += s;
        }
        all
    }
}

/// Well above the rounding of a curve in f64 intervals.
const SLACK: f64 = 1e-12;
/// The same of balls.
const BALL_SLACK: f64 = 1e-66;
/// Halvings of an arc in f64, and after that in balls.
const DEPTH: u32 = 44;
const BALL_DEPTH: u32 = 150;
/// Parts looked at before the answer is `Mixed`.
const PARTS: usize = 4000;

struct Node {
    bounds: Box64,
    arcs: std::ops::Range<usize>,
    children: Option<(usize, usize)>,
}

pub(crate) struct Region<'a> {
    pub(crate) arcs: Vec<LoopArc<'a>>,
    nodes: Vec<Node>,
    roots: Vec<usize>,
    domain: [Interval; 2],
    whole: bool,
}

/// Where a part of an arc lies as seen from a box and its middle.
enum Seen {
    NoMatter,
    Right,
    Meets,
}

impl<'a> Region<'a> {
    pub(crate) fn new(brep: &'a Brep, face: &Face, domain: [Interval; 2]) -> Self {
        let mut region = Self {
            arcs: Vec::new(),
            nodes: Vec::new(),
            roots: Vec::new(),
            domain,
            whole: face.loops.is_none(),
        };
        for l in face.loops.iter().flatten() {
            let first = region.arcs.len();
            for t in &brep.parts().loops[*l].trims {
                let trim = &brep.parts().trims[*t];
                let curve = &brep.parts().curves2[trim.curve];
                let mut parts = pieces(curve, trim.span);
                if trim.reversed {
                    parts.reverse();
                }
                for part in parts {
                    region.append(part.over_unit(trim.reversed), first);
                }
            }
            region.close(first);
        }
        region
    }

    /// Adds an arc, and a segment before it where it does not start at the end of the one before.
    fn append(&mut self, piece: Piece<'a, 2, 3>, first: usize) {
        let Some(jet) = piece.jet(&Ball::exact(0.0)) else {
            return;
        };
        self.join(first, jet.p.clone());
        self.push(piece, jet.p);
    }

    fn push(&mut self, piece: Piece<'a, 2, 3>, start: [Ball; 2]) {
        let next = self.arcs.len() + 1;
        self.arcs.push(LoopArc { piece, start, next });
    }

    fn join(&mut self, first: usize, to: [Ball; 2]) {
        if self.arcs.len() == first {
            return;
        }
        let last = &self.arcs[self.arcs.len() - 1];
        let Some(jet) = last.piece.jet(&Ball::exact(1.0)) else {
            return;
        };
        let same = |a: &Ball, b: &Ball| a.is_point() && b.is_point() && a.center() == b.center();
        if (0..2).all(|c| same(&jet.p[c], &to[c])) {
            return;
        }
        self.push(Piece::segment(jet.p.clone(), to), jet.p);
    }

    /// Joins the end of the loop that starts at arc `first` to its start, and makes its tree.
    fn close(&mut self, first: usize) {
        if self.arcs.len() == first {
            return;
        }
        let start = self.arcs[first].start.clone();
        self.join(first, start);
        let last = self.arcs.len() - 1;
        self.arcs[last].next = first;
        // Leaves, then pairs of neighbours.
        let whole = Interval64::new(0.0, 1.0);
        let mut level: Vec<usize> = Vec::new();
        for i in first..self.arcs.len() {
            let bounds = self.part(i, &whole);
            level.push(self.nodes.len());
            self.nodes.push(Node {
                bounds,
                arcs: i..i + 1,
                children: None,
            });
        }
        while level.len() > 1 {
            let mut above = Vec::with_capacity(level.len().div_ceil(2));
            for pair in level.chunks(2) {
                if let [a, b] = *pair {
                    above.push(self.nodes.len());
                    self.nodes.push(Node {
                        bounds: self.nodes[a].bounds.hull(&self.nodes[b].bounds),
                        arcs: self.nodes[a].arcs.start..self.nodes[b].arcs.end,
                        children: Some((a, b)),
                    });
                } else {
                    above.push(pair[0]);
                }
            }
            level = above;
        }
        self.roots.extend(level);
    }

    /// The box of a part of an arc, in f64.
    pub(super) fn part(&self, arc: usize, x: &Interval64) -> Box64 {
        match self.arcs[arc].piece.jet(x) {
            Some(jet) => Box64::of(&jet.p).slack(),
            None => Box64 {
                lo: [f64::NEG_INFINITY; 2],
                hi: [f64::INFINITY; 2],
            },
        }
    }

    /// Whether a box is proven to lie in the domain (closed); `None` if it is proven not to meet it.
    pub(crate) fn in_domain<N: Number>(&self, uv: &[N; 2]) -> Option<bool> {
        let mut within = true;
        for c in 0..2 {
            let (start, end) = (N::exact(self.domain[c].start), N::exact(self.domain[c].end));
            if uv[c].below(&start) || end.below(&uv[c]) {
                return None;
            }
            within &= !uv[c].lower().below(&start) && !end.below(&uv[c].upper());
        }
        Some(within)
    }

    /// Where a box lies.
    pub(crate) fn place<N: Number>(&self, uv: &[N; 2]) -> Place {
        let Some(within) = self.in_domain(uv) else {
            return Place::Outside;
        };
        let odd = if self.whole {
            Some(true)
        } else {
            self.parity(uv)
        };
        match odd {
            Some(true) if within => Place::Inside,
            Some(false) => Place::Outside,
            _ => Place::Mixed,
        }
    }

    /// The parity of a box that no loop meets; `None` if one may.
    fn parity<N: Number>(&self, uv: &[N; 2]) -> Option<bool> {
        let query = Box64::of(uv);
        let middle = [uv[0].middle(), uv[1].middle()];
        let mut odd = false;
        let mut budget = PARTS;
        let mut stack: Vec<usize> = self.roots.clone();
        while let Some(i) = stack.pop() {
            let node = &self.nodes[i];
            match seen(&node.bounds, &query) {
                Seen::NoMatter => {}
                Seen::Right => {
                    let end = self.arcs[node.arcs.end - 1].next;
                    odd ^= self.above_joint(node.arcs.start, &middle)
                        != self.above_joint(end, &middle);
                }
                Seen::Meets => match node.children {
                    Some((a, b)) => stack.extend([a, b]),
                    None => {
                        odd ^= self.arc_parity(node.arcs.start, uv, &query, &middle, &mut budget)?
                    }
                },
            }
        }
        Some(odd)
    }

    fn above_joint<N: Number>(&self, arc: usize, middle: &[N; 2]) -> bool {
        let v = N::of(&self.arcs[arc].start[1]);
        middle[1].below(&v.middle())
    }

    fn above<N: Number>(&self, arc: usize, x: f64, middle: &[N; 2]) -> bool {
        if x == 0.0 {
            return self.above_joint(arc, middle);
        }
        if x == 1.0 {
            return self.above_joint(self.arcs[arc].next, middle);
        }
        match self.arcs[arc].piece.jet(&N::exact(x)) {
            Some(jet) => middle[1].below(&jet.p[1].middle()),
            None => false,
        }
    }

    /// What one arc adds to the parity; `None` if it may meet the box.
    fn arc_parity<N: Number>(
        &self,
        arc: usize,
        uv: &[N; 2],
        query: &Box64,
        middle: &[N; 2],
        budget: &mut usize,
    ) -> Option<bool> {
        let mut odd = false;
        let mut stack = vec![(0.0f64, 1.0f64, 0u32)];
        while let Some((a, b, depth)) = stack.pop() {
            if *budget == 0 {
                return None;
            }
            *budget -= 1;
            let bounds = self.part(arc, &Interval64::new(a, b));
            match seen(&bounds, query) {
                Seen::NoMatter => {}
                Seen::Right => {
                    odd ^= self.above(arc, a, middle) != self.above(arc, b, middle);
                }
                Seen::Meets => {
                    // Much smaller than the box and still not clear of it, or all of it in it.
                    let small = (0..2).all(|c| {
                        let within = query.lo[c] <= bounds.lo[c] && bounds.hi[c] <= query.hi[c];
                        within || 4.0 * (bounds.hi[c] - bounds.lo[c]) < query.hi[c] - query.lo[c]
                    });
                    if small {
                        return None;
                    }
                    let m = 0.5 * (a + b);
                    let noise = (0..2).all(|c| {
                        let size = bounds.lo[c].abs().max(bounds.hi[c].abs());
                        bounds.hi[c] - bounds.lo[c] <= 4.0 * SLACK * size
                    });
                    if depth < DEPTH && !noise && a < m && m < b {
                        stack.extend([(a, m, depth + 1), (m, b, depth + 1)]);
                    } else if N::UNIT < f64::EPSILON {
                        odd ^= self.ball_parity(arc, [a, b], uv, middle, budget)?;
                    } else {
                        return None;
                    }
                }
            }
        }
        Some(odd)
    }

    /// The same in balls, for what f64 does not settle.
    fn ball_parity<N: Number>(
        &self,
        arc: usize,
        part: [f64; 2],
        uv: &[N; 2],
        middle: &[N; 2],
        budget: &mut usize,
    ) -> Option<bool> {
        let uv = [uv[0].ball(), uv[1].ball()];
        let middle = [middle[0].ball(), middle[1].ball()];
        let piece = &self.arcs[arc].piece;
        let half = Ball::exact(0.5);
        let high = |x: &Ball, end: Option<f64>| match end {
            Some(x) => Some(self.above(arc, x, &middle)),
            None => Some(middle[1].below(&piece.jet(x)?.p[1].middle())),
        };
        let mut odd = false;
        // Ends as balls, and as f64 where they are ends of the part.
        type End = (Ball, Option<f64>);
        let end = |x: f64| (Ball::exact(x), Some(x));
        let mut stack: Vec<(End, End, u32)> = vec![(end(part[0]), end(part[1]), 0)];
        while let Some((a, b, depth)) = stack.pop() {
            if *budget == 0 || depth > BALL_DEPTH {
                return None;
            }
            *budget -= 1;
            let jet = piece.jet(&a.0.hull(&b.0))?;
            let wide: [Ball; 2] =
                std::array::from_fn(|c| jet.p[c].widened(BALL_SLACK * jet.p[c].magnitude()));
            if wide[1].below(&uv[1]) || uv[1].below(&wide[1]) || wide[0].below(&uv[0]) {
                continue;
            }
            if uv[0].below(&wide[0]) {
                odd ^= high(&a.0, a.1)? != high(&b.0, b.1)?;
                continue;
            }
            if (0..2).all(|c| 4.0 * wide[c].radius() < uv[c].radius()) {
                return None;
            }
            let m = a.0.plus(&b.0).times(&half);
            stack.push((a, (m.clone(), None), depth + 1));
            stack.push(((m, None), b, depth + 1));
        }
        Some(odd)
    }
}

fn seen(part: &Box64, query: &Box64) -> Seen {
    if part.hi[1] < query.lo[1] || query.hi[1] < part.lo[1] || part.hi[0] < query.lo[0] {
        Seen::NoMatter
    } else if query.hi[0] < part.lo[0] {
        Seen::Right
    } else {
        Seen::Meets
    }
}
