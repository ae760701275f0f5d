// Tells whether two cameras under the same stamps have seen at the same time and are turned against
// each other as calibrated: one that is late, or bent, is off along what motion, or a turn, does.
// In      the residuals of both, about the pose that was fused from both.
// Out     how much later the right camera saw than the left, and by how much it is turned against
//         it; the camera to be left out, a bit each, until it is asked again.
// Frames  B. Units: s, rad.
// Errors  none. What motion does not tell keeps the sigma that it began with.
// Cost    ~0.1 us a correspondence, x86-64.
// Source  own. The fused pose lies between the two cameras, wherever: the difference of their
//         residuals does not depend on where.
#pragma once

#include "core/base/time.h"
#include "modules/tracking/mm_reprojection.h"

namespace pirvs {

class PairCheck {
 public:
  struct Verdict {
    double late_s = 0, late_sigma_s = 0;                           // right against left
    Vec3 turn_B = Vec3::Zero(), turn_sigma_B = Vec3::Constant(1);  // the same
    bool disagree() const;
  };
  // Before the residuals of a frame at `t` of a body that moves by `rate_B` (rate, velocity in W).
  void begin_frame(TimeNs t, const Vec6& rate);
  void add(int camera, const Reprojection& m);
  Verdict verdict() const;

  // After a frame. The better of two that disagree is the one that fits the IMU: how far both are
  // from it together is known from elsewhere. True: a camera is left out from now on.
  bool judge(TimeNs t, double both_late_s, const Vec3& both_turn_B);
  // The same, of a disagreement that is known from elsewhere.
  void leave_out(TimeNs t, const Verdict& pair, double both_late_s, const Vec3& both_turn_B);
  bool in_doubt() const { return since_ != 0; }
  uint8_t left_out(TimeNs t) const { return t < until_ ? left_out_ : 0; }

 private:
  static constexpr int kN = 4;  // time, turn about x, y and z
  struct Sum {
    Eigen::Matrix<double, kN, kN> information = Eigen::Matrix<double, kN, kN>::Zero();
    Eigen::Matrix<double, kN, 1> score = Eigen::Matrix<double, kN, 1>::Zero();
  };
  Sum sum_[kCamerasMax];
  Vec6 rate_ = Vec6::Zero();
  TimeNs t_ = 0;
  TimeNs since_ = 0, until_ = 0;  // they disagree; one is left out
  double for_s_ = 0;              // for so long the last time
  uint8_t left_out_ = 0;
};

}  // namespace pirvs
