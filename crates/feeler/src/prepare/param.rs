//! How a native parameter runs over a Bezier piece.

use super::exact::dyadic;
use crate::numeric::{Ball, Dd, Real};
use std::cmp::Ordering;

/// The map between a piece's local parameter in `[0, 1]` and the native one, linear.
///
/// # Ends that are no f64
/// A piece of a poly-curve covers `[a, b]` of its segment's own parameters, numbers of f64, and the segment lies over `[c, d]` of the native
/// ones, linearly: the piece's native ends are rational numbers, and may be none of f64. They are not rounded, for that would move
/// the piece; they are kept as what they are made of (`Segment`), and all that is proven of native parameters is computed from that. So a
/// piece has the control points of the segment's own, and of two that follow one another in a segment the end of one is the start of the other,
/// exactly ([`meets`](Self::meets)).
///
/// `start` and `end` are the least and the greatest f64 on the piece. So an f64 is on the piece exactly if it is in `[start, end]`, each f64 of a
/// poly-curve's domain is on one of its pieces, and the border between two is between the end of the first and the start of the next, which are
/// neighbours in f64. A piece shorter than that may hold no f64: then `start > end`.
#[derive(Clone, Debug, PartialEq)]
pub struct ParamMap {
    /// The native parameter at local 0, or the least f64 above it.
    pub start: f64,
    /// The native parameter at local 1, or the greatest f64 below it.
    pub end: f64,
    /// Where an end is no f64, which is seldom.
    segment: Option<Box<Segment>>,
}

/// What the ends of a piece are, exactly: those of `part`, mapped linearly as `own` to `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    part: [f64; 2],
    own: [f64; 2],
    to: [f64; 2],
    /// Whether the native start, and the end, is an f64.
    exact: [bool; 2],
}

impl Segment {
    /// How much longer native lengths are than the segment's own.
    fn scale<T: Real>(&self) -> Ball<T> {
        Ball::difference(self.to[1], self.to[0]) / Ball::difference(self.own[1], self.own[0])
    }

    /// The native parameter of one of its own.
    fn native<T: Real>(&self, own: f64) -> Ball<T> {
        Ball::exact(self.to[0]) + Ball::difference(own, self.own[0]) * self.scale()
    }
}

impl ParamMap {
    /// From a native start to a native end.
    pub const fn new(start: f64, end: f64) -> Self {
        Self {
            start,
            end,
            segment: None,
        }
    }

    /// Of a piece that covers `part` of a segment's own parameters `own`, which lie over `to`, linearly. `None` for what is not finite.
    pub(super) fn of_segment(part: [f64; 2], own: [f64; 2], to: [f64; 2]) -> Option<Self> {
        if own == to {
            return Some(Self::new(part[0], part[1]));
        }
        let ends = [next_to(part[0], own, to)?, next_to(part[1], own, to)?];
        let exact = ends.map(|[below, above]| below == above);
        let [start, end] = [ends[0][1], ends[1][0]];
        let segment = Segment {
            part,
            own,
            to,
            exact,
        };
        Some(Self {
            start,
            end,
            segment: (exact != [true; 2]).then(|| Box::new(segment)),
        })
    }

    /// Whether local 1 of this and local 0 of another are the same native parameter.
    pub fn meets(&self, next: &Self) -> bool {
        match (&self.segment, &next.segment) {
            (Some(a), Some(b)) if !a.exact[1] && !b.exact[0] => {
                // Of other segments it is in the inside too, and so another.
                (a.own, a.to, a.part[1]) == (b.own, b.to, b.part[0])
            }
            (a, b) => {
                let exact =
                    a.as_ref().is_none_or(|a| a.exact[1]) && b.as_ref().is_none_or(|b| b.exact[0]);
                exact && self.end == next.start
            }
        }
    }

    /// The native parameter at local 0 or, with `end`, 1.
    pub fn border<T: Real>(&self, end: bool) -> Ball<T> {
        match &self.segment {
            Some(s) if !s.exact[usize::from(end)] => s.native(s.part[usize::from(end)]),
            _ => Ball::exact(if end { self.end } else { self.start }),
        }
    }

    /// The native length of the piece.
    pub fn length<T: Real>(&self) -> Ball<T> {
        match &self.segment {
            None => Ball::difference(self.end, self.start),
            Some(s) => Ball::difference(s.part[1], s.part[0]) * s.scale(),
        }
    }

    /// The local parameter of a native one: `(t - start) / (end - start)`; exact at ends that are f64.
    pub fn to_local<T: Real>(&self, t: Ball<T>) -> Ball<T> {
        let exact = { self.segment.as_ref() }.map_or([true; 2], |s| s.exact);
        if exact[0] && t.rad == 0.0 && t.mid == T::from_f64(self.start) {
            return Ball::ZERO;
        }
        if exact[1] && t.rad == 0.0 && t.mid == T::from_f64(self.end) {
            return Ball::ONE;
        }
        self.local(|x| t - Ball::exact(x), Ball::ONE)
    }

