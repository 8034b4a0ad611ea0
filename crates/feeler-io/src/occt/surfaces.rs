//! Surfaces: as the file has them, and as the kernel holds the part that a face's loops reach.
//!
//! | in the file | in the kernel |
//! |---|---|
//! | plane | plane |
//! | cylinder, cone | line, turned |
//! | sphere, torus | arc, turned; both angles are the file's parameters |
//! | extrusion | sum of the curve and a line |
//! | revolution | the curve, turned |
//! | Bezier, B-spline | NURBS |
//! | trimmed | its basis |
//! | offset | refused |
//!
//! Parameters are the file's, so that curves in uv need no change, but where an ellipse or a hyperbola is extruded or turned:
//! [`Form3::warp`]. Many of the file's surfaces have no end; the kernel's end where the loops do.

use super::curves::{Budget, Form, MAX_NESTED, MOST_TURNS, Refusal, moved, refused, vector};
use super::error::TextProblem;
use super::motion::Motion;
use super::splines::{Knots, control_points, degree};
use super::tokens::Tokens;
use crate::error::ReadError;
use crate::sheets::{ROUNDING, Reach};
use crate::warp::Warp;
use feeler::numeric::{Ball, Interval, sin_cos};
use feeler::nurbs::{Arc, Curve, Curve3, Line, NurbsSurface, Plane, Revolution, Sum, Surface};
use nalgebra::{Point3, Vector3, Vector4};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Where an elementary surface stands. Its axes may be left-handed.
#[derive(Clone, Debug)]
pub(crate) struct Axes {
    pub(crate) origin: Point3<f64>,
    pub(crate) z: Vector3<f64>,
    pub(crate) x: Vector3<f64>,
    pub(crate) y: Vector3<f64>,
}

/// A surface as the file has it.
#[derive(Clone, Debug)]
pub(crate) enum Form3 {
    Plane(Axes),
    Cylinder(Axes, f64),
    Cone(Axes, f64, f64),
    Sphere(Axes, f64),
    Torus(Axes, [f64; 2]),
    Extrusion(Vector3<f64>, Box<Form<3, 4>>),
    Revolution(Point3<f64>, Vector3<f64>, Box<Form<3, 4>>),
    Spline([Knots; 2], Vec<Vector4<f64>>),
    Trimmed([[f64; 2]; 2], Box<Form3>),
    Offset,
}

/// How many turns from 0 loops may be. Most faces cover one turn of their surface or less; that of a thread winds, and each turn is searched.
const MOST_AWAY: f64 = 0.5 * MOST_TURNS;

/// The largest angle of latitude.
const POLE: [f64; 2] = [-FRAC_PI_2, FRAC_PI_2];

impl Axes {
    fn read(t: &mut Tokens<'_>) -> Result<Self, ReadError> {
        Ok(Self {
            origin: Point3::from(vector(t, "an origin")?),
            z: vector(t, "an axis")?,
            x: vector(t, "an x direction")?,
            y: vector(t, "a y direction")?,
        })
    }

    /// The axis about which x turns into y by 90 degrees, right-handed: z or its opposite.
    fn turning(&self) -> Vector3<f64> {
        if self.x.cross(&self.y).dot(&self.z) < 0.0 {
            -self.z
        } else {
            self.z
        }
    }

    fn at(&self, x: f64, z: f64) -> Point3<f64> {
        self.origin + self.x * x + self.z * z
    }
}

