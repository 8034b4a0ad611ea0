//! Bezier pieces of splines, with bounds.

use super::circle::{ArcPieces, degree, span_count};
use super::param::{ParamMap, order};
use crate::numeric::{Ball, Dd, Interval, Real};
use crate::nurbs::{Curve, KnotVector, NurbsCurve, Polyline};
use nalgebra::{Point, SVector};

/// A homogeneous point with bounds.
pub(crate) type Homogeneous<T, const H: usize> = [Ball<T>; H];

/// A rational Bezier curve: homogeneous control points and the native
/// parameters it covers.
#[derive(Clone, Debug)]
pub(crate) struct BezierCurve<T, const H: usize> {
    pub(crate) points: Vec<Homogeneous<T, H>>,
    pub(crate) map: ParamMap,
    /// What the points stand for where it is an arc.
    pub(crate) arc: Option<Box<ArcPiece<T, H>>>,
}

impl<T, const H: usize> BezierCurve<T, H> {
    /// Bytes that it takes besides its own.
    pub(super) fn bytes(&self) -> usize {
        let arc = self.arc.as_ref().map_or(0, |a| size_of_val(&**a));
        self.points.capacity() * size_of::<Homogeneous<T, H>>() + arc
    }
}

/// `center + cos a x + sin a y`, homogeneous, the angle running linearly over the piece.
#[derive(Clone, Debug)]
pub(crate) struct ArcPiece<T, const H: usize> {
    pub(crate) center: Homogeneous<T, H>,
    pub(crate) x: Homogeneous<T, H>,
    pub(crate) y: Homogeneous<T, H>,
    /// The angle at the start, and how much further it is at the end.
    pub(crate) angle: [Ball<Dd>; 2],
}

/// How the Bezier control points over `[a, b]` within a span of a spline follow from its own.
///
/// Control point `k` is the blossom at `a` (`p - k` times) and `b` (`k` times). Source: L. Ramshaw, *Blossoming* (1987); the
/// recursion is de Boor's with a new argument at each level. Its weights depend on the knots and on whether the argument is `a` or
/// `b`: they are made once for all rows of a net.
pub(crate) struct Blossom<T> {
    degree: usize,
    index: usize,
    /// For `a`, then for `b`: the weights `(down, up)` of the steps of level 1, 2, ..., each from its last step to its first.
    weights: [Vec<[Ball<T>; 2]>; 2],
}

impl<T: Real> Blossom<T> {
    pub(crate) fn new(knots: &KnotVector, index: usize, a: f64, b: f64) -> Self {
        let p = knots.degree();
        let t = knots.knots();
        let weights = [a, b].map(|argument| {
            let steps = (1..=p).flat_map(|r| (r..=p).rev().map(move |j| (r, j)));
            let weight = |(r, j): (usize, usize)| {
                let (low, high) = (t[index - p + j], t[j + 1 + index - r]);
                let width = Ball::<T>::difference(high, low);
                let up = Ball::difference(argument, low) / width;
                let down = Ball::difference(high, argument) / width;
                [down, up]
            };
            steps.map(weight).collect()
        });
        Self {
            degree: p,
            index,
            weights,
        }
    }

    /// The Bezier control points of the spline with control points `point(0), point(1), ...`.
    pub(crate) fn apply<const H: usize>(
        &self,
        point: impl Fn(usize) -> Homogeneous<T, H>,
    ) -> Vec<Homogeneous<T, H>> {
        let p = self.degree;
        // The points, and room to go on from them.
        let mut both = Vec::with_capacity(2 * (p + 1));
        both.extend((0..=p).map(|j| point(self.index - p + j)));
        both.extend_from_within(..);
        let (own, d) = both.split_at_mut(p + 1);
        (0..=p)
            .map(|k| {
                d.copy_from_slice(own);
                let mut at = 0;
                for r in 1..=p {
                    let weights = &self.weights[usize::from(r > p - k)];
                    for j in (r..=p).rev() {
                        let [down, up] = weights[at];
                        at += 1;
                        for c in 0..H {
                            d[j][c] = down * d[j - 1][c] + up * d[j][c];
                        }
                    }
                }
                d[p]
            })
            .collect()
    }
}

