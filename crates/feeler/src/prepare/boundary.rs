//! The boundary of a face in space: trim curves and the segments that join them, cut at the
//! patches of the surface and lifted onto them.

use super::patch::COMPOSE_HALVINGS;
use super::spline::{
    BezierCurve, PiecePlace, curve_piece, curve_pieces, piece_count, piece_places,
};
use super::{Homogeneous, Net, ParamMap, Patch, Patches, curve_jet};
use crate::brep::{Brep, TrimCurve};
use crate::numeric::bernstein::Bidegree;
use crate::numeric::{Ball, Dd, Real};
use crate::nurbs::Curve2;
use nalgebra::Point2;

/// A piece of the boundary over one patch.
///
/// The composed curve may reach past the patch's border: there it is a point of what the patch goes on as
/// (its polynomials, or the whole revolution: see `Patch::compose`), not of the trimmed surface's domain. A minimum over it is thus a minimum over a
/// superset: good for lower bounds; upper bounds must check that the point is on the patch.
#[derive(Clone, Debug)]
pub struct Piece<T> {
    /// The trim, or `None` for a segment that joins two trims.
    pub trim: Option<usize>,
    /// Index of the patch.
    pub patch: usize,
    /// The curve in the patch's local square, homogeneous `(s w, t w, w)`.
    pub local: Vec<Homogeneous<T, 3>>,
    /// The curve in space; `None` where its degree is too high to be composed.
    pub space: Option<Net<T>>,
    /// About the trim's own parameters at the start and at the end; of an arc those between are no linear function of the piece's.
    pub(crate) span: [f64; 2],
}

impl Piece<f64> {
    /// Whether the part of the curve over `[a, b]` is plainly proven to lie in the patch's open square: no more than a cheap test that
    /// says `false` near its border.
    ///
    /// The control points of the part are blossoms: each is made in as many levels as the degree `p`, of three roundings each, of
    /// weights that sum to 1 and are not negative. So they are off by at most `3 p u` times the largest coordinate,
    /// and the stored points' bounds; [`PLAIN`] times that coordinate is far more for `p` up to [`MOST_PLAIN`].
    pub(crate) fn stays(&self, [a, b]: [f64; 2]) -> bool {
        let p = self.local.len() - 1;
        if p > MOST_PLAIN {
            return false;
        }
        let (mut own, mut size, mut spread) = ([[0.0; 3]; MOST_PLAIN + 1], 0.0f64, 0.0f64);
        for (o, x) in own.iter_mut().zip(&self.local) {
            *o = x.map(|x| x.mid);
            size = x.iter().fold(size, |m, x| m.max(x.mid.abs()));
            spread = x.iter().fold(spread, |m, x| m.max(x.rad));
        }
        let margin = PLAIN * size;
        if !(spread <= 0.25 * margin) {
            return false;
        }
        (0..=p).all(|k| {
            let mut d = own;
            for r in 0..p {
                let x = if r < p - k { a } else { b };
                let y = 1.0 - x;
                for i in 0..p - r {
                    d[i] = [0, 1, 2].map(|c| y * d[i][c] + x * d[i + 1][c]);
                }
            }
            let [s, t, w] = d[0];
            [s, t].iter().all(|x| *x > margin && w - x > margin)
        })
    }
}

/// See [`Piece::stays`].
const MOST_PLAIN: usize = 12;
const PLAIN: f64 = 1.0 / (1u64 << 40) as f64;

/// How far a piece may reach past its patch, in units of the patch's width.
const BORDER_SLACK: f64 = 1.0 / (1u64 << 44) as f64;
/// How often a curve may be halved to find where it crosses from patch to patch: what is left belongs to
/// both, and the search cuts it finer where that matters.
const MAX_DEPTH: u32 = 10;
/// How many parts of a curve may cross at one depth; a curve with more runs along a border, and is left to
/// the patches on both sides.
const MAX_CROSSING: usize = 64;

