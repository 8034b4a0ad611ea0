// A line and a NURBS face.

#include <algorithm>

#include "line.hpp"
#include "line_joint.hpp"
#include "line_roots.hpp"
#include "patch_curve.hpp"
#include "roots.hpp"

namespace feeler_oracle {
namespace {

// The two planes through the line, and what gives t: exact coefficients on a patch.
struct PatchLine {
    int p, q;
    std::vector<Q> f1, f2;  // n1.(P - o W), n2.(P - o W)
    std::vector<Q> along;   // d.(P - o W) / d.d
    const std::vector<Q>* weight;
};

PatchLine on_patch(const RationalBezierPatch& patch, const Line& line) {
    const Planes planes(line.direction);
    const std::vector<Q>* const xyz[3] = {&patch.X, &patch.Y, &patch.Z};
    const Q d[3] = {Q(line.direction[0]), Q(line.direction[1]), Q(line.direction[2])};
    const Q o[3] = {Q(line.origin[0]), Q(line.origin[1]), Q(line.origin[2])};
    const Q inverse = Q(1) / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    PatchLine f{patch.p, patch.q, {}, {}, {}, &patch.W};
    for (std::size_t c = 0; c < patch.W.size(); ++c) {
        Q x[3];
        for (int m = 0; m < 3; ++m) x[m] = (*xyz[m])[c] - o[m] * patch.W[c];
        f.f1.push_back(d[planes.k] * x[planes.i] - d[planes.i] * x[planes.k]);
        f.f2.push_back(d[planes.k] * x[planes.j] - d[planes.j] * x[planes.k]);
        f.along.push_back((d[0] * x[0] + d[1] * x[1] + d[2] * x[2]) * inverse);
    }
    return f;
}

// Coefficients on a line of constant local parameter s: along u (fixed_u) or v.
std::vector<Q> iso_line(const std::vector<Q>& c, int p, int q, bool fixed_u, const Q& s) {
    const int lines = fixed_u ? q : p, degree = fixed_u ? p : q;
    const Q r = Q(1) - s;
    std::vector<Q> result;
    for (int l = 0; l <= lines; ++l) {
        std::vector<Q> row;
        for (int k = 0; k <= degree; ++k)
            row.push_back(c[std::size_t(fixed_u ? k * (q + 1) + l : l * (q + 1) + k)]);
        for (int level = 1; level <= degree; ++level)
            for (int k = 0; k + level <= degree; ++k) row[k] = row[k] * r + row[k + 1] * s;
        result.push_back(row[0]);
    }
    return result;
}

// ---- sides that collapse to one point

// Whether F1 = F2 = 0 on side s (u = 0, u = 1, v = 0, v = 1).
bool vanishes_on_side(const PatchLine& f, int s) {
    const auto zero = [&](const std::vector<Q>& c) {
        const auto e = iso_line(c, f.p, f.q, s < 2, Q(s % 2));
        return std::all_of(e.begin(), e.end(), [](const Q& x) { return sign(x) == 0; });
    };
    return zero(f.f1) && zero(f.f2);
}

// All of side s at one parameter of the line: then it is one point.
bool side_collapses(const PatchLine& f, int s, Q& t) {
    const auto a = iso_line(f.along, f.p, f.q, s < 2, Q(s % 2));
    const auto w = iso_line(*f.weight, f.p, f.q, s < 2, Q(s % 2));
    t = a[0] / w[0];
    for (std::size_t k = 0; k < a.size(); ++k)
        if (a[k] != t * w[k]) return false;
    return true;
}

// A net that vanishes on side s, divided by the distance from that side: with n the degree across,
// c_k = g_k (n - k) / n for a zero at 1, c_k = g_(k-1) k / n for a zero at 0.
std::vector<Q> deflate(const std::vector<Q>& c, int p, int q, int s) {
    const bool u = s < 2, at_end = s % 2;
    std::vector<Q> g;
    const int n = u ? p : q;
    for (int i = 0; i <= (u ? p - 1 : p); ++i)
        for (int j = 0; j <= (u ? q : q - 1); ++j) {
            const int k = u ? i : j;
            const std::size_t from =
                at_end ? std::size_t(i * (q + 1) + j)
                       : std::size_t((i + (u ? 1 : 0)) * (q + 1) + j + (u ? 0 : 1));
            g.push_back(c[from] * Q(n) / Q(at_end ? n - k : k + 1));
        }
    return g;
}

struct Search {
    const PreparedFace& face;
    int index;
    const Line& line;
    long& budget;
    LineAnswer& answer;
    // A root at a joint of patches, as they see it.
    struct Joint {
        std::array<Q, 4> unique;  // of surface uv, in which it is the only one
        std::vector<JointView> views;
        std::optional<std::size_t> hit;
        bool done = false;  // a hit, or not on the part of the line that counts, or open
    };
    std::vector<Joint> joints;
    bool factored = false;  // the forms that are searched lack a factor that vanishes on a curve

