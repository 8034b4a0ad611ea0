//! The image of a trim curve in space, as rational Bezier curves in a row.
//!
//! The image is `S(clamp(c))`, `clamp` moving each parameter to the nearest one in the domain of the surface. A trim
//! is cut where it passes from patch to patch or over the border of the domain, as finely as the arithmetic can, and
//! each part is composed with its patch. What is left between two parts, a piece of the curve of about one
//! rounding, goes into [`Image::extra`]; so does a part that cannot be composed.

use super::boundary::{CurveSource, UvCurve, trim_curves, trim_end, uv_curve};
use super::closed::V3;
use super::compose::compose;
use super::matching::Pair;
use super::net::{curve_jet, halves_of, part_of};
use super::patch::COMPOSE_HALVINGS;
use super::patch::Lent;
use super::spline::curve_pieces;
use super::{Box3, FaceGeometry, Homogeneous, Net, ParamMap, Patch, Patches};
use crate::brep::Brep;
use crate::numeric::bernstein::{Bidegree, evaluate};
use crate::numeric::{Ball, Dd, Enclosure, Interval, Real};
use crate::nurbs::Curve3;
use std::sync::OnceLock;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Halvings down to one rounding of the curve's parameter in f64.
const HALVINGS: u32 = 52;
/// A curve that stays within so many roundings of a border is not cut there; where the first makes too many cuts,
/// the next.
const ROUNDINGS: [f64; 5] = [8.0, 512.0, 32768.0, 4_194_304.0, 268_435_456.0];
/// A curve is cut into no more parts than this...
const MOST_PARTS: usize = 4096;
/// ...and crosses no more borders than this; else its image counts as not known.
const MOST_CROSSINGS: usize = 64;

/// A rational Bezier curve with exact control points `(X, w)`, `w > 0`, relative to an origin.
#[derive(Clone, Debug)]
pub(crate) struct Stretch<T> {
    pub(crate) points: Vec<[T; 4]>,
    pub(crate) origin: [f64; 3],
    /// How far the image may be from this curve at the same parameter.
    pub(crate) slack: f64,
    /// A box around this curve.
    pub(crate) bounds: Box3,
}

impl<T: Real> Stretch<T> {
    /// The curve.
    pub(crate) fn net(&self) -> Net<T> {
        let known = |mid: T| Ball { mid, rad: 0.0 };
        let u = self.points.len() - 1;
        let points = self.points.iter().map(|p| p.map(known)).collect();
        Net::new(Bidegree { u, v: 0 }, points, self.origin)
    }
}

impl Stretch<Dd> {
    /// The point of the curve at a parameter.
    pub(crate) fn point(&self, at: Dd) -> V3 {
        let value = |c: usize| {
            let known = |p: &[Dd; 4]| Ball {
                mid: p[c],
                rad: 0.0,
            };
            evaluate(
                self.points.iter().map(known).collect(),
                Ball { mid: at, rad: 0.0 },
            )
        };
        let w = value(3);
        std::array::from_fn(|c| value(c) / w + Ball::exact(self.origin[c]))
    }
}

/// The image of a trim, in the trim's direction.
#[derive(Clone, Debug)]
pub(crate) struct Image<T> {
    /// Not empty.
    pub(crate) stretches: Vec<Stretch<T>>,
    /// What is between (or before, or after) stretches stays within this of the ends next to it.
    pub(crate) extra: f64,
}

impl<T: Real> Image<T> {
    pub(super) fn reversed(mut self) -> Self {
        self.stretches.reverse();
        for s in &mut self.stretches {
            s.points.reverse();
        }
        self
    }

    /// Bytes of its lists, as large as they were reserved.
    pub(super) fn bytes(&self) -> usize {
        let points = self.stretches.iter().map(|s| s.points.capacity());
        self.stretches.capacity() * size_of::<Stretch<T>>()
            + points.sum::<usize>() * size_of::<[T; 4]>()
    }

    /// How many control points a stretch has at most.
    pub(super) fn order(&self) -> usize {
        { self.stretches.iter() }
            .map(|s| s.points.len())
            .max()
            .unwrap_or(0)
    }

    /// A box around all of it.
    pub(crate) fn bounds(&self) -> Box3 {
        let mut out = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for s in &self.stretches {
            let slack = (s.slack + self.extra) * UP;
            for (o, b) in out.iter_mut().zip(&s.bounds) {
                *o = [
                    o[0].min((b[0] - slack).next_down()),
                    o[1].max((b[1] + slack).next_up()),
                ];
            }
        }
        out
    }

    /// About how long the longest chord from the start of a stretch is.
    pub(super) fn reach(&self) -> f64 {
        let mut most: f64 = 0.0;
        for s in &self.stretches {
            let q = |p: &[T; 4]| nalgebra::Vector3::from_fn(|c, _| (p[c] / p[3]).approximate());
            let start = q(&s.points[0]);
            most = s
                .points
                .iter()
                .fold(most, |m, p| m.max((q(p) - start).norm()));
        }
        most
    }
}

