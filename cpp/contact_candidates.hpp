// Where local minimisers of f over a face may be: item 1 of contacts.hpp.
#pragma once

#include <array>
#include <vector>

#include "contact_model.hpp"
#include "distance_nets.hpp"

namespace feeler_oracle {

// A local minimiser may be in the box.
struct Candidate {
    int face;
    std::array<double, 6> box;
    Real lo, hi;         // of the objective; hi infinite if no point of F is known in it
    bool inner = false;  // a critical point well inside the region
    bool sharp = false;  // one point, enclosed; else a part of a face or trim on which f varies
                         // by little, or that was not searched further
    Place place{-1, -1, 0, 0, 0};  // of those on the boundary; face -1: not known
    bool whole_arc = false;        // the place may be anywhere on the piece (a pole)
    double t0 = 0, t1 = 0;         // then
};

// The end of a Trim or Joint from which f falls by `depth` along it.
struct Fall {
    std::array<double, 6> box;
    double depth;
};

struct Candidates {
    std::vector<Candidate> all;
    std::vector<Fall> falls;
    bool whole = true;  // the budget sufficed; else what is left is among the candidates
    long nodes = 0;     // boxes bounded in doubles
};

// All with f <= bound, of the objective's own value. `nodes`: how many boxes at most.
Candidates candidates(const AllPieces& model, const Objective& objective, double bound, long nodes);

}  // namespace feeler_oracle
