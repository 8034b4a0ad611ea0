//! Trim curves: monotone arcs, inclusion in the trimmed region.

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
