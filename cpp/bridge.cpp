#include "bridge.hpp"

#include <CGAL/assertions_behaviour.h>
#include <mpfr.h>

#include <cmath>
#include <string>

#include "distance_pieces.hpp"
#include "edge_width.hpp"
#include "evaluate.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"

namespace feeler_oracle {

namespace {

// MPFR keeps constants and integers for each thread, which do not end with it unless it is told.
struct MpfrCaches {
    MpfrCaches() = default;
    ~MpfrCaches() { mpfr_free_cache(); }
    MpfrCaches(const MpfrCaches&) = delete;
    MpfrCaches& operator=(const MpfrCaches&) = delete;
};

}  // namespace

void silence_cgal() {
    // Every call from Rust passes here, so that every thread that may fill the caches has one.
    static thread_local const MpfrCaches caches;
    (void)caches;
    // Once for all threads: CGAL keeps its handlers in globals without a lock.
    static const bool silenced = [] {
        // Failed assertions of CGAL throw; without a handler they would print first.
        const auto quiet = [](const char*, const char*, const char*, int, const char*) {};
        CGAL::set_error_handler(quiet);
        CGAL::set_warning_handler(quiet);
        CGAL::set_error_behaviour(CGAL::THROW_EXCEPTION);
        return true;
    }();
    (void)silenced;
}

namespace {

void check_finite(double x) {
    if (!std::isfinite(x)) throw std::invalid_argument("the query is not finite");
}

}  // namespace

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

void prepare(const Core& core, std::uint8_t what, std::size_t face) {
    guarded([&] {
        if (what == 0) {
            core.face(face);
            return;
        }
        const Pieces& pieces = core.pieces();
        for (std::size_t f = 0; f < pieces.count(); ++f) {
            core.face(f);
            if (!pieces.nothing(f)) pieces.face(f);
        }
        if (what == 1) return;
        const Edges& edges = core.edges();
        for (std::size_t e = 0; e < edges.images().uses.size(); ++e) edges.rough(int(e));
    });
}

RawEvaluation evaluate_face(const Core& core, std::size_t face, double u, double v, bool below_u,
                            bool below_v) {
    return guarded([&] {
        check_finite(u);
        check_finite(v);
        const Surface& surface = core.model().faces.at(face).surface;
        const auto domain = surface_domain(surface);
        if (Q(u) < domain[0] || Q(u) > domain[1] || Q(v) < domain[2] || Q(v) > domain[3])
            throw std::invalid_argument("the point is outside the surface's domain");
        const auto limit = [](bool below) { return below ? Limit::FromBelow : Limit::FromAbove; };
        const auto e = enclose_evaluation(surface, Q(u), Q(v), limit(below_u), limit(below_v));
        RawEvaluation raw;
        for (const auto* vector : {&e.point, &e.du, &e.dv, &e.duu, &e.duv, &e.dvv})
            for (const Interval& x : *vector)
                raw.numbers.push_back({to_dyadic(x.lo, MPFR_RNDD), to_dyadic(x.hi, MPFR_RNDU)});
        return raw;
    });
}

RawSide side_of(const Core& core, std::size_t face, double u, double v) {
    return guarded([&] {
        check_finite(u);
        check_finite(v);
        const Region& region = core.face(face).region;
        return RawSide{std::uint8_t(side(region, Q(u), Q(v))), in_gap(region, Q(u), Q(v))};
    });
}

void set_rounding_upward(bool upward) { std::fesetround(upward ? FE_UPWARD : FE_TONEAREST); }

}  // namespace feeler_oracle
