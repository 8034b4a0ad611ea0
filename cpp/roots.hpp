// Real roots of exact polynomials.
#pragma once

#include "exact.hpp"

namespace feeler_oracle {

// What the piece (X / W, Y / W), t in [0, 1], does to the parity of the point that f = Y - v W
// and g = X - u W (Bernstein coefficients) are taken from.
enum class Passage { Even, Odd, Through };

// The parity of the number of transitions of [f > 0] at parameters where g > 0, the values at
// t = 0 and t = 1 included; `Through` if f = g = 0 somewhere on [0, 1]. Exact.
Passage passage(const std::vector<Q>& f, const std::vector<Q>& g);

// Whether f and g (Bernstein coefficients over [0, 1], not both zero) have a common root in
// [lo, hi]. Exact.
bool common_root(const std::vector<Q>& f, const std::vector<Q>& g, const Q& lo, const Q& hi);

// Intervals no wider than 2^-bits, each with one of the distinct roots of f in [0, 1], in order. An
// f that vanishes identically has none.
std::vector<std::pair<Q, Q>> isolate_roots(const std::vector<Q>& f, int bits);

}  // namespace feeler_oracle
