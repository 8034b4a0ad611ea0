//! The foot of a contact, and lists of contacts.

use super::{Asked, Fault, Judgement, Verdict, claim_verdict, ulp};
use crate::answer::ContactLine;
use crate::truth::{ContactTruth, SpaceBox, TruthEnclosure};
use feeler::query::{Accuracy, Probe};
use nalgebra::{Point3, Vector3};

/// The distance of a point from a box, up to a few roundings.
fn apart(point: &[f64; 3], at: &SpaceBox) -> f64 {
    let gaps = point.iter().zip(at);
    let square = gaps.map(|(x, [lo, hi])| (lo - x).max(x - hi).max(0.0).powi(2));
    square.sum::<f64>().sqrt()
}

/// Whether the foot is as near to its true place as it claims; no claim is right.
pub(super) fn foot_verdict(claim: &ContactLine, at: &SpaceBox) -> Judgement {
    /// Above the roundings of [`apart`].
    const ROUNDINGS: f64 = 1.0 - 16.0 * f64::EPSILON;
    let off = apart(&claim.on_brep, at);
    let Some(bound) = claim.position_bound else {
        return Judgement::right();
    };
    // NaN is wrong, too.
    if off * ROUNDINGS <= bound {
        Judgement::right()
    } else {
        let reason = format!("the foot is off by {off:e}, the bound is {bound:e}");
        Judgement::wrong(Fault::Value, reason)
    }
}

/// Whether the normal turns from its true direction by no more than it claims; no claim is right.
///
/// From the middle p of the true foot's box, whose diagonal is w, the direction to the centre c of a sphere at the
/// distance d is off by asin(w / 2 / d) <= 0.8 w / d at most, and by the roundings of p and of c - p, which are a few times
/// [`f64::EPSILON`] of the largest coordinate over d. The chord between two unit vectors is no longer than the angle.
pub(super) fn normal_verdict(
    asked: &Asked,
    claim: &ContactLine,
    separation: &TruthEnclosure,
    at: &SpaceBox,
) -> Judgement {
    /// Roundings of a vector of unit length, and of the chord.
    const ROUNDINGS: f64 = 16.0 * f64::EPSILON;
    let (Some(bound), Some(probe)) = (claim.normal_bound, asked.probe) else {
        return Judgement::right();
    };
    let (direction, slack) = match probe {
        // From the BREP into the half-space.
        Probe::HalfSpace(h) => (-h.normal, 0.0),
        Probe::Sphere(s) => {
            let middle = Point3::from(at.map(|[lo, hi]| 0.5 * lo + 0.5 * hi));
            let away = s.center - middle;
            // Out of material.
            let [lo, hi] = separation.raised(s.radius);
            let signed = 0.5 * (lo + hi);
            let width = Vector3::from(at.map(|[lo, hi]| hi - lo)).norm();
            let largest = s.center.coords.amax().max(middle.coords.amax());
            let off = (0.8 * width + 4.0 * f64::EPSILON * largest) / away.norm();
            (away * signed.signum(), off)
        }
    };
    // NaN, too: the centre is the foot.
    if !(slack < TELLING) {
        return Judgement::right();
    }
    let chord = (Vector3::from(claim.normal) - direction.normalize()).norm();
    // NaN is wrong, too.
    if chord <= bound + slack + ROUNDINGS {
        Judgement::right()
    } else {
        let reason = format!("the normal is off by {chord:e}, the bound is {bound:e}");
        Judgement::wrong(Fault::Value, reason)
    }
}

/// Of a continuum: points of it are no higher than the least by the accuracy, or by this part of the model's size (DESIGN, *Continuum*).
pub const CONTINUUM_SLACK: f64 = 1.0 / (1u64 << 44) as f64;

