#include "contact_foot.hpp"

#include <algorithm>

#include "contact_candidates.hpp"

namespace feeler_oracle {

std::optional<std::array<double, 6>> foot_box(const Pieces& model, const Objective& objective,
                                              double limit, long nodes) {
    const AllPieces all(model);
    const double bound = objective.linear ? limit : next_up(limit * limit);
    const Candidates found = candidates(all, objective, bound, nodes);
    if (!found.whole || found.all.empty()) return std::nullopt;
    // The minimum is no more than the bound, nor than any value that is attained.
    Real least(bound);
    for (const Candidate& c : found.all)
        if (c.hi < least) least = c.hi;
    std::optional<std::array<double, 6>> box;
    for (const Candidate& c : found.all) {
        if (least < c.lo) continue;
        if (!box) box = c.box;
        for (int k = 0; k < 3; ++k) {
            (*box)[2 * k] = std::min((*box)[2 * k], c.box[2 * k]);
            (*box)[2 * k + 1] = std::max((*box)[2 * k + 1], c.box[2 * k + 1]);
        }
    }
    // Contacts nearer to each other count as one.
    constexpr double kOne = 0x1p-24;
    if (!box || !(most_apart(*box, *box) <= kOne * all.size)) return std::nullopt;
    return box;
}

}  // namespace feeler_oracle
