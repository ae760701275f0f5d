#include "tools/dataset/calibration/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <random>

namespace pirvs::tools {
namespace {

Lens lens(Projection projection, Distortion distortion, double a, double b,
          std::initializer_list<double> d, std::array<double, 6> size_and_k) {
  Lens out;
  out.projection = projection;
  out.distortion = distortion;
  out.width = int(size_and_k[0]);
  out.height = int(size_and_k[1]);
  out.fx = size_and_k[2], out.fy = size_and_k[3], out.cx = size_and_k[4], out.cy = size_and_k[5];
  out.a = a;
  out.b = b;
  std::copy(d.begin(), d.end(), out.d.begin());
  return out;
}

struct Real {
  const char* what;
  Lens lens;
  double error_px_max;
};

// Lenses of real calibrations.
std::vector<Real> real_lenses() {
  using P = Projection;
  using D = Distortion;
  return {
      {"double sphere, 1440 x 1080 halved",
       lens(P::kDoubleSphere, D::kNone, -0.19963086018860057, 0.5924590037637837, {},
            {720, 540, 158.78, 158.09, 362.43, 273.29}),
       0.1},
      {"EUCM", lens(P::kEucm, D::kNone, 0.6, 1.1, {}, {640, 480, 230.1, 230.4, 319.2, 241.3}), 0.1},
      {"omni",
       lens(P::kOmni, D::kRadtan, 3.320943260749003, 0,
            {0.6711385962510382, 12.74476648953634, -0.0007325429487165742, -0.0004169991326278497},
            {640, 480, 1197.12459604134, 1198.5870310209943, 308.64402245225887,
             241.52711951080227}),
       0.1},
      {"FOV",
       lens(
           P::kPinhole, D::kFov, 0, 0, {0.962084349711143},
           {752, 480, 334.23991339518517, 333.6035571693483, 368.20264278064553, 252.393048692916}),
       0.1},
      {"radtan with k3, a colour camera",
       lens(P::kPinhole, D::kRadtan, 0, 0, {-0.056522, 0.068801, -0.000717, -0.000025, -0.022386},
            {640, 480, 379.5, 379.2, 319.9, 242.0}),
       0.1},
      // Too bent for either: the fit says so.
      {"rational, a colour camera",
       lens(P::kPinhole, D::kRadtan, 0, 0,
            {0.4937, -2.6676, 0.000798, 0.000172, 1.5424, 0.3729, -2.4870, 1.4671},
            {1280, 720, 608.0, 607.8, 640.6, 366.7}),
       0.5}};
}

TEST(lens, real_lenses_are_fitted) {
  for (const Real& real : real_lenses()) {
    const LensFit found = fit(real.lens);
    EXPECT_FALSE(found.exact);
    EXPECT_LT(found.error_px, real.error_px_max) << real.what;
    EXPECT_LT(found.corner_px, 30 * real.error_px_max) << real.what;
    EXPECT_LE(found.error_px, found.corner_px);
    std::printf("%-36s %s  %.4f px, %.3f in the corners\n", real.what,
                found.camera.model == CameraModel::kPinholeRadtan ? "radtan     " : "equidistant",
                found.error_px, found.corner_px);
    // What the fit says of itself holds between the pixels that it was made of.
    std::mt19937 rng(5);
    std::uniform_real_distribution<double> side(-0.5, 0.5);
    for (int i = 0; i < 200; ++i) {
      const Vec3 p_C(side(rng), side(rng), 1);
      Vec2 there, here;
      ASSERT_TRUE(real.lens.project(p_C, there));
      ASSERT_TRUE(found.camera.project(p_C, here));
      EXPECT_LT((here - there).norm(), 1.2 * found.error_px + 1e-3) << real.what;
    }
  }
}

TEST(lens, rays_are_those_of_the_pixels) {
  for (const Real& real : real_lenses()) {
    Lens small = real.lens;  // for the time that it takes
    constexpr int kSmaller = 16;
    small.width /= kSmaller;
    small.height /= kSmaller;
    for (double* const k : {&small.fx, &small.fy, &small.cx, &small.cy}) *k /= kSmaller;
    const std::vector<Vec3> rays = rays_of(small);
    const auto width = size_t(small.width);
    ASSERT_EQ(rays.size(), width * size_t(small.height));
    size_t seen = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      if (rays[i].isZero(0)) continue;
      ++seen;
      Vec2 uv;
      ASSERT_TRUE(small.project(rays[i], uv)) << real.what;
      EXPECT_NEAR(uv.x(), double(i % width), 1e-6) << real.what;
      EXPECT_NEAR(uv.y(), double(i / width), 1e-6) << real.what;
    }
    EXPECT_GT(seen, rays.size() * 9 / 10) << real.what;
  }
}

TEST(lens, what_the_stack_has_is_taken_as_it_is) {
  const std::array<double, 6> k = {640, 480, 385.7, 385.2, 323.1, 236.7};
  const LensFit none = fit(lens(Projection::kPinhole, Distortion::kNone, 0, 0, {}, k));
  EXPECT_TRUE(none.exact);
  EXPECT_EQ(none.camera.model, CameraModel::kPinholeRadtan);
  EXPECT_EQ(none.camera.d[0], 0);
  EXPECT_EQ(none.camera.cy, 236.7);
  const LensFit radtan =
      fit(lens(Projection::kPinhole, Distortion::kRadtan, 0, 0, {-0.28, 0.07, 0.0002, 1e-5}, k));
  EXPECT_TRUE(radtan.exact);
  EXPECT_EQ(radtan.camera.d[3], 1e-5);
  const LensFit fisheye = fit(lens(Projection::kPinhole, Distortion::kEquidistant, 0, 0,
                                   {0.003, 0.0007, -0.002, 0.0002}, k));
  EXPECT_TRUE(fisheye.exact);
  EXPECT_EQ(fisheye.camera.model, CameraModel::kKannalaBrandt);
}

TEST(lens, a_principal_point_far_off_is_refused_at_once) {
  Lens far = real_lenses()[1].lens;
  for (const double cx : {1e9, 1e300, -1e12}) {
    far.cx = cx;
    EXPECT_GT(fit(far).error_px, 0.1) << cx;
  }
}

TEST(lens, a_lens_that_neither_model_has_says_how_far_it_is_off) {
  // Decentred beyond what a fisheye can be, wider than a plane can hold.
  const LensFit found = fit(lens(Projection::kOmni, Distortion::kRadtan, 1.5, 0,
                                 {-0.1, 0.02, 0.02, -0.03}, {640, 480, 500, 500, 320, 240}));
  EXPECT_GT(found.error_px, 0.1);
}

// All 14 coefficients, those of a thin prism and of a tilted sensor too.
TEST(lens, radtan_is_opencvs) {
  Lens wide = real_lenses()[5].lens;
  const double rest[] = {0.001, -0.002, 0.003, 0.0005, 0.05, -0.03};
  std::copy(std::begin(rest), std::end(rest), wide.d.begin() + 8);
  const cv::Mat K = (cv::Mat_<double>(3, 3) << wide.fx, 0, wide.cx, 0, wide.fy, wide.cy, 0, 0, 1);
  std::vector<double> d(wide.d.begin(), wide.d.end());
  std::vector<cv::Point2d> out;
  const std::vector<cv::Point3d> points = {{0.3, -0.2, 1}, {-0.6, 0.4, 1}, {0, 0, 2}};
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), K, d, out);
  for (size_t i = 0; i < points.size(); ++i) {
    Vec2 uv;
    ASSERT_TRUE(wide.project(Vec3(points[i].x, points[i].y, points[i].z), uv));
    EXPECT_LT((uv - Vec2(out[i].x, out[i].y)).norm(), 1e-9);
  }
}

