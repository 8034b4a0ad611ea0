//! What the oracle answers.

use feeler::numeric::Dyadic;
use feeler::trim::Side;

/// Proven to hold the true value. Dyadics of up to 192 bits; `lo == hi` where the value is
/// known exactly.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TruthEnclosure {
    /// Lower end.
    pub lo: Dyadic,
    /// Upper end.
    pub hi: Dyadic,
}

impl TruthEnclosure {
    /// Whether `x` lies in the range.
    pub fn contains(&self, x: &Dyadic) -> bool {
        self.lo <= *x && *x <= self.hi
    }

    /// `hi - lo`.
    pub fn width(&self) -> Dyadic {
        &self.hi - &self.lo
    }
}

/// What queries share, for [`Oracle::prepare`](crate::Oracle::prepare).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shared {
    /// Of one face, what sides in its parameter space and evaluations take.
    Face(usize),
    /// Of all faces, what distances take.
    Pieces,
    /// The same, and what lines, sides in space and lists of contacts take: images of edges.
    Edges,
}

/// A surface point and its derivatives up to the second.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Evaluation {
    /// The point, in the model's frame.
    pub point: [TruthEnclosure; 3],
    /// Derivative along u. At knots and joints all derivatives are one-sided, as was asked.
    pub du: [TruthEnclosure; 3],
    /// Derivative along v.
    pub dv: [TruthEnclosure; 3],
    /// Second derivatives: twice along u, along u and v, twice along v.
    pub second: [[TruthEnclosure; 3]; 3],
}

/// The side of a uv point, exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SideTruth {
    /// Where the point lies. Outside the surface's domain every point is `Outside`; on the
    /// domain's border a point of odd parity is `Boundary`.
    pub side: Side,
    /// Whether it is in the closed uv box of two loop end points that do not meet.
    pub in_gap: bool,
}

/// A place where the derivative of one coordinate of a trim curve vanishes or changes sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DerivativeRootTruth {
    /// The parameter of the trim's curve. Enclosures of one coordinate's roots are disjoint.
    pub t: TruthEnclosure,
    /// How often the derivative vanishes, seen from below and from above. Equal but at a joint of Bezier
    /// pieces; 0 where it does not, where the coordinate is constant on that side, and beyond the
    /// trim's span.
    pub multiplicity: [usize; 2],
    /// The derivative's sign just below and just above; 0 where the coordinate is constant there,
    /// and beyond the span.
    pub sign: [i8; 2],
    /// Whether the derivatives of both coordinates are zero here, from below or from above.
    pub cusp: bool,
}

impl DerivativeRootTruth {
    /// Whether the coordinate turns here: a `MonotoneArc` ends.
    pub fn turns(&self) -> bool {
        self.sign[0] * self.sign[1] < 0
    }
}

/// Where one coordinate of a trim curve is stationary.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AxisRootsTruth {
    /// Ascending. A joint of Bezier pieces is one place, listed where the derivative vanishes on
    /// either side or has different signs; an end of the trim's span, where it vanishes there.
    pub roots: Vec<DerivativeRootTruth>,
    /// The maximal parts of the span on which the coordinate is constant, by their ends.
    pub constant: Vec<[TruthEnclosure; 2]>,
}

/// The derivative roots of a trim curve over its span, in the curve's parameter.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DerivativeRootsTruth {
    /// Of u and of v.
    pub axes: [AxisRootsTruth; 2],
}

/// What is known about where a minimum is attained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DistanceStatus {
    /// At isolated, convex minima inside faces.
    Regular,
    /// Likewise, but on a trim curve, or on a knot line where the surface may be only C0.
    EdgeOrCorner,
    /// Nothing; the enclosure is as narrow as asked (the centre of a socket).
    IntervalOnly,
    /// The node budget was spent; the enclosure holds, but is wider than asked.
    Budget,
}

/// A certified minimum over the union of the trimmed faces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DistanceTruth {
    /// Proven to hold the minimum. No wider than about 2^-118 of the model's size, unless the
    /// status is [`DistanceStatus::Budget`].
    pub enclosure: TruthEnclosure,
    /// Where it is attained.
    pub status: DistanceStatus,
    /// A face on which the upper end is attained, if known.
    pub face: Option<usize>,
    /// Boxes bounded in doubles, and in 320-bit intervals.
    pub nodes: [u64; 2],
}

