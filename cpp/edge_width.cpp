#include "edge_width.hpp"

#include <algorithm>

#include "core.hpp"
#include "edge_near.hpp"
#include "net.hpp"

namespace feeler_oracle {
namespace {

using Vec = std::array<Interval, 3>;
using Curve = std::array<std::vector<Interval>, 4>;

Real sqrt_up(const Real& x) {
    Real r;
    mpfr_sqrt(r.get(), x.get(), MPFR_RNDU);
    return r;
}
Real sqrt_down(const Real& x) {
    Real r;
    mpfr_sqrt(r.get(), x.get(), MPFR_RNDD);
    return r;
}
Real larger(const Real& a, const Real& b) { return a < b ? b : a; }

Interval norm(const Vec& x) {
    const Interval s = square(x[0]) + square(x[1]) + square(x[2]);
    return {sqrt_down(s.lo), sqrt_up(s.hi)};
}
Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

// An image as a sequence of curves.
struct Chain {
    std::vector<Curve> curves;
    Real extra;  // what slack and crossings may add to a distance
    const Image* image;
};

Vec control_point(const Curve& c, std::size_t i) {
    Vec x;
    for (int k = 0; k < 3; ++k) x[k] = divide_positive(c[k][i], c[3][i]);
    return x;
}

Chain chain_of(const Image& image, bool backwards) {
    Chain chain;
    chain.image = &image;
    for (const Piece* p : image.pieces) {
        chain.curves.push_back(p->net);
        chain.extra = larger(chain.extra, Real(slack_of(*p)));
    }
    // A crossing's image stays within the box of its enclosures and of the ends beside it.
    Real widest;
    for (const Piece* b : image.between) {
        Vec hull_of = {divide_positive(b->net[0][0], b->net[3][0]),
                       divide_positive(b->net[1][0], b->net[3][0]),
                       divide_positive(b->net[2][0], b->net[3][0])};
        const auto widen = [&](const Vec& x) {
            for (int k = 0; k < 3; ++k) hull_of[k] = hull(hull_of[k], x[k]);
        };
        for (const Piece* o : image.between)
            if (o->arc == b->arc && o->t0 == b->t0)
                widen({divide_positive(o->net[0][0], o->net[3][0]),
                       divide_positive(o->net[1][0], o->net[3][0]),
                       divide_positive(o->net[2][0], o->net[3][0])});
        for (const Piece* p : image.pieces) {
            if (p->arc != b->arc) continue;
            if (p->t1 == b->t0) widen(control_point(p->net, p->net[3].size() - 1));
            if (p->t0 == b->t1) widen(control_point(p->net, 0));
        }
        Vec diagonal;
        for (int k = 0; k < 3; ++k) diagonal[k] = Interval(sub_up(hull_of[k].hi, hull_of[k].lo));
        widest = larger(widest, norm(diagonal).hi);
    }
    chain.extra = add_up(chain.extra, widest);
    if (backwards) {
        std::reverse(chain.curves.begin(), chain.curves.end());
        for (auto& c : chain.curves)
            for (auto& k : c) std::reverse(k.begin(), k.end());
    }
    return chain;
}

struct Position {
    std::size_t curve;
    Real t;
};

Curve part_of(const Curve& c, const Real& a, const Real& b) {
    Curve r;
    const bool whole = a.sign() == 0 && b.near() == 1 && mpfr_cmp_ui(b.get(), 1) == 0;
    for (int k = 0; k < 4; ++k)
        r[k] = whole ? c[k] : restrict_u(Net{int(c[k].size()) - 1, 0, c[k]}, a, b).c;
    return r;
}

struct CurveJet {
    Vec x, dx;
};

CurveJet jet(const Curve& c, const Real& t) {
    const Interval it(t);
    std::array<Interval, 4> value, slope;
    for (int k = 0; k < 4; ++k) {
        auto b = c[k];
        const std::size_t n = b.size();
        for (std::size_t level = 1; level + 1 < n; ++level)
            for (std::size_t i = 0; i + level < n; ++i) b[i] = b[i] + it * (b[i + 1] - b[i]);
        if (n == 1) {
            value[k] = b[0];
        } else {
            slope[k] = Interval(double(n - 1)) * (b[1] - b[0]);
            value[k] = b[0] + it * (b[1] - b[0]);
        }
    }
    CurveJet r;
    for (int k = 0; k < 3; ++k) {
        r.x[k] = divide_positive(value[k], value[3]);
        r.dx[k] = divide_positive(slope[k] - slope[3] * r.x[k], value[3]);
    }
    return r;
}

struct Near64 {
    double t;
    double square;  // of the distance
};

// About the nearest point to p of the curve over [lo, hi]; no guarantee. In doubles relative to p.
Near64 near64(const Curve& c, const Real& lo, const Real& hi, const Vec& p) {
    constexpr int kStarts = 8;
    constexpr int kSteps64 = 20;
    std::array<std::vector<double>, 4> d;
    for (std::size_t i = 0; i < c[3].size(); ++i) {
        for (int k = 0; k < 3; ++k) d[k].push_back((c[k][i] - p[k] * c[3][i]).lo.near());
        d[3].push_back(c[3][i].lo.near());
    }
    struct Jet64 {
        std::array<double, 3> x, dx;
    };
    std::vector<double> b;
    const auto jet64 = [&](double t) {
        std::array<double, 4> value{}, slope{};
        for (int k = 0; k < 4; ++k) {
            b = d[k];
            const std::size_t n = b.size();
            for (std::size_t level = 1; level + 1 < n; ++level)
                for (std::size_t i = 0; i + level < n; ++i) b[i] += t * (b[i + 1] - b[i]);
            slope[k] = n == 1 ? 0 : double(n - 1) * (b[1] - b[0]);
            value[k] = n == 1 ? b[0] : b[0] + t * (b[1] - b[0]);
        }
        Jet64 r;
        for (int k = 0; k < 3; ++k) {
            r.x[k] = value[k] / value[3];
            r.dx[k] = (slope[k] - slope[3] * r.x[k]) / value[3];
        }
        return r;
    };
    const double lo64 = lo.near(), hi64 = hi.near();
    const auto square64 = [](const std::array<double, 3>& x) {
        return x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    };
    double at = lo64, least = std::numeric_limits<double>::infinity();
    for (int s = 0; s <= kStarts; ++s) {
        const double t = lo64 + (hi64 - lo64) * s / kStarts;
        const double d2 = square64(jet64(t).x);
        if (d2 < least) {
            least = d2;
            at = t;
        }
    }
    for (int step = 0; step < kSteps64; ++step) {
        const Jet64 j = jet64(at);
        const double top = j.x[0] * j.dx[0] + j.x[1] * j.dx[1] + j.x[2] * j.dx[2];
        const double next = std::min(std::max(at - top / square64(j.dx), lo64), hi64);
        if (!(next != at)) break;
        at = next;
    }
    return {at, square64(jet64(at).x)};
}

// The same, after some steps of Newton's in Intervals from there: distances far below the rounding
// of coordinates count here.
Real polished(const Curve& c, const Real& lo, const Real& hi, const Vec& p, double at) {
    constexpr int kSteps = 5;
    Real t(at);
    const auto clamp = [&] {
        if (t < lo) t = lo;
        if (hi < t) t = hi;
    };
    clamp();
    for (int step = 0; step < kSteps; ++step) {
        const CurveJet j = jet(c, t);
        const Vec x = minus(j.x, p);
        Interval top(0.0), bottom(0.0);
        for (int k = 0; k < 3; ++k) {
            top = top + x[k] * j.dx[k];
            bottom = bottom + square(j.dx[k]);
        }
        const Real below = bottom.middle();
        if (below.sign() <= 0) break;
        const Real before = t, move = div_down(top.middle(), below);
        mpfr_sub(t.get(), t.get(), move.get(), MPFR_RNDN);
        clamp();
        // Far finer than any width that is asked for.
        if (std::fabs(sub_down(t, before).near()) < 0x1p-140) break;
    }
    return t;
}

Real project(const Curve& c, const Real& lo, const Real& hi, const Vec& p) {
    return polished(c, lo, hi, p, near64(c, lo, hi, p).t);
}

struct Pair {
    std::size_t i, j;  // curves
    Real a0, a1, b0, b1;
    Real bound;
    int depth;
};

struct Candidate {
    Vec at;
    bool on_first;
    Real distance;  // from the matched point of the other image
};

class Matching {
 public:
    Matching(const Chain& a, const Chain& b, const Real& floor) : a_(a), b_(b), floor_(floor) {}

