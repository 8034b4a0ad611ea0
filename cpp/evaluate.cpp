#include "evaluate.hpp"

#include <stdexcept>

#include "curve3.hpp"
#include "interval_trig.hpp"

namespace feeler_oracle {
namespace {

// The point and the first two derivatives.
template <class N>
using Jet = std::array<std::array<N, 3>, 3>;

using V3 = std::array<Q, 3>;

V3 exact(const std::array<double, 3>& v) { return {Q(v[0]), Q(v[1]), Q(v[2])}; }
Q dot(const V3& a, const V3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
template <class N>
std::array<N, 3> cross(const V3& a, const std::array<N, 3>& b);

Interval enclose(const Q& x) { return Interval(x.mpq()); }

template <class N>
N number(const Q& x) {
    if constexpr (std::is_same_v<N, Q>)
        return x;
    else
        return enclose(x);
}

template <class N>
std::array<N, 3> cross(const V3& a, const std::array<N, 3>& b) {
    const N x = number<N>(a[0]), y = number<N>(a[1]), z = number<N>(a[2]);
    return {y * b[2] - z * b[1], z * b[0] - x * b[2], x * b[1] - y * b[0]};
}

// Index i of the span [cuts[i], cuts[i + 1]] that t belongs to; cuts do not decrease, and the
// first and last non-empty spans hold what lies before or behind.
std::size_t span_of(const std::vector<double>& cuts, std::size_t first, std::size_t last,
                    const Q& t, Limit limit) {
    std::size_t found = last;
    bool any = false;
    for (std::size_t i = first; i < last; ++i) {
        if (!(cuts[i] < cuts[i + 1])) continue;
        const bool begun = limit == Limit::FromAbove ? Q(cuts[i]) <= t : Q(cuts[i]) < t;
        if (any && !begun) break;
        any = true;
        found = i;
    }
    if (!any) throw std::invalid_argument("a knot vector with an empty domain");
    return found;
}

// Weights of a span's control points for the value and two derivatives.
struct Basis {
    std::size_t span;
    std::array<std::vector<Q>, 3> weights;
};

Basis basis(int p, const std::vector<double>& knots, const Q& t, Limit limit) {
    Basis b;
    b.span = span_of(knots, std::size_t(p), knots.size() - std::size_t(p) - 1, t, limit);
    // Derivatives of the blossom f(t, .., t): p (f(.., t + 1) - f(.., t)), and p (p - 1) times the
    // second difference.
    const auto at = [&](int shifted) {
        std::vector<Q> arguments(std::size_t(p), t);
        for (int i = 0; i < shifted; ++i) arguments[std::size_t(i)] += Q(1);
        return blossom_weights(p, knots, int(b.span), arguments);
    };
    b.weights[0] = at(0);
    b.weights[1] = at(1);
    b.weights[2] = p > 1 ? at(2) : std::vector<Q>(std::size_t(p) + 1, Q(0));
    for (std::size_t k = 0; k <= std::size_t(p); ++k) {
        Q &w0 = b.weights[0][k], &w1 = b.weights[1][k], &w2 = b.weights[2][k];
        if (p > 1) w2 = Q(p) * Q(p - 1) * (w2 - Q(2) * w1 + w0);
        w1 = Q(p) * (w1 - w0);
    }
    return b;
}

// Quotient of homogeneous derivatives h[0..2] = (wx, wy, wz, w) of orders 0, 1, 2.
Jet<Q> quotient(const std::array<std::array<Q, 4>, 3>& h) {
    Jet<Q> r;
    const Q inverse = Q(1) / h[0][3];
    for (std::size_t k = 0; k < 3; ++k) {
        r[0][k] = h[0][k] * inverse;
        r[1][k] = (h[1][k] - h[1][3] * r[0][k]) * inverse;
        r[2][k] = (h[2][k] - Q(2) * h[1][3] * r[1][k] - h[2][3] * r[0][k]) * inverse;
    }
    return r;
}

Jet<Q> jet_of(const Polyline3& line, const Q& t, Limit limit) {
    const std::size_t i = span_of(line.params, 0, line.params.size() - 1, t, limit);
    const Q t0(line.params[i]), t1(line.params[i + 1]);
    Jet<Q> r;
    for (std::size_t k = 0; k < 3; ++k) {
        const Q p0(line.points[3 * i + k]), p1(line.points[3 * i + 3 + k]);
        r[1][k] = (p1 - p0) / (t1 - t0);
        r[0][k] = p0 + (t - t0) * r[1][k];
    }
    return r;
}

Jet<Q> jet_of(const NurbsCurve3& c, const Q& t, Limit limit) {
    const Basis b = basis(c.degree, c.knots, t, limit);
    std::array<std::array<Q, 4>, 3> h;
    for (std::size_t j = 0; j <= std::size_t(c.degree); ++j)
        for (std::size_t k = 0; k < 4; ++k) {
            const Q x(c.points[4 * (b.span - std::size_t(c.degree) + j) + k]);
            for (std::size_t o = 0; o < 3; ++o) h[o][k] += b.weights[o][j] * x;
        }
    return quotient(h);
}

Interval inverse_root(const Q& x) {
    return divide_positive(Interval(1.0), square_root(enclose(x)));
}

// A turn by the angle that runs linearly over `angle` as t does over `domain`.
struct Turn {
    Interval cos, sin;
    Q rate;
};

Turn turn_at(const std::array<double, 2>& angle, const std::array<double, 2>& domain, const Q& t) {
    const Q rate = (Q(angle[1]) - Q(angle[0])) / (Q(domain[1]) - Q(domain[0]));
    const Q at = Q(angle[0]) + (t - Q(domain[0])) * rate;
    if (sign(at) == 0) return {Interval(1.0), Interval(0.0), rate};
    const CosSin turned = cos_sin(enclose(at));
    return {turned.cos, turned.sin, rate};
}

Jet<Interval> jet_of(const Arc3& arc, const Q& t, Limit) {
    const V3 x = exact(arc.x), z = exact(arc.z);
    const Q share = dot(x, z) / dot(z, z);
    // Orthogonal to z exactly, not yet of length 1.
    const V3 flat{x[0] - share * z[0], x[1] - share * z[1], x[2] - share * z[2]};
    const V3 side = cross<Q>(z, flat);
    const Interval radius(arc.radius), to_flat = radius * inverse_root(dot(flat, flat)),
                                       to_side = radius * inverse_root(dot(side, side));
    const Turn turn = turn_at(arc.angle, arc.domain, t);
    const Interval rate = enclose(turn.rate);
    Jet<Interval> r;
    for (std::size_t k = 0; k < 3; ++k) {
        const Interval a = to_flat * enclose(flat[k]), b = to_side * enclose(side[k]);
        const Interval out = turn.cos * a + turn.sin * b;
        r[0][k] = Interval(arc.center[k]) + out;
        r[1][k] = rate * (turn.cos * b - turn.sin * a);
        r[2][k] = -(square(rate) * out);
    }
    return r;
}

std::array<double, 2> own_domain(const Polyline3& line) {
    return {line.params.front(), line.params.back()};
}
std::array<double, 2> own_domain(const NurbsCurve3& c) {
    return {c.knots[std::size_t(c.degree)], c.knots[c.knots.size() - std::size_t(c.degree) - 1]};
}
std::array<double, 2> own_domain(const Arc3& arc) { return arc.domain; }

template <class N>
Jet<N> converted(const Jet<Q>& jet) {
    if constexpr (std::is_same_v<N, Q>) {
        return jet;
    } else {
        Jet<N> r;
        for (std::size_t o = 0; o < 3; ++o)
            for (std::size_t k = 0; k < 3; ++k) r[o][k] = enclose(jet[o][k]);
        return r;
    }
}
template <class N>
Jet<N> converted(const Jet<Interval>& jet) {
    if constexpr (std::is_same_v<N, Interval>)
        return jet;
    else
        throw std::logic_error("an arc is not rational");
}

// Scales derivatives by powers of the rate of a linear change of parameter.
template <class N>
Jet<N> curve_jet(const Curve3& curve, const Q& t, Limit limit) {
    const std::size_t i = span_of(curve.params, 0, curve.params.size() - 1, t, limit);
    const Q t0(curve.params[i]), t1(curve.params[i + 1]);
    return std::visit(
        [&](const auto& piece) {
            const auto own = own_domain(piece);
            const Q s0(own[0]), rate = (Q(own[1]) - s0) / (t1 - t0);
            auto jet = jet_of(piece, s0 + (t - t0) * rate, limit);
            using Own = std::decay_t<decltype(jet[0][0])>;
            const Own first = number<Own>(rate), second = number<Own>(rate * rate);
            if (rate != Q(1))
                for (std::size_t k = 0; k < 3; ++k) {
                    jet[1][k] = first * jet[1][k];
                    jet[2][k] = second * jet[2][k];
                }
            return converted<N>(jet);
        },
        curve.pieces[i]);
}

template <class N>
Partials<N> evaluate_sum(const SumSurface& s, const Q& u, const Q& v, Limit lu, Limit lv) {
    const auto f = curve_jet<N>(s.first, u, lu), g = curve_jet<N>(s.second, v, lv);
    Partials<N> r;
    for (std::size_t k = 0; k < 3; ++k) {
        r.point[k] = number<N>(Q(s.base[k])) + f[0][k] + g[0][k];
        r.du[k] = f[1][k];
        r.dv[k] = g[1][k];
        r.duu[k] = f[2][k];
        r.duv[k] = number<N>(Q(0));
        r.dvv[k] = g[2][k];
    }
    return r;
}

// p turned by (cos, sin) about the axis A: along + cos (p - along) + sin A x p / |A|, where
// along = (A.p) A / A.A. `derivative` k: how often it is differentiated with respect to the angle.
struct Turned {
    std::array<Interval, 3> along, flat, side;
    std::array<Interval, 3> at(const Interval& cos, const Interval& sin, int derivative) const {
        std::array<Interval, 3> r;
        for (std::size_t k = 0; k < 3; ++k) {
            if (derivative == 0) r[k] = along[k] + cos * flat[k] + sin * side[k];
            if (derivative == 1) r[k] = cos * side[k] - sin * flat[k];
            if (derivative == 2) r[k] = -(cos * flat[k] + sin * side[k]);
        }
        return r;
    }
};

template <class N>
Turned turned(const V3& axis, const std::array<N, 3>& p) {
    const Q length2 = dot(axis, axis);
    // (A.p) / A.A
    N share = number<N>(Q(0));
    for (std::size_t k = 0; k < 3; ++k) share = share + number<N>(axis[k] / length2) * p[k];
    const auto side = cross<N>(axis, p);
    const Interval inverse = inverse_root(length2);
    Turned t;
    const auto wide = [](const N& x) {
        if constexpr (std::is_same_v<N, Q>)
            return enclose(x);
        else
            return x;
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const N along = share * number<N>(axis[k]);
        t.along[k] = wide(along);
        t.flat[k] = wide(p[k] - along);
        t.side[k] = inverse * wide(side[k]);
    }
    return t;
}

template <class N>
Partials<Interval> revolve(const Revolution& s, Jet<N> profile, const Q& angle) {
    const V3 axis = exact(s.axis), origin = exact(s.origin);
    for (std::size_t k = 0; k < 3; ++k) profile[0][k] = profile[0][k] - number<N>(origin[k]);
    const Turned p = turned<N>(axis, profile[0]), d = turned<N>(axis, profile[1]),
                 dd = turned<N>(axis, profile[2]);
    const Turn turn = turn_at(s.angle, s.angle_domain, angle);
    const Interval rate = enclose(turn.rate), rate2 = enclose(turn.rate * turn.rate);
    const auto times = [](const Interval& x, std::array<Interval, 3> v) {
        for (auto& c : v) c = x * c;
        return v;
    };
    Partials<Interval> r;
    r.point = p.at(turn.cos, turn.sin, 0);
    for (std::size_t k = 0; k < 3; ++k) r.point[k] = r.point[k] + enclose(origin[k]);
    r.du = times(rate, p.at(turn.cos, turn.sin, 1));
    r.duu = times(rate2, p.at(turn.cos, turn.sin, 2));
    r.dv = d.at(turn.cos, turn.sin, 0);
    r.duv = times(rate, d.at(turn.cos, turn.sin, 1));
    r.dvv = dd.at(turn.cos, turn.sin, 0);
    return r;
}

Partials<Interval> evaluate_revolution(const Revolution& s, const Q& u, const Q& v, Limit lu,
                                       Limit lv) {
    const Q& angle = s.transposed ? v : u;
    const Q& along = s.transposed ? u : v;
    const Limit limit = s.transposed ? lu : lv;
    Partials<Interval> r =
        is_rational(s.profile)
            ? revolve<Q>(s, curve_jet<Q>(s.profile, along, limit), angle)
            : revolve<Interval>(s, curve_jet<Interval>(s.profile, along, limit), angle);
    if (s.transposed) {
        std::swap(r.du, r.dv);
        std::swap(r.duu, r.dvv);
    }
    return r;
}

Partials<Q> evaluate_plane(const Plane& plane, const Q& u, const Q& v) {
    Partials<Q> r;
    Q at[2], slope[2];
    for (std::size_t i = 0; i < 2; ++i) {
        const Q t0(plane.domain[2 * i]), t1(plane.domain[2 * i + 1]);
        const Q a0(plane.extents[2 * i]), a1(plane.extents[2 * i + 1]);
        slope[i] = (a1 - a0) / (t1 - t0);
        at[i] = a0 + ((i == 0 ? u : v) - t0) * slope[i];
    }
    for (std::size_t k = 0; k < 3; ++k) {
        r.point[k] = Q(plane.origin[k]) + at[0] * Q(plane.x[k]) + at[1] * Q(plane.y[k]);
        r.du[k] = slope[0] * Q(plane.x[k]);
        r.dv[k] = slope[1] * Q(plane.y[k]);
    }
    return r;
}

Partials<Q> evaluate_nurbs(const NurbsSurface& s, const Q& u, const Q& v, Limit lu, Limit lv) {
    const Basis bu = basis(s.degree_u, s.knots_u, u, lu), bv = basis(s.degree_v, s.knots_v, v, lv);
    const std::size_t p = std::size_t(s.degree_u), q = std::size_t(s.degree_v);
    const std::size_t stride = std::size_t(s.count_v());
    // h[i][j]: i times along u, j times along v.
    std::array<Q, 4> h[3][3];
    for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t i = 0; i <= p; ++i) {
            Q row[3];
            for (std::size_t j = 0; j <= q; ++j) {
                const Q x(s.net[4 * ((bu.span - p + i) * stride + bv.span - q + j) + c]);
                for (std::size_t o = 0; o < 3; ++o) row[o] += bv.weights[o][j] * x;
            }
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t b = 0; a + b < 3; ++b) h[a][b][c] += bu.weights[a][i] * row[b];
        }
    const Jet<Q> along_u = quotient({h[0][0], h[1][0], h[2][0]}),
                 along_v = quotient({h[0][0], h[0][1], h[0][2]});
    Partials<Q> r{along_u[0], along_u[1], along_v[1], along_u[2], {}, along_v[2]};
    for (std::size_t k = 0; k < 3; ++k)
        r.duv[k] =
            (h[1][1][k] - h[1][0][3] * r.dv[k] - h[0][1][3] * r.du[k] - h[1][1][3] * r.point[k]) /
            h[0][0][3];
    return r;
}

}  // namespace

