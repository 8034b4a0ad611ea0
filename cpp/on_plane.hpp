// Points exactly on a planar face.
#pragma once

#include <array>

#include "core.hpp"

namespace feeler_oracle {

// A planar face of which c is a point, exactly, or -1: then the distance is 0 to the last bit,
// which no search by intervals can show, since its objective is the square.
int planar_face_at(const Core& core, const std::array<double, 3>& c);

}  // namespace feeler_oracle
