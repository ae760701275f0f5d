// Long file: one fixture builds the windows of all its tests.
#include "modules/mapping/bundle.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "core/math/so3.h"
#include "modules/state/body_state.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;

using Dense = Eigen::MatrixXd;
using Column = Eigen::VectorXd;

constexpr double kInterval_s = 0.25;      // between keyframes
constexpr double kHopeless_sigma = 50.0;  // the bundle's: from here on the cost is constant

struct Sighting {
  int point, frame, camera;
  Vec2 uv;
  bool outlier;
};

// A window as mapping builds it: fixed frames first, then free ones, linked, the first with a
// prior.
struct Problem {
  Problem(uint32_t seed, int fixed_frames, int free_frames, int point_count,
          CameraModel model = CameraModel::kPinholeRadtan)
      : random(seed), rig(model), fixed(fixed_frames) {
    params = MappingParams{};
    params.sigma_px = 0.6f;
    params.robust_sigma = 1.5f;
    params.iterations_max = 20;
    noise.gyro_noise = 4e-4;
    noise.accel_noise = 2e-2;
    for (int i = 0; i < fixed_frames + free_frames; ++i) {
      truth.push_back(sway.state(i * kInterval_s));
    }
    for (int i = fixed_frames + 1; i < fixed_frames + free_frames; ++i) {
      motions.push_back(sway.between((i - 1) * kInterval_s, i * kInterval_s, noise));
    }
    while (static_cast<int>(points.size()) < point_count) add_point();
    states = truth;
    prior = start_prior(1, truth[static_cast<size_t>(fixed)], params);
  }

  void add_point() {
    const double x = random.uniform(2, 7);
    const Vec3 p_W(x, random.uniform(-0.6, 0.6) * x, random.uniform(-0.4, 0.4) * x);
    std::vector<Sighting> seen;
    for (int i = 0; i < static_cast<int>(truth.size()); ++i) {
      for (int c = 0; c < kCamerasMax; ++c) {
        Vec2 uv;
        if (!rig.see(truth[static_cast<size_t>(i)].T_WB, c, p_W, uv)) continue;
        seen.push_back(
            {static_cast<int>(points.size()), i, c, uv.cast<float>().cast<double>(), false});
      }
    }
    if (seen.size() < 4) return;
    sightings.insert(sightings.end(), seen.begin(), seen.end());
    points.push_back(p_W);
    points_truth.push_back(p_W);
  }
  void add_noise(double sigma_px) {
    for (Sighting& s : sightings) {
      s.uv = (s.uv + random.pixel(sigma_px)).cast<float>().cast<double>();
    }
  }
  void add_outliers(double share) {
    for (Sighting& s : sightings) {
      if (random.uniform(0, 1) > share) continue;
      s.outlier = true;
      s.uv += Vec2(random.uniform(15, 40), random.uniform(-40, -15));
    }
  }
  // Moves what may move away from the truth; 1: centimetres and half a degree.
  void perturb(double scale) {
    Vec15 sigma;
    sigma << Vec3::Constant(0.01), Vec3::Constant(0.03), Vec3::Constant(0.05),
        Vec3::Constant(0.002), Vec3::Constant(0.05);
    for (size_t i = static_cast<size_t>(fixed); i < states.size(); ++i) {
      states[i] = boxplus(truth[i], scale * sigma.cwiseProduct(random.vec15(1)));
    }
    for (Vec3& p : points) p += random.vec(0.04 * scale);
  }

  void load(Bundle& bundle) const {
    bundle.begin(rig.camera, noise, params);
    for (size_t i = 0; i < states.size(); ++i) {
      ASSERT_EQ(bundle.add_frame(states[i], static_cast<int>(i) < fixed), static_cast<int>(i));
    }
    for (size_t i = 0; i < motions.size(); ++i) {
      bundle.link(fixed + static_cast<int>(i), fixed + static_cast<int>(i) + 1, motions[i],
                  WheelPath{});
    }
    bundle.set_prior(fixed, prior);
    size_t at = 0;
    for (size_t p = 0; p < points.size(); ++p) {
      ASSERT_EQ(bundle.add_point(points[p]), static_cast<int>(p));
      for (; at < sightings.size() && sightings[at].point == static_cast<int>(p); ++at) {
        const Sighting& s = sightings[at];
        ASSERT_TRUE(bundle.add_observation(s.point, s.frame, s.camera, s.uv));
      }
    }
  }

