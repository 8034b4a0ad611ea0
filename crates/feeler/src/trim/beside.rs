//! The side of a point that is known to more digits than a f64 has, next to pieces of the boundary.
//!
//! # What is proven
//! Let `B` be the part of a box about the point `p` that is in the domain, a rectangle. Another point `q` of it, with coordinates that are
//! f64, is joined to `p` by way of `(q_u, p_v)` or `(p_u, q_v)`, on two segments along u and v in `B`. If these do not meet the loops, the
//! parity of `p`, which is in the domain (on its border in coordinates that are known exactly, else within), is that of `q`, which is decided
//! exactly. They do not meet parts that do not meet the box; of a part that may, let `p`, `q` and the corner between them be in a common one of these sets:
//!
//! *A segment*, or a curve along which u or v does not change: one of the two sides of its line, which are convex. Which one a point is in
//! is the sign of a determinant of differences of coordinates, in double-double with its error.
//!
//! *Any part*: what is strictly left of its box, or right of it, or below, or above: half planes.
//!
//! *A part along which u and v both rise* (or both fall): the points left of and above some point of the part, those right of and below
//! one, those that are neither left of nor below its upper end, which is not one of them, and those neither right of nor above its lower end.
//! Going left or up from `p` in the first, no point of the part is met: let `c` be on the part with
//! `c_u >= p_u`, `c_v <= p_v`, and let `c'` be on it with `c'_u <= p_u`, `c'_v >= p_v`; as `c'_u <= c_u`, and both rise, `c'_v <= c_v`. So
//! `c'_v = p_v = c_v`, which strictly rising allows only for `c' = c = p`: but `p` is off the part. So of two points of the set on a line along
//! u or v, none between them is on the part. The second set likewise. In the third, of the part only its upper end could be between them, and
//! only where they are on both sides of it on a line through it: but one is then left of it or below. The fourth likewise, and likewise where
//! one coordinate rises and the other falls, with u turned round. One point of the part that is strictly on the one side in u and on the other
//! in v, or an end from which the point is strictly beyond in both, in double-double with its error, tells the set.

use super::decide::{Loops, Part};
use super::source::Ball3;
use super::split::Trend;
use super::{Side, TrimRegion};
use crate::numeric::bernstein::evaluate;
use crate::numeric::{Ball, Dd, Real};
use arrayvec::ArrayVec;
use nalgebra::Point2;

/// Half the widths of the boxes that are tried, as parts of the domain: the least keeps clear of other pieces, the largest has f64
/// numbers on both sides of any line through it.
const WIDTHS: [f64; 3] = [
    1.0 / (1u64 << 48) as f64,
    1.0 / (1u64 << 42) as f64,
    1.0 / (1u64 << 34) as f64,
];
/// Where in the box points are looked for, in both coordinates: some in each sector of a corner that is not all too narrow.
const PLACES: [f64; 5] = [-0.75, 0.75, -0.375, 0.375, 0.0];
/// So many parts near the point are looked at: no corner but a few has more.
const MOST_PARTS: usize = 4;
/// How many points of a part are tried: the search for one gains digits as a secant method does.
const TRIALS: usize = 40;

impl TrimRegion {
    /// The side of a point; `None` where what is said above does not tell.
    pub(crate) fn side_of_ball(&self, uv: [Ball<Dd>; 2]) -> Option<Side> {
        let domain = self.domain();
        let in_domain = |k: usize| {
            let (x, d) = (uv[k], domain[k]);
            if x.rad == 0.0 {
                return Dd::from(d.start) <= x.mid && x.mid <= Dd::from(d.end);
            }
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
            let near = self.parts_near::<MOST_PARTS>(about)?;
            let borders: ArrayVec<Border, MOST_PARTS> = near
                .into_iter()
                .map(|p| Border::new(self.loops(), p))
                .collect();
            let own: ArrayVec<Sets, MOST_PARTS> = borders.iter().map(|b| b.sets(uv)).collect();
            if own.contains(&0) {
                return None;
            }
            // Which of the sets two points share with the first, of each part one at least.
            let shared = |at: [[Ball<Dd>; 2]; 2]| {
                let mut all = borders.iter().zip(&own);
                all.all(|(border, own)| own & border.sets(at[0]) & border.sets(at[1]) != 0)
            };
            let candidates = PLACES.iter().flat_map(|a| PLACES.map(|b| [*a, b]));
            let beside = candidates.filter_map(|by| {
                let at = [0, 1].map(|k| {
                    let x = uv[k].mid.hi + by[k] * half[k];
                    x.clamp(domain[k].start, domain[k].end)
                });
                let [u, v] = at.map(Ball::exact);
                let corners = [[u, uv[1]], [uv[0], v]];
                corners.iter().any(|c| shared([[u, v], *c])).then_some(at)
            });
            let mut sides = beside.map(|at| self.side(Point2::new(at[0], at[1])).side);
            // Off all parts, it is on the boundary where it is on the border of the domain and the region is on the other side of that.
            sides.find_map(|side| match side? {
                Side::Boundary => Some(Side::Inside),
                other => Some(other),
            })
        })
    }
}

