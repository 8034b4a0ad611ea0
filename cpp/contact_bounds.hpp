// What the coefficients of A - T B prove of a box for a search of *all* local minimisers, which has
// no best value to discard by. See contacts.hpp; Net64 and the schemes are those of distance.hpp.
#pragma once

#include "distance_nets.hpp"

namespace feeler_oracle {

// Ranges of f over a box, in doubles; infinite where nothing is known.
Interval64 range_of(const Net64& n);
// [lo, hi] of the distance (or of n.x - h) from f's.
double rooted_down(const Objective& o, double f);
double rooted_up(const Objective& o, double f);

// -1, 1: the derivative of A - T B is negative, positive throughout, if it is off by no more than
// `blur`; 0: neither is proven.
int slope_sign(const Net64& n, Degrees d, bool along_u, const Interval64& t, double blur = 0);

// Second derivatives of A - tau B over a box, for all tau in T; that along u off by no more than
// `blur`.
struct Hessian {
    Interval64 uu, uv, vv;
    bool convex(Degrees d) const;
    // Below the least eigenvalue, if convex: determinant over trace.
    double least_eigenvalue(Degrees d) const;
    // Whether the second derivative along some direction is negative throughout; with `corner`,
    // only directions along the axes may be taken (the others may not enter the patch).
    bool falls(Degrees d, bool corner) const;
};
Hessian hessian(const Net64& n, Degrees d, const Interval64& t, double blur = 0);

// Whether A - tau B varies over the box by no more than the noise of doubles, tau = the least of f.
bool is_noise(const Net64& n, double tau);

}  // namespace feeler_oracle
