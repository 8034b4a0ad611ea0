//! Curves in uv, from curves in space: the projection of an edge onto the surface of a face.
//!
//! - **Planes**: exact up to rounding, for every curve (`occt::projection`).
//! - **Straight in uv**: lines on cylinders and cones, circles about an axis or through it on cylinders, cones, spheres and tori, isoparametric
//!   curves in general. A straight curve in uv with the edge's parameter is taken where none of its samples is farther from the edge than twice the
//!   nearest point of the surface is, beyond rounding.
//! - **Fitted**: otherwise cubics through points and tangents of the projection, halved until the middle of each is within [`FIT`] of the size.
//!
//! **Bound.** On elementary surfaces (and, of circles of latitude, on all that are turned about an axis) the distance `D(t)` of the image of a straight curve in uv and of the edge is
//! - of a line along a cylinder or cone: of two lines, affine in t, so largest at an end, by convexity;
//! - of an arc and a circle of latitude or of a meridian (u or v fixed, the other the arc's angle, with it or against it):
//!   `D = a + b cos t + c sin t`, each of the two being so. From `D` at three angles 120 degrees apart follow a (their mean), b and c
//!   (`2/3` of the sums with cos and sin), and `|D| <= |a| + |b cos t + c sin t| <= |a| + sqrt(|b|^2 + |c|^2)`.
//!
//! On a plane the distance is at most that of the farthest control point from it (convex hull; weights are positive). Of other curves on elementary
//! surfaces it is bounded from points on them and what their series leave out ([`smooth`]), where no curve is rational. All others are bounded by
//! the kernel once the BREP is there ([`feeler::prepare::trim_offsets`]).

use super::chart::Chart;
use super::entities::form;
use super::geometry::Left;
use super::points::Points;
use super::smooth::{self, largest};
use crate::error::ReadError;
use crate::occt::curves::{Budget, Refusal};
use crate::occt::projection::projected;
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, Curve2, Curve3, Limit, Line, NurbsCurve};
use nalgebra::{Point2, Point3, Vector2, Vector3};
use std::f64::consts::TAU;

/// What a straight curve in uv may be off beyond what the surface is, relative to the size: what 10 digits print.
const ROUNDED: f64 = 1.0 / (1_u64 << 32) as f64;
/// How near fitted curves come at the middle of each piece, relative to the size.
pub(super) const FIT: f64 = 1.0 / (1_u64 << 29) as f64;
/// What is farther from a surface, relative to the size and beyond twice the file's tolerance, is not on it.
const FAR: f64 = 1.0 / (1 << 14) as f64;
/// Samples of each span of an edge's curve, and in all.
const SAMPLES: usize = 16;
const MOST_SAMPLES: usize = 2048;
/// How often a piece is halved, and how many pieces there may be.
const HALVINGS: u32 = 7;
const MOST_PIECES: usize = 512;
/// Numbers of a piece: three control points and three knots.
const PIECE: usize = 12;
/// Roundings of points by formula, relative to the size: trigonometric functions and a dozen operations.
pub(super) const FORMULA: f64 = 64.0 * f64::EPSILON;

/// What rounding leaves of a rate of 1.
const RATE: f64 = 8.0 * f64::EPSILON;

/// A curve in uv.
pub(super) struct Made {
    pub(super) curve: Curve2,
    /// A proven bound on the distance of its image from the edge's curve, where it is known here.
    pub(super) bound: Option<f64>,
    /// Whether it was fitted.
    pub(super) fitted: bool,
    /// Whether it starts, and ends, on the axis of its surface.
    pub(super) on_axis: [bool; 2],
}

/// Where the samples of an edge are on a surface.
struct Trace {
    samples: Vec<Sample>,
    on_axis: [bool; 2],
}

/// One point of an edge, and the nearest of the surface.
#[derive(Clone, Copy)]
struct Sample {
    t: f64,
    uv: Point2<f64>,
    at: Point3<f64>,
    /// How far apart they are.
    off: f64,
}

