// What    Simulates a recording: a device flown through a textured hall, written as an ASL folder.
// In      SimOptions; the same options give the same bytes, however many threads draw.
// Out     mav0/ with cam0, cam1, imu0, state_groundtruth_estimate0 (17 columns at IMU rate), and
//         gnss0 and wheel0 if asked for.
// Frames  B = IMU; W: z up.
// Units   s, Hz, grey values, SI.
// Errors  InputError: unknown device, folder cannot be written, nonsensical numbers.
// Cost    20 s of EuRoC: ~20 s on two cores, ~150 MB of PNG.
// Source  DESIGN.md, "The front door": pirvs sim.
#pragma once

#include <functional>
#include <string>

#include "tools/sim/device.h"
#include "tools/sim/gnss_model.h"
#include "tools/sim/imu_model.h"
#include "tools/sim/wheel_model.h"

namespace pirvs::tools {

struct SimOptions {
  std::string out;
  std::string device = "euroc";
  // rest, steady, a motion (motion.h), or the file of a recorded trajectory to follow
  std::string path = "spline";
  double forward_m_s = 0, left_m_s = 0.3, turn_deg_s = 0;  // of a steady path
  double ramp_s = 1;                                       // and from rest to that
  double duration_s = 20;
  double rest_s = 1;
  double rate_hz = 0;  // cameras; 0: the device's own
  uint64_t seed = 1;
  double gyro_noise = -1, gyro_walk = -1, accel_noise = -1, accel_walk = -1;  // < 0: the device's
  double gyro_bias_rad_s = 0.02;
  double accel_bias_m_s2 = 0.05;
  // As far from its data sheet as the estimator's parameters take an IMU to be: for tests of its
  // covariance. The recording says what the data sheet says.
  bool imu_as_expected = false;
  double exposure_ms = 5;
  int blur = 4;                // sub-images of an exposure at most; 1: no motion blur
  double image_noise = 3;      // sigma, grey values at mid grey
  double exposure_change = 0;  // relative amplitude
  double dark = 0;             // share of the light taken away, 0..1
  double dark_from_s = 0;
  double dark_for_s = 0;  // 0: to the end
  int boxes = 40;
  int movers = 0;
  uint64_t room = 0;   // a hall of this number that is the same for every flight; 0: the flight's
  double gone = 0;     // of a room: the share of its boxes that are not there
  bool relit = false;  // of a room: its lamps hang elsewhere
  std::string surfaces = "mixed";  // what covers the hall: mixed, chequered, plain
  double mover = 0;         // share of the view that one object fills that sways before the camera
  double mover_from_s = 0;  // 0: it is there from the start
  GnssOptions gnss;
  std::string gnss_of;  // only the fixes along this recording's truth: out is a gnss0
  WheelOptions wheels;
  std::string format = "png";
  int threads = 2;
};

// done, total: stereo frames; called from one thread at a time.
using SimProgress = std::function<void(size_t done, size_t total)>;

void simulate(const SimOptions& options, const SimProgress& progress);

}  // namespace pirvs::tools
