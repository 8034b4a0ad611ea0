// What the oracle is given: raw control data and topology, every double an exact number; and the
// exact Bezier pieces made of it.
#pragma once

#include <array>
#include <optional>
#include <variant>
#include <vector>

#include "exact.hpp"

namespace feeler_oracle {

// origin + a x + b y; a runs over extents[0..1] as u runs over domain[0..1], linearly, and b over
// extents[2..3] as v over domain[2..3].
struct Plane {
    std::array<double, 3> origin, x, y;
    std::array<double, 4> domain;   // u0, u1, v0, v1
    std::array<double, 4> extents;  // a0, a1, b0, b1
};

// n + p + 2 knots for n + 1 control points (The NURBS Book). Domain [knots[p], knots[n + 1]].
struct NurbsSurface {
    int degree_u, degree_v;
    std::vector<double> knots_u, knots_v;
    std::vector<double> net;  // (wx, wy, wz, w) of point (i, j) at 4 (i count_v + j)

    int count_u() const { return int(knots_u.size()) - degree_u - 1; }
    int count_v() const { return int(knots_v.size()) - degree_v - 1; }
};

using Surface = std::variant<NurbsSurface, Plane>;

// Points joined by straight segments, point i at params[i]; a line is one of two points.
struct Polyline {
    std::vector<double> points;  // (u, v) of point i at 2 i
    std::vector<double> params;
};

struct NurbsCurve2 {
    int degree;
    std::vector<double> knots;
    std::vector<double> points;  // (wu, wv, w) of point i at 3 i
};

using CurvePiece = std::variant<Polyline, NurbsCurve2>;

// Piece i, run over its own domain, covers [params[i], params[i + 1]] linearly. A curve that is no
// poly-curve is one piece over its own domain. Used over [start, end], backwards if reversed.
struct TrimCurve {
    std::vector<CurvePiece> pieces;
    std::vector<double> params;
    double start, end;
    bool reversed;
    int edge;  // index into the model's edges, -1 for a singular trim
};

struct Loop {
    std::vector<TrimCurve> trims;
};

struct Face {
    Surface surface;
    std::optional<std::vector<Loop>> loops;  // none: the whole domain; empty: nothing
    bool reversed;
    int brep;
};

struct Model {
    std::vector<Face> faces;
    std::vector<bool> closed;  // of each BREP: every non-singular edge is used exactly twice
    int edges = 0;             // of all BREPs
};

// (X / W, Y / W) in Bernstein form over t in [0, 1]; W > 0.
struct RationalBezierCurve {
    std::vector<Q> X, Y, W;
    int degree() const { return int(W.size()) - 1; }
};

// (X / W, Y / W, Z / W) in Bernstein form over [0, 1]^2, coefficient (i, j) at i (q + 1) + j, i
// along u; W > 0. The unit square is the box u0..u1, v0..v1 of the surface's domain.
struct RationalBezierPatch {
    int p, q;
    std::vector<Q> X, Y, Z, W;
    Q u0, u1, v0, v1;
};

// u0, u1, v0, v1.
std::array<Q, 4> surface_domain(const Surface& surface);

// One patch a non-empty pair of knot spans; of a plane one bilinear patch over its domain.
std::vector<RationalBezierPatch> bezier_patches(const Surface& surface);

// The used part of a trim curve, in the direction of the trim. Cuts at the ends of the span are
// exact. Successive pieces meet, but for the inner ends of a poly-curve that do not.
std::vector<RationalBezierCurve> bezier_pieces(const TrimCurve& trim);

// The matrix (rows k = 0..p) that takes the p + 1 control points i-p..i of span
// [knots[i], knots[i + 1]) to the Bernstein coefficients over [a, b]: row k holds the weights of
// the blossom f(a, .., a, b, .., b), b taken k times (L. Ramshaw, "Blossoms are polar forms",
// 1989).
std::vector<std::vector<Q>> blossom_matrix(int degree, const std::vector<double>& knots, int span,
                                           const Q& a, const Q& b);

// Index i of the span [knots[i], knots[i + 1]) that holds t; the last one is closed.
int find_span(int degree, const std::vector<double>& knots, const Q& t);

// A point and first derivatives, exactly. At a knot the derivative is that of find_span's span.
struct ExactEvaluation {
    std::array<Q, 3> point, du, dv;
};
ExactEvaluation evaluate(const Surface& surface, const Q& u, const Q& v);

}  // namespace feeler_oracle
