#include "line_quadric.hpp"

namespace feeler_oracle {
namespace {

Q3 exact(const std::array<double, 3>& a) { return {Q(a[0]), Q(a[1]), Q(a[2])}; }
Q3 plus(const Q3& a, const Q3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Q3 times(const Q& s, const Q3& a) { return {s * a[0], s * a[1], s * a[2]}; }
Q3 minus(const Q3& a, const Q3& b) { return plus(a, times(Q(-1), b)); }
Q dot(const Q3& a, const Q3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The curve if it is one piece of this kind.
template <class Kind>
const Kind* only(const Curve3& curve) {
    return curve.pieces.size() == 1 ? std::get_if<Kind>(&curve.pieces[0]) : nullptr;
}

struct Straight {
    Q3 from, along;
};
std::optional<Straight> straight(const Curve3& curve) {
    const auto* line = only<Polyline3>(curve);
    if (!line || line->params.size() != 2) return std::nullopt;
    const auto& p = line->points;
    const Q3 from = exact({p[0], p[1], p[2]});
    return Straight{from, minus(exact({p[3], p[4], p[5]}), from)};
}

// X - center - s D with s = (z.(X - center)) / z.D; D = 0: X - center.
Quadric::Affine shifted(const Q3& center, const Q3& z, const Q3& along) {
    Quadric::Affine f;
    const Q inverse = sign(dot(z, along)) == 0 ? Q(0) : Q(1) / dot(z, along);
    for (int k = 0; k < 3; ++k) {
        f.of[k] = times(-z[k] * inverse, along);
        f.of[k][k] += Q(1);
    }
    f.constant = times(Q(-1), f.at(center, true));
    return f;
}

std::optional<Quadric> of_revolution(const Revolution& s) {
    const Q3 o = exact(s.origin), a = exact(s.axis), none{Q(0), Q(0), Q(0)};
    const Quadric::Affine zero{none, {none, none, none}};
    if (const auto* arc = only<Arc3>(s.profile)) {
        const Q3 c = exact(arc->center), d = minus(c, o);
        for (int k = 0; k < 3; ++k)
            if (d[(k + 1) % 3] * a[(k + 2) % 3] != d[(k + 2) % 3] * a[(k + 1) % 3])
                return std::nullopt;
        return Quadric{shifted(c, a, none), zero, Q(arc->radius) * Q(arc->radius)};
    }
    const auto line = straight(s.profile);
    if (!line) return std::nullopt;
    const Q slope = dot(a, line->along);
    if (sign(slope) == 0) return std::nullopt;
    // P(s) - O, s = a.(X - P0) / a.D.
    Quadric::Affine n;
    for (int k = 0; k < 3; ++k) n.of[k] = times(a[k] / slope, line->along);
    n.constant = minus(minus(line->from, o), n.at(line->from, true));
    return Quadric{shifted(o, a, none), n, Q(0)};
}

std::optional<Quadric> of_sum(const SumSurface& s) {
    for (const bool first : {true, false}) {
        const auto* arc = only<Arc3>(first ? s.first : s.second);
        const auto line = straight(first ? s.second : s.first);
        if (!arc || !line || sign(dot(exact(arc->z), line->along)) == 0) continue;
        const Q3 c = plus(plus(exact(s.base), exact(arc->center)), line->from);
        const Q3 none{Q(0), Q(0), Q(0)};
        return Quadric{shifted(c, exact(arc->z), line->along),
                       {none, {none, none, none}},
                       Q(arc->radius) * Q(arc->radius)};
    }
    return std::nullopt;
}

}  // namespace

Q3 Quadric::Affine::at(const Q3& x, bool linear_part) const {
    Q3 r = linear_part ? Q3{Q(0), Q(0), Q(0)} : constant;
    for (int k = 0; k < 3; ++k) r = plus(r, times(x[k], of[k]));
    return r;
}

Quadratic Quadric::along(const Q3& origin, const Q3& direction) const {
    const Q3 m0 = m.at(origin, false), m1 = m.at(direction, true);
    const Q3 n0 = n.at(origin, false), n1 = n.at(direction, true);
    return {dot(m1, m1) - dot(n1, n1), Q(2) * (dot(m0, m1) - dot(n0, n1)),
            dot(m0, m0) - dot(n0, n0) - k};
}

std::optional<Quadric> quadric_of(const Surface& surface) {
    if (const auto* r = std::get_if<Revolution>(&surface)) return of_revolution(*r);
    if (const auto* s = std::get_if<SumSurface>(&surface)) return of_sum(*s);
    return std::nullopt;
}

}  // namespace feeler_oracle