/// Exact control points from control points with bounds, and how far the curve may be from theirs: with `|dX_i| <= r_i`,
/// `|dw_i| <= s_i` the curve moves by `(dX - q dw) / w` where `q` is the point for the exact ones, no farther from the
/// origin than the farthest `q_i`; and `(sum r_i b_i) / (sum w_i b_i) <= max r_i / w_i`. `None` where a weight is
/// not proven to be positive.
pub(super) fn exact<T: Real, const H: usize>(
    points: &[Homogeneous<T, H>],
) -> Option<(Vec<[T; H]>, f64)> {
    let mut farthest: f64 = 0.0;
    for p in points {
        let w = p[H - 1].mid.approximate();
        // A weight with no bound to speak of has none from below either.
        if !p[H - 1].is_above(0.0) {
            return None;
        }
        let squares = (0..H - 1).map(|c| (p[c].mid.magnitude() / w).powi(2));
        farthest = farthest.max(squares.sum::<f64>().sqrt() * UP);
    }
    let mut slack: f64 = 0.0;
    for p in points {
        let squares = (0..H - 1).map(|c| p[c].rad * p[c].rad);
        let moved = squares.sum::<f64>().sqrt() + farthest * p[H - 1].rad;
        slack = slack.max(moved / p[H - 1].lower() * UP);
    }
    let mids = points.iter().map(|p| p.map(|x| x.mid)).collect();
    slack.is_finite().then_some((mids, slack))
}

/// Where along one parameter a part of a curve lies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cell {
    /// Before the domain: clamped to its start.
    Before,
    /// Over one patch.
    In(usize),
    /// After the domain: clamped to its end.
    After,
}

/// The cells of a grid of patches.
struct Grid<'a, T> {
    patches: &'a Patches<T>,
    /// Patches that are made for the image alone; of some surfaces they are kept instead.
    own: Box<[OnceLock<Lent<'a, T>>]>,
    maps: [Vec<ParamMap>; 2],
    /// Of each of the maps.
    borders: [Vec<Borders<T>>; 2],
    most: usize,
    /// How near a border a curve may wander, in roundings.
    roundings: f64,
}

/// Where a cell starts and ends.
struct Borders<T> {
    start: Ball<T>,
    end: Ball<T>,
    /// What a rounding of its parameters is at most.
    rounding: f64,
}

impl<T: Real> Borders<T> {
    fn new(m: &ParamMap) -> Self {
        Self {
            start: m.border(false),
            end: m.border(true),
            rounding: T::UNIT * m.start.abs().max(m.end.abs()),
        }
    }
}

impl<'a, T: Real> Grid<'a, T> {
    /// `most`: how many bytes the patches that are made, an image and the work for it may take; beyond there is none. Large
    /// patches are made for this once, where it does not matter how much they take: few queries come near where an image is needed.
    fn new(patches: &'a Patches<T>, most: usize) -> Option<Self> {
        let maps = patches.maps();
        let alone = most == usize::MAX && patches.are_large();
        let own = if alone { patches.len() } else { 0 };
        maps.iter().all(|m| !m.is_empty()).then(|| Self {
            patches,
            own: (0..own).map(|_| OnceLock::new()).collect(),
            borders: [0, 1].map(|k| maps[k].iter().map(Borders::new).collect()),
            maps,
            most,
            roundings: ROUNDINGS[0],
        })
    }

    /// Curves that stay so near a border are not cut there. (From a cell to the next it changes by less than these are long, so that starts less it stand in order, and ends
    /// and it: both are looked up by halving.)
    fn slack(&self, b: &Borders<T>) -> T {
        T::from_f64(self.roundings * b.rounding)
    }

    /// Bytes that are left beside so many and the patches that are made.
    fn room(&self, beside: usize) -> usize {
        self.most
            .saturating_sub(self.patches.made().saturating_add(beside))
    }

    /// A patch, where there is room to make it.
    fn made(&self, index: usize, beside: usize) -> Option<&Patch<T>> {
        if let Some(own) = self.own.get(index) {
            return Some(own.get_or_init(|| self.patches.lent(index)));
        }
        (self.patches.bytes_to_make(index) <= self.room(beside)).then(|| &self.patches[index])
    }

