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

// Degrees of A and B.
struct Degrees {
    int p, q;
    size_t index(int i, int j) const { return size_t(i) * (q + 1) + j; }
};
inline Degrees objective_degrees(const Objective& o, const Piece& s) {
    return o.linear ? Degrees{s.p, s.q} : Degrees{2 * s.p, 2 * s.q};
}

// A and B in doubles; the true coefficients are within ra and rb of them.
struct Net64 {
    std::vector<double> a, b;
    double ra = 0, rb = 0;
};
Net64 objective_net64(const Objective& o, const Piece& s);
// On a box of the piece, made in intervals: radii are those of the box's own coefficients.
Net64 objective_net64(const Objective& o, const Piece& s, const DyadicBox& box);
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
