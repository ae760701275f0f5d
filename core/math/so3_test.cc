#include "core/math/so3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/math/se3.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

// A direction uniform in the cube, times an angle that visits zero, small, usual and nearly pi.
Vec3 random_rotation_vector(uint32_t seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Vec3 axis(uniform(rng), uniform(rng), uniform(rng));
  const double angles[] = {0.0, 1e-9, 1e-4, 0.19, 0.21, 1.0, 2.5, kPi - 1e-6};
  return axis.normalized() * angles[seed % 8];
}

TEST(So3, ExpOfLogIsTheRotation) {
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    const Vec3 phi = random_rotation_vector(seed);
    const Mat3 R = so3_exp(phi);
    EXPECT_LT((R * R.transpose() - Mat3::Identity()).norm(), 2e-15);
    EXPECT_NEAR((skew(phi) * phi).norm(), 0.0, 1e-15);
    EXPECT_LT((so3_log(R) - phi).norm(), 3e-15 + 1e-15 * phi.norm()) << seed;
    EXPECT_LT((so3_exp(so3_log(R)) - R).norm(), 3e-15);
  }
}

TEST(So3, LogAtPiHasLengthPi) {
  for (int i = 0; i < 3; ++i) {
    const Mat3 R = Vec3::Unit(i).asDiagonal().toDenseMatrix() * 2.0 - Mat3::Identity();
    EXPECT_NEAR(so3_log(R).norm(), kPi, 1e-15);
    EXPECT_LT((so3_exp(so3_log(R)) - R).norm(), 1e-15);
  }
}

Vec3 right_difference(const Mat3& R, const Vec3& phi) {
  return so3_log(R.transpose() * so3_exp(phi));
}

TEST(So3, RightJacobianMatchesNumeric) {
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    const Vec3 phi = random_rotation_vector(seed);
    const Mat3 R = so3_exp(phi);
    const Mat3 J = right_jacobian(phi);
    constexpr double kStep = 1e-5;
    for (int i = 0; i < 3; ++i) {
      const Vec3 step = kStep * Vec3::Unit(i);
      const Vec3 difference = right_difference(R, phi + step) - right_difference(R, phi - step);
      EXPECT_LT((J.col(i) - difference / (2.0 * kStep)).norm(), 1e-9) << seed;
    }
  }
}

TEST(So3, RightJacobianTimesItsInverseIsIdentity) {
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    const Vec3 phi = random_rotation_vector(seed);
    const Mat3 product = right_jacobian_inverse(phi) * right_jacobian(phi);
    EXPECT_LT((product - Mat3::Identity()).norm(), 1e-13) << seed;
  }
}

TEST(So3, SeriesMeetTheClosedForms) {
  const Vec3 axis = Vec3(1.0, -2.0, 3.0).normalized();
  const Vec3 below = axis * (0.2 - 1e-12), above = axis * (0.2 + 1e-12);
  EXPECT_LT((so3_exp(below) - so3_exp(above)).norm(), 4e-12);
  EXPECT_LT((right_jacobian(below) - right_jacobian(above)).norm(), 2e-12);
  EXPECT_LT((right_jacobian_inverse(below) - right_jacobian_inverse(above)).norm(), 2e-12);
}

TEST(So3, QuaternionsRoundTrip) {
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    const Mat3 R = so3_exp(random_rotation_vector(seed));
    const Vec4 q = quat_xyzw(R);
    EXPECT_NEAR(q.norm(), 1.0, 1e-15);
    EXPECT_GE(q.w(), 0.0);
    EXPECT_LT((rotation_from_quat_xyzw(3.0 * q) - R).norm(), 2e-15);
  }
  const Vec4 quarter_turn_z(0.0, 0.0, std::sqrt(0.5), std::sqrt(0.5));
  EXPECT_LT((rotation_from_quat_xyzw(quarter_turn_z) * Vec3::UnitX() - Vec3::UnitY()).norm(),
            1e-15);
}

TEST(So3, OrthonormalizedRemovesDrift) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> noise(-1e-6, 1e-6);
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    const Mat3 R = so3_exp(random_rotation_vector(seed));
    Mat3 drifted = R;
    for (double& entry : drifted.reshaped()) entry += noise(rng);
    const Mat3 clean = orthonormalized(drifted);
    EXPECT_LT((clean * clean.transpose() - Mat3::Identity()).norm(), 2e-15);
    EXPECT_LT((clean - R).norm(), 1e-5);
  }
}

TEST(Se3, ComposesAndInverts) {
  const SE3 T_AB{so3_exp(Vec3(0.3, -0.2, 1.1)), Vec3(1.0, 2.0, 3.0)};
  const SE3 T_BC{so3_exp(Vec3(-1.3, 0.7, 0.4)), Vec3(-4.0, 0.5, 2.0)};
  const Vec3 p_C(0.1, -0.7, 5.0);
  EXPECT_LT(((T_AB * T_BC) * p_C - T_AB * (T_BC * p_C)).norm(), 1e-14);
  EXPECT_LT((T_AB.inverse() * (T_AB * p_C) - p_C).norm(), 1e-14);
}

}  // namespace
}  // namespace pirvs