    /// The cell that a range of parameters lies in; `None` if in several.
    fn cell(&self, axis: usize, range: [T; 2]) -> Option<Cell> {
        let (borders, maps) = (&self.borders[axis], &self.maps[axis]);
        // The first that does not end before the range does: all later ones start later.
        let i = borders.partition_point(|b| range[1] > b.end.mid + self.slack(b));
        if let Some(b) = borders.get(i)
            && range[0] >= b.start.mid - self.slack(b)
            && range[1] <= b.end.mid + self.slack(b)
        {
            return Some(Cell::In(i));
        }
        if range[1] <= T::from_f64(maps[0].start) {
            return Some(Cell::Before);
        }
        (range[0] >= T::from_f64(maps[maps.len() - 1].end)).then_some(Cell::After)
    }

    /// How far a range reaches past its cell, in local units: from above, where the cell's border is known in a ball too.
    fn overhang(&self, axis: usize, cell: Cell, range: [T; 2]) -> f64 {
        let Cell::In(i) = cell else {
            return 0.0;
        };
        let Borders { start, end, .. } = &self.borders[axis][i];
        let low = (start.mid - range[0]).approximate() + start.rad;
        let high = (range[1] - end.mid).approximate() + end.rad;
        low.max(high).max(0.0) / least_length(&self.maps[axis][i]) * UP
    }

    /// The patches that a range of parameters may meet, with those beside it: first and last.
    fn met(&self, axis: usize, range: [T; 2]) -> [usize; 2] {
        let borders = &self.borders[axis];
        let past = |b: &Borders<T>| range[0] > b.end.mid + (self.slack(b) + T::from_f64(b.end.rad));
        let begun =
            |b: &Borders<T>| range[1] >= b.start.mid - (self.slack(b) + T::from_f64(b.start.rad));
        let (first, end) = (
            borders.partition_point(past),
            borders.partition_point(begun),
        );
        if first < end {
            [first, end - 1]
        } else {
            // Beside the domain.
            [0, borders.len() - 1]
        }
    }

    fn met_patches(&self, ranges: [[T; 2]; 2]) -> impl Iterator<Item = usize> {
        let [u, v] = [0, 1].map(|k| self.met(k, ranges[k]));
        let count_v = self.maps[1].len();
        (u[0]..=u[1]).flat_map(move |i| (v[0]..=v[1]).map(move |j| i * count_v + j))
    }

    /// A local length on a patch as a native one.
    fn native(&self, patch: &Patch<T>, local: [f64; 2], axis: usize) -> f64 {
        let m = &patch.maps[axis];
        local[axis] * m.length::<f64>().upper() * UP
    }

    /// How far the image may move in space where parameters in these ranges move by so much; of that they may go so far past a patch's border,
    /// on its polynomials. `beside`: bytes that are taken.
    fn distance(
        &self,
        ranges: [[T; 2]; 2],
        by: [f64; 2],
        past: [f64; 2],
        beside: usize,
    ) -> Option<f64> {
        // Of what is not a number there is no bound.
        if !by.iter().chain(&past).all(|x| *x >= 0.0) {
            return None;
        }
        let mut steepest: [f64; 2] = [0.0; 2];
        for index in self.met_patches(ranges) {
            let patch = self.made(index, beside)?;
            let least = [0, 1].map(|k| least_length(&patch.maps[k]));
            // What a rounding is of a short span is more than the usual.
            let own = (past[0] / least[0]).max(past[1] / least[1]) * UP;
            let slope = slopes(patch, own.max(EXTENSION))?;
            for k in 0..2 {
                steepest[k] = steepest[k].max(slope[k] / least[k]);
            }
        }
        let sum: f64 = (0..2)
            .map(|k| {
                if by[k] > 0.0 {
                    steepest[k] * by[k]
                } else {
                    0.0
                }
            })
            .sum();
        sum.is_finite().then_some(sum * UP)
    }

    fn patch(&self, u: Cell, v: Cell, beside: usize) -> Option<&Patch<T>> {
        let index = |cell: Cell, axis: usize| match cell {
            Cell::Before => 0,
            Cell::In(i) => i,
            Cell::After => self.maps[axis].len() - 1,
        };
        self.made(index(u, 0) * self.maps[1].len() + index(v, 1), beside)
    }
}

/// The length of a piece's native parameters from below.
fn least_length(m: &ParamMap) -> f64 {
    m.length::<f64>().lower()
}

