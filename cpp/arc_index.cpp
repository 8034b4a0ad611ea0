#include "arc_index.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "passage.hpp"

namespace feeler_oracle {
namespace {

// `border`: the domain, rounded outward.
bool along_border(const RationalBezierCurve& c, const Box& hull, const std::array<Q, 4>& domain,
                  const std::array<Interval64, 4>& border) {
    const Interval64 range[2] = {{hull.u0, hull.u1}, {hull.v0, hull.v1}};
    for (std::size_t side = 0; side < 4; ++side) {
        const auto& [lo, hi] = range[side / 2];
        if (lo > border[side].hi || hi < border[side].lo) continue;
        const auto& coordinate = side < 2 ? c.X : c.Y;
        bool on = true;
        for (std::size_t i = 0; on && i < c.W.size(); ++i)
            on = coordinate[i] == domain[side] * c.W[i];
        if (on) return true;
    }
    return false;
}

Box hull_of(const RationalBezierCurve& c) {
    Box h{};
    for (std::size_t i = 0; i < c.W.size(); ++i) {
        const auto u = double_bounds(c.X[i] / c.W[i]), v = double_bounds(c.Y[i] / c.W[i]);
        if (i == 0) h = {u.first, u.second, v.first, v.second};
        h.u0 = std::min(h.u0, u.first);
        h.u1 = std::max(h.u1, u.second);
        h.v0 = std::min(h.v0, v.first);
        h.v1 = std::max(h.v1, v.second);
    }
    return h;
}

// Bits at which the boxes of points are made.
constexpr int kBoxBits = 128;
// Bits at which the ends of arcs are told from boxes, far more than boxes of root searches have.
constexpr int kClearBits = 1024;

Interval64 wide(const Q& x) {
    const auto b = double_bounds(x);
    return {b.first, b.second};
}

Box bounds_of(const EndPoint& p) {
    if (const auto* q = std::get_if<0>(&p)) {
        const Interval64 u = wide((*q)[0]), v = wide((*q)[1]);
        return {u.lo, u.hi, v.lo, v.hi};
    }
    const auto b = enclose(p, kBoxBits);
    return {double_bounds(b[0].lo).first, double_bounds(b[0].hi).second,
            double_bounds(b[1].lo).first, double_bounds(b[1].hi).second};
}

}  // namespace

// A query point with outward doubles for the filters.
struct ArcIndex::Query {
    const Q &u, &v;
    Box box;
    Height height;
};

ArcIndex::ArcIndex(const std::vector<RegionArc>& arcs, const std::vector<Gap>& gaps,
                   const std::array<Q, 4>& domain)
    : arcs_(arcs.data()), gaps_(gaps.data()) {
    add_items(arcs, domain);
    rank_points();
    cancel_joints();
    std::vector<Box> boxes;
    for (const Gap& gap : gaps) {
        const Box a = bounds_of(gap.from), b = bounds_of(gap.to);
        boxes.push_back({std::min(a.u0, b.u0), std::max(a.u1, b.u1), std::min(a.v0, b.v0),
                         std::max(a.v1, b.v1)});
    }
    gap_tree_ = BoxTree(boxes);
}

std::uint32_t ArcIndex::add_point(EndPoint point) {
    // Successive arcs share their joint.
    if (!points_.empty() && same_point(points_.back(), point))
        return std::uint32_t(points_.size() - 1);
    bounds_.push_back(bounds_of(point));
    points_.push_back(std::move(point));
    return std::uint32_t(points_.size() - 1);
}

Box ArcIndex::point_box(std::uint32_t a, std::uint32_t b) const {
    const Box &p = bounds_[a], &q = bounds_[b];
    return {std::min(p.u0, q.u0), std::max(p.u1, q.u1), std::min(p.v0, q.v0), std::max(p.v1, q.v1)};
}

void ArcIndex::add_items(const std::vector<RegionArc>& arcs, const std::array<Q, 4>& domain) {
    std::array<Interval64, 4> border;
    for (std::size_t k = 0; k < 4; ++k) border[k] = wide(domain[k]);
    for (std::size_t i = 0; i < arcs.size(); ++i) {
        if (const auto* circular = std::get_if<CircularArc>(&arcs[i])) {
            const Circle& c = circular->circle;
            circles_.push_back({wide(c.center[0]), wide(c.center[1]), wide(c.radius)});
            for (auto& quarter : quarter_arcs(*circular)) {
                const auto start = add_point(std::move(quarter.from));
                const auto end = add_point(std::move(quarter.to));
                // Monotone: its ends are the box's corners.
                items_.push_back({int(i), int(circles_.size()) - 1, start, end,
                                  point_box(start, end), std::int8_t(quarter.sign_u),
                                  std::int8_t(quarter.sign_v), false});
            }
            continue;
        }
        const auto start = add_point(end_point(arcs[i], false));
        const auto end = add_point(end_point(arcs[i], true));
        Item item{int(i), -1, start, end, point_box(start, end), 0, 0, false};
        if (const auto* c = std::get_if<RationalBezierCurve>(&arcs[i])) {
            if (c->degree() > 1) item.box = hull_of(*c);
            item.on_border = along_border(*c, item.box, domain, border);
        }
        items_.push_back(item);
    }
    std::vector<Box> boxes;
    for (const Item& item : items_) boxes.push_back(item.box);
    tree_ = BoxTree(boxes);
    halved_.resize(items_.size());
    enclosed_.resize(items_.size());
}

void ArcIndex::rank_points() {
    std::vector<std::uint32_t> order(points_.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto order_of = [&](std::uint32_t a, std::uint32_t b) -> int {
        const Box &p = bounds_[a], &q = bounds_[b];
        if (p.v1 < q.v0) return -1;
        if (q.v1 < p.v0) return 1;
        // Bounds that are one number are exact.
        if (p.v0 == p.v1 && q.v0 == q.v1) return 0;
        return compare(points_[a], points_[b], 1);
    };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return order_of(a, b) < 0; });
    rank_.resize(points_.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || order_of(order[i - 1], order[i]) != 0) heights_.push_back(order[i]);
        rank_[order[i]] = std::uint32_t(heights_.size() - 1);
    }
}

