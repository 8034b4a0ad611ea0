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

use super::chart::{Chart, Located};
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
    t: Vec<f64>,
    at: Vec<Point2<f64>>,
    on_axis: [bool; 2],
}

fn sample(chart: &Chart, points: &Points<'_>, span: Interval) -> Trace {
    let mut breaks = points.curve.breaks();
    breaks.retain(|b| span.start < *b && *b < span.end);
    let mut ends = vec![span.start];
    ends.extend(breaks);
    ends.push(span.end);
    let each = (MOST_SAMPLES / ends.len()).clamp(1, SAMPLES);
    let mut t = Vec::new();
    for w in ends.windows(2) {
        t.extend((0..each).map(|k| w[0] + (w[1] - w[0]) * (k as f64 / each as f64)));
    }
    t.push(span.end);
    let n = t.len();
    let points: Vec<Point3<f64>> = t.iter().map(|t| points.at(*t)).collect();
    let middle = n / 2;
    let mut found: Vec<Option<Located>> = vec![None; n];
    if let (Some(p), Some(slot)) = (points.get(middle), found.get_mut(middle)) {
        *slot = Some(chart.locate(p, None));
    }
    let order = (middle + 1..n)
        .map(|k| (k, k - 1))
        .chain((0..middle).rev().map(|k| (k, k + 1)));
    for (k, from) in order {
        let near = found.get(from).copied().flatten().map(|l| l.uv);
        if let (Some(p), Some(slot)) = (points.get(k), found.get_mut(k)) {
            *slot = Some(chart.locate(p, near));
        }
    }
    let found: Vec<Located> = found.into_iter().flatten().collect();
    let mut at: Vec<Point2<f64>> = found.iter().map(|l| l.uv).collect();
    // On the axis u is what it tends to: that of the next sample, and the difference to the one after.
    let on_axis = [found.first(), found.last()].map(|l| l.is_some_and(|l| l.on_axis));
    if let ([a, b, c, ..], true) = (&mut at[..], on_axis[0]) {
        a.x = 2.0 * b.x - c.x;
    }
    if let ([.., c, b, a], true) = (&mut at[..], on_axis[1]) {
        a.x = 2.0 * b.x - c.x;
    }
    Trace { t, at, on_axis }
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
    let off = |t: f64| {
        chart
            .off_axis(&points.at(t))
            .unwrap_or([f64::INFINITY, 0.0])
    };
    let is_on = |t: f64| {
        let [rho, most] = off(t);
        rho <= most
    };
    let n = MOST_SAMPLES.min(SAMPLES * curve.breaks().len());
    let at: Vec<(f64, Point3<f64>, f64)> = (0..=n)
        .map(|k| span.lerp(k as f64 / n as f64))
        .map(|t| (t, points.at(t), off(t)[0]))
        .collect();
    for w in at.windows(3) {
        let [(mut lo, p, before), (t, q, own), (mut hi, r, after)] = [w[0], w[1], w[2]];
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
fn fits(chart: &Chart, points: &Points<'_>, trace: &Trace, made: &Curve2, slack: f64) -> bool {
    trace.t.iter().zip(&trace.at).all(|(t, uv)| {
        let p = points.at(*t);
        let own = (chart.point(uv) - p).norm();
        (chart.point(&made.point(*t)) - p).norm() <= 2.0 * own + slack
    })
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
        let samples = SAMPLES;
        let worst = (0..=samples)
            .map(|k| off(&curve.point(span.lerp(k as f64 / samples as f64))))
            .fold(0.0, f64::max);
        if !(worst <= most) {
            return Err(astray(entity, worst));
        }
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
    let trace = sample(chart, &points, span);
    let (Some(&from), Some(&to)) = (trace.at.first(), trace.at.last()) else {
        return Err(super::entities::shape(entity, "an edge of no length"));
    };
    let middle = trace.at.get(trace.at.len() / 2).copied().unwrap_or(from);
    let slack = ROUNDED * size;
    let worst = { trace.t.iter().zip(&trace.at) }
        .map(|(t, uv)| (chart.point(uv) - points.at(*t)).norm())
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
        if !fits(chart, &points, &trace, &line, slack) {
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
                let (sin, cos) = feeler::numeric::sin_cos(feeler::numeric::Ball::exact(t));
                let (sin, cos) = (sin.mid.hi, cos.mid.hi);
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

/// `None`: it comes no nearer than `most`. An error: `held` has no room for a piece for each of the edge's own.
fn fitted(
    chart: &Chart,
    points: &Points<'_>,
    trace: &Trace,
    size: f64,
    most: f64,
    held: &mut Budget,
) -> Result<Option<Curve2>, Refusal> {
    let knots: Vec<Knot> = { trace.t.iter().zip(&trace.at) }
        .map(|(t, uv)| Knot { t: *t, uv: *uv })
        .collect();
    let (Some(&first), Some(&last)) = (knots.first(), knots.last()) else {
        return Ok(None);
    };
    // Pieces at first: those of the edge's own curve.
    let mut breaks = points.curve.breaks();
    breaks.retain(|b| first.t < *b && *b < last.t);
    let mut stack: Vec<(Knot, Knot, u32)> = Vec::new();
    let mut ends = vec![first];
    // Both grow.
    let mut rest = breaks.iter().peekable();
    for k in &knots {
        while rest.next_if(|b| **b < k.t).is_some() {}
        if rest.next_if(|b| **b == k.t).is_some() {
            ends.push(*k);
        }
    }
    ends.push(last);
    for w in ends.windows(2).rev() {
        stack.push((w[0], w[1], 0));
    }
    let own = stack.len();
    held.take(own * PIECE)?;
    let most_pieces = own + MOST_PIECES.min(held.left() / PIECE);
    let mut control: Vec<Vector3<f64>> = vec![first.uv.coords.push(1.0)];
    let mut written = vec![first.t; 4];
    let mut pieces = 0;
    while let Some((a, b, depth)) = stack.pop() {
        let tangents = [
            tangent(chart, points, a, b, Limit::FromAbove),
            tangent(chart, points, b, a, Limit::FromBelow),
        ];
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
        // Searches start from it, or from the chord where that is nearer: where an edge runs unevenly the cubic may be far off.
        let guess = |q: &Point3<f64>, s: f64| {
            let (near, chord) = (cubic(s), a.uv + (b.uv - a.uv) * s);
            let off = |uv: Point2<f64>| (chart.point(&chart.clamped(uv)) - q).norm_squared();
            if chart.is_elementary() || off(near) <= off(chord) {
                near
            } else {
                chord
            }
        };
        let q = points.at(middle);
        let located = chart.locate(&q, Some(guess(&q, 0.5)));
        let own = chart.point(&located.uv);
        let mut worst = (chart.point(&chart.clamped(cubic(0.5))) - own).norm();
        let mut good = worst <= FIT * size;
        for s in [0.25, 0.75] {
            if good {
                let q = points.at(a.t + (b.t - a.t) * s);
                let near = chart.locate(&q, Some(guess(&q, s)));
                let off = chart.point(&chart.clamped(cubic(s))) - chart.point(&near.uv);
                worst = off.norm();
                good = worst <= FIT * size;
            }
        }
        let can = depth < HALVINGS && pieces + stack.len() < most_pieces;
        if !good && can && a.t < middle && middle < b.t {
            let m = Knot {
                t: middle,
                uv: located.uv,
            };
            stack.push((m, b, depth + 1));
            stack.push((a, m, depth + 1));
            continue;
        }
        if !(worst <= most) {
            return Ok(None);
        }
        pieces += 1;
        control.extend(p.iter().skip(1).map(|q| q.coords.push(1.0)));
        written.extend([b.t; 3]);
    }
    written.push(last.t);
    held.take((pieces - own) * PIECE)?;
    // It is kept, and room that lists grew by would be, too.
    control.shrink_to_fit();
    written.shrink_to_fit();
    Ok(NurbsCurve::new(3, control, written).ok().map(Curve::Nurbs))
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
    if let Some(uv) = chart.pulled_back(&at.uv, &along) {
        return uv;
    }
    // Where the surface has no tangent plane: a difference.
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