/// A bound on the derivative of a patch along u and v (local parameters), up to `past` past its border; `None` where
/// there is none.
///
/// `S' = (X' - S w') / w` with `|X'| <= p max |X_(i+1) - X_i|`, likewise `w'`, and `|S| <= max |X_i / w_i|`. Past the border
/// by `d <= past` the control points become combinations of these with weights of sum 1 and absolute sum `(1 + 2 d)^p`. With
/// `p d max w / min w <= 1/64` the negative ones make up less than 1.05 p d, so that `w` loses less than 2 %, `S`
/// and the numerators grow by less than 4 % each: by [`PAST`] in all.
fn slopes<T: Real>(patch: &Patch<T>, past: f64) -> Option<[f64; 2]> {
    let degree = patch.net.degree;
    let points = &patch.net.points;
    let (mut low, mut high, mut far): (f64, f64, f64) = (f64::INFINITY, 0.0, 0.0);
    let length = |p: &Homogeneous<T, 4>| {
        let squares = (0..3).map(|c| p[c].magnitude().powi(2));
        squares.sum::<f64>().sqrt() * UP
    };
    for p in points {
        if !p[3].is_above(0.0) {
            return None;
        }
        low = low.min(p[3].lower());
        high = high.max(p[3].upper());
        far = far.max(length(p) / p[3].lower());
    }
    let width = degree.v + 1;
    let steep = |step: usize, p: usize, ends: &dyn Fn(usize) -> bool| {
        let (mut dx, mut dw): (f64, f64) = (0.0, 0.0);
        for i in (0..points.len()).filter(|i| !ends(*i)) {
            let d: Homogeneous<T, 4> = std::array::from_fn(|c| points[i + step][c] - points[i][c]);
            dx = dx.max(length(&d));
            dw = dw.max(d[3].magnitude());
        }
        (dx + far * dw) / low * p as f64 * UP
    };
    let u = steep(width, degree.u, &|i| i / width == degree.u);
    let v = steep(1, degree.v, &|i| i % width == degree.v);
    let tame = degree.u.max(degree.v) as f64 * past * high <= low / 64.0;
    tame.then_some([PAST * u, PAST * v])
}

/// See [`slopes`].
const PAST: f64 = 1.125;

/// How far past its border a patch may be followed without asking how far it is, in local parameters.
const EXTENSION: f64 = 1.0 / (1u64 << 20) as f64;

/// The range of a coordinate over a curve; `None` where it is not known.
fn range<T: Real>(points: &[Homogeneous<T, 3>], c: usize) -> Option<[T; 2]> {
    let mut out: Option<[T; 2]> = None;
    for p in points {
        let x = p[c] / p[2];
        if !(p[2].is_above(0.0) && x.rad.is_finite()) {
            return None;
        }
        // The sum is off by a rounding.
        let slack = T::from_f64((x.rad + 2.0 * T::UNIT * x.mid.magnitude()) * UP);
        let (low, high) = (x.mid - slack, x.mid + slack);
        out = Some(match out {
            None => [low, high],
            Some(r) => [
                if low < r[0] { low } else { r[0] },
                if high > r[1] { high } else { r[1] },
            ],
        });
    }
    out
}

/// A part of a curve: over one cell, or between cells.
struct Part<T> {
    from: f64,
    to: f64,
    cells: Option<[Cell; 2]>,
    /// How far it may reach past its cell, in local units: proven for each part that was put together here.
    overhang: [f64; 2],
    /// Only where between cells: its own points.
    points: Vec<Homogeneous<T, 3>>,
}

/// A curve without bounds, to guess where it crosses borders: what is guessed wrong costs time alone.
struct Plain {
    /// Control points times binomials.
    points: Vec<[f64; 3]>,
}

impl Plain {
    fn new<T: Real>(points: &[Homogeneous<T, 3>]) -> Self {
        let n = points.len() - 1;
        let mut binomial = 1.0;
        let scaled = points.iter().enumerate().map(|(i, p)| {
            let scaled = p.map(|x| x.mid.approximate() * binomial);
            binomial *= (n - i) as f64 / (i + 1) as f64;
            scaled
        });
        Self {
            points: scaled.collect(),
        }
    }

    /// A coordinate: numerator and denominator by Horner's scheme, in t / (1 - t) or the inverse of it (their common factor is left out).
    fn at(&self, t: f64, c: usize) -> f64 {
        let (mut x, mut w) = (0.0, 0.0);
        if t <= 0.5 {
            let s = t / (1.0 - t);
            for p in self.points.iter().rev() {
                (x, w) = (x * s + p[c], w * s + p[2]);
            }
        } else {
            let s = (1.0 - t) / t;
            for p in &self.points {
                (x, w) = (x * s + p[c], w * s + p[2]);
            }
        }
        x / w
    }
}

/// So many places where a curve crosses borders are guessed before it is halved instead.
const MOST_GUESSES: usize = 4 * MOST_CROSSINGS;