  Random random;
  Rig rig;
  Sway sway;
  ImuNoise noise;
  MappingParams params;
  int fixed;
  std::vector<BodyState> truth, states;
  std::vector<Preintegration> motions;
  std::vector<Vec3> points_truth, points;
  std::vector<Sighting> sightings;
  WindowPrior prior;
};

std::unique_ptr<Bundle> solve(const Problem& problem) {
  auto bundle = std::make_unique<Bundle>();
  problem.load(*bundle);
  for (int guard = 0; guard < 100'000 && !bundle->step(); ++guard) {
  }
  return bundle;
}

double worst(const Problem& problem, const Bundle& bundle, int first) {
  double out = 0;
  for (size_t i = static_cast<size_t>(problem.fixed); i < problem.truth.size(); ++i) {
    const Vec15 e = boxminus(bundle.state(static_cast<int>(i)), problem.truth[i]);
    out = std::max(out, e.segment<3>(first).norm());
  }
  return out;
}

// The same problem written down plainly: one residual vector, numeric derivatives, dense algebra.
class BruteForce {
 public:
  explicit BruteForce(const Problem& problem) : BruteForce(problem, RobustCost{}) {
    robust_ = measured();
  }
  // With the cost that an adjustment has settled on at other states.
  BruteForce(const Problem& problem, const RobustCost& robust) : p_(problem), robust_(robust) {
    unknown_poses_ = 15 * (static_cast<int>(p_.states.size()) - p_.fixed);
    unknowns_ = unknown_poses_ + 3 * static_cast<int>(p_.points.size());
    for (size_t i = 0; i < p_.motions.size(); ++i) {
      const int from = p_.fixed + static_cast<int>(i);
      links_.push_back(make_link(from, from + 1, p_.motions[i], p_.noise));
    }
  }

  const RobustCost& robust() const { return robust_; }
  double cost() const {
    const Column r = residuals(Column::Zero(unknowns_));
    double sum = 0;
    for (size_t i = 0; i < p_.sightings.size(); ++i) {
      const double e = std::min(kHopeless_sigma, r.segment<2>(static_cast<int>(2 * i)).norm());
      sum += trust(i) * robust_.cost(e * e);
    }
    const Vec15 e = boxminus(p_.states[static_cast<size_t>(p_.fixed)], p_.prior.mean);
    return sum + r.tail(15 * static_cast<int>(links_.size())).squaredNorm() +
           e.dot(p_.prior.information * e) - 2 * p_.prior.gradient.dot(e);
  }

  // One Levenberg-Marquardt step, and the newest frame's covariance without its damping.
  Column step(double lambda, Mat15& newest_cov) const {
    Dense H = Dense::Zero(unknowns_, unknowns_);
    Column g = Column::Zero(unknowns_);
    linearize(H, g);
    const int n = unknown_poses_, m = unknowns_ - n;
    Dense H_pp = H.bottomRightCorner(m, m);
    for (int p = 0; p < m; p += 3) {
      const Mat3 block = H_pp.block<3, 3>(p, p);
      H_pp.block<3, 3>(p, p) += (1e-6 + 1e-7 * block.trace()) * Mat3::Identity();
    }
    const Dense back = H_pp.ldlt().solve(H.bottomLeftCorner(m, n));
    Dense S = H.topLeftCorner(n, n) - H.topRightCorner(n, m) * back;
    newest_cov = Dense(S.ldlt().solve(Dense::Identity(n, n))).bottomRightCorner<15, 15>();
    S.diagonal() *= 1 + lambda;
    const Column g_reduced = g.head(n) - back.transpose() * g.tail(m);
    Column delta(unknowns_);
    delta.head(n) = S.ldlt().solve(g_reduced);
    delta.tail(m) = H_pp.ldlt().solve(g.tail(m) - H.bottomLeftCorner(m, n) * delta.head(n));
    return delta;
  }

