//! From shapes to BREPs.
//!
//! Every solid becomes a BREP, as do every shell outside of one and the faces that lie loose in one compound: see [`sites`](super::sites). Two uses
//! of a shape are one edge or vertex if they stand at the same location. A loop is read on its
//! face as if that were not reversed, which is how the file's curves in uv run; the face's own orientation, composed with
//! those of all that it is part of, says on which side material is.

use super::builder::{Builder, EdgeUse};
use super::curves::{Budget, clamped, moved};
use super::error::TextProblem;
use super::motion::Place;
use super::projection::projected;
use super::shapes::{Edge as FileEdge, Kind, Orientation, Sub, Tables};
use super::surfaces::wide;
use super::tokens::fail;
use super::wires::{Use, chains};
use crate::error::ReadError;
use crate::sheets::{jumps, kinds};
use feeler::brep::{Brep, Edge, Vertex};
use feeler::numeric::Interval;

/// Numbers that may be made of a file of no bytes, and for each byte: 1 MB, and 64 bytes a byte.
const NUMBERS: usize = 1 << 17;
const NUMBERS_PER_BYTE: usize = 8;

/// Uses of shapes that the bodies of a file may unfold to, some hundred bytes each: what a body places of its own parts is made, other than [bodies that are
/// placed](super::sites).
const USES: usize = 1 << 12;
/// And for each one that it lists.
const USES_PER_PART: usize = 16;

/// What becomes an object.
#[derive(Debug)]
pub(super) struct Body {
    /// The shape in the table.
    pub(super) shape: usize,
    /// What it is called.
    pub(super) class: &'static str,
    /// Its faces; empty for wires, edges and vertices.
    pub(super) faces: Vec<Sub>,
    /// Shapes within it that bound nothing.
    pub(super) skipped: usize,
}

pub(super) struct Assembly {
    pub(super) tables: Tables,
    numbers: Budget,
    uses: usize,
    uses_limit: usize,
}

const INTERNAL: &str =
    "shapes inside or outside of what they are part of (they bound nothing) are left out";
const OFFSET: &str =
    "edges' curves in space that are offset curves are left out; their faces' curves in uv remain";
const WARPED: &str = "surfaces made of an ellipse or a hyperbola have the parameter of its NURBS form; their curves in uv were taken along";
const BROKEN: &str = "wires fall apart into several loops";

impl Assembly {
    pub(super) fn new(tables: Tables, size: usize) -> Self {
        let parts: usize = tables.shapes.iter().map(|s| s.parts.len()).sum();
        let uses_limit = USES.saturating_add(USES_PER_PART.saturating_mul(parts));
        let numbers = NUMBERS.saturating_add(NUMBERS_PER_BYTE.saturating_mul(size));
        Self {
            tables,
            numbers: Budget::new(numbers),
            uses: uses_limit,
            uses_limit,
        }
    }

    pub(super) fn line(&self, shape: usize) -> usize {
        self.tables.shapes.get(shape).map_or(0, |s| s.line)
    }

    pub(super) fn offset(&self, shape: usize) -> usize {
        self.tables.shapes.get(shape).map_or(0, |s| s.offset)
    }

    /// Counts one more use.
    fn visit(&mut self, shape: usize) -> Result<(), ReadError> {
        match self.uses.checked_sub(1) {
            Some(left) => {
                self.uses = left;
                Ok(())
            }
            None => Err(fail(
                self.line(shape),
                TextProblem::Limit {
                    what: "uses of shapes",
                    limit: self.uses_limit,
                },
            )),
        }
    }

    fn product(&mut self, shape: usize, a: Place, b: Place) -> Result<Place, ReadError> {
        let place = self.tables.places.product(a, b);
        place.map_err(|problem| fail(self.line(shape), problem))
    }

    /// The parts of a shape, placed and oriented.
    pub(super) fn parts(&mut self, of: Sub) -> Result<Vec<Sub>, ReadError> {
        let count = self
            .tables
            .shapes
            .get(of.shape)
            .map_or(0, |s| s.parts.len());
        let mut parts = Vec::with_capacity(count);
        for i in 0..count {
            let part = self
                .tables
                .shapes
                .get(of.shape)
                .and_then(|s| s.parts.get(i).copied());
            let Some(mut part) = part else { continue };
            self.visit(of.shape)?;
            part.place = self.product(of.shape, of.place, part.place)?;
            part.orientation = part.orientation.within(of.orientation);
            parts.push(part);
        }
        Ok(parts)
    }

