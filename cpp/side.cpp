#include "side.hpp"

#include <algorithm>
#include <stdexcept>

#include "arc_tree.hpp"
#include "roots.hpp"
#include "uv_curve.hpp"

namespace feeler_oracle {
namespace {

bool along_border(const RationalBezierCurve& c, const std::array<Q, 4>& domain) {
    for (int side = 0; side < 4; ++side) {
        const auto& coordinate = side < 2 ? c.X : c.Y;
        bool on = true;
        for (std::size_t i = 0; on && i < c.W.size(); ++i)
            on = coordinate[i] == domain[side] * c.W[i];
        if (on) return true;
    }
    return false;
}

// A query point with outward doubles for the filters.
struct Point {
    const Q &u, &v;
    std::pair<double, double> du, dv;
};

// After so many halvings of an arc the algebraic kernel decides: each halving is about a hundred
// times cheaper than isolating roots, and points at random are settled by the first few.
constexpr int kHalvings = 12;

bool above(const ArcNode& arc, int end, const Q& v) {
    const auto& c = arc.curve;
    const std::size_t i = end ? c.W.size() - 1 : 0;
    return c.Y[i] > v * c.W[i];
}

Passage node_passage(ArcNode& arc, const Point& q, int halvings) {
    if (arc.box.v0 > q.dv.second || arc.box.v1 < q.dv.first || arc.box.u1 < q.du.first)
        return Passage::Even;
    if (arc.box.u0 > q.du.second)
        return above(arc, 0, q.v) != above(arc, 1, q.v) ? Passage::Odd : Passage::Even;
    if (halvings == 0 || arc.curve.degree() == 1) {
        std::vector<Q> f, g;
        for (std::size_t i = 0; i < arc.curve.W.size(); ++i) {
            f.push_back(arc.curve.Y[i] - q.v * arc.curve.W[i]);
            g.push_back(arc.curve.X[i] - q.u * arc.curve.W[i]);
        }
        return passage(f, g);
    }
    bool odd = false;
    for (int k = 0; k < 2; ++k) {
        const Passage p = node_passage(arc.child(k), q, halvings - 1);
        if (p == Passage::Through) return p;
        odd ^= p == Passage::Odd;
    }
    return odd ? Passage::Odd : Passage::Even;
}

bool within(const Q& x, const Q& lo, const Q& hi) { return lo <= x && x <= hi; }

// ---- boxes

struct QueryBox {
    Box box;                    // outward
    const std::array<Q, 4>* q;  // exactly, where that is finer
    double size_u, size_v;
};

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

Region::Region(const Face& face) : domain_(surface_domain(face.surface)) {
    whole_ = !face.loops.has_value();
    if (whole_) return;
    int trim_index = -1;
    for (const Loop& loop : *face.loops) {
        const std::size_t first = arcs_.size();
        const auto join = [&](const EndPoint& from, const EndPoint& to, int owner) {
            if (same_point(from, to)) return;
            arcs_.push_back(joined(from, to));
            arc_edge_.push_back(-1);
            arc_trim_.push_back(owner);
            const auto *a = std::get_if<0>(&from), *b = std::get_if<0>(&to);
            if (!a || !b) throw std::runtime_error("a gap at a circular arc");
            gaps_.push_back({std::min((*a)[0], (*b)[0]), std::max((*a)[0], (*b)[0]),
                             std::min((*a)[1], (*b)[1]), std::max((*a)[1], (*b)[1])});
        };
        for (const TrimCurve& trim : loop.trims) {
            ++trim_index;
            bool within = false;
            for (auto& piece : uv_pieces(trim)) {
                if (arcs_.size() > first)
                    join(end_point(arcs_.back(), true), end_point(piece, false),
                         within ? trim_index : -1);
                within = true;
                arcs_.push_back(std::move(piece));
                arc_edge_.push_back(trim.edge);
                arc_trim_.push_back(trim_index);
            }
        }
        if (arcs_.size() > first)
            join(end_point(arcs_.back(), true), end_point(arcs_[first], false), -1);
    }
    for (const auto& arc : arcs_) {
        const auto& curve = rational_curve(arc, 0);
        roots_.push_back(std::make_unique<ArcNode>(curve, along_border(curve, domain_)));
    }
}

Region::Region(Region&&) noexcept = default;
Region::~Region() = default;

Side side(const Region& region, const Q& u, const Q& v) {
    const auto& d = region.domain();
    if (!within(u, d[0], d[1]) || !within(v, d[2], d[3])) return Side::Outside;
    bool odd = region.whole_domain();
    const Point q{u, v, double_bounds(u), double_bounds(v)};
    for (const auto& root : region.roots()) {
        const Passage p = node_passage(*root, q, kHalvings);
        if (p == Passage::Through) return Side::Boundary;
        odd ^= p == Passage::Odd;
    }
    if (!odd) return Side::Outside;
    const bool border = u == d[0] || u == d[1] || v == d[2] || v == d[3];
    return border ? Side::Boundary : Side::Inside;
}

bool in_gap(const Region& region, const Q& u, const Q& v) {
    for (const auto& g : region.gaps())
        if (within(u, g[0], g[1]) && within(v, g[2], g[3])) return true;
    return false;
}

BoxSide box_side(const Region& region, double u0, double u1, double v0, double v1) {
    const auto& d = region.domain();
    // The middle of the box cut with the domain.
    const Q lo_u = std::max(Q(u0), d[0]), hi_u = std::min(Q(u1), d[1]);
    const Q lo_v = std::max(Q(v0), d[2]), hi_v = std::min(Q(v1), d[3]);
    if (lo_u > hi_u || lo_v > hi_v) return BoxSide::Outside;
    if (region.whole_domain()) return BoxSide::Inside;
    const QueryBox box{{u0, u1, v0, v1}, nullptr, u1 - u0, v1 - v0};
    bool border_met = false;
    for (const auto& root : region.roots()) {
        if (root->on_border)
            border_met |= !disjoint(*root, box);
        else if (!clear_of(*root, box, kDeepestDouble))
            return BoxSide::Mixed;
    }
    // The open box cut with the open domain is connected and meets no curve.
    const Q half(1, 2);
    switch (side(region, (lo_u + hi_u) * half, (lo_v + hi_v) * half)) {
        case Side::Inside:
            return BoxSide::Inside;
        case Side::Outside:
            return border_met ? BoxSide::Mixed : BoxSide::Outside;
        default:
            return BoxSide::Mixed;
    }
}

bool loops_clear(const Region& region, const std::array<Q, 4>& box) {
    const QueryBox query{{double_bounds(box[0]).first, double_bounds(box[1]).second,
                          double_bounds(box[2]).first, double_bounds(box[3]).second},
                         &box,
                         double_bounds(box[1] - box[0]).second,
                         double_bounds(box[3] - box[2]).second};
    for (const auto& root : region.roots())
        if (!clear_of(*root, query, kDeepest)) return false;
    return true;
}

bool box_clear(const Region& region, const std::array<Q, 4>& box) {
    const auto& d = region.domain();
    const bool within_domain = d[0] < box[0] && box[1] < d[1] && d[2] < box[2] && box[3] < d[3];
    return within_domain && loops_clear(region, box);
}

}  // namespace feeler_oracle