void ArcIndex::cancel_joints() {
    const auto& nodes = tree_.nodes();
    odd_.resize(nodes.size());
    // Children come after their parent.
    for (std::size_t i = nodes.size(); i-- > 0;) {
        auto& odd = odd_[i];
        if (!nodes[i].leaf()) {
            const auto& left = odd_[std::size_t(nodes[i].left)];
            const auto& right = odd_[std::size_t(nodes[i].right)];
            std::set_symmetric_difference(left.begin(), left.end(), right.begin(), right.end(),
                                          std::back_inserter(odd));
            continue;
        }
        std::vector<std::uint32_t> all;
        for (std::uint32_t k = nodes[i].begin; k < nodes[i].end; ++k) {
            const Item& item = items_[tree_.order()[k]];
            all.push_back(rank_[item.start]);
            all.push_back(rank_[item.end]);
        }
        std::sort(all.begin(), all.end());
        for (std::size_t k = 0; k < all.size(); ++k) {
            if (!odd.empty() && odd.back() == all[k])
                odd.pop_back();
            else
                odd.push_back(all[k]);
        }
    }
}

ArcIndex::Height ArcIndex::locate(const Q& v, double lo, double hi) const {
    // The first height that is not below v.
    const auto order = [&](std::uint32_t point) -> int {
        const Box& b = bounds_[point];
        if (b.v1 < lo) return -1;
        if (b.v0 > hi) return 1;
        return compare(points_[point], 1, v);
    };
    std::uint32_t first = 0, count = std::uint32_t(heights_.size());
    bool equal = false;
    while (count > 0) {
        const std::uint32_t half = count / 2;
        const int o = order(heights_[first + half]);
        if (o == 0) {
            first += half;
            equal = true;
            break;
        }
        if (o < 0) {
            first += half + 1;
            count -= half + 1;
        } else {
            count = half;
        }
    }
    return {equal ? first + 1 : first, equal};
}

