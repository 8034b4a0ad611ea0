// What the coefficients of A and B on a box prove (distance.hpp), in doubles and in intervals.
#pragma once

#include "distance_nets.hpp"

namespace feeler_oracle {

// Bounds of the objective over a box of space x0, x1, y0, y1, z0, z1.
Interval64 box_bounds(const Objective& o, const std::array<double, 6>& box);

// Second derivatives of A - tau B over a box: below uu and vv, above |uv|.
struct Curvature {
    double uu, vv, uv;
    bool convex(Degrees d) const;
    // At least -(uu x^2 + 2 uv' x y + vv y^2) / 2 for all |x| <= rx, |y| <= ry, |uv'| <= uv.
    double loss(Degrees d, double rx, double ry) const;
    // m > 0 below the least eigenvalue (determinant over trace, if convex).
    double least_eigenvalue(Degrees d) const;
};

// ---- doubles

// Below A / B on the box (item 1); -infinity if nothing is known.
double lower_bound(const Net64& n);

// Above a_k / b_k.
double value_above(const Net64& n, size_t k);
// Above the value at a local point.
double value_above(const Net64& n, Degrees d, double x, double y);

double magnitude(const std::vector<double>& c);

// Whether a first difference of A - T B along the direction has a strict sign throughout (item 2);
// ma, mb: the magnitudes of a and b.
bool monotone(const Net64& n, Degrees d, bool along_u, const Interval64& t, double ma, double mb);
Curvature curvature(const Net64& n, Degrees d, const Interval64& t, double ma, double mb);

// ---- intervals

Real lower_bound(const NetMp& n);
bool monotone(const NetMp& n, Degrees d, bool along_u, const Interval& t);
Curvature curvature(const NetMp& n, Degrees d, const Interval& t);

// A - t B in doubles, scaled by 2^-exponent to about 1: keeps full relative accuracy where A is
// almost a multiple of B. No guarantee.
std::vector<double> scaled_difference(const NetMp& n, const Real& t, long& exponent);

// ---- where to split

// The direction in which h bends most (with some weight on its slope, for boxes that shrink only
// to get clear of the region's boundary).
bool split_along_u(const std::vector<double>& h, Degrees d, const DyadicBox& at);
// Whether to split along u after all: boxes are not made too uneven, nor too small.
bool allowed_along_u(bool wanted, Degrees d, const DyadicBox& at, bool far);
bool deepest(const DyadicBox& at, Degrees d, bool far);

}  // namespace feeler_oracle
