#include "tools/calib/spline.h"

#include <gtest/gtest.h>

#include "core/math/so3.h"
#include "modules/testing.h"
#include "tools/calib/solver.h"

namespace pirvs::tools {
namespace {

struct Knots {
  explicit Knots(uint32_t seed) {
    testing::Random random(seed);
    Mat3 R = so3_exp(random.vec(1.0));
    for (Rotation& knot : rotation) {
      knot = Rotation(R);
      R = R * so3_exp(random.vec(0.2));
    }
  }
  RotationState at(double u, int moved = 0, const Vec3& theta = Vec3::Zero()) const {
    const double* q[kSplineOrder];
    for (int k = 0; k < kSplineOrder; ++k) q[k] = rotation[k].q;
    const Rotation other(rotation[moved].matrix() * so3_exp(theta));
    q[moved] = other.q;
    return rotation_at(q, spline_basis(u, kStep_s), true);
  }
  static constexpr double kStep_s = 0.02;
  Rotation rotation[kSplineOrder];
};

TEST(spline, weights_sum_to_one_and_their_derivatives_to_zero) {
  for (const double u : {0.0, 0.3, 0.99}) {
    const SplineBasis basis = spline_basis(u, 0.01);
    for (int d = 0; d < 3; ++d) {
      EXPECT_NEAR(basis.c[d][0], d == 0 ? 1 : 0, d == 2 ? 1e-9 : 1e-12);
    }
  }
}

TEST(spline, reproduces_a_quintic) {
  // The blossom of t^5: knot k of a uniform spline is the product of five neighbouring parameters.
  const auto knot = [](int k) {
    double product = 1;
    for (int i = -2; i <= 2; ++i) product *= k + i - 2;
    return product;
  };
  for (const double u : {0.0, 0.25, 0.8}) {
    const SplineBasis basis = spline_basis(u, 1);
    double value[3] = {};
    for (int d = 0; d < 3; ++d) {
      for (int k = 0; k < kSplineOrder; ++k) value[d] += basis.b[d][k] * knot(k);
    }
    EXPECT_NEAR(value[0], std::pow(u, 5), 1e-9);
    EXPECT_NEAR(value[1], 5 * std::pow(u, 4), 1e-9);
    EXPECT_NEAR(value[2], 20 * std::pow(u, 3), 1e-9);
  }
}

TEST(spline, rate_is_the_derivative_of_rotation) {
  constexpr double kStep = 1e-5;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    const Knots knots(seed);
    const RotationState state = knots.at(0.4);
    const Vec3 turned =
        so3_log(knots.at(0.4 - kStep).R_TB.transpose() * knots.at(0.4 + kStep).R_TB);
    const Vec3 numeric = turned / (2 * kStep * Knots::kStep_s);
    EXPECT_LT((numeric - state.w_B).norm(), 1e-5 * (1 + state.w_B.norm())) << seed;
  }
}

TEST(spline, derivatives_by_knots_match_numeric) {
  constexpr double kStep = 1e-6;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    const Knots knots(seed);
    const double u = 0.05 * seed - 0.03;
    const RotationState state = knots.at(u);
    for (int k = 0; k < kSplineOrder; ++k) {
      for (int i = 0; i < 3; ++i) {
        const RotationState a = knots.at(u, k, -kStep * Vec3::Unit(i));
        const RotationState b = knots.at(u, k, kStep * Vec3::Unit(i));
        const Vec3 dR = so3_log(a.R_TB.transpose() * b.R_TB) / (2 * kStep);
        const Vec3 dw = (b.w_B - a.w_B) / (2 * kStep);
        EXPECT_LT((dR - state.dR[k].col(i)).norm(), 1e-7) << seed << " knot " << k;
        EXPECT_LT((dw - state.dw[k].col(i)).norm(), 1e-5 * (1 + dw.norm())) << seed << " " << k;
      }
    }
  }
}

}  // namespace
}  // namespace pirvs::tools
