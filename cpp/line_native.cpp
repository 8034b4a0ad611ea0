#include "line_native.hpp"

#include <algorithm>

#include "distance_pieces.hpp"
#include "interval_trig.hpp"
#include "line_quadric.hpp"
#include "line_roots.hpp"
#include "roots.hpp"

namespace feeler_oracle {
namespace {

// Boxes for one face at most: a tangency that stays open takes them all.
constexpr long kMostBoxes = 4000;

struct Forms {
    Net f1, f2;
    Net along, weight;  // t = along / weight
};

Forms on_patch(const NativePatch& patch, const Vector3& o, const std::array<double, 3>& direction) {
    const Planes planes(direction);
    const Vector3 d = to_vector(direction);
    const Interval length2 = square(d[0]) + square(d[1]) + square(d[2]);
    const Net empty{patch.p, patch.q, {}};
    Forms f{empty, empty, empty, empty};
    for (std::size_t c = 0; c < patch.net[3].size(); ++c) {
        const Interval& w = patch.net[3][c];
        Vector3 x;
        for (int m = 0; m < 3; ++m) x[m] = patch.net[m][c] - o[m] * w;
        f.f1.c.push_back(d[planes.k] * x[planes.i] - d[planes.i] * x[planes.k]);
        f.f2.c.push_back(d[planes.k] * x[planes.j] - d[planes.j] * x[planes.k]);
        f.along.c.push_back(dot(d, x));
        f.weight.c.push_back(length2 * w);
    }
    return f;
}

// On side (axis, end) of the square.
std::vector<Interval> on_side(const Net& n, int axis, int end) {
    std::vector<Interval> r;
    const int last = axis == 0 ? n.q : n.p;
    for (int m = 0; m <= last; ++m)
        r.push_back(n.c[std::size_t(axis == 0 ? (end ? n.p : 0) * (n.q + 1) + m
                                              : m * (n.q + 1) + (end ? n.q : 0))]);
    return r;
}

// Exactly, where all are points.
std::optional<std::vector<Q>> exactly(const std::vector<Interval>& c) {
    std::vector<Q> r;
    for (const Interval& x : c) {
        if (!x.is_point()) return std::nullopt;
        r.push_back(to_exact(x.lo));
    }
    return r;
}

// A form that is 0 on side (axis, end), divided by the distance from it: with n the degree across,
// c_k = g_k (n - k) / n for the end 1, c_k = g_(k-1) k / n for the end 0. Of degree 1 or more
// across again: a constant twice.
Net deflated(const Net& f, int axis, int end) {
    const int n = axis == 0 ? f.p : f.q;
    if (n == 1) {
        const std::vector<Interval> c = on_side(f, axis, 1 - end);
        Net g{f.p, f.q, f.c};
        for (int i = 0; i <= f.p; ++i)
            for (int j = 0; j <= f.q; ++j)
                g.c[std::size_t(i * (f.q + 1) + j)] = c[std::size_t(axis == 0 ? j : i)];
        return g;
    }
    Net g{f.p - (axis == 0), f.q - (axis == 1), {}};
    for (int i = 0; i <= g.p; ++i)
        for (int j = 0; j <= g.q; ++j) {
            const int k = axis == 0 ? i : j;
            const int from_i = i + (axis == 0 && end == 0), from_j = j + (axis == 1 && end == 0);
            g.c.push_back(
                divide_positive(f.c[std::size_t(from_i * (f.q + 1) + from_j)] * Interval(double(n)),
                                Interval(double(end ? n - k : k + 1))));
        }
    return g;
}

// The map, also a little beyond the square.
Interval beyond_square(const ParameterMap& map, const Interval& s) {
    const Interval from(map.from().mpq()), length = Interval(map.to().mpq()) - from;
    if (map.linear()) return from + s * length;
    const Interval cos_half = cos_sin(map.half()).cos;
    const auto part = [&](const Real& x) {
        // Odd in the angle.
        const Interval at(x), cosine = Interval(1.0) - at + at * cos_half,
                              sine = at * map.sin_half();
        if (x.sign() < 0) return -divide_positive(angle_of(cosine, -sine), map.half());
        return divide_positive(angle_of(cosine, sine), map.half());
    };
    return from + Interval(part(s.lo).lo, part(s.hi).hi) * length;
}

class Search {
 public:
    Search(const Core& core, int index, const Line& line, long& budget, LineAnswer& answer)
        : index_(index),
          line_(line),
          budget_(budget),
          answer_(answer),
          surface_(core.model().faces[std::size_t(index)].surface),
          region_(core.face(std::size_t(index)).region),
          pieces_(core.pieces().face(std::size_t(index))) {}

