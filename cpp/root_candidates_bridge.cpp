#include "bridge.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"
#include "root_candidates.hpp"

namespace feeler_oracle {

rust::Vec<double> eigen_candidates(rust::Slice<const double> bernstein) {
    return guarded([&] {
        rust::Vec<double> out;
        for (double x : root_candidates({bernstein.begin(), bernstein.end()})) out.push_back(x);
        return out;
    });
}

}  // namespace feeler_oracle
