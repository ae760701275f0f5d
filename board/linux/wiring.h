// The sensors of a board under Linux: cameras by V4L2, the IMU by IIO or as a chip on I2C, time by
// CLOCK_MONOTONIC. bsp/api/camera.h, imu.h, i2c.h and tick.h answer for them.
// In      wire_sensors(): before they are polled, from the core that polls them; unwire_sensors():
//         after the last frame is back.
// Out     A device that has something ends the wait of that core, but only while it is asked for:
//         a core that has other work does not wake for nothing.
// Errors  A missing or busy device is no error: it is told, and looked for again.
// Source  docs/adr/0010-a-live-board-under-linux.md.
#pragma once

#include "bsp/api/trigger.h"
#include "bsp/linux/i2c_imu.h"
#include "bsp/linux/iio.h"
#include "bsp/linux/v4l2_stereo.h"

namespace pirvs::board {

// Who drives the cameras: a PWM, or a pin; else nobody here. As output 0 of bsp/api/trigger.h.
struct TriggerSetup {
  int pwm_chip = -1, pwm_channel = 0;  // -1: no PWM
  const char* pin = "";
  bool urgent = false;  // the pin's thread: SCHED_FIFO
  bsp::TriggerTiming timing = {50'000'000, 1'000'000, 0, false};
};

struct SensorSetup {
  bsp::V4l2StereoSetup stereo;
  bsp::IioSetup iio;
  bool imu_is_on_i2c = false;
  bsp::I2cImuSetup i2c_imu;
  bsp::DeviceNews news;
  int core = 0;
  // Each frame as soon as it is there, on `core`, which may look at its images until it returns.
  void (*frame_taken)(const StereoFrame&) = nullptr;
};

void wire_sensors(const SensorSetup& setup);
// nullptr, or what is wrong. unwire_sensors() stops it.
const char* start_trigger(const TriggerSetup& setup);
void unwire_sensors();

// Counters of the drivers by name, `camera.left.lost` and so on.
using VisitCounter = void (*)(const char* device, const char* name, uint32_t value);
void for_each_sensor_counter(VisitCounter visit);

}  // namespace pirvs::board
