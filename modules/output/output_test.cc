#include "modules/output/output.h"

#include <gtest/gtest.h>

#include <memory>

#include "modules/testing.h"

namespace pirvs {
namespace {

TimeNs clock_ns = 0;
TimeNs read_clock() { return clock_ns; }

FusedState fused_at(TimeNs t) {
  FusedState fused;
  fused.state = testing::Sway().state(to_seconds(t));
  fused.cov.diagonal().setConstant(1e-4);
  fused.running = true;
  return fused;
}

ImuSample sample_at(TimeNs t) { return testing::Sway().imu(to_seconds(t)); }

TEST(Output, PublishesAndMeasuresAtEverySample) {
  const auto output = std::make_unique<Output>();
  output->configure(ImuNoise{}, 1.8, 1'000'000'000);
  output->set_clock(read_clock);
  const int consumer = output->feed().attach().value();
  for (TimeNs t = 0; t <= 50'000'000; t += 5'000'000) {
    output->add_imu(sample_at(t));
    EXPECT_EQ(output->feed().next(consumer), nullptr);
  }
  clock_ns = 50'000'000 + 12'000'000;
  output->fuse(fused_at(50'000'000));
  for (TimeNs t = 55'000'000; t <= 100'000'000; t += 5'000'000) {
    clock_ns = t + 300'000;
    output->add_imu(sample_at(t));
    const Pose* pose = output->feed().next(consumer);
    ASSERT_NE(pose, nullptr) << "at the sample, not with a frame";
    EXPECT_EQ(pose->state.t, t);
    EXPECT_EQ(pose->t_published, clock_ns);
    EXPECT_EQ(pose->t_frame, 50'000'000);
  }
  const LatencySummary pose = output->latency().imu_to_pose.summary();
  EXPECT_EQ(pose.count, 10u);
  EXPECT_DOUBLE_EQ(pose.median_ms, 0.3);
  const LatencySummary fused = output->latency().exposure_to_fused.summary();
  EXPECT_EQ(fused.count, 1u);
  EXPECT_DOUBLE_EQ(fused.max_ms, 12.0);
}

TEST(Output, MeasuresFramesAlone) {
  const auto output = std::make_unique<Output>();
  output->configure(ImuNoise{}, 1.8, 1'000'000'000);
  output->set_clock(read_clock);
  output->fuse(fused_at(0));
  output->replace(fused_at(0));
  EXPECT_EQ(output->latency().exposure_to_fused.summary().count, 1u);
}

TEST(Output, MeasuresNothingWithoutAClock) {
  const auto output = std::make_unique<Output>();
  output->configure(ImuNoise{}, 1.8, 1'000'000'000);
  const int consumer = output->feed().attach().value();
  output->fuse(fused_at(0));
  output->add_imu(sample_at(0));
  const Pose* pose = output->feed().next(consumer);
  ASSERT_NE(pose, nullptr);
  EXPECT_EQ(pose->t_published, 0);
  EXPECT_EQ(output->latency().imu_to_pose.summary().count, 0u);
  EXPECT_EQ(output->latency().exposure_to_fused.summary().count, 0u);
}

TEST(Output, GoesOnAfterAnInterruptionWithTheNextFusedState) {
  const auto output = std::make_unique<Output>();
  output->configure(ImuNoise{}, 1.8, 1'000'000'000);
  const int consumer = output->feed().attach().value();
  output->fuse(fused_at(0));
  output->add_imu(sample_at(0));
  EXPECT_NE(output->feed().next(consumer), nullptr);
  output->interrupt();
  output->add_imu(sample_at(5'000'000));
  EXPECT_EQ(output->feed().next(consumer), nullptr);
  output->fuse(fused_at(5'000'000));
  output->add_imu(sample_at(10'000'000));
  EXPECT_NE(output->feed().next(consumer), nullptr);
}

}  // namespace
}  // namespace pirvs
