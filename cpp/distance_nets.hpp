// Bernstein nets of the objective on a box, in doubles and in intervals.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "distance_pieces.hpp"

namespace feeler_oracle {

// What is minimised: |x - c|^2, or c.x - h.
struct Objective {
    bool linear;
    std::array<double, 3> c;
    double h = 0;
};

// A dyadic box of a piece's unit square: [iu, iu + 1] / 2^lu x [iv, iv + 1] / 2^lv.
struct DyadicBox {
    int lu = 0, lv = 0;
    std::uint64_t iu = 0, iv = 0;

    DyadicBox half(bool along_u, bool upper) const {
        DyadicBox b = *this;
        (along_u ? b.lu : b.lv) += 1;
        auto& i = along_u ? b.iu : b.iv;
        i = 2 * i + (upper ? 1 : 0);
        return b;
    }
};
// The deepest level in one direction: indices stay exact in a double.
constexpr int kDeepest = 52;
// Whether a box may be halved. Where weights are far apart, what happens next to 0 may need boxes
// smaller than 2^-kDeepest, whose indices are small.
inline bool may_halve(const DyadicBox& b, bool along_u, bool far, int bits = kDeepest) {
    constexpr int kDeepestFar = 200;
    const int level = along_u ? b.lu : b.lv;
    if (!far) return level < kDeepest;
    return level < kDeepestFar && (along_u ? b.iu : b.iv) < std::uint64_t(1) << (bits - 1);
}

// Degrees of A and B.
struct Degrees {
    int p, q;
    size_t index(int i, int j) const { return size_t(i) * (q + 1) + j; }
};
inline Degrees objective_degrees(const Objective& o, const Piece& s) {
    return o.linear ? Degrees{s.p, s.q} : Degrees{2 * s.p, 2 * s.q};
}

// A and B in doubles. Two bounds on what a coefficient is off by, of which the lesser holds: ra and
// rb for all alike; ea b_k for a_k and eb b_k for b_k, where b_k itself is what was computed. The
// second is as good where weights are 1e24 apart, since |a_k| <= ratio b_k: averages of positive
// numbers keep such bounds, so errors stay small in units of A / B. (Infinite: not known.)
struct Net64 {
    std::vector<double> a, b;
    double ra = 0, rb = 0;
    double ea = 0, eb = 0, ratio = 0;

    double error_a(size_t k) const { return std::min(ra, next_up(ea * b[k])); }
    double error_b(size_t k) const { return std::min(rb, next_up(eb * b[k])); }
    // What A / B is off by, roughly, where it is at most f.
    double noise(double f) const;
};
Net64 objective_net64(const Objective& o, const Piece& s);
// Halves; every averaging rounds once, and at most degree of them make a coefficient.
void split64(const Net64& n, Degrees d, bool along_u, Net64& left, Net64& right);

// A and B in intervals, on a box of the piece.
struct NetMp {
    std::vector<Interval> a, b;
};
NetMp objective_net(const Objective& o, const Piece& s, const DyadicBox& box);
void split(const NetMp& n, Degrees d, bool along_u, NetMp& left, NetMp& right);

// Value and first derivatives at (x, y) in the unit square.
struct Jet {
    Interval f, u, v;
};
Jet evaluate_net(const std::vector<Interval>& c, Degrees d, const Real& x, const Real& y);

// A minimiser over the unit square of the Bernstein polynomial h, by projected Newton; no
// guarantee. Returns the second derivatives there as well.
struct Newton64 {
    double x, y, uu, uv, vv;
};
Newton64 newton64(const std::vector<double>& h, Degrees d, double x, double y);

}  // namespace feeler_oracle
