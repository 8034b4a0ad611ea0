//! Revolutions of a segment or an arc whose plane holds the axis, up to a proven deviation.
//!
//! # Terms
//! An orthonormal frame at a point of the axis: `axis`, `e`, `b = axis x e`. A point of the stored profile has coordinates
//! `(a, b, h)` along `e`, `b`, `axis`. The frame is chosen so that `b` is small: `|b| <= skew` on the whole profile (zero up to
//! rounding, where the profile's plane holds the axis). The *model* is the revolution of the plane curve `(a, h)`, a segment or an
//! arc: a point of the true surface lies at most `3 skew` from the model's with the same parameters. (`b` itself moves it by `skew`,
//! the radius `sqrt(a^2 + b^2) - a` by as much; an arc's projection has the stored radius up to
//! `R - sqrt(R^2 - skew^2) <= skew`.)
//!
//! # Critical points
//! Let `q` be at distance `rho > 0` from the axis. For a fixed profile point at distance `r > 0`, the squared distance depends on the
//! angle through `-2 r rho cos`, so it has one minimum, where the profile point stands towards `q`. The azimuth of a profile point
//! is within `twist = 2 skew / min a` of that of `e`; so every local minimum has its angle within `twist` of the azimuth of
//! `q`. For a fixed angle the squared distance from a segment is a parabola, from an arc a sinusoid: one local minimum again,
//! a formula in the profile's own parameter. Both must hold at a local minimum of the surface: it is in one box, of which only
//! copies at whole turns may lie in the domain. For a height `n.x - h` the same holds with `-n`'s part across the axis
//! for `q`, but on a segment it is linear and has no minimum unless it is constant.
//!
//! Near a pole (`a` = 0 at an end of the profile, allowed where `skew` is all but zero) the azimuth of
//! profile points within `POLE` of it means nothing: such points are bounded by the pole itself, which is on the boundary,
//! within [`RevolutionForm::slack`].
//!
//! # Balls
//! An arc whose centre is exactly on the axis sweeps a part of the sphere about that centre, of the stored radius, whatever its plane and its skew: turning
//! keeps distances from points of the axis. So distances and heights have no slack, and only parameters are told by the model. With a pole, the azimuth of
//! points is off by more the nearer to it they are: of a point at `r` from the axis by `asin(skew / r)`, as its `b` is at most `skew`, where its `a` is positive.
//! `a` is negative at most on what the profile reaches past the axis, `-min a`; so all within the *hole*, `skew + max(0, -min a)`, is left out: of a foot nearer to the axis
//! than [`FAR`] holes nothing is said but the sphere's distance.
//!
//! A foot `p` farther from the axis than the hole is the only point that can be a local minimum inside the domain. Where the profile's height
//! along the axis is not stationary the surface is an open part of the sphere around each of its points, and only `p` has none nearer around it. It is stationary where an arc is
//! nearest to the axis, in the hole: there the surface is folded along a circle about the axis and lies outside of it. Of such a circle's points that
//! nearest to `p` has nearer ones outside towards `p`, the one farthest from it has nearer ones along the circle on both sides, and others along it on one.

use super::super::circle::{axes, cross, normalized};
use super::curve::{ClosedCurve, CurveShape, Of, UvPath};
use super::form::{
    Angle, Boxes, Copies, Critical, Extent, Linear, Minimum, SHARP, Target, UP, V3, Vector, add,
    along, angle, at_gap, distance_range, dot, exact, lead, least_square, range, rounded, scale,
    sub, unit,
};
use super::quadric::Quadric;
use super::sphere::SphereForm;
use crate::numeric::{Ball, Dd, Interval, Real, sin_cos};
use crate::nurbs::{Curve3, Revolution};

/// Profile points at `(a, b, h)`.
#[derive(Clone, Debug)]
pub(crate) enum Profile<T> {
    /// From the first to the second point as the parameter runs over its domain.
    Line {
        ends: [[Ball<T>; 3]; 2],
        /// How far the second is from the first along `a` and `h`, and the length of that.
        run: [Ball<T>; 2],
        length: Ball<T>,
    },
    /// `center + radius (cos x + sin y)`.
    Arc {
        center: [Ball<T>; 3],
        x: [Ball<T>; 3],
        y: [Ball<T>; 3],
        radius: f64,
        angle: Interval,
    },
}

/// The frame and the profile in one arithmetic.
#[derive(Clone, Debug)]
pub(crate) struct Model<T> {
    pub(crate) origin: Vector<T>,
    pub(crate) axis: Vector<T>,
    pub(crate) e: Vector<T>,
    pub(crate) b: Vector<T>,
    pub(crate) profile: Profile<T>,
}

#[derive(Clone, Debug)]
pub(crate) struct RevolutionForm {
    pub(crate) fine: Model<Dd>,
    /// The same rounded to f64: it finds where minima are, and values to f64.
    rough: Model<f64>,
    pub(crate) skew: f64,
    twist: Twist,
    /// The least distance of the profile from the axis, from below.
    pub(super) least_radius: f64,
    /// How far the true surface may be from the model, and points near a pole from it.
    pub(crate) slack: f64,
    /// Of this only what poles count for: the part by which curves on the boundary may be lower or higher than found.
    pub(crate) pole_slack: f64,
    angle: Interval,
    angle_domain: Interval,
    profile_domain: Interval,
    transposed: bool,
    /// The same surface exactly, where it is of the second order.
    pub(super) quadric: Option<Quadric>,
    /// The sphere that it is on, if it is.
    pub(crate) sphere: Option<SphereForm>,
}

