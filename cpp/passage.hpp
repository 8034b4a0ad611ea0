// What a piece of a loop does to the parity of a point, by subdivision in interval arithmetic.
#pragma once

#include <optional>
#include <vector>

#include "interval.hpp"
#include "roots.hpp"

namespace feeler_oracle {

// Like passage() of roots.hpp, whose meaning of f and g it shares: Even or Odd where that is
// proven, nothing where it is not (points on the piece, or nearer to it than some 2^-190 of it).
// above0, above1: whether f > 0 at t = 0 and t = 1, exactly.
//
// Method: where f has one strict sign on a part (Bernstein coefficients), or g < 0, nothing passes;
// where g > 0 the transitions of [f > 0] have the parity of its values at the part's ends; else
// the part is split where f has a strict sign. All in intervals of doubles, which are spent after
// some fifty halvings: f and g (their enclosures) are then cut to the part, and rounded afresh.
std::optional<Passage> certain_passage(std::vector<Interval> f, std::vector<Interval> g,
                                       bool above0, bool above1);

}  // namespace feeler_oracle
