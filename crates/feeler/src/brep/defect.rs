//! What can be wrong with a BREP.

use super::LoopKind;
use std::fmt;

/// How much a defect matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// A fact worth knowing: an open border, a deviation within the file's own tolerance.
    Note,
    /// The model is not quite what it seems; answers are about it as it is.
    Warning,
    /// The model contradicts itself or bounds no solid.
    Error,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

/// A part of a BREP, by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// A face.
    Face(usize),
    /// A loop.
    Loop(usize),
    /// A trim.
    Trim(usize),
    /// An edge.
    Edge(usize),
    /// A vertex.
    Vertex(usize),
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Face(i) => write!(f, "face {i}"),
            Self::Loop(i) => write!(f, "loop {i}"),
            Self::Trim(i) => write!(f, "trim {i}"),
            Self::Edge(i) => write!(f, "edge {i}"),
            Self::Vertex(i) => write!(f, "vertex {i}"),
        }
    }
}

/// Something wrong, or worth knowing, in a BREP: where it is and how large. Sizes are in
/// model units, or in units of the face's parameters where it says uv. Distances
/// called "about" are the largest of samples: estimates, not bounds. Points outside a surface's domain
/// are moved to its border before they are measured in space.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Defect {
    /// Consecutive trims of a loop do not meet; inclusion joins them by a straight segment in uv.
    Gap {
        /// The face.
        face: usize,
        /// The loop.
        trim_loop: usize,
        /// The trims with the largest gap, in order.
        trims: [usize; 2],
        /// How many gaps the loop has.
        count: usize,
        /// The largest gap in uv.
        uv: f64,
        /// The same in space.
        space: f64,
        /// The tolerance stored for the vertex between them, if any.
        tolerance: Option<f64>,
    },
    /// A loop without trims.
    EmptyLoop {
        /// The face.
        face: usize,
        /// The loop.
        trim_loop: usize,
    },
    /// An outer loop that is not counter-clockwise, or an inner one that is not clockwise.
    Orientation {
        /// The face.
        face: usize,
        /// The loop.
        trim_loop: usize,
        /// What the file says it is.
        kind: LoopKind,
        /// Its signed area in uv: positive is counter-clockwise.
        area: f64,
    },
    /// A face whose loops are not exactly one outer loop and inner ones.
    OuterLoops {
        /// The face.
        face: usize,
        /// How many outer loops it has.
        count: usize,
    },
    /// A trim leaves the surface's domain; the region is cut there.
    OutsideDomain {
        /// The face.
        face: usize,
        /// The trim.
        trim: usize,
        /// By how much at the worst sample, in uv.
        uv: f64,
    },
    /// A trim's image is off its edge's curve in space.
    EdgeOffSurface {
        /// The face.
        face: usize,
        /// The trim.
        trim: usize,
        /// The edge.
        edge: usize,
        /// About how far.
        distance: f64,
        /// The tolerance stored for the edge, if any.
        tolerance: Option<f64>,
    },
    /// A vertex is off the end of its edge's curve.
    VertexOffEdge {
        /// The vertex.
        vertex: usize,
        /// The edge.
        edge: usize,
        /// How far.
        distance: f64,
        /// The tolerance stored for the vertex, if any.
        tolerance: Option<f64>,
    },
    /// A vertex is off the image of the end of a trim.
    VertexOffFace {
        /// The vertex.
        vertex: usize,
        /// The face.
        face: usize,
        /// The trim.
        trim: usize,
        /// How far.
        distance: f64,
        /// The tolerance stored for the vertex, if any.
        tolerance: Option<f64>,
    },
    /// The stored axes of a plane, arc or revolution are not unit vectors, not orthogonal or
    /// not right-handed. (What that means for the geometry is said at each type.)
    Frame {
        /// What it belongs to.
        owner: Part,
        /// Which form.
        form: &'static str,
        /// The largest deviation: of a length from 1, of a cosine from 0.
        off: f64,
    },
    /// An edge used more than twice.
    NonManifoldEdge {
        /// The edge.
        edge: usize,
        /// How often it is used.
        uses: usize,
    },
    /// An edge used once: the border of an open sheet, or of an unjoined face.
    BoundaryEdge {
        /// The edge.
        edge: usize,
    },
    /// An edge that no trim uses.
    UnusedEdge {
        /// The edge.
        edge: usize,
    },
    /// An edge without a curve in space.
    NoCurve {
        /// The edge.
        edge: usize,
    },
    /// A singular trim (or one without an edge) whose image is no point.
    SingularTrim {
        /// The face.
        face: usize,
        /// The trim.
        trim: usize,
        /// About how far its image reaches.
        size: f64,
    },
    /// One part lists another that does not refer back to it, or lists it twice.
    BackReference {
        /// The part that refers.
        from: Part,
        /// The part it refers to.
        to: Part,
    },
}

