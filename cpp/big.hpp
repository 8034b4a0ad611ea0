// Intervals of a precision chosen at run time, for the few decisions that need more than the 320
// bits of Interval. A thin handle on MPFI: every operation contains the exact result, rounded
// outward to the larger of its operands' precisions, whatever the rounding mode in force.
#pragma once

#include <gmp.h>
#include <mpfr.h>
// After gmp.h.
#include <mpfi.h>

#include <utility>

#include "exact.hpp"
#include "interval.hpp"

namespace feeler_oracle {

class Big {
 public:
    explicit Big(long bits) { mpfi_init2(x_, mpfr_prec_t(bits)); }
    Big(const Q& q, long bits) : Big(bits) { mpfi_set_q(x_, q.mpq()); }
    Big(const Q& lo, const Q& hi, long bits) : Big(bits) {
        mpfr_set_q(&x_->left, lo.mpq(), MPFR_RNDD);
        mpfr_set_q(&x_->right, hi.mpq(), MPFR_RNDU);
    }
    Big(const Big& o) : Big(o.bits()) { mpfi_set(x_, o.x_); }
    Big(Big&& o) noexcept : Big(2) { mpfi_swap(x_, o.x_); }
    Big& operator=(Big o) noexcept {
        mpfi_swap(x_, o.x_);
        return *this;
    }
    ~Big() { mpfi_clear(x_); }

    long bits() const { return long(mpfi_get_prec(x_)); }
    mpfi_ptr get() { return x_; }
    mpfi_srcptr get() const { return x_; }
    // 1 or -1 where all of it is, else 0.
    int sign() const {
        if (mpfr_sgn(&x_->left) > 0) return 1;
        return mpfr_sgn(&x_->right) < 0 ? -1 : 0;
    }
    Q lo() const { return end(&x_->left); }
    Q hi() const { return end(&x_->right); }
    // Some point of it; a dyadic of its precision.
    Q middle() const {
        Big m(bits());
        mpfi_mid(&m.x_->left, x_);
        return end(&m.x_->left);
    }
    double width() const {
        mpfr_t w;
        mpfr_init2(w, 53);
        mpfi_diam_abs(w, x_);
        const double d = mpfr_get_d(w, MPFR_RNDU);
        mpfr_clear(w);
        return d;
    }
    // No less than the largest magnitude in it.
    double magnitude() const {
        return std::max(std::fabs(mpfr_get_d(&x_->left, MPFR_RNDD)),
                        std::fabs(mpfr_get_d(&x_->right, MPFR_RNDU)));
    }
    // No more than the least magnitude in it.
    double least_magnitude() const {
        if (sign() == 0) return 0;
        return sign() > 0 ? mpfr_get_d(&x_->left, MPFR_RNDD) : -mpfr_get_d(&x_->right, MPFR_RNDU);
    }
    // Whether all of it is within (-2^-n, 2^-n).
    bool below(long n) const {
        return mpfr_cmp_si_2exp(&x_->right, 1, -n) < 0 && mpfr_cmp_si_2exp(&x_->left, -1, -n) > 0;
    }

 private:
    static Q end(mpfr_srcptr x) {
        if (mpfr_zero_p(x)) return Q(0);
        mpq_t value;
        mpq_init(value);
        mpfr_get_q(value, x);
        Q result(value);
        mpq_clear(value);
        return result;
    }
    mpfi_t x_;
};

#define FEELER_BIG(op, f)                                 \
    inline Big operator op(const Big& a, const Big& b) {  \
        Big r(a.bits() < b.bits() ? b.bits() : a.bits()); \
        f(r.get(), a.get(), b.get());                     \
        return r;                                         \
    }
FEELER_BIG(+, mpfi_add)
FEELER_BIG(-, mpfi_sub)
FEELER_BIG(*, mpfi_mul)
// The divisor excludes 0.
FEELER_BIG(/, mpfi_div)
#undef FEELER_BIG

// What a and b have in common, where they have.
inline Big meet(const Big& a, const Big& b) {
    Big r(a.bits() < b.bits() ? b.bits() : a.bits());
    mpfi_intersect(r.get(), a.get(), b.get());
    return r;
}

}  // namespace feeler_oracle
