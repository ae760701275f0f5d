#include "modules/fusion/fusion.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <memory>
#include <vector>

#include "core/math/trig.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;

constexpr double kDeg = kPi / 180;

// A flight on the Earth, SLAM that drifts as its covariance says, and a receiver.
struct World {
  double sigma_m = 0.01, sigma_m_s = 0.05;  // of fixes; velocity: 0: none
  int fix_every = 4;                        // frames
  int fix_late = 0;                         // frames
  double claimed = 1;                       // sigma in the fix over the true one
  double drift_m = 0.005;                   // random walk of SLAM's frame, m/sqrt(s)
  double drift_rad = 2e-4;
  Vec3 p_BA = Vec3::Zero();
  double speed = 1;  // 0: hover
  SE3 T_EW = {so3_exp(Vec3(0, 0, 2.0)), Vec3(5, -3, 1)};

  explicit World(uint32_t seed) : random(seed) {
    fusion = std::make_unique<Fusion>();
    truth_frame = LocalFrame(Geodetic{47.4 * kDeg, 8.5 * kDeg, 450});
  }
  void begin() { fusion->configure({p_BA, 0}, params); }
  static constexpr double kFrame_s = 0.05;

  SE3 T_EB(double t) const {
    const double s = speed * t;
    SE3 out;
    out.p = Vec3(4 * std::sin(0.25 * s), 3 * std::sin(0.33 * s), 0.5 * std::sin(0.5 * s));
    out.R = so3_exp(Vec3(0, 0, 0.4 * s)) * so3_exp(Vec3(0.1 * std::sin(s), 0.1 * std::cos(s), 0));
    return out;
  }
  Vec3 v_E(double t) const { return (T_EB(t + 1e-4).p - T_EB(t - 1e-4).p) / 2e-4; }
  Vec3 w_B(double t) const {
    return so3_log(T_EB(t - 1e-4).R.transpose() * T_EB(t + 1e-4).R) / 2e-4;
  }
  static TimeNs stamp(double t) { return 1'000'000'000 + from_seconds(t); }

  Pose slam_at(double t) const {
    Pose out;
    const SE3 T_WB = T_drifted.inverse() * T_EB(t);
    out.state.t = stamp(t);
    out.state.T_WB = T_WB;
    out.state.v_WB = T_drifted.R.transpose() * v_E(t);
    out.w_B = w_B(t);
    out.health = HealthState::kTracking;
    out.trust.resets = resets;
    out.trust.jump_m = jump_m, out.trust.jump_rad = jump_rad;
    out.epoch = epoch;
    out.cov.setZero();
    for (int i = 0; i < 3; ++i) {
      out.cov(i, i) = drift_rad * drift_rad * t;
      out.cov(3 + i, 3 + i) = drift_m * drift_m * t;
    }
    return out;
  }
  GnssFix fix_at(double t) {
    const Vec3 p_E = T_EB(t) * p_BA + random.vec(sigma_m) + bias;
    const Geodetic place = truth_frame.to_global(p_E);
    GnssFix out;
    out.t = stamp(t);
    out.latitude_deg = place.latitude_rad / kDeg;
    out.longitude_deg = place.longitude_rad / kDeg;
    out.height_m = place.height_m;
    out.sigma_horizontal_m = out.sigma_vertical_m = claimed * sigma_m;
    out.type = GnssFixType::k3d;
    if (sigma_m_s > 0) {
      const Vec3 v = v_E(t) + T_EB(t).R * (skew(w_B(t)) * p_BA) + random.vec(sigma_m_s);
      out.v_ned = Vec3(v.y(), v.x(), -v.z());
      out.sigma_velocity_m_s = sigma_m_s;
      out.has_velocity = true;
    }
    return out;
  }
  // SLAM's frame turns and shifts about the body.
  void drift(double t) {
    const SE3 T = T_EB(t);
    const Mat3 turn = so3_exp(Vec3(0, 0, random.gauss(drift_rad * std::sqrt(kFrame_s))));
    T_drifted.p = T.p + turn * (T_drifted.p - T.p) + random.vec(drift_m * std::sqrt(kFrame_s));
    T_drifted.R = (turn * T_drifted.R).eval();
  }

  // To `end`, from where it was.
  void run(double end) {
    if (frame == 0) T_drifted = T_EW;
    for (; frame * kFrame_s < end - 1e-9; ++frame) {
      const double t = frame * kFrame_s;
      if (frame > 0) drift(t);
      if (slam_on) {
        fusion->add_pose(slam_at(t));
      } else {
        Pose none;
        none.state.t = stamp(t);
        none.health = HealthState::kLost;
        fusion->add_pose(none);
      }
      if (gnss_on && frame % fix_every == 0)
        waiting.push_back({frame + fix_late, fix_at(t + 0.02)});
      while (!waiting.empty() && waiting.front().frame <= frame) {
        fusion->add_fix(waiting.front().fix);
        waiting.erase(waiting.begin());
      }
      if (fusion->pose().health != FusionHealth::kNone) measure();
    }
  }
  Vec3 error() const {
    const FusedPose& pose = fusion->pose();
    const double t = to_seconds(pose.t - stamp(0));
    // E stands about the first fix: to the frame of the truth by way of the Earth.
    return truth_frame.to_local(fusion->frame().to_global(pose.T_EB.p)) - T_EB(t).p;
  }
  double heading_error() const {
    const double t = to_seconds(fusion->pose().t - stamp(0));
    return so3_log(T_EB(t).R.transpose() * fusion->pose().T_EB.R).norm();
  }
  void measure() {
    const Vec3 e = error();
    sum2 += e.squaredNorm(), worst = std::max(worst, e.norm());
    const Mat3 cov = fusion->pose().cov.block<3, 3>(3, 3);
    nees += e.dot(cov.llt().solve(e));
    ++count;
  }
  void forget() { sum2 = nees = worst = 0, count = 0; }
  double rms() const { return std::sqrt(sum2 / count); }
  uint32_t gate(FixGate g) const { return fusion->gates()[g]; }
  uint32_t event(FusionEvent e) const { return fusion->events()[e]; }

  struct Waiting {
    int frame;
    GnssFix fix;
  };
  Random random;
  FusionParams params;
  std::unique_ptr<Fusion> fusion;
  LocalFrame truth_frame;
  SE3 T_drifted;
  Vec3 bias = Vec3::Zero();
  bool slam_on = true, gnss_on = true;
  uint32_t resets = 1;
  uint16_t epoch = 1;
  float jump_m = 0, jump_rad = 0;
  int frame = 0;
  std::vector<Waiting> waiting;
  double sum2 = 0, nees = 0, worst = 0;
  int count = 0;
};

TEST(fusion, nothing_comes_out_before_a_fix) {
  World world(1);
  world.gnss_on = false;
  world.begin();
  world.run(2);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kNone);
  EXPECT_FALSE(world.fusion->has_origin());
}

