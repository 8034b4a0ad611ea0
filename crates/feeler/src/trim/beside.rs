//! The side of a point that is known to more digits than a f64 has, next to a straight piece of the boundary.
//!
//! # What is proven
//! Let `B` be the part of a box about the point that is in the open domain, and let no piece of the boundary but one meet the box; let
//! that one be a segment. The line through it cuts `B` into two convex sets at most, and neither meets the boundary: each is all
//! inside or all outside. So a point off the line is on the side of any point of `B` that is on the same side of the line, and
//! there may be one whose coordinates are f64: its side is decided exactly. On which side of the line a point is, is the sign of a
//! determinant of homogeneous coordinates, in double-double with its error.

use super::{Side, TrimRegion};
use crate::numeric::{Ball, Dd, Real};
use nalgebra::Point2;

/// Half the widths of the boxes that are tried, as parts of the domain: the least keeps clear of other pieces, the largest has f64
/// numbers on both sides of any line through it.
const WIDTHS: [f64; 3] = [
    1.0 / (1u64 << 48) as f64,
    1.0 / (1u64 << 42) as f64,
    1.0 / (1u64 << 34) as f64,
];
/// Where in the box points are looked for.
const PLACES: [f64; 2] = [-0.75, 0.75];

impl TrimRegion {
    /// The side of a point; `None` where what is said above does not tell.
    pub(crate) fn side_beside_segment(&self, uv: [Ball<Dd>; 2]) -> Option<Side> {
        let domain = self.domain();
        let in_domain = |k: usize| {
            let (x, d) = (uv[k], domain[k]);
            let off = Dd::from((x.rad + 4.0 * Dd::UNIT * x.mid.magnitude()) * 1.01);
            x.mid - off > Dd::from(d.start) && x.mid + off < Dd::from(d.end)
        };
        if !(in_domain(0) && in_domain(1)) {
            return None;
        }
        WIDTHS.into_iter().find_map(|width| {
            let half = [0, 1].map(|k| width * domain[k].length());
            let about: [[f64; 2]; 2] =
                [0, 1].map(|k| [uv[k].lower() - half[k], uv[k].upper() + half[k]]);
            let only: [[Ball<Dd>; 3]; 2] = self.only_piece(about)?.try_into().ok()?;
            let above = is_above(&only, uv)?;
            let candidates = PLACES.iter().flat_map(|a| PLACES.map(|b| [*a, b]));
            let beside = candidates.filter_map(|by| {
                let at = [0, 1].map(|k| {
                    let x = uv[k].mid.hi + by[k] * half[k];
                    (domain[k].start < x && x < domain[k].end).then_some(x)
                });
                let at = [at[0]?, at[1]?];
                (is_above(&only, at.map(Ball::exact))? == above).then_some(at)
            });
            let mut sides = beside.map(|at| self.side(Point2::new(at[0], at[1])).side);
            sides.find_map(|side| side.filter(|s| *s != Side::Boundary))
        })
    }
}

/// On which side of the line through two points with positive weights a point is.
fn is_above([a, b]: &[[Ball<Dd>; 3]; 2], [u, v]: [Ball<Dd>; 2]) -> Option<bool> {
    let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    let level = u * minor(1, 2) - v * minor(0, 2) + minor(0, 1);
    if level.mid.abs().hi > 2.0 * level.rad {
        Some(level.mid > Dd::ZERO)
    } else {
        None
    }
}
