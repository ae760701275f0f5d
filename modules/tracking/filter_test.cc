#include "modules/tracking/filter.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>

#include "core/math/so3.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;

constexpr CameraModel kModels[] = {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt};

// A point that camera c sees from `at`, 1 to 8 m away, away from the image's rim.
Vec3 visible_point(Random& random, const Camera& camera, const SE3& T_WB) {
  const Vec2 uv(random.uniform(40, camera.width - 40), random.uniform(40, camera.height - 40));
  Vec3 f_C;
  EXPECT_TRUE(camera.unproject(uv, f_C));
  return T_WB * (camera.T_BC * Vec3(random.uniform(1, 8) * f_C));
}

Correspondence exact(const Rig& rig, const SE3& T_WB, int c, const Vec3& p_W) {
  Correspondence out{p_W, Mat3::Identity() * 1e-8, Vec2::Zero(), 1.0, c, Gate::kAccepted};
  EXPECT_TRUE(rig.camera[c].project((T_WB * rig.camera[c].T_BC).inverse() * p_W, out.uv));
  return out;
}

void add_exact(Random& random, const Rig& rig, const SE3& T_WB, int count, Correspondences& out) {
  for (int i = 0; i < count; ++i) {
    const int c = i % kCamerasMax;
    ASSERT_TRUE(out.push_back(exact(rig, T_WB, c, visible_point(random, rig.camera[c], T_WB))));
  }
}

void expect_covariance(const Mat15& cov) {
  EXPECT_EQ(cov, cov.transpose());
  const double least = Eigen::SelfAdjointEigenSolver<Mat15>(cov).eigenvalues().minCoeff();
  EXPECT_GT(least, 0);
}

Mat15 start_cov(double theta, double p, double v = 0.1, double b_g = 0.01, double b_a = 0.1) {
  Vec15 sigma;
  sigma << Vec3::Constant(theta), Vec3::Constant(p), Vec3::Constant(v), Vec3::Constant(b_g),
      Vec3::Constant(b_a);
  return sigma.cwiseAbs2().asDiagonal();
}

TEST(mm_reprojection, jacobian_matches_numeric) {
  for (const CameraModel model : kModels) {
    const Rig rig(model);
    for (uint32_t seed = 1; seed <= 100; ++seed) {
      Random random(seed);
      const BodyState at = random.state();
      const int c = static_cast<int>(seed % 2);
      const Camera& camera = rig.camera[c];
      Correspondence z = exact(rig, at.T_WB, c, visible_point(random, camera, at.T_WB));
      z.uv += random.pixel(3.0);
      const auto at_step = [&](int k, double h) {
        Vec15 delta = Vec15::Zero();
        delta[k] = h;
        Reprojection m;
        EXPECT_TRUE(linearize_reprojection(boxplus(at, delta).T_WB, z, camera,
                                           camera.T_BC.inverse(), 1.0, m));
        return m;
      };
      const Reprojection m = at_step(0, 0);
      const double h = 1e-6;
      for (int k = 0; k < 6; ++k) {
        // J is that of the prediction: the residual goes the other way.
        const Vec2 numeric = -(at_step(k, h).r - at_step(k, -h).r) / (2 * h);
        EXPECT_LT((numeric - m.J.col(k)).norm(), 1e-6 * m.J.norm()) << "seed " << seed << " " << k;
      }
    }
  }
}

TEST(mm_reprojection, noise_is_the_pixel_and_the_projected_point) {
  const Rig rig(CameraModel::kPinholeRadtan);
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    const BodyState at = random.state();
    const Camera& camera = rig.camera[0];
    Correspondence z = exact(rig, at.T_WB, 0, visible_point(random, camera, at.T_WB));
    z.cov_W = random.spd<3>(0.01);
    z.sigma_px = 0.7;
    Reprojection m;
    const SE3 T_CB = camera.T_BC.inverse();
    ASSERT_TRUE(linearize_reprojection(at.T_WB, z, camera, T_CB, 2.0, m));
    Mat23 J_W;
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const auto project = [&](double step) {
        Vec2 uv;
        const Vec3 p_W = z.p_W + step * Vec3::Unit(k);
        EXPECT_TRUE(camera.project(T_CB * (at.T_WB.inverse() * p_W), uv));
        return uv;
      };
      J_W.col(k) = (project(h) - project(-h)) / (2 * h);
    }
    const Mat2 expected = 0.49 * Mat2::Identity() + 2.0 * J_W * z.cov_W * J_W.transpose();
    EXPECT_LT((m.R - expected).norm(), 1e-5 * expected.norm()) << seed;
  }
}

