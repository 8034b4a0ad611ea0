//! Tests of the trimmed region.

mod against_reference;
mod properties;
mod reference;
mod shape;
mod shapes;
mod sides;
mod turns;
