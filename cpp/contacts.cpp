#include "contacts.hpp"

#include <algorithm>
#include <deque>
#include <memory>
#include <numeric>

#include "contact_ways.hpp"
#include "core.hpp"

namespace feeler_oracle {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Boxes on which f varies by no more than this part of the size are not searched further, ...
constexpr double kFlat = 0x1p-44;
// ... but cut down to this level to be put to the region.
constexpr int kFlatLevel = 4;
// Contacts nearer to each other than this part of the size count as one.
constexpr double kOne = 0x1p-24;
// Entries longer than this part of the size are continua.
constexpr double kContinuum = 0x1p-30;

double magnitude(const std::vector<double>& c) {
    double m = 0;
    for (double x : c) m = std::max(m, std::fabs(x));
    return m;
}

// Differences of A - T B over a box; weight: the sum of magnitudes of the scheme's factors, at most
// 4 terms.
struct Differences {
    const Net64& n;
    double ma, mb;
    explicit Differences(const Net64& net) : n(net), ma(magnitude(net.a)), mb(magnitude(net.b)) {}
    Interval64 at(double da, double db, double weight, const Interval64& t) const {
        const double ea = next_up(weight * next_up(n.ra + ma * 0x1p-51));
        const double eb = next_up(weight * next_up(n.rb + mb * 0x1p-51));
        return Interval64(next_down(da - ea), next_up(da + ea)) -
               t * Interval64(next_down(db - eb), next_up(db + eb));
    }
};

// -1, 1: the first difference is negative, positive throughout; 0: neither is proven.
int slope_sign(const Net64& n, Degrees d, bool along_u, const Interval64& t) {
    if ((along_u ? d.p : d.q) == 0) return 0;
    const Differences form(n);
    const size_t step = along_u ? d.q + 1 : 1;
    bool up = true, down = true;
    for (int i = 0; i <= d.p - (along_u ? 1 : 0); ++i)
        for (int j = 0; j <= d.q - (along_u ? 0 : 1); ++j) {
            const size_t k = d.index(i, j);
            const Interval64 x = form.at(n.a[k + step] - n.a[k], n.b[k + step] - n.b[k], 2, t);
            up &= x.lo > 0;
            down &= x.hi < 0;
            if (!up && !down) return 0;
        }
    return up ? 1 : -1;
}

struct Hessian {
    Interval64 uu, uv, vv;
    bool convex(Degrees d) const {
        if (d.p == 0) return true;
        if (d.q == 0) return uu.lo > 0;
        const double m = std::max(-uv.lo, uv.hi);
        return uu.lo > 0 && vv.lo > 0 && next_down(uu.lo * vv.lo) > next_up(m * m);
    }
    // Below the least eigenvalue, if convex: determinant over trace.
    double least_eigenvalue(Degrees d) const {
        if (d.q == 0) return uu.lo;
        const double m = std::max(-uv.lo, uv.hi);
        return next_down(next_down(next_down(uu.lo * vv.lo) - next_up(m * m)) /
                         next_up(uu.lo + vv.lo));
    }
    // Whether the second derivative along some direction is negative throughout; with `corner`,
    // only directions along the axes may be taken (the others may not enter the patch).
    bool falls(Degrees d, bool corner) const {
        if (d.p > 0 && uu.hi < 0) return true;
        if (d.q > 0 && vv.hi < 0) return true;
        if (d.p == 0 || d.q == 0 || corner) return false;
        const auto middle = [](const Interval64& x) { return 0.5 * x.lo + 0.5 * x.hi; };
        const double a = middle(uu), b = middle(uv), c = middle(vv);
        const double root = std::hypot(0.5 * (a - c), b), low = 0.5 * (a + c) - root;
        if (!(low < 0)) return false;
        // The eigenvector (b, low - a) or (low - c, b).
        double x = b, y = low - a;
        if (std::fabs(low - c) > std::fabs(y)) x = low - c, y = b;
        const double size = std::max(std::fabs(x), std::fabs(y));
        if (!(size > 0)) return false;
        x /= size, y /= size;
        const Interval64 form = uu * Interval64(x) * Interval64(x) +
                                Interval64(2.0) * uv * Interval64(x) * Interval64(y) +
                                vv * Interval64(y) * Interval64(y);
        return form.hi < 0;
    }
};

Hessian hessian(const Net64& n, Degrees d, const Interval64& t) {
    const Differences form(n);
    const size_t w = d.q + 1;
    const auto join = [](Interval64& r, const Interval64& x, bool first) {
        r = first ? x : Interval64(std::min(r.lo, x.lo), std::max(r.hi, x.hi));
    };
    const auto second = [&](size_t k, size_t step) {
        return form.at(n.a[k + 2 * step] - 2 * n.a[k + step] + n.a[k],
                       n.b[k + 2 * step] - 2 * n.b[k + step] + n.b[k], 4, t);
    };
    Hessian r;
    for (int i = 0; i + 2 <= d.p; ++i)
        for (int j = 0; j <= d.q; ++j) join(r.uu, second(d.index(i, j), w), i == 0 && j == 0);
    for (int i = 0; i <= d.p; ++i)
        for (int j = 0; j + 2 <= d.q; ++j) join(r.vv, second(d.index(i, j), 1), i == 0 && j == 0);
    for (int i = 0; i < d.p; ++i)
        for (int j = 0; j < d.q; ++j) {
            const size_t k = d.index(i, j);
            join(r.uv,
                 form.at(n.a[k + w + 1] - n.a[k + w] - n.a[k + 1] + n.a[k],
                         n.b[k + w + 1] - n.b[k + w] - n.b[k + 1] + n.b[k], 4, t),
                 i == 0 && j == 0);
        }
    r.uu = r.uu * Interval64(double(d.p * (d.p - 1)));
    r.vv = r.vv * Interval64(double(d.q * (d.q - 1)));
    r.uv = r.uv * Interval64(double(d.p * d.q));
    return r;
}

bool split_along_u(const Net64& n, Degrees d, double t, const DyadicBox& at) {
    if (d.q == 0) return true;
    if (d.p == 0) return false;
    constexpr double kSlopeWeight = 1.0 / 16;
    constexpr int kMostUneven = 40;
    if (at.lu >= kDeepest || at.lu > at.lv + kMostUneven) return false;
    if (at.lv >= kDeepest || at.lv > at.lu + kMostUneven) return true;
    std::vector<double> h(n.a);
    for (size_t i = 0; i < h.size(); ++i) h[i] -= t * n.b[i];
    double u = 0, v = 0;
    const size_t w = d.q + 1;
    for (int i = 0; i <= d.p; ++i)
        for (int j = 0; j <= d.q; ++j) {
            const size_t k = d.index(i, j);
            if (i < d.p) u = std::max(u, kSlopeWeight * d.p * std::fabs(h[k + w] - h[k]));
            if (j < d.q) v = std::max(v, kSlopeWeight * d.q * std::fabs(h[k + 1] - h[k]));
            if (i + 2 <= d.p)
                u = std::max(u, d.p * (d.p - 1) * std::fabs(h[k + 2 * w] - 2 * h[k + w] + h[k]));
            if (j + 2 <= d.q)
                v = std::max(v, d.q * (d.q - 1) * std::fabs(h[k + 2] - 2 * h[k + 1] + h[k]));
        }
    return u > v || (u == v && at.lu <= at.lv);
}

// Where a local minimiser may be.
struct Candidate {
    int face;
    std::array<double, 6> box;
    Real lo, hi;                   // of the objective; hi infinite if no point of F is known in it
    bool inner = false;            // a critical point well inside the region
    Place place{-1, -1, 0, 0, 0};  // of those on the boundary; face -1: not known
    bool whole_arc = false;        // the place may be anywhere on the piece (a pole)
    double t0 = 0, t1 = 0;         // then
};

// The end of a Trim or Joint from which f falls by `depth` along it.
struct Fall {
    std::array<double, 6> box;
    double depth;
};

struct Item {
    int piece;
    DyadicBox at;
    Net64 net;
    bool inside;
};

Q exact(const Real& x) {
    mpq_t q;
    mpq_init(q);
    if (x.sign() != 0) {
        mpz_t m;
        mpz_init(m);
        const mpfr_exp_t e = mpfr_get_z_2exp(m, x.get());
        mpq_set_z(q, m);
        e < 0 ? mpq_div_2exp(q, q, -e) : mpq_mul_2exp(q, q, e);
        mpz_clear(m);
    }
    Q r(q);
    mpq_clear(q);
    return r;
}

// Position and region of a part of a box, in MPFR.
Interval whole_parameter(int level, std::uint64_t index, const Interval& local) {
    Real i, scale;
    mpfr_set_ui_2exp(i.get(), index, 0, MPFR_RNDN);
    mpfr_set_ui_2exp(scale.get(), 1, -level, MPFR_RNDN);
    return Interval(scale) * (Interval(i) + local);
}

Interval bernstein(std::vector<Interval> b, int p, int q, const Interval& x, const Interval& y) {
    const int w = q + 1;
    const auto lerp = [](const Interval& a, const Interval& c, const Interval& t) {
        return a + t * (c - a);
    };
    for (int k = p; k >= 1; --k)
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < w; ++j) b[i * w + j] = lerp(b[i * w + j], b[(i + 1) * w + j], x);
    for (int k = q; k >= 1; --k)
        for (int j = 0; j < k; ++j) b[j] = lerp(b[j], b[j + 1], y);
    return b[0];
}

