// The door's inbox, a queue of many producers and one consumer: commands, GNSS fixes, wheel
// samples, edges, and that a sensor is lost or back. Cameras and IMU are polled instead.
// In      push(): from any core. Senders hold a lock for the time of one copy.
// Out     pop(): the oldest, on the door's core, which never waits. A command has the ticket that
//         its answer names.
// Errors  push: kFull, nothing was taken.
// Cost    a copy of ~600 bytes; 38 kB.
// Source  docs/architecture.md, "One way for the data".
#pragma once

#include <atomic>

#include "core/store/ring.h"
#include "modules/door/arrival.h"

namespace pirvs {

class Inbox {
 public:
  Result<uint32_t> push(const Command& command);  // the ticket
  Status push(const Arrival& arrival);
  bool pop(Arrival& out);

 private:
  static constexpr size_t kWaitingMax = 16     // commands
                                        + 48;  // edges of 2.4 ms at 20 kHz, and all that is rarer

  std::atomic_flag locked_ = ATOMIC_FLAG_INIT;
  Ring<Arrival, kWaitingMax> waiting_;
  uint32_t tickets_ = 0;
};

}  // namespace pirvs
