// What happens on a bug: a report on the console, then a restart of this image into a safe state.
// In      What is wrong; the registers of the code that it struck.
// Out     fault() does not come back: the report is kept, the other cores are switched off, and the
//         image starts again. kept_fault() then says so, until the power goes.
// Errors  A fault inside the report ends it at once. After kRestartsMax the machine stands still.
// Cost    The report: ~1 KiB on the console.
// Source  STYLE principle 7: a bug restarts into a safe mode.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/bare/exception.h"

namespace pirvs::bsp {

inline constexpr uint32_t kRestartsMax = 3;  // safe states that did not hold

struct KeptFault {
  uint32_t restarts;
  char report[2048];
};

[[noreturn]] void fault(const char* what, const ExceptionFrame& frame);
// The same without an exception: from the caller's place.
[[noreturn]] void fault_here(const char* what);

void fault_start(bool restarted);  // once at start, before others run
const KeptFault* kept_fault();     // nullptr: this start is the first

}  // namespace pirvs::bsp
