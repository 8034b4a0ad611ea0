//! Derivative roots against their second method, and, in a build with Eigen, against its eigenvalues.

use crate::verify::Outcome;
use feeler::brep::Brep;
use feeler_corpus::{AxisSplitTruth, TrimLine, TruthEnclosure};
use feeler_oracle::{AxisRootsTruth, OracleError, eigen_candidates, second};

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

/// Each place about an eigenvalue where the derivative changes its sign must have a root of its own. (Those of the truth
/// that no eigenvalue finds, multiple or clustered, say nothing.)
fn by_eigenvalues(breps: &[&Brep], at: TrimLine, truth: [&AxisSplitTruth; 2]) -> Outcome {
    let at = [at.face, at.trim_loop, at.trim];
    match second::root_brackets(breps, at, &eigen_candidates) {
        Ok(brackets) => {
            let missed = truth.into_iter().zip(&brackets).any(|(t, brackets)| {
                let mut roots = t.roots.iter();
                !brackets.iter().all(|b| roots.any(|r| meet(&r.t, b)))
            });
            if missed {
                Outcome::Disagrees("a root near an eigenvalue is missing".to_owned())
            } else {
                Outcome::Agrees(0.0)
            }
        }
        // This build has no Eigen.
        Err(OracleError::NotBuilt) => Outcome::Agrees(0.0),
        Err(e) => Outcome::Disagrees(e.to_string()),
    }
}

/// The truth of u' and v' against the second method.
pub(crate) fn held(breps: &[&Brep], at: TrimLine, truth: [&AxisSplitTruth; 2]) -> Outcome {
    match second::derivative_roots(breps, at.face, at.trim_loop, at.trim) {
        Ok(found) if truth.into_iter().zip(&found.axes).all(|(t, f)| axis(t, f)) => {
            by_eigenvalues(breps, at, truth)
        }
        Ok(_) => Outcome::Disagrees("the second method has other roots".to_owned()),
        Err(OracleError::Refused(why)) => Outcome::Undecided(why),
        Err(e) => Outcome::Disagrees(e.to_string()),
    }
}
