//! The least value next to a foot on a revolution, by the stored surface itself.
//!
//! The model of a [form](super::revolution) is off by its skew. A foot's parameters are known to some roundings all the same, and what the surface is there its own numbers say.
//!
//! # Method
//! Let the boxes of a foot hold every interior local minimum `m`, `w` be parameters in them, `d = (du, dv)` how far `m` is from `w` at most, and `f` half a squared distance, or a height.
//! The value at `w` is one of the face, and so a bound from above. Two bounds from below:
//! No point of the face's border is lower than the least in the boxes, if these are in the domain: of all angles the least is in theirs for each place on the profile, and of all these places, for an angle in
//! theirs, in the other's. So what is least there is an interior minimum, and a bound for the whole face.
//!
//! At `m` the objective is stationary, so at `w` it is larger by half its second derivative along `d` at most.
//! Let `r` bound the distance from the axis and `l` the profile's speed, and a circle's curvature times its square: then all derivatives of the surface along the profile, mixed or not, are
//! bounded by `l`, and those around the axis alone by `r`. Along `d` points move by `s = r du + l dv` at most, and a height grows by no more than half of
//! `t = r du^2 + 2 l du dv + l dv^2`, `f` by half of `s^2 + D t`, `D` the greatest distance from the target on the way.
//!
//! Where `f` is convex in all of the boxes it is no less at `m` than `f(w) - |f_u| du - |f_v| dv`. Of that next to nothing is taken away, as `w` is where a step of Newton's method leads from the parameters in f64.
//! The second derivatives at `w` are evaluated. With `k = max(r, l)` every derivative of the surface is `k` at most, so that each, and the surface, changes by no more than `c = k (du + dv)` within the boxes. A height's second
//! derivatives change by `|n| c`; those of `f`, a product of first derivatives and one of a second derivative with the way from the target, by `c (3 k + D)`.

use super::super::circle::{axes, cross};
use super::form::{
    Critical, Target, UP, V3, add, along, distance_range, dot, exact, range, scale, sub,
};
use super::revolution::RevolutionForm;
use crate::numeric::{Ball, Dd, Real, TINY, sin_cos};
use crate::nurbs::{Curve3, Revolution};
use nalgebra::Point3;

impl RevolutionForm {
    /// Bounds of what is least within the boxes of a foot, by the true surface, where the model is off by its skew; `None` where that tells no more. The foot's own parameters must
    /// be in the face's region, and all of their boxes.
    pub(super) fn at_foot(
        &self,
        surface: &Revolution,
        target: &Target,
        found: &Critical,
    ) -> Option<[Dd; 2]> {
        // Of several copies it need not be the first that is in the region.
        let alone = found.boxes.u.len() == 1 && found.boxes.v.len() == 1;
        if self.slack == 0.0 || !found.minimum.unique || !alone {
            return None;
        }
        let uv = found.minimum.uv;
        let off = self.spread(uv, &found.boxes)?;
        let [u, v] = self.split(uv).map(Ball::exact);
        let from = [self.angle_at(u), self.own_parameter(v)];
        let step = newton(&slopes(
            &self.jet(surface, from.map(|x| x.mid), target)?,
            target,
        ));
        // Parameters that are double-doubles, in the boxes: none is farther from them than from those before by more than the step.
        let steps = [0, 1].map(|k| {
            let by = step.map_or(0.0, |s| s[k]);
            let longest = (by.abs() + from[k].rad + 4.0 * Dd::UNIT * from[k].magnitude()) * UP;
            (by, longest)
        });
        if !(0..2).all(|k| steps[k].1 <= off[k][1]) {
            return None;
        }
        let place = [0, 1].map(|k| from[k].mid + Dd::from(steps[k].0));
        let [du, dv] = [0, 1].map(|k| (off[k][0] + steps[k].1) * UP);
        let jet = self.jet(surface, place, target)?;
        let [low, high] = match target {
            Target::Point(_) => distance_range(dot(&jet.arm, &jet.arm).sqrt(), 0.0),
            Target::Height(n, h) => range(self.fine.base(n, *h) + dot(&exact(n), &jet.arm), 0.0),
        };
        let grown = growth(self, target, [du, dv], length(&jet.arm));
        let slopes = slopes(&jet, target);
        let [fu, fv] = slopes.first.map(|x| x.magnitude());
        let by_slope = match target {
            Target::Height(..) => fu * du + fv * dv,
            // Of the square, not of half of it.
            Target::Point(_) => 2.0 * (fu * du + fv * dv),
        };
        let lower = if slopes.are_convex(grown.changed) {
            by_slope.min(grown.by_curvature)
        } else {
            grown.by_curvature
        };
        let lower = low - Dd::from(lower * UP);
        let unit = 4.0 * Dd::UNIT * lower.magnitude();
        let mut lower = lower - Dd::from(unit + TINY);
        if matches!(target, Target::Point(_)) && lower < Dd::ZERO {
            lower = Dd::ZERO;
        }
        Some([lower, high])
    }

