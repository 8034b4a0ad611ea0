//! Whether two parts of loops meet, by proof.
//!
//! # Method
//! Over a range of its parameter a rational Bezier curve with weights > 0 lies in the convex hull of its control points
//! there (blossoms, in balls), and its derivative is a combination with coefficients >= 0 of the steps of its control
//! polygon (see `prepare::matching`). From that, for parts `A` and `B`:
//!
//! 1. *Apart*: their control points are strictly on different sides of a line, of those along u, along v and
//!    along either chord.
//! 2. *Crossing*: let `S_A` be the strip along `A`'s chord that holds `A`'s control points, likewise `S_B`. Let the ends of `A` lie strictly
//!    beyond `S_B` on opposite sides, and the ends of `B` beyond `S_A`. The strips are not parallel (each would be
//!    wider than the other), so `S_A ∩ S_B` is a parallelogram; a piece of `A` in it joins two of its opposite sides,
//!    a piece of `B` the other two, and two such paths in a disc meet.
//! 3. *A corner*: `A` and `B` start at one point `P`. If for some vector `n` no step of `A`'s polygon (from `P`) has `n.a < 0`
//!    and one has `n.a > 0`, and for `B` the opposite, then `n.(A(t) - P) > 0 > n.(B(s) - P)` away from `P`: they meet
//!    at `P` alone. `n` is the difference of the two chords' directions.
//!
//! Where none holds, the longer of the two is halved. Segments whose ends are f64 are decided by exact signs instead.

use super::piece::Piece;
use crate::numeric::{Ball, Dyadic};

/// Parts of a piece shorter than this are not halved: de Casteljau's roundings are of that size.
const SHORTEST: f64 = 1.0 / (1u64 << 48) as f64;
/// So many pairs of one pair of parts stay open before it is given up: a touch leaves some at every depth.
const MOST_OPEN: usize = 32;
/// So many pairs are looked at for one pair of parts.
const MOST_PAIRS: usize = 4096;
/// How often two parts that start at one point are halved to tell their directions.
const CORNER_HALVINGS: u32 = 24;

/// A box in uv.
pub(super) type Box2 = [[f64; 2]; 2];
/// A point in balls.
pub(super) type Point = [Ball<f64>; 2];

/// How two parts meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meets {
    /// They do not (but at the end they share).
    Not,
    /// They do, in this box.
    At(Box2),
    /// They have a stretch in common.
    Along(Box2),
    /// They come too near to each other there to tell.
    Open(Box2),
}

/// A range of a piece's parameter, in either direction.
#[derive(Clone, Copy)]
pub(super) struct Span<'a> {
    pub(super) piece: &'a Piece,
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Span<'_> {
    /// The first part of it.
    fn start(&self, part: f64) -> Self {
        let to = self.from + (self.to - self.from) * part;
        Self { to, ..*self }
    }
}

/// The control points of a span, in its direction; `None` where a weight is not proven to be positive.
pub(super) fn control_points(s: &Span) -> Option<Vec<Point>> {
    let against = s.from > s.to;
    let range = if against {
        [s.to, s.from]
    } else {
        [s.from, s.to]
    };
    let mut points = Vec::new();
    for p in s.piece.control().sub_points(range) {
        let q = [p[0] / p[2], p[1] / p[2]];
        if !(p[2].is_above(0.0) && q.iter().all(|x| x.rad.is_finite())) {
            return None;
        }
        points.push(q);
    }
    if against {
        points.reverse();
    }
    Some(points)
}

/// The range of one coordinate.
fn range(points: &[Point], axis: usize) -> [f64; 2] {
    points
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |r, p| {
            [r[0].min(p[axis].lower()), r[1].max(p[axis].upper())]
        })
}

fn hull(points: &[Point]) -> Box2 {
    [range(points, 0), range(points, 1)]
}

/// The middles of the first and the last point.
fn ends(points: &[Point]) -> [[f64; 2]; 2] {
    let middle = |p: &Point| p.map(|x| x.mid);
    match points {
        [a, .., b] => [middle(a), middle(b)],
        _ => [[0.0; 2]; 2],
    }
}

/// `n.(p - base)`, an enclosure.
fn level(p: &Point, base: [f64; 2], n: [f64; 2]) -> [f64; 2] {
    let term = |c: usize| (p[c] - Ball::exact(base[c])) * Ball::exact(n[c]);
    let sum = term(0) + term(1);
    [sum.lower(), sum.upper()]
}

fn levels(points: &[Point], base: [f64; 2], n: [f64; 2]) -> [f64; 2] {
    points
        .iter()
        .map(|p| level(p, base, n))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |r, l| {
            [r[0].min(l[0]), r[1].max(l[1])]
        })
}

fn disjoint(a: [f64; 2], b: [f64; 2]) -> bool {
    a[1] < b[0] || b[1] < a[0]
}

/// What is common to two boxes; the first where nothing is.
fn common(a: Box2, b: Box2) -> Box2 {
    let both = [0, 1].map(|k| [a[k][0].max(b[k][0]), a[k][1].min(b[k][1])]);
    if both.iter().all(|r| r[0] <= r[1]) {
        both
    } else {
        a
    }
}

