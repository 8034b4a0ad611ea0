//! Where the loops of a face cross or touch themselves or each other.
//!
//! # Definition
//! Two parts of a face's loops meet where they have a point in common, other than the end of the one and the start of the next
//! in the same loop. The region is told by parity whatever the loops do; but a loop that crosses itself bounds
//! something other than its maker meant.
//!
//! # Method
//! The parts that the region is split into are monotone in u and in v, but for a few of 2^-50 that hold a turn. Parts of one piece
//! in a row are taken together as long as they are strictly monotone in one and the same of them, so that they do not meet
//! themselves. Likewise two parts of a loop cannot meet, but at an end they share, if between them the loop runs
//! strictly monotone in one of the coordinates. Other pairs whose boxes meet go to `pair`.

use super::decide::{Crossing, Part};
use super::pair::{self, Box2, Meets, Point, Span};
use super::region::{PieceOrigin, TrimRegion};
use super::shape::RegionShape;
use super::source::Source;
use super::split::Trend;

/// How parts of loops meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MeetingKind {
    /// Proven: they meet where neither ends.
    Crossing,
    /// Proven: one runs along the other.
    Overlap,
    /// Proven: one meets the other where it ends. (Whether they also cross there is not said.)
    Touch,
    /// They come so near to each other that it could not be told.
    Undecided,
}

impl MeetingKind {
    /// In one word: `crossing`, `overlap`, `touch`, `undecided`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Crossing => "crossing",
            Self::Overlap => "overlap",
            Self::Touch => "touch",
            Self::Undecided => "undecided",
        }
    }
}

/// A place where two parts of a face's loops meet, or may meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// What is known.
    pub kind: MeetingKind,
    /// The loops, as the BREP numbers them; the same twice where a loop meets itself.
    pub loops: [usize; 2],
    /// The trims, or those before the joins that meet.
    pub trims: [usize; 2],
    /// A box in uv that holds such a place: `[[u_lo, u_hi], [v_lo, v_hi]]`.
    pub place: [[f64; 2]; 2],
    /// Whether it is next to a gap of the loop: between the straight segment that joins two trims and what is beside it, between
    /// the two trims, or within two gap's widths of it. It goes away with the gap.
    pub at_gap: bool,
}

/// All meetings of a face's loops.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Meetings {
    /// At most [`MOST_MEETINGS`] of them, in the order of the loops.
    pub found: Vec<Meeting>,
    /// How many pairs of parts meet, or may, beyond those.
    pub more: usize,
}

/// More meetings of a face are counted only.
pub const MOST_MEETINGS: usize = 256;
/// Work on one face, in halves of a pair of cubics looked at: about a second. What is left is undecided.
const BUDGET: usize = 1 << 18;
/// Pairs of parts of one face, most of which take some 30 ns: about a second. What is left is undecided as a whole.
const PAIRS: usize = 1 << 25;

/// Some parts of one piece in a row, no points.
struct Link<'a> {
    parts: &'a [Part],
    trends: [Trend; 2],
    hull: Box2,
    span: Span<'a>,
    /// Its control points, where their weights are proven to be positive.
    points: Option<Vec<Point>>,
    origin: PieceOrigin,
    /// In which strictly monotone course of its loop it is, in u and in v.
    course: [Option<usize>; 2],
}

/// Parts no longer than this are the turns that floats cannot tell: see `split`.
const TURN: f64 = 1.0 / (1u64 << 40) as f64;

