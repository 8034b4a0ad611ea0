//! Probes, options and answers.

use crate::brep::LARGEST_COORDINATE;
use crate::numeric::Enclosure;
use crate::trim::Side;
use nalgebra::{Point2, Point3, Vector3};
use std::fmt;

/// Why a probe is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProbeError {
    /// A number is NaN or infinite.
    #[error("{0} is not finite: give a number")]
    NotFinite(&'static str),
    /// The radius is negative.
    #[error("the radius is negative: give 0 or more")]
    Radius,
    /// The direction is zero.
    #[error("the direction is zero: give a vector that points somewhere")]
    ZeroDirection,
    /// The direction is so short that parameters of hits might be too large for an f64.
    #[error(
        "the direction is shorter than 1e-240: multiply it (parameters of hits are divided by the same)"
    )]
    ShortDirection,
    /// The normal of a half-space is not of unit length: `|n|^2` must be within 2^-50 of 1.
    #[error(
        "the normal is not a unit vector: divide it by its length (|n|^2 must be within 2^-50 of 1)"
    )]
    NotUnit,
    /// The end of a motion is before its start, or no number.
    #[error("the time until which is negative or no number: give 0 or more, or leave it out")]
    Until,
    /// A number so large or so small that the bounds would not hold.
    #[error("{0} is outside the range in which bounds hold (up to 1e60)")]
    Range(&'static str),
}

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, in the model's frame.
    pub center: Point3<f64>,
    /// Radius in model units, not negative.
    pub radius: f64,
}

/// The half-space `{x : normal . x <= offset}`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Outward normal, a unit vector within 2^-50 in `|n|^2`; used as given.
    pub normal: Vector3<f64>,
    /// Offset in model units.
    pub offset: f64,
}

/// Which part of a line counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// All t.
    Line,
    /// t >= 0.
    Ray,
    /// 0 <= t <= 1.
    Segment,
}

/// `origin + t direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineProbe {
    /// The point at t = 0.
    pub origin: Point3<f64>,
    /// Direction, not zero; `t` counts in its length.
    pub direction: Vector3<f64>,
    /// Which part of it counts.
    pub kind: LineKind,
}

/// What touches the BREP.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Probe {
    /// A ball.
    Sphere(Sphere),
    /// A half-space.
    HalfSpace(HalfSpace),
}

/// How narrow the enclosure of a separation must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// No wider than max(2 ulp of the separation, 2^-96 of the model's size).
    Full,
    /// No wider than this length, in model units.
    Length(f64),
}

/// Which contacts to report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contacts {
    /// None: the separation alone. No foot and no normal is made, and whether the minimum is a continuum is not looked at.
    None,
    /// The deepest one.
    Deepest,
    /// All within the prediction.
    All,
}

/// What is asked of a contact query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Width of the separation's enclosure.
    pub accuracy: Accuracy,
    /// Report contacts with separation <= this, in model units. Infinite: however far they are; minus infinity, or NaN: none. (Of an arrival, which
    /// asks when the separation is that small: at once, never, and undecided.)
    pub prediction: f64,
    /// Which contacts to report.
    pub contacts: Contacts,
    /// How many search nodes may be spent before the query gives up with the bound it has; a line's node counts for four. To list all contacts
    /// it may spend as many again, of which one looks around a place in some eight points.
    pub node_budget: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            accuracy: Accuracy::Full,
            prediction: 0.0,
            contacts: Contacts::Deepest,
            node_budget: 200_000,
        }
    }
}

/// Why an answer has only a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Undecided {
    /// The node budget was spent.
    #[error("node budget spent")]
    Budget,
    /// The arithmetic in use cannot narrow the enclosure further.
    #[error("enclosure wider than the accuracy asked for")]
    Precision,
    /// Within the width of a crack between faces.
    #[error("within a crack between faces")]
    Crack,
    /// Too close to call: the number of hits or the side could not be settled.
    #[error("could not be settled at this precision; ask a little beside it")]
    Degenerate,
}

