//! Curves on their way into a file.

use super::super::curves::{Form, Frame};
use super::super::splines::Knots;
use super::Problem;
use super::surfaces::Chart;
use super::text::near;
use crate::reversed::{negated, reversed_curve};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, KnotVector, Line, NurbsCurve};
use nalgebra::{Point, SVector};

/// What is off by no more than this part of a length of 1, or of the model's size, is rounded: some sixty units in the last place.
pub(super) const ROUNDED: f64 = 1.0 / (1_u64 << 46) as f64;

/// A part of a curve, to be run forward: a line, an arc with its angle as parameter, or NURBS.
#[derive(Clone, Debug)]
pub(super) struct Piece<const D: usize, const H: usize> {
    pub(super) curve: Curve<D, H>,
    pub(super) range: Interval,
    /// How far the curve is from the one it stands for: 0 but for curves in pieces.
    pub(super) bound: f64,
}

impl<const D: usize, const H: usize> Piece<D, H> {
    pub(super) fn new(
        curve: &Curve<D, H>,
        span: Interval,
        reversed: bool,
    ) -> Result<Self, Problem> {
        let (curve, span) = if reversed {
            (reversed_curve(curve)?, negated(span))
        } else {
            (curve.clone(), span)
        };
        let (mut range, mut bound) = (span, 0.0);
        let curve = match curve {
            Curve::Arc(a) => {
                range = angles(&a, span)?;
                let angle = a.angle;
                Curve::Arc(Arc { domain: angle, ..a })
            }
            Curve::Polyline(_) | Curve::Poly(_) => {
                let converted = curve.to_nurbs()?;
                bound = converted.bound;
                Curve::Nurbs(converted.nurbs)
            }
            other => other,
        };
        Ok(Self {
            curve,
            range,
            bound,
        })
    }

    /// Whether its parameter may be any: a line or a single Bezier piece, all of it.
    pub(super) fn is_loose(&self) -> bool {
        self.range == self.curve.domain()
            && match &self.curve {
                Curve::Line(_) => true,
                Curve::Nurbs(n) => {
                    let order = n.degree() + 1;
                    let knots = n.knots().knots();
                    n.control_points().len() == order
                        && knots
                            .get(..order)
                            .is_some_and(|k| k.iter().all(|t| *t == knots[0]))
                        && knots
                            .get(order..)
                            .is_some_and(|k| k.iter().all(|t| *t == knots[2 * order - 1]))
                }
                _ => false,
            }
    }

    /// The same points over another range, run at the same pace. Exact where [`is_loose`](Self::is_loose), else knots or an arc's
    /// axes are rounded. `None` where that cannot be said: an arc over another angle.
    pub(super) fn over(&self, range: Interval) -> Result<Option<Self>, Problem> {
        if range == self.range {
            return Ok(Some(self.clone()));
        }
        let (from, own) = (self.range, range);
        let pace = own.length() / from.length();
        let moved = |t: f64| match t {
            t if t == from.start => own.start,
            t if t == from.end => own.end,
            t => own.start + (t - from.start) * pace,
        };
        let domain = self.curve.domain();
        let domain = Interval::new(moved(domain.start), moved(domain.end));
        let Some(domain) = domain else {
            return Ok(None);
        };
        let curve = match &self.curve {
            Curve::Line(l) => Curve::Line(Line::new(l.from, l.to, domain)?),
            Curve::Nurbs(n) => {
                let knots: Vec<f64> = n.knots().knots().iter().map(|t| moved(*t)).collect();
                let points = n.control_points().to_vec();
                match NurbsCurve::new(n.degree(), points, knots) {
                    Ok(curve) => Curve::Nurbs(curve),
                    // Knots that fall together.
                    Err(_) => return Ok(None),
                }
            }
            Curve::Arc(a) if (pace - 1.0).abs() <= ROUNDED => {
                let (sin, cos) = sine_cosine(own.start - from.start);
                Curve::Arc(Arc {
                    x: a.x * cos - a.y * sin,
                    y: a.x * sin + a.y * cos,
                    angle: domain,
                    domain,
                    ..a.clone()
                })
            }
            _ => return Ok(None),
        };
        Ok(Some(Self {
            curve,
            range: own,
            bound: self.bound,
        }))
    }

    /// As the file has it.
    pub(super) fn form(&self) -> Result<Form<D, H>, Problem> {
        let whole = self.range == self.curve.domain();
        if let Curve::Line(l) = &self.curve
            && !whole
        {
            // The ends of a part of a line would be rounded.
            return straight_spline(l);
        }
        form(&self.curve)
    }
}

