#include "native_patch.hpp"

#include <stdexcept>
#include <string>

#include "interval_trig.hpp"

namespace feeler_oracle {
namespace {

Interval enclosed(const Q& x) { return Interval(x.mpq()); }

// Cut with [lo, hi].
Interval clipped(Interval x, const Interval& lo, const Interval& hi) {
    if (x.lo < lo.lo) x.lo = lo.lo;
    if (hi.hi < x.hi) x.hi = hi.hi;
    if (x.hi < lo.lo) x.hi = lo.lo;
    if (hi.hi < x.lo) x.lo = hi.hi;
    return x;
}

bool is_zero(const Real& x) { return x.sign() == 0; }
bool is_one(const Real& x) { return mpfr_cmp_ui(x.get(), 1) == 0; }

const Interval& one() {
    static const Interval x(1.0);
    return x;
}

}  // namespace

// ---- maps

ParameterMap::ParameterMap(Q from, Q to)
    : from_(std::move(from)), to_(std::move(to)), ifrom_(from_.mpq()), ito_(to_.mpq()) {
    from64_ = ifrom_.outer();
    to64_ = ito_.outer();
}

ParameterMap::ParameterMap(Q from, Q to, const Q& turn)
    : ParameterMap(std::move(from), std::move(to)) {
    turn_ = true;
    half_ = enclosed(turn / Q(2));
    const CosSin x = cos_sin(half_);
    cos_half_ = x.cos;
    sin_half_ = x.sin;
}

ParameterMap ParameterMap::onto(Q from, Q to) const {
    ParameterMap m(std::move(from), std::move(to));
    m.turn_ = turn_;
    m.half_ = half_;
    m.sin_half_ = sin_half_;
    m.cos_half_ = cos_half_;
    return m;
}

Interval ParameterMap::to_surface(const Interval& s) const {
    const auto at = [&](const Real& x) -> Interval {
        if (is_zero(x)) return ifrom_;
        if (is_one(x)) return ito_;
        Interval part(x);
        if (turn_) {
            const Interval rest = one() - part;
            part = divide_positive(angle_of(rest + part * cos_half_, part * sin_half_), half_);
        }
        return ifrom_ + part * (ito_ - ifrom_);
    };
    if (s.is_point()) return clipped(at(s.lo), ifrom_, ito_);
    return clipped({at(s.lo).lo, at(s.hi).hi}, ifrom_, ito_);
}

Interval ParameterMap::to_square(const Interval& t) const {
    const Interval length = ito_ - ifrom_;
    const auto at = [&](const Real& x) -> Interval {
        Interval part =
            clipped(divide_positive(Interval(x) - ifrom_, length), Interval(0.0), one());
        if (!turn_ || (part.is_point() && (is_zero(part.lo) || is_one(part.lo)))) return part;
        // Increasing in the part: each end by itself.
        const auto end = [&](const Real& y) {
            const Interval a = Interval(y) * half_;
            const Interval low = cos_sin(a).sin, high = cos_sin(half_ - a).sin;
            return divide_positive(low, low + high);
        };
        return {end(part.lo).lo, end(part.hi).hi};
    };
    if (t.is_point()) return clipped(at(t.lo), Interval(0.0), one());
    return clipped({at(t.lo).lo, at(t.hi).hi}, Interval(0.0), one());
}

Interval64 ParameterMap::to_surface64(const Interval64& s) const {
    // 64 bits, each step rounded in the direction that moves the result outwards: the angle
    // increases in y = s sin h and decreases in x = 1 - s + s cos h.
    const auto at = [&](double x, bool up) -> double {
        if (x <= 0) return up ? from64_.hi : from64_.lo;
        if (x >= 1) return up ? to64_.hi : to64_.lo;
        Interval64 part(x);
        if (turn_) {
            constexpr mpfr_prec_t kShort = 64;
            const mpfr_rnd_t out = up ? MPFR_RNDU : MPFR_RNDD, in = up ? MPFR_RNDD : MPFR_RNDU;
            mpfr_t y, z;
            mpfr_init2(y, kShort);
            mpfr_init2(z, kShort);
            mpfr_set_d(y, x, MPFR_RNDN);
            mpfr_mul(z, (up ? cos_half_.lo : cos_half_.hi).get(), y, in);
            mpfr_mul(y, (up ? sin_half_.hi : sin_half_.lo).get(), y, out);
            mpfr_add_d(z, z, 1.0, in);
            mpfr_sub_d(z, z, x, in);
            mpfr_atan2(y, y, z, out);
            mpfr_div(y, y, (up ? half_.lo : half_.hi).get(), out);
            part = Interval64(mpfr_get_d(y, out));
            mpfr_clear(y);
            mpfr_clear(z);
        }
        const Interval64 t = from64_ + part * (to64_ - from64_);
        return up ? std::min(t.hi, to64_.hi) : std::max(t.lo, from64_.lo);
    };
    return {at(s.lo, false), at(s.hi, true)};
}

ParameterMap::Square64 ParameterMap::to_square64(const Interval64& t) const {
    const Interval64 length = to64_ - from64_;
    const Interval64 ratio = divide_positive(t - from64_, length);
    const Interval64 part(std::min(1.0, std::max(0.0, ratio.lo)),
                          std::max(0.0, std::min(1.0, ratio.hi)));
    if (!turn_) return {part, divide_positive(Interval64(1.0), length)};
    // With h the half turn and a = part h: s = y / (y + z), y = sin a, z = sin(h - a), and
    // ds/da = sin h / (y + z)^2. Both sines increase in their arguments, which are below pi / 2.
    constexpr mpfr_prec_t kShort = 64;
    struct Sines {
        Interval64 y, z;
    };
    const auto at = [&](double x) -> Sines {
        mpfr_t angle;
        mpfr_init2(angle, kShort);
        const auto sine = [&](double share, bool up) {
            const mpfr_rnd_t out = up ? MPFR_RNDU : MPFR_RNDD;
            mpfr_mul_d(angle, (up ? half_.hi : half_.lo).get(), share, out);
            mpfr_sin(angle, angle, out);
            const double s = mpfr_get_d(angle, out);
            return up ? std::min(s, 1.0) : std::max(s, 0.0);
        };
        const Interval64 rest = Interval64(1.0) - Interval64(x);
        const Sines r{{sine(x, false), sine(x, true)},
                      {sine(std::max(0.0, rest.lo), false), sine(std::min(1.0, rest.hi), true)}};
        mpfr_clear(angle);
        return r;
    };
    const Sines low = at(part.lo), high = part.hi == part.lo ? low : at(part.hi);
    const Interval64 first = divide_positive({low.y.lo, low.y.lo}, Interval64(low.y.lo) + low.z.hi),
                     last =
                         divide_positive({high.y.hi, high.y.hi}, Interval64(high.y.hi) + high.z.lo);
    // y + z = 2 sin(h / 2) cos(a - h / 2) is least at an end, and largest at the middle, if that is
    // between them.
    const Interval64 d0 = low.y + low.z, d1 = high.y + high.z;
    Interval64 d(std::min(d0.lo, d1.lo), std::max(d0.hi, d1.hi));
    if (part.lo <= 0.5 && part.hi >= 0.5) {
        const Sines m = at(0.5);
        d.hi = std::max(d.hi, (m.y + m.z).hi);
    }
    const Interval64 slope =
        divide_positive(divide_positive(sin_half_.outer() * half_.outer(), d * d), length);
    return {{std::max(0.0, std::min(1.0, first.lo)), std::min(1.0, std::max(0.0, last.hi))}, slope};
}

// ---- vectors

Vector3 to_vector(const std::array<double, 3>& x) {
    return {Interval(x[0]), Interval(x[1]), Interval(x[2])};
}

Interval dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector3 cross(const Vector3& a, const Vector3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector3 normalized(const Vector3& x) {
    const Interval length = square_root(square(x[0]) + square(x[1]) + square(x[2]));
    if (length.lo.sign() <= 0) throw std::invalid_argument("a direction that is none");
    return {divide_positive(x[0], length), divide_positive(x[1], length),
            divide_positive(x[2], length)};
}

// ---- turns

TurnNet turn_net(const Q& a0, const Q& a1) {
    const CosSin first = cos_sin(enclosed(a0)), last = cos_sin(enclosed(a1)),
                 middle = cos_sin(enclosed((a0 + a1) / Q(2))),
                 half = cos_sin(enclosed((a1 - a0) / Q(2)));
    return {{first.cos, middle.cos, last.cos},
            {first.sin, middle.sin, last.sin},
            {Interval(1.0), half.cos, Interval(1.0)}};
}

std::vector<Q> turn_cuts(const Q& a0, const Q& a1) {
    // A little less than a quarter turn, after the shift of the cuts.
    constexpr double kLongest = 1.4;
    const Q whole = a1 - a0;
    const double turn = std::fabs(double_bounds(whole).second);
    if (!(turn <= kMaxPieces)) throw std::invalid_argument("it turns too many times");
    const int pieces = std::max(1, int(std::ceil(turn / kLongest)));
    std::vector<Q> cuts{a0};
    // By a part of a piece that makes no simple fraction of a turn.
    const Q shift(0x1.3p-5);
    for (int k = 1; k < pieces; ++k) cuts.push_back(a0 + whole * (Q(k) + shift) / Q(pieces));
    cuts.push_back(a1);
    return cuts;
}

// ---- curves

namespace {

struct Collector {
    std::vector<CurveNet> out;

    // The piece's own domain [d0, d1] goes to [t0, t1].
    Q own0, own1, t0, t1;
    Q outer(const Q& t) const {
        return t == own0 ? t0 : t == own1 ? t1 : t0 + (t - own0) / (own1 - own0) * (t1 - t0);
    }

    void add(const Polyline3& line) {
        for (std::size_t i = 0; i + 1 < line.params.size(); ++i) {
            CurveNet c{1,
                       {},
                       ParameterMap(outer(Q(line.params[i])), outer(Q(line.params[i + 1]))),
                       {true, true}};
            for (int k = 0; k < 3; ++k)
                c.net[k] = {Interval(line.points[3 * i + k]), Interval(line.points[3 * i + 3 + k])};
            c.net[3] = {Interval(1.0), Interval(1.0)};
            out.push_back(std::move(c));
        }
    }

    void add(const NurbsCurve3& curve) {
        const int p = curve.degree, n = int(curve.knots.size()) - p - 1;
        const auto crease = [&](double knot) {
            int multiplicity = 0;
            for (double k : curve.knots) multiplicity += k == knot;
            return multiplicity >= p;
        };
        for (int i = p; i < n; ++i) {
            const double from = curve.knots[i], to = curve.knots[i + 1];
            if (!(from < to)) continue;
            CurveNet c{
                p, {}, ParameterMap(outer(Q(from)), outer(Q(to))), {crease(from), crease(to)}};
            for (const auto& row : blossom_matrix(p, curve.knots, i, Q(from), Q(to)))
                for (int k = 0; k < 4; ++k) {
                    Q sum(0);
                    for (int j = 0; j <= p; ++j)
                        if (sign(row[j]) != 0) sum += row[j] * Q(curve.points[4 * (i - p + j) + k]);
                    c.net[k].push_back(enclosed(sum));
                }
            out.push_back(std::move(c));
        }
    }

    void add(const Arc3& arc) {
        const Vector3 z = normalized(to_vector(arc.z)), stored = to_vector(arc.x);
        const Interval along = dot(stored, z);
        Vector3 x;
        for (int k = 0; k < 3; ++k) x[k] = stored[k] - along * z[k];
        x = normalized(x);
        const Vector3 y = cross(z, x);
        const Q a0(arc.angle[0]), a1(arc.angle[1]), d0(arc.domain[0]), d1(arc.domain[1]);
        const auto parameter = [&](const Q& a) {
            return a == a0 ? d0 : a == a1 ? d1 : d0 + (a - a0) / (a1 - a0) * (d1 - d0);
        };
        const auto cuts = turn_cuts(a0, a1);
        const Interval radius(arc.radius);
        for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
            const TurnNet turn = turn_net(cuts[i], cuts[i + 1]);
            CurveNet c{2,
                       {},
                       ParameterMap(outer(parameter(cuts[i])), outer(parameter(cuts[i + 1])),
                                    cuts[i + 1] - cuts[i]),
                       {i == 0, i + 2 == cuts.size()}};
            for (int j = 0; j < 3; ++j) {
                for (int k = 0; k < 3; ++k)
                    c.net[k].push_back(Interval(arc.center[k]) * turn.w[j] +
                                       radius * (turn.cos[j] * x[k] + turn.sin[j] * y[k]));
                c.net[3].push_back(turn.w[j]);
            }
            out.push_back(std::move(c));
        }
    }
};

std::array<double, 2> own_domain(const Polyline3& c) { return {c.params.front(), c.params.back()}; }
std::array<double, 2> own_domain(const NurbsCurve3& c) {
    return {c.knots[c.degree], c.knots[c.knots.size() - c.degree - 1]};
}
std::array<double, 2> own_domain(const Arc3& c) { return c.domain; }

void check_weights(const HomogeneousNet& net) {
    for (const Interval& w : net[3])
        if (w.lo.sign() <= 0)
            throw std::invalid_argument("a weight that is not known to be positive");
}

// ---- surfaces

std::vector<NativePatch> revolution_patches(const Revolution& s) {
    const Vector3 n = normalized(to_vector(s.axis));
    const auto profile = curve_nets(s.profile);
    const Q a0(s.angle[0]), a1(s.angle[1]), d0(s.angle_domain[0]), d1(s.angle_domain[1]);
    const auto parameter = [&](const Q& a) {
        return a == a0 ? d0 : a == a1 ? d1 : d0 + (a - a0) / (a1 - a0) * (d1 - d0);
    };
    const auto cuts = turn_cuts(a0, a1);
    if (profile.size() * (cuts.size() - 1) > std::size_t(kMaxPieces))
        throw std::invalid_argument("it has too many pieces");
    // Of each profile piece: axial part (with the origin), the rest e, and n x e.
    struct Parts {
        std::vector<Vector3> axial, e, f;
    };
    std::vector<Parts> parts;
    for (const CurveNet& c : profile) {
        Parts x;
        for (int j = 0; j <= c.degree; ++j) {
            const Interval& w = c.net[3][j];
            Vector3 d, axial, e;
            for (int k = 0; k < 3; ++k) d[k] = c.net[k][j] - Interval(s.origin[k]) * w;
            const Interval height = dot(d, n);
            for (int k = 0; k < 3; ++k) {
                axial[k] = Interval(s.origin[k]) * w + height * n[k];
                e[k] = d[k] - height * n[k];
            }
            x.axial.push_back(axial);
            x.e.push_back(e);
            x.f.push_back(cross(n, e));
        }
        parts.push_back(std::move(x));
    }
    std::vector<NativePatch> out;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const TurnNet turn = turn_net(cuts[i], cuts[i + 1]);
        const ParameterMap angle(parameter(cuts[i]), parameter(cuts[i + 1]), cuts[i + 1] - cuts[i]);
        for (std::size_t m = 0; m < profile.size(); ++m) {
            const CurveNet& c = profile[m];
            const std::array<bool, 2> smooth{false, false};
            NativePatch patch =
                s.transposed
                    ? NativePatch{c.degree, 2, {}, {c.map, angle}, {c.crease, smooth}, false}
                    : NativePatch{2, c.degree, {}, {angle, c.map}, {smooth, c.crease}, false};
            for (auto& coordinate : patch.net) coordinate.resize(3 * (c.degree + 1));
            for (int a = 0; a < 3; ++a)
                for (int j = 0; j <= c.degree; ++j) {
                    const std::size_t at = s.transposed ? 3 * j + a : a * (c.degree + 1) + j;
                    for (int k = 0; k < 3; ++k)
                        patch.net[k][at] = turn.w[a] * parts[m].axial[j][k] +
                                           turn.cos[a] * parts[m].e[j][k] +
                                           turn.sin[a] * parts[m].f[j][k];
                    patch.net[3][at] = turn.w[a] * c.net[3][j];
                }
            out.push_back(std::move(patch));
        }
    }
    return out;
}

std::vector<NativePatch> sum_patches(const SumSurface& s) {
    const auto first = curve_nets(s.first), second = curve_nets(s.second);
    if (first.size() * second.size() > std::size_t(kMaxPieces))
        throw std::invalid_argument("it has too many pieces");
    std::vector<NativePatch> out;
    for (const CurveNet& a : first)
        for (const CurveNet& b : second) {
            NativePatch patch{a.degree, b.degree, {}, {a.map, b.map}, {a.crease, b.crease}, false};
            for (int i = 0; i <= a.degree; ++i)
                for (int j = 0; j <= b.degree; ++j) {
                    const Interval &wa = a.net[3][i], &wb = b.net[3][j], w = wa * wb;
                    for (int k = 0; k < 3; ++k)
                        patch.net[k].push_back(Interval(s.base[k]) * w + a.net[k][i] * wb +
                                               b.net[k][j] * wa);
                    patch.net[3].push_back(w);
                }
            out.push_back(std::move(patch));
        }
    return out;
}

bool is_parallelogram(const RationalBezierPatch& s) {
    if (s.p != 1 || s.q != 1) return false;
    for (const Q& w : s.W)
        if (w != s.W[0]) return false;
    for (const auto* c : {&s.X, &s.Y, &s.Z})
        if ((*c)[0] + (*c)[3] != (*c)[1] + (*c)[2]) return false;
    return true;
}

std::vector<NativePatch> rational_patches(const Surface& surface) {
    const auto* nurbs = std::get_if<NurbsSurface>(&surface);
    const auto crease = [&](int k, const Q& at) {
        if (!nurbs) return false;
        const auto& knots = k == 0 ? nurbs->knots_u : nurbs->knots_v;
        int multiplicity = 0;
        for (double x : knots) multiplicity += Q(x) == at;
        return multiplicity >= (k == 0 ? nurbs->degree_u : nurbs->degree_v);
    };
    std::vector<NativePatch> out;
    for (const RationalBezierPatch& s : bezier_patches(surface)) {
        NativePatch patch{
            s.p,
            s.q,
            {},
            {ParameterMap(s.u0, s.u1), ParameterMap(s.v0, s.v1)},
            {{{crease(0, s.u0), crease(0, s.u1)}, {crease(1, s.v0), crease(1, s.v1)}}},
            is_parallelogram(s)};
        const std::vector<Q>* const coordinates[4] = {&s.X, &s.Y, &s.Z, &s.W};
        for (int k = 0; k < 4; ++k)
            for (const Q& x : *coordinates[k]) patch.net[k].push_back(enclosed(x));
        out.push_back(std::move(patch));
    }
    return out;
}

}  // namespace