impl<'a> Link<'a> {
    fn new(region: &'a TrimRegion, parts: &'a [Part], origin: PieceOrigin) -> Option<Self> {
        let (first, last) = (parts.first()?, parts.last()?);
        let both = |axis: usize| {
            let t = first.trends[axis];
            if parts.iter().all(|p| p.trends[axis] == t) {
                t
            } else {
                Trend::Mixed
            }
        };
        let hull = [0, 1].map(|axis| {
            let sides = parts.iter().map(|p| p.hull[axis]);
            sides.fold([f64::INFINITY, f64::NEG_INFINITY], |h, s| {
                [h[0].min(s[0]), h[1].max(s[1])]
            })
        });
        let span = Span {
            piece: &region.loops().pieces[first.piece as usize],
            from: first.t(region.loops())[0],
            to: last.t(region.loops())[1],
        };
        Some(Self {
            parts,
            trends: [both(0), both(1)],
            hull,
            span,
            points: None,
            origin,
            course: [None; 2],
        })
    }

    /// Whether it is proven not to meet itself.
    fn goes_on(&self) -> bool {
        self.trends.into_iter().any(is_strict) || pair::goes_on(self.span)
    }

    /// How many of these parts of one piece to take together: one at least.
    fn length(region: &'a TrimRegion, parts: &'a [Part], origin: PieceOrigin) -> usize {
        let mut n = 1;
        while n < parts.len() && parts[n].piece == parts[0].piece {
            let Some(next) = Self::new(region, &parts[..n + 1], origin) else {
                break;
            };
            let tiny = |p: &Part| {
                let [from, to] = p.t(region.loops());
                to - from <= TURN
            };
            let strict = next.trends.into_iter().any(is_strict);
            let over_a_turn = tiny(&parts[n - 1]) || tiny(&parts[n]);
            if !(strict || (over_a_turn && pair::goes_on(next.span))) {
                break;
            }
            n += 1;
        }
        n
    }
}

/// The links of one loop are `links[first..end]`.
struct Ring {
    first: usize,
    end: usize,
    /// Boxes around its gaps.
    gaps: Vec<Box2>,
}

/// A box around a gap's, wider by twice its longer side and some roundings: what trims do within it comes from the gap.
fn around_gap(hull: Box2) -> Box2 {
    let side = hull.iter().map(|r| r[1] - r[0]).fold(0.0, f64::max);
    hull.map(|r| {
        let roundings = 64.0 * f64::EPSILON * r[0].abs().max(r[1].abs());
        let by = 2.0 * side + roundings;
        [r[0] - by, r[1] + by]
    })
}

fn loop_of(origin: PieceOrigin) -> Option<(usize, usize, bool)> {
    match origin {
        PieceOrigin::Trim { trim_loop, trim } => Some((trim_loop, trim, false)),
        PieceOrigin::Join { trim_loop, trim } => Some((trim_loop, trim, true)),
        PieceOrigin::Domain => None,
    }
}

fn is_strict(trend: Trend) -> bool {
    matches!(trend, Trend::Up | Trend::Down)
}

/// Numbers the strictly monotone courses of a loop, along one coordinate.
fn number_courses(links: &mut [Link], axis: usize, next: &mut usize) {
    let n = links.len();
    let trend = |links: &[Link], k: usize| links[k % n].trends[axis];
    // From where one begins, so that none is cut by the loop's own start.
    let start = (0..n)
        .find(|k| trend(links, k + n - 1) != trend(links, *k))
        .unwrap_or(0);
    for k in start..start + n {
        if k == start || trend(links, k - 1) != trend(links, k) {
            *next += 1;
        }
        links[k % n].course[axis] = is_strict(trend(links, k)).then_some(*next);
    }
}

/// -1, 0 or 1: where a part goes along an axis, away from one of its ends; `None` where it turns.
fn heading(part: &Link, axis: usize, from_end: bool) -> Option<i32> {
    let forward = match part.trends[axis] {
        Trend::Up => 1,
        Trend::Down => -1,
        Trend::Flat => 0,
        Trend::Mixed => return None,
    };
    Some(if from_end { -forward } else { forward })
}

struct Search<'a> {
    region: &'a TrimRegion,
    links: Vec<Link<'a>>,
    /// The link of each part.
    link_of: Vec<usize>,
    rings: Vec<Ring>,
    /// Of each link.
    ring: Vec<usize>,
    budget: usize,
    pairs: usize,
    found: Vec<Meeting>,
    more: usize,
}

