//! Trim curves: monotone parts, inclusion in the trimmed region.
//!
//! # Definition
//! A loop is its trim curves in order, each joined to the next (the last to the first) by a straight
//! segment where their end points differ. The region of a face is the closure of the uv points of odd
//! parity with respect to its loops, cut with the surface's domain. No loops given: the whole domain.
//! An empty list of loops: nothing. `Boundary` is the region's topological boundary, and every point
//! of the domain that is exactly on a loop. A point outside the domain is outside.
//!
//! # Method
//! Every trim curve becomes rational Bezier pieces, known in f64 and double-double within proven bounds and,
//! on demand, in integers (control points and knots are dyadic; a common factor of homogeneous
//! coordinates changes nothing). Pieces are split where u' or v' changes sign (the numerator `X'W - XW'`
//! has degree 2p - 2, or p - 1 for equal weights) into parts that are monotone in both coordinates, with
//! signs proven from coefficients; between them remain parts of about 2^-50 that hold the turns, and
//! which integers decide where a point gets that close.
//!
//! A grid of cells keeps, for each, strips that hold what the loops have in it, and the parity of what is left on each side of
//! them: most points are told by one cell alone.
//!
//! The parity is that of the transitions of `[v(t) > q_v]` at curve points with `u(t) > q_u`. Each is
//! decided in f64 with a proven bound, else in double-double, else in integers, always from the
//! original control data. Sides are therefore exact, except near the ends of native arcs (their
//! cosines are no rationals), where [`RegionSide::side`] may be `None`.

mod area;
mod beside;
mod cells;
mod circle;
mod decide;
mod derivative;
mod exact;
mod meeting;
mod pair;
mod piece;
mod region;
mod shape;
mod source;
mod spline;
mod split;
mod strip;
mod turns;

pub(crate) use exact::{ExactPiece, ExactPoint};

pub use derivative::{AxisRoots, PieceRoots, derivative_roots};
pub use meeting::{MOST_MEETINGS, Meeting, MeetingKind, Meetings};
pub use region::{BoundaryPiece, BoxSide, PieceOrigin, RegionSide, TrimRegion};
pub use shape::RegionShape;
pub use turns::{AxisSplit, Stationary, trim_split};

/// Where a point of uv lies relative to the trimmed region of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// In the region's interior.
    Inside,
    /// Outside the region.
    Outside,
    /// On the region's topological boundary, or exactly on a loop.
    Boundary,
}

#[cfg(test)]
mod tests;
