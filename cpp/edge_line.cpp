#include "edge_line.hpp"

#include <algorithm>
#include <numeric>

#include "edge_near.hpp"
#include "edge_width.hpp"

namespace feeler_oracle {
namespace {

struct Passage {
    int edge;
    Interval range;  // projections of the parts of images
    bool certain;    // some of it is in the crack
};

// Lengths to parameters of the line, from above.
Real per_length(const std::array<double, 3>& d) {
    Interval s(0.0);
    for (const double x : d) s = s + square(Interval(x));
    Real r;
    mpfr_rec_sqrt(r.get(), s.lo.get(), MPFR_RNDU);
    return r;
}

Real shifted(const Real& x, const Real& by, int times) {
    return times > 0 ? add_up(x, mul_up(by, Real(double(times))))
                     : sub_down(x, mul_up(by, Real(double(-times))));
}

class Search {
 public:
    Search(const Core& core, const Line& line, const LineAnswer& answer)
        : core_(core), edges_(core.edges()), line_(line), answer_(answer) {
        target_.kind = NearTarget::Line;
        target_.direction = line.direction;
        for (int k = 0; k < 3; ++k) target_.origin[k] = Interval(line.origin[k]);
        scale_ = per_length(line.direction);
    }

    LineCrossings run() {
        LineCrossings result;
        if (!answer_.open.empty()) return result;
        for (std::size_t e = 0; e < edges_.images().uses.size(); ++e)
            if (edges_.images().uses[e].size() > 1) passages_of(int(e));
        if (!known_) return result;
        bool crack = false, maybe_crack = false;
        std::vector<std::pair<int, int>> sure, perhaps;
        std::vector<char> linked(answer_.hits.size(), 0), maybe_linked = linked;
        for (const Passage& p : passages_) {
            const Near here = on_part(p);
            if (here == Near::No) continue;
            int first = -1, first_perhaps = -1;
            for (std::size_t h = 0; h < answer_.hits.size(); ++h) {
                const Near member = in_passage(answer_.hits[h], p);
                if (member == Near::No) continue;
                if (member == Near::Yes) {
                    if (first >= 0) sure.emplace_back(first, int(h));
                    first = int(h);
                    linked[h] = 1;
                }
                if (first_perhaps >= 0) perhaps.emplace_back(first_perhaps, int(h));
                first_perhaps = int(h);
                maybe_linked[h] = 1;
            }
            crack |= first_perhaps < 0 && p.certain && here == Near::Yes;
            maybe_crack |= first < 0;
        }
        result.in_crack = crack ? 1 : maybe_crack ? -1 : 0;
        const int least = count(sure, linked), most = count(perhaps, maybe_linked);
        result.crossings = least == most ? least : -1;
        return result;
    }

 private:
    void passages_of(int edge) {
        const double rough = edges_.rough(edge);
        std::vector<NearPart> parts;
        for (const int i : edges_.images().uses[edge]) {
            const Image& image = edges_.images().images[i];
            if (!image.whole) {
                known_ = false;
                return;
            }
            if (line_misses(target_, image.box, rough)) continue;
            for (const auto* pieces : {&image.pieces, &image.between})
                for (const Piece* p : *pieces) {
                    if (line_misses(target_, p->box, next_up(rough + slack_of(*p)))) continue;
                    if (clear_in_doubles(target_, *p, rough)) continue;
                    near_piece(target_, *p, edges_.width(edge).d, &parts);
                }
        }
        if (parts.empty()) return;
        const Real reach = mul_up(edges_.width(edge).d.hi, scale_);
        const Real less = mul_down(edges_.width(edge).d.lo, scale_);  // hardly rounded up
        std::sort(parts.begin(), parts.end(),
                  [](const NearPart& a, const NearPart& b) { return a.t.lo < b.t.lo; });
        for (std::size_t i = 0; i < parts.size();) {
            Passage passage{edge, parts[i].t, parts[i].near == Near::Yes};
            Real last_certain = parts[i].t.hi;
            for (++i; i < parts.size() && parts[i].t.lo <= shifted(passage.range.hi, reach, 3);
                 ++i) {
                const bool certain = parts[i].near == Near::Yes;
                // Between d_e and 3 d_e from the last: one passage or two.
                if (certain && passage.certain &&
                    !(parts[i].t.lo <= add_down(last_certain, less)) &&
                    !(parts[i].t.lo <= passage.range.hi))
                    known_ = false;
                passage.range = hull(passage.range, parts[i].t);
                passage.certain |= certain;
                if (certain && last_certain < parts[i].t.hi) last_certain = parts[i].t.hi;
            }
            passages_.push_back(passage);
        }
    }

