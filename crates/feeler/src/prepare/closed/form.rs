//! What closed forms share: vectors with bounds, angles, the shape of an answer.

use super::super::circle::normalized;
use crate::numeric::{ATAN_ERROR, Ball, Dd, Interval, Real, atan2};
use arrayvec::ArrayVec;

/// What is minimised: the squared distance from a point, or `n.x - h`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Target {
    Point([f64; 3]),
    Height([f64; 3], f64),
}

impl Target {
    /// The value at a point.
    pub(crate) fn range_at<T: Real>(&self, p: &Vector<T>) -> [Dd; 2] {
        match self {
            Self::Point(q) => {
                let w = sub(&exact(q), p);
                distance_range(dot(&w, &w).sqrt(), 0.0)
            }
            Self::Height(n, h) => range(dot(&exact(n), p) - Ball::exact(*h), 0.0),
        }
    }
}

/// A vector or point with bounds, in one arithmetic.
pub(crate) type Vector<T> = [Ball<T>; 3];
/// The same in double-double.
pub(crate) type V3 = Vector<Dd>;

/// Makes up for the rounding of a bound that is computed in a few f64 operations.
pub(super) const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// `(|gap| - slack)^2` from below, or zero: the square of a distance.
pub(super) fn least_square(gap: Ball<f64>, slack: f64) -> Dd {
    let least = (gap.mid.abs() - (gap.rad + slack) * UP) * (1.0 - 4.0 * f64::EPSILON);
    if !(least > 0.0) {
        return Dd::ZERO;
    }
    let square = Dd::product(least, least);
    square - Dd::from(4.0 * Dd::UNIT * square.hi)
}

pub(crate) fn exact<T: Real>(v: &[f64]) -> Vector<T> {
    std::array::from_fn(|c| Ball::exact(v[c]))
}

/// Rounded to f64, with what that adds.
pub(super) fn rounded(v: &V3) -> Vector<f64> {
    v.map(lead)
}

pub(crate) fn lead(x: Ball<Dd>) -> Ball<f64> {
    Ball::from_dd(x.mid, x.rad)
}

#[inline]
pub(crate) fn dot<T: Real>(a: &Vector<T>, b: &Vector<T>) -> Ball<T> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub(crate) fn sub<T: Real>(a: &Vector<T>, b: &Vector<T>) -> Vector<T> {
    std::array::from_fn(|c| a[c] - b[c])
}

#[inline]
pub(crate) fn add<T: Real>(a: &Vector<T>, b: &Vector<T>) -> Vector<T> {
    std::array::from_fn(|c| a[c] + b[c])
}

#[inline]
pub(crate) fn scale<T: Real>(a: &Vector<T>, s: Ball<T>) -> Vector<T> {
    a.map(|x| x * s)
}

/// `a + s b`.
#[inline]
pub(crate) fn along<T: Real>(a: &Vector<T>, s: Ball<T>, b: &Vector<T>) -> Vector<T> {
    std::array::from_fn(|c| a[c] + s * b[c])
}

/// `v / |v|`; `None` where the length may be zero.
pub(crate) fn unit(v: &V3) -> Option<V3> {
    let out = normalized(v);
    out.iter().all(|x| x.rad < 1.0).then_some(out)
}

/// The point at a distance from one, against a direction: what that is off moves it by so much of the distance.
pub(super) fn at_gap<T: Real>(q: &[f64; 3], gap: Ball<T>, up: &Vector<T>) -> V3 {
    std::array::from_fn(|c| {
        let step = gap * up[c];
        Ball::exact(q[c]) - step.to_dd()
    })
}

/// `[(|D| - slack)^2, (|D| + slack)^2]`, the first not below zero: bounds of a squared distance.
pub(crate) fn distance_range<T: Real>(d: Ball<T>, slack: f64) -> [Dd; 2] {
    let d = d.to_dd();
    let size = d.mid.abs();
    // The sum, the square and their roundings: 2^-102 each, of what is at most the result.
    let off = (d.rad + slack) * UP + f64::MIN_POSITIVE;
    let unit = |x: Dd, sign: f64| x + Dd::from(sign * 4.0 * Dd::UNIT * x.magnitude());
    let low = size - Dd::from(off);
    let low = unit(low, -1.0);
    let high = unit(size + Dd::from(off), 1.0);
    let low = if low > Dd::ZERO {
        unit(low * low, -1.0)
    } else {
        Dd::ZERO
    };
    [low, unit(high * high, 1.0)]
}