// In doubles: 1 if the piece, whose ends are on either side of q's height (or as high), is right of
// q there, -1 if it is left, 0 if that is not settled.
int ArcIndex::right_of(const Item& item, const Query& q, bool curved) const {
    // Beyond this products may overflow, and intervals no longer mean anything.
    constexpr double kLargest = 0x1p500;
    const auto huge = [](const Box& b) {
        return !(std::abs(b.u0) < kLargest && std::abs(b.u1) < kLargest &&
                 std::abs(b.v0) < kLargest && std::abs(b.v1) < kLargest);
    };
    if (curved || huge(item.box) || huge(q.box)) return 0;
    const Interval64 u(q.box.u0, q.box.u1), v(q.box.v0, q.box.v1);
    if (item.circle >= 0) {
        const auto& c = circles_[std::size_t(item.circle)];
        if (!(std::abs(c[0].hi) < kLargest && std::abs(c[1].hi) < kLargest && c[2].hi < kLargest))
            return 0;
        const Interval64 du = u - c[0];
        if (item.sign_u > 0 ? du.hi < 0 : du.lo > 0) return item.sign_u;
        const Interval64 dv = v - c[1], out = du * du + dv * dv - c[2] * c[2];
        return out.lo > 0 ? -item.sign_u : out.hi < 0 ? item.sign_u : 0;
    }
    // Upwards, what has q on its left.
    const bool up = rank_[item.start] < rank_[item.end];
    const Box &a = bounds_[up ? item.start : item.end], &b = bounds_[up ? item.end : item.start];
    const Interval64 au = Interval64(a.u0, a.u1) - u, av = Interval64(a.v0, a.v1) - v,
                     bu = Interval64(b.u0, b.u1) - u, bv = Interval64(b.v0, b.v1) - v;
    const Interval64 left = au * bv - av * bu;
    return left.lo > 0 ? 1 : left.hi < 0 ? -1 : 0;
}

Passage ArcIndex::item_passage(const Item& item, const Query& q) const {
    const std::uint32_t start = rank_[item.start], end = rank_[item.end];
    const bool above0 = start >= q.height.first_above, above1 = end >= q.height.first_above;
    const auto below = [&](std::uint32_t rank) {
        return rank + (q.height.equal ? 1 : 0) < q.height.first_above;
    };
    const Passage passed = above0 != above1 ? Passage::Odd : Passage::Even;
    if (item.box.v0 > q.box.v1 || item.box.v1 < q.box.v0 || item.box.u1 < q.box.u0)
        return Passage::Even;
    if (item.box.u0 > q.box.u1) return passed;
    const RegionArc& arc = arcs_[item.arc];
    const auto* rational = std::get_if<RationalBezierCurve>(&arc);
    if (!rational || rational->degree() == 1) {
        // Monotone in v: nothing passes unless q is between the ends.
        if ((above0 && above1) || (below(start) && below(end))) return Passage::Even;
    }
    if (const int right = right_of(item, q, rational && rational->degree() > 1); right != 0)
        return right > 0 ? passed : Passage::Even;
    if (rational) {
        const auto exact_f = [&](std::size_t i) { return rational->Y[i] - q.v * rational->W[i]; };
        const auto exact_g = [&](std::size_t i) { return rational->X[i] - q.u * rational->W[i]; };
        const std::size_t n = rational->W.size();
        for (const std::size_t i : {std::size_t(0), n - 1})
            if (sign(exact_f(i)) == 0 && sign(exact_g(i)) == 0) return Passage::Through;
        if (n > 2) {
            // Enclosures first: exact coefficients take longer than all else together.
            auto& curve = enclosed_[std::size_t(&item - items_.data())];
            if (!curve) curve = std::make_unique<EnclosedCurve>(*rational);
            std::vector<Interval> f, g;
            const Interval u(q.u.mpq()), v(q.v.mpq());
            for (std::size_t i = 0; i < n; ++i) {
                f.push_back(curve->y[i] - v * curve->w[i]);
                g.push_back(curve->x[i] - u * curve->w[i]);
            }
            if (const auto certain = certain_passage(std::move(f), std::move(g), above0, above1))
                return *certain;
        }
        std::vector<Q> f, g;
        for (std::size_t i = 0; i < n; ++i) {
            f.push_back(exact_f(i));
            g.push_back(exact_g(i));
        }
        return feeler_oracle::passage(f, g);
    }
    if (const auto* segment = std::get_if<Segment>(&arc)) {
        // From the lower to the upper end, what is right of q has it on its left.
        const int side = orientation(*segment, q.u, q.v);
        if (side == 0) return Passage::Through;
        return (side > 0) == above1 ? passed : Passage::Even;
    }
    // On the quarter there is one point as high as q: at center + sign_u sqrt(r^2 - (q_v - c_v)^2).
    const Circle& c = std::get<CircularArc>(arc).circle;
    const Q du = q.u - c.center[0];
    if (sign(du) * item.sign_u < 0) return item.sign_u > 0 ? passed : Passage::Even;
    const Q dv = q.v - c.center[1];
    const int out = sign(du * du + dv * dv - c.radius * c.radius);
    if (out == 0) return Passage::Through;
    return (out < 0) == (item.sign_u > 0) ? passed : Passage::Even;
}

