//! Whether a point is a local minimum of the objective over all faces around it: of use for which contacts there
//! are. No separation rests on it.

use super::nearest::{nearest, nearest_from, nearest_on};
use super::objective::{Objective, ball_around};
use super::place::{rough_jet, trims_near};
use crate::numeric::{Ball, Dd};
use crate::prepare::PreparedBrep;
use crate::trim::Side;
use nalgebra::{Point2, Point3};
use std::cell::Cell;

/// A point of a face, by its parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) face: usize,
    pub(super) uv: Point2<f64>,
}

/// The shortest step from the point, relative to the model's size: feet nearer to each other are one contact.
const FIRST_STEP: f64 = 1.0 / (1u64 << 24) as f64;
/// Each step is so much longer than the one before.
const GROWTH: f64 = 4.0;
/// How many steps a way down has at most.
const STEPS: i32 = 8;
/// Directions in which a way down is sought on each face.
const DIRECTIONS: usize = 24;
/// The cosine and the sine of the angle from one to the next.
const TURN: [f64; 2] = [0.965_925_826_289_068_3, 0.258_819_045_102_520_74];
/// On a trim that is one point in space (a pole), ways start at so many of its parameters.
const AROUND_POLE: usize = 24;

/// Of a speed that is less than this part of a patch's coordinates f64 tells few digits.
const FEW_DIGITS: f64 = 1.0 / (1u64 << 20) as f64;
/// So many values count for a node.
const VALUES_A_NODE: usize = 8;

pub(super) struct Surroundings<'a> {
    pub(super) brep: &'a PreparedBrep,
    pub(super) objective: &'a Objective,
    /// How many values of the objective were asked for.
    values: Cell<usize>,
}

impl<'a> Surroundings<'a> {
    pub(super) fn new(brep: &'a PreparedBrep, objective: &'a Objective) -> Self {
        Self {
            brep,
            objective,
            values: Cell::new(0),
        }
    }

    /// What was asked so far, in nodes.
    pub(super) fn nodes(&self) -> usize {
        self.values.get() / VALUES_A_NODE
    }

    /// Whether no way leads down from a point with this value of `f`: by straight lines in uv, and along trims, from
    /// the point and from where the faces beside it have it. A way falls from its first step on, so that what
    /// is beyond a rise does not count; beyond a crack it has to come below the point itself.
    pub(super) fn is_minimum(
        &self,
        own: Spot,
        trim: Option<usize>,
        point: &Point3<f64>,
        f: Ball<Dd>,
    ) -> bool {
        if self.falls_from(own, f, f) || self.falls_at_borders(own, point, f) {
            return false;
        }
        !self
            .trims_at(own, trim, point)
            .into_iter()
            .any(|t| self.falls_at_trim(t, point, f))
    }

    /// Whether a way leads down from where else faces without loops, which have no edges to tell, have a point on the border of their
    /// domain: across a seam, around a pole, on a neighbour.
    fn falls_at_borders(&self, own: Spot, point: &Point3<f64>, f: Ball<Dd>) -> bool {
        let near = FIRST_STEP * self.brep.size();
        (0..self.brep.brep().faces().len()).any(|face| {
            let without_loops = self.brep.brep().parts().faces[face].loops.is_none();
            let holds = |b: &[[f64; 2]; 3]| {
                (0..3).all(|c| b[c][0] - near <= point[c] && point[c] <= b[c][1] + near)
            };
            without_loops
                && self.brep.face_box(face).is_none_or(holds)
                && self.falls_at_border(face, own, point, f)
        })
    }

