//! Tests of the trimmed region.

mod against_reference;
mod meetings;
mod properties;
mod reference;
mod shape;
mod shapes;
mod sides;
mod turns;
