// A plane's axes as exact numbers: from points of space to parameters and back.
#pragma once

#include <array>

#include "exact.hpp"
#include "model.hpp"

namespace feeler_oracle {

using Q3 = std::array<Q, 3>;

inline Q3 exact(const std::array<double, 3>& a) { return {Q(a[0]), Q(a[1]), Q(a[2])}; }
inline Q dot(const Q3& a, const Q3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Q3 cross(const Q3& a, const Q3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Q3 minus(const Q3& a, const Q3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

struct Frame {
    Q3 origin, x, y, normal;
    Q normal2;
    const Plane* plane;

    explicit Frame(const Plane& p)
        : origin(exact(p.origin)),
          x(exact(p.x)),
          y(exact(p.y)),
          normal(cross(x, y)),
          normal2(dot(normal, normal)),
          plane(&p) {}

    // For w = a x + b y: a = (w x y).n / n.n, b = (x x w).n / n.n.
    std::array<Q, 2> coordinates(const Q3& w) const {
        return {dot(cross(w, y), normal) / normal2, dot(cross(x, w), normal) / normal2};
    }
    Q slope(int axis) const {
        const auto &d = plane->domain, &e = plane->extents;
        return (Q(d[2 * axis + 1]) - Q(d[2 * axis])) / (Q(e[2 * axis + 1]) - Q(e[2 * axis]));
    }
    Q parameter(int axis, const Q& a) const {
        return Q(plane->domain[2 * axis]) + (a - Q(plane->extents[2 * axis])) * slope(axis);
    }
};

}  // namespace feeler_oracle
