//! Topology of BREPs from before format 3.
//!
//! They hold faces, loops and trims, a curve in uv for each trim and one in space for each edge, and say which trims share an
//! edge. Vertices, the kinds of trims and what lies on a side of the domain are not stored: they follow.

use crate::sheets::kinds;
use feeler::brep::{BrepParts, Edge, Face, Iso, LoopKind, TrimCurve, TrimKind, TrimLoop, Vertex};
use feeler::numeric::Interval;
use feeler::nurbs::{Curve, Curve2, Curve3, Line, Surface};
use nalgebra::Point3;

pub(super) struct OldTrim {
    pub(super) curve: Curve2,
    pub(super) edge: Option<usize>,
    /// Whether it runs against its edge.
    pub(super) reversed: bool,
    /// The tolerance in space that is stored with it.
    pub(super) tolerance: Option<f64>,
}

pub(super) struct OldLoop {
    /// As stored: 0 a border, 1 a hole, -1 a slit.
    pub(super) kind: i32,
    pub(super) trims: Vec<usize>,
}

pub(super) struct OldFace {
    pub(super) surface: Surface,
    pub(super) reversed: bool,
    pub(super) loops: Vec<OldLoop>,
}

/// A BREP as old files have it. All indices are those of its lists.
#[derive(Default)]
pub(super) struct OldBrep {
    /// One an edge.
    pub(super) curves3: Vec<Curve3>,
    pub(super) trims: Vec<OldTrim>,
    pub(super) faces: Vec<OldFace>,
}

/// Groups of things that are the same: each points to another of its group, or to itself.
struct Groups(Vec<usize>);

impl Groups {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn first(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            // Halves the way for the next time.
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b)] = a.min(b);
    }
}

fn loop_kind(stored: i32) -> LoopKind {
    match stored {
        0 => LoopKind::Outer,
        1 => LoopKind::Inner,
        -1 => LoopKind::Slit,
        _ => LoopKind::Unknown,
    }
}

/// What a curve in uv is on a surface with this domain. Old files store straight ones as splines.
fn iso(curve: &Curve2, domain: [Interval; 2]) -> Iso {
    if let Curve::Nurbs(n) = curve {
        let points = Vec::from_iter(n.control_points().iter().map(|p| p.xy() / p.z));
        if let [from, .., to] = points[..]
            && (0..2).any(|c| points.iter().all(|p| p[c] == from[c]))
        {
            let line = Line {
                from: from.into(),
                to: to.into(),
                domain: curve.domain(),
            };
            return Iso::of(&Curve::Line(line), domain);
        }
    }
    Iso::of(curve, domain)
}

