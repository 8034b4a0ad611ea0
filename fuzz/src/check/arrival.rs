//! Arrivals against exact points of the faces.
//!
//! "Free until `lo`" is refuted by one exact point of a trimmed face and one time before `lo` at which the probe holds the point, or comes
//! nearer to it than the prediction; "never" likewise until the end of the motion. "Arrived at `hi`" is held against the contact that is
//! told there, against what the kernel says of the probe set down there, and, with more effort, against the second method.

use super::refute::{
    Goal, LED, NEAR, Place, dyadic, highest, in_region, led, most_squared, moved, sampled, square,
};
use super::{Effort, Found, Subject, options, radius, second_of};
use feeler::numeric::Dyadic;
use feeler::query::{
    self, Accuracy, ArrivalAnswer, Contacts, HalfSpace, Motion, Options, Probe, Sphere,
};
use feeler_corpus::Query;
use feeler_oracle::TruthEnclosure;
use feeler_oracle::second;
use nalgebra::Vector3;

/// How exactly full accuracy knows the way, as a part of the size.
const FULL: f64 = 1.0 / (1u64 << 40) as f64;
/// A plane comes nearer by more than this part of its way, or its rounding counts.
const ALONG: f64 = 1.0 / (1u64 << 40) as f64;
/// Sizes of the BREP that a probe is followed where it moves without end.
const FAR: f64 = (1u64 << 20) as f64;

pub(super) fn arrival(
    subject: &mut Subject<'_>,
    query: &Query,
    probe: &Probe,
    motion: &Motion,
    effort: Effort,
) -> Found {
    let asked = options(query);
    let found = query::arrival(
        &subject.prepared,
        probe,
        motion,
        &asked,
        &mut subject.workspace,
    );
    held(subject, &asked, probe, motion, &found, effort)
}

/// Holds an answer against what can be known of it.
fn held(
    subject: &mut Subject<'_>,
    asked: &Options,
    probe: &Probe,
    motion: &Motion,
    found: &ArrivalAnswer,
    effort: Effort,
) -> Found {
    sound(asked, probe, motion, found, subject.prepared.size())?;
    free(subject, asked, probe, motion, found)?;
    let arrived = found.time.map(|t| t.bounds.hi).filter(|t| t.is_finite());
    match arrived {
        Some(time) => there(subject, asked, probe, motion, found, (time, effort)),
        None => Ok(()),
    }
}

/// What holds of any answer.
fn sound(
    asked: &Options,
    probe: &Probe,
    motion: &Motion,
    found: &ArrivalAnswer,
    size: f64,
) -> Found {
    let Some(time) = found.time else {
        return match found.contacts.is_empty() && found.undecided.is_none() {
            true => Ok(()),
            false => Err("contacts or doubts where it never arrives".to_owned()),
        };
    };
    let b = time.bounds;
    if !(0.0 <= b.lo && b.lo <= time.value && time.value <= b.hi) {
        return Err(format!(
            "the time {:e} is not in [{:e}, {:e}]",
            time.value, b.lo, b.hi
        ));
    }
    let known = b.hi.is_finite();
    if b.lo > motion.until || known && b.hi > motion.until {
        return Err(format!(
            "[{:e}, {:e}] is after the motion, {:e}",
            b.lo, b.hi, motion.until
        ));
    }
    if known && time.value != b.hi {
        return Err(format!("the time {:e} is not {:e}", time.value, b.hi));
    }
    if !known && (found.undecided.is_none() || !found.contacts.is_empty()) {
        return Err("it may never arrive, and is decided or has contacts".to_owned());
    }
    if asked.contacts == Contacts::None && !found.contacts.is_empty() {
        return Err("contacts that were not asked for".to_owned());
    }
    let way = match asked.accuracy {
        Accuracy::Full => FULL * size,
        Accuracy::Length(length) => length,
    };
    // Lower bounds, as rounded as those of the product.
    let (speed, rounding) = match probe {
        Probe::Sphere(_) => (motion.velocity.norm() * (1.0 - 16.0 * f64::EPSILON), 0.0),
        // Its accuracy is that of the separation at the start, a quotient of which is the time. Along itself a plane comes no nearer.
        Probe::HalfSpace(h) => {
            let closing = h.normal.dot(&motion.velocity);
            let is_clear = closing > ALONG * motion.velocity.norm();
            let closing = if is_clear { closing } else { 0.0 };
            (closing, 64.0 * f64::EPSILON * closing * b.hi)
        }
    };
    if found.undecided.is_none() && (b.hi - b.lo).next_down() * speed > way + rounding {
        return Err(format!(
            "decided, but the way in [{:e}, {:e}] is longer than {way:e}",
            b.lo, b.hi
        ));
    }
    Ok(())
}