    void run() {
        origin_ = to_vector(line_.origin);
        direction_ = line_.direction;
        if (const auto quadric = quadric_of(surface_))
            if (misses_or_touches(*quadric)) return;
        long own = std::min(budget_, kMostBoxes);
        const long before = own;
        for (const Piece& piece : pieces_.pieces) {
            if (piece.kind != PieceKind::Patch) continue;
            const auto& b = piece.box;
            if (box_missed({Interval64(b[0], b[1]), {b[2], b[3]}, {b[4], b[5]}}, line_)) continue;
            patch(*piece.patch, own);
        }
        budget_ -= before - own;
    }

 private:
    struct Known {
        const NativePatch* patch;
        std::array<Interval, 2> unique;  // in uv
        bool at_cut;
    };

    // Whether the line does not meet the quadric at all. Where it touches it, prepares the search
    // for that point.
    bool misses_or_touches(const Quadric& quadric) {
        Q3 o, d;
        for (int k = 0; k < 3; ++k) {
            o[k] = Q(line_.origin[k]);
            d[k] = Q(line_.direction[k]);
        }
        const Quadratic f = quadric.along(o, d);
        if (sign(f.a) == 0) return sign(f.b) == 0 && sign(f.c) != 0;
        if (sign(f.c) == 0) start_on_ = f;
        const int discriminant = sign(f.b * f.b - Q(4) * f.a * f.c);
        if (discriminant != 0) return discriminant < 0;
        const Q t = -f.b / (Q(2) * f.a);
        if (line_.kind != LineKind::Line &&
            (sign(t) < 0 || (line_.kind == LineKind::Segment && t > Q(1))))
            return true;
        Q3 x;
        std::array<double, 3> normal;
        double largest = 0;
        for (int k = 0; k < 3; ++k) x[k] = o[k] + t * d[k];
        for (int k = 0; k < 3; ++k) {
            Q3 e{Q(0), Q(0), Q(0)};
            e[k] = Q(1);
            normal[k] = double_bounds(quadric.along(x, e).b).first;
            largest = std::max(largest, std::fabs(normal[k]));
        }
        // The tip of a cone, which lines cross; or out of range.
        if (!(largest > 0x1p-500) || !(largest < 0x1p500)) return false;
        for (int k = 0; k < 3; ++k) d[k] = Q(normal[k]);
        const Quadratic across = quadric.along(x, d);
        if (sign(across.b) == 0) return false;
        touch_ = Touch{t, across};
        for (int k = 0; k < 3; ++k) origin_[k] = to_interval(x[k]);
        direction_ = normal;
        return false;
    }

    static bool may_be_zero(const Interval& t) { return t.lo.sign() <= 0 && t.hi.sign() >= 0; }
    // Whether a root of t (a t + b) is 0: the other one, -b / a, is elsewhere if a t + b is not 0.
    static bool is_zero(const Quadratic& f, const Interval& t) {
        return may_be_zero(t) && excludes_zero(to_interval(f.a) * t + to_interval(f.b));
    }

    bool on_border(const NativePatch& s, int axis, int end) const {
        return (end ? s.map[axis].to() : s.map[axis].from()) == region_.domain()[2 * axis + end];
    }
    bool is_cut(const NativePatch& s, int axis, int end) const {
        return !on_border(s, axis, end) && !s.map[axis].linear() && !s.crease[axis][end];
    }

    void patch(const NativePatch& s, long& budget) {
        const Forms f = on_patch(s, origin_, direction_);
        Net g1 = f.f1, g2 = f.f2;
        std::array<std::array<bool, 2>, 2> pole{};
        for (int axis = 0; axis < 2; ++axis)
            for (int end = 0; end < 2; ++end)
                if (!touch_ && passes_pole(s, f, axis, end)) {
                    pole[axis][end] = true;
                    g1 = deflated(g1, axis, end);
                    g2 = deflated(g2, axis, end);
                }
        const PatchRoots found = patch_roots(g1, g2, {0, 1, 0, 1}, budget, {});
        for (const PatchRoot& r : found.roots) root(s, f, g1, g2, r, pole);
        for (const auto& b : found.open) {
            const Real zero(0.0), one(1.0);
            if (b[1] < zero || one < b[0] || b[3] < zero || one < b[2]) continue;
            open(s, f, b, "a tangency, or a line in the face");
        }
    }

