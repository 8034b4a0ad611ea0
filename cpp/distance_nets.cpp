#include "distance_nets.hpp"

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class T>
const T& choose(int n, int k);
template <>
const Interval& choose<Interval>(int n, int k) {
    return binomial(n, k);
}
template <>
const Interval64& choose<Interval64>(int n, int k) {
    thread_local std::vector<std::vector<Interval64>> table;
    if (int(table.size()) <= n) table.resize(n + 1);
    if (table[n].empty())
        for (int i = 0; i <= n; ++i) table[n].push_back(binomial(n, i).outer());
    return table[n][k];
}

// sum_k of the squares of the nets, doubled degrees. Scaled Bernstein form: plain convolution, of
// which the products of two different coefficients are formed once.
template <class T>
std::vector<T> sum_of_squares(std::vector<std::vector<T>> nets, int p, int q) {
    const int width = 2 * q + 1;
    std::vector<T> r(size_t(2 * p + 1) * width);
    for (auto& m : nets) {
        for (int i = 0; i <= p; ++i)
            for (int j = 0; j <= q; ++j)
                m[i * (q + 1) + j] = m[i * (q + 1) + j] * (choose<T>(p, i) * choose<T>(q, j));
        const int n = int(m.size());
        for (int a = 0; a < n; ++a) {
            const int i = a / (q + 1), j = a % (q + 1);
            const T twice = m[a] + m[a];
            for (int b = a; b < n; ++b) {
                auto& to = r[(i + b / (q + 1)) * width + j + b % (q + 1)];
                to = to + (b == a ? m[a] * m[a] : twice * m[b]);
            }
        }
    }
    for (int i = 0; i <= 2 * p; ++i)
        for (int j = 0; j < width; ++j)
            r[i * width + j] =
                divide_positive(r[i * width + j], choose<T>(2 * p, i) * choose<T>(2 * q, j));
    return r;
}

template <class T>
void objective(const Objective& o, const std::array<std::vector<T>, 4>& net, int p, int q,
               std::vector<T>& a, std::vector<T>& b) {
    const size_t n = net[3].size();
    if (o.linear) {
        a.resize(n);
        for (size_t i = 0; i < n; ++i)
            a[i] = T(o.c[0]) * net[0][i] + T(o.c[1]) * net[1][i] + T(o.c[2]) * net[2][i] -
                   T(o.h) * net[3][i];
        b = net[3];
        return;
    }
    std::vector<std::vector<T>> m(3, std::vector<T>(n));
    for (int k = 0; k < 3; ++k)
        for (size_t i = 0; i < n; ++i) m[k][i] = net[k][i] - T(o.c[k]) * net[3][i];
    a = sum_of_squares<T>(std::move(m), p, q);
    b = sum_of_squares<T>({net[3]}, p, q);
}

void centre(const std::vector<Interval64>& x, std::vector<double>& middle, double& radius) {
    radius = 0;
    middle.reserve(x.size());
    for (const auto& i : x) {
        const double m = 0.5 * i.lo + 0.5 * i.hi;
        middle.push_back(m);
        radius = std::max(radius, std::max(next_up(i.hi - m), next_up(m - i.lo)));
    }
}

void split_coefficients(const std::vector<double>& c, Degrees d, bool along_u,
                        std::vector<double>& left, std::vector<double>& right) {
    const int n = along_u ? d.p : d.q, lines = along_u ? d.q : d.p;
    const int step = along_u ? d.q + 1 : 1, line_step = along_u ? 1 : d.q + 1;
    right = c;
    left.resize(c.size());
    for (int m = 0; m <= lines; ++m) {
        double* r = right.data() + m * line_step;
        double* l = left.data() + m * line_step;
        for (int k = 0; k <= n; ++k) {
            l[k * step] = r[0];
            for (int i = 0; i < n - k; ++i) r[i * step] = 0.5 * (r[i * step] + r[(i + 1) * step]);
        }
    }
}

void split_coefficients(const std::vector<Interval>& c, Degrees d, bool along_u,
                        std::vector<Interval>& left, std::vector<Interval>& right) {
    const int n = along_u ? d.p : d.q, lines = along_u ? d.q : d.p;
    const int step = along_u ? d.q + 1 : 1, line_step = along_u ? 1 : d.q + 1;
    right = c;
    left.resize(c.size());
    for (int m = 0; m <= lines; ++m) {
        Interval* r = right.data() + m * line_step;
        Interval* l = left.data() + m * line_step;
        for (int k = 0; k <= n; ++k) {
            l[k * step] = r[0];
            for (int i = 0; i < n - k; ++i) r[i * step] = average(r[i * step], r[(i + 1) * step]);
        }
    }
}

// a + x (b - a) for x in [0, 1].
Interval lerp(const Interval& a, const Interval& b, const Interval& x) { return a + x * (b - a); }

