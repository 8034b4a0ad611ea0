#include "roots.hpp"

#include <CGAL/Algebraic_kernel_d_1.h>

namespace feeler_oracle {
namespace {

using Kernel = CGAL::Algebraic_kernel_d_1<Z>;
using Polynomial = Kernel::Polynomial_1;
using Root = std::pair<Kernel::Algebraic_real_1, Kernel::Multiplicity_type>;

// Integer power-basis coefficients of a positive multiple of the Bernstein polynomial, without
// leading zeros: c_k = C(n, k) times the k-th forward difference at 0.
std::vector<Z> power_basis(const std::vector<Q>& b) {
    Z denominator(1);
    for (const Q& x : b) {
        const Z d = x.denominator();
        denominator = CGAL::integral_division(denominator * d, CGAL::gcd(denominator, d));
    }
    std::vector<Z> differences;
    for (const Q& x : b)
        differences.push_back(x.numerator() *
                              CGAL::integral_division(denominator, x.denominator()));
    const int n = int(b.size()) - 1;
    std::vector<Z> c;
    Z binomial(1);
    for (int k = 0; k <= n; ++k) {
        c.push_back(binomial * differences[0]);
        for (std::size_t i = 0; i + 1 < differences.size(); ++i)
            differences[i] = differences[i + 1] - differences[i];
        differences.pop_back();
        binomial = CGAL::integral_division(binomial * Z(n - k), Z(k + 1));
    }
    while (!c.empty() && CGAL::is_zero(c.back())) c.pop_back();
    return c;
}

std::vector<Root> roots_in_unit(const Kernel& kernel, const Polynomial& f) {
    std::vector<Root> roots;
    kernel.solve_1_object()(f, Kernel::Bound(0), Kernel::Bound(1), std::back_inserter(roots));
    return roots;
}

// Where f vanishes identically the piece runs along the ray's line: no transition inside it.
Passage passage_along(const Kernel& kernel, const std::vector<Z>& g) {
    if (g.empty()) return Passage::Through;
    if (g.size() == 1) return Passage::Even;
    return roots_in_unit(kernel, Polynomial(g.begin(), g.end())).empty() ? Passage::Even
                                                                         : Passage::Through;
}

Passage passage_linear(const std::vector<Q>& f, const std::vector<Q>& g) {
    const int f0 = sign(f[0]), f1 = sign(f[1]), g0 = sign(g[0]), g1 = sign(g[1]);
    if (f0 == 0 && f1 == 0) return g0 * g1 <= 0 ? Passage::Through : Passage::Even;
    if (f0 * f1 > 0) return Passage::Even;
    // The root is at f0 / (f0 - f1), where g is (g0 f1 - g1 f0) / (f1 - f0).
    const int at = sign((g[0] * f[1] - g[1] * f[0])) * sign(f[1] - f[0]);
    if (at == 0) return Passage::Through;
    return at > 0 && (f0 > 0) != (f1 > 0) ? Passage::Odd : Passage::Even;
}

}  // namespace

Passage passage(const std::vector<Q>& f, const std::vector<Q>& g) {
    if (f.size() == 2) return passage_linear(f, g);
    const Kernel kernel;
    const auto fc = power_basis(f), gc = power_basis(g);
    if (fc.empty()) return passage_along(kernel, gc);
    if (fc.size() == 1) return Passage::Even;
    const auto roots = roots_in_unit(kernel, Polynomial(fc.begin(), fc.end()));
    // Sign of f just right of 0.
    int current = 0;
    for (const Z& c : fc)
        if (current == 0) current = CGAL::sign(c);
    bool odd = false;
    for (const auto& [root, multiplicity] : roots) {
        int at = 0;
        if (gc.size() == 1) at = CGAL::sign(gc[0]);
        if (gc.size() > 1) at = kernel.sign_at_1_object()(Polynomial(gc.begin(), gc.end()), root);
        if (at == 0) return Passage::Through;
        const bool first = kernel.compare_1_object()(root, Kernel::Bound(0)) == CGAL::EQUAL;
        const bool last = kernel.compare_1_object()(root, Kernel::Bound(1)) == CGAL::EQUAL;
        const int before = first ? 0 : current;
        if (!first && multiplicity % 2) current = -current;
        const int after = last ? 0 : current;
        // At the root itself f is not > 0.
        if (at > 0 && (before > 0) != (after > 0)) odd = !odd;
    }
    return odd ? Passage::Odd : Passage::Even;
}

bool common_root(const std::vector<Q>& f, const std::vector<Q>& g, const Q& lo, const Q& hi) {
    const Kernel kernel;
    auto fc = power_basis(f), gc = power_basis(g);
    if (fc.empty()) std::swap(fc, gc);
    if (fc.size() < 2) return false;
    std::vector<Root> roots;
    kernel.solve_1_object()(Polynomial(fc.begin(), fc.end()), lo, hi, std::back_inserter(roots));
    if (gc.empty()) return !roots.empty();
    if (gc.size() == 1) return false;
    const Polynomial other(gc.begin(), gc.end());
    for (const auto& root : roots)
        if (kernel.sign_at_1_object()(other, root.first) == CGAL::ZERO) return true;
    return false;
}

std::vector<std::pair<Q, Q>> isolate_roots(const std::vector<Q>& f, int bits) {
    const Kernel kernel;
    const auto fc = power_basis(f);
    std::vector<std::pair<Q, Q>> result;
    if (fc.size() < 2) return result;
    for (const auto& root : roots_in_unit(kernel, Polynomial(fc.begin(), fc.end())))
        result.push_back(kernel.approximate_absolute_1_object()(root.first, bits));
    return result;
}

}  // namespace feeler_oracle