impl Form3 {
    /// Reads a surface. Recursion is bounded by [`MAX_NESTED`].
    pub(super) fn read(t: &mut Tokens<'_>, depth: u32) -> Result<Self, ReadError> {
        if depth >= MAX_NESTED {
            return Err(t.fail(TextProblem::Nested { limit: MAX_NESTED }));
        }
        let kind = t.word("the kind of a surface")?;
        Ok(match kind {
            b"1" => Self::Plane(Axes::read(t)?),
            b"2" => Self::Cylinder(Axes::read(t)?, t.number("a radius")?),
            b"3" => Self::Cone(
                Axes::read(t)?,
                t.number("a radius")?,
                t.number("half an angle")?,
            ),
            b"4" => Self::Sphere(Axes::read(t)?, t.number("a radius")?),
            b"5" => Self::Torus(Axes::read(t)?, t.numbers("a torus's radii")?),
            b"6" => {
                let direction = vector(t, "a direction of extrusion")?;
                Self::Extrusion(direction, Box::new(Form::read(t, depth + 1)?))
            }
            b"7" => {
                let origin = Point3::from(vector(t, "a point of an axis")?);
                let axis = vector(t, "an axis")?;
                Self::Revolution(origin, axis, Box::new(Form::read(t, depth + 1)?))
            }
            b"8" => {
                let rational =
                    t.flag("the rational flag along u")? | t.flag("the rational flag along v")?;
                let [p, q] = [degree(t)?, degree(t)?];
                let net = control_points(t, (p + 1) * (q + 1), rational)?;
                Self::Spline([Knots::bezier(p), Knots::bezier(q)], net)
            }
            b"9" => {
                let rational =
                    t.flag("the rational flag along u")? | t.flag("the rational flag along v")?;
                let periodic = [t.flag("a periodic flag")?, t.flag("a periodic flag")?];
                let degrees = [degree(t)?, degree(t)?];
                let counts = [t.count("control points", 3)?, t.count("control points", 3)?];
                let knots = [t.count("knots", 2)?, t.count("knots", 2)?];
                let product = (counts[0] as i64).saturating_mul(counts[1] as i64);
                let count = t.check_count("control points", product, 3)?;
                let net = control_points(t, count, rational)?;
                let mut read =
                    |i: usize| Knots::read(t, degrees[i], periodic[i], counts[i], knots[i]);
                Self::Spline([read(0)?, read(1)?], net)
            }
            b"10" => {
                let [a, b, c, d] = t.numbers("a trimmed surface's ranges")?;
                Self::Trimmed([[a, b], [c, d]], Box::new(Self::read(t, depth + 1)?))
            }
            b"11" => {
                t.number("an offset")?;
                Self::read(t, depth + 1)?;
                Self::Offset
            }
            _ => return Err(t.unexpected("the kind of a surface", kind, "1 to 11")),
        })
    }

    /// Where the surface ends by itself in u and v; `None` where it goes on.
    fn bounds(&self) -> [Option<[f64; 2]>; 2] {
        let turn = Some([0.0, TAU]);
        match self {
            Self::Plane(_) | Self::Offset => [None, None],
            Self::Cylinder(..) | Self::Cone(..) => [turn, None],
            Self::Sphere(..) => [turn, Some(POLE)],
            Self::Torus(..) => [turn, turn],
            Self::Extrusion(_, profile) => [profile.bounds(), None],
            Self::Revolution(_, _, profile) => [turn, profile.bounds()],
            Self::Spline(knots, _) => [0, 1].map(|i| {
                let window = knots[i].window(None)?;
                let from = window.knots.get(knots[i].degree)?;
                Some([*from, *window.knots.get(window.points.len())?])
            }),
            Self::Trimmed(ranges, _) => ranges.map(Some),
        }
    }

    /// The axes, if it is a plane.
    pub(crate) fn plane(&self) -> Option<&Axes> {
        match self {
            Self::Plane(axes) => Some(axes),
            Self::Trimmed(_, basis) => basis.plane(),
            _ => None,
        }
    }

    /// The coordinate, if there is one, in which the part of the surface over a domain has another parameter than the file's.
    pub(super) fn warp(&self, domain: [Interval; 2]) -> Result<Option<(usize, Warp)>, Refusal> {
        let (c, warp) = match self {
            Self::Extrusion(_, profile) => (0, profile.warp(domain[0])?),
            Self::Revolution(_, _, profile) => (1, profile.warp(domain[1])?),
            Self::Trimmed(_, basis) => return basis.warp(domain),
            _ => return Ok(None),
        };
        Ok(warp.map(|w| (c, w)))
    }

