// Roots of polynomials along a piece of an algebraic curve, with their multiplicities, exactly.
//
// On a box where A_x has one sign, and where A has opposite signs on the sides x = least and
// x = greatest, the curve A = 0 is the graph of a function x(y) over all of the box's y. Along it
// dP/dy = D P / A_x with D P = A_x P_y - A_y P_x. So with J_0 = F, J_(k+1) = D J_k:
// where J_m has no zero in the box, J_(m-1) is strictly monotone along the arc, and between two
// neighbouring roots of J_(k+1) (or ends of the arc) J_k is so too (Rolle). Signs at these places
// then tell all roots of J_k, from k = m - 1 down to 0. A root of J_k that is none of J_(k+1) is
// simple, one that is both has one more than its multiplicity in J_(k+1), and the multiplicity in
// J_0 is that of the common root of A and F, as A is smooth there.
//
// Whether J_j vanishes at a root r of J_k, j < k, is decided exactly. r is a common zero of
// A and J_k, isolated since these are proven coprime, with integer coefficients; so
// J_j(r) is an algebraic number of degree d <= N, N the bihomogeneous Bezout number of A and J_k,
// and by Liouville's inequality, if it is not 0,
//   log |J_j(r)| >= -d h(J_j(r)) >= -(deg_x J_j d h(x) + deg_y J_j d h(y) + d log L(J_j)),
// h the absolute logarithmic height, L the sum of the coefficients' magnitudes (M. Waldschmidt,
// "Diophantine approximation on linear algebraic groups", 2000, lemma 3.7 and (3.14)). x is a root
// of R = Res_y(A, J_k), with at least the multiplicity [Q(x, y) : Q(x)], so that d h(x) is at most
// the logarithm of R's Mahler measure, and that is at most max |R| over |x| = 1, by Hadamard's
// inequality at most deg_y(J_k) log L(A) + deg_y(A) log L(J_k). For y likewise. Less than that
// bound in magnitude is 0. Mostly a sign is found, or a rational point guessed and proven, long
// before so many digits are needed.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "bipoly.hpp"

namespace feeler_oracle {

// x and y boxes of a root, and more.
struct ArcRoot {
    Q x0, x1, y0, y1;
    Q unique_y0, unique_y1;  // over the arc's x, the only root between them
    int multiplicity = 1;
    // The sign of D^n F, n the multiplicity.
    int sign = 0;
};

struct ArcRoots {
    Q x0, x1, y0, y1;  // all common roots of A and F in this box are listed
    std::vector<ArcRoot> roots;
};

// D^k F for k = 0, 1, ..., made on first use.
class Tower {
 public:
    Tower(BiPoly a, BiPoly f);
    const BiPoly& a() const { return a_; }
    const BiPoly& a_x() const { return a_x_; }
    const BiPoly& a_y() const { return a_y_; }
    const BiPoly& level(int k) const;
    // Newton's step from (x, y) to a common root of A and J_k; nothing where it has none.
    std::optional<std::array<Q, 2>> newton(int k, const Q& x, const Q& y) const;
    // Newton's step from (x, y) to the curve along x; likewise.
    std::optional<std::array<Q, 2>> to_curve(const Q& x, const Q& y) const;
    // Whether A and J_k are proven coprime.
    bool coprime_with(int k) const;
    // Whether J_1 vanishes wherever A does, so that F is constant along the curve.
    bool constant() const;
    // What signs of more than a few digits have taken so far, in boxes of a search, about.
    mutable long work = 0;

 private:
    BiPoly a_, a_x_, a_y_;
    mutable std::vector<BiPoly> levels_;
    mutable std::vector<int> coprime_;  // -1: not known yet
    mutable int constant_ = -1;
};

// The largest m that is tried.
constexpr int kMostLevels = 5;

// All common roots of A and F in some box about (x, y), at most of half sizes (size_x, size_y): a
// point near the curve where for m >= 2 J_(m-1) is about 0. m = 0 where F is constant along the
// curve: then one sign tells. Nothing where no certificate is found.
std::optional<ArcRoots> arc_roots(const Tower& tower, int m, const Q& x, const Q& y, double size_x,
                                  double size_y);

}  // namespace feeler_oracle
