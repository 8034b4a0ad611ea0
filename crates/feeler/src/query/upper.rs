//! Upper bounds: points of the BREP where the objective is evaluated, and the descent that finds them.

use super::beside::depth;
use super::leaf::Leaf;
use super::objective::{Guide, Objective};
use super::outcome::{Foot, Locus, Rough, Source};
use super::search::Search;
use super::trail::Hint;
use crate::numeric::{Ball, Dd, Td};
use crate::prepare::{Homogeneous, Net, Patches, Seed, jet};
use crate::trim::{BoxSide, Side};
use nalgebra::Point2;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

impl Search<'_> {
    pub(super) fn guide_value(&self, source: Source, p: [f64; 2]) -> f64 {
        self.net(source).map_or(f64::INFINITY, |net| {
            self.objective.guide_value(net, p[0], p[1])
        })
    }

    /// Descends from a point in a box, on which nothing is below `least`, and keeps what is there, if it may be lower than what is known: by
    /// the value and by what a Newton step promises. Only a guide: what is not tried here is searched all the same.
    pub(super) fn look_down(
        &mut self,
        source: Source,
        p: [f64; 2],
        (range, least): ([[f64; 2]; 2], f64),
    ) {
        let Some(net) = self.net(source) else {
            return self.try_rough_point(source, p);
        };
        let hi = self.out.hi.hi;
        let chosen = hi.is_finite() && self.goal.all_below.is_none();
        // Of trims, which are many and of high degree, a value alone is found in a fraction of the time of its derivatives: half of what is above
        // the bound may be gained.
        if let (true, Source::Piece { .. }) = (chosen, source)
            && 0.5 * (self.objective.guide_value(net, p[0], p[1]) + least) > hi
        {
            return;
        }
        let g = self.objective.guide(net, p[0], p[1]);
        if chosen {
            let step = newton_step(g.slope, g.curvature, blocked(p, g.slope, [[0.0, 1.0]; 2]));
            // Half of it for a quadratic function; the whole, to be generous.
            let gain = g.slope[0] * step[0] + g.slope[1] * step[1];
            // Negated: what is no number promises nothing.
            if !(g.value + gain < hi) {
                return;
            }
        }
        let p = self.descend_from(net, (p, g), range);
        self.try_rough_point(source, p);
    }

    /// Descends from where an earlier query ended. What is no place of this BREP is passed over; a closed form needs no start.
    pub(super) fn try_hint(&mut self, hint: Hint) {
        let face = hint.face;
        if face >= self.brep.brep().faces().len() || self.closed(face).is_some() {
            return;
        }
        let pieces = self.brep.double(face).piece_count();
        if let Some((index, t)) = hint.piece.filter(|(index, _)| *index < pieces) {
            // On the border the next one mostly is, too; the way down on the patch would leave the region.
            let source = Source::Piece { face, index };
            let p = self.descend(source, [t, 0.0], [[0.0, 1.0], [0.0; 2]]);
            self.try_rough_point(source, p);
            if self.out.foot.is_some() {
                return;
            }
        }
        let patches = &self.brep.double(face).patches;
        let known = hint.local.filter(|(index, _)| *index < patches.len());
        let Some((index, local)) = known.or_else(|| patch_at(patches, hint.uv)) else {
            return;
        };
        let source = Source::Patch { face, index };
        let start = hint.ahead.unwrap_or(local);
        let p = self.descend(source, start, [[0.0, 1.0]; 2]);
        let net = &patches[index].net;
        if jet::fits(net.degree) {
            let rough = Rough::new(self.objective, net, source, p);
            self.out.rough = Some(match self.memory.rough.take() {
                Some(mut spare) => {
                    *spare = rough;
                    spare
                }
                None => Box::new(rough),
            });
        }
        self.try_rough_point(source, p);
        if self.out.foot.is_none() {
            // The way down left the region: the place itself was on its border.
            self.try_rough_point(source, local);
        }
    }

    /// Descends from the best of a face's seeds.
    pub(super) fn try_seed(&mut self, face: usize) {
        let seeds = self.brep.double(face).seeds();
        let value = |s: &Seed| match self.objective {
            Objective::SquaredDistance(q) => (s.point - q).norm_squared(),
            Objective::Height(n, _) => n.dot(&s.point.coords),
        };
        let (mut least, mut best) = (f64::INFINITY, 0);
        for (index, seed) in seeds.iter().enumerate() {
            let own = value(seed);
            if own < least {
                (least, best) = (own, index);
            }
        }
        if let Some(best) = seeds.get(best) {
            let source = Source::Patch {
                face,
                index: best.patch(),
            };
            self.look_down(source, best.local(), ([[0.0, 1.0]; 2], f64::NEG_INFINITY));
        }
    }

    /// A projected, damped Newton descent in f64 within a box. No proof rests on it.
    pub(super) fn descend(
        &self,
        source: Source,
        start: [f64; 2],
        range: [[f64; 2]; 2],
    ) -> [f64; 2] {
        let Some(net) = self.net(source) else {
            return start;
        };
        let g = self.objective.guide(net, start[0], start[1]);
        self.descend_from(net, (start, g), range)
    }

    fn descend_from(
        &self,
        net: &Net<f64>,
        (mut p, mut g): ([f64; 2], Guide),
        range: [[f64; 2]; 2],
    ) -> [f64; 2] {
        let mut last_steps = LAST_STEPS;
        for _ in 0..MAX_NEWTON {
            let blocked = blocked(p, g.slope, range);
            if blocked[0] && blocked[1] {
                break;
            }
            let mut step = newton_step(g.slope, g.curvature, blocked);
            let moved = |step: [f64; 2]| -> [f64; 2] {
                std::array::from_fn(|k| (p[k] + step[k]).clamp(range[k][0], range[k][1]))
            };
            let convex = g.curvature[0] * g.curvature[2] > g.curvature[1] * g.curvature[1];
            let gain = (g.slope[0] * step[0] + g.slope[1] * step[1]).abs();
            // What is left after the step is of the order of its square.
            if convex && gain < LITTLE * g.value.abs() {
                return moved(step);
            }
            if gain < NOISE * g.value.abs() {
                // The value no longer shows whether a step is good, but the slope still does, unless it is noise too.
                let length = step[0].abs() + step[1].abs();
                if length > MOST_BLIND {
                    break;
                }
                last_steps -= 1;
                if length < SHORT || last_steps == 0 {
                    return moved(step);
                }
                p = moved(step);
                g = self.objective.guide(net, p[0], p[1]);
                continue;
            }
            let mut better = None;
            for _ in 0..MAX_DAMPING {
                let next = moved(step);
                if next == p {
                    break;
                }
                let trial = self.objective.guide(net, next[0], next[1]);
                if trial.value < g.value {
                    better = Some((next, trial));
                    break;
                }
                step = step.map(|x| 0.5 * x);
            }
            match better {
                Some(next) => (p, g) = next,
                None => break,
            }
        }
        p
    }

    /// Evaluates a point of a patch or a piece at exact local parameters as cheaply as serves, and keeps it if it is the best so
    /// far and in the region.
    pub(super) fn try_rough_point(&mut self, source: Source, p: [f64; 2]) {
        if let (Source::Patch { face, index }, Some(net)) = (source, self.net(source))
            && jet::fits(net.degree)
        {
            let side = self.classify(face, index, [p[0]; 2], [p[1]; 2]);
            if side == BoxSide::Outside {
                // Nor do its neighbours count, which an exact test would be asked about: what is on a trim is found along its pieces.
                return;
            }
            let value = match (side, self.out.rough_at(source, p)) {
                (BoxSide::Mixed, _) => None,
                (_, Some(rough)) => Some(rough.sample.value()),
                (_, None) => Some(self.objective.rough_value(net, p)),
            };
            let size = self.brep.size();
            let scale = if self.objective.is_squared() {
                size * size
            } else {
                size
            };
            // Weights of very different sizes leave f64 without a bound.
            if let Some(value) = value.filter(|v| v.rad <= ROUGH_SLACK * scale) {
                let foot = self.patch_foot(face, index, p.map(Ball::exact), None);
                return self.keep(value, foot);
            }
        }
        self.try_point(source, p.map(Dd::from), false);
    }

    /// Evaluates the best point so far again in double-double.
    pub(super) fn sharpen(&mut self) {
        let Some(foot) = self.out.foot else { return };
        if let (Some((Source::Patch { face, index }, _)), Locus::Patch { local, .. }) =
            (foot.found, foot.spot)
        {
            let net = &self.brep.double_double(face).patches[index].net;
            let value = self.objective.value(net, local);
            self.keep(value, foot);
        }
    }

    /// Keeps the point of a leaf; `inside` says that it is known to be in the region.
    pub(super) fn keep_leaf(&mut self, source: Source, leaf: &Leaf, inside: bool) {
        let (p, value) = (leaf.p, leaf.value);
        match source {
            Source::Patch { face, index } if inside => {
                let local = p.map(|mid| Ball { mid, rad: 0.0 });
                let foot = self.patch_foot(face, index, local, leaf.point);
                self.keep(value, foot);
            }
            Source::Piece { face, index } => match self.piece_foot(face, index, p[0]) {
                Ok(foot) => self.keep(value, foot),
                Err(local) => self.try_beside_piece(face, index, local),
            },
            Source::Patch { .. } => self.try_point(source, p, false),
        }
    }

    /// Evaluates a point and keeps it if it is the best so far and in the region; `trusted` says
    /// that it is known to be in the region.
    pub(super) fn try_point(&mut self, source: Source, p: [Dd; 2], trusted: bool) {
        let rough = self.guide_value(source, [p[0].hi, p[1].hi]);
        // A rough value may be off by a few roundings; f64 noise in it must not lose a better point.
        let hi = self.out.hi.hi;
        if rough > hi + ROUGH_SLACK * (hi.abs() + self.brep.size()) {
            return;
        }
        match source {
            Source::Patch { face, index } if trusted => {
                self.keep_patch_point(face, index, p.map(|mid| Ball { mid, rad: 0.0 }));
            }
            Source::Patch { face, index } => self.try_patch_point(face, index, p, None),
            Source::Piece { face, index } => self.try_piece_point(face, index, p[0]),
        }
    }

    fn try_patch_point(&mut self, face: usize, patch: usize, p: [Dd; 2], trim: Option<usize>) {
        let maps = self.brep.double_double(face).patches.maps_of(patch);
        let at = |k: usize| maps[k].nearest_native(p[k]);
        let center = [at(0), at(1)];
        // The point itself, then its neighbours in f64, for points on a trim.
        for (du, dv) in NEIGHBOURS {
            let uv = [step_ulp(center[0], du), step_ulp(center[1], dv)];
            let within = |k: usize| maps[k].start <= uv[k] && uv[k] <= maps[k].end;
            if !(within(0) && within(1)) {
                continue;
            }
            let side = self.brep.region(face).side(Point2::new(uv[0], uv[1])).side;
            if !matches!(side, Some(Side::Inside | Side::Boundary)) {
                continue;
            }
            let local = [0, 1].map(|k| maps[k].to_local(Ball::<Dd>::exact(uv[k])));
            let source = Source::Patch { face, index: patch };
            let value = self.fine_value(source, local, || {
                [0, 1].map(|k| maps[k].to_local(Ball::exact(uv[k])))
            });
            let foot = Foot {
                face,
                trim,
                uv: Point2::new(uv[0], uv[1]),
                spot: Locus::Patch {
                    patch,
                    local,
                    point: None,
                },
                found: Some((
                    Source::Patch { face, index: patch },
                    local.map(|x| x.mid.hi),
                )),
            };
            return self.keep(value, foot);
        }
    }

    /// A point of a patch that is known to be in the region.
    fn patch_foot(
        &self,
        face: usize,
        patch: usize,
        local: [Ball<Dd>; 2],
        point: Option<Homogeneous<Dd, 4>>,
    ) -> Foot {
        let maps = &self.brep.double(face).patches[patch].maps;
        let at = local.map(|x| x.mid.hi);
        Foot {
            face,
            trim: None,
            uv: Point2::from([0, 1].map(|k| maps[k].to_native(local[k].mid))),
            spot: Locus::Patch {
                patch,
                local,
                point,
            },
            found: Some((Source::Patch { face, index: patch }, at)),
        }
    }

    fn keep_patch_point(&mut self, face: usize, patch: usize, local: [Ball<Dd>; 2]) {
        let source = Source::Patch { face, index: patch };
        let value = self.fine_value(source, local, || raised(local));
        let foot = self.patch_foot(face, patch, local, None);
        self.keep(value, foot);
    }

    /// `f` at a point in double-double, or where that loses the digits that are wanted of the best point so far, in triple-double.
    fn fine_value(
        &self,
        source: Source,
        local: [Ball<Dd>; 2],
        finest: impl FnOnce() -> [Ball<Td>; 2],
    ) -> Ball<Dd> {
        let Some(net) = self.net_dd(source) else {
            return NOTHING_KNOWN;
        };
        let value = self.objective.value(net, local);
        let may_be_best = value.mid - Dd::from(value.rad * UP) < self.out.hi;
        if may_be_best
            && self.is_lost(value)
            && let Some(net) = self.net_in::<Td>(source)
        {
            let [s, t] = finest();
            let fine = self.objective.sample(net, s, t).value();
            if fine.rad < value.rad {
                return fine;
            }
        }
        value
    }

    /// The point of a boundary piece where it is proven to be on its patch; else its local parameters, roughly.
    fn piece_foot(&self, face: usize, index: usize, t: Dd) -> Result<Foot, [Dd; 2]> {
        let geometry = self.brep.double_double(face);
        let piece = geometry.piece(index);
        let (point, _) = crate::prepare::curve_jet(&piece.local, Ball { mid: t, rad: 0.0 });
        let local = [point[0] / point[2], point[1] / point[2]];
        if !(depth(&point) >= 0.0) {
            return Err(local.map(|x| x.mid));
        }
        let maps = geometry.patches.maps_of(piece.patch);
        let uv = [0, 1].map(|k| maps[k].nearest_native(local[k].mid));
        Ok(Foot {
            face,
            trim: piece.trim,
            uv: Point2::new(uv[0], uv[1]),
            spot: Locus::Patch {
                patch: piece.patch,
                local,
                point: None,
            },
            found: Some((Source::Piece { face, index }, [t.hi, 0.0])),
        })
    }

    fn try_piece_point(&mut self, face: usize, index: usize, t: Dd) {
        let piece = self.brep.double_double(face).piece(index);
        if piece.space.is_none() {
            return;
        }
        match self.piece_foot(face, index, t) {
            Ok(foot) => {
                let at = [Ball { mid: t, rad: 0.0 }, Ball::ZERO];
                let source = Source::Piece { face, index };
                self.keep(self.fine_value(source, at, || raised(at)), foot);
            }
            Err(local) => self.try_beside_piece(face, index, local),
        }
    }

    /// On the border of the patch, or past it: the nearest point of the patch counts if the exact test finds it in the region. Past it by more than
    /// roundings of native parameters (next to a patch a few ulps wide, where its pieces are cut) that point is not told to be on the piece's trim.
    fn try_beside_piece(&mut self, face: usize, index: usize, local: [Dd; 2]) {
        let geometry = self.brep.double_double(face);
        let piece = geometry.piece(index);
        let maps = geometry.patches.maps_of(piece.patch);
        let is_beside = (0..2).all(|k| {
            let past = (local[k].hi - local[k].hi.clamp(0.0, 1.0)).abs();
            let [start, end] = [maps[k].start, maps[k].end];
            past * (end - start) <= BESIDE * start.abs().max(end.abs())
        });
        let trim = piece.trim.filter(|_| is_beside);
        self.try_patch_point(face, piece.patch, local, trim);
    }

    fn keep(&mut self, f: Ball<Dd>, foot: Foot) {
        let value = upper_end(f);
        if value < self.out.hi {
            self.out.hi = value;
            self.out.foot = Some(foot);
        }
    }
}

