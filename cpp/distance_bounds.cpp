#include "distance_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double clamp_down(double x) { return std::isnan(x) ? -kInfinity : x; }

// Coefficients of difference schemes of A - T B: T is the same number in all of them, so the
// differences are formed first.
class Differences64 {
 public:
    // ma, mb: the magnitudes of a and b.
    Differences64(const Net64& n, double ma, double mb)
        : a_(next_up(n.ra + ma * 0x1p-51)),
          b_(next_up(n.rb + mb * 0x1p-51)),
          ea_(next_up(n.ea + n.ratio * 0x1p-51)),
          eb_(next_up(n.eb + 0x1p-51)) {}

    // `weight`: the sum of the magnitudes of the scheme's factors; `sum`: of their products with
    // the b_k. A difference has at most 4 terms: 3 roundings of at most 2^-53 of weight max |a|, or
    // of ratio times `sum`.
    Interval64 of(double da, double db, double weight, double sum, const Interval64& t) const {
        const double s = next_up(sum * (1 + 0x1p-50));
        const double ea = next_up(std::min(weight * a_, ea_ * s));
        const double eb = next_up(std::min(weight * b_, eb_ * s));
        return Interval64(next_down(da - ea), next_up(da + ea)) -
               t * Interval64(next_down(db - eb), next_up(db + eb));
    }

 private:
    double a_, b_, ea_, eb_;
};

// Differences to derivatives.
Curvature finish(Curvature r, Degrees d) {
    r.uu = d.p < 2 ? 0 : next_down(r.uu * (d.p * (d.p - 1)));
    r.vv = d.q < 2 ? 0 : next_down(r.vv * (d.q * (d.q - 1)));
    r.uv = next_up(r.uv * (d.p * d.q));
    return r;
}

double value64(std::vector<double> b, Degrees d, double x, double y) {
    const int w = d.q + 1;
    for (int k = d.p; k >= 1; --k)
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < w; ++j)
                b[i * w + j] = (1 - x) * b[i * w + j] + x * b[(i + 1) * w + j];
    for (int k = d.q; k >= 1; --k)
        for (int j = 0; j < k; ++j) b[j] = (1 - y) * b[j] + y * b[j + 1];
    return b[0];
}

}  // namespace

Interval64 box_bounds(const Objective& o, const std::array<double, 6>& box) {
    Interval64 sum(o.linear ? -o.h : 0.0);
    for (int k = 0; k < 3; ++k) {
        const Interval64 range(box[2 * k], box[2 * k + 1]);
        if (o.linear) {
            sum = sum + Interval64(o.c[k]) * range;
        } else {
            const Interval64 x = range - Interval64(o.c[k]);
            const double least = x.lo > 0 ? x.lo : (x.hi < 0 ? -x.hi : 0.0);
            const double most = std::max(-x.lo, x.hi);
            sum = sum + Interval64(std::max(0.0, next_down(least * least)), next_up(most * most));
        }
    }
    return sum;
}

bool Curvature::convex(Degrees d) const {
    if (d.p == 0) return true;
    if (d.q == 0) return uu > 0;
    return uu > 0 && vv > 0 && next_down(uu * vv) > next_up(uv * uv);
}

double Curvature::loss(Degrees d, double rx, double ry) const {
    const double xx = next_up(rx * rx), yy = next_up(ry * ry);
    // -(a z^2) / 2
    const auto one = [](double a, double zz) {
        return a >= 0 ? 0.0 : next_up(0.5 * next_up(-a * zz));
    };
    if (d.p == 0) return 0;
    if (d.q == 0) return one(uu, xx);
    if (convex(d)) return 0;
    double least = next_up(next_up(one(uu, xx) + one(vv, yy)) + next_up(next_up(uv * rx) * ry));
    // Completing the square: a x^2 + 2 b x y + c y^2 >= (a - b^2 / c) x^2.
    const auto completed = [this](double a, double c) {
        return next_down(a - next_up(next_up(uv * uv) / c));
    };
    if (vv > 0) least = std::min(least, one(completed(uu, vv), xx));
    if (uu > 0) least = std::min(least, one(completed(vv, uu), yy));
    return std::isnan(least) ? kInfinity : least;
}

double Curvature::least_eigenvalue(Degrees d) const {
    if (d.q == 0) return uu;
    return next_down(next_down(next_down(uu * vv) - next_up(uv * uv)) / next_up(uu + vv));
}

// ---- doubles

