//! Whether a point is a local minimum of the objective over all faces around it: of use for which contacts there
//! are. No separation rests on it.

use super::objective::{Objective, ball_around};
use super::place::trims_near;
use super::search::least_squared;
use crate::numeric::{Ball, Dd};
use crate::prepare::PreparedBrep;
use crate::prepare::trim_boxes::{BENT, SAMPLES};
use crate::trim::Side;
use nalgebra::{Point, Point2, Point3, Vector3};

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

pub(super) struct Surroundings<'a> {
    pub(super) brep: &'a PreparedBrep,
    pub(super) objective: &'a Objective,
}

impl Surroundings<'_> {
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
            let all = (0..=AROUND_POLE).map(|k| k as f64 / AROUND_POLE as f64);
            let mut all = all.map(|s| self.on_trim(trim, s));
            return all.any(|at| self.value(at).is_some_and(|v| self.falls_from(at, v, f)));
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
        if self.falls_from(at, here, f) {
            return true;
        }
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
        let surface = self.brep.brep().surface(from.face);
        let domain = surface.domain();
        let jet = surface.first_derivatives_with_bound(from.uv.x, from.uv.y);
        let speeds: [Vector3<f64>; 2] = [jet.du, jet.dv];
        let first = FIRST_STEP * self.brep.size();
        // In uv per unit of length; none in a direction in which the whole surface is a point.
        let per_length: [f64; 2] = std::array::from_fn(|k| {
            let speed = speeds[k].norm();
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

    /// The value of `f`.
    pub(super) fn value(&self, at: Spot) -> Option<Ball<Dd>> {
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

/// How near what a trim is in space comes to a point, and where on the trim, from 0 to 1, roughly; `None` where it does not come within so much.
pub(super) fn nearest_on(
    brep: &PreparedBrep,
    trim: usize,
    to: &Point3<f64>,
    within: f64,
) -> Option<(f64, f64)> {
    /// Room for roundings: a box may be a point.
    const DOWN: f64 = 1.0 - 1.0 / (1u64 << 40) as f64;
    let curve = |s: f64| point(brep, on_trim(brep, trim, s));
    let boxes = brep.trim_boxes(trim, curve);
    let mut limit = within;
    // What is told as nearer than this is within the limit.
    let unknown = |limit: f64| (limit.next_up(), 0.0);
    if boxes.len() > 1 {
        // What is no nearer than a place in the nearest box need not be looked at.
        let all = (0..boxes.len()).map(|k| (k, least_squared(&boxes[k], to)));
        let first = |a: (usize, f64), b: (usize, f64)| if b.1 < a.1 { b } else { a };
        let (first, squared) = all.reduce(first)?;
        if squared.sqrt() * DOWN <= within {
            let mut nearest = unknown(within);
            narrow_part(curve, (first, boxes.len()), to, &mut nearest);
            limit = limit.min(nearest.0);
        }
    }
    let mut nearest = unknown(limit);
    for (k, own) in boxes.iter().enumerate() {
        if least_squared(own, to).sqrt() * DOWN <= limit {
            narrow_part(curve, (k, boxes.len()), to, &mut nearest);
        }
    }
    (nearest.0 <= limit && nearest.0 < f64::INFINITY).then_some(nearest)
}

/// Where that is nearest.
pub(super) fn nearest_place(brep: &PreparedBrep, trim: usize, to: &Point3<f64>) -> f64 {
    nearest_on(brep, trim, to, f64::INFINITY).map_or(0.0, |(_, s)| s)
}

/// Whether one value is certainly below another.
fn below(a: Ball<Dd>, b: Ball<Dd>) -> bool {
    (b.mid - a.mid).hi > a.rad + b.rad
}

/// How near a curve over [0, 1] comes to a point, and where, roughly: what is nearest among samples and their neighbours, each
/// narrowed down. (On a closed curve both ends may be near a point, and one of them is the wrong one.)
pub(super) fn nearest<const D: usize>(
    curve: impl Fn(f64) -> Point<f64, D>,
    to: &Point<f64, D>,
) -> (f64, f64) {
    let mut all = (f64::INFINITY, 0.0);
    narrow(curve, to, &mut all);
    all
}

/// The same of a curve over a trim, from its start to its end.
pub(super) fn nearest_along<const D: usize>(
    brep: &PreparedBrep,
    trim: usize,
    curve: impl Fn(f64) -> Point<f64, D>,
    to: &Point<f64, D>,
) -> (f64, f64) {
    let count = brep.trim_parts(trim);
    let mut best = (f64::INFINITY, 0.0);
    for k in 0..count {
        narrow_part(&curve, (k, count), to, &mut best);
    }
    best
}

/// What is nearer on a part of a curve, one of so many, than what is known so far.
fn narrow_part<const D: usize>(
    curve: impl Fn(f64) -> Point<f64, D>,
    (k, count): (usize, usize),
    to: &Point<f64, D>,
    best: &mut (f64, f64),
) {
    let at = |s: f64| (k as f64 + s) / count as f64;
    let before = best.0;
    narrow(|s| curve(at(s)), to, best);
    if best.0 < before {
        best.1 = at(best.1);
    }
}

/// What is nearer than what is known so far.
fn narrow<const D: usize>(
    curve: impl Fn(f64) -> Point<f64, D>,
    to: &Point<f64, D>,
    all: &mut (f64, f64),
) {
    // What is nearer than that is not told from a point on the curve.
    let told = 4.0 * f64::EPSILON * to.coords.norm();
    // A foot is often at an end.
    for s in [0.0, 1.0] {
        let away = (curve(s) - to).norm();
        if away < all.0 {
            *all = (away, s);
        }
        if away <= told {
            return;
        }
    }
    let at = |k: usize| k as f64 / SAMPLES as f64;
    let points: [_; SAMPLES + 1] = std::array::from_fn(|k| curve(at(k)));
    let away = points.map(|p| (p - to).norm());
    let chord = |k: usize, other: usize| (points[k] - points[other]).norm();
    let last = |k: usize| (k + 1).min(SAMPLES);
    let is_least = |k: usize| {
        let around = &away[k.saturating_sub(1)..=last(k)];
        !around.iter().any(|v| *v < away[k])
    };
    // It may pass between two samples where there is a kink, from which the way falls to the other side.
    let may_pass = |k: usize, other: usize| away[k] + away[other] <= BENT * chord(k, other);
    let first = (1..=SAMPLES).fold(0, |a, b| if away[b] < away[a] { b } else { a });
    let others = (0..=SAMPLES).filter(|k| *k != first);
    for k in [first].into_iter().chain(others) {
        let is_far = |other: usize| away[k] - BENT * chord(k, other) > all.0;
        let (before, after) = (k.saturating_sub(1), last(k));
        if away[k] > all.0 && is_far(before) && is_far(after) {
            continue;
        }
        if !(is_least(k) || may_pass(k, before) || may_pass(k, after)) {
            continue;
        }
        let speed = SAMPLES as f64 * chord(k, before).max(chord(k, after));
        let best = descend(|s| (curve(s) - to).norm_squared(), at(k), speed);
        if best.0 < all.0 {
            *all = best;
        }
        if best.0 <= told {
            return;
        }
    }
}

/// Where a curve over [0, 1] comes nearest to a point from a sample on, and how near, given the squared distance and how fast the curve is.
///
/// A pattern search (Hooke and Jeeves): each round looks at both sides of the best place, and between them where the parabola through the three is least.
/// The steps at least halve, as they must where there is a kink; where the parabola is right they shrink as fast as it becomes better.
fn descend(squared: impl Fn(f64) -> f64, from: f64, speed: f64) -> (f64, f64) {
    const ROUNDS: usize = 64;
    const SHRINK: f64 = 1.0 / 64.0;
    const LEAST: f64 = 1.0 / (1u64 << 50) as f64;
    // Nearer to a minimum than so much of the distance, on the curve, the squared distances differ by roundings.
    const NOISE: f64 = 1.0 / (1u64 << 27) as f64;
    let mut best = (squared(from), from);
    let mut step = 0.5 / SAMPLES as f64;
    let mut most = step;
    for _ in 0..ROUNDS {
        if !(step > LEAST + NOISE * best.0.sqrt() / speed) {
            break;
        }
        let is_end = best.1 == 0.0 || best.1 == 1.0;
        if !is_end {
            // As far to one side as to the other, for the parabola.
            step = step.min(best.1).min(1.0 - best.1);
        }
        let sides = [best.1 - step, best.1 + step].map(|s| {
            let s = s.clamp(0.0, 1.0);
            (squared(s), s)
        });
        let bend = sides[0].0 - 2.0 * best.0 + sides[1].0;
        let off = 0.5 * step * (sides[0].0 - sides[1].0) / bend;
        let is_bent = !is_end && bend > 0.0 && off.abs() < step;
        let side = if sides[1].0 < sides[0].0 {
            sides[1]
        } else {
            sides[0]
        };
        let middle = if is_bent && off != 0.0 {
            (squared(best.1 + off), best.1 + off)
        } else {
            best
        };
        if middle.0 < best.0 && middle.0 <= side.0 {
            best = middle;
            step = (SHRINK * step).max(0.25 * off.abs());
        } else if side.0 < best.0 {
            best = side;
            // From where a parabola has led astray it goes back as far as before.
            if step >= most {
                most *= 0.5;
            }
            step = (2.0 * step).min(most);
        } else if is_end || is_bent && off.abs() <= SHRINK * step {
            step *= SHRINK;
        } else {
            step *= 0.5;
            most = step;
        }
    }
    (best.0.sqrt(), best.1)
}

#[cfg(test)]
mod tests {
    use super::super::tests::bowl;
    use super::*;
    use crate::brep::{BrepBuilder, TrimSpec};
    use crate::numeric::Interval;
    use crate::nurbs::{Curve, Line, Plane, Polyline, Surface};

    /// The nearer sample is on the flat side of a fold, the point on the steep one.
    #[test]
    fn the_nearest_point_beyond_a_kink() {
        let fold = |s: f64| {
            let x = s - 25.5 / 32.0;
            Point2::new(s, if x < 0.0 { -0.5 * x } else { 8.0 * x })
        };
        // 44 halvings of 1/64 leave 2^-50, which the slope of 8 makes 2^-47 in space; with room for roundings.
        const NEAR: f64 = 1.0 / (1u64 << 44) as f64;
        let to = fold(25.7 / 32.0);
        let (off, s) = nearest(fold, &to);
        assert!(off < NEAR && (s - 25.7 / 32.0).abs() < NEAR, "{off} {s}");
    }

    /// Random curves, smooth and with kinks on samples: none of many points of them is nearer, and there are few that are looked at.
    #[test]
    fn the_nearest_point_of_random_curves() {
        const CURVES: usize = 400;
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
        };
        let asked = std::cell::Cell::new(0);
        for k in 0..CURVES {
            let c: [Point3<f64>; 4] =
                std::array::from_fn(|_| Point3::new(random(), random(), random()));
            let curve = |s: f64| {
                asked.set(asked.get() + 1);
                if k % 2 == 0 {
                    let (r, b) = (1.0 - s, [1.0, 3.0, 3.0, 1.0]);
                    let all = (0..4)
                        .map(|i| c[i].coords * (b[i] * r.powi(3 - i as i32) * s.powi(i as i32)));
                    Point3::from(all.sum::<Vector3<f64>>())
                } else {
                    // Corners at 1/4 and 3/4.
                    let corners = [0.0, 0.25, 0.75, 1.0];
                    let i = usize::from(s >= 0.25) + usize::from(s >= 0.75);
                    c[i] + (c[i + 1] - c[i]) * ((s - corners[i]) / (corners[i + 1] - corners[i]))
                }
            };
            let s = random() + 0.5;
            let off = Vector3::new(random(), random(), random()) * [0.0, 1e-9, 1e-3, 1.0][k % 4];
            let to = curve(s) + off;
            let (away, at) = nearest(curve, &to);
            assert_eq!(away, (curve(at) - to).norm(), "{k}");
            let samples = (0..=4096).map(|i| (curve(f64::from(i) / 4096.0) - to).norm());
            let least = samples.fold(off.norm(), f64::min);
            assert!(away <= least * (1.0 + 1e-12) + 1e-14, "{k}: {away} {least}");
        }
        let each = asked.get() / CURVES - 4099;
        assert!(each < 120, "{each}");
    }

    /// A comb of long teeth next to each other, as one trim.
    fn comb(surface: Surface) -> PreparedBrep {
        const TEETH: usize = 40;
        let width = 1.0 / TEETH as f64;
        let tops = (0..2 * TEETH).map(|k| {
            let y = if k % 2 == 0 { 0.5 } else { -0.4 };
            Point2::new(0.5 - 0.5 * (k as f64 + 0.25) * width, y)
        });
        let ends = [Point2::new(0.5, -0.5), Point2::new(-0.5, -0.5)];
        let corners: Vec<_> = [ends[0]].into_iter().chain(tops).chain([ends[1]]).collect();
        let params = (0..corners.len()).map(|k| k as f64).collect();
        let unit = Interval::new(0.0, 1.0).unwrap();
        let mut b = BrepBuilder::new();
        let ids = ends.map(|p| b.vertex([p.x, p.y, 0.0]));
        let curves = [
            Curve::Polyline(Polyline::new(corners, params).unwrap()),
            Curve::Line(Line::new(ends[1], ends[0], unit).unwrap()),
        ];
        let trims = [0, 1].into_iter().zip(curves).map(|(k, curve)| {
            let vertices = [ids[k], ids[1 - k]];
            let edge = Some(b.straight_edge(vertices).unwrap());
            TrimSpec {
                vertices,
                curve,
                edge,
            }
        });
        let trims = trims.collect();
        b.face_with_trims(surface, vec![trims]).unwrap();
        PreparedBrep::new(b.build().unwrap())
    }

    /// A plane, whose boxes are of control points, and a bowl, whose boxes are of samples.
    fn combs() -> [PreparedBrep; 2] {
        let d = Interval::new(-1.0, 1.0).unwrap();
        let plane = Plane {
            origin: Point3::new(1.0, 2.0, 3.0),
            x: Vector3::x(),
            y: Vector3::y(),
            domain: [d, d],
            extents: [d, d],
        };
        let bowl = bowl(0.25);
        [
            comb(Surface::Plane(plane)),
            comb(bowl.brep().surface(0).clone()),
        ]
    }

    /// What is left out by boxes is no nearer: all samples of all parts tell the same.
    #[test]
    fn boxes_leave_out_what_is_farther() {
        for brep in combs() {
            let trim = 0;
            assert!(brep.trim_parts(trim) > 16);
            let image = |s: f64| point(&brep, on_trim(&brep, trim, s));
            for k in 0..64 {
                let s = f64::from(k) / 64.0 + 0.004;
                let off = 0.5f64.powi(k % 32);
                let to = image(s) + Vector3::new(0.3, -0.5, 0.8) * off;
                let (all, at) = nearest_along(&brep, trim, image, &to);
                let found = nearest_on(&brep, trim, &to, f64::INFINITY);
                assert_eq!(found, Some((all, at)), "{s} {off}");
                assert_eq!(nearest_on(&brep, trim, &to, 1.5 * all), found);
                assert_eq!(nearest_on(&brep, trim, &to, 0.5 * all), None);
            }
        }
    }
}
