//! Where parts of boundary pieces lie to their patches: a trim that passes a border of patches has a piece on either side that goes on a little past it,
//! where what its patch's polynomials say is not the face.

use super::leaf::Cell;
use super::node::Node;
use super::outcome::Source;
use super::search::Search;
use super::shape::Shape;
use super::task::Arithmetic;
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::{Homogeneous, curve_jet, part_of};

const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

impl Search<'_> {
    /// How a part of a boundary piece lies to its patch, by its control points.
    pub(super) fn piece_place(&self, face: usize, index: usize, range: [f64; 2]) -> PiecePlace {
        if self.brep.double(face).piece(index).stays(range) {
            return PiecePlace {
                off: false,
                leaves: false,
            };
        }
        let geometry = self.brep.double_double(face);
        place_of(&geometry.piece(index).local, range)
    }

    /// Whether a boundary piece [leaves](PiecePlace::leaves) its patch anywhere: what is asked of it at most, and kept.
    pub(super) fn piece_leaves(&self, face: usize, index: usize) -> bool {
        let ask = |local: &[Homogeneous<Dd, 3>]| place_of(local, [0.0, 1.0]).leaves;
        self.brep.double_double(face).piece_leaves(index, ask)
    }

    /// Of a boundary piece that is beside its patch all along, and may only touch it at its own ends: at which; `None` of any other. (Trims that bulge by roundings
    /// over the border of a domain are so, from one end to the other: an end exactly on the border would be next to what is off it by less than any slack.)
    ///
    /// Between its ends a curve of Bezier is within its control points, with each of them at a positive weight. So where none is on the patch's side of a border, and one is
    /// beyond it, all of the curve is beyond but an end whose control point is exactly on it; and that is no place of the patch if it is beyond another border.
    /// What is beyond is on the next patch, which has a piece of the trim there (`cut_boundary`), or outside of the domain.
    pub(super) fn touches_only(&self, face: usize, index: usize) -> Option<[bool; 2]> {
        const BORDERS: [(usize, bool); 4] = [(0, false), (0, true), (1, false), (1, true)];
        let local = &self.brep.double_double(face).piece(index).local;
        let beyond = |p: &Homogeneous<Dd, 3>, (c, high): (usize, bool)| match high {
            true => p[c] - p[2],
            false => -p[c],
        };
        // Negated in effect: what is no number may be anywhere.
        let is_beside = |border: (usize, bool)| {
            let mut all = local.iter().map(|p| beyond(p, border));
            all.clone().any(|x| x.lower() > 0.0) && all.all(|x| x.lower() >= 0.0)
        };
        let border = BORDERS.into_iter().find(|b| is_beside(*b))?;
        let touches = |p: &Homogeneous<Dd, 3>| {
            beyond(p, border).upper() <= 0.0
                && !BORDERS.into_iter().any(|b| beyond(p, b).lower() > 0.0)
        };
        Some([local.first(), local.last()].map(|p| p.is_some_and(touches)))
    }

    /// A bound of `f` on what is on its patch of a part of a piece, too short to be halved, on which what is on the patch ends; and the best place there kept.
    ///
    /// Where `f` is convex on the part that bounds it. Where it is monotone it is least at one end of what is on the patch: at the end of the range, or at a place beyond which all
    /// is off the patch, known to more digits than ends of ranges have; `f` is no less on the rest than there.
    pub(super) fn crossing_bound<T: Real + Arithmetic>(
        &mut self,
        (face, index): (usize, usize),
        node: &Node<T>,
        shape: (&Shape, Dd),
    ) -> Option<Dd> {
        let source = Source::Piece { face, index };
        let (u, sign) = (node.u, shape.0.monotone[0]);
        if sign == 0 {
            if !(shape.0.convexity > 0.0) {
                return None;
            }
            let leaf = self.certify(source, &Cell::from(node), shape)?;
            self.try_point(source, leaf.p, false);
            return Some(leaf.lo);
        }
        let grows = sign > 0;
        let local = &self.brep.double_double(face).piece(index).local;
        let slack = border_slack(local);
        if !slack.is_finite() {
            return None;
        }
        let part = part_of(local, u.map(Dd::from));
        let least = usize::from(!grows);
        let at = |s: f64| {
            // What is rounded here is in the radius.
            Ball::exact(u[0]) + Ball::difference(u[1], u[0]) * Ball::<Dd>::exact(s)
        };
        let [on, off] = if depth_at(&part, least as f64) >= 0.0 {
            [least as f64; 2]
        } else {
            end_between(&part, least, slack)?
        };
        self.try_point(source, [at(on).mid, Dd::ZERO], false);
        let f = self
            .objective
            .value(self.net_dd(source)?, [at(off), Ball::ZERO]);
        Some(f.mid - Dd::from((f.rad + 4.0 * Dd::UNIT * f.mid.magnitude()) * UP))
    }

    /// Whether a part that is off its patch may begin or end at a parameter of a boundary piece.
    pub(super) fn piece_may_end(&self, face: usize, index: usize, at: f64) -> bool {
        let local = &self.brep.double_double(face).piece(index).local;
        let slack = Ball::exact(border_slack(local));
        // All control points of a part without length are this one.
        let (p, _) = curve_jet(local, Ball::exact(at));
        // Negated: what is no number may be anywhere.
        !(0..2).all(|c| {
            (p[c] + p[2] * slack).lower() >= 0.0 && (p[c] - p[2] - p[2] * slack).upper() <= 0.0
        })
    }

    /// Where a boundary piece comes to rest on its patch within a range, and the part of the range that is on it; `None` where no end of the range is. Both are proven to
    /// be on the patch, or to be off it by no more than twice the piece's [`border_slack`].
    pub(super) fn rest_on_patch(
        &self,
        (face, index): (usize, usize),
        range: [f64; 2],
    ) -> Option<(f64, [f64; 2])> {
        let local = &self.brep.double_double(face).piece(index).local;
        let slack = 2.0 * border_slack(local);
        if !slack.is_finite() {
            return None;
        }
        let part = on_patch(local, range, slack)?;
        let source = Source::Piece { face, index };
        let [at, _] = self.descend(source, [0.5 * (part[0] + part[1]), 0.0], [part, [0.0; 2]]);
        // Between two ends that are on it a piece may still be off.
        let on = depth_at(local, at) >= -slack;
        Some((if on { at } else { part[0] }, part))
    }
}

