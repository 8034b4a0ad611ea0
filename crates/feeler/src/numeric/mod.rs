//! Numbers that know how wrong they can be.

mod atan;
mod ball;
pub mod bernstein;
mod dd;
mod dyadic;
mod enclosure;
mod gcd;
mod interval;
pub mod polynomial;
mod real;
pub mod roots;
mod td;
mod trig;

pub(crate) use atan::{ATAN_ERROR, atan2};
pub use ball::Ball;
pub use dd::Dd;
pub(crate) use dd::{two_prod, two_sum};
pub use dyadic::{Dyadic, ParseDyadicError};
pub use enclosure::Enclosure;
pub(crate) use gcd::gcd;
pub use interval::Interval;
pub use real::{Real, TINY};
pub(crate) use td::Td;
pub use trig::{MAX_ANGLE, sin_cos};
pub(crate) use trig::{full_turn, vector_angle};
