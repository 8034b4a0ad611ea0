//! What a scene needs of a BREP: patches, trim indices, boxes.

use crate::brep::Brep;

/// A BREP made ready for queries: immutable and `Sync`.
#[derive(Debug)]
pub struct PreparedBrep {
    brep: Brep,
}

impl PreparedBrep {
    /// Prepares a BREP.
    pub fn new(brep: Brep) -> Self {
        Self { brep }
    }

    /// The BREP as it was given.
    pub fn brep(&self) -> &Brep {
        &self.brep
    }
}
