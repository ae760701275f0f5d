#include "modules/fusion/fusion_state.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "modules/fusion/mm_gnss.h"
#include "modules/fusion/mm_slam.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;

FusionState random_state(Random& random) {
  FusionState out;
  out.T_EB = {so3_exp(random.vec(1.0)), random.vec(20.0)};
  out.v_EB = random.vec(2.0);
  out.w_B = random.vec(0.5);
  out.T_EW = {so3_exp(Vec3(0, 0, random.uniform(-3, 3))), random.vec(20.0)};
  out.placed = out.anchored = out.has_anchor = true;
  out.cov = random.spd<kFusionErrors>(0.1);
  return out;
}

Vec13 random_error(Random& random, double sigma) {
  Vec13 out;
  for (int i = 0; i < kFusionErrors; ++i) out[i] = random.gauss(sigma);
  return out;
}

SlamMeasurement random_slam(Random& random) {
  SlamMeasurement out;
  out.T_WB = {so3_exp(random.vec(1.0)), random.vec(10.0)};
  out.v_WB = random.vec(2.0);
  out.w_B = random.vec(0.5);
  out.sigma_rad = 0.01, out.sigma_m = 0.02, out.sigma_m_s = 0.05;
  return out;
}

// Where SLAM says that the body is, if it is there and SLAM's frame too, plus a little.
SlamMeasurement expected_slam(const FusionState& state, Random& random) {
  SlamMeasurement out = random_slam(random);
  out.T_WB = state.T_EW.inverse() * state.T_EB;
  out.T_WB.R = out.T_WB.R * so3_exp(random.vec(1e-3));
  out.v_WB = state.T_EW.R.transpose() * state.v_EB;
  return out;
}

constexpr double kStep = 1e-6;

TEST(fusion_state, boxminus_undoes_boxplus) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const FusionState at = random_state(random);
    const Vec13 delta = random_error(random, 0.3);
    EXPECT_LT((boxminus(boxplus(at, delta), at) - delta).norm(), 1e-9) << seed;
  }
}

TEST(fusion_state, transition_of_equation_7_matches_numeric) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const FusionState at = random_state(random);
    const double dt = random.uniform(0.01, 0.3);
    const Mat13 F = transition(at, dt);
    const auto moved = [&](const Vec13& delta) {
      FusionState out = boxplus(at, delta);
      propagate(out, out.t + from_seconds(dt), 0, 0);
      return out;
    };
    const FusionState to = moved(Vec13::Zero());
    for (int k = 0; k < kFusionErrors; ++k) {
      const Vec13 step = kStep * Vec13::Unit(k);
      const Vec13 numeric = (boxminus(moved(step), to) - boxminus(moved(-step), to)) / (2 * kStep);
      EXPECT_LT((numeric - F.col(k)).norm(), 1e-6) << "seed " << seed << " " << k;
    }
  }
}

TEST(fusion_state, noise_of_equation_7_does_not_depend_on_the_steps) {
  Random random(3);
  FusionState once = random_state(random);
  once.w_B.setZero();
  FusionState often = once;
  propagate(once, once.t + 400'000'000, 2.0, 0.1);
  for (int i = 0; i < 8; ++i) propagate(often, often.t + 50'000'000, 2.0, 0.1);
  EXPECT_LT((once.cov - often.cov).norm(), 1e-9 * once.cov.norm());
}

TEST(mm_slam, jacobian_of_equation_8_matches_numeric) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const FusionState at = random_state(random);
    const SlamMeasurement z = expected_slam(at, random);
    const FusionLinear<9> m = linearize_slam(at, z);
    for (int k = 0; k < kFusionErrors; ++k) {
      const Vec13 step = kStep * Vec13::Unit(k);
      // H is that of the prediction: the residual goes the other way.
      const Vec9 numeric =
          -(linearize_slam(boxplus(at, step), z).r - linearize_slam(boxplus(at, -step), z).r) /
          (2 * kStep);
      // The attitude's residual is small, not zero: its logarithm's derivative is one to that.
      EXPECT_LT((numeric - m.H.col(k)).norm(), 5e-3) << "seed " << seed << " " << k;
      EXPECT_LT((numeric - m.H.col(k)).tail<6>().norm(), 1e-6) << "seed " << seed << " " << k;
    }
  }
}

TEST(mm_gnss, jacobians_of_equation_9_match_numeric) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const FusionState at = random_state(random);
    const Vec3 p_BA = random.vec(0.5), z = random.vec(5.0), variance(1, 1, 4);
    const FusionLinear<3> place = linearize_gnss_position(at, p_BA, z, variance);
    const FusionLinear<3> speed = linearize_gnss_velocity(at, p_BA, z, variance);
    for (int k = 0; k < kFusionErrors; ++k) {
      const FusionState plus = boxplus(at, kStep * Vec13::Unit(k));
      const FusionState minus = boxplus(at, -kStep * Vec13::Unit(k));
      const Vec3 numeric_p = -(linearize_gnss_position(plus, p_BA, z, variance).r -
                               linearize_gnss_position(minus, p_BA, z, variance).r) /
                             (2 * kStep);
      const Vec3 numeric_v = -(linearize_gnss_velocity(plus, p_BA, z, variance).r -
                               linearize_gnss_velocity(minus, p_BA, z, variance).r) /
                             (2 * kStep);
      EXPECT_LT((numeric_p - place.H.col(k)).norm(), 1e-6) << "seed " << seed << " " << k;
      EXPECT_LT((numeric_v - speed.H.col(k)).norm(), 1e-6) << "seed " << seed << " " << k;
    }
  }
}

