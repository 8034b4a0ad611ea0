#include "contacts.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

#include "contact_candidates.hpp"
#include "contact_ways.hpp"
#include "core.hpp"
#include "edge_width.hpp"

namespace feeler_oracle {

namespace {

// Contacts nearer to each other than this part of the size count as one.
constexpr double kOne = 0x1p-24;
// Entries longer than this part of the size are continua.
constexpr double kContinuum = 0x1p-30;
// `join`, in widths of the widest crack: the jump itself, and as much again for what a path rises
// next to it and for boxes.
constexpr double kJoinOfWidth = 4;
// A crack wider than this part of the size is a hole.
constexpr double kHole = 0x1p-12;
// Points nearer to each other than this part of the size count as joined in any case.
constexpr double kJoin = 0x1p-44;

class Search {
 public:
    Search(const AllPieces& model, const Objective& o, double limit, double join,
           const ContactBudget& budget)
        : model_(model),
          o_(o),
          join_(join),
          bound_(o.linear ? limit : next_up(limit * limit)),
          budget_(budget),
          ways_(model, o, join, budget.ways) {}

    Contacts run() {
        Candidates found = candidates(model_, o_, bound_, budget_.nodes);
        candidates_ = std::move(found.all);
        falls_ = std::move(found.falls);
        out_.join = join_;
        out_.whole = found.whole;
        out_.nodes = found.nodes;
        drop_fallen();
        make_entries();
        return std::move(out_);
    }

