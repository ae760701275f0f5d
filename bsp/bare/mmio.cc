#include "bsp/api/mmio.h"

namespace pirvs::bsp {

// Single instructions: a compiler may pick others for a volatile pointer, which an emulated machine
// cannot decode. Device memory (nGnRE) keeps them in order.
uint32_t mmio_read32(uintptr_t address) {
  uint32_t value;
  asm volatile("ldr %w0, [%1]" : "=r"(value) : "r"(address) : "memory");
  return value;
}

void mmio_write32(uintptr_t address, uint32_t value) {
  asm volatile("str %w0, [%1]" ::"r"(value), "r"(address) : "memory");
}

}  // namespace pirvs::bsp
