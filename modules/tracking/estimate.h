// The estimate of the body: the filter, rest, the way back to a refined keyframe, and how uncertain
// the map is that all of it stands on.
// In      samples after they were added to `history`; correspondences; keyframes that mapping has
//         refined.
// Out     state and covariance, after every sample and frame.
// Errors  restart: false when the samples since the keyframe are no longer there; nothing changes.
// Cost    the filter's.
// Source  PIRVS paper, section IV.B; docs/adr/0007-error-of-the-map.md.
#pragma once

#include "modules/imu/imu_history.h"
#include "modules/map/map_error.h"
#include "modules/standstill/standstill.h"
#include "modules/tracking/filter.h"
#include "modules/wheels/wheel_history.h"

namespace pirvs {
// Many methods: the filter with its history of samples, wheels and maps.
class Estimate {
 public:
  void configure(const Camera* cameras, const ImuNoise& noise, const FilterParams& filter,
                 double cov_scale, const ImuHistory* history);
  void set_noise(const ImuNoise& noise) { filter_.set_noise(noise); }
  void compare(const Correspondences& correspondences, PairCheck& cameras) const {
    filter_.compare(correspondences, cameras);
  }
  // T_BV: wheel_calibration.h.
  void configure_wheels(const SE3& T_BV, const WheelParams& params, const WheelHistory* wheels);
  // A start: the newest sample's time is that of `state`.
  void begin(const BodyState& state, const Mat15& cov);
  void propagate(const ImuSample& sample) { filter_.propagate(sample); }

  WheelVerdict update_wheel(const WheelVelocity& wheel, bool again = false) {
    return filter_.update_wheel(wheel, T_BV_, wheel_params_, again);
  }

  // A keyframe of the past is `refined` after an adjustment: goes on from there. advance() takes it
  // to each frame since then, whose correspondences are fused once more, and to the newest sample,
  // with the wheels' speeds on the way.
  bool restart(const BodyState& refined, const Mat15& cov);
  void advance(TimeNs t);
  // The map was moved by T, and the body with it.
  void carry_over(const SE3& T);
  // The place was recognised: the pose is T_WB, as uncertain as that, and depends on nothing else.
  void relocate(const SE3& T_WB, double sigma_rad, double sigma_m);
  void set_map_error(const MapError& error) { map_error_ = error; }

  // Before what is seen is fused: at rest the filter goes on from the last frame at rest, not from
  // what the IMU added since.
  void stand_still(const StandstillDetector& standstill);
  void end_rest() { resting_ = false; }
  // What is seen. Returns how many correspondences were accepted.
  // again: of a frame that was fused before.
  int update(Correspondences& correspondences, bool again = false) {
    return filter_.update(correspondences, again);
  }
  // The same where the pose is so uncertain that wrong matches may fit one by one: `wanted` and
  // most of them have to agree on where it is. Else nothing changes, and 0 is returned.
  int update_if_agreed(Correspondences& correspondences, int wanted);
  // The pose is off by so much that what is near may be taken for something else.
  bool unsure() const;
  // T_WB lies within what dead reckoning allows.
  bool plausible(const SE3& T_WB, const Mat6& cov) const;
  // After what is seen was fused: the next frame at rest goes on from here.
  void note_rest();
  void end_frame() { T_WB_last_frame_ = filter_.state().T_WB; }

  const BodyState& state() const { return filter_.state(); }
  const SE3& T_WB_last_frame() const { return T_WB_last_frame_; }
  Mat6 pose_cov() const { return filter_.cov().topLeftCorner<6, 6>(); }  // against the map
  const SelfCalibration& self_calibration() const { return self_calibration_; }
  SelfCalibration& self_calibration() { return self_calibration_; }
  const MapError& map_error() const { return map_error_; }
  // Against where the first start began: the filter's, which is against the map, and the map's own,
  // both cov_scale times.
  Mat15 cov() const;

 private:
  void set_now(const BodyState& state, const Mat15& cov);

  Filter filter_;
  SelfCalibration self_calibration_;
  const ImuHistory* history_ = nullptr;
  const WheelHistory* wheels_ = nullptr;
  SE3 T_BV_;
  WheelParams wheel_params_;
  double cov_scale_ = 1;
  MapError map_error_;
  SE3 T_WB_last_frame_;
  bool resting_ = false;  // at the last frame the filter was at rest_state_ with rest_cov_
  BodyState rest_state_;
  Mat15 rest_cov_ = Mat15::Zero();
};

}  // namespace pirvs
