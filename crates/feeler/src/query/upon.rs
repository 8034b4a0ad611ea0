//! Hits with a revolution that are exactly on its seam or on a trim along a parameter, and lines in its rulings.
//!
//! # What is proven
//! What is known exactly of a hit is said in the module `prepare/closed/upon.rs`. A place of which some parameters are known exactly and the others are within
//! enclosures is in a rectangle (the region, where that is one within the domain) by comparison. Else boxes that hold it are
//! looked at, one on either side of each exact parameter, within the domain: if one is inside, the place is in it or on its border, and so in the closed region; if all are
//! outside, it is.

use super::forms::Stabber;
use super::zeros::{HitAt, RawHit};
use crate::numeric::{Ball, Dd};
use crate::prepare::closed::{ClosedHit, ClosedLine, Exactly, Places};
use crate::prepare::{Meeting, PreparedBrep, When};
use crate::trim::{BoundaryPiece, BoxSide, PieceOrigin, TrimRegion};

/// How wide a box beside a place is, as a part of the domain: hardly more than there are f64 for.
const BESIDE: f64 = 1.0 / (1u64 << 48) as f64;

/// A place in uv, and its parameters that are exact.
struct Spot {
    uv: [Ball<Dd>; 2],
    exact: [Option<f64>; 2],
}

/// The segment of a straight piece of f64 along a parameter: which parameter does not change, and its number.
fn iso(piece: &BoundaryPiece) -> Option<(usize, f64)> {
    let [p, q] = piece.control_points.as_slice() else {
        return None;
    };
    if piece.radius != [0.0; 3] || p[2] != 1.0 || q[2] != 1.0 {
        return None;
    }
    (0..2).find(|k| p[*k] == q[*k]).map(|k| (k, p[k]))
}

impl Spot {
    fn new(uv: [Ball<Dd>; 2], known: &[Option<f64>; 2]) -> Self {
        let mut out = Self {
            uv,
            exact: [None; 2],
        };
        for k in 0..2 {
            let held = |c: &f64| uv[k].lower() <= *c && *c <= uv[k].upper();
            out.exact[k] = known[k].filter(held);
            if let Some(c) = out.exact[k] {
                out.uv[k] = Ball::exact(c);
            }
        }
        out
    }

    /// Whether a parameter is within a closed interval.
    fn within(&self, k: usize, [low, high]: [f64; 2]) -> Option<bool> {
        if let Some(c) = self.exact[k] {
            return Some(low <= c && c <= high);
        }
        let [above, below] = [low, high].map(|x| self.uv[k] - Ball::exact(x));
        if (-above).is_above(0.0) || below.is_above(0.0) {
            return Some(false);
        }
        (above.is_above(0.0) && (-below).is_above(0.0)).then_some(true)
    }

    /// Whether it is in the closed region.
    fn is_in(&self, region: &TrimRegion) -> Option<bool> {
        let domain = region.domain();
        let on_domain = [0, 1].map(|k| self.within(k, [domain[k].start, domain[k].end]));
        if on_domain.contains(&Some(false)) {
            return Some(false);
        }
        if on_domain != [Some(true); 2] {
            return None;
        }
        if let Some(r) = region.rectangle() {
            let within = [0, 1].map(|k| self.within(k, r[k]));
            return if within.contains(&Some(false)) {
                Some(false)
            } else {
                (within == [Some(true); 2]).then_some(true)
            };
        }
        let sides = |k: usize| -> [Option<[f64; 2]>; 2] {
            let (d, width) = (&domain[k], BESIDE * domain[k].length());
            match self.exact[k] {
                Some(c) => [
                    (c > d.start).then(|| [(c - width).max(d.start), c]),
                    (c < d.end).then(|| [c, (c + width).min(d.end)]),
                ],
                None => [Some([self.uv[k].lower(), self.uv[k].upper()]), None],
            }
        };
        let (mut outside, mut any) = (true, false);
        for u in sides(0).into_iter().flatten() {
            for v in sides(1).into_iter().flatten() {
                any = true;
                match region.classify_box(u, v) {
                    BoxSide::Inside => return Some(true),
                    BoxSide::Outside => {}
                    BoxSide::Mixed => outside = false,
                }
            }
        }
        (any && outside).then_some(false)
    }