fn homogeneous<T: Real, const D: usize, const H: usize>(p: &Point<f64, D>) -> Homogeneous<T, H> {
    std::array::from_fn(|c| if c < D { Ball::exact(p[c]) } else { Ball::ONE })
}

/// The point `from + (to - from) (t - start) / (end - start)`.
fn on_segment<T: Real, const D: usize, const H: usize>(
    from: &Point<f64, D>,
    to: &Point<f64, D>,
    span: Interval,
    t: f64,
) -> Homogeneous<T, H> {
    if t == span.start {
        return homogeneous(from);
    }
    if t == span.end {
        return homogeneous(to);
    }
    let width = Ball::<T>::difference(span.end, span.start);
    let s = Ball::difference(t, span.start) / width;
    let mut out = homogeneous(from);
    for c in 0..D {
        out[c] = out[c] + s * Ball::difference(to[c], from[c]);
    }
    out
}

/// The piece of a segment, which runs over `span`, that lies over `[from, to]`.
fn segment_piece<T: Real, const D: usize, const H: usize>(
    [a, b]: [&Point<f64, D>; 2],
    span: Interval,
    [from, to]: [f64; 2],
) -> BezierCurve<T, H> {
    let (s, e) = (from.max(span.start), to.min(span.end));
    BezierCurve {
        points: vec![on_segment(a, b, span, s), on_segment(a, b, span, e)],
        map: ParamMap::new(s, e),
        arc: None,
    }
}

/// The same of segment `index` of a polyline.
fn polyline_piece<T: Real, const D: usize, const H: usize>(
    c: &Polyline<D>,
    index: usize,
    over: [f64; 2],
) -> BezierCurve<T, H> {
    let (points, params) = (&c.points()[index..], &c.params()[index..]);
    let span = Interval {
        start: params[0],
        end: params[1],
    };
    segment_piece([&points[0], &points[1]], span, over)
}

/// The same of the span of a spline that starts at knot `index`.
fn spline_piece<T: Real, const H: usize>(
    c: &NurbsCurve<H>,
    index: usize,
    [from, to]: [f64; 2],
) -> BezierCurve<T, H> {
    let exact = |p: &SVector<f64, H>| std::array::from_fn(|i| Ball::exact(p[i]));
    let stored = |i: usize| exact(&c.control_points()[i]);
    let (p, knots) = (c.knots().degree(), c.knots().knots());
    let (s, e) = (from.max(knots[index]), to.min(knots[index + 1]));
    let mut points = Blossom::new(c.knots(), index, s, e).apply(stored);
    // At a knot as often there as the degree the curve is at a control point.
    if knots[index + 1 - p] == s {
        points[0] = stored(index - p);
    }
    if knots[index + p] == e {
        points[p] = stored(index);
    }
    // The piece is made of affine combinations of the span's control points: where all their weights are 1, so are its own, exactly.
    let own = &c.control_points()[index - p..=index];
    if own.iter().all(|p| p[H - 1] == 1.0) {
        points.iter_mut().for_each(|x| x[H - 1] = Ball::ONE);
    }
    BezierCurve {
        points,
        map: ParamMap::new(s, e),
        arc: None,
    }
}

/// Which of the pieces of a curve one is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PiecePlace {
    /// The segment of a poly-curve.
    segment: u32,
    /// The segment of a polyline, the knot that a span starts at, or the part of an arc.
    part: u32,
}

impl PiecePlace {
    fn part(part: usize) -> Self {
        Self {
            segment: 0,
            part: part as u32,
        }
    }
}