    void patch(std::size_t i);
    // What the line has of whole curves of the face, and points of such.
    std::vector<LineHit> runs;
    std::optional<std::array<bool, 2>> closed;  // at its seam, exactly: in u, in v

    // f: on the patch; g: with the same common roots, or fewer.
    void root(const RationalBezierPatch& patch, const PatchLine& f, const PatchLine& g,
              const PatchRoot& root, const std::vector<int>& deflated);
    void describe(const Joint& joint);
    bool in_face(const RationalBezierPatch& patch, const PatchLine& f, PatchLine& g);
    bool follow(const RationalBezierPatch& patch, const PatchLine& f, const PatchCurve& curve);
    void unite_runs(std::size_t first_hit);
    bool closed_in(int axis);
    void pole(const RationalBezierPatch& patch, int s, const Q& t);
    void open(const RationalBezierPatch& patch, const PatchLine& f, std::array<Real, 4> box,
              const char* why);
    Interval parameter(const PatchLine& f, const std::array<Real, 4>& box) const;
    enum class Where { Inside, Outside, Boundary, Unknown };
    Where classify(const RationalBezierPatch& patch, const PatchLine& g, const PatchRoot& root,
                   const std::array<Q, 4>& local, const std::array<Q, 4>& uv) const;
    bool margin_clear(const std::array<Q, 4>& uv) const;
};

std::array<Q, 4> to_surface(const RationalBezierPatch& s, const std::array<Q, 4>& b) {
    const Q du = s.u1 - s.u0, dv = s.v1 - s.v0;
    return {s.u0 + b[0] * du, s.u0 + b[1] * du, s.v0 + b[2] * dv, s.v0 + b[3] * dv};
}

std::array<Q, 4> exact_box(const std::array<Real, 4>& b) {
    return {to_exact(b[0]), to_exact(b[1]), to_exact(b[2]), to_exact(b[3])};
}

Interval Search::parameter(const PatchLine& f, const std::array<Real, 4>& box) const {
    const auto over = [&](const std::vector<Q>& c) {
        return hull(restrict_v(restrict_u(to_net(f.p, f.q, c), box[0], box[1]), box[2], box[3]));
    };
    return divide_positive(over(f.along), over(*f.weight));
}

bool Search::margin_clear(const std::array<Q, 4>& uv) const {
    const auto& d = face.region.domain();
    const Q scale(1L << kMarginBits);
    const Q mu = (d[1] - d[0]) / scale, mv = (d[3] - d[2]) / scale;
    return box_clear(face.region, {uv[0] - mu, uv[1] + mu, uv[2] - mv, uv[3] + mv});
}

Search::Where Search::classify(const RationalBezierPatch& patch, const PatchLine& f,
                               const PatchRoot& root, const std::array<Q, 4>& local,
                               const std::array<Q, 4>& uv) const {
    const Q half(1, 2);
    const auto& region = face.region;
    if (loops_clear(region, uv)) {
        // No loop passes: one parity for the whole box; the domain's border was settled before.
        switch (side(region, (uv[0] + uv[1]) * half, (uv[2] + uv[3]) * half)) {
            case Side::Inside:
                return Where::Inside;
            case Side::Outside:
                return Where::Outside;
            default:
                return Where::Boundary;
        }
    }
    // A loop along a line of constant u or v that the root may lie on: decided exactly.
    for (const auto& any : region.arcs())
        for (int axis = 0; axis < 2; ++axis) {
            if (!std::holds_alternative<RationalBezierCurve>(any)) break;
            const auto& arc = std::get<RationalBezierCurve>(any);
            const auto& c = axis == 0 ? arc.X : arc.Y;
            const auto& other = axis == 0 ? arc.Y : arc.X;
            const Q value = c[0] / arc.W[0];
            bool constant = true;
            for (std::size_t k = 1; k < c.size(); ++k) constant &= c[k] == value * arc.W[k];
            if (!constant || value < uv[2 * axis] || value > uv[2 * axis + 1]) continue;
            // The root's other parameter must be within the arc's range.
            Q lo = other[0] / arc.W[0], hi = other.back() / arc.W.back();
            if (hi < lo) std::swap(lo, hi);
            const int o = axis == 0 ? 2 : 0;
            if (uv[o] < lo || uv[o + 1] > hi) continue;
            const Q s = axis == 0 ? (value - patch.u0) / (patch.u1 - patch.u0)
                                  : (value - patch.v0) / (patch.v1 - patch.v0);
            if (common_root(iso_line(f.f1, f.p, f.q, axis == 0, s),
                            iso_line(f.f2, f.p, f.q, axis == 0, s), local[o], local[o + 1]))
                return Where::Boundary;
        }
    // Any other loop: where the two forms, put on its arc, have a common root there.
    const auto unique = to_surface(patch, exact_box(root.unique));
    for (const auto& any : region.arcs()) {
        const auto* arc = std::get_if<RationalBezierCurve>(&any);
        if (!arc) continue;
        const auto parts = near_box(*arc, uv, unique);
        if (!parts || parts->empty()) continue;
        const LocalArc c = local_arc(*arc, patch);
        const Bernstein on1 = composed(f.f1, f.p, f.q, c.x, c.y, c.w),
                        on2 = composed(f.f2, f.p, f.q, c.x, c.y, c.w);
        if (is_zero(on1) && is_zero(on2)) continue;
        for (const auto& [lo, hi] : *parts)
            if (common_root(on1, on2, lo, hi)) return Where::Boundary;
    }
    return Where::Unknown;
}

void Search::open(const RationalBezierPatch& patch, const PatchLine& f, std::array<Real, 4> box,
                  const char* why) {
    // The part within the patch alone counts.
    const Real zero(0.0), one(1.0);
    for (int k = 0; k < 4; ++k) {
        if (box[k] < zero) box[k] = zero;
        if (one < box[k]) box[k] = one;
    }
    const auto uv = to_surface(patch, exact_box(box));
    if (loops_clear(face.region, uv) &&
        side(face.region, (uv[0] + uv[1]) * Q(1, 2), (uv[2] + uv[3]) * Q(1, 2)) == Side::Outside)
        return;
    const Interval t = parameter(f, box);
    if (line.kind != LineKind::Line && t.hi < Real(0.0)) return;
    if (line.kind == LineKind::Segment && Real(1.0) < t.lo) return;
    // Neighbouring boxes of one cluster are reported once.
    for (auto& o : answer.open)
        if (o.face == index && o.why == why && o.t.lo <= t.hi && t.lo <= o.t.hi) {
            o.t = hull(o.t, t);
            return;
        }
    answer.open.push_back({index, t, why});
}

void Search::pole(const RationalBezierPatch& patch, int s, const Q& t) {
    answer.clear = false;
    std::vector<CurveRun> parts;
    const PatchCurve collapsed{{Q(s % 2)}, {Q(1)}, s >= 2};
    if (!runs_in_region(face, patch, collapsed, {Q(0)}, parts)) {
        answer.open.push_back(
            {index, to_interval(t), "a pole, of which a part may be in the face"});
        return;
    }
    if (parts.empty()) return;
    const Q half(1, 2), at = (parts[0].first_lo + parts[0].last_hi) * half;
    const Q u = s < 2 ? Q(s % 2) : at, v = s < 2 ? at : Q(s % 2);
    const Q at_u = patch.u0 + u * (patch.u1 - patch.u0),
            at_v = patch.v0 + v * (patch.v1 - patch.v0);
    LineHit hit;
    hit.face = index;
    hit.t = to_interval(t);
    hit.boundary = true;
    hit.uv = {double_bounds(at_u).first, double_bounds(at_v).first};
    // One point, whichever patch it is met on.
    for (const auto& h : answer.hits)
        if (h.face == index && h.boundary && h.t.lo <= hit.t.hi && hit.t.lo <= h.t.hi) return;
    keep_hit(line, hit, answer);
}

void Search::root(const RationalBezierPatch& patch, const PatchLine& f, const PatchLine& g,
                  const PatchRoot& root, const std::vector<int>& deflated) {
    auto local = exact_box(root.box);
    const auto& domain = face.region.domain();
    const Q zero(0), one(1);
    const bool beyond = local[1] < zero || local[0] > one || local[3] < zero || local[2] > one;
    const auto reach = to_surface(patch, local);
    const bool beyond_domain = reach[1] < domain[0] || reach[0] > domain[1] ||
                               reach[3] < domain[2] || reach[2] > domain[3];
    if (beyond) {
        // Another patch's, or a near miss at the domain's border.
        const auto& d = domain;
        const Q scale(1L << kMarginBits);
        const Q mu = (d[1] - d[0]) / scale, mv = (d[3] - d[2]) / scale;
        if (beyond_domain && reach[1] >= d[0] - mu && reach[0] <= d[1] + mu &&
            reach[3] >= d[2] - mv && reach[2] <= d[3] + mv)
            answer.clear = false;
        return;
    }
    // Sides of the patch that the box reaches: exactly on them, or not to be told.
    bool on_joint = false, on_border = false;
    int joint_axis = -1;  // 0: a joint u = const, 1: v = const, 2: both
    for (int s = 0; s < 4; ++s) {
        const Q value(s % 2);
        const int axis = s / 2, o = axis == 0 ? 2 : 0;
        if (value < local[2 * axis] || value > local[2 * axis + 1]) continue;
        const bool on_side =
            common_root(iso_line(g.f1, g.p, g.q, axis == 0, value),
                        iso_line(g.f2, g.p, g.q, axis == 0, value), local[o], local[o + 1]);
        // At the pole, which is known.
        if (on_side && std::find(deflated.begin(), deflated.end(), s) != deflated.end()) return;
        if (!on_side) {
            open(patch, f, root.box, "a hit at the joint of two patches");
            answer.clear = false;
            return;
        }
        local[2 * axis] = local[2 * axis + 1] = value;
        on_joint = true;
        joint_axis = joint_axis < 0 ? axis : 2;
        const auto at = to_surface(patch, local);
        on_border |= at[2 * axis] == domain[2 * axis] || at[2 * axis] == domain[2 * axis + 1];
    }
    const auto uv = to_surface(patch, local);
    if (!margin_clear(uv)) answer.clear = false;
    // The same point as a neighbour sees it, across the seam too.
    std::vector<std::array<Q, 4>> views(1, uv);
    for (int axis = 0; on_border && axis < 2; ++axis) {
        const Q &lo = domain[2 * axis], &hi = domain[2 * axis + 1];
        const Q& here = uv[2 * axis];
        if (here != uv[2 * axis + 1] || (here != lo && here != hi) || !closed_in(axis)) continue;
        for (std::size_t k = views.size(); k-- > 0;) {
            auto other = views[k];
            other[2 * axis] = other[2 * axis + 1] = here == lo ? hi : lo;
            views.push_back(other);
        }
    }
    Joint* joint = nullptr;
    if (on_joint) {
        const auto holds = [&](const Joint& j) {
            return std::any_of(views.begin(), views.end(), [&](const std::array<Q, 4>& view) {
                return j.unique[0] <= view[0] && view[1] <= j.unique[1] && j.unique[2] <= view[2] &&
                       view[3] <= j.unique[3];
            });
        };
        const auto found = std::find_if(joints.begin(), joints.end(), holds);
        if (found == joints.end()) {
            joints.push_back({to_surface(patch, exact_box(root.unique)), {}, {}});
            joint = &joints.back();
        } else {
            joint = &*found;
        }
        JointView view{root, joint_axis, false, {0, 0}};
        if (joint_axis < 2) {
            view.after = sign(local[std::size_t(2 * joint_axis)]) == 0;
            // Without a factor that vanishes on a curve the forms are no longer those of the next
            // patch.
            if (!factored)
                view.along = signs_along(joint_axis, g.p, g.q, g.f1, g.f2, root.box);
        }
        joint->views.push_back(std::move(view));
        if (joint->done) {
            if (joint->hit) describe(*joint);
            return;
        }
    }
    // In the face where it is so by one of the views.
    const Where where = classify(patch, g, root, local, uv);
    if (where == Where::Outside) return;
    if (joint) joint->done = true;
    if (where == Where::Unknown) {
        open(patch, f, root.box, "a hit on a loop, as far as can be told");
        answer.clear = false;
        return;
    }
    LineHit hit;
    hit.face = index;
    hit.t = parameter(f, root.box);
    hit.boundary = on_border || where == Where::Boundary;
    hit.multiplicity = root.multiplicity;
    hit.transversal = root.multiplicity % 2 == 1;
    hit.tangential = root.multiplicity % 2 == 0;
    hit.uv = {double_bounds(uv[0]).first, double_bounds(uv[2]).first};
    const std::size_t before = answer.hits.size();
    keep_hit(line, hit, answer);
    if (joint && answer.hits.size() > before) {
        joint->hit = before;
        describe(*joint);
    }
}

// How the line meets the surface at a joint, as far as its patches have been looked at.
void Search::describe(const Joint& joint) {
    // Of one patch alone: at a border of the surface it counts as its polynomials go on.
    if (joint.views.size() < 2) return;
    LineHit& hit = answer.hits[*joint.hit];
    const auto passed = passes(joint.views);
    hit.transversal = passed == true;
    hit.tangential = passed == false;
    hit.multiplicity = joint.views[0].root.multiplicity;
    for (const JointView& v : joint.views)
        if (!passed || v.root.multiplicity != hit.multiplicity ||
            (hit.multiplicity % 2 == 1) != *passed)
            hit.multiplicity = 0;
}

bool Search::follow(const RationalBezierPatch& patch, const PatchLine& f, const PatchCurve& curve) {
    // The line's parameter along the curve; it is cut where that turns.
    const Bernstein zero(std::max(curve.n.size(), curve.d.size()) + 1, Q(0));
    const Bernstein w = combination(Q(1), curve.d, Q(1), zero),
                    dependent = combination(Q(1), curve.n, Q(1), zero),
                    own = combination(Q(1), product(curve.d, {Q(0), Q(1)}), Q(1), zero);
    const auto on = [&](const std::vector<Q>& c) {
        return curve.swapped ? composed(c, f.p, f.q, own, dependent, w)
                             : composed(c, f.p, f.q, dependent, own, w);
    };
    const Bernstein t = on(f.along), weight = on(*f.weight);
    const Bernstein turns =
        combination(Q(1), product(derivative(t), weight), Q(-1), product(t, derivative(weight)));
    std::vector<CurveRun> found;
    if (!runs_in_region(face, patch, curve, turns, found)) return false;
    for (const CurveRun& run : found) {
        const auto parameter_at = [&](const Q& lo, const Q& hi, std::array<Real, 4>& box) {
            Interval n = range(curve.n, lo, hi), d = range(curve.d, lo, hi);
            if (d.hi.sign() < 0) {
                n = -n;
                d = -d;
            }
            if (d.lo.sign() <= 0) return false;
            const Interval u = divide_positive(n, d);
            const Real v0 = to_interval(lo).lo, v1 = to_interval(hi).hi;
            box = curve.swapped ? std::array<Real, 4>{v0, v1, u.lo, u.hi}
                                : std::array<Real, 4>{u.lo, u.hi, v0, v1};
            return true;
        };
        std::array<Real, 4> first, last;
        if (!parameter_at(run.first_lo, run.first_hi, first) ||
            !parameter_at(run.last_lo, run.last_hi, last))
            return false;
        // Where the run's end is known exactly, so is the line's parameter.
        const auto end_at = [&](const Q& lo, const Q& hi, const std::array<Real, 4>& box) {
            const Q d = lo == hi ? value(weight, lo) : Q(0);
            return sign(d) == 0 ? parameter(f, box) : Interval((value(t, lo) / d).mpq());
        };
        LineHit hit;
        hit.face = index;
        hit.boundary = run.boundary;
        hit.t = end_at(run.first_lo, run.first_hi, first);
        hit.t_end = end_at(run.last_lo, run.last_hi, last);
        // A point, or a curve that is one point in space.
        hit.lies_in = !run.is_point() && !is_zero(turns);
        hit.tangential = hit.lies_in;
        if (hit.t_end.lo < hit.t.lo) {
            std::swap(hit.t, hit.t_end);
            std::swap(first, last);
        }
        const auto uv = to_surface(patch, exact_box(first));
        hit.uv = {double_bounds(uv[0]).first, double_bounds(uv[2]).first};
        runs.push_back(std::move(hit));
    }
    return true;
}

bool Search::in_face(const RationalBezierPatch& patch, const PatchLine& f, PatchLine& g) {
    answer.clear = false;
    const BiPoly f1 = to_bipoly(g.p, g.q, g.f1), f2 = to_bipoly(g.p, g.q, g.f2);
    if (f1.is_zero() && f2.is_zero()) return false;
    const CommonFactor factor = common_factor(f1, f2);
    const auto [of_u, of_v, core] = contents(factor.common);
    // Lines of constant u or v.
    for (const bool swapped : {false, true}) {
        const BiPoly& c = swapped ? of_v : of_u;
        const Bernstein b = to_bernstein(c, c.p, c.q);
        for (const auto& [lo, hi] : isolate_roots(b, kRootBits)) {
            const Q at = simplest(lo, hi);
            if (sign(value(b, at)) != 0) return false;
            if (!follow(patch, f, {{at}, {Q(1)}, swapped})) return false;
        }
    }
    // Graphs of rational functions.
    if (core.p > 0 || core.q > 0) {
        const bool swapped = core.p > 1;
        const BiPoly c = swapped ? transposed(core) : core;
        if (c.p != 1) return false;
        const auto row = [&c](int i, const Z& factor) {
            BiPoly r{0, c.q, {}};
            for (int j = 0; j <= c.q; ++j) r.c.push_back(c.at(i, j) * factor);
            return to_bernstein(r, 0, c.q);
        };
        if (!follow(patch, f, {row(0, Z(-1)), row(1, Z(1)), swapped})) return false;
    }
    g.f1 = to_bernstein(factor.f, g.p, g.q);
    g.f2 = to_bernstein(factor.g, g.p, g.q);
    return true;
}

// Adds the runs to the answer. As parameters of the line they are one where they overlap, and what
// else of the face is met at such parameters adds none.
void Search::unite_runs(std::size_t first_hit) {
    if (runs.empty()) return;
    const auto end = [](const LineHit& h) -> const Interval& { return h.lies_in ? h.t_end : h.t; };
    std::sort(runs.begin(), runs.end(),
              [](const LineHit& a, const LineHit& b) { return a.t.lo < b.t.lo; });
    std::vector<LineHit> united;
    for (const LineHit& r : runs) {
        if (united.empty() || end(united.back()).hi < r.t.lo) {
            united.push_back(r);
            continue;
        }
        LineHit& u = united.back();
        u.boundary = u.boundary && r.boundary;
        if (!u.lies_in && r.lies_in) {
            const Interval start = u.t;
            u = r;
            u.t = r.t.lo < start.lo ? r.t : start;
            continue;
        }
        if (r.lies_in && u.t_end.hi < r.t_end.hi) u.t_end = r.t_end;
    }
    auto& hits = answer.hits;
    hits.erase(std::remove_if(hits.begin() + std::ptrdiff_t(first_hit), hits.end(),
                              [&](const LineHit& h) {
                                  return std::any_of(
                                      united.begin(), united.end(), [&](const LineHit& u) {
                                          return u.t.lo <= h.t.hi && h.t.lo <= end(u).hi;
                                      });
                              }),
               hits.end());
    for (LineHit& u : united) keep_hit(line, std::move(u), answer);
}

// Whether the surface's first and last line of constant u (axis 0) or v are one curve, point by
// point, by their data.
bool Search::closed_in(int axis) {
    if (!closed) {
        closed = {true, true};
        const auto& d = face.region.domain();
        for (int k = 0; k < 2; ++k)
            for (const auto& a : face.patches) {
                if ((k == 0 ? a.u0 : a.v0) != d[2 * k]) continue;
                bool matched = false;
                for (const auto& b : face.patches) {
                    if ((k == 0 ? b.u1 : b.v1) != d[2 * k + 1] ||
                        (k == 0 ? a.v0 != b.v0 : a.u0 != b.u0))
                        continue;
                    const auto side = [&](const RationalBezierPatch& s, const std::vector<Q>& c,
                                          int at) { return iso_line(c, s.p, s.q, k == 0, Q(at)); };
                    const auto wa = side(a, a.W, 0), wb = side(b, b.W, 1);
                    matched = wa.size() == wb.size();
                    const std::vector<Q>* const ca[4] = {&a.X, &a.Y, &a.Z, &a.W};
                    const std::vector<Q>* const cb[4] = {&b.X, &b.Y, &b.Z, &b.W};
                    for (int c = 0; matched && c < 4; ++c) {
                        const auto x = side(a, *ca[c], 0), y = side(b, *cb[c], 1);
                        for (std::size_t i = 0; i < x.size(); ++i)
                            matched &= x[i] * wb[0] == y[i] * wa[0];
                    }
                }
                (*closed)[std::size_t(k)] &= matched;
            }
    }
    return (*closed)[std::size_t(axis)];
}

void Search::patch(std::size_t i) {
    const RationalBezierPatch& s = face.patches[i];
    if (box_missed(face.boxes[i], line)) return;
    const PatchLine f = on_patch(s, line);
    std::vector<int> deflated;
    PatchLine g = f;
    for (int side = 0; side < 4; ++side) {
        Q t;
        if ((side < 2 ? g.p : g.q) < 2 || !vanishes_on_side(g, side)) continue;
        if (!side_collapses(f, side, t)) continue;
        pole(s, side, t);
        g.f1 = deflate(g.f1, g.p, g.q, side);
        g.f2 = deflate(g.f2, g.p, g.q, side);
        (side < 2 ? g.p : g.q) -= 1;
        deflated.push_back(side);
    }
    const auto search = [&] {
        return patch_roots(
            to_net(g.p, g.q, g.f1), to_net(g.p, g.q, g.f2), face.areas[i], budget, [&g] {
                return ExactForms{to_bipoly(g.p, g.q, g.f1), to_bipoly(g.p, g.q, g.f2)};
            });
    };
    PatchRoots found = search();
    factored = found.common_factor;
    if (found.common_factor && in_face(s, f, g)) found = search();
    if (found.common_factor) {
        answer.clear = false;
        open(s, f, {Real(0.0), Real(1.0), Real(0.0), Real(1.0)}, "a line in the face");
        return;
    }
    for (const auto& r : found.roots) root(s, f, g, r, deflated);
    for (const auto& b : found.open) {
        answer.clear = false;
        const Real zero(0.0), one(1.0);
        if (b[1] < zero || one < b[0] || b[3] < zero || one < b[2]) continue;
        open(s, f, b, "a tangency, or a line in the face");
    }
}

}  // namespace

void line_hits_nurbs(const PreparedFace& face, int index, const Line& line, long& budget,
                     LineAnswer& answer) {
    Search search{face, index, line, budget, answer, {}, false, {}, {}};
    const std::size_t first_hit = answer.hits.size();
    for (std::size_t i = 0; i < face.patches.size(); ++i) search.patch(i);
    search.unite_runs(first_hit);
}

}  // namespace feeler_oracle
