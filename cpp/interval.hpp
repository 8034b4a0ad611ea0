// Intervals of two kinds: doubles, and binary numbers of kBits bits on top of MPFR.
//
// Both contain the exact result of every operation on points of their operands. Neither depends on
// the rounding mode in force, and neither changes it:
// - Interval64 works in round to nearest and widens each result outwards by the formula of
//   S. M. Rump, P. Zimmermann, S. Boldo, G. Melquiond, "Computing predecessor and successor in
//   rounding to nearest", BIT 49 (2009): for finite c, fl(c - fl(phi |c| + eta)) <= pred(c) with
//   phi = 2^-53 (1 + 2^-52), eta = 2^-1074. The entry points restore round to nearest before use.
// - Interval (MPFR) rounds each end in its own direction by MPFR's integer arithmetic. Its limbs
// lie
//   inside the object (mpfr_custom_init_set): a net of them is one allocation, and an operation
//   takes about a third of MPFI's time. MPFR's exponent range is not left by the sizes the bridge
//   admits, so no underflow is met; directed rounding would keep it sound anyway.
#pragma once

#include <gmp.h>
#include <mpfr.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace feeler_oracle {

// ---- doubles

inline double next_up(double x) {
    constexpr double kPhi = 0x1.0000000000001p-53;
    return x + (kPhi * std::fabs(x) + std::numeric_limits<double>::denorm_min());
}
inline double next_down(double x) { return -next_up(-x); }

struct Interval64 {
    double lo = 0, hi = 0;
    Interval64() = default;
    Interval64(double x) : lo(x), hi(x) {}
    Interval64(double l, double h) : lo(l), hi(h) {}
};
inline Interval64 operator+(const Interval64& a, const Interval64& b) {
    return {next_down(a.lo + b.lo), next_up(a.hi + b.hi)};
}
inline Interval64 operator-(const Interval64& a) { return {-a.hi, -a.lo}; }
inline Interval64 operator-(const Interval64& a, const Interval64& b) { return a + (-b); }
inline Interval64 operator*(const Interval64& a, const Interval64& b) {
    const double x = a.lo * b.lo, y = a.lo * b.hi, z = a.hi * b.lo, t = a.hi * b.hi;
    return {next_down(std::min(std::min(x, y), std::min(z, t))),
            next_up(std::max(std::max(x, y), std::max(z, t)))};
}

// b > 0.
inline Interval64 divide_positive(const Interval64& a, const Interval64& b) {
    return {next_down(a.lo / (a.lo >= 0 ? b.hi : b.lo)), next_up(a.hi / (a.hi >= 0 ? b.lo : b.hi))};
}

// ---- MPFR

constexpr int kLimbs = 5;
constexpr mpfr_prec_t kBits = 64 * kLimbs;
static_assert(GMP_NUMB_BITS == 64, "limbs of 64 bits");

// A binary floating-point number of kBits bits. Copies are plain memory.
class Real {
 public:
    Real() {
        mpfr_custom_init(limbs_, kBits);
        mpfr_custom_init_set(&x_, MPFR_ZERO_KIND, 0, kBits, limbs_);
    }
    explicit Real(double d) : Real() { mpfr_set_d(&x_, d, MPFR_RNDN); }
    Real(const Real& o) { assign(o); }
    Real& operator=(const Real& o) {
        if (this != &o) assign(o);
        return *this;
    }
    mpfr_ptr get() { return &x_; }
    mpfr_srcptr get() const { return &x_; }
    int sign() const { return mpfr_sgn(&x_); }
    double down() const { return mpfr_get_d(&x_, MPFR_RNDD); }
    double up() const { return mpfr_get_d(&x_, MPFR_RNDU); }
    double near() const { return mpfr_get_d(&x_, MPFR_RNDN); }

 private:
    void assign(const Real& o) {
        std::memcpy(limbs_, o.limbs_, sizeof limbs_);
        x_ = o.x_;
        x_._mpfr_d = limbs_;
    }
    __mpfr_struct x_;
    mp_limb_t limbs_[kLimbs];
};
inline bool operator<(const Real& a, const Real& b) { return mpfr_less_p(a.get(), b.get()); }
inline bool operator<=(const Real& a, const Real& b) { return mpfr_lessequal_p(a.get(), b.get()); }

// Sums, products and quotients of Reals, rounded in the direction that is named.
#define FEELER_ROUNDED(name, op)                            \
    inline Real name##_down(const Real& a, const Real& b) { \
        Real r;                                             \
        op(r.get(), a.get(), b.get(), MPFR_RNDD);           \
        return r;                                           \
    }                                                       \
    inline Real name##_up(const Real& a, const Real& b) {   \
        Real r;                                             \
        op(r.get(), a.get(), b.get(), MPFR_RNDU);           \
        return r;                                           \
    }
FEELER_ROUNDED(add, mpfr_add)
FEELER_ROUNDED(sub, mpfr_sub)
FEELER_ROUNDED(mul, mpfr_mul)
FEELER_ROUNDED(div, mpfr_div)
#undef FEELER_ROUNDED

