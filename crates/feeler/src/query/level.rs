//! Whether a way that is low leads far from a foot: along the trims that pass it, or over a face all the way round it.
//!
//! What is low may be a needle: a half-space that leans on a generator by 1e-12 has points that are as low along it, and next to it none. So the directions in
//! which a face rises least are narrowed down. Values are f64, and no bound rests on them.

use super::local::{Spot, on_trim, point};
use super::nearest::{nearest_from, nearest_on, nearest_place};
use super::objective::Objective;
use super::place::nearest_in_uv;
use crate::prepare::PreparedBrep;
use crate::trim::Side;
use nalgebra::{Point3, Vector3};
use std::cell::LazyCell;

/// What is so much farther than the reach is far, whatever is rounded.
const BEYOND: f64 = 1.0 + 1.0 / 16.0;
/// Of a place that is so many times farther than the reach nothing is told of what is there.
const MUCH: f64 = 2.0;
/// Directions that are tried first; over so little of a face values turn four times around a foot.
const DIRECTIONS: usize = 16;
/// ...and between two of them they fall below both by no more than this part of how much they differ around: `1 - cos(2 pi / 16) < 1 / 12`.
const BETWEEN: f64 = 1.0 / 8.0;
/// Golden sections of a range of directions: to a ten thousandth of it, which is less than a needle is wide that is low and so long.
const NARROWED: usize = 20;
/// The larger part.
const GOLDEN: f64 = 0.618_033_988_749_894_8;
/// What is no farther from a foot than this part of the reach is there.
const AT_FOOT: f64 = 1.0 / 64.0;
/// Trims at a vertex that are looked at.
const MOST_TRIMS: usize = 16;
/// The part of the way to a trim's end where it is looked at first.
const PROBED: f64 = 1.0 / 64.0;
/// How often a step is set right, as long as it is where the surface goes about straight on, and at most; by how much of itself it may be off then.
const STEADY: usize = 4;
const STEPS: usize = 32;
const ASIDE: f64 = 1.0 / 64.0;

/// How what is low lies about a foot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lies {
    /// Some of it far away, connected with the foot.
    Far,
    /// None of it far away, so plainly that roundings do not matter: everything around is much higher.
    Near,
    /// None was found far away.
    Open,
}

impl Lies {
    /// Of several ways, in the order in which they are looked at, which ends where one leads far.
    fn of(ways: impl Iterator<Item = Self>) -> Self {
        let mut all = Self::Near;
        for way in ways {
            match way {
                Self::Far => return Self::Far,
                Self::Open => all = Self::Open,
                Self::Near => {}
            }
        }
        all
    }
}

/// What is low around a foot.
pub(super) struct Level<'a> {
    pub(super) brep: &'a PreparedBrep,
    pub(super) objective: &'a Objective,
    pub(super) foot: Point3<f64>,
    /// No point whose distance or height is above this is low.
    pub(super) limit: f64,
    /// By how much that is above the least.
    pub(super) slack: f64,
    pub(super) reach: f64,
}

