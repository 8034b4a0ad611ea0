#include "distance.hpp"

#include <algorithm>
#include <memory>

#include "distance_nets.hpp"

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double clamp_down(double x) { return std::isnan(x) ? -kInfinity : x; }

// Bounds of the objective over the hull box of a piece.
Interval64 hull_bounds(const Objective& o, const std::array<double, 6>& box) {
    Interval64 sum(o.linear ? -o.h : 0.0);
    for (int k = 0; k < 3; ++k) {
        const Interval64 range(box[2 * k], box[2 * k + 1]);
        if (o.linear) {
            sum = sum + Interval64(o.c[k]) * range;
        } else {
            const Interval64 x = range - Interval64(o.c[k]);
            const double least = x.lo > 0 ? x.lo : (x.hi < 0 ? -x.hi : 0.0);
            const double most = std::max(-x.lo, x.hi);
            sum = sum + Interval64(std::max(0.0, next_down(least * least)), next_up(most * most));
        }
    }
    return sum;
}

// A box in the queue of the first phase; `net` is made when it first comes up.
struct Box64 {
    int piece;
    DyadicBox at;
    Net64 net;
    double lo;
    bool inside;  // the region is known to hold the whole box
};

struct BoxMp {
    int piece;
    DyadicBox at;
    NetMp net;
    Real lo;
    bool inside;
};

// Second derivatives of A - tau B over a box: below uu and vv, above |uv|.
struct Curvature {
    double uu, vv, uv;
    bool convex(Degrees d) const {
        if (d.p == 0) return true;
        if (d.q == 0) return uu > 0;
        return uu > 0 && vv > 0 && next_down(uu * vv) > next_up(uv * uv);
    }
    // 0 <= mu, -mu below the least eigenvalue (Gershgorin, if not convex).
    double mu(Degrees d) const {
        if (convex(d)) return 0;
        const double least = d.q == 0 ? uu : std::min(next_down(uu - uv), next_down(vv - uv));
        return std::max(0.0, -least);
    }
    // m > 0 below the least eigenvalue (determinant over trace, if convex).
    double least_eigenvalue(Degrees d) const {
        if (d.q == 0) return uu;
        return next_down(next_down(next_down(uu * vv) - next_up(uv * uv)) / next_up(uu + vv));
    }
};

class Search {
 public:
    Search(const Pieces& model, Objective o, DistanceBudget budget)
        : model_(model), o_(o), budget_(budget) {}

    DistanceAnswer run() {
        first_phase();
        if (best64_ == kInfinity && finals64_.empty()) {
            answer_.lo = answer_.hi = Real(kInfinity);
            answer_.status = DistanceStatus::IntervalOnly;
            return answer_;
        }
        second_phase();
        return answer_;
    }

 private:
    const Piece& piece(int i) const { return model_.pieces[i]; }

    // ---- region

    static Interval64 part(const Interval64& from, const Interval64& to, int level,
                           std::uint64_t index, const Interval64& local) {
        const Interval64 t =
            Interval64(std::ldexp(1.0, -level)) * (Interval64(double(index)) + local);
        const Interval64 x = from + t * (to - from);
        // Exact ends stay exact: the region treats the border of the domain specially.
        const bool first = index == 0 && local.lo == 0;
        const bool last = index + 1 == (std::uint64_t(1) << level) && local.hi == 1;
        return {first ? from.lo : std::max(x.lo, from.lo), last ? to.hi : std::min(x.hi, to.hi)};
    }

    // The region's verdict on a part (local coordinates in the box's unit square) of a box.
    BoxSide region_side(const Piece& s, const DyadicBox& b, const Interval64& x,
                        const Interval64& y) const {
        if (!s.regional) return BoxSide::Inside;
        Interval64 u(s.uv64[0].lo, s.uv64[1].hi), v(s.uv64[2].lo, s.uv64[3].hi);
        if (s.kind == PieceKind::Patch) {
            u = part(s.uv64[0], s.uv64[1], b.lu, b.iu, x);
            v = part(s.uv64[2], s.uv64[3], b.lv, b.iv, y);
        } else if (s.kind == PieceKind::Joint) {
            const bool along_u = !(s.uv[0] == s.uv[1]);
            (along_u ? u : v) =
                part(s.uv64[along_u ? 0 : 2], s.uv64[along_u ? 1 : 3], b.lu, b.iu, x);
        }
        return box_side(*model_.regions[s.face], u.lo, u.hi, v.lo, v.hi);
    }

    static Q exact(const Real& x) {
        mpz_t m;
        mpz_init(m);
        mpq_t q;
        mpq_init(q);
        if (x.sign() != 0) {
            const mpfr_exp_t e = mpfr_get_z_2exp(m, x.get());
            mpq_set_z(q, m);
            e < 0 ? mpq_div_2exp(q, q, -e) : mpq_mul_2exp(q, q, e);
        }
        const Q r(q);
        mpq_clear(q);
        mpz_clear(m);
        return r;
    }

