// The entry of bridge.hpp for contacts.
#include <cmath>
#include <stdexcept>

#include "bridge.hpp"
#include "contact_foot.hpp"
#include "contacts.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"

namespace feeler_oracle {

namespace {

void check_query(rust::Slice<const double> at, double h, double limit) {
    if (at.size() != 3) throw std::invalid_argument("three numbers are needed");
    for (double c : {at[0], at[1], at[2], h, limit}) {
        if (!std::isfinite(c)) throw std::invalid_argument("the query is not finite");
        if (std::fabs(c) > kLargest) throw std::invalid_argument("the query is out of range");
    }
}

}  // namespace

RawContacts contacts_of(const Core& core, bool linear, rust::Slice<const double> at, double h,
                        double limit, double join) {
    return guarded([&] {
        check_query(at, h, limit);
        RawContacts r{{}, 0, true, 0};
        if (!(join > 0 && join <= kLargest)) throw std::invalid_argument("no length");
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

rust::Vec<double> foot_of(const Core& core, bool linear, rust::Slice<const double> at, double h,
                          double limit) {
    return guarded([&] {
        check_query(at, h, limit);
        rust::Vec<double> r;
        if (!linear && limit < 0) return r;
        if (const auto box = foot_box(core.pieces(), {linear, {at[0], at[1], at[2]}, h}, limit))
            for (double x : *box) r.push_back(x);
        return r;
    });
}

double join_width(const Core& core) {
    return guarded([&] { return join_of(core); });
}

}  // namespace feeler_oracle