/// A critical point of the distance from a point to one patch over its closed square.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalPoint {
    /// The distance there.
    pub distance: TruthEnclosure,
    /// A box that holds it: `[lo, hi]` of x, y and z.
    pub at: [[f64; 2]; 3],
    /// Whether it is a local minimiser; `None` where the signs that tell are 0 or not known.
    pub minimum: Option<bool>,
    /// Whether it is inside the square; else on its border.
    pub inner: bool,
}

/// Critical points inside a patch, along its sides, and its corners.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalPoints {
    /// Whether these are all; not where there are curves of them.
    pub all: bool,
    /// In no order.
    pub points: Vec<CriticalPoint>,
}

/// Where a line meets a face.
#[derive(Clone, Debug, PartialEq)]
pub struct LineHitTruth {
    /// The face, numbered through all BREPs.
    pub face: usize,
    /// The parameter; where the line lies in the face, its start.
    pub t: TruthEnclosure,
    /// The end, where the line lies in the face.
    pub t_end: Option<TruthEnclosure>,
    /// Proven to be on the boundary of the face's region (an edge, a seam, a pole).
    pub boundary: bool,
    /// How often the line meets the surface here, as a root of the two polynomials that it is cut out
    /// by: 1 crossing at an angle, 2 touching, 3 touching and crossing, and so on. `None` where it is
    /// not known (poles, creases) or the line lies in the face.
    pub multiplicity: Option<u32>,
    /// Proven to pass from one side of the surface to the other.
    pub transversal: bool,
    /// Proven to touch without crossing (or to lie in the face).
    pub tangential: bool,
    /// Parameters of the point, about; where `t_end` is set, of the start.
    pub uv: [f64; 2],
}

/// A part of a line where more hits may be.
#[derive(Clone, Debug, PartialEq)]
pub struct LineOpen {
    /// The face.
    pub face: usize,
    /// The part of the line.
    pub t: TruthEnclosure,
    /// Why it could not be settled.
    pub why: String,
}

/// All hits of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct LineTruth {
    /// Proven hits, by t. With `open` empty there are no others.
    pub hits: Vec<LineHitTruth>,
    /// Where more hits may be, and only there.
    pub open: Vec<LineOpen>,
    /// How often the line passes through the faces: hits in one passage of an edge's crack count once, others
    /// where they cross. `None` where this is not known, or has no meaning (a line in a face). The exact words
    /// are in `cpp/edge_line.hpp`.
    pub crossings: Option<usize>,
    /// Whether the line passes an edge within the width of its crack without a hit there; `None` where it
    /// is not known.
    pub in_crack: Option<bool>,
}

/// The side of a point in space.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InsideTruth {
    /// In material.
    Inside,
    /// Not in material.
    Outside,
    /// On a face.
    Boundary,
    /// Not settled, and why.
    Undecided(String),
}

/// Where a contact is, or may be.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactTruth {
    /// Holds the separation at the contact, if it is `proven`; otherwise a bound on one end is all that is
    /// certain (the lower; for a centre in material the upper).
    pub separation: TruthEnclosure,
    /// A box that holds the contact: `[lo, hi]` of x, y and z.
    pub at: [[f64; 2]; 3],
    /// Whether there is a contact in the box for certain.
    pub proven: bool,
    /// Whether it is then within the prediction for certain.
    pub within: bool,
    /// Whether the box is longer than 2^-30 of the model's size: a contact that is no point, or one that is not
    /// told from such.
    pub continuum: bool,
    /// A face on which it is, if known.
    pub face: Option<usize>,
}

/// All contacts within a prediction.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactsTruth {
    /// Every contact is in one of these boxes.
    pub contacts: Vec<ContactTruth>,
    /// Points of the faces that are nearer to each other count as joined (`cpp/contacts.hpp`).
    pub join: f64,
    /// Whether the budget sufficed; else some boxes are large.
    pub whole: bool,
}

/// Why the oracle gives no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OracleError {
    /// The crate was built without the feature `cgal`.
    #[error(
        "the oracle is not built in: build with `--features cgal` \
         (needs libcgal-dev libmpfi-dev libmpfr-dev libgmp-dev libboost-dev libeigen3-dev)"
    )]
    NotBuilt,
    /// There is no such face.
    #[error("there is no face {face}: the model has {count}")]
    NoFace {
        /// The face asked for.
        face: usize,
        /// How many there are.
        count: usize,
    },
    /// The query or the model is refused.
    #[error("refused: {0}")]
    Refused(String),
    /// The C++ side gave an answer that cannot be read; a defect of the oracle.
    #[error("defect in the oracle: {0}")]
    Defect(&'static str),
}
