//! Curves in uv, from curves in space: the projection of an edge onto the surface of a face.
//!
//! - **Planes**: exact up to rounding, for every curve (`occt::projection`).
//! - **Straight in uv**: lines on cylinders and cones, circles about an axis or through it on cylinders, cones, spheres and tori, isoparametric
//!   curves in general. A straight curve in uv with the edge's parameter is taken where none of its samples is farther from the edge than twice the
//!   nearest point of the surface is, beyond rounding.
//! - **Fitted**: otherwise cubics through points and tangents of the projection, halved until each is within [`FIT`] of the size at three points; or, where these would be many,
//!   quintics that go through points at thirds, too, within a quarter of that.
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

use super::chart::{Chart, Located, foot_off, pulled_back};
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
/// Samples of an edge's curve, of each span (of many spans no more than it has degrees of freedom there), and in all.
const SAMPLES: usize = 16;
const MOST_SAMPLES: usize = 2048;
/// How often a piece is halved, and how many pieces there may be.
const HALVINGS: u32 = 7;
const MOST_PIECES: usize = 512;
/// Numbers of a piece for each degree: a control point and a knot.
const PIECE: usize = 4;
/// Degrees of fitted curves.
const CUBIC: usize = 3;
const QUINTIC: usize = 5;
/// Beyond this degree the kernel composes no curve with a surface ([`feeler::prepare::trim_offsets`]).
const MOST_COMPOSED: usize = 192;
/// So many parts a piece is split into at most, at a time.
const MOST_PARTS: f64 = 8.0;
/// Lines of u and v that an edge is searched for places where it crosses them, and steps of each search.
const MOST_CROSSED: usize = 256;
const CROSSING: usize = 24;
/// No two of them are nearer than this part of the edge.
const CLEAR: f64 = 1.0 / (1 << 20) as f64;
/// Steps in space below this part of the size are taken for where they lead: surfaces bend little on them.
const SHORT: f64 = 1.0 / (1 << 16) as f64;
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
    let each = SAMPLES.div_ceil(pieces).max(points.degree() + 1);
    let each = each.min(most / (pieces + 1)).clamp(1, SAMPLES);
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
    let mut first = None;
    let mut last = None;
    for k in (middle..n).chain((0..middle).rev()) {
        if k + 1 == middle {
            last = first;
        }
        if let Some(s) = samples.get_mut(k) {
            let found = chart.locate(&s.at, last.as_ref());
            s.uv = found.uv;
            s.off = (found.point(chart) - s.at).norm();
            on_axis[0] |= k == 0 && found.on_axis;
            on_axis[1] |= k + 1 == n && found.on_axis;
            last = Some(found);
            if k == middle {
                first = last;
            }
        }
    }
    // On the axis u is what it tends to: that of the next sample, and the difference to the one after.
    let tend = |a: &mut Sample, b: &Sample, c: &Sample| {
        a.uv.x = 2.0 * b.uv.x - c.uv.x;
        a.off = (chart.point(&a.uv) - a.at).norm();
    };
    if let ([a, b, c, ..], true) = (&mut samples[..], on_axis[0]) {
        tend(a, b, c);
    }
    if let ([.., c, b, a], true) = (&mut samples[..], on_axis[1]) {
        tend(a, b, c);
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
    let fitted = fitted(chart, &points, trace.samples, size, most, &mut left.held)
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
    at: Point3<f64>,
}

impl From<&Sample> for Knot {
    fn from(s: &Sample) -> Self {
        let Sample { t, uv, at, .. } = *s;
        Self { t, uv, at }
    }
}

/// A piece that is to be fitted: its ends, and the derivatives there.
#[derive(Clone, Copy)]
struct Piece {
    ends: [Knot; 2],
    tangents: [Vector2<f64>; 2],
    /// How many pieces it may become.
    most: usize,
}

/// What a fitted curve has become.
enum Fit {
    /// Its control points, and where its pieces end.
    Done(Vec<Point2<f64>>, Vec<f64>),
    /// It comes no nearer.
    Far,
    /// It takes more pieces than it may have.
    Many,
}

/// A fitted curve's pieces: what they are made of.
struct Fitter<'f> {
    chart: &'f Chart,
    points: &'f Points<'f>,
    degree: usize,
    /// How near a piece is to come.
    near: f64,
    size: f64,
}

