//! Native circular arcs in uv.
//!
//! An arc is cut where it crosses its centre's axes: those points are `center ± radius` in one
//! coordinate, exactly, whatever the arc's frame. Pieces between two of them are exact rational quadratics.
//! At the two ends of the arc the cosine and sine of an angle come in, known in enclosures only: there the
//! point's side of the circle itself is decided exactly, and whether it is before or beyond the end by
//! the enclosure.

use super::decide::Crossing;
use super::piece::Piece;
use super::source::{Ball3, End, Exact3, Run, Source, SourcePiece};
use super::spline::Param;
use super::split::Trend;
use crate::numeric::{Ball, Dd, Dyadic, sin_cos};
use crate::nurbs::Arc;
use std::cmp::Ordering;

/// Part of a native arc within one quadrant of its circle.
#[derive(Clone, Debug)]
pub(super) struct ArcSpan {
    center: [f64; 2],
    radius: f64,
    /// Quadrant k goes from direction k to k + 1 (quarter turns).
    quadrant: usize,
    /// Whether it runs counter-clockwise.
    ccw: bool,
    /// Its end directions.
    ends: [Direction; 2],
}

/// A unit vector: an axis, exactly, or in balls.
#[derive(Clone, Copy, Debug)]
enum Direction {
    Axis(usize),
    /// And whether it is proven to be at an angle other than 0.
    Free([Ball<Dd>; 2], bool),
}

/// Unit vector of `k` quarter turns.
fn axis(k: usize) -> [f64; 2] {
    match k % 4 {
        0 => [1.0, 0.0],
        1 => [0.0, 1.0],
        2 => [-1.0, 0.0],
        _ => [0.0, -1.0],
    }
}

/// An end of an arc at an angle that is a rational number other than 0: its coordinates are transcendental (Lindemann),
/// so never equal to a f64, and strictly within `center ± radius`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blur {
    /// The coordinates, if no exact ones.
    pub(super) at: [Ball<Dd>; 2],
    /// Exact strict bounds of each coordinate; `None` for an exact point (in `at`), and for one that is not known to be off all axes.
    limits: Option<[[Dd; 2]; 2]>,
}

impl Blur {
    /// A point whose coordinates are exact, or known no better than this.
    pub(super) fn plain(at: [Ball<Dd>; 2]) -> Self {
        Self { at, limits: None }
    }

    fn on_circle(center: [f64; 2], radius: f64, direction: [Ball<Dd>; 2], turned: bool) -> Self {
        let r = Ball::exact(radius);
        let limits = center.map(|c| [Dd::difference(c, radius), Dd::sum(c, radius)]);
        Self {
            at: [0, 1].map(|i| Ball::exact(center[i]) + r * direction[i]),
            limits: turned.then_some(limits),
        }
    }

    /// A coordinate against a number; `None` where that cannot be told.
    pub(super) fn compare(&self, i: usize, q: f64) -> Option<Ordering> {
        let q = Dd::from(q);
        if let Some(limits) = &self.limits {
            if q >= limits[i][1] {
                return Some(Ordering::Less);
            }
            if q <= limits[i][0] {
                return Some(Ordering::Greater);
            }
        }
        let d = self.at[i] - Ball::from_dd(q, 0.0);
        if d.lower() > 0.0 {
            Some(Ordering::Greater)
        } else if d.upper() < 0.0 {
            Some(Ordering::Less)
        } else if d.rad == 0.0 && self.limits.is_none() {
            Some(Ordering::Equal)
        } else {
            None
        }
    }
}

impl Direction {
    fn balls(&self) -> [Ball<Dd>; 2] {
        match self {
            Self::Axis(k) => axis(*k).map(Ball::exact),
            Self::Free(d, _) => *d,
        }
    }
}

impl ArcSpan {
    /// Its circle's centre and radius.
    pub(super) fn circle(&self) -> ([f64; 2], f64) {
        (self.center, self.radius)
    }

    /// Its end points, where they are on axes.
    pub(super) fn exact_ends(&self) -> [Option<Exact3>; 2] {
        self.ends.map(|d| match d {
            Direction::Axis(k) => extreme(self.center, self.radius, k)?.exact(),
            Direction::Free(..) => None,
        })
    }

    pub(super) fn reverse(&mut self) {
        self.ccw = !self.ccw;
        self.ends.reverse();
    }

