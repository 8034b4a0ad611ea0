// Curves in space, cut into pieces of one kind each.
#pragma once

#include "model.hpp"

namespace feeler_oracle {

// (X / W, Y / W, Z / W) in Bernstein form over s in [0, 1]; W > 0.
struct BezierCurve3 {
    std::vector<Q> X, Y, Z, W;
    int degree() const { return int(W.size()) - 1; }
};

// The arc of `frame` where its angle runs from `start` to `end`, linearly over s in [0, 1];
// `frame` lives as long as the curve that was cut.
struct CircularArc3 {
    const Arc3* frame;
    Q start, end;
};

// Covers [t0, t1] of the whole curve's parameter, linearly as s runs over [0, 1].
struct CurveSpan {
    std::variant<BezierCurve3, CircularArc3> curve;
    Q t0, t1;
};

// One a segment of a polyline, a non-empty knot span, and an arc, in order; they cover the domain.
// Where two meet the curve may be less smooth, and in a poly-curve even jump.
std::vector<CurveSpan> curve_spans(const Curve3& curve);

// The domain of the parameter.
std::array<Q, 2> curve_domain(const Curve3& curve);

// Whether no piece is an arc.
bool is_rational(const Curve3& curve);

}  // namespace feeler_oracle
