#include "distance_region.hpp"

#include <cmath>

#include "net.hpp"

namespace feeler_oracle {
namespace {

// ---- doubles

// The part of the patch's square that the box's part is, outwards; ends of the square stay exact:
// the region treats the border of the domain specially.
Interval64 in_square64(int level, std::uint64_t index, const Interval64& local) {
    const Interval64 s = Interval64(std::ldexp(1.0, -level)) * (Interval64(double(index)) + local);
    const bool first = index == 0 && local.lo == 0;
    const bool last = level <= kDeepest && index + 1 == std::uint64_t(1) << level && local.hi == 1;
    return {first ? 0.0 : std::max(0.0, s.lo), last ? 1.0 : std::min(1.0, s.hi)};
}

// ---- intervals

// Which of u and v (0, 1) varies over the piece, if one alone does; -1: none, 2: both.
int varies(const Piece& s) {
    if (s.kind == PieceKind::Patch) return 2;
    if (s.kind == PieceKind::Joint) return s.uv[0] == s.uv[1] ? 1 : 0;
    return -1;
}

// The local coordinate and level of parameter k.
struct Along {
    const Interval& local;
    int level;
    std::uint64_t index;
};
Along along(const Piece& s, const DyadicBox& b, int k, const Interval& x, const Interval& y) {
    if (s.kind == PieceKind::Joint || k == 0) return {x, b.lu, b.iu};
    return {y, b.lv, b.iv};
}

// index + local, over 2^level.
Interval in_square(const Along& a) {
    Real index;
    mpfr_set_ui(index.get(), a.index, MPFR_RNDN);
    Interval s = Interval(index) + a.local;
    mpfr_div_2ui(s.lo.get(), s.lo.get(), a.level, MPFR_RNDD);
    mpfr_div_2ui(s.hi.get(), s.hi.get(), a.level, MPFR_RNDU);
    return s;
}

bool linear(const Piece& s) {
    const int moving = varies(s);
    for (int k = 0; k < 2; ++k)
        if ((moving == 2 || moving == k) && !s.patch->map[k].linear()) return false;
    return true;
}

// The exact parameters of a point, where they are linear.
std::array<Q, 2> exact_parameters(const Piece& s, const DyadicBox& b, const Real& x,
                                  const Real& y) {
    const int moving = varies(s);
    std::array<Q, 2> r{s.uv[0], s.uv[2]};
    for (int k = 0; k < 2; ++k) {
        if (moving != 2 && moving != k) continue;
        const Interval ix(x), iy(y);
        const Along a = along(s, b, k, ix, iy);
        Real index, scale;
        mpfr_set_ui(index.get(), a.index, MPFR_RNDN);
        mpfr_set_ui_2exp(scale.get(), 1, -a.level, MPFR_RNDN);
        r[k] = s.uv[2 * k] + (to_exact(index) + to_exact(a.local.lo)) * to_exact(scale) *
                                 (s.uv[2 * k + 1] - s.uv[2 * k]);
    }
    return r;
}

bool in_region(const PieceInRegion& s, const Q& u, const Q& v) {
    return side(*s.face.region, u, v) != Side::Outside;
}

// Of a box without arcs: whether the region holds it, by a point of it. On the border of the
// domain the two sides differ only in whether it counts, and a point of it is taken as it is.
bool holds_middle(const PieceInRegion& s, const std::array<Interval, 2>& box) {
    return in_region(s, to_exact(box[0].middle()), to_exact(box[1].middle()));
}

}  // namespace

std::array<Interval, 2> parameters(const Piece& s, const DyadicBox& b, const Interval& x,
                                   const Interval& y) {
    const int moving = varies(s);
    std::array<Interval, 2> r;
    for (int k = 0; k < 2; ++k)
        r[k] = moving == 2 || moving == k
                   ? s.patch->map[k].to_surface(in_square(along(s, b, k, x, y)))
                   : Interval(s.uv[2 * k].mpq());
    return r;
}

BoxSide region_side(const PieceInRegion& s, const DyadicBox& b, const Interval64& x,
                    const Interval64& y) {
    const Piece& p = s.piece;
    if (!p.regional) return BoxSide::Inside;
    Interval64 uv[2] = {{p.uv64[0].lo, p.uv64[1].hi}, {p.uv64[2].lo, p.uv64[3].hi}};
    const int moving = varies(p);
    if (moving == 2) {
        uv[0] = p.patch->map[0].to_surface64(in_square64(b.lu, b.iu, x));
        uv[1] = p.patch->map[1].to_surface64(in_square64(b.lv, b.iv, y));
    } else if (moving >= 0) {
        uv[moving] = p.patch->map[moving].to_surface64(in_square64(b.lu, b.iu, x));
    }
    return box_side(*s.face.region, uv[0].lo, uv[0].hi, uv[1].lo, uv[1].hi);
}

bool holds(const PieceInRegion& s, const DyadicBox& b, const Real& x, const Real& y) {
    if (!s.piece.regional) return true;
    if (linear(s.piece)) {
        const auto at = exact_parameters(s.piece, b, x, y);
        return in_region(s, at[0], at[1]);
    }
    const auto box = parameters(s.piece, b, Interval(x), Interval(y));
    return clear_of_arcs(s.face.arcs, box[0], box[1]) && holds_middle(s, box);
}

BoxSide exact_side(const PieceInRegion& s, const DyadicBox& b, const Interval& ix,
                   const Interval& iy, const Real& x, const Real& y, bool& held) {
    if (!s.piece.regional) {
        held = true;
        return BoxSide::Inside;
    }
    const auto box = parameters(s.piece, b, ix, iy);
    const bool clear = clear_of_arcs(s.face.arcs, box[0], box[1]);
    held = clear && !linear(s.piece) ? holds_middle(s, box) : holds(s, b, x, y);
    if (!clear) return BoxSide::Mixed;
    return held ? BoxSide::Inside : BoxSide::Outside;
}

}  // namespace feeler_oracle
