//! Strips of a cell: what keeps to them leaves the rest of the cell to sides that need no part looked at.
//!
//! A cell is the unit square here, in coordinates `x = (u - origin) rate - i` and likewise y. A strip
//! is where `range[0] <= n.(x, y) <= range[1]`. All that the loops have in a cell keeps to its strips. The points of the
//! cell on one side of each strip are convex, so that no loop meets the way between two of them: they have one parity.

/// Bits of a cell's coordinates that are looked at.
pub(super) const BITS: u32 = 16;

/// A strip's units are finer than a cell by this (times the length of its normal).
const UNITS: f64 = 128.0;
/// From a strip's units to those of a level.
const SHIFT: u32 = BITS - 7;

/// How far beyond its cell, in cells, a point may be: places in up to 2^21 cells along an axis are rounded by
/// less than 2^-28, and a segment's in them by a few times as much.
pub(super) const MARGIN: f64 = 1.0 / (1u64 << 20) as f64;

/// What is beyond all cells, in cells.
const BEYOND: f64 = (1u64 << 40) as f64;

/// A stretch of a curve, in cells: no farther from a segment than `off` along each axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    from: [f64; 2],
    step: [f64; 2],
    /// Of `step`.
    inverse: [f64; 2],
    off: [f64; 2],
}

impl Stretch {
    pub(super) fn new(from: [f64; 2], to: [f64; 2], off: [f64; 2]) -> Self {
        let step = [0, 1].map(|c| to[c] - from[c]);
        let known = [from, step, off].iter().flatten().all(|x| x.abs() < BEYOND);
        let (from, step, off) = if known {
            (from, step, off)
        } else {
            ([0.0; 2], [0.0; 2], [BEYOND; 2])
        };
        let inverse = step.map(|x| 1.0 / x);
        Self {
            from,
            step,
            inverse,
            off,
        }
    }

    /// What of the segment, in shares of it, may be over cells `first..=last` along an axis, out of `share`; no share where none is.
    #[inline]
    pub(super) fn over(&self, axis: usize, [first, last]: [usize; 2], share: [f64; 2]) -> [f64; 2] {
        let reach = self.off[axis] + MARGIN;
        let near = first as f64 - reach - self.from[axis];
        let far = (last + 1) as f64 + reach - self.from[axis];
        if !self.inverse[axis].is_finite() {
            // Hardly a step: all of it is within the margin of its start.
            let none = near > 0.0 || far < 0.0;
            return if none { [1.0, 0.0] } else { share };
        }
        let (a, b) = (near * self.inverse[axis], far * self.inverse[axis]);
        [share[0].max(a.min(b)), share[1].min(a.max(b))]
    }

    /// The range along an axis of what is off this share of the segment.
    #[inline]
    pub(super) fn range(&self, axis: usize, share: [f64; 2]) -> [f64; 2] {
        let [a, b] = share.map(|s| self.from[axis] + s * self.step[axis]);
        let reach = self.off[axis] + MARGIN;
        [a.min(b) - reach, a.max(b) + reach]
    }

    /// The point at a share of the segment.
    fn at(&self, share: f64) -> [f64; 2] {
        [0, 1].map(|c| self.from[c] + share * self.step[c])
    }

    /// The range of levels of a share in a cell.
    #[inline]
    fn levels(&self, normal: [i8; 2], cell: [usize; 2], share: [f64; 2]) -> [f64; 2] {
        let n = normal.map(f64::from);
        let base = [0, 1].map(|c| self.from[c] - cell[c] as f64);
        let at = |s: f64| (base[0] + s * self.step[0]) * n[0] + (base[1] + s * self.step[1]) * n[1];
        let [a, b] = share.map(at);
        let off = n[0].abs() * self.off[0] + n[1].abs() * self.off[1];
        [a.min(b) - off, a.max(b) + off]
    }
}

/// What a part has in a cell: shares of stretches, in its order.
pub(super) type Shares<'a> = &'a [(Stretch, [f64; 2])];

