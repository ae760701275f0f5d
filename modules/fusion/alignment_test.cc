#include "modules/fusion/alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "core/math/trig.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;

constexpr TimeNs kSecond = 1'000'000'000;
constexpr double kDeg = kPi / 180;

struct Receiver {
  double rate_hz = 1, sigma_m = 1.5, sigma_m_s = 0;  // 0: no velocity
};

double yaw_of(const SE3& T) { return arctan2(T.R(1, 0), T.R(0, 0)); }

std::vector<AlignmentPair> pairs_along(const std::function<Vec3(double)>& p_W_at, double length_s,
                                       const Receiver& receiver, const SE3& T_EW, Random& random) {
  std::vector<AlignmentPair> out;
  for (double t = 0; t <= length_s + 1e-9; t += 1 / receiver.rate_hz) {
    AlignmentPair pair;
    pair.t = from_seconds(t);
    pair.p_W = p_W_at(t);
    pair.p_E = T_EW * pair.p_W + random.vec(receiver.sigma_m);
    pair.var_horizontal_m2 = pair.var_vertical_m2 = receiver.sigma_m * receiver.sigma_m;
    pair.v_W = (p_W_at(t + 1e-4) - p_W_at(t - 1e-4)) / 2e-4;
    if (receiver.sigma_m_s > 0) {
      pair.v_E = T_EW.R * pair.v_W + random.vec(receiver.sigma_m_s);
      pair.var_velocity_m2_s2 = receiver.sigma_m_s * receiver.sigma_m_s;
    }
    out.push_back(pair);
  }
  return out;
}

AlignmentWindow window_of(const std::vector<AlignmentPair>& pairs) {
  AlignmentWindow window;
  window.configure(120 * kSecond);
  for (const AlignmentPair& pair : pairs) window.add(pair);
  return window;
}

// Wahba's cost at one heading, with the best place for it.
double cost_at(const std::vector<AlignmentPair>& pairs, double yaw) {
  const Mat3 R = so3_exp(Vec3(0, 0, yaw));
  Vec3 sum = Vec3::Zero();
  double weights = 0;
  for (const AlignmentPair& pair : pairs) {
    sum += (pair.p_E - R * pair.p_W) / pair.var_horizontal_m2;
    weights += 1 / pair.var_horizontal_m2;
  }
  double cost = 0;
  for (const AlignmentPair& pair : pairs) {
    const Vec3 r = pair.p_E - R * pair.p_W - sum / weights;
    cost += r.head<2>().squaredNorm() / pair.var_horizontal_m2;
    if (pair.var_velocity_m2_s2 > 0) {
      cost += (pair.v_E - R * pair.v_W).head<2>().squaredNorm() / pair.var_velocity_m2_s2;
    }
  }
  return cost;
}

Vec3 turning(double t) {  // 20 m in 20 s: a straight half, then an arc of a right angle
  if (t < 10) return {t, 0, 0.1 * t};
  const double radius = 10 / (kPi / 2), angle = (t - 10) / radius;
  return {10 + radius * std::sin(angle), radius * (1 - std::cos(angle)), 1};
}

TEST(alignment, heading_is_that_of_a_brute_force_search) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const SE3 T_EW = {so3_exp(Vec3(0, 0, random.uniform(-3, 3))), random.vec(50)};
    const Receiver receiver = {2, 1.5, seed % 2 == 0 ? 0.1 : 0.0};
    const auto pairs = pairs_along(turning, 20, receiver, T_EW, random);
    Alignment found;
    ASSERT_EQ(window_of(pairs).solve(found), Status::kOk);
    ASSERT_EQ(found.left_out, 0);
    double best = 0;
    for (double step = 0.02, from = -kPi, to = kPi; step > 1e-6; step /= 20) {
      double least = HUGE_VAL;
      for (double yaw = from; yaw < to; yaw += step) {
        const double cost = cost_at(pairs, yaw);
        if (cost < least) least = cost, best = yaw;
      }
      from = best - step, to = best + step;
    }
    const double apart = std::remainder(best - yaw_of(found.T_EW), 2 * kPi);
    EXPECT_LT(std::abs(apart), 1e-5) << seed;
  }
}

TEST(alignment, covariance_is_that_of_many_draws) {
  Random random(2);
  const SE3 T_EW = {so3_exp(Vec3(0, 0, 0.7)), Vec3(100, -50, 3)};
  constexpr int kDraws = 500;
  Eigen::Matrix<double, 4, 4> sample = Eigen::Matrix<double, 4, 4>::Zero();
  Eigen::Matrix<double, 4, 4> told = Eigen::Matrix<double, 4, 4>::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const auto pairs = pairs_along(turning, 20, {5, 1.0, 0.2}, T_EW, random);
    Alignment found;
    ASSERT_EQ(window_of(pairs).solve(found), Status::kOk);
    Vec4 e;
    e << found.T_EW.p - T_EW.p, yaw_of(found.T_EW) - 0.7;
    sample += e * e.transpose() / kDraws;
    told += found.cov / kDraws;
  }
  // The scale by the misfit is never below one: the mean is a little large.
  EXPECT_LT((sample - told).norm(), 0.25 * told.norm());
  EXPECT_GT(told(3, 3), 0.8 * sample(3, 3));
}

