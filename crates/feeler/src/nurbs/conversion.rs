//! Native forms as NURBS.

use super::eval::{Rotation, frame};
use super::{
    Arc, BezierPiece, Curve, GeometryError, NurbsCurve, NurbsSurface, ParameterMap, Plane,
    Polyline, Revolution, Sum, Surface,
};
use crate::numeric::{Ball, Dd, Interval, sin_cos};
use nalgebra::{Point, SVector, Vector4};

/// A curve as NURBS.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvertedCurve<const H: usize> {
    /// The NURBS form, over the same domain.
    pub nurbs: NurbsCurve<H>,
    /// How its parameter goes with the native one.
    pub map: ParameterMap,
    /// Bound on the distance, in model units, of every point of one form from the point
    /// of the other at the mapped parameter (the exact map, not its rounding).
    pub bound: f64,
}

/// A surface as NURBS.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvertedSurface {
    /// The NURBS form, over the same domain.
    pub nurbs: NurbsSurface,
    /// How its parameters go with the native ones, u and v.
    pub maps: [ParameterMap; 2],
    /// Bound on the distance, in model units, of points at mapped parameters.
    pub bound: f64,
}

/// An arc becomes one rational quadratic for each 120 degrees or less than that; this many turns at most.
const MAX_TURNS: f64 = 64.0;
/// A little less than 120 degrees, so that rounding never reaches it.
const MAX_PIECE: f64 = 2.09;

/// n u / (1 - n u) with u = 2^-53, rounded up (Higham, section 3.1).
fn gamma(n: usize) -> f64 {
    let nu = n as f64 * f64::EPSILON / 2.0;
    nu / (1.0 - 2.0 * nu)
}

/// Makes up for the handful of roundings in computing a bound.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// Rounds exact homogeneous points, and keeps a bound on what that does to the surface or curve.
///
/// Lemma: a rational spline's points are X = sum B_i A_i / sum B_i w_i with B_i >= 0, w_i > 0. Changing A_i
/// by at most a_i (a length) and w_i by at most b_i to w_i' > 0 moves X by at most
/// max_i (a_i + |X| b_i) / w_i', as X' - X = sum B_i (dA_i - X dw_i) / sum B_i w_i'; and |X| is at most the
/// largest |A_i / w_i|, by the convex hull.
#[derive(Default)]
struct Rounding {
    /// The largest a_i / w_i', b_i / w_i' and |A_i / w_i| so far.
    coordinates: f64,
    weights: f64,
    size: f64,
}

impl Rounding {
    fn point<const H: usize>(&mut self, exact: [Ball<Dd>; H]) -> SVector<f64, H> {
        let rounded = SVector::from(exact.map(|b| b.mid.hi));
        let w = rounded[H - 1];
        let error = exact.map(|b| b.mid.lo.abs() + b.rad);
        let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.coordinates = self.coordinates.max(length(&error[..H - 1]) / w);
        self.weights = self.weights.max(error[H - 1] / w);
        let size =
            (length(&rounded.as_slice()[..H - 1]) + length(&error[..H - 1])) / (w - error[H - 1]);
        self.size = self.size.max(size);
        rounded
    }

    fn bound(&self) -> f64 {
        (self.coordinates + self.size * self.weights) * UP
    }
}

/// The largest distance of a control point from the origin.
fn reach<const H: usize>(points: &[SVector<f64, H>]) -> f64 {
    points
        .iter()
        .map(|p| length(p) / p[H - 1])
        .fold(0.0, f64::max)
        * UP
}

/// The length of a homogeneous point without its weight.
fn length<const H: usize>(p: &SVector<f64, H>) -> f64 {
    p.iter().take(H - 1).map(|x| x * x).sum::<f64>().sqrt()
}

/// Where an arc is cut: pieces of equal angle, as parameters; and half of each angle, exactly.
struct Cuts {
    params: Vec<f64>,
    half: Ball<Dd>,
}

impl Cuts {
    fn new(what: &'static str, angle: Interval, domain: Interval) -> Result<Self, GeometryError> {
        let sweep = angle.length();
        let usable = sweep <= MAX_TURNS * std::f64::consts::TAU;
        if !usable {
            return Err(GeometryError::Angle {
                what,
                start: angle.start,
                end: angle.end,
            });
        }
        let pieces = (sweep / MAX_PIECE).ceil().max(1.0);
        let n = pieces as usize;
        let params: Vec<f64> = (0..=n).map(|i| domain.lerp(i as f64 / pieces)).collect();
        if params.windows(2).any(|w| w[0] >= w[1]) {
            return Err(GeometryError::EmptyInterval {
                what: "a piece of an arc",
            });
        }
        let half = Ball::difference(angle.end, angle.start) / Ball::exact(2.0 * pieces);
        Ok(Self { params, half })
    }