TEST(mm_reprojection, point_behind_the_camera_is_refused) {
  const Rig rig(CameraModel::kPinholeRadtan);
  const Correspondence z{Vec3(-3, 0, 0), Mat3::Identity(), Vec2(300, 200), 1, 0, Gate::kAccepted};
  Reprojection m;
  EXPECT_FALSE(linearize_reprojection(SE3{}, z, rig.camera[0], rig.camera[0].T_BC.inverse(), 1, m));
}

TEST(mm_standstill, jacobians_match_numeric) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const BodyState at = random.state();
    const Vec3 w_mean_B = random.vec(0.1);
    const double h = 1e-6;
    for (int k = 0; k < 15; ++k) {
      const BodyState plus = boxplus(at, h * Vec15::Unit(k));
      const Vec3 numeric_v =
          (linearize_zero_velocity(at, 1).r - linearize_zero_velocity(plus, 1).r) / h;
      const Vec3 numeric_f =
          (linearize_gravity(at, w_mean_B, 1).r - linearize_gravity(plus, w_mean_B, 1).r) / h;
      EXPECT_LT((numeric_f - linearize_gravity(at, w_mean_B, 1).H.col(k)).norm(), 1e-4);
      const Vec3 numeric_w =
          (linearize_zero_rate(at, w_mean_B, 1).r - linearize_zero_rate(plus, w_mean_B, 1).r) / h;
      EXPECT_LT((numeric_v - linearize_zero_velocity(at, 1).H.col(k)).norm(), 1e-8);
      EXPECT_LT((numeric_w - linearize_zero_rate(at, w_mean_B, 1).H.col(k)).norm(), 1e-8);
    }
  }
}

struct FilterCase {
  explicit FilterCase(CameraModel model = CameraModel::kPinholeRadtan) : rig(model) {
    filter.configure(rig.camera, ImuNoise{}, params);
  }
  Rig rig;
  FilterParams params;
  Filter filter;
};

TEST(filter, boxminus_undoes_boxplus) {
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    const BodyState state = random.state();
    const Vec15 delta = random.vec15(0.3);
    EXPECT_LT((boxminus(boxplus(state, delta), state) - delta).norm(), 1e-12);
  }
}

// With P = e e' and no noise, one step leaves f f', f being that column of the transition.
TEST(filter, transition_matches_numeric) {
  const ImuNoise none{0, 0, 0, 0, 200};
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    const BodyState start = random.state();
    const ImuSample a{0, random.vec(0.5), random.vec(1) + Vec3(0, 0, 9.81)};
    const ImuSample b{5'000'000, a.w_B + random.vec(0.1), a.f_B + random.vec(0.5)};
    FilterCase c;
    c.filter.configure(c.rig.camera, none, c.params);
    const auto step = [&](const BodyState& from, const Mat15& cov) {
      c.filter.reset(from, cov);
      c.filter.propagate(a);
      c.filter.propagate(b);
      return c.filter.state();
    };
    const double h = 1e-5;
    for (int k = 0; k < 15; ++k) {
      const Vec15 e = Vec15::Unit(k);
      const BodyState plus = step(boxplus(start, h * e), Mat15::Zero());
      const BodyState minus = step(boxplus(start, -h * e), Mat15::Zero());
      (void)step(start, e * e.transpose());
      const Vec15 f = boxminus(plus, minus) / (2 * h);
      EXPECT_LT((c.filter.cov() - f * f.transpose()).norm(), 1e-8) << "seed " << seed << " " << k;
    }
  }
}

