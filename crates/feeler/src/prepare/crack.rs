//! Proven widths of the cracks between faces.
//!
//! The width of an edge is the largest Frechet distance between two images of its trims (each run through in whichever
//! direction gives less). What is given here is never less: see `matching` for the proof.

use super::PreparedBrep;
use super::closed::{self, V3};
use super::image::Image;
use super::matching::frechet;
use super::near::distance;
use crate::numeric::{Ball, Dd, Real};
use nalgebra::Vector3;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Ends this near to each other, relative to what is to be matched, do not tell the direction.
pub(super) const CLOSED: f64 = 1.0 / 64.0;
/// A width below this part of the model's size is as good as none: images in double-double would tell no better.
const NOTHING: f64 = 1.0 / (1u128 << 90) as f64;

/// A bound above the width of an edge; infinite where there is none. `image_of` gives a trim's.
pub(super) fn width<'a, T: Real + 'a>(
    brep: &PreparedBrep,
    edge: usize,
    image_of: impl Fn(usize) -> Option<&'a Image<T>>,
) -> f64 {
    let parts = brep.brep().parts();
    let trims = &parts.edges[edge].trims;
    if trims.len() < 2 {
        return 0.0;
    }
    let face = |t: usize| parts.loops[parts.trims[t].trim_loop].face;
    let mut widest: f64 = 0.0;
    for (i, &s) in trims.iter().enumerate() {
        for &t in &trims[i + 1..] {
            let by_formula = apart_in_closed_form(brep, s, t);
            // Arcs that are off by roundings alone are nearer than the formula's sum of bounds says, which digits beyond f64 are for.
            if let Some(found) = by_formula
                && (T::UNIT >= f64::UNIT || found <= NOTHING * brep.size())
            {
                widest = widest.max(found);
                continue;
            }
            let against = parts.trims[s].edge_reversed != parts.trims[t].edge_reversed;
            let found = match (image_of(s), image_of(t)) {
                (Some(a), Some(b)) => apart(a, b, against),
                _ => None,
            };
            let found = match (found, by_formula) {
                (Some(a), Some(b)) => a.min(b),
                (a, b) => (a.or(b)).unwrap_or_else(|| diameter(brep, [face(s), face(t)])),
            };
            widest = widest.max(found);
        }
    }
    widest
}

/// Points tried of each image, besides the ends of its stretches: few distances change faster.
const TRIED: usize = 48;
/// But no fewer than this of each stretch.
const LEAST_TRIED: usize = 1;

/// A bound below the width of an edge: each point of one image is matched with one of the other, which is no nearer than the
/// nearest, and ends are matched with ends.
pub(super) fn least_width(brep: &PreparedBrep, edge: usize) -> f64 {
    let trims = &brep.brep().parts().edges[edge].trims;
    let images: Vec<_> = trims.iter().map(|t| brep.fine_trim_image(*t)).collect();
    let most = brep.fine_crack_width(edge);
    let mut least: f64 = 0.0;
    for (i, from) in images.iter().enumerate() {
        for (k, to) in images.iter().enumerate() {
            let (Some(from), Some(to)) = (from, to) else {
                continue;
            };
            if i == k {
                continue;
            }
            if i < k {
                least = least.max(ends_apart(from, to).unwrap_or(0.0));
            }
            let count = (TRIED / from.stretches.len()).max(LEAST_TRIED);
            for stretch in &from.stretches {
                for tried in 0..=count + 1 {
                    let at = tried as f64 / (count + 1) as f64;
                    let p = stretch.point(Dd::from(at));
                    let slack = (stretch.slack + from.extra) * UP;
                    let [low, _] = distance(&p, to, least + slack, most + slack);
                    least = least.max((low - slack) / UP);
                }
            }
        }
    }
    least.min(most)
}

/// A bound below the distance of the ends that are matched, in the direction in which they are nearer: where closed curves begin
/// elsewhere, or one turns farther than the other, all points of both may be near the other.
fn ends_apart(a: &Image<Dd>, b: &Image<Dd>) -> Option<f64> {
    let ends = |image: &Image<Dd>| {
        let (first, last) = (image.stretches.first()?, image.stretches.last()?);
        let slack = (first.slack.max(last.slack) + image.extra) * UP;
        Some(([first.point(Dd::ZERO), last.point(Dd::ONE)], slack))
    };
    let (([p, q], a_slack), ([r, s], b_slack)) = (ends(a)?, ends(b)?);
    let apart = |x: &V3, y: &V3| {
        let off: [Ball<Dd>; 3] = std::array::from_fn(|c| x[c] - y[c]);
        let least = off.map(|x| x.lower().max(-x.upper()).max(0.0));
        (Vector3::from(least).norm() - a_slack - b_slack) / UP
    };
    let with = apart(&p, &r).max(apart(&q, &s));
    let against = apart(&p, &s).max(apart(&q, &r));
    Some(with.min(against).max(0.0))
}

/// A bound of the Frechet distance of the images of two trims that are segments, or arcs.
fn apart_in_closed_form(brep: &PreparedBrep, s: usize, t: usize) -> Option<f64> {
    let (a, b) = (brep.nearly_closed_image(s)?, brep.nearly_closed_image(t)?);
    Some((closed::frechet(a.shape, b.shape)? + a.slack + b.slack) * UP)
}

/// The diagonal of a box around both faces.
fn diameter(brep: &PreparedBrep, faces: [usize; 2]) -> f64 {
    let boxes = faces.map(|f| brep.face_box(f));
    let [Some(a), Some(b)] = boxes else {
        return f64::INFINITY;
    };
    let widths = Vector3::from_fn(|c, _| a[c][1].max(b[c][1]) - a[c][0].min(b[c][0]));
    widths.norm() * UP
}

/// A bound of the Frechet distance of two images in the better direction; `against` where the file says that the
/// second runs against the first.
pub(super) fn apart<T: Real>(a: &Image<T>, b: &Image<T>, against: bool) -> Option<f64> {
    let ends = |image: &Image<T>| {
        let point = |p: Option<&[T; 4]>, o: &[f64; 3]| {
            let p = p?;
            Some(Vector3::from_fn(|c, _| {
                (p[c] / p[3] + T::from_f64(o[c])).approximate()
            }))
        };
        let (first, last) = (image.stretches.first()?, image.stretches.last()?);
        Some([
            point(first.points.first(), &first.origin)?,
            point(last.points.last(), &last.origin)?,
        ])
    };
    let ([p, q], [r, s]) = (ends(a)?, ends(b)?);
    let with = (p - r).norm().max((q - s).norm());
    let turned = (p - s).norm().max((q - r).norm());
    let (near, far) = (with.min(turned), with.max(turned));
    let size = a.reach().min(b.reach());
    let told = near <= CLOSED * far && far > CLOSED * size;
    let against = if told { turned < with } else { against };
    let directed = |against: bool| {
        if against {
            frechet(a, &b.clone().reversed())
        } else {
            frechet(a, b)
        }
    };
    let first = directed(against);
    let wide = first.is_none_or(|w| w > CLOSED * size);
    if told || !wide {
        return first;
    }
    // The file may be wrong about it.
    match (first, directed(!against)) {
        (Some(x), Some(y)) => Some(x.min(y)),
        (x, y) => x.or(y),
    }
}