    // The exact parameters of a local point of a box.
    static std::array<Q, 2> parameters(const Piece& s, const DyadicBox& b, const Real& x,
                                       const Real& y) {
        const auto at = [](const Q& from, const Q& to, int level, std::uint64_t index,
                           const Real& local) {
            Real t, scale;
            mpfr_set_ui_2exp(t.get(), index, 0, MPFR_RNDN);
            mpfr_set_ui_2exp(scale.get(), 1, -level, MPFR_RNDN);
            return Q(from + (exact(t) + exact(local)) * exact(scale) * (to - from));
        };
        std::array<Q, 2> r{s.uv[0], s.uv[2]};
        if (s.kind == PieceKind::Patch) {
            r[0] = at(s.uv[0], s.uv[1], b.lu, b.iu, x);
            r[1] = at(s.uv[2], s.uv[3], b.lv, b.iv, y);
        } else if (s.kind == PieceKind::Joint) {
            const int k = s.uv[0] == s.uv[1] ? 1 : 0;
            r[k] = at(s.uv[2 * k], s.uv[2 * k + 1], b.lu, b.iu, x);
        }
        return r;
    }

    // Whether the face holds the point of the box, exactly.
    bool holds(const Piece& s, const DyadicBox& b, const Real& x, const Real& y) const {
        if (!s.regional) return true;
        const auto at = parameters(s, b, x, y);
        return side(*model_.regions[s.face], at[0], at[1]) != Side::Outside;
    }

    // The region's verdict on a part of a box (local coordinates), like box_side, but not limited
    // to the resolution of doubles: where no arc meets the part, the side of the point (x, y) of it
    // is that of all of it. `held`: whether the region holds that point.
    BoxSide exact_side(const Piece& s, const DyadicBox& b, const Interval& ix, const Interval& iy,
                       const Real& x, const Real& y, bool& held) const {
        held = holds(s, b, x, y);
        if (!s.regional) return BoxSide::Inside;
        const auto low = parameters(s, b, ix.lo, iy.lo), high = parameters(s, b, ix.hi, iy.hi);
        const auto span = [](const Q& lo, const Q& hi) {
            return hull(Interval(lo.mpq()), Interval(hi.mpq()));
        };
        if (!clear_of_arcs(model_.arcs[s.face], span(low[0], high[0]), span(low[1], high[1])))
            return BoxSide::Mixed;
        return held ? BoxSide::Inside : BoxSide::Outside;
    }

    // ---- phase 1: doubles

    static double bound64(const Net64& n) {
        double lo = kInfinity;
        for (size_t i = 0; i < n.a.size(); ++i) {
            const double a = next_down(n.a[i] - n.ra);
            const double b = a >= 0 ? next_up(n.b[i] + n.rb) : next_down(n.b[i] - n.rb);
            if (b <= 0) return -kInfinity;
            lo = std::min(lo, next_down(a / b));
        }
        return clamp_down(lo);
    }

    static double value_up64(double a, double ra, double b, double rb) {
        const double high = next_up(a + ra);
        const double below = high >= 0 ? next_down(b - rb) : next_up(b + rb);
        return below > 0 ? next_up(high / below) : kInfinity;
    }

    void lower_best64(double value, int index) {
        if (value < best64_) {
            best64_ = value;
            answer_.face = piece(index).face;
            best_kind_ = piece(index).kind;
        }
    }

    void corners64(const Box64& b, Degrees d) {
        const Piece& s = piece(b.piece);
        if (!s.attained || !(b.inside || !s.regional)) return;
        for (int i : {0, d.p})
            for (int j : {0, d.q}) {
                const size_t k = d.index(i, j);
                lower_best64(value_up64(b.net.a[k], b.net.ra, b.net.b[k], b.net.rb), b.piece);
            }
    }

    // Coefficients of a difference scheme of A - T B: T is the same number in all of them, so the
    // differences are formed first. `weight`: sum of magnitudes of the scheme's factors.
    static Interval64 difference64(double da, double db, double ra, double rb, double weight,
                                   double ma, double mb, const Interval64& t) {
        // Each difference is a sum of at most 4 terms: 3 roundings of at most weight max 2^-53
        // each.
        const double ea = next_up(weight * next_up(ra + ma * 0x1p-51));
        const double eb = next_up(weight * next_up(rb + mb * 0x1p-51));
        return Interval64(next_down(da - ea), next_up(da + ea)) -
               t * Interval64(next_down(db - eb), next_up(db + eb));
    }

    static double magnitude(const std::vector<double>& c) {
        double m = 0;
        for (double x : c) m = std::max(m, std::fabs(x));
        return m;
    }

