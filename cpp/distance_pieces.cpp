#include "distance_pieces.hpp"

#include <gmpxx.h>

#include <map>
#include <stdexcept>
#include <string>

#include "uv_curve.hpp"

namespace feeler_oracle {
namespace {

using Poly = std::vector<Interval>;

// Coefficients times C(n, i): products of such are plain convolutions.
Poly scaled(const Poly& b) {
    Poly r(b.size());
    const int n = int(b.size()) - 1;
    for (int i = 0; i <= n; ++i) r[i] = b[i] * binomial(n, i);
    return r;
}
Poly unscaled(const Poly& b) {
    Poly r(b.size());
    const int n = int(b.size()) - 1;
    for (int i = 0; i <= n; ++i) r[i] = divide_positive(b[i], binomial(n, i));
    return r;
}
Poly convolve(const Poly& a, const Poly& b) {
    Poly r(a.size() + b.size() - 1);
    for (size_t i = 0; i < a.size(); ++i)
        for (size_t j = 0; j < b.size(); ++j) r[i + j] = r[i + j] + a[i] * b[j];
    return r;
}

// s^i (w - s)^(p - i) for i = 0..p, all scaled.
std::vector<Poly> powers(const Poly& s, const Poly& c, int p) {
    std::vector<Poly> up{{Interval(1.0)}}, down{{Interval(1.0)}}, r;
    for (int i = 0; i < p; ++i) {
        up.push_back(convolve(up.back(), s));
        down.push_back(convolve(down.back(), c));
    }
    for (int i = 0; i <= p; ++i) {
        Poly x = convolve(up[i], down[p - i]);
        for (auto& k : x) k = k * binomial(p, i);
        r.push_back(std::move(x));
    }
    return r;
}

struct Net {
    int p, q;
    std::array<Poly, 4> c;
};

Interval lerp(const Interval& a, const Interval& b, const Interval& t) { return a + t * (b - a); }

// The net at local u = s: degree q in v.
Poly row_at(const Poly& c, int p, int q, const Interval& s) {
    Poly b = c;
    for (int k = 1; k <= p; ++k)
        for (int i = 0; i <= p - k; ++i)
            for (int j = 0; j <= q; ++j)
                b[i * (q + 1) + j] = lerp(b[i * (q + 1) + j], b[(i + 1) * (q + 1) + j], s);
    b.resize(q + 1);
    return b;
}
Poly column_at(const Poly& c, int p, int q, const Interval& t) {
    Poly r;
    for (int i = 0; i <= p; ++i)
        r.push_back(
            row_at(Poly(c.begin() + i * (q + 1), c.begin() + (i + 1) * (q + 1)), q, 0, t)[0]);
    return r;
}

Poly to_intervals(const std::vector<Q>& v) {
    Poly r;
    for (const Q& x : v) r.emplace_back(x.mpq());
    return r;
}

Net patch_net(const RationalBezierPatch& s) {
    return {s.p, s.q, {to_intervals(s.X), to_intervals(s.Y), to_intervals(s.Z), to_intervals(s.W)}};
}

// Whether a / w is the same at all coefficients.
bool constant_ratio(const std::vector<Q>& a, const std::vector<Q>& w) {
    for (size_t i = 1; i < a.size(); ++i)
        if (a[i] * w[0] != a[0] * w[i]) return false;
    return true;
}

bool is_affine(const RationalBezierPatch& s) {
    if (s.p != 1 || s.q != 1) return false;
    for (const Q& w : s.W)
        if (w != s.W[0]) return false;
    for (const auto* c : {&s.X, &s.Y, &s.Z})
        if ((*c)[0] + (*c)[3] != (*c)[1] + (*c)[2]) return false;
    return true;
}

// Local parameters s = (a - a0 w) / (a1 - a0) and w - s of the curve, homogeneous.
std::pair<std::vector<Q>, std::vector<Q>> local(const std::vector<Q>& a, const std::vector<Q>& w,
                                                const Q& a0, const Q& a1) {
    std::vector<Q> s, c;
    const Q length = a1 - a0;
    for (size_t i = 0; i < a.size(); ++i) {
        s.push_back((a[i] - a0 * w[i]) / length);
        c.push_back(w[i] - s.back());
    }
    return {s, c};
}

// S(c(t)) as one homogeneous Bezier curve.
Net compose(const RationalBezierPatch& s, const Net& net, const RationalBezierCurve& c) {
    const auto [su, cu] = local(c.X, c.W, s.u0, s.u1);
    const auto [sv, cv] = local(c.Y, c.W, s.v0, s.v1);
    Net r{0, 0, {}};
    const bool iso_u = constant_ratio(su, c.W), iso_v = constant_ratio(sv, c.W);
    if (is_affine(s)) {
        const Poly w = to_intervals(c.W), a = to_intervals(su), b = to_intervals(sv);
        r.p = c.degree();
        for (int k = 0; k < 4; ++k) {
            const Interval x = net.c[k][0], du = net.c[k][2] - net.c[k][0],
                           dv = net.c[k][1] - net.c[k][0];
            for (size_t i = 0; i < w.size(); ++i)
                r.c[k].push_back(x * w[i] + du * a[i] + dv * b[i]);
        }
        return r;
    }
    if (iso_u || iso_v) {
        const Q at = iso_u ? su[0] / c.W[0] : sv[0] / c.W[0];
        const int degree = iso_u ? s.q : s.p;
        const auto b = powers(scaled(to_intervals(iso_u ? sv : su)),
                              scaled(to_intervals(iso_u ? cv : cu)), degree);
        r.p = degree * c.degree();
        for (int k = 0; k < 4; ++k) {
            const Interval t(at.mpq());
            const Poly line =
                iso_u ? row_at(net.c[k], s.p, s.q, t) : column_at(net.c[k], s.p, s.q, t);
            Poly sum(r.p + 1);
            for (int i = 0; i <= degree; ++i)
                for (int m = 0; m <= r.p; ++m) sum[m] = sum[m] + line[i] * b[i][m];
            r.c[k] = unscaled(sum);
        }
        return r;
    }
    const auto bu = powers(scaled(to_intervals(su)), scaled(to_intervals(cu)), s.p);
    const auto bv = powers(scaled(to_intervals(sv)), scaled(to_intervals(cv)), s.q);
    r.p = c.degree() * (s.p + s.q);
    for (int k = 0; k < 4; ++k) {
        Poly sum(r.p + 1);
        for (int i = 0; i <= s.p; ++i) {
            Poly inner(c.degree() * s.q + 1);
            for (int j = 0; j <= s.q; ++j)
                for (size_t m = 0; m < inner.size(); ++m)
                    inner[m] = inner[m] + net.c[k][i * (s.q + 1) + j] * bv[j][m];
            const Poly x = convolve(bu[i], inner);
            for (size_t m = 0; m < x.size(); ++m) sum[m] = sum[m] + x[m];
        }
        r.c[k] = unscaled(sum);
    }
    return r;
}

Piece make_piece(PieceKind kind, int face, Net net, bool regional, bool attained,
                 std::array<Q, 4> uv) {
    Piece r{kind,     face,     net.p,         net.q, std::move(net.c), {}, {},
            regional, attained, std::move(uv), {}};
    for (int k = 0; k < 4; ++k)
        for (const Interval& x : r.net[k]) r.net64[k].push_back(x.outer());
    for (int k = 0; k < 3; ++k) {
        double lo = std::numeric_limits<double>::infinity(), hi = -lo;
        for (size_t i = 0; i < r.net[k].size(); ++i) {
            const Interval x = divide_positive(r.net[k][i], r.net[3][i]);
            lo = std::min(lo, x.lo.down());
            hi = std::max(hi, x.hi.up());
        }
        r.box[2 * k] = lo;
        r.box[2 * k + 1] = hi;
    }
    for (int k = 0; k < 4; ++k) {
        const auto b = double_bounds(r.uv[k]);
        r.uv64[k] = {b.first, b.second};
    }
    return r;
}

// ---- cuts at knot lines

struct Cut {
    Q lo, hi;
};

// Isolates the sign changes of the Bernstein polynomial g over [0, 1]: between two successive
// cuts (and before the first, and after the last) g is >= 0 throughout or <= 0 throughout.
void sign_cuts(const std::vector<Q>& g, std::vector<Cut>& cuts) {
    const int n = int(g.size()) - 1;
    const auto one_sided = [](auto begin, auto end) {
        bool plus = false, minus = false;
        for (auto i = begin; i != end; ++i) {
            plus |= sgn(*i) > 0;
            minus |= sgn(*i) < 0;
        }
        return !(plus && minus);
    };
    // Integers, a common multiple of the coefficients.
    mpz_class common = 1;
    for (const Q& x : g) mpz_lcm(common.get_mpz_t(), common.get_mpz_t(), mpq_denref(x.mpq()));
    std::vector<mpz_class> b(n + 1);
    for (int i = 0; i <= n; ++i) {
        mpz_divexact(b[i].get_mpz_t(), common.get_mpz_t(), mpq_denref(g[i].mpq()));
        b[i] *= mpz_class(mpq_numref(g[i].mpq()));
    }
    if (one_sided(b.begin(), b.end())) return;
    if (n == 1) {
        const Q root = g[0] / (g[0] - g[1]);
        cuts.push_back({root, root});
        return;
    }
    struct Item {
        std::vector<mpz_class> b;
        mpz_class index;
        int depth;
    };
    const auto at = [](const mpz_class& index, int depth) {
        mpz_class power = 1;
        power <<= depth;
        mpq_class q(index, power);
        q.canonicalize();
        return Q(q.get_mpq_t());
    };
    std::vector<Item> stack{{b, 0, 0}};
    while (!stack.empty()) {
        Item item = std::move(stack.back());
        stack.pop_back();
        if (one_sided(item.b.begin(), item.b.end())) continue;
        if (item.depth == kCutDepth) {
            cuts.push_back({at(item.index, item.depth), at(item.index + 1, item.depth)});
            continue;
        }
        // de Casteljau without the halving: row k is 2^k times too large.
        Item left{std::vector<mpz_class>(n + 1), item.index * 2, item.depth + 1};
        Item right{std::vector<mpz_class>(n + 1), item.index * 2 + 1, item.depth + 1};
        for (int k = 0; k <= n; ++k) {
            left.b[k] = item.b[0] << (n - k);
            right.b[n - k] = item.b[n - k] << (n - k);
            for (int i = 0; i < n - k; ++i) item.b[i] += item.b[i + 1];
        }
        if (left.b[n] == 0)
            cuts.push_back({at(right.index, right.depth), at(right.index, right.depth)});
        stack.push_back(std::move(right));
        stack.push_back(std::move(left));
    }
}

// The coefficients over [a, b].
std::vector<Q> restrict_to(std::vector<Q> c, const Q& a, const Q& b) {
    const int n = int(c.size()) - 1;
    if (b != Q(1)) {
        std::vector<Q> left(n + 1);
        for (int k = 0; k <= n; ++k) {
            left[k] = c[0];
            for (int i = 0; i < n - k; ++i) c[i] = c[i] + b * (c[i + 1] - c[i]);
        }
        c = left;
    }
    if (a != Q(0)) {
        const Q t = a / b;
        for (int k = 1; k <= n; ++k)
            for (int i = 0; i <= n - k; ++i) c[i] = c[i] + t * (c[i + 1] - c[i]);
    }
    return c;
}

Q value_at(std::vector<Q> c, const Q& t) {
    for (size_t k = c.size(); k > 1; --k)
        for (size_t i = 0; i + 1 < k; ++i) c[i] = c[i] + t * (c[i + 1] - c[i]);
    return c[0];
}

struct FaceBuilder {
    const Face& face;
    int index;
    const Region& region;
    std::vector<Piece>& out;
    std::vector<Piece>& clamped;
    const std::vector<RationalBezierPatch>& patches;
    int arc_index = -1;
    std::vector<Net> nets;
    std::vector<Q> lines[2];  // distinct ends of patches, sorted