    pub(super) fn kind(&self, shape: usize) -> Option<&Kind> {
        self.tables.shapes.get(shape).map(|s| &s.kind)
    }

    /// The faces of a solid or shell. A shape's parts stand before it in the file: this ends.
    pub(super) fn faces(&mut self, of: Sub, body: &mut Body) -> Result<(), ReadError> {
        let mut open = vec![of];
        while let Some(next) = open.pop() {
            if matches!(self.kind(next.shape), Some(Kind::Face { .. })) {
                body.faces.push(next);
                continue;
            }
            for part in self.parts(next)?.into_iter().rev() {
                if part.orientation.bounds() {
                    open.push(part);
                } else {
                    body.skipped += 1;
                }
            }
        }
        Ok(())
    }

    /// The BREP of a body, and what was odd about it; `None` if it has no faces.
    pub(super) fn brep(&mut self, body: &Body) -> Result<Option<(Brep, Vec<String>)>, ReadError> {
        if body.faces.is_empty() && !matches!(body.class, "solid" | "shell") {
            return Ok(None);
        }
        let mut builder = Builder::default();
        if body.skipped > 0 {
            builder.odd.insert(INTERNAL, body.skipped);
        }
        for face in &body.faces {
            self.face(&mut builder, *face)?;
        }
        let Builder {
            mut parts,
            odd,
            is_moved,
            ..
        } = builder;
        kinds(&mut parts);
        let brep =
            Brep::new(parts).map_err(|e| fail(self.line(body.shape), TextProblem::Brep(e)))?;
        let mut warnings: Vec<String> = odd.iter().map(|(what, n)| format!("{n} {what}")).collect();
        if is_moved {
            warnings
                .push("moved to where the file's locations say: coordinates are rounded".into());
        }
        warnings.extend(jumps(&brep));
        Ok(Some((brep, warnings)))
    }

    fn face(&mut self, b: &mut Builder, face: Sub) -> Result<(), ReadError> {
        let line = self.line(face.shape);
        let Some(&Kind::Face { surface, place }) = self.kind(face.shape) else {
            return Ok(());
        };
        let Some(surface) = surface else {
            return Err(fail(
                line,
                TextProblem::Unsupported {
                    what: "a face that is nothing but triangles".into(),
                    remedy: "give it a surface",
                },
            ));
        };
        let place = self.product(face.shape, face.place, place)?;
        // As if the face were not reversed.
        let forward = Sub {
            orientation: Orientation::Forward,
            ..face
        };
        let mut loops: Vec<Vec<EdgeUse>> = Vec::new();
        let mut has_wires = false;
        for wire in self.parts(forward)? {
            if !matches!(self.kind(wire.shape), Some(Kind::Wire)) || !wire.orientation.bounds() {
                *b.odd.entry(INTERNAL).or_default() += 1;
                continue;
            }
            has_wires = true;
            let mut uses = Vec::new();
            for edge in self.parts(wire)? {
                if edge.orientation.bounds() {
                    uses.extend(self.edge_use(b, edge, surface, place)?.map(Some));
                } else {
                    *b.odd.entry(INTERNAL).or_default() += 1;
                }
            }
            let ends: Vec<Use> = uses.iter().flatten().map(|u| b.ends(u)).collect();
            let chains = chains(&ends);
            if chains.len() > 1 {
                *b.odd.entry(BROKEN).or_default() += 1;
            }
            for chain in chains {
                let taken = chain
                    .into_iter()
                    .map(|i| uses.get_mut(i).and_then(Option::take));
                loops.push(taken.flatten().collect());
            }
        }
        let Some(form) = self.tables.surfaces.get(surface) else {
            return Ok(());
        };
        let geometry = |problem| fail(form.line, problem);
        let periods = form.item.periods();
        b.lift(&mut loops, periods);
        // Of a surface that is used as it stands nobody asks how far loops reach, which takes long to say.
        let reach = match form.item.is_whole() {
            true => [None; 2],
            false => b.reach(&loops, periods),
        };
        let motion = self.tables.places.motion(place).map_err(geometry)?;
        b.is_moved |= !motion.is_identity();
        let mirrors = motion.mirrors();
        let shared = form.item.is_whole().then_some((surface, place));
        let index = match shared.and_then(|key| b.surfaces.get(&key)) {
            Some(index) => *index,
            None => {
                let reach = reach.map(|r| r.map(wide));
                let part = form.item.part(reach, motion, &mut self.numbers);
                b.parts.surfaces.push(part.map_err(geometry)?);
                let index = b.parts.surfaces.len() - 1;
                b.surfaces.extend(shared.map(|key| (key, index)));
                index
            }
        };
        let domain = b.parts.surfaces.get(index).map(|s| s.domain());
        if let Some(domain) = domain
            && let Some((c, warp)) = form.item.warp(domain).map_err(geometry)?
        {
            *b.odd.entry(WARPED).or_default() += 1;
            for u in loops.iter_mut().flatten() {
                let Some(curve) = b.parts.curves2.get(u.curve) else {
                    continue;
                };
                let lengths = domain.map(|d| d.length());
                let taken = warp.taken(curve, u.span, c, lengths, &mut self.numbers);
                u.curve = b.parts.curves2.len();
                b.parts.curves2.push(taken.map_err(geometry)?);
            }
        }
        b.face(
            index,
            has_wires,
            loops,
            (face.orientation == Orientation::Reversed) != mirrors,
        );
        Ok(())
    }

