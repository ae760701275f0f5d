// Services of the debugger or emulator that runs us: files and an exit code, for tests.
// In      The command line has the word "semihosting" if somebody listens.
// Out     As the functions say. Paths are the host's, from where the emulator was started.
// Errors  semihosting_open, _open_to_read, _size: -1. The others: false. Calling while nobody
//         listens is a fault.
// Cost    A trap; the emulated clock does not see the host's work.
// Source  Arm, "Semihosting for AArch32 and AArch64".
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::bsp {

int64_t semihosting_open(const char* path);  // for writing, emptied
int64_t semihosting_open_to_read(const char* path);
bool semihosting_write(int64_t handle, const void* data, size_t size);
size_t semihosting_read(int64_t handle, void* data, size_t max);  // fewer than max: the end
int64_t semihosting_size(int64_t handle);
bool semihosting_close(int64_t handle);
bool semihosting_rename(const char* from, const char* to);
bool semihosting_remove(const char* path);
[[noreturn]] void semihosting_exit(int code);

}  // namespace pirvs::bsp