/// Across the way from where a part enters a cell to where it leaves it, as well as that can be said.
fn normal(shares: Shares) -> [i8; 2] {
    let [Some((first, [from, _])), Some((last, [_, to]))] = [shares.first(), shares.last()] else {
        return [127, 0];
    };
    let (a, b) = (first.at(*from), last.at(*to));
    let n = [a[1] - b[1], b[0] - a[0]];
    let most = n[0].abs().max(n[1].abs());
    if most == 0.0 {
        return [127, 0];
    }
    // Rounded to nearest. (A quotient of what is all but nothing is within 1 still; an inverse would be infinite.)
    n.map(|x| ((x / most * 127.0 + 127.5) as i16 - 127) as i8)
}

/// A strip; with no normal, none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    normal: [i8; 2],
    range: [i16; 2],
}

/// Growth of a strip, in its units, that is better than another strip: a sixteenth of a cell.
const LITTLE: i32 = 127 * 128 / 16;

impl Strip {
    /// All points are above it.
    pub(super) const NONE: Self = Self {
        normal: [0; 2],
        range: [i16::MIN; 2],
    };

    /// Whether a point of the cell is above the strip, and whether it is in it. Coordinates in `[0, 1]` as whole numbers of 2^-16, rounded down.
    ///
    /// A level is off by less than `|n| <= 254` units of rounding, half a unit of the strip's. Levels of points, `|level| <= 254 * 2^16`,
    /// are less than `2^15` units of the strip's.
    #[inline]
    pub(super) fn sign(&self, place: [i32; 2]) -> (bool, bool) {
        let level = i32::from(self.normal[0]) * place[0] + i32::from(self.normal[1]) * place[1];
        let [low, high] = self.range.map(|x| i32::from(x) << SHIFT);
        (level > high, (level >= low) & (level <= high))
    }

    pub(super) fn is_none(&self) -> bool {
        self.normal == [0; 2]
    }

    /// With all of these in it, and a unit on either side, which is more than levels of points are off.
    fn around(normal: [i8; 2], shares: Shares, cell: [usize; 2]) -> Self {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for (stretch, share) in shares {
            let [low, high] = stretch.levels(normal, cell, *share);
            range = [range[0].min(low), range[1].max(high)];
        }
        // (`as` saturates: beyond all levels that a point of the cell has.)
        let low = (range[0] * UNITS - 2.0) as i16;
        let high = (range[1] * UNITS + 2.0) as i16;
        Self {
            normal,
            range: [low, high],
        }
    }

    fn with(&self, other: Self) -> Self {
        Self {
            normal: self.normal,
            range: [
                self.range[0].min(other.range[0]),
                self.range[1].max(other.range[1]),
            ],
        }
    }

    fn width(&self) -> i32 {
        i32::from(self.range[1]) - i32::from(self.range[0])
    }

    /// Has what a part has in the cell keep to one of these: one that hardly grows, a new one, or what grows least.
    pub(super) fn add(strips: &mut [Self], shares: Shares, cell: [usize; 2]) {
        let mut least: Option<(i32, &mut Self, Self)> = None;
        for strip in strips {
            if strip.is_none() {
                if least.as_ref().is_none_or(|(growth, ..)| *growth > LITTLE) {
                    *strip = Self::around(normal(shares), shares, cell);
                    return;
                }
                break;
            }
            let grown = strip.with(Self::around(strip.normal, shares, cell));
            let growth = grown.width() - strip.width();
            if least.as_ref().is_none_or(|(least, ..)| growth < *least) {
                least = Some((growth, strip, grown));
            }
        }
        if let Some((_, strip, grown)) = least {
            *strip = grown;
        }
    }

    /// A place in its cell where a level is the strip's least or greatest, about: one of its coordinates is given.
    #[cfg(test)]
    pub(super) fn on_border(&self, upper: bool, other: i32) -> Option<[i32; 2]> {
        let n = self.normal.map(i32::from);
        let level = i32::from(self.range[usize::from(upper)]) << SHIFT;
        let axis = usize::from(n[0].abs() < n[1].abs());
        let mut place = [other; 2];
        place[axis] = (level - n[1 - axis] * other).checked_div(n[axis])?;
        (0..=1 << BITS).contains(&place[axis]).then_some(place)
    }
}