/// A vector across the chord, and where it starts.
fn across(points: &[Point]) -> ([f64; 2], [f64; 2]) {
    let [a, b] = ends(points);
    (a, [a[1] - b[1], b[0] - a[0]])
}

/// Whether a line is between two curves with these control points.
pub(super) fn is_apart(a: &[Point], b: &[Point]) -> bool {
    if (0..2).any(|axis| disjoint(range(a, axis), range(b, axis))) {
        return true;
    }
    [a, b].into_iter().any(|of| {
        let (base, n) = across(of);
        disjoint(levels(a, base, n), levels(b, base, n))
    })
}

/// Whether the ends of `a` are beyond `b`'s strip, one on each side.
fn passes(a: &[Point], b: &[Point]) -> bool {
    let (base, n) = across(b);
    let strip = levels(b, base, n);
    let (Some(first), Some(last)) = (a.first(), a.last()) else {
        return false;
    };
    let [first, last] = [first, last].map(|p| level(p, base, n));
    (first[1] < strip[0] && last[0] > strip[1]) || (last[1] < strip[0] && first[0] > strip[1])
}

/// How long a chord is.
fn chord(points: &[Point]) -> f64 {
    let [a, b] = ends(points);
    let d = [b[0] - a[0], b[1] - a[1]];
    (d[0] * d[0] + d[1] * d[1]).sqrt()
}

/// What looking at a pair costs, in pairs of cubics: blossoms go with the cube of the number of control points.
fn cost(a: &[Point], b: &[Point]) -> usize {
    let cube = |p: &[Point]| p.len().pow(3);
    (cube(a) + cube(b)) / 128 + 1
}

/// Two parts that share no end. `budget`: how much work there may be, in all; a pair of cubics counts 2.
pub(super) fn meet(a: Span, b: Span, budget: &mut usize) -> Meets {
    let mut open: Option<Box2> = None;
    let mut opened = 0;
    let mut left = MOST_PAIRS;
    let mut stack = vec![(a, b)];
    while let Some((a, b)) = stack.pop() {
        let (Some(p), Some(q)) = (control_points(&a), control_points(&b)) else {
            return Meets::Open([a.piece.hull[0], a.piece.hull[1]]);
        };
        if is_apart(&p, &q) {
            continue;
        }
        let place = common(hull(&p), hull(&q));
        if passes(&p, &q) && passes(&q, &p) {
            return Meets::At(place);
        }
        let widths = [&a, &b].map(|s| (s.to - s.from).abs());
        let first = match widths.map(|w| w > SHORTEST) {
            [true, true] => chord(&p) >= chord(&q),
            [one, other] if one || other => one,
            _ => {
                open.get_or_insert(place);
                opened += 1;
                if opened >= MOST_OPEN {
                    break;
                }
                continue;
            }
        };
        if left == 0 || *budget == 0 {
            return Meets::Open(open.unwrap_or(place));
        }
        (left, *budget) = (left - 1, budget.saturating_sub(cost(&p, &q)));
        let cut = if first { &a } else { &b };
        let middle = 0.5 * (cut.from + cut.to);
        for half in [
            Span { to: middle, ..*cut },
            Span {
                from: middle,
                ..*cut
            },
        ] {
            stack.push(if first { (half, b) } else { (a, half) });
        }
    }
    open.map_or(Meets::Not, Meets::Open)
}

/// Whether no step has a negative part along `n` and one has a positive one; no step may be unknown.
fn leads(points: &[Point], n: [f64; 2]) -> bool {
    let mut any = false;
    for w in points.windows(2) {
        let step = [0, 1].map(|c| w[1][c] - w[0][c]);
        if step.iter().all(|x| x.rad == 0.0 && x.mid == 0.0) {
            continue;
        }
        let along = step[0] * Ball::exact(n[0]) + step[1] * Ball::exact(n[1]);
        if !along.is_above(0.0) {
            return false;
        }
        any = true;
    }
    any
}

/// Whether two polygons that start at one point leave it to different sides of a line.
fn parts_ways(a: &[Point], b: &[Point]) -> bool {
    let direction = |points: &[Point]| {
        let [p, q] = ends(points);
        let length = chord(points);
        [(q[0] - p[0]) / length, (q[1] - p[1]) / length]
    };
    let (d, e) = (direction(a), direction(b));
    let n = [d[0] - e[0], d[1] - e[1]];
    leads(a, n) && leads(b, n.map(|x| -x))
}

