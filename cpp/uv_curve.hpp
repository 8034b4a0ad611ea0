// Pieces of trim curves: where they start and end, and in which direction they run.
#pragma once

#include "model.hpp"

namespace feeler_oracle {

// Whether two end points are the same by their data. Points of circles that are equal but given by
// other numbers count as different.
bool same_point(const EndPoint& a, const EndPoint& b);

// Rational lo <= x <= hi.
struct Bounds {
    Q lo, hi;
};

// Both coordinates of a point, enclosed with `bits` bits; exactly, where they are rational.
std::array<Bounds, 2> enclose(const EndPoint& point, int bits);

// Bits at which a comparison is given up. None that has an answer was seen to need more than a few
// hundred.
constexpr int kMostBits = 8192;

// Sign of coordinate k (0: u, 1: v) of a point minus x. Exact: by rational numbers, squares of
// them at an angle of 0, else by enclosures. These end: such a coordinate is transcendental (see
// CirclePoint), so it differs from x. Throws std::runtime_error at kMostBits.
int compare(const EndPoint& point, int k, const Q& x);

// Sign of the difference of coordinate k of two points. Exact likewise: with c + A cos |a| + B sin
// |a| as such a coordinate (A, B algebraic), two of them at angles |a| != 0 are equal only if c,
// |a|, A and B are, again by the theorem of Lindemann and Weierstrass; at angles 0 they are c + A,
// compared by squares.
int compare(const EndPoint& a, const EndPoint& b, int k);

// On which side of q - p the directed line from p to `to` passes: the sign of (from - q) x (to -
// q); > 0 if q lies to the left of the segment. Exact, or std::runtime_error at kMostBits; that can
// happen only where both ends are irrational, as else q, from and to would lie on a line with
// algebraic coefficients.
int orientation(const Segment& segment, const Q& u, const Q& v);

// Likewise, but 0 also where kLikelyBits do not tell.
int likely_orientation(const Segment& segment, const Q& u, const Q& v);
constexpr int kLikelyBits = 512;

// A part of a circle within one quarter of it, so that u and v are monotone along it:
// sign_u (u - center) >= 0 and sign_v (v - center) >= 0 on it.
struct QuarterArc {
    EndPoint from, to;  // counter-clockwise
    int sign_u, sign_v;
};

// The quarters that an arc is cut into by the extreme points of its circle, which are rational. Of
// more than four turns an even number is left out: neither the set of the points nor the parity of
// any crossing depends on them.
//
// The quarter that an end lies in is exact: at angle 0 by signs, else by enclosures of the angle,
// which end because no such end is an extreme point (its coordinates are transcendental).
std::vector<QuarterArc> quarter_arcs(const CircularArc& arc);

// The rational square root, if there is one. x >= 0.
std::optional<Q> rational_root(const Q& x);

// A straight segment between two points that differ.
RegionArc joined(const EndPoint& a, const EndPoint& b);

}  // namespace feeler_oracle