double lower_bound(const Net64& n) {
    double lo = kInfinity;
    for (size_t i = 0; i < n.a.size(); ++i) {
        const double a = next_down(n.a[i] - n.error_a(i)), rb = n.error_b(i);
        const double b = a >= 0 ? next_up(n.b[i] + rb) : next_down(n.b[i] - rb);
        if (b <= 0) return -kInfinity;
        lo = std::min(lo, next_down(a / b));
    }
    return clamp_down(lo);
}

namespace {

// Above a / b for a, b within ra, rb of the values.
double quotient_above(double a, double ra, double b, double rb) {
    const double high = next_up(a + ra);
    const double below = high >= 0 ? next_down(b - rb) : next_up(b + rb);
    return below > 0 ? next_up(high / below) : kInfinity;
}

}  // namespace

double value_above(const Net64& n, size_t k) {
    return quotient_above(n.a[k], n.error_a(k), n.b[k], n.error_b(k));
}

double value_above(const Net64& n, Degrees d, double x, double y) {
    // de Casteljau: each of the p + q levels rounds three times, by parts of sums of magnitudes;
    // twice that is allowed for, also in the value of b, below.
    const double errors = 8 * (d.p + d.q + 1) * 0x1p-53;
    const double a = value64(n.a, d, x, y), b = value64(n.b, d, x, y), s = b * (1 + errors);
    const double ra = next_up(n.ra + errors * magnitude(n.a));
    const double rb = next_up(n.rb + errors * magnitude(n.b));
    return quotient_above(a, std::min(ra, next_up(next_up(n.ea + errors * n.ratio) * s)), b,
                          std::min(rb, next_up(next_up(n.eb + errors) * s)));
}

double magnitude(const std::vector<double>& c) {
    double m = 0;
    for (double x : c) m = std::max(m, std::fabs(x));
    return m;
}

bool monotone(const Net64& n, Degrees d, bool along_u, const Interval64& t, double ma, double mb) {
    if ((along_u ? d.p : d.q) == 0) return false;
    const size_t step = along_u ? d.q + 1 : 1;
    const Differences64 difference(n, ma, mb);
    bool up = true, down = true;
    for (int i = 0; i <= d.p - (along_u ? 1 : 0); ++i)
        for (int j = 0; j <= d.q - (along_u ? 0 : 1); ++j) {
            const size_t k = d.index(i, j);
            const Interval64 x = difference.of(n.a[k + step] - n.a[k], n.b[k + step] - n.b[k], 2,
                                               n.b[k + step] + n.b[k], t);
            up &= x.lo > 0;
            down &= x.hi < 0;
            if (!up && !down) return false;
        }
    return true;
}

Curvature curvature(const Net64& n, Degrees d, const Interval64& t, double ma, double mb) {
    Curvature r{kInfinity, kInfinity, 0};
    const Differences64 difference(n, ma, mb);
    const auto second = [&](size_t k, size_t step) {
        const double ends = n.b[k + 2 * step] + n.b[k], middle = 2 * n.b[k + step];
        return difference
            .of(n.a[k + 2 * step] - 2 * n.a[k + step] + n.a[k], n.b[k + 2 * step] - middle + n.b[k],
                4, ends + middle, t)
            .lo;
    };
    const size_t w = d.q + 1;
    for (int i = 0; i + 2 <= d.p; ++i)
        for (int j = 0; j <= d.q; ++j) r.uu = std::min(r.uu, second(d.index(i, j), w));
    for (int i = 0; i <= d.p; ++i)
        for (int j = 0; j + 2 <= d.q; ++j) r.vv = std::min(r.vv, second(d.index(i, j), 1));
    for (int i = 0; i < d.p; ++i)
        for (int j = 0; j < d.q; ++j) {
            const size_t k = d.index(i, j);
            const double sum = n.b[k + w + 1] + n.b[k + w] + n.b[k + 1] + n.b[k];
            const Interval64 x =
                difference.of(n.a[k + w + 1] - n.a[k + w] - n.a[k + 1] + n.a[k],
                              n.b[k + w + 1] - n.b[k + w] - n.b[k + 1] + n.b[k], 4, sum, t);
            r.uv = std::max(r.uv, std::max(-x.lo, x.hi));
        }
    return finish(r, d);
}

// ---- intervals

Real lower_bound(const NetMp& n) {
    Real lo(kInfinity);
    for (size_t i = 0; i < n.a.size(); ++i) {
        const Real& a = n.a[i].lo;
        const Real q = div_down(a, a.sign() >= 0 ? n.b[i].hi : n.b[i].lo);
        if (q < lo) lo = q;
    }
    return lo;
}

