// Sums the speeds of wheels into the way of the vehicle between two keyframes.
// In      the turn since the first keyframe, at each IMU step; speeds, in order of time.
// Out     way_B0: from V's origin at the first to that at the second; its first-order dependence
//         on the gyro bias; covariance. holds(): wheels have told of all of it and did not slip.
// Frames  B0: body at the first keyframe. V: wheel_calibration.h.
// Units   m, s, rad/s.
// Errors  none: what is missing or slipped is told by holds().
// Cost    ~20 ns an IMU step, ~60 ns a speed, x86-64; no memory beyond the object.
// Source  preintegration of odometry: e.g. Lee et al., IROS 2020 (visual-inertial-wheel);
//         docs/conventions.md, "Wheels".
#pragma once

#include "core/math/types.h"
#include "modules/imu/preintegration.h"
#include "modules/wheels/wheel_odometry.h"

namespace pirvs {

class WheelPath {
 public:
  static constexpr double kGap_s_max = 0.25;  // between two speeds

  // How wheels are to be taken.
  void configure(const SE3& T_BV, const WheelParams& params);
  // A new path, from here on; the last speed still counts.
  void begin();
  // An IMU step: from the attitude dR_before to that of `motion`, all against B0.
  void turn(const Mat3& dR_before, const Preintegration& motion, double dt_s);
  // A speed at the end of the steps so far. slips: it is not to be used.
  void speed(const WheelVelocity& velocity, bool slips);
  // The second keyframe: the last speed holds until there.
  void end();

  bool holds() const { return dt_s > 0 && holds_; }
  Mat3 covariance() const {
    return cov + scale_sigma_ * scale_sigma_ * way_B0 * way_B0.transpose();
  }

  double dt_s = 0;
  Vec3 way_B0 = Vec3::Zero();
  Mat3 dway_dbg = Mat3::Zero();
  Vec3 p_BV = Vec3::Zero();
  Vec3 b_g = Vec3::Zero();  // that it was summed with
  Mat3 cov = Mat3::Zero();  // without the scale's part

 private:
  void close(double forward_m_s, const WheelVelocity& sure);

  Mat3 R_BV_ = Mat3::Identity();
  double correlated_s_ = 0, scale_sigma_ = 0;
  bool holds_ = true;
  // Since the last speed.
  Mat3 dR_sum_ = Mat3::Zero();  // integral of the attitude
  Mat3 dR_ = Mat3::Identity(), dR_dbg_ = Mat3::Zero();
  double open_s_ = 0;
  WheelVelocity last_;
  bool has_last_ = false;
};

}  // namespace pirvs
