// What a face's region says of a part of a piece's box.
#pragma once

#include "distance_nets.hpp"

namespace feeler_oracle {

// A piece with its face's region and arcs.
struct PieceInRegion {
    const Piece& piece;
    const FacePieces& face;
};

// Of a part (local coordinates, in the box's unit square) of a box, in doubles.
BoxSide region_side(const PieceInRegion& s, const DyadicBox& box, const Interval64& x,
                    const Interval64& y);

// The surface's parameters of a part of a box of a Patch or Joint, enclosed.
std::array<Interval, 2> parameters(const Piece& s, const DyadicBox& box, const Interval& x,
                                   const Interval& y);

// Whether the region is known to hold the point (x, y) of the box. Exactly where the piece's
// parameters are linear in the surface's. Else the point is known in an interval only, and held
// where no arc meets that and the region holds the middle of it.
bool holds(const PieceInRegion& s, const DyadicBox& box, const Real& x, const Real& y);

// Like region_side, but not limited to the resolution of doubles: where no arc meets the part, the
// side of its point (x, y) is that of all of it. `held`: as holds(x, y).
BoxSide exact_side(const PieceInRegion& s, const DyadicBox& box, const Interval& ix,
                   const Interval& iy, const Real& x, const Real& y, bool& held);

}  // namespace feeler_oracle
