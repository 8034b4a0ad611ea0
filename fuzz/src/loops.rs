//! Trim loops, drawn in the square `[-HALF, HALF]^2` or a little beyond.

use crate::source::{HALF, Source};
use feeler::numeric::Interval;
use feeler::nurbs::{Arc, Curve, Curve2, Line, NurbsCurve, Polyline};
use nalgebra::{Point2, Vector2, Vector3};

/// A use of a curve: over a part of it or the whole, in its direction or against it.
#[derive(Clone, Debug)]
pub(crate) struct Use {
    pub(crate) curve: Curve2,
    pub(crate) span: Interval,
    pub(crate) reversed: bool,
}

/// Loops, and places that queries aim at.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loops {
    pub(crate) loops: Vec<Vec<Use>>,
    /// Corners and control points.
    pub(crate) marks: Vec<[f64; 2]>,
}

impl Use {
    fn of(curve: Curve2, reversed: bool) -> Self {
        Self {
            span: curve.domain(),
            curve,
            reversed,
        }
    }

    /// A point of it, about.
    pub(crate) fn at(&self, s: f64) -> [f64; 2] {
        self.curve.point(self.span.lerp(s)).coords.into()
    }

    pub(crate) fn start(&self) -> [f64; 2] {
        self.at(if self.reversed { 1.0 } else { 0.0 })
    }

    fn end(&self) -> [f64; 2] {
        self.at(if self.reversed { 0.0 } else { 1.0 })
    }
}

pub(crate) fn interval(a: f64, b: f64) -> Interval {
    Interval { start: a, end: b }
}

/// A straight curve, if its ends are numbers.
pub(crate) fn segment(a: [f64; 2], b: [f64; 2]) -> Option<Curve2> {
    let line = Line::new(Point2::from(a), Point2::from(b), interval(0.0, 1.0));
    line.ok().map(Curve::Line)
}

/// A point between, on the grid of quarters.
fn between(a: [f64; 2], b: [f64; 2], s: f64) -> [f64; 2] {
    [0, 1].map(|i| a[i] + (b[i] - a[i]) * s)
}

impl Loops {
    /// One to four loops.
    pub(crate) fn draw(s: &mut Source<'_>) -> Self {
        let mut all = Self::default();
        let count = 1 + [0, 0, 0, 1, 1, 2, 3][s.below(7)];
        for _ in 0..count {
            let found = match s.below(12) {
                0..=4 => all.chain(s),
                5 => Some(rational_circle(s)),
                6 => native_circle(s),
                7 => all.copy(s),
                8 => all.neighbour(s),
                9 => all.sliver(s),
                _ => all.polygon(s),
            };
            let Some(uses) = found.filter(|u| !u.is_empty()) else {
                continue;
            };
            all.marks.extend(uses.iter().map(Use::start));
            all.loops.push(uses);
        }
        all
    }

    /// Corners joined by curves of any kind.
    fn chain(&mut self, s: &mut Source<'_>) -> Option<Vec<Use>> {
        let corners: Vec<[f64; 2]> = (0..1 + s.below(5)).map(|_| s.pair()).collect();
        let mut uses = Vec::new();
        for (i, &a) in corners.iter().enumerate() {
            let mut b = corners[(i + 1) % corners.len()];
            if s.rarely(12) {
                // A gap.
                b = [s.nudged(b[0]), s.nudged(b[1])];
            }
            let reversed = s.rarely(48);
            let [from, to] = if reversed { [b, a] } else { [a, b] };
            let made = Use::of(self.curve(s, from, to)?, reversed);
            match s.byte() {
                // There and back, and there again.
                248..=251 => {
                    let mut back = made.clone();
                    back.reversed = !back.reversed;
                    uses.extend([made.clone(), back, made]);
                }
                // In two parts.
                252..=255 => uses.extend(halves(made, s.fraction())),
                _ => uses.push(made),
            }
        }
        Some(uses)
    }

    fn polygon(&mut self, s: &mut Source<'_>) -> Option<Vec<Use>> {
        let corners: Vec<[f64; 2]> = if s.rarely(96) {
            let ([a, b], [c, d]) = (s.pair(), s.pair());
            vec![[a, b], [c, b], [c, d], [a, d]]
        } else {
            (0..3 + s.below(6)).map(|_| s.pair()).collect()
        };
        closed(&corners)
    }

