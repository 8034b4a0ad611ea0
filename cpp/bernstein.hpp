// Polynomials of one variable in Bernstein form over [0, 1], exactly.
#pragma once

#include <vector>

#include "interval.hpp"
#include "model.hpp"

namespace feeler_oracle {

using Bernstein = std::vector<Q>;  // n + 1 coefficients

Bernstein product(const Bernstein& f, const Bernstein& g);
// a f + b g, of any degrees.
Bernstein combination(const Q& a, const Bernstein& f, const Q& b, const Bernstein& g);
// A positive multiple of the derivative.
Bernstein derivative(const Bernstein& f);
bool is_zero(const Bernstein& f);
Q value(const Bernstein& f, const Q& t);
Interval range(const Bernstein& f, const Q& lo, const Q& hi);

// F(x / w, y / w) w^(p + q), F in Bernstein form in degrees p and q; x, y, w of one degree.
Bernstein composed(const std::vector<Q>& F, int p, int q, const Bernstein& x, const Bernstein& y,
                   const Bernstein& w);

}  // namespace feeler_oracle
