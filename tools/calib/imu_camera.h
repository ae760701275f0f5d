// What    Calibrates cameras against the IMU: where they stand, when they look, and the IMU itself.
// In      Rig, board and shots as `calibrate_cameras` left them. Its lenses are a start alone: they
//         are estimated again, from all shots, together with the motion. Its board is held, and the
//         covariance of the board's shape carried over to everything. Noise densities of the IMU.
// Out     Everything with a sigma; what the motion did not excite keeps its prior and is named.
// Frames  B: the accelerometer; T: the board. measured = matrix * true + bias; the accelerometer's
//         matrix is lower triangular, which is what fixes B's axes.
// Units   SI, px; t_imu = t_camera + offset_s + drift * (t_camera - middle).
// Errors  InputError as start_motion, and if the adjustment fails.
// Cost    april_euroc, 72 s: ~1.5 s an iteration with a knot every 20 ms, some 40 iterations.
// Source  Furgale, Rehder, Siegwart, IROS 2013, with images compressed (frame_factor.h).
#pragma once

#include <string>
#include <vector>

#include "modules/imu/imu_noise.h"
#include "tools/calib/cameras.h"
#include "tools/calib/lens.h"
#include "tools/calib/motion_start.h"

namespace pirvs::tools {

struct ImuCameraOptions {
  ImuNoise noise;
  double knot_s = 0;           // 0: by the motion
  bool imu_intrinsics = true;  // scale and misalignment
};

struct CameraToImu {
  SE3 T_BC;
  double offset_s = 0;
  double drift = 0;
  // theta (of R_BC Exp(theta)), p_BC, offset, drift.
  Eigen::Matrix<double, 8, 1> sigma;
  LensVector lens_sigma;
  double rms_px = 0;  // corners at the spline's poses
};

struct ImuCameraResult {
  CameraRig rig;
  CameraToImu camera[2];
  Mat3 gyro = Mat3::Identity(), accel = Mat3::Identity();
  Mat3 gyro_sigma, accel_sigma;  // upper triangle of accel_sigma: zero
  Vec3 b_g, b_a;                 // in the middle of the recording
  Vec3 b_g_sigma, b_a_sigma;
  Vec3 gravity_T;
  // T_C1C0 from both: baseline and its sigma.
  double baseline_m = 0, baseline_sigma_m = 0;
  double knot_s = 0;
  size_t frames = 0, samples = 0;
  double gyro_rms = 0, accel_rms = 0;        // of residuals, rad/s, m/s^2
  double gyro_excess = 1, accel_excess = 1;  // noise over what the densities say
  std::vector<std::string> unexcited;        // what kept its prior
  // 16 of each camera: theta, p, offset, drift, lens; then b_g, b_a, and, if they were estimated,
  // 9 of `gyro` by rows, 6 of `accel`'s lower triangle by rows.
  Eigen::MatrixXd covariance;
};

ImuCameraResult calibrate_imu_camera(const CameraResult& cameras, const std::vector<ImuSample>& imu,
                                     const ImuCameraOptions& options);

}  // namespace pirvs::tools
