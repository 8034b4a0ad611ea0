//! Numbers that know how wrong they can be.

mod enclosure;
mod interval;

pub use enclosure::Enclosure;
pub use interval::Interval;
