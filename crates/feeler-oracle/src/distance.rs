//! Distances: safe calls into C++.

use crate::bridge::ffi;
use crate::oracle::{Oracle, enclosure};
use crate::truth::{DistanceStatus, DistanceTruth, OracleError};

/// Stands for the budget that C++ has as its default.
const DEFAULT_BUDGET: i64 = -1;

fn truth(raw: ffi::RawDistance) -> Result<Option<DistanceTruth>, OracleError> {
    if !raw.finite {
        return Ok(None);
    }
    Ok(Some(DistanceTruth {
        enclosure: enclosure(&raw.enclosure)?,
        status: match raw.status {
            0 => DistanceStatus::Regular,
            1 => DistanceStatus::EdgeOrCorner,
            2 => DistanceStatus::IntervalOnly,
            3 => DistanceStatus::Budget,
            _ => return Err(OracleError::Defect("an unknown status")),
        },
        face: usize::try_from(raw.face).ok(),
        nodes: [raw.nodes64, raw.nodes],
    }))
}

fn budget(nodes: Option<u32>) -> i64 {
    nodes.map_or(DEFAULT_BUDGET, i64::from)
}

impl Oracle {
    /// The distance from a point to the union of the trimmed faces, enclosed; `None` if there is
    /// no face. `nodes` limits the work (boxes in 320-bit intervals; by default 20,000).
    ///
    /// Branch and bound with Bernstein bounds in doubles, then in MPFR intervals; see
    /// `cpp/distance.hpp` for the proof of each step. 1 to 30 ms; the first query also prepares
    /// the model.
    ///
    /// # Errors
    /// The point must be finite and within 1e60; so must the model.
    pub fn distance(
        &self,
        point: [f64; 3],
        nodes: Option<u32>,
    ) -> Result<Option<DistanceTruth>, OracleError> {
        let [x, y, z] = point;
        truth(ffi::distance_to(self.core(), x, y, z, budget(nodes))?)
    }

    /// The minimum of `normal . x - offset` over the union of the trimmed faces, with `normal`
    /// as given: the separation of the half-space `normal . x <= offset`. Otherwise as
    /// [`Self::distance`].
    ///
    /// # Errors
    /// The numbers must be finite and within 1e60; so must the model.
    pub fn half_space(
        &self,
        normal: [f64; 3],
        offset: f64,
        nodes: Option<u32>,
    ) -> Result<Option<DistanceTruth>, OracleError> {
        let [x, y, z] = normal;
        truth(ffi::support_of(
            self.core(),
            x,
            y,
            z,
            offset,
            budget(nodes),
        )?)
    }
}
