//! Cells over a region: which parts meet each, and the parity of one point in it.
//!
//! The parity of a point then follows from its cell alone: along a path of two legs from the
//! cell's reference point (first along v, then along u) only parts that meet the cell can cross.

use super::decide::{Crossing, Part};
use super::piece::Piece;
use super::split::Trend;

/// What a cell knows of its reference point, and the parts that meet it, if they are few: all that most queries read of it.
///
/// Two bits say whether the parity is known, and what it is, with the vertical leg's count at the reference point folded in (it is not where the point
/// lies on a loop); two how many parts there are, up to [`MANY`](Self::MANY); twice [`BITS`](Self::BITS) which.
#[derive(Clone, Copy, Debug)]
struct Head(u64);

impl Head {
    const BITS: u32 = 30;
    const COUNT: u32 = 2 * Self::BITS;
    const ODD: u64 = 1 << 62;
    const KNOWN: u64 = 1 << 63;
    /// More parts than are in here.
    const MANY: usize = 3;

    fn new(items: &[u32]) -> Self {
        let fits = items.len() < Self::MANY && items.iter().all(|k| *k < 1 << Self::BITS);
        if !fits {
            return Self((Self::MANY as u64) << Self::COUNT);
        }
        let at = |i: usize| items.get(i).copied().map_or(0, u64::from) << (i as u32 * Self::BITS);
        Self((items.len() as u64) << Self::COUNT | at(0) | at(1))
    }

    #[inline]
    fn count(self) -> usize {
        (self.0 >> Self::COUNT & 3) as usize
    }

    /// Of which `count` are there.
    #[inline]
    fn items(self) -> [u32; 2] {
        let mask = (1 << Self::BITS) - 1;
        [self.0 & mask, self.0 >> Self::BITS & mask].map(|k| k as u32)
    }

    #[inline]
    fn parity(self) -> Option<bool> {
        (self.0 & Self::KNOWN != 0).then_some(self.0 & Self::ODD != 0)
    }

    fn set_parity(&mut self, odd: bool) {
        self.0 |= Self::KNOWN | if odd { Self::ODD } else { 0 };
    }
}

/// A grid of cells. A point belongs to the cell that [`index`](Axis::index) says; that function is
/// monotone, so that cells are boxes and a part lies in the cells between those of its
/// box's corners.
#[derive(Debug)]
pub(super) struct Cells {
    axes: [Axis; 2],
    /// Items of cell `c` are `items[starts[c]..starts[c + 1]]`; cell `(i, j)` is `j * count_u + i`.
    starts: Vec<u32>,
    items: Vec<u32>,
    heads: Vec<Head>,
}

/// One direction of the grid.
#[derive(Clone, Copy, Debug)]
struct Axis {
    origin: f64,
    /// Cells per unit.
    rate: f64,
    count: usize,
    /// The range that all parts are in.
    range: [f64; 2],
}

/// Where in its cell the reference point is: off the centre, which symmetric loops like to pass.
const REFERENCE: [f64; 2] = [0.487_213, 0.518_307];

/// Cells per part, and their least and greatest number; as long as they are few enough to stay in a cache, more per part.
const CELLS_PER_PART: usize = 8;
const CELLS_PER_PART_OF_FEW: usize = 16;
const FEW_CELLS: usize = 1 << 12;
const LEAST_CELLS: usize = 256;
const MOST_CELLS: usize = 1 << 21;
/// How many items (a part in a cell) are accepted per part, beyond a fixed number; with more the
/// cells are made larger.
const ITEMS_PER_PART: f64 = 16.0;
const FREE_ITEMS: f64 = 4096.0;

impl Axis {
    fn new(range: [f64; 2], count: usize) -> Self {
        let rate = count as f64 / (range[1] - range[0]);
        let usable = rate.is_finite() && rate > 0.0;
        Self {
            origin: range[0],
            rate: if usable { rate } else { 0.0 },
            count: if usable { count } else { 1 },
            range,
        }
    }

    /// Monotone: each of its operations is. (`as` takes NaN to 0 and saturates.)
    #[inline]
    fn index(&self, x: f64) -> usize {
        (((x - self.origin) * self.rate) as usize).min(self.count - 1)
    }

    /// The part of cell `i` at `fraction`, rounded.
    fn at(&self, i: usize, fraction: f64) -> f64 {
        if self.rate == 0.0 {
            return self.range[0] + fraction * (self.range[1] - self.range[0]);
        }
        self.origin + (i as f64 + fraction) / self.rate
    }
}

