// An emulated GICv3, its registers in memory, for tests of its driver: one distributor for 96
// interrupts, redistributors of four cores.
// In      The driver's accesses.
// Out     passes(): would the interrupt reach that core?
// Errors  An access beside the registers that the driver may use asserts; so does a setting of a
//         core's own interrupts while its redistributor sleeps.
// Source  gicv3_registers.h.
#pragma once

#include <cstdint>

#include "bsp/drivers/gicv3/gicv3_registers.h"

namespace pirvs::bsp::emulated {

class GicV3Chip {
 public:
  static constexpr int kCores = 4;
  static constexpr uint32_t kWords = 3;  // of 32 interrupts
  static constexpr uint32_t kInterrupts = 32 * kWords;
  static constexpr uint32_t kRedistributors = 0xa0000;  // as on QEMU's virt
  static constexpr uint32_t kSize = kRedistributors + kCores * gicv3::kRedistributorBytes;

  // Affinities as GICR_TYPER has them: Aff3 to Aff0.
  explicit GicV3Chip(const uint32_t (&affinities)[kCores]);

  uint32_t read(uint32_t offset);
  void write(uint32_t offset, uint32_t value);
  bool passes(uint32_t intid, int core) const;

  bool wakes_up = true;  // false: a redistributor that stays asleep

 private:
  struct Core {
    uint32_t affinity;
    uint32_t waker = 0x6;
    uint32_t enabled = 0xffffffff;  // what a firmware may have left
    uint32_t group = 0;
    uint32_t priority[8] = {};
  };
  uint32_t read_core(Core& core, uint32_t offset) const;
  void write_core(Core& core, uint32_t offset, uint32_t value) const;

  uint32_t control_ = 0;
  int writes_on_their_way_ = 0;
  uint32_t enabled_[kWords] = {0, 0xffffffff, 0xffffffff};
  uint32_t group_[kWords] = {};
  uint32_t priority_[kInterrupts / 4] = {};
  uint32_t route_[2 * kInterrupts] = {};
  Core cores_[kCores];
};

}  // namespace pirvs::bsp::emulated
