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
