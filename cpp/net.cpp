#include "net.hpp"

namespace feeler_oracle {
namespace {

// Calls f on every line of coefficients along u (stride q + 1) or along v (stride 1).
template <class F>
Net along(const Net& n, bool u, F f) {
    Net out = n;
    const int lines = u ? n.q + 1 : n.p + 1, length = u ? n.p + 1 : n.q + 1;
    std::vector<Interval> row(length);
    for (int l = 0; l < lines; ++l) {
        const auto index = [&](int k) {
            return std::size_t(u ? k * (n.q + 1) + l : l * (n.q + 1) + k);
        };
        for (int k = 0; k < length; ++k) row[k] = n.c[index(k)];
        f(row);
        for (int k = 0; k < length; ++k) out.c[index(k)] = row[k];
    }
    return out;
}

Interval lerp(const Interval& a, const Interval& b, const Interval& t) { return a + (b - a) * t; }

// De Casteljau in place: the part over [0, t], or over [t, 1].
void keep_lower(std::vector<Interval>& r, const Interval& t) {
    for (std::size_t level = 1; level < r.size(); ++level)
        for (std::size_t i = r.size() - 1; i >= level; --i) r[i] = lerp(r[i - 1], r[i], t);
}

void keep_upper(std::vector<Interval>& r, const Interval& t) {
    for (std::size_t level = 1; level < r.size(); ++level)
        for (std::size_t i = 0; i + level < r.size(); ++i) r[i] = lerp(r[i], r[i + 1], t);
}

Net restrict_to(const Net& n, bool u, const Real& a, const Real& b) {
    const Interval ia(a), ib(b), one(1.0);
    // Whichever divisor is away from zero: 1 - a >= 1/2, or b >= a > 1/2.
    if (a.near() <= 0.5) {
        const Interval rest = divide_positive(ib - ia, one - ia);
        return along(n, u, [&](std::vector<Interval>& r) {
            keep_upper(r, ia);
            keep_lower(r, rest);
        });
    }
    const Interval start = divide_positive(ia, ib);
    return along(n, u, [&](std::vector<Interval>& r) {
        keep_lower(r, ib);
        keep_upper(r, start);
    });
}

Interval hull_of_differences(const Net& n, bool u) {
    Interval h(0.0);
    bool first = true;
    const int step = u ? n.q + 1 : 1;
    for (int i = 0; i + (u ? 1 : 0) <= n.p; ++i)
        for (int j = 0; j + (u ? 0 : 1) <= n.q; ++j) {
            const std::size_t k = std::size_t(i * (n.q + 1) + j);
            const Interval d = n.c[k + step] - n.c[k];
            h = first ? d : hull(h, d);
            first = false;
        }
    return h * Interval(double(u ? n.p : n.q));
}

}  // namespace

Net to_net(int p, int q, const std::vector<Q>& coefficients) {
    Net n{p, q, {}};
    for (const Q& x : coefficients) n.c.push_back(to_interval(x));
    return n;
}

Q to_exact(const Real& x) {
    if (x.sign() == 0) return Q(0);
    mpq_t value;
    mpq_init(value);
    mpfr_get_q(value, x.get());
    Q result(value);
    mpq_clear(value);
    return result;
}

Net restrict_u(const Net& n, const Real& a, const Real& b) { return restrict_to(n, true, a, b); }
Net restrict_v(const Net& n, const Real& a, const Real& b) { return restrict_to(n, false, a, b); }

void halve_net(const Net& n, bool u, Net& lower, Net& upper) {
    // The lower half is written while the row turns into the upper one.
    std::vector<Interval> low;
    lower = n;
    int line = 0;
    upper = along(n, u, [&](std::vector<Interval>& r) {
        low.clear();
        for (std::size_t level = 0; level < r.size(); ++level) {
            low.push_back(r[0]);
            for (std::size_t i = 0; i + level + 1 < r.size(); ++i) r[i] = average(r[i], r[i + 1]);
        }
        for (std::size_t k = 0; k < low.size(); ++k)
            lower.c[u ? k * (n.q + 1) + line : std::size_t(line) * (n.q + 1) + k] = low[k];
        ++line;
    });
}

Interval hull(const Net& n) {
    Interval h = n.c[0];
    for (std::size_t i = 1; i < n.c.size(); ++i) h = hull(h, n.c[i]);
    return h;
}

Interval hull_du(const Net& n) { return hull_of_differences(n, true); }
Interval hull_dv(const Net& n) { return hull_of_differences(n, false); }

Interval at_middle(const Net& n) {
    std::vector<Interval> column;
    for (int i = 0; i <= n.p; ++i) {
        std::vector<Interval> row(n.c.begin() + i * (n.q + 1), n.c.begin() + (i + 1) * (n.q + 1));
        for (std::size_t level = 1; level < row.size(); ++level)
            for (std::size_t k = 0; k + level < row.size(); ++k)
                row[k] = average(row[k], row[k + 1]);
        column.push_back(row[0]);
    }
    for (std::size_t level = 1; level < column.size(); ++level)
        for (std::size_t k = 0; k + level < column.size(); ++k)
            column[k] = average(column[k], column[k + 1]);
    return column[0];
}

Net combine(double x, const Net& a, double y, const Net& b) {
    Net n{a.p, a.q, {}};
    const Interval ix(x), iy(y);
    for (std::size_t i = 0; i < a.c.size(); ++i) n.c.push_back(ix * a.c[i] + iy * b.c[i]);
    return n;
}

}  // namespace feeler_oracle