/// A uv Bezier curve, in the order of its loop.
#[derive(Clone, Debug)]
pub(crate) struct UvCurve<T> {
    pub(crate) trim: Option<usize>,
    /// Of a segment that joins two trims: the first.
    pub(crate) after: Option<usize>,
    pub(crate) points: Vec<Homogeneous<T, 3>>,
    /// The trim's own parameters at the start and at the end, rounded; nothing of a segment that joins two.
    pub(crate) span: [f64; 2],
}

impl<T: Real> UvCurve<T> {
    /// A piece of a trim, in the direction of its loop.
    fn of_trim(trim: usize, reversed: bool, piece: BezierCurve<T, 3>) -> Self {
        let mut points = piece.points;
        let mut span = [piece.map.start, piece.map.end];
        if reversed {
            points.reverse();
            span.reverse();
        }
        Self {
            trim: Some(trim),
            after: None,
            points,
            span,
        }
    }

    /// A segment that joins a trim to the next.
    fn join(after: usize, points: Vec<Homogeneous<T, 3>>) -> Self {
        Self {
            trim: None,
            after: Some(after),
            points,
            span: [0.0; 2],
        }
    }
}

/// The trim's Bezier pieces in uv, in the trim's own direction.
pub(super) fn trim_curves<T: Real>(brep: &Brep, trim: usize) -> impl Iterator<Item = UvCurve<T>> {
    let t = &brep.parts().trims[trim];
    let (curve, reversed) = (&brep.parts().curves2[t.curve], t.reversed);
    let count = piece_count(curve, t.span.start, t.span.end).pieces;
    let mut pieces = Vec::with_capacity(count);
    curve_pieces(curve, t.span.start, t.span.end, &mut pieces);
    if reversed {
        pieces.reverse();
    }
    let piece = move |piece| UvCurve::of_trim(trim, reversed, piece);
    pieces.into_iter().map(piece)
}

/// The quotient of a homogeneous end point.
fn end_point<T: Real>(p: &Homogeneous<T, 3>) -> Homogeneous<T, 3> {
    if p[2].rad == 0.0 && p[2].mid == T::ONE {
        return *p;
    }
    [p[0] / p[2], p[1] / p[2], Ball::ONE]
}

/// The exact homogeneous point at the start or the end of the curve's domain, where it is a stored
/// number.
fn stored_end(curve: &Curve2, start: bool) -> Option<[f64; 3]> {
    let point = |p: &Point2<f64>| Some([p.x, p.y, 1.0]);
    match curve {
        Curve2::Line(c) => point(if start { &c.from } else { &c.to }),
        Curve2::Polyline(c) => point(if start {
            c.points().first()?
        } else {
            c.points().last()?
        }),
        Curve2::Nurbs(c) => {
            let knots = c.knots().knots();
            let p = c.degree();
            let n = knots.len();
            let (clamped, point) = if start {
                (knots[1] == knots[p], c.control_points().first()?)
            } else {
                (knots[n - 2] == knots[n - 1 - p], c.control_points().last()?)
            };
            clamped.then(|| [point[0], point[1], point[2]])
        }
        // Segments are never poly-curves themselves: this goes one level deep.
        Curve2::Poly(c) => stored_end(
            if start {
                c.segments().first()?
            } else {
                c.segments().last()?
            },
            start,
        ),
        Curve2::Arc(_) => None,
    }
}

/// The same for a trim, in its own direction.
fn stored_trim_end(brep: &Brep, t: &TrimCurve, start: bool) -> Option<[f64; 3]> {
    let curve = &brep.parts().curves2[t.curve];
    let at_start = start != t.reversed;
    let domain = curve.domain();
    let whole = if at_start {
        t.span.start == domain.start
    } else {
        t.span.end == domain.end
    };
    whole.then(|| stored_end(curve, at_start)).flatten()
}