impl<T: Real> Grid<'_, T> {
    /// About where a curve crosses a border between two parameters, at the ends of which it is farther from it than it may wander; `None` where its ends may be in one cell.
    fn crossing(&self, curve: &Plain, from: f64, to: f64) -> Option<f64> {
        (0..2)
            .find_map(|axis| {
                let [a, b] = [from, to].map(|t| curve.at(t, axis));
                let borders = &self.borders[axis];
                let [low, high] = if a < b { [a, b] } else { [b, a] };
                let clear = |at: &Ball<T>, slack: T| {
                    let (at, slack) = (at.mid.approximate(), slack.approximate());
                    (low < at - slack && at + slack < high).then_some(at)
                };
                // The first start of a cell above the lower end, or the end of the last.
                let next = borders.partition_point(|b| b.start.mid.approximate() <= low);
                let border = borders[next..]
                    .iter()
                    .find_map(|b| clear(&b.start, self.slack(b)));
                let border =
                    border.or_else(|| borders.last().and_then(|b| clear(&b.end, self.slack(b))))?;
                let (mut from, mut to) = (from, to);
                while to - from > f64::EPSILON {
                    let middle = 0.5 * (from + to);
                    if (curve.at(middle, axis) < border) == (a < b) {
                        from = middle;
                    } else {
                        to = middle;
                    }
                }
                Some(0.5 * (from + to))
            })
            .filter(|t| from < *t && *t < to)
    }
}

impl<T> Part<T> {
    /// What it takes in a list: one that grows has room for twice as many, and is copied.
    fn bytes(&self) -> usize {
        3 * size_of::<Self>() + size_of_val(&self.points[..])
    }
}

/// Cuts a curve at the borders of cells; `None` if into too many parts, or more than there is room for beside so many bytes.
///
/// Where ends of a part are seen to be in different cells it is cut where it crosses a border, as floats tell; what is not proven to stay in a cell then is halved.
fn cut<T: Real>(
    grid: &Grid<T>,
    points: &[Homogeneous<T, 3>],
    beside: usize,
) -> Option<Vec<Part<T>>> {
    let mut out: Vec<Part<T>> = Vec::new();
    let mut crossings = 0;
    let mut room = grid.room(beside);
    let plain = Plain::new(points);
    // In finer arithmetic a place that floats tell is cut again on both sides.
    let mut guesses = if T::UNIT < f64::UNIT { 0 } else { MOST_GUESSES };
    let mut stack = vec![(0.0, 1.0, 0)];
    while let Some((from, to, depth)) = stack.pop() {
        if depth < HALVINGS
            && guesses > 0
            && let Some(middle) = grid.crossing(&plain, from, to)
        {
            guesses -= 1;
            stack.push((middle, to, depth));
            stack.push((from, middle, depth));
            continue;
        }
        let points = part_of(points, [from, to].map(T::from_f64));
        let ranges = [range(&points, 0)?, range(&points, 1)?];
        let cells = match (grid.cell(0, ranges[0]), grid.cell(1, ranges[1])) {
            (Some(u), Some(v)) => Some([u, v]),
            _ if depth < HALVINGS => {
                let middle = 0.5 * (from + to);
                stack.push((middle, to, depth + 1));
                stack.push((from, middle, depth + 1));
                continue;
            }
            _ => None,
        };
        let overhang = cells.map_or([0.0; 2], |cells| {
            std::array::from_fn(|k| grid.overhang(k, cells[k], ranges[k]))
        });
        match out.last_mut() {
            Some(last) if last.cells == cells && cells.is_some() => {
                last.to = to;
                for k in 0..2 {
                    last.overhang[k] = last.overhang[k].max(overhang[k]);
                }
            }
            _ => {
                crossings += usize::from(cells.is_none());
                if out.len() >= MOST_PARTS || crossings > MOST_CROSSINGS {
                    return None;
                }
                let part = Part {
                    from,
                    to,
                    cells,
                    overhang,
                    points: if cells.is_none() { points } else { Vec::new() },
                };
                room = room.checked_sub(part.bytes())?;
                out.push(part);
            }
        }
    }
    Some(out)
}

/// A part of a curve in the patch's local parameters, a coordinate that is off the domain at its border.
fn localized<T: Real>(
    points: &[Homogeneous<T, 3>],
    patch: &Patch<T>,
    cells: [Cell; 2],
) -> Vec<Homogeneous<T, 3>> {
    let local = |p: &Homogeneous<T, 3>, c: usize| {
        let m = &patch.maps[c];
        match cells[c] {
            Cell::Before => Ball::ZERO,
            Cell::After => p[2],
            Cell::In(_) if *m == ParamMap::new(0.0, m.end) => p[c] / Ball::exact(m.end),
            Cell::In(_) => m.local_of(p[c], p[2]),
        }
    };
    let both = |p| [local(p, 0), local(p, 1), p[2]];
    points.iter().map(both).collect()
}

/// Where local parameters are known no better than this, they are taken for exact ones.
const ROUGH: f64 = 1.0 / (1u64 << 30) as f64;