    /// Whether all of the circle is at or below a coordinate (`Less`) or at or above it, exactly.
    fn about(&self, coordinate: usize, q: f64) -> Option<Ordering> {
        let (c, q) = (self.center[coordinate], Dd::from(q));
        if q >= Dd::sum(c, self.radius) {
            Some(Ordering::Less)
        } else if q <= Dd::difference(c, self.radius) {
            Some(Ordering::Greater)
        } else {
            None
        }
    }

    /// Proven: nowhere on the arc is this coordinate equal to `q`.
    pub(super) fn is_beside(&self, coordinate: usize, q: f64) -> bool {
        // Arcs are monotone but for what is past an end that may be on an axis. With `s` the sine to that axis and `rho` what the angle may be off,
        // the circle's extreme is r s^2 / 2 farther at most, and s <= 2 (rho + 2^-98): less than r (rho + 2^-117), which the end's enclosure holds
        // to either side (`sin_cos`) as rho is far below 1/2. So what is not in that enclosure is not on the arc past the end, either.
        let ends = [0, 1].map(|e| compare_end(self, e, coordinate, q));
        let same = ends == [Some(Ordering::Less); 2] || ends == [Some(Ordering::Greater); 2];
        let (c, at) = (self.center[coordinate], Dd::from(q));
        same || at > Dd::sum(c, self.radius) || at < Dd::difference(c, self.radius)
    }

    /// How u and v run. At a free end whose direction is within its enclosure of an axis the arc may
    /// in truth start just before that axis; the part that runs the other way lies in the enclosure of the
    /// end, where nothing is decided.
    pub(super) fn trends(&self) -> [Trend; 2] {
        let ccw = match self.quadrant % 4 {
            0 => [Trend::Down, Trend::Up],
            1 => [Trend::Down, Trend::Down],
            2 => [Trend::Up, Trend::Down],
            _ => [Trend::Up, Trend::Up],
        };
        if self.ccw {
            return ccw;
        }
        ccw.map(|t| {
            if t == Trend::Up {
                Trend::Down
            } else {
                Trend::Up
            }
        })
    }

    /// Homogeneous control points. With end directions d, e and `C = d.e`: the tangents meet at
    /// `center + radius (d + e) / (1 + C)`, and weights `(1, (1 + C) / 2, (1 + C) / 2)` have
    /// `w_1² / (w_0 w_2) = (1 + C) / 2`, the squared cosine of half the angle, as a circle needs (The
    /// NURBS Book, 7.3).
    pub(super) fn balls(&self) -> Vec<Ball3> {
        let (d, e) = (self.ends[0].balls(), self.ends[1].balls());
        let (c, r) = (self.center.map(Ball::exact), Ball::exact(self.radius));
        let w = (Ball::ONE + (d[0] * e[0] + d[1] * e[1])).half();
        let at = |d: [Ball<Dd>; 2], w: Ball<Dd>| [(c[0] + r * d[0]) * w, (c[1] + r * d[1]) * w, w];
        let middle = [0, 1].map(|i| c[i] * w + r * (d[i] + e[i]).half());
        vec![at(d, Ball::ONE), [middle[0], middle[1], w], at(e, w)]
    }
}

/// `center + radius direction` for an axis: exact.
fn extreme(center: [f64; 2], radius: f64, k: usize) -> Option<End> {
    let a = axis(k);
    let sums = [0, 1].map(|i| Dd::sum(center[i], radius * a[i]));
    if sums.iter().all(|s| s.lo == 0.0) {
        return Some(End::Point(sums.map(|s| s.hi)));
    }
    // An f64 pair is a dyadic: integers over a common power of two.
    let parts = super::source::dyadics_to_integers(&[
        &Dyadic::from_f64(sums[0].hi)? + &Dyadic::from_f64(sums[0].lo)?,
        &Dyadic::from_f64(sums[1].hi)? + &Dyadic::from_f64(sums[1].lo)?,
        Dyadic::from_f64(1.0)?,
    ]);
    let [u, v, w] = <[dashu_int::IBig; 3]>::try_from(parts).ok()?;
    Some(End::Rational([u, v, w]))
}

