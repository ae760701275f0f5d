#include "modules/tracking/pair_check.h"

#include <gtest/gtest.h>

#include "core/math/so3.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;

constexpr TimeNs kFrame = 50'000'000;

// Three seconds of a body that sways; the right camera sees `late_s` after its stamps and stands
// turned by `turn_B`. `share`: where between the two cameras' poses the fused one lies.
struct Case {
  double late_s = 0;
  Vec3 turn_B = Vec3::Zero();
  double share = 0;
  int frames = 60;
  PairCheck check{};

  void run() {
    const Rig rig(CameraModel::kPinholeRadtan);
    Random random(4);
    const Sway sway;
    for (int k = 1; k <= frames; ++k) {
      const double t_s = k * to_seconds(kFrame);
      const BodyState fused = sway.state(t_s + share * late_s);
      Vec6 rate;
      rate << sway.imu(t_s).w_B, fused.v_WB;
      check.begin_frame(k * kFrame, rate);
      for (int i = 0; i < 40; ++i) {
        const int c = i % kCamerasMax;
        const SE3 T_CB = rig.camera[c].T_BC.inverse();
        Vec3 f_C;
        const Vec2 uv(random.uniform(40, 700), random.uniform(40, 440));
        ASSERT_TRUE(rig.camera[c].unproject(uv, f_C));
        const Vec3 p_W = fused.T_WB * (rig.camera[c].T_BC * Vec3(random.uniform(2, 8) * f_C));
        SE3 T_WB = sway.state(t_s + (c == 1 ? late_s : 0)).T_WB;
        if (c == 1) T_WB.R = T_WB.R * so3_exp(turn_B);
        Correspondence seen{p_W, Mat3::Identity() * 1e-6, Vec2::Zero(), 1.0, c, Gate::kAccepted};
        if (!rig.see(T_WB, c, p_W, seen.uv)) continue;
        seen.uv += random.pixel(0.5);
        Reprojection m;
        if (linearize_reprojection(fused.T_WB, seen, rig.camera[c], T_CB, 1, m)) check.add(c, m);
      }
    }
  }
};

TEST(pair_check, tells_how_late_the_right_camera_is_wherever_the_pose_lies) {
  for (const double share : {0.0, 0.5, 1.0}) {
    Case late{0.010, Vec3::Zero(), share};
    late.run();
    const PairCheck::Verdict pair = late.check.verdict();
    EXPECT_NEAR(pair.late_s, 0.010, 0.0015) << share;
    EXPECT_LT(pair.late_sigma_s, 0.0015);
    EXPECT_LT(pair.turn_B.norm(), 0.003);
    EXPECT_TRUE(pair.disagree());
  }
}

TEST(pair_check, tells_a_camera_that_is_turned) {
  Case bent{0, Vec3(0.009, -0.004, 0.003)};
  bent.run();
  const PairCheck::Verdict pair = bent.check.verdict();
  EXPECT_LT((pair.turn_B - bent.turn_B).norm(), 0.002);
  EXPECT_LT(std::abs(pair.late_s), 0.001);
  EXPECT_TRUE(pair.disagree());
}

TEST(pair_check, agrees_with_what_is_right) {
  Case good;
  for (int k = 0; k < 5; ++k) {
    good.run();
    EXPECT_FALSE(good.check.verdict().disagree());
    EXPECT_FALSE(good.check.judge(k * 60 * kFrame, 0, Vec3::Zero()));
  }
  EXPECT_FALSE(PairCheck().verdict().disagree()) << "nothing seen";
}

// Both together are late by half of it: the left one is right, or the right one is.
TEST(pair_check, leaves_out_the_camera_that_does_not_fit_the_imu) {
  for (const bool left_is_right : {true, false}) {
    Case late{0.010};
    const double both_s = left_is_right ? 0.005 : -0.005;
    TimeNs t = 0;
    bool left_out = false;
    for (int k = 1; k <= 20 && !left_out; ++k) {
      late.run();
      t = k * kFrame;
      left_out = late.check.judge(t, both_s, Vec3::Zero());
      EXPECT_TRUE(left_out || late.check.in_doubt());
    }
    ASSERT_TRUE(left_out);
    EXPECT_GE(t, 8 * kFrame) << "not at once";
    EXPECT_EQ(late.check.left_out(t), left_is_right ? 2 : 1);
    EXPECT_EQ(late.check.left_out(t + 11'000'000'000), 0) << "asked again";
    EXPECT_FALSE(late.check.verdict().disagree()) << "begins anew";
  }
}

TEST(pair_check, what_was_left_out_and_disagrees_again_stays_out) {
  PairCheck check;
  PairCheck::Verdict pair;
  pair.turn_B = Vec3(0.02, 0, 0);
  const TimeNs t = from_seconds(5), back = from_seconds(15.5);
  check.leave_out(t, pair, 0, Vec3(0.01, 0, 0));
  ASSERT_EQ(check.left_out(t), 2);
  ASSERT_EQ(check.left_out(back), 0);
  check.leave_out(back, pair, 0, Vec3(-0.01, 0, 0));
  EXPECT_EQ(check.left_out(back), 2) << "the map stands on the left one";
  EXPECT_EQ(check.left_out(back + from_seconds(19)), 2) << "for twice as long";
}

}  // namespace
}  // namespace pirvs
