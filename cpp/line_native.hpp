// A line and a face whose surface is a revolution or a sum with arcs.
//
// The patches are those of native_patch.hpp, so the two planes through the line make two
// polynomials on each patch's square whose coefficients are enclosed; the true ones are *one*
// choice within. Exclusion and Krawczyk's operator (line_roots.hpp) hold for every choice: a
// certified root is one simple root of the true forms, so the line crosses the surface there
// (multiplicity 1, transversal). Where the forms touch, nothing is certified: what is left is open.
//
// Where the surface lies in a quadric (line_quadric.hpp), its discriminant along the line tells
// exactly whether they meet. Where it is 0 they touch in one rational point X, unless X is the tip
// of a cone. Whether X is in the face is asked with another line, through X along the quadric's
// normal as rounded: that meets the quadric at 0 and at one other parameter, so a certified root on
// a patch whose parameter holds 0, and not the other, is X; and X, if on a patch, is such a root.
// Likewise a hit is at t = 0 exactly where the line starts on the quadric.
//
// Where a root is not told from a side of the patch's square:
// - A cut inside one turn (one arc, or the angle of a revolution): both patches are one analytic
//   surface, and a root of one's forms beyond its side is one of the other's. In the surface's own
//   parameters the region where the first is alone holds the second: they are one hit.
// - A side on the domain's border: where coefficients of a form are points, they are exact. If both
//   forms are exact on the side, so is the question for a common root. If one is 0 there, and the
//   other one changes its sign along the side within the region where the root is alone, that zero
//   is the root. So it is where a line meets the seam of a surface about an axis of coordinates, in
//   the seam's plane.
// - Else it is open.
// The two ends of a full turn are two lines of the surface some 1e-16 apart: 2 pi is no double.
//
// A pole is an end of a profile's piece that is exactly known and exactly on the axis. Where the
// line passes it, which rational numbers tell, the forms vanish on that side: it is one hit, and
// they are divided by the distance from the side.
#pragma once

#include "line.hpp"

namespace feeler_oracle {

void line_hits_native(const Core& core, int index, const Line& line, long& budget,
                      LineAnswer& answer);

}  // namespace feeler_oracle
