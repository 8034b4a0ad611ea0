// All contacts within a prediction: the local minima, over the union of trimmed faces, of the
// distance to a point or of n.x - h.
//
// Definitions. Let F be the union of the faces, f the distance to c or n.x - h, and let join > 0 be
// a length (of an answer: Contacts::join; no less than the widest crack that was seen at an edge,
// and 2^-44 of the size). Points of F nearer to each other than `join` count as joined: a *way* is
// made of paths in F and of jumps from a point of F to another within `join`. A *contact* is a
// connected component of the local minimisers of f over F from which no way leads to a point lower
// by more than `join` without rising by more than `join` above it. So the end of a face at a seam,
// where the face beyond the crack goes on falling, is no contact, although f has a local minimum of
// F there, exactly taken. Contacts nearer to each other than 2^-24 of the size count as one.
//
// Theorem. Every contact with f <= limit lies in the box of some entry, or within 2^-24 of the size
// of one that is lower. An entry of status Minimum
// has at least one contact in its box, and the least f of its contacts lies in [lo, hi]. Of an
// entry of status Possible nothing is claimed but that f >= lo on the contacts it may hold. (If the
// budget is spent, what is left of the search is in Possible entries.) `continuum`: the box is
// longer than 2^-30 of the size, and says nothing of where in it the contact is.
//
// Proof.
// 1. Candidates (contact_candidates.hpp). A local minimiser of f over F is one over its face, so of
// one of the kinds (a), (b1), (b2) of distance_pieces.hpp: a critical point in one or two
// parameters inside a Trim, Joint or Patch, or a Point. A box of one of these goes if f > limit on
// it; if the region does not meet it; if one of the derivatives of f has a strict sign on it (item
// 2 of distance.hpp, T the range of f on the box up to the limit); or if the second derivative
// along a direction that enters the patch, or its opposite, is negative at all critical points in
// it: B f'' = (A - tau B)'' where f = tau and f' = 0. Where A - tau B is strictly convex for all
// tau in the range of f on the box, with least eigenvalue m, the box has at most one critical point
// z: two with tau1 <= tau2 would give h_tau2 <= 0 at the first, and h_tau2 > 0 off the second. With
// x any point of the box, t = f(x), g = grad(A - t B)(x): t - f(z) <= |g| |x - z| / min B, as h_t
// is convex, and
//    m |x - z| <= |grad h_f(z)(x)| <= |g| + (t - f(z)) |grad B(x)|.
// So z lies within |g| (1 + sqrt 2 |grad B| / min B) / m of x: a box of about 2^-200 of the
// patch's side. Where x is at an end of the box in one direction, and the derivative g_1 there
// points outward, g_1 (z - x)_1 >= 0 drops out of both lines: |g| is then that of the other
// direction, and if g_1 is larger than it can change within the radius (bounds of B f'' times the
// radius), there is no critical point in the box. Boxes on which f varies by no more than 2^-44 of
// the size are candidates as they are, unless 320 bits exclude a critical point or find the one.
// Candidates whose boxes in space are nearer than `join` are one entry.
// 2. Entries that go. A way down from all points of an entry's box shows that it holds no contact
// (contact_ways.hpp, fall).
// 3. Minima. Let K be the box, p a point of F in it with f(p) <= hi, and let f > hi + join at all
// points of F between two distances rho - 2 join and rho from K (contact_ways.hpp, walled). f has a
// least value over the compact part of F within rho - 2 join of K; it is <= hi, so it is not near
// the rim: it is attained at a local minimiser of F. No way that rises by no more than `join`
// leads from it past the wall, which no jump crosses, and nothing within is lower. So there is a
// contact within rho of K. If the boxes of all other entries are farther than that from K, it lies
// in K. (Boxes next to K with lo > hi, which K took in, cannot hold it, as its f is no more than
// hi.) The same follows without a wall where all other entries have lo > hi: the least f of all of
// F is attained at a contact.
// 4. Native surfaces and images known up to a slack. Nets are enclosures of true nets, whose
// parameters alone differ from the surface's (native_patch.hpp): critical points, signs and the
// faces' points are the same. Of a Trim with slack delta the true image is g + R. Either R comes of
// the noise at the border of a patch alone (face_pieces.cpp): then it is zero but next to an end,
// whose Point, widened by delta, holds what is there. Or g is the Taylor polynomial in sigma = 2 t
// - 1 of degree k = kOrder (trim_image.hpp), with W = 1 and B constant: then R' and R'' are the
// remainders of the Taylor polynomials of degree k - 1 and k - 2 of the image's derivatives, whose
// next coefficients are (k + 1) c and (k + 1) k c, c that of the image itself: |R| <= delta, |R'|
// <= 2 (k + 1) delta = 50 delta, |R''| <= 4 (k + 1) k delta = 2400 delta, derivatives by t. With D
// above the distance of g's control points from the point c (or above |n|), |g'| <= 2 k D = 48 D,
// |g''| <= 4 k (k - 1) D = 2208 D, and delta <= D: A' is off by no more than 296 delta D, A'' by
// 28616 delta D, f as a length by delta. Each test allows for that much; boxes are widened by
// delta.
#pragma once

#include <array>
#include <vector>

#include "distance_nets.hpp"
#include "distance_pieces.hpp"

namespace feeler_oracle {

struct ContactEntry {
    std::array<double, 6> box;  // x0, x1, y0, y1, z0, z1
    Real lo, hi;                // of f; hi is infinite where no point of F is known in the box
    bool minimum = false;
    bool continuum = false;
    int face = -1;  // one on which a candidate lies
};

struct Contacts {
    std::vector<ContactEntry> entries;  // by lo
    double join = 0;
    bool whole = true;  // the budget sufficed
    long nodes = 0;     // boxes bounded in doubles
};

struct ContactBudget {
    long nodes = 40000;  // of the search
    long ways = 20000;   // of all walls and ways down together
};

// All contacts of the distance to c (or of n.x - h) up to `limit`. Preconditions: numbers finite,
// limit >= 0 for distances.
Contacts contacts(const Pieces& model, const Objective& objective, double limit, double join,
                  const ContactBudget& budget = {});

// What contacts takes as `join`: four times the widest crack, as certified (edge_width.hpp), but no
// less than 2^-44 of the size and no more than 2^-12 of it: farther apart the images of an edge
// bound a hole. The theorem holds for any length; which contacts there are depends on it. Throws
// std::invalid_argument where an image is not known whole.
double join_of(const class Core& core);

}  // namespace feeler_oracle