    // Whether side (axis, end) is one point, exactly, and on the line; adds the hit.
    bool passes_pole(const NativePatch& s, const Forms& f, int axis, int end) {
        const auto* r = std::get_if<Revolution>(&surface_);
        if (!r || axis != (r->transposed ? 0 : 1)) return false;
        for (const Net* n : {&f.f1, &f.f2})
            for (const Interval& x : on_side(*n, axis, end))
                if (excludes_zero(x)) return false;
        const auto profile = curve_nets(r->profile);
        const CurveNet& c = profile[std::size_t(&s - pieces_.patches.data()) % profile.size()];
        std::vector<Interval> last;
        for (int k = 0; k < 4; ++k) last.push_back(end ? c.net[k].back() : c.net[k].front());
        const auto x = exactly(last);
        if (!x) return false;
        using Q3 = std::array<Q, 3>;
        const auto parallel = [](const Q3& a, const std::array<double, 3>& b) {
            for (int k = 0; k < 3; ++k) {
                const int i = (k + 1) % 3, j = (k + 2) % 3;
                if (a[i] * Q(b[j]) != a[j] * Q(b[i])) return false;
            }
            return true;
        };
        Q3 of_axis, of_line;
        Q along(0), length2(0);
        for (int k = 0; k < 3; ++k) {
            const Q point = (*x)[k] / (*x)[3], d(line_.direction[k]);
            of_axis[k] = point - Q(r->origin[k]);
            of_line[k] = point - Q(line_.origin[k]);
            along += of_line[k] * d;
            length2 += d * d;
        }
        if (!parallel(of_axis, r->axis) || !parallel(of_line, line_.direction)) return false;
        pole_hit(s, axis, end, along / length2);
        return true;
    }

    void pole_hit(const NativePatch& s, int axis, int end, const Q& t) {
        answer_.clear = false;
        const Q at = end ? s.map[axis].to() : s.map[axis].from();
        const ParameterMap& other = s.map[1 - axis];
        const auto side_at = [&](const Q& x) {
            return axis == 0 ? side(region_, at, x) : side(region_, x, at);
        };
        const std::array<Q, 4> flat = axis == 0
                                          ? std::array<Q, 4>{at, at, other.from(), other.to()}
                                          : std::array<Q, 4>{other.from(), other.to(), at, at};
        const Q middle = (other.from() + other.to()) * Q(1, 2);
        bool in = side_at(middle) != Side::Outside;
        if (!in && !loops_clear(region_, flat)) {
            in = side_at(other.from()) != Side::Outside || side_at(other.to()) != Side::Outside;
            if (!in) {
                answer_.open.push_back(
                    {index_, to_interval(t), "a pole, of which a part may be in the face"});
                return;
            }
        }
        if (!in) return;
        LineHit hit;
        hit.face = index_;
        hit.t = to_interval(t);
        hit.boundary = true;
        const double u = double_bounds(axis == 0 ? at : middle).first,
                     v = double_bounds(axis == 0 ? middle : at).first;
        hit.uv = {u, v};
        // One point, whichever patch it is met on.
        for (const LineHit& h : answer_.hits)
            if (h.face == index_ && h.boundary && h.t.lo <= hit.t.hi && hit.t.lo <= h.t.hi) return;
        keep_hit(line_, hit, answer_);
    }

    static std::array<Interval, 2> to_uv(const NativePatch& s, const std::array<Real, 4>& b) {
        return {beyond_square(s.map[0], {b[0], b[1]}), beyond_square(s.map[1], {b[2], b[3]})};
    }

    bool neighbours(const NativePatch& a, const NativePatch& b) const {
        for (int k = 0; k < 2; ++k) {
            const bool same = a.map[k].from() == b.map[k].from(),
                       after = a.map[k].to() == b.map[k].from() && is_cut(a, k, 1),
                       before = a.map[k].from() == b.map[k].to() && is_cut(a, k, 0);
            if (!same && !after && !before) return false;
        }
        return true;
    }