struct Interval {
    Real lo, hi;
    Interval() = default;
    Interval(double d) : lo(d), hi(d) {}
    Interval(const Real& l, const Real& h) : lo(l), hi(h) {}
    explicit Interval(const Real& x) : lo(x), hi(x) {}
    explicit Interval(mpq_srcptr q) {
        mpfr_set_q(lo.get(), q, MPFR_RNDD);
        mpfr_set_q(hi.get(), q, MPFR_RNDU);
    }
    Interval64 outer() const { return {lo.down(), hi.up()}; }
    Real middle() const {
        Real m;
        mpfr_add(m.get(), lo.get(), hi.get(), MPFR_RNDN);
        mpfr_div_2ui(m.get(), m.get(), 1, MPFR_RNDN);
        return m;
    }
    bool is_point() const { return mpfr_equal_p(lo.get(), hi.get()); }
};
inline Interval operator+(const Interval& a, const Interval& b) {
    Interval r;
    mpfr_add(r.lo.get(), a.lo.get(), b.lo.get(), MPFR_RNDD);
    mpfr_add(r.hi.get(), a.hi.get(), b.hi.get(), MPFR_RNDU);
    return r;
}
inline Interval operator-(const Interval& a, const Interval& b) {
    Interval r;
    mpfr_sub(r.lo.get(), a.lo.get(), b.hi.get(), MPFR_RNDD);
    mpfr_sub(r.hi.get(), a.hi.get(), b.lo.get(), MPFR_RNDU);
    return r;
}
inline Interval operator-(const Interval& a) {
    Interval r;
    mpfr_neg(r.lo.get(), a.hi.get(), MPFR_RNDD);
    mpfr_neg(r.hi.get(), a.lo.get(), MPFR_RNDU);
    return r;
}
inline Interval operator*(const Interval& a, const Interval& b) {
    Interval r;
    const auto set = [&r](const Real& l0, const Real& l1, const Real& h0, const Real& h1) {
        mpfr_mul(r.lo.get(), l0.get(), l1.get(), MPFR_RNDD);
        mpfr_mul(r.hi.get(), h0.get(), h1.get(), MPFR_RNDU);
    };
    if (a.lo.sign() >= 0) {
        if (b.lo.sign() >= 0) {
            set(a.lo, b.lo, a.hi, b.hi);
        } else if (b.hi.sign() <= 0) {
            set(a.hi, b.lo, a.lo, b.hi);
        } else {
            set(a.hi, b.lo, a.hi, b.hi);
        }
    } else if (a.hi.sign() <= 0) {
        if (b.lo.sign() >= 0) {
            set(a.lo, b.hi, a.hi, b.lo);
        } else if (b.hi.sign() <= 0) {
            set(a.hi, b.hi, a.lo, b.lo);
        } else {
            set(a.lo, b.hi, a.lo, b.lo);
        }
    } else if (b.lo.sign() >= 0) {
        set(a.lo, b.hi, a.hi, b.hi);
    } else if (b.hi.sign() <= 0) {
        set(a.hi, b.lo, a.lo, b.lo);
    } else {
        const Real x = mul_down(a.lo, b.hi), y = mul_down(a.hi, b.lo);
        const Real z = mul_up(a.lo, b.lo), t = mul_up(a.hi, b.hi);
        r.lo = x < y ? x : y;
        r.hi = z < t ? t : z;
    }
    return r;
}
inline Interval square(const Interval& a) {
    Interval r;
    const bool below = a.hi.sign() <= 0;
    if (a.lo.sign() >= 0 || below) {
        const Real& small = below ? a.hi : a.lo;
        const Real& large = below ? a.lo : a.hi;
        mpfr_sqr(r.lo.get(), small.get(), MPFR_RNDD);
        mpfr_sqr(r.hi.get(), large.get(), MPFR_RNDU);
        return r;
    }
    const Real x = mul_up(a.lo, a.lo), y = mul_up(a.hi, a.hi);
    r.hi = x < y ? y : x;
    return r;
}
// b > 0.
inline Interval divide_positive(const Interval& a, const Interval& b) {
    return {div_down(a.lo, a.lo.sign() >= 0 ? b.hi : b.lo),
            div_up(a.hi, a.hi.sign() >= 0 ? b.lo : b.hi)};
}
// (a + b) / 2
inline Interval average(const Interval& a, const Interval& b) {
    Interval r = a + b;
    mpfr_div_2ui(r.lo.get(), r.lo.get(), 1, MPFR_RNDD);
    mpfr_div_2ui(r.hi.get(), r.hi.get(), 1, MPFR_RNDU);
    return r;
}
inline Interval hull(const Interval& a, const Interval& b) {
    return {a.lo < b.lo ? a.lo : b.lo, a.hi < b.hi ? b.hi : a.hi};
}

}  // namespace feeler_oracle
