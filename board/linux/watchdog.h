// Kicks the hardware watchdog and systemd's while all tasks run. When the kicks stop, the hardware
// restarts the board, and systemd restarts the program.
// In      open(): a node like /dev/watchdog0, or "" for none; systemd is found by NOTIFY_SOCKET.
//         ready(): once images and samples come. poll(): as often as core 0 comes round.
// Out     While a task hangs for longer than kHang_ns neither is kicked, and `news` names the task.
// Errors  open: nullptr, or why the node cannot be opened; systemd is notified all the same.
// Cost    A few clock readings; twice a second, two system calls.
// Source  kernel, Documentation/watchdog/watchdog-api.rst; sd_notify(3).
#pragma once

#include "bsp/linux/device_news.h"
#include "core/base/time.h"

namespace pirvs::board {

class Watchdog {
 public:
  static constexpr TimeNs kEvery_ns = 500'000'000;
  static constexpr TimeNs kHang_ns = 3'000'000'000;
  static constexpr int kTimeout_s = 10;  // of the hardware, where it can be set

  const char* open(const char* node, const bsp::DeviceNews& news);
  void ready();
  void poll();
  // In order: the hardware is told that nobody will come any more, where it allows that.
  void close();

 private:
  void notify(const char* text) const;

  bsp::DeviceTeller teller_;
  int node_ = -1;
  int socket_ = -1;
  bool ready_ = false;
  TimeNs next_t_ = 0;
};

}  // namespace pirvs::board
