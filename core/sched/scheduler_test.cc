#include "core/sched/scheduler.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "core/store/ring.h"

namespace pirvs {
namespace {

// A clock that moves by what steps spend and by 100 us at rest.
TimeNs fake_time;
const SchedulerHooks kFakeHooks = {[] { return fake_time; },
                                   [](int, TimeNs until) {
                                     EXPECT_GT(until, fake_time);
                                     fake_time += 100'000;
                                   },
                                   [](int) {}};

// A step that writes its letter, spends some time, and has a number of jobs.
struct Job {
  char letter;
  TimeNs cost = 0;
  int jobs = 0;  // left; each kAgain takes one
  TimeNs end = INT64_MAX;
  Scheduler* scheduler = nullptr;

  static std::string log;
  static Step step(void* context, TimeNs now) {
    Job& job = *static_cast<Job*>(context);
    if (now >= job.end) job.scheduler->stop();
    log += job.letter;
    fake_time += job.cost;
    if (job.jobs == 0) return Step::kIdle;
    --job.jobs;
    return Step::kAgain;
  }
};
std::string Job::log;

class SchedulerTest : public testing::Test {
 protected:
  void SetUp() override {
    fake_time = 0;
    Job::log.clear();
  }
};

constexpr Task kExample[] = {
    {"imu", 5'000, 50, 0},
    {"image", 50'000, 5'000, 1},
    {"mapping", 0, 2'000, 1},
};
static_assert(utilisation(kExample) > 0.1099 && utilisation(kExample) < 0.1101);
static_assert(utilisation(kExample, 0) > 0.0099 && utilisation(kExample, 0) < 0.0101);
static_assert(longest_budget_us(kExample) == 5'000);
static_assert(longest_budget_us(kExample, 0) == 50);

TEST_F(SchedulerTest, LockstepRestartsAtTheFirstRowAfterEveryJob) {
  Job a{'a'}, b{'b', 0, 2}, c{'c', 0, 1};
  const Task tasks[] = {{"a", 5'000, 10, 0, 0, Job::step, &a},
                        {"b", 0, 10, 1, 0, Job::step, &b},
                        {"c", 50'000, 10, 0, 0, Job::step, &c}};
  Scheduler scheduler(tasks, kFakeHooks);
  scheduler.run_until_idle();
  EXPECT_EQ(Job::log,
            "ab"
            "ab"
            "abc"
            "abc");
  Job::log.clear();
  scheduler.run_until_idle();
  EXPECT_EQ(Job::log, "abc") << "idle is asked again by the next call";
}

TEST_F(SchedulerTest, WorkRunsAtOnceHoweverSeldomItIsExpected) {
  Job a{'a'}, b{'b', 1'000'000, 5};
  const Task tasks[] = {{"a", 5'000, 10, 0, 0, Job::step, &a},
                        {"b", 50'000, 2'000, 0, 0, Job::step, &b}};
  Scheduler scheduler(tasks, kFakeHooks);
  a.scheduler = &scheduler;
  a.end = 6'000'000;
  scheduler.run(0);
  EXPECT_EQ(Job::log.substr(0, 12), "abababababab") << "five jobs, and asked a last time";
  EXPECT_EQ(scheduler.counters(1).overruns, 0u);
  EXPECT_EQ(scheduler.counters(1).busy_max, 1'000'000);
}

TEST_F(SchedulerTest, StepsThatTakeTooLongAreOverruns) {
  Job a{'a'}, b{'b', 2'000'001, 3};
  const Task tasks[] = {{"a", 5'000, 10, 0, 0, Job::step, &a},
                        {"b", 40'000, 2'000, 0, 0, Job::step, &b}};
  Scheduler scheduler(tasks, kFakeHooks);
  scheduler.run_until_idle();
  EXPECT_EQ(scheduler.counters(0).overruns, 0u);
  EXPECT_EQ(scheduler.counters(1).runs, 4u);
  EXPECT_EQ(scheduler.counters(1).overruns, 4u);
  EXPECT_EQ(scheduler.counters(1).busy_total, 4 * 2'000'001);
}

TEST_F(SchedulerTest, RowsThatAreAskedTooLateHaveSlipped) {
  Job a{'a'}, b{'b', 6'000'000, 3};
  const Task tasks[] = {{"a", 5'000, 10, 0, 0, Job::step, &a},
                        {"b", 40'000, 7'000, 0, 0, Job::step, &b}};
  Scheduler scheduler(tasks, kFakeHooks);
  a.scheduler = &scheduler;
  a.end = 60'000'000;
  scheduler.run(0);
  // Three jobs and the last time that b says idle; after that it is asked once in each rest.
  EXPECT_EQ(scheduler.counters(0).slips, scheduler.counters(1).runs);
  EXPECT_GE(scheduler.counters(0).slips, 4u);
  EXPECT_EQ(scheduler.counters(1).slips, 0u);
}

TEST_F(SchedulerTest, ACoreThatRestedIsNotLate) {
  const SchedulerHooks hooks = {[] { return fake_time; },
                                [](int, TimeNs until) { fake_time = until; }, [](int) {}};
  Job a{'a'};
  const Task tasks[] = {{"a", 5'000, 10, 0, 0, Job::step, &a}};
  Scheduler scheduler(tasks, hooks);
  a.scheduler = &scheduler;
  a.end = 10 * kRest_ns;
  scheduler.run(0);
  EXPECT_EQ(scheduler.counters(0).runs, 11u);
  EXPECT_EQ(scheduler.counters(0).slips, 0u);
}

// What the core was told to wait for.
TimeNs waited_until;
int woken_core;

TEST_F(SchedulerTest, ACoreWithoutWorkRestsUntilItIsWoken) {
  const SchedulerHooks hooks = {[] { return fake_time; },
                                [](int core, TimeNs until) {
                                  EXPECT_EQ(core, 0);
                                  waited_until = until;
                                  fake_time += 1'000;
                                },
                                [](int core) { woken_core = core; }};
  Job a{'a'};
  const Task tasks[] = {{"a", 0, 10, 0, 0, Job::step, &a}};
  Scheduler scheduler(tasks, hooks);
  a.scheduler = &scheduler;
  a.end = 1;
  woken_core = -1;
  scheduler.run(0);
  EXPECT_EQ(waited_until, kRest_ns);
  EXPECT_EQ(woken_core, 0) << "stop() wakes";
}

TEST_F(SchedulerTest, ARowThatDidSomethingWakesTheCoresOfThoseThatItNames) {
  const SchedulerHooks hooks = {[] { return fake_time; }, [](int, TimeNs) { fake_time += 100'000; },
                                [](int core) { Job::log += static_cast<char>('0' + core); }};
  Job a{'a', 0, 1}, b{'b'}, c{'c'};
  const Task tasks[] = {{"a", 1'000, 10, 0, 1u << 1 | 1u << 2, Job::step, &a},
                        {"b", 0, 10, 0, 0, Job::step, &b},
                        {"c", 0, 10, 3, 0, Job::step, &c}};
  Scheduler scheduler(tasks, hooks);
  a.scheduler = &scheduler;
  a.end = 1'000'000;
  scheduler.run(0);
  EXPECT_EQ(Job::log.substr(0, 3), "a3a") << "the row of its own core needs no waking";
}

TEST_F(SchedulerTest, EachCoreRunsItsOwnRows) {
  Job a{'a'}, b{'b'};
  const Task tasks[] = {{"a", 1'000, 10, 0, 0, Job::step, &a},
                        {"b", 1'000, 10, 1, 0, Job::step, &b}};
  Scheduler scheduler(tasks, kFakeHooks);
  b.scheduler = &scheduler;
  b.end = 300'000;
  scheduler.run(1);
  EXPECT_EQ(Job::log, "bbbb");
}

// One producer and one consumer, the same table, on one core and on two.
struct Pipe {
  static constexpr int kItems = 2'000;
  Ring<int, 8> ring;
  int pushed = 0, popped = 0;
  bool in_order = true;
  Scheduler* scheduler = nullptr;

  static Step produce(void* context, TimeNs) {
    Pipe& pipe = *static_cast<Pipe*>(context);
    if (pipe.pushed == kItems || !pipe.ring.push(pipe.pushed)) return Step::kIdle;
    ++pipe.pushed;
    return Step::kAgain;
  }
  static Step consume(void* context, TimeNs) {
    Pipe& pipe = *static_cast<Pipe*>(context);
    const int* item = pipe.ring.front();
    if (item == nullptr) return Step::kIdle;
    pipe.in_order &= *item == pipe.popped;
    pipe.ring.pop();
    if (++pipe.popped == kItems) pipe.scheduler->stop();
    return Step::kAgain;
  }
};

TEST_F(SchedulerTest, TheSameTableRunsInLockstepOnOneCoreOrOnTwo) {
  const SchedulerHooks hooks = {[] { return TimeNs{0}; },
                                [](int, TimeNs) { std::this_thread::yield(); }, [](int) {}};
  for (const bool two : {false, true}) {
    Pipe pipe;
    const Task tasks[] = {{"produce", 0, 10, 0, 0, Pipe::produce, &pipe},
                          {"consume", 0, 10, 1, 0, Pipe::consume, &pipe}};
    Scheduler scheduler(tasks, hooks);
    pipe.scheduler = &scheduler;
    if (!two) scheduler.run_until_idle();
    if (two) {
      std::thread second([&scheduler] { scheduler.run(1); });
      scheduler.run(0);
      second.join();
    }
    EXPECT_EQ(pipe.popped, Pipe::kItems);
    EXPECT_TRUE(pipe.in_order);
  }
}

}  // namespace
}  // namespace pirvs
