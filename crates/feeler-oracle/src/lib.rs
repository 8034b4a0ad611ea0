//! Exact ground truth for contact queries, computed by CGAL.
//!
//! The oracle takes the raw control data and topology of BREPs and does its own Bezier
//! extraction, inclusion and root finding in exact or certified arithmetic (`cpp/`); it shares
//! no algorithm with the kernel. It is real only with the feature `cgal`; without it
//! [`Oracle::new`] answers [`OracleError::NotBuilt`] and nothing else can be called.
//!
//! Every surface and curve of the kernel's data model is taken in its native form: NURBS, planes,
//! revolutions and sums; lines, arcs, polylines, NURBS and poly-curves of these. A query that does
//! not treat a kind of them yet is [`OracleError::Refused`], naming face and kind.
//!
//! An [`Oracle`] is neither `Send` nor `Sync`: CGAL's numbers are reference-counted without
//! locks. Make one a thread. Queries leave the floating-point environment as they found it.

#[cfg(feature = "cgal")]
mod bridge;
#[cfg(feature = "cgal")]
mod contacts;
#[cfg(feature = "cgal")]
mod convert;
#[cfg(feature = "cgal")]
mod critical_points;
#[cfg(feature = "cgal")]
mod derivative_roots;
#[cfg(feature = "cgal")]
mod distance;
#[cfg(feature = "cgal")]
mod edges;
#[cfg(feature = "cgal")]
mod oracle;
pub mod second;
#[cfg(feature = "cgal")]
mod space;
#[cfg(not(feature = "cgal"))]
mod stub;
mod truth;

#[cfg(feature = "cgal")]
pub use critical_points::critical_points;
#[cfg(feature = "cgal")]
pub use derivative_roots::eigen_candidates;
#[cfg(feature = "cgal")]
pub use oracle::{Oracle, set_rounding_upward};
#[cfg(not(feature = "cgal"))]
pub use stub::{Oracle, critical_points, eigen_candidates};
pub use truth::{
    AxisRootsTruth, ContactTruth, ContactsTruth, CriticalPoint, CriticalPoints,
    DerivativeRootTruth, DerivativeRootsTruth, DistanceStatus, DistanceTruth, Evaluation,
    InsideTruth, LineHitTruth, LineOpen, LineTruth, OracleError, Shared, SideTruth, TruthEnclosure,
};
