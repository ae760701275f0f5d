// What may come to the door besides IMU samples and frames: it passes in order of sensor time.
// Frames  GnssFix: the antenna, WGS 84, velocity north, east, down. WheelSample: wheel_sample.h.
// Units   ns on the IMU's clock, deg, m, m/s, rad/s.
// Source  docs/gnss.md: the columns of gnss0/data.csv.
#pragma once

#include <cstdint>

#include "core/base/time.h"
#include "core/math/types.h"
#include "modules/wheels/wheel_sample.h"

namespace pirvs {

enum class GnssFixType : uint8_t { kNone, k2d, k3d, kFloat, kFixed };

struct GnssFix {
  TimeNs t = 0;
  double latitude_deg = 0, longitude_deg = 0, height_m = 0;
  Vec3 v_ned = Vec3::Zero();  // z NaN: only the horizontal velocity is measured
  double sigma_horizontal_m = 0, sigma_vertical_m = 0, sigma_velocity_m_s = 0;  // of one axis
  GnssFixType type = GnssFixType::kNone;
  bool has_velocity = false;
};

}  // namespace pirvs
