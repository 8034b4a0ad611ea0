//! A BREP's shapes, and the tables of a file.

use super::curves::Piece;
use super::edges::{self, Curves};
use super::surfaces::{self, Chart};
use super::text::{self, integers, number, numbers};
use super::{Notes, Problem, solids};
use feeler::brep::{Brep, BrepParts};
use feeler::nurbs::Surface;
use std::collections::HashMap;
use std::fmt::Write;

/// A shape without the numbers of its parts, which count from the end of the file.
pub(super) struct Shape {
    pub(super) text: String,
    pub(super) flags: &'static str,
    /// Orientation and shape, by its place from the start.
    pub(super) parts: Vec<(char, usize)>,
}

/// A table of geometry.
#[derive(Default)]
struct Table {
    text: String,
    count: usize,
}

impl Table {
    fn push(
        &mut self,
        write: impl FnOnce(&mut String) -> Result<(), Problem>,
    ) -> Result<usize, Problem> {
        write(&mut self.text)?;
        self.count += 1;
        Ok(self.count)
    }
}

#[derive(Default)]
pub(super) struct Tables {
    curves2: Table,
    curves3: Table,
    surfaces: Table,
    pub(super) shapes: Vec<Shape>,
}

const SURFACE_ROUNDED: &str = "surfaces are not the very same";
const UV_SCALED: &str = "faces' curves in uv are scaled to the format's parameters: rounded";
const UV_ROUNDED: &str = "seams' curves in uv got a common parameter: rounded";
const WEIGHTS: &str =
    "curves in uv have weights that no number times gives a control point back: rounded";
const UV_JOINED: &str = "curves in uv in several pieces are written as one";
const SPACE_ROUNDED: &str = "edges' curves in space got the parameter of those in uv: rounded";
const NOT_ALIKE: &str = "edges' curves in space and in uv run differently, which OCCT finds invalid: mend it there with BRepLib::SameParameter";
const NO_CURVE: &str =
    "edges have no curve in space: make them in OCCT with BRepLib::BuildCurves3d";
const RAISED: &str = "tolerances were too small for their curves: raised";
const NOTHING: &str = "faces of nothing left out";
const LUMPS: &str = "objects are several lumps: a solid each";
const TURNED: &str = "shells' faces look the other way than the format wants: turned";
const UNTOLD: &str =
    "objects whose lumps and the way their faces look lines do not tell: one solid, as stored";
const UNUSED: &str = "edges that bound no face left out";

/// How a face is written.
struct FaceForm {
    /// Its number in the table of surfaces.
    surface: usize,
    chart: Chart,
}

impl Tables {
    /// The whole file.
    pub(super) fn file(&self, header: &str) -> String {
        let mut out = String::with_capacity(
            self.curves2.text.len() + self.curves3.text.len() + self.surfaces.text.len(),
        );
        out.push_str(header);
        out.push_str("Locations 0\n");
        let mut table = |name: &str, table: &Table| {
            let _ = writeln!(out, "{name} {}", table.count);
            out.push_str(&table.text);
        };
        let empty = Table::default();
        table("Curve2ds", &self.curves2);
        table("Curves", &self.curves3);
        table("Polygon3D", &empty);
        table("PolygonOnTriangulations", &empty);
        table("Surfaces", &self.surfaces);
        table("Triangulations", &empty);
        let count = self.shapes.len();
        let _ = writeln!(out, "\nTShapes {count}");
        for shape in &self.shapes {
            let _ = writeln!(out, "{}\n{}", shape.text, shape.flags);
            for (orientation, part) in &shape.parts {
                let _ = write!(out, "{orientation}{} 0 ", count - part);
            }
            out.push_str("*\n");
        }
        // The shape that the file is about stands last.
        out.push_str("\n+1 0 \n");
        out
    }

    fn shape(&mut self, text: String, flags: &'static str, parts: Vec<(char, usize)>) -> usize {
        self.shapes.push(Shape { text, flags, parts });
        self.shapes.len() - 1
    }

