//! When a probe that moves along a straight line first comes to a BREP: the estimated time of arrival.
//!
//! # Definition
//! The least time t >= 0 at which the separation of the probe, moved by t times its velocity, is at most the prediction (0 unless said: the
//! touch). A probe that touches at the start has arrived at 0, whichever way it goes.
//!
//! # Method
//! A half-space {x : n.x <= h} has the separation s - t n.v, s that of the start: a quotient. A ball goes by conservative advancement
//! (Mirtich, *Impulse-based Dynamic Simulation of Rigid Body Systems*, 1996): the distance from a set changes by no more than the point
//! moves, so that a ball whose separation is at least a is free for the time a / |v|, again and again. Each time Newton's method, which proves
//! nothing, proposes where the touch may be; there the kernel is asked. Where steps are short ([`PATIENCE`]), the plane through the nearest point,
//! across its normal, is asked how far the BREP reaches beyond it: the ball is free until it comes to what holds all of it. On a convex part
//! that is Newton's method with a proof.
//!
//! # Guarantee
//! The probe is proven to be free up to `lo`, and to be within the prediction at `hi`. Centres are rounded: what that moves them is
//! taken off each separation, twice over, as it may pass a crack (see the argument in `feeler-rapier`, module `ball`). Contacts are those of the
//! probe where it is rounded to; their separations hold for where it truly is, their places and normals for the rounded probe. "Never" is
//! proven too: either the time asked about is over, or on some axis the ball has passed the box of the faces and does not come back.
//!
//! # Cost
//! Up to ten queries a step. Head on, and to convex parts, a few steps do. Else, at an angle a to the face, the way left shrinks by 1 - sin a a
//! step; a ball that passes at a gap g takes some pi sqrt(2 r / g) steps. Where [`STEPS`] run out the enclosure is as wide as it is, and says so.

use super::answer::{
    Accuracy, Contact, ContactAnswer, Contacts, HalfSpace, Options, Probe, ProbeError, Separation,
    Sphere, Undecided, in_range,
};
use super::contact::{Witness, contact, contact_from};
use super::{Work, Workspace};
use crate::numeric::{Ball, Dd, Enclosure};
use crate::prepare::PreparedBrep;
use nalgebra::Vector3;

/// How exactly `full` knows the way to the arrival, in sizes.
const FULL: f64 = 1.0 / (1u64 << 40) as f64;
/// Separations are asked for this much finer than the way.
const FINER: f64 = 64.0;
/// Most steps of a ball.
const STEPS: usize = 4096;
/// Steps after which planes are asked, too.
const PATIENCE: usize = 8;
/// Most steps of Newton's method towards a touch.
const NEWTON: usize = 8;
/// A quotient of positive numbers, rounded down, and up.
const DOWN: f64 = 1.0 - 8.0 * f64::EPSILON;
const UP: f64 = 1.0 + 8.0 * f64::EPSILON;

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

    /// A bound of the speed.
    fn speed(&self) -> f64 {
        // Scaled first, so that squares of small ones survive.
        match self.velocity.amax() {
            0.0 => 0.0,
            // Below normal numbers products lose digits: what is added is more than that.
            scale => scale * (self.velocity / scale).norm() * UP + f64::MIN_POSITIVE,
        }
    }
}