    // Whether a first difference of A - T B along the direction has a strict sign throughout.
    static bool monotone64(const Net64& n, Degrees d, bool along_u, const Interval64& t, double ma,
                           double mb) {
        if ((along_u ? d.p : d.q) == 0) return false;
        const size_t step = along_u ? d.q + 1 : 1;
        bool up = true, down = true;
        for (int i = 0; i <= d.p - (along_u ? 1 : 0); ++i)
            for (int j = 0; j <= d.q - (along_u ? 0 : 1); ++j) {
                const size_t k = d.index(i, j);
                const Interval64 x = difference64(n.a[k + step] - n.a[k], n.b[k + step] - n.b[k],
                                                  n.ra, n.rb, 2, ma, mb, t);
                up &= x.lo > 0;
                down &= x.hi < 0;
                if (!up && !down) return false;
            }
        return true;
    }

    static Curvature curvature64(const Net64& n, Degrees d, const Interval64& t, double ma,
                                 double mb) {
        Curvature r{kInfinity, kInfinity, 0};
        const auto second = [&](size_t k, size_t step) {
            return difference64(n.a[k + 2 * step] - 2 * n.a[k + step] + n.a[k],
                                n.b[k + 2 * step] - 2 * n.b[k + step] + n.b[k], n.ra, n.rb, 4, ma,
                                mb, t)
                .lo;
        };
        const size_t w = d.q + 1;
        for (int i = 0; i + 2 <= d.p; ++i)
            for (int j = 0; j <= d.q; ++j) r.uu = std::min(r.uu, second(d.index(i, j), w));
        for (int i = 0; i <= d.p; ++i)
            for (int j = 0; j + 2 <= d.q; ++j) r.vv = std::min(r.vv, second(d.index(i, j), 1));
        for (int i = 0; i < d.p; ++i)
            for (int j = 0; j < d.q; ++j) {
                const size_t k = d.index(i, j);
                const Interval64 x = difference64(n.a[k + w + 1] - n.a[k + w] - n.a[k + 1] + n.a[k],
                                                  n.b[k + w + 1] - n.b[k + w] - n.b[k + 1] + n.b[k],
                                                  n.ra, n.rb, 4, ma, mb, t);
                r.uv = std::max(r.uv, std::max(-x.lo, x.hi));
            }
        return finish(r, d);
    }

    // Differences to derivatives.
    static Curvature finish(Curvature r, Degrees d) {
        r.uu = d.p < 2 ? 0 : next_down(r.uu * (d.p * (d.p - 1)));
        r.vv = d.q < 2 ? 0 : next_down(r.vv * (d.q * (d.q - 1)));
        r.uv = next_up(r.uv * (d.p * d.q));
        return r;
    }

    // The direction in which A - t B bends most (with some weight on its slope, for boxes that
    // shrink only to get clear of the region's boundary).
    static bool split_along_u(const std::vector<double>& h, Degrees d, const DyadicBox& at) {
        if (d.q == 0) return true;
        if (d.p == 0) return false;
        constexpr double kSlopeWeight = 1.0 / 16;
        constexpr int kMostUneven = 40;
        double u = 0, v = 0;
        const size_t w = d.q + 1;
        for (int i = 0; i <= d.p; ++i)
            for (int j = 0; j <= d.q; ++j) {
                const size_t k = d.index(i, j);
                if (i < d.p) u = std::max(u, kSlopeWeight * d.p * std::fabs(h[k + w] - h[k]));
                if (j < d.q) v = std::max(v, kSlopeWeight * d.q * std::fabs(h[k + 1] - h[k]));
                if (i + 2 <= d.p)
                    u = std::max(u,
                                 d.p * (d.p - 1) * std::fabs(h[k + 2 * w] - 2 * h[k + w] + h[k]));
                if (j + 2 <= d.q)
                    v = std::max(v, d.q * (d.q - 1) * std::fabs(h[k + 2] - 2 * h[k + 1] + h[k]));
            }
        if (at.lu >= kDeepest || at.lu > at.lv + kMostUneven) return false;
        if (at.lv >= kDeepest || at.lv > at.lu + kMostUneven) return true;
        return u > v || (u == v && at.lu <= at.lv);
    }

    static bool deepest(const DyadicBox& at, Degrees d) {
        return (d.p == 0 || at.lu >= kDeepest) && (d.q == 0 || at.lv >= kDeepest);
    }

    // Trim curves first: their points need no decision of the region, so that they give a tight
    // upper bound before any box is put to it (a box along the domain's border, which a loop
    // follows but for rounding, would otherwise be cut to pieces in vain).
    void first_phase() {
        for (size_t i = 0; i < model_.pieces.size(); ++i) {
            const Piece& s = piece(int(i));
            if (s.kind == PieceKind::Point && s.attained && !s.regional)
                lower_best64(hull_bounds(o_, s.box).hi, int(i));
        }
        const auto on_trims = [](const Piece& s) { return s.kind == PieceKind::Trim; };
        first_phase([&](const Piece& s) { return on_trims(s); });
        first_phase([&](const Piece& s) { return !on_trims(s); });
    }