    /// Writes a BREP and returns its shapes: several where it is in several lumps.
    pub(super) fn brep(&mut self, brep: &Brep, notes: &mut Notes) -> Result<Vec<usize>, Problem> {
        let parts = brep.parts();
        let at_face = |i: usize, problem: Problem| Problem(format!("face {i}: {}", problem.0));
        let mut faces = Vec::with_capacity(parts.faces.len());
        for (i, face) in parts.faces.iter().enumerate() {
            // A list of loops that is empty bounds nothing.
            if face.loops.as_ref().is_some_and(Vec::is_empty) {
                notes.add(NOTHING, 0.0);
                faces.push(None);
                continue;
            }
            let is_whole = face.loops.is_none();
            let form = self.surface(brep.surface(i), is_whole, notes);
            faces.push(Some(form.map_err(|p| at_face(i, p))?));
        }
        let live = |t: &usize| {
            let trim = parts.trims.get(*t);
            let face = trim
                .and_then(|t| parts.loops.get(t.trim_loop))
                .map(|l| l.face);
            face.is_some_and(|f| faces.get(f).is_some_and(Option::is_some))
        };
        let size = size(parts);
        let mut vertex_off = vec![0.0_f64; parts.vertices.len()];
        let mut off = |v: [usize; 2], by: [f64; 2]| {
            for (v, by) in v.into_iter().zip(by) {
                if let Some(worst) = vertex_off.get_mut(v) {
                    *worst = worst.max(by);
                }
            }
        };
        let mut edges = Vec::with_capacity(parts.edges.len());
        for (i, edge) in parts.edges.iter().enumerate() {
            let trims: Vec<usize> = edge.trims.iter().copied().filter(live).collect();
            if trims.is_empty() {
                notes.add(UNUSED, 0.0);
                edges.push(None);
                continue;
            }
            let curves = edges::curves(brep, edge, &trims, size);
            let curves = curves.map_err(|p| Problem(format!("edge {i}: {}", p.0)))?;
            off(edge.vertices, curves.at_ends);
            edges.push(Some(curves));
        }
        let mut singular = vec![None; parts.trims.len()];
        for (i, trim) in parts.trims.iter().enumerate() {
            if trim.edge.is_none() && live(&i) {
                let (piece, by) = edges::singular(parts, trim)?;
                let mut vertices = trim.vertices;
                if trim.reversed {
                    vertices.reverse();
                }
                off(vertices, by);
                singular[i] = Some((piece, vertices));
            }
        }
        let mut vertices = Vec::with_capacity(parts.vertices.len());
        for (v, worst) in parts.vertices.iter().zip(&vertex_off) {
            let (tolerance, raised) = edges::tolerance(v.tolerance, *worst);
            if raised > 0.0 {
                notes.add(RAISED, raised);
            }
            let mut text = String::from("Ve\n");
            number(&mut text, tolerance);
            text.push('\n');
            numbers(&mut text, v.point.coords.as_slice());
            text.push_str("\n0 0\n");
            vertices.push(self.shape(text, "0101101", Vec::new()));
        }
        let ends = |v: [usize; 2]| -> Result<Vec<(char, usize)>, Problem> {
            let [a, b] = v.map(|v| vertices.get(v).copied());
            let missing = || Problem::new("an edge has no vertex");
            Ok(vec![
                ('+', a.ok_or_else(missing)?),
                ('-', b.ok_or_else(missing)?),
            ])
        };
        let mut edge_shapes = Vec::with_capacity(edges.len());
        for (i, curves) in edges.iter().enumerate() {
            let Some(curves) = curves else {
                edge_shapes.push(None);
                continue;
            };
            let text = self.edge(parts, curves, &faces, notes);
            let text = text.map_err(|p| Problem(format!("edge {i}: {}", p.0)))?;
            let shape = self.shape(text, "0101000", ends(parts.edges[i].vertices)?);
            edge_shapes.push(Some(shape));
        }
        let mut shapes = Vec::with_capacity(faces.len());
        for (i, form) in faces.iter().enumerate() {
            let (Some(form), Some(face)) = (form, parts.faces.get(i)) else {
                continue;
            };
            let mut wires = Vec::new();
            for l in face.loops.iter().flatten() {
                let mut uses = Vec::new();
                for t in parts.loops.get(*l).map_or(&[][..], |l| &l.trims) {
                    let Some(trim) = parts.trims.get(*t) else {
                        continue;
                    };
                    let (shape, mut against) = match (&singular[*t], trim.edge) {
                        (Some((piece, vertices)), _) => {
                            let text = self.degenerated(form, piece, notes)?;
                            let shape = self.shape(text, "0101000", ends(*vertices)?);
                            (Some(shape), trim.reversed)
                        }
                        (None, edge) => {
                            let shape = edge.and_then(|e| edge_shapes.get(e).copied().flatten());
                            (shape, trim.edge_reversed)
                        }
                    };
                    // What swaps u and v turns loops round.
                    against ^= form.chart.swapped;
                    uses.extend(shape.map(|s| (sign(against), s)));
                }
                if form.chart.swapped {
                    uses.reverse();
                }
                if !uses.is_empty() {
                    wires.push(('+', self.shape("Wi\n".into(), "0101100", uses)));
                }
            }
            let natural = usize::from(face.loops.is_none());
            let mut text = String::from("Fa\n");
            integers(&mut text, [natural]);
            number(&mut text, edges::CONFUSION);
            integers(&mut text, [form.surface, 0]);
            text.push('\n');
            let shape = self.shape(text, "0101000", wires);
            shapes.push((i, face.reversed != form.chart.swapped, shape));
        }
        Ok(self.body(brep, &shapes, notes))
    }

