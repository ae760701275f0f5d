// Estimates the relative rotation between two cameras that the calibration does not account for,
// from the distances of stereo matches to their epipolar planes.
// In      unit bearings of what both see, each in its own camera, however far off its plane.
// Out     turn_B, so that the true R_BC1 is Exp(turn_B) times that of the calibration, as seen from
//         camera 0.
// Frames  C0, C1, B. Units: rad.
// Errors  none. What the matches do not tell keeps the sigma that it began with.
// Cost    ~0.05 us a match, add_looks ~50 us; x86-64.
// Source  own. About the baseline and the line of sight a turn shows in every match; about the
//         third axis, where the cameras squint, at the rims alone and by the product of both
//         angles: less is told there, since a lens that fits badly looks the same.
#pragma once

#include "core/camera/camera.h"

namespace pirvs {

class EpipolarTurn {
 public:
  void configure(const Camera& c0, const Camera& c1);
  void add(const Vec3& f_C0, const Vec3& f_C1);
  // Matches by looks alone, far off and many of them wrong: what at least half of them agree on
  // counts (Fischler, Bolles, 1981).
  struct Look {
    Vec3 f_C0, f_C1;
  };
  void add_looks(const Look* looks, int count);
  Vec3 turn_B() const { return -R_BC1_ * turn_C1_; }
  bool disagrees() const;
  void forget();  // nearly all: the next matches decide anew

 private:
  // How far off its epipolar plane, rad, and how a turn of C1 changes that.
  struct Miss {
    double off_rad;
    Vec3 J;
  };
  bool miss(const Vec3& f_C0, const Vec3& f_C1, Miss& out) const;
  Mat3 covariance() const;

  SE3 T_C1C0_;
  Mat3 R_BC1_ = Mat3::Identity();
  double pixel_rad_ = 1e-3;  // in the middle of the image
  Mat3 information_ = Mat3::Zero();
  Vec3 score_ = Vec3::Zero();
  Vec3 turn_C1_ = Vec3::Zero();
  double matches_ = 0;  // that fit, less those that do not
};

}  // namespace pirvs
