#include "derivative_roots.hpp"

#include <CGAL/Algebraic_kernel_d_1.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "interval.hpp"

namespace feeler_oracle {
namespace {

using Kernel = CGAL::Algebraic_kernel_d_1<Z>;
using Polynomial = Kernel::Polynomial_1;
using Algebraic = Kernel::Algebraic_real_1;

// Power basis, ascending.
using Coefficients = std::vector<Q>;

// One coordinate's derivative on one piece, in the piece's own s: the curve's parameter is
// t0 + s (t1 - t0), and the part in use is [s0, s1] (or `roots` say where in t).
struct Stretch {
    Q from, to;  // of the curve's parameter
    bool constant = false;
    std::array<int, 2> multiplicity{};  // at from, at to
    std::array<int, 2> sign{};          // just above from, just below to
    std::vector<DerivativeRoot> inside;
    std::array<bool, 2> cusp{};  // at from, at to
};

Coefficients power_basis(std::vector<Q> b) {
    const int n = int(b.size()) - 1;
    Coefficients c;
    Q binomial(1);
    for (int k = 0; k <= n; ++k) {
        c.push_back(binomial * b[0]);
        for (std::size_t i = 0; i + 1 < b.size(); ++i) b[i] = b[i + 1] - b[i];
        b.pop_back();
        binomial = binomial * Q(n - k) / Q(k + 1);
    }
    return c;
}

void strip(Coefficients& c) {
    while (!c.empty() && sign(c.back()) == 0) c.pop_back();
}

// X'W - XW'.
Coefficients numerator(const Coefficients& x, const Coefficients& w) {
    Coefficients n(x.size() + w.size(), Q(0));
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t j = 0; j < w.size(); ++j)
            if (i != j) n[i + j - 1] += Q(int(i) - int(j)) * x[i] * w[j];
    strip(n);
    return n;
}

// A positive multiple with coprime integer coefficients. f is not zero.
Polynomial integral(const Coefficients& f) {
    Z denominator(1);
    for (const Q& x : f) {
        const Z d = x.denominator();
        denominator = CGAL::integral_division(denominator * d, CGAL::gcd(denominator, d));
    }
    std::vector<Z> c;
    Z content(0);
    for (const Q& x : f) {
        c.push_back(x.numerator() * CGAL::integral_division(denominator, x.denominator()));
        content = CGAL::gcd(content, c.back());
    }
    for (Z& x : c) x = CGAL::integral_division(x, content);
    return Polynomial(c.begin(), c.end());
}

Q value_at(const Coefficients& f, const Q& s) {
    Q sum(0);
    for (std::size_t k = f.size(); k-- > 0;) sum = sum * s + f[k];
    return sum;
}

// The multiplicity of s as a root of f, which is not zero, and the sign of f beside it: above if
// `above`, else below.
std::pair<int, int> order_at(Coefficients f, const Q& s, bool above) {
    int order = 0;
    while (true) {
        const int at = sign(value_at(f, s));
        // The leading term of the Taylor series: f^(m)(s) (t - s)^m.
        if (at != 0) return {order, !above && order % 2 ? -at : at};
        for (std::size_t k = 0; k + 1 < f.size(); ++k) f[k] = Q(int(k) + 1) * f[k + 1];
        f.pop_back();
        ++order;
    }
}

// Intervals of the roots, apart from each other and from the ends s0, s1, each no wider than
// 2^-bits.
std::vector<std::pair<Q, Q>> approximate(const Kernel& kernel, const std::vector<Algebraic>& roots,
                                         const Q& s0, const Q& s1, int bits) {
    // Doubled each time; a degree of 2 kMaxDegree and the largest coefficients admitted keep
    // distinct roots farther apart than this (Mahler's bound), and it is reached for no input.
    constexpr int kMostBits = 1 << 24;
    for (; bits <= kMostBits; bits *= 2) {
        std::vector<std::pair<Q, Q>> out;
        bool apart = true;
        Q last = s0;
        for (const Algebraic& root : roots) {
            out.push_back(kernel.approximate_absolute_1_object()(root, bits));
            apart = apart && last < out.back().first;
            last = out.back().second;
        }
        if (apart && (roots.empty() || last < s1)) return out;
    }
    throw std::runtime_error("roots too close to be told apart");
}

struct Exact {
    Coefficients n[2];  // the numerators of u', v'
    Q t0, t1;           // the curve's parameter at s = 0 and s = 1
    Q s0, s1;           // the part in use
};

std::array<Stretch, 2> stretches_of(const Exact& e, int bits) {
    const Kernel kernel;
    std::array<Stretch, 2> out;
    const Q width = e.t1 - e.t0;
    for (int axis = 0; axis < 2; ++axis) {
        Stretch& s = out[axis];
        s.from = e.t0 + e.s0 * width;
        s.to = e.t0 + e.s1 * width;
        const Coefficients &f = e.n[axis], &g = e.n[1 - axis];
        s.constant = f.empty();
        if (s.constant) continue;
        std::tie(s.multiplicity[0], s.sign[0]) = order_at(f, e.s0, true);
        std::tie(s.multiplicity[1], s.sign[1]) = order_at(f, e.s1, false);
        for (int end = 0; end < 2; ++end)
            s.cusp[end] =
                s.multiplicity[end] > 0 && (g.empty() || sign(value_at(g, end ? e.s1 : e.s0)) == 0);
        if (f.size() < 2) continue;
        const Polynomial polynomial = integral(f);
        std::vector<std::pair<Algebraic, Kernel::Multiplicity_type>> all;
        kernel.solve_1_object()(polynomial, e.s0, e.s1, std::back_inserter(all));
        std::vector<Algebraic> roots;
        std::vector<int> multiplicities;
        for (const auto& [root, multiplicity] : all) {
            if (kernel.compare_1_object()(root, e.s0) != CGAL::LARGER ||
                kernel.compare_1_object()(root, e.s1) != CGAL::SMALLER)
                continue;
            roots.push_back(root);
            multiplicities.push_back(int(multiplicity));
        }
        const auto intervals = approximate(kernel, roots, e.s0, e.s1, bits);
        int current = s.sign[0];
        for (std::size_t i = 0; i < roots.size(); ++i) {
            const int m = multiplicities[i], next = m % 2 ? -current : current;
            const bool cusp =
                g.empty() ||
                (g.size() > 1 && kernel.sign_at_1_object()(integral(g), roots[i]) == CGAL::ZERO);
            s.inside.push_back({e.t0 + intervals[i].first * width,
                                e.t0 + intervals[i].second * width,
                                {m, m},
                                {current, next},
                                cusp});
            current = next;
        }
        if (current != s.sign[1]) throw std::logic_error("the roots' multiplicities do not add up");
    }
    return out;
}

// The curve's parameter and the piece's own one.
struct Map {
    Q t0, t1, own0, own1;
    Q to_own(const Q& t) const {
        return t == t0 ? own0 : t == t1 ? own1 : own0 + (t - t0) / (t1 - t0) * (own1 - own0);
    }
    Q to_curve(const Q& x) const {
        return x == own0 ? t0 : x == own1 ? t1 : t0 + (x - own0) / (own1 - own0) * (t1 - t0);
    }
};

// The part of the span own0..own1 of a piece that lies in [from, to] of the curve's parameter;
// false if that is empty.
bool set_span(Exact& e, const Map& map, const Q& from, const Q& to, const Q& own0, const Q& own1) {
    const Q a = std::max(map.to_own(from), own0), b = std::min(map.to_own(to), own1);
    if (!(a < b)) return false;
    e.t0 = map.to_curve(own0);
    e.t1 = map.to_curve(own1);
    e.s0 = (a - own0) / (own1 - own0);
    e.s1 = (b - own0) / (own1 - own0);
    return true;
}

using Stretches = std::vector<std::array<Stretch, 2>>;

void stretches(const Polyline& line, Map map, const Q& from, const Q& to, int bits,
               Stretches& out) {
    map.own0 = Q(line.params.front());
    map.own1 = Q(line.params.back());
    for (std::size_t i = 0; i + 1 < line.params.size(); ++i) {
        Exact e;
        if (!set_span(e, map, from, to, Q(line.params[i]), Q(line.params[i + 1]))) continue;
        for (int axis = 0; axis < 2; ++axis) {
            e.n[axis] = {Q(line.points[2 * i + 2 + axis]) - Q(line.points[2 * i + axis])};
            strip(e.n[axis]);
        }
        out.push_back(stretches_of(e, bits));
    }
}

void stretches(const NurbsCurve2& curve, Map map, const Q& from, const Q& to, int bits,
               Stretches& out) {
    const int p = curve.degree, n = int(curve.knots.size()) - p - 1;
    map.own0 = Q(curve.knots[p]);
    map.own1 = Q(curve.knots[n]);
    for (int i = p; i < n; ++i) {
        if (!(curve.knots[i] < curve.knots[i + 1])) continue;
        Exact e;
        const Q k0(curve.knots[i]), k1(curve.knots[i + 1]);
        if (!set_span(e, map, from, to, k0, k1)) continue;
        std::array<std::vector<Q>, 3> bezier;
        for (const auto& row : blossom_matrix(p, curve.knots, i, k0, k1))
            for (int c = 0; c < 3; ++c) {
                Q sum(0);
                for (int j = 0; j <= p; ++j) sum += row[j] * Q(curve.points[3 * (i - p + j) + c]);
                bezier[c].push_back(sum);
            }
        const Coefficients w = power_basis(bezier[2]);
        for (int axis = 0; axis < 2; ++axis) e.n[axis] = numerator(power_basis(bezier[axis]), w);
        out.push_back(stretches_of(e, bits));
    }
}

// ---- arcs

// The least and largest number an MPFR computation, rounded down and up, can stand for.
template <class F>
std::pair<Q, Q> enclosed(mpfr_prec_t precision, F f) {
    const auto one = [&](mpfr_rnd_t direction) {
        mpfr_t r;
        mpq_t q;
        mpfr_init2(r, precision);
        mpq_init(q);
        f(r, direction);
        mpfr_get_q(q, r);
        Q x(q);
        mpq_clear(q);
        mpfr_clear(r);
        return x;
    };
    return {one(MPFR_RNDD), one(MPFR_RNDU)};
}

// The zeros of sin(phi - a) with phi = atan2(r, p): phi + k pi.
class ArcZeros {
 public:
    ArcZeros(double p, double r, mpfr_prec_t precision) : exact_(r == 0), flip_(r == 0 && p < 0) {
        phi_ = exact_ ? std::make_pair(Q(0), Q(0))
                      : enclosed(precision, [&](mpfr_ptr x, mpfr_rnd_t direction) {
                            const Real row[2] = {Real(p), Real(r)};
                            mpfr_atan2(x, row[1].get(), row[0].get(), direction);
                        });
        pi_ = enclosed(precision,
                       [](mpfr_ptr x, mpfr_rnd_t direction) { mpfr_const_pi(x, direction); });
    }
    // Zero k, enclosed; a single number where it is rational.
    std::pair<Q, Q> zero(long k) const {
        const Q n(k);
        return k < 0 ? std::make_pair(phi_.first + n * pi_.second, phi_.second + n * pi_.first)
                     : std::make_pair(phi_.first + n * pi_.first, phi_.second + n * pi_.second);
    }
    // The sign of sin(phi - a) just above zero k.
    int above(long k) const { return (k % 2 == 0) != flip_ ? -1 : 1; }

