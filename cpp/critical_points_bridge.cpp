#include "bridge.hpp"
#include "critical_points.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"

namespace feeler_oracle {

RawCriticalPoints critical_points_of(std::size_t p, std::size_t q, rust::Slice<const double> net,
                                     const std::array<double, 3>& point) {
    return guarded([&] {
        const CriticalPoints found =
            critical_points(int(p), int(q), {net.begin(), net.end()}, point);
        RawCriticalPoints raw{found.all, {}};
        for (const CriticalPoint& c : found.points)
            raw.points.push_back(
                {{to_dyadic(c.distance.lo, MPFR_RNDD), to_dyadic(c.distance.hi, MPFR_RNDU)},
                 {c.at[0].lo, c.at[0].hi, c.at[1].lo, c.at[1].hi, c.at[2].lo, c.at[2].hi},
                 std::uint8_t(c.kind),
                 c.inner});
        return raw;
    });
}

}  // namespace feeler_oracle
