// The model with what its queries share: regions and Bezier patches of each face.
#pragma once

#include <memory>
#include <vector>

#include "model.hpp"
#include "side.hpp"

namespace feeler_oracle {

struct Pieces;

struct PreparedFace {
    const Face* face;
    Region region;
    std::vector<RationalBezierPatch> patches;
};

// Not for use by several threads at once: CGAL's numbers are reference-counted handles, and
// regions subdivide lazily.
class Core {
 public:
    explicit Core(Model model);
    const Model& model() const { return model_; }
    // Made on first use. Throws std::out_of_range.
    const PreparedFace& face(std::size_t index) const;
    // What distances need; made on first use, of all faces.
    const Pieces& pieces() const;

 private:
    Model model_;
    mutable std::vector<std::unique_ptr<PreparedFace>> faces_;
    mutable std::shared_ptr<const Pieces> pieces_;
};

// Throws std::invalid_argument naming face and defect: what is not finite, weights that are not
// positive, counts that do not fit, knots that decrease, empty domains.
void validate(const Model& model);

}  // namespace feeler_oracle
