//! Faces that are polygons in a plane, and lines against them, exactly.
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

use super::PreparedBrep;
use super::exact::{D3, Ratio, cross, dot, dyadic, scale, sub, vector};
use crate::numeric::Dyadic;
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
    pub(crate) t: Ratio,
    /// The other end, where the line runs in the polygon.
    pub(crate) end: Option<Ratio>,
    /// Whether it does not cross.
    pub(crate) touches: bool,
    /// Trims that it is exactly on.
    pub(crate) on: Vec<usize>,
    /// Trims that the other end is exactly on.
    pub(crate) end_on: Vec<usize>,
    pub(crate) uv: [f64; 2],
}

impl Meeting {
    /// The part of it from one parameter to another; an end that is not finite is none. `None` where it is beyond.
    pub(crate) fn within(mut self, range: [f64; 2]) -> Option<Self> {
        if let Some(low) = Ratio::from_f64(range[0]) {
            let last = self.end.as_ref().unwrap_or(&self.t);
            if last.cmp(&low) == Ordering::Less {
                return None;
            }
            if self.t.cmp(&low) == Ordering::Less {
                self.t = low;
                self.on.clear();
            }
        }
        if let Some(high) = Ratio::from_f64(range[1]) {
            if self.t.cmp(&high) == Ordering::Greater {
                return None;
            }
            if self
                .end
                .as_ref()
                .is_some_and(|e| e.cmp(&high) == Ordering::Greater)
            {
                self.end = Some(high);
                self.end_on.clear();
            }
        }
        Some(self)
    }
}

/// `a x b` in the plane.
fn turn(a: &D2, b: &D2) -> Dyadic {
    &(&a[0] * &b[1]) - &(&a[1] * &b[0])
}

fn less(a: &D2, b: &D2) -> D2 {
    [&a[0] - &b[0], &a[1] - &b[1]]
}

/// Where a line in the plane meets pieces.
struct Event {
    t: Ratio,
    trims: Vec<usize>,
    /// Whether a piece passes from beside the line to the left of it or back, and likewise to the right.
    changes: [bool; 2],
    /// Where to pieces run that end there.
    ways: Vec<D2>,
}

