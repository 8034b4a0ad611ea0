#include "contact_bounds.hpp"

#include <algorithm>
#include <cmath>

#include "distance_bounds.hpp"

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Differences of A - T B over a box; weight: the sum of magnitudes of the scheme's factors, at most
// 4 terms.
struct Differences {
    const Net64& n;
    double ma, mb;
    explicit Differences(const Net64& net) : n(net), ma(magnitude(net.a)), mb(magnitude(net.b)) {}
    Interval64 at(double da, double db, double weight, const Interval64& t) const {
        const double ea = next_up(weight * next_up(n.ra + ma * 0x1p-51));
        const double eb = next_up(weight * next_up(n.rb + mb * 0x1p-51));
        return Interval64(next_down(da - ea), next_up(da + ea)) -
               t * Interval64(next_down(db - eb), next_up(db + eb));
    }
};

}  // namespace

Interval64 range_of(const Net64& n) {
    double lo = kInfinity, hi = -kInfinity;
    for (size_t i = 0; i < n.a.size(); ++i) {
        const double b0 = next_down(n.b[i] - n.rb), b1 = next_up(n.b[i] + n.rb);
        if (!(b0 > 0)) return {-kInfinity, kInfinity};
        const Interval64 x =
            divide_positive({next_down(n.a[i] - n.ra), next_up(n.a[i] + n.ra)}, {b0, b1});
        lo = std::min(lo, x.lo);
        hi = std::max(hi, x.hi);
    }
    return {lo, hi};
}

double rooted_down(const Objective& o, double f) {
    if (o.linear) return f;
    return f > 0 ? std::max(0.0, next_down(std::sqrt(f))) : 0.0;
}

double rooted_up(const Objective& o, double f) {
    if (o.linear) return f;
    return f > 0 ? next_up(std::sqrt(f)) : 0.0;
}

int slope_sign(const Net64& n, Degrees d, bool along_u, const Interval64& t, double blur) {
    const int degree = along_u ? d.p : d.q;
    if (degree == 0) return 0;
    const Differences form(n);
    // The derivative is the degree times these.
    const double least = blur > 0 ? next_up(blur / degree) : 0;
    const size_t step = along_u ? d.q + 1 : 1;
    bool up = true, down = true;
    for (int i = 0; i <= d.p - (along_u ? 1 : 0); ++i)
        for (int j = 0; j <= d.q - (along_u ? 0 : 1); ++j) {
            const size_t k = d.index(i, j);
            const Interval64 x = form.at(n.a[k + step] - n.a[k], n.b[k + step] - n.b[k], 2, t);
            up &= x.lo > least;
            down &= x.hi < -least;
            if (!up && !down) return 0;
        }
    return up ? 1 : -1;
}

bool Hessian::convex(Degrees d) const {
    if (d.p == 0) return true;
    if (d.q == 0) return uu.lo > 0;
    const double m = std::max(-uv.lo, uv.hi);
    return uu.lo > 0 && vv.lo > 0 && next_down(uu.lo * vv.lo) > next_up(m * m);
}

double Hessian::least_eigenvalue(Degrees d) const {
    if (d.q == 0) return uu.lo;
    const double m = std::max(-uv.lo, uv.hi);
    return next_down(next_down(next_down(uu.lo * vv.lo) - next_up(m * m)) / next_up(uu.lo + vv.lo));
}

bool Hessian::falls(Degrees d, bool corner) const {
    if (d.p > 0 && uu.hi < 0) return true;
    if (d.q > 0 && vv.hi < 0) return true;
    if (d.p == 0 || d.q == 0 || corner) return false;
    const auto middle = [](const Interval64& x) { return 0.5 * x.lo + 0.5 * x.hi; };
    const double a = middle(uu), b = middle(uv), c = middle(vv);
    const double root = std::hypot(0.5 * (a - c), b), low = 0.5 * (a + c) - root;
    if (!(low < 0)) return false;
    // The eigenvector (b, low - a) or (low - c, b).
    double x = b, y = low - a;
    if (std::fabs(low - c) > std::fabs(y)) x = low - c, y = b;
    const double size = std::max(std::fabs(x), std::fabs(y));
    if (!(size > 0)) return false;
    x /= size, y /= size;
    const Interval64 form = uu * Interval64(x) * Interval64(x) +
                            Interval64(2.0) * uv * Interval64(x) * Interval64(y) +
                            vv * Interval64(y) * Interval64(y);
    return form.hi < 0;
}

Hessian hessian(const Net64& n, Degrees d, const Interval64& t, double blur) {
    const Differences form(n);
    const size_t w = d.q + 1;
    const auto join = [](Interval64& r, const Interval64& x, bool first) {
        r = first ? x : Interval64(std::min(r.lo, x.lo), std::max(r.hi, x.hi));
    };
    const auto second = [&](size_t k, size_t step) {
        return form.at(n.a[k + 2 * step] - 2 * n.a[k + step] + n.a[k],
                       n.b[k + 2 * step] - 2 * n.b[k + step] + n.b[k], 4, t);
    };
    Hessian r;
    for (int i = 0; i + 2 <= d.p; ++i)
        for (int j = 0; j <= d.q; ++j) join(r.uu, second(d.index(i, j), w), i == 0 && j == 0);
    for (int i = 0; i <= d.p; ++i)
        for (int j = 0; j + 2 <= d.q; ++j) join(r.vv, second(d.index(i, j), 1), i == 0 && j == 0);
    for (int i = 0; i < d.p; ++i)
        for (int j = 0; j < d.q; ++j) {
            const size_t k = d.index(i, j);
            join(r.uv,
                 form.at(n.a[k + w + 1] - n.a[k + w] - n.a[k + 1] + n.a[k],
                         n.b[k + w + 1] - n.b[k + w] - n.b[k + 1] + n.b[k], 4, t),
                 i == 0 && j == 0);
        }
    r.uu = r.uu * Interval64(double(d.p * (d.p - 1)));
    if (blur > 0) r.uu = r.uu + Interval64(-blur, blur);
    r.vv = r.vv * Interval64(double(d.q * (d.q - 1)));
    r.uv = r.uv * Interval64(double(d.p * d.q));
    return r;
}

bool is_noise(const Net64& n, double tau) {
    const Differences form(n);
    double bend = 0;
    for (size_t i = 0; i < n.a.size(); ++i) bend = std::max(bend, std::fabs(n.a[i] - tau * n.b[i]));
    constexpr double kNoise = 4;
    return bend <=
           kNoise * (n.ra + form.ma * 0x1p-51 + std::fabs(tau) * (n.rb + form.mb * 0x1p-51));
}

}  // namespace feeler_oracle
