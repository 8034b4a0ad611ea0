// The certified minimum, over the union of trimmed faces, of the distance to a point, or of n.x -
// h.
//
// Method: best-first branch and bound over Pieces (distance_pieces.hpp says why they suffice), in
// doubles first, in kBits-bit intervals then. With A / B the objective on a piece in Bernstein
// form, B > 0 (A = |X - c W|^2, B = W^2, or A = n.X - h W, B = W):
//
// 1. f >= min A_ij / B_ij on a box, as A - t B has coefficients >= 0 for that t.
// 2. Let T = [lower bound of the box, best upper bound so far]. A minimiser in the box has its
//    value tau in T, and derivative zero where the kinds (b2), (b1), (a) say so; and
//    B grad f = grad A - f grad B = grad(A - tau B) there. So if a first difference of A - T B (T
//    an interval) has a strict sign throughout, the box goes.
// 3. With t any number, x any point of the box (unit square), h = A - t B, g = grad h(x), and L a
//    bound on -(y - x)^T H (y - x) / 2 for all Hessians H of h on the box and all y in it (H from
//    second differences of the nets; where one diagonal entry is positive the square is completed),
//    h >= h(x) + g.(y - x) - L on the box; hence f >= t + min(0, that) / min B. With x from
//    Newton's iteration and t = f(x) this closes regular minima to the last bits; existence or
//    uniqueness of a critical point is not needed for it. Form for lines: h(u, v) = sum_i B_i(u)
//    h_i(v), h_i the polynomial of row i of the net. If all h_i are convex, each is above its
//    tangent at x, so h is above the least of these over i and v. This closes valleys along u: seen
//    from the axis of a revolution, all h_i touch zero at one v.
// 4. If A - tau B is strictly convex on the box for all tau in T (cut by item 3), with constant m >
//    0, and z is a minimiser in the box that item 2 speaks of, then h_tau (tau = f(z)) has its
//    least value 0 at z: z is the only one, tau <= f(x) <= t, and m |x - z| <= |grad h_tau(x)| <=
//    |g| + (t - tau) |grad B(x)|, where t - tau is bounded by item 3. The box around x of that
//    radius is put to the region: if it lies outside, the box goes whole; if inside, t is an upper
//    bound; if neither is proven, the lower bound stays and x itself is classified exactly.
//
// Points with f below the truth that lie outside the region are thus removed only by exact
// decisions.
#pragma once

#include <array>

#include "distance_pieces.hpp"

namespace feeler_oracle {

enum class DistanceStatus {
    Regular,       // attained at isolated convex minima inside faces
    EdgeOrCorner,  // likewise, but on trim curves or joints
    IntervalOnly,  // [lo, hi] as narrow as asked, and no claim on where it is attained
    Budget,        // [lo, hi] holds, but is wider than asked
};

struct DistanceAnswer {
    Real lo, hi;
    DistanceStatus status = DistanceStatus::Budget;
    int face = -1;     // a face on which hi is attained, -1 if unknown
    long nodes64 = 0;  // boxes bounded in doubles
    long nodes = 0;    // boxes bounded in MPFR
};

// In boxes of a bicubic patch: what has more coefficients counts for more, so that this bounds
// the time.
struct DistanceBudget {
    double nodes64 = 200000;
    double nodes = 20000;
};

// Of the distance from c to the union of the faces. Without any face: both ends infinite.
// Preconditions: c finite, weights positive.
DistanceAnswer distance(const Pieces& model, const std::array<double, 3>& c,
                        const DistanceBudget& budget = {});

// Of min n.x - h over the union of the faces.
DistanceAnswer support(const Pieces& model, const std::array<double, 3>& n, double h,
                       const DistanceBudget& budget = {});

// The width asked for, relative to the model's size, is 2^-kWidthBits.
constexpr int kWidthBits = 120;

}  // namespace feeler_oracle
