#include "modules/app/schedule.h"

#include <gtest/gtest.h>

namespace pirvs {
namespace {

constexpr TimeNs kFifo = 100'000'000;
constexpr CorePlan kOne = {1, 0, 0, 0, 0, 0, 10};
constexpr CorePlan kTwo = {2, 0, 0, 1, 0, 1, 10};

constexpr CorePlan at(CorePlan plan, uint8_t frames_hz) {
  plan.frames_hz = frames_hz;
  return plan;
}

// The highest frame rate with which a plan keeps up.
constexpr uint8_t limit_hz(const CorePlan& plan) {
  uint8_t hz = 1;
  while (hz < UINT8_MAX && keeps_up(at(plan, static_cast<uint8_t>(hz + 1)), kFifo)) ++hz;
  return hz;
}

TEST(Schedule, KeepsUpOnlyWithWhatItsCoresHaveTimeFor) {
  EXPECT_GE(limit_hz(kOne), 20);
  EXPECT_LT(limit_hz(kOne), 200);
  EXPECT_GT(limit_hz(kTwo), limit_hz(kOne));
  CorePlan slow = kTwo;
  slow.slow_cores = 0b01;
  EXPECT_LT(limit_hz(slow), limit_hz(kTwo)) << "its first core is an A53";
}

TEST(Schedule, DoesNotKeepUpWhenAStepOutlastsTheFifo) {
  const TimeNs longest = TimeNs{1000} * longest_budget_us(schedule(kOne));
  EXPECT_FALSE(keeps_up(kOne, longest));
  EXPECT_TRUE(keeps_up(kOne, longest + 1));
  for (int task = 0; task < kTasks; ++task) {
    Schedule tasks = schedule(kOne);
    tasks[size_t(task)].budget_us = kFifo / 1000 + 1;
    tasks[size_t(task)].every_us = 0;  // background: of its length alone
    EXPECT_FALSE(keeps_up(tasks, 0, kFifo)) << tasks[size_t(task)].name;
  }
}

// The boards' asserts are of this kind: a bad plan does not compile.
static_assert(!keep_up({kOne, at(kOne, 200)}, kFifo));
static_assert(keep_up({kOne, kTwo}, kFifo));

TEST(Schedule, LeavesNoTaskWithoutAnybodyToWakeIt) {
  const Schedule tasks = schedule(kTwo);
  uint32_t woken = 0;
  for (const Task& task : tasks) woken |= task.wakes;
  EXPECT_EQ(woken, (1u << kTasks) - 1);
}

}  // namespace
}  // namespace pirvs