 private:
  double trust(size_t i) const {
    return p_.sightings[i].frame < p_.fixed ? p_.params.fixed_weight : 1.0;
  }

  RobustCost measured() const {
    const Column r = residuals(Column::Zero(unknowns_));
    RobustCost out;
    out.begin(p_.params.robust_sigma);
    for (size_t i = 0; i < p_.sightings.size(); ++i) {
      out.measure(r.segment<2>(static_cast<int>(2 * i)).squaredNorm());
    }
    out.settle();
    return out;
  }

  // Prediction minus measurement: points in sigmas, then links whitened.
  Column residuals(const Column& delta) const {
    std::vector<BodyState> states = p_.states;
    for (size_t i = static_cast<size_t>(p_.fixed); i < states.size(); ++i) {
      const int at = 15 * (static_cast<int>(i) - p_.fixed);
      states[i] = boxplus(states[i], delta.segment<15>(at));
    }
    Column out(2 * p_.sightings.size() + 15 * links_.size());
    int row = 0;
    for (const Sighting& s : p_.sightings) {
      const Vec3 p_W =
          p_.points[static_cast<size_t>(s.point)] + delta.segment<3>(unknown_poses_ + 3 * s.point);
      const Camera& camera = p_.rig.camera[s.camera];
      const SE3 T_WC = states[static_cast<size_t>(s.frame)].T_WB * camera.T_BC;
      Vec2 uv;
      EXPECT_TRUE(camera.project(T_WC.inverse() * p_W, uv));
      out.segment<2>(row) = (uv - s.uv) / p_.params.sigma_px;
      row += 2;
    }
    for (const ImuLink& link : links_) {
      const Vec15 r = link_residual(link, states[static_cast<size_t>(link.from)],
                                    states[static_cast<size_t>(link.to)]);
      const Mat9 L = link.information.llt().matrixL();
      out.segment<9>(row) = L.transpose() * r.head<9>();
      out.segment<3>(row + 9) = std::sqrt(link.walk_g) * r.segment<3>(9);
      out.segment<3>(row + 12) = std::sqrt(link.walk_a) * r.segment<3>(12);
      row += 15;
    }
    return out;
  }

  void linearize(Dense& H, Column& g) const {
    const Column r = residuals(Column::Zero(unknowns_));
    Dense J(r.size(), unknowns_);
    const double h = 1e-6;
    for (int k = 0; k < unknowns_; ++k) {
      const Column e = h * Column::Unit(unknowns_, k);
      J.col(k) = (residuals(e) - residuals(-e)) / (2 * h);
    }
    Column weight = Column::Ones(r.size());
    for (size_t i = 0; i < p_.sightings.size(); ++i) {
      const int at = static_cast<int>(2 * i);
      const double e = r.segment<2>(at).norm();
      const double share = e > kHopeless_sigma ? 0.0 : robust_.weight(e * e);
      weight.segment<2>(at).setConstant(trust(i) * share);
    }
    H = J.transpose() * weight.asDiagonal() * J;
    g = -J.transpose() * weight.asDiagonal() * r;
    H.topLeftCorner<15, 15>() += p_.prior.information;
    g.head<15>() +=
        p_.prior.gradient -
        p_.prior.information * boxminus(p_.states[static_cast<size_t>(p_.fixed)], p_.prior.mean);
  }

  const Problem& p_;
  RobustCost robust_;
  int unknown_poses_, unknowns_;
  std::vector<ImuLink> links_;
};