/// A whole quadrant, exactly: weights 2, 1, 1.
fn quadrant(center: [f64; 2], radius: f64, from: usize, to: usize) -> Option<Source> {
    let (d, e) = (axis(from), axis(to));
    let mut numbers = Vec::with_capacity(9);
    let two = Dyadic::from_f64(2.0)?;
    for (direction, weight) in [(d, 2.0), ([d[0] + e[0], d[1] + e[1]], 1.0), (e, 1.0)] {
        for i in 0..2 {
            // The middle point is radius (d + e) from the centre, as C = 0.
            let offset = &Dyadic::from_f64(radius)? * &Dyadic::from_f64(direction[i])?;
            let x = &Dyadic::from_f64(center[i])? + &offset;
            numbers.push(if weight == 2.0 { &x * &two } else { x });
        }
        numbers.push(Dyadic::from_f64(weight)?);
    }
    let integers = super::source::dyadics_to_integers(&numbers);
    Some(Source::Exact(
        integers
            .chunks_exact(3)
            .map(|c| [c[0].clone(), c[1].clone(), c[2].clone()])
            .collect(),
    ))
}

/// The direction at a parameter of the arc.
fn direction(arc: &Arc<2>, ccw: bool, at: &Param) -> Direction {
    let (domain, angle) = (arc.domain, arc.angle);
    let a = if at.is(domain.start) {
        Ball::exact(angle.start)
    } else if at.is(domain.end) {
        Ball::exact(angle.end)
    } else if domain == angle {
        -at.below(0.0)
    } else {
        let s = -at.below(domain.start) / Ball::difference(domain.end, domain.start);
        Ball::exact(angle.start) + s * Ball::difference(angle.end, angle.start)
    };
    // The frame's x direction as quarter turns, where it is an axis.
    let turns = match (arc.x[0], arc.x[1]) {
        (x, 0.0) => Some(if x > 0.0 { 0 } else { 2 }),
        (0.0, y) => Some(if y > 0.0 { 1 } else { 3 }),
        _ => None,
    };
    if let (Some(k), true) = (turns, a.rad == 0.0 && a.mid == Dd::ZERO) {
        return Direction::Axis(k);
    }
    let (sin, cos) = sin_cos(a);
    let sin = if ccw { sin } else { -sin };
    // (From a direction that is no axis no rational angle leads to one.)
    let turned = turns.is_none() || a.mid.hi.abs() > 2.0 * a.rad;
    let direction = match turns {
        Some(0) => [cos, sin],
        Some(1) => [-sin, cos],
        Some(2) => [-cos, -sin],
        Some(_) => [sin, -cos],
        None => {
            let (x, y) = (Ball::exact(arc.x[0]), Ball::exact(arc.x[1]));
            // Scaled first: squares may overflow otherwise.
            let size = arc.x[0].abs().max(arc.x[1].abs());
            let (x, y) = (x / Ball::exact(size), y / Ball::exact(size));
            let norm = (x * x + y * y).sqrt();
            let (x, y) = (x / norm, y / norm);
            [x * cos - y * sin, y * cos + x * sin]
        }
    };
    Direction::Free(direction, turned)
}

/// The quadrant that starts at or before a direction, counter-clockwise: on an axis (as far as can
/// be told) the one that starts there.
fn quadrant_of(d: &Direction) -> usize {
    match d {
        Direction::Axis(k) => k % 4,
        Direction::Free([x, y], _) => {
            let sign = |b: &Ball<Dd>| {
                if b.lower() > 0.0 {
                    1
                } else if b.upper() < 0.0 {
                    -1
                } else {
                    0
                }
            };
            match (sign(x), sign(y)) {
                (1, 0 | 1) => 0,
                (0 | -1, 1) => 1,
                (-1, _) => 2,
                _ => 3,
            }
        }
    }
}

