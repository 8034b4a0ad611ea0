// Surfaces of all kinds as rational Bezier patches with interval coefficients.
//
// A turn by an angle theta < pi from a0, at the angle a0 + phi, is an exact rational quadratic in a
// parameter s of [0, 1] of its own: with h = theta / 2 and m = a0 + h,
//     (cos, sin) = ((1-s)^2 (cos a0, sin a0) + 2 s (1-s) (cos m, sin m) + s^2 (cos a1, sin a1)) /
//     w, w = (1-s)^2 + 2 s (1-s) cos h + s^2,    tan(phi / 2) = s sin h / (1 - s + s cos h)
// (The NURBS Book, 7.3; its middle point (cos m, sin m) / cos h has the weight cos h). So arcs,
// revolutions and sums are rational Bezier nets over a unit square. Their coefficients are
// cosines, sines and roots: enclosed, some 300 bits. The true surface is *one* choice of
// coefficients within the intervals, so that whatever interval arithmetic proves of the net is
// true of the surface.
//
// Only the parameters differ: ParameterMap takes s to the surface's own parameter and back. It
// increases strictly and smoothly, with a derivative that vanishes nowhere, so critical points,
// signs of derivatives and differentiability are the same in either.
//
// Cuts: knots, corners and joints as stored; turns besides at angles that are no likely place of a
// foot (a cut is allowed anywhere, but a foot on it is looked for in two patches), into pieces of
// less than a quarter turn. A pole is a side of the square where the coefficients are one point
// (within their intervals); there S is no immersion, which nothing in the searches asks for.
#pragma once

#include <array>
#include <vector>

#include "interval.hpp"
#include "model.hpp"

namespace feeler_oracle {

// s in [0, 1] to the parameter t in [from, to] of a curve or surface, increasing, ends to ends.
class ParameterMap {
 public:
    // t = from + s (to - from).
    ParameterMap(Q from, Q to);
    // The angle phi of the turn runs linearly over [0, turn] as t does over [from, to]; turn in
    // (0, pi).
    ParameterMap(Q from, Q to, const Q& turn);

    const Q& from() const { return from_; }
    const Q& to() const { return to_; }
    bool linear() const { return !turn_; }
    // Half of the turn, and its sine and cosine; 0, 0, 1 if linear.
    const Interval& half() const { return half_; }
    const Interval& sin_half() const { return sin_half_; }

    // Enclosures of the image of an interval, cut with [from, to], or with [0, 1]; 0 and 1 (from
    // and to) themselves go to an end exactly, as far as it is a number of kBits bits.
    Interval to_surface(const Interval& s) const;
    Interval to_square(const Interval& t) const;
    // The first as outward doubles; half the work of the other.
    Interval64 to_surface64(const Interval64& s) const;
    // The other way likewise, with the derivative ds/dt there.
    struct Square64 {
        Interval64 s, slope;
    };
    Square64 to_square64(const Interval64& t) const;
    // The same map onto another range of t.
    ParameterMap onto(Q from, Q to) const;

 private:
    Q from_, to_;
    Interval ifrom_, ito_;
    Interval64 from64_, to64_;
    bool turn_ = false;
    Interval half_{0.0}, sin_half_{0.0}, cos_half_{1.0};
};

// Homogeneous coefficients X, Y, Z, W of the degree; W > 0.
using HomogeneousNet = std::array<std::vector<Interval>, 4>;

// A piece of a curve in space.
struct CurveNet {
    int degree;
    HomogeneousNet net;
    ParameterMap map;
    // Whether the curve may have a corner at the start, at the end. (The ends of its domain count
    // as none.)
    std::array<bool, 2> crease;
};

// (X / W, Y / W, Z / W), coefficient (i, j) at i (q + 1) + j, i along u.
struct NativePatch {
    int p, q;
    HomogeneousNet net;
    std::array<ParameterMap, 2> map;  // of u, of v
    // Whether the surface may be only C0 across the first and the last line of constant u
    // (crease[0]), of constant v (crease[1]), inside the domain.
    std::array<std::array<bool, 2>, 2> crease;
    // Whether S is affine in its own parameters: a parallelogram.
    bool affine;
};

// Throws std::invalid_argument where a frame has no direction, an arc or a revolution turns more
// than kMaxPieces times a radian, or the coefficients leave the range in which W > 0 can be told.
std::vector<CurveNet> curve_nets(const Curve3& curve);
std::vector<NativePatch> native_patches(const Surface& surface);

constexpr int kMaxPieces = 4096;

// x / |x| and so on of stored vectors, enclosed. Throws std::invalid_argument for a zero vector.
using Vector3 = std::array<Interval, 3>;
Vector3 to_vector(const std::array<double, 3>& x);
Vector3 normalized(const Vector3& x);
Vector3 cross(const Vector3& a, const Vector3& b);
Interval dot(const Vector3& a, const Vector3& b);

// A turn over the angles a0 to a1 (either may be the larger, less than pi apart): Bernstein
// coefficients of degree 2 of cosine and sine times w, and of w.
struct TurnNet {
    std::array<Interval, 3> cos, sin, w;
};
TurnNet turn_net(const Q& a0, const Q& a1);

// The angles at which a turn from a0 to a1 is cut, both ends included.
std::vector<Q> turn_cuts(const Q& a0, const Q& a1);

}  // namespace feeler_oracle
