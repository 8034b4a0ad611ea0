// The common roots of two bivariate polynomials: where a line meets a patch.
//
// The line is cut out by two planes; on a patch each is a polynomial in Bernstein form, F1 and F2.
// Boxes are halved and discarded where the hull of F1, F2, or of a combination that removes one
// variable to first order, excludes zero. On a box enlarged by half its size to each side the
// Krawczyk operator K = m - Y F(m) + (I - Y J)(X - m), Y about J(m)^-1, inside the box proves
// exactly one root there, a simple one (R. Krawczyk 1969; A. Neumaier, "Interval Methods for
// Systems of Equations", 1990, theorem 5.1.8); iterating K narrows it. Where the two gradients are
// nearly parallel, at a tangency or next to one, boxes would be halved without end: there the exact
// polynomials are looked at along the curve that one of them makes (arc_roots.hpp), which tells all
// roots of a box with their multiplicities.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "bipoly.hpp"
#include "net.hpp"

namespace feeler_oracle {

struct PatchRoot {
    // u0, u1, v0, v1 in the patch's own square: the root is here ...
    std::array<Real, 4> box;
    // ... and is the only one here.
    std::array<Real, 4> unique;
    // Sign of det J, or of the first derivative of one polynomial along the curve of the other that
    // is not 0.
    int orientation;
    int multiplicity = 1;
    // Of a multiple root: the polynomial that makes the curve, 1 or 2.
    int curve = 0;
};

struct PatchRoots {
    std::vector<PatchRoot> roots;
    // Boxes that could not be settled: more roots may be here, and only here.
    std::vector<std::array<Real, 4>> open;
    // Boxes of which all roots are known.
    std::vector<std::array<Real, 4>> settled;
    // The two polynomials may have a factor in common: nothing was looked for.
    bool common_factor = false;
};

// F1 and F2 exactly, in power basis.
struct ExactForms {
    BiPoly f1, f2;
};

// All roots in [area0, area1] x [area2, area3] (the unit square, or more by at most 1/2 to each
// side); those just outside may be among them. `exact` is called when it is first needed; it may be
// empty, and then tangencies stay open. The budget counts boxes, and what costs as much; it is
// taken from.
PatchRoots patch_roots(const Net& f1, const Net& f2, const std::array<double, 4>& area,
                       long& budget, const std::function<ExactForms()>& exact);

}  // namespace feeler_oracle
