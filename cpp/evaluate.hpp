// A surface point and its derivatives up to the second: exactly where the surface is rational,
// enclosed where sines, cosines and roots come in.
#pragma once

#include "interval.hpp"
#include "model.hpp"

namespace feeler_oracle {

// Which span a parameter on a knot or joint belongs to, and so from which side derivatives are
// taken there: [t_i, t_i+1), the last one closed, or (t_i, t_i+1], the first one closed.
enum class Limit { FromAbove, FromBelow };

template <class N>
struct Partials {
    std::array<N, 3> point, du, dv, duu, duv, dvv;
};

// Precondition: is_rational(surface), (u, v) in its domain.
Partials<Q> evaluate(const Surface& surface, const Q& u, const Q& v,
                     Limit along_u = Limit::FromAbove, Limit along_v = Limit::FromAbove);

// Of any surface, (u, v) in its domain. Rational surfaces are evaluated exactly and rounded last.
// Else the frames, and what the angle is applied to, are rational up to the roots that normalise
// the axes; each number is computed by some thirty operations on kBits-bit intervals from exact
// vectors no larger than the model, and so is wider than 2^-300 of the model's size nowhere.
Partials<Interval> enclose_evaluation(const Surface& surface, const Q& u, const Q& v,
                                      Limit along_u = Limit::FromAbove,
                                      Limit along_v = Limit::FromAbove);

}  // namespace feeler_oracle
