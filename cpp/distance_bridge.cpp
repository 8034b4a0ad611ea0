// The entries of bridge.hpp for distances.
#include <cmath>
#include <stdexcept>

#include "bridge.hpp"
#include "distance.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"
#include "on_plane.hpp"

namespace feeler_oracle {
namespace {

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
        budget.nodes = double(nodes);
        budget.nodes64 = 10 * double(nodes);
    }
    return budget;
}

}  // namespace

RawDistance distance_to(const Core& core, double x, double y, double z, std::int64_t nodes) {
    return guarded([&] {
        check_query({x, y, z});
        DistanceAnswer answer = distance(core.pieces(), {x, y, z}, budget_of(nodes));
        // Where 0 is possible, it may be exact.
        const int face = answer.lo.sign() == 0 ? planar_face_at(core, {x, y, z}) : -1;
        if (face >= 0) {
            answer.hi = Real(0.0);
            answer.face = face;
        }
        return to_raw(answer);
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