    template <class Filter>
    void first_phase(Filter wanted) {
        using Item = std::unique_ptr<Box64>;
        const auto later = [](const Item& a, const Item& b) { return a->lo > b->lo; };
        std::vector<Item> queue;
        const auto push = [&](Item b) {
            if (b->lo > best64_) return;
            queue.push_back(std::move(b));
            std::push_heap(queue.begin(), queue.end(), later);
        };
        for (size_t i = 0; i < model_.pieces.size(); ++i) {
            const Piece& s = piece(int(i));
            if (!wanted(s)) continue;
            queue.push_back(std::make_unique<Box64>(
                Box64{int(i), {}, {}, hull_bounds(o_, s.box).lo, !s.regional}));
        }
        std::make_heap(queue.begin(), queue.end(), later);
        while (!queue.empty()) {
            std::pop_heap(queue.begin(), queue.end(), later);
            Item b = std::move(queue.back());
            queue.pop_back();
            if (b->lo > best64_) break;
            const Piece& s = piece(b->piece);
            const Degrees d = objective_degrees(o_, s);
            if (b->net.a.empty()) {
                b->net = objective_net64(o_, s);
                b->lo = std::max(b->lo, bound64(b->net));
                ++answer_.nodes64;
                corners64(*b, d);
                push(std::move(b));
                continue;
            }
            const double ma = magnitude(b->net.a), mb = magnitude(b->net.b);
            const Interval64 t(b->lo, best64_);
            const bool bounded = std::isfinite(b->lo) && best64_ < kInfinity;
            if (bounded &&
                (monotone64(b->net, d, true, t, ma, mb) || monotone64(b->net, d, false, t, ma, mb)))
                continue;
            if (!b->inside) {
                BoxSide where = region_side(s, b->at, {0, 1}, {0, 1});
                if (where == BoxSide::Mixed) {
                    // A loop may follow the border of the domain but for rounding: box_side cannot
                    // tell then. Joints are few; of patches only a point that would help is asked.
                    const Real half(0.5), none(0.0);
                    const Interval unit(none, Real(1.0));
                    const double value = value_up64(*b, d, 0.5, 0.5);
                    bool held = false;
                    if (s.kind == PieceKind::Joint)
                        where = exact_side(s, b->at, unit, Interval(none), half, none, held);
                    else if (s.kind == PieceKind::Patch && value < best64_)
                        held = holds(s, b->at, half, half);
                    if (held) lower_best64(value, b->piece);
                }
                if (where == BoxSide::Outside) continue;
                if (where == BoxSide::Inside) {
                    b->inside = true;
                    corners64(*b, d);
                }
            }
            // No more to gain in doubles: the gap is of the size of the radii.
            const double least_b =
                std::max(0.0, *std::min_element(b->net.b.begin(), b->net.b.end()) - b->net.rb);
            constexpr double kNoise = 16;
            const bool noise =
                bounded &&
                best64_ - b->lo <=
                    kNoise *
                        (b->net.ra + std::max(std::fabs(b->lo), std::fabs(best64_)) * b->net.rb) /
                        least_b;
            if (noise || deepest(b->at, d) || (d.p == 0 && d.q == 0) ||
                answer_.nodes64 >= budget_.nodes64 ||
                (bounded && curvature64(b->net, d, t, ma, mb).convex(d))) {
                if (s.attained && b->inside) sharpen64(*b, d);
                finals64_.push_back(std::move(b));
                continue;
            }
            std::vector<double> h(b->net.a);
            if (bounded)
                for (size_t i = 0; i < h.size(); ++i) h[i] -= best64_ * b->net.b[i];
            const bool along_u = split_along_u(h, d, b->at);
            Item left = std::make_unique<Box64>(
                Box64{b->piece, b->at.half(along_u, false), {}, 0, b->inside});
            Item right = std::make_unique<Box64>(
                Box64{b->piece, b->at.half(along_u, true), {}, 0, b->inside});
            split64(b->net, d, along_u, left->net, right->net);
            for (Item* half : {&left, &right}) {
                (*half)->lo = std::max(b->lo, bound64((*half)->net));
                ++answer_.nodes64;
                corners64(**half, d);
                push(std::move(*half));
            }
        }
    }

    // Lowers the upper bound to (nearly) the box's least value.
    void sharpen64(const Box64& b, Degrees d) {
        if (d.p == 0 && d.q == 0) return;
        std::vector<double> h(b.net.a);
        const double t = best64_ < kInfinity ? best64_ : b.lo;
        for (size_t i = 0; i < h.size(); ++i) h[i] -= t * b.net.b[i];
        const Newton64 at = newton64(h, d, 0.5, 0.5);
        lower_best64(value_up64(b, d, at.x, at.y), b.piece);
    }

