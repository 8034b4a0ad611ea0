//! Native spheres: what lies nearest to a point, without the plane of the profile.
//!
//! A revolution of an arc whose centre is on the axis is on a sphere: every point of it is within `slack` of one, the slack of the
//! revolution's [model](super::revolution) and what the arc's centre is off the axis. So no point of the surface is nearer to `q` than
//! `||q - c| - R| - slack`, whatever its parameters and trims.
//!
//! *The foot.* Let `D = |q - c| > 0` and `p` the sphere's point towards `q`, or away from it for what is within. The surface's point
//! with the azimuth and the profile parameter of `p` is within `slack` of `p`, so where these parameters are in the face's region the distance is no
//! more than `|D - R| + slack`.
//!
//! *Where the nearest point is.* Of a point `x` of the surface let `y` be the sphere's with the same parameters and `psi` its angle from `p`
//! about `c`: `|q - y|^2 = (D - R)^2 + 2 R D (1 - cos psi)`. With `k` what the arc's centre is off the axis, turned with `x`, and `w` the unit vector from it to
//! `x`, `|x - c|^2 = R^2 + 2 R k.w + |k|^2`: between `x` and the point at `p`'s parameters that changes by no more than `4 R |k| psi` (of `k` across the profile's
//! plane `w` has `skew / R`, which is of the second order), and `x - y` turns by no more than `skew` over `R`. So where `x` is no farther from `q` than
//! that point, `psi` is at most `4 slack (1 / R + 1 / D)`, as `slack` counts `skew` once more than the model does and `|k|` twice: `x` is within
//! `4 slack (1 + R / D)` of `p`, be the face's region what it may.
//!
//! A [ball](super::revolution) is exactly on the sphere: it has no slack, and where the parameters of `p` are in the region `p` is its nearest point.

use super::form::{Linear, V3, Vector, rounded};
use super::revolution::{Profile, RevolutionForm};
use crate::numeric::{Ball, Dd, Real, atan2};

/// The sphere that a surface is on.
#[derive(Clone, Debug)]
pub(crate) struct SphereForm {
    center: V3,
    rough: [f64; 3],
    /// How far `rough` may be from the centre.
    rough_off: f64,
    pub(crate) radius: f64,
    /// How far points of the surface may be from the sphere, and from those of the same parameters; of a ball zero.
    pub(crate) slack: f64,
    /// How far parameters of the model are off those of a ball's points: as an angle, for one that is as far from the axis as from the centre.
    turn: f64,
    frame: [[f64; 3]; 3],
    /// The arc's axes along `e` and the revolution's axis.
    profile: [[f64; 2]; 2],
    angular: Linear,
    meridian: Linear,
    transposed: bool,
}

/// An arc's centre farther from the axis than this part of the radius is none of a sphere: the last digits of a double-double.
const ON_AXIS: f64 = 1e-30;
/// Angles of a foot are known within this, where anything is said of them...
const ANGLE: f64 = 1.0 / (1u64 << 36) as f64;
/// ...which is so where the vector from the centre, its part across the axis included, is known to this part of its length.
const DIRECTION: f64 = 1.0 / (1u64 << 40) as f64;
/// Below this the squares of vectors lose digits to underflow.
const LEAST_SQUARE: f64 = f64::MIN_POSITIVE / (f64::EPSILON * f64::EPSILON);

/// Angles beyond this lose digits by whole turns.
const MOST_ANGLE: f64 = 64.0;
const TURN: f64 = std::f64::consts::TAU;

/// Where the sphere's nearest point to a point is.
pub(crate) struct SphereFoot {
    /// From the centre.
    pub(crate) off: [f64; 3],
    /// The length of that.
    pub(crate) distance: f64,
    /// How far the true vector's end may be from that of `off`, and the true length from `distance`.
    pub(crate) error: f64,
    /// The angles about the axis and along the profile; within [`ANGLE`] of the foot's, and all within that of them is in the domain.
    angles: [f64; 2],
}

impl SphereForm {
    /// Of a revolution, if it is one of a sphere.
    pub(super) fn new(form: &RevolutionForm) -> Option<Self> {
        let Profile::Arc {
            center,
            x,
            y,
            radius,
            ..
        } = &form.fine.profile
        else {
            return None;
        };
        let is_ball = form.is_ball();
        let off_axis = if is_ball { 0.0 } else { center[0].magnitude() };
        let (angular, meridian) = (form.angular(), form.profile_map());
        let few_turns = [&angular, &meridian].iter().all(|m| {
            let i = m.from;
            -MOST_ANGLE <= i.start && i.end <= MOST_ANGLE
        });
        let turn = form.most_turn();
        if !(off_axis <= ON_AXIS * radius && turn <= DIRECTION && few_turns) {
            return None;
        }
        let model = &form.fine;
        let at: V3 = std::array::from_fn(|c| model.origin[c] + center[2] * model.axis[c]);
        let off = off_axis + center[1].magnitude();
        let slack = (form.slack + form.skew + 2.0 * off) * (1.0 + 8.0 * f64::EPSILON);
        let mid = |v: &V3| v.map(|x| x.mid.hi);
        let rough = rounded(&at);
        Some(Self {
            rough: rough.map(|x| x.mid),
            rough_off: rough.iter().map(|x| x.rad).sum::<f64>() * (1.0 + 8.0 * f64::EPSILON),
            center: at,
            radius: *radius,
            slack: if is_ball { 0.0 } else { slack },
            turn,
            frame: [mid(&model.e), mid(&model.b), mid(&model.axis)],
            profile: [x, y].map(|v| [v[0].mid.hi, v[2].mid.hi]),
            angular,
            meridian,
            transposed: form.transposed(),
        })
    }

