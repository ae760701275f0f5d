#include "modules/tracking/turn_check.h"

#include <gtest/gtest.h>

#include "core/math/so3.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;

// A body that sways for so long and flies by what is 2 to 8 m away; the gyro says `axes` times what
// it should.
TurnCheck flown(const Mat3& axes, double seconds = 10, const Vec3& velocity_B = Vec3(0.3, 0.5, 0)) {
  const Rig rig(CameraModel::kPinholeRadtan);
  const Camera& camera = rig.camera[0];
  Random random(7);
  Sway sway;
  sway.angle_rad *= 2;  // of a flight with gusts
  TurnCheck check;
  constexpr double kFrame_s = 0.05;
  for (double t = 0; t < seconds; t += kFrame_s) {
    const Mat3 R_BlB = sway.state(t).T_WB.R.transpose() * sway.state(t + kFrame_s).T_WB.R;
    const SE3 T_BlB{R_BlB, kFrame_s * velocity_B};
    Tracks tracks;
    for (int i = 0; i < 80; ++i) {
      const Vec2 uv(random.uniform(30, 720), random.uniform(30, 450));
      Vec3 f_C;
      Vec2 now;
      if (!camera.unproject(uv, f_C)) continue;
      const Vec3 p_B = camera.T_BC * Vec3(random.uniform(2, 8) * f_C);
      if (!camera.project(camera.T_BC.inverse() * (T_BlB.inverse() * p_B), now)) continue;
      now += random.pixel(0.5);
      Track* const track = tracks.append();
      *track = Track{};
      track->age = 1;
      track->x_last = static_cast<float>(uv.x()), track->y_last = static_cast<float>(uv.y());
      track->x = static_cast<float>(now.x()), track->y = static_cast<float>(now.y());
    }
    check.add(camera, tracks, axes * so3_log(R_BlB), kFrame_s);
  }
  return check;
}

TEST(turn_check, a_gyro_that_fits_turns_with_the_image) {
  const TurnCheck check = flown(Mat3::Identity());
  EXPECT_GT(check.gain().diagonal().minCoeff(), 0.4);
  EXPECT_FALSE(check.against());
  // A circle about what is near: 2 m/s sideways for 1 rad/s is a radius of 2 m.
  EXPECT_FALSE(flown(Mat3::Identity(), 10, Vec3(0, 3, 0)).against());
  EXPECT_FALSE(TurnCheck().against()) << "nothing seen";
}

TEST(turn_check, axes_that_do_not_fit_are_told) {
  Mat3 exchanged;
  exchanged << 0, 1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_TRUE(flown(-Mat3::Identity()).against()) << "sign";
  EXPECT_TRUE(flown(Vec3(1, -1, 1).asDiagonal()).against()) << "mirrored";
  EXPECT_TRUE(flown(exchanged).against()) << "exchanged";
}

TEST(turn_check, noise_and_a_body_that_does_not_turn_tell_nothing) {
  EXPECT_FALSE(flown(1e-3 * Mat3::Identity()).against());
  EXPECT_FALSE(flown(-Mat3::Identity(), 0.1).against()) << "two frames";
}

}  // namespace
}  // namespace pirvs