/// The run of an arc between two of its parameters.
pub(super) fn arc_run(arc: &Arc<2>, from: &Param, to: &Param) -> Option<Run> {
    // The frame's y decides the sense of rotation.
    let cross = Dd::product(arc.x[0], arc.y[1]) - Dd::product(arc.x[1], arc.y[0]);
    let ccw = cross.hi >= 0.0;
    let center = [arc.center.x, arc.center.y];
    // Walk counter-clockwise; turn around at the end.
    let (a, b) = if ccw { (from, to) } else { (to, from) };
    let ends = [direction(arc, ccw, a), direction(arc, ccw, b)];
    let first = quadrant_of(&ends[0]);
    // How many axes are passed: the sweep in quarter turns says so up to one, the quadrants modulo 4.
    let rate = arc.angle.length() / arc.domain.length();
    let sweep =
        ((to.near - from.near) * rate).min(arc.angle.length()) / std::f64::consts::FRAC_PI_2;
    let last = quadrant_of(&ends[1]);
    let between = (last + 4 - first) % 4;
    // A sweep of s quarters passes between s - 1 and s + 1 axes; more than once around is passed over
    // as often as it says.
    const MOST_ROUNDS: f64 = 1000.0;
    let rounds = ((sweep - between as f64) / 4.0).round();
    let mut passed = between + 4 * rounds.clamp(0.0, MOST_ROUNDS) as usize;
    // An end on an axis belongs to the quadrant before it.
    let end_on_axis = match &ends[1] {
        Direction::Axis(_) => true,
        Direction::Free(d, _) => (0..2).any(|i| d[i].lower() <= 0.0 && d[i].upper() >= 0.0),
    };
    if end_on_axis && passed > 0 {
        passed -= 1;
    }
    let point = |d: &Direction| match d {
        Direction::Axis(k) => extreme(center, arc.radius, *k),
        Direction::Free(d, turned) => {
            let end = Blur::on_circle(center, arc.radius, *d, *turned);
            Some(End::Blurred(end))
        }
    };
    let mut pieces = Vec::with_capacity(passed + 1);
    for n in 0..=passed {
        let k = (first + n) % 4;
        let start = if n == 0 { ends[0] } else { Direction::Axis(k) };
        let end = if n == passed {
            ends[1]
        } else {
            Direction::Axis((k + 1) % 4)
        };
        let source = match (start, end) {
            (Direction::Axis(i), Direction::Axis(j)) => quadrant(center, arc.radius, i, j)?,
            _ => Source::Arc(Box::new(ArcSpan {
                center,
                radius: arc.radius,
                quadrant: k,
                ccw: true,
                ends: [start, end],
            })),
        };
        // Parameters for orientation only: evenly spread.
        let at = |n: usize| {
            let s = n as f64 / (passed + 1) as f64;
            a.near + s * (b.near - a.near)
        };
        pieces.push(SourcePiece {
            source,
            params: [at(n), at(n + 1)],
        });
    }
    let mut run = Run {
        pieces,
        start: point(&ends[0])?,
        end: point(&ends[1])?,
    };
    if !ccw {
        super::source::reverse(&mut run);
    }
    Some(run)
}

/// A coordinate of an end of an arc, against a number; `None` also where the arc may run on past it: a free end that is on an axis as far as
/// can be told may be just before it, and the circle's extreme on the arc.
fn compare_end(span: &ArcSpan, end: usize, coordinate: usize, q: f64) -> Option<Ordering> {
    match &span.ends[end] {
        Direction::Axis(k) => {
            let e = Dd::sum(span.center[coordinate], span.radius * axis(*k)[coordinate]);
            // Exact: a double-double against a f64.
            e.partial_cmp(&Dd::from(q))
        }
        Direction::Free(d, turned) => {
            let clear = d.iter().all(|x| x.lower() > 0.0 || x.upper() < 0.0);
            Blur::on_circle(span.center, span.radius, *d, *turned && clear).compare(coordinate, q)
        }
    }
}

/// The last stage for parts that have no integers: pieces of arcs, and segments to their ends.
pub(super) fn crossing(piece: &Piece, q: [f64; 2], ray: usize) -> Crossing {
    match &piece.source {
        Source::Arc(span) => arc_crossing(span, q, ray).unwrap_or(Crossing::Unknown),
        Source::Blurred(ends) => blurred_crossing(ends, q, ray),
        _ => Crossing::Unknown,
    }
}