// Every Jacobian, weight and block of the elimination, against numbers: both models, far residuals
// weighed down.
TEST(bundle, one_step_equals_dense_numeric_gauss_newton) {
  int kept = 0;
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    for (uint32_t seed = 1; seed <= 5; ++seed) {
      Problem problem(seed, 2, 3, 15, model);
      problem.perturb(0.3);
      problem.add_noise(0.6);
      problem.params.iterations_max = 1;
      BodyState& mean = problem.prior.mean;
      mean = problem.states[2];
      mean.T_WB.p += problem.random.vec(1e-5);  // rotation apart, the prior is linear
      mean.v_WB += problem.random.vec(0.1);
      problem.prior.gradient = problem.random.vec15(1.0);
      const BruteForce brute(problem);
      const auto bundle = solve(problem);
      ASSERT_TRUE(bundle->solved()) << seed;
      EXPECT_NEAR(bundle->cost_before(), brute.cost(), 1e-9 * brute.cost());
      Mat15 newest_cov;
      const Column delta = brute.step(1e-4, newest_cov);
      for (int i = 0; i < 3; ++i) {
        const Vec15 moved =
            boxminus(bundle->state(2 + i), problem.states[static_cast<size_t>(2 + i)]);
        const Vec15 expected = delta.segment<15>(15 * i);
        for (int k = 0; k < 15; k += 3) {
          EXPECT_LT((moved - expected).segment<3>(k).norm(),
                    1e-4 * expected.segment<3>(k).norm() + 1e-9)
              << "seed " << seed << " frame " << i << " row " << k;
        }
      }
      for (int i = 0; i < 15; ++i) {
        const Vec3 moved = bundle->point(i) - problem.points[static_cast<size_t>(i)];
        const Vec3 expected = delta.segment<3>(45 + 3 * i);
        if (moved == Vec3::Zero()) {  // its step would have cost more
          ++kept;
          continue;
        }
        EXPECT_LT((moved - expected).norm(), 1e-4 * expected.norm() + 1e-9) << seed << " " << i;
      }
      const Vec15 scale = newest_cov.diagonal().cwiseSqrt().cwiseInverse();
      EXPECT_LT(
          (scale.asDiagonal() * (bundle->newest_cov() - newest_cov) * scale.asDiagonal()).norm(),
          1e-4);
    }
  }
  EXPECT_LE(kept, 1) << "of 150 points";
}

TEST(bundle, converges_from_a_perturbed_window_to_the_truth) {
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    Problem problem(1, 2, 10, 200, model);
    problem.perturb(1);
    const auto bundle = solve(problem);
    ASSERT_TRUE(bundle->solved());
    EXPECT_LT(bundle->cost(), 1e-3 * bundle->cost_before());
    EXPECT_LT(worst(problem, *bundle, 0), 5e-4) << "rad";
    EXPECT_LT(worst(problem, *bundle, 3), 1e-3) << "m";
    EXPECT_LT(worst(problem, *bundle, 6), 1e-2) << "m/s";
    EXPECT_LT(worst(problem, *bundle, 9), 2e-3) << "rad/s";
    double point_error = 0;
    for (int i = 0; i < bundle->points(); ++i) {
      point_error += (bundle->point(i) - problem.points_truth[static_cast<size_t>(i)]).norm() / 200;
    }
    EXPECT_LT(point_error, 5e-3);
  }
}

TEST(bundle, without_fixed_frames_the_prior_holds_the_window) {
  Problem problem(2, 0, 10, 200);
  problem.perturb(1);
  problem.states[0] = problem.truth[0];
  const auto bundle = solve(problem);
  ASSERT_TRUE(bundle->solved());
  EXPECT_LT(worst(problem, *bundle, 3), 3e-3) << "m";
  EXPECT_LT(worst(problem, *bundle, 0), 1e-3) << "rad";
}

TEST(bundle, the_end_is_a_minimum_of_the_cost) {
  Problem problem(3, 1, 3, 30);
  problem.add_noise(0.6);
  problem.perturb(0.3);
  const RobustCost robust = BruteForce(problem).robust();
  auto bundle = solve(problem);
  ASSERT_TRUE(bundle->solved());
  for (size_t i = 0; i < problem.states.size(); ++i) problem.states[i] = bundle->state(int(i));
  for (size_t i = 0; i < problem.points.size(); ++i) problem.points[i] = bundle->point(int(i));
  const double best = BruteForce(problem, robust).cost();
  EXPECT_NEAR(best, bundle->cost(), 1e-9 * best);
  const Problem solved = problem;
  for (int trial = 0; trial < 50; ++trial) {
    problem.states = solved.states;
    problem.points = solved.points;
    for (size_t i = 1; i < problem.states.size(); ++i) {
      problem.states[i] = boxplus(problem.states[i], problem.random.vec15(3e-3));
    }
    for (Vec3& p : problem.points) p += problem.random.vec(1e-2);
    EXPECT_GT(BruteForce(problem, robust).cost(), best) << trial;
  }
}