std::array<double, 6> image(const Piece& s, const Interval& x, const Interval& y) {
    const Interval w = bernstein(s.net[3], s.p, s.q, x, y);
    std::array<double, 6> r;
    for (int k = 0; k < 3; ++k) {
        const Interval c = divide_positive(bernstein(s.net[k], s.p, s.q, x, y), w);
        r[2 * k] = c.lo.down(), r[2 * k + 1] = c.hi.up();
    }
    return r;
}

class Search {
 public:
    Search(const AllPieces& model, const Objective& o, double limit, double join,
           const ContactBudget& budget)
        : model_(model),
          o_(o),
          limit_(limit),
          join_(join),
          budget_(budget),
          ways_(model, o, join, budget.ways) {
        // The limit on the objective's own value.
        bound_ = o.linear ? limit : next_up(limit * limit);
    }

    Contacts run() {
        out_.join = join_;
        for (size_t i = 0; i < model_.pieces.size(); ++i) start(int(i));
        while (!queue_.empty()) {
            const auto item = std::move(queue_.front());
            queue_.pop_front();
            visit(*item);
        }
        drop_fallen();
        make_entries();
        return std::move(out_);
    }

 private:
    const Piece& piece(int i) const { return *model_.pieces[i]; }

    void start(int i) {
        const Piece& s = piece(i);
        if (s.kind == PieceKind::Point) {
            // Those of trims and joints are the two before them.
            add_point(i);
            return;
        }
        auto item = std::make_unique<Item>(Item{i, {}, objective_net64(o_, s), !s.regional});
        ++out_.nodes;
        if (range_of(item->net).lo > bound_) return;
        if (s.kind != PieceKind::Patch)
            for (bool last : {false, true}) add_fall(i, item->net, last);
        queue_.push_back(std::move(item));
    }

