#include "trim_image.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "taylor.hpp"
#include "trim_cuts.hpp"

namespace feeler_oracle {
namespace {

using Poly = std::vector<Interval>;

Poly to_intervals(const std::vector<Q>& v) {
    Poly r;
    for (const Q& x : v) r.emplace_back(x.mpq());
    return r;
}

// ---- composition where all is rational

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

// s^i c^(p - i) for i = 0..p, all scaled.
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

// Local parameters s = (x - x0 w) / (x1 - x0) and w - s of the curve, homogeneous.
struct Local {
    Poly s, c;
};
Local local(const UvCurve& curve, int k, const ParameterMap& map) {
    Local r;
    if (curve.exact) {
        const auto& x = k == 0 ? curve.exact->X : curve.exact->Y;
        const auto& w = curve.exact->W;
        const Q length = map.to() - map.from();
        for (size_t i = 0; i < x.size(); ++i) {
            const Q s = (x[i] - map.from() * w[i]) / length;
            r.s.emplace_back(s.mpq());
            r.c.emplace_back(Q(w[i] - s).mpq());
        }
        return r;
    }
    const Interval from(map.from().mpq()), to(map.to().mpq()),
        length(Q(map.to() - map.from()).mpq());
    for (size_t i = 0; i < curve.c[2].size(); ++i) {
        r.s.push_back(divide_positive(curve.c[k][i] - from * curve.c[2][i], length));
        r.c.push_back(divide_positive(to * curve.c[2][i] - curve.c[k][i], length));
    }
    return r;
}

// The constant value of a parameter along the curve, if it is known to be constant.
std::optional<Q> constant_value(const UvCurve& curve, int k) {
    if (!curve.exact) return std::nullopt;
    const auto& x = k == 0 ? curve.exact->X : curve.exact->Y;
    const auto& w = curve.exact->W;
    for (size_t i = 1; i < x.size(); ++i)
        if (x[i] * w[0] != x[0] * w[i]) return std::nullopt;
    return Q(x[0] / w[0]);
}

Interval lerp(const Interval& a, const Interval& b, const Interval& t) { return a + t * (b - a); }

// The net at local u = s (k = 0) or local v = s: one coefficient for each along the other.
Poly line_at(const Poly& c, int p, int q, int k, const Interval& s) {
    const int n = k == 0 ? p : q, lines = k == 0 ? q : p;
    const int step = k == 0 ? q + 1 : 1, line_step = k == 0 ? 1 : q + 1;
    Poly r;
    for (int m = 0; m <= lines; ++m) {
        Poly b;
        for (int i = 0; i <= n; ++i) b.push_back(c[i * step + m * line_step]);
        for (int level = n; level >= 1; --level)
            for (int i = 0; i < level; ++i) b[i] = lerp(b[i], b[i + 1], s);
        r.push_back(b[0]);
    }
    return r;
}

// Over [a, b], which is in [0, 1].
Poly restricted(Poly c, const Interval& a, const Interval& b) {
    const int n = int(c.size()) - 1;
    // Over [0, b] first, unless b is small against what is left out below.
    const bool upper_first = b.lo.near() >= 0.5;
    const auto keep_lower = [&](const Interval& t) {
        for (int level = 1; level <= n; ++level)
            for (int i = n; i >= level; --i) c[i] = lerp(c[i - 1], c[i], t);
    };
    const auto keep_upper = [&](const Interval& t) {
        for (int level = 1; level <= n; ++level)
            for (int i = 0; i + level <= n; ++i) c[i] = lerp(c[i], c[i + 1], t);
    };
    if (upper_first) {
        keep_lower(b);
        keep_upper(divide_positive(a, b));
    } else {
        const Interval rest = Interval(1.0) - a;
        keep_upper(a);
        keep_lower(divide_positive(b - a, rest));
    }
    return c;
}

TrimImage compose_affine(const NativePatch& s, const UvCurve& c) {
    const Local u = local(c, 0, s.map[0]), v = local(c, 1, s.map[1]);
    TrimImage r{Q(0), Q(1), c.degree(), {}, 0};
    for (int k = 0; k < 4; ++k) {
        const Interval x = s.net[k][0], du = s.net[k][2] - s.net[k][0],
                       dv = s.net[k][1] - s.net[k][0];
        for (size_t i = 0; i < c.c[2].size(); ++i)
            r.net[k].push_back(x * c.c[2][i] + du * u.s[i] + dv * v.s[i]);
    }
    return r;
}

TrimImage compose_linear(const NativePatch& s, const UvCurve& c) {
    const Local u = local(c, 0, s.map[0]), v = local(c, 1, s.map[1]);
    const auto bu = powers(scaled(u.s), scaled(u.c), s.p),
               bv = powers(scaled(v.s), scaled(v.c), s.q);
    TrimImage r{Q(0), Q(1), c.degree() * (s.p + s.q), {}, 0};
    for (int k = 0; k < 4; ++k) {
        Poly sum(r.degree + 1);
        for (int i = 0; i <= s.p; ++i) {
            Poly inner(c.degree() * s.q + 1);
            for (int j = 0; j <= s.q; ++j)
                for (size_t m = 0; m < inner.size(); ++m)
                    inner[m] = inner[m] + s.net[k][i * (s.q + 1) + j] * bv[j][m];
            const Poly x = convolve(bu[i], inner);
            for (size_t m = 0; m < x.size(); ++m) sum[m] = sum[m] + x[m];
        }
        r.net[k] = unscaled(sum);
    }
    return r;
}

// Parameter k is constant, the other one linear in the square's.
TrimImage compose_line(const NativePatch& s, const UvCurve& c, int k, const Interval& at) {
    const Local other = local(c, 1 - k, s.map[1 - k]);
    const int degree = k == 0 ? s.q : s.p;
    const auto b = powers(scaled(other.s), scaled(other.c), degree);
    TrimImage r{Q(0), Q(1), degree * c.degree(), {}, 0};
    for (int x = 0; x < 4; ++x) {
        const Poly line = line_at(s.net[x], s.p, s.q, k, at);
        Poly sum(r.degree + 1);
        for (int i = 0; i <= degree; ++i)
            for (int m = 0; m <= r.degree; ++m) sum[m] = sum[m] + line[i] * b[i][m];
        r.net[x] = unscaled(sum);
    }
    return r;
}

// Parameter k is constant, the other one goes by an angle; if the curve runs one way.
std::optional<TrimImage> reparametrised_line(const NativePatch& s, const UvCurve& c, int k,
                                             const Interval& at) {
    const auto& y = k == 0 ? c.exact->Y : c.exact->X;
    const auto& w = c.exact->W;
    const Q first = y.front() / w.front(), last = y.back() / w.back();
    const Q &low = std::min(first, last), &high = std::max(first, last);
    // The values are those between the ends, because none of the hull lies beyond.
    for (size_t i = 0; i < y.size(); ++i)
        if (y[i] < low * w[i] || y[i] > high * w[i]) return std::nullopt;
    const ParameterMap& map = s.map[1 - k];
    const Interval a = map.to_square(Interval(low.mpq())), b = map.to_square(Interval(high.mpq()));
    TrimImage r{Q(0), Q(1), k == 0 ? s.q : s.p, {}, 0};
    for (int x = 0; x < 4; ++x) {
        r.net[x] = restricted(line_at(s.net[x], s.p, s.q, k, at), a, b);
        if (last < first) std::reverse(r.net[x].begin(), r.net[x].end());
    }
    return r;
}

// ---- Taylor polynomials

Interval64 convert(const Interval& x, const Interval64&) { return x.outer(); }
Interval convert(const Interval& x, const Interval&) { return x; }

// The Taylor coefficients in sigma = 2 t - 1 of a Bernstein polynomial over [0, 1]: at sigma = 0.
Series<Interval> expansion(Poly b, int order, const Interval&) {
    const int n = int(b.size()) - 1;
    // The upper half, over sigma in [0, 1].
    for (int level = 1; level <= n; ++level)
        for (int i = 0; i + level <= n; ++i) b[i] = average(b[i], b[i + 1]);
    Series<Interval> r(order + 1, Interval(0.0));
    for (int k = 0; k <= std::min(n, order); ++k) {
        r[k] = binomial(n, k) * b[0];
        for (int i = 0; i + k < n; ++i) b[i] = b[i + 1] - b[i];
    }
    return r;
}

// Those at all sigma of [-1, 1].
Series<Interval64> expansion(Poly b, int order, const Interval64&) {
    const int n = int(b.size()) - 1;
    Series<Interval64> r(order + 1, Interval64(0.0));
    for (int k = 0; k <= std::min(n, order); ++k) {
        Interval all = b[0];
        for (int i = 1; i + k <= n; ++i) all = hull(all, b[i]);
        r[k] = (binomial(n, k) * all).outer() * Interval64(std::ldexp(1.0, -k));
        for (int i = 0; i + k < n; ++i) b[i] = b[i + 1] - b[i];
    }
    return r;
}

// Series in the place of s and 1 - s: up to a common factor (trim_image.hpp).
template <class T>
std::array<Series<T>, 2> weights(const UvCurve& c, int k, const ParameterMap& map, int order) {
    const Local x = local(c, k, map);
    Series<T> s = expansion(x.s, order, T());
    bool plain = true;
    for (const Interval& w : c.c[2]) plain &= w.is_point() && mpfr_cmp_ui(w.lo.get(), 1) == 0;
    if (!plain) s = divide(s, expansion(c.c[2], order, T()));
    if (map.linear()) {
        Series<T> rest = scale(T(-1.0), s);
        rest[0] = rest[0] + T(1.0);
        return {s, rest};
    }
    const T h = convert(map.half(), T());
    const Series<T> alpha = scale(h, s);
    Series<T> rest = scale(T(-1.0), alpha);
    rest[0] = rest[0] + h;
    return {sine(alpha), sine(rest)};
}

// s^i c^(n - i) C(n, i) for i = 0..n.
template <class T>
std::vector<Series<T>> series_powers(const Series<T>& s, const Series<T>& c, int n) {
    Series<T> one(s.size(), T(0.0));
    one[0] = T(1.0);
    std::vector<Series<T>> up{one}, down{one}, r;
    for (int i = 0; i < n; ++i) {
        up.push_back(i == 0 ? s : multiply(up.back(), s));
        down.push_back(i == 0 ? c : multiply(down.back(), c));
    }
    for (int i = 0; i <= n; ++i) {
        const T b = convert(binomial(n, i), T());
        r.push_back(scale(b, i == 0 ? down[n] : i == n ? up[n] : multiply(up[i], down[n - i])));
    }
    return r;
}

// The series of the three coordinates of S(c).
template <class T>
std::array<Series<T>, 3> coordinates(const NativePatch& s, const UvCurve& c, int order) {
    const auto u = weights<T>(c, 0, s.map[0], order), v = weights<T>(c, 1, s.map[1], order);
    const auto pu = series_powers(u[0], u[1], s.p), pv = series_powers(v[0], v[1], s.q);
    std::array<Series<T>, 4> sum;
    for (auto& x : sum) x.assign(order + 1, T(0.0));
    for (int i = 0; i <= s.p; ++i)
        for (int j = 0; j <= s.q; ++j) {
            const Series<T> b = multiply(pu[i], pv[j]);
            for (int k = 0; k < 4; ++k) {
                const T x = convert(s.net[k][i * (s.q + 1) + j], T());
                for (int m = 0; m <= order; ++m) sum[k][m] = sum[k][m] + x * b[m];
            }
        }
    for (const auto& series : sum)
        for (const T& x : series) check(x);
    return {divide(sum[0], sum[3]), divide(sum[1], sum[3]), divide(sum[2], sum[3])};
}

// A bound on the distance of S(c) from its Taylor polynomial; not finite where none is found.
double taylor_slack(const NativePatch& s, const UvCurve& c) {
    try {
        const auto all = coordinates<Interval64>(s, c, kOrder + 1);
        double slack = 0;
        for (const auto& x : all) {
            const Interval64& last = x[kOrder + 1];
            slack = next_up(slack + std::max(-last.lo, last.hi));
        }
        return slack;
    } catch (const std::range_error&) {
        return INFINITY;
    }
}

// Coefficient of z^k in (1 - z)^(n - j) (1 + z)^j, over C(n, k): Bernstein coefficient j of
// sigma^k, its polar form at n - j times -1 and j times +1 (Ramshaw). Row j.
const std::vector<std::vector<Interval>>& power_to_bernstein() {
    static thread_local std::vector<std::vector<Interval>> table;
    if (!table.empty()) return table;
    for (int j = 0; j <= kOrder; ++j) {
        std::vector<double> c{1.0};
        for (int i = 0; i < kOrder; ++i) {
            std::vector<double> next(c.size() + 1, 0.0);
            for (size_t k = 0; k < c.size(); ++k) {
                next[k] += c[k];
                next[k + 1] += i < j ? c[k] : -c[k];
            }
            c = next;  // whole numbers below 2^kOrder: exact
        }
        std::vector<Interval> row;
        for (int k = 0; k <= kOrder; ++k)
            row.push_back(divide_positive(Interval(c[k]), binomial(kOrder, k)));
        table.push_back(std::move(row));
    }
    return table;
}

TrimImage taylor_image(const NativePatch& s, const UvCurve& c, double slack) {
    const auto all = coordinates<Interval>(s, c, kOrder);
    TrimImage r{Q(0), Q(1), kOrder, {}, slack};
    for (int k = 0; k < 3; ++k)
        for (const auto& row : power_to_bernstein()) {
            Interval sum(0.0);
            for (int m = 0; m <= kOrder; ++m) sum = sum + row[m] * all[k][m];
            r.net[k].push_back(sum);
        }
    r.net[3].assign(kOrder + 1, Interval(1.0));
    return r;
}

double patch_size(const NativePatch& s) {
    double size = 0;
    for (int k = 0; k < 3; ++k) {
        double lo = INFINITY, hi = -INFINITY;
        for (size_t i = 0; i < s.net[3].size(); ++i) {
            const Interval64 x = divide_positive(s.net[k][i].outer(), s.net[3][i].outer());
            lo = std::min(lo, x.lo);
            hi = std::max(hi, x.hi);
        }
        size = std::max(size, hi - lo);
    }
    return size;
}

std::vector<TrimImage> taylor_images(const NativePatch& s, const UvCurve& c) {
    // So many halvings at most: then the slack stays what it is.
    constexpr int kDeepest = 16;
    const double wanted = std::ldexp(patch_size(s), -kSlackBits);
    std::vector<TrimImage> out;
    struct Item {
        Q a, b;
        UvCurve curve;
        int depth;
    };
    std::vector<Item> stack{{Q(0), Q(1), c, 0}};
    while (!stack.empty()) {
        Item item = std::move(stack.back());
        stack.pop_back();
        const double slack = taylor_slack(s, item.curve);
        if (slack <= wanted || item.depth == kDeepest) {
            if (!std::isfinite(slack))
                throw std::runtime_error("a trim curve whose image is not bounded");
            TrimImage image = taylor_image(s, item.curve, slack);
            image.a = item.a;
            image.b = item.b;
            out.push_back(std::move(image));
            continue;
        }
        const Q middle = (item.a + item.b) / Q(2), half = Q(1) / Q(2);
        stack.push_back({middle, item.b, part_of(item.curve, half, Q(1)), item.depth + 1});
        stack.push_back({item.a, middle, part_of(item.curve, Q(0), half), item.depth + 1});
    }
    return out;
}

// Whether the composition has a degree, and weights, that a search takes: not those of degree 25
// composed with cubics, nor the 50th power of a weight of 1e12.
bool composes_well(const UvCurve& c, int degree) {
    constexpr int kHighest = 48;
    constexpr double kMostBits = 80;
    if (c.degree() * degree > kHighest) return false;
    long least = 0, most = 0;
    for (size_t i = 0; i < c.c[2].size(); ++i) {
        const long e = mpfr_get_exp(c.c[2][i].lo.get());
        least = i == 0 ? e : std::min(least, e);
        most = i == 0 ? e : std::max(most, e);
    }
    const double far = std::max(std::labs(least), std::labs(most));
    return far * degree <= kMostBits;
}

}  // namespace

UvCurve uv_curve(const RationalBezierCurve& curve) {
    return {{to_intervals(curve.X), to_intervals(curve.Y), to_intervals(curve.W)}, curve};
}

namespace {

// center + radius (cos a x' + sin a y'), enclosed.
std::array<Interval, 2> circle_point(const Circle& circle, const CosSin& a) {
    const Interval x(circle.x[0].mpq()), y(circle.x[1].mpq());
    const Interval length = square_root(square(x) + square(y));
    if (length.lo.sign() <= 0) throw std::invalid_argument("a circle without direction");
    const Interval r = divide_positive(Interval(circle.radius.mpq()), length);
    const Interval sin = circle.clockwise ? -a.sin : a.sin;
    return {Interval(circle.center[0].mpq()) + r * (a.cos * x - sin * y),
            Interval(circle.center[1].mpq()) + r * (a.cos * y + sin * x)};
}

std::array<Interval, 2> enclosed(const EndPoint& p) {
    if (const auto* q = std::get_if<0>(&p))
        return {Interval((*q)[0].mpq()), Interval((*q)[1].mpq())};
    const auto& c = std::get<CirclePoint>(p);
    return circle_point(c.circle, cos_sin(Interval(c.angle.mpq())));
}

}  // namespace

UvPieces uv_curves(const RegionArc& arc) {
    UvPieces r;
    r.at.push_back(Q(0));
    if (const auto* c = std::get_if<RationalBezierCurve>(&arc)) {
        r.pieces.push_back(uv_curve(*c));
    } else if (const auto* s = std::get_if<Segment>(&arc)) {
        const auto a = enclosed(s->from), b = enclosed(s->to);
        r.pieces.push_back(
            {{Poly{a[0], b[0]}, Poly{a[1], b[1]}, Poly{Interval(1.0), Interval(1.0)}}, {}});
    } else {
        const auto& a = std::get<CircularArc>(arc);
        // More than a turn adds no points.
        const Q most(7), turn = a.end - a.start;
        const Q end = turn > most ? a.start + most : -turn > most ? a.start - most : a.end;
        const auto cuts = turn_cuts(a.start, end);
        const std::array<Interval, 2> center{Interval(a.circle.center[0].mpq()),
                                             Interval(a.circle.center[1].mpq())};
        for (size_t i = 0; i + 1 < cuts.size(); ++i) {
            const TurnNet net = turn_net(cuts[i], cuts[i + 1]);
            UvCurve c;
            for (int j = 0; j < 3; ++j) {
                const auto p = circle_point(a.circle, {net.cos[j], net.sin[j]});
                for (int k = 0; k < 2; ++k)
                    c.c[k].push_back(p[k] + center[k] * (net.w[j] - Interval(1.0)));
                c.c[2].push_back(net.w[j]);
            }
            r.pieces.push_back(std::move(c));
            if (i + 2 < cuts.size()) r.at.push_back((cuts[i + 1] - a.start) / turn);
        }
    }
    r.at.push_back(Q(1));
    return r;
}

UvCurve part_of(const UvCurve& curve, const Q& a, const Q& b) {
    if (a == Q(0) && b == Q(1)) return curve;
    if (curve.exact)
        return uv_curve({restrict_to(curve.exact->X, a, b), restrict_to(curve.exact->Y, a, b),
                         restrict_to(curve.exact->W, a, b)});
    UvCurve r;
    for (int k = 0; k < 3; ++k)
        r.c[k] = restricted(curve.c[k], Interval(a.mpq()), Interval(b.mpq()));
    return r;
}

std::vector<TrimImage> trim_images(const NativePatch& patch, const UvCurve& curve) {
    if (patch.affine) return {compose_affine(patch, curve)};
    for (int k = 0; k < 2; ++k) {
        const auto at = constant_value(curve, k);
        if (!at) continue;
        const Interval s = patch.map[k].to_square(Interval(at->mpq()));
        if (patch.map[1 - k].linear() && composes_well(curve, k == 0 ? patch.q : patch.p))
            return {compose_line(patch, curve, k, s)};
        // Also of high degrees and far apart weights.
        if (auto line = reparametrised_line(patch, curve, k, s)) return {*line};
    }
    if (patch.map[0].linear() && patch.map[1].linear() && composes_well(curve, patch.p + patch.q))
        return {compose_linear(patch, curve)};
    return taylor_images(patch, curve);
}

std::array<Interval, 4> point_at(const NativePatch& patch, const Interval& s, const Interval& t) {
    std::array<Interval, 4> r;
    for (int k = 0; k < 4; ++k)
        r[k] = line_at(line_at(patch.net[k], patch.p, patch.q, 0, s), patch.q, 0, 0, t)[0];
    return r;
}

}  // namespace feeler_oracle