/// A curve in a patch's local parameters, and how far each of them may be from it. Over a span that is short for its parameters' size a rounding of them is much of it:
/// then the curve is the exact one of the middles. Composed with the patch, what is not known of local parameters counts once for each power, for a point as far as the
/// control points are from the origin; as a shift it counts for the way along the surface alone, which is short.
fn middles<T: Real>(local: Vec<Homogeneous<T, 3>>) -> Option<(Vec<Homogeneous<T, 3>>, [f64; 2])> {
    if !local.iter().flatten().any(|x| x.rad > ROUGH) {
        return Some((local, [0.0; 2]));
    }
    let along = |k: usize| -> Vec<_> { local.iter().map(|p| [p[k], p[2]]).collect() };
    let off = [exact(&along(0))?.1, exact(&along(1))?.1];
    let known = |x: Ball<T>| Ball { rad: 0.0, ..x };
    Some((local.into_iter().map(|p| p.map(known)).collect(), off))
}

/// Builds an image part by part.
struct Builder<T> {
    image: Image<T>,
    /// What the parts since the last stretch add.
    pending: f64,
    /// What it takes, and what it takes to match it with another, a pair for each stretch; with the parts that are gone through.
    bytes: usize,
}

impl<T: Real> Builder<T> {
    fn between(&mut self, diameter: f64) {
        self.pending += diameter;
        self.image.extra = self.image.extra.max(self.pending * UP);
    }

    /// `None` where something is not known. Crossings are cut `levels` times more, and what is better composed in parts is
    /// halved `parts` times.
    fn curve(
        &mut self,
        grid: &Grid<T>,
        points: &[Homogeneous<T, 3>],
        levels: u32,
        parts: u32,
    ) -> Option<()> {
        let cut = cut(grid, points, self.bytes)?;
        // With the points of one, those on the patch, and a half of them.
        let own = cut.iter().map(Part::bytes).sum::<usize>() + 4 * size_of_val(points);
        self.bytes += own;
        for part in cut {
            let Some([u, v]) = part.cells else {
                if levels > 0 {
                    self.curve(grid, &part.points, levels - 1, parts)?;
                } else {
                    let ranges = [range(&part.points, 0)?, range(&part.points, 1)?];
                    let widths = ranges.map(|r| (r[1] - r[0]).magnitude());
                    self.between(grid.distance(ranges, widths, [0.0; 2], self.bytes)?);
                }
                continue;
            };
            let patch = grid.patch(u, v, self.bytes)?;
            let points = part_of(points, [part.from, part.to].map(T::from_f64));
            let local = localized(&points, patch, [u, v]);
            if parts > 0 && patch.wants_parts(&local, T::UNIT) {
                for half in halves_of(&points) {
                    self.curve(grid, &half, levels, parts - 1)?;
                }
                continue;
            }
            let ranges = [range(&points, 0)?, range(&points, 1)?];
            if patch.work_bytes(local.len()) > grid.room(self.bytes) {
                return None;
            }
            let (local, rounded) = middles(local)?;
            let (space, moved, twist) = lifted(patch, &local);
            // Past the border the patch's polynomials go on by the overhang, and so does the image: on the next patch,
            // or along the border, to which it is clamped.
            let off = [0, 1].map(|k| (2.0 * part.overhang[k] + moved[k] + rounded[k]) * UP);
            let past = [0, 1].map(|k| grid.native(patch, off, k));
            let Some(space) = space else {
                // As far as the parameters go, all over the patch at most.
                let widths = std::array::from_fn(|k| {
                    (ranges[k][1] - ranges[k][0]).magnitude() + 2.0 * past[k]
                });
                self.between(grid.distance(ranges, widths, past, self.bytes)?);
                continue;
            };
            let (points, mut slack) = exact(&space)?;
            slack += twist;
            if off != [0.0; 2] {
                slack = (slack + grid.distance(ranges, past, past, self.bytes)?) * UP;
            }
            self.pending = 0.0;
            let mut stretch = Stretch {
                points,
                origin: patch.net.origin,
                slack,
                bounds: Box3::default(),
            };
            stretch.bounds = stretch.net().bounding_box()?;
            // A list that grows has room for twice as many, and is copied.
            self.bytes += 3 * size_of::<Stretch<T>>()
                + size_of_val(&stretch.points[..])
                + size_of::<Pair<T>>();
            self.image.stretches.push(stretch);
            if self.bytes.saturating_add(grid.patches.made()) > grid.most {
                return None;
            }
        }
        self.bytes -= own;
        Some(())
    }
}

/// A curve with a coordinate that varies by no more than so many roundings counts as an isoparametric line.
const CONSTANT: f64 = 64.0;
/// A bilinear patch that is twisted by no more than so many roundings counts as plane.
const FLAT: f64 = 16.0;