/// `most`: how many, beyond one for each of the edge's own pieces.
fn sample(chart: &Chart, points: &Points<'_>, span: Interval, most: usize) -> Trace {
    let inner = { points.breaks().iter().copied() }.filter(|b| span.start < *b && *b < span.end);
    let pieces = inner.clone().count() + 1;
    let each = (most / (pieces + 1)).clamp(1, SAMPLES);
    let mut samples = Vec::with_capacity(pieces * each + 1);
    let mut push = |t: f64| {
        samples.push(Sample {
            t,
            uv: Point2::origin(),
            at: points.at(t),
            off: 0.0,
        });
    };
    let mut start = span.start;
    for end in inner.chain([span.end]) {
        (0..each).for_each(|k| push(start + (end - start) * (k as f64 / each as f64)));
        start = end;
    }
    push(span.end);
    // From the middle on to both ends, each from the one before.
    let n = samples.len();
    let middle = n / 2;
    let mut on_axis = [false; 2];
    let order = { (middle..n).map(|k| (k, k.wrapping_sub(1))) }
        .chain((0..middle).rev().map(|k| (k, k + 1)));
    for (k, from) in order {
        let near = samples.get(from).filter(|_| k != middle).map(|s| s.uv);
        if let Some(s) = samples.get_mut(k) {
            let found = chart.locate(&s.at, near);
            s.uv = found.uv;
            on_axis[0] |= k == 0 && found.on_axis;
            on_axis[1] |= k + 1 == n && found.on_axis;
        }
    }
    // On the axis u is what it tends to: that of the next sample, and the difference to the one after.
    if let ([a, b, c, ..], true) = (&mut samples[..], on_axis[0]) {
        a.uv.x = 2.0 * b.uv.x - c.uv.x;
    }
    if let ([.., c, b, a], true) = (&mut samples[..], on_axis[1]) {
        a.uv.x = 2.0 * b.uv.x - c.uv.x;
    }
    for s in &mut samples {
        s.off = (chart.point(&s.uv) - s.at).norm();
    }
    Trace { samples, on_axis }
}

/// The straight curve in uv between two points.
fn straight(from: Point2<f64>, to: Point2<f64>, span: Interval) -> Option<Curve2> {
    Line::new(from, to, span).ok().map(Curve::Line)
}

/// Where an edge goes through the axis of its surface, between its ends: it must be split there. Between samples that are farther from the axis, by
/// golden section of the distance, which falls and rises there.
pub(super) fn pole(chart: &Chart, curve: &Curve3, span: Interval) -> Option<f64> {
    let points = Points::of(curve);
    chart.off_axis(&points.at(span.start))?;
    let off_at = |p: &Point3<f64>| chart.off_axis(p).unwrap_or([f64::INFINITY, 0.0]);
    let off = |t: f64| off_at(&points.at(t));
    let is_on = |t: f64| {
        let [rho, most] = off(t);
        rho <= most
    };
    let n = MOST_SAMPLES.min(SAMPLES * points.breaks().len());
    let at = |k: usize| {
        let t = span.lerp(k as f64 / n as f64);
        let p = points.at(t);
        (t, p, off_at(&p)[0])
    };
    let mut last = [at(0), at(1)];
    for k in 2..=n {
        let next = at(k);
        let [(mut lo, p, before), (t, q, own)] = last;
        let (mut hi, r, after) = next;
        last = [last[1], next];
        // The axis is no farther than the curve goes from here: twice the chord has room for its bends.
        let goes = 2.0 * (q - p).norm().max((r - q).norm());
        if own > before || own > after || own > goes || is_on(lo) || is_on(hi) {
            continue;
        }
        if is_on(t) {
            return Some(t);
        }
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        for _ in 0..96 {
            let by = ratio * (hi - lo);
            let (a, b) = (hi - by, lo + by);
            if off(a)[0] <= off(b)[0] {
                hi = b;
            } else {
                lo = a;
            }
        }
        let t = 0.5 * (lo + hi);
        if is_on(t) {
            return Some(t);
        }
    }
    None
}

/// Whether the image of a curve in uv is as near the edge as the surface is.
fn fits(chart: &Chart, trace: &Trace, made: &Curve2, slack: f64) -> bool {
    trace
        .samples
        .iter()
        .all(|s| (chart.point(&made.point(s.t)) - s.at).norm() <= 2.0 * s.off + slack)
}

