//! Where a line meets a torus: the circle of the [model](super::revolution) turned about the axis at a distance above its radius.
//!
//! # The quartic
//! Relative to the centre let `r` be a point's distance from the axis and `h` its height. With the distances `c` of the circle's centre from the axis and `g` of the
//! point from the model's surface, beyond it or (negative) within, `F = (A - 2 c r) (A + 2 c r)`, `A = r^2 + h^2 + c^2 - R^2`, is
//! `g (g + 2 R) ((r + c)^2 + h^2 - R^2)`, and `A^2 - 4 c^2 r^2` is a quartic along a line. As `c > R` the last factor is positive. A point of the true surface has `|g| <= s`, the
//! slack, and so `|F| <= s (2 R + s) (2 c + 2 R)^2 = E`: `r <= c + R + s`, `|h| <= R + s`.
//!
//! So no hit is where `|F| > E`. The quartic's Bernstein coefficients tell such parts of the line, and parts where it is strictly monotone; on one of these, whose ends have
//! values beyond `E` of both signs, all `t` with `|F| <= E` are around its one root. What is nearly a tangent is left to the search.
//!
//! # One hit to a root
//! Move the profile's points `(a, b, h)` to `(a, x b, h)`, `x` from 1 to 0, and then to the model's circle. All the way it is a revolution with no more skew and slack, so
//! the hits on it are where `|F| <= E` and in the boxes of parameters found for these `t`. Let `N = S_u x S_v`. Where `N.d` has one sign for all of these parameters
//! and all surfaces on the way, hits there are simple and none comes or goes: there is one on the true surface as there is on the model. The model's `N` is `r R` times a
//! unit vector that turns by no more than the parameters do together; on the way `S_u` and `S_v`, whose lengths are about `r` and `R`, are off by `4 skew` at most. With boxes below 2^-16 wide,
//! skews below 2^-24 of `R` and of the least `r`, and a cosine between `N` and `d` above 2^-8 in the middle it has.
//!
//! # The last digits
//! Let `S` be the true surface's point at parameters `d` from those of the hit, at `t`, and `n` its normal. The surface curves away from its tangent plane by no more than half of
//! `r du^2 + 2 R du dv + R dv^2` (see [`at_foot`](RevolutionForm::at_foot)), so `n.(S - P(t'))`, with `P` the line's point, is `(t - t') n.d` up to that times `|n|`, and up to what the rounded
//! normal is off times `r du + R dv`.

use super::form::{V3, along, dot, sub};
use super::line::{ClosedHit, ClosedLine};
use super::revolution::{Profile, RevolutionForm};
use crate::numeric::{Ball, Dd};

/// Sums and products of a few dozen numbers in f64.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;
/// Coefficients in f64 are off by less than this part of the largest sum: each cut has four steps of three roundings of numbers up to twice it, all cuts together 576 units.
const ROUGH: f64 = 1.0 / (1u64 << 42) as f64;
/// Parts of the line are halved no more often: what is left is nearly a tangent.
const HALVINGS: usize = 24;
/// Where parts are cut: in the middle lines in round numbers have hits.
const CUT: f64 = 0.4876;
/// The part of a line, of all that is looked at, that a root is narrowed down to before its slope is taken for constant.
const NARROW: f64 = 1.0 / (1u64 << 30) as f64;
const STEPS: usize = 16;
/// See the module.
const MOST_BOX: f64 = 1.0 / (1u64 << 16) as f64;
const MOST_SKEW: f64 = 1.0 / (1u64 << 24) as f64;
const LEAST_COSINE: f64 = 1.0 / (1u64 << 8) as f64;
/// A torus's circle stays clear of the axis by this part of its radius.
const CLEAR: f64 = 1.0 + 1.0 / (1u64 << 10) as f64;

impl RevolutionForm {
    /// Whether it is part of a torus around a hole, and the formulas here are for it.
    pub(super) fn is_ring(&self) -> bool {
        match &self.fine.profile {
            Profile::Line { .. } => false,
            Profile::Arc { center, radius, .. } => {
                center[0].lower() > radius * CLEAR
                    && self.skew <= MOST_SKEW * radius.min(self.least_radius)
            }
        }
    }
}

/// A quartic in Bernstein form, in f64.
type Rough = [f64; 5];

/// Both parts of it.
fn cut(b: &Rough) -> [Rough; 2] {
    let (mut left, mut right) = ([0.0; 5], *b);
    for k in 0..5 {
        left[k] = right[0];
        for i in 0..4 - k {
            right[i] += (right[i + 1] - right[i]) * CUT;
        }
    }
    [left, right]
}