/// The image of a curve in a patch's local square; how far its parameters may be from the curve's; and how far the
/// image may be from the patch's besides. `None` where its degree is too high.
fn lifted<T: Real>(
    patch: &Patch<T>,
    local: &[Homogeneous<T, 3>],
) -> (Option<Vec<Homogeneous<T, 4>>>, [f64; 2], f64) {
    // An isoparametric line: one of the patch's own curves, of a far lower degree.
    for c in 0..2 {
        let x0 = local[0][c] / local[0][2];
        let spread = local.iter().map(|p| (p[c] / p[2] - x0).magnitude());
        let spread = spread.fold(0.0, f64::max);
        if !(spread <= CONSTANT * T::UNIT) {
            continue;
        }
        let at = Ball {
            mid: x0.mid,
            rad: 0.0,
        };
        let points = &patch.net.points;
        let width = patch.net.degree.v + 1;
        let line: Vec<_> = if c == 0 {
            // One column at a time: all are as much as the net.
            let mut column = Vec::with_capacity(patch.net.degree.u + 1);
            let mut of = |j: usize| {
                column.clear();
                column.extend(points.iter().skip(j).step_by(width));
                curve_jet(&column, at).0
            };
            (0..width).map(&mut of).collect()
        } else {
            { points.chunks_exact(width) }
                .map(|row| curve_jet(row, at).0)
                .collect()
        };
        let u = line.len() - 1;
        let net = Net::new(Bidegree { u, v: 0 }, line, patch.net.origin);
        let along: Vec<Homogeneous<T, 3>> =
            local.iter().map(|p| [p[1 - c], Ball::ZERO, p[2]]).collect();
        let mut moved = [0.0; 2];
        moved[c] = (spread + x0.rad) * UP;
        return (compose(&net, &along), moved, 0.0);
    }
    if let Some(twist) = flat(patch) {
        let [o, q, r] = [0, 2, 1].map(|i| patch.net.points[i]);
        let points = local
            .iter()
            .map(|p| {
                std::array::from_fn(|c| match c {
                    3 => o[3] * p[2],
                    _ => o[c] * p[2] + (q[c] - o[c]) * p[0] + (r[c] - o[c]) * p[1],
                })
            })
            .collect();
        return (Some(points), [0.0; 2], twist);
    }
    (patch.compose(local), [0.0; 2], 0.0)
}

/// For a bilinear patch with equal weights: how far it is from the plane patch with the same three corners, if no
/// more than roundings.
fn flat<T: Real>(patch: &Patch<T>) -> Option<f64> {
    let p = &patch.net.points;
    if (patch.net.degree.u, patch.net.degree.v) != (1, 1) {
        return None;
    }
    let w = p[0][3];
    if p.iter().any(|x| x[3].rad != 0.0 || x[3].mid != w.mid) {
        return None;
    }
    let (mut twist, mut size): (f64, f64) = (0.0, 0.0);
    for c in 0..3 {
        twist += (((p[3][c] - p[1][c]) - (p[2][c] - p[0][c])) / w).magnitude();
        size = p.iter().fold(size, |m, x| m.max((x[c] / w).magnitude()));
    }
    (twist <= FLAT * T::UNIT * size).then_some(twist * UP)
}

/// The image of a trim of a face; `None` where it is not known, or none of it can be composed.
pub(super) fn image<T: Real>(geometry: &FaceGeometry<T>, trim: usize) -> Option<Image<T>> {
    let curves: Vec<_> = trim_curves(&geometry.brep, trim).collect();
    image_of(&geometry.patches, &curves, usize::MAX)
}

/// The image of one trim, where no more than `most` bytes are taken for it, for the work and for the patches that are made; else it counts as not known.
pub(super) fn image_alone(
    brep: &Brep,
    patches: &Patches<f64>,
    trim: usize,
    most: usize,
) -> Option<Image<f64>> {
    let curves: Vec<_> = trim_curves(brep, trim).collect();
    image_of(patches, &curves, most)
}

/// The image of one of the curves that bound a face.
pub(super) fn image_of_one<T: Real>(
    geometry: &FaceGeometry<T>,
    source: CurveSource,
) -> Option<Image<T>> {
    let curve = uv_curve(&geometry.brep, source);
    image_of(&geometry.patches, &[curve], usize::MAX)
}

/// A box around the first or the last point of a trim's image.
pub(super) fn end<T: Real>(geometry: &FaceGeometry<T>, trim: usize, last: bool) -> Option<Box3> {
    point(geometry, &trim_end(&geometry.brep, trim, last)?)
}

