//! Hits of a line with faces that are answered whole: by formula, or exactly as a polygon.

use super::closed::boxes_side;
use super::forms::Stabber;
use super::upon::{border_hit, ruling_hits};
use super::zeros::{Digits, HitAt, RawHit};
use crate::numeric::{Ball, Dd};
use crate::prepare::closed::{Boxes, ClosedHit, ClosedLine, exact};
use crate::prepare::{Polygon, PreparedBrep};
use crate::trim::{BoxSide, Side};
use nalgebra::{Point2, Vector3};
use std::cmp::Ordering;

/// A range of f64 that holds a number: the ends are off by half a unit of rounding of themselves, less than is added.
fn outward(x: Ball<f64>) -> [f64; 2] {
    let off = (x.rad + f64::EPSILON * x.mid.abs()) * (1.0 + 8.0 * f64::EPSILON);
    [x.mid - off, x.mid + off]
}

/// A parameter in f64 is left to double-double where it is off by more than this part of the face's reach.
const SHARP: f64 = 1.0 / (1u64 << 44) as f64;

/// The hits with a face in closed form, where formulas tell them.
///
/// Of a plane, f64 tells in most cases where the hit is, and whether it is in the region; what is then known of it only is the parameter, to the
/// digits that are wanted.
pub(super) fn closed_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    digits: Digits,
    hits: &mut Vec<RawHit>,
) -> Option<()> {
    let form = brep.closed(face)?;
    let b = brep.face_box(face)?;
    let rough = form
        .surface
        .rough_hit(&stab.origin.into(), &stab.direction.into());
    let side = rough
        .as_ref()
        .map(|hit| boxes_side(brep, face, &Boxes::one(hit.uv.map(outward))));
    if side == Some(BoxSide::Outside) {
        return Some(());
    }
    // The middle of the face's box as seen along the line, and how far its corners are from there.
    let (o, d) = (stab.origin, stab.direction);
    let center = Vector3::from_fn(|c, _| 0.5 * (b[c][0] + b[c][1])) - o.coords;
    let middle = center.dot(&d) / d.norm_squared();
    let half = Vector3::from_fn(|c, _| 0.5 * (b[c][1] - b[c][0])).norm();
    let reach = half / d.norm();
    // `middle` and `reach` are off by a few roundings of what they are made of.
    let reach =
        reach * (1.0 + REACH_SLACK) + REACH_SLACK * middle.abs().max(center.norm() / d.norm());
    if !(reach.is_finite() && middle.is_finite() && reach > 0.0) {
        return None;
    }
    let line = ClosedLine {
        origin: exact(o.coords.as_slice()),
        direction: exact(d.as_slice()),
        middle,
        reach,
    };
    if let (Some(hit), Some(BoxSide::Inside)) = (&rough, side) {
        let known = match digits {
            Digits::Double if hit.t.rad <= SHARP * reach => Some(hit.t.to_dd()),
            _ => form.surface.plane_parameter(&line),
        };
        if let Some(t) = known.filter(|t| !stab.is_at_end(t)) {
            if !stab.is_beyond(&t) {
                let point = match digits {
                    Digits::Double => {
                        let t = Ball::<f64>::from_dd(t.mid, t.rad);
                        [0, 1, 2].map(|c| (Ball::exact(o[c]) + t * Ball::exact(d[c])).to_dd())
                    }
                    Digits::All => [0, 1, 2].map(|c| line.origin[c] + t * line.direction[c]),
                };
                let uv = form
                    .surface
                    .rough_parameters(&[0, 1, 2].map(|c| point[c].mid.hi))
                    .unwrap_or(hit.uv.map(|x| x.mid));
                hits.push(hit_at(face, HitAt::Closed { uv, point }, t, false));
            }
            return Some(());
        }
    }
    let mut out = Vec::new();
    let Some(found) = form.surface.hits(&line) else {
        // It may lie in the face.
        hits.extend(ruling_hits(brep, stab, face, &line)?);
        return Some(());
    };
    for mut hit in found {
        if stab.is_beyond(&hit.t) {
            continue;
        }
        // Exact arithmetic may tell.
        if stab.is_at_end(&hit.t) {
            let [start, end] = stab.range;
            let from_end = |e: f64| (hit.t.mid - Dd::from(e)).hi.abs();
            let at = if !end.is_finite() || from_end(start) < from_end(end) {
                start
            } else {
                end
            };
            match (form.surface.order(&line, &hit, at)?, at == start) {
                (Ordering::Equal, _) => hit.t = Ball::exact(at),
                (Ordering::Less, true) | (Ordering::Greater, false) => continue,
                // Within, by less than double-double tells.
                _ => return None,
            }
        }
        match boxes_side(brep, face, &hit.boxes) {
            BoxSide::Outside => {}
            BoxSide::Inside => out.push(closed_hit(face, &hit, hit.uv)),
            // The boxes are rounded outward to f64.
            BoxSide::Mixed => {
                let polygon = brep.polygon(face);
                if polygon.is_some_and(Polygon::is_plain) {
                    hits.extend(polygon_hits(brep, stab, face)?);
                    return Some(());
                }
                let places = form.surface.places(&hit.point)?;
                let known = |uv: &[f64; 2]| form.surface.is_exactly_at(&line, *uv);
                let beside = place_inside(brep, face, &places);
                if beside.is_none() {
                    // Next to the border, exactly.
                    if polygon.is_some()
                        && let Some(found) = polygon_hits(brep, stab, face)
                    {
                        hits.extend(found);
                        return Some(());
                    }
                    if let Some(found) = border_hit(brep, face, &line, &hit, &places) {
                        out.extend(found);
                        continue;
                    }
                }
                let place = match beside {
                    Some(place) => place,
                    // On the border: exactly, if its parameters are f64.
                    None => {
                        let mut tried = places.iter().map(|uv| uv.map(|x| x.mid.hi));
                        let [u, v] = tried.find(known)?;
                        match brep.region(face).side(Point2::new(u, v)).side? {
                            Side::Inside | Side::Boundary => Some([u, v]),
                            Side::Outside => None,
                        }
                    }
                };
                if let Some(uv) = place {
                    out.push(closed_hit(face, &hit, uv));
                }
            }
        }
    }
    hits.append(&mut out);
    Some(())
}

