// The common factor of two polynomials; CGAL's polynomials in a translation unit of their own.

#include <CGAL/Gmpz.h>
#include <CGAL/Polynomial.h>
#include <CGAL/Polynomial_traits_d.h>
#include <CGAL/Polynomial_type_generator.h>

#include <algorithm>

#include "bipoly.hpp"

namespace feeler_oracle {
namespace {

using Inner = CGAL::Polynomial<Z>;      // in v
using Outer = CGAL::Polynomial<Inner>;  // in u

Outer to_outer(const BiPoly& f) {
    std::vector<Inner> rows;
    for (int i = 0; i <= f.p; ++i) {
        const auto first = f.c.begin() + i * (f.q + 1);
        rows.emplace_back(first, first + f.q + 1);
    }
    return Outer(rows.begin(), rows.end());
}

BiPoly from_outer(const Outer& f) {
    BiPoly r{std::max(f.degree(), 0), 0, {}};
    for (int i = 0; i <= f.degree(); ++i) r.q = std::max(r.q, f[i].degree());
    r.c.assign(std::size_t((r.p + 1) * (r.q + 1)), Z(0));
    for (int i = 0; i <= f.degree(); ++i)
        for (int j = 0; j <= f[i].degree(); ++j) r.at(i, j) = f[i][j];
    return r;
}

}  // namespace

CommonFactor common_factor(const BiPoly& f, const BiPoly& g) {
    const BiPoly one{0, 0, {Z(1)}}, zero{0, 0, {Z(0)}};
    if (f.is_zero()) return {g, zero, one};
    if (g.is_zero()) return {f, one, zero};
    const Outer a = to_outer(f), b = to_outer(g);
    const Outer h = CGAL::gcd(a, b);
    return {from_outer(h), from_outer(CGAL::integral_division(a, h)),
            from_outer(CGAL::integral_division(b, h))};
}

std::array<BiPoly, 3> contents(const BiPoly& f) {
    using Traits = CGAL::Polynomial_traits_d<Outer>;
    const Outer a = to_outer(f);
    const Inner of_v = Traits::Univariate_content()(a);
    const Outer rest = CGAL::integral_division(a, Outer(of_v));
    const Outer turned = to_outer(transposed(from_outer(rest)));
    const Inner of_u = Traits::Univariate_content()(turned);
    const Outer core = CGAL::integral_division(turned, Outer(of_u));
    return {transposed(from_outer(Outer(of_u))), from_outer(Outer(of_v)),
            transposed(from_outer(core))};
}

}  // namespace feeler_oracle
