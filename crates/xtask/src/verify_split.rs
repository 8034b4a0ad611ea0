//! Derivative roots against their second method.

use crate::verify::Outcome;
use feeler::brep::Brep;
use feeler_corpus::{AxisSplitTruth, TrimLine, TruthEnclosure};
use feeler_oracle::{AxisRootsTruth, OracleError, second};

fn meet(a: &TruthEnclosure, b: &feeler_oracle::TruthEnclosure) -> bool {
    a.lo <= b.hi && b.lo <= a.hi
}

fn axis(truth: &AxisSplitTruth, found: &AxisRootsTruth) -> bool {
    truth.roots.len() == found.roots.len()
        && truth.constant.len() == found.constant.len()
        && truth.roots.iter().zip(&found.roots).all(|(a, b)| {
            meet(&a.t, &b.t) && (a.multiplicity, a.turns) == (b.multiplicity, b.turns())
        })
        && truth
            .constant
            .iter()
            .zip(&found.constant)
            .all(|(a, b)| meet(&a[0], &b[0]) && meet(&a[1], &b[1]))
}

/// The truth of u' and v' against the second method.
pub(crate) fn held(breps: &[&Brep], at: TrimLine, truth: [&AxisSplitTruth; 2]) -> Outcome {
    match second::derivative_roots(breps, at.face, at.trim_loop, at.trim) {
        Ok(found) if truth.into_iter().zip(&found.axes).all(|(t, f)| axis(t, f)) => {
            Outcome::Agrees(0.0)
        }
        Ok(_) => Outcome::Disagrees("the second method has other roots".to_owned()),
        Err(OracleError::Refused(why)) => Outcome::Undecided(why),
        Err(e) => Outcome::Disagrees(e.to_string()),
    }
}
