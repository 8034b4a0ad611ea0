//! When a moving ball meets a BREP: the kernel's [`arrival_along`] and [`arrival_past`], on the ways that engines ask about.
//!
//! # What is certified
//! Along a straight line ([`straight`]): no contact is before the time that is given, and the ball is within the distance sought no later than
//! 2^-36 of the size of way after it, unless the status says that steps ran out. Where the BREP is the first shape, the ball's centre and velocity in its
//! frame are exact; where it is the second, both are turned into its frame, and what that rounds is in the bounds.
//!
//! Where the bodies turn ([`turning`]) the same, for the motion that Parry's `position_at_time` stands for. The poses along it are computed with
//! the system's sine and cosine: a bound of their rounding is in the bounds, too, and holds if those are within [`SINE`] units of
//! the last place, as those in use are; that is not proven.
//!
//! # Contacts that are left
//! Where the ball touches the BREP at the start, or is as near as an allowance of [`ALLOWANCE`] radii (of the ball, grown by the distance sought), and an
//! overlap is no reason to stop, a hit is elsewhere or later. Before the time that is given, and for the whole
//! time where there is no hit, **the ball is proven to be nowhere deeper than it was at the start by more than the allowance**. (What is said for
//! overlaps holds for the distance sought, too.)
//! - A ball that goes straight and leaves what it touches, or rolls or slides along it: [`arrival_past`], to 2^-20 of the size, or to 32 times what its centre may be off, where that is more (see on ways that bend). What it leaves is no hit, the
//!   rest of the BREP is, from where it is as deep there as it was anywhere at the start.
//! - One that goes into its deepest contact by more than the allowance in the time asked about, at an angle of more than [`ALONG`]: along a line
//!   ([`straight`]) it hits at the start, as Parry says. As bodies move ([`turning`]), which is what an engine asks that passes over hits at the start, it
//!   hits where it is deeper than at the start by the allowance: [`arrival_along`] with as much less than the separation at the start as its prediction,
//!   whose proof asks nothing of the way (but, as ever, that what is left of the radius is no less than half of a crack's width where the way leads through one).
//!   The engine stops the ball there, before it is through the floor or a wall beyond.
//! - The same where a ball that goes along one thing is at the start as deep in another that is ahead (in a corner), or nothing is known of a straight way.
//! - The same where the way bends: a BREP that turns, a ball that goes round a centre of mass elsewhere. (One whose centre is within a 64th of the allowance
//!   of that, twice over, goes straight up to as much: where an engine places a ball in its body roundings leave such centres.) Such a cast takes a query each 128th of the radius while the ball goes along
//!   what it touches, and some 4,000 of them at the most: after some 32 radii it is told where it has come to, as out of iterations, and counted as undecided.
//!
//! The start is asked as exactly as all of this takes, however coarse the shape's own accuracy is.
//!
//! Nothing is known, and counted as undecided, where the centre may be in material, and where the grown ball is no larger than what is overlooked.

use crate::ball::{ball_at, dressed};
use crate::pair::{Ask, Memory, PairContact, from_vector, to_point, to_vector};
use crate::pose::{Order, Placed, Placement, length, rotate_back, up};
use crate::shape::BrepShape;
use feeler::query::{
    Accuracy, ArrivalAnswer, Contacts, Options, Parameter, Separation, StraightWay, Undecided, Way,
    Workspace, arrival_along, arrival_past,
};
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{NonlinearRigidMotion, ShapeCastHit, ShapeCastStatus};
use parry3d_f64::shape::PackedFeatureId;

/// How exactly the way is known, in sizes.
const THERE: f64 = 1.0 / (1u64 << 36) as f64;
/// Nodes that one advance may spend: some hundred steps, each of some queries.
const NODES: usize = 1_000_000;
/// The same of a ball that touches at the start; what needs more is told as undecided.
const NODES_PAST: usize = 50_000;
/// How exactly the way of such a ball is known, in sizes.
const THERE_PAST: f64 = 1.0 / (1u64 << 20) as f64;
/// Or in what the centre may be off, of a way that is only as good as straight: past what only just counts two places that far apart are come to 2 sqrt(1 / [`ALLOWANCE`]) of that
/// apart (see the kernel's module `past`).
const OFF_PAST: f64 = 32.0;
/// How much deeper than at the start such a ball may come without a hit, in radii of the ball grown by the distance sought: in one cast, so that what comes of many hangs on what the engine makes
/// of their contacts.
const ALLOWANCE: f64 = 1.0 / 128.0;
/// The part of the allowance that is as good as nothing: of a way that bends, and of what is known of the start.
const LITTLE: f64 = 1.0 / 64.0;
/// The sine of the angle at which a ball may go into what it touches and yet be said to go along it: above the roundings of normals and velocities.
const ALONG: f64 = 1.0 / (1u64 << 20) as f64;
/// Half a unit in the last place of 1.
const U: f64 = f64::EPSILON / 2.0;
/// What the system's sine and cosine may be off, in units of the last place.
const SINE: f64 = 4.0;

