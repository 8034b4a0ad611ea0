//! Tests of the trimmed region.

mod against_reference;
mod exact;
mod meetings;
mod properties;
mod reference;
mod shape;
pub(super) mod shapes;
mod sides;
mod turns;
