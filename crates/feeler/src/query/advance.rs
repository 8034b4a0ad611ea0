//! Conservative advancement of a ball along a way: the steps, and what proves them. Definition, method and guarantee: see [`super::arrival`].

use super::answer::{
    Accuracy, ContactAnswer, Contacts, HalfSpace, Options, Probe, Sphere, Undecided,
};
use super::arrival::{ArrivalAnswer, missing, widened};
use super::contact::{Witness, contact, contact_from};
use super::{Work, Workspace};
use crate::numeric::{Ball, Dd, Enclosure};
use crate::prepare::PreparedBrep;
use nalgebra::{Point3, Vector3};

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
pub(super) const DOWN: f64 = 1.0 - 8.0 * f64::EPSILON;
pub(super) const UP: f64 = 1.0 + 8.0 * f64::EPSILON;
/// By how many times a way its ends' signed distances may differ, where it may pass a crack: at least 1.6 (see `feeler-rapier`, module `ball`).
const CRACKS: f64 = 2.0;

/// How the centre of a ball moves, in the frame of a BREP. What it says is taken for proven.
pub trait Way {
    /// The centre at a time, rounded, and how far it may be from the true one; not finite where that is not known.
    fn center(&self, time: f64) -> (Point3<f64>, f64);

    /// A time within which the true centre moves by no more than `length`, from where it is at `time`. As long as can be said; infinite
    /// where it stands still.
    fn least_time(&self, time: f64, length: f64) -> f64;

    /// Its velocity at a time: where to look, no proof.
    fn velocity(&self, time: f64) -> Vector3<f64>;

    /// The velocity and how far it may be from the true one, of a way that is straight and has one speed.
    fn steady(&self) -> Option<(Vector3<f64>, f64)> {
        None
    }
}

/// A straight way at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightWay {
    /// The centre at the time 0.
    pub center: Point3<f64>,
    /// How far that may be from the true one.
    pub center_bound: f64,
    /// In model units a unit of time.
    pub velocity: Vector3<f64>,
    /// How far that may be from the true one.
    pub velocity_bound: f64,
}

/// The length of a vector, scaled first, so that squares of small ones survive; rounded.
fn length(v: &Vector3<f64>) -> f64 {
    match v.amax() {
        0.0 => 0.0,
        scale => scale * (v / scale).norm(),
    }
}

impl StraightWay {
    /// A bound of the speed.
    fn speed(&self) -> f64 {
        let speed = match length(&self.velocity) {
            0.0 => 0.0,
            // Below normal numbers products lose digits: what is added is more than that.
            speed => speed * UP + f64::MIN_POSITIVE,
        };
        match self.velocity_bound {
            0.0 => speed,
            bound => (speed + bound).next_up(),
        }
    }
}

impl Way for StraightWay {
    fn center(&self, time: f64) -> (Point3<f64>, f64) {
        if time == 0.0 {
            return (self.center, self.center_bound);
        }
        let by = self.velocity * time;
        // Two roundings a coordinate.
        let one = |v: &Vector3<f64>| v.iter().fold(0.0, |sum: f64, x| sum + x.abs());
        let own = 2.0 * f64::EPSILON * (one(&self.center.coords) + one(&by)) + f64::MIN_POSITIVE;
        let given = self.center_bound + self.velocity_bound * time.abs();
        let bound = if given > 0.0 { (own + given) * UP } else { own };
        (self.center + by, bound)
    }

    fn least_time(&self, _: f64, length: f64) -> f64 {
        let speed = self.speed();
        // What is no number may be any, and `amax` leaves it out.
        let known = self.velocity.iter().all(|v| v.is_finite()) && speed < f64::INFINITY;
        match length {
            _ if !(length > 0.0 && known) => 0.0,
            f64::INFINITY => f64::INFINITY,
            _ if speed == 0.0 => f64::INFINITY,
            _ => (length / speed * DOWN).min(f64::MAX),
        }
    }

    fn velocity(&self, _: f64) -> Vector3<f64> {
        self.velocity
    }

    fn steady(&self) -> Option<(Vector3<f64>, f64)> {
        Some((self.velocity, self.velocity_bound))
    }
}

/// When a ball that goes some way, from one time until another, comes to a BREP: as [`arrival`](super::arrival()).
///
/// The accuracy is a length: the enclosure is no wider than a time in which the ball cannot move farther. A radius or a centre beyond
/// what a [`Sphere`] may have leaves it undecided from there on.
pub fn arrival_along(
    brep: &PreparedBrep,
    radius: f64,
    way: &dyn Way,
    [from, until]: [f64; 2],
    options: &Options,
    workspace: &mut Workspace,
) -> ArrivalAnswer {
    let mut advance = Advance::new(brep, radius, way, options);
    let answer = advance.search(from, until, workspace);
    workspace.work = advance.work;
    answer
}

