// The model with what its queries share: regions and Bezier patches of each face.
#pragma once

#include <memory>
#include <vector>

#include "interval.hpp"
#include "model.hpp"
#include "side.hpp"

namespace feeler_oracle {

class Pieces;
class Edges;

struct PreparedFace {
    const Face* face;
    Region region;
    std::vector<RationalBezierPatch> patches;  // none unless is_rational(face->surface)
    // Of each patch: its square, enlarged by the margin where it meets the domain's border, ...
    std::vector<std::array<double, 4>> areas;
    // ... and a box that holds its image, infinite where that is not bounded.
    std::vector<std::array<Interval64, 3>> boxes;
};

// How far beyond the domain's border, and how near to a loop, a line's hit may be for the line to
// count as near an edge: this part of the domain's length in each direction (inside.hpp).
constexpr int kMarginBits = 10;

// Not for use by several threads at once: CGAL's numbers are reference-counted handles, and
// regions subdivide lazily.
class Core {
 public:
    explicit Core(Model model);
    // Prepared faces point into it.
    Core(const Core&) = delete;
    const Model& model() const { return model_; }
    // Made on first use. Throws std::out_of_range.
    const PreparedFace& face(std::size_t index) const;
    // What distances need; made on first use.
    const Pieces& pieces() const;
    // Images of edges and the widths of their cracks; made on first use.
    const Edges& edges() const;

 private:
    Model model_;
    mutable std::vector<std::unique_ptr<PreparedFace>> faces_;
    mutable std::shared_ptr<const Pieces> pieces_;
    mutable std::shared_ptr<const Edges> edges_;
};

// Throws std::invalid_argument naming face and defect: what is not finite, weights that are not
// positive, counts that do not fit, knots that decrease, empty domains.
void validate(const Model& model);

}  // namespace feeler_oracle