/// How far the azimuth of a point of the profile may be from that of `e`.
#[derive(Clone, Copy, Debug)]
enum Twist {
    /// Anywhere on it.
    All(f64),
    /// More the nearer it is to the axis: of a ball with a pole and this hole around it.
    Hole(f64),
}

/// The target in the half-plane of the axis.
struct Flat<T> {
    /// What is across the axis, along `e` and `b`.
    across: [Ball<T>; 2],
    /// The length of that.
    rho: Ball<T>,
    /// What is along the axis.
    h: Ball<T>,
}

impl Model<Dd> {
    fn rounded(&self) -> Model<f64> {
        Model {
            origin: rounded(&self.origin),
            axis: rounded(&self.axis),
            e: rounded(&self.e),
            b: rounded(&self.b),
            profile: match &self.profile {
                Profile::Line { ends, run, length } => Profile::Line {
                    ends: ends.each_ref().map(rounded),
                    run: run.map(lead),
                    length: lead(*length),
                },
                Profile::Arc {
                    center,
                    x,
                    y,
                    radius,
                    angle,
                } => Profile::Arc {
                    center: rounded(center),
                    x: rounded(x),
                    y: rounded(y),
                    radius: *radius,
                    angle: *angle,
                },
            },
        }
    }

    /// The profile's point `(a, b, h)` and its derivative's direction at its own parameter.
    fn profile_at(&self, t: Ball<Dd>) -> (V3, V3) {
        match &self.profile {
            Profile::Line { ends: [p, q], .. } => {
                let d = sub(q, p);
                if t.rad == 0.0 && t.mid == Dd::ONE {
                    return (*q, d);
                }
                (along(p, t, &d), d)
            }
            Profile::Arc {
                center,
                x,
                y,
                radius,
                ..
            } => {
                let (sin, cos) = sin_cos(t);
                let r = Ball::exact(*radius);
                (
                    std::array::from_fn(|c| center[c] + r * (cos * x[c] + sin * y[c])),
                    std::array::from_fn(|c| cos * y[c] - sin * x[c]),
                )
            }
        }
    }

    /// A point or, from zero, a vector with coordinates `p`, turned by an angle.
    fn turned(&self, from: &V3, p: &V3, sin: Ball<Dd>, cos: Ball<Dd>) -> V3 {
        let a = cos * p[0] - sin * p[1];
        let b = sin * p[0] + cos * p[1];
        self.in_space(from, [a, b, p[2]])
    }
}

impl<T: Real> Model<T> {
    /// `from + a e + b b + h axis`.
    fn in_space(&self, from: &Vector<T>, [a, b, h]: [Ball<T>; 3]) -> Vector<T> {
        along(&along(&along(from, a, &self.e), b, &self.b), h, &self.axis)
    }

    /// `n` is taken against its direction: a height is least where `-n` points.
    fn flatten(&self, target: &Target) -> Flat<T> {
        let (v, sign) = match target {
            Target::Point(q) => (sub(&exact(q), &self.origin), Ball::ONE),
            Target::Height(n, _) => (exact(n), -Ball::<T>::ONE),
        };
        let across = [dot(&v, &self.e) * sign, dot(&v, &self.b) * sign];
        Flat {
            across,
            rho: (across[0].square() + across[1].square()).sqrt(),
            h: dot(&v, &self.axis),
        }
    }

    /// `n.origin - h`.
    pub(super) fn base(&self, n: &[f64; 3], h: f64) -> Ball<T> {
        dot(&exact(n), &self.origin) - Ball::exact(h)
    }

    /// Bounds of the least height on the whole model (on a segment: at its ends).
    fn height(&self, base: Ball<T>, flat: &Flat<T>, slack: f64) -> [Dd; 2] {
        match &self.profile {
            Profile::Line { ends, .. } => {
                let at = |p: &[Ball<T>; 3]| base + flat.h * p[2] - flat.rho * p[0];
                let [a, b] = [0, 1].map(|k| range(at(&ends[k]), 2.0 * slack));
                if a[0] < b[0] { a } else { b }
            }
            Profile::Arc { center, radius, .. } => {
                let length = (flat.rho.square() + flat.h.square()).sqrt();
                let center = base + flat.h * center[2] - flat.rho * center[0];
                range(center - Ball::exact(*radius) * length, 2.0 * slack)
            }
        }
    }

    /// How far a point is from the line or the circle of the profile, with a sign.
    fn gap(&self, flat: &Flat<T>) -> Ball<T> {
        match &self.profile {
            Profile::Line {
                ends: [p, _],
                run: [da, dh],
                length,
            } => (*da * (flat.h - p[2]) - *dh * (flat.rho - p[0])) / *length,
            Profile::Arc { center, radius, .. } => {
                let (x, y) = (flat.rho - center[0], flat.h - center[2]);
                (x.square() + y.square()).sqrt() - Ball::exact(*radius)
            }
        }
    }

    /// The unit vector along which the [gap](Self::gap) grows.
    fn up(&self, flat: &Flat<T>) -> Vector<T> {
        let [a, h] = match &self.profile {
            Profile::Line {
                run: [da, dh],
                length,
                ..
            } => [-*dh / *length, *da / *length],
            Profile::Arc { center, .. } => {
                let (x, y) = (flat.rho - center[0], flat.h - center[2]);
                let length = (x.square() + y.square()).sqrt();
                [x / length, y / length]
            }
        };
        let a = a / flat.rho;
        let zero = [Ball::ZERO; 3];
        self.in_space(&zero, [a * flat.across[0], a * flat.across[1], h])
    }

