#include "core.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "distance_pieces.hpp"
#include "edge_width.hpp"
#include "net.hpp"

namespace feeler_oracle {
namespace {

[[noreturn]] void refuse(std::size_t face, const std::string& what) {
    throw std::invalid_argument("face " + std::to_string(face) + ": " + what);
}

template <class C>
bool finite(const C& values) {
    for (double x : values)
        if (!std::isfinite(x)) return false;
    return true;
}

// More than any file holds; keeps the powers in the exact numbers bounded.
constexpr int kMaxDegree = 64;

void check_knots(std::size_t face, int degree, const std::vector<double>& knots,
                 std::size_t points) {
    if (degree < 1 || degree > kMaxDegree) refuse(face, "degree out of range");
    if (points < std::size_t(degree) + 1 || knots.size() != points + degree + 1)
        refuse(face, "the number of knots does not fit the control points");
    if (!finite(knots)) refuse(face, "a knot is not finite");
    for (std::size_t i = 0; i + 1 < knots.size(); ++i)
        if (knots[i + 1] < knots[i]) refuse(face, "knots decrease");
    const double start = knots[degree], end = knots[points];
    if (!(start < end)) refuse(face, "empty domain of a knot vector");
    for (std::size_t i = 0; i + degree < knots.size(); ++i)
        if (knots[i] == knots[i + degree] && start < knots[i] && knots[i] < end)
            refuse(face, "an interior knot of multiplicity above the degree");
}

void check_weights(std::size_t face, const std::vector<double>& points, std::size_t stride) {
    if (!finite(points)) refuse(face, "a control point is not finite");
    for (std::size_t i = stride - 1; i < points.size(); i += stride)
        if (!(points[i] > 0)) refuse(face, "a weight is not positive");
}

void check_params(std::size_t face, const std::vector<double>& params, std::size_t count) {
    if (params.size() != count || count < 2) refuse(face, "a curve with too few parameters");
    if (!finite(params)) refuse(face, "a parameter is not finite");
    for (std::size_t i = 0; i + 1 < params.size(); ++i)
        if (!(params[i] < params[i + 1])) refuse(face, "parameters do not increase");
}

// The angles of an arc or a revolution, and the domain they are run over.
void check_turn(std::size_t face, const std::array<double, 2>& angle,
                const std::array<double, 2>& domain) {
    for (const auto* range : {&angle, &domain}) {
        if (!finite(*range)) refuse(face, "an angle or its domain is not finite");
        if (!((*range)[0] < (*range)[1])) refuse(face, "an angle or its domain is empty");
    }
    if (angle[0] < -kMaxAngle || angle[1] > kMaxAngle) refuse(face, "an angle out of range");
}

template <std::size_t N>
bool is_zero(const std::array<double, N>& v) {
    for (double x : v)
        if (x != 0) return false;
    return true;
}

void check_radius(std::size_t face, double radius) {
    if (!std::isfinite(radius)) refuse(face, "an arc's radius is not finite");
    if (!(radius > 0)) refuse(face, "an arc's radius is not positive");
}

void check_piece(std::size_t face, const Arc2& arc) {
    if (!finite(arc.center) || !finite(arc.x) || !finite(arc.y))
        refuse(face, "an arc's frame is not finite");
    if (is_zero(arc.x)) refuse(face, "an arc's axis is zero");
    check_radius(face, arc.radius);
    check_turn(face, arc.angle, arc.domain);
}

void check_piece(std::size_t face, const Arc3& arc) {
    if (!finite(arc.center) || !finite(arc.x) || !finite(arc.z))
        refuse(face, "an arc's frame is not finite");
    const auto cross = [&](int i, int j) -> Q {
        return Q(arc.x[i]) * Q(arc.z[j]) - Q(arc.x[j]) * Q(arc.z[i]);
    };
    if (sign(cross(0, 1)) == 0 && sign(cross(1, 2)) == 0 && sign(cross(2, 0)) == 0)
        refuse(face, "an arc's axes are zero or parallel");
    check_radius(face, arc.radius);
    check_turn(face, arc.angle, arc.domain);
}

void check_piece(std::size_t face, const Polyline& line) {
    if (line.points.size() % 2 || !finite(line.points))
        refuse(face, "a polyline point is not finite");
    check_params(face, line.params, line.points.size() / 2);
}

void check_piece(std::size_t face, const Polyline3& line) {
    if (line.points.size() % 3 || !finite(line.points))
        refuse(face, "a polyline point is not finite");
    check_params(face, line.params, line.points.size() / 3);
}

void check_piece(std::size_t face, const NurbsCurve2& curve) {
    if (curve.points.size() % 3) refuse(face, "control points of the wrong size");
    check_knots(face, curve.degree, curve.knots, curve.points.size() / 3);
    check_weights(face, curve.points, 3);
}

void check_piece(std::size_t face, const NurbsCurve3& curve) {
    if (curve.points.size() % 4) refuse(face, "control points of the wrong size");
    check_knots(face, curve.degree, curve.knots, curve.points.size() / 4);
    check_weights(face, curve.points, 4);
}

template <class Pieces>
void check_pieces(std::size_t face, const Pieces& pieces) {
    for (const auto& piece : pieces)
        std::visit([&](const auto& p) { check_piece(face, p); }, piece);
}

void check_curve(std::size_t face, const Curve3& curve) {
    check_params(face, curve.params, curve.pieces.size() + 1);
    check_pieces(face, curve.pieces);
}

void check_trim(std::size_t face, const TrimCurve& trim) {
    check_params(face, trim.params, trim.pieces.size() + 1);
    if (!std::isfinite(trim.start) || !std::isfinite(trim.end) || !(trim.start < trim.end) ||
        trim.start < trim.params.front() || trim.end > trim.params.back())
        refuse(face, "a trim's span is not inside its curve");
    check_pieces(face, trim.pieces);
}

void check_surface(std::size_t face, const Surface& surface) {
    if (const auto* plane = std::get_if<Plane>(&surface)) {
        if (!finite(plane->origin) || !finite(plane->x) || !finite(plane->y) ||
            !finite(plane->domain) || !finite(plane->extents))
            refuse(face, "a plane's number is not finite");
        for (const auto* r : {&plane->domain, &plane->extents})
            if (!((*r)[0] < (*r)[1]) || !((*r)[2] < (*r)[3]))
                refuse(face, "a plane's domain or extent is empty");
        return;
    }
    if (const auto* r = std::get_if<Revolution>(&surface)) {
        if (!finite(r->origin) || !finite(r->axis))
            refuse(face, "a revolution's axis is not finite");
        if (is_zero(r->axis)) refuse(face, "a revolution's axis is zero");
        check_turn(face, r->angle, r->angle_domain);
        check_curve(face, r->profile);
        return;
    }
    if (const auto* sum = std::get_if<SumSurface>(&surface)) {
        if (!finite(sum->base)) refuse(face, "a sum's base is not finite");
        check_curve(face, sum->first);
        check_curve(face, sum->second);
        return;
    }
    const auto& s = std::get<NurbsSurface>(surface);
    if (s.degree_u < 1 || s.degree_v < 1 || s.count_u() < 2 || s.count_v() < 2)
        refuse(face, "too few control points");
    check_knots(face, s.degree_u, s.knots_u, std::size_t(s.count_u()));
    check_knots(face, s.degree_v, s.knots_v, std::size_t(s.count_v()));
    if (s.net.size() != 4 * std::size_t(s.count_u()) * std::size_t(s.count_v()))
        refuse(face, "the number of control points does not fit the knots");
    check_weights(face, s.net, 4);
}

std::array<double, 4> area_of(const RationalBezierPatch& s, const std::array<Q, 4>& d) {
    std::array<double, 4> area = {0, 1, 0, 1};
    const Q scale(1L << kMarginBits);
    const Q* const ends[4] = {&s.u0, &s.u1, &s.v0, &s.v1};
    for (int side = 0; side < 4; ++side) {
        if (*ends[side] != d[side]) continue;
        const Q whole = side < 2 ? d[1] - d[0] : d[3] - d[2];
        const Q own = side < 2 ? s.u1 - s.u0 : s.v1 - s.v0;
        // At most half a patch: what a restriction of a net admits.
        const double reach = std::min(0.5, double_bounds(whole / own / scale).second);
        area[side] += side % 2 ? reach : -reach;
    }
    return area;
}

std::array<Interval64, 3> box_of(const RationalBezierPatch& s, const std::array<double, 4>& area) {
    const auto over = [&](const std::vector<Q>& c) {
        return restrict_v(restrict_u(to_net(s.p, s.q, c), Real(area[0]), Real(area[1])),
                          Real(area[2]), Real(area[3]));
    };
    std::array<Interval64, 3> box;
    const Net w = over(s.W);
    const std::vector<Q>* const xyz[3] = {&s.X, &s.Y, &s.Z};
    for (int k = 0; k < 3; ++k) {
        const Net x = over(*xyz[k]);
        for (std::size_t i = 0; i < w.c.size(); ++i) {
            if (w.c[i].lo.sign() <= 0) {
                box[k] = Interval64(-INFINITY, INFINITY);
                break;
            }
            const Interval64 y = divide_positive(x.c[i], w.c[i]).outer();
            box[k] = i == 0 ? y : Interval64(std::min(box[k].lo, y.lo), std::max(box[k].hi, y.hi));
        }
    }
    return box;
}

}  // namespace

void validate(const Model& model) {
    for (std::size_t i = 0; i < model.faces.size(); ++i) {
        const Face& face = model.faces[i];
        if (face.brep < 0 || std::size_t(face.brep) >= model.closed.size())
            refuse(i, "belongs to no BREP");
        check_surface(i, face.surface);
        if (!face.loops) continue;
        for (const Loop& loop : *face.loops)
            for (const TrimCurve& trim : loop.trims) check_trim(i, trim);
    }
}

Core::Core(Model model) : model_(std::move(model)), faces_(model_.faces.size()) {
    validate(model_);
}

const PreparedFace& Core::face(std::size_t index) const {
    auto& slot = faces_.at(index);
    if (!slot) {
        const Face& face = model_.faces[index];
        slot = std::make_unique<PreparedFace>(PreparedFace{&face, Region(face), {}, {}, {}});
        if (is_rational(face.surface)) slot->patches = bezier_patches(face.surface);
        for (const auto& patch : slot->patches) {
            slot->areas.push_back(area_of(patch, slot->region.domain()));
            slot->boxes.push_back(box_of(patch, slot->areas.back()));
        }
    }
    return *slot;
}

const Pieces& Core::pieces() const {
    if (!pieces_)
        pieces_ = std::make_shared<const Pieces>(
            model_, [this](std::size_t i) -> const Region& { return face(i).region; });
    return *pieces_;
}

const Edges& Core::edges() const {
    if (!edges_) edges_ = std::make_shared<const Edges>(*this);
    return *edges_;
}

}  // namespace feeler_oracle