    fn falls_at_border(&self, face: usize, own: Spot, point: &Point3<f64>, f: Ball<Dd>) -> bool {
        let near = FIRST_STEP * self.brep.size();
        let domain = self.brep.brep().surface(face).domain();
        let own_uv = [own.uv.x, own.uv.y];
        (0..2).any(|across| {
            let along = domain[1 - across];
            [domain[across].start, domain[across].end]
                .into_iter()
                .any(|end| {
                    let at = |t: f64| {
                        let uv = if across == 0 { [end, t] } else { [t, end] };
                        Spot {
                            face,
                            uv: uv.into(),
                        }
                    };
                    let falls = |t: f64| {
                        (self.point(at(t)) - point).norm() <= near
                            && self
                                .value(at(t))
                                .is_some_and(|v| self.falls_from(at(t), v, f))
                    };
                    // A side that is one point is met at any parameter, the face's own at the same one, others where they come nearest.
                    let around = |i: usize| along.lerp(i as f64 / AROUND_POLE as f64);
                    if (0..=AROUND_POLE).any(|i| falls(around(i))) {
                        return true;
                    }
                    if face == own.face {
                        return falls(own_uv[1 - across]);
                    }
                    let (_, s) = nearest(|s| self.point(at(along.lerp(s))), point);
                    falls(along.lerp(s))
                })
        })
    }

    /// All trims that meet at a point: those of its vertex, those of the edge of the trim that it lies on and of others that its face has there (a vertex may
    /// lie elsewhere), or those of the edges that its face has within the first step of it: a foot is known to no more than that.
    fn trims_at(&self, own: Spot, trim: Option<usize>, point: &Point3<f64>) -> Vec<usize> {
        let parts = self.brep.brep().parts();
        let near = FIRST_STEP * self.brep.size();
        let at_vertex = |v: &usize| (parts.vertices[*v].point - point).norm() <= near;
        if (0..parts.vertices.len()).any(|v| at_vertex(&v)) {
            let trims = 0..parts.trims.len();
            return trims
                .filter(|t| parts.trims[*t].vertices.iter().any(at_vertex))
                .collect();
        }
        let of_edge = |trim: usize| match parts.trims[trim].edge {
            Some(edge) => parts.edges[edge].trims.clone(),
            None => vec![trim],
        };
        if let Some(trim) = trim {
            let others = trims_near(self.brep, own.face, &own.uv).into_iter();
            let mut all = of_edge(trim);
            all.extend(others.filter(|t| *t != trim).flat_map(of_edge));
            return all;
        }
        let loops = parts.faces[own.face].loops.iter().flatten();
        let own = loops.flat_map(|l| &parts.loops[*l].trims);
        let beside = |t: &&usize| nearest_on(self.brep, **t, point, near).is_some();
        own.filter(beside).flat_map(|t| of_edge(*t)).collect()
    }

    fn on_trim(&self, trim: usize, s: f64) -> Spot {
        on_trim(self.brep, trim, s)
    }

    fn point(&self, at: Spot) -> Point3<f64> {
        point(self.brep, at)
    }

    fn falls_at_trim(&self, trim: usize, point: &Point3<f64>, f: Ball<Dd>) -> bool {
        let first = FIRST_STEP * self.brep.size();
        let Some((_, s)) = nearest_on(self.brep, trim, point, first) else {
            return false;
        };
        if self.brep.brep().parts().trims[trim].edge.is_none() {
            // By its ends: where it is between tells as much of how its parameter runs as of the face. (What is no pole there is none of its places.)
            let [from, to] = [0.0, 1.0].map(|s| self.on_trim(trim, s));
            return (0..=AROUND_POLE).any(|k| {
                let s = k as f64 / AROUND_POLE as f64;
                let at = Spot {
                    uv: from.uv + (to.uv - from.uv) * s,
                    ..from
                };
                (self.point(at) - point).norm() <= first
                    && self.value(at).is_some_and(|v| self.falls_from(at, v, f))
            });
        }
        // Where a trim closes it is left from both of its ends.
        let ends = [0.0, 1.0].into_iter().filter(|end| {
            *end != s && (self.point(self.on_trim(trim, *end)) - point).norm() <= first
        });
        [s].into_iter()
            .chain(ends)
            .any(|s| self.falls_along(trim, s, f))
    }

    /// Whether a way leads down from a place of a trim, across the face or along the trim.
    fn falls_along(&self, trim: usize, s: f64, f: Ball<Dd>) -> bool {
        let at = self.on_trim(trim, s);
        let Some(here) = self.value(at) else {
            return false;
        };
        self.falls_on(trim, s, here, f) || self.falls_from(at, here, f)
    }

