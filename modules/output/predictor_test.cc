#include "modules/output/predictor.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "modules/testing.h"
#include "modules/tracking/filter.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;

constexpr TimeNs kBridge = 1'000'000'000;
constexpr double kPeriod_s = 0.005, kScale = 1.8;

Sway biased() {
  Sway sway;
  sway.b_g = Vec3(0.01, -0.02, 0.015);
  sway.b_a = Vec3(0.1, 0.05, -0.1);
  return sway;
}

// A predictor beside the filter that it has to agree with, on the samples of a swaying body.
struct Both {
  Both() : rig(CameraModel::kPinholeRadtan), predictor(std::make_unique<Predictor>()) {
    predictor->configure(noise, kScale, kBridge);
    filter.configure(rig.camera, noise, FilterParams{});
    Random random(1);
    fused.state = sway.state(0);
    fused.cov = random.spd<15>(1e-4);
    filter.reset(fused.state, fused.cov);
    fused.cov *= kScale;
    fused.running = true;
    fused.health = HealthState::kTracking;
    fused.trust.confidence = 0.8f;
    fused.trust.resets = 3;
    fused.epoch = 2;
  }

  bool add(double t_s) { return predictor->add_imu(sway.imu(t_s), pose); }

  // As a frame: the filter's state at its time, no matter when it is told.
  void fuse() {
    fused.state = filter.state();
    fused.cov = kScale * filter.cov();
    predictor->fuse(fused);
  }

  void expect_agreement() const {
    EXPECT_EQ(pose.state.t, filter.state().t);
    EXPECT_EQ(pose.state.T_WB.R, filter.state().T_WB.R);
    EXPECT_EQ(pose.state.T_WB.p, filter.state().T_WB.p);
    EXPECT_EQ(pose.state.v_WB, filter.state().v_WB);
    const Mat9 cov = kScale * filter.cov().topLeftCorner<9, 9>();
    EXPECT_LT((pose.cov - cov).norm(), 1e-12 * cov.norm());
  }

  Sway sway = biased();
  ImuNoise noise;
  Rig rig;
  Filter filter;
  std::unique_ptr<Predictor> predictor;
  FusedState fused;
  Pose pose;
};

TEST(Predictor, SaysNothingBeforeAFusedState) {
  Both both;
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(both.add(i * kPeriod_s));
  EXPECT_EQ(both.predictor->anchors_missed(), 0u);
}

// Frames at a sample's time, told 7 samples late: the same operations on the same numbers.
TEST(Predictor, AgreesWithTheFilterToTheLastBit) {
  Both both;
  constexpr int kEvery = 10, kLate = 7;
  Filter at_frame;
  int compared = 0;
  for (int i = 0; i <= 400; ++i) {
    both.filter.propagate(both.sway.imu(i * kPeriod_s));
    if (i % kEvery == 0) at_frame = both.filter;
    if (i % kEvery == kLate) {
      both.fused.state = at_frame.state();
      both.fused.cov = kScale * at_frame.cov();
      both.predictor->fuse(both.fused);
    }
    const bool given = both.add(i * kPeriod_s);
    EXPECT_EQ(given, i >= kLate);
    if (!given) continue;
    both.expect_agreement();
    EXPECT_EQ(both.pose.t_frame, at_frame.state().t - (i % kEvery < kLate ? 50'000'000 : 0));
    ++compared;
  }
  EXPECT_EQ(compared, 394);
  EXPECT_EQ(both.pose.health, HealthState::kTracking);
  EXPECT_EQ(both.pose.trust.resets, 3u);
  EXPECT_EQ(both.pose.epoch, 2);
  EXPECT_EQ(both.pose.w_B, both.sway.imu(2.0).w_B - both.sway.b_g);
}

// The filter gets a sample at the frame's time that the door has interpolated, the predictor has
// only its neighbours: the same line.
TEST(Predictor, AgreesAfterAFrameBetweenTwoSamples) {
  Both both;
  const auto sample = [&](int i) { return both.sway.imu(i * kPeriod_s); };
  for (int i = 0; i <= 10; ++i) {
    both.filter.propagate(sample(i));
    EXPECT_FALSE(both.add(i * kPeriod_s));
  }
  both.filter.propagate(interpolated(sample(10), sample(11), sample(10).t + 1'700'000));
  EXPECT_FALSE(both.add(11 * kPeriod_s));
  both.fuse();
  for (int i = 11; i <= 30; ++i) {
    both.filter.propagate(sample(i));
    if (i == 11) continue;  // the predictor has had it
    ASSERT_TRUE(both.add(i * kPeriod_s));
    both.expect_agreement();
  }
}

TEST(Predictor, FollowsTheTruth) {
  Both both;
  both.predictor->fuse(both.fused);
  double t_s = 0;
  for (int i = 0; i <= 60; ++i) {
    t_s = i * kPeriod_s;
    ASSERT_TRUE(both.add(t_s));
    EXPECT_EQ(both.pose.dead_reckoning, t_s > kDeadReckoning_s) << t_s;
  }
  const BodyState truth = both.sway.state(t_s);
  EXPECT_LT(boxminus(both.pose.state, truth).norm(), 1e-4);
}

