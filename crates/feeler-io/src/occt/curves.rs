//! Curves, in uv (`D = 2`) and in space (`D = 3`): as the file has them, and as the kernel holds a part of them.
//!
//! | in the file | in the kernel |
//! |---|---|
//! | line | line between the ends of the part |
//! | circle | arc; its angle is the file's parameter |
//! | ellipse, hyperbola | rational quadratics: the same points at other parameters |
//! | parabola | its quadratic, the same parameter |
//! | Bezier, B-spline | NURBS, the same parameter |
//! | trimmed | its basis |
//! | offset | refused |

use super::error::TextProblem;
use super::motion::Motion;
use super::splines::{Knots, control_points, degree};
use super::tokens::Tokens;
use crate::error::ReadError;
use crate::sheets::ROUNDING;
use crate::warp::Warp;
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, ConvertedCurve, Curve, GeometryError, Line, NurbsCurve};
use libm::{cosh, sinh};
use nalgebra::{Point, SVector};
use std::f64::consts::TAU;

/// How deep curves and surfaces may be defined by each other.
pub(crate) const MAX_NESTED: u32 = 16;

/// Where a conic stands.
#[derive(Clone, Debug)]
pub(crate) struct Frame<const D: usize> {
    pub(crate) center: Point<f64, D>,
    pub(crate) x: SVector<f64, D>,
    pub(crate) y: SVector<f64, D>,
    /// The axis; zero in uv.
    pub(crate) z: SVector<f64, D>,
}

/// A curve as the file has it.
#[derive(Clone, Debug)]
pub(crate) enum Form<const D: usize, const H: usize> {
    Line {
        from: Point<f64, D>,
        direction: SVector<f64, D>,
    },
    Circle(Frame<D>, f64),
    Ellipse(Frame<D>, [f64; 2]),
    Parabola(Frame<D>, f64),
    Hyperbola(Frame<D>, [f64; 2]),
    Spline(Knots, Vec<SVector<f64, H>>),
    Trimmed([f64; 2], Box<Form<D, H>>),
    Offset,
}

impl<const D: usize, const H: usize> Form<D, H> {
    /// How many numbers its control points are.
    pub(super) fn numbers(&self) -> usize {
        match self {
            Self::Spline(_, points) => H * points.len(),
            Self::Trimmed(_, basis) => basis.numbers(),
            _ => 0,
        }
    }
}

/// Why a form cannot be held.
pub(crate) type Refusal = TextProblem;

pub(super) fn vector<const D: usize>(
    t: &mut Tokens<'_>,
    what: &'static str,
) -> Result<SVector<f64, D>, ReadError> {
    t.numbers::<D>(what).map(SVector::from)
}

impl<const D: usize> Frame<D> {
    fn read(t: &mut Tokens<'_>) -> Result<Self, ReadError> {
        let center = Point::from(vector(t, "a centre")?);
        let z = if D == 3 {
            vector(t, "an axis")?
        } else {
            SVector::zeros()
        };
        let x = vector(t, "an x direction")?;
        let y = vector(t, "a y direction")?;
        Ok(Self { center, x, y, z })
    }

    /// `center + a x + b y`.
    fn at(&self, a: f64, b: f64) -> SVector<f64, D> {
        self.center.coords + self.x * a + self.y * b
    }
}