/// In which sets of a part of the boundary a point is, a bit each: see the module.
type Sets = u8;
/// On one side of it, and on the other.
const BESIDE: [Sets; 2] = [1, 2];
/// Beyond its start, and beyond its end.
const BEYOND: [Sets; 2] = [4, 8];
/// Below and above its box, along u and v.
const OFF: [[Sets; 2]; 2] = [[16, 32], [64, 128]];

/// A part of the boundary near the point.
struct Border<'a> {
    part: &'a Part,
    /// The range of its piece's parameter.
    t: [f64; 2],
    /// Its piece's control points.
    points: Vec<Ball3>,
}

impl<'a> Border<'a> {
    fn new(loops: &Loops, part: &'a Part) -> Self {
        Self {
            part,
            t: part.t(loops),
            points: part.piece(loops).source.balls(),
        }
    }

    /// In which sets a point is, as far as can be told.
    fn sets(&self, uv: [Ball<Dd>; 2]) -> Sets {
        let mut out = self.set_by_shape(uv).unwrap_or(0);
        for k in 0..2 {
            if uv[k].upper() < self.part.hull[k][0] {
                out |= OFF[k][0];
            } else if uv[k].lower() > self.part.hull[k][1] {
                out |= OFF[k][1];
            }
        }
        out
    }

    fn set_by_shape(&self, uv: [Ball<Dd>; 2]) -> Option<Sets> {
        let beside = |positive: bool| BESIDE[usize::from(positive)];
        if let [a, b] = self.points.as_slice() {
            return is_above(a, b, uv).map(beside);
        }
        if let Some(k) = self.part.trends.iter().position(|t| *t == Trend::Flat) {
            let [x, w] = [k, 2].map(|c| self.points[0][c]);
            return is_positive(uv[k] - x / w).map(beside);
        }
        self.set_by_points(uv)
    }

    /// Of a part that rises or falls in both coordinates. The point of the part that tells is sought
    /// where the two coordinates are off by the same share of the part's size, by the secant method within what is known.
    fn set_by_points(&self, uv: [Ball<Dd>; 2]) -> Option<Sets> {
        let signs = self.part.trends.map(|t| match t {
            Trend::Up => Some(1.0),
            Trend::Down => Some(-1.0),
            Trend::Flat | Trend::Mixed => None,
        });
        let signs = [signs[0]?, signs[1]?];
        let shares = [0, 1].map(|k| {
            signs[k] / (self.part.hull[k][1] - self.part.hull[k][0]).max(f64::MIN_POSITIVE)
        });
        let ends = self.t.map(Dd::from);
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
            if let [Some(a), Some(b)] = off.map(is_positive) {
                // Whether the part's point is ahead of the other, along the part, in each coordinate.
                let ahead = [a == (signs[0] > 0.0), b == (signs[1] > 0.0)];
                if ahead[0] != ahead[1] {
                    return Some(BESIDE[usize::from(a)]);
                }
                if trial < 2 && ahead[0] == (trial == 0) {
                    return Some(BEYOND[trial]);
                }
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

/// On which side of the line through two points with positive weights a point is. Differences come first: the points may be next to each other.
fn is_above(a: &Ball3, b: &Ball3, [u, v]: [Ball<Dd>; 2]) -> Option<bool> {
    let [a, b] = [a, b].map(|p| [p[0] / p[2], p[1] / p[2]]);
    is_positive((v - a[1]) * (b[0] - a[0]) - (u - a[0]) * (b[1] - a[1]))
}

/// The sign of a number, if it is known.
fn is_positive(x: Ball<Dd>) -> Option<bool> {
    (x.mid.abs().hi > 2.0 * x.rad).then(|| x.mid > Dd::ZERO)
}
