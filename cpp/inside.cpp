#include "inside.hpp"

#include <algorithm>
#include <stdexcept>

#include "distance_pieces.hpp"
#include "edge_near.hpp"
#include "edge_width.hpp"
#include "evaluate.hpp"
#include "line.hpp"

namespace feeler_oracle {
namespace {

constexpr int kRays = 48;
// Enclosures of hits are far narrower than this, relative to the ray's direction; other open parts
// wider.
constexpr double kNarrow = 0x1p-160;

// Spread evenly, none along an axis or a plane that parts are built along.
std::array<double, 3> ray_direction(int k) {
    constexpr double kGoldenAngle = 2.399963229728653;
    const double z = 1 - (2 * k + 1) / double(kRays), r = std::sqrt(1 - z * z);
    const double turn = 0.7 + kGoldenAngle * k;
    const double x = r * std::cos(turn), y = r * std::sin(turn);
    // Tilted, so that no two of them are opposite or share a height.
    return {0.8 * x - 0.48 * y + 0.36 * z, 0.6 * x + 0.64 * y - 0.48 * z, 0.6 * y + 0.8 * z};
}

bool in_box(const std::array<double, 3>& p, const std::array<double, 6>& box) {
    for (int k = 0; k < 3; ++k)
        if (p[k] < box[2 * k] || p[k] > box[2 * k + 1]) return false;
    return true;
}

std::array<double, 6> to_box(const std::array<Interval64, 3>& b) {
    return {b[0].lo, b[0].hi, b[1].lo, b[1].hi, b[2].lo, b[2].hi};
}

class Query {
 public:
    Query(const Core& core, int brep, const std::array<double, 3>& point)
        : core_(core), edges_(core.edges()), brep_(brep), point_(point) {
        target_.origin = {Interval(point[0]), Interval(point[1]), Interval(point[2])};
    }

    InsideAnswer run(int rays) {
        if (!edges_.images().whole[brep_])
            return {InsideKind::Undecided, "an image of an edge is not known whole"};
        prepare_faces();
        const Near crack = in_crack();
        // A point of a face is on the boundary, within a crack or not.
        if (crack != Near::No && on_a_face()) return {InsideKind::Boundary, {}};
        if (crack == Near::Yes) return {InsideKind::Undecided, kCrack};
        if (crack == Near::Unknown)
            return {InsideKind::Undecided,
                    "at the crack's width from an edge, as far as it is known"};
        return by_rays(rays);
    }

 private:
    void prepare_faces() {
        const auto& faces = core_.model().faces;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            if (faces[f].brep != brep_) continue;
            const PreparedFace& face = core_.face(f);
            if (!face.region.whole_domain() && face.region.arcs().empty()) continue;
            faces_.push_back(int(f));
            const auto holds = [&](const auto& b) { return in_box(point_, to_box(b)); };
            const bool near = face.boxes.empty()
                                  ? in_box(point_, core_.pieces().box(f))
                                  : std::any_of(face.boxes.begin(), face.boxes.end(), holds);
            if (near) around_.push_back(int(f));
        }
    }

    // ---- cracks

    Near in_crack() const {
        for (const auto& v : edges_.images().vertices)
            if (v.brep == brep_ && in_box(point_, v.box)) return Near::Yes;
        Near result = Near::No;
        for (std::size_t e = 0; e < edges_.images().uses.size(); ++e) {
            if (edges_.images().brep_of[e] != brep_) continue;
            const double rough = edges_.rough(int(e));
            for (const int i : edges_.images().uses[e]) {
                const Near near = near_image(edges_.images().images[i], int(e), rough);
                if (near == Near::Yes) return near;
                if (near == Near::Unknown) result = near;
            }
        }
        return result;
    }

    Near near_image(const Image& image, int edge, double rough) const {
        if (box_distance(point_, image.box) > rough) return Near::No;
        Near result = Near::No;
        for (const auto* pieces : {&image.pieces, &image.between})
            for (const Piece* p : *pieces) {
                const double slack = slack_of(*p);
                if (box_distance(point_, p->box) > next_up(rough + slack)) continue;
                if (clear_in_doubles(target_, *p, rough)) continue;
                const Near near = near_piece(target_, *p, edges_.width(edge).d);
                if (near == Near::Yes) return near;
                if (near == Near::Unknown) result = near;
            }
        return result;
    }

