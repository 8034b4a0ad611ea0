//! Derivative roots of trim curves: safe calls into C++.

use crate::bridge::ffi;
use crate::oracle::{Oracle, enclosure};
use crate::truth::{AxisRootsTruth, DerivativeRootTruth, DerivativeRootsTruth, OracleError};

fn axis(raw: &ffi::RawAxisRoots) -> Result<AxisRootsTruth, OracleError> {
    let root = |r: &ffi::RawDerivativeRoot| {
        Ok(DerivativeRootTruth {
            t: enclosure(&r.t)?,
            multiplicity: r.multiplicity.map(|m| m as usize),
            sign: r.sign,
            cusp: r.cusp,
        })
    };
    let part = |p: &ffi::RawPart| Ok([enclosure(&p.start)?, enclosure(&p.end)?]);
    Ok(AxisRootsTruth {
        roots: raw
            .roots
            .iter()
            .map(root)
            .collect::<Result<_, OracleError>>()?,
        constant: raw
            .constant
            .iter()
            .map(part)
            .collect::<Result<_, OracleError>>()?,
    })
}

/// Real numbers in [0, 1] near which the polynomial with these Bernstein coefficients may have roots, ascending:
/// eigenvalues of its colleague matrix, by Eigen (`cpp/root_candidates.hpp`). Nothing is proven of them; see
/// [`second::root_brackets`](crate::second::root_brackets).
///
/// # Errors
/// [`OracleError::NotBuilt`] without the feature `cgal`.
pub fn eigen_candidates(bernstein: &[f64]) -> Result<Vec<f64>, OracleError> {
    Ok(ffi::eigen_candidates(bernstein)?)
}

impl Oracle {
    /// All roots of u' and v' of trim `trim` of loop `trim_loop` of a face (both counted from 0), in
    /// the parameter of the trim's curve, over the trim's span: with multiplicities, each in an interval
    /// of its own of at most 2^-160 of its Bezier piece, and the parts where a coordinate is constant.
    ///
    /// CGAL's univariate algebraic kernel on the exact numerators `X'W - XW'`; see
    /// `cpp/derivative_roots.hpp`. 0.1 to 20 ms a piece, by degree.
    ///
    /// # Errors
    /// There must be such a trim.
    pub fn derivative_roots(
        &self,
        face: usize,
        trim_loop: usize,
        trim: usize,
    ) -> Result<DerivativeRootsTruth, OracleError> {
        self.check_face(face)?;
        let raw = ffi::derivative_roots_of(self.core(), face, trim_loop, trim)?;
        Ok(DerivativeRootsTruth {
            axes: [axis(&raw.u)?, axis(&raw.v)?],
        })
    }
}
