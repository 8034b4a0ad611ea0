//! Faces in a plane within straight and curved pieces, and lines against them, exactly.
//!
//! # What is exact
//! On a plane, or a bilinear patch that is one, `S(u, v) = (O + A X + B Y) / m` with integers' fractions `O`, `X`, `Y`, `m` (dyadic
//! numbers all) and `A = u - u_0`, `B = v - v_0`. Where every piece of the region's boundary is straight with ends that are f64, all that
//! is asked of a line `o + t d` is a rational function of such numbers, whose sign integers tell.
//!
//! - The line crosses the plane at `t = N.(O - m o) / (m N.d)`, `N = X x Y`, at the parameters `A = (W x Y).N / (s N.N)` where `W / s`
//!   is the point relative to `O`. The side there is the parity of the pieces to its right, each counting once where one end is
//!   above it and the other is not; `Boundary` is on a piece.
//! - Where `N.d = 0` and the origin is on the plane, the line runs in it. Take a place of the line between two of its meetings with pieces.
//!   It is in the closed region if points just beside it are, to its left or to its right. To the left the parity changes where a piece has
//!   one end to the left and the other not; to the right likewise. So one walk along the sorted meetings gives all intervals. A meeting
//!   with no interval on either side is a point where the region touches the line.
//!
//! Of curved pieces of degree two the module `bow` tells where they meet a line in the plane, and whether a point is on one. Meetings that are no quotients
//! are known in enclosures, and must be told apart by these. Off all pieces, a point is in the region if it is on a run of the line
//! through it along u or v; where these are not known, its side is that of its enclosure (`trim/beside.rs`).

use super::PreparedBrep;
use super::bow::{Bow, Track};
use super::course::Round;
use super::exact::{D3, Ratio, When, cross, dot, dyadic, scale, sub, vector};
use crate::numeric::{Ball, Dd, Dyadic};
use crate::nurbs::Surface;
use crate::trim::{PieceOrigin, Side};
use nalgebra::{Point3, Vector3};
use std::cmp::Ordering;

type D2 = [Dyadic; 2];

/// Straight pieces in a plane.
#[derive(Debug)]
pub(crate) struct Polygon {
    /// `m S = origin + A x + B y`.
    origin: D3,
    x: D3,
    y: D3,
    m: Dyadic,
    /// `x x y` and its square.
    normal: D3,
    square: Dyadic,
    /// The same, of length one, rounded.
    unit: [f64; 3],
    /// Where `A` and `B` are zero.
    start: [f64; 2],
    pieces: Vec<Straight>,
    bows: Vec<Bow>,
    /// The domain, relative to the corner, where loops may leave it.
    domain: Option<D2>,
}

/// A piece of the boundary, and the trim that it is of; `None` for what joins trims and for borders of the domain.
#[derive(Debug)]
struct Straight {
    ends: [D2; 2],
    trim: Option<usize>,
}

/// Where a line meets a polygon: `t` rises.
#[derive(Clone, Debug)]
pub(crate) struct Meeting {
    pub(crate) t: When,
    /// The other end, where the line runs in the polygon.
    pub(crate) end: Option<When>,
    /// Whether it does not cross.
    pub(crate) touches: bool,
    /// Trims that it is exactly on.
    pub(crate) on: Vec<usize>,
    /// Trims that the other end is exactly on.
    pub(crate) end_on: Vec<usize>,
    /// Trims that all of it is exactly on.
    pub(crate) along: Vec<usize>,
    pub(crate) uv: [f64; 2],
}

impl Meeting {
    /// The part of it from one parameter to another, if there is one; an end that is not finite is none. `None` where that is not known. `uv_at` says where the
    /// line is at a parameter. An interval of which one point is left stays one: the line runs in the face there.
    pub(crate) fn within(
        mut self,
        range: [f64; 2],
        uv_at: impl FnOnce(&When) -> [f64; 2],
    ) -> Option<Option<Self>> {
        if let Some(low) = Ratio::from_f64(range[0]) {
            let low = When::Exact(low);
            let last = self.end.as_ref().unwrap_or(&self.t);
            if last.cmp(&low)? == Ordering::Less {
                return Some(None);
            }
            if self.t.cmp(&low)? == Ordering::Less {
                self.uv = uv_at(&low);
                self.t = low;
                self.on.clone_from(&self.along);
            }
        }
        if let Some(high) = Ratio::from_f64(range[1]) {
            let high = When::Exact(high);
            if self.t.cmp(&high)? == Ordering::Greater {
                return Some(None);
            }
            if let Some(end) = &self.end
                && end.cmp(&high)? == Ordering::Greater
            {
                self.end = Some(high);
                self.end_on.clone_from(&self.along);
            }
        }
        Some(Some(self))
    }
}

