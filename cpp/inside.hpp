// On which side of a solid a point in space lies.
//
// Parity of the hits along a ray, over the faces of one closed BREP. The argument, and its
// hypothesis: Fix a ray from the point whose line meets every face's surface, extended beyond the
// domain's border by the margin, only in proven simple (transversal) roots, all of them listed
// (nothing open), and each with its uv box, enlarged by the margin, off every loop and off the
// domain's border: either well inside a face or well outside. The line then has no face boundary
// within the margin in uv around any of its hits. Suppose every crack of the BREP is narrower than
// the image of the margin: filling the cracks with strips no wider than that, along the faces'
// boundaries, makes the faces a closed surface. A line that met such a strip would meet one of the
// two extended surfaces it joins within the margin of their loops, which was excluded. So the ray
// meets the closed surface in the listed transversal hits alone and their parity tells the side.
// The hypothesis is not checked at the edges; instead several rays in unrelated directions must
// agree, and if two do not, the answer is Undecided.
//
// Closed: every non-singular edge is used exactly twice. A BREP that is not closed has no material.
// Of several BREPs a point is in material if it is in any.
#pragma once

#include <string>

#include "core.hpp"

namespace feeler_oracle {

enum class InsideKind { Inside, Outside, Boundary, Undecided };

struct InsideAnswer {
    InsideKind kind;
    std::string why;  // of Undecided
};

InsideAnswer inside(const Core& core, const std::array<double, 3>& point);

}  // namespace feeler_oracle
