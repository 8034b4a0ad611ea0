#include "inside.hpp"

#include "line.hpp"

namespace feeler_oracle {
namespace {

// Unrelated directions, off the axes and planes that parts are built along.
constexpr double kDirections[][3] = {
    {0.5718, 0.3947, 0.7192},   {-0.6293, 0.4418, 0.6391},  {0.2863, -0.8411, 0.4587},
    {-0.3571, -0.4783, 0.8023}, {0.8147, 0.2239, -0.5347},  {-0.1873, 0.9127, -0.3631},
    {0.4421, -0.6173, -0.6507}, {-0.7619, -0.1237, 0.6359}, {0.1433, 0.2711, 0.9519},
    {0.9341, -0.3083, 0.1797},  {-0.2207, 0.6449, 0.7317},  {0.6829, 0.7103, -0.1709},
};
// So many rays must agree.
constexpr int kAgree = 2;

InsideAnswer inside_brep(const Core& core, int brep, const std::array<double, 3>& point) {
    int votes = 0;
    bool odd = false;
    std::string why = "every ray tried passes near an edge or touches a face";
    for (const auto& d : kDirections) {
        // All of the line, so that a hit at the point itself is seen.
        const Line line{point, {d[0], d[1], d[2]}, LineKind::Line};
        const LineAnswer answer = line_hits(core, line, {brep, 2000});
        bool this_odd = false, usable = answer.clear && answer.open.empty();
        for (const auto& hit : answer.hits) {
            if (hit.t.lo.sign() == 0 && hit.t.hi.sign() == 0) return {InsideKind::Boundary, {}};
            if (hit.t.lo.sign() <= 0 && hit.t.hi.sign() >= 0) {
                why = "on a face, as far as can be told";
                usable = false;
            }
            if (!hit.transversal || hit.boundary || hit.lies_in) usable = false;
            if (hit.t.lo.sign() > 0) this_odd = !this_odd;
        }
        if (!usable) continue;
        if (votes > 0 && this_odd != odd)
            return {InsideKind::Undecided, "rays disagree: a crack wider than the margin"};
        odd = this_odd;
        if (++votes == kAgree) return {odd ? InsideKind::Inside : InsideKind::Outside, {}};
    }
    return {InsideKind::Undecided, why};
}

}  // namespace

InsideAnswer inside(const Core& core, const std::array<double, 3>& point) {
    InsideAnswer result{InsideKind::Outside, {}};
    for (std::size_t b = 0; b < core.model().closed.size(); ++b) {
        if (!core.model().closed[b]) continue;
        const InsideAnswer one = inside_brep(core, int(b), point);
        if (one.kind == InsideKind::Inside) return one;
        if (one.kind == InsideKind::Undecided || result.kind == InsideKind::Outside) result = one;
    }
    return result;
}

}  // namespace feeler_oracle
