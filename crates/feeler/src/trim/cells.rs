//! Cells over a region: which parts meet each, strips that hold these, and the parities of some points in it.
//!
//! The parity of a point then follows from its cell alone: on a side of the strips by another point of that side, else along a path
//! of two legs from the cell's reference point (first along v, then along u), which only parts that meet the cell can cross.

use super::decide::{Crossing, Loops};
use super::piece::{Control, Horner};
use super::split::Trend;
use super::strip::{BITS, MARGIN, Stretch, Strip};

/// Strips of a cell.
const STRIPS: usize = 3;
/// Above all of them, or where there are none.
const LAST_SIDE: usize = (1 << STRIPS) - 1;

/// What a cell knows: all that most queries read. Half a line of a processor's cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Cell {
    /// What the loops have in it keeps to these.
    strips: [Strip; STRIPS],
    /// Two bits for each side of the strips: whether the parity is known, and whether it is odd.
    parities: u16,
    /// The same for the reference point, with the vertical leg's count there folded in (it is not where the point lies on a loop).
    reference: u8,
    /// How many parts meet it, up to [`MANY`](Self::MANY).
    count: u8,
    /// Which, or where in `many` they are listed.
    items: [u32; 2],
}

const _: () = assert!(size_of::<Cell>() == 32);

impl Cell {
    /// Without parts.
    const EMPTY: Self = Self {
        strips: [Strip::NONE; STRIPS],
        parities: 0,
        reference: 0,
        count: 0,
        items: [0; 2],
    };
    /// More parts than are in here.
    const MANY: u8 = 3;

    /// Lists a part; what does not fit is handed back.
    fn push(&mut self, part: u32) -> Option<u32> {
        let Some(free) = self.items.get_mut(usize::from(self.count)) else {
            return Some(part);
        };
        *free = part;
        self.count += 1;
        None
    }

    /// Moves the list to others, with more parts.
    fn push_all(&mut self, more: impl Iterator<Item = u32>, many: &mut Vec<u32>) {
        let start = many.len();
        many.extend(self.items);
        many.extend(more);
        self.count = Self::MANY;
        self.items = [start as u32, many.len() as u32];
    }

    #[inline]
    fn items<'a>(&'a self, many: &'a [u32]) -> &'a [u32] {
        if self.count == Self::MANY {
            &many[self.items[0] as usize..self.items[1] as usize]
        } else {
            &self.items[..usize::from(self.count)]
        }
    }

    /// Whether both are without parts, and say the same.
    fn is_like(&self, other: &Self) -> bool {
        (self.count, other.count) == (0, 0)
            && (self.parities, self.reference) == (other.parities, other.reference)
    }

    fn knows(&self, side: usize) -> bool {
        self.parities >> (2 * side) & 1 != 0
    }

    fn set_parity(&mut self, side: usize, odd: bool) {
        self.parities |= (1 + 2 * u16::from(odd)) << (2 * side);
    }

    fn reference(&self) -> Option<bool> {
        (self.reference & 1 != 0).then_some(self.reference & 2 != 0)
    }

    fn set_reference(&mut self, odd: bool) {
        self.reference = 1 + 2 * u8::from(odd);
    }

    /// Whether there is no side of which nothing is known.
    #[inline]
    fn is_settled(&self) -> bool {
        // Above all strips that there are not.
        let first = match self.strips.each_ref().map(Strip::is_none) {
            [true, ..] => 7,
            [_, true, _] => 6,
            [.., true] => 4,
            _ => 0,
        };
        let known = 0x5555u16 << (2 * first);
        self.parities & known == known
    }

    /// On which side of the strips a point of the cell is, and whether it is in one of them.
    #[inline]
    fn side(&self, place: [i32; 2]) -> (usize, bool) {
        let [a, b, c] = self.strips.each_ref().map(|s| s.sign(place));
        let side = usize::from(a.0) + 2 * usize::from(b.0) + 4 * usize::from(c.0);
        (side, a.1 | b.1 | c.1)
    }