    /// The surface, as seen from a target, and its derivatives by angle and the profile's own parameter: from the numbers that are stored, as the model's coordinates have lost some digits.
    fn jet(&self, surface: &Revolution, [u, v]: [Dd; 2], target: &Target) -> Option<SurfaceJet> {
        let exact_dd = |x: Dd| Ball::from_dd(x, 0.0);
        let origin = &self.fine.origin;
        let space = |p: &Point3<f64>| sub(&exact(p.coords.as_slice()), origin);
        let (p, d, bend) = match &surface.profile {
            Curve3::Arc(a) => {
                let (sin, cos) = sin_cos(exact_dd(v));
                let [x, y] = axes(a).map(|d| scale(&d, Ball::exact(a.radius)));
                let way = add(&scale(&x, cos), &scale(&y, sin));
                let along = sub(&scale(&y, cos), &scale(&x, sin));
                (add(&space(&a.center), &way), along, way.map(|x| -x))
            }
            Curve3::Line(l) => {
                let d = std::array::from_fn(|c| Ball::difference(l.to[c], l.from[c]));
                (along(&space(&l.from), exact_dd(v), &d), d, [Ball::ZERO; 3])
            }
            _ => return None,
        };
        // Where the surface and a target are far from the origin of space, sums of their coordinates would lose what they have in common.
        let from = match target {
            Target::Point(q) => sub(origin, &exact(q)),
            Target::Height(..) => [Ball::ZERO; 3],
        };
        let (sin, cos) = sin_cos(exact_dd(u));
        let turn = |v: &V3| Turn::new(v, &self.fine.axis);
        let [p, d, bend] = [turn(&p), turn(&d), turn(&bend)];
        Some(SurfaceJet {
            arm: add(&add(&from, &p.axial), &p.across(cos, sin)),
            first: [p.across(-sin, cos), add(&d.axial, &d.across(cos, sin))],
            second: [
                p.across(-cos, -sin),
                d.across(-sin, cos),
                add(&bend.axial, &bend.across(cos, sin)),
            ],
        })
    }
}

/// A vector to be turned about an axis (Rodrigues): what of it is along the axis, what is across, and that a quarter turn on.
struct Turn {
    axial: V3,
    ahead: V3,
    aside: V3,
}

impl Turn {
    fn new(v: &V3, axis: &V3) -> Self {
        let axial = scale(axis, dot(v, axis));
        Self {
            ahead: sub(v, &axial),
            aside: cross(axis, v),
            axial,
        }
    }

    /// `cos ahead + sin aside`, or what of these derivatives by the angle have.
    fn across(&self, ahead: Ball<Dd>, aside: Ball<Dd>) -> V3 {
        along(&scale(&self.ahead, ahead), aside, &self.aside)
    }
}

/// The way to a point of a surface, its derivatives by `u` and `v`, and by `uu`, `uv` and `vv`.
struct SurfaceJet {
    /// From the target or, of a height, from the model's origin.
    arm: V3,
    first: [V3; 2],
    second: [V3; 3],
}

/// The derivatives of half a squared distance, or of a height.
struct Slopes {
    first: [Ball<Dd>; 2],
    second: [Ball<Dd>; 3],
}

fn slopes(s: &SurfaceJet, target: &Target) -> Slopes {
    match target {
        Target::Height(n, _) => {
            let n = exact(n);
            Slopes {
                first: s.first.each_ref().map(|d| dot(&n, d)),
                second: s.second.each_ref().map(|d| dot(&n, d)),
            }
        }
        Target::Point(_) => {
            let [u, v] = &s.first;
            let squares = [dot(u, u), dot(u, v), dot(v, v)];
            Slopes {
                first: s.first.each_ref().map(|d| dot(&s.arm, d)),
                second: std::array::from_fn(|k| squares[k] + dot(&s.arm, &s.second[k])),
            }
        }
    }
}

impl Slopes {
    /// Whether the second derivatives are those of a convex function, each changed by so much at most.
    fn are_convex(&self, changed: f64) -> bool {
        let extra = |x: Ball<Dd>| Ball {
            mid: x.mid,
            rad: (x.rad + changed) * UP,
        };
        let [uu, uv, vv] = self.second.map(extra);
        uu.lower() > 0.0 && vv.lower() > 0.0 && (uu * vv - uv.square()).lower() > 0.0
    }
}

