// What the loader has handed over, and the end of the program.
// In      The words of the command line (device tree, bootargs).
// Out     boot_argument: is the word there, and the text behind "name=". boot_recording: the memory
//         that the loader filled with a recording (its "initrd"), read-only; empty if there is
//         none.
// Errors  A device tree or recording that overlaps our own memory ends in a fault report.
// Cost    boot_argument: one pass over the line.
// Source  Linux Documentation/arm64/booting.rst; Devicetree Specification 0.4, 3.6.
#pragma once

#include <cstddef>

namespace pirvs {

// The board's program (board/bare/main.cc); its result is the exit code.
int application();

namespace bsp {

struct Memory {
  const void* data = nullptr;
  size_t size = 0;
};

bool boot_argument(const char* name);
bool boot_argument(const char* name, char* value, size_t size);
Memory boot_recording();

// Tells an emulator or debugger that listens; else says so on the console and rests.
[[noreturn]] void machine_exit(int code);
// After a restart: nothing runs but the console, which repeats the report on any key.
inline constexpr int kExitSafeState = 3;
[[noreturn]] void safe_state();

}  // namespace bsp
}  // namespace pirvs