/// A path's parity, or why there is none.
pub(super) enum Local {
    /// The parity of the point.
    Odd(bool),
    /// On a part.
    On,
    /// Ask all parts.
    Elsewhere,
}

impl Cells {
    /// Cells for these parts: a grid, or one for all. Expected cost: about 100 ns an item.
    pub(super) fn new(pieces: &[Piece], parts: &[Part], grid: bool) -> Self {
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let mut length = [0.0f64; 2];
        for part in parts {
            for i in 0..2 {
                let [lo, hi] = part.hull[i];
                range[i] = [range[i][0].min(lo), range[i][1].max(hi)];
                length[i] += hi - lo;
            }
        }
        let n = parts.len().max(1);
        let relative = [0, 1].map(|i| {
            let r = length[i] / (range[i][1] - range[i][0]);
            if r.is_finite() { r.max(1e-3) } else { 1.0 }
        });
        let mut cells = match grid {
            true => {
                let few = (n * CELLS_PER_PART_OF_FEW).min(FEW_CELLS);
                (n * CELLS_PER_PART).max(few).clamp(LEAST_CELLS, MOST_CELLS) as f64
            }
            false => 1.0,
        };
        let axes = loop {
            // Items are about a cu + b cv + n, for cu by cv cells and parts of total relative length a and b:
            // least where a cu = b cv.
            let cu = (cells * relative[1] / relative[0]).sqrt().clamp(1.0, cells);
            let cv = (cells / cu).max(1.0);
            let expected = relative[0] * cu + relative[1] * cv;
            if expected < ITEMS_PER_PART * n as f64 + FREE_ITEMS || cells < 2.0 {
                break [
                    Axis::new(range[0], cu as usize),
                    Axis::new(range[1], cv as usize),
                ];
            }
            cells *= 0.5;
        };
        let mut out = Self {
            axes,
            starts: Vec::new(),
            items: Vec::new(),
            heads: Vec::new(),
        };
        out.fill(pieces, parts);
        out.settle(pieces, parts);
        out
    }

    pub(super) fn bytes(&self) -> usize {
        (self.starts.capacity() + self.items.capacity()) * size_of::<u32>()
            + self.heads.capacity() * size_of::<Head>()
    }

    fn cell(&self, i: usize, j: usize) -> usize {
        j * self.axes[0].count + i
    }

    fn fill(&mut self, pieces: &[Piece], parts: &[Part]) {
        /// 2^12 cells along one part are ample; beyond, a box takes what it covers.
        const MOST_HALVINGS: u32 = 12;
        let [au, av] = self.axes;
        let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(parts.len() * 2);
        let mut own: Vec<u32> = Vec::new();
        for (k, part) in parts.iter().enumerate() {
            own.clear();
            let piece = &pieces[part.own.piece as usize];
            let mut stack = vec![(part.own.t, part.hull, 0)];
            while let Some((t, hull, level)) = stack.pop() {
                let (i0, i1) = (au.index(hull[0][0]), au.index(hull[0][1]));
                let (j0, j1) = (av.index(hull[1][0]), av.index(hull[1][1]));
                // A gap is a box, not only its diagonal.
                let whole = part.join || !part.is_monotone();
                if whole || i0 == i1 || j0 == j1 || level == MOST_HALVINGS {
                    for j in j0..=j1 {
                        own.extend((i0..=i1).map(|i| self.cell(i, j) as u32));
                    }
                    continue;
                }
                let middle = 0.5 * (t[0] + t[1]);
                let m = piece.coarse_enclosure(middle);
                // A monotone part runs from corner to corner of its box, through m.
                let side = |up: bool, axis: usize| {
                    let [lo, hi] = hull[axis];
                    if up {
                        [m[axis][0].max(lo), hi]
                    } else {
                        [lo, m[axis][1].min(hi)]
                    }
                };
                let rises = [0, 1].map(|i| part.trends[i] == Trend::Up);
                let first = [0, 1].map(|i| side(!rises[i], i));
                let second = [0, 1].map(|i| side(rises[i], i));
                stack.push(([middle, t[1]], second, level + 1));
                stack.push(([t[0], middle], first, level + 1));
            }
            own.sort_unstable();
            own.dedup();
            pairs.extend(own.iter().map(|c| (*c, k as u32)));
        }
        let count = au.count * av.count;
        let mut starts = vec![0u32; count + 1];
        for (c, _) in &pairs {
            starts[*c as usize + 1] += 1;
        }
        for c in 0..count {
            starts[c + 1] += starts[c];
        }
        let mut next = starts.clone();
        let mut items = vec![0u32; pairs.len()];
        for (c, k) in pairs {
            let at = &mut next[c as usize];
            items[*at as usize] = k;
            *at += 1;
        }
        let ends = starts.windows(2);
        let list = |w: &[u32]| &items[w[0] as usize..w[1] as usize];
        self.heads = ends.map(|w| Head::new(list(w))).collect();
        self.starts = starts;
        self.items = items;
    }

