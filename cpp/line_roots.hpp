// The common roots of two bivariate polynomials: where a line meets a patch.
//
// The line is cut out by two planes; on a patch each is a polynomial in Bernstein form, F1 and F2.
// Boxes are halved and discarded where the hull of F1, F2, or of a combination that removes one
// variable to first order, excludes zero. On a box enlarged by half its size to each side the
// Krawczyk operator K = m - Y F(m) + (I - Y J)(X - m), Y about J(m)^-1, inside the box proves
// exactly one root there, a simple one (R. Krawczyk 1969; A. Neumaier, "Interval Methods for
// Systems of Equations", 1990, theorem 5.1.8); iterating K narrows it.
#pragma once

#include <array>
#include <vector>

#include "net.hpp"

namespace feeler_oracle {

struct PatchRoot {
    // u0, u1, v0, v1 in the patch's own square: the root is here ...
    std::array<Real, 4> box;
    // ... and is the only one here.
    std::array<Real, 4> unique;
    int orientation;  // sign of det J
};

struct PatchRoots {
    std::vector<PatchRoot> roots;
    // Boxes that could not be settled: more roots may be here, and only here.
    std::vector<std::array<Real, 4>> open;
    long boxes = 0;
};

// All roots in [area0, area1] x [area2, area3] (the unit square, or more by at most 1/2 to each
// side); those just outside may be among them.
PatchRoots patch_roots(const Net& f1, const Net& f2, const std::array<double, 4>& area,
                       long budget);

}  // namespace feeler_oracle