impl<const D: usize, const H: usize> Form<D, H> {
    /// Reads a curve. Recursion is bounded by [`MAX_NESTED`].
    pub(super) fn read(t: &mut Tokens<'_>, depth: u32) -> Result<Self, ReadError> {
        if depth >= MAX_NESTED {
            return Err(t.fail(TextProblem::Nested { limit: MAX_NESTED }));
        }
        let kind = t.word("the kind of a curve")?;
        Ok(match kind {
            b"1" => Self::Line {
                from: Point::from(vector(t, "a line's origin")?),
                direction: vector(t, "a line's direction")?,
            },
            b"2" => Self::Circle(Frame::read(t)?, t.number("a radius")?),
            b"3" => Self::Ellipse(Frame::read(t)?, t.numbers("an ellipse's radii")?),
            b"4" => Self::Parabola(Frame::read(t)?, t.number("a focal length")?),
            b"5" => Self::Hyperbola(Frame::read(t)?, t.numbers("a hyperbola's radii")?),
            b"6" => {
                let rational = t.flag("the rational flag")?;
                let degree = degree(t)?;
                let points = control_points(t, degree + 1, rational)?;
                Self::Spline(Knots::bezier(degree), points)
            }
            b"7" => {
                let rational = t.flag("the rational flag")?;
                let periodic = t.flag("the periodic flag")?;
                let degree = degree(t)?;
                let count = t.count("control points", D)?;
                let knot_count = t.count("knots", 2)?;
                let points = control_points(t, count, rational)?;
                Self::Spline(Knots::read(t, degree, periodic, count, knot_count)?, points)
            }
            b"8" => {
                let range = t.numbers("a trimmed curve's range")?;
                Self::Trimmed(range, Box::new(Self::read(t, depth + 1)?))
            }
            b"9" => {
                t.number("an offset")?;
                if D == 3 {
                    vector::<D>(t, "an offset's direction")?;
                }
                Self::read(t, depth + 1)?;
                Self::Offset
            }
            _ => return Err(t.unexpected("the kind of a curve", kind, "1 to 9")),
        })
    }

    /// Where the curve ends by itself; `None` where it goes on, or is refused.
    pub(crate) fn bounds(&self) -> Option<[f64; 2]> {
        match self {
            Self::Circle(..) | Self::Ellipse(..) => Some([0.0, TAU]),
            Self::Spline(knots, _) => {
                let window = knots.window(None)?;
                let from = window.knots.get(knots.degree)?;
                let to = window.knots.get(window.points.len())?;
                Some([*from, *to])
            }
            Self::Trimmed(range, _) => Some(*range),
            _ => None,
        }
    }

    /// The period of its parameter, if it has one.
    pub(crate) fn period(&self) -> Option<f64> {
        match self {
            Self::Circle(..) | Self::Ellipse(..) => Some(TAU),
            Self::Spline(knots, _) if knots.periodic => knots.period(),
            Self::Trimmed(_, basis) => basis.period(),
            _ => None,
        }
    }

    /// Whether the kernel's curve is the same whatever part of it is used.
    pub(crate) fn is_whole(&self) -> bool {
        match self {
            Self::Spline(knots, _) => !knots.periodic,
            Self::Trimmed(_, basis) => basis.is_whole(),
            _ => false,
        }
    }

    pub(crate) fn is_offset(&self) -> bool {
        match self {
            Self::Offset => true,
            Self::Trimmed(_, basis) => basis.is_offset(),
            _ => false,
        }
    }

    /// How the kernel's parameter goes with the file's where they differ: on the part over `range`.
    pub(crate) fn warp(&self, range: Interval) -> Result<Option<Warp>, Refusal> {
        Ok(match self {
            Self::Ellipse(..) => Some(Warp::Arcs(unit_circle::<D, H>(range)?.map)),
            Self::Hyperbola(..) => Some(Warp::Hyperbola(range)),
            Self::Trimmed(_, basis) => basis.warp(range)?,
            _ => None,
        })
    }

