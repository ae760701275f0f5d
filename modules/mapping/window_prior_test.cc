#include "modules/mapping/window_prior.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "core/math/so3.h"
#include "modules/state/body_state.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Sway;

using Mat30 = Eigen::Matrix<double, 30, 30>;
using Vec30 = Eigen::Matrix<double, 30, 1>;

struct Case {
  explicit Case(uint32_t seed) : random(seed) {
    a = sway.state(0.2);
    b = sway.state(0.5);
    motion = sway.between(0.2, 0.5, noise);
    prior = start_prior(7, a, params);
  }
  WindowPrior advanced() const {
    const Motions motions{&motion, nullptr};
    return advance(prior, a, 8, b, &motions, vision, noise, params);
  }
  Random random;
  Sway sway;
  ImuNoise noise;
  MappingParams params;
  BodyState a, b;
  Preintegration motion;
  WindowPrior prior;
  Mat6 vision = guessed_vision();
};

Mat15 numeric(const ImuLink& link, const BodyState& a, const BodyState& b, bool to_a) {
  Mat15 J;
  const double h = 1e-6;
  for (int k = 0; k < 15; ++k) {
    const Vec15 e = h * Vec15::Unit(k);
    J.col(k) =
        to_a ? (link_residual(link, boxplus(a, e), b) - link_residual(link, boxplus(a, -e), b)) /
                   (2 * h)
             : (link_residual(link, a, boxplus(b, e)) - link_residual(link, a, boxplus(b, -e))) /
                   (2 * h);
  }
  return J;
}

// Vision's relative pose of b in a: theta in b, p in a.
Vec6 relative(const BodyState& a, const BodyState& b, const BodyState& a0, const BodyState& b0) {
  Vec6 r;
  const Mat3 dR0 = a0.T_WB.R.transpose() * b0.T_WB.R;
  r.head<3>() = so3_log(dR0.transpose() * a.T_WB.R.transpose() * b.T_WB.R);
  r.tail<3>() = a.T_WB.R.transpose() * (b.T_WB.p - a.T_WB.p) -
                a0.T_WB.R.transpose() * (b0.T_WB.p - a0.T_WB.p);
  return r;
}

// The information of the pair (a, b), built from numeric derivatives alone.
struct BruteForce {
  Mat30 H = Mat30::Zero();
  Vec30 g = Vec30::Zero();

  explicit BruteForce(const Case& c) {
    H.topLeftCorner<15, 15>() = c.prior.information;
    g.head<15>() = c.prior.gradient - c.prior.information * boxminus(c.a, c.prior.mean);
    const ImuLink link = make_link(0, 1, c.motion, c.noise);
    Eigen::Matrix<double, 15, 30> J;
    J << numeric(link, c.a, c.b, true), numeric(link, c.a, c.b, false);
    Mat15 W = Mat15::Zero();
    W.topLeftCorner<9, 9>() = link.information;
    W.diagonal().segment<3>(9).setConstant(link.walk_g);
    W.diagonal().segment<3>(12).setConstant(link.walk_a);
    H += J.transpose() * W * J;
    g -= J.transpose() * (W * link_residual(link, c.a, c.b));
    add_vision(c);
  }

  // Vision's pull balances the rest at a's pose, and acts on b with the opposite force.
  void add_vision(const Case& c) {
    Eigen::Matrix<double, 6, 30> J;
    const double h = 1e-6;
    for (int k = 0; k < 30; ++k) {
      const auto at = [&](double step) {
        const Vec15 e = step * Vec15::Unit(k % 15);
        return k < 15 ? relative(boxplus(c.a, e), c.b, c.a, c.b)
                      : relative(c.a, boxplus(c.b, e), c.a, c.b);
      };
      J.col(k) = (at(h) - at(-h)) / (2 * h);
    }
    const Mat6 J_a = J.leftCols<6>();
    const Mat6 from_r = J_a.fullPivLu().inverse();
    const Mat6 W = from_r.transpose() * c.vision * from_r + Mat6::Identity();
    H += J.transpose() * W * J;
    const Vec6 pull = J_a.transpose().eval().fullPivLu().solve(g.head<6>());
    g -= J.transpose() * pull;
  }