impl TrimRegion {
    /// Where the face's loops cross or touch themselves or each other; nothing found is a proof that they do not.
    ///
    /// Exact for segments with f64 ends. For curves a crossing is proven or ruled out where they come within about 2^-48
    /// of a part's length of each other at an angle; tangency and cusps stay [`Undecided`](MeetingKind::Undecided).
    ///
    /// Cost: a microsecond a part where loops keep clear of each other. Halving stops after about a second a face, and so does looking
    /// at pairs of parts; what is left then is undecided.
    pub fn meetings(&self) -> Meetings {
        if matches!(
            self.shape(),
            RegionShape::Whole
                | RegionShape::Nothing
                | RegionShape::Rectangle(_)
                | RegionShape::ConvexPolygon(_)
        ) {
            return Meetings::default();
        }
        let mut search = Search::new(self);
        search.all();
        Meetings {
            found: search.found,
            more: search.more,
        }
    }
}

impl<'a> Search<'a> {
    fn new(region: &'a TrimRegion) -> Self {
        let mut links: Vec<Link> = Vec::new();
        let mut rings: Vec<Ring> = Vec::new();
        let mut ring = Vec::new();
        let mut link_of = vec![usize::MAX; region.loops().parts.len()];
        let mut last = None;
        let mut at = 0;
        while let Some(part) = region.loops().parts.get(at) {
            let origin = region.origin(part.piece);
            let Some((trim_loop, _, is_join)) = loop_of(origin) else {
                at += 1;
                continue;
            };
            if last != Some(trim_loop) {
                last = Some(trim_loop);
                rings.push(Ring {
                    first: links.len(),
                    end: links.len(),
                    gaps: Vec::new(),
                });
            }
            // A point: its neighbours meet in it.
            if part.trends == [Trend::Flat; 2] {
                at += 1;
                continue;
            }
            let rest = &region.loops().parts[at..];
            let n = Link::length(region, rest, origin);
            link_of[at..at + n].fill(links.len());
            at += n;
            if let Some(mut link) = Link::new(region, &rest[..n], origin) {
                link.points = pair::control_points(&link.span);
                if let Some(r) = rings.last_mut().filter(|_| is_join) {
                    r.gaps.push(around_gap(link.hull));
                }
                links.push(link);
                ring.push(rings.len() - 1);
            }
            if let Some(r) = rings.last_mut() {
                r.end = links.len();
            }
        }
        let mut next = 0;
        for r in &rings {
            for axis in 0..2 {
                if r.first < r.end {
                    number_courses(&mut links[r.first..r.end], axis, &mut next);
                }
            }
        }
        Self {
            region,
            links,
            link_of,
            rings,
            ring,
            budget: BUDGET,
            pairs: PAIRS,
            found: Vec::new(),
            more: 0,
        }
    }

    fn all(&mut self) {
        let region = self.region;
        let cells: Vec<&[u32]> = region.parts_by_cell().collect();
        let mut cells_of: Vec<Vec<u32>> = vec![Vec::new(); self.links.len()];
        for (c, parts) in cells.iter().enumerate() {
            for part in *parts {
                if let Some(own) = cells_of.get_mut(self.link_of[*part as usize])
                    && own.last() != Some(&(c as u32))
                {
                    own.push(c as u32);
                }
            }
        }
        let mut seen = vec![usize::MAX; self.links.len()];
        for (i, own) in cells_of.iter().enumerate() {
            let hull = self.links[i].hull;
            if !self.links[i].goes_on() {
                self.push(i, i, MeetingKind::Undecided, hull);
            }
            for part in own.iter().flat_map(|c| cells[*c as usize]) {
                let k = self.link_of[*part as usize];
                if k > i && k < seen.len() && std::mem::replace(&mut seen[k], i) != i {
                    let Some(left) = self.pairs.checked_sub(1) else {
                        return self.push(i, k, MeetingKind::Undecided, hull);
                    };
                    self.pairs = left;
                    self.pair(i, k);
                }
            }
        }
    }