    void add_point(int i) {
        const Piece& s = piece(i);
        const NetMp net = objective_net(o_, s, {});
        const Interval f = divide_positive(net.a[0], net.b[0]);
        if (Real(bound_) < f.lo) return;
        if (s.regional && side(model_.region(s.face), s.uv[0], s.uv[2]) == Side::Outside) return;
        Candidate c{s.face, s.box, f.lo, s.attained ? f.hi : Real(kInfinity)};
        if (s.arc >= 0) {
            c.place = ways_.place(s.face, s.arc, CGAL::to_double(s.t0));
        } else {
            for (int k = 1; k <= 2 && i + k < int(model_.pieces.size()); ++k) {
                const Piece& of = piece(i + k);
                if (of.kind == PieceKind::Trim && of.face == s.face) {
                    c.place = ways_.place(s.face, of.arc, CGAL::to_double(k == 2 ? of.t0 : of.t1));
                    break;
                }
                if (of.kind == PieceKind::Joint && of.face == s.face) {
                    c.place = {s.face, -1, 0, 0.5 * (s.uv64[0].lo + s.uv64[0].hi),
                               0.5 * (s.uv64[2].lo + s.uv64[2].hi)};
                    if (!s.regional) {  // the corner of a whole domain
                        const int e = k == 2 ? 0 : 1;
                        const bool along_u = !(of.uv[0] == of.uv[1]);
                        c.place.u = of.uv64[along_u ? e : 0].lo;
                        c.place.v = of.uv64[along_u ? 2 : 2 + e].lo;
                    }
                    break;
                }
            }
        }
        candidates_.push_back(std::move(c));
    }

