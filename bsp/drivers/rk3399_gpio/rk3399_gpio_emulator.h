// An emulated GPIO bank of the RK3399 for tests of its driver.
// In      The driver's accesses; set_input: the level that the outside puts on a line.
// Out     interrupt(): the level of the bank's interrupt. output(): the level of a driven line.
// Errors  See emulated/register_file.h.
// Source  rk3399_gpio_registers.h.
#pragma once

#include <cstdint>

#include "bsp/drivers/emulated/register_file.h"
#include "bsp/drivers/rk3399_gpio/rk3399_gpio_registers.h"

namespace pirvs::bsp::emulated {

class Rk3399GpioChip {
 public:
  static constexpr uint32_t kSize = 0x100;

  uint32_t read(uint32_t offset);
  void write(uint32_t offset, uint32_t value);
  void set_input(int line, bool level);
  bool output(int line) const;
  bool interrupt() const { return status() != 0; }

 private:
  uint32_t pins() const;
  uint32_t raw_status() const;
  uint32_t status() const { return raw_status() & ~file_.peek(rk3399_gpio::kINTMASK); }

  RegisterFile file_{rk3399_gpio::kRegisters};
  uint32_t inputs_ = 0;
  uint32_t latched_ = 0;
};

}  // namespace pirvs::bsp::emulated
