//! Hits of a line with the trimmed faces.
//!
//! # What is proven
//! The line `o + t d` is the zero set of two linear forms `n_k.x - n_k.o` whose normals are exactly
//! orthogonal to `d` (their entries are entries of `d`). On a patch each becomes a polynomial `L_k` in Bernstein form.
//! A box of the patch is put aside when
//! - some combination of `L_1`, `L_2` has one sign on it (then there is no zero), or
//! - the box does not meet the region, or the line's parameter does not reach it, or
//! - it lies within a box that is known to hold one zero only, which is already listed.
//!
//! One zero: let `K = Y L` with a constant matrix `Y` and `|I - K'| <= e < 1` (maximum norm) on a convex box. For two
//! points `K(x) - K(p) = M (x - p)` with `|I - M| <= e` (mean values), so `|x - p| <= |K(x) - K(p)| / (1 - e)`: there is at most
//! one zero, it is within `rho = |K(p)| / (1 - e)` of `p`, and if the ball of that radius lies in the box there
//! is one (Brouwer's theorem on `x -> x - K(x)`, which maps the ball into itself).
//!
//! What cannot be settled so (a tangent line, a hit within rounding of the region's border) makes the answer
//! `Undecided`; it is never dropped.

use super::closed::boxes_side;
use super::forms::{Forms, Stabber, contraction, parameter_slope, restrict};
use super::rows::Rows;
use super::{border, joints, poles};
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::closed::{ClosedHit, ClosedLine, V3, exact};
use crate::prepare::{Meeting, Net, PreparedBrep, jet};
use crate::trim::{BoxSide, Side, TrimRegion};
use nalgebra::{Point2, Vector3};
use std::cmp::Ordering;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Boxes are not split below this width in local parameters.
const LEAST_WIDTH: f64 = 1.0 / (1u64 << 40) as f64;
/// Forms that change this many times as much along one side of a box as along the other are even along the other.
const UNEVEN: f64 = 8.0;
/// Steps of Newton's method.
const NEWTON_STEPS: usize = 12;
/// Steps in double-double with the Jacobian in f64: each gains about 50 bits.
const POLISHING_STEPS: usize = 3;
/// A patch whose hits are not settled with so many boxes is looked at for rows that lie in the line.
const FIRST_LOOK: usize = 256;
/// So many boxes of a face are tried again in double-double at most: at a tangency some tens are left open.
const MOST_OPEN: usize = 4096;

/// A hit before it is dressed up.
#[derive(Clone, Debug)]
pub(super) struct RawHit {
    pub(super) face: usize,
    pub(super) at: HitAt,
    pub(super) t: Ball<Dd>,
    /// Whether the hit is proven to be in the region's interior.
    pub(super) inside: bool,
    /// Whether it may be just beyond its patch: see the module `joints`.
    pub(super) at_joint: bool,
    /// Whether the line is tangent to the face's surface there and stays on one side of it.
    pub(super) touches: bool,
    /// The same exactly, where that was needed and can be.
    pub(super) exact: Option<Box<Meeting>>,
}

/// Where on its face a hit is.
#[derive(Clone, Debug)]
pub(super) enum HitAt {
    /// Local parameters on a patch, within `rho` of the true ones.
    Patch {
        patch: usize,
        local: [Dd; 2],
        rho: f64,
        /// The point, rounded.
        point: [f64; 3],
    },
    /// On a face in closed form: native parameters, rounded, and the point.
    Closed { uv: [f64; 2], point: V3 },
}

/// All hits with one face's patches, or what could not be settled.
pub(super) struct FaceHits {
    pub(super) hits: Vec<RawHit>,
    /// Local boxes that may hold hits that could not be settled: patch, u, v.
    pub(super) open: Vec<(usize, [f64; 2], [f64; 2])>,
    /// Whether one certain hit is enough: see [`FaceHits::is_done`].
    one: bool,
}

impl FaceHits {
    /// Whether what was asked is found: the rest may be left unsearched.
    fn is_done(&self, stab: &Stabber) -> bool {
        self.one && self.hits.iter().any(|h| h.is_certain(stab))
    }
}

impl RawHit {
    /// Whether the line passes to the other side of the face's surface there.
    pub(super) fn crosses(&self) -> bool {
        !self.touches
    }

    /// Whether the line holds a row of the face there: see the module `rows`.
    pub(super) fn is_row(&self) -> bool {
        matches!(self.at, HitAt::Patch { .. }) && self.exact.is_some()
    }