impl Fitter<'_> {
    /// The control points of a piece: through both ends with their tangents, and of degree 5 through the edge's points at its thirds.
    fn control(&self, piece: &Piece) -> [Point2<f64>; QUINTIC + 1] {
        let ([a, b], [from, to]) = (piece.ends, piece.tangents);
        let step = (b.t - a.t) / CUBIC as f64;
        let p = [a.uv, a.uv + from * step, b.uv - to * step, b.uv];
        let mut all = [b.uv; QUINTIC + 1];
        if self.degree == CUBIC {
            all[..=CUBIC].copy_from_slice(&p);
            return all;
        }
        // What is left of each value beyond what the ends and their tangents make; of Bernstein polynomials at thirds, times 243.
        let step = (b.t - a.t) / QUINTIC as f64;
        let (q, r) = (a.uv.coords + from * step, b.uv.coords - to * step);
        let rest = [1.0, 2.0].map(|k| {
            let s = k / 3.0;
            let t = a.t + (b.t - a.t) * s;
            let uv = self.landed(piece, t, on(&p, s), s).uv.coords * 243.0;
            if k == 1.0 {
                uv - a.uv.coords * 32.0 - q * 80.0 - r * 10.0 - b.uv.coords
            } else {
                uv - a.uv.coords - q * 10.0 - r * 80.0 - b.uv.coords * 32.0
            }
        });
        let inner = [rest[0] * 2.0 - rest[1], rest[1] * 2.0 - rest[0]];
        let [second, third] = inner.map(|x| Point2::from(x / 120.0));
        [a.uv, q.into(), second, third, r.into(), b.uv]
    }

    /// The point of the surface nearest to the edge at `t`. The search starts from `near`, or from the chord at `s` where that is nearer: where an edge runs
    /// unevenly a piece may be far off.
    fn landed(&self, piece: &Piece, t: f64, near: Point2<f64>, s: f64) -> Located {
        let chart = self.chart;
        let q = self.points.at(t);
        if chart.is_elementary() {
            return chart.locate(&q, Some(&Located::at(near)));
        }
        let [a, b] = piece.ends;
        let near = chart.known(chart.clamped(near));
        let off = (near.point(chart) - q).norm();
        // So near to the edge, by its own length, that a search cannot go astray.
        let is_near = off <= FIT * self.size || off <= (b.at - a.at).norm() / 16.0;
        if !is_near {
            let chord = chart.known(chart.clamped(a.uv + (b.uv - a.uv) * s));
            if (chord.point(chart) - q).norm() < off {
                return chart.locate(&q, Some(&chord));
            }
        }
        chart.locate(&q, Some(&near))
    }

    /// How far a piece's image is at `s` from where the edge is on the surface. Steps of Newton's method that are short are the distance that they go,
    /// but for their squares.
    fn off(&self, piece: &Piece, control: &[Point2<f64>], s: f64) -> f64 {
        let [a, b] = piece.ends;
        let t = a.t + (b.t - a.t) * s;
        let uv = on(control, s);
        let own = self.chart.derivatives(&self.chart.clamped(uv));
        let step = foot_off(&own, &self.points.at(t));
        if let Some(off) = step.filter(|off| *off <= SHORT * self.size) {
            return off;
        }
        let there = self.landed(piece, t, uv, s).point(self.chart);
        (there.coords - own[0]).norm()
    }

    /// Where the edge is on the surface within a piece, at `s`, and the derivative: within a piece of the edge's own it is one on both sides.
    fn knot(&self, piece: &Piece, control: &[Point2<f64>], s: f64) -> (Knot, Option<Vector2<f64>>) {
        let [a, b] = piece.ends;
        let t = a.t + (b.t - a.t) * s;
        let found = self.landed(piece, t, on(control, s), s);
        let along = self.points.tangent(t, Limit::FromAbove);
        let d = found.derivatives(self.chart);
        let (uv, at) = (found.uv, self.points.at(t));
        let along = self.chart.carried(&uv, &d, &b.uv, &at, &along);
        (Knot { t, uv, at }, along)
    }

    /// A piece in `count` parts of one length, the last first; nothing where they would be too short.
    fn split(&self, piece: &Piece, control: &[Point2<f64>], count: usize) -> Vec<Piece> {
        let [a, b] = piece.ends;
        let most = piece.most / count;
        let mut parts = Vec::with_capacity(count);
        let mut end = (b, piece.tangents[1]);
        for k in (0..count).rev() {
            let (start, along) = match k {
                0 => (a, Some(piece.tangents[0])),
                k => self.knot(piece, control, k as f64 / count as f64),
            };
            if !(a.t <= start.t && start.t < end.0.t) {
                return Vec::new();
            }
            let [before, after] = [a, end.0]
                .map(|o| along.unwrap_or_else(|| step(self.chart, self.points, start, o)));
            parts.push(Piece {
                ends: [start, end.0],
                tangents: [after, end.1],
                most,
            });
            end = (start, before);
        }
        parts
    }

    /// `starts`: the ends of the edge's own pieces. `most`: how far off a piece may be that cannot be split, for as many as `most_pieces`; `None`: no such.
    fn fit(&self, starts: &[Knot], most_pieces: usize, most: Option<f64>) -> Fit {
        let own = starts.len().saturating_sub(1);
        let mut control = Vec::with_capacity(self.degree * own + 1);
        control.extend(starts.first().map(|k| k.uv));
        let mut written: Vec<f64> = Vec::with_capacity(own);
        let mut open: Vec<Piece> = Vec::new();
        for (k, ends) in starts.windows(2).enumerate() {
            let [a, b] = [ends[0], ends[1]];
            open.push(Piece {
                ends: [a, b],
                tangents: [
                    tangent(self.chart, self.points, a, b, Limit::FromAbove),
                    tangent(self.chart, self.points, b, a, Limit::FromBelow),
                ],
                most: 1 << HALVINGS,
            });
            while let Some(piece) = open.pop() {
                let p = self.control(&piece);
                let p = &p[..=self.degree];
                let (mut worst, mut good) = (0.0, true);
                for s in [0.5, 0.1875, 0.8125] {
                    if good {
                        worst = self.off(&piece, p, s);
                        good = worst <= self.near;
                    }
                }
                if !good {
                    // As many as bring it near, by how fast pieces of this degree do.
                    let orders = 1.0 / (self.degree + 1) as f64;
                    let wanted = libm::pow(worst / self.near, orders).ceil();
                    let waiting = own - k - 1 + open.len();
                    let room = most_pieces.saturating_sub(written.len() + waiting);
                    // What is no number is two.
                    let count = (wanted.min(MOST_PARTS) as usize).max(2);
                    let count = count.min(piece.most).min(room);
                    if count > 1 {
                        let parts = self.split(&piece, p, count);
                        if !parts.is_empty() {
                            open.extend(parts);
                            continue;
                        }
                    }
                    match most {
                        None => return Fit::Many,
                        Some(most) if worst <= most => {}
                        Some(_) => return Fit::Far,
                    }
                }
                grow(&mut control, self.degree);
                control.extend(p.iter().skip(1));
                grow(&mut written, 1);
                written.push(piece.ends[1].t);
            }
        }
        Fit::Done(control, written)
    }
}

