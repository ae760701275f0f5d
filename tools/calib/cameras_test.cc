#include "tools/calib/cameras.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/so3.h"
#include "modules/testing.h"
#include "tools/calib/tag_image.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr double kNoise_px = 0.1;

Target small_board() {
  Target target;
  target.columns = target.rows = 4;
  return target;
}

// A device held by hand: near and far, tilted and rolled, the board anywhere in the image.
std::vector<Shot> views_of(const Target& target, const CameraRig& rig, int count, double tilt,
                           double aside) {
  testing::Random random(5);
  std::vector<Shot> out;
  for (int n = 0; n < count; ++n) {
    const double far = random.uniform(0.7, 1.6) * target.diagonal_m();
    const Mat3 facing = so3_exp(Vec3(M_PI, 0, 0));  // the board's z towards the camera
    SE3 T_CT;
    // Braces: in this order with any compiler.
    const Vec3 turn{random.uniform(-tilt, tilt), random.uniform(-tilt, tilt),
                    random.uniform(-1, 1)};
    T_CT.R = so3_exp(turn) * facing;
    const Vec3 middle{random.uniform(-aside, aside) * far, random.uniform(-0.7, 0.7) * aside * far,
                      far};
    T_CT.p = middle - T_CT.R * target.middle_T();
    Shot shot;
    shot.t = TimeNs{50'000'000} * n;
    for (int c = 0; c < rig.cameras; ++c) {
      shot.view[c].t = shot.t;
      for (int tag = 0; tag < target.tags(); ++tag) {
        TagImage image;
        const SE3 T_C1T = rig.T_C1C0 * T_CT;
        if (!project_tag(rig.camera[c], target, c == 0 ? T_CT : T_C1T, tag, image)) continue;
        const Vec2 uv = image.uv + random.pixel(kNoise_px);
        if (rig.camera[c].in_image(uv, 10)) shot.view[c].tags.push_back({tag, uv});
      }
    }
    out.push_back(shot);
  }
  return out;
}

CameraRig rig_of(CameraModel model) {
  CameraRig rig;
  rig.cameras = 2;
  rig.camera[0] = rig.camera[1] = testing::lens(model);
  rig.camera[1].fx += 3;
  rig.camera[1].cy -= 4;
  rig.T_C1C0 = {so3_exp(Vec3(0.01, -0.02, 0.005)), Vec3(-0.11, 0.002, 0.001)};
  return rig;
}

TEST(cameras, are_found_from_nothing_within_their_sigmas) {
  const Target target = small_board();
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    const CameraRig truth = rig_of(model);
    CameraOptions how;
    how.model = model;
    how.size = {truth.camera[0].width, truth.camera[0].height};
    const double aside = model == CameraModel::kPinholeRadtan ? 0.5 : 2.0;  // up to the rims
    const std::vector<Shot> shots = views_of(target, truth, 140, 0.6, aside);
    const CameraResult found = calibrate_cameras(target, shots, 2, how);
    EXPECT_NEAR(found.adjustment.sigma_px, kNoise_px, 0.015);
    double squares = 0;
    for (int c = 0; c < 2; ++c) {
      const LensVector error = lens_of(found.rig.camera[c]) - lens_of(truth.camera[c]);
      for (int i = 0; i < kLensSize; ++i) {
        const double sigma = std::sqrt(found.adjustment.covariance(8 * c + i, 8 * c + i));
        EXPECT_LT(std::abs(error[i]), 4 * sigma) << "cam" << c << " " << kLensNames[i];
        squares += error[i] * error[i] / (sigma * sigma);
      }
    }
    EXPECT_GT(squares, 2);  // sigmas that are not far too large
    EXPECT_NEAR(found.rig.T_C1C0.p.norm(), truth.T_C1C0.p.norm(), 2e-4);
  }
}

TEST(cameras, too_few_views_are_named) {
  const Target target = small_board();
  const CameraRig truth = rig_of(CameraModel::kPinholeRadtan);
  CameraOptions how;
  how.size = {752, 480};
  how.model = CameraModel::kPinholeRadtan;
  try {
    calibrate_cameras(target, views_of(target, truth, 8, 0.6, 0.5), 2, how);
    FAIL() << "8 views are enough?";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("too few images"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace pirvs::tools