/// Which pieces [`curve_pieces`] are, in order.
pub(crate) fn piece_places<const D: usize, const H: usize>(
    curve: &Curve<D, H>,
    from: f64,
    to: f64,
    out: &mut Vec<PiecePlace>,
) {
    let meets = |start: f64, end: f64| from.max(start) < to.min(end);
    match curve {
        Curve::Line(c) => {
            out.extend(meets(c.domain.start, c.domain.end).then(|| PiecePlace::part(0)));
        }
        Curve::Polyline(c) => {
            let all = c.params().windows(2).enumerate();
            let met = all.filter(|(_, t)| meets(t[0], t[1]));
            out.extend(met.map(|(k, _)| PiecePlace::part(k)));
        }
        Curve::Nurbs(c) => {
            let met = c.knots().spans().filter(|(_, a, b)| meets(*a, *b));
            out.extend(met.map(|(index, ..)| PiecePlace::part(index)));
        }
        Curve::Poly(c) => {
            let all = c.segments().iter().zip(c.params().windows(2));
            for (k, (piece, t)) in all.enumerate() {
                let Some([s, e]) = poly_part(piece.domain(), [t[0], t[1]], [from, to]) else {
                    continue;
                };
                let first = out.len();
                piece_places(piece, s, e, out);
                out[first..]
                    .iter_mut()
                    .for_each(|place| place.segment = k as u32);
            }
        }
        Curve::Arc(c) => {
            let count = span_count(c.angle, c.domain, from, to);
            out.extend((0..count).map(PiecePlace::part));
        }
    }
}

/// One of the [`curve_pieces`], by itself: the same to the last bit. `None` where a poly-curve has no such segment there.
pub(crate) fn curve_piece<T: Real, const D: usize, const H: usize>(
    curve: &Curve<D, H>,
    from: f64,
    to: f64,
    place: PiecePlace,
) -> Option<BezierCurve<T, H>> {
    let part = place.part as usize;
    Some(match curve {
        Curve::Line(c) => segment_piece([&c.from, &c.to], c.domain, [from, to]),
        Curve::Polyline(c) => polyline_piece(c, part, [from, to]),
        Curve::Nurbs(c) => spline_piece(c, part, [from, to]),
        Curve::Poly(c) => {
            let k = place.segment as usize;
            let (piece, t) = (c.segments().get(k)?, [c.params()[k], c.params()[k + 1]]);
            let own = piece.domain();
            let [s, e] = poly_part(own, t, [from, to])?;
            let mut piece = curve_piece(piece, s, e, place)?;
            let asked = [from.max(t[0]), to.min(t[1])];
            reparametrize(&mut piece, [own.start, own.end], t, ([s, e], asked));
            piece
        }
        Curve::Arc(c) => ArcPieces::new(c, from, to).piece(part),
    })
}

/// The Bezier pieces of `curve` over `[from, to]`, in order.
pub(crate) fn curve_pieces<T: Real, const D: usize, const H: usize>(
    curve: &Curve<D, H>,
    from: f64,
    to: f64,
    out: &mut Vec<BezierCurve<T, H>>,
) {
    if let Curve::Arc(c) = curve {
        // Its axes are those of all pieces.
        let pieces = ArcPieces::new(c, from, to);
        out.extend((0..pieces.len()).map(|k| pieces.piece(k)));
        return;
    }
    let mut places = Vec::new();
    piece_places(curve, from, to, &mut places);
    let pieces = places.iter();
    out.extend(pieces.filter_map(|place| curve_piece(curve, from, to, *place)));
}

/// How many pieces a curve has, and control points in all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PieceCount {
    pub(crate) pieces: usize,
    pub(crate) points: usize,
}

impl std::ops::Add for PieceCount {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            pieces: self.pieces.saturating_add(other.pieces),
            points: self.points.saturating_add(other.points),
        }
    }
}

/// How many [`curve_pieces`] there are, in f64: nothing of them is made.
pub(crate) fn piece_count<const D: usize, const H: usize>(
    curve: &Curve<D, H>,
    from: f64,
    to: f64,
) -> PieceCount {
    let of = |pieces: usize, each: usize| PieceCount {
        pieces,
        points: pieces.saturating_mul(each),
    };
    let meets = |start: f64, end: f64| from.max(start) < to.min(end);
    match curve {
        Curve::Line(c) => of(usize::from(meets(c.domain.start, c.domain.end)), 2),
        Curve::Polyline(c) => {
            let met = c.params().windows(2).filter(|t| meets(t[0], t[1]));
            of(met.count(), 2)
        }
        Curve::Nurbs(c) => {
            let met = c.knots().spans().filter(|(_, a, b)| meets(*a, *b));
            of(met.count(), c.degree() + 1)
        }
        Curve::Arc(c) => of(span_count(c.angle, c.domain, from, to), degree::<f64>() + 1),
        Curve::Poly(c) => {
            let met = { c.segments().iter().zip(c.params().windows(2)) };
            let met = met.filter_map(|(piece, t)| {
                let [s, e] = poly_part(piece.domain(), [t[0], t[1]], [from, to])?;
                Some(piece_count(piece, s, e))
            });
            met.fold(PieceCount::default(), |a, b| a + b)
        }
    }
}