    fn reference(&self, i: usize, j: usize) -> [f64; 2] {
        [
            self.axes[0].at(i, REFERENCE[0]),
            self.axes[1].at(j, REFERENCE[1]),
        ]
    }

    /// The parities of the reference points, a row at a time: a part counts for all reference points left
    /// of its box (by the states at its ends alone), and is asked for those within.
    fn settle(&mut self, pieces: &[Piece], parts: &[Part]) {
        let [au, av] = self.axes;
        let mut rows: Vec<Vec<u32>> = vec![Vec::new(); av.count];
        for (k, part) in parts.iter().enumerate() {
            // Only rows whose reference height the part may pass.
            for (j, row) in rows
                .iter_mut()
                .enumerate()
                .take(av.index(part.hull[1][1]) + 1)
                .skip(av.index(part.hull[1][0]))
            {
                let v = av.at(j, REFERENCE[1]);
                if v >= part.hull[1][0] && v <= part.hull[1][1] {
                    row.push(k as u32);
                }
            }
        }
        for (j, row) in rows.iter().enumerate() {
            // flips[i]: from cell i on to the left.
            let mut odd = vec![false; au.count];
            let mut flips = vec![false; au.count + 1];
            let mut lost = vec![false; au.count];
            for k in row {
                let part = &parts[*k as usize];
                let (i0, i1) = (au.index(part.hull[0][0]), au.index(part.hull[0][1]));
                for i in i0..=i1 {
                    match part.crossing_in(pieces, self.reference(i, j), 0) {
                        Crossing::Even => {}
                        Crossing::Odd => odd[i] = !odd[i],
                        Crossing::On | Crossing::Unknown => lost[i] = true,
                    }
                }
                if i0 > 0 {
                    // All reference points of the cells to the left are left of the part.
                    let left = [part.hull[0][0].next_down(), self.reference(0, j)[1]];
                    match part.crossing_in(pieces, left, 0) {
                        Crossing::Even => {}
                        Crossing::Odd => flips[i0] = !flips[i0],
                        // The part is beyond the cells to the left: their parity is lost.
                        Crossing::On | Crossing::Unknown => lost[..i0].fill(true),
                    }
                }
            }
            let mut flip = false;
            for i in (0..au.count).rev() {
                flip ^= flips[i + 1];
                let r = self.reference(i, j);
                // Rounding must not have put the point into another cell.
                let own = au.index(r[0]) == i && av.index(r[1]) == j;
                if lost[i] || !own {
                    continue;
                }
                let c = self.cell(i, j);
                let mut parity = odd[i] ^ flip;
                let mut good = true;
                for k in &self.items[self.starts[c] as usize..self.starts[c + 1] as usize] {
                    let part = &parts[*k as usize];
                    match part.crossing_in(pieces, r, 1) {
                        Crossing::Even => {}
                        Crossing::Odd => parity = !parity,
                        Crossing::On | Crossing::Unknown => good = false,
                    }
                }
                if good {
                    self.heads[c].set_parity(parity);
                }
            }
        }
    }

    /// Whether the point is outside the box of all parts.
    #[inline]
    pub(super) fn beyond(&self, q: [f64; 2]) -> bool {
        (0..2).any(|i| q[i] < self.axes[i].range[0] || q[i] > self.axes[i].range[1])
    }

    /// The parts that may meet the cell of a point.
    #[inline]
    pub(super) fn near(&self, q: [f64; 2]) -> &[u32] {
        let c = self.cell(self.axes[0].index(q[0]), self.axes[1].index(q[1]));
        &self.items[self.starts[c] as usize..self.starts[c + 1] as usize]
    }