/// A hit in the BREP's terms.
struct Met {
    time: f64,
    contact: PairContact,
    status: ShapeCastStatus,
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
    span: [f64; 2],
    distance: f64,
    stop_at_penetration: bool,
    /// Whether a ball that is driven into what it touches is told from where it is deeper, not from the start on.
    driven_on: bool,
}

impl Sought {
    /// How much deeper than at the start the ball may come without a hit.
    fn allowance(&self, radius: f64) -> f64 {
        ALLOWANCE * (radius + self.distance.max(0.0))
    }
}

/// The ball's way, and what it is if it is taken for straight, within the bounds that this has.
fn advance(
    shape: &BrepShape,
    (way, line): (&dyn Way, Option<&StraightWay>),
    radius: f64,
    sought: &Sought,
) -> Option<Met> {
    let [start, end] = sought.span;
    if !(start <= end) {
        return None;
    }
    let shape = &sharp(shape, radius, sought);
    let touched = match sought.stop_at_penetration {
        true => None,
        false => {
            let velocity = line.map_or_else(|| way.velocity(start), |line| line.velocity);
            touched(shape, placed(way, start), velocity, radius, sought)
        }
    };
    let there = THERE * shape.brep().size();
    if let Some(Touched { separation, left }) = touched {
        let limit = limit(separation, radius, sought);
        match line {
            Some(line) if left => {
                let found = past(shape, line, radius, sought);
                if let (false, true, Some(limit)) = (found.later, sought.driven_on, limit) {
                    return deeper(shape, way, radius, (sought, limit));
                }
                if found.undecided {
                    shape.note_undecided();
                }
                return found.met;
            }
            // What is apart and driven in hits when it touches, as ever.
            _ if left || sought.driven_on && separation.value <= sought.distance + there => {
                if let Some(limit) = limit {
                    return deeper(shape, way, radius, (sought, limit));
                }
                shape.note_undecided();
                if left {
                    // Nothing is known: that the contact at the start is left is all there is to tell.
                    return None;
                }
            }
            _ => {}
        }
    }
    let (time, settled) = arrive(shape, way, radius, sought.span, [sought.distance, there]);
    let bounds = time?.bounds;
    let contact = contact_at(
        shape,
        placed(way, bounds.lo),
        radius,
        &mut Memory::default(),
    )?;
    // Or as good as touching, which may or may not be so.
    let near = contact.separation.value <= sought.distance + there;
    let inside = bounds.lo == start && near;
    let status = match inside {
        true => ShapeCastStatus::PenetratingOrWithinTargetDist,
        false if near && settled => ShapeCastStatus::Converged,
        false => ShapeCastStatus::OutOfIterations,
    };
    Some(Met {
        time: bounds.lo,
        contact,
        status,
    })
}

/// The shape with contacts as exact as a cast needs them, whatever its own are to be: its start to a part of what is overlooked.
fn sharp(shape: &BrepShape, radius: f64, sought: &Sought) -> BrepShape {
    let there = THERE * shape.brep().size();
    let start = match sought.allowance(radius) {
        0.0 => there,
        // Half, for the rest of the start's bounds is what its place is off.
        allowance => 0.5 * LITTLE * allowance,
    };
    let accuracy = shape.accuracy().min(there).min(start);
    shape.clone().with_accuracy(accuracy)
}

