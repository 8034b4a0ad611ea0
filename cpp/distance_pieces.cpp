#include "distance_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "face_pieces.hpp"

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using SpaceBox = std::array<double, 6>;

[[noreturn]] void refuse(std::size_t face, const char* what) {
    throw std::invalid_argument("face " + std::to_string(face) + ": " + what);
}

void grow(SpaceBox& box, int k, const Interval64& x) {
    box[2 * k] = std::min(box[2 * k], x.lo);
    box[2 * k + 1] = std::max(box[2 * k + 1], x.hi);
}

bool is_weight(const Interval64& w) { return w.lo >= 1 / kLargest && w.hi <= kLargest; }

SpaceBox box_of(const Surface& surface, const std::vector<NativePatch>& patches, std::size_t face) {
    SpaceBox box{kInfinity, -kInfinity, kInfinity, -kInfinity, kInfinity, -kInfinity};
    if (const auto* s = std::get_if<NurbsSurface>(&surface)) {
        for (std::size_t i = 0; i < s->net.size(); i += 4) {
            if (!is_weight(s->net[i + 3])) refuse(face, "a weight out of range");
            for (int k = 0; k < 3; ++k)
                grow(box, k, divide_positive(Interval64(s->net[i + k]), s->net[i + 3]));
        }
    } else if (const auto* s = std::get_if<Plane>(&surface)) {
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j < 2; ++j)
                for (int k = 0; k < 3; ++k)
                    grow(box, k,
                         Interval64(s->origin[k]) + Interval64(s->extents[i]) * s->x[k] +
                             Interval64(s->extents[2 + j]) * s->y[k]);
    } else {
        for (const NativePatch& patch : patches)
            for (std::size_t i = 0; i < patch.net[3].size(); ++i) {
                const Interval64 w = patch.net[3][i].outer();
                if (!is_weight(w)) refuse(face, "a weight out of range");
                for (int k = 0; k < 3; ++k)
                    grow(box, k, divide_positive(patch.net[k][i], patch.net[3][i]).outer());
            }
    }
    for (double x : box)
        if (!(std::fabs(x) <= kLargest)) refuse(face, "a coordinate out of range");
    return box;
}

}  // namespace

Pieces::Pieces(const Model& model, std::function<const Region&(std::size_t)> region)
    : model_(model), region_(std::move(region)), faces_(model.faces.size()) {
    SpaceBox all{kInfinity, -kInfinity, kInfinity, -kInfinity, kInfinity, -kInfinity};
    for (std::size_t i = 0; i < model.faces.size(); ++i) {
        const Face& face = model.faces[i];
        nothing_.push_back(face.loops && face.loops->empty());
        auto pieces = std::make_unique<FacePieces>();
        const bool native = !std::holds_alternative<NurbsSurface>(face.surface) &&
                            !std::holds_alternative<Plane>(face.surface);
        try {
            if (native) pieces->patches = native_patches(face.surface);
        } catch (const std::invalid_argument& e) {
            refuse(i, e.what());
        }
        boxes_.push_back(box_of(face.surface, pieces->patches, i));
        faces_[i] = std::move(pieces);
        if (!nothing_.back())
            for (int k = 0; k < 3; ++k)
                grow(all, k, Interval64(boxes_[i][2 * k], boxes_[i][2 * k + 1]));
    }
    if (all[0] <= all[1])
        for (int k = 0; k < 3; ++k) {
            const double d = all[2 * k + 1] - all[2 * k];
            size_ += d * d;
        }
    size_ = std::sqrt(size_);
}

const FacePieces& Pieces::face(std::size_t index) const {
    FacePieces& face = *faces_.at(index);
    if (face.region) return face;
    const Region& region = region_(index);
    FacePieces made;
    made.patches =
        face.patches.empty() ? native_patches(model_.faces[index].surface) : face.patches;
    made.region = &region;
    fill_pieces(model_.faces[index], int(index), made);
    for (const auto* pieces : {&made.pieces, &made.clamped})
        for (const Piece& piece : *pieces) {
            for (double x : piece.box)
                if (!(std::fabs(x) <= kLargest)) refuse(index, "a coordinate out of range");
            for (const Interval64& w : piece.net64[3])
                if (!is_weight(w)) refuse(index, "a weight out of range");
            made.slack = std::max(made.slack, piece.slack);
        }
    // Moving keeps the patches where they are, and with them the pieces' pointers.
    face = std::move(made);
    return face;
}

bool clear_of_arcs(const std::vector<ArcNet>& arcs, const Interval& u, const Interval& v) {
    // Beyond this depth the hulls are no smaller than the noise of the enclosures.
    constexpr int kDepth = 280;
    // A curve that passes at a distance of the order of the box's size is told from it by a few
    // pieces a level.
    constexpr int kPieces = 4000;
    int count = 0;
    std::vector<std::pair<ArcNet, int>> stack;
    const Interval64 u64 = u.outer(), v64 = v.outer();
    for (const ArcNet& arc : arcs) {
        if (arc.box[0].lo > u64.hi || arc.box[0].hi < u64.lo || arc.box[1].lo > v64.hi ||
            arc.box[1].hi < v64.lo)
            continue;
        stack.clear();
        stack.emplace_back(arc, 0);
        while (!stack.empty()) {
            auto [a, depth] = std::move(stack.back());
            stack.pop_back();
            const size_t n = a.c[2].size();
            bool apart = false, starts_inside = true;
            for (int k = 0; k < 2 && !apart; ++k) {
                bool above = true, below = true;
                for (size_t i = 0; i < n; ++i) {
                    const Interval x = a.c[k][i] - (k == 0 ? u : v) * a.c[2][i];
                    above &= x.lo.sign() > 0;
                    below &= x.hi.sign() < 0;
                    if (i == 0) starts_inside &= x.lo.sign() <= 0 && x.hi.sign() >= 0;
                }
                apart = above || below;
            }
            if (apart) continue;
            if (starts_inside) return false;  // not to be separated (or hardly)
            if (depth == kDepth || ++count > kPieces) return false;
            ArcNet left = a;
            for (int k = 0; k < 3; ++k)
                for (size_t m = 0; m < n; ++m) {
                    left.c[k][m] = a.c[k][0];
                    for (size_t i = 0; i + 1 < n - m; ++i)
                        a.c[k][i] = average(a.c[k][i], a.c[k][i + 1]);
                }
            stack.emplace_back(std::move(left), depth + 1);
            stack.emplace_back(std::move(a), depth + 1);
        }
    }
    return true;
}

}  // namespace feeler_oracle
