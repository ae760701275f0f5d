// Registers of memory-mapped chips, 32 bits wide, in program order.
// In      Address (a multiple of 4) and value.
// Out     The value read. Accesses to one device are neither merged, dropped nor reordered.
// Errors  none; an address where nothing answers ends in a fault report (bare metal).
// Cost    One load or store to device memory: ~100 ns.
// Source  STYLE principle 3: bare metal reads memory, tests link emulated chips instead.
#pragma once

#include <cstdint>

namespace pirvs::bsp {

uint32_t mmio_read32(uintptr_t address);
void mmio_write32(uintptr_t address, uint32_t value);

}  // namespace pirvs::bsp
