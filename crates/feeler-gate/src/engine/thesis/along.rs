//! Algorithm 5: along the trims.

use super::Target;
use super::trims::Piece;
use feeler::nurbs::Surface;
use nalgebra::Point2;

/// Steps before Newton's method is given up.
const STEPS: usize = 50;
/// A step below this part of the piece ends the search: finite differences see no less.
const SMALL: f64 = 1e-10;
/// Finite differences reach this part of the piece to each side: about the fourth root of f64's unit, where the
/// rounding of a second difference equals what it leaves out.
const REACH: f64 = 1e-4;

/// The point of the trims nearest to the target, by Newton from the middle of each piece; ends of pieces
/// count as well.
pub(super) fn nearest(surface: &Surface, pieces: &[Piece], target: &Target) -> Option<Point2<f64>> {
    let mut best: Option<(f64, Point2<f64>)> = None;
    for piece in pieces {
        let value = |t: f64| {
            let uv = piece.curve.point(t);
            target.value(&surface.point(uv.x, uv.y).coords)
        };
        let found = newton(piece.from, piece.to, value);
        for t in found.into_iter().chain([piece.from, piece.to]) {
            let candidate = (value(t), piece.curve.point(t));
            if best.is_none_or(|b| candidate.0 < b.0) {
                best = Some(candidate);
            }
        }
    }
    best.map(|b| b.1)
}

/// A stationary point within a piece, from its middle.
fn newton(from: f64, to: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    let h = REACH * (to - from);
    let mut t = 0.5 * (from + to);
    for _ in 0..STEPS {
        let (before, here, after) = (f(t - h), f(t), f(t + h));
        let slope = (after - before) / (2.0 * h);
        let bend = (after - 2.0 * here + before) / (h * h);
        let step = slope / bend;
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
