//! The trimmed region of a face.

use super::Side;
use super::cells::{Cells, Local};
use super::decide::{Crossing, Loops, Part};
use super::piece::{Control, Piece};
use super::shape;
use super::source::{End, Source, segment, trim_runs};
use super::split::Trend;
use crate::brep::Brep;
use crate::numeric::Interval;
use arrayvec::ArrayVec;
use nalgebra::Point2;
use std::sync::OnceLock;

/// The answer of [`TrimRegion::side`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegionSide {
    /// Where the point lies; `None` where that could not be settled (a coordinate that is NaN; a
    /// point within about 1e-29 of where a native arc ends).
    pub side: Option<Side>,
    /// Whether the point is in the closed box of two loop end points that do not meet; within about 1e-29 of where a native
    /// arc ends, it may be just outside.
    pub in_gap: bool,
}

/// Where a box lies relative to a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxSide {
    /// Every point of the closed box that is in the surface's domain is in the region, and the region's
    /// boundary meets the box at most along the border of the domain.
    Inside,
    /// No point of the closed box is in the region.
    Outside,
    /// The boundary meets the box, or comes too close to tell.
    Mixed,
}

/// What a piece of the boundary comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceOrigin {
    /// A trim curve.
    Trim {
        /// Index into the face's loops, as the BREP numbers loops.
        trim_loop: usize,
        /// Index of the trim in the BREP.
        trim: usize,
    },
    /// The segment that joins two trims (or two segments of one poly-curve) that do not meet.
    Join {
        /// Index of the loop in the BREP.
        trim_loop: usize,
        /// The trim before the gap.
        trim: usize,
    },
    /// The border of the surface's domain.
    Domain,
}

/// A piece of the region's boundary: a rational Bezier curve in uv.
#[derive(Clone, Copy, Debug)]
pub struct BoundaryPiece<'a> {
    piece: &'a Piece,
    /// Where it comes from.
    pub origin: PieceOrigin,
    /// Parameters of the trim's uv curve at t = 0 and t = 1 (decreasing where the trim is reversed); rounded.
    /// Linear in t for splines and lines; of joins and borders, 0 and 1.
    pub params: [f64; 2],
    /// Box of the piece, rounded outward: `[[u_lo, u_hi], [v_lo, v_hi]]`.
    pub hull: [[f64; 2]; 2],
    /// Whether the box is inside the surface's closed domain. Where not, parts of the piece
    /// may be outside the domain, and so not on the region's boundary.
    pub inside_domain: bool,
}

impl BoundaryPiece<'_> {
    /// Homogeneous control points `(wu, wv, w)`, `w > 0`; the parameter t runs over [0, 1]. Made at each call, of a spline in some microseconds.
    pub fn control_points(&self) -> Vec<[f64; 3]> {
        Control::new(&self.piece.source.balls()).points.into_vec()
    }

    /// Proven: the exact control points, up to one common factor, differ by at most this in each
    /// homogeneous coordinate. Zero where they are exact.
    pub fn radius(&self) -> [f64; 3] {
        Control::new(&self.piece.source.balls()).radius
    }

    /// The ends of a straight piece of f64, in uv.
    pub(crate) fn segment(&self) -> Option<[[f64; 2]; 2]> {
        self.piece.segment()
    }

    /// The parameter that a straight piece of f64 keeps, and its value; of a point the first.
    pub(crate) fn kept(&self) -> Option<(usize, f64)> {
        let [p, q] = self.segment()?;
        (0..2).find(|k| p[*k] == q[*k]).map(|k| (k, p[k]))
    }
}

/// The trimmed region of one face. `Sync`; made once.
#[derive(Debug)]
pub struct TrimRegion {
    domain: [Interval; 2],
    pub(super) untrimmed: bool,
    loops: Loops,
    /// The sides of the domain where these bound the region, too.
    border: Vec<Piece>,
    /// What each piece is of, those of the loops before those of the border.
    notes: Vec<Note>,
    /// What notes tell of by number.
    origins: Vec<PieceOrigin>,
    /// Whether no two ends had to be joined.
    pub(super) gapless: bool,
    /// What the only loop runs around, where that is a rectangle.
    pub(super) rectangle: Option<[[f64; 2]; 2]>,
    /// Whether these are a grid.
    grid: bool,
    cells: OnceLock<Cells>,
}

/// What [`BoundaryPiece`] says besides the piece itself.
#[derive(Debug)]
struct Note {
    params: [f64; 2],
    /// Which of the region's origins it has.
    origin: u32,
    inside_domain: bool,
}

