//! A whole document in other units.

use crate::affine::{Affine, MapError};
use crate::blocks::carried;
use crate::document::{Document, Object, ObjectKind};
use crate::units::Units;
use feeler::brep::{Brep, BrepParts};
use feeler::nurbs::Curve3;

/// Why a document cannot be given other units.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UnitsError {
    /// One of the two has no length.
    #[error(
        "from `{from}` to `{to}`: one of them has no length; name a unit such as mm, or say nothing"
    )]
    NoLength {
        /// The document's units.
        from: String,
        /// The units wanted.
        to: String,
    },
    /// Geometry that does not survive it.
    #[error("object {object}: {problem}")]
    Object {
        /// The object.
        object: usize,
        /// Why.
        problem: MapError,
    },
}

impl Document {
    /// Gives all geometry in other units: every length times the ratio of the two, which is rounded to the nearest f64 once. Returns how far any
    /// point may be from its exact place (that of the rounded ratio), in the new units; 0 where nothing was rounded. Of what blocks place that is where their maps take it;
    /// what is rounded there is told [when it is placed](crate::Placement::placed). What objects' warnings tell of lengths stays in the units in which they were read.
    ///
    /// # Errors
    /// [`UnitsError`]: no length for one of the units, or a size beyond the kernel's range.
    ///
    /// # Cost
    /// O(size).
    pub fn convert_units(&mut self, to: Units) -> Result<f64, UnitsError> {
        let factor = self.units.ratio(&to).ok_or_else(|| UnitsError::NoLength {
            from: self.units.to_string(),
            to: to.to_string(),
        })?;
        let map = Affine::scaling(factor);
        let mut off: f64 = 0.0;
        for (index, object) in self.objects.iter_mut().enumerate() {
            let result = rescale(object, &map, factor);
            off = off.max(result.map_err(|problem| UnitsError::Object {
                object: index,
                problem,
            })?);
        }
        for member in self.blocks.iter_mut().flat_map(|b| &mut b.members) {
            rescale_map(&mut member.map, factor);
        }
        self.tolerance = self.tolerance.map(|t| t * factor);
        self.units = to;
        // A power of two rounds no translation.
        let is_exact = off == 0.0 && factor.to_bits() & ((1 << 52) - 1) == 0;
        Ok(if is_exact { 0.0 } else { carried(self, off) })
    }
}

fn rescale_map(map: &mut Option<Box<Affine>>, factor: f64) {
    if let Some(map) = map {
        **map = map.rescaled(factor);
    }
}

fn rescale(object: &mut Object, map: &Affine, factor: f64) -> Result<f64, MapError> {
    let moved = |brep: &mut Brep| {
        let moved = map.apply(brep)?;
        *brep = moved.brep;
        Ok(moved.off)
    };
    match &mut object.kind {
        ObjectKind::Brep(b) | ObjectKind::Surface(b) | ObjectKind::Extrusion(b) => moved(b),
        ObjectKind::Curve(curve) => {
            let (scaled, off) = moved_curve(curve, map)?;
            *curve = scaled;
            Ok(off)
        }
        ObjectKind::Block { map, .. } => {
            rescale_map(map, factor);
            Ok(0.0)
        }
        ObjectKind::Mesh | ObjectKind::Other(_) | ObjectKind::Refused { .. } => Ok(0.0),
    }
}

/// A curve under a map, as the only part of a BREP, and how far off its points may be.
pub(crate) fn moved_curve(curve: &Curve3, map: &Affine) -> Result<(Curve3, f64), MapError> {
    let parts = BrepParts {
        curves3: vec![curve.clone()],
        ..BrepParts::default()
    };
    let moved = map.apply(&Brep::new(parts)?)?;
    let scaled = moved.brep.parts().curves3.first().cloned();
    Ok((scaled.unwrap_or_else(|| curve.clone()), moved.off))
}