    /// Whether the line surely meets the face there, within its range.
    pub(super) fn is_certain(&self, stab: &Stabber) -> bool {
        // What is known exactly was cut to the range.
        let within = self.exact.is_some()
            || stab.range[0] <= self.t.lower() && self.t.upper() <= stab.range[1];
        self.inside && !self.at_joint && within
    }
}

/// How narrow the enclosures of hits are. Which hits there are is proven with either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Digits {
    /// As f64 gives them: to count hits.
    Double,
    /// All that double-double gives.
    All,
}

/// Finds the hits of a line with one face.
pub(super) fn face_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    digits: Digits,
    budget: &mut usize,
) -> Option<FaceHits> {
    find_hits(brep, stab, face, digits, budget, false)
}

/// The same, but once one is certain the others may be missing.
pub(super) fn one_hit(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    budget: &mut usize,
) -> Option<FaceHits> {
    find_hits(brep, stab, face, Digits::All, budget, true)
}

fn find_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    digits: Digits,
    budget: &mut usize,
    one: bool,
) -> Option<FaceHits> {
    let mut out = FaceHits {
        hits: Vec::new(),
        open: Vec::new(),
        one,
    };
    if let Some(found) = closed_hits(brep, stab, face) {
        out.hits = found;
        return Some(out);
    }
    if let Some(found) = polygon_hits(brep, stab, face) {
        out.hits = found;
        return Some(out);
    }
    let mut rows = Rows::default();
    patches_hits(brep, stab, face, digits, budget, (&mut rows, &mut out));
    rows.add_hits(brep, stab, face, &mut out.hits);
    joints::settle(brep, stab, &mut out.hits);
    Some(out)
}

/// The hits with the patches of a face, each by itself.
fn patches_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    digits: Digits,
    budget: &mut usize,
    (rows, out): (&mut Rows, &mut FaceHits),
) {
    let geometry = brep.double(face);
    for (index, patch) in geometry.patches.iter().enumerate() {
        if geometry.patch_boxes[index]
            .as_ref()
            .is_some_and(|b| !stab.meets(b))
        {
            continue;
        }
        let root = stab.planes(&patch.net);
        if root.has_no_zero() {
            continue;
        }
        let at = Place {
            face,
            patch: index,
            net: &patch.net,
            root: &root,
            digits,
        };
        // Most patches are settled soon; of one that is not, a row may be in the line.
        let before = (out.hits.len(), out.open.len());
        let mut first = FIRST_LOOK.min(*budget);
        *budget -= first;
        patch_hits(brep, stab, &at, vec![root.clone()], &mut first, out);
        *budget += first;
        if out.open.len() > before.1 {
            out.hits.truncate(before.0);
            out.open.truncate(before.1);
            let starts = match rows.leave_out(brep, stab, (face, index), &root, budget) {
                Some(rest) => rest.iter().map(|b| restrict(&root, b[0], b[1])).collect(),
                None => vec![root.clone()],
            };
            patch_hits(brep, stab, &at, starts, budget, out);
        }
        if out.is_done(stab) {
            return;
        }
    }
    if !out.open.is_empty() {
        poles::settle(brep, stab, face, budget, out);
    }
    // What f64 cannot settle (a line nearly tangent to the face) is tried again in double-double; not where so
    // much is open that a whole curve of the face must be on the line (a pole's row, a ruling).
    if out.open.len() > MOST_OPEN {
        return;
    }
    let open = std::mem::take(&mut out.open);
    for index in 0..geometry.patches.len() {
        let boxes: Vec<_> = open.iter().filter(|o| o.0 == index).collect();
        if boxes.is_empty() {
            continue;
        }
        let net = &brep.double_double(face).patches[index].net;
        let root = stab.planes(net);
        let starts = boxes.iter().map(|o| restrict(&root, o.1, o.2)).collect();
        let at = Place {
            face,
            patch: index,
            net,
            root: &root,
            digits: Digits::All,
        };
        patch_hits(brep, stab, &at, starts, budget, out);
    }
}