fn push_piece(region: &mut TrimRegion, origin: PieceOrigin, source: Source, params: [f64; 2]) {
    let balls = source.balls();
    let piece = Piece::with_balls(source, &balls);
    let pieces = match origin {
        PieceOrigin::Domain => {
            region.border.push(piece);
            &region.border
        }
        _ => {
            let is_join = matches!(origin, PieceOrigin::Join { .. });
            region.loops.push(piece, is_join, &balls);
            &region.loops.pieces
        }
    };
    let domain = &region.domain;
    let inside_domain = pieces.last().is_some_and(|piece| {
        (0..2).all(|k| domain[k].start <= piece.hull[k][0] && piece.hull[k][1] <= domain[k].end)
    });
    if region.origins.last() != Some(&origin) {
        region.origins.push(origin);
    }
    region.notes.push(Note {
        params,
        origin: region.origins.len() as u32 - 1,
        inside_domain,
    });
}

impl TrimRegion {
    /// The region of face `face`; nothing where there is no such face.
    ///
    /// Cost: some microseconds a straight piece, some tens a curved one that turns in u or v.
    pub fn new(brep: &Brep, face: usize) -> Self {
        Self::with_cells(brep, face, true)
    }

    /// The same, with a grid of cells or one cell for all, to measure what the grid saves.
    pub(crate) fn with_cells(brep: &Brep, face: usize, grid: bool) -> Self {
        let parts = brep.parts();
        let Some(f) = parts.faces.get(face) else {
            let unit = Interval {
                start: 0.0,
                end: 1.0,
            };
            return Self::empty([unit, unit]);
        };
        let mut region = Self {
            grid,
            ..Self::empty(parts.surfaces[f.surface].domain())
        };
        let Some(loops) = &f.loops else {
            region.untrimmed = true;
            region.add_domain_border();
            return region;
        };
        for &l in loops {
            let mut first: Option<End> = None;
            let mut last: Option<(End, usize)> = None;
            for &t in &parts.loops[l].trims {
                let trim = &parts.trims[t];
                for run in trim_runs(trim, &parts.curves2[trim.curve]) {
                    if let Some((end, before)) = &last {
                        region.join(end, &run.start, l, *before);
                    }
                    first.get_or_insert(run.start);
                    last = Some((run.end, t));
                    for p in run.pieces {
                        let origin = PieceOrigin::Trim {
                            trim_loop: l,
                            trim: t,
                        };
                        push_piece(&mut region, origin, p.source, p.params);
                    }
                }
            }
            if let (Some(first), Some((end, before))) = (first, last) {
                region.join(&end, &first, l, before);
            }
        }
        if region.notes.iter().any(|n| !n.inside_domain) {
            region.add_domain_border();
        }
        region.loops.shrink_to_fit();
        region.border.shrink_to_fit();
        region.notes.shrink_to_fit();
        region.origins.shrink_to_fit();
        region.rectangle = grid.then(|| region.find_rectangle()).flatten();
        region
    }

    fn empty(domain: [Interval; 2]) -> Self {
        Self {
            domain,
            untrimmed: false,
            loops: Loops::default(),
            border: Vec::new(),
            notes: Vec::new(),
            origins: Vec::new(),
            gapless: true,
            rectangle: None,
            grid: true,
            cells: OnceLock::new(),
        }
    }

    fn join(&mut self, a: &End, b: &End, trim_loop: usize, trim: usize) {
        if a.same(b) != Some(true) {
            self.gapless = false;
            let origin = PieceOrigin::Join { trim_loop, trim };
            push_piece(self, origin, segment(a, b), [0.0, 1.0]);
        }
    }

    fn add_domain_border(&mut self) {
        let [u, v] = self.domain;
        let corners = [
            [u.start, v.start],
            [u.end, v.start],
            [u.end, v.end],
            [u.start, v.end],
        ];
        for i in 0..4 {
            let ends = [corners[i], corners[(i + 1) % 4]];
            push_piece(self, PieceOrigin::Domain, Source::Segment(ends), [0.0, 1.0]);
        }
    }

    /// What the loops are made of.
    pub(super) fn loops(&self) -> &Loops {
        &self.loops
    }

    /// What [`pieces`](Self::pieces) are made of.
    pub(super) fn all_pieces(&self) -> impl Iterator<Item = &Piece> {
        self.loops.pieces.iter().chain(&self.border)
    }