/// `a x b` in the plane.
pub(super) fn turn(a: &D2, b: &D2) -> Dyadic {
    &(&a[0] * &b[1]) - &(&a[1] * &b[0])
}

fn less(a: &D2, b: &D2) -> D2 {
    [&a[0] - &b[0], &a[1] - &b[1]]
}

/// Where a line in the plane meets pieces.
pub(super) struct Event {
    t: When,
    trims: Vec<usize>,
    /// Whether a piece passes from beside the line to the left of it or back, and likewise to the right.
    pub(super) changes: [bool; 2],
    /// Where to pieces run that end there.
    pub(super) ways: Vec<D2>,
}

impl Event {
    pub(super) fn new(t: When, trim: Option<usize>) -> Self {
        Self {
            t,
            trims: trim.into_iter().collect(),
            changes: [false; 2],
            ways: Vec::new(),
        }
    }

    /// Another at the same place.
    fn join(&mut self, other: Self) {
        for trim in other.trims {
            if !self.trims.contains(&trim) {
                self.trims.push(trim);
            }
        }
        for (own, c) in self.changes.iter_mut().zip(other.changes) {
            *own ^= c;
        }
        self.ways.extend(other.ways);
    }

    /// Whether two pieces leave in one direction.
    fn runs_back(&self) -> bool {
        let same = |a: &D2, b: &D2| {
            let along = &(&a[0] * &b[0]) + &(&a[1] * &b[1]);
            turn(a, b).signum() == 0 && along.signum() > 0
        };
        let mut rest = &self.ways[..];
        while let Some((first, others)) = rest.split_first() {
            if others.iter().any(|w| same(first, w)) {
                return true;
            }
            rest = others;
        }
        false
    }
}

impl Polygon {
    /// That of a face; `None` where it is none, or a number is none.
    pub(super) fn new(brep: &PreparedBrep, face: usize) -> Option<Self> {
        let surface = brep.brep().surface(face);
        let [u, v] = surface.domain();
        let wide = |start: f64, end: f64| Some(&dyadic(end)? - &dyadic(start)?);
        // A and B run over these as u and v do; the surface over `a` and `b`.
        let (du, dv) = (wide(u.start, u.end)?, wide(v.start, v.end)?);
        let (origin, x, y, [a, b]) = match surface {
            Surface::Plane(p) => (
                vector(p.origin.coords.as_slice())?,
                vector(p.x.as_slice())?,
                vector(p.y.as_slice())?,
                p.extents.map(|e| [e.start, e.end]),
            ),
            Surface::Nurbs(s) => {
                let [p00, p01, p10, p11] = s.control_net() else {
                    return None;
                };
                let all = [p00, p01, p10, p11];
                let degrees = [s.knots_u().degree(), s.knots_v().degree()];
                if degrees != [1, 1] || all.iter().any(|p| p.w != 1.0) {
                    return None;
                }
                let [p00, p01, p10, p11] = all.map(|p| vector(&[p.x, p.y, p.z]));
                let (p00, p01, p10, p11) = (p00?, p01?, p10?, p11?);
                let (x, y) = (sub(&p10, &p00), sub(&p01, &p00));
                if sub(&p11, &p01) != x {
                    return None;
                }
                (p00, x, y, [[0.0, 1.0]; 2])
            }
            Surface::Revolution(_) | Surface::Sum(_) => return None,
        };
        // S = O + (a_0 + A (a_1 - a_0) / du) X + ..., times du dv.
        let m = &du * &dv;
        let (da, db) = (wide(a[0], a[1])?, wide(b[0], b[1])?);
        let (a, b) = (dyadic(a[0])?, dyadic(b[0])?);
        let corner: D3 = std::array::from_fn(|c| &(&origin[c] + &(&a * &x[c])) + &(&b * &y[c]));
        let (x, y) = (scale(&x, &(&da * &dv)), scale(&y, &(&db * &du)));
        let normal = cross(&x, &y);
        let square = dot(&normal, &normal);
        if square.signum() == 0 {
            return None;
        }
        let start = [u.start, v.start];
        let (mut pieces, mut bows) = (Vec::new(), Vec::new());
        let region = brep.region(face);
        let leaves = region.pieces().any(|p| !p.inside_domain);
        for (piece, own) in region.pieces().zip(region.exact_pieces()) {
            // Where loops leave the domain, what they make is cut with it.
            if leaves && piece.origin == PieceOrigin::Domain {
                continue;
            }
            let trim = match piece.origin {
                PieceOrigin::Trim { trim, .. } => Some(trim),
                _ => None,
            };
            let Some([p, q]) = piece.segment() else {
                bows.push(Bow::new(&own, trim, start)?);
                continue;
            };
            let at = |p: [f64; 2]| -> Option<D2> {
                let relative = |k: usize| Some(&dyadic(p[k])? - &dyadic(start[k])?);
                Some([relative(0)?, relative(1)?])
            };
            pieces.push(Straight {
                ends: [at(p)?, at(q)?],
                trim,
            });
        }
        let rough = Vector3::from_fn(|c, _| normal[c].approximate());
        let unit = (rough / rough.amax()).normalize();
        Some(Self {
            origin: scale(&corner, &m),
            x,
            y,
            m,
            normal,
            square,
            unit: unit.into(),
            start,
            pieces,
            bows,
            domain: leaves.then_some([du, dv]),
        })
    }

