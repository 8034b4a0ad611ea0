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
//! Near a pole (`a` = 0 at an end of the profile, allowed only where `skew` is all but zero) the azimuth of
//! profile points within `POLE` of it means nothing: such points are bounded by the pole itself, which is on the boundary,
//! within [`RevolutionForm::slack`].

use super::super::circle::normalized;
use super::curve::{ClosedCurve, CurveShape, UvPath};
use super::form::{
    Angle, Critical, Extent, Linear, Minimum, Rough, Target, V3, add, along, angle, distance_range,
    dot, exact, least_square, range, scale, sub, unit,
};
use crate::numeric::{Ball, Dd, Interval, sin_cos};
use crate::nurbs::{Curve3, Revolution};

/// Profile points at `(a, b, h)`.
#[derive(Clone, Debug)]
pub(crate) enum Profile {
    /// From the first to the second point as the parameter runs over its domain.
    Line([[Ball<Dd>; 3]; 2]),
    /// `center + radius (cos x + sin y)`.
    Arc {
        center: [Ball<Dd>; 3],
        x: [Ball<Dd>; 3],
        y: [Ball<Dd>; 3],
        radius: f64,
        angle: Interval,
    },
}

#[derive(Clone, Debug)]
pub(crate) struct RevolutionForm {
    pub(crate) origin: V3,
    pub(crate) axis: V3,
    pub(crate) e: V3,
    pub(crate) b: V3,
    pub(crate) profile: Profile,
    rough: RoughModel,
    pub(crate) skew: f64,
    pub(crate) twist: f64,
    /// How far the true surface may be from the model, and points near a pole from it.
    pub(crate) slack: f64,
    /// Of this only what poles count for: the part by which curves on the boundary may be lower or higher than found.
    pub(crate) pole_slack: f64,
    angle: Interval,
    angle_domain: Interval,
    profile_domain: Interval,
    transposed: bool,
}

/// The model rounded to f64.
#[derive(Clone, Debug)]
struct RoughModel {
    origin: Rough,
    /// `e`, `b`, `axis`.
    frame: [Rough; 3],
    /// `(a, 0, h)` of the centre of an arc, or of the start of a segment.
    from: Rough,
    /// The radius of an arc, or the unit direction of a segment.
    shape: Result<f64, Rough>,
}

impl RoughModel {
    fn new(origin: &V3, frame: [&V3; 3], profile: &Profile) -> Self {
        let flat = |p: &[Ball<Dd>; 3]| Rough::new(&[p[0], Ball::ZERO, p[2]]);
        let (from, shape) = match profile {
            Profile::Arc { center, radius, .. } => (flat(center), Ok(*radius)),
            Profile::Line([p, q]) => {
                let (da, dh) = (q[0] - p[0], q[2] - p[2]);
                let length = (da.square() + dh.square()).sqrt();
                (flat(p), Err(flat(&[da / length, Ball::ZERO, dh / length])))
            }
        };
        Self {
            origin: Rough::new(origin),
            frame: frame.map(Rough::new),
            from,
            shape,
        }
    }

    /// How far a point is from the whole model (its circle or line turned all around), and a bound on the error.
    ///
    /// The distance from the axis is that of `(we, wb)`, and it and the height move the result by no more than they are off
    /// (distances are 1-Lipschitz); the roots, sums and products that follow are off by a few units of what they are made of, and by
    /// [`UNDERFLOW`] where squares vanish.
    fn distance(&self, q: &V3) -> (f64, f64) {
        let w = Rough::new(q).sub(&self.origin);
        let [(we, e1), (wb, e2), (h, e3)] = [0, 1, 2].map(|k| w.dot(&self.frame[k]));
        let rho = (we * we + wb * wb).sqrt();
        let (x, y) = (rho - self.from.v[0], h - self.from.v[2]);
        let mut size = rho + h.abs() + self.from.v[0].abs() + self.from.v[2].abs();
        let mut off = e1 + e2 + e3 + 2.0 * self.from.off() + UNDERFLOW;
        let gap = match &self.shape {
            Ok(radius) => {
                size += radius;
                (x * x + y * y).sqrt() - radius
            }
            Err(d) => {
                off += d.off() * (x.abs() + y.abs());
                d.v[0] * y - d.v[2] * x
            }
        };
        (gap, (off + 8.0 * f64::EPSILON * size) * 1.01)
    }
}

