// A pose as autopilots want it: of the vehicle, in frames whose z points down.
// In      A pose of the feed; R_VB: how the IMU sits in the vehicle (mounting()).
// Out     What ODOMETRY and its older kin hold.
// Frames  V: the vehicle, forward, left, up (REP 103). D: the same, forward, right, down. L: W
//         turned over, z down: x_L = x_W, y_L = -y_W, z_L = -z_W. The origin of D is that of B: an
//         autopilot is told where the IMU sits (docs/integration.md).
// Units   m, m/s, rad/s, rad.
// Errors  none.
// Cost    ~1 us.
// Source  docs/conventions.md, "What the link says".
#pragma once

#include "modules/output/pose.h"

namespace pirvs {

struct VehiclePose {
  Vec3 p_LD = Vec3::Zero();
  Mat3 R_LD = Mat3::Identity();
  Vec3 v_LD = Vec3::Zero(), v_D = Vec3::Zero(), w_D = Vec3::Zero();
  // p_LD, then the rotation's error about the axes of L.
  Mat6 cov_pose = Mat6::Zero();
  Mat3 cov_v_LD = Mat3::Zero(), cov_v_D = Mat3::Zero();
};

// R_VB: the IMU's axes are V's, turned by yaw about z, then by pitch about the new y, then by roll.
Mat3 mounting(const Vec3& roll_pitch_yaw_rad);

VehiclePose vehicle_pose(const Pose& pose, const Mat3& R_VB);

// Of R = Rz(yaw) Ry(pitch) Rx(roll).
Vec3 roll_pitch_yaw(const Mat3& R);

// Turns W to L and V to D, and back.
Mat3 turned_over();

}  // namespace pirvs