    Interval parameter(const Forms& f, const std::array<Real, 4>& b) const {
        const auto over = [&](const Net& n) {
            return hull(restrict_v(restrict_u(n, b[0], b[1]), b[2], b[3]));
        };
        return divide_positive(over(f.along), over(f.weight));
    }

    // Whether the root is proven to be on the side, given the forms on it.
    static bool root_on_side(const std::vector<Interval>& c1, const std::vector<Interval>& c2,
                             const PatchRoot& r, int axis, const Real& side) {
        const int o = axis == 0 ? 2 : 0;
        const auto x1 = exactly(c1), x2 = exactly(c2);
        if (x1 && x2) return common_root(*x1, *x2, to_exact(r.box[o]), to_exact(r.box[o + 1]));
        const auto zero = [](const std::optional<std::vector<Q>>& x) {
            return x && std::all_of(x->begin(), x->end(), [](const Q& y) { return sign(y) == 0; });
        };
        if (!zero(x1) && !zero(x2)) return false;
        const auto& c = zero(x1) ? c2 : c1;
        if (!(r.unique[2 * axis] <= side) || !(side <= r.unique[2 * axis + 1])) return false;
        const auto sign_at = [&](const Real& t) {
            std::vector<Interval> b = c;
            const Interval at(t);
            for (std::size_t level = 1; level < c.size(); ++level)
                for (std::size_t i = 0; i + level < c.size(); ++i)
                    b[i] = b[i] + at * (b[i + 1] - b[i]);
            return b[0].lo.sign() > 0 ? 1 : b[0].hi.sign() < 0 ? -1 : 0;
        };
        const Real low = Interval(r.unique[o], r.box[o]).middle(),
                   high = Interval(r.box[o + 1], r.unique[o + 1]).middle();
        return sign_at(low) * sign_at(high) < 0;
    }

    void root(const NativePatch& s, const Forms& f, const Net& g1, const Net& g2,
              const PatchRoot& r, const std::array<std::array<bool, 2>, 2>& pole) {
        std::array<Real, 4> local = r.box;
        const Real zero(0.0), one(1.0);
        if (local[1] < zero || one < local[0] || local[3] < zero || one < local[2]) return;
        if (touch_ && !may_be_zero(parameter(f, r.box))) return;
        bool at_cut = false, border = false;
        std::array<bool, 2> exact{};
        for (int axis = 0; axis < 2; ++axis)
            for (int end = 0; end < 2; ++end) {
                const Real& value = end ? one : zero;
                if (value < local[2 * axis] || local[2 * axis + 1] < value) continue;
                if (is_cut(s, axis, end)) {
                    at_cut = true;
                    continue;
                }
                if (pole[axis][end] || !on_border(s, axis, end) ||
                    !root_on_side(on_side(g1, axis, end), on_side(g2, axis, end), r, axis, value)) {
                    open(s, f, r.box, "a hit at the joint of two patches");
                    return;
                }
                local[2 * axis] = local[2 * axis + 1] = value;
                exact[axis] = border = true;
            }
        const auto uv = to_uv(s, local);
        for (const Known& k : known_) {
            if (!(at_cut || k.at_cut) || !neighbours(*k.patch, s)) continue;
            if (k.unique[0].lo <= uv[0].lo && uv[0].hi <= k.unique[0].hi &&
                k.unique[1].lo <= uv[1].lo && uv[1].hi <= k.unique[1].hi)
                return;
        }
        known_.push_back({&s, to_uv(s, r.unique), at_cut});
        std::array<Q, 4> box{to_exact(uv[0].lo), to_exact(uv[0].hi), to_exact(uv[1].lo),
                             to_exact(uv[1].hi)};
        for (int axis = 0; axis < 2; ++axis)
            if (exact[axis])
                box[2 * axis] = box[2 * axis + 1] =
                    local[2 * axis].sign() > 0 ? s.map[axis].to() : s.map[axis].from();
        Side where = Side::Outside;
        if (!classify(box, exact, where)) {
            open(s, f, r.box, "a hit on a loop, as far as can be told");
            return;
        }
        if (where == Side::Outside) return;
        LineHit hit;
        hit.face = index_;
        hit.t = parameter(f, r.box);
        hit.boundary = border || where == Side::Boundary;
        hit.multiplicity = touch_ ? 2 : 1;
        hit.transversal = !touch_;
        hit.tangential = touch_.has_value();
        if (touch_) {
            if (!is_zero(touch_->across, hit.t)) {
                open(s, f, r.box, "a tangency, or a line in the face");
                return;
            }
            // Exact, so that the ends of a ray or segment are decided.
            hit.t = to_interval(touch_->t);
        }
        hit.uv = {uv[0].middle().near(), uv[1].middle().near()};
        if (start_on_ && is_zero(*start_on_, hit.t)) hit.t = Interval(0.0);
        // At a seam that is closed exactly, another view of the same point, perhaps.
        for (const LineHit& h : answer_.hits)
            if (border && h.face == index_ && h.boundary && h.t.lo <= hit.t.hi &&
                hit.t.lo <= h.t.hi) {
                open(s, f, r.box, "two hits at the border of the surface");
                return;
            }
        if (touch_)
            answer_.hits.push_back(std::move(hit));
        else
            keep_hit(line_, hit, answer_);
    }

