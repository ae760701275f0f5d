// New map points: the tracks of a keyframe that have none yet, triangulated from all their views.
// In      the newest keyframe, in the map, its sightings of known points tied to them.
// Out     points in the map, with covariance and descriptor, all their sightings tied to them.
// Frames  W, C.
// Errors  none; points_rejected counts what has too little parallax or fits too badly, points_full
//         what found no room.
// Cost    In the slice of a new keyframe, mapper.h. Mapping's core alone.
// Source  PIRVS paper, section IV.C; modules/matching/triangulate.h.
#pragma once

#include "core/camera/camera.h"
#include "modules/mapping/mapping_counters.h"
#include "modules/mapping/mapping_params.h"
#include "modules/mapping/working_map.h"

namespace pirvs {

void create_points(WorkingMap& map, const Camera* cameras, const MappingParams& params,
                   MappingCounters& counters);

}  // namespace pirvs
