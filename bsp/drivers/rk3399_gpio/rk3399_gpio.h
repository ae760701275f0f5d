// Driver of one GPIO bank of the RK3399. Its pins must be given to it first
// (bsp/drivers/rk3399_setup).
// In      The bank's base address and number, where its edges go. handle_interrupt: the time at
//         which the handler began.
// Out     bsp/api/gpio.h for the pins of this bank.
// Errors  kNotFound: no such line.
// Cost    One or two accesses per call; per interrupt four, and two more for pins watched for both
//         edges.
// Source  rk3399_gpio_registers.h. The chip knows no "both edges": such a pin interrupts at the
//         level that it has not, and the handler turns the level around. No change that lasts until
//         the handler runs is lost that way, and a shorter one leaves no false edge.
#pragma once

#include <cstdint>

#include "bsp/api/gpio.h"
#include "bsp/drivers/edge_queues.h"
#include "bsp/drivers/register.h"

namespace pirvs::bsp {

class Rk3399Gpio {
 public:
  static constexpr uint8_t kLines = 32;

  Rk3399Gpio(uintptr_t base, uint8_t bank, EdgeQueues& edges)
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
  uint32_t both_ = 0;  // lines watched for both edges
};

// Port and number as on the schematics: GPIO4_C2 is bank 4, line rk3399_line('C', 2).
constexpr uint8_t rk3399_line(char port, int number) {
  return static_cast<uint8_t>((port - 'A') * 8 + number);
}

}  // namespace pirvs::bsp