    // Above the value at a local point.
    static double value_up64(const Box64& b, Degrees d, double x, double y) {
        // de Casteljau: each of the p + q levels rounds three times; twice that is allowed for.
        const double errors = 8 * (d.p + d.q + 1) * 0x1p-53;
        return value_up64(
            value64(b.net.a, d, x, y), next_up(b.net.ra + errors * magnitude(b.net.a)),
            value64(b.net.b, d, x, y), next_up(b.net.rb + errors * magnitude(b.net.b)));
    }

    static double value64(std::vector<double> b, Degrees d, double x, double y) {
        const int w = d.q + 1;
        for (int k = d.p; k >= 1; --k)
            for (int i = 0; i < k; ++i)
                for (int j = 0; j < w; ++j)
                    b[i * w + j] = (1 - x) * b[i * w + j] + x * b[(i + 1) * w + j];
        for (int k = d.q; k >= 1; --k)
            for (int j = 0; j < k; ++j) b[j] = (1 - y) * b[j] + y * b[j + 1];
        return b[0];
    }

    // ---- phase 2: MPFR

    void lower_best(const Real& value, const Piece& s) {
        if (value < best_) {
            best_ = value;
            answer_.face = s.face;
            best_kind_ = s.kind;
        }
    }

    static Real bound(const NetMp& n) {
        Real lo(kInfinity);
        for (size_t i = 0; i < n.a.size(); ++i) {
            const Real& a = n.a[i].lo;
            const Real q = div_down(a, a.sign() >= 0 ? n.b[i].hi : n.b[i].lo);
            if (q < lo) lo = q;
        }
        return lo;
    }

    void corners(const BoxMp& b, Degrees d) {
        const Piece& s = piece(b.piece);
        if (!s.attained || !(b.inside || !s.regional)) return;
        for (int i : {0, d.p})
            for (int j : {0, d.q}) {
                const size_t k = d.index(i, j);
                lower_best(divide_positive(b.net.a[k], b.net.b[k]).hi, s);
            }
    }

    static bool monotone(const NetMp& n, Degrees d, bool along_u, const Interval& t) {
        if ((along_u ? d.p : d.q) == 0) return false;
        const size_t step = along_u ? d.q + 1 : 1;
        bool up = true, down = true;
        for (int i = 0; i <= d.p - (along_u ? 1 : 0); ++i)
            for (int j = 0; j <= d.q - (along_u ? 0 : 1); ++j) {
                const size_t k = d.index(i, j);
                const Interval x = n.a[k + step] - n.a[k] - t * (n.b[k + step] - n.b[k]);
                up &= x.lo.sign() > 0;
                down &= x.hi.sign() < 0;
                if (!up && !down) return false;
            }
        return true;
    }

    static Curvature curvature(const NetMp& n, Degrees d, const Interval& t) {
        Curvature r{kInfinity, kInfinity, 0};
        const auto second = [&](const std::vector<Interval>& c, size_t k, size_t step) {
            const Interval& m = c[k + step];
            return c[k + 2 * step] + c[k] - (m + m);
        };
        const size_t w = d.q + 1;
        for (int i = 0; i + 2 <= d.p; ++i)
            for (int j = 0; j <= d.q; ++j) {
                const size_t k = d.index(i, j);
                r.uu = std::min(r.uu, (second(n.a, k, w) - t * second(n.b, k, w)).lo.down());
            }
        for (int i = 0; i <= d.p; ++i)
            for (int j = 0; j + 2 <= d.q; ++j) {
                const size_t k = d.index(i, j);
                r.vv = std::min(r.vv, (second(n.a, k, 1) - t * second(n.b, k, 1)).lo.down());
            }
        const auto mixed = [&](const std::vector<Interval>& c, size_t k) {
            return (c[k + w + 1] + c[k]) - (c[k + w] + c[k + 1]);
        };
        for (int i = 0; i < d.p; ++i)
            for (int j = 0; j < d.q; ++j) {
                const size_t k = d.index(i, j);
                const Interval x = mixed(n.a, k) - t * mixed(n.b, k);
                r.uv = std::max(r.uv, std::max(-x.lo.down(), x.hi.up()));
            }
        return finish(r, d);
    }

    // A - t B in doubles, scaled by a power of two to about 1: keeps full relative accuracy where
    // A is almost a multiple of B.
    static std::vector<double> scaled_difference(const NetMp& n, const Real& t, long& exponent) {
        std::vector<Real> h(n.a.size());
        exponent = 0;
        bool any = false;
        for (size_t i = 0; i < h.size(); ++i) {
            h[i] = (n.a[i] - Interval(t) * n.b[i]).middle();
            if (h[i].sign() == 0) continue;
            const long e = mpfr_get_exp(h[i].get());
            if (!any || e > exponent) exponent = e;
            any = true;
        }
        std::vector<double> r;
        for (Real& x : h) {
            mpfr_mul_2si(x.get(), x.get(), -exponent, MPFR_RNDN);
            r.push_back(x.near());
        }
        return r;
    }