    Interval reach_of(const Passage& p) const {
        const Real reach = mul_up(edges_.width(p.edge).d.hi, scale_);
        return {shifted(p.range.lo, reach, -1), shifted(p.range.hi, reach, 1)};
    }

    // Whether the passage is on the part of the line that counts.
    Near on_part(const Passage& p) const {
        if (line_.kind == LineKind::Line) return Near::Yes;
        const Interval reach = reach_of(p);
        const Real zero(0.0), one(1.0);
        const bool segment = line_.kind == LineKind::Segment;
        if (reach.hi < zero || (segment && one < reach.lo)) return Near::No;
        if (zero <= reach.lo && (!segment || reach.hi <= one)) return Near::Yes;
        return Near::Unknown;
    }

    Near in_passage(const LineHit& hit, const Passage& p) const {
        // A crack leads into its own BREP, whatever others are there.
        if (core_.model().faces[hit.face].brep != edges_.images().brep_of[p.edge]) return Near::No;
        const Interval reach = reach_of(p);
        if (hit.t.hi < reach.lo || reach.hi < hit.t.lo) return Near::No;
        const Near near = near_edge(hit, p.edge);
        if (near != Near::Unknown || !hit.boundary) return near;
        // On the boundary of its region: on the edge, if near no other.
        const auto& all = edges_.images();
        bool own = false;
        for (const Image& image : all.images) {
            if (image.face != hit.face) continue;
            if (image.edge == p.edge)
                own = true;
            else if (near_image(hit, image, Interval(0.0)) != Near::No)
                return Near::Unknown;
        }
        for (const auto& v : all.vertices)
            if (v.brep == core_.model().faces[hit.face].brep && !outside(point_of(hit), v.box))
                return Near::Unknown;
        return own ? Near::Yes : Near::Unknown;
    }

    static bool outside(const std::array<Interval, 3>& x, const std::array<double, 6>& box) {
        for (int k = 0; k < 3; ++k)
            if (x[k].hi < Real(box[2 * k]) || Real(box[2 * k + 1]) < x[k].lo) return true;
        return false;
    }

    std::array<Interval, 3> point_of(const LineHit& hit) const {
        std::array<Interval, 3> x;
        for (int k = 0; k < 3; ++k)
            x[k] = Interval(line_.origin[k]) + hit.t * Interval(line_.direction[k]);
        return x;
    }

    Near near_edge(const LineHit& hit, int edge) const {
        Near result = Near::No;
        for (const int i : edges_.images().uses[edge]) {
            const Near near = near_image(hit, edges_.images().images[i], edges_.width(edge).d);
            if (near == Near::Yes) return near;
            if (near == Near::Unknown) result = near;
        }
        return result;
    }

    Near near_image(const LineHit& hit, const Image& image, const Interval& radius) const {
        NearTarget target;
        target.origin = point_of(hit);
        Near result = Near::No;
        for (const auto* pieces : {&image.pieces, &image.between})
            for (const Piece* p : *pieces) {
                const Near near = near_piece(target, *p, radius);
                if (near == Near::Yes) return near;
                if (near == Near::Unknown) result = near;
            }
        return result;
    }

    // Linked hits count once; others where they cross. -1: not known.
    int count(const std::vector<std::pair<int, int>>& links,
              const std::vector<char>& linked) const {
        std::vector<int> group(answer_.hits.size());
        std::iota(group.begin(), group.end(), 0);
        const auto find = [&](int i) {
            while (group[i] != i) i = group[i];
            return i;
        };
        for (const auto& [a, b] : links) group[find(a)] = find(b);
        int total = 0;
        for (std::size_t h = 0; h < answer_.hits.size(); ++h) {
            const LineHit& hit = answer_.hits[h];
            if (hit.lies_in) return -1;
            if (linked[h]) {
                total += find(int(h)) == int(h);
                continue;
            }
            if (!hit.transversal && !hit.tangential) return -1;
            total += hit.transversal;
        }
        return total;
    }

    const Core& core_;
    const Edges& edges_;
    const Line& line_;
    const LineAnswer& answer_;
    NearTarget target_;
    Real scale_;
    bool known_ = true;
    std::vector<Passage> passages_;
};

}  // namespace

LineCrossings line_crossings(const Core& core, const Line& line, const LineAnswer& answer) {
    return Search(core, line, answer).run();
}

}  // namespace feeler_oracle
