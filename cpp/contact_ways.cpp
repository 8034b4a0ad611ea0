#include "contact_ways.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>

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

Interval64 square(const Interval64& x) {
    const double least = x.lo > 0 ? x.lo : (x.hi < 0 ? -x.hi : 0.0);
    const double most = std::max(-x.lo, x.hi);
    return {std::max(0.0, next_down(least * least)), next_up(most * most)};
}

double bernstein(const std::vector<double>& c, double t) {
    std::vector<double> b = c;
    for (size_t k = b.size(); k > 1; --k)
        for (size_t i = 0; i + 1 < k; ++i) b[i] += t * (b[i + 1] - b[i]);
    return b[0];
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

namespace {

// Above the distance of any point of b from the box k.
double farthest(const std::array<double, 6>& k, const std::array<double, 6>& b) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double gap =
            std::max({0.0, next_up(k[2 * i] - b[2 * i]), next_up(b[2 * i + 1] - k[2 * i + 1])});
        sum = next_up(sum + next_up(gap * gap));
    }
    return next_up(std::sqrt(sum));
}

}  // namespace

AllPieces::AllPieces(const Pieces& model) : size(model.size()) {
    const auto refuse = [](size_t face) {
        throw std::invalid_argument("contacts: face " + std::to_string(face) +
                                    " has a native surface or an arc: not served yet");
    };
    for (size_t f = 0; f < model.count(); ++f) {
        faces.push_back(model.nothing(f) ? nullptr : &model.face(f));
        if (!faces[f]) continue;
        for (const NativePatch& s : faces[f]->patches)
            if (!s.map[0].linear() || !s.map[1].linear()) refuse(f);
        for (const RegionArc& arc : faces[f]->region->arcs())
            if (std::holds_alternative<CircularArc>(arc)) refuse(f);
        for (const Piece& s : faces[f]->pieces) {
            if (s.slack != 0) refuse(f);
            pieces.push_back(&s);
        }
    }
}

Ways::Ways(const AllPieces& model, const Objective& objective, double join, long budget)
    : model_(model), o_(objective), join_(join), left_(budget) {
    patches_.resize(model.faces.size());
    for (size_t i = 0; i < model.pieces.size(); ++i)
        if (model.pieces[i]->kind == PieceKind::Patch)
            patches_[model.pieces[i]->face].push_back(int(i));
    for (size_t f = 0; f < model.faces.size(); ++f) {
        if (!model.faces[f]) continue;
        const auto& edges = model.region(int(f)).arc_edge();
        for (size_t a = 0; a < edges.size(); ++a) {
            if (edges[a] < 0) continue;
            if (size_t(edges[a]) >= uses_.size()) uses_.resize(edges[a] + 1);
            uses_[edges[a]].emplace_back(int(f), int(a));
        }
    }
}

Place Ways::place(int face, int arc, double t) const {
    const auto& c = model_.arcs(face)[size_t(arc)].c;
    double at[3];
    for (int k = 0; k < 3; ++k) {
        std::vector<double> b;
        for (const auto& x : c[k]) b.push_back(x.lo.near());
        at[k] = bernstein(b, t);
    }
    return {face, arc, t, at[0] / at[2], at[1] / at[2]};
}

std::vector<const Piece*> Ways::patches_at(int face, double u0, double u1, double v0,
                                           double v1) const {
    std::vector<const Piece*> r;
    for (int i : patches_[face]) {
        const Piece& s = *model_.pieces[i];
        if (u1 >= s.uv64[0].lo && u0 <= s.uv64[1].hi && v1 >= s.uv64[2].lo && v0 <= s.uv64[3].hi)
            r.push_back(&s);
    }
    return r;
}

Ways::Local Ways::evaluate(const Piece& s, const Interval64& u, const Interval64& v) const {
    const auto local = [](const Interval64& x, const Interval64& x0, const Interval64& x1) {
        const Interval64 r = divide_positive(x - x0, x1 - x0);
        return Interval64(std::min(1.0, std::max(0.0, r.lo)), std::max(0.0, std::min(1.0, r.hi)));
    };
    const Interval64 x = local(u, s.uv64[0], s.uv64[1]), y = local(v, s.uv64[2], s.uv64[3]);
    const Interval64 lu = s.uv64[1] - s.uv64[0], lv = s.uv64[3] - s.uv64[2];
    const Values w = values(s.net64[3], s.p, s.q, x, y);
    Local r;
    for (int k = 0; k < 3; ++k) {
        const Values c = values(s.net64[k], s.p, s.q, x, y);
        r.p[k] = divide_positive(c.f, w.f);
        r.du[k] = divide_positive(divide_positive(c.s - r.p[k] * w.s, w.f), lu);
        r.dv[k] = divide_positive(divide_positive(c.t - r.p[k] * w.t, w.f), lv);
    }
    return r;
}