    // `where` for all of the box, or false; `exact[k]`: coordinate k is the root's, exactly.
    bool classify(const std::array<Q, 4>& box, const std::array<bool, 2>& exact,
                  Side& where) const {
        if (loops_clear(region_, box)) {
            where = side(region_, (box[0] + box[1]) * Q(1, 2), (box[2] + box[3]) * Q(1, 2));
            return true;
        }
        for (int axis = 0; axis < 2; ++axis) {
            if (!exact[axis]) continue;
            for (const auto& any : region_.arcs()) {
                const auto* arc = std::get_if<RationalBezierCurve>(&any);
                if (!arc) continue;
                const auto &c = axis == 0 ? arc->X : arc->Y, &other = axis == 0 ? arc->Y : arc->X;
                bool along = true;
                for (std::size_t k = 0; k < c.size(); ++k)
                    along &= c[k] == box[2 * axis] * arc->W[k];
                if (!along) continue;
                Q lo = other[0] / arc->W[0], hi = other.back() / arc->W.back();
                if (hi < lo) std::swap(lo, hi);
                const int o = axis == 0 ? 2 : 0;
                if (lo <= box[o] && box[o + 1] <= hi) {
                    where = Side::Boundary;
                    return true;
                }
            }
        }
        return false;
    }

    void open(const NativePatch& s, const Forms& f, std::array<Real, 4> box, const char* why) {
        answer_.clear = false;
        const Real zero(0.0), one(1.0);
        for (Real& x : box) {
            if (x < zero) x = zero;
            if (one < x) x = one;
        }
        const Interval u = s.map[0].to_surface({box[0], box[1]}),
                       v = s.map[1].to_surface({box[2], box[3]});
        const std::array<Q, 4> uv{to_exact(u.lo), to_exact(u.hi), to_exact(v.lo), to_exact(v.hi)};
        if (loops_clear(region_, uv) &&
            side(region_, (uv[0] + uv[1]) * Q(1, 2), (uv[2] + uv[3]) * Q(1, 2)) == Side::Outside)
            return;
        Interval t = parameter(f, box);
        if (touch_) {
            if (!may_be_zero(t)) return;
            t = to_interval(touch_->t);
        }
        if (line_.kind != LineKind::Line && t.hi < zero) return;
        if (line_.kind == LineKind::Segment && one < t.lo) return;
        for (auto& o : answer_.open)
            if (o.face == index_ && o.why == why && o.t.lo <= t.hi && t.lo <= o.t.hi) {
                o.t = hull(o.t, t);
                return;
            }
        answer_.open.push_back({index_, t, why});
    }

    int index_;
    const Line& line_;
    long& budget_;
    LineAnswer& answer_;
    const Surface& surface_;
    const Region& region_;
    const FacePieces& pieces_;
    std::vector<Known> known_;
    // What is searched for on the patches: the line, or one across the face through the point where
    // the line touches its quadric.
    struct Touch {
        Q t;               // of the line, exactly
        Quadratic across;  // c = 0
    };
    std::optional<Touch> touch_;
    // Of the line, if it starts on the quadric: c = 0.
    std::optional<Quadratic> start_on_;
    Vector3 origin_;
    std::array<double, 3> direction_{};
};

}  // namespace

void line_hits_native(const Core& core, int index, const Line& line, long& budget,
                      LineAnswer& answer) {
    Search(core, index, line, budget, answer).run();
}

}  // namespace feeler_oracle
