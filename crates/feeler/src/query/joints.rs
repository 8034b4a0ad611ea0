//! Hits of a line within rounding of a joint of patches.
//!
//! # What is proven
//! Each patch is followed a little past its border, and its zero there is certified: it may be off the patch (then it is no hit), on it, or,
//! where its enclosure holds a joint, either. Let `p` be such a zero, and `B` a small box of parameters around the point of the
//! joint beside it, cut by the joint into two parts of two patches, or at a corner by two joints into four. Each patch's
//! polynomials have one zero about `B`, with `K = Y L` as in the module `zeros` and `|I - K'| <= e` there. So `K(x)` differs from `x - p` by
//! less than `sqrt(2) e |x - p|`, and its direction by less than 30 degrees for `e <= 1/4` ([`STRAIGHT`]).
//!
//! The two forms, over `w`, are one continuous map `F` on `B`, for the patches meet in the joint. Along the border of `B` on one of two
//! parts, `x - p` turns by half a turn, or as little more or less as `p` is off the joint against `B`; so `K` turns by more than 1/3
//! of a turn and less than 2/3, and `F = K / (w Y)` by more than none and less than a whole, as a linear map keeps what is above and below
//! half a turn where it keeps orientation. On one of four parts it is a quarter, `K` turns by more than 1/12 and less than 5/12, `F` by
//! more than none and less than half. If all `Y` have determinants of one sign, `F` turns by more than none and less than two turns around
//! all of `B`, in the same sense: once. So its degree is one, as are those of its zeros, all of one sign: there is
//! exactly one hit in `B`. It is the zero of one of the patches, on this patch.
//!
//! With determinants of two signs the line touches a kink or passes it: that is left open.

use super::forms::Stabber;
use super::zeros::{HitAt, Place, RawHit, Zone, certify_at};
use crate::numeric::Dd;
use crate::prepare::{ParamMap, PreparedBrep};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Half of the width of the boxes in which zeros are looked for, in local parameters.
const WIDTHS: [f64; 2] = [1.0 / (1u64 << 16) as f64, 1.0 / (1u64 << 32) as f64];
/// The contraction that the proof asks for.
const STRAIGHT: f64 = 0.25;

/// Settles the hits of a face whose enclosures hold joints of its patches: drops those that are not on their patch, or are listed for
/// another, and marks those of which that is not known as not certain.
pub(super) fn settle(brep: &PreparedBrep, stab: &Stabber, hits: &mut Vec<RawHit>) {
    let mut index = 0;
    while index < hits.len() {
        match verdict(brep, stab, hits, index) {
            Verdict::Keep => {
                hits[index].at_joint = false;
                index += 1;
            }
            Verdict::Drop => {
                hits.remove(index);
            }
            Verdict::Open => {
                hits[index].inside = false;
                index += 1;
            }
        }
    }
}

enum Verdict {
    Keep,
    Drop,
    Open,
}

/// Which ends of a patch an enclosure holds or passes: of u, of v.
fn touched(local: &[Dd; 2], rho: f64) -> [[bool; 2]; 2] {
    let off = Dd::from(rho * UP);
    local.map(|x| [x - off <= Dd::ZERO, x + off >= Dd::ONE])
}

fn verdict(brep: &PreparedBrep, stab: &Stabber, hits: &mut [RawHit], index: usize) -> Verdict {
    let hit = &hits[index];
    let HitAt::Patch {
        patch, local, rho, ..
    } = hit.at
    else {
        return Verdict::Keep;
    };
    if !(hit.inside && hit.at_joint) {
        return Verdict::Keep;
    }
    let ends = touched(&local, rho);
    let face = hit.face;
    let Some(own) = oriented(brep, stab, face, patch, local.map(|x| x.hi)) else {
        return Verdict::Open;
    };
    let maps = &brep.double(face).patches[patch].maps;
    let mut t = hit.t;
    for (other, neighbour) in brep.double(face).patches.iter().enumerate() {
        let Some(start) = beside(maps, &neighbour.maps, ends, local) else {
            continue;
        };
        let Some(found) = oriented(brep, stab, face, other, start) else {
            return Verdict::Open;
        };
        if found.positive != own.positive {
            return Verdict::Open;
        }
        let Some(zero) = found.zero else {
            continue;
        };
        let HitAt::Patch {
            local: at,
            rho: off,
            ..
        } = zero.at
        else {
            continue;
        };
        let held = touched(&at, off);
        if held == [[false; 2]; 2] {
            // It is that one.
            return Verdict::Drop;
        }
        let same = |k: usize| maps[k] == neighbour.maps[k];
        if (0..2).any(|k| same(k) && held[k] != ends[k]) {
            return Verdict::Open;
        }
        // Either: one is listed, and holds both.
        let listed = hits.iter().any(|h| match &h.at {
            HitAt::Patch {
                patch: p,
                local: l,
                rho: r,
                ..
            } => {
                h.face == face
                    && *p == other
                    && (0..2).all(|k| (l[k] - at[k]).hi.abs() <= (r + off) * UP)
            }
            HitAt::Closed { .. } => false,
        });
        if other < patch && listed {
            return Verdict::Drop;
        }
        let apart = (zero.t.mid - t.mid).hi.abs();
        t.rad = t.rad.max((apart + zero.t.rad) * UP);
    }
    hits[index].t = t;
    Verdict::Keep
}

/// Where on a patch beside one, in local parameters, the joint is that an enclosure holds; `None` for one that is not beside it, or
/// across another joint.
fn beside(
    own: &[ParamMap; 2],
    other: &[ParamMap; 2],
    ends: [[bool; 2]; 2],
    local: [Dd; 2],
) -> Option<[f64; 2]> {
    let mut start = [0.0; 2];
    for k in 0..2 {
        start[k] = if own[k] == other[k] {
            local[k].hi.clamp(0.0, 1.0)
        } else if ends[k][0] && other[k].end == own[k].start {
            1.0
        } else if ends[k][1] && other[k].start == own[k].end {
            0.0
        } else {
            return None;
        };
    }
    (own != other).then_some(start)
}

/// A patch's zero near a place.
struct Oriented {
    /// Whether the determinant of `Y` is above zero.
    positive: bool,
    /// `None` where it is off the patch.
    zero: Option<RawHit>,
}

fn oriented(
    brep: &PreparedBrep,
    stab: &Stabber,
    face: usize,
    patch: usize,
    start: [f64; 2],
) -> Option<Oriented> {
    let net = &brep.double_double(face).patches[patch].net;
    let root = stab.planes(net);
    let at = Place {
        face,
        patch,
        net,
        root: &root,
        digits: super::zeros::Digits::All,
    };
    WIDTHS.iter().find_map(|half| {
        let made = |p: [f64; 2], y: [[f64; 2]; 2]| {
            // Far nearer to the joint than the box is wide.
            let near = (0..2).all(|k| (p[k] - start[k]).abs() <= 0.25 * half);
            let around = |k: usize| [p[k] - half, p[k] + half];
            let zone = near.then(|| Zone::over(&at, [around(0), around(1)], y))??;
            (zone.e <= STRAIGHT).then_some((zone, y[0][0] * y[1][1] - y[0][1] * y[1][0]))
        };
        let (found, det) = certify_at(brep, stab, &at, start, made)?;
        (det != 0.0).then_some(Oriented {
            positive: det > 0.0,
            zero: found.map(|f| f.0),
        })
    })
}