impl Level<'_> {
    /// Whether a low way leads far, from a foot at a place, on a trim if there is one; beside it on its face unless it `stands_alone` there.
    pub(super) fn from(&self, at: Spot, trim: Option<usize>, stands_alone: bool) -> Lies {
        let passing = self.passing(at.face, trim);
        let starts = passing.iter().take(MOST_TRIMS);
        // Images of an edge are often at the same pace.
        let guess = LazyCell::new(|| trim.map(|t| (t, nearest_in_uv(self.brep, t, &at.uv).1)));
        let starts: Vec<(usize, f64)> = starts.map(|t| (*t, self.start(*t, || *guess))).collect();
        let ways = starts
            .iter()
            .flat_map(|(t, s)| [(*t, *s, 0.0), (*t, *s, 1.0)]);
        let ways = ways.map(|(t, s, end)| self.along(t, s, end));
        let faces: Vec<Spot> = match trim {
            Some(_) => { starts.iter() }
                .map(|(t, s)| on_trim(self.brep, *t, *s))
                .collect(),
            None if stands_alone => Vec::new(),
            None => vec![at],
        };
        let around = faces.iter().map(|spot| self.around(*spot));
        let all = Lies::of(ways.chain(around));
        // Beyond another trim that is so near there are faces that were not looked at. (Of balls no more is asked than whether it leads far.)
        let is_whole = || {
            !self.objective.is_squared()
                && passing.len() == starts.len()
                && self.is_clear_of_others(&faces, &passing)
        };
        if all == Lies::Near && !is_whole() {
            return Lies::Open;
        }
        all
    }

    /// Whether the faces of some places have no trims within reach but these.
    fn is_clear_of_others(&self, places: &[Spot], trims: &[usize]) -> bool {
        let parts = self.brep.brep().parts();
        places.iter().all(|place| {
            let loops = parts.faces[place.face].loops.iter().flatten();
            let mut others = loops.flat_map(|l| &parts.loops[*l].trims);
            let reach = BEYOND * BEYOND * self.reach;
            let is_far = |t: &usize| nearest_on(self.brep, *t, &self.foot, reach).is_none();
            others.all(|t| trims.contains(t) || is_far(t))
        })
    }

    /// The trims that pass the foot on a face, which is on one of them, or a vertex of the face.
    fn passing(&self, face: usize, trim: Option<usize>) -> Vec<usize> {
        let parts = self.brep.brep().parts();
        let near = self.at_foot();
        let is_here = |v: &usize| {
            let vertex = parts.vertices.get(*v);
            vertex.is_some_and(|v| (v.point - self.foot).norm() <= near)
        };
        let at = match trim {
            Some(trim) => parts.trims[trim].vertices.into_iter().find(is_here),
            None => {
                let loops = parts.faces[face].loops.iter().flatten();
                let trims = loops.flat_map(|l| &parts.loops[*l].trims);
                { trims.flat_map(|t| parts.trims[*t].vertices) }.find(is_here)
            }
        };
        let edges: Vec<usize> = match at {
            Some(vertex) => parts.vertices[vertex].edges.clone(),
            None => trim.and_then(|t| parts.trims[t].edge).into_iter().collect(),
        };
        let mut passing: Vec<usize> = { edges.iter() }
            .flat_map(|e| parts.edges[*e].trims.iter().copied())
            .collect();
        passing.extend(trim.filter(|t| !passing.contains(t)));
        passing
    }

    fn height(&self, x: &Point3<f64>) -> f64 {
        match self.objective {
            Objective::SquaredDistance(q) => (x - q).norm(),
            Objective::Height(n, h) => n.dot(&x.coords) - h,
        }
    }

    fn off(&self, x: &Point3<f64>) -> f64 {
        (x - self.foot).norm()
    }

    /// Where a trim is at the foot, from 0 to 1; a guess is where another one is, or itself.
    fn start(&self, trim: usize, guess: impl Fn() -> Option<(usize, f64)>) -> f64 {
        let trims = &self.brep.brep().parts().trims;
        let is_here = |s: f64| {
            let place = point(self.brep, on_trim(self.brep, trim, s));
            self.off(&place) <= self.at_foot()
        };
        // Mostly a foot is an end.
        if let Some(end) = [0.0, 1.0].into_iter().find(|s| is_here(*s)) {
            return end;
        }
        let guess = guess().map(|(other, s)| {
            let [a, b] = [trim, other].map(|t| trims[t].reversed != trims[t].edge_reversed);
            if a == b { s } else { 1.0 - s }
        });
        let near = guess.map(|s| {
            if is_here(s) {
                return s;
            }
            nearest_from(self.brep, trim, &self.foot, s)
        });
        near.filter(|s| is_here(*s))
            .unwrap_or_else(|| nearest_place(self.brep, trim, &self.foot))
    }

    /// How what is low on a trim lies, on the way to an end: up to where it is far first.
    fn along(&self, trim: usize, start: f64, end: f64) -> Lies {
        /// Parts of a trim, in which it is looked for.
        const PARTS: usize = 8;
        const HALVES: usize = 24;
        if start == end {
            return Lies::Near;
        }
        let (brep, reach) = (self.brep, BEYOND * self.reach);
        let place = |s: f64| point(brep, on_trim(brep, trim, s));
        if self.rises(&place(start + (end - start) * PROBED)) {
            return Lies::Near;
        }
        let part = |k: usize| start + (end - start) * (k as f64 / PARTS as f64);
        let Some(first) = (1..=PARTS).find(|k| self.off(&place(part(*k))) > reach) else {
            return Lies::Open;
        };
        let [mut near, mut far] = [part(first - 1), part(first)];
        for _ in 0..HALVES {
            let middle = 0.5 * (near + far);
            if self.off(&place(middle)) > reach {
                far = middle;
            } else {
                near = middle;
            }
        }
        self.told_by(&place(far))
    }

    /// What a place beyond the reach tells of its direction: that what is low is far there, or that all is higher, by a slack more than it takes, so that no roundings have to do
    /// with it. The latter only if it is not much farther away.
    fn told_by(&self, x: &Point3<f64>) -> Lies {
        let height = self.height(x);
        // Negated in effect: what is no number tells nothing.
        if height <= self.limit {
            Lies::Far
        } else if height > self.limit + self.slack && self.is_about_there(x) {
            Lies::Near
        } else {
            Lies::Open
        }
    }

    /// What is no farther from the foot is at it, as far as the reach is concerned.
    fn at_foot(&self) -> f64 {
        AT_FOOT * self.reach
    }

    fn is_about_there(&self, x: &Point3<f64>) -> bool {
        self.off(x) <= MUCH * self.reach
    }

    /// Whether a point on a way from the foot is so high that nothing far is low on it, if it rises as a square or faster next to the foot.
    fn rises(&self, x: &Point3<f64>) -> bool {
        /// So many times higher than what is low.
        const SURELY: f64 = 256.0;
        let part = (self.reach / self.off(x)).min(1.0);
        (self.height(x) - (self.limit - self.slack)) * part * part > SURELY * self.slack
    }

    /// How what is low on a face lies around the foot: whether it is far in a direction in which the face rises least.
    fn around(&self, at: Spot) -> Lies {
        let Some(ring) = Ring::new(self, at) else {
            return Lies::Open;
        };
        // What is low and trimmed away is none.
        let tell = |(spot, x): (Spot, Point3<f64>)| {
            let told = self.told_by(&x);
            if told == Lies::Near {
                return told;
            }
            match self.brep.region(spot.face).side(spot.uv).side {
                Some(Side::Outside) if self.is_about_there(&x) => Lies::Near,
                Some(Side::Inside | Side::Boundary) => told,
                _ => Lies::Open,
            }
        };
        let spacing = TURN / DIRECTIONS as f64;
        let mut heights = [f64::INFINITY; DIRECTIONS];
        let mut is_gone = [false; DIRECTIONS];
        // Whether all that is low is trimmed away, and all else higher by as much again. Where what is gone ends and what is not begins, there is a trim, which is looked at along itself.
        let mut is_plain = ring.is_near;
        let beside = |k: usize| [(k + DIRECTIONS - 1) % DIRECTIONS, (k + 1) % DIRECTIONS];
        for k in 0..DIRECTIONS {
            let Some((spot, x)) = ring.place(spacing * k as f64) else {
                continue;
            };
            heights[k] = self.height(&x);
            // Mostly all of what is around is low, or nothing.
            match tell((spot, x)) {
                Lies::Far => return Lies::Far,
                Lies::Near => is_gone[k] = heights[k] <= self.limit + self.slack,
                Lies::Open => is_plain = false,
            }
        }
        let finite = || heights.iter().copied().filter(|h| h.is_finite());
        let least = finite().fold(f64::INFINITY, f64::min);
        let most = finite().fold(f64::NEG_INFINITY, f64::max);
        // Negated in effect: what is no number is not low.
        let may_be_low = |h: f64| h - BETWEEN * (most - least) <= self.limit + self.slack;
        for k in 0..DIRECTIONS {
            let [before, after] = beside(k);
            // Negated in effect: what is no number is no turn.
            let is_turn = heights[k] <= heights[before] && heights[k] <= heights[after];
            let is_all_gone = is_gone[before] && is_gone[k] && is_gone[after];
            if !is_turn || is_all_gone || heights[k] == f64::INFINITY || !may_be_low(heights[k]) {
                continue;
            }
            let middle = spacing * k as f64;
            match ring.lowest([middle - spacing, middle + spacing]).map(tell) {
                Some(Lies::Far) => return Lies::Far,
                Some(Lies::Open) => is_plain = false,
                Some(Lies::Near) | None => {}
            }
        }
        // A face without trims may go on beyond the end of its domain as another one.
        let has_trims = self.brep.brep().parts().faces[at.face].loops.is_some();
        let is_whole = has_trims || heights.iter().all(|h| h.is_finite());
        let is_there = (0..DIRECTIONS).any(|k| heights[k].is_finite() && !is_gone[k]);
        if is_plain && is_whole && is_there {
            Lies::Near
        } else {
            Lies::Open
        }
    }
}

