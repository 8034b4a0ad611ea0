// The entry of bridge.hpp for contacts.
#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>

#include "bridge.hpp"
#include "contacts.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"

namespace feeler_oracle {

namespace {

// A sum or a revolution may jump where its poly-curves do, and ways take faces to be continuous.
void refuse_native(const Core& core) {
    const auto& faces = core.model().faces;
    for (std::size_t f = 0; f < faces.size(); ++f)
        if (!std::holds_alternative<NurbsSurface>(faces[f].surface) &&
            !std::holds_alternative<Plane>(faces[f].surface))
            throw std::invalid_argument("contacts: face " + std::to_string(f) +
                                        " is a revolution or a sum: not served yet");
}

}  // namespace

RawContacts contacts_of(const Core& core, bool linear, rust::Slice<const double> at, double h,
                        double limit, double join) {
    return guarded([&] {
        if (at.size() != 3) throw std::invalid_argument("three numbers are needed");
        for (double c : {at[0], at[1], at[2], h, limit, join}) {
            if (!std::isfinite(c)) throw std::invalid_argument("the query is not finite");
            if (std::fabs(c) > kLargest) throw std::invalid_argument("the query is out of range");
        }
        refuse_native(core);
        RawContacts r{{}, 0, true, 0};
        if (!(join > 0)) throw std::invalid_argument("no length");
        if (!linear && limit < 0) return r;
        const Contacts found =
            contacts(core.pieces(), {linear, {at[0], at[1], at[2]}, h}, limit, join);
        r.join = found.join;
        r.whole = found.whole;
        r.nodes = std::uint64_t(found.nodes);
        for (const auto& e : found.entries) {
            const bool held = mpfr_number_p(e.hi.get());
            r.entries.push_back(
                {{to_dyadic(e.lo, MPFR_RNDD), to_dyadic(held ? e.hi : e.lo, MPFR_RNDU)},
                 held,
                 e.box,
                 e.minimum,
                 e.continuum,
                 e.face});
        }
        return r;
    });
}

double join_width(const Core& core) {
    return guarded([&] {
        refuse_native(core);
        return join_of(core);
    });
}

}  // namespace feeler_oracle
