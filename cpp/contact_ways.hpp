// Ways down from a box and walls around it: what decides whether a candidate is a contact. See
// contacts.hpp for the definitions.
//
// fall. Start at a uv point q0 (on the loop, about), and let w be a step in uv. If
// (1) the segment from q0 + s0 w to q0 + w keeps clear of all loops (in boxes that cover it) and
//     its end is not outside the region, exactly: then none of it is;
// (2) on the segment f rises by no more than bounds of grad f . w add up to, over boxes that cover
//     it and every patch that meets them, and the lengths by which the surface jumps (f is
//     piecewise smooth; where a surface's curves do not quite meet the path jumps, by far less
//     than `join`, once at most across each line, as the segment runs one way in u and in v);
// (3) the point of q0 + s0 w is so near to all points of K that the length of that jump and the
//     rise of (2) are together less than `join`;
// (4) f at its end is below K's lo by more than `join`,
// then from each point of K a jump and this path lead down: no contact is in K.
//
// walled. f > bound at all points of F whose distance from K is in [near, far]: by branch and bound
// over the patches, of which boxes outside the region do not count.
#pragma once

#include <array>
#include <vector>

#include "contact_bounds.hpp"
#include "contact_model.hpp"

namespace feeler_oracle {

class Ways {
 public:
    // The pieces must live as long as this.
    Ways(const AllPieces& model, const Objective& objective, double join, long budget);

    // Places of the other images of the place's edge that are next to it.
    std::vector<Place> partners(const Place& place) const;

    bool falls(const Place& place, const std::array<double, 6>& k, double lo);
    bool walled(const std::array<double, 6>& k, double hi, double near, double far);

    bool spent() const { return left_ <= 0; }

 private:
    Interval64 slope(const Local& at, const Interval64& wu, const Interval64& wv) const;
    bool falls_along(const Place& q, double su, double sv, double start,
                     const std::array<double, 6>& k, double lo);
    Interval64 value(const Local& at) const;

    const AllPieces& model_;
    const Objective o_;
    const double join_;
    long left_;
};

}  // namespace feeler_oracle
