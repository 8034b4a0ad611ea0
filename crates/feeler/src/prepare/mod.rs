//! What a scene needs of a BREP: Bezier patches, boundary pieces, boxes.
//!
//! Everything here is made when a query first comes near a face, once in f64 and, where the last
//! digits are asked for, once in double-double; where that loses them in rounding, in triple-double.

pub(crate) mod apart;
mod boundary;
mod bow;
mod box_tree;
mod bunches;
mod bytes;
mod circle;
pub(crate) mod closed;
mod compose;
mod course;
mod crack;
mod exact;
mod geometry;
mod health;
mod image;
pub(crate) mod jet;
mod matched;
mod matching;
mod near;
mod net;
mod param;
mod patch;
mod plan;
mod polygon;
mod quotient;
mod recognise;
mod row;
mod shell;
mod shortcuts;
mod side_cells;
mod spline;
mod stored_place;
pub(crate) mod trim_boxes;
mod turned;
mod turned_products;
mod vertex;

pub use boundary::Piece;
pub use bytes::FaceBytes;
pub use health::{
    Direction, EdgeHealth, FaceHealth, Gap, Health, LoopHealth, Offset, Turn, Undefined,
    trim_offsets,
};
pub use net::Net;
pub use param::ParamMap;
pub use patch::Patch;
pub(crate) use patch::Patches;
pub use plan::{FacePlan, Form, Searched};
pub use shortcuts::Shortcuts;

pub(crate) use boundary::restrict;
pub(crate) use box_tree::Skewer;
pub(crate) use bunches::{Bunch, Bunches, Within};
pub(crate) use course::{Course, Round};
pub(crate) use exact::{Ratio, When};
pub(crate) use geometry::{FaceGeometry, Seed};
pub(crate) use image::{Image, Stretch};
pub(crate) use near::distance;
pub(crate) use net::{Products, curve_jet, halves_of, part_of};
pub(crate) use polygon::{Meeting, Polygon};
pub(crate) use quotient::{Quotient, least_squared_distance};
pub(crate) use row::row_in_line;
pub(crate) use shell::{NearHalfSpace, Shell};
pub(crate) use side_cells::SideCells;
pub(crate) use spline::{Homogeneous, piece_count};
use stored_place::stored_place;
use trim_boxes::TrimBoxes;

use crate::brep::Brep;
use crate::numeric::{Dd, Td};
use crate::nurbs::Curve2;
use crate::trim::TrimRegion;
use boundary::CurveSource;
use box_tree::{BoxTree, Known};
use closed::{ClosedFace, ClosedImage, SphereForm};
use nalgebra::Point3;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use vertex::Vertices;

/// A box in space: ranges of x, y, z, rounded outward.
pub(crate) type Box3 = [[f64; 2]; 3];

/// A box around boxes.
fn around(boxes: &[Box3]) -> Box3 {
    let nothing = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    boxes.iter().fold(nothing, |all, b| {
        std::array::from_fn(|c| [all[c][0].min(b[c][0]), all[c][1].max(b[c][1])])
    })
}

/// What two boxes have in common, which is something.
fn common(a: &Box3, b: &Box3) -> Box3 {
    std::array::from_fn(|c| [a[c][0].max(b[c][0]), a[c][1].min(b[c][1])])
}

/// A box wider by a length on all sides, rounded outward.
fn widened(b: &Box3, by: f64) -> Box3 {
    b.map(|r| [(r[0] - by).next_down(), (r[1] + by).next_up()])
}

/// A box wider by its own diagonal on all sides.
fn by_its_diagonal(b: &Box3) -> Box3 {
    let squares = b.iter().map(|r| (r[1] - r[0]).powi(2));
    // A few roundings of the diagonal.
    let diagonal = squares.sum::<f64>().sqrt() * (1.0 + 16.0 * f64::EPSILON);
    widened(b, diagonal)
}

