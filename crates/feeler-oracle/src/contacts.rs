//! All contacts within a prediction: safe calls into C++.

use crate::bridge::ffi;
use crate::oracle::{Oracle, enclosure};
use crate::truth::{ContactTruth, ContactsTruth, InsideTruth, OracleError, TruthEnclosure};
use feeler::numeric::Dyadic;
use feeler::query::Probe;

fn entry(raw: &ffi::RawEntry) -> Result<(TruthEnclosure, ContactTruth), OracleError> {
    let f = enclosure(&raw.f)?;
    let a = raw.at;
    let truth = ContactTruth {
        separation: f.clone(),
        at: [[a[0], a[1]], [a[2], a[3]], [a[4], a[5]]],
        proven: raw.minimum,
        within: false,
        continuum: raw.continuum,
        face: usize::try_from(raw.face).ok(),
    };
    Ok((f, truth))
}

/// Whether an entry may hold the nearest point, at most this far away.
fn nearest_may_be(raw: &ffi::RawEntry, nearest: &Option<Dyadic>) -> bool {
    let lo = crate::oracle::dyadic(&raw.f.lo);
    matches!((lo, nearest), (Ok(lo), Some(d)) if lo <= *d)
}

fn dyadic(x: f64) -> Result<Dyadic, OracleError> {
    Dyadic::from_f64(x).ok_or_else(|| OracleError::Refused("a number is not finite".to_owned()))
}

impl Oracle {
    /// All contacts of a sphere or half-space with separation up to `prediction`, of each BREP on its own;
    /// with the centre of a sphere in a BREP's material, the nearest of it and those with
    /// `|c - x| <= radius + prediction`.
    ///
    /// Complete: every contact is in the box of one of the answer's entries; a `proven` entry has one.
    /// `cpp/contacts.hpp` has definition, method and proof. 5 to 500 ms.
    ///
    /// # Errors
    /// As [`Self::distance`]; [`OracleError::Refused`] where the side of the centre is undecided.
    pub fn contacts(&self, probe: &Probe, prediction: f64) -> Result<ContactsTruth, OracleError> {
        let mut all = ContactsTruth {
            contacts: Vec::new(),
            join: 0.0,
            whole: true,
        };
        for one in self.each_brep()? {
            let found = match probe {
                Probe::HalfSpace(h) => {
                    one.half_space_contacts(h.normal.into(), h.offset, prediction)
                }
                Probe::Sphere(s) => {
                    one.sphere_contacts(s.center.coords.into(), s.radius, prediction)
                }
            }?;
            all.join = all.join.max(found.join);
            all.whole &= found.whole;
            all.contacts.extend(found.contacts);
        }
        Ok(all)
    }

    /// A box that holds every point of the faces where the separation is attained, none of its sides longer than 2^-24
    /// of the model's size (about 1e-15 of it where the minimum is regular); `None` where such points are farther
    /// apart, the search took too long, or there are several BREPs. `separation` encloses the probe's.
    ///
    /// `cpp/contact_foot.hpp` has the proof. 1 to 50 ms.
    ///
    /// # Errors
    /// As [`Self::distance`].
    pub fn foot(
        &self,
        probe: &Probe,
        separation: &TruthEnclosure,
    ) -> Result<Option<[[f64; 2]; 3]>, OracleError> {
        if !self.is_single() {
            return Ok(None);
        }
        let up = |x: &Dyadic| x.approximate().next_up().next_up();
        let found = match probe {
            Probe::HalfSpace(h) => {
                let normal: [f64; 3] = h.normal.into();
                ffi::foot_of(self.core(), true, &normal, h.offset, up(&separation.hi))?
            }
            Probe::Sphere(s) => {
                // The distance is |separation + radius|, in material and outside.
                let r = dyadic(s.radius)?;
                let ends = [&separation.lo + &r, &separation.hi + &r];
                let limit = ends.iter().fold(0.0f64, |m, x| m.max(up(x)).max(up(&-x)));
                let center: [f64; 3] = s.center.coords.into();
                ffi::foot_of(self.core(), false, &center, 0.0, limit)?
            }
        };
        Ok(match found[..] {
            [x0, x1, y0, y1, z0, z1] => Some([[x0, x1], [y0, y1], [z0, z1]]),
            _ => None,
        })
    }

    /// The length within which points of the faces count as joined: four times the widest crack, as certified, no less
    /// than 2^-44 of the model's size and no more than 2^-12 of it.
    fn join(&self) -> Result<f64, OracleError> {
        if let Some(join) = self.join.get() {
            return Ok(*join);
        }
        let join = ffi::join_width(self.core())?;
        Ok(*self.join.get_or_init(|| join))
    }

    fn half_space_contacts(
        &self,
        normal: [f64; 3],
        offset: f64,
        prediction: f64,
    ) -> Result<ContactsTruth, OracleError> {
        let raw = ffi::contacts_of(self.core(), true, &normal, offset, prediction, self.join()?)?;
        let limit = dyadic(prediction)?;
        let mut contacts = Vec::new();
        for e in &raw.entries {
            let (f, mut truth) = entry(e)?;
            truth.within = e.held && f.hi <= limit;
            if f.lo <= limit {
                contacts.push(truth);
            }
        }
        Ok(ContactsTruth {
            contacts,
            join: raw.join,
            whole: raw.whole,
        })
    }

    fn sphere_contacts(
        &self,
        center: [f64; 3],
        radius: f64,
        prediction: f64,
    ) -> Result<ContactsTruth, OracleError> {
        let r = dyadic(radius)?;
        let reach = &r + &dyadic(prediction)?;
        let material = match self.inside(center)? {
            InsideTruth::Inside => true,
            InsideTruth::Outside | InsideTruth::Boundary => false,
            InsideTruth::Undecided(why) => return Err(OracleError::Refused(why)),
        };
        let nearest = match self.distance(center, None)? {
            Some(d) if material => Some(d.enclosure.hi),
            _ => None,
        };
        let up = |x: &Dyadic| x.approximate().next_up().next_up();
        let limit = nearest.iter().fold(up(&reach), |l, d| l.max(up(d)));
        let raw = ffi::contacts_of(self.core(), false, &center, 0.0, limit, self.join()?)?;
        let mut contacts = Vec::new();
        for e in &raw.entries {
            let (f, mut truth) = entry(e)?;
            if f.lo > reach && nearest.as_ref().is_none_or(|d| f.lo > *d) {
                continue;
            }
            // The nearest is in any case.
            let only = || {
                raw.entries
                    .iter()
                    .filter(|o| nearest_may_be(o, &nearest))
                    .count()
                    == 1
            };
            truth.within = e.held && (f.hi <= reach || (nearest_may_be(e, &nearest) && only()));
            truth.separation = if material {
                TruthEnclosure {
                    lo: &-&f.hi - &r,
                    hi: &-&f.lo - &r,
                }
            } else {
                TruthEnclosure {
                    lo: &f.lo - &r,
                    hi: &f.hi - &r,
                }
            };
            contacts.push(truth);
        }
        Ok(ContactsTruth {
            contacts,
            join: raw.join,
            whole: raw.whole,
        })
    }
}
