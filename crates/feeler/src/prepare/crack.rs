//! The width of the cracks between faces.

use crate::brep::{Brep, TrimCurve};
use nalgebra::Point3;

/// How many points of one image of an edge are looked at, besides its ends: at odd multiples of 1 / (2 PROBES), since
/// two fits of one curve often meet at halves, quarters and eighths.
const PROBES: usize = 16;
/// How many points of the other image are candidates for the nearest.
const SAMPLES: usize = 32;
/// The nearest of them is improved by this many rounds of narrowing.
const ROUNDS: usize = 26;

/// Distances below this part of the coordinates are rounding.
const NOISE: f64 = 8.0 * f64::EPSILON;

/// For each edge, the largest distance found between the images of two trims that use it, in model
/// units. Sampled, an estimate from below; those who use it multiply.
pub(crate) fn crack_widths(brep: &Brep) -> Vec<f64> {
    let width = |trims: &[usize]| {
        let mut widest: f64 = 0.0;
        for (i, &a) in trims.iter().enumerate() {
            for &b in &trims[i + 1..] {
                // Either may reach beyond the other, or double back at its end, which only the ends show.
                let pair = distance(brep, a, b).max(distance(brep, b, a));
                widest = widest.max(pair).max(ends_apart(brep, a, b));
            }
        }
        widest
    };
    let edges = brep.parts().edges.iter();
    edges.map(|e| width(&e.trims)).collect()
}

/// The point of a trim's image in space at fraction `s` of its span.
fn image(brep: &Brep, trim: &TrimCurve, s: f64) -> Point3<f64> {
    let uv = brep.parts().curves2[trim.curve].point(trim.span.lerp(s));
    let face = brep.parts().loops[trim.trim_loop].face;
    brep.surface(face).point(uv.x, uv.y)
}

/// How far the ends of two images are apart, in the better of the two directions.
fn ends_apart(brep: &Brep, a: usize, b: usize) -> f64 {
    let trims = &brep.parts().trims;
    let ends = |t: usize| [0.0, 1.0].map(|s| image(brep, &trims[t], s));
    let ([a0, a1], [b0, b1]) = (ends(a), ends(b));
    let along = (a0 - b0).norm().max((a1 - b1).norm());
    let against = (a0 - b1).norm().max((a1 - b0).norm());
    along.min(against)
}

fn distance(brep: &Brep, a: usize, b: usize) -> f64 {
    let (a, b) = (&brep.parts().trims[a], &brep.parts().trims[b]);
    let fraction = |k: usize, of: usize| k as f64 / of as f64;
    let candidates: Vec<_> = (0..=SAMPLES)
        .map(|k| image(brep, b, fraction(k, SAMPLES)))
        .collect();
    let mut widest: f64 = 0.0;
    let largest = candidates
        .iter()
        .map(|c| c.coords.amax())
        .fold(0.0, f64::max);
    let probes = (0..PROBES).map(|k| fraction(2 * k + 1, 2 * PROBES));
    for at in [0.0, 1.0].into_iter().chain(probes) {
        let p = image(brep, a, at);
        let mut best = (f64::INFINITY, 0.0);
        for (i, c) in candidates.iter().enumerate() {
            let d = (c - p).norm();
            if d < best.0 {
                best = (d, fraction(i, SAMPLES));
            }
        }
        let mut step = 0.5 / SAMPLES as f64;
        for _ in 0..ROUNDS {
            if best.0 <= NOISE * largest {
                break;
            }
            for s in [best.1 - step, best.1 + step] {
                let s = s.clamp(0.0, 1.0);
                let d = (image(brep, b, s) - p).norm();
                if d < best.0 {
                    best = (d, s);
                }
            }
            step *= 0.5;
        }
        if best.0.is_finite() {
            widest = widest.max(best.0);
        }
    }
    widest
}
