// The entries of bridge.hpp for edges.
#include <stdexcept>

#include "bridge.hpp"
#include "edge_width.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"

namespace feeler_oracle {

RawCrack crack_of(const Core& core, std::size_t edge) {
    return guarded([&] {
        if (edge >= std::size_t(core.model().edges)) throw std::out_of_range("no such edge");
        const auto& edges = core.edges();
        const bool shared = edges.images().uses[edge].size() > 1;
        const CrackWidth& w = edges.width(int(edge));
        return RawCrack{{to_dyadic(w.d.lo, MPFR_RNDD), to_dyadic(w.d.hi, MPFR_RNDU)},
                        shared,
                        w.known,
                        std::uint32_t(w.cuts)};
    });
}

}  // namespace feeler_oracle