    /// Along `S_u x S_v`, of length one, rounded.
    pub(crate) fn unit_normal(&self) -> [f64; 3] {
        self.unit
    }

    /// Whether a trim is one straight piece.
    pub(crate) fn is_straight(&self, trim: usize) -> bool {
        self.pieces.iter().filter(|p| p.trim == Some(trim)).count() == 1
            && self.bows.iter().all(|b| b.trim != Some(trim))
    }

    /// The ends in space of a trim that is one straight piece, over a common number.
    pub(super) fn segment(&self, trim: usize) -> Option<([D3; 2], &Dyadic)> {
        if !self.is_straight(trim) {
            return None;
        }
        let piece = self.pieces.iter().find(|p| p.trim == Some(trim))?;
        let ends = piece.ends.each_ref().map(|[a, b]| {
            std::array::from_fn(|c| &(&self.origin[c] + &(a * &self.x[c])) + &(b * &self.y[c]))
        });
        Some((ends, &self.m))
    }

    /// Whether `n.x >= h` is proven for all points of it: on its boundary, in whose hull it is.
    pub(super) fn is_above(&self, normal: &D3, height: &Dyadic) -> bool {
        // m (n.S - h) = at + A a + B b.
        let at = &dot(normal, &self.origin) - &(&self.m * height);
        let (a, b) = (dot(normal, &self.x), dot(normal, &self.y));
        let is_above = |p: &D2, weight: &Dyadic| {
            let value = &(&at * weight) + &(&(&a * &p[0]) + &(&b * &p[1]));
            value.signum() >= 0
        };
        let mut ends = self.pieces.iter().flat_map(|p| &p.ends);
        let one = Dyadic::from_f64(1.0);
        let has_border = !(self.pieces.is_empty() && self.bows.is_empty());
        // What joins two trims is between their ends.
        let mut bows = self.bows.iter().filter(|bow| bow.trim.is_some());
        has_border
            && one.is_some_and(|one| ends.all(|p| is_above(p, &one)))
            && bows.all(|bow| bow.is_above([&at, &a, &b], is_above))
    }

    /// The circle in space that circles about a place in uv are; `None` where they are ellipses.
    pub(super) fn circle(&self, center: [f64; 2]) -> Option<Round> {
        let even =
            dot(&self.x, &self.y).signum() == 0 && dot(&self.x, &self.x) == dot(&self.y, &self.y);
        if !even {
            return None;
        }
        let by = |k: usize| Some(&dyadic(center[k])? - &dyadic(self.start[k])?);
        let (a, b) = (by(0)?, by(1)?);
        let origin =
            std::array::from_fn(|c| &(&self.origin[c] + &(&a * &self.x[c])) + &(&b * &self.y[c]));
        Some(Round::new(origin, self.m.clone(), self.normal.clone()))
    }

