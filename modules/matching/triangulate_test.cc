#include "modules/matching/triangulate.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;

struct Scene {
  explicit Scene(CameraModel model = CameraModel::kPinholeRadtan) : rig(model) {}
  void view(const SE3& T_WB, int c, const Vec3& p_W) {
    View v{&rig.camera[c], (T_WB * rig.camera[c].T_BC).inverse(), Vec2::Zero()};
    EXPECT_TRUE(rig.camera[c].project(v.T_CW * p_W, v.uv));
    views.push_back(v);
  }
  bool solve(double sigma_px = 1.0) {
    return triangulate(views.data(), static_cast<int>(views.size()), sigma_px, out);
  }
  Rig rig;
  std::vector<View> views;
  Triangulated out;
};

TEST(triangulate, two_exact_views_give_the_point) {
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    for (uint32_t seed = 1; seed <= 100; ++seed) {
      Random random(seed);
      Scene s(model);
      const SE3 T_WB = random.state().T_WB;
      const double x = random.uniform(0.6, 10);
      const Vec3 p_B(x, random.uniform(-0.4, 0.4) * x, random.uniform(-0.3, 0.3) * x);
      const Vec3 p_W = T_WB * p_B;
      s.view(T_WB, 0, p_W);
      s.view(T_WB, 1, p_W);
      ASSERT_TRUE(s.solve()) << seed;
      EXPECT_LT((s.out.p_W - p_W).norm(), 1e-4 * x) << seed;
      EXPECT_LT(s.out.residual_px_max, 1e-2);
      EXPECT_NEAR(s.out.parallax_rad, 0.11 / p_B.norm(), 0.35 * 0.11 / p_B.norm());
    }
  }
}

// Noisy points scatter about the truth as the covariance says.
TEST(triangulate, covariance_matches_scatter_of_many_views) {
  const Vec3 p_W(4, 0.5, -0.2);
  double normalized = 0;
  const int runs = 300;
  for (uint32_t seed = 1; seed <= runs; ++seed) {
    Random random(seed);
    Scene s;
    for (int i = 0; i < 4; ++i) {
      SE3 T_WB;
      T_WB.R = so3_exp(Vec3(0.02 * i, -0.01 * i, 0.03 * i));
      T_WB.p = Vec3(0.1 * i, 0.15 * i, 0.02 * i);
      for (int c = 0; c < 2; ++c) {
        s.view(T_WB, c, p_W);
        s.views.back().uv += random.pixel(0.5);
      }
    }
    ASSERT_TRUE(s.solve(0.5)) << seed;
    const Vec3 error = s.out.p_W - p_W;
    normalized += error.dot(s.out.cov.inverse() * error) / (3.0 * runs);
  }
  EXPECT_NEAR(normalized, 1.0, 0.2);
}

TEST(triangulate, more_views_are_more_certain) {
  const Vec3 p_W(6, 0, 0);
  Scene two, many;
  for (int i = 0; i < 6; ++i) {
    SE3 T_WB;
    T_WB.p = Vec3(0, 0.1 * i, 0);
    for (int c = 0; c < 2; ++c) {
      if (i == 0) two.view(T_WB, c, p_W);
      many.view(T_WB, c, p_W);
    }
  }
  ASSERT_TRUE(two.solve() && many.solve());
  EXPECT_LT(many.out.cov.trace(), 0.2 * two.out.cov.trace());
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(two.out.cov);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), 0);
  EXPECT_GT(std::fabs(eigen.eigenvectors().col(2).x()), 0.99) << "depth is what is unsure";
}

TEST(triangulate, fewer_than_two_views_are_refused) {
  Scene s;
  EXPECT_FALSE(s.solve());
  s.view(SE3{}, 0, Vec3(4, 0, 0));
  EXPECT_FALSE(s.solve());
}

TEST(triangulate, parallel_rays_are_refused) {
  Scene far, twice;
  far.view(SE3{}, 0, Vec3(2000, 10, 5));
  far.view(SE3{}, 1, Vec3(2000, 10, 5));
  EXPECT_FALSE(far.solve());
  twice.view(SE3{}, 0, Vec3(4, 0, 0));
  twice.view(SE3{}, 0, Vec3(4, 0, 0));
  EXPECT_FALSE(twice.solve()) << "the same view twice";
}

TEST(triangulate, diverging_rays_meet_behind_the_cameras_and_are_refused) {
  Scene s;
  s.view(SE3{}, 0, Vec3(4, 0.8, 0));
  s.view(SE3{}, 1, Vec3(4, -0.8, 0));
  EXPECT_FALSE(s.solve());
}

TEST(triangulate, a_wrong_match_shows_in_the_residual) {
  Scene s;
  s.view(SE3{}, 0, Vec3(4, 0, 0));
  s.view(SE3{}, 1, Vec3(4, 0, 0));
  s.views[1].uv.y() += 12;  // off the epipolar line
  if (s.solve()) {
    EXPECT_GT(s.out.residual_px_max, 4);
  }
}

TEST(triangulate, not_a_number_is_refused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Scene good;
  good.view(SE3{}, 0, Vec3(4, 0, 0));
  good.view(SE3{}, 1, Vec3(4, 0, 0));
  ASSERT_TRUE(good.solve());
  for (int which = 0; which < 2; ++which) {
    Scene pixel = good, place = good, turn = good;
    pixel.views[static_cast<size_t>(which)].uv.x() = nan;
    place.views[static_cast<size_t>(which)].T_CW.p.z() = nan;
    turn.views[static_cast<size_t>(which)].T_CW.R(1, 1) = nan;
    for (Scene* s : {&pixel, &place, &turn}) {
      for (View& v : s->views) v.camera = &s->rig.camera[&v == &s->views[0] ? 0 : 1];
      EXPECT_FALSE(s->solve()) << which;
    }
  }
}

}  // namespace
}  // namespace pirvs
