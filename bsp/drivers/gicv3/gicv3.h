// Driver of Arm's generic interrupt controller, version 3: the part that is reached by memory
// (distributor and redistributors). The part in system registers is bsp/bare/interrupts.cc.
// In      Base addresses, how many redistributors there are; a core's affinity as MPIDR_EL1 has it.
// Out     start: affinity routing, group 1 on, every device's interrupt off. start_core: wakes the
//         core's redistributor; messages between cores (INTID 0 to 15) pass. enable: from then on
//         the interrupt passes; a device's (32 and on) to the core given, another on that core.
// Errors  start_core, enable: kNotFound, no redistributor has that affinity. start_core: kTimeout,
//         it does not wake.
// Cost    enable: ~5 accesses.
// Source  gicv3_registers.h.
#pragma once

#include "bsp/drivers/register.h"
#include "core/base/status.h"

namespace pirvs::bsp {

class GicV3 {
 public:
  constexpr GicV3(uintptr_t distributor, uintptr_t redistributors, int redistributor_count)
      : distributor_(distributor), redistributors_(redistributors), count_(redistributor_count) {}

  void start() const;
  Status start_core(uint64_t mpidr) const;
  Status enable(uint32_t intid, uint64_t mpidr) const;

 private:
  Result<uintptr_t> redistributor_of(uint64_t mpidr) const;
  void wait_for_writes() const;

  Registers distributor_;
  uintptr_t redistributors_;
  int count_;
};

}  // namespace pirvs::bsp