/// Where a step of Newton's method leads, rounded; `None` where that is no number.
fn newton(s: &Slopes) -> Option<[f64; 2]> {
    let [gu, gv] = s.first.map(|x| x.mid.hi);
    let [uu, uv, vv] = s.second.map(|x| x.mid.hi);
    let det = uu * vv - uv * uv;
    let step = [(uv * gv - vv * gu) / det, (uv * gu - uu * gv) / det];
    step.iter().all(|x| x.is_finite()).then_some(step)
}

/// See the module's description: of the objective (a squared distance, not half of it) and of the second derivatives that [`slopes`] tells.
#[derive(Debug)]
struct Growth {
    /// How much larger it is at `d` from a minimum at most.
    by_curvature: f64,
    /// By how much the second derivatives change.
    changed: f64,
}

/// Within `d` of a place at a distance from the target.
fn growth(form: &RevolutionForm, target: &Target, [du, dv]: [f64; 2], distance: f64) -> Growth {
    let (r, l) = form.sizes();
    let moved = (r * du + l * dv) * UP;
    let bent = (r * du * du + 2.0 * l * du * dv + l * dv * dv) * UP;
    let k = r.max(l);
    let change = k * (du + dv) * UP;
    match target {
        Target::Height(n, _) => {
            let length = n.iter().map(|x| x * x).sum::<f64>().sqrt() * UP;
            Growth {
                by_curvature: 0.5 * length * bent * UP,
                changed: length * change * UP,
            }
        }
        Target::Point(_) => {
            let most = distance + moved;
            Growth {
                by_curvature: (moved * moved + most * bent) * UP,
                changed: change * (3.0 * k + most) * UP,
            }
        }
    }
}

