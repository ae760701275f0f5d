#include "tools/eval/nees.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/math/so3.h"
#include "tools/sim/random.h"

namespace pirvs::tools {
namespace {

Vec3 normal(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return Vec3(x, y, z);
}

// Truth at 200 Hz along a gentle curve, and its view from a world turned about z and shifted.
struct World {
  Trajectory truth;
  Mat3 R_EW = so3_exp(Vec3(0, 0, 2.4));
  Vec3 p_EW = Vec3(3, -8, 0.5);

  World() {
    truth.full_state = true;
    for (int i = 0; i <= 400; ++i) {
      TrajectoryPose pose;
      pose.t = i * TimeNs{5'000'000};
      pose.t_s = double(pose.t) * 1e-9;
      const double s = pose.t_s;
      pose.p_WB = Vec3(s, 0.3 * s * s, 0.1);
      pose.v_WB = Vec3(1, 0.6 * s, 0);
      pose.q_WB = quat_xyzw(so3_exp(Vec3(0.2, 0.1 * s, -0.3 * s)));
      pose.b_g = Vec3(0.01, -0.02, 0.03 * s);
      pose.b_a = Vec3(0.1 * s, 0.2, -0.1);
      truth.poses.push_back(pose);
    }
  }
  TrajectoryPose in_E(const TrajectoryPose& pose) const {
    TrajectoryPose out = pose;
    out.p_WB = R_EW * pose.p_WB + p_EW;
    out.v_WB = R_EW * pose.v_WB;
    out.q_WB = quat_xyzw(R_EW * rotation_from_quat_xyzw(pose.q_WB));
    return out;
  }
};

// Errors drawn from the covariance that is reported (times `scale`).
std::vector<StateEstimate> noisy(const World& world, double scale) {
  Random random(7, 1);
  std::vector<StateEstimate> out;
  for (size_t i = 40; i <= 400; i += 2) {
    StateEstimate estimate;
    estimate.state = world.in_E(world.truth.poses[i]);
    Mat15 L = Mat15::Zero();
    for (int r = 0; r < 15; ++r) {
      for (int c = 0; c <= r; ++c) L(r, c) = r == c ? 0.02 : 0.01 * random.uniform(-1, 1);
    }
    estimate.cov = L * L.transpose();
    Vec15 unit;
    unit << normal(random), normal(random), normal(random), normal(random), normal(random);
    const Vec15 e = scale * (L * unit);
    const Mat3 R_EB = rotation_from_quat_xyzw(estimate.state.q_WB);
    estimate.state.q_WB = quat_xyzw(R_EB * so3_exp(Vec3(-e.segment<3>(0))));
    estimate.state.p_WB -= e.segment<3>(3);
    estimate.state.v_WB -= e.segment<3>(6);
    estimate.state.b_g -= e.segment<3>(9);
    estimate.state.b_a -= e.segment<3>(12);
    out.push_back(estimate);
  }
  return out;
}

TEST(nees, errors_of_the_reported_size_give_three) {
  const World world;
  const auto estimates = noisy(world, 1.0);
  const Nees nees = evaluate_nees(estimates, world.in_E(world.truth.poses[20]), world.truth);
  ASSERT_TRUE(nees.ok);
  ASSERT_EQ(nees.frames.size(), estimates.size());
  const NeesBand band = nees_band(estimates.size());
  for (int part = 0; part < kNeesParts; ++part) {
    EXPECT_GT(nees.mean[part], band.low) << kNeesNames[part];
    EXPECT_LT(nees.mean[part], band.high) << kNeesNames[part];
  }
}

TEST(nees, errors_twice_the_reported_size_are_outside_the_band) {
  const World world;
  const auto estimates = noisy(world, 2.0);
  const Nees nees = evaluate_nees(estimates, world.in_E(world.truth.poses[20]), world.truth);
  ASSERT_TRUE(nees.ok);
  for (int part = 0; part < kNeesParts; ++part) EXPECT_NEAR(nees.mean[part], 12, 2.5);
}

TEST(nees, place_and_heading_are_forgiven_and_tilt_is_not) {
  const World world;
  std::vector<StateEstimate> exact;
  for (const TrajectoryPose& pose : world.truth.poses) {
    exact.push_back({world.in_E(pose), Mat15::Identity() * 1e-4});
  }
  const Nees good = evaluate_nees(exact, exact.front().state, world.truth);
  ASSERT_TRUE(good.ok);
  for (const double mean : good.mean) EXPECT_LT(mean, 1e-12);

  const Mat3 tilt = so3_exp(Vec3(0.02, 0, 0));
  for (StateEstimate& estimate : exact) {
    estimate.state.q_WB = quat_xyzw(tilt * rotation_from_quat_xyzw(estimate.state.q_WB));
  }
  const Nees tilted = evaluate_nees(exact, exact.front().state, world.truth);
  EXPECT_NEAR(tilted.mean[kNeesAttitude], 4, 0.1);
}

TEST(nees, truth_without_velocity_or_without_the_first_keyframe_is_refused) {
  World world;
  const auto estimates = noisy(world, 1.0);
  TrajectoryPose late = world.in_E(world.truth.poses[20]);
  late.t_s = 99;
  EXPECT_FALSE(evaluate_nees(estimates, late, world.truth).ok);
  world.truth.full_state = false;
  EXPECT_FALSE(evaluate_nees(estimates, world.in_E(world.truth.poses[20]), world.truth).ok);
}

// Quantiles of chi-square from its table: 150 degrees of freedom, 2.5 % and 97.5 %.
TEST(nees, band_is_that_of_chi_square) {
  const NeesBand band = nees_band(50);
  EXPECT_NEAR(band.low, 117.985 / 50, 2e-3);
  EXPECT_NEAR(band.high, 185.800 / 50, 2e-3);
}

}  // namespace
}  // namespace pirvs::tools