/// The face, edge or vertex touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Feature {
    /// Index of a face.
    Face(usize),
    /// Index of an edge.
    Edge(usize),
    /// Index of a vertex.
    Vertex(usize),
}

/// A signed gap with its proof: > 0 apart, < 0 overlapping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// The value to use, in model units; within `bounds`.
    pub value: f64,
    /// Proven to hold the true separation.
    pub bounds: Enclosure,
}

/// Where a probe touches or nearly touches a BREP.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Point on the BREP, in the model's frame.
    pub on_brep: Point3<f64>,
    /// Point on the probe's surface, in the model's frame.
    pub on_probe: Point3<f64>,
    /// Unit normal from the BREP to the probe.
    pub normal: Vector3<f64>,
    /// Signed gap at this contact.
    pub separation: Separation,
    /// What is touched.
    pub feature: Feature,
    /// The face the point was found on, and its parameters there.
    pub face: usize,
    /// Parameters of the point on `face`.
    pub uv: Point2<f64>,
    /// Proven distance of `on_brep` from the true contact point; `None` where the contact is a
    /// continuum or no bound was found.
    pub position_bound: Option<f64>,
    /// Proven angle of `normal` to the true one, in radians; `None` likewise, and where it is not known whether the
    /// centre of a sphere is in material.
    pub normal_bound: Option<f64>,
    /// Whether `normal` is one of many: the centre of a sphere is on an edge or a vertex, as far as its place is known, or on a point without a
    /// normal. It is the normalised sum of the faces' normals there. (Within a face it is the face's, by the face's orientation.)
    pub normal_is_choice: bool,
}

/// The answer of a sphere or half-space query.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactAnswer {
    /// The separation from the whole BREP.
    pub separation: Separation,
    /// Whether the closest points reach beyond one foot box; `false` where no contacts were asked for.
    pub continuum: bool,
    /// Contacts within the prediction, deepest first.
    pub contacts: Vec<Contact>,
    /// Set when the enclosure is wider than the accuracy asked for.
    pub undecided: Option<Undecided>,
}

/// Whether a sphere or half-space overlaps a BREP.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapAnswer {
    /// `Some(true)`: the separation is proven to be below 0. `Some(false)`: proven to be 0 or more. `None` with `undecided`.
    pub overlap: Option<bool>,
    /// Set when the sign could not be settled.
    pub undecided: Option<Undecided>,
}

/// A place that a line's answer leaves open: the first that was met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unsettled {
    /// The face.
    pub face: usize,
    /// About where on the line, in lengths of its direction; an estimate. `None` where that is not known.
    pub t: Option<f64>,
}

/// `face 3, t about 0.5`.
impl fmt::Display for Unsettled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "face {}", self.face)?;
        match self.t {
            Some(t) => write!(f, ", t about {t:?}"),
            None => Ok(()),
        }
    }
}

/// Whether a line meets a BREP.
#[derive(Clone, Debug, PartialEq)]
pub struct AnyHit {
    /// A certain hit; not in general the first.
    pub hit: Option<Hit>,
    /// Set when there may be a hit but none is certain. Neither: proven to meet no face.
    pub undecided: Option<Undecided>,
    /// Where, if it is undecided.
    pub unsettled: Option<Unsettled>,
}

/// A parameter of a line or a time of a motion with its proof. It counts in lengths of the line's direction, so that the point is `origin + t direction`, or in units of
/// the motion's velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// The value to use; within `bounds`.
    pub value: f64,
    /// Proven to hold the true parameter.
    pub bounds: Enclosure,
}

/// Where a line meets a face.
#[derive(Clone, Debug, PartialEq)]
pub struct Hit {
    /// Where on the line.
    pub t: Parameter,
    /// The other end of the interval, where the line lies in the face.
    pub t_end: Option<Parameter>,
    /// The point, in the model's frame.
    pub point: Point3<f64>,
    /// Unit normal of the face.
    pub normal: Vector3<f64>,
    /// What is hit.
    pub feature: Feature,
    /// The face, and parameters there.
    pub face: usize,
    /// Parameters of the point on `face`.
    pub uv: Point2<f64>,
    /// Whether the line touches without crossing, or lies in the face.
    pub tangential: bool,
}

