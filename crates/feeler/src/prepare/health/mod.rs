//! What whoever imports a BREP must know of it, with proven bounds.
//!
//! # Definitions
//! - *Gap*: where a trim does not end where the next starts. Its size in uv is the distance of the two ends, in space that
//!   of their images.
//! - *Crack* of an edge: the largest Frechet distance of two of its trims' images
//!   ([`PreparedBrep::crack_width`]).
//! - *Offset* of a trim: the Frechet distance of its image and its edge's curve as stored in space.
//! - *Turn* of a loop: the sign of its area in uv.
//! - *Direction* of an edge: whether the material is on one side of both faces there. A trim of a rightly turned loop has its face on its
//!   left as seen against the surface's normal, or on its right where the face is reversed; so two uses fit
//!   where they run along the edge in opposite directions and neither or both of the faces are reversed.
//! - *Mean width* of a face: twice its area over its border's length. A strip has nearly its width.
//!
//! # Guarantee
//! Sizes are enclosures or bounds from above, never samples: what is said to be small is. What is said to be a sliver is
//! one, too; but not all slivers are named, where the surface runs at an uneven pace. Sampled estimates are
//! left to [`Brep::defects`](crate::brep::Brep::defects), of which [`Health::defects`] keeps what has no bound here.
//!
//! # Cost
//! All that queries would make of all faces, in f64: some 10 us a patch, some 100 us to milliseconds an edge.

mod edge;
mod face;

use super::PreparedBrep;
use crate::brep::{Brep, Defect, LoopKind};
use crate::numeric::Enclosure;
use crate::trim::{MeetingKind, Meetings};
use std::fmt;

/// Lengths below this share of the model's size are as good as f64 makes them, and not worth a word: as for
/// [`defects`](crate::brep::Brep::defects), 13 bits above the unit roundoff.
const ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;
/// An edge is tiny where it reaches no farther than this share of the model's size (a micrometre on a metre).
const TINY: f64 = 1.0 / (1u64 << 20) as f64;
/// A face is a sliver where its border is longer than this many times its mean width.
const SLIVER: f64 = 2000.0;

/// Where two trims of a loop, or two segments of one poly-curve, do not meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The trim before it.
    pub after: usize,
    /// How wide, in uv.
    pub uv: Enclosure,
    /// How wide in space, in model units.
    pub space: Enclosure,
}

/// Which way a loop runs around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Its area in uv is positive.
    CounterClockwise,
    /// Its area is negative.
    Clockwise,
    /// The sign of its area could not be settled.
    Undecided,
}

impl Turn {
    /// `counter_clockwise`, `clockwise`, `undecided`.
    pub fn name(self) -> &'static str {
        match self {
            Self::CounterClockwise => "counter_clockwise",
            Self::Clockwise => "clockwise",
            Self::Undecided => "undecided",
        }
    }
}

/// One loop.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopHealth {
    /// As the BREP numbers it.
    pub trim_loop: usize,
    /// What the file says it is.
    pub kind: LoopKind,
    /// Which way it runs.
    pub turn: Turn,
    /// Its signed area in uv.
    pub area: Enclosure,
    /// Its gaps, in order.
    pub gaps: Vec<Gap>,
}

impl LoopHealth {
    /// Proven: an outer loop runs clockwise, or an inner one counter-clockwise.
    pub fn is_turned_wrong(&self) -> bool {
        matches!(
            (self.kind, self.turn),
            (LoopKind::Outer, Turn::Clockwise) | (LoopKind::Inner, Turn::CounterClockwise)
        )
    }

    /// The widest gap in space.
    pub fn widest_gap(&self) -> Option<&Gap> {
        let by_width = |a: &&Gap, b: &&Gap| a.space.hi.total_cmp(&b.space.hi);
        self.gaps.iter().max_by(by_width)
    }
}

/// One face.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceHealth {
    /// Its index.
    pub face: usize,
    /// Its loops; none where it is its surface's whole domain.
    pub loops: Vec<LoopHealth>,
    /// Where loops cross or touch.
    pub meetings: Meetings,
    /// A bound above its area in space; infinite where there is none, or where loops may cross.
    pub area: f64,
    /// A bound below the length of its border in space.
    pub border: f64,
}

impl FaceHealth {
    /// A bound above its mean width, in model units.
    pub fn mean_width(&self) -> f64 {
        if self.border > 0.0 {
            2.0 * self.area / self.border
        } else {
            f64::INFINITY
        }
    }

    /// Proven: its border is more than 2000 times as long as it is wide in the mean.
    pub fn is_sliver(&self) -> bool {
        SLIVER * self.mean_width() < self.border
    }

    /// Meetings other than those that come from a gap.
    pub fn own_meetings(&self) -> impl Iterator<Item = &crate::trim::Meeting> {
        self.meetings.found.iter().filter(|m| !m.at_gap)
    }
}

