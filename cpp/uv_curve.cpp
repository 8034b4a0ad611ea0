#include "uv_curve.hpp"

#include <gmp.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace feeler_oracle {
namespace {

void reverse(RegionArc& arc) {
    if (auto* c = std::get_if<RationalBezierCurve>(&arc)) {
        std::reverse(c->X.begin(), c->X.end());
        std::reverse(c->Y.begin(), c->Y.end());
        std::reverse(c->W.begin(), c->W.end());
    } else if (auto* a = std::get_if<CircularArc>(&arc)) {
        std::swap(a->start, a->end);
    } else {
        auto& s = std::get<Segment>(arc);
        std::swap(s.from, s.to);
    }
}

// The pieces of one curve over [a, b], a < b, inside its domain.
void pieces_of(const Polyline& line, const Q& a, const Q& b, std::vector<RegionArc>& out) {
    for (std::size_t i = 0; i + 1 < line.params.size(); ++i) {
        const Q t0(line.params[i]), t1(line.params[i + 1]);
        const Q from = std::max(a, t0), to = std::min(b, t1);
        if (!(from < to)) continue;
        const auto at = [&](const Q& t, int c) -> Q {
            Q p0(line.points[2 * i + c]), p1(line.points[2 * i + 2 + c]);
            if (t == t0) return p0;
            if (t == t1) return p1;
            return p0 + (t - t0) / (t1 - t0) * (p1 - p0);
        };
        out.push_back(
            RationalBezierCurve{{at(from, 0), at(to, 0)}, {at(from, 1), at(to, 1)}, {Q(1), Q(1)}});
    }
}

void pieces_of(const NurbsCurve2& curve, const Q& a, const Q& b, std::vector<RegionArc>& out) {
    const int p = curve.degree, n = int(curve.knots.size()) - p - 1;
    for (int i = p; i < n; ++i) {
        if (!(curve.knots[i] < curve.knots[i + 1])) continue;
        const Q from = std::max(a, Q(curve.knots[i])), to = std::min(b, Q(curve.knots[i + 1]));
        if (!(from < to)) continue;
        RationalBezierCurve c;
        for (const auto& row : blossom_matrix(p, curve.knots, i, from, to)) {
            Q sums[3];
            for (int j = 0; j <= p; ++j)
                if (sign(row[j]) != 0)
                    for (int k = 0; k < 3; ++k)
                        sums[k] += row[j] * Q(curve.points[3 * (i - p + j) + k]);
            c.X.push_back(sums[0]);
            c.Y.push_back(sums[1]);
            c.W.push_back(sums[2]);
        }
        out.push_back(std::move(c));
    }
}

void pieces_of(const Arc2& arc, const Q& a, const Q& b, std::vector<RegionArc>& out) {
    const Q x0(arc.x[0]), x1(arc.x[1]);
    const Circle circle{{Q(arc.center[0]), Q(arc.center[1])},
                        {x0, x1},
                        Q(arc.radius),
                        sign(x0 * Q(arc.y[1]) - x1 * Q(arc.y[0])) < 0};
    const Q d0(arc.domain[0]), d1(arc.domain[1]), a0(arc.angle[0]), a1(arc.angle[1]);
    const auto angle = [&](const Q& t) -> Q {
        return t == d0 ? a0 : t == d1 ? a1 : a0 + (t - d0) / (d1 - d0) * (a1 - a0);
    };
    out.push_back(CircularArc{circle, angle(a), angle(b)});
}

std::pair<double, double> own_domain(const Polyline& line) {
    return {line.params.front(), line.params.back()};
}
std::pair<double, double> own_domain(const NurbsCurve2& curve) {
    return {curve.knots[curve.degree], curve.knots[curve.knots.size() - curve.degree - 1]};
}
std::pair<double, double> own_domain(const Arc2& arc) { return {arc.domain[0], arc.domain[1]}; }

EndPoint circle_point(const Circle& circle, const Q& angle) {
    if (sign(angle) == 0)
        if (const auto length =
                rational_root(circle.x[0] * circle.x[0] + circle.x[1] * circle.x[1])) {
            const Q scale = circle.radius / *length;
            return std::array<Q, 2>{circle.center[0] + scale * circle.x[0],
                                    circle.center[1] + scale * circle.x[1]};
        }
    return CirclePoint{circle, angle};
}

}  // namespace

std::optional<Q> rational_root(const Q& x) {
    const mpq_srcptr q = x.mpq();
    if (!mpz_perfect_square_p(mpq_numref(q)) || !mpz_perfect_square_p(mpq_denref(q)))
        return std::nullopt;
    mpq_t root;
    mpq_init(root);
    mpz_sqrt(mpq_numref(root), mpq_numref(q));
    mpz_sqrt(mpq_denref(root), mpq_denref(q));
    const Q result(root);
    mpq_clear(root);
    return result;
}

EndPoint end_point(const RegionArc& arc, bool last) {
    if (const auto* c = std::get_if<RationalBezierCurve>(&arc)) {
        const std::size_t i = last ? c->W.size() - 1 : 0;
        return std::array<Q, 2>{c->X[i] / c->W[i], c->Y[i] / c->W[i]};
    }
    if (const auto* a = std::get_if<CircularArc>(&arc))
        return circle_point(a->circle, last ? a->end : a->start);
    const auto& s = std::get<Segment>(arc);
    return last ? s.to : s.from;
}

bool same_point(const EndPoint& a, const EndPoint& b) {
    if (a.index() != b.index()) return false;
    if (const auto* p = std::get_if<0>(&a)) return *p == std::get<0>(b);
    const auto &p = std::get<CirclePoint>(a), &q = std::get<CirclePoint>(b);
    const auto &x = p.circle.x, &y = q.circle.x;
    const auto turned = [](const CirclePoint& c) {
        return c.circle.clockwise ? -c.angle : c.angle;
    };
    return p.circle.center == q.circle.center && p.circle.radius == q.circle.radius &&
           turned(p) == turned(q) && x[0] * y[1] == x[1] * y[0] &&
           sign(x[0] * y[0] + x[1] * y[1]) > 0;
}

RegionArc joined(const EndPoint& a, const EndPoint& b) {
    const auto *p = std::get_if<0>(&a), *q = std::get_if<0>(&b);
    if (p && q) return RationalBezierCurve{{(*p)[0], (*q)[0]}, {(*p)[1], (*q)[1]}, {Q(1), Q(1)}};
    return Segment{a, b};
}

std::vector<RegionArc> uv_pieces(const TrimCurve& trim) {
    const Q start(trim.start), end(trim.end);
    std::vector<RegionArc> out;
    for (std::size_t i = 0; i < trim.pieces.size(); ++i) {
        const Q t0(trim.params[i]), t1(trim.params[i + 1]);
        const Q from = std::max(start, t0), to = std::min(end, t1);
        if (!(from < to)) continue;
        const auto [d0, d1] =
            std::visit([](const auto& piece) { return own_domain(piece); }, trim.pieces[i]);
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

}  // namespace feeler_oracle