/// What is added to the offset of a half-space that moves, t n.v.
fn closing(plane: &HalfSpace, velocity: &Vector3<f64>, time: &Dyadic) -> Dyadic {
    (0..3).fold(Dyadic::ZERO, |sum, i| {
        &sum + &(&(&dyadic(plane.normal[i]) * &dyadic(velocity[i])) * time)
    })
}

/// No point of a face is within reach before the time at which it may be.
fn free(
    subject: &mut Subject<'_>,
    asked: &Options,
    probe: &Probe,
    motion: &Motion,
    found: &ArrivalAnswer,
) -> Found {
    let size = subject.prepared.size();
    let last = match found.time {
        // Of its start such an answer says nothing.
        Some(time) if time.bounds.lo == 0.0 => return Ok(()),
        Some(time) => time.bounds.lo,
        None => motion.until,
    };
    let speed = motion.velocity.norm();
    let last = match last.is_finite() {
        true => last,
        false if speed > 0.0 => (FAR * size / speed).min(f64::MAX),
        false => 0.0,
    };
    let prediction = dyadic(asked.prediction);
    let reach = &dyadic(radius(probe)) + &prediction;
    if matches!(probe, Probe::Sphere(_)) && reach.signum() <= 0 {
        return Ok(());
    }
    let goal = match probe {
        Probe::Sphere(s) => Goal::Swept {
            from: s.center,
            velocity: motion.velocity,
            until: last,
        },
        Probe::HalfSpace(h) => Goal::Height(h.normal, h.offset),
    };
    let about = reach.approximate();
    for p in places(subject, &goal) {
        let time = match probe {
            Probe::Sphere(_) => goal.time(&p.point),
            Probe::HalfSpace(h) if h.normal.dot(&motion.velocity) > 0.0 => last,
            Probe::HalfSpace(_) => 0.0,
        };
        if matches!(probe, Probe::Sphere(_)) && p.place.value > about + NEAR * (about + size) {
            continue;
        }
        let Some(uv) = in_region(subject, &p.place) else {
            continue;
        };
        let Ok(at) = second::evaluate(&[&subject.scene.brep], p.place.face, uv) else {
            continue;
        };
        let most = goal.most(&at.point);
        let is_within = match probe {
            Probe::Sphere(_) => most < square(&reach),
            Probe::HalfSpace(h) => {
                most < &closing(h, &motion.velocity, &dyadic(time)) + &prediction
            }
        };
        if is_within {
            let told = match found.time {
                Some(_) => format!("free until {last:e}"),
                None => "never to arrive".to_owned(),
            };
            return Err(format!(
                "claimed {told}, and at {time:e} the point of face {} at {uv:?} is within reach",
                p.place.face
            ));
        }
    }
    Ok(())
}

/// A place to try, and its point, about.
struct Spot {
    place: Place,
    point: nalgebra::Point3<f64>,
}

/// The best samples, and where these lead.
fn places(subject: &Subject<'_>, goal: &Goal) -> Vec<Spot> {
    let brep = &subject.scene.brep;
    let mut all = sampled(subject, goal);
    all.retain(|p| p.value.is_finite());
    all.sort_by(|a, b| a.value.total_cmp(&b.value));
    all.truncate(LED);
    let led: Vec<Place> = all
        .iter()
        .map(|p| led(brep.surface(p.face), goal, *p))
        .collect();
    all.into_iter()
        .chain(led)
        .map(|place| Spot {
            place,
            point: brep.surface(place.face).point(place.uv[0], place.uv[1]),
        })
        .collect()
}

/// The probe where it is at a time, rounded, and how far that is off: two roundings a coordinate, or those of three products.
fn set_down(probe: &Probe, motion: &Motion, time: f64) -> Option<(Probe, f64)> {
    let by = motion.velocity * time;
    let one = |v: &Vector3<f64>| v.iter().fold(0.0, |sum: f64, x| sum + x.abs());
    match probe {
        Probe::Sphere(s) => {
            let off = 2.0 * f64::EPSILON * (one(&s.center.coords) + one(&by)) + f64::MIN_POSITIVE;
            let moved = Sphere::new(s.center + by, s.radius).ok()?;
            Some((Probe::Sphere(moved), off))
        }
        Probe::HalfSpace(h) => {
            let off = 8.0 * f64::EPSILON * (h.offset.abs() + one(&by)) + f64::MIN_POSITIVE;
            let moved = HalfSpace::new(h.normal, h.offset + h.normal.dot(&by)).ok()?;
            Some((Probe::HalfSpace(moved), off))
        }
    }
}

