//! A BREP as a collision shape of [Parry](https://parry.rs) and [Rapier](https://rapier.rs), without a mesh.
//!
//! [`BrepShape`] is a Parry `Shape` around a [`PreparedBrep`](feeler::prepare::PreparedBrep); [`BrepDispatcher`] answers
//! the queries of pairs of it and other shapes, and stands in a chain before Parry's own:
//!
//! ```
//! use feeler::brep::BrepBuilder;
//! use feeler::prepare::PreparedBrep;
//! use feeler_rapier::{BrepDispatcher, BrepShape};
//! use parry3d_f64::math::Pose;
//! use parry3d_f64::query::{DefaultQueryDispatcher, QueryDispatcher};
//! use parry3d_f64::shape::Ball;
//! use std::sync::Arc;
//!
//! let mut b = BrepBuilder::new();
//! let corners = [[0., 0., 0.], [4., 0., 0.], [4., 4., 0.], [0., 4., 0.]].map(|p| b.vertex(p));
//! b.planar_face(&corners)?;
//! let plate = BrepShape::new(Arc::new(PreparedBrep::new(b.build()?)))?;
//!
//! let dispatcher = BrepDispatcher::new().chain(DefaultQueryDispatcher);
//! let pose = Pose::translation(2.0, 2.0, 1.75);
//! let contact = dispatcher.contact(&pose, &plate, &Ball::new(2.0), 0.0).unwrap();
//! assert_eq!(contact.unwrap().dist, -0.25);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! In Rapier: `world.narrow_phase.set_query_dispatcher(BrepDispatcher::new().chain(DefaultQueryDispatcher))` and
//! `ColliderBuilder::new(SharedShape::new(plate))`; `examples/drop_balls.rs` is a guide.
//!
//! # What is supported, and how well
//!
//! | pair, in either order | separation | contacts |
//! |---|---|---|
//! | BREP, ball | certified | the deepest certified; further ones see [`Several`] |
//! | BREP, half-space | certified | the deepest certified, and points of the BREP within the prediction, each certified |
//! | BREP, segment or capsule | certified, but no narrower than about 2^-10 of the length | the deepest found, and both ends |
//! | BREP, cuboid, triangle, convex polyhedron, cylinder, cone, also with round borders | certified; tight where a plane parts the two, else about as wide as the shape (and told as undecided) | **approximate**: corners and points of round rims, the deepest point found, points of the BREP's edges |
//! | BREP, ray or point | certified by the kernel | - |
//! | ball that moves | no contact before the time that is given (certified; where bodies turn, as far as the system's sine and cosine are right to 4 units of the last place) | at that time |
//! | any other shape that moves (shape casts, CCD) | **unsupported**, said and counted as below: Rapier does not stop it, and what is fast goes through thin parts | |
//! | compound with a BREP, or a compound and a BREP | as of each pair of parts; what composing their poses rounds is in no bound | of each pair of parts, which the manifolds name |
//! | any other (meshes, height fields, voxels, two BREPs) | **unsupported**: [`BrepDispatcher`] says so, once for each kind of pair, and counts | |
//!
//! Bounds hold for the poses as they are given: a quaternion stands for the rotation by its exact normalisation, and what is
//! rounded on the way into the BREP's frame is in the bound (module [`pose`]). Where an engine forms the relative
//! pose of two bodies, it rounds too; [`ball_gap`] gives the gap at the two poses themselves.
//!
//! With a ball's centre in material there is one contact, the way out through the nearest face; on a part that is not
//! convex this is not the shortest translation that frees the ball. Where the kernel cannot tell on which side the centre is, the
//! ball is taken to be outside; [`BrepShape::undecided`] counts that.
//!
//! # What to set in Rapier
//!
//! - `contact_recycling = false`. With recycling (the default) Rapier keeps the contact of an earlier step, point and
//!   normal, until the pair has moved by 5 % of the length unit: on a curved face that is a facet of that width, the very bumps a BREP is
//!   meant to be free of.
//! - `contact_clustering = false`: clusters give contacts whose normals differ by up to 5 degrees one normal.
//! - `length_unit`: the size of a typical ball in the model's units, since slop and prediction are multiples of it.
//!   Nothing is scaled: a part in mm wants a gravity of 9810 mm/s^2, and has masses in units of density times mm^3.
//! - `contact_softness`, `static_contact_softness`: a resting ball sinks in by about g / (2 pi f)^2 whatever the shape says. At Rapier's 60 Hz
//!   that is 0.07 mm under a gravity in mm; 1000 Hz give 0.25 um.
//! - CCD works for balls alone (of a compound, for those among its parts), as far as the table says, also of a ball that leaves a contact, rolls along one, or is driven into it, and where a BREP turns or a ball goes
//!   round a centre of mass elsewhere: in one cast, of the motion that it is asked about, it may come deeper than it was by a 128th of its radius before it is stopped, no more.
//!   (Rapier casts bodies that move by themselves, against others where they stand at the end of the step: a turntable that is driven is not cast against what lies on it; and it
//!   places a body that was stopped between its poses, not on the way round its centre of mass.) (A hit at the very start
//!   of a step Rapier would pass over; that of a ball driven in is told where it is deeper by as much. Along what it touches on ways that bend a cast takes a query
//!   each 128th of the radius, and stops the ball after some 32 radii a step. What straight ones take, beside
//!   Parry's against triangles: `benches/cast.rs`.) Where the centre is in material such a cast says nothing and is counted as [undecided](BrepShape::undecided).
//!
//! Shapes scale exactly by powers of two (with the feature `files`); other scales are refused aloud. Rapier's serialisation refuses custom shapes; with the feature
//! `files` a shape is saved by reference to its file (module `file`).
//!
//! Queries of one pair remember where the last contact was ([`feeler::query::Witness`]). The memory belongs to the pair, so
//! that a run has the same bits whatever the number of threads; but a world restored from a snapshot has forgotten it,
//! and may differ from the one that went on within the bounds.
#![forbid(unsafe_code)]

mod advance;
mod along;
mod ball;
mod compound;
mod convex;
mod dispatcher;
#[cfg(feature = "experiments")]
pub mod experiment;
#[cfg(feature = "files")]
pub mod file;
mod half_space;
mod mass;
mod pair;
pub mod pose;
mod report;
mod shape;
mod solid;

pub use ball::ball_gap;
pub use dispatcher::BrepDispatcher;
#[cfg(feature = "files")]
pub use file::{ShapeFile, ShapeFileError};
pub use mass::MassEstimate;
pub use pair::{PairAnswer, PairContact};
pub use report::UnsupportedPair;
pub use shape::{BrepShape, Several, ShapeError};