TEST(bundle, five_percent_outliers_do_no_harm_and_are_found) {
  for (uint32_t seed = 1; seed <= 3; ++seed) {
    Problem problem(seed, 2, 10, 200);
    problem.add_noise(0.5);
    problem.add_outliers(0.05);
    problem.perturb(1);
    const auto bundle = solve(problem);
    ASSERT_TRUE(bundle->solved());
    EXPECT_LT(worst(problem, *bundle, 3), 0.01) << "m, seed " << seed;
    EXPECT_LT(worst(problem, *bundle, 0), 3e-3) << "rad, seed " << seed;
    int outliers = 0, found = 0, inliers = 0, wronged = 0;
    size_t at = 0;
    for (int p = 0; p < bundle->points(); ++p) {
      for (int k = 0; k < bundle->observations(p); ++k, ++at) {
        const bool bad = bundle->residual_sigma(p, k) > 3 * problem.params.outlier_sigma;
        (problem.sightings[at].outlier ? outliers : inliers) += 1;
        if (bad) (problem.sightings[at].outlier ? found : wronged) += 1;
      }
    }
    EXPECT_EQ(at, problem.sightings.size());
    EXPECT_GT(found, outliers * 95 / 100);
    EXPECT_LT(wronged, inliers / 100);
  }
}

TEST(bundle, fixed_frames_do_not_move) {
  Problem problem(4, 3, 4, 60);
  problem.add_noise(0.6);
  problem.perturb(1);
  const auto bundle = solve(problem);
  ASSERT_TRUE(bundle->solved());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(bundle->state(i).T_WB.R, problem.truth[static_cast<size_t>(i)].T_WB.R);
    EXPECT_EQ(bundle->state(i).T_WB.p, problem.truth[static_cast<size_t>(i)].T_WB.p);
  }
  EXPECT_GT(boxminus(bundle->state(3), problem.states[3]).norm(), 1e-3);
}

// Everything stands tilted, fixed frames too; only the prior and the IMU know where down is.
TEST(bundle, a_free_tilt_levels_all_as_one) {
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    Problem problem(seed, 3, 5, 80);
    problem.params.iterations_max = 30;
    problem.params.robust_sigma = 1e6;
    const Mat3 R = problem.truth[3].T_WB.R;
    problem.prior.information.topLeftCorner<3, 3>() =
        R.transpose() * Vec3(1e8, 1e8, 0).asDiagonal() * R;
    problem.prior.mean = problem.truth[3];
    const Vec3 tilt(0.02, -0.01, 0);
    const Vec3 at = problem.truth[3].T_WB.p;
    SE3 T;
    T.R = so3_exp(tilt);
    T.p = at - T.R * at;
    for (BodyState& state : problem.states) move(T, state);
    for (Vec3& p : problem.points) p = T * p;
    auto bundle = std::make_unique<Bundle>();
    problem.load(*bundle);
    bundle->free_tilt(Mat2::Identity() * 1e-3);
    while (!bundle->step()) {
    }
    ASSERT_TRUE(bundle->solved());
    EXPECT_LT((so3_log(bundle->tilted()) + tilt).norm(), 1e-3) << seed;
    EXPECT_EQ(bundle->tilted_at(), problem.states[3].T_WB.p);
    for (int i = 0; i < 8; ++i) {
      const BodyState& state = bundle->state(i);
      const BodyState& truth = problem.truth[static_cast<size_t>(i)];
      EXPECT_LT(so3_log(truth.T_WB.R.transpose() * state.T_WB.R).norm(), 1.5e-3) << seed << i;
      EXPECT_LT((state.T_WB.p - truth.T_WB.p).norm(), 5e-3) << seed << i;
    }
    double point_error = 0;
    for (int i = 0; i < bundle->points(); ++i) {
      point_error += (bundle->point(i) - problem.points_truth[static_cast<size_t>(i)]).norm() / 80;
    }
    EXPECT_LT(point_error, 0.01) << seed;
    EXPECT_LT(std::sqrt(bundle->tilt_cov().trace()), 1e-3);
  }
}

