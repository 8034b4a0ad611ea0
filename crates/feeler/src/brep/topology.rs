//! The parts of a BREP and how they refer to each other.

use crate::numeric::Interval;
use crate::nurbs::{Curve, Curve2, Curve3, Surface};
use nalgebra::Point3;

/// A point where edges meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Vertex {
    /// Where it is, as stored: for display and health reports, not for truth.
    pub point: Point3<f64>,
    /// Edges that start or end here.
    pub edges: Vec<usize>,
    /// Tolerance as stored, in model units; `None` if unset.
    pub tolerance: Option<f64>,
}

/// A curve in space where trims meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Index into [`BrepParts::curves3`], if the file holds the curve.
    pub curve: Option<usize>,
    /// The part of that curve that is used.
    pub span: Interval,
    /// Whether the edge runs against the curve.
    pub reversed: bool,
    /// Start and end vertex.
    pub vertices: [usize; 2],
    /// The trims that use it: one on an open border, two inside a closed solid.
    pub trims: Vec<usize>,
    /// Tolerance as stored, in model units; `None` if unset.
    pub tolerance: Option<f64>,
}

/// What a trim is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrimKind {
    /// Not said by the file.
    Unknown,
    /// The only use of its edge.
    Boundary,
    /// Its edge is used by another loop too.
    Mated,
    /// Its edge is used twice by the same loop.
    Seam,
    /// Its image is a single point (a pole); it has no edge.
    Singular,
}

/// Whether a trim is an isoparametric line, and which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Iso {
    /// Not one.
    None,
    /// `u` constant inside the domain.
    U,
    /// `v` constant inside the domain.
    V,
    /// `u` at its minimum.
    West,
    /// `v` at its minimum.
    South,
    /// `u` at its maximum.
    East,
    /// `v` at its maximum.
    North,
}

impl Iso {
    /// What a curve in uv is on a surface with this domain; of straight curves alone.
    pub fn of(curve: &Curve2, [u, v]: [Interval; 2]) -> Self {
        let Curve::Line(line) = curve else {
            return Self::None;
        };
        let pick = |x: f64, d: Interval, low: Self, inside: Self, high: Self| {
            if x == d.start {
                low
            } else if x == d.end {
                high
            } else {
                inside
            }
        };
        if line.from.x == line.to.x {
            pick(line.from.x, u, Self::West, Self::U, Self::East)
        } else if line.from.y == line.to.y {
            pick(line.from.y, v, Self::South, Self::V, Self::North)
        } else {
            Self::None
        }
    }
}

/// One oriented 2D use of an edge in a face's uv space.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimCurve {
    /// Index into [`BrepParts::curves2`].
    pub curve: usize,
    /// The part of that curve that is used.
    pub span: Interval,
    /// Whether the trim runs against the curve.
    pub reversed: bool,
    /// The edge; `None` for a singular trim.
    pub edge: Option<usize>,
    /// Whether the trim runs against its edge.
    pub edge_reversed: bool,
    /// Start and end vertex, in the direction of the trim.
    pub vertices: [usize; 2],
    /// What it is.
    pub kind: TrimKind,
    /// Whether it is an isoparametric line, as the file says.
    pub iso: Iso,
    /// The loop it belongs to.
    pub trim_loop: usize,
}

/// What a loop bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopKind {
    /// Not said by the file.
    Unknown,
    /// The outer border; counter-clockwise in uv.
    Outer,
    /// A hole; clockwise in uv.
    Inner,
    /// Encloses no area.
    Slit,
}

/// Trims in order, head to tail.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimLoop {
    /// What the file says it bounds. Inclusion goes by parity and never reads this.
    pub kind: LoopKind,
    /// The trims, in order.
    pub trims: Vec<usize>,
    /// The face it belongs to.
    pub face: usize,
}

/// A surface, its trim loops and an orientation.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Index into [`BrepParts::surfaces`].
    pub surface: usize,
    /// The loops. `None`: the whole domain. An empty list: nothing.
    pub loops: Option<Vec<usize>>,
    /// Whether the face's normal is against the surface's.
    pub reversed: bool,
}

/// What a [`Brep`] is made of, before it is checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BrepParts {
    /// Curves in uv.
    pub curves2: Vec<Curve2>,
    /// Curves in space.
    pub curves3: Vec<Curve3>,
    /// Surfaces.
    pub surfaces: Vec<Surface>,
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Edges.
    pub edges: Vec<Edge>,
    /// Trims.
    pub trims: Vec<TrimCurve>,
    /// Loops.
    pub loops: Vec<TrimLoop>,
    /// Faces.
    pub faces: Vec<Face>,
}

