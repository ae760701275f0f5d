// What    A smooth path through the world: pose, velocity, acceleration and turn rate at any time.
// In      A seed (a flight through a hall of about 12 x 9 m, at rest first); a constant velocity
//         and turn rate, at rest first; a recorded trajectory or a function of time, which are
//         followed closely, not exactly: the spline is the truth.
// Out     State at t_s in [0, duration_s]. The position and the quaternion (before it is
//         normalized) are uniform B-splines of degree 5: four times continuously differentiable.
// Frames  W: z up. B: IMU. R_LB: from B to the look frame L (x forward, y left, z up), so that a
//         random flight looks where its device's cameras look.
// Units   m, m/s, m/s^2, rad/s, s.
// Errors  bug (assert of the test): t_s outside the path.
// Cost    ~0.2 us a state.
// Source  de Boor 1978; w = 2 vec(q* dq/dt).
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/math/se3.h"
#include "tools/dataset/trajectory.h"

namespace pirvs::tools {

struct PathState {
  Vec3 p_WB;
  Mat3 R_WB;
  Vec4 q_WB;  // x y z w
  Vec3 v_WB;
  Vec3 a_WB;
  Vec3 w_B;
};

// Where Path::flight stays.
inline const Vec3 kFlightLo{-4.5, -3.5, 0.6}, kFlightHi{4.5, 3.5, 2.6};

struct SteadyMotion {
  double rest_s = 0, ramp_s = 1;  // at rest, then without a jerk to full speed
  Vec3 v_L = Vec3::Zero();        // as seen from the look frame at the start
  double turn_rad_s = 0;          // about the vertical
};

class Path {
 public:
  static Path flight(uint64_t seed, double rest_s, double duration_s, const Mat3& R_LB);
  static Path steady(const SteadyMotion& motion, double duration_s, const Mat3& R_LB);
  static Path along(const Trajectory& trajectory, double duration_s);  // 0: all of it
  // T_WB_at is asked for instants a spacing apart, in order, none below zero.
  static Path through(double duration_s, double spacing_s,
                      const std::function<SE3(double)>& T_WB_at);

  double duration_s() const { return duration_s_; }
  PathState at(double t_s) const;

 private:
  using Knot = Eigen::Matrix<double, 7, 1>;  // p_WB, then q_WB x y z w

  double duration_s_ = 0;
  double spacing_s_ = 0;
  std::vector<Knot> knots_;

  void append(const Vec3& p_WB, Vec4 q_WB);
};

}  // namespace pirvs::tools
