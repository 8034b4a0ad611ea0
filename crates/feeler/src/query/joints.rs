//! Hits of a line within rounding of a joint of patches.
//!
//! # What is proven
//! Each patch is followed a little past its border, and its zero there is certified: it may be off the patch (then it is no hit), on it, or,
//! where its enclosure holds a joint, either. Let a joint, or a corner of four patches, be in the enclosure of a zero. Let `B` be a
//! small box of parameters around a point there, cut by the joint into two parts of two patches, or by two joints into four. Each
//! patch's polynomials have one zero `p` about `B`, with `K = Y L` as in the module `certify` and `|I - K'| <= e` in coordinates
//! in which the zone is a square. So `K(x)` differs from `x - p` by no more than `sqrt(2) e |x - p|`, and for `e <= 1/4` ([`STRAIGHT`]) its
//! direction by less than 21 degrees. And `p` is off the middle of `B` by no more than an eighth of its shorter half side ([`NEAR`]), in
//! these coordinates too: seen from `p`, the joints' ends on the border of `B` are less than 9 degrees from where the middle sees them.
//!
//! The two forms, over `w`, are one continuous map `F` on `B`, for the patches meet in the joint. Along the border of `B` on one of two
//! parts, `x - p` turns by 180 degrees up to 18, `K` by 180 up to 60, and `F = K / (w Y)` by more than none and less than a whole turn:
//! a linear map keeps what is above and below half a turn where it keeps orientation. On one of four parts `x - p` turns by 90 degrees
//! up to 18, `K` by 90 up to 60, `F` by more than none and less than half a turn. If all `Y` have determinants of one sign, `F` turns by
//! more than none and less than two turns around all of `B`, in the same sense: once. So its degree is one, and so is that of each of its
//! zeros, their determinants being of one sign: there is exactly one hit in `B`, the zero of one of the patches, on this patch.
//!
//! A seam is such a joint, of the first patch and the last, where the surface's borders there are one curve, exactly: then `F` is continuous over it.
//!
//! With determinants of two signs the line touches a kink or passes it: that is left open.

use super::certify::{Zone, zero_near};
use super::forms::Stabber;
use super::zeros::{Digits, HitAt, Place, RawHit};
use crate::numeric::{Ball, Dd};
use crate::prepare::{ParamMap, PreparedBrep};

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Half of the width of the zones, in local parameters.
const WIDTHS: [f64; 2] = [1.0 / (1u64 << 16) as f64, 1.0 / (1u64 << 32) as f64];
/// The contraction that the proof asks for.
const STRAIGHT: f64 = 0.25;
/// Half sides of `B` in those of the zones, which are about the zeros.
const WITHIN: f64 = 0.75;
/// How far zeros may be from the middle of `B`, in its half side; what is left of an eighth covers roundings.
const NEAR: f64 = 0.12;

/// Settles the hits of a face whose enclosures hold joints of its patches: of those that are one, one is kept. Where that is not known,
/// they are marked as not certain.
pub(super) fn settle(brep: &PreparedBrep, stab: &Stabber, hits: &mut Vec<RawHit>) {
    while let Some(index) = hits.iter().position(|h| h.inside && h.at_joint) {
        let Some(one) = one_of(brep, stab, hits, index) else {
            hits[index].inside = false;
            continue;
        };
        if let Some(kept) = one.kept {
            hits[kept].at_joint = false;
            hits[kept].t.rad = one.radius;
        }
        for i in (0..hits.len()).rev() {
            if one.listed.contains(&i) && one.kept != Some(i) {
                hits.remove(i);
            }
        }
    }
}

/// Hits that are one, at most.
struct One {
    listed: Vec<usize>,
    /// `None` where the one is not listed: outside of the region, or of the line's range.
    kept: Option<usize>,
    /// The radius of the kept one's `t`, so that it holds the others'.
    radius: f64,
}

/// A patch beside a joint or corner: its number, the middle of `B`, and where that is on a border of the patch, whether on the upper one.
struct Beside {
    patch: usize,
    middle: [f64; 2],
    ends: [Option<bool>; 2],
}

/// Whether a patch's zero is on it.
#[derive(Clone, Copy, PartialEq)]
enum On {
    Yes,
    No,
    Either,
}