TEST(fusion, rtk_aligns_and_holds_a_few_centimetres) {
  World world(2);
  world.begin();
  world.run(1);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kAligning);
  EXPECT_FALSE(world.fusion->pose().has_heading);
  world.run(30);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kFused);
  EXPECT_EQ(world.event(FusionEvent::kAligned), 1u);
  world.forget();
  world.run(90);
  EXPECT_LT(world.rms(), 0.02);
  EXPECT_LT(world.heading_error(), 0.5 * kDeg);
  EXPECT_EQ(world.gate(FixGate::kPosition), 0u);
  EXPECT_GT(world.fusion->pose().confidence, 0.95f);
}

TEST(fusion, fixes_of_metres_are_averaged_by_slam) {
  World world(3);
  world.sigma_m = 1.5;
  world.fix_every = 20;
  world.begin();
  world.run(60);
  world.forget();
  world.run(160);
  EXPECT_LT(world.rms(), 0.7);
  EXPECT_LT(world.heading_error(), 3 * kDeg);
}

TEST(fusion, the_lever_arm_of_the_antenna_is_taken_off) {
  World world(4);
  world.p_BA = Vec3(0.8, -0.3, 0.6);
  world.begin();
  world.run(30);
  world.forget();
  world.run(60);
  EXPECT_LT(world.rms(), 0.02);
  World other(4);  // the same flight, told that the antenna is at the body
  other.p_BA = Vec3(0.8, -0.3, 0.6);
  other.fusion->configure({Vec3::Zero(), 0}, other.params);
  other.run(60);
  EXPECT_GT(other.rms(), 0.3);
}