    /// The period of u and of v, if the surface has one.
    pub(crate) fn periods(&self) -> [Option<f64>; 2] {
        let spline = |k: &Knots| k.periodic.then(|| k.period()).flatten();
        match self {
            Self::Plane(_) | Self::Offset => [None, None],
            Self::Cylinder(..) | Self::Cone(..) | Self::Sphere(..) => [Some(TAU), None],
            Self::Torus(..) => [Some(TAU), Some(TAU)],
            Self::Extrusion(_, profile) => [profile.period(), None],
            Self::Revolution(_, _, profile) => [Some(TAU), profile.period()],
            Self::Spline(knots, _) => [spline(&knots[0]), spline(&knots[1])],
            Self::Trimmed(_, basis) => basis.periods(),
        }
    }

    /// Whether the kernel's surface is the same whatever part of it is used.
    pub(crate) fn is_whole(&self) -> bool {
        match self {
            Self::Spline(knots, _) => !knots[0].periodic && !knots[1].periodic,
            Self::Trimmed(_, basis) => basis.is_whole(),
            _ => false,
        }
    }

    /// The part that holds what loops reach in u and v; without loops, all of it.
    pub(crate) fn part(
        &self,
        reach: [Option<Reach>; 2],
        motion: &Motion,
        numbers: &mut Budget,
    ) -> Result<Surface, Refusal> {
        if let Self::Trimmed(_, basis) = self
            && reach[0].is_some()
        {
            return basis.part(reach, motion, numbers);
        }
        self.check(reach)?;
        let own = self.bounds();
        let mut ranges = [[0.0; 2]; 2];
        for c in 0..2 {
            ranges[c] = match (reach[c], own[c]) {
                (Some(reach), _) => open(reach, self.periods()[c]),
                (None, Some(own)) => own,
                (None, None) => {
                    return Err(TextProblem::Unsupported {
                        what: "a face without border on a surface without end".into(),
                        remedy: "bound it (BRepBuilderAPI_MakeFace with a wire or with ranges)",
                    });
                }
            };
        }
        if motion.is_rigid() {
            return self.over(ranges, motion, numbers);
        }
        motion.surface(&self.over(ranges, &Motion::identity(), numbers)?)
    }

    /// How many numbers its control points are, which each face on it has, too.
    pub(crate) fn numbers(&self) -> usize {
        match self {
            Self::Spline(_, net) => 4 * net.len(),
            Self::Extrusion(_, profile) | Self::Revolution(_, _, profile) => profile.numbers(),
            Self::Trimmed(_, basis) => basis.numbers(),
            _ => 0,
        }
    }

    /// All of a surface that has an end everywhere.
    pub(crate) fn whole(&self, numbers: &mut Budget) -> Result<Surface, Refusal> {
        self.part([None, None], &Motion::identity(), numbers)
    }

    /// Refuses loops that lie where no sheet of the surface is.
    fn check(&self, reach: [Option<Reach>; 2]) -> Result<(), Refusal> {
        let periods = self.periods();
        for (c, name) in ["u", "v"].into_iter().enumerate() {
            let Some([lo, hi]) = reach[c].map(|r| r.range) else {
                continue;
            };
            let many = |period: f64| lo.abs().max(hi.abs()) > MOST_AWAY * period;
            let poles = matches!(self, Self::Sphere(..)) && c == 1;
            let what = if periods[c].is_some_and(many) {
                "many turns of the surface"
            } else if poles && (lo < POLE[0] - ROUNDING || hi > POLE[1] + ROUNDING) {
                "beyond a pole of the sphere"
            } else {
                continue;
            };
            return Err(TextProblem::Shape {
                what: format!("loops reach over {name} in [{lo:?}, {hi:?}], {what}"),
            });
        }
        Ok(())
    }