/// The parts of the BREP.
///
/// Where one trim ends, the next of its loop starts: the ends of edges there are one vertex, at their mean. So are the ends of an
/// edge whose curve is closed. A trim without an edge is a point in space, a pole.
pub(super) fn parts(old: OldBrep) -> BrepParts {
    let OldBrep {
        curves3,
        trims,
        faces,
    } = old;
    let ends = Vec::from_iter(curves3.iter().map(|c| {
        let domain = c.domain();
        [c.point(domain.start), c.point(domain.end)]
    }));
    // Nodes: two an edge, then one a trim (used of those without an edge).
    let node = |t: usize, end: usize| match trims.get(t).and_then(|t| Some((t.edge?, t.reversed))) {
        Some((edge, reversed)) => 2 * edge + if reversed { 1 - end } else { end },
        None => 2 * ends.len() + t,
    };
    let mut groups = Groups::new(2 * ends.len() + trims.len());
    for (e, [start, end]) in ends.iter().enumerate() {
        if start == end {
            groups.join(2 * e, 2 * e + 1);
        }
    }
    let loops = || faces.iter().flat_map(|f| &f.loops);
    for l in loops() {
        let next = l.trims.iter().cycle().skip(1);
        for (&a, &b) in l.trims.iter().zip(next) {
            groups.join(node(a, 1), node(b, 0));
        }
    }
    // Numbered as the loops meet them, then those of edges that no trim uses.
    let mut numbers = vec![None; 2 * ends.len() + trims.len()];
    let mut count = 0;
    let starts = loops().flat_map(|l| l.trims.iter().flat_map(|&t| [node(t, 0), node(t, 1)]));
    for n in starts.chain(0..2 * ends.len()) {
        let first = groups.first(n);
        if numbers[first].is_none() {
            numbers[first] = Some(count);
            count += 1;
        }
    }
    let mut vertex = |n: usize| numbers[groups.first(n)].unwrap_or(0);

    let mut points = vec![(Point3::origin().coords, 0.0); count];
    let mut edges_at: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut parts = BrepParts::default();
    for (e, (curve, end)) in curves3.into_iter().zip(&ends).enumerate() {
        let vertices = [vertex(2 * e), vertex(2 * e + 1)];
        for (v, p) in vertices.into_iter().zip(end) {
            points[v].0 += p.coords;
            points[v].1 += 1.0;
            edges_at[v].push(e);
        }
        parts.edges.push(Edge {
            curve: Some(e),
            span: curve.domain(),
            reversed: false,
            vertices,
            trims: Vec::new(),
            tolerance: None,
        });
        parts.curves3.push(curve);
    }
    // A pole that no edge ends at is where its surface has it.
    for f in &faces {
        for &t in f.loops.iter().flat_map(|l| &l.trims) {
            let v = vertex(node(t, 0));
            if points[v].1 == 0.0
                && let Some(trim) = trims.get(t)
            {
                let [u, w] = trim.curve.point(trim.curve.domain().start).into();
                points[v] = (f.surface.point(u, w).coords, 1.0);
            }
        }
    }
    for ((sum, n), edges) in points.into_iter().zip(edges_at) {
        parts.vertices.push(Vertex {
            point: Point3::from(if n > 1.0 { sum / n } else { sum }),
            edges,
            tolerance: Some(0.0),
        });
    }
    // As far as the ends of its edges are from it.
    for (edge, ends) in parts.edges.iter().zip(&ends) {
        for (v, end) in edge.vertices.iter().zip(ends) {
            if let Some(v) = parts.vertices.get_mut(*v) {
                let off = (v.point - end).norm();
                v.tolerance = v.tolerance.map(|t| t.max(off));
            }
        }
    }
    let corners =
        Vec::from_iter((0..trims.len()).map(|t| [vertex(node(t, 0)), vertex(node(t, 1))]));
    for (t, (trim, vertices)) in trims.into_iter().zip(corners).enumerate() {
        if let Some(edge) = trim.edge.and_then(|e| parts.edges.get_mut(e)) {
            edge.trims.push(t);
            edge.tolerance = match (edge.tolerance, trim.tolerance) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            };
        }
        parts.trims.push(TrimCurve {
            curve: t,
            span: trim.curve.domain(),
            reversed: false,
            edge: trim.edge,
            edge_reversed: trim.reversed,
            vertices,
            kind: TrimKind::Unknown,
            iso: Iso::None,
            trim_loop: 0,
        });
        parts.curves2.push(trim.curve);
    }
    for (f, face) in faces.into_iter().enumerate() {
        let mut loops = Vec::with_capacity(face.loops.len());
        for l in face.loops {
            loops.push(parts.loops.len());
            for &t in &l.trims {
                if let (Some(trim), Some(curve)) = (parts.trims.get_mut(t), parts.curves2.get(t)) {
                    trim.trim_loop = parts.loops.len();
                    trim.iso = iso(curve, face.surface.domain());
                }
            }
            parts.loops.push(TrimLoop {
                kind: loop_kind(l.kind),
                trims: l.trims,
                face: f,
            });
        }
        parts.surfaces.push(face.surface);
        parts.faces.push(Face {
            surface: f,
            loops: Some(loops),
            reversed: face.reversed,
        });
    }
    kinds(&mut parts);
    parts
}