TEST(filter, propagation_follows_the_true_motion) {
  Sway sway;
  sway.b_g = Vec3(0.02, -0.01, 0.03);
  sway.b_a = Vec3(0.1, 0.05, -0.2);
  FilterCase c;
  c.filter.reset(sway.state(0), start_cov(0.01, 0.01));
  for (int i = 0; i <= 200; ++i) c.filter.propagate(sway.imu(i * 0.005));
  const Vec15 error = boxminus(c.filter.state(), sway.state(1.0));
  EXPECT_EQ(c.filter.state().t, 1'000'000'000);
  EXPECT_LT(error.segment<3>(0).norm(), 1e-4);
  EXPECT_LT(error.segment<3>(3).norm(), 1e-3);
  EXPECT_LT(error.segment<3>(6).norm(), 1e-3);
}

TEST(filter, covariance_grows_stays_symmetric_and_positive) {
  FilterCase c;
  const Sway sway;
  c.filter.reset(sway.state(0), start_cov(0.01, 0.01));
  const double before = c.filter.cov().trace();
  for (int i = 0; i <= 2000; ++i) c.filter.propagate(sway.imu(i * 0.005));
  expect_covariance(c.filter.cov());
  EXPECT_GT(c.filter.cov().trace(), before);
}

// A gap of the IMU that a line bridges, at many places of a motion, in steps of a camera's frames.
TEST(filter, covariance_contains_the_error_of_a_bridged_gap) {
  Sway sway;
  sway.angle_rad *= 3;  // a lively hand
  for (const double gap_s : {0.1, 0.2, 0.4, 0.7, 1.0}) {
    double worst = 0, mean = 0;
    constexpr int kPlaces = 60;
    for (int k = 0; k < kPlaces; ++k) {
      const double begin_s = 0.11 * k;
      FilterCase c;
      c.filter.reset(sway.state(begin_s), Mat15::Identity() * 1e-12);
      const ImuSample first = sway.imu(begin_s), last = sway.imu(begin_s + gap_s);
      c.filter.propagate(first);
      const int steps = std::max(1, static_cast<int>(gap_s / 0.05));
      for (int i = 1; i <= steps; ++i) {
        ImuSample sample = last;
        const double share = double(i) / steps;
        sample.t = first.t + from_seconds(share * gap_s);
        sample.w_B = first.w_B + share * (last.w_B - first.w_B);
        sample.f_B = first.f_B + share * (last.f_B - first.f_B);
        sample.gap_s = float(gap_s);
        c.filter.propagate(sample);
      }
      const Vec15 error = boxminus(c.filter.state(), sway.state(begin_s + gap_s));
      const Mat9 P = c.filter.cov().topLeftCorner<9, 9>();
      const double nees = error.head<9>().dot(P.ldlt().solve(error.head<9>()));
      worst = std::max(worst, nees);
      mean += nees / kPlaces;
    }
    EXPECT_LT(worst, 21.7) << gap_s << ": chi2 with 9 degrees of freedom, 99 %";
    EXPECT_GT(mean, 1e-3) << gap_s << ": but not so wide that it says nothing";
  }
}

TEST(filter, nothing_changes_without_correspondences) {
  FilterCase c;
  const Sway sway;
  c.filter.reset(sway.state(1), start_cov(0.1, 0.1));
  Correspondences none;
  EXPECT_EQ(c.filter.update(none), 0);
  ASSERT_TRUE(none.push_back({Vec3(-5, 0, 0), Mat3::Zero(), Vec2(1, 1), 1.0, 0, Gate::kAccepted}));
  EXPECT_EQ(c.filter.update(none), 0) << "behind the camera";
  EXPECT_EQ(none[0].gate, Gate::kBehindCamera);
  EXPECT_EQ(boxminus(c.filter.state(), sway.state(1)).norm(), 0);
  EXPECT_EQ(c.filter.cov(), start_cov(0.1, 0.1));
}

// One point: the information form must equal the textbook gain P J' (J P J' + R)^-1.
TEST(filter, one_correspondence_equals_the_textbook_update) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    FilterCase c;
    c.params.iterations_max = 1;
    c.params.robust_sigma = 1e6;
    c.filter.configure(c.rig.camera, ImuNoise{}, c.params);
    const BodyState state = random.state();
    const Mat15 cov = random.spd<15>(1e-4);
    const Camera& camera = c.rig.camera[0];
    Correspondences one;
    ASSERT_TRUE(
        one.push_back(exact(c.rig, state.T_WB, 0, visible_point(random, camera, state.T_WB))));
    one[0].uv += random.pixel(1.0);
    c.filter.reset(state, cov);
    ASSERT_EQ(c.filter.update(one), 1);
    Reprojection m;
    ASSERT_TRUE(linearize_reprojection(state.T_WB, one[0], camera, camera.T_BC.inverse(),
                                       c.params.point_cov_scale, m));
    Eigen::Matrix<double, 2, 15> H = Eigen::Matrix<double, 2, 15>::Zero();
    H.leftCols<6>() = m.J;
    const Mat2 S = H * cov * H.transpose() + m.R;
    const Eigen::Matrix<double, 15, 2> K = cov * H.transpose() * S.inverse();
    EXPECT_LT((boxminus(c.filter.state(), state) - K * m.r).norm(), 1e-9);
    EXPECT_LT((c.filter.cov() - (cov - K * H * cov)).norm(), 1e-10);
    expect_covariance(c.filter.cov());
  }
}

