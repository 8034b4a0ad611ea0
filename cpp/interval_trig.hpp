// Roots, cosine and sine, arc tangent of Intervals, by MPFR's directed rounding.
#pragma once

#include "interval.hpp"

namespace feeler_oracle {

// x >= 0 (an end below zero counts as zero).
Interval square_root(const Interval& x);

// Cosine and sine of the angles in a narrow interval: those of its lower end, widened by its width
// (both have slopes within [-1, 1]).
struct CosSin {
    Interval cos, sin;
};
CosSin cos_sin(const Interval& angle);

// The angle of (x, y), x >= 0, y >= 0, not both 0; monotone in both, so the ends decide.
Interval angle_of(const Interval& x, const Interval& y);

}  // namespace feeler_oracle