/// When the ball comes to a separation, known to within a length, and whether that is settled; what is not is counted.
fn arrive(
    shape: &BrepShape,
    way: &dyn Way,
    radius: f64,
    span: [f64; 2],
    [separation, within]: [f64; 2],
) -> (Option<Parameter>, bool) {
    let options = Options {
        accuracy: Accuracy::Length(within),
        prediction: separation,
        contacts: Contacts::None,
        node_budget: NODES,
    };
    let mut workspace = Workspace::default();
    let answer = arrival_along(shape.brep(), radius, way, span, &options, &mut workspace);
    let settled = is_settled(&answer);
    if !settled {
        shape.note_undecided();
    }
    (answer.time, settled)
}

/// Steps that are too short for the time's own digits end an advance as well as may be, if it is known to end.
fn is_settled(answer: &ArrivalAnswer) -> bool {
    match answer.undecided {
        None => true,
        Some(Undecided::Precision) => answer.time.is_some_and(|t| t.bounds.hi.is_finite()),
        Some(_) => false,
    }
}

fn placed(way: &dyn Way, time: f64) -> Placed {
    let (point, bound) = way.center(time);
    let point = Vector::new(point.x, point.y, point.z);
    Placed { point, bound }
}

/// What a ball touches at the start, or nearly so.
struct Touched {
    separation: Separation,
    /// Whether the ball leaves it there or goes along it. Where to look, no proof: what [`past`] and [`deeper`] say holds whatever this says.
    left: bool,
}

fn touched(
    shape: &BrepShape,
    center: Placed,
    velocity: Vector3<f64>,
    radius: f64,
    sought: &Sought,
) -> Option<Touched> {
    let [start, end] = sought.span;
    let contact = contact_at(shape, center, radius, &mut Memory::default())?;
    // A ball that hovers at a gap less than what is overlooked would come nearer to what it goes along by tiny steps.
    let allowance = sought.allowance(radius);
    let velocity = from_vector(&velocity);
    let closing = -contact.normal.dot(velocity);
    let along = closing <= ALONG * length(velocity);
    let separation = contact.separation;
    (separation.value <= sought.distance + allowance).then_some(Touched {
        separation,
        left: along || closing * (end - start) <= allowance,
    })
}

/// The separation that the ball is not to fall below, if there is one that can be proven: centres in material are out of it.
fn limit(start: Separation, radius: f64, sought: &Sought) -> Option<f64> {
    let allowance = sought.allowance(radius);
    let lo = start.bounds.lo;
    // From above: no deeper than at the start by more than the allowance, wherever in its bounds that was.
    let limit = (start.bounds.hi.min(sought.distance) - allowance).next_up();
    // All of these are false of what is no number.
    let known = start.bounds.width() <= LITTLE * allowance;
    (known && radius + limit > 0.0 && allowance > 0.0 && limit < lo).then_some(limit)
}

/// Where a ball that touches at the start is deeper, anywhere, than it may come.
fn deeper(
    shape: &BrepShape,
    way: &dyn Way,
    radius: f64,
    (sought, limit): (&Sought, f64),
) -> Option<Met> {
    let there = LITTLE * sought.allowance(radius);
    let (time, settled) = arrive(shape, way, radius, sought.span, [limit, there]);
    let time = time?.bounds.lo;
    let memory = &mut Memory::default();
    Some(Met {
        time,
        contact: contact_at(shape, placed(way, time), radius, memory)?,
        status: match settled {
            true => ShapeCastStatus::Converged,
            false => ShapeCastStatus::OutOfIterations,
        },
    })
}

/// What [`past`] found.
struct Past {
    met: Option<Met>,
    undecided: bool,
    /// Whether it is later than the start, or never: an engine passes over hits at the very start.
    later: bool,
}

