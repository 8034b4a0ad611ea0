//! Certified contact queries (sphere, half-space, line) against solids made of
//! trimmed NURBS faces.
//!
//! The kernel is pure: no file formats, clocks, random numbers, logs or globals.
//! Later modules use earlier ones, never the reverse:
//!
//! | module | holds |
//! |---|---|
//! | [`numeric`] | intervals, enclosures, double-double, triple-double, exact dyadics, Bernstein roots |
//! | [`nurbs`] | knot vectors, basis functions, curves, surfaces, Bezier pieces |
//! | [`brep`] | topology, validation, a builder |
//! | [`trim`] | monotone arcs, inclusion in the trimmed region |
//! | [`prepare`] | what a scene needs: patches, trim index, boxes |
//! | [`query`] | sphere, half-space, line; contacts |
//!
//! `PROOFS.md` beside this crate's sources lists what is proven, on which assumptions, and where.
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
//! **Boundary of a face in space.** The image of its trim curves under its surface; where a trim curve leaves the
//! surface's domain, each parameter is moved to the nearest one in it. The 3D edge curve of a file is
//! a second copy: it serves display and defects, not truth. Distances are to the union of the trimmed faces.
//!
//! **Crack.** The images of an edge under the surfaces it borders (a seam: twice the same) may lie apart or overlap. The
//! width d_e of an edge used twice or more is the largest Frechet distance between two of its images, each run through in
//! whichever direction gives less; an edge used once has none. Its crack is the set of the points within d_e of
//! one of the images. A vertex region is the smallest box along the axes that holds the ends of images that meet at
//! a vertex, the images of the segments that join trims there, and those of singular trims. (Frechet, not
//! Hausdorff: matched points joined by segments fill the crack, which is what makes parity the side.)
//!
//! **Sphere.** `separation = d(c) - r`, with `d` the distance of the centre from the union of the faces, negative
//! where the centre is in material. An open sheet has `d >= 0`. Over several BREPs: the least; in material if in
//! any. The depth `-separation` is the depth at the nearest boundary: on a part that is not convex it is
//! not the shortest translation that frees the ball.
//!
//! **Half-space** `{x : n.x <= h}`: `separation` is the least `n.x - h` over the BREP, with n as given; refused
//! unless `|n|^2` is within 2^-50 of 1.
//!
//! **Contact.** A connected component of the local minimisers (of the distance to the centre, or of n.x) over the union of
//! the faces, with `separation <= prediction` (with the centre in material: within `r + prediction` of it, or the
//! nearest of all), from which no way leads to a lower point without a rise: the end of a face at a seam, where the face
//! beyond the crack goes on falling, is none. A way may jump a crack: points of faces nearer to each other than four times the
//! widest crack (but no more than 2^-12 of the size: beyond it is a hole), or than 2^-44 of the size, count as joined. Contacts nearer to each other than 2^-24 of the size count
//! as one. Which contacts there are is searched in certified boxes, but that each is a minimum (no way down, in steps
//! from 2^-24 of the size, along lines in uv and along edges) is tested, not proven. The normal points from the BREP to the probe; with the centre on the surface it is the
//! face's. A contact is a *continuum* when the points within max(accuracy, 2^-44 size) of the minimum reach beyond
//! one foot: here, farther than 2^-12 of the size.
//!
//! **Line.** Its hits are all parameters at which it meets the trimmed faces. A passage is all stretches of the line within
//! an edge's crack that are no farther than d_e apart from the next. Crossings: hits in one passage are linked, and
//! linked hits, through whatever others, count once; other hits count once where they cross, and not where they
//! touch; a line in a face has no number of them. `in_crack`: some passage has no hit. An edge touched from
//! outside counts too, so crossings tell parity only of a line with no passage.
//!
//! **Side of a point in space.** A solid is closed when every non-singular edge is used twice; flags and normals of files decide
//! nothing. A point of a face is `Boundary`. Else a point in a crack or a vertex region is `Undecided(crack)`. Else
//! the parity of the hits of any ray that meets no crack and no vertex region, and the faces in transversal hits inside their
//! regions alone, tells the side: it is the same for all such rays (filling the cracks within themselves makes the faces a
//! closed surface; the proof stands in `cpp/edge_images.hpp`). A point that has no such ray is undecided.
//!
//! **Accuracy.** `Full` means an enclosure no wider than max(2 ulp of the separation, 2^-96 of the model's size, the
//! longest side of its box). Any other accuracy is a length, and the enclosure is no wider than that. Where this cannot be
//! reached the answer says so ([`query::Undecided`]) and has the bound that was.
#![forbid(unsafe_code)]
// Nothing of the platform's mathematics library reaches an answer: `clippy.toml` lists what would.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod brep;
pub mod numeric;
pub mod nurbs;
pub mod prepare;
pub mod query;
pub mod trim;
