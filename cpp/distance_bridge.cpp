// The entries of bridge.hpp for distances.
#include <cmath>
#include <stdexcept>

#include "bridge.hpp"
#include "distance.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"

namespace feeler_oracle {
namespace {

// As for the other entries: more than the 160 significant bits of the truth.
constexpr mpfr_prec_t kTruthBits = 192;

RawDyadic to_dyadic(const Real& x, mpfr_rnd_t direction) {
    mpfr_t r;
    mpfr_init2(r, kTruthBits);
    mpfr_set(r, x.get(), direction);
    RawDyadic d{"0", 0};
    if (mpfr_regular_p(r)) {
        mpz_t m;
        mpz_init(m);
        d.exponent = mpfr_get_z_2exp(m, r);
        const mp_bitcnt_t zeros = mpz_scan1(m, 0);
        mpz_tdiv_q_2exp(m, m, zeros);
        d.exponent += std::int64_t(zeros);
        std::string text(mpz_sizeinbase(m, 16) + 2, '\0');
        mpz_get_str(text.data(), 16, m);
        text.resize(text.find('\0'));
        d.mantissa = text;
        mpz_clear(m);
    }
    mpfr_clear(r);
    return d;
}

RawDistance to_raw(const DistanceAnswer& a) {
    return {{to_dyadic(a.lo, MPFR_RNDD), to_dyadic(a.hi, MPFR_RNDU)},
            mpfr_number_p(a.lo.get()) && mpfr_number_p(a.hi.get()),
            std::uint8_t(a.status),
            a.face,
            std::uint64_t(a.nodes64),
            std::uint64_t(a.nodes)};
}

void check_query(std::initializer_list<double> numbers) {
    for (double x : numbers) {
        if (!std::isfinite(x)) throw std::invalid_argument("the query is not finite");
        if (std::fabs(x) > kLargest) throw std::invalid_argument("the query is out of range");
    }
}

DistanceBudget budget_of(std::int64_t nodes) {
    DistanceBudget budget;
    if (nodes >= 0) {
        budget.nodes = long(nodes);
        budget.nodes64 = 10 * long(nodes);
    }
    return budget;
}

}  // namespace

RawDistance distance_to(const Core& core, double x, double y, double z, std::int64_t nodes) {
    return guarded([&] {
        check_query({x, y, z});
        return to_raw(distance(core.pieces(), {x, y, z}, budget_of(nodes)));
    });
}

RawDistance support_of(const Core& core, double x, double y, double z, double h,
                       std::int64_t nodes) {
    return guarded([&] {
        check_query({x, y, z, h});
        return to_raw(support(core.pieces(), {x, y, z}, h, budget_of(nodes)));
    });
}

}  // namespace feeler_oracle
