//! Boundary curves that are segments or arcs in space.

use super::form::{
    Extent, Minimum, Target, UP, V3, Vector, add, along, angle, distance_range, dot, exact, lead,
    least_square, range, rounded, scale, sub,
};
use crate::numeric::{Ball, Dd, Real};
use std::sync::OnceLock;

/// A boundary curve, or part of one, in closed form.
#[derive(Clone, Debug)]
pub(crate) struct ClosedCurve {
    /// What it is part of.
    pub(crate) of: Of,
    /// Of a segment between points of f64 it is made when it is [first asked for](super::ClosedFace::shape): of many few are.
    pub(super) shape: OnceLock<CurveShape>,
    pub(crate) uv: UvPath,
    /// Whether it was moved into the domain, so that its points may lie outside the region.
    pub(crate) moved: bool,
    /// Whether it runs against the trim.
    pub(crate) against: bool,
}

/// What a boundary curve is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Of {
    Trim(u32),
    /// The segment that joins a trim to the next.
    JoinAfter(u32),
    /// The border of a domain without loops.
    Border,
}

impl Of {
    pub(super) fn new(trim: Option<usize>, after: Option<usize>) -> Self {
        match (trim, after) {
            (Some(trim), _) => Self::Trim(trim as u32),
            (None, Some(after)) => Self::JoinAfter(after as u32),
            (None, None) => Self::Border,
        }
    }

    pub(crate) fn trim(self) -> Option<usize> {
        match self {
            Self::Trim(trim) => Some(trim as usize),
            Self::JoinAfter(_) | Self::Border => None,
        }
    }

    /// Of a segment that joins two trims, the one that ends where it starts.
    pub(crate) fn trim_before(self) -> Option<usize> {
        match self {
            Self::JoinAfter(trim) => Some(trim as usize),
            Self::Trim(_) | Self::Border => None,
        }
    }
}

/// Where a curve lies in uv.
#[derive(Clone, Copy, Debug)]
pub(crate) enum UvPath {
    /// Straight from one point to the other, as the curve runs at a constant speed (a segment over [0, 1], an arc
    /// over its angle).
    Straight([[f64; 2]; 2]),
    /// `center + cos a x + sin a y`, `a` the arc's angle.
    Circle {
        center: [f64; 2],
        x: [f64; 2],
        y: [f64; 2],
    },
}

impl UvPath {
    pub(super) fn straight(ends: [[Ball<Dd>; 2]; 2]) -> Self {
        Self::Straight(ends.map(|p| p.map(|x| x.mid.hi)))
    }
}

#[derive(Clone, Debug)]
pub(crate) enum CurveShape {
    Segment(Box<SegmentShape>),
    Arc(Box<ArcShape>),
}

/// From `a` to `b`.
#[derive(Clone, Debug)]
pub(crate) struct SegmentShape {
    pub(crate) a: V3,
    pub(crate) b: V3,
    /// `b - a` and its length, zero for a point.
    d: V3,
    length: Ball<Dd>,
    /// `a` and `d` rounded to f64.
    rough: [Vector<f64>; 2],
}

/// `center + radius (cos a x + sin a y)`, `0 <= a <= turn`, with orthonormal `x`, `y`, `z`.
#[derive(Clone, Debug)]
pub(crate) struct ArcShape {
    pub(crate) center: V3,
    pub(crate) x: V3,
    pub(crate) y: V3,
    pub(crate) z: V3,
    pub(crate) radius: Ball<Dd>,
    pub(crate) turn: Ball<Dd>,
    /// Cosine and sine of `turn`.
    pub(crate) end: [Ball<Dd>; 2],
    /// The end points.
    pub(crate) ends: [V3; 2],
    rough: Circle<f64>,
}

/// The circle of an arc in one arithmetic: its centre, its axes and its radius.
#[derive(Clone, Debug)]
struct Circle<T> {
    center: Vector<T>,
    axes: [Vector<T>; 3],
    radius: Ball<T>,
}

impl Circle<f64> {
    fn rounded(center: &V3, axes: [&V3; 3], radius: Ball<Dd>) -> Self {
        Self {
            center: rounded(center),
            axes: axes.map(rounded),
            radius: lead(radius),
        }
    }
}

