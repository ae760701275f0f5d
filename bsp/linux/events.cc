#include "bsp/linux/events.h"

#include <poll.h>
#include <stdint.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>

#include "bsp/api/clock.h"
#include "bsp/api/cores.h"
#include "bsp/api/events.h"
#include "core/base/assert.h"

namespace pirvs::bsp {
namespace {

enum class State : uint8_t { kAwake, kWoken, kAsleep };

struct Core {
  std::atomic<State> state{State::kAwake};
  int event_fd = -1;  // made by the first wait, before anybody can see kAsleep
  int fds[kWaitFdsMax];
  bool ready[kWaitFdsMax] = {};  // by the last wait
  int fd_count = 0;
};
Core cores[kCoresMax];

thread_local TimeNs next_alarm = INT64_MAX;

Core& core_of(int core) {
  PIRVS_ASSERT(core >= 0 && core < kCoresMax);
  return cores[core];
}

void make_event_fd(Core& core) {
  if (core.event_fd >= 0) return;
  core.event_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  PIRVS_ASSERT(core.event_fd >= 0);
}

void sleep_until(Core& core, TimeNs until) {
  constexpr TimeNs kSecond = 1'000'000'000;
  pollfd polled[1 + kWaitFdsMax];
  polled[0] = {core.event_fd, POLLIN, 0};
  for (int i = 0; i < core.fd_count; ++i) polled[1 + i] = {core.fds[i], POLLIN, 0};
  const auto count = static_cast<nfds_t>(1 + core.fd_count);
  const TimeNs left = std::max<TimeNs>(0, until - now());
  const timespec timeout{static_cast<time_t>(left / kSecond), static_cast<long>(left % kSecond)};
  const int ready = ppoll(polled, count, &timeout, nullptr);
  for (int i = 0; i < core.fd_count; ++i) core.ready[i] = ready > 0 && polled[1 + i].revents != 0;
  if (ready <= 0 || polled[0].revents == 0) return;
  uint64_t wakes = 0;  // the next poll must not see these again
  (void)!read(core.event_fd, &wakes, sizeof wakes);
}

}  // namespace

void wait(int index, TimeNs until) {
  Core& core = core_of(index);
  make_event_fd(core);
  until = std::min(until, next_alarm);
  next_alarm = INT64_MAX;
  State expected = State::kAwake;
  if (core.state.compare_exchange_strong(expected, State::kAsleep, std::memory_order_acq_rel)) {
    sleep_until(core, until);
  }
  // Acquire: what the waking core wrote before is visible to this one.
  core.state.exchange(State::kAwake, std::memory_order_acq_rel);
}

void wake(int index) {
  Core& core = core_of(index);
  if (core.state.exchange(State::kWoken, std::memory_order_acq_rel) != State::kAsleep) return;
  const uint64_t one = 1;
  (void)!write(core.event_fd, &one, sizeof one);
}

void alarm(TimeNs t) { next_alarm = std::min(next_alarm, t); }

Status watch_fd(int index, int fd) {
  Core& core = core_of(index);
  if (core.fd_count == kWaitFdsMax) return Status::kFull;
  core.ready[core.fd_count] = false;
  core.fds[core.fd_count++] = fd;
  return Status::kOk;
}

void forget_fd(int index, int fd) {
  Core& core = core_of(index);
  int kept = 0;
  for (int i = 0; i < core.fd_count; ++i) {
    if (core.fds[i] == fd) continue;
    core.ready[kept] = core.ready[i];
    core.fds[kept++] = core.fds[i];
  }
  core.fd_count = kept;
}

bool take_ready(int index, int fd) {
  Core& core = core_of(index);
  const auto at = static_cast<int>(std::find(core.fds, core.fds + core.fd_count, fd) - core.fds);
  if (at == core.fd_count || !core.ready[at]) return false;
  core.ready[at] = false;
  return true;
}

}  // namespace pirvs::bsp