// What is known of the fixed frames' tilt weighs as much as what the prior says.
TEST(bundle, a_known_tilt_is_weighed_against_the_prior) {
  Problem problem(2, 3, 5, 80);
  problem.params.iterations_max = 30;
  problem.noise.accel_noise = 100;  // the IMU says nothing
  const Mat3 R = problem.truth[3].T_WB.R;
  problem.prior.information.topLeftCorner<9, 9>().setZero();
  problem.prior.information.topLeftCorner<3, 3>() =
      R.transpose() * Vec3(1e6, 1e6, 0).asDiagonal() * R;
  problem.prior.mean = problem.truth[3];
  problem.prior.mean.T_WB.R = so3_exp(Vec3(0.004, 0, 0)) * R;
  auto bundle = std::make_unique<Bundle>();
  problem.load(*bundle);
  bundle->free_tilt(Mat2::Identity() * 3e6);
  while (!bundle->step()) {
  }
  ASSERT_TRUE(bundle->solved());
  EXPECT_NEAR(so3_log(bundle->tilted()).x(), 0.001, 2e-4) << "it ends a little short";
  EXPECT_NEAR(bundle->tilt_cov()(0, 0), 1 / 4e6, 0.1 / 4e6);
}

Problem held_exactly(uint32_t seed) {
  Problem problem(seed, 3, 5, 80);
  problem.params.fixed_weight = 1;  // the fixed frames are exact
  problem.add_noise(0.6);
  problem.perturb(0.3);
  return problem;
}

TEST(bundle, covariance_of_the_newest_frame_is_positive_and_honest) {
  double normalized = 0;
  const int runs = 10;
  for (uint32_t seed = 1; seed <= runs; ++seed) {
    const Problem problem = held_exactly(seed);
    const auto bundle = solve(problem);
    ASSERT_TRUE(bundle->solved());
    const Mat15& cov = bundle->newest_cov();
    EXPECT_LT((cov - cov.transpose()).norm(), 1e-9 * cov.norm());
    const Vec15 scale = cov.diagonal().cwiseSqrt().cwiseInverse();
    const Mat15 unit = scale.asDiagonal() * cov * scale.asDiagonal();
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Mat15>(unit).eigenvalues().minCoeff(), 0) << seed;
    const Vec6 e = boxminus(bundle->state(7), problem.truth[7]).head<6>();
    const Mat6 pose = cov.topLeftCorner<6, 6>();
    normalized += e.dot(pose.inverse() * e) / (6.0 * runs);
    for (int i = 0; i < bundle->points(); ++i) {
      ASSERT_GT(Eigen::SelfAdjointEigenSolver<Mat3>(bundle->point_cov(i)).eigenvalues()[0], 0);
    }
  }
  EXPECT_GT(normalized, 0.3);
  EXPECT_LT(normalized, 2.5);
}