impl<T: Real> Circle<T> {
    /// The direction of the minimum over the circle along the first two axes (not normalised), its length, and the value there.
    ///
    /// Squared distance: with `w = q - center`, `p = (w.x, w.y)`: `(|p| - R)^2 + (w.z)^2`, along `p`. Height: `n.center - h -
    /// R |(n.x, n.y)|`, against it.
    fn least(&self, target: &Target) -> ([Ball<T>; 2], Ball<T>, [Dd; 2]) {
        let [x, y, z] = &self.axes;
        match target {
            Target::Point(q) => {
                let w = sub(&exact(q), &self.center);
                let p = [dot(&w, x), dot(&w, y)];
                let off = dot(&w, z);
                let plane = (p[0].square() + p[1].square()).sqrt();
                let gap = plane - self.radius;
                let d = (gap.square() + off.square()).sqrt();
                (p, plane, distance_range(d, 0.0))
            }
            Target::Height(n, h) => {
                let n = exact(n);
                let p = [dot(&n, x), dot(&n, y)];
                let plane = (p[0].square() + p[1].square()).sqrt();
                let value = dot(&n, &self.center) - Ball::exact(*h) - self.radius * plane;
                ([-p[0], -p[1]], plane, range(value, 0.0))
            }
        }
    }
}

const WHOLE: f64 = std::f64::consts::TAU;
/// A direction is one whose length is off by no more than this part. (What the point that it leads to is off is counted all the same; where the square of the
/// length has underflowed it is no place worth telling.)
const SHARP: f64 = 1.0 / (1u64 << 40) as f64;
const HALF: f64 = std::f64::consts::PI;
/// A segment is short beside a distance of which it is this part.
const SHORT: f64 = 1.0 / (1u64 << 20) as f64;

impl CurveShape {
    pub(super) fn segment(a: V3, b: V3) -> Self {
        let d = sub(&b, &a);
        let length = dot(&d, &d).sqrt();
        let rough = [rounded(&a), rounded(&d)];
        Self::Segment(Box::new(SegmentShape {
            a,
            b,
            d,
            length,
            rough,
        }))
    }

    /// An arc that starts at `x` and turns towards `y`; `None` for one that turns back or more than once around.
    pub(super) fn arc(center: V3, x: V3, y: V3, radius: Ball<Dd>, turn: Ball<Dd>) -> Option<Self> {
        // The end of a whole turn, in f64, may be a few roundings past 2 pi.
        const MOST: f64 = WHOLE * (1.0 + 4.0 * f64::EPSILON);
        if !(turn.lower() > 0.0 && turn.upper() <= MOST && radius.lower() > 0.0) {
            return None;
        }
        let (sin, cos) = crate::numeric::sin_cos(turn);
        let z = std::array::from_fn(|c| {
            let (i, j) = ((c + 1) % 3, (c + 2) % 3);
            x[i] * y[j] - x[j] * y[i]
        });
        let at = |c: Ball<Dd>, s: Ball<Dd>| {
            let p = add(&scale(&x, c), &scale(&y, s));
            along(&center, radius, &p)
        };
        let ends = [at(Ball::ONE, Ball::ZERO), at(cos, sin)];
        Some(Self::Arc(Box::new(ArcShape {
            center,
            x,
            y,
            z,
            radius,
            turn,
            end: [cos, sin],
            ends,
            rough: Circle::rounded(&center, [&x, &y, &z], radius),
        })))
    }
}

impl CurveShape {
    /// A proven lower bound over the curve, of an arc over its whole circle. In f64: it only puts aside curves that are farther off.
    pub(crate) fn least(&self, target: &Target) -> Dd {
        match self {
            Self::Arc(arc) => arc.rough.least(target).2[0],
            Self::Segment(segment) => segment_least(target, &segment.rough),
        }
    }

