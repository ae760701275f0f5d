// The system calls that a driver of a device node makes, as a table: a test gives its own kernel.
// In, Out As POSIX has them; -1 and errno: failed. ioctl is repeated when a signal interrupts it.
// Errors  those of the calls.
// Cost    An indirect call more.
// Source  STYLE principle 13: the driver under test talks to a fake device.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::bsp {

struct SystemCalls {
  int (*open)(const char* path);  // to read and write, non-blocking
  int (*close)(int fd);
  int (*ioctl)(int fd, unsigned long request, void* argument);
  // Shared; fd -1: memory of our own. nullptr: failed.
  void* (*map)(size_t size, int fd, int64_t offset);
  int (*unmap)(void* address, size_t size);
};

extern const SystemCalls kSystemCalls;

}  // namespace pirvs::bsp
