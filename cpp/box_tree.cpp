#include "box_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace feeler_oracle {

BoxTree::BoxTree(const std::vector<Box>& boxes) : order_(boxes.size()) {
    if (boxes.empty()) return;
    std::iota(order_.begin(), order_.end(), 0u);
    // Where a box is: half its ends' sum, without overflow; what is not finite counts as 0 (any
    // order is valid).
    std::vector<double> middle[2];
    for (const Box& b : boxes) {
        const double m[2] = {0.5 * b.u0 + 0.5 * b.u1, 0.5 * b.v0 + 0.5 * b.v1};
        for (int k = 0; k < 2; ++k) middle[k].push_back(std::isfinite(m[k]) ? m[k] : 0);
    }
    const auto add = [&](std::uint32_t begin, std::uint32_t end) {
        Box hull = boxes[order_[begin]];
        for (std::uint32_t i = begin + 1; i < end; ++i) {
            const Box& b = boxes[order_[i]];
            hull.u0 = std::min(hull.u0, b.u0);
            hull.u1 = std::max(hull.u1, b.u1);
            hull.v0 = std::min(hull.v0, b.v0);
            hull.v1 = std::max(hull.v1, b.v1);
        }
        nodes_.push_back({hull, begin, end});
        return std::int32_t(nodes_.size() - 1);
    };
    add(0, std::uint32_t(boxes.size()));
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        const std::uint32_t begin = nodes_[i].begin, end = nodes_[i].end;
        if (end - begin <= kLeaf) continue;
        int axis = 0;
        double widest = -1;
        for (int k = 0; k < 2; ++k) {
            double lo = middle[k][order_[begin]], hi = lo;
            for (std::uint32_t j = begin; j < end; ++j) {
                lo = std::min(lo, middle[k][order_[j]]);
                hi = std::max(hi, middle[k][order_[j]]);
            }
            if (0.5 * hi - 0.5 * lo > widest) {
                widest = 0.5 * hi - 0.5 * lo;
                axis = k;
            }
        }
        const std::uint32_t half = begin + (end - begin) / 2;
        std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                         [&](std::uint32_t a, std::uint32_t b) {
                             return middle[axis][a] != middle[axis][b]
                                        ? middle[axis][a] < middle[axis][b]
                                        : a < b;
                         });
        const std::int32_t left = add(begin, half), right = add(half, end);
        nodes_[i].left = left;
        nodes_[i].right = right;
    }
}

}  // namespace feeler_oracle
