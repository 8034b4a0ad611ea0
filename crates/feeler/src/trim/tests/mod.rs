//! Tests of the trimmed region.

mod shapes;
mod sides;
