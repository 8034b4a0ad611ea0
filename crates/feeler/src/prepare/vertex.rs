//! Regions around vertices: what the cracks of edges leave open there.
//!
//! A region is the smallest box that holds the ends of all images that meet at a vertex, the images of the segments that join trims there and of the
//! singular trims there. Vertices that an edge or a join connects, whatever the file calls them, are one. The box is made when a line first comes near the faces that have a part in it, all of
//! it being in the box around their surfaces, and near what these have over the parts' boxes in uv.

use super::boundary::{CurveSource, join_source, trim_end, trim_sources};
use super::box_tree::{BoxTree, Known, Skewer};
use super::closed::{self, CurveShape};
use super::image::{end, image, image_of_one};
use super::patch::boxes;
use super::{Box3, FaceGeometry, PreparedBrep, around};
use crate::brep::{Brep, TrimLoop};
use crate::numeric::Real;
use std::sync::OnceLock;

/// A bound that is off by a few roundings.
const UP: f64 = 1.0 + 64.0 * f64::EPSILON;

/// All of a BREP's, in a tree.
#[derive(Debug)]
pub(crate) struct Vertices {
    all: Box<[Vertex]>,
    tree: BoxTree,
}

#[derive(Debug)]
struct Vertex {
    parts: Box<[Part]>,
    /// Around the surfaces of the faces that have a part in it; `None` where none is known.
    far: Option<Box3>,
    /// Around what they have over the boxes of the parts in uv; `None` where one is not known.
    rough: OnceLock<Option<Box3>>,
    /// The region; `None` where an image is not known.
    near: OnceLock<Option<Box3>>,
    /// The same in double-double.
    fine: OnceLock<Option<Box3>>,
}

/// What a region holds.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// The segment that joins a trim of a loop, by its place there, to the next.
    Join { of: usize, at: usize },
    /// A singular trim.
    Trim(usize),
    /// An end of a trim.
    End { trim: usize, last: bool },
}

impl Vertices {
    pub(super) fn new(brep: &PreparedBrep) -> Self {
        let classes = classes(brep.brep());
        let parts = brep.brep().parts();
        let middle = |class: &Class| parts.vertices[class.vertex].point;
        let tree = BoxTree::new(&classes.iter().map(|c| middle(c).into()).collect::<Vec<_>>());
        let all = classes.into_iter().map(|class| {
            let boxes = class.parts.iter().map(|p| {
                let face = match *p {
                    Part::Join { of, .. } => parts.loops[of].face,
                    Part::Trim(trim) | Part::End { trim, .. } => brep.face_of(trim),
                };
                brep.face_box(face).copied()
            });
            let boxes: Option<Vec<Box3>> = boxes.collect();
            Vertex {
                far: boxes.map(|b| around(&b)),
                parts: class.parts.into(),
                rough: OnceLock::new(),
                near: OnceLock::new(),
                fine: OnceLock::new(),
            }
        });
        Self {
            all: all.collect(),
            tree,
        }
    }

    /// Whether a line may meet one. It is asked of few boxes: others are told in the tree.
    pub(crate) fn meet(
        &self,
        brep: &PreparedBrep,
        line: &Skewer,
        misses: impl Fn(&Box3) -> bool,
    ) -> bool {
        let known = |index: usize| {
            let vertex = &self.all[index];
            if vertex.near.get().is_none()
                && (vertex.far.as_ref().is_some_and(&misses)
                    || vertex.rough(brep).is_some_and(|b| misses(&b)))
            {
                return Known::Missed;
            }
            Known::Box(vertex.near(brep))
        };
        self.tree.any(line, known, |index| {
            let vertex = &self.all[index];
            let missed = |b: Option<Box3>| b.as_ref().is_some_and(&misses);
            // All that may tell, whatever has been made before; f64 sees only so far, and what it finds near is looked at again.
            !missed(vertex.far)
                && !missed(vertex.rough(brep))
                && !missed(vertex.near(brep))
                && !missed(vertex.fine(brep))
        })
    }