    /// The trims along parameters that it is exactly on.
    fn trims(&self, region: &TrimRegion) -> Vec<usize> {
        let on = |piece: &BoundaryPiece| {
            let (k, at) = iso(piece)?;
            let PieceOrigin::Trim { trim, .. } = piece.origin else {
                return None;
            };
            let ends = [0, 1].map(|i: usize| piece.control_points[i][1 - k]);
            let range = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            (self.exact[k] == Some(at) && self.within(1 - k, range) == Some(true)).then_some(trim)
        };
        region.pieces().iter().filter_map(on).collect()
    }
}

/// The hit at the copies of a place, if one of them is in the region; `None` where that is not known.
pub(super) fn border_hit(
    brep: &PreparedBrep,
    face: usize,
    line: &ClosedLine,
    hit: &ClosedHit,
    places: &Places,
) -> Option<Option<RawHit>> {
    let (region, surface) = (brep.region(face), brep.brep().surface(face));
    let along = brep.closed(face)?.surface.profile_axis()?;
    let mut isos: Vec<f64> = region.pieces().iter().filter_map(iso).filter(|i| i.0 == along).map(|i| i.1).collect();
    isos.sort_by(f64::total_cmp);
    isos.dedup();
    let known: Exactly = brep.closed(face)?.surface.exactly(surface, line, hit, &isos)?;
    if known.at == [None; 2] {
        return None;
    }
    let mut told = true;
    for uv in places {
        let spot = Spot::new(*uv, &known.at);
        match spot.is_in(region) {
            Some(true) => {
                let uv = spot.uv.map(|x| x.mid.hi);
                let meeting = Meeting {
                    t: known.t.unwrap_or(When::from_ball(hit.t)),
                    end: None,
                    touches: hit.touches,
                    on: spot.trims(region),
                    end_on: Vec::new(),
                    uv,
                };
                return Some(Some(RawHit {
                    face,
                    at: HitAt::Closed {
                        uv,
                        point: hit.point,
                    },
                    t: hit.t,
                    inside: true,
                    at_joint: false,
                    touches: hit.touches,
                    exact: Some(Box::new(meeting)),
                }));
            }
            Some(false) => {}
            None => told = false,
        }
    }
    told.then_some(None)
}

/// The hit of a line that lies in a cylinder or a cone whose region is a rectangle, if it is in that; `None` where that is not known.
pub(super) fn ruling_hit(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    line: &ClosedLine,
) -> Option<Option<RawHit>> {
    let region = brep.region(face);
    let rectangle = region.rectangle()?;
    let ruling = brep.closed(face)?.surface.ruling(brep.brep().surface(face), line)?;
    let (along, across) = (ruling.along, 1 - ruling.along);
    let mut told = true;
    for copy in ruling.across() {
        let spot = |v: f64| {
            let (mut uv, mut known) = ([copy; 2], [None; 2]);
            uv[along] = Ball::exact(v);
            (known[along], known[across]) = (Some(v), ruling.at);
            Spot::new(uv, &known)
        };
        let ends = rectangle[along].map(spot);
        match ends[0].within(across, rectangle[across]) {
            Some(true) => {}
            Some(false) => continue,
            None => {
                told = false;
                continue;
            }
        }
        let [start, end] = rectangle[along].map(|v| ruling.parameter(v));
        let (start, end) = (start?, end?);
        let [first, last] = if start.cmp(&end).is_le() {
            [(start, &ends[0]), (end, &ends[1])]
        } else {
            [(end, &ends[1]), (start, &ends[0])]
        };
        let uv = first.1.uv.map(|x| x.mid.hi);
        let meeting = Meeting {
            t: When::Exact(first.0),
            end: Some(When::Exact(last.0)),
            touches: true,
            on: first.1.trims(region),
            end_on: last.1.trims(region),
            uv,
        };
        let Some(meeting) = meeting.within(stab.range)? else {
            return Some(None);
        };
        let t = meeting.t.enclosed();
        return Some(Some(RawHit {
            face,
            at: HitAt::Closed {
                uv,
                point: [0, 1, 2].map(|c| line.origin[c] + t * line.direction[c]),
            },
            t,
            inside: true,
            at_joint: false,
            touches: true,
            exact: Some(Box::new(meeting)),
        }));
    }
    told.then_some(None)
}
