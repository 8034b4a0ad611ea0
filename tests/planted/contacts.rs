//! Mistakes in lists of contacts.
//!
//! The truth of the suite is a list of boxes with an enclosure each, of which those that are `due` must be answered.

use crate::found_where;
use feeler::query::Probe;
use feeler_corpus::{Answer, Ask, Body, Claim, ContactLine, Truth};

/// How far a contact is put where there is none, in model units (mm): 1e-4 of the size of the smallest model, and far
/// above what counts as the same place.
const ELSEWHERE: f64 = 1e-3;
/// What a foot is moved by beyond its bound, in mm: above the size of a true box that is a point.
const BEYOND: f64 = 1e-11;

/// Contacts that are all points and must be answered.
fn points(truth: &Truth) -> bool {
    let Truth::Contact {
        contacts: Some(all),
        ..
    } = truth
    else {
        return false;
    };
    all.iter().all(|c| c.due && !c.continuum)
}

/// The deepest contact alone is known, as a point.
fn sole_foot(truth: &Truth) -> bool {
    matches!(truth, Truth::Contact { foot: Some(at), contacts: None, .. }
        if at.iter().all(|[lo, hi]| hi - lo < 0.1 * BEYOND))
}

/// The same answer with a change in its list.
fn with_contacts(answer: &Answer, change: fn(&mut Vec<ContactLine>) -> Option<()>) -> Option<Body> {
    let mut body = answer.body.clone();
    let Body::Contact {
        contacts,
        undecided: None,
        ..
    } = &mut body
    else {
        return None;
    };
    change(contacts)?;
    Some(body)
}

/// Each mistake must be found for what it is.
fn must_be_called(called: &str, what: &str, mistake: crate::Mistake) {
    let reasons = found_where("contacts", what, points, mistake);
    assert!(
        reasons.iter().all(|r| r.contains(called)),
        "{what}: {reasons:?}"
    );
}

#[test]
fn a_missed_contact() {
    must_be_called("a missed contact", "no last contact", |_, _, answer, _| {
        with_contacts(answer, |all| {
            // A sole contact is missed as the separation's, too.
            (all.len() > 1).then(|| all.pop())?.map(|_| ())
        })
    });
}

#[test]
fn a_false_contact() {
    must_be_called("a false contact", "one elsewhere", |_, _, answer, _| {
        with_contacts(answer, |all| {
            let mut another = all.last()?.clone();
            another.on_brep[0] += ELSEWHERE;
            all.push(another);
            Some(())
        })
    });
}

#[test]
fn a_doubled_contact() {
    must_be_called("2 contacts for one", "one twice", |_, _, answer, _| {
        with_contacts(answer, |all| {
            all.push(all.last()?.clone());
            Some(())
        })
    });
}

/// By twice its bound, which stays.
#[test]
fn a_foot_off_by_more_than_its_bound() {
    must_be_called("the foot is off", "a foot off", |_, _, answer, _| {
        with_contacts(answer, |all| {
            let foot = all.iter_mut().rfind(|c| c.position_bound.is_some())?;
            foot.on_brep[0] += 2.0 * foot.position_bound? + BEYOND;
            Some(())
        })
    });
}

/// The next f64 above the enclosure of a contact that is not the deepest.
#[test]
fn a_contact_of_another_depth() {
    must_be_called("a contact", "another depth", |_, _, answer, _| {
        with_contacts(answer, |all| {
            let next = all.get_mut(1)?.separation.hi?.next_up();
            all[1].separation = Claim {
                value: next,
                lo: Some(next),
                hi: Some(next),
            };
            Some(())
        })
    });
}

/// A distance in model units at which roundings of a foot turn the direction to it by far less than 1e-6.
const TELLING: f64 = 1e-6;

/// Of the deepest contact, in suites that ask for it alone.
#[test]
fn a_foot_or_a_normal_of_the_deepest_off_by_more_than_its_bound() {
    for suite in ["contact-sphere", "contact-half-space"] {
        let foot: crate::Mistake = |_, _, answer, _| {
            with_contacts(answer, |all| {
                let foot = all.first_mut()?;
                foot.on_brep[0] += 2.0 * foot.position_bound? + BEYOND;
                Some(())
            })
        };
        let normal: crate::Mistake = |_, query, answer, _| {
            if let (Ask::Contact(Probe::Sphere(s)), Body::Contact { contacts, .. }) =
                (&query.ask, &answer.body)
            {
                // From a centre next to it a foot in f64 does not tell the direction to 1e-6.
                let foot = contacts.first()?.on_brep;
                if (0..3).all(|k| (s.center[k] - foot[k]).abs() < TELLING) {
                    return None;
                }
            }
            with_contacts(answer, |all| {
                let foot = all.first_mut()?;
                // Turned about an axis that it is not near to, by twice the bound and 1e-6 more.
                let by = 2.0 * foot.normal_bound? + 1e-6;
                let [x, y, z] = foot.normal;
                foot.normal = if z.abs() < 0.5 {
                    [x - by * y, y + by * x, z]
                } else {
                    [x, y - by * z, z + by * y]
                };
                Some(())
            })
        };
        // A half-space's normal is the probe's own: no bound is claimed for it.
        let mistakes = [("the foot is off", foot), ("the normal is off", normal)];
        let count = if suite == "contact-sphere" { 2 } else { 1 };
        for (called, mistake) in mistakes.into_iter().take(count) {
            let reasons = found_where(suite, called, sole_foot, mistake);
            assert!(reasons.iter().all(|r| r.contains(called)), "{reasons:?}");
        }
    }
}
