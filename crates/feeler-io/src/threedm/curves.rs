//! Curves in uv (`D = 2`) and in space (`D = 3`).

use super::archive::Chunk;
use super::class::{self, Class};
use crate::error::{Problem, ReadError};
use crate::occt::curves::MOST_TURNS;
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, GeometryError, Line, NurbsCurve, PolyCurve, Polyline};
use nalgebra::{Point, SVector};
use std::f64::consts::TAU;

/// Which file versions to save as when a layout is not known.
pub(super) const REMEDY: &str = "5 to 8 with Rhino or rhino3dm";

/// The smallest object: three chunk headers of 8 bytes, an id and two checksums.
pub(super) const MIN_OBJECT: usize = 48;

/// The curve that is the next chunk of `parent`. Recursion (poly-curves) is bounded by
/// [`MAX_DEPTH`](super::archive::MAX_DEPTH).
pub(super) fn curve<const D: usize, const H: usize>(
    parent: &mut Chunk<'_>,
    role: &'static str,
) -> Result<Curve<D, H>, ReadError> {
    let (class, data) = class::object(parent)?;
    curve_of(class, data, role)
}

/// The same when class and data are at hand.
pub(super) fn curve_of<const D: usize, const H: usize>(
    class: Class,
    mut data: Chunk<'_>,
    role: &'static str,
) -> Result<Curve<D, H>, ReadError> {
    let curve = match class {
        Class::LineCurve => Curve::Line(line(&mut data)?),
        Class::ArcCurve => Curve::Arc(arc(&mut data)?),
        Class::PolylineCurve => Curve::Polyline(polyline(&mut data)?),
        Class::NurbsCurve => Curve::Nurbs(nurbs(&mut data)?),
        Class::PolyCurve => Curve::Poly(poly(&mut data, role)?),
        _ => return Err(unusable(class, &data, role)),
    };
    data.finish()?;
    Ok(curve)
}

/// What is said of a class that is none of a curve that can be used.
pub(super) fn unusable(class: Class, data: &Chunk<'_>, role: &'static str) -> ReadError {
    let remedy = if class == Class::CurveOnSurface {
        "convert it to a NURBS curve (Rhino: ToNURBS) and save again"
    } else {
        "convert it to NURBS (Rhino: ToNURBS) and save again"
    };
    let class = class.name();
    data.fail_at(
        data.id.offset,
        Problem::Class {
            class,
            role,
            remedy,
        },
    )
}

/// Wraps what the kernel refuses.
pub(super) fn geometry<T>(
    data: &Chunk<'_>,
    class: &'static str,
    result: Result<T, GeometryError>,
) -> Result<T, ReadError> {
    result.map_err(|source| data.fail_at(data.id.offset, Problem::Geometry { class, source }))
}

fn bad_dimension(data: &Chunk<'_>, at: usize, found: i32, wanted: usize) -> ReadError {
    data.fail_at(
        at,
        Problem::Value {
            what: "the curve's dimension".into(),
            found: found.to_string(),
            expected: wanted.to_string(),
        },
    )
}

/// The dimension, which must be `D`.
fn dimension<const D: usize>(data: &mut Chunk<'_>) -> Result<(), ReadError> {
    let at = data.position();
    let found = data.i32("the dimension")?;
    match usize::try_from(found) {
        Ok(d) if d == D => Ok(()),
        _ => Err(bad_dimension(data, at, found, D)),
    }
}

fn vector<const D: usize>(
    data: &mut Chunk<'_>,
    what: &'static str,
) -> Result<SVector<f64, D>, ReadError> {
    let p: [f64; 3] = data.f64s(what)?;
    // Always stored with three coordinates; the third of a curve in uv is no part of it.
    Ok(SVector::from_iterator(p.into_iter().take(D)))
}

fn point<const D: usize>(
    data: &mut Chunk<'_>,
    what: &'static str,
) -> Result<Point<f64, D>, ReadError> {
    vector(data, what).map(Point::from)
}

fn line<const D: usize>(data: &mut Chunk<'_>) -> Result<Line<D>, ReadError> {
    class::layout(data, "LineCurve", &[1], REMEDY)?;
    let from = point(data, "a line's start")?;
    let to = point(data, "a line's end")?;
    let domain = data.interval("a line's domain")?;
    dimension::<D>(data)?;
    geometry(data, "LineCurve", Line::new(from, to, domain))
}

