//! When a probe that moves along a straight line first comes to a BREP: the estimated time of arrival.
//!
//! # Definition
//! The least time t >= 0 at which the separation of the probe, moved by t times its velocity, is at most the prediction (0 unless said: the
//! touch). A probe that touches at the start has arrived at 0, whichever way it goes; when a ball that leaves what it touches, or goes along it, comes to
//! the rest is asked of [`arrival_past`](super::arrival_past).
//!
//! # Method
//! A half-space {x : n.x <= h} has the separation s - t n.v, s that of the start: a quotient. A ball goes by conservative advancement
//! (Mirtich, *Impulse-based Dynamic Simulation of Rigid Body Systems*, 1996): the distance from a set changes by no more than the point
//! moves, so that a ball whose separation is at least a is free for the time a / |v|, again and again (module `advance`; a way that turns says itself how long that is: [`super::Way`]). Each time Newton's method, which proves
//! nothing, proposes where the touch may be; there the kernel is asked. Where steps are short ([`PATIENCE`]), the plane through the nearest point,
//! across its normal, is asked how far the BREP reaches beyond it: the ball is free until it comes to what holds all of it. On a convex part
//! that is Newton's method with a proof.
//!
//! # Guarantee
//! The probe is proven to be free up to `lo`, and to be within the prediction at `hi`. Centres are rounded: what that moves them is
//! taken off each separation, twice over, as it may pass a crack (see the argument in `feeler-rapier`, module `ball`). Contacts are those of the
//! probe where it is rounded to; their separations hold for where it truly is, their places and normals for the rounded probe. "Never" is
//! proven too: the time asked about is over, or the ball stands still, moves along or away from a plane that the faces are beyond, or has on some
//! axis passed the box of the faces and does not come back. A reach (radius and prediction together) below half of a crack's width, or
//! below zero, is not proven where the way leads through that crack: separations then do not change steadily.
//!
//! # Cost
//! Up to ten queries a step; all of them share the node budget, and the contacts at the end may spend as much again. Head on, and to convex parts, a few steps do. Else, at an angle a to the face, the way left shrinks by 1 - sin a a
//! step; a ball that passes at a gap g takes some pi sqrt(2 r / g) steps. Where [`STEPS`] run out the enclosure is as wide as it is, and says so.

use super::Workspace;
use super::advance::{DOWN, StraightWay, UP, arrival_along, contacts_at, from_prediction};
use super::answer::{
    Contact, ContactAnswer, Contacts, HalfSpace, Options, Parameter, Probe, ProbeError, Sphere,
    Undecided, in_range,
};
use super::contact::contact;
use crate::numeric::{Ball, Dd, Enclosure};
use crate::prepare::PreparedBrep;
use nalgebra::Vector3;

/// How a probe moves: along a straight line, without turning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// In model units a unit of time.
    pub velocity: Vector3<f64>,
    /// Until when; may be infinite.
    pub until: f64,
}

impl Motion {
    /// Refuses a velocity that is not finite or too large, and a time that is negative or none.
    pub fn new(velocity: Vector3<f64>, until: f64) -> Result<Self, ProbeError> {
        in_range("the velocity", velocity.as_slice())?;
        if !(until >= 0.0) {
            return Err(ProbeError::Until);
        }
        Ok(Self { velocity, until })
    }
}

/// When a probe arrives; `default` is never.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ArrivalAnswer {
    /// The time, in units of the velocity: free until `lo`, and where `hi` is finite within the prediction at `value`, which is `hi`.
    /// An infinite `hi` means that it may never arrive. `None`: it is proven not to arrive until the end of the motion.
    pub time: Option<Parameter>,
    /// The contacts at `value`, of the probe with its centre (or offset) there rounded to f64: separations hold without that, too. None where it may
    /// never arrive.
    pub contacts: Vec<Contact>,
    /// Whether the deepest of them is a continuum.
    pub continuum: bool,
    /// Set when the enclosure is wider than was asked.
    pub undecided: Option<Undecided>,
}

