//! Whether a way that is low leads far from a foot: along the trims that pass it, or over a face all the way round it.
//!
//! What is low may be a needle: a half-space that leans on a generator by 1e-12 has points that are as low along it, and next to it none. So the directions in
//! which a face rises least are narrowed down. Values are f64, and no bound rests on them.

use super::local::{Spot, on_trim, point};
use super::nearest::nearest_place;
use super::objective::Objective;
use super::place::ON_VERTEX;
use crate::prepare::PreparedBrep;
use crate::trim::Side;
use nalgebra::{Point2, Point3};

/// What is so much farther than the reach is far, whatever is rounded.
const BEYOND: f64 = 1.0 + 1.0 / 16.0;
/// Directions that are tried first; over so little of a face values turn four times around a foot.
const DIRECTIONS: usize = 16;
/// ...and between two of them they fall below both by no more than this part of how much they differ around: `1 - cos(2 pi / 16) < 1 / 12`.
const BETWEEN: f64 = 1.0 / 8.0;
/// Thirds of a range of directions: to a ten thousandth of it, which is less than a needle is wide that is low and so long.
const NARROWED: usize = 24;
/// Trims at a vertex that are looked at.
const MOST_TRIMS: usize = 16;
/// The part of the way to a trim's end where it is looked at first.
const PROBED: f64 = 1.0 / 64.0;
/// How often a step is set right.
const STEPS: usize = 2;

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
    pub(super) fn leads_far(&self, at: Spot, trim: Option<usize>, stands_alone: bool) -> bool {
        let starts = self.passing(at.face, trim).into_iter().take(MOST_TRIMS);
        let starts: Vec<(usize, f64)> = starts.map(|t| (t, self.start(t))).collect();
        let is_way = |(t, s): &(usize, f64)| self.way(*t, *s, 0.0) || self.way(*t, *s, 1.0);
        let is_low = |(t, s): &(usize, f64)| self.is_low_around(on_trim(self.brep, *t, *s));
        starts.iter().any(is_way)
            || match trim {
                Some(_) => starts.iter().any(is_low),
                None => !stands_alone && self.is_low_around(at),
            }
    }

    /// The trims that pass the foot on a face, which is on one of them, or a vertex of the face.
    fn passing(&self, face: usize, trim: Option<usize>) -> Vec<usize> {
        let parts = self.brep.brep().parts();
        let near = ON_VERTEX * self.brep.size();
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

    fn is_low(&self, x: &Point3<f64>) -> bool {
        self.height(x) <= self.limit
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

    /// Where a trim is at the foot, from 0 to 1.
    fn start(&self, trim: usize) -> f64 {
        let place = |s: f64| point(self.brep, on_trim(self.brep, trim, s));
        // Mostly a foot is an end.
        let mut ends = [0.0, 1.0].into_iter();
        let end = ends.find(|s| self.off(&place(*s)) <= ON_VERTEX * self.brep.size());
        end.unwrap_or_else(|| nearest_place(self.brep, trim, &self.foot))
    }

    /// Whether a trim is low where it first is far on the way to an end.
    fn way(&self, trim: usize, start: f64, end: f64) -> bool {
        /// Parts of a trim, in which it is looked for.
        const PARTS: usize = 8;
        const HALVES: usize = 24;
        let (brep, reach) = (self.brep, BEYOND * self.reach);
        let place = |s: f64| point(brep, on_trim(brep, trim, s));
        if self.rises(&place(start + (end - start) * PROBED)) {
            return false;
        }
        let part = |k: usize| start + (end - start) * (k as f64 / PARTS as f64);
        let Some(first) = (1..=PARTS).find(|k| self.off(&place(part(*k))) > reach) else {
            return false;
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
        self.is_low(&place(far))
    }

    /// Whether a point on a way from the foot is so high that nothing far is low on it, if it rises as a square or faster next to the foot.
    fn rises(&self, x: &Point3<f64>) -> bool {
        /// So many times higher than what is low.
        const SURELY: f64 = 256.0;
        let part = (self.reach / self.off(x)).min(1.0);
        (self.height(x) - (self.limit - self.slack)) * part * part > SURELY * self.slack
    }

    /// Whether a face is low in a direction in which it rises least.
    fn is_low_around(&self, at: Spot) -> bool {
        let Some(ring) = Ring::new(self, at) else {
            return false;
        };
        let spacing = TURN / DIRECTIONS as f64;
        let mut heights = [f64::INFINITY; DIRECTIONS];
        for (k, height) in heights.iter_mut().enumerate() {
            *height = ring.height(spacing * k as f64);
            // Mostly all of what is around is low, or nothing.
            if *height <= self.limit && ring.is_low(spacing * k as f64) {
                return true;
            }
        }
        let finite = || heights.iter().copied().filter(|h| h.is_finite());
        let least = finite().fold(f64::INFINITY, f64::min);
        let most = finite().fold(f64::NEG_INFINITY, f64::max);
        // Negated in effect: what is no number is not low.
        let may_be_low = |h: f64| h - BETWEEN * (most - least) <= self.limit;
        (0..DIRECTIONS).any(|k| {
            let before = heights[(k + DIRECTIONS - 1) % DIRECTIONS];
            let after = heights[(k + 1) % DIRECTIONS];
            // Negated in effect: what is no number is no turn.
            let is_turn = heights[k] <= before && heights[k] <= after;
            if !(is_turn && heights[k] < f64::INFINITY && may_be_low(heights[k])) {
                return false;
            }
            let middle = spacing * k as f64;
            let [mut a, mut b] = [middle - spacing, middle + spacing];
            for _ in 0..NARROWED {
                let third = (b - a) / 3.0;
                if ring.height(a + third) <= ring.height(b - third) {
                    b -= third;
                } else {
                    a += third;
                }
            }
            ring.is_low(0.5 * (a + b))
        })
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
    /// The parameter that turns around a pole, where the foot is one.
    pole: Option<usize>,
}

impl<'a> Ring<'a> {
    /// `None` where parameters do not say where to go.
    fn new(level: &'a Level<'a>, at: Spot) -> Option<Self> {
        let domain = level.brep.brep().surface(at.face).domain();
        let step = [0, 1].map(|k| {
            let by = NUDGE * domain[k].length();
            let mut beside = at;
            beside.uv[k] += if at.uv[k] <= domain[k].mid() { by } else { -by };
            by * level.reach / level.off(&point(level.brep, beside))
        });
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
            pole,
        })
    }

    /// The place in a direction that is far enough; `None` where the domain ends before.
    fn place(&self, direction: f64) -> Option<(Spot, Point3<f64>)> {
        let level = self.level;
        let domain = level.brep.brep().surface(self.at.face).domain();
        let turned = direction.rem_euclid(TURN);
        let from = [self.at.uv.x, self.at.uv.y];
        let (from, way) = match self.pole {
            None => {
                // Around a square on its corner.
                let (side, part) = (turned.floor(), turned.fract());
                let way = match side as usize {
                    0 => [1.0 - part, part],
                    1 => [-part, 1.0 - part],
                    2 => [part - 1.0, -part],
                    _ => [part, part - 1.0],
                };
                (from, [way[0] * self.step[0], way[1] * self.step[1]])
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
                (start, way)
            }
        };
        let spot = |t: f64| Spot {
            face: self.at.face,
            uv: Point2::new(from[0] + t * way[0], from[1] + t * way[1]),
        };
        let mut t = BEYOND;
        for _ in 0..STEPS {
            let off = level.off(&point(level.brep, spot(t)));
            t *= BEYOND * level.reach / off;
        }
        let there = spot(t);
        let [u, v] = domain;
        let (x, y) = (there.uv.x, there.uv.y);
        let is_in = u.start <= x && x <= u.end && v.start <= y && y <= v.end;
        let point = point(level.brep, there);
        (is_in && level.off(&point) > level.reach).then_some((there, point))
    }

    fn height(&self, direction: f64) -> f64 {
        let place = self.place(direction);
        place.map_or(f64::INFINITY, |(_, x)| self.level.height(&x))
    }

    /// Whether what is there is low, and not trimmed away.
    fn is_low(&self, direction: f64) -> bool {
        self.place(direction).is_some_and(|(spot, x)| {
            let side = || self.level.brep.region(spot.face).side(spot.uv).side;
            self.level.is_low(&x) && matches!(side(), Some(Side::Inside | Side::Boundary))
        })
    }
}
