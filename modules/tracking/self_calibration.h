// What the calibration takes for granted and motion can tell: how late the cameras' stamps are, how
// far the rig is turned against the IMU, and how large the wheels are. The filter beside it
// estimates as if all were right; its residuals say by how much they are not.
// In      each step of the filter: its transition, its correspondences before the update.
// Out     estimate(): time_s, so that an image stamped t shows the body at t + time_s; turn_B, so
//         that the cameras' true T_BC is Exp(turn_B) times that of the calibration; scale, so that
//         the body goes 1 + scale times as fast as the wheels say; a sigma each.
// Frames  B. Units: s, rad.
// Errors  none. What motion does not tell keeps the sigma that it began with.
// Cost    ~1 us an IMU sample, ~2 us a frame, x86-64.
// Source  Friedland, TAC 1969 (treatment of bias in recursive filtering): the state's estimate
//         depends on the constants by S, which obeys the filter's own gains.
#pragma once

#include <Eigen/LU>

#include "modules/imu/imu_sample.h"
#include "modules/state/body_state.h"
#include "modules/tracking/mm_standstill.h"
#include "modules/tracking/pose_information.h"

namespace pirvs {

class SelfCalibration {
 public:
  static constexpr int kN = 5;  // time, turn about x, y and z, scale of the wheels
  using VecN = Eigen::Matrix<double, kN, 1>;
  using MatN = Eigen::Matrix<double, kN, kN>;
  using Mat15xN = Eigen::Matrix<double, 15, kN>;
  using Mat6xN = Eigen::Matrix<double, 6, kN>;

  // The filter begins with a state that stands on images: all of it is as far off as they are.
  void begin(const BodyState& state, const ImuSample& sample);
  void propagate(const Mat15& F) { S_ = (F * S_).eval(); }
  // The filter fuses m, whose residual changes by `per_scale` with the wheels' scale, by gain K.
  template <int N>
  void update(const Linear<N>& m, const Eigen::Matrix<double, N, 1>& per_scale,
              const Eigen::Matrix<double, N, N>& S_inverse, const Eigen::Matrix<double, 15, N>& K,
              bool again) {
    Eigen::Matrix<double, N, kN> apart = -m.H * S_;
    apart.col(kScale) += per_scale;
    if (!again) {
      const Eigen::Matrix<double, kN, N> weighted = apart.transpose() * S_inverse;
      information_ += weighted * apart;
      score_ += weighted * m.r;
    }
    S_ += K * apart;
  }
  // Before the filter fuses `seen` with its covariance `cov`; `gain` is I + A P_pp, factored.
  // again: was counted before.
  void update(const PoseInformation& seen, const Eigen::PartialPivLU<Mat6>& gain, const Mat15& cov,
              const BodyState& state, const ImuSample& sample, bool again);

  struct Estimate {
    double time_s = 0, time_sigma_s = 0;  // what correct_time() has left over
    Vec3 turn_B = Vec3::Zero(), turn_sigma_B = Vec3::Zero();
    double scale = 0, scale_sigma = 0;  // what correct_scale() has left over
  };
  Estimate estimate() const;
  // By how much stamps are to be taken for later from the next frame on: a part of what is left
  // over, 0 as long as that is uncertain. The caller does so.
  TimeNs correct_time();
  // The same of the wheels: by what share they are to be taken for faster.
  double correct_scale();

 private:
  static constexpr int kScale = 4;
  static Mat15xN moved(const BodyState& state, const ImuSample& sample);

  Mat15xN S_ = Mat15xN::Zero();  // d state error / d constants
  MatN information_ = MatN::Zero();
  VecN score_ = VecN::Zero();
  TimeNs t_ = 0;  // of the last frame
};

}  // namespace pirvs