    // Whether f falls from an end along the piece.
    void add_fall(int i, Net64 net, bool last) {
        const Piece& s = piece(i);
        const Degrees d = objective_degrees(o_, s);
        constexpr int kHalvings = 24;
        DyadicBox at;
        for (int k = 0; k < kHalvings; ++k) {
            const Interval64 f = range_of(net);
            const int sign = slope_sign(net, d, true, f);
            if (sign == (last ? -1 : 1)) return;
            if (sign != 0) {
                if (s.regional && region_side(s, at) != BoxSide::Inside) return;
                const size_t from = last ? d.p : 0, to = last ? 0 : d.p;
                const auto value = [&](size_t k) {
                    return divide_positive(
                        Interval64(next_down(net.a[k] - net.ra), next_up(net.a[k] + net.ra)),
                        Interval64(next_down(net.b[k] - net.rb), next_up(net.b[k] + net.rb)));
                };
                if (!(next_down(net.b[from] - net.rb) > 0 && next_down(net.b[to] - net.rb) > 0))
                    return;
                const double depth =
                    next_down(rooted_down(o_, value(from).lo) - rooted_up(o_, value(to).hi));
                if (depth > 0) {
                    falls_.push_back({piece(i - (last ? 1 : 2)).box, depth});
                    return;
                }
            }
            Net64 left, right;
            split64(net, d, true, left, right);
            net = last ? right : left;
            at = at.half(true, last);
        }
    }

    static Interval64 part(const Interval64& from, const Interval64& to, int level,
                           std::uint64_t index) {
        const auto at = [&](double i) {
            return from + Interval64(std::ldexp(i, -level)) * (to - from);
        };
        const bool last = index + 1 == (std::uint64_t(1) << level);
        return {index == 0 ? from.lo : std::max(from.lo, at(double(index)).lo),
                last ? to.hi : std::min(to.hi, at(double(index) + 1).hi)};
    }

    BoxSide region_side(const Piece& s, const DyadicBox& b) const {
        if (!s.regional) return BoxSide::Inside;
        Interval64 u(s.uv64[0].lo, s.uv64[1].hi), v(s.uv64[2].lo, s.uv64[3].hi);
        if (s.kind == PieceKind::Patch) {
            u = part(s.uv64[0], s.uv64[1], b.lu, b.iu);
            v = part(s.uv64[2], s.uv64[3], b.lv, b.iv);
        } else if (s.uv[0] == s.uv[1]) {
            v = part(s.uv64[2], s.uv64[3], b.lu, b.iu);
        } else {
            u = part(s.uv64[0], s.uv64[1], b.lu, b.iu);
        }
        return box_side(model_.region(s.face), u.lo, u.hi, v.lo, v.hi);
    }

