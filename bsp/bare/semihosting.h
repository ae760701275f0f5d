// Services of the debugger or emulator that runs us: files and an exit code, for tests.
// In      The command line has the word "semihosting" if somebody listens.
// Out     As the functions say. Paths are the host's, from where the emulator was started.
// Errors  semihosting_open: -1. semihosting_write: false. Calling while nobody listens is a fault.
// Cost    A trap; the emulated clock does not see the host's work.
// Source  Arm, "Semihosting for AArch32 and AArch64".
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::bsp {

int64_t semihosting_open(const char* path);  // for writing, emptied
bool semihosting_write(int64_t handle, const void* data, size_t size);
bool semihosting_close(int64_t handle);
[[noreturn]] void semihosting_exit(int code);

}  // namespace pirvs::bsp