/// Whether trim `a` is proven to end exactly where trim `b` starts.
fn meet(brep: &Brep, a: &TrimCurve, b: &TrimCurve) -> bool {
    let (Some(a), Some(b)) = (
        stored_trim_end(brep, a, false),
        stored_trim_end(brep, b, true),
    ) else {
        return false;
    };
    // x / w = x' / w' as exact products.
    (0..2).all(|c| Dd::product(a[c], b[2]) == Dd::product(b[c], a[2]))
}

/// Which of a face's [uv curves](uv_curves) one is: enough to make it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CurveSource {
    /// A piece of a trim.
    Piece { trim: u32, place: PiecePlace },
    /// The segment that joins a trim to another.
    Join { after: u32, next: u32 },
}

impl CurveSource {
    pub(super) fn trim(self) -> Option<usize> {
        match self {
            Self::Piece { trim, .. } => Some(trim as usize),
            Self::Join { .. } => None,
        }
    }
}

/// The pieces of a trim, in the trim's own direction.
pub(super) fn trim_sources(
    brep: &Brep,
    trim: usize,
) -> impl DoubleEndedIterator<Item = CurveSource> {
    let t = &brep.parts().trims[trim];
    let mut places = Vec::new();
    let curve = &brep.parts().curves2[t.curve];
    piece_places(curve, t.span.start, t.span.end, &mut places);
    if t.reversed {
        places.reverse();
    }
    let trim = trim as u32;
    let piece = move |place| CurveSource::Piece { trim, place };
    places.into_iter().map(piece)
}

/// The curves that bound the region of face `face`, in the order of [`uv_curves`].
pub(crate) fn curve_sources(brep: &Brep, face: usize) -> Vec<CurveSource> {
    let parts = brep.parts();
    let mut out = Vec::new();
    for &l in parts.faces[face].loops.iter().flatten() {
        let trims = &parts.loops[l].trims;
        let mut ends = Vec::with_capacity(trims.len());
        for &t in trims {
            let before = out.len();
            out.extend(trim_sources(brep, t));
            if out.len() > before {
                ends.push(t);
            }
        }
        for (i, &after) in ends.iter().enumerate() {
            let next = ends[(i + 1) % ends.len()];
            if !meet(brep, &parts.trims[after], &parts.trims[next]) {
                out.push(CurveSource::Join {
                    after: after as u32,
                    next: next as u32,
                });
            }
        }
    }
    out
}

/// One of the [`curve_sources`] by itself: the segment that joins a trim, by its place in its loop, to the next that has pieces.
pub(super) fn join_source(brep: &Brep, trims: &[usize], at: usize) -> Option<CurveSource> {
    let all = &brep.parts().trims;
    let has_pieces = |t: usize| trim_sources(brep, t).next().is_some();
    let after = trims[at];
    if !has_pieces(after) {
        return None;
    }
    let mut following = trims[at + 1..].iter().chain(&trims[..=at]);
    let next = *following.find(|t| has_pieces(**t))?;
    (!meet(brep, &all[after], &all[next])).then_some(CurveSource::Join {
        after: after as u32,
        next: next as u32,
    })
}

/// The first or the last point of a trim; `None` where it has no pieces.
pub(super) fn trim_end<T: Real>(brep: &Brep, trim: usize, last: bool) -> Option<Homogeneous<T, 3>> {
    let mut sources = trim_sources(brep, trim);
    let source = if last {
        sources.next_back()
    } else {
        sources.next()
    };
    let points = uv_curve(brep, source?).points;
    let end = if last { points.last() } else { points.first() };
    end.copied()
}

/// A box around some curves in uv; `None` where there are none, or one is not known.
pub(super) fn uv_box(
    brep: &Brep,
    sources: impl Iterator<Item = CurveSource>,
) -> Option<[[f64; 2]; 2]> {
    let mut out: Option<[[f64; 2]; 2]> = None;
    for source in sources {
        let points = uv_curve::<f64>(brep, source).points;
        let own = [0, 1].map(|c| hull(&points, c));
        let all = out.get_or_insert(own);
        for c in 0..2 {
            all[c] = [all[c][0].min(own[c][0]), all[c][1].max(own[c][1])];
        }
    }
    out.filter(|b| b.iter().flatten().all(|x| x.is_finite()))
}