fn closed_hit(face: usize, hit: &ClosedHit, uv: [f64; 2]) -> RawHit {
    let point = hit.point;
    hit_at(face, HitAt::Closed { uv, point }, hit.t, hit.touches)
}

fn hit_at(face: usize, at: HitAt, t: Ball<Dd>, touches: bool) -> RawHit {
    RawHit {
        face,
        at,
        t,
        inside: true,
        at_joint: false,
        touches,
        exact: None,
    }
}

/// Of the copies of one point's parameters the one that is in the region, rounded, if one is; `None` where that is not known.
pub(super) fn place_inside(
    brep: &PreparedBrep,
    face: usize,
    places: &[[Ball<Dd>; 2]],
) -> Option<Option<[f64; 2]>> {
    let domain = brep.brep().surface(face).domain();
    let region = brep.region(face);
    let mut known = true;
    for uv in places {
        let beyond = |k: usize| {
            let [low, high] = [domain[k].start, domain[k].end].map(|end| uv[k] - Ball::exact(end));
            low.mid.hi < -2.0 * low.rad || high.mid.hi > 2.0 * high.rad
        };
        if (0..2).any(beyond) {
            continue;
        }
        match region.side_of_ball(*uv) {
            Some(Side::Inside) => return Some(Some(uv.map(|x| x.mid.hi))),
            Some(Side::Outside) => {}
            Some(Side::Boundary) | None => known = false,
        }
    }
    known.then_some(None)
}

/// The hits with a face that is a polygon, exactly.
pub(super) fn polygon_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
) -> Option<Vec<RawHit>> {
    let side = |uv| brep.region(face).side_of_ball(uv);
    let found = brep
        .polygon(face)?
        .meetings(&stab.origin, &stab.direction, stab.range, side)?;
    let hits = found.into_iter().map(|m| {
        let t = m.t.enclosed();
        let point = std::array::from_fn(|c| {
            Ball::exact(stab.origin[c]) + t * Ball::exact(stab.direction[c])
        });
        RawHit {
            face,
            at: HitAt::Closed { uv: m.uv, point },
            t,
            inside: true,
            at_joint: false,
            touches: m.touches,
            exact: Some(Box::new(m)),
        }
    });
    Some(hits.collect())
}

/// A part of lengths that covers some twenty roundings.
const REACH_SLACK: f64 = 1.0 / (1u64 << 44) as f64;
