// Where a trim curve's coordinates are stationary, exactly.
//
// Piece by piece (a span of a spline, a segment, an arc) a coordinate x(t) = X(t) / W(t) has the
// derivative N / W^2 with N = X'W - XW' and W > 0: same zeros, same multiplicities, same signs as
// N. N is made from the exact Bezier form of the whole span in the power basis (its coefficient of
// degree 2p - 1 is p a_p c_p - a_p p c_p = 0, so the degree is at most 2p - 2, and p - 1 where W is
// constant) and handed to CGAL's algebraic kernel: square-free factorisation and isolation are
// exact, and so are comparisons of its roots with the rational ends of the piece.
//
// A joint of two pieces is one place: the multiplicities and signs of both sides are kept apart,
// since a spline is only as smooth there as its knots allow. It is listed where the derivative
// vanishes on either side or changes sign across it (a corner is a split of `MonotoneArc`s too).
// The ends of the used span are listed where the derivative vanishes there; what is beyond them
// does not count.
//
// An arc's coordinate is c + r (cos a X + sin a Y), (X, Y) one row of its exact frame; in uv Y is X
// turned by a right angle, so that the derivative is a positive multiple of sin(phi - a), phi the
// angle of (X, Y): simple zeros at phi + k pi. phi is 0 or pi where Y = 0; else tan phi is
// rational and not 0, hence phi + k pi transcendental (Lindemann) and never equal to a rational:
// enough digits always decide a comparison with an end.
#pragma once

#include <array>
#include <vector>

#include "model.hpp"

namespace feeler_oracle {

// A place where the derivative of one coordinate vanishes or changes sign.
struct DerivativeRoot {
    // The parameter of the trim's curve; disjoint from those of the coordinate's other roots.
    Q lo, hi;
    // How often the derivative vanishes, seen from below and from above: equal inside a piece; 0
    // where it does not, where the coordinate is constant on that side, and beyond the used span.
    std::array<int, 2> multiplicity;
    // Its sign just below and just above; 0 where the coordinate is constant there, and beyond the
    // span.
    std::array<int, 2> sign;
    // Whether the derivatives of both coordinates are zero here, from below or from above.
    bool cusp;
};

struct AxisRoots {
    std::vector<DerivativeRoot> roots;  // ascending
    // The maximal parts on which the coordinate is constant.
    std::vector<std::pair<Q, Q>> constant;
};

// Of u and v over the used span, in the direction of the curve's parameter whatever that of the
// trim. Intervals are no wider than 2^-bits of their piece.
std::array<AxisRoots, 2> derivative_roots(const TrimCurve& trim, int bits);

}  // namespace feeler_oracle