    /// The use of an edge on a surface at a location.
    fn edge_use(
        &mut self,
        b: &mut Builder,
        edge: Sub,
        surface: usize,
        on: Place,
    ) -> Result<Option<EdgeUse>, ReadError> {
        let line = self.line(edge.shape);
        if !matches!(self.kind(edge.shape), Some(Kind::Edge(_))) {
            return Err(fail(
                line,
                TextProblem::Shape {
                    what: "a wire has a part that is no edge".into(),
                },
            ));
        }
        let reversed = edge.orientation == Orientation::Reversed;
        let mut vertices = self.vertices(b, edge)?;
        let relative = self.tables.places.relative(edge.place, on);
        let relative = relative.map_err(|problem| fail(line, problem))?;
        let Some(Kind::Edge(stored)) = self.kind(edge.shape) else {
            return Ok(None);
        };
        let degenerated = stored.degenerated;
        let on_surface = stored.on_surfaces.iter().copied();
        let found = on_surface
            .clone()
            .find(|r| r.surface == surface && r.place == relative);
        let (curve, span) = match found {
            Some(r) => {
                let curve = r.second.filter(|_| reversed).unwrap_or(r.curve);
                self.uv_curve(b, curve, r.range)?
            }
            None => self.projection(b, edge.shape, surface, relative)?,
        };
        if !degenerated {
            self.edge(b, edge.shape, edge.place, vertices)?;
        }
        if reversed {
            vertices.reverse();
        }
        Ok(Some(EdgeUse {
            shape: edge.shape,
            place: edge.place,
            reversed,
            curve,
            span,
            vertices,
            degenerated,
        }))
    }

    fn uv_curve(
        &mut self,
        b: &mut Builder,
        curve: usize,
        range: [f64; 2],
    ) -> Result<(usize, Interval), ReadError> {
        let Some(form) = self.tables.curves2.get(curve) else {
            return Err(fail(0, TextProblem::Header));
        };
        let geometry = |problem| fail(form.line, problem);
        if form.item.is_whole() {
            if let Some(index) = b.curves2.get(&curve)
                && let Some(shared) = b.parts.curves2.get(*index)
                && let Some(span) = Interval::new(range[0], range[1])
            {
                return Ok((*index, clamped(span, shared.domain())));
            }
            b.curves2.insert(curve, b.parts.curves2.len());
        }
        let (part, span) = form.item.part(range, &mut self.numbers).map_err(geometry)?;
        b.parts.curves2.push(part);
        Ok((b.parts.curves2.len() - 1, span))
    }

    /// The curve in uv that the file leaves out: only planes may do so.
    fn projection(
        &mut self,
        b: &mut Builder,
        edge: usize,
        surface: usize,
        relative: Place,
    ) -> Result<(usize, Interval), ReadError> {
        let line = self.line(edge);
        let missing = || {
            let what = "an edge has no curve on the surface of its face, which is no plane".into();
            fail(line, TextProblem::Shape { what })
        };
        let Some(Kind::Edge(FileEdge { in_space, .. })) = self.kind(edge) else {
            return Err(missing());
        };
        let in_space = in_space.ok_or_else(missing)?;
        // From the edge's curve to the edge, and from there to the surface.
        let places = &mut self.tables.places;
        let place = places.relative(relative, in_space.place);
        let motion = place.and_then(|p| places.motion(p).cloned());
        let motion = motion.map_err(|problem| fail(line, problem))?;
        let axes = self
            .tables
            .surfaces
            .get(surface)
            .and_then(|s| s.item.plane());
        let axes = axes.ok_or_else(missing)?;
        let form = self
            .tables
            .curves3
            .get(in_space.curve)
            .ok_or_else(missing)?;
        let (curve, span) = form
            .item
            .part(in_space.range, &mut self.numbers)
            .and_then(|(curve, span)| Ok((projected(&moved(curve, &motion)?, axes)?, span)))
            .map_err(|problem| fail(form.line, problem))?;
        b.parts.curves2.push(curve);
        Ok((b.parts.curves2.len() - 1, span))
    }