/// The segment between two ends of which one at least is known in an enclosure only.
fn blurred_crossing(ends: &[Blur; 2], q: [f64; 2], ray: usize) -> Crossing {
    let h = 1 - ray;
    let order = [0, 1].map(|i| [0, 1].map(|e: usize| ends[e].compare(i, q[i])));
    let all = |i: usize, o: Ordering| order[i] == [Some(o); 2];
    if all(h, Ordering::Less) || all(h, Ordering::Greater) || all(ray, Ordering::Less) {
        return Crossing::Even;
    }
    if (0..2).any(|e| order[0][e] == Some(Ordering::Equal) && order[1][e] == Some(Ordering::Equal))
    {
        return Crossing::On;
    }
    let [Some(a), Some(b)] = order[h] else {
        return Crossing::Unknown;
    };
    // Not both equal: a transcendental coordinate is never equal to q.
    let (a, b) = (a == Ordering::Greater, b == Ordering::Greater);
    if a == b {
        return Crossing::Even;
    }
    // An end at the very height of the ray, the other above it: the crossing is at that end.
    if let Some(e) = (0..2).find(|e| order[h][*e] == Some(Ordering::Equal)) {
        return match order[ray][e] {
            Some(o) => Crossing::odd(o == Ordering::Greater),
            None => Crossing::Unknown,
        };
    }
    let within = |o: Ordering| {
        order[ray]
            .iter()
            .all(|x| *x == Some(o) || *x == Some(Ordering::Equal))
    };
    if within(Ordering::Less) {
        return Crossing::Even;
    }
    if within(Ordering::Greater) {
        return Crossing::Odd;
    }
    // The sign of the triangle of the two ends and the point; upward, the segment passes beyond the
    // point iff the point is on its left.
    let d = ends.map(|e| [e.at[ray] - Ball::exact(q[ray]), e.at[h] - Ball::exact(q[h])]);
    let cross = d[0][0] * d[1][1] - d[1][0] * d[0][1];
    if cross.lower() > 0.0 {
        Crossing::odd(b)
    } else if cross.upper() < 0.0 {
        Crossing::odd(!b)
    } else {
        Crossing::Unknown
    }
}