/// The answer of a line query.
#[derive(Clone, Debug, PartialEq)]
pub struct LineAnswer {
    /// The hits, in the order of t.
    pub hits: Vec<Hit>,
    /// How often the line passes through the faces; `None` where it lies in one, and where it is not known: that of an
    /// undecided answer is right where it is given.
    pub crossings: Option<usize>,
    /// Whether the line passes an edge within its crack's width without a hit.
    pub in_crack: bool,
    /// Set when the hits could not all be settled.
    pub undecided: Option<Undecided>,
    /// Where, if it is undecided and one face is to blame: of a crack it is not told.
    pub unsettled: Option<Unsettled>,
}

/// The answer of a side query in uv.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SideAnswer {
    /// Where the point lies; `None` with `undecided`.
    pub side: Option<Side>,
    /// Whether the point is in the closed box of two loop end points that do not meet; within about 1e-29 of where a native
    /// arc ends, it may be just outside.
    pub in_gap: bool,
    /// Set when the side could not be settled.
    pub undecided: Option<Undecided>,
}

/// What the largest component of a line's direction is at least. Points of models and origins have coordinates of [1e60](LARGEST_COORDINATE) at most, so a hit is at no more than
/// twice that over this along it, 2e300, which f64 holds.
const LEAST_DIRECTION: f64 = 1e-240;

pub(super) fn in_range(what: &'static str, values: &[f64]) -> Result<(), ProbeError> {
    for x in values {
        if !x.is_finite() {
            return Err(ProbeError::NotFinite(what));
        }
        if x.abs() > LARGEST_COORDINATE {
            return Err(ProbeError::Range(what));
        }
    }
    Ok(())
}

impl Probe {
    /// What is taken from a distance to be the separation.
    pub(super) fn radius(&self) -> f64 {
        match self {
            Self::Sphere(s) => s.radius,
            Self::HalfSpace(_) => 0.0,
        }
    }
}

impl Sphere {
    /// A ball; refuses what is not finite, too large, or of negative radius.
    pub fn new(center: Point3<f64>, radius: f64) -> Result<Self, ProbeError> {
        in_range("the center", center.coords.as_slice())?;
        in_range("the radius", &[radius])?;
        if radius < 0.0 {
            return Err(ProbeError::Radius);
        }
        Ok(Self { center, radius })
    }
}

impl HalfSpace {
    /// A half-space; refuses a normal with `|n|^2` off 1 by more than 2^-50.
    pub fn new(normal: Vector3<f64>, offset: f64) -> Result<Self, ProbeError> {
        in_range("the normal", normal.as_slice())?;
        in_range("the offset", &[offset])?;
        // The rounded square is off by at most 4 * 2^-53 * 1.01 here: below 2^-50 / 1.9, so
        // a normal that was normalised in f64 always passes.
        const LIMIT: f64 = 1.0 / (1u64 << 50) as f64;
        if (normal.norm_squared() - 1.0).abs() > LIMIT {
            return Err(ProbeError::NotUnit);
        }
        Ok(Self { normal, offset })
    }
}

impl LineProbe {
    /// A line; refuses what is not finite, and a direction that is zero or has no component of 1e-240 or more: parameters of hits are
    /// distances, of no more than some 1e60, over its length. (Where its square is lost in f64, from some 1e-150 on, most of what is not flat is undecided.)
    pub fn new(
        origin: Point3<f64>,
        direction: Vector3<f64>,
        kind: LineKind,
    ) -> Result<Self, ProbeError> {
        in_range("the origin", origin.coords.as_slice())?;
        in_range("the direction", direction.as_slice())?;
        if direction == Vector3::zeros() {
            return Err(ProbeError::ZeroDirection);
        }
        if direction.amax() < LEAST_DIRECTION {
            return Err(ProbeError::ShortDirection);
        }
        Ok(Self {
            origin,
            direction,
            kind,
        })
    }
}
