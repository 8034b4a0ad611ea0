//! The side of a point that is known to more digits than a f64 has, next to one piece of the boundary.
//!
//! # What is proven
//! Let `B` be the part of a box about the point that is in the open domain, a rectangle, and let only one part of the boundary meet
//! the box. It cuts `B` into two sets at most that do not meet the boundary and are each connected, so all inside or all outside: then a point
//! off the part is on the side of any point of `B` that is in the same set, and there may be one whose coordinates are f64: its side
//! is decided exactly.
//!
//! *A segment*: the sets are the two sides of its line, which are convex. Which one a point is in is the sign of a determinant
//! of homogeneous coordinates, in double-double with its error.
//!
//! *A part along which u and v both rise* (or both fall): the sets are that of the points left of and above some point of the part,
//! and that of the points right of and below one. Going left or up from `p` in the first, no point of the part is met: let `c` be on the part with
//! `c_u >= p_u`, `c_v <= p_v`, and let `c'` be on it with `c'_u <= p_u`, `c'_v >= p_v`; as `c'_u <= c_u`, and both rise, `c'_v <= c_v`. So
//! `c'_v = p_v = c_v`, which strictly rising allows only for `c' = c = p`: but `p` is off the part. Two points `p`, `q` of the set
//! are joined by way of `(min(p_u, q_u), max(p_v, q_v))`, which is in `B` as well. The second set likewise, and likewise where one coordinate rises and
//! the other falls, with u turned round. One point of the part that is strictly on the one side in u and on the other in v, in
//! double-double with its error, tells the set.

use super::decide::Part;
use super::piece::Piece;
use super::source::Ball3;
use super::split::Trend;
use super::{Side, TrimRegion};
use crate::numeric::bernstein::evaluate;
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
/// How many points of a part are tried: the search for one gains digits as a secant method does.
const TRIALS: usize = 40;

impl TrimRegion {
    /// The side of a point; `None` where what is said above does not tell.
    pub(crate) fn side_beside_part(&self, uv: [Ball<Dd>; 2]) -> Option<Side> {
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
            let (piece, part) = self.only_part(about)?;
            let border = Border::new(piece, part);
            let set = border.set_of(uv)?;
            let candidates = PLACES.iter().flat_map(|a| PLACES.map(|b| [*a, b]));
            let beside = candidates.filter_map(|by| {
                let at = [0, 1].map(|k| {
                    let x = uv[k].mid.hi + by[k] * half[k];
                    (domain[k].start < x && x < domain[k].end).then_some(x)
                });
                let at = [at[0]?, at[1]?];
                (border.set_of(at.map(Ball::exact))? == set).then_some(at)
            });
            let mut sides = beside.map(|at| self.side(Point2::new(at[0], at[1])).side);
            sides.find_map(|side| side.filter(|s| *s != Side::Boundary))
        })
    }
}

/// The only part of the boundary about.
struct Border<'a> {
    part: &'a Part,
    /// Its piece's control points.
    points: Vec<Ball3>,
}

impl<'a> Border<'a> {
    fn new(piece: &Piece, part: &'a Part) -> Self {
        Self {
            part,
            points: piece.source.balls(),
        }
    }

    /// In which of two sets a point is.
    fn set_of(&self, uv: [Ball<Dd>; 2]) -> Option<bool> {
        match self.points.as_slice() {
            [a, b] => is_above(a, b, uv),
            _ => self.is_beyond(uv),
        }
    }

    /// On which side of a part that rises or falls in both coordinates a point is. The point of the part that tells is sought
    /// where the two coordinates are off by the same share of the part's size, by the secant method within what is known.
    fn is_beyond(&self, uv: [Ball<Dd>; 2]) -> Option<bool> {
        let signs = self.part.trends.map(|t| match t {
            Trend::Up => Some(1.0),
            Trend::Down => Some(-1.0),
            Trend::Flat | Trend::Mixed => None,
        });
        let signs = [signs[0]?, signs[1]?];
        let shares = [0, 1].map(|k| {
            signs[k] / (self.part.hull[k][1] - self.part.hull[k][0]).max(f64::MIN_POSITIVE)
        });
        let ends = self.part.t.map(Dd::from);
        // Each end of what is left, with the level there, halved whenever the other end has moved twice.
        let mut known: [(Dd, Dd); 2] = [(ends[0], Dd::ZERO), (ends[1], Dd::ZERO)];
        let mut moved = None;
        for trial in 0..TRIALS {
            let t = match trial {
                0 | 1 => ends[trial],
                _ => {
                    let [(a, low), (b, high)] = known;
                    let t = a - low * ((b - a) / (high - low));
                    // Negated: what is not a number ends it, too.
                    if !(t > a && t < b) {
                        return None;
                    }
                    t
                }
            };
            let [x, y, w] = [0, 1, 2].map(|c| {
                let coordinate = self.points.iter().map(|p| p[c]);
                evaluate(coordinate.collect(), Ball { mid: t, rad: 0.0 })
            });
            let off = [x / w - uv[0], y / w - uv[1]];
            let sign = off.map(|x| {
                (x.mid.abs().hi > 2.0 * x.rad).then(|| if x.mid > Dd::ZERO { 1.0 } else { -1.0 })
            });
            if let [Some(a), Some(b)] = sign
                && a * signs[0] != b * signs[1]
            {
                return Some(a > 0.0);
            }
            let level = off[0].mid * Dd::from(shares[0]) + off[1].mid * Dd::from(shares[1]);
            let end = match trial {
                0 | 1 => trial,
                _ => usize::from(level > Dd::ZERO),
            };
            known[end] = (t, level);
            if trial > 1 && moved == Some(end) {
                known[1 - end].1 = known[1 - end].1.half();
            }
            moved = (trial > 1).then_some(end);
            if trial == 1 && !(known[0].1 < Dd::ZERO && known[1].1 > Dd::ZERO) {
                return None;
            }
        }
        None
    }
}

/// On which side of the line through two points with positive weights a point is.
fn is_above(a: &Ball3, b: &Ball3, [u, v]: [Ball<Dd>; 2]) -> Option<bool> {
    let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    let level = u * minor(1, 2) - v * minor(0, 2) + minor(0, 1);
    if level.mid.abs().hi > 2.0 * level.rad {
        Some(level.mid > Dd::ZERO)
    } else {
        None
    }
}