/// The part of a segment of a poly-curve, in its own parameters `own`, that lies over `[from, to]` of the poly-curve's; `t`: where the segment
/// lies among these. `None` where nothing of it does.
fn poly_part(own: Interval, t: [f64; 2], [from, to]: [f64; 2]) -> Option<[f64; 2]> {
    let (s, e) = (from.max(t[0]), to.min(t[1]));
    // The poly-curve's own rounding rule: segments are cut at rounded parameters, whole segments at their ends.
    let at = |x: f64| {
        if x == t[0] {
            own.start
        } else if x == t[1] {
            own.end
        } else {
            own.lerp((x - t[0]) / (t[1] - t[0]))
                .clamp(own.start, own.end)
        }
    };
    (s < e).then(|| [at(s), at(e)])
}

/// Moves a piece from a segment's own parameters to those of its poly-curve, `own` to `to` linearly.
///
/// That changes nothing of the piece: its ends are numbers of f64 among the segment's own parameters, and the map between its local parameter and the
/// poly-curve's [keeps them as such](ParamMap::of_segment).
///
/// `cut`: where the segment was cut, in its own parameters, and where that was asked for in the poly-curve's. If one is not the other's image,
/// the own parameter was [rounded](poly_part), by less than 8 units of the larger end of `own`: 2.5 of its length for the quotient and the
/// product, and half of one for the sum. The local parameter of a given parameter of the poly-curve is then off by that over the
/// piece's length, `off` at most, and the homogeneous point by `off` times its derivative, `degree` times the largest
/// difference of control points and as often at most `(1 + 2 off)^degree` as it is taken past the ends, less than 2 for
/// `off * degree <= 1/4`: it goes into their radii.
fn reparametrize<T: Real, const H: usize>(
    piece: &mut BezierCurve<T, H>,
    own: [f64; 2],
    to: [f64; 2],
    cut: ([f64; 2], [f64; 2]),
) {
    let part = [piece.map.start, piece.map.end];
    let Some(map) = ParamMap::of_segment(part, own, to) else {
        // An end is no number.
        return widen(piece, f64::INFINITY);
    };
    piece.map = map;
    let (at, asked) = cut;
    let moved = |k: usize| {
        let exact = order(asked[k], at[k], own, to).is_some_and(|o| o.is_eq());
        part[k] == at[k] && !exact
    };
    if moved(0) || moved(1) {
        let off = 8.0 * f64::EPSILON * own[0].abs().max(own[1].abs()) / (part[1] - part[0]);
        widen(piece, off);
    }
}

