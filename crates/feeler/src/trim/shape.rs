//! What bounds a region: nothing, a rectangle, a convex polygon, or more.

use super::decide::Crossing;
use super::piece::Piece;
use super::region::{BoxSide, PieceOrigin, TrimRegion};
use crate::numeric::{Dd, Interval, Real};

/// What bounds the trimmed region of a face, as far as the machinery goes that it needs.
///
/// A rectangle or a convex polygon is one loop of straight pieces whose ends are f64 and meet exactly; it runs
/// once around, in either direction, and its corners may be cut by further points on its sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RegionShape {
    /// No loops: the whole domain.
    Whole,
    /// An empty list of loops: nothing.
    Nothing,
    /// Sides along u and v: `[[u_lo, u_hi], [v_lo, v_hi]]`. Sides of points are comparisons.
    Rectangle([[f64; 2]; 2]),
    /// A convex polygon of this many straight pieces.
    ConvexPolygon(usize),
    /// Anything else: so many pieces.
    General(usize),
}

impl TrimRegion {
    /// What bounds the region; proven, where it is not `General`. Cost: that of looking at each piece once.
    pub fn shape(&self) -> RegionShape {
        if self.untrimmed {
            return RegionShape::Whole;
        }
        let pieces = self.pieces().len();
        if pieces == 0 {
            return RegionShape::Nothing;
        }
        match self.rectangle {
            Some(r) => RegionShape::Rectangle(r),
            None if self.polygon().is_some_and(|p| is_convex(&p)) => {
                RegionShape::ConvexPolygon(pieces)
            }
            None => RegionShape::General(pieces),
        }
    }

    /// The corners of the region's only loop, if that is a polygon.
    fn polygon(&self) -> Option<Vec<[f64; 2]>> {
        let PieceOrigin::Trim { trim_loop, .. } = self.origins().next()? else {
            return None;
        };
        let mut origins = self.origins();
        let own = |o| matches!(o, PieceOrigin::Trim { trim_loop: l, .. } if l == trim_loop);
        if !self.gapless || !origins.all(own) {
            return None;
        }
        let segments: Option<Vec<_>> = self.loops().pieces.iter().map(Piece::segment).collect();
        let segments = segments?;
        // Ends that are known to be the same may still be different numbers here, where one was rounded.
        let next = segments.iter().cycle().skip(1);
        let joined = segments.iter().zip(next).all(|(a, b)| a[1] == b[0]);
        joined.then(|| segments.iter().map(|s| s[0]).collect())
    }

    /// The rectangle that the region's only loop runs around once.
    pub(super) fn find_rectangle(&self) -> Option<[[f64; 2]; 2]> {
        let corners = self.polygon()?;
        let next = corners.iter().cycle().skip(1);
        let along_axis = |(a, b): (&[f64; 2], &[f64; 2])| a[0] == b[0] || a[1] == b[1];
        if !corners.iter().zip(next).all(along_axis) || !is_convex(&corners) {
            return None;
        }
        let range = |k: usize| {
            let start = [f64::INFINITY, f64::NEG_INFINITY];
            corners
                .iter()
                .fold(start, |r, p| [r[0].min(p[k]), r[1].max(p[k])])
        };
        Some([range(0), range(1)])
    }
}

/// Whether a closed polygon turns one way only, once around, and has an area.
///
/// Every turn is to the same side (or none, going on straight) and less than half a turn, so the direction of the
/// sides runs monotonically around the circle; it returns after as many whole turns as it passes the direction of +u.
/// One turn makes a convex polygon (its sides are then met in the order of their directions, as on the border of their
/// convex hull).
fn is_convex(corners: &[[f64; 2]]) -> bool {
    let n = corners.len();
    let side = |i: usize| [corners[i % n], corners[(i + 1) % n]];
    let (mut way, mut turns) = (0, 0);
    for i in 0..n {
        let (s, t) = (side(i), side(i + 1));
        let (Some(s), Some(t)) = (direction(s), direction(t)) else {
            return false;
        };
        let Some(turn) = turn(s, t) else {
            return false;
        };
        if turn == 0 {
            // On straight, not back.
            let sign = |x: Dd| x.partial_cmp(&Dd::ZERO);
            if (0..2).any(|k| sign(s[k]) != sign(t[k])) {
                return false;
            }
            continue;
        }
        if way != 0 && turn != way {
            return false;
        }
        way = turn;
        turns += usize::from(is_upper(s) != is_upper(t));
    }
    // The direction passes +u once and -u once.
    way != 0 && turns == 2
}

/// Whether a direction is in `[+u, -u)`, counter-clockwise.
fn is_upper(d: [Dd; 2]) -> bool {
    d[1] > Dd::ZERO || (d[1] == Dd::ZERO && d[0] > Dd::ZERO)
}

/// From the first to the second point, exactly; `None` where they are one, or so far apart that a difference is no number.
fn direction([a, b]: [[f64; 2]; 2]) -> Option<[Dd; 2]> {
    let d = [0, 1].map(|k| Dd::difference(b[k], a[k]));
    let finite = d.iter().all(|x| x.hi.is_finite());
    (finite && a != b).then_some(d)
}

/// The sign of the turn from `s` to `t`: of `s x t`; `None` where double-double does not tell.
///
/// Where a factor is zero the products are exact: sides along the axes always tell.
fn turn(s: [Dd; 2], t: [Dd; 2]) -> Option<i32> {
    let (a, b) = (s[0] * t[1], s[1] * t[0]);
    let cross = a - b;
    let vanishes = |x: Dd, y: Dd| x == Dd::ZERO || y == Dd::ZERO;
    let (no_a, no_b) = (vanishes(s[0], t[1]), vanishes(s[1], t[0]));
    if no_a && no_b {
        return Some(0);
    }
    // Two products and a difference, 8 units each of what is at most |a| + |b|; what underflows is no proof.
    let size = a.hi.abs() + b.hi.abs();
    let error = 32.0 * Dd::UNIT * size;
    if !(size.is_finite() && error > f64::MIN_POSITIVE) {
        return None;
    }
    if cross.hi > error {
        Some(1)
    } else if cross.hi < -error {
        Some(-1)
    } else {
        None
    }
}

/// The side of a point relative to the loop around a rectangle.
pub(super) fn crossing(r: &[[f64; 2]; 2], q: [f64; 2]) -> Crossing {
    let outside = (0..2).any(|k| q[k] < r[k][0] || q[k] > r[k][1]);
    if outside {
        Crossing::Even
    } else if (0..2).any(|k| q[k] == r[k][0] || q[k] == r[k][1]) {
        Crossing::On
    } else {
        Crossing::Odd
    }
}

/// Where a closed box lies relative to a rectangle within a domain; see [`TrimRegion::classify_box`].
pub(super) fn box_side(r: &[[f64; 2]; 2], domain: &[Interval; 2], b: [[f64; 2]; 2]) -> BoxSide {
    if (0..2).any(|k| b[k][1] < r[k][0] || b[k][0] > r[k][1]) {
        return BoxSide::Outside;
    }
    // What of the box is not in the domain does not count, and sides of the rectangle along the domain's border may meet it.
    let inside = (0..2).all(|k| {
        let d = &domain[k];
        (b[k][0] > r[k][0] || r[k][0] == d.start) && (b[k][1] < r[k][1] || r[k][1] == d.end)
    });
    if inside {
        BoxSide::Inside
    } else {
        BoxSide::Mixed
    }
}
