//! Where surfaces and curves are cut.

use super::Rule;
use feeler::nurbs::{Curve, Surface};
use nalgebra::{Point2, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// No normal or tangent turns further than this from one point to the next, in degrees, whatever is asked: two
/// halves of a circle have no area between them. Patches of 120 degrees, as converters make them, stay whole.
pub(super) const WIDEST: f64 = 150.0;

/// Samples a piece, where turning is summed up; fewer where there are many pieces.
const SAMPLES: usize = 32;
const FEW_SAMPLES: usize = 8;
const MANY_PIECES: usize = 8;
/// Where along the other parameter a piece is sampled.
const ACROSS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Samples keep off the ends of a piece by this part of it: at a knot the derivatives belong to one side alone, and at a
/// pole there is no normal.
const MARGIN: f64 = 1e-6;
/// The most cuts of one piece.
const MOST: f64 = 1e6;
/// A sum that is above a whole number by this part of it is that number: what is asked is often met exactly, and
/// keeping off the ends costs [`MARGIN`] times the samples.
const SLACK: f64 = 1e-4;

/// The angle of one step under a rule, in radians.
pub(super) fn step(rule: &Rule) -> f64 {
    rule.degrees.min(WIDEST) * PI / 180.0
}

/// A parameter in `[a, b]`, at `k` of `n`, off the ends.
fn inner(a: f64, b: f64, s: f64) -> f64 {
    a + (b - a) * s.clamp(MARGIN, 1.0 - MARGIN)
}

/// Ends of pieces with what lies between cut so that `cost` sums up to at most 1 between two cuts. `cost(from, to)`
/// is that of a small step.
pub(super) fn cut(breaks: &[f64], mut cost: impl FnMut(f64, f64) -> f64) -> Vec<f64> {
    let samples = match breaks.len() {
        0..=MANY_PIECES => SAMPLES,
        _ => FEW_SAMPLES,
    };
    let mut cuts = Vec::with_capacity(breaks.len());
    cuts.extend(breaks.first());
    for piece in breaks.windows(2) {
        let (a, b) = (piece[0], piece[1]);
        let at = |k: usize| inner(a, b, k as f64 / samples as f64);
        let mut sums = vec![0.0];
        for k in 0..samples {
            // As if the sample ran to the end of the piece.
            let whole = (b - a) / samples as f64 / (at(k + 1) - at(k));
            let more = cost(at(k), at(k + 1)) * whole;
            let more = if more.is_finite() { more } else { 0.0 };
            sums.push(sums[k] + more);
        }
        let total = sums[samples];
        let pieces = (total * (1.0 - SLACK)).ceil().clamp(1.0, MOST) as usize;
        for i in 1..pieces {
            let want = total * i as f64 / pieces as f64;
            let k = sums.partition_point(|s| *s < want).clamp(1, samples);
            let inside = (want - sums[k - 1]) / (sums[k] - sums[k - 1]);
            cuts.push(a + (b - a) * ((k - 1) as f64 + inside) / samples as f64);
        }
        cuts.push(b);
    }
    cuts
}

/// Where pieces of a curve end: knots, corners and joints, and the quarters of circles.
pub(super) fn curve_breaks<const D: usize, const H: usize>(curve: &Curve<D, H>) -> Vec<f64> {
    let mut all = curve.breaks();
    let mut quarters = |arc: &Curve<D, H>, from: f64, to: f64| {
        if let Curve::Arc(arc) = arc {
            let n = (arc.angle.length() / FRAC_PI_2 * (1.0 - SLACK)).ceil();
            let inner = (1..n as usize).map(|i| from + (to - from) * i as f64 / n);
            all.extend(inner);
        }
    };
    match curve {
        Curve::Poly(poly) => {
            for (segment, w) in poly.segments().iter().zip(poly.params().windows(2)) {
                quarters(segment, w[0], w[1]);
            }
        }
        _ => quarters(curve, curve.domain().start, curve.domain().end),
    }
    all.sort_by(f64::total_cmp);
    all
}

/// Where pieces of a surface end, along u and along v: as its NURBS form would have knots.
pub(super) fn surface_breaks(surface: &Surface) -> [Vec<f64>; 2] {
    match surface {
        Surface::Plane(s) => s.domain.map(|d| vec![d.start, d.end]),
        Surface::Revolution(s) => {
            let n = (s.angle.length() / FRAC_PI_2 * (1.0 - SLACK))
                .ceil()
                .max(1.0);
            let turn = (0..=n as usize).map(|i| s.angle_domain.lerp(i as f64 / n));
            let both = [turn.collect(), curve_breaks(&s.profile)];
            if s.transposed {
                let [turn, profile] = both;
                [profile, turn]
            } else {
                both
            }
        }
        Surface::Sum(s) => [curve_breaks(&s.first), curve_breaks(&s.second)],
        Surface::Nurbs(s) => {
            let ends = |k: &feeler::nurbs::KnotVector| {
                let mut all = vec![k.domain().start];
                all.extend(k.spans().map(|(_, _, end)| end));
                all
            };
            [ends(s.knots_u()), ends(s.knots_v())]
        }
    }
}

/// The unit normal of a surface along `S_u x S_v`, not its face's; NaN at a pole.
pub(super) fn normal(surface: &Surface, uv: Point2<f64>) -> Vector3<f64> {
    let d = surface.derivatives(uv.x, uv.y, 1);
    let n = d.get(1, 0).cross(&d.get(0, 1));
    n / n.norm()
}

/// The angle between two unit vectors.
pub(super) fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// How much of a chord's allowance each of three terms may use: that of u, of v, and the mixed one, which counts
/// twice. Cells beside a trim may be joined to a neighbour: twice as long, four times as far off.
const SHARE: f64 = 1.0 / 16.0;

/// The grid of a surface.
pub(super) fn grid(surface: &Surface, rule: &Rule) -> [Vec<f64>; 2] {
    let breaks = surface_breaks(surface);
    let domain = surface.domain();
    let step = step(rule);
    let mut across: [Vec<f64>; 2] = Default::default();
    for (to, breaks) in across.iter_mut().zip(&breaks) {
        for piece in breaks.windows(2) {
            to.extend(ACROSS.map(|s| inner(piece[0], piece[1], s)));
        }
    }
    [0, 1].map(|axis| {
        let place = |s: f64, other: f64| match axis {
            0 => Point2::new(s, other),
            _ => Point2::new(other, s),
        };
        let lengths = domain.map(|d| d.length());
        cut(&breaks[axis], |from, to| {
            let mut most = 0.0f64;
            for &other in &across[1 - axis] {
                let (a, b) = (place(from, other), place(to, other));
                let turn = angle(&normal(surface, a), &normal(surface, b));
                if turn.is_finite() {
                    most = most.max(turn / step);
                }
                if rule.chord.is_finite() {
                    // A chord over h leaves a curve by |second derivative| h^2 / 8.
                    let d = surface.derivatives(a.x, a.y, 2);
                    let [own, mixed] = match axis {
                        0 => [d.get(2, 0), d.get(1, 1)],
                        _ => [d.get(0, 2), d.get(1, 1)],
                    };
                    let allowed = 8.0 * SHARE * rule.chord;
                    let straight = (own.norm() / allowed).sqrt() * (to - from);
                    let twist = (mixed.norm() * lengths[0] * lengths[1] / allowed).sqrt()
                        * (to - from)
                        / lengths[axis];
                    most = most.max(straight).max(twist);
                }
            }
            most
        })
    })
}
