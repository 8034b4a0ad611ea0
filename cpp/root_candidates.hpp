// Candidates for the real roots of a polynomial in [0, 1]: eigenvalues, in doubles, by Eigen.
//
// The polynomial is sampled at Chebyshev points, which gives its coefficients c_k in Chebyshev
// polynomials T_k of 2t - 1; where c_m is the last that is not noise, its roots are the eigenvalues
// of the colleague matrix: multiplication by 2t - 1 in the basis T_0 .. T_(m-1), with T_m = -sum
// c_k / c_m T_k (I. J. Good, "The colleague matrix, a Chebyshev analogue of the companion matrix",
// 1961). Nothing is proven: who uses a candidate looks for a change of sign about it.
#pragma once

#include <vector>

namespace feeler_oracle {

// Of the polynomial with these Bernstein coefficients, ascending; the eigenvalues near [0, 1],
// moved into it. None where a coefficient is not finite. O(n^3): 0.1 ms at degree 10, 1 ms at 48.
std::vector<double> root_candidates(const std::vector<double>& bernstein);

}  // namespace feeler_oracle
