// Quadrics that hold native surfaces, with rational coefficients in the stored data.
//
// - A revolution of an arc whose center is on the axis: |X - center|^2 = radius^2, whatever the
//   arc's frame.
// - A revolution of a segment P(s) = P0 + s D that is not orthogonal to the axis a through O:
// turning
//   keeps a.(X - O) and |X - O|, so with s from a.(X - O) = a.(P(s) - O), linear in X,
//   |X - O|^2 = |P(s) - O|^2.
// - A sum of an arc about z and a segment along D, z.D not 0: Y = X - C - s D with s from z.Y = 0
//   is in the circle's plane, relative to its center: |Y|^2 = radius^2.
// The axis need not be normalised. So how a line meets the quadric is told by a polynomial of
// degree 2 in t, exactly. The line meets the face nowhere else.
#pragma once

#include <optional>

#include "model.hpp"

namespace feeler_oracle {

using Q3 = std::array<Q, 3>;

// F(origin + t direction) = c + b t + a t^2.
struct Quadratic {
    Q a, b, c;
};

// |m|^2 - |n|^2 = k, where m and n are affine in X.
struct Quadric {
    struct Affine {
        Q3 constant;
        std::array<Q3, 3> of;  // of[k]: what coordinate k of X is multiplied with
        Q3 at(const Q3& x, bool linear_part) const;
    };
    Affine m, n;
    Q k;
    Quadratic along(const Q3& origin, const Q3& direction) const;
};

// If the surface is one of these.
std::optional<Quadric> quadric_of(const Surface& surface);

}  // namespace feeler_oracle