    /// Two straight sides a few steps of f64 apart.
    fn sliver(&mut self, s: &mut Source<'_>) -> Option<Vec<Use>> {
        let (a, b) = (s.pair(), s.pair());
        let mut near = |p: [f64; 2]| [s.nudged(p[0]), s.nudged(p[1])];
        let (c, d) = (near(b), near(a));
        closed(&[a, b, c, d])
    }

    /// An earlier loop again: the same, moved by steps of f64, or run the other way.
    fn copy(&mut self, s: &mut Source<'_>) -> Option<Vec<Use>> {
        let mut uses = self.earlier(s)?.clone();
        if s.rarely(128) {
            uses.reverse();
            for u in &mut uses {
                u.reversed = !u.reversed;
            }
        }
        if s.rarely(128) {
            for u in &mut uses {
                let (a, b) = (u.start(), u.end());
                let near = |s: &mut Source<'_>, p: [f64; 2]| [s.nudged(p[0]), s.nudged(p[1])];
                let (a, b) = (near(s, a), near(s, b));
                *u = Use::of(segment(a, b)?, false);
            }
        }
        Some(uses)
    }

    /// A loop that runs along a curve of an earlier one, and back on another way.
    fn neighbour(&mut self, s: &mut Source<'_>) -> Option<Vec<Use>> {
        let old = self.earlier(s)?;
        let shared = old[s.below(old.len().min(256))].clone();
        let (a, b) = (shared.start(), shared.end());
        let back = self.curve(s, b, a)?;
        Some(vec![shared, Use::of(back, false)])
    }

    fn earlier(&self, s: &mut Source<'_>) -> Option<&Vec<Use>> {
        let count = self.loops.len();
        (count > 0).then(|| &self.loops[s.below(count)])
    }

    /// A curve from one point to another.
    fn curve(&mut self, s: &mut Source<'_>, a: [f64; 2], b: [f64; 2]) -> Option<Curve2> {
        match s.below(8) {
            0 => segment(a, b),
            1 => {
                let mut points = vec![Point2::from(a)];
                points.extend((0..1 + s.below(4)).map(|_| Point2::from(s.pair())));
                points.push(Point2::from(b));
                let params = (0..points.len()).map(|i| i as f64).collect();
                Polyline::new(points, params).ok().map(Curve::Polyline)
            }
            _ => self.spline(s, a, b),
        }
    }

    fn spline(&mut self, s: &mut Source<'_>, a: [f64; 2], b: [f64; 2]) -> Option<Curve2> {
        let degree = s.degree(25);
        let domain = match s.byte() {
            0..=199 => [0.0, 1.0],
            200..=249 => [-3.0, 5.0],
            250..=252 => [1e9, 1e9 + 1.0],
            _ => [1.0, 1.0 + 64.0 * f64::EPSILON],
        };
        let (knots, count) = s.knots(degree, domain);
        let rational = s.rarely(96);
        let mut net: Vec<Vector3<f64>> = Vec::with_capacity(count);
        let mut last = a;
        for i in 0..count {
            let (p, w) = if i == 0 || i + 1 == count {
                let w = if rational { s.exact_weight() } else { 1.0 };
                (if i == 0 { a } else { b }, w)
            } else {
                let p = match s.byte() {
                    0..=159 => s.pair(),
                    // Cusps and ends without a tangent.
                    160..=191 => last,
                    192..=207 => a,
                    // Straight, tangent to the chord, or back on it.
                    208..=239 => between(a, b, f64::from(s.byte() % 9) / 4.0 - 0.5),
                    // Level with an end.
                    240..=247 => [s.coordinate(), a[1]],
                    _ => [b[0], s.coordinate()],
                };
                (p, if rational { s.weight() } else { 1.0 })
            };
            last = p;
            self.marks.push(p);
            net.push(Vector3::new(p[0] * w, p[1] * w, w));
        }
        NurbsCurve::new(degree, net, knots).ok().map(Curve::Nurbs)
    }
}

fn closed(corners: &[[f64; 2]]) -> Option<Vec<Use>> {
    (0..corners.len())
        .map(|i| {
            let next = corners[(i + 1) % corners.len()];
            Some(Use::of(segment(corners[i], next)?, false))
        })
        .collect()
}

