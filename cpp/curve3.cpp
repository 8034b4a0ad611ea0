#include "curve3.hpp"

#include <algorithm>

namespace feeler_oracle {
namespace {

// Cut positions of one piece in its own parameter.
std::vector<double> cuts_of(const Polyline3& line) { return line.params; }
std::vector<double> cuts_of(const NurbsCurve3& c) {
    std::vector<double> cuts(c.knots.begin() + c.degree, c.knots.end() - c.degree);
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
    return cuts;
}
std::vector<double> cuts_of(const Arc3& arc) { return {arc.domain[0], arc.domain[1]}; }

// The part of a piece between two successive cuts, the i-th.
std::variant<BezierCurve3, CircularArc3> span_of(const Polyline3& line, std::size_t i) {
    BezierCurve3 c;
    for (std::size_t k = i; k < i + 2; ++k) {
        c.X.emplace_back(line.points[3 * k]);
        c.Y.emplace_back(line.points[3 * k + 1]);
        c.Z.emplace_back(line.points[3 * k + 2]);
        c.W.emplace_back(1);
    }
    return c;
}
std::variant<BezierCurve3, CircularArc3> span_of(const NurbsCurve3& curve, std::size_t i) {
    const int p = curve.degree, n = int(curve.knots.size()) - p - 1;
    int span = p;
    for (std::size_t found = 0; span < n; ++span)
        if (curve.knots[span] < curve.knots[span + 1] && found++ == i) break;
    BezierCurve3 c;
    for (const auto& row :
         blossom_matrix(p, curve.knots, span, Q(curve.knots[span]), Q(curve.knots[span + 1]))) {
        Q sums[4];
        for (int j = 0; j <= p; ++j)
            if (sign(row[j]) != 0)
                for (int k = 0; k < 4; ++k)
                    sums[k] += row[j] * Q(curve.points[4 * (span - p + j) + k]);
        c.X.push_back(sums[0]);
        c.Y.push_back(sums[1]);
        c.Z.push_back(sums[2]);
        c.W.push_back(sums[3]);
    }
    return c;
}
std::variant<BezierCurve3, CircularArc3> span_of(const Arc3& arc, std::size_t) {
    return CircularArc3{&arc, Q(arc.angle[0]), Q(arc.angle[1])};
}

}  // namespace

std::vector<CurveSpan> curve_spans(const Curve3& curve) {
    std::vector<CurveSpan> out;
    for (std::size_t i = 0; i < curve.pieces.size(); ++i) {
        Q t0(curve.params[i]), t1(curve.params[i + 1]);
        std::visit(
            [&](const auto& piece) {
                const auto cuts = cuts_of(piece);
                const Q own0(cuts.front()), own1(cuts.back());
                const auto outer = [&](double cut) -> Q {
                    const Q t(cut);
                    if (t == own0) return t0;
                    if (t == own1) return t1;
                    return t0 + (t - own0) / (own1 - own0) * (t1 - t0);
                };
                for (std::size_t k = 0; k + 1 < cuts.size(); ++k)
                    out.push_back({span_of(piece, k), outer(cuts[k]), outer(cuts[k + 1])});
            },
            curve.pieces[i]);
    }
    return out;
}

std::array<Q, 2> curve_domain(const Curve3& curve) {
    return {Q(curve.params.front()), Q(curve.params.back())};
}

bool is_rational(const Curve3& curve) {
    return std::none_of(curve.pieces.begin(), curve.pieces.end(), [](const CurvePiece3& piece) {
        return std::holds_alternative<Arc3>(piece);
    });
}

}  // namespace feeler_oracle
