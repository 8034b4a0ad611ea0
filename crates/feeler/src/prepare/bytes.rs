//! How much memory a prepared BREP holds, and how it is given back.

use super::box_tree::BoxTree;
use super::trim_boxes;
use super::vertex::Vertices;
use super::{Box3, FaceGeometry, Image, Net, PreparedBrep, PreparedFace, SideCells};
use crate::numeric::Real;
use std::sync::OnceLock;

/// Of the elements that a list has room for; not of what these hold elsewhere.
fn list<T>(v: &Vec<T>) -> usize {
    v.capacity() * size_of::<T>()
}

fn geometry<T: Real>(g: &FaceGeometry<T>) -> usize {
    let made = g.pieces.iter().filter_map(OnceLock::get);
    let pieces = made.map(|kept| {
        let space = kept.piece.space.as_ref();
        let products = kept.products.get();
        size_of_val(&**kept)
            + list(&kept.piece.local)
            + space.map_or(0, Net::bytes)
            + products.map_or(0, |p| p.bytes())
    });
    let slots = size_of_val(&*g.pieces);
    let seeds = g.seeds.get().map_or(0, |s| size_of_val(&**s));
    size_of_val(g) + slots + g.patches.bytes() + pieces.sum::<usize>() + seeds
}

fn images<T>(slots: &Vec<OnceLock<Option<Image<T>>>>) -> usize {
    let made = slots.iter().filter_map(|s| s.get()?.as_ref());
    let one = |i: &Image<T>| {
        let points: usize = i.stretches.iter().map(|s| list(&s.points)).sum();
        list(&i.stretches) + points
    };
    list(slots) + made.map(one).sum::<usize>()
}

/// Bytes of what is made of one face, by what it is for; 0 for what has not been made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FaceBytes {
    /// The boxes and slots that are there from the start.
    pub at_once: usize,
    /// The trimmed region: made when a query first asks for a side on the face.
    pub region: usize,
    /// The closed form of surface and boundary.
    pub closed: usize,
    /// Patches, boundary pieces and their products in f64: made when the face is first searched.
    pub patches: usize,
    /// The same in double-double and triple-double: made when what is coarser first does not suffice.
    pub fine_patches: usize,
}

impl FaceBytes {
    pub(super) fn of(f: &PreparedFace) -> Self {
        let closed = f.closed.get().and_then(Option::as_ref);
        Self {
            at_once: size_of::<PreparedFace>() + size_of::<Option<Box3>>(),
            region: f.region.get().map_or(0, |r| size_of_val(&**r) + r.bytes()),
            closed: closed.map_or(0, |c| c.bytes()),
            patches: f.double.get().map_or(0, |g| geometry(g) + g.shared_bytes()),
            fine_patches: f.double_double.get().map_or(0, |g| geometry(g))
                + f.triple_double.get().map_or(0, |g| geometry(g)),
        }
    }

    /// What has been made since the BREP was prepared.
    fn later(&self) -> usize {
        self.region + self.closed + self.patches + self.fine_patches
    }
}

impl PreparedBrep {
    /// Bytes that it holds now besides the BREP itself: what queries had it make so far. Counted are the lists that grow
    /// with the model, as large as they were reserved; what the allocator adds is not known.
    pub fn bytes(&self) -> usize {
        let faces: usize = self.faces.iter().map(|f| FaceBytes::of(f).later()).sum();
        let cracks = list(&self.cracks) + list(&self.fine_cracks) + list(&self.least_cracks);
        let kept = self.side_cells.get().and_then(Option::as_ref);
        size_of::<Self>()
            + kept.map_or(0, SideCells::bytes)
            // Of the faces: what they have at once.
            + list(&self.faces)
            + list(&self.boxes)
            // Their points are those of the BREP that was given.
            + size_of_val(&*self.given_curves)
            + faces
            + self.shared.get().map_or(0, |s| size_of_val(&**s))
            + self.edge_tree.get().map_or(0, BoxTree::bytes)
            + self.vertices.get().map_or(0, Vertices::bytes)
            + self.face_tree.get().map_or(0, BoxTree::bytes)
            + self.trim_boxes.get().map_or(0, trim_boxes::bytes)
            + cracks
            + images(&self.images)
            + images(&self.fine_images)
    }

    /// Gives back what queries had it make until it holds no more than `most` [bytes](Self::bytes), or nothing is left but what it was
    /// prepared with; returns how many it holds then. What is used least goes first: arithmetic beyond double-double, double-double,
    /// patches and boundary pieces, and trimmed regions and closed forms at last.
    ///
    /// Answers stay the same, bit for bit: what is missing is made again by the next query that comes near, which takes as long as the first did.
    pub fn shrink_to(&mut self, most: usize) -> usize {
        let stages: [fn(&mut Self); 4] = [
            |b| b.faces.iter_mut().for_each(|f| f.triple_double = empty()),
            |b| {
                b.faces.iter_mut().for_each(|f| f.double_double = empty());
                b.fine_images.iter_mut().for_each(|i| *i = empty());
            },
            |b| {
                b.faces.iter_mut().for_each(|f| f.double = empty());
                b.images.iter_mut().for_each(|i| *i = empty());
                b.side_cells = empty();
                b.trim_boxes = empty();
                *b.rays.get_mut() = 0;
            },
            |b| {
                for f in &mut b.faces {
                    f.region = empty();
                    f.closed = empty();
                    f.shell = empty();
                    f.polygon = empty();
                }
                b.vertices = empty();
                b.shared = empty();
                b.edge_tree = empty();
                b.face_tree = empty();
            },
        ];
        for stage in stages {
            if self.bytes() <= most {
                break;
            }
            stage(self);
        }
        self.bytes()
    }
}

fn empty<T>() -> OnceLock<T> {
    OnceLock::new()
}
