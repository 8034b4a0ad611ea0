#include "side.hpp"

#include <algorithm>

#include "arc_index.hpp"

namespace feeler_oracle {
namespace {

bool within(const Q& x, const Q& lo, const Q& hi) { return lo <= x && x <= hi; }

}  // namespace

Region::Region(const Face& face) : domain_(surface_domain(face.surface)) {
    whole_ = !face.loops.has_value();
    static const std::vector<Loop> kNone;
    int trim_index = -1;
    for (const Loop& loop : whole_ ? kNone : *face.loops) {
        const std::size_t first = arcs_.size();
        const auto join = [&](const EndPoint& from, const EndPoint& to, int owner) {
            if (same_point(from, to)) return;
            arcs_.push_back(joined(from, to));
            arc_edge_.push_back(-1);
            arc_trim_.push_back(owner);
            gaps_.push_back({from, to});
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
    index_ = std::make_unique<ArcIndex>(arcs_, gaps_, domain_);
}

Region::Region(Region&&) noexcept = default;
Region::~Region() = default;

Side side(const Region& region, const Q& u, const Q& v) {
    const auto& d = region.domain();
    if (!within(u, d[0], d[1]) || !within(v, d[2], d[3])) return Side::Outside;
    if (!region.whole_domain()) {
        const Passage p = region.index().passage(u, v);
        if (p == Passage::Through) return Side::Boundary;
        if (p == Passage::Even) return Side::Outside;
    }
    const bool border = u == d[0] || u == d[1] || v == d[2] || v == d[3];
    return border ? Side::Boundary : Side::Inside;
}

bool in_gap(const Region& region, const Q& u, const Q& v) { return region.index().in_gap(u, v); }

BoxSide box_side(const Region& region, double u0, double u1, double v0, double v1) {
    const auto& d = region.domain();
    // The middle of the box cut with the domain.
    const Q lo_u = std::max(Q(u0), d[0]), hi_u = std::min(Q(u1), d[1]);
    const Q lo_v = std::max(Q(v0), d[2]), hi_v = std::min(Q(v1), d[3]);
    if (lo_u > hi_u || lo_v > hi_v) return BoxSide::Outside;
    if (region.whole_domain()) return BoxSide::Inside;
    const QueryBox box{{u0, u1, v0, v1}, nullptr, u1 - u0, v1 - v0};
    bool border_met = false;
    if (!region.index().clear(box, &border_met)) return BoxSide::Mixed;
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
    return region.index().clear(query, nullptr);
}

bool box_clear(const Region& region, const std::array<Q, 4>& box) {
    const auto& d = region.domain();
    const bool within_domain = d[0] < box[0] && box[1] < d[1] && d[2] < box[2] && box[3] < d[3];
    return within_domain && loops_clear(region, box);
}

}  // namespace feeler_oracle
