#include "bsp/api/cores.h"

#include <pthread.h>
#include <time.h>

namespace pirvs::bsp {
namespace {

struct Core {
  pthread_t thread;
  void (*entry)(void*) = nullptr;  // nullptr: not started
  void* argument = nullptr;
};

Core cores[kCoresMax];

void* run(void* core_pointer) {
  const Core& core = *static_cast<Core*>(core_pointer);
  core.entry(core.argument);
  return nullptr;
}

}  // namespace

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
