#include "modules/output/pose_feed.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

namespace pirvs {
namespace {

Pose pose_at(TimeNs t) {
  Pose pose;
  pose.state.t = pose.t_frame = t;
  pose.cov(8, 8) = static_cast<double>(t);
  return pose;
}

void publish(PoseFeed& feed, TimeNs first, TimeNs last) {
  for (TimeNs t = first; t <= last; ++t) feed.publish(pose_at(t));
}

TEST(PoseFeed, GivesEveryConsumerEveryPose) {
  const auto feed = std::make_unique<PoseFeed>();
  publish(*feed, 1, 3);  // nobody listens
  const int a = feed->attach().value(), b = feed->attach().value();
  EXPECT_NE(a, b);
  publish(*feed, 4, 9);
  for (const int consumer : {a, b}) {
    for (TimeNs t = 4; t <= 9; ++t) {
      const Pose* pose = feed->next(consumer);
      ASSERT_NE(pose, nullptr);
      EXPECT_EQ(pose->state.t, t);
    }
    EXPECT_EQ(feed->next(consumer), nullptr);
    EXPECT_EQ(feed->lost(consumer), 0u);
  }
}

TEST(PoseFeed, ASlowConsumerLosesItsOwnOldest) {
  const auto feed = std::make_unique<PoseFeed>();
  const int slow = feed->attach().value(), fast = feed->attach().value();
  constexpr TimeNs kPoses = 1000;
  for (TimeNs t = 1; t <= kPoses; ++t) {
    publish(*feed, t, t);
    const Pose* pose = feed->next(fast);
    ASSERT_NE(pose, nullptr);
    EXPECT_EQ(pose->state.t, t);
  }
  EXPECT_EQ(feed->lost(fast), 0u);
  EXPECT_EQ(feed->lost(slow), kPoses - kPosesKept);
  EXPECT_EQ(feed->next(slow)->state.t, kPoses - TimeNs{kPosesKept} + 1);
  EXPECT_EQ(feed->newest(slow)->state.t, kPoses);
  EXPECT_EQ(feed->newest(slow), nullptr);
}

TEST(PoseFeed, HasAPlaceForEachOfItsConsumers) {
  const auto feed = std::make_unique<PoseFeed>();
  for (int i = 0; i < kPoseConsumersMax; ++i) EXPECT_TRUE(feed->attach().ok());
  EXPECT_EQ(feed->attach().status(), Status::kFull);
  publish(*feed, 1, 200);
  feed->detach(2);
  publish(*feed, 201, 202);
  const Result<int> again = feed->attach();
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again.value(), 2);
  EXPECT_EQ(feed->next(2), nullptr) << "nothing of the consumer before";
  EXPECT_EQ(feed->lost(2), 0u);
  publish(*feed, 203, 203);
  EXPECT_EQ(feed->next(2)->state.t, 203);
}

TEST(PoseFeed, StopsOnAConsumerThatIsNotAttached) {
  const auto feed = std::make_unique<PoseFeed>();
  EXPECT_DEATH((void)feed->next(0), "bug");
  EXPECT_DEATH((void)feed->next(kPoseConsumersMax), "bug");
}

// One consumer comes and goes while another reads on: neither sees a torn pose or an old one.
TEST(PoseFeed, ServesConsumersOnCoresOfTheirOwn) {
  static PoseFeed feed;
  constexpr TimeNs kPoses = 20'000;
  const int steady = feed.attach().value();
  std::atomic<bool> done{false};
  std::thread writer([&done] {
    for (TimeNs t = 1; t <= kPoses; ++t) {
      feed.publish(pose_at(t));
      if (t % 16 == 0) std::this_thread::yield();
    }
    done.store(true);
  });
  std::atomic<uint64_t> wrong{0};
  const auto check = [&wrong](const Pose& pose, TimeNs after) {
    const bool torn =
        pose.t_frame != pose.state.t || pose.cov(8, 8) != static_cast<double>(pose.state.t);
    if (torn || pose.state.t <= after) wrong.fetch_add(1);
  };
  std::thread visitor([&done, &check] {
    while (!done.load()) {
      const int consumer = feed.attach().value();
      TimeNs last = 0;
      for (int i = 0; i < 20; ++i) {
        if (const Pose* pose = feed.newest(consumer)) {
          check(*pose, last);
          last = pose->state.t;
        }
        std::this_thread::yield();
      }
      feed.detach(consumer);
    }
  });
  TimeNs last = 0;
  uint64_t taken = 0;
  while (last < kPoses) {
    const Pose* pose = feed.next(steady);
    if (pose == nullptr) {
      std::this_thread::yield();
      continue;
    }
    check(*pose, last);
    last = pose->state.t;
    ++taken;
  }
  writer.join();
  visitor.join();
  EXPECT_EQ(wrong.load(), 0u);
  EXPECT_EQ(taken + feed.lost(steady), static_cast<uint64_t>(kPoses));
}

}  // namespace
}  // namespace pirvs