// The sign of the derivative of f along (wu, wv).
Interval64 Ways::slope(const Local& at, const Interval64& wu, const Interval64& wv) const {
    Interval64 sum;
    for (int k = 0; k < 3; ++k) {
        const Interval64 step = wu * at.du[k] + wv * at.dv[k];
        sum = sum + (o_.linear ? Interval64(o_.c[k]) : at.p[k] - Interval64(o_.c[k])) * step;
    }
    return sum;
}

// f itself.
Interval64 Ways::value(const Local& at) const {
    Interval64 sum(o_.linear ? -o_.h : 0.0);
    for (int k = 0; k < 3; ++k)
        sum = sum +
              (o_.linear ? Interval64(o_.c[k]) * at.p[k] : square(at.p[k] - Interval64(o_.c[k])));
    return {rooted_down(o_, sum.lo), rooted_up(o_, sum.hi)};
}

std::vector<Place> Ways::partners(const Place& from) const {
    std::vector<Place> found;
    for (const auto& [place, distance] : others(from))
        if (distance <= join_) found.push_back(place);
    return found;
}

double Ways::gap(const Place& from) const {
    double least = kInfinity;
    for (const auto& other : others(from)) least = std::min(least, other.second);
    return std::isfinite(least) ? least : 0;
}

std::vector<std::pair<Place, double>> Ways::others(const Place& from) const {
    std::vector<std::pair<Place, double>> found;
    const int edge = from.arc < 0 ? -1 : model_.region(from.face).arc_edge()[from.arc];
    if (edge < 0) return found;
    const auto point = [&](int face, int arc, double t, std::array<double, 3>& p) {
        // A trim may run beyond the domain by a rounding.
        Place at = place(face, arc, t);
        const auto& d = model_.region(face).domain();
        const auto clamp = [](double x, const Q& lo, const Q& hi) {
            return std::min(std::max(x, CGAL::to_double(lo)), CGAL::to_double(hi));
        };
        at.u = clamp(at.u, d[0], d[1]), at.v = clamp(at.v, d[2], d[3]);
        const auto patches = patches_at(face, at.u, at.u, at.v, at.v);
        if (patches.empty()) return false;
        const Local local = evaluate(*patches[0], at.u, at.v);
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
    for (const auto& [face, arc] : uses_[edge]) {
        if (face == from.face && arc == from.arc) continue;
        // The nearest of some samples, narrowed down; nothing rests on it.
        constexpr int kSamples = 8, kSteps = 60;
        double best = kInfinity, at = 0;
        for (int i = 0; i <= kSamples; ++i) {
            const double d = distance(face, arc, double(i) / kSamples);
            if (d < best) best = d, at = double(i) / kSamples;
        }
        if (best > 0.5 * model_.size) continue;
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

bool Ways::falls(const Place& q, const std::array<double, 6>& k, double lo) {
    for (const Piece* s : patches_at(q.face, q.u, q.u, q.v, q.v)) {
        // Directions of unit length in space, about: steepest descent, then all around (at a foot
        // that is no minimum f falls to second order only).
        const Local at = evaluate(*s, q.u, q.v);
        double e = 0, g = 0;
        for (int i = 0; i < 3; ++i) {
            e += middle(at.du[i]) * middle(at.du[i]);
            g += middle(at.dv[i]) * middle(at.dv[i]);
        }
        const double tiny = 1e-20 * (e + g);
        const double ru = e > tiny ? 1 / std::sqrt(e) : 0, rv = g > tiny ? 1 / std::sqrt(g) : 0;
        const double gu = -middle(slope(at, ru, 0)), gv = -middle(slope(at, 0, rv));
        const double size = std::hypot(gu, gv);
        constexpr int kAround = 8;
        for (int i = -1; i < kAround; ++i) {
            if (left_ <= 0) return false;
            const double angle = 2 * M_PI * i / kAround;
            const double x = i < 0 ? gu / size : std::cos(angle),
                         y = i < 0 ? gv / size : std::sin(angle);
            if (!std::isfinite(x + y) || (x * ru == 0 && y * rv == 0)) continue;
            for (const int bits : {7, 11, 15, 19, 24}) {
                --left_;
                const double length = std::ldexp(model_.size, -bits);
                if (falls_along(q, x * ru * length, y * rv * length, 0.25 * join_ / length, k, lo))
                    return true;
            }
        }
    }
    return false;
}

bool Ways::falls_along(const Place& q, double su, double sv, double start,
                       const std::array<double, 6>& k, double lo) {
    const Region& region = model_.region(q.face);
    const auto& domain = region.domain();
    const double u1 = q.u + su, v1 = q.v + sv;
    if (!(start < 0.01) || (u1 == q.u && v1 == q.v)) return false;
    if (box_side(region, u1, u1, v1, v1) == BoxSide::Outside) return false;
    // (4)
    const auto last = patches_at(q.face, u1, u1, v1, v1);
    const bool low = std::any_of(last.begin(), last.end(), [&](const Piece* p) {
        return value(evaluate(*p, u1, v1)).hi < next_down(lo - join_);
    });
    if (!low) return false;
    left_ -= 4;
    // The segment from q to (u1, v1), these doubles being exact.
    const Q qu(q.u), qv(q.v), du = Q(u1) - qu, dv = Q(v1) - qv;
    const Interval64 step_u = Interval64(u1) - Interval64(q.u),
                     step_v = Interval64(v1) - Interval64(q.v);
    const Q s0(start), bu = qu + s0 * du, bv = qv + s0 * dv;
    if (bu < domain[0] || bu > domain[1] || bv < domain[2] || bv > domain[3]) return false;
    // (3)
    const auto ru = double_bounds(bu), rv = double_bounds(bv);
    const auto first = patches_at(q.face, ru.first, ru.second, rv.first, rv.second);
    double jump = kInfinity;
    for (const Piece* p : first) {
        const Local b = evaluate(*p, {ru.first, ru.second}, {rv.first, rv.second});
        jump = std::min(jump, most_apart(k, {b.p[0].lo, b.p[0].hi, b.p[1].lo, b.p[1].hi, b.p[2].lo,
                                             b.p[2].hi}));
    }
    if (!(jump <= 0.9 * join_)) return false;
    // (2)
    double rise = 0, from = start, ratio = 4;
    constexpr int kMostParts = 500;
    constexpr double kFinest = 1.02;
    for (int parts = 0; from < 1;) {
        if (++parts > kMostParts) return false;
        const double to = std::min(from * ratio, 1.0);
        const Interval64 s(from, to);
        const Interval64 u = Interval64(q.u) + s * step_u, v = Interval64(q.v) + s * step_v;
        double more = 0;
        for (const Piece* p : patches_at(q.face, u.lo, u.hi, v.lo, v.hi)) {
            const Local b = evaluate(*p, u, v);
            const Interval64 up = slope(b, step_u, step_v);
            if (up.hi <= 0) continue;
            // The distance grows by at most slope / distance.
            const double least = o_.linear ? 1 : value(b).lo;
            if (!(least > 0)) return false;
            more = std::max(more, next_up(next_up(up.hi / least) * next_up(to - from)));
        }
        if (more > 0.01 * join_ && ratio > kFinest) {
            ratio = std::sqrt(ratio);
            continue;
        }
        rise = next_up(rise + more);
        from = to;
        if (!(next_up(jump + rise) <= 0.99 * join_)) return false;
    }
    // (1)
    // (no loop: Boundary is the border of the domain, which belongs to the region there)
    if (side(region, Q(u1), Q(v1)) == Side::Outside) return false;
    ratio = 1024;
    for (from = start; from < 1;) {
        const double to = std::min(1.0, from * ratio);
        const Q a(from), b(to);
        std::array<Q, 4> box{qu + a * du, qu + b * du, qv + a * dv, qv + b * dv};
        if (box[1] < box[0]) std::swap(box[0], box[1]);
        if (box[3] < box[2]) std::swap(box[2], box[3]);
        if (loops_clear(region, box)) {
            from = to;
        } else {
            ratio = std::sqrt(ratio);
            if (ratio < 1.1) return false;
        }
    }
    return true;
}

namespace {

struct WallBox {
    const Piece* piece;
    DyadicBox at;
    Net64 f;
    std::array<Net64, 3> x;  // coordinates
    bool inside;
};

Interval64 part(const Interval64& from, const Interval64& to, int level, std::uint64_t index) {
    const auto at = [&](double i) {
        return from + Interval64(std::ldexp(i, -level)) * (to - from);
    };
    const bool last = index + 1 == (std::uint64_t(1) << level);
    return {index == 0 ? from.lo : std::max(from.lo, at(double(index)).lo),
            last ? to.hi : std::min(to.hi, at(double(index) + 1).hi)};
}

// The length of the control polygon along u (or v), about.
double extent(const WallBox& b, bool along_u) {
    const int p = b.piece->p, q = b.piece->q;
    double most = 0;
    const int lines = along_u ? q : p, n = along_u ? p : q;
    for (int m = 0; m <= lines; ++m) {
        double sum = 0;
        for (int i = 0; i < n; ++i) {
            double step = 0;
            for (int k = 0; k < 3; ++k) {
                const size_t from = along_u ? size_t(i) * (q + 1) + m : size_t(m) * (q + 1) + i;
                const size_t to = from + (along_u ? q + 1 : 1);
                step += std::fabs(b.x[k].a[to] / b.x[k].b[to] - b.x[k].a[from] / b.x[k].b[from]);
            }
            sum += step;
        }
        most = std::max(most, sum);
    }
    return most;
}

}  // namespace

bool Ways::walled(const std::array<double, 6>& k, double hi, double near, double far) {
    constexpr long kMost = 1500;
    long count = 0;
    const double least = next_up(hi + join_);
    // The wall as a bound on the objective's own value.
    const double wall = o_.linear ? least : next_up(next_up(least * least));
    std::vector<std::unique_ptr<WallBox>> stack;
    for (const auto& of_face : patches_)
        for (int i : of_face) {
            const Piece& s = *model_.pieces[i];
            if (least_apart(k, s.box) > far || farthest(k, s.box) < near) continue;
            auto b = std::make_unique<WallBox>(WallBox{&s, {}, objective_net64(o_, s), {}, false});
            for (int c = 0; c < 3; ++c) {
                std::array<double, 3> axis{};
                axis[c] = 1;
                b->x[c] = objective_net64({true, axis, 0}, s);
            }
            stack.push_back(std::move(b));
        }
    while (!stack.empty()) {
        const auto b = std::move(stack.back());
        stack.pop_back();
        if (++count > kMost || --left_ <= 0) return false;
        const Piece& s = *b->piece;
        std::array<double, 6> box;
        for (int c = 0; c < 3; ++c) {
            const Interval64 r = range_of(b->x[c]);
            box[2 * c] = r.lo, box[2 * c + 1] = r.hi;
        }
        const double nearest = least_apart(k, box), most = farthest(k, box);
        if (nearest > far || most < near) continue;
        const Interval64 f = range_of(b->f);
        if (f.lo > wall) continue;
        const Interval64 u = part(s.uv64[0], s.uv64[1], b->at.lu, b->at.iu),
                         v = part(s.uv64[2], s.uv64[3], b->at.lv, b->at.iv);
        if (!b->inside && s.regional) {
            const BoxSide where = box_side(model_.region(s.face), u.lo, u.hi, v.lo, v.hi);
            if (where == BoxSide::Outside) continue;
            b->inside = where == BoxSide::Inside;
        }
        if ((b->inside || !s.regional) && nearest >= near && most <= far && f.hi < wall)
            return false;
        const bool along_u = extent(*b, true) >= extent(*b, false);
        if ((along_u ? b->at.lu : b->at.lv) >= kDeepest) return false;
        auto l =
            std::make_unique<WallBox>(WallBox{&s, b->at.half(along_u, false), {}, {}, b->inside});
        auto r =
            std::make_unique<WallBox>(WallBox{&s, b->at.half(along_u, true), {}, {}, b->inside});
        split64(b->f, objective_degrees(o_, s), along_u, l->f, r->f);
        for (int c = 0; c < 3; ++c) split64(b->x[c], Degrees{s.p, s.q}, along_u, l->x[c], r->x[c]);
        stack.push_back(std::move(l));
        stack.push_back(std::move(r));
    }
    return true;
}

}  // namespace feeler_oracle
