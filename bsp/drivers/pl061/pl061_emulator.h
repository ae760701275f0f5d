// An emulated PL061 for tests of its driver.
// In      The driver's accesses; set_input: the level that the outside puts on a line.
// Out     interrupt(): the level of GPIOINTR. output(): the level of a line that is an output.
// Errors  See emulated/register_file.h.
// Source  pl061_registers.h.
#pragma once

#include <cstdint>

#include "bsp/drivers/emulated/register_file.h"
#include "bsp/drivers/pl061/pl061_registers.h"

namespace pirvs::bsp::emulated {

class Pl061Chip {
 public:
  static constexpr uint32_t kSize = 0x1000;

  uint32_t read(uint32_t offset);
  void write(uint32_t offset, uint32_t value);
  void set_input(int line, bool level);
  bool output(int line) const;
  bool interrupt() const { return masked() != 0; }

 private:
  uint32_t pins() const;
  uint32_t masked() const { return latched_ & file_.peek(pl061::kGPIOIE); }

  RegisterFile file_{pl061::kRegisters};
  uint32_t inputs_ = 0;
  uint32_t driven_ = 0;
  uint32_t latched_ = 0;
};

}  // namespace pirvs::bsp::emulated