/// How the part of a curve over a range lies to the patch's square.
fn place_of(local: &[Homogeneous<Dd, 3>], range: [f64; 2]) -> PiecePlace {
    let slack = border_slack(local);
    let part = part_of(local, range.map(Dd::from));
    let off = is_off(&part, slack);
    let twice = 2.0 * slack;
    let leaves = !twice.is_finite()
        || part.iter().any(|p| {
            // Negated: what is no number may be anywhere.
            let near = twice * p[2].mid.hi;
            !(0..2).all(|c| (p[c].mid - p[2].mid).hi <= near && p[c].mid.hi >= -near)
        });
    PiecePlace { off, leaves }
}

/// Where a part of a boundary piece, along which what is on its patch ends, has its end, in parts of the range: the last place known to be on the patch, going from one end
/// of the range to the other (`to`), and one beyond which all is [off](PiecePlace::off) it. `None` where that is not found.
fn end_between(part: &[Homogeneous<Dd, 3>], to: usize, slack: f64) -> Option<[f64; 2]> {
    let ends = [1 - to, to].map(|end| end as f64);
    if !(depth_at(part, ends[0]) >= 0.0 && depth_at(part, ends[1]) < 0.0) {
        return None;
    }
    // Along the border that it passes the secant method gains digits; the depth may be that from another all the way to the border: of a trim along one that it bulges over by
    // roundings.
    let beyond = sides_at(part, ends[1]);
    let side = (0..beyond.len()).fold(0, |k, i| if beyond[i] < beyond[k] { i } else { k });
    let border = |depth: &dyn Fn(f64) -> f64| {
        let [from, to] = ends.map(|end| (end, depth(end)));
        border_between(depth, from, to, FINE * slack)
    };
    let mut on = border(&|t| sides_at(part, t)[side]);
    if !(depth_at(part, on) >= 0.0) {
        // It passes another first.
        on = border(&|t| depth_at(part, t));
    }
    let to = ends[1];
    let mut step = f64::EPSILON;
    while step < 1.0 {
        let off = on + (to - on) * step;
        let rest = part_of(part, [off.min(to), off.max(to)].map(Dd::from));
        if is_off(&rest, 0.0) {
            return Some([on, off]);
        }
        step *= 4.0;
    }
    None
}

/// Which part of the slack of a piece is still told from nothing at a single place, where no more is counted than the place's own roundings. Only a guide: how a place
/// lies is asked of itself.
const FINE: f64 = 1.0 / 64.0;

/// Whether all of a part is off its patch, by more than a slack, on one side.
fn is_off(part: &[Homogeneous<Dd, 3>], slack: f64) -> bool {
    let exact = Ball::exact(slack);
    (0..2).any(|c| {
        let below = |p: &Homogeneous<Dd, 3>| (p[c] + p[2] * exact).upper() < 0.0;
        let above = |p: &Homogeneous<Dd, 3>| (p[c] - p[2] - p[2] * exact).lower() > 0.0;
        part.iter().all(below) || part.iter().all(above)
    })
}