/// Directions count from 0 to this once around.
const TURN: f64 = 4.0;

/// The part of a domain that tells how fast a surface is: far more than roundings, far less than it bends in.
const NUDGE: f64 = 1.0 / (1u64 << 20) as f64;

/// What is as far from a foot as the reach, over one face.
struct Ring<'a> {
    level: &'a Level<'a>,
    at: Spot,
    /// How far in each parameter goes so far.
    step: [f64; 2],
    /// What that is in space.
    along: [Vector3<f64>; 2],
    /// The parameter that turns around a pole, where the foot is one.
    pole: Option<usize>,
    /// Whether a nudge goes no farther than the reach: where it does, nothing is seen of what is nearer.
    is_near: bool,
}

impl<'a> Ring<'a> {
    /// `None` where parameters do not say where to go.
    fn new(level: &'a Level<'a>, at: Spot) -> Option<Self> {
        let domain = level.brep.brep().surface(at.face).domain();
        let center = point(level.brep, at);
        let (mut step, mut along, mut is_near) = ([0.0; 2], [Vector3::zeros(); 2], true);
        for k in 0..2 {
            let by = NUDGE * domain[k].length();
            let by = if at.uv[k] <= domain[k].mid() { by } else { -by };
            let mut beside = at;
            beside.uv[k] += by;
            let way = point(level.brep, beside) - center;
            let so_far = level.reach / way.norm();
            // Negated in effect: what is no number is not near.
            is_near &= so_far >= 1.0;
            step[k] = by.abs() * so_far;
            along[k] = way * (so_far * by.signum());
        }
        // Negated in effect: what is no number is nowhere.
        let stands = [0, 1].map(|k| !(step[k] < domain[k].length()));
        let pole = match stands {
            [false, false] => None,
            [true, false] => Some(0),
            [false, true] => Some(1),
            [true, true] => return None,
        };
        Some(Self {
            level,
            at,
            step,
            along,
            pole,
            is_near,
        })
    }

