#include "line_roots.hpp"

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "arc_roots.hpp"

namespace feeler_oracle {
namespace {

struct Node {
    Net f1, f2;
    std::array<Real, 4> box;
    int depth;
};

// Boxes below 2^-90 of the patch in both directions stay open: a tangency, or a curve of roots.
constexpr int kDeepest = 180;
// Narrower than this a root box is good: Real has 320 bits.
constexpr double kNarrow = 0x1p-240;
// A wider one is searched on: its t would be no truth of 160 bits.
constexpr double kUsable = 0x1p-180;

Real sum(const Real& a, const Real& b) {
    // Exact here: dyadics of the search.
    Real r;
    mpfr_add(r.get(), a.get(), b.get(), MPFR_RNDN);
    return r;
}

Real scaled(const Real& a, const Real& b, int numerator_a, int numerator_b, int halvings) {
    // (numerator_a a + numerator_b b) / 2^halvings; exact for dyadics of the search.
    Real x, y;
    mpfr_mul_si(x.get(), a.get(), numerator_a, MPFR_RNDN);
    mpfr_mul_si(y.get(), b.get(), numerator_b, MPFR_RNDN);
    Real r = sum(x, y);
    mpfr_div_2si(r.get(), r.get(), halvings, MPFR_RNDN);
    return r;
}

double middle(const Interval& x) { return x.middle().near(); }

// The first differences across the net, about: the gradient times the box's size.
std::array<double, 2> gradient(const Net& n) {
    const auto corner = [&](int i, int j) {
        return middle(n.c[std::size_t(i * n.p * (n.q + 1) + j * n.q)]);
    };
    const double c00 = corner(0, 0), c01 = corner(0, 1), c10 = corner(1, 0), c11 = corner(1, 1);
    return {0.5 * (c10 + c11 - c00 - c01), 0.5 * (c01 + c11 - c00 - c10)};
}

// How much the coefficients change in all along u and along v, about, in the row that does most.
std::array<double, 2> variation(const Net& n) {
    std::array<double, 2> most = {0, 0};
    std::vector<double> c;
    for (const Interval& x : n.c) c.push_back(middle(x));
    const auto at = [&](int i, int j) { return c[std::size_t(i * (n.q + 1) + j)]; };
    for (int i = 0; i <= n.p; ++i) {
        double sum = 0;
        for (int j = 0; j < n.q; ++j) sum += std::abs(at(i, j + 1) - at(i, j));
        most[1] = std::max(most[1], sum);
    }
    for (int j = 0; j <= n.q; ++j) {
        double sum = 0;
        for (int i = 0; i < n.p; ++i) sum += std::abs(at(i + 1, j) - at(i, j));
        most[0] = std::max(most[0], sum);
    }
    return most;
}

// Scalars of any size make valid combinations; these keep clear of overflow.
void normalise(std::array<double, 2>& a, std::array<double, 2>& b) {
    double m = 0;
    for (double x : {a[0], a[1], b[0], b[1]}) m = std::max(m, std::abs(x));
    if (!(m > 0) || !std::isfinite(1 / m)) return;
    for (auto* g : {&a, &b})
        for (double& x : *g) x /= m;
}

bool excluded(const Node& n) {
    if (excludes_zero(hull(n.f1)) || excludes_zero(hull(n.f2))) return true;
    auto g1 = gradient(n.f1), g2 = gradient(n.f2);
    normalise(g1, g2);
    return excludes_zero(hull(combine(g2[1], n.f1, -g1[1], n.f2))) ||
           excludes_zero(hull(combine(-g2[0], n.f1, g1[0], n.f2)));
}

bool contains(const std::array<Real, 4>& outer, const std::array<Real, 4>& inner) {
    return outer[0] <= inner[0] && inner[1] <= outer[1] && outer[2] <= inner[2] &&
           inner[3] <= outer[3];
}

// The operator on the nets' unit square. Whether it lies inside, and so proves a root; a root in
// the square is in K in any case, where K was computed.
struct Step {
    Interval u, v;
    int orientation;
    bool computed = false;
};
bool krawczyk(const Net& f1, const Net& f2, Step& step) {
    const auto a = gradient(f1), b = gradient(f2);
    double m = 0;
    step.computed = false;
    for (double x : {a[0], a[1], b[0], b[1]}) m = std::max(m, std::abs(x));
    if (!(m > 0) || !std::isfinite(1 / m)) return false;
    const double det = (a[0] / m) * (b[1] / m) - (a[1] / m) * (b[0] / m);
    const double k = 1 / (det * m);
    if (!std::isfinite(k) || k == 0) return false;
    const double y00 = b[1] / m * k, y01 = -a[1] / m * k, y10 = -b[0] / m * k, y11 = a[0] / m * k;
    const Net g1 = combine(y00, f1, y01, f2), g2 = combine(y10, f1, y11, f2);
    const Interval one(1.0), half(0.5), reach{Real(-0.5), Real(0.5)};
    const Interval j00 = hull_du(g1), j01 = hull_dv(g1), j10 = hull_du(g2), j11 = hull_dv(g2);
    step.computed = true;
    step.u = half - at_middle(g1) + (one - j00) * reach - j01 * reach;
    step.v = half - at_middle(g2) - j10 * reach + (one - j11) * reach;
    // K inside the box proves Y and J regular and I - Y J of norm < 1, so that det(Y J) > 0.
    const Interval det_y = Interval(y00) * Interval(y11) - Interval(y01) * Interval(y10);
    step.orientation = det_y.lo.sign() > 0 ? 1 : -1;
    const auto inside = [](const Interval& x) {
        return x.lo.sign() > 0 && mpfr_cmp_ui(x.hi.get(), 1) < 0;
    };
    return inside(step.u) && inside(step.v);
}

// A box that is flat in one direction (K may be a point there) has no Jacobian to speak of: it is
// widened to a part of the other's width.
void inflate(Interval& u, Interval& v) {
    constexpr double kPart = 0.25, kLeast = 0x1p-200;
    const double wu = sub_up(u.hi, u.lo).up(), wv = sub_up(v.hi, v.lo).up();
    const double least = std::max(kPart * std::max(wu, wv), kLeast);
    for (auto* x : {&u, &v})
        if ((x == &u ? wu : wv) < least) {
            x->lo = sub_down(x->lo, Real(least));
            x->hi = add_up(x->hi, Real(least));
        }
}

double width_of(const std::array<Real, 4>& box) {
    return std::max(sub_up(box[1], box[0]).up(), sub_up(box[3], box[2]).up());
}

// Tries the node's box enlarged by half its size to each side.
bool certify(const Node& n, PatchRoot& root) {
    Real lo(-0.5), hi(1.5);
    Net f1 = restrict_v(restrict_u(n.f1, lo, hi), lo, hi);
    Net f2 = restrict_v(restrict_u(n.f2, lo, hi), lo, hi);
    Step step;
    if (!krawczyk(f1, f2, step)) return false;
    const auto cut = [](Interval& x) {
        if (x.lo < Real(-0.25)) x.lo = Real(-0.25);
        if (Real(1.25) < x.hi) x.hi = Real(1.25);
    };
    const auto& b = n.box;
    root.unique = {scaled(b[0], b[1], 3, -1, 1), scaled(b[0], b[1], -1, 3, 1),
                   scaled(b[2], b[3], 3, -1, 1), scaled(b[2], b[3], -1, 3, 1)};
    root.orientation = step.orientation;
    // Patch parameter = start + size * local parameter, as intervals.
    Interval start_u(root.unique[0]), start_v(root.unique[2]);
    Interval size_u = Interval(root.unique[1]) - start_u,
             size_v = Interval(root.unique[3]) - start_v;
    double width = INFINITY;
    for (int round = 0;; ++round) {
        const Interval u = start_u + size_u * step.u, v = start_v + size_v * step.v;
        root.box = {u.lo, u.hi, v.lo, v.hi};
        const double now = width_of(root.box);
        // Newton's convergence ends at the width of the coefficients.
        if (now <= kNarrow || now > 0.5 * width || round == 20) break;
        width = now;
        inflate(step.u, step.v);
        f1 = restrict_v(restrict_u(f1, step.u.lo, step.u.hi), step.v.lo, step.v.hi);
        f2 = restrict_v(restrict_u(f2, step.u.lo, step.u.hi), step.v.lo, step.v.hi);
        start_u = start_u + size_u * Interval(step.u.lo);
        start_v = start_v + size_v * Interval(step.v.lo);
        size_u = size_u * (Interval(step.u.hi) - Interval(step.u.lo));
        size_v = size_v * (Interval(step.v.hi) - Interval(step.v.lo));
        krawczyk(f1, f2, step);
        if (!step.computed) break;
        // The root is in the square and in K.
        cut(step.u);
        cut(step.v);
    }
    return width_of(root.box) <= kUsable;
}

bool known(const PatchRoots& found, const std::array<Real, 4>& box) {
    for (const auto& r : found.roots)
        if (contains(r.unique, box)) return true;
    for (const auto& b : found.settled)
        if (contains(b, box)) return true;
    return false;
}

bool overlaps_settled(const PatchRoots& found, const std::array<Real, 4>& box) {
    for (const auto& b : found.settled)
        if (b[0] <= box[1] && box[0] <= b[1] && b[2] <= box[3] && box[2] <= b[3]) return true;
    return false;
}

// ---- tangencies

// Below this sine of the angle between the gradients a box is looked at as a tangency.
constexpr double kNearlyParallel = 0.5;
// Boxes of so many halvings are tried for a contact of order m (multiplicity m or less): before,
// halving is cheaper.
constexpr int kFromDepth[kMostLevels + 1] = {4, 16, 4, 12, 20, 24};
// What an attempt costs, in boxes.
constexpr long kAttempt = 20;
// Attempts are made at boxes of every so many halvings, and for one that failed so many boxes are
// halved before the next: what fails must not take more time than halving does.
constexpr int kEvery = 2;
constexpr long kAfterFailure = 16;

Real to_real(const Q& x, mpfr_rnd_t direction) {
    Real r;
    mpfr_set_q(r.get(), x.mpq(), direction);
    return r;
}

class Tangencies {
 public:
    explicit Tangencies(const std::function<ExactForms()>& exact) : exact_(exact) {}
    bool possible() const { return bool(exact_); }
    // Proven to have no factor in common.
    bool coprime_forms() {
        if (!coprime_) coprime_ = coprime(forms().f1, forms().f2);
        return *coprime_;
    }
    // Tries to settle a box near the node. Whether it did.
    bool attempt(const Node& n, PatchRoots& found);
    // What that took since this was last asked, in boxes.
    long spent() {
        long sum = kAttempt;
        for (const auto& t : towers_)
            if (t) sum += std::exchange(t->work, 0);
        return sum;
    }

