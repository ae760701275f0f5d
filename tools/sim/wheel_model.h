// What    What the wheels of a vehicle would have told along a path.
// In      The truth as poses; how its wheels tell, and what is wrong with them; where the axle is;
//         seed.
// Out     A folder as an ASL recording's wheel0: data.csv, sensor.yaml. The first sample comes 7 ms
//         after the first pose, so that none has a frame's time by chance.
// Frames  V: wheel_calibration.h.
// Units   m, m/s, s.
// Errors  InputError: unknown kind, a folder that cannot be written, a truth of one pose.
// Cost    ~1 us a sample.
// Source  own.
#pragma once

#include <cstdint>
#include <string>

#include "core/math/se3.h"
#include "tools/dataset/trajectory.h"

namespace pirvs::tools {

struct WheelOptions {
  std::string kind;  // left_right, twist, ticks, steering; empty: no wheels
  double rate_hz = 50;
  double sigma_m_s = 0.005;  // white noise of a speed
  double scale = 1;          // what they tell over the truth: worn tyres
  int ticks_per_turn = 1024;
  double radius_m = 0.1, track_m = 0.4, wheelbase_m = 0.5;
  double spin_m_s = 0, spin_from_s = 0, spin_for_s = 0;  // the left wheel spins so much faster
};

void write_wheels(const WheelOptions& options, const Trajectory& truth, const SE3& T_BV,
                  uint64_t seed, const std::string& folder);

}  // namespace pirvs::tools