    void add_point(const Net& net, size_t at, bool regional, bool attained,
                   const std::array<Q, 4>& uv) {
        Net point{0, 0, {}};
        for (int k = 0; k < 4; ++k) point.c[k] = {net.c[k][at]};
        out.push_back(
            make_piece(PieceKind::Point, index, std::move(point), regional, attained, uv));
    }

    // The part [a, b] of an arc, which lies in one closed patch or outside the domain.
    void add_trim(const RationalBezierCurve& arc, const Q& a, const Q& b) {
        const Q m = (a + b) / Q(2);
        const Q w = value_at(arc.W, m), u = value_at(arc.X, m) / w, v = value_at(arc.Y, m) / w;
        for (size_t i = 0; i < patches.size(); ++i) {
            const auto& s = patches[i];
            if (u < s.u0 || u > s.u1 || v < s.v0 || v > s.v1) continue;
            const RationalBezierCurve part{restrict_to(arc.X, a, b), restrict_to(arc.Y, a, b),
                                           restrict_to(arc.W, a, b)};
            Net net = compose(s, nets[i], part);
            const std::array<Q, 4> none{Q(0), Q(0), Q(0), Q(0)};
            add_point(net, 0, false, true, none);
            add_point(net, net.c[0].size() - 1, false, true, none);
            out.push_back(of_arc(
                make_piece(PieceKind::Trim, index, std::move(net), false, true, none), a, b));
            return;
        }
        add_clamped(arc, a, b, u, v);
    }