    /// All regions; `None` where one is not known.
    pub(super) fn regions<'a>(
        &'a self,
        brep: &'a PreparedBrep,
    ) -> impl Iterator<Item = Option<Box3>> + 'a {
        self.all.iter().map(|v| v.near(brep))
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        let parts = self.all.iter().map(|v| size_of_val(&*v.parts));
        size_of_val(self) + size_of_val(&*self.all) + parts.sum::<usize>() + self.tree.bytes()
    }
}

impl Vertex {
    fn rough(&self, brep: &PreparedBrep) -> Option<Box3> {
        let make = || {
            let boxes = self.parts.iter().filter_map(|part| rough(brep, part));
            let boxes: Option<Vec<Box3>> = boxes.collect();
            Some(around(&boxes?))
        };
        *self.rough.get_or_init(make)
    }

    fn near(&self, brep: &PreparedBrep) -> Option<Box3> {
        let make = || region(brep, &self.parts, |face| brep.double(face));
        *self.near.get_or_init(make)
    }

    fn fine(&self, brep: &PreparedBrep) -> Option<Box3> {
        let make = || region(brep, &self.parts, |face| brep.double_double(face));
        *self.fine.get_or_init(make)
    }
}

/// A vertex of the BREP, one of those that are one, and what its region holds.
struct Class {
    vertex: usize,
    parts: Vec<Part>,
}

/// The vertices that have a part of some trim.
fn classes(brep: &Brep) -> Vec<Class> {
    let parts = brep.parts();
    let mut class: Vec<usize> = (0..parts.vertices.len()).collect();
    fn root(class: &mut [usize], mut v: usize) -> usize {
        while class[v] != v {
            class[v] = class[class[v]];
            v = class[v];
        }
        v
    }
    let join = |class: &mut [usize], a: usize, b: usize| {
        let (a, b) = (root(class, a), root(class, b));
        class[a] = b;
    };
    let mut found: Vec<(usize, Part)> = Vec::new();
    for (of, l) in parts.loops.iter().enumerate() {
        for (at, &t) in l.trims.iter().enumerate() {
            let trim = &parts.trims[t];
            let next = &parts.trims[l.trims[(at + 1) % l.trims.len()]];
            join(&mut class, trim.vertices[1], next.vertices[0]);
            found.push((trim.vertices[1], Part::Join { of, at }));
            if trim.edge.is_none() {
                join(&mut class, trim.vertices[0], trim.vertices[1]);
                found.push((trim.vertices[1], Part::Trim(t)));
            } else {
                let ends = [false, true].map(|last| Part::End { trim: t, last });
                found.extend(trim.vertices.into_iter().zip(ends));
            }
        }
    }
    for e in &parts.edges {
        for pair in e.trims.windows(2) {
            let [s, t] = [&parts.trims[pair[0]], &parts.trims[pair[1]]];
            let turned = usize::from(s.edge_reversed != t.edge_reversed);
            for end in 0..2 {
                join(&mut class, s.vertices[end], t.vertices[end ^ turned]);
            }
        }
    }
    let mut out: Vec<Class> = (0..class.len())
        .map(|vertex| Class {
            vertex,
            parts: Vec::new(),
        })
        .collect();
    for (v, part) in found {
        out[root(&mut class, v)].parts.push(part);
    }
    out.retain(|c| !c.parts.is_empty());
    out
}

/// A box around what a face's surface has over a part's box in uv: `Some(None)` where none is known, and `None` where there is no such part.
fn rough(brep: &PreparedBrep, part: &Part) -> Option<Option<Box3>> {
    let parts = brep.brep().parts();
    let over = |trim: usize, sources: &mut dyn Iterator<Item = CurveSource>| {
        brep.box_over(brep.face_of(trim), sources)
    };
    Some(match *part {
        Part::Join { of, at } => {
            let trims = &parts.loops[of].trims;
            let source = join_source(brep.brep(), trims, at)?;
            over(trims[at], &mut std::iter::once(source))
        }
        Part::Trim(trim) => over(trim, &mut trim_sources(brep.brep(), trim)),
        Part::End { trim, last } => {
            let end = trim_end::<f64>(brep.brep(), trim, last).filter(|p| p[2].is_above(0.0));
            end.and_then(|p| {
                let uv = [p[0] / p[2], p[1] / p[2]].map(|x| [x.lower(), x.upper()]);
                let known = uv.iter().flatten().all(|x| x.is_finite());
                let surface = brep.brep().surface(brep.face_of(trim));
                known.then(|| boxes::box_over(surface, &uv)).flatten()
            })
        }
    })
}

