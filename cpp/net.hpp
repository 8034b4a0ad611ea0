// Bivariate Bernstein polynomials with interval coefficients.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "exact.hpp"
#include "interval.hpp"

namespace feeler_oracle {

// Coefficient (i, j) at i (q + 1) + j, i along u. Over a box [0, 1]^2 of its own.
struct Net {
    int p = 0, q = 0;
    std::vector<Interval> c;
};

Net to_net(int p, int q, const std::vector<Q>& coefficients);

// An interval of rationals.
inline Interval to_interval(const Q& x) { return Interval(x.mpq()); }
Q to_exact(const Real& x);

// The polynomial over [a, b] along u (or v), a < b or a = b, mapped to [0, 1]. The ends may lie
// outside [0, 1], at most 1 away.
Net restrict_u(const Net& n, const Real& a, const Real& b);
Net restrict_v(const Net& n, const Real& a, const Real& b);

void halve_net(const Net& n, bool along_u, Net& lower, Net& upper);

Interval hull(const Net& n);
inline bool excludes_zero(const Interval& x) { return x.lo.sign() > 0 || x.hi.sign() < 0; }

// Hulls of the derivatives over the box.
Interval hull_du(const Net& n);
Interval hull_dv(const Net& n);

// Value at (1/2, 1/2).
Interval at_middle(const Net& n);

// x a + y b, for nets of one degree.
Net combine(double x, const Net& a, double y, const Net& b);

}  // namespace feeler_oracle
