#include "contact_candidates.hpp"

#include <algorithm>
#include <deque>
#include <memory>

#include "contact_bounds.hpp"
#include "distance_bounds.hpp"

namespace feeler_oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Boxes on which f varies by no more than this part of the size are not searched further, ...
constexpr double kFlat = 0x1p-44;
// ... but cut down to this level to be put to the region.
constexpr int kFlatLevel = 4;
// Boxes of feet are narrower than this part of the patch's side; on a Trim that is known but to a
// slack, than this one.
constexpr double kSharp = 0x1p-150, kSharpWithSlack = 0x1p-110;

struct Item {
    int piece;
    DyadicBox at;
    Net64 net;
    bool inside;
};

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

// index + local, over 2^level.
Interval whole_parameter(int level, std::uint64_t index, const Interval& local) {
    Real i, scale;
    mpfr_set_ui_2exp(i.get(), index, 0, MPFR_RNDN);
    mpfr_set_ui_2exp(scale.get(), 1, -level, MPFR_RNDN);
    return Interval(scale) * (Interval(i) + local);
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

void widen(std::array<double, 6>& box, double slack) {
    if (!(slack > 0)) return;
    for (int k = 0; k < 3; ++k) {
        box[2 * k] = next_down(box[2 * k] - slack);
        box[2 * k + 1] = next_up(box[2 * k + 1] + slack);
    }
}

// What a true image within `slack` of the net's curve does to f and to its derivatives by the
// piece's parameter; see contacts.hpp, item 4.
struct Deviation {
    double slack = 0;              // of f, as a length
    double first = 0, second = 0;  // of the derivatives of B f, over the whole piece

    Interval64 value(const Objective& o, const Interval64& f) const {
        if (!(slack > 0)) return f;
        if (o.linear) return {next_down(f.lo - slack), next_up(f.hi + slack)};
        const double lo = std::max(0.0, next_down(rooted_down(o, f.lo) - slack));
        const double hi = next_up(rooted_up(o, f.hi) + slack);
        return {next_down(lo * lo), next_up(hi * hi)};
    }
    Interval value(const Objective& o, const Interval& f) const {
        if (!(slack > 0)) return f;
        const Real d(slack);
        if (o.linear) return {sub_down(f.lo, d), add_up(f.hi, d)};
        // (r +- d)^2 = r^2 +- 2 r d + d^2.
        Real root(0.0);
        if (f.hi.sign() > 0) mpfr_sqrt(root.get(), f.hi.get(), MPFR_RNDU);
        const Real by = mul_up(d, add_up(add_up(root, root), d));
        return {sub_down(f.lo, by), add_up(f.hi, by)};
    }
    double first_at(const DyadicBox& b) const { return std::ldexp(first, -b.lu); }
    double second_at(const DyadicBox& b) const { return std::ldexp(second, -2 * b.lu); }
};

Deviation deviation(const Objective& o, const Piece& s) {
    Deviation r;
    if (!(s.slack > 0)) return r;
    double reach = 1;
    if (o.linear) {
        reach = 0;
        for (double c : o.c) reach = next_up(reach + std::fabs(c));
        r.slack = next_up(s.slack * reach);
    } else {
        r.slack = s.slack;
        reach = next_up(rooted_up(o, box_bounds(o, s.box).hi) + s.slack);
    }
    bool polynomial = true;
    for (const Interval& w : s.net[3])
        polynomial &= w.is_point() && mpfr_cmp_ui(w.lo.get(), 1) == 0;
    if (!polynomial) return r;
    constexpr double kFirst = 512, kSecond = 32768;
    r.first = next_up(kFirst * s.slack * reach);
    r.second = next_up(kSecond * s.slack * reach);
    return r;
}

class Search {
 public:
    Search(const AllPieces& model, const Objective& o, double bound, long nodes)
        : model_(model), o_(o), bound_(bound), budget_(nodes) {}

    Candidates run() {
        for (size_t i = 0; i < model_.pieces.size(); ++i) start(int(i));
        while (!queue_.empty()) {
            const auto item = std::move(queue_.front());
            queue_.pop_front();
            visit(*item);
        }
        return std::move(out_);
    }

 private:
    const Piece& piece(int i) const { return *model_.pieces[size_t(i)]; }

    void start(int i) {
        const Piece& s = piece(i);
        if (s.kind == PieceKind::Point) {
            // Those of trims and joints are the two before them.
            add_point(i);
            return;
        }
        auto item = std::make_unique<Item>(Item{i, {}, objective_net64(o_, s), !s.regional});
        ++out_.nodes;
        if (range(*item).lo > bound_) return;
        if (s.kind != PieceKind::Patch)
            for (bool last : {false, true}) add_fall(i, item->net, last);
        queue_.push_back(std::move(item));
    }

    // Of f over a box.
    Interval64 range(const Item& b) const {
        return deviation(o_, piece(b.piece)).value(o_, range_of(b.net));
    }

    void add_point(int i) {
        const Piece& s = piece(i);
        const NetMp net = objective_net(o_, s, {});
        const Interval f = deviation(o_, s).value(o_, divide_positive(net.a[0], net.b[0]));
        if (Real(bound_) < f.lo) return;
        if (s.regional && side(model_.region(s.face), s.uv[0], s.uv[2]) == Side::Outside) return;
        Candidate c{s.face, s.box, f.lo, s.attained ? f.hi : Real(kInfinity)};
        widen(c.box, s.slack);
        c.sharp = true;
        if (s.arc >= 0) {
            c.place = model_.place(s.face, s.arc, CGAL::to_double(s.t0));
        } else {
            for (int k = 1; k <= 2 && i + k < int(model_.pieces.size()); ++k) {
                const Piece& of = piece(i + k);
                if (of.kind == PieceKind::Trim && of.face == s.face) {
                    c.place = model_.place(s.face, of.arc, CGAL::to_double(k == 2 ? of.t0 : of.t1));
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
        out_.all.push_back(std::move(c));
    }

    // Whether f falls from an end along the piece.
    void add_fall(int i, Net64 net, bool last) {
        const Piece& s = piece(i);
        const Degrees d = objective_degrees(o_, s);
        const Deviation off = deviation(o_, s);
        constexpr int kHalvings = 24;
        DyadicBox at;
        for (int k = 0; k < kHalvings; ++k) {
            const Interval64 f = off.value(o_, range_of(net));
            const int sign = slope_sign(net, d, true, f, off.first_at(at));
            if (sign == (last ? -1 : 1)) return;
            if (sign != 0) {
                if (s.regional &&
                    region_side(model_.in_region(s), at, {0, 1}, {0, 1}) != BoxSide::Inside)
                    return;
                const size_t from = last ? d.p : 0, to = last ? 0 : d.p;
                const auto value = [&](size_t k) {
                    return off.value(
                        o_,
                        divide_positive(
                            Interval64(next_down(net.a[k] - net.ra), next_up(net.a[k] + net.ra)),
                            Interval64(next_down(net.b[k] - net.rb), next_up(net.b[k] + net.rb))));
                };
                if (!(next_down(net.b[from] - net.rb) > 0 && next_down(net.b[to] - net.rb) > 0))
                    return;
                const double depth =
                    next_down(rooted_down(o_, value(from).lo) - rooted_up(o_, value(to).hi));
                if (depth > 0) {
                    Fall fall{piece(i - (last ? 1 : 2)).box, depth};
                    widen(fall.box, s.slack);
                    out_.falls.push_back(fall);
                    return;
                }
            }
            Net64 left, right;
            split64(net, d, true, left, right);
            net = last ? right : left;
            at = at.half(true, last);
        }
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
        const Deviation off = deviation(o_, s);
        const Interval64 f = range(b);
        if (f.lo > bound_) return;
        const bool ranged = std::isfinite(f.lo) && std::isfinite(f.hi);
        const Interval64 up_to(f.lo, std::min(f.hi, bound_));
        bool inside = b.inside;
        if (ranged) {
            const double first = off.first_at(b.at);
            if (slope_sign(b.net, d, true, up_to, first) != 0 ||
                slope_sign(b.net, d, false, up_to, first) != 0)
                return;
            if (hessian(b.net, d, up_to, off.second_at(b.at))
                    .falls(d, s.kind == PieceKind::Patch && at_corner(b.at)))
                return;
        }
        if (!inside) {
            const BoxSide where = region_side(model_.in_region(s), b.at, {0, 1}, {0, 1});
            if (where == BoxSide::Outside) return;
            inside = where == BoxSide::Inside;
        }
        const bool deep = (d.p == 0 || b.at.lu >= kDeepest) && (d.q == 0 || b.at.lv >= kDeepest);
        if (ranged) {
            if (rooted_up(o_, f.hi) - rooted_down(o_, f.lo) <= kFlat * model_.size) {
                const bool small =
                    (d.p == 0 || b.at.lu >= kFlatLevel) && (d.q == 0 || b.at.lv >= kFlatLevel);
                if (close_at_side(b, d, f, inside)) return;
                if (inside || small || s.kind != PieceKind::Patch) return add_flat(b, f, inside);
            } else {
                if (close_at_side(b, d, f, inside)) return;
                const Hessian h = hessian(b.net, d, f, off.second_at(b.at));
                if (h.convex(d) && close(b, d, h, inside)) return;
            }
        }
        if (out_.nodes >= budget_) {
            out_.whole = false;
            return add_flat(b, f, inside);
        }
        // No more to be learnt in doubles.
        if (deep || (ranged && is_noise(b.net, f.lo))) return add_flat(b, f, inside);
        std::vector<double> h(b.net.a);
        if (ranged)
            for (size_t i = 0; i < h.size(); ++i) h[i] -= f.lo * b.net.b[i];
        const bool along_u = allowed_along_u(split_along_u(h, d, b.at), d, b.at, false);
        auto l = std::make_unique<Item>(Item{b.piece, b.at.half(along_u, false), {}, inside});
        auto r = std::make_unique<Item>(Item{b.piece, b.at.half(along_u, true), {}, inside});
        split64(b.net, d, along_u, l->net, r->net);
        out_.nodes += 2;
        queue_.push_back(std::move(l));
        queue_.push_back(std::move(r));
    }

    // A candidate of the whole box, unless 320 bits tell more where f varies by no more than the
    // noise of doubles: along the tiny segments that join trims, or next to a pole.
    void add_flat(const Item& b, const Interval64& f, bool inside) {
        const Piece& s = piece(b.piece);
        const Degrees d = objective_degrees(o_, s);
        const Deviation off = deviation(o_, s);
        const NetMp net = objective_net(o_, s, b.at);
        Interval range(Real(kInfinity), Real(-kInfinity));
        for (size_t i = 0; i < net.a.size(); ++i) {
            const Interval x = divide_positive(net.a[i], net.b[i]);
            range = i == 0 ? x : hull(range, x);
        }
        range = off.value(o_, range);
        if (d.p > 0 && std::isfinite(f.lo) && !(off.slack > 0)) {
            if (monotone(net, d, true, range) || monotone(net, d, false, range)) return;
            const Curvature least = curvature(net, d, range);
            const Hessian bend{{least.uu, kInfinity}, {-least.uv, least.uv}, {least.vv, kInfinity}};
            if (bend.convex(d) && close(b, d, bend, inside)) return;
        }
        Candidate c{s.face, part_box(s, b.at), range.lo, Real(kInfinity)};
        if (c.lo < Real(f.lo)) c.lo = Real(f.lo);
        widen(c.box, s.slack);
        if (s.attained && inside && std::isfinite(f.hi)) c.hi = range.hi;
        if (s.kind == PieceKind::Trim) {
            const double t0 = CGAL::to_double(s.t0), t1 = CGAL::to_double(s.t1);
            c.whole_arc = true;
            c.t0 = t0 + (t1 - t0) * std::ldexp(double(b.at.iu), -b.at.lu);
            c.t1 = t0 + (t1 - t0) * std::ldexp(double(b.at.iu) + 1, -b.at.lu);
            c.place = model_.place(s.face, s.arc, 0.5 * (c.t0 + c.t1));
        }
        out_.all.push_back(std::move(c));
    }

    // The hull of a part of a piece.
    static std::array<double, 6> part_box(const Piece& s, const DyadicBox& at) {
        std::array<double, 6> box;
        for (int k = 0; k < 3; ++k) {
            std::array<double, 3> axis{};
            axis[k] = 1;
            const NetMp net = objective_net({true, axis, 0}, s, at);
            double lo = kInfinity, hi = -kInfinity;
            for (size_t i = 0; i < net.a.size(); ++i) {
                const Interval x = divide_positive(net.a[i], net.b[i]);
                lo = std::min(lo, x.lo.down());
                hi = std::max(hi, x.hi.up());
            }
            box[2 * k] = lo, box[2 * k + 1] = hi;
        }
        return box;
    }

    // Of a Patch box that has a side along which f is level and does not change to first order
    // across it: a pole above which the centre is, an apex, a ridge. With y in [0, 1] the distance
    // from that side in the box, f0 the value on it, m > 0 below the second derivative of A - tau B
    // along y for all tau in the range of f, e above |d/dy (A - f0 B)| and w above |A - f0 B| on
    // the side. Let z, at y, be a critical point, tau = f(z). h_f0 is convex along y, so
    // (tau - f0) B(z) = h_f0(z) >= -w - e^2 / (2 m). h_tau is, and least at z, where it is zero:
    // (f0 - tau) B >= -w on the side. So |f0 - tau| <= D = (w + e^2 / (2 m)) / min B, and
    //    0 = dh_tau/dy(z) >= dh_tau/dy(side) + m y >= -e - D |dB/dy| + m y.
    // All critical points of the box are within y <= (e + D |dB/dy|) / m. If d/dy (A - f0 B) >= g >
    // 0 on the side, h_f0(z) >= -w, so D = w / min B, and with g > D |dB/dy| there is none: as
    // beside a pole that the surface falls short of by a rounding.
    bool close_at_side(const Item& b, Degrees d, const Interval64& f, bool inside) {
        const Piece& s = piece(b.piece);
        if (s.kind != PieceKind::Patch || d.p < 2 || d.q < 2) return false;
        for (int k = 0; k < 2; ++k)
            for (const bool last : {false, true})
                if (is_level_side(b, d, k, last) && close_at_side(b, d, f, inside, k, last))
                    return true;
        return false;
    }

    // Coefficient (along the side, away from it) of a side of a box.
    static size_t from_side(Degrees d, int k, bool last, int along, int away) {
        const int n = k == 0 ? d.p : d.q, i = last ? n - away : away;
        return k == 0 ? d.index(i, along) : d.index(along, i);
    }

    // In doubles, about.
    bool is_level_side(const Item& b, Degrees d, int k, bool last) const {
        const int level = k == 0 ? b.at.lu : b.at.lv;
        const std::uint64_t index = k == 0 ? b.at.iu : b.at.iv;
        if (index != (last ? (std::uint64_t(1) << level) - 1 : 0)) return false;
        constexpr double kLevel = 0x1p-40;
        const size_t first = from_side(d, k, last, 0, 0);
        const double f0 = b.net.a[first] / b.net.b[first];
        const double most = kLevel * (magnitude(b.net.a) + std::fabs(f0) * magnitude(b.net.b));
        for (int i = 0; i <= (k == 0 ? d.q : d.p); ++i)
            for (int away = 0; away < 2; ++away) {
                const size_t at = from_side(d, k, last, i, away);
                if (!(std::fabs(b.net.a[at] - f0 * b.net.b[at]) <= most)) return false;
            }
        return true;
    }

    bool close_at_side(const Item& b, Degrees d, const Interval64& f, bool inside, int k,
                       bool last) {
        const Piece& s = piece(b.piece);
        const NetMp net = objective_net(o_, s, b.at);
        const Curvature bend = curvature(net, d, Interval(Real(f.lo), Real(f.hi)));
        const Real m(k == 0 ? bend.uu : bend.vv);
        if (!(m.sign() > 0)) return false;
        const int lines = k == 0 ? d.q : d.p;
        const Interval degree(double(k == 0 ? d.p : d.q));
        const auto size = [](const Interval& g) {
            Real minus;
            mpfr_neg(minus.get(), g.lo.get(), MPFR_RNDU);
            return minus < g.hi ? g.hi : minus;
        };
        Interval f0;
        Real least_b = net.b[0].lo;
        for (const Interval& x : net.b)
            if (x.lo < least_b) least_b = x.lo;
        if (least_b.sign() <= 0) return false;
        for (int i = 0; i <= lines; ++i) {
            const size_t at = from_side(d, k, last, i, 0);
            const Interval x = divide_positive(net.a[at], net.b[at]);
            f0 = i == 0 ? x : hull(f0, x);
        }
        Real w(0.0), e(0.0), slope_b(0.0), least_rise(kInfinity);
        const auto raise = [&](Real& most, const Interval& x) {
            const Real r = size(x);
            if (most < r) most = r;
        };
        for (int i = 0; i <= lines; ++i) {
            const size_t at = from_side(d, k, last, i, 0), next = from_side(d, k, last, i, 1);
            raise(w, net.a[at] - f0 * net.b[at]);
            const Interval rise =
                degree * (net.a[next] - net.a[at] - f0 * (net.b[next] - net.b[at]));
            raise(e, rise);
            if (rise.lo < least_rise) least_rise = rise.lo;
            raise(slope_b, degree * (net.b[next] - net.b[at]));
        }
        if (mul_up(div_up(w, least_b), slope_b) < least_rise) return true;
        const Real off = div_up(add_up(w, div_up(mul_up(e, e), m)), least_b);
        const Real radius = div_up(add_up(e, mul_up(off, slope_b)), m);
        // The part of the box next to the side that the candidate is given.
        if (!(radius < Real(std::ldexp(1.0, -kDeepest)))) return false;
        const Real lo = sub_down(f0.lo, off);
        if (Real(bound_) < lo) return true;
        DyadicBox thin = b.at;
        auto& level = k == 0 ? thin.lu : thin.lv;
        auto& index = k == 0 ? thin.iu : thin.iv;
        index = last ? (std::uint64_t(1) << kDeepest) - 1 : 0;
        level = kDeepest;
        Candidate c{s.face, part_box(s, thin), lo, Real(kInfinity)};
        if (s.attained && inside) c.hi = f0.hi;
        out_.all.push_back(std::move(c));
        return true;
    }

    // The one critical point of a convex box: false if it is better split.
    bool close(const Item& b, Degrees d, const Hessian& bend, bool inside) {
        const double m = bend.least_eigenvalue(d);
        if (!(m > 0)) return false;
        const Piece& s = piece(b.piece);
        const Deviation off = deviation(o_, s);
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
        const Real blur(off.first_at(b.at));
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
        // What is true of the image itself: with a slack, q = 0 and B is constant, or nothing is
        // added to the derivative.
        gu = {sub_down(gu.lo, blur), add_up(gu.hi, blur)};
        t = off.value(o_, t);
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
        if (!(radius < Real(off.slack > 0 ? kSharpWithSlack : kSharp))) return false;
        // t - |g| radius / min B <= f(z) <= t.
        const Real lo = sub_down(t.lo, div_up(mul_up(push, radius), least_b));
        if (Real(bound_) < lo) return true;
        const auto around = [&](const Real& z) {
            const Real below = sub_down(z, radius), above = add_up(z, radius);
            return Interval(below < zero ? zero : below, one < above ? one : above);
        };
        const Interval lx = around(x), ly = d.q > 0 ? around(y) : Interval(0.0);
        Candidate c{s.face,
                    image(s, whole_parameter(b.at.lu, b.at.iu, lx),
                          d.q > 0 ? whole_parameter(b.at.lv, b.at.iv, ly) : Interval(0.0)),
                    lo, Real(kInfinity)};
        widen(c.box, s.slack);
        c.sharp = true;
        bool held = true, mixed = false;
        if (s.kind != PieceKind::Trim) {
            const auto centre = parameters(s, b.at, Interval(x), Interval(y));
            c.place = {s.face, -1, 0, centre[0].lo.near(), centre[1].lo.near()};
            if (s.regional && !inside) {
                const BoxSide where = exact_side(model_.in_region(s), b.at, lx, ly, x, y, held);
                if (where == BoxSide::Outside) return true;
                mixed = where == BoxSide::Mixed;
            }
            c.inner = s.kind == PieceKind::Patch && !mixed;
        } else {
            const double t0 = CGAL::to_double(s.t0), t1 = CGAL::to_double(s.t1);
            c.place = model_.place(
                s.face, s.arc, t0 + (t1 - t0) * std::ldexp(double(b.at.iu) + x.near(), -b.at.lu));
        }
        if (held && s.attained) c.hi = t.hi;
        out_.all.push_back(std::move(c));
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

    const AllPieces& model_;
    const Objective o_;
    const double bound_;
    const long budget_;
    std::deque<std::unique_ptr<Item>> queue_;
    Candidates out_;
};

}  // namespace

Candidates candidates(const AllPieces& model, const Objective& objective, double bound,
                      long nodes) {
    return Search(model, objective, bound, nodes).run();
}

}  // namespace feeler_oracle
