// Bernstein polynomials in one variable, exactly: coefficients over [0, 1].
#pragma once

#include <vector>

#include "exact.hpp"
#include "interval.hpp"

namespace feeler_oracle {

// C(n, k) exactly.
const Interval& binomial(int n, int k);

// The coefficients over [a, b], 0 <= a < b <= 1.
std::vector<Q> restrict_to(std::vector<Q> c, const Q& a, const Q& b);

Q value_at(std::vector<Q> c, const Q& t);

// lo = hi for an exact point.
struct Cut {
    Q lo, hi;
};

// Depth of bisection to which sign changes are enclosed.
constexpr int kCutDepth = 200;

// Isolates the sign changes of g over [0, 1], unordered: between two successive cuts (and before
// the first, and after the last) g is >= 0 throughout or <= 0 throughout.
void sign_cuts(const std::vector<Q>& g, std::vector<Cut>& cuts);
// Of a polynomial whose coefficients are enclosed. Where noise hides the sign the cut is as wide
// as that takes.
void sign_cuts(const std::vector<Interval>& g, std::vector<Cut>& cuts);

}  // namespace feeler_oracle
