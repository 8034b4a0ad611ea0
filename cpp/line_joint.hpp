// How a line meets a surface where patches join: from what each patch says of the one point.
#pragma once

#include <optional>
#include <vector>

#include "bipoly.hpp"
#include "line_roots.hpp"

namespace feeler_oracle {

// A patch's view of a root exactly on one of its sides (or two).
struct JointView {
    PatchRoot root;
    int axis = 0;        // the side is 0: u = const, 1: v = const, 2: both, a corner
    bool after = false;  // the patch goes on from the joint in the direction of its parameter
    // The signs of both forms' derivatives along the joint, at the root; 0: not known, or 0.
    std::array<int, 2> along = {0, 0};
};

// Both forms over the patch, with coefficients in Bernstein form; `at` is the box of the root.
std::array<int, 2> signs_along(int axis, int p, int q, const std::vector<Q>& f1,
                               const std::vector<Q>& f2, const std::array<Real, 4>& at);

// Whether the line passes from one side of the surface to the other; nothing where that is not
// proven. `views` are those of all patches about the point, each once.
std::optional<bool> passes(const std::vector<JointView>& views);

}  // namespace feeler_oracle