/// The hits with a face in closed form, where formulas tell them.
fn closed_hits(brep: &PreparedBrep, stab: &Stabber, face: usize) -> Option<Vec<RawHit>> {
    let form = brep.closed(face)?;
    let b = brep.face_box(face)?;
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
    let mut out = Vec::new();
    for mut hit in form.surface.hits(&line)? {
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
            // Whether hits are one is known exactly for polygons: they go there.
            BoxSide::Mixed if brep.polygon(face).is_some() => return None,
            // The boxes are rounded outward to f64.
            BoxSide::Mixed => {
                let places = form.surface.places(&hit.point)?;
                let known = |uv: &[f64; 2]| form.surface.is_exactly_at(&line, *uv);
                let place = match place_inside(brep, face, &places) {
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
    Some(out)
}

fn closed_hit(face: usize, hit: &ClosedHit, uv: [f64; 2]) -> RawHit {
    RawHit {
        face,
        at: HitAt::Closed {
            uv,
            point: hit.point,
        },
        t: hit.t,
        inside: true,
        at_joint: false,
        touches: hit.touches,
        exact: None,
    }
}

/// Of the copies of one point's parameters the one that is in the region, rounded, if one is; `None` where that is not known.
fn place_inside(
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
fn polygon_hits(brep: &PreparedBrep, stab: &Stabber, face: usize) -> Option<Vec<RawHit>> {
    let found = brep
        .polygon(face)?
        .meetings(&stab.origin, &stab.direction)?;
    let kept = found.into_iter().filter_map(|m| m.within(stab.range));
    let hits = kept.map(|m| {
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

/// A box that holds one zero at most, which is known.
struct Solved {
    u: [f64; 2],
    v: [f64; 2],
}

/// A patch, the forms on all of it, and how its hits are wanted.
pub(super) struct Place<'a, T> {
    pub(super) face: usize,
    pub(super) patch: usize,
    pub(super) net: &'a Net<T>,
    pub(super) root: &'a Forms<T>,
    pub(super) digits: Digits,
}

fn patch_hits<T: Real>(
    brep: &PreparedBrep,
    stab: &Stabber,
    at: &Place<T>,
    starts: Vec<Forms<T>>,
    budget: &mut usize,
    out: &mut FaceHits,
) {
    let (face, patch) = (at.face, at.patch);
    let geometry = brep.double(face);
    let maps = &geometry.patches[patch].maps;
    let classify = |u: [f64; 2], v: [f64; 2]| {
        brep.region(face).classify_box(
            maps[0].to_native_range(u[0], u[1]),
            maps[1].to_native_range(v[0], v[1]),
        )
    };
    let mut solved: Vec<Solved> = Vec::new();
    // Combinations of the two forms, used again and again.
    let mut turned: [Vec<T>; 2] = Default::default();
    let mut stack: Vec<_> = starts.into_iter().map(|r| (r, false)).collect();
    while let Some((node, mut inside)) = stack.pop() {
        let within = |s: &Solved| {
            s.u[0] <= node.u[0] && node.u[1] <= s.u[1] && s.v[0] <= node.v[0] && node.v[1] <= s.v[1]
        };
        if node.has_no_zero() || node.beyond(stab) || solved.iter().any(within) {
            continue;
        }
        if *budget == 0 {
            out.open.push((patch, node.u, node.v));
            continue;
        }
        *budget -= 1;
        if !inside {
            match classify(node.u, node.v) {
                BoxSide::Outside => continue,
                BoxSide::Inside => inside = true,
                BoxSide::Mixed => {}
            }
        }
        let (j, change) = node.slopes();
        let look = node.look(&j, &mut turned);
        if look.none {
            continue;
        }
        if look.one_at_most
            && let Some((hit, zone)) = certify(brep, stab, at, &node)
        {
            let settled = within(&zone);
            if let Some((hit, local, rho, seam)) = hit {
                let known = solved.iter().any(|s| {
                    s.u[0] <= local[0].hi
                        && local[0].hi <= s.u[1]
                        && s.v[0] <= local[1].hi
                        && local[1].hi <= s.v[1]
                });
                // Or an earlier pass found it, if that is in the zone that holds one zero only.
                let mut listed = false;
                let mut may_be = false;
                for other in &out.hits {
                    let HitAt::Patch {
                        patch: p,
                        local: l,
                        rho: r,
                        ..
                    } = &other.at
                    else {
                        continue;
                    };
                    if *p != patch || other.face != face {
                        continue;
                    }
                    let (off, zone) = (Dd::from(r * UP), [zone.u, zone.v]);
                    let held = (0..2).all(|k| {
                        Dd::from(zone[k][0]) <= l[k] - off && l[k] + off <= Dd::from(zone[k][1])
                    });
                    let near = (0..2).all(|k| (l[k] - local[k]).hi.abs() <= UP * (r + rho));
                    listed |= held;
                    may_be |= near && !held;
                }
                if !known && !listed && may_be {
                    out.open.push((patch, node.u, node.v));
                    continue;
                }
                if !known && !listed {
                    let known = inside.then_some([node.u, node.v]);
                    let side = side_at(brep, at, (local, rho, seam), known);
                    accept(stab, hit, side, out);
                    if out.is_done(stab) {
                        return;
                    }
                }
            }
            solved.push(zone);
            if settled {
                continue;
            }
        }
        // Along the longer side, but where the forms hardly change along it: along a ruling that the line is parallel to nothing
        // is gained by halves.
        let [wide_u, wide_v] = [node.u, node.v].map(|r| r[1] - r[0]);
        if look.noise || wide_u.max(wide_v) <= LEAST_WIDTH {
            out.open.push((patch, node.u, node.v));
            continue;
        }
        let across = poles::split_across(&node, change);
        if across.is_some_and(|u| if u { wide_u } else { wide_v } <= LEAST_WIDTH) {
            out.open.push((patch, node.u, node.v));
            continue;
        }
        let along_u = if let Some(along_u) = across {
            along_u
        } else if wide_u.min(wide_v) <= LEAST_WIDTH {
            wide_u > LEAST_WIDTH
        } else if change[0].max(change[1]) > UNEVEN * change[0].min(change[1]) {
            change[0] > change[1]
        } else {
            wide_u >= wide_v
        };
        let [a, b] = node.halves(along_u);
        stack.push((b, inside));
        stack.push((a, inside));
    }
}

/// Where a zero is, known within `rho`: first by a box in f64, and where that meets the region's boundary by all digits. It
/// was found from a node that is known to be inside or not, but may lie beside it.
fn side_at<T>(
    brep: &PreparedBrep,
    at: &Place<T>,
    (local, rho, seam): ([Dd; 2], f64, Option<usize>),
    inside: Option<[[f64; 2]; 2]>,
) -> BoxSide {
    let off = Dd::from(rho * UP);
    let within = |b: [[f64; 2]; 2]| {
        (0..2).all(|k| Dd::from(b[k][0]) <= local[k] - off && local[k] + off <= Dd::from(b[k][1]))
    };
    if inside.is_some_and(within) {
        return BoxSide::Inside;
    }
    let region = brep.region(at.face);
    let maps = &brep.double(at.face).patches[at.patch].maps;
    let uv = [0, 1].map(|k| {
        let x = Ball {
            mid: local[k],
            rad: rho * UP,
        };
        Ball::exact(maps[k].start) + x * Ball::difference(maps[k].end, maps[k].start)
    });
    if let Some(k) = seam {
        return side_on_seam(region, k, uv[1 - k]);
    }
    let r = rho * UP + 4.0 * f64::EPSILON;
    let around = |k: usize| {
        let x = local[k].hi;
        maps[k].to_native_range((x - r).max(0.0), (x + r).min(1.0))
    };
    let side = region.classify_box(around(0), around(1));
    // Where the zero may be just beyond its patch, it stands for the next patch's, which is elsewhere by as little: a box holds
    // both, but not all digits do.
    let on_patch = (0..2).all(|k| local[k] - off >= Dd::ZERO && local[k] + off <= Dd::ONE);
    if side != BoxSide::Mixed || !on_patch {
        return side;
    }
    match region.side_of_ball(uv) {
        Some(Side::Inside) => BoxSide::Inside,
        Some(Side::Outside) => BoxSide::Outside,
        Some(Side::Boundary) | None => BoxSide::Mixed,
    }
}

/// Where a point is that is exactly on the seam across a coordinate, given the other: in the region where it is on either side of the seam.
fn side_on_seam(region: &TrimRegion, across: usize, along: Ball<Dd>) -> BoxSide {
    let domain = region.domain()[across];
    let width = BESIDE_SEAM * domain.length();
    let sides = [
        (domain.start, [domain.start, domain.start + width]),
        (domain.end, [domain.end - width, domain.end]),
    ]
    .map(|(end, beside)| {
        let (mut uv, mut b) = ([along; 2], [[along.lower(), along.upper()]; 2]);
        (uv[across], b[across]) = (Ball::exact(end), beside);
        // A loop that runs along the border leaves what is beside it inside.
        match region.classify_box(b[0], b[1]) {
            BoxSide::Inside => Some(Side::Inside),
            BoxSide::Outside => Some(Side::Outside),
            BoxSide::Mixed => region.side_of_ball(uv),
        }
    });
    if sides.contains(&Some(Side::Inside)) {
        BoxSide::Inside
    } else if sides == [Some(Side::Outside); 2] {
        BoxSide::Outside
    } else {
        BoxSide::Mixed
    }
}

/// How wide a box beside a seam is, as a part of the domain: hardly more than there are f64 for.
const BESIDE_SEAM: f64 = 1.0 / (1u64 << 48) as f64;

/// Takes a certified zero in, unless it is outside the region or the line's range.
fn accept(stab: &Stabber, mut hit: RawHit, side: BoxSide, out: &mut FaceHits) {
    hit.inside &= side == BoxSide::Inside;
    if side != BoxSide::Outside && !stab.is_beyond(&hit.t) {
        out.hits.push(hit);
    }
}

/// A certified zero, its local parameters and the bound on them, and across which coordinate's seam it is, exactly.
type Found = (RawHit, [Dd; 2], f64, Option<usize>);

/// The point of a net at local parameters near the unit square, and `L_1`, `L_2` there, with bounds.
fn forms_at(
    stab: &Stabber,
    net: &Net<Dd>,
    offsets: &[Ball<Dd>; 2],
    p: [Dd; 2],
) -> ([Ball<Dd>; 4], [Ball<Dd>; 2]) {
    let p = p.map(ball);
    let value = jet::fine_value(net, p).unwrap_or_else(|| net.jet(p[0], p[1]).value);
    (value, stab.apply(&value, offsets))
}

/// Near a zero: the point where Newton's method in f64 ends, and the inverse of the Jacobian there. No bound: what is made of it
/// is proven afterwards.
fn newton(
    stab: &Stabber,
    net: &Net<f64>,
    offsets: &[Ball<Dd>; 2],
    start: [f64; 2],
) -> Option<Near> {
    let offsets = offsets.map(|x| x.mid.hi);
    let apply = |h: &[f64; 4]| -> [f64; 2] {
        std::array::from_fn(|k| {
            let n = &stab.normals[k];
            n[0] * h[0] + n[1] * h[1] + n[2] * h[2] + offsets[k] * h[3]
        })
    };
    let (mut p, mut last) = (start, f64::INFINITY);
    let mut y = [[0.0; 2]; 2];
    let mut tangent = false;
    for _ in 0..NEWTON_STEPS {
        let h: [[f64; 4]; 3] = if jet::fits(net.degree) {
            jet::jet1(net, p[0], p[1])
        } else {
            let j = net.jet(Ball::exact(p[0]), Ball::exact(p[1]));
            [j.value, j.s, j.t].map(|v| v.map(|x| x.mid))
        };
        let [l, ls, lt] = h.map(|h| apply(&h));
        let det = ls[0] * lt[1] - lt[0] * ls[1];
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        y = [[lt[1] / det, -lt[0] / det], [-ls[1] / det, ls[0] / det]];
        let size = (ls[0].abs() + lt[0].abs()) * (ls[1].abs() + lt[1].abs());
        tangent = det.abs() < TANGENT * size;
        let mut moved: f64 = 0.0;
        for k in 0..2 {
            let step = y[k][0] * l[0] + y[k][1] * l[1];
            // Stay near the patch: zeros far off are of no use.
            p[k] = (p[k] - step).clamp(-0.5 * EXTENSION, 1.0 + 0.5 * EXTENSION);
            moved = moved.max(step.abs());
        }
        // In the end rounding moves it to and fro.
        if moved <= f64::EPSILON || (moved < SETTLED && moved >= 0.5 * last) {
            break;
        }
        last = moved;
    }
    Some(Near { p, y, tangent })
}

/// Where Newton's method ended, the inverse of the Jacobian there, and whether the line is near to tangent, so that f64 does not tell
/// either well.
struct Near {
    p: [f64; 2],
    y: [[f64; 2]; 2],
    tangent: bool,
}

/// A Jacobian whose determinant is below this part of its products.
const TANGENT: f64 = 1.0 / (1u64 << 20) as f64;

/// A step below this, in local parameters, is not worth taking: 2^-96 of the size is what full accuracy asks for.
const POLISHED: f64 = 1.0 / (1u128 << 102) as f64;

/// Whether a point is farther from a node than half its width.
fn is_apart<T>(p: [f64; 2], node: &Forms<T>) -> bool {
    let apart = |x: f64, r: [f64; 2]| (r[0] - x).max(x - r[1]).max(0.0) / (r[1] - r[0]);
    apart(p[0], node.u) > 0.5 || apart(p[1], node.v) > 0.5
}

/// Steps below this are near rounding.
const SETTLED: f64 = 1.0 / (1u64 << 32) as f64;

/// The same in double-double throughout, for lines next to tangent: the Jacobian in f64 is then not near enough to the true one.
fn newton_fine(
    stab: &Stabber,
    net: &Net<Dd>,
    offsets: &[Ball<Dd>; 2],
    start: [f64; 2],
) -> Option<([Dd; 2], [[f64; 2]; 2])> {
    let mut p = start.map(Dd::from);
    let mut y = [[0.0; 2]; 2];
    for _ in 0..NEWTON_STEPS {
        let jet = net.jet(ball(p[0]), ball(p[1]));
        let l = stab.apply(&jet.value, offsets);
        let (ls, lt) = (stab.apply(&jet.s, offsets), stab.apply(&jet.t, offsets));
        let j = [[ls[0].mid.hi, lt[0].mid.hi], [ls[1].mid.hi, lt[1].mid.hi]];
        let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        y = [
            [j[1][1] / det, -j[0][1] / det],
            [-j[1][0] / det, j[0][0] / det],
        ];
        let mut moved: f64 = 0.0;
        for k in 0..2 {
            let step = -(y[k][0] * l[0].mid.hi + y[k][1] * l[1].mid.hi);
            let next = p[k] + Dd::from(step);
            p[k] = if next.hi < -0.5 * EXTENSION {
                Dd::from(-0.5 * EXTENSION)
            } else if next.hi > 1.0 + 0.5 * EXTENSION {
                Dd::from(1.0 + 0.5 * EXTENSION)
            } else {
                next
            };
            moved = moved.max(step.abs());
        }
        if moved < f64::EPSILON * f64::EPSILON {
            break;
        }
    }
    Some((p, y))
}

/// The point and `L_1`, `L_2` at a place of a patch, with bounds.
struct Sample {
    value: [Ball<Dd>; 4],
    l: [Ball<Dd>; 2],
    /// What the point is relative to: each arithmetic's net has its own.
    origin: [f64; 3],
}

/// The zero near a node, and a box about it in which it is the only one.
fn certify<T: Real>(
    brep: &PreparedBrep,
    stab: &Stabber,
    at: &Place<T>,
    node: &Forms<T>,
) -> Option<(Option<Found>, Solved)> {
    let (face, patch) = (at.face, at.patch);
    let middle = [node.u, node.v].map(|r| 0.5 * (r[0] + r[1]));
    let coarse = &brep.double(face).patches[patch].net;
    let offsets = |origin: &[f64; 3]| [0, 1].map(|k| stab.offset(k, origin));
    let near = newton(stab, coarse, &offsets(&coarse.origin), middle);
    // What f64 does not tell about a line near to tangent, and what it left open, is looked at more finely below.
    let last = T::UNIT >= f64::UNIT && near.as_ref().is_some_and(|n| !n.tangent);
    let zone = near.as_ref().and_then(|n| Zone::new(at, node, n.p, n.y));
    if last && zone.is_none() {
        return None;
    }
    let on_patch = |p: &[f64; 2]| p.iter().all(|x| (0.0..=1.0).contains(x));
    if at.digits == Digits::Double
        && jet::fits(coarse.degree)
        && let (Some(n), Some(zone)) = (&near, &zone)
        && on_patch(&n.p)
    {
        let [value, ..] = jet::jet(coarse, n.p[0], n.p[1]);
        let value = value.map(|x| Ball {
            mid: Dd::from(x.mid),
            rad: x.rad,
        });
        let sample = Sample {
            l: stab.apply(&value, &offsets(&coarse.origin)),
            value,
            origin: coarse.origin,
        };
        return prove(brep, stab, at, zone, n.p.map(Dd::from), &sample);
    }
    let fine = &brep.double_double(face).patches[patch].net;
    let offsets = offsets(&fine.origin);
    let sample_at = |p: [Dd; 2]| {
        let (value, l) = forms_at(stab, fine, &offsets, p);
        Sample {
            value,
            l,
            origin: fine.origin,
        }
    };
    if let (Some(n), Some(zone)) = (&near, &zone) {
        let mut p = n.p.map(Dd::from);
        for _ in 0..=POLISHING_STEPS {
            let sample = sample_at(p);
            let step: [Dd; 2] = std::array::from_fn(|k| {
                Dd::from(n.y[k][0]) * sample.l[0].mid + Dd::from(n.y[k][1]) * sample.l[1].mid
            });
            let moved = step[0].hi.abs().max(step[1].hi.abs());
            if moved <= POLISHED {
                let found = prove(brep, stab, at, zone, p, &sample);
                if last || found.is_some() {
                    return found;
                }
                break;
            }
            if !(moved < SETTLED) {
                break;
            }
            p = [0, 1].map(|k| p[k] - step[k]);
        }
    }
    let (p, y) = newton_fine(stab, fine, &offsets, middle)?;
    let zone = Zone::new(at, node, p.map(|x| x.hi), y)?;
    prove(brep, stab, at, &zone, p, &sample_at(p))
}

/// The zero near a place, on the patch or not: its local parameters, known within the radius, and what was said of the zone in
/// which it is the only one; `zone_at` makes this about the place where Newton's method ends, with the inverse of the Jacobian there.
pub(super) fn zero_near<R>(
    stab: &Stabber,
    at: &Place<Dd>,
    start: [f64; 2],
    zone_at: impl Fn([f64; 2], [[f64; 2]; 2]) -> Option<(Zone, R)>,
) -> Option<([Dd; 2], f64, R)> {
    let offsets = [0, 1].map(|k| stab.offset(k, &at.net.origin));
    let (p, y) = newton_fine(stab, at.net, &offsets, start)?;
    let (zone, said) = zone_at(p.map(|x| x.hi), y)?;
    let (value, l) = forms_at(stab, at.net, &offsets, p);
    let sample = Sample {
        value,
        l,
        origin: at.net.origin,
    };
    let widest = (zone.u[1] - zone.u[0]).max(zone.v[1] - zone.v[0]);
    let rho = zone.radius(p, &sample)? * widest * UP;
    Some((p, rho, said))
}

/// A zero of the forms: its local parameters, how far it can be from there in each, and a box about it in which it is the only one.
pub(super) struct KnownZero {
    pub(super) at: [Dd; 2],
    pub(super) reach: [Dd; 2],
    pub(super) zone: [[f64; 2]; 2],
}

/// The zero near the middle of a box, on the patch or not.
pub(super) fn known_zero(stab: &Stabber, at: &Place<Dd>, node: &Forms<Dd>) -> Option<KnownZero> {
    let offsets = [0, 1].map(|k| stab.offset(k, &at.net.origin));
    let middle = [node.u, node.v].map(|r| 0.5 * (r[0] + r[1]));
    let (p, y) = newton_fine(stab, at.net, &offsets, middle)?;
    let zone = Zone::new(at, node, p.map(|x| x.hi), y)?;
    let (value, l) = forms_at(stab, at.net, &offsets, p);
    let sample = Sample {
        value,
        l,
        origin: at.net.origin,
    };
    let rho = zone.radius(p, &sample)?;
    let reach = [zone.u, zone.v].map(|r| Dd::from(rho * (r[1] - r[0]) * UP));
    Some(KnownZero {
        at: p,
        reach,
        zone: [zone.u, zone.v],
    })
}

/// The parameter of the line at a zero that is known so, and the point, rounded; `None` where a weight may not be positive.
pub(super) fn parameter_at(
    stab: &Stabber,
    net: &Net<Dd>,
    KnownZero { at, reach, zone }: &KnownZero,
) -> Option<(Ball<Dd>, [f64; 3])> {
    let offsets = [0, 1].map(|k| stab.offset(k, &net.origin));
    let (value, _) = forms_at(stab, net, &offsets, *at);
    let t = stab.parameter(&value, &net.origin);
    // t moves with the point: bounded by the slopes over the zone, for coordinates that run over it from 0 to 1.
    let clock = restrict(&stab.clock(net), zone[0], zone[1]);
    let share = (0..2).map(|k| reach[k].hi / (zone[k][1] - zone[k][0]));
    let off = parameter_slope(&clock, stab, t.mid.hi) * share.fold(0.0, f64::max) * UP;
    let t = Ball {
        mid: t.mid,
        rad: (t.rad + off) * UP,
    };
    let point = [0, 1, 2].map(|c| {
        let x = value[c] / value[3] + Ball::exact(net.origin[c]);
        x.mid.hi
    });
    t.rad.is_finite().then_some((t, point))
}

/// A box in which there is one zero at most.
pub(super) struct Zone {
    u: [f64; 2],
    v: [f64; 2],
    /// `Y` for coordinates that run over it from 0 to 1.
    scaled: [[f64; 2]; 2],
    /// The contraction there.
    pub(super) e: f64,
}

impl Zone {
    /// Twice a node's width about a point in it or not far from it (else another node will find the zero), within the
    /// extended patch. `y` is about the inverse of the Jacobian.
    fn new<T: Real>(at: &Place<T>, node: &Forms<T>, p: [f64; 2], y: [[f64; 2]; 2]) -> Option<Self> {
        if is_apart(p, node) {
            return None;
        }
        let around = |k: usize, r: [f64; 2]| {
            let h = r[1] - r[0];
            [(p[k] - h).max(-EXTENSION), (p[k] + h).min(1.0 + EXTENSION)]
        };
        Self::over(at, [around(0, node.u), around(1, node.v)], y)
    }

    /// The zone over a box within the extended patch.
    pub(super) fn over<T: Real>(
        at: &Place<T>,
        [u, v]: [[f64; 2]; 2],
        y: [[f64; 2]; 2],
    ) -> Option<Self> {
        let widths = [u[1] - u[0], v[1] - v[0]];
        let near = restrict(at.root, u, v);
        let scaled = [0, 1].map(|k: usize| y[k].map(|x| x / widths[k]));
        let mut turned: [Vec<T>; 2] = Default::default();
        let errors = [0, 1].map(|k| near.combine(scaled[k], &mut turned[k]));
        let [first, second] = &turned;
        let e = contraction([(first, errors[0]), (second, errors[1])], near.degree);
        (e < 1.0).then_some(Self { u, v, scaled, e })
    }

    /// How far the zero is from a point at most, in widths of the zone; `None` where none is known to be there.
    fn radius(&self, p: [Dd; 2], sample: &Sample) -> Option<f64> {
        let widths = [self.u[1] - self.u[0], self.v[1] - self.v[0]];
        let mut residual: f64 = 0.0;
        for row in &self.scaled {
            let k = Ball::exact(row[0]) * sample.l[0] + Ball::exact(row[1]) * sample.l[1];
            residual = residual.max(k.magnitude());
        }
        let rho = residual / (1.0 - self.e) * UP / (1.0 - f64::EPSILON);
        // A zero exists if its ball is in the zone.
        let reach = |k: usize| Dd::from(rho * widths[k] * UP);
        let exists = (0..2).all(|k| {
            let r = if k == 0 { self.u } else { self.v };
            (p[k] - reach(k)).hi > r[0] && (p[k] + reach(k)).hi < r[1]
        });
        exists.then_some(rho)
    }
}

/// That there is one zero near a point: see the module.
fn prove<T: Real>(
    brep: &PreparedBrep,
    stab: &Stabber,
    at: &Place<T>,
    zone: &Zone,
    p: [Dd; 2],
    sample: &Sample,
) -> Option<(Option<Found>, Solved)> {
    let (face, patch) = (at.face, at.patch);
    let &Zone { u, v, .. } = zone;
    let widths = [u[1] - u[0], v[1] - v[0]];
    let rho = zone.radius(p, sample)?;
    let local_rho = rho * widths[0].max(widths[1]) * UP;
    let reach = |k: usize| Dd::from(rho * widths[k] * UP);
    // It counts if it is on the patch. One that may be just beyond is settled with the next patch's: see the module `joints`.
    let off = |k: usize| p[k] + reach(k) < Dd::ZERO || p[k] - reach(k) > Dd::ONE;
    if off(0) || off(1) {
        return Some((None, Solved { u, v }));
    }
    // Within rounding of the border of the whole surface the hit cannot be settled, unless that is a seam: a joint as any other.
    let domain = brep.brep().surface(face).domain();
    let maps = &brep.double(face).patches[patch].maps;
    let (mut on_edge, mut at_joint, mut seam) = (false, false, None);
    for k in 0..2 {
        let (low, high) = (p[k] - reach(k) <= Dd::ZERO, p[k] + reach(k) >= Dd::ONE);
        if !(low || high) {
            continue;
        }
        let of_surface =
            low && maps[k].start == domain[k].start || high && maps[k].end == domain[k].end;
        let exact = || {
            let net = &brep.double_double(face).patches[patch].net;
            let surface = brep.brep().surface(face);
            low != high && border::holds_zero(stab, surface, net, (k, high), [u, v])
        };
        if !of_surface {
            at_joint = true;
        } else if brep.meets_itself(face, k == 0) {
            at_joint = true;
            if exact() {
                seam = Some(k);
            }
        } else {
            on_edge |= !exact();
        }
    }
    let t = stab.parameter(&sample.value, &sample.origin);
    // t moves with the point: bounded by the slopes over the zone.
    let clock = restrict(&stab.clock(at.net), u, v);
    let reach = parameter_slope(&clock, stab, t.mid.hi) * rho * UP;
    let t = Ball {
        mid: t.mid,
        rad: (t.rad + reach) * UP,
    };
    let hit = RawHit {
        face,
        at: HitAt::Patch {
            patch,
            local: p,
            rho: local_rho,
            point: [0, 1, 2].map(|c| {
                let x = sample.value[c] / sample.value[3] + Ball::exact(sample.origin[c]);
                x.mid.hi
            }),
        },
        t,
        inside: !on_edge,
        at_joint,
        touches: false,
        exact: None,
    };
    Some((Some((hit, p, local_rho, seam)), Solved { u, v }))
}

/// How far the polynomials of a patch are followed past its border, in local parameters.
const EXTENSION: f64 = 1.0 / 1024.0;

fn ball(x: Dd) -> Ball<Dd> {
    Ball { mid: x, rad: 0.0 }
}