TEST(fusion_state, update_moves_to_the_measurement_and_is_gated) {
  Random random(5);
  FusionState state = random_state(random);
  const Vec3 truth = state.T_EB.p + Vec3(0.1, -0.1, 0.2), sure = Vec3::Constant(1e-8);
  FusionState far = state;
  const FusionLinear<3> wild =
      linearize_gnss_position(far, Vec3::Zero(), truth + Vec3(30, 0, 0), sure);
  EXPECT_GT(update(far, wild, 16.0), 16.0);
  EXPECT_EQ(far.T_EB.p, state.T_EB.p);
  EXPECT_EQ(far.cov, state.cov);
  EXPECT_LT(update(state, linearize_gnss_position(state, Vec3::Zero(), truth, sure), 16.0), 16.0);
  EXPECT_LT((state.T_EB.p - truth).norm(), 1e-4);
  EXPECT_LT((state.cov.block<3, 3>(kFusePos, kFusePos).norm()), 1e-7);
}

// The covariance of the anchor that follows from the body, against a cloud of states.
TEST(fusion_state, anchoring_anew_has_the_covariance_of_a_sample) {
  Random random(11);
  FusionState mean = random_state(random);
  mean.cov *= 1e-3;
  const Mat13 root = mean.cov.llt().matrixL();
  const SlamMeasurement slam = expected_slam(mean, random);
  FusionState found = mean;
  anchor_anew(found, slam);
  Mat13 sample = Mat13::Zero();
  constexpr int kDraws = 2000;
  for (int i = 0; i < kDraws; ++i) {
    FusionState drawn = boxplus(mean, root * random_error(random, 1));
    SlamMeasurement seen = slam;
    seen.T_WB.R = slam.T_WB.R * so3_exp(random.vec(slam.sigma_rad));
    seen.T_WB.p += random.vec(slam.sigma_m);
    anchor_anew(drawn, seen);
    const Vec13 e = boxminus(drawn, found);
    sample += e * e.transpose() / kDraws;
  }
  EXPECT_LT((sample - found.cov).norm(), 0.15 * found.cov.norm());
  EXPECT_LT((found.T_EW * slam.T_WB).p.x() - found.T_EB.p.x(), 1e-9);
}

TEST(fusion_state, placing_by_the_anchor_has_the_covariance_of_a_sample) {
  Random random(12);
  const SlamMeasurement slam = random_slam(random);
  const SE3 T_EW = {so3_exp(Vec3(0, 0, 1.1)), Vec3(3, -8, 1)};
  const Eigen::Matrix<double, 4, 4> cov = random.spd<4>(1e-3);
  const Eigen::Matrix<double, 4, 4> root = cov.llt().matrixL();
  FusionState found;
  place_by_anchor(found, T_EW, cov, slam);
  Mat13 sample = Mat13::Zero();
  constexpr int kDraws = 2000;
  for (int i = 0; i < kDraws; ++i) {
    Vec4 e;
    for (int k = 0; k < 4; ++k) e[k] = random.gauss(1);
    e = (root * e).eval();
    SlamMeasurement seen = slam;
    seen.T_WB.R = slam.T_WB.R * so3_exp(random.vec(slam.sigma_rad));
    seen.T_WB.p += random.vec(slam.sigma_m);
    seen.v_WB += random.vec(slam.sigma_m_s);
    FusionState drawn;
    place_by_anchor(drawn, {so3_exp(Vec3(0, 0, e[3])) * T_EW.R, T_EW.p + e.head<3>()}, cov, seen);
    const Vec13 error = boxminus(drawn, found);
    sample += error * error.transpose() / kDraws;
  }
  EXPECT_LT((sample - found.cov).norm(), 0.15 * found.cov.norm());
}

TEST(fusion_state, drift_leaves_the_body_where_it_is) {
  Random random(13);
  FusionState state = random_state(random);
  const Mat9 before = state.cov.topLeftCorner<9, 9>();
  const SlamMeasurement slam = expected_slam(state, random);
  const Mat9 S0 =
      linearize_slam(state, slam).H * state.cov * linearize_slam(state, slam).H.transpose();
  let_drift(state, 0, 0, 0.01);
  const Mat9 S1 =
      linearize_slam(state, slam).H * state.cov * linearize_slam(state, slam).H.transpose();
  EXPECT_EQ((state.cov.topLeftCorner<9, 9>()), before);
  // Seen in W the body stays, too: only what is about it turns.
  EXPECT_LT(((S1 - S0).block<3, 3>(3, 3).norm()), 1e-9);
  EXPECT_GT(((S1 - S0).block<3, 3>(0, 0).norm()), 0.005);
}

TEST(fusion_state, forgetting_the_heading_leaves_the_antenna) {
  Random random(14);
  FusionState state = random_state(random);
  const Vec3 p_BA(0.3, 0.1, 0.8), p_EA = state.T_EB * p_BA;
  forget_heading(state, p_BA);
  EXPECT_FALSE(state.anchored);
  EXPECT_TRUE(state.has_anchor);
  EXPECT_LT((state.T_EB.p - p_EA).norm(), 1e-12);
  EXPECT_EQ((state.cov.block<9, 4>(0, kFuseAnchor).norm()), 0);
}

}  // namespace
}  // namespace pirvs
