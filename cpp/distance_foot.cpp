#include "distance_foot.hpp"

#include <cmath>

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Newton's step along the direction of largest second derivative alone.
void steepest_step(const Newton64& at, double gu, double gv, double& dx, double& dy) {
    const double half = 0.5 * (at.uu - at.vv), root = std::hypot(half, at.uv);
    const double largest = 0.5 * (at.uu + at.vv) + root;
    double eu = half >= 0 ? half + root : at.uv, ev = half >= 0 ? at.uv : root - half;
    const double length = std::hypot(eu, ev);
    eu /= length;
    ev /= length;
    const double step = -(gu * eu + gv * ev) / largest;
    dx = step * eu;
    dy = step * ev;
}

// The least of g (y - z) over y in [0, 1].
Real least_linear(const Interval& g, const Real& z) {
    const Interval to_one(sub_down(Real(1.0), z), sub_up(Real(1.0), z));
    const Real down = (g * -Interval(z)).lo, up = (g * to_one).lo;
    Real least = down < up ? down : up;
    return least.sign() > 0 ? Real(0.0) : least;
}

// Below h = A - t B on the box, where h is convex along u (or along v): by item 3 in its form for
// lines.
Real least_over_lines(const NetMp& net, Degrees d, const Interval& t, bool along_u, const Real& z) {
    const int n = along_u ? d.p : d.q, lines = along_u ? d.q : d.p;
    const int step = along_u ? d.q + 1 : 1, line_step = along_u ? 1 : d.q + 1;
    const Interval iz(z);
    Real least(kInfinity);
    std::vector<Interval> h(n + 1);
    for (int m = 0; m <= lines; ++m) {
        for (int i = 0; i <= n; ++i) {
            const int k = i * step + m * line_step;
            h[i] = net.a[k] - t * net.b[k];
        }
        Interval slope(0.0);
        for (int level = n; level >= 1; --level) {
            if (level == 1) slope = Interval(double(n)) * (h[1] - h[0]);
            for (int i = 0; i < level; ++i) h[i] = h[i] + iz * (h[i + 1] - h[i]);
        }
        const Real value = add_down(h[0].lo, least_linear(slope, z));
        if (value < least) least = value;
    }
    return least;
}

// Where weights are far apart over the box, the bounds of item 3 lose by the least of them. With
// x / (1 - x) = 2^k s / (1 - s) the coefficients of s are those of x times 2^(k i), exactly (The
// NURBS Book, 6.8). k is taken so that the two ends weigh about the same.
class Balance {
 public:
    Balance(const NetMp& net, Degrees d) : k_{along(net, d, true), along(net, d, false)} {}

    bool needed() const { return k_[0] != 0 || k_[1] != 0; }
    NetMp balanced(NetMp net, Degrees d) const {
        for (auto* c : {&net.a, &net.b})
            for (int i = 0; i <= d.p; ++i)
                for (int j = 0; j <= d.q; ++j)
                    for (Real* x : {&(*c)[d.index(i, j)].lo, &(*c)[d.index(i, j)].hi})
                        mpfr_mul_2si(x->get(), x->get(), k_[0] * i + k_[1] * j, MPFR_RNDN);
        return net;
    }
    // From s to x, enclosed.
    Interval back(int axis, const Interval& s) const {
        const auto end = [&](const Real& z, mpfr_rnd_t down) {
            // x = 2^k s / (2^k s + (1 - s)) increases with s.
            Real a, b;
            const mpfr_rnd_t up = down == MPFR_RNDD ? MPFR_RNDU : MPFR_RNDD;
            mpfr_mul_2si(a.get(), z.get(), k_[axis], MPFR_RNDN);
            if (a.sign() == 0) return a;
            // x = 1 / (1 + (1 - s) / (2^k s)).
            mpfr_ui_sub(b.get(), 1, z.get(), up);
            mpfr_div(b.get(), b.get(), a.get(), up);
            mpfr_add_ui(b.get(), b.get(), 1, up);
            mpfr_ui_div(b.get(), 1, b.get(), down);
            return b;
        };
        return {end(s.lo, MPFR_RNDD), end(s.hi, MPFR_RNDU)};
    }