TEST(alignment, hover_and_a_short_line_do_not_show_the_heading) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const SE3 T_EW = {so3_exp(Vec3(0, 0, 2)), Vec3(1, 2, 3)};
    const auto hover = [](double t) { return Vec3(0.1 * std::sin(t), 0.1 * std::cos(0.7 * t), 1); };
    const auto line = [](double t) { return Vec3(std::min(0.5 * t, 2.0), 0, 1); };
    for (const auto& path :
         {std::function<Vec3(double)>(hover), std::function<Vec3(double)>(line)}) {
      Alignment found;
      ASSERT_EQ(window_of(pairs_along(path, 60, {5, 1.5, 0}, T_EW, random)).solve(found),
                Status::kOk);
      EXPECT_GT(found.sigma_yaw_rad, 4 * kDeg);
      EXPECT_LT(found.span_m, 3.0);
    }
  }
}

TEST(alignment, twenty_metres_with_a_turn_show_the_heading) {
  int good = 0;
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const SE3 T_EW = {so3_exp(Vec3(0, 0, random.uniform(-3, 3))), random.vec(50)};
    Alignment found;
    const auto pairs = pairs_along(turning, 20, {1, 1.5, 0.05}, T_EW, random);
    ASSERT_EQ(window_of(pairs).solve(found), Status::kOk);
    const double error = so3_log(T_EW.R.transpose() * found.T_EW.R).norm();
    EXPECT_LT(error, 4 * found.sigma_yaw_rad) << seed;
    EXPECT_LT(found.sigma_yaw_rad, 2 * kDeg);
    good += error < 2 * kDeg ? 1 : 0;
  }
  EXPECT_EQ(good, 50);
}

TEST(alignment, a_stretch_of_multipath_is_left_out) {
  Random random(4);
  const SE3 T_EW = {so3_exp(Vec3(0, 0, -1)), Vec3(10, 20, 3)};
  auto pairs = pairs_along(turning, 20, {5, 0.5, 0}, T_EW, random);
  for (AlignmentPair& pair : pairs) {
    if (pair.t > 4 * kSecond && pair.t < 9 * kSecond) pair.p_E += Vec3(25, -15, 5);
  }
  Alignment found;
  ASSERT_EQ(window_of(pairs).solve(found), Status::kOk);
  EXPECT_GT(found.left_out, 20);
  EXPECT_LT(so3_log(T_EW.R.transpose() * found.T_EW.R).norm(), 2 * kDeg);
  EXPECT_LT(found.misfit, 1.3);
}

TEST(alignment, a_receiver_that_claims_too_much_is_found_out) {
  Random random(6);
  const SE3 T_EW = {so3_exp(Vec3(0, 0, -1)), Vec3(10, 20, 3)};
  auto pairs = pairs_along(turning, 20, {5, 1.0, 0}, T_EW, random);
  for (AlignmentPair& pair : pairs) pair.var_horizontal_m2 = pair.var_vertical_m2 = 1e-4;
  Alignment found;
  ASSERT_EQ(window_of(pairs).solve(found), Status::kOk);
  EXPECT_GT(found.misfit, 50);
  EXPECT_GT(found.sigma_yaw_rad, 0.5 * kDeg);
}

TEST(alignment, old_pairs_are_forgotten) {
  Random random(7);
  AlignmentWindow window;
  window.configure(60 * kSecond);
  EXPECT_EQ(window.span(), 0);
  const SE3 first, second = {so3_exp(Vec3(0, 0, 1.5)), Vec3(50, 0, 0)};
  for (AlignmentPair pair : pairs_along(turning, 20, {5, 0.1, 0}, first, random)) window.add(pair);
  for (AlignmentPair pair : pairs_along(turning, 20, {5, 0.1, 0}, second, random)) {
    pair.t += 70 * kSecond;
    window.add(pair);
  }
  Alignment found;
  ASSERT_EQ(window.solve(found), Status::kOk);
  EXPECT_LT((found.T_EW.p - second.p).norm(), 1);
  EXPECT_LE(window.span(), 60 * kSecond);
}

// At rest fixes can be averaged whatever the heading is; far from where they were it matters.
TEST(alignment, a_place_is_known_before_the_heading) {
  const SE3 T_EW = {so3_exp(Vec3(0, 0, 2)), Vec3(10, -20, 3)};
  const auto rest = [](double) { return Vec3(1, 2, 3); };
  double nees = 0, sum2 = 0;
  constexpr int kDraws = 100;
  for (uint32_t seed = 1; seed <= kDraws; ++seed) {
    Random random(seed);
    const AlignmentWindow window = window_of(pairs_along(rest, 24, {1, 1.5, 0}, T_EW, random));
    Vec3 p_E;
    Mat3 cov;
    ASSERT_EQ(window.locate(Vec3(1, 2, 3), p_E, cov), Status::kOk);
    const Vec3 e = p_E - T_EW * Vec3(1, 2, 3);
    sum2 += e.squaredNorm() / kDraws;
    nees += (e.array().square() / cov.diagonal().array()).sum() / kDraws;
    ASSERT_EQ(window.locate(Vec3(6, 2, 3), p_E, cov), Status::kOk);
    EXPECT_GT(cov(0, 0), 20) << "5 m away in an unknown direction";
  }
  EXPECT_LT(std::sqrt(sum2), 0.6);
  EXPECT_GT(nees, 2.2);
  EXPECT_LT(nees, 3.6);
  AlignmentWindow none;
  none.configure(kSecond);
  Vec3 p_E;
  Mat3 cov;
  EXPECT_EQ(none.locate(Vec3::Zero(), p_E, cov), Status::kEmpty);
}

TEST(alignment, a_few_pairs_are_none) {
  Random random(8);
  AlignmentWindow window = window_of(pairs_along(turning, 3, {1, 0.1, 0}, SE3{}, random));
  Alignment found;
  EXPECT_EQ(window.solve(found), Status::kEmpty);
}

}  // namespace
}  // namespace pirvs
