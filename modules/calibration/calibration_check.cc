#include "modules/calibration/calibration_check.h"

#include <Eigen/LU>
#include <cmath>

#include "core/base/limits.h"

namespace pirvs {
namespace {

constexpr double kRotation = 1e-6;
constexpr double kLever_m_max = 5.0;
constexpr double kAntenna_m_max = 50.0, kVehicle_m_max = 20.0;
constexpr double kFocal_min = 0.05, kFocal_max = 20.0;  // of the image's width
constexpr double kAspect_max = 2.0;                     // fx / fy and its inverse
constexpr double kReprojection_px = 0.1;
constexpr double kBaseline_m_min = 0.01, kBaseline_m_max = 2.0;
constexpr TimeNs kOffset_max = 1'000'000'000;

bool offset_fits(TimeNs offset) { return offset <= kOffset_max && offset >= -kOffset_max; }

bool within(double value, double min, double max) { return value >= min && value <= max; }

bool is_rotation(const Mat3& R) {
  return R.allFinite() && (R * R.transpose() - Mat3::Identity()).norm() < kRotation &&
         R.determinant() > 0;
}

bool is_finite(const Camera& camera) {
  bool finite = camera.T_BC.p.allFinite() && std::isfinite(camera.cx) && std::isfinite(camera.cy);
  for (const double d : camera.d) finite = finite && std::isfinite(d);
  return finite;
}

// The pixel has a ray, and the ray the pixel.
bool has_ray(const Camera& camera, double u, double v) {
  Vec3 bearing_C;
  Vec2 uv;
  return camera.unproject(Vec2(u, v), bearing_C) && camera.project(bearing_C, uv) &&
         (uv - Vec2(u, v)).norm() < kReprojection_px;
}

// At the middle of each edge; a fisheye's corners may well be dark.
bool covers_image(const Camera& c) {
  return has_ray(c, 0, c.cy) && has_ray(c, c.width - 1, c.cy) && has_ray(c, c.cx, 0) &&
         has_ray(c, c.cx, c.height - 1);
}

CalibrationFault find_camera_fault(const Camera& camera, const char* where) {
  if (camera.width < 16 || camera.height < 16) {
    return {where, "the image has no size", "give width and height in pixels"};
  }
  if (!image_fits(camera.width, camera.height)) {
    return {where, "the image is larger than the memory of this build",
            "record smaller images, or raise the board's board_limits.h"};
  }
  if (!is_finite(camera)) return {where, "a number is not finite", "calibrate again"};
  if (!is_rotation(camera.T_BC.R)) {
    return {where, "the camera's rotation is not one", "check rows, columns and digits of T_BS"};
  }
  if (camera.T_BC.p.norm() > kLever_m_max) {
    return {where, "the camera is more than 5 m from the IMU", "give T_BS in metres"};
  }
  const bool focal = within(camera.fx, kFocal_min * camera.width, kFocal_max * camera.width) &&
                     within(camera.fx / camera.fy, 1 / kAspect_max, kAspect_max);
  if (!focal) {
    return {where, "the focal length does not fit the image's size",
            "give fx, fy in pixels of this resolution"};
  }
  if (!within(camera.cx, 0, camera.width) || !within(camera.cy, 0, camera.height)) {
    return {where, "the principal point lies outside the image",
            "give cx, cy in pixels of this resolution"};
  }
  if (!covers_image(camera)) {
    return {where, "the distortion turns back within the image",
            "check the model, and the order and signs of its coefficients"};
  }
  return {};
}

CalibrationFault find_imu_fault(const ImuNoise& imu) {
  for (const ImuBand& band : kImuBands) {
    if (!within(imu.*band.field, band.min, band.max)) return {"imu", band.what, band.what_to_do};
  }
  return {};
}

CalibrationFault find_intrinsics_fault(const ImuIntrinsics& imu) {
  constexpr double kOff_max = 0.2, kGyroBias_max = 1, kAccelBias_max = 5;
  for (const Mat3& M : {imu.gyro, imu.accel}) {
    if (M.allFinite() && (M - Mat3::Identity()).cwiseAbs().maxCoeff() < kOff_max) continue;
    return {"imu", "a matrix of scale and misalignment is not within 0.2 of identity",
            "measured = matrix * true + bias: give it by rows, or leave it out"};
  }
  const bool good = imu.b_g.allFinite() && imu.b_g.norm() < kGyroBias_max && imu.b_a.allFinite() &&
                    imu.b_a.norm() < kAccelBias_max;
  if (!good) return {"imu", "a bias is more than 1 rad/s or 5 m/s^2", "give rad/s and m/s^2"};
  return {};
}

CalibrationFault find_gnss_fault(const GnssAntenna& gnss) {
  if (!gnss.p_BA.allFinite() || gnss.p_BA.norm() > kAntenna_m_max) {
    return {"gnss", "the antenna is more than 50 m from the IMU", "give it in metres"};
  }
  if (!offset_fits(gnss.time_offset_ns)) {
    return {"gnss", "the time offset to the IMU is more than 1 s", "give it in nanoseconds"};
  }
  return {};
}

CalibrationFault find_wheel_fault(const WheelCalibration& wheels) {
  if (!wheels.known) return {};
  if (!wheels.T_BV.p.allFinite() || wheels.T_BV.p.norm() > kVehicle_m_max) {
    return {"wheels", "the axle is more than 20 m from the IMU", "give it in metres"};
  }
  if (!is_rotation(wheels.T_BV.R)) {
    return {"wheels", "the rotation of T_BV is none", "give a right-handed orthonormal matrix"};
  }
  if (!within(wheels.track_m, 0, kVehicle_m_max) ||
      !within(wheels.wheelbase_m, 0, kVehicle_m_max) || !within(wheels.tick_m, 0, 1)) {
    return {"wheels", "track, wheelbase or the way of a tick cannot be", "give them in metres"};
  }
  if (!offset_fits(wheels.time_offset_ns)) {
    return {"wheels", "the time offset to the IMU is more than 1 s", "give it in nanoseconds"};
  }
  return {};
}

CalibrationFault find_stereo_fault(const Camera& left, const Camera& right) {
  const SE3 T_C0C1 = left.T_BC.inverse() * right.T_BC;
  const double baseline_m = T_C0C1.p.norm();
  if (!within(baseline_m, kBaseline_m_min, kBaseline_m_max)) {
    return {"cameras", "the baseline is not within 0.01 to 2 m", "give T_BS in metres"};
  }
  if (T_C0C1.p.x() < -0.5 * baseline_m) {
    return {"cameras", "the right camera stands left of the left one",
            "swap cam0 and cam1, or invert T_BS: it takes camera to body coordinates"};
  }
  if (T_C0C1.R(2, 2) < 0.5) {
    return {"cameras", "the cameras look more than 60 degrees apart",
            "invert T_BS: it takes camera to body coordinates"};
  }
  return {};
}

}  // namespace

CalibrationFault find_fault(const Calibration& calibration) {
  constexpr const char* kNames[] = {"cam0", "cam1"};
  for (int c = 0; c < calibration.cameras; ++c) {
    if (const auto fault = find_camera_fault(calibration.camera[c], kNames[c])) return fault;
  }
  if (const auto fault = find_imu_fault(calibration.imu)) return fault;
  if (const auto fault = find_intrinsics_fault(calibration.imu_intrinsics)) return fault;
  const TimeNs offset = calibration.camera_time_offset_ns;
  if (!offset_fits(offset)) {
    return {"cameras", "the time offset to the IMU is more than 1 s",
            "give timeshift_cam_imu in seconds"};
  }
  if (const auto fault = find_gnss_fault(calibration.gnss)) return fault;
  if (const auto fault = find_wheel_fault(calibration.wheels)) return fault;
  if (calibration.cameras < 2) return {};
  return find_stereo_fault(calibration.camera[0], calibration.camera[1]);
}

}  // namespace pirvs