    /// Whether an end may be a local minimum along the curve beside the [least](ClosedCurve::minimum): of an arc, as it may turn beyond the point
    /// farthest away, and of a segment on one level. (A squared distance on a segment is convex.)
    pub(crate) fn may_end_low(&self, target: &Target, ends: &[Minimum; 2]) -> bool {
        let [a, b] = ends.each_ref().map(|m| m.range);
        let level = matches!(target, Target::Height(..)) && !(a[1] < b[0] || b[1] < a[0]);
        level || matches!(self, Self::Arc(_))
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Segment(s) => size_of_val(&**s),
            Self::Arc(a) => size_of_val(&**a),
        }
    }

    /// A box around it; around the whole circle of an arc (whose axes are of length one, up to rounding).
    pub(crate) fn bounds(&self) -> [[f64; 2]; 3] {
        match self {
            Self::Segment(s) => {
                let (a, b) = (&s.a, &s.b);
                let low = |c: usize| a[c].lower().min(b[c].lower());
                let high = |c: usize| a[c].upper().max(b[c].upper());
                [0, 1, 2].map(|c| [low(c), high(c)])
            }
            Self::Arc(arc) => {
                const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
                let r = arc.radius.upper() * UP;
                let around =
                    |x: &Ball<Dd>| [(x.lower() - r).next_down(), (x.upper() + r).next_up()];
                [0, 1, 2].map(|c| around(&arc.center[c]))
            }
        }
    }

    /// The same arc with its axis known better than from the cross product.
    pub(super) fn about(mut self, axis: V3) -> Self {
        if let Self::Arc(arc) = &mut self {
            arc.z = axis;
            arc.rough.axes[2] = rounded(&axis);
        }
        self
    }
}

/// Whether something holds, as far as is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Known {
    Yes,
    No,
    Unsure,
}

impl ArcShape {
    /// Whether the direction `(c, s)` (not normalised) lies on the arc.
    ///
    /// An arc of at most half a turn holds what is not right of its start and not left of its end; the complement of a
    /// longer one, up to a whole turn, is what is right of its start and left of its end.
    pub(crate) fn holds(&self, c: Ball<Dd>, s: Ball<Dd>) -> Known {
        // The f64 2 pi is below the true one, its successor above.
        if self.turn.lower() >= WHOLE.next_up() {
            return Known::Yes;
        }
        let sign = |x: Ball<Dd>| {
            if x.lower() > 0.0 {
                Known::Yes
            } else if x.upper() < 0.0 {
                Known::No
            } else {
                Known::Unsure
            }
        };
        let after_start = sign(s);
        // end cross direction < 0.
        let before_end = sign(self.end[1] * c - self.end[0] * s);
        if self.turn.upper() < HALF {
            return match (after_start, before_end) {
                (Known::Yes, Known::Yes) => Known::Yes,
                (Known::No, _) | (_, Known::No) => Known::No,
                _ => Known::Unsure,
            };
        }
        if self.turn.lower() > HALF {
            return match (after_start, before_end) {
                (Known::Yes, _) | (_, Known::Yes) => Known::Yes,
                // It may turn past its start by a rounding: then nothing is off it.
                (Known::No, Known::No) if self.turn.upper() <= WHOLE => Known::No,
                _ => Known::Unsure,
            };
        }
        // Half a turn, as far as is known: the end lies against the start.
        match (after_start, before_end) {
            (Known::Yes, Known::Yes) => Known::Yes,
            (Known::No, Known::No) => Known::No,
            _ => Known::Unsure,
        }
    }

    fn minimum(&self, target: &Target) -> (Minimum, f64, f64) {
        let circle = Circle {
            center: self.center,
            axes: [self.x, self.y, self.z],
            radius: self.radius,
        };
        let (p, length, inner) = circle.least(target);
        let grow = match target {
            Target::Point(_) => 1.0,
            Target::Height(..) => 0.5,
        };
        let radius = self.radius.mid.hi;
        let extent = Extent::Ring {
            around: (radius / (grow * length.mid.hi)).sqrt(),
            diameter: 2.0 * radius,
            along: 0.0,
        };
        // Next to the axis it leads nowhere.
        let held = if length.rad <= SHARP * length.mid.hi {
            self.holds(p[0], p[1])
        } else {
            Known::Unsure
        };
        if held == Known::Yes {
            let d = [p[0] / length, p[1] / length];
            let point = along(
                &along(&self.center, self.radius * d[0], &self.x),
                self.radius * d[1],
                &self.y,
            );
            let found_angle = angle(p[1], p[0]);
            let a = found_angle.at;
            let a = if a < 0.0 { a + WHOLE } else { a };
            let found = Minimum {
                range: inner,
                point,
                uv: [0.0; 2],
                uv_off: [0.0; 2],
                unique: true,
                extent,
            };
            return (
                found,
                a.clamp(0.0, self.turn.mid.hi),
                found_angle.off + 8.0 * f64::EPSILON,
            );
        }
        let [first, last] = [0, 1].map(|k| target.range_at(&self.ends[k]));
        let (k, end) = if last[1] < first[1] {
            (1, last)
        } else {
            (0, first)
        };
        let low = match held {
            // The least on the whole circle.
            Known::Unsure => inner[0],
            _ if last[0] < first[0] => last[0],
            _ => first[0],
        };
        let unsure = held == Known::Unsure;
        // Both ends may be equally low.
        let apart = first[1] < last[0] || last[1] < first[0];
        let found = Minimum {
            range: [low, end[1]],
            point: self.ends[k],
            uv: [0.0; 2],
            uv_off: [0.0; 2],
            unique: apart && !unsure,
            extent: if unsure { extent } else { Extent::Root(0.0) },
        };
        (found, if k == 0 { 0.0 } else { self.turn.mid.hi }, 0.0)
    }
}