/// One of the [uv curves](uv_curves), by itself: the same to the last bit.
pub(crate) fn uv_curve<T: Real>(brep: &Brep, source: CurveSource) -> UvCurve<T> {
    match source {
        CurveSource::Piece { trim, place } => {
            let t = &brep.parts().trims[trim as usize];
            let curve = &brep.parts().curves2[t.curve];
            // No points where there is no such piece.
            let piece = curve_piece(curve, t.span.start, t.span.end, place);
            let piece = piece.unwrap_or_else(|| BezierCurve {
                points: Vec::new(),
                map: ParamMap::new(0.0, 0.0),
                arc: None,
            });
            UvCurve::of_trim(trim as usize, t.reversed, piece)
        }
        CurveSource::Join { after, next } => {
            let ends = [(after, true), (next, false)];
            let ends = ends.map(|(trim, last)| trim_end(brep, trim as usize, last));
            let points = ends.iter().flatten().map(end_point).collect();
            UvCurve::join(after as usize, points)
        }
    }
}

/// All curves that bound the region of face `face`, in uv.
pub(crate) fn uv_curves<T: Real>(brep: &Brep, face: usize) -> Vec<UvCurve<T>> {
    let parts = brep.parts();
    let mut out = Vec::new();
    for &l in parts.faces[face].loops.iter().flatten() {
        let trims = &parts.loops[l].trims;
        let mut ends = Vec::with_capacity(trims.len());
        for &t in trims {
            let before = out.len();
            out.extend(trim_curves(brep, t));
            if let ([first, ..], [.., last]) = (&out[before..], &out[before..]) {
                ends.push((t, first.points[0], last.points[last.points.len() - 1]));
            }
        }
        for (i, (t, _, end)) in ends.iter().enumerate() {
            let (next, start, _) = &ends[(i + 1) % ends.len()];
            if !meet(brep, &parts.trims[*t], &parts.trims[*next]) {
                let points = vec![end_point(end), end_point(start)];
                out.push(UvCurve::join(*t, points));
            }
        }
    }
    out
}

/// The control points of a Bezier curve over `[a, b]`. Ends of the curve itself, and weights of 1, stay as exact as they are.
pub(crate) fn restrict<T: Real, const H: usize>(
    points: &[Homogeneous<T, H>],
    a: f64,
    b: f64,
) -> Vec<Homogeneous<T, H>> {
    let p = points.len() - 1;
    if a == 0.0 && b == 1.0 {
        return points.to_vec();
    }
    // Averages of what is 1 are.
    let rational = !points.iter().all(|p| p[H - 1].is_one());
    let coordinates = if rational { H } else { H - 1 };
    let mut d = Vec::with_capacity(points.len());
    (0..=p)
        .map(|k| {
            d.clear();
            d.extend_from_slice(points);
            for r in 0..p {
                let x = if r < p - k { a } else { b };
                if x == 0.0 {
                    continue;
                }
                if x == 1.0 {
                    d.copy_within(1..=p - r, 0);
                    continue;
                }
                let x = Ball::exact(x);
                let y = Ball::ONE - x;
                for i in 0..p - r {
                    for c in 0..coordinates {
                        d[i][c] = y * d[i][c] + x * d[i + 1][c];
                    }
                }
            }
            d[0]
        })
        .collect()
}

/// The range of a coordinate over a curve, by its control points: proven, infinite where a weight is not
/// proven to be positive.
fn hull<T: Real>(points: &[Homogeneous<T, 3>], c: usize) -> [f64; 2] {
    points
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |r, p| {
            let x = p[c] / p[2];
            let (low, high) = (x.lower(), x.upper());
            if p[2].is_above(0.0) && low.is_finite() && high.is_finite() {
                [r[0].min(low), r[1].max(high)]
            } else {
                [f64::NEG_INFINITY, f64::INFINITY]
            }
        })
}