/// Two parts that start at one point.
pub(super) fn corner(a: Span, b: Span, budget: &mut usize) -> Meets {
    let mut part = 1.0;
    let mut place = None;
    for _ in 0..=CORNER_HALVINGS {
        let (p, q) = (a.start(part), b.start(part));
        let (Some(p_points), Some(q_points)) = (control_points(&p), control_points(&q)) else {
            break;
        };
        place = Some(common(hull(&p_points), hull(&q_points)));
        if !parts_ways(&p_points, &q_points) {
            part *= 0.5;
            continue;
        }
        if part == 1.0 {
            return Meets::Not;
        }
        // The rest of each with all of the other.
        let rests = [(Span { from: p.to, ..a }, b), (p, Span { from: q.to, ..b })];
        for (a, b) in rests {
            let found = meet(a, b, budget);
            if found != Meets::Not {
                return found;
            }
        }
        return Meets::Not;
    }
    Meets::Open(place.unwrap_or(a.piece.hull))
}

/// Whether a part turns back nowhere: all steps of its polygon go along its chord.
pub(super) fn goes_on(s: Span) -> bool {
    control_points(&s).is_some_and(|points| {
        let [a, b] = ends(&points);
        leads(&points, [b[0] - a[0], b[1] - a[1]])
    })
}

/// The sign of `(b - a) x (c - a)`, exactly.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<i32> {
    let d = |x: f64| Dyadic::from_f64(x);
    let off = |p: [f64; 2], k: usize| Some(&d(p[k])? - &d(a[k])?);
    let left = &off(b, 0)? * &off(c, 1)?;
    let right = &off(b, 1)? * &off(c, 0)?;
    Some((&left - &right).signum())
}

/// Two segments with f64 ends, exactly; the end of `a` that is the start of `b` counts for nothing where `follows`, and
/// likewise where `a` follows `b`. `None` for numbers that are not finite.
pub(super) fn segments(a: [[f64; 2]; 2], b: [[f64; 2]; 2], shared: [bool; 2]) -> Option<Meets> {
    let box_of = |s: [[f64; 2]; 2]| [0, 1].map(|k| [s[0][k].min(s[1][k]), s[0][k].max(s[1][k])]);
    let (box_a, box_b) = (box_of(a), box_of(b));
    if (0..2).any(|k| disjoint(box_a[k], box_b[k])) {
        return Some(Meets::Not);
    }
    let place = common(box_a, box_b);
    let of_b = [turn(a[0], a[1], b[0])?, turn(a[0], a[1], b[1])?];
    let of_a = [turn(b[0], b[1], a[0])?, turn(b[0], b[1], a[1])?];
    if of_b == [0, 0] {
        // On one line: what they have in common is that of their boxes.
        let point = place.iter().all(|r| r[0] == r[1]);
        let corner = shared[0] || shared[1];
        return Some(match (point, corner) {
            (true, true) => Meets::Not,
            (true, false) => Meets::At(place),
            (false, _) => Meets::Along(place),
        });
    }
    if shared[0] || shared[1] {
        // Lines that differ have one point in common.
        return Some(Meets::Not);
    }
    let both = of_b[0] * of_b[1] <= 0 && of_a[0] * of_a[1] <= 0;
    Some(if both { Meets::At(place) } else { Meets::Not })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meets(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> bool {
        match segments(a, b, [false; 2]) {
            Some(Meets::Not) => false,
            Some(Meets::At(_)) => true,
            other => panic!("{a:?} {b:?}: {other:?}"),
        }
    }

    /// Two segments meet where each has the ends of the other on different sides, or an end on it: one of the two is not enough.
    #[test]
    fn segments_meet_where_both_part_the_other() {
        let a = [[0.0, 0.0], [4.0, 4.0]];
        // Their boxes overlap. The line of the first passes the second beyond its own end, the line of the second the first within.
        for (b, is) in [
            ([[1.0, 3.0], [3.0, 1.0]], true),
            ([[1.0, 3.0], [2.0, 2.0]], true),
            ([[1.0, 3.0], [1.5, 2.5]], false),
            ([[3.0, 4.5], [4.5, 3.0]], true),
            ([[3.0, 6.0], [6.0, 3.0]], false),
            ([[3.5, 4.75], [4.75, 3.5]], false),
            ([[0.0, 1.0], [3.0, 4.0]], false),
            ([[4.0, 4.0], [3.0, 6.0]], true),
            ([[0.0, 4.0], [1.0, 1.0]], true),
        ] {
            for (x, y) in [(a, b), (b, a)] {
                for x in [x, [x[1], x[0]]] {
                    for y in [y, [y[1], y[0]]] {
                        assert_eq!(meets(x, y), is, "{x:?} {y:?}");
                    }
                }
            }
        }
    }

    /// A curve that ends on another's chord does not pass it.
    #[test]
    fn an_end_on_a_line_is_not_past_it() {
        let points =
            |p: &[[f64; 2]]| -> Vec<Point> { p.iter().map(|q| q.map(Ball::exact)).collect() };
        let chord = points(&[[0.0, 0.0], [2.0, 0.0]]);
        for (from, to, is) in [
            (-1.0, 1.0, true),
            (1.0, -1.0, true),
            (0.0, 1.0, false),
            (1.0, 0.0, false),
            (0.0, -1.0, false),
            (-1.0, 0.0, false),
        ] {
            let a = points(&[[1.0, from], [1.0, to]]);
            assert_eq!(passes(&a, &chord), is, "{from} {to}");
        }
    }
}