    /// Each control point's angle and whether it is a middle one.
    fn angles(&self, start: f64) -> impl Iterator<Item = (Ball<Dd>, bool)> + '_ {
        (0..=2 * (self.params.len() - 1)).map(move |i| {
            let angle = Ball::exact(start) + self.half * Ball::exact(i as f64);
            (angle, i % 2 == 1)
        })
    }

    fn knots(&self) -> Vec<f64> {
        let last = self.params.len() - 1;
        let mut knots = vec![self.params[0]];
        for p in &self.params {
            knots.extend([*p, *p]);
        }
        knots.push(self.params[last]);
        knots
    }

    fn map(&self) -> ParameterMap {
        let mut map = ParameterMap::default();
        for w in self.params.windows(2) {
            map.push_arc(
                Interval {
                    start: w[0],
                    end: w[1],
                },
                self.half.mid.hi,
            );
        }
        map
    }
}

fn homogeneous<const D: usize, const H: usize>(p: &Point<f64, D>) -> SVector<f64, H> {
    SVector::from_fn(|i, _| if i < D { p[i] } else { 1.0 })
}

fn polyline<const D: usize, const H: usize>(
    points: &[Point<f64, D>],
    params: &[f64],
) -> Result<ConvertedCurve<H>, GeometryError> {
    let mut knots = vec![params[0]];
    knots.extend_from_slice(params);
    knots.push(params[params.len() - 1]);
    let points = points.iter().map(homogeneous).collect();
    Ok(ConvertedCurve {
        nurbs: NurbsCurve::new(1, points, knots)?,
        map: ParameterMap::default(),
        bound: 0.0,
    })
}

fn arc<const D: usize, const H: usize>(arc: &Arc<D>) -> Result<ConvertedCurve<H>, GeometryError> {
    let cuts = Cuts::new("an arc", arc.angle, arc.domain)?;
    let (x, y) = frame(arc);
    let (_, middle) = sin_cos(cuts.half);
    let mut rounding = Rounding::default();
    let radius = Ball::exact(arc.radius);
    let points = cuts
        .angles(arc.angle.start)
        .map(|(angle, is_middle)| {
            // A middle point (weight w = cos h) lies at radius r / w: times w it is w c + r dir.
            let w = if is_middle { middle } else { Ball::ONE };
            let (sin, cos) = sin_cos(angle);
            rounding.point::<H>(std::array::from_fn(|c| {
                if c < D {
                    w * Ball::exact(arc.center[c]) + radius * (cos * x[c] + sin * y[c])
                } else {
                    w
                }
            }))
        })
        .collect();
    Ok(ConvertedCurve {
        nurbs: NurbsCurve::new(2, points, cuts.knots())?,
        map: cuts.map(),
        bound: rounding.bound(),
    })
}

/// One degree higher (The NURBS Book, equation 5.36 with t = 1).
fn elevated<const H: usize>(points: &[SVector<f64, H>]) -> Vec<SVector<f64, H>> {
    let n = points.len();
    (0..=n)
        .map(|i| {
            if i == 0 || i == n {
                return points[i.min(n - 1)];
            }
            points[i] + (points[i - 1] - points[i]) * (i as f64 / n as f64)
        })
        .collect()
}