/// How far past the borders of a span what lies near them still meets it, in native units. That is far more than
/// a border that is no f64 is off the one that is compared.
fn slack(m: &ParamMap) -> f64 {
    BORDER_SLACK * (m.end - m.start) + 8.0 * f64::EPSILON * m.start.abs().max(m.end.abs())
}

/// The indices of the spans that `range` meets, and whether it stays within one of them up to the slack.
fn spans(maps: &[ParamMap], range: [f64; 2]) -> (std::ops::Range<usize>, bool) {
    let meets = |m: &ParamMap| range[1] >= m.start - slack(m) && range[0] <= m.end + slack(m);
    let first = maps.iter().position(meets).unwrap_or(0);
    let last = maps.iter().rposition(meets).map_or(0, |i| i + 1);
    let within = |m: &ParamMap| range[0] >= m.start - slack(m) && range[1] <= m.end + slack(m);
    // A curve that runs along a border belongs to the patches of both sides.
    (
        first..last.max(first),
        maps[first..last.max(first)].iter().all(within),
    )
}

/// Which part of which boundary curve lies over which patch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub(crate) curve: u32,
    pub(crate) patch: u32,
    from: f64,
    to: f64,
}

/// Cuts the boundary of face `face` at the patches, which stand in a grid.
pub(crate) fn cut_boundary(brep: &Brep, face: usize, patches: &Patches<f64>) -> Vec<Cut> {
    let [maps_u, maps_v] = patches.maps();
    let count_v = maps_v.len();
    let mut out = Vec::new();
    for (index, curve) in uv_curves::<f64>(brep, face).iter().enumerate() {
        let mut settled: Vec<(f64, f64, Cells)> = Vec::new();
        let mut open = vec![(0.0, 1.0)];
        for depth in 0..=MAX_DEPTH {
            let mut crossing = Vec::new();
            for &(from, to) in &open {
                let part = restrict(&curve.points, from, to);
                let cells = |part: &[Homogeneous<f64, 3>]| {
                    let (us, in_u) = spans(&maps_u, hull(part, 0));
                    let (vs, in_v) = spans(&maps_v, hull(part, 1));
                    ((us, vs), in_u, in_v)
                };
                let ((us, vs), in_u, in_v) = cells(&part);
                if us.is_empty() || vs.is_empty() {
                    continue; // Outside the domain: not in the region.
                }
                if (in_u && in_v) || depth == MAX_DEPTH || open.len() > MAX_CROSSING {
                    settled.push((from, to, (us, vs)));
                    continue;
                }
                let across_u = (!in_u).then(|| passage(&part, 0, &maps_u[us])).flatten();
                let across = across_u.or_else(|| passage(&part, 1, &maps_v[vs]));
                if let Some(ends) = across {
                    let [a, b] = ends.map(|t| from + t * (to - from));
                    settled.push((a, b, cells(&restrict(&curve.points, a, b)).0));
                    crossing.extend([(from, a), (b, to)]);
                } else {
                    let middle = 0.5 * (from + to);
                    crossing.extend([(from, middle), (middle, to)]);
                }
            }
            open = crossing;
        }
        settled.sort_by(|a, b| a.0.total_cmp(&b.0));
        merge(&mut settled);
        for (from, to, (us, vs)) in settled {
            for iu in us {
                for iv in vs.clone() {
                    let patch = iu * count_v + iv;
                    for (from, to) in composable(&curve.points, from, to, patches, patch) {
                        out.push(Cut {
                            curve: index as u32,
                            patch: patch as u32,
                            from,
                            to,
                        });
                    }
                }
            }
        }
    }
    out
}

