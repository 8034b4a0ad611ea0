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
//
// Native surfaces: the patches are those of native_patch.hpp, whose squares differ from the
// surface's parameters by maps that keep critical points and smoothness; coefficients are intervals
// that hold the true ones. The argument above and the searches speak of the true net, of which they
// use enclosures alone. Where the profile of a revolution (or a curve of a sum) has a corner or a
// jump there are Joints on both sides.
//
// Slack: a Trim may be a curve g that is within `slack` of the image of the trim curve, not the
// image itself (trim_image.hpp). Let F be the minimum over the true faces, delta the largest slack.
// A search that takes g for the image, and finds [lo, hi] for the minimum over what it takes, has
// proven F in [lo - delta, hi + delta] (for distances, and for n.x with |n| = 1): hi is the value
// at a point of a face, or at one of some g, which is within delta of one of a face. For lo: the
// search discards no minimiser with a value <= hi of what it takes. If F is attained at kind (b),
// it is either not discarded, so lo <= F, or F > hi >= lo. If F is attained at kind (a), the
// minimum G of the g's is <= F + delta; if G <= hi it was not discarded and lo <= G, else lo <= hi
// < G. Derivatives along a Trim are those of g, whose ends are Points of g.
//
// Faces are prepared when a query first comes near: until then a face is its box.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "interval.hpp"
#include "native_patch.hpp"
#include "side.hpp"
#include "trim_cuts.hpp"

namespace feeler_oracle {

enum class PieceKind { Patch, Joint, Trim, Point };

// (X / W, Y / W, Z / W) in Bernstein form, degrees p and q (q = 0 but for patches; p = 0 for
// points).
struct Piece {
    PieceKind kind;
    int face;
    int p, q;
    HomogeneousNet net;                            // coefficient (i, j) at i (q + 1) + j
    std::array<std::vector<Interval64>, 4> net64;  // contains net
    std::array<double, 6> box;                     // x0, x1, y0, y1, z0, z1 of the hull
    bool regional;                                 // counts only where the region holds it
    bool attained;  // its points (in the region) are on the face, up to the slack
    // Where the parameters of a Patch, Joint or regional Point run: u0..u1, v0..v1. A Joint has one
    // of the two of length zero; its parameter runs along the other.
    std::array<Q, 4> uv{Q(0), Q(0), Q(0), Q(0)};
    std::array<Interval64, 4> uv64{};  // u0, u1, v0, v1
    // Of a Patch or Joint: what takes its parameters to those of the surface. Lives as long as the
    // Pieces.
    const NativePatch* patch = nullptr;
    // Of a Trim, and of a Point that encloses the crossing of a trim curve and a knot line: the arc
    // of the face's region that it is the image of, over [t0, t1] (in a circular arc, as the angle
    // runs; where ends are no rational numbers, rounded); -1 for others.
    int arc = -1;
    Q t0 = Q(0), t1 = Q(0);
    // The true image is within this of the net's points.
    double slack = 0;
    // Whether weights are more than 2^10 apart.
    bool far = false;
};

// An arc of a face's loops (or a part of one), X, Y, W enclosed.
struct ArcNet {
    std::array<std::vector<Interval>, 3> c;
    std::array<Interval64, 2> box;  // of its hull in u and v
    int arc = -1;                   // of the region
    double from = 0, to = 1;        // its parameters there, rounded
};

// What a search needs of one face.
struct FacePieces {
    const Region* region = nullptr;
    std::vector<NativePatch> patches;
    std::vector<ArcNet> arcs;
    std::vector<Piece> pieces;
    // Images of the parts of trim curves beyond the domain, with their parameters clamped to it
    // (edge_images.hpp). They belong to no face: distances do not see them.
    std::vector<Piece> clamped;
    double slack = 0;  // the largest of the pieces
};

// What a model needs for all queries.
class Pieces {
 public:
    // `region` gives the region of a face, which must live as long as this, as must the model.
    //
    // Throws std::invalid_argument naming a face with a coordinate beyond kLargest, or a weight
    // beyond it or below its inverse: no product of the search overflows or underflows within; or
    // a frame that is none.
    Pieces(const Model& model, std::function<const Region&(std::size_t)> region);
    Pieces(const Pieces&) = delete;

    std::size_t count() const { return boxes_.size(); }
    // Whether the face has no points at all.
    bool nothing(std::size_t face) const { return nothing_[face]; }
    // Of the untrimmed surface: x0, x1, y0, y1, z0, z1.
    const std::array<double, 6>& box(std::size_t face) const { return boxes_[face]; }
    // Made on first use: about 0.1 ms a patch and 0.3 ms a trim curve of low degree. Throws
    // std::invalid_argument as the constructor does, of trim curves.
    const FacePieces& face(std::size_t face) const;
    // The diagonal of the hull of all faces' boxes, rounded.
    double size() const { return size_; }

 private:
    const Model& model_;
    std::function<const Region&(std::size_t)> region_;
    std::vector<std::array<double, 6>> boxes_;
    std::vector<bool> nothing_;
    mutable std::vector<std::unique_ptr<FacePieces>> faces_;
    double size_ = 0;
};

constexpr double kLargest = 1e60;

// Whether the box u x v is proven to be disjoint from all arcs; for boxes far smaller than box_side
// can tell (it takes doubles).
bool clear_of_arcs(const std::vector<ArcNet>& arcs, const Interval& u, const Interval& v);

}  // namespace feeler_oracle