/// The circle decides: a point of the arc at height `q_h` is `center ± sqrt(..)`, the sign by quadrant.
fn arc_crossing(span: &ArcSpan, q: [f64; 2], ray: usize) -> Option<Crossing> {
    let h = 1 - ray;
    // Elsewhere than at an extreme of the circle no point of the arc matters that is on a line that touches the circle there.
    let about = [0, 1].map(|i| span.about(i, q[i]));
    let at_extreme = (0..2).any(|i| about[i].is_some() && q[1 - i] == span.center[1 - i]);
    let compare = |e: usize, i: usize| match compare_end(span, e, i, q[i]) {
        None if !at_extreme => about[i],
        order => order,
    };
    let ends = [0, 1].map(|e| [0, 1].map(|i| compare(e, i)));
    for e in ends {
        if e == [Some(Ordering::Equal); 2] {
            return Some(Crossing::On);
        }
    }
    let state = |e: usize| ends[e][h].map(|o| o == Ordering::Greater);
    let (a, b) = (state(0), state(1));
    if a.is_none() || b.is_none() {
        // The height is that of a free end, as far as can be told. Left of all of the arc that cannot be
        // ignored; right of it, it can.
        let beyond = ends.iter().all(|e| e[ray] == Some(Ordering::Less));
        return Some(if beyond {
            Crossing::Even
        } else {
            Crossing::Unknown
        });
    }
    if a == b {
        return Some(Crossing::Even);
    }
    let square = |i: usize| {
        let d = &Dyadic::from_f64(q[i])? - &Dyadic::from_f64(span.center[i])?;
        Some(&d * &d)
    };
    let r = Dyadic::from_f64(span.radius)?;
    let out = (&(&square(0)? + &square(1)?) - &(&r * &r)).signum();
    // Directions k and k + 1 bound the quadrant: their sum has its signs.
    let (d, e) = (axis(span.quadrant), axis(span.quadrant + 1));
    let positive = d[ray] + e[ray] > 0.0;
    let before = q[ray].partial_cmp(&span.center[ray])?;
    Some(if positive {
        match (before, out) {
            (Ordering::Less, _) | (_, -1) => Crossing::Odd,
            (_, 0) => Crossing::On,
            _ => Crossing::Even,
        }
    } else {
        match (before, out) {
            (Ordering::Greater, _) | (_, -1) => Crossing::Even,
            (_, 0) => Crossing::On,
            _ => Crossing::Odd,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Interval;
    use nalgebra::{Point2, Vector2};

    /// Half of the way from -1 to 1 is 0, found with an error: there the circle's extreme is met.
    #[test]
    fn an_end_that_may_be_on_an_axis_may_be_at_the_extreme() {
        let arc = Arc::new(Arc {
            center: Point2::origin(),
            x: Vector2::x(),
            y: Vector2::y(),
            z: Vector2::zeros(),
            radius: 1.0,
            angle: Interval::new(-1.0, 1.0).unwrap(),
            domain: Interval::new(0.0, 2.0).unwrap(),
        });
        let arc = arc.unwrap();
        for (at, less) in [(1.0, None), (1.5, Some(Ordering::Less))] {
            let Direction::Free(d, turned) = direction(&arc, true, &Param::f64(at)) else {
                panic!("{at} is found exactly");
            };
            let end = Blur::on_circle([0.0; 2], 1.0, d, turned);
            assert_eq!(end.compare(0, 1.0), less, "{at}");
        }
    }

    /// Quarters of the circle of radius 5 about the origin, next to (3, 4) and its turns: on either ray the arc is beyond what is
    /// inside where that is up the axis, and beyond what is outside where it is down.
    #[test]
    fn quarters() {
        for k in 0..4 {
            let span = ArcSpan {
                center: [0.0, 0.0],
                radius: 5.0,
                quadrant: k,
                ccw: true,
                ends: [Direction::Axis(k), Direction::Axis((k + 1) % 4)],
            };
            let turned = |x: f64, y: f64| {
                let (d, e) = (axis(k), axis(k + 1));
                [d[0] * x + e[0] * y, d[1] * x + e[1] * y]
            };
            for ray in 0..2 {
                let at = |x: f64, y: f64| arc_crossing(&span, turned(x, y), ray);
                let up = turned(3.0, 4.0)[ray] > 0.0;
                assert_eq!(at(3.0, 4.0), Some(Crossing::On));
                let (below, above) = (4f64.next_down(), 4f64.next_up());
                assert_eq!(at(3.0, below), Some(Crossing::odd(up)), "{k} {ray}");
                assert_eq!(at(3.0, above), Some(Crossing::odd(!up)), "{k} {ray}");
                assert_eq!(at(6.0, 6.0), Some(Crossing::Even));
            }
        }
    }

    /// A segment from the origin to (4, 2), whichever end is first: what is left of it has it on the ray along u, what is below on the ray along v.
    #[test]
    fn segments_between_blurred_ends() {
        let end = |x: f64, y: f64| Blur::plain([Ball::exact(x), Ball::exact(y)]);
        let ends = [end(0.0, 0.0), end(4.0, 2.0)];
        for ends in [ends, [ends[1], ends[0]]] {
            for (q, along_u, along_v) in [
                ([1.0, 1.0], Crossing::Odd, Crossing::Even),
                ([3.0, 1.0], Crossing::Even, Crossing::Odd),
                ([2.0_f64.next_down(), 1.0], Crossing::Odd, Crossing::Even),
                ([2.0_f64.next_up(), 1.0], Crossing::Even, Crossing::Odd),
                // On it, which enclosures do not tell but at its ends.
                ([2.0, 1.0], Crossing::Unknown, Crossing::Unknown),
                ([0.0, 0.0], Crossing::On, Crossing::On),
                ([4.0, 2.0], Crossing::On, Crossing::On),
                // Beside its box.
                ([-1.0, 1.0], Crossing::Odd, Crossing::Even),
                ([5.0, 1.0], Crossing::Even, Crossing::Even),
                ([1.0, 3.0], Crossing::Even, Crossing::Even),
                ([1.0, -1.0], Crossing::Even, Crossing::Odd),
                // At the height of an end: the crossing of [h > q_h] is at the lower one.
                ([-1.0, 0.0], Crossing::Odd, Crossing::Even),
                ([1.0, 0.0], Crossing::Even, Crossing::Odd),
                ([-1.0, 2.0], Crossing::Even, Crossing::Even),
                ([0.0, -1.0], Crossing::Even, Crossing::Odd),
                ([4.0, -1.0], Crossing::Even, Crossing::Even),
            ] {
                let found = [0, 1].map(|ray| blurred_crossing(&ends, q, ray));
                assert_eq!(found, [along_u, along_v], "{q:?}");
            }
        }
    }

    /// The first quarter of a circle from 1 to 3 in u: whose box begins at the centre, and whose extremes are exactly there.
    #[test]
    fn beside_a_circle_and_a_quarter() {
        let span = ArcSpan {
            center: [2.0, 0.0],
            radius: 1.0,
            quadrant: 0,
            ccw: true,
            ends: [Direction::Axis(0), Direction::Axis(1)],
        };
        let about = [1.0, 1f64.next_up(), 3f64.next_down(), 3.0].map(|q| span.about(0, q));
        let (less, greater) = (Some(Ordering::Less), Some(Ordering::Greater));
        assert_eq!(about, [greater, None, None, less]);
        let beside = [1.5, 2f64.next_down(), 2.0, 2.5, 3.0, 3f64.next_up()];
        let beside = beside.map(|q| span.is_beside(0, q));
        assert_eq!(beside, [true, true, false, false, false, true]);
    }
}
