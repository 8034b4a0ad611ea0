#include "arc_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace feeler_oracle {
namespace {

std::array<Q, 4> hull_of(const RationalBezierCurve& c) {
    std::array<Q, 4> h;
    for (std::size_t i = 0; i < c.W.size(); ++i) {
        const Q u = c.X[i] / c.W[i], v = c.Y[i] / c.W[i];
        if (i == 0 || u < h[0]) h[0] = u;
        if (i == 0 || u > h[1]) h[1] = u;
        if (i == 0 || v < h[2]) h[2] = v;
        if (i == 0 || v > h[3]) h[3] = v;
    }
    return h;
}

}  // namespace

// With e = 2^-53, in any rounding mode: a product is off by at most 2 e of itself or the
// smallest subnormal, the sum by 2 e of itself; 8 e of |a u| + |b v| and eight subnormals cover
// all of it, their own rounding included.
std::pair<double, double> strip_range(double a, double b, const Box& box) {
    const double au0 = a * box.u0, au1 = a * box.u1, bv0 = b * box.v0, bv1 = b * box.v1;
    const double magnitude =
        std::max(std::abs(au0), std::abs(au1)) + std::max(std::abs(bv0), std::abs(bv1));
    const double slack = magnitude * 4 * std::numeric_limits<double>::epsilon() +
                         8 * std::numeric_limits<double>::denorm_min();
    return {std::min(au0, au1) + std::min(bv0, bv1) - slack,
            std::max(au0, au1) + std::max(bv0, bv1) + slack};
}

ArcNode::ArcNode(RationalBezierCurve c) : curve(std::move(c)), hull(hull_of(curve)) {
    box = {double_bounds(hull[0]).first, double_bounds(hull[1]).second,
           double_bounds(hull[2]).first, double_bounds(hull[3]).second};
    size_u = double_bounds(hull[1] - hull[0]).second;
    size_v = double_bounds(hull[3] - hull[2]).second;
    // Any direction is valid; the chord's normal is the useful one. Normalised so that it
    // neither overflows nor vanishes.
    a = -double_bounds(end_v(1) - end_v(0)).first;
    b = double_bounds(end_u(1) - end_u(0)).first;
    const double scale = std::max(std::abs(a), std::abs(b));
    if (scale > 0 && std::isfinite(1 / scale) && std::isfinite(scale)) {
        a /= scale;
        b /= scale;
    } else {
        a = 1;
        b = 0;
    }
    strip_lo = std::numeric_limits<double>::infinity();
    strip_hi = -strip_lo;
    for (std::size_t i = 0; i < curve.W.size(); ++i) {
        const auto u = double_bounds(curve.X[i] / curve.W[i]),
                   v = double_bounds(curve.Y[i] / curve.W[i]);
        const auto r = strip_range(a, b, {u.first, u.second, v.first, v.second});
        strip_lo = std::min(strip_lo, r.first);
        strip_hi = std::max(strip_hi, r.second);
    }
}

ArcNode& ArcNode::child(int k) {
    if (!children[0]) {
        RationalBezierCurve left, right;
        halve(curve.X, left.X, right.X);
        halve(curve.Y, left.Y, right.Y);
        halve(curve.W, left.W, right.W);
        children[0] = std::make_unique<ArcNode>(std::move(left));
        children[1] = std::make_unique<ArcNode>(std::move(right));
    }
    return *children[k];
}

Q ArcNode::end_u(int end) const {
    return end ? curve.X.back() / curve.W.back() : curve.X.front() / curve.W.front();
}

Q ArcNode::end_v(int end) const {
    return end ? curve.Y.back() / curve.W.back() : curve.Y.front() / curve.W.front();
}

namespace {

bool disjoint(const ArcNode& arc, const QueryBox& b) {
    if (arc.box.u0 > b.box.u1 || arc.box.u1 < b.box.u0 || arc.box.v0 > b.box.v1 ||
        arc.box.v1 < b.box.v0)
        return true;
    const auto range = strip_range(arc.a, arc.b, b.box);
    if (range.first > arc.strip_hi || range.second < arc.strip_lo) return true;
    if (b.q) {
        const auto &h = arc.hull, &q = *b.q;
        return h[0] > q[1] || h[1] < q[0] || h[2] > q[3] || h[3] < q[2];
    }
    return false;
}

bool end_inside(const ArcNode& arc, const QueryBox& b) {
    // Inward is not needed: a wrong yes only makes the answer Mixed.
    for (int end = 0; end < 2; ++end) {
        const auto u = double_bounds(arc.end_u(end)), v = double_bounds(arc.end_v(end));
        if (b.box.u0 <= u.first && u.second <= b.box.u1 && b.box.v0 <= v.first &&
            v.second <= b.box.v1)
            return true;
    }
    return false;
}

// Bounds the recursion; 2^-200 of an arc is far below what any root box reaches.
constexpr int kDeepest = 200;
// Below 2^-60 of an arc a box of doubles cannot be told apart from it any better.
constexpr int kDeepestDouble = 60;

bool clear_of(ArcNode& arc, const QueryBox& b, int depth) {
    if (disjoint(arc, b)) return true;
    // A box that is flat in one direction is judged by the other.
    const double larger = std::max(b.size_u, b.size_v);
    const bool small = std::max(arc.size_u, arc.size_v) <= 0.5 * larger &&
                       (b.size_u == 0 || b.size_v == 0 ||
                        (arc.size_u <= 0.5 * b.size_u && arc.size_v <= 0.5 * b.size_v));
    if (small || depth == 0) return false;
    if (!b.q && end_inside(arc, b)) return false;
    return clear_of(arc.child(0), b, depth - 1) && clear_of(arc.child(1), b, depth - 1);
}

}  // namespace

bool clear_of(ArcNode& arc, const QueryBox& box) {
    return clear_of(arc, box, box.q ? kDeepest : kDeepestDouble);
}

std::array<Q, 4> QueryBox::exact() const {
    if (q) return *q;
    return {Q(box.u0), Q(box.u1), Q(box.v0), Q(box.v1)};
}

}  // namespace feeler_oracle