    CrackWidth run(int budget, const Real& ends) {
        // Without cuts the bound above is rough anyway, to the rounding of coordinates, and that
        // below is the ends'.
        polish_ = budget > 0;
        Real lower = ends;
        for (const int end : {0, 1}) {
            candidate(end_of(a_, end), end_of(b_, end));
        }
        whole({0, Real(0.0)}, {a_.curves.size() - 1, Real(1.0)}, {0, Real(0.0)},
              {b_.curves.size() - 1, Real(1.0)});
        CrackWidth result;
        const auto smaller = [](const Pair& x, const Pair& y) { return x.bound < y.bound; };
        std::make_heap(pairs_.begin(), pairs_.end(), smaller);
        Real upper = add_up(pairs_.front().bound, extra());
        while (true) {
            upper = add_up(pairs_.front().bound, extra());
            if (enough(lower, upper)) break;
            if (budget > 0) raise(lower);
            if (enough(lower, upper) || result.cuts >= budget) break;
            std::pop_heap(pairs_.begin(), pairs_.end(), smaller);
            const Pair p = pairs_.back();
            pairs_.pop_back();
            ++result.cuts;
            cut(p);
            for (int k = 0; k < 2; ++k)
                std::push_heap(pairs_.begin(), pairs_.end() - (1 - k), smaller);
        }
        if (upper < lower) lower = upper;  // both hold: only by rounding
        result.d = Interval(lower, upper);
        return result;
    }

