//! Distances to small polynomial patches against all their critical points, in a build with the oracle.

use crate::verify::Outcome;
use feeler::numeric::Dyadic;
use feeler::nurbs::Surface;
use feeler_corpus::{Model, TruthEnclosure};
use feeler_oracle::{OracleError, critical_points};

/// Models of more faces take too long.
const MOST_FACES: usize = 4;
/// The largest product of the degrees: bicubic, 1.5 s of a core a point (0.5 s where it is 4). Higher degrees and rational
/// patches `critical_points` refuses: one rational bicubic point took the bivariate kernel 49 s.
const MOST_DEGREES: usize = 9;

/// The distance from a point to a model whose faces all are small polynomial patches, untrimmed; `None` of any other, and
/// where there are curves of critical points.
fn least(model: &Model, point: [f64; 3]) -> Result<Option<[Dyadic; 2]>, OracleError> {
    let faces: Vec<_> = model
        .breps
        .iter()
        .flat_map(|b| b.faces().iter().enumerate().map(move |(i, f)| (b, i, f)))
        .collect();
    if faces.len() > MOST_FACES {
        return Ok(None);
    }
    let mut least: Option<[Dyadic; 2]> = None;
    for (brep, i, face) in faces {
        let Surface::Nurbs(surface) = brep.surface(i) else {
            return Ok(None);
        };
        let [p, q] = [surface.knots_u(), surface.knots_v()].map(|k| k.degree());
        if face.loops.is_some() || p * q > MOST_DEGREES {
            return Ok(None);
        }
        let Some(found) = critical_points(surface, point)?.filter(|c| c.all) else {
            return Ok(None);
        };
        for c in found.points {
            let [lo, hi] = [c.distance.lo, c.distance.hi];
            least = Some(match least {
                None => [lo, hi],
                Some([a, b]) => [a.min(lo), b.min(hi)],
            });
        }
    }
    Ok(least)
}

/// A true distance (not signed) against the critical points, if they tell; else `outcome` as it is.
pub(crate) fn held(
    model: &Model,
    point: [f64; 3],
    truth: &TruthEnclosure,
    outcome: Outcome,
) -> Outcome {
    match least(model, point) {
        Ok(Some([lo, hi])) if hi < truth.lo || truth.hi < lo => Outcome::Disagrees(format!(
            "truly {:e}, at the nearest critical point {:e}",
            truth.lo.approximate(),
            lo.approximate()
        )),
        // This build has no oracle.
        Ok(_) | Err(OracleError::NotBuilt) => outcome,
        Err(e) => Outcome::Disagrees(e.to_string()),
    }
}
