// Cuts a face into the pieces of distance_pieces.hpp.
#pragma once

#include "distance_pieces.hpp"

namespace feeler_oracle {

// Fills arcs, pieces and clamped; region and patches are there.
void fill_pieces(const Face& face, int index, FacePieces& out);

}  // namespace feeler_oracle