 private:
    static Vec end_of(const Chain& c, bool last) {
        const Curve& curve = last ? c.curves.back() : c.curves.front();
        return control_point(curve, last ? curve[3].size() - 1 : 0);
    }

    Real extra() const { return add_up(a_.extra, b_.extra); }

    bool enough(const Real& lower, const Real& upper) const {
        return upper <= floor_ || upper <= mul_down(lower, Real(1 + 0x1p-10));
    }

    void candidate(const Vec& at, const Vec& other) {
        const Real d = norm(minus(at, other)).lo;
        candidates_.push_back({at, true, d});
        candidates_.push_back({other, false, d});
    }

    // Tries to prove a larger lower bound from the farthest matched points.
    void raise(Real& lower) {
        const auto nearer = [](const Candidate& x, const Candidate& y) {
            return x.distance < y.distance;
        };
        while (!candidates_.empty()) {
            const auto best = std::max_element(candidates_.begin(), candidates_.end(), nearer);
            if (best->distance <= mul_up(lower, Real(1 + 0x1p-11)) || best->distance <= floor_) {
                candidates_.clear();
                return;
            }
            const Candidate c = *best;
            candidates_.erase(best);
            if (++tries_ > kTries) return;
            // Nearly all of it, or what part is left of it.
            for (const double part : {1 - 0x1p-12, 0.9, 0.5}) {
                const Real r = mul_down(c.distance, Real(part));
                if (r <= lower) break;
                if (farther(c, r)) {
                    // The point itself may be off by its own slack.
                    const Real proven = sub_down(r, (c.on_first ? a_ : b_).extra);
                    lower = larger(lower, proven);
                    break;
                }
            }
        }
    }