    enum class Verdict { Gone, Settled, Final, Open };

    // Applies items 3 and 4 of the header to a box. Gone: holds no minimiser. Settled: its lower
    // bound is within the tolerance of best_. Final: nothing more can be learnt by splitting.
    Verdict close(BoxMp& b, Degrees d) {
        const Piece& s = piece(b.piece);
        const Interval range(b.lo, best_);
        const Curvature c = curvature(b.net, d, range);
        const double mu = c.mu(d);
        Real least_b = b.net.b[0].lo;
        for (const Interval& x : b.net.b)
            if (x.lo < least_b) least_b = x.lo;
        {
            // The loss mu |y - x|^2 / 2 <= mu is worth the trouble only if it beats the bound so
            // far.
            const Real gap = mul_up(sub_up(best_, b.lo), least_b);
            if (!(Real(mu) < gap)) return Verdict::Open;
        }
        // A foot by Newton's iteration; none of this needs to be right.
        long exponent = 0;
        std::vector<double> h = scaled_difference(b.net, best_, exponent);
        Newton64 foot = newton64(h, d, 0.5, 0.5);
        Real x(foot.x), y(foot.y);
        Jet a = evaluate_net(b.net.a, d, x, y), w = evaluate_net(b.net.b, d, x, y);
        h = scaled_difference(b.net, divide_positive(a.f, w.f).hi, exponent);
        foot = newton64(h, d, foot.x, foot.y);
        x = Real(foot.x), y = Real(foot.y);
        double last = kInfinity;
        constexpr int kSteps = 16;            // each gains about 15 digits
        constexpr double kEnough = 0x1p-280;  // of the box's side
        Real t;
        for (int step = 0;; ++step) {
            a = evaluate_net(b.net.a, d, x, y);
            w = evaluate_net(b.net.b, d, x, y);
            t = divide_positive(a.f, w.f).hi;
            if (step == kSteps) break;
            const auto slope = [&](const Interval& da, const Interval& dw) {
                Real g = (da - Interval(t) * dw).middle();
                mpfr_mul_2si(g.get(), g.get(), -exponent, MPFR_RNDN);
                return g.near();
            };
            const double gu = slope(a.u, w.u), gv = slope(a.v, w.v);
            const auto at_end = [](const Real& z, double g) {
                return (z.sign() <= 0 && g > 0) || (mpfr_cmp_ui(z.get(), 1) >= 0 && g < 0);
            };
            const bool free_u = d.p > 0 && !at_end(x, gu), free_v = d.q > 0 && !at_end(y, gv);
            double dx = 0, dy = 0;
            const double det = foot.uu * foot.vv - foot.uv * foot.uv;
            if (free_u && free_v) {
                if (!(det > 0)) break;
                dx = (-gu * foot.vv + gv * foot.uv) / det;
                dy = (-gv * foot.uu + gu * foot.uv) / det;
            } else {
                if (free_u) dx = -gu / foot.uu;
                if (free_v) dy = -gv / foot.vv;
            }
            const double size = std::max(std::fabs(dx), std::fabs(dy));
            if (!std::isfinite(dx) || !std::isfinite(dy) || !(size > kEnough) || !(size < 1) ||
                size > 0.5 * last)
                break;
            last = size;
            const auto move = [](Real& z, double dz) {
                mpfr_add_d(z.get(), z.get(), dz, MPFR_RNDN);
                if (z.sign() < 0) z = Real(0.0);
                if (mpfr_cmp_ui(z.get(), 1) > 0) z = Real(1.0);
            };
            move(x, dx);
            move(y, dy);
        }
        // Item 3, with curvature over T: t may exceed best_ by far only if the box is above it
        // anyway.
        const Interval it(t);
        const Interval gu = a.u - it * w.u, gv = a.v - it * w.v;
        const auto reach = [](const Real& z) {  // the farthest |y - x| in [0, 1]
            const Real other = sub_up(Real(1.0), z);
            return z < other ? other : z;
        };
        const auto size = [](const Interval& g) {
            Real minus;
            mpfr_neg(minus.get(), g.lo.get(), MPFR_RNDU);
            return minus < g.hi ? g.hi : minus;
        };
        // The least of g (y - x) over y in [0, 1].
        const auto least_linear = [](const Interval& g, const Real& z) {
            const Interval to_one(sub_down(Real(1.0), z), sub_up(Real(1.0), z));
            const Real down = (g * -Interval(z)).lo, up = (g * to_one).lo;
            Real least = down < up ? down : up;
            return least.sign() > 0 ? Real(0.0) : least;
        };
        Real least = (a.f - it * w.f).lo;
        if (d.p > 0) least = add_down(least, least_linear(gu, x));
        if (d.q > 0) least = add_down(least, least_linear(gv, y));
        const bool covered = t <= best_ || c.uu == kInfinity;
        const Curvature ct = covered ? c : curvature(b.net, d, Interval(b.lo, t));
        const double mu_t = ct.mu(d);
        if (mu_t > 0) {
            Real square = mul_up(reach(x), reach(x));
            if (d.q > 0) square = add_up(square, mul_up(reach(y), reach(y)));
            least = sub_down(least, mul_up(Real(mu_t), square));  // twice what is needed
        }
        Real lo = t;
        if (least.sign() < 0) lo = add_down(t, div_down(least, least_b));
        if (b.lo < lo) b.lo = lo;
        if (best_ < b.lo) return Verdict::Gone;

        // Is x on the face?
        if (!s.regional || b.inside) {
            if (s.attained) lower_best(t, s);
        } else if (ct.convex(d) && d.p > 0) {
            // Item 4.
            const Real m(ct.least_eigenvalue(d));
            const Real slack = lo < t ? sub_up(t, lo) : Real(0.0);
            Real push = add_up(size(gu), mul_up(slack, size(w.u)));
            if (d.q > 0) push = add_up(push, add_up(size(gv), mul_up(slack, size(w.v))));
            const Real radius = m.sign() > 0 ? div_up(push, m) : Real(1.0);
            bool held = false;
            const auto around = [&radius](const Real& z, bool free) {
                if (!free) return Interval(z);
                const Real below = sub_down(z, radius), above = add_up(z, radius);
                const Real zero(0.0), one(1.0);
                return Interval(below < zero ? zero : below, one < above ? one : above);
            };
            const BoxSide where =
                exact_side(s, b.at, around(x, d.p > 0), around(y, d.q > 0), x, y, held);
            if (where == BoxSide::Outside) return Verdict::Gone;
            if (held) lower_best(t, s);
            // The region's boundary passes within the radius: not worth resolving further.
            constexpr double kUnresolved = 0x1p-160;
            if (where == BoxSide::Mixed && !held && radius < Real(kUnresolved))
                return Verdict::Final;
        }
        return settled(b.lo) ? Verdict::Settled : Verdict::Open;
    }

