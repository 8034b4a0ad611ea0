#include "line_roots.hpp"

#include <cmath>

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
    return false;
}

}  // namespace

PatchRoots patch_roots(const Net& f1, const Net& f2, const std::array<double, 4>& area,
                       long budget) {
    PatchRoots found;
    std::array<Real, 4> whole;
    for (int k = 0; k < 4; ++k) whole[k] = Real(area[k]);
    const auto over = [&](const Net& f) {
        return restrict_v(restrict_u(f, whole[0], whole[1]), whole[2], whole[3]);
    };
    const bool unit = area[0] == 0 && area[1] == 1 && area[2] == 0 && area[3] == 1;
    std::vector<Node> stack;
    stack.push_back({unit ? f1 : over(f1), unit ? f2 : over(f2), whole, 0});
    while (!stack.empty()) {
        const Node n = std::move(stack.back());
        stack.pop_back();
        ++found.boxes;
        if (known(found, n.box) || excluded(n)) continue;
        if (found.boxes > budget || n.depth >= kDeepest) {
            found.open.push_back(n.box);
            continue;
        }
        PatchRoot root;
        if (certify(n, root)) {
            // The neighbours find it too: the same root if it lies where another is unique.
            if (!known(found, root.box)) found.roots.push_back(root);
            continue;
        }
        // Halve where the polynomials change more.
        const auto g1 = gradient(n.f1), g2 = gradient(n.f2);
        const double along_u = std::abs(g1[0]) + std::abs(g2[0]),
                     along_v = std::abs(g1[1]) + std::abs(g2[1]);
        const double wu = sub_up(n.box[1], n.box[0]).up(), wv = sub_up(n.box[3], n.box[2]).up();
        // Near a pole boxes have to get long: the patch turns there by far less than it stretches.
        constexpr double kMost = 0x1p60;
        const bool u = wu > kMost * wv || (wv <= kMost * wu && along_u >= along_v);
        Node lower{{}, {}, n.box, n.depth + 1}, upper = lower;
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