/// What is kept of one face.
#[derive(Debug)]
struct PreparedFace {
    region: OnceLock<Box<TrimRegion>>,
    closed: OnceLock<Option<Box<ClosedFace>>>,
    shell: OnceLock<Option<Box<Shell>>>,
    polygon: OnceLock<Option<Box<Polygon>>>,
    double: OnceLock<Box<FaceGeometry<f64>>>,
    double_double: OnceLock<Box<FaceGeometry<Dd>>>,
    triple_double: OnceLock<Box<FaceGeometry<Td>>>,
}

/// A BREP made ready for queries: immutable and `Sync`.
#[derive(Debug)]
pub struct PreparedBrep {
    /// What tells it from others, while anyone holds a copy.
    identity: Arc<()>,
    brep: Arc<Brep>,
    /// The uv curves as they were given, of those that have other parameters in `brep`; by their indices, in order.
    given_curves: Box<[(usize, Curve2)]>,
    shortcuts: Shortcuts,
    faces: Vec<PreparedFace>,
    /// A box around each face.
    boxes: Vec<Option<Box3>>,
    size: f64,
    /// A box around all faces; `None` where none is known.
    bounding_box: Option<Box3>,
    /// How many rays were cast for sides that cells might have told.
    rays: AtomicUsize,
    /// Of each trim: its image.
    images: Vec<OnceLock<Option<Image<f64>>>>,
    /// The same in double-double.
    fine_images: Vec<OnceLock<Option<Image<Dd>>>>,
    /// The regions around vertices.
    vertices: OnceLock<Vertices>,
    /// Of each edge: its crack's width, from above.
    cracks: Vec<OnceLock<f64>>,
    /// The same in double-double.
    fine_cracks: Vec<OnceLock<f64>>,
    /// From below.
    least_cracks: Vec<OnceLock<f64>>,
    side_cells: OnceLock<Option<SideCells>>,
    /// The edges that several trims use.
    shared: OnceLock<Box<[SharedEdge]>>,
    edge_tree: OnceLock<BoxTree>,
    face_tree: OnceLock<BoxTree>,
    /// Made for what is near a contact.
    trim_boxes: OnceLock<TrimBoxes>,
}

/// An edge that several trims use, and what a line must miss to be clear of its crack.
#[derive(Debug)]
pub(crate) struct SharedEdge {
    pub(crate) edge: usize,
    /// See [`PreparedBrep::edges_by_line`].
    far: Option<Box3>,
    rough: OnceLock<Option<Box3>>,
    near: OnceLock<Option<Box3>>,
}

impl PreparedBrep {
    /// Prepares a BREP. Cheap: the work is done when a query first comes near a face.
    pub fn new(brep: Brep) -> Self {
        Self::with_shortcuts(brep, Shortcuts::ALL)
    }

    /// The same without some of the shortcuts, to measure what each saves.
    pub fn with_shortcuts(brep: Brep, shortcuts: Shortcuts) -> Self {
        let (brep, given_curves) = brep.with_handy_weights();
        let faces: Vec<_> = (0..brep.faces().len())
            .map(|_| PreparedFace {
                region: OnceLock::new(),
                closed: OnceLock::new(),
                shell: OnceLock::new(),
                polygon: OnceLock::new(),
                double: OnceLock::new(),
                double_double: OnceLock::new(),
                triple_double: OnceLock::new(),
            })
            .collect();
        let boxes: Vec<Option<Box3>> = (0..faces.len())
            .map(|face| patch::boxes::surface_box(brep.surface(face)))
            .collect();
        let all: Option<Vec<Box3>> = boxes.iter().copied().collect();
        let bounding_box = all.map(|all| around(&all));
        let mut size: f64 = 0.0;
        for c in 0..3 {
            let known = boxes.iter().flatten();
            let range = known.fold([f64::INFINITY, f64::NEG_INFINITY], |r, b| {
                [r[0].min(b[c][0]), r[1].max(b[c][1])]
            });
            size = size.max(range[1] - range[0]);
        }
        let slots = || brep.parts().edges.iter().map(|_| OnceLock::new()).collect();
        Self {
            identity: Arc::new(()),
            cracks: slots(),
            fine_cracks: slots(),
            least_cracks: slots(),
            images: brep.parts().trims.iter().map(|_| OnceLock::new()).collect(),
            fine_images: brep.parts().trims.iter().map(|_| OnceLock::new()).collect(),
            vertices: OnceLock::new(),
            side_cells: OnceLock::new(),
            shared: OnceLock::new(),
            edge_tree: OnceLock::new(),
            face_tree: OnceLock::new(),
            trim_boxes: OnceLock::new(),
            brep: Arc::new(brep),
            given_curves,
            shortcuts,
            faces,
            boxes,
            size,
            bounding_box,
            rays: AtomicUsize::new(0),
        }
    }

