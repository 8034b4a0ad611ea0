//! Loops in uv: one sheet of a periodic surface, poles, seams that the file leaves out.
//!
//! A loop's curves in uv are made one by one, each on some sheet; here each is moved by whole periods so that it starts where the one before ends.
//! - **Poles**: where a loop goes through a point at which all u are one, a singular trim goes from the u it came with to the u it leaves with. The face
//!   is on the loop's left, so at the upper end of v it goes towards smaller u, at the lower towards larger; by a whole turn where the loop goes
//!   back on the edge it came by.
//! - **Rims**: a loop that ends a period beside its start runs around the surface. Two of them bound a face together: a seam from one to the other
//!   and back makes them one loop. One alone is closed by a seam to the pole on its left.
//! - **No edges**: a sphere or torus with no loop, or with holes alone, gets the border of its whole domain.

use super::chart::Chart;
use super::pcurve::{Made, grow};
use crate::occt::builder::shift;
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Line, Polyline};
use nalgebra::Point2;
use std::f64::consts::TAU;

/// How far apart uv may be and still be the same, in parts of a period.
const SAME: f64 = 1.0 / (1 << 20) as f64;

/// What rounding makes of whole turns, in radians: proven bounds have room for it.
const CLOSING: f64 = 4.0 * f64::EPSILON;

/// An edge as a loop uses it.
pub(super) struct Use {
    /// The edge's key; `None`: singular.
    pub(super) key: Option<usize>,
    pub(super) reversed: bool,
    pub(super) curve: Curve2,
    pub(super) span: Interval,
    /// In the direction of the loop.
    pub(super) vertices: [usize; 2],
    pub(super) on_axis: [bool; 2],
    /// How far its image is at most from its edge, where that is known, and where the surface's domain cuts nothing off.
    pub(super) bound: Option<f64>,
}

impl Use {
    pub(super) fn new(
        key: usize,
        reversed: bool,
        made: Made,
        span: Interval,
        vertices: [usize; 2],
    ) -> Self {
        let mut u = Self {
            key: Some(key),
            reversed,
            curve: made.curve,
            span,
            vertices,
            on_axis: made.on_axis,
            bound: made.bound,
        };
        if reversed {
            u.vertices.reverse();
            u.on_axis.reverse();
        }
        u
    }

    /// A straight one, of an edge or singular.
    fn straight(
        key: Option<usize>,
        from: Point2<f64>,
        to: Point2<f64>,
        vertices: [usize; 2],
    ) -> Option<Self> {
        let span = Interval::new(0.0, 1.0)?;
        Some(Self {
            key,
            reversed: false,
            curve: Curve::Line(Line::new(from, to, span).ok()?),
            span,
            vertices,
            on_axis: [false; 2],
            // Nothing to be off: it has no curve in space.
            bound: Some(0.0),
        })
    }

    fn at(&self, s: f64) -> Point2<f64> {
        let s = if self.reversed { 1.0 - s } else { s };
        self.curve.point(self.span.lerp(s))
    }

    pub(super) fn start(&self) -> Point2<f64> {
        self.at(0.0)
    }

    pub(super) fn end(&self) -> Point2<f64> {
        self.at(1.0)
    }

    fn shift(&mut self, c: usize, by: f64) {
        if by != 0.0 {
            shift(&mut self.curve, c, by);
        }
    }

    /// What [`join`] asks of it, with three points for its curve: that may be long.
    fn sketch(&self) -> Option<Self> {
        let points = [0.0, 0.5, 1.0].map(|s| self.at(s)).to_vec();
        Some(Self {
            reversed: false,
            curve: Curve::Polyline(Polyline::new(points, vec![0.0, 0.5, 1.0]).ok()?),
            span: Interval::new(0.0, 1.0)?,
            ..*self
        })
    }
}

/// What the next one must know of a use: its curve may be long.
struct Tip {
    key: Option<usize>,
    middle: Point2<f64>,
    end: Point2<f64>,
    vertex: usize,
    on_axis: bool,
}

impl Tip {
    fn of(u: &Use) -> Self {
        Self {
            key: u.key,
            middle: u.at(0.5),
            end: u.end(),
            vertex: u.vertices[1],
            on_axis: u.on_axis[1],
        }
    }
}

