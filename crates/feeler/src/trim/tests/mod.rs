//! Tests of the trimmed region.

mod against_reference;
mod arcs;
mod exact;
mod meetings;
pub(super) mod near;
mod properties;
mod reference;
mod regions;
mod shape;
pub(super) mod shapes;
mod sides;
mod stationary;
mod steps;
mod turns;
