// The state of fusion: the paper's [p v psi] on the Earth, and the anchor, which says where SLAM's
// world lies on it. And the moves of both that are no measurement.
// In      state; time steps; how far SLAM may have drifted.
// Out     the changed state and covariance.
// Frames  E: east, north, up. W: SLAM's world, z up as E: the anchor T_EW has four numbers, place
//         and heading. B: IMU. Error order: theta (in B, right), p, v (in E), p_EW (in E), yaw_EW
//         (rad, about the vertical of E: R_EW = Exp(yaw z) R^_EW).
// Units   m, rad, m/s, ns.
// Errors  none.
// Cost    propagate ~2 us, update of N rows ~1 us a row, x86-64; 1.7 kB.
// Source  PIRVS paper, eq. 7; docs/conventions.md, "GNSS"; docs/adr/0017-fusion-anchors-slam.md.
#pragma once

#include "core/base/time.h"
#include "core/math/se3.h"

namespace pirvs {

inline constexpr int kFusionErrors = 13;
inline constexpr double kRateHolds_s = 0.15;
enum : int { kFuseTheta = 0, kFusePos = 3, kFuseVel = 6, kFuseAnchor = 9, kFuseYaw = 12 };

using Vec13 = Eigen::Matrix<double, kFusionErrors, 1>;
using Mat13 = Eigen::Matrix<double, kFusionErrors, kFusionErrors>;

struct FusionState {
  TimeNs t = 0;
  SE3 T_EB;
  Vec3 v_EB = Vec3::Zero();
  // At which the attitude turns on, for kRateHolds_s after it was measured.
  Vec3 w_B = Vec3::Zero();
  TimeNs w_t = 0;
  SE3 T_EW;
  bool placed = false;  // false: nothing is known yet
  // False: the heading is unknown. T_EB.p is then the antenna's, and the attitude says nothing.
  bool anchored = false;
  // The anchor holds for this epoch of SLAM, even if the heading of the body is unknown.
  bool has_anchor = false;
  uint16_t epoch = 0;
  Mat13 cov = Mat13::Zero();
};

// A pose of SLAM as a measurement. sigma: from one frame to the next; what drifts is the anchor's.
struct SlamMeasurement {
  uint16_t epoch = 0;
  SE3 T_WB;
  Vec3 v_WB = Vec3::Zero();
  Vec3 w_B = Vec3::Zero();
  double sigma_rad = 0, sigma_m = 0, sigma_m_s = 0;
};

// A residual, its Jacobian d h / d error, and the covariance of its noise.
template <int N>
struct FusionLinear {
  Eigen::Matrix<double, N, 1> r;
  Eigen::Matrix<double, N, kFusionErrors> H;
  Eigen::Matrix<double, N, N> R;
};

FusionState boxplus(const FusionState& state, const Vec13& delta);
Vec13 boxminus(const FusionState& a, const FusionState& b);

// Eq. 7: velocity and turn rate stay for dt. Noise densities in m/s^2/sqrt(Hz) and rad/sqrt(s).
Mat13 transition(const FusionState& state, double dt_s);
double turning_s(const FusionState& state, double dt_s);  // the part of dt in which w_B holds
void propagate(FusionState& state, TimeNs t, double accel_noise, double turn_noise);

// SLAM's frame walks under the body: it turns about the body's place, which stays where it is.
void let_drift(FusionState& state, double var_horizontal_m2, double var_vertical_m2,
               double var_yaw_rad2);

// The only writer of the covariance by measurements. Returns r' S^-1 r; when it is above `gate`
// nothing changes.
template <int N>
double update(FusionState& state, const FusionLinear<N>& m, double gate);

// The anchor is moved to where body and SLAM agree; its covariance stays. For jumps that are no
// small errors.
void follow_jump(FusionState& state, const SlamMeasurement& slam);
// The anchor follows from where the body is and where SLAM says that it is, and from nothing else.
void anchor_anew(FusionState& state, const SlamMeasurement& slam);
// The body follows from the anchor. cov: of p_EW and yaw_EW.
void place_by_anchor(FusionState& state, const SE3& T_EW, const Eigen::Matrix<double, 4, 4>& cov,
                     const SlamMeasurement& slam);
// The body's heading is lost: what remains is the antenna's place and velocity, and the anchor for
// the case that SLAM finds back.
void forget_heading(FusionState& state, const Vec3& p_BA);

double yaw_variance(const FusionState& state);  // of the body, about the vertical of E

}  // namespace pirvs
