//! The oracle of a build without the feature `cgal`: it cannot be made.

use crate::truth::{
    ContactsTruth, CriticalPoints, DerivativeRootsTruth, DistanceTruth, Evaluation, InsideTruth,
    LineTruth, OracleError, Shared, SideTruth, TruthEnclosure,
};
use feeler::brep::Brep;
use feeler::nurbs::{Limit, NurbsSurface};
use feeler::query::{LineKind, Probe};
use std::convert::Infallible;

/// Exact truth about BREPs; this build has none, and [`Oracle::new`] says so.
#[derive(Debug)]
pub struct Oracle {
    never: Infallible,
}

/// # Errors
/// Always [`OracleError::NotBuilt`].
pub fn critical_points(
    _surface: &NurbsSurface,
    _point: [f64; 3],
) -> Result<Option<CriticalPoints>, OracleError> {
    Err(OracleError::NotBuilt)
}

/// # Errors
/// Always [`OracleError::NotBuilt`].
pub fn eigen_candidates(_bernstein: &[f64]) -> Result<Vec<f64>, OracleError> {
    Err(OracleError::NotBuilt)
}

impl Oracle {
    /// # Errors
    /// Always [`OracleError::NotBuilt`].
    pub fn new(_breps: &[&Brep]) -> Result<Self, OracleError> {
        Err(OracleError::NotBuilt)
    }

    /// How many faces all BREPs have together.
    pub fn faces(&self) -> usize {
        match self.never {}
    }

    /// Makes what queries share.
    pub fn prepare(&self, _what: Shared) -> Result<(), OracleError> {
        match self.never {}
    }

    /// The point of a face's surface at `uv` and its derivatives.
    pub fn evaluate(&self, _face: usize, _uv: [f64; 2]) -> Result<Evaluation, OracleError> {
        match self.never {}
    }

    /// Where a trim curve's coordinates are stationary.
    pub fn derivative_roots(
        &self,
        _face: usize,
        _trim_loop: usize,
        _trim: usize,
    ) -> Result<DerivativeRootsTruth, OracleError> {
        match self.never {}
    }

    /// Likewise, with the sides from which derivatives are taken.
    pub fn evaluate_from(
        &self,
        _face: usize,
        _uv: [f64; 2],
        _limits: [Limit; 2],
    ) -> Result<Evaluation, OracleError> {
        match self.never {}
    }

    /// The distance from a point to the union of the trimmed faces.
    pub fn distance(
        &self,
        _point: [f64; 3],
        _nodes: Option<u32>,
    ) -> Result<Option<DistanceTruth>, OracleError> {
        match self.never {}
    }

    /// The separation of a half-space from the union of the trimmed faces.
    pub fn half_space(
        &self,
        _normal: [f64; 3],
        _offset: f64,
        _nodes: Option<u32>,
    ) -> Result<Option<DistanceTruth>, OracleError> {
        match self.never {}
    }

    /// All contacts of a sphere or half-space.
    pub fn contacts(&self, _probe: &Probe, _prediction: f64) -> Result<ContactsTruth, OracleError> {
        match self.never {}
    }

    /// Where the separation is attained, if that is one place.
    pub fn foot(
        &self,
        _probe: &Probe,
        _separation: &TruthEnclosure,
    ) -> Result<Option<[[f64; 2]; 3]>, OracleError> {
        match self.never {}
    }

    /// The side of a point of a face's parameter space.
    pub fn side(&self, _face: usize, _uv: [f64; 2]) -> Result<SideTruth, OracleError> {
        match self.never {}
    }

    /// All hits of a line with the trimmed faces.
    pub fn line(
        &self,
        _origin: [f64; 3],
        _direction: [f64; 3],
        _kind: LineKind,
    ) -> Result<LineTruth, OracleError> {
        match self.never {}
    }

    /// The width of an edge's crack.
    pub fn crack_width(&self, _edge: usize) -> Result<Option<TruthEnclosure>, OracleError> {
        match self.never {}
    }

    /// Whether a point is in material.
    pub fn inside(&self, _point: [f64; 3]) -> Result<InsideTruth, OracleError> {
        match self.never {}
    }

    /// The separation of a ball.
    pub fn sphere(
        &self,
        _center: [f64; 3],
        _radius: f64,
        _nodes: Option<u32>,
    ) -> Result<Option<DistanceTruth>, OracleError> {
        match self.never {}
    }
}
