//! Numbers that know how wrong they can be.

mod dyadic;
mod enclosure;
mod interval;

pub use dyadic::{Dyadic, ParseDyadicError};
pub use enclosure::Enclosure;
pub use interval::Interval;
