#include "model.hpp"

#include <algorithm>
#include <stdexcept>

namespace feeler_oracle {
namespace {

// Weights of the p + 1 control points of `span` in the blossom at arguments s[0..p-1]: the
// recursion of The NURBS Book A2.2 with another argument at each level.
std::vector<Q> blossom_weights(const std::vector<Q>& knots, int p, int span,
                               const std::vector<Q>& s) {
    std::vector<Q> n(p + 1, Q(0));
    n[0] = Q(1);
    for (int r = 1; r <= p; ++r) {
        const Q& t = s[r - 1];
        Q saved(0);
        for (int j = 0; j < r; ++j) {
            const Q& right = knots[span + j + 1];
            const Q& left = knots[span + 1 - (r - j)];
            if (sign(n[j]) == 0) {
                n[j] = saved;
                saved = Q(0);
                continue;
            }
            const Q share = n[j] / (right - left);
            n[j] = saved + (right - t) * share;
            saved = (t - left) * share;
        }
        n[r] = saved;
    }
    return n;
}

std::vector<Q> to_exact(const std::vector<double>& values) {
    return std::vector<Q>(values.begin(), values.end());
}

// sum of weights[k] * values(k)
template <class F>
Q combine(const std::vector<Q>& weights, F values) {
    Q sum(0);
    for (std::size_t k = 0; k < weights.size(); ++k)
        if (sign(weights[k]) != 0) sum += weights[k] * values(k);
    return sum;
}

void reverse(RationalBezierCurve& c) {
    std::reverse(c.X.begin(), c.X.end());
    std::reverse(c.Y.begin(), c.Y.end());
    std::reverse(c.W.begin(), c.W.end());
}

// The pieces of one curve over [a, b], a < b, inside its domain.
void pieces_of(const Polyline& line, const Q& a, const Q& b,
               std::vector<RationalBezierCurve>& out) {
    for (std::size_t i = 0; i + 1 < line.params.size(); ++i) {
        const Q t0(line.params[i]), t1(line.params[i + 1]);
        const Q from = std::max(a, t0), to = std::min(b, t1);
        if (!(from < to)) continue;
        const auto at = [&](const Q& t, int c) -> Q {
            const Q p0(line.points[2 * i + c]), p1(line.points[2 * i + 2 + c]);
            if (t == t0) return p0;
            if (t == t1) return p1;
            return p0 + (t - t0) / (t1 - t0) * (p1 - p0);
        };
        out.push_back({{at(from, 0), at(to, 0)}, {at(from, 1), at(to, 1)}, {Q(1), Q(1)}});
    }
}

void pieces_of(const NurbsCurve2& curve, const Q& a, const Q& b,
               std::vector<RationalBezierCurve>& out) {
    const int p = curve.degree, n = int(curve.knots.size()) - p - 1;
    for (int i = p; i < n; ++i) {
        if (!(curve.knots[i] < curve.knots[i + 1])) continue;
        const Q from = std::max(a, Q(curve.knots[i])), to = std::min(b, Q(curve.knots[i + 1]));
        if (!(from < to)) continue;
        RationalBezierCurve c;
        for (const auto& row : blossom_matrix(p, curve.knots, i, from, to)) {
            const auto coordinate = [&](int k) {
                return combine(row, [&](int j) { return Q(curve.points[3 * (i - p + j) + k]); });
            };
            c.X.push_back(coordinate(0));
            c.Y.push_back(coordinate(1));
            c.W.push_back(coordinate(2));
        }
        out.push_back(std::move(c));
    }
}

std::pair<double, double> own_domain(const CurvePiece& piece) {
    if (const auto* line = std::get_if<Polyline>(&piece))
        return {line->params.front(), line->params.back()};
    const auto& curve = std::get<NurbsCurve2>(piece);
    return {curve.knots[curve.degree], curve.knots[curve.knots.size() - curve.degree - 1]};
}

std::array<Q, 2> plane_parameter(const Plane& plane, int axis, const Q& t) {
    // a(t) and its derivative.
    const Q t0(plane.domain[2 * axis]), t1(plane.domain[2 * axis + 1]);
    const Q a0(plane.extents[2 * axis]), a1(plane.extents[2 * axis + 1]);
    const Q slope = (a1 - a0) / (t1 - t0);
    return {a0 + (t - t0) * slope, slope};
}

std::array<Q, 3> plane_point(const Plane& plane, const Q& a, const Q& b) {
    std::array<Q, 3> point;
    for (int k = 0; k < 3; ++k)
        point[k] = Q(plane.origin[k]) + a * Q(plane.x[k]) + b * Q(plane.y[k]);
    return point;
}

ExactEvaluation evaluate_plane(const Plane& plane, const Q& u, const Q& v) {
    const auto a = plane_parameter(plane, 0, u), b = plane_parameter(plane, 1, v);
    ExactEvaluation e;
    e.point = plane_point(plane, a[0], b[0]);
    for (int k = 0; k < 3; ++k) {
        e.du[k] = a[1] * Q(plane.x[k]);
        e.dv[k] = b[1] * Q(plane.y[k]);
    }
    return e;
}

// Weights of the control points span-p..span for the point and for the derivative.
std::array<std::vector<Q>, 2> basis(int p, const std::vector<double>& knots, int span, const Q& t) {
    const auto exact = to_exact(knots);
    std::array<std::vector<Q>, 2> result;
    result[0] = blossom_weights(exact, p, span, std::vector<Q>(p, t));
    // The derivative is p times the blossom at (t, .., t, direction 1): the difference of the
    // blossoms at (t, .., t, 1 + t) and (t, .., t, t).
    std::vector<Q> arguments(p, t);
    arguments.back() = t + Q(1);
    result[1] = blossom_weights(exact, p, span, arguments);
    for (int k = 0; k <= p; ++k) result[1][k] = Q(p) * (result[1][k] - result[0][k]);
    return result;
}

ExactEvaluation evaluate_nurbs(const NurbsSurface& s, const Q& u, const Q& v) {
    const int iu = find_span(s.degree_u, s.knots_u, u), iv = find_span(s.degree_v, s.knots_v, v);
    const auto bu = basis(s.degree_u, s.knots_u, iu, u), bv = basis(s.degree_v, s.knots_v, iv, v);
    const int stride = s.count_v();
    std::array<Q, 4> value, along_u, along_v;
    for (int c = 0; c < 4; ++c) {
        std::vector<Q> row(s.degree_u + 1), row_dv(s.degree_u + 1);
        for (int i = 0; i <= s.degree_u; ++i) {
            const auto net = [&](int j) {
                return Q(s.net[4 * ((iu - s.degree_u + i) * stride + iv - s.degree_v + j) + c]);
            };
            row[i] = combine(bv[0], net);
            row_dv[i] = combine(bv[1], net);
        }
        value[c] = combine(bu[0], [&](int i) { return row[i]; });
        along_u[c] = combine(bu[1], [&](int i) { return row[i]; });
        along_v[c] = combine(bu[0], [&](int i) { return row_dv[i]; });
    }
    ExactEvaluation e;
    const Q inverse = Q(1) / value[3];
    for (int k = 0; k < 3; ++k) {
        e.point[k] = value[k] * inverse;
        e.du[k] = (along_u[k] - along_u[3] * e.point[k]) * inverse;
        e.dv[k] = (along_v[k] - along_v[3] * e.point[k]) * inverse;
    }
    return e;
}

RationalBezierPatch plane_patch(const Plane& plane) {
    RationalBezierPatch patch{1, 1, {}, {}, {}, std::vector<Q>(4, Q(1)), {}, {}, {}, {}};
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) {
            const auto point = plane_point(plane, Q(plane.extents[i]), Q(plane.extents[2 + j]));
            patch.X.push_back(point[0]);
            patch.Y.push_back(point[1]);
            patch.Z.push_back(point[2]);
        }
    patch.u0 = Q(plane.domain[0]);
    patch.u1 = Q(plane.domain[1]);
    patch.v0 = Q(plane.domain[2]);
    patch.v1 = Q(plane.domain[3]);
    return patch;
}

RationalBezierPatch nurbs_patch(const NurbsSurface& s, int iu, int iv,
                                const std::vector<std::vector<Q>>& mu,
                                const std::vector<std::vector<Q>>& mv) {
    const int p = s.degree_u, q = s.degree_v, stride = s.count_v();
    RationalBezierPatch patch;
    patch.p = p;
    patch.q = q;
    patch.u0 = Q(s.knots_u[iu]);
    patch.u1 = Q(s.knots_u[iu + 1]);
    patch.v0 = Q(s.knots_v[iv]);
    patch.v1 = Q(s.knots_v[iv + 1]);
    std::vector<Q>* const outputs[4] = {&patch.X, &patch.Y, &patch.Z, &patch.W};
    for (int c = 0; c < 4; ++c) {
        std::vector<Q> rows((p + 1) * (q + 1));  // control points along u, Bezier along v
        for (int i = 0; i <= p; ++i)
            for (int l = 0; l <= q; ++l)
                rows[i * (q + 1) + l] = combine(mv[l], [&](int j) {
                    return Q(s.net[4 * ((iu - p + i) * stride + iv - q + j) + c]);
                });
        for (int k = 0; k <= p; ++k)
            for (int l = 0; l <= q; ++l)
                outputs[c]->push_back(combine(mu[k], [&](int i) { return rows[i * (q + 1) + l]; }));
    }
    return patch;
}

}  // namespace

