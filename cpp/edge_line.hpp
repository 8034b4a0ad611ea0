// Crossings of a line, and whether it passes a crack.
//
// Definitions. The line is in the crack of an edge of two images or more where it is within d_e of
// one of them. A passage is all of these stretches of the line that are no farther than d_e apart
// from the next. Of the line's hits, those in one passage are linked, and linked hits, through
// whatever others, count once; a hit in no passage counts once where it crosses, and not at all
// where it touches. `in_crack`: some passage has no hit. Stretches beyond the ends of a ray or a
// segment do not count. A line that lies in a face has no number of crossings.
//
// Method: the parts of the images near the line (edge_near.hpp), projected to it. A stretch reaches
// beyond these projections by d_e at most. So two parts whose projections are within d_e of each
// other are of one passage, two more than 3 d_e apart are of two, and what is between is not
// decided. A hit is in the crack where its point is within d_e of an image; a hit that is known to
// be exactly on its region's boundary, and near no other edge of its face, is on that edge. Where
// something is not known, the answer is given if it is the same either way.
#pragma once

#include "line.hpp"

namespace feeler_oracle {

struct LineCrossings {
    int crossings = -1;  // -1: not known
    int in_crack = -1;   // 0, 1; -1: not known
};

// Of the hits in `answer`, which is that of this line.
LineCrossings line_crossings(const Core& core, const Line& line, const LineAnswer& answer);

}  // namespace feeler_oracle
