// Ways down from a box and walls around it: what decides whether a candidate is a contact. See
// contacts.hpp for the definitions.
//
// fall. Start at a uv point q0 (on the loop, about), and let w be a step in uv. If
// (1) the segment from q0 + s0 w to q0 + w keeps clear of all loops (in boxes that cover it) and
//     its end is not outside the region, exactly: then none of it is;
// (2) on the segment f rises by no more than bounds of grad f . w add up to, over boxes that cover
//     it and every patch that meets them (f is continuous and piecewise smooth, across knot lines
//     too);
// (3) the point of q0 + s0 w is so near to all points of K that the length of that jump and the
//     rise of (2) are together less than `join`;
// (4) f at its end is below K's lo by more than `join`,
// then from each point of K a jump and this path lead down: no contact is in K.
//
// walled. f > bound at all points of F whose distance from K is in [near, far]: by branch and bound
// over the patches, of which boxes outside the region do not count.
#pragma once

#include <array>
#include <vector>

#include "contacts.hpp"

namespace feeler_oracle {

// A place on (or next to) the boundary of a face's region, in doubles.
struct Place {
    int face;
    int arc;  // -1: not on one
    double t;
    double u, v;
};

// The pieces of all faces, one after another, as Pieces has them.
//
// Throws std::invalid_argument where a face has a native surface whose parameters are not linear in
// its patches', a circular arc, or images of trims with a slack: ways and walls take boxes of
// parameters to be the patches' own, and images to be exact.
struct AllPieces {
    explicit AllPieces(const Pieces& model);
    std::vector<const Piece*> pieces;
    std::vector<const FacePieces*> faces;  // null where a face has no points
    double size;

    const Region& region(int face) const { return *faces[size_t(face)]->region; }
    const std::vector<ArcNet>& arcs(int face) const { return faces[size_t(face)]->arcs; }
};

class Ways {
 public:
    // The pieces must live as long as this.
    Ways(const AllPieces& model, const Objective& objective, double join, long budget);

    // The place of an arc's parameter.
    Place place(int face, int arc, double t) const;
    // Places of the other images of the place's edge that are next to it.
    std::vector<Place> partners(const Place& place) const;
    // How far the nearest of these is, about; 0 if there is none.
    double gap(const Place& place) const;

    bool falls(const Place& place, const std::array<double, 6>& k, double lo);
    bool walled(const std::array<double, 6>& k, double hi, double near, double far);

    bool spent() const { return left_ <= 0; }

 private:
    // The nearest points of the other arcs of the place's edge, and how far they are, about.
    std::vector<std::pair<Place, double>> others(const Place& place) const;
    struct Local {  // point and derivatives over a uv box
        std::array<Interval64, 3> p, du, dv;
    };
    Local evaluate(const Piece& patch, const Interval64& u, const Interval64& v) const;
    Interval64 slope(const Local& at, const Interval64& wu, const Interval64& wv) const;
    bool falls_along(const Place& q, double su, double sv, double start,
                     const std::array<double, 6>& k, double lo);
    Interval64 value(const Local& at) const;
    std::vector<const Piece*> patches_at(int face, double u0, double u1, double v0,
                                         double v1) const;

    const AllPieces& model_;
    const Objective o_;
    const double join_;
    long left_;
    std::vector<std::vector<int>> patches_;               // of each face
    std::vector<std::vector<std::pair<int, int>>> uses_;  // of each edge: face, arc
};

}  // namespace feeler_oracle