    /// The part over ranges under a rigid motion.
    pub(super) fn over(
        &self,
        ranges: [[f64; 2]; 2],
        motion: &Motion,
        numbers: &mut Budget,
    ) -> Result<Surface, Refusal> {
        let domain = |c: usize| {
            let [a, b]: [f64; 2] = ranges[c];
            Interval::new(a, b).ok_or_else(|| TextProblem::Shape {
                what: format!(
                    "a face reaches over [{a:?}, {b:?}] of a parameter: nothing of its surface"
                ),
            })
        };
        numbers.take(32)?;
        Ok(match self {
            Self::Plane(a) => {
                let domain = [domain(0)?, domain(1)?];
                let plane = Plane {
                    origin: motion.point(&a.origin),
                    x: motion.vector(&a.x),
                    y: motion.vector(&a.y),
                    domain,
                    extents: domain,
                };
                Surface::Plane(Plane::new(plane).map_err(refused("a plane"))?)
            }
            Self::Cylinder(a, r) => {
                let v = domain(1)?;
                let profile = straight(a.at(*r, v.start), a.at(*r, v.end), v)?;
                turned(a, profile, domain(0)?, motion)?
            }
            Self::Cone(a, r, half) => {
                let v = domain(1)?;
                let (sin, cos) = sin_cos(Ball::exact(*half));
                let (sin, cos) = (sin.mid.hi, cos.mid.hi);
                let at = |v: f64| a.at(r + v * sin, v * cos);
                turned(a, straight(at(v.start), at(v.end), v)?, domain(0)?, motion)?
            }
            Self::Sphere(a, r) => {
                let mut v = domain(1)?;
                // What sticks out at a pole is rounding of what was printed.
                v.start = v.start.max(POLE[0]);
                v.end = v.end.min(POLE[1]);
                turned(a, meridian(a, 0.0, *r, v)?, domain(0)?, motion)?
            }
            Self::Torus(a, [major, minor]) => turned(
                a,
                meridian(a, *major, *minor, domain(1)?)?,
                domain(0)?,
                motion,
            )?,
            Self::Extrusion(direction, profile) => {
                let first = whole(profile, domain(0)?, numbers)?;
                let v = domain(1)?;
                let at = |v: f64| Point3::from(direction * v);
                let mut second = straight(at(v.start), at(v.end), v)?;
                if let Curve::Line(line) = &mut second {
                    // A sum's second curve is a vector from place to place: it turns, but does not move.
                    line.from = Point3::from(motion.vector(&line.from.coords));
                    line.to = Point3::from(motion.vector(&line.to.coords));
                }
                Surface::Sum(Sum {
                    base: Vector3::zeros(),
                    first: moved(first, motion)?,
                    second,
                })
            }
            Self::Revolution(origin, axis, profile) => {
                let profile = whole(profile, domain(1)?, numbers)?;
                revolution(*origin, *axis, profile, domain(0)?, motion)?
            }
            Self::Spline(knots, net) => {
                let mut windows = Vec::with_capacity(2);
                for c in 0..2 {
                    let Some(window) = knots[c].window(Some(ranges[c])) else {
                        return Err(TextProblem::Shape {
                            what: format!(
                                "a face reaches over [{:?}, {:?}] of a periodic surface, many periods",
                                ranges[c][0], ranges[c][1]
                            ),
                        });
                    };
                    windows.push(window);
                }
                let [u, v] = &windows[..] else {
                    return Err(TextProblem::Header);
                };
                numbers.take(4 * u.points.len() * v.points.len())?;
                let mut points = Vec::with_capacity(u.points.len() * v.points.len());
                for i in &u.points {
                    for j in &v.points {
                        let p = net.get(i * knots[1].control_points + j);
                        points.extend(p.map(|p| {
                            if motion.is_identity() {
                                *p
                            } else {
                                motion.homogeneous(p)
                            }
                        }));
                    }
                }
                let counts = [u.points.len(), v.points.len()];
                let degrees = [knots[0].degree, knots[1].degree];
                let written = [u.knots.clone(), v.knots.clone()];
                let surface = NurbsSurface::new(degrees, counts, points, written);
                Surface::Nurbs(surface.map_err(refused("a B-spline surface"))?)
            }
            Self::Trimmed(_, basis) => basis.over(ranges, motion, numbers)?,
            Self::Offset => {
                return Err(TextProblem::Unsupported {
                    what: "an offset surface".into(),
                    remedy: "convert it to a B-spline (BRepBuilderAPI_NurbsConvert)",
                });
            }
        })
    }
}

