//! The side of a small box next to a trim: nearer to it than native parameters tell.
//!
//! # What is proven
//! The trims of the region, on one patch, lie on its [boundary pieces](crate::prepare::Piece), whose control points are known in double-double. Let `B` be a box in the
//! patch's local square, and `y` a native parameter next to it that is on the patch. Pieces are cut into parts; one counts unless the box of its control points
//! does not meet a box that holds `B` and `y`, and with them their convex hull. If for each part that counts there is a normal `n` and a number `s` with `n.x <= s` for its control points,
//! and `n.x > s` on `B` and for `y`, the part does not meet the hull (half-planes are convex). If none does, the hull is on one side of the region, which is
//! that of `y`: the exact test tells.
//!
//! Next to a border of the patch that other patches share, pieces of those may be the trim's, up to their slack: nothing is said of boxes there.
//!
//! Each part is cut no further than it takes. Of a trim that is seen to pass through the box nothing is said, which is always right; where a hundred cuts do not tell, nothing is said.

use super::search::Search;
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::{Homogeneous, halves_of};
use crate::trim::{BoxSide, Side};
use arrayvec::ArrayVec;
use nalgebra::Point2;

/// How many parts are looked at.
const MOST_PARTS: usize = 512;
/// How many parts next to a box are told: two trims that meet there, cut once or twice.
const MOST_NEAR: usize = 8;
/// How far from the box, in ulps of the larger end of the patch's parameters, the points are that tell its side.
const AWAY: f64 = 4.0;
/// Nearer to a border that is shared nothing is said.
const SHARED: f64 = 1.0 / (1u128 << 80) as f64;
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// A point of the local square.
type Local = [Ball<Dd>; 2];

/// A box about a point, in local parameters.
struct Around {
    p: [Dd; 2],
    r: [f64; 2],
}

impl Search<'_> {
    /// The side of what is within `r` of `p` on a patch; mixed where that is not told.
    pub(super) fn side_around(
        &self,
        (face, patch): (usize, usize),
        p: [Dd; 2],
        r: [f64; 2],
    ) -> BoxSide {
        let around = Around { p, r };
        if self.is_next_to_shared(face, patch, &around) {
            return BoxSide::Mixed;
        }
        let tellers = self.tellers(face, patch, &around);
        let Some(zone) = zone(&around, &tellers) else {
            return BoxSide::Mixed;
        };
        let geometry = self.brep.double_double(face);
        let mut near = ArrayVec::new();
        let mut left = MOST_PARTS;
        for index in 0..geometry.piece_count() {
            if geometry.piece_patch(index) == patch {
                let local = &geometry.piece(index).local;
                if !around.take_near(local, &zone, &mut near, &mut left) {
                    return BoxSide::Mixed;
                }
            }
        }
        for (uv, local) in &tellers {
            if near.iter().all(|normal| around.is_before(normal, local)) {
                return match self.brep.region(face).side(*uv).side {
                    Some(Side::Inside) => BoxSide::Inside,
                    Some(Side::Outside) => BoxSide::Outside,
                    _ => BoxSide::Mixed,
                };
            }
        }
        BoxSide::Mixed
    }

    /// Whether a box is next to a border of its patch that is none of the surface.
    fn is_next_to_shared(&self, face: usize, patch: usize, around: &Around) -> bool {
        let maps = self.brep.double_double(face).patches.maps_of(patch);
        let domain = self.brep.brep().surface(face).domain();
        (0..2).any(|k| {
            let more = Dd::from(around.r[k] + SHARED);
            let low = around.p[k] - more <= Dd::ZERO && maps[k].start != domain[k].start;
            let high = around.p[k] + more >= Dd::ONE && maps[k].end != domain[k].end;
            low || high
        })
    }

    /// Native parameters of a patch on all sides of a box, and where they are on it.
    fn tellers(
        &self,
        face: usize,
        patch: usize,
        around: &Around,
    ) -> ArrayVec<(Point2<f64>, Local), 8> {
        let maps = self.brep.double_double(face).patches.maps_of(patch);
        let at = |k: usize, steps: f64| {
            let map = &maps[k];
            let ulp = f64::EPSILON * map.start.abs().max(map.end.abs());
            let native = map.nearest_native(around.p[k]);
            (native + AWAY * ulp * steps).max(map.start).min(map.end)
        };
        let sides = [-1.0, 0.0, 1.0];
        let all = sides
            .iter()
            .flat_map(|u| sides.iter().map(move |v| [*u, *v]));
        let beside = all.filter(|s| *s != [0.0, 0.0]);
        beside
            .map(|[u, v]| {
                let uv = [at(0, u), at(1, v)];
                let local = [0, 1].map(|k| maps[k].to_local(Ball::exact(uv[k])));
                (Point2::from(uv), local)
            })
            .collect()
    }
}

/// A box that holds one about a point, and some points; `None` where that is no number.
fn zone(around: &Around, points: &[(Point2<f64>, Local)]) -> Option<[[f64; 2]; 2]> {
    let mut out = [[0.0; 2]; 2];
    for (k, range) in out.iter_mut().enumerate() {
        let r = Dd::from((around.r[k] + 4.0 * Dd::UNIT) * UP);
        *range = [(around.p[k] - r).floor_f64(), (around.p[k] + r).ceil_f64()];
        for (_, local) in points {
            *range = [
                range[0].min(local[k].lower()),
                range[1].max(local[k].upper()),
            ];
        }
    }
    let finite = out.iter().flatten().all(|x| x.is_finite());
    finite.then_some(out)
}

/// What a part is not beyond, and a box is.
struct Normal {
    n: [f64; 2],
    /// `n.x <= n.p - gap` on the part, and nowhere on the box about `p`.
    gap: f64,
}

