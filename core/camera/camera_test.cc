#include "core/camera/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/math/trig.h"

namespace pirvs {
namespace {

Camera euroc() {
  Camera camera;
  camera.model = CameraModel::kPinholeRadtan;
  camera.width = 752, camera.height = 480;
  camera.fx = 458.654, camera.fy = 457.296, camera.cx = 367.215, camera.cy = 248.375;
  const double d[4] = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  std::copy(d, d + 4, camera.d);
  return camera;
}

Camera fisheye() {
  Camera camera;
  camera.model = CameraModel::kKannalaBrandt;
  camera.width = 640, camera.height = 480;
  camera.fx = 190.978, camera.fy = 190.973, camera.cx = 319.5, camera.cy = 239.5;
  const double d[4] = {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673};
  std::copy(d, d + 4, camera.d);
  return camera;
}

// A ray theta off the axis, at a random distance.
Vec3 random_point(std::mt19937& rng, double theta_max) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double theta = theta_max * unit(rng), angle = 2.0 * kPi * unit(rng);
  const double distance = 0.2 + 20.0 * unit(rng);
  return distance * Vec3(std::sin(theta) * std::cos(angle), std::sin(theta) * std::sin(angle),
                         std::cos(theta));
}

void expect_jacobian(const Camera& camera, double theta_max) {
  std::mt19937 rng(11);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p_C = random_point(rng, theta_max);
    Vec2 uv, uv_alone;
    Mat23 J, numeric;
    ASSERT_TRUE(camera.project(p_C, uv, J));
    ASSERT_TRUE(camera.project(p_C, uv_alone));
    ASSERT_EQ(uv, uv_alone);
    const double step = 1e-6 * p_C.norm();
    for (int k = 0; k < 3; ++k) {
      Vec2 plus, minus;
      ASSERT_TRUE(camera.project(p_C + step * Vec3::Unit(k), plus));
      ASSERT_TRUE(camera.project(p_C - step * Vec3::Unit(k), minus));
      numeric.col(k) = (plus - minus) / (2.0 * step);
    }
    EXPECT_LT((J - numeric).norm(), 1e-7 * J.norm()) << p_C.transpose()(0);
  }
}

void expect_round_trip(const Camera& camera, double theta_max) {
  std::mt19937 rng(12);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p_C = random_point(rng, theta_max);
    Vec2 uv;
    Vec3 bearing_C;
    ASSERT_TRUE(camera.project(p_C, uv));
    ASSERT_TRUE(camera.unproject(uv, bearing_C));
    EXPECT_NEAR(bearing_C.norm(), 1.0, 1e-15);
    EXPECT_LT((bearing_C - p_C.normalized()).norm(), 1e-12);
  }
}

TEST(Camera, RadtanJacobianMatchesNumeric) { expect_jacobian(euroc(), 0.9); }
TEST(Camera, KannalaBrandtJacobianMatchesNumeric) { expect_jacobian(fisheye(), 1.9); }
TEST(Camera, RadtanRoundTrip) { expect_round_trip(euroc(), 0.9); }
TEST(Camera, KannalaBrandtRoundTripPast90Degrees) { expect_round_trip(fisheye(), 1.9); }

TEST(Camera, EveryPixelHasARay) {
  for (const Camera& camera : {euroc(), fisheye()}) {
    for (int y = 0; y < camera.height; y += 7) {
      for (int x = 0; x < camera.width; x += 7) {
        Vec3 bearing_C;
        Vec2 uv;
        ASSERT_TRUE(camera.unproject(Vec2(x, y), bearing_C)) << x << " " << y;
        ASSERT_TRUE(camera.project(bearing_C, uv));
        ASSERT_LT((uv - Vec2(x, y)).norm(), 1e-9);
      }
    }
  }
}

// Values of cv::projectPoints and cv::fisheye::projectPoints for (0.5, -0.3, 1.0).
TEST(Camera, AgreesWithOpenCv) {
  Vec2 uv;
  ASSERT_TRUE(euroc().project(Vec3(0.5, -0.3, 1.0), uv));
  EXPECT_LT((uv - Vec2(576.385155769302, 123.276240971480)).norm(), 1e-9);
  ASSERT_TRUE(fisheye().project(Vec3(0.5, -0.3, 1.0), uv));
  EXPECT_LT((uv - Vec2(406.034537330963, 187.580636939210)).norm(), 1e-9);
}

TEST(Camera, AxisIsNoSpecialCase) {
  for (const Camera& camera : {euroc(), fisheye()}) {
    Vec2 uv;
    Mat23 J;
    ASSERT_TRUE(camera.project(Vec3(0.0, 0.0, 2.0), uv, J));
    EXPECT_EQ(uv, Vec2(camera.cx, camera.cy));
    EXPECT_NEAR(J(0, 0), camera.fx / 2.0, 1e-12);
    EXPECT_NEAR(J(1, 1), camera.fy / 2.0, 1e-12);
    EXPECT_NEAR(J(0, 1), 0.0, 1e-12);
    Vec3 bearing_C;
    ASSERT_TRUE(camera.unproject(Vec2(camera.cx, camera.cy), bearing_C));
    EXPECT_EQ(bearing_C, Vec3::UnitZ());
    EXPECT_FALSE(camera.project(Vec3(0.0, 0.0, -1.0), uv));
    EXPECT_FALSE(camera.project(Vec3(NAN, 0.0, 1.0), uv));
  }
  Vec2 uv;
  EXPECT_FALSE(euroc().project(Vec3(1.0, 1.0, 0.0), uv));
  EXPECT_TRUE(fisheye().project(Vec3(1.0, 1.0, 0.0), uv));
}

