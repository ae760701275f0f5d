#include "bsp/api/cores.h"

#include <atomic>

#include "bsp/api/watchdog.h"
#include "bsp/bare/core_setup.h"
#include "bsp/bare/firmware.h"
#include "bsp/bare/interrupts.h"
#include "bsp/bare/machine.h"
#include "bsp/bare/registers.h"
#include "core/base/assert.h"

extern "C" void bare_core_start();  // start.S

namespace pirvs::bsp {
namespace {

struct Job {
  void (*entry)(void*) = nullptr;  // nullptr: not started
  void* argument = nullptr;
  std::atomic<bool> done{false};
};
Job jobs[kCoresMax];

// wfe wakes on an event of another core, and by CNTKCTL's event stream at the latest every 2^8
// ticks: 11 us at the RK3399's 24 MHz.
constexpr uint64_t kEventStream = 1u << 2 | 7u << 4;  // EVNTEN, EVNTI

}  // namespace

void start_this_core() {
  PIRVS_WRITE(cntkctl_el1, kEventStream);
  cycles_start_core();
  interrupts_start_core();
  watchdog_start_core();
}

Status start_core(int index, void (*entry)(void*), void* argument) {
  if (index < 1 || index >= kMachine.cores) return Status::kNotFound;
  Job& job = jobs[index];
  if (job.entry != nullptr) return Status::kFull;
  job.entry = entry;
  job.argument = argument;
  job.done.store(false, std::memory_order_release);
  asm volatile("dsb sy" ::: "memory");
  const Status status =
      firmware_core_on(kMachine.mpidr[index], reinterpret_cast<uintptr_t>(&bare_core_start),
                       static_cast<uint64_t>(index));
  if (status != Status::kOk) job.entry = nullptr;
  return status;
}

void join_cores() {
  for (int i = 1; i < kMachine.cores; ++i) {
    Job& job = jobs[i];
    if (job.entry == nullptr) continue;
    while (!job.done.load(std::memory_order_acquire)) relax();
    while (!firmware_core_is_off(kMachine.mpidr[i])) relax();
    job.entry = nullptr;
  }
}

void relax() {
  watchdog_kick(nullptr);
  asm volatile("wfe" ::: "memory");
}

}  // namespace pirvs::bsp

extern "C" void bare_core_main(int core);
extern "C" void bare_core_main(int core) {
  using namespace pirvs::bsp;
  start_this_core();
  Job& job = jobs[core];
  job.entry(job.argument);
  job.done.store(true, std::memory_order_release);
  asm volatile("sev" ::: "memory");
  firmware_core_off();
}