 private:
    // From the points of a candidate within a jump of an end from which f falls along a trim or
    // joint, a way leads down. Candidates whose box is no longer than a jump alone.
    void drop_fallen() {
        std::sort(falls_.begin(), falls_.end(),
                  [](const Fall& a, const Fall& b) { return a.box[0] < b.box[0]; });
        const auto fallen = [&](const Candidate& c) {
            if (c.inner) return false;
            const double from = c.box[0] - 2 * join_;
            auto i = std::lower_bound(falls_.begin(), falls_.end(), from,
                                      [](const Fall& a, double x) { return a.box[0] < x; });
            for (; i != falls_.end() && i->box[0] <= c.box[1] + join_; ++i)
                if (i->depth > 3 * join_ && most_apart(i->box, c.box) <= 0.999 * join_) return true;
            return false;
        };
        candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), fallen),
                          candidates_.end());
    }

    // Candidates nearer than a jump to each other, directly or through others.
    std::vector<std::vector<int>> groups() const {
        const int n = int(candidates_.size());
        std::vector<int> order(n), parent(n);
        std::iota(order.begin(), order.end(), 0);
        std::iota(parent.begin(), parent.end(), 0);
        std::sort(order.begin(), order.end(),
                  [&](int a, int b) { return candidates_[a].box[0] < candidates_[b].box[0]; });
        const auto root = [&](int i) {
            while (parent[i] != i) i = parent[i] = parent[parent[i]];
            return i;
        };
        std::vector<int> active;
        for (int i : order) {
            const auto& box = candidates_[i].box;
            size_t kept = 0;
            for (int j : active) {
                if (candidates_[j].box[1] < box[0] - 2 * join_) continue;
                active[kept++] = j;
                if (root(i) != root(j) && least_apart(box, candidates_[j].box) <= join_)
                    parent[root(i)] = root(j);
            }
            active.resize(kept);
            active.push_back(i);
        }
        std::vector<std::vector<int>> r;
        std::vector<int> index(n, -1);
        for (int i = 0; i < n; ++i) {
            int& k = index[root(i)];
            if (k < 0) k = int(r.size()), r.emplace_back();
            r[k].push_back(i);
        }
        return r;
    }

    bool leads_down(const std::vector<int>& group, const ContactEntry& e) {
        // A group that is longer than a jump cannot be within one of a point.
        if (most_apart(e.box, e.box) > 0.5 * join_) return false;
        for (int i : group)
            if (candidates_[i].inner) return false;
        const double lo = rooted_down(o_, e.lo.down());
        int tried = 0;
        constexpr int kMost = 32;
        const auto along = [&](const Place& at) {
            if (at.face < 0) return false;
            if (++tried > kMost) return false;
            if (ways_.falls(at, e.box, lo)) return true;
            for (const Place& p : ways_.partners(at))
                if (ways_.falls(p, e.box, lo)) return true;
            return false;
        };
        for (int i : group) {
            const Candidate& c = candidates_[i];
            if (along(c.place)) return true;
            if (!c.whole_arc) continue;
            constexpr int kAlong = 8;
            for (int k = 0; k < kAlong; ++k)
                if (along(model_.place(c.place.face, c.place.arc,
                                       c.t0 + (c.t1 - c.t0) * (k + 0.5) / kAlong)))
                    return true;
        }
        return false;
    }

    void make_entries() {
        for (const auto& group : groups()) {
            ContactEntry e;
            const Candidate& first = candidates_[group[0]];
            e.box = first.box;
            e.face = first.face;
            e.lo = first.lo, e.hi = first.hi;
            for (int i : group) {
                const Candidate& c = candidates_[i];
                for (int k = 0; k < 3; ++k) {
                    e.box[2 * k] = std::min(e.box[2 * k], c.box[2 * k]);
                    e.box[2 * k + 1] = std::max(e.box[2 * k + 1], c.box[2 * k + 1]);
                }
                if (c.lo < e.lo) e.lo = c.lo;
                if (c.hi < e.hi) e.hi = c.hi, e.face = c.face;
            }
            e.continuum = most_apart(e.box, e.box) > kContinuum * model_.size;
            if (leads_down(group, e)) continue;
            out_.entries.push_back(std::move(e));
        }
        merge_touching();
        auto& all = out_.entries;
        std::sort(all.begin(), all.end(),
                  [](const ContactEntry& a, const ContactEntry& b) { return a.lo < b.lo; });
        absorb();
        for (size_t i = 0; i < all.size(); ++i) all[i].minimum = is_minimum(i);
        for (auto& e : all) {
            if (o_.linear) continue;
            if (e.lo.sign() < 0) e.lo = Real(0.0);
            mpfr_sqrt(e.lo.get(), e.lo.get(), MPFR_RNDD);
            mpfr_sqrt(e.hi.get(), e.hi.get(), MPFR_RNDU);
        }
    }

    // Boxes of groups may be nearer than their candidates are.
    void merge_touching() {
        auto& all = out_.entries;
        for (bool again = true; again;) {
            again = false;
            for (size_t i = 0; i < all.size(); ++i)
                for (size_t j = all.size(); --j > i;) {
                    if (least_apart(all[i].box, all[j].box) > join_) continue;
                    for (int k = 0; k < 3; ++k) {
                        all[i].box[2 * k] = std::min(all[i].box[2 * k], all[j].box[2 * k]);
                        all[i].box[2 * k + 1] =
                            std::max(all[i].box[2 * k + 1], all[j].box[2 * k + 1]);
                    }
                    if (all[j].lo < all[i].lo) all[i].lo = all[j].lo;
                    if (all[j].hi < all[i].hi) all[i].hi = all[j].hi;
                    all[i].continuum |=
                        most_apart(all[i].box, all[i].box) > kContinuum * model_.size;
                    all.erase(all.begin() + std::ptrdiff_t(j));
                    again = true;
                }
        }
    }

    // What is next to a lower entry is one with it; of boxes that may be the lowest all are kept.
    void absorb() {
        auto& all = out_.entries;
        for (size_t i = 0; i < all.size(); ++i)
            for (size_t j = i + 1; j < all.size();) {
                ContactEntry &low = all[i], &high = all[j];
                if (least_apart(low.box, high.box) > kOne * model_.size) {
                    ++j;
                    continue;
                }
                if (!(low.hi < high.lo)) {
                    for (int k = 0; k < 3; ++k) {
                        low.box[2 * k] = std::min(low.box[2 * k], high.box[2 * k]);
                        low.box[2 * k + 1] = std::max(low.box[2 * k + 1], high.box[2 * k + 1]);
                    }
                    if (high.hi < low.hi) low.hi = high.hi;
                    low.continuum |= most_apart(low.box, low.box) > kContinuum * model_.size;
                }
                all.erase(all.begin() + std::ptrdiff_t(j));
            }
    }

    bool is_minimum(size_t i) {
        const auto& all = out_.entries;
        const ContactEntry& e = all[i];
        // A point of F in the box, no higher than the limit.
        if (!mpfr_number_p(e.hi.get()) || Real(bound_) < e.hi) return false;
        bool alone = true;
        double nearest = 0.25 * model_.size;
        for (size_t j = 0; j < all.size(); ++j) {
            if (j == i) continue;
            alone &= e.hi < all[j].lo;
            nearest = std::min(nearest, least_apart(e.box, all[j].box));
        }
        if (alone) return true;
        if (e.continuum && most_apart(e.box, e.box) > 0.5 * model_.size) return false;
        const double hi = rooted_up(o_, e.hi.up());
        for (const int bits : {7, 10, 13, 16, 19, 4}) {
            if (ways_.spent()) return false;
            const double far = std::ldexp(model_.size, -bits);
            if (far >= nearest || far < 64 * join_) continue;
            if (ways_.walled(e.box, hi, far - 4 * join_, far)) return true;
        }
        const double far = 0.5 * nearest;
        return far > 64 * join_ && ways_.walled(e.box, hi, far - 4 * join_, far);
    }

    const AllPieces& model_;
    const Objective o_;
    const double join_;
    // The limit on the objective's own value.
    const double bound_;
    const ContactBudget budget_;
    Ways ways_;
    std::vector<Candidate> candidates_;
    std::vector<Fall> falls_;
    Contacts out_;
};

}  // namespace

Contacts contacts(const Pieces& model, const Objective& objective, double limit, double join,
                  const ContactBudget& budget) {
    const AllPieces all(model);
    return Search(all, objective, limit, join, budget).run();
}

double join_of(const Core& core) {
    const Edges& edges = core.edges();
    const double least = kJoin * core.pieces().size(), most = kHole * core.pieces().size();
    double widest = 0;
    for (size_t e = 0; e < edges.images().uses.size(); ++e) {
        if (edges.images().uses[e].size() < 2) continue;
        // What is soon found is enough where it changes nothing.
        const double rough = edges.rough(int(e));
        if (rough <= widest || kJoinOfWidth * rough <= least) continue;
        const CrackWidth& width = edges.width(int(e));
        if (!width.known)
            throw std::invalid_argument("edge " + std::to_string(e) +
                                        ": an image is not known whole, so no crack's width is");
        widest = std::max(widest, width.d.hi.up());
    }
    return std::max(least, std::min(next_up(kJoinOfWidth * widest), most));
}

}  // namespace feeler_oracle
