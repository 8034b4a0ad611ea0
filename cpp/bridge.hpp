// What Rust calls. Every entry runs in the default floating-point environment, restores the
// caller's, and throws nothing but std::exception (which the bridge turns into an error).
#pragma once

#include <cstdint>
#include <memory>

#include "core.hpp"
#include "rust/cxx.h"

namespace feeler_oracle {

struct RawContacts;
struct RawCriticalPoints;
struct RawDerivativeRoots;
struct RawDistance;
struct RawCrack;
struct RawDyadic;
struct RawEvaluation;
struct RawInside;
struct RawLine;
struct RawSide;

// Collects the raw data of BREPs, then makes the core.
class Builder {
 public:
    void add_brep(bool closed, std::size_t edges);
    void add_nurbs_face(bool reversed, std::size_t degree_u, std::size_t degree_v,
                        rust::Slice<const double> knots_u, rust::Slice<const double> knots_v,
                        rust::Slice<const double> net);
    // origin, x, y, domain, extents: 17 numbers.
    void add_plane_face(bool reversed, rust::Slice<const double> numbers);
    // A curve in space for the next face, and its pieces in order.
    void add_curve(rust::Slice<const double> params);
    void add_space_polyline(rust::Slice<const double> points, rust::Slice<const double> params);
    void add_space_nurbs_curve(std::size_t degree, rust::Slice<const double> knots,
                               rust::Slice<const double> points);
    // center, x, z, radius, angle, domain: 14 numbers.
    void add_space_arc(rust::Slice<const double> numbers);
    // origin, axis, angle, angle domain: 10 numbers. Takes the curve added before as its profile.
    void add_revolution_face(bool reversed, bool transposed, rust::Slice<const double> numbers);
    // Takes the two curves added before.
    void add_sum_face(bool reversed, rust::Slice<const double> base);
    // Of the last face. A face without it covers its whole domain.
    void set_trimmed();
    void add_loop();
    void add_trim(double start, double end, bool reversed, std::int64_t edge,
                  rust::Slice<const double> params);
    void add_polyline(rust::Slice<const double> points, rust::Slice<const double> params);
    void add_nurbs_curve(std::size_t degree, rust::Slice<const double> knots,
                         rust::Slice<const double> points);
    // center, x, y, radius, angle, domain: 11 numbers.
    void add_arc(rust::Slice<const double> numbers);
    // Leaves the builder empty.
    std::unique_ptr<Core> finish();

 private:
    void add_face(bool reversed, Surface surface);
    Curve3& last_curve();

    Model model_;
    std::vector<Curve3> curves_;  // for the next face
};

std::unique_ptr<Builder> new_builder();

// Makes now what queries would make on first use and keep. 0: the region and the patches of the
// face; 1: those of all faces, and their pieces; 2: also the images of all edges, and rough widths
// of their cracks (exact ones are made as queries come near).
void prepare(const Core& core, std::uint8_t what, std::size_t face);

RawEvaluation evaluate_face(const Core& core, std::size_t face, double u, double v, bool below_u,
                            bool below_v);
RawSide side_of(const Core& core, std::size_t face, double u, double v);
// Of trim `trim` of loop `loop` of a face, each counted from 0.
RawDerivativeRoots derivative_roots_of(const Core& core, std::size_t face, std::size_t loop,
                                       std::size_t trim);
RawDistance distance_to(const Core& core, double x, double y, double z, std::int64_t nodes);
RawDistance support_of(const Core& core, double x, double y, double z, double h,
                       std::int64_t nodes);
// Of the distance to the point `at`, or (linear) of at.x - h, up to the limit.
RawContacts contacts_of(const Core& core, bool linear, rust::Slice<const double> at, double h,
                        double limit, double join);
// A box x0, x1, y0, y1, z0, z1 of the foot (contact_foot.hpp), or nothing.
rust::Vec<double> foot_of(const Core& core, bool linear, rust::Slice<const double> at, double h,
                          double limit);
// See contacts.hpp.
double join_width(const Core& core);
// kind: 0 line, 1 ray, 2 segment.
RawLine line_truth(const Core& core, rust::Slice<const double> origin,
                   rust::Slice<const double> direction, std::uint8_t kind);
// Of edge `edge` of all; fewer than two images: not `shared`.
RawCrack crack_of(const Core& core, std::size_t edge);
// Of the polynomial with these Bernstein coefficients (root_candidates.hpp).
rust::Vec<double> eigen_candidates(rust::Slice<const double> bernstein);
// Of the distance from a point to one polynomial patch (critical_points.hpp).
RawCriticalPoints critical_points_of(std::size_t p, std::size_t q, rust::Slice<const double> net,
                                     const std::array<double, 3>& point);
// By so many rays, which must agree.
RawInside inside_of(const Core& core, double x, double y, double z, std::int32_t rays);

// A Real rounded to kTruthBits in the direction named; 0 if it is no number.
RawDyadic to_dyadic(const Real& x, mpfr_rnd_t direction);
// More than the 160 significant bits of the truth.
constexpr mpfr_prec_t kTruthBits = 192;

// For tests: sets the rounding mode of the calling thread to upward (true) or nearest.
void set_rounding_upward(bool upward);

}  // namespace feeler_oracle