    /// The foot of a height on an arc; on a segment it has none, or all of it is.
    fn lowest(&self, flat: &Flat<T>) -> Option<Vector<T>> {
        let Profile::Arc { center, radius, .. } = &self.profile else {
            return None;
        };
        let length = (flat.rho.square() + flat.h.square()).sqrt();
        let s = Ball::exact(*radius) / length;
        let a = (center[0] + s * flat.rho) / flat.rho;
        let h = center[2] - s * flat.h;
        Some(self.in_space(&self.origin, [a * flat.across[0], a * flat.across[1], h]))
    }
}

/// A profile is in closed form when `skew` is below half this part of its least distance from the axis: places are then known to as much, some hundred roundings, and values at them to
/// the square of it...
const MOST_TWIST: f64 = 1.0 / (1u64 << 45) as f64;
/// ...and where it has a pole when `skew` is below this part of the model's size (about 1e-60; a frame along
/// the axes gives 1e-280). Points with `a` below 2^60 `skew`, about 1e-42 of the size, are those near the pole.
const NO_SKEW: f64 = 1e-60;
/// The azimuth of other profile points is within this of that of `e`.
const POLE_TWIST: f64 = 1.0 / (1u64 << 60) as f64;
/// Points near a pole are within this part of the size of it: 1e-42 over the least slope of the profile there, 2^-20.
const POLE: f64 = 1e-35;
const LEAST_SLOPE: f64 = 1.0 / (1u64 << 20) as f64;
/// A ball's hole is no more than this part of its radius, and azimuths are told so many holes from the axis: within some 2^-20.
const MOST_HOLE: f64 = 1.0 / (1u64 << 24) as f64;
const FAR: f64 = (1u64 << 20) as f64;
/// Whole turns, as f64; in truth 2 pi is larger by 2.45e-16.
const TURN: f64 = std::f64::consts::TAU;

/// From one angle to another; exactly where both are f64: a whole turn must not look as if it were more.
fn way(from: Ball<Dd>, to: Ball<Dd>) -> Ball<Dd> {
    let is_plain = |x: Ball<Dd>| x.rad == 0.0 && x.mid.lo == 0.0;
    if is_plain(from) && is_plain(to) {
        Ball::difference(to.mid.hi, from.mid.hi)
    } else {
        to - from
    }
}

impl RevolutionForm {
    pub(super) fn new(s: &Revolution, size: f64) -> Option<Self> {
        // More than a turn, up to rounding, would cover some points twice.
        if s.angle.end - s.angle.start > TURN * (1.0 + 4.0 * f64::EPSILON) {
            return None;
        }
        let axis = unit(&exact(s.axis.as_slice()))?;
        let origin = exact(s.origin.coords.as_slice());
        // Coordinates relative to the axis: along it, and the vector across.
        let across = |v: &V3| {
            let h = dot(v, &axis);
            (h, along(v, -h, &axis))
        };
        let domain = s.profile.domain();
        let middle = match &s.profile {
            Curve3::Line(l) => {
                let (from, to) = (
                    exact(l.from.coords.as_slice()),
                    exact(l.to.coords.as_slice()),
                );
                scale(&add(&from, &to), Ball::exact(0.5))
            }
            Curve3::Arc(a) => {
                let (sin, cos) = sin_cos(Ball::exact(a.angle.mid()));
                let [x, y] = axes(a);
                let d = add(&scale(&x, cos), &scale(&y, sin));
                along(
                    &exact(a.center.coords.as_slice()),
                    Ball::exact(a.radius),
                    &d,
                )
            }
            _ => return None,
        };
        let (_, r) = across(&sub(&middle, &origin));
        let e = unit(&r)?;
        let b = cross(&axis, &e);
        // `e` and `b` are orthogonal to the axis, whatever their balls hold: what of a vector is along it does not count.
        let coordinates = |v: &V3| {
            let (h, w) = across(v);
            let narrower = |d: &V3| {
                let [a, b] = [dot(v, d), dot(&w, d)];
                if b.rad < a.rad { b } else { a }
            };
            [narrower(&e), narrower(&b), h]
        };
        let (profile, skew, least_a, poles) = match &s.profile {
            Curve3::Line(l) => {
                let ends = [&l.from, &l.to]
                    .map(|p| coordinates(&sub(&exact(p.coords.as_slice()), &origin)));
                let skew = ends[0][1].magnitude().max(ends[1][1].magnitude());
                let least = ends[0][0].lower().min(ends[1][0].lower());
                let rise = (ends[1][0] - ends[0][0]).mid.hi.abs();
                let along = (ends[1][2] - ends[0][2]).mid.hi.abs();
                let run = [0, 2].map(|c| ends[1][c] - ends[0][c]);
                let length = (run[0].square() + run[1].square()).sqrt();
                let slopes = rise > LEAST_SLOPE * along;
                (Profile::Line { ends, run, length }, skew, least, slopes)
            }
            Curve3::Arc(a) => {
                let [x, y] = axes(a);
                let center = coordinates(&sub(&exact(a.center.coords.as_slice()), &origin));
                let (x, y) = (coordinates(&x), coordinates(&y));
                let skew = center[1].magnitude() + a.radius * (x[1].magnitude() + y[1].magnitude());
                if a.angle.end - a.angle.start > TURN * (1.0 + 4.0 * f64::EPSILON) {
                    return None;
                }
                let poles = center[0].magnitude() < 0.5 * a.radius;
                let profile = Profile::Arc {
                    center,
                    x,
                    y,
                    radius: a.radius,
                    angle: a.angle,
                };
                let least = least_distance(&profile)?;
                (profile, skew * (1.0 + 8.0 * f64::EPSILON), least, poles)
            }
            _ => return None,
        };
        let quadric = Quadric::new(s);
        let ball = match &quadric {
            Some(Quadric::Sphere { radius, .. }) => Some(*radius),
            _ => None,
        };
        let hole = (skew - least_a.min(0.0)) * (1.0 + 4.0 * f64::EPSILON);
        // (Of a pole with no skew at all the first would hold, and say nothing.)
        let (twist, slack, pole_slack) = if least_a > 0.0 && 2.0 * skew <= MOST_TWIST * least_a {
            let slack = if ball.is_some() { 0.0 } else { 3.1 * skew };
            (Twist::All(2.2 * skew / least_a), slack, 0.0)
        } else if poles && skew <= NO_SKEW * size && least_a >= -ON_AXIS * size {
            (Twist::All(POLE_TWIST), POLE * size, POLE * size)
        } else if ball.is_some_and(|radius| hole <= MOST_HOLE * radius) {
            (Twist::Hole(hole), POLE * size, POLE * size)
        } else {
            return None;
        };
        let fine = Model {
            origin,
            axis,
            e,
            b,
            profile,
        };
        let mut form = Self {
            rough: fine.rounded(),
            fine,
            skew,
            twist,
            least_radius: least_a,
            slack,
            pole_slack,
            angle: s.angle,
            angle_domain: s.angle_domain,
            profile_domain: domain,
            transposed: s.transposed,
            quadric,
            sphere: None,
        };
        form.sphere = SphereForm::new(&form);
        Some(form)
    }