/// The first patch that holds a place, and the local parameters there.
pub(super) fn patch_at(patches: &Patches<f64>, uv: Point2<f64>) -> Option<(usize, [f64; 2])> {
    let uv = [uv.x, uv.y];
    let index = patches.holding(uv)?;
    let maps = patches.maps_of(index);
    let local = [0, 1].map(|k| {
        let local: Ball<f64> = maps[k].to_local(Ball::exact(uv[k]));
        local.mid.clamp(0.0, 1.0)
    });
    Some((index, local))
}

/// The value of what cannot be evaluated.
const NOTHING_KNOWN: Ball<Dd> = Ball {
    mid: Dd::ZERO,
    rad: f64::INFINITY,
};

fn raised(local: [Ball<Dd>; 2]) -> [Ball<Td>; 2] {
    local.map(|x| Ball::from_dd(x.mid, x.rad))
}

/// A number not below what a ball holds.
pub(super) fn upper_end(f: Ball<Dd>) -> Dd {
    let mut value = f.mid + Dd::from(f.rad * UP);
    value.lo = value.lo.next_up();
    value
}

/// How many Newton steps and halvings of one; both are guides.
const MAX_NEWTON: usize = 24;
const MAX_DAMPING: usize = 10;
/// A step that gains less than this part of the value, where `f` is convex, is the last: its length is about the root of that, 2^-17, of the distance.
const LITTLE: f64 = 1.0 / (1u64 << 34) as f64;
/// A gain below this part of the value is lost in its rounding.
const NOISE: f64 = 1.0 / (1u64 << 46) as f64;
/// A step of Newton's method this short, in local parameters, is the last: the next would be lost in rounding.
const SHORT: f64 = 1.0 / (1u64 << 24) as f64;
/// A longer step, in local parameters, is not taken blindly.
const MOST_BLIND: f64 = 1.0 / (1u64 << 12) as f64;
/// How many steps are taken once the gain is lost in rounding: each squares the error.
const LAST_STEPS: usize = 3;
/// Rough values are compared with this relative slack.
const ROUGH_SLACK: f64 = 1e-9;
/// A foot is moved onto its patch by so much of the native parameters, a few ulps, and is still that of its piece.
const BESIDE: f64 = 8.0 * f64::EPSILON;
/// A point and its neighbours in ulps of uv.
pub(super) const NEIGHBOURS: [(i32, i32); 9] = [
    (0, 0),
    (1, 0),
    (-1, 0),
    (0, 1),
    (0, -1),
    (1, 1),
    (-1, -1),
    (1, -1),
    (-1, 1),
];

