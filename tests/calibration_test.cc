// Factory calibration as a whole.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "core/math/so3.h"
#include "tools/calib/board_pose.h"
#include "tools/calib/imu_camera.h"
#include "tools/calib/tag_detector.h"
#include "tools/calib/test_device.h"
#include "tools/dataset/calibration_file.h"

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
  out.result =
      calibrate_imu_camera(out.cameras.target, out.cameras.rig, out.cameras.adjustment.sigma_px,
                           out.cameras.all, device.samples(how), motion);
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

}  // namespace
}  // namespace pirvs::tools
