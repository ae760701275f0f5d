#include "modules/mapping/imu_link.h"

#include <gtest/gtest.h>

#include <random>

#include "core/math/so3.h"
#include "modules/state/body_state.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;

Preintegration random_motion(Random& random, const Vec3& b_g, const Vec3& b_a) {
  Preintegration motion;
  motion.reset(b_g, b_a);
  Vec3 w = random.vec(0.5), f = random.vec(1.0) + Vec3(0, 0, 9.81);
  for (int i = 0; i < 60; ++i) {
    const Vec3 w1 = w + random.vec(0.05), f1 = f + random.vec(0.2);
    motion.add(w, f, w1, f1, 0.005, ImuNoise{});
    w = w1;
    f = f1;
  }
  return motion;
}

TEST(preintegration, bias_jacobians_match_numeric) {
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    const Vec3 b_g = random.vec(0.05), b_a = random.vec(0.2);
    const auto at = [&](const Vec3& g, const Vec3& a) {
      Random again(seed + 1000);
      return random_motion(again, g, a);
    };
    const Preintegration motion = at(b_g, b_a);
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Vec3 step = h * Vec3::Unit(k);
      const Preintegration g = at(b_g + step, b_a), a = at(b_g, b_a + step);
      EXPECT_LT((so3_log(motion.dR.transpose() * g.dR) / h - motion.dR_dbg.col(k)).norm(), 1e-5);
      EXPECT_LT(((g.dv - motion.dv) / h - motion.dv_dbg.col(k)).norm(), 1e-4);
      EXPECT_LT(((g.dp - motion.dp) / h - motion.dp_dbg.col(k)).norm(), 1e-4);
      EXPECT_LT(((a.dv - motion.dv) / h - motion.dv_dba.col(k)).norm(), 1e-6);
      EXPECT_LT(((a.dp - motion.dp) / h - motion.dp_dba.col(k)).norm(), 1e-6);
    }
  }
}

// The covariance says how far noisy sums scatter: 400 noisy runs of one motion.
TEST(preintegration, covariance_matches_scatter) {
  ImuNoise noise;
  noise.gyro_noise = 2e-3;
  noise.accel_noise = 2e-2;
  const double dt = 0.005;
  std::mt19937 engine(7);
  std::normal_distribution<double> normal;
  const auto run = [&](bool noisy) {
    Preintegration motion;
    motion.reset(Vec3::Zero(), Vec3::Zero());
    const auto sample = [&](int i, double density, const Vec3& mean) {
      Vec3 out = mean + Vec3(std::sin(0.1 * i), std::cos(0.07 * i), 0.3);
      if (!noisy) return out;
      for (int k = 0; k < 3; ++k) out[k] += density / std::sqrt(dt) * normal(engine);
      return out;
    };
    Vec3 w = sample(0, noise.gyro_noise, Vec3::Zero());
    Vec3 f = sample(0, noise.accel_noise, Vec3(0, 0, 9.81));
    for (int i = 1; i <= 100; ++i) {
      const Vec3 w1 = sample(i, noise.gyro_noise, Vec3::Zero());
      const Vec3 f1 = sample(i, noise.accel_noise, Vec3(0, 0, 9.81));
      motion.add(w, f, w1, f1, dt, noise);
      w = w1;
      f = f1;
    }
    return motion;
  };
  const Preintegration truth = run(false);
  Mat9 scatter = Mat9::Zero();
  const int runs = 400;
  for (int i = 0; i < runs; ++i) {
    const Preintegration m = run(true);
    Vec9 e;
    e << so3_log(truth.dR.transpose() * m.dR), m.dv - truth.dv, m.dp - truth.dp;
    scatter += e * e.transpose() / runs;
  }
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(scatter(k, k) / truth.cov(k, k), 1.0, 0.25) << k;
  EXPECT_NEAR(scatter(3, 6) / truth.cov(3, 6), 1.0, 0.3);
}

TEST(imu_link, jacobians_match_numeric) {
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    BodyState a = random.state();
    const Preintegration motion = random_motion(random, a.b_g, a.b_a);
    a.b_g += random.vec(0.01);  // away from where it was linearized
    a.b_a += random.vec(0.05);
    const Preintegration::Motion m = motion.at(a.b_g, a.b_a);
    BodyState b = a;
    const double dt = motion.dt_s;
    const Vec3 g(0, 0, -kGravity_m_s2);
    b.T_WB.R = a.T_WB.R * m.dR * so3_exp(random.vec(0.02));
    b.T_WB.p = a.T_WB.p + a.v_WB * dt + 0.5 * dt * dt * g + a.T_WB.R * m.dp + random.vec(0.02);
    b.v_WB = a.v_WB + g * dt + a.T_WB.R * m.dv + random.vec(0.02);
    const ImuLink link = make_link(0, 1, motion, ImuNoise{});
    Mat15 J_a, J_b;
    link_jacobians(link, a, b, J_a, J_b);
    const double h = 1e-6;
    for (int k = 0; k < 15; ++k) {
      const Vec15 step = h * Vec15::Unit(k);
      const Vec15 n_a =
          (link_residual(link, boxplus(a, step), b) - link_residual(link, boxplus(a, -step), b)) /
          (2 * h);
      const Vec15 n_b =
          (link_residual(link, a, boxplus(b, step)) - link_residual(link, a, boxplus(b, -step))) /
          (2 * h);
      EXPECT_LT((n_a - J_a.col(k)).norm(), 1e-5) << "seed " << seed << " a " << k;
      EXPECT_LT((n_b - J_b.col(k)).norm(), 1e-5) << "seed " << seed << " b " << k;
    }
  }
}

}  // namespace
}  // namespace pirvs
