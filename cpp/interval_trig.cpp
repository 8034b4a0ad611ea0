#include "interval_trig.hpp"

namespace feeler_oracle {

Interval square_root(const Interval& x) {
    Interval r;
    if (x.lo.sign() > 0) mpfr_sqrt(r.lo.get(), x.lo.get(), MPFR_RNDD);
    if (x.hi.sign() > 0) mpfr_sqrt(r.hi.get(), x.hi.get(), MPFR_RNDU);
    return r;
}

CosSin cos_sin(const Interval& angle) {
    CosSin r;
    mpfr_cos(r.cos.lo.get(), angle.lo.get(), MPFR_RNDD);
    mpfr_cos(r.cos.hi.get(), angle.lo.get(), MPFR_RNDU);
    mpfr_sin(r.sin.lo.get(), angle.lo.get(), MPFR_RNDD);
    mpfr_sin(r.sin.hi.get(), angle.lo.get(), MPFR_RNDU);
    if (angle.is_point()) return r;
    const Real width = sub_up(angle.hi, angle.lo), one(1.0), minus_one(-1.0);
    for (Interval* x : {&r.cos, &r.sin}) {
        x->lo = sub_down(x->lo, width);
        x->hi = add_up(x->hi, width);
        if (x->lo < minus_one) x->lo = minus_one;
        if (one < x->hi) x->hi = one;
    }
    return r;
}

Interval angle_of(const Interval& x, const Interval& y) {
    Interval r;
    mpfr_atan2(r.lo.get(), y.lo.get(), x.hi.get(), MPFR_RNDD);
    mpfr_atan2(r.hi.get(), y.hi.get(), x.lo.get(), MPFR_RNDU);
    return r;
}

}  // namespace feeler_oracle
