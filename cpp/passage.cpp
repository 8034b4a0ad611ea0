#include "passage.hpp"

#include "interval.hpp"

namespace feeler_oracle {
namespace {

int strict_sign(const Interval64& x) { return x.lo > 0 ? 1 : x.hi < 0 ? -1 : 0; }
int strict_sign(const Interval& x) { return x.lo.sign() > 0 ? 1 : x.hi.sign() < 0 ? -1 : 0; }

template <class N>
int hull_sign(const std::vector<N>& c) {
    const int s = strict_sign(c[0]);
    for (std::size_t i = 1; s != 0 && i < c.size(); ++i)
        if (strict_sign(c[i]) != s) return 0;
    return s;
}

// The coefficients over [0, t] and [t, 1], t a double exactly.
template <class N>
void split(const std::vector<N>& c, double t, std::vector<N>& left, std::vector<N>& right) {
    const std::size_t n = c.size();
    const N a(1 - t), b(t);
    right = c;
    left.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
        left[k] = right[0];
        for (std::size_t i = 0; i + 1 < n - k; ++i) right[i] = a * right[i] + b * right[i + 1];
    }
}

template <class N>
struct Part {
    std::vector<N> f, g;
    bool above0, above1;
    int depth;
};

// Eighths: 1 - t is exact too.
constexpr double kSplits[] = {0.5, 0.375, 0.625, 0.25};

template <class N>
std::optional<Passage> subdivide(std::vector<N> f, std::vector<N> g, bool above0, bool above1,
                                 int deepest, int most) {
    bool odd = false;
    std::vector<Part<N>> stack;
    stack.push_back({std::move(f), std::move(g), above0, above1, 0});
    for (int count = 0; !stack.empty(); ++count) {
        if (count == most) return std::nullopt;
        Part<N> part = std::move(stack.back());
        stack.pop_back();
        if (hull_sign(part.f) != 0) continue;
        const int right = hull_sign(part.g);
        if (right < 0) continue;
        if (right > 0) {
            odd ^= part.above0 != part.above1;
            continue;
        }
        if (part.depth == deepest) return std::nullopt;
        Part<N> lower, upper;
        int middle = 0;
        for (double t : kSplits) {
            split(part.f, t, lower.f, upper.f);
            middle = strict_sign(upper.f[0]);
            if (middle == 0) continue;
            split(part.g, t, lower.g, upper.g);
            break;
        }
        if (middle == 0) return std::nullopt;
        lower.above0 = part.above0;
        lower.above1 = upper.above0 = middle > 0;
        upper.above1 = part.above1;
        lower.depth = upper.depth = part.depth + 1;
        stack.push_back(std::move(lower));
        stack.push_back(std::move(upper));
    }
    return odd ? Passage::Odd : Passage::Even;
}

// Doubles are spent after some fifty halvings; what a point at the distance of 2^-100 of a piece
// needs is settled with eighty.
constexpr int kDeepest64 = 48, kMost64 = 400;
constexpr int kDeepest = 80, kMost = 600;

}  // namespace

std::optional<Passage> certain_passage(const std::vector<Q>& f, const std::vector<Q>& g,
                                       bool above0, bool above1) {
    std::vector<Interval64> f64, g64;
    const auto to64 = [](const Q& x) -> Interval64 {
        const auto b = double_bounds(x);
        return {b.first, b.second};
    };
    for (const Q& x : f) f64.push_back(to64(x));
    for (const Q& x : g) g64.push_back(to64(x));
    if (auto r = subdivide(std::move(f64), std::move(g64), above0, above1, kDeepest64, kMost64))
        return r;
    std::vector<Interval> fw, gw;
    for (const Q& x : f) fw.emplace_back(x.mpq());
    for (const Q& x : g) gw.emplace_back(x.mpq());
    return subdivide(std::move(fw), std::move(gw), above0, above1, kDeepest, kMost);
}

}  // namespace feeler_oracle
