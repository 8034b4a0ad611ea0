//! Points through poses, with bounds of what is rounded.
//!
//! A pose is a quaternion and a translation, all exact numbers; the quaternion `(w, v)` stands for the rotation by its exact
//! normalisation, `x -> x + 2 (w (v x x) + v x (v x x)) / (w^2 + |v|^2)`.
//!
//! # Bound of a rotation
//! Let u = 2^-53, N = w^2 + |v|^2, and write errors to first order; what is left out is below 2^-40 of them.
//! - `a = v x x`: each coordinate is off by at most 2u (|v_i x_j| + |v_j x_i|) <= 2u |v||x|, the vector by 3.5u |v||x|.
//! - `w a`: 3.5u from `a` and u from the product, of |w||v||x| <= N|x| / 2: 2.3u N|x|.
//! - `v x a`: 3.5u from `a` and 3.5u of its own, of |v|^2|x| <= N|x|: 7u N|x|.
//! - their sum is at most 1.5 N|x| long and is rounded once: all in all 10.8u N|x|.
//! - `2 / N`: 4u from N and u from the quotient; times the sum u more: 6u of 3|x|, 18u |x|; and the error of the sum 21.6u |x|.
//! - adding `x` gives a vector as long as `x`, rounded once: u |x|.
//!
//! In all 40.6u |x|; the bound is 48u. Products that underflow are off by at most 2^-1074 each: 1e-280 more covers them where
//! N is not below 2^-100, and other quaternions have an infinite bound, as have those that are not finite.

use parry3d_f64::math::{Pose, Rotation, Vector};

/// Half a unit in the last place of 1.
const U: f64 = f64::EPSILON / 2.0;
/// What a rotation may be off, relative to the length of the vector.
const ROTATION: f64 = 48.0 * U;
/// Far above what is lost by underflow.
const TINY: f64 = 1e-280;
/// The least square of a quaternion's length that is taken.
const LEAST: f64 = 1.0 / (1u128 << 100) as f64;
/// A length computed by a few operations, rounded up.
const UP: f64 = 1.0 + 16.0 * U;

/// A point or a direction, and how far it may be from the true one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// The rounded point.
    pub point: Vector,
    /// Proven bound of its distance from the true one, in the same unit; infinite where there is none.
    pub bound: f64,
}

impl Placed {
    /// A point that is not rounded.
    pub fn exact(point: Vector) -> Self {
        Self { point, bound: 0.0 }
    }

    /// No bound at all where a number is none.
    fn within(point: Vector, bound: f64) -> Self {
        let known = point.is_finite() && bound.is_finite();
        Self {
            point,
            bound: if known { bound } else { f64::INFINITY },
        }
    }

    fn plus(self, by: Vector) -> Self {
        let point = self.point + by;
        Self::within(point, up(self.bound + U * length(point) + TINY))
    }
}

/// The length of a vector, also where squares of its coordinates are below all numbers; rounded.
pub(crate) fn length(v: Vector) -> f64 {
    /// Squares of what is above it are normal numbers.
    const SMALL: f64 = 1e-150;
    let direct = v.length();
    if !(direct < SMALL) {
        return direct;
    }
    match v.abs().max_element() {
        0.0 => 0.0,
        scale => scale * (v / scale).length(),
    }
}

/// A sum of nonnegative terms, rounded up.
pub(crate) fn up(x: f64) -> f64 {
    x * UP
}

/// A vector turned by a quaternion's exact normalisation.
pub fn rotate(q: &Rotation, x: Vector) -> Placed {
    let (w, v) = (q.w, Vector::new(q.x, q.y, q.z));
    let square = w * w + v.dot(v);
    let a = v.cross(x);
    let sum = a * w + v.cross(a);
    let point = x + sum * (2.0 / square);
    let bound = up(ROTATION * length(x) + TINY);
    let known = square.is_finite() && square >= LEAST;
    Placed::within(point, if known { bound } else { f64::INFINITY })
}

/// The same turned back.
pub fn rotate_back(q: &Rotation, x: Vector) -> Placed {
    rotate(&Rotation::from_xyzw(-q.x, -q.y, -q.z, q.w), x)
}

/// A point of the pose's own frame in the frame that it stands in.
pub fn out_of(pose: &Pose, x: Vector) -> Placed {
    if x == Vector::ZERO {
        return Placed::exact(pose.translation);
    }
    rotate(&pose.rotation, x).plus(pose.translation)
}

/// A point in the pose's own frame.
pub fn into(pose: &Pose, x: Vector) -> Placed {
    let off = x - pose.translation;
    let turned = rotate_back(&pose.rotation, off);
    // The difference is rounded once, and a rotation keeps lengths.
    Placed::within(turned.point, up(turned.bound + U * length(off) + TINY))
}

/// Which of the two shapes of a pair is the BREP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The first.
    First,
    /// The second.
    Second,
}

/// Where the other shape of a pair is, seen from the BREP.
#[derive(Clone, Copy, Debug)]
pub struct Placement<'a> {
    /// The pose of the second shape in the frame of the first.
    pub pos12: &'a Pose,
    /// Which one is the BREP.
    pub order: Order,
}

impl Placement<'_> {
    /// A point of the other shape's frame in the BREP's.
    pub fn to_brep(self, x: Vector) -> Placed {
        match self.order {
            Order::First => out_of(self.pos12, x),
            Order::Second => into(self.pos12, x),
        }
    }

    /// A direction of the other shape's frame in the BREP's.
    pub fn turn_to_brep(self, x: Vector) -> Placed {
        match self.order {
            Order::First => rotate(&self.pos12.rotation, x),
            Order::Second => rotate_back(&self.pos12.rotation, x),
        }
    }

    /// A direction of the BREP's frame in the other shape's, rounded.
    pub(crate) fn turn_to_other(self, x: Vector) -> Vector {
        match self.order {
            Order::First => rotate_back(&self.pos12.rotation, x).point,
            Order::Second => rotate(&self.pos12.rotation, x).point,
        }
    }

    /// A point of the BREP's frame in the other shape's, rounded.
    pub(crate) fn to_other(self, x: Vector) -> Vector {
        match self.order {
            Order::First => into(self.pos12, x).point,
            Order::Second => out_of(self.pos12, x).point,
        }
    }
}