// 200 ms late, at 1 m/s: without the history every fix would be 0.2 m behind.
TEST(fusion, late_fixes_count_at_their_own_time) {
  World world(5);
  world.fix_late = 4;
  world.begin();
  world.run(30);
  world.forget();
  world.run(60);
  EXPECT_LT(world.rms(), 0.02);
  EXPECT_LE(world.gate(FixGate::kTooLate), 2u);  // one or two that an alignment overtook
  EXPECT_EQ(world.gate(FixGate::kPosition), 0u);
}

TEST(fusion, a_late_fix_gives_what_one_in_time_gives) {
  World in_time(6), late(6);
  in_time.begin(), late.begin();
  in_time.run(20), late.run(20);
  const GnssFix fix = late.fix_at(19.97);
  in_time.frame = late.frame;
  // In time: before the frames that follow it.
  in_time.fusion->add_fix(fix);
  for (int k = 0; k < 4; ++k) in_time.fusion->add_pose(in_time.slam_at(20 + 0.05 * k));
  for (int k = 0; k < 4; ++k) late.fusion->add_pose(late.slam_at(20 + 0.05 * k));
  late.fusion->add_fix(fix);
  EXPECT_EQ(in_time.fusion->pose().T_EB.p, late.fusion->pose().T_EB.p);
  EXPECT_EQ(in_time.fusion->pose().cov, late.fusion->pose().cov);
}

TEST(fusion, older_than_the_history_is_refused) {
  World world(7);
  world.begin();
  world.run(20);
  GnssFix old = world.fix_at(10);
  old.t = world.fusion->pose().t - 5'000'000'000;
  world.fusion->add_fix(old);
  EXPECT_EQ(world.gate(FixGate::kBackwards) + world.gate(FixGate::kTooLate), 1u);
}

TEST(fusion, multipath_of_30_m_is_gated_and_moves_nothing) {
  for (const double sigma : {0.01, 1.5}) {
    World world(8);
    world.sigma_m = sigma;
    world.begin();
    world.run(60);
    ASSERT_EQ(world.fusion->pose().health, FusionHealth::kFused);
    const Vec3 before = world.error();
    world.bias = Vec3(25, -15, 8);
    world.forget();
    world.run(80);
    EXPECT_GE(world.gate(FixGate::kPosition), 95u) << sigma;
    EXPECT_EQ(world.fusion->pose().health, FusionHealth::kSlamOnly);
    EXPECT_LT((world.error() - before).norm(), 0.2) << sigma;
    EXPECT_LT(world.worst, before.norm() + 0.2);
    world.bias.setZero();
    world.run(85);
    EXPECT_EQ(world.fusion->pose().health, FusionHealth::kFused);
    EXPECT_EQ(world.event(FusionEvent::kFixesBelieved), 0u);
  }
}

TEST(fusion, an_outage_is_bridged_by_slam) {
  World world(9);
  world.begin();
  world.run(60);
  world.gnss_on = false;
  world.run(62);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kFused);
  world.forget();
  const SE3 anchor = world.T_drifted;
  world.run(135);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kSlamOnly);
  EXPECT_EQ(world.fusion->pose().sources, kFromSlam);
  const SE3 T = world.T_EB(134.95);
  const double drifted = ((world.T_drifted * anchor.inverse()) * T.p - T.p).norm();
  EXPECT_LT(world.error().norm(), drifted + 0.1);
  // The covariance knows: 0.005 m/sqrt(s) for 75 s is 4 cm.
  const double told = std::sqrt(world.fusion->pose().cov(3, 3));
  EXPECT_GT(told, 0.03);
  EXPECT_LT(told, 0.15);
  world.gnss_on = true;
  world.run(140);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kFused);
  EXPECT_LT(world.error().norm(), 0.03);
}