    /// What the pieces come from, each of it once as long as it is the same.
    pub(super) fn origins(&self) -> impl Iterator<Item = PieceOrigin> {
        self.origins.iter().copied()
    }

    /// What a piece of the loops comes from.
    pub(super) fn origin(&self, piece: u32) -> PieceOrigin {
        self.origins[self.notes[piece as usize].origin as usize]
    }

    /// The parts of each cell, by index: parts that have a point in common have a cell in common.
    pub(super) fn parts_by_cell(&self) -> impl Iterator<Item = &[u32]> {
        self.cells().lists()
    }

    /// The surface's domain.
    pub fn domain(&self) -> [Interval; 2] {
        self.domain
    }

    /// Everything the region's boundary is made of: the pieces of all trims, the segments that join
    /// them, and the four sides of the domain where the face has no loops or where a loop leaves the domain
    /// (then only parts of these four are on the boundary).
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = BoundaryPiece<'_>> {
        (0..self.notes.len()).map(|index| self.piece(index))
    }

    /// One of the [`pieces`](Self::pieces).
    ///
    /// # Panics
    /// If there is no such piece.
    pub fn piece(&self, index: usize) -> BoundaryPiece<'_> {
        let note = &self.notes[index];
        let own = &self.loops.pieces;
        let piece = own
            .get(index)
            .unwrap_or_else(|| &self.border[index - own.len()]);
        BoundaryPiece {
            piece,
            origin: self.origins[note.origin as usize],
            params: note.params,
            hull: piece.hull,
            inside_domain: note.inside_domain,
        }
    }

    /// The trims a part of which may meet a closed box, in order, each once; of a join of two the first.
    pub(crate) fn trims_near(&self, b: [[f64; 2]; 2]) -> Vec<usize> {
        let parts = &self.loops.parts;
        let mut trims = Vec::new();
        if parts.is_empty() {
            return trims;
        }
        for k in self.cells().meeting(b).flatten() {
            let part = &parts[*k as usize];
            if part.misses(&self.loops, b) {
                continue;
            }
            if let PieceOrigin::Trim { trim, .. } | PieceOrigin::Join { trim, .. } =
                self.origin(part.piece)
            {
                trims.push(trim);
            }
        }
        trims.sort_unstable();
        trims.dedup();
        trims
    }

    /// The parts of the loops that may meet a closed box, and their pieces; `None` if they are more than asked for.
    pub(super) fn parts_near<const N: usize>(
        &self,
        b: [[f64; 2]; 2],
    ) -> Option<ArrayVec<&Part, N>> {
        let mut near = ArrayVec::<u32, N>::new();
        for k in self.cells().meeting(b).flatten() {
            if near.contains(k) || self.loops.parts[*k as usize].misses(&self.loops, b) {
                continue;
            }
            near.try_push(*k).ok()?;
        }
        Some(
            near.into_iter()
                .map(|k| &self.loops.parts[k as usize])
                .collect(),
        )
    }

    /// On which side of the boundary the point is. Exact; see [`RegionSide::side`] for the exception.
    pub fn side(&self, uv: Point2<f64>) -> RegionSide {
        let uv = [uv.x, uv.y];
        let [u, v] = self.domain;
        let answer = |side| RegionSide {
            side: Some(side),
            in_gap: false,
        };
        if uv.iter().any(|x| x.is_nan()) {
            return RegionSide {
                side: None,
                in_gap: false,
            };
        }
        let in_gap = self.in_gap(uv);
        if !u.contains(uv[0]) || !v.contains(uv[1]) {
            return RegionSide {
                in_gap,
                ..answer(Side::Outside)
            };
        }
        let on_border = uv[0] == u.start || uv[0] == u.end || uv[1] == v.start || uv[1] == v.end;
        let odd = if self.untrimmed {
            Some(true)
        } else {
            match self.parity(uv) {
                Crossing::On => {
                    return RegionSide {
                        in_gap,
                        ..answer(Side::Boundary)
                    };
                }
                Crossing::Odd => Some(true),
                Crossing::Even => Some(false),
                Crossing::Unknown => None,
            }
        };
        let side = odd.map(|odd| match (odd, on_border) {
            (true, true) => Side::Boundary,
            (true, false) => Side::Inside,
            (false, _) => Side::Outside,
        });
        RegionSide { side, in_gap }
    }

    /// Bytes that its lists hold, arithmetic beyond f64 aside.
    pub(crate) fn bytes(&self) -> usize {
        self.loops.bytes()
            + self.border.capacity() * size_of::<Piece>()
            + self.notes.capacity() * size_of::<Note>()
            + self.origins.capacity() * size_of::<PieceOrigin>()
            + self.cells.get().map_or(0, Cells::bytes)
    }

    pub(super) fn cells(&self) -> &Cells {
        // What is made of pieces for the cells alone goes with a copy of them: most are never asked for it again.
        let make = || Cells::new(&self.loops.afresh(), self.grid);
        self.cells.get_or_init(make)
    }

    fn parity(&self, q: [f64; 2]) -> Crossing {
        if let Some(r) = &self.rectangle {
            return shape::crossing(r, q);
        }
        let cells = self.cells();
        if cells.beyond(q) {
            return Crossing::Even;
        }
        match cells.parity(&self.loops, q) {
            Local::Odd(odd) => Crossing::odd(odd),
            Local::On => Crossing::On,
            Local::Elsewhere => self.parity_of_all(q),
        }
    }

    /// By all parts: the definition itself.
    #[cold]
    pub(super) fn parity_of_all(&self, q: [f64; 2]) -> Crossing {
        let mut odd = false;
        let mut unknown = false;
        for part in &self.loops.parts {
            match part.crossing_in(&self.loops, q, 0) {
                Crossing::Even => {}
                Crossing::Odd => odd = !odd,
                Crossing::On => return Crossing::On,
                Crossing::Unknown => unknown = true,
            }
        }
        if unknown {
            Crossing::Unknown
        } else {
            Crossing::odd(odd)
        }
    }

    fn in_gap(&self, q: [f64; 2]) -> bool {
        if self.gapless {
            return false;
        }
        // A gap's box is that of the segment that joins its ends.
        let cells = self.cells();
        !cells.beyond(q)
            && cells.near(q).iter().any(|k| {
                let part = &self.loops.parts[*k as usize];
                part.join
                    && (0..2).all(|i| q[i] >= part.hull[i][0] && q[i] <= part.hull[i][1])
                    && part.piece(&self.loops).in_box(q)
            })
    }

    /// Whether it is the whole of its domain, without loops.
    pub(crate) fn is_untrimmed(&self) -> bool {
        self.untrimmed
    }

    /// Where the closed box `[u[0], u[1]] x [v[0], v[1]]` lies. Conservative: `Inside` and `Outside` are
    /// proven; `Mixed` where a loop meets the box (other than along the border of the domain or beyond it, for `Inside`), or
    /// comes as close as f64 can tell.
    pub fn classify_box(&self, u: [f64; 2], v: [f64; 2]) -> BoxSide {
        let [du, dv] = self.domain;
        if !(u[0] <= u[1] && v[0] <= v[1]) {
            return BoxSide::Mixed;
        }
        if u[1] < du.start || u[0] > du.end || v[1] < dv.start || v[0] > dv.end {
            return BoxSide::Outside;
        }
        if self.untrimmed {
            return BoxSide::Inside;
        }
        if let Some(r) = &self.rectangle {
            return shape::box_side(r, &self.domain, [u, v]);
        }
        let mut along_border = false;
        // A part that several cells list, one after the other: what is dear to tell of it is told once.
        let mut last = None;
        for k in self.cells().meeting([u, v]).flatten() {
            if last == Some(*k) {
                continue;
            }
            last = Some(*k);
            let part = &self.loops.parts[*k as usize];
            if part.is_clear_of(&[u, v]) {
                continue;
            }
            if part.misses(&self.loops, [u, v]) {
                continue;
            }
            if self.is_on_border(part) {
                along_border = true;
                continue;
            }
            // On a parameter line (the border of a patch, to which trims come as near as they were fitted).
            let beside = |axis: usize, range: [f64; 2]| {
                range[0] == range[1]
                    && part
                        .piece(&self.loops)
                        .is_beside(axis, part.hull[axis], range[0])
            };
            if !(beside(0, u) || beside(1, v)) {
                return BoxSide::Mixed;
            }
        }
        // The open box cut with the open domain is connected and no loop meets it: its parity is that of any
        // point of it. (Likewise a box that is a segment: no loop meets it, but for what runs along the border.)
        let middle = |a: [f64; 2], d: Interval| {
            let (lo, hi) = (a[0].max(d.start), a[1].min(d.end));
            (0.5 * lo + 0.5 * hi).clamp(lo, hi)
        };
        match self.side(Point2::new(middle(u, du), middle(v, dv))).side {
            Some(Side::Inside) => BoxSide::Inside,
            Some(Side::Outside) if !along_border => BoxSide::Outside,
            _ => BoxSide::Mixed,
        }
    }

    /// Whether a part is nowhere within the open domain: it runs along a side of it, or beyond one.
    fn is_on_border(&self, part: &Part) -> bool {
        (0..2).any(|i| {
            part.hull[i][0] >= self.domain[i].end || part.hull[i][1] <= self.domain[i].start
        })
    }
}