    /// The parity of a point of the cell, where its side tells: then no loop meets the way from it to another point of that side,
    /// of which the parity is known.
    #[inline]
    fn told(&self, place: [i32; 2]) -> Option<bool> {
        let (side, within) = self.side(place);
        let bits = self.parities >> (2 * side);
        ((bits & 1 != 0) & !within).then_some(bits & 2 != 0)
    }
}

/// A grid of cells. A point belongs to the cell that [`index`](Axis::index) says; that function is
/// monotone, so that cells are boxes.
#[derive(Debug)]
pub(super) struct Cells {
    axes: [Axis; 2],
    /// Where in `cells` cell `(i, j)` is, at `j * count_u + i`; empty where it is just there.
    index: Vec<u32>,
    /// Those without parts but twice where there is an index: outside and inside.
    cells: Vec<Cell>,
    /// The parts of cells that have many.
    many: Vec<u32>,
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
const CELLS_PER_PART: usize = 4;
const CELLS_PER_PART_OF_FEW: usize = 8;
const FEW_CELLS: usize = 1 << 12;
const LEAST_CELLS: usize = 64;
const MOST_CELLS: usize = 1 << 21;
/// How many items (a part in a cell) are accepted per part, beyond a fixed number; with more the
/// cells are made larger.
const ITEMS_PER_PART: f64 = 16.0;
const FREE_ITEMS: f64 = 4096.0;

/// A cell's size is beyond all rounding, but within f64's range many times over.
const MOST_RATE: f64 = 1e150;

/// A part is halved until it bulges by less than this share of a cell, but not too often.
const FLAT: f64 = 1.0 / 16.0;
/// 2^12 cells along one part are ample; beyond, a box takes what it covers.
const MOST_HALVINGS: u32 = 12;
/// The same for a part that is in one row or column of cells.
const FEW_HALVINGS: u32 = 5;

/// A cell's width in units of places.
const CELL: i32 = 1 << BITS;

/// Where in a cell its strips' sides are looked for: along the edges to the cells before it, then within.
const SAMPLES: [[i32; 2]; 21] = samples();

const fn samples() -> [[i32; 2]; 21] {
    let mut out = [[0; 2]; 21];
    let mut k = 0;
    while k < 5 {
        out[k] = [0, k as i32 * CELL / 4];
        k += 1;
    }
    while k < 9 {
        out[k] = [(k as i32 - 4) * CELL / 4, 0];
        k += 1;
    }
    while k < 21 {
        let (i, j) = ((20 - k as i32) % 3, (20 - k as i32) / 3);
        out[k] = [
            (i + 1) * CELL / 3 - CELL / 24,
            (j + 1) * CELL / 4 - CELL / 24,
        ];
        k += 1;
    }
    out
}

impl Axis {
    fn new(range: [f64; 2], count: usize) -> Self {
        let rate = count as f64 / (range[1] - range[0]);
        let usable = rate < MOST_RATE && rate > 0.0;
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
        self.place(x).0
    }

    /// The index of a number in the range, and where it is in that cell.
    #[inline]
    fn place(&self, x: f64) -> (usize, i32) {
        let fixed = (((x - self.origin) * self.rate * (1i64 << BITS) as f64) as i64).max(0);
        let i = ((fixed >> BITS) as usize).min(self.count - 1);
        (i, (fixed - ((i as i64) << BITS)) as i32)
    }

    /// In cells.
    fn scaled(&self, x: f64) -> f64 {
        (x - self.origin) * self.rate
    }

