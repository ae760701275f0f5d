// Simulated devices by seed, tags projected: everything found as close as a factory asks, and as
// close as its sigmas say.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <chrono>
#include <cmath>
#include <cstdlib>

#include "core/math/so3.h"
#include "tools/calib/device_calibration.h"
#include "tools/calib/simulated_device.h"

namespace pirvs::tools {
namespace {

constexpr double kDegrees = 180 / M_PI;

struct Found {
  CameraResult cameras;
  ImuCameraResult result;
  double seconds = 0;
};

Found calibrate(SimulatedDevice& device, const SimulatedRecording& how) {
  CameraOptions options;
  options.model = CameraModel::kKannalaBrandt;
  options.size = {device.rig.camera[0].width, device.rig.camera[0].height};
  Found out;
  const std::vector<Shot> shots = device.shots(how);
  const std::vector<ImuSample> samples = device.samples(how);
  ImuCameraOptions motion;
  motion.noise = device.noise;
  const auto begin = std::chrono::steady_clock::now();
  out.cameras = calibrate_cameras(device.target, shots, 2, options);
  out.result = calibrate_imu_camera(out.cameras, samples, motion);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

// Found less true, in the order of the covariance.
Eigen::VectorXd error_of(const SimulatedDevice& device, const ImuCameraResult& r) {
  Eigen::VectorXd out(r.covariance.rows());
  for (int c = 0; c < 2; ++c) {
    const SE3 &was = device.rig.camera[c].T_BC, &is = r.camera[c].T_BC;
    out.segment<3>(16 * c) = so3_log(was.R.transpose() * is.R);
    out.segment<3>(16 * c + 3) = is.p - was.p;
    out[16 * c + 6] = r.camera[c].offset_s - device.offset_s;
    out[16 * c + 7] = r.camera[c].drift;
    out.segment<8>(16 * c + 8) = lens_of(r.rig.camera[c]) - lens_of(device.rig.camera[c]);
  }
  out.segment<3>(32) = r.b_g - device.imu.b_g;
  out.segment<3>(35) = r.b_a - device.imu.b_a;
  Eigen::Index at = 38;
  for (int i = 0; i < 9; ++i) out[at++] = r.gyro(i / 3, i % 3) - device.imu.gyro(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) out[at++] = r.accel(i, j) - device.imu.accel(i, j);
  }
  return out;
}

// Over its mean, and the worst of all values in its own sigmas.
struct Consistency {
  double nees = 0, worst = 0;
};

Consistency consistency(const Eigen::VectorXd& error, const Eigen::MatrixXd& P) {
  Consistency out;
  // Of values in their sigmas, whose units do not matter.
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt(), e = error.cwiseQuotient(sigma);
  const Eigen::MatrixXd inverse_sigma = sigma.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd correlation = inverse_sigma * P * inverse_sigma;
  out.nees = e.dot(correlation.ldlt().solve(e)) / double(e.size());
  out.worst = e.cwiseAbs().maxCoeff();
  return out;
}

Consistency expect_truth(const SimulatedDevice& device, const Found& found) {
  const ImuCameraResult& r = found.result;
  double focal = 0, centre = 0, rotation = 0, place = 0, time = 0, gyro = 0, accel = 0;
  for (int c = 0; c < 2; ++c) {
    const Camera &is = r.rig.camera[c], &was = device.rig.camera[c];
    focal = std::max({focal, std::abs(is.fx / was.fx - 1), std::abs(is.fy / was.fy - 1)});
    centre = std::max({centre, std::abs(is.cx - was.cx), std::abs(is.cy - was.cy)});
    rotation = std::max(rotation, kDegrees * so3_log(was.T_BC.R.transpose() * is.T_BC.R).norm());
    place = std::max(place, 1e3 * (is.T_BC.p - was.T_BC.p).norm());
    time = std::max(time, 1e3 * std::abs(r.camera[c].offset_s - device.offset_s));
  }
  const double baseline = 1e3 * std::abs(r.baseline_m - device.rig.T_C1C0.p.norm());
  for (int i = 0; i < 3; ++i) {
    gyro = std::max(gyro, std::abs(r.gyro(i, i) - device.imu.gyro(i, i)));
    accel = std::max(accel, std::abs(r.accel(i, i) - device.imu.accel(i, i)));
  }
  const Consistency out = consistency(error_of(device, r), r.covariance);
  const HeldOut& held = found.cameras.held_out;
  std::printf(
      "%.3f %.3f px | focal %.4f %% | centre %.3f px | baseline %.3f mm | rotation %.4f deg"
      " | place %.2f mm | time %.4f ms | gyro %.4f %% | accelerometer %.4f %% | NEES %.2f |"
      " worst %.1f sigma | %.0f s\n",
      std::max(held.within_px[0], held.within_px[1]), held.across_px, 100 * focal, centre, baseline,
      rotation, place, time, 100 * gyro, 100 * accel, out.nees, out.worst, found.seconds);
  std::fflush(stdout);
  EXPECT_LT(std::max(held.within_px[0], held.within_px[1]), 0.2);
  EXPECT_LT(held.across_px, 0.3);
  EXPECT_LT(focal, 1e-3);
  EXPECT_LT(centre, 0.3);
  EXPECT_LT(baseline, 0.1);
  EXPECT_LT(rotation, 0.03);
  EXPECT_LT(place, 1);
  EXPECT_LT(time, 0.05);
  EXPECT_LT(gyro, 1e-3);
  EXPECT_LT(accel, 2e-3);
  return out;
}

// PIRVS_CALIB_DEVICES=20 for the long run, of a minute each.
TEST(calibration, devices_by_seed_are_found_within_their_sigmas) {
  const char* const more = std::getenv("PIRVS_CALIB_DEVICES");
  const int devices = more != nullptr ? std::atoi(more) : 1;
  SimulatedRecording how;
  how.duration_s = more != nullptr ? 60 : 15;
  how.frames_hz = 12;
  double nees = 0;
  for (int seed = 1; seed <= devices; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SimulatedDevice device(static_cast<uint64_t>(seed));
    const Consistency found = expect_truth(device, calibrate(device, how));
    nees += found.nees / devices;
    // Of 53 values of each of 20 devices, the worst is rarely beyond four.
    EXPECT_LT(found.worst, 4);
  }
  // The mean of as many values as devices have of a chi-square over its mean, at four sigmas.
  constexpr double kValues = 53;
  const double band = 4 * std::sqrt(2 / (kValues * devices));
  std::printf("NEES %.2f, band 1 +- %.2f\n", nees, band);
  EXPECT_LT(nees, 1 + band);
  EXPECT_GT(nees, 1 - band);
}

}  // namespace
}  // namespace pirvs::tools