    /// What it is called, by coordinates rounded to f64: nothing rests on it.
    pub(super) fn name(&self) -> &'static str {
        /// Of the profile's size: what is nearer counts as equal.
        const SAME: f64 = 1.0 / (1u64 << 40) as f64;
        match &self.fine.profile {
            Profile::Line { ends: [p, q], .. } => {
                let [a, _, h] = [0, 1, 2].map(|c| (q[c].mid.hi - p[c].mid.hi).abs());
                if a <= SAME * h {
                    "cylinder"
                } else if h <= SAME * a {
                    "disc"
                } else {
                    "cone"
                }
            }
            Profile::Arc { center, radius, .. } => {
                if center[0].mid.hi.abs() <= SAME * radius {
                    "sphere"
                } else {
                    "torus"
                }
            }
        }
    }

    /// The angles of its domain, in radians.
    pub(super) fn angle(&self) -> Interval {
        self.angle
    }

    /// The same as native parameters.
    pub(super) fn angle_domain(&self) -> Interval {
        self.angle_domain
    }

    /// Whether native parameters are profile's first.
    pub(super) fn transposed(&self) -> bool {
        self.transposed
    }

    /// Native angular parameter from an angle.
    pub(super) fn angular(&self) -> Linear {
        Linear {
            from: self.angle,
            to: self.angle_domain,
        }
    }

    pub(super) fn angle_at(&self, u: Ball<Dd>) -> Ball<Dd> {
        self.angular().inverse().at(u)
    }

    /// The profile's map from its own parameter (0 to 1 on a segment, the angle on an arc) to the native one.
    pub(super) fn profile_map(&self) -> Linear {
        Linear {
            from: match &self.fine.profile {
                Profile::Line { .. } => UNIT_INTERVAL,
                Profile::Arc { angle, .. } => *angle,
            },
            to: self.profile_domain,
        }
    }

    pub(super) fn own_parameter(&self, v: Ball<Dd>) -> Ball<Dd> {
        self.profile_map().inverse().at(v)
    }

    /// Angular and profile parameter, in this order.
    pub(super) fn split(&self, uv: [f64; 2]) -> [f64; 2] {
        if self.transposed { [uv[1], uv[0]] } else { uv }
    }

    pub(super) fn join<T>(&self, angular: T, profile: T) -> [T; 2] {
        if self.transposed {
            [profile, angular]
        } else {
            [angular, profile]
        }
    }

    pub(super) fn point(&self, uv: [f64; 2]) -> V3 {
        let [u, v] = self.split(uv).map(Ball::exact);
        let (sin, cos) = sin_cos(self.angle_at(u));
        let (p, _) = self.fine.profile_at(self.own_parameter(v));
        self.fine.turned(&self.fine.origin, &p, sin, cos)
    }

    pub(super) fn normal(&self, uv: [f64; 2]) -> [f64; 3] {
        let [u, v] = self.split(uv).map(Ball::exact);
        let (sin, cos) = sin_cos(self.angle_at(u));
        let (p, d) = self.fine.profile_at(self.own_parameter(v));
        let zero = [Ball::ZERO; 3];
        let slope = self.fine.turned(&zero, &d, sin, cos).map(|x| x.mid.hi);
        // The derivative by the angle: the part across, a quarter turn on.
        let around = self
            .fine
            .turned(&zero, &[-p[1], p[0], Ball::ZERO], sin, cos);
        let around = around.map(|x| x.mid.hi);
        let cross = |a: &[f64; 3], b: &[f64; 3]| {
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        if self.transposed {
            cross(&slope, &around)
        } else {
            cross(&around, &slope)
        }
    }

    /// The image of an iso-parameter segment: a parallel (an arc about the axis) or a meridian (the profile, turned).
    pub(super) fn iso_curve(&self, ends: [[Ball<Dd>; 2]; 2], of: Of) -> Option<ClosedCurve> {
        let same = |k: usize| {
            ends[0][k].rad == 0.0 && ends[1][k].rad == 0.0 && ends[0][k].mid == ends[1][k].mid
        };
        let (angular, profile) = if self.transposed { (1, 0) } else { (0, 1) };
        let mut ends = ends;
        if same(angular) {
            let (sin, cos) = sin_cos(self.angle_at(ends[0][angular]));
            match &self.fine.profile {
                Profile::Line { .. } => {
                    let at = |v| {
                        let (p, _) = self.fine.profile_at(self.own_parameter(v));
                        self.fine.turned(&self.fine.origin, &p, sin, cos)
                    };
                    let (a, b) = (at(ends[0][profile]), at(ends[1][profile]));
                    return Some(ClosedCurve::segment(a, b, ends, of));
                }
                Profile::Arc {
                    center,
                    x,
                    y,
                    radius,
                    ..
                } => {
                    let against = ends[1][profile].mid < ends[0][profile].mid;
                    if against {
                        ends.swap(0, 1);
                    }
                    let [from, to] = [0, 1].map(|k| self.own_parameter(ends[k][profile]));
                    let zero = [Ball::ZERO; 3];
                    let (s, c) = sin_cos(from);
                    let start: [Ball<Dd>; 3] = std::array::from_fn(|k| c * x[k] + s * y[k]);
                    let next: [Ball<Dd>; 3] = std::array::from_fn(|k| c * y[k] - s * x[k]);
                    let shape = CurveShape::arc(
                        self.fine.turned(&self.fine.origin, center, sin, cos),
                        self.fine.turned(&zero, &start, sin, cos),
                        self.fine.turned(&zero, &next, sin, cos),
                        Ball::exact(*radius),
                        way(from, to),
                    )?;
                    return Some(ClosedCurve {
                        against,
                        ..ClosedCurve::new(of, UvPath::straight(ends), shape)
                    });
                }
            }
        }
        if !same(profile) {
            return None;
        }
        let (p, _) = self.fine.profile_at(self.own_parameter(ends[0][profile]));
        let center = along(&self.fine.origin, p[2], &self.fine.axis);
        let radius = (p[0].square() + p[1].square()).sqrt();
        if radius.magnitude() < self.pole_slack {
            // A pole: a point within that slack.
            return Some(ClosedCurve::segment(center, center, ends, of));
        }
        if !(radius.lower() > radius.rad * HARDLY) {
            return None;
        }
        let against = ends[1][angular].mid < ends[0][angular].mid;
        if against {
            ends.swap(0, 1);
        }
        let [from, to] = [0, 1].map(|k| self.angle_at(ends[k][angular]));
        let (sin, cos) = sin_cos(from);
        let zero = [Ball::ZERO; 3];
        // Near a pole `a` has few digits, its direction all of them.
        let [a, b] = normalized(&[p[0], p[1]]);
        let unit = [a, b, Ball::ZERO];
        let next = [-unit[1], unit[0], Ball::ZERO];
        let shape = CurveShape::arc(
            center,
            self.fine.turned(&zero, &unit, sin, cos),
            self.fine.turned(&zero, &next, sin, cos),
            radius,
            way(from, to),
        )?
        .about(self.fine.axis);
        Some(ClosedCurve {
            against,
            ..ClosedCurve::new(of, UvPath::straight(ends), shape)
        })
    }

    /// The least value on the model, less the slack; for a squared distance on the whole of its line or circle.
    ///
    /// Of a distance in f64, which puts aside faces that are farther off; a height is least at the ends of a segment, and then as
    /// good as what is found there: to its last digits it puts aside the rest of the face.
    pub(super) fn least(&self, target: &Target) -> Dd {
        match target {
            Target::Point(_) => {
                let flat = self.rough.flatten(target);
                least_square(self.rough.gap(&flat), self.slack)
            }
            Target::Height(n, h) => {
                let base = self.fine.base(n, *h);
                let flat = self.fine.flatten(target);
                self.fine.height(base, &flat, self.slack)[0]
            }
        }
    }

    /// See the module's description; from numbers in f64.
    pub(super) fn critical(&self, target: &Target) -> Option<Critical> {
        self.critical_of(&self.rough, target)
    }

    /// The same from numbers in double-double.
    pub(super) fn critical_fine(&self, target: &Target) -> Option<Critical> {
        self.critical_of(&self.fine, target)
    }

    fn critical_of<T: Real>(&self, model: &Model<T>, target: &Target) -> Option<Critical> {
        let flat = model.flatten(target);
        let twist = self.twist_of_foot(model, target, &flat);
        let profile = self.critical_profile(model, target, &flat, twist)?;
        let mut azimuth = angle(flat.across[1], flat.across[0]);
        azimuth.off += twist;
        let known = azimuth.off < KNOWN;
        let (boxes, uv) = self.boxes(azimuth, profile.range, profile.at)?;
        let narrow = profile.range[1] - profile.range[0];
        let tells = known && narrow < 1.0;
        let mut up = [Ball::ZERO; 3];
        let (range, foot) = match target {
            Target::Point(q) => {
                let gap = model.gap(&flat);
                let foot = tells.then(|| model.up(&flat)).and_then(|fine| {
                    up = fine.map(|x| {
                        let x = x.to_dd();
                        Ball::from_dd(x.mid, x.rad)
                    });
                    // Next to a focal point, where squares are lost, a length may have no digits though its vector has.
                    let known = fine.iter().all(|x| x.rad < KNOWN_UP);
                    known.then(|| at_gap(q, gap, &fine))
                });
                (distance_range(gap, self.slack), foot)
            }
            Target::Height(n, h) => {
                let foot = model.lowest(&flat).filter(|_| tells);
                let foot = foot.map(|p| p.map(Ball::to_dd));
                (model.height(model.base(n, *h), &flat, self.slack), foot)
            }
        };
        let unique = foot.is_some();
        let point = foot.map_or_else(|| self.point(uv), |p| self.with_slack(p));
        // Around the axis: the growth of f over s^2 is rho / r for a distance, (rho / r) / 2 for a height.
        let radius = self.radius_at(&point);
        let grow = match target {
            Target::Point(_) => flat.rho.mid.approximate() / radius,
            Target::Height(..) => 0.5 * flat.rho.mid.approximate() / radius,
        };
        Some(Critical {
            boxes,
            minimum: Minimum {
                range: if unique {
                    range
                } else {
                    // The point is one of many, and not the lowest to the last digit.
                    [range[0], target.range_at(&point)[1]]
                },
                point,
                uv,
                uv_off: [0.0; 2],
                unique,
                // Next to a pole both radii may be noise, and the circle is a point.
                extent: Extent::Ring {
                    around: (1.0 / grow).sqrt(),
                    diameter: 2.0 * radius,
                    along: profile.reach,
                },
            },
            sharp: unique && azimuth.off < SHARP && narrow < SHARP,
            up,
        })
    }

    /// The same minimum to the last digits, of one that is sharp.
    pub(super) fn sharpened(&self, target: &Target, found: &Critical) -> Minimum {
        let flat = self.fine.flatten(target);
        let (range, point) = match target {
            Target::Point(q) => {
                let gap = self.fine.gap(&flat);
                let range = distance_range(gap, self.slack);
                (range, Some(at_gap(q, lead(gap), &found.up)))
            }
            Target::Height(n, h) => {
                let base = self.fine.base(n, *h);
                let range = self.fine.height(base, &flat, self.slack);
                (range, self.fine.lowest(&flat))
            }
        };
        Minimum {
            range,
            point: point.map_or(found.minimum.point, |p| self.with_slack(p)),
            ..found.minimum
        }
    }

    /// How far native parameters are at most from all others in the boxes that were made with them, and at least from those boxes' ends: as angle and profile's own parameter. `None` where they are not in the first.
    pub(super) fn spread(&self, uv: [f64; 2], boxes: &Boxes) -> Option<[[f64; 2]; 2]> {
        let off = |x: f64, copies: &Copies, map: &Linear| {
            let [low, high] = *copies.first()?;
            let scale = map.from.length() / map.to.length();
            let (from, to) = (x - low, high - x);
            let up = 1.0 + 16.0 * f64::EPSILON;
            let both = [from.max(to) * scale * up, from.min(to) * scale / up];
            (low <= x && x <= high).then_some(both)
        };
        let [u, v] = self.split(uv);
        let (us, vs) = if self.transposed {
            (&boxes.v, &boxes.u)
        } else {
            (&boxes.u, &boxes.v)
        };
        Some([
            off(u, us, &self.angular())?,
            off(v, vs, &self.profile_map())?,
        ])
    }

    /// Bounds of the distances from the axis and of the profile's derivatives by its own parameter.
    pub(super) fn sizes(&self) -> (f64, f64) {
        // The second is the skew at most: hardly more than the root of the squares, which may underflow.
        let far = |p: &V3| (p[0].magnitude() + p[1].magnitude()) * UP;
        match &self.fine.profile {
            Profile::Line {
                ends: [p, q],
                length,
                ..
            } => {
                let length = (length.magnitude() + 2.0 * self.skew) * UP;
                (far(p).max(far(q)), length)
            }
            Profile::Arc { center, radius, .. } => ((far(center) + radius) * UP, *radius),
        }
    }

    fn with_slack(&self, p: V3) -> V3 {
        p.map(|x| Ball {
            mid: x.mid,
            rad: x.rad + self.slack,
        })
    }

    /// The distance of a point from the axis, rounded.
    fn radius_at(&self, p: &V3) -> f64 {
        let w: [f64; 3] = std::array::from_fn(|c| p[c].mid.hi - self.rough.origin[c].mid);
        let along = |d: &Vector<f64>| (0..3).map(|c| w[c] * d[c].mid).sum::<f64>();
        let (a, b) = (along(&self.rough.e), along(&self.rough.b));
        (a * a + b * b).sqrt()
    }

    /// How far the azimuth of a profile point may be from that of `e`, where it is so far from the axis at least; infinite where nothing is known.
    pub(super) fn twist_at(&self, radius: f64) -> f64 {
        match self.twist {
            Twist::All(twist) => twist,
            Twist::Hole(hole) if radius > FAR * hole => 2.2 * self.skew / radius,
            Twist::Hole(_) => f64::INFINITY,
        }
    }

    /// How far a point of the surface may be from the profile's point at its parameter, turned into the half-plane of the axis that it is in: the true point is off the
    /// half-plane by `skew`, the model by no more than thrice that. What is past a pole is in the other half-plane, within the hole on both sides.
    pub(super) fn beside(&self) -> f64 {
        match self.twist {
            Twist::All(_) => 4.0 * self.skew,
            Twist::Hole(hole) => 4.0 * hole,
        }
    }

    /// How far points of a ball that the model tells are turned about the centre at most, near its poles by as much as the vector is longer than its part across the axis:
    /// beside what [`twist_at`](Self::twist_at) says everywhere.
    pub(super) fn most_turn(&self) -> f64 {
        match (self.twist, &self.fine.profile) {
            (Twist::Hole(hole), Profile::Arc { radius, .. }) => 2.2 * hole / radius,
            _ => self.twist_at(0.0),
        }
    }

    /// Whether it is exactly a part of a sphere.
    pub(super) fn is_ball(&self) -> bool {
        matches!(self.quadric, Some(Quadric::Sphere { .. }))
    }

    /// [`twist_at`](Self::twist_at) where a target's foot is. (On a ball the centre is on the axis, and the foot stands towards the target.)
    fn twist_of_foot<T: Real>(&self, model: &Model<T>, target: &Target, flat: &Flat<T>) -> f64 {
        match (&self.twist, &model.profile) {
            (Twist::Hole(_), Profile::Arc { center, radius, .. }) => {
                let up = match target {
                    Target::Point(_) => flat.h - center[2],
                    Target::Height(..) => flat.h,
                };
                let length = (flat.rho.square() + up.square()).sqrt();
                self.twist_at((Ball::exact(*radius) * flat.rho / length).lower())
            }
            // What is none is never asked.
            _ => self.twist_at(0.0),
        }
    }

    /// The boxes of native parameters that hold the points whose azimuth is that of a vector, and whose own
    /// profile parameter is in a range, and the parameters of one of them, rounded into the domain. `None` if none is near
    /// the domain.
    fn boxes(&self, azimuth: Angle, t_box: [f64; 2], t: f64) -> Option<(Boxes, [f64; 2])> {
        let map = self.profile_map();
        let (vs, v) = match &self.fine.profile {
            Profile::Line { .. } => (Copies::from_iter([map.range(t_box)]), map.rough(t)),
            Profile::Arc { angle, .. } => turns(t_box, t, *angle, &map)?,
        };
        let off = azimuth.off;
        let (us, u) = if off < KNOWN {
            let around = [azimuth.at - off, azimuth.at + off];
            turns(around, azimuth.at, self.angle, &self.angular())?
        } else {
            let d = self.angle_domain;
            (Copies::from_iter([[d.start, d.end]]), d.mid())
        };
        let domain = self.join(self.angle_domain, self.profile_domain);
        let uv = self.join(u, v);
        let uv = [0, 1].map(|k| uv[k].clamp(domain[k].start, domain[k].end));
        let [u, v] = self.join(us, vs);
        Some((Boxes { u, v }, uv))
    }

    /// The boxes of a point of the surface given relative to the origin: see [`boxes`](Self::boxes). The surface goes on beyond its domain: of a point with any azimuth
    /// the box is all angles, not only those of the domain, in which it need not be.
    pub(super) fn locate(&self, w: &V3) -> Option<(Boxes, [f64; 2])> {
        let (azimuth, around, at) = self.polar(w);
        let (mut boxes, uv) = self.boxes(azimuth, around, at)?;
        if !(azimuth.off < KNOWN) {
            let us = if self.transposed {
                &mut boxes.v
            } else {
                &mut boxes.u
            };
            *us = Copies::from_iter([[f64::NEG_INFINITY, f64::INFINITY]]);
        }
        Some((boxes, uv))
    }

    /// The azimuth of a point of the surface given relative to the origin, a range of the profile's own parameter that holds its own, and one in it.
    fn polar(&self, w: &V3) -> (Angle, [f64; 2], f64) {
        let (we, wb, h) = (
            dot(w, &self.fine.e),
            dot(w, &self.fine.b),
            dot(w, &self.fine.axis),
        );
        let rho = (we.square() + wb.square()).sqrt();
        let mut azimuth = angle(wb, we);
        azimuth.off += self.twist_at(rho.lower());
        match &self.fine.profile {
            Profile::Line { ends: [p, q], .. } => {
                let s = (h - p[2]) / (q[2] - p[2]);
                // Rounded outward a little more: `range` maps ends exactly, and this is none.
                let b = [s.lower().next_down(), s.upper().next_up()];
                (azimuth, b, s.mid.hi)
            }
            Profile::Arc {
                center,
                x,
                y,
                angle: range,
                ..
            } => {
                let (a, h) = (rho - center[0], h - center[2]);
                let extra = |b: Ball<Dd>| Ball {
                    mid: b.mid,
                    rad: b.rad + self.beside(),
                };
                let at = angle(extra(a * y[0] + h * y[2]), extra(a * x[0] + h * x[2]));
                let b = if at.off.is_finite() {
                    [at.at - at.off, at.at + at.off]
                } else {
                    [range.start, range.end]
                };
                (azimuth, b, at.at)
            }
        }
    }

    /// Where on the profile the minimum in the half-plane is.
    ///
    /// With `q` (or `-n`) turned away from the half-plane by at most `twist`, its coordinates there are `rho cos`, `rho
    /// sin`, off by `rho twist^2` and `rho twist`; the second counts `skew` over the profile's length at most. On a segment the minimum is where
    /// `(q - P).D = 0`, and the model leaves out `-P_b D_b` there, no more than `2 skew^2`.
    fn critical_profile<T: Real>(
        &self,
        model: &Model<T>,
        target: &Target,
        &Flat { rho, h, .. }: &Flat<T>,
        twist: f64,
    ) -> Option<OnProfile> {
        let turn = rho.magnitude() * twist * 1.01;
        match &model.profile {
            Profile::Line {
                ends: [p, _],
                run: [da, dh],
                length,
            } => {
                let off = turn * (twist * da.magnitude() + 2.0 * self.skew);
                if let Target::Height(..) = target {
                    let slope = h * *dh - rho * *da;
                    if slope.mid.magnitude() > 2.0 * (slope.rad + off) {
                        return None;
                    }
                    return Some(OnProfile {
                        range: [0.0, 1.0],
                        at: 0.5,
                        reach: f64::INFINITY,
                    });
                }
                let off = off + 2.0 * self.skew * self.skew;
                let square = length.square();
                let t = ((rho - p[0]) * *da + (h - p[2]) * *dh) / square;
                let off = off / square.lower() * (1.0 + 8.0 * f64::EPSILON);
                // Past an end by less than parameters in f64 tell, as next to the apex of a cone.
                if (t - Ball::ONE).lower() > off || (-t).lower() > off {
                    return None;
                }
                Some(OnProfile {
                    range: [(t.lower() - off).next_down(), (t.upper() + off).next_up()],
                    at: t.mid.approximate(),
                    reach: 1.0,
                })
            }
            Profile::Arc {
                center,
                x,
                y,
                radius,
                angle: whole,
            } => {
                let (da, dh) = match target {
                    Target::Point(_) => (rho - center[0], h - center[2]),
                    Target::Height(..) => (rho, -h),
                };
                let extra = |b: Ball<T>| Ball {
                    mid: b.mid,
                    rad: b.rad + turn * 2.0 + self.skew * 2.0,
                };
                let dx = extra(da * x[0] + dh * x[2]);
                let dy = extra(da * y[0] + dh * y[2]);
                let (a, b) = (da.mid.approximate(), dh.mid.approximate());
                let length = (a * a + b * b).sqrt();
                let grow = match target {
                    Target::Point(_) => length / radius,
                    Target::Height(..) => 0.5 * length / radius,
                };
                let at = angle(dy, dx);
                Some(if at.off.is_finite() {
                    OnProfile {
                        range: [at.at - at.off, at.at + at.off],
                        at: at.at,
                        reach: (1.0 / grow).sqrt(),
                    }
                } else {
                    OnProfile {
                        range: [whole.start, whole.end],
                        at: whole.mid(),
                        reach: f64::INFINITY,
                    }
                })
            }
        }
    }
}

