// What a pack (bsp/replay/pack.h) says, as the stack wants it.
// Units   as modules/door/items.h and modules/calibration/calibration.h.
// Errors  none: an open pack has been checked.
#pragma once

#include "bsp/replay/pack.h"
#include "modules/calibration/calibration.h"
#include "modules/door/items.h"

namespace pirvs::board {

inline Calibration calibration_of(const bsp::Pack& pack) {
  const bsp::PackHeader& header = pack.header();
  Calibration out;
  for (int c = 0; c < kCamerasMax; ++c) out.camera[c] = pack.camera(c);
  out.imu = {header.gyro_noise, header.gyro_walk, header.accel_noise, header.accel_walk,
             header.rate_hz};
  out.camera_time_offset_ns = header.camera_time_offset_ns;
  out.gnss.p_BA = Vec3(header.antenna[0], header.antenna[1], header.antenna[2]);
  out.gnss.time_offset_ns = header.gnss_time_offset_ns;
  return out;
}

static_assert(bsp::kFixTypes == static_cast<uint32_t>(GnssFixType::kFixed) + 1);

inline GnssFix fix_of(const bsp::PackedFix& packed) {
  GnssFix out;
  out.t = packed.t;
  out.latitude_deg = packed.latitude_deg;
  out.longitude_deg = packed.longitude_deg;
  out.height_m = packed.height_m;
  for (int i = 0; i < 3; ++i) out.v_ned(i) = packed.v_ned[i];
  out.sigma_horizontal_m = packed.sigma_horizontal_m;
  out.sigma_vertical_m = packed.sigma_vertical_m;
  out.sigma_velocity_m_s = packed.sigma_velocity_m_s;
  out.type = static_cast<GnssFixType>(packed.type);
  out.has_velocity = packed.has_velocity != 0;
  return out;
}

}  // namespace pirvs::board
