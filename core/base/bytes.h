// Fills and moves memory: memset, memcpy and memmove of the boards without an operating system,
// whose C library works byte by byte. Elsewhere the C library's own are faster: call those.
// In      Any address, any size; normal memory, not registers of devices. move_bytes may overlap.
// Cost    1 KiB filled or moved in about 100 instructions on AArch64.
// Source  Small sizes are done by two blocks that overlap, as in Arm's optimized-routines.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs {

void fill_bytes(void* to, uint8_t value, size_t size);
void move_bytes(void* to, const void* from, size_t size);

}  // namespace pirvs