// All fixed frames are off together: solved anew, the others must follow as foretold.
TEST(bundle, frames_follow_what_holds_them_as_foretold) {
  const double sizes[6] = {1e-4, 1e-4, 1e-4, 1e-3, 1e-3, 1e-3};
  Problem problem(11, 3, 6, 120);
  problem.params.iterations_max = 30;
  problem.params.robust_sigma = 1e6;
  problem.noise.accel_noise = 2e-3;                           // inertia should have a say
  problem.prior.information.topLeftCorner<9, 9>().setZero();  // no hold on place, heading, speed
  const Mat3 R = problem.truth[3].T_WB.R;
  problem.prior.information.topLeftCorner<3, 3>() =
      R.transpose() * Vec3(1e6, 1e6, 0).asDiagonal() * R;
  problem.add_noise(0.3);
  // Again and again from where it ended: an adjustment stops where the cost hardly falls, short of
  // the end along what is weakly determined.
  const auto settle = [](Problem out) {
    for (int again = 0; again < 6; ++again) {
      const auto bundle = solve(out);
      for (size_t i = 3; i < out.states.size(); ++i) out.states[i] = bundle->state(int(i));
      for (size_t i = 0; i < out.points.size(); ++i) out.points[i] = bundle->point(int(i));
    }
    return out;
  };
  const Problem settled = settle(problem);
  const auto before = solve(settle(settled));  // as often as below
  ASSERT_TRUE(before->errors_known());
  const Vec3 at = before->state(3).T_WB.p;
  for (int axis = 0; axis < 6; ++axis) {
    Vec6 off = Vec6::Zero();
    off[axis] = sizes[axis];
    Problem moved = settled;
    for (BodyState& state : moved.states) state = boxplus(state, rigid_motion(state, at) * off);
    for (Vec3& p : moved.points) p += off.tail<3>() + off.head<3>().cross(p - at);
    const auto after = solve(settle(moved));
    ASSERT_TRUE(after->errors_known());
    const Vec15 newest = boxminus(after->state(8), before->state(8)) / sizes[axis];
    const Vec6 oldest = boxminus(after->state(3), before->state(3)).head<6>() / sizes[axis];
    EXPECT_LT((newest.head<9>() - before->newest_follows().col(axis).head<9>()).norm(),
              0.03 + 0.01 * newest.norm())
        << axis << "\n"
        << newest.norm() << "\n"
        << before->newest_follows().col(axis).norm();
    EXPECT_LT((oldest - before->oldest_follows().col(axis)).norm(), 0.03) << axis;
  }
  const Vec3 tilt = R * before->oldest_follows().col(0).head<3>();
  EXPECT_LT(tilt.x(), 0.95) << "inertia resists a tilt";
  EXPECT_GT(tilt.x(), 0.0);
}

TEST(bundle, covariance_of_the_oldest_pose_is_honest) {
  double normalized = 0;
  const int runs = 10;
  for (uint32_t seed = 1; seed <= runs; ++seed) {
    const Problem problem = held_exactly(seed);
    const auto bundle = solve(problem);
    ASSERT_TRUE(bundle->errors_known());
    const Mat6& cov = bundle->oldest_pose_cov();
    EXPECT_LT((cov - cov.transpose()).norm(), 1e-9 * cov.norm());
    const Vec6 e = boxminus(bundle->state(3), problem.truth[3]).head<6>();
    normalized += e.dot(cov.inverse() * e) / (6.0 * runs);
  }
  EXPECT_GT(normalized, 0.3);
  EXPECT_LT(normalized, 2.5);
}

TEST(bundle, same_input_same_bits_after_any_former_use) {
  Problem problem(5, 1, 4, 60), other(6, 2, 6, 90);
  problem.add_noise(0.6);
  problem.perturb(0.5);
  const auto once = solve(problem);
  const auto used = solve(other);
  problem.load(*used);
  while (!used->step()) {
  }
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(once->state(i).T_WB.p, used->state(i).T_WB.p);
    EXPECT_EQ(once->state(i).T_WB.R, used->state(i).T_WB.R);
  }
  EXPECT_EQ(once->cost(), used->cost());
  EXPECT_EQ(once->newest_cov(), used->newest_cov());
}

TEST(bundle, without_free_frames_nothing_is_solved) {
  Problem problem(7, 2, 1, 30);
  auto bundle = std::make_unique<Bundle>();
  bundle->begin(problem.rig.camera, problem.noise, problem.params);
  EXPECT_EQ(bundle->add_frame(problem.truth[0], true), 0);
  int steps = 0;
  while (!bundle->step()) ASSERT_LT(++steps, 1000);
  EXPECT_FALSE(bundle->solved());
}

TEST(bundle, a_point_behind_its_camera_is_infinitely_bad_and_does_no_harm) {
  Problem problem(8, 2, 4, 60);
  problem.perturb(0.3);
  const size_t behind = problem.points.size();
  problem.points.push_back(Vec3(-4, 0, 0));
  for (int c = 0; c < 2; ++c) {
    problem.sightings.push_back({static_cast<int>(behind), 3, c, Vec2(300, 200), true});
  }
  const auto bundle = solve(problem);
  ASSERT_TRUE(bundle->solved());
  EXPECT_EQ(bundle->residual_sigma(static_cast<int>(behind), 0),
            std::numeric_limits<double>::infinity());
  EXPECT_LT(worst(problem, *bundle, 3), 2e-3);
}

