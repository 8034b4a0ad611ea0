#include "face_pieces.hpp"

#include <algorithm>
#include <cmath>

#include "net.hpp"
#include "trim_image.hpp"

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Piece make_piece(PieceKind kind, int face, int p, int q, HomogeneousNet net) {
    Piece r{kind, face, p, q, std::move(net), {}, {}, false, true};
    for (int k = 0; k < 4; ++k)
        for (const Interval& x : r.net[k]) r.net64[k].push_back(x.outer());
    for (int k = 0; k < 3; ++k) {
        double lo = kInfinity, hi = -kInfinity;
        for (size_t i = 0; i < r.net[k].size(); ++i) {
            const Interval x = divide_positive(r.net[k][i], r.net[3][i]);
            lo = std::min(lo, x.lo.down());
            hi = std::max(hi, x.hi.up());
        }
        r.box[2 * k] = lo;
        r.box[2 * k + 1] = hi;
    }
    constexpr double kFar = 0x1p10;
    double light = kInfinity, heavy = 0;
    for (const Interval64& w : r.net64[3]) {
        light = std::min(light, w.lo);
        heavy = std::max(heavy, w.hi);
    }
    r.far = heavy > kFar * light;
    return r;
}

void set_uv(Piece& piece, const std::array<Q, 4>& uv) {
    piece.uv = uv;
    for (int k = 0; k < 4; ++k) {
        const auto b = double_bounds(uv[k]);
        piece.uv64[k] = {b.first, b.second};
    }
}

// A point near the middle of the part [a, b] of the curve; exactly it where the curve is exact.
std::array<Q, 2> near_middle(const UvCurve& curve, const Q& a, const Q& b) {
    const Q m = (a + b) / Q(2);
    if (curve.exact) {
        const Q w = value_at(curve.exact->W, m);
        return {value_at(curve.exact->X, m) / w, value_at(curve.exact->Y, m) / w};
    }
    const UvCurve rest = part_of(curve, m, Q(1));
    std::array<Q, 2> r;
    for (int k = 0; k < 2; ++k)
        r[k] = to_exact(divide_positive(rest.c[k][0], rest.c[2][0]).middle());
    return r;
}

std::array<Interval64, 2> hull_of(const UvCurve& curve) {
    std::array<Interval64, 2> box{Interval64(kInfinity, -kInfinity),
                                  Interval64(kInfinity, -kInfinity)};
    for (int k = 0; k < 2; ++k)
        for (size_t i = 0; i < curve.c[2].size(); ++i) {
            const Interval64 x = divide_positive(curve.c[k][i], curve.c[2][i]).outer();
            box[k] = {std::min(box[k].lo, x.lo), std::max(box[k].hi, x.hi)};
        }
    return box;
}

struct FaceBuilder {
    const Face& face;
    int index;
    const Region& region;
    FacePieces& out;
    const std::vector<NativePatch>& patches;
    // The arc being added, and the part of its parameter that the curve in hand covers.
    int arc = -1;
    Q arc_from = Q(0), arc_to = Q(1);
    std::vector<Q> lines[2]{};  // distinct ends of patches, sorted

    void add_point(const HomogeneousNet& net, size_t at) {
        HomogeneousNet point;
        for (int k = 0; k < 4; ++k) point[k] = {net[k][at]};
        out.pieces.push_back(make_piece(PieceKind::Point, index, 0, 0, std::move(point)));
    }

    Piece of_arc(Piece piece, const Q& a, const Q& b) const {
        piece.arc = arc;
        piece.t0 = arc_from + a * (arc_to - arc_from);
        piece.t1 = arc_from + b * (arc_to - arc_from);
        return piece;
    }

    const NativePatch* patch_at(const Q& u, const Q& v) const {
        for (const NativePatch& s : patches)
            if (u >= s.map[0].from() && u <= s.map[0].to() && v >= s.map[1].from() &&
                v <= s.map[1].to())
                return &s;
        return nullptr;
    }

