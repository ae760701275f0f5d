// What else ends bsp::wait on Linux: file descriptors that have something to read.
// In      From the core that waits, for its own number.
// Out     bsp::wait(core, ...) returns while the descriptor is readable; who owns it reads it.
//         take_ready(): the last wait of this core found it readable, and nobody has taken that
//         yet. A wait that did not sleep knows nothing: who must not depend on it looks now and
//         then, too.
// Errors  kFull: kWaitFdsMax are watched on this core. forget_fd and take_ready of one not watched:
//         nothing, false.
// Source  bsp/api/events.h.
#pragma once

#include "core/base/status.h"

namespace pirvs::bsp {

inline constexpr int kWaitFdsMax = 4     // cameras, by one descriptor each at most
                                   + 2   // IMU: samples, its interrupt's pin
                                   + 2;  // pins, commands

Status watch_fd(int core, int fd);
void forget_fd(int core, int fd);
[[nodiscard]] bool take_ready(int core, int fd);

}  // namespace pirvs::bsp
