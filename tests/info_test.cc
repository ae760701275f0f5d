// What `pirvs info` finds by images: nothing in a good recording, and each fault that is put in.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/recordings.h"
#include "tools/info/image_turn.h"
#include "tools/info/imu_sense.h"
#include "tools/info/stereo_sense.h"

namespace pirvs::systems {
namespace {

std::string found(const tools::Recording& recording) {
  std::string out;
  const tools::ImuFault imu = tools::find_imu_fault(recording.imu);
  if (!imu.what.empty()) out += imu.what + ": " + imu.what_to_do + "\n";
  const tools::ImageTurn turn = tools::compare_turns(recording);
  const tools::StereoSense stereo = tools::compare_cameras(recording);
  std::printf(
      "turn: agreement %.3f, late %+.1f ms, off %.1f, inverse %.1f, scale %.3f; pair: %zu "
      "matches, %.2f px, %.2f in front\n",
      turn.agreement, 1e3 * turn.late_s, turn.off_deg, turn.inverse_off_deg, turn.gyro_scale,
      stereo.matches, stereo.epipolar_px, stereo.in_front);
  for (const std::string& fault : faults_of(turn)) out += fault + "\n";
  for (const std::string& fault : faults_of(stereo)) out += fault + "\n";
  return out;
}

void expect_says(const tools::Recording& recording, const char* part) {
  const std::string text = found(recording);
  EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST(info, finds_nothing_in_good_recordings) {
  EXPECT_EQ(found(simulated(SimulatedDevice::kEuroc)), "");
  EXPECT_EQ(found(simulated(SimulatedDevice::kIronsides)), "");
  if (clip() != nullptr) {
    EXPECT_EQ(found(*clip()), "");
  }
}

TEST(info, names_the_fault) {
  const tools::Recording& good = simulated(SimulatedDevice::kEuroc);
  for (const int late_ms : {20, -40}) {
    if (clip() == nullptr) break;  // it turns enough to tell
    tools::Recording late = *clip();
    for (tools::FrameFiles& frame : late.frames) frame.t += late_ms * TimeNs{1'000'000};
    expect_says(late, late_ms > 0 ? " ms late: --set-offset 0.0" : " ms early: --set-offset -0.0");
  }
  tools::Recording in_g = good;
  for (ImuSample& sample : in_g.imu) sample.f_B /= 9.80665;
  expect_says(in_g, "not g");
  tools::Recording inverted = good;
  for (Camera& camera : inverted.calibration.camera) camera.T_BC = camera.T_BC.inverse();
  expect_says(inverted, "invert T_BS");
  tools::Recording swapped = good;
  for (tools::FrameFiles& frame : swapped.frames) std::swap(frame.image[0], frame.image[1]);
  expect_says(swapped, "off the epipolar curve");
  tools::Recording mirrored = good;
  Camera& right = mirrored.calibration.camera[1];
  const Camera& left = mirrored.calibration.camera[0];
  right.T_BC.p = left.T_BC.p - (right.T_BC.p - left.T_BC.p);
  expect_says(mirrored, "behind the cameras");
  tools::Recording lens = good;  // a pinhole's numbers taken for a fisheye of another focal length
  for (Camera& camera : lens.calibration.camera) {
    camera.model = CameraModel::kKannalaBrandt;
    camera.fx *= 1.3;
    camera.fy *= 1.3;
  }
  expect_says(lens, "lens model");
}

}  // namespace
}  // namespace pirvs::systems