void restrict_along(std::vector<Interval>& c, int p, int q, bool along_u, int level,
                    std::uint64_t index) {
    if (level == 0) return;
    const int n = along_u ? p : q, lines = along_u ? q : p;
    const int step = along_u ? q + 1 : 1, line_step = along_u ? 1 : q + 1;
    Real a, b, t;
    mpfr_set_ui_2exp(a.get(), index, -level, MPFR_RNDN);  // exact
    mpfr_set_ui_2exp(b.get(), index + 1, -level, MPFR_RNDN);
    // Over [0, b], then from a / b, which is enclosed.
    const Interval ib(b), ratio = divide_positive(Interval(a), ib);
    for (int m = 0; m <= lines; ++m) {
        Interval* l = c.data() + m * line_step;
        std::vector<Interval> work;
        for (int i = 0; i <= n; ++i) work.push_back(l[i * step]);
        for (int k = 0; k <= n; ++k) {
            l[k * step] = work[0];
            for (int i = 0; i < n - k; ++i) work[i] = lerp(work[i], work[i + 1], ib);
        }
        if (index != 0)
            for (int k = 1; k <= n; ++k)
                for (int i = 0; i <= n - k; ++i)
                    l[i * step] = lerp(l[i * step], l[(i + 1) * step], ratio);
    }
}

}  // namespace

double Net64::noise(double f) const {
    const double least = std::max(0.0, *std::min_element(b.begin(), b.end()) - rb);
    return std::min((ra + f * rb) / least, ea + f * eb);
}

Net64 objective_net64(const Objective& o, const Piece& s) {
    std::vector<Interval64> a, b;
    objective<Interval64>(o, s.net64, s.p, s.q, a, b);
    Net64 r;
    centre(a, r.a, r.ra);
    centre(b, r.b, r.rb);
    if (!s.far) {
        // The bounds for all alike are as good.
        r.ea = r.eb = kInfinity;
        return r;
    }
    for (size_t k = 0; k < b.size(); ++k) {
        const auto part = [&](const Interval64& x, double middle) {
            return next_up(std::max(next_up(x.hi - middle), next_up(middle - x.lo)) / r.b[k]);
        };
        r.ea = std::max(r.ea, part(a[k], r.a[k]));
        r.eb = std::max(r.eb, b[k].lo > 0 ? part(b[k], r.b[k]) : kInfinity);
        r.ratio = std::max(r.ratio, next_up(std::fabs(r.a[k]) / r.b[k]));
    }
    return r;
}

void split64(const Net64& n, Degrees d, bool along_u, Net64& left, Net64& right) {
    split_coefficients(n.a, d, along_u, left.a, right.a);
    split_coefficients(n.b, d, along_u, left.b, right.b);
    const int degree = along_u ? d.p : d.q;
    constexpr double kTiny = std::numeric_limits<double>::denorm_min();
    // One averaging errs by at most 2^-53 of the larger operand (halving is exact, or loses a
    // denormal); twice that also covers the growth of the maximum and the sums below.
    const auto grown = [degree](const std::vector<double>& c, double radius) {
        double m = 0;
        for (double x : c) m = std::max(m, std::fabs(x));
        return next_up(radius + degree * (m * 0x1p-52 + 2 * kTiny));
    };
    left.ra = right.ra = grown(n.a, n.ra);
    left.rb = right.rb = grown(n.b, n.rb);
    // Let a, a', b, b' be averaged, s = (b + b') / 2 and u = 2^-53. The result is off by at most
    // ea s + u ratio s + kTiny, or eb s + u s + kTiny; and s <= (1 + 2 u) of what is computed for
    // it, as all b are positive and far from denormals. So each of `degree` averagings adds u ratio
    // (or u) and the denormal's part and multiplies by 1 + 2 u; and ratio grows by (1 + u) (1 + 2
    // u) at most. Twice all that covers the roundings here.
    const double least = *std::min_element(n.b.begin(), n.b.end());
    const double tiny = kTiny / least, growth = 1 + degree * 0x1p-50;
    left.ea = right.ea = (n.ea + degree * (n.ratio * 0x1p-52 + 2 * tiny)) * growth;
    left.eb = right.eb = (n.eb + degree * (0x1p-52 + 2 * tiny)) * growth;
    left.ratio = right.ratio = n.ratio * growth;
}

NetMp objective_net(const Objective& o, const Piece& s, const DyadicBox& box) {
    auto net = s.net;
    for (auto& c : net) {
        restrict_along(c, s.p, s.q, true, box.lu, box.iu);
        restrict_along(c, s.p, s.q, false, box.lv, box.iv);
    }
    NetMp r;
    objective<Interval>(o, net, s.p, s.q, r.a, r.b);
    return r;
}

