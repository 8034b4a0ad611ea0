//! Certified contact queries (sphere, half-space, line) against solids made of
//! trimmed NURBS faces.
//!
//! The kernel is pure: no file formats, clocks, random numbers, logs or globals.
//! Later modules use earlier ones, never the reverse:
//!
//! | module | holds |
//! |---|---|
//! | [`numeric`] | intervals, enclosures, double-double, exact dyadics, Bernstein roots |
//! | [`nurbs`] | knot vectors, basis functions, curves, surfaces, Bezier pieces |
//! | [`brep`] | topology, validation, a builder |
//! | [`trim`] | monotone arcs, inclusion in the trimmed region |
//! | [`prepare`] | what a scene needs: patches, trim index, boxes |
//! | [`query`] | sphere, half-space, line; contacts |
#![forbid(unsafe_code)]

pub mod brep;
pub mod numeric;
pub mod nurbs;
pub mod prepare;
pub mod query;
pub mod trim;
