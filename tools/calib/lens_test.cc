#include "tools/calib/lens.h"

#include <gtest/gtest.h>

#include "modules/testing.h"

namespace pirvs::tools {
namespace {

TEST(lens, derivatives_by_intrinsics_match_numeric) {
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    testing::Random random(3);
    const Camera camera = testing::lens(model);
    for (int n = 0; n < 100; ++n) {
      const Vec3 p_C(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 1);
      Vec2 uv;
      Mat23 J;
      Mat28 J_lens;
      ASSERT_TRUE(project(camera, p_C, uv, J, J_lens));
      for (int i = 0; i < kLensSize; ++i) {
        const double step = i < 4 ? 1e-3 : 1e-6;
        LensVector lens = lens_of(camera);
        Camera moved = camera;
        Vec2 a, b;
        lens[i] -= step;
        set_lens(lens.data(), moved);
        ASSERT_TRUE(moved.project(p_C, a));
        lens[i] += 2 * step;
        set_lens(lens.data(), moved);
        ASSERT_TRUE(moved.project(p_C, b));
        EXPECT_LT((J_lens.col(i) - (b - a) / (2 * step)).norm(), 1e-5 * (1 + J_lens.col(i).norm()))
            << kLensNames[i];
      }
    }
  }
}

TEST(lens, on_the_axis_distortion_moves_nothing) {
  const Camera camera = testing::lens(CameraModel::kKannalaBrandt);
  Vec2 uv;
  Mat23 J;
  Mat28 J_lens;
  ASSERT_TRUE(project(camera, Vec3(0, 0, 2), uv, J, J_lens));
  EXPECT_EQ((J_lens.rightCols<4>().norm()), 0);
}

}  // namespace
}  // namespace pirvs::tools
