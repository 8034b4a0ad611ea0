// Where a line meets the trimmed faces.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core.hpp"
#include "interval.hpp"

namespace feeler_oracle {

enum class LineKind { Line, Ray, Segment };

struct Line {
    std::array<double, 3> origin, direction;
    LineKind kind;
};

struct LineHit {
    int face = 0;
    Interval t;
    Interval t_end;         // where the line lies in the face from t on
    bool lies_in = false;   // t_end counts
    bool boundary = false;  // on the region's boundary, exactly
    // How often the line meets the surface here: 1 crossing it at an angle, 2 touching it, 3
    // touching and crossing it, ... 0: not known, or no isolated hit.
    int multiplicity = 0;
    // Passes from one side of the surface to the other, as proven; false: not known, or touching.
    bool transversal = false;
    bool tangential = false;     // proven to touch without crossing, or to lie in the face
    std::array<double, 2> uv{};  // about
};

struct LineOpen {
    int face;
    Interval t;
    std::string why;
};

struct LineAnswer {
    std::vector<LineHit> hits;   // of each face by t
    std::vector<LineOpen> open;  // more hits may be in these parts of the line, and only there
    // Every point where the line meets a face's surface, extended beyond the domain by the margin,
    // is off the region's boundary by the margin in uv. See inside.hpp.
    bool clear = true;
};

struct LineOptions {
    int only_brep = -1;  // -1: all
    // Boxes of all faces together, and what costs as much. What remains then is open.
    long budget = 20000;
    // Only faces with a non-zero entry, if given.
    const std::vector<char>* faces = nullptr;
};

LineAnswer line_hits(const Core& core, const Line& line, const LineOptions& options = {});

// The parts of it.
void line_hits_plane(const PreparedFace& face, int index, const Line& line, LineAnswer& answer);
void line_hits_nurbs(const PreparedFace& face, int index, const Line& line, long& budget,
                     LineAnswer& answer);

// d_k e_i - d_i e_k for the largest |d_k| and the two other i: both normal to d, independent.
struct Planes {
    int k, i, j;
    explicit Planes(const std::array<double, 3>& d);
};

// Whether the box is proven to miss the line through it, whatever part of it counts.
bool box_missed(const std::array<Interval64, 3>& box, const Line& line);

// Adds the hit unless t is not on the part of the line that counts.
void keep_hit(const Line& line, LineHit hit, LineAnswer& answer);

// Width of enclosures of roots of one-variable polynomials.
constexpr int kRootBits = 256;

}  // namespace feeler_oracle
