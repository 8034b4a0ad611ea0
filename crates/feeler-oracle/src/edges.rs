//! Edges: safe calls into C++.

use crate::bridge::ffi;
use crate::oracle::{Oracle, enclosure};
use crate::truth::{OracleError, TruthEnclosure};

impl Oracle {
    /// The width `d_e` of an edge's crack, enclosed; edges are numbered through all BREPs in order.
    /// `None` for an edge that is used less than twice.
    ///
    /// The largest Frechet distance between two images of the edge, each run through in whichever
    /// direction gives less: see the definitions in the crate `feeler`. To a relative width of 2^-10 or to
    /// 2^-100 of the model's size; where more than 600 cuts would be needed for that, what was
    /// reached. The first call prepares the model; 0.1 to 100 ms an edge, which is kept.
    ///
    /// # Errors
    /// [`OracleError::Refused`] where there is no such edge, or where an image of it is not known.
    pub fn crack_width(&self, edge: usize) -> Result<Option<TruthEnclosure>, OracleError> {
        let raw = ffi::crack_of(self.core(), edge)?;
        if !raw.known {
            return Err(OracleError::Refused(format!(
                "edge {edge}: an image of it is not known whole"
            )));
        }
        if !raw.shared {
            return Ok(None);
        }
        enclosure(&raw.width).map(Some)
    }
}