    /// A solid for each lump with its cavities, or a shell.
    fn body(
        &mut self,
        brep: &Brep,
        faces: &[(usize, bool, usize)],
        notes: &mut Notes,
    ) -> Vec<usize> {
        let mut shape_of = vec![None; brep.faces().len()];
        for (face, against, shape) in faces {
            if let Some(place) = shape_of.get_mut(*face) {
                *place = Some((*against, *shape));
            }
        }
        let mut shell = |flags, faces: &[usize], turned: bool| {
            let all = faces.iter().filter_map(|f| shape_of.get(*f).copied()?);
            let all = all.map(|(against, shape)| (sign(against != turned), shape));
            self.shape("Sh\n".into(), flags, all.collect())
        };
        if !brep.is_closed() {
            let all = Vec::from_iter(0..brep.faces().len());
            return vec![shell("0101000", &all, false)];
        }
        let groups = connected(brep.parts());
        let mut solids = Vec::new();
        if let Some((lumps, shells)) = solids::lumps(brep, &groups) {
            if lumps.len() > 1 {
                notes.add(LUMPS, 0.0);
            }
            for lump in lumps {
                let mut parts = Vec::with_capacity(lump.len());
                for (s, turned) in lump {
                    if turned {
                        notes.add(TURNED, 0.0);
                    }
                    let faces = shells.get(s).map_or(&[][..], |s| &s.faces);
                    parts.push(('+', shell("0101100", faces, turned)));
                }
                solids.push(parts);
            }
        } else {
            notes.add(UNTOLD, 0.0);
            let shells = solids::shells(&groups).into_iter();
            let shells = shells.map(|faces| ('+', shell("0101100", &faces, false)));
            solids.push(shells.collect());
        }
        let solids = solids.into_iter();
        solids
            .map(|parts| self.shape("So\n".into(), "0100000", parts))
            .collect()
    }

    fn surface(
        &mut self,
        surface: &Surface,
        is_whole: bool,
        notes: &mut Notes,
    ) -> Result<FaceForm, Problem> {
        let written = surfaces::written(surface)?;
        if !written.exact {
            notes.add(SURFACE_ROUNDED, written.off);
        }
        if written.chart.rounds() {
            notes.add(UV_SCALED, 0.0);
        }
        let chart = written.chart;
        let form = if is_whole {
            written.bounded(surface)
        } else {
            written.form
        };
        Ok(FaceForm {
            surface: self.surfaces.push(|out| text::surface(out, &form))?,
            chart,
        })
    }

    fn curve2(
        &mut self,
        face: &FaceForm,
        piece: &Piece<2, 3>,
        notes: &mut Notes,
    ) -> Result<usize, Problem> {
        let moved = piece.charted(&face.chart)?;
        let form = moved.form()?;
        let off = text::off_by_weights(&form);
        if off > 0.0 {
            notes.add(WEIGHTS, off);
        }
        self.curves2.push(|out| text::curve(out, &form))
    }