/// When a probe arrives; `default` is never.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ArrivalAnswer {
    /// The time, in units of the velocity: free until `lo`, and where `hi` is finite within the prediction at `value`, which is `hi`.
    /// An infinite `hi` means that it may never arrive. `None`: it is proven not to arrive until the end of the motion.
    pub time: Option<Separation>,
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
        first.time = Some(Separation {
            value: if bounds.hi.is_finite() {
                bounds.hi
            } else {
                bounds.lo
            },
            bounds,
        });
        first
    }

    fn at(time: Enclosure, found: Option<ContactAnswer>, undecided: Option<Undecided>) -> Self {
        let known = time.hi.is_finite();
        let (contacts, continuum) = match found {
            Some(found) => (found.contacts, found.continuum),
            None => (Vec::new(), false),
        };
        Self {
            time: Some(Separation {
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
pub fn arrival(
    brep: &PreparedBrep,
    probe: &Probe,
    motion: &Motion,
    options: &Options,
    workspace: &mut Workspace,
) -> ArrivalAnswer {
    match probe {
        Probe::Sphere(ball) => Advance::new(brep, *ball, motion, options).run(workspace),
        Probe::HalfSpace(plane) => of_half_space(brep, plane, motion, options, workspace),
    }
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
    let at = |offset: f64, prediction: f64, workspace: &mut Workspace| {
        let plane = HalfSpace::new(plane.normal, offset).ok()?;
        let asked = Options {
            prediction,
            ..*options
        };
        let found = contact(brep, &Probe::HalfSpace(plane), &asked, workspace);
        Some(found)
    };
    if hi <= options.prediction {
        let found = at(plane.offset, options.prediction, workspace);
        return ArrivalAnswer::at(Enclosure::exact(0.0), found, None);
    }
    // Products with zero are left out: they are exact, and a plane that moves along itself never comes nearer.
    let factors = plane.normal.iter().zip(&motion.velocity);
    let closing = factors
        .filter(|(n, v)| **n != 0.0 && **v != 0.0)
        .map(|(n, v)| Ball::<Dd>::exact(*n) * Ball::exact(*v))
        .fold(Ball::<Dd>::ZERO, |sum, x| sum + x);
    let (slow, fast) = (closing.lower(), closing.upper());
    let [near, far] = [lo, hi].map(|s| Ball::<Dd>::difference(s, options.prediction));
    let (near, far) = (near.lower().max(0.0), far.upper());
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
        let open = Enclosure {
            lo: first,
            hi: f64::INFINITY,
        };
        return ArrivalAnswer::at(open, None, Some(Undecided::Precision));
    }
    let gone = last * closing.mid.hi;
    let offset = plane.offset + gone;
    // The rounded offset may fall short of the touch by its rounding.
    let short = 4.0 * f64::EPSILON * (plane.offset.abs() + gone.abs() + hi.abs());
    let found = at(offset, options.prediction + short, workspace).map(|f| widened(f, short));
    let time = Enclosure {
        lo: first,
        hi: last,
    };
    let missing = missing(options, found.as_ref());
    ArrivalAnswer::at(time, found, start.undecided.or(missing))
}

/// The same contacts, their separations for a probe that is so far off.
fn widened(mut found: ContactAnswer, by: f64) -> ContactAnswer {
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
fn missing(options: &Options, found: Option<&ContactAnswer>) -> Option<Undecided> {
    found
        .filter(|_| options.contacts == Contacts::All)
        .and_then(|f| f.undecided)
}

/// The separation at a time, for the true centre, and the way it changes.
struct Here {
    /// From the prediction.
    bounds: Enclosure,
    value: f64,
    /// From the BREP to the ball; no proof.
    normal: Vector3<f64>,
    /// How fast the separation falls, as the normal says.
    closing: f64,
}

struct Advance<'a> {
    brep: &'a PreparedBrep,
    ball: Sphere,
    motion: &'a Motion,
    options: &'a Options,
    speed: f64,
    /// How exactly the way is asked for.
    way: f64,
    witness: Witness,
    work: Work,
}

impl<'a> Advance<'a> {
    fn new(brep: &'a PreparedBrep, ball: Sphere, motion: &'a Motion, options: &'a Options) -> Self {
        Self {
            brep,
            ball,
            motion,
            options,
            speed: motion.speed(),
            way: match options.accuracy {
                Accuracy::Full => FULL * brep.size(),
                Accuracy::Length(a) => a,
            },
            witness: Witness::default(),
            work: Work::default(),
        }
    }

    /// The ball at a time, and how far its centre may be from the true one.
    fn moved(&self, time: f64) -> Option<(Sphere, f64)> {
        if time == 0.0 {
            return Some((self.ball, 0.0));
        }
        let by = self.motion.velocity * time;
        let center = self.ball.center + by;
        // Two roundings a coordinate.
        let one = |v: &Vector3<f64>| v.iter().fold(0.0, |sum: f64, x| sum + x.abs());
        let off = 2.0 * f64::EPSILON * (one(&self.ball.center.coords) + one(&by));
        let ball = Sphere::new(center, self.ball.radius).ok()?;
        Some((ball, off + f64::MIN_POSITIVE))
    }

    fn ask(
        &mut self,
        time: f64,
        contacts: Contacts,
        workspace: &mut Workspace,
    ) -> Option<(ContactAnswer, f64)> {
        let (ball, off) = self.moved(time)?;
        let prediction = match contacts {
            Contacts::All => self.options.prediction,
            _ => f64::INFINITY,
        };
        let options = Options {
            accuracy: match self.options.accuracy {
                Accuracy::Full => Accuracy::Full,
                Accuracy::Length(a) => Accuracy::Length(a / FINER),
            },
            prediction,
            contacts,
            node_budget: self.options.node_budget,
        };
        let probe = Probe::Sphere(ball);
        let found = contact_from(self.brep, &probe, &mut self.witness, &options, workspace);
        self.work.nodes += workspace.work.nodes;
        self.work.contacts += workspace.work.contacts;
        self.work.rays += workspace.work.rays;
        Some((found, off))
    }

    fn here(&mut self, time: f64, workspace: &mut Workspace) -> Option<Here> {
        let (found, off) = self.ask(time, Contacts::Deepest, workspace)?;
        let s = found.separation;
        let less = |x: f64| Ball::<Dd>::difference(x, self.options.prediction);
        let normal = found
            .contacts
            .first()
            .map_or(Vector3::zeros(), |c| c.normal);
        let low = less(s.bounds.lo).lower() - 2.0 * off;
        Some(Here {
            bounds: Enclosure {
                // Infinite where there is nothing: it stays so.
                lo: if s.bounds.lo == f64::INFINITY {
                    s.bounds.lo
                } else {
                    low.next_down()
                },
                hi: match off {
                    0.0 => less(s.bounds.hi).upper(),
                    _ => (less(s.bounds.hi).upper() + 2.0 * off).next_up(),
                },
            },
            value: s.value - self.options.prediction,
            normal,
            closing: -normal.dot(&self.motion.velocity),
        })
    }

    /// A time at which the ball is proven to have arrived, found by Newton's method from a time at which it has not.
    fn touch(&mut self, from: f64, here: &Here, workspace: &mut Workspace) -> Option<f64> {
        let (mut time, mut value, mut closing) = (from, here.value, here.closing);
        let mut width = here.bounds.width();
        for _ in 0..NEWTON {
            if !(closing > 0.0) {
                return None;
            }
            // A little too far, so that the enclosure there is below zero; the less, the slower it comes nearer.
            let beyond = (4.0 * self.way / FINER * (closing / self.speed)).max(2.0 * width);
            let step = (value + beyond) / closing;
            // At least to the next number, where the last step was one of rounding.
            time = if step > 0.0 {
                (time + step).max(time.next_up())
            } else {
                time + step
            };
            if !(time >= from && time <= self.motion.until) {
                return None;
            }
            let there = self.here(time, workspace)?;
            if there.bounds.hi <= 0.0 {
                return Some(time);
            }
            (value, closing, width) = (there.value.max(0.0), there.closing, there.bounds.width());
        }
        None
    }

    /// How long the ball is free at the least, from where it is, because all of the BREP is beyond a plane across a normal n: with
    /// n.x <= m on the BREP, its distance from c is at least (n.c - m) / |n|, and |n| is within 2^-50 of 1. Infinite: for good.
    fn until_plane(&mut self, time: f64, here: &Here, workspace: &mut Workspace) -> Option<f64> {
        /// Of sums of three products, in sums of magnitudes, and of |n|.
        const ROUNDING: f64 = 16.0 * f64::EPSILON;
        let (ball, off) = self.moved(time)?;
        let probe = Probe::HalfSpace(HalfSpace::new(-here.normal, 0.0).ok()?);
        let options = Options {
            contacts: Contacts::None,
            accuracy: Accuracy::Length(self.way / FINER),
            ..*self.options
        };
        let found = contact(self.brep, &probe, &options, workspace);
        self.work.nodes += workspace.work.nodes;
        let reach = ball.radius + self.options.prediction;
        let height = here.normal.dot(&ball.center.coords) + found.separation.bounds.lo - reach;
        let sizes = ball
            .center
            .coords
            .iter()
            .fold(reach.abs(), |s, x| s + x.abs());
        let free = height - ROUNDING * (sizes + found.separation.bounds.lo.abs()) - 2.0 * off;
        let speeds = self
            .motion
            .velocity
            .iter()
            .fold(0.0, |s: f64, x| s + x.abs());
        let closing = here.closing + ROUNDING * speeds + f64::MIN_POSITIVE;
        (free > 0.0).then(|| match closing > 0.0 {
            true => (free / closing * DOWN).min(f64::MAX),
            false => f64::INFINITY,
        })
    }

    /// Whether the ball is proven to be beyond the box of the faces for good.
    fn is_gone(&self, time: f64) -> bool {
        let Some((ball, off)) = self.moved(time) else {
            return false;
        };
        let Some(bounds) = self.brep.bounding_box() else {
            return false;
        };
        // A ball is out of reach of the box where a coordinate of its centre is this far out of it. Differences are rounded once each.
        let reach = (ball.radius + self.options.prediction.max(0.0)).next_up();
        (0..3).any(|c| {
            let [low, high] = bounds[c];
            let velocity = self.motion.velocity[c];
            let up = (ball.center[c] - off).next_down() - high;
            let down = low - (ball.center[c] + off).next_up();
            velocity >= 0.0 && up.next_down() > reach || velocity <= 0.0 && down.next_down() > reach
        })
    }

    fn run(mut self, workspace: &mut Workspace) -> ArrivalAnswer {
        let answer = self.search(workspace);
        workspace.work = self.work;
        answer
    }

    fn search(&mut self, workspace: &mut Workspace) -> ArrivalAnswer {
        let (mut lo, mut hi) = (0.0, f64::INFINITY);
        let mut why = Undecided::Budget;
        for step in 0..STEPS {
            let Some(here) = self.here(lo, workspace) else {
                // Beyond the range in which bounds hold.
                why = Undecided::Precision;
                break;
            };
            if here.bounds.hi <= 0.0 {
                hi = lo;
                break;
            }
            if here.bounds.lo > 0.0 && (self.speed == 0.0 || self.is_gone(lo)) {
                return ArrivalAnswer::default();
            }
            if let Some(found) = self.touch(lo, &here, workspace) {
                hi = hi.min(found);
            }
            let mut free = match here.bounds.lo {
                f64::INFINITY => f64::INFINITY,
                lo => (lo / self.speed * DOWN).min(f64::MAX),
            };
            if step >= PATIENCE
                && let Some(longer) = self.until_plane(lo, &here, workspace)
            {
                free = free.max(longer);
            }
            if free == f64::INFINITY && hi == f64::INFINITY {
                return ArrivalAnswer::default();
            }
            let next = (lo + free).next_down();
            // Bounds that say nothing leave the ball where it is.
            if !(next > lo) {
                why = match here.bounds.lo.is_finite() {
                    true => Undecided::Precision,
                    false => Undecided::Degenerate,
                };
                break;
            }
            if next >= self.motion.until && next < hi {
                return ArrivalAnswer::default();
            }
            lo = next.min(hi);
            if (hi - lo) * self.speed <= self.way || self.work.nodes > self.options.node_budget {
                break;
            }
        }
        let time = Enclosure { lo, hi };
        if hi == f64::INFINITY {
            return ArrivalAnswer::at(time, None, Some(why));
        }
        let undecided = ((hi - lo) * self.speed > self.way).then_some(why);
        let found = self.ask(hi, self.options.contacts, workspace);
        let found = found.map(|(found, off)| widened(found, 2.0 * off));
        let missing = missing(self.options, found.as_ref());
        ArrivalAnswer::at(time, found, undecided.or(missing))
    }
}
