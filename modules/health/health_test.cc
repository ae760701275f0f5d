#include "modules/health/health.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace pirvs