/// See [`reparametrize`].
fn widen<T: Real, const H: usize>(piece: &mut BezierCurve<T, H>, off: f64) {
    // Its angle is no longer known to the last digit.
    piece.arc = None;
    let degree = (piece.points.len() - 1) as f64;
    for c in 0..H {
        let steps = piece.points.windows(2);
        let largest = steps
            .map(|p| (p[1][c] - p[0][c]).magnitude())
            .fold(0.0, f64::max);
        let slack = if off * degree <= 0.25 {
            2.0 * degree * largest * off
        } else {
            f64::INFINITY
        };
        for p in &mut piece.points {
            p[c].rad = (p[c].rad + slack) * (1.0 + 4.0 * f64::EPSILON);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nurbs::{Arc, Curve2, Line, NurbsCurve, PolyCurve, Polyline};
    use dashu_ratio::RBig;
    use nalgebra::{Point2, Vector2, Vector3};

    fn interval(start: f64, end: f64) -> Interval {
        Interval::new(start, end).unwrap()
    }

    fn pieces<T: Real>(curve: &Curve2, from: f64, to: f64) -> Vec<BezierCurve<T, 3>> {
        let mut out = Vec::new();
        curve_pieces(curve, from, to, &mut out);
        out
    }

    /// A spline with inner knots, a poly-line, and an arc of several pieces.
    fn segments() -> Vec<Curve2> {
        let points = [[0.1, 0.2], [1.3, 0.1], [1.7, 1.9], [0.6, 2.3], [0.1, 3.1]];
        let homogeneous = points.iter().map(|[x, y]| Vector3::new(*x, *y, 1.0));
        let knots = vec![0.0, 0.0, 0.0, 0.3, 0.7, 1.0, 1.0, 1.0];
        let spline = NurbsCurve::new(2, homogeneous.collect(), knots).unwrap();
        let params = vec![0.1, 0.2, 0.3, 0.7, 1.1];
        let polyline = Polyline::new(points.map(Point2::from).to_vec(), params).unwrap();
        let arc = Arc {
            center: Point2::new(0.1, 0.2),
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
            radius: 1.5,
            angle: interval(0.0, 2.0),
            domain: interval(0.1, 0.9),
        };
        vec![
            Curve2::Nurbs(spline),
            Curve2::Polyline(polyline),
            Curve2::Arc(Arc::new(arc).unwrap()),
        ]
    }

    /// To the last bit, and as narrow.
    fn check_whole<T: Real>() {
        let all = segments();
        let poly = PolyCurve::new(all.clone(), vec![1.0, 2.1, 2.8, 7.3]).unwrap();
        let found = pieces::<T>(&Curve2::Poly(poly), 1.0, 7.3);
        let own = all.iter().flat_map(|c| {
            let domain = c.domain();
            pieces::<T>(c, domain.start, domain.end)
        });
        let own: Vec<_> = own.collect();
        assert_eq!(found.len(), own.len());
        for (a, b) in found.iter().zip(&own) {
            assert_eq!(format!("{:?}", a.points), format!("{:?}", b.points));
            assert_eq!(format!("{:?}", a.arc), format!("{:?}", b.arc));
        }
        for p in found.windows(2) {
            assert!(p[0].map.meets(&p[1].map), "{:?} {:?}", p[0].map, p[1].map);
        }
    }

    #[test]
    fn pieces_of_a_poly_curve_are_those_of_its_segments() {
        check_whole::<f64>();
        check_whole::<Dd>();
    }

    /// A segment that is cut within: its own parameters are far larger than the poly-curve's, and there the cut is rounded.
    #[test]
    fn a_cut_segment_holds_its_ends() {
        let q = |x: f64| RBig::try_from(x).unwrap();
        let line = Line::new(
            Point2::new(0.0, -1.0),
            Point2::new(1.0, 3.0),
            interval(1000.0, 1001.0),
        );
        let poly = PolyCurve::new(vec![Curve2::Line(line.unwrap())], vec![0.0, 1.0]).unwrap();
        let curve = Curve2::Poly(poly);
        // What the doc of `reparametrize` allows: 8 units of 1001 over a tenth, twice the largest difference, 4.
        const MOST: f64 = 8.0 * f64::EPSILON * 1001.0 / 0.1 * 8.0;
        // Roundings of double-double alone.
        const FINE: f64 = 256.0 * Dd::UNIT * 1001.0;
        for cut in [0.1, 0.3, 0.7, 0.9] {
            let (before, after) = (
                pieces::<Dd>(&curve, 0.0, cut),
                pieces::<Dd>(&curve, cut, 1.0),
            );
            let t = q(cut);
            let truth = [t.clone(), q(-1.0) + q(4.0) * &t];
            for p in [before[0].points[1], after[0].points[0]] {
                for c in 0..2 {
                    let off = q(p[c].mid.hi) + q(p[c].mid.lo) - &truth[c];
                    let rad = q(p[c].rad);
                    assert!(-&rad <= off && off <= rad, "{cut} {c} {p:?}");
                    assert!(p[c].rad < MOST);
                }
            }
        }
        // Nothing is rounded where the cut is a round number.
        for p in [
            &pieces::<Dd>(&curve, 0.0, 0.5)[0],
            &pieces::<Dd>(&curve, 0.5, 1.0)[0],
        ] {
            assert!(p.points.iter().flatten().all(|x| x.rad < FINE), "{p:?}");
        }
    }
}
