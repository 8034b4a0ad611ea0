//! A surface as a map from uv to space and back: which uv is nearest to a point.
//!
//! Planes, cylinders, cones, spheres and tori by formula; profiles of other surfaces by a search in one parameter, B-spline surfaces in
//! two. The searches carry no proof: what is made with them is measured afterwards.

use super::entities::form;
use super::geometry::Left;
use super::net;
use super::smooth::{Disc, largest};
use crate::error::ReadError;
use crate::occt::curves::{Budget, Form};
use crate::occt::surfaces::{Axes, Form3};
use feeler::numeric::{Ball, sin_cos};
use feeler::nurbs::{Curve, Curve3, Surface};
use nalgebra::{Matrix2, Point2, Point3, Vector2, Vector3};
use std::cell::OnceCell;
use std::f64::consts::TAU;

/// A point is on an axis of revolution if it is no farther off than this part of its distance from the origin: there its
/// angle says nothing.
const ON_AXIS: f64 = 1.0 / (1 << 30) as f64;

/// Samples of a span from which searches start.
const SAMPLES: usize = 8;
/// The most samples of a curve, or of a surface in all.
const MOST_SAMPLES: usize = 4096;
/// And the numbers of one.
const SAMPLE: usize = 3;
/// So many of the samples are searched from.
const TRIED: usize = 4;
/// Steps of a search: Newton's method needs a few; some curves need them to be damped.
const STEPS: usize = 16;
/// How often a step is halved that leads away.
const HALVINGS: usize = 6;
/// Steps in space below this part of the size are rounding.
const STILL: f64 = 1.0 / (1_u64 << 46) as f64;

/// What is farther from a surface than this part of the size is beside it.
const BESIDE: f64 = 1.0 / (1_u64 << 36) as f64;

/// How far a B-spline's opposite borders may be apart for it to be closed, relative to its size.
const CLOSED: f64 = 1.0 / (1 << 26) as f64;

/// What is turned about the third axis.
enum Meridian {
    /// `(radius + v sin, 0, v cos)`.
    Line { radius: f64, sin: f64, cos: f64 },
    /// `(major + minor cos v, 0, minor sin v)`.
    Circle { major: f64, minor: f64 },
    /// Anything, in the coordinates of the axes.
    Curve(Curve3),
}

enum Kind {
    Plane(Axes),
    Turned(Axes, Meridian),
    Extruded(Vector3<f64>, Curve3),
    Spline(Box<Surface>),
}

/// A surface both ways.
pub(super) struct Chart {
    kind: Kind,
    /// The periods of u and v; of a closed B-spline its domain's lengths.
    pub(super) periods: [Option<f64>; 2],
    /// The domain of a B-spline, beyond which there is nothing.
    pub(super) domain: Option<[[f64; 2]; 2]>,
    /// No point of the body is farther from the origin in any coordinate.
    size: f64,
    /// The u and v of samples of a B-spline.
    grid: [Vec<f64>; 2],
    /// Their points, made for the first search that starts from nothing: most faces need none.
    samples: OnceCell<Vec<Point3<f64>>>,
}

/// The uv of a point.
#[derive(Clone, Copy)]
pub(super) struct Located {
    pub(super) uv: Point2<f64>,
    /// Whether u says nothing: a point on the axis.
    pub(super) on_axis: bool,
    /// The surface's point there and its derivatives, where the search has found them.
    derivatives: Option<[Vector3<f64>; 3]>,
}

impl Located {
    /// Where a search is to start.
    pub(super) fn at(uv: Point2<f64>) -> Self {
        Self {
            uv,
            on_axis: false,
            derivatives: None,
        }
    }

    pub(super) fn derivatives(&self, chart: &Chart) -> [Vector3<f64>; 3] {
        self.derivatives
            .unwrap_or_else(|| chart.derivatives(&self.uv))
    }

    pub(super) fn point(&self, chart: &Chart) -> Point3<f64> {
        match self.derivatives {
            Some([point, ..]) => Point3::from(point),
            None => chart.point(&self.uv),
        }
    }
}