Passage ArcIndex::passage(const Q& u, const Q& v) const {
    if (items_.empty()) return Passage::Even;
    const auto du = double_bounds(u), dv = double_bounds(v);
    const Query q{u, v, {du.first, du.second, dv.first, dv.second}, locate(v, dv.first, dv.second)};
    const auto& nodes = tree_.nodes();
    bool odd = false;
    std::vector<std::int32_t> stack{0};
    while (!stack.empty()) {
        const std::size_t at = std::size_t(stack.back());
        stack.pop_back();
        const BoxTree::Node& node = nodes[at];
        if (node.box.v0 > q.box.v1 || node.box.v1 < q.box.v0 || node.box.u1 < q.box.u0) continue;
        if (node.box.u0 > q.box.u1) {
            const auto& ranks = odd_[at];
            const auto first = std::lower_bound(ranks.begin(), ranks.end(), q.height.first_above);
            odd ^= (ranks.end() - first) % 2 != 0;
            continue;
        }
        if (!node.leaf()) {
            stack.push_back(node.right);
            stack.push_back(node.left);
            continue;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i) {
            const Passage p = item_passage(items_[tree_.order()[i]], q);
            if (p == Passage::Through) return p;
            odd ^= p == Passage::Odd;
        }
    }
    return odd ? Passage::Odd : Passage::Even;
}

bool ArcIndex::item_clear(std::uint32_t index, const QueryBox& box) const {
    const Item& item = items_[index];
    if (!overlap(item.box, box.box)) return true;
    const RegionArc& arc = arcs_[item.arc];
    if (const auto* curve = std::get_if<RationalBezierCurve>(&arc)) {
        auto& node = halved_[index];
        if (!node) node = std::make_unique<ArcNode>(*curve);
        return clear_of(*node, box);
    }
    const std::array<Q, 4> q = box.exact();
    if (const auto* segment = std::get_if<Segment>(&arc)) {
        // All corners on one side of the line.
        int sides[4];
        for (int k = 0; k < 4; ++k)
            sides[k] =
                likely_orientation(*segment, q[std::size_t(k / 2)], q[std::size_t(2 + k % 2)]);
        return sides[0] != 0 && sides[0] == sides[1] && sides[0] == sides[2] &&
               sides[0] == sides[3];
    }
    // The quarter is what of the circle lies in the box of its ends. Cut with that, `q` holds a
    // point of it unless all of it is inside the circle or all outside; being in one quadrant, its
    // nearest and farthest corners are known.
    const Circle& c = std::get<CircularArc>(arc).circle;
    const auto from = enclose(points_[item.start], kClearBits),
               to = enclose(points_[item.end], kClearBits);
    Q nearest(0), farthest(0);
    for (std::size_t k = 0; k < 2; ++k) {
        const Q lo = std::max(q[2 * k], std::min(from[k].lo, to[k].lo));
        const Q hi = std::min(q[2 * k + 1], std::max(from[k].hi, to[k].hi));
        if (lo > hi) return true;
        const Q reach[2] = {lo - c.center[k], hi - c.center[k]};
        const bool up = (k == 0 ? item.sign_u : item.sign_v) > 0;
        const Q& near = reach[up ? 0 : 1];
        const Q& far = reach[up ? 1 : 0];
        // Bounds of the ends may lie beyond the centre by their rounding.
        if (sign(near) == (up ? 1 : -1)) nearest += near * near;
        farthest += far * far;
    }
    const Q radius2 = c.radius * c.radius;
    return nearest > radius2 || farthest < radius2;
}

bool ArcIndex::clear(const QueryBox& box, bool* on_border) const {
    return tree_.each_overlap(box.box, [&](std::uint32_t i) {
        if (on_border && items_[i].on_border) {
            *on_border |= overlap(items_[i].box, box.box);
            return true;
        }
        return item_clear(i, box);
    });
}

bool ArcIndex::in_gap(const Q& u, const Q& v) const {
    const auto du = double_bounds(u), dv = double_bounds(v);
    return !gap_tree_.each_overlap(
        {du.first, du.second, dv.first, dv.second}, [&](std::uint32_t i) {
            const Gap& gap = gaps_[i];
            const auto between = [&](int k, const Q& x) {
                return compare(gap.from, k, x) * compare(gap.to, k, x) <= 0;
            };
            return !(between(0, u) && between(1, v));
        });
}

}  // namespace feeler_oracle