fn one_of(brep: &PreparedBrep, stab: &Stabber, hits: &[RawHit], index: usize) -> Option<One> {
    let hit = &hits[index];
    let HitAt::Patch {
        patch, local, rho, ..
    } = hit.at
    else {
        return None;
    };
    let face = hit.face;
    let patches = &brep.double(face).patches;
    let around = star(brep, face, patch, local, rho)?;
    let zeros: Option<Vec<Zero>> = around.iter().map(|b| zero(stab, brep, face, b)).collect();
    let zeros = zeros?;
    if zeros.iter().any(|z| z.positive != zeros[0].positive) {
        return None;
    }
    // The half sides of `B`, in native parameters.
    let length = |b: &Beside, k: usize| {
        let length: Ball<f64> = patches.maps_of(b.patch)[k].length();
        length.mid
    };
    let sides = [0, 1].map(|k| {
        let all = around
            .iter()
            .zip(&zeros)
            .map(|(b, z)| z.half * length(b, k));
        WITHIN * all.fold(f64::INFINITY, f64::min)
    });
    let mut listed = Vec::new();
    let mut held: Vec<(On, Option<usize>)> = Vec::new();
    for (b, z) in around.iter().zip(&zeros) {
        let short = (0..2).fold(1.0, |m: f64, k| m.min(sides[k] / (z.half * length(b, k))));
        let near = |k: usize| (z.at[k].hi - b.middle[k]).abs() + z.rho <= NEAR * z.half * short;
        if !(near(0) && near(1)) {
            return None;
        }
        let mut own = None;
        for (i, h) in hits.iter().enumerate() {
            let HitAt::Patch {
                patch, local, rho, ..
            } = &h.at
            else {
                continue;
            };
            let same = (0..2).all(|k| (local[k] - z.at[k]).hi.abs() <= (rho + z.rho) * UP);
            if h.face == face && *patch == b.patch && same {
                // Else it may be another zero.
                if *rho > 0.25 * z.half {
                    return None;
                }
                listed.push(i);
                own = own.or(Some(i));
            }
        }
        held.push((z.is_on(b)?, own));
    }
    if !listed.contains(&index) {
        return None;
    }
    let all = |on: On| held.iter().filter(move |h| h.0 == on);
    let (sure, either) = (all(On::Yes).count(), all(On::Either).count());
    let kept = match (sure, either) {
        (1, _) => all(On::Yes).next()?.1,
        (0, 1) => all(On::Either).next()?.1,
        // All are listed, so that one holds all.
        (0, 2..) => {
            if all(On::Either).any(|h| h.1.is_none()) {
                return None;
            }
            all(On::Either).filter_map(|h| h.1).min()
        }
        _ => return None,
    };
    let radius = kept.map_or(0.0, |kept| {
        let t = hits[kept].t;
        listed.iter().fold(t.rad, |most, i| {
            let other = hits[*i].t;
            most.max(((other.mid - t.mid).hi.abs() + other.rad) * UP)
        })
    });
    Some(One {
        listed,
        kept,
        radius,
    })
}

/// The patches about the joint or corner that an enclosure holds, its own among them; `None` where it holds a border of the surface that is no
/// seam, or two opposite borders of its patch.
fn star(
    brep: &PreparedBrep,
    face: usize,
    patch: usize,
    local: [Dd; 2],
    rho: f64,
) -> Option<Vec<Beside>> {
    let patches = &brep.double(face).patches;
    let own = patches.maps_of(patch);
    let off = Dd::from(rho * UP);
    let mut ends = [None; 2];
    for k in 0..2 {
        ends[k] = match (local[k] - off <= Dd::ZERO, local[k] + off >= Dd::ONE) {
            (true, true) => return None,
            (true, false) => Some(false),
            (false, true) => Some(true),
            (false, false) => None,
        };
    }
    // A seam is a joint of the first and the last patch.
    let domain = brep.brep().surface(face).domain();
    let over_seam = |k: usize, end: bool| -> Option<f64> {
        let (at, other) = (domain[k].start, domain[k].end);
        let (here, there) = if end { (other, at) } else { (at, other) };
        let joint = if end { own[k].end } else { own[k].start };
        (joint == here && brep.meets_itself(face, k == 0)).then_some(there)
    };
    // Where another patch's border is the joint, and the middle of `B` on it.
    let beside = |other: &ParamMap, k: usize| -> Option<(Option<bool>, f64)> {
        let place = |end: bool| if end { 1.0 } else { 0.0 };
        let Some(end) = ends[k] else {
            return (*other == own[k]).then_some((None, local[k].hi));
        };
        if *other == own[k] {
            return Some((Some(end), place(end)));
        }
        let meets = match (over_seam(k, end), end) {
            (Some(there), true) => other.start == there,
            (Some(there), false) => other.end == there,
            (None, true) => own[k].meets(other),
            (None, false) => other.meets(&own[k]),
        };
        meets.then_some((Some(!end), place(!end)))
    };
    let around = (0..patches.len()).filter_map(|patch| {
        let maps = patches.maps_of(patch);
        let [(a, u), (b, v)] = [beside(&maps[0], 0)?, beside(&maps[1], 1)?];
        Some(Beside {
            patch,
            middle: [u, v],
            ends: [a, b],
        })
    });
    let around: Vec<Beside> = around.collect();
    let joints = ends.iter().flatten().count();
    (joints > 0 && around.len() == 1 << joints).then_some(around)
}

