#include "contact_ways.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double middle(const Interval64& x) { return 0.5 * x.lo + 0.5 * x.hi; }

Interval64 square(const Interval64& x) {
    const double least = x.lo > 0 ? x.lo : (x.hi < 0 ? -x.hi : 0.0);
    const double most = std::max(-x.lo, x.hi);
    return {std::max(0.0, next_down(least * least)), next_up(most * most)};
}

}  // namespace

Ways::Ways(const AllPieces& model, const Objective& objective, double join, long budget)
    : model_(model), o_(objective), join_(join), left_(budget) {}

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
    for (const auto& [place, distance] : model_.others(from))
        if (distance <= join_) found.push_back(place);
    return found;
}

bool Ways::falls(const Place& q, const std::array<double, 6>& k, double lo) {
    for (const Piece* s : model_.patches_at(q.face, q.u, q.u, q.v, q.v)) {
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
    const auto last = model_.patches_at(q.face, u1, u1, v1, v1);
    const bool low = std::all_of(last.begin(), last.end(), [&](const Piece* p) {
        return value(evaluate(*p, u1, v1)).hi < next_down(lo - join_);
    });
    if (last.empty() || !low) return false;
    left_ -= 4;
    // The segment from q to (u1, v1), these doubles being exact.
    const Q qu(q.u), qv(q.v), du = Q(u1) - qu, dv = Q(v1) - qv;
    const Interval64 step_u = Interval64(u1) - Interval64(q.u),
                     step_v = Interval64(v1) - Interval64(q.v);
    const Q s0(start), bu = qu + s0 * du, bv = qv + s0 * dv;
    if (bu < domain[0] || bu > domain[1] || bv < domain[2] || bv > domain[3]) return false;
    // (3)
    const auto ru = double_bounds(bu), rv = double_bounds(bv);
    const auto first = model_.patches_at(q.face, ru.first, ru.second, rv.first, rv.second);
    double jump = first.empty() ? kInfinity : 0;
    for (const Piece* p : first) {
        const Local b = evaluate(*p, {ru.first, ru.second}, {rv.first, rv.second});
        jump = std::max(jump, most_apart(k, {b.p[0].lo, b.p[0].hi, b.p[1].lo, b.p[1].hi, b.p[2].lo,
                                             b.p[2].hi}));
    }
    if (!(jump <= 0.9 * join_)) return false;
    // (2)
    const double jumps = model_.jumps[size_t(q.face)];
    if (!(jumps <= 0.01 * join_)) return false;
    double rise = jumps, from = start, ratio = 4;
    constexpr int kMostParts = 500;
    constexpr double kFinest = 1.02;
    for (int parts = 0; from < 1;) {
        if (++parts > kMostParts) return false;
        const double to = std::min(from * ratio, 1.0);
        const Interval64 s(from, to);
        const Interval64 u = Interval64(q.u) + s * step_u, v = Interval64(q.v) + s * step_v;
        double more = 0;
        for (const Piece* p : model_.patches_at(q.face, u.lo, u.hi, v.lo, v.hi)) {
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
    for (const auto& of_face : model_.patches)
        for (const Piece* of : of_face) {
            const Piece& s = *of;
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
        if (!b->inside && s.regional) {
            const BoxSide where = region_side(model_.in_region(s), b->at, {0, 1}, {0, 1});
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