/// What of the BREP is in the way of a ball that leaves it, or goes along it.
fn past(shape: &BrepShape, way: &StraightWay, radius: f64, sought: &Sought) -> Past {
    let brep = shape.brep();
    let there = (THERE_PAST * brep.size()).max(OFF_PAST * way.center_bound);
    let options = Options {
        accuracy: Accuracy::Length(there),
        prediction: sought.distance,
        contacts: Contacts::Deepest,
        node_budget: NODES_PAST,
    };
    let (span, allowance) = (sought.span, sought.allowance(radius));
    let mut workspace = Workspace::default();
    let answer = arrival_past(brep, radius, way, span, allowance, &options, &mut workspace);
    let undecided = answer.undecided.is_some();
    let Some(time) = &answer.time else {
        return Past {
            met: None,
            undecided,
            later: !undecided,
        };
    };
    let bounds = time.bounds;
    let met = || {
        if bounds.lo == span[0] && bounds.hi == f64::INFINITY {
            // Nothing is known: that the contact at the start is left is all there is to tell.
            return None;
        }
        let center = placed(way, bounds.lo);
        let contact = match answer.contacts.first() {
            Some(c) => dressed(c, center.point, radius, PackedFeatureId::face(0)),
            None => contact_at(shape, center, radius, &mut Memory::default())?,
        };
        let status = match undecided {
            // At the start, and proven to be.
            _ if bounds.hi == span[0] => ShapeCastStatus::PenetratingOrWithinTargetDist,
            false => ShapeCastStatus::Converged,
            true => ShapeCastStatus::OutOfIterations,
        };
        Some(Met {
            time: bounds.lo,
            contact,
            status,
        })
    };
    Past {
        met: met(),
        undecided,
        later: bounds.lo > span[0],
    }
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

/// Along a straight line, as Parry's `cast_shapes`: the second shape moves in the frame of the first.
pub(crate) fn straight(
    shape: &BrepShape,
    placement: Placement<'_>,
    velocity: Vector,
    radius: f64,
    options: &ShapeCastOptions,
) -> Option<ShapeCastHit> {
    let center = placement.to_brep(Vector::ZERO);
    let velocity = match placement.order {
        Order::First => Placed::exact(velocity),
        Order::Second if velocity == Vector::ZERO => Placed::exact(velocity),
        Order::Second => placement.turn_to_brep(-velocity),
    };
    let way = StraightWay {
        center: to_point(center.point),
        center_bound: center.bound,
        velocity: to_vector(velocity.point),
        velocity_bound: velocity.bound,
    };
    let sought = Sought {
        span: [0.0, options.max_time_of_impact],
        distance: options.target_distance,
        stop_at_penetration: options.stop_at_penetration,
        driven_on: false,
    };
    let met = advance(shape, (&way, Some(&way)), radius, &sought)?;
    let other = |v: Vector| placement.turn_to_other(v);
    Some(hit(&met, placement.order, radius, other))
}

/// No less than the length of a vector but for roundings, which below normal numbers are more than a part of it.
fn most(v: Vector) -> f64 {
    match length(v) {
        0.0 => 0.0,
        length => length + f64::MIN_POSITIVE,
    }
}

/// The velocity of a body's point that is somewhere at a time.
fn velocity_at(body: &NonlinearRigidMotion, time: f64, point: Vector) -> Vector {
    let center = body.start * body.local_center + body.linvel * time;
    body.linvel + body.angvel.cross(point - center)
}

/// Both bodies move and turn.
struct Turning<'a> {
    brep: &'a NonlinearRigidMotion,
    ball: &'a NonlinearRigidMotion,
    /// Bound of the speed of the ball's centre relative to that of the BREP's.
    speed: f64,
    /// Of the BREP's turning.
    spin: f64,
    /// Of the ball's centre round its centre of mass.
    round: f64,
}

/// How far a body's place at a time may be off, and how far it may be turned too far, in radians.
///
/// The angle t |w| is off by 4u of itself: products, length; half of it, its sine and cosine by [`SINE`] u, and
/// the axis by 4u, give a quaternion that is off by (2 t |w| + SINE + 4) u, a rotation by twice that; the product with
/// the start's quaternion, which is not quite of unit length, is off by some 8u more, thrice for the three poses that are multiplied. What is
/// turned and added on the way is no longer than the centre's place, twice, and the way.
fn rounding(motion: &NonlinearRigidMotion, time: f64) -> [f64; 2] {
    let turned = length(motion.angvel) * time.abs();
    let angle = U * (4.0 * turned + 2.0 * (SINE + 4.0) + 24.0);
    let center = length(motion.start.translation) + length(motion.local_center);
    let sizes = 2.0 * center + length(motion.linvel) * time.abs();
    [up((angle + 48.0 * U) * sizes), up(angle)]
}

