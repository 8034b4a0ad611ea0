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

// Points joined by straight segments, point i at params[i]; a line is one of two points.
struct Polyline3 {
    std::vector<double> points;  // (x, y, z) of point i at 3 i
    std::vector<double> params;
};

struct NurbsCurve3 {
    int degree;
    std::vector<double> knots;
    std::vector<double> points;  // (wx, wy, wz, w) of point i at 4 i
};

// center + radius (cos a x' + sin a y'), a running over `angle` as the parameter runs over
// `domain`, linearly. z' is z exactly normalised, x' is x made exactly orthogonal to z' and
// normalised, y' = z' x x'. Angles in radians, within +-kMaxAngle.
struct Arc3 {
    std::array<double, 3> center, x, z;
    double radius;
    std::array<double, 2> angle, domain;
};

using CurvePiece3 = std::variant<Polyline3, NurbsCurve3, Arc3>;

// Piece i, run over its own domain, covers [params[i], params[i + 1]] linearly. A curve that is no
// poly-curve is one piece over its own domain.
struct Curve3 {
    std::vector<CurvePiece3> pieces;
    std::vector<double> params;
};

// `profile` turned about the axis through `origin` along `axis` (exactly normalised),
// right-handed, by the angle a; a runs over `angle` as the angular parameter runs over
// `angle_domain`, linearly. Not transposed, u is the angular parameter and v the profile's.
struct Revolution {
    std::array<double, 3> origin, axis;
    std::array<double, 2> angle, angle_domain;
    Curve3 profile;
    bool transposed;
};

// S(u, v) = base + first(u) + second(v).
struct SumSurface {
    std::array<double, 3> base;
    Curve3 first, second;
};

// The largest angle of arcs and revolutions.
constexpr double kMaxAngle = 0x1p30;

using Surface = std::variant<NurbsSurface, Plane, Revolution, SumSurface>;

// Whether the surface is made of rational Bezier patches: NURBS, planes, and sums of curves
// without arcs.
bool is_rational(const Surface& surface);

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

// center + radius (cos a x' + sin a y'), a running over `angle` as the parameter runs over
// `domain`, linearly. x' is x exactly normalised; y' is x' turned by +90 degrees, or by -90 where y
// lies on that side of x. Angles in radians, within +-kMaxAngle.
struct Arc2 {
    std::array<double, 2> center, x, y;
    double radius;
    std::array<double, 2> angle, domain;
};

using CurvePiece = std::variant<Polyline, NurbsCurve2, Arc2>;

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

// center + radius (cos a x' + sin a y') with x' = x / |x| and y' = x' turned by +90 degrees, by -90
// if `clockwise`.
struct Circle {
    std::array<Q, 2> center, x;
    Q radius;
    bool clockwise;
};

// The part of a circle where a runs from `start` to `end` (either may be the larger), linearly over
// t in [0, 1]. It may be many turns: the points are those of the first seven radians then.
struct CircularArc {
    Circle circle;
    Q start, end;
};

// The point of a circle at a (rational) angle a. Unless a = 0 no line with algebraic coefficients
// holds it: by the theorem of Lindemann and Weierstrass e^(ia), e^(-ia) and 1 are linearly
// independent over the algebraic numbers for algebraic a != 0, and so are cos a, sin a and 1.
// At a = 0 it is center + radius x / |x|, which is irrational where |x| is.
struct CirclePoint {
    Circle circle;
    Q angle;
};

// An exactly known point of uv.
using EndPoint = std::variant<std::array<Q, 2>, CirclePoint>;

// The straight segment, from t = 0 to 1, between two points that are not both rational.
struct Segment {
    EndPoint from, to;
};

// What the boundary of a region is made of.
using RegionArc = std::variant<RationalBezierCurve, CircularArc, Segment>;

// The point at t = 0 or t = 1; rational wherever it is.
EndPoint end_point(const RegionArc& arc, bool last);

// (X / W, Y / W, Z / W) in Bernstein form over [0, 1]^2, coefficient (i, j) at i (q + 1) + j, i
// along u; W > 0. The unit square is the box u0..u1, v0..v1 of the surface's domain.
struct RationalBezierPatch {
    int p, q;
    std::vector<Q> X, Y, Z, W;
    Q u0, u1, v0, v1;
};

// u0, u1, v0, v1.
std::array<Q, 4> surface_domain(const Surface& surface);

// One patch a non-empty pair of knot spans; of a plane one bilinear patch over its domain; of a
// sum one a pair of spans (or segments) of its curves. Precondition: is_rational(surface).
std::vector<RationalBezierPatch> bezier_patches(const Surface& surface);

// The used part of a trim curve, in the direction of the trim. Cuts at the ends of the span are
// exact. Successive pieces meet, but for the inner ends of a poly-curve that do not.
std::vector<RegionArc> uv_pieces(const TrimCurve& trim);

// Weights of the p + 1 control points i-p..i of span [knots[i], knots[i + 1]) in the blossom at
// the p arguments.
std::vector<Q> blossom_weights(int degree, const std::vector<double>& knots, int span,
                               const std::vector<Q>& arguments);

// The matrix (rows k = 0..p) that takes the p + 1 control points i-p..i of span
// [knots[i], knots[i + 1]) to the Bernstein coefficients over [a, b]: row k holds the weights of
// the blossom f(a, .., a, b, .., b), b taken k times (L. Ramshaw, "Blossoms are polar forms",
// 1989).
std::vector<std::vector<Q>> blossom_matrix(int degree, const std::vector<double>& knots, int span,
                                           const Q& a, const Q& b);

}  // namespace feeler_oracle
