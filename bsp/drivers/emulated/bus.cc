#include "bsp/drivers/emulated/bus.h"

#include "bsp/api/mmio.h"
#include "core/base/assert.h"

namespace pirvs::bsp {
namespace emulated {
namespace {

Chip chips[kChipsMax];

bool overlap(const Chip& a, const Chip& b) {
  return a.base < b.base + b.size && b.base < a.base + a.size;
}

const Chip& chip_at(uintptr_t address) {
  PIRVS_ASSERT(address % 4 == 0);
  const Chip* found = nullptr;
  for (const Chip& chip : chips) {
    if (address >= chip.base && address - chip.base < chip.size) found = &chip;
  }
  PIRVS_ASSERT(found != nullptr);
  return *found;
}

}  // namespace

int Attachment::attach(const Chip& chip) {
  PIRVS_ASSERT(chip.size > 0);
  int free = -1;
  for (int slot = kChipsMax - 1; slot >= 0; --slot) {
    if (chips[slot].size == 0) free = slot;
    PIRVS_ASSERT(chips[slot].size == 0 || !overlap(chips[slot], chip));
  }
  PIRVS_ASSERT(free >= 0);
  chips[free] = chip;
  return free;
}

void Attachment::detach(int slot) { chips[slot] = Chip{}; }

}  // namespace emulated

uint32_t mmio_read32(uintptr_t address) {
  const emulated::Chip& chip = emulated::chip_at(address);
  return chip.read(chip.self, static_cast<uint32_t>(address - chip.base));
}

void mmio_write32(uintptr_t address, uint32_t value) {
  const emulated::Chip& chip = emulated::chip_at(address);
  chip.write(chip.self, static_cast<uint32_t>(address - chip.base), value);
}

}  // namespace pirvs::bsp