    /// The same of homogeneous numbers, `t w` and `w`: the local parameter times `w`. Where the weight is 1 it is as exact at ends.
    pub(super) fn local_of<T: Real>(&self, t: Ball<T>, w: Ball<T>) -> Ball<T> {
        if w.is_one() {
            return self.to_local(t);
        }
        self.local(|x| t - w * Ball::exact(x), w)
    }

    /// `from(x)` is `(t - x) w`.
    fn local<T: Real>(&self, from: impl Fn(f64) -> Ball<T>, w: Ball<T>) -> Ball<T> {
        let Some(s) = &self.segment else {
            return from(self.start) / Ball::difference(self.end, self.start);
        };
        // From a native parameter that is an f64: an end of the piece, or else the start of the segment.
        if s.exact[1] {
            w + from(self.end) / self.length()
        } else if s.exact[0] {
            from(self.start) / self.length()
        } else {
            let before = Ball::difference(s.part[0], s.own[0]);
            from(s.to[0]) / self.length() - w * (before / Ball::difference(s.part[1], s.part[0]))
        }
    }

    /// The native parameter of a local one.
    pub fn to_native_ball<T: Real>(&self, local: Ball<T>) -> Ball<T> {
        self.border(false) + local * self.length()
    }

    /// The native parameter of a local one, up to some roundings, never outside `[start, end]`. Next to an end its distance from that has all its digits, which are
    /// those of the parameter itself if the end is 0.
    pub fn to_native(&self, local: Dd) -> f64 {
        let length = self.end - self.start;
        let t = if local.hi < 0.5 {
            self.start + local.hi * length
        } else {
            // The first difference is exact.
            self.end - ((1.0 - local.hi) - local.lo) * length
        };
        self.nearest(t)
    }

    /// The same, rounded once as a rule: of a native parameter that is a number of f64 that number.
    pub fn nearest_native(&self, local: Dd) -> f64 {
        let native: Dd = match &self.segment {
            None => Dd::from(self.start) + local * Dd::difference(self.end, self.start),
            Some(_) => {
                let local = Ball {
                    mid: local,
                    rad: 0.0,
                };
                self.to_native_ball(local).mid
            }
        };
        self.nearest(native.hi)
    }

    /// Not `clamp`, which panics where there is no f64 on the piece.
    fn nearest(&self, t: f64) -> f64 {
        t.max(self.start).min(self.end)
    }

    /// A native interval that holds all of the piece: its ends, or the next f64 beyond.
    pub fn around(&self) -> [f64; 2] {
        match &self.segment {
            None => [self.start, self.end],
            Some(s) => [
                if s.exact[0] {
                    self.start
                } else {
                    self.start.next_down()
                },
                if s.exact[1] {
                    self.end
                } else {
                    self.end.next_up()
                },
            ],
        }
    }

    /// A native interval that holds the image of the local `[a, b]`, `0 <= a <= b <= 1`; exact at 0 and 1 where the ends are.
    pub fn to_native_range(&self, a: f64, b: f64) -> [f64; 2] {
        let around = self.around();
        // Three roundings of numbers no larger than the ends...
        let slack = 2.0 * f64::EPSILON * around[0].abs().max(around[1].abs());
        // ...and what the ends are off: less than the f64 next to them are apart, one rounding of the larger (or of the least numbers).
        let slack = match &self.segment {
            None => slack,
            Some(_) => 2.0 * slack + f64::MIN_POSITIVE,
        };
        let at = |local: f64, slack: f64| {
            if local <= 0.0 {
                around[0]
            } else if local >= 1.0 {
                around[1]
            } else {
                (1.0 - local) * self.start + local * self.end + slack
            }
        };
        [at(a, -slack), at(b, slack)]
    }
}

/// How a native parameter compares with the image of `own_parameter` where `own` is mapped to `to` linearly: exactly.
pub(super) fn order(
    native: f64,
    own_parameter: f64,
    own: [f64; 2],
    to: [f64; 2],
) -> Option<Ordering> {
    let apart = |a: f64, b: f64| Some(&dyadic(a)? - &dyadic(b)?);
    // Both sides times the length of `own`, which is above zero.
    let left = &apart(native, to[0])? * &apart(own[1], own[0])?;
    let right = &apart(own_parameter, own[0])? * &apart(to[1], to[0])?;
    Some(left.cmp(&right))
}

