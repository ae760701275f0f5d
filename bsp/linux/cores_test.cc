#include "bsp/linux/cores.h"

#include <gtest/gtest.h>
#include <sched.h>

#include "bsp/api/cores.h"

namespace pirvs::bsp {
namespace {

struct Seen {
  cpu_set_t cpus;
  int policy = -1;

  static void look(void* self) {
    Seen& seen = *static_cast<Seen*>(self);
    sched_getaffinity(0, sizeof seen.cpus, &seen.cpus);
    seen.policy = sched_getscheduler(0);
  }
};

// A core other tests do not use: a setup stays.
constexpr int kCore = 5;

TEST(LinuxCoreSetup, PutsACoreWhereItIsTold) {
  cpu_set_t all;
  sched_getaffinity(0, sizeof all, &all);
  int last = 0;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(size_t(cpu), &all)) last = cpu;
  }
  Seen seen;
  set_core(kCore, {last, 0});
  ASSERT_EQ(start_core(kCore, Seen::look, &seen), Status::kOk);
  join_cores();
  EXPECT_EQ(CPU_COUNT(&seen.cpus), 1);
  EXPECT_TRUE(CPU_ISSET(size_t(last), &seen.cpus));
  EXPECT_EQ(seen.policy, SCHED_OTHER);
  set_core(kCore, {-1, 0});
  ASSERT_EQ(start_core(kCore, Seen::look, &seen), Status::kOk);
  join_cores();
  EXPECT_TRUE(CPU_EQUAL(&seen.cpus, &all)) << "anywhere again";
}

TEST(LinuxCoreSetup, RunsAllTheSameWhereTheMachineLacksACpu) {
  Seen seen;
  set_core(kCore, {CPU_SETSIZE - 1, 0});
  ASSERT_EQ(start_core(kCore, Seen::look, &seen), Status::kOk);
  join_cores();
  set_core(kCore, {-1, 0});
  EXPECT_EQ(seen.policy, SCHED_OTHER) << "it ran";
  ASSERT_NE(core_refusals(), nullptr);
  EXPECT_STREQ(core_refusals(),
               "not on the CPUs that the board's plan names: this machine lacks one");
}

}  // namespace
}  // namespace pirvs::bsp