pub(super) fn step_ulp(x: f64, ulps: i32) -> f64 {
    match ulps {
        1 => x.next_up(),
        -1 => x.next_down(),
        _ => x,
    }
}

/// Along which of u and v a point of a box is not to be moved: out of it, or where it has no width.
pub(super) fn blocked(p: [f64; 2], slope: [f64; 2], range: [[f64; 2]; 2]) -> [bool; 2] {
    std::array::from_fn(|k| {
        range[k][0] == range[k][1]
            || (p[k] <= range[k][0] && slope[k] > 0.0)
            || (p[k] >= range[k][1] && slope[k] < 0.0)
    })
}

/// The Newton step, or a gradient step where the Hessian is not positive; zero where blocked.
pub(super) fn newton_step(slope: [f64; 2], h: [f64; 3], blocked: [bool; 2]) -> [f64; 2] {
    let single = |g: f64, h: f64| {
        if g == 0.0 {
            0.0
        } else if h > 0.0 {
            -g / h
        } else {
            // Any step downhill will do; it is damped.
            -0.25 * g.signum()
        }
    };
    match blocked {
        [true, true] => [0.0, 0.0],
        [true, false] => [0.0, single(slope[1], h[2])],
        [false, true] => [single(slope[0], h[0]), 0.0],
        [false, false] => {
            let det = h[0] * h[2] - h[1] * h[1];
            if h[0] > 0.0 && det > f64::EPSILON * (h[0] * h[2]).abs() {
                [
                    -(slope[0] * h[2] - slope[1] * h[1]) / det,
                    -(h[0] * slope[1] - h[1] * slope[0]) / det,
                ]
            } else {
                [single(slope[0], h[0]), single(slope[1], h[2])]
            }
        }
    }
}
