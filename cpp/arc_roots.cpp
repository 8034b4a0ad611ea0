#include "arc_roots.hpp"

#include <algorithm>
#include <cmath>

namespace feeler_oracle {
namespace {

// Enough for a first look; the same as Interval's.
constexpr long kFirstBits = 320;
// Signs that take more digits than this are left open. At 2^17 bits one evaluation of a bicubic's
// polynomials takes some 20 ms.
constexpr long kMostBits = 1L << 17;
// A root's box is so narrow.
constexpr long kRootWidth = 256;
// Signs at the ends of an arc that take more than this are 0 for all that is known.
constexpr long kEndBits = 4096;
// Rational guesses from so many digits at most: the continued fraction takes quadratic time.
constexpr long kGuessBits = 1L << 13;

Q dyadic(double x) { return Q(x); }

// x rounded to a multiple of 2^-bits.
Q rounded(const Q& x, long bits) {
    Z n = x.numerator();
    Z scaled;
    mpz_mul_2exp(scaled.mpz(), n.mpz(), mp_bitcnt_t(bits));
    Z r;
    mpz_fdiv_q(r.mpz(), scaled.mpz(), x.denominator().mpz());
    Z one(1), scale;
    mpz_mul_2exp(scale.mpz(), one.mpz(), mp_bitcnt_t(bits));
    return Q(r, scale);
}

// About -log2 of x > 0.
long digits(const Q& x) {
    return long(mpz_sizeinbase(x.denominator().mpz(), 2)) -
           long(mpz_sizeinbase(x.numerator().mpz(), 2));
}

struct Place {
    // A root of J_level on the arc, simple in it: between y0 and y1, where J_level has the signs
    // `left` and -left.
    int level;
    Q y0, y1;
    int left;
    std::optional<std::array<Q, 2>> exact;
};

class Arc {
 public:
    const Tower& tower;
    Q x0, x1, y0, y1;
    Big a_x, slope;  // over the box
    int sign_a_x;

    // The curve's x at y, a point.
    Big x_at(const Q& y, long bits) const {
        // Interval Newton for A(., y), from the whole range; there is exactly one zero.
        std::vector<Big> c;
        const Big by(y, bits);
        const BiPoly& a = tower.a();
        for (int i = 0; i <= a.p; ++i) {
            Big s(Q(0), bits);
            for (int j = a.q; j >= 0; --j) {
                mpfi_mul(s.get(), s.get(), by.get());
                mpfi_add_z(s.get(), s.get(), a.at(i, j).mpz());
            }
            c.push_back(std::move(s));
        }
        const auto value_and_slope = [&](const Big& x, Big& v, Big& d) {
            v = c.back();
            d = Big(Q(0), bits);
            for (int i = a.p - 1; i >= 0; --i) {
                d = d * x + v;
                v = v * x + c[std::size_t(i)];
            }
        };
        // From half the digits, so that the last steps alone cost what they must.
        Big x =
            bits > 2 * kFirstBits ? meet(x_at(y, bits / 2), Big(x0, x1, bits)) : Big(x0, x1, bits);
        Big v(bits), d(bits), ignored(bits);
        double width = x.width();
        for (int round = 0; round < 400; ++round) {
            value_and_slope(x, ignored, d);
            Big over = d.sign() == sign_a_x ? meet(d, a_x) : a_x;
            const Big m(x.middle(), bits);
            value_and_slope(m, v, ignored);
            x = meet(x, m - v / over);
            const double now = x.width();
            if (!(now < 0.75 * width)) break;
            width = now;
            if (width == 0) break;
        }
        return x;
    }

    // The curve's x over [lo, hi].
    Big x_over(const Q& lo, const Q& hi, long bits) const {
        const Q mid = (lo + hi) * Q(1, 2);
        return meet(x_at(mid, bits) + slope * Big(lo - mid, hi - mid, bits), Big(x0, x1, bits));
    }

    // Sign of J_k at the arc's point over y; 0 where that is not found.
    int sign_at(int k, const Q& y, long most = kEndBits) const {
        for (long bits = kFirstBits;; bits *= 2) {
            const int s = value(tower.level(k), x_at(y, bits), Big(y, bits)).sign();
            if (s != 0 || bits >= most) return s;
        }
    }