    /// How far a point is outside of the sphere.
    pub(crate) fn gap(&self, q: &[f64; 3]) -> Ball<Dd> {
        let w: V3 = std::array::from_fn(|c| Ball::exact(q[c]) - self.center[c]);
        length(&w) - Ball::exact(self.radius)
    }

    /// The foot of a point; `None` where f64 does not tell, or where its parameters are next to the border of the domain.
    ///
    /// With `U = EPSILON / 2` the differences are off by `U` of their magnitudes, whose sum is at most `3^(1/2)` times the length: with the centre's own
    /// error by `rough_off + EPSILON D`, and so is the length. Squares, sums and root add `5/2 U D`, and what is of the second order is below the half
    /// `EPSILON` that is left of the three.
    ///
    /// Products and sums for one component along the frame are off by six roundings of the vector's length, and the frame's vectors, known
    /// as well as `turn` says, by as much again: so all parts of a direction by less than `DIRECTION`, and angles by twice that,
    /// [`ATAN_ERROR`](crate::numeric::ATAN_ERROR) and `turn`, which for a ball counts by as much as the vector is longer than its part across the axis: all told below `ANGLE / 2`. The other half is for whole turns and for what the nearest
    /// point is off.
    #[inline]
    pub(crate) fn foot(&self, q: &[f64; 3]) -> Option<SphereFoot> {
        let w: [f64; 3] = std::array::from_fn(|c| q[c] - self.rough[c]);
        let squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
        let distance = squared.sqrt();
        let [e, b, h] = self
            .frame
            .each_ref()
            .map(|f| w[0] * f[0] + w[1] * f[1] + w[2] * f[2]);
        let rho = (e * e + b * b).sqrt();
        let error = self.rough_off + 3.0 * f64::EPSILON * distance;
        let rounded = 16.0 * f64::EPSILON + 2.0 * self.turn;
        let known = 2.0 * error + 4.0 * self.slack + rounded * distance;
        if !(known < DIRECTION * rho && squared > LEAST_SQUARE) {
            return None;
        }
        let [x, y] = self.profile.map(|a| rho * a[0] + h * a[1]);
        let angles = [
            turned(atan2(b, e), &self.angular)?,
            turned(atan2(y, x), &self.meridian)?,
        ];
        Some(SphereFoot {
            off: w,
            distance,
            error,
            angles,
        })
    }

    /// The native parameters of a foot, to f64, and in the domain.
    pub(crate) fn uv(&self, foot: &SphereFoot) -> [f64; 2] {
        let native = |map: &Linear, at: f64| map.rough(at).clamp(map.to.start, map.to.end);
        self.in_order([
            native(&self.angular, foot.angles[0]),
            native(&self.meridian, foot.angles[1]),
        ])
    }

    /// A box of native parameters that holds those of the foot, and others all around.
    pub(crate) fn around(&self, foot: &SphereFoot) -> [[f64; 2]; 2] {
        let range = |map: &Linear, at: f64| map.range([at - ANGLE, at + ANGLE]);
        self.in_order([
            range(&self.angular, foot.angles[0]),
            range(&self.meridian, foot.angles[1]),
        ])
    }

    fn in_order<T>(&self, [angular, meridian]: [T; 2]) -> [T; 2] {
        if self.transposed {
            [meridian, angular]
        } else {
            [angular, meridian]
        }
    }

    /// How far the nearest point of the surface may be from the sphere's, in units of the slack.
    pub(crate) fn shift(&self, distance: f64) -> f64 {
        4.0 * self.slack * (1.0 + self.radius / distance) * (1.0 + 8.0 * f64::EPSILON)
    }
}

fn length<T: Real>(w: &Vector<T>) -> Ball<T> {
    (w[0].square() + w[1].square() + w[2].square()).sqrt()
}

/// An angle moved into a range by whole turns; `None` if what is within [`ANGLE`] of it is not in there. The roundings of numbers up
/// to [`MOST_ANGLE`], ten in number, are below another `ANGLE`.
fn turned(at: f64, map: &Linear) -> Option<f64> {
    let range = map.from;
    let mut at = at;
    while at - TURN >= range.start {
        at -= TURN;
    }
    while at < range.start {
        at += TURN;
    }
    (at > range.start + 2.0 * ANGLE && at < range.end - 2.0 * ANGLE).then_some(at)
}