/// The greatest f64 at or below the image of a segment's own parameter, and the least at or above.
fn next_to(own_parameter: f64, own: [f64; 2], to: [f64; 2]) -> Option<[f64; 2]> {
    if own_parameter == own[0] {
        return Some([to[0]; 2]);
    }
    if own_parameter == own[1] {
        return Some([to[1]; 2]);
    }
    let is_below = |t: f64| Some(order(t, own_parameter, own, to)?.is_lt());
    let segment = Segment {
        part: [own_parameter; 2],
        own,
        to,
        exact: [false; 2],
    };
    let near = segment.native::<Dd>(own_parameter).mid.hi;
    let mut around = [near.next_down(), near.next_up()].map(rank);
    // Next to zero double-double may be off by many f64; and it may overflow.
    if !(near.is_finite() && is_below(of_rank(around[0]))? && !is_below(of_rank(around[1]))?) {
        around = to.map(rank);
    }
    // The first is below the image, the second is not.
    while around[0] + 1 < around[1] {
        let middle = around[0].midpoint(around[1]);
        around[usize::from(!is_below(of_rank(middle))?)] = middle;
    }
    let [below, above] = around.map(of_rank);
    let exact = order(above, own_parameter, own, to)?.is_eq();
    Some([if exact { above } else { below }, above])
}