// A wrong stereo match: the disparity of a point at 1.6 m, the estimate at 4.5 m. The undamped step
// in depth, linear in the disparity, ends behind the camera and costs more than all others gain.
TEST(bundle, a_point_that_jumps_behind_its_camera_vetoes_no_step) {
  Problem problem(12, 2, 4, 60);
  problem.perturb(0.02);
  const auto without = solve(problem);
  ASSERT_TRUE(without->solved());
  const SE3 T_WC = problem.truth[3].T_WB * problem.rig.camera[0].T_BC;
  const Vec3 start_W = T_WC * Vec3(0.1, 0.05, 4.5);
  Vec2 left, right;
  ASSERT_TRUE(problem.rig.see(problem.truth[3].T_WB, 0, start_W, left));
  ASSERT_TRUE(problem.rig.see(problem.truth[3].T_WB, 1, start_W, right));
  const double disparity_px = left.x() - right.x();
  const int bad = static_cast<int>(problem.points.size());
  problem.points.push_back(start_W);
  problem.sightings.push_back({bad, 3, 0, left, true});
  problem.sightings.push_back({bad, 3, 1, right + Vec2(4 * disparity_px, 0), true});
  const auto with = solve(problem);
  ASSERT_TRUE(with->solved());
  EXPECT_LT(worst(problem, *with, 3), 1.1 * worst(problem, *without, 3) + 1e-4);
  EXPECT_LT((with->point(bad) - start_W).norm(), 0.5) << "it stays about where it was";
  EXPECT_GT(with->residual_sigma(bad, 1), 3 * problem.params.outlier_sigma) << "and is found";
  EXPECT_TRUE(with->errors_known());
}

TEST(bundle, full_pools_say_so_and_what_is_in_still_solves) {
  Problem problem(9, 1, 5, 40);
  problem.perturb(0.3);
  auto bundle = std::make_unique<Bundle>();
  problem.load(*bundle);
  for (int i = 5; i < Bundle::kFreeMax; ++i) {
    EXPECT_GE(bundle->add_frame(problem.truth[1], false), 0);
  }
  EXPECT_EQ(bundle->add_frame(problem.truth[1], false), -1) << "free frames";
  for (int i = 0; i < Bundle::kFramesMax - Bundle::kFreeMax - 1; ++i) {
    EXPECT_GE(bundle->add_frame(problem.truth[0], true), 0);
  }
  EXPECT_EQ(bundle->add_frame(problem.truth[0], true), -1) << "frames";
  int point = bundle->points() - 1;
  while (bundle->points() < Bundle::kPointsMax) point = bundle->add_point(Vec3(4, 0, 0));
  EXPECT_EQ(bundle->add_point(Vec3(4, 0, 0)), -1);
  int observations = static_cast<int>(problem.sightings.size());
  Vec2 uv;
  ASSERT_TRUE(problem.rig.see(problem.truth[0].T_WB, 0, Vec3(4, 0, 0), uv));
  while (bundle->add_observation(point, 0, 0, uv)) ++observations;
  EXPECT_EQ(observations, Bundle::kObservationsMax);
  while (!bundle->step()) {
  }
  EXPECT_FALSE(bundle->solved()) << "seven free frames hang in the air: no step is possible";
}

// More pairs of point and free frame than there is room for: the rest holds its points only.
TEST(bundle, running_out_of_shares_still_lowers_the_cost) {
  Problem problem(10, 1, 12, 900);
  problem.perturb(0.3);
  problem.params.iterations_max = 4;
  ASSERT_GT(problem.sightings.size() / 2, static_cast<size_t>(Bundle::kSharesMax));
  ASSERT_LT(problem.sightings.size(), static_cast<size_t>(Bundle::kObservationsMax));
  const auto bundle = solve(problem);
  EXPECT_TRUE(bundle->solved());
  EXPECT_LT(bundle->cost(), 0.5 * bundle->cost_before());
}

}  // namespace
}  // namespace pirvs