/// A place on a profile, in its own parameter.
struct OnProfile {
    range: [f64; 2],
    /// One of them.
    at: f64,
    /// How far it extends along the profile: see [`Extent::Root`].
    reach: f64,
}

/// An azimuth known no better than this, in radians, is not known.
const KNOWN: f64 = 1.0;
/// Nor a unit vector no better than this.
const KNOWN_UP: f64 = 1.0 / (1u64 << 20) as f64;
const UNIT_INTERVAL: Interval = Interval {
    start: 0.0,
    end: 1.0,
};
/// A profile may reach past the axis by so much of the size: rounding, at a pole.
const ON_AXIS: f64 = 1e-28;
/// A circle with a radius known no better than this is none.
const HARDLY: f64 = (1u64 << 40) as f64;

/// The least `a` on an arc's profile: at an end, or at the circle's far side if the arc holds it.
fn least_distance(profile: &Profile<Dd>) -> Option<f64> {
    let Profile::Arc {
        center,
        x,
        y,
        radius,
        angle: range,
    } = profile
    else {
        return None;
    };
    let a = |t: f64| {
        let (sin, cos) = sin_cos(Ball::exact(t));
        (center[0] + Ball::exact(*radius) * (cos * x[0] + sin * y[0])).lower()
    };
    let far = angle(-y[0], -x[0]);
    if !far.off.is_finite() {
        return None;
    }
    let same = Linear {
        from: *range,
        to: *range,
    };
    let held = turns([far.at - far.off, far.at + far.off], far.at, *range, &same);
    let inner = if held.is_none() {
        f64::INFINITY
    } else {
        (center[0] - Ball::exact(*radius)).lower()
    };
    Some(a(range.start).min(a(range.end)).min(inner))
}

/// The images of those copies of a range of angles, at whole turns, that meet another, and that of the angle itself, moved with the first;
/// `None` if none does.
///
/// Neither range is longer than a turn, up to roundings: the whole numbers of turns by which one must be moved to meet the other are in
/// an interval hardly longer than 2, so they are three at most.
fn turns(b: [f64; 2], at: f64, range: Interval, map: &Linear) -> Option<(Copies, f64)> {
    // Angles are below 2^30, so a turn more or less is off by less than this.
    let size = range.start.abs().max(range.end.abs()) + b[0].abs().max(b[1].abs()) + 8.0;
    let off = 8.0 * f64::EPSILON * size;
    let (low, high) = (b[0] - off, b[1] + off);
    let least = ((range.start - high) / TURN).floor();
    let (mut copies, mut first) = (Copies::new(), None);
    for k in 0..=3 {
        let turn = TURN * (least + f64::from(k));
        if turn + low > range.end || copies.is_full() {
            break;
        }
        if turn + high >= range.start {
            copies.push(map.range([turn + low, turn + high]));
            first = first.or(Some(map.rough(at + turn)));
        }
    }
    Some((copies, first?))
}
