#include "modules/health/health.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace pirvs {
namespace {

constexpr TimeNs kSecond = 1'000'000'000;

struct HealthCase {
  HealthCase() {
    params.matches_min = 8;
    params.lost_s = 3;
    params.lost_sigma_m = 1;
    params.recover_matches = 12;
    params.recover_s = 0.1f;
    health.configure(params);
  }
  bool update(double t_s, int accepted, double sigma_m = 0.01, bool at_rest = false) {
    return health.update({from_seconds(t_s), accepted, accepted > 0 ? 12 : 0, sigma_m, at_rest});
  }
  float confidence() const { return health.trust().confidence; }
  HealthParams params;
  Health health;
};

TEST(health, begins_initializing_and_tracks_once_started) {
  HealthCase c;
  EXPECT_EQ(c.health.state(), HealthState::kInitializing);
  EXPECT_EQ(c.confidence(), 0);
  c.health.started(kSecond);
  EXPECT_EQ(c.health.state(), HealthState::kTracking);
  EXPECT_FALSE(c.update(2, 8)) << "no change";
}

TEST(health, few_matches_degrade_at_once_and_recovery_takes_more_for_longer) {
  HealthCase c;
  c.health.started(0);
  EXPECT_TRUE(c.update(1, 7));
  EXPECT_EQ(c.health.state(), HealthState::kDegraded);
  EXPECT_FALSE(c.update(1.05, 0));
  EXPECT_FALSE(c.update(1.10, 9)) << "enough to stay, not to return";
  EXPECT_FALSE(c.update(1.15, 12)) << "for too short a time";
  EXPECT_FALSE(c.update(1.20, 11));
  EXPECT_FALSE(c.update(1.25, 12));
  EXPECT_FALSE(c.update(1.30, 12));
  EXPECT_TRUE(c.update(1.36, 12));
  EXPECT_EQ(c.health.state(), HealthState::kTracking);
}

// Images and IMU may not belong together: nothing that fits earns trust, but rest is rest.
TEST(health, stamps_in_doubt_keep_the_confidence_low) {
  HealthCase c;
  c.health.started(0);
  c.update(1, 100);
  EXPECT_GT(c.confidence(), 0.9f);
  c.health.doubt_stamps(true);
  c.update(1.05, 100);
  EXPECT_LE(c.confidence(), 0.25f);
  c.update(1.10, 100, 0.01, true);
  EXPECT_GT(c.confidence(), 0.85f);
  c.health.doubt_stamps(false);
  c.update(1.15, 100);
  EXPECT_GT(c.confidence(), 0.9f);
}

// Lost takes both: long without matches, and uncertain. A device at rest in the dark is not lost.
TEST(health, lost_only_when_long_degraded_and_uncertain) {
  HealthCase c;
  c.health.started(0);
  (void)c.update(2, 0, 5.0);
  EXPECT_EQ(c.health.state(), HealthState::kDegraded) << "uncertain, but not for long";
  (void)c.update(10, 0, 0.9);
  EXPECT_EQ(c.health.state(), HealthState::kDegraded) << "long, but certain";
  EXPECT_TRUE(c.update(11, 0, 1.1));
  EXPECT_EQ(c.health.state(), HealthState::kLost);
  EXPECT_EQ(c.confidence(), 0);
  EXPECT_FALSE(c.update(12, 100)) << "only a start ends it";
}

TEST(health, matches_restart_the_clock) {
  HealthCase c;
  c.health.started(0);
  for (int i = 1; i < 10; ++i) {
    (void)c.update(2 * i, 20, 5.0);
    (void)c.update(2 * i + 1, 0, 5.0);
    EXPECT_EQ(c.health.state(), HealthState::kDegraded) << i;
  }
}

TEST(health, rest_needs_no_matches) {
  HealthCase c;
  c.health.started(0);
  EXPECT_FALSE(c.update(20, 0, 0.01, true));
  EXPECT_EQ(c.health.state(), HealthState::kTracking);
  EXPECT_GT(c.confidence(), 0.8);
}

TEST(health, confidence_falls_in_the_first_blind_frame_and_further_with_time) {
  HealthCase c;
  c.health.started(0);
  (void)c.update(1, 100);
  EXPECT_GT(c.confidence(), 0.95);
  (void)c.update(1.02, 0);
  EXPECT_LT(c.confidence(), 0.5);
  float before = c.confidence();
  for (double t_s = 1.1; t_s < 4; t_s += 0.1) {
    (void)c.update(t_s, 0);
    EXPECT_LT(c.confidence(), before);
    before = c.confidence();
  }
  EXPECT_LT(before, 0.1);
}

TEST(health, confidence_knows_number_spread_and_covariance) {
  HealthCase few, corner, unsure;
  for (HealthCase* c : {&few, &corner, &unsure}) c->health.started(0);
  (void)few.update(1, 10);
  EXPECT_LT(few.confidence(), 0.3);
  (void)corner.health.update({kSecond, 100, 1, 0.01, false});
  EXPECT_LT(corner.confidence(), 0.6);
  (void)unsure.update(1, 100, few.params.sigma_half_m);
  EXPECT_NEAR(unsure.confidence(), 0.5, 0.01);
}

TEST(health, jumps_are_counted_when_large_or_certain) {
  HealthCase c;
  EXPECT_FALSE(c.health.note_jump(0.9 * c.params.jump_m, 0, false));
  EXPECT_EQ(c.health.trust().resets, 0u);
  EXPECT_TRUE(c.health.note_jump(1.1 * c.params.jump_m, 0, false));
  EXPECT_TRUE(c.health.note_jump(0, 1.1 * c.params.jump_rad, false));
  EXPECT_TRUE(c.health.note_jump(0.001, 0, true));
  EXPECT_EQ(c.health.trust().resets, 3u);
  EXPECT_FLOAT_EQ(c.health.trust().jump_m, 0.001f);
}

TEST(health, every_state_has_a_name) {
  EXPECT_STREQ(name(HealthState::kInitializing), "initializing");
  EXPECT_STREQ(name(HealthState::kLost), "lost");
}

FrameEvidence sound(double t_s) {
  FrameEvidence e;
  e.t = from_seconds(t_s);
  e.accepted = 100;
  e.cells = 12;
  e.position_sigma_m = 0.01;
  return e;
}

// Runs for two seconds at 20 Hz with what `spoil` makes of each frame.
template <class Spoil>
void run(HealthCase& c, Spoil&& spoil) {
  for (int k = 1; k <= 40 && c.health.state() != HealthState::kLost; ++k) {
    FrameEvidence e = sound(0.05 * k);
    spoil(e);
    c.health.update(e);
  }
}

TEST(health, what_cannot_be_is_doubted_by_name) {
  struct Case {
    Reason reason;
    void (*spoil)(FrameEvidence&);
  };
  const Case cases[] = {
      {Reason::kRejected, [](FrameEvidence& e) { e.rejected = 90; }},
      {Reason::kAccelBias, [](FrameEvidence& e) { e.accel_bias_m_s2 = 2.5; }},
      {Reason::kGyroBias, [](FrameEvidence& e) { e.gyro_bias_rad_s = 0.7; }},
  };
  for (const Case& one : cases) {
    HealthCase c;
    c.health.started(0);
    run(c, one.spoil);
    EXPECT_EQ(c.health.trust().reasons, bit(one.reason)) << name(one.reason);
    EXPECT_LE(c.confidence(), 0.5f) << name(one.reason);
    EXPECT_EQ(c.health.state(), HealthState::kTracking) << name(one.reason);
    FrameEvidence last = sound(8);
    for (int k = 0; k < 20; ++k) {
      last.t += from_seconds(0.2);
      c.health.update(last);
    }
    EXPECT_EQ(c.health.trust().reasons, 0) << "it passes";
    EXPECT_GT(c.confidence(), 0.9f);
  }
}

TEST(health, what_is_hopeless_is_lost_within_a_second) {
  for (void (*spoil)(FrameEvidence&) :
       {+[](FrameEvidence& e) { e.speed_m_s = 100; },
        +[](FrameEvidence& e) { e.accel_bias_m_s2 = 7; },
        +[](FrameEvidence& e) { e.speed_m_s = std::numeric_limits<double>::quiet_NaN(); },
        +[](FrameEvidence& e) { e.accepted = 20, e.rejected = 80; }}) {
    HealthCase c;
    c.health.started(0);
    run(c, spoil);
    EXPECT_EQ(c.health.state(), HealthState::kLost);
    EXPECT_EQ(c.confidence(), 0);
    EXPECT_TRUE(c.health.denied());
    c.health.started(from_seconds(5));
    c.health.update(sound(6));
    EXPECT_EQ(c.health.trust().reasons, bit(Reason::kDenied)) << "for a while";
    c.health.update(sound(16));
    EXPECT_EQ(c.health.trust().reasons, 0);
  }
}

TEST(health, jumps_of_its_own_again_and_again_are_doubted) {
  HealthCase c;
  c.health.started(0);
  for (int k = 0; k < 4; ++k) (void)c.health.note_jump(0.3, 0, true);
  c.health.update(sound(0.1));
  EXPECT_EQ(c.health.trust().reasons, 0) << "certain ones are none of its own";
  for (int k = 0; k < 3; ++k) (void)c.health.note_jump(0.3, 0, false);
  c.health.update(sound(0.2));
  EXPECT_EQ(c.health.trust().reasons, bit(Reason::kJumps));
}

TEST(health, every_reason_has_a_name) {
  for (int i = 0; i < static_cast<int>(Reason::kCount); ++i) {
    EXPECT_GT(std::string(name(Reason(i))).size(), 0u);
    EXPECT_EQ(std::string(name(Reason(i))).find_first_of(",+ "), std::string::npos);
  }
}

TEST(health, what_is_rejected_for_long_counts_sooner) {
  HealthCase c;
  c.health.started(0);
  double doubted_s = 0;
  for (double t_s = 0.05; t_s < 10 && doubted_s == 0; t_s += 0.05) {
    FrameEvidence e{from_seconds(t_s), 60, 12, 0.01};
    e.rejected = 25;  // 29 %, of which 35 are too many at once
    c.health.update(e);
    if ((c.health.trust().reasons & bit(Reason::kRejected)) != 0) doubted_s = t_s;
  }
  EXPECT_GT(doubted_s, 2);
  EXPECT_LT(doubted_s, 9);
}

TEST(health, what_is_degraded_is_never_trusted) {
  HealthCase c;
  c.health.started(0);
  c.update(1, 0);
  c.update(1.05, 200);
  ASSERT_EQ(c.health.state(), HealthState::kDegraded);
  EXPECT_LE(c.confidence(), 0.5f);
}

}  // namespace
}  // namespace pirvs