    /// The cells that this range, in cells, meets.
    fn span(&self, [low, high]: [f64; 2]) -> [usize; 2] {
        [low, high].map(|x| (x as i64).max(0).min(self.count as i64 - 1) as usize)
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
    pub(super) fn new(loops: &Loops, grid: bool) -> Self {
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let mut length = [0.0f64; 2];
        for part in &loops.parts {
            for i in 0..2 {
                let [lo, hi] = part.hull[i];
                range[i] = [range[i][0].min(lo), range[i][1].max(hi)];
                length[i] += hi - lo;
            }
        }
        // Parts around turns are all but points: only of few does each count.
        let monotone = loops.parts.iter().filter(|p| p.is_monotone()).count();
        let (all, n) = (loops.parts.len().max(1), monotone.max(1));
        let relative = [0, 1].map(|i| {
            let r = length[i] / (range[i][1] - range[i][0]);
            if r.is_finite() { r.max(1e-3) } else { 1.0 }
        });
        let mut cells = match grid {
            true => {
                let few = (all * CELLS_PER_PART_OF_FEW).min(FEW_CELLS);
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
            index: Vec::new(),
            cells: vec![Cell::EMPTY; axes[0].count * axes[1].count],
            many: Vec::new(),
        };
        out.fill(loops);
        out.settle(loops);
        out.settle_sides(loops);
        out.merge_empty();
        out
    }

    /// Keeps one for all cells without parts on the same side, where there are many. (Of few all are kept: which one is asked for is then told at once.)
    fn merge_empty(&mut self) {
        let empty = [false, true].map(|odd| {
            let mut cell = Cell::EMPTY;
            cell.set_parity(LAST_SIDE, odd);
            cell.set_reference(odd);
            cell
        });
        let which = |cell: &Cell| empty.iter().position(|e| e.is_like(cell));
        let kept = empty.len() + self.cells.iter().filter(|c| which(c).is_none()).count();
        let before = self.cells.len() * size_of::<Cell>();
        let after = kept * size_of::<Cell>() + self.cells.len() * size_of::<u32>();
        if self.cells.len() <= FEW_CELLS || after > before / 2 {
            return;
        }
        let mut cells = Vec::with_capacity(kept);
        cells.extend(empty);
        let index = self.cells.iter().map(|cell| match which(cell) {
            Some(same) => same as u32,
            None => {
                cells.push(*cell);
                cells.len() as u32 - 1
            }
        });
        self.index = index.collect();
        self.cells = cells;
    }

    pub(super) fn bytes(&self) -> usize {
        self.cells.capacity() * size_of::<Cell>()
            + (self.index.capacity() + self.many.capacity()) * size_of::<u32>()
    }

    /// The cell at a place of the grid.
    #[inline]
    fn at(&self, place: usize) -> &Cell {
        if self.index.is_empty() {
            &self.cells[place]
        } else {
            &self.cells[self.index[place] as usize]
        }
    }

    fn cell(&self, i: usize, j: usize) -> usize {
        j * self.axes[0].count + i
    }

    /// Puts each part into the cells that a point of it may be in (rounding included), and has it keep to their strips.
    ///
    /// Between two of its points a curve is no farther from their segment, along an axis, than an eighth of its greatest second
    /// derivative times the square of the parameter between them.
    fn fill(&mut self, loops: &Loops) {
        let au = self.axes[0];
        // Parts that their cells have no room for.
        let mut more: Vec<(usize, u32)> = Vec::new();
        let mut own: Vec<(usize, [usize; 2], u32)> = Vec::new();
        let mut shares: Vec<(Stretch, [f64; 2])> = Vec::new();
        let mut group: Vec<(Stretch, [f64; 2])> = Vec::new();
        let mut stack = Vec::new();
        // A curved piece: which, and what its parts need of it, one after the other.
        let mut curved: Option<(u32, [f64; 2], Horner<f64>)> = None;
        for (k, part) in loops.parts.iter().enumerate() {
            own.clear();
            shares.clear();
            let piece = part.piece(loops);
            if piece.segment().is_some() {
                curved = None;
            } else if curved.as_ref().is_none_or(|(of, ..)| *of != part.piece) {
                // For this alone it is not kept.
                let balls = piece.source.balls();
                let bend = Control::new(&balls).bend(&piece.hull);
                curved = Some((part.piece, bend, Horner::new(&balls)));
            }
            let curve = curved.as_ref().map(|(.., horner)| horner);
            // A gap is a box, not only its diagonal.
            let whole = part.join || !part.is_monotone();
            let bend = curved.as_ref().map_or([0.0; 2], |(_, bend, _)| *bend);
            let blur = part.blur(loops, curve);
            let rises = [0, 1].map(|i| part.trends[i] == Trend::Up);
            stack.push((part.t(loops), part.hull, 0));
            while let Some((t, hull, level)) = stack.pop() {
                let width = t[1] - t[0];
                let bulge = [0, 1].map(|i| 0.125 * width * width * bend[i]);
                let bounds = [0, 1].map(|i| hull[i].map(|x| self.axes[i].scaled(x)));
                let spans = [0, 1].map(|i| {
                    let [low, high] = bounds[i];
                    self.axes[i].span([low - MARGIN, high + MARGIN])
                });
                let narrow = spans.iter().any(|s| s[0] == s[1]);
                let flat = (0..2).all(|i| bulge[i] * self.axes[i].rate <= FLAT);
                let most = if narrow { FEW_HALVINGS } else { MOST_HALVINGS };
                if let Some(curve) = curve
                    && !whole
                    && !flat
                    && level < most
                {
                    let middle = 0.5 * (t[0] + t[1]);
                    let m = curve.enclosure(middle);
                    // A monotone part runs from corner to corner of its box, through m.
                    let side = |up: bool, axis: usize| {
                        let [lo, hi] = hull[axis];
                        if up {
                            [m[axis][0].max(lo), hi]
                        } else {
                            [lo, m[axis][1].min(hi)]
                        }
                    };
                    let first = [0, 1].map(|i| side(!rises[i], i));
                    let second = [0, 1].map(|i| side(rises[i], i));
                    stack.push(([middle, t[1]], second, level + 1));
                    stack.push(([t[0], middle], first, level + 1));
                    continue;
                }
                let end = |e: bool| [0, 1].map(|i| bounds[i][usize::from(rises[i] == e)]);
                let stretch = if whole {
                    let middle = bounds.map(|[a, b]| 0.5 * (a + b));
                    let half = bounds.map(|[a, b]| 0.5 * (b - a));
                    Stretch::new(middle, middle, half)
                } else {
                    let off = [0, 1].map(|i| (bulge[i] + blur[i]) * self.axes[i].rate);
                    Stretch::new(end(false), end(true), off)
                };
                for j in spans[1][0]..=spans[1][1] {
                    let share = stretch.over(1, [j, j], [0.0, 1.0]);
                    if share[0] > share[1] {
                        continue;
                    }
                    let [first, last] = au.span(stretch.range(0, share));
                    for i in first.max(spans[0][0])..=last.min(spans[0][1]) {
                        let share = stretch.over(0, [i, i], share);
                        if share[0] > share[1] {
                            continue;
                        }
                        own.push((self.cell(i, j), [i, j], shares.len() as u32));
                        shares.push((stretch, share));
                    }
                }
            }
            own.sort_unstable();
            for list in own.chunk_by(|a, b| a.0 == b.0) {
                let Some((c, at, _)) = list.first() else {
                    continue;
                };
                group.clear();
                group.extend(list.iter().map(|(_, _, s)| shares[*s as usize]));
                let cell = &mut self.cells[*c];
                Strip::add(&mut cell.strips, &group, *at);
                more.extend(cell.push(k as u32).map(|k| (*c, k)));
            }
        }
        more.sort_unstable();
        for list in more.chunk_by(|a, b| a.0 == b.0) {
            if let Some((c, _)) = list.first() {
                let parts = list.iter().map(|(_, k)| *k);
                self.cells[*c].push_all(parts, &mut self.many);
            }
        }
        self.many.shrink_to_fit();
    }

    fn reference(&self, i: usize, j: usize) -> [f64; 2] {
        [
            self.axes[0].at(i, REFERENCE[0]),
            self.axes[1].at(j, REFERENCE[1]),
        ]
    }

    /// The parities of the reference points, a row at a time: a part counts for all reference points left
    /// of its box (by the states at its ends alone), and is asked for those within.
    fn settle(&mut self, loops: &Loops) {
        let [au, av] = self.axes;
        let mut rows: Vec<Vec<u32>> = vec![Vec::new(); av.count];
        for (k, part) in loops.parts.iter().enumerate() {
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
                let part = &loops.parts[*k as usize];
                let (i0, i1) = (au.index(part.hull[0][0]), au.index(part.hull[0][1]));
                for i in i0..=i1 {
                    match part.crossing_in(loops, self.reference(i, j), 0) {
                        Crossing::Even => {}
                        Crossing::Odd => odd[i] = !odd[i],
                        Crossing::On | Crossing::Unknown => lost[i] = true,
                    }
                }
                if i0 > 0 {
                    // All reference points of the cells to the left are left of the part.
                    let left = [part.hull[0][0].next_down(), self.reference(0, j)[1]];
                    match part.crossing_in(loops, left, 0) {
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
                self.set_side([i, j], r, parity);
                for k in self.cells[c].items(&self.many) {
                    let part = &loops.parts[*k as usize];
                    match part.crossing_in(loops, r, 1) {
                        Crossing::Even => {}
                        Crossing::Odd => parity = !parity,
                        Crossing::On | Crossing::Unknown => good = false,
                    }
                }
                if good {
                    self.cells[c].set_reference(parity);
                }
            }
        }
    }

    /// Gives the parity of a point in a cell to its side of the strips.
    fn set_side(&mut self, [i, j]: [usize; 2], q: [f64; 2], odd: bool) {
        let ((own_i, x), (own_j, y)) = (self.axes[0].place(q[0]), self.axes[1].place(q[1]));
        let cell = &mut self.cells[j * self.axes[0].count + i];
        let (side, within) = cell.side([x, y]);
        if (own_i, own_j) == (i, j) && !within && !cell.knows(side) {
            cell.set_parity(side, odd);
        }
    }

    /// The parities of the sides of cells that have parts: from the cells before them, as a point of the edge that they share has one
    /// parity (even where it is on the border of the box of all parts, and beside points beyond), or else by a point of the side, if one is found.
    fn settle_sides(&mut self, loops: &Loops) {
        let [au, av] = self.axes;
        for c in 0..self.cells.len() {
            let (i, j) = (c % au.count, c / au.count);
            for place in SAMPLES {
                let cell = &self.cells[c];
                if cell.is_settled() {
                    break;
                }
                let (side, within) = cell.side(place);
                if within || cell.knows(side) {
                    continue;
                }
                let [x, y] = place;
                let odd = if x == 0 {
                    match i {
                        0 => Some(false),
                        _ => self.cells[c - 1].told([CELL, y]),
                    }
                } else if y == 0 {
                    match j {
                        0 => Some(false),
                        _ => self.cells[c - au.count].told([x, CELL]),
                    }
                } else {
                    let at = place.map(|x| f64::from(x) / f64::from(CELL));
                    let q = [au.at(i, at[0]), av.at(j, at[1])];
                    // Rounded, it may be elsewhere.
                    let ((own_i, x), (own_j, y)) = (au.place(q[0]), av.place(q[1]));
                    let own = (own_i, own_j) == (i, j) && cell.side([x, y]) == (side, false);
                    match self.by_parts(loops, q, c) {
                        Local::Odd(odd) if own => Some(odd),
                        _ => None,
                    }
                };
                if let Some(odd) = odd {
                    self.cells[c].set_parity(side, odd);
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
        self.at(c).items(&self.many)
    }

    /// Each cell's parts: two parts with a point in common have a cell in common, that of the point.
    pub(super) fn lists(&self) -> impl Iterator<Item = &[u32]> {
        self.cells.iter().map(|c| c.items(&self.many))
    }

    /// The cells that a box meets, each with its parts.
    pub(super) fn meeting(&self, b: [[f64; 2]; 2]) -> impl Iterator<Item = &[u32]> {
        let [au, av] = self.axes;
        let (i0, i1) = (au.index(b[0][0]), au.index(b[0][1]));
        let (j0, j1) = (av.index(b[1][0]), av.index(b[1][1]));
        (j0..=j1)
            .flat_map(move |j| self.cell(i0, j)..=self.cell(i1, j))
            .map(|c| self.at(c).items(&self.many))
    }

    /// The parity of a point that is not [`beyond`](Self::beyond).
    #[inline]
    pub(super) fn parity(&self, loops: &Loops, q: [f64; 2]) -> Local {
        let ((i, x), (j, y)) = (self.axes[0].place(q[0]), self.axes[1].place(q[1]));
        let c = self.cell(i, j);
        match self.at(c).told([x, y]) {
            Some(odd) => Local::Odd(odd),
            None => self.by_parts(loops, q, c),
        }
    }

    /// The same, by the parts of its cell.
    ///
    /// Legs: from `q` along u to the corner `(r_u, q_v)`, from there along v to the reference point r. Crossings of
    /// the first are those of the ray from q without those of the ray from the corner, and likewise the second.
    /// A part that does not meet the cell (a box that holds both legs) has none; one that does has all its
    /// crossings counted, and where two parts share a joint on a leg, both are listed. Should the
    /// corner be on a loop, as that of each point at the height of an edge along u may be, the legs do not tell, but others may.
    #[inline(never)]
    fn by_parts(&self, loops: &Loops, q: [f64; 2], c: usize) -> Local {
        let cell = self.at(c);
        let Some(odd) = cell.reference() else {
            return Local::Elsewhere;
        };
        let items = cell.items(&self.many);
        let i = c % self.axes[0].count;
        let corner = [self.axes[0].at(i, REFERENCE[0]), q[1]];
        let (mut odd, mut lost) = (odd, false);
        for k in items {
            let part = &loops.parts[*k as usize];
            match part.crossing_in(loops, q, 0) {
                Crossing::Even => {}
                Crossing::Odd => odd = !odd,
                Crossing::On => return Local::On,
                Crossing::Unknown => lost = true,
            }
            for ray in 0..2 {
                match part.crossing_in(loops, corner, ray) {
                    Crossing::Even => {}
                    Crossing::Odd => odd = !odd,
                    Crossing::On | Crossing::Unknown => lost = true,
                }
            }
        }
        if lost {
            return self.by_other_legs(loops, q, c);
        }
        Local::Odd(odd)
    }

    /// The same by the way round the other corner, `k = (q_u, r_v)`: from `q` along v to it, from there along u to the reference point r.
    ///
    /// Where neither end of a leg is on a loop, the parities of both differ by the crossings of the rays along the leg from both: `p(q) - p(k)` by those along v
    /// from `q` and `k`, `p(k) - p(r)` by those along u from `k` and r; other parts than the cell's have as many with either ray. The cell keeps `p(r)` with the crossings
    /// along v from r, which are counted once more and so taken out again. What is on a loop is told nothing.
    #[cold]
    fn by_other_legs(&self, loops: &Loops, q: [f64; 2], c: usize) -> Local {
        let cell = self.at(c);
        let Some(mut odd) = cell.reference() else {
            return Local::Elsewhere;
        };
        let r = self.reference(c % self.axes[0].count, c / self.axes[0].count);
        let corner = [q[0], r[1]];
        for k in cell.items(&self.many) {
            let part = &loops.parts[*k as usize];
            for (at, ray) in [(q, 1), (corner, 1), (corner, 0), (r, 0), (r, 1)] {
                match part.crossing_in(loops, at, ray) {
                    Crossing::Even => {}
                    Crossing::Odd => odd = !odd,
                    Crossing::On | Crossing::Unknown => return Local::Elsewhere,
                }
            }
        }
        Local::Odd(odd)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trim::tests::shapes::{Use, bezier, circle, face, polygon};
    use crate::trim::{BoxSide, TrimRegion};
    use proptest::prelude::*;

    const WIDE: [f64; 4] = [-64.0, 64.0, -64.0, 64.0];

    /// What the strips of a point's cell tell, which must be what all parts say.
    fn told(region: &TrimRegion, q: [f64; 2]) -> Option<bool> {
        let cells = region.cells();
        if cells.beyond(q) {
            return None;
        }
        let ((i, x), (j, y)) = (cells.axes[0].place(q[0]), cells.axes[1].place(q[1]));
        // Either way round tells the same, if it tells anything.
        if let Local::Odd(odd) = cells.by_other_legs(region.loops(), q, cells.cell(i, j)) {
            assert_eq!(region.parity_of_all(q), Crossing::odd(odd), "{q:?}");
        }
        let odd = cells.at(cells.cell(i, j)).told([x, y])?;
        assert_eq!(region.parity_of_all(q), Crossing::odd(odd), "{q:?}");
        Some(odd)
    }

    fn nudged(x: f64, n: i8) -> f64 {
        (0..n.unsigned_abs() % 3).fold(x, |x, _| if n > 0 { x.next_up() } else { x.next_down() })
    }

    /// A point of a cell at a border of a strip, a few places off and then a few roundings.
    fn on_a_border(cells: &Cells, [c, y]: [u16; 2], off: [i8; 3]) -> Option<[f64; 2]> {
        let (i, j) = (
            usize::from(c) % cells.axes[0].count,
            usize::from(c) / 8 % cells.axes[1].count,
        );
        let strips = cells.at(cells.cell(i, j)).strips;
        let place =
            strips[usize::from(y) % STRIPS].on_border(y & 32 != 0, i32::from(y) % 1024 * 64)?;
        let at = place.map(|x| f64::from(x + i32::from(off[2]) % 4) / f64::from(CELL));
        let q = [cells.axes[0].at(i, at[0]), cells.axes[1].at(j, at[1])];
        Some([nudged(q[0], off[0]), nudged(q[1], off[1])])
    }

    /// A point of a Bezier curve, about.
    fn on(net: &[[f64; 3]], t: f64) -> [f64; 2] {
        let mut d = net.to_vec();
        while d.len() > 1 {
            let mix = |w: &[[f64; 3]]| [0, 1, 2].map(|i| w[0][i] * (1.0 - t) + w[1][i] * t);
            d = d.windows(2).map(mix).collect();
        }
        [d[0][0] / d[0][2], d[0][1] / d[0][2]]
    }

    fn net() -> impl Strategy<Value = Vec<[f64; 3]>> {
        let point = (-64i32..=64, -64i32..=64, 2i32..=8).prop_map(|(x, y, w)| {
            let w = f64::from(w) / 4.0;
            [f64::from(x) * w / 4.0, f64::from(y) * w / 4.0, w]
        });
        proptest::collection::vec(point, 2..=6)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

        /// Points anywhere, on the borders of strips, and on curves, and a few roundings off.
        #[test]
        fn strips_say_what_all_parts_say(
            nets in proptest::collection::vec(net(), 1..=5),
            anywhere in proptest::collection::vec(any::<[i16; 2]>(), 64),
            borders in proptest::collection::vec(any::<([u16; 2], [i8; 3])>(), 64),
            ons in proptest::collection::vec(any::<(u8, u16, [i8; 2])>(), 32),
        ) {
            let loops = nets.iter().map(|n| vec![Use::from(bezier(n))]).collect();
            let region = TrimRegion::new(&face(WIDE, Some(loops)), 0);
            for q in anywhere {
                told(&region, q.map(|x| f64::from(x) / 2048.0));
            }
            for (at, off) in borders {
                if let Some(q) = on_a_border(region.cells(), at, off) {
                    told(&region, q);
                }
            }
            for (k, t, off) in ons {
                let q = on(&nets[usize::from(k) % nets.len()], f64::from(t) / 65535.0);
                told(&region, [nudged(q[0], off[0]), nudged(q[1], off[1])]);
            }
        }
    }

    /// A circle of so many sides passes few of its cells: the others are kept as two.
    #[test]
    fn empty_cells_are_kept_once() {
        let corner = |k: u32| {
            let (sin, cos) = (f64::from(k) / 2048.0 * std::f64::consts::TAU).sin_cos();
            [cos, sin]
        };
        let sides = polygon(&(0..2048).map(corner).collect::<Vec<_>>());
        let region = TrimRegion::new(&face(WIDE, Some(vec![sides])), 0);
        let cells = region.cells();
        assert!(cells.index.len() > 4 * cells.cells.len());
        let mut count = [0; 2];
        for i in 0..200 {
            for j in 0..200 {
                let q = [i, j].map(|k| -0.99 + 1.98 * f64::from(k) / 199.0);
                if let Some(odd) = told(&region, q) {
                    count[usize::from(odd)] += 1;
                }
            }
        }
        assert!(count[0] > 7000 && count[1] > 30_000, "{count:?}");
        // Boxes away from it, and one that it passes.
        let at = |u: [f64; 2]| region.classify_box(u, [-0.25, 0.25]);
        assert_eq!(at([-0.5, 0.5]), BoxSide::Inside);
        assert_eq!(at([1.5, 2.0]), BoxSide::Outside);
        assert_eq!(at([0.5, 1.0]), BoxSide::Mixed);
    }

    /// Strips are thin: most points are told by them.
    #[test]
    fn most_points_are_told_by_strips() {
        let loops = (0..64).map(|k| circle([f64::from(k % 8), f64::from(k / 8)], 0.375));
        let region = TrimRegion::new(&face(WIDE, Some(loops.collect())), 0);
        let mut count = [0; 2];
        for i in 0..100 {
            for j in 0..100 {
                let q = [i, j].map(|k| -0.37 + 7.74 * f64::from(k) / 99.0);
                if let Some(odd) = told(&region, q) {
                    count[usize::from(odd)] += 1;
                }
            }
        }
        assert!(count[0] > 4500 && count[1] > 3500, "{count:?}");
    }

    /// A side so short that its inverse is infinite, where the grid begins: coordinates near 0 are in cells what they are.
    #[test]
    fn a_side_may_be_all_but_a_point() {
        for short in [1e-300, 1e-310, 5e-324] {
            // That side comes first: it has a strip of its own.
            let square = [
                [short, 0.0],
                [0.0, short],
                [0.0, 1.0],
                [1.0, 1.0],
                [1.0, 0.0],
            ];
            let turned = square.map(|[u, v]| [v, u]);
            for corners in [square, turned] {
                let region = TrimRegion::new(&face(WIDE, Some(vec![polygon(&corners)])), 0);
                assert_eq!(told(&region, [0.3, 0.4]), Some(true), "{short:e}");
            }
        }
    }

    /// Corners of the hole are reference points, to the last digit; of these cells nothing is known, though the rays from such a point that
    /// half-open rules leave are even each: `tests/it/regions.rs` asks about points in them.
    #[test]
    fn nothing_is_known_of_a_reference_on_a_loop() {
        let corner = |k: usize| {
            let k = k as f64;
            [-10.0 + (k + REFERENCE[0]), -6.0 + (k + REFERENCE[1])]
        };
        let bottom = (0..8).map(|k| [-10.0 + 2.5 * f64::from(k), -6.0]);
        let mut outer: Vec<[f64; 2]> = bottom.chain([[10.0, -6.0], [10.0, 0.0]]).collect();
        let turned: Vec<[f64; 2]> = outer.iter().map(|p| p.map(|x| -x)).collect();
        outer.extend(turned);
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
            assert_eq!(cells.at(cells.cell(k, k)).reference(), None, "{k}");
        }
        let told = cells.cells.iter();
        let told = told.filter(|c| c.reference().is_some());
        assert_eq!(told.count(), 240 - 7);
    }

    /// Battlements: at the heights of their edges one corner of the legs is on an edge in many cells, and the other is not.
    #[test]
    fn points_at_the_heights_of_edges_are_told_by_their_cells() {
        const TEETH: usize = 24;
        let mut corners = vec![[-12.0, -5.0], [12.0, -5.0]];
        for k in (0..TEETH).rev() {
            let x = k as f64 - 12.0;
            corners.extend([
                [x + 0.9, -3.0],
                [x + 0.9, 4.0],
                [x + 0.3, 4.0],
                [x + 0.3, -3.0],
            ]);
        }
        let turned: Vec<[f64; 2]> = corners.iter().map(|[u, v]| [*v, *u]).collect();
        for (corners, across) in [(corners, 1), (turned, 0)] {
            let region = TrimRegion::new(&face(WIDE, Some(vec![polygon(&corners)])), 0);
            let cells = region.cells();
            assert!(cells.axes[1 - across].count > TEETH);
            let mut other = 0;
            for k in 0..1000 {
                for height in [-5.0, -3.0, 4.0] {
                    let mut q = [height; 2];
                    q[1 - across] = -11.99 + 0.024 * f64::from(k);
                    let c = cells.cell(cells.axes[0].index(q[0]), cells.axes[1].index(q[1]));
                    let all = region.parity_of_all(q);
                    match cells.by_parts(region.loops(), q, c) {
                        Local::Odd(odd) => assert_eq!(all, Crossing::odd(odd), "{q:?}"),
                        Local::On => assert_eq!(all, Crossing::On, "{q:?}"),
                        Local::Elsewhere => other += 1,
                    }
                }
            }
            assert_eq!(other, 0);
        }
    }
}
