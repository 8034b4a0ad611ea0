#include "line.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "line_native.hpp"

namespace feeler_oracle {

Planes::Planes(const std::array<double, 3>& d) {
    k = 0;
    for (int m = 1; m < 3; ++m)
        if (std::abs(d[m]) > std::abs(d[k])) k = m;
    i = (k + 1) % 3;
    j = (k + 2) % 3;
}

bool box_missed(const std::array<Interval64, 3>& box, const Line& line) {
    const Planes planes(line.direction);
    const auto off = [&](int m) {
        const Interval64 dk(line.direction[planes.k]), dm(line.direction[m]);
        const Interval64 o_m(line.origin[m]), o_k(line.origin[planes.k]);
        return dk * (box[m] - o_m) - dm * (box[planes.k] - o_k);
    };
    for (int m : {planes.i, planes.j}) {
        const Interval64 range = off(m);
        if (range.lo > 0 || range.hi < 0) return true;
    }
    return false;
}

void keep_hit(const Line& line, LineHit hit, LineAnswer& answer) {
    if (line.kind != LineKind::Line) {
        const auto beyond = [&](const Interval& end, bool lower) {
            const Interval& last = hit.lies_in ? hit.t_end : hit.t;
            return lower ? last.hi < end.lo : end.hi < hit.t.lo;
        };
        const Interval zero(0.0), one(1.0);
        const bool segment = line.kind == LineKind::Segment;
        if (beyond(zero, true) || (segment && beyond(one, false))) return;
        if (hit.lies_in) {
            // The part that counts; ends that are not told apart from 0 or 1 may be either.
            if (hit.t.hi < zero.lo) hit.t = zero;
            if (segment && one.hi < hit.t_end.lo) hit.t_end = one;
        }
        const auto unsettled = [](const Interval& x, const Interval& end) {
            return x.lo <= end.hi && end.lo <= x.hi && !x.is_point();
        };
        const Interval& last = hit.lies_in ? hit.t_end : hit.t;
        if (unsettled(last, zero) || (segment && unsettled(hit.t, one))) {
            answer.open.push_back({hit.face, hit.t, "a hit at the end of the line's part"});
            return;
        }
    }
    answer.hits.push_back(std::move(hit));
}

LineAnswer line_hits(const Core& core, const Line& line, const LineOptions& options) {
    LineAnswer answer;
    long budget = options.budget;
    const auto& faces = core.model().faces;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        if (options.only_brep >= 0 && faces[i].brep != options.only_brep) continue;
        if (options.faces && !(*options.faces)[i]) continue;
        const PreparedFace& face = core.face(i);
        // An empty list of loops: no face.
        if (!face.region.whole_domain() && face.region.arcs().empty()) continue;
        if (std::holds_alternative<Plane>(faces[i].surface))
            line_hits_plane(face, int(i), line, answer);
        else if (is_rational(faces[i].surface))
            line_hits_nurbs(face, int(i), line, budget, answer);
        else
            line_hits_native(core, int(i), line, budget, answer);
    }
    std::stable_sort(answer.hits.begin(), answer.hits.end(),
                     [](const LineHit& a, const LineHit& b) { return a.t.lo < b.t.lo; });
    return answer;
}

}  // namespace feeler_oracle
