//! Tests of the trimmed region.

mod against_reference;
mod arcs;
mod exact;
mod meetings;
mod properties;
mod reference;
mod regions;
mod shape;
pub(super) mod shapes;
mod sides;
mod stationary;
mod turns;
