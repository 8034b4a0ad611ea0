#include "bridge.hpp"

#include <CGAL/assertions_behaviour.h>
#include <mpfr.h>

#include <cmath>
#include <string>

#include "feeler-oracle/src/bridge.rs.h"
#include "guard.hpp"

namespace feeler_oracle {

void silence_cgal() {
    // Failed assertions of CGAL throw; without a handler they would print first.
    const auto quiet = [](const char*, const char*, const char*, int, const char*) {};
    CGAL::set_error_handler(quiet);
    CGAL::set_warning_handler(quiet);
    CGAL::set_error_behaviour(CGAL::THROW_EXCEPTION);
}

namespace {

std::vector<double> copy(rust::Slice<const double> s) { return {s.begin(), s.end()}; }

RawDyadic round(const Q& x, mpfr_rnd_t direction) {
    // Rounding twice in one direction stays outward.
    Real r;
    mpfr_set_q(r.get(), x.mpq(), direction);
    return to_dyadic(r, direction);
}

RawEnclosure enclose(const Q& x) { return {round(x, MPFR_RNDD), round(x, MPFR_RNDU)}; }

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

void check_finite(double x) {
    if (!std::isfinite(x)) throw std::invalid_argument("the query is not finite");
}

}  // namespace

RawDyadic to_dyadic(const Real& x, mpfr_rnd_t direction) {
    mpfr_t r;
    mpfr_init2(r, kTruthBits);
    mpfr_set(r, x.get(), direction);
    RawDyadic d{"0", 0};
    if (mpfr_regular_p(r)) {
        mpz_t m;
        mpz_init(m);
        d.exponent = mpfr_get_z_2exp(m, r);
        const mp_bitcnt_t zeros = mpz_scan1(m, 0);
        mpz_tdiv_q_2exp(m, m, zeros);
        d.exponent += std::int64_t(zeros);
        std::string text(mpz_sizeinbase(m, 16) + 2, '\0');
        mpz_get_str(text.data(), 16, m);
        text.resize(text.find('\0'));
        d.mantissa = text;
        mpz_clear(m);
    }
    mpfr_clear(r);
    return d;
}

std::unique_ptr<Builder> new_builder() { return std::make_unique<Builder>(); }

void Builder::add_brep(bool closed, std::size_t edges) {
    model_.closed.push_back(closed);
    model_.edges += int(edges);
}

void Builder::add_nurbs_face(bool reversed, std::size_t degree_u, std::size_t degree_v,
                             rust::Slice<const double> knots_u, rust::Slice<const double> knots_v,
                             rust::Slice<const double> net) {
    model_.faces.push_back(
        {NurbsSurface{int(degree_u), int(degree_v), copy(knots_u), copy(knots_v), copy(net)},
         std::nullopt, reversed, int(model_.closed.size()) - 1});
}

void Builder::add_plane_face(bool reversed, rust::Slice<const double> numbers) {
    if (numbers.size() != 17) throw std::logic_error("a plane has 17 numbers");
    Plane plane;
    const double* x = numbers.data();
    for (int k = 0; k < 3; ++k) {
        plane.origin[k] = x[k];
        plane.x[k] = x[3 + k];
        plane.y[k] = x[6 + k];
    }
    for (int k = 0; k < 4; ++k) {
        plane.domain[k] = x[9 + k];
        plane.extents[k] = x[13 + k];
    }
    model_.faces.push_back({plane, std::nullopt, reversed, int(model_.closed.size()) - 1});
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

std::unique_ptr<Core> Builder::finish() {
    return guarded([&] { return std::make_unique<Core>(std::move(model_)); });
}

RawEvaluation evaluate_face(const Core& core, std::size_t face, double u, double v) {
    return guarded([&] {
        check_finite(u);
        check_finite(v);
        const Surface& surface = core.model().faces.at(face).surface;
        const auto domain = surface_domain(surface);
        if (Q(u) < domain[0] || Q(u) > domain[1] || Q(v) < domain[2] || Q(v) > domain[3])
            throw std::invalid_argument("the point is outside the surface's domain");
        const auto e = evaluate(surface, Q(u), Q(v));
        RawEvaluation raw;
        for (const auto* vector : {&e.point, &e.du, &e.dv})
            for (const Q& x : *vector) raw.numbers.push_back(enclose(x));
        return raw;
    });
}

RawSide side_of(const Core& core, std::size_t face, double u, double v) {
    return guarded([&] {
        check_finite(u);
        check_finite(v);
        const Region& region = core.face(face).region;
        return RawSide{std::uint8_t(side(region, Q(u), Q(v))), in_gap(region, Q(u), Q(v))};
    });
}

void set_rounding_upward(bool upward) { std::fesetround(upward ? FE_UPWARD : FE_TONEAREST); }

}  // namespace feeler_oracle