    // How far the image under a patch may be off where an enclosed curve may be on the wrong side
    // of the patch's border by its noise: less than 2^-250 of a patch; times a bound on slopes
    // that weights of 1e24 apart leave.
    double noise(const UvCurve& curve, const NativePatch& s) const {
        if (curve.exact || patches.size() == 1) return 0;
        double largest = 0;
        for (int k = 0; k < 3; ++k)
            for (size_t i = 0; i < s.net[3].size(); ++i)
                largest =
                    std::max(largest, std::fabs(divide_positive(s.net[k][i], s.net[3][i]).hi.up()));
        return largest * 0x1p-160;
    }

    void add_images(const NativePatch& s, const UvCurve& curve, const Q& a, const Q& b,
                    bool within) {
        for (TrimImage& image : trim_images(s, part_of(curve, a, b))) {
            if (within) {
                add_point(image.net, 0);
                add_point(image.net, image.net[0].size() - 1);
            }
            Piece piece =
                of_arc(make_piece(PieceKind::Trim, index, image.degree, 0, std::move(image.net)),
                       a + image.a * (b - a), a + image.b * (b - a));
            piece.attained = within;
            const double more = noise(curve, s);
            piece.slack = more > 0 ? next_up(image.slack + more) : image.slack;
            if (within) out.pieces.end()[-1].slack = out.pieces.end()[-2].slack = piece.slack;
            (within ? out.pieces : out.clamped).push_back(std::move(piece));
        }
    }

    // The part [a, b] of a curve, which lies in one closed patch or outside the domain.
    void add_trim(const UvCurve& curve, const Q& a, const Q& b) {
        const auto [u, v] = near_middle(curve, a, b);
        if (const NativePatch* s = patch_at(u, v))
            add_images(*s, curve, a, b, true);
        else
            add_clamped(curve, a, b, u, v);
    }

    // The part [a, b] of a curve, which lies on one side of each knot line and outside the domain,
    // around the point u, v: its image with the parameters clamped to the domain.
    void add_clamped(const UvCurve& curve, const Q& a, const Q& b, const Q& u, const Q& v) {
        const auto& d = region.domain();
        UvCurve part = part_of(curve, a, b);
        const auto clamp = [&](int k, const Q& at, const Q& lo, const Q& hi) {
            if (at >= lo && at <= hi) return at;
            Q to = at < lo ? lo : hi;
            const Interval ito(to.mpq());
            for (size_t i = 0; i < part.c[k].size(); ++i) part.c[k][i] = ito * part.c[2][i];
            if (part.exact) {
                auto& c = k == 0 ? part.exact->X : part.exact->Y;
                for (size_t i = 0; i < c.size(); ++i) c[i] = to * part.exact->W[i];
            }
            return to;
        };
        const Q cu = clamp(0, u, d[0], d[1]), cv = clamp(1, v, d[2], d[3]);
        if (const NativePatch* s = patch_at(cu, cv)) {
            const size_t first = out.clamped.size();
            add_images(*s, part, Q(0), Q(1), false);
            for (size_t i = first; i < out.clamped.size(); ++i) {
                Piece& piece = out.clamped[i];
                const Q from = arc_from + a * (arc_to - arc_from),
                        length = (b - a) * (arc_to - arc_from);
                const Q whole = arc_to - arc_from;
                piece.t0 = from + (piece.t0 - arc_from) / whole * length;
                piece.t1 = from + (piece.t1 - arc_from) / whole * length;
            }
        }
    }

