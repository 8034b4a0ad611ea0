//! From the lists of a file to the parts of a [`Brep`](feeler::brep::Brep).
//!
//! The format keeps lists with holes: a curve may be missing, an item may be marked as deleted. Both
//! are dropped and the indices renumbered; a reference to one is an error.

use super::archive::Chunk;
use crate::error::{Problem, ReadError};
use crate::sheets::ROUNDING;
use feeler::brep::{BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop, Vertex};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve2, Curve3, Surface};
use nalgebra::Point3;

/// A list with holes, renumbered.
pub(super) struct Kept<T> {
    what: &'static str,
    items: Vec<T>,
    /// Where each stored item went.
    place: Vec<Option<usize>>,
}

impl<T> Kept<T> {
    pub(super) fn new(what: &'static str) -> Self {
        Self {
            what,
            items: Vec::new(),
            place: Vec::new(),
        }
    }

    pub(super) fn push(&mut self, item: Option<T>) {
        self.place.push(item.as_ref().map(|_| self.items.len()));
        self.items.extend(item);
    }

    pub(super) fn items_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.items.iter_mut()
    }
}

pub(super) struct StoredVertex {
    pub(super) point: Point3<f64>,
    pub(super) edges: Vec<i32>,
    pub(super) tolerance: Option<f64>,
}

pub(super) struct StoredEdge {
    pub(super) curve: i32,
    pub(super) reversed: bool,
    pub(super) span: [f64; 2],
    pub(super) vertices: [i32; 2],
    pub(super) trims: Vec<i32>,
    pub(super) tolerance: Option<f64>,
}

pub(super) struct StoredTrim {
    pub(super) curve: i32,
    pub(super) reversed: bool,
    pub(super) span: [f64; 2],
    pub(super) edge: i32,
    pub(super) edge_reversed: bool,
    pub(super) vertices: [i32; 2],
    pub(super) kind: TrimKind,
    pub(super) iso: Iso,
    pub(super) trim_loop: i32,
}

pub(super) struct StoredLoop {
    pub(super) trims: Vec<i32>,
    pub(super) kind: i32,
    pub(super) face: i32,
}

pub(super) struct StoredFace {
    pub(super) loops: Vec<i32>,
    pub(super) surface: i32,
    pub(super) reversed: bool,
}

/// The lists of a BREP after its curves and surfaces.
pub(super) struct Topology {
    pub(super) vertices: Kept<StoredVertex>,
    pub(super) edges: Kept<StoredEdge>,
    pub(super) trims: Kept<StoredTrim>,
    pub(super) loops: Kept<StoredLoop>,
    pub(super) faces: Kept<StoredFace>,
}

/// Builds the parts; `at` is the BREP's offset, where errors point to.
pub(super) struct Assembly<'c, 'a> {
    pub(super) data: &'c Chunk<'a>,
    pub(super) at: usize,
    pub(super) warnings: Vec<String>,
}

