//! Whether f has a local minimum over a face at a place on its border: see `contacts`.

use super::contacts::{KNOT, most_apart};
use super::number::{Ball, Interval64, Number};
use super::region::Place;
use super::search::{Goal, Kind, Scene};

/// Places on a pole that are looked at.
const POLE_PARTS: u32 = 16;
/// Steps to the sides of an arc that are tried, as parts of the domain.
const STEPS: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-9];
/// Parts of arcs looked at for one step.
const PARTS: usize = 4000;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Standing {
    Stands,
    Falls,
    Open(&'static str),
}

/// By the signs of what must all rise.
pub(super) fn all_rise(rises: &[Ball]) -> Standing {
    if rises.iter().any(Number::is_negative) {
        Standing::Falls
    } else if rises.iter().all(Number::is_positive) {
        Standing::Stands
    } else {
        Standing::Open("f is level along a border")
    }
}

pub(super) fn both(a: Standing, b: Standing) -> Standing {
    match (a, b) {
        (Standing::Falls, _) | (_, Standing::Falls) => Standing::Falls,
        (Standing::Open(why), _) | (_, Standing::Open(why)) => Standing::Open(why),
        _ => Standing::Stands,
    }
}

/// Near `t` along an arc.
pub(super) type Own = (usize, f64);

/// f raised by `by` (or lowered) in the units of a length.
fn raised(goal: &Goal, f: &Interval64, by: f64) -> Interval64 {
    match goal {
        Goal::Distance(_) => {
            let d = f.times(&Interval64::exact(2.0)).root();
            let d = d.plus(&Interval64::exact(by));
            if d.is_positive() {
                d.squared().times(&Interval64::exact(0.5))
            } else {
                Interval64::zero()
            }
        }
        Goal::Plane(..) => f.plus(&Interval64::exact(by)),
    }
}

impl Scene<'_> {
    pub(super) fn lengths(&self, face: usize) -> [f64; 2] {
        self.faces[face]
            .shape
            .domain
            .map(|d| (d.end - d.start).abs().max(f64::MIN_POSITIVE))
    }

    /// The gradient of f in uv over all cells that touch the place.
    fn gradient(&self, goal: &Goal, face: usize, uv: &[Ball; 2]) -> Option<[Ball; 2]> {
        let wide = uv
            .each_ref()
            .map(|x| x.widened(KNOT * x.magnitude().max(KNOT)));
        let jet = self.faces[face].shape.jet_across(&wide)?;
        Some([goal.first(&jet.p, &jet.u), goal.first(&jet.p, &jet.v)])
    }

    /// Whether within the box `uv` +- `r` there is nothing of the loops but what belongs to the arcs of `own`,
    /// near their parameters, each going one way there.
    fn alone(&self, face: usize, uv: [f64; 2], r: [f64; 2], own: &[Own]) -> bool {
        let arcs = &self.faces[face].region.arcs;
        let mut near: Vec<(usize, f64, f64)> = Vec::new();
        for (arc, t) in own {
            let piece = &arcs[*arc].piece;
            let Some(at) = piece.jet(&Interval64::exact(*t)) else {
                return false;
            };
            let tangent: [f64; 2] = std::array::from_fn(|c| at.d[c].middle().lo() / r[c]);
            let speed = tangent[0].hypot(tangent[1]);
            let w = 4.0 / speed;
            if !w.is_finite() {
                return false;
            }
            let (a, b) = ((t - w).max(0.0), (t + w).min(1.0));
            let Some(all) = piece.jet(&Interval64::new(a, b)) else {
                return false;
            };
            let mut along = Interval64::zero();
            for c in 0..2 {
                along = along.plus(&all.d[c].times(&Interval64::exact(tangent[c] / r[c])));
            }
            if !along.is_positive() {
                return false;
            }
            near.push((*arc, a, b));
        }
        let mut budget = PARTS;
        for arc in 0..arcs.len() {
            let mut stack = vec![(0.0, 1.0)];
            while let Some((a, b)) = stack.pop() {
                if budget == 0 {
                    return false;
                }
                budget -= 1;
                if near.iter().any(|(o, c, d)| *o == arc && *c <= a && b <= *d) {
                    continue;
                }
                let part = self.faces[face].region.part(arc, &Interval64::new(a, b));
                let clear = (0..2).any(|c| part.lo[c] > uv[c] + r[c] || part.hi[c] < uv[c] - r[c]);
                if clear {
                    continue;
                }
                let m = 0.5 * (a + b);
                let tiny = (0..2).all(|c| part.hi[c] - part.lo[c] < r[c] / 16.0);
                if tiny || !(a < m && m < b) {
                    return false;
                }
                stack.extend([(a, m), (m, b)]);
            }
        }
        true
    }

    /// The direction from an arc into the region, in uv.
    fn inward(&self, face: usize, arc: usize, t: f64) -> Option<[f64; 2]> {
        let region = &self.faces[face].region;
        let lengths = self.lengths(face);
        let at = region.arcs[arc].piece.jet(&Interval64::exact(t))?;
        let uv = at.p.each_ref().map(|x| x.middle().lo());
        let d: [f64; 2] = std::array::from_fn(|c| at.d[c].middle().lo() / lengths[c]);
        let speed = d[0].hypot(d[1]);
        let normal = [-d[1] / speed * lengths[0], d[0] / speed * lengths[1]];
        if !normal.iter().all(|x| x.is_finite()) {
            return None;
        }
        for step in STEPS {
            let r = lengths.map(|l| 4.0 * step * l);
            if !self.alone(face, uv, r, &[(arc, t)]) {
                continue;
            }
            let place = |sign: f64| {
                let q: [Interval64; 2] =
                    std::array::from_fn(|c| Interval64::exact(uv[c] + sign * step * normal[c]));
                region.place(&q)
            };
            return match (place(1.0), place(-1.0)) {
                (Place::Inside, Place::Outside) => Some(normal),
                (Place::Outside, Place::Inside) => Some(normal.map(|x| -x)),
                _ => None,
            };
        }
        None
    }

    /// How f changes into the region, at a point of an arc.
    pub(super) fn rises_inward(&self, goal: &Goal, face: usize, arc: usize, t: &Ball) -> Standing {
        let parts = (
            self.inward(face, arc, t.middle().lo()),
            self.faces[face].region.arcs[arc].piece.jet(t),
        );
        let (Some(n), Some(c)) = parts else {
            return Standing::Open("the side of an arc on which the region lies");
        };
        let Some(g) = self.gradient(goal, face, &c.p) else {
            return Standing::Open("no derivative");
        };
        let rise = g[0]
            .times(&Ball::exact(n[0]))
            .plus(&g[1].times(&Ball::exact(n[1])));
        all_rise(&[rise])
    }

    /// f along the parameter `axis` on both sides of a place that is on a side of the domain, on a crease or in a
    /// corner; by each cell's own formula.
    pub(super) fn rises_across(
        &self,
        goal: &Goal,
        face: usize,
        uv: &[Ball; 2],
        axes: &[usize],
    ) -> Standing {
        let shape = &self.faces[face].shape;
        let about = |c: usize| {
            let x = &uv[c];
            shape.met(c, &x.widened(KNOT * x.magnitude().max(KNOT)))
        };
        let mut rises = Vec::new();
        for i in about(0) {
            for j in about(1) {
                let cell = [i, j];
                let Some(jet) = shape.jet(cell, uv) else {
                    return Standing::Open("no derivative");
                };
                let g = [goal.first(&jet.p, &jet.u), goal.first(&jet.p, &jet.v)];
                for c in axes {
                    let range = &shape.ranges[*c][cell[*c]];
                    // Into the cell.
                    let half = range.from.plus(&range.to).times(&Ball::exact(0.5));
                    rises.push(if uv[*c].below(&half) {
                        g[*c].clone()
                    } else {
                        g[*c].negated()
                    });
                }
            }
        }
        all_rise(&rises)
    }

    /// Whether a way leads from a place, which `from` holds in space, to values lower by more than `join`, without
    /// rising by more: a jump of no more than `join` to a point of a straight segment in uv that starts at `uv`, and
    /// the rest of that segment, all of which belongs to the region.
    pub(super) fn falls_far(
        &self,
        goal: &Goal,
        face: usize,
        uv: &[Ball; 2],
        from: &[[f64; 2]; 3],
        join: f64,
    ) -> bool {
        const WAYS: [[f64; 2]; 8] = [
            [1.0, 0.0],
            [0.7, 0.7],
            [0.0, 1.0],
            [-0.7, 0.7],
            [-1.0, 0.0],
            [-0.7, -0.7],
            [0.0, -1.0],
            [0.7, -0.7],
        ];
        const PIECES: u32 = 8;
        // The first piece goes on towards its start by such parts, to 1e-12 of it at most.
        const PART: f64 = 0.75;
        const PARTS: usize = 96;
        let parts = &self.faces[face];
        let lengths = self.lengths(face);
        let uv = uv.each_ref().map(|x| x.middle().lo());
        let space = |q: &[Interval64; 2]| Some(parts.shape.jet_across(q)?.p);
        let value = |q: &[Interval64; 2]| Some(goal.value(&space(q)?));
        let Some(start) = value(&uv.map(Interval64::exact)) else {
            return false;
        };
        let (most, least) = (
            raised(goal, &start, 0.5 * join),
            raised(goal, &start, -4.0 * join),
        );
        for step in STEPS {
            for way in WAYS {
                let at = |share: f64| -> [Interval64; 2] {
                    std::array::from_fn(|c| {
                        Interval64::exact(uv[c] + share * step * way[c] * lengths[c])
                    })
                };
                let piece = |a: f64, b: f64| -> [Interval64; 2] {
                    let (a, b) = (at(a), at(b));
                    std::array::from_fn(|c| a[c].hull(&b[c]))
                };
                let belongs = |q: &[Interval64; 2]| parts.region.place(q) == Place::Inside;
                let falls = (0..PIECES).all(|i| {
                    let q = piece(
                        f64::from(i) / f64::from(PIECES),
                        f64::from(i + 1) / f64::from(PIECES),
                    );
                    (i == 0 || belongs(&q)) && value(&q).is_some_and(|f| f.hi() <= most.hi())
                });
                if !falls || !value(&at(1.0)).is_some_and(|f| f.below(&least)) {
                    continue;
                }
                let mut end = 1.0 / f64::from(PIECES);
                for _ in 0..PARTS {
                    let next = PART * end;
                    if !belongs(&piece(next, end)) {
                        break;
                    }
                    let near = space(&at(next)).is_some_and(|p| {
                        most_apart(from, &p.each_ref().map(|x| [x.lo(), x.hi()])) <= join
                    });
                    if near {
                        return true;
                    }
                    end = next;
                }
            }
        }
        false
    }

    /// A joint of two arcs.
    pub(super) fn joint(&self, goal: &Goal, face: usize, arc: usize) -> Standing {
        let arcs = &self.faces[face].region.arcs;
        let Some(before) = (0..arcs.len()).find(|a| arcs[*a].next == arc) else {
            return Standing::Open("a loop that does not close");
        };
        let ends = (
            arcs[arc].piece.jet(&Ball::exact(0.0)),
            arcs[before].piece.jet(&Ball::exact(1.0)),
            self.gradient(goal, face, &arcs[arc].start),
        );
        let (Some(out), Some(back), Some(g)) = ends else {
            return Standing::Open("no derivative");
        };
        let along = |d: &[Ball; 2]| g[0].times(&d[0]).plus(&g[1].times(&d[1]));
        let rises = all_rise(&[along(&out.d), along(&back.d).negated()]);
        if rises != Standing::Stands {
            return rises;
        }
        let lengths = self.lengths(face);
        let unit = |d: &[Ball; 2], sign: f64| {
            let d: [f64; 2] = std::array::from_fn(|c| sign * d[c].middle().lo() / lengths[c]);
            let size = d[0].hypot(d[1]);
            d.map(|x| x / size)
        };
        let (a, b) = (unit(&out.d, 1.0), unit(&back.d, -1.0));
        let middle: [f64; 2] = std::array::from_fn(|c| a[c] + b[c]);
        let size = middle[0].hypot(middle[1]);
        /// Below this the sector is nearly straight.
        const STRAIGHT: f64 = 1e-3;
        // NaN too.
        if !(size > STRAIGHT) {
            return Standing::Open("a joint that is nearly smooth");
        }
        let uv = arcs[arc].start.each_ref().map(|x| x.middle().lo());
        for step in STEPS {
            let r = lengths.map(|l| 4.0 * step * l);
            if !self.alone(face, uv, r, &[(arc, 0.0), (before, 1.0)]) {
                continue;
            }
            let q: [Interval64; 2] = std::array::from_fn(|c| {
                Interval64::exact(uv[c] + step * middle[c] / size * lengths[c])
            });
            return match self.faces[face].region.place(&q) {
                Place::Inside => Standing::Stands,
                Place::Outside => Standing::Falls,
                Place::Mixed => Standing::Open("the sector at a joint"),
            };
        }
        Standing::Open("a joint next to other arcs")
    }

    /// An arc or a side that is one point in space; with a place on it from which f falls, if it does.
    pub(super) fn pole(
        &self,
        goal: &Goal,
        face: usize,
        kind: &Kind,
        x: &Ball,
    ) -> (Standing, Option<[Ball; 2]>) {
        for i in 0..POLE_PARTS {
            let share = (f64::from(i) + 0.5) / f64::from(POLE_PARTS);
            let t = x
                .lower()
                .plus(&x.upper().minus(&x.lower()).times(&Ball::exact(share)))
                .middle();
            let (one, uv) = match kind {
                Kind::Arc(a) => {
                    let at = self.faces[face].region.arcs[*a].piece.jet(&t);
                    (self.rises_inward(goal, face, *a, &t), at.map(|j| j.p))
                }
                Kind::Iso { fixed, at } => {
                    let uv = if *fixed == 0 {
                        [at.clone(), t]
                    } else {
                        [t, at.clone()]
                    };
                    let one = match self.faces[face].region.place(&uv) {
                        Place::Inside => self.rises_across(goal, face, &uv, &[*fixed]),
                        _ => Standing::Open("a pole on a border"),
                    };
                    (one, Some(uv))
                }
                _ => (Standing::Open("no pole"), None),
            };
            if one == Standing::Falls {
                return (one, uv);
            }
        }
        // That it rises is seen at samples alone.
        (Standing::Open("a pole"), None)
    }
}
