//! What closed forms share: vectors with bounds, angles, the shape of an answer.

use super::super::circle::normalized;
use crate::numeric::{ATAN_ERROR, Ball, Dd, Interval, Real, atan2};

/// What is minimised: the squared distance from a point, or `n.x - h`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Target {
    Point(V3),
    Height(V3, Ball<Dd>),
}

impl Target {
    /// The value at a point.
    pub(crate) fn range_at(&self, p: &V3) -> [Dd; 2] {
        match self {
            Self::Point(q) => {
                let w = sub(q, p);
                distance_range(dot(&w, &w).sqrt(), 0.0)
            }
            Self::Height(n, h) => range(dot(n, p) - *h, 0.0),
        }
    }
}

/// A vector or point with bounds.
pub(crate) type V3 = [Ball<Dd>; 3];

/// Makes up for the rounding of a bound that is computed in a few f64 operations.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// A vector rounded to f64, and how far it may be from the true one in each coordinate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rough {
    pub(super) v: [f64; 3],
    off: f64,
}

impl Rough {
    pub(super) fn new(v: &V3) -> Self {
        let off = v.iter().map(|x| x.rad + x.mid.lo.abs());
        Self {
            v: v.map(|x| x.mid.hi),
            off: off.fold(0.0, f64::max) * UP,
        }
    }

    pub(super) fn exact(v: [f64; 3]) -> Self {
        Self { v, off: 0.0 }
    }

    pub(super) fn off(&self) -> f64 {
        self.off
    }

    /// The scalar product with another, and a bound on its error: `u = 2^-53`; three products and two sums of parts, each off by
    /// three roundings at most, and what the vectors are off.
    pub(super) fn dot(&self, o: &Self) -> (f64, f64) {
        let (mut sum, mut size, mut left, mut right) = (0.0, 0.0, 0.0, 0.0);
        for c in 0..3 {
            let x = self.v[c] * o.v[c];
            sum += x;
            size += x.abs();
            left += self.v[c].abs();
            right += o.v[c].abs();
        }
        let off = 4.0 * f64::EPSILON * size + self.off * (right + 3.0 * o.off) + o.off * left;
        (sum, off * UP + f64::MIN_POSITIVE)
    }

    /// The difference of two.
    pub(super) fn sub(&self, o: &Self) -> Self {
        let v: [f64; 3] = std::array::from_fn(|c| self.v[c] - o.v[c]);
        let most = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        Self {
            v,
            off: (self.off + o.off + f64::EPSILON * most) * UP,
        }
    }
}

/// `(gap - off)^2` from below, or zero: the square of a distance of which `gap` is known within `off`.
pub(super) fn least_square(gap: f64, off: f64) -> Dd {
    let least = (gap.abs() - off) * (1.0 - 4.0 * f64::EPSILON);
    if !(least > 0.0) {
        return Dd::ZERO;
    }
    let square = Dd::product(least, least);
    square - Dd::from(4.0 * Dd::UNIT * square.hi)
}

pub(crate) fn exact(v: &[f64]) -> V3 {
    std::array::from_fn(|c| Ball::exact(v[c]))
}

pub(crate) fn dot(a: &V3, b: &V3) -> Ball<Dd> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn sub(a: &V3, b: &V3) -> V3 {
    std::array::from_fn(|c| a[c] - b[c])
}

pub(crate) fn add(a: &V3, b: &V3) -> V3 {
    std::array::from_fn(|c| a[c] + b[c])
}

pub(crate) fn scale(a: &V3, s: Ball<Dd>) -> V3 {
    a.map(|x| x * s)
}

/// `a + s b`.
pub(crate) fn along(a: &V3, s: Ball<Dd>, b: &V3) -> V3 {
    std::array::from_fn(|c| a[c] + s * b[c])
}

/// `v / |v|`; `None` where the length may be zero.
pub(crate) fn unit(v: &V3) -> Option<V3> {
    let out = normalized(v);
    out.iter().all(|x| x.rad < 1.0).then_some(out)
}

/// `[(|D| - slack)^2, (|D| + slack)^2]`, the first not below zero: bounds of a squared distance.
pub(crate) fn distance_range(d: Ball<Dd>, slack: f64) -> [Dd; 2] {
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
pub(crate) fn range(x: Ball<Dd>, slack: f64) -> [Dd; 2] {
    let off = (x.rad + slack + 4.0 * Dd::UNIT * x.mid.magnitude()) * UP;
    [x.mid - Dd::from(off), x.mid + Dd::from(off)]
}

/// A range of values, widened by a length: squared distances through their roots.
pub(crate) fn widened(target: &Target, r: [Dd; 2], slack: f64) -> [Dd; 2] {
    if slack == 0.0 {
        return r;
    }
    match target {
        Target::Height(..) => [
            range(
                Ball {
                    mid: r[0],
                    rad: 0.0,
                },
                2.0 * slack,
            )[0],
            range(
                Ball {
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
pub(crate) fn angle(y: Ball<Dd>, x: Ball<Dd>) -> Angle {
    let (a, b) = (x.mid.hi, y.mid.hi);
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
    pub(crate) fn at(&self, x: Ball<Dd>) -> Ball<Dd> {
        if x.rad == 0.0 {
            if x.mid == Dd::from(self.from.start) {
                return Ball::exact(self.to.start);
            }
            if x.mid == Dd::from(self.from.end) {
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

/// Where an objective can have local minima in the interior of a surface.
#[derive(Clone, Debug)]
pub(crate) enum Critical {
    /// Nowhere.
    None,
    /// In these boxes of native parameters, only: at most one point or, on a focal set, one curve or all of it.
    Boxes {
        boxes: Vec<[[f64; 2]; 2]>,
        /// What is there.
        minimum: Minimum,
    },
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
        }
    }
}