std::vector<std::vector<Q>> blossom_matrix(int degree, const std::vector<double>& knots, int span,
                                           const Q& a, const Q& b) {
    const auto exact = to_exact(knots);
    std::vector<std::vector<Q>> rows;
    for (int k = 0; k <= degree; ++k) {
        std::vector<Q> arguments(degree - k, a);
        arguments.insert(arguments.end(), k, b);
        rows.push_back(blossom_weights(exact, degree, span, arguments));
    }
    return rows;
}

int find_span(int degree, const std::vector<double>& knots, const Q& t) {
    const int n = int(knots.size()) - degree - 1;
    int found = -1;
    for (int i = degree; i < n; ++i)
        if (knots[i] < knots[i + 1] && (found < 0 || Q(knots[i]) <= t)) found = i;
    if (found < 0) throw std::invalid_argument("a knot vector with an empty domain");
    return found;
}

std::array<Q, 4> surface_domain(const Surface& surface) {
    if (const auto* plane = std::get_if<Plane>(&surface))
        return {Q(plane->domain[0]), Q(plane->domain[1]), Q(plane->domain[2]), Q(plane->domain[3])};
    const auto& s = std::get<NurbsSurface>(surface);
    return {Q(s.knots_u[s.degree_u]), Q(s.knots_u[s.count_u()]), Q(s.knots_v[s.degree_v]),
            Q(s.knots_v[s.count_v()])};
}