TEST(filter, gate_rejects_outliers_alone) {
  FilterCase c;
  Random random(3);
  const BodyState truth = Sway{}.state(1);
  Correspondences z;
  add_exact(random, c.rig, truth.T_WB, 40, z);
  for (size_t i = 0; i < z.size(); i += 10) z[i].uv += Vec2(25, -10);
  c.filter.reset(truth, start_cov(0.002, 0.005));
  EXPECT_EQ(c.filter.update(z), 36);
  for (size_t i = 0; i < z.size(); ++i) {
    EXPECT_EQ(z[i].gate, i % 10 == 0 ? Gate::kChi2 : Gate::kAccepted) << i;
  }
  EXPECT_LT(boxminus(c.filter.state(), truth).norm(), 1e-9);
}

TEST(filter, not_a_number_is_never_accepted) {
  FilterCase c;
  Random random(4);
  const BodyState truth = Sway{}.state(1);
  Correspondences z;
  add_exact(random, c.rig, truth.T_WB, 3, z);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  z[0].uv.x() = nan;
  z[1].p_W.y() = nan;
  z[2].cov_W(0, 0) = nan;
  c.filter.reset(truth, start_cov(0.01, 0.01));
  EXPECT_EQ(c.filter.update(z), 0);
  EXPECT_TRUE(c.filter.cov().allFinite());
}

TEST(filter, iterations_bring_a_perturbed_pose_to_the_truth) {
  for (const CameraModel model : kModels) {
    for (uint32_t seed = 1; seed <= 20; ++seed) {
      Random random(seed);
      FilterCase c(model);
      const BodyState truth = random.state();
      Correspondences z;
      add_exact(random, c.rig, truth.T_WB, 60, z);
      Vec15 error = Vec15::Zero();
      error << random.vec(0.03), random.vec(0.05), Vec3::Zero(), Vec3::Zero(), Vec3::Zero();
      const auto error_after = [&](float iterations) {
        c.params.iterations_max = iterations;
        c.filter.configure(c.rig.camera, ImuNoise{}, c.params);
        c.filter.reset(boxplus(truth, error), start_cov(0.06, 0.1));
        EXPECT_GT(c.filter.update(z), 55);
        return boxminus(c.filter.state(), truth).head<6>().norm();
      };
      const double one = error_after(1), three = error_after(3);
      EXPECT_LT(three, 0.1 * error.norm()) << seed;
      EXPECT_LE(three, one * 1.01) << seed;
      EXPECT_LT(three, 3e-3) << seed;
    }
  }
}