    // Whether the box of a Patch holds one of the patch's corners.
    static bool at_corner(const DyadicBox& b) {
        const auto end = [](int level, std::uint64_t i) {
            return i == 0 || i + 1 == (std::uint64_t(1) << level);
        };
        return end(b.lu, b.iu) && end(b.lv, b.iv);
    }

    void visit(const Item& b) {
        const Piece& s = piece(b.piece);
        const Degrees d = objective_degrees(o_, s);
        const Interval64 f = range_of(b.net);
        if (f.lo > bound_) return;
        const bool ranged = std::isfinite(f.lo) && std::isfinite(f.hi);
        const Interval64 up_to(f.lo, std::min(f.hi, bound_));
        bool inside = b.inside;
        if (ranged) {
            if (slope_sign(b.net, d, true, up_to) != 0 || slope_sign(b.net, d, false, up_to) != 0)
                return;
            if (hessian(b.net, d, up_to).falls(d, s.kind == PieceKind::Patch && at_corner(b.at)))
                return;
        }
        if (!inside) {
            const BoxSide where = region_side(s, b.at);
            if (where == BoxSide::Outside) return;
            inside = where == BoxSide::Inside;
        }
        const bool deep = (d.p == 0 || b.at.lu >= kDeepest) && (d.q == 0 || b.at.lv >= kDeepest);
        if (ranged) {
            if (rooted_up(o_, f.hi) - rooted_down(o_, f.lo) <= kFlat * model_.size) {
                const bool small =
                    (d.p == 0 || b.at.lu >= kFlatLevel) && (d.q == 0 || b.at.lv >= kFlatLevel);
                if (inside || small || s.kind != PieceKind::Patch) return add_flat(b, f, inside);
            } else {
                const Hessian h = hessian(b.net, d, f);
                if (h.convex(d) && close(b, d, h, inside)) return;
            }
        }
        if (out_.nodes >= budget_.nodes) {
            out_.whole = false;
            return add_flat(b, f, inside);
        }
        // No more to be learnt in doubles.
        const Differences form(b.net);
        double bend = 0;
        for (size_t i = 0; i < b.net.a.size(); ++i)
            bend = std::max(bend, std::fabs(b.net.a[i] - f.lo * b.net.b[i]));
        constexpr double kNoise = 4;
        const bool noise =
            ranged && bend <= kNoise * (b.net.ra + form.ma * 0x1p-51 +
                                        std::fabs(f.lo) * (b.net.rb + form.mb * 0x1p-51));
        if (deep || noise) return add_flat(b, f, inside);
        const bool along_u = split_along_u(b.net, d, ranged ? f.lo : 0, b.at);
        auto l = std::make_unique<Item>(Item{b.piece, b.at.half(along_u, false), {}, inside});
        auto r = std::make_unique<Item>(Item{b.piece, b.at.half(along_u, true), {}, inside});
        split64(b.net, d, along_u, l->net, r->net);
        out_.nodes += 2;
        queue_.push_back(std::move(l));
        queue_.push_back(std::move(r));
    }

    // A candidate of the whole box.
    void add_flat(const Item& b, const Interval64& f, bool inside) {
        const Piece& s = piece(b.piece);
        Candidate c{s.face, s.box, Real(f.lo), Real(kInfinity)};
        for (int k = 0; k < 3; ++k) {
            std::array<double, 3> axis{};
            axis[k] = 1;
            const NetMp net = objective_net({true, axis, 0}, s, b.at);
            double lo = kInfinity, hi = -kInfinity;
            for (size_t i = 0; i < net.a.size(); ++i) {
                const Interval x = divide_positive(net.a[i], net.b[i]);
                lo = std::min(lo, x.lo.down());
                hi = std::max(hi, x.hi.up());
            }
            c.box[2 * k] = lo, c.box[2 * k + 1] = hi;
        }
        if (s.attained && inside && std::isfinite(f.hi)) c.hi = Real(f.hi);
        if (s.kind == PieceKind::Trim) {
            const double t0 = CGAL::to_double(s.t0), t1 = CGAL::to_double(s.t1);
            c.whole_arc = true;
            c.t0 = t0 + (t1 - t0) * std::ldexp(double(b.at.iu), -b.at.lu);
            c.t1 = t0 + (t1 - t0) * std::ldexp(double(b.at.iu) + 1, -b.at.lu);
            c.place = ways_.place(s.face, s.arc, 0.5 * (c.t0 + c.t1));
        }
        candidates_.push_back(std::move(c));
    }

