// Arcs of a region's boundary, halved lazily, with the boxes and strips that hold them.
#pragma once

#include <memory>

#include "side.hpp"

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
    bool on_border;  // of the surface's domain, all of it
    std::unique_ptr<ArcNode> children[2];

    explicit ArcNode(RationalBezierCurve c, bool border);
    // Makes the children on first use.
    ArcNode& child(int k);
    Q end_u(int end) const;
    Q end_v(int end) const;
};

// Range of a u + b v over a box, rounded outward.
std::pair<double, double> strip_range(double a, double b, const Box& box);

}  // namespace feeler_oracle