/// The zero of a patch near the middle of `B`.
struct Zero {
    at: [Dd; 2],
    rho: f64,
    /// Half of the width of the zone in which it is the only one.
    half: f64,
    /// Whether the determinant of `Y` is above zero.
    positive: bool,
}

impl Zero {
    /// `None` where it is near another joint or border.
    fn is_on(&self, b: &Beside) -> Option<On> {
        let off = Dd::from(self.rho * UP);
        let mut on = On::Yes;
        for k in 0..2 {
            let (low, high) = (self.at[k] - off, self.at[k] + off);
            let (inner, outer) = match b.ends[k] {
                None if low > Dd::ZERO && high < Dd::ONE => continue,
                None => return None,
                Some(false) => (low > Dd::ZERO, high < Dd::ZERO),
                Some(true) => (high < Dd::ONE, low > Dd::ONE),
            };
            if outer {
                return Some(On::No);
            }
            if !inner {
                on = On::Either;
            }
        }
        Some(on)
    }
}

fn zero(stab: &Stabber, brep: &PreparedBrep, face: usize, b: &Beside) -> Option<Zero> {
    let net = &brep.double_double(face).patches[b.patch].net;
    let root = stab.planes(net);
    let at = Place {
        face,
        patch: b.patch,
        net,
        root: &root,
        digits: Digits::All,
    };
    WIDTHS.iter().find_map(|half| {
        let made = |p: [f64; 2], y: [[f64; 2]; 2]| {
            if (0..2).any(|k| !((p[k] - b.middle[k]).abs() <= NEAR * half)) {
                return None;
            }
            let around = |k: usize| [p[k] - half, p[k] + half];
            let zone = Zone::over(&at, [around(0), around(1)], y)?;
            let det = Dd::product(y[0][0], y[1][1]) - Dd::product(y[0][1], y[1][0]);
            (zone.e <= STRAIGHT && det != Dd::ZERO).then_some((zone, det > Dd::ZERO))
        };
        let (at, rho, positive) = zero_near(stab, &at, b.middle, made)?;
        Some(Zero {
            at,
            rho,
            half: *half,
            positive,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::Brep;
    use crate::nurbs::{NurbsSurface, Surface};
    use crate::query::zeros::{FaceHits, face_hits};
    use crate::query::{LineKind, LineProbe};
    use nalgebra::{Point3, Vector3, Vector4};

    /// `z = -|x|`, of two patches: a line through the top is one hit, which is certain; of one that stays above there is none that is.
    #[test]
    fn what_is_known_of_hits_at_a_kink() {
        let rows = [-1.0, 0.0, 1.0f64];
        let net = rows
            .iter()
            .flat_map(|x| [-1.0, 1.0].map(|y| Vector4::new(*x, y, -x.abs(), 1.0)));
        let knots = [vec![0.0, 0.0, 0.5, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
        let surface = NurbsSurface::new([1, 1], [3, 2], net.collect(), knots).unwrap();
        let brep = PreparedBrep::new(Brep::from_surface(Surface::Nurbs(surface)).unwrap());
        for (direction, passes) in [
            ([0.0, 0.0, 1.0], true),
            ([0.5, 0.25, 1.0], true),
            ([1.0, 0.0, 0.0], false),
            ([1.0, 0.5, 0.25], false),
            ([-1.0, 2.0, 0.75], false),
        ] {
            let top = Point3::new(0.0, 0.25, 0.0);
            let probe = LineProbe::new(top, Vector3::from(direction), LineKind::Line);
            let stab = Stabber::new(&probe.unwrap());
            let mut found = FaceHits::default();
            face_hits(&brep, &stab, 0, Digits::All, &mut 10_000, &mut found).unwrap();
            let certain = found.hits.iter().filter(|h| h.is_certain(&stab)).count();
            let open = found.hits.len() - certain + found.open.len();
            assert_eq!(
                (certain, open == 0),
                (usize::from(passes), passes),
                "{direction:?}"
            );
        }
    }
}
