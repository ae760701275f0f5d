#include "bsp/linux/cores.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <time.h>
#include <unistd.h>

#include <atomic>

#include "bsp/api/cores.h"
#include "bsp/linux/watchdog.h"
#include "core/base/assert.h"

namespace pirvs::bsp {
namespace {

struct Core {
  pthread_t thread;
  void (*entry)(void*) = nullptr;  // nullptr: not started
  void* argument = nullptr;
  CoreSetup setup;
  bool has_setup = false;
};

Core cores[kCoresMax];
std::atomic<const char*> refusal{nullptr};

void refuse(const char* what) {
  const char* none = nullptr;
  refusal.compare_exchange_strong(none, what);
}

cpu_set_t any_cpu;  // of the process, before core 0 was put somewhere
bool any_cpu_known = false;

// Of the calling thread, which has inherited both from the one that made it.
void apply(const CoreSetup& setup) {
  const sched_param param{setup.priority};
  const int policy = setup.priority > 0 ? SCHED_FIFO : SCHED_OTHER;
  if (pthread_setschedparam(pthread_self(), policy, &param) != 0) {
    refuse("no real-time priority: it needs CAP_SYS_NICE or RLIMIT_RTPRIO");
  }
  cpu_set_t cpus = any_cpu;
  if (setup.cpu >= 0) {
    CPU_ZERO(&cpus);
    CPU_SET(static_cast<size_t>(setup.cpu), &cpus);
  }
  if (pthread_setaffinity_np(pthread_self(), sizeof cpus, &cpus) != 0) {
    refuse("not on the CPUs that the board's plan names: this machine lacks one");
  }
}

void* run(void* core_pointer) {
  const Core& core = *static_cast<Core*>(core_pointer);
  if (core.has_setup) apply(core.setup);
  core.entry(core.argument);
  watchdog_forget();
  return nullptr;
}

}  // namespace

void set_core(int index, const CoreSetup& setup) {
  PIRVS_ASSERT(index >= 0 && index < kCoresMax);
  if (!any_cpu_known) {
    any_cpu_known = pthread_getaffinity_np(pthread_self(), sizeof any_cpu, &any_cpu) == 0;
  }
  cores[index].setup = setup;
  cores[index].has_setup = true;
  if (index == 0) apply(setup);
}

void leave_cores() {
  if (any_cpu_known) apply(CoreSetup{});
}

void ask_not_to_be_killed() {
  const int fd = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (fd < 0) return;
  (void)!write(fd, "-900", 4);
  close(fd);
}

const char* core_refusals() { return refusal; }

Status start_core(int index, void (*entry)(void*), void* argument) {
  if (index < 1 || index >= kCoresMax) return Status::kNotFound;
  Core& core = cores[index];
  if (core.entry != nullptr) return Status::kFull;
  core.entry = entry;
  core.argument = argument;
  if (pthread_create(&core.thread, nullptr, run, &core) == 0) return Status::kOk;
  core.entry = nullptr;
  return Status::kBusFault;
}

void join_cores() {
  for (Core& core : cores) {
    if (core.entry == nullptr) continue;
    pthread_join(core.thread, nullptr);
    core.entry = nullptr;
  }
}

void relax() {
  constexpr timespec kRest{0, 20'000};  // about 70 us with the kernel's usual timer slack
  nanosleep(&kRest, nullptr);
}

}  // namespace pirvs::bsp