    bool farther(const Candidate& c, const Real& r) const {
        NearTarget target;
        target.origin = c.at;
        const Image& image = *(c.on_first ? b_ : a_).image;
        for (const auto* pieces : {&image.pieces, &image.between})
            for (const Piece* p : *pieces)
                if (near_piece(target, *p, Interval(r)) != Near::No) return false;
        return true;
    }

    void add(std::size_t i, const Real& a0, const Real& a1, std::size_t j, const Real& b0,
             const Real& b1, int depth) {
        Curve a = part_of(a_.curves[i], a0, a1), b = part_of(b_.curves[j], b0, b1);
        // The coefficients of a product are sums of products of these, over a factor of all four.
        for (Curve* c : {&a, &b}) {
            const int degree = int((*c)[3].size()) - 1;
            for (int s = 0; s <= degree; ++s)
                for (auto& row : *c)
                    row[std::size_t(s)] = binomial(degree, s) * row[std::size_t(s)];
        }
        const int m = int(a[3].size()) - 1, n = int(b[3].size()) - 1;
        Real most;
        for (int k = 0; k <= m + n; ++k) {
            std::array<Interval, 4> sum;
            for (int s = std::max(0, k - n); s <= std::min(k, m); ++s) {
                for (int c = 0; c < 3; ++c)
                    sum[c] = sum[c] + (a[c][s] * b[3][k - s] - b[c][k - s] * a[3][s]);
                sum[3] = sum[3] + a[3][s] * b[3][k - s];
            }
            const Real d2 = (square(sum[0]) + square(sum[1]) + square(sum[2])).hi;
            most = larger(most, div_up(sqrt_up(d2), sum[3].lo));
        }
        pairs_.push_back({i, j, a0, a1, b0, b1, most, depth});
    }

    // Matches two stretches of the chains.
    void whole(Position a0, Position a1, Position b0, Position b1) {
        struct Task {
            Position a0, a1, b0, b1;
        };
        std::vector<Task> stack{{a0, a1, b0, b1}};
        while (!stack.empty()) {
            const Task t = stack.back();
            stack.pop_back();
            if (t.a0.curve == t.a1.curve && t.b0.curve == t.b1.curve) {
                add(t.a0.curve, t.a0.t, t.a1.t, t.b0.curve, t.b0.t, t.b1.t, 0);
                continue;
            }
            // Cut one at a joint, the other at the nearest point.
            const bool first = t.a1.curve - t.a0.curve >= t.b1.curve - t.b0.curve;
            const Chain& own = first ? a_ : b_;
            const Chain& other = first ? b_ : a_;
            const Position &o0 = first ? t.a0 : t.b0, &o1 = first ? t.a1 : t.b1;
            const Position &n0 = first ? t.b0 : t.a0, &n1 = first ? t.b1 : t.a1;
            const std::size_t middle = (o0.curve + o1.curve) / 2;  // < o1.curve
            const Curve& before = own.curves[middle];
            const Vec p = control_point(before, before[3].size() - 1);
            // Which curve it is on, doubles tell well enough: any matching will do.
            const auto from = [&](std::size_t c) { return c == n0.curve ? n0.t : Real(0.0); };
            const auto to = [&](std::size_t c) { return c == n1.curve ? n1.t : Real(1.0); };
            std::size_t nearest = n0.curve;
            Near64 least{n0.t.near(), std::numeric_limits<double>::infinity()};
            for (std::size_t c = n0.curve; c <= n1.curve; ++c) {
                const Near64 here = near64(other.curves[c], from(c), to(c), p);
                if (here.square < least.square) {
                    least = here;
                    nearest = c;
                }
            }
            Position best{nearest, Real(least.t)};
            if (polish_)
                best.t = polished(other.curves[nearest], from(nearest), to(nearest), p, least.t);
            // The ends of the stretch are no doubles.
            if (best.t < from(nearest)) best.t = from(nearest);
            if (to(nearest) < best.t) best.t = to(nearest);
            if (polish_) {
                const Vec q = jet(other.curves[best.curve], best.t).x;
                first ? candidate(p, q) : candidate(q, p);
            }
            const Position end{middle, Real(1.0)}, start{middle + 1, Real(0.0)};
            if (first) {
                stack.push_back({t.a0, end, t.b0, best});
                stack.push_back({start, t.a1, best, t.b1});
            } else {
                stack.push_back({t.a0, best, t.b0, end});
                stack.push_back({best, t.a1, start, t.b1});
            }
        }
    }