impl ArrivalAnswer {
    /// The first arrival at either of two BREPs.
    #[must_use]
    pub fn or_earlier(self, other: Self) -> Self {
        let (Some(a), Some(b)) = (self.time, other.time) else {
            return if self.time.is_some() { self } else { other };
        };
        let bounds = a.bounds.min(&b.bounds);
        let (mut first, later) = match a.bounds.hi <= b.bounds.hi {
            true => (self, other),
            false => (other, self),
        };
        if later.time.is_some_and(|t| t.bounds.lo <= bounds.hi) {
            first.undecided = first.undecided.or(later.undecided);
        }
        first.time = Some(Parameter {
            value: if bounds.hi.is_finite() {
                bounds.hi
            } else {
                bounds.lo
            },
            bounds,
        });
        first
    }

    pub(super) fn at(
        time: Enclosure,
        found: Option<ContactAnswer>,
        undecided: Option<Undecided>,
    ) -> Self {
        let known = time.hi.is_finite();
        let (contacts, continuum) = match found {
            Some(found) => (found.contacts, found.continuum),
            None => (Vec::new(), false),
        };
        Self {
            time: Some(Parameter {
                value: if known { time.hi } else { time.lo },
                bounds: time,
            }),
            contacts,
            continuum,
            undecided,
        }
    }
}

/// When a ball or half-space that moves comes to a BREP: see the module's text.
///
/// The accuracy is that of the way: the enclosure of the time is no wider than this length over the speed; `full` stands for 2^-40 of the
/// model's size. For a half-space it is that of the separation at the start.
///
/// What it allocates: see [`Workspace`].
pub fn arrival(
    brep: &PreparedBrep,
    probe: &Probe,
    motion: &Motion,
    options: &Options,
    workspace: &mut Workspace,
) -> ArrivalAnswer {
    match probe {
        Probe::Sphere(ball) => {
            let span = [0.0, motion.until];
            let way = way_of(ball, motion);
            arrival_along(brep, ball.radius, &way, span, options, workspace)
        }
        Probe::HalfSpace(plane) => of_half_space(brep, plane, motion, options, workspace),
    }
}

/// The contacts of a probe that has moved for so long, with what its place is rounded by in their separations: those at the `value` of an
/// [`arrival`], of another BREP beside the one that it arrives at. `None`: it is beyond the range in which bounds hold.
pub fn contact_on_arrival(
    brep: &PreparedBrep,
    probe: &Probe,
    motion: &Motion,
    time: f64,
    options: &Options,
    workspace: &mut Workspace,
) -> Option<ContactAnswer> {
    match probe {
        Probe::Sphere(ball) => {
            let way = way_of(ball, motion);
            contacts_at(brep, ball.radius, &way, time, options, workspace)
        }
        Probe::HalfSpace(plane) => {
            let (gone, off) = gone_by(time, closing(plane, motion));
            plane_at(brep, plane, gone, [0.0, off], options, workspace)
        }
    }
}

fn way_of(ball: &Sphere, motion: &Motion) -> StraightWay {
    StraightWay {
        center: ball.center,
        center_bound: 0.0,
        velocity: motion.velocity,
        velocity_bound: 0.0,
    }
}

/// How fast the offset of a half-space grows.
fn closing(plane: &HalfSpace, motion: &Motion) -> Ball<Dd> {
    // Products with zero are left out: they are exact, and a plane that moves along itself never comes nearer.
    let factors = plane.normal.iter().zip(&motion.velocity);
    factors
        .filter(|(n, v)| **n != 0.0 && **v != 0.0)
        .map(|(n, v)| Ball::<Dd>::exact(*n) * Ball::exact(*v))
        .fold(Ball::<Dd>::ZERO, |sum, x| sum + x)
}

