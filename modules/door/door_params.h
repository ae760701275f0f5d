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
    {"gyro_range_rad_s", &DoorParams::gyro_range_rad_s, 1, 70, "rad/s", Audience::kUser,
     "full scale of the gyro: a reading at it is saturated and interpolated over"},
    {"accel_range_m_s2", &DoorParams::accel_range_m_s2, 10, 315, "m/s^2", Audience::kUser,
     "full scale of the accelerometer: a reading at it is saturated and interpolated over"},
    {"spike_rad_s", &DoorParams::spike_rad_s, 0.1f, 70, "rad/s", Audience::kExpert,
     "a single angular rate that differs by more from both its neighbours is a spike and "
     "interpolated over"},
    {"spike_m_s2", &DoorParams::spike_m_s2, 1, 315, "m/s^2", Audience::kExpert,
     "a single specific force that differs by more from both its neighbours is a spike and "
     "interpolated over"},
    {"stuck_samples", &DoorParams::stuck_samples, 3, 1000, count_of("samples"), Audience::kExpert,
     "equal IMU samples in a row after which the IMU counts as stuck; the rest of them is "
     "interpolated over"},
    {"gap_s", &DoorParams::gap_s, 0.001f, 10, "s", Audience::kExpert,
     "longest interval between IMU samples that is not counted as a gap"},
    {"bridge_s", &DoorParams::bridge_s, 0.05f, 10, "s", Audience::kExpert,
     "longest gap of the IMU that is interpolated over; after a longer one tracking restarts. "
     "Timeout of a live IMU"},
    {"break_s", &DoorParams::break_s, 0.05f, 10, "s", Audience::kExpert,
     "a stamp this far in the future must be confirmed by the next one; stamps that go back by "
     "this much mean that a clock was set back"},
    {"clock_step_s", &DoorParams::clock_step_s, 0.05f, 2, "s", Audience::kExpert,
     "a step of one sensor's stamps beyond its period that starts the test whether its clock was "
     "set"},
    {"pair_s", &DoorParams::pair_s, 0, 0.1f, "s", Audience::kExpert,
     "largest difference between the stamps of a stereo pair; an image that is farther off is left "
     "out as late"},
    {"frame_wait_s", &DoorParams::frame_wait_s, 0.01f, 10, "s", Audience::kExpert,
     "timeout of the cameras: after it IMU samples no longer wait for a frame"},
    {"lost_s", &DoorParams::lost_s, 0.01f, 10, "s", Audience::kExpert,
     "a sensor whose driver has reported nothing but faults for this long is lost"},
};
static_assert(sizeof(DoorParams) == std::size(kDoorRows) * sizeof(float));
static_assert(in_range(DoorParams{}, kDoorRows));

// 126 years either way. Beyond is no time, and differences of such stamps would overflow.
inline constexpr TimeNs kStampMax = 4'000'000'000'000'000'000;

inline bool is_stamp(TimeNs t) { return t >= -kStampMax && t <= kStampMax; }

}  // namespace pirvs
