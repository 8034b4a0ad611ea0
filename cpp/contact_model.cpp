#include "contact_model.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Interval64 lerp(const Interval64& a, const Interval64& b, const Interval64& t) {
    return a + t * (b - a);
}

struct Values {
    Interval64 f, s, t;
};

// Value and first derivatives of a Bernstein polynomial over a box of parameters.
Values values(std::vector<Interval64> b, int p, int q, const Interval64& x, const Interval64& y) {
    const int w = q + 1;
    std::vector<Interval64> ds(w);
    for (int k = p; k >= 1; --k) {
        if (k == 1)
            for (int j = 0; j < w; ++j) ds[j] = Interval64(double(p)) * (b[w + j] - b[j]);
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < w; ++j) b[i * w + j] = lerp(b[i * w + j], b[(i + 1) * w + j], x);
    }
    Values r;
    for (int k = q; k >= 1; --k) {
        if (k == 1) r.t = Interval64(double(q)) * (b[1] - b[0]);
        for (int j = 0; j < k; ++j) {
            b[j] = lerp(b[j], b[j + 1], y);
            if (p > 0) ds[j] = lerp(ds[j], ds[j + 1], y);
        }
    }
    r.f = b[0];
    r.s = ds[0];
    return r;
}

double middle(const Interval64& x) { return 0.5 * x.lo + 0.5 * x.hi; }

double bernstein(const std::vector<Interval>& c, double t) {
    std::vector<double> b;
    for (const Interval& x : c) b.push_back(x.lo.near());
    for (size_t k = b.size(); k > 1; --k)
        for (size_t i = 0; i + 1 < k; ++i) b[i] += t * (b[i + 1] - b[i]);
    return b[0];
}

// Corner (i, j) of a patch, i and j 0 or 1.
std::array<Interval, 3> corner(const NativePatch& s, int i, int j) {
    const size_t at = size_t(i * s.p) * (s.q + 1) + size_t(j * s.q);
    std::array<Interval, 3> r;
    for (int k = 0; k < 3; ++k) r[k] = divide_positive(s.net[k][at], s.net[3][at]);
    return r;
}

double jumps_of(const std::vector<NativePatch>& patches) {
    double sum = 0;
    for (int k = 0; k < 2; ++k) {
        // Patches that start at a crease, by its parameter and where they start along it.
        std::map<std::pair<Q, Q>, const NativePatch*> starts;
        for (const NativePatch& s : patches)
            if (s.crease[k][0]) starts[{s.map[k].from(), s.map[1 - k].from()}] = &s;
        std::map<Q, double> lines;
        for (const NativePatch& s : patches) {
            if (!s.crease[k][1]) continue;
            const auto next = starts.find({s.map[k].to(), s.map[1 - k].from()});
            if (next == starts.end()) continue;
            const auto p = k == 0 ? corner(s, 1, 0) : corner(s, 0, 1),
                       q = corner(*next->second, 0, 0);
            double square = 0;
            for (int c = 0; c < 3; ++c) {
                const Interval64 d = (p[c] - q[c]).outer();
                const double most = std::max(-d.lo, d.hi);
                square = next_up(square + next_up(most * most));
            }
            double& gap = lines[s.map[k].to()];
            gap = std::max(gap, next_up(std::sqrt(square)));
        }
        for (const auto& line : lines) sum = next_up(sum + line.second);
    }
    return sum;
}

}  // namespace

double least_apart(const std::array<double, 6>& a, const std::array<double, 6>& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double gap =
            std::max({0.0, next_down(a[2 * k] - b[2 * k + 1]), next_down(b[2 * k] - a[2 * k + 1])});
        sum = std::max(0.0, next_down(sum + std::max(0.0, next_down(gap * gap))));
    }
    return std::max(0.0, next_down(std::sqrt(sum)));
}

double most_apart(const std::array<double, 6>& a, const std::array<double, 6>& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double gap =
            std::max(next_up(a[2 * k + 1] - b[2 * k]), next_up(b[2 * k + 1] - a[2 * k]));
        sum = next_up(sum + next_up(gap * gap));
    }
    return next_up(std::sqrt(sum));
}

double farthest(const std::array<double, 6>& k, const std::array<double, 6>& b) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double gap =
            std::max({0.0, next_up(k[2 * i] - b[2 * i]), next_up(b[2 * i + 1] - k[2 * i + 1])});
        sum = next_up(sum + next_up(gap * gap));
    }
    return next_up(std::sqrt(sum));
}

