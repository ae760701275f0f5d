// What    The least-squares problem of camera-to-IMU calibration over one recording.
// In      Shots, samples, what is known at the start.
// Out     solve() moves the unknowns; the rest asks about them.
// Frames, units  as imu_camera.h; times in s since the first shot, on the IMU's clock.
// Errors  solve: false if Ceres gives up.
// Cost    ~1 s an iteration for 72 s at 50 knots a second.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "tools/calib/imu_camera.h"
#include "tools/calib/motion_costs.h"
#include "tools/calib/solver.h"

namespace pirvs::tools {

// Standard deviations of what is known before the recording.
inline constexpr double kMatrixSigma = 0.03;  // of each element of both matrices of the IMU
inline constexpr double kPlaceSigma_m = 0.5;
inline constexpr double kOffsetSigma_s = 0.1;
inline constexpr double kDriftSigma = 1e-4;
inline constexpr double kGyroBiasSigma_rad_s = 0.2;
inline constexpr double kAccelBiasSigma_m_s2 = 1.0;

struct MotionUnknowns {
  double t0_s = 0, dt_s = 0;  // the first segment's start, knots' distance
  std::vector<Rotation> q_TB;
  std::vector<Vec3> p_TB;
  Rotation R_BC[2];
  Vec3 p_BC[2];
  double time[2][2];  // offset_s, drift
  LensVector lens[2];
  Vec3 gravity_T;
  double gyro[9], accel[6];
  std::vector<Vec3> b_g, b_a;  // a knot every kBiasKnot_s from t0_s on

  static constexpr double kBiasKnot_s = 5;

  int segments() const { return int(q_TB.size()) - kSplineOrder + 1; }
  double end_s() const { return t0_s + segments() * dt_s; }
  int segment(double t_s) const;
  SE3 T_TB(double t_s) const;
};

struct Weights {
  double sigma_px = 0.3;
  double gyro_excess = 1, accel_excess = 1;  // noise over what the densities say
};

class MotionProblem {
 public:
  MotionProblem(const Target& target, const CameraRig& rig, const std::vector<PosedShot>& shots,
                const std::vector<ImuSample>& imu, const ImuCameraOptions& options);

  // Knots from the boards' poses, or from the spline as it is.
  void start(const MotionStart& start, double knot_s);
  void refine(double knot_s);

  // Linearizes images where the board is now seen: at the boards' own poses the first time.
  bool solve(const Weights& weights, int steps_max);
  // Of theta, p, offset, drift and lens of each camera, both biases, both matrices of the IMU.
  // board: of the tags' shifts, which were estimated before and are held here.
  bool covariance(const Eigen::MatrixXd& board, Eigen::MatrixXd& out);

  const MotionUnknowns& unknowns() const { return x_; }
  // Root mean squares over all samples and corners; excess over the densities, less what the knots
  // have taken.
  struct Residuals {
    double gyro = 0, accel = 0, gyro_excess = 1, accel_excess = 1;
    double px[2] = {0, 0};
    size_t samples = 0;
  };
  Residuals residuals() const;

 private:
  const Target& target_;
  CameraRig rig_;
  const std::vector<PosedShot>& shots_;
  const std::vector<ImuSample>& imu_;
  ImuCameraOptions options_;
  TimeNs epoch_;
  double middle_s_;
  bool solved_ = false;
  MotionUnknowns x_;
  std::unique_ptr<ceres::Problem> problem_;
  struct Image {
    ceres::ResidualBlockId id;
    BoardRows board;
  };
  std::vector<Image> images_;  // the first residuals of the problem

  double image_time_s(size_t shot, int camera) const;
  SE3 board_in(int camera, double t_s) const;
  bool knots_at(double t_s, std::vector<double*>& blocks);
  void add_imu(const Weights& weights);
  void add_images(const Weights& weights);
  void add_priors();
  void make_knots(double knot_s, const std::vector<SE3>& T_TB_at_knots);
};

}  // namespace pirvs::tools