TEST(fusion, without_slam_gnss_carries_the_position_and_says_so) {
  World world(10);
  world.begin();
  world.run(60);
  world.slam_on = false;
  world.run(70);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kGnssOnly);
  EXPECT_EQ(world.fusion->pose().sources, kFromGnss);
  EXPECT_FALSE(world.fusion->pose().has_heading);
  EXPECT_LT(world.error().norm(), 0.3);
  // Back in the same world: the anchor still holds.
  world.slam_on = true;
  ++world.resets;
  world.run(71);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kFused);
  EXPECT_EQ(world.event(FusionEvent::kFoundBack), 1u);
  EXPECT_LT(world.error().norm(), 0.1);
  EXPECT_LT(world.heading_error(), 1 * kDeg);
}

// No frames at all, as at a recording's end: nobody says that SLAM is lost.
TEST(fusion, when_frames_stay_away_the_heading_is_given_up) {
  World world(20);
  world.begin();
  world.run(60);
  for (int k = 1; k <= 10; ++k) {
    world.fusion->add_fix(world.fix_at(60 + 0.2 * k));
    EXPECT_TRUE(k < 2 || world.fusion->pose().health == FusionHealth::kGnssOnly) << k;
  }
  EXPECT_FALSE(world.fusion->pose().has_heading);
  EXPECT_EQ(world.event(FusionEvent::kHeadingLost), 1u);
  world.frame += 45;
  ++world.resets;
  world.run(64);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kFused);
  EXPECT_LT(world.heading_error(), 1 * kDeg);
}

TEST(fusion, another_epoch_after_a_loss_is_aligned_anew) {
  World world(11);
  world.begin();
  world.run(60);
  world.slam_on = false;
  world.run(70);
  world.slam_on = true;
  ++world.resets, ++world.epoch;
  world.T_drifted = {so3_exp(Vec3(0, 0, -1)), Vec3(40, 40, 0)};
  world.run(71);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kAligning);
  world.run(100);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kFused);
  EXPECT_EQ(world.event(FusionEvent::kAligned), 2u);
  EXPECT_LT(world.error().norm(), 0.05);
}

TEST(fusion, without_both_the_covariance_grows_and_confidence_falls) {
  World world(12);
  world.begin();
  world.run(60);
  world.slam_on = world.gnss_on = false;
  world.run(62);
  const FusedPose soon = world.fusion->pose();
  world.run(70);
  const FusedPose& late = world.fusion->pose();
  EXPECT_EQ(late.health, FusionHealth::kDeadReckoning);
  EXPECT_EQ(late.sources, 0);
  EXPECT_GT(late.cov(3, 3), 10 * soon.cov(3, 3));
  EXPECT_LT(late.confidence, 0.1f);
  EXPECT_LT(late.confidence, soon.confidence);
}

TEST(fusion, the_anchor_goes_along_when_slam_jumps) {
  World world(13);
  world.begin();
  world.run(60);
  const double before = world.error().norm();
  const uint32_t told = world.fusion->pose().resets;
  world.T_drifted = {so3_exp(Vec3(0, 0, 0.3)) * world.T_drifted.R,
                     world.T_drifted.p + Vec3(3, 2, 0)};
  ++world.resets;
  world.jump_m = 4, world.jump_rad = 0.3f;
  world.forget();
  world.run(60.5);
  EXPECT_EQ(world.event(FusionEvent::kAnchoredAnew), 1u);
  EXPECT_LT(world.worst, before + 0.05);
  // One that SLAM does not tell of.
  world.T_drifted = {so3_exp(Vec3(0, 0, -0.3)) * world.T_drifted.R,
                     world.T_drifted.p - Vec3(1, 1, 0)};
  world.run(61);
  EXPECT_EQ(world.event(FusionEvent::kSlamJumped), 1u);
  EXPECT_LT(world.worst, before + 0.05);
  EXPECT_EQ(world.fusion->pose().resets, told);
}

