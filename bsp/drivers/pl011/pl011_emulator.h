// An emulated PL011 for tests of its driver.
// In      The driver's accesses. receive: a character from the outside. Each look at the flags lets
//         the line carry one character away.
// Out     sent(): what left on the line.
// Errors  A character written while the port is off or its FIFO full, or settings changed while it
//         is on: a bug of the driver, asserts.
// Source  pl011_registers.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/drivers/emulated/register_file.h"
#include "bsp/drivers/pl011/pl011_registers.h"
#include "core/base/text.h"
#include "core/store/ring.h"

namespace pirvs::bsp::emulated {

class Pl011Chip {
 public:
  static constexpr uint32_t kSize = 0x1000;
  static constexpr size_t kFifo = 32;

  uint32_t read(uint32_t offset);
  void write(uint32_t offset, uint32_t value);
  bool receive(char c) { return received_.push(c); }  // false: lost, the FIFO is full
  const char* sent() const { return sent_.c_str(); }

 private:
  bool is_on(uint32_t which) const;

  RegisterFile file_{pl011::kRegisters};
  Ring<char, kFifo> waiting_;
  Ring<char, kFifo> received_;
  Text<512> sent_;
};

}  // namespace pirvs::bsp::emulated