/// From above.
fn length(v: &V3) -> f64 {
    v.iter().map(|x| x.magnitude().powi(2)).sum::<f64>().sqrt() * UP
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Interval;
    use crate::nurbs::{Arc, Line};
    use nalgebra::{Rotation3, Vector3};

    /// Differences are taken over so much: what they leave out is its square, times derivatives of some 10.
    const STEP: f64 = 1.0 / (1u64 << 30) as f64;
    const LEFT_OUT: f64 = 100.0 * STEP * STEP;

    struct Random(u64);

    impl Random {
        fn between(&mut self, low: f64, high: f64) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
        }
    }

    /// A part of a torus, or of a cone, in some frame, with its form, and a target.
    fn scene(random: &mut Random, round: usize) -> (Revolution, RevolutionForm, Target) {
        let mut vector = |size: f64| Vector3::from_fn(|_, _| random.between(-size, size));
        let frame = Rotation3::new(vector(2.0));
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|v| frame * v);
        let origin = Point3::from(vector(9.0));
        let (q, n) = (origin + vector(4.0), vector(1.0));
        let range = Interval::new(-2.0, 3.0).unwrap();
        let profile = if round.is_multiple_of(2) {
            let arc = Arc {
                center: origin + x * 3.0,
                x,
                y: z,
                z: -y,
                radius: 0.75,
                angle: range,
                domain: range,
            };
            Curve3::Arc(Arc::new(arc).unwrap())
        } else {
            Curve3::Line(Line {
                from: origin + x * 2.0 - z,
                to: origin + x * 0.5 + z * 3.0,
                domain: Interval::new(0.0, 1.0).unwrap(),
            })
        };
        let surface = Revolution {
            origin,
            axis: z,
            angle: range,
            angle_domain: range,
            profile,
            transposed: round.is_multiple_of(3),
        };
        let surface = Revolution::new(surface).unwrap();
        let form = RevolutionForm::new(&surface, 8.0).unwrap();
        let target = if round % 4 < 2 {
            Target::Point([q.x, q.y, q.z])
        } else {
            Target::Height([n.x, n.y, n.z], 0.5)
        };
        (surface, form, target)
    }

    /// Derivatives are those of differences, and the way that of the form's own point.
    #[test]
    fn jets_are_those_of_the_surface() {
        let mut random = Random(0x51ed_270b_9f1c_a0e5);
        for round in 0..60 {
            let (surface, form, target) = scene(&mut random, round);
            let own = [random.between(-1.9, 2.9), random.between(0.05, 0.95)];
            let jet = |by: [f64; 2]| {
                let at = [0, 1].map(|k| Dd::from(own[k]) + Dd::from(by[k]));
                form.jet(&surface, at, &target).unwrap()
            };
            let middle = jet([0.0; 2]);
            let p = form.point(form.join(own[0], own[1]));
            let from = match target {
                Target::Point(q) => exact(&q),
                Target::Height(..) => form.fine.origin,
            };
            let near = |a: &V3, b: &V3, off: f64| {
                (0..3).all(|c| (a[c] - b[c]).mid.hi.abs() <= off + a[c].rad + b[c].rad)
            };
            assert!(near(&middle.arm, &sub(&p, &from), 0.0), "{round}");
            let rate = |k: usize, of: &dyn Fn(&SurfaceJet) -> V3| {
                let mut by = [0.0; 2];
                by[k] = STEP;
                let after = of(&jet(by));
                by[k] = -STEP;
                scale(&sub(&after, &of(&jet(by))), Ball::exact(0.5 / STEP))
            };
            let wanted = [
                (rate(0, &|j| j.arm), middle.first[0]),
                (rate(1, &|j| j.arm), middle.first[1]),
                (rate(0, &|j| j.first[0]), middle.second[0]),
                (rate(1, &|j| j.first[0]), middle.second[1]),
                (rate(0, &|j| j.first[1]), middle.second[1]),
                (rate(1, &|j| j.first[1]), middle.second[2]),
            ];
            for (k, (rate, told)) in wanted.iter().enumerate() {
                assert!(near(rate, told, LEFT_OUT), "{round} {k}: {rate:?} {told:?}");
            }
            let all = [0, 1].map(|k| {
                let value = |j: &SurfaceJet| match target {
                    Target::Point(_) => dot(&j.arm, &j.arm) * Ball::exact(0.5),
                    Target::Height(n, _) => dot(&exact(&n), &j.arm),
                };
                let mut by = [0.0; 2];
                by[k] = STEP;
                let after = jet(by);
                by[k] = -STEP;
                let before = jet(by);
                let rate = |x: Ball<Dd>| (x.mid * Dd::from(0.5 / STEP)).hi;
                let slope = rate(value(&after) - value(&before));
                let bends = [0, 1].map(|c| {
                    let of = |j: &SurfaceJet| slopes(j, &target).first[c];
                    rate(of(&after) - of(&before))
                });
                (slope, bends)
            });
            let told = slopes(&middle, &target);
            for k in 0..2 {
                assert!(
                    (all[k].0 - told.first[k].mid.hi).abs() < LEFT_OUT,
                    "{round} {k}"
                );
                for c in 0..2 {
                    let second = told.second[k + c].mid.hi;
                    assert!(
                        (all[k].1[c] - second).abs() < 4.0 * LEFT_OUT,
                        "{round} {k} {c}"
                    );
                }
            }
        }
    }

    /// Second derivatives elsewhere differ by no more than is said, over ways from next to nothing to most of the surface.
    #[test]
    fn what_second_derivatives_change_by() {
        let mut random = Random(0x2c1b_3c6d_a4f0_9e13);
        let mut nearest = 0.0f64;
        for round in 0..4000 {
            let (surface, form, target) = scene(&mut random, round);
            let size = 10f64.powf(random.between(-9.0, 0.0));
            let own = [random.between(-1.0, 2.0), random.between(0.3, 0.7)];
            let d = [
                random.between(-size, size),
                random.between(-0.3 * size, 0.3 * size),
            ];
            let at = |s: f64| {
                let at = [0, 1].map(|k| Dd::from(own[k] + s * d[k]));
                form.jet(&surface, at, &target).unwrap()
            };
            let (here, there) = (at(0.0), at(1.0));
            let grown = growth(&form, &target, d.map(f64::abs), length(&here.arm));
            let (a, b) = (slopes(&here, &target), slopes(&there, &target));
            for k in 0..3 {
                let change = (a.second[k] - b.second[k]).lower().abs();
                assert!(change <= grown.changed, "{round} {k}: {change:e} {grown:?}");
                nearest = nearest.max(change / grown.changed);
            }
        }
        // What is said is not far from what is: a bound that is larger by orders would not be tested.
        assert!(nearest > 0.1, "{nearest}");
    }

    #[test]
    fn what_is_convex() {
        let second = |uu: f64, uv: f64, vv: f64| Slopes {
            first: [Ball::ZERO; 2],
            second: [uu, uv, vv].map(Ball::exact),
        };
        assert!(second(2.0, 1.0, 1.0).are_convex(0.0));
        assert!(second(2.0, 1.0, 1.0).are_convex(0.1));
        // The least eigenvalue is 0.38: with 0.2 on either side the determinant may vanish.
        assert!(!second(2.0, 1.0, 1.0).are_convex(0.3));
        assert!(!second(-2.0, 0.0, -1.0).are_convex(0.0));
        assert!(!second(1.0, 1.5, 1.0).are_convex(0.0));
        assert!(!second(1.0, 0.0, f64::NAN).are_convex(0.0));
    }
}
