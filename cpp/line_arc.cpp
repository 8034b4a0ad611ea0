#include "line_arc.hpp"

#include <gmp.h>

#include <algorithm>

namespace feeler_oracle {
namespace {

using Q2 = std::array<Q, 2>;

constexpr int kFirstBits = 384;

Q dot(const Q2& a, const Q2& b) { return a[0] * b[0] + a[1] * b[1]; }
Q cross(const Q2& a, const Q2& b) { return a[0] * b[1] - a[1] * b[0]; }
Q2 minus(const Q2& a, const Q2& b) { return {a[0] - b[0], a[1] - b[1]}; }

// The root of x > 0, to about so many bits of it.
Bounds root_of(const Q& x, int bits) {
    const long size =
        long(mpz_sizeinbase(mpq_numref(x.mpq()), 2)) - long(mpz_sizeinbase(mpq_denref(x.mpq()), 2));
    // x 4^shift has 2 bits binary digits or more.
    const long shift = std::max(0L, long(bits) - size / 2 + 1);
    mpz_t n;
    mpz_init(n);
    mpz_mul_2exp(n, mpq_numref(x.mpq()), mp_bitcnt_t(2 * shift));
    mpz_fdiv_q(n, n, mpq_denref(x.mpq()));
    mpz_sqrt(n, n);
    const auto scaled = [&] {
        mpq_t q;
        mpq_init(q);
        mpq_set_z(q, n);
        mpq_div_2exp(q, q, mp_bitcnt_t(shift));
        Q result(q);
        mpq_clear(q);
        return result;
    };
    Bounds b;
    b.lo = scaled();
    mpz_add_ui(n, n, 1);
    b.hi = scaled();
    mpz_clear(n);
    return b;
}

Bounds plus(const Q& a, const Bounds& b, const Q& factor) {
    if (sign(factor) >= 0) return {a + factor * b.lo, a + factor * b.hi};
    return {a + factor * b.hi, a + factor * b.lo};
}

// The point start + t along of the circle, t = middle + branch sqrt(square).
struct CrossingPoint {
    const Q2 &start, &along;
    Q middle, square;
    int branch;  // 0: t is rational, and `middle`

    Bounds t(int bits) const {
        if (branch == 0) return {middle, middle};
        return plus(middle, root_of(square, bits), Q(branch));
    }
    Bounds coordinate(int k, int bits) const { return plus(start[k], t(bits), along[k]); }
    bool rational(int k) const { return branch == 0 || sign(along[k]) == 0; }
    Q exact(int k) const { return start[k] + middle * along[k]; }

    // Sign of coordinate k minus x.
    std::optional<int> compared(int k, const Q& x) const {
        if (rational(k)) return sign(exact(k) - x);
        for (int bits = kFirstBits; bits <= kMostBits; bits *= 2) {
            const Bounds b = coordinate(k, bits);
            if (b.lo > x) return 1;
            if (b.hi < x) return -1;
        }
        return std::nullopt;
    }

