// Rigid transform: rotation, then translation.
// In      T_AB = {R_AB, p_AB}.
// Out     T_AB * p_BX = p_AX, T_AB * T_BC = T_AC, T_AB.inverse() = T_BA.
// Frames  Takes B coordinates to A; p_AB is the position of B in A, metres.
// Errors  none; R stays as orthonormal as its factors (see orthonormalized in so3.h).
// Cost    36 multiplications for a product, 9 for a point.
// Source  DESIGN, "Frames, units, names".
#pragma once

#include "core/math/types.h"

namespace pirvs {

struct SE3 {
  Mat3 R = Mat3::Identity();
  Vec3 p = Vec3::Zero();

  SE3 operator*(const SE3& other) const { return {R * other.R, p + R * other.p}; }
  Vec3 operator*(const Vec3& point) const { return p + R * point; }
  SE3 inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

}  // namespace pirvs