    /// The place in a direction that is far enough; `None` where the domain ends before.
    fn place(&self, direction: f64) -> Option<(Spot, Point3<f64>)> {
        let level = self.level;
        let domain = level.brep.brep().surface(self.at.face).domain();
        let turned = direction.rem_euclid(TURN);
        let from = [self.at.uv.x, self.at.uv.y];
        let (from, way, length) = match self.pole {
            None => {
                // Around a square on its corner.
                let (side, part) = (turned.floor(), turned.fract());
                let way = match side as usize {
                    0 => [1.0 - part, part],
                    1 => [-part, 1.0 - part],
                    2 => [part - 1.0, -part],
                    _ => [part, part - 1.0],
                };
                let length = (self.along[0] * way[0] + self.along[1] * way[1]).norm();
                (from, [way[0] * self.step[0], way[1] * self.step[1]], length)
            }
            Some(k) => {
                let other = 1 - k;
                let (mut start, mut way) = (from, [0.0; 2]);
                start[k] = domain[k].lerp(turned / TURN);
                let inward = if from[other] <= domain[other].mid() {
                    1.0
                } else {
                    -1.0
                };
                way[other] = inward * self.step[other];
                (start, way, level.reach)
            }
        };
        // Where the way leaves the domain.
        let ends = [0, 1].map(|k| {
            let end = if way[k] > 0.0 {
                domain[k].end
            } else {
                domain[k].start
            };
            if way[k] == 0.0 {
                f64::INFINITY
            } else {
                (end - from[k]) / way[k]
            }
        });
        let end = ends[0].min(ends[1]);
        let [mut near, mut far] = [0.0, end];
        let mut t = (BEYOND * level.reach / length).min(end);
        for step in 0..STEPS {
            // Negated in effect: what is no number is nowhere.
            if !(t > 0.0 && t < f64::INFINITY) {
                return None;
            }
            let at = [0, 1].map(|k| (from[k] + t * way[k]).clamp(domain[k].start, domain[k].end));
            let spot = Spot {
                face: self.at.face,
                uv: at.into(),
            };
            let point = point(level.brep, spot);
            let off = level.off(&point) / (BEYOND * level.reach);
            let is_last = step + 1 == STEPS || (off < 1.0 && t == end);
            if (off - 1.0).abs() <= ASIDE || is_last {
                return (level.off(&point) > level.reach).then_some((spot, point));
            }
            if off < 1.0 {
                near = t;
            } else {
                far = t;
            }
            let next = t / off;
            t = if step < STEADY && near < next && next < far {
                next
            } else if far == end && near > 0.0 {
                end
            } else if near > 0.0 {
                (near * far).sqrt()
            } else {
                far / 64.0
            };
        }
        None
    }

    /// The lowest place in a range of directions in which there is one turn; `None` where the domain ends before in all of them.
    fn lowest(&self, [mut a, mut b]: [f64; 2]) -> Option<(Spot, Point3<f64>)> {
        let at = |a: f64, b: f64| {
            let x = a + GOLDEN * (b - a);
            let place = self.place(x);
            let height = place.map_or(f64::INFINITY, |(_, x)| self.level.height(&x));
            (x, height, place)
        };
        let (mut low, mut high) = (at(b, a), at(a, b));
        for _ in 0..NARROWED {
            if low.1 <= high.1 {
                b = high.0;
                high = low;
                low = at(b, a);
            } else {
                a = low.0;
                low = high;
                high = at(a, b);
            }
        }
        if low.1 <= high.1 { low.2 } else { high.2 }
    }
}

#[cfg(test)]
mod tests;