fn local(a: &Axes, v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.dot(&a.x), v.dot(&a.y), v.dot(&a.z))
}

/// The parameter of a curve at which a residual is least: from `near`, or of all its spans. `residual` gives it and its derivative, of a point and
/// a derivative of the curve.
/// `period`: of a curve that goes on beyond its domain's ends.
pub(super) fn nearest(
    curve: &Curve3,
    near: Option<f64>,
    period: Option<f64>,
    residual: impl Fn(&Vector3<f64>, &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>),
) -> f64 {
    let domain = curve.domain();
    let at = |t: f64| {
        let d = curve.derivatives(t, 1);
        let zero = Vector3::zeros();
        residual(d.first().unwrap_or(&zero), d.get(1).unwrap_or(&zero))
    };
    let within = |t: f64| match period {
        Some(period) => domain.start + (t - domain.start).rem_euclid(period),
        None => t.clamp(domain.start, domain.end),
    };
    let refine = |start: f64| {
        let mut t = within(start);
        let (mut r, mut dr) = at(t);
        for _ in 0..STEPS {
            let square = dr.norm_squared();
            if !(square > 0.0) {
                break;
            }
            let mut step = -r.dot(&dr) / square;
            if step.abs() <= STILL * domain.length() {
                break;
            }
            let mut moved = false;
            for _ in 0..HALVINGS {
                let next = within(t + step);
                if next == t {
                    break;
                }
                let (r2, dr2) = at(next);
                if r2.norm_squared() < r.norm_squared() {
                    (t, r, dr, moved) = (next, r2, dr2, true);
                    break;
                }
                step *= 0.5;
            }
            if !moved {
                break;
            }
        }
        (t, r.norm_squared())
    };
    if let Some(t) = near {
        return refine(t).0;
    }
    let breaks = curve.breaks();
    let each = (MOST_SAMPLES / breaks.len().max(1)).clamp(1, 4 * SAMPLES);
    let starts = breaks.windows(2).flat_map(|w| {
        let (from, by) = (w[0], w[1] - w[0]);
        (0..=each).map(move |k| from + by * (k as f64 / each as f64))
    });
    let tried = least(starts.map(|t| (at(t).0.norm_squared(), t)));
    let tried = tried.into_iter().flatten().map(|(_, t)| refine(t));
    let best = tried.min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(domain.start, |(t, _)| t)
}

/// The first of the candidates, from which searches go on: the least come first, and of those that are alike the earlier.
fn least<T: Copy>(all: impl Iterator<Item = (f64, T)>) -> [Option<(f64, T)>; TRIED] {
    let mut found: [Option<(f64, T)>; TRIED] = [None; TRIED];
    for own in all {
        let is_more =
            |place: &Option<(f64, T)>| place.is_none_or(|p| own.0.total_cmp(&p.0).is_lt());
        if let Some(at) = found.iter().position(is_more)
            && let Some(rest) = found.get_mut(at..)
        {
            rest.rotate_right(1);
            if let Some(place) = rest.first_mut() {
                *place = Some(own);
            }
        }
    }
    found
}

