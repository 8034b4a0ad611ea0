// Images of pieces of trim curves in space, as rational Bezier curves.
//
// Exactly (the image is one choice of coefficients within the intervals) where
// - both parameters of the patch are linear (NURBS, planes, sums without arcs): by composition;
// - one parameter of the curve is constant: then the image is a line of constant parameter of the
//   patch. Where the other one goes by an angle and runs one way, the piece is run through at
//   another speed, which changes no distance: the part of that line between the images of its ends.
//
// Else S(c(t)) is no quotient of polynomials, as cosines of polynomials come in, or one of a degree
// (or with weights) that is no use. It is replaced by
// a polynomial g of degree kOrder: with sigma = 2 t - 1, g is the Taylor polynomial of S(c) at
// sigma = 0, by the arithmetic of truncated series, and |S(c) - g| <= |c_{kOrder+1}| in each
// coordinate, where c_{kOrder+1} encloses the next Taylor coefficient at *all* sigma of [-1, 1]
// (Lagrange), by the same arithmetic with intervals as the point of expansion. The curve is halved
// until that is below 2^-kSlackBits of the patch's size. In this arithmetic the turn's quadratic is
// used in the form
//     X = sum C(2, i) X_i sin^i(alpha) sin^{2-i}(h - alpha), alpha = phi / 2,
// which is the one of native_patch.hpp with (s, 1 - s) ~ (sin alpha, sin(h - alpha)): entire.
//
// `slack` is a bound on |S(c) - g|. Distances to g are within slack of those to the image; what is
// said of derivatives is said of g.
#pragma once

#include <optional>
#include <vector>

#include "native_patch.hpp"

namespace feeler_oracle {

// (X / W, Y / W) in Bernstein form over [0, 1] in uv, enclosed; exactly too where it is rational.
struct UvCurve {
    std::array<std::vector<Interval>, 3> c;  // X, Y, W
    std::optional<RationalBezierCurve> exact;
    int degree() const { return int(c[2].size()) - 1; }
};

UvCurve uv_curve(const RationalBezierCurve& curve);
// Circular arcs in pieces of less than a quarter turn, `at` their ends in the arc's parameter
// (one more than pieces), with seven radians at most; segments with irrational ends. One piece
// for a rational curve.
struct UvPieces {
    std::vector<UvCurve> pieces;
    std::vector<Q> at;
};
UvPieces uv_curves(const RegionArc& arc);

// Over [a, b] of [0, 1].
UvCurve part_of(const UvCurve& curve, const Q& a, const Q& b);

// The piece [a, b] of the curve's parameter.
struct TrimImage {
    Q a, b;
    int degree;
    HomogeneousNet net;
    double slack;
};

// Of a curve that runs in the closed patch. In order along it.
// Throws std::runtime_error where no bound on the slack is found.
std::vector<TrimImage> trim_images(const NativePatch& patch, const UvCurve& curve);

// The image of a box of the patch's own square, enclosed: X, Y, Z, W.
std::array<Interval, 4> point_at(const NativePatch& patch, const Interval& s, const Interval& t);

constexpr int kOrder = 24;
constexpr int kSlackBits = 150;

}  // namespace feeler_oracle