std::vector<CurveNet> curve_nets(const Curve3& curve) {
    Collector all;
    for (std::size_t i = 0; i < curve.pieces.size(); ++i)
        std::visit(
            [&](const auto& piece) {
                const auto own = own_domain(piece);
                all.own0 = Q(own[0]), all.own1 = Q(own[1]);
                all.t0 = Q(curve.params[i]), all.t1 = Q(curve.params[i + 1]);
                all.add(piece);
                // Segments of a poly-curve need not even meet smoothly.
                all.out.back().crease[1] = true;
            },
            curve.pieces[i]);
    for (std::size_t i = 0; i + 1 < all.out.size(); ++i)
        all.out[i + 1].crease[0] = all.out[i].crease[1] =
            all.out[i].crease[1] || all.out[i + 1].crease[0];
    for (const CurveNet& c : all.out) check_weights(c.net);
    return all.out;
}

std::vector<NativePatch> native_patches(const Surface& surface) {
    auto out = std::holds_alternative<Revolution>(surface)
                   ? revolution_patches(std::get<Revolution>(surface))
               : std::holds_alternative<SumSurface>(surface)
                   ? sum_patches(std::get<SumSurface>(surface))
                   : rational_patches(surface);
    for (const NativePatch& patch : out) check_weights(patch.net);
    return out;
}

}  // namespace feeler_oracle