impl Around {
    /// Adds the normals of those parts of a piece that meet a zone; whether all of them have one.
    fn take_near(
        &self,
        piece: &[Homogeneous<Dd, 3>],
        zone: &[[f64; 2]; 2],
        near: &mut ArrayVec<Normal, MOST_NEAR>,
        left: &mut usize,
    ) -> bool {
        // Of a trim that passes through the box nothing is told, however it is cut.
        if [piece.first(), piece.last()]
            .into_iter()
            .flatten()
            .any(|p| self.holds(p))
        {
            return false;
        }
        let mut open = vec![piece.to_vec()];
        while let Some(part) = open.pop() {
            if *left == 0 {
                return false;
            }
            *left -= 1;
            if is_clear(&part, zone) {
                continue;
            }
            if let Some(normal) = self.normal(&part) {
                if near.try_push(normal).is_err() {
                    return false;
                }
                continue;
            }
            let [low, high] = halves_of(&part);
            if high.first().is_some_and(|p| self.holds(p)) {
                return false;
            }
            // The one that is nearer to the box comes first: that is where the box is passed, if it is.
            let is_low_nearer = self.off(low.first()) < self.off(high.last());
            open.extend(if is_low_nearer {
                [high, low]
            } else {
                [low, high]
            });
        }
        true
    }

    /// A normal of a part's chord such that the part is below the box.
    fn normal(&self, part: &[Homogeneous<Dd, 3>]) -> Option<Normal> {
        let [first, .., last] = part else { return None };
        let at = |p: &Homogeneous<Dd, 3>, k: usize| (p[k] / p[2]).mid;
        let chord = [0, 1].map(|k| (at(last, k) - at(first, k)).hi);
        let size = chord[0].abs().max(chord[1].abs());
        // (Of a size at which nothing that follows is lost.)
        let n = [-chord[1] / size, chord[0] / size];
        if !(size > 0.0 && n.iter().all(|x| x.is_finite())) {
            return None;
        }
        let side = (0..2).map(|k| n[k] * (at(first, k) - self.p[k]).hi);
        let n = if side.sum::<f64>() < 0.0 {
            n
        } else {
            n.map(|x| -x)
        };
        // How far the box reaches along it.
        let reach = (n[0].abs() * self.r[0] + n[1].abs() * self.r[1]) * UP;
        let mut gap = f64::INFINITY;
        for x in part {
            let along = |k: usize| Ball::exact(n[k]) * (x[k] - x[2] * self.center(k));
            let below = (-(along(0) + along(1)) / x[2]).lower();
            // Negated: what is no number is nowhere.
            if !(below > reach) {
                return None;
            }
            gap = gap.min(below);
        }
        Some(Normal { n, gap })
    }

    /// Whether a point is in the box for certain.
    fn holds(&self, x: &Homogeneous<Dd, 3>) -> bool {
        (0..2).all(|k| {
            let off = x[k] / x[2] - self.center(k);
            -self.r[k] < off.lower() && off.upper() < self.r[k]
        })
    }

    /// How far a point is from the middle of the box, about.
    fn off(&self, x: Option<&Homogeneous<Dd, 3>>) -> f64 {
        let off = |x: &Homogeneous<Dd, 3>, k: usize| (x[k].mid / x[2].mid - self.p[k]).hi.abs();
        x.map_or(f64::INFINITY, |x| off(x, 0).max(off(x, 1)))
    }

    fn center(&self, k: usize) -> Ball<Dd> {
        Ball {
            mid: self.p[k],
            rad: 0.0,
        }
    }

    /// Whether a point is on the side of the box, of a part with a normal.
    fn is_before(&self, normal: &Normal, local: &Local) -> bool {
        let along = |k: usize| Ball::exact(normal.n[k]) * (local[k] - self.center(k));
        (along(0) + along(1)).lower() > -normal.gap
    }
}

/// Whether the box of a part's control points does not meet a zone.
fn is_clear(part: &[Homogeneous<Dd, 3>], zone: &[[f64; 2]; 2]) -> bool {
    (0..2).any(|k| {
        let [low, high] = zone[k].map(Ball::<Dd>::exact);
        let below = |p: &Homogeneous<Dd, 3>| (p[k] - p[2] * low).upper() < 0.0;
        let above = |p: &Homogeneous<Dd, 3>| (p[k] - p[2] * high).lower() > 0.0;
        part.iter().all(below) || part.iter().all(above)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola `y = x (1 - x)` past a box about `(1/3, 2/9 + off)`: what passes beside it has normals, and what passes through it is not cut until no parts are left. From 1 to the
    /// box it takes 30 halvings, of two parts each.
    #[test]
    fn a_trim_through_the_box_is_found_soon() {
        const RADIUS: f64 = 1.0 / (1u64 << 30) as f64;
        const SOON: usize = 2 * 30 + 4;
        let ends = [[0.0, 0.0], [0.5, 0.5], [1.0, 0.0]];
        let piece = ends.map(|[x, y]| [x, y, 1.0].map(Ball::<Dd>::exact));
        for (off, passes_beside) in [(0.0, false), (0.5 * RADIUS, false), (8.0 * RADIUS, true)] {
            let around = Around {
                p: [1.0 / 3.0, 2.0 / 9.0 + off].map(Dd::from),
                r: [RADIUS; 2],
            };
            let zone = [0, 1].map(|k| [-16.0, 16.0].map(|x| around.p[k].hi + x * RADIUS));
            let (mut near, mut left) = (ArrayVec::new(), MOST_PARTS);
            let told = around.take_near(&piece, &zone, &mut near, &mut left);
            assert_eq!(told, passes_beside, "{off}");
            assert!(MOST_PARTS - left <= SOON, "{off}: {left}");
        }
    }
}