    /// What tells it from others: no other points to the same while a copy is held.
    pub(crate) fn identity(&self) -> &Arc<()> {
        &self.identity
    }

    pub(crate) fn shortcuts(&self) -> Shortcuts {
        self.shortcuts
    }

    /// The BREP as it was given, but that homogeneous points of NURBS may be multiplied by powers of two, for weights near to 1. Points and uv stay the same, exactly; the parameters of a
    /// uv curve whose weights rise or fall along it do not: that is run through at another pace.
    pub fn brep(&self) -> &Brep {
        &self.brep
    }

    /// A uv curve with the parameters that it was given.
    pub(crate) fn given_curve(&self, curve: usize) -> &Curve2 {
        match self.given_curves.binary_search_by_key(&curve, |(i, _)| *i) {
            Ok(k) => &self.given_curves[k].1,
            Err(_) => &self.brep.parts().curves2[curve],
        }
    }

    /// The model's size: the longest side of the box of its surfaces' control points, in
    /// model units.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// A bound above the width of an edge's crack, in model units: the largest Frechet distance between the images
    /// of two of its trims under their faces' surfaces. Proven; infinite where there is none. Made at the
    /// first call, from tens of microseconds to milliseconds for trims over many patches. Where the
    /// images agree to rounding it is about 2^-46 of the faces' size.
    ///
    /// # Panics
    /// If there is no such edge.
    pub fn crack_width(&self, edge: usize) -> f64 {
        let make = || crack::width(self, edge, |trim| self.trim_image(trim));
        *self.cracks[edge].get_or_init(make)
    }

    /// The same in double-double, for lines that pass within the rounding of the first: far slower.
    ///
    /// # Panics
    /// If there is no such edge.
    pub fn fine_crack_width(&self, edge: usize) -> f64 {
        let make = || {
            let fine = crack::width(self, edge, |trim| self.fine_trim_image(trim));
            fine.min(self.crack_width(edge))
        };
        *self.fine_cracks[edge].get_or_init(make)
    }

    /// A bound below the width of an edge's crack: the distance of some point of one image from another. Made at the first
    /// call, in milliseconds.
    ///
    /// # Panics
    /// If there is no such edge.
    pub fn least_crack_width(&self, edge: usize) -> f64 {
        *self.least_cracks[edge].get_or_init(|| crack::least_width(self, edge))
    }

    /// The image of a trim in space; `None` where it is not known.
    pub(crate) fn trim_image(&self, trim: usize) -> Option<&Image<f64>> {
        let make = || image::image(self.double(self.face_of(trim)), trim);
        self.images[trim].get_or_init(make).as_ref()
    }

    /// The same in double-double.
    pub(crate) fn fine_trim_image(&self, trim: usize) -> Option<&Image<Dd>> {
        let make = || image::image(self.double_double(self.face_of(trim)), trim);
        self.fine_images[trim].get_or_init(make).as_ref()
    }

