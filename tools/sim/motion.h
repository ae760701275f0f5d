// What    How devices move that do not fly through a hall: paths of a kind, drawn by a seed.
// In      kind; seed; standstill before it; R_LB as in path.h.
// Out     hover      climbs 0.7 m, then stays within a hand's breadth and looks about a little
//         loop       laps of 20 m in 13 s that pass the same places in the same directions
//         handheld   carried at 0.6 m/s: steps at 1.8 Hz, and shakes of 1 to 3 Hz that come and go
//         vehicle    on a floor, without sideways motion: speeds up to 3 m/s, stops every 14 s,
//                    pitches as it does, and rattles at 5 to 7 Hz
// Frames  W: z up.
// Units   s, m.
// Errors  find_motion: false for an unknown name.
// Source  own: sizes and frequencies are chosen, not measured.
#pragma once

#include <string>

#include "tools/sim/path.h"

namespace pirvs::tools {

enum class Motion : uint8_t { kHover, kLoop, kHandheld, kVehicle, kCount };

bool find_motion(const std::string& name, Motion& out);

Path make_motion(Motion motion, uint64_t seed, double rest_s, double duration_s, const Mat3& R_LB);

}  // namespace pirvs::tools