impl Event {
    fn new(t: Ratio, piece: &Straight) -> Self {
        Self {
            t,
            trims: piece.trim.into_iter().collect(),
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
        let mut pieces = Vec::new();
        for piece in brep.region(face).pieces() {
            let [p, q] = piece.control_points.as_slice() else {
                return None;
            };
            if piece.radius != [0.0; 3] || p[2] != 1.0 || q[2] != 1.0 || !piece.inside_domain {
                return None;
            }
            let at = |p: &[f64; 3]| -> Option<D2> {
                let relative = |k: usize| Some(&dyadic(p[k])? - &dyadic(start[k])?);
                Some([relative(0)?, relative(1)?])
            };
            pieces.push(Straight {
                ends: [at(p)?, at(q)?],
                trim: match piece.origin {
                    PieceOrigin::Trim { trim, .. } => Some(trim),
                    _ => None,
                },
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
        })
    }

    /// Along `S_u x S_v`, of length one, rounded.
    pub(crate) fn unit_normal(&self) -> [f64; 3] {
        self.unit
    }

    /// Whether a trim is one straight piece.
    pub(crate) fn is_straight(&self, trim: usize) -> bool {
        self.pieces.iter().filter(|p| p.trim == Some(trim)).count() == 1
    }

    /// All places where a line meets the closed polygon, in order; `None` where the line is not of finite numbers, or
    /// touches the region in a point where two pieces run back.
    pub(crate) fn meetings(&self, o: &Point3<f64>, d: &Vector3<f64>) -> Option<Vec<Meeting>> {
        let (o, d) = (vector(o.coords.as_slice())?, vector(d.as_slice())?);
        // From the corner to the origin, times m.
        let from = sub(&scale(&o, &self.m), &self.origin);
        let rate = dot(&self.normal, &d);
        let height = dot(&self.normal, &from);
        if rate.signum() == 0 {
            if height.signum() != 0 {
                return Some(Vec::new());
            }
            return self.along(&from, &d);
        }
        // m (o + t d) - origin = from + t m d, t = -height / (m rate): times the rate.
        let t = Ratio::new(-&height, &self.m * &rate);
        let w: D3 = std::array::from_fn(|c| &(&from[c] * &rate) - &(&d[c] * &height));
        let bottom = &rate * &self.square;
        let p = self.parameters(&w);
        let (side, on) = self.side(&p, &bottom);
        if side == Side::Outside {
            return Some(Vec::new());
        }
        let uv = self.rounded(&p, &bottom);
        Some(vec![Meeting {
            t,
            end: None,
            touches: false,
            on,
            end_on: Vec::new(),
            uv,
        }])
    }

    /// `A` and `B` of a vector in the plane, times the normal's square.
    fn parameters(&self, w: &D3) -> D2 {
        [
            dot(&cross(w, &self.y), &self.normal),
            dot(&cross(&self.x, w), &self.normal),
        ]
    }

    fn rounded(&self, p: &D2, bottom: &Dyadic) -> [f64; 2] {
        [0, 1].map(|k| self.start[k] + p[k].approximate() / bottom.approximate())
    }

    /// The side of `p / s`, and the trims that it is on.
    fn side(&self, p: &D2, s: &Dyadic) -> (Side, Vec<usize>) {
        let (p, s) = if s.signum() < 0 {
            ([-&p[0], -&p[1]], -s)
        } else {
            (p.clone(), s.clone())
        };
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
        let side = if border {
            Side::Boundary
        } else if odd {
            Side::Inside
        } else {
            Side::Outside
        };
        (side, on)
    }

    /// For a line in the plane.
    fn along(&self, from: &D3, d: &D3) -> Option<Vec<Meeting>> {
        // At t it is at (p + t q) / square.
        let (p, q) = (self.parameters(from), self.parameters(&scale(d, &self.m)));
        let axis = usize::from(q[0].signum() == 0);
        let mut events: Vec<Event> = Vec::new();
        for piece in &self.pieces {
            let ends = piece.ends.each_ref().map(|e| {
                let e = [&e[0] * &self.square, &e[1] * &self.square];
                less(&e, &p)
            });
            // Above zero to the left.
            let left = ends.each_ref().map(|e| turn(&q, e));
            let signs = left.each_ref().map(Dyadic::signum);
            for k in 0..2 {
                if signs[k] == 0 {
                    let t = Ratio::new(ends[k][axis].clone(), q[axis].clone());
                    let mut event = Event::new(t, piece);
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
            let mut event = Event::new(t, piece);
            event.changes = crosses;
            events.push(event);
        }
        events.sort_by(|a, b| a.t.cmp(&b.t));
        let mut places: Vec<Event> = Vec::new();
        for event in events {
            match places.last_mut() {
                Some(last) if last.t.cmp(&event.t) == Ordering::Equal => last.join(event),
                _ => places.push(event),
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
                }
                // Where pieces run back there is no area beside the line.
                (false, false) if place.runs_back() => return None,
                // An interval begins, or a corner only touches the line.
                (false, _) => {
                    let uv = self.uv_at(&p, &q, &place.t);
                    out.push(Meeting {
                        t: place.t,
                        end: None,
                        touches: true,
                        on: place.trims,
                        end_on: Vec::new(),
                        uv,
                    });
                }
            }
        }
        Some(out)
    }

    fn uv_at(&self, p: &D2, q: &D2, t: &Ratio) -> [f64; 2] {
        let at = [0, 1].map(|k| &(&p[k] * &t.bottom) + &(&q[k] * &t.top));
        self.rounded(&at, &(&self.square * &t.bottom))
    }
}
