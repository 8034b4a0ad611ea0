// Arcs of a region's boundary, halved lazily, with the boxes and strips that hold them.
#pragma once

#include <memory>

#include "box_tree.hpp"
#include "model.hpp"

namespace feeler_oracle {

// Coordinates are those of the curve's hull: it lies in the convex hull of its control points
// because the weights are positive, and halving keeps them positive.
struct ArcNode {
    RationalBezierCurve curve;
    std::array<Q, 4> hull;  // u0, u1, v0, v1, exactly
    Box box;                // the same, rounded outward
    double size_u, size_v;  // of the hull, rounded
    // a u + b v lies in [strip_lo, strip_hi] on the curve; normal to its chord.
    double a, b, strip_lo, strip_hi;
    std::unique_ptr<ArcNode> children[2];

    explicit ArcNode(RationalBezierCurve c);
    // Makes the children on first use.
    ArcNode& child(int k);
    Q end_u(int end) const;
    Q end_v(int end) const;
};

// A closed box in uv.
struct QueryBox {
    Box box;                    // rounded outward
    const std::array<Q, 4>* q;  // u0, u1, v0, v1 exactly, where that is finer than `box`
    double size_u, size_v;

    std::array<Q, 4> exact() const;
};

// Whether the curve is proven to be disjoint from the box; it is halved until its hulls are smaller
// than the box.
bool clear_of(ArcNode& arc, const QueryBox& box);

// Range of a u + b v over a box, rounded outward.
std::pair<double, double> strip_range(double a, double b, const Box& box);

}  // namespace feeler_oracle