/// The finite numbers of f64 in a row, -0 just below 0: their order is that of these whole numbers.
fn rank(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

/// The other way.
fn of_rank(rank: i64) -> f64 {
    f64::from_bits((rank ^ (((rank >> 63) as u64) >> 1) as i64) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dashu_ratio::RBig;

    /// In f64 the way back misses by some units of a number that is nearer to 0 than the ends.
    #[test]
    fn a_native_parameter_comes_back() {
        let (start, end) = (-0.527_071_077_530_392_8, 0.472_928_922_469_607_16);
        let map = ParamMap::new(start, end);
        for native in [-0.200_984_391_879_907_85, start, end, 1e-9, -3e-17] {
            let local = map.to_local(Ball::<Dd>::exact(native));
            assert_eq!(map.nearest_native(local.mid), native);
        }
    }

    /// Next to an end that is 0, from either side.
    #[test]
    fn a_native_parameter_next_to_zero_has_all_its_digits() {
        for k in 0..200 {
            let off = 0.73 * 0.7f64.powi(k);
            let part = Dd::from(off) / Dd::from(3.0);
            let ends = [ParamMap::new(-3.0, 0.0), ParamMap::new(0.0, 3.0)];
            let found = [ends[0].to_native(Dd::ONE - part), -ends[1].to_native(part)];
            for native in found {
                // Of a few roundings; and what is left of double-double's digits of 1.
                let slack = 4.0 * f64::EPSILON * off + 8.0 * Dd::UNIT;
                assert!((native + off).abs() <= slack, "{off:e}: {native:e}");
            }
        }
    }

    fn q(x: f64) -> RBig {
        RBig::try_from(x).unwrap()
    }

    /// A few operations, each with its rounding of at most some units.
    const ROUNDINGS: f64 = 64.0;
    /// What some operations that underflow may lose beside.
    const UNDERFLOWS: f64 = 1e-270;

    /// Whether a ball holds a number, no wider than some roundings of a number of this size.
    fn holds<T: Real>(b: Ball<T>, truth: &RBig, size: f64) -> bool {
        let (mid, _) = b.mid.to_dd();
        let off = q(mid.hi) + q(mid.lo) - truth;
        let rad = q(b.rad);
        b.rad <= ROUNDINGS * T::UNIT * size + UNDERFLOWS && -&rad <= off && off <= rad
    }

    /// Everything that a map says, against rationals.
    fn check(part: [f64; 2], own: [f64; 2], to: [f64; 2]) {
        let what = format!("{part:?} {own:?} {to:?}");
        let map = ParamMap::of_segment(part, own, to).unwrap();
        let scale = (q(to[1]) - q(to[0])) / (q(own[1]) - q(own[0]));
        let native = |x: &RBig| q(to[0]) + (x - q(own[0])) * &scale;
        let ends = part.map(|x| native(&q(x)));
        // The least and the greatest on the piece.
        assert!(
            q(map.start.next_down()) < ends[0] && ends[0] <= q(map.start),
            "{what}"
        );
        assert!(
            q(map.end) <= ends[1] && ends[1] < q(map.end.next_up()),
            "{what}"
        );
        let around = map.around();
        assert!(q(around[0]) <= ends[0] && ends[1] <= q(around[1]), "{what}");
        let size = to[0].abs().max(to[1].abs());
        for (k, end) in ends.iter().enumerate() {
            assert!(holds(map.border::<f64>(k == 1), end, size), "{what}");
            assert!(holds(map.border::<Dd>(k == 1), end, size), "{what}");
        }
        let length = &ends[1] - &ends[0];
        let long = length.to_f64().value();
        assert!(holds(map.length::<f64>(), &length, long), "{what}");
        assert!(holds(map.length::<Dd>(), &length, long), "{what}");
        let near = |x: f64| [x.next_down(), x, x.next_up()];
        let natives = [
            map.start,
            map.end,
            0.5 * (map.start + map.end),
            to[0],
            to[1],
        ];
        for t in natives.into_iter().flat_map(near) {
            let local = (q(t) - &ends[0]) / &length;
            // From the nearest end that is an f64, in parts of the piece.
            let size = (to[1] - to[0]).max((t - to[0]).abs()) / long + 1.0;
            // A homogeneous number is rounded before it is told from an end.
            let far = t.abs().max(to[0].abs()).max(to[1].abs()) / long;
            let (coarse, fine) = (Ball::<f64>::exact(t), Ball::<Dd>::exact(t));
            assert!(holds(map.to_local(coarse), &local, size), "{what} {t}");
            assert!(holds(map.to_local(fine), &local, size), "{what} {t}");
            let two = Ball::exact(2.0);
            let doubled = map.local_of(fine * two, two);
            assert!(
                holds(doubled, &(local.clone() * q(2.0)), 4.0 * size + 4.0 * far),
                "{what} {t}"
            );
            // On the piece as told by its ends.
            let on = RBig::ZERO <= local && local <= RBig::ONE;
            assert_eq!(map.start <= t && t <= map.end, on, "{what} {t}");
        }
        for [a, b] in [
            [0.0, 1.0],
            [0.25, 0.75],
            // Next to an end.
            [0.0, f64::UNIT * f64::UNIT],
            [0.999, 1.0],
            [0.5, 0.5],
        ] {
            let [low, high] = map.to_native_range(a, b).map(q);
            let [a, b] = [a, b].map(|x| &ends[0] + q(x) * &length);
            assert!(low <= a && b <= high, "{what}");
        }
        for local in [0.0, 0.3, 1.0] {
            let truth = &ends[0] + q(local) * &length;
            assert!(
                holds(map.to_native_ball(Ball::<Dd>::exact(local)), &truth, size),
                "{what}"
            );
            let local = Dd::from(local);
            let near = [map.to_native(local), map.nearest_native(local)];
            let on = |t: &f64| map.start <= *t && *t <= map.end;
            assert!(map.start > map.end || near.iter().all(on), "{what}");
        }
    }

    #[test]
    fn ends_of_pieces_of_poly_curves_are_exact() {
        let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
        let mut random = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for k in 0..500 {
            let size = 10f64.powi(k % 7 - 3);
            let own = [random() - 0.5, 0.5 + random()];
            let from = size * (random() - 0.5);
            let to = [from, from + random() + 0.01];
            let at = |s: f64| own[0] + s * (own[1] - own[0]);
            let inner = [0.1 + 0.3 * random(), 0.6 + 0.3 * random()].map(at);
            for part in [inner, [own[0], inner[0]], [inner[1], own[1]], own] {
                check(part, own, to);
            }
            let [a, b, c] = [[own[0], inner[0]], inner, [inner[1], own[1]]]
                .map(|part| ParamMap::of_segment(part, own, to).unwrap());
            assert!(a.meets(&b) && b.meets(&c) && !a.meets(&c) && !b.meets(&a));
        }
        let whole = [0.0, 3.0];
        for (part, own, to) in [
            // At zero, next to it, and far from both ends.
            ([1.0, 2.0], whole, [-0.1, 0.2]),
            ([1.0f64.next_down(), 2.0], whole, [-0.1, 0.2]),
            ([1.0f64.next_up(), 2.0], whole, [-0.1, 0.2]),
            ([1.0, 2.0], whole, [-0.1, 0.2f64.next_up()]),
            ([1.0, 2.0], whole, [-0.1, 0.2f64.next_down()]),
            ([0.1, 0.3], [0.0, 1.0], [1e9, 1e9 + 1.0]),
            // Shorter than what is between two f64.
            ([0.5, 0.5f64.next_up()], [0.0, 1.0], [1000.0, 1001.0]),
            ([0.3, 0.3f64.next_up()], [0.0, 1.0], [1000.0, 1001.0]),
            // Ends that are f64 after all.
            ([0.25, 0.75], [0.0, 1.0], [2.0, 4.0]),
            ([0.25, 0.7], [0.0, 1.0], [2.0, 4.0]),
            ([0.3, 0.7], [0.1, 0.9], [0.1, 0.9]),
        ] {
            check(part, own, to);
        }
    }

    #[test]
    fn what_is_no_number_has_no_map() {
        let whole = [0.0, 1.0];
        for part in [[f64::NAN, 1.0], [0.25, f64::INFINITY]] {
            assert_eq!(ParamMap::of_segment(part, whole, [1.0, 2.1]), None);
        }
    }
}