/// A box around the image of a point of uv.
pub(super) fn point<T: Real>(geometry: &FaceGeometry<T>, at: &Homogeneous<T, 3>) -> Option<Box3> {
    let mut grid = Grid::new(&geometry.patches, usize::MAX)?;
    let point = std::slice::from_ref(at);
    let ranges = [range(point, 0)?, range(point, 1)?];
    let cells = ROUNDINGS.into_iter().find_map(|roundings| {
        grid.roundings = roundings;
        Some([grid.cell(0, ranges[0])?, grid.cell(1, ranges[1])?])
    })?;
    let patch = grid.patch(cells[0], cells[1], 0)?;
    let local = localized(point, patch, cells)[0];
    let overhang = [0, 1].map(|k| 2.0 * grid.overhang(k, cells[k], ranges[k]) * UP);
    let moved = [0, 1].map(|k| grid.native(patch, overhang, k));
    let slack = if moved == [0.0; 2] {
        0.0
    } else {
        grid.distance(ranges, moved, moved, 0)?
    };
    let value = patch
        .net
        .jet(local[0] / local[2], local[1] / local[2])
        .value;
    if !value[3].is_above(0.0) {
        return None;
    }
    Some(std::array::from_fn(|c| {
        let x = value[c] / value[3] + Ball::exact(patch.net.origin[c]);
        [
            (x.lower() - slack).next_down(),
            (x.upper() + slack).next_up(),
        ]
    }))
}

/// A bound on the derivative of a face's surface along u and v, in model units for one of uv; `None` where there is none.
pub(super) fn steepest<T: Real>(geometry: &FaceGeometry<T>) -> Option<[f64; 2]> {
    let mut most: [f64; 2] = [0.0; 2];
    for index in 0..geometry.patches.len() {
        let patch = geometry.patches.lent(index);
        let slope = slopes(&patch, EXTENSION)?;
        for k in 0..2 {
            let m = &patch.maps[k];
            most[k] = most[k].max(slope[k] / least_length(m) * UP);
        }
    }
    most.iter().all(|x| x.is_finite()).then_some(most)
}

/// A part of a curve in space as an image, in the curve's direction: its Bezier pieces. Where two do not meet (segments of a
/// poly-curve), the straight segment between them counts as part of it.
pub(super) fn of_curve(curve: &Curve3, span: Interval) -> Option<Image<f64>> {
    let mut pieces = Vec::new();
    curve_pieces::<f64, 3, 4>(curve, span.start, span.end, &mut pieces);
    let mut image = Image {
        stretches: Vec::with_capacity(pieces.len()),
        extra: 0.0,
    };
    for piece in pieces {
        let (points, slack) = exact(&piece.points)?;
        let mut stretch = Stretch {
            points,
            origin: [0.0; 3],
            slack,
            bounds: Box3::default(),
        };
        stretch.bounds = stretch.net().bounding_box()?;
        if let Some(last) = image.stretches.last() {
            let gap = distance(&end_box(last, true), &end_box(&stretch, false)).hi;
            image.extra = image.extra.max(gap);
        }
        image.stretches.push(stretch);
    }
    (!image.stretches.is_empty() && image.extra.is_finite()).then_some(image)
}

/// A box around the first or the last point of what a stretch stands for.
pub(super) fn end_box<T: Real>(stretch: &Stretch<T>, last: bool) -> Box3 {
    let p = if last {
        stretch.points[stretch.points.len() - 1]
    } else {
        stretch.points[0]
    };
    let p = p.map(|mid| Ball { mid, rad: 0.0 });
    std::array::from_fn(|c| {
        let x = p[c] / p[3] + Ball::exact(stretch.origin[c]);
        [
            (x.lower() - stretch.slack).next_down(),
            (x.upper() + stretch.slack).next_up(),
        ]
    })
}

/// How far apart a point of one box and a point of another are.
pub(super) fn distance(a: &Box3, b: &Box3) -> Enclosure {
    let (mut low, mut high) = (0.0, 0.0);
    for c in 0..3 {
        let apart = (a[c][0] - b[c][1]).max(b[c][0] - a[c][1]).max(0.0);
        let far = (a[c][1] - b[c][0]).max(b[c][1] - a[c][0]);
        low += apart * apart;
        high += far * far;
    }
    // Each difference, square, sum and root is off by a rounding.
    Enclosure {
        lo: low.sqrt() / UP,
        hi: high.sqrt() * UP,
    }
}

fn image_of<T: Real>(patches: &Patches<T>, curves: &[UvCurve<T>], most: usize) -> Option<Image<T>> {
    let mut grid = Grid::new(patches, most)?;
    // Crossings are cut finer once where the numbers go finer.
    let levels = u32::from(T::UNIT < f64::UNIT);
    let mut with = |roundings: f64| {
        grid.roundings = roundings;
        let mut builder = Builder {
            image: Image {
                stretches: Vec::new(),
                extra: 0.0,
            },
            pending: 0.0,
            bytes: 0,
        };
        for curve in curves {
            builder.curve(&grid, &curve.points, levels, COMPOSE_HALVINGS)?;
        }
        let mut image = builder.image;
        image.stretches.shrink_to_fit();
        (!image.stretches.is_empty() && image.extra.is_finite()).then_some(image)
    };
    ROUNDINGS.into_iter().find_map(&mut with)
}
