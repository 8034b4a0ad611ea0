#include "trim_cuts.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <map>

namespace feeler_oracle {
namespace {

// index / 2^depth
Q dyadic(const mpz_class& index, int depth) {
    mpz_class power = 1;
    power <<= depth;
    mpq_class q(index, power);
    q.canonicalize();
    return Q(q.get_mpq_t());
}

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
    std::vector<Item> stack{{b, 0, 0}};
    while (!stack.empty()) {
        Item item = std::move(stack.back());
        stack.pop_back();
        if (one_sided(item.b.begin(), item.b.end())) continue;
        if (item.depth == kCutDepth) {
            cuts.push_back({dyadic(item.index, item.depth), dyadic(item.index + 1, item.depth)});
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
            cuts.push_back({dyadic(right.index, right.depth), dyadic(right.index, right.depth)});
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

void sign_cuts(const std::vector<Interval>& g, std::vector<Cut>& cuts) {
    const size_t n = g.size();
    // -1, 1: of one sign (or zero); 0: of both, or not known; 2: all within the noise.
    const auto kind = [n](const std::vector<Interval>& b) {
        bool plus = true, minus = true, noise = true;
        for (size_t i = 0; i < n; ++i) {
            plus &= b[i].lo.sign() >= 0;
            minus &= b[i].hi.sign() <= 0;
            noise &= b[i].lo.sign() <= 0 && b[i].hi.sign() >= 0;
        }
        return plus ? 1 : minus ? -1 : noise ? 2 : 0;
    };
    struct Item {
        std::vector<Interval> b;
        mpz_class index;
        int depth;
    };
    // Towards noise a double root widens to about the square root of it; no more boxes a level
    // than a polynomial of the degree has roots, and their neighbours.
    std::vector<Item> stack{{g, 0, 0}};
    while (!stack.empty()) {
        Item item = std::move(stack.back());
        stack.pop_back();
        const int found = kind(item.b);
        if (found == 1 || found == -1) continue;
        if (found == 2 || item.depth == kCutDepth) {
            cuts.push_back({dyadic(item.index, item.depth), dyadic(item.index + 1, item.depth)});
            continue;
        }
        Item left{item.b, item.index * 2, item.depth + 1},
            right{std::move(item.b), item.index * 2 + 1, item.depth + 1};
        for (size_t k = 0; k < n; ++k) {
            left.b[k] = right.b[0];
            for (size_t i = 0; i + k + 1 < n; ++i) right.b[i] = average(right.b[i], right.b[i + 1]);
        }
        stack.push_back(std::move(right));
        stack.push_back(std::move(left));
    }
}

}  // namespace feeler_oracle