    // The tolerance on the objective at a value: 2 d w for squares of d, w the width asked of d.
    Real tolerance(const Real& value) const {
        Real width(model_.size);
        mpfr_div_2ui(width.get(), width.get(), kWidthBits, MPFR_RNDN);
        if (o_.linear) return width;
        Real d;
        if (value.sign() > 0) mpfr_sqrt(d.get(), value.get(), MPFR_RNDD);
        return mul_down(d < width ? width : d, width);
    }
    bool near_enough(const Real& lo, const Real& hi) const {
        return !(add_up(lo, tolerance(hi)) < hi);
    }
    bool settled(const Real& lo) const { return near_enough(lo, best_); }

    // Whether each box can be cut into parts that hold no minimiser or are convex.
    bool isolated(std::vector<std::unique_ptr<BoxMp>> boxes) const {
        if (!mpfr_number_p(best_.get())) return false;
        constexpr int kParts = 200;
        for (int count = 0; !boxes.empty(); ++count) {
            const auto b = std::move(boxes.back());
            boxes.pop_back();
            const Degrees d = objective_degrees(o_, piece(b->piece));
            if (best_ < b->lo || (d.p == 0 && d.q == 0)) continue;
            const Interval range(b->lo, best_);
            if (monotone(b->net, d, true, range) || monotone(b->net, d, false, range)) continue;
            if (curvature(b->net, d, range).convex(d)) continue;
            if (count > kParts || deepest(b->at, d)) return false;
            for (auto& half : halves(*b, d)) boxes.push_back(std::move(half));
        }
        return true;
    }

    std::array<std::unique_ptr<BoxMp>, 2> halves(const BoxMp& b, Degrees d) const {
        long exponent = 0;
        const Real& t = mpfr_number_p(best_.get()) ? best_ : b.lo;
        const bool along_u = split_along_u(scaled_difference(b.net, t, exponent), d, b.at);
        std::array<std::unique_ptr<BoxMp>, 2> r;
        for (int k = 0; k < 2; ++k)
            r[k] = std::make_unique<BoxMp>(
                BoxMp{b.piece, b.at.half(along_u, k == 1), {}, b.lo, b.inside});
        split(b.net, d, along_u, r[0]->net, r[1]->net);
        for (auto& half : r) {
            const Real lo = bound(half->net);
            if (half->lo < lo) half->lo = lo;
        }
        return r;
    }