    // ---- on a face

    bool on_a_face() const {
        for (const int f : around_) {
            const PreparedFace& face = core_.face(std::size_t(f));
            for (const auto& patch : face.patches)
                if (on_parallelogram(face, patch)) return true;
        }
        const auto& faces = core_.model().faces;
        std::vector<char> wanted(faces.size(), 0);
        for (const int f : around_) wanted[f] = 1;
        const Line line{point_, ray_direction(0), LineKind::Line};
        LineOptions options{brep_, 20000};
        options.faces = &wanted;
        for (const LineHit& hit : line_hits(core_, line, options).hits) {
            if (hit.lies_in) continue;
            if (hit.t.lo.sign() == 0 && hit.t.hi.sign() == 0) return true;
            if (hit.t.lo.sign() <= 0 && hit.t.hi.sign() >= 0 && exact_foot(hit)) return true;
        }
        return false;
    }

    // Exactly, for a patch that is an affine image of its square; false for others.
    bool on_parallelogram(const PreparedFace& face, const RationalBezierPatch& s) const {
        if (s.p != 1 || s.q != 1) return false;
        for (const Q& w : s.W)
            if (w != s.W[0]) return false;
        using Q3 = std::array<Q, 3>;
        Q3 u, v, x;
        const std::vector<Q>* const xyz[3] = {&s.X, &s.Y, &s.Z};
        for (int k = 0; k < 3; ++k) {
            const auto& c = *xyz[k];
            if (c[0] + c[3] != c[1] + c[2]) return false;
            u[k] = (c[2] - c[0]) / s.W[0];
            v[k] = (c[1] - c[0]) / s.W[0];
            x[k] = Q(point_[k]) - c[0] / s.W[0];
        }
        const auto dot = [](const Q3& a, const Q3& b) -> Q {
            return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        };
        const auto cross = [](const Q3& a, const Q3& b) -> Q3 {
            return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                    a[0] * b[1] - a[1] * b[0]};
        };
        const Q3 n = cross(u, v);
        const Q n2 = dot(n, n);
        if (sign(n2) == 0 || sign(dot(n, x)) != 0) return false;
        const Q a = dot(cross(x, v), n) / n2, b = dot(cross(u, x), n) / n2;
        if (sign(a) < 0 || a > Q(1) || sign(b) < 0 || b > Q(1)) return false;
        return side(face.region, s.u0 + a * (s.u1 - s.u0), s.v0 + b * (s.v1 - s.v0)) !=
               Side::Outside;
    }

    // Whether the point is the exact image of parameters beside those of the hit.
    bool exact_foot(const LineHit& hit) const {
        const Face& face = core_.model().faces[hit.face];
        const auto& region = core_.face(std::size_t(hit.face)).region;
        const auto& domain = region.domain();
        // No point of these is known exactly.
        if (!is_rational(face.surface)) return false;
        const auto beside = [](double x) {
            return std::array<double, 3>{std::nextafter(x, -INFINITY), x,
                                         std::nextafter(x, INFINITY)};
        };
        for (const double u : beside(hit.uv[0]))
            for (const double v : beside(hit.uv[1])) {
                const Q qu(u), qv(v);
                if (qu < domain[0] || qu > domain[1] || qv < domain[2] || qv > domain[3]) continue;
                const auto e = evaluate(face.surface, qu, qv);
                bool equal = true;
                for (int k = 0; k < 3; ++k) equal &= e.point[k] == Q(point_[k]);
                if (equal && side(region, qu, qv) != Side::Outside) return true;
            }
        return false;
    }

    // ---- rays

    bool clear_of_edges(const NearTarget& ray) const {
        for (const auto& v : edges_.images().vertices)
            if (v.brep == brep_ && !line_misses_exactly(ray, v.box)) return false;
        for (const Image& image : edges_.images().images) {
            if (core_.model().faces[image.face].brep != brep_) continue;
            // A singular trim lies in a vertex region.
            if (image.edge < 0) continue;
            const double rough = edges_.rough(image.edge);
            if (line_misses(ray, image.box, rough)) continue;
            for (const auto* pieces : {&image.pieces, &image.between})
                for (const Piece* p : *pieces) {
                    if (line_misses(ray, p->box, next_up(rough + slack_of(*p)))) continue;
                    if (clear_in_doubles(ray, *p, rough)) continue;
                    const CrackWidth& width = edges_.width(image.edge);
                    if (!width.known || near_piece(ray, *p, width.d) != Near::No) return false;
                }
        }
        return true;
    }

