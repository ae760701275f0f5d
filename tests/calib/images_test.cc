// From pixels to files: `pirvs calib device` as a whole, on drawn recordings and a real pair.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/math/so3.h"
#include "tests/recordings.h"
#include "tools/calib/board_images.h"
#include "tools/calib/board_pose.h"
#include "tools/calib/board_recording.h"
#include "tools/calib/calib_command.h"
#include "tools/calib/tag_detector.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

// One real pair of images of EuRoC's board, against the published lens: corners of each image at
// the pose that fits them best.
TEST(calibration, corners_of_a_real_pair_are_those_of_a_board) {
  const char* const at = std::getenv("PIRVS_DATA");
  const std::string data = at != nullptr ? at : "../shared/data";
  const std::string stamp = "_1403709395937837056.png";
  if (!std::filesystem::exists(data + "/april_euroc/cam0" + stamp)) {
    GTEST_SKIP() << "the images of the board are not on this machine";
  }
  const Target target = read_target(data + "/april_euroc/target.yaml");
  InputLog log;
  const Rig rig = read_asl_rig(data + "/euroc_mh01_clip/mav0", {}, log);
  TagDetector detector(target);
  for (int c = 0; c < 2; ++c) {
    const std::string path = data + "/april_euroc/cam" + std::to_string(c) + stamp;
    TagDetector::Dropped dropped;
    std::vector<Corner> corners = detector.find(cv::imread(path, cv::IMREAD_GRAYSCALE), dropped);
    EXPECT_GE(corners.size(), 4u * 34);
    const std::vector<Corner> seen = corners;
    TagCounts counts;
    const View view = whole_tags(0, corners, counts);
    const Camera& camera = rig.calibration.camera[c];
    BoardPose pose;
    ASSERT_TRUE(find_pose(camera, target, view, pose));
    double squares = 0;
    for (const Corner& corner : seen) {
      Vec2 uv;
      ASSERT_TRUE(camera.project(pose.T_CT * target.p_T(corner.id), uv));
      squares += (uv - corner.uv).squaredNorm();
    }
    const double rms_px = std::sqrt(squares / double(2 * seen.size()));
    std::printf("cam%d: %zu tags, corners %.3f px an axis, tags %.3f px\n", c, view.tags.size(),
                rms_px, pose.rms_px);
    EXPECT_LT(rms_px, 0.2);
    EXPECT_LT(pose.rms_px, 0.15);
  }
}

int run(const Command& command, const std::vector<std::string>& words) {
  CLI::App app;
  const std::function<int()> run = command.declare(app);
  std::vector<std::string> reversed(words.rbegin(), words.rend());
  app.parse(reversed);
  return run();
}

std::string refusal(const std::string& folder) {
  try {
    (void)run(kCalibDeviceCommand,
              {folder, "--target", folder + "/target.yaml", "--out", folder + "/out"});
  } catch (const InputError& error) {
    return error.what();
  }
  return "not refused";
}

DrawnRecording short_recording(double duration_s) {
  DrawnRecording out;
  out.motion.duration_s = duration_s;
  out.motion.frames_hz = 8;
  return out;
}

TEST(calibration, a_device_is_calibrated_from_images) {
  SimulatedDevice device(7);
  const std::string folder = systems::scratch_folder("board"), out = folder + "/out";
  write_board_recording(device, short_recording(12), folder);
  const std::vector<std::string> words = {
      folder, "--target", folder + "/target.yaml", "--serial", "0042", "--model", "equidistant"};
  std::vector<std::string> good = words;
  good.insert(good.end(), {"--out", out});
  EXPECT_EQ(run(kCalibDeviceCommand, good), kExitDone);
  InputLog log;
  const Calibration found = read_rig(out + "/calibration.cfg", {}, log).calibration;
  for (int c = 0; c < 2; ++c) {
    const Camera &is = found.camera[c], &was = device.rig.camera[c];
    EXPECT_NEAR(is.fx / was.fx, 1, 1e-3);
    EXPECT_NEAR(is.cx, was.cx, 0.3);
    EXPECT_NEAR(is.cy, was.cy, 0.3);
    EXPECT_LT(so3_log(was.T_BC.R.transpose() * is.T_BC.R).norm(), 0.03 * M_PI / 180);
    EXPECT_LT((is.T_BC.p - was.T_BC.p).norm(), 1e-3);
  }
  EXPECT_NEAR(to_seconds(found.camera_time_offset_ns), device.offset_s, 5e-5);
  EXPECT_NEAR((found.camera[0].T_BC.p - found.camera[1].T_BC.p).norm(), device.rig.T_C1C0.p.norm(),
              1e-4);
  for (const char* file : {"calibration.html", "calibration.json", "camchain-imucam.yaml",
                           "imu.yaml", "mav0/cam1/sensor.yaml", "mav0/imu0/sensor.yaml"}) {
    EXPECT_TRUE(fs::exists(out + "/" + file)) << file;
  }
  const std::string asl = out + "/mav0";
  EXPECT_NEAR(read_asl_rig(asl, {}, log).calibration.camera[1].fx, found.camera[1].fx, 1e-6);

  // An IMU thirty times as noisy as its data sheet fails, and leaves no calibration.
  std::ofstream noise(folder + "/noise.yaml");
  noise << "gyroscope_noise_density: 5e-6\ngyroscope_random_walk: 1e-6\n"
           "accelerometer_noise_density: 6e-5\naccelerometer_random_walk: 1e-5\nupdate_rate: 200\n";
  noise.close();
  std::vector<std::string> bad = words;
  bad.insert(bad.end(), {"--noise", folder + "/noise.yaml", "--out", folder + "/bad"});
  EXPECT_EQ(run(kCalibDeviceCommand, bad), kExitFailed);
  EXPECT_FALSE(fs::exists(folder + "/bad/calibration.cfg"));
  EXPECT_FALSE(fs::exists(folder + "/bad/mav0"));
  std::ifstream json(folder + "/bad/calibration.json");
  EXPECT_FALSE(nlohmann::json::parse(json)["passed"].get<bool>());
}

TEST(calibration, bad_images_are_refused_by_name) {
  SimulatedDevice device(7);
  const std::string folder = systems::scratch_folder("bad_board");
  DrawnRecording smeared = short_recording(4);
  smeared.exposure_s = 0.06;
  write_board_recording(device, smeared, folder);
  EXPECT_NE(refusal(folder).find("blurred"), std::string::npos) << refusal(folder);

  DrawnRecording two = short_recording(4);
  two.second_board = 0.3;
  write_board_recording(device, two, systems::scratch_folder("bad_board"));
  EXPECT_NE(refusal(folder).find("in the image twice"), std::string::npos) << refusal(folder);

  DrawnRecording dark = short_recording(1);
  dark.light.white = 6, dark.light.black = 4;
  write_board_recording(device, dark, systems::scratch_folder("bad_board"));
  EXPECT_NE(refusal(folder).find("dark"), std::string::npos) << refusal(folder);
}

}  // namespace
}  // namespace pirvs::tools
