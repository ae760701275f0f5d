// Counts heap allocations: the linker wraps malloc, calloc and realloc with counting functions.
// Out     calls(): since the program began; calls_after_start(): since start_is_over(). Both from
//         any core.
// Errors  none. Memory that the kernel gives (mmap) is not counted.
// Cost    An addition a call.
// Source  make/linux.mk, --wrap.
#pragma once

#include <cstdint>

namespace pirvs::board::heap {

void start_is_over();
uint32_t calls();
uint32_t calls_after_start();

}  // namespace pirvs::board::heap