// Errors of many noisy updates are as large as the covariance says, no more and no less.
TEST(filter, covariance_is_honest) {
  double normalized = 0;
  const int runs = 200;
  for (uint32_t seed = 1; seed <= runs; ++seed) {
    Random random(seed);
    FilterCase c;
    c.params.chi2_max = 100;  // the gate cuts off the tails that are counted here
    c.params.robust_sigma = 1e6;
    c.filter.configure(c.rig.camera, ImuNoise{}, c.params);
    const BodyState truth = random.state();
    Correspondences z;
    add_exact(random, c.rig, truth.T_WB, 40, z);
    for (Correspondence& one : z) one.uv += random.pixel(1.0);
    Vec15 error = Vec15::Zero();
    error << random.vec(0.01), random.vec(0.02), Vec3::Zero(), Vec3::Zero(), Vec3::Zero();
    c.filter.reset(boxplus(truth, error), start_cov(0.01, 0.02));
    ASSERT_EQ(c.filter.update(z), 40);
    expect_covariance(c.filter.cov());
    const Vec6 left = boxminus(c.filter.state(), truth).head<6>();
    const Mat6 cov = c.filter.cov().topLeftCorner<6, 6>();
    normalized += left.dot(cov.inverse() * left) / (6.0 * runs);
  }
  EXPECT_NEAR(normalized, 1.0, 0.15);
}

// An hour at rest, 20 frames a second, all the while with a little too much rate and force.
TEST(filter, holding_goes_nowhere_and_does_not_pretend_to_learn_the_place) {
  FilterCase c;
  Random random(8);
  BodyState start;
  start.v_WB = Vec3(0.004, -0.003, 0.002);
  const Vec3 b_g(0.011, -0.02, 0.005), f_B(0.05, -0.08, 9.84);
  Mat15 cov = Mat15::Identity() * 1e-4;
  c.filter.reset(start, cov);
  for (int k = 0; k < 72'000; ++k) {
    const BodyState at = c.filter.state();
    cov = c.filter.cov();
    for (int i = 0; i <= 1; ++i) {
      c.filter.propagate({from_seconds(0.05 * (k + i)), b_g + random.vec(2e-3), f_B});
    }
    c.filter.hold(at, cov, b_g + random.vec(1e-3), f_B + random.vec(1e-2));
  }
  const BodyState& state = c.filter.state();
  EXPECT_EQ(state.t, from_seconds(3600));
  EXPECT_LT(state.T_WB.p.norm(), 1e-3);
  EXPECT_LT(so3_log(state.T_WB.R).norm(), 0.02) << "tilt and bias share what gravity says";
  EXPECT_LT(std::fabs(so3_log(state.T_WB.R).z()), 1e-3) << "heading";
  EXPECT_LT((state.b_g - b_g).norm(), 1e-3);
  EXPECT_LT((state.T_WB.R * (f_B - state.b_a) - Vec3(0, 0, kGravity_m_s2)).norm(), 0.02);
  EXPECT_EQ(state.v_WB.norm(), 0);
  EXPECT_GT(c.filter.cov()(3, 3), 1e-4) << "rest says nothing of the place";
  expect_covariance(c.filter.cov());
}

TEST(filter, standstill_stops_the_body_and_finds_the_gyro_bias) {
  Random random(5);
  FilterCase c;
  BodyState start = random.state();
  const Vec3 b_g(0.011, -0.02, 0.005);
  c.filter.reset(start, random.spd<15>(1e-2));
  const Mat15 before = c.filter.cov();
  for (int i = 0; i < 20; ++i) c.filter.update_standstill(b_g);
  EXPECT_LT(c.filter.state().v_WB.norm(), 0.02);
  EXPECT_LT((c.filter.state().b_g - b_g).norm(), 1e-3);
  EXPECT_LT(c.filter.cov().diagonal().segment<3>(6).maxCoeff(), 1e-5);
  EXPECT_TRUE((c.filter.cov().diagonal().array() <= before.diagonal().array()).all());
  expect_covariance(c.filter.cov());
}

}  // namespace
}  // namespace pirvs
