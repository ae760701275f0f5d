// Driver of the Arm PL061 GPIO controller (QEMU's virt board): one bank of eight pins.
// In      The chip's base address, the number of its bank, where its edges go. handle_interrupt:
//         the time at which the handler began.
// Out     bsp/api/gpio.h for the pins of this bank.
// Errors  kNotFound: no such line. Two edges of one pin before the handler ran are one interrupt:
//         the edge reported is then the last one, by its level.
// Cost    One access per call, four per interrupt.
// Source  pl061_registers.h.
#pragma once

#include <cstdint>

#include "bsp/api/gpio.h"
#include "bsp/drivers/edge_queues.h"
#include "bsp/drivers/register.h"

namespace pirvs::bsp {

class Pl061 {
 public:
  static constexpr uint8_t kLines = 8;

  Pl061(uintptr_t base, uint8_t bank, EdgeQueues& edges)
      : registers_(base), bank_(bank), edges_(edges) {}

  Status direction(uint8_t line, PinDirection direction, bool level);
  Status write(uint8_t line, bool level);
  Result<bool> read(uint8_t line) const;
  Status watch(uint8_t line, EdgeKind kind);
  void handle_interrupt(TimeNs t);

 private:
  Registers registers_;
  uint8_t bank_;
  EdgeQueues& edges_;
};

}  // namespace pirvs::bsp
