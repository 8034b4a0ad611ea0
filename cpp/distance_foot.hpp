// Items 3 and 4 of distance.hpp: what Newton's iteration proves of a box.
#pragma once

#include <array>
#include <optional>

#include "distance_bounds.hpp"

namespace feeler_oracle {

struct Foot {
    Real x, y;  // a point of the unit square
    Real t;     // above f(x, y)
    Real lo;    // below f on the box (item 3)
    // A - tau B is strictly convex on the box for all tau in [lo, best], in some parameters of it;
    // then a minimiser is no farther than `radius` from (x, y) in these, and lies in `around`,
    // which holds (x, y) (item 4). Not told of points.
    bool convex = false;
    Real radius;
    std::array<Interval, 2> around;
};

// `lo` is below f on the box, `best` at or above the value of each minimiser in question. None
// where the bound cannot be better than `lo`. `far`: weights may be far apart.
std::optional<Foot> foot(const NetMp& net, Degrees d, const Real& lo, const Real& best, bool far);

}  // namespace feeler_oracle