    /// Whether a way leads down from where a trim is next to a point, about a parameter of its curve. (No, where it is not next to that point thereabouts.)
    pub(super) fn falls_about(
        &self,
        (trim, about): (usize, f64),
        point: &Point3<f64>,
        f: Ball<Dd>,
    ) -> bool {
        let near = FIRST_STEP * self.brep.size();
        let span = self.brep.brep().parts().trims[trim].span;
        let guess = ((about - span.start) / (span.end - span.start)).clamp(0.0, 1.0);
        let away = |s: f64| (self.point(self.on_trim(trim, s)) - point).norm();
        let s = if away(guess) <= near {
            guess
        } else {
            nearest_from(self.brep, trim, point, guess)
        };
        away(s) <= near && self.falls_along(trim, s, f)
    }

    /// Whether a way along a trim leads down from a place on it, with value `here`.
    fn falls_on(&self, trim: usize, s: f64, here: Ball<Dd>, f: Ball<Dd>) -> bool {
        [-1.0, 1.0].into_iter().any(|sign| {
            let along = |length: f64| {
                let to = self.along_trim(trim, (s, sign), length)?;
                Some(self.on_trim(trim, to))
            };
            self.falls(here, f, along, |_| true)
        })
    }

    /// The parameter of a trim about so far along it from another one, forwards or backwards; `None` beyond its end, and where the next
    /// parameter is much farther away: what lies between is not known to fall.
    ///
    /// A trim may stand still at its end, so that its speed there tells nothing.
    fn along_trim(&self, trim: usize, (s, sign): (f64, f64), length: f64) -> Option<f64> {
        const PROBE: f64 = 1.0 / (1u64 << 16) as f64;
        const LEAST: f64 = 1.0 / (1u64 << 50) as f64;
        const HALVINGS: usize = 8;
        let room = if sign > 0.0 { 1.0 - s } else { s };
        let from = self.point(self.on_trim(trim, s));
        let away = |part: f64| (self.point(self.on_trim(trim, s + sign * part)) - from).norm();
        let first = PROBE * length / away(PROBE.min(room));
        if first <= room && (0.5..=2.0).contains(&(away(first) / length)) {
            return Some(s + sign * first);
        }
        // As fast as it is here it would not come so far; nor does it.
        if first > room && away(room) < length {
            return None;
        }
        let mut far = LEAST;
        while far < room && away(far) < length {
            far *= 2.0;
        }
        let mut far = far.min(room);
        // Negated: what is no number is no way.
        if !(away(far) >= length) {
            return None;
        }
        let mut near = 0.0;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            if away(middle) < length {
                near = middle;
            } else {
                far = middle;
            }
        }
        (away(far) <= GROWTH * length).then_some(s + sign * far)
    }

    /// Whether some straight line in uv leads down from a point with value `here`.
    fn falls_from(&self, from: Spot, here: Ball<Dd>, f: Ball<Dd>) -> bool {
        let domain = self.brep.brep().surface(from.face).domain();
        let speeds = self.speeds(from);
        let first = FIRST_STEP * self.brep.size();
        // In uv per unit of length; none in a direction in which the whole surface is a point.
        let per_length: [f64; 2] = std::array::from_fn(|k| {
            let speed = speeds[k];
            if speed * (domain[k].end - domain[k].start) > GROWTH * first {
                1.0 / speed
            } else {
                0.0
            }
        });
        let mut direction = [1.0, 0.0];
        (0..DIRECTIONS).any(|_| {
            // Along u and v exactly: on the border of the domain what is beside it is beyond.
            let [c, s] = direction.map(|x: f64| if x.abs() < 0.5 * TURN[1] { 0.0 } else { x });
            direction = [c * TURN[0] - s * TURN[1], c * TURN[1] + s * TURN[0]];
            let step = [c * per_length[0], s * per_length[1]];
            if step == [0.0; 2] {
                return false;
            }
            let along = |length: f64| {
                let uv = Point2::new(from.uv.x + length * step[0], from.uv.y + length * step[1]);
                let within = domain[0].start <= uv.x
                    && uv.x <= domain[0].end
                    && domain[1].start <= uv.y
                    && uv.y <= domain[1].end;
                within.then_some(Spot {
                    face: from.face,
                    uv,
                })
            };
            let in_region =
                |at: Spot| self.brep.region(at.face).side(at.uv).side != Some(Side::Outside);
            self.falls(here, f, along, in_region)
        })
    }

    /// Whether `f` falls along a way, given by lengths from its start, without a rise, and below `f`, at places that count. (Which do is
    /// asked last: most ways lead up.)
    fn falls(
        &self,
        here: Ball<Dd>,
        f: Ball<Dd>,
        way: impl Fn(f64) -> Option<Spot>,
        counts: impl Fn(Spot) -> bool,
    ) -> bool {
        let mut last = here;
        for k in 0..STEPS {
            let length = FIRST_STEP * self.brep.size() * GROWTH.powi(k);
            let Some(at) = way(length) else {
                return false;
            };
            let Some(value) = self.value(at).filter(|v| below(*v, last)) else {
                return false;
            };
            if !counts(at) {
                return false;
            }
            if below(value, f) {
                return true;
            }
            last = value;
        }
        false
    }

    /// How fast a face goes along u and v: from its patch in f64, if the patch is not so narrow, or so slow there, that few digits are left of that.
    fn speeds(&self, at: Spot) -> [f64; 2] {
        let uv = [at.uv.x, at.uv.y];
        if self.brep.closed(at.face).is_none() {
            let patches = &self.brep.double(at.face).patches;
            if let Some(patch) = patches.holding(uv).map(|index| &patches[index]) {
                let local = |k: usize| patch.maps[k].to_local(Ball::exact(uv[k])).mid;
                let [_, along_u, along_v] = rough_jet(&patch.net, [local(0), local(1)]);
                let speeds = [along_u.norm(), along_v.norm()];
                let [x, y, z, _] = patch.net.largest;
                if speeds.iter().all(|s| *s >= FEW_DIGITS * x.max(y).max(z)) {
                    let length = |k: usize| patch.maps[k].length::<f64>().mid;
                    return [speeds[0] / length(0), speeds[1] / length(1)];
                }
            }
        }
        let surface = self.brep.brep().surface(at.face);
        let all = surface.first_derivatives_with_bound(uv[0], uv[1]);
        [all.du.norm(), all.dv.norm()]
    }

    /// The value of `f`.
    pub(super) fn value(&self, at: Spot) -> Option<Ball<Dd>> {
        self.values.set(self.values.get() + 1);
        let uv = [at.uv.x, at.uv.y];
        if let Some(form) = self.brep.closed(at.face) {
            let point = form.surface.point(uv);
            return Some(ball_around(self.objective.target().range_at(&point)));
        }
        let index = self.brep.double(at.face).patches.holding(uv)?;
        let patch = &self.brep.double_double(at.face).patches[index];
        let [s, t] = [0, 1].map(|k| patch.maps[k].to_local(Ball::exact(uv[k])));
        Some(self.objective.value(&patch.net, [s, t]))
    }
}

/// The place of a trim at a part of its span, clamped to the surface's domain.
pub(super) fn on_trim(brep: &PreparedBrep, trim: usize, s: f64) -> Spot {
    let brep = brep.brep();
    let parts = brep.parts();
    let trim = &parts.trims[trim];
    let face = parts.loops[trim.trim_loop].face;
    let at = parts.curves2[trim.curve].point(trim.span.lerp(s));
    let [u, v] = brep.surface(face).domain();
    let uv = Point2::new(at.x.clamp(u.start, u.end), at.y.clamp(v.start, v.end));
    Spot { face, uv }
}

pub(super) fn point(brep: &PreparedBrep, at: Spot) -> Point3<f64> {
    let surface = brep.brep().surface(at.face);
    surface.point(at.uv.x, at.uv.y)
}

/// Whether one value is certainly below another.
fn below(a: Ball<Dd>, b: Ball<Dd>) -> bool {
    (b.mid - a.mid).hi > a.rad + b.rad
}