/// Halves a part of a curve until each is of a kind that composes well with its patch, in double-double too.
fn composable(
    curve: &[Homogeneous<f64, 3>],
    from: f64,
    to: f64,
    patches: &Patches<f64>,
    patch: usize,
) -> Vec<(f64, f64)> {
    let maps = patches.maps_of(patch);
    let mut settled = Vec::new();
    let mut open = vec![(from, to, 0)];
    while let Some((from, to, depth)) = open.pop() {
        let part = || to_local(&restrict(curve, from, to), &maps);
        if depth < COMPOSE_HALVINGS && patches.wants_parts(patch, part, Dd::UNIT) {
            let middle = 0.5 * (from + to);
            open.extend([(middle, to, depth + 1), (from, middle, depth + 1)]);
        } else {
            settled.push((from, to));
        }
    }
    settled
}

/// A curve in the patch's local square.
fn to_local<T: Real>(points: &[Homogeneous<T, 3>], maps: &[ParamMap; 2]) -> Vec<Homogeneous<T, 3>> {
    let local = |p: &Homogeneous<T, 3>, c: usize| maps[c].local_of(p[c], p[2]);
    let both = |p| [local(p, 0), local(p, 1), p[2]];
    points.iter().map(both).collect()
}

/// Where a part of a curve passes the border in the middle of some patches side by side, along u or v: a stretch that is just long enough for its ends to be
/// clearly on one patch each. `None` where it does not pass from one side to the other, or at so small an angle that the stretch would be no short one.
/// (Where the cuts are is free: whatever parts a curve is cut into, each is told its patches by its own hull.)
fn passage(part: &[Homogeneous<f64, 3>], c: usize, maps: &[ParamMap]) -> Option<[f64; 2]> {
    /// Of the slack by which parts near a border belong to both sides.
    const CLEARLY: f64 = 4.0;
    /// Parts of the whole that are short.
    const SHORT: f64 = 1.0 / 64.0;
    let (before, after) = maps.split_at(maps.len() / 2);
    let (before, after) = (before.last()?, after.first()?);
    let border = after.start;
    let height = |t: f64| {
        let (p, _) = curve_jet(part, Ball::exact(t));
        p[c].mid - border * p[2].mid
    };
    let ends = [0.0, 1.0].map(height);
    if !(ends[0] * ends[1] < 0.0) {
        return None;
    }
    let mut around = [0.0, 1.0];
    while around[1] - around[0] > f64::EPSILON {
        let middle = 0.5 * (around[0] + around[1]);
        let low = (height(middle) < 0.0) == (ends[0] < 0.0);
        around[usize::from(!low)] = middle;
    }
    let at = around[0];
    let (p, slope) = curve_jet(part, Ball::exact(at));
    // Of the quotient, whose numerator vanishes here.
    let speed = ((slope[c].mid - border * slope[2].mid) / p[2].mid).abs();
    let wide = CLEARLY * slack(before).max(slack(after)) / speed;
    let ends = [at - wide, at + wide];
    // Negated: what is no number is not short.
    let short = wide > 2.0 * f64::EPSILON && wide < SHORT && ends[0] > 0.0 && ends[1] < 1.0;
    short.then_some(ends)
}

/// The rows and columns of patches that a part of a curve lies over.
type Cells = (std::ops::Range<usize>, std::ops::Range<usize>);

/// Joins neighbouring parts over the same patches.
fn merge(parts: &mut Vec<(f64, f64, Cells)>) {
    parts.dedup_by(|next, kept| {
        let same = kept.1 == next.0 && kept.2 == next.2;
        if same {
            kept.1 = next.1;
        }
        same
    });
}

/// The piece of the boundary that a cut describes.
pub(crate) fn lift<T: Real>(curve: &UvCurve<T>, cut: &Cut, surface: &Patch<T>) -> Piece<T> {
    let local = to_local(&restrict(&curve.points, cut.from, cut.to), &surface.maps);
    let space = surface.compose(&local).map(|points| {
        let u = points.len() - 1;
        Net::new(Bidegree { u, v: 0 }, points, surface.net.origin)
    });
    Piece {
        trim: curve.trim,
        patch: cut.patch as usize,
        local,
        space,
        span: [cut.from, cut.to].map(|t| curve.span[0] + t * (curve.span[1] - curve.span[0])),
    }
}