/// How far, in units of a part's height, a box that ends at the part's end is enlarged to be
/// compared with the part: far enough that a flat start (a circle at its lowest point) has left
/// the end, near enough that the box is hardly larger.
const END_INSET: f64 = 1.0 / (1u64 << 20) as f64;

impl Part {
    /// Whether the part's box does not meet the closed box.
    #[inline]
    fn is_clear_of(&self, b: &[[f64; 2]; 2]) -> bool {
        let h = &self.hull;
        (0..2).any(|i| b[i][1] < h[i][0] || b[i][0] > h[i][1])
    }

    /// Proven: the part does not meet the closed box.
    pub(super) fn misses(&self, loops: &Loops, b: [[f64; 2]; 2]) -> bool {
        if self.is_clear_of(&b) {
            return true;
        }
        let ends = self.ends(loops).map(|e| e.at);
        if (0..2).any(|i| self.ends_beside(&ends, i, &b)) {
            return true;
        }
        // A part that rises (falls) in both lies between two corners of its box. It misses the query box iff
        // both remaining corners of the common box are strictly on one side of it.
        let down = match (self.trends[0], self.trends[1]) {
            (Trend::Up, Trend::Up) | (Trend::Down, Trend::Down) => false,
            (Trend::Up, Trend::Down) | (Trend::Down, Trend::Up) => true,
            _ => return false,
        };
        // Rising: the corners are (u_hi, v_lo), right of the part, and (u_lo, v_hi), left of it.
        let clear = |heights: [f64; 2]| {
            let v_of = |right: bool| heights[usize::from(right == down)];
            let corners = [[b[0][1], v_of(true)], [b[0][0], v_of(false)]];
            // The right corner is left of the part: so is the whole box. The left corner is right of it: likewise.
            self.beyond(loops, corners[0]) == Some(true)
                || self.beyond(loops, corners[1]) == Some(false)
        };
        // A corner at or past an end of the part is moved a little way into its heights. That only makes the
        // box larger, so a proof for the larger box holds.
        let [lo, hi] = ends.map(|e| e[1]);
        let (bottom, top) = if lo[0] <= hi[0] { (lo, hi) } else { (hi, lo) };
        let inset = END_INSET * (top[0] - bottom[1]);
        let heights = [b[1][0].min(top[0] - inset), b[1][1].max(bottom[1] + inset)];
        // Where a part that is not flat comes to its end (a corner), the box's own heights tell more.
        clear(heights) || heights != b[1] && clear(b[1])
    }

