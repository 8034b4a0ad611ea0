// The images of edges in space, the regions around vertices, and why parity needs no more.
//
// Definitions. The region of a face is the set of odd parity of its loops, cut with the domain D of
// its surface S. The image of a trim curve c is the curve S(clamp(c)), clamp moving each parameter
// to the nearest one in D; where c lies in D, as it nearly always does, this is S(c). The width d_e
// of an edge is the largest Frechet distance between two of its images, each run through in
// whichever direction gives less (edge_width.hpp). The crack of an edge is the set of all points
// within d_e of one of its images. A vertex region is the smallest box along the axes that holds:
// the ends of images that meet there, the images of the segments that join trims there, and the
// images of singular trims there.
//
// Theorem. Let B be a closed BREP: loops on every face, each non-singular edge used exactly twice.
// Let N be the union of its cracks and vertex regions. Let r be a ray from a point p that does not
// meet N, and let r meet the faces in finitely many points, each interior to a face's region and
// crossed transversally. Then the parity of their number is the same for all such rays from p, and
// the same for all p of a connected set that meets neither N nor a face. The points of odd parity,
// off N and off the faces, are the material.
//
// Proof, in chains modulo 2. (1) The boundary of the chain of a face is the sum of the images of
// its trim curves and joins: the chain P of odd parity in the parameter plane has the loops as its
// boundary; the clamp is Lipschitz, takes P to P cut with D but for parts that fall onto the border
// of D and carry no area, and commutes with taking the boundary. Hence the boundary of the sum C of
// all faces is the sum of the images of all trims and joins. (2) Two images of one edge, at
// Frechet distance <= d_e, bound a strip: join the points that are matched by straight segments.
// Each segment is no longer than d_e, so the strip lies in the crack; its boundary is the two
// images and the segments K at its two ends. (3) What remains of the boundary of C and all strips
// is the sum of the segments K, the joins' images and the singular trims' images: a cycle. Its
// connected parts are the graphs around vertices; each part is a cycle by itself and lies in one
// vertex region, since a segment K lies in the box of its ends. A box is convex: the cone over the
// cycle from a point of the box fills it there. (4) So C and a chain supported in N together make a
// cycle Z. The number of transversal intersections of a ray from p with Z, modulo 2, is the winding
// number of Z around p modulo 2, for every ray from p, and constant on connected sets off the
// support of Z. r meets Z only in C. (5) Another choice of the filling differs by a cycle in N. A
// ray that avoids N shows that p lies in the unbounded component of its complement, where that
// cycle winds around nothing. So the parity does not depend on the filling either.
//
// Points that no ray (and no path) joins to infinity off N have no side: Undecided(crack).
#pragma once

#include <vector>

#include "distance_pieces.hpp"

namespace feeler_oracle {

class Core;

// A trim's image: pieces in order along it. Those of kind Point enclose the image of a tiny part of
// the trim curve, between the pieces beside it.
struct Image {
    int face = -1;
    int edge = -1;                      // -1: a singular trim
    std::vector<const Piece*> pieces;   // Trim
    std::vector<const Piece*> between;  // Point
    bool whole = false;  // the pieces cover all of it; else some of the image is not known

    // All of it in doubles: x0, x1, y0, y1, z0, z1.
    std::array<double, 6> box;
};

struct VertexRegion {
    int brep;
    std::array<double, 6> box;
};

struct EdgeImages {
    std::vector<Image> images;           // of all faces, trims in order
    std::vector<std::vector<int>> uses;  // of each edge: its images
    // For an edge of two images: whether the second runs against the first.
    std::vector<char> against;
    std::vector<int> brep_of;  // of each edge, -1: not used
    std::vector<VertexRegion> vertices;
    std::vector<char> whole;  // of each BREP: all images known
};

// Twice as long as preparing the pieces, at most.
EdgeImages edge_images(const Core& core);

// How far the image may be from the piece's net, at most.
inline double slack_of(const Piece& piece) { return piece.slack; }

}  // namespace feeler_oracle
