// What the sensor door takes for possible. Units and meaning are in the rows.
#pragma once

#include <iterator>

#include "core/base/time.h"
#include "core/params/params.h"

namespace pirvs {

struct DoorParams {
  float gyro_range_rad_s = 34.9f;
  float accel_range_m_s2 = 156.9f;
  float spike_rad_s = 1.5f;
  float spike_m_s2 = 25.0f;
  float stuck_samples = 10;
  float gap_s = 0.05f;
  float bridge_s = 1.0f;
  float break_s = 0.5f;
  float clock_step_s = 0.15f;
  float pair_s = 0.001f;
  float frame_wait_s = 0.15f;
  float lost_s = 0.5f;
};

inline constexpr ParamRow<DoorParams> kDoorRows[] = {
    {"gyro_range_rad_s", &DoorParams::gyro_range_rad_s, 1, 70, "rad/s",
     "full scale of the gyro: a reading there is saturated and bridged"},
    {"accel_range_m_s2", &DoorParams::accel_range_m_s2, 10, 315, "m/s^2",
     "full scale of the accelerometer, likewise"},
    {"spike_rad_s", &DoorParams::spike_rad_s, 0.1f, 70, "rad/s",
     "a single rate this far from both its neighbours is a spike and bridged"},
    {"spike_m_s2", &DoorParams::spike_m_s2, 1, 315, "m/s^2", "a single force, likewise"},
    {"stuck_samples", &DoorParams::stuck_samples, 3, 1000, "1",
     "as many equal samples in a row: the IMU is stuck, the rest is bridged"},
    {"gap_s", &DoorParams::gap_s, 0.001f, 10, "s", "a longer gap of the IMU is counted"},
    {"bridge_s", &DoorParams::bridge_s, 0.05f, 10, "s",
     "a longer one is not bridged: tracking starts anew; a live IMU silent for longer is told"},
    {"break_s", &DoorParams::break_s, 0.05f, 10, "s",
     "a stamp this far ahead waits for the next; time that runs back this long is a clock set "
     "back"},
    {"clock_step_s", &DoorParams::clock_step_s, 0.05f, 2, "s",
     "stamps of one sensor that step by more over its period: was its clock set against the "
     "other's?"},
    {"pair_s", &DoorParams::pair_s, 0, 0.1f, "s",
     "an image whose stamp is farther from its frame's is late and left out"},
    {"frame_wait_s", &DoorParams::frame_wait_s, 0.01f, 10, "s",
     "cameras silent for longer: IMU samples no longer wait for them"},
    {"lost_s", &DoorParams::lost_s, 0.01f, 10, "s",
     "a sensor whose driver has reported nothing but faults for this long is lost"},
};
static_assert(sizeof(DoorParams) == std::size(kDoorRows) * sizeof(float));
static_assert(in_range(DoorParams{}, kDoorRows));

// 126 years either way. Beyond is no time, and differences of such stamps would overflow.
inline constexpr TimeNs kStampMax = 4'000'000'000'000'000'000;

inline bool is_stamp(TimeNs t) { return t >= -kStampMax && t <= kStampMax; }

}  // namespace pirvs