/// The curve in uv of an edge's curve over its `span`. `left`: how many pieces may still be proven by points, see
/// [`smooth::bound`], and what a fitted curve may hold; it is coarser where it may hold little.
pub(super) fn made(
    entity: u64,
    chart: &Chart,
    curve: &Curve3,
    span: Interval,
    size: f64,
    tolerance: f64,
    left: &mut Left,
) -> Result<Made, ReadError> {
    let most = (2.0 * tolerance).max(FAR * size);
    if let Some(axes) = chart.plane() {
        let normal = axes.x.cross(&axes.y).normalize();
        let off = |p: &Point3<f64>| (p - axes.origin).dot(&normal).abs();
        let bound = match curve {
            Curve::Line(l) => off(&l.from).max(off(&l.to)),
            Curve::Arc(a) => {
                let tilt = [a.x, a.z.cross(&a.x)].map(|v| v.dot(&normal).abs());
                off(&a.center) + a.radius * tilt[0].hypot(tilt[1])
            }
            Curve::Nurbs(n) => n
                .control_points()
                .iter()
                .map(|p| off(&Point3::from(p.xyz() / p.w)))
                .fold(0.0, f64::max),
            _ => f64::INFINITY,
        };
        if !(bound <= most) {
            // What is beyond it may be another part of its curve.
            let points = Points::of(curve);
            let worst = (0..=SAMPLES)
                .map(|k| off(&points.at(span.lerp(k as f64 / SAMPLES as f64))))
                .fold(0.0, f64::max);
            if !(worst <= most) {
                return Err(astray(entity, worst));
            }
        }
        let far = (0..3).fold(size, |most, c| most.max(largest(curve, c)));
        // An arc that becomes an ellipse has other parameters between its ends: of a piece those must be its own.
        let part;
        let own = match curve {
            Curve::Arc(a) if span != a.domain => {
                part = Curve::Arc(part_of(a, span));
                &part
            }
            _ => curve,
        };
        return Ok(Made {
            curve: projected(own, axes).map_err(form(entity))?,
            bound: Some(bound + FORMULA * far),
            fitted: false,
            on_axis: [false; 2],
        });
    }
    let points = Points::of(curve);
    let trace = sample(chart, &points, span, MOST_SAMPLES.min(left.samples));
    let uv = |k: usize| trace.samples.get(k).map(|s| s.uv);
    let last = trace.samples.len().saturating_sub(1);
    let (Some(from), Some(middle), Some(to)) = (uv(0), uv(last.div_ceil(2)), uv(last)) else {
        return Err(super::entities::shape(entity, "an edge of no length"));
    };
    let slack = ROUNDED * size;
    let worst = { trace.samples.iter() }
        .map(|s| s.off)
        // No number is the worst there is.
        .fold(0.0, |a: f64, b| if b <= a { a } else { b });
    if !(worst <= most) {
        return Err(astray(entity, worst));
    }
    let candidates = [
        // Lines of u and v first: what they are they are exactly.
        (Point2::new(middle.x, from.y), Point2::new(middle.x, to.y)),
        (Point2::new(from.x, middle.y), Point2::new(to.x, middle.y)),
        (from, to),
    ];
    for (i, (a, b)) in candidates.into_iter().enumerate() {
        let (a, b) = whole_turns(curve, span, a, b);
        let Some(line) = straight(a, b, span) else {
            continue;
        };
        if !fits(chart, &trace, &line, slack) {
            continue;
        }
        let bound = if i < 2 && (i == 1 || chart.is_elementary()) {
            straight_bound(chart, curve, span, [a, b], i)
        } else {
            None
        };
        let bound =
            bound.or_else(|| smooth::bound(chart, curve, &line, span, size, &mut left.pieces));
        return Ok(Made {
            curve: line,
            bound,
            fitted: false,
            on_axis: trace.on_axis,
        });
    }
    let fitted = fitted(chart, &points, &trace, size, most, &mut left.held)
        .map_err(form(entity))?
        .ok_or_else(|| super::entities::shape(entity, "an edge that could not be projected"))?;
    Ok(Made {
        bound: smooth::bound(chart, curve, &fitted, span, size, &mut left.pieces),
        curve: fitted,
        fitted: true,
        on_axis: trace.on_axis,
    })
}

/// A piece of an arc whose parameter is its angle.
fn part_of(arc: &Arc<3>, span: Interval) -> Arc<3> {
    Arc {
        angle: span,
        domain: span,
        ..arc.clone()
    }
}

/// An edge that is not on its face.
fn astray(entity: u64, off: f64) -> ReadError {
    let what = format!("an edge that is {off:.2e} from the surface of a face that it bounds");
    super::entities::shape(entity, what)
}

/// An angle runs as an arc's does, to the last digit, where it nearly does: a full turn is one.
fn whole_turns(
    curve: &Curve3,
    span: Interval,
    a: Point2<f64>,
    mut b: Point2<f64>,
) -> (Point2<f64>, Point2<f64>) {
    if let Curve::Arc(_) = curve {
        for c in 0..2 {
            let by = b[c] - a[c];
            if by != 0.0 && (by.abs() - span.length()).abs() <= ROUNDED * span.length() {
                b[c] = a[c] + span.length() * by.signum();
            }
        }
    }
    (a, b)
}

