//! Lists of contacts against their second method.

use crate::verify::Outcome;
use feeler::numeric::Dyadic;
use feeler::query::Probe;
use feeler_corpus::{ContactTruth, Query, SpaceBox, TruthEnclosure};
use feeler_oracle::second::{Second, SecondContact, SecondContacts, SecondSide};

/// Contacts nearer to each other than this part of the size are not told apart.
const SAME: f64 = 1.0 / (1u64 << 24) as f64;
/// The two methods join what cracks separate differently, and give the least value of either side: to this part of the
/// size. (The separation of the whole is held against a second enclosure exactly.)
const JOINED: f64 = 1.0 / (1u64 << 36) as f64;

fn apart(a: &SpaceBox, b: &SpaceBox) -> f64 {
    let gap = |k: usize| (a[k][0] - b[k][1]).max(b[k][0] - a[k][1]).max(0.0);
    gap(0).hypot(gap(1)).hypot(gap(2))
}

/// The list of the truth against the second method's.
pub(crate) fn held(
    second: &Second<'_>,
    breps: usize,
    size: f64,
    query: &Query,
    probe: &Probe,
    truths: &[ContactTruth],
) -> Outcome {
    let undecided = |why: &str| Outcome::Undecided(why.to_owned());
    if breps != 1 {
        return undecided("contacts of several BREPs");
    }
    let prediction = query.prediction.unwrap_or(0.0);
    // Distances in, and what is to be made of them.
    let (found, radius, material, reach) = match probe {
        Probe::HalfSpace(h) => {
            let found = second.half_space_contacts(h.normal.into(), h.offset, prediction, size);
            (found, 0.0, false, prediction)
        }
        Probe::Sphere(s) => {
            let center = s.center.coords.into();
            let material = match second.inside(center) {
                SecondSide::Inside => true,
                SecondSide::Outside => false,
                SecondSide::Undecided => return undecided("no rays that agree"),
            };
            let reach = s.radius + prediction;
            let nearest = match second.distance(center).and_then(|d| d.hi) {
                Some(d) if material => d.approximate().next_up(),
                _ => reach,
            };
            let limit = reach.max(nearest);
            let found = second.sphere_contacts(center, limit, size);
            (found, s.radius, material, reach)
        }
    };
    let found = match found {
        SecondContacts::All(all) => all,
        SecondContacts::Open(why) => return Outcome::Undecided(why),
    };
    let Some(radius) = Dyadic::from_f64(radius) else {
        return undecided("no radius");
    };
    let separation = |c: &SecondContact| {
        let [lo, hi] = &c.f;
        if material {
            TruthEnclosure {
                lo: &-hi - &radius,
                hi: &-lo - &radius,
            }
        } else {
            TruthEnclosure {
                lo: lo - &radius,
                hi: hi - &radius,
            }
        }
    };
    compare(&found, &separation, truths, reach, size)
}

fn compare(
    found: &[SecondContact],
    separation: &dyn Fn(&SecondContact) -> TruthEnclosure,
    truths: &[ContactTruth],
    reach: f64,
    size: f64,
) -> Outcome {
    let near = SAME * size;
    let mut width = 0.0f64;
    for c in found {
        // One about as far as the limit may be in the list or not.
        let well_within = c.f[1].approximate() < reach - JOINED * size;
        if well_within && !truths.iter().any(|t| apart(&t.at, &c.at) <= near) {
            return Outcome::Disagrees(format!(
                "a contact that the list lacks, near {:?}, at {:e}",
                c.at.map(|x| x[0]),
                c.f[0].approximate()
            ));
        }
    }
    for t in truths.iter().filter(|t| t.due && !t.continuum) {
        let at = t.at.map(|x| x[0]);
        let mut there = found.iter().filter(|c| apart(&t.at, &c.at) <= near);
        let Some(c) = there.next() else {
            return Outcome::Disagrees(format!("no contact near {at:?}"));
        };
        if there.next().is_some() {
            return Outcome::Disagrees(format!("two contacts near {at:?}"));
        }
        let s = separation(c);
        let off = (&s.lo - &t.separation.hi)
            .approximate()
            .max((&t.separation.lo - &s.hi).approximate());
        if off > JOINED * size {
            return Outcome::Disagrees(format!(
                "the contact near {at:?} is truly at {:e}, second {:e}",
                t.separation.lo.approximate(),
                s.lo.approximate()
            ));
        }
        width = width.max((&s.hi - &s.lo).approximate()).max(off);
    }
    if truths.iter().any(|t| t.due && t.continuum) {
        return Outcome::Undecided("a continuum".to_owned());
    }
    Outcome::Agrees(width / size)
}