AllPieces::AllPieces(const Pieces& model) : size(model.size()) {
    for (size_t f = 0; f < model.count(); ++f) {
        faces.push_back(model.nothing(f) ? nullptr : &model.face(f));
        patches.emplace_back();
        jumps.push_back(0);
        if (!faces[f]) continue;
        for (const Piece& s : faces[f]->pieces) {
            pieces.push_back(&s);
            if (s.kind == PieceKind::Patch) patches[f].push_back(&s);
        }
        jumps[f] = jumps_of(faces[f]->patches);
        const auto& edges = region(int(f)).arc_edge();
        for (size_t a = 0; a < edges.size(); ++a) {
            if (edges[a] < 0) continue;
            if (size_t(edges[a]) >= uses_.size()) uses_.resize(edges[a] + 1);
            uses_[edges[a]].emplace_back(int(f), int(a));
        }
    }
}

Place AllPieces::place(int face, int arc, double t) const {
    const auto& arcs = faces[size_t(face)]->arcs;
    const ArcNet* of = nullptr;
    for (const ArcNet& a : arcs) {
        if (a.arc != arc) continue;
        of = &a;
        if (t <= a.to) break;
    }
    if (!of) return {-1, arc, t, 0, 0};
    const double s = (t - of->from) / (of->to - of->from);
    const double w = bernstein(of->c[2], s);
    return {face, arc, t, bernstein(of->c[0], s) / w, bernstein(of->c[1], s) / w};
}

std::vector<const Piece*> AllPieces::patches_at(int face, double u0, double u1, double v0,
                                                double v1) const {
    std::vector<const Piece*> r;
    for (const Piece* s : patches[size_t(face)])
        if (u1 >= s->uv64[0].lo && u0 <= s->uv64[1].hi && v1 >= s->uv64[2].lo &&
            v0 <= s->uv64[3].hi)
            r.push_back(s);
    return r;
}

Local evaluate(const Piece& s, const Interval64& u, const Interval64& v) {
    const auto x = s.patch->map[0].to_square64(u), y = s.patch->map[1].to_square64(v);
    const Values w = values(s.net64[3], s.p, s.q, x.s, y.s);
    Local r;
    for (int k = 0; k < 3; ++k) {
        const Values c = values(s.net64[k], s.p, s.q, x.s, y.s);
        r.p[k] = divide_positive(c.f, w.f);
        r.du[k] = divide_positive(c.s - r.p[k] * w.s, w.f) * x.slope;
        r.dv[k] = divide_positive(c.t - r.p[k] * w.t, w.f) * y.slope;
    }
    return r;
}

std::vector<std::pair<Place, double>> AllPieces::others(const Place& from) const {
    std::vector<std::pair<Place, double>> found;
    const int edge =
        from.face < 0 || from.arc < 0 ? -1 : region(from.face).arc_edge()[size_t(from.arc)];
    if (edge < 0) return found;
    const auto point = [&](int face, int arc, double t, std::array<double, 3>& p) {
        // A trim may run beyond the domain by a rounding.
        Place at = place(face, arc, t);
        if (at.face < 0) return false;
        const auto& d = region(face).domain();
        const auto clamp = [](double x, const Q& lo, const Q& hi) {
            return std::min(std::max(x, CGAL::to_double(lo)), CGAL::to_double(hi));
        };
        at.u = clamp(at.u, d[0], d[1]), at.v = clamp(at.v, d[2], d[3]);
        const auto near = patches_at(face, at.u, at.u, at.v, at.v);
        if (near.empty()) return false;
        const Local local = evaluate(*near[0], at.u, at.v);
        for (int k = 0; k < 3; ++k) p[k] = middle(local.p[k]);
        return true;
    };
    std::array<double, 3> to;
    if (!point(from.face, from.arc, from.t, to)) return found;
    const auto distance = [&](int face, int arc, double t) {
        std::array<double, 3> p;
        if (!point(face, arc, t, p)) return kInfinity;
        return std::hypot(p[0] - to[0], p[1] - to[1], p[2] - to[2]);
    };
    for (const auto& [face, arc] : uses_[size_t(edge)]) {
        if (face == from.face && arc == from.arc) continue;
        // The nearest of some samples, narrowed down; nothing rests on it.
        constexpr int kSamples = 8, kSteps = 60;
        double best = kInfinity, at = 0;
        for (int i = 0; i <= kSamples; ++i) {
            const double d = distance(face, arc, double(i) / kSamples);
            if (d < best) best = d, at = double(i) / kSamples;
        }
        if (best > 0.5 * size) continue;
        double a = std::max(0.0, at - 1.0 / kSamples), b = std::min(1.0, at + 1.0 / kSamples);
        for (int i = 0; i < kSteps && best > 0; ++i) {
            const double x = a + (b - a) * 0.382, y = a + (b - a) * 0.618;
            const double dx = distance(face, arc, x), dy = distance(face, arc, y);
            if (dx < best) best = dx, at = x;
            if (dy < best) best = dy, at = y;
            dx < dy ? b = y : a = x;
        }
        found.emplace_back(place(face, arc, at), best);
    }
    return found;
}

}  // namespace feeler_oracle
