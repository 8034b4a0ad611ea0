// Bivariate polynomials with integer coefficients, exactly.
#pragma once

#include <array>
#include <vector>

#include "big.hpp"
#include "exact.hpp"

namespace feeler_oracle {

// The fraction of least denominator in [lo, hi].
Q simplest(Q lo, Q hi);

// Sum of c[i (q + 1) + j] u^i v^j.
struct BiPoly {
    int p = 0, q = 0;
    std::vector<Z> c;

    const Z& at(int i, int j) const { return c[std::size_t(i * (q + 1) + j)]; }
    Z& at(int i, int j) { return c[std::size_t(i * (q + 1) + j)]; }
    bool is_zero() const;
};

// A positive multiple of the Bernstein polynomial over [0, 1]^2 (coefficient (i, j) at
// i (q + 1) + j), without common divisor and without rows or columns of leading zeros.
BiPoly to_bipoly(int p, int q, const std::vector<Q>& bernstein);

BiPoly derivative(const BiPoly& f, bool by_u);
// a b - c d, divided by its coefficients' positive common divisor, without leading zeros.
BiPoly cross(const BiPoly& a, const BiPoly& b, const BiPoly& c, const BiPoly& d);
// u and v exchanged.
BiPoly transposed(const BiPoly& f);

Q value(const BiPoly& f, const Q& u, const Q& v);
Big value(const BiPoly& f, const Big& u, const Big& v);

// Coefficients of f(u + x, v + y) in x, y.
std::vector<Big> shifted(const BiPoly& f, const Q& u, const Q& v, long bits);

// No less than log2 of the sum of the coefficients' magnitudes, which is not 0.
long length_bits(const BiPoly& f);

// Whether f and g are proven to have no common factor. False where they have one; practically never
// otherwise.
bool coprime(const BiPoly& f, const BiPoly& g);

// f = common f', g = common g', not both zero, with f' and g' coprime.
struct CommonFactor {
    BiPoly common, f, g;
};
CommonFactor common_factor(const BiPoly& f, const BiPoly& g);

// f, which is not 0, as a product of a polynomial in u, one in v, and one without such factors.
std::array<BiPoly, 3> contents(const BiPoly& f);

// Bernstein coefficients over [0, 1]^2 in degrees p and q, which are no less than f's.
std::vector<Q> to_bernstein(const BiPoly& f, int p, int q);

}  // namespace feeler_oracle