/// How far a trim's image is from its edge's curve in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// The trim.
    pub trim: usize,
    /// From above: their Frechet distance, in the better direction. Infinite where there is no bound.
    pub at_most: f64,
    /// What samples show where it is beyond rounding: an estimate.
    pub about: Option<f64>,
}

/// Whether the faces at an edge fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Material is on one side of both.
    Fits,
    /// It changes sides there: one of the two faces is inside out.
    Against,
    /// No two faces meet there, or more.
    NotTwo,
    /// A loop there is turned wrong or undecided, so that the faces' sides are not known.
    Unknown,
}

impl Direction {
    /// `fits`, `against`, `not_two`, `unknown`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fits => "fits",
            Self::Against => "against",
            Self::NotTwo => "not_two",
            Self::Unknown => "unknown",
        }
    }
}

/// One edge.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeHealth {
    /// Its index.
    pub edge: usize,
    /// The faces that use it, one for each use.
    pub faces: Vec<usize>,
    /// The width of its crack; zero for a single use. Its upper end is infinite where there is no bound.
    pub crack: Enclosure,
    /// Of each trim, how far it is from the edge's curve; empty where the file holds no curve.
    pub offsets: Vec<Offset>,
    /// A bound above how far the edge reaches: the diagonal of a box around its images.
    pub reach: f64,
    /// The tolerance stored for it, if any.
    pub tolerance: Option<f64>,
    /// Whether its faces fit.
    pub direction: Direction,
    /// Proven: it reaches no farther than 2^-20 of the model's size, or than its stored tolerance.
    pub is_tiny: bool,
}

impl EdgeHealth {
    /// Used once: the border of an open sheet.
    pub fn is_naked(&self) -> bool {
        self.faces.len() == 1
    }

    /// Used more than twice.
    pub fn is_non_manifold(&self) -> bool {
        self.faces.len() > 2
    }

    /// The largest bound of its trims' offsets, and what samples show of it.
    pub fn worst_offset(&self) -> Option<&Offset> {
        let by_bound = |a: &&Offset, b: &&Offset| a.at_most.total_cmp(&b.at_most);
        self.offsets.iter().max_by(by_bound)
    }
}

/// An answer that the BREP's state leaves undefined or undecided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Undefined {
    /// It is not closed: no point is in material, and no ball's separation is below minus its radius.
    Material,
    /// Points and lines that come as near to an edge as its crack is wide, at most this, have no side, and their parity none.
    NearCracks(f64),
    /// For so many edges the crack has no bound.
    UnknownCracks(usize),
    /// So many faces have loops that cross, overlap or touch: the region is that of odd parity, which may not be what was meant.
    CrossedLoops(usize),
    /// So many faces have loops for which that could not be told.
    UndecidedLoops(usize),
    /// So many loops have gaps beyond rounding: points of uv in their boxes are marked `in_gap`.
    InGaps(usize),
    /// Faces that are inside out beside others: signs go by parity and stay right, but the faces' own normals do not
    /// tell what is outside; so many edges show it.
    Normals(usize),
}

impl Undefined {
    /// A word for machines: `material`, `near_cracks`, `unknown_cracks`, `crossed_loops`, `undecided_loops`, `in_gaps`, `normals`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Material => "material",
            Self::NearCracks(_) => "near_cracks",
            Self::UnknownCracks(_) => "unknown_cracks",
            Self::CrossedLoops(_) => "crossed_loops",
            Self::UndecidedLoops(_) => "undecided_loops",
            Self::InGaps(_) => "in_gaps",
            Self::Normals(_) => "normals",
        }
    }
}

/// One plain sentence without a full stop.
impl fmt::Display for Undefined {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let faces = |n: usize| {
            if n == 1 {
                "1 face has".into()
            } else {
                format!("{n} faces have")
            }
        };
        match *self {
            Self::Material => f.write_str(
                "not closed: no point counts as inside, and no ball is deeper than its radius",
            ),
            Self::NearCracks(width) => write!(
                f,
                "up to {width:.3e} model units from cracked edges, sides of points and hits of lines are undecided"
            ),
            Self::UnknownCracks(n) => write!(
                f,
                "{n} edges have cracks without a bound: sides of points may be undecided anywhere"
            ),
            Self::CrossedLoops(n) => write!(
                f,
                "{} loops that meet: the region is what has odd parity, which may not be what was meant",
                faces(n)
            ),
            Self::UndecidedLoops(n) => write!(
                f,
                "{} loops of which it is undecided whether they meet: the region is what has odd parity",
                faces(n)
            ),
            Self::InGaps(n) => write!(
                f,
                "{n} loops have gaps: points of uv within them are answered as if joined straight, and marked"
            ),
            Self::Normals(n) => write!(
                f,
                "at {n} edges one face is inside out: answers go by parity, but normals of faces do not tell outside"
            ),
        }
    }
}