    // Sign of u minus that of an end of a quarter which holds both, if they are on it.
    std::optional<int> compared(const EndPoint& end) const {
        if (const auto* p = std::get_if<0>(&end)) return compared(0, (*p)[0]);
        if (rational(0)) return -compare(end, 0, exact(0));
        const auto& [circle, angle] = std::get<CirclePoint>(end);
        if (sign(angle) == 0 && sign(cross(along, circle.x)) == 0 &&
            sign(cross(minus(start, circle.center), circle.x)) == 0 &&
            branch * sign(dot(along, circle.x)) > 0)
            return 0;
        for (int bits = kFirstBits; bits <= kMostBits; bits *= 2) {
            const Bounds own = coordinate(0, bits), other = enclose(end, bits)[0];
            if (own.lo > other.hi) return 1;
            if (own.hi < other.lo) return -1;
        }
        return std::nullopt;
    }
};

// Whether a point of the circle is in this part of it.
std::optional<bool> holds(const QuarterArc& quarter, const Circle& circle, const CrossingPoint& p) {
    for (int k = 0; k < 2; ++k) {
        const auto s = p.compared(k, circle.center[k]);
        if (!s) return std::nullopt;
        if (*s * (k == 0 ? quarter.sign_u : quarter.sign_v) < 0) return false;
    }
    // Counter-clockwise above the center is towards smaller u.
    const bool falls = quarter.sign_v > 0;
    const auto low = p.compared(falls ? quarter.to : quarter.from),
               high = p.compared(falls ? quarter.from : quarter.to);
    if (!low || !high) return std::nullopt;
    return *low >= 0 && *high <= 0;
}

// Sign of a + b / sqrt(n), n > 0.
int sign_with_root(const Q& a, const Q& b, const Q& n) {
    const int sa = sign(a), sb = sign(b);
    if (sa == 0 || sa == sb) return sb;
    if (sb == 0) return sa;
    return sb * sign(b * b - a * a * n);
}

Bounds product(const Q& a, const Bounds& b) { return plus(Q(0), b, a); }
Bounds sum(const Bounds& a, const Bounds& b) { return {a.lo + b.lo, a.hi + b.hi}; }

// v.(point - start), enclosed.
Bounds along_of(const Q2& v, const EndPoint& point, const Q2& start, int bits) {
    const auto e = enclose(point, bits);
    return plus(-dot(v, start), sum(product(v[0], e[0]), product(v[1], e[1])), Q(1));
}

// On which side of the line an end is: the sign of across.(point - start).
std::optional<int> side_of(const Q2& across, const EndPoint& point, const Q2& start) {
    if (const auto* p = std::get_if<0>(&point)) return sign(dot(across, minus(*p, start)));
    const auto& [circle, angle] = std::get<CirclePoint>(point);
    if (sign(angle) == 0)
        return sign_with_root(dot(across, minus(circle.center, start)),
                              circle.radius * dot(across, circle.x), dot(circle.x, circle.x));
    for (int bits = kFirstBits; bits <= kMostBits; bits *= 2) {
        const Bounds b = along_of(across, point, start, bits);
        if (sign(b.lo) > 0) return 1;
        if (sign(b.hi) < 0) return -1;
    }
    return std::nullopt;
}

}  // namespace

bool arc_breaks(const CircularArc& arc, const std::array<Q, 2>& start,
                const std::array<Q, 2>& along, std::vector<LineBreak>& breaks) {
    const Circle& c = arc.circle;
    const Q2 from = minus(start, c.center);
    const Q a = dot(along, along), b = dot(along, from),
            rest = dot(from, from) - c.radius * c.radius;
    const Q middle = -b / a, square = middle * middle - rest / a;
    if (sign(square) < 0) return true;
    std::vector<CrossingPoint> points;
    if (sign(square) == 0) {
        points.push_back({start, along, middle, Q(0), 0});
    } else if (const auto root = rational_root(square)) {
        points.push_back({start, along, middle - *root, Q(0), 0});
        points.push_back({start, along, middle + *root, Q(0), 0});
    } else {
        points.push_back({start, along, middle, square, -1});
        points.push_back({start, along, middle, square, 1});
    }
    const auto quarters = quarter_arcs(arc);
    for (const CrossingPoint& p : points)
        for (const QuarterArc& quarter : quarters) {
            const auto on = holds(quarter, c, p);
            if (!on) return false;
            if (!*on) continue;
            const Bounds t = p.t(kFirstBits);
            breaks.push_back({t.lo, t.hi});
            break;
        }
    return true;
}

bool arc_breaks(const Segment& segment, const std::array<Q, 2>& start,
                const std::array<Q, 2>& along, std::vector<LineBreak>& breaks) {
    const Q2 across{-along[1], along[0]};
    const auto s0 = side_of(across, segment.from, start), s1 = side_of(across, segment.to, start);
    if (!s0 || !s1) return false;
    if (*s0 * *s1 > 0) return true;
    const Q length2 = dot(along, along);
    const auto at = [&](const EndPoint& p) {
        const Bounds b = along_of(along, p, start, kFirstBits);
        return Bounds{b.lo / length2, b.hi / length2};
    };
    const Bounds t0 = at(segment.from), t1 = at(segment.to);
    if (*s0 == 0) breaks.push_back({t0.lo, t0.hi});
    if (*s1 == 0) breaks.push_back({t1.lo, t1.hi});
    if (*s0 == 0 || *s1 == 0) return true;
    // Between: weights f1 and f0, the distances of the other end from the line.
    for (int bits = kFirstBits; bits <= kMostBits; bits *= 2) {
        Bounds f0 = product(Q(*s0), along_of(across, segment.from, start, bits)),
               f1 = product(Q(*s1), along_of(across, segment.to, start, bits));
        if (sign(f0.lo) <= 0 || sign(f1.lo) <= 0) continue;
        // t = t0 + s (t1 - t0), s = f0 / (f0 + f1) increasing in f0, decreasing in f1.
        const Bounds s{f0.lo / (f0.lo + f1.hi), f0.hi / (f0.hi + f1.lo)};
        const Bounds d{t1.lo - t0.hi, t1.hi - t0.lo};
        const Q ends[4] = {s.lo * d.lo, s.lo * d.hi, s.hi * d.lo, s.hi * d.hi};
        breaks.push_back(
            {t0.lo + *std::min_element(ends, ends + 4), t0.hi + *std::max_element(ends, ends + 4)});
        return true;
    }
    return false;
}

}  // namespace feeler_oracle
