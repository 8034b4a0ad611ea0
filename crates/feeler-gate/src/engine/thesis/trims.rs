//! Algorithms 3 and 4: derivative roots of trim curves, and the parity of a ray.

use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, NurbsCurve2};
use nalgebra::Point2;
use std::sync::Arc;

/// Steps before Newton's method is given up.
const STEPS: usize = 50;
/// A step below this part of the interval ends the search.
const SMALL: f64 = 1e-13;
/// A derivative root nearer to an end of its interval than this part of it is that end.
const AT_END: f64 = 1e-9;
/// The same of a crossing with a ray.
const AT_JOINT: f64 = 1e-12;

/// A part of a trim curve on which u and v are taken to be monotone.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Shared: a curve may have as many pieces as segments.
    pub(super) curve: Arc<Curve2>,
    pub(super) from: f64,
    pub(super) to: f64,
}

/// Newton's method for a root in an interval, from its middle. `None` where it leaves the interval or does not settle.
fn newton(from: f64, to: f64, f: impl Fn(f64) -> (f64, f64)) -> Option<f64> {
    let mut t = 0.5 * (from + to);
    for _ in 0..STEPS {
        let (value, slope) = f(t);
        if value == 0.0 {
            return Some(t);
        }
        let step = value / slope;
        t -= step;
        // Also where it is NaN.
        if !(from <= t && t <= to) {
            return None;
        }
        if step.abs() <= SMALL * (to - from) {
            return Some(t);
        }
    }
    None
}

/// Algorithm 3 for one coordinate: roots of its derivative, in no order. An interval in which Newton finds none from
/// its middle has none; after `order` roots of the curve it stops.
fn derivative_roots(spans: &[Span<'_>], axis: usize) -> Vec<f64> {
    let mut roots = Vec::new();
    let mut intervals: Vec<_> = spans.iter().map(|s| (s, s.from, s.to)).collect();
    intervals.reverse();
    while let Some((span, from, to)) = intervals.pop() {
        if roots.len() >= span.order {
            break;
        }
        let derivative = |t: f64| {
            let d = span.curve.derivatives(t, 2);
            (d[1][axis], d[2][axis])
        };
        if let Some(t) = newton(from, to, derivative) {
            let margin = AT_END * (to - from);
            if t - from > margin && to - t > margin {
                roots.push(t);
                intervals.push((span, t, to));
                intervals.push((span, from, t));
            }
        }
    }
    roots
}

/// A span of a trim curve in NURBS form.
struct Span<'a> {
    curve: &'a Curve2,
    from: f64,
    to: f64,
    /// Of the curve: its degree and 1.
    order: usize,
}

/// The curve in NURBS form, run over the same parameters; an arc as such, cut at its quarters.
fn spans(curve: &Curve2, used: Interval) -> Vec<Span<'_>> {
    let mut all = Vec::new();
    let mut add = |from: f64, to: f64, order: usize| {
        let (from, to) = (from.max(used.start), to.min(used.end));
        if from < to {
            all.push(Span {
                curve,
                from,
                to,
                order,
            });
        }
    };
    match curve {
        Curve::Nurbs(c) => {
            let nurbs: &NurbsCurve2 = c;
            for (_, from, to) in nurbs.knots().spans() {
                add(from, to, nurbs.degree() + 1);
            }
        }
        Curve::Arc(arc) => {
            /// Order of a quarter in NURBS form.
            const ORDER: usize = 3;
            let quarters = (arc.angle.length() / std::f64::consts::FRAC_PI_2)
                .ceil()
                .max(1.0);
            let at = |i: usize| arc.domain.lerp(i as f64 / quarters);
            for i in 0..quarters as usize {
                add(at(i), at(i + 1), ORDER);
            }
        }
        Curve::Line(_) | Curve::Polyline(_) => {
            for w in curve.breaks().windows(2) {
                add(w[0], w[1], 2);
            }
        }
        Curve::Poly(poly) => {
            let order = |c: &Curve2| match c {
                Curve::Nurbs(c) => c.degree() + 1,
                Curve::Arc(_) => 3,
                _ => 2,
            };
            let most = poly.segments().iter().map(order).max().unwrap_or(2);
            for w in curve.breaks().windows(2) {
                add(w[0], w[1], most);
            }
        }
    }
    all
}

/// Algorithm 3: the used part of a trim curve, cut at its derivative roots in u and in v.
pub(super) fn pieces(curve: &Arc<Curve2>, span: Interval) -> Vec<Piece> {
    let spans = spans(curve, span);
    let mut cuts: Vec<f64> = spans.iter().flat_map(|s| [s.from, s.to]).collect();
    for axis in 0..2 {
        cuts.extend(derivative_roots(&spans, axis));
    }
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let piece = |w: &[f64]| Piece {
        curve: Arc::clone(curve),
        from: w[0],
        to: w[1],
    };
    cuts.windows(2).map(piece).collect()
}

/// Where a piece is at height v: Newton from its middle, kept within the piece. `None` where it does not settle, or settles
/// at an end without being at that height.
fn at_height(piece: &Piece, v: f64) -> Option<f64> {
    let length = piece.to - piece.from;
    let mut t = 0.5 * (piece.from + piece.to);
    for _ in 0..STEPS {
        let d = piece.curve.derivatives(t, 1);
        let (height, slope) = (d[0].y - v, d[1].y);
        if height == 0.0 {
            return Some(t);
        }
        let next = (t - height / slope).clamp(piece.from, piece.to);
        if !next.is_finite() {
            return None;
        }
        let step = next - t;
        t = next;
        if step.abs() <= SMALL * length {
            // As far off as the parameter is known, along the curve.
            let there = height.abs() <= AT_JOINT * length * slope.abs().max(f64::MIN_POSITIVE);
            return there.then_some(t);
        }
    }
    None
}

/// Algorithm 4: whether a ray along +u from the point crosses the trims an odd number of times.
pub(super) fn inside(pieces: &[Piece], q: Point2<f64>) -> bool {
    let crosses = |piece: &&Piece| {
        // The start of a piece belongs to it and its end does not, so that a joint counts once.
        let margin = AT_JOINT * (piece.to - piece.from);
        at_height(piece, q.y).is_some_and(|t| piece.to - t > margin && piece.curve.point(t).x > q.x)
    };
    pieces.iter().filter(crosses).count() % 2 == 1
}
