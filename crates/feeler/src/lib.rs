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
//!
//! # What is true
//!
//! Every claim of this crate is about the following definitions, and the oracle that checks it computes
//! the same things from them.
//!
//! **Numbers.** Each f64 of a [`brep::Brep`] is an exact number. A NURBS curve or surface is the exact quotient
//! of its homogeneous splines. A plane is `O + x a + y b` with its axes as stored. A native circle, arc or
//! surface of revolution is the exact one with the stored centre and radius, the stored axis exactly normalised and
//! the stored X direction made exactly orthogonal to it; how far the stored frame is from that is a
//! [defect](brep::Defect). Angles are exact f64. Coordinates are at most
//! [1e60](brep::LARGEST_COORDINATE) in magnitude and weights between 1e-60 and 1e60: there no
//! product overflows, and what underflows is covered by the bounds. Other BREPs and probes are refused.
//!
//! **Trimmed region of a face.** A loop is its trim curves in order, each joined to the next (the last to the
//! first) by a straight segment in uv where their end points differ. The region is the closure of the uv
//! points of odd parity, cut with the surface's domain. `Boundary` is its topological boundary, and every point
//! exactly on a loop. No loops given (`None`): the whole domain; an empty list: nothing. `in_gap` says that a point is in the
//! closed uv box of two end points so joined. A point outside the domain is outside, even on a loop there; a loop
//! that bounds no area belongs to the face where it is in the domain. Readers cut periodic surfaces at their seams: here every
//! loop closes in uv, up to its gaps. Where loops leave the domain of a plane or a revolution, whose formula goes on
//! beyond it, readers widen the domain to hold them and warn; no point moves.
//!
//! **Boundary of a face in space.** The image of its trim curves under its surface. The 3D edge curve of a file is
//! a second copy: it serves display and defects, not truth. The two images of an edge may leave a crack or
//! overlap. Distances are to the union of the trimmed faces.
//!
//! **Sphere.** `separation = d(c) - r`, with `d` the distance of the centre from the union of the faces, negative
//! where the centre is in material. An open sheet has `d >= 0`. Over several BREPs: the least; in material if in
//! any. The depth `-separation` is the depth at the nearest boundary: on a part that is not convex it is
//! not the shortest translation that frees the ball.
//!
//! **Half-space** `{x : n.x <= h}`: `separation` is the least `n.x - h` over the BREP, with n as given; refused
//! unless `|n|^2` is within 2^-50 of 1.
//!
//! **Contact.** A connected component of the local minimisers over the union of the faces with
//! `separation <= prediction`. The normal points from the BREP to the probe; with the centre on the surface it is the
//! face's. A contact is a *continuum* when the points within max(accuracy, 2^-44 size) of the minimum reach beyond
//! one foot: here, farther than 2^-12 of the size.
//!
//! **Line.** Its hits are all parameters at which it meets the trimmed faces. Crossings are derived from them: hits on
//! both sides of an edge, within its crack, count once.
//!
//! **Side of a point in space.** Parity along a line that stays clear of every edge by more than its crack. A solid is
//! closed when every non-singular edge is used twice; flags and normals of files decide nothing.
//!
//! **Accuracy.** `Full` means an enclosure no wider than max(2 ulp of the separation, 2^-96 of the model's size, the
//! longest side of its box). Any other accuracy is a length, and the enclosure is no wider than that. Where this cannot be
//! reached the answer says so ([`query::Undecided`]) and has the bound that was.
#![forbid(unsafe_code)]

pub mod brep;
pub mod numeric;
pub mod nurbs;
pub mod prepare;
pub mod query;
pub mod trim;