    /// Whether all of its pieces are straight: then nothing is left open, but where pieces run back.
    pub(crate) fn is_plain(&self) -> bool {
        self.bows.is_empty()
    }

    /// All places where a line meets the closed polygon, in order; `None` where the line is not of finite numbers, or
    /// touches the region in a point where two pieces run back, and next to curved pieces where neither exact numbers nor
    /// `side`, the side of parameters that are known in enclosures, tell.
    pub(crate) fn meetings(
        &self,
        o: &Point3<f64>,
        d: &Vector3<f64>,
        range: [f64; 2],
        side: impl FnOnce([Ball<Dd>; 2]) -> Option<Side>,
    ) -> Option<Vec<Meeting>> {
        let (o, d) = (vector(o.coords.as_slice())?, vector(d.as_slice())?);
        // From the corner to the origin, times m.
        let from = sub(&scale(&o, &self.m), &self.origin);
        let rate = dot(&self.normal, &d);
        let height = dot(&self.normal, &from);
        if rate.signum() == 0 {
            if height.signum() != 0 {
                return Some(Vec::new());
            }
            return self.along(&from, &d, range);
        }
        // m (o + t d) - origin = from + t m d, t = -height / (m rate): times the rate.
        let t = When::Exact(Ratio::new(-&height, &self.m * &rate));
        let w: D3 = std::array::from_fn(|c| &(&from[c] * &rate) - &(&d[c] * &height));
        let bottom = &rate * &self.square;
        let p = self.parameters(&w);
        let (side, on) = self.side(&p, &bottom, side)?;
        if side == Side::Outside {
            return Some(Vec::new());
        }
        let uv = self.rounded(&p, &bottom);
        let meeting = Meeting {
            t,
            end: None,
            touches: false,
            on,
            end_on: Vec::new(),
            along: Vec::new(),
            uv,
        };
        Some(meeting.within(range, |_| uv)?.into_iter().collect())
    }

    /// `A` and `B` of a vector in the plane, times the normal's square.
    fn parameters(&self, w: &D3) -> D2 {
        [
            dot(&cross(w, &self.y), &self.normal),
            dot(&cross(&self.x, w), &self.normal),
        ]
    }

    fn rounded(&self, p: &D2, bottom: &Dyadic) -> [f64; 2] {
        // Both may be beyond all f64 where the quotient is not.
        [0, 1].map(|k| self.start[k] + Ratio::new(p[k].clone(), bottom.clone()).enclosed().mid.hi)
    }

    /// The side of `p / s`, and the trims that it is on: off all that is exact, it is what is said of an enclosure where there are curved pieces.
    fn side(
        &self,
        p: &D2,
        s: &Dyadic,
        otherwise: impl FnOnce([Ball<Dd>; 2]) -> Option<Side>,
    ) -> Option<(Side, Vec<usize>)> {
        let (p, s) = if s.signum() < 0 {
            ([-&p[0], -&p[1]], -s)
        } else {
            (p.clone(), s.clone())
        };
        if let Some(domain) = &self.domain {
            let beyond = |k: usize| p[k].signum() < 0 || p[k] > &domain[k] * &s;
            if beyond(0) || beyond(1) {
                return Some((Side::Outside, Vec::new()));
            }
        }
        let (mut odd, mut border, mut on) = (false, false, Vec::new());
        for piece in &self.pieces {
            let [a, b] = piece.ends.each_ref().map(|e| [&e[0] * &s, &e[1] * &s]);
            let (from, to) = (less(&p, &a), less(&p, &b));
            let turned = turn(&from, &to).signum();
            // On the piece: in line with its ends, and not beyond one of them.
            let between = |k: usize| from[k].signum() * to[k].signum() <= 0;
            if turned == 0 && between(0) && between(1) {
                border = true;
                on.extend(piece.trim);
            }
            let above = [a[1] > p[1], b[1] > p[1]];
            if above[0] != above[1] {
                // Upwards it is to the right of p where p is to its left.
                odd ^= if above[1] { turned > 0 } else { turned < 0 };
            }
        }
        for bow in &self.bows {
            if bow.holds(&p, &s) == Some(true) {
                border = true;
                on.extend(bow.trim);
            }
        }
        let side = if border {
            Side::Boundary
        } else if !self.is_plain() {
            // Enclosures tell sooner, as a rule.
            let at = [0, 1].map(|k| {
                let off = Ratio::new(p[k].clone(), s.clone()).enclosed();
                Ball::exact(self.start[k]) + off
            });
            match otherwise(at) {
                Some(side) => side,
                None if self.is_on_run(&p, &s)? => Side::Inside,
                None => Side::Outside,
            }
        } else if odd {
            Side::Inside
        } else {
            Side::Outside
        };
        Some((side, on))
    }

