#include "bipoly.hpp"

#include <algorithm>
#include <cstdint>

namespace feeler_oracle {
namespace {

// Takes away the common divisor and the leading rows and columns of zeros.
BiPoly primitive(const BiPoly& f) {
    Z divisor(0);
    int p = 0, q = 0;
    for (int i = 0; i <= f.p; ++i)
        for (int j = 0; j <= f.q; ++j) {
            const Z& c = f.at(i, j);
            if (CGAL::is_zero(c)) continue;
            p = std::max(p, i);
            q = std::max(q, j);
            if (divisor != Z(1)) divisor = CGAL::gcd(divisor, c);
        }
    BiPoly r{p, q, std::vector<Z>(std::size_t((p + 1) * (q + 1)), Z(0))};
    if (CGAL::is_zero(divisor)) return r;
    divisor = CGAL::abs(divisor);
    for (int i = 0; i <= p; ++i)
        for (int j = 0; j <= q; ++j) r.at(i, j) = CGAL::integral_division(f.at(i, j), divisor);
    return r;
}

// Bernstein to power basis, in place: c_k = C(n, k) times the k-th forward difference at 0.
void to_power(std::vector<Z>& b) {
    const int n = int(b.size()) - 1;
    Z binomial(1);
    for (int k = 0; k <= n; ++k) {
        // b[k..] are the k-th differences.
        for (int i = n; i > k; --i) b[i] -= b[i - 1];
        b[k] *= binomial;
        if (k < n) binomial = CGAL::integral_division(binomial * Z(n - k), Z(k + 1));
        // The value at k must stay the plain difference for the next level; it is not used again.
    }
}

// ---- modulo a prime

constexpr std::uint64_t kPrime = (std::uint64_t(1) << 61) - 1;
std::uint64_t times(std::uint64_t a, std::uint64_t b) {
    return std::uint64_t((unsigned __int128)a * b % kPrime);
}
std::uint64_t minus(std::uint64_t a, std::uint64_t b) { return a >= b ? a - b : a + kPrime - b; }
std::uint64_t inverse(std::uint64_t a) {
    std::uint64_t r = 1;
    for (std::uint64_t e = kPrime - 2; e; e >>= 1, a = times(a, a))
        if (e & 1) r = times(r, a);
    return r;
}
std::uint64_t residue(const Z& x) { return mpz_fdiv_ui(x.mpz(), kPrime); }

// f(., v) modulo the prime, without leading zeros.
std::vector<std::uint64_t> row_at(const BiPoly& f, std::uint64_t v) {
    std::vector<std::uint64_t> r;
    for (int i = 0; i <= f.p; ++i) {
        std::uint64_t s = 0;
        for (int j = f.q; j >= 0; --j) s = (times(s, v) + residue(f.at(i, j))) % kPrime;
        r.push_back(s);
    }
    return r;
}

// Whether f(., v) and g(., v) keep their degrees modulo the prime and are coprime there: then the
// resultant by u is not the zero polynomial of v.
bool coprime_at(const BiPoly& f, const BiPoly& g, std::uint64_t v) {
    auto a = row_at(f, v), b = row_at(g, v);
    if (a.back() == 0 || b.back() == 0) return false;
    while (true) {
        if (a.size() < b.size()) std::swap(a, b);
        if (b.size() == 1) return true;  // a constant that is not 0
        const std::uint64_t k = times(a.back(), inverse(b.back()));
        const std::size_t shift = a.size() - b.size();
        for (std::size_t i = 0; i < b.size(); ++i)
            a[i + shift] = minus(a[i + shift], times(k, b[i]));
        while (!a.empty() && a.back() == 0) a.pop_back();
        if (a.empty()) return false;
    }
}

}  // namespace

Q simplest(Q lo, Q hi) {
    // Continued fractions: convergents' recursion, iterated while both ends agree.
    Z p0(0), q0(1), p1(1), q1(0);
    while (true) {
        Z floor_lo;
        mpz_fdiv_q(floor_lo.mpz(), lo.numerator().mpz(), lo.denominator().mpz());
        const bool whole = Q(floor_lo) == lo;
        if (whole || Q(floor_lo) + Q(1) <= hi) {
            const Z a = whole ? floor_lo : floor_lo + Z(1);
            return Q(a * p1 + p0, a * q1 + q0);
        }
        const Z p2 = floor_lo * p1 + p0, q2 = floor_lo * q1 + q0;
        p0 = p1;
        q0 = q1;
        p1 = p2;
        q1 = q2;
        const Q a(floor_lo);
        const Q next_lo = Q(1) / (hi - a), next_hi = Q(1) / (lo - a);
        lo = next_lo;
        hi = next_hi;
    }
}

bool BiPoly::is_zero() const {
    return std::all_of(c.begin(), c.end(), [](const Z& x) { return CGAL::is_zero(x); });
}

BiPoly to_bipoly(int p, int q, const std::vector<Q>& bernstein) {
    Z denominator(1);
    for (const Q& x : bernstein) {
        const Z d = x.denominator();
        denominator = CGAL::integral_division(denominator * d, CGAL::gcd(denominator, d));
    }
    BiPoly f{p, q, {}};
    for (const Q& x : bernstein)
        f.c.push_back(x.numerator() * CGAL::integral_division(denominator, x.denominator()));
    std::vector<Z> line;
    for (int i = 0; i <= p; ++i) {
        line.assign(f.c.begin() + i * (q + 1), f.c.begin() + (i + 1) * (q + 1));
        to_power(line);
        std::copy(line.begin(), line.end(), f.c.begin() + i * (q + 1));
    }
    for (int j = 0; j <= q; ++j) {
        line.clear();
        for (int i = 0; i <= p; ++i) line.push_back(f.at(i, j));
        to_power(line);
        for (int i = 0; i <= p; ++i) f.at(i, j) = line[i];
    }
    return primitive(f);
}

BiPoly derivative(const BiPoly& f, bool by_u) {
    BiPoly r{by_u ? std::max(f.p - 1, 0) : f.p, by_u ? f.q : std::max(f.q - 1, 0), {}};
    r.c.assign(std::size_t((r.p + 1) * (r.q + 1)), Z(0));
    if ((by_u ? f.p : f.q) == 0) return r;
    for (int i = 0; i <= r.p; ++i)
        for (int j = 0; j <= r.q; ++j)
            r.at(i, j) = by_u ? f.at(i + 1, j) * Z(i + 1) : f.at(i, j + 1) * Z(j + 1);
    return r;
}

BiPoly cross(const BiPoly& a, const BiPoly& b, const BiPoly& c, const BiPoly& d) {
    BiPoly r{std::max(a.p + b.p, c.p + d.p), std::max(a.q + b.q, c.q + d.q), {}};
    r.c.assign(std::size_t((r.p + 1) * (r.q + 1)), Z(0));
    const auto add = [&r](const BiPoly& f, const BiPoly& g, bool negative) {
        for (int i = 0; i <= f.p; ++i)
            for (int j = 0; j <= f.q; ++j) {
                if (CGAL::is_zero(f.at(i, j))) continue;
                for (int k = 0; k <= g.p; ++k)
                    for (int l = 0; l <= g.q; ++l) {
                        const Z product = f.at(i, j) * g.at(k, l);
                        if (negative)
                            r.at(i + k, j + l) -= product;
                        else
                            r.at(i + k, j + l) += product;
                    }
            }
    };
    add(a, b, false);
    add(c, d, true);
    return primitive(r);
}

BiPoly transposed(const BiPoly& f) {
    BiPoly r{f.q, f.p, {}};
    for (int j = 0; j <= f.q; ++j)
        for (int i = 0; i <= f.p; ++i) r.c.push_back(f.at(i, j));
    return r;
}

Q value(const BiPoly& f, const Q& u, const Q& v) {
    Q sum(0);
    for (int i = f.p; i >= 0; --i) {
        Q row(0);
        for (int j = f.q; j >= 0; --j) row = row * v + Q(f.at(i, j));
        sum = sum * u + row;
    }
    return sum;
}

Big value(const BiPoly& f, const Big& u, const Big& v) {
    const long bits = std::max(u.bits(), v.bits());
    Big sum(Q(0), bits), row(bits);
    for (int i = f.p; i >= 0; --i) {
        mpfi_set_z(row.get(), f.at(i, f.q).mpz());
        for (int j = f.q - 1; j >= 0; --j) {
            mpfi_mul(row.get(), row.get(), v.get());
            mpfi_add_z(row.get(), row.get(), f.at(i, j).mpz());
        }
        if (i < f.p) mpfi_mul(sum.get(), sum.get(), u.get());
        mpfi_add(sum.get(), sum.get(), row.get());
    }
    return sum;
}

std::vector<Big> shifted(const BiPoly& f, const Q& u, const Q& v, long bits) {
    std::vector<Big> c;
    for (const Z& x : f.c) c.emplace_back(Q(x), bits);
    const Big bu(u, bits), bv(v, bits);
    const auto at = [&](int i, int j) -> Big& { return c[std::size_t(i * (f.q + 1) + j)]; };
    // Repeated synthetic division.
    for (int i = 0; i <= f.p; ++i)
        for (int level = 0; level < f.q; ++level)
            for (int j = f.q - 1; j >= level; --j) at(i, j) = at(i, j) + bv * at(i, j + 1);
    for (int j = 0; j <= f.q; ++j)
        for (int level = 0; level < f.p; ++level)
            for (int i = f.p - 1; i >= level; --i) at(i, j) = at(i, j) + bu * at(i + 1, j);
    return c;
}

std::vector<Q> to_bernstein(const BiPoly& f, int p, int q) {
    // x^k = sum over i of C(i, k) / C(n, k) B_i.
    const auto share = [](int n, int i, int k) {
        Q r(1);
        for (int m = 0; m < k; ++m) r *= Q(i - m, n - m);
        return r;
    };
    std::vector<Q> b(std::size_t((p + 1) * (q + 1)), Q(0));
    for (int k = 0; k <= f.p; ++k)
        for (int l = 0; l <= f.q; ++l) {
            if (CGAL::is_zero(f.at(k, l))) continue;
            for (int i = k; i <= p; ++i)
                for (int j = l; j <= q; ++j)
                    b[std::size_t(i * (q + 1) + j)] +=
                        share(p, i, k) * share(q, j, l) * Q(f.at(k, l));
        }
    return b;
}

long length_bits(const BiPoly& f) {
    Z sum(0);
    for (const Z& x : f.c) sum += CGAL::abs(x);
    return long(mpz_sizeinbase(sum.mpz(), 2));
}

bool coprime(const BiPoly& f, const BiPoly& g) {
    if (f.is_zero() || g.is_zero()) return false;
    const BiPoly ft = transposed(f), gt = transposed(g);
    // A factor in common has a positive degree in u or in v; each try fails by chance with a
    // probability of about 1e-15.
    constexpr std::uint64_t kPlaces[] = {0x123456789abcdefull, 0x0fedcba987654321ull};
    bool by_u = false, by_v = false;
    for (std::uint64_t place : kPlaces) {
        by_u = by_u || coprime_at(f, g, place % kPrime);
        by_v = by_v || coprime_at(ft, gt, place % kPrime);
    }
    return by_u && by_v;
}

}  // namespace feeler_oracle