/// The contacts of the ball at a time, their separations for the true centre; none if the centre is beyond the range in which bounds hold.
pub(super) fn contacts_at(
    brep: &PreparedBrep,
    radius: f64,
    way: &dyn Way,
    time: f64,
    options: &Options,
    workspace: &mut Workspace,
) -> Option<ContactAnswer> {
    let mut advance = Advance::new(brep, radius, way, options);
    let (found, off) = advance.ask(time, options.contacts, workspace)?;
    Some(widened(found, CRACKS * off))
}

/// A separation less the prediction; infinite where there is nothing to be separate from, whatever the prediction.
pub(super) fn from_prediction(s: Enclosure, prediction: f64) -> Enclosure {
    let less = |x: f64| Ball::<Dd>::difference(x, prediction);
    let infinite = |x: f64| match x {
        f64::INFINITY => x,
        _ => x - prediction,
    };
    match prediction.is_finite() {
        true => Enclosure {
            lo: if s.lo.is_finite() {
                less(s.lo).lower()
            } else {
                s.lo
            },
            hi: if s.hi.is_finite() {
                less(s.hi).upper()
            } else {
                s.hi
            },
        },
        false => Enclosure {
            lo: infinite(s.lo),
            hi: infinite(s.hi),
        },
    }
}

/// Rounded down; infinite stays so.
fn less_by(x: f64, by: f64) -> f64 {
    match x {
        f64::INFINITY => x,
        _ => (x - by).next_down(),
    }
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
    radius: f64,
    way: &'a dyn Way,
    options: &'a Options,
    /// How exactly the way is asked for.
    exactly: f64,
    witness: Witness,
    work: Work,
}

impl<'a> Advance<'a> {
    fn new(brep: &'a PreparedBrep, radius: f64, way: &'a dyn Way, options: &'a Options) -> Self {
        Self {
            brep,
            radius,
            way,
            options,
            exactly: match options.accuracy {
                Accuracy::Full => FULL * brep.size(),
                Accuracy::Length(a) => a,
            },
            witness: Witness::default(),
            work: Work::default(),
        }
    }

    /// The ball at a time, and how far its centre may be from the true one.
    fn moved(&self, time: f64) -> Option<(Sphere, f64)> {
        let (center, off) = self.way.center(time);
        let ball = Sphere::new(center, self.radius).ok()?;
        off.is_finite().then_some((ball, off))
    }

    fn ask(
        &mut self,
        time: f64,
        contacts: Contacts,
        workspace: &mut Workspace,
    ) -> Option<(ContactAnswer, f64)> {
        let (ball, off) = self.moved(time)?;
        let options = Options {
            accuracy: match self.options.accuracy {
                Accuracy::Full => Accuracy::Full,
                Accuracy::Length(a) => Accuracy::Length(a / FINER),
            },
            prediction: match contacts {
                // Two faces that are reached together are both: the later one is nearer than what the way is known to.
                Contacts::All => self.options.prediction + self.exactly + CRACKS * off,
                _ => f64::INFINITY,
            },
            contacts,
            node_budget: self.left(),
        };
        let probe = Probe::Sphere(ball);
        let found = contact_from(self.brep, &probe, &mut self.witness, &options, workspace);
        self.count(workspace);
        Some((found, off))
    }

    fn count(&mut self, workspace: &Workspace) {
        self.work.nodes += workspace.work.nodes;
        self.work.contacts += workspace.work.contacts;
        self.work.rays += workspace.work.rays;
    }

    /// What is left of the budget.
    fn left(&self) -> usize {
        self.options.node_budget.saturating_sub(self.work.nodes)
    }

    fn here(&mut self, time: f64, workspace: &mut Workspace) -> Option<Here> {
        let (found, off) = self.ask(time, Contacts::Deepest, workspace)?;
        let s = found.separation;
        let bounds = from_prediction(s.bounds, self.options.prediction);
        let normal = found
            .contacts
            .first()
            .map_or(Vector3::zeros(), |c| c.normal);
        Some(Here {
            bounds: match off {
                0.0 => bounds,
                _ => Enclosure {
                    lo: less_by(bounds.lo, CRACKS * off),
                    hi: (bounds.hi + CRACKS * off).next_up(),
                },
            },
            value: s.value - self.options.prediction,
            normal,
            closing: -normal.dot(&self.way.velocity(time)),
        })
    }

