#include "bridge.hpp"
#include "derivative_roots.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"

namespace feeler_oracle {
namespace {

// Of each piece's parameter: what is stored has 160 bits or more.
constexpr int kRootBits = 168;

// The number itself where it is dyadic, else one outward within 2^-(kTruthBits) of it.
RawDyadic exact_or_rounded(const Q& x, mpfr_rnd_t direction) {
    mpz_t m;
    mpz_init_set(m, mpq_numref(x.mpq()));
    const mp_bitcnt_t shift = mpz_scan1(mpq_denref(x.mpq()), 0);
    std::int64_t exponent = -std::int64_t(shift);
    if (mpz_sizeinbase(mpq_denref(x.mpq()), 2) != shift + 1) {
        // No power of two: m = floor or ceiling of x 2^bits, as fine as kTruthBits of x.
        const std::int64_t size = std::int64_t(mpz_sizeinbase(mpq_numref(x.mpq()), 2)) -
                                  std::int64_t(mpz_sizeinbase(mpq_denref(x.mpq()), 2));
        const std::int64_t bits = std::max<std::int64_t>(0, kTruthBits - size);
        mpz_mul_2exp(m, m, mp_bitcnt_t(bits));
        if (direction == MPFR_RNDD)
            mpz_fdiv_q(m, m, mpq_denref(x.mpq()));
        else
            mpz_cdiv_q(m, m, mpq_denref(x.mpq()));
        exponent = -bits;
    }
    RawDyadic d{"0", 0};
    if (mpz_sgn(m) != 0) {
        std::string text(mpz_sizeinbase(m, 16) + 2, '\0');
        mpz_get_str(text.data(), 16, m);
        text.resize(text.find('\0'));
        d.mantissa = text;
        d.exponent = exponent;
    }
    mpz_clear(m);
    return d;
}

RawEnclosure between(const Q& lo, const Q& hi) {
    return {exact_or_rounded(lo, MPFR_RNDD), exact_or_rounded(hi, MPFR_RNDU)};
}

RawAxisRoots raw(const AxisRoots& axis) {
    RawAxisRoots out;
    for (const DerivativeRoot& r : axis.roots)
        out.roots.push_back({between(r.lo, r.hi),
                             {std::uint32_t(r.multiplicity[0]), std::uint32_t(r.multiplicity[1])},
                             {std::int8_t(r.sign[0]), std::int8_t(r.sign[1])},
                             r.cusp});
    for (const auto& [a, b] : axis.constant) out.constant.push_back({between(a, a), between(b, b)});
    return out;
}

}  // namespace

RawDerivativeRoots derivative_roots_of(const Core& core, std::size_t face, std::size_t loop,
                                       std::size_t trim) {
    return guarded([&] {
        const auto& loops = core.model().faces.at(face).loops;
        if (!loops || loop >= loops->size()) throw std::out_of_range("there is no such loop");
        const auto& trims = (*loops)[loop].trims;
        if (trim >= trims.size()) throw std::out_of_range("there is no such trim");
        const auto axes = derivative_roots(trims[trim], kRootBits);
        return RawDerivativeRoots{raw(axes[0]), raw(axes[1])};
    });
}

}  // namespace feeler_oracle
