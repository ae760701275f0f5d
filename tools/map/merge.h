// What    Two maps of one place as one: the second is laid on the first where both know the same
//         points, and what both know becomes one point.
// In      Two maps; the first keeps its frame.
// Out     The first map, with the second in its frame and epoch: keyframes, points, nodes of names
//         that were free. How much they shared, and how well that fits.
// Frames  W of the first. The frames differ by a turn about the vertical and a shift.
// Errors  InputError: too few points that both know, or no one motion fits them.
// Cost    ~0.5 s for two full maps.
// Source  Fischler, Bolles, 1981 (RANSAC); the least squares of a turn in the plane are closed.
#pragma once

#include <cstddef>

#include "modules/map/map.h"

namespace pirvs::tools {

struct MergeReport {
  size_t matched = 0, shared = 0;  // by descriptor alone; of these, what fits one motion
  double rms_m = 0;                // of the shared points, once laid on each other
  SE3 T_AB;                        // from the second's frame to the first's
  size_t points_left_out = 0, keyframes_left_out = 0;  // for want of room: the least seen
};

MergeReport merge_maps(Map& a, const Map& b);

}  // namespace pirvs::tools
