//! A second method for each truth, in Rust alone.
//!
//! It shares with the first (`cpp/`) nothing but the input types, and nothing with the kernel's algorithms: no
//! Bernstein form but for the hull of a control polygon, no subdivision of control nets, no MPFR. One entry is an exception and says so:
//! [`TrimmedRegion::side_by_halving`], quick enough for loops of checks, which decides a side as the first method and the kernel do. What the method does: Sturm chains for sides and roots; for the rest Taylor forms of surfaces and
//! curves on boxes in their own parameters, automatic differentiation to second order, interval
//! Newton (Krawczyk's operator), in intervals of f64 first and of 256-bit numbers then. It may be slow, and where a
//! problem is degenerate (the focal set of a surface) its enclosures are wide; they hold nevertheless, so
//! two methods disagree when theirs are disjoint.
//!
//! | module | holds |
//! |---|---|
//! | [`number`] | intervals of f64 and balls of 256 bits; sine and cosine |
//! | `shape` | curves and surfaces with derivatives over whole intervals |
//! | `region` | where a box of parameters lies |
//! | `search` | the least value of an objective over trimmed faces: [`Second::distance`], [`Second::half_space`] |
//! | `contacts` | all local minimisers: [`Second::sphere_contacts`], [`Second::half_space_contacts`] |
//! | `standing` | whether a place on a border of a face is one |
//! | `pole` | whether there is one at a side of the domain that is one point in space |
//! | `line` | [`Second::line`] and [`Second::inside`] |
//! | [`analytic`] | closed forms |
//! | `polynomial`, `candidates`, `isolate` | exact roots: Sturm chains, eigenvalues as candidates |
//! | `spline`, `pieces` | exact values by truncated powers, Bezier pieces by knot insertion |
//! | `fraction` | exact rationals |
//! | `fixed` | intervals of any precision: roots, angles |
//! | `derivative_roots`, `side`, `evaluate` | the exact truths by them |

pub mod analytic;
mod candidates;
mod contacts;
mod derivative_roots;
mod evaluate;
mod fixed;
mod fraction;
mod isolate;
mod line;
pub mod number;
mod pieces;
mod pole;
mod polynomial;
mod rational;
mod region;
mod search;
mod shape;
mod side;
mod space;
mod spline;
mod standing;

pub use contacts::{SecondContact, SecondContacts};
pub use derivative_roots::{Candidates, derivative_roots, isolated_by_candidates, root_brackets};
pub use evaluate::evaluate;
pub use line::{SecondHit, SecondLine, SecondSide};
pub use side::{TrimmedRegion, side};
pub use space::{BUDGET, Bound, Second};
