#include "bernstein.hpp"

#include <algorithm>

#include "net.hpp"

namespace feeler_oracle {
namespace {

Z binomial(int n, int k) {
    Z r;
    mpz_bin_uiui(r.mpz(), unsigned(n), unsigned(k));
    return r;
}

// In a higher degree, exactly.
Bernstein elevated(Bernstein f, std::size_t size) {
    while (f.size() < size) {
        const int n = int(f.size());
        Bernstein g(f.size() + 1);
        for (int i = 0; i <= n; ++i) {
            const Q s(i, n);
            g[i] = (i > 0 ? s * f[i - 1] : Q(0)) + (i < n ? (Q(1) - s) * f[i] : Q(0));
        }
        f = std::move(g);
    }
    return f;
}

}  // namespace

Bernstein product(const Bernstein& f, const Bernstein& g) {
    const int n = int(f.size()) - 1, m = int(g.size()) - 1;
    Bernstein r(f.size() + g.size() - 1, Q(0));
    for (int i = 0; i <= n; ++i) {
        if (sign(f[i]) == 0) continue;
        const Q left = f[i] * Q(binomial(n, i));
        for (int j = 0; j <= m; ++j) r[i + j] += left * Q(binomial(m, j)) * g[j];
    }
    for (int k = 0; k <= n + m; ++k) r[k] /= Q(binomial(n + m, k));
    return r;
}

Bernstein combination(const Q& a, const Bernstein& f, const Q& b, const Bernstein& g) {
    const std::size_t size = std::max(f.size(), g.size());
    Bernstein x = elevated(f, size);
    const Bernstein y = elevated(g, size);
    for (std::size_t i = 0; i < size; ++i) x[i] = a * x[i] + b * y[i];
    return x;
}

Bernstein derivative(const Bernstein& f) {
    if (f.size() == 1) return {Q(0)};
    Bernstein d;
    for (std::size_t i = 0; i + 1 < f.size(); ++i) d.push_back(f[i + 1] - f[i]);
    return d;
}

bool is_zero(const Bernstein& f) {
    return std::all_of(f.begin(), f.end(), [](const Q& x) { return sign(x) == 0; });
}

Q value(const Bernstein& f, const Q& t) {
    Bernstein r = f;
    const Q s = Q(1) - t;
    for (std::size_t level = 1; level < f.size(); ++level)
        for (std::size_t i = 0; i + level < f.size(); ++i) r[i] = r[i] * s + r[i + 1] * t;
    return r[0];
}

Interval range(const Bernstein& f, const Q& lo, const Q& hi) {
    const Net n =
        restrict_v(to_net(0, int(f.size()) - 1, f), to_interval(lo).lo, to_interval(hi).hi);
    return hull(n);
}

Bernstein composed(const std::vector<Q>& F, int p, int q, const Bernstein& x, const Bernstein& y,
                   const Bernstein& w) {
    // Products x^i (w - x)^(p - i), and so for y.
    const auto powers = [&w](const Bernstein& z, int n) {
        const Bernstein rest = combination(Q(1), w, Q(-1), z);
        std::vector<Bernstein> up(1, {Q(1)}), down(1, {Q(1)}), all;
        for (int k = 0; k < n; ++k) {
            up.push_back(product(up.back(), z));
            down.push_back(product(down.back(), rest));
        }
        for (int k = 0; k <= n; ++k) {
            Bernstein both = product(up[std::size_t(k)], down[std::size_t(n - k)]);
            for (Q& c : both) c *= Q(binomial(n, k));
            all.push_back(std::move(both));
        }
        return all;
    };
    const auto along_u = powers(x, p), along_v = powers(y, q);
    Bernstein sum(1, Q(0));
    for (int i = 0; i <= p; ++i) {
        Bernstein row(along_v[0].size(), Q(0));
        for (int j = 0; j <= q; ++j)
            for (std::size_t k = 0; k < row.size(); ++k)
                row[k] += F[std::size_t(i * (q + 1) + j)] * along_v[std::size_t(j)][k];
        sum = combination(Q(1), sum, Q(1), product(along_u[std::size_t(i)], row));
    }
    return sum;
}

}  // namespace feeler_oracle