    // The image of a tiny part of a curve that crosses knot lines: enclosed under each patch it
    // touches.
    void add_crossing(const UvCurve& curve, const Q& a, const Q& b) {
        const UvCurve part = part_of(curve, a, b);
        Interval box[2];
        for (int k = 0; k < 2; ++k)
            for (size_t i = 0; i < part.c[2].size(); ++i) {
                const Interval x = divide_positive(part.c[k][i], part.c[2][i]);
                box[k] = i == 0 ? x : hull(box[k], x);
            }
        // Beyond the domain the clamped image alone is left.
        const auto& d = region.domain();
        bool beyond = false;
        for (int k = 0; k < 2; ++k) {
            const Interval lo(d[2 * k].mpq()), hi(d[2 * k + 1].mpq());
            beyond |= box[k].hi < lo.lo || hi.hi < box[k].lo;
        }
        if (beyond)
            for (int k = 0; k < 2; ++k) {
                const Interval lo(d[2 * k].mpq()), hi(d[2 * k + 1].mpq());
                for (Real* end : {&box[k].lo, &box[k].hi}) {
                    if (*end < lo.lo) *end = lo.lo;
                    if (hi.hi < *end) *end = hi.hi;
                }
            }
        for (const NativePatch& s : patches) {
            bool apart = false;
            for (int k = 0; k < 2; ++k) {
                const Interval lo(s.map[k].from().mpq()), hi(s.map[k].to().mpq());
                apart |= box[k].hi < lo.lo || hi.hi < box[k].lo;
            }
            if (apart) continue;
            const auto at = point_at(s, s.map[0].to_square(box[0]), s.map[1].to_square(box[1]));
            HomogeneousNet point;
            for (int k = 0; k < 4; ++k) point[k] = {at[k]};
            Piece piece = of_arc(make_piece(PieceKind::Point, index, 0, 0, std::move(point)), a, b);
            piece.attained = false;
            (beyond ? out.clamped : out.pieces).push_back(std::move(piece));
        }
    }