/// Whose references are being resolved.
#[derive(Clone, Copy)]
struct Owner(&'static str, usize);

impl Assembly<'_, '_> {
    fn place<T>(&self, owner: Owner, target: i32, list: &Kept<T>) -> Result<usize, ReadError> {
        let place = usize::try_from(target).ok().and_then(|i| list.place.get(i));
        match place {
            Some(Some(place)) => Ok(*place),
            _ => Err(self.data.fail_at(
                self.at,
                Problem::Reference {
                    owner: owner.0,
                    index: owner.1,
                    what: list.what,
                    target,
                    count: list.items.len(),
                },
            )),
        }
    }

    fn places<T>(
        &self,
        owner: Owner,
        targets: &[i32],
        list: &Kept<T>,
    ) -> Result<Vec<usize>, ReadError> {
        targets
            .iter()
            .map(|t| self.place(owner, *t, list))
            .collect()
    }

    /// The part of a curve that `owner` uses.
    fn span(
        &mut self,
        owner: Owner,
        stored: [f64; 2],
        domain: Interval,
    ) -> Result<Interval, ReadError> {
        let slack = ROUNDING * domain.start.abs().max(domain.end.abs());
        let [mut start, mut end] = stored;
        if start < domain.start && domain.start - start <= slack {
            start = domain.start;
        }
        if end > domain.end && end - domain.end <= slack {
            end = domain.end;
        }
        let Owner(what, index) = owner;
        if [start, end] != stored {
            self.warnings.push(format!(
                "{what} {index}: span [{:?}, {:?}] cut to the curve's domain [{:?}, {:?}]",
                stored[0], stored[1], domain.start, domain.end
            ));
        }
        Interval::new(start, end).ok_or_else(|| {
            self.data.fail_at(
                self.at,
                Problem::Value {
                    what: format!("the span of {what} {index}"),
                    found: format!("[{start:?}, {end:?}]"),
                    expected: "a finite increasing interval".into(),
                },
            )
        })
    }

    /// All parts, their indices renumbered. Ranges and finiteness of the rest are
    /// [`Brep::new`](feeler::brep::Brep::new)'s to check.
    pub(super) fn parts(
        &mut self,
        curves2: Kept<Curve2>,
        curves3: Kept<Curve3>,
        surfaces: Kept<Surface>,
        topology: &Topology,
    ) -> Result<BrepParts, ReadError> {
        let Topology {
            vertices,
            edges,
            trims,
            loops,
            faces,
        } = topology;
        let mut parts = BrepParts::default();
        for (i, v) in vertices.items.iter().enumerate() {
            parts.vertices.push(Vertex {
                point: v.point,
                edges: self.places(Owner("vertex", i), &v.edges, edges)?,
                tolerance: v.tolerance,
            });
        }
        for (i, e) in edges.items.iter().enumerate() {
            let owner = Owner("edge", i);
            let (curve, span) = if e.curve == -1 {
                let unused = Interval {
                    start: 0.0,
                    end: 1.0,
                };
                (None, unused)
            } else {
                let place = self.place(owner, e.curve, &curves3)?;
                let domain = curves3.items.get(place).map(Curve3::domain);
                let own = Interval {
                    start: e.span[0],
                    end: e.span[1],
                };
                (
                    Some(place),
                    self.span(owner, e.span, domain.unwrap_or(own))?,
                )
            };
            parts.edges.push(Edge {
                curve,
                span,
                reversed: e.reversed,
                vertices: [
                    self.place(owner, e.vertices[0], vertices)?,
                    self.place(owner, e.vertices[1], vertices)?,
                ],
                trims: self.places(owner, &e.trims, trims)?,
                tolerance: e.tolerance,
            });
        }
        for (i, t) in trims.items.iter().enumerate() {
            parts
                .trims
                .push(self.trim(Owner("trim", i), t, &curves2, topology)?);
        }
        for (i, l) in loops.items.iter().enumerate() {
            let owner = Owner("loop", i);
            parts.loops.push(TrimLoop {
                kind: self.loop_kind(i, l.kind)?,
                trims: self.places(owner, &l.trims, trims)?,
                face: self.place(owner, l.face, faces)?,
            });
        }
        for (i, f) in faces.items.iter().enumerate() {
            let owner = Owner("face", i);
            if f.loops.is_empty() {
                self.warnings
                    .push(format!("face {i} has no loops: nothing of it is left"));
            }
            parts.faces.push(Face {
                surface: self.place(owner, f.surface, &surfaces)?,
                loops: Some(self.places(owner, &f.loops, loops)?),
                reversed: f.reversed,
            });
        }
        parts.curves2 = curves2.items;
        parts.curves3 = curves3.items;
        parts.surfaces = surfaces.items;
        Ok(parts)
    }

    fn trim(
        &mut self,
        owner: Owner,
        t: &StoredTrim,
        curves2: &Kept<Curve2>,
        topology: &Topology,
    ) -> Result<TrimCurve, ReadError> {
        let curve = self.place(owner, t.curve, curves2)?;
        let own = Interval {
            start: t.span[0],
            end: t.span[1],
        };
        let domain = curves2.items.get(curve).map(Curve2::domain);
        let edge = match t.edge {
            -1 => None,
            e => Some(self.place(owner, e, &topology.edges)?),
        };
        Ok(TrimCurve {
            curve,
            span: self.span(owner, t.span, domain.unwrap_or(own))?,
            reversed: t.reversed,
            edge,
            edge_reversed: t.edge_reversed,
            vertices: [
                self.place(owner, t.vertices[0], &topology.vertices)?,
                self.place(owner, t.vertices[1], &topology.vertices)?,
            ],
            kind: t.kind,
            iso: t.iso,
            trim_loop: self.place(owner, t.trim_loop, &topology.loops)?,
        })
    }

    /// Loops that bound nothing (curves and points on a surface) are refused: by parity they would.
    fn loop_kind(&self, index: usize, stored: i32) -> Result<LoopKind, ReadError> {
        match stored {
            0 => Ok(LoopKind::Unknown),
            1 => Ok(LoopKind::Outer),
            2 => Ok(LoopKind::Inner),
            3 => Ok(LoopKind::Slit),
            _ => Err(self.data.fail_at(
                self.at,
                Problem::Value {
                    what: format!("the kind of loop {index}"),
                    found: stored.to_string(),
                    expected: "0 to 3 (a border, a hole or a slit)".into(),
                },
            )),
        }
    }
}