impl ClosedCurve {
    pub(super) fn new(of: Of, uv: UvPath, shape: CurveShape) -> Self {
        Self {
            shape: OnceLock::from(shape),
            ..Self::unmade(of, uv)
        }
    }

    /// One whose shape is made when it is asked for.
    pub(super) fn unmade(of: Of, uv: UvPath) -> Self {
        Self {
            of,
            shape: OnceLock::new(),
            uv,
            moved: false,
            against: false,
        }
    }

    pub(super) fn segment(a: V3, b: V3, uv: [[Ball<Dd>; 2]; 2], of: Of) -> Self {
        Self::new(of, UvPath::straight(uv), CurveShape::segment(a, b))
    }

    /// The minimum over the curve, given its shape: for a segment, the foot where it is between the ends, else the nearer end. A squared
    /// distance on a segment is a parabola, a height is linear.
    pub(crate) fn minimum(&self, shape: &CurveShape, target: &Target) -> Minimum {
        match shape {
            CurveShape::Arc(arc) => {
                let (found, a, off) = arc.minimum(target);
                let turn = arc.turn.mid.hi;
                let part = if a == turn { 1.0 } else { a / turn };
                Minimum {
                    uv: self.uv_at(part, a),
                    uv_off: self.uv_off(off / turn),
                    ..found
                }
            }
            CurveShape::Segment(segment) => {
                let (found, s, off) = segment_minimum(target, segment);
                Minimum {
                    uv: self.uv_at(s, s),
                    uv_off: self.uv_off(off),
                    ..found
                }
            }
        }
    }

    /// Its ends, as minima.
    pub(crate) fn ends(&self, shape: &CurveShape, target: &Target) -> [Minimum; 2] {
        let (points, turn) = match shape {
            CurveShape::Arc(arc) => (arc.ends, arc.turn.mid.hi),
            CurveShape::Segment(s) => ([s.a, s.b], 1.0),
        };
        [0, 1].map(|k| Minimum {
            range: target.range_at(&points[k]),
            point: points[k],
            uv: self.uv_at(k as f64, if k == 0 { 0.0 } else { turn }),
            uv_off: [0.0; 2],
            unique: true,
            extent: Extent::Root(0.0),
        })
    }

    /// How far the parameters found may be off, if the part of the curve is by `off`: by so much of its length, and a few
    /// roundings; not at its ends.
    fn uv_off(&self, off: f64) -> [f64; 2] {
        match self.uv {
            UvPath::Straight([a, b]) if off > 0.0 => std::array::from_fn(|k| {
                let size = a[k].abs().max(b[k].abs());
                (2.0 * off + 4.0 * f64::EPSILON) * (b[k] - a[k]).abs() + 4.0 * f64::EPSILON * size
            }),
            UvPath::Straight(_) => [0.0; 2],
            UvPath::Circle { .. } => [f64::INFINITY; 2],
        }
    }

    fn uv_at(&self, part: f64, a: f64) -> [f64; 2] {
        match self.uv {
            UvPath::Straight([from, to]) => std::array::from_fn(|k| {
                if part >= 1.0 {
                    to[k]
                } else {
                    from[k] + part * (to[k] - from[k])
                }
            }),
            UvPath::Circle { center, x, y } => {
                let (sin, cos) = crate::numeric::sin_cos(Ball::exact(a));
                std::array::from_fn(|k| center[k] + cos.mid.hi * x[k] + sin.mid.hi * y[k])
            }
        }
    }
}