/// See the [module](self).
fn straight_bound(
    chart: &Chart,
    curve: &Curve3,
    span: Interval,
    [a, b]: [Point2<f64>; 2],
    fixed: usize,
) -> Option<f64> {
    // A circle that a damaged file names may be larger than all of its points are far.
    let rounded = chart.rounded(a.y.abs().max(b.y.abs()))?;
    let rounded = (0..3).fold(rounded, |most, c| most.max(largest(curve, c)));
    let rate = (b - a) / span.length();
    let at = |t: f64| a + rate * (t - span.start);
    let bound = match curve {
        Curve::Line(_) if chart.is_ruled() && fixed == 0 => {
            let off = |t: f64, uv: Point2<f64>| (chart.point(&uv) - curve.point(t)).norm();
            off(span.start, a).max(off(span.end, b))
        }
        Curve::Arc(arc) if (rate[1 - fixed].abs() - 1.0).abs() <= RATE && rate[fixed] == 0.0 => {
            // A meridian of a cylinder or cone is no circle.
            if fixed == 0 && chart.is_ruled() {
                return None;
            }
            // At most 8 from the start, the rate's error moves a point by 8 RATE of the size: the second half of the rounding below.
            let y = arc.z.cross(&arc.x);
            let mut sums = [Vector3::zeros(); 3];
            for k in 0..3 {
                let t = span.start + TAU / 3.0 * f64::from(k);
                let (sin, cos) = libm::sincos(t);
                let own = arc.center + (arc.x * cos + y * sin) * arc.radius;
                let d = chart.point(&at(t)) - own;
                sums[0] += d / 3.0;
                sums[1] += d * (2.0 / 3.0 * cos);
                sums[2] += d * (2.0 / 3.0 * sin);
            }
            sums[0].norm() + sums[1].norm().hypot(sums[2].norm())
        }
        _ => return None,
    };
    Some(bound + 2.0 * FORMULA * rounded)
}

/// One end of a piece.
#[derive(Clone, Copy)]
struct Knot {
    t: f64,
    uv: Point2<f64>,
}

impl From<&Sample> for Knot {
    fn from(s: &Sample) -> Self {
        Self { t: s.t, uv: s.uv }
    }
}

