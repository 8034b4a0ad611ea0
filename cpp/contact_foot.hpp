// The place where the minimum over the union of the trimmed faces is attained, if it is one.
//
// All points of F with f = min f are local minimisers, so each lies in the box of a Candidate
// (contacts.hpp, item 1) whose lower bound is no more than the least upper bound of all. If the
// boxes of these are near to each other, their hull is the answer.
#pragma once

#include <array>
#include <optional>

#include "distance_pieces.hpp"

namespace feeler_oracle {

struct Objective;

// A box of a diagonal of no more than 2^-24 of the size that holds all minimisers of f; nothing
// where they are farther apart, or the search took more boxes than `nodes`. `limit`: no less than
// the minimum of the distance, or of n.x - h.
std::optional<std::array<double, 6>> foot_box(const Pieces& model, const Objective& objective,
                                              double limit, long nodes = 20000);

}  // namespace feeler_oracle