    void cut(const Pair& p) {
        // The two in turn: each is then sampled evenly.
        const bool first = p.depth % 2 == 0;
        Real s, r;
        if (first) {
            s = Interval(p.a0, p.a1).middle();
            const Vec at = jet(a_.curves[p.i], s).x;
            r = project(b_.curves[p.j], p.b0, p.b1, at);
        } else {
            r = Interval(p.b0, p.b1).middle();
            const Vec at = jet(b_.curves[p.j], r).x;
            s = project(a_.curves[p.i], p.a0, p.a1, at);
        }
        candidate(jet(a_.curves[p.i], s).x, jet(b_.curves[p.j], r).x);
        add(p.i, p.a0, s, p.j, p.b0, r, p.depth + 1);
        add(p.i, s, p.a1, p.j, r, p.b1, p.depth + 1);
    }

    static constexpr int kTries = 40;

    const Chain &a_, &b_;
    Real floor_;
    bool polish_ = true;
    std::vector<Pair> pairs_;
    std::vector<Candidate> candidates_;
    int tries_ = 0;
};

}  // namespace

CrackWidth crack_width(const Pieces& pieces, const EdgeImages& edges, int edge, int budget) {
    CrackWidth result;
    const auto& uses = edges.uses[edge];
    for (std::size_t i = 0; i < uses.size() && uses.size() > 1; ++i) {
        const Image& image = edges.images[uses[i]];
        if (!image.whole || image.pieces.empty()) {
            result.known = false;
            return result;
        }
    }
    Real floor(pieces.size());
    mpfr_div_2ui(floor.get(), floor.get(), kCrackFloorBits, MPFR_RNDD);
    for (std::size_t i = 0; i < uses.size(); ++i)
        for (std::size_t j = i + 1; j < uses.size(); ++j) {
            const Chain a = chain_of(edges.images[uses[i]], false);
            // Either direction will do for a bound above; the ends bound both below.
            const bool against = uses.size() == 2 && edges.against[edge];
            const Chain b = chain_of(edges.images[uses[j]], against);
            const auto end = [](const Chain& c, bool last) {
                const Curve& curve = last ? c.curves.back() : c.curves.front();
                return control_point(curve, last ? curve[3].size() - 1 : 0);
            };
            const auto apart = [&](bool x, bool y) { return norm(minus(end(a, x), end(b, y))).lo; };
            const Real with = larger(apart(false, false), apart(true, true));
            const Real turned = larger(apart(false, true), apart(true, false));
            Real ends = with < turned ? with : turned;
            ends = sub_down(ends, add_up(a.extra, b.extra));
            if (ends.sign() < 0) ends = Real(0.0);
            const CrackWidth one = Matching(a, b, floor).run(budget, ends);
            result.cuts += one.cuts;
            result.d.lo = larger(result.d.lo, one.d.lo);
            result.d.hi = larger(result.d.hi, one.d.hi);
        }
    return result;
}

Edges::Edges(const Core& core) : pieces_(core.pieces()), images_(edge_images(core)) {
    widths_.resize(images_.uses.size());
    rough_.resize(images_.uses.size());
}

double Edges::rough(int edge) const {
    auto& slot = rough_.at(std::size_t(edge));
    if (!slot) {
        const CrackWidth w = crack_width(pieces_, images_, edge, 0);
        slot = w.known ? w.d.hi.up() : std::numeric_limits<double>::infinity();
    }
    return *slot;
}

const CrackWidth& Edges::width(int edge) const {
    auto& slot = widths_.at(std::size_t(edge));
    if (!slot) slot = crack_width(pieces_, images_, edge);
    return *slot;
}

}  // namespace feeler_oracle
