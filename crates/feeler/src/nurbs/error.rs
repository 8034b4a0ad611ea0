//! Why a piece of geometry was refused.

/// Why a curve, surface or knot vector cannot be built from the given data.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A number is NaN or infinite.
    #[error("{what} is not finite")]
    NotFinite {
        /// Which quantity.
        what: &'static str,
    },
    /// The degree is 0 or above [`MAX_DEGREE`](super::KnotVector::MAX_DEGREE).
    #[error("degree {degree} is outside 1..={max}")]
    Degree {
        /// The refused degree.
        degree: usize,
        /// The largest supported.
        max: usize,
    },
    /// A knot vector of the wrong length.
    #[error("{found} knots where {expected} are needed")]
    KnotCount {
        /// How many were given.
        found: usize,
        /// How many the degree and the control points need.
        expected: usize,
    },
    /// Knot `index` is smaller than the one before it.
    #[error("knot {index} is smaller than the knot before it")]
    KnotOrder {
        /// Index of the offending knot.
        index: usize,
    },
    /// An interior knot of multiplicity above the degree (a broken curve), or an empty domain.
    #[error("knot {index} has multiplicity {multiplicity}, above degree {degree}")]
    KnotMultiplicity {
        /// Index of the first of the equal knots.
        index: usize,
        /// How often it occurs.
        multiplicity: usize,
        /// The degree.
        degree: usize,
    },
    /// A domain or angle interval that is empty or reversed.
    #[error("{what} is empty or reversed")]
    EmptyInterval {
        /// Which interval.
        what: &'static str,
    },
    /// Weight `index` is not positive.
    #[error("weight {index} is {weight:?}, not positive")]
    Weight {
        /// Index of the control point.
        index: usize,
        /// The weight.
        weight: f64,
    },
    /// A parameter that does not lie inside the domain.
    #[error("parameter {parameter:?} is not inside the domain ({start:?}, {end:?})")]
    OutsideDomain {
        /// The parameter.
        parameter: f64,
        /// Start of the domain.
        start: f64,
        /// End of the domain.
        end: f64,
    },
    /// An angle beyond [`MAX_ANGLE`](crate::numeric::MAX_ANGLE), or more turns than a NURBS form is
    /// made for.
    #[error("{what} runs from {start:?} to {end:?} radians, too far")]
    Angle {
        /// Of what.
        what: &'static str,
        /// Start in radians.
        start: f64,
        /// End in radians.
        end: f64,
    },
    /// Too few control points or pieces.
    #[error("{found} {what} where at least {needed} are needed")]
    TooFew {
        /// Of what.
        what: &'static str,
        /// How many were given.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// A direction or axis of zero length, or a radius that is not positive.
    #[error("{what} is degenerate")]
    Degenerate {
        /// Which quantity.
        what: &'static str,
    },
}