    InsideAnswer by_rays(int rays) {
        struct Ray {
            int index, boxes;
        };
        std::vector<Ray> order;
        std::vector<std::vector<char>> met(kRays);
        NearTarget ray = target_;
        ray.kind = NearTarget::Ray;
        for (int k = 0; k < kRays; ++k) {
            ray.direction = ray_direction(k);
            met[k].assign(core_.model().faces.size(), 0);
            int boxes = 0;
            for (const int f : faces_) {
                const PreparedFace& face = core_.face(std::size_t(f));
                if (face.boxes.empty() && !line_misses(ray, core_.pieces().box(f), 0)) {
                    ++boxes;
                    met[k][f] = 1;
                }
                for (const auto& b : face.boxes)
                    if (!line_misses(ray, to_box(b), 0)) {
                        ++boxes;
                        met[k][f] = 1;
                    }
            }
            order.push_back({k, boxes});
        }
        std::stable_sort(order.begin(), order.end(),
                         [](const Ray& a, const Ray& b) { return a.boxes < b.boxes; });
        std::string why = "no ray found that is clear of all edges";
        int votes = 0;
        bool odd = false;
        for (const Ray& r : order) {
            ray.direction = ray_direction(r.index);
            if (!clear_of_edges(ray)) continue;
            why = "every ray found touches a face, as far as can be told";
            bool this_odd = false;
            const Count found = count(ray.direction, met[r.index], this_odd);
            if (found == Count::AtPoint) {
                // So it will be by any other ray.
                if (on_a_face()) return {InsideKind::Boundary, {}};
                return {InsideKind::Undecided, "on a face, as far as can be told"};
            }
            if (found == Count::Unsettled) continue;
            if (votes > 0 && this_odd != odd)
                throw std::logic_error("two rays from one point disagree");
            odd = this_odd;
            if (++votes == rays) break;
        }
        if (votes == 0) return {InsideKind::Undecided, why};
        return {odd ? InsideKind::Inside : InsideKind::Outside, {}};
    }

    enum class Count { Settled, Unsettled, AtPoint };

    // All hits of the ray, and `odd` their parity where they are settled.
    Count count(const std::array<double, 3>& direction, const std::vector<char>& faces,
                bool& odd) const {
        const Line line{point_, direction, LineKind::Ray};
        LineOptions options{brep_, 20000};
        options.faces = &faces;
        const LineAnswer answer = line_hits(core_, line, options);
        // A hit that is not told apart from the start is an open part, and a narrow one.
        for (const auto& open : answer.open)
            if (open.t.lo.sign() <= 0 && open.t.hi.sign() >= 0 &&
                sub_up(open.t.hi, open.t.lo).up() < kNarrow)
                return Count::AtPoint;
        odd = false;
        bool settled = answer.open.empty();
        for (const auto& hit : answer.hits) {
            if (hit.t.lo.sign() <= 0) return Count::AtPoint;
            settled &= hit.transversal && !hit.boundary && !hit.lies_in;
            odd = !odd;
        }
        return settled ? Count::Settled : Count::Unsettled;
    }

    const Core& core_;
    const Edges& edges_;
    int brep_;
    std::array<double, 3> point_;
    NearTarget target_;
    std::vector<int> faces_;   // of this BREP
    std::vector<int> around_;  // those with a box that holds the point
};

}  // namespace

InsideAnswer inside(const Core& core, const std::array<double, 3>& point, int rays) {
    InsideAnswer result{InsideKind::Outside, {}};
    for (std::size_t b = 0; b < core.model().closed.size(); ++b) {
        if (!core.model().closed[b]) continue;
        InsideAnswer one = Query(core, int(b), point).run(rays);
        if (one.kind == InsideKind::Inside) return one;
        if (one.kind == InsideKind::Undecided || result.kind == InsideKind::Outside) result = one;
    }
    return result;
}

}  // namespace feeler_oracle