 private:
    const ExactForms& forms() {
        if (!forms_) forms_ = exact_();
        return *forms_;
    }
    const Tower& tower(bool second, bool swapped) {
        auto& slot = towers_[std::size_t(2 * second + swapped)];
        if (!slot) {
            const BiPoly &a = second ? forms().f2 : forms().f1,
                         &f = second ? forms().f1 : forms().f2;
            slot = swapped ? std::make_unique<Tower>(transposed(a), transposed(f))
                           : std::make_unique<Tower>(a, f);
        }
        return *slot;
    }
    const std::function<ExactForms()>& exact_;
    std::optional<ExactForms> forms_;
    std::optional<bool> coprime_;
    std::array<std::unique_ptr<Tower>, 4> towers_;
};

bool Tangencies::attempt(const Node& n, PatchRoots& found) {
    // By the patch's parameters; the box may be long.
    const double wu = sub_up(n.box[1], n.box[0]).up(), wv = sub_up(n.box[3], n.box[2]).up();
    auto g1 = gradient(n.f1), g2 = gradient(n.f2);
    for (auto* gradient : {&g1, &g2}) {
        (*gradient)[0] /= wu;
        (*gradient)[1] /= wv;
    }
    const double n1 = std::hypot(g1[0], g1[1]), n2 = std::hypot(g2[0], g2[1]);
    bool second = n2 > n1;
    // Along a curve on which the other is constant one sign tells; one may have that, the other
    // not.
    if (!tower(second, false).constant() && tower(!second, false).constant()) second = !second;
    const auto& g = second ? g2 : g1;
    const bool swapped = std::abs(g[1]) > std::abs(g[0]);
    const Tower& t = tower(second, swapped);
    const int kx = swapped ? 2 : 0, ky = swapped ? 0 : 2;
    const Q half(1, 2);
    const Q ends[2][2] = {{to_exact(n.box[kx]), to_exact(n.box[kx + 1])},
                          {to_exact(n.box[ky]), to_exact(n.box[ky + 1])}};
    const Q size = std::max(ends[0][1] - ends[0][0], ends[1][1] - ends[1][0]);
    for (int m = t.constant() ? 0 : 1; m <= kMostLevels; m = m == 0 ? kMostLevels + 1 : m + 1) {
        if (n.depth < kFromDepth[m]) continue;
        // To the place where the method is centred: a common root of the curve and J_(m-1).
        std::array<Q, 2> at = {(ends[0][0] + ends[0][1]) * half, (ends[1][0] + ends[1][1]) * half};
        constexpr int kSteps = 8;
        bool near = true;
        for (int step = 0; near && step < kSteps; ++step) {
            const auto by = m < 2 ? t.to_curve(at[0], at[1]) : t.newton(m - 1, at[0], at[1]);
            if (!by) break;
            bool small = true;
            for (int k = 0; k < 2; ++k) {
                // Rounded to what matters here.
                at[k] = to_exact(to_real(at[k] + (*by)[k], MPFR_RNDN));
                near &= ends[k][0] - size <= at[k] && at[k] <= ends[k][1] + size;
                small &= CGAL::abs((*by)[k]) * Q(1L << 40) <= size;
            }
            if (small) break;
        }
        if (!near) continue;
        const auto box = [&](const Q& x0, const Q& x1, const Q& y0, const Q& y1) {
            const Real x[2] = {to_real(x0, MPFR_RNDD), to_real(x1, MPFR_RNDU)};
            const Real y[2] = {to_real(y0, MPFR_RNDD), to_real(y1, MPFR_RNDU)};
            return swapped ? std::array<Real, 4>{y[0], y[1], x[0], x[1]}
                           : std::array<Real, 4>{x[0], x[1], y[0], y[1]};
        };
        const auto inward = [&](const Q& x0, const Q& x1, const Q& y0, const Q& y1) {
            const Real x[2] = {to_real(x0, MPFR_RNDU), to_real(x1, MPFR_RNDD)};
            const Real y[2] = {to_real(y0, MPFR_RNDU), to_real(y1, MPFR_RNDD)};
            return swapped ? std::array<Real, 4>{y[0], y[1], x[0], x[1]}
                           : std::array<Real, 4>{x[0], x[1], y[0], y[1]};
        };
        if (known(found, box(at[0], at[0], at[1], at[1]))) return false;
        // No size of which an end might be a place of the model's own.
        constexpr double kReach = 13.37;
        const double reach = std::min(0.4321, kReach * double_bounds(size).second);
        const auto arc = arc_roots(t, m, at[0], at[1], reach, reach);
        if (!arc) continue;
        std::vector<PatchRoot> fresh;
        for (const ArcRoot& r : arc->roots) {
            PatchRoot root;
            root.box = box(r.x0, r.x1, r.y0, r.y1);
            root.unique = inward(arc->x0, arc->x1, r.unique_y0, r.unique_y1);
            root.multiplicity = r.multiplicity;
            const bool odd = r.multiplicity % 2;
            root.orientation = r.sign * (odd && swapped ? -1 : 1) * (odd && second ? -1 : 1);
            root.curve = second ? 2 : 1;
            if (known(found, root.box)) continue;
            // Not told whether it is another box's.
            if (overlaps_settled(found, root.box)) return false;
            fresh.push_back(std::move(root));
        }
        for (auto& r : fresh) found.roots.push_back(std::move(r));
        found.settled.push_back(inward(arc->x0, arc->x1, arc->y0, arc->y1));
        return true;
    }
    return false;
}

// Whether both derivatives may vanish in the box, about.
bool may_be_critical(const Net& f) {
    for (bool u : {true, false}) {
        double lo = INFINITY, hi = -INFINITY;
        const int step = u ? f.q + 1 : 1;
        for (int i = 0; i + (u ? 1 : 0) <= f.p; ++i)
            for (int j = 0; j + (u ? 0 : 1) <= f.q; ++j) {
                const std::size_t k = std::size_t(i * (f.q + 1) + j);
                const double d = middle(f.c[k + std::size_t(step)]) - middle(f.c[k]);
                lo = std::min(lo, d);
                hi = std::max(hi, d);
            }
        if (lo > 0 || hi < 0) return false;
    }
    return true;
}

// Where a tangency may be: a rule of thumb that only says what is tried.
bool may_touch(const Node& n) {
    if (may_be_critical(n.f1) || may_be_critical(n.f2)) return true;
    auto a = gradient(n.f1), b = gradient(n.f2);
    for (auto* g : {&a, &b}) {
        const double m = std::max(std::abs((*g)[0]), std::abs((*g)[1]));
        if (!(m > 0) || !std::isfinite(m)) return true;
        for (double& x : *g) x /= m;
    }
    const double sine = std::abs(a[0] * b[1] - a[1] * b[0]);
    return sine < kNearlyParallel * std::hypot(a[0], a[1]) * std::hypot(b[0], b[1]);
}

}  // namespace

PatchRoots patch_roots(const Net& f1, const Net& f2, const std::array<double, 4>& area,
                       long& budget, const std::function<ExactForms()>& exact) {
    PatchRoots found;
    Tangencies tangencies(exact);
    std::array<Real, 4> whole;
    for (int k = 0; k < 4; ++k) whole[k] = Real(area[k]);
    const auto over = [&](const Net& f) {
        return restrict_v(restrict_u(f, whole[0], whole[1]), whole[2], whole[3]);
    };
    const bool unit = area[0] == 0 && area[1] == 1 && area[2] == 0 && area[3] == 1;
    long boxes = 0, failures = 0;
    std::vector<Node> stack;
    stack.push_back({unit ? f1 : over(f1), unit ? f2 : over(f2), whole, 0});
    while (!stack.empty()) {
        const Node n = std::move(stack.back());
        stack.pop_back();
        if (known(found, n.box)) continue;
        ++boxes;
        if (budget-- <= 0 || n.depth >= kDeepest) {
            found.open.push_back(n.box);
            continue;
        }
        if (excluded(n)) continue;
        PatchRoot root;
        if (certify(n, root)) {
            // The neighbours find it too: the same root if it lies where another is unique.
            if (known(found, root.box)) continue;
            if (overlaps_settled(found, root.box))
                found.open.push_back(n.box);
            else
                found.roots.push_back(root);
            continue;
        }
        if (tangencies.possible() && n.depth >= kFromDepth[2] && n.depth % kEvery == 0 &&
            boxes >= kAfterFailure * failures && may_touch(n)) {
            if (!tangencies.coprime_forms()) {
                found.common_factor = true;
                return found;
            }
            const bool settled = tangencies.attempt(n, found);
            budget -= tangencies.spent();
            if (!settled)
                ++failures;
            else if (known(found, n.box))
                continue;
        }
        // Halve where the polynomials change more, however long the boxes get: next to a side that
        // nearly collapses to a point, or along two curves that touch, they must.
        const auto v1 = variation(n.f1), v2 = variation(n.f2);
        const bool u = v1[0] + v2[0] >= v1[1] + v2[1];
        Node lower{{}, {}, n.box, n.depth + 1};
        Node upper = lower;
        halve_net(n.f1, u, lower.f1, upper.f1);
        halve_net(n.f2, u, lower.f2, upper.f2);
        const int k = u ? 0 : 2;
        const Real mid = scaled(n.box[k], n.box[k + 1], 1, 1, 1);
        lower.box[k + 1] = mid;
        upper.box[k] = mid;
        stack.push_back(std::move(upper));
        stack.push_back(std::move(lower));
    }
    return found;
}

}  // namespace feeler_oracle
