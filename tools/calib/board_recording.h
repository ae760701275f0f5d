// What    What a simulated device records of a board, as an ASL folder with drawn images.
// In      A device, how it is moved, the light.
// Out     FOLDER/mav0: cam0, cam1 with data.csv and PGM images, imu0 with data.csv and the
//         densities in sensor.yaml; FOLDER/target.yaml. FOLDER/truth: the device's true
//         calibration, as sensor.yaml files and calibration.cfg. The board is flat.
// Errors  InputError: it cannot be written.
// Cost    ~0.1 s an image of one core, 0.3 MB; one core a camera.
#pragma once

#include <string>

#include "tools/calib/board_camera.h"
#include "tools/calib/simulated_device.h"

namespace pirvs::tools {

struct DrawnRecording {
  // A detector needs whole tags, so that wider swings have to bring them to the rims.
  DrawnRecording() { motion.turning = 1.3, motion.moving = 1.2; }

  SimulatedRecording motion;
  BoardLight light;
  double exposure_s = 0.004;
  // A board like it beside it, at this share of its width away; 0: none.
  double second_board = 0;
};

void write_board_recording(SimulatedDevice& device, const DrawnRecording& how,
                           const std::string& folder);

}  // namespace pirvs::tools