/// Segments in a row: as Bezier pieces of the largest degree.
fn poly<const D: usize, const H: usize>(
    segments: &[Curve<D, H>],
    params: &[f64],
) -> Result<ConvertedCurve<H>, GeometryError> {
    let converted: Vec<ConvertedCurve<H>> = segments
        .iter()
        .map(Curve::to_nurbs)
        .collect::<Result<_, _>>()?;
    let degree = converted
        .iter()
        .map(|c| c.nurbs.degree())
        .max()
        .unwrap_or(1);
    let mut points: Vec<SVector<f64, H>> = Vec::new();
    let mut breaks = vec![params[0]];
    let mut map = ParameterMap::default();
    let (mut rounding, mut gap, mut size) = (0.0f64, 0.0f64, 0.0f64);
    for (segment, (converted, to)) in segments.iter().zip(converted.iter().zip(params.windows(2))) {
        let from = segment.domain();
        let to = Interval {
            start: to[0],
            end: to[1],
        };
        let moved = |t: f64| {
            if t == from.end {
                to.end
            } else {
                let fraction = (t - from.start) / from.length();
                to.lerp(fraction).clamp(to.start, to.end)
            }
        };
        for (on, half) in converted.map.arcs() {
            let (start, end) = (moved(on.start), moved(on.end));
            map.push_arc(Interval { start, end }, *half);
        }
        rounding = rounding.max(converted.bound);
        size = size.max(reach(converted.nurbs.control_points()));
        for piece in converted.nurbs.bezier_pieces() {
            let BezierPiece {
                domain,
                mut control_points,
            } = piece;
            for _ in converted.nurbs.degree()..degree {
                control_points = elevated(&control_points);
            }
            if let Some(last) = points.last().copied() {
                // One homogeneous point at the joint: scale this piece to the weight
                // there, and let its own start win (the half-open rule).
                let scale = last[H - 1] / control_points[0][H - 1];
                for p in &mut control_points {
                    *p *= scale;
                }
                let start = control_points[0];
                let step = length(&(start - last)) / last[H - 1];
                gap = gap.max(step);
                points.pop();
            }
            points.extend(control_points);
            breaks.push(moved(domain.end));
        }
    }
    if breaks.windows(2).any(|w| w[0] >= w[1]) {
        return Err(GeometryError::EmptyInterval {
            what: "a piece of a poly-curve",
        });
    }
    let mut knots = vec![breaks[0]];
    for b in &breaks {
        knots.extend(std::iter::repeat_n(*b, degree));
    }
    knots.push(breaks[breaks.len() - 1]);
    // Bezier extraction gamma_{6p} and its quotient as much again, elevation gamma_4 for each
    // degree, the scale gamma_2, all of coordinates and weights both, in up to 3 coordinates.
    let steps = 2 * (6 * degree + 4 * degree + 4);
    let bound = (rounding + gap + 2.0 * gamma(steps) * size) * UP;
    Ok(ConvertedCurve {
        nurbs: NurbsCurve::new(degree, points, knots)?,
        map,
        bound,
    })
}

impl<const D: usize, const H: usize> Curve<D, H> {
    /// The curve as NURBS over the same domain.
    ///
    /// - Lines and polylines: exact, degree 1. NURBS: as they are.
    /// - Arcs: rational quadratics, each turning by less than 120 degrees (The NURBS Book, A7.1), their
    ///   control points rounded. The parameter is no longer linear in the angle: see [`ParameterMap`].
    /// - Poly-curves: Bezier pieces elevated to the largest degree. Breaks move to the nearest f64 (so the
    ///   bound holds at parameters moved accordingly); a gap between segments is closed by moving the
    ///   end of the one before, and counts in the bound.
    ///
    /// # Errors
    /// An arc of more than 64 turns, or of pieces too short for its parameters to differ.
    pub fn to_nurbs(&self) -> Result<ConvertedCurve<H>, GeometryError> {
        match self {
            Self::Line(c) => polyline(&[c.from, c.to], &[c.domain.start, c.domain.end]),
            Self::Polyline(c) => {
                let c: &Polyline<D> = c;
                polyline(c.points(), c.params())
            }
            Self::Arc(c) => arc(c),
            Self::Nurbs(c) => Ok(ConvertedCurve {
                nurbs: c.clone(),
                map: ParameterMap::default(),
                bound: 0.0,
            }),
            Self::Poly(c) => poly(c.segments(), c.params()),
        }
    }
}

fn plane(s: &Plane) -> Result<ConvertedSurface, GeometryError> {
    let mut rounding = Rounding::default();
    let mut net = Vec::with_capacity(4);
    for a in [s.extents[0].start, s.extents[0].end] {
        for b in [s.extents[1].start, s.extents[1].end] {
            let (a, b) = (Ball::exact(a), Ball::exact(b));
            net.push(rounding.point::<4>(std::array::from_fn(|c| {
                if c < 3 {
                    Ball::exact(s.origin[c]) + Ball::exact(s.x[c]) * a + Ball::exact(s.y[c]) * b
                } else {
                    Ball::ONE
                }
            })));
        }
    }
    let knots = |d: Interval| vec![d.start, d.start, d.end, d.end];
    Ok(ConvertedSurface {
        nurbs: NurbsSurface::new(
            [1, 1],
            [2, 2],
            net,
            [knots(s.domain[0]), knots(s.domain[1])],
        )?,
        maps: Default::default(),
        bound: rounding.bound(),
    })
}