/// The two parts of a use, where there are two.
fn halves(whole: Use, at: f64) -> Vec<Use> {
    let middle = whole.span.lerp(at);
    let (start, end) = (whole.span.start, whole.span.end);
    if !(start < middle && middle < end) {
        return vec![whole];
    }
    let mut parts = [interval(start, middle), interval(middle, end)].map(|span| Use {
        span,
        ..whole.clone()
    });
    if whole.reversed {
        parts.reverse();
    }
    parts.into()
}

/// A circle exactly: quarters x = (1 - t^2) / (1 + t^2), y = 2t / (1 + t^2), whose control points are integers.
fn rational_circle(s: &mut Source<'_>) -> Vec<Use> {
    let center = s.pair();
    let radius = f64::from(1 + s.byte() % 64) / 16.0;
    let turned = |k: usize, [x, y]: [f64; 2]| match k {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    };
    let quarter = |k: usize| {
        let net = [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 2.0]].map(|p| {
            let q = turned(k, [p[0], p[1]]);
            let [x, y] = [0, 1].map(|i| radius * q[i] + center[i] * p[2]);
            Vector3::new(x, y, p[2])
        });
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        NurbsCurve::new(2, net.into(), knots).ok()
    };
    let curves = (0..4).filter_map(quarter);
    curves.map(|c| Use::of(Curve::Nurbs(c), false)).collect()
}

/// One arc, or two.
fn native_circle(s: &mut Source<'_>) -> Option<Vec<Use>> {
    use std::f64::consts::{PI, TAU};
    let center = Point2::from(s.pair());
    let radius = f64::from(1 + s.byte() % 64) / 16.0;
    let start = s.one_of(&[0.0, 0.0, 0.0, PI / 2.0, 1.0, -2.5]);
    let arc = |from: f64, to: f64| {
        Arc::new(Arc {
            center,
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
            radius,
            angle: interval(from, to),
            domain: interval(from, to),
        })
        .ok()
        .map(|a| Use::of(Curve::Arc(a), false))
    };
    if s.rarely(128) {
        Some(vec![arc(start, start + PI)?, arc(start + PI, start + TAU)?])
    } else {
        Some(vec![arc(start, start + TAU)?])
    }
}

/// A point to ask about: on a curve and up to 4 steps of f64 off in each coordinate, level with corners, on the border
/// of the domain, or anywhere.
pub(crate) fn aimed(
    s: &mut Source<'_>,
    loops: &[Vec<Use>],
    marks: &[[f64; 2]],
    domain: [Interval; 2],
) -> [f64; 2] {
    let mark = |s: &mut Source<'_>| match marks.len() {
        0 => s.pair(),
        n => marks[s.below(n.min(256))],
    };
    let on_curve = |s: &mut Source<'_>| {
        let uses = &loops[s.below(loops.len().max(1)).min(loops.len().checked_sub(1)?)];
        let used = uses.get(s.below(uses.len().clamp(1, 256)))?;
        Some(used.at(s.fraction()))
    };
    let kind = s.byte();
    let found = match kind {
        0..=111 => on_curve(s).unwrap_or([0.0; 2]),
        112..=159 => [mark(s)[0], mark(s)[1]],
        160..=191 => {
            let [x, _] = on_curve(s).unwrap_or([0.0; 2]);
            [x, mark(s)[1]]
        }
        192..=223 => s.pair(),
        _ => [0, 1].map(|i| domain[i].lerp(s.fraction())),
    };
    if kind % 4 == 3 {
        return found;
    }
    [s.nudged(found[0]), s.nudged(found[1])]
}

/// The square in which loops are drawn, or another.
pub(crate) fn domain(s: &mut Source<'_>) -> [Interval; 2] {
    match s.byte() {
        0..=159 => [interval(-4.0 * HALF, 4.0 * HALF); 2],
        160..=207 => [interval(-HALF, HALF); 2],
        _ => [0, 1].map(|_| {
            let (a, b) = (s.coordinate(), s.coordinate());
            if a < b {
                interval(a, b)
            } else {
                interval(-HALF, HALF)
            }
        }),
    }
}
