//! When a moving ball meets a BREP: conservative advancement.
//!
//! # What is certified
//! As long as the ball has moved by no more than the lower bound of its separation less the distance that is sought, it is not
//! nearer than that distance. So time is moved on by that way over a bound of the speed, rounded down, again and again; no contact is
//! before the time that comes out, and there the separation is at most the distance sought plus the tolerance (2^-36 of the
//! size). (Mirtich, *Impulse-based Dynamic Simulation of Rigid Body Systems*, 1996, whose bound is on the
//! estimated time of arrival.) Head on, two steps do; along a face the way shrinks by a factor at each step, and the status
//! says where the steps ran out.

use crate::ball::{ball_at, separation_at};
use crate::pair::{Ask, Memory, PairContact};
use crate::pose::{Order, Placed, Placement, up};
use crate::shape::BrepShape;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{NonlinearRigidMotion, ShapeCastHit, ShapeCastStatus};
use parry3d_f64::shape::PackedFeatureId;

/// How near to the distance sought is there, in sizes.
const THERE: f64 = 1.0 / (1u64 << 36) as f64;
/// Most steps.
const MOST: usize = 2000;
/// A quotient rounded down.
const DOWN: f64 = 1.0 - 8.0 * f64::EPSILON;

/// A hit in the BREP's terms.
struct Met {
    time: f64,
    contact: PairContact,
    status: ShapeCastStatus,
}

/// A ball's way past a BREP.
trait Way {
    /// The centre in the BREP's frame.
    fn center(&self, time: f64) -> Placed;
    /// How long the ball takes, at the least, to come nearer by this from where it is.
    fn least_time(&self, center: &Placed, way: f64) -> f64;
    /// Its velocity in the BREP's frame, for the sign alone.
    fn velocity(&self, time: f64) -> Vector;
}

fn contact_at(
    shape: &BrepShape,
    center: Placed,
    radius: f64,
    memory: &mut Memory,
) -> Option<PairContact> {
    let ask = Ask {
        placement: Placement {
            pos12: &Pose::IDENTITY,
            order: Order::First,
        },
        prediction: f64::INFINITY,
        several: false,
    };
    let feature = PackedFeatureId::face(0);
    ball_at(shape, &ask, center, radius, feature, memory)
        .contacts
        .first()
        .copied()
}

/// What is sought: from when to when, the distance, and whether an overlap at the start counts whichever way the ball goes.
struct Sought {
    start: f64,
    end: f64,
    distance: f64,
    stop_at_penetration: bool,
}

fn advance(shape: &BrepShape, way: &dyn Way, radius: f64, sought: &Sought) -> Option<Met> {
    let mut memory = Memory::default();
    let there = THERE * shape.brep().size();
    let mut time = sought.start;
    for step in 0..MOST {
        let center = way.center(time);
        let separation = separation_at(shape, center, radius, &mut memory);
        let free = separation.bounds.lo - sought.distance;
        // Bounds that say nothing leave the ball where it is.
        if !(free > there) {
            let contact = contact_at(shape, center, radius, &mut memory)?;
            let inside = step == 0 && separation.value <= sought.distance;
            if inside
                && !sought.stop_at_penetration
                && contact.normal.dot(way.velocity(time)) >= 0.0
            {
                return None;
            }
            let status = if inside {
                ShapeCastStatus::PenetratingOrWithinTargetDist
            } else {
                ShapeCastStatus::Converged
            };
            return Some(Met {
                time,
                contact,
                status,
            });
        }
        let step = way.least_time(&center, free) * DOWN;
        time = (time + step).next_down().max(time);
        if !(time <= sought.end) {
            return None;
        }
    }
    let contact = contact_at(shape, way.center(time), radius, &mut memory)?;
    Some(Met {
        time,
        contact,
        status: ShapeCastStatus::OutOfIterations,
    })
}

fn hit(met: &Met, order: Order, radius: f64, other: impl Fn(Vector) -> Vector) -> ShapeCastHit {
    let c = &met.contact;
    let normal = other(-c.normal);
    let found = ShapeCastHit {
        time_of_impact: met.time,
        witness1: c.on_brep,
        witness2: normal * radius,
        normal1: c.normal,
        normal2: normal,
        status: met.status,
        subshape1: 0,
        subshape2: 0,
    };
    match order {
        Order::First => found,
        Order::Second => found.swapped(),
    }
}