/// The quartic by powers of the parameter on `[0, 1]`.
struct Quartic {
    powers: [Ball<Dd>; 5],
}

impl Quartic {
    /// Along `p + s e`, relative to the torus's centre; `axis` is a unit vector.
    fn new(p: &V3, e: &V3, axis: &V3, c: Ball<Dd>, radius: f64) -> Self {
        let two = Ball::exact(2.0);
        let square = [dot(p, p), two * dot(p, e), dot(e, e)];
        let height = [dot(p, axis), dot(e, axis)];
        let c2 = c.square();
        let mut a = square;
        a[0] = a[0] + c2 - Ball::exact(radius).square();
        let four = Ball::exact(4.0) * c2;
        let across = [
            square[0] - height[0].square(),
            square[1] - two * height[0] * height[1],
            square[2] - height[1].square(),
        ];
        let product = [
            a[0].square(),
            two * a[0] * a[1],
            a[1].square() + two * a[0] * a[2],
            two * a[1] * a[2],
            a[2].square(),
        ];
        let less = |k: usize| match across.get(k) {
            Some(x) => product[k] - four * *x,
            None => product[k],
        };
        Self {
            powers: std::array::from_fn(less),
        }
    }

    /// Its Bernstein coefficients, rounded, and how far they may be off.
    fn rough(&self) -> (Rough, f64) {
        // `C(k, i) / C(4, i)`.
        const SHARES: [[f64; 5]; 5] = [
            [1.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, 0.25, 0.0, 0.0, 0.0],
            [1.0, 0.5, 1.0 / 6.0, 0.0, 0.0],
            [1.0, 0.75, 0.5, 0.25, 0.0],
            [1.0, 1.0, 1.0, 1.0, 1.0],
        ];
        let sum = |k: usize, x: &dyn Fn(&Ball<Dd>) -> f64| -> f64 {
            { self.powers.iter().zip(SHARES[k]) }
                .map(|(p, share)| x(p) * share)
                .sum()
        };
        let b = std::array::from_fn(|k| sum(k, &|p| p.mid.hi));
        let size = sum(4, &|p| p.magnitude());
        let known: f64 = self.powers.iter().map(|p| p.rad).sum();
        (b, (ROUGH * size + known) * UP)
    }

    /// Value and derivative.
    fn at(&self, s: Dd) -> [Ball<Dd>; 2] {
        let s = Ball { mid: s, rad: 0.0 };
        let (mut value, mut slope) = (Ball::ZERO, Ball::ZERO);
        for p in self.powers.iter().rev() {
            slope = slope * s + value;
            value = value * s + *p;
        }
        [value, slope]
    }

    /// A bound of the second derivative on `[0, 1]`, and for [`NARROW`] beyond.
    fn bend(&self) -> f64 {
        let p = self.powers.map(|x| x.magnitude());
        (2.0 * p[2] + 6.0 * p[3] + 12.0 * p[4]) * (1.0 + 8.0 * NARROW)
    }

    /// The root of the part of the line that `rough` is in, and how far from it `|F| <= error` may be, where `F` is monotone for [`NARROW`] to both sides: then what is found there is
    /// the part's own root, as `F` is monotone on both together.
    fn root(&self, rough: f64, error: f64) -> Option<(Dd, f64)> {
        let mut s = Dd::from(rough);
        for _ in 0..2 {
            let [value, slope] = self.at(s);
            let step = value.mid / slope.mid;
            if !step.hi.is_finite() {
                return None;
            }
            s = s - step;
        }
        if !((s.hi - rough).abs() < 0.5 * NARROW) {
            return None;
        }
        let [value, slope] = self.at(s);
        let steep = slope.lower().max(-slope.upper()) - self.bend() * NARROW;
        let off = (value.magnitude() + error) / steep * UP;
        (steep > 0.0 && off < 0.5 * NARROW).then_some((s, off))
    }
}

/// Where roots are in `[0, 1]`, about, one in each part where a quartic in this form is monotone; `None` where that is not told. Values of no more than `error` may be zero.
fn isolated(b: Rough, error: f64) -> Option<Vec<f64>> {
    let mut out = Vec::new();
    let mut open = vec![(b, 0.0, 1.0, 0)];
    while let Some((b, from, to, depth)) = open.pop() {
        if b.iter().all(|x| *x > error) || b.iter().all(|x| *x < -error) {
            continue;
        }
        let steps: [f64; 4] = std::array::from_fn(|k| b[k + 1] - b[k]);
        let rises = steps.iter().all(|x| *x > 2.0 * error);
        if rises || steps.iter().all(|x| *x < -2.0 * error) {
            if !(b[0].abs() > error && b[4].abs() > error) {
                return None;
            }
            if (b[0] < 0.0) != (b[4] < 0.0) {
                out.push(from + (to - from) * narrowed(&b));
            }
            continue;
        }
        if depth == HALVINGS {
            return None;
        }
        let middle = from + (to - from) * CUT;
        let [left, right] = cut(&b);
        open.push((right, middle, to, depth + 1));
        open.push((left, from, middle, depth + 1));
    }
    Some(out)
}

