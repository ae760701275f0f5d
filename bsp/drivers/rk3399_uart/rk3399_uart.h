// Driver of one UART of the RK3399. Its pins and clock must be on (bsp/drivers/rk3399_setup).
// In      The UART's base address and the rate of its clock (24 MHz unless a board changes it).
// Out     bsp/api/serial.h for this port; put(): one byte, waiting for room, for a console.
// Errors  As bsp/api/serial.h. The receiver holds 64 bytes: read at least that often, every 0.4 ms
//         at 1500000 baud.
// Cost    Two accesses a byte.
// Source  rk3399_uart_registers.h. 24 MHz / 16 / 1 = 1500000 baud, what U-Boot leaves on UART2.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/drivers/register.h"
#include "core/base/status.h"

namespace pirvs::bsp {

class Rk3399Uart {
 public:
  constexpr Rk3399Uart(uintptr_t base, uint32_t clock_hz) : registers_(base), clock_hz_(clock_hz) {}

  Status open(uint32_t baud) const;
  size_t write(const uint8_t* data, size_t size) const;
  Status read(uint8_t* data, size_t max, size_t& count) const;
  void put(uint8_t byte) const;

 private:
  Registers registers_;
  uint32_t clock_hz_;
};

}  // namespace pirvs::bsp
