//! How far two boundary curves in closed form are from each other.

use super::curve::{ArcShape, CurveShape};
use super::form::{V3, scale, sub};
use crate::numeric::{Ball, Dd};
use nalgebra::Vector3;

/// A bound that is off by a few dozen roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// A bound above the Frechet distance of two curves of one kind, in the better direction; `None` for a segment and an arc.
///
/// Both are run through at constant speed. The difference of two segments is linear: longest at an end. That of two arcs at
/// the part `s` is, with the angle `a = s T`, `|T' s - a| <= |T' - T|`, no longer than
/// `|C - C'| + max |cos a P + sin a Q| + R' |T' - T|`, `P = R x - R' x'`, `Q = R y - R' y'`; the maximum is no more than
/// the largest singular value of the matrix of `P` and `Q`.
pub(crate) fn frechet(a: &CurveShape, b: &CurveShape) -> Option<f64> {
    let bound = match (a, b) {
        (CurveShape::Segment(a), CurveShape::Segment(b)) => {
            let with = length(&sub(&a.a, &b.a)).max(length(&sub(&a.b, &b.b)));
            let against = length(&sub(&a.a, &b.b)).max(length(&sub(&a.b, &b.a)));
            with.min(against)
        }
        (CurveShape::Arc(a), CurveShape::Arc(b)) => {
            let to_b = [scale(&b.x, b.radius), scale(&b.y, b.radius)];
            arcs(a, b, &to_b).min(arcs(a, b, &turned(b)))
        }
        _ => return None,
    };
    bound.is_finite().then_some(bound)
}

/// A bound above the length of a vector.
fn length(v: &V3) -> f64 {
    let squares = v.iter().map(|x| x.magnitude() * x.magnitude());
    squares.sum::<f64>().sqrt() * UP
}

/// `R x`, `R y` of the arc that runs from its end: at the angle `b` back from there, `cos (T - b) x + sin (T - b) y`
/// is `cos b (cos T x + sin T y) + sin b (sin T x - cos T y)`.
fn turned(arc: &ArcShape) -> [V3; 2] {
    let [cos, sin] = arc.end;
    let combined = |p: Ball<Dd>, q: Ball<Dd>| -> V3 {
        std::array::from_fn(|c| (p * arc.x[c] + q * arc.y[c]) * arc.radius)
    };
    [combined(cos, sin), combined(sin, -cos)]
}

fn arcs(a: &ArcShape, b: &ArcShape, axes: &[V3; 2]) -> f64 {
    let mut radius = 0.0;
    let mut rounded = |v: V3| {
        radius += v
            .iter()
            .map(|x| x.rad + f64::EPSILON * x.magnitude())
            .sum::<f64>();
        Vector3::from_fn(|c, _| v[c].mid.hi)
    };
    let p = rounded(sub(&scale(&a.x, a.radius), &axes[0]));
    let q = rounded(sub(&scale(&a.y, a.radius), &axes[1]));
    // The largest eigenvalue of the Gram matrix. It is at least half the trace, of which each term loses a few roundings.
    let (pp, qq, pq) = (p.dot(&p), q.dot(&q), p.dot(&q));
    let half = 0.5 * (pp - qq);
    let largest = 0.5 * (pp + qq) + (half * half + pq * pq).sqrt();
    let shift = length(&sub(&a.center, &b.center));
    let speed = b.radius.magnitude() * (a.turn - b.turn).magnitude();
    (largest.sqrt() * UP + radius + shift + speed) * UP
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::closed::form::exact;

    fn segment(a: [f64; 3], b: [f64; 3]) -> CurveShape {
        CurveShape::segment(exact(&a), exact(&b))
    }

    fn arc(center: [f64; 3], x: [f64; 3], y: [f64; 3], radius: f64, turn: f64) -> CurveShape {
        let made = CurveShape::arc(
            exact(&center),
            exact(&x),
            exact(&y),
            Ball::exact(radius),
            Ball::exact(turn),
        );
        made.unwrap()
    }

    const O: [f64; 3] = [0.0; 3];
    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const BACK: [f64; 3] = [0.0, -1.0, 0.0];

    /// Above the true distance, by no more than so many times it and the rounding of f64.
    fn check(a: &CurveShape, b: &CurveShape, is: f64, factor: f64) {
        for (a, b) in [(a, b), (b, a)] {
            let found = frechet(a, b).unwrap();
            // UP is taken twice at most.
            let most = factor * is * UP * UP * UP + 16.0 * f64::EPSILON;
            assert!(is <= found && found <= most, "{found:e}, is {is:e}");
        }
    }

    #[test]
    fn copies_are_as_good_as_nothing_apart() {
        check(&segment(O, X), &segment(O, X), 0.0, 1.0);
        check(&arc(O, X, Y, 2.0, 3.0), &arc(O, X, Y, 2.0, 3.0), 0.0, 1.0);
    }

    #[test]
    fn direction_does_not_matter() {
        check(&segment(O, X), &segment(X, O), 0.0, 1.0);
        // From -Y over X to Y, and back.
        let half = std::f64::consts::PI;
        check(
            &arc(O, BACK, X, 1.0, half),
            &arc(O, Y, X, 1.0, half),
            0.0,
            1.0,
        );
        // A whole turn.
        let whole = std::f64::consts::TAU;
        check(
            &arc(O, X, Y, 1.0, whole),
            &arc(O, X, BACK, 1.0, whole),
            0.0,
            1.0,
        );
    }

    #[test]
    fn known_distances() {
        // One end is off by 1/8, the other by 1/4.
        let b = segment([0.0, 0.125, 0.0], [1.0, 0.0, 0.25]);
        check(&segment(O, X), &b, 0.25, 1.0);
        // Concentric; side by side.
        let a = arc(O, X, Y, 1.0, 3.0);
        check(&a, &arc(O, X, Y, 1.125, 3.0), 0.125, 1.0);
        check(&a, &arc([0.0, 0.0, 0.5], X, Y, 1.0, 3.0), 0.5, 1.0);
        // One is longer by 1/16: the ends are a chord of that angle apart.
        let chord = 2.0 * (1.0f64 / 32.0).sin();
        check(&a, &arc(O, X, Y, 1.0, 3.0625), chord, 1.001);
    }

    #[test]
    fn a_segment_and_an_arc_are_left_to_others() {
        assert!(frechet(&segment(O, X), &arc(O, X, Y, 1.0, 1.0)).is_none());
    }
}
