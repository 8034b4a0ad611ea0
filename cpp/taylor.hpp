// Truncated power series with enclosed coefficients, for functions that are no polynomials.
//
// In doubles an overflow could hide (the product of 0 and infinity is lost in a minimum): each
// result is checked, and std::range_error is thrown where one is not finite.
#pragma once

#include <cmath>
#include <stdexcept>
#include <vector>

#include "interval.hpp"
#include "interval_trig.hpp"

namespace feeler_oracle {

// Coefficient k of sigma^k, for k = 0..order.
template <class T>
using Series = std::vector<T>;

inline void check(const Interval64& x) {
    if (!(std::isfinite(x.lo) && std::isfinite(x.hi) && x.lo <= x.hi))
        throw std::range_error("a series out of range");
}
inline void check(const Interval& x) {
    if (!mpfr_number_p(x.lo.get()) || !mpfr_number_p(x.hi.get()))
        throw std::range_error("a series out of range");
}
inline bool is_positive(const Interval64& x) { return x.lo > 0; }
inline bool is_positive(const Interval& x) { return x.lo.sign() > 0; }

template <class T>
Series<T> scale(const T& x, const Series<T>& a) {
    Series<T> r(a.size());
    for (std::size_t k = 0; k < a.size(); ++k) check(r[k] = x * a[k]);
    return r;
}

template <class T>
Series<T> multiply(const Series<T>& a, const Series<T>& b) {
    Series<T> r(a.size(), T(0.0));
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; i + j < a.size(); ++j) r[i + j] = r[i + j] + a[i] * b[j];
    for (const T& x : r) check(x);
    return r;
}

// a / b, from a = q b, q_k = (a_k - sum_{j > 0} b_j q_{k-j}) / b_0. Throws std::range_error
// unless b_0 > 0.
template <class T>
Series<T> divide(const Series<T>& a, const Series<T>& b) {
    if (!is_positive(b[0])) throw std::range_error("a divisor that may be zero");
    Series<T> q(a.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
        T x = a[k];
        for (std::size_t j = 1; j <= k; ++j) x = x - b[j] * q[k - j];
        check(q[k] = divide_positive(x, b[0]));
    }
    return q;
}

inline CosSin start_of(const Interval& angle) { return cos_sin(angle); }
struct CosSin64 {
    Interval64 cos, sin;
};
inline CosSin64 start_of(const Interval64& angle) {
    const CosSin x = cos_sin(Interval(Real(angle.lo), Real(angle.hi)));
    return {x.cos.outer(), x.sin.outer()};
}

// The sine of a series: s' = a' c, c' = -a' s, coefficient by coefficient.
template <class T>
Series<T> sine(const Series<T>& a) {
    Series<T> s(a.size()), c(a.size());
    const auto start = start_of(a[0]);
    s[0] = start.sin;
    c[0] = start.cos;
    for (std::size_t k = 1; k < a.size(); ++k) {
        T x(0.0), y(0.0);
        for (std::size_t j = 1; j <= k; ++j) {
            const T slope = T(double(j)) * a[j];
            x = x + slope * c[k - j];
            y = y - slope * s[k - j];
        }
        check(s[k] = divide_positive(x, T(double(k))));
        check(c[k] = divide_positive(y, T(double(k))));
    }
    return s;
}

}  // namespace feeler_oracle