/// Whether a deviation is covered by the file's own tolerance.
fn by_tolerance(size: f64, tolerance: Option<f64>) -> Severity {
    match tolerance {
        Some(t) if size <= t => Severity::Note,
        _ => Severity::Warning,
    }
}

impl Defect {
    /// Whether it is a deviation that the file's own tolerance covers.
    pub fn is_within_tolerance(&self) -> bool {
        matches!(
            self,
            Self::Gap { .. }
                | Self::EdgeOffSurface { .. }
                | Self::VertexOffEdge { .. }
                | Self::VertexOffFace { .. }
        ) && self.severity() == Severity::Note
    }

    /// How much it matters.
    pub fn severity(&self) -> Severity {
        match self {
            Self::Gap {
                space, tolerance, ..
            } => by_tolerance(*space, *tolerance),
            Self::EdgeOffSurface {
                distance,
                tolerance,
                ..
            }
            | Self::VertexOffEdge {
                distance,
                tolerance,
                ..
            }
            | Self::VertexOffFace {
                distance,
                tolerance,
                ..
            } => by_tolerance(*distance, *tolerance),
            Self::BoundaryEdge { .. } | Self::NoCurve { .. } => Severity::Note,
            Self::EmptyLoop { .. }
            | Self::Orientation { .. }
            | Self::OuterLoops { .. }
            | Self::OutsideDomain { .. }
            | Self::Frame { .. }
            | Self::UnusedEdge { .. }
            | Self::SingularTrim { .. } => Severity::Warning,
            Self::NonManifoldEdge { .. } | Self::BackReference { .. } => Severity::Error,
        }
    }
}

/// "(the file allows 0.01)", or nothing.
struct Allowed(Option<f64>);

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(t) => write!(f, " (the file allows {t:?})"),
            None => Ok(()),
        }
    }
}

/// One plain sentence without a full stop.
impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gap {
                face,
                trim_loop,
                trims: [a, b],
                count,
                uv,
                space,
                tolerance,
            } => {
                let more = match count {
                    1 => String::new(),
                    n => format!(", the largest of {n} gaps"),
                };
                write!(
                    f,
                    "face {face}, loop {trim_loop}: trims {a} and {b} do not meet, by {uv:.3e} in uv and {space:.3e} model units{}{more}",
                    Allowed(*tolerance)
                )
            }
            Self::EmptyLoop { face, trim_loop } => {
                write!(f, "face {face}, loop {trim_loop}: no trims")
            }
            Self::Orientation {
                face,
                trim_loop,
                kind,
                area,
            } => {
                let (kind, should) = match kind {
                    LoopKind::Inner => ("inner", "clockwise"),
                    _ => ("outer", "counter-clockwise"),
                };
                write!(
                    f,
                    "face {face}, loop {trim_loop}: an {kind} loop should run {should}, but its signed area in uv is {area:.3e}"
                )
            }
            Self::OuterLoops { face, count } => {
                write!(f, "face {face}: {count} outer loops instead of one")
            }
            Self::OutsideDomain { face, trim, uv } => write!(
                f,
                "face {face}, trim {trim}: leaves the surface's domain by about {uv:.3e} in uv"
            ),
            Self::EdgeOffSurface {
                face,
                trim,
                edge,
                distance,
                tolerance,
            } => write!(
                f,
                "face {face}, trim {trim}: about {distance:.3e} model units off the curve of edge {edge}{}",
                Allowed(*tolerance)
            ),
            Self::VertexOffEdge {
                vertex,
                edge,
                distance,
                tolerance,
            } => write!(
                f,
                "vertex {vertex}: {distance:.3e} model units off the end of edge {edge}{}",
                Allowed(*tolerance)
            ),
            Self::VertexOffFace {
                vertex,
                face,
                trim,
                distance,
                tolerance,
            } => write!(
                f,
                "vertex {vertex}: {distance:.3e} model units off the end of trim {trim} on face {face}{}",
                Allowed(*tolerance)
            ),
            Self::Frame { owner, form, off } => {
                write!(
                    f,
                    "{owner}: the {form}'s stored axes are off an orthonormal frame by {off:.3e}"
                )
            }
            Self::NonManifoldEdge { edge, uses } => {
                write!(f, "edge {edge}: used {uses} times, so it bounds no solid")
            }
            Self::BoundaryEdge { edge } => {
                write!(f, "edge {edge}: used once, so the model is open there")
            }
            Self::UnusedEdge { edge } => write!(f, "edge {edge}: no trim uses it"),
            Self::NoCurve { edge } => write!(f, "edge {edge}: no curve in space"),
            Self::SingularTrim { face, trim, size } => write!(
                f,
                "face {face}, trim {trim}: has no edge, but its image is no point: it reaches about {size:.3e} model units"
            ),
            Self::BackReference { from, to } => {
                write!(
                    f,
                    "{from} lists {to} twice, or {to} does not refer back to it"
                )
            }
        }
    }
}
