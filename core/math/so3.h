// Rotations: exponential, logarithm, right Jacobians, quaternions.
// In      Rotation vectors in rad (any length for so3_exp; < 2 pi for right_jacobian_inverse);
//         rotation matrices orthonormal to about 1e-6.
// Out     so3_exp(so3_log(R)) = R. so3_log has length <= pi.
//         so3_exp(a + d) = so3_exp(a) so3_exp(right_jacobian(a) d) + O(d^2).
// Frames  R_AB takes B coordinates to A; quaternions are x y z w of the same map, w >= 0.
// Errors  none; a zero quaternion is a bug and asserts.
// Cost    so3_exp 14 ns below 0.2 rad (series: no loss of digits at zero), 24 ns above; so3_log
//         28 ns: x86-64 at 2.1 GHz (make bench K=so3).
// Source  Forster et al., "On-Manifold Preintegration", TRO 2017, eq. (3), (8), (9);
//         Shepperd, "Quaternion from Rotation Matrix", 1978.
#pragma once

#include "core/math/types.h"

namespace pirvs {

Mat3 skew(const Vec3& a);  // skew(a) b = a x b
Mat3 so3_exp(const Vec3& phi);
Vec3 so3_log(const Mat3& R);
Mat3 right_jacobian(const Vec3& phi);
Mat3 right_jacobian_inverse(const Vec3& phi);
Mat3 orthonormalized(const Mat3& R);  // a rotation within about the deviation of R from one
Vec4 quat_xyzw(const Mat3& R);
Mat3 rotation_from_quat_xyzw(const Vec4& q);  // q need not be normalized

}  // namespace pirvs