  // What is left of b when a may be anywhere: through the covariance, not through Schur.
  void marginal(Mat15& information, Vec15& gradient) const {
    const Eigen::FullPivLU<Mat30> solver(H);
    const Mat30 cov = solver.inverse();
    information = cov.bottomRightCorner<15, 15>().inverse();
    const Vec15 x_b = solver.solve(g).tail<15>();
    gradient = information * x_b;
  }
};

// Compares in units of each error's own sigma, since the entries span fifteen decades.
double scaled_difference(const Mat15& A, const Mat15& B, const Mat15& units) {
  const Vec15 scale = units.diagonal().cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (A - B) * scale.asDiagonal()).norm();
}

// What vision and the IMU cannot see: a turn about gravity (velocity turns along) and a shift.
using Gauge = Eigen::Matrix<double, 15, 4>;
Gauge gauge_of(const BodyState& state) {
  Gauge U;
  const double h = 1e-6;
  for (int k = 0; k < 4; ++k) {
    const auto moved = [&](double step) {
      BodyState s = state;
      const Mat3 turn = so3_exp(k == 0 ? Vec3(0, 0, step) : Vec3(0, 0, 0));
      s.T_WB.R = turn * s.T_WB.R;
      s.v_WB = turn * s.v_WB;
      if (k > 0) s.T_WB.p[k - 1] += step;
      return s;
    };
    U.col(k) = boxminus(moved(h), moved(-h)) / (2 * h);
  }
  return U;
}

TEST(window_prior, advance_equals_brute_force_marginalization) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    Case c(seed);
    c.params.anchor_sigma_rad = c.params.anchor_sigma_m = 1e6;  // no anchor
    c.prior.information = c.random.spd<15>(1e3);
    c.prior.gradient = c.random.vec15(3.0);
    c.vision = c.random.spd<6>(1e5);
    c.a = boxplus(c.a, c.random.vec15(1e-3));
    c.b = boxplus(c.b, c.random.vec15(1e-3));
    const WindowPrior next = c.advanced();
    Mat15 information;
    Vec15 gradient;
    BruteForce(c).marginal(information, gradient);
    // Nothing is left along the gauge; across it, all is left.
    const Gauge U = gauge_of(c.b);
    const Eigen::Matrix4d core = (U.transpose() * information * U).inverse();
    const Mat15 across = Mat15::Identity() - U * core * U.transpose() * information;
    const Mat15 expected = across.transpose() * information * across;
    EXPECT_LT(scaled_difference(next.information, expected, information), 1e-4) << seed;
    const Vec15 pull = across.transpose() * gradient;
    const Vec15 sigma = information.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_LT(sigma.cwiseProduct(next.gradient - pull).norm(),
              1e-3 * (1 + sigma.cwiseProduct(pull).norm()))
        << seed;
  }
}

TEST(window_prior, turn_about_gravity_and_shift_cost_the_anchor_alone) {
  Case c(4);
  const WindowPrior next = c.advanced();
  const Vec3 shift(1, -2, 0.5);
  BodyState moved = next.mean;
  moved.T_WB.p += shift;
  const Vec15 e = boxminus(moved, next.mean);
  const double anchor = shift.squaredNorm() / (c.params.anchor_sigma_m * c.params.anchor_sigma_m);
  EXPECT_NEAR(e.dot(next.information * e), anchor, 1e-3 * anchor);
  BodyState turned = next.mean;
  const Mat3 turn = so3_exp(Vec3(0, 0, 1e-4));
  turned.T_WB.R = turn * turned.T_WB.R;
  turned.v_WB = turn * turned.v_WB;
  const Vec15 f = boxminus(turned, next.mean);
  const double heading = 1e-8 / (c.params.anchor_sigma_rad * c.params.anchor_sigma_rad);
  EXPECT_NEAR(f.dot(next.information * f), heading, 0.02 * heading);
}