TEST(Camera, RadtanRejectsBeyondTheFold) {
  Camera camera = euroc();
  camera.d[0] = -0.3, camera.d[1] = 0.0, camera.d[2] = camera.d[3] = 0.0;
  // r (1 - 0.3 r^2) rises until 0.9 r^2 = 1.
  const double fold = std::sqrt(1.0 / 0.9);
  Vec2 uv;
  Vec3 bearing_C;
  EXPECT_TRUE(camera.project(Vec3(fold - 1e-6, 0.0, 1.0), uv));
  EXPECT_FALSE(camera.project(Vec3(fold + 1e-6, 0.0, 1.0), uv));
  EXPECT_FALSE(camera.unproject(Vec2(camera.cx + 0.71 * camera.fx, camera.cy), bearing_C));
  // With k2 the curve dips and rises again; what lies behind the dip stays out.
  camera.d[0] = -0.5, camera.d[1] = 0.1;
  EXPECT_TRUE(camera.project(Vec3(0.9, 0.0, 1.0), uv));
  EXPECT_FALSE(camera.project(Vec3(1.2, 0.0, 1.0), uv));
  EXPECT_FALSE(camera.project(Vec3(3.0, 0.0, 1.0), uv));
}

// The image radius grows faster than the angle, until it turns back: Newton's first guess, the
// radius, lies beyond the fold, and the ray is there all the same.
TEST(Camera, KannalaBrandtFindsTheRayFromBeyondTheFold) {
  const double models[][4] = {
      {0.4, -0.12, 0.0, 0.0},  // slope 1 + 1.2 u - 0.6 u^2: folds at 1.62, radius 1.98
      {0.8, -0.5, 0.05, 0.0},  // folds earlier
      {0.1, 0.2, -0.15, 0.01}};
  constexpr double kNear = 0.01;  // of the fold, where the radius hardly grows
  for (const auto& d : models) {
    Camera camera = fisheye();
    std::copy(d, d + 4, camera.d);
    int rays = 0, beyond = 0;
    for (double theta = 0.01; theta < 2.5; theta += 0.01) {
      const Vec3 p_C(std::sin(theta) * 0.6, std::sin(theta) * 0.8, std::cos(theta));
      Vec2 uv;
      Vec3 bearing_C;
      if (!camera.project(p_C, uv)) break;
      ++rays;
      const double radius =
          Vec2((uv.x() - camera.cx) / camera.fx, (uv.y() - camera.cy) / camera.fy).norm();
      Vec2 there;
      beyond += !camera.project(Vec3(std::sin(radius), 0.0, std::cos(radius)), there);
      const bool at_the_fold =
          !camera.project(Vec3(std::sin(theta + kNear) * 0.6, std::sin(theta + kNear) * 0.8,
                               std::cos(theta + kNear)),
                          there);
      if (at_the_fold) break;
      ASSERT_TRUE(camera.unproject(uv, bearing_C)) << d[0] << " " << theta;
      EXPECT_LT((bearing_C - p_C).norm(), 1e-6) << d[0] << " " << theta;
    }
    EXPECT_GT(rays, 50);
    EXPECT_GT(beyond, 0) << d[0];
  }
}

TEST(Camera, KannalaBrandtRejectsBeyondTheFold) {
  Camera camera = fisheye();
  const double d[4] = {-0.3, 0.03, 0.0, 0.0};  // slope 1 - 0.9 u + 0.15 u^2: roots 1.46 and 4.54
  std::copy(d, d + 4, camera.d);
  const auto accepts = [&camera](double theta) {
    Vec2 uv;
    return camera.project(Vec3(std::sin(theta), 0.0, std::cos(theta)), uv);
  };
  const double fold = std::sqrt((0.9 - std::sqrt(0.81 - 0.6)) / 0.3);
  EXPECT_TRUE(accepts(fold - 1e-6));
  EXPECT_FALSE(accepts(fold + 1e-6));
  EXPECT_FALSE(accepts(std::sqrt(5.0)));
  Vec3 bearing_C;
  EXPECT_FALSE(camera.unproject(Vec2(camera.cx + camera.fx * 2.0, camera.cy), bearing_C));
}

TEST(Camera, ImageBorder) {
  const Camera camera = euroc();
  EXPECT_TRUE(camera.in_image(Vec2(0.0, 0.0), 0.0));
  EXPECT_TRUE(camera.in_image(Vec2(751.0, 479.0), 0.0));
  EXPECT_FALSE(camera.in_image(Vec2(751.1, 479.0), 0.0));
  EXPECT_FALSE(camera.in_image(Vec2(7.9, 100.0), 8.0));
  EXPECT_FALSE(camera.in_image(Vec2(NAN, 100.0), 8.0));
}

}  // namespace
}  // namespace pirvs
