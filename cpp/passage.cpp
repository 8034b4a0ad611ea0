#include "passage.hpp"

namespace feeler_oracle {
namespace {

int strict_sign(const Interval64& x) { return x.lo > 0 ? 1 : x.hi < 0 ? -1 : 0; }

int hull_sign(const std::vector<Interval64>& c) {
    const int s = strict_sign(c[0]);
    for (std::size_t i = 1; s != 0 && i < c.size(); ++i)
        if (strict_sign(c[i]) != s) return 0;
    return s;
}

// (x + y) / 2: halving is exact, or loses half of a denormal, which the widening covers.
Interval64 average(const Interval64& x, const Interval64& y) {
    return {next_down(0.5 * (x.lo + y.lo)), next_up(0.5 * (x.hi + y.hi))};
}

// The coefficients over [0, t] and [t, 1]; t and 1 - t are exact.
void split(const std::vector<Interval64>& c, double t, std::vector<Interval64>& left,
           std::vector<Interval64>& right) {
    const std::size_t n = c.size();
    const Interval64 a(1 - t), b(t);
    right = c;
    left.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
        left[k] = right[0];
        if (t == 0.5)  // almost always, and several times as fast
            for (std::size_t i = 0; i + 1 < n - k; ++i) right[i] = average(right[i], right[i + 1]);
        else
            for (std::size_t i = 0; i + 1 < n - k; ++i) right[i] = a * right[i] + b * right[i + 1];
    }
}

// The coefficients over [a, b], 0 <= a < b <= 1.
std::vector<Interval> restricted(const std::vector<Interval>& c, double a, double b) {
    const std::size_t n = c.size();
    const auto blend = [](const Interval& x, const Interval& y, const Interval& t) {
        return x + t * (y - x);
    };
    std::vector<Interval> lower = c;
    if (b < 1) {
        const Interval t(b);
        std::vector<Interval> rest = c;
        for (std::size_t k = 0; k < n; ++k) {
            lower[k] = rest[0];
            for (std::size_t i = 0; i + 1 < n - k; ++i) rest[i] = blend(rest[i], rest[i + 1], t);
        }
    }
    if (a > 0) {
        const Interval t = divide_positive(Interval(a), Interval(b));
        for (std::size_t k = 1; k < n; ++k)
            for (std::size_t i = 0; i + k < n; ++i) lower[i] = blend(lower[i], lower[i + 1], t);
    }
    return lower;
}

// [from, from + length], multiples of 2^-bits.
struct Part {
    std::vector<Interval64> f, g;
    double from, length;
    int bits;
    bool above0, above1;
};

// Eighths.
constexpr double kSplits[] = {0.5, 0.375, 0.625, 0.25};
// So far from the noise of doubles that one or two parts are left, where it is one point of the
// curve that q is near to. The ends of parts are doubles.
constexpr int kBits = 24;
// Of parts looked at in one round, and of those that are left to the next.
constexpr int kMost = 400, kLeft = 6;
// Each round comes 2^-kBits nearer.
constexpr int kRounds = 8;

// Parity of the parts that are settled; others go to `left`. Whether it is of use.
bool settle(Part whole, bool& odd, std::vector<Part>& left) {
    std::vector<Part> stack;
    stack.push_back(std::move(whole));
    for (int count = 0; !stack.empty(); ++count) {
        if (count == kMost || left.size() > kLeft) return false;
        Part part = std::move(stack.back());
        stack.pop_back();
        if (hull_sign(part.f) != 0) continue;
        const int right = hull_sign(part.g);
        if (right < 0) continue;
        if (right > 0) {
            odd ^= part.above0 != part.above1;
            continue;
        }
        Part lower, upper;
        int middle = 0;
        for (const double t : kSplits) {
            if (part.bits + 3 > kBits) break;
            split(part.f, t, lower.f, upper.f);
            middle = strict_sign(upper.f[0]);
            if (middle == 0) continue;
            if (hull_sign(lower.f) != 0 && hull_sign(upper.f) != 0) break;
            split(part.g, t, lower.g, upper.g);
            lower.from = part.from;
            lower.length = t * part.length;
            upper.from = part.from + lower.length;
            upper.length = part.length - lower.length;
            lower.bits = upper.bits = part.bits + (t == 0.5 ? 1 : 3);
            break;
        }
        if (middle == 0) {
            left.push_back(std::move(part));
            continue;
        }
        if (lower.g.empty()) continue;  // f is of one sign on both halves
        lower.above0 = part.above0;
        lower.above1 = upper.above0 = middle > 0;
        upper.above1 = part.above1;
        stack.push_back(std::move(lower));
        stack.push_back(std::move(upper));
    }
    return true;
}

std::vector<Interval64> rounded(const std::vector<Interval>& c) {
    std::vector<Interval64> r;
    for (const Interval& x : c) r.push_back(x.outer());
    return r;
}

}  // namespace

std::optional<Passage> certain_passage(std::vector<Interval> f, std::vector<Interval> g,
                                       bool above0, bool above1) {
    struct Wide {
        std::vector<Interval> f, g;
        bool above0, above1;
        int round;
    };
    bool odd = false;
    std::vector<Wide> todo;
    todo.push_back({std::move(f), std::move(g), above0, above1, 1});
    while (!todo.empty()) {
        const Wide e = std::move(todo.back());
        todo.pop_back();
        std::vector<Part> left;
        if (!settle({rounded(e.f), rounded(e.g), 0, 1, 0, e.above0, e.above1}, odd, left))
            return std::nullopt;
        for (const Part& part : left) {
            if (e.round == kRounds || todo.size() >= kLeft) return std::nullopt;
            const double a = part.from, b = part.from + part.length;
            // A part that is the whole again got nowhere.
            if (a == 0 && b == 1) return std::nullopt;
            todo.push_back({restricted(e.f, a, b), restricted(e.g, a, b), part.above0, part.above1,
                            e.round + 1});
        }
    }
    return odd ? Passage::Odd : Passage::Even;
}

}  // namespace feeler_oracle