/// By how much an offset has grown in a time, rounded, and what the speed's own error adds to its rounding.
fn gone_by(time: f64, closing: Ball<Dd>) -> (f64, f64) {
    let speed = closing.mid.hi;
    let off = (closing.upper() - speed).max(speed - closing.lower());
    (time * speed, time.abs() * off * UP)
}

/// The contacts of a half-space whose offset has grown by `gone`; `sizes` of other numbers that its place comes from, and how far off it is
/// known to be besides.
fn plane_at(
    brep: &PreparedBrep,
    plane: &HalfSpace,
    gone: f64,
    [sizes, off]: [f64; 2],
    options: &Options,
    workspace: &mut Workspace,
) -> Option<ContactAnswer> {
    // The rounded offset may fall short of the touch by its rounding.
    let short = match gone {
        0.0 => 0.0,
        _ => (4.0 * f64::EPSILON * (plane.offset.abs() + gone.abs() + sizes) + off) * UP,
    };
    let moved = HalfSpace::new(plane.normal, plane.offset + gone).ok()?;
    let asked = Options {
        prediction: options.prediction + short,
        ..*options
    };
    let found = contact(brep, &Probe::HalfSpace(moved), &asked, workspace);
    Some(widened(found, short))
}

fn of_half_space(
    brep: &PreparedBrep,
    plane: &HalfSpace,
    motion: &Motion,
    options: &Options,
    workspace: &mut Workspace,
) -> ArrivalAnswer {
    let alone = Options {
        contacts: Contacts::None,
        ..*options
    };
    let start = contact(brep, &Probe::HalfSpace(*plane), &alone, workspace);
    let Enclosure { lo, hi } = start.separation.bounds;
    let open = |lo: f64| Enclosure {
        lo,
        hi: f64::INFINITY,
    };
    if options.prediction.is_nan() {
        // Nothing can be said of what is no number.
        return ArrivalAnswer::at(open(0.0), None, Some(Undecided::Degenerate));
    }
    if lo == f64::INFINITY {
        return ArrivalAnswer::default();
    }
    if hi <= options.prediction {
        let found = plane_at(brep, plane, 0.0, [0.0; 2], options, workspace);
        let missing = missing(options, found.as_ref());
        return ArrivalAnswer::at(Enclosure::exact(0.0), found, missing);
    }
    let closing = closing(plane, motion);
    let (slow, fast) = (closing.lower(), closing.upper());
    let left = from_prediction(start.separation.bounds, options.prediction);
    let (near, far) = (left.lo.max(0.0), left.hi);
    let first = match fast > 0.0 {
        true => near / fast * DOWN,
        // It stays where it is or goes away.
        false if near > 0.0 => f64::INFINITY,
        false => 0.0,
    };
    if first == f64::INFINITY || first > motion.until {
        return ArrivalAnswer::default();
    }
    let last = match slow > 0.0 {
        true => (far / slow * UP).max(first),
        false => f64::INFINITY,
    };
    if !(last <= motion.until) || last == f64::INFINITY {
        return ArrivalAnswer::at(open(first), None, Some(Undecided::Precision));
    }
    let (gone, off) = gone_by(last, closing);
    let found = plane_at(brep, plane, gone, [hi.abs(), off], options, workspace);
    let time = Enclosure {
        lo: first,
        hi: last,
    };
    let missing = missing(options, found.as_ref());
    ArrivalAnswer::at(time, found, start.undecided.or(missing))
}

/// The same contacts, their separations for a probe that is so far off.
pub(super) fn widened(mut found: ContactAnswer, by: f64) -> ContactAnswer {
    if by > 0.0 {
        for contact in &mut found.contacts {
            let b = &mut contact.separation.bounds;
            b.lo = (b.lo - by).next_down();
            b.hi = (b.hi + by).next_up();
        }
    }
    found
}

/// Why contacts may be missing of those that were asked for.
pub(super) fn missing(options: &Options, found: Option<&ContactAnswer>) -> Option<Undecided> {
    found
        .filter(|_| options.contacts == Contacts::All)
        .and_then(|f| f.undecided)
}