impl Piece<2, 3> {
    /// The same on a form's parameters.
    pub(super) fn charted(&self, chart: &Chart) -> Result<Self, Problem> {
        let curve = match &self.curve {
            // What becomes an ellipse becomes no more than the part that is used: its parameter is another.
            Curve::Arc(a) => Curve::Arc(Arc {
                angle: self.range,
                domain: self.range,
                ..a.clone()
            }),
            other => other.clone(),
        };
        Ok(Self {
            curve: chart.curve(&curve)?,
            range: self.range,
            bound: self.bound,
        })
    }
}

/// The same bits on every platform.
pub(super) fn sine_cosine(angle: f64) -> (f64, f64) {
    let (sin, cos) = feeler::numeric::sin_cos(feeler::numeric::Ball::exact(angle));
    (sin.mid.hi, cos.mid.hi)
}

/// The angles at the ends of a part of an arc.
fn angles<const D: usize>(a: &Arc<D>, span: Interval) -> Result<Interval, Problem> {
    if a.angle == a.domain {
        return Ok(span);
    }
    let at = |t: f64| {
        if t == a.domain.start {
            a.angle.start
        } else if t == a.domain.end {
            a.angle.end
        } else {
            let s = (t - a.domain.start) / a.domain.length();
            a.angle.lerp(s).clamp(a.angle.start, a.angle.end)
        }
    };
    Interval::new(at(span.start), at(span.end))
        .ok_or_else(|| Problem::new("a part of an arc is too short to be told from a point"))
}

/// A curve as the file has it; in space with the parameter as it is: an arc's must be its angle.
pub(super) fn form<const D: usize, const H: usize>(
    curve: &Curve<D, H>,
) -> Result<Form<D, H>, Problem> {
    match curve {
        Curve::Line(l) => match line(l) {
            Some(form) => Ok(form),
            None => straight_spline(l),
        },
        Curve::Arc(a) if a.angle == a.domain => Ok(Form::Circle(
            Frame {
                center: a.center,
                x: a.x,
                y: a.y,
                z: a.z,
            },
            a.radius,
        )),
        Curve::Nurbs(n) => spline(n),
        Curve::Polyline(_) => match curve.to_nurbs() {
            Ok(same) => spline(&same.nurbs),
            Err(e) => Err(e.into()),
        },
        Curve::Arc(_) | Curve::Poly(_) => Err(Problem::new(
            "a surface is made of a curve in pieces or of an arc with a parameter that is not its angle",
        )),
    }
}

fn spline<const D: usize, const H: usize>(n: &NurbsCurve<H>) -> Result<Form<D, H>, Problem> {
    Ok(Form::Spline(knots(n.knots())?, n.control_points().to_vec()))
}

fn straight_spline<const D: usize, const H: usize>(l: &Line<D>) -> Result<Form<D, H>, Problem> {
    let ends = [(l.domain.start, 2), (l.domain.end, 2)];
    let knots = Knots::new(1, false, 2, ends.to_vec()).map_err(|e| Problem::new(e.to_string()))?;
    let points = [l.from, l.to].map(|p| SVector::from_fn(|i, _| if i < D { p[i] } else { 1.0 }));
    Ok(Form::Spline(knots, points.to_vec()))
}

/// Knots with their multiplicities.
pub(super) fn knots(all: &KnotVector) -> Result<Knots, Problem> {
    let mut distinct: Vec<(f64, usize)> = Vec::new();
    for knot in all.knots() {
        match distinct.last_mut() {
            Some((last, count)) if last == knot => *count += 1,
            _ => distinct.push((*knot, 1)),
        }
    }
    let knots = Knots::new(all.degree(), false, all.control_points(), distinct);
    knots.map_err(|e| Problem::new(e.to_string()))
}

/// A line that gives both ends back bit for bit and whose direction has length 1 but for rounding: OCCT makes it 1.
fn line<const D: usize, const H: usize>(l: &Line<D>) -> Option<Form<D, H>> {
    let [s, t] = [l.domain.start, l.domain.end];
    let mut from = Point::<f64, D>::origin();
    let mut direction = SVector::<f64, D>::zeros();
    for c in 0..D {
        (from[c], direction[c]) = coordinate([l.from[c], l.to[c]], [s, t])?;
    }
    let is_unit = (direction.norm() - 1.0).abs() <= ROUNDED;
    is_unit.then_some(Form::Line { from, direction })
}

/// `o` and `d` with `o + d t` rounding to both values.
fn coordinate([a, b]: [f64; 2], [s, t]: [f64; 2]) -> Option<(f64, f64)> {
    let slope = (b - a) / (t - s);
    for d in near(slope) {
        for o in near(a - d * s).chain(near(b - d * t)) {
            if o + d * s == a && o + d * t == b {
                return Some((o, d));
            }
        }
    }
    None
}
