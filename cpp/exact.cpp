#include "exact.hpp"

#include <mpfr.h>

namespace feeler_oracle {

std::pair<double, double> double_bounds(const Q& x) {
    // A double is an MPFR number of 53 bits; mpfr_get_d rounds as told, whatever the mode of the
    // FPU, subnormal results included. Rounding twice in the same direction stays outward.
    mpfr_t r;
    mpfr_init2(r, 64);
    mpfr_set_q(r, x.mpq(), MPFR_RNDD);
    const double lo = mpfr_get_d(r, MPFR_RNDD);
    mpfr_set_q(r, x.mpq(), MPFR_RNDU);
    const double hi = mpfr_get_d(r, MPFR_RNDU);
    mpfr_clear(r);
    return {lo, hi};
}

void halve(const std::vector<Q>& b, std::vector<Q>& left, std::vector<Q>& right) {
    const std::size_t n = b.size();
    const Q half(1, 2);
    right = b;
    left.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
        left[k] = right[0];
        for (std::size_t i = 0; i + 1 < n - k; ++i) right[i] = (right[i] + right[i + 1]) * half;
    }
}

}  // namespace feeler_oracle
