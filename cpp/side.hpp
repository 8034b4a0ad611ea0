// The trimmed region of a face, and on which side of its boundary a point of uv lies: exactly.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "uv_curve.hpp"

namespace feeler_oracle {

enum class Side { Inside, Outside, Boundary };

// What is known of all points of a box, cut with the closed domain:
// Inside: they belong to the region (its interior, or the border of the domain);
// Outside: none of them belongs to it, and none is on a loop;
// Mixed: neither is proven.
enum class BoxSide { Inside, Outside, Mixed };

class ArcIndex;

// Two end points that differ and are joined by a segment.
struct Gap {
    EndPoint from, to;
};

// Closed boundary made of the trim curves of all loops, each joined to the next (the last to the
// first) by a straight segment where their end points differ.
class Region {
 public:
    explicit Region(const Face& face);
    Region(Region&&) noexcept;
    ~Region();

    // The loops' curves and joining segments, in order. Without loops: none.
    const std::vector<RegionArc>& arcs() const { return arcs_; }
    // arc_edge()[i]: the edge that arc i is an image of; -1 for joins and singular trims.
    const std::vector<int>& arc_edge() const { return arc_edge_; }
    // arc_trim()[i]: the trim that arc i belongs to, counted through the face's loops; -1 for the
    // joins between two trims. A join within a trim belongs to it.
    const std::vector<int>& arc_trim() const { return arc_trim_; }
    // The surface's domain u0, u1, v0, v1. Its sides bound the region too, where its inside
    // reaches them.
    const std::array<Q, 4>& domain() const { return domain_; }
    // Whether the region is the whole domain, because no loops are given.
    bool whole_domain() const { return whole_; }
    // Pairs of end points that differ. Irrational ones that are equal, but given by other numbers,
    // count as different: such a gap is one irrational point, to which no rational point belongs.
    const std::vector<Gap>& gaps() const { return gaps_; }

    const ArcIndex& index() const { return *index_; }

 private:
    std::vector<RegionArc> arcs_;
    std::vector<int> arc_edge_, arc_trim_;
    std::array<Q, 4> domain_;
    std::vector<Gap> gaps_;
    std::unique_ptr<ArcIndex> index_;
    bool whole_ = false;
};

// The region is the closure of the points of odd parity, cut with the surface's domain. A point
// outside the closed domain is Outside. On the border of the domain a point is Boundary if its
// parity is odd. A point on a loop is Boundary. Exact.
//
// Cost: logarithmic in the number of arcs (arc_index.hpp), and one exact decision for each arc
// whose box holds the point. Throws std::runtime_error where the sign of a number is not known at
// kMostBits (uv_curve.hpp says when that may be).
//
// Not for use by several threads on one region: subdivided arcs are kept in it.
Side side(const Region& region, const Q& u, const Q& v);

// Whether the point lies in the closed uv box of two end points that a segment joins.
bool in_gap(const Region& region, const Q& u, const Q& v);

// Conservative: Mixed where a curve's hull (subdivided as far as the box's size calls for) meets
// the box. The parts of loops that run exactly along the domain's border do not count.
BoxSide box_side(const Region& region, double u0, double u1, double v0, double v1);

// Whether the closed box u0, u1, v0, v1 is proven to be disjoint from every loop and from the
// domain's border, and to lie in the domain. Subdivides until the arcs' hulls are smaller than
// the box.
bool box_clear(const Region& region, const std::array<Q, 4>& box);

// Whether the closed box is proven to be disjoint from every loop; it may be flat.
bool loops_clear(const Region& region, const std::array<Q, 4>& box);

}  // namespace feeler_oracle