std::vector<RationalBezierPatch> bezier_patches(const Surface& surface) {
    if (const auto* plane = std::get_if<Plane>(&surface)) return {plane_patch(*plane)};
    const auto& s = std::get<NurbsSurface>(surface);
    const auto matrices = [](int p, const std::vector<double>& knots) {
        std::vector<std::pair<int, std::vector<std::vector<Q>>>> spans;
        for (int i = p; i < int(knots.size()) - p - 1; ++i)
            if (knots[i] < knots[i + 1])
                spans.emplace_back(i, blossom_matrix(p, knots, i, Q(knots[i]), Q(knots[i + 1])));
        return spans;
    };
    const auto along_u = matrices(s.degree_u, s.knots_u), along_v = matrices(s.degree_v, s.knots_v);
    std::vector<RationalBezierPatch> patches;
    for (const auto& [iu, mu] : along_u)
        for (const auto& [iv, mv] : along_v) patches.push_back(nurbs_patch(s, iu, iv, mu, mv));
    return patches;
}

std::vector<RationalBezierCurve> bezier_pieces(const TrimCurve& trim) {
    const Q start(trim.start), end(trim.end);
    std::vector<RationalBezierCurve> out;
    for (std::size_t i = 0; i < trim.pieces.size(); ++i) {
        const Q t0(trim.params[i]), t1(trim.params[i + 1]);
        const Q from = std::max(start, t0), to = std::min(end, t1);
        if (!(from < to)) continue;
        const auto [d0, d1] = own_domain(trim.pieces[i]);
        const Q own0(d0), own1(d1);
        const auto map = [&](const Q& t) -> Q {
            return t == t0 ? own0 : t == t1 ? own1 : own0 + (t - t0) / (t1 - t0) * (own1 - own0);
        };
        std::visit([&](const auto& piece) { pieces_of(piece, map(from), map(to), out); },
                   trim.pieces[i]);
    }
    if (trim.reversed) {
        std::reverse(out.begin(), out.end());
        for (auto& c : out) reverse(c);
    }
    return out;
}

ExactEvaluation evaluate(const Surface& surface, const Q& u, const Q& v) {
    if (const auto* plane = std::get_if<Plane>(&surface)) return evaluate_plane(*plane, u, v);
    return evaluate_nurbs(std::get<NurbsSurface>(surface), u, v);
}

}  // namespace feeler_oracle