    /// A link's span, from its end to its start where `turned`.
    fn span(&self, i: usize, turned: bool) -> Span<'a> {
        let s = self.links[i].span;
        if turned {
            Span {
                from: s.to,
                to: s.from,
                ..s
            }
        } else {
            s
        }
    }

    /// Whether `b` follows `a` in their loop, so that it starts where `a` ends.
    fn follows(&self, a: usize, b: usize) -> bool {
        let r = &self.rings[self.ring[a]];
        self.ring[a] == self.ring[b] && (if a + 1 == r.end { r.first } else { a + 1 }) == b
    }

    fn pair(&mut self, i: usize, k: usize) {
        let (a, b) = (&self.links[i], &self.links[k]);
        if (0..2).any(|c| a.hull[c][1] < b.hull[c][0] || b.hull[c][1] < a.hull[c][0]) {
            return;
        }
        let shared = [self.follows(i, k), self.follows(k, i)];
        let same_course = (0..2).any(|c| a.course[c].is_some() && a.course[c] == b.course[c]);
        if same_course {
            return;
        }
        if shared == [false; 2]
            && let (Some(p), Some(q)) = (&a.points, &b.points)
            && pair::is_apart(p, q)
        {
            return;
        }
        let sources = (&a.span.piece.source, &b.span.piece.source);
        if let (Source::Segment(p), Source::Segment(q)) = sources {
            match pair::segments(*p, *q, shared) {
                Some(Meets::Not) => return,
                Some(Meets::At(place)) => {
                    let kind = self.at_an_end(i, k, MeetingKind::Crossing);
                    return self.push(i, k, kind, place);
                }
                Some(Meets::Along(place)) => return self.push(i, k, MeetingKind::Overlap, place),
                Some(Meets::Open(_)) | None => {}
            }
        }
        let mut budget = self.budget;
        let found = match shared {
            [false, false] => pair::meet(self.span(i, false), self.span(k, false), &mut budget),
            [true, false] => self.corner(i, k, &mut budget),
            [false, true] => self.corner(k, i, &mut budget),
            [true, true] => self.two(i, k, &mut budget),
        };
        self.budget = budget;
        match found {
            Meets::Not => {}
            Meets::At(place) => self.push(i, k, MeetingKind::Crossing, place),
            Meets::Along(place) => self.push(i, k, MeetingKind::Overlap, place),
            Meets::Open(place) => {
                let kind = if shared == [false, false] && budget > 0 {
                    self.at_an_end(i, k, MeetingKind::Undecided)
                } else {
                    MeetingKind::Undecided
                };
                self.push(i, k, kind, place);
            }
        }
    }

    /// `b` follows `a`: whether they meet anywhere but there.
    fn corner(&self, a: usize, b: usize, budget: &mut usize) -> Meets {
        let headings = |axis: usize| {
            Some([
                heading(&self.links[a], axis, true)?,
                heading(&self.links[b], axis, false)?,
            ])
        };
        // To different sides of the point that they share, or one along its coordinate and the other away from it.
        let apart = |h: Option<[i32; 2]>| h.is_some_and(|[x, y]| x != y && x * y <= 0);
        if (0..2).any(|axis| apart(headings(axis))) {
            return Meets::Not;
        }
        pair::corner(self.span(a, true), self.span(b, false), budget)
    }

    /// A loop of two parts: each follows the other.
    fn two(&self, a: usize, b: usize, budget: &mut usize) -> Meets {
        let halves = |i: usize| {
            let s = self.span(i, false);
            let middle = 0.5 * (s.from + s.to);
            [Span { to: middle, ..s }, Span { from: middle, ..s }]
        };
        let turned = |s: Span<'a>| Span {
            from: s.to,
            to: s.from,
            ..s
        };
        let ([a0, a1], [b0, b1]) = (halves(a), halves(b));
        let steps: [&dyn Fn(&mut usize) -> Meets; 4] = [
            &|budget| pair::corner(turned(a1), b0, budget),
            &|budget| pair::corner(turned(b1), a0, budget),
            &|budget| pair::meet(a0, b0, budget),
            &|budget| pair::meet(a1, b1, budget),
        ];
        let found = steps.into_iter().map(|step| step(budget));
        found
            .into_iter()
            .find(|m| *m != Meets::Not)
            .unwrap_or(Meets::Not)
    }

    /// `Touch` where an end of one part, an f64 point, is exactly on the other; else what is said.
    fn at_an_end(&self, i: usize, k: usize, otherwise: MeetingKind) -> MeetingKind {
        let loops = self.region.loops();
        let on = |of: usize, other: usize| {
            let (of, other) = (&self.links[of], &self.links[other]);
            let ends = [
                of.parts.first().map(|p| p.ends(loops)[0].at),
                of.parts.last().map(|p| p.ends(loops)[1].at),
            ];
            ends.into_iter().flatten().any(|end| {
                let is_point = end.iter().all(|r| r[0] == r[1]);
                let q = [end[0][0], end[1][0]];
                let meets = |p: &Part| p.crossing_in(loops, q, 0) == Crossing::On;
                is_point && other.parts.iter().any(meets)
            })
        };
        if on(i, k) || on(k, i) {
            MeetingKind::Touch
        } else {
            otherwise
        }
    }

    /// Whether a join is one of the two, or all that lies between them, or the place is next to one.
    fn is_at_gap(&self, i: usize, k: usize, place: &Box2) -> bool {
        let within =
            |gap: &Box2| (0..2).all(|c| gap[c][0] <= place[c][0] && place[c][1] <= gap[c][1]);
        let mut gaps = [i, k]
            .into_iter()
            .flat_map(|x| &self.rings[self.ring[x]].gaps);
        if gaps.any(within) {
            return true;
        }
        if self.ring[i] != self.ring[k] {
            return false;
        }
        let is_join = |k: usize| matches!(self.links[k].origin, PieceOrigin::Join { .. });
        let r = &self.rings[self.ring[i]];
        let next = |k: usize| if k + 1 == r.end { r.first } else { k + 1 };
        let between = |a: usize, b: usize| is_join(next(a)) && next(next(a)) == b;
        let beside = |join: usize, k: usize| {
            is_join(join) && (next(join) == k || next(k) == join || next(next(join)) == k)
        };
        between(i, k) || between(k, i) || beside(i, k) || beside(k, i)
    }

    fn push(&mut self, i: usize, k: usize, kind: MeetingKind, place: Box2) {
        if self.found.len() >= MOST_MEETINGS {
            self.more += 1;
            return;
        }
        let told = [i, k].map(|x| loop_of(self.links[x].origin).unwrap_or_default());
        self.found.push(Meeting {
            kind,
            loops: told.map(|t| t.0),
            trims: told.map(|t| t.1),
            place,
            at_gap: self.is_at_gap(i, k, &place),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::shapes::{L_SHAPE, face, polygon};
    use super::*;

    /// What is not looked at is not said to be clear.
    #[test]
    fn pairs_that_are_left_are_undecided() {
        let wide = [-10.0, 10.0, -10.0, 10.0];
        let region = TrimRegion::new(&face(wide, Some(vec![polygon(&L_SHAPE)])), 0);
        let kinds = |pairs| {
            let mut search = Search::new(&region);
            search.pairs = pairs;
            search.all();
            search.found.iter().map(|m| m.kind).collect::<Vec<_>>()
        };
        assert_eq!(kinds(PAIRS), []);
        assert_eq!(kinds(0), [MeetingKind::Undecided]);
    }
}