    /// The image of a trim in closed form.
    pub(crate) fn closed_image(&self, trim: usize) -> Option<ClosedImage<'_>> {
        self.closed(self.face_of(trim))?.image_of(trim)
    }

    /// The same where it is nearly in closed form, too: where digits beyond f64 do not matter.
    pub(crate) fn nearly_closed_image(&self, trim: usize) -> Option<ClosedImage<'_>> {
        self.closed(self.face_of(trim))?.nearly_image_of(trim)
    }

    /// The edges that several trims use.
    pub(crate) fn shared_edges(&self) -> &[SharedEdge] {
        self.shared.get_or_init(|| {
            let edges = self.brep.parts().edges.iter().enumerate();
            let shared = edges.filter(|(_, e)| e.trims.len() > 1);
            let made = shared.map(|(edge, e)| SharedEdge {
                edge,
                far: self.far_box(&e.trims),
                rough: OnceLock::new(),
                near: OnceLock::new(),
            });
            made.collect()
        })
    }

    /// Calls `found` with the numbers, in [`shared_edges`](Self::shared_edges), of those whose cracks a line may come to: the others it
    /// is clear of, farther from the images of their trims than the crack's width. Until it returns true; whether it did. The ends of a
    /// line count for what `misses` tells of a box: whether the line surely does not meet it. It is asked of few: others are told in a tree.
    ///
    /// Three boxes know it. *Far*: the images are moved to the domains of their surfaces and so lie in the box `B` around the faces; their
    /// Frechet distance, the crack's width, is at most the diagonal of `B`; who misses `B` widened by its diagonal is
    /// clear. It costs nothing to make, so that an edge far off stays unmade. *Rough*: the same of boxes around what the surfaces have over the trims' boxes in uv, for who meets the
    /// first; without images and without the crack's width, which take a hundred times as long. *Near*: a box around the images, widened by the
    /// bound of the crack's width; made when something first comes near, and cut with the others: who comes so near to the images is in all, and it is the same whether the box has been made or not.
    pub(crate) fn edges_by_line(
        &self,
        line: &Skewer,
        misses: impl Fn(&Box3) -> bool,
        mut found: impl FnMut(usize) -> bool,
    ) -> bool {
        let edges = self.shared_edges();
        let known = |index: usize| {
            let shared = &edges[index];
            if shared.near.get().is_none() {
                let rough = || {
                    let make = || self.rough_box(shared.edge);
                    shared.rough.get_or_init(make).as_ref()
                };
                if shared.far.as_ref().is_some_and(&misses) || rough().is_some_and(&misses) {
                    return Known::Missed;
                }
            }
            Known::Box(*shared.near.get_or_init(|| {
                let make = || self.rough_box(shared.edge);
                let all = [
                    self.near_box(shared.edge),
                    *shared.rough.get_or_init(make),
                    shared.far,
                ];
                all.into_iter().flatten().reduce(|a, b| common(&a, &b))
            }))
        };
        let tree = self.edge_tree.get_or_init(|| {
            let vertices = &self.brep.parts().vertices;
            let middle = |shared: &SharedEdge| {
                let [a, b] = self.brep.parts().edges[shared.edge].vertices;
                let ends = [a, b].map(|v| vertices[v].point);
                [0, 1, 2].map(|c| 0.5 * (ends[0][c] + ends[1][c]))
            };
            BoxTree::new(&edges.iter().map(middle).collect::<Vec<_>>())
        });
        // (What misses the box that is known first misses the other as well, in the last digits, too: it lies in it, and `misses` rounds alike.)
        tree.any(line, known, |index| {
            let near = edges[index].near.get().and_then(Option::as_ref);
            !near.is_some_and(&misses) && found(index)
        })
    }

    /// The faces whose boxes a line may meet, in order, in a list that is used again. `misses` as in [`edges_by_line`](Self::edges_by_line).
    pub(crate) fn faces_by_line(
        &self,
        line: &Skewer,
        misses: impl Fn(&Box3) -> bool,
        out: &mut Vec<usize>,
    ) {
        out.clear();
        // One face needs no tree.
        if let [only] = &*self.boxes {
            out.extend((!only.as_ref().is_some_and(misses)).then_some(0));
            return;
        }
        let tree = self.face_tree.get_or_init(|| {
            let middle = |b: &Option<Box3>| b.map_or([0.0; 3], |b| b.map(|r| 0.5 * (r[0] + r[1])));
            BoxTree::new(&self.boxes.iter().map(middle).collect::<Vec<_>>())
        });
        let known = |face: usize| Known::Box(self.boxes[face]);
        tree.any(line, known, |face| {
            if !(line.has_ends && self.boxes[face].as_ref().is_some_and(&misses)) {
                out.push(face);
            }
            false
        });
        out.sort_unstable();
    }

    fn far_box(&self, trims: &[usize]) -> Option<Box3> {
        let faces = trims.iter().map(|t| self.boxes[self.face_of(*t)]);
        let faces: Option<Vec<Box3>> = faces.collect();
        Some(by_its_diagonal(&around(&faces?)))
    }

    /// See [`edges_by_line`](Self::edges_by_line).
    fn rough_box(&self, edge: usize) -> Option<Box3> {
        let trims = self.brep.parts().edges[edge].trims.iter();
        let boxes = trims.map(|&t| {
            let sources = boundary::trim_sources(&self.brep, t);
            self.box_over(self.face_of(t), sources)
        });
        let boxes: Option<Vec<Box3>> = boxes.collect();
        Some(by_its_diagonal(&around(&boxes?)))
    }

    /// A box around what a face's surface has over the box around some curves in uv: around their images.
    fn box_over(&self, face: usize, sources: impl Iterator<Item = CurveSource>) -> Option<Box3> {
        let uv = boundary::uv_box(&self.brep, sources)?;
        patch::boxes::box_over(self.brep.surface(face), &uv)
    }

    fn near_box(&self, edge: usize) -> Option<Box3> {
        let trims = self.brep.parts().edges[edge].trims.iter();
        let images = trims.map(|t| match self.nearly_closed_image(*t) {
            Some(image) => Some(widened(&image.shape.bounds(), image.slack)),
            None => self.trim_image(*t).map(Image::bounds),
        });
        let images: Option<Vec<Box3>> = images.collect();
        Some(widened(&around(&images?), self.crack_width(edge)))
    }

    pub(crate) fn face_of(&self, trim: usize) -> usize {
        let parts = self.brep.parts();
        parts.loops[parts.trims[trim].trim_loop].face
    }

    /// The regions around vertices.
    pub(crate) fn vertices(&self) -> &Vertices {
        self.vertices.get_or_init(|| Vertices::new(self))
    }

    /// Sides of points in space that are kept, where they are wanted and can be. They need the widths of all cracks, of which a ray needs those alone that it comes near.
    pub(crate) fn side_cells(&self) -> Option<&SideCells> {
        if !self.shortcuts.side_cells {
            return None;
        }
        self.side_cells
            .get_or_init(|| SideCells::new(self))
            .as_ref()
    }

    /// Whether [`side_cells`](Self::side_cells) are there, or worth their making: after so many rays as take about as long.
    pub(crate) fn has_side_cells(&self) -> bool {
        /// The width of a crack takes some times as long as a ray.
        const RAYS_AN_EDGE: usize = 4;
        let few = RAYS_AN_EDGE * self.brep.parts().edges.len();
        self.side_cells.get().is_some() || self.rays.fetch_add(1, Ordering::Relaxed) >= few
    }

    /// Whether a point is so far out that it is proven to be outside: beyond the box `B` of all surfaces.
    ///
    /// Faces, images of trims and what of these is moved to the borders of domains lie on the surfaces, so in `B`. What closes cracks and vertices (module `side_cells`) are
    /// segments between points of these, and others within the smallest boxes around such points: in `B` too, as that is convex. A point beyond `B` in some coordinate
    /// starts a ray away from `B` along that coordinate that meets none of it: its parity, 0, is the side.
    pub(crate) fn is_beyond(&self, point: &Point3<f64>) -> bool {
        let beyond = |b: &Box3| (0..3).any(|c| point[c] < b[c][0] || point[c] > b[c][1]);
        self.bounding_box.as_ref().is_some_and(beyond)
    }

    /// A box around all faces; `None` where none is known.
    pub(crate) fn bounding_box(&self) -> Option<&Box3> {
        self.bounding_box.as_ref()
    }

    /// A box around the face's surface; `None` where none is known.
    pub(crate) fn face_box(&self, face: usize) -> Option<&Box3> {
        self.boxes[face].as_ref()
    }

    /// The coordinate that all points of a face have in common, exactly, and its value.
    pub(crate) fn level(&self, face: usize) -> Option<(usize, f64)> {
        patch::level(self.brep.surface(face))
    }

    /// See [`stored_place`].
    pub(crate) fn stored_place(&self, face: usize, point: &[f64; 3]) -> Option<[f64; 2]> {
        stored_place(self.brep.surface(face), point)
    }

    /// Whether a face's surface goes on over its seam along u (or v): the two borders are one curve, exactly.
    pub(crate) fn meets_itself(&self, face: usize, along_u: bool) -> bool {
        patch::meets_itself(self.brep.surface(face), along_u)
    }

    /// The trimmed region of a face.
    pub(crate) fn region(&self, face: usize) -> &TrimRegion {
        let slot = &self.faces[face].region;
        let cells = self.shortcuts.trim_cells;
        slot.get_or_init(|| Box::new(TrimRegion::with_cells(&self.brep, face, cells)))
    }

    /// The closed form of a face, if it has one and it is wanted.
    pub(crate) fn closed(&self, face: usize) -> Option<&ClosedFace> {
        if !self.shortcuts.closed_forms {
            return None;
        }
        let slot = &self.faces[face].closed;
        let recognise = self.shortcuts.recognition;
        let make = || ClosedFace::new(&self.brep, face, self.region(face), self.size, recognise);
        slot.get_or_init(|| make().map(Box::new)).as_deref()
    }

    /// The sphere that the BREP's only face is on, if it has no other and that is on one.
    pub(crate) fn only_sphere(&self) -> Option<&SphereForm> {
        let only = self.faces.len() == 1;
        only.then(|| self.closed(0)).flatten()?.surface.sphere()
    }

    /// A face as a polygon, if it is one: for what double-double does not tell.
    pub(crate) fn polygon(&self, face: usize) -> Option<&Polygon> {
        let slot = &self.faces[face].polygon;
        slot.get_or_init(|| Polygon::new(self, face).map(Box::new))
            .as_deref()
    }

    /// The shell around a face's surface, if that is seen to be round.
    pub(crate) fn shell(&self, face: usize) -> Option<&Shell> {
        if !self.shortcuts.recognition {
            return None;
        }
        let slot = &self.faces[face].shell;
        slot.get_or_init(|| Shell::new(self, face).map(Box::new))
            .as_deref()
    }

    pub(crate) fn double(&self, face: usize) -> &FaceGeometry<f64> {
        let slot = &self.faces[face].double;
        slot.get_or_init(|| Box::new(FaceGeometry::of_face(&self.brep, face)))
    }

    /// The same patches and pieces as [`double`](Self::double), by index.
    pub(crate) fn double_double(&self, face: usize) -> &FaceGeometry<Dd> {
        let slot = &self.faces[face].double_double;
        slot.get_or_init(|| Box::new(self.double(face).finer()))
    }

    /// The same in triple-double.
    pub(crate) fn triple_double(&self, face: usize) -> &FaceGeometry<Td> {
        let slot = &self.faces[face].triple_double;
        slot.get_or_init(|| Box::new(self.double(face).finer()))
    }
}