    /// Start and end vertex of an edge.
    fn vertices(&mut self, b: &mut Builder, edge: Sub) -> Result<[usize; 2], ReadError> {
        let line = self.line(edge.shape);
        let mut ends = [None; 2];
        let forward = Sub {
            orientation: Orientation::Forward,
            ..edge
        };
        for part in self.parts(forward)? {
            let end = match part.orientation {
                Orientation::Forward => 0,
                Orientation::Reversed => 1,
                // On the edge, not at its end.
                Orientation::Internal | Orientation::External => continue,
            };
            let Some(&Kind::Vertex { tolerance, point }) = self.kind(part.shape) else {
                continue;
            };
            let motion = self.tables.places.motion(part.place);
            let motion = motion.map_err(|problem| fail(line, problem))?;
            let count = b.parts.vertices.len();
            let index = *b.vertices.entry((part.shape, part.place)).or_insert(count);
            if index == count {
                b.parts.vertices.push(Vertex {
                    point: if motion.is_identity() {
                        point
                    } else {
                        motion.point(&point)
                    },
                    edges: Vec::new(),
                    tolerance: Some(tolerance),
                });
            }
            ends[end] = Some(index);
        }
        match ends {
            [Some(start), Some(end)] => Ok([start, end]),
            _ => Err(fail(
                line,
                TextProblem::Shape {
                    what: "an edge has no start or no end vertex".into(),
                },
            )),
        }
    }

    /// Adds an edge, if it is new.
    fn edge(
        &mut self,
        b: &mut Builder,
        shape: usize,
        place: Place,
        vertices: [usize; 2],
    ) -> Result<(), ReadError> {
        let index = b.parts.edges.len();
        if b.edges.contains_key(&(shape, place)) {
            return Ok(());
        }
        let Some(Kind::Edge(stored)) = self.kind(shape) else {
            return Ok(());
        };
        let (tolerance, in_space) = (stored.tolerance, stored.in_space);
        let mut curve = None;
        // Of no meaning where there is no curve.
        let mut span = Interval {
            start: 0.0,
            end: 1.0,
        };
        if let Some(s) = in_space {
            let whole = self.product(shape, place, s.place)?;
            if let Some(form) = self.tables.curves3.get(s.curve) {
                if form.item.is_offset() {
                    *b.odd.entry(OFFSET).or_default() += 1;
                } else {
                    let geometry = |problem| fail(form.line, problem);
                    let shared = form.item.is_whole().then_some((s.curve, whole));
                    let known = shared.and_then(|key| b.curves3.get(&key)).copied();
                    let known = known.and_then(|i| Some((i, b.parts.curves3.get(i)?.domain())));
                    let own = Interval::new(s.range[0], s.range[1]);
                    if let (Some((i, domain)), Some(own)) = (known, own) {
                        (curve, span) = (Some(i), clamped(own, domain));
                    } else {
                        let motion = self.tables.places.motion(whole).map_err(geometry)?;
                        let (part, own) = form
                            .item
                            .part(s.range, &mut self.numbers)
                            .map_err(geometry)?;
                        let i = b.parts.curves3.len();
                        b.parts.curves3.push(moved(part, motion).map_err(geometry)?);
                        b.curves3.extend(shared.map(|key| (key, i)));
                        (curve, span) = (Some(i), own);
                    }
                }
            }
        }
        b.edges.insert((shape, place), index);
        b.parts.edges.push(Edge {
            curve,
            span,
            reversed: false,
            vertices,
            trims: Vec::new(),
            tolerance: Some(tolerance),
        });
        let [start, end] = vertices;
        for v in if start == end {
            vec![start]
        } else {
            vec![start, end]
        } {
            if let Some(vertex) = b.parts.vertices.get_mut(v) {
                vertex.edges.push(index);
            }
        }
        Ok(())
    }
}