/// About where a monotone quartic is zero: Newton's method within a bracket that shrinks.
fn narrowed(b: &Rough) -> f64 {
    // Before de Casteljau's last step the two that are left tell the derivative.
    let jet = |s: f64| {
        let mut d = *b;
        for k in (2..5).rev() {
            for i in 0..k {
                d[i] += (d[i + 1] - d[i]) * s;
            }
        }
        [d[0] + (d[1] - d[0]) * s, 4.0 * (d[1] - d[0])]
    };
    let rises = b[4] > b[0];
    let (mut low, mut high, mut s) = (0.0, 1.0, b[0] / (b[0] - b[4]));
    for _ in 0..STEPS {
        let [x, slope] = jet(s);
        if (x < 0.0) == rises {
            low = s;
        } else {
            high = s;
        }
        let next = s - x / slope;
        if next == s {
            break;
        }
        s = if low <= next && next <= high {
            next
        } else {
            0.5 * (low + high)
        };
    }
    s
}

/// All meetings with a ring, those beyond its domain included; `None` where the line nearly touches it, or lies in it.
pub(super) fn hits(r: &RevolutionForm, line: &ClosedLine) -> Option<Vec<ClosedHit>> {
    let Profile::Arc { center, radius, .. } = &r.fine.profile else {
        return None;
    };
    let (c, d) = (center[0], &line.direction);
    let start = Ball::exact(line.middle) - Ball::exact(line.reach);
    let middle = along(&r.fine.origin, center[2], &r.fine.axis);
    let p = sub(&along(&line.origin, start, d), &middle);
    let length = Ball::exact(2.0) * Ball::exact(line.reach);
    let e: V3 = std::array::from_fn(|k| length * d[k]);
    let quartic = Quartic::new(&p, &e, &r.fine.axis, c, *radius);
    let wide = 2.0 * (c.magnitude() + radius + r.slack);
    let error = r.slack * (2.0 * radius + r.slack) * wide * wide * UP;
    let (rough, off) = quartic.rough();
    let all = off + error;
    if !all.is_finite() {
        return None;
    }
    let roots = isolated(rough, all)?;
    let mut out = Vec::with_capacity(roots.len());
    for s in roots {
        let (s, off) = quartic.root(s, error)?;
        let t = start + length * Ball { mid: s, rad: off };
        if let Some(hit) = hit(r, line, t)? {
            out.push(hit);
        }
    }
    Some(out)
}

/// The hit whose parameter is known about; nothing where it is beyond the domain, `None` where it is not told to be one.
fn hit(r: &RevolutionForm, line: &ClosedLine, t: Ball<Dd>) -> Option<Option<ClosedHit>> {
    let d = &line.direction;
    let w = along(&sub(&line.origin, &r.fine.origin), t, d);
    let Some((boxes, uv)) = r.locate(&w) else {
        return Some(None);
    };
    // Where the border of the domain is between what was moved into it and its box nothing is told.
    let [du, dv] = r.spread(uv, &boxes)?.map(|[most, _]| most);
    if !(du + dv <= MOST_BOX) {
        return None;
    }
    let n = r.normal(uv);
    let size = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let exactly = n.map(Ball::<Dd>::exact);
    let rate = dot(&exactly, d);
    let speed = size(&d.map(|x| x.mid.hi));
    if !(rate.mid.hi.abs() > LEAST_COSINE * size(&n) * speed) {
        return None;
    }
    let (far, round) = r.sizes();
    let bent = 0.5 * (far * du * du + 2.0 * round * du * dv + round * dv * dv);
    // The normal is the product of a unit vector and one as long as the radius, both rounded from double-double.
    let tilted = 16.0 * f64::EPSILON * far * (far * du + round * dv);
    let beside = (size(&n) * bent + tilted) * UP;
    let at = Ball {
        mid: t.mid,
        rad: 0.0,
    };
    let surface = r.point(uv);
    let apart = sub(&surface, &along(&line.origin, at, d));
    let gap = dot(&exactly, &apart);
    let gap = Ball {
        mid: gap.mid,
        rad: (gap.rad + beside) * UP,
    };
    let finer = at + gap / rate;
    let t = if finer.rad < t.rad { finer } else { t };
    Some(Some(ClosedHit {
        t,
        point: along(&line.origin, t, d),
        boxes,
        uv,
        touches: false,
    }))
}