    Piece of_arc(Piece piece, const Q& a, const Q& b) const {
        piece.arc = arc_index;
        piece.t0 = a;
        piece.t1 = b;
        return piece;
    }

    // The part [a, b] of an arc, which lies on one side of each knot line and outside the domain,
    // around the point u, v: its image with the parameters clamped to the domain.
    void add_clamped(const RationalBezierCurve& arc, const Q& a, const Q& b, const Q& u,
                     const Q& v) {
        const auto& d = region.domain();
        RationalBezierCurve part{restrict_to(arc.X, a, b), restrict_to(arc.Y, a, b),
                                 restrict_to(arc.W, a, b)};
        const auto clamp = [&](std::vector<Q>& c, const Q& at, const Q& lo, const Q& hi) {
            if (at >= lo && at <= hi) return at;
            const Q to = at < lo ? lo : hi;
            for (size_t i = 0; i < c.size(); ++i) c[i] = to * part.W[i];
            return to;
        };
        const Q cu = clamp(part.X, u, d[0], d[1]), cv = clamp(part.Y, v, d[2], d[3]);
        for (size_t i = 0; i < patches.size(); ++i) {
            const auto& s = patches[i];
            if (cu < s.u0 || cu > s.u1 || cv < s.v0 || cv > s.v1) continue;
            clamped.push_back(of_arc(make_piece(PieceKind::Trim, index, compose(s, nets[i], part),
                                                false, false, {Q(0), Q(0), Q(0), Q(0)}),
                                     a, b));
            return;
        }
    }

