//! What a search is asked for, and what it finds.

use super::objective::{Objective, Sample};
use super::trail::Hint;
use crate::numeric::{Ball, Dd, Real};
use crate::prepare::closed::{Extent, V3};
use crate::prepare::{Homogeneous, Net};
use nalgebra::Point2;

/// Makes up for the rounding of a bound that is computed in a few f64 operations.
const UP: f64 = 1.0 + 32.0 * f64::EPSILON;

/// Where a node lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// A patch of a face.
    Patch { face: usize, index: usize },
    /// A boundary piece of a face.
    Piece { face: usize, index: usize },
}

impl Source {
    pub(crate) fn face(self) -> usize {
        let (Self::Patch { face, .. } | Self::Piece { face, .. }) = self;
        face
    }
}

/// A point of the BREP where `f` was evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    pub(crate) face: usize,
    /// The trim it lies on, for a boundary piece of a trim.
    pub(crate) trim: Option<usize>,
    pub(crate) uv: Point2<f64>,
    pub(crate) spot: Locus,
    /// Where the search found it, rounded; `None` for closed forms.
    pub(crate) found: Option<(Source, [f64; 2])>,
}

/// A point in the terms of the machinery that found it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Locus {
    /// Local parameters on a patch.
    Patch {
        patch: usize,
        local: [Ball<Dd>; 2],
        /// The homogeneous point there, where the search found it in double-double.
        point: Option<Homogeneous<Dd, 4>>,
    },
    /// A point of a face in closed form.
    Closed { point: V3 },
}

/// A node that convexity settled, kept for contacts and for the extent of the minimum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settled {
    pub(crate) face: usize,
    /// `None` for closed forms.
    pub(crate) source: Option<Source>,
    pub(crate) lo: Dd,
    /// The minimum on the node, rounded; of closed forms in native parameters.
    pub(crate) at: [f64; 2],
    /// What is proven about where on it the closest point can be; `None` where nothing is.
    pub(crate) spread: Option<Spread>,
    /// How far (in units of length, an estimate) one can go from it before `f` grows; infinite where not
    /// convex.
    pub(crate) extent: Extent,
    /// Whether the minimum of the node may be a local minimum of the face by what is known of the node (it is not cut off by it).
    pub(crate) local_minimum: bool,
    /// Whether the node is cut off there by nothing but the border of its patch or piece, beyond which `f` may rise, too.
    pub(crate) on_border: bool,
    /// Whether no arithmetic tells `f` on the node from one value: a minimum on it may be anywhere.
    pub(crate) flat: bool,
}

/// What may be a local minimum, by the formula of a face in closed form or of a curve that bounds it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FormulaMinimum {
    pub(crate) face: usize,
    /// The trim, on a curve that is part of one.
    pub(crate) trim: Option<usize>,
    pub(crate) uv: Point2<f64>,
    pub(crate) point: V3,
    /// Proven bounds of `f`.
    pub(crate) range: [Dd; 2],
    /// Those of `f` at the point, where it may not be the minimum: the same where no point is known better.
    pub(crate) here: [Dd; 2],
}

/// Where on a settled node `f` can be as low as a given value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Spread {
    /// As near to the node's own point as `f` grows.
    Around(Growth),
    /// On all of a box of its parameters.
    Within([[f64; 2]; 2]),
    /// No farther than `off` from a point: where the formula of a closed form says.
    At { point: [f64; 3], off: f64 },
}

/// How fast `f` grows on a node away from its own point.
///
/// With the terms of [`Leaf`](super::leaf::Leaf): where `f(y) <= hi`, `G(y) = C (f(y) - tau) <= C (hi - tau)`, and
/// `G(y) >= -|G(p)| - |g'| r + lambda/2 r^2` at distance `r`. So
/// `r <= (|g'| + sqrt(|g'|^2 + 2 lambda (|G(p)| + max C max(hi - tau, 0)))) / lambda`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Growth {
    /// `|g'|`.
    pub(crate) slope: f64,
    /// `|G(p)|`.
    pub(crate) value: f64,
    pub(crate) lambda: f64,
    pub(crate) c_max: f64,
    pub(crate) tau: Dd,
    /// Length of the surface's path per unit of node coordinates.
    pub(crate) speed: f64,
}

