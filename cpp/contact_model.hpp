// The pieces of all faces as the search for contacts takes them, and places on their trims.
#pragma once

#include <array>
#include <vector>

#include "distance_pieces.hpp"
#include "distance_region.hpp"

namespace feeler_oracle {

class Core;

// A place on (or next to) the boundary of a face's region, in doubles.
struct Place {
    int face;
    int arc;  // of the region; -1: not on one
    double t;
    double u, v;
};

// Point and derivatives over a uv box of a face.
struct Local {
    std::array<Interval64, 3> p, du, dv;
};

// The pieces of all faces, one after another, as Pieces has them.
struct AllPieces {
    explicit AllPieces(const Pieces& model);
    std::vector<const Piece*> pieces;
    std::vector<const FacePieces*> faces;  // null where a face has no points
    double size;

    const Region& region(int face) const { return *faces[size_t(face)]->region; }
    PieceInRegion in_region(const Piece& s) const { return {s, *faces[size_t(s.face)]}; }

    // The place of an arc's parameter. Nothing rests on it.
    Place place(int face, int arc, double t) const;
    // The patches of the face that meet a box of its parameters.
    std::vector<const Piece*> patches_at(int face, double u0, double u1, double v0,
                                         double v1) const;
    // Places on the other arcs of the place's edge that are nearest to it, and how far they are,
    // about.
    std::vector<std::pair<Place, double>> others(const Place& place) const;

    // Patches of each face.
    std::vector<std::vector<const Piece*>> patches;
    // Of each face: no less than the sum of the distances by which the surface jumps, over its
    // lines of constant parameter. The curves of a revolution or of a sum may be poly-curves whose
    // segments meet but for rounding; turning is an isometry, and a sum moves one curve along the
    // other, so that the distance at a line is that of any two corners that meet on it. Other
    // surfaces are continuous, and their corners the same points, enclosed.
    std::vector<double> jumps;

 private:
    std::vector<std::vector<std::pair<int, int>>> uses_;  // of each edge: face, arc
};

// Over the part of a patch in a box of its surface's parameters.
Local evaluate(const Piece& patch, const Interval64& u, const Interval64& v);

// Lower bound of the distance of two boxes (x0, x1, y0, y1, z0, z1), and upper bound of that of
// their points.
double least_apart(const std::array<double, 6>& a, const std::array<double, 6>& b);
double most_apart(const std::array<double, 6>& a, const std::array<double, 6>& b);
// Above the distance of any point of b from the box k.
double farthest(const std::array<double, 6>& k, const std::array<double, 6>& b);

}  // namespace feeler_oracle