impl BrepParts {
    /// Gives back what its lists have room for, as none grows any more.
    fn shrink(&mut self) {
        self.curves2.shrink_to_fit();
        self.curves3.shrink_to_fit();
        self.surfaces.shrink_to_fit();
        self.vertices.shrink_to_fit();
        self.edges.shrink_to_fit();
        self.trims.shrink_to_fit();
        self.loops.shrink_to_fit();
        self.faces.shrink_to_fit();
        let of_vertices = self.vertices.iter_mut().map(|v| &mut v.edges);
        let of_edges = self.edges.iter_mut().map(|e| &mut e.trims);
        let of_loops = self.loops.iter_mut().map(|l| &mut l.trims);
        let of_faces = self.faces.iter_mut().filter_map(|f| f.loops.as_mut());
        let lists = of_vertices.chain(of_edges).chain(of_loops).chain(of_faces);
        lists.for_each(Vec::shrink_to_fit);
    }
}

/// Why [`Brep::new`] refuses its parts.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BrepError {
    /// An index points past the end of a list.
    #[error("{owner} {index} refers to {what} {target}, but there are {count}")]
    Index {
        /// What holds the index (`"face"`, ...).
        owner: &'static str,
        /// Which one.
        index: usize,
        /// What it refers to.
        what: &'static str,
        /// The bad index.
        target: usize,
        /// How many there are.
        count: usize,
    },
    /// A number is NaN or infinite.
    #[error("{owner} {index}: {what} is not finite")]
    NotFinite {
        /// What holds the number.
        owner: &'static str,
        /// Which one.
        index: usize,
        /// Which number.
        what: &'static str,
    },
    /// A number too large, or a weight too far from 1, for the kernel's bounds to hold.
    #[error(
        "{owner} {index}: a coordinate is above 1e60 or a weight outside 1e-60..1e60 (rescale the model)"
    )]
    Range {
        /// What holds the number.
        owner: &'static str,
        /// Which one.
        index: usize,
    },
    /// A span that is not inside its curve's domain.
    #[error("{owner} {index} uses [{start:?}, {end:?}] of a curve with domain [{from:?}, {to:?}]")]
    Span {
        /// What holds the span.
        owner: &'static str,
        /// Which one.
        index: usize,
        /// Start of the span.
        start: f64,
        /// End of the span.
        end: f64,
        /// Start of the domain.
        from: f64,
        /// End of the domain.
        to: f64,
    },
}

/// A boundary representation whose indices are all valid and whose numbers are all
/// finite. See the [module](super).
#[derive(Clone, Debug, PartialEq)]
pub struct Brep {
    parts: BrepParts,
}

impl Brep {
    /// Checks the structure and keeps the parts. O(size).
    pub fn new(mut parts: BrepParts) -> Result<Self, BrepError> {
        check(&parts)?;
        parts.shrink();
        Ok(Self { parts })
    }

    /// The same BREP, as exactly, of weights that are easier to compute with, as far as that takes no more than powers of two and all stays in range. The first weight of
    /// each NURBS surface and uv curve is between 1 and 2: what is made of weights of ordinary sizes neither overflows nor underflows. Those of a uv curve that is used as a whole
    /// [rise no more than they fall](Curve::with_even_weights): a step of its parameter is about as long anywhere. With what the curves were whose parameters changed, by
    /// their indices. O(size).
    pub(crate) fn with_handy_weights(mut self) -> (Self, Box<[(usize, Curve2)]>) {
        for surface in &mut self.parts.surfaces {
            if let Some(scaled) = surface.with_scaled_weights().filter(surface_in_range) {
                *surface = scaled;
            }
        }
        let mut is_whole = vec![true; self.parts.curves2.len()];
        for trim in &self.parts.trims {
            is_whole[trim.curve] &= trim.span == self.parts.curves2[trim.curve].domain();
        }
        let mut given = Vec::new();
        for (index, curve) in self.parts.curves2.iter_mut().enumerate() {
            if let Some(scaled) = curve.with_scaled_weights().filter(curve_in_range) {
                *curve = scaled;
            }
            if !is_whole[index] {
                continue;
            }
            if let Some(even) = curve.with_even_weights().filter(curve_in_range) {
                given.push((index, std::mem::replace(curve, even)));
            }
        }
        (self, given.into())
    }

    /// The parts.
    pub fn parts(&self) -> &BrepParts {
        &self.parts
    }

    /// The faces.
    pub fn faces(&self) -> &[Face] {
        &self.parts.faces
    }

    /// The surface of face `face`.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn surface(&self, face: usize) -> &Surface {
        &self.parts.surfaces[self.parts.faces[face].surface]
    }

    /// A solid is closed when every non-singular edge is used exactly twice (and there is an edge
    /// or a face whose own surface closes it). Flags in files never decide this.
    pub fn is_closed(&self) -> bool {
        !self.parts.faces.is_empty()
            && self.parts.faces.iter().all(|f| f.loops.is_some())
            && self.parts.edges.iter().all(|e| e.trims.len() == 2)
    }
}

fn index(
    owner: &'static str,
    index: usize,
    what: &'static str,
    targets: &[usize],
    count: usize,
) -> Result<(), BrepError> {
    match targets.iter().find(|t| **t >= count) {
        Some(&target) => Err(BrepError::Index {
            owner,
            index,
            what,
            target,
            count,
        }),
        None => Ok(()),
    }
}

