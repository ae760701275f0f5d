// The timing of the whole stack on one screen: its tasks in order of priority, how often their work
// comes, how long a step of theirs may take, and which core runs them.
// In      A plan of cores, one of its board's.
// Out     schedule(): the plan's rows, without their steps. keeps_up(): whether every core has time
//         for what comes, with a fifth to spare for mapping and bursts, and no sample is lost. Each
//         board asserts it for each of its plans.
// Units   us on the cores of an RK3399: Cortex-A72 at 1.8 GHz, the slow ones A53 at 1.4 GHz.
// Errors  none.
// Source  docs/profiling.md, "Budgets"; STYLE principle 1.
#pragma once

#include <array>

#include "core/sched/scheduler.h"

namespace pirvs {

enum TaskIndex : int { kDoor, kPrepare, kLeft, kRight, kTracking, kMapping, kTasks };

// Which core runs what. On one core all tasks interleave.
struct CorePlan {
  uint8_t cores = 1;
  uint8_t door = 0, left = 0, right = 0, tracking = 0, mapping = 0;
  uint8_t frames_hz = 20;  // stereo frames a second that it is laid out for
  uint8_t slow_cores = 0;  // by bit: Cortex-A53 or alike
};

using Schedule = std::array<Task, kTasks>;

inline constexpr uint32_t kImu_us = 5'000;  // 200 samples a second

constexpr Schedule schedule(const CorePlan& plan) {
  struct Budget {
    uint32_t a72_us, a53_us;
  };
  const auto task = [&plan](const char* name, uint32_t every_us, Budget budget, uint8_t core,
                            uint32_t wakes) {
    const bool slow = (plan.slow_cores >> core & 1) != 0;
    return Task{name, every_us, slow ? budget.a53_us : budget.a72_us, core, wakes};
  };
  const uint32_t door = 1u << kDoor, prepare = 1u << kPrepare, left = 1u << kLeft,
                 right = 1u << kRight, tracking = 1u << kTracking, mapping = 1u << kMapping;
  const uint32_t frame_us = 1'000'000u / plan.frames_hz;
  return {{
      // name, how often, budget, core, who may have work after its steps
      task("door", kImu_us, {200, 600}, plan.door, prepare | mapping),
      task("prepare", frame_us, {1'000, 3'000}, plan.door, left | right),  // a frame, for flow
      task("left", frame_us, {5'000, 16'000}, plan.left, tracking),
      task("right", frame_us, {5'000, 16'000}, plan.right, tracking),
      task("tracking", frame_us, {5'000, 16'000}, plan.tracking, door | mapping),
      task("mapping", 0, {3'000, 9'000}, plan.mapping, door | prepare),  // in slices
  }};
}

inline constexpr double kUtilisationMax = 0.8;

// The first row waits for one step at most, while the IMU's FIFO fills.
constexpr bool keeps_up(const Schedule& tasks, int core, TimeNs imu_fifo) {
  return utilisation(tasks, core) < kUtilisationMax &&
         static_cast<TimeNs>(longest_budget_us(tasks, core)) * 1000 < imu_fifo;
}

constexpr bool keeps_up(const CorePlan& plan, TimeNs imu_fifo) {
  for (int core = 0; core < plan.cores; ++core) {
    if (!keeps_up(schedule(plan), core, imu_fifo)) return false;
  }
  return true;
}

template <size_t N>
constexpr bool keep_up(const CorePlan (&plans)[N], TimeNs imu_fifo) {
  for (const CorePlan& plan : plans) {
    if (!keeps_up(plan, imu_fifo)) return false;
  }
  return true;
}

}  // namespace pirvs
