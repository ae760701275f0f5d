#include "tools/calib/imu_camera.h"

#include <algorithm>
#include <cmath>

#include "tools/calib/motion_problem.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr double kCoarse_s = 0.02, kFine_s = 0.01;
constexpr double kStiff = 1.2;  // excess noise that a finer spline must take away to be worth it
constexpr double kNews = 0.5;   // a sigma above this share of its prior's: the motion said little
constexpr double kPlace_m = 0.01;
constexpr int kPerCamera = 16;  // unknowns: theta, p, offset, drift, lens

Weights next_weights(const MotionProblem& problem, double sigma_px) {
  const MotionProblem::Residuals now = problem.residuals();
  Weights out;
  out.sigma_px = std::max({sigma_px, now.px[0], now.px[1]});
  out.gyro_excess = std::max(1.0, now.gyro_excess);
  out.accel_excess = std::max(1.0, now.accel_excess);
  return out;
}

void solve(MotionProblem& problem, const Weights& weights, int steps) {
  if (problem.solve(weights, steps)) return;
  throw InputError("images and IMU samples do not fit one motion", "the recording",
                   "check the target, the stamps, and that the board did not move");
}

void name_unexcited(const ImuCameraResult& r, bool imu_intrinsics, std::vector<std::string>& out) {
  const char* const axes[3] = {"x", "y", "z"};
  for (int i = 0; i < 3 && imu_intrinsics; ++i) {
    for (int j = 0; j < 3; ++j) {
      const std::string what = i == j ? std::string(" scale ") + axes[i]
                                      : std::string(" misalignment ") + axes[i] + axes[j];
      if (r.gyro_sigma(i, j) > kNews * kMatrixSigma) out.push_back("gyro" + what);
      if (j <= i && r.accel_sigma(i, j) > kNews * kMatrixSigma)
        out.push_back("accelerometer" + what);
    }
  }
  for (int c = 0; c < r.rig.cameras; ++c) {
    const std::string name = "cam" + std::to_string(c);
    for (int i = 0; i < 3; ++i) {
      if (r.camera[c].sigma[3 + i] > kPlace_m) out.push_back(name + " place along " + axes[i]);
    }
    if (r.camera[c].sigma[6] > 1e-3) out.push_back(name + " time offset");
  }
}

void take_sigmas(bool imu_intrinsics, ImuCameraResult& out) {
  const Eigen::MatrixXd& P = out.covariance;
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  for (int c = 0; c < out.rig.cameras; ++c) {
    out.camera[c].sigma = sigma.segment<8>(kPerCamera * c);
    out.camera[c].lens_sigma = sigma.segment<8>(kPerCamera * c + 8);
  }
  const int at = kPerCamera * out.rig.cameras;
  out.b_g_sigma = sigma.segment<3>(at);
  out.b_a_sigma = sigma.segment<3>(at + 3);
  out.gyro_sigma.setZero();
  out.accel_sigma.setZero();
  if (imu_intrinsics) {
    for (int i = 0; i < 9; ++i) out.gyro_sigma(i / 3, i % 3) = sigma[at + 6 + i];
    out.accel_sigma = lower_triangular(sigma.data() + at + 15);
  }
  if (out.rig.cameras < 2) return;
  const Vec3 between = out.camera[1].T_BC.p - out.camera[0].T_BC.p;
  const Vec3 unit = between.normalized();
  const int a = 3, b = kPerCamera + 3;
  const Mat3 spread =
      P.block<3, 3>(a, a) + P.block<3, 3>(b, b) - P.block<3, 3>(a, b) - P.block<3, 3>(b, a);
  out.baseline_m = between.norm();
  out.baseline_sigma_m = std::sqrt(unit.dot(spread * unit));
}

ImuCameraResult collect(const MotionProblem& problem, const CameraRig& rig) {
  const MotionUnknowns& x = problem.unknowns();
  const MotionProblem::Residuals residuals = problem.residuals();
  ImuCameraResult out;
  out.rig = rig;
  for (int c = 0; c < rig.cameras; ++c) {
    set_lens(x.lens[c].data(), out.rig.camera[c]);
    out.camera[c].T_BC = {x.R_BC[c].matrix(), x.p_BC[c]};
    out.rig.camera[c].T_BC = out.camera[c].T_BC;
    out.camera[c].offset_s = x.time[c][0];
    out.camera[c].drift = x.time[c][1];
    out.camera[c].rms_px = residuals.px[c];
  }
  if (rig.cameras == 2) out.rig.T_C1C0 = out.camera[1].T_BC.inverse() * out.camera[0].T_BC;
  for (int i = 0; i < 9; ++i) out.gyro(i / 3, i % 3) = x.gyro[i];
  out.accel = lower_triangular(x.accel);
  out.b_g = x.b_g[x.b_g.size() / 2];
  out.b_a = x.b_a[x.b_a.size() / 2];
  out.gravity_T = x.gravity_T;
  out.knot_s = x.dt_s;
  out.samples = residuals.samples;
  out.gyro_rms = residuals.gyro;
  out.accel_rms = residuals.accel;
  out.gyro_excess = residuals.gyro_excess;
  out.accel_excess = residuals.accel_excess;
  return out;
}

}  // namespace

ImuCameraResult calibrate_imu_camera(const CameraResult& cameras, const std::vector<ImuSample>& imu,
                                     const ImuCameraOptions& options) {
  const std::vector<PosedShot>& shots = cameras.all;
  const double sigma_px = cameras.adjustment.sigma_px;
  const MotionStart start = start_motion(shots, imu);
  MotionProblem problem(cameras.target, cameras.rig, shots, imu, options);
  const bool automatic = options.knot_s <= 0;
  problem.start(start, automatic ? kCoarse_s : options.knot_s);
  // The start is no better than centimetres: the first round trusts the IMU less than its
  // densities.
  constexpr double kStartExcess = 10;
  solve(problem, {2 * sigma_px, kStartExcess, kStartExcess}, 15);
  solve(problem, next_weights(problem, sigma_px), 10);
  Weights weights = next_weights(problem, sigma_px);
  if (automatic && std::max(weights.gyro_excess, weights.accel_excess) > kStiff) {
    problem.refine(kFine_s);
    solve(problem, weights, 10);
    weights = next_weights(problem, sigma_px);
  }
  solve(problem, weights, 10);
  ImuCameraResult out = collect(problem, cameras.rig);
  out.frames = shots.size();
  if (!problem.covariance(cameras.adjustment.board_covariance, out.covariance)) {
    throw InputError("the motion leaves the calibration open", "the recording",
                     "turn and move the device along all three axes, with the board in view");
  }
  take_sigmas(options.imu_intrinsics, out);
  name_unexcited(out, options.imu_intrinsics, out.unexcited);
  return out;
}

}  // namespace pirvs::tools