impl Chart {
    /// `size`: no point of the body is farther from the origin in any coordinate. `left`: what the file may still hold; the chart's part of it is let go with it.
    pub(super) fn new(
        entity: u64,
        surface: &Form3,
        size: f64,
        left: &Left,
        numbers: &mut Budget,
    ) -> Result<Self, ReadError> {
        // What is made here, and what the face is to have.
        let mut room = left.held.clone();
        room.take(2 * surface.numbers()).map_err(form(entity))?;
        let mut grid = [Vec::new(), Vec::new()];
        let mut domain = None;
        let mut periods = surface.periods();
        let mut profile = |form3: &Form<3, 4>| -> Result<Curve3, ReadError> {
            let mut far = 16.0 * size.max(1.0);
            if let Form::Line { from, direction } = form3 {
                // Its parameter counts directions, from anywhere.
                far = (far + from.coords.norm()) / direction.norm();
            }
            let range = form3.bounds().unwrap_or([-far, far]);
            let (curve, _) = form3.part(range, numbers).map_err(form(entity))?;
            Ok(curve)
        };
        let kind = match surface {
            Form3::Plane(a) => Kind::Plane(a.clone()),
            Form3::Cylinder(a, radius) => Kind::Turned(
                a.clone(),
                Meridian::Line {
                    radius: *radius,
                    sin: 0.0,
                    cos: 1.0,
                },
            ),
            Form3::Cone(a, radius, half) => {
                let (sin, cos) = sin_cos(Ball::exact(*half));
                let (radius, sin, cos) = (*radius, sin.mid.hi, cos.mid.hi);
                Kind::Turned(a.clone(), Meridian::Line { radius, sin, cos })
            }
            Form3::Sphere(a, minor) => Kind::Turned(
                a.clone(),
                Meridian::Circle {
                    major: 0.0,
                    minor: *minor,
                },
            ),
            Form3::Torus(a, [major, minor]) => Kind::Turned(
                a.clone(),
                Meridian::Circle {
                    major: *major,
                    minor: *minor,
                },
            ),
            Form3::Extrusion(direction, p) => Kind::Extruded(*direction, profile(p)?),
            Form3::Revolution(origin, axis, p) => {
                let z = axis.normalize();
                let far = [Vector3::x(), Vector3::y(), Vector3::z()];
                let least = far
                    .iter()
                    .min_by(|a, b| a.dot(&z).abs().total_cmp(&b.dot(&z).abs()));
                let x = least
                    .map_or(Vector3::x(), |v| v - z * v.dot(&z))
                    .normalize();
                let axes = Axes {
                    origin: *origin,
                    z,
                    x,
                    y: z.cross(&x),
                };
                Kind::Turned(axes, Meridian::Curve(profile(p)?))
            }
            other => {
                let whole = other.whole(numbers).map_err(form(entity))?;
                let [u, v] = whole.domain();
                domain = Some([[u.start, u.end], [v.start, v.end]]);
                let breaks = |d: [f64; 2], knots: &[f64]| {
                    let mut b: Vec<f64> = knots.to_vec();
                    b.retain(|k| (d[0]..=d[1]).contains(k));
                    b.dedup();
                    b
                };
                let point = |u: f64, v: f64| match &whole {
                    Surface::Nurbs(n) => net::point(n, [u, v]),
                    _ => whole.point(u, v),
                };
                if let Surface::Nurbs(n) = &whole {
                    let us = breaks([u.start, u.end], n.knots_u().knots());
                    let vs = breaks([v.start, v.end], n.knots_v().knots());
                    let cells = (us.len() * vs.len()).max(1);
                    let most = MOST_SAMPLES.min(left.samples);
                    let each = ((most as f64 / cells as f64).sqrt() as usize).clamp(1, SAMPLES);
                    // Every knot of a large net is enough.
                    let strides = [us.len(), vs.len()].map(|n| n.div_ceil(64).max(1));
                    let fine = |b: &[f64], stride: usize| -> Vec<f64> {
                        let mut list = Vec::new();
                        for w in b.windows(2).step_by(stride) {
                            list.extend(
                                (0..each).map(|k| w[0] + (w[1] - w[0]) * k as f64 / each as f64),
                            );
                        }
                        list.extend(b.last());
                        list
                    };
                    grid = [fine(&us, strides[0]), fine(&vs, strides[1])];
                    let [us, vs] = [&grid[0], &grid[1]].map(Vec::len);
                    let numbers = us * vs * SAMPLE + us + vs * (1 + net::held(n));
                    room.take(numbers).map_err(form(entity))?;
                }
                // Closed where opposite borders are one.
                for c in 0..2 {
                    let d = [u, v];
                    let off = (0..=SAMPLES).map(|k| {
                        let s = d[1 - c].lerp(k as f64 / SAMPLES as f64);
                        let at = |t: f64| {
                            if c == 0 { point(t, s) } else { point(s, t) }
                        };
                        (at(d[c].start) - at(d[c].end)).norm()
                    });
                    if off.fold(0.0, f64::max) <= CLOSED * size {
                        periods[c] = Some(d[c].length());
                    }
                }
                Kind::Spline(Box::new(whole))
            }
        };
        if let Kind::Extruded(_, p) = &kind {
            let d = p.domain();
            if (p.point(d.start) - p.point(d.end)).norm() <= CLOSED * size {
                periods[0] = Some(d.length());
                if surface.periods()[0].is_none() {
                    domain = Some([[d.start, d.end], [f64::NEG_INFINITY, f64::INFINITY]]);
                }
            }
        }
        Ok(Self {
            kind,
            periods,
            domain,
            size,
            grid,
            samples: OnceCell::new(),
        })
    }

