// Exact numbers of the oracle.
#pragma once

#include <CGAL/Gmpq.h>
#include <CGAL/Gmpz.h>

#include <utility>
#include <vector>

namespace feeler_oracle {

using Q = CGAL::Gmpq;
using Z = CGAL::Gmpz;

// -1, 0 or 1.
inline int sign(const Q& x) { return mpq_sgn(x.mpq()); }

// Doubles lo <= x <= hi, at most 2 ulp apart (infinite where x is beyond the range of doubles).
// Independent of the rounding mode in force.
std::pair<double, double> double_bounds(const Q& x);

// The two halves of a Bernstein polynomial at t = 1/2, exactly.
void halve(const std::vector<Q>& b, std::vector<Q>& left, std::vector<Q>& right);

}  // namespace feeler_oracle
