// Pieces of trim curves: where they start and end, and in which direction they run.
#pragma once

#include "model.hpp"

namespace feeler_oracle {

// Whether two end points are the same by their data. Points of circles that are equal but given by
// other numbers count as different.
bool same_point(const EndPoint& a, const EndPoint& b);

// The rational square root, if there is one. x >= 0.
std::optional<Q> rational_root(const Q& x);

// A straight segment between two points that differ.
RegionArc joined(const EndPoint& a, const EndPoint& b);

// The rational curve; throws std::runtime_error naming the face if it is none.
const RationalBezierCurve& rational_curve(const RegionArc& arc, std::size_t face);

}  // namespace feeler_oracle