impl Turning<'_> {
    fn placed(&self, time: f64) -> Placed {
        let at = self.ball.position_at_time(time).translation;
        let placed = crate::pose::into(&self.brep.position_at_time(time), at);
        let ([ball, _], [brep, angle]) = (rounding(self.ball, time), rounding(self.brep, time));
        let bound = up(placed.bound + ball + brep + angle * length(placed.point));
        Placed { bound, ..placed }
    }

    /// How fast the ball's centre of mass moves in the frame of a BREP that does not turn.
    fn shifting(&self) -> (Vector3<f64>, f64) {
        let velocity = self.ball.linvel - self.brep.linvel;
        let turned = Pose::from_parts(Vector::ZERO, self.brep.start.rotation);
        let seen = crate::pose::into(&turned, velocity);
        let bound = up(seen.bound + f64::EPSILON * most(velocity));
        (to_vector(seen.point), bound)
    }

    /// The way, if the BREP does not turn and the ball goes as good as straight: a circle about the centre of mass keeps
    /// within its diameter of where it begins.
    fn line(&self, diameter: f64, sought: &Sought, radius: f64) -> Option<StraightWay> {
        let bend = match self.round {
            0.0 => 0.0,
            _ => up(diameter),
        };
        let straight = self.spin == 0.0 && bend <= LITTLE * sought.allowance(radius);
        straight.then(|| {
            let (velocity, velocity_bound) = self.shifting();
            let start = self.placed(0.0);
            StraightWay {
                center: to_point(start.point),
                center_bound: start.bound + bend,
                velocity,
                velocity_bound,
            }
        })
    }
}

impl Way for Turning<'_> {
    fn center(&self, time: f64) -> (Point3<f64>, f64) {
        let placed = self.placed(time);
        (to_point(placed.point), placed.bound)
    }

    /// While the ball comes nearer by w, it moves by at most w against the BREP's centre, from which it is then at most
    /// D + w away: in the BREP's frame it is no faster than V + spin (D + w).
    fn least_time(&self, time: f64, way: f64) -> f64 {
        /// A quotient rounded down.
        const DOWN: f64 = 1.0 - 8.0 * f64::EPSILON;
        if !(way > 0.0) {
            return 0.0;
        }
        let center = self.placed(time);
        let from = length(center.point - self.brep.local_center) + center.bound;
        match up(self.speed + up(self.spin) * (from + way)) {
            0.0 => f64::INFINITY,
            // Beyond all numbers: nothing is known.
            speed if speed.is_nan() || speed == f64::INFINITY => 0.0,
            speed => (way / speed * DOWN).min(f64::MAX),
        }
    }

    fn velocity(&self, time: f64) -> Vector3<f64> {
        if let Some((velocity, _)) = self.steady() {
            return velocity;
        }
        let at = self.ball.position_at_time(time).translation;
        let [ball, brep] = [self.ball, self.brep].map(|body| velocity_at(body, time, at));
        let turned = self.brep.position_at_time(time).rotation;
        to_vector(rotate_back(&turned, ball - brep).point)
    }

    fn steady(&self) -> Option<(Vector3<f64>, f64)> {
        (self.spin == 0.0 && self.round == 0.0).then(|| self.shifting())
    }
}

/// Both bodies move and turn, as Parry's `cast_shapes_nonlinear`.
pub(crate) fn turning(
    shape: &BrepShape,
    order: Order,
    [brep, ball]: [&NonlinearRigidMotion; 2],
    radius: f64,
    span: [f64; 2],
    stop_at_penetration: bool,
) -> Option<ShapeCastHit> {
    // The ball's centre, the origin of its frame, goes round the ball's centre of mass.
    let [spin, arm] = [ball.angvel, ball.local_center].map(most);
    let round = match spin > 0.0 && arm > 0.0 {
        true => spin * arm + f64::MIN_POSITIVE,
        false => 0.0,
    };
    let way = Turning {
        brep,
        ball,
        speed: up(most(ball.linvel - brep.linvel) + round),
        spin: most(brep.angvel),
        round,
    };
    let sought = Sought {
        span,
        distance: 0.0,
        stop_at_penetration,
        driven_on: true,
    };
    let line = way.line(2.0 * arm, &sought, radius);
    let met = advance(shape, (&way, line.as_ref()), radius, &sought)?;
    let relative = brep
        .position_at_time(met.time)
        .inv_mul(&ball.position_at_time(met.time));
    let placement = Placement {
        pos12: &relative,
        order: Order::First,
    };
    Some(hit(&met, order, radius, |v| placement.turn_to_other(v)))
}