fn revolution(s: &Revolution) -> Result<ConvertedSurface, GeometryError> {
    let profile = s.profile.to_nurbs()?;
    let cuts = Cuts::new("a revolution", s.angle, s.angle_domain)?;
    let (_, middle) = sin_cos(cuts.half);
    let mut rounding = Rounding::default();
    let columns = profile.nurbs.control_points();
    // Row by row of angles.
    let mut rows: Vec<Vec<Vector4<f64>>> = Vec::new();
    let split: Vec<Rotation> = columns.iter().map(|p| Rotation::new(s, p)).collect();
    for (angle, is_middle) in cuts.angles(s.angle.start) {
        let share = if is_middle { middle } else { Ball::ONE };
        let (sin, cos) = sin_cos(angle);
        let row = columns
            .iter()
            .zip(&split)
            .map(|(p, r)| {
                let [x, y, z] = r.turned(sin, cos, share);
                rounding.point::<4>([x, y, z, share * Ball::exact(p[3])])
            })
            .collect();
        rows.push(row);
    }
    let counts = [rows.len(), columns.len()];
    let (angular_knots, own_knots) = (cuts.knots(), profile.nurbs.knots().knots().to_vec());
    let degree = profile.nurbs.degree();
    let bound = (rounding.bound() + profile.bound) * UP;
    if s.transposed {
        let net = (0..counts[1])
            .flat_map(|j| rows.iter().map(move |r| r[j]))
            .collect();
        Ok(ConvertedSurface {
            nurbs: NurbsSurface::new(
                [degree, 2],
                [counts[1], counts[0]],
                net,
                [own_knots, angular_knots],
            )?,
            maps: [profile.map, cuts.map()],
            bound,
        })
    } else {
        Ok(ConvertedSurface {
            nurbs: NurbsSurface::new(
                [2, degree],
                counts,
                rows.concat(),
                [angular_knots, own_knots],
            )?,
            maps: [cuts.map(), profile.map],
            bound,
        })
    }
}

fn sum(s: &Sum) -> Result<ConvertedSurface, GeometryError> {
    let (first, second) = (s.first.to_nurbs()?, s.second.to_nurbs()?);
    let mut rounding = Rounding::default();
    let mut net = Vec::new();
    for a in first.nurbs.control_points() {
        for b in second.nurbs.control_points() {
            // (A / v + B / w + base) of weight v w.
            let (v, w) = (Ball::<Dd>::exact(a[3]), Ball::<Dd>::exact(b[3]));
            net.push(rounding.point::<4>(std::array::from_fn(|c| {
                if c < 3 {
                    Ball::exact(a[c]) * w + v * Ball::exact(b[c]) + v * w * Ball::exact(s.base[c])
                } else {
                    v * w
                }
            })));
        }
    }
    let degrees = [first.nurbs.degree(), second.nurbs.degree()];
    let counts = [
        first.nurbs.control_points().len(),
        second.nurbs.control_points().len(),
    ];
    let knots = [
        first.nurbs.knots().knots().to_vec(),
        second.nurbs.knots().knots().to_vec(),
    ];
    Ok(ConvertedSurface {
        nurbs: NurbsSurface::new(degrees, counts, net, knots)?,
        maps: [first.map, second.map],
        bound: (rounding.bound() + first.bound + second.bound) * UP,
    })
}

impl Surface {
    /// The surface as NURBS over the same domain.
    ///
    /// - Planes: degrees (1, 1), corners rounded. NURBS: as they are.
    /// - Revolutions: rational quadratic in the angle, each piece less than 120 degrees (The NURBS Book,
    ///   A8.1), times the profile as NURBS. The angular parameter changes: see [`ParameterMap`].
    /// - Sums: weights are the products of the curves' weights.
    ///
    /// Control points are computed in double-double and rounded once.
    ///
    /// # Errors
    /// As for [`Curve::to_nurbs`].
    pub fn to_nurbs(&self) -> Result<ConvertedSurface, GeometryError> {
        match self {
            Self::Plane(s) => plane(s),
            Self::Revolution(s) => revolution(s),
            Self::Sum(s) => sum(s),
            Self::Nurbs(s) => Ok(ConvertedSurface {
                nurbs: s.clone(),
                maps: Default::default(),
                bound: 0.0,
            }),
        }
    }
}
