//! Upper bounds: points of the BREP where the objective is evaluated, and the descent that finds them.

use super::objective::Sample;
use super::search::{Foot, Locus, Search, Source};
use crate::numeric::{Ball, Dd};
use crate::trim::Side;
use nalgebra::Point2;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

impl Search<'_> {
    pub(super) fn guide_value(&self, source: Source, p: [f64; 2]) -> f64 {
        self.net(source).map_or(f64::INFINITY, |net| {
            self.objective.guide(net, p[0], p[1]).value
        })
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
        let mut p = start;
        let mut g = self.objective.guide(net, p[0], p[1]);
        for _ in 0..MAX_NEWTON {
            let blocked: [bool; 2] = std::array::from_fn(|k| {
                range[k][0] == range[k][1]
                    || (p[k] <= range[k][0] && g.slope[k] > 0.0)
                    || (p[k] >= range[k][1] && g.slope[k] < 0.0)
            });
            if blocked[0] && blocked[1] {
                break;
            }
            let mut step = newton_step(g.slope, g.curvature, blocked);
            let mut better = false;
            for _ in 0..MAX_DAMPING {
                let next: [f64; 2] =
                    std::array::from_fn(|k| (p[k] + step[k]).clamp(range[k][0], range[k][1]));
                if next == p {
                    break;
                }
                let trial = self.objective.guide(net, next[0], next[1]);
                if trial.value < g.value {
                    (p, g, better) = (next, trial, true);
                    break;
                }
                step = step.map(|x| 0.5 * x);
            }
            if !better {
                break;
            }
        }
        p
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
        let geometry = self.brep.double_double(face);
        let surface = &geometry.patches[patch];
        let at = |k: usize| surface.maps[k].to_native(p[k].hi.clamp(0.0, 1.0));
        let center = [at(0), at(1)];
        // The point itself, then its neighbours in f64, for points on a trim.
        for (du, dv) in NEIGHBOURS {
            let uv = [step_ulp(center[0], du), step_ulp(center[1], dv)];
            let within = |k: usize| surface.maps[k].start <= uv[k] && uv[k] <= surface.maps[k].end;
            if !(within(0) && within(1)) {
                continue;
            }
            let side = self.brep.region(face).side(Point2::new(uv[0], uv[1])).side;
            if !matches!(side, Some(Side::Inside | Side::Boundary)) {
                continue;
            }
            let local = [0, 1].map(|k| surface.maps[k].to_local(Ball::<Dd>::exact(uv[k])));
            let sample = self.objective.sample(&surface.net, local[0], local[1]);
            self.keep(
                &sample,
                Foot {
                    face,
                    trim,
                    uv: Point2::new(uv[0], uv[1]),
                    spot: Locus::Patch { patch, local },
                },
            );
            return;
        }
    }

    /// Evaluates a point of a patch that is known to be in the region.
    fn keep_patch_point(&mut self, face: usize, patch: usize, local: [Ball<Dd>; 2]) {
        let geometry = self.brep.double_double(face);
        let surface = &geometry.patches[patch];
        let sample = self.objective.sample(&surface.net, local[0], local[1]);
        let foot = Foot {
            face,
            trim: None,
            uv: Point2::new(
                surface.maps[0].to_native(local[0].mid.hi),
                surface.maps[1].to_native(local[1].mid.hi),
            ),
            spot: Locus::Patch { patch, local },
        };
        self.keep(&sample, foot);
    }

    fn try_piece_point(&mut self, face: usize, index: usize, t: Dd) {
        let geometry = self.brep.double_double(face);
        let piece = geometry.piece(index);
        let Some(space) = &piece.space else { return };
        let t = Ball { mid: t, rad: 0.0 };
        let (point, _) = crate::prepare::curve_jet(&piece.local, t);
        let local = [point[0] / point[2], point[1] / point[2]];
        let on_patch = local.iter().all(|x| x.lower() >= 0.0 && x.upper() <= 1.0);
        let maps = &geometry.patches[piece.patch].maps;
        if on_patch {
            let sample = self.objective.sample(space, t, Ball::ZERO);
            let uv = Point2::new(
                maps[0].to_native(local[0].mid.hi),
                maps[1].to_native(local[1].mid.hi),
            );
            self.keep(
                &sample,
                Foot {
                    face,
                    trim: piece.trim,
                    uv,
                    spot: Locus::Patch {
                        patch: piece.patch,
                        local,
                    },
                },
            );
        } else {
            // On the border of the patch, or past it by a rounding: the nearest point of the patch
            // counts if the exact test finds it in the region.
            let (patch, trim) = (piece.patch, piece.trim);
            self.try_patch_point(face, patch, [local[0].mid, local[1].mid], trim);
        }
    }

    fn keep(&mut self, sample: &Sample, foot: Foot) {
        let f = sample.value();
        let mut value = f.mid + Dd::from(f.rad * UP);
        value.lo = value.lo.next_up();
        if value < self.out.hi {
            self.out.hi = value;
            self.out.foot = Some(foot);
        }
    }
}

/// How many Newton steps and halvings of one; both are guides.
const MAX_NEWTON: usize = 24;
const MAX_DAMPING: usize = 10;
/// Rough values are compared with this relative slack.
const ROUGH_SLACK: f64 = 1e-9;
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