/// The part of a range of a boundary piece where that is on its patch: what matters of a range that passes the border. `None` where both ends are off the
/// patch: it is not looked for between them.
///
/// Its ends are proven to be on the patch, or to be off it by no more than a slack (a trim may begin on the border).
fn on_patch(local: &[Homogeneous<Dd, 3>], range: [f64; 2], slack: f64) -> Option<[f64; 2]> {
    let depth = |t: f64| depth_at(local, t);
    let [low, high] = range.map(|t| (t, depth(t)));
    match (low.1 >= 0.0, high.1 >= 0.0) {
        (true, true) => Some(range),
        (true, false) => Some([low.0, border_between(&depth, low, high, slack)]),
        (false, true) => Some([border_between(&depth, high, low, slack), high.0]),
        (false, false) => match (low.1 >= -slack, high.1 >= -slack) {
            (true, true) => Some(range),
            (true, false) => Some([low.0; 2]),
            (false, true) => Some([high.0; 2]),
            (false, false) => None,
        },
    }
}

/// How far within each border of its patch a point of a boundary piece is at least, in local parameters; negative where it may be off it.
fn sides(p: &Homogeneous<Dd, 3>) -> [f64; 4] {
    // (By how far it is from 1: what is below 1 by less than an ulp is bounded by 1 and more in f64.)
    [p[0], p[1], p[2] - p[0], p[2] - p[1]].map(|x| {
        let low = x.lower() / p[2].mid.hi;
        // What is no number is nowhere.
        if low.is_nan() { f64::NEG_INFINITY } else { low }
    })
}

/// How far within its patch it is at least.
pub(super) fn depth(p: &Homogeneous<Dd, 3>) -> f64 {
    sides(p).into_iter().fold(f64::INFINITY, f64::min)
}

/// The same at a parameter.
fn depth_at(local: &[Homogeneous<Dd, 3>], t: f64) -> f64 {
    depth(&curve_jet(local, Ball::exact(t)).0)
}

fn sides_at(local: &[Homogeneous<Dd, 3>], t: f64) -> [f64; 4] {
    sides(&curve_jet(local, Ball::exact(t)).0)
}

/// Where a piece leaves its patch, or passes one border of that, given its depth, between a parameter where it is on it and one where it is not: up to a slack where it still is on
/// it, by the secant method (the Illinois rule).
fn border_between(
    depth: &dyn Fn(f64) -> f64,
    (mut on, above): (f64, f64),
    (mut off, below): (f64, f64),
    slack: f64,
) -> f64 {
    /// The number of digits grows by half with each, once it is near.
    const STEPS: usize = 16;
    /// Where the other end is all but on the border a step goes no nearer to it than this.
    const NEAREST: f64 = 1.0 - 1.0 / (1u64 << 20) as f64;
    if above <= slack {
        return on;
    }
    let mut weights = [above, below];
    let mut last = None;
    for _ in 0..STEPS {
        let part = weights[0] / (weights[0] - weights[1]);
        let t = on + (off - on) * part.min(NEAREST);
        if t == on || t == off {
            break;
        }
        let found = depth(t);
        let side = usize::from(found < 0.0);
        if side == 0 {
            on = t;
        } else {
            off = t;
        }
        weights[side] = found;
        if last == Some(side) {
            weights[1 - side] *= 0.5;
        }
        last = Some(side);
        if side == 0 && found <= slack {
            break;
        }
    }
    on
}

/// Where a part of a boundary piece lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct PiecePlace {
    /// Whether all of it is proven to lie off its patch: by more than the piece's [`border_slack`].
    pub(super) off: bool,
    /// Whether some control point lies off its patch, by more than twice that as computed.
    pub(super) leaves: bool,
}

/// How far off its patch a boundary piece may be, in local parameters, and still be taken for on it: so far that what its control points are
/// off does not matter.
///
/// Let `|x| <= m w` for all coordinates of its control points, each known within `r w`. Those of a part over a range are averages of them, made in `2 p`
/// levels of three roundings, whose factors are off by less than five more: off by at most `16 p u m + r` times the true ones' weights, and `s - w` by twice that. That is an eighth of the slack `e`. So a
/// part that does not [leave](PiecePlace::leaves) its patch is within `9/4 e` of it; one that is [off](PiecePlace::off) is farther than `e` from
/// it all along. What leaves and is not off is put aside by its bound alone. What is off is put aside without any: where the curve comes to it from a
/// part that does not leave, the end that both share [is seen](Search::piece_may_end) to be as far off, and that part is not put aside by a slope towards
/// that end: the curve ends there, or a little before.
fn border_slack(local: &[Homogeneous<Dd, 3>]) -> f64 {
    let (mut most, mut known) = (1.0f64, 0.0f64);
    for p in local {
        let w = p[2].lower();
        if !(w > 0.0) {
            return f64::INFINITY;
        }
        for x in p {
            most = most.max(x.mid.magnitude() / w);
            known = known.max(x.rad / w);
        }
    }
    let degree = local.len() as f64 - 1.0;
    16.0 * (16.0 * degree * Dd::UNIT * most + known) * UP
}

#[cfg(test)]
mod tests;