/// `None`: it comes no nearer than `most`. An error: `held` has no room for a piece for each of the edge's own.
fn fitted(
    chart: &Chart,
    points: &Points<'_>,
    trace: &Trace,
    size: f64,
    most: f64,
    held: &mut Budget,
) -> Result<Option<Curve2>, Refusal> {
    let [first, .., last] = &trace.samples[..] else {
        return Ok(None);
    };
    let [first, last] = [first, last].map(Knot::from);
    // Pieces at first: those of the edge's own curve.
    let inner = |s: &&Sample| first.t < s.t && s.t < last.t && points.is_break(s.t);
    let ends = trace.samples.iter().filter(inner);
    let own = ends.clone().count() + 1;
    // Before the curve is made of them the points take two thirds of what they do in it, and an eighth more as their list grows.
    let room = 7 * held.left() / (10 * PIECE);
    held.take(own * PIECE)?;
    let most_pieces = own.max(room.min(own + MOST_PIECES));
    let mut control: Vec<Point2<f64>> = Vec::with_capacity(3 * own + 1);
    let mut written: Vec<f64> = Vec::with_capacity(own);
    control.push(first.uv);
    let mut pieces = 0;
    let mut stack: Vec<([Knot; 2], [Vector2<f64>; 2], u32)> = Vec::new();
    let mut begun = first;
    for (k, end) in ends.map(Knot::from).chain([last]).enumerate() {
        let waiting = own - k - 1;
        let tangents = [
            tangent(chart, points, begun, end, Limit::FromAbove),
            tangent(chart, points, end, begun, Limit::FromBelow),
        ];
        stack.push(([begun, end], tangents, 0));
        begun = end;
        while let Some(([a, b], tangents, depth)) = stack.pop() {
            let third = (b.t - a.t) / 3.0;
            let p = [
                a.uv,
                a.uv + tangents[0] * third,
                b.uv - tangents[1] * third,
                b.uv,
            ];
            let cubic = |s: f64| {
                let r = 1.0 - s;
                let sum = p[0].coords * (r * r * r)
                    + p[1].coords * (3.0 * r * r * s)
                    + p[2].coords * (3.0 * r * s * s)
                    + p[3].coords * (s * s * s);
                Point2::from(sum)
            };
            let middle = 0.5 * (a.t + b.t);
            // Where the edge is there on the surface, and how far the cubic is from that. Searches start from the cubic, or from the chord
            // where that is nearer: where an edge runs unevenly the cubic may be far off.
            let at = |t: f64, s: f64| {
                let q = points.at(t);
                let (near, chord) = (cubic(s), a.uv + (b.uv - a.uv) * s);
                let on = chart.point(&chart.clamped(near));
                let off = (on - q).norm();
                let is_near = chart.is_elementary()
                    || off <= FIT * size
                    || off <= (chart.point(&chart.clamped(chord)) - q).norm();
                let start = if is_near { near } else { chord };
                let uv = chart.locate(&q, Some(start)).uv;
                (uv, (on - chart.point(&uv)).norm())
            };
            let (uv, mut worst) = at(middle, 0.5);
            let mut good = worst <= FIT * size;
            for s in [0.25, 0.75] {
                if good {
                    worst = at(a.t + (b.t - a.t) * s, s).1;
                    good = worst <= FIT * size;
                }
            }
            let waiting = waiting + stack.len();
            let can = depth < HALVINGS && pieces + waiting < most_pieces;
            if !good && can && a.t < middle && middle < b.t {
                let m = Knot { t: middle, uv };
                // Within a piece of the edge's it is one on both sides.
                let along = chart.pulled_back(&m.uv, &points.tangent(m.t, Limit::FromAbove));
                let [before, after] =
                    [a, b].map(|o| along.unwrap_or_else(|| step(chart, points, m, o)));
                stack.push(([m, b], [after, tangents[1]], depth + 1));
                stack.push(([a, m], [tangents[0], before], depth + 1));
                continue;
            }
            if !(worst <= most) {
                return Ok(None);
            }
            pieces += 1;
            grow(&mut control, 3);
            control.extend(p.iter().skip(1));
            grow(&mut written, 1);
            written.push(b.t);
        }
    }
    held.take((pieces - own) * PIECE)?;
    let control = control.into_iter().map(|q| q.coords.push(1.0)).collect();
    let mut knots = Vec::with_capacity(3 * pieces + 5);
    knots.extend([first.t; 4]);
    knots.extend(written.iter().flat_map(|t| [*t; 3]));
    knots.push(last.t);
    Ok(NurbsCurve::new(3, control, knots).ok().map(Curve::Nurbs))
}

/// Makes room for `count` more, and for little beyond.
pub(super) fn grow<T>(list: &mut Vec<T>, count: usize) {
    if list.capacity() - list.len() < count {
        list.reserve_exact(count.max(list.len() / 8));
    }
}

/// The derivative of the projection at `at`, on the side of `other`.
fn tangent(
    chart: &Chart,
    points: &Points<'_>,
    at: Knot,
    other: Knot,
    limit: Limit,
) -> Vector2<f64> {
    let along = points.tangent(at.t, limit);
    chart
        .pulled_back(&at.uv, &along)
        .unwrap_or_else(|| step(chart, points, at, other))
}

/// The same where the surface has no tangent plane: a difference.
fn step(chart: &Chart, points: &Points<'_>, at: Knot, other: Knot) -> Vector2<f64> {
    let step = (other.t - at.t) / (1 << 12) as f64;
    let near = at.uv + (other.uv - at.uv) / f64::from(1 << 12);
    let next = chart.locate(&points.at(at.t + step), Some(near));
    (next.uv - at.uv) / step
}

/// The file's curve in uv where it is as near to the edge as `tolerance`, at the edge's own parameter.
pub(super) fn taken(
    chart: &Chart,
    curve: &Curve3,
    span: Interval,
    own: Curve2,
    tolerance: f64,
) -> Option<Made> {
    let domain = own.domain();
    if !(domain.start <= span.start && span.end <= domain.end) {
        return None;
    }
    let n = MOST_SAMPLES.min(SAMPLES * curve.breaks().len());
    let near = (0..=n).all(|k| {
        let t = span.lerp(k as f64 / n as f64);
        let uv = own.point(t);
        let inside = chart.clamped(uv) == uv;
        inside && (chart.point(&uv) - curve.point(t)).norm() <= tolerance
    });
    near.then_some(Made {
        curve: own,
        bound: None,
        fitted: false,
        on_axis: [false; 2],
    })
}
