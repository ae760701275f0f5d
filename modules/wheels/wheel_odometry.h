// Makes one speed and one turn rate of whatever wheels tell.
// In      samples of one kind, in order of time; where the wheels are; how far they are believed.
// Out     WheelVelocity: the velocity of V's origin along x of V, the turn rate about z of V, and
//         how sure they are.
// Frames  V, B: wheel_calibration.h.
// Errors  kEmpty: counters say nothing until the second sample. kStale: not after the last sample.
//         kBadData: not finite, faster than any robot, or the calibration does not say what this
//         kind needs.
// Cost    ~20 ns, x86-64.
// Source  rigid-body kinematics; docs/conventions.md, "Wheels".
#pragma once

#include "core/base/status.h"
#include "modules/wheels/wheel_calibration.h"
#include "modules/wheels/wheel_params.h"
#include "modules/wheels/wheel_sample.h"

namespace pirvs {

struct WheelVelocity {
  TimeNs t = 0;                           // the middle of what was measured
  TimeNs dt_ns = 0;                       // since the sample before
  double forward_m_s = 0, sigma_m_s = 0;  // errors are the same for correlated_s
  double side_sigma_m_s = 0;              // of the speeds that are zero: along y and z of V
  double turn_rad_s = 0, turn_sigma_rad_s = 0;
  bool has_turn = false;
};

class WheelOdometry {
 public:
  void configure(const WheelCalibration& calibration, const WheelParams& params);
  Status take(const WheelSample& sample, WheelVelocity& out);
  // The wheels are larger by that share than what has been taken for so far.
  void enlarge(double share) { scale_ *= 1 + share; }
  double scale() const { return scale_; }

 private:
  Status measure(const WheelSample& sample, double dt_s, WheelVelocity& out) const;

  WheelCalibration calibration_;
  WheelParams params_;
  double scale_ = 1;
  WheelSample last_;
  bool has_last_ = false;
};

}  // namespace pirvs