/// `[mid - rad - slack, mid + rad + slack]`, outward.
pub(crate) fn range<T: Real>(x: Ball<T>, slack: f64) -> [Dd; 2] {
    let Ball { mid, rad } = x.to_dd();
    let off = (rad + slack + 4.0 * Dd::UNIT * mid.magnitude()) * UP;
    [mid - Dd::from(off), mid + Dd::from(off)]
}

/// A range of values, widened by a length: squared distances through their roots.
pub(crate) fn widened(target: &Target, r: [Dd; 2], slack: f64) -> [Dd; 2] {
    if slack == 0.0 {
        return r;
    }
    match target {
        Target::Height(..) => [
            range(
                Ball::<Dd> {
                    mid: r[0],
                    rad: 0.0,
                },
                2.0 * slack,
            )[0],
            range(
                Ball::<Dd> {
                    mid: r[1],
                    rad: 0.0,
                },
                2.0 * slack,
            )[1],
        ],
        Target::Point(_) => {
            // Roots are off by 2^-103 of themselves.
            let root = |x: Dd| {
                let root = x.sqrt();
                Ball {
                    mid: root,
                    rad: 4.0 * Dd::UNIT * root.magnitude(),
                }
            };
            [
                distance_range(root(r[0]), slack)[0],
                distance_range(root(r[1]), slack)[1],
            ]
        }
    }
}

/// An angle in f64, within `off`; where nothing is known `off` is infinite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Angle {
    pub(crate) at: f64,
    pub(crate) off: f64,
}

/// The angle of a vector from the x axis, in `[-pi, pi]`.
///
/// The leading parts of `x` and `y` are off by `2^-53` of their size and by the radii: in all by `e` at most, which turns a
/// vector of length `l >= 2 e` by less than `asin(e / (l - e)) <= 1.1 * 2 e / l`.
pub(crate) fn angle<T: Real>(y: Ball<T>, x: Ball<T>) -> Angle {
    let (a, b) = (x.mid.approximate(), y.mid.approximate());
    let l = a.abs().max(b.abs());
    let e = x.rad + y.rad + f64::EPSILON * l;
    let off = if 4.0 * e < l && l > f64::MIN_POSITIVE / f64::EPSILON {
        ATAN_ERROR + 2.5 * e / l
    } else {
        f64::INFINITY
    };
    Angle {
        at: atan2(b, a),
        off,
    }
}

/// `start + (x - from.start) (to length) / (from length)`: a native parameter from an angle, or the reverse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linear {
    pub(crate) from: Interval,
    pub(crate) to: Interval,
}

impl Linear {
    pub(crate) fn inverse(&self) -> Self {
        Self {
            from: self.to,
            to: self.from,
        }
    }

    pub(crate) fn at<T: Real>(&self, x: Ball<T>) -> Ball<T> {
        if x.rad == 0.0 {
            if x.mid == T::from_f64(self.from.start) {
                return Ball::exact(self.to.start);
            }
            if x.mid == T::from_f64(self.from.end) {
                return Ball::exact(self.to.end);
            }
        }
        if self.from == self.to {
            return x;
        }
        let s =
            (x - Ball::exact(self.from.start)) / Ball::difference(self.from.end, self.from.start);
        Ball::exact(self.to.start) + s * Ball::difference(self.to.end, self.to.start)
    }

    /// The image of a number, rounded a few times; of an end the end.
    pub(crate) fn rough(&self, x: f64) -> f64 {
        if x == self.from.start {
            self.to.start
        } else if x == self.from.end {
            self.to.end
        } else if self.from == self.to {
            x
        } else {
            let s = (x - self.from.start) / self.from.length();
            self.to.start + s * self.to.length()
        }
    }