/// Whether the deepest contact fits itself, and its foot is as far away as the separation says: what holds of any contact, a continuum's too.
///
/// No point of a BREP is nearer than the separation. A foot that is off by its bound is farther by no more than that; one of many in a continuum, which have no bound,
/// is as low as it takes to be one. A foot p and its probe tell a normal: off by e, p turns it by asin(e / d) <= 1.6 e / d at the distance d.
pub(super) fn standing_verdict(
    asked: &Asked,
    claim: &ContactLine,
    separation: &TruthEnclosure,
    (continuum, undecided): (Option<bool>, &Option<String>),
) -> Judgement {
    let continuum = continuum == Some(true);
    let own = &claim.separation;
    let (Some(probe), Some(own_lo), Some(own_hi)) = (asked.probe, own.lo, own.hi) else {
        // Without bounds nothing is claimed that is as narrow as this.
        return Judgement::right();
    };
    let normal = Vector3::from(claim.normal);
    let [foot, on_probe] = [claim.on_brep, claim.on_probe].map(Point3::from);
    // How high the lowest point is: over the centre of a ball, below it in material, or along a half-space's normal.
    let (height, raised, largest, radius) = match probe {
        Probe::Sphere(s) => {
            let height = (foot - s.center).norm();
            (
                height,
                separation.raised(s.radius),
                s.center.coords.amax(),
                s.radius,
            )
        }
        Probe::HalfSpace(h) => {
            let height = h.normal.dot(&foot.coords);
            (height, separation.raised(h.offset), h.offset.abs(), 0.0)
        }
    };
    let [lo, hi] = [&separation.lo, &separation.hi].map(|x| x.approximate());
    let middle = 0.5 * (raised[0] + raised[1]);
    let least = match probe {
        Probe::Sphere(_) => middle.abs(),
        Probe::HalfSpace(_) => middle,
    };
    // A few roundings of coordinates, of the truth, and of what is made of them here.
    let largest = largest.max(foot.coords.amax()).max(asked.size);
    let rounded = 32.0 * f64::EPSILON * largest + (raised[1] - raised[0]);
    let wrong = |reason: String| Judgement::wrong(Fault::Value, reason);
    // Each is negated, so that what is no number is wrong.
    let length = normal.norm();
    if !((length - 1.0).abs() <= 16.0 * f64::EPSILON) {
        return wrong(format!("the normal's length is {length:?}"));
    }
    if !(height >= least - rounded) {
        let by = least - height;
        return wrong(format!("the foot is nearer than the BREP, by {by:e}"));
    }
    let slack = match (claim.position_bound, asked.accuracy) {
        (Some(bound), _) => bound,
        (None, _) if !continuum => f64::INFINITY,
        (None, Accuracy::Length(a)) => a.max(CONTINUUM_SLACK * asked.size),
        (None, Accuracy::Full) => {
            (CONTINUUM_SLACK * asked.size).max(2.0 * ulp(lo.abs().max(hi.abs())))
        }
    };
    // What is not decided tells of a foot no more than its bounds.
    if !(height <= least + slack.max(own_hi - own_lo) + rounded) {
        let by = height - least;
        return wrong(format!("the foot is farther away than the BREP, by {by:e}"));
    }
    let (true_normal, turned, there) = match probe {
        Probe::HalfSpace(h) => (
            -h.normal.normalize(),
            0.0,
            foot - h.normal * (height - h.offset),
        ),
        Probe::Sphere(s) => {
            let direction = (s.center - foot) * (middle.signum() / height);
            // Both may be off by what they claim to be.
            let own = claim.normal_bound.unwrap_or(0.0);
            let off = claim.position_bound.unwrap_or(0.0) + rounded;
            (
                direction,
                own + 1.6 * off / height,
                s.center - normal * s.radius,
            )
        }
    };
    let chord = (normal - true_normal).norm();
    // Next to the surface its normal counts, and a foot tells none: of a centre that may be on it, as far as the claim says, no more than on which side it is.
    let tells = turned <= TELLING && (continuum || claim.position_bound.is_some());
    let may_touch = match probe {
        Probe::Sphere(s) => own_lo <= -s.radius && -s.radius <= own_hi,
        Probe::HalfSpace(_) => false,
    };
    if tells && may_touch {
        let is_behind = normal.dot(&true_normal) < -TELLING - turned;
        // Where the side of the centre is what is not decided, none is claimed; nor where, by the claim's bounds, it may be on either side by more than a rounding.
        let may_be = |x: f64| own_lo < x && x < own_hi;
        let is_either = may_be((-radius).next_down()) && may_be((-radius).next_up());
        let tells_side = claim.normal_bound.is_some() || !is_either;
        if is_behind && tells_side && !claim.normal_is_choice && undecided.is_none() {
            return wrong("the normal points away from the centre".to_owned());
        }
    } else if tells && !(chord <= turned + 16.0 * f64::EPSILON) {
        return wrong(format!("the normal is off its foot's by {chord:e}"));
    }
    let off = (on_probe - there).norm();
    if !(off <= rounded + 32.0 * f64::EPSILON * radius) {
        return wrong(format!("the point on the probe is off by {off:e}"));
    }
    Judgement::right()
}