    void narrow(Place& p, long bits) const;
    bool guess(Place& p) const;
    // Sign of J_k at p, exactly; nothing where it takes too many digits.
    std::optional<int> sign_of(int k, Place& p) const;
};

// Halves, or better, the place until it is no wider than 2^-bits.
void Arc::narrow(Place& p, long bits) const {
    if (p.exact) return;
    const BiPoly &g = tower.level(p.level), &dg = tower.level(p.level + 1);
    const Q half(1, 2), least(Z(1), Z(1) << bits);
    // Puts y in, by its sign; says whether that is known.
    const auto cut = [&](const Q& y) {
        if (y <= p.y0 || p.y1 <= y) return true;
        const int s = sign_at(p.level, y, 4 * kEndBits + 4 * bits);
        if (s == 0) return false;
        (s == p.left ? p.y0 : p.y1) = y;
        return true;
    };
    for (long round = 0; p.y1 - p.y0 > least && round < 4 * bits; ++round) {
        const Q width = p.y1 - p.y0;
        const long known = std::max(digits(width), 0L);
        // Newton's step from the middle, as if it were to double the digits.
        const long precision = std::max(kFirstBits, 4 * known + 128);
        const Q m = rounded((p.y0 + p.y1) * half, known + 64);
        const Big x = x_at(m, precision), y(m, precision);
        const Big v = value(g, x, y), d = value(dg, x, y);
        if (d.sign() != 0) {
            const Q step = (v * value(tower.a_x(), x, y) / d).middle();
            Q reach = step * step;
            if (reach > width * Q(1, 64)) reach = width * Q(1, 64);
            if (reach < least * Q(1, 8)) reach = least * Q(1, 8);
            const long places = std::max(digits(reach) + 8, 0L);
            const Q to = rounded(m - step, places);
            reach = rounded(reach, places) + Q(Z(1), Z(1) << places);
            cut(to - reach);
            cut(to + reach);
        }
        if (p.y1 - p.y0 > width * half && !cut(m)) {
            // The middle is too near the root for a sign: another place.
            if (!cut(rounded(p.y0 + width * Q(1, 3), known + 64))) return;
        }
    }
}

// Whether the root is a rational point of few digits: tried where the digits known would show one
// of half as many.
bool Arc::guess(Place& p) const {
    const long bits = digits(p.y1 - p.y0);
    if (bits > kGuessBits) return false;
    const Q y = simplest(p.y0, p.y1);
    if (2 * long(mpz_sizeinbase(y.denominator().mpz(), 2)) > bits) return false;
    const Big at = x_at(y, 2 * bits + kFirstBits);
    const Q x = simplest(at.lo(), at.hi());
    if (CGAL::sign(value(tower.a(), x, y)) != CGAL::ZERO ||
        CGAL::sign(value(tower.level(p.level), x, y)) != CGAL::ZERO)
        return false;
    // On the arc, and there J_level has one root between y0 and y1.
    p.exact = {x, y};
    p.y0 = p.y1 = y;
    return true;
}

std::optional<int> Arc::sign_of(int k, Place& p) const {
    const BiPoly& f = tower.level(k);
    if (f.is_zero()) return 0;
    std::optional<long> bound;
    for (long bits = kRootWidth;;) {
        tower.work += bits > kRootWidth ? bits / 64 : 0;
        if (!p.exact) {
            narrow(p, bits);
            if (!guess(p) && digits(p.y1 - p.y0) < bits - 2) return std::nullopt;
        }
        if (p.exact) return int(CGAL::sign(value(f, (*p.exact)[0], (*p.exact)[1])));
        const long precision = bits + kFirstBits;
        const Big v = value(f, x_over(p.y0, p.y1, precision), Big(p.y0, p.y1, precision));
        if (v.sign() != 0) return v.sign();
        if (!bound) {
            if (!tower.coprime_with(p.level)) return std::nullopt;
            const BiPoly &a = tower.a(), &b = tower.level(p.level);
            const long la = length_bits(a), lb = length_bits(b);
            const long degree = long(a.p) * b.q + long(a.q) * b.p;
            bound =
                f.p * (b.q * la + a.q * lb) + f.q * (b.p * la + a.p * lb) + degree * length_bits(f);
        }
        if (v.below(*bound)) return 0;
        // So narrow a place that J_k over it is narrower than the bound.
        const long enough = *bound + length_bits(f) + kFirstBits;
        if (bits >= enough || enough > kMostBits) return std::nullopt;
        bits = std::min(4 * bits, enough);
    }
}

// Bounds over the box of half sizes hx, hy about the point of the shifted coefficients.
struct Bounds {
    Big value, dx, dy;
};
Bounds bounds(const BiPoly& f, const std::vector<Big>& c, const Big& x, const Big& y) {
    const long bits = x.bits();
    Bounds b{Big(Q(0), bits), Big(Q(0), bits), Big(Q(0), bits)};
    for (int i = f.p; i >= 0; --i) {
        Big row(Q(0), bits), row_dy(Q(0), bits);
        for (int j = f.q; j >= 0; --j) {
            row_dy = row_dy * y + row;
            row = row * y + c[std::size_t(i * (f.q + 1) + j)];
        }
        b.dx = b.dx * x + b.value;
        b.value = b.value * x + row;
        b.dy = b.dy * x + row_dy;
    }
    return b;
}

// The largest box about (x, y) of at most these half sizes that the method's conditions hold in.
std::optional<Arc> make_arc(const Tower& tower, int m, const Q& x, const Q& y, double size_x,
                            double size_y) {
    constexpr long kBits = 256;
    constexpr int kHalvings = 7;
    const BiPoly &a = tower.a(), &b = tower.level(std::max(m - 1, 0));
    auto ca = shifted(a, x, y, kBits);
    const auto cb = shifted(b, x, y, kBits);
    // To the range of doubles.
    const long scale = length_bits(a);
    for (Big& c : ca) mpfi_div_2exp(c.get(), c.get(), std::size_t(scale));
    const double at = ca[0].magnitude();
    double hx = size_x, hy = size_y;
    for (int k = 0; k < kHalvings; ++k, hx *= 0.5, hy *= 0.5) {
        const auto range = [](double h) { return Big(dyadic(-h), dyadic(h), kBits); };
        Bounds over_a = bounds(a, ca, range(hx), range(hy));
        const double least = over_a.dx.least_magnitude();
        if (!(least > 0)) continue;
        // Less of y until the curve leaves by the ends.
        double h = hy;
        const double room = 0.9 * least * hx - at;
        if (!(room > 0)) continue;
        const double rise = over_a.dy.magnitude();
        if (rise * h > room) h = room / rise;
        if (!(h > 0) || !std::isfinite(h)) continue;
        if (h < hy) over_a = bounds(a, ca, range(hx), range(h));
        const Bounds over_b = bounds(b, cb, range(hx), range(h));
        if (m > 0 && (over_a.dx * over_b.dy - over_a.dy * over_b.dx).sign() == 0) continue;
        // In doubles rounded to nearest, with room to spare.
        if (!(over_a.dx.least_magnitude() * hx > 1.01 * (at + over_a.dy.magnitude() * h))) continue;
        const Q qx = dyadic(hx), qy = dyadic(h);
        const Big slope = Big(Q(0), kBits) - over_a.dy / over_a.dx;
        const int sign = over_a.dx.sign();
        mpfi_mul_2exp(over_a.dx.get(), over_a.dx.get(), std::size_t(scale));
        return Arc{tower, x - qx, x + qx, y - qy, y + qy, std::move(over_a.dx), slope, sign};
    }
    return std::nullopt;
}

// The places where J_k vanishes, from those where J_(k+1) does; false where a sign is not found.
struct Found {
    Place place;
    int order;  // of J_k
};
bool descend(const Arc& arc, int k, std::vector<Found>& found, int& last_sign) {
    std::vector<Found> next;
    Q left_y = arc.y0;
    int left = arc.sign_at(k, arc.y0);
    if (left == 0) return false;
    bool left_zero = false;
    const auto between = [&](const Q& y, int s) {
        if (!left_zero && s != 0 && left != s)
            next.push_back({{k, left_y, y, left, std::nullopt}, 1});
    };
    for (Found& f : found) {
        const auto s = arc.sign_of(k, f.place);
        if (!s) return false;
        if (*s == 0) {
            next.push_back({f.place, f.order + 1});
            left_zero = true;
            left_y = f.place.y1;
            left = 0;
            continue;
        }
        // Its two ends with the same sign as the place itself, so that brackets can start there.
        for (long bits = 2 * kRootWidth; !f.place.exact; bits *= 2) {
            if (arc.sign_at(k, f.place.y0) == *s && arc.sign_at(k, f.place.y1) == *s) break;
            if (bits > kMostBits) return false;
            arc.narrow(f.place, bits);
        }
        between(f.place.y0, *s);
        left_zero = false;
        left = *s;
        left_y = f.place.y1;
    }
    last_sign = arc.sign_at(k, arc.y1);
    if (last_sign == 0) return false;
    between(arc.y1, last_sign);
    found = std::move(next);
    return true;
}

}  // namespace

Tower::Tower(BiPoly a, BiPoly f)
    : a_(std::move(a)), a_x_(derivative(a_, true)), a_y_(derivative(a_, false)) {
    levels_.push_back(std::move(f));
    // References into it are kept while it grows.
    levels_.reserve(kMostLevels + 2);
}

const BiPoly& Tower::level(int k) const {
    while (int(levels_.size()) <= k)
        levels_.push_back(
            cross(a_x_, derivative(levels_.back(), false), a_y_, derivative(levels_.back(), true)));
    return levels_[std::size_t(k)];
}

std::optional<std::array<Q, 2>> Tower::newton(int k, const Q& x, const Q& y) const {
    // The next level is the determinant of the Jacobian, up to a positive factor.
    const BiPoly &b = level(k), b_x = derivative(b, true), b_y = derivative(b, false);
    const Big u(x, kFirstBits), v(y, kFirstBits);
    const Big fa = value(a_, u, v), fb = value(b, u, v), ax = value(a_x_, u, v),
              ay = value(a_y_, u, v), bx = value(b_x, u, v), by = value(b_y, u, v);
    const Big det = ax * by - ay * bx;
    if (det.sign() == 0) return std::nullopt;
    return std::array<Q, 2>{((ay * fb - by * fa) / det).middle(),
                            ((bx * fa - ax * fb) / det).middle()};
}

std::optional<std::array<Q, 2>> Tower::to_curve(const Q& x, const Q& y) const {
    const Big u(x, kFirstBits), v(y, kFirstBits), slope = value(a_x_, u, v);
    if (slope.sign() == 0) return std::nullopt;
    return std::array<Q, 2>{(Big(Q(0), kFirstBits) - value(a_, u, v) / slope).middle(), Q(0)};
}

bool Tower::coprime_with(int k) const {
    coprime_.resize(std::max(coprime_.size(), std::size_t(k) + 1), -1);
    int& known = coprime_[std::size_t(k)];
    if (known < 0) known = coprime(a_, level(k));
    return known == 1;
}

bool Tower::constant() const {
    if (constant_ < 0) {
        const BiPoly& j = level(1);
        if (j.is_zero()) {
            constant_ = 1;
        } else if (coprime_with(1)) {
            constant_ = 0;
        } else {
            // A's factors that J_1 lacks are constant.
            const BiPoly rest = common_factor(a_, j).f;
            constant_ = rest.p == 0 && rest.q == 0;
        }
    }
    return constant_ == 1;
}

std::optional<ArcRoots> arc_roots(const Tower& tower, int m, const Q& x, const Q& y, double size_x,
                                  double size_y) {
    const auto arc = make_arc(tower, m, x, y, size_x, size_y);
    if (!arc) return std::nullopt;
    std::vector<Found> found;
    int last = 0;
    if (m == 0 && (!tower.constant() || arc->sign_at(0, arc->y0) == 0)) return std::nullopt;
    for (int k = m - 1; k >= 0; --k)
        if (!descend(*arc, k, found, last)) return std::nullopt;
    ArcRoots result{arc->x0, arc->x1, arc->y0, arc->y1, {}};
    // From the right: J_0's sign beyond the root, and with it that of its first derivative.
    int right = last;
    for (auto f = found.rbegin(); f != found.rend(); ++f) {
        Place& p = f->place;
        arc->narrow(p, kRootWidth);
        const Big px = p.exact ? Big((*p.exact)[0], kFirstBits + kRootWidth)
                               : arc->x_over(p.y0, p.y1, kFirstBits + kRootWidth);
        ArcRoot root;
        root.x0 = p.exact ? (*p.exact)[0] : px.lo();
        root.x1 = p.exact ? (*p.exact)[0] : px.hi();
        root.y0 = p.y0;
        root.y1 = p.y1;
        root.multiplicity = f->order;
        // d^n/dy^n = D^n / A_x^n at a zero of order n.
        root.sign = right * (f->order % 2 ? arc->sign_a_x : 1);
        root.unique_y0 = arc->y0;
        root.unique_y1 = arc->y1;
        if (f->order % 2) right = -right;
        result.roots.push_back(std::move(root));
    }
    std::reverse(result.roots.begin(), result.roots.end());
    for (std::size_t i = 0; i + 1 < result.roots.size(); ++i) {
        // Half way between them.
        const Q between = (result.roots[i].y1 + result.roots[i + 1].y0) * Q(1, 2);
        result.roots[i].unique_y1 = between;
        result.roots[i + 1].unique_y0 = between;
    }
    return result;
}

}  // namespace feeler_oracle