    void add_curve(const UvCurve& curve) {
        std::vector<Cut> cuts;
        for (int k = 0; k < 2; ++k)
            for (const Q& line : lines[k]) {
                if (curve.exact) {
                    std::vector<Q> g;
                    const auto& c = k == 0 ? curve.exact->X : curve.exact->Y;
                    for (size_t i = 0; i < c.size(); ++i)
                        g.push_back(c[i] - line * curve.exact->W[i]);
                    sign_cuts(g, cuts);
                } else {
                    std::vector<Interval> g;
                    const Interval at(line.mpq());
                    for (size_t i = 0; i < curve.c[k].size(); ++i)
                        g.push_back(curve.c[k][i] - at * curve.c[2][i]);
                    sign_cuts(g, cuts);
                }
            }
        std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.lo < b.lo; });
        Q from(0);
        for (size_t i = 0; i < cuts.size();) {
            Cut merged = cuts[i];
            for (++i; i < cuts.size() && cuts[i].lo <= merged.hi; ++i)
                if (cuts[i].hi > merged.hi) merged.hi = cuts[i].hi;
            if (merged.lo > from) add_trim(curve, from, merged.lo);
            if (merged.lo < merged.hi) add_crossing(curve, merged.lo, merged.hi);
            from = merged.hi;
        }
        if (from < Q(1)) add_trim(curve, from, Q(1));
    }

    // Whether a loop may leave the domain: a curve's control points, or all of an arc's circle.
    bool loops_leave_domain() const {
        const auto& d = region.domain();
        const auto circle_leaves = [&](const Circle& c) {
            for (int k = 0; k < 2; ++k)
                if (c.center[k] - c.radius < d[2 * k] || c.center[k] + c.radius > d[2 * k + 1])
                    return true;
            return false;
        };
        const auto point_leaves = [&](const EndPoint& p) {
            if (const auto* c = std::get_if<CirclePoint>(&p)) return circle_leaves(c->circle);
            const auto& q = std::get<0>(p);
            return q[0] < d[0] || q[0] > d[1] || q[1] < d[2] || q[1] > d[3];
        };
        for (const RegionArc& any : region.arcs()) {
            if (const auto* a = std::get_if<CircularArc>(&any)) {
                if (circle_leaves(a->circle)) return true;
            } else if (const auto* s = std::get_if<Segment>(&any)) {
                if (point_leaves(s->from) || point_leaves(s->to)) return true;
            } else {
                const auto& c = std::get<RationalBezierCurve>(any);
                for (size_t i = 0; i < c.W.size(); ++i)
                    if (c.X[i] < d[0] * c.W[i] || c.X[i] > d[1] * c.W[i] ||
                        c.Y[i] < d[2] * c.W[i] || c.Y[i] > d[3] * c.W[i])
                        return true;
            }
        }
        return false;
    }

    void add_joint(const NativePatch& s, int k, bool upper) {
        const int degree = k == 0 ? s.q : s.p;
        HomogeneousNet net;
        for (int c = 0; c < 4; ++c)
            for (int m = 0; m <= degree; ++m)
                net[c].push_back(s.net[c][k == 0 ? (upper ? s.p : 0) * (s.q + 1) + m
                                                 : m * (s.q + 1) + (upper ? s.q : 0)]);
        std::array<Q, 4> uv = uv_of(s);
        uv[2 * k] = uv[2 * k + 1] = upper ? uv[2 * k + 1] : uv[2 * k];
        const bool regional = !region.whole_domain();
        for (int end = 0; end < 2; ++end) {
            std::array<Q, 4> corner = uv;
            const int other = 2 - 2 * k;
            corner[other] = corner[other + 1] = uv[other + end];
            add_point(net, end == 0 ? 0 : degree);
            set_uv(out.pieces.back(), corner);
            out.pieces.back().regional = regional;
        }
        Piece piece = make_piece(PieceKind::Joint, index, degree, 0, std::move(net));
        set_uv(piece, uv);
        piece.regional = regional;
        piece.patch = &s;
        out.pieces.push_back(std::move(piece));
    }

    static std::array<Q, 4> uv_of(const NativePatch& s) {
        return {s.map[0].from(), s.map[0].to(), s.map[1].from(), s.map[1].to()};
    }

    void run() {
        if (face.loops && face.loops->empty()) return;
        for (const NativePatch& s : patches)
            for (int k = 0; k < 2; ++k) {
                lines[k].push_back(s.map[k].from());
                lines[k].push_back(s.map[k].to());
            }
        for (auto& l : lines) {
            std::sort(l.begin(), l.end());
            l.erase(std::unique(l.begin(), l.end()), l.end());
        }
        const bool borders = region.whole_domain() || loops_leave_domain();
        // Across the knots of a NURBS surface the two sides agree; a poly-curve may jump.
        const bool both = !std::holds_alternative<NurbsSurface>(face.surface);
        for (const NativePatch& s : patches) {
            Piece piece = make_piece(PieceKind::Patch, index, s.p, s.q, s.net);
            set_uv(piece, uv_of(s));
            piece.regional = !region.whole_domain();
            piece.patch = &s;
            out.pieces.push_back(std::move(piece));
            for (int k = 0; k < 2; ++k) {
                const bool first = s.map[k].from() == lines[k].front(),
                           last = s.map[k].to() == lines[k].back();
                if (first ? borders : s.crease[k][0]) add_joint(s, k, false);
                if (last ? borders : both && s.crease[k][1]) add_joint(s, k, true);
            }
        }
        for (const RegionArc& any : region.arcs()) {
            ++arc;
            const UvPieces curves = uv_curves(any);
            for (size_t i = 0; i < curves.pieces.size(); ++i) {
                const UvCurve& curve = curves.pieces[i];
                arc_from = curves.at[i];
                arc_to = curves.at[i + 1];
                out.arcs.push_back({curve.c, hull_of(curve), arc, CGAL::to_double(arc_from),
                                    CGAL::to_double(arc_to)});
                add_curve(curve);
            }
        }
    }
};

}  // namespace

void fill_pieces(const Face& face, int index, FacePieces& out) {
    FaceBuilder{face, index, *out.region, out, out.patches}.run();
}

}  // namespace feeler_oracle
