#include "tests/logs/clip_part.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

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

void expect_same_trajectory(const std::string& got, const std::string& wanted) {
  std::istringstream have(got), want(wanted);
  size_t count = 0;
  for (double x = 0, y = 0; want >> y; ++count) {
    ASSERT_TRUE(have >> x) << count;
    ASSERT_NEAR(x, y, 1e-8) << count;
  }
  std::string rest;
  EXPECT_FALSE(have >> rest) << rest;
  EXPECT_GT(count, 400u);
}

}  // namespace pirvs::systems
