// The half of bridge.hpp that takes BREPs.
#include <string>

#include "bridge.hpp"
#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"

namespace feeler_oracle {
namespace {

std::vector<double> copy(rust::Slice<const double> s) { return {s.begin(), s.end()}; }

void check_count(rust::Slice<const double> numbers, std::size_t count, const char* what) {
    if (numbers.size() != count)
        throw std::logic_error(std::string(what) + " has " + std::to_string(count) + " numbers");
}

// N numbers from `first` on.
template <std::size_t N>
std::array<double, N> part(rust::Slice<const double> numbers, std::size_t first) {
    std::array<double, N> out;
    for (std::size_t i = 0; i < N; ++i) out[i] = numbers[first + i];
    return out;
}

Face& last_face(Model& model) {
    if (model.faces.empty()) throw std::logic_error("no face yet");
    return model.faces.back();
}

TrimCurve& last_trim(Model& model) {
    auto& loops = last_face(model).loops;
    if (!loops || loops->empty() || loops->back().trims.empty())
        throw std::logic_error("no trim yet");
    return loops->back().trims.back();
}

}  // namespace

std::unique_ptr<Builder> new_builder() { return std::make_unique<Builder>(); }

void Builder::add_brep(bool closed, std::size_t edges) {
    model_.closed.push_back(closed);
    model_.edges += int(edges);
}

void Builder::add_nurbs_face(bool reversed, std::size_t degree_u, std::size_t degree_v,
                             rust::Slice<const double> knots_u, rust::Slice<const double> knots_v,
                             rust::Slice<const double> net) {
    add_face(reversed,
             NurbsSurface{int(degree_u), int(degree_v), copy(knots_u), copy(knots_v), copy(net)});
}

void Builder::add_plane_face(bool reversed, rust::Slice<const double> numbers) {
    check_count(numbers, 17, "a plane");
    add_face(reversed, Plane{part<3>(numbers, 0), part<3>(numbers, 3), part<3>(numbers, 6),
                             part<4>(numbers, 9), part<4>(numbers, 13)});
}

void Builder::add_curve(rust::Slice<const double> params) { curves_.push_back({{}, copy(params)}); }

void Builder::add_space_polyline(rust::Slice<const double> points,
                                 rust::Slice<const double> params) {
    last_curve().pieces.push_back(Polyline3{copy(points), copy(params)});
}

void Builder::add_space_nurbs_curve(std::size_t degree, rust::Slice<const double> knots,
                                    rust::Slice<const double> points) {
    last_curve().pieces.push_back(NurbsCurve3{int(degree), copy(knots), copy(points)});
}

void Builder::add_space_arc(rust::Slice<const double> numbers) {
    check_count(numbers, 14, "an arc in space");
    last_curve().pieces.push_back(Arc3{part<3>(numbers, 0), part<3>(numbers, 3),
                                       part<3>(numbers, 6), numbers[9], part<2>(numbers, 10),
                                       part<2>(numbers, 12)});
}

void Builder::add_revolution_face(bool reversed, bool transposed,
                                  rust::Slice<const double> numbers) {
    check_count(numbers, 10, "a revolution");
    if (curves_.size() != 1) throw std::logic_error("a revolution has one curve");
    Revolution r{part<3>(numbers, 0), part<3>(numbers, 3),   part<2>(numbers, 6),
                 part<2>(numbers, 8), std::move(curves_[0]), transposed};
    curves_.clear();
    add_face(reversed, std::move(r));
}

void Builder::add_sum_face(bool reversed, rust::Slice<const double> base) {
    check_count(base, 3, "a sum's base");
    if (curves_.size() != 2) throw std::logic_error("a sum has two curves");
    SumSurface sum{part<3>(base, 0), std::move(curves_[0]), std::move(curves_[1])};
    curves_.clear();
    add_face(reversed, std::move(sum));
}

void Builder::add_face(bool reversed, Surface surface) {
    model_.faces.push_back(
        {std::move(surface), std::nullopt, reversed, int(model_.closed.size()) - 1});
}

Curve3& Builder::last_curve() {
    if (curves_.empty()) throw std::logic_error("no curve yet");
    return curves_.back();
}

void Builder::set_trimmed() { last_face(model_).loops.emplace(); }

void Builder::add_loop() {
    auto& loops = last_face(model_).loops;
    if (!loops) throw std::logic_error("the face is not trimmed");
    loops->emplace_back();
}

void Builder::add_trim(double start, double end, bool reversed, std::int64_t edge,
                       rust::Slice<const double> params) {
    auto& loops = last_face(model_).loops;
    if (!loops || loops->empty()) throw std::logic_error("no loop yet");
    loops->back().trims.push_back({{}, copy(params), start, end, reversed, int(edge)});
}

void Builder::add_polyline(rust::Slice<const double> points, rust::Slice<const double> params) {
    last_trim(model_).pieces.push_back(Polyline{copy(points), copy(params)});
}

void Builder::add_nurbs_curve(std::size_t degree, rust::Slice<const double> knots,
                              rust::Slice<const double> points) {
    last_trim(model_).pieces.push_back(NurbsCurve2{int(degree), copy(knots), copy(points)});
}

void Builder::add_arc(rust::Slice<const double> numbers) {
    check_count(numbers, 11, "an arc");
    last_trim(model_).pieces.push_back(Arc2{part<2>(numbers, 0), part<2>(numbers, 2),
                                            part<2>(numbers, 4), numbers[6], part<2>(numbers, 7),
                                            part<2>(numbers, 9)});
}

std::unique_ptr<Core> Builder::finish() {
    return guarded([&] { return std::make_unique<Core>(std::move(model_)); });
}

}  // namespace feeler_oracle