    /// Proven: the box begins where the part ends along an axis, and does not hold that end. (A coordinate that only rises is as large as at
    /// the part's end nowhere else.)
    fn ends_beside(&self, ends: &[[[f64; 2]; 2]; 2], i: usize, b: &[[f64; 2]; 2]) -> bool {
        let [least, most] = match self.trends[i] {
            Trend::Up => [0, 1],
            Trend::Down => [1, 0],
            Trend::Flat | Trend::Mixed => return false,
        }
        .map(|e: usize| &ends[e]);
        let elsewhere = |end: &[[f64; 2]; 2]| {
            let j = 1 - i;
            end[j][1] < b[j][0] || end[j][0] > b[j][1]
        };
        (b[i][0] >= most[i][1] && elsewhere(most)) || (b[i][1] <= least[i][0] && elsewhere(least))
    }

    /// Whether a monotone part, at height `q[1]`, is strictly at `u > q[0]` (`Some(false)`: strictly
    /// below), where that is plain in f64. Heights beyond the part's ends give `None`... see `misses`.
    fn beyond(&self, loops: &Loops, q: [f64; 2]) -> Option<bool> {
        let [lo, hi] = self.ends(loops).map(|e| e.at[1]);
        let (bottom, top) = if lo[0] <= hi[0] { (lo, hi) } else { (hi, lo) };
        if q[1] <= bottom[1] || q[1] >= top[0] {
            return None;
        }
        if q[0] < self.hull[0][0] {
            return Some(true);
        }
        if q[0] > self.hull[0][1] {
            return Some(false);
        }
        self.crossing_coarse(loops, q, 0)
    }
}