/// A lower bound over a segment `a + s d`, in f64. A distance is least at some `s` in a range that is the foot's, cut to `[0, 1]` as
/// far as is known: the vectors from there, as one ball, bound it.
fn segment_least(target: &Target, [a, d]: &[Vector<f64>; 2]) -> Dd {
    match target {
        Target::Point(q) => {
            let w = sub(&exact(q), a);
            let foot = dot(&w, d) / dot(d, d);
            let s = if !(foot.rad < 1.0) {
                // As good as a point: anywhere on it.
                Ball { mid: 0.5, rad: 0.5 }
            } else if foot.upper() <= 0.0 {
                Ball::ZERO
            } else if foot.lower() >= 1.0 {
                Ball::ONE
            } else {
                foot
            };
            let w = along(&w, -s, d);
            least_square(dot(&w, &w).sqrt(), 0.0)
        }
        Target::Height(n, h) => {
            let n = exact(n);
            let at = dot(&n, a) - Ball::exact(*h);
            let ends = [at, at + dot(&n, d)].map(|x| range(x, 0.0)[0]);
            if ends[1] < ends[0] { ends[1] } else { ends[0] }
        }
    }
}

/// The minimum, the part of the segment where it is, and how far that may be off.
fn segment_minimum(target: &Target, segment: &SegmentShape) -> (Minimum, f64, f64) {
    let SegmentShape {
        a, b, d, length, ..
    } = segment;
    let length = *length;
    let at_end = |unique: bool, extent: Extent, least: Option<Dd>| {
        let [first, last] = [a, b].map(|p| target.range_at(p));
        let (point, s, end) = if last[1] < first[1] {
            (*b, 1.0, last)
        } else {
            (*a, 0.0, first)
        };
        let low = if last[0] < first[0] {
            last[0]
        } else {
            first[0]
        };
        let low = match least {
            Some(l) if l < low => l,
            _ => low,
        };
        let found = Minimum {
            range: [low, end[1]],
            point,
            uv: [0.0; 2],
            uv_off: [0.0; 2],
            unique,
            extent,
        };
        (found, s, 0.0)
    };
    match target {
        Target::Height(n, _) => {
            let slope = dot(&exact(n), d);
            let (length, slope) = (length.mid.hi, slope.mid.hi.abs() - slope.rad);
            if slope > 0.0 {
                let slope = slope / length;
                at_end(true, Extent::Linear { slope, length }, None)
            } else {
                at_end(false, Extent::Linear { slope: 0.0, length }, None)
            }
        }
        Target::Point(q) => {
            if !(length.lower() > 0.0) {
                // A point, or as good as one: no farther from its ends than its length.
                let (mut found, s, _) = at_end(true, Extent::Root(0.0), None);
                for x in &mut found.point {
                    x.rad += length.magnitude();
                }
                let low = found.range[0].sqrt() - Dd::from(2.0 * length.magnitude());
                found.range[0] = if low > Dd::ZERO { low * low } else { Dd::ZERO };
                found.range[0] =
                    found.range[0] - Dd::from(8.0 * Dd::UNIT * found.range[0].magnitude());
                return (found, s, 0.0);
            }
            let w = sub(&exact(q), a);
            let way = dot(&w, d);
            let part = way / length.square();
            let inside = part.lower() >= 0.0 && part.upper() <= 1.0;
            let outside = part.upper() < 0.0 || part.lower() > 1.0;
            if outside {
                return at_end(true, Extent::Root(0.0), None);
            }
            let foot = along(a, part, d);
            // Across the line, whatever part is off by: |w x d| / |d|.
            let cross: V3 = std::array::from_fn(|c| {
                let (i, j) = ((c + 1) % 3, (c + 2) % 3);
                w[i] * d[j] - w[j] * d[i]
            });
            let size = dot(&cross, &cross).sqrt();
            let mut found = distance_range(size / length, 0.0);
            // A segment as short as a rounding, as it joins the ends of trims, hardly has a direction; along it there is little to take off from the square of
            // how far its start is.
            let square = dot(&w, &w);
            if length.mid.hi <= SHORT * square.mid.hi.sqrt() {
                let across = square - (way / length).square();
                let other = distance_range(across.sqrt(), 0.0);
                // |w - s d|^2 >= |w|^2 - 2 max(0, w.d) on it.
                let off = (square.rad + 2.0 * way.upper().max(0.0)) * UP;
                let most = off + 4.0 * Dd::UNIT * square.mid.magnitude();
                for low in [other[0], square.mid - Dd::from(most)] {
                    if low > found[0] {
                        found[0] = low;
                    }
                }
                if other[1] < found[1] {
                    found[1] = other[1];
                }
            }
            if !inside {
                return at_end(false, Extent::Root(1.0), Some(found[0]));
            }
            let s = part.mid.hi;
            let found = Minimum {
                range: found,
                point: foot,
                uv: [0.0; 2],
                uv_off: [0.0; 2],
                unique: true,
                extent: Extent::Root(1.0),
            };
            (found, s, part.rad + f64::EPSILON)
        }
    }
}