    void second_phase() {
        using Item = std::unique_ptr<BoxMp>;
        const auto later = [](const Item& a, const Item& b) { return b->lo < a->lo; };
        std::vector<Item> queue;
        best_ = Real(best64_);
        Real floor(kInfinity);  // least bound of the boxes that are closed
        bool open = false;      // whether a box was left without a proof of a single minimiser
        const auto keep = [&floor](const Real& lo) {
            if (lo < floor) floor = lo;
        };
        std::sort(finals64_.begin(), finals64_.end(),
                  [](const auto& a, const auto& b) { return a->lo < b->lo; });
        size_t next = 0;
        const auto push = [&](Item b) {
            if (best_ < b->lo) return;
            queue.push_back(std::move(b));
            std::push_heap(queue.begin(), queue.end(), later);
        };
        for (;;) {
            // Boxes of the first phase join when they become the least: their nets are made then.
            while (next < finals64_.size() &&
                   (queue.empty() || Real(finals64_[next]->lo) <= queue.front()->lo)) {
                const Box64& f = *finals64_[next++];
                if (best_ < Real(f.lo)) continue;
                const Piece& s = piece(f.piece);
                Item b = std::make_unique<BoxMp>(
                    BoxMp{f.piece, f.at, objective_net(o_, s, f.at), Real(f.lo), f.inside});
                const Real lo = bound(b->net);
                if (b->lo < lo) b->lo = lo;
                ++answer_.nodes;
                corners(*b, objective_degrees(o_, s));
                push(std::move(b));
            }
            if (queue.empty()) break;
            std::pop_heap(queue.begin(), queue.end(), later);
            Item b = std::move(queue.back());
            queue.pop_back();
            if (best_ < b->lo) continue;
            const Piece& s = piece(b->piece);
            const Degrees d = objective_degrees(o_, s);
            if (settled(b->lo)) {
                // All other boxes lie above this bound; whether the minimiser is isolated is asked
                // of those that may hold one.
                keep(b->lo);
                queue.push_back(std::move(b));
                open = !isolated(std::move(queue));
                break;
            }
            if (d.p == 0 && d.q == 0) {
                // Attained points lowered best_ to their own upper end already.
                if (!s.regional || b->inside) {
                    if (s.attained) lower_best(divide_positive(b->net.a[0], b->net.b[0]).hi, s);
                    keep(b->lo);
                } else if (holds(s, b->at, Real(0.0), Real(0.0))) {
                    lower_best(divide_positive(b->net.a[0], b->net.b[0]).hi, s);
                    keep(b->lo);
                }
                continue;
            }
            if (answer_.nodes >= budget_.nodes) {
                keep(b->lo);
                open = true;
                break;
            }
            const Interval range(b->lo, best_);
            const bool bounded = mpfr_number_p(best_.get());
            if (bounded && (monotone(b->net, d, true, range) || monotone(b->net, d, false, range)))
                continue;
            if (!b->inside) {
                BoxSide where = region_side(s, b->at, {0, 1}, {0, 1});
                if (where == BoxSide::Mixed) {
                    const Interval unit(Real(0.0), Real(1.0)), none(0.0);
                    bool held = false;
                    where = exact_side(s, b->at, unit, d.q > 0 ? unit : none, Real(0.5),
                                       Real(d.q > 0 ? 0.5 : 0.0), held);
                }
                if (where == BoxSide::Outside) continue;
                if (where == BoxSide::Inside) {
                    b->inside = true;
                    corners(*b, d);
                }
            }
            const Verdict verdict = bounded ? close(*b, d) : Verdict::Open;
            if (verdict == Verdict::Gone) continue;
            if (verdict != Verdict::Open || deepest(b->at, d)) {
                keep(b->lo);
                open |= verdict == Verdict::Open;
                continue;
            }
            for (auto& half : halves(*b, d)) {
                ++answer_.nodes;
                corners(*half, d);
                push(std::move(half));
            }
        }
        answer_.hi = best_;
        answer_.lo = floor < best_ ? floor : best_;
        answer_.status = DistanceStatus::Regular;
        if (!near_enough(answer_.lo, best_))
            answer_.status = DistanceStatus::Budget;
        else if (open)
            answer_.status = DistanceStatus::IntervalOnly;
        else if (best_kind_ != PieceKind::Patch)
            answer_.status = DistanceStatus::EdgeOrCorner;
    }

    const Pieces& model_;
    const Objective o_;
    const DistanceBudget budget_;
    DistanceAnswer answer_;
    std::vector<std::unique_ptr<Box64>> finals64_;
    double best64_ = kInfinity;
    Real best_;
    PieceKind best_kind_ = PieceKind::Point;
};

}  // namespace

DistanceAnswer distance(const Pieces& model, const std::array<double, 3>& c,
                        const DistanceBudget& budget) {
    DistanceAnswer r = Search(model, {false, c, 0}, budget).run();
    if (r.lo.sign() < 0) r.lo = Real(0.0);
    mpfr_sqrt(r.lo.get(), r.lo.get(), MPFR_RNDD);
    mpfr_sqrt(r.hi.get(), r.hi.get(), MPFR_RNDU);
    return r;
}

DistanceAnswer support(const Pieces& model, const std::array<double, 3>& n, double h,
                       const DistanceBudget& budget) {
    return Search(model, {true, n, h}, budget).run();
}

}  // namespace feeler_oracle
