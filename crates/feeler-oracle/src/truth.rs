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

/// A surface point and its first derivatives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Evaluation {
    /// The point, in the model's frame.
    pub point: [TruthEnclosure; 3],
    /// Derivative along u; at a knot that of the span above it.
    pub du: [TruthEnclosure; 3],
    /// Derivative along v; likewise.
    pub dv: [TruthEnclosure; 3],
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

/// Why the oracle gives no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OracleError {
    /// The crate was built without the feature `cgal`.
    #[error(
        "the oracle is not built in: build with `--features cgal` \
         (needs libcgal-dev libmpfi-dev libmpfr-dev libgmp-dev libboost-dev)"
    )]
    NotBuilt,
    /// A surface or curve the oracle cannot treat exactly.
    #[error("face {face}: the oracle does not treat a {kind}; convert it to NURBS")]
    Unsupported {
        /// The face, numbered through all BREPs in order.
        face: usize,
        /// What it is: `revolution`, `arc`, ...
        kind: &'static str,
    },
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
