// Factory calibration as a whole.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "core/math/so3.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/calib/board_images.h"
#include "tools/calib/board_pose.h"
#include "tools/calib/device_calibration.h"
#include "tools/calib/flight_check.h"
#include "tools/calib/imu_camera.h"
#include "tools/calib/tag_detector.h"
#include "tools/calib/test_board.h"
#include "tools/calib/test_device.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr double kDegrees = 180 / M_PI;

std::string shared_data() {
  const char* const at = std::getenv("PIRVS_DATA");
  return at != nullptr ? at : "../shared/data";
}

struct Found {
  CameraResult cameras;
  ImuCameraResult result;
};

Found calibrate(TestDevice& device, const TestRecording& how) {
  CameraOptions options;
  options.model = CameraModel::kKannalaBrandt;
  options.size = {device.rig.camera[0].width, device.rig.camera[0].height};
  Found out;
  const std::vector<Shot> shots = device.shots(how);
  out.cameras = calibrate_cameras(device.target, shots, 2, options);
  ImuCameraOptions motion;
  motion.noise = device.noise;
  out.result = calibrate_imu_camera(out.cameras, device.samples(how), motion);
  return out;
}

// Sum of squares of errors over sigmas, and how many; prints what is worst.
struct Nees {
  double squares = 0;
  int count = 0;
  double worst = 0;
  void add(double error, double sigma) {
    const double e = std::abs(error) / sigma;
    squares += e * e;
    ++count;
    worst = std::max(worst, e);
  }
};

void expect_truth(const TestDevice& device, const Found& found) {
  const ImuCameraResult& r = found.result;
  Nees nees;
  double focal = 0, centre = 0, rotation = 0, place = 0, time = 0;
  for (int c = 0; c < 2; ++c) {
    const Camera &is = r.rig.camera[c], &was = device.rig.camera[c];
    focal = std::max({focal, std::abs(is.fx / was.fx - 1), std::abs(is.fy / was.fy - 1)});
    centre = std::max({centre, std::abs(is.cx - was.cx), std::abs(is.cy - was.cy)});
    const Vec3 theta = so3_log(was.T_BC.R.transpose() * r.camera[c].T_BC.R);
    const Vec3 p = r.camera[c].T_BC.p - was.T_BC.p;
    rotation = std::max(rotation, kDegrees * theta.norm());
    place = std::max(place, 1e3 * p.norm());
    const double offset = r.camera[c].offset_s - device.offset_s;
    time = std::max(time, 1e3 * std::abs(offset));
    for (int i = 0; i < 3; ++i) {
      nees.add(theta[i], r.camera[c].sigma[i]);
      nees.add(p[i], r.camera[c].sigma[3 + i]);
    }
    nees.add(offset, r.camera[c].sigma[6]);
    const LensVector lens = lens_of(is) - lens_of(was);
    for (int i = 0; i < 4; ++i) nees.add(lens[i], r.camera[c].lens_sigma[i]);
  }
  const double baseline = 1e3 * std::abs(r.baseline_m - device.rig.T_C1C0.p.norm());
  double gyro = 0, accel = 0;
  for (int i = 0; i < 3; ++i) {
    gyro = std::max(gyro, std::abs(r.gyro(i, i) - device.gyro(i, i)));
    accel = std::max(accel, std::abs(r.accel(i, i) - device.accel(i, i)));
    for (int j = 0; j < 3; ++j) {
      nees.add(r.gyro(i, j) - device.gyro(i, j), r.gyro_sigma(i, j));
      if (j <= i) nees.add(r.accel(i, j) - device.accel(i, j), r.accel_sigma(i, j));
    }
  }
  std::printf(
      "focal %.4f %%, centre %.3f px, baseline %.3f mm, rotation %.4f deg, place %.2f mm, time "
      "%.4f ms, gyro %.4f %%, accelerometer %.4f %%, NEES %.2f, worst %.1f sigma\n"
      "tags %.3f px within, %.3f px across\n",
      100 * focal, centre, baseline, rotation, place, time, 100 * gyro, 100 * accel,
      nees.squares / nees.count, nees.worst, found.cameras.held_out.within_px[0],
      found.cameras.held_out.across_px);
  EXPECT_LT(found.cameras.held_out.within_px[0], 0.2);
  EXPECT_LT(found.cameras.held_out.across_px, 0.3);
  EXPECT_LT(focal, 1e-3);
  EXPECT_LT(centre, 0.3);
  EXPECT_LT(baseline, 0.1);
  EXPECT_LT(rotation, 0.03);
  EXPECT_LT(place, 1);
  EXPECT_LT(time, 0.05);
  EXPECT_LT(gyro, 1e-3);
  EXPECT_LT(accel, 2e-3);
  EXPECT_LT(nees.worst, 4.5);
  EXPECT_LT(nees.squares / nees.count, 2.5);
  EXPECT_GT(nees.squares / nees.count, 0.3);
}