    /// Each cell's parts: two parts with a point in common have a cell in common, as the boxes that they were put into cells by
    /// have that point in common, and the place of a number on an axis is monotone.
    pub(super) fn lists(&self) -> impl Iterator<Item = &[u32]> {
        let ends = self.starts.windows(2);
        ends.map(|w| &self.items[w[0] as usize..w[1] as usize])
    }

    /// The cells that a box meets, each with its parts.
    pub(super) fn meeting(&self, b: [[f64; 2]; 2]) -> impl Iterator<Item = &[u32]> {
        let [au, av] = self.axes;
        let (i0, i1) = (au.index(b[0][0]), au.index(b[0][1]));
        let (j0, j1) = (av.index(b[1][0]), av.index(b[1][1]));
        (j0..=j1).flat_map(move |j| {
            let (a, z) = (self.cell(i0, j), self.cell(i1, j));
            // A row of cells is contiguous.
            std::iter::once(&self.items[self.starts[a] as usize..self.starts[z + 1] as usize])
        })
    }

    /// The parity of a point that is not [`beyond`](Self::beyond).
    ///
    /// Legs: from `q` along u to the corner `(r_u, q_v)`, from there along v to the reference point r. Crossings of
    /// the first are those of the ray from q without those of the ray from the corner, and likewise the second.
    /// A part that does not meet the cell (a box that holds both legs) has none; one that does has all its
    /// crossings counted, and where two parts share a joint on a leg, both are listed. Should the
    /// corner be on a loop, the legs do not tell.
    #[inline]
    pub(super) fn parity(&self, pieces: &[Piece], parts: &[Part], q: [f64; 2]) -> Local {
        let (i, j) = (self.axes[0].index(q[0]), self.axes[1].index(q[1]));
        let c = self.cell(i, j);
        let head = self.heads[c];
        let Some(odd) = head.parity() else {
            return Local::Elsewhere;
        };
        let few = head.items();
        let items = match head.count() {
            0 => return Local::Odd(odd),
            Head::MANY => &self.items[self.starts[c] as usize..self.starts[c + 1] as usize],
            count => &few[..count],
        };
        let corner = [self.axes[0].at(i, REFERENCE[0]), q[1]];
        let (mut odd, mut lost) = (odd, false);
        for k in items {
            let part = &parts[*k as usize];
            match part.crossing_in(pieces, q, 0) {
                Crossing::Even => {}
                Crossing::Odd => odd = !odd,
                Crossing::On => return Local::On,
                Crossing::Unknown => lost = true,
            }
            for ray in 0..2 {
                match part.crossing_in(pieces, corner, ray) {
                    Crossing::Even => {}
                    Crossing::Odd => odd = !odd,
                    Crossing::On | Crossing::Unknown => lost = true,
                }
            }
        }
        if lost {
            return Local::Elsewhere;
        }
        Local::Odd(odd)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trim::TrimRegion;
    use crate::trim::tests::shapes::{face, polygon};

    /// Corners of the hole are reference points, to the last digit; of these cells nothing is known, though the rays from such a point that
    /// half-open rules leave are even each: `tests/it/regions.rs` asks about points in them.
    #[test]
    fn nothing_is_known_of_a_reference_on_a_loop() {
        let corner = |k: usize| {
            let k = k as f64;
            [-10.0 + (k + REFERENCE[0]), -6.0 + (k + REFERENCE[1])]
        };
        let outer = [[-10.0, -6.0], [10.0, -6.0], [10.0, 6.0], [-10.0, 6.0]];
        let mut hole: Vec<[f64; 2]> = (2..9).map(corner).collect();
        hole.extend([[2.0, 3.75], [-5.0, -3.75]]);
        let sliver = [[7.0, -5.0], [7.25, 4.75], [7.125, -5.0]];
        let loops = vec![polygon(&outer), polygon(&hole), polygon(&sliver)];
        let region = TrimRegion::new(&face([-10.0, 10.0, -10.0, 10.0], Some(loops)), 0);
        let cells = region.cells();
        assert_eq!(
            cells.axes.map(|a| (a.count, a.rate)),
            [(20, 1.0), (12, 1.0)]
        );
        for k in 2..9 {
            assert_eq!(cells.reference(k, k), corner(k));
            assert_eq!(cells.heads[cells.cell(k, k)].parity(), None, "{k}");
        }
        let told = cells.heads.iter().filter(|h| h.parity().is_some());
        assert_eq!(told.count(), 240 - 7);
    }
}
