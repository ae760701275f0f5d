// Recordings that cannot tell a calibration are refused by name, odd ones warned of.
#include <gtest/gtest.h>

#include <cmath>

#include "tools/calib/device_calibration.h"
#include "tools/calib/simulated_device.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

SimulatedRecording short_recording() {
  SimulatedRecording out;
  out.duration_s = 15, out.frames_hz = 12;
  return out;
}

DeviceRecording record(const SimulatedRecording& how) {
  SimulatedDevice device(4);
  DeviceRecording out;
  out.target = device.target;
  out.how.model = CameraModel::kKannalaBrandt;
  out.how.size = {device.rig.camera[0].width, device.rig.camera[0].height};
  out.shots = device.shots(how);
  out.imu = device.samples(how);
  out.motion.noise = device.noise;
  return out;
}

const DeviceRecording& good() {
  static const DeviceRecording recording = record(short_recording());
  return recording;
}

std::string refusal(const DeviceRecording& recording) {
  try {
    (void)calibrate_device(recording, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "not refused";
}

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

bool warns(const std::vector<std::string>& warnings, const char* part) {
  return std::any_of(warnings.begin(), warnings.end(),
                     [part](const std::string& warning) { return has(warning, part); });
}

// Every part-th of `of` shots is kept.
DeviceRecording thinned(size_t kept, size_t of) {
  DeviceRecording out = good();
  out.shots.clear();
  for (size_t i = 0; i < good().shots.size(); ++i) {
    if (i % of < kept) out.shots.push_back(good().shots[i]);
  }
  return out;
}

TEST(bad_recordings, a_good_one_passes_without_a_warning) {
  const DeviceResult result = calibrate_device(good(), {});
  for (const DeviceCheck& check : result.checks) {
    EXPECT_TRUE(check.passed()) << check.what << " " << check.value;
  }
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
  EXPECT_TRUE(result.passed());
  EXPECT_FALSE((DeviceCheck{"a number that is none", "", NAN, 1}.passed()));
}

TEST(bad_recordings, no_board) {
  DeviceRecording empty = good();
  empty.shots.clear();
  EXPECT_TRUE(has(refusal(empty), "never in view"));
}

TEST(bad_recordings, no_rim) {
  DeviceRecording middle = good();
  for (Shot& shot : middle.shots) {
    for (View& view : shot.view) {
      std::vector<SeenTag> kept;
      for (const SeenTag& tag : view.tags) {
        if (tag.uv.x() > 140) kept.push_back(tag);
      }
      view.tags = kept;
    }
  }
  EXPECT_TRUE(has(refusal(middle), "never at the left rim of cam")) << refusal(middle);
}

TEST(bad_recordings, no_rotation) {
  SimulatedRecording how = short_recording();
  how.turning = 0.05;
  const std::string text = refusal(record(how));
  EXPECT_TRUE(has(text, "never turned about its line of sight") || has(text, "straight ahead"))
      << text;
}

TEST(bad_recordings, blurred) {
  SimulatedRecording how = short_recording();
  how.tag_px = 0.9;
  EXPECT_TRUE(has(refusal(record(how)), "blurred")) << refusal(record(how));
}

TEST(bad_recordings, two_boards) {
  DeviceRecording doubled = good();
  doubled.tags_twice = 4000;
  EXPECT_TRUE(has(refusal(doubled), "in the image twice"));
  doubled.tags_twice = 10;
  EXPECT_TRUE(warns(tidy(doubled), "a reflection"));
}

TEST(bad_recordings, wrong_tag_size) {
  DeviceRecording smaller = good();
  smaller.target.tag_m *= 0.9;
  EXPECT_TRUE(has(refusal(smaller), "of the size that its yaml says")) << refusal(smaller);
}

TEST(bad_recordings, units) {
  DeviceRecording in_g = good(), degrees = good();
  for (ImuSample& sample : in_g.imu) sample.f_B /= 9.81;
  EXPECT_TRUE(has(refusal(in_g), "seems to be in g")) << refusal(in_g);
  for (ImuSample& sample : degrees.imu) sample.w_B *= 180 / M_PI;
  EXPECT_TRUE(has(refusal(degrees), "degrees per second")) << refusal(degrees);
}

TEST(bad_recordings, an_offset_of_80_ms_is_found_and_warned_of) {
  DeviceRecording late = good();
  const double offset_s = SimulatedDevice(4).offset_s;
  for (ImuSample& sample : late.imu) sample.t += from_seconds(0.08 - offset_s);
  const DeviceResult result = calibrate_device(late, {});
  EXPECT_TRUE(result.passed());
  EXPECT_NEAR(result.imu.camera[0].offset_s, 0.08, 5e-5);
  EXPECT_TRUE(warns(result.warnings, "80 ms off the IMU's clock"));
  for (ImuSample& sample : late.imu) sample.t += 400'000'000;
  EXPECT_TRUE(has(refusal(late), "clocks") || has(refusal(late), "turns are not those"))
      << refusal(late);
}

TEST(bad_recordings, dropped_frames) {
  EXPECT_TRUE(has(refusal(thinned(5, 9)), "of the frames are missing")) << refusal(thinned(5, 9));
  DeviceRecording some = thinned(9, 10);
  EXPECT_TRUE(warns(tidy(some), "10 % of the frames are missing"));
}

TEST(bad_recordings, eight_minutes_too_long) {
  DeviceRecording recording = good();
  recording.shots.clear();
  for (TimeNs t = 0; t <= 570; ++t) recording.shots.push_back({t * 1'000'000'000, {}});
  EXPECT_TRUE(warns(tidy(recording), "570 s long: its first 180 s are used"));
  EXPECT_EQ(recording.shots.size(), 181u);
  // Images after the 180th second are not even looked at.
  recording.left_out_s = 390;
  EXPECT_TRUE(warns(tidy(recording), "570 s long"));
}

// Samples that are no numbers end in a name, not in a calibration.
TEST(bad_recordings, numbers_that_are_none) {
  DeviceRecording broken = good();
  for (size_t i = 0; i < broken.imu.size(); i += 7) broken.imu[i].w_B.x() = NAN;
  try {
    EXPECT_FALSE(calibrate_device(broken, {}).passed());
  } catch (const InputError& error) {
    EXPECT_FALSE(std::string(error.what()).empty());
  }
}

}  // namespace
}  // namespace pirvs::tools