// By hand: z = 1, x = 1, so that |p| = sqrt(2).
TEST(lens, models_are_their_papers) {
  const Vec3 p_C(1, 0, 1);
  const std::array<double, 6> k = {640, 480, 100, 100, 0, 0};
  Vec2 uv;
  const double r2 = std::sqrt(2.0);
  ASSERT_TRUE(lens(Projection::kOmni, Distortion::kNone, 0.5, 0, {}, k).project(p_C, uv));
  EXPECT_NEAR(uv.x(), 100 / (1 + 0.5 * r2), 1e-12);
  ASSERT_TRUE(lens(Projection::kEucm, Distortion::kNone, 0.6, 1.5, {}, k).project(p_C, uv));
  EXPECT_NEAR(uv.x(), 100 / (0.6 * std::sqrt(1.5 + 1) + 0.4), 1e-12);
  ASSERT_TRUE(
      lens(Projection::kDoubleSphere, Distortion::kNone, -0.2, 0.6, {}, k).project(p_C, uv));
  const double z1 = -0.2 * r2 + 1;
  EXPECT_NEAR(uv.x(), 100 / (0.6 * std::sqrt(1 + z1 * z1) + 0.4 * z1), 1e-12);
  ASSERT_TRUE(lens(Projection::kPinhole, Distortion::kFov, 0, 0, {0.9}, k).project(p_C, uv));
  EXPECT_NEAR(uv.x(), 100 * std::atan(2 * std::tan(0.45)) / 0.9, 1e-12);
}

}  // namespace
}  // namespace pirvs::tools
