// What leaves the map: once it is full, the keyframes and points that contribute least to it; and
// always the points that too few views constrain.
// In      the map; `window`, the number of newest keyframes that an adjustment moves.
// Out     a place in the map's order, or how many points were released.
// Errors  none.
// Cost    weigh_keyframes(): the sightings of kWeighedAtOnce keyframes; the others one pass over
//         the points, when there is something to do. Mapping's core alone.
// Source  own; docs/results.md, "Long flights".
#pragma once

#include "modules/mapping/working_map.h"

namespace pirvs {

// The contribution of a keyframe is the sum over its points of its share of their views. A slice of
// the map each call; `next`, kept by the caller, is where the slice begins.
inline constexpr size_t kWeighedAtOnce = 64;
void weigh_keyframes(WorkingMap& map, size_t& next);

// Place of the keyframe that contributes least, among those that no adjustment moves any more and
// that are not to be kept. By contribution, not by age: a device that hovers does not forget the
// way it came.
size_t least_useful(const WorkingMap& map, size_t window);

// Makes room for all points that one keyframe can bring. The points with the fewest views leave, of
// those that none of the last `window` keyframes sees; of equals, those not seen for longest.
uint32_t forget_points(WorkingMap& map, size_t window);

// A map that was loaded stays as it is: nothing of it leaves any more, but what must make room now
// for a run of its own beside it. While no run has begun.
void keep_all(WorkingMap& map);

// A point needs two views, and once its first keyframes are past, three.
uint32_t remove_weak_points(WorkingMap& map);

}  // namespace pirvs
