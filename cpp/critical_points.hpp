// All critical points of the distance to one small polynomial patch: another method for distances
// and contacts, which shares nothing with the search (distance.hpp, contacts.hpp) but the numbers
// given.
//
// With F(u, v) = |S(u, v) - c|^2 an exact polynomial, the critical points inside the square are the
// common zeros of F_u and F_v, all of which CGAL's bivariate algebraic kernel finds exactly (A.
// Eigenwillig, M. Kerber, "Exact and efficient 2D-arrangements of arbitrary algebraic curves", SODA
// 2008); those along each side are the zeros of one polynomial of one variable (its univariate
// kernel); and there are the four corners. The least of their values is the minimum, since a
// continuous function has one on the closed square, at one of them.
//
// A common zero known to lie in a box [x] with the middle m has its value in F(m) + grad
// F([x]).([x]
// - m), by the mean value theorem; grad F is about 0 there, so the width is of second order. It is
// a local minimiser where the Hessian is positive definite over the box; a zero along a side, where
// the second derivative along it and the first derivative inwards are positive; a corner, where
// both derivatives inwards are. Where such a sign is 0 or unknown nothing is claimed.
//
// The kernel in a translation unit of its own, and no polynomial outlives the call: CGAL's are
// reference-counted without locks.
#pragma once

#include <array>
#include <vector>

#include "interval.hpp"

namespace feeler_oracle {

enum class Extremum { Minimum, None, Unknown };

struct CriticalPoint {
    Interval distance;             // of the point from c
    std::array<Interval64, 3> at;  // in space
    Extremum kind;                 // whether it is a local minimiser over the closed square
    bool inner;                    // inside the square, not on its border
};

struct CriticalPoints {
    // Whether these are all of them. False where F_u and F_v have a common factor (a curve of
    // critical points) or F is constant along a side, or one is too near a side to tell.
    bool all = false;
    std::vector<CriticalPoint> points;
};

// Of the Bezier patch of degrees p and q, 1 to 3, with control points (x, y, z) at 3 (i (q + 1) +
// j), i along u. Throws std::invalid_argument for other counts and numbers that are not finite. 5
// ms at degrees (1, 1), 0.1 s at (2, 2), seconds at (3, 3).
CriticalPoints critical_points(int p, int q, const std::vector<double>& net,
                               const std::array<double, 3>& c);

}  // namespace feeler_oracle