TEST(fusion, hover_does_not_align) {
  for (const double sigma : {0.01, 1.5}) {
    World world(14);
    world.sigma_m = sigma;
    world.speed = 0;
    world.begin();
    world.run(60);
    EXPECT_EQ(world.fusion->pose().health, FusionHealth::kAligning);
    EXPECT_EQ(world.event(FusionEvent::kAligned), 0u);
  }
}

TEST(fusion, a_frozen_receiver_is_found_out) {
  World world(15);
  world.sigma_m = 1.5;
  world.begin();
  world.run(60);
  world.gnss_on = false;
  GnssFix frozen = world.fix_at(60);
  for (int k = 0; k < 20; ++k) {
    world.run(60.5 + 0.5 * k);
    frozen.t = world.fusion->pose().t;
    world.fusion->add_fix(frozen);
  }
  EXPECT_GE(world.gate(FixGate::kFrozen), 15u);
}

// It claims a centimetre and holds a metre: gated at first, then taken for what it is.
TEST(fusion, a_receiver_that_claims_too_much_is_told_and_weighed_anew) {
  World world(16);
  world.sigma_m_s = 0;
  world.begin();
  world.run(60);
  world.sigma_m = 1.0, world.claimed = 0.01;
  world.run(90);
  EXPECT_GT(world.gate(FixGate::kPosition), 80u);
  world.run(150);
  EXPECT_GE(world.event(FusionEvent::kFixesBelieved), 1u);
  const uint32_t rejected = world.gate(FixGate::kPosition);
  world.forget();
  world.run(200);
  EXPECT_LT(world.gate(FixGate::kPosition), rejected + 15);
  EXPECT_LT(world.rms(), 0.7);
}

TEST(fusion, nonsense_is_counted_by_name) {
  World world(17);
  world.begin();
  world.run(20);
  GnssFix fix = world.fix_at(20);
  const FusedPose before = world.fusion->pose();
  fix.t = before.t + 1;
  for (const double bad : {100.0, static_cast<double>(NAN), HUGE_VAL}) {
    GnssFix wrong = fix;
    wrong.latitude_deg = bad;
    world.fusion->add_fix(wrong);
  }
  GnssFix wrong = fix;
  wrong.v_ned.x() = NAN;
  world.fusion->add_fix(wrong);
  EXPECT_EQ(world.gate(FixGate::kNotFinite), 4u);
  wrong = fix;
  wrong.type = GnssFixType::kNone;
  world.fusion->add_fix(wrong);
  EXPECT_EQ(world.gate(FixGate::kNoFix), 1u);
  wrong = fix;
  wrong.sigma_horizontal_m = 1000;
  world.fusion->add_fix(wrong);
  EXPECT_EQ(world.gate(FixGate::kUncertain), 1u);
  EXPECT_EQ(world.fusion->pose().T_EB.p, before.T_EB.p);
}

TEST(fusion, time_that_breaks_begins_anew_in_the_same_frame) {
  World world(18);
  world.begin();
  world.run(30);
  world.fusion->interrupt();
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kNone);
  EXPECT_TRUE(world.fusion->has_origin());
  world.run(60);
  EXPECT_EQ(world.fusion->pose().health, FusionHealth::kFused);
  EXPECT_LT(world.error().norm(), 0.05);
}

// Mean over flights of the NEES of the position, 3 where the covariance is honest.
TEST(fusion, nees_of_the_position) {
  for (const double sigma : {0.01, 1.5}) {
    double sum = 0;
    constexpr int kFlights = 10;
    for (int i = 0; i < kFlights; ++i) {
      World world(100 + static_cast<uint32_t>(i));
      world.sigma_m = sigma;
      world.fix_every = sigma > 1 ? 20 : 4;
      world.begin();
      world.run(60);
      world.forget();
      world.run(120);
      sum += world.nees / world.count / kFlights;
    }
    std::printf("sigma %.2f m: NEES of the position %.2f\n", sigma, sum);
    EXPECT_GT(sum, 1.0);
    EXPECT_LT(sum, 4.5);
  }
}

}  // namespace
}  // namespace pirvs