    /// The axes, if it is a plane.
    pub(super) fn plane(&self) -> Option<&Axes> {
        match &self.kind {
            Kind::Plane(a) => Some(a),
            _ => None,
        }
    }

    /// Whether it is a cylinder, cone, sphere or torus.
    pub(super) fn is_elementary(&self) -> bool {
        matches!(
            self.kind,
            Kind::Turned(_, Meridian::Line { .. } | Meridian::Circle { .. })
        )
    }

    /// How long the part of the surface's points that is no polynomial in u and v is at most, where these run over complex discs: see
    /// [`smooth`](super::smooth). `None` where the surface is not elementary.
    pub(super) fn most_in(&self, u: Disc, v: Disc) -> Option<f64> {
        let turned = libm::exp(u.off);
        match self.kind {
            Kind::Turned(_, Meridian::Line { radius, sin, .. }) => {
                Some((radius.abs() + v.most * sin.abs()) * turned)
            }
            Kind::Turned(_, Meridian::Circle { major, minor }) => {
                let own = minor.abs() * libm::exp(v.off);
                Some((major.abs() + own) * turned + own)
            }
            _ => None,
        }
    }

    /// No number that is met on the way to a point with this v is larger, where the surface is elementary.
    pub(super) fn far(&self, v: f64) -> f64 {
        match &self.kind {
            Kind::Turned(a, Meridian::Line { radius, .. }) => {
                a.origin.coords.amax() + radius.abs() + v.abs()
            }
            Kind::Turned(a, Meridian::Circle { major, minor }) => {
                a.origin.coords.amax() + major.abs() + minor.abs()
            }
            _ => f64::INFINITY,
        }
    }

    /// How far a point moves at most with each of u and v, up to `v` from 0 (infinite: that is not known); `None` but of planes and surfaces that are
    /// turned about an axis.
    pub(super) fn speeds(&self, v: f64) -> Option<[f64; 2]> {
        match &self.kind {
            Kind::Plane(a) => Some([a.x.norm(), a.y.norm()]),
            Kind::Turned(_, Meridian::Line { radius, sin, .. }) => {
                Some([radius.abs() + v.abs() * sin.abs(), 1.0])
            }
            Kind::Turned(_, Meridian::Circle { major, minor }) => {
                Some([major.abs() + minor.abs(), minor.abs()])
            }
            // No farther from the axis than the control points.
            Kind::Turned(a, Meridian::Curve(Curve::Nurbs(n))) => {
                let far = n.control_points().iter().map(|p| {
                    let l = local(a, &(p.xyz() / p.w - a.origin.coords));
                    l.x.hypot(l.y)
                });
                Some([far.fold(0.0, f64::max), f64::INFINITY])
            }
            _ => None,
        }
    }

