#include "patch_curve.hpp"

#include <algorithm>

#include "net.hpp"
#include "roots.hpp"

namespace feeler_oracle {
namespace {

constexpr int kBits = 256;

struct Break {
    Q lo, hi;
    bool on_loop;
};

void add_roots(const Bernstein& f, std::vector<Break>& breaks) {
    for (const auto& [lo, hi] : isolate_roots(f, kBits)) breaks.push_back({lo, hi, false});
}

std::array<Q, 4> hull_of(const RationalBezierCurve& c) {
    std::array<Q, 4> h;
    for (std::size_t i = 0; i < c.W.size(); ++i) {
        const Q u = c.X[i] / c.W[i], v = c.Y[i] / c.W[i];
        h[0] = i == 0 ? u : std::min(h[0], u);
        h[1] = i == 0 ? u : std::max(h[1], u);
        h[2] = i == 0 ? v : std::min(h[2], v);
        h[3] = i == 0 ? v : std::max(h[3], v);
    }
    return h;
}

bool disjoint(const std::array<Q, 4>& a, const std::array<Q, 4>& b) {
    return a[0] > b[1] || a[1] < b[0] || a[2] > b[3] || a[3] < b[2];
}

// Where a loop's arc meets the curve.
void loop_breaks(const RationalBezierCurve& arc, const RationalBezierPatch& patch,
                 const PatchCurve& curve, std::vector<Break>& breaks) {
    if (disjoint(hull_of(arc), {patch.u0, patch.u1, patch.v0, patch.v1})) return;
    LocalArc local = local_arc(arc, patch);
    if (curve.swapped) std::swap(local.x, local.y);
    const int k = int(std::max(curve.n.size(), curve.d.size())) - 1;
    const auto at = [&](const Bernstein& f) {
        // f in degree k.
        const Bernstein one(std::size_t(k) + 1, Q(0));
        return composed(combination(Q(1), f, Q(1), one), 0, k, local.w, local.y, local.w);
    };
    const Bernstein off =
        combination(Q(1), product(at(curve.d), local.x), Q(-1), product(at(curve.n), local.w));
    const auto add = [&](const Q& lo, const Q& hi) {
        if (lo == hi) {
            const Q s = value(local.y, lo) / value(local.w, lo);
            breaks.push_back({s, s, true});
            return;
        }
        const Interval s = divide_positive(range(local.y, lo, hi), range(local.w, lo, hi));
        breaks.push_back({to_exact(s.lo), to_exact(s.hi), true});
    };
    if (is_zero(off)) {
        // Along the curve: its ends, and where it turns.
        add(Q(0), Q(0));
        add(Q(1), Q(1));
        const Bernstein turn = combination(Q(1), product(derivative(local.y), local.w), Q(-1),
                                           product(local.y, derivative(local.w)));
        if (!is_zero(turn))
            for (const auto& [lo, hi] : isolate_roots(turn, kBits)) add(lo, hi);
        return;
    }
    // On one side of the curve.
    const auto all = [&off](int s) {
        return std::all_of(off.begin(), off.end(), [s](const Q& x) { return sign(x) == s; });
    };
    if (all(1) || all(-1)) return;
    for (const auto& [lo, hi] : isolate_roots(off, kBits)) add(lo, hi);
}

}  // namespace

LocalArc local_arc(const RationalBezierCurve& arc, const RationalBezierPatch& patch) {
    LocalArc r{{}, {}, arc.W};
    const Q du = patch.u1 - patch.u0, dv = patch.v1 - patch.v0;
    for (std::size_t i = 0; i < arc.W.size(); ++i) {
        r.x.push_back((arc.X[i] - patch.u0 * arc.W[i]) / du);
        r.y.push_back((arc.Y[i] - patch.v0 * arc.W[i]) / dv);
    }
    return r;
}

bool runs_in_region(const PreparedFace& face, const RationalBezierPatch& patch,
                    const PatchCurve& curve, const Bernstein& cuts, std::vector<CurveRun>& runs) {
    std::vector<Break> breaks = {{Q(0), Q(0), false}, {Q(1), Q(1), false}};
    add_roots(curve.n, breaks);
    add_roots(curve.d, breaks);
    add_roots(combination(Q(1), curve.n, Q(-1), curve.d), breaks);
    add_roots(cuts, breaks);
    for (const auto& any : face.region.arcs()) {
        const auto* arc = std::get_if<RationalBezierCurve>(&any);
        if (!arc) return false;
        loop_breaks(*arc, patch, curve, breaks);
    }
    const Q zero(0), one(1), half(1, 2);
    std::vector<Break> distinct;
    std::sort(breaks.begin(), breaks.end(),
              [](const Break& a, const Break& b) { return a.lo < b.lo; });
    for (const Break& b : breaks) {
        if (b.hi < zero || one < b.lo) continue;
        if (!distinct.empty() && b.lo <= distinct.back().hi) {
            distinct.back().hi = std::max(distinct.back().hi, b.hi);
            distinct.back().on_loop |= b.on_loop;
        } else {
            distinct.push_back(b);
        }
    }
    // The side of the point at s; outside the square it is another patch's.
    const auto side_at = [&](const Q& s) {
        const Q d = value(curve.d, s);
        if (sign(d) == 0) return Side::Outside;
        Q u = value(curve.n, s) / d, v = s;
        if (u < zero || one < u) return Side::Outside;
        if (curve.swapped) std::swap(u, v);
        return side(face.region, patch.u0 + u * (patch.u1 - patch.u0),
                    patch.v0 + v * (patch.v1 - patch.v0));
    };
    for (std::size_t i = 0; i < distinct.size(); ++i) {
        const Break& b = distinct[i];
        std::optional<Side> next;
        if (i + 1 < distinct.size()) next = side_at((b.hi + distinct[i + 1].lo) * half);
        if (next && *next != Side::Outside) {
            const Break& e = distinct[i + 1];
            runs.push_back({b.lo, b.hi, e.lo, e.hi, *next == Side::Boundary});
            continue;
        }
        // A point of the region that no run holds?
        if (!runs.empty() && runs.back().last_lo == b.lo && runs.back().last_hi == b.hi) continue;
        if (b.lo == b.hi) {
            if (side_at(b.lo) != Side::Outside) runs.push_back({b.lo, b.hi, b.lo, b.hi, true});
        } else if (b.on_loop) {
            // On a loop; whether in the square, too.
            Interval n = range(curve.n, b.lo, b.hi), d = range(curve.d, b.lo, b.hi);
            if (d.hi.sign() < 0) {
                n = -n;
                d = -d;
            }
            if (d.lo.sign() <= 0) return false;
            const Interval u = divide_positive(n, d);
            if (u.hi.sign() < 0 || Real(1.0) < u.lo) continue;
            if (u.lo.sign() < 0 || Real(1.0) < u.hi || b.lo < zero || one < b.hi) return false;
            runs.push_back({b.lo, b.hi, b.lo, b.hi, true});
        }
    }
    return true;
}

std::optional<std::vector<std::pair<Q, Q>>> near_box(const RationalBezierCurve& curve,
                                                     const std::array<Q, 4>& box,
                                                     const std::array<Q, 4>& larger) {
    struct Part {
        RationalBezierCurve c;
        Q lo, hi;
    };
    constexpr std::size_t kMost = 2000;
    std::vector<Part> stack;
    stack.push_back({curve, Q(0), Q(1)});
    std::vector<std::pair<Q, Q>> near;
    for (std::size_t count = 0; !stack.empty(); ++count) {
        if (count > kMost) return std::nullopt;
        const Part part = std::move(stack.back());
        stack.pop_back();
        const auto h = hull_of(part.c);
        if (disjoint(h, box)) continue;
        if (larger[0] <= h[0] && h[1] <= larger[1] && larger[2] <= h[2] && h[3] <= larger[3]) {
            near.emplace_back(part.lo, part.hi);
            continue;
        }
        const Q middle = (part.lo + part.hi) * Q(1, 2);
        Part a{{}, part.lo, middle}, b{{}, middle, part.hi};
        halve(part.c.X, a.c.X, b.c.X);
        halve(part.c.Y, a.c.Y, b.c.Y);
        halve(part.c.W, a.c.W, b.c.W);
        stack.push_back(std::move(a));
        stack.push_back(std::move(b));
    }
    return near;
}

}  // namespace feeler_oracle