#[cfg(test)]
mod tests {
    use super::super::form::exact;
    use super::*;
    use crate::numeric::Interval;
    use crate::nurbs::{Arc, Curve, Revolution};
    use dashu_ratio::RBig as Q;
    use nalgebra::{Point3, Rotation3, Vector3};

    /// Some roundings of points up to 8 from the origin, over a cosine of 2^-8.
    const NEAR: f64 = 1e-12;
    /// A skew of some 1e-15 over that cosine is how far off places are at first; its square over the cosine again, for a radius of 4.
    const FINE: f64 = 1e-20;
    /// A slope is taken for smaller by [`NARROW`] times the bend: 2^-30 times 35 at most over 0.04 at least, for the roots below. What curves up to 2^-34 from them is less.
    const LONGER: f64 = 1.0 + 1.0 / (1u64 << 20) as f64;

    /// The quartic with these roots, by powers.
    fn with_roots(roots: [f64; 4]) -> Quartic {
        let mut powers = [1.0, 0.0, 0.0, 0.0, 0.0];
        for r in roots {
            for k in (0..5).rev() {
                powers[k] = if k > 0 { powers[k - 1] } else { 0.0 } - r * powers[k];
            }
        }
        Quartic {
            powers: powers.map(Ball::exact),
        }
    }

    #[test]
    fn roots_are_told_from_each_other() {
        let found = |roots: [f64; 4]| {
            let (b, error) = with_roots(roots).rough();
            isolated(b, error)
        };
        let simple = [0.125, 0.4375, 0.5, 0.96875];
        let roots = found(simple).unwrap();
        assert_eq!(roots.len(), 4);
        for (s, truth) in roots.into_iter().zip(simple) {
            assert!((s - truth).abs() < NARROW, "{s}");
        }
        // Beyond the ends there is none; what is double is not told.
        assert!(found([-1.0, -0.5, 1.5, 2.0]).unwrap().is_empty());
        assert_eq!(found([-1.0, 0.25, 1.5, 2.0]).unwrap().len(), 1);
        assert!(found([0.25, 0.5, 0.5, 0.75]).is_none());
    }

    /// A circle turned all round an axis, of which no part is next to that.
    fn ring(origin: Point3<f64>, axis: Vector3<f64>, circle: Arc<3>) -> RevolutionForm {
        let whole = circle.angle;
        let revolution = Revolution {
            origin,
            axis,
            angle: whole,
            angle_domain: whole,
            profile: Curve::Arc(Arc::new(circle).unwrap()),
            transposed: false,
        };
        let form = RevolutionForm::new(&Revolution::new(revolution).unwrap(), 8.0).unwrap();
        assert!(form.is_ring());
        form
    }

    /// In rationals: lines along the axis of a torus whose circle's plane leans. With `x` the way from the axis to its centre and `v` the profile's parameter, the circle's point is
    /// `(c + R cos v) x + R sin v (s y + z) / sqrt(1 + s^2)`: with its distance `r` from the axis, its height `h` and `q = r^2 - s^2 h^2 = (c + R cos v)^2` it is
    /// `(sqrt q - c)^2 + (1 + s^2) h^2 = R^2`, without roots `(q + c^2 + (1 + s^2) h^2 - R^2)^2 = 4 c^2 q`.
    #[test]
    fn hits_with_a_torus_whose_profile_leans() {
        let q = |x: f64| Q::try_from(x).expect("a number");
        let whole = Interval::new(0.0, std::f64::consts::TAU).unwrap();
        let (center, radius) = (3.0, 0.75);
        for lean in [-1.0, 1.0, 0.125].map(|x| x / (1u64 << 46) as f64) {
            let circle = Arc {
                center: Point3::new(center, 0.0, 0.0),
                x: Vector3::x(),
                y: Vector3::new(0.0, lean, 1.0),
                z: Vector3::new(0.0, -1.0, lean),
                radius,
                angle: whole,
                domain: whole,
            };
            let form = ring(Point3::origin(), Vector3::z(), circle);
            let value = |square: &Q, h: &Q| {
                let (s2, h2) = (q(lean) * q(lean), h * h);
                let c2 = q(center) * q(center);
                let r2 = square - &s2 * &h2;
                let sum = &r2 + &c2 + (Q::ONE + s2) * h2 - q(radius) * q(radius);
                &sum * &sum - Q::from(4) * c2 * r2
            };
            for [x, y] in [[2.5, 0.25], [3.25, 0.125], [-3.0, 1.75], [0.5, -2.5]] {
                let line = ClosedLine {
                    origin: exact(&[x, y, 0.0]),
                    direction: exact(&[0.0, 0.0, 1.0]),
                    middle: 0.0,
                    reach: 1.0,
                };
                let square = q(x) * q(x) + q(y) * q(y);
                let found = hits(&form, &line).unwrap();
                assert_eq!(found.len(), 2, "{x} {y}");
                for hit in found {
                    let Dd { hi, lo } = hit.t.mid;
                    let [from, to] = [-hit.t.rad, hit.t.rad]
                        .map(|off| value(&square, &(q(hi) + q(lo) + q(off))) < Q::ZERO);
                    assert!(from != to, "{x} {y}: {:?}", hit.t);
                    assert!(hit.t.rad < FINE, "{x} {y}: {:?}", hit.t);
                }
            }
        }
    }