    /// The part of the curve over `range`, and its span of the parameter of what is returned. `numbers` is
    /// how many more numbers may be made.
    pub(crate) fn part(
        &self,
        range: [f64; 2],
        numbers: &mut Budget,
    ) -> Result<(Curve<D, H>, Interval), Refusal> {
        let Some(mut span) = Interval::new(range[0], range[1]) else {
            return Err(TextProblem::Shape {
                what: format!(
                    "a curve is used from parameter {:?} to {:?}: nothing of it",
                    range[0], range[1]
                ),
            });
        };
        if matches!(self, Self::Circle(..) | Self::Ellipse(..)) {
            if (span.length() - TAU).abs() <= ROUNDING * TAU {
                // Ranges are written with 15 digits: one turn is one turn.
                span.end = span.start + TAU;
            } else if span.length() > MOST_TURNS * TAU {
                return Err(TextProblem::Shape {
                    what: format!(
                        "a circle or an ellipse is used over [{:?}, {:?}], many turns",
                        range[0], range[1]
                    ),
                });
            }
        }
        let curve = match self {
            Self::Line { from, direction } => {
                let at = |t: f64| from + direction * t;
                let line = Line::new(at(span.start), at(span.end), span);
                Curve::Line(line.map_err(refused("a line"))?)
            }
            Self::Circle(frame, radius) => Curve::Arc(arc(frame, *radius, span)?),
            Self::Ellipse(frame, [a, b]) => {
                let circle: NurbsCurve<H> = unit_circle::<D, H>(span)?.nurbs;
                let points = circle.control_points().iter().map(|p| {
                    let w = p[H - 1];
                    let moved =
                        frame.center.coords * w + frame.x * (a * p[0]) + frame.y * (b * p[1]);
                    homogeneous(moved, w)
                });
                let (degree, knots) = (circle.degree(), circle.knots().knots().to_vec());
                nurbs("an ellipse", degree, points.collect(), knots)?
            }
            Self::Parabola(frame, focal) => {
                // The polar form of t^2 / (4 f) at (r, s) is r s / (4 f), of t their mean.
                let polar = |r: f64, s: f64| frame.at(r * s / (4.0 * focal), 0.5 * (r + s));
                let [r, s] = [span.start, span.end];
                let points = [polar(r, r), polar(r, s), polar(s, s)].map(|p| homogeneous(p, 1.0));
                nurbs("a parabola", 2, points.to_vec(), vec![r, r, r, s, s, s])?
            }
            Self::Hyperbola(frame, [a, b]) => {
                // As an arc's, with the hyperbolic functions for the circular ones.
                let (r, s) = (span.start, span.end);
                let at = |t: f64| frame.at(a * cosh(t), b * sinh(t));
                let w = cosh(0.5 * (s - r));
                let mid = 0.5 * (r + s);
                // The middle point is that of the tangents, times its weight w: nothing is divided.
                let middle =
                    frame.center.coords * w + frame.x * (a * cosh(mid)) + frame.y * (b * sinh(mid));
                let points = vec![
                    homogeneous(at(r), 1.0),
                    homogeneous(middle, w),
                    homogeneous(at(s), 1.0),
                ];
                nurbs("a hyperbola", 2, points, vec![r, r, r, s, s, s])?
            }
            Self::Spline(knots, points) => {
                let Some(window) = knots.window(Some(range)) else {
                    return Err(TextProblem::Shape {
                        what: format!(
                            "a periodic curve is used over [{:?}, {:?}], many periods",
                            range[0], range[1]
                        ),
                    });
                };
                numbers.take(H * window.points.len())?;
                // As many as there are: a list that grows would have room for twice that.
                let mut net = Vec::with_capacity(window.points.len());
                net.extend(window.points.iter().filter_map(|i| points.get(*i).copied()));
                let curve = nurbs("a B-spline curve", knots.degree, net, window.knots)?;
                span = clamped(span, curve.domain());
                curve
            }
            Self::Trimmed(_, basis) => return basis.part(range, numbers),
            Self::Offset => {
                return Err(TextProblem::Unsupported {
                    what: "an offset curve".into(),
                    remedy: "convert it to a B-spline (GeomConvert, BRepBuilderAPI_NurbsConvert)",
                });
            }
        };
        numbers.take(H)?;
        Ok((curve, span))
    }
}

/// The unit circle about the origin over a range of angles, as NURBS: what an ellipse is an image of.
fn unit_circle<const D: usize, const H: usize>(
    span: Interval,
) -> Result<ConvertedCurve<H>, Refusal> {
    let mut unit = Frame {
        center: Point::origin(),
        x: SVector::zeros(),
        y: SVector::zeros(),
        z: SVector::zeros(),
    };
    unit.x[0] = 1.0;
    unit.y[1] = 1.0;
    if D == 3 {
        unit.z[2] = 1.0;
    }
    let circle: Curve<D, H> = Curve::Arc(arc(&unit, 1.0, span)?);
    circle.to_nurbs().map_err(refused("an ellipse"))
}

fn arc<const D: usize>(frame: &Frame<D>, radius: f64, angle: Interval) -> Result<Arc<D>, Refusal> {
    let arc = Arc {
        center: frame.center,
        x: frame.x,
        y: frame.y,
        z: frame.z,
        radius,
        angle,
        domain: angle,
    };
    Arc::new(arc).map_err(refused("a circle"))
}

