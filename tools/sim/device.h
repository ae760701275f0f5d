// What    The devices that can be simulated: their calibration and frame rate.
// In      a name: "euroc", "ironsides", "tumvi", "t265" or "oakd".
// Out     Calibration, camera rate, and R_LB: where the cameras look (x forward, y left, z up).
// Frames  euroc: B is the sensor's IMU (x up, y right, z forward); the others: x forward, z up.
// Errors  find_device returns nullptr for an unknown name.
// Source  EuRoC: the sensor.yaml of MH_01_easy. Ironsides: 133 x 100 degree lenses, 640 x 480 at
//         60 Hz, 65 mm apart (PIRVS paper, section II); its distortion and IMU noise are typical.
//         The others have the size, rate, baseline and about the lens of the devices they are
//         named after:
//         TUM VI (Schubert et al., IROS 2018), Intel RealSense T265, Luxonis OAK-D; the IMU is
//         that of ironsides.
#pragma once

#include <string>

#include "modules/calibration/calibration.h"

namespace pirvs::tools {

struct Device {
  const char* name;
  Calibration calibration;
  double camera_rate_hz;
  Mat3 R_LB;
};

const Device* find_device(const std::string& name);

}  // namespace pirvs::tools