TEST(window_prior, speaks_of_the_next_keyframe_at_its_state) {
  const Case c(1);
  const WindowPrior next = c.advanced();
  EXPECT_EQ(next.sequence, 8u);
  EXPECT_EQ(boxminus(next.mean, c.b).norm(), 0);
}

TEST(window_prior, agreement_leaves_no_pull) {
  Case c(1);
  c.noise.rate_hz = 2000;
  c.motion = c.sway.between(0.2, 0.5, c.noise);
  const WindowPrior next = c.advanced();
  // Perfect samples, integrated in steps: what is left is far below a sigma.
  const Vec15 shift = next.information.ldlt().solve(next.gradient);
  const Vec15 sigma = next.information.inverse().diagonal().cwiseSqrt();
  EXPECT_LT(shift.cwiseQuotient(sigma).norm(), 0.2);
}

TEST(window_prior, information_stays_positive_over_a_long_slide) {
  Case c(1);
  const double step_s = 0.3;
  for (int i = 0; i < 100; ++i) {
    c.a = c.sway.state(i * step_s);
    c.b = c.sway.state((i + 1) * step_s);
    c.motion = c.sway.between(i * step_s, (i + 1) * step_s, c.noise);
    if (i == 0) c.prior = start_prior(7, c.a, c.params);
    c.prior = c.advanced();
    const Mat15 transposed = c.prior.information.transpose();
    EXPECT_LT(scaled_difference(transposed, c.prior.information, transposed), 1e-9);
    const Vec15 scale = c.prior.information.diagonal().cwiseSqrt().cwiseInverse();
    const Mat15 unit = scale.asDiagonal() * c.prior.information * scale.asDiagonal();
    ASSERT_GT(Eigen::SelfAdjointEigenSolver<Mat15>(unit).eigenvalues().minCoeff(), 0) << i;
  }
}

TEST(window_prior, certainty_of_place_fades_and_biases_get_better_known) {
  Case c(1);
  const auto sigma = [](const WindowPrior& prior, int k) {
    return std::sqrt(Mat15(prior.information.inverse())(k, k));
  };
  const WindowPrior start = c.prior;
  for (int i = 0; i < 20; ++i) {
    c.a = c.sway.state(i * 0.3);
    c.b = c.sway.state((i + 1) * 0.3);
    c.motion = c.sway.between(i * 0.3, (i + 1) * 0.3, c.noise);
    if (i == 0) c.prior = start_prior(7, c.a, c.params);
    c.prior = c.advanced();
  }
  for (int k = 3; k < 6; ++k) EXPECT_GT(sigma(c.prior, k), 2 * sigma(start, k)) << k;
  for (int k = 9; k < 12; ++k) EXPECT_LT(sigma(c.prior, k), 0.5 * sigma(start, k)) << k;
}

TEST(window_prior, without_a_link_velocity_is_forgotten_and_biases_are_kept) {
  Case c(2);
  c.prior.information = c.random.spd<15>(1e6);
  const WindowPrior next = advance(c.prior, c.a, 9, c.b, nullptr, c.vision, c.noise, c.params);
  EXPECT_EQ(next.sequence, 9u);
  EXPECT_EQ((next.information.block<6, 6>(9, 9)), (c.prior.information.block<6, 6>(9, 9)));
  EXPECT_LT(next.information.diagonal().segment<3>(6).maxCoeff(), 100);
  EXPECT_EQ(next.gradient.norm(), 0);
}

// A start fixes place and heading by convention; tilt is left to the IMU. Any attitude will do.
TEST(window_prior, start_holds_heading_harder_than_tilt) {
  Random random(3);
  const BodyState first = random.state();
  const WindowPrior prior = start_prior(1, first, MappingParams{});
  const Mat3 in_W = first.T_WB.R * prior.information.block<3, 3>(0, 0) * first.T_WB.R.transpose();
  EXPECT_GT(in_W(2, 2), 100 * in_W(0, 0));
  EXPECT_LT(Mat3(in_W - Mat3(in_W.diagonal().asDiagonal())).norm(), 1e-6 * in_W(2, 2));
}

}  // namespace
}  // namespace pirvs