/// The health of a BREP.
#[derive(Clone, Debug, PartialEq)]
pub struct Health {
    /// Every edge is used twice (see [`Brep::is_closed`](crate::brep::Brep::is_closed)).
    pub is_closed: bool,
    /// The model's size, in model units.
    pub size: f64,
    /// Lengths up to this are rounding, in model units.
    pub rounding: f64,
    /// A face each.
    pub faces: Vec<FaceHealth>,
    /// An edge each.
    pub edges: Vec<EdgeHealth>,
    /// Defects that the lists above do not hold: vertices off their edges, frames that are not orthonormal, references that do not
    /// match, trims beyond their domain, ...
    pub defects: Vec<Defect>,
    /// What follows for answers.
    pub undefined: Vec<Undefined>,
}

/// How far the images of some trims are from the curves in space of their edges, proven: as [`PreparedBrep::edge_offsets`], face by face. Nothing of a
/// trim whose edge has no curve.
///
/// What takes more than about `most_bytes` of memory counts as not known: its offset is infinite.
///
/// # Panics
/// If there is no such trim.
///
/// # Cost
/// Some 100 us to milliseconds for each trim. No face is prepared: in memory are the patches of one that the images of some trims met, and one
/// trim's image.
pub fn trim_offsets(brep: &Brep, trims: &[usize], most_bytes: usize) -> Vec<Offset> {
    edge::offsets_alone(brep, trims, most_bytes)
}

impl PreparedBrep {
    /// How far the images of an edge's trims are from its curve in space, proven: as in [`health`](Self::health), without estimates. Nothing where
    /// it has no curve.
    ///
    /// # Panics
    /// If there is no such edge.
    ///
    /// # Cost
    /// Some 100 us to milliseconds for each trim.
    pub fn edge_offsets(&self, edge: usize) -> Vec<Offset> {
        let trims = &self.brep().parts().edges[edge].trims;
        edge::offsets(self, edge, trims, &[])
    }

    /// The health of the BREP. See the module `prepare::health` for what each size means and what is proven.
    pub fn health(&self) -> Health {
        let all = self.brep().defects();
        let faces: Vec<FaceHealth> = (0..self.brep().faces().len())
            .map(|f| face::health(self, f))
            .collect();
        let edges: Vec<EdgeHealth> = (0..self.brep().parts().edges.len())
            .map(|e| edge::health(self, e, &faces, &all))
            .collect();
        let has_bound = |d: &Defect| {
            matches!(
                d,
                Defect::Gap { .. }
                    | Defect::Orientation { .. }
                    | Defect::EdgeOffSurface { .. }
                    | Defect::BoundaryEdge { .. }
                    | Defect::NonManifoldEdge { .. }
                    | Defect::NoCurve { .. }
            )
        };
        let mut health = Health {
            is_closed: self.brep().is_closed(),
            size: self.size(),
            rounding: ROUNDING * self.size(),
            faces,
            edges,
            defects: all.into_iter().filter(|d| !has_bound(d)).collect(),
            undefined: Vec::new(),
        };
        health.undefined = health.consequences();
        health
    }
}

impl Health {
    fn consequences(&self) -> Vec<Undefined> {
        let mut out = Vec::new();
        if !self.is_closed {
            out.push(Undefined::Material);
        }
        let known = self.edges.iter().map(|e| e.crack.hi);
        let widest = known.filter(|x| x.is_finite()).fold(0.0, f64::max);
        if widest > self.rounding {
            out.push(Undefined::NearCracks(widest));
        }
        let count = |n: usize, of: fn(usize) -> Undefined, out: &mut Vec<Undefined>| {
            if n > 0 {
                out.push(of(n));
            }
        };
        let unknown = self.edges.iter().filter(|e| !e.crack.hi.is_finite());
        count(unknown.count(), Undefined::UnknownCracks, &mut out);
        let undecided = |f: &FaceHealth| {
            f.own_meetings().any(|m| m.kind == MeetingKind::Undecided) || f.meetings.more > 0
        };
        let crossed = |f: &FaceHealth| f.own_meetings().any(|m| m.kind != MeetingKind::Undecided);
        let faces =
            |pred: &dyn Fn(&FaceHealth) -> bool| self.faces.iter().filter(|f| pred(f)).count();
        count(faces(&crossed), Undefined::CrossedLoops, &mut out);
        count(
            faces(&|f| undecided(f) && !crossed(f)),
            Undefined::UndecidedLoops,
            &mut out,
        );
        let loops = self.faces.iter().flat_map(|f| &f.loops);
        let gapped = loops.filter(|l| l.widest_gap().is_some_and(|g| g.space.hi > self.rounding));
        count(gapped.count(), Undefined::InGaps, &mut out);
        let against = self
            .edges
            .iter()
            .filter(|e| e.direction == Direction::Against);
        count(against.count(), Undefined::Normals, &mut out);
        out
    }
}
