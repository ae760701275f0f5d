#include "tools/calib/coverage.h"

#include <gtest/gtest.h>

#include "tools/calib/simulated_device.h"

namespace pirvs::tools {
namespace {

// The truth's poses: this is about what was shown, not about finding it.
std::vector<PosedShot> shots_of(SimulatedDevice& device, const SimulatedRecording& how) {
  std::vector<PosedShot> out;
  for (const Shot& shot : device.shots(how)) {
    out.push_back({shot, device.pose(how, shot.t)});
  }
  return out;
}

Coverage coverage_of(const SimulatedRecording& how) {
  SimulatedDevice device(3);
  return measure(device.target, device.rig, shots_of(device, how));
}

SimulatedRecording short_recording() {
  SimulatedRecording how;
  how.duration_s = 30;
  how.frames_hz = 4;
  return how;
}

TEST(coverage, of_a_good_recording_lacks_nothing) {
  const Coverage coverage = coverage_of(short_recording());
  EXPECT_EQ(missing(coverage, 2).what, "");
  EXPECT_NE(picture(coverage, 0).find('#'), std::string::npos);
}

TEST(coverage, names_what_is_missing) {
  SimulatedRecording how = short_recording();
  how.turning = 0.05;
  EXPECT_NE(missing(coverage_of(how), 2).what.find("about its line of sight"), std::string::npos)
      << missing(coverage_of(how), 2).what;
  how = short_recording();
  how.roll = 0.02;
  EXPECT_NE(missing(coverage_of(how), 2).what.find("about its line of sight"), std::string::npos);
  how = short_recording();
  how.moving = 0;
  EXPECT_NE(missing(coverage_of(how), 2).what.find("straight ahead"), std::string::npos)
      << missing(coverage_of(how), 2).what;
}

TEST(coverage, a_bare_rim_is_named_with_its_side) {
  SimulatedDevice device(3);
  std::vector<PosedShot> shots = shots_of(device, short_recording());
  for (PosedShot& shot : shots) {
    std::vector<SeenTag> kept;
    for (const SeenTag& tag : shot.shot.view[1].tags) {
      if (tag.uv.x() < 500) kept.push_back(tag);
    }
    shot.shot.view[1].tags = kept;
  }
  EXPECT_EQ(missing(measure(device.target, device.rig, shots), 2).what,
            "the board was never at the right rim of cam1");
}

}  // namespace
}  // namespace pirvs::tools
