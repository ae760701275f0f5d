// What    Does the covariance contain the error? Normalized estimation error squared (NEES) of
//         position, attitude, velocity and the biases against exact truth.
// In      StateEstimate per frame; the refined pose of the first keyframe, which defines the
//         estimator's world; truth with velocities and biases.
// Out     per frame e' P^-1 e with P the 3 x 3 block of each quantity, 3 degrees of freedom each:
//         mean 3 when consistent, more when overconfident. And the errors and their sigmas.
// Frames  E: the estimator's world, whose origin and heading are those of the first keyframe. The
//         truth is moved there by the four numbers that no camera and no IMU can know (place and
//         heading) at that keyframe, and by nothing else: what the estimate drifts from there is
//         its error, and a tilt is an error from the start.
// Units   m, rad, m/s, rad/s, m/s^2.
// Errors  ok = false: truth without velocity, or no truth at the first keyframe.
// Cost    ~2 us a frame.
// Source  Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation,
//         2001, section 5.4; Zhang, Scaramuzza, IROS 2018 (four-number alignment).
#pragma once

#include <vector>

#include "tools/dataset/trajectory.h"

namespace pirvs::tools {

struct StateEstimate {
  TrajectoryPose state;
  Mat15 cov = Mat15::Zero();  // theta (in B, right), p, v (in W), b_g, b_a
};

enum NeesPart : int {
  kNeesPosition,
  kNeesAttitude,
  kNeesVelocity,
  kNeesGyroBias,
  kNeesAccelBias,
  kNeesParts
};
inline constexpr const char* kNeesNames[kNeesParts] = {"position", "attitude", "velocity",
                                                       "gyro_bias", "accel_bias"};

struct NeesFrame {
  TimeNs t = 0;
  double nees[kNeesParts];
  Vec3 error[kNeesParts];
  Vec3 sigma[kNeesParts];
};

struct Nees {
  bool ok = false;
  double mean[kNeesParts] = {};
  std::vector<NeesFrame> frames;
};

Nees evaluate_nees(const std::vector<StateEstimate>& estimates, const TrajectoryPose& first,
                   const Trajectory& truth);

// Central 95 % of the mean of `count` independent NEES of 3 degrees of freedom (Wilson, Hilferty).
struct NeesBand {
  double low, high;
};
NeesBand nees_band(size_t count);

}  // namespace pirvs::tools
