// A line and a planar face: exact rational intersection; where the line lies in the plane, the
// intervals between its crossings with the loops.

#include <algorithm>
#include <stdexcept>

#include "line.hpp"
#include "line_arc.hpp"
#include "net.hpp"
#include "plane_frame.hpp"
#include "roots.hpp"

namespace feeler_oracle {
namespace {

double nearest(const Q& x) { return double_bounds(x).first; }

void cross_plane(const PreparedFace& face, int index, const Line& line, const Frame& frame,
                 const Q& numerator, const Q& denominator, LineAnswer& answer) {
    const Q t = numerator / denominator;
    Q3 w = exact(line.origin);
    for (int k = 0; k < 3; ++k) w[k] += t * Q(line.direction[k]) - frame.origin[k];
    const auto ab = frame.coordinates(w);
    const Q u = frame.parameter(0, ab[0]), v = frame.parameter(1, ab[1]);
    const auto& d = face.region.domain();
    const Q scale(1L << kMarginBits);
    const Q mu = (d[1] - d[0]) / scale, mv = (d[3] - d[2]) / scale;
    // Clear: the box of the margin meets no loop, and either lies in the domain or is off it.
    const bool off = u + mu < d[0] || u - mu > d[1] || v + mv < d[2] || v - mv > d[3];
    if (!off && !box_clear(face.region, {u - mu, u + mu, v - mv, v + mv})) answer.clear = false;
    const Side where = side(face.region, u, v);
    if (where == Side::Outside) return;
    LineHit hit;
    hit.face = index;
    hit.t = to_interval(t);
    hit.boundary = where == Side::Boundary;
    hit.transversal = true;
    hit.uv = {nearest(u), nearest(v)};
    // Exact, so that the ends of a ray or segment are decided.
    if (line.kind != LineKind::Line &&
        (sign(t) < 0 || (line.kind == LineKind::Segment && t > Q(1))))
        return;
    if (t == Q(0) || t == Q(1)) hit.t = Interval(t == Q(0) ? 0.0 : 1.0);
    answer.hits.push_back(std::move(hit));
}

using Break = LineBreak;

// Where the line u = u0 + t u1, v = v0 + t v1 meets a loop's arc.
void breaks_of(const RationalBezierCurve& arc, const std::array<Q, 2>& start,
               const std::array<Q, 2>& along, std::vector<Break>& breaks) {
    const Q length2 = along[0] * along[0] + along[1] * along[1];
    std::vector<Q> off, forward;
    for (std::size_t i = 0; i < arc.W.size(); ++i) {
        const Q x = arc.X[i] - start[0] * arc.W[i], y = arc.Y[i] - start[1] * arc.W[i];
        off.push_back(along[1] * x - along[0] * y);
        forward.push_back((along[0] * x + along[1] * y) / length2);
    }
    const auto add = [&](const Q& lo, const Q& hi) {
        // t over the parameters [lo, hi], by intervals over the restricted coefficients.
        const auto over = [&](const std::vector<Q>& c) {
            const Net n =
                restrict_v(to_net(0, int(c.size()) - 1, c), to_interval(lo).lo, to_interval(hi).hi);
            return hull(n);
        };
        const Interval t = divide_positive(over(forward), over(arc.W));
        breaks.push_back({to_exact(t.lo), to_exact(t.hi)});
    };
    const bool all_on =
        std::all_of(off.begin(), off.end(), [](const Q& x) { return sign(x) == 0; });
    if (all_on) {
        // The arc runs along the line: its hull's ends are breaks (it may reach less far, which
        // only adds a break).
        for (std::size_t i = 0; i < arc.W.size(); ++i) {
            const Q t = forward[i] / arc.W[i];
            breaks.push_back({t, t});
        }
        return;
    }
    if (off.size() == 2) {
        if (sign(off[0]) * sign(off[1]) > 0) return;
        const Q s = off[0] / (off[0] - off[1]), r = Q(1) - s;
        const Q t = (forward[0] * r + forward[1] * s) / (arc.W[0] * r + arc.W[1] * s);
        breaks.push_back({t, t});
        return;
    }
    for (int side : {1, -1})
        if (std::all_of(off.begin(), off.end(), [&](const Q& x) { return sign(x) == side; }))
            return;
    for (const auto& root : isolate_roots(off, kRootBits)) add(root.first, root.second);
}

void lie_in_plane(const PreparedFace& face, int index, const Line& line, const Frame& frame,
                  LineAnswer& answer) {
    const auto at = frame.coordinates(minus(exact(line.origin), frame.origin));
    const auto step = frame.coordinates(exact(line.direction));
    const std::array<Q, 2> start{frame.parameter(0, at[0]), frame.parameter(1, at[1])};
    const std::array<Q, 2> along{step[0] * frame.slope(0), step[1] * frame.slope(1)};
    std::vector<Break> breaks;
    answer.clear = false;
    for (const RegionArc& any : face.region.arcs()) {
        if (const auto* curve = std::get_if<RationalBezierCurve>(&any)) {
            breaks_of(*curve, start, along, breaks);
            continue;
        }
        const auto* arc = std::get_if<CircularArc>(&any);
        if (arc ? arc_breaks(*arc, start, along, breaks)
                : arc_breaks(std::get<Segment>(any), start, along, breaks))
            continue;
        throw std::runtime_error("a loop that is not told from the line at the top precision");
    }
    const auto& d = face.region.domain();
    for (int k = 0; k < 4; ++k)
        if (sign(along[k / 2]) != 0) {
            const Q t = (d[k] - start[k / 2]) / along[k / 2];
            breaks.push_back({t, t});
        }
    std::sort(breaks.begin(), breaks.end(),
              [](const Break& a, const Break& b) { return a.lo < b.lo; });
    // Breaks that are not told apart count as one.
    std::vector<Break> distinct;
    for (const auto& b : breaks) {
        if (!distinct.empty() && b.lo <= distinct.back().hi)
            distinct.back().hi = std::max(distinct.back().hi, b.hi);
        else
            distinct.push_back(b);
    }
    const auto belongs = [&](const Q& t) {
        return side(face.region, start[0] + t * along[0], start[1] + t * along[1]) != Side::Outside;
    };
    const auto enclose = [](const Break& b) {
        return Interval(to_interval(b.lo).lo, to_interval(b.hi).hi);
    };
    const auto hit_at = [&](std::size_t first, std::size_t last) {
        LineHit hit;
        hit.face = index;
        hit.t = enclose(distinct[first]);
        hit.t_end = enclose(distinct[last]);
        hit.lies_in = first != last;
        hit.boundary = !hit.lies_in;
        hit.tangential = true;
        const Q& t = distinct[first].lo;
        hit.uv = {nearest(start[0] + t * along[0]), nearest(start[1] + t * along[1])};
        keep_hit(line, hit, answer);
    };
    const Q half(1, 2);
    for (std::size_t i = 0; i < distinct.size(); ++i) {
        std::size_t last = i;
        while (last + 1 < distinct.size() &&
               belongs((distinct[last].hi + distinct[last + 1].lo) * half))
            ++last;
        if (last > i) {
            hit_at(i, last);
            i = last;
        } else if (distinct[i].lo < distinct[i].hi) {
            // On a loop, by a root of the arc; counts where that is in the domain.
            const Q t = distinct[i].lo;
            const Q u = start[0] + t * along[0], v = start[1] + t * along[1];
            if (d[0] <= u && u <= d[1] && d[2] <= v && v <= d[3]) hit_at(i, i);
        } else if (belongs(distinct[i].lo)) {
            hit_at(i, i);
        }
    }
}

}  // namespace

void line_hits_plane(const PreparedFace& face, int index, const Line& line, LineAnswer& answer) {
    const Frame frame(std::get<Plane>(face.face->surface));
    if (sign(frame.normal2) == 0) {
        answer.open.push_back({index, Interval(0.0), "a plane whose axes are parallel"});
        answer.clear = false;
        return;
    }
    const Q3 direction = exact(line.direction);
    const Q denominator = dot(frame.normal, direction);
    const Q numerator = dot(frame.normal, minus(frame.origin, exact(line.origin)));
    if (sign(denominator) != 0)
        cross_plane(face, index, line, frame, numerator, denominator, answer);
    else if (sign(numerator) == 0)
        lie_in_plane(face, index, line, frame, answer);
}

}  // namespace feeler_oracle
