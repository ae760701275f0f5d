// A serial line of Linux as raw bytes: a UART, or /dev/ttyGS0 of the USB gadget.
// In      Its path; its speed, 0: as it is set.
// Out     A descriptor that never waits, -1: it cannot be opened now. A read gives EAGAIN for
//         nothing, and 0 for a tty that is gone.
// Errors  A speed that is_baud() refuses is a bug and asserts. What is no tty is opened as it is.
// Source  termios(3).
#pragma once

#include <cstdint>

namespace pirvs::bsp {

bool is_baud(int64_t baud);
int tty_open(const char* path, int baud);

}  // namespace pirvs::bsp
