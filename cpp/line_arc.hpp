// Where a straight line of uv meets an arc of a loop that is no rational curve: exactly.
//
// A circle is met where a quadratic with rational coefficients vanishes. Whether such a point P is
// on the arc, quarter by quarter, is told by the coordinate u of P and of the quarter's ends, which
// is rational or quadratic for P. An end at an angle other than 0 is transcendental (CirclePoint),
// so it differs, and enclosures tell. An end at the angle 0, center + radius x / |x|, is P only if
// P - center is parallel to x; that is linear in P's parameter t, so an irrational t gives it only
// where the line runs through the center along x, which rational numbers tell.
//
// A segment between ends that are not both rational is met where its ends are on two sides of the
// line: signs that enclosures tell, as no line with rational coefficients holds an end at an angle
// other than 0; at the angle 0 by squares.
#pragma once

#include <vector>

#include "uv_curve.hpp"

namespace feeler_oracle {

// An enclosure of the line's parameter at a point of a loop: lo = hi if it is rational.
struct LineBreak {
    Q lo, hi;
};

// Adds all t where start + t along is on the arc, along not zero; of a segment along the line, its
// ends. False where kMostBits do not tell.
bool arc_breaks(const CircularArc& arc, const std::array<Q, 2>& start,
                const std::array<Q, 2>& along, std::vector<LineBreak>& breaks);
bool arc_breaks(const Segment& segment, const std::array<Q, 2>& start,
                const std::array<Q, 2>& along, std::vector<LineBreak>& breaks);

}  // namespace feeler_oracle
