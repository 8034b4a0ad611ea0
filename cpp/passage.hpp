// What a piece of a loop does to the parity of a point, by subdivision in interval arithmetic.
#pragma once

#include <optional>
#include <vector>

#include "roots.hpp"

namespace feeler_oracle {

// Like passage() of roots.hpp, whose meaning of f and g it shares: Even or Odd where that is
// proven, nothing where it is not (points on the piece, or nearer to it than 320 bits tell).
// above0, above1: whether f > 0 at t = 0 and t = 1, exactly.
//
// Method: where f has one strict sign on a part (Bernstein coefficients), or g < 0, nothing passes;
// where g > 0 the transitions of [f > 0] have the parity of its values at the part's ends; else
// the part is split where f has a strict sign. First in doubles, then in 320 bits.
std::optional<Passage> certain_passage(const std::vector<Q>& f, const std::vector<Q>& g,
                                       bool above0, bool above1);

}  // namespace feeler_oracle