TEST(Predictor, SaysNothingWhileTrackingDoesNotRun) {
  Both both;
  both.predictor->fuse(both.fused);
  EXPECT_TRUE(both.add(0));
  EXPECT_TRUE(both.add(kPeriod_s));
  both.fused.running = false;
  both.predictor->fuse(both.fused);
  EXPECT_FALSE(both.add(2 * kPeriod_s));
  EXPECT_FALSE(both.add(3 * kPeriod_s));
  both.fused = FusedState{};
  both.fused.state = both.sway.state(3 * kPeriod_s);
  both.fused.running = true;
  both.predictor->fuse(both.fused);
  EXPECT_TRUE(both.add(4 * kPeriod_s));
}

// Neither across a gap longer than the bridge nor across a clock that was set back, and no state
// from before is taken up after it.
TEST(Predictor, StopsAtABreakInTime) {
  for (const double step_s : {1.2, -0.5}) {
    Both both;
    both.predictor->fuse(both.fused);
    EXPECT_TRUE(both.add(0));
    EXPECT_TRUE(both.add(1.0)) << "the bridge holds";
    EXPECT_FALSE(both.add(1.0 + step_s));
    EXPECT_FALSE(both.add(1.005 + step_s));
    both.fused.state = both.sway.state(1.0);
    both.predictor->fuse(both.fused);
    EXPECT_FALSE(both.add(1.01 + step_s));
    EXPECT_EQ(both.predictor->anchors_missed(), 1u);
    both.fused.state = both.sway.state(1.005 + step_s);
    both.predictor->fuse(both.fused);
    EXPECT_TRUE(both.add(1.015 + step_s));
  }
}

TEST(Predictor, MissesAStateOlderThanItsHistory) {
  Both both;
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(both.add(i * kPeriod_s));
  both.predictor->fuse(both.fused);  // of t = 0
  EXPECT_FALSE(both.add(5.0));
  EXPECT_EQ(both.predictor->anchors_missed(), 1u);
  both.fused.state = both.sway.state(5.0 - 500 * kPeriod_s);
  both.predictor->fuse(both.fused);
  EXPECT_TRUE(both.add(5.005));
}

// One sensor's clock may have been set: from then on samples count as in the filter, which is told
// the same.
TEST(Predictor, SaysOfStampsInDoubtThatTheyAre) {
  Both doubted_too, both;
  for (Both* b : {&doubted_too, &both}) {
    for (int i = 0; i <= 20; ++i) {
      b->filter.propagate(b->sway.imu(i * kPeriod_s));
      (void)b->add(i * kPeriod_s);
    }
    b->fuse();
    b->predictor->doubt_stamps(b == &doubted_too);
    for (int i = 21; i <= 30; ++i) {
      const ImuSample sample = b->sway.imu(i * kPeriod_s);
      b->filter.propagate(b == &doubted_too ? doubted(sample) : sample);
      ASSERT_TRUE(b->add(i * kPeriod_s));
      b->expect_agreement();
    }
  }
  EXPECT_EQ(both.pose.trust.confidence, 0.8f);
  EXPECT_EQ(doubted_too.pose.trust.confidence, kDoubtConfidence);
  for (int i = 0; i < 9; ++i) EXPECT_GT(doubted_too.pose.cov(i, i), both.pose.cov(i, i)) << i;
  EXPECT_GT(doubted_too.pose.cov(0, 0), 10 * both.pose.cov(0, 0)) << "the gyro's time may be wrong";
  doubted_too.predictor->doubt_stamps(false);
  ASSERT_TRUE(doubted_too.add(31 * kPeriod_s));
  EXPECT_EQ(doubted_too.pose.trust.confidence, 0.8f) << "the fused state's own";
}

TEST(Predictor, DoubtsNothingAtRest) {
  Both both;
  both.fused.at_rest = true;
  both.predictor->doubt_stamps(true);
  both.predictor->fuse(both.fused);
  EXPECT_TRUE(both.add(0));
  EXPECT_TRUE(both.add(kPeriod_s));
  EXPECT_EQ(both.pose.trust.confidence, 0.8f);
}

TEST(Predictor, NeverGivesWhatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Both both;
  both.fused.state.v_WB.x() = nan;
  both.predictor->fuse(both.fused);
  EXPECT_FALSE(both.add(0));
  EXPECT_EQ(both.predictor->not_finite(), 1u);
  both.fused.state = both.sway.state(0);
  both.fused.cov(4, 4) = nan;
  both.predictor->fuse(both.fused);
  EXPECT_FALSE(both.add(kPeriod_s));
  EXPECT_EQ(both.predictor->not_finite(), 2u);
}

}  // namespace
}  // namespace pirvs