    /// What the roundings of a point with this v are parts of, [`FORMULA`](super::pcurve::FORMULA) twice, on a surface that is turned about an axis; `None` of
    /// others. A torus or cone may be much larger than the body, which lies in a small part of it. Of a rational profile as in [`smooth`](super::smooth): its
    /// control points, times twice what weights differ by.
    pub(super) fn rounded(&self, v: f64) -> Option<f64> {
        let Kind::Turned(_, Meridian::Curve(profile)) = &self.kind else {
            let is_elementary = self.is_elementary();
            return is_elementary.then(|| self.far(v).max(self.size));
        };
        let far = (0..3).map(|c| largest(profile, c)).fold(0.0, f64::max);
        let own = match profile {
            Curve::Line(_) | Curve::Arc(_) => far,
            Curve::Nurbs(n) if n.degree() <= 16 => {
                let weights = n.control_points().iter().map(|p| p.w);
                let [least, most] = weights.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], w| {
                    [a.min(w), b.max(w)]
                });
                far * (2.0 * most / least)
            }
            _ => return None,
        };
        Some(own.max(self.size))
    }

    /// Whether its meridians are straight.
    pub(super) fn is_ruled(&self) -> bool {
        matches!(self.kind, Kind::Turned(_, Meridian::Line { .. }))
    }

    /// The v of poles, where all u are one point: of spheres both, of cones the apex, which bounds either half.
    pub(super) fn poles(&self) -> [Option<f64>; 2] {
        match self.kind {
            Kind::Turned(_, Meridian::Circle { major: 0.0, .. }) => {
                [Some(-0.25 * TAU), Some(0.25 * TAU)]
            }
            Kind::Turned(_, Meridian::Line { radius, sin, .. }) if sin != 0.0 => {
                [Some(-radius / sin); 2]
            }
            _ => [None, None],
        }
    }

    /// The parameter at which a closed profile is looked up: its curve ends where it started.
    fn wrapped(&self, c: usize, t: f64) -> f64 {
        let profile = match &self.kind {
            Kind::Extruded(_, p) | Kind::Turned(_, Meridian::Curve(p)) => p,
            _ => return t,
        };
        let start = profile.domain().start;
        match (self.periods[c], self.domain) {
            (Some(period), None) => start + (t - start).rem_euclid(period),
            _ => t,
        }
    }

    /// The point, and the derivatives by u and v.
    pub(super) fn derivatives(&self, uv: &Point2<f64>) -> [Vector3<f64>; 3] {
        match &self.kind {
            Kind::Plane(a) => [a.origin.coords + a.x * uv.x + a.y * uv.y, a.x, a.y],
            Kind::Turned(a, meridian) => {
                let (q, dq) = meridian_at(a, meridian, self.wrapped(1, uv.y));
                let (sin, cos) = libm::sincos(uv.x);
                let turn = |v: &Vector3<f64>| {
                    a.x * (cos * v.x - sin * v.y) + a.y * (sin * v.x + cos * v.y) + a.z * v.z
                };
                let along = Vector3::new(-q.y, q.x, 0.0);
                [a.origin.coords + turn(&q), turn(&along), turn(&dq)]
            }
            Kind::Extruded(direction, p) => {
                let d = p.derivatives(self.wrapped(0, uv.x), 1);
                let get = |i: usize| d.get(i).copied().unwrap_or_default();
                [get(0) + direction * uv.y, get(1), *direction]
            }
            Kind::Spline(s) => {
                if let Surface::Nurbs(s) = &**s {
                    return net::derivatives(s, [uv.x, uv.y]);
                }
                let d = s.derivatives(uv.x, uv.y, 1);
                [d.get(0, 0), d.get(1, 0), d.get(0, 1)]
            }
        }
    }

    pub(super) fn point(&self, uv: &Point2<f64>) -> Point3<f64> {
        // A profile's point is found as its derivative is.
        let (a, [x, z]) = match &self.kind {
            Kind::Turned(a, Meridian::Line { radius, sin, cos }) => {
                (a, [radius + uv.y * sin, uv.y * cos])
            }
            Kind::Turned(a, Meridian::Circle { major, minor }) => {
                let (sin, cos) = libm::sincos(uv.y);
                (a, [major + minor * cos, minor * sin])
            }
            Kind::Spline(s) => {
                return match &**s {
                    Surface::Nurbs(s) => net::point(s, [uv.x, uv.y]),
                    other => other.point(uv.x, uv.y),
                };
            }
            _ => return Point3::from(self.derivatives(uv)[0]),
        };
        let (sin, cos) = libm::sincos(uv.x);
        a.origin + (a.x * (cos * x) + a.y * (sin * x) + a.z * z)
    }

    /// How far a point is from the axis of revolution, and how far it may be to be on it; nothing where the surface keeps clear of its axis, as
    /// cylinders and most tori do.
    pub(super) fn off_axis(&self, p: &Point3<f64>) -> Option<[f64; 2]> {
        let Kind::Turned(a, meridian) = &self.kind else {
            return None;
        };
        let clear = match meridian {
            Meridian::Line { sin, .. } => *sin == 0.0,
            Meridian::Circle { major, minor } => major - minor > ON_AXIS * (major + minor),
            Meridian::Curve(_) => false,
        };
        if clear {
            return None;
        }
        let l = local(a, &(p - a.origin));
        Some([l.x.hypot(l.y), ON_AXIS * l.norm().max(meridian.size())])
    }

    /// The uv nearest to a point; `near`: that of a point close by, from which it goes on.
    pub(super) fn locate(&self, p: &Point3<f64>, near: Option<&Located>) -> Located {
        if let Kind::Spline(_) = &self.kind {
            return self.search(p, near);
        }
        let near = near.map(|n| n.uv);
        let mut on_axis = false;
        let round = |c: usize| self.periods[c].filter(|_| self.domain.is_none());
        let mut uv = match &self.kind {
            Kind::Plane(a) => {
                let l = local(a, &(p - a.origin));
                Point2::new(l.x, l.y)
            }
            Kind::Turned(a, meridian) => {
                let l = local(a, &(p - a.origin));
                let rho = l.x.hypot(l.y);
                let (v, phase) = match meridian {
                    Meridian::Line { radius, sin, cos } => ((rho - radius) * sin + l.z * cos, 0.0),
                    Meridian::Circle { major, .. } => (libm::atan2(l.z, rho - major), 0.0),
                    Meridian::Curve(c) => {
                        let v = nearest(c, near.map(|n| n.y), round(1), |q, dq| {
                            let (q, dq) = (local(a, &(q - a.origin.coords)), local(a, dq));
                            let h = q.x.hypot(q.y);
                            let slope = if h > 0.0 {
                                (q.x * dq.x + q.y * dq.y) / h
                            } else {
                                dq.x.hypot(dq.y)
                            };
                            (
                                Vector3::new(h - rho, q.z - l.z, 0.0),
                                Vector3::new(slope, dq.z, 0.0),
                            )
                        });
                        let (q, _) = meridian_at(a, meridian, v);
                        (v, libm::atan2(q.y, q.x))
                    }
                };
                on_axis = rho <= ON_AXIS * l.norm().max(meridian.size());
                Point2::new(libm::atan2(l.y, l.x) - phase, v)
            }
            Kind::Extruded(direction, c) => {
                let square = direction.norm_squared();
                let flat = |v: &Vector3<f64>| v - direction * (v.dot(direction) / square);
                let u = nearest(c, near.map(|n| n.x), round(0), |q, dq| {
                    (flat(&(q - p.coords)), flat(dq))
                });
                Point2::new(u, (p - c.point(u)).dot(direction) / square)
            }
            // Searched for above.
            Kind::Spline(_) => Point2::origin(),
        };
        if let Some(near) = near {
            for c in 0..2 {
                // What has an end goes no further.
                if let (Some(period), None) = (self.periods[c], self.domain) {
                    uv[c] += ((near[c] - uv[c]) / period).round() * period;
                }
            }
        }
        Located {
            uv,
            on_axis,
            derivatives: None,
        }
    }

    /// The points of the samples, one u after the other.
    fn samples(&self) -> &[Point3<f64>] {
        self.samples.get_or_init(|| {
            let mut all = Vec::new();
            if let Kind::Spline(s) = &self.kind
                && let Surface::Nurbs(s) = &**s
            {
                let [us, vs] = &self.grid;
                all.reserve_exact(us.len() * vs.len());
                net::points(s, us, vs, |p| all.push(p));
            }
            all
        })
    }

    /// In two parameters.
    fn search(&self, p: &Point3<f64>, near: Option<&Located>) -> Located {
        let refine = |start: &Located| {
            let mut uv = start.uv;
            let mut d = start.derivatives(self);
            for _ in 0..STEPS {
                let r = d[0] - p.coords;
                let (g, h) = normal_equations(&d, &r);
                let Some(step) = solve(&h, &-g) else { break };
                // A step s brings the square of the distance down by s^2, which beside roundings of points is not seen where it is less than they are.
                let square = (d[1] * step.x + d[2] * step.y).norm_squared();
                let still = STILL * self.size;
                if square <= (still * still).max(2.0 * f64::EPSILON * self.size * r.norm()) {
                    break;
                }
                let mut scale = 1.0;
                let mut moved = false;
                for _ in 0..HALVINGS {
                    let next = self.clamped(uv + step * scale);
                    if next == uv {
                        break;
                    }
                    let d2 = self.derivatives(&next);
                    if (d2[0] - p.coords).norm_squared() < r.norm_squared() {
                        (uv, d, moved) = (next, d2, true);
                        break;
                    }
                    scale *= 0.5;
                }
                if !moved {
                    break;
                }
            }
            let found = Located {
                uv,
                on_axis: false,
                derivatives: Some(d),
            };
            (found, (d[0] - p.coords).norm_squared())
        };
        if let Some(near) = near {
            let uv = self.clamped(near.uv);
            let start = if uv == near.uv {
                *near
            } else {
                Located::at(uv)
            };
            return refine(&start).0;
        }
        let [us, vs] = &self.grid;
        let starts = us
            .iter()
            .flat_map(|u| vs.iter().map(|v| Point2::new(*u, *v)));
        let starts = starts.zip(self.samples());
        let tried = least(starts.map(|(uv, q)| ((q - p).norm_squared(), uv)));
        let tried = tried.into_iter().flatten();
        let tried = tried.map(|(_, uv)| refine(&Located::at(uv)));
        let best = tried.min_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or(Located::at(Point2::origin()), |(found, _)| found)
    }

    pub(super) fn clamped(&self, mut uv: Point2<f64>) -> Point2<f64> {
        for (c, d) in self.domain.iter().flatten().enumerate() {
            uv[c] = uv[c].clamp(d[0], d[1]);
        }
        uv
    }

    /// A place with what the surface does there.
    pub(super) fn known(&self, uv: Point2<f64>) -> Located {
        Located {
            derivatives: Some(self.derivatives(&uv)),
            ..Located::at(uv)
        }
    }

    /// The derivative in uv of the place nearest to a point `p` that moves with `tangent`, from what the surface does there; what is beside the surface is also
    /// turned by how it bends, found by differences `towards` another place. `None` where it has no tangent plane.
    pub(super) fn carried(
        &self,
        uv: &Point2<f64>,
        d: &[Vector3<f64>; 3],
        towards: &Point2<f64>,
        p: &Point3<f64>,
        tangent: &Vector3<f64>,
    ) -> Option<Vector2<f64>> {
        let (g, mut h) = normal_equations(d, tangent);
        let r = p.coords - d[0];
        if r.norm() > BESIDE * self.size {
            for c in 0..2 {
                let mut near = *uv;
                near[c] += (towards[c] - uv[c]) / 256.0;
                let step = near[c] - uv[c];
                // Along what does not change it does not bend.
                if step == 0.0 {
                    continue;
                }
                let [_, su, sv] = self.derivatives(&near);
                h[(0, c)] -= (su - d[1]).dot(&r) / step;
                h[(1, c)] -= (sv - d[2]).dot(&r) / step;
            }
        }
        solve(&h, &g)
    }

    /// The knots of a B-spline between the ends of its domain, in u or v: its derivatives may jump there.
    pub(super) fn inner_knots(&self, c: usize) -> Vec<f64> {
        let mut inner = Vec::new();
        if let Kind::Spline(s) = &self.kind
            && let Surface::Nurbs(s) = &**s
        {
            let knots = if c == 0 { s.knots_u() } else { s.knots_v() };
            let domain = knots.domain();
            let all = knots.knots().iter();
            inner.extend(all.filter(|k| domain.start < **k && **k < domain.end));
            inner.dedup();
        }
        inner
    }

    /// The degree in u and v of a B-spline, both together.
    pub(super) fn degree(&self) -> Option<usize> {
        match &self.kind {
            Kind::Spline(s) => match &**s {
                Surface::Nurbs(n) => Some(n.knots_u().degree() + n.knots_v().degree()),
                _ => None,
            },
            _ => None,
        }
    }
}

