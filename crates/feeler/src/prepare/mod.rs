//! What a scene needs of a BREP: Bezier patches, boundary pieces, boxes.
//!
//! Everything here is made when a query first comes near a face, once in f64 and, where the last
//! digits are asked for, once in double-double.

mod boundary;
mod circle;
pub(crate) mod closed;
mod compose;
mod crack;
mod net;
mod param;
mod patch;
mod spline;

pub use boundary::Piece;
pub use net::Net;
pub use param::ParamMap;
pub use patch::Patch;

pub(crate) use boundary::restrict;
pub(crate) use net::{Products, curve_jet};
pub(crate) use spline::Homogeneous;

use crate::brep::Brep;
use crate::numeric::{Dd, Real};
use crate::trim::TrimRegion;
use boundary::{Cut, UvCurve};
use closed::ClosedFace;
use std::sync::OnceLock;

/// A box in space: ranges of x, y, z, rounded outward.
pub(crate) type Box3 = [[f64; 2]; 3];

/// The patches and boundary of one face in one arithmetic.
#[derive(Debug)]
pub(crate) struct FaceGeometry<T> {
    pub(crate) patches: Vec<Patch<T>>,
    curves: Vec<UvCurve<T>>,
    cuts: Vec<Cut>,
    pieces: Vec<OnceLock<Piece<T>>>,
    /// The patches' boxes in space; `None` where a weight is not proven to be positive.
    pub(crate) patch_boxes: Vec<Option<Box3>>,
    patch_products: Vec<OnceLock<Products<T>>>,
    piece_products: Vec<OnceLock<Products<T>>>,
}

impl<T: Real> FaceGeometry<T> {
    fn new(brep: &Brep, face: usize, patches: Vec<Patch<T>>, cuts: Vec<Cut>) -> Self {
        Self {
            patch_boxes: patches.iter().map(|p| p.net.bounding_box()).collect(),
            patch_products: patches.iter().map(|_| OnceLock::new()).collect(),
            piece_products: cuts.iter().map(|_| OnceLock::new()).collect(),
            pieces: cuts.iter().map(|_| OnceLock::new()).collect(),
            curves: boundary::uv_curves(brep, face),
            patches,
            cuts,
        }
    }

    /// How many boundary pieces there are.
    pub(crate) fn piece_count(&self) -> usize {
        self.cuts.len()
    }

    /// The uv curve that a boundary piece is part of, as `uv_curves` numbers them.
    pub(crate) fn piece_curve(&self, index: usize) -> usize {
        self.cuts[index].curve
    }

    /// The patch that a boundary piece lies on.
    pub(crate) fn piece_patch(&self, index: usize) -> usize {
        self.cuts[index].patch
    }

    /// The trim that a boundary piece is part of; `None` for a segment that joins two.
    pub(crate) fn piece_trim(&self, index: usize) -> Option<usize> {
        self.curves[self.cuts[index].curve].trim
    }

    /// A boundary piece; made at the first call.
    pub(crate) fn piece(&self, index: usize) -> &Piece<T> {
        self.pieces[index].get_or_init(|| {
            let cut = &self.cuts[index];
            boundary::lift(&self.curves[cut.curve], cut, &self.patches[cut.patch])
        })
    }

    pub(crate) fn patch_products(&self, index: usize) -> &Products<T> {
        self.patch_products[index].get_or_init(|| self.patches[index].net.products())
    }

    /// `None` where the piece's degree is too high to be composed.
    pub(crate) fn piece_products(&self, index: usize) -> Option<&Products<T>> {
        let space = self.piece(index).space.as_ref()?;
        Some(self.piece_products[index].get_or_init(|| space.products()))
    }
}

/// What is kept of one face.
#[derive(Debug)]
struct PreparedFace {
    bounding_box: Option<Box3>,
    region: OnceLock<TrimRegion>,
    closed: OnceLock<Option<ClosedFace>>,
    double: OnceLock<FaceGeometry<f64>>,
    double_double: OnceLock<FaceGeometry<Dd>>,
}

/// A BREP made ready for queries: immutable and `Sync`.
#[derive(Debug)]
pub struct PreparedBrep {
    brep: Brep,
    faces: Vec<PreparedFace>,
    size: f64,
    cracks: OnceLock<Vec<f64>>,
}

impl PreparedBrep {
    /// Prepares a BREP. Cheap: the work is done when a query first comes near a face.
    pub fn new(brep: Brep) -> Self {
        let faces: Vec<_> = (0..brep.faces().len())
            .map(|face| PreparedFace {
                bounding_box: patch::surface_box(brep.surface(face)),
                region: OnceLock::new(),
                closed: OnceLock::new(),
                double: OnceLock::new(),
                double_double: OnceLock::new(),
            })
            .collect();
        let mut size: f64 = 0.0;
        for c in 0..3 {
            let boxes = faces.iter().filter_map(|f| f.bounding_box);
            let range = boxes.fold([f64::INFINITY, f64::NEG_INFINITY], |r, b| {
                [r[0].min(b[c][0]), r[1].max(b[c][1])]
            });
            size = size.max(range[1] - range[0]);
        }
        Self {
            brep,
            faces,
            size,
            cracks: OnceLock::new(),
        }
    }

    /// The BREP as it was given.
    pub fn brep(&self) -> &Brep {
        &self.brep
    }

    /// The model's size: the longest side of the box of its surfaces' control points, in
    /// model units.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The width of the crack at each edge, in model units: the distance of its two images, sampled,
    /// an estimate from below. Made at the first call.
    pub fn cracks(&self) -> &[f64] {
        self.cracks.get_or_init(|| crack::crack_widths(&self.brep))
    }

    /// The widest crack, in model units; see [`cracks`](Self::cracks).
    pub fn widest_crack(&self) -> f64 {
        self.cracks().iter().copied().fold(0.0, f64::max)
    }

    /// A box around the face's surface; `None` where none is known.
    pub(crate) fn face_box(&self, face: usize) -> Option<&Box3> {
        self.faces[face].bounding_box.as_ref()
    }

    /// The trimmed region of a face.
    pub(crate) fn region(&self, face: usize) -> &TrimRegion {
        let slot = &self.faces[face].region;
        slot.get_or_init(|| TrimRegion::new(&self.brep, face))
    }

    /// The closed form of a face, if it has one.
    pub(crate) fn closed(&self, face: usize) -> Option<&ClosedFace> {
        let slot = &self.faces[face].closed;
        let make = || ClosedFace::new(&self.brep, face, self.region(face), self.size);
        slot.get_or_init(make).as_ref()
    }

    pub(crate) fn double(&self, face: usize) -> &FaceGeometry<f64> {
        let make = || {
            let patches = patch::surface_patches(self.brep.surface(face));
            let cuts = boundary::cut_boundary(&self.brep, face, &patches);
            FaceGeometry::new(&self.brep, face, patches, cuts)
        };
        let slot = &self.faces[face].double;
        slot.get_or_init(make)
    }

    /// The same patches and pieces as [`double`](Self::double), by index.
    pub(crate) fn double_double(&self, face: usize) -> &FaceGeometry<Dd> {
        let double = self.double(face);
        let make = || {
            let patches = patch::surface_patches(self.brep.surface(face));
            FaceGeometry::new(&self.brep, face, patches, double.cuts.clone())
        };
        let slot = &self.faces[face].double_double;
        slot.get_or_init(make)
    }
}