/// A range of angles. What a query takes grows with the turns, and only damaged files have many.
pub(super) fn few_turns(data: &mut Chunk<'_>, what: &'static str) -> Result<Interval, ReadError> {
    let at = data.position();
    let angle = data.interval(what)?;
    if angle.length().abs() <= MOST_TURNS * TAU {
        return Ok(angle);
    }
    Err(data.fail_at(
        at,
        Problem::Value {
            what: what.into(),
            found: format!("[{:?}, {:?}]", angle.start, angle.end),
            expected: format!("{MOST_TURNS} turns at most"),
        },
    ))
}

fn arc<const D: usize>(data: &mut Chunk<'_>) -> Result<Arc<D>, ReadError> {
    class::layout(data, "ArcCurve", &[1], REMEDY)?;
    let center = point(data, "an arc's centre")?;
    let x = vector(data, "an arc's x axis")?;
    let y = vector(data, "an arc's y axis")?;
    let normal = vector(data, "an arc's z axis")?;
    let z = if D == 2 { SVector::zeros() } else { normal };
    // The plane's equation follows from its frame.
    data.f64s::<4>("an arc's plane equation")?;
    let radius = data.f64("an arc's radius")?;
    // Three points on the circle, rounded: the frame and the radius say where they are.
    data.f64s::<9>("an arc's points")?;
    let angle = few_turns(data, "an arc's angle")?;
    let domain = data.interval("an arc's domain")?;
    dimension::<D>(data)?;
    let arc = Arc {
        center,
        x,
        y,
        z,
        radius,
        angle,
        domain,
    };
    geometry(data, "ArcCurve", Arc::new(arc))
}

fn polyline<const D: usize>(data: &mut Chunk<'_>) -> Result<Polyline<D>, ReadError> {
    class::layout(data, "PolylineCurve", &[1], REMEDY)?;
    let n = data.count("polyline points", 3 * size_of::<f64>())?;
    let mut points = Vec::with_capacity(n);
    for _ in 0..n {
        points.push(point(data, "a polyline point")?);
    }
    let params = data.f64_array("polyline parameters")?;
    dimension::<D>(data)?;
    geometry(data, "PolylineCurve", Polyline::new(points, params))
}

/// The segments of a poly-curve, each with its own domain.
pub(super) struct Segments<const D: usize, const H: usize> {
    pub(super) curves: Vec<Curve<D, H>>,
    params: Vec<f64>,
}

impl<const D: usize, const H: usize> Segments<D, H> {
    /// The poly-curve itself.
    pub(super) fn join(self) -> Result<Curve<D, H>, GeometryError> {
        PolyCurve::new(self.curves, self.params).map(Curve::Poly)
    }
}

/// The segments of the poly-curve whose data is at hand.
pub(super) fn poly_segments<const D: usize, const H: usize>(
    mut data: Chunk<'_>,
    role: &'static str,
) -> Result<Segments<D, H>, ReadError> {
    let segments = segments(&mut data, role)?;
    data.finish()?;
    Ok(segments)
}

/// A poly-curve whose fields come next, without an object's wrapper; of one segment, that segment.
pub(super) fn poly_or_only<const D: usize, const H: usize>(
    data: &mut Chunk<'_>,
    role: &'static str,
) -> Result<Curve<D, H>, ReadError> {
    let mut segments = segments(data, role)?;
    if segments.curves.len() == 1
        && let Some(only) = segments.curves.pop()
    {
        return Ok(only);
    }
    geometry(data, "PolyCurve", segments.join())
}

fn segments<const D: usize, const H: usize>(
    data: &mut Chunk<'_>,
    role: &'static str,
) -> Result<Segments<D, H>, ReadError> {
    class::layout(data, "PolyCurve", &[1], REMEDY)?;
    let n = data.count("poly-curve segments", MIN_OBJECT)?;
    data.skip(2 * size_of::<i32>(), "reserved fields")?;
    data.f64s::<6>("a poly-curve's box")?;
    let params = data.f64_array("poly-curve parameters")?;
    let mut curves = Vec::new();
    for _ in 0..n {
        curves.push(curve(data, role)?);
    }
    Ok(Segments { curves, params })
}

fn poly<const D: usize, const H: usize>(
    data: &mut Chunk<'_>,
    role: &'static str,
) -> Result<PolyCurve<D, H>, ReadError> {
    let Segments { curves, params } = segments(data, role)?;
    geometry(data, "PolyCurve", PolyCurve::new(curves, params))
}

