// The half of uv_curve.hpp that deals with points of circles.
#include <mpfi.h>

#include <algorithm>
#include <stdexcept>

#include "uv_curve.hpp"

namespace feeler_oracle {
namespace {

// An interval of any precision, outward by MPFI.
class Wide {
 public:
    explicit Wide(int bits) { mpfi_init2(x_, mpfr_prec_t(bits)); }
    Wide(int bits, const Q& q) : Wide(bits) { mpfi_set_q(x_, q.mpq()); }
    ~Wide() { mpfi_clear(x_); }
    Wide(const Wide&) = delete;
    mpfi_ptr get() { return x_; }
    mpfr_ptr lo() { return &x_->left; }
    mpfr_ptr hi() { return &x_->right; }

 private:
    mpfi_t x_;
};

Q to_q(mpfr_srcptr x) {
    if (!mpfr_number_p(x)) throw std::runtime_error("a coordinate out of MPFR's range");
    mpq_t q;
    mpq_init(q);
    mpfr_get_q(q, x);
    Q result(q);
    mpq_clear(q);
    return result;
}

Bounds bounds_of(Wide& x) { return {to_q(x.lo()), to_q(x.hi())}; }

// Adds [-width, width].
void widen(Wide& x, Wide& width) {
    mpfr_sub(x.lo(), x.lo(), width.hi(), MPFR_RNDD);
    mpfr_add(x.hi(), x.hi(), width.hi(), MPFR_RNDU);
}

// Cosine and sine of an angle: those of its lower bound, and the bounds' distance (both functions
// have slopes within [-1, 1]).
void cos_sin(const Q& angle, int bits, Wide& cos, Wide& sin) {
    Wide a(bits, angle), width(bits);
    mpfr_cos(cos.lo(), a.lo(), MPFR_RNDD);
    mpfr_cos(cos.hi(), a.lo(), MPFR_RNDU);
    mpfr_sin(sin.lo(), a.lo(), MPFR_RNDD);
    mpfr_sin(sin.hi(), a.lo(), MPFR_RNDU);
    mpfr_sub(width.hi(), a.hi(), a.lo(), MPFR_RNDU);
    widen(cos, width);
    widen(sin, width);
}

Q dot(const std::array<Q, 2>& a, const std::array<Q, 2>& b) { return a[0] * b[0] + a[1] * b[1]; }

// The unit vector x' turned by 90 degrees in the circle's sense is y / |x|.
std::array<Q, 2> turned(const Circle& c) {
    if (c.clockwise) return {c.x[1], -c.x[0]};
    return {-c.x[1], c.x[0]};
}

// Sign of a + b / sqrt(n), n > 0; of a alone if b is 0.
int sign_with_root(const Q& a, const Q& b, const Q& n) {
    const int sa = sign(a), sb = sign(b);
    if (sa == 0 || sa == sb) return sb;
    if (sb == 0) return sa;
    return sb * sign(b * b - a * a * n);
}

// Sign of a + sqrt(b) - sqrt(c) with the signs p, q before the roots instead of 1, -1.
int sign_with_roots(const Q& a, int p, const Q& b, int q, const Q& c) {
    // x = a + p sqrt(b), x^2 - c = a^2 + b - c + 2 a p sqrt(b).
    const int sx = sign_with_root(a, Q(p) * b, b), sc = sign(c) == 0 ? 0 : q;
    if (sx == 0 || sx == sc) return sc;
    if (sc == 0) return sx;
    return sx * sign_with_root(a * a + b - c, Q(2 * p) * a * b, b);
}

// A coordinate of a point of a circle is c + A cos t + B sin t, t = |angle|.
struct Wave {
    Q c, t;
    int sign_a, sign_b;
    Q a2, b2;  // A^2, B^2
};
bool operator==(const Wave& x, const Wave& y) {
    return x.c == y.c && x.t == y.t && x.sign_a == y.sign_a && x.sign_b == y.sign_b &&
           x.a2 == y.a2 && x.b2 == y.b2;
}

Wave wave(const CirclePoint& p, int k) {
    const Circle& c = p.circle;
    const Q y = turned(c)[k];
    const Q scale = c.radius * c.radius / dot(c.x, c.x);
    return {c.center[k],
            sign(p.angle) < 0 ? -p.angle : p.angle,
            sign(c.x[k]),
            sign(y) * sign(p.angle),
            scale * c.x[k] * c.x[k],
            sign(p.angle) == 0 ? Q(0) : scale * y * y};
}

// Sign of x * y - z * t, by bounds; 0 if not told apart.
int sign_of_cross(const std::array<Bounds, 2>& a, const std::array<Bounds, 2>& b) {
    const auto product = [](const Bounds& x, const Bounds& y) -> Bounds {
        const Q p[4] = {x.lo * y.lo, x.lo * y.hi, x.hi * y.lo, x.hi * y.hi};
        return {*std::min_element(p, p + 4), *std::max_element(p, p + 4)};
    };
    const Bounds p = product(a[0], b[1]), q = product(a[1], b[0]);
    if (p.lo > q.hi) return 1;
    return p.hi < q.lo ? -1 : 0;
}

// Where the direction of angle a points to, in half quarters: 2 m exactly at m quarter turns from
// +u, 2 m + 1 strictly between m and m + 1.
long half_quarters(const Circle& circle, const Q& angle) {
    const int su = sign(circle.x[0]), sv = sign(circle.x[1]);
    if (sign(angle) == 0) {
        if (sv == 0) return su > 0 ? 0 : 4;
        if (su == 0) return sv > 0 ? 2 : -2;
        if (sv > 0) return su > 0 ? 1 : 3;
        return su > 0 ? -1 : -3;
    }
    for (int bits = 128; bits <= kMostBits; bits *= 2) {
        // x / |x| = (cos, sin) of x's own angle: scaling by 1 / max(|x_0|, |x_1|) is not needed, as
        // MPFR has the range. The angle is monotone in each coordinate within a quadrant.
        Wide x(bits, circle.x[0]), y(bits, circle.x[1]), theta(bits), a(bits, angle);
        Wide p(bits), q(bits);
        mpfr_atan2(p.lo(), y.lo(), x.lo(), MPFR_RNDD);
        mpfr_atan2(p.hi(), y.lo(), x.lo(), MPFR_RNDU);
        // The coordinates are rounded to relative 2^(1 - bits), so the angle is off by at most
        // twice that.
        mpfr_set_ui_2exp(q.hi(), 8, -mpfr_exp_t(bits), MPFR_RNDU);
        widen(p, q);
        if (circle.clockwise)
            mpfi_sub(theta.get(), p.get(), a.get());
        else
            mpfi_add(theta.get(), p.get(), a.get());
        Wide half_pi(bits);
        mpfi_const_pi(half_pi.get());
        mpfi_div_2ui(half_pi.get(), half_pi.get(), 1);
        mpfi_div(theta.get(), theta.get(), half_pi.get());
        // Within 2^31 by the range of angles.
        if (mpfr_cmp_si(theta.lo(), -(1L << 40)) < 0 || mpfr_cmp_si(theta.hi(), 1L << 40) > 0)
            throw std::runtime_error("an angle out of range");
        const long lo = mpfr_get_si(theta.lo(), MPFR_RNDD), hi = mpfr_get_si(theta.hi(), MPFR_RNDD);
        if (lo == hi && !mpfr_integer_p(theta.lo())) return 2 * lo + 1;
    }
    throw std::runtime_error("the quarter of an arc's end is undecided at the top precision");
}

// Floor of k / 2.
long half_of(long k) { return (k - (k & 1)) / 2; }

}  // namespace

std::array<Bounds, 2> enclose(const EndPoint& point, int bits) {
    if (const auto* p = std::get_if<0>(&point))
        return {Bounds{(*p)[0], (*p)[0]}, Bounds{(*p)[1], (*p)[1]}};
    const auto& [circle, angle] = std::get<CirclePoint>(point);
    Wide scale(bits, circle.radius), length(bits, dot(circle.x, circle.x));
    mpfi_sqrt(length.get(), length.get());
    mpfi_div(scale.get(), scale.get(), length.get());
    Wide cos(bits), sin(bits);
    cos_sin(angle, bits, cos, sin);
    const auto y = turned(circle);
    std::array<Bounds, 2> out;
    for (int k = 0; k < 2; ++k) {
        Wide sum(bits), part(bits);
        mpfi_mul_q(sum.get(), cos.get(), circle.x[k].mpq());
        mpfi_mul_q(part.get(), sin.get(), y[k].mpq());
        mpfi_add(sum.get(), sum.get(), part.get());
        mpfi_mul(sum.get(), sum.get(), scale.get());
        mpfi_add_q(sum.get(), sum.get(), circle.center[k].mpq());
        out[k] = bounds_of(sum);
    }
    return out;
}

int compare(const EndPoint& point, int k, const Q& x) {
    if (const auto* p = std::get_if<0>(&point)) return sign((*p)[k] - x);
    const auto& [circle, angle] = std::get<CirclePoint>(point);
    if (sign(angle) == 0)
        return sign_with_root(circle.center[k] - x, circle.radius * circle.x[k],
                              dot(circle.x, circle.x));
    for (int bits = 128; bits <= kMostBits; bits *= 2) {
        const auto b = enclose(point, bits)[k];
        if (b.lo > x) return 1;
        if (b.hi < x) return -1;
    }
    throw std::runtime_error("the end of an arc is not told from the point at the top precision");
}

int compare(const EndPoint& a, const EndPoint& b, int k) {
    if (const auto* p = std::get_if<0>(&b)) return compare(a, k, (*p)[k]);
    if (const auto* p = std::get_if<0>(&a)) return -compare(b, k, (*p)[k]);
    const auto &p = std::get<CirclePoint>(a), &q = std::get<CirclePoint>(b);
    // Like those of equal arcs in a row: cheaper than the rest.
    if (p.circle.center[k] == q.circle.center[k] && p.angle == q.angle &&
        p.circle.radius == q.circle.radius && p.circle.x == q.circle.x &&
        p.circle.clockwise == q.circle.clockwise)
        return 0;
    const Wave x = wave(p, k), y = wave(q, k);
    if (x == y) return 0;
    if (sign(x.t) == 0 && sign(y.t) == 0)
        return sign_with_roots(x.c - y.c, x.sign_a, x.a2, -y.sign_a, y.a2);
    for (int bits = 128; bits <= kMostBits; bits *= 2) {
        const Bounds m = enclose(a, bits)[k], n = enclose(b, bits)[k];
        if (m.lo > n.hi) return 1;
        if (m.hi < n.lo) return -1;
    }
    throw std::runtime_error("the ends of two arcs are not told apart at the top precision");
}

namespace {

// 0 also where most_bits do not tell, which `told` says.
int orientation(const Segment& segment, const Q& u, const Q& v, int most_bits, bool& told) {
    told = true;
    const EndPoint *a = &segment.from, *b = &segment.to;
    int flip = 1;  // -1: the segment is looked at backwards
    if (a->index() == 0) {
        std::swap(a, b);
        flip = -1;
    }
    const auto* p = std::get_if<CirclePoint>(a);
    if (!p) throw std::logic_error("a segment between rational points");
    if (sign(p->angle) == 0 && b->index() == 0) {
        // (c - q + r x / |x|) x (b - q)
        const auto& to = std::get<0>(*b);
        const auto& c = p->circle;
        const Q bu = to[0] - u, bv = to[1] - v;
        return flip * sign_with_root((c.center[0] - u) * bv - (c.center[1] - v) * bu,
                                     c.radius * (c.x[0] * bv - c.x[1] * bu), dot(c.x, c.x));
    }
    if (b->index() == 0 && std::get<0>(*b) == std::array<Q, 2>{u, v}) return 0;
    for (int bits = 128; bits <= most_bits; bits *= 2) {
        auto from = enclose(*a, bits), to = enclose(*b, bits);
        for (auto* point : {&from, &to}) {
            (*point)[0] = {(*point)[0].lo - u, (*point)[0].hi - u};
            (*point)[1] = {(*point)[1].lo - v, (*point)[1].hi - v};
        }
        if (const int s = sign_of_cross(from, to)) return flip * s;
    }
    told = false;
    return 0;
}

}  // namespace

int orientation(const Segment& segment, const Q& u, const Q& v) {
    bool told;
    const int s = orientation(segment, u, v, kMostBits, told);
    if (told) return s;
    throw std::runtime_error(
        "a point is not told from the segment that joins two arcs at the top precision");
}

int likely_orientation(const Segment& segment, const Q& u, const Q& v) {
    bool told;
    return orientation(segment, u, v, kLikelyBits, told);
}

std::vector<QuarterArc> quarter_arcs(const CircularArc& arc) {
    const Circle& c = arc.circle;
    const bool forward = (arc.start < arc.end) != c.clockwise;
    const Q& first = forward ? arc.start : arc.end;
    const Q& last = forward ? arc.end : arc.start;
    const long begin = half_quarters(c, first);
    long end = half_quarters(c, last);
    constexpr long kTwoTurns = 16;
    if (end - begin >= 2 * kTwoTurns) end -= ((end - begin) / kTwoTurns - 1) * kTwoTurns;
    const auto at = [&](bool of_last) {
        const CircularArc whole{c, first, last};
        return end_point(whole, of_last);
    };
    std::vector<QuarterArc> out;
    EndPoint from = at(false);
    // The quarter between the extreme points m and m + 1.
    for (long m = half_of(begin); 2 * m < end; ++m) {
        constexpr int kU[4] = {1, 0, -1, 0}, kV[4] = {0, 1, 0, -1};
        const int now = int(((m % 4) + 4) % 4), next = (now + 1) % 4;
        EndPoint to = at(true);
        if (2 * (m + 1) < end)
            to = std::array<Q, 2>{c.center[0] + Q(kU[next]) * c.radius,
                                  c.center[1] + Q(kV[next]) * c.radius};
        const int sign_u = kU[now] + kU[next], sign_v = kV[now] + kV[next];
        out.push_back({from, to, sign_u, sign_v});
        from = to;
    }
    return out;
}

}  // namespace feeler_oracle