    /// In rationals: what has a value of no more than `error` beside a root is no farther from it than is told.
    #[test]
    fn roots_with_an_error_hold_all_values_up_to_it() {
        let q = |x: f64| Q::try_from(x).expect("a number");
        let exact = |x: Dd| q(x.hi) + q(x.lo);
        let magnitude = |x: Q| if x < Q::ZERO { -x } else { x };
        // Sums and products of these have few bits.
        let roots = [0.125, 0.4375, 0.75, 0.96875];
        let value = |s: &Q| roots.iter().fold(Q::ONE, |x, r| x * (s - q(*r)));
        for root in roots {
            for away in [-1.0, 1.0, -1024.0, 1024.0].map(|x| x / (1u64 << 44) as f64) {
                let place = q(root + away);
                let value = magnitude(value(&place));
                let error = value.to_f64().value().next_up();
                assert!(value <= q(error));
                let (s, off) = with_roots(roots).root(root, error).unwrap();
                let apart = magnitude(place - exact(s));
                assert!(apart <= q(off), "{root} {away:e}: {off:e}");
                assert!(off <= LONGER * away.abs(), "{root} {away:e}: {off:e}");
            }
        }
    }

    /// A line through two points of a torus has hits there, and as many in all as it has ends outside: an even number. Few of these lines are nearly tangents.
    #[test]
    fn lines_through_two_points_have_hits_there() {
        let interval = |a: f64, b: f64| Interval::new(a, b).unwrap();
        let whole = interval(0.0, std::f64::consts::TAU);
        let (mut told, count) = (0, 200);
        for n in 0..count {
            let unit = |k: usize| ((n * 37 + k * 61 + n * n * k) % 101) as f64 / 101.0;
            let frame = match n % 2 {
                0 => Rotation3::identity(),
                _ => Rotation3::new(Vector3::new(unit(1), unit(2), unit(3))),
            };
            let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|v| frame * v);
            let origin = Point3::new(1.0, -2.0, 0.5);
            let circle = Arc {
                center: origin + x * 3.0,
                x,
                y: z,
                z: -y,
                radius: 0.75,
                angle: whole,
                domain: whole,
            };
            let form = ring(origin, z, circle);
            let at = |k: usize| form.point([6.2 * unit(k), 6.2 * unit(k + 1)]);
            let [a, b] = [at(4), at(6)].map(|p| p.map(|x| x.mid.hi));
            let direction: [f64; 3] = std::array::from_fn(|c| b[c] - a[c]);
            let length = Vector3::from(direction).norm();
            let line = ClosedLine {
                origin: exact(&a),
                direction: exact(&direction),
                middle: 0.5,
                reach: 9.0 / length,
            };
            let Some(found) = (length > 0.5).then(|| hits(&form, &line)).flatten() else {
                continue;
            };
            told += 1;
            assert!(matches!(found.len(), 2 | 4), "{n}: {}", found.len());
            for end in [0.0, 1.0] {
                // The points were rounded, and the line is no nearer to a tangent than 2^-8.
                let near = |h: &ClosedHit| (h.t.mid.hi - end).abs() < NEAR;
                assert_eq!(found.iter().filter(|h| near(h)).count(), 1, "{n}");
            }
            assert!(found.iter().all(|h| h.t.rad < FINE), "{n}");
        }
        assert!(10 * told > 8 * count, "{told} of {count}");
    }
}
