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
//! That there is one zero in a box, and where, is proven in the module `certify`.
//!
//! What cannot be settled so (a tangent line, a hit within rounding of the region's border) makes the answer
//! `Undecided`; it is never dropped.

use super::certify::{Solved, certify};
use super::forms::{Forms, Stabber, restrict};
use super::hit_side::side_at;
use super::plain_zero::{Told, Whole, plainly, whole_patch};
use super::rows::Rows;
use super::whole_faces::{closed_hits, polygon_hits};
use super::{grazes, joints, poles};
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::closed::V3;
use crate::prepare::{Meeting, Net, PreparedBrep};
use crate::trim::BoxSide;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Boxes are not split below this width in local parameters: in f64, where little is told of boxes that narrow...
const LEAST_WIDTH: f64 = 1.0 / (1u64 << 40) as f64;
/// ...and in double-double, which tells zeros apart that f64 hardly has numbers for, as next to a tangency of a surface that is off by roundings.
const LEAST_FINE_WIDTH: f64 = 1.0 / (1u64 << 50) as f64;
/// Forms that change this many times as much along one side of a box as along the other are even along the other.
const UNEVEN: f64 = 8.0;
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
#[derive(Debug, Default)]
pub(super) struct FaceHits {
    pub(super) hits: Vec<RawHit>,
    /// Local boxes that may hold hits that could not be settled: patch, u, v.
    pub(super) open: Vec<(usize, [f64; 2], [f64; 2])>,
    /// Whether one certain hit is enough, where the others may be missing: see [`FaceHits::is_done`].
    pub(super) one: bool,
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

    fn is_on_patch(&self, index: usize) -> bool {
        matches!(self.at, HitAt::Patch { patch, .. } if patch == index)
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

/// Finds the hits of a line with one face, in a list that is used again; `None` where that is not told.
pub(super) fn face_hits(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    digits: Digits,
    budget: &mut usize,
    out: &mut FaceHits,
) -> Option<()> {
    out.hits.clear();
    out.open.clear();
    if closed_hits(brep, stab, face, digits, &mut out.hits).is_some() {
        return Some(());
    }
    if let Some(found) = polygon_hits(brep, stab, face) {
        out.hits = found;
        return Some(());
    }
    let mut rows = Rows::default();
    patches_hits(brep, stab, face, digits, budget, (&mut rows, out));
    rows.add_hits(brep, stab, face, &mut out.hits);
    joints::settle(brep, stab, &mut out.hits);
    Some(())
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
    // Patches that are known with one before them.
    let mut settled: Vec<usize> = Vec::new();
    for index in 0..geometry.patches.len() {
        if geometry.patch_boxes()[index]
            .as_ref()
            .is_some_and(|b| !stab.meets(b))
            || settled.contains(&index)
        {
            continue;
        }
        let patch = &geometry.patches[index];
        if *budget > 0 {
            *budget -= 1;
            match whole_patch(brep, stab, (face, index), &patch.net, digits) {
                Whole::Missed => continue,
                Whole::Hit(hit, local, rho) => {
                    let side = side_at(brep, (face, index), (local, rho, None), None);
                    accept(stab, hit, side, out);
                    if out.is_done(stab) {
                        return;
                    }
                    continue;
                }
                Whole::Open => {}
            }
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
            if let Some(graze) = grazes::settle(brep, stab, (face, index), &root) {
                if let Some(mate) = graze.mate {
                    out.hits.retain(|h| !h.is_on_patch(mate));
                    out.open.retain(|o| o.0 != mate);
                    settled.push(mate);
                }
                if let Some((hit, side)) = graze.hit {
                    accept(stab, hit, side, out);
                }
                continue;
            }
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
    let least_width = if T::UNIT < f64::UNIT {
        LEAST_FINE_WIDTH
    } else {
        LEAST_WIDTH
    };
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
        let found = look
            .one_at_most
            .and_then(|one| match plainly(brep, stab, at, &node, &one) {
                Told::Zero(found) => Some(found),
                Told::Out => None,
                Told::Open => certify(brep, stab, at, &node),
            });
        if let Some((hit, zone)) = found {
            let settled = within(&zone);
            if let Some((hit, local, rho, border)) = hit {
                // All of where it may be: next to a zone there may be another.
                let around = Dd::from(rho * UP);
                let lies = |x: Dd, zone: [f64; 2]| {
                    Dd::from(zone[0]) <= x - around && x + around <= Dd::from(zone[1])
                };
                let mut zones = solved.iter();
                let known = zones.any(|s| lies(local[0], s.u) && lies(local[1], s.v));
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
                    let side = side_at(brep, (face, patch), (local, rho, border), known);
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
        if look.noise || wide_u.max(wide_v) <= least_width {
            out.open.push((patch, node.u, node.v));
            continue;
        }
        let across = poles::split_across(&node, change);
        if across.is_some_and(|u| if u { wide_u } else { wide_v } <= least_width) {
            out.open.push((patch, node.u, node.v));
            continue;
        }
        let along_u = if let Some(along_u) = across {
            along_u
        } else if wide_u.min(wide_v) <= least_width {
            wide_u > least_width
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

/// Takes a certified zero in, unless it is outside the region or the line's range.
fn accept(stab: &Stabber, mut hit: RawHit, side: BoxSide, out: &mut FaceHits) {
    hit.inside &= side == BoxSide::Inside;
    if side != BoxSide::Outside && !stab.is_beyond(&hit.t) {
        out.hits.push(hit);
    }
}
