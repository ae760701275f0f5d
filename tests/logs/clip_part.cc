#include "tests/logs/clip_part.h"

#include <fstream>

#include "modules/calibration/calibration_text.h"
#include "tests/recordings.h"

namespace pirvs::systems {

tools::Recording first_part() {
  tools::Recording part = *clip();
  const TimeNs end = part.frames.front().t + from_seconds(kPart_s);
  while (part.frames.back().t > end) part.frames.pop_back();
  while (part.imu.back().t > end) part.imu.pop_back();
  return part;
}

std::string calibration_file(const std::string& folder) {
  Text<kCalibrationTextMax> text;
  write_calibration(clip()->calibration, text);
  const std::string path = folder + "/clip.cfg";
  std::ofstream(path) << text.c_str();
  return path;
}

}  // namespace pirvs::systems
