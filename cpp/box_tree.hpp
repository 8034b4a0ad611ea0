// A static tree over boxes in the plane.
#pragma once

#include <cstdint>
#include <vector>

namespace feeler_oracle {

struct Box {
    double u0, u1, v0, v1;
};

inline bool overlap(const Box& a, const Box& b) {
    return a.u0 <= b.u1 && b.u0 <= a.u1 && a.v0 <= b.v1 && b.v0 <= a.v1;
}

// Halved at the median of the boxes' middles along the direction in which these spread most, so
// its depth is about log2(n / kLeaf). Built in O(n log n).
class BoxTree {
 public:
    static constexpr std::uint32_t kLeaf = 4;

    struct Node {
        Box box;                             // holds the boxes of the node
        std::uint32_t begin, end;            // of order()
        std::int32_t left = -1, right = -1;  // both or none; children come after their parent
        bool leaf() const { return left < 0; }
    };

    BoxTree() = default;
    explicit BoxTree(const std::vector<Box>& boxes);

    // Without boxes: none. The first is the root.
    const std::vector<Node>& nodes() const { return nodes_; }
    // Indices of the boxes, those of a node in one range.
    const std::vector<std::uint32_t>& order() const { return order_; }

    // Calls visit(index) -> bool (whether to go on) for each box that meets the box, and maybe for
    // others. Whether all calls said to go on.
    template <class Visit>
    bool each_overlap(const Box& box, Visit visit) const {
        if (nodes_.empty()) return true;
        std::vector<std::int32_t> stack{0};
        while (!stack.empty()) {
            const Node& node = nodes_[std::size_t(stack.back())];
            stack.pop_back();
            if (!overlap(node.box, box)) continue;
            if (!node.leaf()) {
                stack.push_back(node.right);
                stack.push_back(node.left);
                continue;
            }
            for (std::uint32_t i = node.begin; i < node.end; ++i)
                if (!visit(order_[i])) return false;
        }
        return true;
    }

 private:
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
};

}  // namespace feeler_oracle