    /// Whether a point `p / s` is on a run of the line through it along u or v, where there are curved pieces; `None` where that is not known.
    fn is_on_run(&self, p: &D2, s: &Dyadic) -> Option<bool> {
        if self.is_plain() {
            return None;
        }
        let here = When::Exact(Ratio::from_f64(0.0)?);
        let along = |q: D2| -> Option<bool> {
            for m in self.runs(p, &q, s)? {
                let last = m.end.as_ref().unwrap_or(&m.t);
                if m.t.cmp(&here)?.is_le() && last.cmp(&here)?.is_ge() {
                    return Some(true);
                }
            }
            Some(false)
        };
        along([s.clone(), Dyadic::ZERO]).or_else(|| along([Dyadic::ZERO, s.clone()]))
    }

    /// For a line in the plane.
    fn along(&self, from: &D3, d: &D3, range: [f64; 2]) -> Option<Vec<Meeting>> {
        let (p, q) = (self.parameters(from), self.parameters(&scale(d, &self.m)));
        let runs = self.runs(&p, &q, &self.square)?.into_iter();
        let kept = runs.map(|m| m.within(range, |t| self.uv_at((&p, &q, &self.square), t)));
        Some(
            kept.collect::<Option<Vec<_>>>()?
                .into_iter()
                .flatten()
                .collect(),
        )
    }

    /// Where the line in the plane that is at `(p + t q) / square` at `t` meets the closed region.
    fn runs(&self, p: &D2, q: &D2, square: &Dyadic) -> Option<Vec<Meeting>> {
        let axis = usize::from(q[0].signum() == 0);
        let mut events: Vec<Event> = Vec::new();
        for piece in &self.pieces {
            let ends = piece.ends.each_ref().map(|e| {
                let e = [&e[0] * square, &e[1] * square];
                less(&e, p)
            });
            // Above zero to the left.
            let left = ends.each_ref().map(|e| turn(q, e));
            let signs = left.each_ref().map(Dyadic::signum);
            for k in 0..2 {
                if signs[k] == 0 {
                    let t = Ratio::new(ends[k][axis].clone(), q[axis].clone());
                    let mut event = Event::new(When::Exact(t), piece.trim);
                    event.ways.push(less(&ends[1 - k], &ends[k]));
                    events.push(event);
                }
            }
            let crosses = [
                (signs[0] > 0) != (signs[1] > 0),
                (signs[0] < 0) != (signs[1] < 0),
            ];
            if !(crosses[0] || crosses[1]) {
                continue;
            }
            let t = match signs {
                [0, _] => Ratio::new(ends[0][axis].clone(), q[axis].clone()),
                [_, 0] => Ratio::new(ends[1][axis].clone(), q[axis].clone()),
                _ => {
                    // e_0 + s (e_1 - e_0) with s = l_0 / (l_0 - l_1).
                    let span = &left[0] - &left[1];
                    let step = &ends[1][axis] - &ends[0][axis];
                    let at = &(&ends[0][axis] * &span) + &(&step * &left[0]);
                    Ratio::new(at, &span * &q[axis])
                }
            };
            let mut event = Event::new(When::Exact(t), piece.trim);
            event.changes = crosses;
            events.push(event);
        }
        let line = Track { p, q, square, axis };
        for bow in &self.bows {
            events.extend(bow.events(&line)?);
        }
        // In order of what is about their parameters; then each is compared with the one before.
        let mut events: Vec<(Dd, Event)> = events
            .into_iter()
            .map(|e| (e.t.enclosed().mid, e))
            .collect();
        events.sort_by(|(x, a), (y, b)| match (&a.t, &b.t) {
            (When::Exact(a), When::Exact(b)) if self.is_plain() => a.cmp(b),
            _ => x.partial_cmp(y).unwrap_or(Ordering::Equal),
        });
        let mut places: Vec<Event> = Vec::new();
        for (_, event) in events {
            match places.last_mut() {
                Some(last) => match last.t.cmp(&event.t)? {
                    Ordering::Equal => last.join(event),
                    Ordering::Less => places.push(event),
                    Ordering::Greater => return None,
                },
                None => places.push(event),
            }
        }
        let mut out: Vec<Meeting> = Vec::new();
        let mut odd = [false; 2];
        for place in places {
            let before = odd[0] || odd[1];
            for (o, c) in odd.iter_mut().zip(place.changes) {
                *o ^= c;
            }
            let after = odd[0] || odd[1];
            match (before, after) {
                (true, true) => {}
                (true, false) => {
                    let last = out.last_mut()?;
                    last.end = Some(place.t);
                    last.end_on = place.trims;
                    // A segment that both ends are on holds all between them.
                    let held = last.on.iter().copied();
                    let along = held.filter(|t| last.end_on.contains(t) && self.is_straight(*t));
                    last.along = along.collect();
                }
                // Where pieces run back there is no area beside the line.
                (false, false) if place.runs_back() => return None,
                // An interval begins, or a corner only touches the line.
                (false, _) => {
                    let uv = self.uv_at((p, q, square), &place.t);
                    out.push(Meeting {
                        t: place.t,
                        end: None,
                        touches: true,
                        on: place.trims,
                        end_on: Vec::new(),
                        along: Vec::new(),
                        uv,
                    });
                }
            }
        }
        match &self.domain {
            Some(domain) => self.cut(out, domain, (p, q, square)),
            None => Some(out),
        }
    }