    // The image of a tiny part of an arc that crosses knot lines: enclosed under each patch it
    // touches.
    void add_crossing(const RationalBezierCurve& arc, const Q& a, const Q& b) {
        const auto w = restrict_to(arc.W, a, b);
        Q box[4];
        const std::vector<Q> c[2] = {restrict_to(arc.X, a, b), restrict_to(arc.Y, a, b)};
        for (int k = 0; k < 2; ++k)
            for (size_t i = 0; i < w.size(); ++i) {
                const Q x = c[k][i] / w[i];
                if (i == 0 || x < box[2 * k]) box[2 * k] = x;
                if (i == 0 || x > box[2 * k + 1]) box[2 * k + 1] = x;
            }
        // Beyond the domain the clamped image alone is left.
        const auto& d = region.domain();
        const bool beyond = box[1] < d[0] || box[0] > d[1] || box[3] < d[2] || box[2] > d[3];
        if (beyond)
            for (int k = 0; k < 4; ++k)
                box[k] = std::min(std::max(box[k], d[k / 2 * 2]), d[k / 2 * 2 + 1]);
        for (size_t i = 0; i < patches.size(); ++i) {
            const auto& s = patches[i];
            if (box[1] < s.u0 || box[0] > s.u1 || box[3] < s.v0 || box[2] > s.v1) continue;
            const auto part = [](const Q& x, const Q& x0, const Q& x1) {
                return Q((x - x0) / (x1 - x0));
            };
            const Interval u = hull(Interval(part(box[0], s.u0, s.u1).mpq()),
                                    Interval(part(box[1], s.u0, s.u1).mpq()));
            const Interval v = hull(Interval(part(box[2], s.v0, s.v1).mpq()),
                                    Interval(part(box[3], s.v0, s.v1).mpq()));
            Net point{0, 0, {}};
            for (int k = 0; k < 4; ++k)
                point.c[k] = {row_at(row_at(nets[i].c[k], s.p, s.q, u), s.q, 0, v)[0]};
            (beyond ? clamped : out)
                .push_back(of_arc(make_piece(PieceKind::Point, index, std::move(point), false,
                                             false, {Q(0), Q(0), Q(0), Q(0)}),
                                  a, b));
        }
    }