/// What is missing for a face to be bounded.
pub(super) enum Trouble {
    /// Its loops do not bound a part of its surface.
    Unbounded(&'static str),
    /// An edge must be split where its u is this, up to whole periods, for a seam to end there.
    Split { key: usize, parameter: f64 },
}

/// Makes vertices and edges that the file does not have.
pub(super) trait Maker {
    /// The vertex at a point of the chart.
    fn vertex(&mut self, uv: Point2<f64>) -> usize;
    /// A seam between two vertices.
    fn seam(&mut self, vertices: [usize; 2]) -> usize;
}

/// Moves the uses of a loop to one sheet and puts in what lies at poles. Returns by how many periods the loop ends beside its start.
pub(super) fn lifted(chart: &Chart, uses: &mut Vec<Use>) -> Result<[i32; 2], Trouble> {
    let n = uses.len();
    if n == 0 {
        return Ok([0; 2]);
    }
    // A curve along the border of a closed surface that has ends may lie at either end: start with another.
    let first = (0..n).find(|i| uses.get(*i).is_some_and(|u| !at_border(chart, u)));
    uses.rotate_left(first.unwrap_or(0));
    // A pole lies before each that starts on the axis.
    let poles = uses.iter().filter(|u| u.on_axis[0]).count();
    let mut all: Vec<Use> = Vec::with_capacity(n + poles);
    for mut u in std::mem::take(uses) {
        if let Some(last) = all.last() {
            let last = Tip::of(last);
            join(chart, &last, &mut u, &mut all);
            let ends = all.last().map_or(last.end, Use::end);
            let jumps = |c: usize| {
                let gap = (u.start()[c] - ends[c]).abs();
                chart.periods[c].is_some_and(|period| gap > 0.5 * period)
            };
            if jumps(0) || jumps(1) {
                return Err(Trouble::Unbounded(
                    "one crosses the line where its closed surface starts, and has no edge there",
                ));
            }
        }
        grow(&mut all, 1);
        all.push(u);
    }
    // The last to the first, without moving that.
    let mut turns = [0; 2];
    if let (Some(last), Some(mut u)) = (all.last().map(Tip::of), all.first().and_then(Use::sketch))
    {
        let before = u.start();
        let end = last.end;
        let on_axis = last.on_axis && u.on_axis[0];
        join(chart, &last, &mut u, &mut all);
        for c in 0..2 {
            if let Some(period) = chart.periods[c] {
                // What ends at the border of a closed surface is not moved, but runs around all the same.
                let to = if c == 0 && on_axis { u.start() } else { end };
                turns[c] = ((to[c] - before[c]) / period).round() as i32;
            }
        }
    }
    // Where all lie along borders the first may lie at the other end: back to where there is something.
    if let Some(domain) = chart.domain {
        for c in 0..2 {
            let Some(period) = chart.periods[c] else {
                continue;
            };
            let [lo, hi] = range(&all, c);
            let is_out = lo < domain[c][0] - SAME * period || hi > domain[c][1] + SAME * period;
            if is_out && hi - lo <= (1.0 + SAME) * period {
                let by = ((domain[c][0] - lo) / period).round() * period;
                for u in &mut all {
                    u.shift(c, by);
                }
            }
        }
    }
    *uses = all;
    Ok(turns)
}

/// Whether a use lies along a border at which the surface is closed, and beyond which it does not go on.
fn at_border(chart: &Chart, u: &Use) -> bool {
    let Some(domain) = chart.domain else {
        return false;
    };
    (0..2).any(|c| {
        let Some(period) = chart.periods[c] else {
            return false;
        };
        let on = |x: f64, border: f64| (x - border).abs() <= SAME * period;
        domain[c]
            .iter()
            .any(|b| [0.0, 0.5, 1.0].iter().all(|s| on(u.at(*s)[c], *b)))
    })
}

/// Moves `u` so that it starts where `last` ends, with what must lie between the two.
fn join(chart: &Chart, last: &Tip, u: &mut Use, all: &mut Vec<Use>) {
    let end = last.end;
    let on_axis = last.on_axis && u.on_axis[0];
    for c in 0..2 {
        let Some(period) = chart.periods[c] else {
            continue;
        };
        if c == 0 && on_axis {
            continue;
        }
        let by = ((end[c] - u.start()[c]) / period).round() * period;
        if chart.domain.is_none() || at_border(chart, u) {
            u.shift(c, by);
        }
    }
    if on_axis {
        let upper = end.y > last.middle.y;
        let mut by = u.start().x - end.x;
        by -= (by / TAU).floor() * TAU;
        // From 0 to one turn now.
        let is_same = last.key == u.key;
        if by <= SAME * TAU || by >= (1.0 - SAME) * TAU {
            by = if is_same { TAU } else { 0.0 };
        }
        let by = match (upper, by) {
            (_, 0.0) => 0.0,
            (true, by) if by == TAU => -TAU,
            (true, by) => by - TAU,
            (false, by) => by,
        };
        let turned = end.x + by - u.start().x;
        u.shift(0, turned);
        // Made to close by more than rounding: what was proven was proven of another curve.
        if (turned - (turned / TAU).round() * TAU).abs() > CLOSING {
            u.bound = None;
        }
        if by != 0.0 {
            let to = Point2::new(u.start().x, end.y);
            grow(all, 1);
            all.extend(Use::straight(None, end, to, [last.vertex; 2]));
        }
        return;
    }
    // A border of the surface that is one point.
    let gap = u.start() - end;
    let wide = (0..2).any(|c| {
        let length = chart.domain.map_or(TAU, |d| d[c][1] - d[c][0]);
        gap[c].abs() > SAME * length.min(1e300)
    });
    if wide && last.vertex == u.vertices[0] {
        let middle = chart.point(&chart.clamped(end + gap * 0.5));
        let (a, b) = (chart.point(&end), chart.point(&u.start()));
        let apart = (a - b).norm().max((middle - a).norm());
        let scale = a.coords.amax().max(b.coords.amax());
        if apart <= SAME * scale {
            let vertices = [last.vertex; 2];
            all.extend(Use::straight(None, end, u.start(), vertices));
        }
    }
}

/// Twice the area of a polygon through points of a loop.
fn area(uses: &[Use]) -> f64 {
    let mut points = Vec::new();
    for u in uses {
        points.extend((0..16).map(|k| u.at(f64::from(k) / 16.0)));
    }
    let Some(&o) = points.first() else { return 0.0 };
    let pairs = points.windows(2).map(|w| (w[0] - o, w[1] - o));
    pairs.map(|(a, b)| a.x * b.y - a.y * b.x).sum()
}

/// Loops that are lifted, each with its turns, as loops that close. `bare`: the file gives no edge, but says that there is a border of one point.
pub(super) fn closed(
    chart: &Chart,
    loops: Vec<(Vec<Use>, [i32; 2])>,
    maker: &mut impl Maker,
) -> Result<Vec<Vec<Use>>, Trouble> {
    let mut done = Vec::new();
    let mut rims = Vec::new();
    for (uses, turns) in loops {
        if turns == [0; 2] {
            done.push(uses);
        } else {
            rims.push((uses, turns));
        }
    }
    match (rims.pop(), rims.pop(), rims.is_empty()) {
        (None, ..) => {
            if let Some(domain) = whole(chart)
                && done.iter().all(|l| area(l) < 0.0)
            {
                done.push(bordered(chart, domain, &done, maker)?);
            }
            Ok(done)
        }
        (Some(rim), None, _) => {
            done.push(to_pole(chart, rim, &done, maker)?);
            Ok(done)
        }
        (Some(b), Some(a), true) => {
            done.push(between(chart, a, b, &done, maker)?);
            Ok(done)
        }
        _ => Err(Trouble::Unbounded(
            "more than two loops run around the surface",
        )),
    }
}

/// The domain of a surface that bounds a solid alone.
fn whole(chart: &Chart) -> Option<[f64; 2]> {
    match (chart.poles(), chart.periods, chart.domain) {
        ([Some(lo), Some(hi)], ..) if lo < hi => Some([lo, hi]),
        (_, [Some(_), Some(period)], None) => Some([0.0, period]),
        _ => None,
    }
}

/// The range of loops in a coordinate.
fn range(uses: &[Use], c: usize) -> [f64; 2] {
    let curves = uses.iter().map(|u| (&u.curve, u.span));
    crate::sheets::reach(curves, c).map_or([0.0; 2], |r| r.range)
}

/// Where a seam at coordinate `c` crosses none of some loops; from `preferred`, if that is good.
fn clear(loops: &[Vec<Use>], c: usize, period: f64, preferred: &[f64]) -> Option<f64> {
    let ranges: Vec<[f64; 2]> = loops.iter().map(|l| range(l, c)).collect();
    let free = |x: f64| {
        ranges.iter().all(|[lo, hi]| {
            // The first copy of x at or above lo.
            let above = x + ((lo - SAME * period - x) / period).ceil() * period;
            above > hi + SAME * period
        })
    };
    let gaps = ranges.iter().map(|[_, hi]| hi + 2.0 * SAME * period);
    let middles = (0..64).map(|k| period * f64::from(k) / 64.0);
    { preferred.iter().copied() }
        .chain(middles)
        .chain(gaps)
        .find(|x| free(*x))
}

/// The border of a whole sphere or torus.
fn bordered(
    chart: &Chart,
    v: [f64; 2],
    holes: &[Vec<Use>],
    maker: &mut impl Maker,
) -> Result<Vec<Use>, Trouble> {
    let none = Trouble::Unbounded("no seam avoids its holes");
    let Some(u0) = clear(holes, 0, TAU, &[0.0]) else {
        return Err(none);
    };
    let is_sphere = chart.poles()[0].is_some();
    let v0 = if is_sphere {
        v[0]
    } else {
        let period = v[1] - v[0];
        clear(holes, 1, period, &[v[0]]).ok_or(none)?
    };
    let v1 = v0 + (v[1] - v[0]);
    let at = |i: usize, j: usize| Point2::new([u0, u0 + TAU][i], [v0, v1][j]);
    let low = maker.vertex(at(0, 0));
    let high = if is_sphere {
        maker.vertex(at(0, 1))
    } else {
        low
    };
    let up = Some(maker.seam([low, high]));
    let around = (!is_sphere).then(|| maker.seam([low, low]));
    let mut all = Vec::new();
    all.extend(Use::straight(around, at(0, 0), at(1, 0), [low; 2]));
    all.extend(Use::straight(up, at(1, 0), at(1, 1), [low, high]));
    all.extend(reversed(Use::straight(
        around,
        at(0, 1),
        at(1, 1),
        [high; 2],
    )));
    all.extend(reversed(Use::straight(up, at(0, 0), at(0, 1), [low, high])));
    Ok(all)
}

fn reversed(u: Option<Use>) -> Option<Use> {
    let mut u = u?;
    u.reversed = true;
    u.vertices.reverse();
    Some(u)
}

type Rim = (Vec<Use>, [i32; 2]);

/// One rim and the pole on its left.
fn to_pole(
    chart: &Chart,
    (mut uses, turns): Rim,
    holes: &[Vec<Use>],
    maker: &mut impl Maker,
) -> Result<Vec<Use>, Trouble> {
    let nothing =
        Trouble::Unbounded("one loop alone runs around the surface, and no pole is on its left");
    let pole = match turns {
        [1, 0] => chart.poles()[1],
        [-1, 0] => chart.poles()[0],
        _ => None,
    };
    let Some(pole) = pole else {
        return Err(nothing);
    };
    let Some(at) = clear(holes, 0, TAU, &starts(&uses, 0)) else {
        return Err(Trouble::Unbounded("no seam avoids its holes"));
    };
    let Some(k) = { uses.iter() }.position(|u| same(u.start().x, at, TAU)) else {
        return Err(split(&uses, 0, TAU, at));
    };
    rotate(&mut uses, k, 0, TAU);
    let (Some(first), Some(last)) = (uses.first(), uses.last()) else {
        return Err(nothing);
    };
    let (from, start, vertex) = (last.end(), first.start(), first.vertices[0]);
    let by = TAU * f64::from(turns[0]);
    let end = Point2::new(start.x + by, from.y);
    let top = maker.vertex(Point2::new(start.x, pole));
    let seam = Some(maker.seam([vertex, top]));
    let (a, b) = (Point2::new(end.x, pole), Point2::new(start.x, pole));
    uses.extend(Use::straight(seam, end, a, [vertex, top]));
    uses.extend(Use::straight(None, a, b, [top; 2]));
    uses.extend(reversed(Use::straight(seam, start, b, [vertex, top])));
    Ok(uses)
}

/// Where the edges of a loop start.
fn starts(uses: &[Use], c: usize) -> Vec<f64> {
    let own = uses.iter().filter(|u| u.key.is_some());
    own.map(|u| u.start()[c]).collect()
}

/// Whether two coordinates are the same but for whole periods.
fn same(x: f64, y: f64, period: f64) -> bool {
    let by = (x - y) / period;
    (by - by.round()).abs() <= SAME
}

/// Two rims and a seam between them.
fn between(
    chart: &Chart,
    a: Rim,
    b: Rim,
    holes: &[Vec<Use>],
    maker: &mut impl Maker,
) -> Result<Vec<Use>, Trouble> {
    let c = usize::from(a.1[0] == 0);
    let opposite = [-a.1[0], -a.1[1]] == b.1;
    let (Some(period), true) = (
        chart.periods[c],
        opposite && a.1[c].abs() == 1 && a.1[1 - c] == 0,
    ) else {
        return Err(Trouble::Unbounded(
            "its loops do not run around the surface once, one against the other",
        ));
    };
    let (mut a, mut b, turn) = (a.0, b.0, f64::from(a.1[c]));
    // Where both have a vertex, or at least one has.
    let same = |x: f64, y: f64| same(x, y, period);
    let (own, theirs) = (starts(&a, c), starts(&b, c));
    let both = own.iter().filter(|x| theirs.iter().any(|y| same(**x, *y)));
    let preferred: Vec<f64> = both.chain(&own).chain(&theirs).copied().collect();
    let Some(at) = clear(holes, c, period, &preferred) else {
        return Err(Trouble::Unbounded("no seam avoids its holes"));
    };
    for rim in [&mut a, &mut b] {
        let Some(k) = rim.iter().position(|u| same(u.start()[c], at)) else {
            return Err(split(rim, c, period, at));
        };
        rotate(rim, k, c, period);
    }
    // The second goes back from where the first ends.
    let (Some(p), Some(mut q)) = (a.first().map(Use::start), b.first().map(Use::start)) else {
        return Err(Trouble::Unbounded("an empty loop"));
    };
    // Both coordinates may come back: the face is on the first's left, which is towards larger v where u grows and smaller u where v does,
    // up to the first copy of the second.
    let o = 1 - c;
    if let Some(period) = chart.periods[o] {
        let left = if c == 0 { turn } else { -turn };
        let mut gap = left * (q[o] - p[o]);
        gap -= (gap / period).floor() * period;
        if gap <= SAME * period {
            gap += period;
        }
        let by = ((p[o] + left * gap - q[o]) / period).round() * period;
        if by != 0.0 && chart.domain.is_some() {
            return Err(Trouble::Unbounded(
                "one crosses the line where its closed surface starts, and has no edge there",
            ));
        }
        for u in &mut b {
            u.shift(o, by);
        }
        q[o] += by;
    }
    let (Some(va), Some(vb)) = (
        a.first().map(|u| u.vertices[0]),
        b.first().map(|u| u.vertices[0]),
    ) else {
        return Err(Trouble::Unbounded("an empty loop"));
    };
    let end = p[c] + turn * period;
    let by = ((end - q[c]) / period).round() * period;
    for u in &mut b {
        u.shift(c, by);
    }
    let (mut p1, mut q1, mut q0) = (p, q, q);
    (p1[c], q1[c], q0[c]) = (end, q[c] + by, q[c] + by - turn * period);
    let seam = Some(maker.seam([va, vb]));
    let forth = Use::straight(seam, p1, q1, [va, vb]);
    let back = reversed(Use::straight(seam, p, q0, [va, vb]));
    let mut all = a;
    all.extend(forth);
    all.extend(b);
    all.extend(back);
    Ok(all)
}

/// Makes a loop that runs around start with its use `k`.
fn rotate(rim: &mut [Use], k: usize, c: usize, period: f64) {
    rim.rotate_left(k);
    for i in 1..rim.len() {
        let (before, rest) = rim.split_at_mut(i);
        if let (Some(last), Some(u)) = (before.last(), rest.first_mut()) {
            u.shift(
                c,
                ((last.end()[c] - u.start()[c]) / period).round() * period,
            );
        }
    }
}

/// Where the edge of a loop that passes a seam must be split.
fn split(rim: &[Use], c: usize, period: f64, at: f64) -> Trouble {
    for u in rim {
        let Some(key) = u.key else { continue };
        let value = |t: f64| u.curve.point(t)[c];
        let (mut lo, mut hi) = (u.span.start, u.span.end);
        let (a, b) = (value(lo), value(hi));
        let target = at + ((a.min(b) - at) / period).ceil() * period;
        if !(target > a.min(b) && target < a.max(b)) {
            continue;
        }
        // To the last digit: bisection of f64 ends.
        for _ in 0..128 {
            let middle = 0.5 * (lo + hi);
            if !(lo < middle && middle < hi) {
                break;
            }
            if (value(middle) < target) == (a < b) {
                lo = middle;
            } else {
                hi = middle;
            }
        }
        return Trouble::Split {
            key,
            parameter: 0.5 * (lo + hi),
        };
    }
    Trouble::Unbounded("a seam would end nowhere")
}