    /// What of meetings is in the domain; `None` where that is not known.
    fn cut(
        &self,
        meetings: Vec<Meeting>,
        domain: &D2,
        line @ (p, q, square): (&D2, &D2, &Dyadic),
    ) -> Option<Vec<Meeting>> {
        // (p + t q) / square is from zero to the domain's width.
        let (mut low, mut high): (Option<Ratio>, Option<Ratio>) = (None, None);
        for k in 0..2 {
            let far = &domain[k] * square;
            if q[k].signum() == 0 {
                if p[k].signum() < 0 || p[k] > far {
                    return Some(Vec::new());
                }
                continue;
            }
            let [mut first, mut last] =
                [-&p[k], &far - &p[k]].map(|top| Ratio::new(top, q[k].clone()));
            if q[k].signum() < 0 {
                std::mem::swap(&mut first, &mut last);
            }
            if low.as_ref().is_none_or(|l| l.cmp(&first).is_lt()) {
                low = Some(first);
            }
            if high.as_ref().is_none_or(|h| h.cmp(&last).is_gt()) {
                high = Some(last);
            }
        }
        let (low, high) = (low?, high?);
        if low.cmp(&high).is_gt() {
            return Some(Vec::new());
        }
        let (low, high) = (When::Exact(low), When::Exact(high));
        let mut out = Vec::new();
        for mut m in meetings {
            let last = m.end.as_ref().unwrap_or(&m.t);
            if last.cmp(&low)?.is_lt() || m.t.cmp(&high)?.is_gt() {
                continue;
            }
            if m.t.cmp(&low)?.is_lt() {
                m.t = low.clone();
                m.on.clone_from(&m.along);
                m.uv = self.uv_at(line, &m.t);
            }
            if let Some(end) = &m.end
                && end.cmp(&high)?.is_gt()
            {
                m.end = Some(high.clone());
                m.end_on.clone_from(&m.along);
            }
            // What is left is one point.
            if m.end.as_ref().is_some_and(|e| e.is(&m.t)) {
                m.end = None;
            }
            out.push(m);
        }
        Some(out)
    }

    fn uv_at(&self, (p, q, square): (&D2, &D2, &Dyadic), t: &When) -> [f64; 2] {
        let t = match t {
            When::Exact(t) => t,
            When::Known(t) => {
                return [0, 1].map(|k| {
                    let part = |x: &Dyadic| Ratio::new(x.clone(), square.clone()).enclosed().mid.hi;
                    self.start[k] + (part(&p[k]) + part(&q[k]) * t.mid.hi)
                });
            }
        };
        let at = [0, 1].map(|k| &(&p[k] * &t.bottom) + &(&q[k] * &t.top));
        self.rounded(&at, &(square * &t.bottom))
    }
}
