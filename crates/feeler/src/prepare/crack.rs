//! Proven widths of the cracks between faces.
//!
//! The width of an edge is the largest Frechet distance between two images of its trims (each run through in whichever
//! direction gives less). What is given here is never less: see `matching` for the proof.

use super::boundary::join_source;
use super::closed;
use super::closed::{CurveShape, V3};
use super::image::{Image, end, image, image_of_one};
use super::matching::frechet;
use super::near::distance;
use super::{Box3, FaceGeometry, PreparedBrep};
use crate::brep::TrimLoop;
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
    let (a, b) = (brep.closed_image(s)?, brep.closed_image(t)?);
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

/// A box around a point.
fn region(p: &closed::V3, slack: f64) -> Box3 {
    p.map(|x| {
        [
            (x.lower() - slack).next_down(),
            (x.upper() + slack).next_up(),
        ]
    })
}

/// Circles of at most this part of the model's size are boxed whole: the arcs that poles are, but for rounding.
const SMALL_CIRCLE: f64 = 1.0 / (1u64 << 40) as f64;

/// A box around a segment or the circle of a small arc; `size` is the model's.
fn curve_region(shape: &CurveShape, slack: f64, size: f64) -> Option<Box3> {
    match shape {
        CurveShape::Segment(s) => {
            let [a, b] = [&s.a, &s.b].map(|p| region(p, slack));
            Some(std::array::from_fn(|c| {
                [a[c][0].min(b[c][0]), a[c][1].max(b[c][1])]
            }))
        }
        CurveShape::Arc(a) if a.radius.upper() <= SMALL_CIRCLE * size => {
            // The axes are of length one, up to rounding.
            Some(region(&a.center, (slack + a.radius.upper()) * UP))
        }
        CurveShape::Arc(_) => None,
    }
}

/// A box around the image of the segment that joins a trim, by its place in its loop, to the next, if there is one: `Some(None)` where none is known.
fn join_region<'a, T: Real + 'a>(
    brep: &PreparedBrep,
    geometry: impl FnOnce() -> &'a FaceGeometry<T>,
    of: &TrimLoop,
    at: usize,
) -> Option<Option<Box3>> {
    if let Some(form) = brep.closed(of.face)
        && let Ok(join) = form.join_of(of.trims[at])
    {
        let join = join?;
        if let Some(region) = curve_region(join.shape, join.slack, brep.size()) {
            return Some(Some(region));
        }
    }
    let source = join_source(brep.brep(), &of.trims, at)?;
    Some(image_of_one(geometry(), source).map(|image| image.bounds()))
}

/// A box around the image of a trim.
fn trim_region<'a, T: Real + 'a>(
    brep: &PreparedBrep,
    geometry: impl FnOnce() -> &'a FaceGeometry<T>,
    trim: usize,
) -> Option<Box3> {
    let closed = brep.closed_image(trim);
    let region = closed.and_then(|i| curve_region(i.shape, i.slack, brep.size()));
    region.or_else(|| Some(image(geometry(), trim)?.bounds()))
}

/// Boxes around the ends of the image of a trim.
pub(super) fn end_regions<'a, T: Real + 'a>(
    brep: &PreparedBrep,
    geometry: impl FnOnce() -> &'a FaceGeometry<T>,
    trim: usize,
) -> Option<[Box3; 2]> {
    if let Some(image) = brep.closed_image(trim) {
        let ends = match image.shape {
            CurveShape::Segment(s) => [&s.a, &s.b],
            CurveShape::Arc(a) => [&a.ends[0], &a.ends[1]],
        };
        let [first, last] = ends.map(|p| region(p, image.slack));
        return Some(if image.against {
            [last, first]
        } else {
            [first, last]
        });
    }
    let geometry = geometry();
    Some([end(geometry, trim, false)?, end(geometry, trim, true)?])
}

/// Boxes that hold the ends of all images that meet at a vertex, the images of the segments that join trims there and of the
/// singular trims there: what the cracks of edges leave open around vertices. Vertices that an edge or a join
/// connects, whatever the file calls them, are one. `None` where an image is not known.
pub(super) fn vertex_regions<'a, T: Real + 'a>(
    brep: &PreparedBrep,
    geometry: impl Fn(usize) -> &'a FaceGeometry<T>,
) -> Option<Vec<Box3>> {
    let parts = brep.brep().parts();
    let mut class: Vec<usize> = (0..parts.vertices.len()).collect();
    fn root(class: &mut [usize], mut v: usize) -> usize {
        while class[v] != v {
            class[v] = class[class[v]];
            v = class[v];
        }
        v
    }
    let mut found: Vec<(usize, Box3)> = Vec::new();
    for l in &parts.loops {
        // Made only where a closed form does not tell.
        let geometry = || geometry(l.face);
        for (i, &t) in l.trims.iter().enumerate() {
            let trim = &parts.trims[t];
            let next = &parts.trims[l.trims[(i + 1) % l.trims.len()]];
            let (a, b) = (
                root(&mut class, trim.vertices[1]),
                root(&mut class, next.vertices[0]),
            );
            class[a] = b;
            if let Some(region) = join_region(brep, geometry, l, i) {
                found.push((b, region?));
            }
            if trim.edge.is_none() {
                let (a, b) = (
                    root(&mut class, trim.vertices[0]),
                    root(&mut class, trim.vertices[1]),
                );
                class[a] = b;
                found.push((b, trim_region(brep, geometry, t)?));
                continue;
            }
            for (k, region) in end_regions(brep, geometry, t)?.into_iter().enumerate() {
                found.push((trim.vertices[k], region));
            }
        }
    }
    for e in &parts.edges {
        for pair in e.trims.windows(2) {
            let [s, t] = [&parts.trims[pair[0]], &parts.trims[pair[1]]];
            let turned = usize::from(s.edge_reversed != t.edge_reversed);
            for end in 0..2 {
                let a = root(&mut class, s.vertices[end]);
                let b = root(&mut class, t.vertices[end ^ turned]);
                class[a] = b;
            }
        }
    }
    let mut out: Vec<Option<Box3>> = vec![None; class.len()];
    for (v, b) in found {
        let all = out[root(&mut class, v)].get_or_insert(b);
        for c in 0..3 {
            all[c] = [all[c][0].min(b[c][0]), all[c][1].max(b[c][1])];
        }
    }
    Some(out.into_iter().flatten().collect())
}
