// A rational curve in a patch's square, and which parts of it belong to the face's region.
//
// Membership can change only where the curve meets a loop or leaves the square: at roots of
// polynomials in one variable, isolated exactly. Between two neighbouring ones it is told by one
// rational point, exactly. Ends that are not told apart at 2^-256 of the curve count as one.
#pragma once

#include "bernstein.hpp"
#include "core.hpp"

namespace feeler_oracle {

// u = n(s) / d(s), v = s over s in [0, 1]; u and v exchanged if `swapped`. n and d have no common
// root.
struct PatchCurve {
    Bernstein n, d;
    bool swapped;
};

// s from the first to the last; the ends are enclosures.
struct CurveRun {
    Q first_lo, first_hi, last_lo, last_hi;
    bool boundary;  // all of it is on a loop
    bool is_point() const { return first_lo == last_lo && first_hi == last_hi; }
};

// The parts of the curve in the square that belong to the region, in order, cut also at the roots
// of `cuts`. False where that could not be told.
bool runs_in_region(const PreparedFace& face, const RationalBezierPatch& patch,
                    const PatchCurve& curve, const Bernstein& cuts, std::vector<CurveRun>& runs);

// Parts of the parameters [0, 1] of a curve outside of which it is away from the box (exact
// coordinates), and in which it is within the larger box. Empty: it is away from it. Nothing where
// that takes too many parts.
std::optional<std::vector<std::pair<Q, Q>>> near_box(const RationalBezierCurve& curve,
                                                     const std::array<Q, 4>& box,
                                                     const std::array<Q, 4>& larger);

// x, y of a loop's arc in the patch's square, times w.
struct LocalArc {
    Bernstein x, y, w;
};
LocalArc local_arc(const RationalBezierCurve& arc, const RationalBezierPatch& patch);

}  // namespace feeler_oracle