    // The one critical point of a convex box: false if it is better split.
    bool close(const Item& b, Degrees d, const Hessian& bend, bool inside) {
        const double m = bend.least_eigenvalue(d);
        if (!(m > 0)) return false;
        const Piece& s = piece(b.piece);
        std::vector<double> h(b.net.a);
        const auto less = [&](double t) {
            for (size_t i = 0; i < h.size(); ++i) h[i] = b.net.a[i] - t * b.net.b[i];
        };
        less(range_of(b.net).lo);
        Newton64 foot = newton64(h, d, 0.5, 0.5);
        {
            const double w = value64(b.net.b, d, foot.x, foot.y);
            less(value64(b.net.a, d, foot.x, foot.y) / w);
            foot = newton64(h, d, foot.x, foot.y);
        }
        const NetMp net = objective_net(o_, s, b.at);
        Real x(foot.x), y(d.q > 0 ? foot.y : 0.0);
        Real least_b = net.b[0].lo;
        for (const Interval& w : net.b)
            if (w.lo < least_b) least_b = w.lo;
        const double det = foot.uu * foot.vv - foot.uv * foot.uv;
        Jet a, w;
        Interval t;
        Interval gu, gv;
        // At an end of the box, and the derivative has its sign.
        const auto blocked = [](const Real& z, const Interval& g) {
            return (z.sign() == 0 && g.lo.sign() > 0) ||
                   (mpfr_cmp_ui(z.get(), 1) == 0 && g.hi.sign() < 0);
        };
        constexpr int kSteps = 24;
        double last = kInfinity;
        for (int step = 0;; ++step) {
            a = evaluate_net(net.a, d, x, y);
            w = evaluate_net(net.b, d, x, y);
            t = divide_positive(a.f, w.f);
            gu = a.u - t * w.u;
            gv = d.q > 0 ? a.v - t * w.v : Interval(0.0);
            const double u = gu.middle().near(), v = gv.middle().near();
            double dx = 0, dy = 0;
            const bool free_u = !blocked(x, gu), free_v = d.q > 0 && !blocked(y, gv);
            if (free_u && free_v) {
                if (!(det > 0)) return false;
                dx = (-u * foot.vv + v * foot.uv) / det;
                dy = (-v * foot.uu + u * foot.uv) / det;
            } else {
                if (free_u) dx = -u / foot.uu;
                if (free_v) dy = -v / foot.vv;
            }
            const double size = std::hypot(dx, dy);
            if (step == kSteps || !std::isfinite(size) || size < 0x1p-260 || size > last) break;
            last = size;
            const auto move = [](Real& z, double dz) {
                mpfr_add_d(z.get(), z.get(), dz, MPFR_RNDN);
                if (z.sign() < 0) z = Real(0.0);
                if (mpfr_cmp_ui(z.get(), 1) > 0) z = Real(1.0);
            };
            move(x, dx);
            if (d.q > 0) move(y, dy);
        }
        const auto size = [](const Interval& g) {
            Real minus;
            mpfr_neg(minus.get(), g.lo.get(), MPFR_RNDU);
            return minus < g.hi ? g.hi : minus;
        };
        // |g| (1 + sqrt 2 |grad B| / min B) / m, norms as sums; of g what is not blocked, ...
        const bool stopped_u = blocked(x, gu), stopped_v = d.q > 0 && blocked(y, gv);
        const Real zero(0.0), one(1.0);
        Real slope_b = size(w.u);
        if (d.q > 0) slope_b = add_up(slope_b, size(w.v));
        if (least_b.sign() <= 0) return false;
        const Real factor = add_up(one, div_up(mul_up(Real(1.5), slope_b), least_b));
        const auto reach = [&](bool with_u, bool with_v) {
            Real push = with_u ? size(gu) : zero;
            if (d.q > 0 && with_v) push = add_up(push, size(gv));
            return push;
        };
        if (stopped_u || stopped_v) {
            // ... so no critical point is farther than `radius` from x; nor nearer, where the
            // blocked derivative cannot fall to zero within it.
            const Real push = reach(!stopped_u, !stopped_v);
            const Real radius = div_up(mul_up(push, factor), Real(m));
            const Real fall = mul_up(div_up(mul_up(push, radius), least_b), slope_b);
            const auto most = [](const Interval64& i) { return std::max(-i.lo, i.hi); };
            const auto none = [&](const Interval& g, const Interval64& along) {
                const Real least = g.lo.sign() > 0 ? g.lo : sub_down(zero, g.hi);
                const double bends = next_up(most(along) + most(bend.uv));
                return add_up(fall, mul_up(Real(bends), radius)) < least;
            };
            if ((stopped_u && none(gu, bend.uu)) || (stopped_v && none(gv, bend.vv))) return true;
        }
        const Real push = reach(true, true);
        const Real radius = div_up(mul_up(push, factor), Real(m));
        if (!(radius < Real(kSharp))) return false;
        // t - |g| radius / min B <= f(z) <= t.
        const Real lo = sub_down(t.lo, div_up(mul_up(push, radius), least_b));
        if (Real(bound_) < lo) return true;
        const auto around = [&](const Real& z) {
            const Real below = sub_down(z, radius), above = add_up(z, radius);
            return Interval(below < zero ? zero : below, one < above ? one : above);
        };
        const Interval ix = whole_parameter(b.at.lu, b.at.iu, around(x));
        const Interval iy = d.q > 0 ? whole_parameter(b.at.lv, b.at.iv, around(y)) : Interval(0.0);
        Candidate c{s.face, image(s, ix, iy), lo, Real(kInfinity)};
        bool held = true, mixed = false;
        if (s.kind != PieceKind::Trim) {
            const Interval cx = whole_parameter(b.at.lu, b.at.iu, Interval(x)),
                           cy = d.q > 0 ? whole_parameter(b.at.lv, b.at.iv, Interval(y))
                                        : Interval(0.0);
            const auto at = [&](const Real& p, int k) {
                return Q(s.uv[2 * k] + exact(p) * (s.uv[2 * k + 1] - s.uv[2 * k]));
            };
            const bool across = s.kind == PieceKind::Joint && s.uv[0] == s.uv[1];
            const Real zero(0.0);
            const auto pair = [&](const Real& p, const Real& q) {
                return across ? std::array<Q, 2>{s.uv[0], at(p, 1)}
                              : std::array<Q, 2>{at(p, 0),
                                                 s.kind == PieceKind::Joint ? s.uv[2] : at(q, 1)};
            };
            const auto centre = pair(cx.lo, cy.lo);
            c.place = {s.face, -1, 0, CGAL::to_double(centre[0]), CGAL::to_double(centre[1])};
            if (s.regional && !inside) {
                held = side(model_.region(s.face), centre[0], centre[1]) != Side::Outside;
                const auto low = pair(ix.lo, iy.lo), high = pair(ix.hi, iy.hi);
                const auto span = [](const Q& p, const Q& q) {
                    return hull(Interval(p.mpq()), Interval(q.mpq()));
                };
                mixed = !clear_of_arcs(model_.arcs(s.face), span(low[0], high[0]),
                                       span(low[1], high[1]));
                if (!mixed && !held) return true;
            }
            c.inner = s.kind == PieceKind::Patch && !mixed;
        } else {
            const double t0 = CGAL::to_double(s.t0), t1 = CGAL::to_double(s.t1);
            c.place = ways_.place(
                s.face, s.arc, t0 + (t1 - t0) * std::ldexp(double(b.at.iu) + x.near(), -b.at.lu));
        }
        if (held && s.attained) c.hi = t.hi;
        candidates_.push_back(std::move(c));
        return true;
    }