Partials<Q> evaluate(const Surface& surface, const Q& u, const Q& v, Limit along_u, Limit along_v) {
    if (const auto* plane = std::get_if<Plane>(&surface)) return evaluate_plane(*plane, u, v);
    if (const auto* s = std::get_if<NurbsSurface>(&surface))
        return evaluate_nurbs(*s, u, v, along_u, along_v);
    if (const auto* s = std::get_if<SumSurface>(&surface))
        return evaluate_sum<Q>(*s, u, v, along_u, along_v);
    throw std::logic_error("a revolution is not rational");
}

Partials<Interval> enclose_evaluation(const Surface& surface, const Q& u, const Q& v, Limit along_u,
                                      Limit along_v) {
    if (const auto* s = std::get_if<Revolution>(&surface))
        return evaluate_revolution(*s, u, v, along_u, along_v);
    if (!is_rational(surface))
        return evaluate_sum<Interval>(std::get<SumSurface>(surface), u, v, along_u, along_v);
    const Partials<Q> e = evaluate(surface, u, v, along_u, along_v);
    const auto rounded = [](const V3& x) {
        return std::array<Interval, 3>{enclose(x[0]), enclose(x[1]), enclose(x[2])};
    };
    return {rounded(e.point), rounded(e.du),  rounded(e.dv),
            rounded(e.duu),   rounded(e.duv), rounded(e.dvv)};
}

}  // namespace feeler_oracle