/// Ranges of native parameters that hold what lies on its patch of a piece of the boundary.
pub(super) fn native_range(curve: &UvCurve<f64>, cut: &Cut, maps: &[ParamMap; 2]) -> [[f64; 2]; 2] {
    let part = restrict(&curve.points, cut.from, cut.to);
    [0, 1].map(|c| {
        // Borders may be no f64, and between two that are neighbours.
        let (low, high) = (maps[c].start.next_down(), maps[c].end.next_up());
        hull(&part, c).map(|x| x.max(low).min(high))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::{BrepBuilder, TrimSpec};
    use crate::numeric::Interval;
    use crate::nurbs::{Arc, Plane, Polyline, Surface};
    use nalgebra::{Point3, Vector2, Vector3};

    fn curve(points: &[[f64; 3]]) -> Vec<Homogeneous<f64, 3>> {
        points.iter().map(|p| p.map(Ball::exact)).collect()
    }

    const HALVES: [ParamMap; 2] = [ParamMap::new(0.0, 0.5), ParamMap::new(0.5, 1.0)];

    /// A quarter of the unit circle has `u = 1/2` at 60 degrees, where `(1 - t^2) / (1 + t^2) = 1/2`: at `t = 1 / sqrt 3`.
    #[test]
    fn a_curve_that_passes_a_border_is_cut_on_both_sides_of_it() {
        let arc = curve(&[[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 2.0]]);
        let [a, b] = passage(&arc, 0, &HALVES).expect("a passage");
        let at = 1.0 / 3f64.sqrt();
        // Twice four slacks, each below 2^-44, where u falls by 4 t / (1 + t^2)^2 = 1.3 for each unit of t: with room to spare.
        const MOST: f64 = 1.0 / (1u64 << 40) as f64;
        assert!(a < at && at < b && b - a < MOST, "{a} {b}");
        for (ends, patch) in [([0.0, a], 1), ([b, 1.0], 0)] {
            let part = restrict(&arc, ends[0], ends[1]);
            assert_eq!(spans(&HALVES, hull(&part, 0)), (patch..patch + 1, true));
        }
        let part = restrict(&arc, a, b);
        assert_eq!(spans(&HALVES, hull(&part, 0)).0, 0..2);
    }

    /// A part of a curve has the curve's own ends where it has them, and weights of 1, without a bound; between them points are averages, known to roundings.
    #[test]
    fn parts_keep_exact_ends_and_weights() {
        let parabola = curve(&[[0.1, 0.3, 1.0], [0.7, 0.2, 1.0], [0.9, 0.6, 1.0]]);
        for (a, b) in [(0.0, 0.3), (0.3, 1.0), (0.25, 0.75)] {
            let part = restrict(&parabola, a, b);
            assert!(part.iter().all(|p| p[2].is_one()));
            for (end, t) in [(0, a), (2, b)] {
                let exact = t == 0.0 || t == 1.0;
                let point = [0, 1].map(|c| {
                    let [p, q, r] = [0, 1, 2].map(|i| parabola[i][c].mid);
                    (1.0 - t) * (1.0 - t) * p + 2.0 * t * (1.0 - t) * q + t * t * r
                });
                for c in 0..2 {
                    let x = part[end][c];
                    assert_eq!(x.rad == 0.0, exact, "{a} {b}: {x:?}");
                    if exact {
                        assert_eq!(x.mid, parabola[end][c].mid);
                    }
                    // Some roundings of numbers below 1.
                    let off = (x.mid - point[c]).abs();
                    assert!(off <= 4.0 * f64::EPSILON, "{a} {b}: {x:?}");
                }
            }
        }
        // Weights that are not 1 are averages, too.
        let arc = curve(&[[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 2.0]]);
        let part = restrict(&arc, 0.0, 0.5);
        assert_eq!(part[2][2].mid, 1.25);
        assert_eq!((part[0][0].mid, part[0][0].rad), (1.0, 0.0));
    }

    /// Half a disc, its loop as it is seen from either side: curves made one by one are those made together, and have the same numbers. (An arc's ends are
    /// none that are known to meet others, so that there are joins.)
    #[test]
    fn a_curve_by_itself_is_the_one_of_all() {
        let interval = |a: f64, b: f64| Interval::new(a, b).unwrap();
        for up in [1.0, -1.0] {
            let arc = Arc {
                center: Point2::origin(),
                x: Vector2::x(),
                y: Vector2::y() * up,
                z: Vector2::zeros(),
                radius: 1.0,
                angle: interval(0.0, 3.0),
                domain: interval(0.0, 3.0),
            };
            let end = [3f64.cos(), up * 3f64.sin()];
            let points = [end, [0.0, -0.5 * up], [1.0, 0.0]].map(Point2::from);
            let polyline = Polyline::new(points.to_vec(), vec![0.0, 1.0, 3.0]).unwrap();
            let mut b = BrepBuilder::new();
            let [v, w] = [[1.0, 0.0], end].map(|[x, y]| b.vertex([x, y, 0.0]));
            let trim = |vertices, curve| TrimSpec {
                vertices,
                curve,
                edge: None,
            };
            let trims = vec![
                trim([v, w], Curve2::Arc(arc)),
                trim([w, v], Curve2::Polyline(polyline)),
            ];
            let plane = Plane {
                origin: Point3::origin(),
                x: Vector3::x(),
                y: Vector3::y(),
                domain: [interval(-2.0, 2.0); 2],
                extents: [interval(-2.0, 2.0); 2],
            };
            b.face_with_trims(Surface::Plane(plane), vec![trims])
                .unwrap();
            let brep = b.build().unwrap();
            fn check<T: Real>(brep: &Brep) {
                let all = uv_curves::<T>(brep, 0);
                let sources = curve_sources(brep, 0).into_iter();
                let alone: Vec<UvCurve<T>> = sources.map(|c| uv_curve(brep, c)).collect();
                assert!(all.iter().any(|c| c.trim.is_none()) && all.len() > 5);
                assert_eq!(format!("{alone:?}"), format!("{all:?}"));
                // Each knows between which of its trim's own parameters it runs.
                for c in &all {
                    let Some(trim) = c.trim.map(|t| &brep.parts().trims[t]) else {
                        continue;
                    };
                    let (first, last) = (&c.points[0], &c.points[c.points.len() - 1]);
                    for (end, at) in [first, last].into_iter().zip(c.span) {
                        let truth = brep.parts().curves2[trim.curve].point(at);
                        for k in 0..2 {
                            let off = (end[k] / end[2]).mid.approximate() - truth[k];
                            // Some roundings of numbers below 1.
                            assert!(off.abs() <= 4.0 * f64::EPSILON, "{at}: {off}");
                        }
                    }
                }
            }
            check::<f64>(&brep);
            check::<Dd>(&brep);
            // Joins stand after the trims of their loop, in the order of those.
            let trims = &brep.parts().loops[0].trims;
            let is_join = |c: &CurveSource| matches!(c, CurveSource::Join { .. });
            let joins = { curve_sources(&brep, 0).into_iter() }.filter(is_join);
            let found = (0..trims.len()).filter_map(|at| join_source(&brep, trims, at));
            assert_eq!(found.collect::<Vec<_>>(), joins.collect::<Vec<_>>());
        }
    }

    /// One that touches the border does not pass it, and one that passes it flat has no short stretch there.
    #[test]
    fn a_curve_that_touches_a_border_is_left_to_halving() {
        let touching = curve(&[[0.0, 0.0, 1.0], [1.0, 0.5, 1.0], [0.0, 1.0, 1.0]]);
        assert_eq!(passage(&touching, 0, &HALVES), None);
        // 2 u - 1 = (2 t - 1)^5, whose coefficients are -1 and 1 in turn.
        let flat = [0.0, 1.0, 0.0, 1.0, 0.0, 1.0].map(|u| [u, u, 1.0]);
        assert_eq!(passage(&curve(&flat), 0, &HALVES), None);
    }
}