 private:
    static long along(const NetMp& net, Degrees d, bool along_u) {
        const int n = along_u ? d.p : d.q, lines = along_u ? d.q : d.p;
        if (n == 0) return 0;
        long first = std::numeric_limits<long>::min(), last = first;
        for (int m = 0; m <= lines; ++m) {
            const auto exponent = [&](int i) {
                const size_t k = along_u ? d.index(i, m) : d.index(m, i);
                return long(mpfr_get_exp(net.b[k].hi.get()));
            };
            first = std::max(first, exponent(0));
            last = std::max(last, exponent(n));
        }
        return (first - last) / n;
    }

    std::array<long, 2> k_;
};

// Of a net that is balanced already, in its own parameters.
std::optional<Foot> balanced_foot(const NetMp& net, Degrees d, const Real& lo, const Real& best) {
    Real least_b = net.b[0].lo;
    for (const Interval& x : net.b)
        if (x.lo < least_b) least_b = x.lo;
    // Where f is constant along a valley, best is above f by about the gap, and the loss, of that
    // size, is gone once t is the value in the valley. Beyond that it is not worth Newton's
    // trouble.
    constexpr double kPromising = 32;
    const Real gap = mul_up(sub_up(best, lo), least_b);
    if (!(curvature(net, d, Interval(best)).loss(d, 1, 1) < kPromising * gap.up()))
        return std::nullopt;
    // A foot by Newton's iteration; none of this needs to be right.
    long exponent = 0;
    std::vector<double> h = scaled_difference(net, best, exponent);
    Newton64 at = newton64(h, d, 0.5, 0.5);
    Real x(at.x), y(at.y);
    Jet a = evaluate_net(net.a, d, x, y), w = evaluate_net(net.b, d, x, y);
    Real t = divide_positive(a.f, w.f).hi;
    const Curvature rough = curvature(net, d, Interval(t));
    const bool lines = d.p > 0 && d.q > 0 && (rough.uu > 0 || rough.vv > 0);
    if (!lines && !(Real(rough.loss(d, 1, 1)) < gap)) return std::nullopt;
    h = scaled_difference(net, t, exponent);
    at = newton64(h, d, at.x, at.y);
    x = Real(at.x), y = Real(at.y);
    double last = kInfinity;
    constexpr int kSteps = 16;            // each gains about 15 digits
    constexpr double kEnough = 0x1p-280;  // of the box's side
    for (int step = 0;; ++step) {
        a = evaluate_net(net.a, d, x, y);
        w = evaluate_net(net.b, d, x, y);
        t = divide_positive(a.f, w.f).hi;
        if (step == kSteps) break;
        const auto slope = [&](const Interval& da, const Interval& dw) {
            Real g = (da - Interval(t) * dw).middle();
            mpfr_mul_2si(g.get(), g.get(), -exponent, MPFR_RNDN);
            return g.near();
        };
        const double gu = slope(a.u, w.u), gv = slope(a.v, w.v);
        const auto at_end = [](const Real& z, double g) {
            return (z.sign() <= 0 && g > 0) || (mpfr_cmp_ui(z.get(), 1) >= 0 && g < 0);
        };
        const bool free_u = d.p > 0 && !at_end(x, gu), free_v = d.q > 0 && !at_end(y, gv);
        double dx = 0, dy = 0;
        const double det = at.uu * at.vv - at.uv * at.uv;
        if (free_u && free_v) {
            dx = (-gu * at.vv + gv * at.uv) / det;
            dy = (-gv * at.uu + gu * at.uv) / det;
            // A valley: across it only.
            if (!(det > 0) || !(std::fabs(dx) < 1) || !(std::fabs(dy) < 1))
                steepest_step(at, gu, gv, dx, dy);
        } else {
            if (free_u) dx = -gu / at.uu;
            if (free_v) dy = -gv / at.vv;
        }
        const double size = std::max(std::fabs(dx), std::fabs(dy));
        if (!std::isfinite(dx) || !std::isfinite(dy) || !(size > kEnough) || !(size < 1) ||
            size > 0.5 * last)
            break;
        last = size;
        const auto move = [](Real& z, double dz) {
            mpfr_add_d(z.get(), z.get(), dz, MPFR_RNDN);
            if (z.sign() < 0) z = Real(0.0);
            if (mpfr_cmp_ui(z.get(), 1) > 0) z = Real(1.0);
        };
        move(x, dx);
        move(y, dy);
    }
    // Item 3.
    const Interval it(t);
    const Interval gu = a.u - it * w.u, gv = a.v - it * w.v;
    const auto reach = [](const Real& z) {  // the farthest |y - x| in [0, 1]
        const Real other = sub_up(Real(1.0), z);
        return z < other ? other : z;
    };
    const auto size = [](const Interval& g) {
        Real minus;
        mpfr_neg(minus.get(), g.lo.get(), MPFR_RNDU);
        return minus < g.hi ? g.hi : minus;
    };
    Real least = (a.f - it * w.f).lo;
    if (d.p > 0) least = add_down(least, least_linear(gu, x));
    if (d.q > 0) least = add_down(least, least_linear(gv, y));
    const Curvature bend = curvature(net, d, it);
    const double loss = bend.loss(d, reach(x).up(), reach(y).up());
    if (loss > 0) least = sub_down(least, Real(loss));
    if (d.p > 0 && d.q > 0) {
        const auto better = [&least](const Real& other) {
            if (least < other) least = other;
        };
        if (bend.vv > 0) better(least_over_lines(net, d, it, false, y));
        if (bend.uu > 0) better(least_over_lines(net, d, it, true, x));
    }
    Foot r;
    r.x = x;
    r.y = y;
    r.t = t;
    r.lo = t;
    if (least.sign() < 0) r.lo = add_down(t, div_down(least, least_b));
    if (!(lo < r.lo)) {
        if (loss > 0) return std::nullopt;
        r.lo = lo;
    }
    // Item 4: the value of the minimiser is in what item 3 left of T.
    if (d.p == 0 || !(r.lo <= best)) return r;
    const Curvature ct = curvature(net, d, Interval(r.lo, best));
    r.convex = ct.convex(d);
    if (r.convex) {
        const Real m(ct.least_eigenvalue(d));
        const Real slack = r.lo < t ? sub_up(t, r.lo) : Real(0.0);
        Real push = add_up(size(gu), mul_up(slack, size(w.u)));
        if (d.q > 0) push = add_up(push, add_up(size(gv), mul_up(slack, size(w.v))));
        r.radius = m.sign() > 0 ? div_up(push, m) : Real(1.0);
    }
    const auto around = [&r](const Real& z, bool free) {
        if (!free) return Interval(z);
        const Real below = sub_down(z, r.radius), above = add_up(z, r.radius);
        const Real zero(0.0), one(1.0);
        return Interval(below < zero ? zero : below, one < above ? one : above);
    };
    r.around = {around(r.x, d.p > 0), around(r.y, d.q > 0)};
    return r;
}

}  // namespace

std::optional<Foot> foot(const NetMp& net, Degrees d, const Real& lo, const Real& best, bool far) {
    if (!far) return balanced_foot(net, d, lo, best);
    const Balance balance(net, d);
    if (!balance.needed()) return balanced_foot(net, d, lo, best);
    auto r = balanced_foot(balance.balanced(net, d), d, lo, best);
    if (!r) return r;
    // The bounds hold as they are: it is the same function on the same box. The point is another
    // one after rounding.
    const auto back = [&](int axis, const Real& s) {
        return balance.back(axis, Interval(s)).middle();
    };
    r->x = back(0, r->x);
    r->y = back(1, r->y);
    for (int k = 0; k < 2; ++k) r->around[k] = balance.back(k, r->around[k]);
    const Jet a = evaluate_net(net.a, d, r->x, r->y), w = evaluate_net(net.b, d, r->x, r->y);
    r->t = divide_positive(a.f, w.f).hi;
    return r;
}

}  // namespace feeler_oracle