/// Sizes of one direction of a spline, as stored.
pub(super) struct SplineSize {
    pub(super) degree: usize,
    pub(super) count: usize,
}

impl SplineSize {
    /// Checks an order and a number of control points of at least `point_size` bytes each.
    pub(super) fn new(
        data: &Chunk<'_>,
        at: usize,
        order: i32,
        count: i32,
        point_size: usize,
    ) -> Result<Self, ReadError> {
        let count = data.check_count(at, "control points", i64::from(count), point_size)?;
        match usize::try_from(order) {
            Ok(order) if order >= 2 && order <= count => Ok(Self {
                degree: order - 1,
                count,
            }),
            _ => Err(data.fail_at(
                at,
                Problem::Value {
                    what: "the order".into(),
                    found: order.to_string(),
                    expected: format!("2 to the number of control points ({count})"),
                },
            )),
        }
    }

    /// Reads the knots and adds the two that the format leaves out.
    ///
    /// The format stores `n + p` knots where The NURBS Book has `n + p + 1` (n control points):
    /// without the first and the last. On a span `[u_k, u_{k+1})` inside the domain (`p <= k < n`) de
    /// Boor's algorithm reads the knots `u_{k-p+1} .. u_{k+p}`, that is, none outside `u_1 .. u_{n+p-1}`,
    /// so the two outer ones change no point and no derivative there, and any choice that keeps the
    /// vector non-decreasing is right. The end knots are repeated, which clamps a clamped spline fully.
    pub(super) fn knots(&self, data: &mut Chunk<'_>) -> Result<Vec<f64>, ReadError> {
        let at = data.position();
        let stored = data.f64_array("knots")?;
        let expected = self.count.saturating_add(self.degree).saturating_sub(1);
        if stored.len() == expected {
            return Ok(widened(&stored));
        }
        Err(data.fail_at(
            at,
            Problem::Value {
                what: "the number of knots".into(),
                found: stored.len().to_string(),
                expected: expected.to_string(),
            },
        ))
    }
}

/// Stored knots with the two outer ones, which repeat the ends.
pub(super) fn widened(stored: &[f64]) -> Vec<f64> {
    let ends = stored
        .first()
        .into_iter()
        .chain(stored)
        .chain(stored.last());
    ends.copied().collect()
}

/// Whether control points have weights.
pub(super) fn rational(data: &mut Chunk<'_>) -> Result<bool, ReadError> {
    Ok(data.i32("the rational flag")? != 0)
}

/// Checks that as many control points follow as were announced.
pub(super) fn control_point_count(data: &mut Chunk<'_>, expected: usize) -> Result<(), ReadError> {
    let at = data.position();
    let found = data.i32("the number of control points")?;
    if usize::try_from(found) == Ok(expected) {
        return Ok(());
    }
    Err(data.fail_at(
        at,
        Problem::Value {
            what: "the number of control points".into(),
            found: found.to_string(),
            expected: expected.to_string(),
        },
    ))
}

/// One control point, homogeneous as stored (`w x, .., w`); weight 1 where none is stored.
pub(super) fn control_point<const H: usize>(
    data: &mut Chunk<'_>,
    rational: bool,
) -> Result<SVector<f64, H>, ReadError> {
    let mut p = SVector::<f64, H>::repeat(1.0);
    let stored = if rational { H } else { H - 1 };
    for x in p.iter_mut().take(stored) {
        *x = data.f64("a control point")?;
    }
    Ok(p)
}

fn nurbs<const H: usize>(data: &mut Chunk<'_>) -> Result<NurbsCurve<H>, ReadError> {
    class::layout(data, "NurbsCurve", &[1], REMEDY)?;
    let at = data.position();
    let found = data.i32("the dimension")?;
    if usize::try_from(found) != Ok(H - 1) {
        return Err(bad_dimension(data, at, found, H - 1));
    }
    let rational = rational(data)?;
    let at = data.position();
    let order = data.i32("the order")?;
    let count = data.i32("the number of control points")?;
    let size = SplineSize::new(data, at, order, count, (H - 1) * size_of::<f64>())?;
    data.skip(2 * size_of::<i32>(), "reserved fields")?;
    data.f64s::<6>("a curve's box")?;
    let knots = size.knots(data)?;
    control_point_count(data, size.count)?;
    let mut points = Vec::with_capacity(size.count);
    for _ in 0..size.count {
        points.push(control_point(data, rational)?);
    }
    geometry(
        data,
        "NurbsCurve",
        NurbsCurve::new(size.degree, points, knots),
    )
}