    void add_arc(const RationalBezierCurve& arc) {
        std::vector<Cut> cuts;
        for (int k = 0; k < 2; ++k)
            for (const Q& line : lines[k]) {
                std::vector<Q> g;
                const auto& c = k == 0 ? arc.X : arc.Y;
                for (size_t i = 0; i < c.size(); ++i) g.push_back(c[i] - line * arc.W[i]);
                sign_cuts(g, cuts);
            }
        std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.lo < b.lo; });
        Q from(0);
        for (size_t i = 0; i < cuts.size();) {
            Cut merged = cuts[i];
            for (++i; i < cuts.size() && cuts[i].lo <= merged.hi; ++i)
                if (cuts[i].hi > merged.hi) merged.hi = cuts[i].hi;
            if (merged.lo > from) add_trim(arc, from, merged.lo);
            if (merged.lo < merged.hi) add_crossing(arc, merged.lo, merged.hi);
            from = merged.hi;
        }
        if (from < Q(1)) add_trim(arc, from, Q(1));
    }

    bool loops_leave_domain() const {
        const auto& d = region.domain();
        for (const auto& any : region.arcs()) {
            const auto& arc = rational_curve(any, size_t(index));
            for (size_t i = 0; i < arc.W.size(); ++i)
                if (arc.X[i] < d[0] * arc.W[i] || arc.X[i] > d[1] * arc.W[i] ||
                    arc.Y[i] < d[2] * arc.W[i] || arc.Y[i] > d[3] * arc.W[i])
                    return true;
        }
        return false;
    }

    // Whether the surface may be only C0 across u = at (k = 0) or v = at (k = 1).
    bool is_joint(int k, const Q& at) const {
        // The curves of a sum may have corners at their joints.
        if (std::holds_alternative<SumSurface>(face.surface)) return true;
        const auto* s = std::get_if<NurbsSurface>(&face.surface);
        if (!s) return false;
        const auto& knots = k == 0 ? s->knots_u : s->knots_v;
        int multiplicity = 0;
        for (double x : knots) multiplicity += Q(x) == at;
        return multiplicity >= (k == 0 ? s->degree_u : s->degree_v);
    }

    void add_joint(size_t i, int k, bool upper) {
        const auto& s = patches[i];
        Net net{k == 0 ? s.q : s.p, 0, {}};
        for (int c = 0; c < 4; ++c)
            for (int m = 0; m <= net.p; ++m)
                net.c[c].push_back(nets[i].c[c][k == 0 ? (upper ? s.p : 0) * (s.q + 1) + m
                                                       : m * (s.q + 1) + (upper ? s.q : 0)]);
        std::array<Q, 4> uv{s.u0, s.u1, s.v0, s.v1};
        uv[2 * k] = uv[2 * k + 1] = upper ? uv[2 * k + 1] : uv[2 * k];
        const bool regional = !region.whole_domain();
        for (int end = 0; end < 2; ++end) {
            std::array<Q, 4> corner = uv;
            const int other = 2 - 2 * k;
            corner[other] = corner[other + 1] = uv[other + end];
            add_point(net, end == 0 ? 0 : net.p, regional, true, corner);
        }
        out.push_back(make_piece(PieceKind::Joint, index, std::move(net), regional, true, uv));
    }