/// The point of a Bezier curve, of a degree up to 5.
fn on(control: &[Point2<f64>], s: f64) -> Point2<f64> {
    let mut own = [Point2::origin(); QUINTIC + 1];
    for (own, p) in own.iter_mut().zip(control) {
        *own = *p;
    }
    for n in (1..control.len()).rev() {
        for i in 0..n {
            own[i] = own[i] + (own[i + 1] - own[i]) * s;
        }
    }
    own[0]
}

/// Where an edge crosses a line of u or v at which derivatives of a B-spline surface may jump, between two samples: its curve in uv bends there. Newton's
/// method, kept between the two; what it comes near to is a joint in any case.
fn crossing(
    chart: &Chart,
    points: &Points<'_>,
    [a, b]: [&Sample; 2],
    c: usize,
    knot: f64,
) -> Option<Knot> {
    let [mut lo, mut hi] = [a, b].map(|s| (s.t, s.uv[c] - knot));
    let same = (b.uv[c] - a.uv[c]).abs() * f64::EPSILON * 16.0;
    let mut near = Located::at(a.uv);
    let mut t = lo.0 + (hi.0 - lo.0) * (lo.1 / (lo.1 - hi.1));
    for _ in 0..CROSSING {
        let found = chart.locate(&points.at(t), Some(&near));
        let off = found.uv[c] - knot;
        if (off < 0.0) == (lo.1 < 0.0) {
            lo = (t, off);
        } else {
            hi = (t, off);
        }
        let along = points.tangent(t, Limit::FromAbove);
        let rate = pulled_back(&found.derivatives(chart), &along).map(|v| v[c]);
        near = found;
        let next = rate.map(|rate| t - off / rate);
        let next = next.filter(|next| lo.0 < *next && *next < hi.0);
        let next = next.unwrap_or(0.5 * (lo.0 + hi.0));
        if off.abs() <= same || !(lo.0 < next && next < hi.0) {
            break;
        }
        t = next;
    }
    let mut uv = near.uv;
    uv[c] = knot;
    let at = points.at(t);
    (a.t < t && t < b.t).then_some(Knot { t, uv, at })
}

