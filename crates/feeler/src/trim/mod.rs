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

/// Where a box of uv lies relative to the region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxSide {
    /// The whole closed box is in the region's interior.
    Inside,
    /// No point of the closed box is in the region.
    Outside,
    /// Not known to be either.
    Mixed,
}

/// STUB until the trim branch lands: the whole domain.
#[derive(Debug)]
pub struct TrimRegion {}

/// STUB.
#[derive(Debug)]
pub struct SideAnswerStub {
    /// stub
    pub side: Option<Side>,
}

impl TrimRegion {
    /// STUB.
    pub fn new(_brep: &crate::brep::Brep, _face: usize) -> Self {
        Self {}
    }
    /// STUB.
    pub fn side(&self, _uv: nalgebra::Point2<f64>) -> SideAnswerStub {
        SideAnswerStub {
            side: Some(Side::Inside),
        }
    }
    /// STUB.
    pub fn classify_box(&self, _u: [f64; 2], _v: [f64; 2]) -> BoxSide {
        BoxSide::Inside
    }
}