/// The derivative in uv of a curve that runs on a surface with this derivative in space, from the surface's point and derivatives; `None` where it has no
/// tangent plane.
pub(super) fn pulled_back(d: &[Vector3<f64>; 3], tangent: &Vector3<f64>) -> Option<Vector2<f64>> {
    let (g, h) = normal_equations(d, tangent);
    solve(&h, &g)
}

/// How far from a surface's point the one nearest to `p` is, up to squares of that; `None` where there is no tangent plane.
pub(super) fn foot_off(d: &[Vector3<f64>; 3], p: &Point3<f64>) -> Option<f64> {
    let step = pulled_back(d, &(p.coords - d[0]))?;
    Some((d[1] * step.x + d[2] * step.y).norm())
}

impl Meridian {
    fn size(&self) -> f64 {
        match self {
            Self::Line { radius, .. } => *radius,
            Self::Circle { major, minor } => major + minor,
            Self::Curve(_) => 0.0,
        }
    }
}

fn meridian_at(a: &Axes, meridian: &Meridian, v: f64) -> (Vector3<f64>, Vector3<f64>) {
    match meridian {
        Meridian::Line { radius, sin, cos } => (
            Vector3::new(radius + v * sin, 0.0, v * cos),
            Vector3::new(*sin, 0.0, *cos),
        ),
        Meridian::Circle { major, minor } => {
            let (sin, cos) = libm::sincos(v);
            (
                Vector3::new(major + minor * cos, 0.0, minor * sin),
                Vector3::new(-minor * sin, 0.0, minor * cos),
            )
        }
        Meridian::Curve(c) => {
            let d = c.derivatives(v, 1);
            let get = |i: usize| d.get(i).copied().unwrap_or_default();
            (local(a, &(get(0) - a.origin.coords)), local(a, &get(1)))
        }
    }
}

fn normal_equations(d: &[Vector3<f64>; 3], r: &Vector3<f64>) -> (Vector2<f64>, Matrix2<f64>) {
    let [_, su, sv] = d;
    let cross = su.dot(sv);
    (
        Vector2::new(su.dot(r), sv.dot(r)),
        Matrix2::new(su.norm_squared(), cross, cross, sv.norm_squared()),
    )
}

fn solve(h: &Matrix2<f64>, g: &Vector2<f64>) -> Option<Vector2<f64>> {
    let determinant = h.determinant();
    let scale = h.m11 * h.m22;
    // 2^-40: lines of u and v that are as good as parallel.
    if !(determinant > scale / (1_u64 << 40) as f64) {
        return None;
    }
    let step = Vector2::new(
        (h.m22 * g.x - h.m12 * g.y) / determinant,
        (h.m11 * g.y - h.m21 * g.x) / determinant,
    );
    step.iter().all(|x| x.is_finite()).then_some(step)
}
