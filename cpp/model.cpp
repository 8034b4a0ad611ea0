#include "model.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "curve3.hpp"

namespace feeler_oracle {
namespace {

// The knots that matter to a span: knots[span - p + 1 .. span + p], exactly.
std::vector<Q> local_knots(const std::vector<double>& knots, int p, int span) {
    return std::vector<Q>(knots.begin() + (span - p + 1), knots.begin() + (span + p + 1));
}

// Weights of the p + 1 control points of a span in the blossom at arguments s[0..p-1]: the
// recursion of The NURBS Book A2.2 with another argument at each level. `knots` are the span's
// local ones.
std::vector<Q> weights_in(const std::vector<Q>& knots, int p, const std::vector<Q>& s) {
    std::vector<Q> n(p + 1, Q(0));
    n[0] = Q(1);
    for (int r = 1; r <= p; ++r) {
        const Q& t = s[r - 1];
        Q saved(0);
        for (int j = 0; j < r; ++j) {
            const Q& right = knots[p + j];
            const Q& left = knots[p - (r - j)];
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

// sum of weights[k] * values(k)
template <class F>
Q combine(const std::vector<Q>& weights, F values) {
    Q sum(0);
    for (std::size_t k = 0; k < weights.size(); ++k)
        if (sign(weights[k]) != 0) sum += weights[k] * values(k);
    return sum;
}

std::array<Q, 3> plane_point(const Plane& plane, const Q& a, const Q& b) {
    std::array<Q, 3> point;
    for (int k = 0; k < 3; ++k)
        point[k] = Q(plane.origin[k]) + a * Q(plane.x[k]) + b * Q(plane.y[k]);
    return point;
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

// With P_i = (X_i, w_i) and R_j = (Y_j, v_j) the homogeneous points of two curves, base + X / w +
// Y / v has the homogeneous coefficients (base w_i v_j + X_i v_j + Y_j w_i, w_i v_j).
std::vector<RationalBezierPatch> sum_patches(const SumSurface& sum) {
    const auto along_u = curve_spans(sum.first), along_v = curve_spans(sum.second);
    std::vector<RationalBezierPatch> patches;
    for (const auto& a : along_u)
        for (const auto& b : along_v) {
            const auto &f = std::get<BezierCurve3>(a.curve), &g = std::get<BezierCurve3>(b.curve);
            RationalBezierPatch patch{f.degree(), g.degree(), {},   {},   {},
                                      {},         a.t0,       a.t1, b.t0, b.t1};
            for (std::size_t i = 0; i < f.W.size(); ++i)
                for (std::size_t j = 0; j < g.W.size(); ++j) {
                    const Q w = f.W[i] * g.W[j];
                    patch.X.push_back(Q(sum.base[0]) * w + f.X[i] * g.W[j] + g.X[j] * f.W[i]);
                    patch.Y.push_back(Q(sum.base[1]) * w + f.Y[i] * g.W[j] + g.Y[j] * f.W[i]);
                    patch.Z.push_back(Q(sum.base[2]) * w + f.Z[i] * g.W[j] + g.Z[j] * f.W[i]);
                    patch.W.push_back(w);
                }
            patches.push_back(std::move(patch));
        }
    return patches;
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

std::vector<Q> blossom_weights(int degree, const std::vector<double>& knots, int span,
                               const std::vector<Q>& arguments) {
    return weights_in(local_knots(knots, degree, span), degree, arguments);
}

std::vector<std::vector<Q>> blossom_matrix(int degree, const std::vector<double>& knots, int span,
                                           const Q& a, const Q& b) {
    const auto exact = local_knots(knots, degree, span);
    std::vector<std::vector<Q>> rows;
    for (int k = 0; k <= degree; ++k) {
        std::vector<Q> arguments(degree - k, a);
        arguments.insert(arguments.end(), k, b);
        rows.push_back(weights_in(exact, degree, arguments));
    }
    return rows;
}

std::array<Q, 4> surface_domain(const Surface& surface) {
    if (const auto* plane = std::get_if<Plane>(&surface))
        return {Q(plane->domain[0]), Q(plane->domain[1]), Q(plane->domain[2]), Q(plane->domain[3])};
    if (const auto* r = std::get_if<Revolution>(&surface)) {
        const Q a0(r->angle_domain[0]), a1(r->angle_domain[1]);
        const auto [t0, t1] = curve_domain(r->profile);
        if (r->transposed) return {t0, t1, a0, a1};
        return {a0, a1, t0, t1};
    }
    if (const auto* sum = std::get_if<SumSurface>(&surface)) {
        const auto first = curve_domain(sum->first), second = curve_domain(sum->second);
        return {first[0], first[1], second[0], second[1]};
    }
    const auto& s = std::get<NurbsSurface>(surface);
    return {Q(s.knots_u[s.degree_u]), Q(s.knots_u[s.count_u()]), Q(s.knots_v[s.degree_v]),
            Q(s.knots_v[s.count_v()])};
}

bool is_rational(const Surface& surface) {
    if (const auto* sum = std::get_if<SumSurface>(&surface))
        return is_rational(sum->first) && is_rational(sum->second);
    return !std::holds_alternative<Revolution>(surface);
}

std::vector<RationalBezierPatch> bezier_patches(const Surface& surface) {
    if (const auto* plane = std::get_if<Plane>(&surface)) return {plane_patch(*plane)};
    if (const auto* sum = std::get_if<SumSurface>(&surface)) return sum_patches(*sum);
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

}  // namespace feeler_oracle