impl CurveShape {
    /// Whether all of the curve is proven to be farther than `margin` from the line `origin + t direction`, in f64.
    ///
    /// The points are moved along the (nearly) unit `direction` into the plane across it through the origin, which a few
    /// roundings of their distance from the origin may spoil: `noise`. An arc of an angle below a right one lies within `R (1 - cos(angle / 2))` of
    /// its chord; halves of it are tried where that is too much.
    pub(crate) fn is_clear_of(&self, origin: &[f64; 3], direction: &[f64; 3], margin: f64) -> bool {
        let lead = |v: &V3| v.map(|x| x.mid.hi);
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let across = |v: [f64; 3]| -> [f64; 3] {
            let along = dot(&v, direction);
            std::array::from_fn(|c| v[c] - along * direction[c])
        };
        let from_origin = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| p[c] - origin[c]) };
        // The distance from zero to a segment, squared.
        let gap = |a: &[f64; 3], b: &[f64; 3]| {
            let d: [f64; 3] = std::array::from_fn(|c| b[c] - a[c]);
            let square = dot(&d, &d);
            let s = if square > 0.0 {
                (-dot(a, &d) / square).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let p: [f64; 3] = std::array::from_fn(|c| a[c] + s * d[c]);
            dot(&p, &p).sqrt()
        };
        let size = |p: &[f64; 3]| p.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let place = size(origin);
        match self {
            Self::Segment(s) => {
                let (a, b) = (lead(&s.a), lead(&s.b));
                let noise = CLEAR_NOISE * (place + size(&a) + size(&b));
                gap(&across(from_origin(a)), &across(from_origin(b))) > margin + noise
            }
            Self::Arc(arc) => {
                let (center, radius) = (lead(&arc.center), arc.radius.mid.hi);
                let noise = CLEAR_NOISE * (place + size(&center) + radius);
                let center = across(from_origin(center));
                let [x, y] = [&arc.x, &arc.y].map(|v| across(lead(v)));
                let at = |u: [f64; 2]| -> [f64; 3] {
                    std::array::from_fn(|c| center[c] + radius * (u[0] * x[c] + u[1] * y[c]))
                };
                // Quarters, the last one cut.
                let quarters = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
                let turn = arc.turn.mid.hi;
                let mut open = Vec::with_capacity(16);
                for k in 0..4 {
                    let start = k as f64 * std::f64::consts::FRAC_PI_2;
                    if start >= turn {
                        break;
                    }
                    let whole = k == 3 || start + std::f64::consts::FRAC_PI_2 <= turn;
                    // The last quarter is taken whole: a superset.
                    let end = if whole {
                        quarters[(k + 1) % 4]
                    } else {
                        arc.end.map(|x| x.mid.hi)
                    };
                    open.push((quarters[k], end, 0));
                }
                while let Some((u, w, depth)) = open.pop() {
                    let sum = [u[0] + w[0], u[1] + w[1]];
                    let cos = 0.5 * (sum[0] * sum[0] + sum[1] * sum[1]).sqrt();
                    let bulge = radius * (1.0 - cos).max(0.0);
                    if gap(&at(u), &at(w)) > margin + noise + bulge {
                        continue;
                    }
                    if depth == CLEAR_DEPTH {
                        return false;
                    }
                    let middle = sum.map(|x| 0.5 * x / cos);
                    open.push((u, middle, depth + 1));
                    open.push((middle, w, depth + 1));
                }
                true
            }
        }
    }
}

/// Covers some hundred roundings of lengths up to the sum it is applied to.
const CLEAR_NOISE: f64 = 1.0 / (1u64 << 45) as f64;
/// A quarter halved so often bulges by 2^-50 of its radius: below the noise.
const CLEAR_DEPTH: u32 = 25;
