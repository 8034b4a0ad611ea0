// Where a region's arcs are, so that a side need not look at all of them.
//
// Items: a rational curve is one; a circular arc is one a quarter (uv_curve.hpp); a segment is one.
// Each has a start and an end point. The parity of a point q is that of the number of transitions
// of [v > q_v] on the loops at points with u > q_u (roots.hpp). An item whose box
//   - lies above q, below it, or left of it contributes nothing (above: [v > q_v] is always true;
//     below, and touching from below: never; left: u <= q_u);
//   - lies right of q contributes [end above q] xor [start above q].
// So does a set of items in a box: right of q it contributes the parity of the number of those of
// its start and end points that are above q, where points that occur an even number of times
// (joints within the set) cancel. Each node of a tree over the items' boxes keeps the other
// points, sorted by height: its contribution is one binary search. Only nodes whose box holds q
// are opened.
//
// Heights are compared once a query: the points' distinct heights are sorted exactly beforehand,
// and one binary search says which of them is the first above q_v, and whether one equals it.
// Everything else compares their ranks.
//
// Cost: O(n log n) to make, O(log^2 n) a query beside the items whose boxes hold q.
#pragma once

#include <cstdint>
#include <memory>

#include "arc_tree.hpp"
#include "box_tree.hpp"
#include "interval.hpp"
#include "roots.hpp"
#include "side.hpp"

namespace feeler_oracle {

class ArcIndex {
 public:
    // The elements of `arcs` and `gaps` must outlive the index, where they are.
    ArcIndex(const std::vector<RegionArc>& arcs, const std::vector<Gap>& gaps,
             const std::array<Q, 4>& domain);

    // Parity of the point, or Through if it lies on an arc.
    Passage passage(const Q& u, const Q& v) const;

    bool in_gap(const Q& u, const Q& v) const;

    // Whether all arcs are proven to be disjoint from the box. If `on_border` is given, arcs that
    // run along the domain's border are not looked at, but it is set if one of them may meet the
    // box.
    bool clear(const QueryBox& box, bool* on_border) const;

 private:
    struct Item {
        int arc;
        int circle;                // of a quarter: into circles_; else -1
        std::uint32_t start, end;  // of points_
        Box box;
        std::int8_t sign_u, sign_v;  // of a quarter
        bool on_border;
    };
    // Of the points' heights: how many distinct ones are not above q, and whether one equals it.
    struct Height {
        std::uint32_t first_above;
        bool equal;
    };
    struct Query;
    // A rational curve's coefficients.
    struct EnclosedCurve {
        std::vector<Interval> x, y, w;
        explicit EnclosedCurve(const RationalBezierCurve& c) {
            const auto enclose = [](const std::vector<Q>& from, std::vector<Interval>& to) {
                for (const Q& a : from) to.emplace_back(a.mpq());
            };
            enclose(c.X, x);
            enclose(c.Y, y);
            enclose(c.W, w);
        }
    };

    std::uint32_t add_point(EndPoint point);
    void add_items(const std::vector<RegionArc>& arcs, const std::array<Q, 4>& domain);
    void rank_points();
    void cancel_joints();
    Height locate(const Q& v, double lo, double hi) const;
    int right_of(const Item& item, const Query& q, bool curved) const;
    Passage item_passage(const Item& item, const Query& q) const;
    bool item_clear(std::uint32_t index, const QueryBox& box) const;
    Box point_box(std::uint32_t a, std::uint32_t b) const;

    const RegionArc* arcs_;
    const Gap* gaps_;
    std::vector<EndPoint> points_;
    // u0, u1, v0, v1 of each point, rounded outward; equal ends mean that it is exactly that.
    std::vector<Box> bounds_;
    std::vector<std::uint32_t> rank_;     // of each point
    std::vector<std::uint32_t> heights_;  // of each rank: a point
    std::vector<Item> items_;
    std::vector<std::array<Interval64, 3>> circles_;  // centre and radius
    BoxTree tree_, gap_tree_;
    std::vector<std::vector<std::uint32_t>> odd_;  // of each node of tree_: ranks, sorted
    // Of rational items, on demand.
    mutable std::vector<std::unique_ptr<ArcNode>> halved_;
    mutable std::vector<std::unique_ptr<EnclosedCurve>> enclosed_;
};

}  // namespace feeler_oracle
