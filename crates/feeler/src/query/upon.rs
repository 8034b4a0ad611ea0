//! Hits with a revolution that are exactly on its seam or on a trim along a parameter, and lines in its rulings.
//!
//! # What is proven
//! What is known exactly of a hit is said in the module `prepare/closed/upon.rs`. A place of which some parameters are known exactly and the others are within
//! enclosures is in the closed region if it is on one of the runs of the line through it along an exact parameter. Where these are not known, boxes that hold it are
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
        for k in 0..2 {
            if let Some(c) = self.exact[k]
                && let Some(runs) = self.runs(region, k)
            {
                return Some(runs.iter().any(|r| r[0] <= c && c <= r[1]));
            }
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

    /// Where the line through it along a parameter is in the closed region: intervals of that parameter; `None` where that is not known, as where it meets
    /// pieces that are not straight along the other one.
    ///
    /// The parity on either side of the line changes where a piece passes from beside it on that side to it or beyond; the line is in the closed
    /// region where the parity is odd on one of the sides. What is left is cut with the domain.
    fn runs(&self, region: &TrimRegion, along: usize) -> Option<Vec<[f64; 2]>> {
        let across = 1 - along;
        let domain = region.domain();
        let (own, other) = (domain[along], domain[across]);
        match self.within(across, [other.start, other.end]) {
            Some(true) => {}
            Some(false) => return Some(Vec::new()),
            None => return None,
        }
        if region.is_untrimmed() {
            return Some(vec![[own.start, own.end]]);
        }
        // Where a number is: below it, there, or above.
        let side = |x: f64| -> Option<i32> {
            if let Some(c) = self.exact[across] {
                return Some(if x < c { -1 } else { i32::from(x > c) });
            }
            let off = Ball::exact(x) - self.uv[across];
            if off.is_above(0.0) {
                Some(1)
            } else {
                (-off).is_above(0.0).then_some(-1)
            }
        };
        let mut places: Vec<(f64, [bool; 2])> = Vec::new();
        let mut on_line: Vec<[f64; 2]> = Vec::new();
        for piece in region.pieces() {
            if piece.origin == PieceOrigin::Domain {
                continue;
            }
            let [low, high] = piece.hull[across];
            if side(high) == Some(-1) || side(low) == Some(1) {
                continue;
            }
            let (k, at) = piece.kept()?;
            let [p, q] = piece.segment()?;
            let signs = [side(p[across])?, side(q[across])?];
            let changes = [
                (signs[0] > 0) != (signs[1] > 0),
                (signs[0] < 0) != (signs[1] < 0),
            ];
            if !(changes[0] || changes[1]) {
                if signs == [0; 2] {
                    let ends = [p[along], q[along]];
                    on_line.push([ends[0].min(ends[1]), ends[0].max(ends[1])]);
                }
                continue;
            }
            // It runs across.
            if k != along {
                return None;
            }
            places.push((at, changes));
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut out: Vec<[f64; 2]> = Vec::new();
        let (mut odd, mut from) = ([false; 2], None);
        for same in places.chunk_by(|a, b| a.0 == b.0) {
            let before = odd != [false; 2];
            for (_, changes) in same {
                for (o, c) in odd.iter_mut().zip(changes) {
                    *o ^= c;
                }
            }
            match (before, odd != [false; 2]) {
                (false, true) => from = Some(same[0].0),
                (true, false) => out.push([from?, same[0].0]),
                // A point that pieces only touch.
                (false, false) => return None,
                (true, true) => {}
            }
        }
        // Pieces on the line that are no border of a run.
        let held = |x: &[f64; 2]| out.iter().any(|r| r[0] <= x[0] && x[1] <= r[1]);
        if !on_line.iter().all(held) {
            return None;
        }
        out.retain_mut(|r| {
            *r = [r[0].max(own.start), r[1].min(own.end)];
            r[0] <= r[1]
        });
        Some(out)
    }

    /// The trims along parameters that it is exactly on.
    fn trims(&self, region: &TrimRegion) -> Vec<usize> {
        let on = |piece: BoundaryPiece| {
            let (k, at) = piece.kept()?;
            let PieceOrigin::Trim { trim, .. } = piece.origin else {
                return None;
            };
            let ends = piece.segment()?.map(|p| p[1 - k]);
            let range = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            (self.exact[k] == Some(at) && self.within(1 - k, range) == Some(true)).then_some(trim)
        };
        region.pieces().filter_map(on).collect()
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
    let mut isos: Vec<f64> = region
        .pieces()
        .filter_map(|p| p.kept())
        .filter(|i| i.0 == along)
        .map(|i| i.1)
        .collect();
    isos.sort_by(f64::total_cmp);
    isos.dedup();
    let known: Exactly = brep
        .closed(face)?
        .surface
        .exactly(surface, line, hit, &isos)?;
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
                    along: Vec::new(),
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

/// The hits of a line that lies in a cylinder or a cone; `None` where they are not known.
pub(super) fn ruling_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    line: &ClosedLine,
) -> Option<Vec<RawHit>> {
    let region = brep.region(face);
    let surface = brep.brep().surface(face);
    let ruling = brep.closed(face)?.surface.ruling(surface, line)?;
    let (along, across) = (ruling.along, 1 - ruling.along);
    let middle = 0.5 * (region.domain()[along].start + region.domain()[along].end);
    let mut out = Vec::new();
    for copy in ruling.across() {
        let spot = |v: f64| {
            let (mut uv, mut known) = ([copy; 2], [None; 2]);
            uv[along] = Ball::exact(v);
            (known[along], known[across]) = (Some(v), ruling.at);
            Spot::new(uv, &known)
        };
        for run in spot(middle).runs(region, along)? {
            let ends = run.map(spot);
            let [start, end] = run.map(|v| ruling.parameter(v));
            let (start, end) = (start?, end?);
            let [first, last] = if start.cmp(&end).is_le() {
                [(start, &ends[0]), (end, &ends[1])]
            } else {
                [(end, &ends[1]), (start, &ends[0])]
            };
            let point = run[0] == run[1];
            let uv = first.1.uv.map(|x| x.mid.hi);
            let meeting = Meeting {
                t: When::Exact(first.0.clone()),
                end: (!point).then_some(When::Exact(last.0.clone())),
                touches: true,
                on: first.1.trims(region),
                end_on: last.1.trims(region),
                along: Vec::new(),
                uv,
            };
            let last_uv = last.1.uv.map(|x| x.mid.hi);
            let whole = [&first.0, &last.0].map(|t| t.enclosed());
            // Along a ruling parameters are linear in each other.
            let uv_at = |t: &When| {
                let part = ((t.enclosed() - whole[0]) / (whole[1] - whole[0])).mid.hi;
                [0, 1].map(|k| uv[k] + part * (last_uv[k] - uv[k]))
            };
            let Some(meeting) = meeting.within(stab.range, uv_at)? else {
                continue;
            };
            let uv = meeting.uv;
            let t = meeting.t.enclosed();
            out.push(RawHit {
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
            });
        }
    }
    Some(out)
}