// PIRVS_CALIB_DEVICES=20 for the long run.
TEST(calibration, devices_by_seed_are_found) {
  const char* const more = std::getenv("PIRVS_CALIB_DEVICES");
  const int devices = more != nullptr ? std::atoi(more) : 1;
  TestRecording how;
  how.duration_s = more != nullptr ? 45 : 15;
  how.frames_hz = more != nullptr ? 30 : 12;
  for (int seed = 1; seed <= devices; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    TestDevice device(static_cast<uint64_t>(seed));
    expect_truth(device, calibrate(device, how));
  }
}

// One real pair of images of EuRoC's board, against the published lens: corners of each image at
// the pose that fits them best.
TEST(calibration, corners_of_a_real_pair_are_those_of_a_board) {
  const std::string data = shared_data();
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

// The clip with the calibration in question.
FlightVerdict check_clip(const std::function<void(Calibration&)>& bump) {
  static const std::vector<FlightLook> looks = follow(*systems::clip());
  Calibration calibration = systems::clip()->calibration;
  bump(calibration);
  const FlightVerdict out = judge(looks, systems::clip()->imu, calibration);
  std::printf("%zu looks, %zu points, %.2f px\n", out.looks, out.points, out.residual_px);
  for (const FlightFinding& f : out.findings) {
    std::printf("  %-42s %8.3f +- %.3f %s%s\n", f.what.c_str(), f.value, f.sigma, f.unit.c_str(),
                f.bumped() ? "  BUMPED" : "");
  }
  return out;
}

TEST(calibration, a_bump_is_seen_in_any_flight) {
  if (systems::clip() == nullptr) GTEST_SKIP() << "the real recording is not on this machine";
  constexpr double kBump_rad = 0.3 * M_PI / 180;
  EXPECT_FALSE(check_clip([](Calibration&) {}).bumped());
  for (int axis = 0; axis < 3; ++axis) {
    const Mat3 turn = so3_exp(kBump_rad * Vec3::Unit(axis));
    EXPECT_TRUE(check_clip([&](Calibration& c) {
                  c.camera[1].T_BC.R = c.camera[1].T_BC.R * turn;
                }).bumped())
        << "right camera, " << axis;
    EXPECT_TRUE(check_clip([&](Calibration& c) {
                  for (Camera& camera : c.camera)
                    camera.T_BC = SE3{turn, Vec3::Zero()} * camera.T_BC;
                }).bumped())
        << "both, " << axis;
  }
  EXPECT_TRUE(check_clip([](Calibration& c) {
                for (Camera& camera : c.camera) camera.fx *= 1.01, camera.fy *= 1.01;
              }).bumped());
  EXPECT_TRUE(check_clip([](Calibration& c) { c.camera_time_offset_ns += 5'000'000; }).bumped());
}

// What was found is taken out at the door: a flight whose IMU has scale, misalignment and bias.
TEST(calibration, the_stack_takes_the_imus_errors_out) {
  const Recording& ideal = systems::simulated(systems::SimulatedDevice::kIronsides);
  Recording crooked = ideal;
  ImuIntrinsics& found = crooked.calibration.imu_intrinsics;
  found.gyro << 1.01, 0.004, -0.005, 0.003, 0.992, 0.006, -0.004, 0.005, 1.008;
  found.accel << 0.99, 0, 0, 0.006, 1.009, 0, -0.007, 0.005, 1.01;
  found.b_g = Vec3(0.02, -0.03, 0.01);
  found.b_a = Vec3(0.2, -0.1, 0.3);
  for (ImuSample& sample : crooked.imu) {
    sample.w_B = found.gyro * sample.w_B + found.b_g;
    sample.f_B = found.accel * sample.f_B + found.b_a;
  }
  Recording unknown = crooked;
  unknown.calibration.imu_intrinsics = {};
  const systems::Replay was = systems::replay(ideal), with = systems::replay(crooked),
                        without = systems::replay(unknown);
  systems::print("ideal IMU", was);
  systems::print("errors known", with);
  systems::print("errors unknown", without);
  EXPECT_LT(with.result.evaluation.ate_rmse_m, 1.1 * was.result.evaluation.ate_rmse_m);
  EXPECT_GT(without.result.evaluation.ate_rmse_m, 1.5 * was.result.evaluation.ate_rmse_m);
}

// One recording in, pass or fail out; what would fail by name.
TEST(calibration, a_device_passes_or_is_refused_by_name) {
  TestDevice device(4);
  TestRecording how;
  how.duration_s = 15, how.frames_hz = 12;
  DeviceRecording in;
  in.target = device.target;
  in.how.model = CameraModel::kKannalaBrandt;
  in.how.size = {device.rig.camera[0].width, device.rig.camera[0].height};
  in.shots = device.shots(how);
  in.imu = device.samples(how);
  in.motion.noise = device.noise;
  const auto refusal = [](const DeviceRecording& recording) -> std::string {
    try {
      (void)calibrate_device(recording, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  DeviceRecording doubled = in, holes = in, empty = in;
  doubled.tags_twice = 4000;
  EXPECT_TRUE(has(refusal(doubled), "in the image twice"));
  std::vector<Shot> left;
  for (size_t i = 0; i < holes.shots.size(); ++i) {
    if (i % 9 < 5) left.push_back(in.shots[i]);
  }
  holes.shots = left;
  EXPECT_TRUE(has(refusal(holes), "frames are missing"));
  empty.shots.clear();
  EXPECT_TRUE(has(refusal(empty), "never in view"));

  const DeviceResult result = calibrate_device(in, {});
  for (const DeviceCheck& check : result.checks) {
    EXPECT_TRUE(check.passed()) << check.what << " " << check.value;
  }
  EXPECT_TRUE(result.warnings.empty());
  EXPECT_FALSE((DeviceCheck{"a number that is none", "", NAN, 1}.passed()));
}

// From pixels to files: images drawn along a hand's motion, found again. Long.
TEST(calibration, a_device_is_calibrated_from_images) {
  if (std::getenv("PIRVS_CALIB_DEVICES") == nullptr) {
    GTEST_SKIP() << "set PIRVS_CALIB_DEVICES: it draws some 200 images";
  }
  TestDevice device(7);
  TestRecording how;
  how.duration_s = 13, how.frames_hz = 8;
  const std::string folder = systems::scratch_folder("board");
  const TestBoard board(device.target);
  uint64_t seed = 0;
  for (const Shot& shot : device.shots(how)) {
    const SE3 T_C0T = device.pose(how, shot.t);
    for (int c = 0; c < 2; ++c) {
      const std::string data = folder + "/mav0/cam" + std::to_string(c) + "/data";
      std::filesystem::create_directories(data);
      const SE3 T_CT = c == 0 ? T_C0T : device.rig.T_C1C0 * T_C0T;
      cv::imwrite(data + "/" + std::to_string(shot.t) + ".pgm",
                  board.draw(device.rig.camera[c], T_CT, {}, ++seed));
    }
  }
  InputLog log;
  BoardImages found = find_boards(folder, device.target, 20, log);
  std::vector<View> views[2];
  for (int c = 0; c < 2; ++c) {
    TagCounts counts;
    for (ImageCorners& image : found.images[c]) {
      views[c].push_back(whole_tags(image.t, image.corners, counts));
    }
  }
  CameraOptions options;
  options.model = CameraModel::kKannalaBrandt;
  options.size = found.size;
  Found out;
  out.cameras = calibrate_cameras(device.target, pair_views(views[0], views[1]), 2, options);
  ImuCameraOptions motion;
  motion.noise = device.noise;
  out.result = calibrate_imu_camera(out.cameras, device.samples(how), motion);
  expect_truth(device, out);
}

}  // namespace
}  // namespace pirvs::tools