/// What a square below the least normal number, 2^-1022, can have been lost of a root: a square that underflows is
/// of a number below 2^-511, 1.5e-154.
const UNDERFLOW: f64 = 1e-150;

/// A profile is in closed form when `skew` is below this part of its least distance from the axis: what is within
/// `3 skew` of the model is then known to about 2^-52 of that distance...
const MOST_TWIST: f64 = 1.0 / (1u64 << 50) as f64;
/// ...and where it has a pole when `skew` is below this part of the model's size (about 1e-60; a frame along
/// the axes gives 1e-280). Points with `a` below 2^60 `skew`, about 1e-42 of the size, are those near the pole.
const NO_SKEW: f64 = 1e-60;
/// The azimuth of other profile points is within this of that of `e`.
const POLE_TWIST: f64 = 1.0 / (1u64 << 60) as f64;
/// Points near a pole are within this part of the size of it: 1e-42 over the least slope of the profile there, 2^-20.
const POLE: f64 = 1e-35;
const LEAST_SLOPE: f64 = 1.0 / (1u64 << 20) as f64;
/// Whole turns, as f64; in truth 2 pi is larger by 2.45e-16.
const TURN: f64 = std::f64::consts::TAU;

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
                let [x, y] = super::super::circle::axes(a);
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
        let b = std::array::from_fn(|c| {
            let (i, j) = ((c + 1) % 3, (c + 2) % 3);
            axis[i] * e[j] - axis[j] * e[i]
        });
        let coordinates = |v: &V3| [dot(v, &e), dot(v, &b), dot(v, &axis)];
        let (profile, skew, least_a, poles) = match &s.profile {
            Curve3::Line(l) => {
                let ends = [&l.from, &l.to]
                    .map(|p| coordinates(&sub(&exact(p.coords.as_slice()), &origin)));
                let skew = ends[0][1].magnitude().max(ends[1][1].magnitude());
                let least = ends[0][0].lower().min(ends[1][0].lower());
                let rise = (ends[1][0] - ends[0][0]).mid.hi.abs();
                let run = (ends[1][2] - ends[0][2]).mid.hi.abs();
                (Profile::Line(ends), skew, least, rise > LEAST_SLOPE * run)
            }
            Curve3::Arc(a) => {
                let [x, y] = super::super::circle::axes(a);
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
        let (twist, slack, pole_slack) = if 2.0 * skew <= MOST_TWIST * least_a {
            (2.2 * skew / least_a, 3.1 * skew, 0.0)
        } else if poles && skew <= NO_SKEW * size && least_a >= -ON_AXIS * size {
            (POLE_TWIST, POLE * size, POLE * size)
        } else {
            return None;
        };
        Some(Self {
            origin,
            axis,
            rough: RoughModel::new(&origin, [&e, &b, &axis], &profile),
            e,
            b,
            profile,
            skew,
            twist,
            slack,
            pole_slack,
            angle: s.angle,
            angle_domain: s.angle_domain,
            profile_domain: domain,
            transposed: s.transposed,
        })
    }

    /// What it is called, by coordinates rounded to f64: nothing rests on it.
    pub(super) fn name(&self) -> &'static str {
        /// Of the profile's size: what is nearer counts as equal.
        const SAME: f64 = 1.0 / (1u64 << 40) as f64;
        match &self.profile {
            Profile::Line([p, q]) => {
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

    /// Native angular parameter from an angle.
    fn angular(&self) -> Linear {
        Linear {
            from: self.angle,
            to: self.angle_domain,
        }
    }

    fn angle_at(&self, u: Ball<Dd>) -> Ball<Dd> {
        Linear {
            from: self.angle_domain,
            to: self.angle,
        }
        .at(u)
    }

    /// The profile's map from its own parameter (0 to 1 on a segment, the angle on an arc) to the native one.
    fn profile_map(&self) -> Linear {
        Linear {
            from: match &self.profile {
                Profile::Line(_) => UNIT_INTERVAL,
                Profile::Arc { angle, .. } => *angle,
            },
            to: self.profile_domain,
        }
    }

    fn own_parameter(&self, v: Ball<Dd>) -> Ball<Dd> {
        let map = self.profile_map();
        Linear {
            from: map.to,
            to: map.from,
        }
        .at(v)
    }

    /// The profile's point `(a, b, h)` and its derivative's direction at its own parameter.
    fn profile_at(&self, t: Ball<Dd>) -> ([Ball<Dd>; 3], [Ball<Dd>; 3]) {
        match &self.profile {
            Profile::Line([p, q]) => {
                let d: [Ball<Dd>; 3] = std::array::from_fn(|c| q[c] - p[c]);
                if t.rad == 0.0 && t.mid == Dd::ONE {
                    return (*q, d);
                }
                (std::array::from_fn(|c| p[c] + t * d[c]), d)
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
    fn turned(&self, from: &V3, p: &[Ball<Dd>; 3], sin: Ball<Dd>, cos: Ball<Dd>) -> V3 {
        let a = cos * p[0] - sin * p[1];
        let b = sin * p[0] + cos * p[1];
        along(
            &along(&along(from, a, &self.e), b, &self.b),
            p[2],
            &self.axis,
        )
    }

    /// Angular and profile parameter, in this order.
    fn split(&self, uv: [f64; 2]) -> [f64; 2] {
        if self.transposed { [uv[1], uv[0]] } else { uv }
    }

    fn join<T>(&self, angular: T, profile: T) -> [T; 2] {
        if self.transposed {
            [profile, angular]
        } else {
            [angular, profile]
        }
    }

    pub(super) fn point(&self, uv: [f64; 2]) -> V3 {
        let [u, v] = self.split(uv).map(Ball::exact);
        let (sin, cos) = sin_cos(self.angle_at(u));
        let (p, _) = self.profile_at(self.own_parameter(v));
        self.turned(&self.origin, &p, sin, cos)
    }

    pub(super) fn normal(&self, uv: [f64; 2]) -> [f64; 3] {
        let [u, v] = self.split(uv).map(Ball::exact);
        let (sin, cos) = sin_cos(self.angle_at(u));
        let (p, d) = self.profile_at(self.own_parameter(v));
        let zero = [Ball::ZERO; 3];
        let slope = self.turned(&zero, &d, sin, cos).map(|x| x.mid.hi);
        // The derivative by the angle: the part across, a quarter turn on.
        let around = self.turned(&zero, &[-p[1], p[0], Ball::ZERO], sin, cos);
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
    pub(super) fn iso_curve(
        &self,
        ends: [[Ball<Dd>; 2]; 2],
        trim: Option<usize>,
    ) -> Option<ClosedCurve> {
        let same = |k: usize| {
            ends[0][k].rad == 0.0 && ends[1][k].rad == 0.0 && ends[0][k].mid == ends[1][k].mid
        };
        let (angular, profile) = if self.transposed { (1, 0) } else { (0, 1) };
        let mut ends = ends;
        if same(angular) {
            let (sin, cos) = sin_cos(self.angle_at(ends[0][angular]));
            match &self.profile {
                Profile::Line(_) => {
                    let at = |v| {
                        let (p, _) = self.profile_at(self.own_parameter(v));
                        self.turned(&self.origin, &p, sin, cos)
                    };
                    let (a, b) = (at(ends[0][profile]), at(ends[1][profile]));
                    return Some(ClosedCurve::segment(a, b, ends, trim));
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
                        self.turned(&self.origin, center, sin, cos),
                        self.turned(&zero, &start, sin, cos),
                        self.turned(&zero, &next, sin, cos),
                        Ball::exact(*radius),
                        to - from,
                    )?;
                    return Some(ClosedCurve {
                        trim,
                        shape,
                        uv: UvPath::Straight(ends.map(|p| p.map(|x| x.mid.hi))),
                        moved: false,
                        after: None,
                        against,
                    });
                }
            }
        }
        if !same(profile) {
            return None;
        }
        let (p, _) = self.profile_at(self.own_parameter(ends[0][profile]));
        let center = along(&self.origin, p[2], &self.axis);
        let radius = (p[0].square() + p[1].square()).sqrt();
        if radius.magnitude() < self.slack {
            // A pole: a point within the surface's slack.
            return Some(ClosedCurve::segment(center, center, ends, trim));
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
            self.turned(&zero, &unit, sin, cos),
            self.turned(&zero, &next, sin, cos),
            radius,
            to - from,
        )?
        .about(self.axis);
        Some(ClosedCurve {
            trim,
            shape,
            uv: UvPath::Straight(ends.map(|p| p.map(|x| x.mid.hi))),
            moved: false,
            after: None,
            against,
        })
    }

    /// The target in the half-plane of the axis: what is across the axis (as `e`, `b` components), its length, and what
    /// is along.
    fn flatten(&self, target: &Target) -> ([Ball<Dd>; 2], Ball<Dd>, Ball<Dd>) {
        let (v, sign) = match target {
            Target::Point(q) => (sub(q, &self.origin), Ball::ONE),
            Target::Height(n, _) => (*n, -Ball::<Dd>::ONE),
        };
        let w = [dot(&v, &self.e) * sign, dot(&v, &self.b) * sign];
        (
            w,
            (w[0].square() + w[1].square()).sqrt(),
            dot(&v, &self.axis),
        )
    }

    /// `n.origin - h`.
    fn base(&self, target: &Target) -> Ball<Dd> {
        match target {
            Target::Point(_) => Ball::ZERO,
            Target::Height(n, h) => dot(n, &self.origin) - *h,
        }
    }

    /// The least value on the model, less the slack; for a squared distance on the whole of its line or circle.
    pub(super) fn least(&self, target: &Target) -> Dd {
        // In f64: it only puts aside faces that are farther off.
        if let Target::Point(q) = target {
            let (gap, off) = self.rough.distance(q);
            return least_square(gap, off + self.slack);
        }
        let (_, rho, h) = self.flatten(target);
        self.value(target, rho, h)[0]
    }

    /// Bounds of the least value on the whole model (on a segment: of a height, its ends).
    fn value(&self, target: &Target, rho: Ball<Dd>, h: Ball<Dd>) -> [Dd; 2] {
        match (target, &self.profile) {
            (Target::Point(_), Profile::Line([p, q])) => {
                let (da, dh) = (q[0] - p[0], q[2] - p[2]);
                let length = (da.square() + dh.square()).sqrt();
                let cross = da * (h - p[2]) - dh * (rho - p[0]);
                distance_range(cross / length, self.slack)
            }
            (Target::Point(_), Profile::Arc { center, radius, .. }) => {
                let (x, y) = (rho - center[0], h - center[2]);
                let off = (x.square() + y.square()).sqrt() - Ball::exact(*radius);
                distance_range(off, self.slack)
            }
            (Target::Height(..), Profile::Line(ends)) => {
                let base = self.base(target);
                let [a, b] = ends.map(|p| range(base + h * p[2] - rho * p[0], 2.0 * self.slack));
                if a[0] < b[0] { a } else { b }
            }
            (Target::Height(..), Profile::Arc { center, radius, .. }) => {
                let length = (rho.square() + h.square()).sqrt();
                let base = self.base(target) + h * center[2] - rho * center[0];
                range(base - Ball::exact(*radius) * length, 2.0 * self.slack)
            }
        }
    }

    /// See the module's description.
    pub(super) fn critical(&self, target: &Target) -> Critical {
        let (w, rho, h) = self.flatten(target);
        let (t_box, t, extent_profile) = match self.critical_profile(target, rho, h) {
            Some(found) => found,
            None => return Critical::None,
        };
        let azimuth = angle(w[1], w[0]);
        let known = azimuth.off + self.twist < KNOWN;
        let (boxes, uv) = match self.boxes(azimuth, t_box, t) {
            Some(found) => found,
            None => return Critical::None,
        };
        let unique = known && t_box[1] - t_box[0] < 1.0;
        let point = if unique {
            self.foot(target, w, rho, h)
        } else {
            self.point(uv)
        };
        // Around the axis: the growth of f over s^2 is rho / r for a distance, (rho / r) / 2 for a height.
        let radius = point_radius(self, &point);
        let grow = match target {
            Target::Point(_) => rho.mid.hi / radius,
            Target::Height(..) => 0.5 * rho.mid.hi / radius,
        };
        let around = (1.0 / grow).sqrt();
        Critical::Boxes {
            boxes,
            minimum: Minimum {
                range: if unique {
                    self.value(target, rho, h)
                } else {
                    // The point is one of many, and not the lowest to the last digit.
                    [self.value(target, rho, h)[0], target.range_at(&point)[1]]
                },
                point,
                uv,
                uv_off: [0.0; 2],
                unique,
                extent: Extent::Root(around.max(extent_profile)),
            },
        }
    }

    /// The boxes of native parameters that hold the points whose azimuth is that of a vector, within `twist`, and whose own
    /// profile parameter is in a range, and the parameters of one of them, rounded into the domain. `None` if none is near
    /// the domain.
    #[allow(clippy::type_complexity)] // Named nowhere else.
    fn boxes(
        &self,
        azimuth: Angle,
        t_box: [f64; 2],
        t: f64,
    ) -> Option<(Vec<[[f64; 2]; 2]>, [f64; 2])> {
        let map = self.profile_map();
        let native = |b: [f64; 2], t: f64| (map.range(b), map.rough(t));
        let v_boxes: Vec<([f64; 2], f64)> = match &self.profile {
            Profile::Line(_) => vec![native(t_box, t)],
            Profile::Arc { angle, .. } => {
                let copies = turns(t_box, t, *angle).into_iter();
                copies.map(|(b, t)| native(b, t)).collect()
            }
        };
        let off = azimuth.off + self.twist;
        let u_boxes: Vec<([f64; 2], f64)> = if off < KNOWN {
            let map = self.angular();
            let copies = turns([azimuth.at - off, azimuth.at + off], azimuth.at, self.angle);
            let native = |(b, a)| (map.range(b), map.rough(a));
            copies.into_iter().map(native).collect()
        } else {
            let d = self.angle_domain;
            vec![([d.start, d.end], d.mid())]
        };
        let (first_u, first_v) = (u_boxes.first()?, v_boxes.first()?);
        let uv = self.join(first_u.1, first_v.1);
        let domain = self.join(self.angle_domain, self.profile_domain);
        let uv = [0, 1].map(|k| uv[k].clamp(domain[k].start, domain[k].end));
        let pairs = v_boxes
            .iter()
            .flat_map(|v| u_boxes.iter().map(|u| self.join(u.0, v.0)));
        Some((pairs.collect(), uv))
    }

    /// The boxes of a point of the surface given relative to the origin: see [`boxes`](Self::boxes).
    #[allow(clippy::type_complexity)] // As above.
    pub(super) fn locate(&self, w: &V3) -> Option<(Vec<[[f64; 2]; 2]>, [f64; 2])> {
        let (we, wb, h) = (dot(w, &self.e), dot(w, &self.b), dot(w, &self.axis));
        let azimuth = angle(wb, we);
        match &self.profile {
            Profile::Line([p, q]) => {
                let s = (h - p[2]) / (q[2] - p[2]);
                // Rounded outward a little more: `range` maps ends exactly, and this is none.
                let b = [s.lower().next_down(), s.upper().next_up()];
                self.boxes(azimuth, b, s.mid.hi)
            }
            Profile::Arc {
                center,
                x,
                y,
                angle: range,
                ..
            } => {
                let rho = (we.square() + wb.square()).sqrt();
                let (a, h) = (rho - center[0], h - center[2]);
                // The true point is off the half-plane by `skew`, the model by no more than thrice that.
                let extra = |b: Ball<Dd>| Ball {
                    mid: b.mid,
                    rad: b.rad + 4.0 * self.skew,
                };
                let at = angle(extra(a * y[0] + h * y[2]), extra(a * x[0] + h * x[2]));
                let b = if at.off.is_finite() {
                    [at.at - at.off, at.at + at.off]
                } else {
                    [range.start, range.end]
                };
                self.boxes(azimuth, b, at.at)
            }
        }
    }

    /// Where on the profile, in its own parameter, the minimum in the half-plane is: a range, a value, and how far it
    /// extends along the profile.
    ///
    /// With `q` (or `-n`) turned away from the half-plane by at most `twist`, its coordinates there are `rho cos`, `rho
    /// sin`, off by `rho twist^2` and `rho twist`; the second counts `skew` over the profile's length at most.
    fn critical_profile(
        &self,
        target: &Target,
        rho: Ball<Dd>,
        h: Ball<Dd>,
    ) -> Option<([f64; 2], f64, f64)> {
        let turn = rho.magnitude() * self.twist * 1.01;
        match &self.profile {
            Profile::Line([p, q]) => {
                let (da, dh) = (q[0] - p[0], q[2] - p[2]);
                let square = da.square() + dh.square();
                if let Target::Height(..) = target {
                    let slope = h * dh - rho * da;
                    let off = slope.rad + turn * (self.twist * da.magnitude() + 2.0 * self.skew);
                    if slope.mid.hi.abs() > 2.0 * off {
                        return None;
                    }
                    return Some(([0.0, 1.0], 0.5, f64::INFINITY));
                }
                let t = ((rho - p[0]) * da + (h - p[2]) * dh) / square;
                let off = turn * (self.twist * da.magnitude() + 2.0 * self.skew) / square.lower();
                let off = off * (1.0 + 8.0 * f64::EPSILON);
                Some((
                    [(t.lower() - off).next_down(), (t.upper() + off).next_up()],
                    t.mid.hi,
                    1.0,
                ))
            }
            Profile::Arc {
                center,
                x,
                y,
                radius,
                ..
            } => {
                let (da, dh) = match target {
                    Target::Point(_) => (rho - center[0], h - center[2]),
                    Target::Height(..) => (rho, -h),
                };
                let extra = |b: Ball<Dd>| Ball {
                    mid: b.mid,
                    rad: b.rad + turn * 2.0 + self.skew * 2.0,
                };
                let dx = extra(da * x[0] + dh * x[2]);
                let dy = extra(da * y[0] + dh * y[2]);
                let length = (da.mid.hi.powi(2) + dh.mid.hi.powi(2)).sqrt();
                let grow = match target {
                    Target::Point(_) => length / radius,
                    Target::Height(..) => 0.5 * length / radius,
                };
                let at = angle(dy, dx);
                let reach = (1.0 / grow).sqrt();
                if at.off.is_finite() {
                    Some(([at.at - at.off, at.at + at.off], at.at, reach))
                } else {
                    let Profile::Arc { angle, .. } = &self.profile else {
                        return None;
                    };
                    Some(([angle.start, angle.end], angle.mid(), f64::INFINITY))
                }
            }
        }
    }

    /// The foot on the model.
    fn foot(&self, target: &Target, w: [Ball<Dd>; 2], rho: Ball<Dd>, h: Ball<Dd>) -> V3 {
        let (a, up) = match &self.profile {
            Profile::Line([p, q]) => {
                let (da, dh) = (q[0] - p[0], q[2] - p[2]);
                let t = ((rho - p[0]) * da + (h - p[2]) * dh) / (da.square() + dh.square());
                (p[0] + t * da, p[2] + t * dh)
            }
            Profile::Arc { center, radius, .. } => {
                let (da, dh) = match target {
                    Target::Point(_) => (rho - center[0], h - center[2]),
                    Target::Height(..) => (rho, -h),
                };
                let s = Ball::exact(*radius) / (da.square() + dh.square()).sqrt();
                (center[0] + s * da, center[2] + s * dh)
            }
        };
        let s = a / rho;
        let p = along(
            &along(&along(&self.origin, s * w[0], &self.e), s * w[1], &self.b),
            up,
            &self.axis,
        );
        p.map(|x| Ball {
            mid: x.mid,
            rad: x.rad + self.slack,
        })
    }
}

/// An azimuth known no better than this, in radians, is not known.
const KNOWN: f64 = 1.0;
const UNIT_INTERVAL: Interval = Interval {
    start: 0.0,
    end: 1.0,
};
/// A profile may reach past the axis by so much of the size: rounding, at a pole.
const ON_AXIS: f64 = 1e-28;
/// A circle with a radius known no better than this is none.
const HARDLY: f64 = (1u64 << 40) as f64;

fn point_radius(s: &RevolutionForm, p: &V3) -> f64 {
    let w: [f64; 3] = std::array::from_fn(|c| (p[c].mid - s.origin[c].mid).hi);
    let [(a, _), (b, _)] = [0, 1].map(|k| Rough::exact(w).dot(&s.rough.frame[k]));
    (a * a + b * b).sqrt()
}

/// The least `a` on an arc's profile: at an end, or at the circle's far side if the arc holds it.
fn least_distance(profile: &Profile) -> Option<f64> {
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
    let held = turns([far.at - far.off, far.at + far.off], far.at, *range);
    let inner = if held.is_empty() {
        f64::INFINITY
    } else {
        (center[0] - Ball::exact(*radius)).lower()
    };
    Some(a(range.start).min(a(range.end)).min(inner))
}

/// The copies of a range of angles, at whole turns, that meet another: each cut to it, with the angle itself moved likewise.
fn turns(b: [f64; 2], at: f64, range: Interval) -> Vec<([f64; 2], f64)> {
    // Angles are below 2^30, so a turn more or less is off by less than this.
    let size = range.start.abs().max(range.end.abs()) + b[0].abs().max(b[1].abs()) + 8.0;
    let off = 8.0 * f64::EPSILON * size;
    let first = ((range.start - b[1] - off) / TURN).floor();
    let mut out = Vec::new();
    let mut k = first;
    while TURN * k + b[0] - off <= range.end {
        let moved = [b[0] + TURN * k - off, b[1] + TURN * k + off];
        if moved[1] >= range.start && moved[0] <= range.end {
            out.push((moved, at + TURN * k));
        }
        k += 1.0;
    }
    out
}