/// The box around some parts; `None` where an image is not known.
fn region<'a, T: Real + 'a>(
    brep: &PreparedBrep,
    parts: &[Part],
    geometry: impl Fn(usize) -> &'a FaceGeometry<T>,
) -> Option<Box3> {
    let mut out: Option<Box3> = None;
    for part in parts {
        let own = match *part {
            Part::Join { of, at } => {
                let of = &brep.brep().parts().loops[of];
                match join_region(brep, || geometry(of.face), of, at) {
                    Some(own) => own?,
                    None => continue,
                }
            }
            Part::Trim(trim) => trim_region(brep, || geometry(brep.face_of(trim)), trim)?,
            Part::End { trim, last } => {
                end_region(brep, || geometry(brep.face_of(trim)), trim, last)?
            }
        };
        out = Some(out.map_or(own, |b| around(&[b, own])));
    }
    out
}

/// A box around a point.
fn point_region(p: &closed::V3, slack: f64) -> Box3 {
    p.map(|x| {
        [
            (x.lower() - slack).next_down(),
            (x.upper() + slack).next_up(),
        ]
    })
}

/// Circles of at most this part of the model's size are boxed whole: the arcs that poles are, but for rounding.
const SMALL_CIRCLE: f64 = 1.0 / (1u64 << 40) as f64;

/// A box around a segment or the circle of a small arc; `size` is the model's.
fn curve_region(shape: &CurveShape, slack: f64, size: f64) -> Option<Box3> {
    match shape {
        CurveShape::Segment(s) => {
            let [a, b] = [&s.a, &s.b].map(|p| point_region(p, slack));
            Some(std::array::from_fn(|c| {
                [a[c][0].min(b[c][0]), a[c][1].max(b[c][1])]
            }))
        }
        CurveShape::Arc(a) if a.radius.upper() <= SMALL_CIRCLE * size => {
            // The axes are of length one, up to rounding.
            Some(point_region(&a.center, (slack + a.radius.upper()) * UP))
        }
        CurveShape::Arc(_) => None,
    }
}

/// A box around the image of the segment that joins a trim, by its place in its loop, to the next, if there is one: `Some(None)` where none is known.
fn join_region<'a, T: Real + 'a>(
    brep: &PreparedBrep,
    geometry: impl FnOnce() -> &'a FaceGeometry<T>,
    of: &TrimLoop,
    at: usize,
) -> Option<Option<Box3>> {
    if let Some(form) = brep.closed(of.face)
        && let Ok(join) = form.join_of(of.trims[at])
    {
        let join = join?;
        if let Some(region) = curve_region(join.shape, join.slack, brep.size()) {
            return Some(Some(region));
        }
    }
    let source = join_source(brep.brep(), &of.trims, at)?;
    Some(image_of_one(geometry(), source).map(|image| image.bounds()))
}

/// A box around the image of a trim.
fn trim_region<'a, T: Real + 'a>(
    brep: &PreparedBrep,
    geometry: impl FnOnce() -> &'a FaceGeometry<T>,
    trim: usize,
) -> Option<Box3> {
    let closed = brep.closed_image(trim);
    let region = closed.and_then(|i| curve_region(i.shape, i.slack, brep.size()));
    region.or_else(|| Some(image(geometry(), trim)?.bounds()))
}

/// A box around an end of the image of a trim.
pub(super) fn end_region<'a, T: Real + 'a>(
    brep: &PreparedBrep,
    geometry: impl FnOnce() -> &'a FaceGeometry<T>,
    trim: usize,
    last: bool,
) -> Option<Box3> {
    if let Some(image) = brep.closed_image(trim) {
        let ends = match image.shape {
            CurveShape::Segment(s) => [&s.a, &s.b],
            CurveShape::Arc(a) => [&a.ends[0], &a.ends[1]],
        };
        let point = ends[usize::from(last != image.against)];
        return Some(point_region(point, image.slack));
    }
    end(geometry(), trim, last)
}
