// The pieces among which the minimum over trimmed faces is sought.
//
// Let f be continuous on space and smooth where it matters (the squared distance to a point, or a
// linear form), and let S be a trimmed face. Any minimiser P = S(u, v), (u, v) in the closed
// region, is of one of these kinds:
//   (a) (u, v) lies on a trim curve or on a segment joining two of them            -> Trim, Point
//   (b) else (u, v) is interior to the region (relative to the domain), and lies
//       (b1) on a knot line where S is only C0, or on the domain's border         -> Joint, Point
//       (b2) nowhere such: S is C1 around it, so both partial derivatives of f(S) vanish -> Patch
// Hence a box of a Patch on which one of these partial derivatives (one-sided at the box's sides)
// has a strict sign holds no minimiser of kind (b2) and may be discarded, whatever the region is,
// because (a) and (b1) are searched on their own, in one dimension: there, too, parts with a
// derivative of strict sign are discarded, because the ends of each one-dimensional piece are
// Points.
//
// C1: a knot of multiplicity < degree leaves the homogeneous spline C1, and so its quotient (W >
// 0). Border: where all loops lie in the closed domain (checked on the control points), a point of
// the region on the border but on no loop would have neighbours of odd parity beyond the border;
// but there the parity is even, being outside every loop. So borders need Joints only without
// loops, or where a loop leaves the domain.
//
// Trim curves are cut where they cross knot lines. Such a parameter is irrational in general: it is
// enclosed in an interval of 2^-kCutDepth of the arc, whose image under every patch it touches
// becomes a Point with interval coordinates that is good for lower bounds only (`attained` false).
// Parts of a trim curve outside the domain do not belong to the region and are dropped.
#pragma once

#include <array>
#include <vector>

#include "core.hpp"
#include "interval.hpp"

namespace feeler_oracle {

enum class PieceKind { Patch, Joint, Trim, Point };

// (X / W, Y / W, Z / W) in Bernstein form, degrees p and q (q = 0 but for patches; p = 0 for
// points).
struct Piece {
    PieceKind kind;
    int face;
    int p, q;
    std::array<std::vector<Interval>, 4> net;  // X, Y, Z, W; coefficient (i, j) at i (q + 1) + j
    std::array<std::vector<Interval64>, 4> net64;  // contains net
    std::array<double, 6> box;                     // x0, x1, y0, y1, z0, z1 of the hull
    bool regional;                                 // counts only where the region holds it
    bool attained;                                 // its points (in the region) are on the face
    // Where the parameters of a Patch, Joint or regional Point run: u0..u1, v0..v1. A Joint has one
    // of the two of length zero; its parameter runs along the other.
    std::array<Q, 4> uv;
    std::array<Interval64, 4> uv64;  // u0, u1, v0, v1
    // Of a Trim, and of a Point that encloses the crossing of a trim curve and a knot line: the arc
    // of the face's region that it is the image of, over [t0, t1]; -1 for others.
    int arc = -1;
    Q t0 = Q(0), t1 = Q(0);
};

// An arc of a face's loops, X, Y, W enclosed.
struct ArcNet {
    std::array<std::vector<Interval>, 3> c;
};

// What a model needs once for all queries.
struct Pieces {
    std::vector<const Region*> regions;     // of each face
    std::vector<std::vector<ArcNet>> arcs;  // of each face
    std::vector<Piece> pieces;
    // Images of the parts of trim curves beyond the domain, with their parameters clamped to it
    // (edge_images.hpp). They belong to no face: distances do not see them.
    std::vector<Piece> clamped;
    double size = 0;  // the diagonal of the hull of all control points, rounded
};

// Depth of bisection to which crossings of trim curves and knot lines are enclosed.
constexpr int kCutDepth = 200;

// Cost: about 0.1 ms a patch and 0.3 ms a trim curve of low degree.
//
// Throws std::invalid_argument naming a face with a coordinate beyond kLargest, or a weight beyond
// it or below its inverse: no product of the search overflows or underflows within. The faces must
// outlive the pieces.
Pieces prepare_pieces(const std::vector<const PreparedFace*>& faces);

constexpr double kLargest = 1e60;

// Whether the box u x v is proven to be disjoint from all arcs; for boxes far smaller than box_side
// can tell (it takes doubles).
bool clear_of_arcs(const std::vector<ArcNet>& arcs, const Interval& u, const Interval& v);

// C(n, k) exactly.
const Interval& binomial(int n, int k);

}  // namespace feeler_oracle
