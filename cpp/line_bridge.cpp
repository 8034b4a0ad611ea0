// The entries of bridge.hpp for lines and the side of a point in space.
#include <cmath>
#include <stdexcept>

#include "bridge.hpp"
#include "edge_line.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"
#include "inside.hpp"
#include "line.hpp"

namespace feeler_oracle {
namespace {

RawEnclosure to_raw(const Interval& x) {
    return {to_dyadic(x.lo, MPFR_RNDD), to_dyadic(x.hi, MPFR_RNDU)};
}

std::array<double, 3> to_array(rust::Slice<const double> s) {
    if (s.size() != 3) throw std::logic_error("a vector has three numbers");
    for (double x : s)
        if (!std::isfinite(x)) throw std::invalid_argument("the query is not finite");
    return {s[0], s[1], s[2]};
}

}  // namespace

RawLine line_truth(const Core& core, rust::Slice<const double> origin,
                   rust::Slice<const double> direction, std::uint8_t kind) {
    return guarded([&] {
        const Line line{to_array(origin), to_array(direction), LineKind(kind)};
        if (line.direction == std::array<double, 3>{0, 0, 0})
            throw std::invalid_argument("the direction is zero");
        const LineAnswer answer = line_hits(core, line);
        RawLine raw;
        const LineCrossings found = line_crossings(core, line, answer);
        raw.crossings = found.crossings;
        raw.in_crack = found.in_crack;
        for (const auto& h : answer.hits)
            raw.hits.push_back({std::size_t(h.face), to_raw(h.t), h.lies_in,
                                to_raw(h.lies_in ? h.t_end : h.t), h.boundary,
                                std::uint32_t(h.multiplicity), h.transversal, h.tangential, h.uv[0],
                                h.uv[1]});
        for (const auto& o : answer.open)
            raw.open.push_back({std::size_t(o.face), to_raw(o.t), o.why});
        return raw;
    });
}

RawInside inside_of(const Core& core, double x, double y, double z, std::int32_t rays) {
    return guarded([&] {
        for (double c : {x, y, z})
            if (!std::isfinite(c)) throw std::invalid_argument("the query is not finite");
        const InsideAnswer answer = inside(core, {x, y, z}, rays);
        return RawInside{std::uint8_t(answer.kind), answer.why};
    });
}

}  // namespace feeler_oracle
