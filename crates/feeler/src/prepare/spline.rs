//! Bezier pieces of splines, with bounds.

use super::ParamMap;
use super::circle::{arc_pieces, degree, span_count};
use crate::numeric::{Ball, Dd, Interval, Real};
use crate::nurbs::{Curve, KnotVector};
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
        let own: Vec<_> = (0..=p).map(|j| point(self.index - p + j)).collect();
        let mut d = own.clone();
        (0..=p)
            .map(|k| {
                d.copy_from_slice(&own);
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

/// The Bezier pieces of `curve` over `[from, to]`, in order.
pub(crate) fn curve_pieces<T: Real, const D: usize, const H: usize>(
    curve: &Curve<D, H>,
    from: f64,
    to: f64,
    out: &mut Vec<BezierCurve<T, H>>,
) {
    let mut segment = |a: &Point<f64, D>, b: &Point<f64, D>, span: Interval| {
        let (s, e) = (from.max(span.start), to.min(span.end));
        if s < e {
            out.push(BezierCurve {
                points: vec![on_segment(a, b, span, s), on_segment(a, b, span, e)],
                map: ParamMap { start: s, end: e },
                arc: None,
            });
        }
    };
    match curve {
        Curve::Line(c) => segment(&c.from, &c.to, c.domain),
        Curve::Polyline(c) => {
            for (p, t) in c.points().windows(2).zip(c.params().windows(2)) {
                segment(
                    &p[0],
                    &p[1],
                    Interval {
                        start: t[0],
                        end: t[1],
                    },
                );
            }
        }
        Curve::Nurbs(c) => {
            let exact = |p: &SVector<f64, H>| std::array::from_fn(|i| Ball::exact(p[i]));
            let stored = |i: usize| exact(&c.control_points()[i]);
            // Pieces are affine combinations of the control points: where all weights are 1, so are those of the pieces, exactly.
            let plain = c.control_points().iter().all(|p| p[H - 1] == 1.0);
            let (p, knots) = (c.knots().degree(), c.knots().knots());
            for (index, start, end) in c.knots().spans() {
                let (s, e) = (from.max(start), to.min(end));
                if s < e {
                    let mut points = Blossom::new(c.knots(), index, s, e).apply(stored);
                    // At a knot as often there as the degree the curve is at a control point.
                    if knots[index + 1 - p] == s {
                        points[0] = stored(index - p);
                    }
                    if knots[index + p] == e {
                        points[p] = stored(index);
                    }
                    if plain {
                        points.iter_mut().for_each(|x| x[H - 1] = Ball::ONE);
                    }
                    out.push(BezierCurve {
                        points,
                        map: ParamMap { start: s, end: e },
                        arc: None,
                    });
                }
            }
        }
        Curve::Poly(c) => {
            for (piece, t) in c.segments().iter().zip(c.params().windows(2)) {
                let own = piece.domain();
                let Some([s, e]) = poly_part(own, [t[0], t[1]], [from, to]) else {
                    continue;
                };
                let first = out.len();
                curve_pieces(piece, s, e, out);
                for piece in &mut out[first..] {
                    reparametrize(piece, own, [t[0], t[1]]);
                }
            }
        }
        Curve::Arc(c) => arc_pieces(c, from, to, out),
    }
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
/// Where an end of the piece is no end of the segment its new parameter is rounded: by at most four roundings of the
/// larger end of `to`. The local parameter of a given poly-curve parameter is then off by at most that over the
/// piece's length, and the homogeneous point by that times its derivative, `degree` times the largest
/// difference of control points: it goes into their radii.
fn reparametrize<T: Real, const H: usize>(
    piece: &mut BezierCurve<T, H>,
    own: Interval,
    to: [f64; 2],
) {
    let mut exact = true;
    let mut map = |x: f64| {
        if x == own.start {
            to[0]
        } else if x == own.end {
            to[1]
        } else {
            exact = false;
            let s = (x - own.start) / (own.end - own.start);
            (to[0] + s * (to[1] - to[0])).clamp(to[0], to[1])
        }
    };
    let (start, end) = (map(piece.map.start), map(piece.map.end));
    piece.map = ParamMap { start, end };
    if exact {
        return;
    }
    // Its angle is no longer known to the last digit.
    piece.arc = None;
    let off = 4.0 * f64::EPSILON * to[0].abs().max(to[1].abs()) / (end - start);
    let degree = (piece.points.len() - 1) as f64;
    for c in 0..H {
        let steps = piece.points.windows(2);
        let largest = steps
            .map(|p| (p[1][c] - p[0][c]).magnitude())
            .fold(0.0, f64::max);
        // Twice: the derivative is that of the piece, a little way past its ends too.
        let slack = 2.0 * degree * largest * off;
        for p in &mut piece.points {
            p[c].rad = (p[c].rad + slack) * (1.0 + 4.0 * f64::EPSILON);
        }
    }
}