impl Growth {
    /// The radius, in units of length, of the ball that holds all points with `f <= hi`.
    pub(crate) fn radius(&self, hi: Dd) -> f64 {
        let above = (hi - self.tau).approximate().max(0.0) * UP;
        // Divided first: of small weights the products underflow. The square, the quotient and its double lose less than the least normal number together.
        let step = self.slope / self.lambda;
        let rest = 2.0 * ((self.value + self.c_max * above) / self.lambda);
        (step + (step * step + rest + f64::MIN_POSITIVE).sqrt()) * UP * self.speed
    }
}

/// What was found of a place in f64, for what is asked of the same place later.
#[derive(Clone, Debug)]
pub(crate) struct Rough {
    source: Source,
    at: [f64; 2],
    /// The homogeneous point.
    pub(crate) point: [Ball<f64>; 4],
    pub(crate) sample: Sample,
}

impl Rough {
    pub(crate) fn new(objective: &Objective, net: &Net<f64>, source: Source, at: [f64; 2]) -> Self {
        let (point, sample) = objective.rough_point(net, at);
        Self {
            source,
            at,
            point,
            sample,
        }
    }

    /// Whether it is of this place, to the last bit.
    pub(crate) fn is_at(&self, source: Source, at: [f64; 2]) -> bool {
        self.source == source && self.at == at
    }
}

/// What a search found.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// Proven: `lo <= min f`.
    pub(crate) lo: Dd,
    /// Proven: `min f <= hi`; infinite if no point was found.
    pub(crate) hi: Dd,
    /// Where `hi` was found.
    pub(crate) foot: Option<Foot>,
    /// What is known of the place that it started from, if it was given one.
    pub(crate) rough: Option<Box<Rough>>,
    /// Nodes put aside with a bound near the minimum.
    pub(crate) settled: Vec<Settled>,
    /// Where all minima are asked for: those of faces in closed form, and of their curves.
    pub(crate) formulas: Vec<FormulaMinimum>,
    /// How many nodes were visited.
    pub(crate) nodes: usize,
    /// Whether the budget ended the search.
    pub(crate) budget_spent: bool,
    /// Whether parts that may hold the minimum are not among `settled`: the enclosure was narrow enough without them, or
    /// they cannot be searched further.
    pub(crate) left_open: bool,
    /// Whether a closed form had part in it.
    pub(crate) used_closed: bool,
}

impl Outcome {
    /// What is known of a place, if it is the one that the search started from.
    pub(crate) fn rough_at(&self, source: Source, at: [f64; 2]) -> Option<&Rough> {
        self.rough.as_deref().filter(|r| r.is_at(source, at))
    }
}

/// How narrow the enclosure of the separation must be.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Width {
    /// This length, in model units.
    Length(f64),
    /// Two ulp of the separation, but no less than `floor`; the separation is the
    /// distance or height found less `radius`.
    Full { floor: f64, radius: f64 },
}

impl Width {
    /// Whether the last digits are asked for.
    pub(crate) fn is_full(self) -> bool {
        matches!(self, Self::Full { .. })
    }

    /// The width in model units for a distance or height near `value`.
    pub(crate) fn at(self, value: f64) -> f64 {
        match self {
            Self::Length(a) => a,
            Self::Full { floor, radius } => {
                let separation = (value.abs() - radius).abs();
                floor.max(2.0 * (separation.next_up() - separation))
            }
        }
    }
}

/// When a search may stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Width of the enclosure of the separation.
    pub(crate) width: Width,
    /// Find all minima with `f` up to this, not only the global one.
    pub(crate) all_below: Option<f64>,
    /// Only how far what is so low extends is asked, of a minimum not above this: closed forms tell that, too.
    pub(crate) extents: Option<Dd>,
    /// Only whether the least `f` is below this is asked.
    pub(crate) threshold: Option<Dd>,
    /// How many nodes may be visited.
    pub(crate) budget: usize,
    /// Whether closed forms may be used.
    pub(crate) closed: bool,
    /// Whether the foot is asked for, with what bounds its place.
    pub(crate) foot: bool,
    /// Where the minimum may be near.
    pub(crate) hint: Option<Hint>,
}