bool monotone(const NetMp& n, Degrees d, bool along_u, const Interval& t) {
    if ((along_u ? d.p : d.q) == 0) return false;
    const size_t step = along_u ? d.q + 1 : 1;
    bool up = true, down = true;
    for (int i = 0; i <= d.p - (along_u ? 1 : 0); ++i)
        for (int j = 0; j <= d.q - (along_u ? 0 : 1); ++j) {
            const size_t k = d.index(i, j);
            const Interval x = n.a[k + step] - n.a[k] - t * (n.b[k + step] - n.b[k]);
            up &= x.lo.sign() > 0;
            down &= x.hi.sign() < 0;
            if (!up && !down) return false;
        }
    return true;
}

Curvature curvature(const NetMp& n, Degrees d, const Interval& t) {
    Curvature r{kInfinity, kInfinity, 0};
    const auto second = [&](const std::vector<Interval>& c, size_t k, size_t step) {
        const Interval& m = c[k + step];
        return c[k + 2 * step] + c[k] - (m + m);
    };
    const size_t w = d.q + 1;
    for (int i = 0; i + 2 <= d.p; ++i)
        for (int j = 0; j <= d.q; ++j) {
            const size_t k = d.index(i, j);
            r.uu = std::min(r.uu, (second(n.a, k, w) - t * second(n.b, k, w)).lo.down());
        }
    for (int i = 0; i <= d.p; ++i)
        for (int j = 0; j + 2 <= d.q; ++j) {
            const size_t k = d.index(i, j);
            r.vv = std::min(r.vv, (second(n.a, k, 1) - t * second(n.b, k, 1)).lo.down());
        }
    const auto mixed = [&](const std::vector<Interval>& c, size_t k) {
        return (c[k + w + 1] + c[k]) - (c[k + w] + c[k + 1]);
    };
    for (int i = 0; i < d.p; ++i)
        for (int j = 0; j < d.q; ++j) {
            const size_t k = d.index(i, j);
            const Interval x = mixed(n.a, k) - t * mixed(n.b, k);
            r.uv = std::max(r.uv, std::max(-x.lo.down(), x.hi.up()));
        }
    return finish(r, d);
}

std::vector<double> scaled_difference(const NetMp& n, const Real& t, long& exponent) {
    std::vector<Real> h(n.a.size());
    exponent = 0;
    bool any = false;
    for (size_t i = 0; i < h.size(); ++i) {
        h[i] = (n.a[i] - Interval(t) * n.b[i]).middle();
        if (h[i].sign() == 0) continue;
        const long e = mpfr_get_exp(h[i].get());
        if (!any || e > exponent) exponent = e;
        any = true;
    }
    std::vector<double> r;
    for (Real& x : h) {
        mpfr_mul_2si(x.get(), x.get(), -exponent, MPFR_RNDN);
        r.push_back(x.near());
    }
    return r;
}

// ---- where to split

bool split_along_u(const std::vector<double>& h, Degrees d, const DyadicBox& at) {
    if (d.q == 0) return true;
    if (d.p == 0) return false;
    constexpr double kSlopeWeight = 1.0 / 16;
    double u = 0, v = 0;
    const size_t w = d.q + 1;
    for (int i = 0; i <= d.p; ++i)
        for (int j = 0; j <= d.q; ++j) {
            const size_t k = d.index(i, j);
            if (i < d.p) u = std::max(u, kSlopeWeight * d.p * std::fabs(h[k + w] - h[k]));
            if (j < d.q) v = std::max(v, kSlopeWeight * d.q * std::fabs(h[k + 1] - h[k]));
            if (i + 2 <= d.p)
                u = std::max(u, d.p * (d.p - 1) * std::fabs(h[k + 2 * w] - 2 * h[k + w] + h[k]));
            if (j + 2 <= d.q)
                v = std::max(v, d.q * (d.q - 1) * std::fabs(h[k + 2] - 2 * h[k + 1] + h[k]));
        }
    return u > v || (u == v && at.lu <= at.lv);
}

bool allowed_along_u(bool wanted, Degrees d, const DyadicBox& at, bool far) {
    if (d.q == 0) return true;
    if (d.p == 0) return false;
    const int most_uneven = far ? 120 : 40;
    if (!may_halve(at, true, far) || at.lu > at.lv + most_uneven) return false;
    if (!may_halve(at, false, far) || at.lv > at.lu + most_uneven) return true;
    return wanted;
}

bool deepest(const DyadicBox& at, Degrees d, bool far) {
    return (d.p == 0 || !may_halve(at, true, far)) && (d.q == 0 || !may_halve(at, false, far));
}

}  // namespace feeler_oracle