struct Straight<'a> {
    placement: Placement<'a>,
    velocity: Vector,
    speed: f64,
}

impl Way for Straight<'_> {
    fn center(&self, time: f64) -> Placed {
        let pos12 = Pose {
            translation: self.placement.pos12.translation + self.velocity * time,
            ..*self.placement.pos12
        };
        let moved = Placement {
            pos12: &pos12,
            order: self.placement.order,
        };
        let at = moved.to_brep(Vector::ZERO);
        let rounding = f64::EPSILON * (pos12.translation.length() + self.speed * time);
        Placed {
            point: at.point,
            bound: up(at.bound + rounding),
        }
    }

    fn least_time(&self, _: &Placed, way: f64) -> f64 {
        way / self.speed
    }

    fn velocity(&self, _: f64) -> Vector {
        match self.placement.order {
            Order::First => self.velocity,
            Order::Second => self.placement.turn_to_brep(-self.velocity).point,
        }
    }
}

/// Along a straight line, as Parry's `cast_shapes`: the second shape moves in the frame of the first.
pub(crate) fn straight(
    shape: &BrepShape,
    placement: Placement<'_>,
    velocity: Vector,
    radius: f64,
    options: &ShapeCastOptions,
) -> Option<ShapeCastHit> {
    let way = Straight {
        placement,
        velocity,
        speed: up(velocity.length()),
    };
    let sought = Sought {
        start: 0.0,
        end: options.max_time_of_impact,
        distance: options.target_distance,
        stop_at_penetration: options.stop_at_penetration,
    };
    let met = advance(shape, &way, radius, &sought)?;
    let other = |v: Vector| placement.turn_to_other(v);
    Some(hit(&met, placement.order, radius, other))
}

/// Both bodies move and turn.
struct Turning<'a> {
    brep: &'a NonlinearRigidMotion,
    ball: &'a NonlinearRigidMotion,
    /// Bound of the speed of the ball's centre relative to that of the BREP's.
    speed: f64,
    /// Of the BREP's turning.
    spin: f64,
}

impl Way for Turning<'_> {
    fn center(&self, time: f64) -> Placed {
        let at = self.ball.position_at_time(time).translation;
        crate::pose::into(&self.brep.position_at_time(time), at)
    }

    /// While the ball comes nearer by w, it moves by at most w against the BREP's centre, from which it is then at most
    /// D + w away: in the BREP's frame it is no faster than V + spin (D + w).
    fn least_time(&self, center: &Placed, way: f64) -> f64 {
        let from = (center.point - self.brep.local_center).length() + center.bound;
        way / up(self.speed + self.spin * (from + way))
    }

    fn velocity(&self, time: f64) -> Vector {
        let later = (time.abs() + 1.0) * f64::EPSILON.sqrt();
        self.center(time + later).point - self.center(time).point
    }
}

/// The bound leaves out what is rounded in the poses along the motions.
pub(crate) fn turning(
    shape: &BrepShape,
    order: Order,
    [brep, ball]: [&NonlinearRigidMotion; 2],
    radius: f64,
    [start, end]: [f64; 2],
    stop_at_penetration: bool,
) -> Option<ShapeCastHit> {
    // The ball's centre, the origin of its frame, goes round the ball's centre of mass.
    let round = ball.angvel.length() * ball.local_center.length();
    let way = Turning {
        brep,
        ball,
        speed: up((ball.linvel - brep.linvel).length() + round),
        spin: up(brep.angvel.length()),
    };
    let sought = Sought {
        start,
        end,
        distance: 0.0,
        stop_at_penetration,
    };
    let met = advance(shape, &way, radius, &sought)?;
    let relative = brep
        .position_at_time(met.time)
        .inv_mul(&ball.position_at_time(met.time));
    let placement = Placement {
        pos12: &relative,
        order: Order::First,
    };
    Some(hit(&met, order, radius, |v| placement.turn_to_other(v)))
}