    /// An interval that holds the image of one.
    pub(crate) fn range(&self, x: [f64; 2]) -> [f64; 2] {
        if self.from == self.to {
            return x;
        }
        // Ends go to ends exactly; else three roundings of numbers no larger than the ends.
        let scale = self.to.length() / self.from.length();
        if !(scale >= f64::MIN_POSITIVE / f64::EPSILON) {
            // A quotient that has lost digits.
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let size = self.to.start.abs().max(self.to.end.abs())
            + scale * (self.from.start.abs() + x[0].abs().max(x[1].abs()));
        let slack = 8.0 * f64::EPSILON * size;
        let map = |x: f64, sign: f64| {
            if x == self.from.start {
                self.to.start
            } else if x == self.from.end {
                self.to.end
            } else {
                self.to.start + (x - self.from.start) * scale + sign * slack
            }
        };
        [map(x[0], -1.0), map(x[1], 1.0)]
    }
}

/// Ranges of a parameter: the copies of one at whole turns, three at most.
pub(crate) type Copies = ArrayVec<[f64; 2], 3>;

/// Boxes of native parameters: each range of `u` with each of `v`.
#[derive(Clone, Debug)]
pub(crate) struct Boxes {
    pub(crate) u: Copies,
    pub(crate) v: Copies,
}

impl Boxes {
    pub(crate) fn one([u, v]: [[f64; 2]; 2]) -> Self {
        let only = |r| Copies::from_iter([r]);
        Self {
            u: only(u),
            v: only(v),
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        self.v.iter().flat_map(|v| self.u.iter().map(|u| [*u, *v]))
    }
}

/// Angles, and parameters in parts of their range, that are known within this are sharp: nine of f64's 53 bits are lost at most. A foot
/// found from them is off by about that part of its distance.
pub(super) const SHARP: f64 = 1.0 / (1u64 << 44) as f64;

/// Where an objective can have local minima in the interior of a surface: at most one point or, on a focal set, one curve or
/// all of it.
#[derive(Clone, Debug)]
pub(crate) struct Critical {
    /// In these boxes of native parameters, only.
    pub(crate) boxes: Boxes,
    /// What is there.
    pub(crate) minimum: Minimum,
    /// Whether the place is known to nearly all digits of f64.
    pub(crate) sharp: bool,
    /// The unit vector along which a distance grows, where it is sharp; of a height nothing.
    pub(crate) up: Vector<f64>,
}

/// A minimum of an objective over a closed form.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Minimum {
    /// Proven bounds of its value.
    pub(crate) range: [Dd; 2],
    /// Where, with a bound; nothing is known about where else where `unique` is not set.
    pub(crate) point: V3,
    /// Native parameters, rounded.
    pub(crate) uv: [f64; 2],
    /// How far these may be off; of use on boundary curves.
    pub(crate) uv_off: [f64; 2],
    /// Whether it is proven to be at `point` only.
    pub(crate) unique: bool,
    /// How far one may go from it before the objective grows by one: see `Extent`.
    pub(crate) extent: Extent,
}

/// How the points with an objective within `g` of a minimum extend from it; an estimate.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Extent {
    /// `reach * sqrt(g)`.
    Root(f64),
    /// `g / slope`, but no more than `length`.
    Linear { slope: f64, length: f64 },
    /// `around * sqrt(g)` along a circle, but no more than its `diameter`, or `along * sqrt(g)` across it.
    Ring {
        around: f64,
        diameter: f64,
        along: f64,
    },
}

impl Extent {
    /// The extent for a growth `g >= 0`.
    pub(crate) fn length(&self, g: f64) -> f64 {
        match *self {
            Self::Root(reach) => reach * g.sqrt(),
            Self::Linear { slope, length } => {
                if g >= slope * length {
                    length
                } else {
                    g / slope
                }
            }
            Self::Ring {
                around,
                diameter,
                along,
            } => {
                let root = g.sqrt();
                (around * root).min(diameter).max(along * root)
            }
        }
    }
}