    void run() {
        if (face.loops && face.loops->empty()) return;
        for (const auto& s : patches) {
            nets.push_back(patch_net(s));
            lines[0].push_back(s.u0);
            lines[0].push_back(s.u1);
            lines[1].push_back(s.v0);
            lines[1].push_back(s.v1);
        }
        for (auto& l : lines) {
            std::sort(l.begin(), l.end());
            l.erase(std::unique(l.begin(), l.end()), l.end());
        }
        const bool borders = region.whole_domain() || loops_leave_domain();
        for (size_t i = 0; i < patches.size(); ++i) {
            const auto& s = patches[i];
            const std::array<Q, 4> uv{s.u0, s.u1, s.v0, s.v1};
            out.push_back(
                make_piece(PieceKind::Patch, index, nets[i], !region.whole_domain(), true, uv));
            for (int k = 0; k < 2; ++k) {
                const bool first = uv[2 * k] == lines[k].front(),
                           last = uv[2 * k + 1] == lines[k].back();
                if (first ? borders : is_joint(k, uv[2 * k])) add_joint(i, k, false);
                if (last && borders) add_joint(i, k, true);
            }
        }
        for (const auto& arc : region.arcs()) {
            ++arc_index;
            add_arc(rational_curve(arc, size_t(index)));
        }
    }
};

}  // namespace

const Interval& binomial(int n, int k) {
    thread_local std::map<int, std::vector<Interval>> table;
    auto& row = table[n];
    if (row.empty())
        for (int i = 0; i <= n; ++i) {
            mpz_class b;
            mpz_bin_uiui(b.get_mpz_t(), n, i);
            row.emplace_back(mpq_class(b).get_mpq_t());
        }
    return row[k];
}

bool clear_of_arcs(const std::vector<ArcNet>& arcs, const Interval& u, const Interval& v) {
    // Beyond this depth the hulls are no smaller than the noise of the enclosures.
    constexpr int kDepth = 280;
    // A curve that passes at a distance of the order of the box's size is told from it by a few
    // pieces a level.
    constexpr int kPieces = 4000;
    int count = 0;
    std::vector<std::pair<ArcNet, int>> stack;
    for (const ArcNet& arc : arcs) {
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

Pieces prepare_pieces(const std::vector<const PreparedFace*>& faces) {
    Pieces r;
    for (size_t i = 0; i < faces.size(); ++i) {
        const PreparedFace& f = *faces[i];
        r.regions.push_back(&f.region);
        r.arcs.emplace_back();
        require_rational(*f.face, i);
        for (const auto& any : f.region.arcs()) {
            const auto& arc = rational_curve(any, i);
            r.arcs.back().push_back(
                {{to_intervals(arc.X), to_intervals(arc.Y), to_intervals(arc.W)}});
        }
        const size_t first = r.pieces.size();
        FaceBuilder{*f.face, int(i), f.region, r.pieces, r.clamped, f.patches, -1, {}, {}}.run();
        for (size_t k = first; k < r.pieces.size(); ++k) {
            for (double x : r.pieces[k].box)
                if (!(std::fabs(x) <= kLargest))
                    throw std::invalid_argument("face " + std::to_string(i) +
                                                ": a coordinate out of range");
            for (const Interval64& w : r.pieces[k].net64[3])
                if (!(w.lo >= 1 / kLargest && w.hi <= kLargest))
                    throw std::invalid_argument("face " + std::to_string(i) +
                                                ": a weight out of range");
        }
    }
    double lo[3], hi[3];
    for (size_t i = 0; i < r.pieces.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            const auto& b = r.pieces[i].box;
            lo[k] = i == 0 ? b[2 * k] : std::min(lo[k], b[2 * k]);
            hi[k] = i == 0 ? b[2 * k + 1] : std::max(hi[k], b[2 * k + 1]);
        }
    for (int k = 0; k < 3 && !r.pieces.empty(); ++k) r.size += (hi[k] - lo[k]) * (hi[k] - lo[k]);
    r.size = std::sqrt(r.size);
    return r;
}

}  // namespace feeler_oracle
