//! Trims that run along their curves.
//!
//! The format has a byte for trims that run against theirs, which openNURBS writes and does not heed when it reads: ends of such trims do not meet
//! there. So their curves are written the other way round, which is exact.

use crate::reversed::{negated, reversed_curve};
use feeler::brep::Brep;

/// The same BREP with such curves, if it has trims that run against theirs.
pub(super) fn directed(brep: &Brep) -> Option<Brep> {
    let mut parts = brep.parts().clone();
    if !parts.trims.iter().any(|t| t.reversed) {
        return None;
    }
    let mut uses = vec![0usize; parts.curves2.len()];
    for trim in &parts.trims {
        *uses.get_mut(trim.curve)? += 1;
    }
    for trim in parts.trims.iter_mut().filter(|t| t.reversed) {
        let curve = reversed_curve(&parts.curves2[trim.curve]).ok()?;
        if uses[trim.curve] == 1 {
            parts.curves2[trim.curve] = curve;
        } else {
            // Another trim runs along it.
            trim.curve = parts.curves2.len();
            parts.curves2.push(curve);
        }
        trim.span = negated(trim.span);
        trim.reversed = false;
    }
    Brep::new(parts).ok()
}