void split(const NetMp& n, Degrees d, bool along_u, NetMp& left, NetMp& right) {
    split_coefficients(n.a, d, along_u, left.a, right.a);
    split_coefficients(n.b, d, along_u, left.b, right.b);
}

Jet evaluate_net(const std::vector<Interval>& c, Degrees d, const Real& x, const Real& y) {
    const Interval ix(x), iy(y);
    const int w = d.q + 1;
    std::vector<Interval> b = c, du(w);
    for (int k = d.p; k >= 1; --k) {
        if (k == 1)
            for (int j = 0; j < w; ++j) du[j] = Interval(double(d.p)) * (b[w + j] - b[j]);
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < w; ++j) b[i * w + j] = lerp(b[i * w + j], b[(i + 1) * w + j], ix);
    }
    Jet r;
    for (int k = d.q; k >= 1; --k) {
        if (k == 1) r.v = Interval(double(d.q)) * (b[1] - b[0]);
        for (int j = 0; j < k; ++j) {
            b[j] = lerp(b[j], b[j + 1], iy);
            if (d.p > 0) du[j] = lerp(du[j], du[j + 1], iy);
        }
    }
    r.f = b[0];
    r.u = du[0];
    return r;
}

namespace {

double polynomial(std::vector<double> b, int p, int q, double x, double y) {
    const int w = q + 1;
    for (int k = p; k >= 1; --k)
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < w; ++j) b[i * w + j] += x * (b[(i + 1) * w + j] - b[i * w + j]);
    for (int k = q; k >= 1; --k)
        for (int j = 0; j < k; ++j) b[j] += y * (b[j + 1] - b[j]);
    return b[0];
}

// Coefficients of the derivative along u or v; degree lowered by one (zero for degree 0).
std::vector<double> derivative(const std::vector<double>& c, int& p, int& q, bool along_u) {
    const int w = q + 1;
    std::vector<double> r;
    if ((along_u ? p : q) == 0) return std::vector<double>(c.size(), 0.0);
    if (along_u) {
        for (int i = 0; i < p; ++i)
            for (int j = 0; j < w; ++j) r.push_back(p * (c[(i + 1) * w + j] - c[i * w + j]));
        --p;
    } else {
        for (int i = 0; i <= p; ++i)
            for (int j = 0; j < q; ++j) r.push_back(q * (c[i * w + j + 1] - c[i * w + j]));
        --q;
    }
    return r;
}

struct DerivativeNet {
    std::vector<double> c;
    int p, q;
    DerivativeNet(const std::vector<double>& h, int p0, int q0, bool along_u) : p(p0), q(q0) {
        c = derivative(h, p, q, along_u);
    }
    double at(double x, double y) const { return polynomial(c, p, q, x, y); }
};

}  // namespace

Newton64 newton64(const std::vector<double>& h, Degrees d, double x, double y) {
    const DerivativeNet u(h, d.p, d.q, true), v(h, d.p, d.q, false);
    const DerivativeNet uu(u.c, u.p, u.q, true), uv(u.c, u.p, u.q, false), vv(v.c, v.p, v.q, false);
    Newton64 r{x, y, 0, 0, 0};
    const auto clamp = [](double t) { return std::min(1.0, std::max(0.0, t)); };
    constexpr int kSteps = 12;  // quadratic convergence takes about 6
    for (int step = 0;; ++step) {
        r.uu = uu.at(r.x, r.y), r.uv = uv.at(r.x, r.y), r.vv = vv.at(r.x, r.y);
        if (step == kSteps) return r;
        const double gu = u.at(r.x, r.y), gv = v.at(r.x, r.y);
        const bool free_u = d.p > 0 && !((r.x <= 0 && gu > 0) || (r.x >= 1 && gu < 0));
        const bool free_v = d.q > 0 && !((r.y <= 0 && gv > 0) || (r.y >= 1 && gv < 0));
        double dx = 0, dy = 0;
        const double det = r.uu * r.vv - r.uv * r.uv;
        if (free_u && free_v && r.uu > 0 && det > 0) {
            dx = (-gu * r.vv + gv * r.uv) / det;
            dy = (-gv * r.uu + gu * r.uv) / det;
        } else {
            if (free_u) dx = r.uu > 0 ? -gu / r.uu : (gu > 0 ? -0.25 : 0.25);
            if (free_v) dy = r.vv > 0 ? -gv / r.vv : (gv > 0 ? -0.25 : 0.25);
        }
        if (!std::isfinite(dx) || !std::isfinite(dy)) return r;
        const double nx = clamp(r.x + dx), ny = clamp(r.y + dy);
        if (nx == r.x && ny == r.y) return r;
        r.x = nx, r.y = ny;
    }
}

}  // namespace feeler_oracle