fn homogeneous<const D: usize, const H: usize>(point: SVector<f64, D>, w: f64) -> SVector<f64, H> {
    let mut p = SVector::repeat(w);
    for c in 0..D {
        p[c] = point[c];
    }
    p
}

fn nurbs<const D: usize, const H: usize>(
    what: &'static str,
    degree: usize,
    points: Vec<SVector<f64, H>>,
    knots: Vec<f64>,
) -> Result<Curve<D, H>, Refusal> {
    let curve = NurbsCurve::new(degree, points, knots).map_err(refused(what))?;
    Ok(Curve::Nurbs(curve))
}

pub(crate) fn refused(what: &'static str) -> impl Fn(GeometryError) -> Refusal {
    move |source| TextProblem::Geometry { what, source }
}

/// A span that sticks out of its curve's domain by no more than rounding, cut.
pub(crate) fn clamped(mut span: Interval, domain: Interval) -> Interval {
    let slack = ROUNDING * domain.start.abs().max(domain.end.abs());
    if span.start < domain.start && domain.start - span.start <= slack {
        span.start = domain.start;
    }
    if span.end > domain.end && span.end - domain.end <= slack {
        span.end = domain.end;
    }
    span
}

/// Turns that a circle or a surface of revolution may make: what a query takes grows with them, and a screw's thread, whose face winds, has some.
pub(crate) const MOST_TURNS: f64 = 32.0;

/// How many numbers may still be made: a file that uses the same spline over and over must not
/// take memory out of all proportion.
#[derive(Clone)]
pub(crate) struct Budget {
    left: usize,
    limit: usize,
}

impl Budget {
    pub(crate) fn new(limit: usize) -> Self {
        Self { left: limit, limit }
    }

    pub(crate) fn left(&self) -> usize {
        self.left
    }

    pub(crate) fn used(&self) -> usize {
        self.limit - self.left
    }

    pub(crate) fn take(&mut self, count: usize) -> Result<(), Refusal> {
        match self.left.checked_sub(count) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(TextProblem::Limit {
                what: "numbers",
                limit: self.limit,
            }),
        }
    }
}

/// A curve in space, moved. Rounded.
pub(crate) fn moved(curve: Curve<3, 4>, motion: &Motion) -> Result<Curve<3, 4>, Refusal> {
    if motion.is_identity() {
        return Ok(curve);
    }
    if !motion.is_rigid() {
        return motion.curve(&curve);
    }
    Ok(match curve {
        Curve::Line(mut l) => {
            (l.from, l.to) = (motion.point(&l.from), motion.point(&l.to));
            Curve::Line(l)
        }
        Curve::Arc(mut a) => {
            a.center = motion.point(&a.center);
            [a.x, a.y, a.z] = [a.x, a.y, a.z].map(|v| motion.vector(&v));
            Curve::Arc(a)
        }
        Curve::Nurbs(n) => {
            let points = n.control_points().iter().map(|p| motion.homogeneous(p));
            let knots = n.knots().knots().to_vec();
            nurbs("a moved curve", n.degree(), points.collect(), knots)?
        }
        // Never made here.
        other @ (Curve::Polyline(_) | Curve::Poly(_)) => other,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point2, Vector2};

    /// A damaged file asked for 83 million turns, with which a query takes seconds.
    #[test]
    fn circles_are_used_for_few_turns() {
        let frame = || Frame {
            center: Point2::origin(),
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
        };
        let circle: Form<2, 3> = Form::Circle(frame(), 2.5);
        let ellipse: Form<2, 3> = Form::Ellipse(frame(), [2.5, 1.0]);
        for curve in [circle, ellipse] {
            let mut numbers = Budget::new(10_000);
            for range in [[0.0, TAU], [-4.0, 8.0], [-100.0, 100.0]] {
                assert!(curve.part(range, &mut numbers).is_ok());
            }
            for range in [[0.0, 202.0], [0.0, 522_133_279.0]] {
                let refused = curve.part(range, &mut numbers).unwrap_err().to_string();
                assert!(refused.contains("turns"), "{refused}");
            }
        }
    }
}