    static double value64(const std::vector<double>& c, Degrees d, double x, double y) {
        std::vector<double> b = c;
        const int w = d.q + 1;
        for (int k = d.p; k >= 1; --k)
            for (int i = 0; i < k; ++i)
                for (int j = 0; j < w; ++j) b[i * w + j] += x * (b[(i + 1) * w + j] - b[i * w + j]);
        for (int k = d.q; k >= 1; --k)
            for (int j = 0; j < k; ++j) b[j] += y * (b[j + 1] - b[j]);
        return b[0];
    }

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
                if (along(ways_.place(c.place.face, c.place.arc,
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

    // Boxes of feet are narrower than this part of the patch's side.
    static constexpr double kSharp = 0x1p-150;

    const AllPieces& model_;
    const Objective o_;
    const double limit_, join_;
    const ContactBudget budget_;
    double bound_;
    Ways ways_;
    std::deque<std::unique_ptr<Item>> queue_;
    std::vector<Candidate> candidates_;
    std::vector<Fall> falls_;
    Contacts out_;
};

}  // namespace

Interval64 range_of(const Net64& n) {
    double lo = kInfinity, hi = -kInfinity;
    for (size_t i = 0; i < n.a.size(); ++i) {
        const double b0 = next_down(n.b[i] - n.rb), b1 = next_up(n.b[i] + n.rb);
        if (!(b0 > 0)) return {-kInfinity, kInfinity};
        const Interval64 x =
            divide_positive({next_down(n.a[i] - n.ra), next_up(n.a[i] + n.ra)}, {b0, b1});
        lo = std::min(lo, x.lo);
        hi = std::max(hi, x.hi);
    }
    return {lo, hi};
}

double rooted_down(const Objective& o, double f) {
    if (o.linear) return f;
    return f > 0 ? std::max(0.0, next_down(std::sqrt(f))) : 0.0;
}

double rooted_up(const Objective& o, double f) {
    if (o.linear) return f;
    return f > 0 ? next_up(std::sqrt(f)) : 0.0;
}

Contacts contacts(const Pieces& model, const Objective& objective, double limit, double join,
                  const ContactBudget& budget) {
    const AllPieces all(model);
    return Search(all, objective, limit, join, budget).run();
}

double join_of(const Core& core) {
    const AllPieces model(core.pieces());
    // How often each edge is used by a trim.
    std::vector<int> uses;
    for (const Face& face : core.model().faces)
        for (const Loop& loop : face.loops ? *face.loops : std::vector<Loop>{})
            for (const TrimCurve& trim : loop.trims) {
                if (trim.edge < 0) continue;
                if (size_t(trim.edge) >= uses.size()) uses.resize(trim.edge + 1);
                ++uses[trim.edge];
            }
    const Ways ways(model, {true, {0, 0, 1}, 0}, 0, 0);
    double widest = 0;
    for (size_t f = 0; f < model.faces.size(); ++f) {
        if (!model.faces[f]) continue;
        const auto& edges = model.region(int(f)).arc_edge();
        for (size_t a = 0; a < edges.size(); ++a) {
            if (edges[a] < 0 || uses[edges[a]] < 2) continue;
            for (const double t : {0.03, 0.25, 0.5, 0.77})
                widest = std::max(widest, ways.gap(ways.place(int(f), int(a), t)));
        }
    }
    // Four times what samples show; a crack beyond 2^-12 of the size is no crack but a hole.
    constexpr double kSafety = 4;
    return std::max(0x1p-44 * model.size, std::min(kSafety * widest, 0x1p-12 * model.size));
}

}  // namespace feeler_oracle
