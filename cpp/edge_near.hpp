// Whether a point or a line comes near the images of edges.
//
// On a part of an image, D / W relative to the target's origin in Bernstein form with W > 0, and
// for any vector n (for a line: n perpendicular to it), n.D_i > r |n| W_i at all coefficients i
// proves that all of the part is farther than r: n.(D / W) is then above r |n|, and the distance is
// no less than n.(D / W) / |n|. |D_i| <= r W_i at all i proves that all of it is within r, balls
// and cylinders being convex; at the first or last i it proves so of a point of the image. What
// neither settles is halved. With n towards the part's middle the first test loses only what the
// part bends, so that the number of halvings is about log2(length / r) / 2 or less. First in
// doubles, then in Intervals.
#pragma once

#include <vector>

#include "distance_pieces.hpp"

namespace feeler_oracle {

struct NearTarget {
    std::array<Interval, 3> origin;
    enum Kind { Point, Line, Ray } kind = Point;
    std::array<double, 3> direction{};  // of a Line or Ray, not zero
};

enum class Near { No, Yes, Unknown };

// A part of an image that may be near a line.
struct NearPart {
    Interval t;  // where along the line
    Near near;   // Yes: some of it is, for certain
};

// Yes: the image has a point at distance <= radius.lo. No: all of it is farther than radius.hi.
// Unknown: neither could be told, or the distance is between the two. With `parts` all of the image
// is searched, and what is not proven to be farther than radius.hi is listed.
Near near_piece(const NearTarget& target, const Piece& piece, const Interval& radius,
                std::vector<NearPart>* parts = nullptr);

// Whether a piece is proven, in doubles alone, to be farther than `radius`.
bool clear_in_doubles(const NearTarget& target, const Piece& piece, double radius);

// A bound below the distance of the target from the box x0, x1, y0, y1, z0, z1 in doubles, for a
// Point; for a Line or Ray whether it misses the box widened by `radius`.
double box_distance(const std::array<double, 3>& point, const std::array<double, 6>& box);
bool line_misses(const NearTarget& target, const std::array<double, 6>& box, double radius);
// Likewise, of the box as it is, in Intervals where doubles cannot tell.
bool line_misses_exactly(const NearTarget& target, const std::array<double, 6>& box);

}  // namespace feeler_oracle
