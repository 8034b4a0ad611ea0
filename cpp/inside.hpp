// On which side of a solid a point in space lies.
//
// By the theorem of edge_images.hpp: parity along one ray from the point that is proven to stay off
// all cracks and vertex regions, and to meet the faces in transversal hits inside their regions
// alone. Many rays are at hand; those that meet the fewest patches' boxes are tried first.
//
// Boundary: the point is proven to be on a face: exactly, for a plane, or with rational parameters
// whose exact image it is. Undecided, with the reason kCrack: proven to be within d_e of an edge,
// or in a vertex region. A point so near that the enclosure of d_e cannot tell, or one that no ray
// could be found for, is Undecided too, with another reason.
//
// Closed: loops on every face, every non-singular edge used exactly twice. A BREP that is not
// closed has no material. Of several BREPs a point is in material if it is in any.
#pragma once

#include <string>

#include "core.hpp"

namespace feeler_oracle {

enum class InsideKind { Inside, Outside, Boundary, Undecided };

struct InsideAnswer {
    InsideKind kind;
    std::string why;  // of Undecided
};

// The reason of a point that is undecided by definition.
constexpr const char* kCrack = "crack";

// `rays`: how many rays are used where there are so many; all must agree (one is enough by the
// theorem; std::logic_error if they do not, for tests).
InsideAnswer inside(const Core& core, const std::array<double, 3>& point, int rays = 1);

}  // namespace feeler_oracle
