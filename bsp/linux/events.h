// What else ends bsp::wait on Linux: file descriptors that have something to read.
// In      From the core that waits, for its own number.
// Out     bsp::wait(core, ...) returns while the descriptor is readable; who owns it reads it.
// Errors  kFull: kWaitFdsMax are watched on this core. forget_fd of one not watched does nothing.
// Source  bsp/api/events.h.
#pragma once

#include "core/base/status.h"

namespace pirvs::bsp {

inline constexpr int kWaitFdsMax = 4     // cameras, by one descriptor each at most
                                   + 2   // IMU: samples, its interrupt's pin
                                   + 2;  // pins, commands

Status watch_fd(int core, int fd);
void forget_fd(int core, int fd);

}  // namespace pirvs::bsp
