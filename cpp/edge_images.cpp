#include "edge_images.hpp"

#include <algorithm>
#include <numeric>

#include "core.hpp"

namespace feeler_oracle {
namespace {

using Box6 = std::array<double, 6>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Box6 kNothing{kInfinity, -kInfinity, kInfinity, -kInfinity, kInfinity, -kInfinity};

void include(Box6& box, const Box6& other) {
    for (int k = 0; k < 3; ++k) {
        box[2 * k] = std::min(box[2 * k], other[2 * k]);
        box[2 * k + 1] = std::max(box[2 * k + 1], other[2 * k + 1]);
    }
}

Box6 box_of(const Piece& piece) {
    Box6 box = piece.box;
    const double slack = slack_of(piece);
    if (slack > 0)
        for (int k = 0; k < 6; ++k)
            box[k] = k % 2 ? next_up(box[k] + slack) : next_down(box[k] - slack);
    return box;
}

// Of the first or last control point: the curve's end.
Box6 end_box(const Piece& piece, bool last) {
    const std::size_t i = last ? piece.net[3].size() - 1 : 0;
    const double slack = slack_of(piece);
    Box6 box;
    for (int k = 0; k < 3; ++k) {
        const Interval64 x = divide_positive(piece.net[k][i], piece.net[3][i]).outer();
        box[2 * k] = slack > 0 ? next_down(x.lo - slack) : x.lo;
        box[2 * k + 1] = slack > 0 ? next_up(x.hi + slack) : x.hi;
    }
    return box;
}

// Of one end of an image. Where it begins with a tiny part that is enclosed, that belongs to it.
Box6 end_box(const Image& image, bool last) {
    if (image.pieces.empty()) return image.box;
    const Piece& end = last ? *image.pieces.back() : *image.pieces.front();
    Box6 box = end_box(end, last);
    for (const Piece* b : image.between)
        if (b->arc == end.arc && (last ? b->t0 == end.t1 : b->t1 == end.t0)) include(box, b->box);
    return box;
}

std::array<double, 3> middle(const Image& image, double fraction) {
    // Control points do for telling one direction from the other.
    const std::size_t n = image.pieces.size();
    const double at = fraction * double(n);
    const std::size_t i = std::min(n - 1, std::size_t(at));
    const Piece& piece = *image.pieces[i];
    const double t = at - double(i);
    std::array<double, 4> value{};
    for (int k = 0; k < 4; ++k) {
        std::vector<double> c;
        for (const auto& x : piece.net64[k]) c.push_back(0.5 * (x.lo + x.hi));
        for (std::size_t level = 1; level < c.size(); ++level)
            for (std::size_t m = 0; m + level < c.size(); ++m) c[m] += t * (c[m + 1] - c[m]);
        value[k] = c[0];
    }
    return {value[0] / value[3], value[1] / value[3], value[2] / value[3]};
}

// Whether b fits a better when run through backwards.
bool runs_against(const Image& a, const Image& b) {
    if (a.pieces.empty() || b.pieces.empty()) return false;
    double with = 0, against = 0;
    for (const double at : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
        const auto p = middle(a, at), q = middle(b, at), r = middle(b, 1 - at);
        for (int k = 0; k < 3; ++k) {
            with += (p[k] - q[k]) * (p[k] - q[k]);
            against += (p[k] - r[k]) * (p[k] - r[k]);
        }
    }
    return against < with;
}

struct Groups {
    std::vector<int> parent;
    int find(int i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    }
    void join(int i, int j) { parent[find(i)] = find(j); }
};

// Of one face: for each trim its image, and the boxes of the joins after each trim.
struct FaceImages {
    std::vector<Image> trims;
    std::vector<Box6> joins;  // kNothing where there is none
    std::vector<int> next;    // the trim that follows in its loop
    bool whole = true;
};

FaceImages images_of(const Core& core, int index,
                     const std::vector<std::vector<const Piece*>>& by_arc) {
    const Region& region = core.face(std::size_t(index)).region;
    FaceImages result;
    const auto& loops = core.model().faces[index].loops;
    if (!loops) return result;
    int count = 0;
    for (const auto& loop : *loops) {
        const int first = count;
        for (std::size_t i = 0; i < loop.trims.size(); ++i, ++count) {
            Image image;
            image.face = index;
            image.edge = loop.trims[i].edge;
            image.whole = true;
            image.box = kNothing;
            result.trims.push_back(std::move(image));
            result.joins.push_back(kNothing);
            result.next.push_back(i + 1 < loop.trims.size() ? count + 1 : first);
        }
    }
    int last_trim = -1;
    for (std::size_t a = 0; a < by_arc.size(); ++a) {
        const int trim = region.arc_trim()[a];
        // The pieces of an arc in order, without a hole.
        auto pieces = by_arc[a];
        std::sort(pieces.begin(), pieces.end(), [](const Piece* x, const Piece* y) {
            return x->t0 < y->t0 || (x->t0 == y->t0 && x->t1 < y->t1);
        });
        Q reached(0);
        bool whole = true;
        for (const Piece* p : pieces) {
            whole &= p->t0 <= reached;
            reached = std::max(reached, p->t1);
            if (trim < 0) continue;
            Image& image = result.trims[trim];
            (p->kind == PieceKind::Trim ? image.pieces : image.between).push_back(p);
            include(image.box, box_of(*p));
        }
        whole &= reached == Q(1);
        result.whole &= whole;
        if (trim >= 0) {
            result.trims[trim].whole &= whole;
            last_trim = trim;
        } else if (last_trim >= 0) {
            for (const Piece* p : pieces) include(result.joins[last_trim], box_of(*p));
        }
    }
    for (const Image& image : result.trims) result.whole &= !image.pieces.empty();
    return result;
}

}  // namespace

EdgeImages edge_images(const Core& core) {
    const Model& model = core.model();
    const Pieces& all = core.pieces();
    EdgeImages result;
    result.uses.resize(model.edges);
    result.against.assign(model.edges, 0);
    result.brep_of.assign(model.edges, -1);
    result.whole.assign(model.closed.size(), 1);

    std::vector<std::vector<std::vector<const Piece*>>> by_arc(model.faces.size());
    for (std::size_t f = 0; f < model.faces.size(); ++f)
        by_arc[f].resize(core.face(f).region.arcs().size());
    for (std::size_t f = 0; f < model.faces.size(); ++f) {
        if (all.nothing(f)) continue;
        for (const auto* pieces : {&all.face(f).pieces, &all.face(f).clamped})
            for (const Piece& p : *pieces)
                if (p.arc >= 0) by_arc[f][p.arc].push_back(&p);
    }

    struct Join {
        int image, next;
        Box6 box;
    };
    std::vector<Join> joins;
    for (std::size_t f = 0; f < model.faces.size(); ++f) {
        const int brep = model.faces[f].brep;
        FaceImages of_face = images_of(core, int(f), by_arc[f]);
        if (!of_face.whole) result.whole[brep] = 0;
        const int base = int(result.images.size());
        for (std::size_t t = 0; t < of_face.trims.size(); ++t) {
            Image& image = of_face.trims[t];
            if (image.edge >= 0) {
                result.uses[image.edge].push_back(base + int(t));
                result.brep_of[image.edge] = brep;
            }
            joins.push_back({base + int(t), base + of_face.next[t], of_face.joins[t]});
            result.images.push_back(std::move(image));
        }
    }
    for (int e = 0; e < model.edges; ++e)
        if (result.uses[e].size() == 2)
            result.against[e] =
                runs_against(result.images[result.uses[e][0]], result.images[result.uses[e][1]]);

    // Ends of images: 2 i the start of image i, 2 i + 1 its end.
    Groups groups;
    groups.parent.resize(2 * result.images.size());
    std::iota(groups.parent.begin(), groups.parent.end(), 0);
    for (const auto& j : joins) groups.join(2 * j.image + 1, 2 * j.next);
    for (std::size_t i = 0; i < result.images.size(); ++i)
        if (result.images[i].edge < 0) groups.join(2 * int(i), 2 * int(i) + 1);
    for (int e = 0; e < model.edges; ++e)
        for (std::size_t k = 1; k < result.uses[e].size(); ++k) {
            const int a = result.uses[e][0], b = result.uses[e][k];
            const int turn = result.uses[e].size() == 2 && result.against[e] ? 1 : 0;
            groups.join(2 * a, 2 * b + turn);
            groups.join(2 * a + 1, 2 * b + 1 - turn);
        }
    std::vector<Box6> boxes(groups.parent.size(), kNothing);
    for (std::size_t i = 0; i < result.images.size(); ++i) {
        const Image& image = result.images[i];
        for (int end = 0; end < 2; ++end)
            include(boxes[groups.find(2 * int(i) + end)], end_box(image, end == 1));
        if (image.edge < 0) include(boxes[groups.find(2 * int(i))], image.box);
    }
    for (const auto& j : joins) include(boxes[groups.find(2 * j.image + 1)], j.box);
    for (std::size_t g = 0; g < boxes.size(); ++g)
        if (boxes[g][0] <= boxes[g][1]) {
            const int face = result.images[g / 2].face;
            result.vertices.push_back({model.faces[face].brep, boxes[g]});
        }
    return result;
}

}  // namespace feeler_oracle