 private:
    bool exact_, flip_;  // phi is 0 or pi, and counted from 0
    std::pair<Q, Q> phi_, pi_;
};

// -1, 0, 1: where the zero lies relative to x; 2 if that is not known.
int compare(const std::pair<Q, Q>& zero, const Q& x) {
    if (zero.second < x) return -1;
    if (zero.first > x) return 1;
    return zero.first == zero.second ? 0 : 2;
}

// More than any drawing's; each has its turns listed.
constexpr long kMostTurns = 1 << 12;

// One coordinate of an arc between the angles a0 < a1; `to_curve` takes an angle to the curve's
// parameter. False where the precision does not suffice.
template <class F>
bool arc_stretch(double p, double r, const Q& a0, const Q& a1, int bits, mpfr_prec_t precision,
                 F to_curve, Stretch& s) {
    const ArcZeros zeros(p, r, precision);
    s = Stretch();
    s.from = to_curve(a0);
    s.to = to_curve(a1);
    const Q widest = (a1 - a0) / Q(CGAL::ipower(Z(2), bits));
    // The zero before a0, or one or two before that: |phi| <= pi, and this quotient is good to
    // 1e-6.
    const long first = long(std::floor(double_bounds(a0).first / 3.141592653589793)) - 3;
    long last_below = first;  // the last zero that is not above a0
    for (long k = first;; ++k) {
        const auto zero = zeros.zero(k);
        const int start = compare(zero, a0), end = compare(zero, a1);
        if (start == 2 || end == 2) return false;
        if (start <= 0) {
            last_below = k;
            if (start == 0) s.multiplicity[0] = 1;
            continue;
        }
        if (k == last_below + 1) s.sign[0] = zeros.above(last_below);
        if (end >= 0) {
            s.sign[1] = zeros.above(k - 1);
            if (end == 0) s.multiplicity[1] = 1;
            return true;
        }
        if (zero.second - zero.first > widest) return false;
        s.inside.push_back({to_curve(zero.first),
                            to_curve(zero.second),
                            {1, 1},
                            {zeros.above(k - 1), zeros.above(k)},
                            false});
    }
}

void stretches(const Arc2& arc, Map map, const Q& from, const Q& to, int bits, Stretches& out) {
    map.own0 = Q(arc.domain[0]);
    map.own1 = Q(arc.domain[1]);
    const Map angles{map.own0, map.own1, Q(arc.angle[0]), Q(arc.angle[1])};
    const Q a0 = angles.to_own(map.to_own(from)), a1 = angles.to_own(map.to_own(to));
    if (a1 - a0 > Q(6 * kMostTurns)) throw std::invalid_argument("an arc of too many turns");
    const auto to_curve = [&](const Q& a) { return map.to_curve(angles.to_curve(a)); };
    const bool clockwise = Q(arc.x[0]) * Q(arc.y[1]) < Q(arc.x[1]) * Q(arc.y[0]);
    const double turn = clockwise ? -1 : 1;
    std::array<Stretch, 2> both;
    for (int axis = 0; axis < 2; ++axis) {
        const double p = arc.x[axis], r = axis == 0 ? -turn * arc.x[1] : turn * arc.x[0];
        // Ends are rational and zeros are not (or exact): this comes to an end.
        mpfr_prec_t precision = bits + 64;
        while (!arc_stretch(p, r, a0, a1, bits, precision, to_curve, both[axis])) {
            if (precision > 1 << 20) throw std::runtime_error("an arc's end too near an extremum");
            precision *= 2;
        }
    }
    out.push_back(both);
}

// The roots of one coordinate over all stretches.
AxisRoots joined(const Stretches& all, int axis) {
    AxisRoots out;
    for (std::size_t i = 0; i <= all.size(); ++i) {
        const Stretch* before = i > 0 ? &all[i - 1][axis] : nullptr;
        const Stretch* after = i < all.size() ? &all[i][axis] : nullptr;
        DerivativeRoot joint{Q(0), Q(0), {0, 0}, {0, 0}, false};
        if (before) {
            joint.lo = before->to;
            joint.multiplicity[0] = before->multiplicity[1];
            joint.sign[0] = before->sign[1];
            joint.cusp = before->cusp[1];
        }
        if (after) {
            joint.lo = after->from;
            joint.multiplicity[1] = after->multiplicity[0];
            joint.sign[1] = after->sign[0];
            joint.cusp = joint.cusp || after->cusp[0];
        }
        joint.hi = joint.lo;
        if (joint.multiplicity[0] > 0 || joint.multiplicity[1] > 0 ||
            joint.sign[0] * joint.sign[1] < 0)
            out.roots.push_back(joint);
        if (!after) continue;
        out.roots.insert(out.roots.end(), after->inside.begin(), after->inside.end());
        if (!after->constant) continue;
        if (before && before->constant)
            out.constant.back().second = after->to;
        else
            out.constant.emplace_back(after->from, after->to);
    }
    return out;
}

}  // namespace

std::array<AxisRoots, 2> derivative_roots(const TrimCurve& trim, int bits) {
    const Q start(trim.start), end(trim.end);
    Stretches all;
    for (std::size_t i = 0; i < trim.pieces.size(); ++i) {
        const Q t0(trim.params[i]), t1(trim.params[i + 1]);
        const Q from = std::max(start, t0), to = std::min(end, t1);
        if (!(from < to)) continue;
        const Map map{t0, t1, Q(0), Q(1)};
        std::visit([&](const auto& piece) { stretches(piece, map, from, to, bits, all); },
                   trim.pieces[i]);
    }
    return {joined(all, 0), joined(all, 1)};
}

}  // namespace feeler_oracle