/// It is within the prediction at the time at which it is told to be.
fn there(
    subject: &mut Subject<'_>,
    asked: &Options,
    probe: &Probe,
    motion: &Motion,
    found: &ArrivalAnswer,
    (time, effort): (f64, Effort),
) -> Found {
    let Some((there, off)) = set_down(probe, motion, time) else {
        return Ok(());
    };
    if asked.contacts == Contacts::Deepest && found.contacts.is_empty() && found.undecided.is_none()
    {
        return Err(format!("arrived at {time:e}, decided, without a contact"));
    }
    if let Some(first) = found.contacts.first() {
        let lo = first.separation.bounds.lo;
        if lo > asked.prediction {
            return Err(format!("arrived, and the deepest contact is at {lo:e}"));
        }
        foot(asked, probe, motion, first, (time, off))?;
    }
    // The same probe for a stranger: what the motion knew of the BREP is not used. Cracks may part two places of one centre by twice the way.
    let alone = Options {
        contacts: Contacts::None,
        prediction: f64::INFINITY,
        ..*asked
    };
    let other = query::contact(&subject.prepared, &there, &alone, &mut subject.workspace);
    let lo = other.separation.bounds.lo;
    let room = 2.0 * off + 4.0 * f64::EPSILON * asked.prediction.abs();
    if lo > asked.prediction + room {
        return Err(format!(
            "arrived at {time:e}, and the separation there is not below {lo:e}"
        ));
    }
    if effort == Effort::Full {
        by_second(subject, asked, &there, room)?;
    }
    Ok(())
}

/// The foot of the deepest contact is as near as the arrival says, up to the bound on its place and that of the rounded probe: exactly.
fn foot(
    asked: &Options,
    probe: &Probe,
    motion: &Motion,
    contact: &query::Contact,
    (time, off): (f64, f64),
) -> Found {
    let Some(bound) = contact.position_bound.and_then(Dyadic::from_f64) else {
        return Ok(());
    };
    let room = &bound + &dyadic(4.0 * off);
    let time = dyadic(time);
    let at = [0, 1, 2].map(|i| TruthEnclosure {
        lo: dyadic(contact.on_brep[i]),
        hi: dyadic(contact.on_brep[i]),
    });
    let near = match probe {
        Probe::Sphere(s) => {
            let from = moved(&s.center, &motion.velocity, &time);
            let reach = &(&dyadic(s.radius) + &dyadic(asked.prediction)) + &room;
            // In material a prediction below -r is met by what is far.
            reach.signum() <= 0 || most_squared(&at, &from) <= square(&reach)
        }
        Probe::HalfSpace(h) => {
            let gone = closing(h, &motion.velocity, &time);
            let level = &(&gone + &dyadic(h.offset)) + &dyadic(asked.prediction);
            // |n| <= 1 + 2^-50.
            let room = &room * &dyadic(1.0 + 4.0 * f64::EPSILON);
            highest(&at, &h.normal) <= &level + &room
        }
    };
    // The separation is that of the centre in material otherwise.
    if near || contact.separation.bounds.hi < -radius(probe) {
        Ok(())
    } else {
        Err(format!(
            "the foot {:?} is not within the reach of the probe where it arrives",
            contact.on_brep
        ))
    }
}

/// The second method on the probe where it arrives.
fn by_second(subject: &Subject<'_>, asked: &Options, moved: &Probe, room: f64) -> Found {
    let second = second_of(&subject.scene.brep);
    let (least, reach) = match moved {
        Probe::HalfSpace(h) => (
            second.half_space(h.normal.into(), h.offset).map(|b| b.lo),
            dyadic(asked.prediction),
        ),
        Probe::Sphere(s) => (
            second.distance(s.center.coords.into()).map(|b| b.lo),
            &dyadic(s.radius) + &dyadic(asked.prediction),
        ),
    };
    let Some(least) = least.filter(|l| *l > &reach + &dyadic(room)) else {
        return Ok(());
    };
    // In material all balls overlap.
    if let Probe::Sphere(s) = moved
        && subject.scene.brep.is_closed()
        && second.inside(s.center.coords.into()) != second::SecondSide::Outside
    {
        return Ok(());
    }
    Err(format!(
        "arrived, and the faces are {:e} away",
        least.approximate()
    ))
}
