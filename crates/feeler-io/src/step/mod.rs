//! STEP, ISO 10303-21: AP203, AP214 and AP242.
//!
//! Entities keep their numbers, which messages name.
//!
//! | module | holds |
//! |---|---|
//! | `part21` | the syntax |
//! | `entities` | entities, attributes, errors that name them |
//! | `geometry` | placements, curves, surfaces |
//! | `hyperbola` | the part of a hyperbola that a surface is made of |
//! | `chart` | uv of a point |
//! | `net` | points of B-spline surfaces |
//! | `pcurve` | curves in uv of edges, with a bound |
//! | `points` | points of edges' curves |
//! | `smooth` | how far images on elementary surfaces are off, without composing them |
//! | `loops` | sheets, poles, seams |
//! | `body` | a solid or a set of faces as a BREP |
//! | `products` | assemblies, placements, names |
//! | `context` | units and tolerances |
//! | `sites` | which bodies stand where |
//! | `document` | the whole file |

mod body;
mod chart;
mod context;
mod document;
mod entities;
mod geometry;
mod hyperbola;
mod loops;
mod net;
mod part21;
mod pcurve;
mod points;
mod products;
mod sites;
mod smooth;

pub use document::read_step;
