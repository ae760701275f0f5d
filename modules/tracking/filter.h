// The iterated error-state Kalman filter: the only writer of the tracked state and its covariance.
// In      IMU samples in order; 3D-2D correspondences of both cameras; standstill
//         pseudo-measurements.
// Out     BodyState and its 15 x 15 covariance, error order theta (in B, right), p, v (in W), b_g,
//         b_a.
// Frames  W: world, z up; B: IMU; gravity is (0, 0, -kGravity) in W.
// Errors  correspondences are gated one by one; the gate's verdict is left in each of them.
// Cost    propagate ~3 us a sample, update ~0.25 us a correspondence and iteration, x86-64.
// Source  PIRVS paper, eqs. 1 to 6; Bell, Cathey, TAC 1993 (iterated EKF as Gauss-Newton).
#pragma once

#include "core/camera/camera.h"
#include "modules/imu/gravity.h"
#include "modules/imu/imu_history.h"
#include "modules/map/map.h"
#include "modules/tracking/mm_reprojection.h"
#include "modules/tracking/mm_standstill.h"
#include "modules/tracking/mm_wheel.h"
#include "modules/tracking/pair_check.h"
#include "modules/tracking/self_calibration.h"
#include "modules/tracking/tracking_params.h"

namespace pirvs {

using Correspondences = FixedVector<Correspondence, kCamerasMax * kTracksMax>;

// How well a pose is known that is looked for: first so, then `tighter` times that, a gate that
// rejects what does not fit.
struct PoseGuess {
  double sigma_rad, sigma_m, tighter;
};

// What the filter made of a speed.
enum class WheelVerdict : uint8_t {
  kUsed,
  kSlips,  // refused: it is not the body's
  kSkids,  // the speed is used, the turn rate refused
};

class Filter {
 public:
  void configure(const Camera* cameras, const ImuNoise& noise, const FilterParams& params);
  void set_noise(const ImuNoise& noise) { noise_ = noise; }  // from now on
  void reset(const BodyState& state, const Mat15& cov);
  // Tells it of every step from now on; nullptr: nobody.
  void tell(SelfCalibration* listener) { listener_ = listener; }

  // Moves the state to the time of `sample`; the first sample after reset() only sets the start.
  void propagate(const ImuSample& sample);
  // reset() to a state of the past, at the time of a sample. False: there is none at its time, and
  // nothing changes.
  bool restart(const BodyState& state, const Mat15& cov, const ImuHistory& imu);
  // All samples after the last one, up to t.
  void propagate_until(TimeNs t, const ImuHistory& imu);
  // Eq. 6 for all correspondences at once. Returns how many were accepted; 0 changes nothing.
  // again: they were fused before, and the listener has counted them.
  int update(Correspondences& correspondences, bool again = false);
  // Every residual about the present pose, to what compares the cameras.
  void compare(const Correspondences& correspondences, PairCheck& cameras) const;
  // How many of the accepted still fit the pose that they have led to.
  int agreeing(const Correspondences& correspondences) const;
  // From a pose alone: reset() and update(), loosely, then tightly. Returns how many were accepted.
  int locate(const SE3& T_WB, const PoseGuess& guess, Correspondences& correspondences);
  // The body goes as its wheels say, measured about now.
  WheelVerdict update_wheel(const WheelVelocity& wheel, const SE3& T_BV, const WheelParams& params,
                            bool again = false);
  // As rest begins: 0 = v_WB + n and w_B = b_g + n.
  void update_standstill(const Vec3& w_mean_B);
  // As rest goes on: pose and velocity stay those of `state` with `cov`; dead reckoning since then
  // is discarded, and the samples serve as measurements of the biases and of gravity instead.
  void hold(const BodyState& state, const Mat15& cov, const Vec3& w_mean_B, const Vec3& f_mean_B);

  const BodyState& state() const { return state_; }
  const Mat15& cov() const { return cov_; }

 private:
  bool linearize(const BodyState& at, const Correspondence& c, Reprojection& out) const;
  int gate(Correspondences& correspondences) const;
  PoseInformation linearize(const BodyState& at, const Correspondences& correspondences) const;
  template <int N>
  struct Gain {
    Eigen::Matrix<double, 15, N> PH, K;
    Eigen::Matrix<double, N, N> S_inverse;
  };
  template <int N>
  Gain<N> gain(const Linear<N>& m) const;
  template <int N>
  void fuse(const Linear<N>& m, const Gain<N>& gain);
  template <int N>
  void fuse(const Linear<N>& m) {
    fuse(m, gain(m));
  }
  template <int N>
  bool fuse_wheel(const Linear<N>& m, const Eigen::Matrix<double, N, 1>& per_scale,
                  const WheelParams& params, bool again);

  Camera camera_[kCamerasMax];
  SE3 T_CB_[kCamerasMax];
  ImuNoise noise_;
  FilterParams params_;
  BodyState state_;
  Mat15 cov_ = Mat15::Identity();
  ImuSample last_;
  bool has_sample_ = false;
  SelfCalibration* listener_ = nullptr;
};

}  // namespace pirvs