/// What loops reach, rounded to a multiple of a quarter turn (or of the period) where it is that up to rounding, and
/// no more than one period unless one of them winds; otherwise with its margin.
fn open(reach: Reach, period: Option<f64>) -> [f64; 2] {
    let [mut lo, mut hi] = reach.range;
    let Some(period) = period else {
        return [lo - reach.margin, hi + reach.margin];
    };
    let slack = ROUNDING * lo.abs().max(hi.abs()).max(period);
    let snapped = |x: f64| {
        let quarter = 0.25 * period;
        let near = (x / quarter).round() * quarter;
        ((x - near).abs() <= slack).then_some(near)
    };
    let (low, high) = (snapped(lo), snapped(hi));
    lo = low.unwrap_or(lo - reach.margin);
    hi = high.unwrap_or(hi + reach.margin);
    if hi - lo > period && !reach.winds {
        // The margins of one turn are not needed.
        (lo, hi) = match (low, high) {
            (_, Some(hi)) => (hi - period, hi),
            (_, None) => (lo, lo + period),
        };
    }
    [lo, hi]
}

fn straight(from: Point3<f64>, to: Point3<f64>, domain: Interval) -> Result<Curve3, Refusal> {
    let line = Line::new(from, to, domain).map_err(refused("a line"))?;
    Ok(Curve::Line(line))
}

/// The circle of radius `minor` in the plane of x and z, `major` off the axis.
fn meridian(a: &Axes, major: f64, minor: f64, angle: Interval) -> Result<Curve3, Refusal> {
    let arc = Arc {
        center: a.origin + a.x * major,
        x: a.x,
        y: a.z,
        z: a.x.cross(&a.z),
        radius: minor,
        angle,
        domain: angle,
    };
    Ok(Curve::Arc(Arc::new(arc).map_err(refused("a circle"))?))
}

fn turned(a: &Axes, profile: Curve3, angle: Interval, motion: &Motion) -> Result<Surface, Refusal> {
    revolution(a.origin, a.turning(), profile, angle, motion)
}

fn revolution(
    origin: Point3<f64>,
    axis: Vector3<f64>,
    profile: Curve3,
    angle: Interval,
    motion: &Motion,
) -> Result<Surface, Refusal> {
    let revolution = Revolution {
        origin: motion.point(&origin),
        axis: motion.vector(&axis),
        angle,
        angle_domain: angle,
        profile: moved(profile, motion)?,
        transposed: false,
    };
    let revolution = Revolution::new(revolution).map_err(refused("a surface of revolution"))?;
    Ok(Surface::Revolution(revolution))
}

/// A curve that a surface is made of, over a domain that holds `range`.
fn whole(profile: &Form<3, 4>, range: Interval, numbers: &mut Budget) -> Result<Curve3, Refusal> {
    if profile.is_offset() {
        return Err(TextProblem::Unsupported {
            what: "a surface made of an offset curve".into(),
            remedy: "convert the shape to NURBS (BRepBuilderAPI_NurbsConvert)",
        });
    }
    // A B-spline ends where it ends: what loops reach beyond is cut off, as on every surface.
    let (curve, _) = profile.part([range.start, range.end], numbers)?;
    Ok(curve)
}

/// A range of no length is a slit; the surface below it must have one.
pub(crate) fn wide(mut reach: Reach) -> Reach {
    let [lo, hi] = reach.range;
    if !(lo < hi) {
        reach.margin = ROUNDING * lo.abs().max(1.0);
    }
    reach
}
