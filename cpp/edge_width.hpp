// The certified width d_e of an edge's crack.
//
// d_e is the largest Frechet distance between two images of the edge (edge_images.hpp): the least d
// such that both can be run through, without turning back, and stay within d of each other; of the
// two directions of the second image the better one counts.
//
// Above: both images are cut into corresponding parts, in order; a pair of parts, each on one
// Bezier piece A / V and B / W, is run through at equal relative parameters. The distance then is
// |A W - B V| / (V W), a convex combination of the quotients of its Bernstein coefficients, so that
// the largest of these bounds it. The pair with the largest bound is cut further: one part at its
// middle, the other at the nearest point. Below: a point of one image farther than r from all of
// the other (edge_near.hpp) proves d_e >= r, for the Hausdorff distance is no more than the Frechet
// distance; and so do the ends, which have to be matched. Where an image is known up to a slack, or
// crosses a knot line, what that part may add is added.
#pragma once

#include <optional>

#include "edge_images.hpp"

namespace feeler_oracle {

struct CrackWidth {
    Interval d;         // holds d_e
    bool known = true;  // false: no bound (an image is not known whole)
    int cuts = 0;
};

// Of an edge with two images or more; of others [0, 0]. To a relative width of 2^-10, or to
// 2^-kCrackFloorBits of the model's size, unless that takes more than `budget` cuts.
CrackWidth crack_width(const Pieces& pieces, const EdgeImages& edges, int edge, int budget = 600);

constexpr int kCrackFloorBits = 100;

// The edges of a model, their widths made as they are needed. Not for use by several threads.
class Edges {
 public:
    explicit Edges(const Core& core);
    const EdgeImages& images() const { return images_; }
    const CrackWidth& width(int edge) const;
    // A bound above it in doubles, soon found; infinite where none is known.
    double rough(int edge) const;

 private:
    const Pieces& pieces_;
    EdgeImages images_;
    mutable std::vector<std::optional<CrackWidth>> widths_;
    mutable std::vector<std::optional<double>> rough_;
};

}  // namespace feeler_oracle