    /// A time at which the ball is proven to have arrived, found by Newton's method from a time at which it has not.
    fn touch(
        &mut self,
        [from, until]: [f64; 2],
        here: &Here,
        workspace: &mut Workspace,
    ) -> Option<f64> {
        let (mut time, mut value, mut closing) = (from, here.value, here.closing);
        let mut width = here.bounds.width();
        for _ in 0..NEWTON {
            let speed = length(&self.way.velocity(time));
            if !(closing > 0.0 && speed > 0.0) || self.left() == 0 {
                return None;
            }
            // A little too far, so that the enclosure there is below zero; the less, the slower it comes nearer.
            let beyond = (4.0 * self.exactly / FINER * (closing / speed)).max(2.0 * width);
            let step = (value + beyond) / closing;
            // At least to the next number, where the last step was one of rounding.
            time = if step > 0.0 {
                (time + step).max(time.next_up())
            } else {
                time + step
            };
            if !(time >= from && time <= until) {
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
        let (velocity, velocity_bound) = self.way.steady()?;
        let (ball, off) = self.moved(time)?;
        let probe = Probe::HalfSpace(HalfSpace::new(-here.normal, 0.0).ok()?);
        let options = Options {
            contacts: Contacts::None,
            accuracy: Accuracy::Length(self.exactly / FINER),
            node_budget: self.left(),
            ..*self.options
        };
        let found = contact(self.brep, &probe, &options, workspace);
        self.count(workspace);
        let reach = ball.radius + self.options.prediction;
        let height = here.normal.dot(&ball.center.coords) + found.separation.bounds.lo - reach;
        let sizes = ball
            .center
            .coords
            .iter()
            .fold(reach.abs(), |s, x| s + x.abs());
        let free = height - ROUNDING * (sizes + found.separation.bounds.lo.abs()) - CRACKS * off;
        let speeds = velocity.iter().fold(0.0, |s: f64, x| s + x.abs());
        let rounding = ROUNDING * speeds + f64::MIN_POSITIVE + UP * velocity_bound;
        let closing = -here.normal.dot(&velocity) + rounding;
        (free > 0.0 && closing.is_finite()).then(|| match closing > 0.0 {
            true => (free / closing * DOWN).min(f64::MAX),
            false => f64::INFINITY,
        })
    }

    /// Whether the ball is proven to be beyond the box of the faces for good.
    fn is_gone(&self, time: f64) -> bool {
        let Some((velocity, velocity_bound)) = self.way.steady() else {
            return false;
        };
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
            let velocity = velocity[c];
            let up = (ball.center[c] - off).next_down() - high;
            let down = low - (ball.center[c] + off).next_up();
            velocity >= velocity_bound && up.next_down() > reach
                || velocity <= -velocity_bound && down.next_down() > reach
        })
    }

    fn search(&mut self, from: f64, until: f64, workspace: &mut Workspace) -> ArrivalAnswer {
        let (mut lo, mut hi) = (from, f64::INFINITY);
        if self.options.prediction.is_nan() {
            // Nothing can be said of what is no number.
            return ArrivalAnswer::at(Enclosure { lo, hi }, None, Some(Undecided::Degenerate));
        }
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
            let mut free = match here.bounds.lo > 0.0 {
                true => self.way.least_time(lo, here.bounds.lo),
                false => 0.0,
            };
            if here.bounds.lo > 0.0 && (free == f64::INFINITY || self.is_gone(lo)) {
                return ArrivalAnswer::default();
            }
            if let Some(found) = self.touch([lo, until], &here, workspace) {
                hi = hi.min(found);
            }
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
                    _ if self.left() == 0 => Undecided::Budget,
                    true => Undecided::Precision,
                    false => Undecided::Degenerate,
                };
                break;
            }
            if next >= until && next < hi {
                return ArrivalAnswer::default();
            }
            lo = next.min(hi);
            if self.is_known(lo, hi) || self.left() == 0 {
                break;
            }
        }
        let time = Enclosure { lo, hi };
        if hi == f64::INFINITY {
            return ArrivalAnswer::at(time, None, Some(why));
        }
        let undecided = (!self.is_known(lo, hi)).then_some(why);
        // A budget of its own, however the search went: what is found is told with its contacts.
        let spent = std::mem::take(&mut self.work);
        let found = self.ask(hi, self.options.contacts, workspace);
        self.work.nodes += spent.nodes;
        self.work.contacts += spent.contacts;
        self.work.rays += spent.rays;
        let found = found.map(|(found, off)| widened(found, CRACKS * off));
        let missing = missing(self.options, found.as_ref());
        ArrivalAnswer::at(time, found, undecided.or(missing))
    }

    /// Whether the times are near enough to each other.
    fn is_known(&self, lo: f64, hi: f64) -> bool {
        hi == lo || hi < f64::INFINITY && hi - lo <= self.way.least_time(lo, self.exactly)
    }
}
