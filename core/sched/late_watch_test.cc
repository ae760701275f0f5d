#include "core/sched/late_watch.h"

#include <gtest/gtest.h>

namespace pirvs {
namespace {

TimeNs fake_time;
const SchedulerHooks kFakeHooks = {[] { return fake_time; }, [](int, TimeNs) {}, [](int) {}};

// A step that takes as long as it is told.
Step take(void* cost, TimeNs) {
  fake_time += *static_cast<TimeNs*>(cost);
  return Step::kIdle;
}

class LateWatchTest : public testing::Test {
 protected:
  void run(int times) {
    for (int i = 0; i < times; ++i) scheduler_.run_until_idle();
  }

  TimeNs cost_[2] = {0, 0};
  const Task tasks_[2] = {{"quick", 0, 1'000, 0, 0, take, &cost_[0]},
                          {"slow", 0, 2'000, 0, 0, take, &cost_[1]}};
  Scheduler scheduler_{tasks_, kFakeHooks};
  LateWatch watch_;
  LateTask late_;
};

TEST_F(LateWatchTest, TellsATaskThatIsLateAgainAndAgainOnceAWindow) {
  cost_[1] = 3'000'000;
  run(5);
  ASSERT_TRUE(watch_.next(scheduler_, fake_time, late_));
  EXPECT_STREQ(late_.name, "slow");
  EXPECT_EQ(late_.overruns, 5u);
  EXPECT_EQ(late_.longest, 3'000'000);
  EXPECT_FALSE(watch_.next(scheduler_, fake_time, late_)) << "the other keeps its budget";
  const TimeNs told = fake_time;
  int again = 0;
  while (fake_time < told + kLateWindow_ns) {
    EXPECT_FALSE(watch_.next(scheduler_, fake_time, late_)) << "told already";
    run(1);
    ++again;
  }
  ASSERT_TRUE(watch_.next(scheduler_, fake_time, late_));
  EXPECT_EQ(late_.overruns, static_cast<uint32_t>(again)) << "since the last time";
}

TEST_F(LateWatchTest, SaysNothingOfAFewInAWindow) {
  for (int window = 0; window < 10; ++window) {
    cost_[1] = 3'000'000;
    run(static_cast<int>(kLateTimes) - 1);
    EXPECT_FALSE(watch_.next(scheduler_, fake_time, late_));
    fake_time += kLateWindow_ns;
  }
  EXPECT_EQ(scheduler_.counters(1).overruns, 10 * (kLateTimes - 1)) << "counted all the same";
}

TEST_F(LateWatchTest, TellsEachLateTask) {
  cost_[0] = cost_[1] = 5'000'000;
  run(3);
  ASSERT_TRUE(watch_.next(scheduler_, fake_time, late_));
  EXPECT_STREQ(late_.name, "quick");
  ASSERT_TRUE(watch_.next(scheduler_, fake_time, late_));
  EXPECT_STREQ(late_.name, "slow");
}

}  // namespace
}  // namespace pirvs