/// Beyond this a foot does not tell the direction: on the surface the normal is the face's.
const TELLING: f64 = 0.5;

/// Contacts nearer to each other than this part of the model's size are one.
const ONE_CONTACT: f64 = 1.0 / (1u64 << 24) as f64;

/// Each contact that is due must be reported, once, and nothing else. A contact is known by its foot: by the
/// nearest of the true boxes.
pub(super) fn contacts_verdict(
    asked: &Asked,
    claims: &[ContactLine],
    truths: &[ContactTruth],
    undecided: &Option<String>,
) -> Judgement {
    let mut all = Judgement::right();
    let near = ONE_CONTACT * asked.size;
    let mut found = vec![0usize; truths.len()];
    for (i, claim) in claims.iter().enumerate() {
        let apart = |t: &ContactTruth| apart(&claim.on_brep, &t.at);
        let nearest = (0..truths.len()).min_by(|a, b| {
            let by_place = apart(&truths[*a]).total_cmp(&apart(&truths[*b]));
            by_place.then(truths[*b].due.cmp(&truths[*a].due))
        });
        let Some(k) = nearest.filter(|k| apart(&truths[*k]) <= near) else {
            let reason = format!("a false contact: {i}, at {:?}", claim.on_brep);
            // By an answer that says it is not settled, and bounds on both sides of the prediction, it may be one and no more.
            let bounds = claim.separation.lo.zip(claim.separation.hi);
            let may_be =
                bounds.is_some_and(|(lo, hi)| lo <= asked.prediction && asked.prediction < hi);
            all = all.and(if undecided.is_some() && may_be {
                Judgement::new(Verdict::Undecided, reason)
            } else {
                Judgement::wrong(Fault::FalseContact, reason)
            });
            continue;
        };
        found[k] += 1;
        let truth = &truths[k];
        if truth.due && !truth.continuum {
            let mut one = claim_verdict(
                &claim.separation,
                &truth.separation,
                "a contact",
                asked.tolerance,
            );
            // Its width is its own affair.
            one.error = None;
            all = all.and(one).and(foot_verdict(claim, &truth.at));
        }
    }
    for (truth, count) in truths.iter().zip(found) {
        if truth.due && count == 0 {
            let reason = format!(
                "a missed contact: near {:?}, separation near {:e}",
                truth.at.map(|x| x[0]),
                truth.separation.lo.approximate()
            );
            // An answer that says it is not whole has claimed nothing.
            all = all.and(match undecided {
                None => Judgement::wrong(Fault::MissedContact, reason),
                Some(_) => Judgement::new(Verdict::Undecided, reason),
            });
        }
        if count > 1 && !truth.continuum {
            let reason = format!(
                "{count} contacts for one, near {:?}",
                truth.at.map(|x| x[0])
            );
            all = all.and(Judgement::wrong(Fault::FalseContact, reason));
        }
    }
    all
}
