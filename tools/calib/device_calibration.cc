#include "tools/calib/device_calibration.h"

#include <algorithm>
#include <cmath>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

// Of all tags: those of a second board that are seen alone are taken for ours.
constexpr double kTwice = 0.03;
constexpr double kBlurred_px = 0.5;  // noise of a tag
constexpr double kOffsetOdd_s = 0.05;
constexpr double kHoles = 0.02, kHoles_max = 0.3;  // of the frames

std::string percent(double share) { return std::to_string(int(std::lround(100 * share))) + " %"; }

void cut(DeviceRecording& in, std::vector<std::string>& warnings) {
  const TimeNs begin = in.shots.front().t;
  const double all_s = to_seconds(in.shots.back().t - begin) + in.left_out_s;
  if (all_s <= kRecording_s_max) return;
  warnings.push_back("the recording is " + std::to_string(int(all_s)) + " s long: its first " +
                     std::to_string(int(kRecording_s_max)) + " s are used, 90 s would do");
  const TimeNs end = begin + from_seconds(kRecording_s_max);
  in.shots.erase(std::find_if(in.shots.begin(), in.shots.end(),
                              [&](const Shot& shot) { return shot.t > end; }),
                 in.shots.end());
}

// Frames that are missing between those that show the board.
void look_for_holes(const DeviceRecording& in, std::vector<std::string>& warnings) {
  std::vector<TimeNs> steps;
  for (size_t i = 1; i < in.shots.size(); ++i) steps.push_back(in.shots[i].t - in.shots[i - 1].t);
  if (steps.size() < 10) return;
  std::vector<TimeNs> sorted = steps;
  std::sort(sorted.begin(), sorted.end());
  const double usual = double(sorted[sorted.size() / 2]);
  double missing = 0;
  constexpr double kAway_s = 1;  // the board was not in view, which is no fault of the recording
  for (const TimeNs step : steps) {
    if (to_seconds(step) < kAway_s) missing += std::max(0.0, std::round(double(step) / usual) - 1);
  }
  const double share = missing / (missing + double(steps.size()));
  if (share > kHoles_max) {
    throw InputError(percent(share) + " of the frames are missing", "the recording",
                     "record to a faster disk, or fewer frames a second");
  }
  if (share > kHoles) warnings.push_back(percent(share) + " of the frames are missing");
}

void look_for_a_second_board(const DeviceRecording& in, std::vector<std::string>& warnings) {
  size_t tags = 0;
  for (const Shot& shot : in.shots) tags += shot.view[0].tags.size() + shot.view[1].tags.size();
  const double share = double(in.tags_twice) / double(std::max<size_t>(1, tags + in.tags_twice));
  if (share > kTwice) {
    throw InputError(percent(share) + " of the tags are in the image twice", "the recording",
                     "leave one board in view, and no mirror");
  }
  if (in.tags_twice > 0) warnings.push_back("some tags were in the image twice: a reflection?");
}

void check_cameras(const CameraResult& r, const DeviceLimits& limits,
                   std::vector<DeviceCheck>& checks) {
  const Eigen::VectorXd sigma = r.adjustment.covariance.diagonal().cwiseSqrt();
  for (int c = 0; c < r.rig.cameras; ++c) {
    const std::string name = "cam" + std::to_string(c);
    checks.push_back(
        {name + ": a tag, on shots left out", "px", r.held_out.within_px[c], limits.within_px});
    checks.push_back({name + ": sigma of the focal length", "%",
                      100 * sigma[8 * c] / r.rig.camera[c].fx, limits.focal_percent});
    checks.push_back({name + ": sigma of the principal point", "px",
                      std::max(sigma[8 * c + 2], sigma[8 * c + 3]), limits.centre_px});
  }
  if (r.rig.cameras < 2) return;
  checks.push_back(
      {"a tag across cameras, on shots left out", "px", r.held_out.across_px, limits.across_px});
}

void check_imu(const ImuCameraResult& r, bool intrinsics, const DeviceLimits& limits,
               std::vector<DeviceCheck>& checks) {
  for (int c = 0; c < r.rig.cameras; ++c) {
    const std::string name = "cam" + std::to_string(c);
    const auto& sigma = r.camera[c].sigma;
    checks.push_back({name + ": sigma of its rotation", "degrees",
                      180 / M_PI * sigma.head<3>().maxCoeff(), limits.rotation_deg});
    checks.push_back({name + ": sigma of its place", "mm", 1e3 * sigma.segment<3>(3).maxCoeff(),
                      limits.place_mm});
    checks.push_back({name + ": sigma of its time offset", "ms", 1e3 * sigma[6], limits.offset_ms});
  }
  if (r.rig.cameras == 2) {
    checks.push_back({"sigma of the baseline", "mm", 1e3 * r.baseline_sigma_m, limits.baseline_mm});
  }
  if (intrinsics) {
    checks.push_back({"sigma of the gyro's scale", "%", 100 * r.gyro_sigma.diagonal().maxCoeff(),
                      limits.gyro_scale_percent});
    checks.push_back({"sigma of the accelerometer's scale", "%",
                      100 * r.accel_sigma.diagonal().maxCoeff(), limits.accel_scale_percent});
  }
  checks.push_back({"the gyro's noise over its density", "", r.gyro_excess, limits.gyro_excess});
  checks.push_back(
      {"the accelerometer's noise over its density", "", r.accel_excess, limits.accel_excess});
  checks.push_back({"values that the motion did not tell", "", double(r.unexcited.size()), 0});
}

}  // namespace

bool DeviceResult::passed() const {
  return std::all_of(checks.begin(), checks.end(),
                     [](const DeviceCheck& check) { return check.passed(); });
}

std::vector<std::string> tidy(DeviceRecording& in) {
  if (in.shots.empty()) {
    throw InputError("the board is never in view", "the recording", "record it for a minute");
  }
  std::vector<std::string> warnings;
  cut(in, warnings);
  look_for_holes(in, warnings);
  look_for_a_second_board(in, warnings);
  return warnings;
}

DeviceResult calibrate_device(DeviceRecording in, const DeviceLimits& limits) {
  DeviceResult out;
  out.warnings = tidy(in);
  out.cameras = calibrate_cameras(in.target, in.shots, in.cameras, in.how);
  if (out.cameras.adjustment.sigma_px > kBlurred_px) {
    throw InputError("the images are blurred, or the board bends: its tags scatter by " +
                         std::to_string(out.cameras.adjustment.sigma_px).substr(0, 4) + " px",
                     "the recording", "more light and shorter exposure, a flat and stiff board");
  }
  out.imu = calibrate_imu_camera(out.cameras, in.imu, in.motion);
  for (int c = 0; c < in.cameras; ++c) {
    if (std::abs(out.imu.camera[c].offset_s) < kOffsetOdd_s) continue;
    out.warnings.push_back("cam" + std::to_string(c) + " is " +
                           std::to_string(int(std::lround(1e3 * out.imu.camera[c].offset_s))) +
                           " ms off the IMU's clock: are stamps taken at arrival?");
  }
  check_cameras(out.cameras, limits, out.checks);
  check_imu(out.imu, in.motion.imu_intrinsics, limits, out.checks);
  return out;
}

}  // namespace pirvs::tools
