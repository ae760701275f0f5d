// What    How devices move that do not fly through a hall: paths of a kind, drawn by a seed.
// In      kind; seed; standstill before it; R_LB as in path.h.
// Out     hover      climbs 0.7 m, then stays within a hand's breadth and looks about a little
//         loop       laps of 20 m in 13 s that pass the same places in the same directions
//         handheld   carried at 0.6 m/s: steps at 1.8 Hz, and shakes of 1 to 3 Hz that come and go
//         vehicle    on a floor, without sideways motion: speeds up to 3 m/s, stops every 14 s,
//                    pitches as it does, and rattles at 5 to 7 Hz
//         spot       a vehicle that turns on the spot, ten times one way
//         ramps      a vehicle that goes up and down slopes of 10 degrees, winding
//         circuit    a vehicle on a lap of 300 m at 3 m/s
//         straight   a vehicle at 1 m/s from the first moment on
// Frames  W: z up.
// Units   s, m.
// Errors  find_motion: false for an unknown name.
// Source  own: sizes and frequencies are chosen, not measured.
#pragma once

#include <string>

#include "tools/sim/path.h"

namespace pirvs::tools {

enum class Motion : uint8_t {
  kHover,
  kLoop,
  kHandheld,
  kVehicle,
  kSpot,
  kRamps,
  kCircuit,
  kStraight,
  kCount
};

bool find_motion(const std::string& name, Motion& out);

// Where the axle of the path's vehicle is in the look frame; of a path that is no vehicle's
// straight below the camera.
Vec3 axle_L(const std::string& path);

Path make_motion(Motion motion, uint64_t seed, double rest_s, double duration_s, const Mat3& R_LB);

}  // namespace pirvs::tools