/// All such places, but those that are as good as at one of `starts`, among which they are put.
fn joints(chart: &Chart, points: &Points<'_>, samples: &[Sample], starts: &mut Vec<Knot>) {
    let [Some(first), Some(last)] = [starts.first(), starts.last()].map(|k| k.copied()) else {
        return;
    };
    let clear = (last.t - first.t) * CLEAR;
    let mut found = Vec::new();
    for c in 0..2 {
        let knots = chart.inner_knots(c);
        for pair in samples.windows(2) {
            let [a, b] = [&pair[0], &pair[1]];
            let [lo, hi] = [a.uv[c].min(b.uv[c]), a.uv[c].max(b.uv[c])];
            let from = knots.partition_point(|k| *k <= lo);
            let own = knots.iter().skip(from).take_while(|k| **k < hi);
            for knot in own.take(MOST_CROSSED.saturating_sub(found.len())) {
                found.extend(crossing(chart, points, [a, b], c, *knot));
            }
        }
    }
    for knot in found {
        let at = starts.partition_point(|k| k.t < knot.t);
        let near = |k: Option<&Knot>| k.is_none_or(|k| (k.t - knot.t).abs() <= clear);
        if !near(starts.get(at)) && !near(starts.get(at.wrapping_sub(1))) {
            starts.insert(at, knot);
        }
    }
}

/// `None`: it comes no nearer than `most`. An error: `held` has no room for a piece for each of the edge's own.
fn fitted(
    chart: &Chart,
    points: &Points<'_>,
    samples: Vec<Sample>,
    size: f64,
    most: f64,
    held: &mut Budget,
) -> Result<Option<Curve2>, Refusal> {
    let [first, .., last] = samples[..] else {
        return Ok(None);
    };
    // Pieces at first: those of the edge's own curve.
    let inner = |s: &&Sample| first.t < s.t && s.t < last.t && points.is_break(s.t);
    let ends = samples.iter().filter(inner);
    let mut starts = Vec::with_capacity(ends.clone().count() + 2);
    starts.extend(
        [&first]
            .into_iter()
            .chain(ends)
            .chain([&last])
            .map(Knot::from),
    );
    let many = held.left() / (16 * PIECE * QUINTIC);
    if starts.len() + MOST_CROSSED < many {
        joints(chart, points, &samples, &mut starts);
    }
    // Of an edge with many pieces they take as much as what is made now.
    drop(samples);
    let own = starts.len() - 1;
    // Before the curve is made of them the points take two thirds of what they do in it, and an eighth more as their list grows.
    let room = |degree: usize| 7 * held.left() / (10 * PIECE * degree);
    let rooms = [room(CUBIC), room(QUINTIC)];
    held.take(own * CUBIC * PIECE)?;
    let fitter = |degree: usize, near: f64| Fitter {
        chart,
        points,
        degree,
        near,
        size,
    };
    let cubic = fitter(CUBIC, FIT * size);
    let most_pieces = |room: usize| own.max(room.min(own + MOST_PIECES));
    // Where few pieces are split cubics do; else quintics take far fewer. Some surfaces have no proof with them.
    let few = most_pieces(rooms[0]).min(2 * own);
    let is_composed = chart.degree().is_none_or(|d| d * QUINTIC <= MOST_COMPOSED);
    let (fit, degree) = if !is_composed || rooms[1] < own {
        let fit = cubic.fit(&starts, most_pieces(rooms[0]), Some(most));
        (fit, CUBIC)
    } else {
        match cubic.fit(&starts, few, None) {
            Fit::Many => {
                let quintic = fitter(QUINTIC, FIT / 4.0 * size);
                let fit = quintic.fit(&starts, most_pieces(rooms[1]), Some(most));
                (fit, QUINTIC)
            }
            fit => (fit, CUBIC),
        }
    };
    let Fit::Done(control, written) = fit else {
        return Ok(None);
    };
    let pieces = written.len();
    held.take((pieces * degree).saturating_sub(own * CUBIC) * PIECE)?;
    let control = control.into_iter().map(|q| q.coords.push(1.0)).collect();
    let mut knots = Vec::with_capacity(degree * (pieces + 1) + 2);
    knots.extend(std::iter::repeat_n(first.t, degree + 1));
    knots.extend(written.iter().flat_map(|t| std::iter::repeat_n(*t, degree)));
    knots.push(last.t);
    Ok(NurbsCurve::new(degree, control, knots)
        .ok()
        .map(Curve::Nurbs))
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
    // The surface's derivatives are those from above: towards smaller u or v they are those just below.
    let mut uv = at.uv;
    if chart.domain.is_some() {
        for c in 0..2 {
            if other.uv[c] < uv[c] {
                uv[c] = uv[c].next_down();
            }
        }
    }
    chart
        .carried(&uv, &chart.derivatives(&uv), &other.uv, &at.at, &along)
        .unwrap_or_else(|| step(chart, points, at, other))
}

/// The same where the surface has no tangent plane: a difference.
fn step(chart: &Chart, points: &Points<'_>, at: Knot, other: Knot) -> Vector2<f64> {
    let step = (other.t - at.t) / (1 << 12) as f64;
    let near = at.uv + (other.uv - at.uv) / f64::from(1 << 12);
    let next = chart.locate(&points.at(at.t + step), Some(&Located::at(near)));
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