    fn edge(
        &mut self,
        parts: &BrepParts,
        edge: &Curves,
        faces: &[Option<FaceForm>],
        notes: &mut Notes,
    ) -> Result<String, Problem> {
        let alike = usize::from(edge.alike);
        let mut text = String::from("Ed\n");
        number(&mut text, edge.tolerance);
        integers(&mut text, [alike, alike, 0]);
        text.push('\n');
        if edge.raised > 0.0 {
            notes.add(RAISED, edge.raised);
        }
        if !edge.alike {
            notes.add(NOT_ALIKE, 0.0);
        }
        if edge.space_rounded {
            notes.add(SPACE_ROUNDED, 0.0);
        }
        if edge.uv_rounded {
            notes.add(UV_ROUNDED, 0.0);
        }
        match &edge.in_space {
            Some(piece) => {
                let form = piece.form()?;
                let curve = self.curves3.push(|out| text::curve(out, &form))?;
                integers(&mut text, [1, curve, 0]);
                numbers(&mut text, &[piece.range.start, piece.range.end]);
                text.push('\n');
            }
            None => notes.add(NO_CURVE, 0.0),
        }
        let face_of = |t: usize| {
            let trim = parts.trims.get(t)?;
            Some((parts.loops.get(trim.trim_loop)?.face, trim.edge_reversed))
        };
        // What each face has to do with it, in the order of first uses.
        let mut uses: Vec<(usize, Vec<usize>)> = Vec::new();
        let mut place = HashMap::new();
        for (i, (t, _)) in edge.in_uv.iter().enumerate() {
            if let Some((face, _)) = face_of(*t) {
                let at = *place.entry(face).or_insert(uses.len());
                match uses.get_mut(at) {
                    Some((_, all)) => all.push(i),
                    None => uses.push((face, vec![i])),
                }
            }
        }
        for (face, all) in uses {
            let Some((t, piece)) = all.first().and_then(|i| edge.in_uv.get(*i)) else {
                continue;
            };
            let Some((_, against)) = face_of(*t) else {
                continue;
            };
            let Some(form) = faces.get(face).and_then(Option::as_ref) else {
                continue;
            };
            if piece.bound > 0.0 {
                notes.add(UV_JOINED, piece.bound);
            }
            let curve = self.curve2(form, piece, notes)?;
            match all[..] {
                [_] => integers(&mut text, [2, curve]),
                [_, j] if face_of(edge.in_uv[j].0) == Some((face, !against)) => {
                    let second = self.curve2(form, &edge.in_uv[j].1, notes)?;
                    // Where u and v swap, what ran with the edge runs against it.
                    let pair = if against != form.chart.swapped {
                        [second, curve]
                    } else {
                        [curve, second]
                    };
                    integers(&mut text, [3, pair[0]]);
                    // Where the surface has a kink there, more would not be true.
                    let _ = write!(text, "{}C0 ", pair[1]);
                }
                _ => {
                    return Err(Problem(format!(
                        "face {face} uses it more than twice, or twice in one direction, which the format cannot say"
                    )));
                }
            }
            integers(&mut text, [form.surface, 0]);
            numbers(&mut text, &[piece.range.start, piece.range.end]);
            text.push('\n');
        }
        text.push_str("0\n");
        Ok(text)
    }

    fn degenerated(
        &mut self,
        face: &FaceForm,
        piece: &Piece<2, 3>,
        notes: &mut Notes,
    ) -> Result<String, Problem> {
        let curve = self.curve2(face, piece, notes)?;
        let mut text = String::from("Ed\n");
        number(&mut text, edges::CONFUSION);
        text.push_str("1 1 1\n");
        integers(&mut text, [2, curve, face.surface, 0]);
        numbers(&mut text, &[piece.range.start, piece.range.end]);
        text.push_str("\n0\n");
        Ok(text)
    }
}

fn sign(against: bool) -> char {
    if against { '-' } else { '+' }
}

/// The diagonal of the box of the vertices.
fn size(parts: &BrepParts) -> f64 {
    let points = parts.vertices.iter().map(|v| v.point.coords);
    let (low, high) = points.clone().zip(points).fold(
        (
            nalgebra::Vector3::repeat(f64::INFINITY),
            nalgebra::Vector3::repeat(f64::NEG_INFINITY),
        ),
        |(low, high), (p, q)| (low.inf(&p), high.sup(&q)),
    );
    let size = (high - low).norm();
    if size.is_finite() { size } else { 0.0 }
}

/// For each face the first that it hangs together with by edges.
fn connected(parts: &BrepParts) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..parts.faces.len()).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    let face = |t: &usize| {
        let l = parts.trims.get(*t)?.trim_loop;
        parts.loops.get(l).map(|l| l.face)
    };
    for edge in &parts.edges {
        let faces: Vec<usize> = edge.trims.iter().filter_map(face).collect();
        for pair in faces.windows(2) {
            let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
            parent[a.max(b)] = a.min(b);
        }
    }
    (0..parent.len()).map(|i| root(&mut parent, i)).collect()
}
