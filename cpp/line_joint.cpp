// Proofs. The two forms (F1, F2), up to a positive factor, are one continuous map M about the point,
// on the patches that join there, and the line passes through the surface if the degree of M about
// its zero is odd.
//
// Simple roots of one orientation: each half (or quarter) of the map is regular, and equal to the
// next on the joint, so that M is a homeomorphism: its degree is 1 or -1.
//
// Two patches, and a form A whose derivative along the joint is not 0, on either: near the point
// A = 0 is one curve, a graph over the parameter across the joint, and A has one sign on either
// side of it. So the degree of M is not 0 if the other form G has another sign on the curve before
// the joint than after it, and 0 if it has the same. With m the multiplicity of a root, and y the
// parameter across, G is along the curve as d^m G / dy^m = D^m G / A_x^m, D the derivation of
// arc_roots.hpp, which changes its sign alone where x and y are exchanged. For m = 1, D G is the
// determinant of the forms' Jacobian up to sign.

#include "line_joint.hpp"

namespace feeler_oracle {
namespace {

// The sign of G on the curve A = 0 within the patch, next to the joint; 0: not known. `second`: A
// is the second form.
int sign_beside(const JointView& view, bool second) {
    const PatchRoot& r = view.root;
    const int along = view.along[second ? 1 : 0];
    if (along == 0) return 0;
    // x is v, along a joint u = const.
    const bool swapped = view.axis == 0, odd = r.multiplicity % 2;
    if (r.multiplicity > 1 && r.curve != (second ? 2 : 1)) return 0;
    int sign = r.orientation;
    if (odd) sign *= (swapped ? -1 : 1) * (second ? -1 : 1) * along;
    return odd && !view.after ? -sign : sign;
}

}  // namespace

std::array<int, 2> signs_along(int axis, int p, int q, const std::vector<Q>& f1,
                               const std::vector<Q>& f2, const std::array<Real, 4>& at) {
    const int du = axis == 0 ? 0 : 1, dv = 1 - du;
    if (p < du || q < dv) return {0, 0};
    // The derivative's coefficients, up to a positive factor.
    const auto along = [&](const std::vector<Q>& c) {
        std::vector<Q> d;
        for (int i = 0; i + du <= p; ++i)
            for (int j = 0; j + dv <= q; ++j)
                d.push_back(c[std::size_t((i + du) * (q + 1) + j + dv)] -
                            c[std::size_t(i * (q + 1) + j)]);
        const Net net = to_net(p - du, q - dv, d);
        const Interval x = hull(restrict_v(restrict_u(net, at[0], at[1]), at[2], at[3]));
        return x.lo.sign() > 0 ? 1 : x.hi.sign() < 0 ? -1 : 0;
    };
    return {along(f1), along(f2)};
}

std::optional<bool> passes(const std::vector<JointView>& views) {
    bool simple = true;
    for (const JointView& v : views)
        simple &= v.root.multiplicity == 1 && v.root.orientation == views[0].root.orientation;
    if (simple) return true;
    if (views.size() != 2 || views[0].axis == 2 || views[0].axis != views[1].axis ||
        views[0].after == views[1].after)
        return std::nullopt;
    for (const bool second : {false, true}) {
        if (views[0].along[second] != views[1].along[second]) continue;
        const int a = sign_beside(views[0], second), b = sign_beside(views[1], second);
        if (a != 0 && b != 0) return a != b;
    }
    return std::nullopt;
}

}  // namespace feeler_oracle