fn span(owner: &'static str, index: usize, s: Interval, domain: Interval) -> Result<(), BrepError> {
    let inside = domain.start <= s.start && s.start < s.end && s.end <= domain.end;
    if inside {
        Ok(())
    } else {
        Err(BrepError::Span {
            owner,
            index,
            start: s.start,
            end: s.end,
            from: domain.start,
            to: domain.end,
        })
    }
}

/// No coordinate of a BREP or a probe may be larger, and no weight larger or below its inverse: then
/// no product of the search overflows (the largest are squares of weighted coordinates, 1e240; fourth powers in recognition may, which sees it),
/// and what underflows is counted. (The image of a trim has weights that are products of those of surface and trim, as many as their degrees: next to 1 they do no harm, which
/// is where a [prepared](crate::prepare::PreparedBrep::brep) BREP has the first of each that allows it.)
pub const LARGEST_COORDINATE: f64 = 1e60;

/// Whether homogeneous points, and what they stand for, are in range.
fn points_in_range<const H: usize>(points: &[nalgebra::SVector<f64, H>]) -> bool {
    points.iter().all(|p| {
        let w = p[H - 1];
        let usable = (1.0 / LARGEST_COORDINATE..=LARGEST_COORDINATE).contains(&w);
        usable && (0..H - 1).all(|c| p[c].abs() <= LARGEST_COORDINATE * w.min(1.0))
    })
}

fn curve_in_range<const D: usize, const H: usize>(curve: &Curve<D, H>) -> bool {
    let small = |x: f64| x.abs() <= LARGEST_COORDINATE;
    let point = |p: &nalgebra::Point<f64, D>| p.iter().all(|x| small(*x));
    match curve {
        Curve::Line(c) => point(&c.from) && point(&c.to),
        Curve::Arc(c) => point(&c.center) && small(c.radius),
        Curve::Polyline(c) => c.points().iter().all(point),
        Curve::Nurbs(c) => points_in_range(c.control_points()),
        // Segments are never poly-curves themselves: this goes one level deep.
        Curve::Poly(c) => c.segments().iter().all(curve_in_range),
    }
}

fn surface_in_range(surface: &Surface) -> bool {
    match surface {
        Surface::Plane(s) => {
            let reach = |k: usize| s.extents[k].start.abs().max(s.extents[k].end.abs());
            (0..3).all(|c| {
                let x = s.origin[c].abs() + s.x[c].abs() * reach(0) + s.y[c].abs() * reach(1);
                x <= LARGEST_COORDINATE
            })
        }
        Surface::Revolution(s) => {
            curve_in_range(&s.profile) && s.origin.iter().all(|x| x.abs() <= LARGEST_COORDINATE)
        }
        Surface::Sum(s) => curve_in_range(&s.first) && curve_in_range(&s.second),
        Surface::Nurbs(s) => points_in_range(s.control_net()),
    }
}

fn check_range(p: &BrepParts) -> Result<(), BrepError> {
    let range = |owner, index| Err(BrepError::Range { owner, index });
    if let Some(i) = p.surfaces.iter().position(|s| !surface_in_range(s)) {
        return range("surface", i);
    }
    if let Some(i) = p.curves2.iter().position(|c| !curve_in_range(c)) {
        return range("uv curve", i);
    }
    if let Some(i) = p.curves3.iter().position(|c| !curve_in_range(c)) {
        return range("space curve", i);
    }
    Ok(())
}

fn check(p: &BrepParts) -> Result<(), BrepError> {
    check_range(p)?;
    for (i, v) in p.vertices.iter().enumerate() {
        if v.point.iter().any(|x| !x.is_finite()) {
            return Err(BrepError::NotFinite {
                owner: "vertex",
                index: i,
                what: "the point",
            });
        }
        index("vertex", i, "edge", &v.edges, p.edges.len())?;
    }
    for (i, e) in p.edges.iter().enumerate() {
        if let Some(c) = e.curve {
            index("edge", i, "space curve", &[c], p.curves3.len())?;
            span("edge", i, e.span, p.curves3[c].domain())?;
        }
        index("edge", i, "vertex", &e.vertices, p.vertices.len())?;
        index("edge", i, "trim", &e.trims, p.trims.len())?;
    }
    for (i, t) in p.trims.iter().enumerate() {
        index("trim", i, "uv curve", &[t.curve], p.curves2.len())?;
        span("trim", i, t.span, p.curves2[t.curve].domain())?;
        if let Some(e) = t.edge {
            index("trim", i, "edge", &[e], p.edges.len())?;
        }
        index("trim", i, "vertex", &t.vertices, p.vertices.len())?;
        index("trim", i, "loop", &[t.trim_loop], p.loops.len())?;
    }
    for (i, l) in p.loops.iter().enumerate() {
        index("loop", i, "trim", &l.trims, p.trims.len())?;
        index("loop", i, "face", &[l.face], p.faces.len())?;
    }
    for (i, f) in p.faces.iter().enumerate() {
        index("face", i, "surface", &[f.surface], p.surfaces.len())?;
        if let Some(loops) = &f.loops {
            index("face", i, "loop", loops, p.loops.len())?;
        }
    }
    Ok(())
}
